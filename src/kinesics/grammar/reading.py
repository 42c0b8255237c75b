"""The motion graph read from a recording (§3.5-3.6): which moments are states, which stretches are the same path.

The dissertation drew its graphs by eye. Here the recording draws a map of itself: moment by moment it is either where it has
been before (the same or mirrored, forwards or backwards) or on new ground. Where it leaves or joins known ground, where it
stops, turns back or passes its own mirror image, there is a state. Moments of state that lie together under D, or under D*,
are one state or a mirrored pair; the stretches between are compared with each other with tempo freedom and merged.

A state that leaves no trace (one way in, one way out, no stop, no turning back, not symmetric) is none.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar.cyclic import Cyclic
from kinesics.grammar.moments import Moments
from kinesics.progress import Progress, silent

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

BREAK: Final = -1
"""In place of a path, between the last visit of one recording and the first of the next."""
_ROWS: Final = 128
_SAMPLE: Final = 600
"""Moments that the thresholds are judged by."""
_NOISE_FACTOR: Final = 3.0
"""Two moments of one pose lie this many times the noise apart at most (a χ² with 45 degrees of freedom has no long tail)."""
_TURN_REACH: Final = 3.0
"""Seconds that a turning back may take to lead away from its centre."""
_STILL: Final = 0.2
"""Seconds that make a stop."""
_PARTING: Final = 0.6
"""Seconds that two ways may take to part."""


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


class Visit(NamedTuple):
    """The movement is in a state."""

    start: int
    end: int
    """Exclusive."""
    at: int
    """The moment nearest to the state."""
    state: int
    mirrored: bool


@dataclass(frozen=True)
class Traversal:
    """A stretch between two visits, as one of the paths."""

    start: int
    end: int
    path: int
    """-1 where one recording ends and the next begins between the visits."""
    reversed: bool
    mirrored: bool


@dataclass(frozen=True)
class ReadState:
    """A state, up to its mirror image."""

    moment: int
    """A moment at which the movement is in it, unmirrored."""
    symmetric: bool
    traced: bool
    """Whether the movement stops or turns back there."""


@dataclass(frozen=True)
class ReadPath:
    """A path, up to its mirror image; its first traversal runs forwards and unmirrored."""

    from_: tuple[int, bool]
    """State, and whether its mirror image."""
    to: tuple[int, bool]
    symmetric: bool | None = None
    """Whether it is symmetric throughout, where the class of a cyclic movement tells."""


@dataclass(frozen=True)
class Reading:
    """States, paths, and the recording as a string of them."""

    states: tuple[ReadState, ...]
    paths: tuple[ReadPath, ...]
    visits: tuple[Visit, ...]
    traversals: tuple[Traversal, ...]
    """One fewer than visits."""
    nearness: Nearness
    leads: Mapping[int, Traversal] = field(default_factory=dict)
    """By visit: where a recording begins on the way of a cyclic movement, the path to its first visit, begun before."""
    tails: Mapping[int, Traversal] = field(default_factory=dict)
    """By visit: where a recording ends on the way of a cyclic movement, the path from its last visit, not ended."""


def judge_nearness(moments: Moments) -> Nearness:
    """What counts as near, from the data: how close repeated movement comes to itself, against how far movement goes.

    For a sample of moments the nearest other moment is sought, once the movement has been away in between. Where much of it
    recurs, the spread of these distances is that of repetition; what is left lies far off and does not matter.
    """
    n = moments.count
    sample = np.unique(np.linspace(0, n - 1, min(n, _SAMPLE)).round().astype(int))
    rows: list[tuple[int, Floats, Floats]] = []
    for first in range(0, len(sample), 64):
        part = sample[first : first + 64]
        rows += zip(part.tolist(), *_between(moments, part, np.arange(n)), strict=True)
    nearest: list[float] = []
    spreads = [float(np.quantile(d, 0.75)) for _, d, _ in rows]
    spread = float(np.median(spreads)) or 1e-9
    for t, d, s in rows:
        away = np.flatnonzero(d > 0.25 * spread)
        after, before = away[away > t][:1], away[away < t][-1:]
        best = np.inf
        if len(after):
            best = min(best, _deepest(d[after[0] :]))
        if len(before):
            best = min(best, _deepest(d[: before[0] + 1]))
        if s[t] > 0.25 * spread:
            best = min(best, _deepest(s))
        nearest.append(best)
    close = np.array([v for v in nearest if v < 0.12 * spread])
    recurring = float(np.quantile(close, 0.75)) if len(close) >= 0.1 * len(sample) else 0.03 * spread
    floor = _NOISE_FACTOR * moments.noise
    same = max(floor, min(1.5 * recurring, 0.08 * spread), 5e-6)
    return Nearness(
        spread=spread,
        same=same,
        state=float(np.clip(6.0 * same, 0.15 * spread, max(0.2 * spread, 1.5 * same))),
        visit=float(np.clip(4.0 * same, 0.04 * spread, max(0.15 * spread, 1.2 * same))),
        away=max(8.0 * same, 0.25 * spread),
        path=float(np.clip(5.0 * same, 0.06 * spread, max(0.2 * spread, 3.0 * same))),
    )


def _deepest(row: Floats) -> float:
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
class _Localised:
    """For each moment: new ground, or the earlier moment where the movement was before."""

    new: NDArray[np.bool_]
    where: NDArray[np.intp]
    mirrored: NDArray[np.bool_]


def _localise(moments: Moments, same: float, progress: Progress) -> _Localised:
    """One pass through the recording: every moment is on known ground, or it becomes ground itself.

    Ground that the movement has not left yet is not known: a moment counts only after the movement has been far from it
    (four times the nearness) in between.
    """
    n = moments.count
    new = np.zeros(n, dtype=np.bool_)
    where = np.full(n, -1, dtype=np.intp)
    mirrored = np.zeros(n, dtype=np.bool_)
    ground = np.empty(n, dtype=np.intp)
    farthest = np.zeros(n, dtype=np.float32)
    count = 0
    last: tuple[int, bool] | None = None  # place on the ground (index into ``ground``) and mirrored
    for first in range(0, n, _ROWS):
        stop = min(first + _ROWS, n)
        progress(first / n, "comparing moments")
        d_rows, s_rows = moments.tile(slice(first, stop), slice(0, stop))
        for t in range(first, stop):
            places = ground[:count]
            d = d_rows[t - first, places]
            np.maximum(farthest[:count], d, out=farthest[:count])
            left = farthest[:count] > 4 * same
            found: tuple[int, bool] | None = None
            if count and left.any():
                d = np.where(left, _valleys(d), np.inf)
                s = np.where(left, _valleys(s_rows[t - first, places]), np.inf)
                if last is not None:
                    low = max(0, last[0] - 6)
                    part = (s if last[1] else d)[low : last[0] + 7]
                    k = int(part.argmin())
                    if part[k] < same:
                        found = (low + k, last[1])
                if found is None:
                    i, k = int(d.argmin()), int(s.argmin())
                    if min(d[i], s[k]) < same:
                        # where both fit, near a symmetric pose, the unmirrored one
                        found = (i, False) if d[i] <= s[k] + 0.2 * same else (k, True)
            last = found
            if found is None:
                new[t] = True
                ground[count] = t
                farthest[count] = 0.0
                count += 1
            else:
                where[t] = ground[found[0]]
                mirrored[t] = found[1]
    return _Localised(new, where, mirrored)


def _runs(place: _Localised) -> Iterator[tuple[int, int]]:
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
                and abs(place.where[t] - place.where[t - 1]) <= 6
            ):
                continue
        yield start, t
        start = t


@dataclass(frozen=True)
class _Mark:
    """A moment at which the movement may be in a state."""

    moment: int
    traced: bool
    """It stops, turns back or passes its mirror image there; else a way parts or joins."""


def _marks(moments: Moments, place: _Localised, near: Nearness, breaks: Sequence[int]) -> list[_Mark]:
    n = moments.count
    marks = [_Mark(0, False), _Mark(n - 1, False)]
    runs = list(_runs(place))
    marks += [_Mark(start - 1, False) for start, _ in runs[1:]]
    for start, end in runs:
        if not place.new[start]:
            marks += [_Mark(t, True) for t in _turns_on_ground(moments, place.where[start:end], start, near)]
    reach = min(n - 1, max(2, round(_TURN_REACH * moments.fps)))
    d, _ = moments.by_lag(reach)
    marks += [_Mark((a + b) // 2, True) for a, b in _stops(d, near, max(2, round(_STILL * moments.fps)))]
    slow = _local_minima(moments.speed)
    slow = [t for t in slow if all(abs(t - b) > 1 for b in breaks)]
    marks += [_Mark(t, True) for t in slow if _turns_back(d, t, near)]
    marks += [_Mark(t, True) for t in _symmetric_passages(moments, near) if _stands_alone(moments, t, near)]
    return _absorbed(moments, marks, near)


def _absorbed(moments: Moments, marks: list[_Mark], near: Nearness) -> list[_Mark]:
    """Leave out partings and joinings close before or after a stop or a turn: ways part slowly, and join early."""
    traced = sorted({m.moment for m in marks if m.traced})
    if not traced:
        return marks
    index = np.array(traced)
    reach = _PARTING * moments.fps
    out = []
    for mark in marks:
        if not mark.traced:
            close = index[np.abs(index - mark.moment) <= reach]
            if len(close) and float(_between(moments, np.array([mark.moment]), close)[0].min()) < 2 * near.state:
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
        if float(_between(moments, np.array([t]), np.array([lost]))[0][0, 0]) > near.away:
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
    to_first = _between(moments, where[:1], steps)[0][0]

    def apart(a: int, b: int) -> bool:
        if a == first:
            return bool(to_first[b - low] > 4 * near.same)
        return bool(_between(moments, np.array([a]), np.array([b]))[0][0, 0] > 4 * near.same)

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


def _cluster(moments: Moments, marks: Sequence[_Mark], radius: float) -> list[list[_Mark]]:
    """Marks that lie together under D or D*: complete linkage of √(2D)."""
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import squareform

    index = np.array([m.moment for m in marks])
    if len(index) == 1:
        return [list(marks)]
    d, s = _between(moments, index, index)
    chords = np.sqrt(2.0 * np.maximum(np.minimum(d, s), 0.0)).astype(np.float64)
    chords = (chords + chords.T) / 2
    np.fill_diagonal(chords, 0.0)
    labels = fcluster(linkage(squareform(chords, checks=False), "complete"), np.sqrt(2.0 * radius), "distance")
    groups: dict[int, list[_Mark]] = {}
    for mark, label in zip(marks, labels.tolist(), strict=True):
        groups.setdefault(label, []).append(mark)
    return sorted(groups.values(), key=lambda g: min(m.moment for m in g))


def _between(moments: Moments, rows: NDArray[np.intp], cols: NDArray[np.intp]) -> tuple[Floats, Floats]:
    """D and D* between two lists of moments."""
    if moments.dense is not None:
        return moments.dense[0][np.ix_(rows, cols)], moments.dense[1][np.ix_(rows, cols)]
    from kinesics.similarity import distance, mirror_distance

    assert moments.poses is not None
    q = moments.poses.quaternions
    return distance(q[rows], q[cols], moments.weights), mirror_distance(q[rows], q[cols], moments.weights)


def _state_of(moments: Moments, group: Sequence[_Mark], near: Nearness) -> ReadState:
    """The middle of a cluster, of its traced moments where there are any."""
    traced = [m for m in group if m.traced]
    middle = np.array([m.moment for m in (traced or group)])
    every = np.array([m.moment for m in group])
    d, s = _between(moments, middle, every)
    moment = int(middle[np.minimum(d, s).mean(axis=1).argmin()])
    symmetric = float(np.median(moments.symmetry[middle])) < max(4 * near.same, 0.04 * near.spread)
    return ReadState(moment, symmetric, bool(traced))


def _refined(moments: Moments, states: Sequence[ReadState], near: Nearness) -> list[ReadState]:
    """States that are only passed, put where the ways cross: at the moment near by that most passages come closest to.

    Ways join early and part late, so the marks lie to either side of the state.
    """
    reach = max(1, round(_PARTING * moments.fps))
    out = []
    for state in states:
        if state.traced:
            out.append(state)
            continue
        around = np.arange(max(0, state.moment - reach), min(moments.count, state.moment + reach + 1))
        d, s = _between(moments, np.arange(moments.count), around)
        close = _between(moments, np.array([state.moment]), around)[0][0] < near.state
        exact = max(near.same, 0.005 * near.spread)
        best = (0, -np.inf)
        moment = state.moment
        for column in np.flatnonzero(close).tolist():
            depths = [
                _deepest(row[start:end])
                for row in (d[:, column], s[:, column])
                for start, end in _below(row, near.visit)
            ]
            through = [x for x in depths if x < exact]
            score = (len(through), -float(np.mean(through)) if through else -np.inf)
            if score > best:
                best, moment = score, int(around[column])
        out.append(ReadState(moment, state.symmetric, False))
    return _distinct(moments, out, near)


def _distinct(moments: Moments, states: Sequence[ReadState], near: Nearness) -> list[ReadState]:
    """Of states that have come to lie in one place, the first traced one, else the first."""
    index = np.array([s.moment for s in states], dtype=np.intp)
    d, s = _between(moments, index, index)
    apart = np.minimum(d, s)
    kept: list[int] = []
    for k in sorted(range(len(states)), key=lambda k: (not states[k].traced, states[k].moment)):
        if all(apart[k, o] >= 2 * near.visit for o in kept):
            kept.append(k)
    return [states[k] for k in sorted(kept)]


def _split(stretches: Iterable[tuple[int, int]], breaks: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Cut stretches where another recording begins."""
    for start, end in stretches:
        borders = [start, *(b for b in breaks if start < b < end), end]
        yield from pairwise(borders)


