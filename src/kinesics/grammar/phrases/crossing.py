"""The curve that phrases are read from, all recurrences that reach across each moment, and its hills."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar import lags
from kinesics.grammar.moments import Moments
from kinesics.grammar.ranges import STILL, range_of, spread

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

SCALES_S: Final = (0.4, 0.8, 1.6)
"""Half the length of the stretches compared, seconds."""
REACH_S: Final = 8.0
"""Recurrences are looked for so many seconds ahead: the longest cycle that makes one phrase by itself."""
CHANCE: Final = 0.4
"""Residual of a path from which on it counts for nothing."""
_VALLEY: Final = 0.3
"""A valley of the crossing curve parts two phrases when it falls below this share of the lower hill."""
_HILL: Final = 0.005
"""Least height of a hill, seconds²."""
_FOOT: Final = 0.05
"""Below this share of its height a hill has ended."""
_TOP: Final = 0.3
"""Above this share of its height is the core of a hill."""
_FURTHER: Final = 2.0
"""Recurrences this many times as far off as the nearest one do not count."""
_BLOCK: Final = 1024
"""Moments whose paths are followed at once."""


def _widths(fps: float) -> list[int]:
    return [max(2, round(s * fps)) for s in SCALES_S]


def reach_of_lags(fps: float) -> int:
    """Moments ahead of each that `crossing` needs the distances of."""
    # a path that runs backwards on one side starts as far out as it ends inside
    return round(REACH_S * fps) + 2 * max(_widths(fps)) + 2


def crossing(coarse: Moments, by_lag: tuple[Floats, Floats]) -> Array:
    """How much recurs across each moment, seconds², shape (moments,).

    Parameters
    ----------
    by_lag : D and D* of ``coarse`` up to `reach_of_lags` (`Moments.by_lag`).
    """
    n = coarse.count
    widths = [w for w in _widths(coarse.fps) if 2 * w + 1 < n]
    out = np.zeros(n)
    if not widths:
        return out
    strength = _near_ones(_recurrences(coarse, by_lag, widths))
    change = np.zeros(n + 1)
    change[:n] += strength.sum(axis=0, dtype=np.float64)
    lag, first = np.nonzero(strength)
    np.subtract.at(change, np.minimum(first + lag, n), strength[lag, first])
    return np.maximum(np.cumsum(change)[:n], 0.0) / coarse.fps**2


def _near_ones(strength: Floats) -> Floats:
    """Without recurrences much further off than the nearest ones: a movement done before and after another one is two phrases."""
    reach, n = strength.shape
    top = strength.max(axis=0)
    for k in range(reach):
        np.maximum(top[k:], strength[k, : n - k], out=top[k:])
    nearest = np.full(n, reach, dtype=np.intp)
    for k in range(reach - 1, 0, -1):
        row = strength[k, : n - k]
        nearest[: n - k][(row > 0.0) & (row >= 0.5 * top[: n - k])] = k
        nearest[k:][(row > 0.0) & (row >= 0.5 * top[k:])] = k
    for k in range(1, reach):
        strength[k, : n - k][k > _FURTHER * np.maximum(nearest[: n - k], nearest[k:])] = 0.0
    return strength


def _recurrences(coarse: Moments, by_lag: tuple[Floats, Floats], widths: Sequence[int]) -> Floats:
    """How strongly moment i recurs at i + k under any relation and at any scale, 0 to 1, shape (lags, n)."""
    n = coarse.count
    reach = min(round(REACH_S * coarse.fps), n - 1)
    bend = lags.bend_cost(by_lag[0])
    # the noise is in every distance, and is no movement: what moves by less than the noise does not count
    ranges = {w: range_of(coarse, spread(by_lag[0], w)) for w in widths}
    floor = 0.5 * STILL**2 + coarse.noise
    out = np.zeros((reach + 1, n), dtype=np.float32)
    for distance in by_lag:
        for backwards in (False, True):
            paths = paths_by_lag(distance, widths, bend, backwards=backwards)
            for w, cost in paths.items():
                span = ranges[w]
                scale = np.where(span > floor, np.sqrt(np.maximum(span, 0.0)), 0.0).astype(np.float32)
                for k in range(2 * w + 1, reach + 1):
                    size = scale[: n - k] * scale[k:]
                    share = np.maximum(cost[k, : n - k] - np.float32(coarse.noise), 0.0)
                    with np.errstate(divide="ignore", invalid="ignore"):
                        weight = 1.0 - share / (CHANCE * size)
                    weight[~(size > 0.0)] = 0.0
                    row = out[k, : n - k]
                    np.maximum(row, np.maximum(weight, 0.0) ** 2, out=row)
    return out


def paths_by_lag(distance: Floats, widths: Sequence[int], bend: float, *, backwards: bool) -> dict[int, Floats]:
    """Mean distance along the cheapest path through each pair (i, i + k), so many steps of i before and after it.

    Of the two halves the worse one counts: both must be alike, so that no stretch recurs that reaches into another phrase.

    With ``backwards`` one side runs backwards: the lag shrinks by two in a step, else it stays. It may change by one more or
    less in each step, at a cost: one side stands for a moment, or goes at double speed.
    """
    steps = ((0, 0.0), (1, bend), (-1, bend)) if not backwards else ((-2, 0.0), (-1, bend), (-3, bend))
    out = {w: np.empty_like(distance) for w in widths}
    n, halo = distance.shape[1], max(widths)
    for first in range(0, n, _BLOCK):
        # each step looks one moment further: a block with so many beside it fits into the cache, and knows all it needs
        low, high = max(0, first - halo), min(n, first + _BLOCK + halo)
        last = min(n, first + _BLOCK)
        cells = np.ascontiguousarray(distance[:, low:high])
        after, before = cells.copy(), cells.copy()
        scratch = np.empty_like(cells)
        for s in range(1, halo + 1):
            after = _extended(cells, after, [(k, 1, c) for k, c in steps], scratch)
            before = _extended(cells, before, [(-k, -1, c) for k, c in steps], scratch)
            if s in out:
                inner = slice(first - low, last - low)
                worse = np.maximum(after[:, inner], before[:, inner])
                np.divide(worse, np.float32(s + 1), out=out[s][:, first:last])
    return out


def _extended(distance: Floats, total: Floats, steps: Sequence[tuple[int, int, float]], scratch: Floats) -> Floats:
    """One step more: ``out[k, t] = distance[k, t] + min over steps of total[k + dk, t + dt] + cost``."""
    rows, n = distance.shape
    best = np.full_like(distance, np.inf)
    for dk, dt, cost in steps:
        k0, k1 = max(0, -dk), min(rows, rows - dk)
        t0, t1 = max(0, -dt), min(n, n - dt)
        there = np.add(total[k0 + dk : k1 + dk, t0 + dt : t1 + dt], np.float32(cost), out=scratch[k0:k1, t0:t1])
        np.minimum(best[k0:k1, t0:t1], there, out=best[k0:k1, t0:t1])
    best += distance
    return best


@dataclass(frozen=True)
class Hill:
    """A hill of the curve, moments [start, end)."""

    foot: tuple[int, int]
    top: tuple[int, int]


def hills(weight: Array) -> list[Hill]:
    """The hills that valleys part, in order."""
    out = []
    for top, members in _watersheds(weight):
        if top < _HILL:
            continue
        foot = [t for t in members if weight[t] > _FOOT * top]
        high = [t for t in members if weight[t] > _TOP * top]
        out.append(Hill((foot[0], foot[-1] + 1), (high[0], high[-1] + 1)))
    return sorted(out, key=lambda h: h.foot)


def _watersheds(weight: Array) -> list[tuple[float, list[int]]]:
    """Height and moments of each hill, low ones included.

    From above: each top grows; where two meet at a height above the share, the lower one joins the higher.
    """
    n = len(weight)
    owner = np.full(n, -1)
    top: dict[int, float] = {}
    parent: dict[int, int] = {}

    def root(k: int) -> int:
        while parent[k] != k:
            k = parent[k]
        return k

    for t in np.argsort(-weight, kind="stable"):
        height = weight[t]
        if height <= _HILL * 0.05:
            break
        near = {root(owner[s]) for s in (t - 1, t + 1) if 0 <= s < n and owner[s] >= 0}
        if not near:
            k = int(t)
            parent[k] = k
            top[k] = float(height)
        else:
            k, *lower = sorted(near, key=lambda r: (-top[r], r))
            for other in lower:
                if height > _VALLEY * top[other] or top[other] < _HILL:
                    parent[other] = k
        owner[t] = k
    groups: dict[int, list[int]] = {}
    for t in range(n):
        if owner[t] >= 0:
            groups.setdefault(root(owner[t]), []).append(t)
    return [(top[k], members) for k, members in groups.items()]
