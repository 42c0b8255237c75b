"""Smoothness of speed curves: textbook cases, and what it must not depend on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics as kx
from kinesics.errors import InputError
from kinesics.grammar import smoothness
from kinesics.grammar.moments import from_poses
from naive import smoothness as naive


def _reach(seconds: float = 1.0, fps: float = 100.0, size: float = 1.0) -> np.ndarray:
    """The speed of a minimum-jerk reach (Flash and Hogan 1985): 30 s² (1 − s)² · size / seconds."""
    s = np.arange(round(seconds * fps) + 1) / round(seconds * fps)
    return size / seconds * 30.0 * s**2 * (1.0 - s) ** 2


def _with_stops(count: int, pause: float = 0.2) -> np.ndarray:
    """So many reaches with pauses between, as submovements of a jerky hand."""
    parts = []
    for k in range(count):
        if k:
            parts.append(np.zeros(round(pause * 100)))
        parts.append(_reach(1.0 / count))
    return np.concatenate(parts)


def test_a_minimum_jerk_reach() -> None:
    """−ln of the closed form: ∫(d²v/dt²)² of 30 s²(1 − s)² is 720, its peak 15/8; the arc length is that of the paper, −1.41."""
    assert smoothness.log_dimensionless_jerk(_reach(), 100.0) == pytest.approx(
        -np.log(720.0 / (15.0 / 8.0) ** 2), abs=0.1
    )
    assert smoothness.sparc(_reach(), 100.0) == pytest.approx(-1.41, abs=0.02)


def test_each_stop_is_less_smooth() -> None:
    """The more submovements with pauses between, the lower both measures."""
    for measure in (smoothness.sparc, smoothness.log_dimensionless_jerk):
        values = [measure(_with_stops(k), 100.0) for k in (1, 2, 3, 4, 5)]
        assert values == sorted(values, reverse=True)
        assert np.diff(values).max() < -0.05


@given(size=st.floats(0.01, 100.0), seconds=st.floats(0.5, 4.0))
def test_size_and_duration_do_not_matter(size: float, seconds: float) -> None:
    """A movement half as large or half as fast is as smooth."""
    seconds = round(seconds, 2)
    assert smoothness.sparc(_reach(seconds, size=size), 100.0) == pytest.approx(-1.41, abs=0.04)
    jerk = smoothness.log_dimensionless_jerk(_reach(seconds, size=size), 100.0)
    assert jerk == pytest.approx(-np.log(720.0 / (15.0 / 8.0) ** 2), abs=0.15)


def test_backwards_it_is_as_smooth(rng: np.random.Generator) -> None:
    """Both measures are the same for the speed curve read from its end."""
    speed = rng.random(150)
    for measure in (smoothness.sparc, smoothness.log_dimensionless_jerk):
        assert measure(speed[::-1], 60.0) == pytest.approx(measure(speed, 60.0))


def test_sampling_rate_hardly_matters() -> None:
    """The arc length of one curve sampled at 30 and at 120 a second differs by a hundredth."""
    fine, coarse = _with_stops(3), _with_stops(3)[::4]
    assert smoothness.sparc(coarse, 25.0) == pytest.approx(smoothness.sparc(fine, 100.0), abs=0.02)


def test_the_plain_sum_agrees(rng: np.random.Generator) -> None:
    """The fast transform gives what the sums written out give."""
    speed = rng.random(23) + 0.2
    assert smoothness.sparc(speed, 30.0) == pytest.approx(naive.sparc(speed.tolist(), 30.0))


def test_a_slow_bow_is_smoother_than_kicks() -> None:
    """On whole bodies: one bow against a sequence of kicks."""
    values = {}
    for name in ("bow", "side_kicks"):
        moments = from_poses(kx.poses(kx.performer.perform(name, fps=60.0, seed=0).motion))
        values[name] = smoothness.of_phrase(moments)
    for measure in ("spectral_arc_length", "log_dimensionless_jerk"):
        assert getattr(values["bow"], measure) > getattr(values["side_kicks"], measure)


def test_of_no_movement_there_is_no_smoothness() -> None:
    """One pose held, and a stretch too short, have none."""
    poses = kx.poses(kx.performer.stand(seconds=2.0, fps=30.0, seed=0).motion)
    held = from_poses(poses[0:1])
    assert smoothness.of_phrase(held) == smoothness.Smoothness(None, None)
    walk = from_poses(kx.poses(kx.performer.walk(seconds=3.0, fps=30.0).motion))
    assert smoothness.of_phrase(walk, 5, 8) == smoothness.Smoothness(None, None)


@pytest.mark.parametrize(
    "speed", [[1.0, 2.0], [0.0] * 9, [1.0, -1.0, 1.0, 2.0], [1.0, float("nan"), 2.0, 3.0], [[1.0] * 5]]
)
def test_what_is_no_speed_is_refused(speed: list[float]) -> None:
    """Too short, all 0, negative, not a number, or not a row."""
    for measure in (smoothness.sparc, smoothness.log_dimensionless_jerk):
        with pytest.raises(InputError, match="speed"):
            measure(speed, 30.0)


def test_parameters_are_checked() -> None:
    """A rate, a cutoff or an amplitude that makes no sense, and a speed without jerk."""
    with pytest.raises(InputError, match="fps"):
        smoothness.sparc(_reach(), 0.0)
    with pytest.raises(InputError, match="cutoff"):
        smoothness.sparc(_reach(), 100.0, cutoff=-1.0)
    with pytest.raises(InputError, match="jerk"):
        smoothness.log_dimensionless_jerk([2.0] * 9, 30.0)
