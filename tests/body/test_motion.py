"""The motion: what it refuses, slicing, resampling, reversal."""

from __future__ import annotations

from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose, assert_array_equal

import kinesics as kx
from kinesics.body.motion import Motion, reverse
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError
from kinesics.geometry import quaternion

SKELETON = Skeleton(("root", "upper", "lower"), (-1, 0, 1), np.array([[0.0, 0, 0], [0, 0.5, 0], [0, 0.4, 0]]))


def build(frames: int = 12, fps: float = 120.0, shifts: bool = False, **changes: Any) -> Motion:
    """Smooth turning of three joints, quick enough that Euler angles would take another way."""
    times = np.arange(frames) / (fps or 1.0)
    vectors = np.stack(
        [
            np.stack([np.sin(7 * times), 2 * times, np.cos(5 * times)], axis=-1),
            np.stack([1.5 * np.cos(9 * times), np.sin(4 * times), times], axis=-1),
            np.stack([times, 2 * np.sin(6 * times), np.sin(3 * times)], axis=-1),
        ],
        axis=1,
    )
    parts: dict[str, Any] = {
        "skeleton": SKELETON,
        "rotations": quaternion.from_rotvec(vectors),
        "root_positions": np.stack([times, 1 + 0.1 * np.sin(8 * times), times**2], axis=-1),
        "fps": fps,
    }
    if shifts:
        parts["joint_translations"] = SKELETON.offsets + 0.01 * np.sin(times)[:, None, None]
    return Motion(**(parts | changes))


def far_apart(a: Motion, b: Motion) -> float:
    """Largest angle between their joints, radians."""
    return float(np.max(quaternion.angle(a.rotations, b.rotations)))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rotations": np.ones((12, 2, 4))}, r"`rotations` of shape \(frames, 3, 4\), got \(12, 2, 4\)"),
        ({"rotations": np.ones((12, 12))}, r"`rotations` of shape \(frames, 3, 4\), got \(12, 12\)"),
        ({"rotations": np.ones((0, 3, 4)), "root_positions": np.ones((0, 3))}, "at least one frame"),
        ({"root_positions": np.ones((11, 3))}, r"`root_positions` of shape \(12, 3\), got \(11, 3\)"),
        ({"fps": 0.0}, "frame rate above 0, got 0.0"),
        ({"fps": -30.0}, "frame rate above 0, got -30.0"),
        ({"fps": float("nan")}, "frame rate above 0, got nan"),
        ({"fps": float("inf")}, "frame rate above 0, got inf"),
        ({"joint_translations": np.ones((12, 2, 3))}, r"`joint_translations` of shape \(12, 3, 3\), got \(12, 2, 3\)"),
        ({"joint_translations": np.full((12, 3, 3), np.nan)}, "`joint_translations` is not finite"),
        ({"rotations": np.zeros((12, 3, 4))}, "not zero"),
        ({"root_positions": np.eye(12, 3, -2) * 1e200}, r"root lies 1e\+200 m away in frame 2, beyond any length"),
        ({"joint_translations": np.full((12, 3, 3), 1e13)}, r"`joint_translations` reaches 1e\+13 m"),
    ],
)
def test_each_fault_is_named(changes: dict[str, Any], message: str) -> None:
    """What does not fit is refused with what was expected and what came."""
    with pytest.raises(InputError, match=message):
        build(**changes)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_name_their_frame(bad: float) -> None:
    """The first bad frame is in the message, for rotations and for the root."""
    rotations, roots = build().rotations.copy(), build().root_positions.copy()
    rotations[7, 1, 2] = bad
    roots[[3, 9], 0] = bad
    with pytest.raises(InputError, match="`rotations` is not finite in frame 7"):
        build(rotations=rotations)
    with pytest.raises(InputError, match="`root_positions` is not finite in frame 3"):
        build(root_positions=roots)


def test_quaternions_are_made_unit() -> None:
    """A file's rounding is mended, the rotation kept."""
    motion = build(rotations=build().rotations * 3.0)
    assert_allclose(np.linalg.norm(motion.rotations, axis=-1), 1.0, atol=1e-12)
    assert far_apart(motion, build()) < 1e-12


