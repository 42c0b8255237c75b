"""Two stretches laid along one another with tempo freedom: the cheapest paths through the distances of their moments.

Each step goes on by one row and one column, one row and two columns, or two rows and one column, so that the tempo stays between
half and double.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled

Array = NDArray[np.float64]
Floats = NDArray[np.float32]


def seed_costs(tile: Floats, bend: np.float32, *, backwards: bool) -> Floats:
    """Mean distance along the cheapest path of all rows that passes the middle row at each column, the worse half.

    Shape (columns,).

    Parameters
    ----------
    tile : distances of a stretch (an odd number of rows) and all moments, shape (rows, columns).
    bend : what it costs to go by no column or by two in place of one.
    backwards : the columns run backwards.
    """
    if compiled.wanted():
        out = np.empty(tile.shape[1], dtype=np.float32)
        compiled.native.seed_costs(np.ascontiguousarray(tile), float(bend), backwards, out)
        return out
    half = len(tile) // 2
    sides = []
    for direction in (1, -1):
        run = np.zeros(tile.shape[1], dtype=np.float32)
        towards = -direction if backwards else direction
        for s in range(half, 0, -1):
            run = run + tile[half + direction * s]
            best = run + bend
            _lower(best, run, towards, 0.0)
            _lower(best, run, 2 * towards, bend)
            # beyond the recording there is nothing
            edge = slice(-1, None) if towards > 0 else slice(0, 1)
            best[edge] = np.inf
            run = best
        sides.append((run + tile[half]) / np.float32(half + 1))
    worse: Floats = np.maximum(*sides)
    return worse


def _lower(best: Floats, run: Floats, shift: int, cost: float | np.float32) -> None:
    """``best[j] = min(best[j], run[j + shift] + cost)``."""
    k = abs(shift)
    if k >= len(run):
        return
    here, there = (slice(None, -k), slice(k, None)) if shift > 0 else (slice(k, None), slice(None, -k))
    np.minimum(best[here], run[there] + np.float32(cost), out=best[here])


def advance(total: Array, before: Array, gain: Array, bend: float) -> Array:
    """Gains of paths one row further: from one row and one column back, one row and two columns, or two rows and one column.

    Parameters
    ----------
    total, before : greatest gains of the paths that end at each column of the last row and of the one before it, shape (columns,).
    gain : of each column of the row that is reached, of as many columns as any path can reach there.
    bend : what a step costs that is not of one row and one column.
    """
    m = len(gain)
    best = np.full(len(total), -np.inf)
    best[1:m] = total[: m - 1]
    np.maximum(best[2:m], total[: m - 2] - bend, out=best[2:m])
    np.maximum(best[1:m], before[: m - 1] - bend, out=best[1:m])
    best[:m] += gain
    return best


def subsequence(tile: Floats, bend: float, *, backwards: bool = False) -> tuple[Floats, NDArray[np.intp]]:
    """The cheapest way through all rows that ends at each column: summed distance, and the column it began at.

    Two of shape (columns,). Each step goes on by one row and one column, one row and two columns, or two rows and one column (the
    row between counts as much as the one that is reached), so that the tempo stays between half and double. With ``backwards``
    the last row comes first.
    """
    rows, n = tile.shape
    if compiled.wanted():
        totals, starts = np.empty(n, dtype=np.float32), np.empty(n, dtype=np.int64)
        compiled.native.subsequence(np.ascontiguousarray(tile), backwards, bend, totals, starts)
        return totals, starts
    tile = tile[::-1] if backwards else tile
    cost = np.float32(bend)
    total, start = tile[0].copy(), np.arange(n)
    before, before_start = np.full(n, np.inf, dtype=np.float32), start
    for r in range(1, rows):
        here = tile[r]
        now = np.full(n, np.inf, dtype=np.float32)
        now[1:] = total[:-1] + here[1:]
        origin = np.concatenate([start[:1], start[:-1]])
        other = total[:-2] + here[2:] + cost
        lower = other < now[2:]
        now[2:][lower] = other[lower]
        origin[2:][lower] = start[:-2][lower]
        other = before[:-1] + np.float32(2.0) * here[1:] + cost
        lower = other < now[1:]
        now[1:][lower] = other[lower]
        origin[1:][lower] = before_start[:-1][lower]
        before, before_start, total, start = total, start, now, origin
    return total, start


def cheapest_path(tile: Floats, bend: float) -> list[tuple[int, int]]:
    """Rows and columns of the cheapest way through all rows, with the steps of `subsequence`; ends may be free by an eighth."""
    rows, n = tile.shape
    total = np.full((rows, n), np.inf)
    came = np.zeros((rows, n), dtype=np.int8)
    total[0, : max(1, n // 8)] = tile[0, : max(1, n // 8)]
    if rows > 1:
        total[1, :1] = tile[1, :1] * 2.0
    for r in range(1, rows):
        options = np.full((3, n), np.inf)
        options[0, 1:] = total[r - 1, :-1] + tile[r, 1:]
        options[1, 2:] = total[r - 1, :-2] + tile[r, 2:] + bend
        if r > 1:
            options[2, 1:] = total[r - 2, :-1] + 2.0 * tile[r, 1:] + bend
        best = options.argmin(axis=0)
        value = options[best, np.arange(n)]
        better = value < total[r]
        total[r][better] = value[better]
        came[r] = np.where(better, best + 1, 0)
    ends = total[-1, n - max(1, n // 8) :]
    r, c = rows - 1, n - max(1, n // 8) + int(ends.argmin())
    if not np.isfinite(total[r, c]):
        # too unequal for the steps: a straight line
        return [(round(k * (rows - 1) / max(n - 1, 1)), k) for k in range(n)]
    out = [(r, c)]
    while came[r, c]:
        dr, dc = ((1, 1), (1, 2), (2, 1))[came[r, c] - 1]
        r, c = r - dr, c - dc
        out.append((r, c))
    return out[::-1]
