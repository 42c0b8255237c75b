"""Real recordings: two formats of one movement agree, and every file that we have is read."""

from __future__ import annotations

import zipfile

import numpy as np
import pytest

import kinesics as kx
from kinesics import formats
from kinesics.geometry import quaternion
from naive import formats as naive

CGSPEED_NAMES = {
    "Hips": "root",
    **{
        f"{side}{bvh}": f"{side[0].lower()}{asf}"
        for side in ("Left", "Right")
        for bvh, asf in {
            "UpLeg": "femur",
            "Leg": "tibia",
            "Foot": "foot",
            "ToeBase": "toes",
            "Shoulder": "clavicle",
            "Arm": "humerus",
            "ForeArm": "radius",
            "Hand": "wrist",
            "FingerBase": "hand",
            "HandIndex1": "fingers",
        }.items()
    },
    "LThumb": "lthumb",
    "RThumb": "rthumb",
    "LowerBack": "lowerback",
    "Spine": "upperback",
    "Spine1": "thorax",
    "Neck": "lowerneck",
    "Neck1": "upperneck",
    "Head": "head",
}
"""Joints of the cgspeed conversions and the bones of the ASF that they were made from."""


def joints(motion, names):
    """World positions and orientations of the joints called so."""
    index = [motion.skeleton.find(n) for n in names]
    return motion.positions()[:, index], motion.global_rotations()[:, index]


def test_one_movement_in_two_formats_is_the_same(shared_data) -> None:
    """The Empi kata as BVH and as ASF/AMC: every joint within 1e-4 m in every frame (1e-5 in truth)."""
    bvh = kx.read(shared_data / "cmu/bvh/135_02_120fps.bvh")
    amc = kx.read(shared_data / "cmu/135/135_02.amc")
    assert bvh.fps == amc.fps == 120.0
    assert bvh.frame_count == amc.frame_count == 5202
    one, turned_one = joints(bvh, CGSPEED_NAMES)
    other, turned_other = joints(amc, CGSPEED_NAMES.values())
    assert np.linalg.norm(one - other, axis=-1).max() < 1e-5
    assert quaternion.angle(turned_one, turned_other).max() < 1e-5


@pytest.mark.parametrize(("bvh", "amc"), [("cgspeed_02_01", "02/02_01"), ("cgspeed_16_21", "16/16_21")])
def test_frames_of_a_cgspeed_file_are_those_of_its_amc(shared_data, bvh, amc) -> None:
    """The inserted T-pose is gone, so frames agree; what hangs on the lost thorax bone sits lower, turned alike."""
    one = kx.read(shared_data / f"cmu/bvh/{bvh}.bvh")
    other = kx.read(shared_data / f"cmu/{amc}.amc")
    assert one.frame_count == other.frame_count
    assert any("inserted T-pose" in a for a in one.assumptions)
    assert one.source.metres_per_unit == pytest.approx(other.source.metres_per_unit)
    where, turned = joints(one, CGSPEED_NAMES)
    expected, expected_turned = joints(other, CGSPEED_NAMES.values())
    below = [k for k, name in enumerate(CGSPEED_NAMES) if "Leg" in name or "Foot" in name or "Toe" in name]
    assert np.linalg.norm(where - expected, axis=-1)[:, below].max() < 1e-5
    assert quaternion.angle(turned, expected_turned).max() < 1e-4


def test_all_cmu_recordings_are_read(shared_data) -> None:
    """Skeleton found, frames complete, the body of human size and upright; the unit is the length scale's."""
    files = sorted((shared_data / "cmu").glob("*/*.amc"))
    assert files
    for path in files:
        motion = kx.read(path)
        lines = path.read_bytes().count(b"\n")
        assert motion.frame_count == lines // 30
        assert motion.warnings == ()
        assert motion.source.metres_per_unit == pytest.approx(0.0254 / 0.45)
        height = np.ptp(motion.positions()[..., 1], axis=1)
        assert 1.2 < height.max() < 2.7


