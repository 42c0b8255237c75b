"""One body's movement on another: poses go back into joints, bones point the same way, feet stand on the ground."""

from __future__ import annotations

import zipfile
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import kinesics as kx
from kinesics.body import anatomy, contacts, retargeting
from kinesics.body.motion import Motion
from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.errors import InputError, SkeletonError
from kinesics.geometry import quaternion
from naive import retargeting as naive

Array = NDArray[np.float64]
LEG = ("UpLeg", "Leg", "Foot", "Toe")
ARM = ("Arm", "ForeArm", "Hand")


def body(
    spine: int = 3, neck: int = 2, *, clavicle: bool = True, thigh: float = 0.42, shank: float = 0.41, arm: float = 0.28,
    sides: tuple[float, float] = (1.0, 1.0), fingers: bool = False,
) -> Skeleton:  # fmt: skip
    """A human in a T-pose facing +z, with as many joints as asked for."""
    joints: list[tuple[str, str, tuple[float, float, float]]] = [("Hips", "", (0.0, 0.0, 0.0))]
    above = "Hips"
    for k in range(spine):
        joints.append((f"Spine{k}", above, (0.0, 0.36 / spine, 0.0)))
        above = joints[-1][0]
    chest = above
    for k in range(neck):
        joints.append((f"Neck{k}", above, (0.0, 0.16 if k == 0 else 0.05, 0.0)))
        above = joints[-1][0]
    joints.append(("Head", above, (0.0, 0.1, 0.0)))
    sites = {"Head": (0.0, 0.2, 0.0)}
    for side, sign, size in (("Left", 1.0, sides[0]), ("Right", -1.0, sides[1])):
        girdle = chest
        if clavicle:
            joints.append((f"{side}Shoulder", chest, (0.04 * sign, 0.1, 0.0)))
            girdle = f"{side}Shoulder"
        joints += [
            (f"{side}Arm", girdle, (0.14 * sign, 0.0, 0.0)),
            (f"{side}ForeArm", f"{side}Arm", (arm * sign, 0.0, 0.0)),
            (f"{side}Hand", f"{side}ForeArm", (0.9 * arm * sign, 0.0, 0.0)),
            (f"{side}UpLeg", "Hips", (0.1 * sign, -0.05, 0.0)),
            (f"{side}Leg", f"{side}UpLeg", (0.0, -thigh * size, 0.0)),
            (f"{side}Foot", f"{side}Leg", (0.0, -shank * size, 0.0)),
            (f"{side}Toe", f"{side}Foot", (0.0, -0.06, 0.13)),
        ]
        if fingers:
            joints.append((f"{side}HandIndex", f"{side}Hand", (0.08 * sign, 0.0, 0.0)))
        sites |= {f"{side}Hand": (0.1 * sign, 0.0, 0.0), f"{side}Toe": (0.0, 0.0, 0.06)}
    names = [name for name, _, _ in joints]
    return Skeleton(
        tuple(names),
        tuple(names.index(parent) if parent else -1 for _, parent, _ in joints),
        np.array([offset for _, _, offset in joints]),
        tuple(EndSite(names.index(n), o) for n, o in sites.items()),
    )


def in_frames_of_its_own(motion: Motion, rng: np.random.Generator) -> Motion:
    """The same movement in a file whose joints have frames of any direction, so that its rest is no human pose."""
    skeleton = motion.skeleton
    turn = quaternion.normalize(rng.normal(size=(skeleton.joint_count, 4)))
    world = quaternion.multiply(motion.global_rotations(), quaternion.conjugate(turn))
    local = world.copy()
    for j, parent in enumerate(skeleton.parents[1:], start=1):
        local[:, j] = quaternion.multiply(quaternion.conjugate(world[:, parent]), world[:, j])
    offsets = np.array(
        [
            quaternion.rotate(turn[p], o) if p >= 0 else o
            for p, o in zip(skeleton.parents, skeleton.offsets, strict=True)
        ]
    )
    sites = tuple(
        EndSite(s.parent, tuple(float(v) for v in quaternion.rotate(turn[s.parent], s.offset)))
        for s in skeleton.end_sites
    )
    return motion.replace(skeleton=Skeleton(skeleton.joint_names, skeleton.parents, offsets, sites), rotations=local)


