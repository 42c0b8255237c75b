"""Forward kinematics: from joint rotations to orientations and positions in the world (§2.6)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.geometry import quaternion

if TYPE_CHECKING:
    from kinesics.body.skeleton import Skeleton

Array = NDArray[np.float64]


class Kinematics(NamedTuple):
    """Where every joint is."""

    positions: Array
    """World, metres, shape (frames, joints, 3)."""
    rotations: Array
    """World orientations, quaternions, shape (frames, joints, 4)."""


def global_rotations(skeleton: Skeleton, rotations: Array) -> Array:
    """World orientations of all joints from rotations relative to the parents. Shape (frames, joints, 4) to the same."""
    out = np.empty_like(rotations)
    out[:, 0] = rotations[:, 0]
    for j, parent in enumerate(skeleton.parents[1:], start=1):
        out[:, j] = quaternion.multiply(out[:, parent], rotations[:, j])
    return out


def forward(
    skeleton: Skeleton, rotations: Array, root_positions: Array, joint_translations: Array | None = None
) -> Kinematics:
    """Positions and orientations of all joints: g(0,n) = g(0,1) g(1,2) … g(n−1,n).

    Parameters
    ----------
    rotations : relative to the parents, shape (frames, joints, 4).
    root_positions : metres, shape (frames, 3).
    joint_translations : metres, shape (frames, joints, 3), in place of the skeleton's offsets; entry 0 is not read.
    """
    world = global_rotations(skeleton, rotations)
    positions = np.empty((*rotations.shape[:2], 3))
    positions[:, 0] = root_positions
    for j, parent in enumerate(skeleton.parents[1:], start=1):
        offset = skeleton.offsets[j] if joint_translations is None else joint_translations[:, j]
        positions[:, j] = positions[:, parent] + quaternion.rotate(world[:, parent], offset)
    return Kinematics(positions, world)
