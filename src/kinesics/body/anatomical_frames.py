"""The constant rotation K from each joint's frame to its anatomical frame (§2.7, §2.10; CONVENTIONS.md, "The mirror").

K comes from the rest pose where that is a human pose (the bones are swung straight onto the T-pose): `from_rest`. Else it comes
from what the bones tell, their directions, the hip and the shoulder line, and the way knees and elbows bend: `from_bones`. Joints
that carry no link have one, too: `beyond_links`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import roles as _roles
from kinesics.body.roles import Roles
from kinesics.body.skeleton import Skeleton
from kinesics.body.tree import ancestors
from kinesics.errors import InputError, SkeletonError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

DIRECTIONS: Final = {
    "+x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "+z": (0.0, 0.0, 1.0),
    "-z": (0.0, 0.0, -1.0),
}
_FORWARD: Final = np.array([0.0, 0.0, 1.0])
_SIDES: Final = ("left", "right")
_SNAP: Final = np.deg2rad(30.0)
"""A frame this near to the axes of its own file is taken to lie along them: a rig is built that way, and K then does not
depend on the clip."""
_ALONG: Final = np.deg2rad(15.0)
"""A trunk this near to its rig's axes was built along them: hips and shoulders of real bodies lean by a few degrees."""


_STILLEST: Final = (0.3, 0.1)
"""Share of the time standing in which a foot is taken to stand still: who runs has it on the ground for a third of the time."""
_ASIDE: Final = np.deg2rad(60.0)
"""A head may look aside, and fingers be bent, for a whole clip: the axes of their rig are the nearest ones however far they are
turned."""

_Limb = tuple[int, int | None, Array]
"""Joint, joint at its end, direction in the T-pose."""


def _bone(skeleton: Skeleton, joint: int, end: int | None) -> Array | None:
    """Direction and length of the bone of ``joint`` at rest: to ``end``, else to its longest child or tip."""
    rest = skeleton.rest_positions
    if end is not None:
        reach = [rest[end] - rest[joint]]
    else:
        reach = [skeleton.offsets[c] for c in skeleton.children[joint]]
        reach += [np.array(s.offset) for s in skeleton.end_sites if s.parent == joint]
    reach = [r for r in reach if np.linalg.norm(r) > 0]
    return max(reach, key=lambda r: float(np.linalg.norm(r))) if reach else None


def _limbs(roles: Roles, side: str) -> list[_Limb]:
    """The four limb bones of one side: femur, tibia, humerus, radius."""
    down = np.array([0.0, -1.0, 0.0])
    out = np.array([1.0 if side == "left" else -1.0, 0.0, 0.0])
    joint = {part: getattr(roles, f"{side}_{part}") for part in _roles.LIMB_ROLES}
    return [
        (joint["femur"], joint["tibia"], down),
        (joint["tibia"], joint["foot"], down),
        (joint["humerus"], joint["radius"], out),
        (joint["radius"], joint["hand"], out),
    ]


def axis_named(v: Array) -> str:
    """The axis a direction is nearest to, in words."""
    return max(DIRECTIONS, key=lambda name: float(np.dot(DIRECTIONS[name], v)))


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v))


class _RestPose(NamedTuple):
    """What a rest pose tells that is a human pose; unit vectors in the file's axes."""

    up: Array
    left: Array
    bones: Mapping[tuple[str, int], Array]
    """Of each side the limb bones of `_limbs`."""


def from_rest(skeleton: Skeleton, roles: Roles, facing: str | None = None) -> Array | None:
    """K from the rest pose, quaternions, shape (joints, 4), of joints that carry a link; None where that is no human pose.

    Parameters
    ----------
    facing : where the rest pose looks, one of `DIRECTIONS`; where its left and right say, without.

    Raises
    ------
    InputError
        If ``facing`` is up or down in the rest pose.
    """
    rest = _human_rest(skeleton, roles)
    if rest is None:
        return None
    up, left = rest.up, rest.left
    # the file's own axes where they are meant: hip lines of real bodies lean by a degree or two
    base = quaternion.from_matrix(_snapped(_frame(x=left - (left @ up) * up, y=up)))
    if facing is not None:
        forward = np.array(DIRECTIONS[facing])
        if abs(forward @ up) > 0.7:
            raise InputError(f'The mapping says facing = "{facing}", but that is up or down in the rest pose.')
        base = quaternion.from_matrix(_snapped(_frame(x=np.cross(up, forward), y=up)))
    frames = quaternion.identity((skeleton.joint_count,))
    for j in _trunk(roles):
        frames[j] = base
    to_character = quaternion.conjugate(base)
    for side in _SIDES:
        for part, (joint, _, target) in enumerate(_limbs(roles, side)):
            swing = quaternion.between(quaternion.rotate(to_character, rest.bones[side, part]), target)
            frames[joint] = quaternion.conjugate(quaternion.multiply(swing, to_character))
    return frames


