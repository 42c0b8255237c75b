"""Moments: one time grid whatever the frame rate, distances in tiles and by lag, the sensor's noise."""

from __future__ import annotations

import numpy as np
import pytest

import kinesics as kx
from kinesics.errors import InputError
from kinesics.grammar import moments as room


@pytest.fixture(scope="module")
def walk() -> room.Moments:
    return room.from_poses(kx.poses(kx.performer.walk(seconds=4, fps=120, noise_degrees=1, seed=1).motion))


def test_a_recording_at_120_and_at_30_has_the_same_moments():
    """Taking every fourth frame first, from where it is read, changes nothing but the frame numbers."""
    fast = kx.poses(kx.performer.run(seconds=3, fps=120, seed=2).motion)
    a, b = room.from_poses(fast), room.from_poses(fast[::4])
    assert a.fps == b.fps == 30.0
    assert a.poses is not None
    assert b.poses is not None
    assert np.array_equal(a.poses.quaternions, b.poses.quaternions)
    assert np.array_equal(a.speed, b.speed)
    assert a.source_frames == 4 * b.source_frames


@pytest.mark.parametrize("frames", [357, 358, 359, 360])
@pytest.mark.parametrize("fps", [50.0, 120.0])
def test_turned_round_a_recording_has_the_same_moments(frames: int, fps: float):
    """Whatever the number of frames, played backwards the moments are the same ones in the other order."""
    poses = kx.poses(kx.performer.throw(fps=fps, seed=2, noise_degrees=0.5, seconds=10).motion)[:frames]
    a, b = room.from_poses(poses), room.from_poses(poses[::-1])
    assert a.from_end != b.from_end
    assert a.poses is not None
    assert b.poses is not None
    assert np.allclose(a.poses.quaternions, b.poses.quaternions[::-1], atol=1e-12)
    assert np.allclose(a.symmetry, b.symmetry[::-1], atol=1e-12)
    ends = [m.exact_frame_of(k) for m, k in ((a, 0), (b, b.count - 1))]
    assert ends[0] == pytest.approx(len(poses) - 1 - ends[1])


def test_a_slower_recording_keeps_its_own_rate():
    """Nothing is invented between the frames of a slow recording."""
    slow = kx.poses(kx.performer.walk(seconds=4, fps=25, seed=1).motion)
    m = room.from_poses(slow)
    assert m.fps == 25.0
    assert m.count == len(slow)


@pytest.mark.parametrize("fps", [30, 50, 60, 100, 120])
def test_moments_and_frames_find_each_other(fps: float):
    """A moment's frame lies at its time, and its moment is the same again."""
    m = room.from_poses(kx.poses(kx.performer.walk(seconds=3, fps=fps, seed=1).motion))
    for k in range(m.count):
        assert abs(m.frame_of(k) - m.exact_frame_of(k)) <= max(0.5, m.lead if k == 0 else 0.0) + 1e-9
        assert (m.exact_frame_of(k) - m.lead) / fps == pytest.approx(k / m.fps)
        assert m.moment_of(m.frame_of(k)) == k
    assert m.frame_of(m.count) == m.source_frames
    assert m.moment_of(m.source_frames) == m.count


@pytest.mark.parametrize("fps", [25, 120])
def test_a_stretch_by_itself_keeps_its_frames(fps: float):
    """The moments of a stretch are those of the recording, and lie at the recording's frames; of a stretch of it, too."""
    m = room.from_poses(kx.poses(kx.performer.walk(seconds=4, fps=fps, seed=1).motion))
    part = m.cut(10, 80).cut(5, 65)
    assert part.count == 60
    assert [part.frame_of(k) for k in range(61)] == [m.frame_of(15 + k) for k in range(61)]
    assert [part.moment_of(m.frame_of(15 + k)) for k in range(61)] == list(range(61))
    assert np.array_equal(part.speed, m.speed[15:75])
    assert np.allclose(part.block()[0], m.tile(slice(15, 75), slice(15, 75))[0], atol=1e-6)
    assert m.cut(0, m.count) is m


def test_tiles_and_lags_are_parts_of_the_whole(walk: room.Moments):
    """A tile is a rectangle of the block, a row by lag is one of its diagonals."""
    d, mirrored = walk.block()
    a, b = walk.tile(slice(10, 60), slice(40, 100))
    assert np.allclose(a, d[10:60, 40:100], atol=1e-6)
    assert np.allclose(b, mirrored[10:60, 40:100], atol=1e-6)
    by_lag = walk.by_lag(30, 5, 95)
    assert np.array_equal(by_lag[0], walk.d_by_lag(30, 5, 95))
    for rows, whole in zip(by_lag, (d, mirrored), strict=True):
        for k in range(31):
            assert np.allclose(rows[k, : 90 - k], np.diagonal(whole[5:95, 5:95], k), atol=1e-6)
            assert np.isinf(rows[k, 90 - k :]).all()
    index = np.array([3, 17, 44])
    assert np.allclose(walk.thinned(index)[1], mirrored[np.ix_(index, index)], atol=1e-6)


