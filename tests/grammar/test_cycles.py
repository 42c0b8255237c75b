"""Cycles one by one: where they begin, how long they are, what left and right do."""

from __future__ import annotations

import numpy as np
import pytest

import kinesics as kx
from kinesics.grammar import bias, classes, cycles, evidence, moments


def _verdict(motion: kx.Motion) -> classes.Verdict:
    return classes.classify(moments.from_poses(kx.poses(motion)))


@pytest.mark.parametrize(
    ("name", "fps"), [("walk", 120), ("run", 60), ("jumping_jacks", 30), ("squat", 30), ("wave", 60)]
)
def test_cycles_are_as_long_as_they_are(name: str, fps: float):
    """Without jitter every cycle has the true period to a third of a frame at 30, and the mean to 1 %."""
    p = kx.performer.perform(name, seconds=8, fps=fps, seed=1)
    v = _verdict(p.motion)
    assert p.truth.period_s is not None
    assert v.period_s == pytest.approx(p.truth.period_s, rel=0.01)
    assert len(v.cycles) in (int(8 / p.truth.period_s) - 1, int(8 / p.truth.period_s))
    for c in v.cycles:
        assert c.period_s == pytest.approx(p.truth.period_s, abs=1.0 / 60)


def test_cycles_of_uneven_tempo_are_told_one_by_one():
    """The period of every cycle is that of the score, which makes some longer and some shorter."""
    p = kx.performer.jumping_jacks(seconds=12, fps=60, tempo_jitter=0.1, seed=4)
    v = _verdict(p.motion)
    true = np.array(p.truth.cycles) / 60.0
    assert len(v.cycles) >= 8
    for c in v.cycles:
        # phases lie evenly between the boundaries of the score
        begins, ends = np.interp([c.start / 60.0, c.end / 60.0], true, np.arange(len(true)))
        if c.end / 60.0 <= true[-1]:
            assert ends - begins == pytest.approx(1.0, abs=0.06)
    assert v.stability is not None
    assert 0.04 < v.stability.period_deviation < 0.2
    assert v.stability.residual < 0.02


def test_cycles_follow_each_other():
    """Each begins where the last one ended, within the recording."""
    p = kx.performer.walk(seconds=9, fps=120, tempo_jitter=0.05, seed=2)
    v = _verdict(p.motion)
    assert all(a.end == b.start for a, b in zip(v.cycles[:-1], v.cycles[1:], strict=True))
    assert v.cycles[0].start >= 0
    assert v.cycles[-1].end <= p.motion.frame_count


def test_a_cycle_begins_where_the_movement_is_slowest():
    """The squat's cycles begin standing up or down below, where it is slow, not on the way."""
    p = kx.performer.squat(seconds=10, fps=60, seed=1)
    m = moments.from_poses(kx.poses(p.motion))
    v = classes.classify(m)
    median = float(np.median(m.speed))
    assert all(m.speed[m.moment_of(c.start)] < 0.5 * median for c in v.cycles)


def test_an_even_walk_has_phase_zero_and_a_limp_has_not():
    """The stiff leg of a limp comes early or late by the same share in every cycle; the sign turns in the mirror."""
    even = _verdict(kx.performer.walk(seconds=8, fps=60, seed=1).motion)
    assert all(c.phase == pytest.approx(0.0, abs=0.01) for c in even.cycles)
    limp = kx.performer.limp(seconds=10, fps=60, degree=1.0, seed=1)
    phases = [c.phase for c in _verdict(limp.motion).cycles]
    mirrored = [c.phase for c in _verdict(kx.mirror(limp.motion)).cycles]
    assert min(abs(p) for p in phases if p is not None) > 0.02
    assert np.mean([p for p in phases if p is not None]) == pytest.approx(
        -np.mean([p for p in mirrored if p is not None]), abs=0.01
    )


def test_one_hand_has_no_phase():
    """A hand that waves beside one that hangs is neither early nor late."""
    v = _verdict(kx.performer.wave(seconds=6, fps=60, seed=1).motion)
    assert len(v.cycles) >= 4
    assert all(c.phase is None for c in v.cycles)
    assert all(c.mirror_residual is not None and c.mirror_residual > 1.0 for c in v.cycles)


def test_a_constant_difference_of_the_sides_is_measured_and_taken_out():
    """The estimate tells the degrees the performer was given, D stays what it was, D* becomes that of an even body."""
    straight = moments.from_poses(kx.poses(kx.performer.walk(seconds=8.8, fps=30, seed=1).motion))
    bent = moments.from_poses(kx.poses(kx.performer.walk(seconds=8.8, fps=30, seed=1, asymmetry_degrees=30).motion))
    found = bias.estimate(bent)
    assert found is not None
    assert found.degrees["radius"] == pytest.approx(30.0, abs=1.5)
    assert found.degrees["humerus"] == pytest.approx(30.0, abs=1.5)
    assert found.degrees["femur"] == pytest.approx(30.0, abs=1.5)
    assert found.degrees["thorax"] < 1.0
    assert found.largest_degrees == pytest.approx(30.0, abs=1.5)
    mended = bias.without(bent, found)
    for a, b in zip(mended.block(0, 100), (bent.block(0, 100)[0], straight.block(0, 100)[1]), strict=True):
        assert np.abs(a - b).max() < 2e-3


def test_a_raised_arm_is_a_posture_and_no_bias():
    """A difference too large for any rig stays with the movement."""
    m = moments.from_poses(kx.poses(kx.performer.wave(seconds=6, fps=30, seed=1).motion))
    found = bias.estimate(m)
    assert found is not None
    assert "humerus" in found.kept
    assert np.array_equal(found.rotations[9], [1.0, 0.0, 0.0, 0.0])


def test_an_arm_that_goes_all_the_way_round_has_no_average():
    """Averages of full circles are not used as a bias."""
    m = moments.from_poses(kx.poses(kx.performer.arm_circles(seconds=8.4, fps=30, seed=1).motion))
    found = bias.estimate(m)
    assert found is not None
    assert "humerus" in found.kept


def test_folding_a_movement_is_what_trying_all_finds(rng: np.random.Generator):
    """Dynamic time warping from both ends inwards costs what the recursion says."""
    from naive import grammar as naive

    for n in (4, 5, 7):
        d = rng.uniform(size=(n, n))
        d = d + d.T
        weight = rng.uniform(0.1, 1.0, n)
        assert evidence.folded(d, weight)[0] == pytest.approx(naive.folded(d, weight))


def test_window_means_by_lag_are_those_of_all_pairs(rng: np.random.Generator):
    """The mean over a window needs no matrix of it."""
    from kinesics.grammar import lags
    from naive import grammar as naive

    d = rng.uniform(size=(20, 20))
    d = d + d.T
    np.fill_diagonal(d, 0.0)
    by_lag = lags.diagonals(d, 12)
    for start, width in ((0, 5), (7, 10), (12, 8)):
        assert evidence._window_mean(by_lag, start, width) == pytest.approx(naive.window_mean(d, start, width))


def test_fractional_lags_tell_a_period_between_two_frames():
    """A swing of 20.4 moments is not taken for 20."""
    t = np.arange(200.0)
    x = np.stack([np.cos(2 * np.pi * t / 20.4), np.sin(2 * np.pi * t / 20.4)], axis=1)
    d = ((x[:, None] - x[None]) ** 2).sum(-1)
    by_lag = np.full((40, 200), np.inf)
    for k in range(40):
        by_lag[k, : 200 - k] = np.diagonal(d, k)
    found = cycles.fractional_lags(by_lag, np.full(170, 20))
    assert found.mean() == pytest.approx(20.4, abs=0.02)
