"""Toes end above the floor, however far a recording bends them down."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinesics as kx
from kinesics.body import kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment.rehearsal import played
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.embodiment.toes import Ends, toes_above_the_floor, usual_heights
from kinesics.synthesis.repertoire import repertoire

Array = NDArray[np.float64]


def ends_above(stage: Stage, rotations: Array, roots: Array) -> Array:
    """Height of the end of the toes of each foot, the naive way: (frames, n)."""
    skeleton = stage.repertoire.skeleton
    motion = kx.Motion(skeleton, rotations, roots, stage.repertoire.fps)
    places, turned = motion.positions(), motion.global_rotations()
    out = []
    for joint, site in zip(Ends.of(stage).joints.tolist(), Ends.of(stage).sites, strict=True):
        out.append([(places[t, joint] + quaternion.rotate(turned[t, joint], site))[1] for t in range(len(places))])
    return np.array(out).T


@pytest.fixture(scope="module")
def stage(shared_data: Path) -> Stage:
    """Of a recording whose right toes are bent down far below the sole that bears."""
    return Stage.of(repertoire(kx.read(shared_data / "cmu" / "86" / "86_01.amc").resample(30.0)))


def test_toes_that_dig_into_the_floor_are_bent_up(stage: Stage) -> None:
    """As they are planted, in both images; in the recording they end centimetres below it."""
    own, planted = stage.repertoire, played(stage)
    usual = usual_heights(stage, planted)
    assert len(usual) == 2
    recorded = ends_above(stage, own.rotations[0], own.root_positions[0])
    assert (recorded < -0.015).mean() > 0.03
    for image in (0, 1):
        found = ends_above(stage, planted.rotations[image], planted.root_positions[image])
        assert found.min() > usual.min() - 0.012


def test_only_toes_that_dig_are_bent_and_legs_where_those_go_no_farther(stage: Stage) -> None:
    """Raised by half a metre nothing is changed; on the floor toes, and legs in few frames, by little; the trunk never."""
    own = stage.repertoire
    rotations, roots = own.rotations[0], own.root_positions[0]
    usual = usual_heights(stage, own)
    high = toes_above_the_floor(stage, rotations, roots + np.array([0.0, 0.5, 0.0]), usual)
    assert np.array_equal(high, rotations)
    bent = toes_above_the_floor(stage, rotations, roots, usual)
    toes = Ends.of(stage).joints
    legs = np.array([*stage.legs.femurs, *stage.legs.tibias, *stage.legs.feet])
    others = np.setdiff1d(np.arange(own.skeleton.joint_count), [*toes, *legs])
    assert np.array_equal(bent[:, others], rotations[:, others])
    raised = quaternion.angle(bent[:, legs], rotations[:, legs]).max(axis=1)
    assert 0.0 < (raised > 1e-6).mean() < 0.15
    assert raised.max() < np.deg2rad(25.0)
    turn = quaternion.angle(bent[:, toes], rotations[:, toes])
    assert turn.max() > np.deg2rad(5.0)
    assert (turn < 1e-9).mean() > 0.3
    known = kinematics.forward(own.skeleton, bent, roots)
    height = known.positions[:, toes, 1] + Ends.of(stage).beneath(known)[..., 1]
    np.testing.assert_allclose(height, ends_above(stage, bent, roots), atol=1e-12)


def test_toes_of_a_walk_stay_as_they_are() -> None:
    """Of a body whose toes end on the floor."""
    own = repertoire(kx.performer.walk(seconds=4, fps=60, seed=2).motion)
    stage = Stage.of(own)
    planted = played(stage)
    usual = usual_heights(stage, planted)
    again = toes_above_the_floor(stage, planted.rotations[0], planted.root_positions[0], usual)
    assert quaternion.angle(again, planted.rotations[0]).max() < 1e-6
