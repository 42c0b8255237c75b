"""Poses made ready once, to be compared many times in small parts ([Schultz2012] §2.13-2.14).

`kinesics.similarity.distance` checks and packs its poses at every call: nothing beside N×N, most of the time beside 1×100.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinesics.similarity import _kernel
from kinesics.similarity._inputs import Poses, Weights, check_poses, check_weights

Floats = NDArray[np.float32]
Index = slice | NDArray[np.intp]
"""Frames: a range without steps, or a list."""


class Prepared:
    """Poses of one recording, checked and packed.

    Parameters
    ----------
    poses, weights : see `kinesics.similarity.distance`.

    Raises
    ------
    InputError
        If poses or weights cannot be used.
    """

    def __init__(self, poses: Poses, weights: Weights | None = None) -> None:
        self._path = _kernel.chosen()
        self._packed = _kernel.pack(check_poses(poses).quaternions, check_weights(weights), self._path)

    def __len__(self) -> int:
        """How many frames."""
        return self._packed.frames

    def distances(self, rows: Index, columns: Index) -> tuple[Floats, Floats]:
        """D and D* of frames ``rows`` (down) and ``columns`` (across), two of shape (rows, columns).

        Rounding leaves up to 4e-7 between equal poses.
        """
        packed_rows, row_start, height = self._part(rows)
        packed_columns, column_start, width = self._part(columns)
        # the kernels begin at multiples of LANES: what comes before is computed, and left out
        row_lead, column_lead = row_start % _kernel.LANES, column_start % _kernel.LANES
        d, mirrored = (np.empty((row_lead + height, column_lead + width), dtype=np.float32) for _ in range(2))
        _kernel.fill_distances(
            packed_rows,
            packed_columns,
            d,
            mirrored,
            self._path,
            row_start=row_start - row_lead,
            column_start=column_start - column_lead,
        )
        return d[row_lead:, column_lead:], mirrored[row_lead:, column_lead:]

    def _part(self, frames: Index) -> tuple[_kernel.Packed, int, int]:
        """Packed poses, the first frame in them, and how many."""
        if isinstance(frames, slice):
            start, stop, _ = frames.indices(len(self))
            count = max(stop - start, 0)
            # short ranges are taken out: beside a few rows, fifteen more would be many
            if start % _kernel.LANES == 0 or count > 16 * _kernel.LANES:
                return self._packed, start, count
            frames = np.arange(start, stop)
        return _kernel.taken(self._packed, frames), 0, len(frames)