def moving(skeleton: Skeleton, rng: np.random.Generator, frames: int = 40, size: float = 0.5) -> Motion:
    """All joints turn smoothly, each about an axis of its own; knees and elbows more than the others."""
    t = np.linspace(0.0, 2.0 * np.pi, frames)[:, None, None]
    joints = skeleton.joint_count
    vectors = size * rng.normal(size=(joints, 3)) * np.sin(t + rng.uniform(0, 6, (joints, 3))) * 0.5
    for j, name in enumerate(skeleton.joint_names):
        if name.endswith("Leg") and not name.endswith("UpLeg"):
            vectors[:, j] = [1.0, 0.0, 0.0] * (0.5 + 0.4 * np.sin(t[:, 0]))
        elif name.endswith("ForeArm"):
            vectors[:, j] = np.array([0.0, -1.0 if name.startswith("Left") else 1.0, 0.0]) * (
                0.6 + 0.5 * np.cos(t[:, 0])
            )
    places = np.stack([0.3 * np.sin(t[:, 0, 0]), 0.9 + 0.02 * np.cos(t[:, 0, 0]), 0.5 * t[:, 0, 0]], axis=1)
    return Motion(skeleton, quaternion.from_rotvec(vectors), places, 30.0)


def walking(skeleton: Skeleton, frames: int = 180) -> Motion:
    """A plain walk along +z whose feet stand: the lower foot carries the body."""
    phase = 2.0 * np.pi * np.arange(frames) / 60.0
    vectors = np.zeros((frames, skeleton.joint_count, 3))
    for side, swing in (("Left", np.sin(phase)), ("Right", -np.sin(phase))):
        knee = 0.1 + 0.5 * np.clip(np.cos(phase if side == "Left" else phase + np.pi), 0, 1) ** 2
        vectors[:, skeleton.find(f"{side}UpLeg"), 0] = -0.4 * swing - 0.5 * knee
        vectors[:, skeleton.find(f"{side}Leg"), 0] = knee
        vectors[:, skeleton.find(f"{side}Foot"), 0] = 0.4 * swing - 0.5 * knee
    rotations = quaternion.from_rotvec(vectors)
    still = Motion(skeleton, rotations, np.zeros((frames, 3)), 60.0)
    ball = still.positions()[:, [skeleton.find("LeftToe"), skeleton.find("RightToe")]]
    stance = ball[..., 1].argmin(axis=1)
    places = np.zeros((frames, 3))
    places[:, 1] = 0.03 - ball[..., 1].min(axis=1)
    for f in range(1, frames):
        k = stance[f]
        places[f, [0, 2]] = places[f - 1, [0, 2]] - (ball[f, k] - ball[f - 1, k])[[0, 2]]
    return still.replace(root_positions=places)


def off(a: Array, b: Array) -> float:
    return float(quaternion.angle(a, b).max())


def distance(a: Motion, b: Motion) -> Array:
    """D frame by frame, in double precision."""
    first, second = kx.poses(a), kx.poses(b)
    dots = np.abs(np.sum(first.quaternions * second.quaternions, axis=-1))
    dots[:, 0] = np.sqrt(np.clip((1.0 + np.sum(first.gravity * second.gravity, axis=-1)) / 2.0, 0.0, 1.0))
    return np.asarray(1.0 - dots.mean(axis=-1))


@pytest.mark.parametrize(
    ("spine", "neck", "clavicle"), [(3, 2, True), (0, 0, False), (1, 1, True), (2, 1, True), (4, 3, False)]
)
def test_in_the_t_pose_every_link_is_the_identity(spine: int, neck: int, clavicle: bool) -> None:
    """Whatever joints a body has, its T-pose reads as the identity of all links and faces +z."""
    skeleton = body(spine, neck, clavicle=clavicle)
    read = kx.poses(Motion(skeleton, retargeting.t_pose(skeleton)[None], np.zeros((1, 3)), 30.0))
    assert off(read.quaternions, quaternion.identity((1, 15))) < 1e-12
    assert abs(read.yaw[0]) < 1e-12