def _below(row: Floats, limit: float) -> list[tuple[int, int]]:
    inside = np.concatenate([[False], row < limit, [False]])
    edges = np.flatnonzero(inside[1:] != inside[:-1])
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _visits(moments: Moments, states: Sequence[ReadState], radius: float, breaks: Sequence[int]) -> list[Visit]:
    """All times at which the movement is in a state; where two claim it, the nearer one's."""
    index = np.array([s.moment for s in states], dtype=np.intp)
    d, s = _between(moments, np.arange(moments.count), index)
    found: list[tuple[Visit, float]] = []
    for k, state in enumerate(states):
        for is_mirrored, row in ((False, d[:, k]), (True, s[:, k])):
            if is_mirrored and state.symmetric:
                continue
            # in at the radius, out at three times it: noise must not make two visits of one
            for start, end in _split(_below(row, 3 * radius), breaks):
                at = start + int(row[start:end].argmin())
                if row[at] < radius:
                    near = np.flatnonzero(row[start:end] < radius)
                    found.append(
                        (Visit(start + int(near[0]), start + int(near[-1]) + 1, at, k, is_mirrored), float(row[at]))
                    )
    found.sort(key=lambda v: (v[0].at, v[1]))
    out: list[tuple[Visit, float]] = []
    for visit, depth in found:
        if out and visit.start < out[-1][0].end:
            before, its_depth = out[-1]
            if (before.state, before.mirrored) == (visit.state, visit.mirrored):
                continue
            if visit.at - before.at >= 3:
                border = (before.at + visit.at + 1) // 2
                out[-1] = (before._replace(end=min(before.end, border)), its_depth)
                out.append((visit._replace(start=max(visit.start, border)), depth))
                continue
            if depth < its_depth:
                out[-1] = (visit, depth)
            continue
        out.append((visit, depth))
    return [v for v, _ in out]


