"""What the grammar read, as facts: from `kinesics.grammar.whole.Grammar` to the dataclasses of `analysis.json`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinesics.analysis import facts
from kinesics.grammar.classes import Verdict
from kinesics.grammar.moments import Moments
from kinesics.grammar.motifs import in_frames
from kinesics.grammar.smoothness import of_phrase
from kinesics.grammar.whole import Grammar, JudgedPhrase

Array = NDArray[np.float64]


def overall(verdict: Verdict | None) -> facts.Overall:
    """The class of a whole recording; all None where it was not judged."""
    if verdict is None:
        return facts.Overall()
    bias = verdict.bias
    return facts.Overall(
        **_judged(verdict),
        bias_degrees={} if bias is None else {link: float(angle) for link, angle in bias.degrees.items()},
        bias_kept=() if bias is None else bias.kept,
        lean_degrees={} if bias is None else {part: float(angle) for part, angle in bias.leans.items()},
    )


def of_several(sources: Sequence[facts.Source]) -> facts.Overall:
    """Several recordings are no single path: each has its own class."""
    if len(sources) == 1:
        return sources[0].overall
    return facts.Overall(reasons=("several recordings are no single path: the class of each stands with its source",))


def phrases(source: int, grammar: Grammar, speed: Array, fps: float) -> tuple[facts.Phrase, ...]:
    """The phrases of one recording.

    Parameters
    ----------
    speed : √(2D)/Δt of each of its frames, shape (frames,).
    fps : frames a second.
    """
    return tuple(_phrase(source, phrase, grammar.moments, speed, fps) for phrase in grammar.phrases)


def _phrase(source: int, phrase: JudgedPhrase, moments: Moments, speed: Array, fps: float) -> facts.Phrase:
    start = moments.moment_of(phrase.start)
    smooth = of_phrase(moments, start, max(start + 1, moments.moment_of(phrase.end)))
    return facts.Phrase(
        source=source,
        start=phrase.start,
        end=phrase.end,
        start_s=phrase.start / fps,
        end_s=phrase.end / fps,
        **({} if phrase.verdict is None else _judged(phrase.verdict)),
        speed_mean=float(speed[phrase.start : phrase.end].mean()),
        smoothness=_known(smooth.spectral_arc_length),
        log_dimensionless_jerk=_known(smooth.log_dimensionless_jerk),
        kind=phrase.kind,
        mirrored=phrase.mirrored,
        name=phrase.name,
    )


def cycles(grammar: Grammar, first_phrase: int) -> tuple[facts.Cycle, ...]:
    """The cycles of all phrases of one recording.

    Parameters
    ----------
    first_phrase : place of the recording's first phrase among those of all recordings.
    """
    return tuple(
        facts.Cycle(
            phrase=first_phrase + number,
            start=int(cycle.start),
            end=int(cycle.end),
            period_s=float(cycle.period_s),
            phase=_known(cycle.phase),
            mirror_residual=_known(cycle.mirror_residual),
        )
        for number, phrase in enumerate(grammar.phrases)
        if phrase.verdict is not None
        for cycle in phrase.verdict.cycles
    )


def motifs(source: int, grammar: Grammar, first_id: int) -> tuple[facts.Motif, ...]:
    """The motifs of one recording.

    Parameters
    ----------
    first_id : motifs are numbered from here on, so that several recordings can be told together.
    """
    return tuple(
        facts.Motif(
            id=first_id + number,
            relation=str(motif.relation),
            similarity=float(motif.similarity),
            members=tuple(
                facts.MotifMember(source, m.start, m.end, bool(m.reversed), bool(m.mirrored), m.path)
                for m in motif.members
            ),
        )
        for number, motif in enumerate(in_frames(grammar.moments, grammar.motifs))
    )


def state_repetitions(source: int, grammar: Grammar) -> tuple[facts.StateRepetition, ...]:
    """Moments of one recording at which a pose is taken again."""
    frame = grammar.moments.frame_of
    return tuple(
        facts.StateRepetition(source, tuple(frame(k) for k in found.moments), bool(found.mirrored))
        for found in grammar.state_repetitions
    )


def reversals(source: int, grammar: Grammar) -> tuple[facts.Reversal, ...]:
    """Moments of one recording at which the movement turns back on its own path."""
    return tuple(facts.Reversal(source, grammar.moments.frame_of(found.moment)) for found in grammar.reversals)


def strikes(source: int, grammar: Grammar) -> tuple[facts.Strike, ...]:
    """Fast movements of one recording that end abruptly."""
    read = grammar.moments
    out = []
    for found in grammar.strikes:
        frame = read.frame_of(found.moment)
        out.append(facts.Strike(source, frame, frame / read.source_fps, float(found.speed)))
    return tuple(out)


def _judged(verdict: Verdict) -> dict[str, Any]:
    """What a verdict says of a phrase and of the whole alike."""
    r = verdict.residuals
    bias = verdict.bias
    return {
        "class_": None if verdict.class_ is None else str(verdict.class_),
        "group": verdict.group,
        "period_s": _known(verdict.period_s),
        "confidence": float(verdict.confidence),
        "runner_up": None if verdict.runner_up is None else str(verdict.runner_up),
        "residuals": facts.Residuals(*(_known(v) for v in (r.period, r.mirror, r.glide, r.reverse, r.mirror_reverse))),
        "repeats": _known(verdict.repeats),
        "bias_largest_degrees": None if bias is None else float(bias.largest_degrees),
        "reasons": tuple(verdict.reasons),
    }


def _known(value: float | None) -> float | None:
    """JSON has no infinity: what could not be measured is not known."""
    return None if value is None or not np.isfinite(value) else float(value)
