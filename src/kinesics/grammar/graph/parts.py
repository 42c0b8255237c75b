"""What a motion graph is made of: recordings, states, paths, and where in the recordings each is seen."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kinesics.errors import InputError

if TYPE_CHECKING:
    from kinesics.grammar.graph.motion_graph import MotionGraph


@dataclass(frozen=True)
class Source:
    """A recording that the graph was read from."""

    name: str
    frames: int
    fps: float

    def __post_init__(self) -> None:
        if self.frames < 1 or not 0.0 < self.fps < float("inf"):
            raise InputError(
                f"Expected a source of at least one frame and a positive frame rate, got '{self.name}' with "
                f"{self.frames} frames at {self.fps} fps."
            )


@dataclass(frozen=True)
class Stay:
    """Frames [start, end) of a source in which a state is held."""

    source: int
    start: int
    end: int


@dataclass(frozen=True)
class Occurrence:
    """One traversal of a path: frames [start, end) of a source."""

    source: int
    start: int
    end: int
    reversed: bool = False
    """Traversed from the path's end to its start."""
    complete: bool = True
    """False where the recording begins or ends on the way: only the first and the last step of a source can be so."""


@dataclass(frozen=True)
class State:
    """A node: a pose that is repeated, held, turned back in or branched from."""

    id: int
    label: str = ""
    symmetric: bool = False
    mirror_of: int | None = None
    """Id of the state that is its mirror image; None for a symmetric state, and where the graph has none."""
    stays: tuple[Stay, ...] = ()


@dataclass(frozen=True)
class Path:
    """An edge: the movement from one state to another."""

    id: int
    label: str = ""
    from_: int = 0
    to: int = 0
    index: int = 0
    """1, 2, … of the distinct paths between the same states (§3.6.2); mirror images share it."""
    reversible: bool = False
    mirror_of: int | None = None
    """Id of the path that is its mirror image; its own id where it is that played backwards; None for a symmetric path."""
    inferred: bool = False
    """Never seen: known by racemisation only (§3.6.2)."""
    occurrences: tuple[Occurrence, ...] = ()
    symmetric: bool = False
    """Symmetric throughout, so that its label carries a bar."""

    @property
    def antipalindromic(self) -> bool:
        """Its mirror image is itself played backwards."""
        return self.mirror_of == self.id

    def turned(self) -> Path:
        """The same path, named in the other direction."""
        occurrences = tuple(dataclasses.replace(o, reversed=not o.reversed) for o in self.occurrences)
        return dataclasses.replace(self, from_=self.to, to=self.from_, occurrences=occurrences)


@dataclass(frozen=True)
class Step:
    """One step of a timeline: a stay (``state``) or a traversal (``path``)."""

    source: int
    start: int
    end: int
    state: int | None = None
    path: int | None = None
    reversed: bool = False
    complete: bool = True


def steps_of(graph: MotionGraph) -> Iterator[Step]:
    """All stays and traversals of all sources, in no order of time."""
    for state in graph.states:
        for stay in state.stays:
            yield Step(stay.source, stay.start, stay.end, state=state.id)
    for path in graph.paths:
        for o in path.occurrences:
            yield Step(o.source, o.start, o.end, path=path.id, reversed=o.reversed, complete=o.complete)


def ends_of(graph: MotionGraph, step: Step) -> tuple[int, int]:
    """Ids of the states in which a step begins and ends."""
    if step.path is None:
        assert step.state is not None
        return step.state, step.state
    path = graph.path(step.path)
    return (path.to, path.from_) if step.reversed else (path.from_, path.to)
