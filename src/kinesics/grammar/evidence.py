"""Evidence for the symmetries of a movement: what each leaves over, against the movement's own range.

A residual is the mean D (or D*) along the path on which the symmetry would make it 0, less the sensor's noise, over 1.3 times
the mean D between all moments of the same window: 0 is exact, about 1 is what unrelated moments of the same movement give.
Windows are one period long and half a period apart, and medians over the windows decide, so that what is not of the cycle (a
hand raised before it waves) does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.grammar import lags, period
from kinesics.grammar.moments import Moments
from kinesics.grammar.ranges import RANGE, SWAY

Array = NDArray[np.float64]
Distances = NDArray[Any]

_CALM: Final = 0.03
"""A window with less than this share of the liveliest windows' range is still, and so is one with no more than `SWAY`."""
_CYCLING: Final = 0.35
"""Where the period leaves more than this in a window, the window is not of the cycle."""
_GLIDE_BAND: Final = 0.3
_NARROW: Final = 0.15
_RECURRED: Final = 0.3
"""A moment has its return when the residual of the period is below this."""
_CYCLES_COMPARED: Final = 12
_PHASES_COMPARED: Final = 12
_ONCE_MOMENTS: Final = 600
"""Moments of a movement made once that are compared all with all; of a longer one every other, third, … is taken."""
_FOLDED_POINTS: Final = 128
"""Points, the same way apart, at which a movement made once is compared with its own reverse;"""
_UNEVEN: Final = 0.1
"""and so much of the way may the two sides be apart: who comes back as he went travels the same way, at whatever speed."""
_FAR: Final = 4.0
"""No D is so large."""
_SPANS: Final = (1, 2, 3, 4, 6, 8)
_STANDS_OUT: Final = 6.0
_MARGIN: Final = 1.5
"""Times the noise is taken off: its mean square over three steps scatters by an eighth."""
_EDGE: Final = 0.01
"""Share of the way at either end of a movement that is left out as stillness."""


@dataclass(frozen=True)
class Residuals:
    """What each symmetry leaves over; None where it does not apply. The smaller, the better it holds."""

    period: float | None = None
    mirror: float | None = None
    """Mirrored at once."""
    glide: float | None = None
    """Mirrored after half a period."""
    reverse: float | None = None
    mirror_reverse: float | None = None


@dataclass(frozen=True, eq=False)
class CyclicEvidence:
    """What speaks for the symmetries of a movement that repeats itself."""

    residuals: Residuals
    path: lags.LagPath
    """From each moment of the stretch to the same one a period later."""
    period: float
    """Moments."""
    returns: NDArray[np.bool_]
    """For each moment of the path: whether it moves and returns a period later."""
    repeats: float
    """How many periods long the moving part is."""
    coverage: float
    """Share of the moving moments that return a period later."""
    unbroken: float
    """The same, between the first and the last moment that returns: what leads in and out is left aside."""
    period_s: float
    unity: float
    """Residual between cycles anywhere in the stretch: large where one cyclic movement follows another."""
    turn_speed: float | None
    """Speed at the best reversals over the mean speed: 0 at a true turning."""
    range: float
    """1.3 times the mean distance within windows: what residuals are measured against."""


@dataclass(frozen=True, eq=False)
class SingleEvidence:
    """What speaks for the symmetries of a movement made once."""

    residuals: Residuals
    start: int
    """First and last (exclusive) moment of the movement itself, within the stretch."""
    end: int
    turn_speed: float | None
    range: float


def cyclic(
    moments: Moments, start: int, end: int, by_lag: tuple[Distances, Distances], path: lags.LagPath
) -> CyclicEvidence:
    """Residuals of the symmetries of a cycle.

    Parameters
    ----------
    by_lag : D and D* of the stretch by lag (`Moments.by_lag`), up to a period at least.
    path : of the period (`kinesics.grammar.period.find`).
    """
    d, _ = by_lag
    tau, noise = float(np.mean(path.lags)), moments.noise
    windows = _windows(d, path, end - start, tau, noise)
    medians = _medians(windows, by_lag, path, tau, _without_noise(moments, start, end), noise)
    starts, width, ranges, still, cycling = windows
    local = np.interp(np.arange(len(path.costs)), starts + width / 2.0, ranges)
    returned = (path.costs - noise < _RECURRED * local) & (local > still)
    moving = _extent(moments, start, end)
    inside = np.zeros(len(path.costs), dtype=np.bool_)
    inside[moving[0] : moving[1]] = True
    moving_there = float((inside & (local > still)).sum())
    returned &= inside
    coverage = float(returned.sum()) / moving_there if moving_there else 0.0
    span = np.flatnonzero(returned)
    unbroken = float(returned[span[0] : span[-1] + 1].mean()) if len(span) else 0.0
    return CyclicEvidence(
        Residuals(medians["period"], medians["mirror"], medians["glide"], medians["reverse"], medians["both"]),
        path,
        tau,
        returned,
        (moving[1] - moving[0]) / tau,
        coverage,
        unbroken,
        tau / moments.fps,
        _unity(moments, start, path, moving, float(np.median(ranges[cycling]))),
        medians["turn"],
        float(np.median(ranges[cycling])),
    )