def test_a_rig_that_rests_in_no_human_pose_gets_the_same_t_pose(rng: np.random.Generator) -> None:
    """Frames of any direction change numbers, not the T-pose in the world; toes and hands lie where they do at rest."""
    plain = moving(body(), rng, frames=120)
    rig = anatomy.understood(in_frames_of_its_own(plain, rng)).skeleton
    at_rest = body().rest_positions
    found = Motion(rig, retargeting.t_pose(rig)[None], np.zeros((1, 3)), 30.0).positions()[0]
    for names, near in (
        ((*(f"{s}{p}" for s in ("Left", "Right") for p in ("UpLeg", "Leg", "Arm", "ForeArm", "Hand")),), 0.06),
    ):
        for name in names:
            assert np.linalg.norm(found[rig.find(name)] - at_rest[rig.find(name)]) < near, name
    links = anatomy.link_rotations(
        anatomy.resolve(Motion(rig, retargeting.t_pose(rig)[None], np.zeros((1, 3)), 30.0)),
        Motion(rig, retargeting.t_pose(rig)[None], np.zeros((1, 3)), 30.0).global_rotations(),
    )
    assert off(links, quaternion.identity((1, 15))) < 1e-9


def test_a_rig_without_anatomy_that_rests_in_no_human_pose_is_refused(rng: np.random.Generator) -> None:
    """Its rest alone cannot tell; the message says to take the skeleton of a recording."""
    rig = in_frames_of_its_own(moving(body(), rng), rng).skeleton
    names = tuple(f"bone{j}" for j in range(rig.joint_count))
    with pytest.raises(SkeletonError, match="skeleton of a recording"):
        retargeting.t_pose(rig.replace(joint_names=names))


@pytest.mark.parametrize(("spine", "neck"), [(3, 2), (4, 2), (5, 3), (7, 4)])
def test_poses_go_into_joints_and_come_back(spine: int, neck: int, rng: np.random.Generator) -> None:
    """Reading the poses of joints that were set by poses gives them again, yaw included."""
    source = moving(body(), rng)
    wanted = kx.poses(source)
    skeleton = body(spine, neck, clavicle=spine % 2 == 0)
    local = retargeting.joint_rotations(skeleton, wanted.quaternions, wanted.yaw)
    read = kx.poses(Motion(skeleton, local, source.root_positions, 30.0))
    assert off(read.quaternions, wanted.quaternions) < 1e-7
    np.testing.assert_allclose(np.exp(1j * read.yaw), np.exp(1j * wanted.yaw), atol=1e-9)


@pytest.mark.parametrize(("spine", "neck"), [(2, 1), (1, 1), (1, 0)])
def test_short_spines_keep_chest_and_head(spine: int, neck: int, rng: np.random.Generator) -> None:
    """With fewer joints the bend is spread otherwise, but chest and head are oriented as they were, and so are the limbs."""
    source = moving(body(), rng)
    wanted = kx.poses(source)
    skeleton = body(spine, neck)
    local = retargeting.joint_rotations(skeleton, wanted.quaternions, wanted.yaw)
    out = Motion(skeleton, local, source.root_positions, 30.0)
    assert off(kx.poses(out).quaternions[:, 7:], wanted.quaternions[:, 7:]) < 1e-7
    for name, theirs in (("Head", "Head"), (f"Spine{spine - 1}", "Spine2")):
        ours, other = (
            out.global_rotations()[:, skeleton.find(name)],
            source.global_rotations()[:, source.skeleton.find(theirs)],
        )
        assert off(ours, other) < 1e-7


