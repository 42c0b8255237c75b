"""C_free: joint limits of the file, and limbs that pass through the body."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose

import bodies
from kinesics import compiled, formats
from kinesics.body import limits
from kinesics.body.mirroring import mirror
from kinesics.body.motion import Motion
from kinesics.body.skeleton import EndSite, JointFreedom, Skeleton
from kinesics.geometry import euler, quaternion
from naive import geometry as naive

HUMAN = bodies.human()
J = HUMAN.joint_index
SKELETON = HUMAN.replace(
    end_sites=(
        *HUMAN.end_sites,
        EndSite(J["LeftHand"], (0.15, 0.0, 0.0)),
        EndSite(J["RightHand"], (-0.15, 0.0, 0.0)),
    )
)


def posed(skeleton: Skeleton = SKELETON, frames: int = 1, **turns: Any) -> Motion:
    """The T-pose, with joints turned by rotation vectors (3,) or (frames, 3)."""
    rotations = quaternion.identity((frames, skeleton.joint_count))
    for name, vector in turns.items():
        rotations[:, skeleton.find(name)] = quaternion.from_rotvec(np.asarray(vector, dtype=np.float64))
    return Motion(skeleton, rotations, np.tile([0.0, 0.95, 0.0], (frames, 1)), 30.0)


def limited(freedom: JointFreedom) -> Skeleton:
    """The body with one joint, the left arm, whose file gives limits."""
    freedoms = list(SKELETON.freedoms)
    freedoms[J["LeftArm"]] = freedom
    return SKELETON.replace(freedoms=tuple(freedoms))


def turned(freedom: JointFreedom, angles: Any) -> Motion:
    """The left arm at Euler angles (frames, 3) in the joint's own frame and order."""
    inner = euler.from_euler(np.deg2rad(angles), freedom.order)
    axis = np.array(freedom.axis)
    local = quaternion.multiply(quaternion.multiply(axis, inner), quaternion.conjugate(axis))
    motion = posed(limited(freedom), len(local))
    rotations = motion.rotations.copy()
    rotations[:, J["LeftArm"]] = local
    return motion.replace(rotations=rotations)


def degrees(*pairs: tuple[float, float]) -> tuple[tuple[float, float], ...]:
    return tuple((float(np.deg2rad(a)), float(np.deg2rad(b))) for a, b in pairs)


TILTED = tuple(float(v) for v in quaternion.normalize([0.9, 0.2, -0.3, 0.25]))
SHOULDER = JointFreedom(order="ZYX", channels="xyz", axis=TILTED, limits=degrees((-60, 90), (-80, 80), (-45, 45)))


def test_within_its_limits_a_joint_is_let_pass(rng: np.random.Generator) -> None:
    """Any angles within the limits, in the joint's own tilted frame."""
    low, high = np.rad2deg(np.array(SHOULDER.limits)).T
    xyz = rng.uniform(low, high, size=(500, 3))
    found = limits.joint_excesses(turned(SHOULDER, xyz[:, ::-1]))
    assert found.excesses == ()
    assert found.frames == 0


def test_beyond_its_limits_a_joint_is_told_with_axis_frame_and_degrees() -> None:
    """10° beyond about z in frames 3 to 5, worst 25° in frame 4."""
    zyx = np.zeros((10, 3))
    zyx[3:6, 0] = [55.0, 70.0, 55.0]
    found = limits.joint_excesses(turned(SHOULDER, zyx))
    (excess,) = found.excesses
    assert (excess.joint, excess.axis, excess.frames, excess.worst_frame) == ("LeftArm", "z", 3, 4)
    assert excess.worst_degrees == pytest.approx(25.0)
    assert (excess.lowest_degrees, excess.highest_degrees) == pytest.approx((-45.0, 45.0))
    assert found.frames == 3


@pytest.mark.parametrize(("angle", "told"), [(45.9, False), (46.1, True), (-45.9, False), (-46.1, True)])
def test_the_tolerance_is_a_degree(angle: float, told: bool) -> None:
    """On either side of the range."""
    assert bool(limits.joint_excesses(turned(SHOULDER, [[angle, 0.0, 0.0]])).excesses) is told


