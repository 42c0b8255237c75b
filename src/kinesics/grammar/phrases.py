"""Phrases: a recording cut into stretches of one kind of movement.

What makes a stretch one phrase is that it recurs within itself: the same, mirrored, backwards or both ([Schultz2012] §3.2-3.4),
a few seconds later. Between one exercise and the next nothing recurs across. So for every moment all recurrences are weighed
that reach across it, from a stretch before it to one after it (`crossing`): phrases are the hills of that curve, and where it
falls to a small part of the lower hill beside it, one phrase ends and another begins.

- **Tempo freedom.** A recurrence is a path, not a straight line: one side may go up to twice as fast for a while.
- **Several scales.** Stretches of about 0.8, 1.6 and 3.2 s are compared, so that quick and slow cycles are seen alike.
- **Against chance.** A path's mean distance is measured against the range of both stretches. Stretches of unrelated movement
  leave about 1, and one in twenty finds somewhere in the neighbourhood a path that leaves .3 to .4; what leaves more than `CHANCE`
  does not count, and what leaves less counts the more, the less it leaves. Both halves of a path must be alike.
- **Stillness is no recurrence.** Both stretches must move by more than a body at rest sways.

The border itself is put where the moments before it are nearer to the one hill and those after it to the other. What recurs
nowhere, between two calm moments, is a phrase made once; a long rest is a phrase of its own. Phrases whose movements are found
in one another get the same kind, however far apart they are.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar import lags
from kinesics.grammar.linkage import clusters
from kinesics.grammar.moments import Moments
from kinesics.similarity import chord

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

RATE: Final = 15.0
"""Moments a second at which recurrences are looked for: a cycle of 0.4 s still has six."""
SCALES_S: Final = (0.4, 0.8, 1.6)
"""Half the length of the stretches compared, seconds."""
REACH_S: Final = 8.0
"""Recurrences are looked for so many seconds ahead: the longest cycle that makes one phrase by itself."""
CHANCE: Final = 0.4
"""Residual of a path from which on it counts for nothing."""
STILL: Final = float(2.0 * np.sin(np.deg2rad(5.0) / 4.0))
"""√(2D) of 5° r.m.s. in all joints: people at rest sway by one or two degrees."""
REST_S: Final = 3.0
"""A rest of so long is a phrase."""
SHORTEST_S: Final = 1.5
"""The shortest phrase."""
_RANGE: Final = 1.3
"""Times the mean distance in a stretch: about the 75th percentile, and steadier."""
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
_LIKE: Final = 0.5
"""What lies between two phrases belongs to one of them if it is nearer to it than this share of how far apart they are."""
GAP_S: Final = 2.5
"""What recurs nowhere for so long is a movement of its own."""
_BLOCK: Final = 1024
"""Moments whose paths are followed at once."""
_MARGIN_S: Final = 0.5
_SLACK_S: Final = 1.0
_CORE_S: Final = 10.0
"""Most of a core that moments near its border are compared with."""
_CALM: Final = 0.4
"""A moment is calm whose speed is below this share of that of the liveliest moments on either side of it."""
_SMOOTH_S: Final = 0.3
_SAMPLES: Final = 8
_SEARCHES: Final = 1000
"""Stretches of each phrase that are looked for in the others."""
_SEEN_S: Final = 12.0
"""Of a longer phrase so much, from its middle, is looked for in the others."""
KIN: Final = 0.4
"""Mean residual up to which two phrases are of one kind."""


@dataclass(frozen=True)
class Phrase:
    """A stretch of one kind of movement, moments [start, end)."""

    start: int
    end: int
    kind: int
    """The same number for phrases of the same kind, counted from 0 in order of appearance."""
    still: bool = False
    """A rest: the body stays where it is."""
    recurs: bool = False
    """The movement recurs within the phrase; False for what is made once."""
    mirrored: bool = False
    """It is like the first phrase of its kind as that is seen in a mirror, and not as it is."""


@dataclass(frozen=True, eq=False)
class Crossing:
    """How much recurs across each moment."""

    weight: Array
    """Seconds², shape (coarse moments,)."""
    step: int
    """Moments of the recording from one coarse moment to the next."""


def find_phrases(moments: Moments) -> tuple[Phrase, ...]:
    """The recording cut into phrases, which follow one another without gaps from the first moment to the last."""
    coarse, step = thinned(moments, RATE)
    n = coarse.count
    by_lag = coarse.by_lag(_lags(coarse.fps))[0:2]
    weight = _crossing(coarse, by_lag)
    rests = _rests(coarse, by_lag[0])
    speed = _calmness(coarse)
    pieces: list[_Piece] = []
    last = 0
    for a, b in [*rests, (n, n)]:
        if a > last:
            pieces.extend(_cut(coarse, weight, speed, last, a))
        if b > a:
            pieces.append(_Piece(a, b, still=True))
        last = b
    pieces = _joined(coarse, pieces)
    out: list[Phrase] = []
    for piece, kind in _merged(pieces, _kinds(coarse, pieces)):
        start, end = piece.start * step, moments.count if piece.end == n else piece.end * step
        out.append(Phrase(start, end, kind.number, piece.still, piece.recurs, kind.mirrored))
    return tuple(out)


def crossing(moments: Moments) -> Crossing:
    """The curve that phrases are read from: recurrences that reach across each moment."""
    coarse, step = thinned(moments, RATE)
    return Crossing(_crossing(coarse, coarse.by_lag(_lags(coarse.fps))), step)


@dataclass(frozen=True)
class _Piece:
    start: int
    end: int
    still: bool = False
    recurs: bool = False


def thinned(moments: Moments, rate: float) -> tuple[Moments, int]:
    """Every so manieth moment, so that there are about ``rate`` a second; and how manieth."""
    step = max(1, round(moments.fps / rate))
    if step == 1 or moments.count < 2 * step:
        return moments, 1
    speed = moments.speed[::step].copy()
    for k in range(1, step):
        later = moments.speed[k::step]
        speed[: len(later)] += later
    # the last one may stand for fewer than the others
    counts = np.full(len(speed), float(step))
    counts[-1] = moments.count - (len(speed) - 1) * step
    poses, dense = moments.poses, moments.dense
    return (
        dataclasses.replace(
            moments,
            fps=moments.fps / step,
            speed=speed / counts,
            symmetry=moments.symmetry[::step],
            poses=None if poses is None else poses[::step],
            dense=None if dense is None else (dense[0][::step, ::step], dense[1][::step, ::step]),
        ),
        step,
    )


def _widths(fps: float) -> list[int]:
    return [max(2, round(s * fps)) for s in SCALES_S]


def _lags(fps: float) -> int:
    # a path that runs backwards on one side starts as far out as it ends inside
    return round(REACH_S * fps) + 2 * max(_widths(fps)) + 2


def _crossing(coarse: Moments, by_lag: tuple[Floats, Floats]) -> Array:
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
    ranges = {w: _RANGE * np.maximum(spread(by_lag[0], w) - coarse.noise, 0.0) for w in widths}
    floor = 0.5 * STILL**2 + coarse.noise
    out = np.zeros((reach + 1, n), dtype=np.float32)
    for distance in by_lag:
        for backwards in (False, True):
            paths = _paths(distance, widths, bend, backwards=backwards)
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


def _paths(distance: Floats, widths: Sequence[int], bend: float, *, backwards: bool) -> dict[int, Floats]:
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


def spread(by_lag: Floats, half: int) -> Array:
    """Mean distance between all moments within ``half`` of each moment, each with itself included."""
    n = by_lag.shape[1]
    t = np.arange(n)
    low, high = np.maximum(t - half, 0), np.minimum(t + half + 1, n)
    total = np.zeros(n)
    for k in range(1, min(2 * half + 1, len(by_lag))):
        row = np.where(np.isfinite(by_lag[k]), by_lag[k], np.float32(0.0))
        sums = np.concatenate([[0.0], np.cumsum(row, dtype=np.float64)])
        total += 2.0 * (sums[np.maximum(high - k, low)] - sums[low])
    mean: Array = total / (high - low) ** 2
    return mean


def _rests(coarse: Moments, by_lag: Floats) -> list[tuple[int, int]]:
    """Stretches of at least `REST_S` in which no two moments a rest apart differ by more than a body at rest sways."""
    n = coarse.count
    span = max(2, round(REST_S * coarse.fps))
    if n <= span:
        return (
            [(0, n)]
            if n > 1 and bool((chord(by_lag[1:, :][np.isfinite(by_lag[1:, :])]) <= _sway(coarse)).all())
            else []
        )
    near = np.ones(n - span, dtype=np.bool_)
    for k in range(1, span + 1):
        row = chord(by_lag[k, : n - k].astype(np.float64)) <= _sway(coarse)
        # all pairs at this lag within the window of span + 1 moments
        count = np.concatenate([[0], np.cumsum(~row)])
        near &= count[span + 1 - k : n - k + 1][: n - span] == count[: n - span]
    still = np.zeros(n, dtype=np.bool_)
    for t in np.flatnonzero(near):
        still[t : t + span + 1] = True
    edges = np.diff(np.concatenate([[False], still, [False]]).astype(np.int8))
    return [(int(a), int(b)) for a, b in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True)]


def _sway(coarse: Moments) -> float:
    return float(np.sqrt(STILL**2 + 2.0 * coarse.noise * 2.0))


def _calmness(coarse: Moments) -> Array:
    """Speed, smoothed a little: the lower, the calmer."""
    width = max(1, round(_SMOOTH_S * coarse.fps)) | 1
    weights = np.hanning(width + 2)[1:-1]
    # steps lead from one moment to the next: put them on the moments
    v = coarse.speed
    on = v.copy()
    on[1:-1] = 0.5 * (v[1:-1] + v[2:])
    padded = np.pad(on, width // 2, mode="edge")
    return np.convolve(padded, weights / weights.sum(), "valid")


def _cut(coarse: Moments, weight: Array, speed: Array, start: int, end: int) -> list[_Piece]:
    """A stretch without rests, cut into hills of the crossing curve and what lies between them."""
    shortest = SHORTEST_S * coarse.fps
    cores = _without_leaning(coarse, _cores(weight, speed, start, end, coarse.fps))
    if end - start < 2 * shortest or len(cores) < 2:
        return [_Piece(start, end, recurs=any(c.recurs for c in cores))]
    borders: dict[tuple[_Piece, _Piece], int] = {}
    while True:
        for pair in itertools.pairwise(cores):
            if pair not in borders:
                borders[pair] = _border(coarse, *pair, start, end)
        inner = [borders[pair] for pair in itertools.pairwise(cores)]
        # borders are found pair by pair: keep them in order
        bounds = [start, *np.maximum.accumulate(np.array(inner, dtype=np.intp)).tolist(), end]
        lengths = np.diff(bounds)
        if len(cores) < 2 or lengths.min() >= shortest:
            break
        # too short to be a phrase: its neighbours share it
        del cores[int(lengths.argmin())]
    return [_Piece(a, b, recurs=core.recurs) for (a, b), core in zip(itertools.pairwise(bounds), cores, strict=True)]


def _cores(weight: Array, speed: Array, start: int, end: int, fps: float) -> list[_Piece]:
    """What surely belongs to each phrase: the upper part of each hill, and the middle of what recurs nowhere."""
    shortest = SHORTEST_S * fps
    cores: list[_Piece] = []
    last = start

    def once(low: int, high: int) -> None:
        if high - low < GAP_S * fps:
            return
        margin = round(_MARGIN_S * fps)
        low, high = low + (margin if low > start else 0), high - (margin if high < end else 0)
        bounds = [low, *_calm_moments(speed, low, high, shortest), high]
        cores.extend(_Piece(a, b) for a, b in itertools.pairwise(bounds))

    for hill in _hills(weight[start:end]):
        once(last, start + hill.foot[0])
        cores.append(_Piece(start + hill.top[0], start + hill.top[1], recurs=True))
        last = start + hill.foot[1]
    once(last, end)
    return cores


def _without_leaning(coarse: Moments, cores: list[_Piece]) -> list[_Piece]:
    """Without what is made once but is like the phrase before or after it: an exercise that is only beginning."""
    half = max(2, round(SCALES_S[0] * coarse.fps))

    def apart(a: _Piece, b: _Piece) -> float:
        there, back = (_nearest(coarse, x.start, x.end, y.start, y.end, half) for x, y in ((a, b), (b, a)))
        return max(float(np.median(there)), float(np.median(back)))

    return [
        core
        for k, core in enumerate(cores)
        if core.recurs
        or not 0 < k < len(cores) - 1
        or min(apart(core, cores[k - 1]), apart(core, cores[k + 1])) >= _LIKE * apart(cores[k - 1], cores[k + 1])
    ]


def _border(coarse: Moments, a: _Piece, b: _Piece, start: int, end: int) -> int:
    """Where one phrase ends and the next begins.

    Each moment between two cores, with what surrounds it, is nearer to one or to the other: the border is where most are on
    their own side. Between two that are made once the body is calm, and that is the border.
    """
    if not (a.recurs or b.recurs):
        return int(np.clip(round(0.5 * (a.end + b.start)), start + 1, end - 1))
    half = max(2, round(SCALES_S[0] * coarse.fps))
    slack = round(_SLACK_S * coarse.fps)
    low, high = max(start + 1, min(a.end, b.start) - slack), min(end - 1, max(a.end, b.start) + slack)
    if high - low < 2:
        return low
    most = round(_CORE_S * coarse.fps)
    left = _nearest(coarse, low, high, max(a.start, a.end - most), a.end, half)
    right = _nearest(coarse, low, high, b.start, min(b.end, b.start + most), half)
    with np.errstate(invalid="ignore"):
        gain = np.where(np.isfinite(left) & np.isfinite(right), left - right, 0.0)
    # the border before moment low + k: those before it are on the left
    cost = np.concatenate([[0.0], np.cumsum(gain)])
    return low + int(np.argmin(cost))


def _nearest(coarse: Moments, low: int, high: int, first: int, last: int, half: int) -> Array:
    """√(2D) of each moment in [low, high), with what surrounds it, to the nearest in [first, last), the same or mirrored.

    What overlaps it in time does not count: a moment is always like the one before it.
    """
    n = coarse.count
    r0, r1 = max(0, low - half), min(n, high + half)
    c0, c1 = max(0, first - half), min(n, last + half)
    best = np.full((r1 - r0, c1 - c0), np.inf, dtype=np.float32)
    for tile in coarse.tile(slice(r0, r1), slice(c0, c1)):
        np.minimum(best, _tile_paths(tile, half), out=best)
    rows, cols = np.arange(r0, r1), np.arange(c0, c1)
    best[np.abs(rows[:, None] - cols) <= 2 * half] = np.inf
    out = np.full(high - low, np.inf)
    if len(cols):
        out[:] = chord(
            best[low - r0 : high - r0, first - c0 : last - c0].min(axis=1, initial=np.inf).astype(np.float64)
        )
    return out


def _tile_paths(tile: Floats, half: int) -> Floats:
    """Mean distance along the cheapest path of ``half`` steps of the row both ways through each cell; inf near the edges."""
    bend = np.float32(lags.bend_cost(tile))
    after, before = tile, tile
    for _ in range(half):
        best = np.full_like(tile, np.inf)
        best[:-1, :-1] = after[1:, 1:]
        np.minimum(best[:-1], after[1:] + bend, out=best[:-1])
        np.minimum(best[:-1, :-2], after[1:, 2:] + bend, out=best[:-1, :-2])
        after = tile + best
        best = np.full_like(tile, np.inf)
        best[1:, 1:] = before[:-1, :-1]
        np.minimum(best[1:], before[:-1] + bend, out=best[1:])
        np.minimum(best[1:, 2:], before[:-1, :-2] + bend, out=best[1:, 2:])
        before = tile + best
    out: Floats = (after + before - tile) / np.float32(2 * half + 1)
    return out


@dataclass(frozen=True)
class _Hill:
    foot: tuple[int, int]
    top: tuple[int, int]


def _hills(weight: Array) -> list[_Hill]:
    """The hills that valleys part, in order."""
    n = len(weight)
    # watershed from above: each top grows; where two meet at a height above the share, the lower one joins the higher
    order = np.argsort(-weight, kind="stable")
    owner = np.full(n, -1)
    top: dict[int, float] = {}
    parent: dict[int, int] = {}

    def root(k: int) -> int:
        while parent[k] != k:
            k = parent[k]
        return k

    for t in order:
        height = weight[t]
        if height <= _HILL * 0.05:
            break
        near = {root(owner[s]) for s in (t - 1, t + 1) if 0 <= s < n and owner[s] >= 0}
        if not near:
            k = int(t)
            parent[k] = k
            top[k] = float(height)
        else:
            ranked = sorted(near, key=lambda r: (-top[r], r))
            k = ranked[0]
            for other in ranked[1:]:
                if height > _VALLEY * top[other] or top[other] < _HILL:
                    parent[other] = k
        owner[t] = k
    groups: dict[int, list[int]] = {}
    for t in range(n):
        if owner[t] >= 0:
            groups.setdefault(root(owner[t]), []).append(t)
    hills = []
    for k, members in groups.items():
        if top[k] < _HILL:
            continue
        foot = [t for t in members if weight[t] > _FOOT * top[k]]
        high = [t for t in members if weight[t] > _TOP * top[k]]
        hills.append(_Hill((foot[0], foot[-1] + 1), (high[0], high[-1] + 1)))
    return sorted(hills, key=lambda h: h.foot)


def _calm_moments(speed: Array, low: int, high: int, shortest: float) -> list[int]:
    """Moments in (low, high) that are calm against what lies on either side, at least ``shortest`` apart; of a rest the middle."""
    inner = speed[low : high + 1]
    found: list[tuple[float, int]] = []
    for t in range(low + 1, min(high, len(speed) - 1)):
        if not (speed[t] <= speed[t - 1] and speed[t] < speed[t + 1]):
            continue
        calm = _CALM * min(float(inner[: t - low + 1].max()), float(inner[t - low :].max()))
        if speed[t] < calm:
            a = b = t
            level = max(float(speed[t]), 0.5 * calm)
            while a > low + 1 and speed[a - 1] <= level:
                a -= 1
            while b < high - 1 and b < len(speed) - 1 and speed[b + 1] <= level:
                b += 1
            found.append((float(speed[t]), (a + b) // 2))
    chosen: list[int] = []
    for _, t in sorted(found):
        if all(abs(t - c) >= shortest for c in chosen):
            chosen.append(t)
    return sorted(chosen)


def _joined(coarse: Moments, pieces: list[_Piece]) -> list[_Piece]:
    """Pieces that are too short, joined to a neighbour: to the shorter one that moves, or, if half as long, to a rest."""
    shortest = SHORTEST_S * coarse.fps
    out = list(pieces)
    while len(out) > 1:
        for k, piece in enumerate(out):
            if piece.still or piece.end - piece.start >= shortest:
                continue
            near = [m for m in (k - 1, k + 1) if 0 <= m < len(out)]
            moving = [m for m in near if not out[m].still]
            if not moving and piece.end - piece.start >= 0.5 * shortest:
                continue
            m = min(moving or near, key=lambda m: out[m].end - out[m].start)
            a, b = min(k, m), max(k, m)
            recurs = out[a].recurs or out[b].recurs
            out[a : b + 1] = [_Piece(out[a].start, out[b].end, still=out[m].still, recurs=recurs and not out[m].still)]
            break
        else:
            break
    return out


@dataclass(frozen=True)
class _Kind:
    number: int
    mirrored: bool


def _merged(pieces: list[_Piece], kinds: list[_Kind]) -> list[tuple[_Piece, _Kind]]:
    """Neighbours of one kind are one phrase."""
    out: list[tuple[_Piece, _Kind]] = []
    for piece, kind in zip(pieces, kinds, strict=True):
        if out and out[-1][1].number == kind.number:
            before = out[-1][0]
            joined = _Piece(before.start, piece.end, before.still and piece.still, recurs=not piece.still)
            out[-1] = joined, out[-1][1]
        else:
            out.append((piece, kind))
    return out


def _kinds(coarse: Moments, pieces: list[_Piece]) -> list[_Kind]:
    """Kinds of pieces: those whose stretches are found in one another, the same or mirrored, have the same."""
    apart = kinds_apart(coarse, pieces, range(len(pieces)))
    numbers = clusters(apart[0], KIN, "average")
    firsts = np.unique(numbers, return_index=True)[1][numbers]
    return [
        _Kind(number, k != first and mirror_image(*apart[1:, first, k].tolist()))
        for k, (number, first) in enumerate(zip(numbers.tolist(), firsts.tolist(), strict=True))
    ]


def mirror_image(same: float, mirrored: float) -> bool:
    """Whether two phrases are alike by the mirror only, by what is left over of each in the other under D and under D*."""
    return same > KIN and mirrored < same


def _postures(coarse: Moments, middles: NDArray[np.intp]) -> Array:
    """The same posture held, or its mirror image: 0 where it is, 2 where it is not; under either, D and D*, shape (3, n, n)."""
    straight, image = coarse.thinned(middles)
    measured = np.stack([np.minimum(straight, image), straight, image]).astype(np.float64)
    return np.where(chord(measured) <= 2.0 * _sway(coarse), 0.0, 2.0)


def _of_either(left: Array) -> Array:
    """Mean over stretches of `_left_over`: under the nearer relation, under D, under D*; shape (3, pieces)."""
    return np.stack([left.min(axis=0).mean(axis=0), *left.mean(axis=1)])


def kinds_apart(coarse: Moments, phrases: Sequence[Phrase | _Piece], groups: Sequence[int]) -> Array:
    """How far apart kinds of phrases are: what is left over when the longest of each is looked for in all of the other.

    Under the nearer of D and D*, under D, under D*; 0 to 1 (2 for a rest and what is none), shape (3, kinds, kinds).

    Parameters
    ----------
    coarse : moments, about `RATE` a second, of one recording or several put one after the other.
    phrases : that tile them, in order.
    groups : the kind of each; the kinds are counted from 0.
    """
    count = max(groups) + 1
    # the more there are, the less of each is looked for: time grows with the recording, not with its square
    samples = int(np.clip(_SEARCHES // count, 2, _SAMPLES))
    starts = np.array([p.start for p in phrases])
    order = np.argsort(groups, kind="stable")
    edges = np.searchsorted(np.asarray(groups)[order], np.arange(count))
    longest = [max((phrases[k] for k in part), key=lambda p: p.end - p.start) for part in np.split(order, edges[1:])]
    apart = np.ones((3, count, count))
    for k, phrase in enumerate(longest):
        if not phrase.still:
            left = _left_over(coarse, phrase.start, phrase.end, starts, samples)
            apart[:, k] = _of_either(np.minimum.reduceat(left[:, :, order], edges, axis=2))
    apart = np.maximum(apart, apart.transpose(0, 2, 1))
    rests = np.array([k for k, p in enumerate(longest) if p.still], dtype=np.intp)
    apart[:, rests] = apart[:, :, rests] = 2.0
    if len(rests):
        middles = np.array([(longest[k].start + longest[k].end) // 2 for k in rests], dtype=np.intp)
        apart[:, rests[:, None], rests] = _postures(coarse, middles)
    return apart


def _left_over(coarse: Moments, start: int, end: int, starts: NDArray[np.intp], samples: int) -> Array:
    """What is left over of each stretch of a phrase where it is best found in each of the phrases that begin at ``starts``.

    Under D and under D*, 0 to 1, shape (2, stretches, pieces). What does not move is found nowhere.
    """
    n = coarse.count
    half = max(2, min(round(SCALES_S[1] * coarse.fps), (end - start - 1) // 2))
    # of a long phrase the middle stands for it
    spare = max(0, (end - start - round(_SEEN_S * samples / _SAMPLES * coarse.fps)) // 2)
    first, last = max(0, start + spare), min(n, end - spare)
    nowhere = np.ones((2, 1, len(starts)))
    if last - first < 2 * half + 1:
        return nowhere
    centres = np.unique(np.linspace(half, last - first - 1 - half, samples).round().astype(np.intp))
    rows = centres[:, None] + np.arange(-half, half + 1)
    own = coarse.tile(slice(first, last), slice(first, last))[0]
    spans = _RANGE * np.maximum(np.array([float(own[np.ix_(r, r)].mean()) for r in rows]) - coarse.noise, 0.0)
    moving = spans > 0.5 * STILL**2 + coarse.noise
    if not moving.any():
        return nowhere
    tiles = coarse.tile(slice(first, last), slice(0, n))
    least = np.stack([np.minimum.reduceat(_row_paths(tile, rows[moving]), starts, axis=1) for tile in tiles])
    return np.clip((least - coarse.noise) / spans[moving, None], 0.0, 1.0)


def _row_paths(tile: Floats, rows: NDArray[np.intp]) -> Floats:
    """Mean distance along the cheapest path of given rows that passes column j in the middle one, shape (stretches, columns).

    Parameters
    ----------
    rows : of each stretch, shape (stretches, 2·half + 1).
    """
    half = rows.shape[1] // 2
    bend = np.float32(0.02 * float(np.median(tile[:: max(1, len(tile) // 32), :: max(1, tile.shape[1] // 512)])))
    total = tile[rows[:, half]]
    for direction in (1, -1):
        run = np.zeros_like(total)
        for s in range(half, 0, -1):
            run += tile[rows[:, half + direction * s]]
            best = run + bend
            for jump, cost in ((1, np.float32(0.0)), (2, bend)):
                here, there = (slice(None, -jump), slice(jump, None))[::direction]
                np.minimum(best[:, here], run[:, there] + cost, out=best[:, here])
            # at the ends of the recording a path may not stand still for ever
            if direction > 0:
                best[:, -1] = np.inf
            else:
                best[:, 0] = np.inf
            run = best
        total = total + run
    out: Floats = total / np.float32(2 * half + 1)
    return out
