"""BVH files: read right, whoever wrote them, and written so that nothing is lost."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

import bodies
import kinesics as kx
import small_files
from kinesics.body.motion import Source
from kinesics.body.skeleton import EndSite, JointFreedom, Skeleton
from kinesics.errors import FileError
from kinesics.geometry import quaternion
from naive import formats as naive

NAMES = ["Hips", "mixamorig:Spine", "Left Arm", "LeftForeArm", "LeftThumb", "Head", "LeftUpLeg", "Skirt", "LeftLeg"]


@pytest.fixture
def read(tmp_path):
    """Reads a text as a BVH in metres, y up."""

    def read(content, **options):
        path = tmp_path / "small.bvh"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return kx.read(path, **({"unit": "m", "up": "y"} | options))

    return read


def assert_same_motion(a, b, tolerance=1e-6):
    """Positions in metres and rotations in radians agree, joint by joint."""
    assert a.skeleton.joint_names == b.skeleton.joint_names
    assert np.abs(a.positions() - b.positions()).max() < tolerance
    assert quaternion.angle(a.global_rotations(), b.global_rotations()).max() < tolerance


def test_any_order_and_number_of_channels_is_read_as_the_naive_reader_does(read, rng) -> None:
    """Mixed rotation orders, positions between rotations, joints of 0, 1, 2, 4 and 6 channels."""
    content = small_files.bvh(rng)
    motion = read(content)
    names, positions, orientations, seconds = naive.read_bvh(content)
    assert list(motion.skeleton.joint_names) == names == NAMES
    np.testing.assert_allclose(motion.positions(), positions, atol=1e-9)
    np.testing.assert_allclose(quaternion.as_matrix(motion.global_rotations()), orientations, atol=1e-12)
    assert motion.fps == pytest.approx(1.0 / seconds)


def test_all_tips_are_kept(read, rng) -> None:
    """A joint may have several End Sites, and fingers are not thrown away."""
    sites = read(small_files.bvh(rng)).skeleton.end_sites
    assert [(NAMES[s.parent], s.offset) for s in sites] == [
        ("LeftThumb", (2.0, 0.0, 2.0)),
        ("LeftThumb", (3.0, 0.0, 1.0)),
        ("Head", (0.0, 20.0, 0.0)),
        ("LeftLeg", (0.0, -41.0, 0.0)),
    ]


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t.replace("\n", "\r\n").encode(),
        lambda t: t.replace("\n", "\r").encode(),
        lambda t: t.encode("utf-8-sig"),
        lambda t: t.encode("utf-16"),
        lambda t: t.replace("\t", " ").replace(" ", "\t").replace("Left\tArm", "Left Arm").encode(),
        lambda t: ("# made by hand\n// so\n" + t.replace("MOTION\n", "# now\nMOTION\n\n")).encode(),
        lambda t: t.replace("0.01\n", "0.01\n# the frames\n\n").encode(),
        lambda t: re.sub(
            r"HIERARCHY|ROOT|JOINT|OFFSET|CHANNELS|End|MOTION|Frames|Frame Time", lambda m: m[0].lower(), t
        ).encode(),
        lambda t: re.sub(r"\n\s*\{", " {", t).encode(),
        lambda t: re.sub(r"(\d)(\.\d+)", r"\1\2e+00", t).encode(),
        lambda t: t.replace("Frame Time: 0.01", "Frame Time:1.0E-2").replace("Frames: ", "Frames:").encode(),
        lambda t: t.rstrip("\n").encode(),
    ],
    ids=[
        "crlf",
        "cr",
        "bom",
        "utf16",
        "tabs",
        "comments",
        "comments-in-motion",
        "lowercase",
        "braces",
        "exponents",
        "spacing",
        "no-last-newline",
    ],
)
def test_the_same_file_in_another_dress_is_the_same_motion(read, rng, change) -> None:
    """Line ends, marks, blanks, comments, capitals and exponents change nothing."""
    content = small_files.bvh(rng)
    assert_same_motion(read(content), read(change(content)), 1e-12)


def test_positions_take_the_place_of_the_offset(read, rng) -> None:
    """Position channels are where the joint is, and are not added to where it would be; the root's too, and that is said."""
    tree = small_files.BVH_TREE.replace("OFFSET 0 0 0", "OFFSET 5 90 -400", 1)
    motion = read(small_files.bvh(rng, tree=tree))
    row = np.array(small_files.bvh(np.random.default_rng(20120615), tree=tree).splitlines()[-5].split(), dtype=float)
    np.testing.assert_allclose(motion.root_positions[0], row[:3])
    np.testing.assert_allclose(motion.joint_translations[0, 2], row[9:12])
    assert any("OFFSET (5 90 -400) is not added" in a for a in motion.assumptions)


