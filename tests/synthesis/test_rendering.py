"""Paths performed: laid end to end as the recordings say, without seams, feet in place, joints in range, live and at once."""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics as kx
from bodies import rounds
from kinesics import compiled
from kinesics.body import contacts
from kinesics.body.contacts import Floor
from kinesics.body.limits import Capsules
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import checking, planting, quality
from kinesics.synthesis.embodiment.ranges import envelope
from kinesics.synthesis.embodiment.rendering import render
from kinesics.synthesis.embodiment.stage import FLESH, LEAST_TURNING, Stage, turn_bodies
from kinesics.synthesis.live.renderer import LiveRenderer
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.repertoire import repertoire
from naive import rendering as naive


def walking(made: Network, count: int, seed: int, hold: float = 0.5) -> list[int]:
    """Paths at random: a transition whenever none was for ``hold`` seconds and there is one."""
    rng = np.random.default_rng(seed)
    paths, since = [int(rng.integers(len(made)))], 0.0
    while len(paths) < count:
        since += float(made.duration[paths[-1]])
        nexts = made.successors(paths[-1])
        jumps = nexts[made.first[nexts] != made.onward[paths[-1]]]
        stays = np.setdiff1d(nexts, jumps)
        if len(jumps) and (since > hold or not len(stays)):
            paths.append(int(rng.choice(jumps)))
            since = 0.0
        else:
            paths.append(int(stays[0]))
    return paths


@pytest.fixture(scope="module")
def made() -> Network:
    """Of a walk in a circle and its mirror image."""
    walk = kx.performer.walk(seconds=12, fps=30, noise_degrees=0.3, noise_kind="smooth", route="circle", seed=3).motion
    return network(repertoire(walk))


@pytest.fixture(scope="module")
def paths(made: Network) -> list[int]:
    """A stroll of some ten seconds."""
    return walking(made, 60, 1)


def test_recording_goes_on_as_it_was(made: Network) -> None:
    """Without a transition and without pinning, what is performed is the recording, turned and shifted."""
    chosen = [0]
    for _ in range(6):
        nexts = made.successors(chosen[-1])
        onward = nexts[made.first[nexts] == made.onward[chosen[-1]]]
        if not len(onward):
            break
        chosen.append(int(onward[0]))
    done = render(made, chosen, pinned=False)
    own = made.repertoire
    assert len(done.cuts) == 0
    assert not done.provenance.transition.any()
    assert np.allclose(
        quaternion.angle(done.motion.rotations[:, 1:], own.rotations_of(done.provenance.moment)[:, 1:]), 0.0
    )
    moved = np.linalg.norm(np.diff(done.motion.root_positions, axis=0), axis=1)
    assert np.allclose(moved, np.linalg.norm(np.diff(own.roots_of(done.provenance.moment), axis=0), axis=1), atol=1e-9)


def test_paths_are_laid_as_the_twin_lays_them(made: Network, paths: list[int]) -> None:
    """Place and heading of every frame away from transitions are those of adding up the recordings' steps."""
    bend = np.random.default_rng(2).uniform(-0.2, 0.2, len(paths))
    done = render(made, paths, start=(2.0, -1.0), heading=0.7, bend=bend, pinned=False)
    twin = np.array(naive.laid(made, paths, (2.0, -1.0), 0.7, bend.tolist()))
    away = ~done.provenance.transition
    assert away.sum() > 25
    assert np.abs(done.motion.root_positions[away][:, [0, 2]] - twin[away][:, :2]).max() < 1e-9
    turned = kx.poses(done.motion).yaw[away] - twin[away][:, 2]
    assert np.abs(np.arctan2(np.sin(turned), np.cos(turned))).max() < 1e-6
    assert done.motion.root_positions[0, [0, 2]] == pytest.approx([2.0, -1.0])


