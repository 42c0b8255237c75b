"""What is known of a performance, because it was made so.

Frames count from 0, ranges are [start, end). The words are those of an analysis: a mirrored stretch is an occurrence of the
path that `TruePath.mirror_of` names, a stretch played backwards is ``reversed``; stays and occurrences together cover every
frame exactly once. Nothing here was measured on the motion: it is what the score said before it was performed.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from kinesics.body.mirroring import mirror as mirror_motion
from kinesics.body.motion import Motion
from kinesics.body.motion import reverse as reverse_motion
from kinesics.body.pose import mirror as mirror_pose
from kinesics.vocabulary import FRIEZE_GROUPS, MovementClass

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Range:
    """Frames [start, end)."""

    start: int
    end: int

    def __len__(self) -> int:
        """How many frames."""
        return self.end - self.start

    def reverse(self, frame_count: int) -> Range:
        """The same stretch of the motion played backwards."""
        return Range(frame_count - self.end, frame_count - self.start)


@dataclass(frozen=True)
class TruePhrase:
    """A stretch of one kind of movement."""

    name: str
    start: int
    end: int
    class_: MovementClass
    period_s: float | None = None
    """Seconds of one cycle, on the average; None for what is done once."""
    cycles: tuple[int, ...] = ()
    """First frame of each cycle and, last, the first frame after the last full cycle."""
    tempo_exact: bool = True
    """False where the tempo wavers: the symmetries in time hold for the path through pose space, not for the clock."""

    @property
    def group(self) -> str | None:
        """The frieze group of a cyclic class."""
        return FRIEZE_GROUPS.get(self.class_)

    def reverse(self, frame_count: int) -> TruePhrase:
        """The phrase of the motion played backwards."""
        # a boundary is a first frame; played backwards, the first frame of the next cycle is the one before it
        cycles = tuple(frame_count - frame for frame in reversed(self.cycles))
        return dataclasses.replace(self, start=frame_count - self.end, end=frame_count - self.start, cycles=cycles)


@dataclass(frozen=True, eq=False)
class TrueState:
    """A node of the motion graph."""

    label: str
    """"A", its mirror image "A*", symmetric "X~"."""
    pose: Array = field(repr=False)
    """Unit quaternions of the 15 links, before noise and asymmetry, shape (15, 4)."""
    symmetric: bool
    mirror_of: str | None = None
    """The state that is its mirror image, where the graph has it; a symmetric state is its own."""
    stays: tuple[Range, ...] = ()
    """Where it is held. A state that is only passed has none."""

    def mirror(self) -> TrueState:
        """The state of the mirrored performance."""
        return dataclasses.replace(self, pose=mirror_pose(self.pose))


@dataclass(frozen=True)
class TrueOccurrence:
    """One traversal of a path."""

    start: int
    end: int
    reversed: bool = False
    """Traversed from the path's end to its start."""
    complete: bool = True
    """False where the performance began or ended on the way."""

    def __len__(self) -> int:
        """How many frames."""
        return self.end - self.start


@dataclass(frozen=True)
class TruePath:
    """An edge of the motion graph."""

    label: str
    """"ab_1", its mirror image "(ab_1)*", a symmetric path "xy~_1"."""
    from_: str
    to: str
    reversible: bool
    mirror_of: str | None = None
    """The path that is its mirror image, where the graph has it; a symmetric path is its own."""
    occurrences: tuple[TrueOccurrence, ...] = ()


@dataclass(frozen=True)
class Truth:
    """The known answers of one performance."""

    movement: str
    class_: MovementClass
    """Of the whole as one path."""
    period_s: float | None
    frame_count: int
    fps: float
    phrases: tuple[TruePhrase, ...]
    """They cover [0, frame_count) without gap or overlap."""
    states: tuple[TrueState, ...] = ()
    paths: tuple[TruePath, ...] = ()
    reversals: tuple[int, ...] = ()
    """Frames at which the movement turns back on its own path."""
    stillness: tuple[Range, ...] = ()
    """Where the pose does not change."""
    strikes: tuple[int, ...] = ()
    """Frames of impact: full speed, then stop and recoil (§3.6.3)."""
    notation: str = ""
    """The paths in the order of performance, "<" before one traversed backwards."""

    @property
    def cycles(self) -> tuple[int, ...]:
        """Cycle boundaries of the only phrase; empty where there are several."""
        return self.phrases[0].cycles if len(self.phrases) == 1 else ()

    def state(self, label: str) -> TrueState:
        """The state of that label.

        Raises
        ------
        KeyError
            If there is none.
        """
        return next((s for s in self.states if s.label == label), None) or _missing(
            label, [s.label for s in self.states]
        )

    def path(self, label: str) -> TruePath:
        """The path of that label.

        Raises
        ------
        KeyError
            If there is none.
        """
        return next((p for p in self.paths if p.label == label), None) or _missing(label, [p.label for p in self.paths])

    def mirror(self) -> Truth:
        """The truth of the mirrored performance: the same sentence, every pose reflected."""
        return dataclasses.replace(self, states=tuple(s.mirror() for s in self.states))

    def reverse(self) -> Truth:
        """The truth of the performance played backwards.

        A reversible path keeps its direction and its occurrences are turned round; a one-way path is itself turned round,
        for the reversed performance knows only the other direction. Strikes are lost: an impact played backwards is none.
        """
        n = self.frame_count

        def turned(path: TruePath) -> TruePath:
            occurrences = tuple(
                TrueOccurrence(n - o.end, n - o.start, o.reversed ^ path.reversible, o.complete)
                for o in reversed(path.occurrences)
            )
            ends = (path.from_, path.to) if path.reversible else (path.to, path.from_)
            return dataclasses.replace(path, from_=ends[0], to=ends[1], occurrences=occurrences)

        paths = tuple(turned(p) for p in self.paths)
        return dataclasses.replace(
            self,
            phrases=tuple(p.reverse(n) for p in reversed(self.phrases)),
            states=tuple(
                dataclasses.replace(s, stays=tuple(r.reverse(n) for r in reversed(s.stays))) for s in self.states
            ),
            paths=paths,
            reversals=tuple(n - 1 - f for f in reversed(self.reversals)),
            stillness=tuple(r.reverse(n) for r in reversed(self.stillness)),
            strikes=(),
            notation=notation_of(paths),
        )


def notation_of(paths: tuple[TruePath, ...]) -> str:
    """Complete occurrences in the order of time as labels separated by spaces, "<" before one traversed backwards."""
    order = sorted((o.start, "<" * o.reversed + p.label) for p in paths for o in p.occurrences if o.complete)
    return " ".join(label for _, label in order)


def _missing(label: str, known: list[str]) -> NoReturn:
    raise KeyError(f"Nothing is labelled '{label}'. Labels: {', '.join(known)}.")


@dataclass(frozen=True, eq=False)
class Performance:
    """A motion and what is known of it."""

    motion: Motion
    truth: Truth

    def mirror(self) -> Performance:
        """The performance in the mirror x = 0."""
        return Performance(mirror_motion(self.motion), self.truth.mirror())

    def reverse(self) -> Performance:
        """The performance played backwards."""
        return Performance(reverse_motion(self.motion), self.truth.reverse())
