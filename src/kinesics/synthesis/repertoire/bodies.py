"""Recordings brought onto the body that is performed on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from kinesics.body import anatomy as _anatomy
from kinesics.body.legs_apart import legs_apart
from kinesics.body.motion import Motion
from kinesics.body.retargeting import body_of, retarget
from kinesics.body.skeleton import Skeleton
from kinesics.errors import SkeletonError

LIFTED: Final = 0.05
"""Metres between the root joint and the pelvis from which it is said that the result has the root in the pelvis."""

ROOT_PUT: Final = "the root joint,"
"""How it begins that this is told."""


def root_put(before: Skeleton, after: Skeleton) -> list[str]:
    """That the root joint lies in the pelvis, where in the recordings it does not: a stand on the floor, for one."""
    assert after.anatomy is not None
    joint, away = after.anatomy.pelvis, np.zeros(3)
    while joint > 0:
        away = away + before.offsets[joint]
        joint = before.parents[joint]
    if np.linalg.norm(away) < LIFTED:
        return []
    root, pelvis = after.joint_names[0], after.joint_names[after.anatomy.pelvis]
    return [
        f"{ROOT_PUT} {root}, is in the pelvis, where {pelvis} is; recordings on this skeleton have it elsewhere, as a stand on the "
        "floor, for one"
    ]


def understood(motion: Motion, name: str) -> Motion:
    """A motion whose skeleton carries its anatomy. Raises SkeletonError, with the name, where that is not understood."""
    try:
        return _anatomy.understood(motion)
    except SkeletonError as error:
        raise SkeletonError(f"{name}: {error}", found=error.found, missing=error.missing) from error


def output_body(skeleton: Skeleton, motions: Sequence[Motion]) -> Skeleton:
    """The skeleton to perform on, with its anatomy, and with the joints above the pelvis (a rig's stand) drawn into it."""
    if skeleton.anatomy is None:
        # a recording on the same joints tells more than the rest pose
        like = next((m.skeleton for m in motions if m.skeleton.same_tree(skeleton)), None)
        try:
            skeleton = skeleton.replace(anatomy=body_of(skeleton if like is None else like))
        except SkeletonError as error:
            raise SkeletonError(
                f"The skeleton to perform on: {error}", found=error.found, missing=error.missing
            ) from error
    assert skeleton.anatomy is not None
    offsets = skeleton.offsets.copy()
    joint = skeleton.anatomy.pelvis
    while joint > 0:
        offsets[joint] = 0.0
        joint = skeleton.parents[joint]
    return skeleton if np.array_equal(offsets, skeleton.offsets) else skeleton.replace(offsets=offsets)


def brought(motion: Motion, skeleton: Skeleton) -> tuple[Motion, tuple[str, ...]]:
    """The motion on the skeleton, with nothing but rotations and a root in the pelvis; what was assumed for it."""
    assert skeleton.anatomy is not None
    out = retarget(motion, skeleton)
    if out.joint_translations is not None:
        # the root joint lies in the pelvis
        out = out.replace(root_positions=out.positions()[:, skeleton.anatomy.pelvis], joint_translations=None)
    said = out.assumptions[len(motion.assumptions) :]
    apart = legs_apart(out.replace(skeleton=skeleton), motion)
    if apart.angle > 0.0:
        said += (
            f"thighs turned outwards by {np.rad2deg(apart.angle):.1f}°, for the hips are narrower than those recorded: knees and "
            "feet are as far apart as they were",
        )
    return apart.motion, said
