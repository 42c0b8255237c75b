"""Motifs: stretches that recur, the same, mirrored, backwards or both; states that return; turnings back; strikes.

The dissertation's visual motifs ([Schultz2012] §3.2-3.4): proximity signals in Z (same, reverse) and Z* (mirror, mirror and
reverse), along the identity axis or at right angles to it. Here they are sets: a stretch, and all places where it comes back.

- `find_motifs`: going through the recording, the first stretch not yet explained is looked up in the whole recording, made as
  long as it recurs, and looked up again as a whole; what is found is explained and not looked up any more. So a movement done
  a hundred times is one set of a hundred members, not 4,950 pairs.
- `find_state_repetitions` (§3.2.2, §3.4.2), `find_reversals` (§3.2.4), `find_strikes` (§3.6.3).

**Tempo** is free: one side may go up to twice as fast as the other, for a while or throughout. **Ends** are where the alignment
gains no more (Smith and Waterman 1981): every moment of it gains what it is nearer than chance. **Chance**: distances are
measured against the range of the movement around; unrelated movement leaves about 1. **Stillness** has no range and gains nothing:
it never poses as a repetition.

Memory grows with the length of the recording and with the stretch that is looked up, not with its square.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.grammar import lags, linkage
from kinesics.grammar.moments import Moments
from kinesics.grammar.phrases import RATE, STILL, spread, thinned
from kinesics.progress import Progress, silent
from kinesics.similarity import chord

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

RELATIONS: Final = ("same", "mirror", "reverse", "mirror_reverse")
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
"""Up to so many moments are read one by one, of longer recordings as many as make `kinesics.grammar.phrases.RATE` a second."""
_RANGE: Final = 1.3
_SWAY: Final = 4e-4
"""Range of a body at rest, beyond the noise (as in `kinesics.grammar.evidence`). What moves by less than the noise rests, too: the
cheapest of many paths through noise is nearer than the noise lets it be."""
_DROP: Final = 0.4
"""An extension ends when it has lost what this many seconds of perfect agreement gain."""
_BEND: Final = 0.02
_EDGE: Final = 0.01
_EXPLAINED: Final = 0.5
"""A stretch of which more than this share is explained makes no motif of its own."""
_TURN_S: Final = (0.4, 0.8, 1.6)
_TURNING: Final = 0.12
"""Residual up to which a path counts as turning back; up to twice as much where the body stops for it."""
_MUCH: Final = 0.35
"""Share of the range of the longest reach that must be passed through within a shorter one to judge by that."""
_SLOWED: Final = 0.6
"""Share of the speed around, from which down a turning counts as slowed for."""
_CALM: Final = 0.5
"""A moment is calm whose speed is below this share of the greatest within a second."""
_TURNS_APART_S: Final = 0.25
STRIKE_S: Final = 0.12
"""A strike loses half of its speed in no more than this. A swing of half a second takes .17 s."""
_STRIKE_SPEED: Final = 2.0
"""A strike is faster than the middling movement of the recording by this factor."""
_SAME_STATE: Final = 2.0
"""Times the sway of a body at rest: so exactly people come back to a pose."""


@dataclass(frozen=True)
class Member:
    """One occurrence, moments [start, end)."""

    start: int
    end: int
    reversed: bool
    mirrored: bool
    residual: float
    """Mean distance to the first member over its range."""
    path: tuple[tuple[int, int], ...]
    """Pairs of moments (this member's, the first member's), from its start to its end."""


@dataclass(frozen=True)
class Motif:
    """A stretch that recurs under one relation: its first occurrence and all others."""

    id: int
    family: int
    """Motifs of one stretch under several relations share this number."""
    relation: str
    similarity: float
    """One less the mean residual of all members but the first: 1 is exact."""
    members: tuple[Member, ...]


@dataclass(frozen=True)
class StateRepetition:
    """Moments at which one pose is taken; with ``mirrored``, the pose and its mirror image."""

    moments: tuple[int, ...]
    mirrored: bool


@dataclass(frozen=True)
class Reversal:
    """A moment at which the movement turns back on its own path."""

    moment: int
    residual: float
    """What the way back leaves of the way there, over what may be left: 0 is exact, 1 the limit."""


@dataclass(frozen=True)
class Strike:
    """A fast movement that ends abruptly."""

    moment: int
    """When half of the speed is gone."""
    speed: float
    """√(2D)/Δt at its fastest, 1/s."""


def find_motifs(moments: Moments, progress: Progress = silent) -> tuple[Motif, ...]:
    """All stretches that recur, as sets, in the order in which they first come up.

    Parameters
    ----------
    progress : told how far the recording is read.
    """
    coarse, step = (moments, 1) if moments.count <= FULL_RATE_MOMENTS else thinned(moments, RATE)
    search = _Search(coarse)
    found = search.run(progress)
    return tuple(_at_rate(motif, step, moments.count) for motif in found)


class _Search:
    """The recording, and what of it is explained."""

    def __init__(self, moments: Moments) -> None:
        self.moments = moments
        n, fps = moments.count, moments.fps
        self.half = max(2, round(SEED_S * fps))
        by_lag = moments.d_by_lag(2 * self.half + 1)
        range_ = _without_noise(moments, spread(by_lag, self.half))
        self.floor = _floor(moments)
        self.range: Array = np.where(range_ > self.floor, range_, 0.0)
        resting = spread(by_lag, max(1, round(0.5 * REST_S * moments.fps)))
        self.still = _without_noise(moments, resting) <= self.floor
        finite = by_lag[1:][np.isfinite(by_lag[1:])]
        self.bend = np.float32(
            _BEND * float(np.median(finite[:: max(1, len(finite) // 100_000)])) if len(finite) else 0.0
        )
        self.short_range = _without_noise(moments, spread(by_lag, self.half // 2))
        self.block: tuple[int, tuple[Floats, Floats] | None] = (0, None)
        self.explained = np.zeros(n, dtype=np.bool_)
        self.way = np.concatenate([[0.0], np.cumsum(_quiet_speed(moments)[1:])])

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
                valleys = [j for j in _valleys(share, CHANCE, half) if self.range[j] > 0.0]
                hits.extend((j, bool(mirrored), backwards) for j in valleys[:_MOST_HITS])
                if not mirrored and not backwards:
                    nearest = min((abs(j - i) for j in valleys), default=nearest)
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
            valley = [k for k in _valleys(np.where(risen, side, np.inf), CHANCE, 2) if k >= 0.25 * self.moments.fps]
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
                    now = _advance(total, before, gain, float(self.bend))
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
        size = max(float(_without_noise(moments, own.mean())), 1e-12)
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
                    for end in _valleys(share, CHANCE, max(2, (b - a) // 4))
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
            path = _path(tables[which][:, s:e], float(self.bend))
            pairs = tuple((s + c, b - 1 - r if backwards else a + r) for r, c in path)
            out.append(Member(s, e, backwards, mirrored_, max(0.0, share_ - 0.02 * which), pairs))
        return [out[0], *sorted(out[1:], key=lambda m: m.start)]

    def _moves(self, a: int, b: int, size: float) -> bool:
        index = np.unique(np.linspace(a, b - 1, 24).round().astype(np.intp))
        moved = float(_without_noise(self.moments, self.moments.thinned(index)[0].mean()))
        return moved > max(0.25 * size, self.floor)


_KEPT_CELLS: Final = 4_000_000
_MOST_HITS: Final = 4
"""Of each relation, that are followed to see how long a stretch recurs."""


def seed_costs(tile: Floats, bend: np.float32, *, backwards: bool) -> Floats:
    """Mean distance along the cheapest path of all rows that passes the middle row at each column, the worse half."""
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


def _advance(total: Array, before: Array, gain: Array, bend: float) -> Array:
    """One row further: from one row and one column back, one row and two columns, or two rows and one column."""
    m = len(gain)
    best = np.full(len(total), -np.inf)
    best[1:m] = total[: m - 1]
    np.maximum(best[2:m], total[: m - 2] - bend, out=best[2:m])
    np.maximum(best[1:m], before[: m - 1] - bend, out=best[1:m])
    best[:m] += gain
    return best


def subsequence(tile: Floats, bend: float, *, backwards: bool = False) -> tuple[Floats, NDArray[np.intp]]:
    """The cheapest way through all rows that ends at each column: summed distance, and the column it began at.

    Each step goes on by one row and one column, one row and two columns, or two rows and one column (the row between counts as
    much as the one that is reached), so that the tempo stays between half and double. With ``backwards`` the last row comes first.
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