def test_a_hinge_has_one_limit() -> None:
    """An elbow that bends to 170° is within (−10°, 170°); one bent backwards by 30° is not."""
    hinge = JointFreedom(order="ZYX", channels="x", axis=TILTED, limits=degrees((-10, 170)))
    assert limits.joint_excesses(turned(hinge, [[0.0, 0.0, 169.0]])).excesses == ()
    (excess,) = limits.joint_excesses(turned(hinge, [[0.0, 0.0, 60.0], [0.0, 0.0, -30.0]])).excesses
    assert (excess.axis, excess.worst_frame) == ("x", 1)
    assert excess.worst_degrees == pytest.approx(20.0)


def test_channels_in_another_order_than_the_axes() -> None:
    """Limits belong to channels, channels to axes."""
    odd = JointFreedom(order="ZYX", channels="zx", limits=degrees((-5, 5), (-100, 100)))
    (excess,) = limits.joint_excesses(turned(odd, [[20.0, 0.0, 90.0]])).excesses
    assert excess.axis == "z"
    assert excess.worst_degrees == pytest.approx(15.0)


@given(st.floats(-179, 179), st.floats(95, 175), st.floats(-179, 179))
def test_the_other_reading_of_the_same_rotation_counts(first: float, middle: float, third: float) -> None:
    """A file may write a middle angle beyond 90°: within its limits there, it is no fault that we would write it otherwise."""
    wide = JointFreedom(order="ZYX", channels="xyz", limits=degrees((-180, 180), (90, 180), (-180, 180)))
    assert limits.joint_excesses(turned(wide, [[first, middle, third]])).excesses == ()


def test_whole_turns_are_no_fault() -> None:
    """Limits of (100°, 260°) hold for an angle of 200°, which is also −160°."""
    far = JointFreedom(order="ZYX", channels="x", limits=degrees((100, 260)))
    assert limits.joint_excesses(turned(far, [[0.0, 0.0, 200.0]])).excesses == ()


def test_gimbal_lock_is_not_judged() -> None:
    """With the middle angle at 90° the outer ones are not defined."""
    tight = JointFreedom(order="ZYX", channels="xyz", limits=degrees((-10, 10), (-95, 95), (-10, 10)))
    assert limits.joint_excesses(turned(tight, [[40.0, 90.0, 40.0]])).excesses == ()


def test_a_file_without_limits_is_said_to_have_none() -> None:
    """Not checked is not the same as nothing found."""
    found = limits.free_space(posed())
    assert found.joints_checked == 0
    assert found.sentences[0] == "The file gives no joint limits."


def test_the_mirror_image_breaks_the_mirrored_limits_alike(rng: np.random.Generator) -> None:
    """§2.10: if Ψ is in C_free so is Ψ*; excesses change sides, not size."""
    zyx = rng.uniform(-90.0, 90.0, size=(200, 3))
    motion = turned(SHOULDER, zyx)
    original, image = limits.joint_excesses(motion), limits.joint_excesses(mirror(motion))
    assert original.frames == image.frames > 0
    assert {e.joint for e in image.excesses} == {"RightArm"}
    assert_allclose([e.worst_degrees for e in original.excesses], [e.worst_degrees for e in image.excesses], atol=1e-6)


points = arrays(np.float64, 3, elements=st.floats(-1.0, 1.0, width=32))


