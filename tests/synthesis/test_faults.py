"""Where a recording leaps it is not performed if there is a choice, and what is performed of it is told."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import kinesics as kx
from bodies import rounds
from floor_networks import Path, floor_network
from kinesics.body.motion import Motion
from kinesics.geometry import quaternion
from kinesics.synthesis.control.courses import perform_paths
from kinesics.synthesis.goals import Target
from kinesics.synthesis.joining import faults
from kinesics.synthesis.joining.parts import Draft
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.repertoire import repertoire


def flipped(motion: Motion, *frames: int, angle: float = 2.0) -> Motion:
    """The same, with an upper arm thrown aside in single frames."""
    rotations = motion.rotations.copy()
    joint = motion.skeleton.joint_index["LeftArm"]
    turn = quaternion.from_rotvec(np.array([0.0, angle, 0.0]))
    for frame in frames:
        rotations[frame, joint] = quaternion.multiply(rotations[frame, joint], turn)
    return motion.replace(rotations=rotations)


def test_a_fault_is_seen_in_the_recording_as_it_came() -> None:
    """At a quarter of the rate the leap would be none, or not be there; the frames about it are marked."""
    motion = flipped(rounds(fps=120.0), *range(801, 807), angle=1.0)
    assert np.flatnonzero(repertoire(motion).faults).tolist() == list(range(800, 808))
    assert np.flatnonzero(repertoire(motion, fps=30.0).faults).tolist() == [200, 201, 202]
    assert not repertoire(rounds(fps=120.0)).faults.any()


def test_what_leaps_away_and_back_is_mended_and_told() -> None:
    """For a frame: then it is no fault that would be left out; the recording itself stays as it is."""
    sound, leaping = rounds(fps=120.0), flipped(rounds(fps=120.0), 801, angle=1.0)
    stock = repertoire(leaping)
    assert not stock.faults.any()
    apart = quaternion.angle(stock.rotations, repertoire(sound).rotations)
    assert apart.max() < 0.02
    (told,) = [line for line in stock.assumptions if "mended" in line]
    assert "1 frame mended, in which the capture leaps away and back by up to " in told
    assert not any("mended" in line for line in repertoire(sound).assumptions)


def test_what_hardly_moves_anything_is_no_fault_to_be_left_out() -> None:
    """A hand that turns about its own length, as markers lost for a frame make it."""
    motion = rounds(fps=120.0)
    rotations = motion.rotations.copy()
    joint = motion.skeleton.joint_index["LeftHand"]
    rotations[600, joint] = quaternion.multiply(
        rotations[600, joint], quaternion.from_rotvec(np.array([0.5, 0.0, 0.0]))
    )
    assert not repertoire(motion.replace(rotations=rotations)).faults.any()


def test_a_fault_is_left_out_and_told() -> None:
    """Of a march that comes round again and again; in every strand, with hardly anything beside it."""
    sound, leaping = (network(repertoire(motion)) for motion in (rounds(), flipped(rounds(), 240)))
    stock = leaping.repertoire
    assert stock.faults.any()
    assert not leaping.leaping.any()
    assert leaping.seconds > 0.9 * sound.seconds
    (why,) = {s.why for p in leaping.pruned for s in p.stretches if s.start < 8.0 < s.end}
    assert why == "a fault of the recording, in which the body leaps"


def test_a_fault_that_much_leads_through_is_kept() -> None:
    """Two rings of paths, from the one to the other by a single path: without it one of them would be lost."""
    stock = repertoire(rounds())
    first = np.arange(0, 480, 60)
    before = np.array([0, 1, 1, 2, 3, 3, 4, 5, 6, 6, 7])
    after = np.array([1, 2, 3, 3, 0, 4, 5, 6, 7, 5, 0])
    cut = Draft(first, first + 59, np.full(8, 60), before, after, np.full(11, -1))

    def marked(*paths: int) -> np.ndarray:
        mask = np.zeros(480, dtype=np.bool_)
        for path in paths:
            mask[60 * path : 60 * path + 60] = True
        return mask

    for given, left in (((4,), ()), ((7,), ()), ((2,), (2,)), ((2, 4), (2,)), ((), ())):
        leaping = dataclasses.replace(stock, faults=marked(*given))
        np.testing.assert_array_equal(faults.left_out(leaping, cut), marked(*left))


def test_where_there_is_a_choice_the_sound_way_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two ways that are the same but for a fault the other; where both have one, left and right in turn."""
    paths = [Path(name, 10, 1.0, 0.0) for name in ("walk", "fault", "sound")]
    paths += [Path("left", 10, 0.5, 1.5), Path("right", 10, 0.5, -1.5)]
    net = floor_network(paths, {"walk": ["fault", "sound", "left", "right"]} | {p.name: ["walk"] for p in paths[1:]})

    def taken(*leaping: bool) -> set[int]:
        monkeypatch.setattr(Network, "leaping", np.array([*leaping, False, False]))
        course = perform_paths(net, Target((0.0, 30.0)), 40.0, 3, finish=True)
        assert course.attained
        return set(course.paths.tolist())

    assert taken(False, False, False) == {0, 1, 2}
    assert taken(False, True, False) == {0, 2}
    assert taken(False, True, True) == {0, 3, 4}


def test_what_is_performed_of_a_fault_is_told() -> None:
    """When, and that it is the recordings'."""
    piece = kx.performance(flipped(rounds(8.0), *range(30, 210, 15)), seconds=20.0)
    stock = piece.network.repertoire
    played = stock.faults[stock.frame_of(piece.course.moments)]
    assert played.any()
    (told,) = [w for w in piece.motion.warnings if w.startswith("the body leaps at ")]
    assert f"{np.flatnonzero(played)[0] / piece.motion.fps:.1f} s" in told


@pytest.mark.parametrize("count", [1, 3])
def test_edges_of_faults_are_where_they_begin_and_end(count: int) -> None:
    """But not where recordings do."""
    mask = np.zeros(20, dtype=np.bool_)
    mask[:2] = mask[9:12] = True
    starts = np.array([0, 9, 20]) if count == 3 else np.array([0, 20])
    assert faults.edges(mask, starts).tolist() == ([2, 12] if count == 3 else [2, 9, 12])
