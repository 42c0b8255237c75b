"""What looks wrong in a recording: planted defects are found where they are, clean recordings are left in peace."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

import bodies
from kinesics import formats
from kinesics.body import limits
from kinesics.body.motion import Motion, reverse
from kinesics.body.quality import KINDS, MOST_SENTENCES, Quality, estimated_stature, inspect
from kinesics.body.skeleton import EndSite, Skeleton
from kinesics.geometry import quaternion

HUMAN = bodies.human()
NAMES = HUMAN.joint_names
SKELETON = HUMAN.replace(
    end_sites=(
        EndSite(NAMES.index("Head"), (0.0, 0.2, 0.0)),
        EndSite(NAMES.index("LeftHand"), (0.15, 0.0, 0.0)),
        EndSite(NAMES.index("RightHand"), (-0.15, 0.0, 0.0)),
    )
)


def moving(frames: int = 600, fps: float = 120.0, **changes: Any) -> Motion:
    """A body that sways, swings its arms and steps in place: every joint moves, none beyond what joints do."""
    times = np.arange(frames) / fps
    vectors = np.zeros((frames, len(NAMES), 3))
    for j in range(len(NAMES)):
        rate, phase = 2.0 + 0.37 * j, 0.9 * j
        vectors[:, j, j % 3] = 0.4 * np.sin(rate * times + phase)
        vectors[:, j, (j + 1) % 3] = 0.1 * np.cos(0.7 * rate * times)
    root = np.stack([0.1 * np.sin(times), 0.93 + 0.02 * np.sin(5.0 * times), 0.3 * times], axis=-1)
    parts = {"skeleton": SKELETON, "rotations": quaternion.from_rotvec(vectors), "root_positions": root, "fps": fps}
    return Motion(**(parts | changes))


def with_rotations(motion: Motion, joint: str, frames: Any, change: np.ndarray) -> Motion:
    """One joint turned further by ``change`` in some frames."""
    rotations = motion.rotations.copy()
    j = NAMES.index(joint)
    rotations[frames, j] = quaternion.multiply(rotations[frames, j], quaternion.from_rotvec(change))
    return motion.replace(rotations=rotations)


def only(quality: Quality, kind: str) -> tuple[Any, ...]:
    """The findings, all of which are of one kind."""
    assert quality.findings
    assert {f.kind for f in quality.findings} == {kind}, quality.sentences
    return quality.findings


@pytest.mark.parametrize("fps", [25.0, 30.0, 60.0, 120.0, 240.0])
def test_a_sound_recording_has_no_findings(fps: float) -> None:
    """Nothing is said where nothing is wrong, at any frame rate."""
    assert inspect(moving(round(5 * fps), fps)).sentences == ()


@pytest.mark.parametrize("frames", [1, 2, 3, 5, 10])
def test_the_shortest_recordings_are_looked_at_too(frames: int) -> None:
    """One frame, two frames: no finding, no failure."""
    assert inspect(moving(frames)).findings == ()


def test_a_one_frame_flip_is_a_glitch_in_that_frame() -> None:
    """A joint that leaps by 120° for one frame and comes back: joint, frame and size are told."""
    motion = with_rotations(moving(), "LeftForeArm", 300, np.array([0.0, np.deg2rad(120.0), 0.0]))
    (found,) = only(inspect(motion), "glitch")
    assert (found.joint, found.start, found.end) == ("LeftForeArm", 300, 301)
    assert found.figure == pytest.approx(120.0, abs=3.0)
    assert found.sentence == "LeftForeArm leaps by 120° in one frame at frame 300 and back."
    assert found.moved == pytest.approx(2 * np.sin(np.deg2rad(60.0)) * 0.41, rel=0.05)


def test_a_glitch_of_several_frames_is_one_event() -> None:
    """Away for three frames and back is one finding of three frames."""
    motion = with_rotations(moving(), "RightArm", slice(200, 203), np.array([0.0, 0.0, 0.8]))
    (found,) = only(inspect(motion), "glitch")
    assert (found.joint, found.start, found.end) == ("RightArm", 200, 203)


def test_flipped_signs_of_quaternions_are_no_glitch(rng: np.random.Generator) -> None:
    """q and −q are one rotation."""
    motion = moving()
    signs = np.where(rng.random((600, len(NAMES), 1)) < 0.5, -1.0, 1.0)
    assert inspect(motion.replace(rotations=motion.rotations * signs)).findings == ()


def test_joints_that_leap_farther_are_told_first() -> None:
    """A shoulder that leaps by 45° throws the hand farther than a hand that turns by 170°."""
    motion = moving()
    for frame in (100, 200, 300):
        motion = with_rotations(motion, "LeftHand", frame, np.array([3.0, 0.0, 0.0]))
    for frame in (150, 400, 500):
        motion = with_rotations(motion, "LeftArm", frame, np.array([0.0, 0.8, 0.0]))
    quality = inspect(motion)
    assert quality.sentences[0].startswith("LeftArm leaps by up to 4")
    assert quality.sentences[0].endswith("3 times: frames 150, 400, 500.")
    assert quality.sentences[1].startswith("LeftHand leaps by up to 17")
    assert quality.sentences[1].endswith("3 times: frames 100, 200, 300.")


def test_a_quick_movement_is_no_glitch() -> None:
    """A joint that reaches 60 rad/s by speeding up and slowing down, as a thrower's does, is none."""
    frames, fps = 480, 240.0
    times = np.arange(frames) / fps
    angle = 2.0 * np.tanh(30.0 * (times - 1.0))
    vectors = angle[:, None] * np.array([1.0, 0.0, 0.0])
    motion = moving(frames, fps)
    rotations = motion.rotations.copy()
    rotations[:, NAMES.index("RightArm")] = quaternion.from_rotvec(vectors)
    assert np.max(np.abs(np.gradient(angle, 1 / fps))) > 55.0
    quality = inspect(motion.replace(rotations=rotations))
    assert quality.findings == ()


