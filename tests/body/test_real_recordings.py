"""What must hold on every real recording: the mirror law, agreement of formats, bodies at ease that are symmetric."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinesics as kx
from kinesics.body import anatomy, mirroring, pose
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

AT_EASE = ("13_29", "13_30", "14_06", "86_01", "91_01", "91_34", "135_02", "135_11")
"""CMU recordings in which the subject stands at ease at some moment."""


def pair_distance(a: Array, b: Array) -> Array:
    """D frame by frame, from the definition. Shapes (frames, 15, 4) to (frames,)."""
    dots = np.abs(np.sum(a * b, axis=-1))
    cos = np.sum(pose.gravity(a) * pose.gravity(b), axis=-1)
    dots[:, 0] = np.sqrt(np.maximum(0.0, (1 + cos) / 2))
    return np.asarray(1 - dots.mean(axis=-1))


def recordings(shared: Path) -> list[Path]:
    return sorted([*shared.glob("cmu/*/*.amc"), *shared.glob("cmu/bvh/*.bvh")])


def bandai_clips(shared: Path, folder: Path, wanted: str, step: int = 1) -> Iterator[kx.Motion]:
    with zipfile.ZipFile(shared / "bandai-namco" / "clips.zip") as archive:
        for name in sorted(n for n in archive.namelist() if wanted in n)[::step]:
            target = folder / name
            target.write_bytes(archive.read(name))
            yield kx.read(target)
            target.unlink()


def check_mirror_law(motion: kx.Motion) -> None:
    """Both halves of the law, to 1e-6; and the frames found anew from the mirrored body obey it too."""
    image = kx.mirror(motion)
    partner = list(mirroring.partners(motion.skeleton, anatomy.resolve(motion).roles))
    assert sorted(partner) == list(range(motion.skeleton.joint_count))
    np.testing.assert_allclose(image.positions(), motion.positions()[:, partner] * [-1, 1, 1], atol=1e-6)
    expected = pose.mirror(kx.poses(motion).quaternions)
    assert quaternion.angle(kx.poses(image).quaternions, expected).max() < 1e-6
    anew = image.replace(skeleton=image.skeleton.replace(anatomy=None))
    assert quaternion.angle(kx.poses(anew).quaternions, expected).max() < 1e-6


def test_the_mirror_law_on_every_cmu_recording(shared_data: Path) -> None:
    """Every AMC and BVH of the CMU database obeys the mirror law."""
    files = recordings(shared_data)
    assert len(files) >= 20
    for file in files:
        motion = kx.read(file)
        check_mirror_law(motion[:: max(1, motion.frame_count // 400)])


def test_the_mirror_law_on_bandai_namco(shared_data: Path, tmp_path: Path) -> None:
    """A rig whose zero pose is no human pose obeys the mirror law."""
    checked = 0
    for motion in bandai_clips(shared_data, tmp_path, ".bvh", step=23):
        check_mirror_law(motion)
        checked += 1
    assert checked > 30


@pytest.mark.long
def test_the_mirror_law_on_all_of_bandai_namco(shared_data: Path, tmp_path: Path) -> None:
    """All 774 clips obey the mirror law, with one frame for each joint whatever the clip."""
    for motion in bandai_clips(shared_data, tmp_path, ".bvh"):
        check_mirror_law(motion)


@pytest.mark.parametrize("clip", AT_EASE)
def test_a_subject_at_ease_is_symmetric(clip: str, shared_data: Path) -> None:
    """D*(a, a) falls below .005 where a subject stands at ease."""
    q = kx.poses(kx.read(shared_data / "cmu" / clip.split("_")[0] / f"{clip}.amc")).quaternions
    assert pair_distance(q, pose.mirror(q)).min() < 0.005


def test_one_motion_in_two_formats(shared_data: Path) -> None:
    """135_02 as BVH and as ASF/AMC: the same joint positions, and the same poses frame by frame."""
    amc, bvh = kx.read(shared_data / "cmu/135/135_02.amc"), kx.read(shared_data / "cmu/bvh/135_02_120fps.bvh")
    assert amc.frame_count == bvh.frame_count == 5202
    names = {
        "lfemur": "LeftUpLeg",
        "rfoot": "RightFoot",
        "lwrist": "LeftHand",
        "head": "Head",
        "rradius": "RightForeArm",
    }
    a = amc.positions()[:, [amc.skeleton.find(n) for n in names]]
    b = bvh.positions()[:, [bvh.skeleton.find(n) for n in names.values()]]
    assert np.abs(a - b).max() < 1e-4
    assert pair_distance(kx.poses(amc).quaternions, kx.poses(bvh).quaternions).max() < 1e-4


@pytest.mark.parametrize("clip", ["02_01", "16_21"])
def test_cgspeed_conversions_agree_with_the_originals(clip: str, shared_data: Path) -> None:
    """The cgspeed BVHs, their T-pose dropped, have the AMCs' poses in spite of the lost thorax bone."""
    amc = kx.read(shared_data / "cmu" / clip[:2] / f"{clip}.amc")
    bvh = kx.read(shared_data / "cmu" / "bvh" / f"cgspeed_{clip}.bvh")
    assert any("T-pose" in text for text in bvh.assumptions)
    assert amc.frame_count == bvh.frame_count
    distance = pair_distance(kx.poses(amc).quaternions, kx.poses(bvh).quaternions)
    worst = int(distance.argmax())
    assert np.median(distance) <= 0.005, f"worst frame {worst}: {distance[worst]:.4f}"


def test_raising_the_left_hand_is_raising_the_right_one_mirrored(shared_data: Path, tmp_path: Path) -> None:
    """Time-aligned, a left-hand raise is nearer to a mirrored right-hand raise than to the raise itself, in ≥ 97 % of pairs."""

    def aligned(wanted: str) -> list[Array]:
        out = []
        for motion in bandai_clips(shared_data, tmp_path, wanted, step=2):
            q = kx.poses(motion).quaternions
            out.append(q[np.linspace(0, len(q) - 1, 40).round().astype(int)])
        return out

    left, right = aligned("raise-up-left-hand"), aligned("raise-up-right-hand")
    assert len(left) >= 40
    assert len(right) >= 40
    nearer = [pair_distance(a, pose.mirror(b)).mean() < pair_distance(a, b).mean() for a in left for b in right]
    assert np.mean(nearer) >= 0.97


def test_yaw_place_and_size_leave_poses_alone_on_a_real_clip(shared_data: Path) -> None:
    """A real walk turned about the vertical, moved and on a longer-limbed body has the same poses."""
    motion = kx.read(shared_data / "cmu/91/91_34.amc")[::20]
    expected = kx.poses(motion).quaternions
    turn = quaternion.from_rotvec([0, 2.2, 0])
    rotations = motion.rotations.copy()
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    other = motion.replace(
        skeleton=motion.skeleton.replace(offsets=motion.skeleton.offsets * 1.25),
        rotations=rotations,
        root_positions=quaternion.rotate(turn, motion.root_positions) + np.array([5.0, 0.0, 1.0]),
    )
    assert pair_distance(kx.poses(other).quaternions, expected).max() < 1e-9
