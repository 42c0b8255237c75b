"""How fast the body moves, without what the sensor's noise adds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar.moments import Moments

Array = NDArray[np.float64]


def quiet_speed(moments: Moments) -> Array:
    """Way of each step, √(2D), without what the noise adds to it, shape (moments,)."""
    squared = (moments.speed / moments.fps) ** 2
    smooth = np.convolve(np.pad(squared, 1, mode="edge"), np.ones(3) / 3.0, "valid")
    return np.sqrt(np.maximum(smooth - 2.0 * moments.noise, 0.0))


def speed_on_moments(moments: Moments) -> Array:
    """Speed at each moment without what the noise adds to it, √(2D)/Δt, 1/s, shape (moments,).

    The mean of the steps to it and from it, smoothed over three.
    """
    v = quiet_speed(moments) * moments.fps
    on = v.copy()
    on[1:-1] = 0.5 * (v[1:-1] + v[2:])
    return np.convolve(np.pad(on, 1, mode="edge"), (0.25, 0.5, 0.25), "valid")
