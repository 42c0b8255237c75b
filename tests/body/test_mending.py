"""Frames in which the capture leaps away and back are bridged; no movement, however quick, is touched."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics as kx
from bodies import about, moving, rounds
from kinesics.body.mending import ALL_AWAY, AS_BEFORE, AWAY, leaps_away, mended
from kinesics.body.motion import Motion
from kinesics.geometry import quaternion
from naive import mending as naive


def turned(motion: Motion, first: int, past: int, joint: str, angle: float) -> Motion:
    """With a joint turned aside in some frames."""
    rotations = motion.rotations.copy()
    number = motion.skeleton.joint_index[joint]
    aside = quaternion.from_rotvec(np.array([0.0, 0.0, angle]))
    rotations[first:past, number] = quaternion.multiply(rotations[first:past, number], aside)
    return motion.replace(rotations=rotations)


@pytest.mark.parametrize("length", [1, 2, 3, 4])
@pytest.mark.parametrize("first", [1, 200])
def test_what_leaps_away_and_back_is_bridged(first: int, length: int) -> None:
    """Nearly as it was; no other frame is changed, nor the recording itself; and it is told."""
    sound = rounds(4.0, fps=120.0)
    leaping = turned(sound, first, first + length, "LeftArm", 0.2)
    before = leaping.rotations.copy()
    found = mended(leaping)
    assert np.flatnonzero(found.frames).tolist() == list(range(first, first + length))
    assert np.linalg.norm(found.motion.positions() - sound.positions(), axis=-1).max() < 0.002
    np.testing.assert_array_equal(found.motion.rotations[~found.frames], sound.rotations[~found.frames])
    np.testing.assert_array_equal(found.motion.root_positions, sound.root_positions)
    np.testing.assert_array_equal(leaping.rotations, before)
    leg = sound.skeleton.joint_index["LeftLeg"]
    np.testing.assert_array_equal(found.motion.rotations[:, leg], sound.rotations[:, leg])
    assert found.joints[0] in ("LeftHand", "LeftForeArm")
    told = str(found)
    assert told.startswith(
        f"{length} frame{'s'[: length != 1]} mended, in which the capture leaps away and back by up to "
    )
    assert f"by up to {100 * found.away:.0f} cm" in told


def test_what_leaps_as_a_whole_is_bridged_with_its_place() -> None:
    """The root, three centimetres up for two frames."""
    sound = rounds(3.0, fps=120.0)
    roots = sound.root_positions.copy()
    roots[100:102, 1] += 0.03
    found = mended(sound.replace(root_positions=roots))
    assert np.flatnonzero(found.frames).tolist() == [100, 101]
    assert np.abs(found.motion.root_positions - sound.root_positions).max() < 0.002


def test_joints_that_are_shifted_are_bridged_too() -> None:
    """Of rigs whose joints move in their parents."""
    sound = rounds(3.0, fps=120.0)
    shifts = np.repeat(sound.skeleton.offsets[None], sound.frame_count, axis=0)
    steady = sound.replace(joint_translations=shifts)
    leaping = shifts.copy()
    leaping[150, sound.skeleton.joint_index["LeftHand"]] *= 1.3
    found = mended(sound.replace(joint_translations=leaping))
    assert np.flatnonzero(found.frames).tolist() == [150]
    assert np.linalg.norm(found.motion.positions() - steady.positions(), axis=-1).max() < 0.002


@pytest.mark.parametrize("name", kx.performer.NAMES)
def test_no_synthetic_movement_is_touched(name: str) -> None:
    """The very same motion comes back, and nothing is told."""
    make = getattr(kx.performer, name)
    motion = (make(fps=120) if name == "kata" else make(seconds=6, fps=120)).motion
    found = mended(motion)
    assert found.motion is motion
    assert str(found) == ""


@pytest.mark.parametrize("fps", [60.0, 100.0, 120.0, 240.0, 480.0])
@pytest.mark.parametrize("rebound", [0.0, 0.3, 1.0])
def test_a_blow_is_no_glitch(fps: float, rebound: float) -> None:
    """An arm that strikes within a tenth of a second, is stopped dead by what it hits, or thrown back at once."""
    t = np.arange(round(2.0 * fps)) / fps
    for hit in (1.0, 1.0 + 0.5 / fps):
        since = t - hit
        coming = np.clip(since / 0.1 + 1.0, 0.0, 1.0) ** 2
        back = rebound * np.clip(since / 0.1, 0.0, 1.0)
        motion = moving({"LeftArm": about(1, 2.0 * coming - np.where(since > 0.0, 2.0 * back, 0.0))}, fps=fps)
        found = mended(motion)
        assert not found.frames.any()


def test_what_stays_or_comes_back_late_is_left() -> None:
    """That is no matter of some frames; and at 30 frames a second even one is too long to tell."""
    sound = rounds(4.0, fps=120.0)
    for past in (206, 480):
        assert not mended(turned(sound, 200, past, "LeftArm", 0.2)).frames.any()
    assert not mended(turned(rounds(4.0), 50, 51, "LeftArm", 0.2)).frames.any()


def test_what_is_hardly_seen_is_left() -> None:
    """Less than a centimetre and a half."""
    assert not mended(turned(rounds(4.0, fps=120.0), 200, 201, "LeftHand", 0.05)).frames.any()


@given(st.integers(0, 2**32 - 1), st.integers(1, 5))
def test_leaps_are_where_the_obvious_twin_finds_them(seed: int, length: int) -> None:
    """Of ways that leap here and there, at their ends too."""
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.normal(0.0, 0.004, (24, 3, 3)), axis=0)
    for _ in range(4):
        begin = int(rng.integers(0, 24))
        points[begin : begin + int(rng.integers(1, 6)), rng.integers(0, 3)] += rng.normal(0.0, 0.03, 3)
    np.testing.assert_allclose(
        leaps_away(points, length), naive.leaps_away(points, length, AWAY, AS_BEFORE, ALL_AWAY), atol=1e-12
    )


@pytest.mark.parametrize(
    ("recording", "most"),
    [("135/135_11", 3), ("86/86_01", 10), ("02/02_01", 0), ("13/13_30", 0), ("14/14_06", 5), ("49/49_18", 6)],
)
def test_kicks_punches_and_leaps_stay_as_they_were(shared_data: Path, recording: str, most: int) -> None:
    """A handful of frames of thousands; whoever looks at them sees what no body does: centimetres there and back."""
    motion = kx.read(shared_data / "cmu" / f"{recording}.amc")
    found = mended(motion)
    assert int(found.frames.sum()) <= most
    np.testing.assert_array_equal(found.motion.rotations[~found.frames], motion.rotations[~found.frames])
    feet = [motion.skeleton.joint_index[name] for name in ("lfoot", "rfoot", "ltibia", "rtibia")]
    speed = np.linalg.norm(np.gradient(motion.positions()[:, feet], axis=0), axis=-1) * motion.fps
    quick = speed.max(axis=1) > 6.0
    moved = np.linalg.norm((found.motion.positions() - motion.positions())[:, feet], axis=-1)
    assert moved[quick].max(initial=0.0) == 0.0


def test_wrists_that_leap_are_mended(shared_data: Path) -> None:
    """The first frames of 16_35, in which the whole body above the hips trembles."""
    motion = kx.read(shared_data / "cmu" / "16" / "16_35.amc")
    found = mended(motion)
    assert {4, 5, 6, 7} <= set(np.flatnonzero(found.frames).tolist())
    wrist = motion.skeleton.joint_index["rwrist"]
    steps, were = (
        np.linalg.norm(np.diff(m.positions()[4:10, wrist], 2, axis=0), axis=-1).max() for m in (found.motion, motion)
    )
    assert were > 0.025
    assert steps < 0.5 * were
