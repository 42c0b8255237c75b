"""Rigid motions: SE(3) as rotation and translation, or as 4x4 homogeneous matrices ([Schultz2012] §2.3).

``g_AB = (Q, p)`` takes coordinates in frame B to coordinates in frame A: r_A = Q r_B + p. As a set SE(3) is R³ × SO(3);
as a group it is the **semidirect** product, since composition turns the second translation (the dissertation prints the
direct product). Everything is batched: leading axes broadcast as in NumPy. Twists are (v, ω): see
`kinesics.geometry.twists`.

- make: `identity`, `from_matrix`, `exp`
- combine: `compose`, `inverse`, `apply`
- take apart: `as_matrix`, `log`, `adjoint`

Source for the adjoint, exponential and logarithm: Murray, Li & Sastry, *A Mathematical Introduction to Robotic
Manipulation* (1994), ch. 2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]


class Rigid(NamedTuple):
    """A rigid motion g: r ↦ Q r + p."""

    rotation: Array
    """Q, unit quaternions (w, x, y, z), shape (..., 4)."""
    translation: Array
    """p, metres, shape (..., 3)."""


def identity(shape: tuple[int, ...] = ()) -> Rigid:
    """The rigid motion that moves nothing, of batch shape ``shape``."""
    return Rigid(quaternion.identity(shape), np.zeros((*shape, 3)))


def compose(a: Rigid, b: Rigid) -> Rigid:
    """``g_AC = g_AB · g_BC``: first b moves, then a (§2.3). Batch shapes broadcast."""
    translation = np.asarray(a.translation, dtype=np.float64) + quaternion.rotate(a.rotation, b.translation)
    return Rigid(quaternion.multiply(a.rotation, b.rotation), translation)


def inverse(g: Rigid) -> Rigid:
    """``g_BA`` of ``g_AB``: (Q*, −Q* p) (§2.3)."""
    back = quaternion.conjugate(g.rotation)
    return Rigid(back, -quaternion.rotate(back, g.translation))


def apply(g: Rigid, points: ArrayLike) -> Array:
    """Points (..., 3) in frame B to frame A: Q r + p (§2.3)."""
    return quaternion.rotate(g.rotation, points) + np.asarray(g.translation, dtype=np.float64)


def as_matrix(g: Rigid) -> Array:
    """Homogeneous matrices (..., 4, 4): rotation, translation, last row (0 0 0 1) (§2.3)."""
    rotation = quaternion.as_matrix(g.rotation)
    translation = np.asarray(g.translation, dtype=np.float64)
    out = np.zeros((*np.broadcast_shapes(rotation.shape[:-2], translation.shape[:-1]), 4, 4))
    out[..., :3, :3] = rotation
    out[..., :3, 3] = translation
    out[..., 3, 3] = 1.0
    return out


def from_matrix(matrix: ArrayLike) -> Rigid:
    """The rigid motion of homogeneous matrices (..., 4, 4).

    Raises
    ------
    InputError
        If the shape or the last row is wrong, the upper left is no rotation, or a value is not finite.
    """
    m = np.asarray(matrix, dtype=np.float64)
    if m.shape[-2:] != (4, 4):
        raise InputError(f"Expected homogeneous matrices of shape (..., 4, 4), got {m.shape}.")
    if not np.all(np.abs(m[..., 3, :] - np.array([0.0, 0.0, 0.0, 1.0])) < 1e-9):
        raise InputError("Expected homogeneous matrices of rigid motions: the last row is (0, 0, 0, 1).")
    if not np.all(np.isfinite(m[..., :3, 3])):
        raise InputError("Expected homogeneous matrices with finite translations.")
    return Rigid(quaternion.from_matrix(m[..., :3, :3]), m[..., :3, 3].copy())


def adjoint(g: Rigid) -> Array:
    """The matrices (..., 6, 6) that take twists (v, ω) in frame B to frame A: [[R, p̂R], [0, R]].

    ``adjoint(compose(a, b)) = adjoint(a) @ adjoint(b)``, and g·exp(ξ)·g⁻¹ = exp(adjoint(g) @ ξ).
    """
    rotation = quaternion.as_matrix(g.rotation)
    translation = np.asarray(g.translation, dtype=np.float64)
    out = np.zeros((*np.broadcast_shapes(rotation.shape[:-2], translation.shape[:-1]), 6, 6))
    out[..., :3, :3] = rotation
    out[..., 3:, 3:] = rotation
    # column by column, p̂R is p × (column of R)
    out[..., :3, 3:] = np.cross(translation[..., None, :], np.swapaxes(rotation, -1, -2)).swapaxes(-1, -2)
    return out


def exp(twist: ArrayLike) -> Rigid:
    """Exponential of SE(3): twists (v, ω), shape (..., 6), to the rigid motion they reach in unit time.

    Q = exp(ω̂) and p = V v with V = I + (1 − cos θ)/θ² ω̂ + (θ − sin θ)/θ³ ω̂², θ = |ω|.
    """
    v, omega = _split(twist)
    theta2 = np.sum(omega * omega, axis=-1, keepdims=True)
    theta = np.sqrt(theta2)
    first = 0.5 * np.sinc(theta / (2.0 * np.pi)) ** 2
    # θ − sin θ cancels below half a radian; six terms of its series are exact to rounding there
    small = theta < 0.5
    series = 1 / 6 - theta2 * (
        1 / 120 - theta2 * (1 / 5040 - theta2 * (1 / 362880 - theta2 * (1 / 39916800 - theta2 / 6227020800)))
    )
    safe = np.where(small, 1.0, theta)
    second = np.where(small, series, (safe - np.sin(safe)) / safe**3)
    turned = np.cross(omega, v)
    return Rigid(quaternion.from_rotvec(omega), v + first * turned + second * np.cross(omega, turned))


def log(g: Rigid) -> Array:
    """Logarithm of SE(3): the twist (v, ω), shape (..., 6), that reaches ``g`` in unit time; |ω| ≤ π.

    v = V⁻¹ p with V⁻¹ = I − ½ω̂ + (1 − (θ/2) cot(θ/2))/θ² ω̂². First order, near the identity, it is g − I (§2.4, whose
    last row must read (0 0)). At θ = π the two opposite axes are both right and either may come.
    """
    omega = quaternion.as_rotvec(g.rotation)
    p = np.asarray(g.translation, dtype=np.float64)
    theta2 = np.sum(omega * omega, axis=-1, keepdims=True)
    x2 = theta2 / 4.0
    small = theta2 < 0.25
    # (1 − x cot x)/(4x²), x = θ/2, by its series where the difference cancels
    series = 0.25 * (
        1 / 3
        + x2
        * (1 / 45 + x2 * (2 / 945 + x2 * (1 / 4725 + x2 * (2 / 93555 + x2 * (1382 / 638512875 + x2 * 4 / 18243225)))))
    )
    x = np.sqrt(np.where(small, 1.0, x2))
    second = np.where(small, series, (1.0 - x / np.tan(x)) / (4.0 * x * x))
    turned = np.cross(omega, p)
    return np.concatenate(
        [p - 0.5 * turned + second * np.cross(omega, turned), np.broadcast_to(omega, turned.shape)], axis=-1
    )


def _split(twist: ArrayLike) -> tuple[Array, Array]:
    twist = np.asarray(twist, dtype=np.float64)
    if twist.ndim == 0 or twist.shape[-1] != 6:
        raise InputError(f"Expected twists (v, ω) of shape (..., 6), got {twist.shape}.")
    return twist[..., :3], twist[..., 3:]