def test_positions_that_only_repeat_the_offset_move_nothing(read, tmp_path) -> None:
    """Files whose joints all have six channels but never shift hold no joint translations; the channels come back on writing."""
    tree = small_files.BVH_TREE.replace(
        "CHANNELS 4 Zrotation Yposition Yrotation Xrotation", "CHANNELS 3 Zrotation Yrotation Xrotation"
    )
    row = ["0"] * (small_files.BVH_COLUMNS - 1)
    row[9:12] = ["18.0", "16", "0.000000"]
    content = f"{tree}MOTION\nFrames: 2\nFrame Time: 0.01\n" + 2 * (" ".join(row) + "\n")
    motion = read(content)
    assert motion.joint_translations is None
    kx.write(motion, tmp_path / "again.bvh")
    assert (
        "CHANNELS 6 Xposition Yposition Zposition Yrotation Zrotation Xrotation" in (tmp_path / "again.bvh").read_text()
    )


def test_doubled_names_are_made_unique_and_this_is_said(read, rng) -> None:
    """Two joints of one name are told apart."""
    motion = read(small_files.bvh(rng).replace("JOINT Skirt", "JOINT Head"))
    assert motion.skeleton.joint_names[7] == "Head_2"
    assert any("two joints are called 'Head'" in a and "'Head_2'" in a for a in motion.assumptions)


def test_of_two_skeletons_the_first_is_read(read, rng) -> None:
    """A second ROOT is left out with its columns, and that is said."""
    second = "ROOT Other\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\n"
    content = small_files.bvh(rng)
    both = small_files.bvh(np.random.default_rng(20120615), tree=small_files.BVH_TREE + second)
    lines = [line if k < content.count("\n") - 5 else line + " 7" for k, line in enumerate(content.splitlines())]
    both = "\n".join(lines).replace("MOTION", second + "MOTION") + "\n"
    motion = read(both)
    assert_same_motion(read(content), motion, 1e-12)
    assert any("only the first, 'Hips'" in w for w in motion.warnings)


@pytest.mark.parametrize(
    ("frame_time", "fps", "said"),
    [
        ("0.00833333", 120.0, True),
        (".0083333", 120.0, True),
        ("0.0083", 120.0, True),
        ("0.0333333", 30.0, True),
        ("0.033333", 30.0, True),
        ("0.0166667", 60.0, True),
        ("0.04", 25.0, False),
        ("0.01", 100.0, False),
        ("0.008333333333333333", 120.0, False),
        ("0.03336667", 1.0 / 0.03336667, False),
        ("0.016683350016683351", 59.94, False),
        ("4e-2", 25.0, False),
        ("2", 0.5, False),
    ],
)
def test_a_frame_time_of_few_digits_is_taken_for_the_whole_rate_it_stands_for(read, rng, frame_time, fps, said) -> None:
    """Printed times are rounded; NTSC rates are not."""
    motion = read(small_files.bvh(rng, frame_time=frame_time))
    assert motion.fps == pytest.approx(fps, rel=1e-12)
    assert any("frame time" in a for a in motion.assumptions) == said


def test_the_caller_may_give_the_frame_rate(read, rng) -> None:
    """A frame time that cannot be is mended by fps=."""
    content = small_files.bvh(rng, frame_time="0")
    with pytest.raises(FileError, match=r"\(--fps, fps=\)"):
        read(content)
    assert read(content, fps=50.0).fps == 50.0


