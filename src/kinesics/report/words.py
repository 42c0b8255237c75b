"""What an analysis says, in words: for the page, and for the command line."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from kinesics.analysis import Analysis
from kinesics.analysis.facts import MotifMember, Overall, Phrase, Source
from kinesics.analysis.facts import source_names as _source_names
from kinesics.grammar.graph import MotionGraph
from kinesics.vocabulary import CLASS_WORDS, MovementClass

_SENTENCES: Final[dict[str, str]] = {
    "cyclic-asymmetric": (
        "It returns again and again; within a cycle nothing is mirrored and nothing is taken back. Limping is so."
    ),
    "cyclic-antiphase": (
        "Half a cycle later the mirror image of every pose comes: what left does, right does next. Walking is so."
    ),
    "cyclic-symmetric": "Left and right do the same at once, and no way is taken back. The butterfly stroke is so.",
    "cyclic-palindromic": "Every way is taken back the way it came, and left and right differ. Waving one hand is so.",
    "cyclic-antipalindromic": (
        "Played backwards, it is its own mirror image. One arm circling forwards and the other backwards is so."
    ),
    "cyclic-antiphase-palindromic": (
        "Every way is taken back the way it came, first on one side, then on the other. Jogging in place is so."
    ),
    "cyclic-symmetric-palindromic": (
        "Left and right do the same at once, and every way is taken back the way it came. Jumping jacks are so."
    ),
    "asymmetric": "Nothing is mirrored and nothing is taken back.",
    "symmetric": "Left and right do the same at once.",
    "palindromic": "It is taken back the way it came.",
    "antipalindromic": "Played backwards, it is its own mirror image.",
    "symmetric-palindromic": "Left and right do the same at once, and it is taken back the way it came.",
    "still": "No joint moves by more than a body at rest sways.",
}
CLASSES: Final[dict[str, tuple[str, str]]] = {c.value: (CLASS_WORDS[c], _SENTENCES[c]) for c in MovementClass}
"""Each class in a few words, and in a sentence."""

_LIKE: Final = {
    "cyclic-asymmetric": "limping",
    "cyclic-antiphase": "walking",
    "cyclic-symmetric": "the butterfly stroke",
    "cyclic-palindromic": "waving one hand",
    "cyclic-antipalindromic": "one arm circling forwards, the other backwards",
    "cyclic-antiphase-palindromic": "jogging in place",
    "cyclic-symmetric-palindromic": "jumping jacks",
}

_SLUG: Final = re.compile(r"(?<![\w-])(?:" + "|".join(sorted(CLASSES, key=len, reverse=True)) + r")(?![\w-])")

RESIDUALS: Final[tuple[tuple[str, str], ...]] = (
    ("period", "a cycle later"),
    ("mirror", "its mirror image, at once"),
    ("glide", "its mirror image, half a cycle later"),
    ("reverse", "played backwards"),
    ("mirror_reverse", "its mirror image, played backwards"),
)
"""Field of the residuals, and in words."""

_BIAS_DEGREES: Final = 15.0
"""A constant difference of left and right from which on it is worth a sentence."""
_LEAN_DEGREES: Final = 0.5 * _BIAS_DEGREES
"""Likewise of a lean or turn to one side: it differs from its mirror image by twice of it."""
_LATE: Final = 0.03
"""Of a cycle: one side later than the other by so much is worth a sentence, if it is so in all cycles alike."""
_UNEVEN: Final = 0.15
"""Standard deviation of the length of cycles, over their mean."""
_LIMBS: Final = {"humerus": "upper arms", "radius": "forearms", "femur": "thighs", "tibia": "lower legs"}
_LEANS: Final = {"trunk": "the chest by {:.0f}° against the pelvis", "head": "the head by {:.0f}° against the chest"}
_LONGEST_REFRAIN: Final = 24
_PART: Final = 0.3
"""Of a recording: a part of it as long as that which comes again is worth a sentence."""


def source_names(analysis: Analysis) -> tuple[str, ...]:
    """What each recording is called; those of one name are numbered."""
    return _source_names(analysis.sources)


def lingering(graph: MotionGraph, source: int) -> float:
    """Seconds of a recording in which it stays in states of the graph, however shortly."""
    if not graph.sources:
        return 0.0
    frames = sum(s.end - s.start for state in graph.states for s in state.stays if s.source == source)
    return frames / graph.sources[source].fps


def stillness(analysis: Analysis, source: int) -> str:
    """How much of a recording is rest, lingering and left like right, in a line."""
    known = analysis.sources[source]
    still = sum(r.end - r.start for r in analysis.stillness if r.source == source) / known.frames
    symmetric = sum(r.end - r.start for r in analysis.symmetric_states if r.source == source) / known.frames
    # a rest is lingered in, too
    lingers = lingering(analysis.graph, source) / known.duration_s
    said = f"at rest {still:.0%} of the time"
    if lingers > still + 0.005:
        said += f" (it lingers in poses of the graph, if only for a moment, {lingers:.0%} of the time)"
    return f"{said}; left and right alike {symmetric:.0%} of the time"


def likelihood(confidence: float) -> str:
    """A probability in words and figures; nothing is ever 100 % sure."""
    word = (
        "surely"
        if confidence >= 0.95
        else "very likely"
        if confidence >= 0.8
        else "probably"
        if confidence >= 0.6
        else "perhaps"
    )
    figure = "over 99 %" if confidence > 0.99 else f"{100.0 * confidence:.0f} %"
    return f"{word} ({figure})"


def reason(text: str) -> str:
    """A reason of a verdict with the names of classes in words."""
    return _SLUG.sub(lambda found: f"“{CLASSES[found.group()][0]}”", text)


def short_class(judged: Overall | Phrase) -> str:
    """The class in a few words with its frieze group; "cannot tell" where there is none."""
    if judged.class_ is None:
        return "cannot tell"
    words = CLASSES[judged.class_][0]
    return f"{words} ({judged.group})" if judged.group else words


def kind(phrase: Phrase) -> str:
    """The number of a phrase's kind, from 1; with a star where it is the mirror image of the first one of its kind."""
    return "" if phrase.kind is None else str(phrase.kind + 1) + "*" * phrase.mirrored