def test_a_root_that_leaps_is_a_glitch() -> None:
    """The whole body a metre away for one frame."""
    motion = moving()
    roots = motion.root_positions.copy()
    roots[250, 0] += 1.0
    (found,) = only(inspect(motion.replace(root_positions=roots)), "glitch")
    assert (found.joint, found.start, found.end, found.unit) == ("Hips", 250, 251, "m/s")
    assert found.figure == pytest.approx(120.0, rel=0.05)


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_an_inserted_first_frame_is_told(fps: float) -> None:
    """A T-pose before the recording: a hand at 100 m/s on frame 1."""
    motion = moving(round(4 * fps), fps)
    rotations = motion.rotations.copy()
    for joint, sign in (("LeftArm", -1.0), ("RightArm", 1.0)):
        arm = NAMES.index(joint)
        down = quaternion.from_rotvec([0.0, 0.0, sign * 1.3])
        rotations[1:, arm] = quaternion.multiply(down, quaternion.power(rotations[1:, arm], 0.3))
        rotations[0, arm] = quaternion.identity()
    motion = motion.replace(rotations=rotations)
    (found,) = only(inspect(motion), "gap")
    assert (found.start, found.end) == (0, 1)
    assert "first frame stands apart" in found.sentence
    (at_end,) = only(inspect(reverse(motion)), "gap")
    assert at_end.start == motion.frame_count - 1
    assert "last frame stands apart" in at_end.sentence


def test_missing_frames_are_a_gap() -> None:
    """A second of movement cut out: the whole body jumps at once."""
    motion = moving(900)
    keep = np.r_[0:400, 520:900]
    cut = motion.replace(rotations=motion.rotations[keep], root_positions=motion.root_positions[keep])
    (found,) = only(inspect(cut), "gap")
    assert (found.start, found.end) == (400, 401)
    assert "between frames 399 and 400" in found.sentence


def test_a_frozen_joint_is_told_with_its_stretch() -> None:
    """One joint holds its value to the last bit for a second while the rest moves."""
    motion = moving()
    rotations = motion.rotations.copy()
    rotations[200:321, NAMES.index("RightLeg")] = rotations[200, NAMES.index("RightLeg")]
    (found,) = only(inspect(motion.replace(rotations=rotations)), "frozen")
    assert (found.joint, found.start, found.end) == ("RightLeg", 200, 321)
    assert found.figure == pytest.approx(1.0)


