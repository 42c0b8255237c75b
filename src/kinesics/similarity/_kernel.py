"""The work itself: the compiled kernels, or NumPy where they were not built. Nothing here checks values.

``KINESICS_KERNEL`` names the code path; ``KINESICS_NO_NATIVE=1`` asks for NumPy.
"""

from __future__ import annotations

import os
import time
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.body import pose
from kinesics.errors import InputError
from kinesics.progress import Progress, silent
from kinesics.vocabulary import MIRROR_LINKS

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

LANES: Final = 16
"""Parts of a matrix start at multiples of this many frames."""
_FIRST_TILES: Final = 1024
"""Tiles (128 × 128) before the first call of `progress`, and so the first look at Ctrl-C."""
_CHUNK_SECONDS: Final = 0.2
"""About how long the work goes on between two such looks."""
_BLOCK_ROWS: Final = 256
_ONE_THREAD: Final = 1 << 20
"""Pairs that one thread does in two milliseconds: on a busy machine, waiting for a second one takes longer."""


class Packed(Protocol):
    """Poses made ready by `pack`."""

    @property
    def frames(self) -> int:
        """How many."""
        ...


def available() -> list[str]:
    """Code paths that this machine has, the fastest first."""
    return [*([] if compiled.native is None else compiled.native.paths()), "numpy"]


def chosen() -> str:
    """The code path in use.

    Raises
    ------
    InputError
        If the environment asks for one that this machine does not have.
    """
    if compiled.declined():
        return "numpy"
    paths = available()
    wish = os.environ.get("KINESICS_KERNEL", "")
    if wish and wish not in paths:
        raise InputError(f"KINESICS_KERNEL={wish}: this machine has {', '.join(paths)}.")
    return wish or paths[0]


class _NumpyPoses:
    """Weights folded in as the compiled kernels do: |√w q · √w g| = w |q·g|."""

    def __init__(self, quaternions: Array, gravity: Array, weights: Array) -> None:
        share = weights / weights.sum()
        self.frames = len(quaternions)
        self.links = np.ascontiguousarray(
            np.swapaxes(quaternions * np.sqrt(share)[:, None], 0, 1)[1:], dtype=np.float32
        )  # (14, frames, 4)
        self.gravity = np.ascontiguousarray(gravity * (share[0] / np.sqrt(2.0)), dtype=np.float32)
        self.root_constant = np.float32(share[0] ** 2 / 2.0)

    def part(self, span: slice) -> _NumpyPoses:
        out = object.__new__(_NumpyPoses)
        out.links, out.gravity, out.root_constant = self.links[:, span], self.gravity[span], self.root_constant
        out.frames = len(out.gravity)
        return out

    def taken(self, frames: NDArray[np.intp]) -> _NumpyPoses:
        out = object.__new__(_NumpyPoses)
        out.links, out.gravity, out.root_constant = self.links[:, frames], self.gravity[frames], self.root_constant
        out.frames = len(out.gravity)
        return out

    def mirror(self) -> _NumpyPoses:
        out = object.__new__(_NumpyPoses)
        out.frames, out.root_constant = self.frames, self.root_constant
        partners = [link - 1 for link in MIRROR_LINKS[1:]]
        out.links = self.links[partners] * np.array([1, 1, -1, -1], dtype=np.float32)
        out.gravity = self.gravity * np.array([-1, 1, 1], dtype=np.float32)
        return out


def pack(quaternions: Array, weights: Array, path: str, *, out: Floats | None = None) -> Packed:
    """Poses ready for the kernels. ``out`` is where Z will go: tiles are then laid on its cache lines."""
    gravity = np.ascontiguousarray(pose.gravity(quaternions))
    if path == "numpy":
        return _NumpyPoses(quaternions, gravity, weights)
    lead = 0 if out is None else out.ctypes.data % 64 // 4
    return compiled.native.Poses(quaternions, gravity, weights, lead)


def taken(packed: Packed, frames: NDArray[np.intp]) -> Packed:
    """Some of the packed poses, in the order given; an index below 0 counts from the end."""
    index = np.asarray(frames, dtype=np.int64)
    index = np.ascontiguousarray(np.where(index < 0, index + packed.frames, index))
    if isinstance(packed, _NumpyPoses):
        return packed.taken(index)
    assert isinstance(packed, compiled.native.Poses)
    return packed.taken(index)


