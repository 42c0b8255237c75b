"""The network: every path leads on, and from every path to every other."""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from bodies import about, moving, rounds
from kinesics.analysis.facts import Phrase
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.grammar.graph import MotionGraph, Occurrence, Source, State, Stay
from kinesics.grammar.graph import Path as Edge
from kinesics.synthesis.joining.transitions import transitions
from kinesics.synthesis.paths.labels import labelled
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.repertoire import repertoire
from naive import transitions as naive


@pytest.fixture(scope="module", params=["as recorded", "mirrored", "backwards", "backwards and mirrored"])
def made(request: pytest.FixtureRequest) -> Network:
    """Of a march, in the strands named."""
    backwards = "backwards" in request.param
    # whoever walks ahead cannot go over into walking back; on the spot one can
    motion = rounds(lead=2.0, speed=0.0 if backwards else 1.2)
    return network(repertoire(motion, mirrored="mirrored" in request.param, backwards=backwards))


@pytest.fixture(scope="module")
def both() -> Network:
    """Of a march and its mirror image."""
    return network(repertoire(rounds()))


def test_every_path_leads_to_every_path(made: Network) -> None:
    """Every path has a successor, and all can be reached from each."""
    successors = [made.successors(k).tolist() for k in range(len(made))]
    everything = set(range(len(made)))
    assert all(successors)
    for path in (0, len(made) // 2, len(made) - 1):
        assert naive.reachable(successors, path) == everything
    predecessors: list[list[int]] = [[] for _ in successors]
    for path, after in enumerate(successors):
        for follower in after:
            predecessors[follower].append(path)
    assert naive.reachable(predecessors, 0) == everything


def test_paths_play_every_frame_once(made: Network) -> None:
    """No moment lies in two paths, none crosses the border of a recording, and none is too short."""
    rep = made.repertoire
    played = [
        m
        for first, length in zip(made.first.tolist(), made.length.tolist(), strict=True)
        for m in naive.frames_played(first, length, rep.frame_count)
    ]
    assert len(set(played)) == len(played)
    assert (rep.strand_of(made.last) == made.strand).all()
    assert made.duration.min() >= 0.1 - 1e-9
    np.testing.assert_allclose(made.duration, made.length / rep.fps)


def test_successors_are_what_is_recorded_or_transitions(made: Network) -> None:
    """After a path comes the one that was recorded, for free, or the one that a transition leads to, at its cost."""
    found = transitions(made.repertoire)
    known = {
        (s, t): (c, d)
        for s, t, c, d in zip(
            found.source.tolist(), found.target.tolist(), found.cost.tolist(), found.distance.tolist(), strict=True
        )
    }
    jumps = 0
    for path in range(len(made)):
        for at in range(int(made.indptr[path]), int(made.indptr[path + 1])):
            follower = int(made.indices[at])
            if made.first[follower] == made.onward[path]:
                assert made.cost[at] == made.distance[at] == 0.0
            else:
                assert (made.cost[at], made.distance[at]) == known[int(made.last[path]), int(made.first[follower])]
                jumps += 1
        assert (np.diff(made.cost[made.indptr[path] : made.indptr[path + 1]]) >= 0.0).all()
    assert jumps > 10
    assert made.distance.max() <= made.threshold


def test_only_what_was_recorded_is_free() -> None:
    """Going over into a copy of the same recording costs next to nothing, but something: to go on as recorded is told by cost 0."""
    made = network(repertoire([rounds(8.0), rounds(8.0)], mirrored=False))
    goes_on = np.repeat(made.onward, np.diff(made.indptr)) == made.first[made.indices]
    np.testing.assert_array_equal(made.cost == 0.0, goes_on)
    assert made.cost[~goes_on].min() < 1e-6


def test_displacement_and_turn_by_their_definition(made: Network) -> None:
    """From a path's first moment to that with which the recording goes on, as seen from the heading at the first."""
    rep = made.repertoire
    for path in range(len(made)):
        first, onward = int(made.first[path]), int(made.onward[path])
        (x0, _, z0), (x1, _, z1) = rep.roots_of(np.array([first, onward])).tolist()
        yaw = float(rep.yaw_of(first))
        np.testing.assert_allclose(made.displacement[path], naive.seen_from(yaw, x1 - x0, z1 - z0), atol=1e-12)
        turned = float(rep.yaw_of(onward)) - yaw
        assert np.cos(made.turn[path] - turned) == pytest.approx(1.0, abs=1e-12)
    as_recorded = made.strand == 0
    assert (made.displacement[as_recorded, 1] > 0.0).all() or made.repertoire.backwards
    assert made.turn[as_recorded].sum() > 0.3


def test_all_strands_asked_for_are_used(made: Network) -> None:
    """Mirror images and the way back belong to the network where they may and can be."""
    assert set(made.strand.tolist()) == set(made.repertoire.strands)


def test_the_mirrored_network_is_the_same_network(both: Network) -> None:
    """Every path has its mirror image: as long, as far, turning the other way, and followed by mirror images at equal cost."""
    image = both.mirror_of
    assert (image >= 0).all()
    np.testing.assert_array_equal(image[image], np.arange(len(both)))
    np.testing.assert_array_equal(both.length[image], both.length)
    np.testing.assert_allclose(both.displacement[image], both.displacement * [-1.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(both.turn[image], -both.turn, atol=1e-12)
    ways = {
        (p, int(both.indices[k])): both.cost[k]
        for p in range(len(both))
        for k in range(both.indptr[p], both.indptr[p + 1])
    }
    assert {(int(image[p]), int(image[q])): cost for (p, q), cost in ways.items()} == ways


def test_what_is_pruned_is_said(made: Network) -> None:
    """Seconds kept and seconds pruned are all there are, and which are left out for what: the lead-in, to which nothing leads."""
    rep = made.repertoire
    recorded = [p for p in made.pruned if "as recorded" in p.strand]
    assert sum(made.duration[made.strand == 0]) + sum(p.seconds for p in recorded) == pytest.approx(16.0)
    first = recorded[0].stretches[0]
    assert first.start == 0.0
    assert "leads there" in first.why or rep.backwards
    assert str(recorded[0]).startswith("rounds, as recorded")
    for lost in made.pruned:
        shown = [why for why in {part.why for part in lost.stretches} if why in lost.why]
        assert shown
        assert all(lost.why.count(f"{why}: ") == 1 for why in shown)
    for lost in made.pruned:
        assert sum(part.end - part.start for part in lost.stretches) == pytest.approx(lost.seconds)
        assert all(before.end <= after.start for before, after in itertools.pairwise(lost.stretches))


def test_dead_ends_are_told_from_what_nothing_leads_to() -> None:
    """A march whose beginning and end are like nothing else: the one cannot be come back to, from the other nothing leads back."""
    march = rounds(12.0, lead=2.0)
    t = np.arange(march.frame_count) / 30.0
    bow = quaternion.from_rotvec(about(0, np.clip(t - 10.0, 0.0, None)))
    rotations = march.rotations.copy()
    for joint in (march.skeleton.joint_index[name] for name in ("Chest", "Neck", "LeftForeArm", "RightForeArm")):
        rotations[:, joint] = quaternion.multiply(rotations[:, joint], bow)
    (lost,) = network(repertoire(march.replace(rotations=rotations), mirrored=False)).pruned
    head, tail = lost.stretches[0], lost.stretches[-1]
    assert head.why == "no transition leads there"
    assert tail.why == "no transition leads back from there"
    assert tail.end == 12.0
    assert tail.start == pytest.approx(10.5, abs=1.0)


def test_unconnected_recordings_are_named() -> None:
    """A recording that nothing leads to and back from is left out, with a warning that names it."""
    t = np.arange(300) / 30.0
    circling = moving(
        {"LeftArm": about(2, 1.2 + 0.4 * np.sin(5.0 * t)), "Spine": about(0, 0.9 + 0.3 * np.cos(3.0 * t))}, fps=30
    )
    with pytest.warns(UserWarning, match="Nothing is performed of bowing"):
        made = network(repertoire([rounds(), circling.replace(name="bowing")], mirrored=False))
    left = [p for p in made.pruned if p.everything]
    assert [(p.recording, p.seconds) for p in left] == [("bowing", 10.0)]
    assert set(made.recording.tolist()) == {0}


def test_a_recording_that_strands_lose_for_different_reasons_is_named() -> None:
    """Joined at one place alone, one half of it leads nowhere and to the other nothing leads; played backwards, each the other."""
    march = rounds(speed=0.0)
    rep = repertoire([march.replace(name="one"), march.replace(name="two")], mirrored=False, backwards=True)
    found = transitions(rep)
    here, there = rep.frame_of(found.source), rep.frame_of(found.target)
    first, second = rep.recording_of(here), rep.recording_of(there)
    across = (first != second) & (rep.strand_of(found.source) == rep.strand_of(found.target))
    seam = np.where(first == 1, here + ~rep.is_backward(found.source), there + rep.is_backward(found.target))
    places = np.unique(seam[across])
    kept = ((first == 0) & (second == 0)) | (across & (seam == places[len(places) // 2]))
    few = dataclasses.replace(
        found,
        source=found.source[kept],
        target=found.target[kept],
        distance=found.distance[kept],
        cost=found.cost[kept],
    )
    with pytest.warns(UserWarning, match="Nothing is performed of two:"):
        made = network(rep, transitions=few)
    assert set(made.recording.tolist()) == {0}
    lost = [p for p in made.pruned if p.recording == "two"]
    assert len({p.why for p in lost}) == 2
    assert all(p.everything for p in lost)
    assert not any(p.everything for p in made.pruned if p.recording == "one")
    assert repr(made).endswith("1 recordings pruned)")


def test_mirror_images_that_cannot_be_reached_are_left_out() -> None:
    """Of a movement with one arm only one of the two mirror images is kept, the one as recorded, and that is said."""
    t = np.arange(450) / 30.0
    wave = moving(
        {"LeftArm": about(2, 1.2 + 0.3 * np.sin(5.0 * t)), "LeftForeArm": about(1, 0.4 * np.sin(5.3 * t))}, fps=30
    )
    made = network(repertoire(wave.replace(name="wave")))
    assert set(made.strand.tolist()) == {0}
    assert (made.mirror_of == -1).all()
    assert [p.seconds for p in made.pruned if p.strand == "mirrored"] == [15.0]


def test_no_transition_is_an_error_that_helps() -> None:
    """The nearest pair, its distance, the threshold and a way out are named."""
    t = np.arange(90) / 30.0
    rising = moving({"LeftArm": about(2, 0.6 * t), "Spine": about(0, 0.3 * t)}, fps=30).replace(name="rising")
    with pytest.raises(
        InputError, match=r"no transitions in rising.*rising at .* s and rising at .* s.*mean D of .*`threshold`"
    ):
        network(repertoire(rising, mirrored=False), threshold=1e-9)


def test_near_poses_that_differ_otherwise_are_told() -> None:
    """If a pose recurs, but in another direction of movement, the message says what differs."""
    phase = np.linspace(-0.3, np.pi + 0.3, 40)
    eight = {"LeftArm": about(2, np.sin(phase)), "LeftForeArm": about(2, 0.5 * np.sin(2.0 * phase))}
    with pytest.raises(InputError, match="differ in velocity of the pose"):
        network(repertoire(moving(eight, fps=30), mirrored=False))


def test_too_short_is_an_error_that_helps() -> None:
    """A recording shorter than two windows is said to be too short."""
    with pytest.raises(InputError, match="too short to leave"):
        network(repertoire(rounds(0.5, fps=8.0), mirrored=False))


def test_a_way_that_never_leads_back_is_an_error() -> None:
    """Transitions that only lead ahead make no network."""
    rep = repertoire(rounds(), mirrored=False)
    found = transitions(rep)
    ahead = found.target > found.source
    only = dataclasses.replace(
        found,
        source=found.source[ahead],
        target=found.target[ahead],
        distance=found.distance[ahead],
        cost=found.cost[ahead],
    )
    with pytest.raises(InputError, match="none leads back"):
        network(rep, transitions=only)


def test_transitions_of_another_repertoire_are_refused() -> None:
    """Moments mean nothing in another repertoire."""
    one, other = repertoire(rounds()), repertoire(rounds())
    with pytest.raises(InputError, match="another repertoire"):
        network(one, transitions=transitions(other))


def _graph(frames: int) -> MotionGraph:
    """Half of the recording in state A, then on to the symmetric X and back, twice."""
    half, quarter = frames // 2, frames // 4
    return MotionGraph(
        states=(State(0, "A", stays=(Stay(0, 0, half),)), State(1, "X~", symmetric=True)),
        paths=(
            Edge(0, "ax_1", from_=0, to=1, index=1, occurrences=(Occurrence(0, half, half + quarter),)),
            Edge(1, "xa_1", from_=1, to=0, index=1, occurrences=(Occurrence(0, half + quarter, frames),)),
        ),
        sources=(Source("rounds", frames, 30.0),),
    )


def test_paths_carry_the_grammar_s_words(both: Network) -> None:
    """A path is labelled by what it shares most time with; its mirror image carries the conjugate label."""
    frames = both.repertoire.frame_count
    phrases = [Phrase(0, 0, frames, 0.0, frames / 30.0, class_="cyclic-antiphase")]
    named = labelled(both, _graph(frames), phrases)
    first = int(np.flatnonzero(both.strand == 0)[0])
    last = int(np.flatnonzero(both.strand == 0)[-1])
    assert (named.state_from[first], named.label[first], named.state_to[first]) == ("A", "aa_0", "A")
    assert (named.state_from[last], named.label[last], named.state_to[last]) == ("X~", "xa_1", "A")
    image = int(both.mirror_of[last])
    assert (named.state_from[image], named.label[image], named.state_to[image]) == ("X~", "(xa_1)*", "A*")
    assert named.label[int(both.mirror_of[first])] == "(aa_0)*"
    assert set(named.class_) == {"cyclic-antiphase"}
    assert both.label == ()


def test_the_way_back_is_written_backwards() -> None:
    """Paths of backward strands carry the label of the way back."""
    made = network(repertoire(rounds(speed=0.0), mirrored=False, backwards=True))
    named = labelled(made, _graph(made.repertoire.frame_count))
    back = int(np.flatnonzero(made.strand == 2)[-1])
    assert (named.state_from[back], named.label[back], named.state_to[back]) == ("A", "<xa_1", "X~")


def test_a_graph_of_other_recordings_is_refused(both: Network) -> None:
    """The graph must be of the same recordings."""
    with pytest.raises(InputError, match="same recordings"):
        labelled(both, MotionGraph())
    with pytest.raises(InputError, match="more frames"):
        labelled(both, _graph(100))


def test_a_larger_threshold_does_not_leave_less(shared_data: Path) -> None:
    """More may go over into more: of real exercises hardly a moment is lost that a smaller threshold would have joined."""
    exercises = repertoire(kx.read(shared_data / "cmu" / "14" / "14_06.amc").resample(30.0))
    seconds = [network(exercises, threshold=most).seconds for most in (None, 0.03, 0.08)]
    assert min(seconds[1:]) > 0.98 * seconds[0]


def test_real_walks_make_one_network(shared_data: Path) -> None:
    """Walks of four people, mirrored too, are joined and nearly wholly kept."""
    clips = [kx.read(shared_data / "cmu" / name[:2] / f"{name}.amc") for name in ("91_01", "91_34", "07_01", "35_01")]
    made = network(repertoire(clips, fps=30.0))
    total = made.repertoire.frame_count / made.repertoire.fps
    assert set(made.recording.tolist()) == {0, 1, 2, 3}
    assert (made.mirror_of >= 0).all()
    assert made.seconds > 0.85 * 2.0 * total
    assert np.median(np.diff(made.indptr)) >= 3
