"""Euler angles in every order, to and from quaternions ([Schultz2012] §2.1).

An order is up to three letters, read as SciPy reads them. Capitals are **intrinsic**: each turn is about an axis of the
frame as it has been turned so far, so ``"ZYX"`` is R = Rz·Ry·Rx. Small letters are **extrinsic**: each turn is about a
fixed axis, so ``"xyz"`` is the same R = Rz·Ry·Rx with the angles listed the other way round. Angles are listed in the
order of the letters, in radians.

- `from_euler`, `as_euler`: any of the 24 orders (`ORDERS`)
- `from_fick`, `as_fick`: the dissertation's R(θx, θy, θz) = Rz·Ry·Rx, which is ``"xyz"``; ASF/AMC files use it
"""

from __future__ import annotations

from itertools import pairwise, product
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError

Array = NDArray[np.float64]

_INTRINSIC: Final = tuple("".join(o) for o in product("XYZ", repeat=3) if o[0] != o[1] != o[2])

ORDERS: Final[tuple[str, ...]] = _INTRINSIC + tuple(o.lower() for o in _INTRINSIC)
"""The 12 intrinsic orders, then the 12 extrinsic ones. The half with three different axes are called Tait-Bryan or
Cardan angles, the half with the first axis again at the end proper Euler angles."""

FICK: Final = "xyz"
"""Angles (θx, θy, θz) about the fixed x, then y, then z axis: R = Rz·Ry·Rx (§2.1)."""

LOCK_TOLERANCE: Final = 1e-7
"""Radians between the middle angle and gimbal lock below which `as_euler` reports it."""


class EulerAngles(NamedTuple):
    """Euler angles, and where they are not unique."""

    angles: Array
    """Radians, in the order of the letters, shape (..., 3). The outer two lie in [−π, π]; the middle one in [−π/2,
    π/2], or in [0, π] where the first axis comes again at the end."""
    gimbal_lock: NDArray[np.bool_]
    """True where the first and third axis coincide, shape (...): only the sum or difference of the outer angles is
    defined. The rotation is still the same; at the lock itself the third angle is 0."""


def from_euler(angles: ArrayLike, order: str) -> Array:
    """Quaternions (..., 4) from Euler angles (..., n), radians, n the number of letters of ``order`` (1 to 3).

    Parameters
    ----------
    angles : listed in the order of the letters, shape (..., n).
    order : such as "ZYX" (intrinsic) or "xyz" (extrinsic); see the module. Joints with one or two degrees of freedom
        have one or two letters.

    Raises
    ------
    InputError
        If the order is not one, or the last axis of ``angles`` has another length.
    """
    axes, intrinsic = _parse(order, shortest=1)
    angles = np.asarray(angles, dtype=np.float64)
    if angles.ndim == 0 or angles.shape[-1] != len(axes):
        raise InputError(f"Expected `angles` of shape (..., {len(axes)}) for the order '{order}', got {angles.shape}.")
    # components first: long contiguous rows are several times faster than rows of three
    half = 0.5 * np.moveaxis(angles, -1, 0)
    c, s = np.cos(half), np.sin(half)
    if not intrinsic:
        axes, c, s = axes[::-1], c[::-1], s[::-1]
    out = np.zeros((*angles.shape[:-1], 4))
    if len(axes) == 1:
        out[..., 0] = c[0]
        out[..., 1 + axes[0]] = s[0]
        return out
    i, j = axes[:2]
    k = 3 - i - j
    parity = 1.0 if (j - i) % 3 == 1 else -1.0
    if len(axes) == 2:
        out[..., 0] = c[0] * c[1]
        out[..., 1 + i] = s[0] * c[1]
        out[..., 1 + j] = c[0] * s[1]
        out[..., 1 + k] = parity * s[0] * s[1]
        return out
    cc, cs, sc, ss = c[0] * c[2], c[0] * s[2], s[0] * c[2], s[0] * s[2]
    if axes[2] == i:
        out[..., 0] = c[1] * (cc - ss)
        out[..., 1 + i] = c[1] * (sc + cs)
        out[..., 1 + j] = s[1] * (cc + ss)
        out[..., 1 + k] = parity * s[1] * (sc - cs)
    else:
        out[..., 0] = cc * c[1] - parity * ss * s[1]
        out[..., 1 + i] = sc * c[1] + parity * cs * s[1]
        out[..., 1 + j] = cc * s[1] - parity * ss * c[1]
        out[..., 1 + k] = cs * c[1] + parity * sc * s[1]
    return out