def _trunk(roles: Roles) -> tuple[int, ...]:
    """The joints of the links between pelvis and head, clavicles included."""
    return roles.pelvis, *roles.spine, *roles.neck, roles.head, *roles.left_clavicle, *roles.right_clavicle


def _human_rest(skeleton: Skeleton, roles: Roles) -> _RestPose | None:
    """The rest pose where it is that of a body: upright, its legs down, left and right the mirror images of each other."""
    rest = skeleton.rest_positions
    hips = (rest[roles.left_femur] + rest[roles.right_femur]) / 2
    up = rest[roles.head] - hips
    lateral = rest[roles.left_femur] - rest[roles.right_femur]
    shoulders = rest[roles.left_humerus] - rest[roles.right_humerus]
    if min(np.linalg.norm(v) for v in (up, lateral, shoulders)) < 1e-9:
        return None
    up, lateral, shoulders = _unit(up), _unit(lateral), _unit(shoulders)
    if abs(up @ lateral) > 0.3 or lateral @ shoulders < 0.7:
        return None
    flip = np.eye(3) - 2 * np.outer(lateral, lateral)
    bones: dict[tuple[str, int], Array] = {}
    for side in _SIDES:
        for part, (joint, end, _) in enumerate(_limbs(roles, side)):
            bone = _bone(skeleton, joint, end)
            if bone is None:
                return None
            bones[side, part] = _unit(bone)
            if part < 2 and _unit(bone) @ up > -0.7:
                return None
    if any(flip @ bones["left", part] @ bones["right", part] < 0.87 for part in range(4)):
        return None  # left and right are not mirror images: a pose, but no reference
    return _RestPose(up, lateral, bones)


def from_bones(skeleton: Skeleton, roles: Roles, positions: Array, world: Array) -> Array:
    """K from bone directions, hip and shoulder line, and the bend of knees and elbows over the clip.

    Parameters
    ----------
    positions, world : of all joints in the world, shapes (frames, joints, 3) and (frames, joints, 4).

    Returns
    -------
    Array
        Quaternions, shape (joints, 4), of joints that carry a link.

    Raises
    ------
    SkeletonError
        If the joints of the trunk lie in one place, so that it has no frame.
    """
    frames = quaternion.identity((skeleton.joint_count,))

    def trunk(j: int, left: int, right: int, above: Sequence[int]) -> Array:
        """Columns left, up, forward of a trunk joint in its own frame; up is to the first joint that lies elsewhere."""
        ups = [_seen_from(world[:, j], positions[:, a] - positions[:, j]) for a in above]
        y = next((v for v in ups if np.linalg.norm(v) > 1e-6), None)
        x = _seen_from(world[:, j], positions[:, left] - positions[:, right])
        if y is None or np.linalg.norm(np.cross(x, y)) < 1e-9:
            raise SkeletonError(
                f"The frame of joint '{skeleton.joint_names[j]}' cannot be found: the joints above it, or those to its left "
                "and right, lie in one place."
            )
        return _frame(x=x, y=y)

    above_chest = (*roles.neck, roles.head)
    raw_pelvis = trunk(roles.pelvis, roles.left_femur, roles.right_femur, (*roles.spine, *above_chest))
    raw_chest = trunk(roles.chest, roles.left_humerus, roles.right_humerus, above_chest) if roles.spine else raw_pelvis
    # a rig built along axes has them everywhere, and then K does not depend on the clip; one that is not has them nowhere
    along_axes = all(_off_axes(m) < _ALONG for m in (raw_pelvis, raw_chest))
    near, far = (_SNAP, _ASIDE) if along_axes else (0.0, 0.0)
    frames[roles.pelvis] = quaternion.from_matrix(_snapped(raw_pelvis, near))
    frames[roles.chest] = quaternion.from_matrix(_snapped(raw_chest, near))
    pelvis = quaternion.multiply(world[:, roles.pelvis], frames[roles.pelvis])
    chest = quaternion.multiply(world[:, roles.chest], frames[roles.chest])

    def neutral(j: int, like: Array) -> Array:
        """K that leaves joint j on average as its neighbours are."""
        average = quaternion.mean(quaternion.multiply(quaternion.conjugate(world[:, j]), like))
        return quaternion.from_matrix(_snapped(quaternion.as_matrix(average), far))

    middle = quaternion.slerp(pelvis, chest, np.full(len(world), 0.5))
    for j in roles.spine[:-1]:
        frames[j] = neutral(j, middle)
    for j in (*roles.neck, roles.head, *roles.left_clavicle, *roles.right_clavicle):
        frames[j] = neutral(j, chest)
    for side in _SIDES:
        femur, tibia, humerus, radius = _limbs(roles, side)
        # knees bend the shank backwards, elbows the forearm forwards
        for upper, lower, around, bends in ((femur, tibia, pelvis, -1.0), (humerus, radius, chest, 1.0)):
            frames[upper[0]], frames[lower[0]] = _limb_frames(
                skeleton, upper, lower, positions, world, around, bends, near
            )
    return frames


