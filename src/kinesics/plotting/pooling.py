"""Matrices too large for a picture made small without losing anything thin.

A strike lasts a few frames; in a plot of 10,000 frames it is a line far thinner than a pixel. Averaging would dim it to
nothing and skipping rows would miss it, so every pixel shows the **largest** value of the cells it covers: each frame is
in exactly one pixel row, and no signal is dropped.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError

if TYPE_CHECKING:
    from kinesics.body.pose import PoseSequence
    from kinesics.progress import Progress
    from kinesics.similarity import Weights

Float32 = NDArray[np.float32]
_TILE_STEP: Final = 16
"""Sides of tiles are multiples of it."""


@dataclass(frozen=True, eq=False)
class PooledSimilarity:
    """Z and Z* of a recording at the size of a picture."""

    z: Float32
    """``z[i, j]`` is the largest Z between the frames of bin i and those of bin j. Shape (size, size)."""
    z_mirror: Float32
    """The same for Z*. Shape (size, size)."""
    beta: float
    frame_count: int
    """Frames before pooling."""
    fps: float | None = None


def bin_starts(count: int, bins: int) -> NDArray[np.intp]:
    """First frame of each of ``bins`` bins that share ``count`` frames as evenly as can be; none is empty if bins ≤ count."""
    return (np.arange(bins, dtype=np.intp) * count) // bins


def pool_maximum(matrix: ArrayLike, size: int) -> Float32:
    """The largest value in each of size × size blocks of a square matrix.

    Parameters
    ----------
    matrix : shape (n, n).
    size : wanted; where n ≤ size the matrix comes back as it is.

    Returns
    -------
    Shape (min(n, size), min(n, size)).

    Raises
    ------
    InputError
        If the matrix is not square or the size is not positive.
    """
    values = np.asarray(matrix, dtype=np.float32)
    if values.ndim != 2 or values.shape[0] != values.shape[1] or values.size == 0:
        raise InputError(f"Expected a square matrix, got shape {values.shape}.")
    if size < 1:
        raise InputError(f"Expected a size of at least 1, got {size}.")
    if len(values) <= size:
        return values
    starts = bin_starts(len(values), size)
    return _blocks(np.maximum, values, starts, starts)


def pooled_similarity(
    poses: PoseSequence,
    *,
    size: int = 1200,
    beta: float | None = None,
    weights: Weights | None = None,
    progress: Progress | None = None,
) -> PooledSimilarity:
    """Z and Z* at the size of a picture, straight from the poses: N×N is never held.

    Parameters
    ----------
    poses : of one recording, or of several one after another.
    size : rows and columns of the result, at most; fewer frames give one row each.
    beta : see `kinesics.similarity.similarity`.
    weights : see `kinesics.similarity.distance`.
    progress : told the fraction done; may raise to stop.

    Returns
    -------
    The same as pooling the full matrices with `pool_maximum`: Z falls with D, so the largest Z is that of the least D.

    Raises
    ------
    InputError
        If an argument cannot be used.
    """
    from kinesics.similarity import default_beta, tiles

    if size < 1:
        raise InputError(f"Expected a size of at least 1, got {size}.")
    if beta is not None and not (np.isfinite(beta) and beta > 0.0):
        raise InputError(f"Expected `beta` above 0, got {beta}.")
    frames = len(poses)
    bins = min(frames, size)
    starts = bin_starts(frames, bins)
    counts = np.diff(starts, append=frames)
    # the first frames of all bins, then their second ones, …: a tile then holds one cell of every block, and the least of a block
    # is the least of some tiles. A bin that has fewer frames repeats its last one, and so does the last bin up to a full tile
    width = -(-bins // _TILE_STEP) * _TILE_STEP
    turns = np.minimum(np.arange(counts.max())[:, None], counts - 1)
    order = np.pad(starts + turns, ((0, 0), (0, width - bins)), mode="edge").ravel()
    nearest, nearest_mirror = (np.full((width, width), np.inf, dtype=np.float32) for _ in range(2))
    for tile in tiles(poses.quaternions[order], weights=weights, size=width, half=True, progress=progress):
        np.minimum(nearest, tile.d, out=nearest)
        np.minimum(nearest_mirror, tile.d_mirror, out=nearest_mirror)
    nearest, nearest_mirror = (np.minimum(d, d.T)[:bins, :bins] for d in (nearest, nearest_mirror))
    np.fill_diagonal(nearest, 0.0)  # of a frame and itself; rounding leaves up to 4e-7
    contrast = default_beta(poses, weights) if beta is None else float(beta)
    z, z_mirror = (np.exp(np.float32(-contrast) * d) for d in (nearest, nearest_mirror))
    return PooledSimilarity(z, z_mirror, contrast, frames, poses.fps)


def _blocks(best: np.ufunc, matrix: Float32, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Float32:
    """The best value of each block; blocks begin at the given rows and columns.

    Along contiguous memory twice, with a turn between: across rows `reduceat` is up to fifteen times slower.
    """
    by_columns = best.reduceat(matrix, columns, axis=1)
    return np.asarray(best.reduceat(np.ascontiguousarray(by_columns.T), rows, axis=1).T)
