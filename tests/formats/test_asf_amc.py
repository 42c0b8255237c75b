"""ASF/AMC files: the two halves found and joined, every frame of reference right, and written from any motion."""

from __future__ import annotations

import numpy as np
import pytest

import bodies
import kinesics as kx
import small_files
from kinesics.body.motion import Source
from kinesics.errors import FileError, InputError
from kinesics.geometry import quaternion
from naive import formats as naive

UNIT = 0.0254 / 0.45


@pytest.fixture
def folder(tmp_path, rng):
    """A folder with a skeleton and a recording of it."""
    (tmp_path / "07.asf").write_text(small_files.ASF)
    (tmp_path / "07_01.amc").write_text(small_files.amc(rng))
    return tmp_path


@pytest.fixture(params=["native", "python"])
def parser(request, monkeypatch):
    """With the compiled number parser and without."""
    if request.param == "native":
        pytest.importorskip("kinesics._native", reason="Built without the compiled kernels.")
    else:
        monkeypatch.setenv("KINESICS_NO_NATIVE", "1")
    return request.param


def named(motion, names):
    """World positions and orientations of joints by name; the root is called root in an .amc."""
    index = [motion.skeleton.joint_index.get(n, 0) for n in names]
    return motion.positions()[:, index], motion.global_rotations()[:, index]


def assert_same_motion(a, b, tolerance=1e-6):
    """Positions in metres and rotations in radians agree, joint by joint."""
    names = a.skeleton.joint_names
    (where_a, turned_a), (where_b, turned_b) = named(a, names), named(b, names)
    assert len(names) == b.skeleton.joint_count
    assert np.abs(where_a - where_b).max() < tolerance
    assert quaternion.angle(turned_a, turned_b).max() < tolerance


@pytest.mark.parametrize("angle", ["deg", "rad"])
def test_frames_of_reference_are_those_of_the_naive_reader(tmp_path, rng, parser, angle) -> None:
    """Axes in every order, degrees of freedom in any order, bones that shift, hinges, degrees and radians."""
    asf = small_files.ASF
    if angle == "rad":
        asf = (
            asf.replace("angle deg", "angle rad")
            .replace("-90", "-1.5")
            .replace("10 -20 30", "1 -2 3")
            .replace("5 6 20", ".5 .6 2")
        )
    amc = small_files.amc(rng, header=":FULLY-SPECIFIED\n" + (":DEGREES\n" if angle == "deg" else ":RADIANS\n"))
    (tmp_path / "a.asf").write_text(asf)
    (tmp_path / "a.amc").write_text(amc)
    motion = kx.read(tmp_path / "a.amc", up="y")
    names, positions, orientations = naive.read_amc(asf, amc)
    where, turned = named(motion, names)
    np.testing.assert_allclose(where, positions * UNIT, atol=1e-9)
    np.testing.assert_allclose(quaternion.as_matrix(turned), orientations, atol=1e-12)
    assert sorted(motion.skeleton.joint_names) == sorted(names)


def test_the_root_may_start_elsewhere(tmp_path, rng) -> None:
    """:root position is where the root's translations start from."""
    (tmp_path / "a.asf").write_text(small_files.ASF.replace("position 0 0 0", "position 1 2 3"))
    (tmp_path / "b.asf").write_text(small_files.ASF)
    (tmp_path / "a.amc").write_text(small_files.amc(rng))
    shifted = kx.read(tmp_path / "a.amc", up="y").root_positions
    plain = kx.read(tmp_path / "a.amc", up="y", skeleton=tmp_path / "b.asf").root_positions
    np.testing.assert_allclose(shifted - plain, np.tile(np.array([1.0, 2.0, 3.0]) * UNIT, (5, 1)))


def test_joints_sit_at_the_near_ends_of_bones(folder) -> None:
    """A joint's offset is its parent's direction times length, and a leaf has its tip at the far end."""
    skeleton = kx.read(folder / "07_01.amc", up="y").skeleton
    np.testing.assert_allclose(skeleton.offsets[skeleton.find("lfemur")], np.array([0.6, -0.8, 0.0]) * 2.5 * UNIT)
    tips = {skeleton.joint_names[s.parent]: s.offset for s in skeleton.end_sites}
    assert set(tips) == {"lfoot", "lowerback"}
    assert tips["lfoot"] == pytest.approx((0.0, 0.0, 2.1 * UNIT))


