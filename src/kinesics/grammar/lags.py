"""Paths of recurrence with tempo freedom: repetitions are never equally long ([Schultz2012] §3.2.3, §3.2.4).

Two kinds of path through the distances between moments:

- `follow`: near one lag, parallel to the identity axis. The movement is at t + lag what it was at t; the lag may drift.
- `turning`: out from the identity axis, at right angles to it. The movement after a centre is what it was before, backwards.

Both may bend (one side may go up to about twice as fast as the other); bending costs a little, so that noise does not
pull them about. Both read distances by lag, never all pairs: ``by_lag[k, i]`` is the distance of moments i and i + k, inf
beyond the end (`kinesics.grammar.moments.Moments.by_lag`, or `diagonals` of a matrix).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled

Array = NDArray[np.float64]
Distances = NDArray[Any]
"""float32 or float64."""

BAND: Final = 0.25
"""How far a lag may stray from the one it started with, as a share of it."""
_BEND_COST: Final = 0.02
"""Of the typical distance, for each moment that a path bends."""
_SAMPLED: Final = 200_000


@dataclass(frozen=True, eq=False)
class LagPath:
    """One valley followed along the diagonals."""

    lags: NDArray[np.intp]
    """Moments, for t = 0 … len − 1."""
    costs: Array
    """Distance between moment t and moment t + lag."""

    @property
    def lag(self) -> float:
        """Median lag, moments."""
        return float(np.median(self.lags))


@dataclass(frozen=True, eq=False)
class Turning:
    """For every place on the identity axis, in steps of half a moment, the best path at right angles to it."""

    costs: Array
    """Mean distance along the path, inf where it does not fit, shape (2n − 1,); entry c stands for the moment c/2."""


def bend_cost(by_lag: Distances) -> float:
    """What bending by a moment costs, in units of distance."""
    step = max(1, by_lag.size // _SAMPLED)
    sample = by_lag.ravel()[::step]
    return _BEND_COST * float(np.median(sample[np.isfinite(sample)]))


def diagonals(distance: Distances, most: int) -> Distances:
    """Row k holds the k-th diagonal, padded with inf. Shape (n, n) to (most + 1, n)."""
    n = len(distance)
    out = np.full((most + 1, n), np.inf, dtype=distance.dtype)
    for k in range(most + 1):
        out[k, : n - k] = np.diagonal(distance, k)
    return out


def follow(by_lag: Distances, lag: float, *, bend: float, band: float = BAND) -> LagPath | None:
    """The cheapest path near one lag; None where the recording is too short for it.

    Parameters
    ----------
    by_lag : distances, row k at lag k.
    lag : moments.
    bend : from `bend_cost`.
    band : how far the path may stray, as a share of ``lag``.
    """
    low, high = max(1, int(np.floor(lag * (1 - band)))), min(len(by_lag) - 1, int(np.ceil(lag * (1 + band))))
    length = by_lag.shape[1] - high
    if length < 3 or high < low:
        return None
    if compiled.wanted():
        path = np.empty(length, dtype=np.int64)
        compiled.native.cheapest_path(np.ascontiguousarray(by_lag, dtype=np.float32), low, high + 1 - low, bend, path)
        lags = path.astype(np.intp)
    else:
        lags = _cheapest(by_lag[low : high + 1, :length], bend)
    return LagPath(lags + low, by_lag[low + lags, np.arange(length)].astype(np.float64))


def _cheapest(rows: Distances, bend: float) -> NDArray[np.intp]:
    """Row of the cheapest path in each column, from left to right, at most one row up or down a step."""
    width, length = rows.shape
    columns = np.ascontiguousarray(rows.T, dtype=np.float64)
    total = columns[0].copy()
    came = np.zeros((length, width), dtype=np.int8)
    choices = np.full((3, width), np.inf)
    index = np.arange(width)
    for t in range(1, length):
        choices[0] = total
        choices[1, 1:] = total[:-1] + bend
        choices[2, :-1] = total[1:] + bend
        came[t] = choices.argmin(axis=0)
        total = columns[t] + choices[came[t], index]
    k = int(total.argmin())
    lags = np.empty(length, dtype=np.intp)
    for t in range(length - 1, -1, -1):
        lags[t] = k
        k += (0, -1, 1)[came[t, k]]
    return lags


def turning(by_lag: Distances, reach: int, *, bend: float) -> Turning:
    """The cheapest paths from the identity axis outwards, ``reach`` moments to either side on the average.

    Cell (i, j) has place i + j (twice its moment on the axis) and span j − i. A path takes steps of both at once (span + 2)
    or of one side alone (span + 1, place ± 1: one side goes faster).

    Parameters
    ----------
    by_lag : distances up to lag 2·reach at least (beyond the recording's end they count as inf).
    reach : moments.
    bend : from `bend_cost`.
    """
    n = by_lag.shape[1]
    costs = np.full(2 * n - 1, np.inf)
    if compiled.wanted():
        compiled.native.turning_costs(np.ascontiguousarray(by_lag, dtype=np.float32), reach, bend, costs)
        return Turning(costs)
    places = np.arange(2 * n - 1)

    def cells(span: int) -> Array:
        out = np.full(2 * n - 1, np.inf)
        if span < len(by_lag):
            # cell (i, i + span) has place 2i + span
            out[span : 2 * n - 1 - span : 2] = by_lag[span, : n - span]
        return out

    before, total = cells(0), cells(1)
    from_before, from_total = places.copy(), places.copy()
    for span in range(2, 2 * reach + 1):
        here = cells(span)
        straight = before + 2.0 * here  # two moments' worth of path
        left, right = np.full(2 * n - 1, np.inf), np.full(2 * n - 1, np.inf)
        left[1:] = total[:-1]
        right[:-1] = total[1:]
        options = np.stack([straight, left + here + bend, right + here + bend])
        best = options.argmin(axis=0)
        origin = np.stack([from_before, np.roll(from_total, 1), np.roll(from_total, -1)])
        before, from_before = total, from_total
        total, from_total = options[best, places], origin[best, places]
    for ends, origins in ((before, from_before), (total, from_total)):
        reached = np.isfinite(ends)
        np.minimum.at(costs, origins[reached], ends[reached] / (2 * reach + 1))
    return Turning(costs)
