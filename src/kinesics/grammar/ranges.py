"""How far a movement ranges: what is left of it under a symmetry, or when it recurs, is measured against that.

Residuals are so free of scale: 0 is exact, about 1 is what unrelated moments of the same movement leave.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar.moments import Moments

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

RANGE: Final = 1.3
"""Times the mean distance in a stretch: about the 75th percentile, and steadier."""
STILL: Final = float(2.0 * np.sin(np.deg2rad(5.0) / 4.0))
"""√(2D) of 5° r.m.s. in all joints: people at rest sway by one or two degrees."""
SWAY: Final = 4e-4
"""Range of a body at rest, beyond the noise: joints that stay within 5° r.m.s. of each other. What moves by less than the noise
rests, too: the cheapest of many paths through noise is nearer than the noise lets it be."""


def spread(by_lag: Floats, half: int) -> Array:
    """Mean distance between all moments within ``half`` of each moment, each with itself included; shape (moments,).

    Parameters
    ----------
    by_lag : ``by_lag[k, i]`` is the distance of moments i and i + k, inf beyond the end.
    """
    n = by_lag.shape[1]
    t = np.arange(n)
    low, high = np.maximum(t - half, 0), np.minimum(t + half + 1, n)
    total = np.zeros(n)
    for k in range(1, min(2 * half + 1, len(by_lag))):
        row = np.where(np.isfinite(by_lag[k]), by_lag[k], np.float32(0.0))
        sums = np.concatenate([[0.0], np.cumsum(row, dtype=np.float64)])
        total += 2.0 * (sums[np.maximum(high - k, low)] - sums[low])
    mean: Array = total / (high - low) ** 2
    return mean


def range_of(moments: Moments, mean: Array | np.floating) -> Array:
    """The range of a movement, from the mean distance of its moments: without what the noise adds to each distance."""
    return RANGE * np.maximum(np.asarray(mean, dtype=np.float64) - moments.noise, 0.0)