def _path(tile: Floats, bend: float) -> list[tuple[int, int]]:
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


def _without_noise(moments: Moments, spread_: Array | np.floating) -> Array:
    """The range of a movement, from the mean distance of its moments: without what the noise adds to each distance."""
    return _RANGE * np.maximum(np.asarray(spread_, dtype=np.float64) - moments.noise, 0.0)


def _floor(moments: Moments) -> float:
    """Range up to which a body rests."""
    return _SWAY + moments.noise


def _valleys(values: Array | Floats, below: float, apart: int) -> list[int]:
    """Indices of the minima under a level, each the lowest within ``apart``, the lowest first."""
    n = len(values)
    out: list[int] = []
    blocked = np.zeros(n, dtype=np.bool_)
    low = np.flatnonzero(values < below)
    if not len(low):
        return out
    inner = np.concatenate([[np.inf], np.asarray(values, dtype=np.float64), [np.inf]])
    minimum = (inner[1:-1] <= inner[:-2]) & (inner[1:-1] <= inner[2:])
    low = low[minimum[low]]
    for k in low[np.argsort(values[low], kind="stable")]:
        if not blocked[k]:
            out.append(int(k))
            blocked[max(0, k - apart) : k + apart + 1] = True
    return out


def _quiet_speed(moments: Moments) -> Array:
    """Way of each step without what the noise adds to it."""
    squared = (moments.speed / moments.fps) ** 2
    smooth = np.convolve(np.pad(squared, 1, mode="edge"), np.ones(3) / 3.0, "valid")
    return np.sqrt(np.maximum(smooth - 2.0 * moments.noise, 0.0))