def fill_distances(
    a: Packed, b: Packed, d: Floats, d_mirror: Floats | None, path: str, *, row_start: int = 0, column_start: int = 0
) -> None:
    """Write D, and D* if wanted, of the frames from ``row_start`` and ``column_start`` on (multiples of `LANES`)."""
    if isinstance(a, _NumpyPoses):
        assert isinstance(b, _NumpyPoses)
        columns = b.part(slice(column_start, column_start + d.shape[1]))
        image = columns.mirror() if d_mirror is not None else None
        for start in range(0, len(d), _BLOCK_ROWS):
            end = min(start + _BLOCK_ROWS, len(d))
            rows = a.part(slice(row_start + start, row_start + end))
            _numpy_distances(rows, columns, d[start:end])
            if image is not None and d_mirror is not None:
                _numpy_distances(rows, image, d_mirror[start:end])
        return
    assert isinstance(a, compiled.native.Poses)
    assert isinstance(b, compiled.native.Poses)
    threads = 1 if d.size <= _ONE_THREAD else 0
    compiled.native.distances(a, b, d, d_mirror, row_start, column_start, path, threads)


def fill_diagonal_sums(a: Packed, b: Packed, length: int, d: Floats, d_mirror: Floats, path: str) -> None:
    """Write the sums of D and D* over ``length`` frames along diagonals."""
    if isinstance(a, _NumpyPoses):
        assert isinstance(b, _NumpyPoses)
        image = b.mirror()
        for start in range(0, len(d), _BLOCK_ROWS):
            end = min(start + _BLOCK_ROWS, len(d))
            rows = a.part(slice(start, end + length - 1))
            band = np.empty((rows.frames, b.frames), dtype=np.float32)
            for out, columns in ((d, b), (d_mirror, image)):
                _numpy_distances(rows, columns, band)
                if out is d and a is b:
                    np.fill_diagonal(band[:, start:], 0.0)
                part = out[start:end]
                part[:] = 0.0
                for k in range(length):
                    part += band[k : k + len(part), k : k + part.shape[1]]
        return
    assert isinstance(a, compiled.native.Poses)
    assert isinstance(b, compiled.native.Poses)
    compiled.native.diagonal_sums(a, b, length, d, d_mirror, path)


def fill_similarity(
    poses: Packed,
    beta: float,
    z: Floats,
    z_mirror: Floats,
    path: str,
    *,
    fresh: bool,
    progress: Progress | None,
) -> None:
    """Write Z = exp(−β D) and Z* = exp(−β D*), exactly symmetric. ``fresh``: nothing was ever written to the arrays."""
    report = progress or silent
    if isinstance(poses, _NumpyPoses):
        for start in range(0, poses.frames, _BLOCK_ROWS):
            end = min(start + _BLOCK_ROWS, poses.frames)
            report(start / poses.frames, "comparing all moments")
            rows, columns = poses.part(slice(start, end)), poses.part(slice(start, None))
            for out, others in ((z, columns), (z_mirror, columns.mirror())):
                band = out[start:end, start:]
                _numpy_distances(rows, others, band)
                corner = band[:, : end - start]
                np.copyto(corner, corner.T.copy(), where=np.tri(end - start, k=-1, dtype=np.bool_))
                if out is z:
                    np.fill_diagonal(corner, 0.0)
                np.exp(np.multiply(band, np.float32(-beta), out=band), out=band)
                out[end:, start:end] = band[:, end - start :].T
    else:
        assert isinstance(poses, compiled.native.Poses)
        count = poses.tile_count
        first, chunk = 0, _FIRST_TILES
        while first < count:
            report(first / count, "comparing all moments")
            began = time.perf_counter()
            last = min(first + chunk, count)
            compiled.native.similarity_tiles(poses, z, z_mirror, beta, first, last, fresh, path)
            took = max(time.perf_counter() - began, 1e-6)
            first, chunk = last, max(16, int((last - first) * min(_CHUNK_SECONDS / took, 8.0)))
    report(1.0, "comparing all moments")


def _numpy_distances(a: _NumpyPoses, b: _NumpyPoses, out: Floats) -> None:
    """D by one matrix product a link."""
    root = a.gravity @ b.gravity.T
    root += a.root_constant
    np.sqrt(np.maximum(root, 0.0, out=root), out=out)
    for i in range(len(a.links)):
        np.matmul(a.links[i], b.links[i].T, out=root)
        out += np.abs(root, out=root)
    np.subtract(np.float32(1.0), out, out=out)
    np.maximum(out, 0.0, out=out)
