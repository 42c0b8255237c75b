"""The graph of several recordings read together."""

from __future__ import annotations

import pytest

import kinesics as kx
from kinesics.errors import InputError
from kinesics.grammar import many
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


def test_bad_calls_are_told() -> None:
    """No recording, or names that do not match, are refused."""
    with pytest.raises(InputError, match="at least one"):
        kx.graph([])
    with pytest.raises(InputError, match="as many names"):
        many.read_graph([kx.poses(kx.performer.wave(seconds=2).motion)], ["a", "b"])
