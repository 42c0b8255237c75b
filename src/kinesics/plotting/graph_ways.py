"""Which way an arrow of a motion graph takes, so that it runs through no state but its own.

States stand a cell apart, so that between their rows and columns there is always room: where neither a bow nor an S is free, the
way leads through these channels. Ways are laid one after another, and each keeps off those that lie already.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Corner = tuple[int, int]

SAMPLES: Final = 48
"""Points of a curve."""
CLEAR: Final = 0.06
"""Cells that an arrow keeps from the rim of a state it does not join."""
_EASY: Final = 0.15
"""Cells from a rim at which it looks at ease."""
RIM: Final = 1.08
"""Where arrows begin and end, in radii of their states."""

_NARROW: Final = 0.55
"""How much closer the arrows of a bundle may run where there is no room."""
_NARROWER: Final = 0.3
_GOOD: Final = 1.0
"""A curve that costs less is taken as it is."""
_HIT: Final = 100.0
_ALONG: Final = 1.2
"""What a cell of way on another arrow costs, in cells of detour."""
_CROSSING: Final = 0.7
"""What it costs to cross an arrow between the same states."""
_SAME: Final = 10.0
"""What it costs to take the way of another arrow."""
_BESIDE: Final = 0.1
"""Cells within which one arrow lies on another."""
_ANGLES: Final = np.radians([-80.0, -55.0, -30.0, 0.0, 30.0, 55.0, 80.0])
_HANDLES: Final = (0.35, 0.6, 0.9)
_MIRROR: Final = np.array([-1.0, 1.0])
_LANES: Final = ((0.0, 0.0), (0.09, 0.09), (-0.09, -0.09), (0.09, -0.09), (-0.09, 0.09))
"""Cells by which a way through channels keeps off their middle, across and up."""


class Ways:
    """The ways laid so far between states that stand at ``places`` (n, 2), a cell apart, and are ``radius`` large."""

    def __init__(self, places: Array, radius: float) -> None:
        self.places = places
        self.radius = radius
        self.taken = _Taken(places)
        self.low, self.high = _corners_of(places)

    def lay(self, ways: Sequence[Array]) -> None:
        """Ways that others keep off from now on."""
        for way in ways:
            self.taken.mark(way)

    def bundle(
        self, a: Array, b: Array, normal: Array, offsets: Sequence[float], *, symmetric: bool, paired: bool
    ) -> list[Array]:
        """Ways from ``a`` to ``b``, as many as ``offsets``: side by side if that is free, those that are not each on its own.

        Parameters
        ----------
        normal : unit normal of the line from ``a`` to ``b``.
        symmetric : the mirror images of the ways are to be as free.
        paired : the last is to be the mirror image of the first, the last but one of the second, and so on.
        """
        others = self._others(a, b)
        if symmetric:
            mirrored = others * _MIRROR
            others = np.unique(np.concatenate([others, mirrored]), axis=0)
            others = others[[not any(np.array_equal(p, end) for end in (a, b)) for p in others]]
        length = float(np.linalg.norm(b - a))
        bows, price = _bows(a, b, offsets, together=not paired)
        curves = _quadratic(a, 0.5 * (a + b) + 2.0 * bows[..., None, None] * normal, b, SAMPLES)
        flat = curves.reshape(-1, SAMPLES, 2)
        hits = self._in_the_way(flat, others).reshape(bows.shape)
        cost = hits.sum(axis=1) + self._along(flat, a, b).reshape(bows.shape).sum(axis=1)
        cost += 0.25 * np.abs(bows).max(axis=1) / max(length, 1.0) + price
        chosen = int(np.argmin(np.round(cost, 9))) if len(others) else 0
        best = list(curves[chosen])
        free = hits[chosen] < _HIT
        if paired:
            free &= free[::-1]
        self.lay([curve for curve, good in zip(best, free, strict=True) if good])
        count = len(offsets)
        for k in np.flatnonzero(~free):
            if paired and k >= count - k:
                best[k] = best[count - 1 - k] * _MIRROR
            else:
                best[k] = self._alone(a, b, normal, others, [c for j, c in enumerate(best) if free[j] or j < k])
                if paired and k < count - 1 - k and best[k][:, 0].sum() > 0.0:
                    best[k] = best[k] * _MIRROR
            self.lay([best[k]])
        return [self.cut(curve, a, b) for curve in best]

    def cut(self, curve: Array, a: Array, b: Array) -> Array:
        """What is seen of a curve between the rims of its states, shape (SAMPLES, 2)."""
        fine = _evenly(curve, 8 * SAMPLES)
        rim = self.radius * RIM
        kept = fine[(np.hypot(*(fine - a).T) >= rim) & (np.hypot(*(fine - b).T) >= rim)]
        return np.asarray(kept[np.linspace(0, len(kept) - 1, SAMPLES).astype(np.intp)])

    def hits(self, curve: Array, ends: Sequence[Array]) -> int:
        """How many states a curve runs through that do not stand at ``ends``."""
        others = self._others(*ends)
        return int((_nearest(curve[None], others) < self.radius + 0.5 * CLEAR).sum())

    def _others(self, *ends: Array) -> Array:
        return self.places[[not any(np.array_equal(p, end) for end in ends) for p in self.places]]

    def _alone(self, a: Array, b: Array, normal: Array, others: Array, beside: Sequence[Array]) -> Array:
        """The best curve with two bends, or way through the channels; ``beside`` it others join the same states."""
        bends = _bends(a, b, normal)
        cost = self._cost(bends, a, b, others, beside)
        if cost.min() < _GOOD:
            return np.asarray(bends[int(np.argmin(cost))])
        curves = np.concatenate([bends, np.stack(list(self._through_channels(a, b, others)))])
        return np.asarray(curves[int(np.argmin(self._cost(curves, a, b, others, beside)))])

    def _cost(self, curves: Array, a: Array, b: Array, others: Array, beside: Sequence[Array]) -> Array:
        """Of each curve: what it runs through, lies on and crosses, and how far and how much round it leads; shape (curves,)."""
        steps = np.diff(curves, axis=1)
        lengths = np.hypot(steps[..., 0], steps[..., 1]).sum(axis=1)
        turns = np.abs(np.diff(np.unwrap(np.arctan2(steps[..., 1], steps[..., 0]), axis=1), axis=1)).sum(axis=1)
        cost = self._in_the_way(curves, others) + self._along(curves, a, b)
        cost += lengths - float(np.linalg.norm(b - a)) + 0.15 * turns
        for other in beside:
            same = np.abs(curves - other).max(axis=(1, 2)) < _BESIDE
            cost += _CROSSING * _crossings(curves, other) + _SAME * same
        return np.asarray(np.round(cost, 9))

    def _in_the_way(self, curves: Array, others: Array) -> Array:
        """What it costs each curve to run through states, or close by; shape (curves,)."""
        if not len(others):
            return np.zeros(len(curves))
        near = _nearest(curves, others)
        through, close = near < self.radius + CLEAR, near < self.radius + _EASY
        return np.asarray(_HIT * through.sum(axis=1) + 0.4 * close.sum(axis=1))

    def _along(self, curves: Array, a: Array, b: Array) -> Array:
        """What it costs each curve to lie on those that are laid; shape (curves,)."""
        steps = np.gradient(curves, axis=1)
        lengths = np.hypot(steps[..., 0], steps[..., 1])
        # where arrows come together in a state they may
        free = np.minimum(*(np.hypot(*np.moveaxis(curves - end, -1, 0)) for end in (a, b))) > self.radius + 0.3
        return np.asarray(_ALONG * (lengths * free * self.taken.lies_at(curves, steps)).sum(axis=1))

    def _through_channels(self, a: Array, b: Array, others: Array) -> Iterator[Array]:
        """Curves between the rows and columns of states. One at least keeps off all of them, if they stand a cell apart."""
        for across, up in _LANES:
            origin = self.low - 0.5 + (across, up)
            size = np.rint(self.high - self.low).astype(int) + 2
            corners = self._corners(a, b, origin, (int(size[0]), int(size[1])))
            polygon = np.concatenate([a[None], corners, b[None]])
            # without corners that are not needed
            for k in range(len(polygon) - 2, 0, -1):
                shorter = np.delete(polygon, k, axis=0)
                if len(shorter) > 2 and (_nearest(_spline(shorter)[None], others) >= self.radius + _EASY).all():
                    polygon = shorter
            yield _spline(polygon)

    def _corners(self, a: Array, b: Array, origin: Array, size: tuple[int, int]) -> Array:
        """The corners of cells by which the least taken of the shortest ways leads, shape (n, 2)."""
        grid = np.stack(np.meshgrid(np.arange(size[0]), np.arange(size[1]), indexing="ij"), axis=-1) + origin
        inner = np.linspace(0.0, 1.0, 8)[:, None]

        def prices(starts: Array, ends: Array) -> Array:
            along = (ends - starts)[..., None, :]
            lines = starts[..., None, :] + inner * along
            taken = self.taken.lies_at(lines, np.broadcast_to(along, lines.shape)).mean(axis=-1)
            return np.asarray(np.linalg.norm(ends - starts, axis=-1) * (1.0 + taken))

        across, up = prices(grid[:-1], grid[1:]).tolist(), prices(grid[:, :-1], grid[:, 1:]).tolist()
        leaving, arriving = (prices(grid, np.broadcast_to(end, grid.shape)).tolist() for end in (a, b))

        def around(state: Array) -> list[Corner]:
            return [(int(i), int(j)) for i, j in np.argwhere((np.abs(grid - state) < 0.75).all(axis=-1))]

        goals = {(i, j): arriving[i][j] for i, j in around(b)}
        queue: list[tuple[float, Corner, Corner | None]] = [(leaving[i][j], (i, j), None) for i, j in around(a)]
        heapq.heapify(queue)
        came: dict[Corner, Corner | None] = {}
        best, last = np.inf, None
        while queue and queue[0][0] < best:
            so_far, corner, before = heapq.heappop(queue)
            if corner in came:
                continue
            came[corner] = before
            if corner in goals and so_far + goals[corner] < best:
                best, last = so_far + goals[corner], corner
            i, j = corner
            steps = [((i - 1, j), across[i - 1][j])] if i > 0 else []
            steps += [((i + 1, j), across[i][j])] if i + 1 < size[0] else []
            steps += [((i, j - 1), up[i][j - 1])] if j > 0 else []
            steps += [((i, j + 1), up[i][j])] if j + 1 < size[1] else []
            for step, price in steps:
                if step not in came:
                    heapq.heappush(queue, (so_far + price, step, corner))
        way: list[Array] = []
        while last is not None:
            way.append(grid[last])
            last = came[last]
        return np.array(way[::-1])


class _Taken:
    """Where arrows lie and in which direction, as a picture."""

    PIXEL: Final = 0.05
    DIRECTIONS: Final = 12
    MARGIN: Final = 4.0

    def __init__(self, places: Array) -> None:
        low, high = _corners_of(places)
        self.origin = low - self.MARGIN
        self.size = np.ceil((high - low + 2.0 * self.MARGIN) / self.PIXEL).astype(np.intp) + 1
        self.picture = np.zeros((self.DIRECTIONS, *self.size), dtype=np.bool_)
        reach = int(_BESIDE / self.PIXEL)
        offsets = np.stack(np.meshgrid(*[np.arange(-reach, reach + 1)] * 2), axis=-1).reshape(-1, 2)
        self.disc = offsets[np.hypot(*offsets.T) <= reach + 0.5]

    def mark(self, way: Array) -> None:
        length = float(np.hypot(*np.diff(way, axis=0).T).sum())
        points = _evenly(way, max(2, int(length / self.PIXEL)))
        direction = self._direction(np.gradient(points, axis=0))
        cells = self._cells(points[:, None]) + self.disc
        x, y = np.moveaxis(np.clip(cells, 0, self.size - 1), -1, 0)
        for turned in (-1, 0, 1):
            self.picture[(direction[:, None] + turned) % self.DIRECTIONS, x, y] = True

    def lies_at(self, points: Array, along: Array) -> NDArray[np.bool_]:
        """Whether something lies at points (..., 2) that goes the way a curve goes there, ``along`` (..., 2)."""
        x, y = np.moveaxis(np.clip(self._cells(points), 0, self.size - 1), -1, 0)
        return np.asarray(self.picture[self._direction(along), x, y])

    def _cells(self, points: Array) -> NDArray[np.intp]:
        return np.rint((points - self.origin) / self.PIXEL).astype(np.intp)

    def _direction(self, along: Array) -> NDArray[np.intp]:
        turns = np.arctan2(along[..., 1], along[..., 0]) / np.pi
        return np.rint(turns * self.DIRECTIONS).astype(np.intp) % self.DIRECTIONS


def _corners_of(places: Array) -> tuple[Array, Array]:
    """The least and the greatest of the places' coordinates; 0 without places."""
    known = places if len(places) else np.zeros((1, 2))
    return known.min(axis=0), known.max(axis=0)


