"""Motifs: planted repetitions are found with their relation and their ends; stillness and chance are not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

import kinesics as kx
from kinesics.body import pose
from kinesics.body.pose import PoseSequence
from kinesics.geometry import quaternion
from kinesics.grammar import linkage, motifs
from kinesics.grammar.moments import Moments, from_poses
from kinesics.grammar.motifs import returns, search

FPS = 30.0


def _sequence(q: np.ndarray, fps: float = FPS) -> PoseSequence:
    return PoseSequence(quaternions=q, yaw=np.zeros(len(q)), ground=np.zeros((len(q), 2)), fps=fps)


def _stretch(a: np.ndarray, b: np.ndarray, steps: int) -> np.ndarray:
    t = np.linspace(0.0, 1.0, steps + 2)[1:-1]
    t = t * t * (3.0 - 2.0 * t)
    return quaternion.slerp(np.broadcast_to(a, (steps, 15, 4)), np.broadcast_to(b, (steps, 15, 4)), t[:, None])


def _poses(name: str, seed: int = 1, fps: float = FPS, **parameters: float) -> np.ndarray:
    return kx.poses(kx.performer.perform(name, seed=seed, fps=fps, **parameters).motion).quaternions


def planted(fps: float = FPS) -> tuple[PoseSequence, list[tuple[int, int]]]:
    """A throw, a rest, the throw backwards, a rest, the throw mirrored; and where they are."""
    a = _poses("throw", fps=fps, noise_degrees=0.3, noise_kind="smooth")
    # the rest is at a posture of the throw's beginning with one arm out: neither throw begins or ends there
    rest = np.repeat(pose_with_arms_out(a[0])[None], round(1.5 * fps), axis=0)
    steps = round(0.4 * fps)
    out: list[np.ndarray] = []
    places: list[tuple[int, int]] = []
    count = 0
    for part in (a, a[::-1], pose.mirror(a)):
        if out:
            between = np.concatenate([_stretch(out[-1][-1], rest[0], steps), rest, _stretch(rest[0], part[0], steps)])
            out.append(between)
            count += len(between)
        places.append((count, count + len(part)))
        out.append(part)
        count += len(part)
    return _sequence(np.concatenate(out), fps), places


def pose_with_arms_out(standing: np.ndarray) -> np.ndarray:
    """Half-way from standing to the T-pose, which is the identity of every joint."""
    return _stretch(standing, quaternion.identity((15,)), 1)[0]


def _moving(moments: Moments, start: int, end: int) -> tuple[int, int]:
    """Where a planted throw begins and ends to move."""
    fast = np.flatnonzero(moments.speed[start + 1 : end] > 0.1) + start
    return int(fast[0]), int(fast[-1]) + 2


def _overlap(a: tuple[int, int], b: tuple[int, int]) -> float:
    """Length of what two ranges share over what they cover."""
    shared = max(0, min(a[1], b[1]) - max(a[0], b[0]))
    return shared / (max(a[1], b[1]) - min(a[0], b[0]))


def _holds(found: tuple[int, int], place: tuple[int, int]) -> bool:
    """Nine tenths of the place are found, and no more than as much again (the way to the rest is made backwards too)."""
    shared = min(found[1], place[1]) - max(found[0], place[0])
    return shared >= 0.9 * (place[1] - place[0]) and found[1] - found[0] <= 2 * (place[1] - place[0])


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_a_reversed_and_a_mirrored_throw_are_found(fps: float) -> None:
    """[A, rest, reversed A, rest, mirrored A]: one stretch, once backwards and once mirrored, at the right places."""
    poses, places = planted(fps)
    moments = from_poses(poses)
    found = motifs.find_motifs(moments)
    where = [_moving(moments, round(a * 30 / fps), round(b * 30 / fps)) for a, b in places]
    main = [m for m in found if _holds((m.members[0].start, m.members[0].end), where[0])]
    by_relation = {m.relation: m for m in main}
    assert {"reverse", "mirror"} <= set(by_relation)
    for relation, place in (("reverse", where[1]), ("mirror", where[2])):
        member = by_relation[relation].members[1]
        assert _holds((member.start, member.end), place)
        assert (member.reversed, member.mirrored) == (relation == "reverse", relation == "mirror")
        assert by_relation[relation].similarity > 0.9


def test_ends_agree_to_a_few_moments() -> None:
    """Occurrences of one stretch are equally long, and the path leads from its ends to the first one's ends."""
    found = motifs.find_motifs(from_poses(planted()[0]))
    first = found[0].members[0]
    for motif in found:
        if motif.family == 0:
            member = motif.members[1]
            assert abs((member.end - member.start) - (first.end - first.start)) <= 6
            ends = [member.path[0][1], member.path[-1][1]]
            assert (ends if not member.reversed else ends[::-1]) == pytest.approx([first.start, first.end - 1], abs=6)
            times = np.array(member.path)
            assert (np.diff(times[:, 0]) >= 1).all()
            assert (np.diff(times[:, 1]) <= -1).all() if member.reversed else (np.diff(times[:, 1]) >= 1).all()