def _limb_frames(
    skeleton: Skeleton,
    upper: _Limb,
    lower: _Limb,
    positions: Array,
    world: Array,
    trunk: Array,
    bends: float,
    snap: float,
) -> tuple[Array, Array]:
    """K of the two bones of a limb.

    Parameters
    ----------
    trunk : orientation of what the limb hangs on in the world, anatomical, shape (frames, 4).
    bends : 1 where the limb bends its lower bone forwards, −1 where backwards.
    """
    first, second, end = upper[0], lower[0], lower[1]
    target = upper[2]
    bone = _unit(_seen_from(world[:, first], positions[:, second] - positions[:, first]))
    tip = _tip(skeleton, second, end)
    lower_bone = (
        positions[:, end] - positions[:, second] if end is not None else quaternion.rotate(world[:, second], tip)
    )
    # the trunk's own forward settles straight limbs
    forward = bends * _seen_from(world[:, first], lower_bone / max(float(np.linalg.norm(tip)), 1e-9))
    forward = forward + 0.25 * _seen_from(world[:, first], quaternion.rotate(trunk, _FORWARD))
    forward = forward - (forward @ bone) * bone
    frame = _limb_frame(bone, forward, target, snap)
    # about its own bone the lower link does not turn (§2.7), so any second axis will do: the upper one's, carried on
    lower_dir = _unit(tip) if np.linalg.norm(tip) > 0 else bone
    carried = _seen_from(world[:, second], quaternion.rotate(quaternion.multiply(world[:, first], frame), _FORWARD))
    return frame, _limb_frame(lower_dir, carried - (carried @ lower_dir) * lower_dir, target, snap)


def _seen_from(orientation: Array, directions: Array) -> Array:
    """Mean over the clip of a direction given in the world, seen from a joint of that orientation, shape (3,)."""
    return np.asarray(quaternion.rotate(quaternion.conjugate(orientation), directions).mean(axis=0))


def beyond_links(
    skeleton: Skeleton, roles: Roles, frames: Array, positions: Array, world: Array, *, rests: bool
) -> Array:
    """K of the joints that carry no link.

    A foot's frame is the world's while it stands flat, turned to where the toes point; where the clip does not show it
    standing, that of the rest pose, with the toes as far below the ankle as those of the other foot if that is seen. Every other
    joint goes on from its parent as at rest or, where the rest is no human pose, along the axes that are nearest to the average of
    the clip.

    Parameters
    ----------
    frames : K of those that carry one, quaternions, shape (joints, 4).
    positions, world : of all joints in the world, shapes (frames, joints, 3) and (frames, joints, 4).
    rests : whether the rest pose is a human pose.

    Returns
    -------
    Array
        K of all joints, shape (joints, 4).
    """
    frames = frames.copy()
    carriers = {
        *_trunk(roles),
        *(getattr(roles, f"{side}_{part}") for side in _SIDES for part in ("femur", "tibia", "humerus", "radius")),
    }
    feet = {j: side for side in _SIDES if (j := getattr(roles, f"{side}_foot")) is not None}
    seen: set[int] = set()
    above = set(ancestors(skeleton, roles.pelvis))
    for j, parent in enumerate(skeleton.parents):
        if j in carriers:
            continue
        if j in above:
            # a rig's stand on the floor: the T-pose faces +z by it, or by the pelvis alone
            frames[j] = frames[roles.pelvis] if rests else quaternion.identity()
            continue
        if rests:
            onward = frames[roles.pelvis] if j in feet else frames[parent]
        else:
            local = quaternion.multiply(quaternion.conjugate(world[:, parent]), world[:, j])
            rest = quaternion.from_matrix(_snapped(quaternion.as_matrix(quaternion.mean(local)), _ASIDE))
            onward = quaternion.multiply(quaternion.conjugate(rest), frames[parent])
        if j in feet:
            flat = _flat_foot(skeleton, roles, feet[j], positions, world)
            if flat is not None and (not rests or quaternion.angle(flat, onward) < np.deg2rad(40.0)):
                onward = flat
                seen.add(j)
        frames[j] = onward
    if len(feet) == 2 and len(seen) == 1:
        (other,) = seen
        (foot,) = feet.keys() - seen
        bones = [_bone(skeleton, j, getattr(roles, f"{feet[j]}_toes")) for j in (foot, other)]
        if bones[0] is not None and bones[1] is not None:
            frames[foot] = _declined(frames[foot], bones[0], frames[other], bones[1])
    return frames