def test_network_tells_where_paths_lead(made: Network, paths: list[int]) -> None:
    """Displacements, turns and meetings of the network are what the performance does, to the millimetre after many paths."""
    assert made.meeting is not None
    place, heading = 0j, 0.0
    for before, p in itertools.pairwise([-1, *paths[:-1]]):
        if before >= 0:
            edge = int(made.edges(before, p))
            place += (made.meeting.place[edge, 1] + 1j * made.meeting.place[edge, 0]) * np.exp(1j * heading)
            heading += float(made.meeting.turn[edge])
        place += (made.displacement[p, 1] + 1j * made.displacement[p, 0]) * np.exp(1j * heading)
        heading += float(made.turn[p])
    live = LiveRenderer(made, paths, pinned=False, ahead=0.0)
    for _ in range(int(made.length[paths[:-1]].sum())):
        live.step()
    assert live.place == pytest.approx((place.imag, place.real), abs=1e-6)
    assert np.cos(live.heading - heading) == pytest.approx(1.0, abs=1e-9)


def test_no_seams(made: Network, paths: list[int]) -> None:
    """At the cuts no joint turns by more from frame to frame than it does anywhere in the recording, and a little."""
    done = render(made, paths, pinned=False)
    assert len(done.cuts) > 5
    own = made.repertoire.rotations[0]
    usual = quaternion.angle(own[1:, 1:], own[:-1, 1:]).max(axis=0)
    steps = quaternion.angle(done.motion.rotations[1:, 1:], done.motion.rotations[:-1, 1:])
    assert np.all(steps[done.cuts - 1] <= 1.15 * usual + np.deg2rad(0.5))
    assert np.abs(np.diff(done.motion.root_positions[:, 1])).max() < 0.03