def _at_rate(motif: Motif, step: int, count: int) -> Motif:
    if step == 1:
        return motif

    def moment(k: int) -> int:
        return min(k * step, count)

    return replace(
        motif,
        members=tuple(
            replace(
                m,
                start=moment(m.start),
                end=moment(m.end),
                path=tuple((moment(x), moment(y)) for x, y in m.path),
            )
            for m in motif.members
        ),
    )


def find_reversals(moments: Moments) -> tuple[Reversal, ...]:
    """Moments at which the movement turns back on its own path, in order.

    What comes after is what was before, backwards, for 0.4 s at least (or 0.8 or 1.6 s, where it stays at the turning for a
    while), and the body is slower there than around. Between strides, too, legs nearly retrace their way: that leaves .15 to .3
    of the range, where true turnings leave less than .12, or somewhat more where the body stops.
    """
    n, fps = moments.count, moments.fps
    reaches = [w for w in (max(2, round(s * fps)) for s in _TURN_S) if 2 * w < n]
    if not reaches:
        return ()
    by_lag = moments.d_by_lag(2 * max(reaches) + 1)
    bend = lags.bend_cost(by_lag)
    floor = _floor(moments)
    places = np.arange(2 * n - 1)
    least = np.full(2 * n - 1, np.inf)
    judged = np.zeros(2 * n - 1, dtype=np.bool_)
    on = _speed_on_moments(moments)
    around = _without_noise(moments, spread(by_lag, reaches[-1]))
    widest = 0.5 * (around[places // 2] + around[(places + 1) // 2])
    for reach in reaches:
        range_ = _without_noise(moments, spread(by_lag, reach))
        # a place between two moments has the range of both
        size = 0.5 * (range_[places // 2] + range_[(places + 1) // 2])
        mean = np.convolve(np.pad(on, reach, mode="edge"), np.ones(2 * reach + 1) / (2 * reach + 1), "valid")
        slow = 0.5 * (on[places // 2] + on[(places + 1) // 2]) / np.maximum(mean[places // 2], 1e-12)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.maximum(lags.turning(by_lag, reach, bend=bend).costs - moments.noise, 0.0) / size
        share /= _TURNING * (1.0 + np.maximum(1.0 - slow / _SLOWED, 0.0))
        share[(slow >= 1.0) | np.isnan(share)] = np.inf
        # a longer reach is for where little moves within the shorter one
        here = (size > np.maximum(floor, _MUCH * widest)) & ~judged
        least[here] = share[here]
        judged |= here
    found = _valleys(least, 1.0, round(2 * _TURNS_APART_S * fps))
    return tuple(Reversal(c // 2, float(least[c])) for c in sorted(found))


def find_strikes(moments: Moments) -> tuple[Strike, ...]:
    """Fast movements that end abruptly (§3.6.3: the identity signal thins, then a spike stands at right angles to it)."""
    v, fps = np.convolve(np.pad(moments.speed, 1, mode="edge"), (0.25, 0.5, 0.25), "valid"), moments.fps
    moving = v[v > STILL]
    if len(v) < 4 or not len(moving):
        return ()
    enough = _STRIKE_SPEED * float(np.median(moving))
    span = max(1, int(np.floor(STRIKE_S * fps + 1e-9)))
    out: list[Strike] = []
    for k in range(1, len(v) - 1):
        if not (v[k] >= enough and v[k] >= v[k - 1] and v[k] > v[k + 1]):
            continue
        after = np.flatnonzero(v[k + 1 : k + 1 + span] <= 0.5 * v[k])
        if not len(after):
            continue
        hit = Strike(int(k + 1 + after[0]), float(v[k]))
        if out and hit.moment - out[-1].moment <= 2 * span:
            out[-1] = max(out[-1], hit, key=lambda s: s.speed)
        else:
            out.append(hit)
    return tuple(out)


def find_state_repetitions(moments: Moments) -> tuple[StateRepetition, ...]:
    """Poses that are taken again: calm moments and the first and last one, merged under D and under D*.

    Moments of one stay are one: between two of a set the body has been elsewhere.
    """
    marks = _calm(moments)
    if len(marks) < 2:
        return ()
    near = float(np.sqrt((_SAME_STATE * STILL) ** 2 + 4.0 * moments.noise))
    groups = _groups(moments, marks, near)
    visits = [_visits(moments, group, near) for group in groups]
    out = [StateRepetition(tuple(group), mirrored=False) for group in visits if len(group) > 1]
    out += [
        StateRepetition(tuple(sorted((*visits[a], *visits[b]))), mirrored=True)
        for a, b in _images(moments, visits, near)
    ]
    return tuple(out)


def _calm(moments: Moments) -> NDArray[np.intp]:
    """The first and last moment and those in between at which speed is least for a quarter of a second either way."""
    v = _speed_on_moments(moments)
    n = len(v)
    apart = max(1, round(0.25 * moments.fps))
    padded = np.pad(v, apart, mode="edge")
    least = np.lib.stride_tricks.sliding_window_view(padded, 2 * apart + 1).min(axis=1)
    most = np.lib.stride_tricks.sliding_window_view(np.pad(v, 4 * apart, mode="edge"), 8 * apart + 1).max(axis=1)
    marks = np.flatnonzero((v <= least) & (v < _CALM * most))
    return np.unique(np.concatenate([[0], marks, [n - 1]])).astype(np.intp)


def _groups(moments: Moments, marks: NDArray[np.intp], near: float) -> list[NDArray[np.intp]]:
    """Marks merged under average linkage, groups in order of their first member."""

    def apart(rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        same = len(rows) == len(columns) and bool((rows == columns).all())
        d = moments.thinned(marks[rows])[0] if same else moments.between(marks[rows], marks[columns])[0]
        distances = chord(d.astype(np.float64))
        return 0.5 * (distances + distances.T) if same else distances

    labels = linkage.clusters_of_many(apart, len(marks), near)
    order = np.argsort(labels, kind="stable")
    return np.split(marks[order], np.flatnonzero(np.diff(labels[order])) + 1)


def _images(moments: Moments, visits: Sequence[Sequence[int]], near: float) -> Iterator[tuple[int, int]]:
    """Pairs of groups of moments, the earlier first, that are mirror images: √(2D*) of their moments is small on average."""
    index = np.concatenate([np.asarray(v, dtype=np.intp) for v in visits])
    sizes = np.array([len(v) for v in visits])
    firsts = np.cumsum([0, *sizes[:-1]])
    group_of = np.repeat(np.arange(len(visits)), sizes)
    step = max(1, linkage.CELLS // len(index))
    # rows of one group may lie in two blocks
    open_, total = 0, np.zeros(len(visits))
    for first in range(0, len(index), step):
        block = chord(moments.between(index[first : first + step], index)[1].astype(np.float64))
        for group, row in zip(
            group_of[first : first + step].tolist(), np.add.reduceat(block, firsts, axis=1), strict=True
        ):
            if group != open_:
                yield from _near_images(open_, total, sizes, near)
                open_, total = group, np.zeros(len(visits))
            total += row
    yield from _near_images(open_, total, sizes, near)


def _near_images(group: int, total: Array, sizes: NDArray[np.intp], near: float) -> Iterator[tuple[int, int]]:
    for other in np.flatnonzero(total <= near * sizes * sizes[group]).tolist():
        if other > group:
            yield group, other


def _visits(moments: Moments, marks: NDArray[np.intp], near: float) -> list[int]:
    """One moment for each visit: between two of them the body has been further away than ``near``."""
    out = [int(marks[0])]
    for mark in marks[1:]:
        index = np.unique(np.linspace(out[-1], int(mark), 32).round().astype(np.intp))
        if float(chord(moments.thinned(index)[0][0].astype(np.float64)).max()) > near:
            out.append(int(mark))
    return out


def _speed_on_moments(moments: Moments) -> Array:
    """Speed at each moment without what the noise adds to it: the mean of the steps to it and from it, smoothed over three."""
    v = _quiet_speed(moments) * moments.fps
    on = v.copy()
    on[1:-1] = 0.5 * (v[1:-1] + v[2:])
    return np.convolve(np.pad(on, 1, mode="edge"), (0.25, 0.5, 0.25), "valid")


def in_frames(moments: Moments, motifs: Sequence[Motif]) -> Iterator[Motif]:
    """Motifs with frames of the recording in the place of moments."""
    for motif in motifs:
        members = tuple(
            replace(
                m,
                start=moments.frame_of(m.start),
                end=moments.frame_of(m.end),
                path=tuple((moments.frame_of(x), moments.frame_of(y)) for x, y in m.path),
            )
            for m in motif.members
        )
        yield replace(motif, members=members)
