"""The map of known ground that a recording draws of itself (§3.5-3.6), and the moments on it where a state may be.

Moment by moment the movement is either where it has been before (the same or mirrored, forwards or backwards) or on new ground.
Where it leaves or joins known ground, where it stops, turns back or passes its own mirror image, it is marked: there a state may
be. What counts as near is judged from the recording itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.grammar.moments import Moments
from kinesics.progress import Progress

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

STOP_S: Final = 0.2
"""Seconds that make a stop."""
SYMMETRIC: Final = 0.005
"""A pose is symmetric up to this D*(a, a): 11° r.m.s. between left and right, as people reach who stand at ease. It is a fixed
angle, so that a person agrees by eye, whatever else the recording holds."""
PARTING_S: Final = 0.6
"""Seconds that two ways may take to part."""
_ROWS: Final = 128
_FOLLOWED: Final = 6
"""Known ground is followed without a leap while one moment further is at most so many places further."""
_SAMPLE: Final = 600
"""Moments that the thresholds are judged by."""
_NOISE_FACTOR: Final = 3.0
"""Two moments of one pose lie this many times the noise apart at most (a χ² with 45 degrees of freedom has no long tail)."""
_TURN_REACH: Final = 3.0
"""Seconds that a turning back may take to lead away from its centre."""

_UPPER: Final = 0.75
"""Quantile that says how far a movement goes and how far its repetitions are apart: robust, unlike the extremes."""
_FAR: Final = 0.25
"""Of the spread: so far off the movement has been away, and what comes near again is a repetition."""
_CLOSE: Final = 0.12
"""Of the spread: what comes back no closer is other movement, not a repetition;"""
_SHARE: Final = 0.1
"""and so much of a recording must come back for its precision to be known;"""
_UNREPEATED: Final = 0.03
"""else it is taken to be this share of the spread, as it is in exercises repeated with care."""
_LOOSER: Final = 1.5
"""Beyond the upper quartile of repetition: the rest of it;"""
_SAME_MOST: Final = 0.08
"""of the spread, at most, lest a careless body make one of all poses."""
_ROUNDING: Final = 5e-6
"""Ten times what single precision leaves between a moment and itself."""
_STATE: Final = (6.0, 0.15, 0.2, 1.5)
"""Moments of one state lie within so many times `same` of each other, for they are marked to either side of it; at least and
at most so much of the spread, lest few or many states be made of a few; and in any case within so many times `same`."""
_VISIT: Final = (4.0, 0.04, 0.15, 1.2)
"""The same of being in a state: nearer than a state is wide, for the distance is from its middle."""
_PATH: Final = (5.0, 0.025, 0.2, 3.0)
"""The same of two traversals of a path: tempo is warped away, but a way is less precise than the places it leads to."""
_AWAY: Final = 8.0
"""Times `same`, or `_FAR` of the spread: the movement has left."""
_CENTRED: Final = 4.0
_CENTRED_SHARE: Final = 0.04
"""D*(a, a) of a pose that the movement cannot tell from its mirror image: so many times `same`, or this share of the spread. It
makes a state symmetric only where D is not one of poses, and D* therefore no angle."""
_PRECISE: Final = 0.005
"""Of the spread: nobody tells two ways apart that differ so little."""


@dataclass(frozen=True)
class Nearness:
    """What counts as near in this recording, in units of D."""

    spread: float
    """Upper quartile of D between moments: how far the movement goes."""
    same: float
    """Moments of repeated movement are nearer than this."""
    state: float
    """Moments of one state lie within this of each other."""
    visit: float
    """The movement is in a state when it is nearer than this to its middle."""
    away: float
    """Beyond this the movement has left."""
    path: float
    """Mean distance, warped, of two traversals of one path."""
    symmetric: float
    """D*(a, a) of a symmetric state is no more than this."""
    centred: float
    """A pose of less D*(a, a) than this is no state together with one of much more."""
    precise: float
    """Within this two traversals are one path, however much nearer others are."""


@dataclass(frozen=True)
class _Precision:
    """How far a recording goes, and how precisely its body comes back."""

    spread: float
    recurring: float | None
    """Upper quartile of D to the nearest moment of another time; None where too little of it recurs to tell."""


def judge_nearness(moments: Moments, breaks: Sequence[int] = ()) -> Nearness:
    """What counts as near, from the data: how close repeated movement comes to itself, against how far movement goes.

    For a sample of moments the nearest other moment is sought, once the movement has been away in between. Where much of it
    recurs, the spread of these distances is that of repetition; what is left lies far off and does not matter.

    Each recording is judged by itself, and the longer half of them decides: how precisely a body repeats itself is seen where it
    does so, and that one recording resembles another, or is a copy of it, says nothing about that.

    Parameters
    ----------
    breaks : moments at which another recording begins.
    """
    parts = [moments.cut(a, b) for a, b in pairwise((0, *breaks, moments.count))]
    judged = [_precision(part) for part in parts]
    spread = _median([(j.spread, part.count) for j, part in zip(judged, parts, strict=True)]) or 1e-9
    # relative to the recording's own spread: a small exercise is repeated as well as a large one
    precise = [(j.recurring, p.count) for j, p in zip(judged, parts, strict=True) if j.recurring is not None]
    recurring = _median(precise) if precise else _UNREPEATED * spread
    floor = _NOISE_FACTOR * moments.noise
    same = max(floor, min(_LOOSER * recurring, _SAME_MOST * spread), _ROUNDING)

    centred = max(_CENTRED * same, _CENTRED_SHARE * spread)

    def between(times: float, least: float, most: float, at_least: float) -> float:
        return float(np.clip(times * same, least * spread, max(most * spread, at_least * same)))

    return Nearness(
        spread=spread,
        same=same,
        state=between(*_STATE),
        visit=between(*_VISIT),
        away=max(_AWAY * same, _FAR * spread),
        path=between(*_PATH),
        symmetric=centred if moments.poses is None else max(SYMMETRIC, floor),
        centred=centred if moments.poses is None else min(max(SYMMETRIC, floor), centred),
        precise=_PRECISE * spread,
    )


def _precision(moments: Moments) -> _Precision:
    n = moments.count
    sample = np.unique(np.linspace(0, n - 1, min(n, _SAMPLE)).round().astype(int))
    everything = np.arange(n)

    def rows() -> Iterator[tuple[int, Floats, Floats]]:
        # twice computed rather than kept: of an hour they would be half a gigabyte
        for first in range(0, len(sample), 64):
            part = sample[first : first + 64]
            yield from zip(part.tolist(), *moments.between(part, everything), strict=True)

    spreads = [float(np.quantile(d, _UPPER)) for _, d, _ in rows()]
    spread = float(np.median(spreads)) or 1e-9
    nearest: list[float] = []
    for t, d, s in rows():
        away = np.flatnonzero(d > _FAR * spread)
        after, before = away[away > t][:1], away[away < t][-1:]
        best = np.inf
        if len(after):
            best = min(best, deepest(d[after[0] :]))
        if len(before):
            best = min(best, deepest(d[: before[0] + 1]))
        if s[t] > _FAR * spread:
            best = min(best, deepest(s))
        nearest.append(best)
    close = np.array([v for v in nearest if v < _CLOSE * spread])
    recurs = len(close) >= _SHARE * len(sample)
    return _Precision(spread, float(np.quantile(close, _UPPER)) if recurs else None)


def _median(weighted: Sequence[tuple[float, int]]) -> float:
    """The median of values that count as often as they weigh; the mean of the two where half lies on either side."""
    ordered = sorted(weighted)
    values = np.array([v for v, _ in ordered])
    passed = np.cumsum([w for _, w in ordered])
    half = passed[-1] / 2
    return float((values[np.searchsorted(passed, half)] + values[np.searchsorted(passed, half, side="right")]) / 2)


def deepest(row: Floats) -> float:
    """Least distance, between the samples too: D is quadratic about its minimum."""
    k = int(row.argmin())
    if 0 < k < len(row) - 1:
        a, b, c = float(row[k - 1]), float(row[k]), float(row[k + 1])
        bend = a - 2 * b + c
        if bend > 1e-12:
            return max(0.0, b - (a - c) ** 2 / (8 * bend))
    return float(row[k])


def _valleys(row: Floats) -> Floats:
    """Each local minimum deepened to what it is between the samples."""
    if len(row) < 3:
        return row
    a, b, c = row[:-2], row[1:-1], row[2:]
    bend = a - 2 * b + c
    low = (b <= a) & (b <= c) & (bend > 1e-9)
    out = row.copy()
    out[1:-1][low] = np.maximum(b[low] - (a[low] - c[low]) ** 2 / (8 * bend[low]), 0)
    return out


@dataclass(frozen=True, eq=False)
class Ground:
    """For each moment: new ground, or the earlier moment where the movement was before."""

    new: NDArray[np.bool_]
    where: NDArray[np.int64]
    mirrored: NDArray[np.bool_]


def localise(moments: Moments, same: float, progress: Progress) -> Ground:
    """One pass through the recording: every moment is on known ground, or it becomes ground itself.

    Ground that the movement has not left yet is not known: a moment counts only after the movement has been far from it
    (four times the nearness) in between.
    """
    n = moments.count
    out = Ground(np.zeros(n, dtype=np.bool_), np.full(n, -1, dtype=np.int64), np.zeros(n, dtype=np.bool_))
    places = np.empty(n, dtype=np.int64)
    farthest = np.zeros(n, dtype=np.float32)
    step = compiled.native.localise if compiled.wanted() else _block
    count, last, last_mirrored = 0, -1, False
    for first in range(0, n, _ROWS):
        stop = min(first + _ROWS, n)
        progress(first / n, "comparing moments")
        here = np.arange(first, stop)
        d, s = moments.between(here, np.concatenate([places[:count], here]))
        count, last, last_mirrored = step(
            d, s, first, same, count, last, last_mirrored, places, farthest, out.new, out.where, out.mirrored
        )
    return out


def _block(
    d: Floats,
    s: Floats,
    first: int,
    same: float,
    count: int,
    last: int,
    last_mirrored: bool,
    places: NDArray[np.int64],
    farthest: Floats,
    new: NDArray[np.bool_],
    where: NDArray[np.int64],
    mirrored: NDArray[np.bool_],
) -> tuple[int, int, bool]:
    """Some moments further: d and s are between them and the places so far, then themselves. The compiled one is its equal."""
    before = count
    columns = np.empty(before + len(d), dtype=np.intp)
    columns[:before] = np.arange(before)
    for row, t in enumerate(range(first, first + len(d))):
        here = d[row, columns[:count]]
        np.maximum(farthest[:count], here, out=farthest[:count])
        left = farthest[:count] > 4 * same
        found, is_mirrored = -1, False
        if count and left.any():
            straight = np.where(left, _valleys(here), np.inf)
            image = np.where(left, _valleys(s[row, columns[:count]]), np.inf)
            if last >= 0:
                low = max(0, last - _FOLLOWED)
                part = (image if last_mirrored else straight)[low : last + _FOLLOWED + 1]
                k = int(part.argmin())
                if part[k] < same:
                    found, is_mirrored = low + k, last_mirrored
            if found < 0:
                i, k = int(straight.argmin()), int(image.argmin())
                if min(straight[i], image[k]) < same:
                    # where both fit, near a symmetric pose, the unmirrored one
                    found, is_mirrored = (i, False) if straight[i] <= image[k] + 0.2 * same else (k, True)
        new[t] = found < 0
        if found < 0:
            places[count] = t
            columns[count] = before + row
            farthest[count] = 0.0
            count += 1
        else:
            where[t] = places[found]
            mirrored[t] = is_mirrored
        last, last_mirrored = found, is_mirrored
    return count, last, last_mirrored


def _runs(place: Ground) -> Iterator[tuple[int, int]]:
    """Stretches [start, end) of new ground, or of known ground followed without a leap."""
    n = len(place.new)
    start = 0
    for t in range(1, n + 1):
        if t < n:
            if place.new[t] and place.new[t - 1]:
                continue
            if (
                not place.new[t]
                and not place.new[t - 1]
                and place.mirrored[t] == place.mirrored[t - 1]
                and abs(place.where[t] - place.where[t - 1]) <= _FOLLOWED
            ):
                continue
        yield start, t
        start = t


@dataclass(frozen=True)
class Mark:
    """A moment at which the movement may be in a state."""

    moment: int
    traced: bool
    """It stops, turns back or passes its mirror image there; else a way parts or joins."""


def all_marks(moments: Moments, near: Nearness, breaks: Sequence[int], progress: Progress) -> list[Mark]:
    """The marks of several recordings put one after the other: each one's own, and where it joins or leaves another's ground.

    Each draws its own map, so that its marks do not depend on which others are read with it, or in which order.
    """
    borders = (0, *breaks, moments.count)
    out: list[Mark] = []
    for number, (start, end) in enumerate(pairwise(borders)):

        def share(fraction: float, message: str = "", number: int = number) -> None:
            progress((number + fraction) / (len(borders) - 1), message)

        part = moments.cut(start, end)
        place = localise(part, near.same, share)
        meetings = [Mark(t, False) for t in _meetings(moments, start, end, breaks, near)]
        out += [Mark(start + m.moment, m.traced) for m in find_marks(part, place, near, meetings)]
    return out


def _meetings(moments: Moments, start: int, end: int, breaks: Sequence[int], near: Nearness) -> list[int]:
    """Moments, counted from ``start``, at which a recording joins and leaves ground of the others, the same or mirrored."""
    others = [np.arange(a, b) for a, b in pairwise((0, *breaks, moments.count)) if a != start]
    if not others:
        return []
    nearest = np.full(end - start, np.inf)
    for first in range(start, end, _ROWS):
        here = np.arange(first, min(first + _ROWS, end))
        for other in others:
            for block in moments.between(here, other):
                part = nearest[first - start : first - start + len(here)]
                np.minimum(part, _deepest_of_each(block), out=part)
    out: list[int] = []
    # gone when three times as far: noise must not part what goes along
    inside = np.concatenate([[False], nearest < 3 * near.same, [False]])
    edges = np.flatnonzero(inside[1:] != inside[:-1])
    for low, high in zip(edges[::2], edges[1::2], strict=True):
        met = low + np.flatnonzero(nearest[low:high] < near.same)
        if len(met):
            out += [int(t) for t in (met[0], met[-1]) if 0 < t < end - start - 1]
    return out


def _deepest_of_each(block: Floats) -> Array:
    """`deepest` of each row."""
    return np.array([deepest(row) for row in block])


def find_marks(moments: Moments, place: Ground, near: Nearness, meetings: Sequence[Mark] = ()) -> list[Mark]:
    """Moments at which the movement may be in a state: where ways part or join, where it stops, turns back, is symmetric.

    Parameters
    ----------
    meetings : where it joins or leaves ground of other recordings.
    """
    n = moments.count
    marks = [Mark(0, False), Mark(n - 1, False), *meetings]
    runs = list(_runs(place))
    marks += [Mark(start - 1, False) for start, _ in runs[1:]]
    for start, end in runs:
        if not place.new[start]:
            marks += [Mark(t, True) for t in _turns_on_ground(moments, place.where[start:end], start, near)]
    reach = min(n - 1, max(2, round(_TURN_REACH * moments.fps)))
    d = moments.d_by_lag(reach)
    marks += [Mark((a + b) // 2, True) for a, b in _stops(d, near, max(2, round(STOP_S * moments.fps)))]
    marks += [Mark(t, True) for t in _local_minima(moments.speed) if _turns_back(d, t, near)]
    marks += [Mark(t, True) for t in _symmetric_passages(moments, near) if _stands_alone(moments, t, near)]
    return _absorbed(moments, marks, near)


def _absorbed(moments: Moments, marks: list[Mark], near: Nearness) -> list[Mark]:
    """Leave out partings and joinings close before or after a stop or a turn: ways part slowly, and join early."""
    traced = sorted({m.moment for m in marks if m.traced})
    if not traced:
        return marks
    index = np.array(traced)
    reach = PARTING_S * moments.fps
    out = []
    for mark in marks:
        if not mark.traced:
            close = index[np.abs(index - mark.moment) <= reach]
            if len(close) and float(moments.between(np.array([mark.moment]), close)[0].min()) < 2 * near.state:
                continue
        out.append(mark)
    return out


def _symmetric_passages(moments: Moments, near: Nearness) -> list[int]:
    """Moments at which the movement goes through a pose that is its own mirror image (between the samples too)."""
    depths = _valleys(moments.symmetry.astype(np.float32))
    return [t for t in _local_minima(moments.symmetry) if depths[t] < near.same]


def _stands_alone(moments: Moments, t: int, near: Nearness) -> bool:
    """Whether a symmetric pose is passed, and not part of a symmetric movement: before the symmetry is lost on either side
    the movement does not get far, and then it is lost well.

    In a movement that is symmetric throughout no pose is a state for being so.
    """
    limit = max(6 * near.same, 0.1 * near.spread)
    values = moments.symmetry
    for step in (-1, 1):
        side = values[t::step]
        high = np.flatnonzero(side > limit)
        if not len(high) or (side[1 : high[0]] < values[t]).any():
            return False
        lost = t + step * int(np.argmax(side > 3 * near.same))
        if float(moments.between(np.array([t]), np.array([lost]))[0][0, 0]) > near.away:
            return False
    return True


def _local_minima(values: Array) -> list[int]:
    return [t for t in range(1, len(values) - 1) if values[t] <= values[t - 1] and values[t] < values[t + 1]]


def _turns_on_ground(moments: Moments, where: NDArray[np.intp], start: int, near: Nearness) -> list[int]:
    """Where the movement turns back on known ground."""
    out: list[int] = []
    direction, extreme, at = 0, int(where[0]), 0
    first = int(where[0])
    low = int(where.min())
    steps = np.arange(low, int(where.max()) + 1)
    to_first = moments.between(where[:1], steps)[0][0]

    def apart(a: int, b: int) -> bool:
        if a == first:
            return bool(to_first[b - low] > 4 * near.same)
        return bool(moments.between(np.array([a]), np.array([b]))[0][0, 0] > 4 * near.same)

    for k, place in enumerate(where.tolist()):
        step = place - extreme
        if direction == 0:
            if step and apart(first, place):
                direction, extreme, at = (1 if step > 0 else -1), place, k
            continue
        if step * direction > 0:
            extreme, at = place, k
        elif step and apart(extreme, place):
            out.append(start + at)
            direction, extreme, at = -direction, place, k
    return out


def _stops(d: Floats, near: Nearness, least: int) -> list[tuple[int, int]]:
    """Stretches in which the pose stays within a part of the nearness of its first moment."""
    out: list[tuple[int, int]] = []
    n = d.shape[1]
    t = 0
    while t < n - least:
        k = 1
        while k < len(d) and t + k < n and d[k, t] < 0.6 * near.same:
            k += 1
        if k - 1 >= least:
            out.append((t, t + k - 1))
            t += k
        else:
            t += 1
    return out


def _turns_back(d: Floats, centre: int, near: Nearness) -> bool:
    """Whether the movement after a moment is what it was before, backwards, until it is well away from it.

    ``d`` is by lag: d[k, t] is between moments t and t + k.
    """
    n = d.shape[1]
    i = j = centre
    while True:
        best, step = np.inf, (0, 0)
        for a, b in ((1, 1), (2, 1), (1, 2), (1, 0), (0, 1)):
            x, y = i - a, j + b
            if x >= 0 and y < n and y - x < len(d) and d[y - x, x] < best:
                best, step = float(d[y - x, x]), (a, b)
        if step == (0, 0) or best > near.same:
            return False
        i, j = i - step[0], j + step[1]
        if min(d[centre - i, i], d[j - centre, centre]) > near.away:
            return True
