"""The performer's body has human proportions and its joints are the 15 links."""

from __future__ import annotations

import numpy as np
import pytest

import kinesics as kx
from kinesics.body.mirroring import partners
from kinesics.errors import InputError
from kinesics.performer import STANDING, T_POSE, Body, posture
from kinesics.performer.body import JOINT, LINK_JOINTS
from kinesics.performer.postures import ANGLE, ANGLES, joint_rotations, mirror, pose
from kinesics.vocabulary import LINK_PARENTS, MIRROR_LINKS


def place(angles, joint, body=None):
    """World position of a joint with the root at the origin."""
    body = body or Body()
    motion = kx.Motion(body.skeleton, joint_rotations(angles[None]), np.zeros((1, 3)), 1.0)
    return motion.positions()[0, JOINT[joint]]


def test_lengths_are_those_of_the_table():
    """Thigh, shank, upper arm, forearm and stature are the fractions of body height that Drillis and Contini give."""
    body = Body(height=2.0)
    rest = body.skeleton.rest_positions
    for upper, lower, share in (
        ("LeftUpLeg", "LeftLeg", 0.245),
        ("LeftLeg", "LeftFoot", 0.246),
        ("LeftArm", "LeftForeArm", 0.186),
        ("LeftForeArm", "LeftHand", 0.146),
    ):
        assert np.linalg.norm(rest[JOINT[upper]] - rest[JOINT[lower]]) == pytest.approx(2.0 * share)
    sole = rest[JOINT["LeftToeBase"], 1]
    crown = rest[JOINT["Head"], 1] + body.skeleton.end_sites[0].offset[1]
    assert crown - sole == pytest.approx(2.0)
    assert rest[JOINT["LeftArm"], 1] - sole == pytest.approx(2.0 * 0.818)
    assert rest[JOINT["LeftUpLeg"], 1] - sole == pytest.approx(2.0 * 0.530)


def test_limbs_scale_apart_from_the_height():
    """Longer arms and shorter legs change those segments alone."""
    plain, odd = Body().skeleton, Body(arms=1.2, legs=0.9).skeleton
    ratio = np.linalg.norm(odd.offsets, axis=1)[1:] / np.maximum(np.linalg.norm(plain.offsets, axis=1)[1:], 1e-12)
    names = plain.joint_names[1:]
    for name, value in zip(names, ratio, strict=True):
        want = 1.2 if name.endswith(("ForeArm", "Hand")) else 0.9 if name.endswith(("Leg", "Foot")) else 1.0
        want = 1.0 if name.endswith("UpLeg") else want
        assert value == pytest.approx(want), name


@pytest.mark.parametrize(
    ("arguments", "name"),
    [({"height": 0.1}, "height"), ({"arms": 3.0}, "arms"), ({"legs": float("nan")}, "legs")],
)
def test_impossible_bodies_are_refused(arguments, name):
    """A body out of range is an `InputError` that names the argument and its range."""
    with pytest.raises(InputError, match=rf"`{name}`.*between"):
        Body(**arguments)


def test_the_skeleton_is_its_own_mirror_image():
    """Left and right have the same lengths, reflected."""
    skeleton = Body().skeleton
    np.testing.assert_allclose(skeleton.mirror(partners(skeleton)).offsets, skeleton.offsets, atol=0)


def test_each_link_has_a_joint_of_its_own():
    """The 15 links are 15 joints, and a link's parent link is among its joint's ancestors."""
    skeleton = Body().skeleton
    assert len(set(LINK_JOINTS)) == 15
    for link, parent in enumerate(LINK_PARENTS):
        joint = skeleton.parents[LINK_JOINTS[link]]
        while joint >= 0 and joint not in LINK_JOINTS:
            joint = skeleton.parents[joint]
        assert joint == (LINK_JOINTS[parent] if parent >= 0 else -1)


def test_the_library_reads_the_same_pose(rng):
    """`kinesics.poses` of any posture gives the quaternions that the performer says it has."""
    angles = STANDING + 0.4 * rng.standard_normal((40, len(ANGLES)))
    motion = kx.Motion(Body().skeleton, joint_rotations(angles), np.zeros((40, 3)), 30.0)
    dots = np.abs(np.sum(kx.poses(motion).quaternions * pose(angles), axis=-1))
    np.testing.assert_allclose(dots, 1.0, atol=1e-12)


def test_the_t_pose_is_the_identity():
    """With all angles zero every link is at its identity, arms along x, palms down."""
    np.testing.assert_allclose(pose(T_POSE), np.tile([1.0, 0, 0, 0], (15, 1)), atol=1e-15)
    hand, elbow = place(T_POSE, "LeftHand"), place(T_POSE, "LeftForeArm")
    assert hand[0] > elbow[0] > 0
    np.testing.assert_allclose(hand[1:], elbow[1:], atol=1e-12)


def test_mirrored_angles_are_the_mirrored_pose(rng):
    """Mirroring angles is W on quaternions: left and right swapped, y and z negated, to rounding."""
    angles = STANDING + 0.7 * rng.standard_normal((60, len(ANGLES)))
    wanted = pose(angles)[:, list(MIRROR_LINKS)] * [1, 1, -1, -1]
    dots = np.abs(np.sum(pose(mirror(angles)) * wanted, axis=-1))
    np.testing.assert_allclose(dots, 1.0, atol=1e-14)
    np.testing.assert_array_equal(mirror(mirror(angles)), angles)


@pytest.mark.parametrize(
    ("angle", "joint", "axis", "sign"),
    [
        ("hip_flex", "LeftFoot", 2, 1),
        ("hip_flex", "RightFoot", 2, 1),
        ("knee", "LeftFoot", 2, -1),
        ("left_hip_abduct", "LeftFoot", 0, 1),
        ("right_hip_abduct", "RightFoot", 0, -1),
        ("elbow", "LeftHand", 2, 1),
        ("shoulder_flex", "RightHand", 2, 1),
        ("shoulder_elevate", "LeftHand", 1, 1),
        ("trunk_bend", "Head", 2, 1),
        ("trunk_lean", "Head", 0, -1),
        ("trunk_twist", "LeftArm", 2, -1),
    ],
)
def test_angles_turn_the_way_their_names_say(angle, joint, axis, sign):
    """A positive angle moves the limb in the anatomical direction: flexion forward, knees back, abduction outward."""
    hanging = posture(shoulder_elevate=-80)
    moved = place(posture(hanging, **{angle: 30}), joint) - place(hanging, joint)
    assert sign * moved[axis] > 0.05


def test_unknown_angles_are_refused_with_the_known():
    """A misspelt angle lists the angles there are."""
    with pytest.raises(InputError, match=r"no angle 'knees'.*left_knee"):
        posture(knees=3)


def test_one_name_can_mean_several_entries():
    """`knee` is both knees, `trunk_bend` is spread over three links."""
    both = posture(knee=30, trunk_bend=30)
    assert both[ANGLE["left_knee"]] == both[ANGLE["right_knee"]] == pytest.approx(np.deg2rad(30))
    assert both[ANGLE["upperback_bend"]] == pytest.approx(np.deg2rad(10))
