"""What a label of the side file, or a frame in its place, speaks of: always in the graph without the edits."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Final, TypeVar

from kinesics.errors import InputError
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, State

T = TypeVar("T")
Traversed = tuple[Path, Occurrence]

NEAR: Final = 1.0
"""Seconds: a frame farther than this from every visit of a state names none of them."""
_FRAME: Final = re.compile(r"(.*)@(\d+)", re.DOTALL)
"""A frame of a recording in the place of a label."""


def traversed(paths: Iterable[Path], source: int) -> list[Traversed]:
    """Path and occurrence of each step of a source in the order of time; without stays: they are at the boundaries."""
    return sorted(((p, o) for p in paths for o in p.occurrences if o.source == source), key=lambda step: step[1].start)


def boundaries(steps: Sequence[Traversed]) -> list[tuple[int, float]]:
    """Boundaries between traversals, each with its middle frame: boundary k lies before step k, boundary k + 1 after it."""
    out = []
    for k in range(len(steps) + 1):
        before = steps[k - 1][1] if k else None
        after = steps[k][1] if k < len(steps) else None
        start = before.end if before else 0
        end = after.start if after else start
        cut = (before is not None and not before.complete and k == len(steps)) or (
            after is not None and not after.complete and k == 0
        )
        if not cut:
            out.append((k, 0.5 * (start + end)))
    return out


def state_at(steps: Sequence[Traversed], k: int) -> int | None:
    """Id of the state at boundary k; None where nothing is traversed."""
    if not steps:
        return None
    at_start = k < len(steps)
    path, occurrence = steps[k] if at_start else steps[k - 1]
    return path.from_ if at_start != occurrence.reversed else path.to


class Labels:
    """Looks up in one graph what its labels mean."""

    def __init__(self, graph: MotionGraph) -> None:
        self.graph = graph

    def source(self, which: int | str) -> int:
        """The number of a recording, given that or its name.

        Raises
        ------
        InputError
            If there is none, or several have the name.
        """
        sources = self.graph.sources
        if isinstance(which, str):
            numbers = [k for k, s in enumerate(sources) if s.name == which]
            if len(numbers) != 1:
                known = ", ".join(f"'{s.name}'" for s in sources)
                why = "no recording is" if not numbers else "several recordings are: give its number, from 0, instead"
                raise InputError(f"The edits speak of a recording '{which}'; {why}. Recordings: {known}.")
            return numbers[0]
        self.graph.timeline(which)  # refuses a source that does not exist
        return which

    def state(self, label: str) -> State:
        """The state of that label, or the one held at that frame or visited nearest to it.

        Raises
        ------
        InputError
            If there is none.
        """
        at = self._at(label)
        if at is None:
            return self._known(self.graph.state, label)
        source, frame = at
        held = [s for s in self.graph.states for r in s.stays if r.source == source and r.start <= frame < r.end]
        if held:
            return held[0]
        steps = traversed(self.graph.paths, source)
        states = [(abs(middle - frame), state_at(steps, k)) for k, middle in boundaries(steps)]
        nearest = min(((apart, s) for apart, s in states if s is not None), default=None)
        if nearest is None:
            raise InputError(f"No state is visited in source {source}: '{label}' speaks of none.")
        return self.graph.state(nearest[1])

    def path(self, label: str) -> Path:
        """The path of that label, or the one traversed at that frame.

        Raises
        ------
        InputError
            If there is none.
        """
        at = self._at(label)
        if at is None:
            return self._known(self.graph.path, label)
        source, frame = at
        for path, occurrence in traversed(self.graph.paths, source):
            if occurrence.start <= frame < occurrence.end:
                return path
        raise InputError(f"No path is traversed at frame {frame} of source {source}: a state is held there.")

    def visits(self, state: State, source: int) -> list[tuple[int, float]]:
        """The boundaries at which a state is visited in a source, each with its middle frame.

        Raises
        ------
        InputError
            If it never is.
        """
        steps = traversed(self.graph.paths, source)
        visits = [(k, frame) for k, frame in boundaries(steps) if state_at(steps, k) == state.id]
        if not visits:
            raise InputError(f"State '{state.label}' is not visited in source {source}: it cannot be split there.")
        return visits

    def visit_near(self, frame: int, state: State, source: int) -> int:
        """The boundary at which a state is visited nearest to a frame.

        Raises
        ------
        InputError
            If none is within `NEAR`.
        """
        visits = self.visits(state, source)
        steps = traversed(self.graph.paths, source)
        place, _ = min(visits, key=lambda visit: abs(visit[1] - frame))
        low = steps[place - 1][1].end if place else 0
        high = steps[place][1].start if place < len(steps) else self.graph.sources[source].frames
        if max(low - frame, frame - high) > NEAR * self.graph.sources[source].fps:
            seen = ", ".join(f"{middle:.0f}" for _, middle in visits[:20])
            raise InputError(
                f"State '{state.label}' is not visited within {NEAR:g} s of frame {frame} of source {source}; it is at {seen}"
                f"{', …' if len(visits) > 20 else ''}."
            )
        return place

    def _at(self, label: str) -> tuple[int, int] | None:
        """Source and frame, where a frame stands in the place of a label."""
        found = _FRAME.fullmatch(label)
        if found is None:
            return None
        named = found.group(1)
        source = self.source(int(named) if named.isdecimal() else named or 0)
        frame, frames = int(found.group(2)), self.graph.sources[source].frames
        if frame >= frames:
            raise InputError(f"The edits speak of frame {frame} of source {source}, which has {frames} frames.")
        return source, frame

    def _known(self, find: Callable[[str], T], label: str) -> T:
        try:
            return find(label)
        except InputError as error:
            raise InputError(
                f"{error} Labels may change with the choice of recordings and with weights; a frame in their place, "
                'such as "@812", does not.'
            ) from None