class _Windows(NamedTuple):
    """Stretches one period long, half a period apart."""

    starts: NDArray[np.intp]
    width: int
    ranges: Array
    """How far the movement ranges in each."""
    still: float
    """Range up to which one is still."""
    cycling: NDArray[np.bool_]
    """Whether each is of the cycle; where none is, whether it moves."""


def _windows(d: Distances, path: lags.LagPath, n: int, tau: float, noise: float) -> _Windows:
    width = min(n, max(3, round(tau)))
    starts = np.unique(
        np.linspace(0, n - width, max(1, int(np.ceil(2.0 * (n - width) / width)) + 1)).round().astype(np.intp)
    )
    ranges = np.array([RANGE * _window_mean(d, a, width) for a in starts])
    ranges = np.maximum(ranges - RANGE * noise, 1e-12)
    still = max(_CALM * float(np.quantile(ranges, 0.9)), min(SWAY, 0.5 * float(ranges.max())))
    held = np.array([_held(path.costs, a, width) for a in starts]) - noise
    cycling = (ranges > still) & (held < _CYCLING * ranges)
    return _Windows(starts, width, ranges, still, cycling if cycling.any() else ranges > still)


def _medians(
    windows: _Windows,
    by_lag: tuple[Distances, Distances],
    path: lags.LagPath,
    tau: float,
    speed: Array,
    noise: float,
) -> dict[str, float | None]:
    """What each symmetry leaves over in the median window, and the speed at the reversals; None where there is none."""
    d, mirrored = by_lag
    bend = lags.bend_cost(d)
    reach = max(2, round(tau / 2))
    glide = lags.follow(mirrored, tau / 2, bend=bend, band=_GLIDE_BAND)
    turning = lags.turning(d, reach, bend=bend).costs
    mirrored_turning = lags.turning(mirrored, reach, bend=bend).costs
    found: dict[str, list[float]] = {name: [] for name in ("period", "mirror", "glide", "reverse", "both", "turn")}
    for a, full in zip(windows.starts[windows.cycling], windows.ranges[windows.cycling], strict=True):
        b = a + windows.width

        def share(cost: float, full: float = float(full)) -> float:
            return max(cost - noise, 0.0) / full

        if a < len(path.costs):
            found["period"].append(share(float(path.costs[a:b].mean())))
        found["mirror"].append(share(float(mirrored[0][a:b].mean())))
        if glide is not None and a < len(glide.costs):
            found["glide"].append(share(float(glide.costs[a:b].mean())))
        places = turning[2 * a : 2 * b - 1]
        if np.isfinite(places).any():
            best = int(np.argmin(places))
            found["reverse"].append(share(float(places[best])))
            centre = a + best // 2
            found["turn"].append(_slowest(speed, centre) / max(float(speed[a + 1 : b].mean()), 1e-9))
        places = mirrored_turning[2 * a : 2 * b - 1]
        if np.isfinite(places).any():
            found["both"].append(share(float(places.min())))
    return {name: float(np.median(values)) if values else None for name, values in found.items()}