@given(st.integers(0, 9), st.integers(1, 3), st.integers(0, 2**32 - 1))
def test_unspread_is_undone_by_spread(count: int, links: int, seed: int) -> None:
    """From as many joints as links on, a chain is read back link by link; shorter ones keep the whole; small steps agree."""
    rng = np.random.default_rng(seed)
    wanted = quaternion.from_rotvec(rng.normal(size=(3, links, 3)) * 0.4)
    joints = retargeting.unspread(wanted, count)
    assert len(joints) == count
    if count == 0:
        return
    read = anatomy.spread(joints, links)
    whole, whole_read = wanted[:, 0], read[:, 0]
    for k in range(1, links):
        whole, whole_read = quaternion.multiply(whole, wanted[:, k]), quaternion.multiply(whole_read, read[:, k])
    assert off(whole, whole_read) < 1e-7
    if count >= links:
        assert off(read, wanted) < 1e-7
    slow = naive.links_of_chain([tuple(j[0]) for j in joints], links)
    assert off(read[0], np.array(slow)) < 1e-7


def test_the_same_skeleton_leaves_the_motion_as_it_is(rng: np.random.Generator) -> None:
    """Identical joints and lengths: nothing is computed, every number stays."""
    motion = moving(body(), rng)
    out = retargeted(motion, body())
    np.testing.assert_array_equal(out.rotations, motion.rotations)
    np.testing.assert_array_equal(out.root_positions, motion.root_positions)


def retargeted(motion: Motion, skeleton: Skeleton) -> Motion:
    return retargeting.retarget(motion, skeleton)


def test_one_rig_in_another_size_keeps_its_rotations(rng: np.random.Generator) -> None:
    """Bones in the same directions but of other lengths: rotations are copied, the way is scaled by the legs."""
    motion = walking(body())
    out = retargeted(motion, body(thigh=0.84, shank=0.82, arm=0.5))
    np.testing.assert_array_equal(out.rotations, motion.rotations)
    np.testing.assert_allclose(out.root_positions[:, [0, 2]], 2.0 * motion.root_positions[:, [0, 2]], atol=1e-9)
    assert any("scaled by 2.000" in said for said in out.assumptions)


def test_bones_point_the_same_way_on_a_rig_of_any_frames(rng: np.random.Generator) -> None:
    """Thighs, shanks, arms, hands and feet point where they pointed, in a file whose frames are all others."""
    motion = moving(body(), rng, frames=100)
    other = moving(body(2, 1, thigh=0.5, arm=0.33), rng, frames=100)
    bones = [
        (f"{side}{a}", f"{side}{b}") for side in ("Left", "Right") for chain in (LEG[:3], ARM) for a, b in pairwise(chain)
    ]  # fmt: skip
    wanted = naive.directions(motion.positions(), motion.skeleton.joint_names, bones)
    for skeleton in (other.skeleton, anatomy.understood(in_frames_of_its_own(other, rng)).skeleton):
        out = retargeted(motion, skeleton)
        found = naive.directions(out.positions(), skeleton.joint_names, bones)
        for bone, rows in wanted.items():
            degrees = np.degrees(np.arccos(np.clip((rows * found[bone]).sum(axis=1), -1.0, 1.0)))
            assert degrees.max() < 1e-3, bone


def test_there_and_back_is_the_same_movement(rng: np.random.Generator) -> None:
    """Over a rig with more spine joints and other lengths, and back: poses to the last digits, places to a millimetre."""
    motion = walking(body())
    there = retargeted(motion, body(5, 3, thigh=0.5, shank=0.38, clavicle=False))
    back = retargeted(there, motion.skeleton)
    assert distance(motion, there).max() < 1e-12
    assert distance(motion, back).max() < 1e-12
    assert np.abs(back.positions() - motion.positions()).max() < 2e-3


def test_the_mirror_image_can_be_brought_before_or_after() -> None:
    """Mirrored and then brought over, or brought over and then mirrored: the same poses, the same places over the ground."""
    motion, skeleton = (
        walking(body(sides=(1.0, 1.05))),
        anatomy.understood(walking(body(4, 1, sides=(0.9, 0.93)))).skeleton,
    )
    first = retargeted(kx.mirror(motion), skeleton)
    second = kx.mirror(retargeted(motion, skeleton))
    assert off(kx.poses(first).quaternions, kx.poses(second).quaternions) < 1e-7
    np.testing.assert_allclose(kx.poses(first).ground, kx.poses(second).ground, atol=1e-9)
    assert np.abs(first.root_positions[:, 1] - second.root_positions[:, 1]).max() < 0.03


