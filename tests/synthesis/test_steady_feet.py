"""Feet do not flicker where they bear; what they do in the air is theirs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import kinesics as kx
from kinesics import compiled
from kinesics.body import kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment.quality import measure
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.embodiment.steady_feet import PLAY, steady_feet, taut, unturned_feet, unturning
from kinesics.synthesis.repertoire import Repertoire, repertoire
from naive import steady_feet as naive

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
FPS = 120.0


def walking(fps: float = FPS) -> tuple[Repertoire, Stage]:
    """A performed walk and what is measured on it."""
    walk = kx.performer.walk(seconds=3, fps=fps, seed=4).motion
    own = repertoire(walk)
    return own, Stage.of(own)


def flickering(stage: Stage, frames: list[int]) -> Array:
    """The walk, its left foot turned by 15° in these frames."""
    rotations = stage.repertoire.rotations[0].copy()
    foot = stage.legs.feet[0]
    leap = quaternion.from_rotvec(np.deg2rad([15.0, 0.0, 0.0]))
    rotations[frames, foot] = quaternion.multiply(rotations[frames, foot], leap)
    return rotations


def turning(stage: Stage, rotations: Array) -> Array:
    """Second difference of the left foot's turning in the world, radians, shape (frames − 2,)."""
    places = np.zeros((len(rotations), 3))
    turned = kinematics.forward(stage.repertoire.skeleton, rotations, places).rotations[:, stage.legs.feet[0]]
    step = quaternion.as_rotvec(quaternion.multiply(turned[1:], quaternion.conjugate(turned[:-1])))
    return np.asarray(np.linalg.norm(np.diff(step, axis=0), axis=-1))


