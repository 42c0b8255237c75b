"""Stretches of a recording: cut where another recording begins, and how far one is from another or from its own images."""

from __future__ import annotations

import bisect
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.body.runs import runs
from kinesics.grammar.moments import Moments

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

CELLS: Final = 4_000_000
"""Distances that are asked for at once."""
POINTS: Final = 24
"""Of each stretch, at which it is compared."""


def recording_of(moment: int, count: int, breaks: Sequence[int]) -> tuple[int, int]:
    """The range [start, end) of the recording that a moment is of."""
    k = bisect.bisect_right(breaks, moment)
    return (0, *breaks)[k], (*breaks, count)[k]


def cut_at(stretches: Iterable[tuple[int, int]], breaks: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Cut stretches where another recording begins."""
    for start, end in stretches:
        borders = [start, *(b for b in breaks if start < b < end), end]
        yield from pairwise(borders)


def below(row: Floats, limit: float) -> list[tuple[int, int]]:
    """[start, end) of each stretch of values, shape (moments,), below a limit."""
    return runs(row < limit)


def spaced(start: int, end: int) -> NDArray[np.intp]:
    """`POINTS` moments evenly spaced over a stretch, its ends included."""
    return np.linspace(start, end, POINTS).round().astype(np.intp)


def warped(blocks: Floats) -> Array:
    """Mean distance along the best monotone way from corner to corner, for many square blocks at once. (b, p, p) to (b,)."""
    count, p, _ = blocks.shape
    if compiled.wanted():
        out = np.empty(count)
        compiled.native.warped(np.ascontiguousarray(blocks), out)
        return out
    total = np.full((count, p + 1, p + 1), np.inf)
    total[:, 0, 0] = 0.0
    for i in range(p):
        for j in range(p):
            here = blocks[:, i, j]
            total[:, i + 1, j + 1] = here + np.minimum(
                total[:, i, j] + here, np.minimum(total[:, i, j + 1], total[:, i + 1, j])
            )
    return np.asarray(total[:, p, p] / (2 * p))


def self_symmetry(moments: Moments, stretches: Sequence[tuple[int, int]]) -> tuple[float, float]:
    """Mean distance of stretches from their mirror images, and from their mirror images played backwards (warped)."""
    blocks = []
    for start, end in stretches:
        points = spaced(start, end)
        blocks.append(moments.between(points, points)[1])
    s = np.stack(blocks)
    return float(np.diagonal(s, axis1=1, axis2=2).mean()), float(warped(s[:, :, ::-1]).mean())
