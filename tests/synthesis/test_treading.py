"""Feet kept in place live: the slow twin, which feet are held, and that nothing else of the body is touched."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.live.foresight import Foresight, Stretch
from kinesics.synthesis.live.treading import Treading
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.repertoire import repertoire
from naive import treading as naive


@pytest.fixture(scope="module")
def made() -> Network:
    """Of a walk in a circle and its mirror image."""
    walk = kx.performer.walk(seconds=8, fps=30, noise_degrees=0.5, noise_kind="smooth", route="circle", seed=4).motion
    return network(repertoire(walk))


def beside_the_twin(made: Network, count: int, rng: np.random.Generator) -> tuple[float, float, int, int]:
    """Frames that go on for a while and leap, slightly bent: greatest difference in radians and metres, frames with a leg held
    back, and with a thigh at the end of its range."""
    own = made.repertoire
    stage = Stage.of(own)
    here, twin = Treading(stage), naive.Treading(stage)
    foresight = Foresight.of(stage)
    inner = np.setdiff1d([*stage.legs.femurs, *stage.legs.tibias, *stage.legs.feet], [stage.carrier])
    turned = moved = 0.0
    frame = image = 0
    place = np.zeros(3)
    for k in range(count):
        if k % 25 == 0:
            frame, image = int(rng.integers(own.frame_count - 30)), int(rng.integers(2))
            leap = complex(*rng.normal(0.0, 0.03, 2))
            if k:
                here.leap(leap)
                twin.leap(leap)
            noise = quaternion.from_rotvec(rng.normal(0.0, 0.1, (len(inner), 3)))
        frame += 1
        rotations = own.rotations[image, frame].copy()
        rotations[inner] = quaternion.multiply(rotations[inner], noise)
        place += np.array([0.01, 0.0, 0.03])
        root = np.array([place[0], own.root_positions[image, frame, 1], place[2]])
        given = rotations.copy()
        left = 25 - k % 25
        coming = foresight.coming([Stretch(0, 0, image, frame, 1, left, 0.3, 0.01, [0j] * left)], 0)
        q, there = twin.step(given, root, image, frame, coming)
        found = np.array(here.step(rotations, tuple(root.tolist()), image, frame, coming))
        turned = max(turned, float(quaternion.angle(q, rotations).max()))
        moved = max(moved, float(np.abs(found - there).max()))
        others = np.setdiff1d(np.arange(own.skeleton.joint_count), twin.joints)
        assert np.array_equal(rotations[others], given[others])
    return turned, moved, twin.slips, twin.held_back


@pytest.mark.parametrize("plain", ["0", "1"])
def test_treads_like_the_twin(
    made: Network, rng: np.random.Generator, plain: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same rotations and root as the twin's, which places the whole body, also where legs are at their limits; with legs
    that are compiled, and in plain numbers.
    """
    monkeypatch.setenv("KINESICS_NO_NATIVE", plain)
    turned, moved, slipped, held_back = beside_the_twin(made, 250 if plain == "0" else 80, rng)
    assert turned < 1e-6
    assert moved < 1e-7
    assert slipped > 10
    assert held_back > 10


def test_treads_like_the_twin_on_real_bodies(shared_data: Path, rng: np.random.Generator) -> None:
    """A run of a body whose knees are hinges, as recorded."""
    run = kx.read(shared_data / "cmu" / "09" / "09_06.amc").resample(30.0)
    turned, moved, *_ = beside_the_twin(network(repertoire([run])), 100, rng)
    assert turned < 1e-6
    assert moved < 1e-7
