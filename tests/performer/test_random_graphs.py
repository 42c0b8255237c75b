"""Random graphs keep every promise, and their covering traversals cover."""

from __future__ import annotations

import dataclasses

import networkx
import numpy as np
import pytest

from kinesics.errors import InputError
from kinesics.performer import KeyGraph, KeyPath, covering_steps, random_graph, traverse
from kinesics.performer.postures import pose
from kinesics.performer.traversal import seconds_of
from naive import symmetry as naive

CASES = [(3, 0), (4, 1), (5, 2), (7, 3), (8, 4), (10, 5), (12, 6), (12, 7)]


@pytest.fixture(params=CASES, ids=lambda case: f"{case[0]} states, seed {case[1]}")
def graph(request: pytest.FixtureRequest) -> KeyGraph:
    """A random graph."""
    return random_graph(*request.param)


def test_states_are_apart(graph):
    """Any two states differ by at least .01 in D, and chiral states from every mirror image but their partner's."""
    for i, a in enumerate(graph.states):
        for j, b in enumerate(graph.states):
            if i != j:
                assert naive.distance(a.pose, b.pose) >= 0.01
            image = naive.distance(a.pose, naive.mirrored(b.pose))
            assert image < 1e-12 if a.mirror_of == b.label else image >= 0.01
    assert any(s.symmetric for s in graph.states)
    assert any(not s.symmetric for s in graph.states)


def test_half_of_the_states_are_passed(graph):
    """About half of the states have a velocity: the body goes through them without a stop."""
    passed = sum(s.velocity is not None for s in graph.states)
    assert 0 < passed <= (len(graph.states) + 1) // 2
    assert passed >= len(graph.states) / 2 - 1.5


def test_a_third_of_the_paths_are_parallel(graph):
    """A third or more of the paths share both ends with another path that takes another way."""
    ends = [frozenset((p.from_, p.to)) for p in graph.paths]
    assert np.mean([ends.count(e) > 1 for e in ends]) >= 1 / 3
    u = np.linspace(0.0, 1.0, 21)
    for i, p in enumerate(graph.paths):
        for other, same_ends in zip(graph.paths[:i], ends[:i], strict=True):
            if same_ends == ends[i]:
                ways = [pose(graph.along(x.label, u)) for x in (p, other)]
                far = max(min(naive.distance(a, b) for b in ways[1]) for a in ways[0])
                assert far >= 0.009, (p.label, other.label)


def test_every_state_leads_to_every_other(graph):
    """The graph is strongly connected."""
    net = networkx.DiGraph()
    net.add_nodes_from(s.label for s in graph.states)
    for p in graph.paths:
        net.add_edge(p.from_, p.to)
        if p.reversible:
            net.add_edge(p.to, p.from_)
    assert networkx.is_strongly_connected(net)


def test_coverings_cover(graph):
    """Every path is taken at least twice within 60 to 180 s, each traversal .4 to 3 s, and the truth lists them all."""
    steps = covering_steps(graph, seed=1)
    assert 60.0 <= seconds_of(graph, steps) <= 180.0
    performance = traverse(graph, steps, fps=30.0)
    truth = performance.truth
    for path in truth.paths:
        assert len(path.occurrences) >= 2
        for o in path.occurrences:
            assert 0.4 - 0.04 <= len(o) / 30.0 <= 3.0 + 0.04
            assert path.reversible or not o.reversed
    assert sum(len(p.occurrences) for p in truth.paths) == len(steps)
    for state, known in zip(truth.states, graph.states, strict=True):
        assert (known.velocity is None) or not state.stays


def test_movement_is_smooth():
    """Nowhere does a joint turn more than 12 degrees in a 120th of a second: states are passed, not jumped through."""
    graph = random_graph(8, seed=4)
    motion = traverse(graph, covering_steps(graph, seed=0), fps=120.0).motion
    q = motion.rotations
    turn = 2 * np.arccos(np.clip(np.abs(np.sum(q[1:] * q[:-1], axis=-1)), 0, 1))
    assert np.rad2deg(turn).max() < 12.0


def test_kinds_of_states_and_paths_are_mixed():
    """Over some seeds there are reversible and one-way, symmetric, mirrored and lone paths, and lone chiral states."""
    seen = set()
    for seed in (7, 9):
        graph = random_graph(7, seed=seed)
        for p in graph.paths:
            seen.add("reversible" if p.reversible else "one-way")
            seen.add("lone" if p.mirror_of is None else "symmetric" if p.mirror_of == p.label else "mirrored")
        seen |= {"alone" for s in graph.states if s.mirror_of is None}
    assert seen == {"reversible", "one-way", "lone", "symmetric", "mirrored", "alone"}


def test_seeds_decide():
    """The same seed gives the same graph and traversal, another seed another."""
    one, same, other = random_graph(6, seed=3), random_graph(6, seed=3), random_graph(6, seed=4)
    assert [p.label for p in one.paths] == [p.label for p in same.paths]
    np.testing.assert_array_equal(one.states[0].posture, same.states[0].posture)
    assert np.abs(one.states[0].posture - other.states[0].posture).max() > 0.01
    assert covering_steps(one, seed=3) == covering_steps(same, seed=3) != covering_steps(one, seed=4)


@pytest.mark.parametrize("states", [2, 13, 4.5, True, "six"])
def test_impossible_sizes_are_refused(states):
    """A graph has 3 to 12 states."""
    with pytest.raises(InputError, match="`states` to be a whole number from 3 to 12"):
        random_graph(states)


def test_what_does_not_fit_is_refused():
    """Too many traversals for the time allowed, and graphs with no way back, are errors that say so."""
    graph = random_graph(6, seed=2)
    with pytest.raises(InputError, match="does not fit into `longest` of 61 s"):
        covering_steps(graph, times=10, longest=61.0)
    here, there = (dataclasses.replace(s, mirror_of=None, velocity=None) for s in graph.states[:2])
    oneway = KeyGraph((here, there), (KeyPath("ab_1", here.label, there.label, 1.0),))
    with pytest.raises(InputError, match="not connected"):
        covering_steps(oneway, times=2)
