"""Joints beyond the limits that the file itself gives (ASF ``limits``; [Schultz2012] §2.9)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body.motion import Motion
from kinesics.body.skeleton import JointFreedom
from kinesics.geometry import euler, quaternion

Array = NDArray[np.float64]

JOINT_TOLERANCE: Final = np.deg2rad(1.0)
"""Radians beyond a limit that are let pass: a file's rounding and a marker's slip."""


@dataclass(frozen=True)
class JointExcess:
    """One axis of one joint that goes beyond the limits of its own file."""

    joint: str
    axis: str
    """"x", "y" or "z" in the joint's frame."""
    lowest_degrees: float
    """The file's limits."""
    highest_degrees: float
    frames: int
    """How many frames are beyond, tolerance included."""
    worst_degrees: float
    """Farthest beyond the limit."""
    worst_frame: int


class JointExcesses(NamedTuple):
    """Joints beyond their limits, worst first, and in how many frames any of them is."""

    excesses: tuple[JointExcess, ...]
    frames: int


def joint_excesses(motion: Motion, *, tolerance: float = JOINT_TOLERANCE) -> JointExcesses:
    """Axes of joints that go beyond the limits of the file (§2.9).

    The local rotation C·R·C⁻¹ is taken back to the joint's own angles. Two sets of angles give the same rotation, and
    each angle may be counted with whole turns: a joint is beyond its limits only if every reading is. At gimbal lock
    angles are not defined, and such frames are not judged.

    Parameters
    ----------
    tolerance : radians that are let pass.
    """
    out = []
    beyond_any = np.zeros(motion.frame_count, dtype=np.bool_)
    for j, freedom in enumerate(motion.skeleton.freedoms):
        if not freedom.limits or not freedom.channels:
            continue
        excess = _excess(motion.rotations[:, j], freedom)
        beyond = excess > tolerance
        beyond_any |= beyond.any(axis=1)
        for k, (axis, (low, high)) in enumerate(zip(freedom.channels, freedom.limits, strict=False)):
            if not beyond[:, k].any():
                continue
            worst = int(np.argmax(excess[:, k]))
            out.append(
                JointExcess(
                    joint=motion.skeleton.joint_names[j],
                    axis=axis.lower(),
                    lowest_degrees=float(np.rad2deg(low)),
                    highest_degrees=float(np.rad2deg(high)),
                    frames=int(beyond[:, k].sum()),
                    worst_degrees=float(np.rad2deg(excess[worst, k])),
                    worst_frame=worst,
                )
            )
    out.sort(key=lambda e: (-e.worst_degrees, e.joint, e.axis))
    return JointExcesses(tuple(out), int(beyond_any.sum()))


def _excess(rotations: Array, freedom: JointFreedom) -> Array:
    """Radians beyond the limits, 0 within them, for each channel with limits; shape (frames, channels)."""
    frame = np.asarray(freedom.axis)
    own = quaternion.multiply(quaternion.multiply(quaternion.conjugate(frame), rotations), frame)
    found = euler.as_euler(own, freedom.order)
    order, channels = freedom.order.upper(), freedom.channels.upper()
    # an axis without a channel does not turn, one without limits turns freely
    low = np.array([-np.inf if axis in channels else 0.0 for axis in order])
    high = np.array([np.inf if axis in channels else 0.0 for axis in order])
    columns = [order.index(axis) for axis in channels[: len(freedom.limits)]]
    for column, limits in zip(columns, freedom.limits, strict=False):
        low[column], high[column] = limits
    middle = np.where(np.isfinite(low) & np.isfinite(high), 0.5 * (low + high), 0.0)
    readings = []
    for angles in (found.angles, _other_angles(found.angles)):
        # with the whole turns that bring each angle nearest to the middle of its range
        nearest = angles - 2.0 * np.pi * np.round((angles - middle) / (2.0 * np.pi))
        readings.append(np.maximum(np.maximum(low - nearest, nearest - high), 0.0))
    other = readings[1].max(axis=1) < readings[0].max(axis=1)
    excess = np.where(other[:, None], readings[1], readings[0])
    excess[found.gimbal_lock] = 0.0
    return np.asarray(excess[:, columns])


def _other_angles(angles: Array) -> Array:
    """The other set of three angles about three different axes that gives the same rotation."""
    first, middle, third = angles[:, 0], angles[:, 1], angles[:, 2]
    return np.stack([first + np.pi, np.pi - middle, third + np.pi], axis=1)
