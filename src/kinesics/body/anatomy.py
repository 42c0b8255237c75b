"""Any humanoid skeleton onto the 15 anatomical links (§2.7, §2.10, §2.16; CONVENTIONS.md, "The mirror").

The mirror operator W is only true in anatomical frames: frames in which the T-pose facing +z, palms down, is the
identity of every link, x to the subject's left on both sides. A file's frames are others. Each joint that carries a link
gets one constant rotation K, found once for the skeleton, so that (world orientation in the file) · K is the anatomical
orientation.

K comes from the rest pose where that is a human pose (the bones are swung straight onto the T-pose), else from what the
bones tell: their directions, the hip and the shoulder line, and the way knees and elbows bend.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import roles as _roles
from kinesics.body.motion import Motion
from kinesics.body.roles import Roles
from kinesics.body.skeleton import Skeleton
from kinesics.body.tree import ancestors
from kinesics.errors import InputError, SkeletonError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

_SNAP: Final = np.deg2rad(30.0)
"""A frame this near to the axes of its own file is taken to lie along them: a rig is built that way, and K then does not
depend on the clip."""
_ALONG: Final = np.deg2rad(15.0)
"""A trunk this near to its rig's axes was built along them: hips and shoulders of real bodies lean by a few degrees."""
_SAMPLES: Final = 500
_SIDES: Final = ("left", "right")
_DIRECTIONS: Final = {
    "+x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "+z": (0.0, 0.0, 1.0),
    "-z": (0.0, 0.0, -1.0),
}


@dataclass(frozen=True, eq=False)
class Anatomy:
    """Which joints carry the links, and the constant rotation from each joint's frame to its anatomical frame."""

    roles: Roles
    frames: Array
    """K for each joint, quaternions, shape (joints, 4). Joints that carry no link have one too: a foot stands flat in it, toes,
    fingers and joints that only twist go straight on from their parents."""
    clavicle: str = "compose"
    """"compose": the humerus is taken relative to the chest, clavicle included; "drop": relative to the clavicle (§2.16)."""
    profile: str = ""
    """Naming, spine rule and clavicle rule in one line: D between unlike rules means little."""
    assumptions: tuple[str, ...] = ()

    @property
    def pelvis(self) -> int:
        """Joint of the root link."""
        return self.roles.pelvis

    @property
    def chest(self) -> int:
        """Joint that the arms and the neck hang on."""
        return self.roles.chest

    @property
    def spine(self) -> tuple[int, ...]:
        """Joints from above the pelvis up to the chest."""
        return self.roles.spine

    @property
    def neck(self) -> tuple[int, ...]:
        """Joints between chest and head."""
        return self.roles.neck

    @property
    def head(self) -> int:
        """Joint of the head."""
        return self.roles.head

    def __getattr__(self, name: str) -> int | None:
        """``left_femur``, ``right_hand`` … : the joint in that role, or None."""
        if name.startswith(("left_", "right_")):
            value: int | None = getattr(self.roles, name)
            return value
        raise AttributeError(name)

    def mirror(self, partner: tuple[int, ...]) -> Anatomy:
        """For the skeleton seen in the mirror: joint j takes the reflected frame of its partner."""
        return dataclasses.replace(self, frames=quaternion.mirror(self.frames[list(partner)]))