def test_by_lag_does_not_depend_on_how_rows_are_taken(walk: room.Moments, monkeypatch: pytest.MonkeyPatch):
    """Tiles of few rows give what tiles of many give."""
    whole = walk.by_lag(40)
    monkeypatch.setattr(room, "_ROWS", 7)
    monkeypatch.setattr(room, "_FEWEST_ROWS", 1)
    for a, b in zip(walk.by_lag(40), whole, strict=True):
        assert np.allclose(np.where(np.isfinite(a), a, -1), np.where(np.isfinite(b), b, -1), atol=1e-6)


def test_all_pairs_of_a_long_stretch_are_refused(walk: room.Moments, monkeypatch: pytest.MonkeyPatch):
    """Nobody allocates N×N of a long recording by accident."""
    monkeypatch.setattr(room, "LARGEST_BLOCK", 100)
    with pytest.raises(InputError, match="at most 100 moments"):
        walk.block()
    assert walk.block(0, 100)[0].shape == (100, 100)


@pytest.mark.parametrize("stretch", [(-1, 10), (5, 5), (0, 10_000)])
def test_a_stretch_outside_is_refused(walk: room.Moments, stretch: tuple[int, int]):
    """The message says how many moments there are."""
    with pytest.raises(InputError, match=f"within the {walk.count} moments"):
        walk.stretch(*stretch)


@pytest.mark.parametrize("fps", [30, 60, 120])
@pytest.mark.parametrize("degrees", [0.5, 1.0, 2.0])
def test_the_noise_of_the_sensor_is_measured(fps: float, degrees: float):
    """White noise of σ in each joint puts D ≈ σ²/4 between two moments of one pose, whatever moves and at any frame rate."""
    m = room.from_poses(kx.poses(kx.performer.walk(seconds=5, fps=fps, noise_degrees=degrees, seed=3).motion))
    assert m.noise == pytest.approx(np.deg2rad(degrees) ** 2 / 4.0, rel=0.1)


def test_movement_is_not_noise():
    """A run without noise is called noiseless to a tenth of what half a degree would give."""
    m = room.from_poses(kx.poses(kx.performer.run(seconds=5, fps=30, seed=3).motion))
    assert m.noise < 0.1 * np.deg2rad(0.5) ** 2 / 4.0


def test_noise_from_distances_only_is_that_of_the_points(rng: np.random.Generator):
    """Where 2D is a squared distance of points, the cubic through the neighbours is found without the points."""
    from naive import grammar as naive

    t = np.linspace(0, 3, 80)
    points = np.stack([np.sin(t), np.cos(2 * t), 0.2 * t], axis=1) + 0.01 * rng.standard_normal((80, 3))
    squared = ((points[:, None] - points[None]) ** 2).sum(-1)
    lagged = [np.diagonal(squared / 2.0, k) for k in range(1, 5)]
    expected = np.quantile(naive.noise_of(points), 0.2) / 2.0 / room._QUANTILE_SHARE * 2.0 / room._LEFT_OVER
    # D is half of the squared distance, and so is what is left of it
    assert room._noise([d.astype(np.float64) for d in lagged]) == pytest.approx(expected, rel=1e-9)


def test_moments_of_anything_with_distances(walk: room.Moments):
    """Matrices of D and D* give the same moments as the poses they came from."""
    d, mirrored = walk.block()
    m = room.from_distances(d, mirrored, 30.0)
    assert np.allclose(m.speed, walk.speed, atol=0.05)
    assert np.allclose(m.symmetry, walk.symmetry, atol=1e-5)
    assert np.array_equal(m.block(3, 50)[0], d[3:50, 3:50])
    half = room.from_distances(d, mirrored, 60.0)
    assert half.count == -(-walk.count // 2)
    assert half.fps == 30.0


@pytest.mark.parametrize(
    ("d", "mirrored", "fps", "words"),
    [
        (np.zeros((3, 4)), np.zeros((3, 4)), 30.0, "one shape"),
        (np.zeros((3, 3)), np.zeros((4, 4)), 30.0, "one shape"),
        (np.full((3, 3), np.nan), np.zeros((3, 3)), 30.0, "finite"),
        (np.zeros((3, 3)), np.full((3, 3), -1.0), 30.0, "not negative"),
        (np.zeros((3, 3)), np.zeros((3, 3)), 0.0, "above 0"),
    ],
)
def test_bad_distances_are_refused(d: np.ndarray, mirrored: np.ndarray, fps: float, words: str):
    """The message says what was expected."""
    with pytest.raises(InputError, match=words):
        room.from_distances(d, mirrored, fps)


def test_a_single_frame_is_a_moment():
    """One frame has speed 0 and no noise."""
    m = room.from_poses(kx.poses(kx.performer.stand(seconds=1, fps=30).motion)[:1])
    assert m.count == 1
    assert m.speed.tolist() == [0.0]
    assert m.noise == 0.0
    with pytest.raises(InputError, match="above 0"):
        room.from_poses(kx.poses(kx.performer.stand(seconds=1, fps=30).motion), rate=0.0)