def _declined(frame: Array, bone: Array, like: Array, other: Array) -> Array:
    """K of a foot, turned about its own x so that its bone lies as steeply as that of the other."""
    slopes = []
    for k, ahead in ((frame, bone), (like, other)):
        x, y, z = quaternion.rotate(quaternion.conjugate(k), ahead)
        slopes.append(np.arctan2(y, np.hypot(x, z)))
    return np.asarray(quaternion.multiply(frame, quaternion.from_rotvec([slopes[1] - slopes[0], 0.0, 0.0])))


def _flat_foot(skeleton: Skeleton, roles: Roles, side: str, positions: Array, world: Array) -> Array | None:
    """K of a foot, from how it stands in the clip; None where it is not seen standing."""
    foot, toes = getattr(roles, f"{side}_foot"), getattr(roles, f"{side}_toes")
    ahead = _bone(skeleton, foot, toes)
    if ahead is None or len(positions) < 3:
        return None
    ball = positions[:, foot] + quaternion.rotate(world[:, foot], ahead)
    speed = sum(np.linalg.norm(np.gradient(p, axis=0), axis=1) for p in (ball, positions[:, foot]))
    over = positions[:, roles.head, 1] - np.maximum(ball[:, 1], positions[:, roles.pelvis, 1])
    standing = over > 0.5 * over.max()
    if over.max() <= 0.0 or standing.sum() < 3:
        return None
    low = standing & (ball[:, 1] <= np.median(ball[standing, 1]))
    for share in _STILLEST:
        still = low & (speed <= np.quantile(speed[standing], share))
        if not still.any():
            return None
        ups = quaternion.rotate(quaternion.conjugate(world[still, foot]), np.array([0.0, 1.0, 0.0]))
        up = np.median(ups, axis=0)
        if np.linalg.norm(up) >= 0.5 and np.median(ups @ _unit(up)) >= np.cos(np.deg2rad(10.0)):
            break
    else:
        return None  # it rolls all the time
    y = _unit(up)
    z = ahead - (ahead @ y) * y
    if np.linalg.norm(z) < 0.3 * np.linalg.norm(ahead):
        return None  # on its toes, or the bone is that of the ankle alone
    z = _unit(z)
    return quaternion.from_matrix(np.stack([np.cross(y, z), y, z], axis=1))


def _tip(skeleton: Skeleton, joint: int, end: int | None) -> Array:
    if end is not None and skeleton.parents[end] == joint:
        return np.asarray(skeleton.offsets[end])
    bone = _bone(skeleton, joint, end)
    return np.zeros(3) if bone is None else bone


def _limb_frame(bone: Array, forward: Array, target: Array, snap: float) -> Array:
    """K of a limb joint: its bone (local) is ``target`` in the T-pose, ``forward`` (local) is +z."""
    if np.linalg.norm(forward) < 1e-6:
        least = np.eye(3)[np.argmin(np.abs(bone))]
        forward = least - (least @ bone) * bone
    z = _unit(forward)
    if abs(target[1]) > 0.5:
        y = -bone
        matrix = np.stack([np.cross(y, z), y, z], axis=1)
    else:
        x = bone * np.sign(target[0])
        matrix = np.stack([x, np.cross(z, x), z], axis=1)
    return quaternion.from_matrix(_snapped(matrix, snap))


def _frame(x: Array, y: Array) -> Array:
    """Matrix whose columns are left, up and forward, given left and up in the file's coordinates."""
    x = _unit(x - (x @ _unit(y)) * _unit(y))
    y = _unit(y)
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _nearest_axes(matrix: Array) -> Array | None:
    """The nearest rotation onto coordinate axes; None where the choice is no rotation."""
    best = np.zeros((3, 3))
    rest = np.abs(matrix)
    for _ in range(3):
        row, column = np.unravel_index(np.argmax(rest), (3, 3))
        best[row, column] = np.sign(matrix[row, column])
        rest[row, :] = -1.0
        rest[:, column] = -1.0
    return best if np.linalg.det(best) > 0 else None


def _off_axes(matrix: Array) -> float:
    """Angle of a frame from the coordinate axes, radians."""
    best = _nearest_axes(matrix)
    if best is None:
        return float(np.pi)
    return float(np.arccos(np.clip((np.trace(best.T @ matrix) - 1.0) / 2.0, -1.0, 1.0)))


def _snapped(matrix: Array, limit: float = _SNAP) -> Array:
    """The nearest rotation onto coordinate axes, if it is nearer than ``limit``; else the matrix itself."""
    best = _nearest_axes(matrix)
    return best if best is not None and _off_axes(matrix) < limit else matrix
