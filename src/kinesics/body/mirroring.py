"""A motion seen in a mirror (§2.10): reflected in the world plane x = 0, left and right changing places."""

from __future__ import annotations

import numpy as np

from kinesics.body import anatomy as _anatomy
from kinesics.body import roles as _roles
from kinesics.body.motion import Motion
from kinesics.errors import SkeletonError
from kinesics.geometry import quaternion


def mirror(motion: Motion) -> Motion:
    """The mirror image of a motion, on the mirrored skeleton: left limb lengths become right.

    Its world positions are those of the motion with x negated and left and right swapped; its poses are W applied to the
    motion's poses. Mirroring twice gives the motion back.

    Raises
    ------
    SkeletonError
        If left and right of the skeleton do not match joint by joint.
    """
    try:
        # the frames found on this recording go along, so that both images are read in mirrored frames
        motion = _anatomy.understood(motion)
        roles = motion.skeleton.anatomy.roles if motion.skeleton.anatomy else None
    except SkeletonError:
        roles = None  # no human body, but it may have a mirror image all the same
    partner = _roles.partners(motion.skeleton, roles)
    order = list(partner)
    flip = np.array([-1.0, 1.0, 1.0])
    shifts = motion.joint_translations
    return motion.replace(
        skeleton=motion.skeleton.mirror(partner),
        rotations=quaternion.mirror(motion.rotations[:, order]),
        root_positions=motion.root_positions * flip,
        joint_translations=None if shifts is None else shifts[:, order] * flip,
    )