_POINTS: Final = 24


def _warped(blocks: Floats) -> Array:
    """Mean distance along the best monotone way from corner to corner, for many square blocks at once. (b, p, p) to (b,)."""
    count, p, _ = blocks.shape
    total = np.full((count, p + 1, p + 1), np.inf)
    total[:, 0, 0] = 0.0
    for i in range(p):
        for j in range(p):
            here = blocks[:, i, j]
            total[:, i + 1, j + 1] = here + np.minimum(
                total[:, i, j] + here, np.minimum(total[:, i, j + 1], total[:, i + 1, j])
            )
    return np.asarray(total[:, p, p] / (2 * p))


def _traverse(
    moments: Moments,
    states: Sequence[ReadState],
    visits: Sequence[Visit],
    near: Nearness,
    keys: Mapping[int, tuple[tuple[int, int, int], bool, bool]],
    symmetric: Mapping[int, bool],
    breaks: Sequence[int],
) -> tuple[list[ReadPath], list[Traversal]]:
    """The stretches between visits, equal ones merged: the same, reversed, mirrored or both.

    Where the class of a cyclic movement tells which path a stretch is (``keys``), its first occurrence alone is compared.
    """
    known: dict[tuple[int, int, int], Traversal] = {}
    paths: list[ReadPath] = []
    shapes: list[NDArray[np.intp]] = []
    out: list[Traversal] = []

    def image(end: tuple[int, bool]) -> tuple[int, bool]:
        return end if states[end[0]].symmetric else (end[0], not end[1])

    def note(number: int, path: int, backwards: bool, mirrored: bool) -> Traversal:
        a, b = visits[number], visits[number + 1]
        taken = Traversal(a.at, b.at, path, backwards, mirrored)
        if number in keys:
            key, way_back, way_mirrored = keys[number]
            known.setdefault(key, Traversal(a.at, b.at, path, backwards != way_back, mirrored != way_mirrored))
        return taken

    for number, (a, b) in enumerate(pairwise(visits)):
        if any(a.at < border <= b.at for border in breaks):
            out.append(Traversal(a.at, b.at, BREAK, False, False))
            continue
        if number in keys and keys[number][0] in known:
            key, way_back, way_mirrored = keys[number]
            model = known[key]
            out.append(note(number, model.path, model.reversed != way_back, model.mirrored != way_mirrored))
            continue
        here, there = (a.state, a.mirrored), (b.state, b.mirrored)
        points = np.linspace(a.at, b.at, _POINTS).round().astype(np.intp)
        trials: list[tuple[int, bool, bool]] = []
        blocks: list[Floats] = []
        for k, path in enumerate(paths):
            relations = [
                (reverse, mirror)
                for reverse, mirror, ends in (
                    (False, False, (path.from_, path.to)),
                    (True, False, (path.to, path.from_)),
                    (False, True, (image(path.from_), image(path.to))),
                    (True, True, (image(path.to), image(path.from_))),
                )
                if ends == (here, there)
            ]
            if relations:
                d, s = _between(moments, points, shapes[k])
                for reverse, mirror in relations:
                    block = s if mirror else d
                    trials.append((k, reverse, mirror))
                    blocks.append(block[:, ::-1] if reverse else block)
        if blocks:
            costs = _warped(np.stack(blocks))
            best = int(costs.argmin())
            if costs[best] < near.path:
                k, reverse, mirror = trials[best]
                out.append(note(number, k, reverse, mirror))
                continue
        told = symmetric.get(keys[number][0][0]) if number in keys else None
        paths.append(ReadPath(here, there, told))
        shapes.append(points)
        out.append(note(number, len(paths) - 1, False, False))
    return paths, out


