"""Feet kept in place live: the slow twin, which feet are held, and that nothing else of the body is touched."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment.stage import FLESH, Stage
from kinesics.synthesis.live.clear_legs import ClearLegs
from kinesics.synthesis.live.foresight import Foresight, Stretch
from kinesics.synthesis.live.renderer import LiveRenderer, performed
from kinesics.synthesis.live.treading import Treading
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.repertoire import repertoire
from naive import treading as naive


@pytest.fixture(scope="module")
def made() -> Network:
    """Of a walk in a circle and its mirror image."""
    walk = kx.performer.walk(seconds=8, fps=30, noise_degrees=0.5, noise_kind="smooth", route="circle", seed=4).motion
    return network(repertoire(walk))


def beside_the_twin(made: Network, count: int, rng: np.random.Generator) -> tuple[float, float, int, int, int]:
    """Frames that go on for a while and leap, slightly bent: greatest difference in radians and metres, frames with a leg held
    back, with a thigh at the end of its range, and times that a foot goes aside for the other leg."""
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
    return turned, moved, twin.slips, twin.held_back, twin.asides


@pytest.mark.parametrize("plain", ["0", "1"])
def test_treads_like_the_twin(
    made: Network, rng: np.random.Generator, plain: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same rotations and root as the twin's, which places the whole body, also where legs are at their limits; with legs
    that are compiled, and in plain numbers.
    """
    monkeypatch.setenv("KINESICS_NO_NATIVE", plain)
    turned, moved, slipped, held_back, aside = beside_the_twin(made, 250 if plain == "0" else 80, rng)
    assert turned < 1e-6
    assert moved < 1e-7
    assert slipped > 10
    assert held_back > 10
    assert aside > 5


def test_treads_like_the_twin_on_real_bodies(shared_data: Path, rng: np.random.Generator) -> None:
    """A run of a body whose knees are hinges, as recorded."""
    run = kx.read(shared_data / "cmu" / "09" / "09_06.amc").resample(30.0)
    turned, moved, *_ = beside_the_twin(network(repertoire([run])), 100, rng)
    assert turned < 1e-6
    assert moved < 1e-7


def leg_at(hip: float, x: float, z: float) -> tuple[tuple[float, float, float], ...]:
    """Hip, knee and ankle of a straight leg, whose hip is so far to the left, its ankle over a place."""
    return (hip, 0.9, 0.0), (0.5 * (hip + x), 0.48, 0.5 * z), (x, 0.06, z)


def aside(stage: Stage, left: tuple, right: tuple, free: list[float]) -> list[complex]:
    """How far feet go aside, of legs given as `leg_at`."""
    hips, knees, ankles = (list(pair) for pair in zip(left, right, strict=True))
    return ClearLegs(stage).aside(hips, knees, ankles, free)


def test_a_foot_that_swings_goes_aside_for_the_leg_that_bears(made: Network) -> None:
    """Only it, by as much as brings the legs apart, from whichever side it comes; legs that are apart are left alone."""
    stage = Stage.of(made.repertoire)
    bears = leg_at(0.09, 0.02, 0.0)
    for angle in np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False).tolist():
        x, z = 0.02 + 0.03 * np.cos(angle), 0.03 * np.sin(angle)
        stays, goes = aside(stage, bears, leg_at(-0.09, x, z), [0.0, 1.0])
        assert stays == 0j
        # back to the side that its hip is on, by no more than it may
        assert goes.imag < -0.05
        assert abs(goes) <= 0.08 + 1e-12
        assert goes.real * z >= -1e-9
        # as in a mirror
        assert aside(stage, leg_at(0.09, -x, z), leg_at(-0.09, -0.02, 0.0), [1.0, 0.0]) == pytest.approx(
            [goes.conjugate(), 0j], abs=1e-5
        )
        assert aside(stage, bears, leg_at(-0.09, x, z), [0.0, 0.0]) == [0j, 0j]
    assert aside(stage, bears, leg_at(-0.09, -0.12, 0.3), [1.0, 1.0]) == [0j, 0j]


def test_legs_of_walkers_do_not_pass_through_each_other_live(shared_data: Path) -> None:
    """Of bodies of other breadth on one skeleton: more than 2 cm deeper than recorded, were feet not to go aside."""
    made = network(
        repertoire([kx.read(shared_data / "cmu" / f"{n}.amc").resample(60.0) for n in ("35/35_01", "16/16_21")])
    )
    stage = Stage.of(made.repertoire)
    rng = np.random.default_rng(2)
    paths = [0]
    while len(paths) < 40:
        nexts = made.successors(paths[-1])
        jumps = nexts[made.first[nexts] != made.onward[paths[-1]]]
        paths.append(int(rng.choice(jumps if len(jumps) else nexts)))
    done = performed(made, list(LiveRenderer(made, paths))).motion
    names = stage.capsules.names
    legs = [
        n for n, pair in enumerate(stage.capsules.pairs) if all(names[m].endswith(("femur", "tibia")) for m in pair)
    ]
    deeper = (stage.capsules.depths(done.positions(), done.global_rotations()) - stage.deepest)[:, legs]
    assert deeper.max() < 0.01
    assert np.mean((deeper > FLESH).any(axis=1)) < 0.005