def test_slicing_keeps_frames_and_rate() -> None:
    """[start:end] has those frames; a step divides the rate; a negative index counts from the end."""
    motion = build(shifts=True)
    part = motion[3:9]
    assert part.frame_count == len(part) == 6
    assert part.fps == 120.0
    assert part.duration == pytest.approx(0.05)
    assert_array_equal(part.rotations, motion.rotations[3:9])
    assert_array_equal(part.joint_translations, motion.joint_translations[3:9])
    assert_array_equal(motion[::4].root_positions, motion.root_positions[::4])
    assert motion[::4].fps == 30.0
    assert_array_equal(motion[-1].rotations, motion.rotations[-1:])
    assert motion[-5:].frame_count == 5


def test_slices_that_leave_nothing_are_refused() -> None:
    """An empty range, a frame that is not there, playing backwards by a step."""
    motion = build()
    with pytest.raises(InputError, match=r"No frame is left of 12 by \[9:3\]"):
        motion[9:3]
    with pytest.raises(InputError, match=r"No frame is left of 12 by \[50:60\]"):
        motion[50:60]
    with pytest.raises(IndexError, match="Frame 12 of a motion of 12 frames"):
        motion[12]
    with pytest.raises(InputError, match=r"kinesics\.reverse"):
        motion[::-1]


def test_a_number_of_numpy_is_an_index_too() -> None:
    """As `np.argmax` gives it."""
    motion = build()
    np.testing.assert_array_equal(motion[np.int64(5)].rotations, motion[5].rotations)


def test_iteration_ends() -> None:
    """A motion can be looped over, one frame at a time."""
    assert [m.frame_count for m in build(frames=3)] == [1, 1, 1]


def test_resampling_down_keeps_coincident_frames_to_the_last_bit() -> None:
    """120 to 30 frames a second is every fourth frame, untouched."""
    motion = build(frames=41, shifts=True)
    down = motion.resample(30.0)
    assert down.fps == 30.0
    assert_array_equal(down.rotations, motion.rotations[::4])
    assert_array_equal(down.root_positions, motion.root_positions[::4])
    assert_array_equal(down.joint_translations, motion.joint_translations[::4])


@pytest.mark.parametrize("frames", [1, 2, 3, 29, 30, 31, 300, 1001])
@pytest.mark.parametrize(("low", "high"), [(30.0, 120.0), (25.0, 100.0), (29.97, 119.88), (60.0, 120.0)])
def test_up_and_down_again_is_the_same(frames: int, low: float, high: float) -> None:
    """30 → 120 → 30 gives back every frame, the last one too."""
    motion = build(frames=frames, fps=low)
    back = motion.resample(high).resample(low)
    assert back.frame_count == motion.frame_count
    assert far_apart(back, motion) < 1e-9
    assert_allclose(back.root_positions, motion.root_positions, atol=1e-12)


@given(st.integers(1, 400), st.floats(1.0, 500.0), st.floats(1.0, 500.0))
def test_resampled_frames_lie_within_the_recording(frames: int, old: float, new: float) -> None:
    """Frame k is at k/fps; the last is at or before the recording's last, and less than a step before it."""
    motion = build(frames=frames, fps=old)
    resampled = motion.resample(new)
    last_old, last_new = (frames - 1) / old, (resampled.frame_count - 1) / new
    assert last_new <= last_old + 1e-6
    if frames > 1:
        assert last_old - last_new < 1.0 / new + 1e-6


def test_between_frames_joints_turn_along_the_shorter_arc_at_constant_rate() -> None:
    """Spherical interpolation: halfway between two frames is half the angle from each, whatever their signs."""
    motion = build(frames=2, fps=4.0)
    flipped = motion.replace(rotations=motion.rotations * np.array([1.0, -1.0])[:, None, None])
    for m in (motion, flipped):
        middle = m.resample(8.0).rotations[1]
        whole = quaternion.angle(m.rotations[0], m.rotations[1])
        assert_allclose(quaternion.angle(m.rotations[0], middle), whole / 2.0, atol=1e-12)
        assert_allclose(quaternion.angle(middle, m.rotations[1]), whole / 2.0, atol=1e-12)


def test_interpolation_does_not_depend_on_the_frame_of_the_angles() -> None:
    """Turning the whole body in the world and resampling commute, which Euler angles would not."""
    motion = build(frames=10, fps=10.0)
    turn = quaternion.from_rotvec(np.array([0.9, 1.7, -0.4]))
    rotations = motion.rotations.copy()
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    turned_first = motion.replace(rotations=rotations).resample(37.0)
    turned_after = motion.resample(37.0).rotations.copy()
    turned_after[:, 0] = quaternion.multiply(turn, turned_after[:, 0])
    assert float(np.max(quaternion.angle(turned_first.rotations, turned_after))) < 1e-9


