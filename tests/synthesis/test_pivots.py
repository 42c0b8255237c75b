"""The point that a foot stands on stays while it turns; what slides is seen to slide."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import kinesics as kx
from kinesics import compiled
from kinesics.body import contacts
from kinesics.body.contacts import Floor, runs
from kinesics.body.motion import Motion
from kinesics.synthesis.control.controller import Controller
from kinesics.synthesis.embodiment import pivots
from kinesics.synthesis.embodiment.checking import check, farthest, slide
from kinesics.synthesis.embodiment.rendering import render
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.goals import Economy, Novelty
from kinesics.synthesis.live.renderer import LiveRenderer, performed
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.repertoire import repertoire
from naive import pivots as naive

Array = NDArray[np.float64]

FPS = 60.0
HEEL, BALL, TIP = 0.0, 0.18, 0.25


def sole(yaw: Array, about: Array, heel: Array | float = 0.0, away: Array | float = 0.0) -> tuple[Array, Array]:
    """Heel, ball and tip (frames, 3, 3) and their heights of a foot that turns, each step about a point so far along the sole."""
    yaw = np.asarray(yaw, dtype=np.float64)
    ahead = np.stack([np.sin(yaw), np.zeros_like(yaw), np.cos(yaw)], axis=-1)
    place = np.zeros((len(yaw), 3))
    for t in range(1, len(yaw)):
        place[t] = place[t - 1] + about[t - 1] * (ahead[t - 1] - ahead[t])
    place[:, 2] += away
    points = place[:, None] + np.array([HEEL, BALL, TIP])[None, :, None] * ahead[:, None]
    points[:, 0, 1] = heel
    return points, points[..., 1].copy()


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**16), native=st.booleans())
def test_of_all_choices_of_points_the_cheapest_is_found(seed: int, native: bool) -> None:
    """A sole of 1.5 cm, so that every choice can be tried."""
    if native and compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    rng = np.random.default_rng(seed)
    yaw = np.cumsum(rng.normal(0.0, 0.3, 5))
    ahead = np.stack([np.sin(yaw), np.zeros(5), np.cos(yaw)], axis=-1)
    points = rng.normal(0.0, 0.002, (5, 1, 3)) + np.array([0.0, 0.01, 0.015])[None, :, None] * ahead[:, None]
    height = rng.uniform(0.0, 0.03, (5, 3))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("KINESICS_NO_NATIVE", "0" if native else "1")
        patch.delenv("KINESICS_KERNEL", raising=False)
        found = pivots.cheapest(points, height, 30.0)
    parts, apart = naive.along(points)
    chosen = [int(np.argmin([np.abs(part - one).sum() for part in parts])) for one in found]
    assert naive.cost(points, height, 30.0, parts, apart, chosen) == pytest.approx(naive.least(points, height, 30.0))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**16), at=st.sampled_from([HEEL, 0.09, BALL, 0.22]), degrees=st.floats(20.0, 300.0))
def test_a_turn_about_one_point_is_no_slide_however_heights_tremble(seed: int, at: float, degrees: float) -> None:
    """Nor is it one if the foot turns back in between."""
    rng = np.random.default_rng(seed)
    yaw = np.deg2rad(degrees) * np.cumsum(np.concatenate([[0.0], rng.normal(0.02, 0.03, 60)]))
    points, height = sole(yaw, np.full(60, at))
    height = height + rng.uniform(0.0, 0.008, height.shape)
    assert slide(points, height, FPS) < 0.004
    assert np.abs(np.diff(pivots.stood_on(points, height, FPS), axis=0)).sum() < 0.2


def test_heel_gives_way_to_ball_at_once() -> None:
    """A turn on the heel that goes on on the ball stands on the one, then on the other, and nothing slides."""
    yaw = np.linspace(0.0, np.deg2rad(150.0), 61)
    points, height = sole(yaw, np.repeat([HEEL, BALL], 30))
    found = pivots.stood_on(points, height, FPS)
    np.testing.assert_allclose(found[:26], [[1.0, 0.0, 0.0]] * 26, atol=0.05)
    np.testing.assert_allclose(found[34:], [[0.0, 1.0, 0.0]] * 26, atol=0.05)
    # in some hundredths of a second, in which this foot turns by 10°
    assert np.abs(np.diff(found, axis=0)).max() < 0.5
    assert slide(points, height, FPS) < 0.01


@pytest.mark.parametrize("degrees", [0.0, 15.0, 90.0])
def test_what_slides_as_it_turns_is_seen_to(degrees: float) -> None:
    """Three centimetres ahead, with a turn about the ball or without: no point of the sole stays."""
    yaw = np.linspace(0.0, np.deg2rad(degrees), 61)
    points, height = sole(yaw, np.full(60, BALL), away=np.linspace(0.0, 0.03, 61))
    # a quarter of a turn goes about a point 2 cm beside the sole, which goes round it
    assert slide(points, height, FPS) > (0.018 if degrees > 30.0 else 0.028)


def test_what_is_lifted_does_not_bear() -> None:
    """A foot on its toes that turns about its heel, 5 cm above the floor, goes with its toes over the floor."""
    yaw = np.linspace(0.0, np.deg2rad(40.0), 41)
    points, height = sole(yaw, np.full(40, HEEL), heel=0.05)
    assert slide(points, height, FPS) > 0.1
    flat = sole(yaw, np.full(40, HEEL))
    assert slide(*flat, FPS) < 1e-9


def test_back_and_mirrored_it_stands_on_the_same_points() -> None:
    """Reversed in time and seen in a mirror."""
    rng = np.random.default_rng(3)
    yaw = np.cumsum(rng.normal(0.02, 0.05, 80))
    points, height = sole(yaw, np.repeat([HEEL, BALL, 0.09, BALL], 20)[:79])
    points += rng.normal(0.0, 0.0005, points.shape)
    found = pivots.stood_on(points, height, FPS)
    np.testing.assert_allclose(pivots.stood_on(points * [-1.0, 1.0, 1.0], height, FPS), found, atol=1e-12)
    way = np.linalg.norm(pivots.steps_of(points, height, FPS), axis=1).sum()
    back = np.linalg.norm(pivots.steps_of(points[::-1], height[::-1], FPS), axis=1).sum()
    assert back == pytest.approx(way, rel=0.05)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**16), frames=st.integers(1, 60), native=st.booleans())
def test_how_far_a_way_spreads_is_told_to_a_fiftieth(seed: int, frames: int, native: bool) -> None:
    """Never more than any two of its places are apart, of each run by itself, and of one frame nothing."""
    if native and compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    rng = np.random.default_rng(seed)
    way = np.cumsum(rng.normal(0.0, 1.0, (frames, 2)) * rng.uniform(0.0, 1.0, 2), axis=0) + 5.0
    cut = int(rng.integers(1, frames + 1))
    spans = [(0, frames), (0, cut), (cut - 1, frames), (0, 1)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("KINESICS_NO_NATIVE", "0" if native else "1")
        patch.delenv("KINESICS_KERNEL", raising=False)
        found = pivots.spreads(way, spans)
        assert pivots.spreads(way, []).shape == (0,)
    exact = np.array([farthest(way[a:b]) for a, b in spans])
    assert (found <= exact + 1e-12).all()
    assert (found >= 0.98 * exact).all()
    assert found[-1] == 0.0


def test_one_frame_and_two() -> None:
    """What has no steps stands on nothing; what has one, on what moves least."""
    points, height = sole(np.array([0.0, 0.3]), np.array([HEEL]))
    assert pivots.stood_on(points[:1], height[:1], FPS).shape == (0, 3)
    np.testing.assert_allclose(pivots.stood_on(points, height, FPS), [[1.0, 0.0, 0.0]])
    np.testing.assert_array_equal(pivots.way_over(points[:1], height[:1], FPS), np.zeros((1, 2)))


def worst_gone(motion: Motion, stage: Stage) -> float:
    """Metres, of all contacts, by a rule that knows of no costs."""
    found = contacts.contacts(motion, known=stage.soles, ground=Floor(0.0), slow=stage.slow)
    height = found.positions[..., 1] - stage.levels
    return max(
        naive.gone(found.positions[a:b, k], height[a:b, k], motion.fps)
        for k in (0, 1)
        for a, b in runs(found.feet[:, k])
    )


@pytest.fixture(scope="module")
def landing(shared_data: Path) -> Network:
    """A leap whose landing turns on the heel: 49_08."""
    return network(repertoire(kx.read(shared_data / "cmu" / "49" / "49_08.amc")))


def test_who_turns_as_they_land_stands_on_a_point(landing: Network) -> None:
    """At once and live; the recording itself slides by centimetres there."""
    own = landing.repertoire
    stage = Stage.of(own)
    assert worst_gone(own.motion(0, 0), stage) > 0.05
    done = render(landing, list(itertools.islice(walk(landing), 40)))
    assert worst_gone(done.motion, stage) < 0.01
    assert check(done, landing).slides == 0
    live = LiveRenderer(landing, Controller(landing, [Novelty(), Economy()], seed=1))
    steps = performed(landing, list(itertools.islice(live, round(10.0 * own.fps))))
    assert worst_gone(steps.motion, stage) < 0.01


def walk(made: Network) -> Iterator[int]:
    """Paths drawn at random."""
    rng = np.random.default_rng(1)
    path = int(rng.integers(len(made)))
    while True:
        yield path
        path = int(rng.choice(made.successors(path)))


def test_farthest_is_the_greatest_distance() -> None:
    """Between any two places, however far apart in time."""
    rng = np.random.default_rng(0)
    places = rng.normal(size=(700, 2))
    assert farthest(places) == pytest.approx(max(float(np.linalg.norm(a - b)) for a in places for b in places))
