"""The mirror image on the body it was taken from: bones point where the mirror shows them, also where they lean to one side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import bodies
import kinesics as kx
from kinesics.body import anatomy
from kinesics.body.mirroring import partners, with_bones_of
from kinesics.body.motion import Motion
from kinesics.body.retargeting import retarget
from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.geometry import quaternion
from naive import retargeting as naive

Array = NDArray[np.float64]


def leaning(spine: float, neck: float, crown: float) -> Skeleton:
    """The human figure whose bones of the midline lean to the left, metres."""
    human = bodies.human()
    offsets = human.offsets.copy()
    offsets[human.find("Chest"), 0], offsets[human.find("Head"), 0] = spine, neck
    head = human.find("Head")
    sites = tuple(EndSite(s.parent, (crown, 0.2, 0.0)) if s.parent == head else s for s in human.end_sites)
    return human.replace(offsets=offsets, end_sites=sites)


def moving(skeleton: Skeleton, seed: int) -> Motion:
    """A walk in which the trunk bends to all sides."""
    rng = np.random.default_rng(seed)
    walk = bodies.legs_striding(20)
    rotations = walk.rotations.copy()
    for name in ("Hips", "Spine", "Chest", "Neck", "Head"):
        rotations[:, skeleton.find(name)] = quaternion.from_rotvec(rng.normal(scale=0.3, size=(20, 3)))
    return anatomy.understood(walk.replace(skeleton=skeleton, rotations=rotations))


def image_of(motion: Motion) -> Motion:
    """The mirror image, by the same body."""
    seen = kx.mirror(motion)
    return with_bones_of(retarget(seen, motion.skeleton), seen)


def crown(motion: Motion) -> Array:
    """From the head's joint to its tip, in the world."""
    head = motion.skeleton.find("Head")
    (tip,) = (site.offset for site in motion.skeleton.end_sites if site.parent == head)
    return quaternion.rotate(motion.global_rotations()[:, head], np.array(tip))


leans = st.floats(-0.05, 0.05)


@given(spine=leans, neck=leans, tip=leans, seed=st.integers(0, 99))
def test_a_leaning_body_bends_as_its_mirror_image_does(spine: float, neck: float, tip: float, seed: int) -> None:
    """All joints are where bones of the same lengths put them that point as in the mirror; so is the crown of the head."""
    motion = moving(leaning(spine, neck, tip), seed)
    image = image_of(motion)
    skeleton = motion.skeleton
    expected = naive.mirrored_bones(
        motion.positions(), skeleton.parents, partners(skeleton), np.linalg.norm(skeleton.offsets, axis=1)
    )
    found = image.positions()
    np.testing.assert_allclose(found - found[:, :1], expected, atol=1e-9)
    np.testing.assert_allclose(crown(image), crown(motion) * [-1.0, 1.0, 1.0], atol=1e-9)


@given(spine=leans, neck=leans, tip=leans, seed=st.integers(0, 99))
def test_mirrored_twice_is_as_it_was(spine: float, neck: float, tip: float, seed: int) -> None:
    """What turned the bones is undone by the second image."""
    motion = moving(leaning(spine, neck, tip), seed)
    twice = image_of(image_of(motion))
    assert quaternion.angle(twice.rotations, motion.rotations).max() < 1e-7


def test_an_upright_body_and_all_limbs_are_left_as_they_are() -> None:
    """Nothing turns where bones do not lean; and a shorter thigh, a longer foot or a foot that points outwards turns nothing."""
    skeleton = bodies.human()
    sites = list(skeleton.end_sites)
    sites[-1] = EndSite(sites[-1].parent, (0.05, -0.08, 0.19))
    offsets = skeleton.offsets.copy()
    offsets[skeleton.find("LeftLeg"), 1] *= 0.9
    for body in (skeleton, skeleton.replace(offsets=offsets, end_sites=tuple(sites))):
        motion = moving(body, 3)
        seen = kx.mirror(motion)
        plain = retarget(seen, motion.skeleton)
        assert quaternion.angle(with_bones_of(plain, seen).rotations, plain.rotations).max() < 1e-7


def test_where_bones_part_a_joint_keeps_its_orientation() -> None:
    """A chest whose neck leans, but whose arms do not, cannot do right by both: it stays as it is, and so does what it bears."""
    human = bodies.human()
    offsets = human.offsets.copy()
    offsets[human.find("Neck"), 0] = 0.04
    motion = moving(human.replace(offsets=offsets), 5)
    seen = kx.mirror(motion)
    plain = retarget(seen, motion.skeleton)
    assert quaternion.angle(with_bones_of(plain, seen).rotations, plain.rotations).max() < 1e-7


def bends(motion: Motion, joint: str) -> Array:
    """Degrees between the bone before a joint and the one after, in every frame."""
    skeleton, places = motion.skeleton, motion.positions()
    j = skeleton.find(joint)
    before, after = places[:, j] - places[:, skeleton.parents[j]], places[:, skeleton.children[j][0]] - places[:, j]
    cosine = np.sum(before * after, axis=1) / np.linalg.norm(before, axis=1) / np.linalg.norm(after, axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


@pytest.mark.parametrize("clip", ["07/07_01", "16/16_35", "91/91_01"])
def test_recorded_necks_bend_no_farther_in_the_mirror(shared_data: Path, clip: str) -> None:
    """Neck bones of these files lean by up to seven degrees: backs and necks bend in the image as they were recorded."""
    recorded = anatomy.understood(kx.read(shared_data / f"cmu/{clip}.amc")[::8])
    image = image_of(recorded)
    for joint in ("upperback", "thorax", "lowerneck", "upperneck"):
        np.testing.assert_allclose(bends(image, joint), bends(recorded, joint), atol=1e-3)


@pytest.mark.parametrize("clip", ["07/07_01", "16/16_35"])
def test_limbs_point_as_in_the_mirror_and_what_never_turns_does_not(shared_data: Path, clip: str) -> None:
    """Hips and collar bones of these files are rigid: they go along with the trunk; arms and legs keep their directions."""
    recorded = anatomy.understood(kx.read(shared_data / f"cmu/{clip}.amc")[::8])
    image, seen = image_of(recorded), kx.mirror(recorded)
    skeleton = recorded.skeleton
    for side in "lr":
        for joint in ("hipjoint", "clavicle"):
            assert quaternion.angle(image.rotations[:, skeleton.find(side + joint)]).max() < 1e-6
        for joint, end in (("humerus", "radius"), ("radius", "wrist"), ("femur", "tibia"), ("tibia", "foot")):
            a, b = skeleton.find(side + joint), skeleton.find(side + end)
            ours, theirs = (m.positions()[:, b] - m.positions()[:, a] for m in (image, seen))
            ours, theirs = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (ours, theirs))
            np.testing.assert_allclose(ours, theirs, atol=1e-6)
