"""Slow, obvious twins of `kinesics.body.contacts`: one frame after another."""

from __future__ import annotations

import numpy as np


def hysteresis(on: list[bool], stay: list[bool]) -> list[bool]:
    """A frame counts if walking away from it, one way or the other, without leaving ``stay``, one comes to an ``on``."""
    out = []
    for k in range(len(on)):
        found = False
        for step in (-1, 1):
            j = k
            while 0 <= j < len(on) and stay[j]:
                found = found or on[j]
                j += step
        out.append(found)
    return out


def bearing(performance_motion, contact_points, skeleton, tolerance: float) -> np.ndarray:
    """Whether any of the performer's own points of either foot is within ``tolerance`` of y = 0; shape (frames, 2)."""
    world = performance_motion.global_rotations()
    where = performance_motion.positions()
    out = np.zeros((len(where), 2), dtype=bool)
    for point in contact_points:
        side = 0 if skeleton.joint_names[point.joint].startswith("Left") else 1
        for t in range(len(where)):
            w, x, y, z = world[t, point.joint]
            turn = np.array(
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]  # the matrix's second row
            )
            height = where[t, point.joint, 1] + turn @ np.array(point.offset) - point.radius
            out[t, side] |= height < tolerance
    return out
