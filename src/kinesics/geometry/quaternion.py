"""Unit quaternions ``(w, x, y, z)``: scalar first, Hamilton product, active rotation ([Schultz2012] §2.2).

Every function is batched: leading axes broadcast as in NumPy. ``q`` and ``−q`` are the same rotation and every
function that returns a rotation treats them alike. Angles are radians. Euler angles: `kinesics.geometry.euler`.

- make: `identity`, `from_rotvec` (exponential), `from_matrix`, `from_axis_angle`, `between`, `normalize`
- combine: `multiply`, `conjugate`, `rotate`, `power`, `slerp`, `mean`
- take apart: `as_rotvec` (logarithm), `offset` (of one from another), `as_axis_angle` (Euler pole), `as_matrix`, `angle`,
  `swing_twist`, `yaw_tilt`
- signs: `canonical` (for storage), `continuous` (along time)
- the mirror: `mirror` (the operator w of §2.10)
- other libraries: `as_scalar_last`, `from_scalar_last`

Products, turned vectors, logarithms and exponentials are compiled, where that was built, and NumPy's elsewhere.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics import compiled
from kinesics.errors import InputError

Array = NDArray[np.float64]


class AxisAngle(NamedTuple):
    """A rotation as Euler's theorem gives it: a turn by one angle about one axis (§2.1)."""

    axis: Array
    """The Euler pole, a unit vector, shape (..., 3); +x where the rotation turns nothing and has no pole."""
    angle: Array
    """Radians in [0, π], shape (...)."""


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
    InputError
        If a quaternion is zero or not finite; the message has the index of the first.
    """
    values = _components(q, 4, "quaternions")
    squared = np.einsum("...i,...i->...", values, values)[..., None]
    if not np.all((squared > 1e-200) & (squared < 1e200)):
        # the squares of very large or small components leave the range of floats: scale by the largest first
        largest = np.max(np.abs(values), axis=-1, keepdims=True)
        bad = ~(np.isfinite(largest) & (largest > 0.0))
        if bad.any():
            index = tuple(int(i) for i in np.argwhere(bad[..., 0])[0])
            at = f" at index {index if len(index) > 1 else index[0]}" if index else ""
            raise InputError(f"Expected finite quaternions that are not zero, got {values[index].tolist()}{at}.")
        values = values / largest
        squared = np.einsum("...i,...i->...", values, values)[..., None]
    return np.asarray(values / np.sqrt(squared))


def multiply(a: ArrayLike, b: ArrayLike) -> Array:
    """Hamilton product ``a · b``: first b turns, then a. Shapes (..., 4), broadcast."""
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    if compiled.wanted():
        out = np.empty((*_together(a, b), 4))
        compiled.native.quaternion_products(_rows(a, out), _rows(b, out), _rows(out, out))
        return out
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
    return np.asarray(np.multiply(q, [1.0, -1.0, -1.0, -1.0]), dtype=np.float64)


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """Turn vectors: ``v + 2w q×v + 2q×(q×v)`` (§2.2, with its missing brackets). Shapes (..., 4) and (..., 3)."""
    q = np.asarray(q, dtype=np.float64)
    v = np.asarray(v, dtype=np.float64)
    if compiled.wanted():
        out = np.empty((*_together(q, v), 3))
        compiled.native.quaternion_turned(_rows(q, out), _rows(v, out), _rows(out, out))
        return out
    w = q[..., :1]
    u = q[..., 1:]
    t = 2.0 * _cross(u, v)
    return v + w * t + _cross(u, t)


def mirror(q: ArrayLike) -> Array:
    """The reflection operator w of §2.10: ``(w, x, −y, −z)``, the rotation ``F R F`` with ``F = diag(−1, 1, 1)``."""
    return np.asarray(np.multiply(q, [1.0, 1.0, -1.0, -1.0]), dtype=np.float64)


def canonical(q: ArrayLike) -> Array:
    """The one of ±q with w ≥ 0, shape (..., 4). For storage only: it does not commute with the mirror at w = 0."""
    q = np.asarray(q, dtype=np.float64)
    return np.where(q[..., :1] < 0.0, -q, q)


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> Array:
    """Turn by ``angle`` radians (...) about ``axis`` (..., 3), which need not be of length 1 (Euler pole, §2.1).

    Raises
    ------
    InputError
        If an axis is zero or not finite.
    """
    half = 0.5 * np.asarray(angle, dtype=np.float64)[..., None]
    vector = np.sin(half) * _unit(axis, "axis")
    return np.concatenate([np.broadcast_to(np.cos(half), (*vector.shape[:-1], 1)), vector], axis=-1)


def as_axis_angle(q: ArrayLike) -> AxisAngle:
    """Euler pole and angle (§2.1), right for every angle: shape (..., 4) to (..., 3) and (...).

    The dissertation's θ = cos⁻¹((tr R − 1)/2), ω = (r₃₂−r₂₃, r₁₃−r₃₁, r₂₁−r₁₂)/(2 sin θ) loses half its digits near 0
    and all of them near π; here both come from the quaternion's vector.
    """
    q = canonical(q)
    vector = q[..., 1:]
    # scaled first, so that the square of a tiny vector does not vanish
    largest = np.max(np.abs(vector), axis=-1, keepdims=True)
    turns = largest > 0.0
    scaled = np.where(turns, vector / np.where(turns, largest, 1.0), np.array([1.0, 0.0, 0.0]))
    length = np.linalg.norm(scaled, axis=-1, keepdims=True)
    return AxisAngle(scaled / length, 2.0 * np.arctan2((largest * length)[..., 0], q[..., 0]))


def from_rotvec(rotvec: ArrayLike) -> Array:
    """Exponential of SO(3): rotation vectors (..., 3), radians, to quaternions (..., 4)."""
    v = np.asarray(rotvec, dtype=np.float64)
    if compiled.wanted():
        out = np.empty((*v.shape[:-1], 4))
        compiled.native.quaternion_exponentials(_rows(v, out), _rows(out, out))
        return out
    theta = np.linalg.norm(v, axis=-1, keepdims=True)
    # sin(θ/2)/θ is smooth through 0; np.sinc(x) = sin(πx)/(πx) has the limit built in.
    return np.concatenate([np.cos(theta / 2.0), 0.5 * np.sinc(theta / (2.0 * np.pi)) * v], axis=-1)


def as_rotvec(q: ArrayLike) -> Array:
    """Logarithm of SO(3): quaternions (..., 4) to rotation vectors (..., 3), radians, of length ≤ π."""
    q = np.asarray(q, dtype=np.float64)
    if compiled.wanted():
        out = np.empty((*q.shape[:-1], 3))
        compiled.native.quaternion_logarithms(_rows(q, out), _rows(out, out))
        return out
    q = np.where(q[..., :1] < 0.0, -q, q)
    sin_half = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(sin_half, q[..., :1])
    # θ / sin(θ/2) → 2 as θ → 0
    scale = np.where(sin_half > 1e-150, 2.0 * half / np.where(sin_half > 1e-150, sin_half, 1.0), 2.0)
    return scale * q[..., 1:]


def offset(a: ArrayLike, b: ArrayLike) -> Array:
    """Rotation vector of what turns ``a`` into ``b``: ``log(a⁻¹ · b)``, radians, of length ≤ π. Shapes (..., 4) to (..., 3)."""
    if not compiled.wanted():
        return as_rotvec(multiply(conjugate(a), b))
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    out = np.empty((*_together(a, b), 3))
    compiled.native.quaternion_offsets(_rows(a, out), _rows(b, out), _rows(out, out))
    return out


def angle(a: ArrayLike, b: ArrayLike | None = None) -> Array:
    """Angle of the rotation ``a``, or between ``a`` and ``b``, radians in [0, π]. Shape (..., 4) to (...)."""
    q = np.asarray(a, dtype=np.float64)
    if b is not None:
        b = np.asarray(b, dtype=np.float64)
        if compiled.wanted():
            out = np.empty((*_together(q, b), 1))
            compiled.native.quaternion_angles(_rows(q, out), _rows(b, out), _rows(out, out))
            return out[..., 0]
        q = multiply(conjugate(q), b)
    # atan2 stays exact near 0, where arccos of the dot product loses half its digits
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), np.abs(q[..., 0])))


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

    Raises
    ------
    InputError
        If a matrix is no rotation: not finite, RᵀR off the identity by more than 1e-3, or a reflection (det R < 0).
    """
    m: Array = np.asarray(matrix, dtype=np.float64)
    if m.shape[-2:] != (3, 3):
        raise InputError(f"Expected rotation matrices of shape (..., 3, 3), got {m.shape}.")
    if not np.isfinite(m).all():
        raise InputError("Expected rotation matrices (RᵀR = I, det R = 1). There is one that is not finite.")
    off = np.abs(np.swapaxes(m, -1, -2) @ m - np.eye(3)).max(axis=(-2, -1))
    determinant = np.sum(m[..., 0] * _cross(m[..., 1], m[..., 2]), axis=-1)
    bad = ~((off < 1e-3) & (determinant > 0.0))
    if bad.any():
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        at = f" Matrix {index if len(index) > 1 else index[0]}" if index else " It"
        raise InputError(
            f"Expected rotation matrices (RᵀR = I, det R = 1).{at} is off by {off[index]:.3g}, "
            f"with determinant {determinant[index]:.3g}."
        )
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

    For opposite directions any axis at right angles will do; the one chosen is also at right angles to the coordinate
    axis that ``a`` is least along.

    Raises
    ------
    InputError
        If a direction is zero or not finite.
    """
    a, b = np.broadcast_arrays(_unit(a, "direction"), _unit(b, "direction"))
    # The turn of a onto the direction halfway, twice. Its cosine is |a + b|/2, which keeps its digits near opposite
    # directions, where 1 + a·b (or a · halfway) would lose half of them.
    halfway = a + b
    length = np.linalg.norm(halfway, axis=-1, keepdims=True)
    opposite = length < 1e-15
    halfway = halfway / np.where(opposite, 1.0, length)
    q = np.concatenate([0.5 * length, _cross(a, halfway)], axis=-1)
    if np.any(opposite):
        least = np.eye(3)[np.argmin(np.abs(a), axis=-1)]
        q = np.where(opposite, np.concatenate([np.zeros_like(q[..., :1]), _cross(a, least)], axis=-1), q)
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

    Raises
    ------
    InputError
        If there is nothing to average, or the weights are of another length, negative or all zero.
    """
    q = _components(q, 4, "quaternions")
    if q.ndim < 2 or len(q) == 0:
        raise InputError(f"Expected quaternions of shape (n, ..., 4) with n ≥ 1, got {q.shape}.")
    w = np.ones(len(q)) if weights is None else np.asarray(weights, dtype=np.float64)
    if w.shape != (len(q),) or not (np.all(w >= 0.0) and np.sum(w) > 0.0):
        raise InputError(f"Expected {len(q)} `weights` that are not negative and not all zero, got {w.tolist()}.")
    moment = np.einsum("n,n...i,n...j->...ij", w, q, q)
    return canonical(np.linalg.eigh(moment)[1][..., :, -1])