def _unity(moments: Moments, start: int, path: lags.LagPath, moving: tuple[int, int], scale: float) -> float:
    """Mean residual between the same phases of cycles that lie apart, of up to a dozen cycles spread over the stretch."""
    known = np.arange(len(path.lags))
    beginnings = [float(moving[0])]
    while True:
        length = float(np.interp(beginnings[-1], known, path.lags))
        if beginnings[-1] + 2.0 * length > moving[1] or len(beginnings) > moments.count:
            break
        beginnings.append(beginnings[-1] + length)
    # what leads into the cycles and out of them is not of them
    beginnings = [b for b in beginnings if _held(path.costs, int(b), round(path.lag)) < _CYCLING * scale]
    if len(beginnings) < 2:
        return 0.0
    chosen = np.array(beginnings)[np.unique(np.linspace(0, len(beginnings) - 1, _CYCLES_COMPARED).round().astype(int))]
    lengths = np.interp(chosen, known, path.lags)
    phases = np.arange(_PHASES_COMPARED) / _PHASES_COMPARED
    index = np.minimum((chosen[:, None] + phases * lengths[:, None]).round().astype(np.intp), moving[1] - 1)
    d, _ = moments.thinned(start + index.ravel())
    count = len(chosen)
    pairs = d.reshape(count, _PHASES_COMPARED, count, _PHASES_COMPARED)
    same_phase = np.einsum("ipjp->ij", pairs) / _PHASES_COMPARED
    return max(float(same_phase[np.triu_indices(count, 1)].mean()) - moments.noise, 0.0) / scale


def _held(costs: Array, start: int, width: int) -> float:
    """Mean cost of the period's path over a window, inf where it does not reach."""
    part = costs[start : start + width]
    return float(part.mean()) if len(part) else np.inf


