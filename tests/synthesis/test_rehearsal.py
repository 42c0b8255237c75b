"""Recordings performed beforehand with their feet on the ground: however long, and for no longer than they are wanted."""

from __future__ import annotations

import dataclasses
import gc
import weakref
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinesics as kx
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import rehearsal
from kinesics.synthesis.embodiment.checking import beyond
from kinesics.synthesis.embodiment.rehearsal import played
from kinesics.synthesis.embodiment.rendering import render
from kinesics.synthesis.embodiment.stage import Stage, turn_bodies
from kinesics.synthesis.paths.meeting import meetings, same_soles
from kinesics.synthesis.paths.network import network
from kinesics.synthesis.repertoire import Repertoire, repertoire

Array = NDArray[np.float64]


def from_frame_to_frame(of: Repertoire) -> tuple[Array, Array]:
    """By how much each joint turns (radians) and the root goes (metres) from each frame to the next: (frames − 1, ...)."""
    q, at = of.rotations[0], of.root_positions[0]
    return quaternion.angle(q[:-1], q[1:]), np.linalg.norm(np.diff(at, axis=0), axis=-1)


def creeping() -> Repertoire:
    """Who stands for twenty seconds on feet that creep round by 3° a second, as in a capture that drifts."""
    stand = kx.performer.stand(seconds=20, fps=30, seed=1).motion
    rotations = stand.rotations.copy()
    held = Stage.of(repertoire(stand))
    turn_bodies(held.repertoire, held.carrier, rotations, np.deg2rad(3.0) * np.arange(len(rotations)) / 30.0)
    return repertoire(stand.replace(rotations=rotations))


@pytest.mark.parametrize("name", ["", "14/14_06"])
def test_stretches_of_a_long_recording_meet_without_a_leap(
    name: str, shared_data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Planted in stretches of five seconds, nothing turns or goes more from frame to frame where they meet than elsewhere."""
    own = repertoire(kx.read(shared_data / "cmu" / f"{name}.amc").resample(30.0)) if name else creeping()
    whole = from_frame_to_frame(played(Stage.of(own)))
    monkeypatch.setattr(rehearsal, "_AT_ONCE", 150)
    again = repertoire(own.motion(0))
    stage = Stage.of(again)
    planted = played(stage)
    parts = from_frame_to_frame(planted)
    assert own.frame_count > 450
    assert beyond(planted.motion(0), stage).max() < 1e-6
    for one, other, little in zip(whole, parts, (np.deg2rad(0.5), 0.002), strict=True):
        assert np.abs(other - one).max() < little + 0.25 * one.max()


def test_the_heading_is_that_of_the_body_as_it_is_played(shared_data: Path) -> None:
    """Where it turned with its feet, it is laid as it turned: told to face ahead it does, and so it goes on."""
    own = repertoire(creeping().motion(0))
    planted = played(Stage.of(own))
    assert np.abs(planted.turned_at(np.arange(own.frame_count))).max() > np.deg2rad(20.0)
    for image in (0, 1):
        motion = kx.Motion(own.skeleton, planted.rotations[image], planted.root_positions[image], own.fps)
        moments = own.moments(np.arange(own.frame_count), image)
        off = np.angle(np.exp(1j * (kx.poses(motion).yaw - planted.yaw_of(moments))))
        assert np.abs(off).max() < np.deg2rad(1.0)
    walk = network(repertoire(kx.read(shared_data / "cmu" / "49/49_18.amc")))
    for path in (0, len(walk) // 2, len(walk) - 1):
        faced = kx.poses(render(walk, [path], heading=0.7).motion).yaw[0]
        assert faced == pytest.approx(0.7, abs=np.deg2rad(1.0))


def test_planted_bodies_meet_as_they_are_played(shared_data: Path) -> None:
    """The legs of a real body differ: its mirror image, planted, is met as the recording would be of which it were the one."""
    own = repertoire(kx.read(shared_data / "cmu" / "91/91_01.amc"))
    planted = played(Stage.of(own))
    bears = own.contacts[0]
    changed = dataclasses.replace(
        planted,
        rotations=planted.rotations[::-1],
        root_positions=planted.root_positions[::-1],
        turned=None if planted.turned is None else planted.turned[::-1],
        contacts=np.stack([bears[:, ::-1], bears]),
        poses=own.poses.mirror(),
    )
    same_soles(changed, own)
    rng = np.random.default_rng(1)
    left, entered = rng.integers(own.frame_count, size=(2, 200))
    one = meetings(planted, own.moments(left, 1), own.moments(entered, 1))
    other = meetings(changed, left, entered)
    assert np.allclose(one.place, other.place, atol=1e-9)
    assert np.allclose(one.turn, other.turn, atol=1e-9)
    image = meetings(planted, left, entered)
    assert np.abs(one.place[:, 1] - image.place[:, 1]).max() > 1e-3


def test_what_is_measured_on_a_repertoire_goes_with_it() -> None:
    """Stage, soles and what is played are kept as long as the repertoire is, and no longer."""
    own = repertoire(kx.performer.walk(seconds=3, fps=30, seed=2).motion)
    stage = Stage.of(own)
    assert Stage.of(own) is stage
    assert played(stage) is played(stage)
    seen = [weakref.ref(own), weakref.ref(stage), weakref.ref(played(stage))]
    del own, stage
    gc.collect()
    assert [ref() for ref in seen] == [None, None, None]