def test_joints_that_never_move_are_not_frozen() -> None:
    """A rigid clavicle, a hand without a sensor: never moving is no fault."""
    motion = moving()
    rotations = motion.rotations.copy()
    rotations[:, NAMES.index("LeftHand")] = quaternion.identity()
    rotations[:, NAMES.index("Neck")] = rotations[0, NAMES.index("Neck")]
    assert inspect(motion.replace(rotations=rotations)).findings == ()


def test_joints_without_freedom_are_not_frozen_for_rounding() -> None:
    """What moves by less than a millionth of a radian in some stretches and not at all in others does not move."""
    motion = moving()
    vectors = np.zeros((motion.frame_count, 3))
    vectors[100:500] = 1e-9 * np.random.default_rng(0).standard_normal((400, 3))
    rotations = motion.rotations.copy()
    for joint in (3, 13):
        rotations[:, joint] = quaternion.from_rotvec(vectors)
    assert inspect(motion.replace(rotations=rotations)).findings == ()


def test_an_animation_whose_joints_rest_between_keys_is_not_frozen() -> None:
    """Where half the joints rest exactly now and then, none of them has failed."""
    motion = moving()
    rotations = motion.rotations.copy()
    for j in range(1, len(NAMES), 2):
        start = 20 * j
        rotations[start + 100 :, j] = motion.rotations[start:-100, j]
        rotations[start : start + 100, j] = motion.rotations[start, j]
    assert inspect(motion.replace(rotations=rotations)).findings == ()


def test_a_frozen_body_is_told() -> None:
    """All joints and the root exactly still for half a second."""
    motion = moving()
    rotations, roots = motion.rotations.copy(), motion.root_positions.copy()
    rotations[300:361], roots[300:361] = rotations[300], roots[300]
    found = inspect(motion.replace(rotations=rotations, root_positions=roots)).of_kind("frozen")
    assert [(f.joint, f.start, f.end) for f in found] == [("", 300, 361)]


@pytest.mark.parametrize(("frames", "told"), [(200, True), (3, False)])
def test_one_pose_throughout_is_told(frames: int, told: bool) -> None:
    """A single pose written many times is no movement of a living body; a few frames say nothing."""
    motion = moving()
    still = motion.replace(rotations=motion.rotations[[0] * frames], root_positions=motion.root_positions[[0] * frames])
    assert [(f.kind, f.start, f.end) for f in inspect(still).findings] == [("frozen", 0, frames)] * told
    assert any("Nothing moves" in said for said in inspect(still).sentences) is told


def test_doubled_frames_tell_the_true_frame_rate() -> None:
    """60 frames a second written as 120: every second frame repeats the one before."""
    slow = moving(300, 60.0)
    each_twice = np.repeat(np.arange(300), 2)
    doubled = slow.replace(
        rotations=slow.rotations[each_twice], root_positions=slow.root_positions[each_twice], fps=120.0
    )
    found = inspect(doubled).of_kind("frozen")
    assert len(found) == 1
    assert "about 60 frames a second, not 120" in found[0].sentence


@pytest.mark.parametrize("fps", [60.0, 120.0])
def test_a_trembling_joint_is_told(rng: np.random.Generator, fps: float) -> None:
    """White noise of 1° on one joint, measured to a quarter."""
    frames = round(8 * fps)
    noise = rng.normal(scale=np.deg2rad(1.0), size=(frames, 3))
    motion = with_rotations(moving(frames, fps), "LeftLeg", slice(None), noise)
    (found,) = only(inspect(motion), "jitter")
    assert found.joint == "LeftLeg"
    assert found.figure == pytest.approx(1.0, rel=0.25)


def test_a_body_that_trembles_all_over_is_told_once(rng: np.random.Generator) -> None:
    """Noise of 1.5° on every joint is one finding."""
    motion = moving()
    noise = quaternion.from_rotvec(rng.normal(scale=np.deg2rad(1.5), size=(600, len(NAMES), 3)))
    (found,) = only(inspect(motion.replace(rotations=quaternion.multiply(motion.rotations, noise))), "jitter")
    assert found.joint == ""
    assert found.figure == pytest.approx(1.5, rel=0.25)


