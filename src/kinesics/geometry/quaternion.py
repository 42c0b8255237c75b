"""Unit quaternions ``(w, x, y, z)``: scalar first, Hamilton product, active rotation ([Schultz2012] §2.2).

Every function is batched: leading axes broadcast as in NumPy. ``q`` and ``−q`` are the same rotation and every
function that returns a rotation treats them alike.

- make: `identity`, `from_rotvec` (exponential), `from_matrix`, `from_axis_angle`, `between`
- combine: `multiply`, `conjugate`, `rotate`, `power`, `slerp`, `mean`
- take apart: `as_rotvec` (logarithm), `as_matrix`, `angle`, `swing_twist`, `yaw_tilt`
- the mirror: `mirror` (the operator w of §2.10)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class SwingTwist(NamedTuple):
    """``q = swing · twist``: the twist turns about the given axis, the swing about an axis at right angles to it."""

    swing: Array
    twist: Array


class YawTilt(NamedTuple):
    """``q = yaw · tilt``: yaw about +y in the world, tilt about a horizontal axis."""

    yaw: Array
    """Radians, shape (...)."""
    tilt: Array
    """Quaternions with y = 0, w ≥ 0, shape (..., 4)."""
    singular: NDArray[np.bool_]
    """True where the body is upside down so that yaw is not defined (it is given as 0), shape (...)."""


def identity(shape: tuple[int, ...] = ()) -> Array:
    """The rotation that turns nothing, shape ``(*shape, 4)``."""
    q = np.zeros((*shape, 4))
    q[..., 0] = 1.0
    return q


def normalize(q: ArrayLike) -> Array:
    """Scale to length 1. Shape (..., 4) to (..., 4).

    Raises
    ------
    ValueError
        If a quaternion is zero or not finite.
    """
    q = np.asarray(q, dtype=np.float64)
    norm = np.sqrt(np.einsum("...i,...i->...", q, q))[..., None]
    if not (np.all(np.isfinite(norm)) and np.all(norm > 0.0)):
        raise ValueError("Expected finite quaternions that are not zero.")
    return q / norm


def multiply(a: ArrayLike, b: ArrayLike) -> Array:
    """Hamilton product ``a · b``: first b turns, then a. Shapes (..., 4), broadcast."""
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    aw, ax, ay, az = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bw, bx, by, bz = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = aw * bw - ax * bx - ay * by - az * bz
    out[..., 1] = aw * bx + ax * bw + ay * bz - az * by
    out[..., 2] = aw * by - ax * bz + ay * bw + az * bx
    out[..., 3] = aw * bz + ax * by - ay * bx + az * bw
    return out


def conjugate(q: ArrayLike) -> Array:
    """The inverse rotation of unit quaternions. Shape (..., 4) to (..., 4)."""
    return np.asarray(q, dtype=np.float64) * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """Turn vectors: ``v + 2w q×v + 2q×(q×v)`` (§2.2, with its missing brackets). Shapes (..., 4) and (..., 3)."""
    q = np.asarray(q, dtype=np.float64)
    v = np.asarray(v, dtype=np.float64)
    w = q[..., :1]
    u = q[..., 1:]
    t = 2.0 * _cross(u, v)
    return v + w * t + _cross(u, t)


def mirror(q: ArrayLike) -> Array:
    """The reflection operator w of §2.10: ``(w, x, −y, −z)``, the rotation ``F R F`` with ``F = diag(−1, 1, 1)``."""
    return np.asarray(q, dtype=np.float64) * np.array([1.0, 1.0, -1.0, -1.0])


def canonical(q: ArrayLike) -> Array:
    """The one of ±q with w ≥ 0. For storage only: it does not commute with the mirror at w = 0."""
    q = np.asarray(q, dtype=np.float64)
    return np.where(q[..., :1] < 0.0, -q, q)


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> Array:
    """Turn by ``angle`` radians (...) about ``axis`` (..., 3), which need not be of length 1 (Euler pole, §2.1)."""
    axis = np.asarray(axis, dtype=np.float64)
    norm = np.linalg.norm(axis, axis=-1, keepdims=True)
    if not np.all(norm > 0.0):
        raise ValueError("Expected an axis that is not zero.")
    return from_rotvec(axis / norm * np.asarray(angle, dtype=np.float64)[..., None])


def from_rotvec(rotvec: ArrayLike) -> Array:
    """Exponential of SO(3): rotation vectors (..., 3), radians, to quaternions (..., 4)."""
    v = np.asarray(rotvec, dtype=np.float64)
    theta = np.linalg.norm(v, axis=-1, keepdims=True)
    # sin(θ/2)/θ is smooth through 0; np.sinc(x) = sin(πx)/(πx) has the limit built in.
    return np.concatenate([np.cos(theta / 2.0), 0.5 * np.sinc(theta / (2.0 * np.pi)) * v], axis=-1)


def as_rotvec(q: ArrayLike) -> Array:
    """Logarithm of SO(3): quaternions (..., 4) to rotation vectors (..., 3), radians, of length ≤ π."""
    q = np.asarray(q, dtype=np.float64)
    q = np.where(q[..., :1] < 0.0, -q, q)
    sin_half = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(sin_half, q[..., :1])
    # θ / sin(θ/2) → 2 as θ → 0
    scale = np.where(sin_half > 1e-150, 2.0 * half / np.where(sin_half > 1e-150, sin_half, 1.0), 2.0)
    return scale * q[..., 1:]


def angle(a: ArrayLike, b: ArrayLike | None = None) -> Array:
    """Angle of the rotation ``a``, or between ``a`` and ``b``, radians in [0, π]. Shape (..., 4) to (...)."""
    q = np.asarray(a, dtype=np.float64)
    if b is not None:
        q = multiply(conjugate(q), b)
    # atan2 stays exact near 0, where arccos of the dot product loses half its digits
    return 2.0 * np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), np.abs(q[..., 0]))


def as_matrix(q: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    q = np.asarray(q, dtype=np.float64)
    w, x, y, z = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    out = np.empty((*q.shape[:-1], 3, 3))
    out[..., 0, 0] = 1 - 2 * (y * y + z * z)
    out[..., 0, 1] = 2 * (x * y - w * z)
    out[..., 0, 2] = 2 * (x * z + w * y)
    out[..., 1, 0] = 2 * (x * y + w * z)
    out[..., 1, 1] = 1 - 2 * (x * x + z * z)
    out[..., 1, 2] = 2 * (y * z - w * x)
    out[..., 2, 0] = 2 * (x * z - w * y)
    out[..., 2, 1] = 2 * (y * z + w * x)
    out[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return out


def from_matrix(matrix: ArrayLike) -> Array:
    """Quaternions (..., 4) of rotation matrices (..., 3, 3).

    The largest of the four squared components is taken first (Shepperd 1978), so that no angle is special.
    """
    m = np.asarray(matrix, dtype=np.float64)
    d0, d1, d2 = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    four_squares = np.stack([1 + d0 + d1 + d2, 1 + d0 - d1 - d2, 1 - d0 + d1 - d2, 1 - d0 - d1 + d2], axis=-1)
    s_x, s_y, s_z = m[..., 2, 1] + m[..., 1, 2], m[..., 0, 2] + m[..., 2, 0], m[..., 1, 0] + m[..., 0, 1]
    a_x, a_y, a_z = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    # row k is 4·q_k·q: all four rows are the same quaternion, each safe where its own component is large
    rows = np.stack(
        [
            np.stack([four_squares[..., 0], a_x, a_y, a_z], axis=-1),
            np.stack([a_x, four_squares[..., 1], s_z, s_y], axis=-1),
            np.stack([a_y, s_z, four_squares[..., 2], s_x], axis=-1),
            np.stack([a_z, s_y, s_x, four_squares[..., 3]], axis=-1),
        ],
        axis=-2,
    )
    best = np.argmax(four_squares, axis=-1)
    q = np.take_along_axis(rows, best[..., None, None], axis=-2)[..., 0, :]
    return canonical(normalize(q))


def between(a: ArrayLike, b: ArrayLike) -> Array:
    """The smallest rotation that turns direction ``a`` onto direction ``b``. Shapes (..., 3) to (..., 4).

    For opposite directions any axis at right angles will do; the one chosen lies in the plane of ``a`` and the
    coordinate axis that ``a`` is least along, turned by a right angle.
    """
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    a = a / np.linalg.norm(a, axis=-1, keepdims=True)
    b = b / np.linalg.norm(b, axis=-1, keepdims=True)
    a, b = np.broadcast_arrays(a, b)
    q = np.concatenate([1.0 + np.sum(a * b, axis=-1, keepdims=True), _cross(a, b)], axis=-1)
    opposite = q[..., 0] < 1e-12
    if np.any(opposite):
        least = np.eye(3)[np.argmin(np.abs(a), axis=-1)]
        q = np.where(opposite[..., None], np.concatenate([np.zeros_like(q[..., :1]), _cross(a, least)], axis=-1), q)
    return normalize(q)


def power(q: ArrayLike, exponent: ArrayLike) -> Array:
    """``q`` taken ``exponent`` times (½ is halfway), along the shorter arc. Shapes (..., 4) and (...)."""
    return from_rotvec(as_rotvec(q) * np.asarray(exponent, dtype=np.float64)[..., None])


def slerp(a: ArrayLike, b: ArrayLike, t: ArrayLike) -> Array:
    """Spherical interpolation from ``a`` (t = 0) to ``b`` (t = 1) along the shorter arc. Shapes (..., 4), (...)."""
    a = np.asarray(a, dtype=np.float64)
    return multiply(a, power(multiply(conjugate(a), b), t))


def mean(q: ArrayLike, weights: ArrayLike | None = None) -> Array:
    """The rotation nearest to all: the principal eigenvector of Σ w q qᵀ (Markley 2007), blind to signs.

    Shape (n, ..., 4) to (..., 4): the first axis is averaged. ``weights`` has shape (n,).
    """
    q = np.asarray(q, dtype=np.float64)
    w = np.ones(len(q)) if weights is None else np.asarray(weights, dtype=np.float64)
    moment = np.einsum("n,n...i,n...j->...ij", w, q, q)
    return canonical(np.linalg.eigh(moment)[1][..., :, -1])


def continuous(q: ArrayLike) -> Array:
    """Choose signs along the first axis so that neighbours lie in the same half. Shape (frames, ..., 4)."""
    q = np.array(q, dtype=np.float64)
    flips = np.sum(q[1:] * q[:-1], axis=-1) < 0.0
    sign = np.where(np.cumsum(flips, axis=0) % 2 == 1, -1.0, 1.0)
    q[1:] *= sign[..., None]
    return q


def swing_twist(q: ArrayLike, axis: ArrayLike) -> SwingTwist:
    """Take ``q`` apart into ``swing · twist`` about ``axis`` (a unit vector of the frame that is turned).

    Where the swing is a half turn the twist is not defined and is given as none.

    Shapes (..., 4) and (3,) or (..., 3) to two of (..., 4).
    """
    q = np.asarray(q, dtype=np.float64)
    axis = np.asarray(axis, dtype=np.float64)
    along = np.sum(q[..., 1:] * axis, axis=-1, keepdims=True)
    twist = np.concatenate([q[..., :1], along * axis], axis=-1)
    norm = np.linalg.norm(twist, axis=-1, keepdims=True)
    twist = np.where(norm > 1e-12, twist / np.where(norm > 1e-12, norm, 1.0), identity())
    return SwingTwist(multiply(q, conjugate(twist)), twist)


def yaw_tilt(q: ArrayLike) -> YawTilt:
    """Take the orientation of a body apart into yaw about gravity and tilt ([Schultz2012] §2.8).

    The tilt depends only on the direction of gravity in the body: turning the body about +y in the world changes
    the yaw alone. Shape (..., 4).
    """
    q = np.asarray(q, dtype=np.float64)
    w, y = q[..., 0], q[..., 2]
    norm = np.hypot(w, y)
    singular = norm < 1e-6
    safe = np.where(singular, 1.0, norm)
    cos_half, sin_half = np.where(singular, 1.0, w / safe), np.where(singular, 0.0, y / safe)
    zero = np.zeros_like(cos_half)
    inverse_yaw = np.stack([cos_half, zero, -sin_half, zero], axis=-1)
    tilt = multiply(inverse_yaw, q)
    tilt[..., 2] = 0.0
    tilt = canonical(normalize(tilt))
    yaw = 2.0 * np.arctan2(sin_half, cos_half)
    return YawTilt(np.arctan2(np.sin(yaw), np.cos(yaw)), tilt, singular)


def _cross(a: Array, b: Array) -> Array:
    """Cross product, several times faster than ``np.cross`` on long batches."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)
