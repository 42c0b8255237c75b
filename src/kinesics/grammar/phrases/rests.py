"""Where the body rests, and where it is calm."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.runs import runs
from kinesics.grammar.moments import Moments
from kinesics.grammar.ranges import STILL
from kinesics.similarity import chord

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

REST_S: Final = 3.0
"""A rest of so long is a phrase."""
_CALM: Final = 0.4
"""A moment is calm whose speed is below this share of that of the liveliest moments on either side of it."""
_SMOOTH_S: Final = 0.3


def rests(coarse: Moments, by_lag: Floats) -> list[tuple[int, int]]:
    """Stretches [start, end) of at least `REST_S` in which no two moments a rest apart differ by more than a body at rest sways.

    Parameters
    ----------
    by_lag : D of ``coarse`` by lag (`Moments.by_lag`), up to `REST_S` at least.
    """
    n = coarse.count
    span = max(2, round(REST_S * coarse.fps))
    if n <= span:
        return (
            [(0, n)] if n > 1 and bool((chord(by_lag[1:, :][np.isfinite(by_lag[1:, :])]) <= sway(coarse)).all()) else []
        )
    near = np.ones(n - span, dtype=np.bool_)
    for k in range(1, span + 1):
        row = chord(by_lag[k, : n - k].astype(np.float64)) <= sway(coarse)
        # all pairs at this lag within the window of span + 1 moments
        count = np.concatenate([[0], np.cumsum(~row)])
        near &= count[span + 1 - k : n - k + 1][: n - span] == count[: n - span]
    still = np.zeros(n, dtype=np.bool_)
    for t in np.flatnonzero(near):
        still[t : t + span + 1] = True
    return runs(still)


def sway(coarse: Moments) -> float:
    """√(2D) up to which a body rests, the noise included."""
    return float(np.sqrt(STILL**2 + 2.0 * coarse.noise * 2.0))


def calmness(coarse: Moments) -> Array:
    """Speed on the moments, 1/s, smoothed a little, shape (moments,): the lower, the calmer."""
    width = max(1, round(_SMOOTH_S * coarse.fps)) | 1
    weights = np.hanning(width + 2)[1:-1]
    # steps lead from one moment to the next: put them on the moments
    v = coarse.speed
    on = v.copy()
    on[1:-1] = 0.5 * (v[1:-1] + v[2:])
    padded = np.pad(on, width // 2, mode="edge")
    return np.convolve(padded, weights / weights.sum(), "valid")


def calm_moments(speed: Array, low: int, high: int, shortest: float) -> list[int]:
    """Moments in (low, high) that are calm against what lies on either side, at least ``shortest`` apart; of a rest the middle."""
    inner = speed[low : high + 1]
    found: list[tuple[float, int]] = []
    for t in range(low + 1, min(high, len(speed) - 1)):
        if not (speed[t] <= speed[t - 1] and speed[t] < speed[t + 1]):
            continue
        calm = _CALM * min(float(inner[: t - low + 1].max()), float(inner[t - low :].max()))
        if speed[t] < calm:
            a = b = t
            level = max(float(speed[t]), 0.5 * calm)
            while a > low + 1 and speed[a - 1] <= level:
                a -= 1
            while b < high - 1 and b < len(speed) - 1 and speed[b + 1] <= level:
                b += 1
            found.append((float(speed[t]), (a + b) // 2))
    chosen: list[int] = []
    for _, t in sorted(found):
        if all(abs(t - c) >= shortest for c in chosen):
            chosen.append(t)
    return sorted(chosen)
