"""Legs of a body with narrower hips, as far apart as those that moved so first.

Who is given the directions of another's thighs and shanks (`kinesics.body.retargeting.retarget`), but whose hips are narrower
for the length of the legs, brings knees and feet nearer to each other, and thighs that touched pass through each other. The
anatomy of such a body is that of steeper thighs: turned outwards by as much as its hips are narrower, they bring the knees to
where they were, and everything below along with them, as it was.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body.motion import Motion
from kinesics.body.retargeting import body_of, leg_length, lowered
from kinesics.body.roles import Roles
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

LEAST: Final = np.deg2rad(0.25)
"""Radians that are left as they are: two files of one person differ by so much."""
MOST: Final = np.deg2rad(12.0)
"""Radians by which thighs are turned at most: no two people are more unlike."""


class Apart(NamedTuple):
    """A motion, and by how much thighs were turned outwards."""

    motion: Motion
    angle: float
    """Radians, of thighs that hang; less of those that are lifted sideways."""


def legs_apart(motion: Motion, before: Motion) -> Apart:
    """Knees and feet as far apart as they were on the body that moved so first, for the length of the legs.

    Thighs are turned outwards; shanks and feet keep their directions in space, and the lowest point its height. Where the hips
    are not narrower than they were, the motion is left as it is.

    Parameters
    ----------
    motion : what `retarget` made of the other, on a skeleton with its anatomy.
    before : the same movement on the other body.

    Raises
    ------
    SkeletonError
        If one of the skeletons cannot be understood as a human body, or legs have no length.
    """
    skeleton = motion.skeleton
    roles = body_of(skeleton).roles
    positions = motion.positions()
    narrower = _hips(before) - _hips(motion)
    thigh = min(_thigh(positions, roles, side) for side in ("left", "right"))
    legs = leg_length(skeleton, body_of(skeleton))
    angle = float(min(np.arcsin(np.clip(0.5 * narrower * legs / max(thigh, 1e-9), 0.0, 1.0)), MOST))
    if angle < LEAST:
        return Apart(motion, 0.0)
    world = motion.global_rotations()
    across = positions[:, roles.left_femur] - positions[:, roles.right_femur]
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    turned = world.copy()
    moved: list[int] = []
    for side, outwards in (("left", across), ("right", -across)):
        femur, tibia = getattr(roles, f"{side}_femur"), getattr(roles, f"{side}_tibia")
        down = positions[:, tibia] - positions[:, femur]
        down /= np.linalg.norm(down, axis=1, keepdims=True)
        # as long as the sine of the angle between the two: a thigh lifted sideways is turned less
        turn = quaternion.from_rotvec(angle * np.cross(down, outwards))
        joint = skeleton.parents[tibia]
        chain = [femur]
        while joint != femur:
            chain.append(joint)
            joint = skeleton.parents[joint]
        for j in chain:
            turned[:, j] = quaternion.multiply(turn, world[:, j])
        moved += [*chain, *(c for j in chain for c in skeleton.children[j])]
    rotations = motion.rotations.copy()
    for j in sorted(set(moved)):
        parent = skeleton.parents[j]
        rotations[:, j] = quaternion.multiply(quaternion.conjugate(turned[:, parent]), turned[:, j])
    out = motion.replace(rotations=quaternion.normalize(rotations))
    return Apart(out.replace(root_positions=lowered(out, motion)), angle)


def _hips(motion: Motion) -> float:
    """Metres from hip to hip for a metre of leg."""
    body = body_of(motion.skeleton)
    away = motion[:1].positions()[0][[body.roles.left_femur, body.roles.right_femur]]
    return float(np.linalg.norm(away[0] - away[1])) / leg_length(motion.skeleton, body)


def _thigh(positions: Array, roles: Roles, side: str) -> float:
    """Metres from hip to knee."""
    femur, tibia = getattr(roles, f"{side}_femur"), getattr(roles, f"{side}_tibia")
    return float(np.median(np.linalg.norm(positions[:, tibia] - positions[:, femur], axis=1)))