@given(points, points, points, points)
def test_segments_come_as_near_as_a_grid_finds(a0: np.ndarray, a1: np.ndarray, b0: np.ndarray, b1: np.ndarray) -> None:
    """Never farther than the best of a fine grid, and never nearer by more than the grid's mesh."""
    found = float(limits.segment_distance(a0, a1, b0, b1))
    assert found == pytest.approx(naive.segment_distance(a0, a1, b0, b1), abs=2e-5)
    # of nearly parallel ones a hundredth of a micrometre is left to rounding
    assert found == pytest.approx(float(limits.segment_distance(b1, b0, a0, a1)), abs=1e-7)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        (((0, 0, 0), (1, 0, 0)), ((0, 1, 0), (1, 1, 0)), 1.0),
        (((0, 0, 0), (1, 0, 0)), ((3, 0, 0), (2, 0, 0)), 1.0),
        (((0, 0, 0), (1, 0, 0)), ((0.5, -1, 0.25), (0.5, 1, 0.25)), 0.25),
        (((0, 0, 0), (0, 0, 0)), ((0, 3, 4), (0, 3, 4)), 5.0),
        (((0, 0, 0), (0, 0, 0)), ((-1, 2, 0), (1, 2, 0)), 2.0),
        (((-1, 2, 0), (1, 2, 0)), ((0, 0, 0), (0, 0, 0)), 2.0),
        (((0, 0, 0), (2, 0, 0)), ((1, 0, 0), (3, 0, 0)), 0.0),
    ],
)
def test_segments_in_special_places(a: Any, b: Any, expected: float) -> None:
    """Parallel, in line, crossing, points, overlapping."""
    assert float(limits.segment_distance(*np.array(a, float), *np.array(b, float))) == pytest.approx(expected)


def test_many_segments_at_once(rng: np.random.Generator) -> None:
    """Leading axes broadcast, entry by entry the same as alone."""
    a0, a1, b0, b1 = rng.normal(size=(4, 5, 1, 3))
    b0, b1 = b0[:, 0], b1[:, 0]
    together = limits.segment_distance(a0, a1, b0, b1)
    assert together.shape == (5, 5)
    assert_allclose(together[2, 3], limits.segment_distance(a0[2, 0], a1[2, 0], b0[3], b1[3]))


def test_radii_are_those_of_a_body() -> None:
    """At 1.75 m: a thigh of 14 cm, a shank of 9, an upper arm of 8, a forearm of 7 in diameter; in proportion to stature."""
    found = [200 * limits.capsule_radius(part, 1.75) for part in ("femur", "tibia", "humerus", "radius")]
    assert_allclose(found, [13.8, 9.2, 8.3, 6.9], atol=0.1)
    assert limits.capsule_radius("femur", 3.5) == pytest.approx(2 * limits.capsule_radius("femur", 1.75))


def test_the_t_pose_and_a_relaxed_stand_are_free() -> None:
    """Arms out, and arms hanging by the sides."""
    down = {"LeftArm": [0.0, 0.0, -1.45], "RightArm": [0.0, 0.0, 1.45]}
    for motion in (posed(), posed(**down)):
        found = limits.self_collisions(motion)
        assert found.pairs > 30
        assert found.collisions == ()


THROUGH = {"LeftArm": np.array([0.0, 0.0, -1.45]), "LeftForeArm": np.array([0.0, 0.0, -1.7])}
"""The upper arm hangs by the side, the forearm points inwards through the belly."""


def test_a_forearm_through_the_trunk_is_found() -> None:
    """In the frames in which it is there, as deep as the two are thick together."""
    still = {name: np.zeros((8, 3)) for name in THROUGH}
    for name, vector in THROUGH.items():
        still[name][3:6] = vector
    found = limits.self_collisions(posed(frames=8, **still))
    (hit,) = found.collisions
    assert (hit.first, hit.second, hit.frames, found.frames) == ("lower trunk", "left radius", 3, 3)
    assert hit.worst_frame == 3
    stature = 0.86 / 0.491
    assert hit.worst_depth == pytest.approx(0.3 * 0.36 + limits.capsule_radius("radius", stature), abs=0.01)


def test_crossed_shanks_are_found_with_their_depth() -> None:
    """Both legs turned inwards by 20° cross below the knees."""
    found = limits.self_collisions(posed(LeftUpLeg=[0.0, 0.0, -0.35], RightUpLeg=[0.0, 0.0, 0.35]))
    pairs = {frozenset((c.first, c.second)) for c in found.collisions}
    assert frozenset(("left femur", "right femur")) in pairs or frozenset(("left tibia", "right tibia")) in pairs


