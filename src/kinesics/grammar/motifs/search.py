"""The search for stretches that recur: looked up in the whole recording, made as long as they recur, looked up again."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar.coarse import RATE, thinned
from kinesics.grammar.moments import Moments
from kinesics.grammar.motifs.alignment import advance, cheapest_path, seed_costs, subsequence
from kinesics.grammar.motifs.sets import RELATIONS, Member, Motif, at_rate
from kinesics.grammar.motifs.speed import quiet_speed
from kinesics.grammar.motifs.valleys import valleys
from kinesics.grammar.ranges import SWAY, range_of, spread
from kinesics.progress import Progress, silent

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

CHANCE: Final = 0.35
"""Mean distance of a member to the first one, over the movement's range, up to which it counts."""
_GAIN: Final = 0.4
"""A moment gains as much as it is nearer than this share of the range."""
SEED_S: Final = 0.8
"""Half the length of the stretch that is looked up first, seconds."""
LONGEST_S: Final = 20.0
SHORTEST_S: Final = 0.6
REST_S: Final = 1.2
"""A rest of so long is in no motif."""
FULL_RATE_MOMENTS: Final = 6000
"""Up to so many moments are read one by one, of longer recordings as many as make `kinesics.grammar.coarse.RATE` a second."""
_DROP: Final = 0.4
"""An extension ends when it has lost what this many seconds of perfect agreement gain."""
_BEND: Final = 0.02
_EDGE: Final = 0.01
_EXPLAINED: Final = 0.5
"""A stretch of which more than this share is explained makes no motif of its own."""
_KEPT_CELLS: Final = 4_000_000
_MOST_HITS: Final = 4
"""Of each relation, that are followed to see how long a stretch recurs."""


def find_motifs(moments: Moments, progress: Progress = silent) -> tuple[Motif, ...]:
    """All stretches that recur, as sets, in the order in which they first come up.

    Parameters
    ----------
    progress : told how far the recording is read.
    """
    coarse, step = (moments, 1) if moments.count <= FULL_RATE_MOMENTS else thinned(moments, RATE)
    search = _Search(coarse)
    found = search.run(progress)
    return tuple(at_rate(motif, step, moments.count) for motif in found)


