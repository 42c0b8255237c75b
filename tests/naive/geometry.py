"""Geometry by the definition: power series of matrices, one rotation at a time."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def exp_matrix(matrix: Array) -> Array:
    """Matrix exponential as its power series, halved until it converges quickly, then squared back."""
    halvings = max(0, int(np.ceil(np.log2(max(np.abs(matrix).sum(), 1e-300)))) + 4)
    small = matrix / 2.0**halvings
    total = np.eye(len(matrix))
    term = np.eye(len(matrix))
    for n in range(1, 20):
        term = term @ small / n
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def hat(v: Array) -> Array:
    """§2.1: the matrix of v ×."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def hat_twist(twist: Array) -> Array:
    """§2.4 with its last row corrected to (0 0)."""
    out = np.zeros((4, 4))
    out[:3, :3] = hat(twist[3:])
    out[:3, 3] = twist[:3]
    return out


def rotation_matrix(axis: str, angle: float) -> Array:
    """§2.1: Rx, Ry, Rz as printed."""
    c, s = math.cos(angle), math.sin(angle)
    return {
        "x": np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]),
        "y": np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]),
        "z": np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]),
    }[axis]


def euler_matrix(angles: Array, order: str) -> Array:
    """Capitals: about the axes as they have been turned; small letters: about fixed axes."""
    total = np.eye(3)
    for letter, angle in zip(order, angles, strict=True):
        turn = rotation_matrix(letter.lower(), float(angle))
        total = total @ turn if letter.isupper() else turn @ total
    return total


def multiply(a: Array, b: Array) -> Array:
    """§2.2: (a0 b0 − a·b, a0 b + b0 a + a × b)."""
    scalar = a[0] * b[0] - float(np.dot(a[1:], b[1:]))
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([scalar, *vector])


def rotate(q: Array, v: Array) -> Array:
    """§2.2: q (0, v) q*."""
    return multiply(multiply(q, np.array([0.0, *v])), q * np.array([1.0, -1.0, -1.0, -1.0]))[1:]


def matrix(q: Array) -> Array:
    """The columns are where the axes go."""
    return np.stack([rotate(q, e) for e in np.eye(3)], axis=1)


def homogeneous(q: Array, p: Array) -> Array:
    """§2.3: rotation and translation in one matrix."""
    out = np.eye(4)
    out[:3, :3] = matrix(q)
    out[:3, 3] = p
    return out


def unhat_twist(m: Array) -> Array:
    """(v, ω) of ξ̂."""
    return np.array([*m[:3, 3], m[2, 1], m[0, 2], m[1, 0]])


def adjoint(g: Array) -> Array:
    """Column k is g ê_k g⁻¹, read as a twist."""
    columns = [unhat_twist(g @ hat_twist(e) @ np.linalg.inv(g)) for e in np.eye(6)]
    return np.stack(columns, axis=1)


def segment_distance(a0: Array, a1: Array, b0: Array, b1: Array, steps: int = 200) -> float:
    """Nearest approach of two segments: the best of a grid, then of finer grids about it."""
    low, high = np.zeros(2), np.ones(2)
    best = (math.inf, np.zeros(2))
    for _ in range(12):
        s = np.linspace(low[0], high[0], steps)
        t = np.linspace(low[1], high[1], steps)
        first = a0 + s[:, None] * (a1 - a0)
        second = b0 + t[:, None] * (b1 - b0)
        distance = np.linalg.norm(first[:, None] - second[None], axis=-1)
        i, j = np.unravel_index(np.argmin(distance), distance.shape)
        best = min(best, (float(distance[i, j]), np.array([s[i], t[j]])), key=lambda pair: pair[0])
        width = (high - low) / steps * 4.0
        low, high = np.clip(best[1] - width, 0.0, 1.0), np.clip(best[1] + width, 0.0, 1.0)
    return best[0]
