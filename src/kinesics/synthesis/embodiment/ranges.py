"""Joints that are put back into their range, over a stretch of time rather than at once ([Schultz2012] §2.9: Cfree)."""

from __future__ import annotations

import functools
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.stage import Stage

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

YIELD: Final = 0.05
"""Seconds before and after over which a joint goes back that would go beyond its range."""


def put_within_range(stage: Stage, rotations: Array, joints: Indices, where: Mask | None = None) -> None:
    """Put joints back into the range that they have in the recordings, over a stretch of time rather than at once.

    Parameters
    ----------
    rotations : shape (frames, joints, 4); changed in place.
    joints : numbers of those looked at.
    where : frames in which a joint can be beyond at all.
    """
    reach = max(1, round(YIELD * stage.repertoire.fps))
    frames = np.arange(len(rotations)) if where is None else np.nonzero(where)[0]
    middle = stage.middle[joints]
    low, high = stage.low[joints], stage.high[joints]
    vectors = blending.rotation_offset(middle, rotations[np.ix_(frames, joints)])
    beyond = np.maximum(np.maximum(vectors - high, low - vectors), 0.0)
    for n in np.nonzero((beyond > 1e-9).any(axis=(0, 2)))[0].tolist():
        back = np.zeros((len(rotations), 3))
        for axis in np.nonzero((beyond[:, n] > 1e-9).any(axis=0))[0].tolist():
            over = np.zeros((2, len(rotations)))
            over[0, frames] = np.maximum(vectors[:, n, axis] - high[n, axis], 0.0)
            over[1, frames] = np.maximum(low[n, axis] - vectors[:, n, axis], 0.0)
            back[:, axis] = envelope(over[0], reach) - envelope(over[1], reach)
        goes = np.flatnonzero(back.any(axis=1))
        at, back = blending.rotation_offset(middle[n], rotations[goes, joints[n]]), back[goes]
        at = np.where(back != 0.0, np.clip(at - back, low[n], high[n]), at)
        put_joint(rotations, goes, joints[n], blending.add_rotation(middle[n], at))


def put_joint(rotations: Array, frames: Indices, joint: int, q: Array) -> None:
    """Turn a joint as told in some frames; signs stay as they were, so that from frame to frame they do not change."""
    sign = np.copysign(1.0, np.einsum("fi,fi->f", q, rotations[frames, joint]))
    rotations[frames, joint] = sign[:, None] * q


def envelope(values: Array, reach: int) -> Array:
    """A smooth curve that is nowhere below ``values`` (frames,), which are not negative: it rises and falls over ``reach``.

    The greatest within ``reach`` frames, averaged under a Hann window of the same reach.
    """
    if not values.any():
        return np.zeros_like(values)
    if compiled.wanted():
        out = np.empty(len(values))
        compiled.native.envelope(np.ascontiguousarray(values, dtype=np.float64), _hann(reach), out)
        return out
    from scipy.ndimage import maximum_filter1d

    wide = maximum_filter1d(values, 2 * reach + 1, mode="nearest")
    return smooth(wide, reach)


def both_ways(values: Array, reach: int) -> Array:
    """`envelope` of vectors (frames, n): of what each component is above 0, and of what it is below."""
    return np.stack(
        [envelope(np.maximum(v, 0.0), reach) - envelope(np.maximum(-v, 0.0), reach) for v in values.T], axis=-1
    )


def smooth(values: Array, reach: int) -> Array:
    """Averaged under a Hann window of ``reach`` frames to either side."""
    return np.convolve(np.pad(values, reach, mode="edge"), _hann(reach), "valid")


@functools.cache
def _hann(reach: int) -> Array:
    """A Hann window of ``reach`` frames to either side, sum 1."""
    window = np.hanning(2 * reach + 3)[1:-1]
    return np.asarray(window / window.sum())