def test_limits_are_in_radians_and_in_the_order_of_the_channels(folder) -> None:
    """Limits are kept for each turning axis; those of a file in degrees become radians."""
    skeleton = kx.read(folder / "07_01.amc", up="y").skeleton
    femur = skeleton.freedoms[skeleton.find("lfemur")]
    assert femur.channels == "xyz"
    np.testing.assert_allclose(femur.limits, np.radians([(-160, 20), (-70, 70), (-60, np.inf)]))
    assert skeleton.freedoms[skeleton.find("lfoot")].channels == "zx"
    assert skeleton.freedoms[skeleton.find("lhipjoint")].channels == ""


@pytest.mark.parametrize(
    ("skeletons", "taken"),
    [
        (["07_01.asf", "07.asf", "x.asf"], "07_01.asf"),
        (["07.asf", "x.asf"], "07.asf"),
        (["07.ASF", "x.asf"], "07.ASF"),
        (["whoever.asf"], "whoever.asf"),
    ],
)
def test_the_skeleton_is_found_beside_the_recording_and_named(tmp_path, rng, skeletons, taken) -> None:
    """Of the same name, else the subject's, else the only one there is."""
    for name in skeletons:
        (tmp_path / name).write_text(small_files.ASF)
    (tmp_path / "07_01.amc").write_text(small_files.amc(rng))
    motion = kx.read(tmp_path / "07_01.amc", up="y")
    assert any(taken in a for a in motion.assumptions)
    assert motion.source.details["skeleton_file"] == taken


def test_without_a_skeleton_the_error_says_which_were_looked_for(tmp_path, rng) -> None:
    """None beside it, or several of which none fits."""
    (tmp_path / "07_01.amc").write_text(small_files.amc(rng))
    with pytest.raises(FileError, match=r"07_01\.asf or 07\.asf, there is none.*\(--skeleton, skeleton=\)"):
        kx.read(tmp_path / "07_01.amc")
    for name in ("x.asf", "y.asf"):
        (tmp_path / name).write_text(small_files.ASF)
    with pytest.raises(FileError, match="there are 2 beside it"):
        kx.read(tmp_path / "07_01.amc")
    with pytest.raises(FileError, match="no such file"):
        kx.read(tmp_path / "07_01.amc", skeleton=tmp_path / "z.asf")


def test_a_skeleton_alone_is_no_recording(folder) -> None:
    """Reading an .asf says what to give instead."""
    with pytest.raises(FileError, match=r"skeleton \(.asf\), not a recording.*\.amc"):
        kx.read(folder / "07.asf")


@pytest.mark.parametrize(
    ("name", "fps"), [("07_01", 120.0), ("60_12", 60.0), ("89_06", 60.0), ("134_15", 120.0), ("kata", 120.0)]
)
def test_the_frame_rate_is_the_database_s_and_said(tmp_path, rng, name, fps) -> None:
    """CMU captured some subjects at 60 frames a second; the file says nothing."""
    (tmp_path / "any.asf").write_text(small_files.ASF)
    (tmp_path / f"{name}.amc").write_text(small_files.amc(rng))
    motion = kx.read(tmp_path / f"{name}.amc", up="y")
    assert motion.fps == fps
    assert any(f"{fps:g} frames a second" in a for a in motion.assumptions)
    assert kx.read(tmp_path / f"{name}.amc", up="y", fps=59.94).fps == 59.94


def test_a_frame_rate_in_the_file_is_taken(tmp_path, rng) -> None:
    """Some programs write :SAMPLES-PER-SECOND."""
    (tmp_path / "any.asf").write_text(small_files.ASF)
    header = ":FULLY-SPECIFIED\n:SAMPLES-PER-SECOND 100\n:DEGREES\n"
    (tmp_path / "a.amc").write_text(small_files.amc(rng, header=header))
    motion = kx.read(tmp_path / "a.amc", up="y")
    assert motion.fps == 100.0
    assert not any("frames a second" in a for a in motion.assumptions)


