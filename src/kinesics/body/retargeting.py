"""One body's movement on another body: rotations of links back to rotations of joints (§2.7, §2.16).

`kinesics.body.anatomy.link_rotations` reads the 15 links from any skeleton. This is the way back: `t_pose` and
`joint_rotations` set a skeleton into given poses, `retarget` lets one body move as another one does.

All of it goes through anatomical frames, in which the T-pose is the identity of every joint whatever a file's own frames
and rest pose are: an orientation carries over as it is, only the bones it turns are others.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body import anatomy as _anatomy
from kinesics.body import contacts as _contacts
from kinesics.body import roles as _roles
from kinesics.body.anatomy import Anatomy
from kinesics.body.motion import Motion
from kinesics.body.roles import Roles
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError, SkeletonError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

_SIDES: Final = ("left", "right")
_SPINE: Final = slice(1, 4)
_NECK: Final = slice(4, 6)
_HEAD: Final = 6
_LIMBS: Final = {"left": 7, "right": 11}
"""First of the four links of each side: femur, tibia, humerus, radius."""
_SAME_DIRECTION: Final = 1e-3
"""Radians: bones nearer than this are those of one rig, written with few digits."""
_SETTLING: Final = 0.06
"""Seconds, one standard deviation, over which the height is corrected: the ground passes from foot to foot without a jolt."""
_STRETCH: Final = 1e-3
"""Metres: what joints shift by less is rounding."""
_NEARLY_LOWEST: Final = 0.01
"""Metres within which points count as lowest together, so that the ground passes from one to the other smoothly."""


def t_pose(skeleton: Skeleton) -> Array:
    """Local rotations that put a skeleton into the T-pose facing +z: every anatomical link rotation is the identity.

    Shape (joints, 4). Feet stand flat; fingers, toes and joints that only twist are as at rest.

    Raises
    ------
    SkeletonError
        If the skeleton carries no anatomy and its rest pose alone does not tell: a skeleton whose rest is no human pose is
        understood from a recording (`kinesics.body.anatomy.understood`).
    """
    body = body_of(skeleton)
    return np.asarray(_local(skeleton, body, quaternion.identity((1, skeleton.joint_count)))[0])


def joint_rotations(skeleton: Skeleton, quaternions: ArrayLike, yaw: ArrayLike = 0.0) -> Array:
    """Local rotations that give a skeleton the poses asked for: the inverse of reading them.

    Poses read back (`kinesics.body.pose.poses`) are those given, where the skeleton has the joints: a spine of fewer than
    three joints or a neck of fewer than two keeps the orientation of chest and head and spreads the bend over what there is.
    Collar bones, hands, feet, toes and fingers are as in the T-pose.

    Parameters
    ----------
    quaternions : of the 15 links in anatomical frames, shape (frames, 15, 4).
    yaw : heading of the pelvis about +y, radians, shape (frames,) or one for all.

    Returns
    -------
    Array
        Shape (frames, joints, 4).

    Raises
    ------
    InputError
        If shapes disagree or a quaternion is zero or not finite.
    SkeletonError
        As `t_pose`.
    """
    links = quaternion.normalize(quaternions)
    if links.ndim != 3 or links.shape[1:] != (15, 4):
        raise InputError(f"Expected `quaternions` of shape (frames, 15, 4), got {links.shape}.")
    heading = np.asarray(yaw, dtype=np.float64)
    if heading.shape not in ((), (len(links),)) or not np.isfinite(heading).all():
        raise InputError(f"Expected `yaw` to be finite, one for all or of shape ({len(links)},), got {heading.shape}.")
    body = body_of(skeleton)
    roles = body.roles
    about_up = quaternion.from_axis_angle([0.0, 1.0, 0.0], np.broadcast_to(heading, len(links)))
    known: dict[int, Array] = {}
    known[roles.pelvis] = quaternion.multiply(about_up, links[:, 0])
    _follow(known, known[roles.pelvis], roles.spine, unspread(links[:, _SPINE], len(roles.spine)))
    chest = known[roles.chest]
    neck = _follow(known, chest, roles.neck, unspread(links[:, _NECK], len(roles.neck)))
    if not roles.neck:
        neck = quaternion.multiply(quaternion.multiply(chest, links[:, 4]), links[:, 5])
    known[roles.head] = quaternion.multiply(neck, links[:, _HEAD])
    for side, first in _LIMBS.items():
        for base, upper, lower, link in (
            (known[roles.pelvis], "femur", "tibia", first),
            (chest, "humerus", "radius", first + 2),
        ):
            known[_role(roles, side, upper)] = quaternion.multiply(base, links[:, link])
            known[_role(roles, side, lower)] = quaternion.multiply(known[_role(roles, side, upper)], links[:, link + 1])
        for j in getattr(roles, f"{side}_clavicle"):
            known[j] = chest
    return _local(skeleton, body, _completed(skeleton, body, known, len(links)))


def unspread(links: Array, count: int) -> list[Array]:
    """Rotations of ``count`` joints that `kinesics.body.anatomy.spread` reads as ``links``.

    The product is always that of the links. From as many joints as links on every link is met, too: joints that lie within
    one link share what those across its ends leave. Fewer joints each take the links' shares of their stretch.

    Parameters
    ----------
    links : shape (frames, links, 4).

    Returns
    -------
    list
        ``count`` arrays of shape (frames, 4).
    """
    wanted = [links[:, k] for k in range(links.shape[1])]
    n = len(wanted)
    if count < n:
        # a single step is one of count·n: `spread` the other way round
        spreaded = _anatomy.spread(wanted, count)
        return [spreaded[:, k] for k in range(count)]
    joints: list[Array] = [np.empty(0)] * count
    # joint k covers [k·n, (k+1)·n), link l covers [l·count, (l+1)·count), in units of 1/(count·n)
    across = [k for k in range(count) if k * n // count != ((k + 1) * n - 1) // count]
    for k in across:
        middle = (2 * k + 1) * n // (2 * count)
        joints[k] = quaternion.power(wanted[min(middle, n - 1)], n / count)
    for link, rotation in enumerate(wanted):
        start, end = link * count, (link + 1) * count
        inside = [k for k in range(count) if start <= k * n and (k + 1) * n <= end]
        if not inside:
            continue
        need = rotation
        before, after = inside[0] - 1, inside[-1] + 1
        if before >= 0 and (before + 1) * n > start:
            share = ((before + 1) * n - start) / n
            need = quaternion.multiply(quaternion.conjugate(quaternion.power(joints[before], share)), need)
        if after < count and after * n < end:
            share = (end - after * n) / n
            need = quaternion.multiply(need, quaternion.conjugate(quaternion.power(joints[after], share)))
        part = need if len(inside) == 1 else quaternion.power(need, 1.0 / len(inside))
        for k in inside:
            joints[k] = part
    return joints


def retarget(motion: Motion, skeleton: Skeleton) -> Motion:
    """The same movement by another body.

    Poses carry over exactly as far as both skeletons have the joints; the twist of forearms and shanks, collar bones, hands,
    feet, toes and fingers come along by their role, their name or their place. Places are scaled about the world's origin by
    the length of the legs, and the height of the root is set so that the lowest point of the body is where it was: feet
    stand, jumps fly. On the same skeleton the motion is the same; on the same joints with other lengths the rotations are.

    Parameters
    ----------
    skeleton : of the other body.

    Returns
    -------
    Motion
        On ``skeleton``, which then carries its anatomy, with no joint translations; what was assumed is added to its
        assumptions.

    Raises
    ------
    SkeletonError
        If one of the skeletons cannot be understood as a human body.
    """
    motion = _anatomy.understood(motion)
    if _same_body(motion.skeleton, skeleton):
        return motion
    source = body_of(motion.skeleton)
    rig = _same_rig(motion.skeleton, skeleton, source)
    target = source if rig and skeleton.anatomy is None else body_of(skeleton)
    skeleton = skeleton.replace(anatomy=target)
    if rig:
        # the same joints in the same frames: their rotations mean the same
        rotations = motion.rotations
    else:
        seen = motion.global_rotations()
        rotations = _local(skeleton, target, _oriented_like(motion.skeleton, source, seen, skeleton, target))
    roots, scale = _travel(motion, source, skeleton, target, rotations)
    said = []
    if not rig or scale != 1.0:
        said = [
            f"brought onto the skeleton '{skeleton.name}'" if skeleton.name else "brought onto another skeleton",
            f"places scaled by {scale:.3f}, as its legs are to those recorded",
        ]
    for what, here, there in (
        ("spine", source.roles.spine, target.roles.spine),
        ("neck", source.roles.neck, target.roles.neck),
    ):
        if len(here) != len(there):
            said.append(f"{what} of {len(here)} joint(s) spread over {len(there)}")
    if source.clavicle != target.clavicle:
        said.append("the two bodies have unlike rules for the clavicle: upper arms keep their place to the chest")
    if motion.joint_translations is not None:
        below = _below_pelvis(motion.skeleton, source)
        stretch = float(np.abs(motion.joint_translations[:, below] - motion.skeleton.offsets[below]).max(initial=0.0))
        if stretch > _STRETCH:
            said.append(
                f"bones that stretch by up to {stretch:.3f} m in the recording keep the lengths of the skeleton"
            )
    return Motion(
        skeleton,
        rotations,
        roots,
        motion.fps,
        name=motion.name,
        assumptions=(*motion.assumptions, *said),
        warnings=motion.warnings,
    )


def body_of(skeleton: Skeleton) -> Anatomy:
    """The anatomy a skeleton carries, else what its rest pose tells.

    Raises
    ------
    SkeletonError
        If it carries none and its rest pose is no human pose.
    """
    if skeleton.anatomy is not None:
        return skeleton.anatomy
    at_rest = Motion(skeleton, quaternion.identity((1, skeleton.joint_count)), np.zeros((1, 3)), 1.0)
    try:
        return _anatomy.resolve(at_rest)
    except SkeletonError as error:
        raise SkeletonError(
            f"{error} Its rest pose alone was looked at: take the skeleton of a recording that is understood "
            "(`kinesics.body.anatomy.understood(motion).skeleton`).",
            found=error.found,
            missing=error.missing,
        ) from error


def _role(roles: Roles, side: str, part: str) -> int:
    joint = getattr(roles, f"{side}_{part}")
    assert isinstance(joint, int)
    return joint


def _same_body(a: Skeleton, b: Skeleton) -> bool:
    return a is b or (a.same_tree(b) and np.array_equal(a.offsets, b.offsets))


def _below_pelvis(skeleton: Skeleton, body: Anatomy) -> list[int]:
    return [j for j in range(skeleton.joint_count) if not _is_above(skeleton, j, body.pelvis)]


def _same_rig(a: Skeleton, b: Skeleton, body: Anatomy) -> bool:
    """Whether two skeletons have the same joints with bones in the same directions; where the pelvis hangs does not matter."""
    if not a.same_tree(b):
        return False
    below = _below_pelvis(a, body)
    first, second = a.offsets[below], b.offsets[below]
    lengths = np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
    # by the cross product: the cosine of a small angle has lost its digits
    off = np.linalg.norm(np.cross(first, second), axis=1)
    there = lengths > 0.0
    return bool(
        np.all(off[there] <= _SAME_DIRECTION * lengths[there])
        and np.all(np.sum(first * second, axis=1)[there] > 0.0)
        and np.array_equal(first.any(axis=1), second.any(axis=1))
    )


def _follow(known: dict[int, Array], base: Array, chain: Sequence[int], steps: Sequence[Array]) -> Array:
    """Orient a chain of joints by rotations from each to the next; the last orientation."""
    for j, step in zip(chain, steps, strict=True):
        base = quaternion.multiply(base, step)
        known[j] = base
    return base


def _completed(skeleton: Skeleton, body: Anatomy, known: dict[int, Array], frames: int) -> Array:
    """Anatomical orientations of all joints: those not known go on from their parents, shape (frames, joints, 4)."""
    out = quaternion.identity((frames, skeleton.joint_count))
    for j, parent in enumerate(skeleton.parents):
        if j in known:
            out[:, j] = known[j]
        elif parent >= 0 and not _is_above(skeleton, j, body.pelvis):
            out[:, j] = out[:, parent]
    return out


def _is_above(skeleton: Skeleton, j: int, joint: int) -> bool:
    while joint >= 0:
        if joint == j:
            return True
        joint = skeleton.parents[joint]
    return False


def _local(skeleton: Skeleton, body: Anatomy, anatomical: Array) -> Array:
    """Rotations relative to parents from anatomical orientations in the world, shape (frames, joints, 4) to the same."""
    world = quaternion.multiply(anatomical, quaternion.conjugate(body.frames))
    parents = list(skeleton.parents[1:])
    local = world.copy()
    local[:, 1:] = quaternion.multiply(quaternion.conjugate(world[:, parents]), world[:, 1:])
    return quaternion.normalize(local)


def _oriented_like(skeleton: Skeleton, body: Anatomy, world: Array, other: Skeleton, other_body: Anatomy) -> Array:
    """Anatomical orientations of all joints of another skeleton, as those of this one: shape (frames, joints, 4)."""
    seen = quaternion.multiply(world, body.frames)
    here, there = body.roles, other_body.roles
    known: dict[int, Array] = {there.pelvis: seen[:, here.pelvis]}

    def along(base: Array, chain: Sequence[int]) -> list[Array]:
        ways = pairwise([base, *(seen[:, j] for j in chain)])
        return [quaternion.multiply(quaternion.conjugate(a), b) for a, b in ways]

    def carry(base: Array, chain: Sequence[int], links: int, onto: Sequence[int], onto_base: Array) -> Array:
        steps = along(base, chain)
        if len(chain) != len(onto):
            steps = unspread(_anatomy.spread(steps, links), len(onto)) if chain else _still(len(seen), len(onto))
        return _follow(known, onto_base, onto, steps)

    chest = carry(seen[:, here.pelvis], here.spine, 3, there.spine, known[there.pelvis])
    # where the other body has no spine to bend, everything above stays as it is to the chest
    if here.spine and not there.spine:
        lift = quaternion.multiply(chest, quaternion.conjugate(seen[:, here.chest]))
        for j in range(skeleton.joint_count):
            legs = any(_is_above(skeleton, _role(here, side, "femur"), j) for side in _SIDES)
            if j != here.chest and _is_above(skeleton, here.chest, j) and not legs:
                seen[:, j] = quaternion.multiply(lift, seen[:, j])
    seen_chest = chest if here.spine else seen[:, here.chest]

    carry(seen_chest, here.neck, 2, there.neck, chest)
    if not here.neck and there.neck:
        # a head alone is read as neck and head in equal parts
        links = _anatomy.spread(along(seen_chest, [here.head]), 3)
        _follow(known, chest, there.neck, unspread(links[:, :2], len(there.neck)))
    known[there.head] = seen[:, here.head]
    for side in _SIDES:
        carry(
            seen_chest,
            getattr(here, f"{side}_clavicle"),
            1,
            getattr(there, f"{side}_clavicle"),
            chest,
        )
    for j, k in _matched(skeleton, here, other, there).items():
        known.setdefault(k, seen[:, j])
    return _completed(other, other_body, known, len(seen))


def _still(frames: int, joints: int) -> list[Array]:
    return [quaternion.identity((frames,)) for _ in range(joints)]


def _matched(skeleton: Skeleton, here: Roles, other: Skeleton, there: Roles) -> dict[int, int]:
    """Joint of one skeleton to that of the other, beyond the trunk: by role, then by name, then by place below a hand or foot."""
    pairs: dict[int, int] = {}

    def pair(j: int | None, k: int | None) -> None:
        if j is not None and k is not None and j not in pairs and k not in pairs.values():
            pairs[j] = k

    for side in _SIDES:
        for part in (*_roles.LIMB_ROLES, "toes"):
            pair(getattr(here, f"{side}_{part}"), getattr(there, f"{side}_{part}"))
    for side in _SIDES:
        for part in ("hand", "foot", "toes"):
            a, b = getattr(here, f"{side}_{part}"), getattr(there, f"{side}_{part}")
            if a is not None and b is not None and _shape(skeleton, a) == _shape(other, b):
                for j, k in zip(_subtree(skeleton, a), _subtree(other, b), strict=True):
                    pair(j, k)
    trunk = {here.pelvis, *here.spine, *here.neck, here.head, *here.left_clavicle, *here.right_clavicle}
    above = {j for j in range(skeleton.joint_count) if _is_above(skeleton, j, here.pelvis)}
    for name, j in skeleton.joint_index.items():
        if name in other.joint_index and j not in trunk and j not in above:
            k = other.joint_index[name]
            if not _is_above(other, k, there.pelvis):
                pair(j, k)
    return pairs


def _subtree(skeleton: Skeleton, joint: int) -> list[int]:
    out = [joint]
    for child in skeleton.children[joint]:
        out += _subtree(skeleton, child)
    return out


def _shape(skeleton: Skeleton, joint: int) -> tuple[object, ...]:
    return tuple(_shape(skeleton, child) for child in skeleton.children[joint])


def _travel(
    motion: Motion, source: Anatomy, skeleton: Skeleton, target: Anatomy, rotations: Array
) -> tuple[Array, float]:
    """Positions of the root of the new body, metres, shape (frames, 3), and the scale of its way."""
    below = _below_pelvis(skeleton, target)
    alike = skeleton.same_tree(motion.skeleton) and np.allclose(
        skeleton.offsets[below], motion.skeleton.offsets[below], rtol=0.0, atol=1e-9
    )
    scale = 1.0 if alike else leg_length(skeleton, target) / leg_length(motion.skeleton, source)
    before = motion.positions()
    pelvis = before[:, source.pelvis] * scale
    draft = Motion(skeleton, rotations, np.zeros((motion.frame_count, 3)), motion.fps)
    draft = draft.replace(root_positions=pelvis - draft.positions()[:, target.pelvis])
    if alike:
        return np.asarray(draft.root_positions), scale
    # roughly right, so that the feet are seen to stand; then the lowest points are put where they were
    return lowered(draft, motion, scale), scale


def lowered(draft: Motion, motion: Motion, scale: float = 1.0) -> Array:
    """Positions of the root, metres, shape (frames, 3), with which the lowest point of a body is where another's is.

    Parameters
    ----------
    draft, motion : the same movement on the two bodies, which carry their anatomy.
    scale : times the height of the other.
    """
    assert draft.skeleton.anatomy is not None
    low, low_draft = _lowest(motion, draft, body_of(motion.skeleton), draft.skeleton.anatomy)
    roots = draft.root_positions.copy()
    roots[:, 1] += _smooth(scale * low - low_draft, _SETTLING * motion.fps)
    return roots


def _smooth(values: Array, frames: float) -> Array:
    """Gaussian mean over time; beyond its ends a curve is taken to stay as it is there."""
    reach = int(np.ceil(4.0 * frames))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / frames) ** 2)
    return np.convolve(np.pad(values, reach, mode="edge"), weights / weights.sum(), mode="valid")


def _lowest(motion: Motion, draft: Motion, source: Anatomy, target: Anatomy) -> tuple[Array, Array]:
    """Height of the lowest point of each body above its floor, metres, two of shape (frames,).

    Soles, hands, elbows, knees, pelvis and head: what both bodies have.
    """
    pairs = _matched(motion.skeleton, source.roles, draft.skeleton, target.roles)
    pairs |= {source.pelvis: target.pelvis, source.head: target.head}
    heights = [motion.positions()[:, list(pairs), 1], draft.positions()[:, list(pairs.values()), 1]]
    try:
        for k, m in enumerate((motion, draft)):
            soles = _contacts.soles(m).place(m.positions(), m.global_rotations())[..., 1]
            heights[k] = np.concatenate([heights[k], soles.reshape(len(soles), -1)], axis=1)
    except SkeletonError:
        heights = [h[:, : len(pairs)] for h in heights]  # a body without feet stands on its knees or shanks
    low = [-_NEARLY_LOWEST * _log_sum(-h / _NEARLY_LOWEST) for h in heights]
    return low[0], low[1]


def _log_sum(values: Array) -> Array:
    """log Σ exp over the last axis."""
    largest = values.max(axis=-1)
    return np.asarray(largest + np.log(np.exp(values - largest[..., None]).sum(axis=-1)))


def leg_length(skeleton: Skeleton, body: Anatomy) -> float:
    """Thigh and shank, mean of left and right, metres.

    Raises
    ------
    SkeletonError
        If the legs have no length.
    """
    total = 0.0
    for side in _SIDES:
        tibia, foot = _role(body.roles, side, "tibia"), getattr(body.roles, f"{side}_foot")
        end = tibia if foot is None else foot
        if foot is None:
            sites = [float(np.linalg.norm(s.offset)) for s in skeleton.end_sites if s.parent == tibia]
            total += max(sites, default=0.0)
        while end != _role(body.roles, side, "femur"):
            total += float(np.linalg.norm(skeleton.offsets[end]))
            end = skeleton.parents[end]
    if total <= 0.0:
        raise SkeletonError("The legs of this skeleton have no length, so that nothing tells how far its steps go.")
    return total / 2.0