def resolve(motion: Motion, mapping: Mapping[str, object] | None = None) -> Anatomy:
    """The anatomy of a motion's skeleton: the one it carries, else found now.

    Parameters
    ----------
    mapping : what the user says, as read from a TOML file: a table ``[joints]`` of role = "joint name" (roles: those of
        `kinesics.body.roles.REQUIRED` and ``OPTIONAL``; any subset, the rest is found), ``clavicle = "compose" | "drop"``, and
        ``facing``: where the rest pose looks, in the file's axes ("+z", "-x", …), if not where its left and right say.

    Raises
    ------
    SkeletonError
        If the skeleton cannot be understood as a human body; it lists what was found and what is missing.
    InputError
        If the mapping names unknown roles or joints.
    """
    if motion.skeleton.anatomy is not None and not mapping:
        return motion.skeleton.anatomy
    clavicle = str((mapping or {}).get("clavicle", "compose"))
    if clavicle not in ("compose", "drop"):
        raise InputError(f'Expected clavicle = "compose" or "drop" in the mapping, got "{clavicle}".')
    facing = (mapping or {}).get("facing")
    if facing is not None and facing not in _DIRECTIONS:
        raise InputError(f"Expected facing = one of {', '.join(_DIRECTIONS)} in the mapping, got {facing!r}.")
    joints = {k: v for k, v in (mapping or {}).items() if k not in ("clavicle", "facing")}
    sample = motion[:: max(1, motion.frame_count // _SAMPLES)]
    positions = sample.positions()
    roles = _roles.identify(motion.skeleton, positions, joints)
    return _attach_frames(
        motion.skeleton, roles, positions, sample.global_rotations(), clavicle, None if facing is None else str(facing)
    )


def understood(motion: Motion, mapping: Mapping[str, object] | None = None) -> Motion:
    """The same motion on a skeleton that carries its anatomy, so that slices and mirror images agree on it.

    Raises
    ------
    SkeletonError
        As `resolve`.
    """
    if motion.skeleton.anatomy is not None and not mapping:
        return motion
    return motion.replace(skeleton=motion.skeleton.replace(anatomy=resolve(motion, mapping)))


def link_rotations(anatomy: Anatomy, world: Array) -> Array:
    """Rotations of the 15 links relative to their parent links in anatomical frames.

    Parameters
    ----------
    world : world orientations of all joints, shape (frames, joints, 4).

    Returns
    -------
    Array
        Shape (frames, 15, 4). Entry 0 is the pelvis in the world, yaw included. Spines and necks of other lengths are
        spread over their links along the way they go; the twist of forearm and shank about their own bone is left out, for
        elbow and knee are hinges (§2.7).
    """
    roles = anatomy.roles

    def turned(j: int) -> Array:
        return quaternion.multiply(world[:, j], anatomy.frames[j])

    pelvis, chest, head = turned(roles.pelvis), turned(roles.chest), turned(roles.head)
    out = np.empty((len(world), 15, 4))
    out[:, 0] = pelvis
    out[:, 1:4] = spread(_steps(pelvis, [turned(j) for j in roles.spine]), 3)
    if roles.neck:
        neck = [turned(j) for j in roles.neck]
        out[:, 4:6] = spread(_steps(chest, neck), 2)
        out[:, 6] = quaternion.multiply(quaternion.conjugate(neck[-1]), head)
    else:
        out[:, 4:7] = spread(_steps(chest, [head]), 3)
    for start, side in ((7, "left"), (11, "right")):
        femur, tibia = turned(getattr(roles, f"{side}_femur")), turned(getattr(roles, f"{side}_tibia"))
        humerus, radius = turned(getattr(roles, f"{side}_humerus")), turned(getattr(roles, f"{side}_radius"))
        clavicles = getattr(roles, f"{side}_clavicle")
        girdle = turned(clavicles[-1]) if anatomy.clavicle == "drop" and clavicles else chest
        out[:, start] = quaternion.multiply(quaternion.conjugate(pelvis), femur)
        out[:, start + 1] = _hinge(femur, tibia, np.array([0.0, 1.0, 0.0]))
        out[:, start + 2] = quaternion.multiply(quaternion.conjugate(girdle), humerus)
        out[:, start + 3] = _hinge(humerus, radius, np.array([1.0, 0.0, 0.0]))
    return out


def spread(steps: list[Array], links: int) -> Array:
    """Rotations of a chain of joints as those of a chain of ``links`` links whose product is the same.

    Joint k of n covers the stretch [k/n, (k+1)/n] of the way; each link takes, in order, the share of the joints that lies
    in its own stretch, as a power of their rotation. A chain of equal length is left as it is; an empty one is straight.

    Parameters
    ----------
    steps : rotations along the chain, each of shape (frames, 4).

    Returns
    -------
    Array
        Shape (frames, links, 4).
    """
    count = len(steps)
    if count == 0:
        return quaternion.identity((1, links))
    out = quaternion.identity((len(steps[0]), links))
    for link in range(links):
        for k, step in enumerate(steps):
            # stretches in units of 1/(count·links), so that equal ends compare as whole numbers
            share = min((k + 1) * links, (link + 1) * count) - max(k * links, link * count)
            if share == links:
                out[:, link] = quaternion.multiply(out[:, link], step)
            elif share > 0:
                out[:, link] = quaternion.multiply(out[:, link], quaternion.power(step, share / links))
    return out


def _steps(base: Array, chain: list[Array]) -> list[Array]:
    """Rotations from one world orientation to the next."""
    return [quaternion.multiply(quaternion.conjugate(a), b) for a, b in pairwise([base, *chain])]


def _hinge(upper: Array, lower: Array, bone: Array) -> Array:
    return quaternion.swing_twist(quaternion.multiply(quaternion.conjugate(upper), lower), bone).swing


def _attach_frames(
    skeleton: Skeleton, roles: Roles, positions: Array, world: Array, clavicle: str, facing: str | None
) -> Anatomy:
    spine_text = {0: "no spine joint: the three spine links stay straight", 3: ""}.get(
        len(roles.spine), f"spine of {len(roles.spine)} joints spread over three links"
    )
    neck_text = {0: "no neck joint: the head's rotation spread over neck and head", 2: ""}.get(
        len(roles.neck), f"neck of {len(roles.neck)} joint(s) spread over two links"
    )
    rested = _frames_from_rest(skeleton, roles, facing)
    if rested is not None:
        frames = rested
        forward = quaternion.rotate(frames[roles.pelvis], np.array([0.0, 0.0, 1.0]))
        said = "as the mapping says" if facing is not None else "by its left and right"
        how = f"anatomical frames from the rest pose, which faces {_direction(forward)} ({said})"
    elif facing is not None:
        raise InputError(
            "The mapping gives a facing, but the rest pose of this skeleton is no human pose and faces nowhere."
        )
    else:
        frames = _frames_from_bones(skeleton, roles, positions, world)
        how = "the rest pose is no human pose: anatomical frames from bones, hip and shoulder line and the bend of knees and elbows"
    naming = {
        "shape": "joint names tell nothing: links found by the skeleton's shape, left and right by the way the knees bend",
        _roles.BOTH: "links by joint names; those without a telling name by the skeleton's shape, which agrees with the names",
        "mapping": "links as the mapping says",
    }.get(roles.naming, f"links by joint names ({roles.naming})")
    frames = _frames_beyond_links(skeleton, roles, frames, positions, world, rests=rested is not None)
    rule = "clavicle composed with the humerus" if clavicle == "compose" else "clavicle dropped"
    return Anatomy(
        roles=roles,
        frames=frames,
        clavicle=clavicle,
        profile=f"{roles.naming}; spine {len(roles.spine)}, neck {len(roles.neck)}; clavicle {clavicle}",
        assumptions=tuple(t for t in (naming, spine_text, neck_text, rule, how) if t),
    )


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


def _limbs(roles: Roles, side: str) -> list[tuple[int, int | None, Array]]:
    """(joint, joint at its end, direction in the T-pose) of the four limb bones of one side."""
    down = np.array([0.0, -1.0, 0.0])
    out = np.array([1.0 if side == "left" else -1.0, 0.0, 0.0])
    joint = {part: getattr(roles, f"{side}_{part}") for part in _roles.LIMB_ROLES}
    return [
        (joint["femur"], joint["tibia"], down),
        (joint["tibia"], joint["foot"], down),
        (joint["humerus"], joint["radius"], out),
        (joint["radius"], joint["hand"], out),
    ]


def _direction(v: Array) -> str:
    """The axis a direction is nearest to, in words."""
    return max(_DIRECTIONS, key=lambda name: float(np.dot(_DIRECTIONS[name], v)))


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v))


