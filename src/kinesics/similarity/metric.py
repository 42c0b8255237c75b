"""The pose metric D, its mirror D*, and what follows from them along time ([Schultz2012] §2.13-2.14, §3.2).

D(a, b) = 1 − Σᵢ wᵢ |qᵢ·gᵢ| / Σᵢ wᵢ over the links but the root, whose term is √((1 + g_a·g_b)/2), with g the direction of
gravity in the frame of the pelvis: the greatest |q_a·q_b| over all headings. The modulus is taken for each link, because the
sign of a quaternion means nothing. D lies in [0, 1]; D*(a, b) = D(a, Wb) with W the mirror of §2.10.

D is half a squared chord and no metric (the dissertation's fourth axiom fails); √(2D) is one: see `chord`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body import pose
from kinesics.errors import InputError
from kinesics.similarity import _kernel
from kinesics.similarity._inputs import Poses, Weights, check_poses, check_weights

Array = NDArray[np.float64]
Floats = NDArray[np.float32]


def distance(a: Poses, b: Poses, weights: Weights | None = None) -> Floats:
    """D: ``out[i, j]`` is the distance of frame i of ``a`` from frame j of ``b``, in [0, 1].

    Parameters
    ----------
    a, b : poses of any two recordings, or arrays of unit quaternions (w, x, y, z), shapes (frames, 15, 4).
    weights : 15 numbers in the order of `kinesics.vocabulary.LINKS`, or a mapping of link names ("femur" for both sides);
        not negative, left equal to right; None weighs all alike.

    Returns
    -------
    float32, shape (len(a), len(b)). Rounding leaves up to 4e-7 between equal poses.

    Raises
    ------
    InputError
        If poses or weights cannot be used; the message says which and why.

    References
    ----------
    [Schultz2012] §2.13, with the modulus for each joint and the root by gravity.
    """
    return _matrix(check_poses(a, "a").quaternions, check_poses(b, "b").quaternions, check_weights(weights))


def mirror_distance(a: Poses, b: Poses, weights: Weights | None = None) -> Floats:
    """D*: ``out[i, j]`` is the distance of frame i of ``a`` from the mirror image of frame j of ``b``, in [0, 1].

    D*(a, a) is 0 only for a symmetric pose. Parameters, result and errors are those of `distance`.

    References
    ----------
    [Schultz2012] §2.14.
    """
    image = np.ascontiguousarray(pose.mirror(check_poses(b, "b").quaternions))
    return _matrix(check_poses(a, "a").quaternions, image, check_weights(weights))


def _matrix(a: Array, b: Array, weights: Array) -> Floats:
    path = _kernel.chosen()
    d = np.empty((len(a), len(b)), dtype=np.float32)
    packed = _kernel.pack(a, weights, path)
    _kernel.fill_distances(packed, packed if b is a else _kernel.pack(b, weights, path), d, None, path)
    return d


def chord(d: ArrayLike) -> Array:
    """√(2D), the metric: it obeys the triangle inequality, D does not. Any shape.

    √(2D*) is no metric, but √(2D*)(a, c) ≤ √(2D)(a, b) + √(2D*)(b, c) and √(2D)(a, c) ≤ √(2D*)(a, b) + √(2D*)(b, c).
    """
    return np.sqrt(2.0 * np.maximum(np.asarray(d, dtype=np.float64), 0.0))


def paired_distance(a: Poses, b: Poses, weights: Weights | None = None) -> Array:
    """D of frame k of ``a`` and frame k of ``b``, to float64's precision, shape (frames,).

    1 − |q·g| is taken as min(|q − g|, |q + g|)²/2, and the root's term likewise, so that small distances keep their digits:
    1 − |q·g| itself can be negative, and in float32 gives speeds a floor of .02-.08 1/s at 120 fps.

    Raises
    ------
    InputError
        If poses or weights cannot be used, or the numbers of frames differ.
    """
    q, g, share = check_poses(a, "a").quaternions, check_poses(b, "b").quaternions, check_weights(weights)
    if len(q) != len(g):
        raise InputError(f"Expected `a` and `b` of as many frames, got {len(q)} and {len(g)}.")
    return _paired(_Checked.of(q), _Checked.of(g), share)


class Frames:
    """The poses of a recording, checked once, to be compared a few at a time: as `paired_distance`, for many short calls.

    Raises
    ------
    InputError
        If poses or weights cannot be used.
    """

    def __init__(self, poses: Poses, weights: Weights | None = None) -> None:
        self._poses = _Checked.of(check_poses(poses).quaternions)
        self._share = check_weights(weights)

    def distance_from(self, frame: int, start: int, end: int) -> Array:
        """D of one frame and each of the frames [start, end), shape (end − start,)."""
        return _paired(self._poses.part(start, end), self._poses.part(frame, frame + 1), self._share)


class _Checked(NamedTuple):
    """What D is made of."""

    quaternions: Array
    """Unit, shape (frames, 15, 4)."""
    gravity: Array
    """In the frame of the pelvis, shape (frames, 3)."""

    @classmethod
    def of(cls, q: Array) -> _Checked:
        return cls(q, pose.gravity(q))

    def part(self, start: int, end: int) -> _Checked:
        return _Checked(self.quaternions[start:end], self.gravity[start:end])


def _paired(a: _Checked, b: _Checked, weights: Array) -> Array:
    """D of each frame of ``a`` and that of ``b``, or the only one of ``b``."""
    minus, plus = a.quaternions - b.quaternions, a.quaternions + b.quaternions
    chords = np.minimum(np.einsum("fji,fji->fj", minus, minus), np.einsum("fji,fji->fj", plus, plus))
    sine = np.linalg.norm(a.gravity - b.gravity, axis=-1) / 2.0  # of half the angle between the two
    cosine = np.linalg.norm(a.gravity + b.gravity, axis=-1) / 2.0
    root = sine**2 / (1.0 + cosine)
    share = weights / weights.sum()
    return np.asarray(share[0] * root + 0.5 * (chords[:, 1:] @ share[1:]))


def speed(poses: Poses, *, fps: float | None = None, weights: Weights | None = None) -> Array:
    """How fast the body moves: √(2D)/Δt, half the root mean square angular speed of the joints, in 1/s.

    Parameters
    ----------
    poses : of one recording.
    fps : frames a second; needed for an array, taken from a `PoseSequence`.
    weights : see `distance`.

    Returns
    -------
    float64, shape (frames,): entry i is the speed between frames i − 1 and i, entry 0 repeats entry 1; a single frame has
    speed 0. Nothing is smoothed.

    Raises
    ------
    InputError
        If poses or weights cannot be used, or the frame rate is missing or not positive.

    References
    ----------
    [Schultz2012] §3.2, with √(2D) in place of D.
    """
    checked = check_poses(poses)
    rate = checked.fps if fps is None else fps
    if rate is None:
        raise InputError("An array of poses has no frame rate: give `fps`.")
    if not (np.isfinite(rate) and rate > 0):
        raise InputError(f"Expected `fps` above 0, got {rate}.")
    q = checked.quaternions
    out = np.zeros(len(q))
    if len(q) > 1:
        every = _Checked.of(q)
        out[1:] = chord(_paired(every.part(1, len(q)), every.part(0, len(q) - 1), check_weights(weights))) * rate
        out[0] = out[1]
    return out


def symmetry_residual(poses: Poses, weights: Weights | None = None) -> Array:
    """D*(a, a) of every frame: 0 for a symmetric pose, the diagonal of Z* before the exponential.

    With equal weights this is 2·mean|A|² of the antisymmetric parts (`kinesics.body.pose.symmetry_parts`).

    Returns
    -------
    float64, shape (frames,).

    Raises
    ------
    InputError
        If poses or weights cannot be used.

    References
    ----------
    [Schultz2012] §2.11, §2.14, §3.3.
    """
    q = check_poses(poses).quaternions
    return _paired(_Checked.of(q), _Checked.of(pose.mirror(q)), check_weights(weights))
