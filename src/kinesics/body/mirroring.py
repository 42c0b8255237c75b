"""A motion seen in a mirror (§2.10): reflected in the world plane x = 0, left and right changing places."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import anatomy as _anatomy
from kinesics.body.joint_names import numbered, split_name
from kinesics.body.motion import Motion
from kinesics.body.roles import LIMB_ROLES, Roles
from kinesics.body.skeleton import Skeleton
from kinesics.body.tree import ancestors
from kinesics.errors import SkeletonError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

_SHORTEST: Final = 1e-3
"""Metres: of a shorter bone no direction is told."""
_ONE_LINE: Final = 1e-6
"""Radians: bones that begin in one joint and are nearer to each other than this go one way."""


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
    partner = partners(motion.skeleton, roles)
    order = list(partner)
    flip = np.array([-1.0, 1.0, 1.0])
    shifts = motion.joint_translations
    return motion.replace(
        skeleton=motion.skeleton.mirror(partner),
        rotations=quaternion.mirror(motion.rotations[:, order]),
        root_positions=motion.root_positions * flip,
        joint_translations=None if shifts is None else shifts[:, order] * flip,
    )


def with_bones_of(motion: Motion, image: Motion) -> Motion:
    """A mirror image brought back onto the skeleton it was taken from, its spine, neck and head where the mirror shows them.

    From skeleton to skeleton the trunk's orientations carry over, not the directions of its bones. Where those lean to one side
    at rest, a recorded body is straight because its joints turn against that; mirrored, the joints turn to the other side while
    the bones lean as before, and the body is bent by twice what they lean. So every joint of the midline is turned on by what
    lies between the direction of its bone and that in the mirror, the shortest way: the same in every frame, and done twice it
    is undone. Where bones go several ways from a joint it keeps its orientation.

    Limbs keep theirs, too, and their own shape: a collar bone, a hand or a foot that is not the other's mirror image is left as it
    is. What lies between trunk and limb, or cannot turn, goes along with what it hangs on.

    Parameters
    ----------
    motion : what `kinesics.body.retargeting.retarget` makes of ``image``.
    image : the mirror image, on the mirrored skeleton.

    Returns
    -------
    Motion
        ``motion`` with other rotations; its root is where it was.
    """
    skeleton = motion.skeleton
    # what turns a joint of one body into the other's is the same in every frame
    there, here = image[:1].global_rotations()[0], motion[:1].global_rotations()[0]
    seen = quaternion.multiply(quaternion.conjugate(here), there)
    limbs = _along_bones(skeleton)
    midline = [
        j == k for j, k in enumerate(partners(skeleton, None if skeleton.anatomy is None else skeleton.anatomy.roles))
    ]
    # by how much each joint is turned on, seen from itself
    turns = np.broadcast_to(quaternion.identity(), motion.rotations.shape).copy()
    rotations = motion.rotations.copy()
    for j, parent in enumerate(skeleton.parents):
        before = turns[:, parent] if parent >= 0 else quaternion.identity()
        own, shown = _bones(skeleton, j), quaternion.rotate(seen[j], _bones(image.skeleton, j))
        if midline[j] and skeleton.freedoms[j].channels:
            if _one_way(own) and _one_way(shown):
                turns[:, j] = quaternion.between(own[0], shown[0])
        elif j not in limbs:
            turns[:, j] = quaternion.multiply(
                quaternion.conjugate(rotations[:, j]), quaternion.multiply(before, rotations[:, j])
            )
            continue
        rotations[:, j] = quaternion.multiply(
            quaternion.conjugate(before), quaternion.multiply(rotations[:, j], turns[:, j])
        )
    return motion.replace(rotations=quaternion.normalize(rotations))


def _along_bones(skeleton: Skeleton) -> set[int | None]:
    """The joints that carry over from skeleton to skeleton by the direction of their bones."""
    if skeleton.anatomy is None:
        return set()
    roles = skeleton.anatomy.roles
    return {
        getattr(roles, f"{side}_{part}")
        for side in ("left", "right")
        for part in ("femur", "tibia", "humerus", "radius")
    }


def _bones(skeleton: Skeleton, joint: int) -> Array:
    """Of the bones that begin in a joint, in its own frame, directions: shape (bones, 3)."""
    ends = [skeleton.offsets[child] for child in skeleton.children[joint]]
    ends += [np.asarray(site.offset) for site in skeleton.end_sites if site.parent == joint]
    sizes = [float(np.linalg.norm(end)) for end in ends]
    return np.array([e / size for e, size in zip(ends, sizes, strict=True) if size > _SHORTEST]).reshape(-1, 3)


def _one_way(directions: Array) -> bool:
    return len(directions) > 0 and bool(np.linalg.norm(directions - directions[0], axis=1).max() < _ONE_LINE)


def partners(skeleton: Skeleton, roles: Roles | None = None) -> tuple[int, ...]:
    """For each joint the one it changes places with in the mirror; itself on the midline.

    Names decide where they tell a side; below the limbs whose roles are known, the tree does. The result keeps the tree:
    the partner of a joint's parent is its partner's parent. A joint without a counterpart stays itself.

    Raises
    ------
    SkeletonError
        If a branch on one side has no counterpart that it could change places with.
    """
    split = [split_name(n) for n in skeleton.joint_names]
    out = [-1] * skeleton.joint_count
    out[0] = 0
    forced: dict[int, int] = {}
    if roles is not None:
        for part in LIMB_ROLES:
            a, b = getattr(roles, f"left_{part}"), getattr(roles, f"right_{part}")
            if a is not None and b is not None:
                forced[a], forced[b] = b, a
                # the way up from a limb to the midline changes sides with it
                chain_a, chain_b = ancestors(skeleton, a), ancestors(skeleton, b)
                for x, y in zip(chain_a, chain_b, strict=False):
                    if x == y:
                        break
                    forced.setdefault(x, y)
                    forced.setdefault(y, x)
    tagged = {(s.side, numbered(skeleton.joint_names[j], s)): j for j, s in enumerate(split) if s.side}
    for j in range(1, skeleton.joint_count):
        parent_partner = out[skeleton.parents[j]]
        candidates = skeleton.children[parent_partner] if parent_partner >= 0 else ()
        other = {"left": "right", "right": "left"}.get(split[j].side, "")
        by_tag = tagged.get((other, numbered(skeleton.joint_names[j], split[j]))) if other else None
        if j in forced and forced[j] in candidates:
            out[j] = forced[j]
        elif by_tag is not None and by_tag in candidates:
            out[j] = by_tag
        elif parent_partner != skeleton.parents[j]:
            # inside a limb: the child that stands in the same place
            siblings = skeleton.children[skeleton.parents[j]]
            if len(siblings) == len(candidates):
                out[j] = candidates[siblings.index(j)]
        elif not split[j].side and j not in forced:
            out[j] = j
    # whatever has no counterpart keeps its place only if its parent does; else the whole branch is left unpaired
    for j in range(1, skeleton.joint_count):
        k = out[j]
        if k < 0 or out[k] != j:
            out[j] = j if out[skeleton.parents[j]] == skeleton.parents[j] else -1
    if any(k < 0 for k in out):
        raise SkeletonError(
            "Left and right of the skeleton do not match, so it has no mirror image: "
            + ", ".join(skeleton.joint_names[j] for j, k in enumerate(out) if k < 0)
            + " have no counterpart."
        )
    return tuple(out)
