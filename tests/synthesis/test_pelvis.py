"""The pelvis turns so that hips stay in their range and feet where they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinesics as kx
from kinesics.body import kinematics
from kinesics.body.kinematics import Kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.checking import check
from kinesics.synthesis.embodiment.pelvis import FARTHEST, _turned, turned_for_the_hips
from kinesics.synthesis.embodiment.rendering import render
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.paths.network import network
from kinesics.synthesis.repertoire import Repertoire, repertoire

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def stage() -> Stage:
    """Of a walk and its mirror image."""
    walk = kx.performer.walk(seconds=6, fps=60, noise_degrees=0.3, noise_kind="smooth", route="circle", seed=3).motion
    return Stage.of(repertoire(walk))


def tilted(stage: Stage, image: int) -> tuple[Array, Array]:
    """The walk, its pelvis tilted forward by up to 4° for two seconds, trunk and feet where they were."""
    own: Repertoire = stage.repertoire
    rotations, roots = own.rotations[image], own.root_positions[image]
    known = kinematics.forward(own.skeleton, rotations, roots)
    feet = Kinematics(*(values[:, list(stage.legs.feet)] for values in known))
    turn = np.zeros((own.frame_count, 3))
    turn[120:240, 0] = np.deg2rad(4.0) * np.hanning(120)
    return _turned(stage, rotations, roots, feet, turn), roots


def beyond(stage: Stage, rotations: Array) -> Array:
    """Radians by which hips and knees are beyond their range, shape (frames,)."""
    joints = [*stage.legs.femurs, *stage.legs.tibias]
    at = blending.rotation_offset(stage.middle[joints], rotations[:, joints])
    over = np.maximum(at - stage.high[joints], stage.low[joints] - at)
    return np.asarray(np.maximum(over, 0.0).max(axis=(1, 2)))


def test_hips_come_back_and_feet_stay(stage: Stage) -> None:
    """Hips degrees beyond their range are within half of one, feet are where and as they were, as is all at other times."""
    rotations, roots = tilted(stage, 0)
    assert np.rad2deg(beyond(stage, rotations).max()) > 2.0
    out = turned_for_the_hips(stage, rotations, roots).rotations
    assert np.rad2deg(beyond(stage, out).max()) < 0.5
    skeleton, feet = stage.repertoire.skeleton, list(stage.legs.feet)
    was, now = (kinematics.forward(skeleton, q, roots) for q in (rotations, out))
    assert np.abs(was.positions[:, feet] - now.positions[:, feet]).max() < 1e-4
    assert quaternion.angle(was.rotations[:, feet], now.rotations[:, feet]).max() < 1e-6
    turned = quaternion.angle(rotations[:, stage.carrier], out[:, stage.carrier])
    assert 0.01 < turned.max() < FARTHEST + 1e-9
    assert np.array_equal(out[:60], rotations[:60])
    for joint in stage.trunk:
        assert quaternion.angle(was.rotations[:, joint], now.rotations[:, joint]).max() < turned.max()


def test_nothing_turns_where_nothing_is_beyond(stage: Stage) -> None:
    """The recordings themselves are handed back."""
    own = stage.repertoire
    rotations = own.rotations[0]
    assert turned_for_the_hips(stage, rotations, own.root_positions[0]).rotations is rotations


def test_walks_whose_hips_land_at_the_end_of_their_range(shared_data: Path) -> None:
    """Of three seconds of two walkers, with a transition at every other chance, hardly a contact slides more than 1 cm."""
    clips = [kx.read(shared_data / "cmu" / f"{clip}.amc") for clip in ("35/35_01", "16/16_21")]
    made = network(repertoire(clips))
    rng = np.random.default_rng(1)
    paths = [int(rng.integers(len(made)))]
    while len(paths) < 100:
        nexts = made.successors(paths[-1])
        jumps = nexts[made.first[nexts] != made.onward[paths[-1]]]
        stays = np.setdiff1d(nexts, jumps)
        paths.append(int(rng.choice(jumps)) if len(jumps) and (rng.random() < 0.5 or not len(stays)) else int(stays[0]))
    found = check(render(made, paths), made)
    assert found.contacts > 25
    assert found.slides <= 0.05 * found.contacts
    assert found.stays
