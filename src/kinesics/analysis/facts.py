"""The facts of a recording, as `analysis.json` has them (CONVENTIONS.md): frozen dataclasses and nothing else.

Frames count from 0, ranges are [start, end), times are seconds. What is not known is None or empty, never absent. A trailing
underscore (``class_``, ``from_``) stands for a name that Python keeps for itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Source:
    """A recording that went in."""

    name: str
    """File name without folders; "" for a motion made by the program."""
    sha256: str
    """Of the file's bytes; "" where there is no file."""
    format: str
    skeleton: str
    """How the skeleton was mapped onto the 15 links."""
    fps: float
    frames: int
    duration_s: float
    joints: int
    """Joints of the file's skeleton."""
    assumptions: tuple[str, ...] = ()
    """What the file did not say and was assumed."""
    warnings: tuple[str, ...] = ()
    """What looks wrong."""


@dataclass(frozen=True)
class Residuals:
    """How far the movement is from each symmetry, relative to its own range; None where it was not measured."""

    period: float | None = None
    mirror: float | None = None
    glide: float | None = None
    reverse: float | None = None
    mirror_reverse: float | None = None


@dataclass(frozen=True)
class Overall:
    """The symmetry class of the whole, as one path."""

    class_: str | None = None
    group: str | None = None
    period_s: float | None = None
    confidence: float | None = None
    runner_up: str | None = None
    residuals: Residuals = field(default_factory=Residuals)


@dataclass(frozen=True)
class Phrase:
    """A stretch of one kind of movement."""

    source: int
    start: int
    end: int
    start_s: float
    end_s: float
    class_: str | None = None
    group: str | None = None
    period_s: float | None = None
    confidence: float | None = None
    runner_up: str | None = None
    residuals: Residuals = field(default_factory=Residuals)
    speed_mean: float | None = None
    smoothness: float | None = None


@dataclass(frozen=True)
class MotifMember:
    """One occurrence of a motif."""

    source: int
    start: int
    end: int
    reversed: bool
    mirrored: bool
    path: tuple[tuple[int, int], ...] = ()
    """Pairs of frames (this member's, the first member's)."""


@dataclass(frozen=True)
class Motif:
    """A stretch that recurs under a relation: a set of members, not all pairs."""

    id: int
    relation: str
    similarity: float
    members: tuple[MotifMember, ...] = ()


@dataclass(frozen=True)
class StateRepetition:
    """Moments at which the same pose, or its mirror image, returns."""

    source: int
    frames: tuple[int, ...]
    mirrored: bool


@dataclass(frozen=True)
class Range:
    """Frames [start, end) of one source."""

    source: int
    start: int
    end: int


@dataclass(frozen=True)
class Gap:
    """Frames [start, end) of one source that tell nothing."""

    source: int
    start: int
    end: int
    reason: str


@dataclass(frozen=True)
class Reversal:
    """A moment at which the movement turns back on its own path."""

    source: int
    frame: int


@dataclass(frozen=True)
class Strike:
    """A moment of abrupt stop or turn."""

    source: int
    frame: int
    time_s: float
    speed: float


@dataclass(frozen=True)
class Cycle:
    """One repetition within a cyclic phrase."""

    phrase: int
    start: int
    end: int
    period_s: float
    phase: float | None
    mirror_residual: float | None


@dataclass(frozen=True)
class Speed:
    """The rate of change of the pose √(2D)/Δt, in 1/s, over all steps of all sources."""

    mean: float | None = None
    median: float | None = None
    max: float | None = None
    max_source: int | None = None
    max_frame: int | None = None
    """The step from the frame before to this one is the fastest."""
    max_s: float | None = None


@dataclass(frozen=True)
class State:
    """A node of the motion graph."""

    id: int
    label: str
    symmetric: bool
    mirror_of: int | None = None
    stays: tuple[Range, ...] = ()


@dataclass(frozen=True)
class Occurrence:
    """One traversal of a path."""

    source: int
    start: int
    end: int
    reversed: bool


@dataclass(frozen=True)
class Path:
    """An edge of the motion graph."""

    id: int
    label: str
    from_: int
    to: int
    index: int
    reversible: bool
    mirror_of: int | None = None
    inferred: bool = False
    occurrences: tuple[Occurrence, ...] = ()


@dataclass(frozen=True)
class Estimate:
    """A number and its standard error."""

    value: float
    standard_error: float


@dataclass(frozen=True)
class Information:
    """How much a traversal of the graph tells."""

    order0_bits: Estimate | None = None
    order1_bits: Estimate | None = None
    bits_per_s: Estimate | None = None


@dataclass(frozen=True)
class Graph:
    """The motion graph."""

    states: tuple[State, ...] = ()
    paths: tuple[Path, ...] = ()
    notation: str = ""
    information: Information = field(default_factory=Information)


@dataclass(frozen=True)
class Facts:
    """All of `analysis.json`."""

    schema_version: int
    kinesics_version: str
    parameters: Mapping[str, Any]
    """What is needed to do it again: rules, weights, thresholds and where they come from."""
    beta: float
    sources: tuple[Source, ...]
    overall: Overall = field(default_factory=Overall)
    phrases: tuple[Phrase, ...] = ()
    motifs: tuple[Motif, ...] = ()
    state_repetitions: tuple[StateRepetition, ...] = ()
    stillness: tuple[Range, ...] = ()
    symmetric_states: tuple[Range, ...] = ()
    reversals: tuple[Reversal, ...] = ()
    strikes: tuple[Strike, ...] = ()
    cycles: tuple[Cycle, ...] = ()
    gaps: tuple[Gap, ...] = ()
    speed: Speed = field(default_factory=Speed)
    graph: Graph = field(default_factory=Graph)
    warnings: tuple[str, ...] = ()
    """What looks wrong with the recording or makes the analysis doubtful, of all sources together."""
