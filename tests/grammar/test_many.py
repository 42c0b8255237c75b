"""The graph of several recordings read together."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from kinesics.errors import InputError
from kinesics.grammar import classes, edits, many, whole
from kinesics.performer.random_graphs import covering_steps, random_graph
from performed_graphs import performed


def test_two_halves_give_the_graph_of_the_whole() -> None:
    """A traversal cut where it is held in a state, given as two recordings, reads as one graph of two sources."""
    graph = random_graph(states=4, seed=1)
    done = kx.performer.traverse(graph, covering_steps(graph, seed=1), fps=30, seed=1)
    poses = kx.poses(done.motion)
    held = [(r.start + r.end) // 2 for s in done.truth.states for r in s.stays if r.end - r.start > 8]
    cut = min(held, key=lambda f: abs(f - len(poses) // 2))
    read = many.read_graph([poses[:cut], poses[cut:]], ["first", "second"])
    assert [s.name for s in read.sources] == ["first", "second"]
    for source, frames in enumerate((cut, len(poses) - cut)):
        steps = read.timeline(source)
        assert steps[0].start == 0
        assert steps[-1].end == frames
    truth = performed(done.truth).contracted()
    found = read.contracted()
    assert (len(found.states), len(found.paths)) == (len(truth.states), len(truth.paths))


def test_different_movements_share_nothing_but_standing() -> None:
    """Jumping jacks and waving, each from its own recording, are two parts of one graph."""
    jacks = kx.performer.jumping_jacks(seconds=6, fps=60).motion
    wave = kx.performer.wave(seconds=6, fps=30).motion
    graph = kx.graph([jacks, wave])
    assert len(graph.sources) == 2
    assert len(graph.components()) == 2
    assert {p.symmetric for p in graph.paths} == {True, False}


def test_the_same_movement_twice_is_one_path() -> None:
    """Two recordings of one exercise share their states and their path."""
    a = kx.performer.squat(seconds=8, fps=60, seed=1, noise_degrees=0.3).motion
    b = kx.performer.squat(seconds=8, fps=120, seed=2, noise_degrees=0.3, tempo_jitter=0.05).motion
    graph = kx.graph([a, b])
    assert len(graph.paths) == 1
    assert {o.source for o in graph.paths[0].occurrences} == {0, 1}


@pytest.mark.parametrize("frames", [1, 45, 60])
def test_every_recording_is_in_some_state(frames: int) -> None:
    """A part of a run in which nothing stops, turns or parts has a state at its slowest moment beside other recordings, too."""
    run = kx.performer.run(seconds=5, fps=60, seed=3, noise_degrees=0.3).motion[101 : 101 + frames]
    squat = kx.performer.squat(seconds=6, fps=60, seed=1, noise_degrees=0.3).motion
    for motions in ([run, squat], [squat, run], [run, squat, run]):
        graph = kx.graph(motions)
        for source, motion in enumerate(motions):
            steps = graph.timeline(source)
            assert (steps[0].start, steps[-1].end) == (0, motion.frame_count)
            assert graph.rebuild(graph.notation(source), source) == steps


def test_one_recording_is_read_as_it_is_alone() -> None:
    """The graph of one recording does not depend on whether it was asked for by itself or with all the rest."""
    motion = kx.performer.side_kicks(seconds=12, fps=60, seed=1, noise_degrees=0.3).motion
    assert kx.graph([motion]).paths == kx.graph(motion).paths == kx.analyze(motion).graph.paths


@pytest.mark.parametrize("seed", [0, 1])
def test_a_walk_and_a_run_are_no_palindromes_together(seed: int) -> None:
    """What the class of each excludes the two together do not have: no step is its own mirror image backwards."""
    walk = kx.performer.walk(seconds=6, fps=60, seed=seed, noise_degrees=1.0).motion
    run = kx.performer.run(seconds=5, fps=120, seed=seed, noise_degrees=1.0).motion
    other = kx.performer.throw(seed=seed, fps=60, noise_degrees=1.0).motion
    for graph in (kx.graph([walk, run]), kx.graph([walk, run, other])):
        assert not [p.label for p in graph.paths if p.antipalindromic]
        assert sum(p.mirror_of is not None and not p.reversible for p in graph.paths) >= 4


def test_recordings_are_classed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The graph of several recordings takes their classes from what was read of each; without, it is the same graph."""
    motions = [
        kx.performer.squat(seconds=6, fps=60, seed=1, noise_degrees=0.3).motion,
        kx.performer.walk(seconds=5, fps=30, seed=2, noise_degrees=0.3).motion,
    ]
    judged: list[tuple[int, int | None]] = []
    classify = classes.classify

    def counted(*args: object) -> classes.Verdict:
        judged.append((id(args[0]), len(judged)))
        return classify(*args)

    monkeypatch.setattr(classes, "classify", counted)
    analysis = kx.analyze(motions)
    once = len(judged)
    assert once == len(motions) + sum(len(g.phrases) > 1 for g in analysis.grammars)
    assert kx.graph(motions).paths == analysis.graph.paths
    assert len(judged) > once