def test_feet_of_another_body_stand_on_the_ground() -> None:
    """Where the walker's foot stands the other's stands, neither above nor below the floor."""
    motion = walking(body())
    for skeleton in (body(thigh=0.5, shank=0.5), body(thigh=0.3, shank=0.3), body(thigh=0.5, shank=0.33)):
        out = retargeted(motion, skeleton)
        here, there = contacts.contacts(motion), contacts.contacts(out)
        assert (here.feet == there.feet).mean() > 0.93
        lowest = there.positions[..., 1].min(axis=(1, 2))
        assert np.abs(lowest - np.median(lowest)).max() < 0.02


def test_a_jump_stays_a_jump() -> None:
    """The body leaves the ground as high as its legs are long to those recorded."""
    motion = walking(body())
    up = np.zeros(len(motion))
    up[60:90] = 0.4 * np.sin(np.linspace(0.0, np.pi, 30))
    jump = motion.replace(root_positions=motion.root_positions + np.stack([0 * up, up, 0 * up], axis=1))
    tall = body(thigh=0.63, shank=0.615)
    still, leapt = retargeted(motion, tall), retargeted(jump, tall)
    np.testing.assert_allclose(leapt.root_positions[:, 1] - still.root_positions[:, 1], 1.5 * up, atol=0.02)


def test_fingers_and_hands_come_along(rng: np.random.Generator) -> None:
    """Hands by their role, fingers by their place or name; what the other body has besides stays as at rest."""
    motion = moving(body(fingers=True), rng)
    with_them = body(2, 1, fingers=True, arm=0.3)
    renamed = with_them.replace(joint_names=tuple(n.replace("HandIndex", "FingerBase") for n in with_them.joint_names))
    for skeleton, finger in ((with_them, "LeftHandIndex"), (renamed, "LeftFingerBase")):
        out = retargeted(motion, skeleton)
        for here, there in (("LeftHand", "LeftHand"), ("LeftHandIndex", finger)):
            ours, theirs = motion.skeleton.find(here), skeleton.find(there)
            assert off(out.rotations[:, theirs], motion.rotations[:, ours]) < 1e-7, there
        # a foot's frame is turned to the floor it was seen to stand on, so that the toes' axis is, too
        bend, theirs = out.rotations[:, skeleton.find("LeftToe")], motion.rotations[:, motion.skeleton.find("LeftToe")]
        np.testing.assert_allclose(quaternion.angle(bend), quaternion.angle(theirs), atol=1e-7)
    without = retargeted(moving(body(), rng), with_them)
    assert off(without.rotations[:, with_them.find("LeftHandIndex")], quaternion.identity((40,))) < 1e-9


def test_bad_poses_are_refused() -> None:
    """Wrong shapes and numbers that are none are named."""
    skeleton = body()
    with pytest.raises(InputError, match=r"\(frames, 15, 4\)"):
        retargeting.joint_rotations(skeleton, quaternion.identity((3, 14)))
    with pytest.raises(InputError, match="not zero"):
        retargeting.joint_rotations(skeleton, np.zeros((3, 15, 4)))
    with pytest.raises(InputError, match="yaw"):
        retargeting.joint_rotations(skeleton, quaternion.identity((3, 15)), [0.0, 1.0])
    with pytest.raises(InputError, match="yaw"):
        retargeting.joint_rotations(skeleton, quaternion.identity((3, 15)), np.nan)


def bandai(shared: Path, folder: Path, name: str) -> Motion:
    with zipfile.ZipFile(shared / "bandai-namco" / "clips.zip") as archive:
        member = next(n for n in sorted(archive.namelist()) if name in n)
        target = folder / Path(member).name
        target.write_bytes(archive.read(member))
    return kx.read(target)


def test_the_kata_is_the_same_on_either_of_its_files(shared_data: Path) -> None:
    """135_02 was recorded as ASF/AMC and written as BVH: brought from one onto the other, D stays what it was, to rounding."""
    asf = kx.read(shared_data / "cmu/135/135_02.amc")[::40]
    bvh = kx.read(shared_data / "cmu/bvh/135_02_120fps.bvh")[::40]
    out = retargeted(asf, bvh.skeleton)
    assert distance(asf, out).max() < 1e-9
    assert np.abs(out.positions() - bvh.positions()).max() < 1e-3


