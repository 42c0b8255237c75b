"""Arms go round what they would pass through."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import kinesics as kx
from kinesics.body import kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment.arms import _Moment, put_arms_clear
from kinesics.synthesis.embodiment.ranges import Ranges
from kinesics.synthesis.embodiment.stage import FLESH, Stage
from kinesics.synthesis.repertoire import repertoire


def test_arms_that_another_turn_has_freed_are_left() -> None:
    """Where nothing is too deep, no way round is taken, though ways were found for other moments of the movement."""
    made = repertoire(kx.performer.walk(seconds=4, fps=30.0, seed=1).motion)
    stage = Stage.of(made)
    names = list(stage.capsules.names)
    pair = stage.capsules.pairs.index((names.index("left radius"), names.index("right radius")))
    moment = _Moment.at(stage, made.rotations[0, :20], made.root_positions[0, :20], np.ones(20))
    sides = np.ones(2, dtype=np.bool_)
    for found in ([], [np.array([[0.1, 0.0, 0.0], [0.0, 0.0, 0.0]])]):
        assert not moment.way_round(pair, sides, found).any()


def test_arms_that_pass_through_each_other_go_round(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wrists crossed ahead of the chest, first the left above and then the right: one goes round the end of the other."""
    made = repertoire(kx.performer.walk(seconds=4, fps=30.0, seed=1).motion)
    stage = Stage.of(made)
    anatomy, skeleton = made.skeleton.anatomy, made.skeleton
    assert anatomy is not None
    roles = anatomy.roles
    shoulders = [roles.left_humerus, roles.right_humerus]
    frames = 60
    rotations = np.repeat(made.rotations[0, :1], frames, axis=0)
    rotations[:, [roles.left_radius, roles.right_radius]] = [1.0, 0.0, 0.0, 0.0]
    roots = np.repeat(made.root_positions[0, :1], frames, axis=0)
    above = 0.06 * np.cos(np.linspace(0.0, np.pi, frames))
    names = list(stage.capsules.names)
    for joint, side, sign in zip(shoulders, ("left", "right"), (1.0, -1.0), strict=True):
        known = kinematics.forward(skeleton, rotations, roots)
        at, middle = known.positions[:, joint], known.positions[:, shoulders].mean(axis=1)
        wrist = stage.capsules.ends(*known).ends[:, names.index(f"{side} radius")]
        far = np.linalg.norm(wrist - at, axis=-1)
        goal = middle + np.stack([np.full(frames, -0.02 * sign), sign * above, 0.9 * far], axis=-1)
        by = quaternion.between(wrist - at, goal - at)
        parent = known.rotations[:, skeleton.parents[joint]]
        turned = quaternion.multiply(quaternion.conjugate(parent), quaternion.multiply(by, known.rotations[:, joint]))
        rotations[:, joint] = turned
    low, high = np.full_like(stage.low, -3.0), np.full_like(stage.high, 3.0)
    pair = stage.capsules.pairs.index((names.index("left radius"), names.index("right radius")))
    free, own = dataclasses.replace(stage, low=low, high=high), Ranges.of(stage)
    bends = tuple(bends._replace(least=bends.least - np.pi, most=bends.most + np.pi) for bends in own.bends)
    freed = dataclasses.replace(own, low=low, high=high, bends=bends)
    monkeypatch.setattr(Ranges, "of", lambda _: freed)

    def deepest(q: np.ndarray) -> float:
        depths = stage.capsules.depths(*kinematics.forward(skeleton, q, roots)) - stage.deepest
        return float(depths[:, pair].max())

    assert deepest(rotations) > 0.02
    done = rotations.copy()
    put_arms_clear(free, done, roots)
    assert deepest(done) <= FLESH
    assert np.array_equal(done[[0, -1]], rotations[[0, -1]])
    turned = quaternion.angle(rotations[:, shoulders], done[:, shoulders])
    assert turned.max() < np.deg2rad(30.0)
    assert np.abs(np.diff(turned, axis=0)).max() < np.deg2rad(5.0)
