"""The graph of several recordings read together."""

from __future__ import annotations

import pytest

import kinesics as kx
from kinesics.errors import InputError
from kinesics.grammar import classes, edits, many
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
        return classify(*args)  # type: ignore[arg-type]

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


def test_bad_calls_are_told() -> None:
    """No recording, or names that do not match, are refused."""
    with pytest.raises(InputError, match="at least one"):
        kx.graph([])
    with pytest.raises(InputError, match="as many names"):
        many.read_graph([kx.poses(kx.performer.wave(seconds=2).motion)], ["a", "b"])