def test_cmu_on_bandai_namco_and_back(shared_data: Path, tmp_path: Path) -> None:
    """A CMU walk on a rig whose bones all lie along x, with two spine joints: limbs as they were, and back again."""
    walk = kx.read(shared_data / "cmu/07/07_01.amc")
    rig = anatomy.understood(bandai(shared_data, tmp_path, "dataset-1_walk_normal_001"))
    out = retargeted(walk, rig.skeleton)
    before, after = kx.poses(walk), kx.poses(out)
    assert off(before.quaternions[:, [0, *range(7, 15)]], after.quaternions[:, [0, *range(7, 15)]]) < 1e-7
    assert distance(walk, out).max() < 0.006  # one joint of the neck for two
    back = retargeted(out, walk.skeleton)
    links = [0, *range(7, 15)]
    assert off(kx.poses(back).quaternions[:, links], before.quaternions[:, links]) < 1e-7
    feet = [walk.skeleton.find(n) for n in ("lfoot", "rfoot", "ltoes", "rtoes", "lfemur", "rtibia")]
    apart = np.abs(back.positions()[:, feet] - walk.positions()[:, feet])
    assert apart[..., [0, 2]].max() < 0.006
    assert apart[..., 1].max() < 0.02  # the lowest point of another foot is another point
    here, there = contacts.contacts(walk), contacts.contacts(out)
    assert (here.feet == there.feet).mean() > 0.93


def test_bandai_namco_on_cmu_stands_on_flat_feet(shared_data: Path, tmp_path: Path) -> None:
    """D is kept to rounding, and a foot that stands flat on the one rig stands within 10° of flat on the other."""
    clip = anatomy.understood(bandai(shared_data, tmp_path, "dataset-1_walk_normal_001"))
    for name in ("cmu/07/07_01.amc", "cmu/bvh/cgspeed_02_01.bvh", "cmu/bvh/135_01_bassai_30fps.bvh"):
        other = anatomy.understood(kx.read(shared_data / name))
        out = retargeted(clip, other.skeleton)
        if "bassai" not in name:
            assert distance(clip, out).max() < 1e-9
        usual = other.skeleton.anatomy
        assert usual is not None
        flat = contacts.contacts(clip).points.all(axis=2)
        for k, foot in enumerate((usual.roles.left_foot, usual.roles.right_foot)):
            assert foot is not None
            world = quaternion.multiply(out.global_rotations()[:, foot], usual.frames[foot])
            up = quaternion.rotate(world, np.array([0.0, 1.0, 0.0]))[flat[:, k], 1]
            assert np.degrees(np.arccos(np.clip(np.median(up), -1, 1))) < 10.0


@pytest.mark.parametrize("clip", ["09/09_06", "16/16_35", "135/135_02"])
def test_feet_that_roll_are_flat_while_they_stand(shared_data: Path, clip: str) -> None:
    """Of runners and of a kata, too: where a foot is stillest on the ground its frame is upright, within 5°."""
    motion = anatomy.understood(kx.read(shared_data / f"cmu/{clip}.amc"))
    body = motion.skeleton.anatomy
    assert body is not None
    standing = contacts.contacts(motion).feet
    positions, world = motion.positions(), motion.global_rotations()
    for k, side in enumerate(("left", "right")):
        foot, toes = getattr(body.roles, f"{side}_foot"), getattr(body.roles, f"{side}_toes")
        speed = sum(np.linalg.norm(np.gradient(positions[:, j], axis=0), axis=1) for j in (foot, toes))
        still = standing[:, k] & (speed <= np.quantile(speed[standing[:, k]], 0.1))
        ahead = quaternion.rotate(quaternion.multiply(world[still, foot], body.frames[foot]), [0.0, 0.0, 1.0])
        assert abs(np.rad2deg(np.median(np.arcsin(ahead[:, 1])))) < 5.0