def _bows(a: Array, b: Array, offsets: Sequence[float], *, together: bool) -> tuple[Array, Array]:
    """How far the arrows of a bundle may bow, all on one side, or some on either, or closer together; and what that costs.

    Shapes (choices, arrows) and (choices,).
    """
    step = max(0.3, 0.16 * float(np.linalg.norm(b - a)))
    central = a[0] == b[0] == 0.0
    shifts = step * (-1.0 if central else 1.0) * np.array([0.0, 0.6, -0.6, 1, -1, 1.5, -1.5, 2.1, -2.1, 3, -3])
    base = np.asarray(offsets)
    sides = np.sign(base) * (step * np.array([0.6, 1.0, 1.5, 2.1]))[:, None] if len(base) > 1 else np.zeros((0, 1))
    moved = np.concatenate([np.repeat((shifts if together else shifts[:1])[:, None], len(base), axis=1), sides])
    spreads = np.array([1.0, _NARROW] if len(base) > 1 else [1.0])
    bows = (spreads[:, None, None] * base + moved).reshape(-1, len(base))
    return bows, np.repeat(np.where(spreads < 1.0, _NARROWER, 0.0), len(moved))


def _bends(a: Array, b: Array, normal: Array) -> Array:
    """Cubic Bézier curves that leave and arrive at all angles, shape (curves, SAMPLES, 2)."""
    along = b - a
    across = normal * np.linalg.norm(along)
    leave, arrive, handle = (v.ravel()[:, None] for v in np.meshgrid(_ANGLES, _ANGLES, _HANDLES, indexing="ij"))
    first = a + handle * (np.cos(leave) * along + np.sin(leave) * across)
    second = b - handle * (np.cos(arrive) * along - np.sin(arrive) * across)
    t = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    weights = ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3)
    return np.asarray(weights[0] * a + weights[1] * first[:, None] + weights[2] * second[:, None] + weights[3] * b)


