"""Feet that bear stay where they are, without making worse what was good."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import kinesics as kx
from kinesics.body import contacts, kinematics
from kinesics.synthesis.embodiment import planting
from kinesics.synthesis.embodiment.checking import check, slide
from kinesics.synthesis.embodiment.rehearsal import played
from kinesics.synthesis.embodiment.rendering import render
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.paths.network import network
from kinesics.synthesis.repertoire import Repertoire, repertoire

Array = NDArray[np.float64]


def standing(shared: Path, folder: Path, name: str) -> kx.Motion:
    """A recording in which both feet bear all the time."""
    with zipfile.ZipFile(shared / "bandai-namco" / "clips.zip") as archive:
        inside = next(n for n in archive.namelist() if Path(n).name == f"{name}.bvh")
        path = folder / f"{name}.bvh"
        path.write_bytes(archive.read(inside))
    return kx.read(path)


@pytest.mark.parametrize("name", ["dataset-1_bye_normal_001", "dataset-1_bow_active_001"])
def test_who_stands_goes_on_standing(name: str, shared_data: Path, tmp_path: Path) -> None:
    """Hips and knees that hardly move in a recording have hardly any range; feet that stand in it stand when it is planted."""
    own = repertoire(standing(shared_data, tmp_path, name))
    stage = Stage.of(own)
    planted = played(stage)
    known = kinematics.forward(own.skeleton, planted.rotations[0], planted.root_positions[0])
    soles = stage.soles.place(known.positions, known.rotations)
    for foot in (0, 1):
        assert slide(soles[2:, foot], soles[2:, foot, :, 1] - stage.levels[foot], own.fps) < 0.01


def test_loops_of_who_stands_stay_on_the_spot(shared_data: Path, tmp_path: Path) -> None:
    """A third of a second of a bow, over and over, its feet where they are."""
    made = network(repertoire(standing(shared_data, tmp_path, "dataset-1_bow_active_001")))
    rng = np.random.default_rng(2)
    paths = [int(rng.integers(len(made)))]
    while len(paths) < 60:
        nexts = made.successors(paths[-1])
        jumps = nexts[made.first[nexts] != made.onward[paths[-1]]]
        paths.append(int(rng.choice(jumps if len(jumps) else nexts)))
    found = check(render(made, paths), made)
    assert found.slides == 0
    assert found.below_floor < 0.01


def test_legs_that_go_back_towards_their_source_do_not_sink(shared_data: Path) -> None:
    """Who stands on one leg, where D may be little: what is taken back of planting does not put the foot below the floor."""
    made = network(repertoire(kx.read(shared_data / "cmu" / "49/49_18.amc")))
    paths = [0]
    while len(paths) < 12:
        paths.append(int(made.successors(paths[-1])[0]))
    found = check(render(made, paths), made)
    assert found.below_floor < 0.01
    assert found.distance <= found.accepted


def test_long_contacts_are_held_more_firmly() -> None:
    """As their length, from some seconds on: what a foot gives way in all does not grow."""
    bears = np.zeros(1000, dtype=np.bool_)
    bears[10:60] = True
    bears[100:900] = True
    firm = planting._firmly(bears, 50.0)
    assert (firm[:100] == 1.0).all()
    assert np.allclose(firm[100:900] ** 2, 800 / 50.0 / planting.LONG)


def test_ankles_do_not_leap_as_feet_are_let_go(shared_data: Path) -> None:
    """A runner's feet slide by centimetres a contact; in what is performed they catch up hardly quicker than recorded ones go."""
    run = kx.read(shared_data / "cmu" / "09" / "09_06.amc")
    done = kx.perform(run, seconds=20, seed=3)
    feet = [done.skeleton.joint_names.index(name) for name in ("lfoot", "rfoot")]

    def leaps(of: kx.Motion) -> Array:
        return np.linalg.norm(np.diff(of.positions()[:, feet], 2, axis=0), axis=-1)

    assert leaps(done).max() < 1.3 * leaps(run).max()


def test_feet_that_glide_as_recorded_are_not_thrown_where_they_are_let_go(shared_data: Path) -> None:
    """Who hops and turns has feet that leave the floor at 1 m/s and more: they are in motion before the last frame of a contact."""
    made = network(repertoire(kx.read(shared_data / "cmu" / "49/49_08.amc")))
    paths = [0]
    while len(paths) < 40:
        paths.append(int(made.successors(paths[-1])[0]))
    found = check(render(made, paths), made)
    assert found.contacts > 10
    assert not found.leaps
    assert not found.slides


def test_a_foot_is_held_by_decades_less_where_it_rolls_on_and_off() -> None:
    """Wholly in the middle of a contact, by the same at both ends, not at all in the air; whatever the frame rate."""
    for fps in (30.0, 60.0, 120.0):
        bears = np.zeros(round(2.0 * fps), dtype=np.bool_)
        on, off = round(0.5 * fps), round(1.5 * fps)
        bears[on:off] = True
        firm = planting._grip(bears, fps)
        away = 1 + np.minimum(np.arange(len(bears)) - on, off - 1 - np.arange(len(bears)))[bears]
        assert (firm[~bears] == 0.0).all()
        assert (firm[bears][away >= planting.GRIP * fps] == 1.0).all()
        assert (np.diff(firm[on : on + len(bears) // 4]) >= 0.0).all()
        assert np.allclose(firm[on:off], firm[on:off][::-1])
    # at 120 frames a second it glides in the last of them
    assert firm[on] < 0.003
    assert (planting._grip(np.ones(9, dtype=np.bool_), 60.0) == 1.0).all()
    assert (planting._grip(np.zeros(9, dtype=np.bool_), 60.0) == 0.0).all()


def test_a_runner_s_feet_are_on_the_ground_for_as_long_as_they_were(shared_data: Path) -> None:
    """Within a tenth, though they stand still where in the recording they slide; and they are not drawn to the floor besides."""
    own = repertoire(kx.read(shared_data / "cmu" / "09/09_06.amc"))
    stage, planted = Stage.of(own), played(Stage.of(own))

    def share(of: Repertoire) -> float:
        known = kinematics.forward(own.skeleton, of.rotations[0], of.root_positions[0])
        soles = stage.soles.place(known.positions, known.rotations)
        return float(contacts.touching(soles, soles[..., 1], own.fps, stage.stature, stage.slow).feet.mean())

    assert share(planted) == pytest.approx(share(own), rel=0.1)


def test_a_round_that_would_end_as_the_one_before_is_not_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where contacts slide on that nothing mends, more rounds are no more work; what another would make of the feet is known."""
    own = repertoire(kx.performer.walk(seconds=3, fps=60, seed=4).motion)
    stage = Stage.of(own)
    gone, plant = [], planting._planted

    def planted(*given: Any) -> planting.Footed:
        gone.append((given, plant(*given)))
        return gone[-1][1]

    monkeypatch.setattr(planting, "_planted", planted)
    monkeypatch.setattr(planting, "_PATIENCE", 100)
    monkeypatch.setattr(planting, "LET_PASS", -1.0)
    planting.pin(stage, own.rotations[0], own.root_positions[0], own.contacts[0], rounds=30)
    assert 2 <= len(gone) < 30
    given, last = gone[-1]
    again = plant(*given)
    np.testing.assert_array_equal(again.rotations, last.rotations)
    np.testing.assert_array_equal(again.roots, last.roots)