def _frames_from_rest(skeleton: Skeleton, roles: Roles, facing: str | None = None) -> Array | None:
    """K from the rest pose; None where that is no human pose."""
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
    upright = _frame(x=lateral - (lateral @ up) * up, y=up)
    frames = quaternion.identity((skeleton.joint_count,))
    # the file's own axes where they are meant: hip lines of real bodies lean by a degree or two
    base = quaternion.from_matrix(_snapped(upright))
    if facing is not None:
        forward = np.array(_DIRECTIONS[facing])
        if abs(forward @ up) > 0.7:
            raise InputError(f'The mapping says facing = "{facing}", but that is up or down in the rest pose.')
        base = quaternion.from_matrix(_snapped(_frame(x=np.cross(up, forward), y=up)))
    for j in (
        roles.pelvis,
        *roles.spine,
        *roles.neck,
        roles.head,
        *roles.left_clavicle,
        *roles.right_clavicle,
    ):
        frames[j] = base
    to_character = quaternion.conjugate(base)
    for side in _SIDES:
        for part, (joint, _, target) in enumerate(_limbs(roles, side)):
            swing = quaternion.between(quaternion.rotate(to_character, bones[side, part]), target)
            frames[joint] = quaternion.conjugate(quaternion.multiply(swing, to_character))
    return frames