def verdict(judged: Overall | Phrase) -> str:
    """What a movement is, in a line: class, period, how many cycles, how sure."""
    if judged.class_ is None:
        return "cannot tell" + (f": {reason(judged.reasons[0])}" if judged.reasons else "")
    parts = [short_class(judged)]
    if judged.period_s is not None:
        parts.append(f"{judged.period_s:.2f} s a cycle")
        if judged.repeats is not None:
            parts.append(f"{judged.repeats:.1f} cycles")
    return ", ".join(parts) + (f"; {likelihood(judged.confidence)}" if judged.confidence is not None else "")


def headline(analysis: Analysis, source: int) -> str:
    """What a recording is, in a sentence.

    One movement is told by its class; several by how many phrases there are, for a class of the whole would tell little.
    """
    own = [p for p in analysis.phrases if p.source == source]
    moving = [p for p in own if p.class_ != "still"]
    judged = analysis.sources[source].overall
    if len(moving) <= 1 or judged.period_s is not None:
        said = verdict(judged)
        like = _LIKE.get(judged.class_ or "")
        return f"Like {like}: {said}" if like else said[0].upper() + said[1:]
    kinds = len({p.kind for p in moving})
    alike = "" if kinds == len(moving) else f" of {kinds} {'kind' if kinds == 1 else 'kinds'}"
    rests = len(own) - len(moving)
    still = f" and {rests} {'rest' if rests == 1 else 'rests'}" if rests else ""
    return f"{len(moving)} phrases{alike}{still}"


