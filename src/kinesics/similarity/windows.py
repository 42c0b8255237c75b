"""How alike two stretches of movement are, frame against frame: sums of D along diagonals ([Schultz2012] §3.2)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.similarity import _kernel
from kinesics.similarity._inputs import Poses, Weights, check_outputs, check_poses, check_weights

Floats = NDArray[np.float32]


class DiagonalSums(NamedTuple):
    """Sums of D and of D* over all pairs of stretches of one length."""

    d: Floats
    """``d[i, j]`` compares the stretch that begins at frame i with the one that begins at frame j, shape
    (len(poses) − length + 1, len(other) − length + 1)."""
    d_mirror: Floats
    """The same of D*."""


def diagonal_sums(
    poses: Poses,
    other: Poses | None = None,
    *,
    length: int,
    reverse: bool = False,
    weights: Weights | None = None,
    out: tuple[Floats, Floats] | None = None,
) -> DiagonalSums:
    """Compare all stretches of ``length`` frames: Σ over k < length of D(i + k, j + k).

    With ``reverse`` the second stretch is played backwards: Σ D(i + k, j + length − 1 − k). So the four results are small
    where one stretch recurs as the same, mirrored, reversed, or both. N×N floats are held twice: for long recordings compare
    part by part.

    Parameters
    ----------
    poses : frames of the rows.
    other : frames of the columns; None compares ``poses`` with themselves.
    length : frames of a stretch, at least 1, at most the length of the shorter recording.
    weights : see `distance`.
    out : two float32 arrays of the result's shape to write into, as for `similarity`. With ``reverse`` the result is a view of
        them with its columns in the other order.

    Raises
    ------
    InputError
        If poses, weights, length or ``out`` cannot be used.
    """
    a = check_poses(poses).quaternions
    b = a if other is None else check_poses(other, "other").quaternions
    share = check_weights(weights)
    if not 1 <= length <= min(len(a), len(b)):
        raise InputError(f"Expected `length` between 1 and {min(len(a), len(b))}, the shorter recording; got {length}.")
    d, d_mirror = check_outputs((len(a) - length + 1, len(b) - length + 1), out, ("d", "d_mirror"))
    path = _kernel.chosen()
    packed_a = _kernel.pack(a, share, path)
    same = other is None and not reverse
    packed_b = packed_a if same else _kernel.pack(np.ascontiguousarray(b[::-1]) if reverse else b, share, path)
    _kernel.fill_diagonal_sums(packed_a, packed_b, length, d, d_mirror, path)
    # played backwards, the window that ends last begins first
    return DiagonalSums(d[:, ::-1], d_mirror[:, ::-1]) if reverse else DiagonalSums(d, d_mirror)
