"""Pooling by loops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]


def pool_maximum(matrix: Floats, size: int) -> Floats:
    """Every cell looked at in turn: bin b holds the frames f with b·n ≤ f·m + (m − 1 …), that is the greatest b ≤ f."""
    n = len(matrix)
    m = min(n, size)
    begins = [b * n // m for b in range(m)]
    out = np.full((m, m), -np.inf, dtype=np.float32)
    for i in range(n):
        for j in range(n):
            a = max(b for b in range(m) if begins[b] <= i)
            c = max(b for b in range(m) if begins[b] <= j)
            out[a, c] = max(out[a, c], matrix[i, j])
    return out


def triangle(matrix: Floats) -> Floats:
    """Cell (i, j), i ≤ j, goes to column (i + j) // 2 and row (j − i) // 2; the larger one wins."""
    n = len(matrix)
    out = np.zeros(((n + 1) // 2, n), dtype=np.float32)
    for i in range(n):
        for j in range(i, n):
            row, column = (j - i) // 2, (i + j) // 2
            out[row, column] = max(out[row, column], matrix[i, j])
    return out


def still_everywhere(distances: Floats, start: int, end: int, epsilon: float) -> bool:
    """Whether all pairs of moments in [start, end) are within epsilon."""
    return all(distances[i, j] <= epsilon for i in range(start, end) for j in range(start, end))