def _traceless(states: Sequence[ReadState], visits: Sequence[Visit], traversals: Sequence[Traversal]) -> set[int]:
    """States with one way in and one way out, no stop, no turning back, not symmetric."""
    ways: dict[int, set[frozenset[tuple[int, bool, bool]]]] = {k: set() for k in range(len(states))}
    ends: dict[int, set[tuple[int, bool, bool]]] = {k: set() for k in range(len(states))}
    for visit, before, after in zip(visits[1:-1], traversals[:-1], traversals[1:], strict=True):
        if BREAK in (before.path, after.path):
            # where a recording begins or ends the state shows
            ends[visit.state].add((BREAK, False, False))
            continue
        # an end of a path: which path, which of its ends, and on which side of the mirror, seen from the unmirrored state
        arriving = (before.path, not before.reversed, before.mirrored != visit.mirrored)
        leaving = (after.path, after.reversed, after.mirrored != visit.mirrored)
        ways[visit.state].add(frozenset((arriving, leaving)))
        ends[visit.state].update((arriving, leaving))
    return {
        k
        for k, state in enumerate(states)
        if not state.traced and not state.symmetric and len(ends[k]) == 2 and len(ways[k]) == 1
    }


def held(moments: Moments, reading: Reading) -> list[tuple[int, int] | None]:
    """For each visit the stretch [start, end) in which the pose is held, or None."""
    least = max(2, round(_STILL * moments.fps))
    out: list[tuple[int, int] | None] = []
    for visit in reading.visits:
        around = np.arange(visit.start, visit.end)
        near = _between(moments, np.array([visit.at]), around)[0][0] < 0.6 * reading.nearness.same
        k = visit.at - visit.start
        low = high = k
        while low > 0 and near[low - 1]:
            low -= 1
        while high + 1 < len(near) and near[high + 1]:
            high += 1
        out.append((visit.start + low, visit.start + high + 1) if high - low >= least else None)
    return out


