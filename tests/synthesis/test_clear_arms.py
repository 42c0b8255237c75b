"""Arms kept clear of the body live."""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from kinesics.body import kinematics, mirroring
from kinesics.body.motion import Motion
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment.ranges import Ranges
from kinesics.synthesis.embodiment.stage import FLESH, Stage
from kinesics.synthesis.live.clear_arms import ClearArms
from kinesics.synthesis.live.renderer import LiveRenderer, performed
from kinesics.synthesis.paths.network import network
from kinesics.synthesis.repertoire import repertoire

Array = np.ndarray


@pytest.fixture(scope="module")
def stage() -> Stage:
    """Of arms that go about, on a body that has become stouter since: they are in it where they were beside it."""
    slim = Stage.of(repertoire(kx.performer.kata(fps=30, seed=1).motion))
    stout = dataclasses.replace(slim.capsules, radii=slim.capsules.radii + 0.04)
    return dataclasses.replace(slim, capsules=stout)


def deeper(stage: Stage, rotations: Array) -> Array:
    """By how much each pair with an arm is deeper than ever, metres, shape (frames, pairs)."""
    known = kinematics.forward(stage.repertoire.skeleton, rotations, np.zeros((len(rotations), 3)))
    names = stage.capsules.names
    arms = [
        n for n, pair in enumerate(stage.capsules.pairs) if any(names[m].endswith(("humerus", "radius")) for m in pair)
    ]
    return np.asarray((stage.capsules.depths(*known) - stage.deepest)[:, arms])


def with_an_arm_in_the_body(stage: Stage, rng: np.random.Generator, count: int) -> Array:
    """Recorded poses in which an arm is too deep in something, shape (at most ``count``, joints, 4)."""
    own = stage.repertoire.rotations[0]
    deep = deeper(stage, own).max(axis=1)
    some = np.flatnonzero((deep > FLESH) & (deep < 0.04))
    return own[rng.choice(some, min(count, len(some)), replace=False)]


@pytest.mark.parametrize("plain", ["0", "1"])
def test_arms_come_out(stage: Stage, rng: np.random.Generator, plain: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what they are too deep in, by shoulders that stay in their range; nothing else is turned, and nothing that is clear."""
    monkeypatch.setenv("KINESICS_NO_NATIVE", plain)
    given = with_an_arm_in_the_body(stage, rng, 30 if plain == "0" else 5)
    clear, done = ClearArms(stage), given.copy()
    for q in done:
        clear.put_clear(q)
    before, after = (np.maximum(deeper(stage, q).max(axis=1), 0.0) for q in (given, done))
    assert (after < 0.5 * before).all()
    assert np.mean(after <= FLESH) > 0.9
    roles = stage.repertoire.skeleton.anatomy.roles
    others = np.setdiff1d(np.arange(given.shape[1]), [roles.left_humerus, roles.right_humerus])
    assert np.array_equal(done[:, others], given[:, others])
    assert Ranges.of(stage).beyond(done).max() < 1e-6
    again = done[after <= 0.001]
    kept = again.copy()
    for q in kept:
        clear.put_clear(q)
    assert np.array_equal(kept, again)


def test_it_goes_on_without_a_snap(stage: Stage, rng: np.random.Generator) -> None:
    """As an arm goes into the body bit by bit, its shoulder is turned bit by bit."""
    clear = ClearArms(stage)
    for deep in with_an_arm_in_the_body(stage, rng, 5):
        free = stage.repertoire.rotations[0, 0]
        way = quaternion.slerp(free[None], deep[None], np.linspace(0.0, 1.0, 200)[:, None, None][..., 0])
        done = way.copy()
        for q in done:
            clear.put_clear(q)
        step = quaternion.angle(way[1:], way[:-1]).max()
        assert quaternion.angle(done[1:], done[:-1]).max() < 6.0 * step


def test_mirrored_arms_come_out_as_in_the_mirror(stage: Stage, rng: np.random.Generator) -> None:
    """What is done to the mirror image is the mirror image of what is done."""
    own, clear = stage.repertoire, ClearArms(stage)
    given = with_an_arm_in_the_body(stage, rng, 10)

    def mirrored(rotations: Array) -> Array:
        motion = Motion(own.skeleton, rotations, np.zeros((len(rotations), 3)), 30.0)
        return mirroring.mirror(motion).rotations.copy()

    done, image = given.copy(), mirrored(given)
    for q in (*done, *image):
        clear.put_clear(q)
    assert quaternion.angle(image, mirrored(done)).max() < np.deg2rad(0.5)


def test_dancers_arms_are_clear_live(shared_data: Path, tmp_path: Path) -> None:
    """Of two dances played on and over into one another: more than a centimetre deeper than recorded, were they not moved."""
    import zipfile

    motions = []
    with zipfile.ZipFile(shared_data / "bandai-namco" / "clips.zip") as archive:
        for name in sorted(archive.namelist()):
            if Path(name).name.startswith(("dataset-1_dance-short_normal", "dataset-1_dance-long_normal")):
                path = tmp_path / Path(name).name
                path.write_bytes(archive.read(name))
                motions.append(kx.read(path))
    made = network(repertoire(motions))
    rng = np.random.default_rng(1)
    paths = [int(rng.integers(len(made)))]
    while len(paths) < 120:
        paths.append(int(rng.choice(made.successors(paths[-1]))))
    frames = list(itertools.islice(LiveRenderer(made, paths), 900))
    assert deeper(Stage.of(made.repertoire), performed(made, frames).motion.rotations).max() < FLESH