def single(moments: Moments, start: int, end: int) -> SingleEvidence | None:
    """Residuals of the symmetries of a movement made once; None where nothing moves.

    Stillness before and after is left out, moments are weighted by the way travelled, and the whole is compared with its own
    reverse, by the way travelled and not by the clock, by dynamic time warping from both ends inwards.
    """
    n = end - start
    if n < 5:
        return None
    way = _way(moments, start, end)
    if way.sum() <= 0.0:
        return None
    a, b = _extent(moments, start, end)
    stride = -(-(b - a) // _ONCE_MOMENTS)
    index = np.arange(a, b, stride)
    if len(index) < 5:
        return None
    weight = np.array([part.sum() for part in np.split(way[a:b], index[1:] - a)])
    weight /= weight.sum()
    span = slice(start + a, start + b)
    if stride == 1:
        d, mirrored = moments.tile(span, span)
    else:
        d, mirrored = moments.thinned(index + start)
    pairs = d[np.triu_indices(len(index), 1)]
    full = float(np.quantile(pairs, 0.75)) - moments.noise
    if full <= 0.0:
        return None

    def residual(cost: float) -> float:
        return max(cost - moments.noise, 0.0) / full

    speed = _without_noise(moments, start, end)
    mean_speed = float((speed[index] * weight).sum())
    at_turn, (reverse, both) = _reversals(moments, start, way)
    return SingleEvidence(
        Residuals(
            mirror=residual(float((np.diagonal(mirrored) * weight).sum())),
            reverse=residual(reverse),
            mirror_reverse=residual(both),
        ),
        start=int(a),
        end=int(b),
        turn_speed=_slowest(speed, at_turn) / mean_speed if mean_speed > 0.0 else None,
        range=full,
    )


def _reversals(moments: Moments, start: int, way: Array) -> tuple[int, tuple[float, float]]:
    """Mean D of a stretch from its reverse, and D* from its mirrored reverse; and at which moment of it the former turns."""
    share = np.cumsum(way) / way.sum()
    points = np.linspace(_EDGE, 1.0 - _EDGE, _FOLDED_POINTS)
    index = np.minimum(np.searchsorted(share, points), len(way) - 1)
    there = np.arange(_FOLDED_POINTS)
    uneven = np.abs(there[:, None] + there[None, :] - (_FOLDED_POINTS - 1)) > _UNEVEN * _FOLDED_POINTS
    even = np.full(_FOLDED_POINTS, 1.0 / _FOLDED_POINTS)
    costs, centres = [], []
    for distances in moments.thinned(start + index):
        # not infinite: the compiled kernel adds these up, too
        cost, centre = folded(np.where(uneven, np.float32(_FAR), distances), even)
        costs.append(cost)
        centres.append(int(index[centre]))
    return centres[0], (costs[0], costs[1])


def _without_noise(moments: Moments, start: int, end: int) -> Array:
    """Speed without what the noise adds to it: squares are subtracted, averaged over three steps so that few fall below 0."""
    squared = moments.speed[start:end] ** 2
    smooth = np.convolve(np.pad(squared, 1, mode="edge"), np.ones(3) / 3.0, "valid")
    return np.sqrt(np.maximum(smooth - 2.0 * moments.noise * moments.fps**2, 0.0))


def _slowest(speed: Array, centre: int) -> float:
    return float(speed[max(0, centre - 2) : centre + 3].min())


def _way(moments: Moments, start: int, end: int) -> Array:
    """Way travelled in each step, without noise and without the crawling of the calmest tenth.

    Slow movement is smaller from one moment to the next than the noise; over several moments it is not, while the noise stays
    what it is: the shortest span is taken over which the livelier quarter of the stretch stands out.
    """
    n = end - start
    way = np.zeros(n)
    for span in (k for k in _SPANS if k < n):
        d = (
            0.5 * (moments.speed[start + 1 : end] / moments.fps) ** 2
            if span == 1
            else moments.d_by_lag(span, start, end)[span, : n - span].astype(np.float64)
        )
        smooth = np.convolve(np.pad(d, 1, mode="edge"), np.ones(3) / 3.0, "valid")
        first = (span + 1) // 2
        way[:] = 0.0
        way[first : first + len(d)] = np.sqrt(2.0 * np.maximum(smooth - _MARGIN * moments.noise, 0.0)) / span
        if float(np.quantile(d, 0.75)) > _STANDS_OUT * moments.noise:
            break
    if n > 1:
        crawl = min(float(np.quantile(way[1:], 0.1)), 0.1 * float(np.quantile(way[1:], 0.9)))
        way = np.maximum(way - 2.0 * crawl, 0.0)
    return way


def _extent(moments: Moments, start: int, end: int) -> tuple[int, int]:
    """First and last (exclusive) moment of the stretch between which nearly all of the way is travelled."""
    way = _way(moments, start, end)
    total = float(way.sum())
    if total <= 0.0:
        return 0, end - start
    share = np.cumsum(way) / total
    first = max(0, int(np.searchsorted(share, _EDGE)) - 2)
    last = min(end - start, int(np.searchsorted(share, 1.0 - _EDGE)) + 3)
    return first, last


def _window_mean(by_lag: Distances, start: int, width: int) -> float:
    """Mean distance between all moments of a window, from distances by lag; each with itself included, as 0."""
    width = min(width, len(by_lag) + 1, by_lag.shape[1] - start)
    total = 0.0
    for k in range(1, min(width, len(by_lag))):
        total += 2.0 * float(by_lag[k, start : start + width - k].sum())
    return total / (width * width)


def folded(distance: Distances, weight: Array) -> tuple[float, int]:
    """The cheapest path from (first, last) inwards to the identity axis, mean distance by way travelled; and where it ends."""
    n = len(distance)
    if compiled.wanted():
        return compiled.native.folded(np.ascontiguousarray(distance, dtype=np.float32), np.ascontiguousarray(weight))
    cells = distance[:, ::-1].astype(np.float64)  # (i from the front, j from the back)
    back = weight[::-1]
    cost = np.full((n, n), np.inf)
    cost[0, 0] = cells[0, 0] * (weight[0] + back[0])
    for s in range(1, n):
        i = np.arange(s + 1)
        j = s - i
        best = np.full(s + 1, np.inf)
        best[1:] = cost[i[1:] - 1, j[1:]] + cells[i[1:], j[1:]] * weight[i[1:]]
        best[:-1] = np.minimum(best[:-1], cost[i[:-1], j[:-1] - 1] + cells[i[:-1], j[:-1]] * back[j[:-1]])
        cost[i, j] = best
    i = np.arange(n)
    ends = cost[i, n - 1 - i]
    centre = int(np.argmin(ends))
    return float(ends[centre]), centre


def find_period(moments: Moments, start: int, end: int) -> tuple[Distances, lags.LagPath | None]:
    """D of the stretch by lag, and the path of the shortest period in it, if there is one."""
    most = period.longest_lag(end - start, moments.fps)
    by_lag = moments.d_by_lag(most, start, end)
    path = period.find(by_lag, shortest=max(3.0, period.SHORTEST_S * moments.fps))
    if path is not None:
        # the search looked from trial lags with a wide band; a narrow one about what it found reaches further
        path = lags.follow(by_lag, path.lag, bend=lags.bend_cost(by_lag), band=_NARROW) or path
    return by_lag, path
