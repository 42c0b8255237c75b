"""Phrases: found where exercises change, the same under mirror, reversal and frame rate."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

import kinesics as kx
from kinesics.body.pose import PoseSequence
from kinesics.geometry import quaternion
from kinesics.grammar import phrases, whole
from kinesics.grammar.moments import Moments, from_distances, from_poses
from kinesics.grammar.phrases import crossing
from naive import phrases as naive

FPS = 30.0
_NEAR = 15
"""Half a second."""


def medley(names: Sequence[str], seconds: float = 7.0, fps: float = FPS) -> tuple[PoseSequence, list[int]]:
    """Movements of the performer one after another with half a second from each to the next, and the borders in frames."""
    parts: list[np.ndarray] = []
    borders = []
    count = 0
    for k, name in enumerate(names):
        once = name in ("throw", "raise_arms", "reach", "sway", "bow")
        performance = kx.performer.perform(
            name, seed=k, fps=fps, noise_degrees=1.0, **({} if once else {"seconds": seconds})
        )
        q = kx.poses(performance.motion).quaternions
        if parts:
            steps = round(0.5 * fps)
            t = np.linspace(0.0, 1.0, steps + 2)[1:-1]
            t = t * t * (3.0 - 2.0 * t)
            ends = [np.broadcast_to(p, (steps, 15, 4)) for p in (parts[-1][-1], q[0])]
            parts.append(quaternion.slerp(ends[0], ends[1], t[:, None]))
            borders.append(count + steps // 2)
            count += steps
        parts.append(q)
        count += len(q)
    return sequence(np.concatenate(parts), fps), borders


def sequence(q: np.ndarray, fps: float = FPS) -> PoseSequence:
    """Poses without a place."""
    return PoseSequence(quaternions=q, yaw=np.zeros(len(q)), ground=np.zeros((len(q), 2)), fps=fps)


def inner_borders(found: Sequence[phrases.Phrase]) -> list[int]:
    """Where one phrase ends and the next begins."""
    return [p.start for p in found[1:]]


MEDLEYS = (
    ("jumping_jacks", "twist", "squat", "walk"),
    ("wave", "arm_circles", "jumping_jacks", "butterfly"),
    ("squat", "wave_both", "run"),
)


@pytest.fixture(scope="module")
def exercises() -> tuple[PoseSequence, list[int]]:
    """Four exercises, the first one once more at the end."""
    return medley((*MEDLEYS[0], "jumping_jacks"))


@pytest.mark.parametrize("names", MEDLEYS)
def test_exercises_are_told_apart(names: Sequence[str]) -> None:
    """One phrase for each movement, borders within half a second, all of different kinds."""
    poses, borders = medley(names)
    found = phrases.find_phrases(from_poses(poses))
    assert len(found) == len(names)
    assert np.abs(np.subtract(inner_borders(found), borders)).max() <= _NEAR
    assert len({p.kind for p in found}) == len(names)
    assert all(p.recurs for p in found)


def test_a_throw_between_exercises_is_a_phrase() -> None:
    """What is done once is cut out too: the fastest moment of the throw lies in a phrase of its own."""
    poses, borders = medley(("squat", "throw", "wave_both"))
    moments = from_poses(poses)
    found = phrases.find_phrases(moments)
    assert len(found) == 3
    thrown = borders[0] + int(np.argmax(moments.speed[borders[0] : borders[1]]))
    assert found[1].start < thrown < found[1].end
    assert abs(found[1].end - borders[1]) <= _NEAR


def test_what_is_done_again_later_is_of_the_same_kind(exercises: tuple[PoseSequence, list[int]]) -> None:
    """Jumping jacks at the beginning and at the end have one number, what lies between others."""
    found = phrases.find_phrases(from_poses(exercises[0]))
    kinds = [p.kind for p in found]
    assert kinds == [0, 1, 2, 3, 0]


def test_phrases_tile_the_recording(exercises: tuple[PoseSequence, list[int]]) -> None:
    """They follow one another without gaps from the first moment to the last, whatever is cut from the recording."""
    poses = exercises[0]
    for end in (1, 2, 3, 7, 40, 100, 333, len(poses)):
        moments = from_poses(poses[:end])
        found = phrases.find_phrases(moments)
        assert [found[0].start, *(p.end for p in found)] == [*(p.start for p in found), moments.count]
        assert all(p.end > p.start for p in found)


def test_mirror_changes_nothing(exercises: tuple[PoseSequence, list[int]]) -> None:
    """The mirrored recording has the same phrases to the moment."""
    poses = exercises[0]
    assert phrases.find_phrases(from_poses(poses.mirror())) == phrases.find_phrases(from_poses(poses))


def test_backwards_the_phrases_are_turned(exercises: tuple[PoseSequence, list[int]]) -> None:
    """Played backwards the borders are the same, counted from the other end, to a third of a second."""
    poses = exercises[0]
    there = inner_borders(phrases.find_phrases(from_poses(poses)))
    back = inner_borders(phrases.find_phrases(from_poses(poses[::-1])))
    np.testing.assert_allclose([len(poses) - b for b in reversed(back)], there, atol=10)


def test_frame_rate_changes_nothing() -> None:
    """The same performance at 120, 60 and 30 frames a second has the same phrases to a fifth of a second."""
    reference: list[int] | None = None
    for fps in (30.0, 60.0, 120.0):
        poses, _ = medley(("squat", "jumping_jacks", "wave"), seconds=6.0, fps=fps)
        moments = from_poses(poses)
        borders = inner_borders(phrases.find_phrases(moments))
        reference = reference or borders
        np.testing.assert_allclose(borders, reference, atol=6)


def test_distances_alone_are_enough() -> None:
    """Phrases of distances are those of the poses they were made of."""
    poses, _ = medley(MEDLEYS[0], seconds=5.0)
    moments = from_poses(poses)
    given = from_distances(*moments.block(), fps=moments.fps)
    assert phrases.find_phrases(given) == phrases.find_phrases(moments)


@pytest.mark.parametrize("name", ["walk", "run", "limp", "wave", "twist", "squat", "butterfly"])
def test_one_movement_is_one_phrase(name: str) -> None:
    """A recording of one exercise is not cut."""
    performance = kx.performer.perform(name, seconds=20.0, fps=FPS, seed=4, noise_degrees=1.0)
    found = phrases.find_phrases(from_poses(kx.poses(performance.motion)))
    assert len(found) == 1
    assert found[0].recurs
    assert not found[0].still


def test_a_body_at_rest_is_one_still_phrase() -> None:
    """Standing is no recurrence, however long."""
    performance = kx.performer.stand(seconds=12.0, fps=FPS, seed=1, noise_degrees=0.5)
    found = phrases.find_phrases(from_poses(kx.poses(performance.motion)))
    assert [(p.start, p.end, p.still, p.recurs) for p in found] == [(0, 360, True, False)]


def test_a_long_rest_is_a_phrase_of_its_own() -> None:
    """Squats, five seconds of rest, squats: three phrases, the first and the last of one kind."""
    performance = kx.performer.squat(seconds=9.6, fps=FPS, seed=2)
    q = kx.poses(performance.motion).quaternions
    rest = np.repeat(q[-1:], 150, axis=0)
    back = np.repeat(q[:1], 1, axis=0)
    found = phrases.find_phrases(from_poses(sequence(np.concatenate([q, rest, back, q]))))
    assert [p.still for p in found] == [False, True, False]
    assert found[0].kind == found[2].kind != found[1].kind
    np.testing.assert_allclose([found[1].start, found[1].end], [len(q), len(q) + 150], atol=12)


def test_recurrences_are_those_of_the_plain_rule(rng: np.random.Generator) -> None:
    """The paths by lag are those of a search over all paths of three steps, written out."""
    distance = rng.random((14, 14)).astype(np.float32)
    distance = distance + distance.T
    by_lag = np.full((14, 14), np.inf, dtype=np.float32)
    for k in range(14):
        by_lag[k, : 14 - k] = np.diagonal(distance, k)
    for backwards in (False, True):
        quick = crossing.paths_by_lag(by_lag, [3], 0.05, backwards=backwards)[3]
        for i in range(14):
            for k in range(14 - i):
                assert quick[k, i] == pytest.approx(
                    naive.path_through(distance, i, i + k, 3, 0.05, backwards=backwards), rel=1e-5
                )


def test_exercises_are_found_and_classed_with_nothing_told(shared_data: Path) -> None:
    """In CMU 13_30, with five exercises one after another, the three of known class are found, and are of that class."""
    poses = kx.poses(kx.read(shared_data / "cmu/13/13_30.amc"))
    _, judged = whole.judge(from_poses(poses))
    with (shared_data / "cmu" / "segments.tsv").open(encoding="utf-8") as lines:
        rows = [r for r in csv.DictReader(lines, delimiter="\t") if r["clip"] == "13_30" and r["expected_class"]]
    assert len(rows) == 3
    for row in rows:
        start, end = int(row["start_frame"]), int(row["end_frame"])
        best = max(judged, key=lambda p: min(end, p.end) - max(start, p.start))
        assert best.verdict is not None
        assert best.verdict.class_ == row["expected_class"]
        assert min(end, best.end) - max(start, best.start) > 0.75 * (max(end, best.end) - min(start, best.start))


def _labelled(shared_data: Path, clip: str) -> list[tuple[str, int, int]]:
    with (shared_data / "cmu" / "segments.tsv").open(encoding="utf-8") as lines:
        rows = [row for row in csv.DictReader(lines, delimiter="\t") if row["clip"] == clip]
    return [(row["action"], int(row["start_frame"]), int(row["end_frame"])) for row in rows]


@pytest.mark.parametrize("clip", ["13_29", "13_30", "14_06"])
def test_recorded_exercises(shared_data: Path, clip: str) -> None:
    """On recordings labelled by people at most a quarter of the moments belongs to another phrase."""
    poses = kx.poses(kx.read(shared_data / "cmu" / clip[:2] / f"{clip}.amc"))
    moments: Moments = from_poses(poses)
    labels = _labelled(shared_data, clip)
    found = phrases.find_phrases(moments)
    assert naive.hamming([(p.kind, p.start * 4, p.end * 4) for p in found], labels) <= 0.25


def test_swaying_under_a_noisy_sensor_does_not_recur() -> None:
    """Who sways by 3° before a sensor with 3° of noise does nothing twice: noise does not make one moment like another."""
    rng = np.random.default_rng(5)
    standing = kx.poses(kx.performer.squat(seconds=5, fps=30, seed=1).motion).quaternions[:1].repeat(900, axis=0)
    sway = gaussian_filter1d(rng.normal(size=(900, 15, 3)), 15.0, axis=0)
    turn = np.deg2rad(3.0 * sway / sway.std() + 3.0 * rng.normal(size=sway.shape))
    change = np.concatenate([np.ones((900, 15, 1)), 0.5 * turn], axis=-1)
    q = quaternion.multiply(standing, change / np.linalg.norm(change, axis=-1, keepdims=True))
    found = phrases.find_phrases(from_poses(sequence(q)))
    assert not any(p.recurs for p in found)
