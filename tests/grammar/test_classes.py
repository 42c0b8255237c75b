"""The symmetry class: of every movement the performer knows, under every condition that must not change it."""

from __future__ import annotations

import csv
import zipfile
from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from kinesics.grammar import classes, moments
from kinesics.grammar.classes import Verdict
from kinesics.vocabulary import FRIEZE_GROUPS, MovementClass

C = MovementClass

EXAMPLES = {
    "limp": C.CYCLIC_ASYMMETRIC,
    "walk": C.CYCLIC_ANTIPHASE,
    "run": C.CYCLIC_ANTIPHASE,
    "butterfly": C.CYCLIC_SYMMETRIC,
    "wave": C.CYCLIC_PALINDROMIC,
    "arm_circles": C.CYCLIC_ANTIPALINDROMIC,
    "jog_in_place": C.CYCLIC_ANTIPHASE_PALINDROMIC,
    "twist": C.CYCLIC_ANTIPHASE_PALINDROMIC,
    "jumping_jacks": C.CYCLIC_SYMMETRIC_PALINDROMIC,
    "squat": C.CYCLIC_SYMMETRIC_PALINDROMIC,
    "wave_both": C.CYCLIC_SYMMETRIC_PALINDROMIC,
    "throw": C.ASYMMETRIC,
    "raise_arms": C.SYMMETRIC,
    "reach": C.PALINDROMIC,
    "sway": C.ANTIPALINDROMIC,
    "bow": C.SYMMETRIC_PALINDROMIC,
    "stand": C.STILL,
}


def _classify(motion: kx.Motion) -> Verdict:
    return classes.classify(moments.from_poses(kx.poses(motion)))


def test_the_examples_show_every_class():
    """All 13 classes are tested below."""
    assert set(EXAMPLES.values()) == set(MovementClass)


@pytest.mark.parametrize("name", EXAMPLES)
@pytest.mark.parametrize(("fps", "seed"), [(30, 1), (120, 2)])
def test_every_class_is_recognised_under_noise_and_uneven_tempo(name: str, fps: float, seed: int):
    """1° of noise and 5 % of jitter change nothing, and the verdict is confident."""
    extra = {} if name == "stand" else {"tempo_jitter": 0.05}
    v = _classify(kx.performer.perform(name, fps=fps, noise_degrees=1.0, seed=seed, **extra).motion)
    assert v.class_ is EXAMPLES[name]
    assert v.confidence > 0.7
    assert v.runner_up is not v.class_
    assert v.group == FRIEZE_GROUPS.get(EXAMPLES[name])
    assert (v.period_s is None) is (v.group is None)
    assert (len(v.cycles) > 0) is (v.group is not None)


@pytest.mark.parametrize(
    "name", ["walk", "limp", "wave", "jumping_jacks", "arm_circles", "butterfly", "throw", "sway", "bow"]
)
def test_mirrored_reversed_turned_taller_resampled_it_stays_what_it_is(name: str):
    """What is done to the recording and not to the movement changes neither the class nor the period by 1 %."""
    given = {"noise_degrees": 0.5, "seed": 3}
    p = kx.performer.perform(name, fps=120, **given)
    v = _classify(p.motion)
    others = {
        "mirrored": kx.mirror(p.motion),
        "reversed": kx.reverse(p.motion),
        "every fourth frame": p.motion.resample(30.0),
        "turned": kx.performer.perform(name, fps=120, facing_degrees=70, **given).motion,
        "taller": kx.performer.perform(name, fps=120, body=2.0, **given).motion,
    }
    for what, motion in others.items():
        w = _classify(motion)
        assert w.class_ is v.class_ is EXAMPLES[name], what
        if v.period_s is not None:
            assert w.period_s == pytest.approx(v.period_s, rel=0.01), what


@pytest.mark.parametrize("degrees", [15, 30, 42])
@pytest.mark.parametrize("name", ["walk", "jumping_jacks", "jog_in_place"])
def test_a_crooked_rig_does_not_make_a_limp(name: str, degrees: float):
    """A constant difference of left and right is reported, and does not change the class."""
    v = _classify(kx.performer.perform(name, fps=30, asymmetry_degrees=degrees, noise_degrees=0.5, seed=1).motion)
    assert v.class_ is EXAMPLES[name]
    assert v.bias is not None
    assert v.bias.largest_degrees == pytest.approx(degrees, abs=2.5)
    assert (v.residuals_biased.mirror_reverse or 0) > (v.residuals.mirror_reverse or 0)


