"""Twists: the instantaneous motion of a rigid body, and velocities of a sampled motion ([Schultz2012] §2.4).

A twist is ξ = (v, ω), shape (..., 6): v in m/s first, then ω in rad/s (Murray, Li & Sastry 1994). In the **body** frame
ω̂ᴮ = Q*Q̇ and vᴮ = Q*ṗ; in the **space** frame ω̂ᴬ = Q̇Q* and vᴬ = ṗ − ω̂ᴬp, the velocity of the point of the body that
is passing the world's origin, **not** that of the body. (§2.4 prints ω̂ᴮ = Q̇ and ξ̂ = g − I with last row (0 1): true
to first order near the identity only, and the last row is (0 0).)

- matrices: `hat`, `vee` (so(3)); `hat_twist`, `vee_twist` (se(3))
- of a sampled motion: `body_velocity`, `space_velocity`, `angular_velocity_body`, `angular_velocity_space`
- of a point: `point_velocity`

Velocities are differences on the group: the mean of the logarithms of the step into and the step out of each frame. A
step's logarithm is the same seen from both its ends, so the mean is sound, of second order in the time step, exact for
a screw motion at constant rate, and right up to half a turn a frame (a difference over two frames would alias at a
quarter). The first and last frame have one step only and are of first order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.geometry import quaternion, rigid
from kinesics.geometry.rigid import Rigid

Array = NDArray[np.float64]


def hat(omega: ArrayLike) -> Array:
    """The matrix ω̂ with ω̂ r = ω × r. Shape (..., 3) to (..., 3, 3), skew symmetric (§2.1)."""
    omega = np.asarray(omega, dtype=np.float64)
    x, y, z = omega[..., 0], omega[..., 1], omega[..., 2]
    out = np.zeros((*omega.shape[:-1], 3, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -z, y, -x
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = z, -y, x
    return out


def vee(matrix: ArrayLike) -> Array:
    """ω of ω̂, shape (..., 3, 3) to (..., 3); of any matrix, that of its skew part."""
    m = np.asarray(matrix, dtype=np.float64)
    return 0.5 * np.stack(
        [m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]], axis=-1
    )


def hat_twist(twist: ArrayLike) -> Array:
    """The matrix ξ̂ = [[ω̂, v], [0, 0]] of a twist. Shape (..., 6) to (..., 4, 4)."""
    twist = np.asarray(twist, dtype=np.float64)
    out = np.zeros((*twist.shape[:-1], 4, 4))
    out[..., :3, :3] = hat(twist[..., 3:])
    out[..., :3, 3] = twist[..., :3]
    return out


def vee_twist(matrix: ArrayLike) -> Array:
    """The twist (v, ω) of ξ̂. Shape (..., 4, 4) to (..., 6)."""
    m = np.asarray(matrix, dtype=np.float64)
    return np.concatenate([m[..., :3, 3], vee(m[..., :3, :3])], axis=-1)


def body_velocity(g: Rigid, fps: float) -> Array:
    """Body-frame twists (vᴮ, ωᴮ) of a sampled rigid motion, m/s and rad/s.

    Parameters
    ----------
    g : rotation (frames, ..., 4) and translation (frames, ..., 3); time is the first axis.
    fps : frames a second.

    Returns
    -------
    Array
        Shape (frames, ..., 6).

    Raises
    ------
    InputError
        If there are fewer than two frames, or the frame rate is not above 0.
    """
    q, p = np.asarray(g.rotation, dtype=np.float64), np.asarray(g.translation, dtype=np.float64)
    if q.shape[:-1] != p.shape[:-1]:
        raise InputError(f"Expected as many rotations as translations, got {q.shape[:-1]} and {p.shape[:-1]}.")
    _check_sampling(q, fps)
    steps = rigid.log(rigid.compose(rigid.inverse(Rigid(q[:-1], p[:-1])), Rigid(q[1:], p[1:])))
    return _centre(steps) * fps


def space_velocity(g: Rigid, fps: float) -> Array:
    """Space-frame twists (vᴬ, ωᴬ) of a sampled rigid motion: the adjoint of the body-frame ones. Shape (frames, ...,
    6).
    """
    body = body_velocity(g, fps)
    v, omega = quaternion.rotate(g.rotation, body[..., :3]), quaternion.rotate(g.rotation, body[..., 3:])
    return np.concatenate([v + np.cross(g.translation, omega), omega], axis=-1)


def angular_velocity_body(q: ArrayLike, fps: float) -> Array:
    """ωᴮ with ω̂ᴮ = Q*Q̇, rad/s, of sampled orientations (frames, ..., 4). Shape (frames, ..., 3).

    Raises
    ------
    InputError
        If there are fewer than two frames, or the frame rate is not above 0.
    """
    q = np.asarray(q, dtype=np.float64)
    _check_sampling(q, fps)
    return _centre(quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(q[:-1]), q[1:]))) * fps


def angular_velocity_space(q: ArrayLike, fps: float) -> Array:
    """ωᴬ with ω̂ᴬ = Q̇Q*, rad/s, of sampled orientations (frames, ..., 4). Shape (frames, ..., 3)."""
    return quaternion.rotate(q, angular_velocity_body(q, fps))


def point_velocity(twist: ArrayLike, point: ArrayLike) -> Array:
    """Velocity, m/s, of the body's point that is at ``point`` (..., 3), both in the same frame: v + ω × r."""
    twist = np.asarray(twist, dtype=np.float64)
    return twist[..., :3] + np.cross(twist[..., 3:], np.asarray(point, dtype=np.float64))


def _centre(steps: Array) -> Array:
    """Mean of the step into and the step out of each frame. Shape (frames − 1, ...) to (frames, ...)."""
    out = np.empty((len(steps) + 1, *steps.shape[1:]))
    out[0], out[-1] = steps[0], steps[-1]
    out[1:-1] = 0.5 * (steps[:-1] + steps[1:])
    return out


def _check_sampling(q: Array, fps: float) -> None:
    if q.ndim < 2 or q.shape[-1] != 4 or len(q) < 2:
        raise InputError(f"Expected at least two frames of quaternions, shape (frames, ..., 4), got {q.shape}.")
    if not (np.isfinite(fps) and fps > 0):
        raise InputError(f"Expected a frame rate above 0, got {fps}.")
