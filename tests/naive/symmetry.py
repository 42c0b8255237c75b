"""How far a movement is from a symmetry, the slow and obvious way: pair by pair."""

from __future__ import annotations

import math
from statistics import median

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PARTNER = (0, 1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 7, 8, 9, 10)


def gravity(q: Array) -> tuple[float, float, float]:
    """Where down is, in the frame of a body turned by q: the second row of its matrix, negated."""
    w, x, y, z = (float(v) for v in q)
    return (-2 * (x * y + w * z), -(1 - 2 * (x * x + z * z)), -2 * (y * z - w * x))


def mirrored(pose: Array) -> Array:
    """W: left and right swapped, y and z of every quaternion negated. Shape (15, 4)."""
    return np.array([pose[partner] * (1.0, 1.0, -1.0, -1.0) for partner in PARTNER])


def distance(a: Array, b: Array) -> float:
    """D of two poses (15, 4), all links of one weight, the root by gravity."""
    down = sum(p * q for p, q in zip(gravity(a[0]), gravity(b[0]), strict=True))
    total = 1.0 - math.sqrt(max(0.0, (1.0 + down) / 2.0))
    total += sum(1.0 - abs(float(dot)) for dot in (a[1:] * b[1:]).sum(axis=1))
    return total / 15.0


def span(poses: Array) -> float:
    """How far the movement goes: the 75th percentile of D between its poses."""
    some = poses[:: max(1, len(poses) // 20)]
    return float(np.percentile([distance(a, b) for a in some for b in some], 75))


def parallel(poses: Array, lag: int, *, mirror: bool) -> float:
    """Median D between each pose and the one ``lag`` frames later, mirrored if asked, relative to the span."""
    pairs = [(poses[i], poses[i + lag]) for i in range(len(poses) - lag)]
    return median(distance(a, mirrored(b) if mirror else b) for a, b in pairs) / span(poses)


def perpendicular(poses: Array, total: int, *, mirror: bool) -> float:
    """Median D between poses i and ``total`` − i: the movement against itself played backwards about a centre."""
    pairs = [(poses[i], poses[total - i]) for i in range(len(poses)) if 0 <= total - i < len(poses)]
    return median(distance(a, mirrored(b) if mirror else b) for a, b in pairs) / span(poses)