def phrase_line(analysis: Analysis, number: int) -> str:
    """A phrase in a line: its number, from 1 through all recordings, when, and what."""
    phrase = analysis.phrases[number]
    name = f"{phrase.name}: " if phrase.name else ""
    return f"{number + 1}. {phrase.start_s:.1f}-{phrase.end_s:.1f} s  {name}{verdict(phrase)}"


CYCLES_HEADER: Final = ("phrase", "cycles", "lasts (s)", "right after left", "left unlike right")


def cycles_of_phrases(analysis: Analysis) -> list[tuple[int, tuple[str, ...]]]:
    """The cycles of each phrase in a row: the source, and cells under `CYCLES_HEADER`, means ± standard deviations of a cycle."""
    rows: list[tuple[int, tuple[str, ...]]] = []
    for number, phrase in enumerate(analysis.phrases):
        own = [c for c in analysis.cycles if c.phrase == number]
        if own:
            lasts = _spread([c.period_s for c in own], 2)
            late = _spread([100.0 * c.phase for c in own if c.phase is not None], 1, sign="+", unit=" %")
            unlike = _spread([c.mirror_residual for c in own if c.mirror_residual is not None], 2)
            rows.append((phrase.source, (str(number + 1), str(len(own)), lasts, late, unlike)))
    return rows


def _spread(values: Sequence[float], places: int, *, sign: str = "", unit: str = "") -> str:
    """Mean ± standard deviation."""
    if not values:
        return "–"
    # + 0.0: no minus before a nought
    said = f"{round(float(np.mean(values)), places) + 0.0:{sign}.{places}f}"
    if len(values) > 1:
        said += f" ± {float(np.std(values, ddof=1)):.{places}f}"
    return said + unit


def counted(graph: MotionGraph) -> str:
    """How many states and paths a motion graph has, and how many of them are symmetric or reversible."""
    states, paths = len(graph.states), len(graph.paths)
    symmetric = sum(s.symmetric for s in graph.states)
    reversible = sum(p.reversible for p in graph.paths)
    said = f"{states} {'state' if states == 1 else 'states'}" + (f" ({symmetric} symmetric)" if symmetric else "")
    said += f", {paths} {'path' if paths == 1 else 'paths'}"
    return said + (f" ({reversible} both ways)" if reversible else "")


