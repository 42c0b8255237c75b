"""Legs that reach: targets met, nothing changed where nothing is asked, the mirror and the turn laws, a slow twin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics as kx
from kinesics import compiled
from kinesics.body import anatomy, kinematics
from kinesics.body.mirroring import mirror
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError, SkeletonError
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import inverse_kinematics as ik
from naive import inverse_kinematics as naive


def _walk(**conditions):
    return anatomy.understood(kx.performer.walk(seconds=3, fps=30, **conditions).motion)


WALK = _walk()
LEGS = ik.legs(WALK.skeleton)


def _at(motion):
    return kinematics.forward(motion.skeleton, motion.rotations, motion.root_positions)


def test_nothing_changes_where_nothing_is_asked() -> None:
    """A target where the ankle is leaves every rotation as it was, also of straight knees."""
    for motion in (WALK, anatomy.understood(kx.performer.stand(seconds=1, fps=30).motion)):
        legs = ik.legs(motion.skeleton)
        found = ik.reach(
            motion.skeleton, motion.rotations, motion.root_positions, _at(motion).positions[:, list(legs.feet)]
        )
        assert np.allclose(quaternion.angle(found.rotations, motion.rotations), 0.0, atol=1e-7)
        assert np.allclose(found.misses, 0.0, atol=1e-12)


@given(st.integers(0, 10_000))
def test_targets_within_reach_are_met_and_feet_keep_their_orientation(seed: int) -> None:
    """The ankle comes to its target to a nanometre, and the foot is turned in the world as it was."""
    rng = np.random.default_rng(seed)
    known = _at(WALK)
    hips, ankles = known.positions[:, list(LEGS.femurs)], known.positions[:, list(LEGS.feet)]
    away = ankles - hips + rng.uniform(-0.1, 0.1, ankles.shape)
    most = 0.98 * 0.491 * 1.75
    away *= np.minimum(1.0, most / np.linalg.norm(away, axis=-1, keepdims=True))
    found = ik.reach(WALK.skeleton, WALK.rotations, WALK.root_positions, hips + away)
    after = kinematics.forward(WALK.skeleton, found.rotations, WALK.root_positions)
    assert np.abs(after.positions[:, list(LEGS.feet)] - hips - away).max() < 1e-9
    assert quaternion.angle(after.rotations[:, list(LEGS.feet)], known.rotations[:, list(LEGS.feet)]).max() < 1e-6
    others = np.setdiff1d(np.arange(WALK.skeleton.joint_count), [*LEGS.femurs, *LEGS.tibias, *LEGS.feet])
    assert np.array_equal(found.rotations[:, others], WALK.rotations[:, others])


def test_bends_like_the_twin() -> None:
    """Knee and ankle come where bisection of the knee's angle about its hinge puts them."""
    rng = np.random.default_rng(4)
    known = _at(WALK)
    targets = (
        known.positions[:, list(LEGS.feet)] + rng.uniform(-0.08, 0.04, (len(WALK), 2, 3)) + np.array([0.0, 0.06, 0.0])
    )
    found = ik.reach(WALK.skeleton, WALK.rotations, WALK.root_positions, targets)
    after = kinematics.forward(WALK.skeleton, found.rotations, WALK.root_positions).positions
    for t in (0, 17, 40):
        for k in (0, 1):
            hinge = quaternion.rotate(known.rotations[t, LEGS.tibias[k]], LEGS.hinges[k])
            joints = [known.positions[t, j[k]] for j in (LEGS.femurs, LEGS.tibias, LEGS.feet)]
            knee, ankle = naive.reach(*joints, targets[t, k], hinge)
            assert np.allclose(after[t, LEGS.tibias[k]], knee, atol=1e-6)
            assert np.allclose(after[t, LEGS.feet[k]], ankle, atol=1e-6)


@given(st.integers(0, 10_000))
def test_compiled_and_plain_agree(seed: int) -> None:
    """Legs reach alike compiled and in NumPy: near, far beyond, and where nothing is asked."""
    if compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    rng = np.random.default_rng(seed)
    targets = _at(WALK).positions[:, list(LEGS.feet)]
    targets = targets + rng.choice([0.0, 0.01, 0.1, 3.0], targets.shape[:2])[..., None] * rng.normal(size=targets.shape)
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("KINESICS_KERNEL", raising=False)
        patch.setenv("KINESICS_NO_NATIVE", "0")
        quick = ik.reach(WALK.skeleton, WALK.rotations, WALK.root_positions, targets)
        patch.setenv("KINESICS_NO_NATIVE", "1")
        plain = ik.reach(WALK.skeleton, WALK.rotations, WALK.root_positions, targets)
    np.testing.assert_allclose(quick.rotations, plain.rotations, atol=1e-7)
    np.testing.assert_allclose(quick.misses, plain.misses, atol=1e-9)


