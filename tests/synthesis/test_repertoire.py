"""Recordings brought onto one skeleton: strands, moments, mirror images, the ground, and what is refused."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import bodies
import kinesics as kx
from kinesics.body import contacts
from kinesics.body.mending import mended
from kinesics.body.motion import Motion
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError, SkeletonError
from kinesics.geometry import quaternion
from kinesics.synthesis.repertoire import Repertoire, repertoire
from kinesics.vocabulary import LINKS

Array = NDArray[np.float64]


TWO_WALKS = repertoire([bodies.legs_striding(60), bodies.legs_striding(45, period=0.7)], backwards=True)
"""Two recordings of a small figure, all strands allowed."""


@pytest.fixture
def two_walks() -> Repertoire:
    return TWO_WALKS


def played(rep: Repertoire, moment: int) -> list[int]:
    """All moments from one on to the end of its recording, one step at a time."""
    out = [moment]
    while (following := int(rep.advance(out[-1]))) >= 0:
        out.append(following)
    return out


def test_recordings_lie_end_to_end(two_walks: Repertoire) -> None:
    """Frames count through, each belongs to its recording, and the arrays are as long."""
    assert two_walks.frame_count == 105
    assert two_walks.starts.tolist() == [0, 60, 105]
    assert two_walks.recording_of([0, 59, 60, 104]).tolist() == [0, 0, 1, 1]
    assert two_walks.rotations.shape == (2, 105, 17, 4)
    assert two_walks.root_positions.shape == (2, 105, 3)
    assert two_walks.contacts.shape == (2, 105, 2)
    assert len(two_walks.poses) == 105
    assert two_walks.source_frames[[0, 59, 60, 104]].tolist() == [0, 59, 0, 44]
    assert two_walks.names == ("recording 1", "recording 2")
    assert two_walks.skeleton.anatomy is not None


@given(st.integers(0, 4 * 105 - 1))
def test_moments_go_on_in_their_strand(moment: int) -> None:
    """Step by step, in one leap, or counted: the same way to the same end, forwards or backwards."""
    rep = TWO_WALKS
    frame, strand = divmod_of(rep, moment)
    assert rep.moments(frame, strand) == moment
    way = played(rep, moment)
    assert len(way) == rep.remaining(moment) + 1
    frames = rep.frame_of(way)
    assert np.all(np.diff(frames) == (-1 if strand >= 2 else 1))
    assert len(set(rep.recording_of(frames).tolist())) == 1
    assert rep.advance(moment, len(way) - 1) == way[-1]
    assert rep.advance(moment, len(way)) == -1
    assert rep.advance(way[-1], 1 - len(way)) == moment


def divmod_of(rep: Repertoire, moment: int) -> tuple[int, int]:
    strand, frame = divmod(moment, rep.frame_count)
    return frame, strand


def test_strands_are_mirror_images_and_reversals(two_walks: Repertoire) -> None:
    """Every strand of a recording is what mirroring and reversing the recording gives."""
    plain = two_walks.motion(1)
    for strand, expected in enumerate((plain, kx.mirror(plain), kx.reverse(plain), kx.reverse(kx.mirror(plain)))):
        found = two_walks.motion(1, strand)
        np.testing.assert_allclose(found.positions(), expected.positions(), atol=1e-6)
        moments = two_walks.moments(np.arange(60, 105)[:: -1 if strand >= 2 else 1], strand)
        poses = kx.poses(expected)
        assert quaternion.angle(two_walks.quaternions_of(moments), poses.quaternions).max() < 1e-7
        np.testing.assert_allclose(two_walks.yaw_of(moments), poses.yaw, atol=1e-9)
        np.testing.assert_array_equal(two_walks.contacts_of(moments), contacts_in(two_walks, strand))
        assert two_walks.is_mirrored(moments).all() == (strand % 2 == 1)
        assert two_walks.is_backward(moments).all() == (strand >= 2)


def contacts_in(rep: Repertoire, strand: int) -> NDArray[np.bool_]:
    feet = rep.contacts[0, 60:105]
    feet = feet[:, ::-1] if strand % 2 else feet
    return feet[::-1] if strand >= 2 else feet


@pytest.mark.parametrize(
    ("mirrored", "backwards", "strands"),
    [(True, False, (0, 1)), (False, False, (0,)), (False, True, (0, 2)), (True, True, (0, 1, 2, 3))],
)
def test_only_strands_asked_for_may_be_used(mirrored: bool, backwards: bool, strands: tuple[int, ...]) -> None:
    """Mirror images by default, reversals on request."""
    rep = repertoire([bodies.legs_striding(30)], mirrored=mirrored, backwards=backwards)
    assert rep.strands == strands


def test_one_motion_need_not_be_listed() -> None:
    """A single motion is a repertoire of one recording."""
    assert repertoire(bodies.legs_striding(30)).recording_count == 1


def test_limbs_of_the_image_are_those_of_the_output() -> None:
    """A body whose right leg is longer stays so in the mirror: the pose is mirrored, the skeleton is not."""
    walk = bodies.legs_striding(120)
    offsets = walk.skeleton.offsets.copy()
    offsets[walk.skeleton.find("RightLeg"), 1] *= 1.1
    uneven = walk.replace(skeleton=walk.skeleton.replace(offsets=offsets))
    rep = repertoire([uneven])
    image = rep.motion(0, 1)
    np.testing.assert_array_equal(image.skeleton.offsets, offsets)
    assert quaternion.angle(kx.poses(image).quaternions, rep.poses.mirror().quaternions).max() < 1e-7
    np.testing.assert_allclose(image.root_positions[:, 0], -rep.root_positions[0, :, 0], atol=1e-12)


def test_the_ground_is_at_zero() -> None:
    """Recordings made at any height come to stand on y = 0; what was found is said."""
    walk = bodies.legs_striding(240)
    for height in (-3.0, 0.0, 1.7):
        rep = repertoire([walk.replace(root_positions=walk.root_positions + np.array([0.0, height, 0.0]))])
        for strand in (0, 1):
            assert abs(contacts.floor_height(rep.motion(0, strand))) < 0.01
        assert any("ground, found at" in said for said in rep.assumptions)


def test_frame_rates_are_made_one() -> None:
    """The first recording's rate unless another is asked for; source frames say where each frame came from."""
    slow, fast = bodies.legs_striding(61, fps=30.0), bodies.legs_striding(241, fps=120.0)
    rep = repertoire([slow, fast])
    assert rep.fps == 30.0
    assert rep.source_fps == (30.0, 120.0)
    assert rep.source_frames[rep.starts[1] :].tolist() == list(range(0, 241, 4))
    np.testing.assert_allclose(rep.rotations[0, rep.starts[1] :], fast.rotations[::4], atol=1e-9)
    assert any("from 120 to 30" in said for said in rep.assumptions)
    asked = repertoire([slow], fps=45.0)
    np.testing.assert_allclose(asked.source_frames[:4], [0.0, 2.0 / 3.0, 4.0 / 3.0, 2.0])