def test_the_tolerance_lets_flesh_touch() -> None:
    """What is found at no tolerance and not at five centimetres is a touch."""
    knees = posed(LeftUpLeg=[0.0, 0.0, -0.08], RightUpLeg=[0.0, 0.0, 0.08])
    assert limits.self_collisions(knees, tolerance=0.0).collisions
    assert limits.self_collisions(knees).collisions == ()


def test_collisions_do_not_depend_on_place_heading_or_side(rng: np.random.Generator) -> None:
    """Moved, turned and mirrored, the same depths in the same frames."""
    turns = {
        name: rng.normal(scale=0.9, size=(60, 3)) for name in ("LeftArm", "LeftForeArm", "RightUpLeg", "LeftUpLeg")
    }
    motion = posed(frames=60, **turns)
    elsewhere = posed(frames=60, Hips=[0.0, 2.0, 0.0], **turns).replace(
        root_positions=np.tile([5.0, 1.0, -3.0], (60, 1))
    )
    here, there, image = (limits.self_collisions(m) for m in (motion, elsewhere, mirror(motion)))
    assert here.frames > 0
    assert (here.frames, here.pairs) == (there.frames, there.pairs) == (image.frames, image.pairs)
    depths = [[c.worst_depth for c in found.collisions] for found in (here, there, image)]
    assert_allclose(depths[0], depths[1], atol=1e-9)
    assert_allclose(depths[0], depths[2], atol=1e-9)


@pytest.mark.parametrize("least", [0.0, 0.05])
def test_depths_compiled_and_plain_agree(
    least: float, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator
) -> None:
    """The compiled module finds what NumPy finds, of limbs anywhere, of bones without length and of parallel ones."""
    if compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    capsules = limits.Capsules.of(posed())
    positions = rng.normal(scale=0.3, size=(60, SKELETON.joint_count, 3))
    rotations = quaternion.normalize(rng.normal(size=(60, SKELETON.joint_count, 4)))
    positions[:5] = positions[:5, :1]
    positions[5:9, :, 0] = 0.1
    positions[5:9, :, 2] = 0.0
    monkeypatch.delenv("KINESICS_KERNEL", raising=False)
    monkeypatch.setenv("KINESICS_NO_NATIVE", "0")
    quick = capsules.depths(positions, rotations, least=least)
    monkeypatch.setenv("KINESICS_NO_NATIVE", "1")
    assert_allclose(quick, capsules.depths(positions, rotations, least=least), atol=1e-12)
    assert np.isfinite(quick).any()
    assert np.isneginf(quick).any()


def test_some_pairs_are_as_deep_as_among_all() -> None:
    """Of the capsules only those of the pairs looked at matter: what the others are, even unknown, changes nothing."""
    motion = posed(
        frames=3, LeftUpLeg=[[0.0, 0.0, -0.1], [0.0, 0.0, -0.2], [0.2, 0.0, -0.3]], RightUpLeg=[0.0, 0.0, 0.1]
    )
    capsules = limits.Capsules.of(motion)
    legs = [
        n
        for n, pair in enumerate(capsules.pairs)
        if all("femur" in (m := capsules.names[k]) or "tibia" in m for k in pair)
    ]
    some = dataclasses.replace(capsules, pairs=tuple(capsules.pairs[n] for n in legs))
    known = motion.positions(), motion.global_rotations()
    found = some.depths(*known)
    assert found.max() > 0.0
    arms = [n for n, name in enumerate(SKELETON.joint_names) if "Arm" in name or "Hand" in name]
    unknown = tuple(values.copy() for values in known)
    for values in unknown:
        values[:, arms] = np.nan
    assert_allclose(found, capsules.depths(*known)[:, legs])
    assert_allclose(found, some.depths(*unknown))
    assert dataclasses.replace(capsules, pairs=()).depths(*known).shape == (3, 0)


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_radii_are_scaled_to_the_body(scale: float) -> None:
    """A child or a giant in the same pose collides alike: depths grow with the body."""
    bigger = SKELETON.replace(
        offsets=SKELETON.offsets * scale,
        end_sites=tuple(EndSite(s.parent, tuple(scale * v for v in s.offset)) for s in SKELETON.end_sites),
    )
    usual = limits.self_collisions(posed(**THROUGH), tolerance=0.05).collisions[0]
    scaled = limits.self_collisions(posed(bigger, **THROUGH), tolerance=0.05 * scale).collisions[0]
    assert scaled.worst_depth == pytest.approx(scale * usual.worst_depth)


