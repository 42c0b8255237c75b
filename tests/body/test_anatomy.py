"""Poses of any rig land in the same anatomical frames, and the mirror law holds."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from kinesics import performer
from kinesics.body import anatomy, conventions, mirroring, pose
from kinesics.body.motion import Motion
from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.errors import InputError, SkeletonError
from kinesics.geometry import quaternion
from kinesics.vocabulary import LINKS

Array = NDArray[np.float64]

# name, parent, offset in metres: a T-pose facing +z
BODY = [
    ("Hips", -1, (0, 0, 0)),
    ("Spine", 0, (0, 0.10, 0)),
    ("Spine1", 1, (0, 0.12, 0)),
    ("Spine2", 2, (0, 0.12, 0)),
    ("Neck", 3, (0, 0.16, 0)),
    ("Head", 4, (0, 0.10, 0)),
    ("LeftShoulder", 3, (0.05, 0.10, 0)),
    ("LeftArm", 6, (0.13, 0, 0)),
    ("LeftForeArm", 7, (0.29, 0, 0)),
    ("LeftHand", 8, (0.25, 0, 0)),
    ("RightShoulder", 3, (-0.05, 0.10, 0)),
    ("RightArm", 10, (-0.13, 0, 0)),
    ("RightForeArm", 11, (-0.29, 0, 0)),
    ("RightHand", 12, (-0.25, 0, 0)),
    ("LeftUpLeg", 0, (0.09, -0.04, 0)),
    ("LeftLeg", 14, (0, -0.42, 0)),
    ("LeftFoot", 15, (0, -0.42, 0)),
    ("LeftToe", 16, (0, -0.06, 0.14)),
    ("RightUpLeg", 0, (-0.09, -0.04, 0)),
    ("RightLeg", 18, (0, -0.42, 0)),
    ("RightFoot", 19, (0, -0.42, 0)),
    ("RightToe", 20, (0, -0.06, 0.14)),
]
TIPS = {
    "Head": (0, 0.2, 0),
    "LeftHand": (0.18, 0, 0),
    "RightHand": (-0.18, 0, 0),
    "LeftToe": (0, 0, 0.07),
    "RightToe": (0, 0, 0.07),
}


def skeleton() -> Skeleton:
    names = tuple(b[0] for b in BODY)
    sites = tuple(EndSite(names.index(n), o) for n, o in TIPS.items())
    return Skeleton(names, tuple(b[1] for b in BODY), np.array([b[2] for b in BODY], dtype=float), sites)


def moving(rng: np.random.Generator, frames: int = 80) -> Motion:
    """A body that moves every joint smoothly, with knees bent back, elbows bent forward and the trunk upright."""
    body = skeleton()
    t = np.linspace(0, 1, frames)[:, None]
    q = quaternion.identity((frames, body.joint_count))

    def wave(size: float) -> Array:
        phase, rate = rng.uniform(0, 2 * np.pi, 3), rng.uniform(0.7, 2.5, 3)
        return np.asarray(size * np.sin(2 * np.pi * rate * t + phase))

    for j, name in enumerate(body.joint_names):
        q[:, j] = quaternion.from_rotvec(wave(0.25))
        bend = 0.7 + 0.5 * wave(1.0)[:, :1]
        if name in ("LeftLeg", "RightLeg"):
            q[:, j] = quaternion.from_rotvec(bend * np.array([1.0, 0, 0]))
        elif name == "LeftForeArm":
            q[:, j] = quaternion.from_rotvec(bend * np.array([0, -1.0, 0]))
        elif name == "RightForeArm":
            q[:, j] = quaternion.from_rotvec(bend * np.array([0, 1.0, 0]))
        elif name in ("LeftArm", "RightArm"):
            hang = quaternion.from_rotvec([0, 0, -1.2 if name == "LeftArm" else 1.2])
            q[:, j] = quaternion.multiply(quaternion.from_rotvec(wave(0.4)), hang)
    roots = np.concatenate([wave(0.3)[:, :1], 0.92 + wave(0.02)[:, :1], wave(0.5)[:, :1]], axis=1)
    return Motion(body, q, roots, 60.0)


def in_other_rig(motion: Motion, frames: Array) -> Motion:
    """The same movement in a rig whose joint j rests in the frame ``frames[j]`` (quaternions) of the first one."""
    body = motion.skeleton
    parents = np.array(body.parents)
    above = np.where(parents[:, None] < 0, quaternion.identity((1,)), frames[parents])
    offsets = quaternion.rotate(quaternion.conjugate(above), body.offsets)
    sites = tuple(
        EndSite(s.parent, tuple(quaternion.rotate(quaternion.conjugate(frames[s.parent]), s.offset).tolist()))
        for s in body.end_sites
    )
    rotations = quaternion.multiply(quaternion.multiply(quaternion.conjugate(above), motion.rotations), frames)
    return motion.replace(skeleton=body.replace(offsets=offsets, end_sites=sites), rotations=rotations)


def axis_rotations() -> Array:
    """The 24 rotations onto coordinate axes."""
    out = []
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((-1.0, 1.0), repeat=3):
            m = np.zeros((3, 3))
            m[range(3), order] = signs
            if np.linalg.det(m) > 0:
                out.append(quaternion.from_matrix(m))
    return np.array(out)


def difference(a: Array, b: Array) -> float:
    """Largest angle between poses, radians."""
    return float(quaternion.angle(a, b).max())


def test_the_t_pose_is_the_identity() -> None:
    """The rest pose of a T-pose rig facing +z has the identity for all 15 links."""
    body = skeleton()
    motion = Motion(body, quaternion.identity((2, body.joint_count)), np.zeros((2, 3)), 30.0)
    found = pose.poses(motion)
    assert found.quaternions.shape == (2, len(LINKS), 4)
    assert difference(found.quaternions, quaternion.identity((2, 15))) < 1e-12


def test_an_a_pose_rig_gives_the_same_poses(rng: np.random.Generator) -> None:
    """A rig that rests with its arms lowered and its legs astride reads the same movement as the same poses."""
    motion = moving(rng)
    frames = quaternion.identity((motion.skeleton.joint_count,))
    turn = {"LeftArm": -0.7, "RightArm": 0.7, "LeftUpLeg": 0.25, "RightUpLeg": -0.25}
    carried = {"LeftArm": ("LeftForeArm", "LeftHand"), "RightArm": ("RightForeArm", "RightHand")}
    carried |= {"LeftUpLeg": ("LeftLeg", "LeftFoot", "LeftToe"), "RightUpLeg": ("RightLeg", "RightFoot", "RightToe")}
    body = motion.skeleton
    # a zero pose with the limb turned: offsets turn with it, rotations are taken from there
    for name, angle in turn.items():
        for j in (name, *carried[name]):
            frames[body.find(j)] = quaternion.from_rotvec([0, 0, -angle])
    other = in_other_rig(motion, frames)
    rest = other.skeleton.rest_positions
    assert rest[body.find("LeftHand"), 1] < rest[body.find("LeftArm"), 1] - 0.2
    assert difference(pose.poses(other).quaternions, pose.poses(motion).quaternions) < 1e-9


@pytest.mark.parametrize("seed", range(6))
def test_a_rig_with_any_axes_gives_the_same_poses(seed: int) -> None:
    """Rigs whose bones lie along any axes of their own, so that the zero pose is no human pose, read as the same poses."""
    rng = np.random.default_rng(seed)
    motion = moving(rng, frames=200)
    expected = pose.poses(motion).quaternions
    frames = axis_rotations()[rng.integers(0, 24, motion.skeleton.joint_count)]
    other = in_other_rig(motion, frames)
    np.testing.assert_allclose(other.positions(), motion.positions(), atol=1e-9)
    found = anatomy.resolve(other)
    assert "no human pose" in " ".join(found.assumptions)
    assert difference(pose.poses(other).quaternions, expected) < 1e-6


def test_a_rig_facing_elsewhere_gives_the_same_poses(rng: np.random.Generator) -> None:
    """A rig that rests facing −x, or with z up, reads as the same poses."""
    motion = moving(rng)
    expected = pose.poses(motion).quaternions
    for turn in ([0, -np.pi / 2, 0], [np.pi / 2, 0, 0], [0, np.pi, 0]):
        frames = np.tile(quaternion.from_rotvec(turn), (motion.skeleton.joint_count, 1))
        other = in_other_rig(motion, frames)
        assert difference(pose.poses(other).quaternions, expected) < 1e-9


def test_names_that_tell_nothing(rng: np.random.Generator) -> None:
    """A body with names such as bone_7 is found by its shape, left and right included."""
    motion = moving(rng)
    nameless = motion.replace(
        skeleton=motion.skeleton.replace(joint_names=tuple(f"bone_{j}" for j in range(motion.skeleton.joint_count)))
    )
    found = anatomy.resolve(nameless)
    assert "shape" in found.profile
    assert found.left_femur == motion.skeleton.find("LeftUpLeg")
    assert found.right_radius == motion.skeleton.find("RightForeArm")
    assert found.head == motion.skeleton.find("Head")
    assert difference(pose.poses(nameless).quaternions, pose.poses(motion).quaternions) < 1e-9


def test_a_nameless_body_on_all_fours_is_refused(rng: np.random.Generator) -> None:
    """Four legs under a level trunk and names that tell nothing: no human body."""
    body = skeleton()
    names = tuple(f"bone_{j}" for j in range(body.joint_count))
    offsets = body.offsets.copy()
    for j, name in enumerate(body.joint_names):
        if name.startswith(("Spine", "Neck", "Head")):
            offsets[j] = (0, 0, np.linalg.norm(offsets[j]))
        elif "Arm" in name or "Hand" in name:
            offsets[j] = (0, -np.linalg.norm(offsets[j]), 0)
    dog = body.replace(joint_names=names, offsets=offsets)
    motion = Motion(dog, quaternion.identity((4, dog.joint_count)), np.zeros((4, 3)), 30.0)
    with pytest.raises(SkeletonError, match="Missing"):
        anatomy.resolve(motion)


def test_q_and_minus_q_yaw_place_and_bone_lengths_do_not_matter(rng: np.random.Generator) -> None:
    """Poses do not know the signs of quaternions, the heading, the place or the size of the body."""
    motion = moving(rng)
    expected = pose.poses(motion)
    turn = quaternion.from_rotvec([0, 1.1, 0])
    rotations, places = conventions.rotate_world(turn, motion.rotations, motion.root_positions)
    rotations *= rng.choice([-1.0, 1.0], rotations.shape[:2])[..., None]
    longer = motion.skeleton.replace(offsets=motion.skeleton.offsets * 1.3)
    other = pose.poses(
        motion.replace(skeleton=longer, rotations=rotations, root_positions=places + np.array([3.0, 0.0, -2.0]))
    )
    assert difference(other.quaternions, expected.quaternions) < 1e-9
    turned = np.angle(np.exp(1j * (other.yaw - expected.yaw - 1.1)))
    np.testing.assert_allclose(turned, 0.0, atol=1e-9)


def test_forearm_twist_is_no_part_of_the_pose(rng: np.random.Generator) -> None:
    """Turning the forearm about its own bone, as some rigs and all wrists do, leaves the pose as it is (§2.7)."""
    motion = moving(rng)
    rotations = motion.rotations.copy()
    elbow = motion.skeleton.find("LeftForeArm")
    rotations[:, elbow] = quaternion.multiply(rotations[:, elbow], quaternion.from_rotvec([0.6, 0, 0]))
    assert (
        difference(pose.poses(motion.replace(rotations=rotations)).quaternions, pose.poses(motion).quaternions) < 1e-9
    )


@pytest.mark.parametrize("rig", ["t-pose", "any axes"])
def test_the_mirror_law(rig: str, rng: np.random.Generator) -> None:
    """Positions of the mirror image are reflected and swapped, its poses are W applied, and twice is the identity."""
    motion = moving(rng, frames=150)
    if rig == "any axes":
        motion = in_other_rig(motion, axis_rotations()[rng.integers(0, 24, motion.skeleton.joint_count)])
    image = mirroring.mirror(motion)
    partner = list(mirroring.partners(motion.skeleton, anatomy.resolve(motion).roles))
    np.testing.assert_allclose(image.positions(), motion.positions()[:, partner] * [-1, 1, 1], atol=1e-9)
    expected = pose.mirror(pose.poses(motion).quaternions)
    assert difference(pose.poses(image).quaternions, expected) < 1e-9
    np.testing.assert_allclose(pose.poses(image).yaw, -pose.poses(motion).yaw, atol=1e-9)
    # the law is no gift of the frames that the image carries: found anew from the mirrored file, they are the same
    anew = image.replace(skeleton=image.skeleton.replace(anatomy=None))
    assert difference(pose.poses(anew).quaternions, expected) < 1e-6
    twice = mirroring.mirror(image)
    np.testing.assert_allclose(twice.positions(), motion.positions(), atol=1e-12)


def test_spread_keeps_the_whole_rotation(rng: np.random.Generator) -> None:
    """However many joints a spine has, its three links together turn as far as all of them."""
    for count in (1, 2, 3, 4, 5, 7):
        steps = [quaternion.from_rotvec(rng.normal(0, 0.3, (5, 3))) for _ in range(count)]
        whole = quaternion.identity((5,))
        for step in steps:
            whole = quaternion.multiply(whole, step)
        links = anatomy.spread(steps, 3)
        together = quaternion.multiply(quaternion.multiply(links[:, 0], links[:, 1]), links[:, 2])
        assert difference(together, whole) < 1e-9
        if count == 3:
            assert difference(links, np.stack(steps, axis=1)) < 1e-12
    assert difference(anatomy.spread([], 3), quaternion.identity((1, 3))) == 0.0


@pytest.mark.parametrize(("unit", "scale"), sorted(conventions.UNITS.items()))
def test_units_are_told_by_the_leg(unit: str, scale: float, rng: np.random.Generator) -> None:
    """A body written in any unit is read in metres, and the reading is said."""
    motion = moving(rng, 5)
    body = motion.skeleton.replace(offsets=motion.skeleton.offsets / scale)
    found = conventions.detect(body, motion.positions() / scale)
    assert found.metres_per_unit == scale
    assert found.up_axis == "y"
    assert len(found.assumptions) == 2
    assert conventions.detect(body, motion.positions() / scale, unit="m").metres_per_unit == 1.0


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
def test_up_is_told_by_head_over_feet(up: str, rng: np.random.Generator) -> None:
    """A body in a world with any axis up is told by its head, and can be turned back."""
    motion = moving(rng, 5)
    back = quaternion.conjugate(conventions.to_y_up(up))
    positions = quaternion.rotate(back, motion.positions())
    found = conventions.detect(motion.skeleton, positions)
    assert found.up_axis == up
    np.testing.assert_allclose(quaternion.rotate(conventions.to_y_up(up), positions), motion.positions(), atol=1e-12)
    with pytest.raises(InputError, match='"w"'):
        conventions.detect(motion.skeleton, positions, up="w")
    with pytest.raises(InputError, match="furlong"):
        conventions.detect(motion.skeleton, positions, unit="furlong")


def test_a_foot_that_is_never_seen_flat_is_like_the_other(rng: np.random.Generator) -> None:
    """Its rest pose, in which the toes hang down, does not tell: the toes are as far below the ankle as the other's."""
    walk = performer.walk(seconds=8.0, fps=30.0, seed=2).motion
    body = walk.skeleton
    foot, toes, other, opposite = (
        body.joint_index[name] for name in ("LeftFoot", "LeftToeBase", "RightFoot", "RightToeBase")
    )
    hangs = quaternion.from_rotvec([np.deg2rad(35.0), 0.0, 0.0])
    offsets, rotations = body.offsets.copy(), walk.rotations.copy()
    offsets[toes] = quaternion.rotate(hangs, offsets[toes])
    rolls = quaternion.from_rotvec(rng.uniform(-1.0, 1.0, (walk.frame_count, 3)) * [0.6, 0.0, 0.6])
    rotations[:, foot] = quaternion.multiply(
        quaternion.multiply(rotations[:, foot], rolls), quaternion.conjugate(hangs)
    )
    rolling = Motion(body.replace(offsets=offsets), rotations, walk.root_positions, walk.fps)
    frames = anatomy.resolve(rolling).frames

    def slope(joint: int, end: int) -> float:
        x, y, z = quaternion.rotate(quaternion.conjugate(frames[joint]), rolling.skeleton.offsets[end])
        return float(np.arctan2(y, np.hypot(x, z)))

    assert slope(foot, toes) == pytest.approx(slope(other, opposite), abs=1e-9)
    assert slope(other, opposite) > np.deg2rad(-60.0)