@given(st.integers(0, 10_000))
def test_one_leg_turns_as_many_do(seed: int) -> None:
    """One leg at one moment, live, turns as among all frames: within reach, beyond it, straight, and bent backwards."""
    rng = np.random.default_rng(seed)
    n = 20
    hinge, v = rng.normal(size=(2, n, 3))
    hinge /= np.linalg.norm(hinge, axis=-1, keepdims=True)
    hip = rng.normal(size=(n, 3))
    knee = hip + rng.uniform(0.3, 0.5, (n, 1)) * v / np.linalg.norm(v, axis=-1, keepdims=True)
    bent = quaternion.from_axis_angle(hinge, rng.choice([0.0, 0.001, -0.1, -0.5, 0.3, 1.5], n))
    ankle = knee + rng.uniform(0.8, 1.2, (n, 1)) * quaternion.rotate(bent, knee - hip)
    target = ankle + rng.choice([0.0, 0.01, 0.2, 2.0], (n, 1)) * rng.normal(size=(n, 3))
    bends, swings, _ = ik._bend_and_swing(hip, knee, ankle, target, hinge)
    for k in range(n):
        one = ik.turns(*(tuple(v[k].tolist()) for v in (hip, knee, ankle, target, hinge)))
        assert quaternion.angle(bends[k], one[0]) < 1e-6
        assert quaternion.angle(swings[k], one[1]) < 1e-6


def test_a_bone_along_its_hinge_is_only_swung() -> None:
    """Where the shin lies along the knee's axis no turn about it changes the distance: the leg swings, no number is spoilt."""
    bend, swing = ik.turns((0.0, 1.0, 0.0), (0.0, 0.5, 0.0), (0.5, 0.5, 0.0), (0.0, 0.6, 0.3), (1.0, 0.0, 0.0))
    assert bend == (1.0, 0.0, 0.0, 0.0)
    assert np.isfinite(swing).all()
    many = (
        np.array([v]) for v in ((0.0, 1.0, 0.0), (0.0, 0.5, 0.0), (0.5, 0.5, 0.0), (0.0, 0.6, 0.3), (1.0, 0.0, 0.0))
    )
    bends, swings, _ = ik._bend_and_swing(*many)
    assert np.allclose(bends[0], bend)
    assert np.allclose(swings[0], swing)


def test_the_knee_turns_about_its_hinge_alone() -> None:
    """Whatever is asked, the knee's rotation changes by a turn about its own hinge."""
    known = _at(WALK)
    found = ik.reach(WALK.skeleton, WALK.rotations, WALK.root_positions, known.positions[:, list(LEGS.feet)] + 0.05)
    for j, hinge in zip(LEGS.tibias, LEGS.hinges, strict=True):
        change = quaternion.as_rotvec(
            quaternion.multiply(quaternion.conjugate(WALK.rotations[:, j]), found.rotations[:, j])
        )
        assert np.abs(change).max() > 0.02
        assert np.linalg.norm(change - (change @ hinge)[:, None] * hinge, axis=-1).max() < 1e-9


def test_out_of_reach_is_softly_given_up() -> None:
    """A target that moves away without end is followed ever less, never beyond the straight leg, and without a leap."""
    still = anatomy.understood(kx.performer.stand(seconds=1, fps=30).motion[:1])
    legs = ik.legs(still.skeleton)
    n = 200
    motion = still.replace(
        rotations=np.repeat(still.rotations, n, axis=0), root_positions=np.repeat(still.root_positions, n, axis=0)
    )
    targets = np.repeat(_at(still).positions[:, list(legs.feet)], n, axis=0)
    targets[..., 1] += np.linspace(0.15, -0.4, n)[:, None]
    found = ik.reach(motion.skeleton, motion.rotations, motion.root_positions, targets)
    after = kinematics.forward(motion.skeleton, found.rotations, motion.root_positions).positions
    far = np.linalg.norm(after[:, list(legs.feet)] - after[:, list(legs.femurs)], axis=-1)
    assert np.all(np.diff(far, axis=0) > -1e-9)
    assert far.max() < 0.491 * 1.75 * 1.0000001
    knees = quaternion.angle(found.rotations[1:, list(legs.tibias)], found.rotations[:-1, list(legs.tibias)])
    assert knees.max() < np.deg2rad(6.0)
    assert found.misses[-1].min() > 0.3
    assert np.allclose(found.misses[:40], 0.0, atol=1e-9)