@pytest.mark.parametrize(
    ("name", "period"), [("walk", 1.1), ("squat", 2.4), ("jumping_jacks", 1.05), ("butterfly", 1.7)]
)
def test_a_cycle_is_one_set(name: str, period: float) -> None:
    """A movement done over and over is a set with about as many members as there are cycles, not all pairs of them."""
    moments = from_poses(kx.poses(kx.performer.perform(name, seconds=20.0, seed=2, fps=FPS, noise_degrees=1.0).motion))
    found = motifs.find_motifs(moments)
    assert sum(len(m.members) for m in found) <= 4.0 * 20.0 / period
    covered = np.zeros(moments.count, dtype=bool)
    for motif in found:
        for member in motif.members:
            covered[member.start : member.end] = True
    assert covered.mean() > 0.85


def test_the_mirrored_recording_has_the_same_motifs() -> None:
    """Neither places nor relations change."""
    poses = planted()[0]
    there, mirrored = motifs.find_motifs(from_poses(poses)), motifs.find_motifs(from_poses(poses.mirror()))
    assert [(m.relation, [(x.start, x.end) for x in m.members]) for m in there] == [
        (m.relation, [(x.start, x.end) for x in m.members]) for m in mirrored
    ]


def test_backwards_the_relations_are_turned() -> None:
    """Played backwards the mirrored throw comes first; the others are its mirror image, and that backwards, at the same places."""
    poses, places = planted()
    n = len(poses)
    moments = from_poses(poses[::-1])
    where = [_moving(moments, n - b, n - a) for a, b in reversed(places)]
    main = [m for m in motifs.find_motifs(moments) if _holds((m.members[0].start, m.members[0].end), where[0])]
    by_relation = {m.relation: m.members[1] for m in main}
    assert set(by_relation) == {"mirror_reverse", "mirror"}
    assert _holds((by_relation["mirror_reverse"].start, by_relation["mirror_reverse"].end), where[1])
    assert _holds((by_relation["mirror"].start, by_relation["mirror"].end), where[2])


def test_what_happens_once_is_no_motif() -> None:
    """A throw, and standing with sensor noise, recur nowhere."""
    assert motifs.find_motifs(from_poses(_sequence(_poses("throw", noise_degrees=1.0)))) == ()
    still = kx.performer.stand(seconds=10.0, fps=FPS, seed=0, noise_degrees=1.0)
    moments = from_poses(kx.poses(still.motion))
    assert motifs.find_motifs(moments) == ()
    assert motifs.find_reversals(moments) == ()


def test_long_recordings_are_read_more_coarsely(monkeypatch: pytest.MonkeyPatch) -> None:
    """Above the limit every other moment is read, and the members are the same to a tenth of a second."""
    moments = from_poses(planted()[0])
    fine = motifs.find_motifs(moments)
    monkeypatch.setattr(search, "FULL_RATE_MOMENTS", 100)
    coarse = motifs.find_motifs(moments)
    first = [motif for motif in fine if motif.family == 0]
    assert first
    for motif in first:
        twin = next(m for m in coarse if m.relation == motif.relation and m.family == 0)
        for a, b in zip(motif.members, twin.members, strict=True):
            assert _overlap((a.start, a.end), (b.start, b.end)) > 0.8


def test_the_cheapest_way_is_that_of_all_ways(rng: np.random.Generator) -> None:
    """Costs and beginnings agree with a search over all ways, and the steps written down cost as much."""
    from naive import motifs as naive

    for rows in (1, 2, 3, 6):
        tile = rng.random((rows, 9)).astype(np.float32)
        costs, starts = motifs.subsequence(tile, 0.1)
        expected, begins = naive.subsequence(tile, 0.1)
        np.testing.assert_allclose(costs, expected, rtol=1e-5)
        reached = np.isfinite(expected)
        assert (starts[reached] == np.array(begins)[reached]).all()


@pytest.mark.parametrize(("name", "turns"), [("squat", 2.4), ("jumping_jacks", 1.05), ("wave", 0.9), ("twist", 1.8)])
def test_there_and_back_has_two_turnings_a_cycle(name: str, turns: float) -> None:
    """Reversals of a cycle that goes there and back on one path: two in each period."""
    moments = from_poses(kx.poses(kx.performer.perform(name, seconds=12.0, seed=5, fps=FPS, noise_degrees=0.5).motion))
    assert len(motifs.find_reversals(moments)) == pytest.approx(2.0 * 12.0 / turns, rel=0.2)


@pytest.mark.parametrize("name", ["walk", "run", "arm_circles"])
def test_going_on_has_no_turnings(name: str) -> None:
    """Gaits and circles never turn back."""
    moments = from_poses(kx.poses(kx.performer.perform(name, seconds=12.0, seed=5, fps=FPS, noise_degrees=0.5).motion))
    assert motifs.find_reversals(moments) == ()


def test_reversals_of_the_reversed_recording() -> None:
    """They are at the same moments, counted from the other end."""
    poses = _sequence(_poses("squat", seconds=10.0))
    there = [r.moment for r in motifs.find_reversals(from_poses(poses))]
    back = [len(poses) - 1 - r.moment for r in motifs.find_reversals(from_poses(poses[::-1]))]
    assert sorted(back) == pytest.approx(there, abs=1)