def test_a_crooked_rig_does_not_hide_a_limp():
    """Taking the constant difference out leaves the uneven steps."""
    for degrees in (0, 20, 40):
        v = _classify(kx.performer.limp(fps=30, seed=1, asymmetry_degrees=degrees, noise_degrees=0.5).motion)
        assert v.class_ is C.CYCLIC_ASYMMETRIC


@pytest.mark.parametrize("name", ["walk", "twist", "squat", "wave"])
def test_cyclic_from_two_periods_and_for_halves_from_a_little_less(name: str):
    """1.75 periods of alternating or palindromic movement are cyclic; 1.3 are not."""
    p = kx.performer.perform(name, fps=60, seed=1)
    assert p.truth.period_s is not None
    period = p.truth.period_s * 60
    for periods, cyclic in ((2.3, True), (1.75, True), (1.3, False)):
        v = _classify(p.motion[: round(periods * period)])
        assert (v.group is not None) is cyclic, (periods, v)


def test_less_than_two_periods_of_one_limp_are_not_a_cycle():
    """What is not made of halves needs two full periods."""
    p = kx.performer.limp(fps=60, seed=1)
    assert p.truth.period_s is not None
    assert _classify(p.motion[: round(1.7 * p.truth.period_s * 60)]).group is None


def test_noise_is_no_movement():
    """A body that stands still under 2° of noise has no class but stillness, whatever the noise repeats by chance."""
    v = _classify(kx.performer.stand(seconds=4, fps=60, noise_degrees=2, seed=5).motion)
    assert v.class_ is C.STILL
    assert v.period_s is None
    assert v.cycles == ()


def test_a_moment_is_too_short_to_tell():
    """Five frames have no class; the reason is given."""
    v = _classify(kx.performer.walk(seconds=3, fps=30, seed=1).motion[:5])
    assert v.class_ is None
    assert v.confidence == 0.0
    assert "too short" in v.reasons[0]


def test_one_cyclic_movement_after_another_is_not_cyclic():
    """Kicks to the left and then kicks to the right are no one cycle."""
    assert _classify(kx.performer.side_kicks(fps=30, seed=1).motion).group is None


def test_a_part_of_a_recording_is_judged_by_itself():
    """The wave within raise, wave and lower has the class of a wave; and so has the whole, which is mostly waving."""
    m = moments.from_poses(kx.poses(kx.performer.wave(seconds=9, fps=30, seed=1).motion))
    part = classes.classify(m, 60, 200)
    assert part.class_ is C.CYCLIC_PALINDROMIC
    assert all(60 <= c.start < c.end <= 200 for c in part.cycles)


def test_distances_without_poses_are_enough():
    """Silhouettes and gestures have D and D* only: the class comes out the same, without a bias."""
    m = moments.from_poses(kx.poses(kx.performer.jumping_jacks(seconds=6, fps=30, seed=1).motion))
    v = classes.classify(moments.from_distances(*m.block(), 30.0))
    assert v.class_ is C.CYCLIC_SYMMETRIC_PALINDROMIC
    assert v.bias is None
    assert all(c.phase is None for c in v.cycles)


def test_a_long_recording_does_not_need_all_pairs(monkeypatch: pytest.MonkeyPatch):
    """No tile larger than a band of lags is asked for."""
    m = moments.from_poses(kx.poses(kx.performer.walk(seconds=200, fps=30, seed=1).motion))
    largest = 0
    real = moments.Moments.tile

    def watched(self: moments.Moments, rows: slice, cols: slice) -> tuple[moments.Floats, moments.Floats]:
        nonlocal largest
        d, mirrored = real(self, rows, cols)
        largest = max(largest, d.size)
        return d, mirrored

    monkeypatch.setattr(moments.Moments, "tile", watched)
    v = classes.classify(m)
    assert v.class_ is C.CYCLIC_ANTIPHASE
    assert largest < m.count**2 / 2