def as_euler(q: ArrayLike, order: str) -> EulerAngles:
    """Euler angles (..., 3), radians, of unit quaternions (..., 4), in one of the 24 orders.

    The angles come straight from the quaternion (Bernardes & Viollet 2022), without a matrix and without loss near
    gimbal lock: `from_euler` gives back the same rotation in every case. q and −q give the same angles.

    Raises
    ------
    InputError
        If the order is none of `ORDERS`.
    """
    axes, intrinsic = _parse(order, shortest=3)
    q = np.asarray(q, dtype=np.float64)
    if q.ndim == 0 or q.shape[-1] != 4:
        raise InputError(f"Expected quaternions of shape (..., 4), got {q.shape}.")
    i, j, last = axes if not intrinsic else axes[::-1]
    proper = i == last
    k = 3 - i - j
    parity = 1.0 if (j - i) % 3 == 1 else -1.0
    w, x, y, z = q[..., 0], q[..., 1 + i], q[..., 1 + j], parity * q[..., 1 + k]
    # a turn of the middle axis by a right angle makes three different axes into the case of a repeated one
    a, b, c, d = (w, x, y, z) if proper else (w - y, x + z, y + w, z - x)
    near_zero, near_pi = np.hypot(c, d), np.hypot(a, b)
    middle = 2.0 * np.arctan2(near_zero, near_pi)
    half_sum, half_difference = np.arctan2(b, a), np.arctan2(d, c)
    first, third = half_sum - half_difference, half_sum + half_difference
    # With one pair of components exactly nothing its angle is noise: put everything into the angle listed first. Where
    # the pair is merely tiny, the angles are kept, since any others would change the rotation.
    size = 1e-15 * np.hypot(near_zero, near_pi)
    at_zero, at_pi = near_zero <= size, near_pi <= size
    if intrinsic:
        first, third = np.where(at_zero | at_pi, 0.0, first), np.where(at_zero, 2.0 * half_sum, third)
        third = np.where(at_pi, 2.0 * half_difference, third)
    else:
        first, third = np.where(at_zero, 2.0 * half_sum, first), np.where(at_zero | at_pi, 0.0, third)
        first = np.where(at_pi, -2.0 * half_difference, first)
    if not proper:
        third = parity * third
    lock = np.minimum(middle, np.pi - middle) < LOCK_TOLERANCE
    if not proper:
        middle = middle - 0.5 * np.pi
    listed = (third, middle, first) if intrinsic else (first, middle, third)
    angles = np.stack(listed, axis=-1)
    outer = angles[..., ::2]
    angles[..., ::2] = outer - 2.0 * np.pi * np.round(outer / (2.0 * np.pi))
    return EulerAngles(angles, np.asarray(lock))


def from_fick(angles: ArrayLike) -> Array:
    """Quaternions (..., 4) from Fick angles (θx, θy, θz), radians (..., 3): R = Rz·Ry·Rx (§2.1)."""
    return from_euler(angles, FICK)


def as_fick(q: ArrayLike) -> EulerAngles:
    """Fick angles (θx, θy, θz), radians (..., 3), of quaternions (..., 4): R = Rz·Ry·Rx (§2.1)."""
    return as_euler(q, FICK)


def _parse(order: str, shortest: int) -> tuple[tuple[int, ...], bool]:
    """Axes as 0, 1, 2 and whether the order is intrinsic."""
    axes = tuple("xyz".find(letter) for letter in order.lower())
    lawful = shortest <= len(axes) <= 3 and -1 not in axes and all(a != b for a, b in pairwise(axes))
    if not lawful or not (order.isupper() or order.islower()):
        raise InputError(
            f"'{order}' is no order of Euler angles. Expected {'three' if shortest == 3 else 'one to three'} letters, "
            "no axis twice running: capitals for intrinsic (about the turned axes) such as 'ZXY', small letters for "
            "extrinsic (about the fixed axes) such as 'xyz'."
        )
    return axes, order.isupper()