def test_resampling_one_frame_or_to_the_same_rate_changes_nothing() -> None:
    """One frame is still one frame."""
    assert build(frames=1).resample(30.0).frame_count == 1
    assert build(frames=1).resample(30.0).fps == 30.0
    assert_array_equal(build().resample(120.0).rotations, build().rotations)


def test_resampling_to_more_frames_than_memory_holds_is_refused() -> None:
    """A slip of the keyboard does not stop the machine."""
    with pytest.raises(InputError, match=r"1e\+15 frames a second would make 9.17e\+13 frames of 12"):
        build().resample(1e15)


@pytest.mark.parametrize("fps", [0.0, -1.0, float("nan"), float("inf")])
def test_resampling_to_no_rate_is_refused(fps: float) -> None:
    """The rate is named."""
    with pytest.raises(InputError, match="frame rate above 0"):
        build().resample(fps)


def test_reversed_twice_is_the_same() -> None:
    """§3.2.4: played backwards the last frame comes first; backwards again it is the motion itself."""
    motion = build(shifts=True)
    backwards = reverse(motion)
    assert_array_equal(backwards.rotations[0], motion.rotations[-1])
    assert_array_equal(backwards.positions()[::-1], motion.positions())
    twice = reverse(backwards)
    assert_array_equal(twice.rotations, motion.rotations)
    assert_array_equal(twice.root_positions, motion.root_positions)
    assert_array_equal(twice.joint_translations, motion.joint_translations)
    assert twice.fps == motion.fps


def test_reversal_and_resampling_commute() -> None:
    """Where the last frame falls on the new rate, it does not matter which comes first."""
    motion = build(frames=41)
    a, b = reverse(motion).resample(30.0), reverse(motion.resample(30.0))
    assert_array_equal(a.rotations, b.rotations)


def test_a_motion_does_not_alias_a_caller_who_changes_his_array() -> None:
    """What the caller does to his arrays afterwards does not reach the motion."""
    rotations, roots = build().rotations.copy(), build().root_positions.copy()
    motion = build(rotations=rotations, root_positions=roots)
    before = motion.positions()
    rotations[:] = quaternion.identity((12, 3))
    roots[:] = 7.0
    assert_array_equal(motion.positions(), before)


def test_a_motion_does_not_change() -> None:
    """Neither do its slices, which share its memory: copy an array before changing it."""
    motion = build(shifts=True)
    part = motion[2:6]
    assert np.shares_memory(part.rotations, motion.rotations)
    for m in (motion, part):
        for values in (m.rotations, m.root_positions, m.joint_translations):
            assert values is not None
            with pytest.raises(ValueError, match="read-only"):
                values[0] = 0.0


@pytest.mark.parametrize("new", [60.0, 90.0, 120.0])
def test_between_frames_nothing_jerks(new: float) -> None:
    """A walk kept at 30 frames a second and brought back is where it was to 5 mm, and is accelerated as evenly: it does not
    go in straight lines from frame to frame.
    """
    walk = kx.performer.walk(seconds=3, fps=120, noise_degrees=0.5, noise_kind="smooth", seed=3).motion
    again = walk.resample(30.0).resample(new)
    same = walk.resample(new)[: again.frame_count]
    assert np.abs(again.positions() - same.positions()).max() < 0.005

    def pushed(motion: kx.Motion) -> np.ndarray:
        wrist = motion.skeleton.joint_names.index("LeftHand")
        return np.linalg.norm(np.diff(motion.positions()[:, wrist], 2, axis=0), axis=-1) * new**2

    phase = np.arange(1, again.frame_count - 1) * 30.0 / new % 1.0
    at_frames, between = pushed(again)[phase < 1e-9], pushed(again)[phase > 1e-9]
    assert at_frames.mean() < 1.25 * between.mean()
    assert pushed(again).max() < 1.2 * pushed(same).max()


def test_who_turns_by_half_a_turn_from_frame_to_frame_goes_along_great_circles() -> None:
    """Components of quaternions tell nothing between such frames."""
    motion = build(frames=6, fps=5.0)
    turns = quaternion.from_rotvec(np.outer(np.arange(6), [0.0, 2.5, 0.0]))
    rotations = motion.rotations.copy()
    rotations[:, 0] = turns
    up = motion.replace(rotations=rotations).resample(20.0)
    steps = quaternion.angle(up.rotations[1:, 0], up.rotations[:-1, 0])
    assert_allclose(steps, 2.5 / 4.0, atol=1e-9)