def _frames_from_bones(skeleton: Skeleton, roles: Roles, positions: Array, world: Array) -> Array:
    """K from bone directions, hip and shoulder line, and the bend of knees and elbows over the clip."""
    frames = quaternion.identity((skeleton.joint_count,))

    def local(j: int, points: Array) -> Array:
        """Mean over the clip of a direction given in the world, seen from joint j."""
        return np.asarray(quaternion.rotate(quaternion.conjugate(world[:, j]), points).mean(axis=0))

    def trunk(j: int, left: int, right: int, above: Sequence[int]) -> Array:
        """Columns left, up, forward of a trunk joint in its own frame; up is to the first joint that lies elsewhere."""
        ups = [local(j, positions[:, a] - positions[:, j]) for a in above]
        y = next((v for v in ups if np.linalg.norm(v) > 1e-6), None)
        x = local(j, positions[:, left] - positions[:, right])
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
    near, far = (_SNAP, np.deg2rad(60.0)) if along_axes else (0.0, 0.0)
    frames[roles.pelvis] = quaternion.from_matrix(_snapped(raw_pelvis, near))
    frames[roles.chest] = quaternion.from_matrix(_snapped(raw_chest, near))
    pelvis = quaternion.multiply(world[:, roles.pelvis], frames[roles.pelvis])
    chest = quaternion.multiply(world[:, roles.chest], frames[roles.chest])

    def neutral(j: int, like: Array) -> Array:
        """K that leaves joint j on average as its neighbours are."""
        average = quaternion.mean(quaternion.multiply(quaternion.conjugate(world[:, j]), like))
        # a head may look aside for a whole clip: its rig's axes are the nearest ones however far it is turned
        return quaternion.from_matrix(_snapped(quaternion.as_matrix(average), far))

    middle = quaternion.slerp(pelvis, chest, np.full(len(world), 0.5))
    for j in roles.spine[:-1]:
        frames[j] = neutral(j, middle)
    for j in (*roles.neck, roles.head, *roles.left_clavicle, *roles.right_clavicle):
        frames[j] = neutral(j, chest)

    for side in _SIDES:
        (femur, _knee, down), (tibia, foot, _), (humerus, _elbow, out), (radius, hand, _) = _limbs(roles, side)
        for upper, lower, end, target, trunk_frame, bends in (
            (femur, tibia, foot, down, pelvis, -1.0),
            (humerus, radius, hand, out, chest, 1.0),
        ):
            bone = _unit(local(upper, positions[:, lower] - positions[:, upper]))
            tip = _tip(skeleton, lower, end)
            lower_bone = (
                positions[:, end] - positions[:, lower] if end is not None else quaternion.rotate(world[:, lower], tip)
            )
            # knees bend the shank backwards, elbows the forearm forwards; the trunk's own forward settles straight limbs
            forward = bends * local(upper, lower_bone / max(float(np.linalg.norm(tip)), 1e-9))
            forward = forward + 0.25 * local(upper, quaternion.rotate(trunk_frame, np.array([0.0, 0.0, 1.0])))
            forward = forward - (forward @ bone) * bone
            frames[upper] = _limb_frame(bone, forward, target, near)
            # about its own bone the lower link does not turn (§2.7), so any second axis will do: the upper one's, carried on
            lower_dir = _unit(tip) if np.linalg.norm(tip) > 0 else bone
            carried = local(
                lower,
                quaternion.rotate(quaternion.multiply(world[:, upper], frames[upper]), np.array([0.0, 0.0, 1.0])),
            )
            frames[lower] = _limb_frame(lower_dir, carried - (carried @ lower_dir) * lower_dir, target, near)
    return frames


def _frames_beyond_links(
    skeleton: Skeleton, roles: Roles, frames: Array, positions: Array, world: Array, *, rests: bool
) -> Array:
    """K of the joints that carry no link.

    A foot's frame is the world's while it stands flat, turned to where the toes point; where the clip does not show it
    standing, that of the rest pose. Every other joint goes on from its parent as at rest or, where the rest is no human pose,
    along the axes that are nearest to the average of the clip.
    """
    frames = frames.copy()
    carriers = {
        roles.pelvis, *roles.spine, *roles.neck, roles.head, *roles.left_clavicle, *roles.right_clavicle,
        *(getattr(roles, f"{side}_{part}") for side in _SIDES for part in ("femur", "tibia", "humerus", "radius")),
    }  # fmt: skip
    feet = {j: side for side in _SIDES if (j := getattr(roles, f"{side}_foot")) is not None}
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
            # a rig built along axes has its fingers and twists along them, however the clip holds them on the average
            rest = quaternion.from_matrix(_snapped(quaternion.as_matrix(quaternion.mean(local)), np.deg2rad(60.0)))
            onward = quaternion.multiply(quaternion.conjugate(rest), frames[parent])
        if j in feet:
            flat = _flat_foot(skeleton, roles, feet[j], positions, world)
            if flat is not None and (not rests or quaternion.angle(flat, onward) < np.deg2rad(40.0)):
                onward = flat
        frames[j] = onward
    return frames


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
    standing &= (speed <= np.quantile(speed[standing], 0.3)) & (ball[:, 1] <= np.median(ball[standing, 1]))
    if not standing.any():
        return None
    ups = quaternion.rotate(quaternion.conjugate(world[standing, foot]), np.array([0.0, 1.0, 0.0]))
    up = np.median(ups, axis=0)
    if np.linalg.norm(up) < 0.5 or np.median(ups @ _unit(up)) < np.cos(np.deg2rad(10.0)):
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
