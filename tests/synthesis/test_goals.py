"""Goals by themselves: what they weigh, on a small network whose numbers are plain."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import kinesics as kx
from floor_networks import walker
from kinesics import compiled
from kinesics.body.motion import Motion
from kinesics.errors import InputError
from kinesics.synthesis.control.controller import Controller
from kinesics.synthesis.goals import (
    Abiding,
    Goal,
    Heading,
    Measured,
    MovingTarget,
    Novelty,
    Onwards,
    OwnFeature,
    Route,
    Situation,
    Speed,
    Target,
    TrailPursuit,
)
from kinesics.synthesis.goals.measured import _Measured
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.paths.prospects import SOON, prospects
from kinesics.synthesis.repertoire import repertoire

AHEAD, STAND = 0, 3


class Standing:
    """1 of the path that stands, 0 of all others; none is wished for."""

    weight = 1.0

    def values(self, network: Network) -> list[float]:
        return [0.0, 0.0, 0.0, 1.0]

    def wish(self, now: Situation) -> float:
        return 0.0


@pytest.mark.parametrize("lookahead", [0.0, 1.0, 3.0])
def test_what_comes_late_counts_less(lookahead: float) -> None:
    """A frame counts e times less for every `SOON`-th part of the lookahead that it comes later; without one all count alike."""
    net = walker()
    pursuit = OwnFeature(Standing()).pursuit(net, prospects(net, lookahead))
    now = Situation()
    first, second = float(net.duration[STAND]), float(net.duration[AHEAD])

    def count(begin: float, end: float) -> float:
        """Of all frames from one second to another, each by itself."""
        middles = begin + (end - begin) * (np.arange(10_000) + 0.5) / 10_000
        return float(np.exp(-SOON * middles / lookahead).mean() * (end - begin)) if lookahead else end - begin

    at_once = count(0.0, first) / count(0.0, first + second)
    later = count(second, second + first) / count(0.0, first + second)
    expected = (later / at_once) ** 2
    got = pursuit.chain([AHEAD, STAND], now) / pursuit.chain([STAND, AHEAD], now)
    assert got == pytest.approx(expected, rel=1e-6)
    assert expected < 1.0 or not lookahead


def test_before_anything_was_played_all_is_new() -> None:
    """Nothing is missed, for each of the rows that are asked for."""
    net = walker()
    ready = prospects(net, 1.0)
    paths = len(net.first)
    now = Situation(last_played=np.full(paths, -np.inf), plays=np.zeros(paths, dtype=np.intp))
    np.testing.assert_array_equal(Novelty().pursuit(net, ready).miss(slice(3, 8), now, 0.0), np.zeros(5))


@pytest.mark.parametrize(
    "goal", [Route([(0.0, 0.0), (1.5, 2.0), (0.0, 5.0)]), MovingTarget(lambda t: (0.5 * t, 1.0)), Target((2.0, 2.0))]
)
@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_a_way_that_may_be_bent_leads_no_farther_from_the_wish(goal: Goal, heading: float) -> None:
    """The bend that is added is the one that helps; of a way by itself it is said, and no more than is allowed."""
    ready = prospects(walker(), 2.0)
    pursuit = goal.pursuit(walker(), ready)
    assert isinstance(pursuit, TrailPursuit)
    pursuit.prepare(0.4)
    now = Situation(place=0.3 + 0.2j, heading=heading)
    trail = ready.along(slice(0, len(ready.sequence)))
    straight, bent = pursuit.weigh(trail, now, 0.0), pursuit.weigh(trail, now, 0.4)
    assert (bent <= straight + 1e-6).all()
    assert (bent < straight - 1e-3).any()
    bends = [pursuit.bend(ready.along(slice(k, k + 1)), now, 0.4) for k in range(40)]
    assert max(map(abs, bends)) <= 0.4 + 1e-6
    assert max(map(abs, bends)) > 0.01


def test_who_abides_leaves_a_recording_after_a_while() -> None:
    """To leave at once costs most, after two seconds nothing; of a chain of paths by itself as of a composite."""
    net, ready = walker(), prospects(walker(), 2.0)
    pursuit = Abiding(weight=3.0).pursuit(net, ready)
    path = int(np.argmax(np.diff(net.indptr)))
    rows = slice(int(ready.rows[path]), int(ready.rows[path + 1]))
    for stayed in (0.0, 0.7, 1.9):
        now = Situation(path=path, since_jump=stayed)
        miss = pursuit.miss(rows, now, 0.0)
        until = stayed + ready.first_jump[rows].astype(np.float64)
        np.testing.assert_allclose(miss, 3.0 * np.clip(1.0 - until / 2.0, 0.0, None) ** 2, atol=1e-6)
        chains = [sequence[sequence >= 0].tolist() for sequence in ready.sequence[rows]]
        np.testing.assert_allclose([pursuit.chain(paths, now) for paths in chains], miss, atol=1e-5)
        assert np.ptp(miss) > 0.0
    assert not pursuit.miss(rows, Situation(path=path, since_jump=2.0), 0.0).any()
    with pytest.raises(InputError, match="awhile"):
        Abiding(awhile=0.0)


def test_misses_are_counted_in_spreads() -> None:
    """Of a speed in the middle of all that there are the mean square miss is 1; headings count all along the way."""
    ready = prospects(walker(), 2.0)
    now, trail, rows = Situation(heading=0.5), ready.trail, slice(0, len(ready.sequence))
    speeds = (trail.travelled[:, -1] / trail.times[:, -1]).astype(np.float64)
    even = Speed(float(speeds.mean())).pursuit(walker(), ready).miss(rows, now, 0.0)
    assert even.mean() == pytest.approx(1.0, rel=1e-4)
    off = np.angle(np.exp(1j * (0.5 + trail.headings.astype(np.float64) - 1.2)))
    expected = np.mean(off**2, axis=1) / np.var(trail.headings[:, -1])
    np.testing.assert_allclose(Heading(1.2).pursuit(walker(), ready).miss(rows, now, 0.0), expected, rtol=1e-4)


def _hands(motion: Motion) -> NDArray[np.float64]:
    """How high the left hand is."""
    return np.asarray(motion.positions()[:, motion.skeleton.find("LeftHand"), 1])


@pytest.mark.parametrize("lookahead", [0.0, 2.0])
@pytest.mark.parametrize(
    "goal",
    [
        Target((0.4, 0.9)),
        Target((-90.0, 40.0)),
        MovingTarget([(0.5, 1.0), (-3.0, -1.0)], fps=1.0),
        MovingTarget([(20.0, 1.0)], fps=1.0),
        Novelty(),
        Onwards(),
    ],
)
def test_compiled_and_plain_weigh_alike(goal: Goal, lookahead: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """What all composites miss, bent and not, and how each is bent: compiled as in NumPy, whatever was played before."""
    if compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    net = network(repertoire(kx.performer.walk(seconds=6, fps=30, noise_degrees=0.5, route="circle", seed=5).motion))
    ready = prospects(net, lookahead)
    controller = Controller(net, None, prepared=ready, seed=2)
    for _ in range(12):
        controller.step()
    found: dict[str, list[NDArray[np.float64]]] = {"0": [], "1": []}
    for plain, given in found.items():
        monkeypatch.setenv("KINESICS_NO_NATIVE", plain)
        pursuit = goal.pursuit(net, ready)
        for bend in (0.0, 0.1):
            pursuit.prepare(bend)
            for path in range(0, len(net), 5):
                rows = slice(*ready.rows[path : path + 2].tolist())
                given.append(pursuit.miss(rows, controller.now, bend))
                if isinstance(pursuit, TrailPursuit):
                    trail = ready.along(slice(rows.start, rows.start + 1))
                    given.append(np.array([pursuit.bend(trail, controller.now, bend)]))
    assert any(len(np.unique(values)) > 1 for values in found["0"])
    for one, other in zip(found["0"], found["1"], strict=True):
        np.testing.assert_allclose(one, other, rtol=2e-4, atol=1e-5)


@pytest.fixture(scope="module")
def kata() -> Motion:
    return kx.performer.kata(fps=30).motion


def test_what_is_measured_is_the_mean_over_each_path_and_its_mirror_image(kata: Motion) -> None:
    """Said the long way, frame by frame of the recording and of its image."""
    net = network(repertoire(kata, backwards=True))
    got = _Measured(Measured(_hands, 1.0)).values(net)
    for path in range(len(net)):
        frames = [net.repertoire.frame_of(net.repertoire.advance(net.first[path], k)) for k in range(net.length[path])]
        image = net.repertoire.motion(0, int(net.strand[path]) % 2)
        assert got[path, 0] == pytest.approx(_hands(image)[frames].mean())


def test_hands_are_held_as_high_as_is_wished_for(kata: Motion) -> None:
    """A function of a motion is all that a goal of one's own needs; the wish may change with time."""
    low, high = (np.median(_hands(kx.perform(kata, goal=Measured(_hands, y), seconds=8, seed=1))) for y in (0.8, 1.8))
    assert high > low + 0.2
    changing = Measured(_hands, lambda now: 1.8 if now.time < 10.0 else 0.8)
    heights = _hands(kx.perform(kata, goal=changing, seconds=20, seed=1))
    assert np.median(heights[:300]) > np.median(heights[300:]) + 0.2


@pytest.mark.parametrize(
    ("measure", "told"),
    [
        (lambda m: 1.0, r"got float\."),
        (lambda m: np.ones(3), r"of shape \(3,\)\."),
        (lambda m: ["high"] * m.frame_count, r"got list\."),
        (lambda m: np.full(m.frame_count, np.nan), "with NaN"),
    ],
)
def test_a_measure_that_gives_no_numbers_is_refused(kata: Motion, measure: Any, told: str) -> None:
    """What was expected and what came."""
    with pytest.raises(InputError, match=told):
        kx.perform(kata, goal=Measured(measure, 1.0), seconds=2)


def test_a_measure_is_a_function_and_its_wish_has_its_dimensions(kata: Motion) -> None:
    """Both said before anything is performed."""
    with pytest.raises(InputError, match="function of a motion"):
        Measured(1.0, 1.0)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="`wish` of Measured to be 1 finite"):
        kx.perform(kata, goal=Measured(_hands, [1.0, 2.0]), seconds=2)
