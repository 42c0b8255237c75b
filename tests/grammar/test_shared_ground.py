"""Recordings that share ground: copies, mirror images and parts of one another are read as what they are."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

import kinesics as kx
from kinesics.geometry import quaternion
from kinesics.grammar import ground, moments

REAL = ["cmu/07/07_01.amc", "cmu/13/13_29.amc", "cmu/135/135_11.amc", "cmu/bvh/135_01_bassai_30fps.bvh"]
JUMPS = "cmu/86/86_01.amc"


PERFORMED: dict[str, Callable[[], kx.Motion]] = {
    "walk": lambda: kx.performer.walk(seconds=5, fps=60, seed=1, noise_degrees=0.5).motion,
    "side kicks": lambda: kx.performer.side_kicks(fps=60, seed=2, noise_degrees=0.5).motion,
    "sun salutation": lambda: kx.performer.sun_salutation(fps=30, seed=1, noise_degrees=0.5).motion,
}


def _wavered(motion: kx.Motion, degrees: float, rng: np.random.Generator) -> kx.Motion:
    """Every joint turned a little by something smooth, which no sensor's noise explains."""
    turn: NDArray[np.float64] = gaussian_filter1d(
        rng.normal(size=(*motion.rotations.shape[:2], 3)), 0.3 * motion.fps, axis=0
    )
    turn *= np.deg2rad(degrees) / turn.std()
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    change = np.concatenate([np.cos(angle / 2), np.sinc(angle / (2 * np.pi)) * turn / 2], axis=-1)
    return dataclasses.replace(motion, rotations=quaternion.multiply(motion.rotations, change))


def _check(motion: kx.Motion) -> None:
    alone = kx.graph(motion)
    twice = kx.graph([motion, motion])
    assert twice.isomorphic_to(alone)
    assert twice.notation(0) == twice.notation(1) == alone.notation(0)
    reflected = kx.graph([motion, kx.mirror(motion)])
    assert reflected.isomorphic_to(alone.racemic())


@pytest.mark.parametrize("name", [*REAL, JUMPS])
def test_a_copy_and_the_mirror_image_of_a_real_recording(name: str, shared_data: Path) -> None:
    """Twice the same recording has its graph, each string written twice; with its mirror image it has the racemic graph."""
    _check(kx.read(shared_data / name))


@pytest.mark.parametrize("name", PERFORMED)
def test_a_copy_and_the_mirror_image_of_a_performance(name: str) -> None:
    """So has every performance."""
    _check(PERFORMED[name]())


@pytest.mark.parametrize("name", REAL[1:])
def test_likeness_does_not_make_one_of_many_states(name: str, shared_data: Path, rng: np.random.Generator) -> None:
    """With its own first half, or with a copy that wavers by 1°, a recording keeps its states, give or take a few."""
    motion = kx.read(shared_data / name)
    alone = len(kx.graph(motion).states)
    for other in (motion[: motion.frame_count // 2], _wavered(motion, 1.0, rng)):
        together = len(kx.graph([motion, other]).states)
        assert abs(together - alone) <= max(1, 0.25 * alone)


def test_its_first_half_adds_nothing_to_side_kicks(shared_data: Path) -> None:
    """Where a recording repeats a few things, its first half has the same graph with it."""
    motion = kx.read(shared_data / "cmu/135/135_11.amc")
    assert kx.graph([motion, motion[: motion.frame_count // 2]]).isomorphic_to(kx.graph(motion))


def test_order_does_not_matter(shared_data: Path) -> None:
    """Recordings in another order have the same graph, each the same string up to the labels."""
    walk, exercises = (kx.read(shared_data / name) for name in REAL[:2])
    squat = kx.performer.squat(seconds=6, fps=60, seed=1, noise_degrees=0.3).motion
    first = kx.graph([walk, exercises, squat])
    for order in ([exercises, walk, squat], [squat, exercises, walk]):
        assert kx.graph(order).isomorphic_to(first)
    again = kx.graph([squat, walk, exercises])
    assert [s.frames for s in again.sources] == [m.frame_count for m in (squat, walk, exercises)]
    assert len(again.timeline(2)) == len(first.timeline(1))


def test_copies_say_nothing_of_precision(shared_data: Path) -> None:
    """What counts as near is judged within each recording: two copies leave it as it is."""
    motion = kx.read(shared_data / REAL[1])
    one = moments.from_poses(kx.poses(motion))
    q = one.poses
    assert q is not None
    doubled = dataclasses.replace(
        q,
        quaternions=np.concatenate([q.quaternions] * 2),
        yaw=np.concatenate([q.yaw] * 2),
        ground=np.concatenate([q.ground] * 2),
        yaw_undefined=None,
    )
    two = dataclasses.replace(moments.from_poses(doubled), noise=one.noise)
    near = ground.judge_nearness(one)
    assert ground.judge_nearness(two, [one.count]) == near
    assert ground.judge_nearness(two).same < near.same


def test_bars_stand_on_what_is_symmetric(shared_data: Path) -> None:
    """Bassai has symmetric states at its beginning, in its middle and at its end, and none where one arm is elsewhere (§3.6.3)."""
    motion = kx.read(shared_data / REAL[3])
    graph = kx.graph(motion)
    distances = moments.from_poses(kx.poses(motion)).symmetry
    held = [stay for s in graph.states if s.symmetric for stay in s.stays]
    assert held
    assert all(np.median(distances[stay.start : stay.end]) <= ground.SYMMETRIC for stay in held)
    assert held[0].start == 0
    assert max(stay.end for stay in held) == motion.frame_count
    assert any(0.3 < stay.start / motion.frame_count < 0.6 for stay in held)