def test_probabilities_are_those_of_groups():
    """Each group needs its symmetries and none of the others; the classes of one kind share all probability."""
    v = _classify(kx.performer.walk(seconds=6, fps=30, noise_degrees=1, seed=1).motion)
    assert sum(v.probabilities.values()) == pytest.approx(1.0)
    assert set(v.probabilities) == set(classes.CYCLIC_SYMMETRIES)
    assert v.probabilities[C.CYCLIC_ANTIPHASE] == v.confidence
    odds = {"mirror": -9.0, "glide": 9.0, "reverse": -9.0, "mirror_reverse": -9.0}
    alone = classes._of_groups(odds, classes.CYCLIC_SYMMETRIES, 1.0)
    assert max(alone, key=lambda c: alone[c]) is C.CYCLIC_ANTIPHASE
    assert alone[C.CYCLIC_ANTIPHASE] > 0.99


REAL = [
    ("dataset-2_walk_active_001.bvh", C.CYCLIC_ANTIPHASE),
    ("dataset-2_run_normal_003.bvh", C.CYCLIC_ANTIPHASE),
    ("dataset-2_wave-left-hand_active_003.bvh", C.CYCLIC_PALINDROMIC),
    ("dataset-2_wave-both-hands_active_002.bvh", C.CYCLIC_SYMMETRIC_PALINDROMIC),
    ("dataset-2_raise-up-right-hand_normal_004.bvh", C.PALINDROMIC),
    ("dataset-2_raise-up-both-hands_normal_004.bvh", C.SYMMETRIC_PALINDROMIC),
]


@pytest.mark.parametrize(("clip", "expected"), REAL)
def test_real_recordings_under_what_must_not_change_them(
    shared_data: Path, tmp_path: Path, clip: str, expected: MovementClass
):
    """A real clip has the class it is labelled with, mirrored and reversed too, with the same period."""
    with (shared_data / "bandai-namco" / "labels.tsv").open(encoding="utf-8") as lines:
        labels = {r["file"]: r["expected_class"] for r in csv.DictReader(lines, delimiter="\t")}
    assert labels[clip] == expected.value
    with zipfile.ZipFile(shared_data / "bandai-namco" / "clips.zip") as archive:
        inside = next(name for name in archive.namelist() if Path(name).name == clip)
        (tmp_path / clip).write_bytes(archive.read(inside))
    motion = kx.read(tmp_path / clip)
    v = _classify(motion)
    assert v.class_ is expected
    for other in (kx.mirror(motion), kx.reverse(motion)):
        w = _classify(other)
        assert w.class_ is expected
        if v.period_s is not None:
            assert w.period_s == pytest.approx(v.period_s, rel=0.01)
    assert np.isfinite(v.confidence)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_choreography_is_no_cycle(seed: int) -> None:
    """The long phrases of a kata, in which guards and techniques return in parts, are neither cyclic nor palindromes."""
    seen = kx.performer.kata(fps=30, seed=seed, noise_degrees=0.2, noise_kind="smooth")
    m = moments.from_poses(kx.poses(seen.motion))
    for start, end in ((4.7, 24.8), (28.2, 48.0), (5.0, 24.0)):
        verdict = classes.classify(m, m.moment_of(start * 30.0), m.moment_of(end * 30.0))
        assert verdict.class_ is C.ASYMMETRIC


def test_a_reversal_takes_the_same_way_at_any_speed() -> None:
    """Who bows slowly and rises four times as fast makes a palindrome; bowing alone is none."""
    seen = kx.performer.bow(fps=120, seed=0)
    poses = kx.poses(seen.motion)
    half = len(poses) // 2
    uneven = np.concatenate([np.arange(half), np.arange(half, len(poses), 4)])
    bent = kx.PoseSequence(poses.quaternions[uneven], poses.yaw[uneven], poses.ground[uneven], 120.0)
    assert classes.classify(moments.from_poses(bent)).class_ is C.SYMMETRIC_PALINDROMIC
    assert classes.classify(moments.from_poses(poses[:half])).class_ is C.SYMMETRIC
