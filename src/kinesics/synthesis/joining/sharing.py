"""Pairs moved onto few seams: where many transitions leave and arrive at the same seams, paths are few and long.

First a step has one seam, the places of the best pairs first. What does not agree there may keep, in a second round, seams of
its own, where no other is too near.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.joining.seams import BAND, REVERSE, SAME, Pairs, Seams

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

_OPTIONS: Final = 2
"""Pairs of seams that a pair may be moved to."""


class Shared:
    """Pairs that agree on the seams that they share; it grows."""

    def __init__(self, seams: Seams) -> None:
        self.seams = seams
        self.pairs = Pairs.none()

    def add(self, pairs: Pairs) -> None:
        """Those of the pairs that agree on seams there are, or that there may be besides; the cheapest first."""
        left = self._moved(pairs.take(np.argsort(pairs.cost, kind="stable")), one_a_step=True)
        self._moved(left, one_a_step=False)

    def hold(self, pairs: Pairs) -> None:
        """The same, on seams of their own wherever these are free: for pairs that matter more than that seams are few.

        The dearest go first: they can be moved least.
        """
        left = self._moved(pairs.take(np.argsort(-pairs.cost, kind="stable")), one_a_step=False)
        for k in range(left.size):
            fitted = self._fitted(left.take(np.array([k])))
            self.pairs = _once(self.seams, Pairs.joined([self.pairs, fitted]))

    def _moved(self, pairs: Pairs, *, one_a_step: bool) -> Pairs:
        """Adds what agrees on seams beside its own; the others are left."""
        if not pairs.size:
            return pairs
        moved, origin = _beside(self.seams, pairs, self._places(pairs, one_a_step=one_a_step))
        agreed = np.isfinite(moved.cost)
        self.pairs = _once(self.seams, Pairs.joined([self.pairs, moved.take(agreed)]))
        left = np.ones(pairs.size, dtype=np.bool_)
        left[origin[agreed]] = False
        return pairs.take(left)

    def _fitted(self, pair: Pairs) -> Pairs:
        """One pair moved to where it costs least of all the seams about that are used or free; none if it agrees nowhere."""
        seams = self.seams
        used = np.zeros(seams.frames, dtype=np.bool_)
        used[self.pairs.a] = used[self.pairs.b] = True
        sides: list[Indices] = []
        for seam in (int(pair.a[0]), int(pair.b[0])):
            near = np.arange(max(seam - seams.spacing, 0), min(seam + seams.spacing + 1, seams.frames))
            near = near[seams.inside[near] & (seams.recording[near] == seams.recording[seam])]
            # what the seams of the pair itself take up is seen to when they are added
            taken = np.cumsum(np.append(0, used))
            low, high = np.maximum(near - seams.spacing + 1, 0), np.minimum(near + seams.spacing, seams.frames)
            sides.append(near[used[near] | (taken[high] == taken[low])])
        a, b = (grid.ravel() for grid in np.meshgrid(*sides, indexing="ij"))
        back = -1 if pair.relation[0] >= REVERSE else 1
        straight = np.abs((a - pair.a[0]) - back * (b - pair.b[0])) <= seams.spacing // 2
        straight &= (a == b) | (np.abs(a - b) >= seams.spacing) | (seams.recording[a] != seams.recording[b])
        a, b = a[straight], b[straight]
        moved = Pairs.near(np.minimum(a, b), np.maximum(a, b), np.full(len(a), pair.relation[0]), np.zeros(len(a)))
        moved = moved.take(~_trivial(seams, moved))
        moved = seams.agreeing(seams.measured(moved)).pairs
        return moved.take(np.argsort(moved.cost, kind="stable")[:1])

    def _places(self, pairs: Pairs, *, one_a_step: bool) -> Indices:
        """All seams that are used, and those that the pairs want besides and can have, rising."""
        seams = self.seams
        places: list[int] = np.unique(np.concatenate([self.pairs.a, self.pairs.b])).tolist()
        cell: list[int] = seams.cell.tolist()
        inside: list[bool] = seams.inside.tolist()
        recording: list[int] = seams.recording.tolist()

        def beside(seam: int) -> int | None:
            """The seam to use for this one, if there is one already."""
            at = bisect_left(places, seam)
            near = [p for p in places[max(at - 1, 0) : at + 1] if recording[p] == recording[seam]]
            own = [p for p in near if cell[p] == cell[seam]] if one_a_step else []
            near = own or [p for p in near if abs(p - seam) < seams.spacing]
            return min(near, key=lambda p: abs(p - seam)) if near else None

        def settle(seam: int) -> int:
            there = beside(seam)
            if there is None:
                insort(places, seam)
            return seam if there is None else there

        for a, b, relation in zip(pairs.a.tolist(), pairs.b.tolist(), pairs.relation.tolist(), strict=True):
            # the one that has no choice goes first; moved along with it, the other stays as near as it was
            first, second = (b, a) if beside(a) is None and beside(b) is not None else (a, b)
            moved = settle(first) - first
            onward = second - moved if relation >= REVERSE else second + moved
            same = 0 <= onward < seams.frames and inside[onward] and recording[onward] == recording[second]
            settle(onward if same and (not one_a_step or cell[onward] == cell[second]) else second)
        return np.array(places, dtype=np.intp)


def refined(seams: Seams, pairs: Pairs) -> Pairs:
    """Those that agree at full rate, the second seam moved to where they agree best, by less than the grid's step."""
    out = pairs._replace(b=pairs.b.copy(), distance=pairs.distance.copy(), cost=np.full(pairs.size, np.inf))
    for shift in sorted(range(1 - seams.step, seams.step), key=abs):
        b = np.clip(pairs.b + shift, 0, seams.frames - 1)
        moved = pairs._replace(b=b)
        allowed = np.flatnonzero(
            seams.inside[b] & (seams.recording[b] == seams.recording[pairs.b]) & ~_trivial(seams, moved)
        )
        moved = moved.take(allowed)
        moved = seams.judged(moved if seams.step == 1 else seams.measured(moved)).pairs
        better = moved.cost < out.cost[allowed]
        for column, values in ((out.b, moved.b), (out.distance, moved.distance), (out.cost, moved.cost)):
            column[allowed[better]] = values[better]
    return out.take(np.isfinite(out.cost))


