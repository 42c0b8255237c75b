"""`kinesics.synthesis.embodiment.steady_feet.taut` as the least of a sum of squares, and feet that are down, frame by frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

Array = NDArray[np.float64]


def slopes(line: Array, at: Array) -> float:
    """Sum of squared slopes, each times its length."""
    return float(sum((b - a) ** 2 / (v - u) for a, b, u, v in zip(line, line[1:], at, at[1:], strict=False)))


def taut(low: Array, high: Array, at: Array) -> Array:
    """The line between two others of the least `slopes`."""
    steps = np.diff(np.eye(len(low)), axis=0) / np.sqrt(np.diff(at))[:, None]
    # a trace of the middle, or a line that nothing touches could lie anywhere
    middle = 1e-6 * np.eye(len(low))
    found = lsq_linear(
        np.vstack([steps, middle]),
        np.concatenate([np.zeros(len(low) - 1), middle @ (0.5 * (low + high))]),
        bounds=(low - 1e-9, high + 1e-9),
        tol=1e-14,
    )
    return np.asarray(found.x)
