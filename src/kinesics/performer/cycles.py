"""Cyclic movement with its symmetry built in.

A cycle is a function of phase, period 1, into postures. Averaging any such function over a frieze group gives one with
exactly that group's symmetries (the mirror is linear in postures), so a movement is written down loosely and made exact by
`symmetrise`. The seven groups are the seven cyclic classes (CONVENTIONS.md).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

from kinesics.errors import InputError
from kinesics.performer import postures as _postures
from kinesics.performer.postures import ANGLES, entries_of, pose
from kinesics.performer.score import TEMPO_STREAM, Score, Shutter, check_number, generator
from kinesics.performer.truth import TrueOccurrence, TruePath, TruePhrase, TrueState, Truth, notation_of
from kinesics.vocabulary import MovementClass

Array = NDArray[np.float64]
Shape = Callable[[Array], Array]
"""Phase (n,) to postures (n, angles)."""

C = MovementClass

_ELEMENTS: dict[MovementClass, tuple[tuple[bool, int, float], ...]] = {
    # (mirrored?, direction of time, shift): g(φ) ↦ W^m g(direction·φ + shift)
    C.CYCLIC_ASYMMETRIC: ((False, 1, 0.0),),
    C.CYCLIC_ANTIPHASE: ((False, 1, 0.0), (True, 1, 0.5)),
    C.CYCLIC_SYMMETRIC: ((False, 1, 0.0), (True, 1, 0.0)),
    C.CYCLIC_PALINDROMIC: ((False, 1, 0.0), (False, -1, 0.0)),
    C.CYCLIC_ANTIPALINDROMIC: ((False, 1, 0.0), (True, -1, 0.0)),
    C.CYCLIC_ANTIPHASE_PALINDROMIC: ((False, 1, 0.0), (False, -1, 0.0), (True, 1, 0.5), (True, -1, 0.5)),
    C.CYCLIC_SYMMETRIC_PALINDROMIC: ((False, 1, 0.0), (False, -1, 0.0), (True, 1, 0.0), (True, -1, 0.0)),
}


def symmetrise(shape: Shape, class_: MovementClass) -> Shape:
    """The average of a cycle over the frieze group of a class: exactly of that class (or of a richer one).

    Reversals (T) lie at phases 0 and ½; the mirrored reversals (MT) at 0 and ½, in p2mg at ¼ and ¾.
    """
    elements = _ELEMENTS[class_]

    def averaged(phase: Array) -> Array:
        total = np.zeros((len(phase), len(ANGLES)))
        for mirrored, direction, shift in elements:
            values = shape(direction * phase + shift)
            total += _postures.mirror(values) if mirrored else values
        return total / len(elements)

    return averaged


def through(keys: Sequence[tuple[float, Array]]) -> Shape:
    """The smooth periodic curve through postures at given phases in [0, 1)."""
    phases = np.array([phase for phase, _ in keys])
    values = np.array([values for _, values in keys])
    spline = CubicSpline(np.append(phases, phases[0] + 1.0), np.vstack([values, values[:1]]), bc_type="periodic")
    return lambda phase: np.asarray(spline(np.mod(phase - phases[0], 1.0) + phases[0]))


def tracks(base: Array, curves: Mapping[str, Sequence[tuple[float, float]]], amplitude: float = 1.0) -> Shape:
    """A cycle from a curve for each angle: (percent of the cycle, degrees) pairs, joined smoothly and periodically.

    ``amplitude`` scales the departure of each curve from its own mean.
    """
    splines: list[tuple[list[int], float, CubicSpline]] = []
    for name, points in curves.items():
        x = np.array([p for p, _ in points]) / 100.0
        y = np.array([v for _, v in points])
        y = y if name.endswith("plant") else np.deg2rad(y)
        spline = CubicSpline(np.append(x, x[0] + 1.0), np.append(y, y[0]), bc_type="periodic")
        entries, share = entries_of(name)
        splines.append((entries, share, spline))

    def shape(phase: Array) -> Array:
        out = np.tile(base, (len(phase), 1))
        for entries, share, spline in splines:
            start = spline.x[0]
            values = spline(np.mod(phase - start, 1.0) + start)
            middle = spline.integrate(start, start + 1.0)
            out[:, entries] = share * (middle + amplitude * (values - middle))[:, None]
        return out

    return shape


def scaled(shape: Shape, centre: Array, amplitude: float) -> Shape:
    """The cycle with its departure from ``centre`` scaled."""
    return lambda phase: centre + amplitude * (shape(phase) - centre)


@dataclass(frozen=True)
class Tempo:
    """When each cycle begins."""

    boundaries: Array
    """Seconds; phase k is reached at entry k; they reach beyond the end of the performance."""
    exact: bool
    """All cycles take equally long."""

    def phase(self, times: Array) -> Array:
        """Phase at given seconds: smooth and rising, k at boundary k."""
        if self.exact:
            return np.asarray(times / (self.boundaries[1] - self.boundaries[0]))
        return np.asarray(self._curve(times))

    @cached_property
    def _curve(self) -> PchipInterpolator:
        return PchipInterpolator(self.boundaries, np.arange(len(self.boundaries)))

    def time(self, phase: float) -> float:
        """Seconds at which a phase is reached."""
        if self.exact:
            return float(phase * (self.boundaries[1] - self.boundaries[0]))
        whole = float(np.interp(phase, np.arange(len(self.boundaries)), self.boundaries))
        if phase == int(phase):
            return whole
        low, high = whole - self._longest, whole + self._longest
        for _ in range(60):  # bisection: the clock is monotone
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._clock(middle) < phase else (low, middle)
        return 0.5 * (low + high)

    @property
    def _longest(self) -> float:
        return float(np.diff(self.boundaries).max())

    def _clock(self, seconds: float) -> float:
        inside = float(np.clip(seconds, self.boundaries[0], self.boundaries[-1]))
        return float(self.phase(np.array([inside]))[0])


def unequal(lengths: Array, jitter: float, rng: np.random.Generator) -> Array:
    """Durations multiplied by 1 + jitter·normal, no repetition more than 2.5 deviations or half its length off."""
    factors = 1.0 + jitter * np.clip(rng.standard_normal(len(lengths)), -2.5, 2.5)
    return np.asarray(lengths * np.clip(factors, 0.5, 1.5))


def tempo(period: float, seconds: float, jitter: float, seed: int) -> Tempo:
    """Cycles of the given period, each shorter or longer by a relative deviation ``jitter``."""
    count = int(np.ceil(2.0 * seconds / period)) + 3
    lengths = unequal(np.full(count, period), jitter, generator(seed, TEMPO_STREAM))
    return Tempo(np.concatenate([[0.0], np.cumsum(lengths)]), exact=jitter == 0.0)


@dataclass(frozen=True)
class _Cell:
    """The graph of one cycle: states at phases, and the paths between them in order."""

    states: tuple[tuple[str, float, bool, str | None], ...]
    """Label, phase, symmetric?, mirror of."""
    paths: tuple[tuple[str, str, str, bool, str | None], ...]
    """Label, from, to, reversible?, mirror of."""
    passage: tuple[tuple[float, float, int, bool], ...]
    """From phase, to phase, index of the path, reversed?"""
    reversals: tuple[float, ...]


def slowest_phase(shape: Shape, within: float = 1.0) -> float:
    """The phase in [0, within) at which the pose changes least (least √(2D) a step)."""
    count = 1440
    phase = np.arange(int(count * within) + 1) / count
    q = pose(shape(phase))
    speed = np.sqrt(np.sum(2.0 * (1.0 - np.minimum(np.abs(np.einsum("fji,fji->fj", q[1:], q[:-1])), 1.0)), axis=1))
    return float((phase[:-1] + phase[1:])[int(np.argmin(speed))] / 2.0)


def _cell(shape: Shape, class_: MovementClass) -> _Cell:
    if class_ is C.CYCLIC_ASYMMETRIC:
        p = slowest_phase(shape)
        return _Cell((("A", p, False, None),), (("aa_1", "A", "A", False, None),), ((p, p + 1, 0, False),), ())
    if class_ is C.CYCLIC_SYMMETRIC:
        p = slowest_phase(shape)
        return _Cell((("X~", p, True, "X~"),), (("xx~_1", "X~", "X~", False, "xx~_1"),), ((p, p + 1, 0, False),), ())
    if class_ is C.CYCLIC_ANTIPHASE:
        p = slowest_phase(shape, 0.5)
        return _Cell(
            (("A", p, False, "A*"), ("A*", p + 0.5, False, "A")),
            (("aa*_1", "A", "A*", False, "(aa*_1)*"), ("(aa*_1)*", "A*", "A", False, "aa*_1")),
            ((p, p + 0.5, 0, False), (p + 0.5, p + 1, 1, False)),
            (),
        )
    if class_ is C.CYCLIC_PALINDROMIC:
        return _Cell(
            (("A", 0.0, False, None), ("B", 0.5, False, None)),
            (("ab_1", "A", "B", True, None),),
            ((0.0, 0.5, 0, False), (0.5, 1.0, 0, True)),
            (0.0, 0.5),
        )
    if class_ is C.CYCLIC_ANTIPALINDROMIC:
        # the way back is the mirror image of the way there, played backwards
        return _Cell(
            (("X~", 0.0, True, "X~"), ("Y~", 0.5, True, "Y~")),
            (("xy_1", "X~", "Y~", True, "(xy_1)*"), ("(xy_1)*", "X~", "Y~", True, "xy_1")),
            ((0.0, 0.5, 0, False), (0.5, 1.0, 1, True)),
            (),
        )
    if class_ is C.CYCLIC_ANTIPHASE_PALINDROMIC:
        return _Cell(
            (("A", 0.0, False, "A*"), ("X~", 0.25, True, "X~"), ("A*", 0.5, False, "A")),
            (("ax_1", "A", "X~", True, "(ax_1)*"), ("(ax_1)*", "A*", "X~", True, "ax_1")),
            ((0.0, 0.25, 0, False), (0.25, 0.5, 1, True), (0.5, 0.75, 1, False), (0.75, 1.0, 0, True)),
            (0.0, 0.5),
        )
    return _Cell(
        (("X~", 0.0, True, "X~"), ("Y~", 0.5, True, "Y~")),
        (("xy~_1", "X~", "Y~", True, "xy~_1"),),
        ((0.0, 0.5, 0, False), (0.5, 1.0, 0, True)),
        (0.0, 0.5),
    )


def cyclic_score(
    movement: str,
    class_: MovementClass,
    shape: Shape,
    *,
    seconds: float,
    period: float,
    tempo_jitter: float,
    seed: int,
    lift: Callable[[Array, Array], Array] | None = None,
    travels: bool = False,
) -> Score:
    """A movement that repeats a cycle.

    Parameters
    ----------
    shape : already of its class (`symmetrise`).
    lift : from phase and the cycle's length in seconds to metres above the ground.

    Raises
    ------
    InputError
        If a number is out of range, or ``seconds`` are fewer than two periods.
    """
    seconds = check_number("seconds", seconds, 0.05, 3600.0, unit="s")
    period = check_number("period", period, 0.2, 60.0, unit="s")
    tempo_jitter = check_number("tempo_jitter", tempo_jitter, 0.0, 0.3)
    beat = tempo(period, seconds, tempo_jitter, seed)
    if beat.boundaries[2] > seconds + 1e-9:
        raise InputError(
            f"A movement is cyclic from two full periods on: expected `seconds` of at least {beat.boundaries[2]:.3g} "
            f"for {movement} of period {period:g} s (seed {seed}), got {seconds:g}."
        )

    def angles(times: Array) -> Array:
        return shape(beat.phase(times))

    def height(times: Array) -> Array:
        if lift is None:
            return np.zeros(len(times))
        phase = beat.phase(times)
        k = np.clip(np.floor(phase).astype(np.intp), 0, len(beat.boundaries) - 2)
        return lift(phase, np.diff(beat.boundaries)[k])

    def truth(shutter: Shutter) -> Truth:
        return _cyclic_truth(movement, class_, shape, beat, shutter, seconds)

    return Score(movement, seconds, angles, truth, lift=height, travels=travels, detrend=not travels)


def _cyclic_truth(
    movement: str, class_: MovementClass, shape: Shape, beat: Tempo, shutter: Shutter, seconds: float
) -> Truth:
    cell = _cell(shape, class_)
    n = shutter.frame_count
    full = [float(t) for t in beat.boundaries if t <= seconds + 1e-9]
    last_phase = float(beat.phase(np.array([seconds]))[0])

    occurrences: list[list[TrueOccurrence]] = [[] for _ in cell.paths]
    for k in range(-1, int(np.ceil(last_phase)) + 1):
        for start, end, path, reversed_ in cell.passage:
            low, high = k + start, k + end
            if high <= 1e-9 or low >= last_phase - 1e-9:
                continue
            complete = low >= -1e-9 and high <= last_phase + 1e-9
            first = shutter.frame(beat.time(max(low, 0.0)))
            final = n if high >= last_phase - 1e-9 else shutter.frame(beat.time(high))
            if final > first:
                occurrences[path].append(TrueOccurrence(first, final, reversed_, complete))

    turns = [
        shutter.nearest(beat.time(k + p))
        for k in range(int(np.ceil(last_phase)) + 1)
        for p in cell.reversals
        if 0.0 < k + p < last_phase
    ]
    paths = tuple(
        TruePath(label, from_, to, reversible, image, tuple(occurrences[i]))
        for i, (label, from_, to, reversible, image) in enumerate(cell.paths)
    )
    period_s = float(np.mean(np.diff(full))) if len(full) > 1 else float(beat.boundaries[1])
    phrase = TruePhrase(movement, 0, n, class_, period_s, tuple(shutter.frame(t) for t in full), tempo_exact=beat.exact)
    return Truth(
        movement=movement,
        class_=class_,
        period_s=period_s,
        frame_count=n,
        fps=shutter.fps,
        phrases=(phrase,),
        states=tuple(
            TrueState(label, pose(shape(np.array([phase])))[0], symmetric, image)
            for label, phase, symmetric, image in cell.states
        ),
        paths=paths,
        reversals=tuple(sorted(f for f in turns if f is not None)),
        notation=notation_of(paths),
    )