class _Search:
    """The recording, and what of it is explained."""

    def __init__(self, moments: Moments) -> None:
        self.moments = moments
        n, fps = moments.count, moments.fps
        self.half = max(2, round(SEED_S * fps))
        by_lag = moments.d_by_lag(2 * self.half + 1)
        range_ = range_of(moments, spread(by_lag, self.half))
        self.floor = SWAY + moments.noise
        self.range: Array = np.where(range_ > self.floor, range_, 0.0)
        resting = spread(by_lag, max(1, round(0.5 * REST_S * moments.fps)))
        self.still = range_of(moments, resting) <= self.floor
        finite = by_lag[1:][np.isfinite(by_lag[1:])]
        self.bend = np.float32(
            _BEND * float(np.median(finite[:: max(1, len(finite) // 100_000)])) if len(finite) else 0.0
        )
        self.short_range = range_of(moments, spread(by_lag, self.half // 2))
        self.block: tuple[int, tuple[Floats, Floats] | None] = (0, None)
        self.explained = np.zeros(n, dtype=np.bool_)
        self.way = np.concatenate([[0.0], np.cumsum(quiet_speed(moments)[1:])])

    def run(self, progress: Progress) -> list[Motif]:
        out: list[Motif] = []
        n = self.moments.count
        stride = max(1, self.half // 2)
        i = self.half
        family = 0
        while i < n - self.half:
            progress(i / n, "motifs")
            if self.explained[i] or self.still[i] or self.range[i] <= 0.0:
                i += 1
                continue
            run = self._unexplained(i)
            if run[1] - run[0] < SHORTEST_S * self.moments.fps:
                i = run[1]
                continue
            stretch = self._stretch(i)
            if stretch and self.explained[slice(*stretch)].mean() > _EXPLAINED:
                stretch = None
            members = self._members(*stretch) if stretch else []
            if len(members) < 2:
                i += stride
                continue
            for member in members:
                self.explained[member.start : member.end] = True
            first = members[0]
            for relation in RELATIONS:
                flags = ("reverse" in relation, "mirror" in relation)
                others = [m for m in members[1:] if (m.reversed, m.mirrored) == flags]
                if others:
                    mean = float(np.mean([m.residual for m in others]))
                    out.append(Motif(len(out), family, relation, 1.0 - mean, (first, *others)))
            family += 1
            i += 1 if self.explained[i] else stride
        progress(1.0, "motifs")
        return out

    def _stretch(self, i: int) -> tuple[int, int] | None:
        """The stretch about a moment that recurs, as long as it does so; None where nothing does."""
        half = self.half
        own = slice(i - half, i + half + 1)
        size = float(self.range[i])
        hits: list[tuple[int, bool, bool]] = []
        nearest = 10**9
        for mirrored, tile in enumerate(self._rows(own.start, own.stop)):
            for backwards in (False, True):
                cost = seed_costs(tile, self.bend, backwards=backwards)
                cost[max(0, i - 2 * half) : i + 2 * half + 1] = (
                    np.inf if not mirrored or backwards else cost[max(0, i - 2 * half) : i + 2 * half + 1]
                )
                share = (cost - self.moments.noise) / size
                # of movement of another size the one cannot be the other
                places = [j for j in valleys(share, CHANCE, half) if self.range[j] > 0.0]
                hits.extend((j, bool(mirrored), backwards) for j in places[:_MOST_HITS])
                if not mirrored and not backwards:
                    nearest = min((abs(j - i) for j in places), default=nearest)
        nearest = min(nearest, self._period_near(i))
        extents: list[tuple[int, int]] = []
        for j, mirrored_, backwards in hits:
            if abs(j - i) < 2:
                continue
            back, ahead = self._extent(i, j, nearest, mirrored=mirrored_, backwards=backwards)
            a, b = i - back, i + ahead + 1
            if backwards:
                middle = (i + j) // 2
                a, b = (a, min(b, middle + 1)) if j > i else (max(a, middle), b)
            a = max(a, self._unexplained(i)[0])
            b = min(b, a + nearest, a + round(LONGEST_S * self.moments.fps))
            extents.append((a, b))
        if not extents:
            return None
        # the stretch that explains most: its length, times how often all of it recurs
        slack = round(0.1 * self.moments.fps)

        def explains(extent: tuple[int, int]) -> tuple[int, int]:
            a, b = extent
            often = sum(c <= a + slack and d >= b - slack for c, d in extents)
            return (b - a) * (1 + often), a - b

        a, b = self._trimmed(*max(extents, key=explains))
        return (a, b) if b - a >= SHORTEST_S * self.moments.fps else None

    def _rows(self, a: int, b: int) -> tuple[Floats, Floats]:
        """D and D* of moments [a, b) and all others, from a block of rows that is kept until another is wanted."""
        n = self.moments.count
        first, block = self.block
        if block is None or a < first or b > first + len(block[0]):
            rows = max(b - a, min(n, _KEPT_CELLS // n))
            block = self.moments.tile(slice(a, min(a + rows, n)), slice(0, n))
            first = a
            self.block = (first, block)
        return block[0][a - first : b - first], block[1][a - first : b - first]

    def _period_near(self, i: int) -> int:
        """The shortest lag at which the movement about a moment is the same, were it shorter than the seed is long."""
        half = self.half // 2
        n = self.moments.count
        low, high = max(0, i - 4 * half - half), min(n, i + 4 * half + half + 1)
        if i - half < 0 or i + half >= n:
            return 10**9
        tile = self._rows(i - half, i + half + 1)[0][:, low:high]
        cost = (seed_costs(tile, self.bend, backwards=False) - self.moments.noise) / max(
            float(self.short_range[i]), 1e-12
        )
        best = 10**9
        for side in (cost[i - low :], cost[i - low :: -1]):
            risen = np.maximum.accumulate(np.where(np.isfinite(side), side, 0.0)) > _GAIN
            valley = [k for k in valleys(np.where(risen, side, np.inf), CHANCE, 2) if k >= 0.25 * self.moments.fps]
            if valley:
                best = min(best, int(valley[0]))
        return best

    def _unexplained(self, i: int) -> tuple[int, int]:
        """The run of moments about ``i`` of which nothing is explained."""
        before, after = np.flatnonzero(self.explained[:i]), np.flatnonzero(self.explained[i:])
        return (int(before[-1]) + 1 if len(before) else 0), (i + int(after[0]) if len(after) else len(self.explained))

    def _trimmed(self, a: int, b: int) -> tuple[int, int]:
        """Without the stillness at either end."""
        way = self.way[a:b]
        total = float(way[-1] - way[0]) if len(way) else 0.0
        if total <= 0.0:
            return a, a
        share = (way - way[0]) / total
        # the last moment before anything moved, the first one after
        first = int(np.searchsorted(share, _EDGE, side="right")) - 1
        last = int(np.searchsorted(share, 1.0 - _EDGE))
        return a + max(0, first), a + min(len(way), last + 1)

    def _extent(self, i: int, j: int, most: int, *, mirrored: bool, backwards: bool) -> tuple[int, int]:
        """How many moments before and after ``i``, at most, the agreement with what surrounds ``j`` goes on."""
        most = min(most, round(LONGEST_S * self.moments.fps))
        ahead = self._one_way(i, j, 1, most, mirrored, backwards=backwards)
        back = self._one_way(i, j, -1, most, mirrored, backwards=backwards)
        return back, ahead

    def _one_way(self, i: int, j: int, direction: int, most: int, mirrored: bool, *, backwards: bool) -> int:
        n = self.moments.count
        rows = min(most, n - 1 - i if direction > 0 else i)
        towards = -direction if backwards else direction
        columns = min(2 * rows, n - 1 - j if towards > 0 else j)
        drop = _DROP * self.moments.fps * _GAIN * float(self.range[i])
        block = 64
        total = np.full(columns + 1, -np.inf)
        before = total.copy()
        best, best_row = -np.inf, 0
        for first in range(0, rows + 1, block):
            last = min(first + block, rows + 1)
            row_slice = slice(i + first, i + last) if direction > 0 else slice(i - last + 1, i - first + 1)
            width = min(columns + 1, 2 * last + 1)
            col_slice = slice(j, j + width) if towards > 0 else slice(j - width + 1, j + 1)
            tile = self.moments.tile(row_slice, col_slice)[int(mirrored)]
            tile = tile[:: 1 if direction > 0 else -1, :: 1 if towards > 0 else -1]
            gains = _GAIN * self.range[row_slice][:: 1 if direction > 0 else -1]
            still = self.still[row_slice][:: 1 if direction > 0 else -1]
            for r in range(first, last):
                gain = gains[r - first] - tile[r - first] + self.moments.noise
                if still[r - first]:
                    return best_row
                if r == 0:
                    now = np.full(columns + 1, -np.inf)
                    now[0] = gain[0]
                else:
                    now = advance(total, before, gain, float(self.bend))
                before, total = total, now
                top = float(now.max())
                if top > best:
                    best, best_row = top, r
                elif top < best - drop:
                    return best_row
        return best_row

    def _members(self, a: int, b: int) -> list[Member]:
        """The stretch and all other places where it is found, non-overlapping, the nearest ones first."""
        moments = self.moments
        n = moments.count
        own = moments.tile(slice(a, b), slice(a, b))[0]
        size = max(float(range_of(moments, own.mean())), 1e-12)
        first = Member(a, b, False, False, 0.0, tuple((k, k) for k in range(a, b)))
        candidates: list[tuple[float, int, int, int]] = []
        tables = {}
        for mirrored, tile in enumerate(moments.tile(slice(a, b), slice(0, n))):
            for backwards in (False, True):
                rows = tile[::-1] if backwards else tile
                cost, start = subsequence(tile, float(self.bend), backwards=backwards)
                share = (cost / (b - a) - moments.noise) / size
                which = 2 * backwards + mirrored
                tables[which] = rows
                # at equal terms the simpler relation
                candidates.extend(
                    (float(share[end]) + 0.02 * which, which, int(start[end]), int(end) + 1)
                    for end in valleys(share, CHANCE, max(2, (b - a) // 4))
                )
        taken = np.zeros(n, dtype=np.bool_)
        taken[a:b] = True
        out = [first]
        slack = max(1, (b - a) // 10)
        for share_, which, s, e in sorted(candidates):
            middle = taken[s + slack : e - slack]
            if e - s < 0.45 * (b - a) or middle.any() or not len(middle):
                continue
            if not self._moves(s, e, size):
                continue
            # a border moment shared with a neighbour belongs to the one that came first
            s, e = s + int(taken[s : s + slack].sum()), e - int(taken[e - slack : e].sum())
            taken[s:e] = True
            mirrored_, backwards = bool(which % 2), which >= 2
            path = cheapest_path(tables[which][:, s:e], float(self.bend))
            pairs = tuple((s + c, b - 1 - r if backwards else a + r) for r, c in path)
            out.append(Member(s, e, backwards, mirrored_, max(0.0, share_ - 0.02 * which), pairs))
        return [out[0], *sorted(out[1:], key=lambda m: m.start)]

    def _moves(self, a: int, b: int, size: float) -> bool:
        index = np.unique(np.linspace(a, b - 1, 24).round().astype(np.intp))
        moved = float(range_of(self.moments, self.moments.thinned(index)[0].mean()))
        return moved > max(0.25 * size, self.floor)