def folded(words: Sequence[str]) -> str:
    """A sentence of the motion graph with its refrains folded: ``3 × (A ab₁→ B ←ab₁) A``.

    Whether a state is held (…) is told where it is so in every repetition.
    """
    plain = [w.rstrip("…") for w in words]
    out: list[str] = []
    at = 0
    while at < len(words):
        best, times = 0, 1
        for length in range(1, min(_LONGEST_REFRAIN, (len(words) - at) // 2) + 1):
            count = 1
            while plain[at + count * length : at + (count + 1) * length] == plain[at : at + length]:
                count += 1
            if (count - 1) * length > (times - 1) * best:
                best, times = length, count
        if (times - 1) * best < 3:
            out.append(words[at])
            at += 1
            continue
        refrain = []
        for k in range(at, at + best):
            held = all(words[k + n * best].endswith("…") for n in range(times))
            refrain.append(plain[k] + "…" * held)
        out.append(f"{times} × ({' '.join(refrain)})")
        at += times * best
    return " ".join(out)


def surprises(analysis: Analysis) -> list[str]:
    """What one would not expect: constant differences of the sides, one side late, uneven cycles, strikes."""
    out: list[str] = []
    names = source_names(analysis)
    for number, source in enumerate(analysis.sources):
        of = f"{names[number]}: " if len(names) > 1 else ""
        found = [
            *_halves(analysis, number),
            *_bias(source),
            *_uneven(analysis, number),
            *_strikes(analysis, number),
        ]
        out.extend(of + s for s in found)
    parts = analysis.graph.components()
    if len(parts) > 1:
        out.append(f"the motion graph falls into {len(parts)} parts that no path joins")
    return out


def _halves(analysis: Analysis, source: int) -> list[str]:
    """One part of a recording that is another part of it, mirrored or backwards or the same; cycles are no surprise."""
    known = analysis.sources[source]
    if known.overall.period_s is not None:
        return []
    best: tuple[int, float, MotifMember, MotifMember] | None = None
    for motif in analysis.motifs:
        first = motif.members[0]
        for other in motif.members[1:]:
            apart = other.start >= first.end or first.start >= other.end
            length = min(first.end - first.start, other.end - other.start)
            if first.source == other.source == source and apart and length >= _PART * known.frames:
                best = max(
                    best or (0, 0.0, first, other), (length, motif.similarity, first, other), key=lambda b: b[:2]
                )
    if best is None:
        return []
    _, similarity, first, other = best
    one, two = sorted((first, other), key=lambda m: m.start)
    mirrored, backwards = one.mirrored != two.mirrored, one.reversed != two.reversed
    how = (
        "the mirror image, played backwards, of"
        if mirrored and backwards
        else "the mirror image of"
        if mirrored
        else "the same, played backwards, as"
        if backwards
        else "the same as"
    )
    # 1 would say that nothing differs
    alike = (
        f"{similarity:.2f}" if similarity < 0.995 else f"{similarity:.5f}" if similarity < 0.99999 else "over 0.99999"
    )
    fps = known.fps
    return [
        f"{two.start / fps:.1f}-{two.end / fps:.1f} s is {how} {one.start / fps:.1f}-{one.end / fps:.1f} s "
        f"(similarity {alike})"
    ]


def _bias(source: Source) -> list[str]:
    """Limbs whose sides differ; chest and head that lean, by what all links of trunk and neck add up to."""
    judged = source.overall
    aside = "set aside before the symmetry was judged"
    limbs = {k: v for k, v in judged.bias_degrees.items() if k in _LIMBS and k not in judged.bias_kept}
    out = []
    if (most := max(limbs, key=lambda k: limbs[k], default=None)) is not None and limbs[most] >= _BIAS_DEGREES:
        out.append(f"left and right differ all the time, most in the {_LIMBS[most]} ({limbs[most]:.0f}°): {aside}")
    held = [_LEANS[k].format(v) for k, v in judged.lean_degrees.items() if v >= _LEAN_DEGREES]
    if held:
        out.append(f"leaning or turned to one side all the time, {' and '.join(held)}: {aside}")
    return out


def _uneven(analysis: Analysis, source: int) -> list[str]:
    out = []
    for number, phrase in enumerate(analysis.phrases):
        if phrase.source != source:
            continue
        own = [c for c in analysis.cycles if c.phrase == number]
        if len(own) < 3:
            continue
        when = f"{phrase.start_s:.1f}-{phrase.end_s:.1f} s: "
        periods = np.array([c.period_s for c in own])
        deviation = float(periods.std(ddof=1) / periods.mean())
        if deviation > _UNEVEN:
            out.append(f"{when}cycles of uneven length ({deviation:.0%} more or less)")
        phases = np.array([c.phase for c in own if c.phase is not None])
        if len(phases) >= 3:
            mean, error = float(phases.mean()), float(phases.std(ddof=1) / np.sqrt(len(phases)))
            if abs(mean) > _LATE and abs(mean) > 3.0 * error:
                late = "right" if mean > 0.0 else "left"
                out.append(f"{when}the {late} side comes late by {abs(mean):.0%} of a cycle")
    return out


def _strikes(analysis: Analysis, source: int) -> list[str]:
    own = [s for s in analysis.strikes if s.source == source]
    if not own:
        return []
    times = ", ".join(f"{s.time_s:.1f}" for s in own[:8]) + (" …" if len(own) > 8 else "")
    return [f"{len(own)} {'strike' if len(own) == 1 else 'strikes'}, movement that stops at once: at {times} s"]
