"""A recording played backwards reads as the same thing turned round."""

from __future__ import annotations

import pytest

import kinesics as kx
from kinesics.grammar import direction, moments
from kinesics.grammar.whole import read_grammar


@pytest.mark.parametrize("name", ["walk", "squat", "throw", "side_kicks"])
def test_backwards_is_turned_round(name: str) -> None:
    """Class and period are the same, cycles and phrases lie at the same moments, the graph has its one-way arrows turned."""
    poses = kx.poses(kx.performer.perform(name, fps=30.0, noise_degrees=0.5, seed=3, tempo_jitter=0.05).motion)
    a, b = read_grammar(poses), read_grammar(poses[::-1])
    assert a.overall is not None
    assert b.overall is not None
    assert (a.overall.class_, a.overall.period_s) == (b.overall.class_, b.overall.period_s)
    n = len(poses)
    assert [(p.start, p.end) for p in a.phrases] == [(n - p.end, n - p.start) for p in reversed(b.phrases)]
    last = n - 1
    assert [(c.start, c.end) for c in a.overall.cycles] == [
        (last - c.end, last - c.start) for c in reversed(b.overall.cycles)
    ]
    assert a.graph is not None
    assert b.graph is not None
    assert b.graph.isomorphic_to(a.graph.reversed_in_time())


def test_one_of_the_two_directions_is_read_from_the_end() -> None:
    """Of a recording and the same played backwards one is read from its end; turned twice, moments are as they were."""
    m = moments.from_poses(kx.poses(kx.performer.perform("throw", fps=60.0).motion))
    back = direction.reversed_moments(m)
    assert m.from_end != back.from_end
    again = direction.reversed_moments(back)
    assert (again.speed == m.speed).all()
    assert (again.symmetry == m.symmetry).all()