def test_edits_are_honoured_on_several_recordings() -> None:
    """States and paths are named, merged and split where a frame of any of the recordings says."""
    a = kx.performer.squat(seconds=8, fps=60, seed=1, noise_degrees=0.3).motion
    b = kx.performer.squat(seconds=8, fps=120, seed=2, noise_degrees=0.3).motion
    plain = kx.graph([a, b])
    low, high = sorted(plain.states, key=lambda s: s.label)
    path = plain.paths[0].label
    late = max(o.start for o in plain.paths[0].occurrences if o.source == 1)
    text = f"""
        states.rename = {{ "{low.label}" = "top" }}
        states.split = [ {{ state = "{high.label}", into = "deep", frames = [500], source = 1 }} ]
        paths.split = [ {{ path = "{path}", into = "last", frames = [{late + 1}], source = 1 }} ]
        phrases.rename = [ {{ frame = 100, name = "second", source = 1 }} ]
    """
    edited = kx.analyze([a, b], edits=edits.parse(text))
    assert {s.label for s in edited.graph.states} == {"top~", high.label, "deep~"}
    last = edited.graph.path("last~")
    assert [(o.source, o.start) for o in last.occurrences] == [(1, late)]
    assert [p.name for p in edited.phrases] == [None, "second"]
    for source, motion in enumerate((a, b)):
        steps = edited.graph.timeline(source)
        assert (steps[0].start, steps[-1].end) == (0, motion.frame_count)
    assert edited.graph == kx.graph([a, b], edits=edits.parse(text))


def test_edits_survive_another_analysis() -> None:
    """Said by frames and names of recordings, they hold in another order, with other weights and beside another recording."""
    squat = dataclasses.replace(kx.performer.squat(seconds=8, fps=60, seed=1, noise_degrees=0.3).motion, name="squat")
    kicks = dataclasses.replace(kx.performer.side_kicks(fps=30, seed=2, noise_degrees=0.3).motion, name="kicks")
    walk = dataclasses.replace(kx.performer.walk(seconds=5, fps=60, seed=3, noise_degrees=0.3).motion, name="walk")
    plain = kx.graph([squat, kicks])
    path = next(p for p in plain.paths if len([o for o in p.occurrences if o.source == 1]) > 1)
    first, *_, last = (o for o in path.occurrences if o.source == 1)
    bottom = next(p for p in plain.paths if p.occurrences[0].source == 0).occurrences[0].end
    told = edits.parse(f"""
        states.rename = {{ "squat@{bottom}" = "low" }}
        paths.rename = {{ "kicks@{first.start}" = "way" }}
        paths.split = [ {{ path = "kicks@{first.start}", into = "again", frames = [{last.start}], source = "kicks" }} ]
        phrases.rename = [ {{ frame = 10, name = "knees", source = "squat" }} ]
    """)
    uneven = np.ones(15)
    uneven[[7, 8, 11, 12]] = 1.5
    for motions, weights in (
        ([squat, kicks], None),
        ([kicks, squat], None),
        ([walk, squat, kicks], None),
        ([squat, kicks], uneven),
    ):
        found = kx.analyze(motions, edits=told, weights=weights)
        number = {s.name: k for k, s in enumerate(found.sources)}
        low = found.graph.state("low~")
        ends = [p for p in found.graph.paths if low.id in (p.from_, p.to)]
        assert {o.source for p in ends for o in p.occurrences} == {number["squat"]}
        named = {p.label.strip("()*~") for p in found.graph.paths}
        assert {"way", "again"} <= named
        assert [p.source for p in found.phrases if p.name == "knees"] == [number["squat"]]
        for k in range(len(motions)):
            assert found.graph.rebuild(found.graph.notation(k), k) == found.graph.timeline(k)


def test_recordings_that_are_not_there_are_told() -> None:
    """By number or by name, in states, paths and phrases; and a name that two recordings have."""
    squat = dataclasses.replace(kx.performer.squat(seconds=6, fps=30, seed=1).motion, name="squat")
    for text, message in (
        ('phrases.rename = [ { frame = 1, name = "x", source = 3 } ]', "No source 3"),
        (
            'phrases.split = [ { frame = 1, source = "walk" } ]',
            "a recording 'walk'; no recording is. Recordings: 'squat', 'squat'",
        ),
        ('states.rename = { "squat@3" = "x" }', "several recordings are: give its number"),
        ('states.rename = { "@99999" = "x" }', "frame 99999 of source 0, which has"),
        ('paths.rename = { "qq_1" = "x" }', 'a frame in their place, such as "@812", does not'),
    ):
        with pytest.raises(InputError, match=message):
            kx.analyze([squat, squat], edits=edits.parse(text))


