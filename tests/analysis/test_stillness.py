"""Stillness (§3.2.1): a stay in one neighbourhood, whatever the frame rate and the tempo."""

from __future__ import annotations

import numpy as np
import pytest

import bodies
import kinesics as kx
from kinesics.analysis import find_stillness, stillness_rule
from kinesics.similarity import chord, distance
from naive import pooling as naive


def _steps(
    holds_s: list[float], fps: float, *, move_s: float = 0.5, sway: float = 0.0, jitter: float = 0.0
) -> kx.Motion:
    """The left arm goes to a new height, stays, goes on: smooth moves of 1.2 rad between holds of the given lengths."""
    ease = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, round(move_s * fps), endpoint=False))
    parts, height = [], 0.0
    for k, hold in enumerate(holds_s):
        if k:
            goal = 1.2 if height == 0.0 else 0.0
            parts.append(height + (goal - height) * ease)
            height = goal
        parts.append(np.full(round(hold * fps), height))
    angle = np.concatenate(parts)
    t = np.arange(len(angle)) / fps
    noise = np.random.default_rng(5).normal(0.0, jitter, (len(angle), 3))
    angles = {
        "LeftArm": bodies.about(2, angle) + noise,
        "Spine": bodies.about(0, sway * np.sin(2.0 * np.pi * 0.3 * t)),
        "RightLeg": bodies.about(0, 0.4 * angle),
    }
    return bodies.moving(angles, fps=fps)


@pytest.mark.parametrize("fps", [25.0, 30.0, 60.0, 120.0, 240.0])
def test_holds_are_found_and_moves_are_not(fps: float) -> None:
    """Three holds between smooth moves: three stretches, the same at every frame rate, to the moving ends within ε."""
    poses = kx.poses(_steps([1.5, 2.0, 1.0], fps, sway=0.02))
    found = [(a / fps, b / fps) for a, b in find_stillness(poses)]
    assert len(found) == 3
    np.testing.assert_allclose(found, [(0.0, 1.5), (2.0, 4.0), (4.5, 5.5)], atol=0.2 + 1.0 / fps)


def test_a_slower_performance_has_the_same_stillness() -> None:
    """Played at half and at a fifth of the speed the stretches are the same frames: slow is not still."""
    motion = _steps([1.5, 2.0, 1.0], 60.0)
    usual = find_stillness(kx.poses(motion))
    for tempo in (0.5, 0.2):
        assert find_stillness(kx.poses(motion.replace(fps=60.0 * tempo))) == usual


def test_all_pairs_of_a_stretch_are_near() -> None:
    """The definition itself, checked with loops; and a frame more on either side would break it or end the recording."""
    poses = kx.poses(_steps([0.8, 1.0], 30.0, sway=0.03))
    rule = stillness_rule(poses)
    distances = chord(distance(poses, poses)).astype(np.float32)
    stretches = find_stillness(poses, rule)
    assert stretches
    for start, end in stretches:
        assert end - start > rule.minimum_s * poses.fps
        assert naive.still_everywhere(distances, start, end, rule.epsilon)
        if end < len(poses):
            assert not naive.still_everywhere(distances, start, end + 1, rule.epsilon)


@pytest.mark.parametrize("period", [0.8, 2.0, 8.0, 30.0])
def test_a_turn_is_not_a_stay(period: float) -> None:
    """A swinging arm stops for a moment at either end, however slowly it swings: that is a reversal, not stillness."""
    frames = round(4 * period * 60)
    assert find_stillness(kx.poses(bodies.arms_swinging(frames, fps=60.0, period=period))) == []


def test_uniform_slow_movement_is_not_still() -> None:
    """An arm that rises at one slow speed for twenty seconds never stays anywhere."""
    poses = kx.poses(bodies.moving({"LeftArm": bodies.about(2, np.linspace(-1.0, 1.5, 1200))}))
    assert find_stillness(poses) == []


def test_jitter_of_the_sensor_does_not_hide_a_hold() -> None:
    """With half a degree of noise on the arm the hold is still one hold."""
    poses = kx.poses(_steps([0.5, 2.0, 0.5], 120.0, jitter=np.deg2rad(0.5)))
    assert any(b - a >= 1.8 * 120 for a, b in find_stillness(poses))


def test_a_body_that_never_moves_is_still_throughout() -> None:
    """However short the recording; one single frame is no stretch."""
    for frames in (2, 5, 500):
        assert find_stillness(kx.poses(bodies.moving({"Spine": np.zeros((frames, 3))}))) == [(0, frames)]
    assert find_stillness(kx.poses(bodies.moving({"Spine": np.zeros((1, 3))}))) == []


def test_a_long_stay_is_sampled_and_still_found() -> None:
    """Ten thousand still frames between two moves are one stretch, though not all their pairs are compared."""
    poses = kx.poses(_steps([0.2, 83.3, 0.2], 120.0))
    assert max(b - a for a, b in find_stillness(poses)) >= 83 * 120


def test_weights_decide_what_counts_as_moving() -> None:
    """If only the legs count, a waving arm leaves the body still."""
    poses = kx.poses(bodies.arms_swinging(240))
    assert find_stillness(poses) == []
    assert find_stillness(poses, weights={link: 0.0 for link in kx.vocabulary.LINKS if "femur" not in link}) == [
        (0, 240)
    ]


@pytest.mark.parametrize("movement", ["kata", "sun_salutation", "throw", "raise_arms", "stand"])
def test_the_performer_s_holds_are_found(movement: str) -> None:
    """Every hold that lasts as long as the rule asks is covered in its middle, most shorter ones too; nothing else is still."""
    performed = getattr(kx.performer, movement)(fps=30.0)
    true = performed.truth.stillness
    assert true
    poses = kx.poses(performed.motion)
    found = find_stillness(poses)
    covered = [any(a <= (r.start + r.end) // 2 < b for a, b in found) for r in true]
    least = stillness_rule(poses).minimum_s * poses.fps
    assert all(c for c, r in zip(covered, true, strict=True) if r.end - r.start > least)
    assert sum(covered) >= 0.85 * len(true)
    assert all(any(a < r.end and r.start < b for r in true) for a, b in found)


@pytest.mark.parametrize(
    "movement", ["walk", "run", "jumping_jacks", "squat", "wave", "butterfly", "arm_circles", "twist"]
)
def test_the_performer_s_cycles_have_no_stillness(movement: str) -> None:
    """Movement that goes on without a stop has no stay, though it turns and slows down."""
    assert find_stillness(kx.poses(getattr(kx.performer, movement)().motion)) == []