def test_mirror_law() -> None:
    """The mirror image of what reaches is what reaches in the mirror."""
    targets = _at(WALK).positions[:, list(LEGS.feet)] + np.array([[0.03, 0.05, 0.02], [-0.01, 0.04, -0.05]])
    found = ik.reach(WALK.skeleton, WALK.rotations, WALK.root_positions, targets)
    there = mirror(WALK.replace(rotations=found.rotations))
    image = mirror(WALK)
    flipped = targets[:, ::-1] * np.array([-1.0, 1.0, 1.0])
    back = ik.reach(image.skeleton, image.rotations, image.root_positions, flipped)
    assert np.allclose(quaternion.angle(back.rotations, there.rotations), 0.0, atol=1e-6)


@given(st.floats(-3.0, 3.0), st.floats(-5.0, 5.0))
def test_turning_the_world_changes_nothing(yaw: float, far: float) -> None:
    """Body and targets turned and shifted together give the same joint rotations, the root's aside."""
    targets = _at(WALK).positions[:, list(LEGS.feet)] + 0.04
    found = ik.reach(WALK.skeleton, WALK.rotations, WALK.root_positions, targets)
    turn = quaternion.from_axis_angle([0.0, 1.0, 0.0], yaw)
    rotations = WALK.rotations.copy()
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    moved = quaternion.rotate(turn, WALK.root_positions) + far
    other = ik.reach(WALK.skeleton, rotations, moved, quaternion.rotate(turn, targets) + far)
    assert quaternion.angle(other.rotations[:, 1:], found.rotations[:, 1:]).max() < 1e-6


def test_joints_between_are_carried_along() -> None:
    """A twist joint in the thigh stays as it is and the ankle still comes to its target."""
    old = WALK.skeleton
    femur, tibia = LEGS.femurs[0], LEGS.tibias[0]
    shift = lambda j: j + (j > femur)  # noqa: E731
    names = [*old.joint_names[: femur + 1], "LeftUpLegRoll", *old.joint_names[femur + 1 :]]
    parents = [shift(p) if p >= 0 else -1 for p in old.parents]
    parents = [*parents[: femur + 1], femur, *parents[femur + 1 :]]
    offsets = np.insert(old.offsets, femur + 1, old.offsets[tibia] / 2, axis=0)
    parents[shift(tibia)], offsets[shift(tibia)] = femur + 1, old.offsets[tibia] / 2
    skeleton = Skeleton(tuple(names), tuple(parents), offsets)
    roll = quaternion.from_axis_angle([0.0, 1.0, 0.0], np.full(len(WALK), 0.2))
    rotations = np.insert(WALK.rotations, femur + 1, roll, axis=1)
    motion = anatomy.understood(kx.Motion(skeleton, rotations, WALK.root_positions, 30.0))
    legs = ik.legs(motion.skeleton)
    targets = _at(motion).positions[:, list(legs.feet)] + np.array([0.02, 0.06, 0.01])
    found = ik.reach(motion.skeleton, motion.rotations, motion.root_positions, targets)
    after = kinematics.forward(motion.skeleton, found.rotations, motion.root_positions).positions
    assert np.abs(after[:, list(legs.feet)] - targets).max() < 1e-9
    assert np.allclose(quaternion.angle(found.rotations[:, femur + 1], roll), 0.0, atol=1e-7)


def test_the_hinge_is_found_in_the_recording() -> None:
    """A knee that turns about a slanting axis in the recording has that axis for its hinge."""
    j = LEGS.tibias[0]
    slant = np.array([0.94, 0.34, 0.0]) / np.linalg.norm([0.94, 0.34, 0.0])
    rotations = WALK.rotations.copy()
    rotations[:, j] = quaternion.from_axis_angle(np.tile(slant, (len(WALK), 1)), np.linspace(0.1, 1.2, len(WALK)))
    assert np.allclose(ik.legs(WALK.skeleton, rotations).hinges[0], slant, atol=1e-6)


def test_bad_input_is_told() -> None:
    """Targets of the wrong shape, and skeletons without anatomy or ankles, are refused in words."""
    with pytest.raises(InputError, match="targets"):
        ik.reach(WALK.skeleton, WALK.rotations, WALK.root_positions, np.zeros((3, 2, 3)))
    with pytest.raises(SkeletonError, match="anatomy"):
        ik.legs(kx.performer.Body().skeleton)
