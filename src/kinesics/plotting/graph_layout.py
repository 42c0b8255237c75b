"""Where the states of a motion graph stand: symmetric ones on the vertical axis, a state left and its mirror image right of it.

Mirror images stand at mirrored places, and the place of an image that the graph does not have stays free: a graph and its
racemisation are drawn alike. The places are cells of a lattice, found by seeded annealing: short arrows, few crossings, no arrow
over a state.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Cell = tuple[int, int]

CROSSING: Final = 3.0
"""What two arrows that cross cost, in squared cells of length."""
COVERING: Final = 9.0
"""What an arrow over a state costs."""
_MOST_STEPS: Final = 1000
"""Of the annealing: a second or two for sixty states."""
_CLEAR: Final = 0.42  # cells that an arrow keeps away from states it does not join


@dataclass(frozen=True)
class Place:
    """Of one state: what it is to the layout."""

    orbit: Hashable
    """The same for a state and its mirror image."""
    side: int
    """0 on the axis, −1 left, 1 right."""


class _Met(NamedTuple):
    """Where arrows are in the way."""

    crossing: NDArray[np.bool_]
    """Whether arrows cross, shape (arrows, arrows)."""
    covered: NDArray[np.bool_]
    """Whether a state lies under an arrow, shape (states, arrows)."""


def lay_out(places: Sequence[Place], arrows: Sequence[tuple[int, int]], *, seed: int = 0, sweeps: int = 40) -> Array:
    """Positions of the states, in cells: x across, y up; shape (states, 2).

    Parameters
    ----------
    places : of each state, in the order in which they should be read where nothing speaks against it: from the top down.
    arrows : pairs of indices into ``places``; loops and repetitions are passed over.
    seed : of the annealing; the same graph is always drawn alike.
    sweeps : rounds of moving every orbit.
    """
    if not places:
        return np.zeros((0, 2))
    return _Annealing(places, arrows, seed).run(sweeps)


class _Annealing:
    def __init__(self, places: Sequence[Place], arrows: Sequence[tuple[int, int]], seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.orbits = list(dict.fromkeys(p.orbit for p in places))
        number = {orbit: k for k, orbit in enumerate(self.orbits)}
        self.of = np.array([number[p.orbit] for p in places])
        self.side = np.array([p.side for p in places], dtype=np.float64)
        self.central = np.array([any(p.orbit == o and p.side == 0 for p in places) for o in self.orbits])
        joined = sorted({(min(a, b), max(a, b)) for a, b in arrows if a != b})
        self.arrows = np.array(joined, dtype=np.intp).reshape(-1, 2)
        # arrows that share an end do not cross, and a state does not lie under its own arrows
        shared = (self.arrows[:, None, :, None] == self.arrows[None, :, None, :]).any(axis=(2, 3))
        self.may_cross = ~shared
        self.may_cover = ~(np.arange(len(places))[:, None, None] == self.arrows[None]).any(axis=-1)
        self.known: dict[tuple[int, ...], tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]] = {}
        self.members = [np.flatnonzero(self.of == k) for k in range(len(self.orbits))]
        self.touching = [np.flatnonzero((self.of[self.arrows] == k).any(axis=1)) for k in range(len(self.orbits))]
        middle, outer = int(self.central.sum()), int((~self.central).sum())
        # a page is higher than wide, and both sides of the axis count
        self.rows = max(middle, int(np.ceil(np.sqrt(2.6 * outer))) if outer > 3 else 1, 1)
        self.columns = max(1, int(np.ceil(outer / self.rows)) + (outer > self.rows // 2 and outer > 2))
        self.cell = self._start()

    def _start(self) -> list[Cell]:
        """Central orbits down the axis, the others in rows beside them, in the order given."""
        cells: list[Cell] = []
        middle = outer = 0
        for central in self.central:
            if central:
                cells.append((0, middle))
                middle += 1
            else:
                cells.append((1 + outer // self.rows, outer % self.rows))
                outer += 1
        return cells

    def run(self, sweeps: int) -> Array:
        where = self.points()
        met = self._met(where)
        steps = min(sweeps * len(self.orbits), _MOST_STEPS)
        hot = 2.0
        best, best_cost, cost = list(self.cell), 0.0, 0.0
        for step in range(steps if len(self.orbits) > 1 else 0):
            warmth = hot * (1.0 - step / steps) ** 2 + 1e-3
            k = int(self.rng.integers(len(self.orbits)))
            target = self._somewhere(k, where)
            if target == self.cell[k]:
                continue
            there = self.cell.index(target) if target in self.cell else None
            moved = (k,) if there is None else (k, there)
            before = self._cost(moved, where, met)
            old = [self.cell[m] for m in moved]
            self.cell[k] = target
            if there is not None:
                self.cell[there] = old[0]
            new = self.points()
            new_met = self._met_again(moved, new, met)
            change = self._cost(moved, new, new_met) - before
            if change <= 0.0 or self.rng.random() < np.exp(-change / warmth):
                where, met = new, new_met
                cost += change
                if cost < best_cost - 1e-9:
                    best, best_cost = list(self.cell), cost
            else:
                for m, place in zip(moved, old, strict=True):
                    self.cell[m] = place
        self.cell = best
        return self._tidy(self.points())

    def points(self) -> Array:
        cells = np.array(self.cell, dtype=np.float64)[self.of]
        return np.stack([cells[:, 0] * self.side, -cells[:, 1]], axis=1)

    def _somewhere(self, k: int, where: Array) -> Cell:
        """A cell that the orbit may stand in: any, or one near the states it is joined to."""
        column = 0 if self.central[k] else int(self.rng.integers(1, self.columns + 1))
        row = int(self.rng.integers(self.rows))
        mine = self.touching[k]
        if len(mine) and self.rng.random() < 0.7:
            ends = self.arrows[mine].ravel()
            others = ends[self.of[ends] != k]
            if len(others):
                goal = where[self.rng.choice(others)]
                row = int(np.clip(-goal[1] + self.rng.integers(-1, 2), 0, self.rows - 1))
                if column:
                    column = int(np.clip(abs(goal[0]) + self.rng.integers(-1, 2), 1, self.columns))
        return column, row

    def _concerned(self, moved: tuple[int, ...]) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
        """The arrows that touch these orbits, all others, and their states."""
        if moved not in self.known:
            mine = np.unique(np.concatenate([self.touching[k] for k in moved]))
            rest = np.setdiff1d(np.arange(len(self.arrows)), mine)
            self.known[moved] = mine, rest, np.concatenate([self.members[k] for k in moved])
        return self.known[moved]

    def _met(self, where: Array) -> _Met:
        starts, ends = where[self.arrows[:, 0]], where[self.arrows[:, 1]]
        crossing = _crossing(starts, ends, starts, ends) & self.may_cross
        return _Met(crossing, _covered(where, starts, ends) & self.may_cover)

    def _met_again(self, moved: tuple[int, ...], where: Array, before: _Met) -> _Met:
        """What changes when these orbits are moved, and all else as it was."""
        mine, _, nodes = self._concerned(moved)
        starts, ends = where[self.arrows[:, 0]], where[self.arrows[:, 1]]
        crossing, covered = before.crossing.copy(), before.covered.copy()
        rows = _crossing(starts[mine], ends[mine], starts, ends) & self.may_cross[mine]
        crossing[mine], crossing[:, mine] = rows, rows.T
        covered[nodes] = _covered(where[nodes], starts, ends) & self.may_cover[nodes]
        covered[:, mine] = _covered(where, starts[mine], ends[mine]) & self.may_cover[:, mine]
        return _Met(crossing, covered)

    def _cost(self, moved: tuple[int, ...], where: Array, met: _Met) -> float:
        """All of the cost that depends on where these orbits stand."""
        mine, rest, nodes = self._concerned(moved)
        # rows are read from the top: the slightest pull keeps the order where nothing else decides
        total = 1e-2 * float(
            sum(abs(self.cell[k][1] - k * (self.rows - 1) / max(1, len(self.orbits) - 1)) for k in moved)
        )
        along = where[self.arrows[mine, 1]] - where[self.arrows[mine, 0]]
        total += float((along**2).sum())
        crossing = met.crossing[mine]
        total += CROSSING * (np.count_nonzero(crossing) - 0.5 * np.count_nonzero(crossing[:, mine]))
        over = np.count_nonzero(met.covered[:, mine]) + np.count_nonzero(met.covered[nodes][:, rest])
        return total + COVERING * over

    def _tidy(self, points: Array) -> Array:
        """Without empty rows and columns, the middle of the picture at height 0."""
        heights = np.unique(points[:, 1])
        points[:, 1] = np.searchsorted(heights, points[:, 1])
        columns = np.unique(np.abs(points[:, 0]))
        columns = columns[columns > 0]
        points[:, 0] = np.sign(points[:, 0]) * (1 + np.searchsorted(columns, np.abs(points[:, 0])))
        points[:, 1] -= 0.5 * (points[:, 1].max() + points[:, 1].min())
        return points


def _crossing(a: Array, b: Array, c: Array, d: Array) -> NDArray[np.bool_]:
    """Whether segments a-b cross segments c-d between their ends; shape (len(a), len(c))."""

    def turns(p: Array, q: Array, r: Array) -> Array:
        """Of p-q to r, a positive number to the left; shape (len(p), len(r))."""
        x, y = (q - p).T[..., None]
        return np.asarray(x * (r[:, 1] - p[:, 1:]) - y * (r[:, 0] - p[:, :1]))

    return np.asarray((turns(a, b, c) * turns(a, b, d) < -1e-9) & (turns(c, d, a) * turns(c, d, b) < -1e-9).T)


def _covered(points: Array, starts: Array, ends: Array) -> NDArray[np.bool_]:
    """Whether each point lies under each segment; shape (points, segments)."""
    x, y = (ends - starts).T
    squared = np.maximum(x**2 + y**2, 1e-12)
    away_x, away_y = points[:, :1] - starts[:, 0], points[:, 1:] - starts[:, 1]
    t = np.minimum(np.maximum((away_x * x + away_y * y) / squared, 0.0), 1.0)
    return np.asarray((away_x - t * x) ** 2 + (away_y - t * y) ** 2 < _CLEAR**2)


def widest_gap(angles: Sequence[float], preferred: float) -> float:
    """The direction farthest from all ``angles`` (radians), the one nearest ``preferred`` among equally good ones."""
    return gaps(angles, preferred)[0] if angles else float(preferred)


def gaps(angles: Sequence[float], preferred: float) -> list[float]:
    """Directions all around, those first that are farther from all ``angles`` and nearer to ``preferred`` (radians)."""
    candidates = preferred + np.arange(24) * (2 * np.pi / 24)
    off = np.abs((candidates - preferred + np.pi) % (2 * np.pi) - np.pi)
    apart = np.full(24, 1.2)
    if angles:
        apart = np.abs((candidates[:, None] - np.asarray(angles)[None] + np.pi) % (2 * np.pi) - np.pi).min(axis=1)
    order = np.argsort(-(np.minimum(apart, 1.2) - 0.12 * off), kind="stable")
    return [float(v) for v in candidates[order]]