def self_symmetry(moments: Moments, stretches: Sequence[tuple[int, int]]) -> tuple[float, float]:
    """Mean distance of stretches from their mirror images, and from their mirror images played backwards (warped)."""
    blocks = []
    for start, end in stretches:
        points = np.linspace(start, end, _POINTS).round().astype(np.intp)
        blocks.append(_between(moments, points, points)[1])
    s = np.stack(blocks)
    return float(np.diagonal(s, axis1=1, axis2=2).mean()), float(_warped(s[:, :, ::-1]).mean())


def _shadows(moments: Moments, states: Sequence[ReadState], visits: Sequence[Visit], near: Nearness) -> set[int]:
    """States that are only the slow parting or joining of ways at another: always just before or after it, and close by."""
    index = np.array([s.moment for s in states], dtype=np.intp)
    d, s = _between(moments, index, index)
    apart = np.minimum(d, s)
    reach = 2 * _PARTING * moments.fps
    out: set[int] = set()
    for k, state in enumerate(states):
        if state.traced:
            continue
        places = [i for i, v in enumerate(visits) if v.state == k]
        beside: dict[int, int] = {}
        for i in places:
            for o in {
                visits[j].state
                for j in (i - 1, i + 1)
                if 0 <= j < len(visits) and abs(visits[j].at - visits[i].at) <= reach and visits[j].state != k
            }:
                beside[o] = beside.get(o, 0) + 1
        if any(
            count >= 0.8 * len(places) and apart[k, o] < 2.5 * near.state and o not in out
            for o, count in beside.items()
        ):
            out.add(k)
    return out