def test_names_are_told_apart() -> None:
    """Two recordings of one name stay two."""
    walks = [bodies.legs_striding(30, file_name="walk"), bodies.legs_striding(30, file_name="walk")]
    assert repertoire(walks).names == ("walk", "walk (2)")


def test_what_cannot_be_performed_is_refused() -> None:
    """No recordings, a single pose, a rate that is none, a body that is no human's: each with its name."""
    walk = bodies.legs_striding(30, file_name="walk")
    with pytest.raises(InputError, match="empty"):
        repertoire([])
    with pytest.raises(InputError, match=r"recording 2 is a single pose"):
        repertoire([walk, bodies.legs_striding(30)[4]])
    for rate in (0.0, -30.0, float("nan")):
        with pytest.raises(InputError, match="fps"):
            repertoire([walk], fps=rate)
    with pytest.raises(InputError, match=r"Expected 8 frames a second or more .* got `fps` = 1: one recording passes"):
        repertoire([walk], fps=1.0)
    with pytest.raises(InputError, match=r"at most 1000 frames a second .* got `fps` = 100000"):
        repertoire([walk], fps=1e5)
    with pytest.raises(InputError, match=r"walk has 2 frames a second, fewer than the 8"):
        repertoire([walk.replace(fps=2.0)])
    fast = walk.replace(fps=2000.0)
    with pytest.raises(InputError, match=r"walk has 2000 frames a second, more than the 1000 that are performed"):
        repertoire([fast, walk])
    assert repertoire([walk, fast], fps=60.0).fps == 60.0
    with pytest.raises(InputError, match=r"Too short to perform from: 'walk' lasts 0.2 s, 12 frames"):
        repertoire([walk[:12]])
    with pytest.raises(InputError, match=r"Too short to perform from: 'walk', 'walk \(2\)' last 0.2 s at most"):
        repertoire([walk[:12], walk[:5]])
    stick = Skeleton(("a", "b"), (-1, 0), np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    pole = Motion(stick, quaternion.identity((5, 2)), np.zeros((5, 3)), 30.0, name="pole")
    with pytest.raises(SkeletonError, match="pole"):
        repertoire([walk, pole])
    for body in (stick, pole):
        with pytest.raises(SkeletonError, match="The skeleton to perform on"):
            repertoire([walk], skeleton=body)


def test_the_skeleton_is_said_and_may_be_that_of_a_recording() -> None:
    """Of the first, of the recording given for it, or given as such; a recording tells what a skeleton at rest does not."""
    walk = bodies.legs_striding(30, file_name="walk")
    other = walk.replace(skeleton=walk.skeleton.replace(offsets=1.1 * walk.skeleton.offsets), name="tall")
    assert "performed on the skeleton of walk" in repertoire([walk]).assumptions
    on_other = repertoire([walk], skeleton=other)
    assert "performed on the skeleton of tall" in on_other.assumptions
    np.testing.assert_array_equal(on_other.skeleton.offsets, other.skeleton.offsets)
    given = repertoire([walk], skeleton=other.skeleton.replace(name="Eve"))
    assert "performed on the skeleton 'Eve'" in given.assumptions


def test_arrays_cannot_be_written_to(two_walks: Repertoire) -> None:
    """What many share nobody changes."""
    for array in (two_walks.rotations, two_walks.root_positions, two_walks.contacts, two_walks.starts):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def bandai(shared: Path, folder: Path, *names: str) -> list[Motion]:
    out = []
    with zipfile.ZipFile(shared / "bandai-namco" / "clips.zip") as archive:
        for name in names:
            target = folder / f"{name}.bvh"
            target.write_bytes(archive.read(next(n for n in sorted(archive.namelist()) if name in n)))
            out.append(kx.read(target))
    return out


def check(rep: Repertoire, leans: bool) -> None:
    """What holds for all recordings: images are images, feet stand on the ground, the root lies in the pelvis.

    Links of the trunk turn a little where bones of the skeleton lean to one side.
    """
    body = rep.skeleton.anatomy
    assert body is not None
    for strand in (0, 1):
        for number in range(rep.recording_count):
            motion = rep.motion(number, strand)
            seen = contacts.contacts(motion)
            bears = seen.positions[..., 1][seen.points]
            assert abs(np.median(bears)) < 0.012
            assert np.quantile(bears, 0.02) > -0.05
            kept = rep.contacts[strand, rep.starts[number] : rep.starts[number + 1]]
            assert (seen.feet == kept).mean() > 0.95
            np.testing.assert_allclose(motion.positions()[:, body.pelvis], motion.root_positions, atol=1e-9)
    image = Motion(rep.skeleton, rep.rotations[1], rep.root_positions[1], rep.fps)
    off = quaternion.angle(kx.poses(image).quaternions, rep.poses.mirror().quaternions).max(axis=0)
    bear = [k for k, name in enumerate(LINKS) if name.endswith(("root", "femur", "tibia", "radius"))]
    assert off[bear].max() < 1e-6
    assert off.max() < 1e-6 or (leans and off.max() < np.deg2rad(25.0))
    np.testing.assert_allclose(rep.root_positions[1][:, [0, 2]], rep.root_positions[0][:, [0, 2]] * [-1, 1], atol=1e-12)


def test_people_of_several_sizes_on_one_skeleton(shared_data: Path) -> None:
    """Walkers of the CMU database, each with limbs of their own, perform on the first one's."""
    names = ("07/07_01", "35/35_01", "91/91_01")
    motions = [kx.read(shared_data / f"cmu/{n}.amc") for n in names]
    rep = repertoire(motions, fps=60.0)
    check(rep, leans=True)
    legs = [f"{side}_{part}" for side in ("left", "right") for part in ("femur", "tibia")]
    for number, motion in enumerate(motions):
        recorded = kx.poses(mended(motion).motion[::2]).quaternions
        ours = rep.poses.quaternions[rep.starts[number] : rep.starts[number + 1]]
        off = np.delete(quaternion.angle(ours, recorded).max(axis=0), [LINKS.index(name) for name in legs])
        assert off.max() < 1e-6
    # 91 has wider hips for the length of the legs
    (said,) = (said for said in rep.assumptions if "thighs turned outwards by" in said)
    assert said.startswith("91_01")


def test_a_rig_whose_stand_moves_and_other_rigs(shared_data: Path, tmp_path: Path) -> None:
    """Bandai-Namco clips hang the pelvis elsewhere in every file; they and CMU perform on one skeleton, of either kind."""
    clips = bandai(shared_data, tmp_path, "dataset-1_walk_normal_001", "dataset-2_raise-up-left-hand_normal")
    walk = kx.read(shared_data / "cmu/07/07_01.amc")
    rep = repertoire([*clips, walk])
    check(rep, leans=False)
    assert any("root joint, joint_Root, is in the pelvis, where Hips is" in said for said in rep.assumptions)
    assert not any("root joint" in said for said in repertoire(walk).assumptions)
    for number, clip in enumerate(clips):
        # the same rig: its joints keep the rotations of the file, wrists and all
        ours = rep.rotations[0, rep.starts[number] : rep.starts[number + 1]]
        np.testing.assert_allclose(ours, clip.rotations, atol=1e-12)
        start = rep.starts[number]
        pelvis = clip.positions()[:, clip.skeleton.find("Hips")]
        np.testing.assert_allclose(
            rep.root_positions[0, start : rep.starts[number + 1]][:, [0, 2]], pelvis[:, [0, 2]], atol=1e-9
        )
    check(repertoire([*clips, walk], skeleton=walk.skeleton, fps=60.0), leans=True)


def test_limbs_that_pass_through_each_other_on_another_body_are_told() -> None:
    """Hips more than twice as wide, and arms that hang as they did: told, with the depth here and there; not of bodies alike."""
    walk = kx.performer.walk(seconds=4, fps=30).motion.replace(name="walk")
    wide = walk.skeleton.offsets.copy()
    for joint in ("LeftUpLeg", "RightUpLeg"):
        wide[walk.skeleton.find(joint), 0] *= 2.5
    (said,) = repertoire(walk, skeleton=walk.skeleton.replace(offsets=wide)).warnings
    assert re.fullmatch(
        r"walk: on this body .* pass up to \d+ cm into each other, (not at all|\d+ cm) on its own; perform .*", said
    )
    assert repertoire(walk, skeleton=walk.skeleton.replace(offsets=1.1 * walk.skeleton.offsets)).warnings == ()
    assert repertoire(walk).warnings == ()
