"""One rotation, one vector at a time, as tuples of plain numbers.

The same as in `kinesics.geometry.quaternion`, for what is done live: of few numbers NumPy takes ten times longer to prepare
its work than Python takes to do it. Nothing is checked here.
"""

from __future__ import annotations

import math
from typing import TypeAlias

Vector: TypeAlias = tuple[float, float, float]
"""x, y, z."""
Quaternion: TypeAlias = tuple[float, float, float, float]
"""w, x, y, z, of length 1."""


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Hamilton product ``a · b``: first b turns, then a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def undo(a: Quaternion, b: Quaternion) -> Quaternion:
    """``a⁻¹ · b``: the rotation b as seen from a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw + ax * bx + ay * by + az * bz,
        aw * bx - ax * bw - ay * bz + az * by,
        aw * by + ax * bz - ay * bw - az * bx,
        aw * bz - ax * by + ay * bx - az * bw,
    )


def rotate(q: Quaternion, v: Vector) -> Vector:
    """Turn a vector: ``v + 2w q×v + 2q×(q×v)``."""
    w, x, y, z = q
    vx, vy, vz = v
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return vx + w * tx + (y * tz - z * ty), vy + w * ty + (z * tx - x * tz), vz + w * tz + (x * ty - y * tx)


def from_rotvec(v: Vector) -> Quaternion:
    """Exponential of SO(3): a rotation vector, radians, to a quaternion."""
    x, y, z = v
    theta = math.sqrt(x * x + y * y + z * z)
    if theta == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    scale = math.sin(0.5 * theta) / theta
    return math.cos(0.5 * theta), scale * x, scale * y, scale * z


def as_rotvec(q: Quaternion) -> Vector:
    """Logarithm of SO(3): a quaternion to a rotation vector, radians, of length ≤ π."""
    w, x, y, z = q
    sin_half = math.sqrt(x * x + y * y + z * z)
    # θ / sin(θ/2) → 2 as θ → 0; of q and −q the one with w ≥ 0
    scale = 2.0 * math.atan2(sin_half, abs(w)) / sin_half if sin_half > 1e-150 else 2.0
    if w < 0.0:
        scale = -scale
    return scale * x, scale * y, scale * z


def least_turn(a: Vector, b: Vector) -> Quaternion:
    """The least rotation from direction a to direction b; none where either has no length or they are opposite."""
    la, lb = math.hypot(*a), math.hypot(*b)
    if la < 1e-12 or lb < 1e-12:
        return 1.0, 0.0, 0.0, 0.0
    ax, ay, az = a[0] / la, a[1] / la, a[2] / la
    # the turn of a onto the direction halfway, twice
    hx, hy, hz = ax + b[0] / lb, ay + b[1] / lb, az + b[2] / lb
    length = math.sqrt(hx * hx + hy * hy + hz * hz)
    if length < 2e-9:
        return 1.0, 0.0, 0.0, 0.0
    return 0.5 * length, (ay * hz - az * hy) / length, (az * hx - ax * hz) / length, (ax * hy - ay * hx) / length


def subtract(a: Vector, b: Vector) -> Vector:
    """a − b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def add(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def dot(a: Vector, b: Vector) -> float:
    """a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""
    ax, ay, az = a
    bx, by, bz = b
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def length(v: Vector) -> float:
    """Of a vector."""
    return math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
