"""Forward kinematics, compiled and in NumPy, against products of 4×4 matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinesics import compiled
from kinesics.body import kinematics
from kinesics.body.motion import Motion
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from naive import kinematics as naive


@pytest.fixture(params=["compiled", "numpy"])
def way(request, monkeypatch):
    """Each way forced in turn."""
    if request.param == "compiled" and compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    monkeypatch.delenv("KINESICS_KERNEL", raising=False)
    monkeypatch.setenv("KINESICS_NO_NATIVE", "1" if request.param == "numpy" else "0")
    return request.param


def random_tree(rng, joints):
    parents = (-1, *(int(rng.integers(0, j)) for j in range(1, joints)))
    return Skeleton(tuple(f"joint{j}" for j in range(joints)), parents, rng.normal(size=(joints, 3)))


def random_rotations(rng, frames, joints):
    return quaternion.normalize(rng.normal(size=(frames, joints, 4)))


def assert_matches(where, expected):
    np.testing.assert_allclose(where.positions, expected[:, :, :3, 3], atol=1e-12)
    np.testing.assert_allclose(quaternion.as_matrix(where.rotations), expected[:, :, :3, :3], atol=1e-12)


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize(("frames", "joints"), [(1, 1), (1, 40), (7, 5), (40, 23)])
def test_matches_the_twin(rng, way, frames, joints, moving):
    """Positions and orientations are those of the chain of matrices, with fixed and with moving joints."""
    skeleton = random_tree(rng, joints)
    rotations, roots = random_rotations(rng, frames, joints), rng.normal(size=(frames, 3))
    shifts = rng.normal(size=(frames, joints, 3)) if moving else None
    expected = naive.forward(skeleton.parents, skeleton.offsets, rotations, roots, shifts)
    assert_matches(kinematics.forward(skeleton, rotations, roots, shifts), expected)
    np.testing.assert_allclose(
        kinematics.positions(skeleton, rotations, roots, shifts), expected[:, :, :3, 3], atol=1e-12
    )
    np.testing.assert_allclose(
        quaternion.as_matrix(kinematics.global_rotations(skeleton, rotations)), expected[:, :, :3, :3], atol=1e-12
    )


def test_of_some_joints(rng, way):
    """Joints that are asked for, and all they hang on, are where they are among all; the others are not told."""
    skeleton = random_tree(rng, 30)
    rotations, roots = random_rotations(rng, 20, 30), rng.normal(size=(20, 3))
    joints = np.array([29, 11, 17])
    told = {0}
    for joint in joints.tolist():
        while joint > 0:
            told.add(joint)
            joint = skeleton.parents[joint]
    hers, others = sorted(told), sorted(set(range(30)) - told)
    whole, some = (kinematics.forward(skeleton, rotations, roots, joints=j) for j in (None, joints))
    where = kinematics.positions(skeleton, rotations, roots, joints=joints)
    turned = kinematics.global_rotations(skeleton, rotations, joints=joints)
    for all_of_them, found in zip((*whole, *whole), (*some, where, turned), strict=True):
        np.testing.assert_array_equal(found[:, hers], all_of_them[:, hers])
        assert np.isnan(found[:, others]).all()
    assert others
    for bad in (30, -1):
        with pytest.raises(InputError, match="below 30"):
            kinematics.forward(skeleton, rotations, roots, joints=np.array([3, bad]))


@given(seed=st.integers(0, 2**32 - 1), frames=st.integers(1, 3000), joints=st.integers(1, 30))
def test_both_ways_agree(seed, frames, joints):
    """Compiled, on one thread or several, and in NumPy: the same for any tree and length."""
    if compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    rng = np.random.default_rng(seed)
    skeleton = random_tree(rng, joints)
    rotations, roots = random_rotations(rng, frames, joints), rng.normal(size=(frames, 3))
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("KINESICS_KERNEL", raising=False)
        patch.setenv("KINESICS_NO_NATIVE", "0")
        quick = kinematics.forward(skeleton, rotations, roots)
        patch.setenv("KINESICS_NO_NATIVE", "1")
        plain = kinematics.forward(skeleton, rotations, roots)
    np.testing.assert_allclose(quick.positions, plain.positions, atol=1e-11)
    np.testing.assert_allclose(quick.rotations, plain.rotations, atol=1e-13)


def test_rest_is_the_skeleton(rng, way):
    """With no rotation every joint lies where the offsets put it."""
    skeleton = random_tree(rng, 12)
    where = kinematics.positions(skeleton, quaternion.identity((3, 12)), np.zeros((3, 3)))
    np.testing.assert_allclose(where, np.broadcast_to(skeleton.rest_positions, (3, 12, 3)), atol=1e-15)


def test_bones_keep_their_length(rng, way):
    """However the joints turn, the distance from parent to child is the length of the offset."""
    skeleton = random_tree(rng, 20)
    where = kinematics.positions(skeleton, random_rotations(rng, 50, 20), rng.normal(size=(50, 3)))
    for joint, parent in enumerate(skeleton.parents[1:], start=1):
        lengths = np.linalg.norm(where[:, joint] - where[:, parent], axis=-1)
        np.testing.assert_allclose(lengths, np.linalg.norm(skeleton.offsets[joint]), atol=1e-12)


def test_a_motion_and_its_strided_parts(rng, way):
    """A motion's own positions, and those of arrays that are not contiguous or are read-only."""
    skeleton = random_tree(rng, 6)
    rotations, roots = random_rotations(rng, 20, 6), rng.normal(size=(20, 3))
    motion = Motion(skeleton=skeleton, rotations=rotations, root_positions=roots, fps=30.0)
    whole = kinematics.forward(skeleton, rotations, roots)
    np.testing.assert_array_equal(motion.positions(), whole.positions)
    np.testing.assert_array_equal(motion.global_rotations(), whole.rotations)
    every_third = kinematics.forward(skeleton, rotations[::3], roots[::3])
    np.testing.assert_array_equal(every_third.positions, whole.positions[::3])
    rotations.setflags(write=False)
    np.testing.assert_array_equal(kinematics.positions(skeleton, rotations, roots), whole.positions)


def test_refuses_shapes_that_disagree(rng):
    """The message names the array, what was expected and what came."""
    skeleton = random_tree(rng, 4)
    rotations, roots = random_rotations(rng, 5, 4), np.zeros((5, 3))
    with pytest.raises(InputError, match=r"`rotations` of shape \(frames, 4, 4\), got \(5, 3, 4\)"):
        kinematics.forward(skeleton, rotations[:, :3], roots)
    with pytest.raises(InputError, match=r"`root_positions` of shape \(5, 3\), got \(4, 3\)"):
        kinematics.positions(skeleton, rotations, roots[:4])
    with pytest.raises(InputError, match=r"`joint_translations` of shape \(5, 4, 3\)"):
        kinematics.forward(skeleton, rotations, roots, np.zeros((5, 3, 3)))
    with pytest.raises(InputError, match="`rotations`"):
        kinematics.global_rotations(skeleton, rotations[0])