def _spline(polygon: Array) -> Array:
    """A quadratic B-spline from the first to the last of at least three points, shape (SAMPLES, 2)."""
    inner = polygon[1:-1]
    knots = np.concatenate([polygon[:1], 0.5 * (inner[:-1] + inner[1:]), polygon[-1:]])
    each = 12
    pieces = [_quadratic(p, c, q, each)[:-1] for p, c, q in zip(knots[:-1], inner, knots[1:], strict=True)]
    return _evenly(np.concatenate([*pieces, knots[-1:]]), SAMPLES)


def _quadratic(a: Array, control: Array, b: Array, samples: int) -> Array:
    """Quadratic Bézier curves from ``a`` to ``b``, shape (..., samples, 2), for control points (..., 1, 2) or (2,)."""
    t = np.linspace(0.0, 1.0, samples)[:, None]
    return np.asarray((1 - t) ** 2 * a + 2 * t * (1 - t) * control + t**2 * b)


def _evenly(curve: Array, samples: int) -> Array:
    """As many points as wanted, equally far apart along a curve."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))])
    at = np.linspace(0.0, along[-1], samples)
    return np.stack([np.interp(at, along, curve[:, k]) for k in range(2)], axis=-1)


def _nearest(curves: Array, places: Array) -> Array:
    """How near each curve (c, samples, 2) comes to each place; shape (c, places)."""
    x = curves[:, :, None, 0] - places[:, 0]
    y = curves[:, :, None, 1] - places[:, 1]
    return np.asarray(np.sqrt((x**2 + y**2).min(axis=1)))


def _crossings(curves: Array, other: Array) -> Array:
    """How often each curve (c, samples, 2) crosses another that begins and ends where it does; shape (c,)."""
    coarse, line = curves[:, 1:-1:3], other[1:-1:3]
    starts, ends = coarse[:, :-1, None], coarse[:, 1:, None]

    def turns(p: Array, q: Array, r: Array) -> Array:
        u, v = q - p, r - p
        return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    apart = turns(starts, ends, line[:-1]) * turns(starts, ends, line[1:])
    across = turns(line[:-1], line[1:], starts) * turns(line[:-1], line[1:], ends)
    return np.asarray(((apart < 0.0) & (across < 0.0)).sum(axis=(1, 2)), dtype=np.float64)
