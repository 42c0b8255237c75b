"""Real rigs without telling names, with z up, and with axes of any direction, read as the same poses."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinesics as kx
from kinesics.body import anatomy, conventions
from kinesics.geometry import quaternion

RIGS = [
    "cmu/07/07_01.amc",
    "cmu/13/13_29.amc",
    "cmu/49/49_08.amc",
    "cmu/bvh/cgspeed_02_01.bvh",
    "cmu/bvh/135_01_bassai_30fps.bvh",
]


def sample(path: Path) -> kx.Motion:
    motion = kx.read(path)
    return motion[:: max(1, motion.frame_count // 300)]


def nameless(motion: kx.Motion) -> kx.Motion:
    names = tuple(f"B{j:02d}" for j in range(motion.skeleton.joint_count))
    return motion.replace(skeleton=motion.skeleton.replace(joint_names=names, anatomy=None))


def difference(a: kx.Motion, b: kx.Motion) -> float:
    return float(quaternion.angle(kx.poses(a).quaternions, kx.poses(b).quaternions).max())


@pytest.mark.parametrize("rig", RIGS)
def test_a_real_rig_without_names_reads_the_same(rig: str, shared_data: Path) -> None:
    """Collar bones are not taken for arms nor left for right: the poses are those of the named file."""
    motion = sample(shared_data / rig)
    assert difference(nameless(motion), motion) < 1e-6


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("role", ["right_femur", "left_radius", "head"])
def test_one_joint_that_is_named_otherwise_is_found_by_shape(rig: str, role: str, shared_data: Path) -> None:
    """The other names and the shape agree, so the poses are those of the named file; that the shape told is stated."""
    motion = sample(shared_data / rig)
    names = list(motion.skeleton.joint_names)
    names[getattr(anatomy.resolve(motion).roles, role)] = "Foo"
    renamed = motion.replace(skeleton=motion.skeleton.replace(joint_names=tuple(names), anatomy=None))
    assert difference(renamed, motion) < 1e-6
    assert any("shape" in a for a in anatomy.resolve(renamed).assumptions)


@pytest.mark.parametrize("rig", RIGS)
def test_z_up_is_told_with_and_without_names(rig: str, shared_data: Path) -> None:
    """A world with z up is told by the body, even in a cartwheel and where names tell nothing."""
    motion = sample(shared_data / rig)
    back = quaternion.conjugate(conventions.to_y_up("z"))
    positions = quaternion.rotate(back, motion.positions())
    for body in (motion.skeleton, nameless(motion).skeleton):
        assert conventions.detect(body, positions).up_axis == "z"
        assert conventions.detect(body, motion.positions()).up_axis == "y"


@pytest.mark.parametrize("rig", RIGS)
def test_axes_of_any_direction_leave_poses_nearly_alone(rig: str, shared_data: Path, rng: np.random.Generator) -> None:
    """A rig whose joints rest in frames of any direction: the same movement, the mirror distance hardly changed."""
    motion = sample(shared_data / rig)
    body = motion.skeleton
    turns = quaternion.normalize(rng.normal(size=(body.joint_count, 4)))
    parents = np.array(body.parents)
    above = np.where(parents[:, None] < 0, quaternion.identity((1,)), turns[parents])
    sites = tuple(
        dataclasses.replace(
            s, offset=tuple(quaternion.rotate(quaternion.conjugate(turns[s.parent]), s.offset).tolist())
        )
        for s in body.end_sites
    )
    other = motion.replace(
        skeleton=body.replace(
            offsets=quaternion.rotate(quaternion.conjugate(above), body.offsets), end_sites=sites, anatomy=None
        ),
        rotations=quaternion.multiply(quaternion.multiply(quaternion.conjugate(above), motion.rotations), turns),
    )
    np.testing.assert_allclose(other.positions(), motion.positions(), atol=1e-9)

    def asymmetry(m: kx.Motion) -> NDArray[np.float64]:
        p = kx.poses(m)
        return np.diagonal(kx.mirror_distance(p, p)).astype(np.float64)

    assert float(np.mean(asymmetry(other))) < float(np.mean(asymmetry(motion))) + 0.012


def test_the_facing_of_the_rest_pose_is_stated_and_can_be_said(shared_data: Path) -> None:
    """What the rest pose faces is among the assumptions; a mapping may say otherwise, and nonsense is refused."""
    path = shared_data / "cmu/07/07_01.amc"
    assert any("faces +z" in text for text in kx.read(path).assumptions)
    turned = kx.read(path, mapping={"facing": "-x"})
    assert any("faces -x (as the mapping says)" in text for text in turned.assumptions)
    with pytest.raises(kx.InputError, match="north"):
        kx.read(path, mapping={"facing": "north"})
    with pytest.raises(kx.InputError, match="up or down"):
        kx.read(path, mapping={"facing": "+y"})