def test_a_skeleton_that_is_no_body_is_said_not_to_be_checked() -> None:
    """A chain of bones has no limbs to collide."""
    chain = Skeleton(("a", "b", "c"), (-1, 0, 1), np.array([[0.0, 0, 0], [0, 1, 0], [0, 1, 0]]))
    motion = Motion(chain, quaternion.identity((2, 3)), np.zeros((2, 3)), 30.0)
    found = limits.free_space(motion)
    assert found.pairs_checked == 0
    assert "not checked" in found.sentences[-1]


def test_the_result_is_plain_for_json_and_short_for_people() -> None:
    """Through JSON and back nothing is lost; two sentences say it all."""
    zyx = np.zeros((4, 3))
    zyx[2, 0] = 90.0
    found = limits.free_space(turned(SHOULDER, zyx))
    plain = found.to_dict()
    assert json.loads(json.dumps(plain)) == plain
    assert plain["excesses"][0]["joint"] == "LeftArm"
    assert len(found.sentences) == 2
    assert found.sentences[0] == "Beyond the file's own joint limits: LeftArm by up to 45° about z (frame 2)."


def test_sentences_name_each_joint_once_and_leave_hands_and_toes_out() -> None:
    """Whatever wrists and toes do, the joints that matter are told, three at most and worst first; values keep them all."""
    narrow = JointFreedom(order="ZYX", channels="xyz", limits=degrees((-5, 5), (-5, 5), (-5, 5)))
    angles = {"LeftHand": 80.0, "LeftLeg": 50.0, "RightArm": 40.0, "Head": 30.0, "Spine": 20.0}

    def told(*names: str) -> limits.FreeSpace:
        freedoms = tuple(
            narrow if n in angles else f for n, f in zip(SKELETON.joint_names, SKELETON.freedoms, strict=True)
        )
        return limits.free_space(
            posed(SKELETON.replace(freedoms=freedoms), **{n: np.deg2rad([angles[n] / 2, 0, angles[n]]) for n in names})
        )

    everything = told(*angles)
    sentence = everything.sentences[0]
    assert [name for name in angles if name in sentence] == ["LeftLeg", "RightArm", "Head"]
    assert sentence.count("LeftLeg") == 1
    assert sentence.endswith(" and 1 more.")
    assert {e.joint for e in everything.excesses} == set(angles)
    assert told("LeftHand").sentences[0] == "Only wrists, hands, fingers or toes go beyond the file's own joint limits."


def test_angles_of_a_real_file_come_back_as_written(shared_data: Path) -> None:
    """CMU 02_01: the left wrist's y, limited to (−180°, 0°), is written as 29.6913° in its worst frame, counted from 0."""
    path = shared_data / "cmu" / "02" / "02_01.amc"
    blocks = path.read_text().split("\nlwrist ")[1:]
    written = np.array([float(block.split()[0]) for block in blocks])
    found = limits.joint_excesses(formats.read(path)).excesses
    wrist = next(e for e in found if e.joint == "lwrist")
    assert wrist.axis == "y"
    assert wrist.worst_degrees == pytest.approx(written.max(), abs=1e-6)
    assert wrist.worst_frame == int(np.argmax(written))
    assert wrist.frames == int((written > 1.0).sum())


def test_walking_is_free_of_collisions(shared_data: Path) -> None:
    """Ordinary walks of two people."""
    for clip in ("07/07_01", "16/16_21", "91/91_34"):
        assert limits.self_collisions(formats.read(shared_data / "cmu" / f"{clip}.amc")).collisions == ()
