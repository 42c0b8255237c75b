"""Feet do not flicker where they bear; what they do in the air is theirs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinesics as kx
from kinesics.body import kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.embodiment.steady_feet import steady_feet
from kinesics.synthesis.repertoire import Repertoire, repertoire

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
    """Feet of a walk without any tremble are turned by half a degree at most."""
    own, stage = walking()
    steady = steady_feet(stage, own.rotations[0], own.contacts[0])
    assert np.rad2deg(quaternion.angle(steady, own.rotations[0]).max()) < 0.5


def test_mirroring_the_recording_mirrors_its_steady_feet() -> None:
    """Left and right are treated alike."""
    own, stage = walking()
    one = steady_feet(stage, own.rotations[0], own.contacts[0])
    other = steady_feet(stage, own.rotations[1], own.contacts[1])
    left, right = stage.legs.feet
    assert np.allclose(
        quaternion.angle(one[:, left], own.rotations[0, :, left]),
        quaternion.angle(other[:, right], own.rotations[1, :, right]),
        atol=1e-6,
    )


@pytest.mark.parametrize(("fps", "changes"), [(10.0, False), (30.0, True), (120.0, True)])
def test_frames_too_far_apart_are_left(fps: float, changes: bool) -> None:
    """Ten frames a second tell nothing of a tremble."""
    own, stage = walking(fps)
    leaping = flickering(stage, [own.frame_count // 2])
    steady = steady_feet(stage, leaping, np.ones((len(leaping), 2), dtype=np.bool_))
    assert np.array_equal(steady, leaping) is not changes


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