def _beside(seams: Seams, pairs: Pairs, places: Indices) -> tuple[Pairs, Indices]:
    """All pairs moved onto seams beside theirs, in the ways that move them least, and the number of the pair that each was."""
    sides: list[Indices] = []
    for seam in (pairs.a, pairs.b):
        at = np.searchsorted(places, seam)
        options = np.stack([places[np.clip(at + k, 0, len(places) - 1)] for k in (-1, 0, 1)], axis=1)
        near = np.abs(options - seam[:, None]) <= seams.spacing
        near |= seams.cell[options] == seams.cell[seam][:, None]
        near &= seams.recording[options] == seams.recording[seam][:, None]
        # at the ends of the list the same seam comes twice
        near[:, 1:] &= options[:, 1:] != options[:, :-1]
        sides.append(np.where(near, options, -1))
    a, b = np.repeat(sides[0], 3, axis=1), np.tile(sides[1], (1, 3))
    back = np.where(pairs.relation >= REVERSE, -1, 1)[:, None]
    far = np.iinfo(np.intp).max
    shear = np.abs((a - pairs.a[:, None]) - back * (b - pairs.b[:, None])) * 4 + np.abs(a - pairs.a[:, None])
    shear = np.where((a < 0) | (b < 0), far, shear)
    order = np.argsort(shear, axis=1, kind="stable")[:, :_OPTIONS]
    row, option = np.nonzero(np.take_along_axis(shear, order, axis=1) < far)
    column = order[row, option]
    first, second = a[row, column], b[row, column]
    moved = Pairs.near(np.minimum(first, second), np.maximum(first, second), pairs.relation[row], np.zeros(len(row)))
    real = ~_trivial(seams, moved)
    return seams.judged(seams.measured(moved.take(real))).pairs, row[real]


def _trivial(seams: Seams, pairs: Pairs) -> Mask:
    """Near because they are nearly one."""
    same = (pairs.relation == SAME) & (seams.recording[pairs.a] == seams.recording[pairs.b])
    return np.asarray(same & (pairs.b - pairs.a < BAND * seams.fps))


def _once(seams: Seams, pairs: Pairs) -> Pairs:
    _, first = np.unique((pairs.relation * seams.frames + pairs.a) * seams.frames + pairs.b, return_index=True)
    return pairs.take(first)
