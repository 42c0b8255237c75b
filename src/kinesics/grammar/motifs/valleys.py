"""The minima of a row of values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Floats = NDArray[np.float32]


def valleys(values: Array | Floats, below: float, apart: int) -> list[int]:
    """Indices of the minima under a level, each the lowest within ``apart``, the lowest first."""
    n = len(values)
    out: list[int] = []
    blocked = np.zeros(n, dtype=np.bool_)
    low = np.flatnonzero(values < below)
    if not len(low):
        return out
    inner = np.concatenate([[np.inf], np.asarray(values, dtype=np.float64), [np.inf]])
    minimum = (inner[1:-1] <= inner[:-2]) & (inner[1:-1] <= inner[2:])
    low = low[minimum[low]]
    for k in low[np.argsort(values[low], kind="stable")]:
        if not blocked[k]:
            out.append(int(k))
            blocked[max(0, k - apart) : k + apart + 1] = True
    return out