_Roles = dict[tuple[int, int], int]
"""(cyclic stretch, role) to state."""


def _with_cyclic(
    moments: Moments, states: list[ReadState], cyclic: Sequence[Cyclic], near: Nearness
) -> tuple[list[ReadState], _Roles]:
    """Add the states of the cyclic stretches; where one lies in a state that is there already, it is that one."""
    roles: _Roles = {}
    for number, stretch in enumerate(cyclic):
        for role in sorted({a.role for a in stretch.anchors}):
            index = np.array([a.moment for a in stretch.anchors if a.role == role and not a.mirrored], dtype=np.intp)
            if not len(index):
                index = np.array([a.moment for a in stretch.anchors if a.role == role], dtype=np.intp)
            symmetric = next(a.symmetric for a in stretch.anchors if a.role == role)
            d, _ = _between(moments, index, index)
            moment = int(index[d.mean(axis=1).argmin()])
            taken = [k for (n, _), k in roles.items() if n == number]
            candidates = [k for k, s in enumerate(states) if s.symmetric == symmetric and k not in taken]
            if candidates:
                there = np.array([states[k].moment for k in candidates], dtype=np.intp)
                distances = _between(moments, np.array([moment]), there)[0][0]
                best = int(distances.argmin())
                if distances[best] < near.state:
                    roles[number, role] = candidates[best]
                    continue
            roles[number, role] = len(states)
            states = [*states, ReadState(moment, symmetric, True)]
    return states, roles


def _without(states: Sequence[ReadState], roles: _Roles, gone: set[int]) -> tuple[list[ReadState], _Roles]:
    kept = [k for k in range(len(states)) if k not in gone]
    number = {k: i for i, k in enumerate(kept)}
    return [states[k] for k in kept], {role: number[k] for role, k in roles.items()}


def _cyclic_visits(
    visits: list[Visit], cyclic: Sequence[Cyclic], roles: _Roles
) -> tuple[list[Visit], dict[int, tuple[tuple[int, int, int], bool, bool]]]:
    """Visits with those of the cyclic stretches among them; and what is known of the way from a visit to the next one."""
    keyed: list[tuple[Visit, tuple[tuple[int, int, int], bool, bool] | None]] = [(v, None) for v in visits]
    for number, stretch in enumerate(cyclic):
        ways = [((number, *leg.key), leg.reversed, leg.mirrored) for leg in stretch.legs]
        for anchor, way in zip(stretch.anchors, [*ways, None], strict=True):
            visit = Visit(anchor.moment, anchor.moment + 1, anchor.moment, roles[number, anchor.role], anchor.mirrored)
            keyed.append((visit, way))
    keyed.sort(key=lambda item: item[0].at)
    return [v for v, _ in keyed], {k: way for k, (_, way) in enumerate(keyed) if way is not None}


