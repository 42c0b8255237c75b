"""All moments compared with all: pairs of seams that are near and agree.

Poses are compared on a grid of about 30 moments a second, tile by tile. Where all of one movement is near another, two valleys
run side by side in the plane of the seams, and the lowest point of a valley need not be where velocities and feet agree. So of
every tenth of a second against every tenth of a second, nearer than which no two seams are used, the nearest pair is looked at;
and only of those that agree the best are chosen.
"""

from __future__ import annotations

import itertools
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.progress import Progress
from kinesics.similarity import diagonal_sums
from kinesics.synthesis.joining.choice import best, best_of_steps
from kinesics.synthesis.joining.limits import WINDOW
from kinesics.synthesis.joining.seams import BAND, MIRROR, REVERSE, SAME, SEARCH_RATE, Pairs, Seams

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Indices = NDArray[np.intp]

BLOCK: Final = 0.1
"""Seconds: of each block of so many by so many the nearest pair is looked at."""
POOL: Final = 240.0
"""Transitions that leave each second of a strand, on average, of which the best are kept in mind at most."""
GRID_SLACK: Final = 1.2
"""Times the threshold within which a pair on the grid may be near enough at full rate."""
_TILE: Final = 1024


class Nearest(NamedTuple):
    """Of all pairs of moments outside the trivial band, the nearest in pose."""

    distance: float
    """Mean D over the window; infinite where there is no pair at all."""
    first: int
    second: int
    """Frames, over all recordings end to end."""


class Found(NamedTuple):
    """What a search finds."""

    pairs: Pairs
    """Of every two steps the best one that agrees, on the grid."""
    nearest: Nearest
    refused: dict[str, int]
    """Pairs that are near in pose, but differ too much in something else: what → how many."""


def search(seams: Seams, progress: Progress) -> Found:
    """Pairs that are near in pose and agree in all else, the best of every two steps."""
    starts, step = seams.repertoire.starts, seams.step
    grid = np.concatenate([np.arange(s, e, step) for s, e in itertools.pairwise(starts)])
    half = max(1, round(0.5 * WINDOW * seams.fps / step))
    q = np.ascontiguousarray(seams.quaternions[0][grid])
    recording = seams.recording[grid]
    windows = len(grid) - 2 * half + 1
    if windows < 1:
        return Found(Pairs.none(), Nearest(np.inf, 0, 0), {})
    # a window that begins at grid moment i lies about the seam before grid moment i + half
    ok = recording[:windows] == recording[2 * half - 1 :]
    seam = grid[half : half + windows]
    owner = recording[half : half + windows]
    ok &= seams.inside[seam]
    band = BAND * seams.fps / step
    slack = GRID_SLACK if step > 1 else 1.0
    most = seams.limits.distance * 2 * half * slack
    side = max(1, round(BLOCK * min(SEARCH_RATE, seams.fps)))
    room = int(POOL * seams.frames / seams.fps)
    tile = _TILE // side * side
    corners = [(i, j) for i in range(0, windows, tile) for j in range(i, windows, tile)]
    nearest = Nearest(np.inf, 0, 0)
    pool: list[Pairs] = []
    refused: dict[str, int] = {}
    for done, (i, j) in enumerate(corners):
        progress(0.9 * done / len(corners), "comparing all moments")
        rows, columns = (slice(k, min(k + tile, windows)) for k in (i, j))
        a, b = (q[part.start : part.stop + 2 * half - 1] for part in (rows, columns))
        for reverse in (False, True) if seams.repertoire.backwards else (False,):
            sums = diagonal_sums(a, b, length=2 * half, reverse=reverse, weights=seams.weights)
            for mirrored, d in ((False, sums.d), (True, sums.d_mirror)):
                if mirrored and not seams.repertoire.mirrored:
                    continue
                relation = (REVERSE if reverse else SAME) + (MIRROR if mirrored else SAME)
                d[~ok[rows]] = np.inf
                d[:, ~ok[columns]] = np.inf
                if j - i - tile < band:
                    across = np.arange(j, columns.stop) - np.arange(i, rows.stop)[:, None]
                    # what is below the diagonal is found above it; across the border of a recording nothing is trivial
                    trivial = (across < band) & (owner[rows][:, None] == owner[columns]) if relation == SAME else False
                    d[(across < 0) | trivial] = np.inf
                least = int(np.argmin(d))
                value = float(d.flat[least]) / (2 * half)
                if value < nearest.distance:
                    at = divmod(least, d.shape[1])
                    nearest = Nearest(value, int(seam[i + at[0]]), int(seam[j + at[1]]))
                if value * 2 * half > most:
                    continue
                r, c = _nearest_of_blocks(d, most, side)
                near = Pairs.near(
                    seam[i + r], seam[j + c], np.full(len(r), relation), d[r, c].astype(np.float64) / (2 * half)
                )
                agreed = seams.agreeing(near, slack=slack)
                for what, count in agreed.refused.items():
                    refused[what] = refused.get(what, 0) + count
                pool.append(best_of_steps(seams, agreed.pairs))
                if sum(part.size for part in pool) > 4 * room:
                    pool = [best(seams, Pairs.joined(pool), POOL)]
    return Found(best(seams, best_of_steps(seams, Pairs.joined(pool)), POOL), nearest, refused)


def _nearest_of_blocks(d: Floats, most: float, side: int) -> tuple[Indices, Indices]:
    """Of every ``side`` by ``side`` entries the least, where that is at most ``most``: rows and columns."""
    rows, columns = d.shape
    down, across = -(-rows // side), -(-columns // side)
    wide = np.full((down * side, across * side), np.inf, dtype=np.float32)
    wide[:rows, :columns] = d
    # first over the columns of a block, then over its rows
    parts = wide.reshape(down * side, across, side)
    column = np.argmin(parts, axis=2)
    value = np.take_along_axis(parts, column[..., None], axis=2).reshape(down, side, across)
    row = np.argmin(value, axis=1)
    at, beside = np.nonzero(np.take_along_axis(value, row[:, None], axis=1)[:, 0] <= np.float32(most))
    r = at * side + row[at, beside]
    return r, beside * side + column[r, beside]
