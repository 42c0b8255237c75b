"""Which symmetry class a movement has, how sure that is, and what else it might be ([Schultz2012] §3.4, completed).

A class is a hypothesis with evidence. Each symmetry (M at once, M after half a period, T, MT) leaves a residual
(`kinesics.grammar.evidence`); a logistic curve turns it into the probability that the symmetry holds, by the residual itself and
by how it compares with what the period leaves, for a symmetry cannot hold better than the movement repeats itself. Symmetries
form groups: a class has the probability that its symmetries hold and the others do not, and the classes that no group allows
(M and T without MT, say) have none. The few numbers of the curves were fitted on synthetic performances
(``benchmarks/fit_classes.py``, which states by what convention a nearly symmetric movement counts as symmetric).

**Cyclic or made once.** Cyclic from two full periods on. A movement seen a little less long is cyclic too when it is made of
halves that are images of each other (glide, mirrored reversal, reversal) and at least three halves are seen: from 1.6 periods
on. (Recorded exercises often end in the middle of a repetition.)

**Left and right.** The constant difference of the sides is taken out first (`kinesics.grammar.bias`) and reported. The class is
judged with and without it; the verdict says so where that makes a difference, and falls back on "cannot tell" where the
difference is much larger than the movement.

**Cannot tell** (``class_`` None): too short, hardly larger than the sensor's noise, or no class is likelier than the others.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar import bias as _bias
from kinesics.grammar import cycles as _cycles
from kinesics.grammar import evidence as _evidence
from kinesics.grammar.bias import Bias
from kinesics.grammar.cycles import Cycle, Stability
from kinesics.grammar.evidence import CyclicEvidence, Residuals, SingleEvidence
from kinesics.grammar.moments import Moments
from kinesics.similarity import chord
from kinesics.vocabulary import FRIEZE_GROUPS, MovementClass

C = MovementClass

CYCLIC_SYMMETRIES: Final[Mapping[MovementClass, frozenset[str]]] = {
    C.CYCLIC_ASYMMETRIC: frozenset(),
    C.CYCLIC_ANTIPHASE: frozenset({"glide"}),
    C.CYCLIC_SYMMETRIC: frozenset({"mirror"}),
    C.CYCLIC_PALINDROMIC: frozenset({"reverse"}),
    C.CYCLIC_ANTIPALINDROMIC: frozenset({"mirror_reverse"}),
    C.CYCLIC_ANTIPHASE_PALINDROMIC: frozenset({"glide", "reverse", "mirror_reverse"}),
    C.CYCLIC_SYMMETRIC_PALINDROMIC: frozenset({"mirror", "reverse", "mirror_reverse"}),
}
SINGLE_SYMMETRIES: Final[Mapping[MovementClass, frozenset[str]]] = {
    C.ASYMMETRIC: frozenset(),
    C.SYMMETRIC: frozenset({"mirror"}),
    C.PALINDROMIC: frozenset({"reverse"}),
    C.ANTIPALINDROMIC: frozenset({"mirror_reverse"}),
    C.SYMMETRIC_PALINDROMIC: frozenset({"mirror", "reverse", "mirror_reverse"}),
}

PERIODS: Final = 2.0
"""A movement is cyclic from so many periods on,"""
PERIODS_OF_HALVES: Final = 1.6
"""or from so many where half a period is an image of the other half."""
_PERIODS_TOLERANCE: Final = 0.07
"""Of a period: stillness at both ends, and half a moment at each, are not counted."""
_PERIODS_SPREAD: Final = 0.05
"""By how much the number of periods may be misjudged, as the scale of a logistic curve."""
_COVERAGE: Final = 0.6
"""Share of the moving moments that must return a period later;"""
_COVERAGE_OF_HALVES: Final = 0.75
"""so many where fewer than two periods are seen,"""
_RESIDUAL_OF_HALVES: Final = 0.3
"""and what the period leaves over must be no more than this."""
SLOW_S: Final = 2.5
"""In a longer cycle there is time for a choreography, of which parts return by themselves: of its moments,"""
_UNBROKEN: Final = 0.92
"""between the first and the last that returns, so many must."""
_UNITY: Final = 0.6
"""Cycles anywhere in the stretch must be alike to this residual: else it is several cyclic movements, and as a whole none."""
STILL: Final = float(2.0 * np.sin(np.deg2rad(5.0) / 4.0))
"""√(2D) of 5° r.m.s. in all joints: a body that stays within it is still (people at rest sway by one or two degrees)."""
_NOISES: Final = 8.0
"""A movement must be larger than the noise by this factor (in D)."""
_BIASES: Final = 4.0
"""A movement smaller than the left/right bias by this factor (in D) has no class that can be told from it."""
_SHORTEST_S: Final = 0.25
_LIKELY: Final = 0.4
"""A class less probable than this is not named."""
_FLOOR: Final = 0.01
_PERIOD_FLOOR: Final = 0.02


@dataclass(frozen=True)
class Curve:
    """Log odds that a symmetry which leaves r holds.

    offset − residual·ln(r + .01) − ratio·ln((r + .02)/(p + .02)) − turn·ln(v + .1), with p what the period leaves and v the speed
    at the turning over the mean speed.
    """

    offset: float
    residual: float
    ratio: float = 0.0
    turn: float = 0.0

    def log_odds(self, residual: float | None, period: float | None = None, turn: float | None = None) -> float:
        """Of one symmetry; very low where there is no residual."""
        if residual is None:
            return -30.0
        value = self.offset - self.residual * np.log(residual + _FLOOR)
        if self.ratio and period is not None:
            value -= self.ratio * np.log((residual + _PERIOD_FLOOR) / (period + _PERIOD_FLOOR))
        if self.turn and turn is not None:
            value -= self.turn * np.log(turn + 0.1)
        return float(np.clip(value, -30.0, 30.0))


CYCLIC_CURVES: Final[Mapping[str, Curve]] = {
    "mirror": Curve(offset=0.501, residual=0.379, ratio=0.957),
    "glide": Curve(offset=0.347, residual=2.44, ratio=6.5),
    "reverse": Curve(offset=-1.71, residual=1.44, ratio=0.755, turn=0.229),
    "mirror_reverse": Curve(offset=-1.51, residual=1.2, ratio=0.285),
}
SINGLE_CURVES: Final[Mapping[str, Curve]] = {
    "mirror": Curve(offset=-1.28, residual=1.23),
    "reverse": Curve(offset=-1.97, residual=1.75, turn=0.596),
    "mirror_reverse": Curve(offset=-1.77, residual=1.4),
}
CYCLIC_TEMPERATURE: Final = 0.376
SINGLE_TEMPERATURE: Final = 0.158
"""The symmetries of one movement do not err independently: log probabilities are divided by this."""
LEANINGS: Final[Mapping[MovementClass, float]] = {
    C.CYCLIC_ASYMMETRIC: -0.71,
    C.CYCLIC_ANTIPHASE: 0.98,
    C.CYCLIC_SYMMETRIC: 0.15,
    C.CYCLIC_PALINDROMIC: 0.16,
    C.CYCLIC_ANTIPALINDROMIC: 0.24,
    C.CYCLIC_ANTIPHASE_PALINDROMIC: -0.85,
    C.CYCLIC_SYMMETRIC_PALINDROMIC: 0.04,
    C.ASYMMETRIC: 0.81,
    C.SYMMETRIC: -0.21,
    C.PALINDROMIC: -0.32,
    C.ANTIPALINDROMIC: -0.29,
    C.SYMMETRIC_PALINDROMIC: 0.01,
}
"""Added to the log probability of a class: a reversal leaves over less by chance in some than in others."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """All that a class is judged by."""

    cyclic: CyclicEvidence | None
    """Without the left/right bias; None where no period was found."""
    cyclic_biased: CyclicEvidence | None
    single: SingleEvidence | None
    single_biased: SingleEvidence | None
    bias: Bias | None
    reach: float
    """95th percentile of √(2D) between moments, without noise."""
    by_lag: NDArray[np.float32]


@dataclass(frozen=True)
class Verdict:
    """The class of a stretch, with its evidence."""

    class_: MovementClass | None
    """None: cannot tell."""
    group: str | None
    """Frieze group of a cyclic class."""
    period_s: float | None
    confidence: float
    """Probability that the class is right; 0 where none is named."""
    runner_up: MovementClass | None
    residuals: Residuals
    """Without the constant left/right bias."""
    residuals_biased: Residuals
    """With it."""
    repeats: float | None
    """How many periods long the movement is."""
    cycles: tuple[Cycle, ...]
    stability: Stability | None
    bias: Bias | None
    reasons: tuple[str, ...]
    """In words: what decided, what was assumed, why it cannot be told."""
    probabilities: Mapping[MovementClass, float]


def classify(moments: Moments, start: int = 0, end: int | None = None) -> Verdict:
    """The class of a stretch of moments as one path.

    Raises
    ------
    InputError
        If the stretch is empty or reaches beyond the recording.
    """
    start, end = moments.stretch(start, end)
    # by themselves: what is turned or mirrored on the way is then the stretch, not the recording
    moments = moments.cut(start, end)
    start, end = 0, moments.count
    seen = measure(moments, start, end)
    if seen is None:
        return _unknown(f"{(end - start) / moments.fps:.2g} s is too short to tell")
    if seen.reach <= STILL:
        return _verdict_still(seen)
    main = seen.cyclic if is_cyclic(seen) else seen.single
    if main is None:
        return _unknown("what moves is not long enough to compare", bias=seen.bias)
    reasons: list[str] = []
    if main.range < _NOISES * moments.noise:
        return _unknown("the movement is hardly larger than the sensor's noise", main.residuals, seen.bias)
    if isinstance(main, CyclicEvidence):
        return _cyclic_verdict(moments, start, end, seen, main, reasons)
    biased = seen.single_biased or main
    chances = single_probabilities(main)
    if seen.cyclic is not None and seen.cyclic.repeats >= 1.2:
        length = f"{seen.cyclic.period / moments.fps:.2f} s"
        reasons.append(
            f"only {seen.cyclic.repeats:.1f} periods of {length} are seen"
            if seen.cyclic.repeats < PERIODS
            else f"parts repeat after {length}, but not the whole"
        )
    return _verdict(chances, single_probabilities(biased), main.residuals, biased.residuals, seen, reasons, main.range)


def measure(moments: Moments, start: int, end: int) -> Evidence | None:
    """The evidence for every class; None where the stretch is too short for any."""
    n = end - start
    if n < max(6, round(_SHORTEST_S * moments.fps)):
        return None
    reach = _reach(moments, start, end)
    by_lag, path = _evidence.find_period(moments, start, end)
    cyclic = cyclic_biased = None
    if path is not None and reach > STILL:
        # symmetries are looked for within a period
        near = min(len(by_lag), int(1.3 * path.lags.max()) + 4)
        within = moments.by_lag(near - 1, start, end)
        cyclic = cyclic_biased = _evidence.cyclic(moments, start, end, within, path)
        # averages are taken over whole periods, the middle ones
        whole = int((n - 1) / cyclic.period) * cyclic.period
        edge = int((n - whole) / 2.0)
        bias = _bias.estimate(moments, start + edge, end - edge)
        if bias is not None:
            straight = _bias.without(moments, bias)
            cyclic = _evidence.cyclic(straight, start, end, straight.by_lag(near - 1, start, end), path)
    single = single_biased = _evidence.single(moments, start, end)
    bias_all = _bias.estimate(moments, start, end)
    if bias_all is not None and single is not None:
        single = _evidence.single(_bias.without(moments, bias_all), start, end)
    chosen = bias if cyclic is not None else bias_all
    return Evidence(cyclic, cyclic_biased, single, single_biased, chosen, reach, by_lag)


def is_cyclic(seen: Evidence) -> bool:
    """Whether the movement repeats itself, by the rule of this module."""
    return cyclic_chance(seen) >= 0.5


def cyclic_chance(seen: Evidence) -> float:
    """How sure it is that the movement repeats itself: ½ at the number of periods that the rule asks for."""
    found = seen.cyclic
    if found is None or found.residuals.period is None or found.coverage < _COVERAGE or found.unity > _UNITY:
        return 0.0
    if found.period_s > SLOW_S and found.unbroken < _UNBROKEN:
        return 0.0
    needed = PERIODS
    if found.coverage >= _COVERAGE_OF_HALVES and found.residuals.period <= _RESIDUAL_OF_HALVES:
        chances = cyclic_probabilities(found)
        if sum(p for c, p in chances.items() if CYCLIC_SYMMETRIES[c] - {"mirror"}) > 0.5:
            needed = PERIODS_OF_HALVES
    return float(1.0 / (1.0 + np.exp(-min((found.repeats - needed + _PERIODS_TOLERANCE) / _PERIODS_SPREAD, 700.0))))


def cyclic_probabilities(found: CyclicEvidence) -> dict[MovementClass, float]:
    """The probability of each cyclic class."""
    r = found.residuals
    odds = {
        name: curve.log_odds(getattr(r, name), r.period, found.turn_speed if curve.turn else None)
        for name, curve in CYCLIC_CURVES.items()
    }
    return _of_groups(odds, CYCLIC_SYMMETRIES, CYCLIC_TEMPERATURE)


def single_probabilities(found: SingleEvidence) -> dict[MovementClass, float]:
    """The probability of each class of movement made once."""
    odds = {
        name: curve.log_odds(getattr(found.residuals, name), None, found.turn_speed if curve.turn else None)
        for name, curve in SINGLE_CURVES.items()
    }
    return _of_groups(odds, SINGLE_SYMMETRIES, SINGLE_TEMPERATURE)


def _of_groups(
    odds: Mapping[str, float], groups: Mapping[MovementClass, frozenset[str]], temperature: float
) -> dict[MovementClass, float]:
    """Each group needs its symmetries and none of the others: the product, normalised over the groups there are."""
    logs = np.array(
        [
            sum(-float(np.logaddexp(0.0, -v if name in symmetries else v)) for name, v in odds.items())
            for symmetries in groups.values()
        ]
    )
    logs = logs / temperature + np.array([LEANINGS[c] for c in groups])
    share = np.exp(logs - logs.max())
    share /= share.sum()
    return {c: float(p) for c, p in zip(groups, share, strict=True)}


def _cyclic_verdict(
    moments: Moments, start: int, end: int, seen: Evidence, found: CyclicEvidence, reasons: list[str]
) -> Verdict:
    biased = seen.cyclic_biased or found
    chances = cyclic_probabilities(found)
    best = max(chances, key=lambda c: chances[c])
    straight = moments if seen.bias is None else _bias.without(moments, seen.bias)
    alternating = bool(CYCLIC_SYMMETRIES[best] & {"glide"}) or (
        not CYCLIC_SYMMETRIES[best] & {"mirror"} and (found.residuals.glide or 9.0) < (found.residuals.mirror or 9.0)
    )
    listed, period_s = _cycles.find(
        straight, start, end, seen.by_lag, found.path.lags, found.returns, found.range, alternating=alternating
    )
    if found.repeats < PERIODS - _PERIODS_TOLERANCE:
        reasons.append(f"{found.repeats:.1f} periods are seen, of halves that are images of each other")
    stable = _cycles.stability(listed, found.residuals.period)
    return _verdict(
        chances,
        cyclic_probabilities(biased),
        found.residuals,
        biased.residuals,
        seen,
        reasons,
        found.range,
        period_s=period_s,
        repeats=found.repeats,
        cycles=listed,
        stable=stable,
    )


def _verdict(
    chances: dict[MovementClass, float],
    biased_chances: dict[MovementClass, float],
    residuals: Residuals,
    biased: Residuals,
    seen: Evidence,
    reasons: list[str],
    range_: float,
    *,
    period_s: float | None = None,
    repeats: float | None = None,
    cycles: tuple[Cycle, ...] = (),
    stable: Stability | None = None,
) -> Verdict:
    ranked = sorted(chances, key=lambda c: -chances[c])
    best: MovementClass | None = ranked[0]
    repeating = cyclic_chance(seen)
    confidence = chances[ranked[0]] * (repeating if ranked[0] in FRIEZE_GROUPS else 1.0 - repeating)
    if confidence < _LIKELY:
        reasons.append(
            f"no class stands out: {ranked[0].value} {confidence:.0%}, {ranked[1].value} {chances[ranked[1]]:.0%}"
        )
        best = None
    other = max(biased_chances, key=lambda c: biased_chances[c])
    if seen.bias is not None and other is not ranked[0]:
        reasons.append(
            f"a constant difference of left and right of up to {seen.bias.largest_degrees:.0f}° was set aside; "
            f"with it the movement would read as {other.value}"
        )
        if seen.bias.distance > _BIASES * range_:
            reasons.append("and the movement is much smaller than that difference")
            best = None
    return Verdict(
        class_=best,
        group=None if best is None else FRIEZE_GROUPS.get(best),
        period_s=period_s,
        confidence=confidence if best is not None else 0.0,
        runner_up=ranked[1] if best is not None else ranked[0],
        residuals=residuals,
        residuals_biased=biased,
        repeats=repeats,
        cycles=cycles,
        stability=stable,
        bias=seen.bias,
        reasons=tuple(reasons),
        probabilities=chances,
    )


def _verdict_still(seen: Evidence) -> Verdict:
    confidence = float(1.0 / (1.0 + (seen.reach / (1.3 * STILL)) ** 6))
    return Verdict(
        class_=C.STILL,
        group=None,
        period_s=None,
        confidence=confidence,
        runner_up=None,
        residuals=Residuals(),
        residuals_biased=Residuals(),
        repeats=None,
        cycles=(),
        stability=None,
        bias=seen.bias,
        reasons=(f"no joint leaves the others' 5° r.m.s.: reach {seen.reach:.3f} of {STILL:.3f}",),
        probabilities={C.STILL: confidence},
    )


def _unknown(reason: str, residuals: Residuals | None = None, bias: Bias | None = None) -> Verdict:
    known = residuals or Residuals()
    return Verdict(None, None, None, 0.0, None, known, known, None, (), None, bias, (reason,), {})


def _reach(moments: Moments, start: int, end: int) -> float:
    """95th percentile of √(2D) between moments evenly spaced over the stretch, without noise."""
    index = np.unique(np.linspace(start, end - 1, min(end - start, 400)).round().astype(np.intp))
    d, _ = moments.thinned(index)
    pairs = d[np.triu_indices(len(index), 1)]
    return float(np.quantile(chord(np.maximum(pairs - moments.noise, 0.0)), 0.95)) if len(pairs) else 0.0
