"""Kinds of movement: phrases whose stretches are found in one another, the same or mirrored, are of one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar.linkage import clusters
from kinesics.grammar.moments import Moments
from kinesics.grammar.phrases.crossing import SCALES_S
from kinesics.grammar.phrases.pieces import Phrase, Piece
from kinesics.grammar.phrases.rests import sway
from kinesics.grammar.ranges import STILL, range_of
from kinesics.similarity import chord

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

_SAMPLES: Final = 8
_SEARCHES: Final = 1000
"""Stretches of each phrase that are looked for in the others."""
_SEEN_S: Final = 12.0
"""Of a longer phrase so much, from its middle, is looked for in the others."""
KIN: Final = 0.4
"""Mean residual up to which two phrases are of one kind."""


@dataclass(frozen=True)
class Kind:
    """A kind of movement, and whether it is that one's mirror image."""

    number: int
    mirrored: bool


def kinds(coarse: Moments, pieces: list[Piece]) -> list[Kind]:
    """Kinds of pieces: those whose stretches are found in one another, the same or mirrored, have the same."""
    apart = kinds_apart(coarse, pieces, range(len(pieces)))
    numbers = clusters(apart[0], KIN, "average")
    firsts = np.unique(numbers, return_index=True)[1][numbers]
    return [
        Kind(number, k != first and mirror_image(*apart[1:, first, k].tolist()))
        for k, (number, first) in enumerate(zip(numbers.tolist(), firsts.tolist(), strict=True))
    ]


def mirror_image(same: float, mirrored: float) -> bool:
    """Whether two phrases are alike by the mirror only, by what is left over of each in the other under D and under D*."""
    return same > KIN and mirrored < same


def _postures(coarse: Moments, middles: NDArray[np.intp]) -> Array:
    """The same posture held, or its mirror image: 0 where it is, 2 where it is not; under either, D and D*, shape (3, n, n)."""
    straight, image = coarse.thinned(middles)
    measured = np.stack([np.minimum(straight, image), straight, image]).astype(np.float64)
    return np.where(chord(measured) <= 2.0 * sway(coarse), 0.0, 2.0)


def _of_either(left: Array) -> Array:
    """Mean over stretches of `_left_over`: under the nearer relation, under D, under D*; shape (3, pieces)."""
    return np.stack([left.min(axis=0).mean(axis=0), *left.mean(axis=1)])


def kinds_apart(coarse: Moments, phrases: Sequence[Phrase | Piece], groups: Sequence[int]) -> Array:
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
    spans = range_of(coarse, np.array([float(own[np.ix_(r, r)].mean()) for r in rows]))
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
