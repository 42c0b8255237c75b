"""The similarity plots Z and Z* of a whole recording, and the number β that sets their contrast ([Schultz2012] §3.1-3.4)."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.progress import Progress
from kinesics.similarity import _kernel
from kinesics.similarity._inputs import Poses, Weights, check_outputs, check_poses, check_weights

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

_SAMPLES: Final = 512
_QUANTILE: Final = 0.75
_DARK: Final = 0.05
_LEAST_DISTANCE: Final = 0.002
"""D of a body whose joints all turn by 7°: less than this is standing still, and must not be stretched to full contrast."""


BETA_RULE: Final = (
    "ln 20 / max(D75, 0.002); D75 is the 75th percentile of D over the pairs of up to 512 moments evenly spaced in time"
)
"""How `default_beta` chooses, in words."""


@dataclass(frozen=True, eq=False)
class Similarity:
    """Z and Z* of one recording, and all that is needed to read them."""

    z: Floats
    """``z[i, j]`` = exp(−β D) of frames i and j, in [exp(−β), 1], shape (frames, frames), exactly symmetric."""
    z_mirror: Floats
    """``z_mirror[i, j]`` = exp(−β D*): frame i against the mirror image of frame j. The same shape, exactly symmetric."""
    beta: float
    beta_rule: str
    """How β was chosen."""
    weights: Array
    """Of the 15 links, shape (15,)."""
    fps: float | None
    """Frames a second; None where an array was compared."""

    @property
    def frame_count(self) -> int:
        """How many frames."""
        return len(self.z)

    def __len__(self) -> int:
        """How many frames."""
        return len(self.z)


def default_beta(poses: Poses, weights: Weights | None = None) -> float:
    """The contrast at which a quarter of all pairs of moments is nearly black: β = ln 20 / max(D₇₅, .002).

    D₇₅ is the 75th percentile of D over all pairs of up to 512 moments, evenly spaced in time over the recording. So β does
    not depend on the frame rate, hardly on a little more or less of the same movement, and never on chance. The floor keeps
    the noise of a body that stands still from being drawn as if it were movement.

    β sets how a picture looks and no more; conclusions are drawn from D.

    Raises
    ------
    InputError
        If poses or weights cannot be used.
    """
    q, share = check_poses(poses).quaternions, check_weights(weights)
    count = min(len(q), _SAMPLES)
    moments = ((np.arange(count) + 0.5) * len(q) / count).astype(np.intp)
    path = _kernel.chosen()
    sample = _kernel.pack(np.ascontiguousarray(q[moments]), share, path)
    d = np.empty((count, count), dtype=np.float32)
    _kernel.fill_distances(sample, sample, d, None, path)
    pairs = d[np.triu_indices(count, 1)]
    typical = float(np.quantile(pairs, _QUANTILE)) if len(pairs) else 0.0
    return -math.log(_DARK) / max(typical, _LEAST_DISTANCE)


def similarity(
    poses: Poses,
    *,
    beta: float | None = None,
    weights: Weights | None = None,
    out: tuple[Floats, Floats] | None = None,
    progress: Progress | None = None,
) -> Similarity:
    """Z and Z* of all pairs of moments of a recording.

    Parameters
    ----------
    poses : a `PoseSequence`, or unit quaternions (w, x, y, z), shape (frames, 15, 4).
    beta : contrast, above 0; None chooses by `default_beta`.
    weights : see `distance`.
    out : (z, z_mirror) to write into: float32, C-contiguous, shape (frames, frames), not overlapping. Reusing arrays saves
        half the time.
    progress : told the fraction done; may raise to stop, which leaves ``out`` half-written.

    Raises
    ------
    InputError
        If an argument cannot be used, or the matrices would not fit into the machine's memory.

    References
    ----------
    [Schultz2012] §3.1 (Z = C·exp(−β D), here with C = 1), §3.3 (Z*).
    """
    checked = check_poses(poses)
    share = check_weights(weights)
    if beta is not None and not (math.isfinite(beta) and beta > 0):
        raise InputError(f"Expected `beta` above 0, got {beta}.")
    frames = len(checked.quaternions)
    if out is None:
        _check_memory(frames)
    z, z_mirror = check_outputs((frames, frames), out, ("z", "z_mirror"))
    rule = BETA_RULE if beta is None else "given by the caller"
    value = default_beta(poses, share) if beta is None else float(beta)
    path = _kernel.chosen()
    packed = _kernel.pack(checked.quaternions, share, path, out=z)
    _kernel.fill_similarity(packed, value, z, z_mirror, path, fresh=out is None, progress=progress)
    return Similarity(z, z_mirror, value, rule, share, checked.fps)


def _check_memory(frames: int) -> None:
    """Refuse what cannot fit: the system would kill the program half-way, without a word."""
    need = 2 * 4 * frames * frames
    try:
        have = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):  # not known on this system
        return
    if need > have:
        raise InputError(
            f"Z and Z* of {frames:,} frames need {need / 1e9:.0f} GB and this machine has {have / 1e9:.0f} GB. Resample to "
            "fewer frames, or go tile by tile with kinesics.similarity.tiles."
        )