def test_kicks_strike_and_walking_does_not() -> None:
    """A stop within an eighth of a second from high speed is a strike; a smooth swing is none."""
    t = np.arange(90) / FPS
    # raised by 90° within a fifth of a second, stopped dead, lowered in two seconds
    angle = np.deg2rad(90.0) * np.interp(t, [0.0, 0.5, 0.7, 1.0, 3.0], [0.0, 0.0, 1.0, 1.0, 0.0])
    q = quaternion.identity((90, 15))
    q[:, 9] = np.stack([np.cos(angle / 2), np.sin(angle / 2), 0 * t, 0 * t], axis=-1)
    struck = motifs.find_strikes(from_poses(_sequence(q)))
    assert [s.moment for s in struck] == pytest.approx([22], abs=2)
    for name in ("walk", "squat", "jumping_jacks"):
        assert motifs.find_strikes(from_poses(_sequence(_poses(name, seconds=8.0)))) == ()


def test_states_that_return() -> None:
    """Reaching and coming back returns to standing; the far point is reached again mirrored when the other arm reaches."""
    a = _poses("reach")
    q = np.concatenate([a, pose.mirror(a)])
    found = motifs.find_state_repetitions(from_poses(_sequence(q)))
    standing = [r for r in found if not r.mirrored]
    assert any(r.moments[0] < 20 and r.moments[-1] > len(q) - 40 for r in standing)
    far = [r for r in found if r.mirrored and any(40 < m < 80 for m in r.moments)]
    assert far
    assert any(len(a) + 40 < m < len(a) + 80 for m in far[0].moments)


def _mostly_still(minutes: float, rng: np.random.Generator) -> PoseSequence:
    """Standing with half a degree of noise in each joint, and one throw a minute."""
    throw = _poses("throw")
    q = np.repeat(throw[:1], round(minutes * 60.0 * FPS), axis=0)
    for first in range(round(10.0 * FPS), len(q) - len(throw), round(60.0 * FPS)):
        q[first : first + len(throw)] = throw
    turn = np.deg2rad(0.5) * rng.normal(size=(*q.shape[:2], 3))
    noise = np.concatenate([np.ones((*q.shape[:2], 1)), 0.5 * turn], axis=-1)
    return _sequence(quaternion.multiply(q, noise / np.linalg.norm(noise, axis=-1, keepdims=True)))


def test_states_of_a_long_rest_take_no_square_of_it(monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> None:
    """Who stands for minutes is calm at thousands of moments: never are the distances of all of them asked for at once."""
    moments = from_poses(_mostly_still(6.0, rng))
    calm = len(returns.calm_moments(moments))
    assert calm > 1000
    at_once = motifs.find_state_repetitions(moments)
    assert sorted(len(r.moments) for r in at_once if not r.mirrored)[-1] == 7  # before, between and after six throws
    largest = 0
    for name in ("thinned", "between", "tile"):
        asked = getattr(Moments, name)

        def counted(self: Moments, *which: NDArray[np.intp], asked: Callable[..., Any] = asked) -> Any:
            nonlocal largest
            d, mirrored = asked(self, *which)
            largest = max(largest, d.size)
            return d, mirrored

        monkeypatch.setattr(Moments, name, counted)
    monkeypatch.setattr(linkage, "MOST", 100)
    monkeypatch.setattr(linkage, "CELLS", 20_000)
    assert motifs.find_state_repetitions(moments) == at_once
    assert largest <= 20_000 < 0.02 * calm**2


@pytest.mark.parametrize("noise", [0.2, 3.0, 5.0])
@pytest.mark.parametrize("seed", [13, 21])
def test_swaying_under_a_noisy_sensor_is_no_motif(noise: float, seed: int) -> None:
    """Who stands and sways by 2° repeats nothing, and noise beyond that does not make one moment like another."""
    rng = np.random.default_rng(seed)
    standing = np.repeat(_poses("squat")[:1], 900, axis=0)
    sway = gaussian_filter1d(rng.normal(size=(900, 15, 3)), 0.5 * FPS, axis=0)
    turn = np.deg2rad(2.0 * sway / sway.std() + noise * rng.normal(size=sway.shape))
    change = np.concatenate([np.ones((900, 15, 1)), 0.5 * turn], axis=-1)
    q = quaternion.multiply(standing, change / np.linalg.norm(change, axis=-1, keepdims=True))
    moments = from_poses(_sequence(q))
    assert motifs.find_motifs(moments) == ()
    assert motifs.find_state_repetitions(moments) == ()


def test_frames_instead_of_moments() -> None:
    """At 120 frames a second frames are those at the time of the moments, and the end of the last stays within the recording."""
    moments = from_poses(planted(120.0)[0])
    found = motifs.find_motifs(moments)
    for a, b in zip(found, motifs.in_frames(moments, found), strict=True):
        assert [
            tuple(min(round(moments.lead) + 4 * k, moments.source_frames) for k in (m.start, m.end)) for m in a.members
        ] == [(m.start, m.end) for m in b.members]
