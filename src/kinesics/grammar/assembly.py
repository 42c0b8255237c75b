"""From a reading (states and paths up to the mirror) to the motion graph with both sides of it, every frame accounted for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kinesics.grammar import reading as _reading
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, Source, State, Stay, build
from kinesics.grammar.moments import Moments
from kinesics.grammar.reading import Reading, Traversal


@dataclass(frozen=True)
class Recorded:
    """One of the recordings that were read together."""

    source: Source
    first: int
    """Its first moment among all."""
    moments: Moments
    """Its own moments."""

    def frame_of(self, moment: int) -> int:
        """Source frame of a moment counted among all recordings."""
        return self.moments.frame_of(moment - self.first)


def assemble(read: Reading, moments: Moments, name: str = "") -> MotionGraph:
    """The graph of one recording.

    A state seen on one side of the mirror only has no image in the graph (`MotionGraph.racemic` adds it). A visit in which
    the pose is held is a stay; the other frames belong to the paths, which begin and end at the moment nearest to the state.
    """
    source = Source(name, moments.source_frames, moments.source_fps)
    return assemble_many(read, moments, [Recorded(source, 0, moments)])


def assemble_many(read: Reading, moments: Moments, recordings: Sequence[Recorded]) -> MotionGraph:
    """The graph of several recordings read together (`reading.read` with breaks).

    Parameters
    ----------
    moments : of all recordings, one after the other.
    """
    sources = tuple(r.source for r in recordings)
    if len(read.visits) == 0:
        return MotionGraph((), (), sources)
    stays, occurrences = _timelines(read, moments, recordings)
    sides = {(v.state, v.mirrored) for v in read.visits}
    states = [
        State(
            id=_state_id(k, side),
            symmetric=state.symmetric,
            mirror_of=_state_id(k, not side) if not state.symmetric and {(k, False), (k, True)} <= sides else None,
            stays=tuple(stays.get((k, side), ())),
        )
        for k, state in enumerate(read.states)
        for side in (False, True)
        if (k, side) in sides
    ]
    return build(states, _paths(read, moments, occurrences), sources)


def _state_id(state: int, mirrored: bool) -> int:
    return 2 * state + mirrored


_Number = tuple[str, int]
"""Which traversal: ("way", its number), ("lead", visit) or ("tail", visit)."""


def _timelines(
    read: Reading, moments: Moments, recordings: Sequence[Recorded]
) -> tuple[dict[tuple[int, bool], list[Stay]], dict[_Number, Occurrence]]:
    """Stays by state and side; and the frames of each traversal, direction left open."""
    held = _reading.held(moments, read)
    stays: dict[tuple[int, bool], list[Stay]] = {}
    occurrences: dict[_Number, Occurrence] = {}
    borders = [*(r.first for r in recordings[1:]), moments.count]
    for number, (recording, end_moment) in enumerate(zip(recordings, borders, strict=True)):
        own = [k for k, v in enumerate(read.visits) if recording.first <= v.at < end_moment]
        frames = recording.source.frames
        at = 0
        if own and own[0] in read.leads:
            at = max(1, recording.frame_of(read.visits[own[0]].at))
            occurrences["lead", own[0]] = Occurrence(number, 0, at, complete=False)
        for k in own:
            visit, stretch = read.visits[k], held[k]
            low, high = stretch or (visit.at, visit.at)
            start, end = recording.frame_of(low), recording.frame_of(high)
            if k == own[0]:
                start = at
            if k == own[-1] and k not in read.tails:
                end = frames
            start, end = max(start, at), max(end, at)
            if k != own[0]:
                # a path has at least one frame, even where two states lie within one
                start = max(start, at + 1)
                occurrences["way", k - 1] = Occurrence(number, at, start)
                end = max(end, start)
            if end > start:
                stays.setdefault((visit.state, visit.mirrored), []).append(Stay(number, start, end))
            at = end
        if own and own[-1] in read.tails and at < frames:
            occurrences["tail", own[-1]] = Occurrence(number, at, frames, complete=False)
    return stays, occurrences


def _paths(read: Reading, moments: Moments, frames: Mapping[_Number, Occurrence]) -> list[Path]:
    out: list[Path] = []
    for k, path in enumerate(read.paths):
        ways: list[tuple[_Number, Traversal]] = [(("way", n), t) for n, t in enumerate(read.traversals)]
        ways += [(("lead", n), t) for n, t in read.leads.items()]
        ways += [(("tail", n), t) for n, t in read.tails.items()]
        taken = [(n, t) for n, t in ways if t.path == k and n in frames]
        # of all traversals, not of the first one: which one is first depends on the direction of time
        whole = [t for (kind, _), t in taken if kind == "way"] or [t for _, t in taken]
        mirror_cost, mirror_reverse_cost = _reading.self_symmetry(moments, [(t.start, t.end) for t in whole])
        ends_symmetric = read.states[path.from_[0]].symmetric and read.states[path.to[0]].symmetric
        symmetric = (
            path.symmetric if path.symmetric is not None else ends_symmetric and mirror_cost < read.nearness.path
        )
        crosses = path.from_[0] == path.to[0] and (ends_symmetric or path.from_[1] != path.to[1])
        # where the class of a cyclic movement tells the symmetries of its paths, this is none of them
        open_ = path.symmetric is None and not symmetric and crosses
        antipalindromic = open_ and mirror_reverse_cost < read.nearness.path
        sides: dict[bool, list[Occurrence]] = {}
        for n, t in taken:
            backwards = t.reversed != (antipalindromic and t.mirrored)
            side = t.mirrored and not (symmetric or antipalindromic)
            f = frames[n]
            sides.setdefault(side, []).append(Occurrence(f.source, f.start, f.end, backwards, f.complete))
        reversible = antipalindromic or len({o.reversed for side in sides.values() for o in side}) == 2
        for side, seen in sides.items():
            image = 2 * k + (not side) if len(sides) == 2 else None
            # seen in one direction only, that direction is the path's
            turned = not reversible and seen[0].reversed
            start, end = (path.to, path.from_) if turned else (path.from_, path.to)
            out.append(
                Path(
                    id=2 * k + side,
                    from_=_end_id(read, start, side),
                    to=_end_id(read, end, side),
                    reversible=reversible,
                    mirror_of=2 * k if antipalindromic else image,
                    symmetric=symmetric,
                    occurrences=tuple(
                        Occurrence(o.source, o.start, o.end, o.reversed and not turned, o.complete) for o in seen
                    ),
                )
            )
    return out


def _end_id(read: Reading, end: tuple[int, bool], mirrored: bool) -> int:
    """The state at the end of a path or of its mirror image."""
    state, side = end
    return _state_id(state, not read.states[state].symmetric and side != mirrored)