def _ends(
    moments: Moments,
    visits: Sequence[Visit],
    traversals: Sequence[Traversal],
    inside: NDArray[np.bool_],
    breaks: Sequence[int],
) -> tuple[dict[int, Traversal], dict[int, Traversal]]:
    """The paths of a cyclic movement that each recording begins and ends on, away from any state."""
    leads: dict[int, Traversal] = {}
    tails: dict[int, Traversal] = {}
    for start, end in pairwise((0, *breaks, moments.count)):
        own = [k for k, v in enumerate(visits) if start <= v.at < end]
        if not own:
            continue
        first, last = own[0], own[-1]
        if visits[first].at > start and inside[start]:
            # whatever path arrives in that state later arrives in it now
            here = (visits[first].state, visits[first].mirrored)
            for t, v in zip(traversals, visits[1:], strict=True):
                if t.path != BREAK and (v.state, v.mirrored) == here:
                    leads[first] = Traversal(start, visits[first].at, t.path, t.reversed, t.mirrored)
                    break
        if visits[last].at < end - 1 and inside[end - 1]:
            here = (visits[last].state, visits[last].mirrored)
            for t, v in zip(traversals, visits[:-1], strict=True):
                if t.path != BREAK and (v.state, v.mirrored) == here:
                    tails[last] = Traversal(visits[last].at, end - 1, t.path, t.reversed, t.mirrored)
                    break
    return leads, tails


def read(
    moments: Moments, cyclic: Sequence[Cyclic] = (), progress: Progress = silent, *, breaks: Sequence[int] = ()
) -> Reading:
    """Read states and paths from a recording, or from several put one after the other.

    Parameters
    ----------
    cyclic : stretches whose states follow from their class (see `kinesics.grammar.cyclic`), in order, not overlapping.
    breaks : moments at which another recording begins.
    """
    near = judge_nearness(moments)
    inside = np.zeros(moments.count, dtype=np.bool_)
    for stretch in cyclic:
        first, last = stretch.anchors[0].moment, stretch.anchors[-1].moment
        # what leads up to the first state and away from the last one within the cyclic movement is part of it
        inside[min(stretch.start, first) : max(stretch.end, last + 1)] = True
    marks: list[_Mark] = []
    if not inside.all():
        place = _localise(moments, near.same, progress)
        edges = [_Mark(t, False) for b in breaks for t in (b - 1, b)]
        marks = [m for m in (*_marks(moments, place, near, breaks), *edges) if not inside[m.moment]]
    states = [_state_of(moments, group, near) for group in _cluster(moments, marks, near.state)] if marks else []
    states = _refined(moments, states, near) if states else []
    states, roles = _with_cyclic(moments, states, cyclic, near)
    fixed = set(roles.values())
    symmetric = {number: stretch.symmetric for number, stretch in enumerate(cyclic)}
    while True:
        if not states:
            # a cycle without stop, turning back or parting of ways has its state at its slowest moment
            slowest = int(moments.speed.argmin())
            states = [_state_of(moments, [_Mark(slowest, True)], near)]
        visits = [v for v in _visits(moments, states, near.visit, breaks) if not inside[v.at]]
        visits, keys = _cyclic_visits(visits, cyclic, roles)
        shadows = _shadows(moments, states, visits, near) - fixed
        if shadows:
            states, roles = _without(states, roles, shadows)
            fixed = set(roles.values())
            continue
        paths, traversals = _traverse(moments, states, visits, near, keys, symmetric, breaks)
        visited = {v.state for v in visits}
        drop = (_traceless(states, visits, traversals) | (set(range(len(states))) - visited)) - fixed
        if not drop:
            break
        # one at a time: two neighbours without trace may be each other's only trace
        states, roles = _without(states, roles, {min(drop)})
        fixed = set(roles.values())
    leads, tails = _ends(moments, visits, traversals, inside, breaks)
    return Reading(tuple(states), tuple(paths), tuple(visits), tuple(traversals), near, leads, tails)
