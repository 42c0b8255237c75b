"""D and D* tile by tile, for recordings whose N×N would not fit ([Schultz2012] §2.13-2.14)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.progress import Progress, silent
from kinesics.similarity import _kernel
from kinesics.similarity._inputs import Poses, Weights, check_poses, check_weights

Floats = NDArray[np.float32]


class Tile(NamedTuple):
    """A rectangle of D and D*."""

    rows: slice
    """Frames of ``poses``."""
    columns: slice
    """Frames of ``other``, or of ``poses``."""
    d: Floats
    """``d[i, j]`` is D of frame ``rows.start + i`` and frame ``columns.start + j``."""
    d_mirror: Floats
    """The same of D*."""


def tiles(
    poses: Poses,
    other: Poses | None = None,
    *,
    weights: Weights | None = None,
    size: int = 1024,
    half: bool = False,
    progress: Progress | None = None,
) -> Iterator[Tile]:
    """All of D and D*, a tile at a time, row by row; no more than one tile is held.

    Each tile is a pair of fresh arrays, so it may be kept.

    Parameters
    ----------
    poses : frames of the rows.
    other : frames of the columns; None compares ``poses`` with themselves.
    weights : see `distance`.
    size : rows and columns of a tile, at least 16, rounded up to a multiple of 16.
    half : only tiles on and above the diagonal (D and D* are symmetric); not with ``other``.
    progress : told the fraction done before each tile; may raise to stop.

    Raises
    ------
    InputError
        At once, if poses, weights or size cannot be used.
    """
    a = check_poses(poses).quaternions
    b = a if other is None else check_poses(other, "other").quaternions
    share = check_weights(weights)
    if size < _kernel.LANES:
        raise InputError(f"Expected `size` of at least {_kernel.LANES}, got {size}.")
    if half and other is not None:
        raise InputError(
            "`half` is only for poses compared with themselves: D between two recordings is not symmetric."
        )
    step = -(-size // _kernel.LANES) * _kernel.LANES
    path = _kernel.chosen()
    packed_a = _kernel.pack(a, share, path)
    packed_b = packed_a if other is None else _kernel.pack(b, share, path)
    return _walk(packed_a, packed_b, step, half, path, progress or silent)


def _walk(a: _kernel.Packed, b: _kernel.Packed, step: int, half: bool, path: str, progress: Progress) -> Iterator[Tile]:
    corners = [
        (row, column) for row in range(0, a.frames, step) for column in range(row if half else 0, b.frames, step)
    ]
    for done, (row, column) in enumerate(corners):
        progress(done / len(corners), "comparing all moments")
        rows = slice(row, min(row + step, a.frames))
        columns = slice(column, min(column + step, b.frames))
        d = np.empty((rows.stop - row, columns.stop - column), dtype=np.float32)
        d_mirror = np.empty_like(d)
        _kernel.fill_distances(a, b, d, d_mirror, path, row_start=row, column_start=column)
        if a is b and row == column:
            np.fill_diagonal(d, 0.0)  # rounding leaves up to 4e-7
        yield Tile(rows, columns, d, d_mirror)
    progress(1.0, "comparing all moments")