def test_all_bandai_namco_clips_are_read(shared_data, tmp_path) -> None:
    """774 files with six channels on every joint; the hips move against a root that stays."""
    path = tmp_path / "clip.bvh"
    read = 0
    with zipfile.ZipFile(shared_data / "bandai-namco/clips.zip") as archive:
        for name in archive.namelist():
            if not name.endswith(".bvh"):
                continue
            path.write_bytes(archive.read(name))
            motion = kx.read(path)
            read += 1
            assert (motion.fps, motion.source.metres_per_unit, motion.source.up_axis) == (30.0, 0.01, "y")
            assert motion.joint_translations is not None
            assert motion.warnings == ()
            assert 0.6 < np.median(motion.positions()[:, motion.skeleton.find("Hips"), 1]) < 1.1
    assert read == 774


@pytest.mark.parametrize(
    "name", ["cmu/bvh/135_01_bassai_30fps.bvh", "cmu/bvh/cgspeed_02_01.bvh", "cmu/07/07_01.amc", "cmu/49/49_08.amc"]
)
@pytest.mark.parametrize("suffix", [".bvh", ".amc"])
def test_a_real_recording_survives_both_formats(shared_data, tmp_path, name, suffix) -> None:
    """Written and read again: positions within 1e-6 m, rotations within 1e-6 rad."""
    motion = kx.read(shared_data / name)
    kx.write(motion, tmp_path / f"a{suffix}")
    again = kx.read(tmp_path / f"a{suffix}")
    assert again.fps == motion.fps
    names = motion.skeleton.joint_names
    assert again.skeleton.joint_count == len(names)
    same = ["root" if n not in again.skeleton.joint_index else n for n in names]
    (where, turned), (where_again, turned_again) = joints(motion, names), joints(again, same)
    assert np.abs(where - where_again).max() < 1e-6
    assert quaternion.angle(turned, turned_again).max() < 1e-6


def test_the_naive_readers_agree_on_real_files(shared_data, tmp_path) -> None:
    """The first frames of one file of each format, line by line and with SciPy's rotations."""
    whole = (shared_data / "cmu/09/09_06.amc").read_text()
    amc = whole[: whole.index("\n13\n") + 1]
    (tmp_path / "09_06.amc").write_text(amc)
    asf = (shared_data / "cmu/09/09.asf").read_text()
    motion = kx.read(tmp_path / "09_06.amc", skeleton=shared_data / "cmu/09/09.asf")
    names, positions, orientations = naive.read_amc(asf, amc)
    where, turned = joints(motion, names)
    np.testing.assert_allclose(where, positions * 0.0254 / 0.45, atol=1e-9)
    np.testing.assert_allclose(quaternion.as_matrix(turned), orientations, atol=1e-9)

    lines = (shared_data / "cmu/bvh/135_01_bassai_30fps.bvh").read_text().splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("Frame Time"))
    bvh = "\n".join(lines[: start + 13]).replace("Frames: 1433", "Frames: 12") + "\n"
    (tmp_path / "a.bvh").write_text(bvh)
    motion = kx.read(tmp_path / "a.bvh", unit="cm", up="y")
    names, positions, orientations, _ = naive.read_bvh(bvh)
    where, turned = joints(motion, names)
    np.testing.assert_allclose(where, positions * 0.01, atol=1e-9)
    np.testing.assert_allclose(quaternion.as_matrix(turned), orientations, atol=1e-9)


def test_pictures_and_films_of_the_data_are_told_from_recordings(shared_data) -> None:
    """A wrong file given by mistake is called what it is."""
    for pattern, what in (
        ("video/**/*.avi", "video"),
        ("video/**/*.jpg", "picture"),
        ("**/*.zip", "zip"),
        ("**/*.c3d", "C3D"),
    ):
        path = next(shared_data.glob(pattern))
        if any(path.suffix in f.suffixes for f in formats.readable() if f.name != "bvh"):
            continue  # a format that has been added since
        with pytest.raises(kx.InputError, match=what):
            kx.read(path)
