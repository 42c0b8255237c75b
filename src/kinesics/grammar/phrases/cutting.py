"""A recording cut into phrases: at rests, in the valleys of the crossing curve, at calm moments."""

from __future__ import annotations

import itertools
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar import lags
from kinesics.grammar.coarse import RATE, thinned
from kinesics.grammar.moments import Moments
from kinesics.grammar.phrases.crossing import SCALES_S, crossing, hills, reach_of_lags
from kinesics.grammar.phrases.kinds import Kind, kinds
from kinesics.grammar.phrases.pieces import Phrase, Piece
from kinesics.grammar.phrases.rests import calm_moments, calmness, rests
from kinesics.similarity import chord

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

SHORTEST_S: Final = 1.5
"""The shortest phrase."""
GAP_S: Final = 2.5
"""What recurs nowhere for so long is a movement of its own."""
_LIKE: Final = 0.5
"""What lies between two phrases belongs to one of them if it is nearer to it than this share of how far apart they are."""
_MARGIN_S: Final = 0.5
_SLACK_S: Final = 1.0
_CORE_S: Final = 10.0
"""Most of a core that moments near its border are compared with."""


def find_phrases(moments: Moments) -> tuple[Phrase, ...]:
    """The recording cut into phrases, which follow one another without gaps from the first moment to the last."""
    coarse, step = thinned(moments, RATE)
    n = coarse.count
    by_lag = coarse.by_lag(reach_of_lags(coarse.fps))
    weight = crossing(coarse, by_lag)
    speed = calmness(coarse)
    pieces: list[Piece] = []
    last = 0
    for a, b in [*rests(coarse, by_lag[0]), (n, n)]:
        if a > last:
            pieces.extend(_cut(coarse, weight, speed, last, a))
        if b > a:
            pieces.append(Piece(a, b, still=True))
        last = b
    pieces = _joined(coarse, pieces)
    out: list[Phrase] = []
    for piece, kind in _merged(pieces, kinds(coarse, pieces)):
        start, end = piece.start * step, moments.count if piece.end == n else piece.end * step
        out.append(Phrase(start, end, kind.number, piece.still, piece.recurs, kind.mirrored))
    return tuple(out)


def _cut(coarse: Moments, weight: Array, speed: Array, start: int, end: int) -> list[Piece]:
    """A stretch without rests, cut into hills of the crossing curve and what lies between them."""
    shortest = SHORTEST_S * coarse.fps
    cores = _without_leaning(coarse, _cores(weight, speed, start, end, coarse.fps))
    if end - start < 2 * shortest or len(cores) < 2:
        return [Piece(start, end, recurs=any(c.recurs for c in cores))]
    borders: dict[tuple[Piece, Piece], int] = {}
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
    return [Piece(a, b, recurs=core.recurs) for (a, b), core in zip(itertools.pairwise(bounds), cores, strict=True)]


def _cores(weight: Array, speed: Array, start: int, end: int, fps: float) -> list[Piece]:
    """What surely belongs to each phrase: the upper part of each hill, and the middle of what recurs nowhere."""
    shortest = SHORTEST_S * fps
    cores: list[Piece] = []
    last = start

    def once(low: int, high: int) -> None:
        if high - low < GAP_S * fps:
            return
        margin = round(_MARGIN_S * fps)
        low, high = low + (margin if low > start else 0), high - (margin if high < end else 0)
        bounds = [low, *calm_moments(speed, low, high, shortest), high]
        cores.extend(Piece(a, b) for a, b in itertools.pairwise(bounds))

    for hill in hills(weight[start:end]):
        once(last, start + hill.foot[0])
        cores.append(Piece(start + hill.top[0], start + hill.top[1], recurs=True))
        last = start + hill.foot[1]
    once(last, end)
    return cores


def _without_leaning(coarse: Moments, cores: list[Piece]) -> list[Piece]:
    """Without what is made once but is like the phrase before or after it: an exercise that is only beginning."""
    half = max(2, round(SCALES_S[0] * coarse.fps))

    def apart(a: Piece, b: Piece) -> float:
        there, back = (_nearest(coarse, x.start, x.end, y.start, y.end, half) for x, y in ((a, b), (b, a)))
        return max(float(np.median(there)), float(np.median(back)))

    return [
        core
        for k, core in enumerate(cores)
        if core.recurs
        or not 0 < k < len(cores) - 1
        or min(apart(core, cores[k - 1]), apart(core, cores[k + 1])) >= _LIKE * apart(cores[k - 1], cores[k + 1])
    ]


def _border(coarse: Moments, a: Piece, b: Piece, start: int, end: int) -> int:
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


def _joined(coarse: Moments, pieces: list[Piece]) -> list[Piece]:
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
            out[a : b + 1] = [Piece(out[a].start, out[b].end, still=out[m].still, recurs=recurs and not out[m].still)]
            break
        else:
            break
    return out


def _merged(pieces: list[Piece], kinds: list[Kind]) -> list[tuple[Piece, Kind]]:
    """Neighbours of one kind are one phrase."""
    out: list[tuple[Piece, Kind]] = []
    for piece, kind in zip(pieces, kinds, strict=True):
        if out and out[-1][1].number == kind.number:
            before = out[-1][0]
            joined = Piece(before.start, piece.end, before.still and piece.still, recurs=not piece.still)
            out[-1] = joined, out[-1][1]
        else:
            out.append((piece, kind))
    return out
