"""The skeleton: what it refuses, by name, and what it knows of itself."""

from __future__ import annotations

import dataclasses
import pickle
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from kinesics.body.skeleton import EndSite, JointFreedom, Skeleton
from kinesics.errors import InputError
from kinesics.geometry import euler, quaternion

NAMES = ("hips", "left_knee", "right_knee", "chest")
PARENTS = (-1, 0, 0, 0)
OFFSETS = np.array([[0.0, 0.0, 0.0], [0.1, -0.4, 0.0], [-0.1, -0.5, 0.0], [0.0, 0.3, 0.02]])
PARTNER = (0, 2, 1, 3)


def build(**changes: Any) -> Skeleton:
    parts: dict[str, Any] = {"joint_names": NAMES, "parents": PARENTS, "offsets": OFFSETS}
    return Skeleton(**(parts | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"joint_names": (), "parents": (), "offsets": np.zeros((0, 3))}, "at least one joint"),
        ({"offsets": OFFSETS[:3]}, r"`offsets` of shape \(4, 3\), got \(3, 3\)"),
        ({"parents": (-1, 0, 0)}, "Expected 4 parents, got 3"),
        ({"parents": (0, 0, 0, 0)}, "first joint must be the root"),
        ({"parents": (-1, 0, 3, 0)}, r"'right_knee' \(number 2\) has parent 3"),
        ({"parents": (-1, 0, -1, 0)}, r"'right_knee' \(number 2\) has parent -1"),
        ({"joint_names": ("hips", "knee", "knee", "chest")}, "doubled: knee"),
        ({"freedoms": (JointFreedom(),)}, "Expected 4 freedoms, got 1"),
        ({"offsets": OFFSETS * 1e200}, r"offset of joint 'right_knee' is 5e\+199 m, beyond any length"),
        ({"end_sites": (EndSite(2, (0.0, 1e200, 0.0)),)}, "end site hangs on joint 2"),
        ({"end_sites": (EndSite(7, (0.0, 0.0, 0.0)),)}, "end site hangs on joint 7"),
        ({"end_sites": (EndSite(1, (0.0, float("nan"), 0.0)),)}, "end site hangs on joint 1"),
    ],
)
def test_each_fault_is_named(changes: dict[str, Any], message: str) -> None:
    """What breaks the tree is refused with the joint, what was expected and what came."""
    with pytest.raises(InputError, match=message):
        build(**changes)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_offset_that_is_not_finite_names_its_joint(bad: float) -> None:
    """The joint is in the message."""
    offsets = OFFSETS.copy()
    offsets[2, 1] = bad
    with pytest.raises(InputError, match="offset of joint 'right_knee' is not finite"):
        build(offsets=offsets)


def test_a_skeleton_does_not_change() -> None:
    """Neither its fields nor its offsets, nor by the array that it was made from."""
    source = OFFSETS.copy()
    skeleton = build(offsets=source)
    source[1] = 99.0
    assert_allclose(skeleton.offsets, OFFSETS)
    with pytest.raises(ValueError, match="read-only"):
        skeleton.offsets[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        skeleton.name = "other"


def test_tree_and_rest_positions() -> None:
    """Children by parent, positions summed along the chain, joints by name."""
    chain = build(parents=(-1, 0, 1, 2))
    assert chain.children == ((1,), (2,), (3,), ())
    assert_allclose(chain.rest_positions, np.cumsum(OFFSETS, axis=0))
    assert chain.find("chest") == 3
    with pytest.raises(InputError, match=r"No joint is called 'nose'\. Joints: hips, left_knee, right_knee, chest"):
        chain.find("nose")


def test_the_same_tree_may_have_other_lengths() -> None:
    """Names and parents count, lengths do not."""
    assert build().same_tree(build(offsets=OFFSETS * 2.0))
    assert not build().same_tree(build(parents=(-1, 0, 1, 0)))
    assert not build().same_tree(build(joint_names=("a", "b", "c", "d")))


def test_one_joint_is_a_skeleton() -> None:
    """The smallest body: a root."""
    one = Skeleton(("root",), (-1,), np.zeros((1, 3)))
    assert one.joint_count == 1
    assert one.children == ((),)
    assert one.freedoms[0].translation == "XYZ"


def test_crossing_a_process_border() -> None:
    """A skeleton survives pickling."""
    back = pickle.loads(pickle.dumps(build(end_sites=(EndSite(3, (0.0, 0.1, 0.0)),))))
    assert back.same_tree(build())
    assert_allclose(back.offsets, OFFSETS)


def test_the_mirror_swaps_sides_and_reflects() -> None:
    """Left takes the right's length with x negated; the end sites go with their joints; twice is nothing."""
    sites = (EndSite(1, (0.01, -0.3, 0.1)), EndSite(2, (-0.02, -0.35, 0.12)), EndSite(3, (0.03, 0.2, 0.0)))
    skeleton = build(end_sites=sites)
    mirrored = skeleton.mirror(PARTNER)
    assert_allclose(mirrored.offsets[1], [0.1, -0.5, 0.0])
    assert_allclose(mirrored.offsets[2], [-0.1, -0.4, 0.0])
    assert_allclose(mirrored.offsets[3], [0.0, 0.3, 0.02])
    assert {s.parent: s.offset for s in mirrored.end_sites} == {
        1: (0.02, -0.35, 0.12),
        2: (-0.01, -0.3, 0.1),
        3: (-0.03, 0.2, 0.0),
    }
    again = mirrored.mirror(PARTNER)
    assert_allclose(again.offsets, skeleton.offsets)
    assert {s.parent: s.offset for s in again.end_sites} == {s.parent: s.offset for s in sites}


def test_the_mirror_of_limits(rng: np.random.Generator) -> None:
    """A rotation within a joint's limits, mirrored, is within the mirrored joint's limits, at the same angles' sizes."""
    limits = ((-0.2, 1.0), (-0.3, 0.9), (-1.1, 0.1))
    axis = quaternion.normalize(rng.normal(size=4))
    freedom = JointFreedom(order="ZYX", axis=tuple(axis), limits=limits)
    mirrored = build(freedoms=(JointFreedom(), freedom, JointFreedom(), JointFreedom())).mirror(PARTNER).freedoms[2]
    low, high = np.array(limits).T
    angles = rng.uniform(low, high)
    inner = euler.from_fick(angles)
    local = quaternion.multiply(quaternion.multiply(axis, inner), quaternion.conjugate(axis))
    image = quaternion.mirror(local)
    frame = np.array(mirrored.axis)
    unturned = quaternion.multiply(quaternion.multiply(quaternion.conjugate(frame), image), frame)
    found = euler.as_fick(unturned).angles
    assert_allclose(found, angles * [1.0, -1.0, -1.0], atol=1e-12)
    new_low, new_high = np.array(mirrored.limits).T
    assert np.all((new_low <= found) & (found <= new_high))
