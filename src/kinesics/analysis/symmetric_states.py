"""Moments and stretches at which the body is its own mirror image ([Schultz2012] §2.12, §3.3).

√(2 D*(a, a)) is half the r.m.s. angle by which the joints differ from their mirror images. Nobody is exactly symmetric: people
standing at ease reach D*(a, a) ≈ .005, which is 11° r.m.s. That is the threshold: a pose counts as symmetric when it is
as symmetric as a body at rest. It is a fixed angle, so it depends on no picture, no β, no tempo and no frame rate.

So that noise at the border does not cut a stretch into many, a stretch goes on until D* exceeds 1.25 times the threshold; each
has at least one moment below the threshold itself.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from kinesics.errors import InputError
from kinesics.grammar.ground import SYMMETRIC

SYMMETRY_THRESHOLD: Final = SYMMETRIC
"""Of D*(a, a): that of a symmetric state in the motion graph."""
RELEASE: Final = 1.25


def find_symmetric_states(mirror_distance: ArrayLike, threshold: float = SYMMETRY_THRESHOLD) -> list[tuple[int, int]]:
    """Ranges [start, end) of symmetric poses.

    Parameters
    ----------
    mirror_distance : D*(a, a) of each frame, shape (frames,).

    Raises
    ------
    InputError
        If the values are not one a frame, or the threshold is not positive.
    """
    values = np.asarray(mirror_distance, dtype=np.float64)
    if values.ndim != 1:
        raise InputError(f"Expected one value a frame, got shape {values.shape}.")
    if not threshold > 0.0:
        raise InputError(f"Expected a threshold above 0, got {threshold}.")
    wide = np.concatenate([[False], values <= RELEASE * threshold, [False]])
    edges = np.diff(wide.astype(np.int8))
    starts, ends = np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)
    return [(int(a), int(b)) for a, b in zip(starts, ends, strict=True) if values[a:b].min() <= threshold]