def test_what_places_may_be_accelerated_by_makes_transitions_long(
    made: Network, paths: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not only how quick joints turn: a head that is moved by all of the spine takes more time than any joint of that."""
    own = Stage.of(made.repertoire)
    borne = []
    for times in (1.0, 0.1):
        other = dataclasses.replace(own, places=times * own.places)
        monkeypatch.setattr(Stage, "of", lambda _, stage=other: stage)
        borne.append(float(np.mean(1.0 - render(made, paths, pinned=False).provenance.weight)))
    assert borne[1] > 1.1 * borne[0]


def test_feet_stay_where_they_are_put(made: Network, paths: list[int]) -> None:
    """While a foot bears it slides less than 15 mm, most less than 2 mm, and no sole comes more than 1 cm below the floor."""
    done = render(made, paths)
    stage = Stage.of(made.repertoire)
    motion = done.motion
    places = done.soles.place(motion.positions(), motion.global_rotations())
    assert places[..., 1].min() > -0.01
    assert len(done.contacts) > 10
    slides = []
    for touch in done.contacts:
        sole = places[touch.start : touch.end, touch.foot]
        slides.append(checking.slide(sole, sole[..., 1] - stage.levels[touch.foot], motion.fps))
    assert max(slides) < 0.015
    assert np.median(slides) < 0.002
    assert done.lowered.max() < 0.06


def test_contacts_are_those_of_the_recordings(made: Network, paths: list[int]) -> None:
    """A performance is on the ground as much as what it plays, within a tenth."""
    done = render(made, paths)
    played = made.repertoire.contacts_of(done.provenance.moment)
    assert done.feet.mean() == pytest.approx(played.mean(), rel=0.1)
    assert np.mean(done.feet == played) > 0.93


@pytest.mark.parametrize("hold", [0.0, 0.5])
def test_joints_stay_in_their_range(made: Network, hold: float) -> None:
    """No joint, fingers and toes among them, goes beyond what it does in the recordings, mirrored counted."""
    done = render(made, walking(made, 60, 3, hold))
    stage = Stage.of(made.repertoire)
    own = made.repertoire.rotations[:, :, stage.carrier + 1 :]
    middle = stage.middle[stage.carrier + 1 :]
    ranges, found = (
        quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(middle), q))
        for q in (own.reshape(-1, *own.shape[2:]), done.motion.rotations[:, stage.carrier + 1 :])
    )
    assert np.all(found.max(axis=0) < ranges.max(axis=0) + 1e-6)
    assert np.all(found.min(axis=0) > ranges.min(axis=0) - 1e-6)


def test_limbs_do_not_pass_into_each_other(made: Network, paths: list[int]) -> None:
    """No limb is deeper in another than in the recordings, mirrored counted, and 3 mm."""
    done = render(made, paths)
    capsules = Capsules.of(made.repertoire.motion(0))
    motions = [made.repertoire.motion(0, strand) for strand in (0, 1)]
    deepest = np.max([capsules.depths(m.positions(), m.global_rotations()).max(axis=0) for m in motions], axis=0)
    deep = capsules.depths(done.motion.positions(), done.motion.global_rotations()).max(axis=0)
    assert np.all(deep < np.maximum(deepest, 0.0) + FLESH + 1e-6)


def test_provenance_names_the_source(made: Network, paths: list[int]) -> None:
    """Every frame tells its recording, place, strand and path; between transitions it is that frame."""
    done = render(made, paths, pinned=False)
    came, own = done.provenance, made.repertoire
    assert np.array_equal(came.path, np.repeat(paths, made.length[paths]))
    assert np.array_equal(came.source_frame, own.source_frames[own.frame_of(came.moment)])
    assert np.array_equal(came.mirrored, own.is_mirrored(came.moment))
    assert 0.1 <= came.weight.min() <= 0.7
    assert came.transition[came.weight < 1.0].all()
    away = ~came.transition
    source = own.rotations_of(came.moment[away])
    assert np.allclose(quaternion.angle(done.motion.rotations[away, 1:], source[:, 1:]), 0.0, atol=1e-6)


def test_same_paths_same_movement(made: Network, paths: list[int]) -> None:
    """Nothing is left to chance, and another start only moves and turns the whole."""
    one, two = render(made, paths), render(made, paths)
    assert np.array_equal(one.motion.rotations, two.motion.rotations)
    away = render(made, paths, start=(5.0, 3.0), heading=1.0)
    turn = quaternion.from_axis_angle([0.0, 1.0, 0.0], 1.0)
    assert np.allclose(
        quaternion.rotate(turn, one.motion.root_positions) + np.array([5.0, 0.0, 3.0]),
        away.motion.root_positions,
        atol=1e-3,
    )
    # whether a foot is a hair beyond what is let pass may hang on rounding
    assert np.allclose(quaternion.angle(one.motion.rotations[:, 1:], away.motion.rotations[:, 1:]), 0.0, atol=1e-3)


def test_live_goes_the_same_way(made: Network, paths: list[int]) -> None:
    """Frame by frame the body goes where it goes at once, but for half a metre, no joint leaps or goes beyond its range."""
    done = render(made, paths, start=(1.0, 2.0), heading=0.5)
    frames = list(LiveRenderer(made, paths, start=(1.0, 2.0), heading=0.5))
    assert len(frames) == len(done.motion)
    roots, rotations = np.array([f.root for f in frames]), np.array([f.rotations for f in frames])
    assert np.abs(roots - done.motion.root_positions).max() < 0.5
    assert np.linalg.norm(np.diff(roots, axis=0), axis=1).max() < 0.08
    steps = quaternion.angle(rotations[1:], rotations[:-1])
    usual = quaternion.angle(done.motion.rotations[1:], done.motion.rotations[:-1])
    assert steps.max() < 2.0 * usual.max()
    assert checking.beyond(done.motion.replace(rotations=rotations), Stage.of(made.repertoire)).max() < 1e-6
    motion = done.motion.replace(rotations=rotations, root_positions=roots)
    soles = done.soles.place(motion.positions(), motion.global_rotations())
    assert soles[..., 1].min() > -0.01


def test_live_asks_for_a_path_only_when_it_needs_one(made: Network, paths: list[int]) -> None:
    """The next path is asked for when the one before has been played to its end, or so many seconds before as one likes."""
    asked: list[int] = []

    def choose():
        for p in paths:
            asked.append(p)
            yield p

    live = LiveRenderer(made, choose(), ahead=0.0)
    for _ in range(int(made.length[paths[0]])):
        live.step()
    assert asked == paths[:1]
    live.step()
    assert asked == paths[:2]
    assert live.path == paths[1]
    asked.clear()
    live = LiveRenderer(made, choose(), ahead=0.5)
    for frame in range(int(made.length[paths[:6]].sum())):
        live.step()
        # getting ready takes a frame or two for each path, and paths may be as short as a tenth of a second
        known = 0.3 * made.repertoire.fps if frame >= 0.5 * made.repertoire.fps else 2
        assert made.length[asked].sum() >= min(frame + known, made.length[paths].sum())
        assert made.length[asked[:-1]].sum() <= frame + 0.5 * made.repertoire.fps + 1


def test_bad_input_is_told(made: Network) -> None:
    """No path, no such path, a path that does not follow, bends and starts that are none: refused in words."""
    wrong = next(p for p in range(len(made)) if p not in made.successors(0))
    for asked, words in (([], "list of path"), ([len(made)], "below"), ([0, wrong], "does not follow")):
        with pytest.raises(InputError, match=words):
            render(made, asked)
    with pytest.raises(InputError, match="bend"):
        render(made, [0], bend=[0.1, 0.2])
    with pytest.raises(InputError, match="start"):
        render(made, [0], start=(np.nan, 0.0))
    with pytest.raises(InputError, match="does not follow"):
        list(LiveRenderer(made, [0, wrong]))


def test_envelope_is_nowhere_below(rng: np.random.Generator) -> None:
    """It covers every value and is smooth: no step is larger than the highest value under the top of its window."""
    values = np.where(rng.random(300) < 0.03, rng.random(300), 0.0)
    cover = envelope(values, 12)
    assert np.all(cover >= values - 1e-12)
    assert np.abs(np.diff(cover)).max() <= values.max() / (12 + 1) + 1e-12
    assert not envelope(np.zeros(50), 12).any()


@given(st.integers(0, 10_000), st.integers(1, 80), st.integers(1, 20))
def test_envelopes_compiled_and_plain_agree(seed: int, frames: int, reach: int) -> None:
    """The compiled envelope is that of SciPy's maximum and NumPy's convolution, near the ends too."""
    if compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    rng = np.random.default_rng(seed)
    values = np.where(rng.random(frames) < 0.05, rng.random(frames), 0.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("KINESICS_KERNEL", raising=False)
        patch.setenv("KINESICS_NO_NATIVE", "0")
        quick = envelope(values, reach)
        patch.setenv("KINESICS_NO_NATIVE", "1")
        np.testing.assert_allclose(quick, envelope(values, reach), atol=1e-15)


def test_quality_of_the_recording_itself_is_its_own_yardstick(made: Network) -> None:
    """Measured on paths without a cut and unpinned, nothing is worse than in the recording."""
    chosen = [0]
    while True:
        nexts = made.successors(chosen[-1])
        onward = nexts[made.first[nexts] == made.onward[chosen[-1]]]
        if not len(onward) or len(chosen) > 20:
            break
        chosen.append(int(onward[0]))
    done = render(made, chosen, pinned=False)
    found = quality.measure(done, made.repertoire, threshold=made.threshold)
    assert found.distance.performance < 1e-6
    assert found.joint_excess < 1e-6
    assert found.slide.performance <= found.slide_worst.recordings + 1e-6
    assert found.penetration.performance <= found.penetration.recordings + 1e-6


def test_quality_finds_what_is_wrong(made: Network, paths: list[int]) -> None:
    """A body that is dragged over the floor slides, one that is sunk penetrates, one that trembles accelerates."""
    done = render(made, paths)
    fine = quality.measure(done, made.repertoire)
    roots = done.motion.root_positions.copy()
    roots[:, 1] -= 0.05
    sunk = dataclasses.replace(done, motion=done.motion.replace(root_positions=roots))
    assert quality.measure(sunk, made.repertoire).penetration.performance > 0.04
    trembling = quaternion.multiply(
        done.motion.rotations,
        quaternion.from_rotvec(np.random.default_rng(1).normal(0.0, 0.05, (*done.motion.rotations.shape[:2], 3))),
    )
    shaken = dataclasses.replace(done, motion=done.motion.replace(rotations=trembling))
    assert quality.measure(shaken, made.repertoire).turning_over.performance > 2.0 * fine.turning_over.performance


def test_joints_that_never_moved_are_measured_by_what_nobody_sees() -> None:
    """They tremble less: nothing is counted; they tremble a hundred times more: all of them are."""
    made = network(repertoire(rounds()))
    done, stage = render(made, walking(made, 40, 2)), Stage.of(made.repertoire)
    still = np.flatnonzero(stage.accelerations[:-1] <= 2e-6)
    assert len(still)
    fps, count = done.motion.fps, made.repertoire.skeleton.joint_count
    fine = quality.measure(done, made.repertoire)
    noise = np.random.default_rng(1).uniform(-1.0, 1.0, (len(done.motion), len(still), 3))
    shares = []
    for size in (0.1, 10.0):
        rotations = done.motion.rotations.copy()
        turns = quaternion.from_rotvec(noise * size * LEAST_TURNING / fps**2)
        rotations[:, still] = quaternion.multiply(rotations[:, still], turns)
        shaken = dataclasses.replace(done, motion=done.motion.replace(rotations=rotations))
        shares.append(quality.measure(shaken, made.repertoire).turning_over.performance)
    assert shares[0] == pytest.approx(fine.turning_over.performance)
    assert shares[1] - shares[0] == pytest.approx(len(still) / count, rel=0.02)


def test_real_walk(shared_data: Path) -> None:
    """A real walk of 23 s: feet slide less than a centimetre, stay above the floor, and every pose is a pose of the walk."""
    walk = kx.read(shared_data / "cmu" / "91" / "91_01.amc").resample(60.0)
    made = network(repertoire(walk))
    done = render(made, walking(made, 80, 5))
    found = quality.measure(done, made.repertoire, threshold=made.threshold)
    assert found.slide.performance < 0.012
    assert found.penetration.performance < 0.01
    assert found.distance.performance < found.distance.recordings
    assert found.contact_share.performance == pytest.approx(found.contact_share.recordings, rel=0.15)
    assert found.turning.performance < 1.2
    assert contacts.contacts(done.motion, known=done.soles, ground=Floor(0.0)).feet.any(axis=1).mean() > 0.97


def test_no_frame_is_farther_from_the_recordings_than_transitions_may_be(made: Network) -> None:
    """Also where cuts follow each other as quickly as they can: by every frame's D to the nearest of the recordings."""
    rng = np.random.default_rng(4)
    chosen = [0]
    while len(chosen) < 60:
        nexts = made.successors(chosen[-1])
        leaps = nexts[made.first[nexts] != made.onward[chosen[-1]]]
        chosen.append(int(rng.choice(leaps if len(leaps) else nexts)))
    done = render(made, chosen)
    assert len(done.cuts) > 20
    assert checking.nearest(kx.poses(done.motion), made.repertoire).max() <= made.threshold


def test_who_stands_turns_with_the_feet(made: Network) -> None:
    """Where paths are laid so that a body that stands turns round and round, it does not, and turns back as it goes on."""
    stage, fps = Stage.of(made.repertoire), made.repertoire.fps
    frames = round(12 * fps)
    still = int(np.argmax(made.repertoire.contacts[0].all(axis=1)))
    rotations = np.repeat(made.repertoire.rotations[0, still : still + 1], frames, axis=0)
    roots = np.repeat(made.repertoire.root_positions[0, still : still + 1], frames, axis=0)
    turn = np.minimum(np.arange(frames) / frames, 0.5) * 0.8
    turn_bodies(made.repertoire, stage.carrier, rotations, turn)
    stands = np.repeat((np.arange(frames) < frames // 2)[:, None], 2, axis=1)
    turned, moved, by = planting.with_the_feet(stage, rotations, roots, stands)
    faced = kx.poses(done_motion(made, turned, moved)).yaw
    assert np.abs(faced[: frames // 2 - round(0.5 * fps)] - faced[0]).max() < 0.02
    assert abs(faced[-1] - faced[0] - 0.4) < 0.05
    assert np.allclose(faced - faced[0], turn + by, atol=0.01)
    assert np.array_equal(planting.with_the_feet(stage, rotations, roots, ~stands & False).rotations, rotations)


def done_motion(made: Network, rotations: np.ndarray, roots: np.ndarray) -> kx.Motion:
    return kx.Motion(made.repertoire.skeleton, rotations, roots, made.repertoire.fps)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_joints_that_take_their_own_time_stay_within_their_range(seed: int) -> None:
    """Collar bones that hardly ever move go over for longer than the window of a transition: within their range all the while."""
    kicks = kx.performer.perform("side_kicks", fps=30, noise_degrees=0.5, noise_kind="smooth", seed=seed).motion
    done = kx.performance([kicks], seconds=15, fps=60, seed=1)
    assert done.check.beyond_range < 1e-6