def test_ordinary_sensor_noise_is_not_told(rng: np.random.Generator) -> None:
    """A quarter of a degree and a millimetre are what good sensors have."""
    motion = moving()
    noise = quaternion.from_rotvec(rng.normal(scale=np.deg2rad(0.25), size=(600, len(NAMES), 3)))
    noisy = motion.replace(
        rotations=quaternion.multiply(motion.rotations, noise),
        root_positions=motion.root_positions + rng.normal(scale=0.001, size=(600, 3)),
    )
    assert inspect(noisy).findings == ()


def test_a_trembling_root_is_told(rng: np.random.Generator) -> None:
    """The place of the root, noisy by a centimetre."""
    motion = moving()
    noisy = motion.replace(root_positions=motion.root_positions + rng.normal(scale=0.01, size=(600, 3)))
    (found,) = only(inspect(noisy), "jitter")
    assert found.figure == pytest.approx(0.01, rel=0.25)


@pytest.mark.parametrize(("scale", "stature"), [(0.01, 0.0175), (0.0254, 0.044), (2.54, 4.4), (100.0, 175.0)])
def test_a_wrong_unit_is_seen_in_the_size(scale: float, stature: float) -> None:
    """Centimetres or inches taken for metres, and the other way round."""
    skeleton = SKELETON.replace(offsets=SKELETON.offsets * scale)
    motion = moving()
    found = inspect(motion.replace(skeleton=skeleton, root_positions=motion.root_positions * scale)).of_kind("size")
    assert len(found) == 1
    assert found[0].figure == pytest.approx(stature, rel=0.05)
    assert "unit of length" in found[0].sentence


def test_stature_from_the_legs() -> None:
    """A leg of .83 m belongs to a body of 1.69 m: thigh and shank are .246 and .245 of the height (Drillis and Contini 1966)."""
    assert estimated_stature(moving()) == pytest.approx(0.83 / 0.491, rel=1e-3)


def test_stature_of_what_is_no_body_comes_from_its_longest_way() -> None:
    """A chain that is no human body still has a size."""
    names = tuple("abcdef")
    chain = Skeleton(names, (-1, 0, 1, 2, 3, 4), np.vstack([np.zeros(3), np.tile([0.0, 0.5, 0.0], (5, 1))]))
    motion = Motion(chain, quaternion.identity((3, 6)), np.zeros((3, 3)), 30.0)
    assert estimated_stature(motion) == pytest.approx(2.5 / 1.3)


def test_a_body_off_the_floor_is_told() -> None:
    """Half a metre above y = 0 for the whole recording, or sunk into it."""
    motion = moving()
    lifted = motion.replace(root_positions=motion.root_positions + np.array([0.0, 0.5, 0.0]))
    (found,) = only(inspect(lifted), "floor")
    assert found.figure == pytest.approx(0.5, abs=0.1)
    assert "above the floor" in found.sentence
    roots = motion.root_positions.copy()
    roots[300:330, 1] -= 0.4 * np.sin(np.linspace(0, np.pi, 30))
    (sunk,) = only(inspect(motion.replace(root_positions=roots)), "floor")
    assert 300 <= sunk.start < sunk.end <= 330
    assert 0.15 < sunk.figure < 0.4


def test_a_body_that_is_too_fast_is_told() -> None:
    """Sliding at 20 m/s, smoothly."""
    motion = moving()
    roots = motion.root_positions.copy()
    roots[:, 2] = 20.0 * np.arange(600) / 120.0
    (found,) = only(inspect(motion.replace(root_positions=roots)), "speed")
    assert found.figure == pytest.approx(20.0, rel=0.1)


def test_a_wreck_is_told_in_a_handful_of_sentences(rng: np.random.Generator) -> None:
    """However much is wrong, there are at most six sentences, worst kind first, and the same ones each time."""
    motion = moving(1200)
    for frame in range(50, 1150, 10):
        joint = NAMES[int(rng.integers(1, len(NAMES)))]
        motion = with_rotations(motion, joint, frame, rng.normal(size=3) * 2.0)
    roots = motion.root_positions.copy()
    roots[600:] += 5.0
    motion = motion.replace(root_positions=roots * 30.0, skeleton=SKELETON.replace(offsets=SKELETON.offsets * 30.0))
    first, again = inspect(motion), inspect(motion)
    assert len(first.findings) > 20
    assert len(first.sentences) <= MOST_SENTENCES
    assert first.findings == again.findings
    assert first.sentences == again.sentences
    order = [KINDS.index(f.kind) for f in first.findings]
    assert order == sorted(order)
    assert "unit of length" in first.sentences[0]


