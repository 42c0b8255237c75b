"""Marks that become states: very many of them are put together in two steps, a few in one, with the same result."""

import numpy as np
import pytest

from kinesics.grammar.ground import Mark
from kinesics.grammar.moments import Moments, from_distances
from kinesics.grammar.reading import states


def _crowded(rng: np.random.Generator, places: int, each: int) -> tuple[Moments, np.ndarray]:
    """Moments crowded about a few places far apart, in any order; and the place of each."""
    centres = np.stack([np.cos(a) * np.array([1.0, 0.0]) + np.sin(a) * np.array([0.0, 1.0]) for a in np.arange(places)])
    place = rng.permutation(np.repeat(np.arange(places), each))
    points = centres[place] + rng.uniform(-0.01, 0.01, size=(len(place), 2))
    d, s = (0.5 * np.square(points[:, None] - side * points[None]).sum(axis=-1) for side in (1.0, -1.0))
    return from_distances(d, s, 30.0), place


@pytest.mark.parametrize("most", [10, 60, 10_000])
def test_marks_are_put_together_by_place(rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch, most: int) -> None:
    """Whether all are compared with all or the closest taken as one first, each cluster is one place and each place one."""
    monkeypatch.setattr(states, "_MOST_MARKS", most)
    moments, place = _crowded(rng, 6, 40)
    marks = [Mark(int(t), False) for t in rng.permutation(len(place))] + [Mark(3, True)]
    groups = states.cluster(moments, marks, 0.005)
    assert sum(len(g) for g in groups) == len(marks)
    assert len(groups) == 6
    for group in groups:
        assert len({place[m.moment] for m in group}) == 1


def test_no_two_of_a_cluster_are_further_apart_than_a_state(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Along a line without gaps clusters have the diameter asked for; in two steps half as much again at most."""
    at = np.sort(rng.uniform(0.0, 1.0, 300))
    d = 0.5 * np.square(at[:, None] - at[None])
    moments = from_distances(d, np.ones_like(d), 30.0)
    marks = [Mark(t, False) for t in range(300)]
    limit = 0.1
    for most, slack in ((10_000, 1.0), (50, 1.5)):
        monkeypatch.setattr(states, "_MOST_MARKS", most)
        groups = states.cluster(moments, marks, limit**2 / 2)
        assert max(np.ptp(at[[m.moment for m in g]]) for g in groups) <= limit * slack + 1e-6
        assert 1.0 / (slack * limit) - 1 <= len(groups) <= 30