def test_frames_that_list_their_bones_in_another_order_are_read_the_same(folder, parser) -> None:
    """The fast way needs all frames alike; others are read one by one, with the same result."""
    motion = kx.read(folder / "07_01.amc", up="y")
    lines = (folder / "07_01.amc").read_text().splitlines()
    lines[12], lines[13] = lines[13], lines[12]
    lines.insert(11, "# a remark")
    (folder / "07_02.amc").write_text("\n".join(lines))
    again = kx.read(folder / "07_02.amc", up="y")
    np.testing.assert_array_equal(again.rotations, motion.rotations)
    np.testing.assert_array_equal(again.root_positions, motion.root_positions)


def test_bones_that_never_occur_do_not_turn_and_this_is_said(folder) -> None:
    """An .amc may leave bones of its skeleton out."""
    content = "".join(
        line for line in (folder / "07_01.amc").read_text().splitlines(keepends=True) if not line.startswith("ltibia")
    )
    (folder / "07_02.amc").write_text(content)
    motion = kx.read(folder / "07_02.amc", up="y")
    np.testing.assert_array_equal(motion.rotations[:, motion.skeleton.find("ltibia")], quaternion.identity((5,)))
    assert any("'ltibia' does not occur" in a for a in motion.assumptions)


def test_frame_numbers_that_jump_are_a_warning(folder) -> None:
    """A gap in the numbers says that frames are missing; a step throughout, that the recording was thinned."""
    content = (folder / "07_01.amc").read_text()
    (folder / "07_02.amc").write_text(content.replace("\n5\n", "\n9\n"))
    assert "from 4 to 9" in kx.read(folder / "07_02.amc", up="y").warnings[0]
    for k in (5, 4, 3, 2):
        content = content.replace(f"\n{k}\n", f"\n{1 + 4 * (k - 1)}\n")
    (folder / "07_03.amc").write_text(content)
    assert "go up by 4" in kx.read(folder / "07_03.amc", up="y").warnings[0]


def test_without_a_length_scale_the_unit_is_judged_by_the_body(tmp_path) -> None:
    """A scale of 1 is what programs write that know nothing of it."""
    walk = bodies.legs_striding(30)
    kx.write(walk, tmp_path / "walk.amc")
    asf = (tmp_path / "walk.asf").read_text()
    assert "length 0.45" in asf
    (tmp_path / "walk.asf").write_text(asf.replace("length 0.45", "length 1.0", 1))
    motion = kx.read(tmp_path / "walk.amc")
    assert motion.source.metres_per_unit == pytest.approx(UNIT)
    assert any("CMU's ASF units" in a for a in motion.assumptions)
    assert kx.read(tmp_path / "walk.amc", unit="cm").source.metres_per_unit == 0.01


# ------------------------------------------------------------------------------------------------- writing


def test_what_was_read_is_written_back(folder) -> None:
    """Skeleton, tips, axes, degrees of freedom, limits, frame rate and every rotation survive."""
    motion = kx.read(folder / "07_01.amc", up="y", fps=59.94)
    remarks = kx.write(motion, folder / "again.amc")
    assert remarks == ("'lowerback' moves against its parent (dof tx ty tz), which not every program reads",)
    again = kx.read(folder / "again.amc", up="y")
    assert_same_motion(motion, again)
    assert again.fps == 59.94
    assert again.source.metres_per_unit == pytest.approx(motion.source.metres_per_unit, rel=1e-14)
    assert again.skeleton.joint_names == motion.skeleton.joint_names
    assert again.skeleton.name == "tiny"
    np.testing.assert_allclose(again.skeleton.offsets, motion.skeleton.offsets, atol=1e-12)
    for one, other in zip(again.skeleton.end_sites, motion.skeleton.end_sites, strict=True):
        assert one.parent == other.parent
        assert one.offset == pytest.approx(other.offset, abs=1e-12)
    for one, other in zip(again.skeleton.freedoms, motion.skeleton.freedoms, strict=True):
        assert (one.order, one.channels) == (other.order, other.channels)
        assert quaternion.angle(one.axis, other.axis) < 1e-9
        np.testing.assert_allclose(one.limits, other.limits)