def test_more_frames_than_promised_are_read_with_a_warning(read, rng) -> None:
    """The lines are what counts."""
    motion = read(small_files.bvh(rng).replace("Frames: 5", "Frames: 4"))
    assert motion.frame_count == 5
    assert any("promises 4 frames" in w for w in motion.warnings)


def test_one_frame_is_a_motion(read, rng) -> None:
    """A single pose can be read."""
    assert read(small_files.bvh(rng, frames=1)).frame_count == 1


def with_inserted_frame(row: str) -> str:
    """A recording whose numbers are no whole degrees, with another row put before it."""
    t = np.arange(20)[:, None]
    values = 37.3 + 10.0 * np.sin(0.05 * t + np.arange(small_files.BVH_COLUMNS))
    values[:, :3] = 12.5
    values[:, 19] = 30.0
    rows = "".join(" ".join(f"{v:.4f}" for v in line) + "\n" for line in values)
    return f"{small_files.BVH_TREE}MOTION\nFrames: 21\nFrame Time: 0.01\n{row}\n{rows}"


def test_an_inserted_t_pose_is_dropped_unless_it_is_asked_for(read) -> None:
    """As in the cgspeed conversions of the CMU database: whole degrees, in place, and a jump out of it."""
    pose = ["0"] * small_files.BVH_COLUMNS
    pose[:3] = ["12.5"] * 3
    pose[4] = "-21"
    content = with_inserted_frame(" ".join(pose))
    motion = read(content)
    assert motion.frame_count == 20
    assert any("inserted T-pose" in a for a in motion.assumptions)
    kept = read(content, keep_first_frame=True)
    assert kept.frame_count == 21
    assert not any("inserted" in a for a in kept.assumptions)


def test_a_first_frame_that_belongs_to_the_movement_is_kept(read) -> None:
    """Neither a jump between measured frames nor whole degrees throughout are an inserted pose."""
    jump = [f"{v:.4f}" for v in np.linspace(-80.03, 80.0, small_files.BVH_COLUMNS)]
    jump[:3] = ["12.5"] * 3
    assert read(with_inserted_frame(" ".join(jump))).frame_count == 21
    stepped = small_files.BVH_TREE + "MOTION\nFrames: 3\nFrame Time: 0.1\n"
    stepped += "\n".join(" ".join([str(v)] * small_files.BVH_COLUMNS) for v in (0, 45, 45)) + "\n"
    assert read(stepped).frame_count == 3


# ------------------------------------------------------------------------------------------------- writing


def test_what_was_read_is_written_back(read, rng, tmp_path) -> None:
    """Skeleton, tips, channels in their order, frame rate and every rotation survive; the file is the same but for digits."""
    content = small_files.bvh(rng, frame_time="0.0125")
    motion = read(content, unit="cm")
    assert kx.write(motion, tmp_path / "again.bvh") == ()
    again = kx.read(tmp_path / "again.bvh", unit="cm", up="y")
    assert_same_motion(motion, again)
    assert again.fps == motion.fps
    assert again.skeleton.end_sites == motion.skeleton.end_sites
    assert again.skeleton.freedoms == motion.skeleton.freedoms
    np.testing.assert_allclose(again.skeleton.offsets, motion.skeleton.offsets, atol=1e-12)
    np.testing.assert_allclose(again.joint_translations, motion.joint_translations, atol=1e-8)
    written = (tmp_path / "again.bvh").read_text()
    channels = re.findall("CHANNELS.*", content)
    assert sorted(re.findall("CHANNELS.*", written)) == sorted(channels)


@pytest.mark.parametrize("order", ["XYZ", "ZXY", "YZX"])
@pytest.mark.parametrize("middle", [89.9999, 90.0, -90.0, 90.00001])
def test_rotations_near_gimbal_lock_survive(tmp_path, rng, order, middle) -> None:
    """The angles may differ, the rotation may not."""
    skeleton = Skeleton(
        joint_names=("Hips", "Head"),
        parents=(-1, 0),
        offsets=np.array([[0.0, 0, 0], [0, 1, 0]]),
        freedoms=(JointFreedom(order=order, translation="XYZ"),) * 2,
    )
    from kinesics.geometry import euler

    angles = rng.uniform(-np.pi, np.pi, (40, 2, 3))
    angles[..., 1] = np.radians(middle)
    motion = kx.Motion(skeleton, euler.from_euler(angles, order), np.zeros((40, 3)), 30.0)
    kx.write(motion, tmp_path / "locked.bvh")
    assert_same_motion(motion, kx.read(tmp_path / "locked.bvh", unit="cm", up="y"))


