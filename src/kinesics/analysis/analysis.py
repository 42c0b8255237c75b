"""From motions to an `Analysis`."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.analysis import judgement
from kinesics.analysis import stillness as _stillness
from kinesics.analysis import symmetric_states as _symmetric
from kinesics.analysis.facts import Facts, Gap, Range, Source, Speed, source_names
from kinesics.analysis.serial import decode, encode
from kinesics.body import anatomy, quality
from kinesics.body.motion import Motion
from kinesics.body.pose import PoseSequence, check_alike, poses
from kinesics.errors import InputError
from kinesics.grammar import many
from kinesics.grammar import moments as _moments
from kinesics.grammar.edits import Edits
from kinesics.grammar.graph import MotionGraph
from kinesics.grammar.whole import Grammar, part, read_grammar
from kinesics.progress import Progress, silent
from kinesics.similarity import BETA_RULE, Weights, check_weights, default_beta, speed, symmetry_residual

Array = NDArray[np.float64]

SCHEMA_VERSION: Final = 1
"""Of `analysis.json`: raised when something that stood there changes its meaning."""


@dataclass(frozen=True)
class Analysis(Facts):
    """The facts of a recording, and what they were found in.

    Two analyses are equal when their facts are: the motions and the curves are not compared.
    """

    motions: tuple[Motion, ...] = dataclasses.field(default=(), compare=False, repr=False)
    """One for each source; empty for an analysis read back from a folder."""
    poses: tuple[PoseSequence, ...] = dataclasses.field(default=(), compare=False, repr=False)
    speed_curves: tuple[Array, ...] = dataclasses.field(default=(), compare=False, repr=False)
    """√(2D)/Δt, 1/s, shape (frames,), for each source: entry i is the step from frame i − 1 to i, entry 0 repeats entry 1."""
    mirror_distance_curves: tuple[Array, ...] = dataclasses.field(default=(), compare=False, repr=False)
    """D*(a, a) of each frame, shape (frames,), for each source: 0 is symmetric (§2.14)."""

    grammars: tuple[Grammar, ...] = dataclasses.field(default=(), compare=False, repr=False)
    """What the grammar read, one for each source; empty for an analysis read back from a folder."""

    def to_dict(self) -> dict[str, Any]:
        """The facts as plain JSON values: what stands in `analysis.json`."""
        return {f.name.rstrip("_"): encode(getattr(self, f.name)) for f in dataclasses.fields(Facts)}

    @classmethod
    def from_dict(
        cls,
        values: Mapping[str, Any],
        *,
        speed_curves: Sequence[Array] = (),
        mirror_distance_curves: Sequence[Array] = (),
    ) -> Analysis:
        """The analysis with these facts.

        Raises
        ------
        InputError
            If a key is missing, a value has the wrong type, or the schema is of a later version.
        """
        version = values.get("schema_version")
        if version != SCHEMA_VERSION:
            raise InputError(
                f"Expected schema_version {SCHEMA_VERSION}, got {version}: the analysis was made by another version of "
                "kinesics; analyse the recording again."
            )
        facts = decode(Facts, dict(values))
        return cls(
            **{f.name: getattr(facts, f.name) for f in dataclasses.fields(Facts)},
            speed_curves=tuple(speed_curves),
            mirror_distance_curves=tuple(mirror_distance_curves),
        )


def analyze(
    motion: Motion | Sequence[Motion],
    *,
    beta: float | None = None,
    weights: Weights | None = None,
    mapping: Mapping[str, object] | None = None,
    edits: Edits | None = None,
    progress: Progress | None = None,
) -> Analysis:
    """What a recording is, or several recordings that belong together.

    Parameters
    ----------
    motion : one, or several; each becomes a source, and frames are counted within their source.
    beta : sensitivity of Z = exp(−β D) (§3.1); without, `kinesics.similarity.default_beta` of all poses together. No fact
        depends on it, only the pictures.
    weights : of the 15 links in D, left and right equal (see `kinesics.similarity.distance`); equal without.
    mapping : joint names by the user (see `kinesics.body.anatomy.resolve`).
    edits : names, merges and splits of phrases, states and paths (see `kinesics.grammar.edits`).
    progress : called with a fraction now and then; may raise to stop.

    Raises
    ------
    SkeletonError
        If a skeleton cannot be understood as a human body.
    InputError
        If there is no motion, β is not above 0, the weights are not 15 numbers that suit D*, the edits speak of what is not
        there, or one body has the clavicle composed and another has it dropped.
    """
    from kinesics import __version__

    report = progress or silent
    motions = _motions(motion)
    if beta is not None and not (np.isfinite(beta) and beta > 0.0):
        raise InputError(f"Expected β above 0, got {beta}.")
    link_weights = check_weights(weights)

    understood: list[Motion] = []
    sequences: list[PoseSequence] = []
    for number, each in enumerate(motions):
        report(0.05 + 0.3 * number / len(motions), f"poses of {each.name or 'the motion'}")
        understood.append(anatomy.understood(each, mapping))
        sequences.append(poses(understood[-1]))
    check_alike(sequences, [_name(m) or f"motion {k + 1}" for k, m in enumerate(motions)])
    speeds = tuple(speed(p, weights=link_weights) for p in sequences)
    reflected = tuple(symmetry_residual(p, link_weights) for p in sequences)

    report(0.35, "stillness and symmetry")
    rules = [_stillness.stillness_rule(p, link_weights) for p in sequences]
    still = [_stillness.find_stillness(p, r, link_weights) for p, r in zip(sequences, rules, strict=True)]
    symmetric = [_symmetric.find_symmetric_states(d) for d in reflected]

    grammars: list[Grammar] = []
    share = 0.5 if len(motions) == 1 else 0.25 / len(motions)
    for number, (each, sequence) in enumerate(zip(understood, sequences, strict=True)):
        grammars.append(
            read_grammar(
                sequence,
                name=_name(each),
                weights=link_weights,
                edits=edits,
                source=number,
                with_graph=len(motions) == 1,
                progress=part(report, 0.45 + share * number, 0.45 + share * (number + 1)),
            )
        )

    grammars = list(many.match_kinds(grammars))

    doubts = [quality.inspect(m) for m in understood]
    sources = tuple(_source(*parts) for parts in zip(understood, sequences, doubts, grammars, strict=True))
    phrases = [
        judgement.phrases(number, grammar, curve, sequence.fps)
        for number, (grammar, curve, sequence) in enumerate(zip(grammars, speeds, sequences, strict=True))
    ]
    first_motifs = np.cumsum([0, *(len(g.motifs) for g in grammars)])
    numbered = list(enumerate(grammars))
    firsts = np.cumsum([0, *(len(p) for p in phrases)])
    graph = grammars[0].graph
    if len(sources) > 1:
        names = [s.name or f"motion {k + 1}" for k, s in enumerate(sources)]
        graph = many.read_graph(
            sequences, names, weights=link_weights, grammars=grammars, progress=part(report, 0.7, 0.95)
        )
    graph = graph or MotionGraph()
    report(0.95, "β")
    contrast = float(beta) if beta is not None else default_beta(joined(sequences), link_weights)
    parameters = {
        "beta_rule": BETA_RULE if beta is None else "given by the caller",
        "weights": [float(w) for w in link_weights],
        "mapping": None if mapping is None else encode(mapping),
        "stillness": {
            "sway_degrees": _stillness.SWAY_DEGREES,
            "jitters": _stillness.JITTERS,
            "turns": _stillness.TURNS,
            "reach_quantile": _stillness.REACH_QUANTILE,
            "sources": [encode(r) for r in rules],
        },
        "symmetric_states": {"threshold": _symmetric.SYMMETRY_THRESHOLD, "release": _symmetric.RELEASE},
        "grammar": {
            "most_moments_a_second": _moments.RATE,
            "sources": [{"moments_a_second": g.moments.fps, "noise": float(g.moments.noise)} for g in grammars],
        },
    }
    report(1.0, "done")
    return Analysis(
        schema_version=SCHEMA_VERSION,
        kinesics_version=__version__,
        parameters=parameters,
        beta=contrast,
        sources=sources,
        overall=judgement.of_several(sources),
        phrases=tuple(p for each in phrases for p in each),
        motifs=tuple(m for k, g in numbered for m in judgement.motifs(k, g, int(first_motifs[k]))),
        state_repetitions=tuple(r for k, g in numbered for r in judgement.state_repetitions(k, g)),
        reversals=tuple(r for k, g in numbered for r in judgement.reversals(k, g)),
        strikes=tuple(s for k, g in numbered for s in judgement.strikes(k, g)),
        cycles=tuple(c for g, first in zip(grammars, firsts, strict=False) for c in judgement.cycles(g, int(first))),
        graph=graph if edits is None else edits.apply(graph),
        stillness=_ranges(still),
        symmetric_states=_ranges(symmetric),
        gaps=tuple(gap for k, q in enumerate(doubts) for gap in _gaps(k, q)),
        speed=summarize_speed(speeds, [p.fps for p in sequences]),
        warnings=_warnings(sources, [g.remarks for g in grammars]),
        motions=tuple(understood),
        poses=tuple(sequences),
        speed_curves=speeds,
        mirror_distance_curves=reflected,
        grammars=tuple(grammars),
    )


def summarize_speed(speeds: Sequence[Array], fps: Sequence[float]) -> Speed:
    """Mean, median and greatest speed over all sources, each step counted by its duration; all None where nothing moves.

    Parameters
    ----------
    speeds : √(2D)/Δt of the step to each frame, 1/s, shape (frames,) for each source; the first entry stands for no step.
    fps : of each source.
    """
    steps = [s[1:] for s in speeds]
    counted = [(s, 1.0 / f) for s, f in zip(steps, fps, strict=True) if len(s)]
    if not counted:
        return Speed()
    values = np.concatenate([s for s, _ in counted])
    seconds = np.concatenate([np.full(len(s), step) for s, step in counted])
    order = np.argsort(values, kind="stable")
    passed = np.cumsum(seconds[order])
    source = max(range(len(steps)), key=lambda k: float(steps[k].max()) if len(steps[k]) else -1.0)
    frame = 1 + int(np.argmax(steps[source]))
    return Speed(
        mean=float(np.average(values, weights=seconds)),
        median=float(values[order][np.searchsorted(passed, 0.5 * passed[-1])]),
        max=float(speeds[source][frame]),
        max_source=source,
        max_frame=frame,
        max_s=frame / fps[source],
    )


def joined(sequences: Sequence[PoseSequence]) -> PoseSequence:
    """All poses one after another, at the frame rate of the first."""
    if len(sequences) == 1:
        return sequences[0]
    return PoseSequence(
        quaternions=np.concatenate([p.quaternions for p in sequences]),
        yaw=np.concatenate([p.yaw for p in sequences]),
        ground=np.concatenate([p.ground for p in sequences]),
        fps=sequences[0].fps,
    )


def _motions(motion: Motion | Sequence[Motion]) -> list[Motion]:
    motions = [motion] if isinstance(motion, Motion) else list(motion)
    if not motions:
        raise InputError("Expected a motion, or several; got none.")
    for each in motions:
        if not isinstance(each, Motion):
            raise InputError(f"Expected a Motion, got {type(each).__name__}; `kinesics.read` makes one of a file.")
    return motions


def _name(motion: Motion) -> str:
    """Without folders: their names are nobody's business but the user's."""
    return re.split(r"[/\\]", motion.source.file_name or motion.name)[-1]


def _source(motion: Motion, sequence: PoseSequence, doubts: quality.Quality, grammar: Grammar) -> Source:
    origin = motion.source
    return Source(
        name=_name(motion),
        sha256=origin.sha256,
        format=origin.format,
        skeleton=sequence.profile,
        fps=motion.fps,
        frames=motion.frame_count,
        duration_s=motion.duration,
        joints=motion.skeleton.joint_count,
        assumptions=tuple(dict.fromkeys((*motion.assumptions, *sequence.assumptions))),
        warnings=tuple(dict.fromkeys((*motion.warnings, *doubts.sentences))),
        overall=judgement.overall(grammar.overall),
    )


def _warnings(sources: Sequence[Source], remarks: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """What looks wrong with each recording and what its grammar remarks; named where there are several."""
    said = [
        (name, each)
        for name, source, own in zip(source_names(sources), sources, remarks, strict=True)
        for each in (*source.warnings, *own)
    ]
    return tuple(dict.fromkeys(each if len(sources) == 1 else f"{name}: {each}" for name, each in said))


def _gaps(source: int, doubts: quality.Quality) -> list[Gap]:
    """Where frames are missing or do not belong: the whole body leaps, or the first or last frame stands apart."""
    lost = sorted(doubts.of_kind("gap"), key=lambda f: (f.start, f.end))
    return [Gap(source, f.start, f.end, f.sentence) for f in lost]


def _ranges(per_source: Sequence[Sequence[tuple[int, int]]]) -> tuple[Range, ...]:
    return tuple(Range(k, a, b) for k, ranges in enumerate(per_source) for a, b in ranges)