def test_any_motion_can_be_written_and_comes_back_joint_for_joint(tmp_path, rng) -> None:
    """Children that hang at different places get helper bones, which reading takes out again."""
    (tmp_path / "small.bvh").write_text(small_files.bvh(rng))
    motion = kx.read(tmp_path / "small.bvh", unit="cm", up="y")
    remarks = kx.write(motion, tmp_path / "small.amc")
    assert any("'Hips' is called 'root'" in r for r in remarks)
    assert any("'Left Arm' is called 'Left_Arm'" in r for r in remarks)
    assert any("'Left_Arm' moves against its parent" in r for r in remarks)
    asf = (tmp_path / "small.asf").read_text()
    assert "Left_Arm_link" in asf
    again = kx.read(tmp_path / "small.amc", up="y")
    renamed = motion.replace(
        skeleton=motion.skeleton.replace(
            joint_names=("root", *(n.replace(" ", "_") for n in motion.skeleton.joint_names[1:]))
        )
    )
    assert again.skeleton.joint_names == renamed.skeleton.joint_names
    assert again.skeleton.parents == renamed.skeleton.parents
    assert_same_motion(renamed, again)
    tips = {(s.parent, *np.round(s.offset, 9)) for s in again.skeleton.end_sites}
    assert tips == {(s.parent, *np.round(s.offset, 9)) for s in motion.skeleton.end_sites}


def test_the_naive_reader_agrees_with_what_was_written(tmp_path, rng) -> None:
    """Helper bones and frames of reference mean the same to a reader that knows nothing of kinesics."""
    (tmp_path / "small.bvh").write_text(small_files.bvh(rng))
    motion = kx.read(tmp_path / "small.bvh", unit="cm", up="y")
    kx.write(motion, tmp_path / "small.amc")
    names, positions, orientations = naive.read_amc(
        (tmp_path / "small.asf").read_text(), (tmp_path / "small.amc").read_text()
    )
    index = [names.index("root" if j == 0 else n.replace(" ", "_")) for j, n in enumerate(motion.skeleton.joint_names)]
    np.testing.assert_allclose(np.array(positions)[:, index] * UNIT, motion.positions(), atol=1e-6)
    np.testing.assert_allclose(
        np.array(orientations)[:, index], quaternion.as_matrix(motion.global_rotations()), atol=1e-6
    )


def test_a_hinge_that_was_turned_another_way_gets_all_three_axes(folder) -> None:
    """What the file's degrees of freedom cannot say is written with more of them."""
    motion = kx.read(folder / "07_01.amc", up="y")
    rotations = motion.rotations.copy()
    for name in ("ltibia", "lfoot", "lhipjoint"):
        rotations[:, motion.skeleton.find(name)] = quaternion.from_rotvec([0.3, 0.4, 0.5])
    bent = motion.replace(rotations=rotations)
    kx.write(bent, folder / "bent.amc")
    assert_same_motion(bent, kx.read(folder / "bent.amc", up="y"))


def test_between_the_formats_nothing_is_lost(tmp_path) -> None:
    """BVH to ASF/AMC and back again is the same movement, in metres."""
    walk = bodies.legs_striding(40).replace(source=Source())
    kx.write(walk, tmp_path / "a.bvh")
    first = kx.read(tmp_path / "a.bvh")
    kx.write(first, tmp_path / "b.amc")
    second = kx.read(tmp_path / "b.amc")
    kx.write(second, tmp_path / "c.bvh")
    assert_same_motion(first, kx.read(tmp_path / "c.bvh"))
    assert first.fps == second.fps == walk.fps


def test_a_skeleton_file_is_not_a_place_to_write_a_motion(tmp_path) -> None:
    """The .amc is named; the .asf comes with it."""
    with pytest.raises(InputError, match=r"walk\.amc"):
        kx.write(bodies.legs_striding(3), tmp_path / "walk.asf")