def continuous(q: ArrayLike) -> Array:
    """Choose signs along the first axis so that neighbours lie in the same half. Shape (frames, ..., 4) to the same.

    The rotations stay what they are; the components become smooth curves that can be differenced and filtered.
    """
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


def as_scalar_last(q: ArrayLike) -> Array:
    """``(x, y, z, w)`` for SciPy, glTF and others that put the scalar last. Shape (..., 4).

    This and `from_scalar_last` are the only places where the order changes.
    """
    return np.asarray(q, dtype=np.float64)[..., [1, 2, 3, 0]]


def from_scalar_last(xyzw: ArrayLike) -> Array:
    """``(w, x, y, z)`` from ``(x, y, z, w)`` as SciPy and glTF give it. Shape (..., 4)."""
    return np.asarray(xyzw, dtype=np.float64)[..., [3, 0, 1, 2]]


def _together(a: Array, b: Array) -> tuple[int, ...]:
    """Leading axes of two arrays broadcast."""
    if a.shape[:-1] == b.shape[:-1]:
        return a.shape[:-1]
    return np.broadcast_shapes(a.shape[:-1], b.shape[:-1])


def _rows(values: Array, out: Array) -> Array:
    """As the compiled module takes them: three axes, the leading ones as those of ``out``; hardly ever copied."""
    leading, own = out.shape[:-1], values.shape[-1:]
    if values.shape[:-1] != leading:
        values = np.broadcast_to(values, leading + own)
    if len(leading) == 2:
        return values
    return (
        values[(None,) * (2 - len(leading))]
        if len(leading) < 2
        else values.reshape(math.prod(leading[:-1]), leading[-1], *own)
    )


def _components(values: ArrayLike, width: int, what: str) -> Array:
    array: Array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != width:
        raise InputError(f"Expected {what} of shape (..., {width}), got {array.shape}.")
    return array


def _unit(vectors: ArrayLike, what: str) -> Array:
    v = _components(vectors, 3, what)
    largest = np.max(np.abs(v), axis=-1, keepdims=True)
    bad = ~(np.isfinite(largest) & (largest > 0.0))[..., 0]
    if bad.any():
        first = tuple(int(i) for i in np.argwhere(bad)[0])
        raise InputError(f"Expected a finite {what} that is not zero, got {v[first].tolist()}.")
    # the square of a tiny vector would vanish
    v = v / largest
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def _cross(a: Array, b: Array) -> Array:
    """Cross product, several times faster than ``np.cross`` on long batches."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)