def _kinds(*motions: kx.Motion) -> list[list[tuple[int, bool]]]:
    """Of each recording the kinds of its phrases, and which are mirrored."""
    grammars = many.match_kinds([whole.read_grammar(kx.poses(m), with_graph=False) for m in motions])
    return [[(p.kind, p.mirrored) for p in g.phrases] for g in grammars]


def _exercises(*names: str, seed: int = 1) -> kx.Motion:
    """One exercise after the other, ten seconds each, in one recording."""
    parts = [kx.performer.perform(n, seed=seed, seconds=10.0, fps=30, noise_degrees=0.3).motion for n in names]
    return dataclasses.replace(
        parts[0],
        rotations=np.concatenate([p.rotations for p in parts]),
        root_positions=np.concatenate([p.root_positions for p in parts]),
    )


def test_kinds_are_the_same_in_a_copy_and_in_a_mirror() -> None:
    """The same clip twice has the same kinds; in its mirror image those are mirrored that are not their own mirror image."""
    motion = _exercises("wave", "squat", "walk")
    alone = [p.kind for p in whole.read_grammar(kx.poses(motion)).phrases]
    assert alone == [0, 1, 2]
    assert _kinds(motion, motion) == [[(k, False) for k in alone]] * 2
    assert _kinds(motion, kx.mirror(motion)) == [[(k, False) for k in alone], [(0, True), (1, False), (2, False)]]
    assert _kinds(kx.mirror(motion), motion) == _kinds(motion, kx.mirror(motion))


def test_within_one_recording_the_other_hand_is_told() -> None:
    """Waving with the one hand, walking, waving with the other: two kinds, the last phrase mirrored, from either end."""
    left = _exercises("wave")
    walk = _exercises("walk")
    motion = dataclasses.replace(
        left,
        rotations=np.concatenate([m.rotations for m in (left, walk, kx.mirror(left))]),
        root_positions=np.concatenate([m.root_positions for m in (left, walk, left)]),
    )
    assert _kinds(motion) == [[(0, False), (1, False), (0, True)]]
    assert _kinds(kx.reverse(motion)) == [[(0, False), (1, False), (0, True)]]


def test_kinds_are_counted_through_all_recordings_in_the_order_given() -> None:
    """What was seen before keeps its number, what is new gets the next one, whatever the frame rate."""
    first = _exercises("wave", "squat", seed=1)
    second = _exercises("walk", "squat", "wave", seed=2)
    assert _kinds(first, second) == [[(0, False), (1, False)], [(2, False), (1, False), (0, False)]]
    assert _kinds(second, first.resample(24.0)) == [[(0, False), (1, False), (2, False)], [(2, False), (1, False)]]


def test_two_walks_are_of_one_kind_and_a_kata_is_of_another(shared_data: Path) -> None:
    """Walks of three people are one kind, whatever their styles; side kicks are another."""
    walks = [kx.read(shared_data / f"cmu/{name}.amc") for name in ("07/07_01", "02/02_01", "16/16_21")]
    kicks = kx.read(shared_data / "cmu/135/135_11.amc")
    assert _kinds(*walks, kicks) == [[(0, False)], [(0, False)], [(0, False)], [(1, False)]]


def test_exercises_are_known_again(shared_data: Path) -> None:
    """Jumping jacks are one kind in all three recordings, knee raises and squats in two, and nothing else is (`segments.tsv`)."""
    one, two, three = (
        [kind for kind, _ in part]
        for part in _kinds(*(kx.read(shared_data / f"cmu/{name}.amc") for name in ("13/13_29", "13/13_30", "14/14_06")))
    )
    assert one[0] == two[0] == three[0]
    assert set(one) & set(two) == {one[0], one[4], one[5]}
    assert set(three) & {*one, *two} == {one[0]}


def test_names_of_a_person_stay_with_their_phrases() -> None:
    """Phrases that a person has split keep the kind they had, as it is counted through all recordings."""
    first, second = _exercises("squat"), _exercises("wave", "squat", seed=2)
    told = edits.parse("phrases.split = [ { frame = 450, source = 1 } ]")
    found = kx.analyze([first, second], edits=told).phrases
    assert [(p.source, p.kind) for p in found] == [(0, 0), (1, 1), (1, 0), (1, 0)]
    assert found[-1].start == 450


def test_a_recording_of_a_few_frames_has_no_kinds() -> None:
    """It is passed over; the others are matched."""
    squat = _exercises("squat")
    assert _kinds(squat, squat[:3], squat) == [[(0, False)], [], [(0, False)]]


def test_bad_calls_are_told() -> None:
    """No recording, or names that do not match, are refused."""
    with pytest.raises(InputError, match="at least one"):
        kx.graph([])
    with pytest.raises(InputError, match="as many names"):
        many.read_graph([kx.poses(kx.performer.wave(seconds=2).motion)], ["a", "b"])
