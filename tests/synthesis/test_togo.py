"""Seconds to go to a target, by what the paths let a performer do."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from floor_networks import Path, floor_network
from kinesics import compiled
from kinesics.synthesis.control.courses import perform_paths
from kinesics.synthesis.goals import Target
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.paths.prospects import prospects
from kinesics.synthesis.paths.togo import KNOTS, ToGo
from naive import togo as naive

PACE = 1.25
RADIUS = 0.5


def walking(**turns: float) -> Network:
    """Steps of .2 s and .25 m, each of which may follow each."""
    return floor_network([Path(name, 4, 0.2 * PACE, turn) for name, turn in turns.items()])


def seconds(ahead: ToGo, x: float, z: float) -> float:
    return float(ahead.after(np.zeros(1, dtype=np.intp), np.array([complex(z, x)]), np.zeros(1, dtype=np.float32))[0])


def hopeless(ahead: ToGo, x: float, z: float) -> bool:
    return ahead.hopeless(0, complex(z, x))


@pytest.mark.parametrize("metres", [1.0, 2.5, 4.0, 7.0, 20.0])
def test_straight_on_it_takes_as_long_as_the_way_is(metres: float) -> None:
    """Up to the quarter of a second at which composites are looked at, also beyond the last knot of the tables."""
    ahead = prospects(walking(ahead=0.0)).to_go(RADIUS, 0.0)
    assert seconds(ahead, 0.0, metres) == pytest.approx((metres - RADIUS) / PACE, abs=0.35)


def test_what_cannot_be_reached_is_known() -> None:
    """One who only walks straight on never meets what is aside or behind."""
    ahead = prospects(walking(ahead=0.0)).to_go(RADIUS, 0.0)
    assert hopeless(ahead, -2.0, 4.0)
    assert hopeless(ahead, 0.0, -3.0)
    assert not hopeless(ahead, 0.0, 8.0)
    assert not hopeless(ahead, 0.0, 800.0)


def test_within_the_radius_nothing_is_left_to_go() -> None:
    """There is there, wherever one faces."""
    ahead = prospects(walking(ahead=0.0)).to_go(RADIUS, 0.0)
    for degrees in range(0, 360, 45):
        place = 0.15 * np.exp(1j * math.radians(degrees))
        assert seconds(ahead, place.imag, place.real) == 0.0


def test_round_a_circle_its_middle_is_never_met() -> None:
    """One who can only walk round it has the middle beside him for ever, unless the way may be bent."""
    radius = 1.5
    bundle = prospects(walking(round=0.2 * PACE / radius))
    for degrees, possible in ((0.0, False), (30.0, True)):
        ahead = bundle.to_go(RADIUS, math.radians(degrees))
        assert hopeless(ahead, radius, 0.0) != possible


def test_more_may_be_done_never_takes_longer() -> None:
    """With turns to both sides no target is farther in time than with turns to the left alone."""
    one = prospects(walking(ahead=0.0, left=0.25)).to_go(RADIUS, 0.0)
    both = prospects(walking(ahead=0.0, left=0.25, right=-0.25)).to_go(RADIUS, 0.0)
    for degrees in range(-180, 180, 30):
        place = 4.0 * np.exp(1j * math.radians(degrees))
        longer, shorter = (seconds(t, place.imag, place.real) for t in (one, both))
        assert shorter <= longer + 0.3


def test_left_and_right_are_mirror_images() -> None:
    """Who turns to either side alike needs as long to a target on the left as to one on the right."""
    both = prospects(walking(ahead=0.0, left=0.25, right=-0.25)).to_go(RADIUS, 0.0)
    for degrees in (30, 60, 90, 120, 150):
        place = 3.0 * np.exp(1j * math.radians(degrees))
        left, right = (seconds(both, side * place.imag, place.real) for side in (1.0, -1.0))
        assert left == pytest.approx(right, abs=0.3)


@pytest.mark.parametrize("bend", [0.0, 5.0])
@pytest.mark.parametrize("turns", [{"left": 0.1}, {"left": 0.1, "right": -0.1}, {"right": -0.1}])
@pytest.mark.parametrize("target", [(1.5, 0.0), (-1.5, 0.0), (2.0, 1.0), (-2.0, 0.5), (0.0, -1.5)])
def test_targets_inside_the_narrowest_turn_are_reached(
    turns: dict[str, float], bend: float, target: tuple[float, float]
) -> None:
    """The narrowest turn has a radius of 2.5 m: one walks away from the target and comes back, also by one side alone."""
    net = walking(ahead=0.0, **turns)
    ready = prospects(net)
    for seed in range(3):
        course = perform_paths(net, Target(target), 40.0, seed, finish=True, bend=bend, prepared=ready, start=0)
        assert course.attained


def test_a_beeline_stays_a_beeline() -> None:
    """To a target far ahead nothing is walked round about."""
    net = walking(ahead=0.0, left=0.1, right=-0.1)
    course = perform_paths(net, Target((3.0, 15.0)), 40.0, finish=True, start=0)
    assert course.attained
    assert course.length < 1.1 * math.hypot(3.0, 15.0)
    assert KNOTS[-1] < 15.0


def test_what_was_computed_once_is_kept() -> None:
    """The same radius and bend give the same tables; another bend others."""
    bundle = prospects(walking(ahead=0.0, left=0.1))
    assert bundle.to_go(RADIUS, 0.0) is bundle.to_go(RADIUS, 0.0)
    assert bundle.to_go(RADIUS, 0.0) is not bundle.to_go(RADIUS, 0.1)


@pytest.mark.parametrize("declined", ["", "1"])
def test_looked_up_as_the_twin_does(monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator, declined: str) -> None:
    """Compiled or not: seconds by trails, bent either way, to targets near and beyond the tables, all around."""
    monkeypatch.setenv("KINESICS_NO_NATIVE", declined)
    ready = prospects(walking(left=0.2, right=-0.15, ahead=0.0))
    ahead = ready.to_go(RADIUS, 0.1)
    bends = np.array([0.0, -0.1, 0.1], dtype=np.float32)
    for rows in (slice(None), slice(5, 6)):
        trail = ready.along(rows)
        ends = [complex(place) for place in trail.places[:3, -1]]
        for target in [0j, -4.0 + 0j, *ends, *(complex(*v) for v in rng.normal(0.0, 6.0, (12, 2)))]:
            found = ahead.by(trail, target, bends)
            assert found.shape == (3, len(trail.places))
            for b, row in itertools.product(range(3), range(0, len(trail.places), 7)):
                twin = naive.seconds_by(ahead, trail, row, target, float(bends[b]))
                assert found[b, row] == pytest.approx(twin, rel=1e-4, abs=1e-4)


@pytest.mark.skipif(compiled.native is None, reason="built without the compiled module")
def test_what_does_not_fit_is_not_looked_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """Paths that there are no tables for are refused by the compiled module too."""
    monkeypatch.delenv("KINESICS_KERNEL", raising=False)
    monkeypatch.delenv("KINESICS_NO_NATIVE", raising=False)
    ready = prospects(walking(left=0.2, ahead=0.0))
    ahead, trail = ready.to_go(RADIUS, 0.0), ready.along(slice(0, 4))
    with pytest.raises(ValueError, match="seconds_by"):
        ahead.by(trail._replace(playing=trail.playing + 100), 1j, np.zeros(1, dtype=np.float32))
