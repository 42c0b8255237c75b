"""Slow and obvious: the cheapest way through all rows, over all ways written out one after the other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np


def ways(rows: int, columns: int, end: int) -> Iterator[list[tuple[int, int, int]]]:
    """All ways from the first row to (rows − 1, end): (row, column, rows it counts for), by steps (1, 1), (1, 2), (2, 1)."""

    def back(r: int, c: int) -> Iterator[list[tuple[int, int, int]]]:
        if r == 0:
            yield [(r, c, 1)]
            return
        for dr, dc in ((1, 1), (1, 2), (2, 1)):
            if r - dr >= 0 and c - dc >= 0:
                for way in back(r - dr, c - dc):
                    yield [*way, (r, c, dr)]

    yield from back(rows - 1, end)


def subsequence(tile: np.ndarray, bend: float) -> tuple[list[float], list[int]]:
    """Cheapest cost to each column of the last row, and the column that way began at; inf and −1 where there is none."""
    rows, n = tile.shape
    costs, starts = [], []
    for end in range(n):
        best, start = np.inf, -1
        for way in ways(rows, n, end):
            cost = 0.0
            for k, (r, c, weight) in enumerate(way):
                cost += weight * float(tile[r, c])
                if k and (r - way[k - 1][0], c - way[k - 1][1]) != (1, 1):
                    cost += bend
            if cost < best:
                best, start = cost, way[0][1]
        costs.append(best)
        starts.append(start)
    return costs, starts
