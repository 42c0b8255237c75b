"""The facts of a recording, as `analysis.json` has them (CONVENTIONS.md): frozen dataclasses and nothing else,
save the motion graph, which is what the grammar makes it.

Frames count from 0, ranges are [start, end), times are seconds. What is not known is None or empty, never absent. A trailing
underscore (``class_``, ``from_``) stands for a name that Python keeps for itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from kinesics.grammar.graph import MotionGraph


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
    """The symmetry class of the whole, as one path; all None where there is nothing to judge, or no single path."""

    class_: str | None = None
    """None where it cannot be told; ``reasons`` say why."""
    group: str | None = None
    """Frieze group of a cyclic class."""
    period_s: float | None = None
    confidence: float | None = None
    """Probability that the class is right; 0 where it cannot be told."""
    runner_up: str | None = None
    residuals: Residuals = field(default_factory=Residuals)
    """Without the constant difference of left and right."""
    repeats: float | None = None
    """How many periods long the movement is."""
    bias_degrees: Mapping[str, float] = field(default_factory=dict)
    """Degrees, all the time: of limbs, by their name without side, the difference of left and right; of axial links how far each
    leans or is turned to one side."""
    bias_kept: tuple[str, ...] = ()
    """Those of them that are a posture, or have no average, and stay with the movement."""
    lean_degrees: Mapping[str, float] = field(default_factory=dict)
    """What the axial links add up to: how far the chest leans or is turned to one side against the pelvis ("trunk"), the head
    against the chest ("head"); without those of which a link is kept."""
    bias_largest_degrees: float | None = None
    """The largest of ``bias_degrees`` that was set aside before judging."""
    reasons: tuple[str, ...] = ()
    """What decided, what was assumed, why it cannot be told."""


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
    overall: Overall = field(default_factory=Overall)
    """The symmetry class of this recording, as one path."""


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
    """Of √(2D)/Δt, 1/s."""
    smoothness: float | None = None
    """Spectral arc length of the speed curve, negative: the nearer to 0 the smoother (`kinesics.grammar.smoothness`)."""
    log_dimensionless_jerk: float | None = None
    """Likewise, by jerk."""
    kind: int | None = None
    """The same number for phrases of the same kind of movement, in all recordings, in order of appearance."""
    mirrored: bool = False
    """It is like the first phrase of its kind as that is seen in a mirror, and not as it is."""
    repeats: float | None = None
    """How many periods long it is."""
    bias_largest_degrees: float | None = None
    """The largest constant difference of limbs, or lean of an axial link, that was set aside before judging."""
    reasons: tuple[str, ...] = ()
    name: str | None = None
    """Given by a person in a side file of edits."""


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
    """Its place in the list of phrases."""
    start: int
    end: int
    period_s: float
    phase: float | None
    """Left minus right, as a fraction of the cycle, less the half by which alternating sides are apart; None where the sides
    do different things."""
    mirror_residual: float | None
    """What the mirror leaves over at that phase, relative to the range of the movement."""


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
    graph: MotionGraph = field(default_factory=MotionGraph)
    """Without states where none was read; in JSON with its notation and its information."""
    warnings: tuple[str, ...] = ()
    """What looks wrong with the recording or makes the analysis doubtful, of all sources together; where there are several each
    begins with the name of its recording (`source_names`)."""


def source_names(sources: Sequence[Source]) -> tuple[str, ...]:
    """What each recording is called; those of one name are numbered."""
    names = [s.name or "a motion made by the program" for s in sources]
    return tuple(
        f"{name} ({names[: number + 1].count(name)})" if names.count(name) > 1 else name
        for number, name in enumerate(names)
    )