def test_findings_are_plain_values_for_json() -> None:
    """Through JSON and back nothing is lost."""
    motion = with_rotations(moving(), "LeftForeArm", 300, np.array([0.0, 2.0, 0.0]))
    plain = inspect(motion).to_dict()
    assert json.loads(json.dumps(plain)) == plain
    assert plain["counts"]["glitch"] == 1
    assert plain["findings"][0]["joints"] == ["LeftForeArm"]


@pytest.mark.parametrize(
    ("clip", "expected"),
    [
        ("135/135_02", [("rthumb", 3058), ("lthumb", 3088), ("lhand", 4205)]),
        ("49/49_08", [("lhand", 138), ("rthumb", 339), ("rhand", 376)]),
        ("86/86_01", [("rhumerus", 2175)]),
        ("35/35_01", [("lfoot", 99)]),
        ("91/91_34", [("rthumb", 1182)]),
    ],
)
def test_known_flips_of_real_recordings_are_found(
    shared_data: Path, clip: str, expected: list[tuple[str, int]]
) -> None:
    """The one-frame flips that are known in CMU recordings lie within a finding for their joint."""
    found = inspect(formats.read(shared_data / "cmu" / f"{clip}.amc")).of_kind("glitch")
    for joint, frame in expected:
        assert any(f.joint == joint and f.start - 1 <= frame <= f.end for f in found), (joint, frame)


@pytest.mark.parametrize("clip", ["02/02_01", "07/07_01", "09/09_06", "13/13_29", "13/13_30", "14/14_06", "16/16_21"])
def test_clean_real_recordings_are_left_in_peace(shared_data: Path, clip: str) -> None:
    """No wolf is cried."""
    assert inspect(formats.read(shared_data / "cmu" / f"{clip}.amc")).sentences == ()


def test_no_wolf_in_another_studios_recordings(shared_data: Path, tmp_path: Path) -> None:
    """A sample of clips at 30 frames a second of three actors, fast and slow: not one finding."""
    with zipfile.ZipFile(shared_data / "bandai-namco" / "clips.zip") as archive:
        names = sorted(n for n in archive.namelist() if n.endswith(".bvh"))[::40]
        for name in names:
            archive.extract(name, tmp_path)
    told = {name: inspect(formats.read(tmp_path / name)).sentences for name in names}
    assert len(told) > 15
    assert {name: sentences for name, sentences in told.items() if sentences} == {}


@given(
    st.integers(1, 40),
    st.integers(1, 12),
    st.sampled_from([1.0, 29.97, 120.0, 1e6]),
    st.sampled_from([0.0, 1e-300, 1.0, 1e9, 1e11]),
    st.integers(0, 2**32 - 1),
)
def test_nothing_makes_it_fail(frames: int, joints: int, fps: float, size: float, seed: int) -> None:
    """Any lawful motion, however absurd, is looked at without an error or a warning, and said to be finite figures."""
    rng = np.random.default_rng(seed)
    parents = (-1, *(int(rng.integers(0, j)) for j in range(1, joints)))
    skeleton = Skeleton(tuple(f"j{j}" for j in range(joints)), parents, size * rng.normal(size=(joints, 3)))
    rotations = quaternion.normalize(rng.normal(size=(frames, joints, 4)))
    if seed % 3 == 0:
        rotations[:] = rotations[0]
    motion = Motion(skeleton, rotations, size * rng.normal(size=(frames, 3)), fps)
    quality = inspect(motion)
    assert len(quality.sentences) <= MOST_SENTENCES
    assert all(np.isfinite(f.figure) and 0 <= f.start < f.end <= frames for f in quality.findings)
    assert limits.free_space(motion).frame_count == frames