def test_a_motion_of_no_file_is_written_in_centimetres_and_read_back_in_metres(tmp_path) -> None:
    """The unit and the up axis are found again by the body."""
    motion = bodies.legs_striding(60).replace(source=Source())
    kx.write(motion, tmp_path / "walk.bvh")
    again = kx.read(tmp_path / "walk.bvh")
    assert again.source.metres_per_unit == 0.01
    assert again.source.up_axis == "y"
    assert sorted(again.skeleton.joint_names) == sorted(motion.skeleton.joint_names)
    order = [again.skeleton.find(n) for n in motion.skeleton.joint_names]
    np.testing.assert_allclose(again.positions()[:, order], motion.positions(), atol=1e-6)


@pytest.mark.parametrize("up", ["z", "x", "-y", "-z", "-x"])
def test_files_with_another_up_axis_are_turned_upright_and_written_back_as_they_were(tmp_path, up) -> None:
    """The world is turned, root and all, and turned back for the file."""
    from kinesics.body import conventions

    upright = bodies.legs_striding(60)
    turn = conventions.to_y_up(up)
    lying = upright.replace(
        source=dataclasses.replace(upright.source, format="bvh", up_axis=up, metres_per_unit=0.0254)
    )
    kx.write(lying, tmp_path / "turned.bvh")
    assert_up = kx.read(tmp_path / "turned.bvh")
    assert assert_up.source.up_axis == up
    assert assert_up.source.metres_per_unit == 0.0254
    assert any(f"up axis {up}" in a for a in assert_up.assumptions)
    order = [assert_up.skeleton.find(n) for n in upright.skeleton.joint_names]
    np.testing.assert_allclose(assert_up.positions()[:, order], upright.positions(), atol=1e-6)
    raw = kx.read(tmp_path / "turned.bvh", up="y")
    np.testing.assert_allclose(quaternion.rotate(turn, raw.positions()[:, order]), upright.positions(), atol=1e-6)
    kx.write(assert_up, tmp_path / "again.bvh")
    assert (tmp_path / "again.bvh").read_text() == (tmp_path / "turned.bvh").read_text()


def test_a_joint_that_turns_more_than_its_channels_allow_gets_all_three(read, rng, tmp_path) -> None:
    """A hinge of the file that was turned another way since is written in full and not bent to its hinge."""
    motion = read(small_files.bvh(rng))
    rotations = motion.rotations.copy()
    rotations[:, 3] = quaternion.from_rotvec([0.3, 0.4, 0.5])
    rotations[:, 4] = quaternion.from_rotvec([0.3, 0.4, 0.5])
    rotations[:, 7] = quaternion.from_rotvec([0.0, 0.0, 0.5])
    bent = motion.replace(rotations=rotations)
    kx.write(bent, tmp_path / "bent.bvh")
    assert_same_motion(bent, kx.read(tmp_path / "bent.bvh", unit="m", up="y"))


def test_names_that_would_break_the_file_are_changed_and_this_is_said(tmp_path) -> None:
    """A bracket or a line feed within a name would make another file of it."""
    skeleton = Skeleton(("Hips", "a{b\nc", "a b c"), (-1, 0, 0), np.ones((3, 3)), (EndSite(1, (0.0, 0.0, 1.0)),))
    motion = kx.Motion(skeleton, quaternion.identity((2, 3)), np.zeros((2, 3)), 30.0)
    remarks = kx.write(motion, tmp_path / "names.bvh")
    assert len(remarks) == 2
    assert kx.read(tmp_path / "names.bvh", unit="cm", up="y").skeleton.joint_names == ("Hips", "a b c", "a b c_")