def test_a_foot_that_flickers_while_it_bears_turns_steadily() -> None:
    """15° for a frame: a sixth of the leap is left; the shin is where it was."""
    own, stage = walking()
    bears = np.flatnonzero(own.contacts[0, 60:300, 0]) + 60
    at = int(bears[len(bears) // 2])
    leaping = flickering(stage, [at])
    steady = steady_feet(stage, leaping, np.ones((len(leaping), 2), dtype=np.bool_))
    assert turning(stage, leaping)[at - 3 : at + 3].max() > np.deg2rad(25.0)
    assert turning(stage, steady)[at - 3 : at + 3].max() < np.deg2rad(4.0)
    others = [j for j in range(own.skeleton.joint_count) if j not in {*stage.legs.feet, *stage.soles.joints.ravel()}]
    assert np.array_equal(steady[:, others], leaping[:, others])


def test_a_foot_in_the_air_turns_as_it_was_recorded() -> None:
    """Kicks are quick, and nothing holds the foot there."""
    _, stage = walking()
    leaping = flickering(stage, [100, 200])
    nowhere = np.zeros((len(leaping), 2), dtype=np.bool_)
    assert np.abs(quaternion.angle(steady_feet(stage, leaping, nowhere), leaping)).max() < 1e-6


def test_what_turns_slowly_stays() -> None:
    """Feet of a walk without any tremble are turned by half a degree at most, but for where they head as they come and go."""
    own, stage = walking()
    steady, unturned = (feet(stage, own.rotations[0], own.contacts[0]) for feet in (steady_feet, unturned_feet))
    assert np.rad2deg(quaternion.angle(steady, unturned).max()) < 0.5
    assert quaternion.angle(unturned, own.rotations[0]).max() < PLAY


def test_mirroring_the_recording_mirrors_its_steady_feet() -> None:
    """Left and right are treated alike, but for their soles, which are found each by itself."""
    own, stage = walking()
    one = steady_feet(stage, own.rotations[0], own.contacts[0])
    other = steady_feet(stage, own.rotations[1], own.contacts[1])
    left, right = stage.legs.feet
    assert np.allclose(
        quaternion.angle(one[:, left], own.rotations[0, :, left]),
        quaternion.angle(other[:, right], own.rotations[1, :, right]),
        atol=1e-4,
    )


@pytest.mark.parametrize(("fps", "changes"), [(10.0, False), (30.0, True), (120.0, True)])
def test_frames_too_far_apart_are_not_averaged(fps: float, changes: bool) -> None:
    """Ten frames a second tell nothing of a tremble."""
    own, stage = walking(fps)
    leaping = flickering(stage, [own.frame_count // 2])
    everywhere = np.ones((len(leaping), 2), dtype=np.bool_)
    steady, unturned = (feet(stage, leaping, everywhere) for feet in (steady_feet, unturned_feet))
    assert np.allclose(steady, unturned, atol=1e-12) is not changes


@pytest.mark.parametrize("name", ["07/07_01", "35/35_01"])
def test_ankles_of_flickering_feet_do_not_leap(name: str, shared_data: Path) -> None:
    """Toes of these walkers flip by 14 to 28° in a frame while they bear; the ankles above them go on smoothly."""
    piece = kx.performance([kx.read(shared_data / "cmu" / f"{name}.amc")], seconds=15, seed=3)
    assert piece.check.contacts > 20
    assert not piece.check.leaps
    assert piece.check.slides == 0


@pytest.mark.parametrize("fps", [60.0, 120.0])
def test_steady_feet_stay_within_the_range_recorded(fps: float) -> None:
    """A foot that flips from side to side, turned outwards all the while: half-way it would be turned farther out than ever."""
    own, stage = walking(fps)
    rotations = own.rotations.copy()
    foot = stage.legs.feet[0]
    sides = 0.6 * (-1.0) ** np.arange(own.frame_count)
    rotations[:, :, foot] = quaternion.from_rotvec(np.stack([sides, np.full_like(sides, 0.4), 0.0 * sides], axis=-1))
    flipping = Stage.of(replace(own, rotations=rotations))
    everywhere = np.ones((own.frame_count, 2), dtype=np.bool_)
    vectors = quaternion.offset(flipping.middle[foot], steady_feet(flipping, rotations[0], everywhere)[:, foot])
    assert np.ptp(vectors[20:-20, 0]) < 0.5
    assert (vectors <= flipping.high[foot] + 1e-9).all()
    assert (vectors >= flipping.low[foot] - 1e-9).all()


def tube(frames: int, seed: int) -> tuple[Array, Array, Array]:
    """Its floor, its ceiling and where along it each frame lies, shape (frames,); in one frame of five it is closed."""
    rng = np.random.default_rng(seed)
    middle = np.cumsum(rng.normal(size=frames))
    width = rng.uniform(0.0, 1.5, frames) * (rng.random(frames) > 0.2)
    return middle - width, middle + width, np.cumsum(rng.uniform(0.05, 1.0, frames))


@pytest.mark.skipif(compiled.native is None, reason="The compiled kernels were not built.")
@settings(deadline=None)
@given(st.integers(1, 200), st.integers(0, 2**32 - 1), st.sampled_from([1.0, 0.1]))
def test_a_string_is_pulled_as_taut_without_the_compiled_module(frames: int, seed: int, rough: float) -> None:
    """Also where it is level, or the tube closed from end to end."""
    low, high, at = tube(frames, seed)
    low, high = rough * low - (1.0 - rough), rough * high + (1.0 - rough)
    for floor in (low, high):
        found = taut(floor, high, at)
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("KINESICS_NO_NATIVE", "1")
            np.testing.assert_allclose(found, taut(floor, high, at), rtol=0.0, atol=1e-12)


@given(st.integers(2, 25), st.integers(0, 2**32 - 1))
def test_a_taut_line_is_the_least_of_all_in_its_tube(frames: int, seed: int) -> None:
    """As the twin finds it, which knows of no corners."""
    low, high, at = tube(frames, seed)
    found = taut(low, high, at)
    assert (found >= low - 1e-9).all()
    assert (found <= high + 1e-9).all()
    assert naive.slopes(found, at) <= naive.slopes(naive.taut(low, high, at), at) + 1e-5
    # time the other way round, and up for down
    np.testing.assert_allclose(taut(low[::-1], high[::-1], -at[::-1])[::-1], found, atol=1e-9)
    np.testing.assert_allclose(-taut(-high, -low, at), found, atol=1e-9)


def heading(turned: Array) -> Array:
    """Where +z of orientations (frames, 4) points, radians."""
    ahead = quaternion.rotate(turned, np.array([0.0, 0.0, 1.0]))
    return np.asarray(np.unwrap(np.arctan2(ahead[:, 0], ahead[:, 2])))


def about(degrees: Array) -> Array:
    """Orientations that head so many degrees to the left, the toes a little up."""
    up = quaternion.from_rotvec(np.array([-0.1, 0.0, 0.0]))
    turns = np.stack([0.0 * degrees, np.deg2rad(degrees), 0.0 * degrees], axis=-1)
    return quaternion.multiply(quaternion.from_rotvec(turns), up)


def test_a_bearing_foot_that_is_turned_to_and_fro_stands_still() -> None:
    """By 5° either way while it bears; in the air it turns as it does, and nowhere does it leap."""
    t = np.arange(240) / FPS
    recorded = about(5.0 * np.sin(2.0 * np.pi * t))
    standing = (t > 0.5) & (t < 1.5)
    still = unturning(recorded, np.array([0.0, 0.0, 1.0]), np.ones(240), standing, FPS)
    assert np.ptp(np.rad2deg(heading(recorded)[standing])) > 9.9
    assert np.ptp(np.rad2deg(heading(still)[standing])) < 1.0
    away = (t < 0.3) | (t > 1.7)
    assert np.allclose(still[away], recorded[away], atol=1e-12)
    assert quaternion.angle(still, recorded).max() <= PLAY + 1e-9
    # it begins and ceases to turn within .15 s: in a frame by no more than a degree
    assert np.rad2deg(np.abs(np.diff(heading(still)))).max() < 1.0


def test_a_foot_that_pivots_does_so_once_and_where_it_is_not_flat() -> None:
    """By 40° while only its heel bears, with a tremble of 3°: before and after it stands."""
    t = np.arange(360) / FPS
    turns = 40.0 * np.clip((t - 1.0) / 0.5, 0.0, 1.0) + 3.0 * np.sin(9.0 * t)
    flat = np.where((t > 0.8) & (t < 1.7), 0.0, 1.0)
    still = unturning(about(turns), np.array([0.0, 0.0, 1.0]), flat, np.ones(360, dtype=np.bool_), FPS)
    found = np.rad2deg(heading(still))
    assert np.ptp(found[t < 0.7]) < 0.5
    assert np.ptp(found[t > 1.8]) < 0.5
    assert found[-1] - found[0] > 40.0 - 2.0 * np.rad2deg(PLAY) - 3.0
    assert (np.diff(found) > -1e-6).all()


def test_feet_that_do_not_bear_head_as_they_did() -> None:
    """And nothing but feet is touched."""
    own, stage = walking()
    nowhere = np.zeros((own.frame_count, 2), dtype=np.bool_)
    assert np.abs(quaternion.angle(unturned_feet(stage, own.rotations[0], nowhere), own.rotations[0])).max() < 1e-6


@pytest.mark.parametrize("name", ["07/07_01", "86/86_01", "135/135_11"])
def test_heel_and_ball_stay_while_they_are_down(name: str, shared_data: Path) -> None:
    """Less than a quarter of what they shift in the recording goes more than a centimetre."""
    piece = kx.performance([kx.read(shared_data / "cmu" / f"{name}.amc")], seconds=15, seed=3)
    found = measure(piece.performance, piece.network.repertoire)
    assert found.shift.performance < 0.5 * found.shift.recordings
    assert found.shifts_over.performance < 0.5 * found.shifts_over.recordings
