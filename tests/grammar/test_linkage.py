"""Clusters are those that SciPy finds."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from kinesics.grammar import linkage as own
from kinesics.grammar.linkage import clusters, clusters_of_many


@pytest.mark.parametrize("method", ["average", "complete"])
@given(
    count=st.integers(2, 60), seed=st.integers(0, 999), levels=st.sampled_from([2, 5, 0]), within=st.floats(0.05, 0.9)
)
def test_the_clusters_are_those_of_scipy(
    method: Literal["average", "complete"], count: int, seed: int, levels: int, within: float
) -> None:
    """The same parts, ties included: distances are often of a few values only."""
    values = np.random.default_rng(seed).random((count, count))
    if levels:
        values = np.round(values * levels) / levels
    apart = np.triu(values, 1) + np.triu(values, 1).T
    theirs = fcluster(linkage(squareform(apart, checks=False), method), within, "distance")
    ours = clusters(apart, within, method)
    assert ((theirs[:, None] == theirs[None]) == (ours[:, None] == ours[None])).all()


def test_clusters_are_counted_in_the_order_of_their_first_members() -> None:
    """Three pairs, told apart by far; one thing alone is a cluster."""
    places = np.array([5.0, 0.0, 9.0, 0.1, 5.1, 9.1])
    apart = np.abs(places[:, None] - places)
    np.testing.assert_array_equal(clusters(apart, 1.0, "complete"), [0, 1, 2, 1, 0, 2])
    np.testing.assert_array_equal(clusters(np.zeros((1, 1)), 1.0, "average"), [0])


@given(
    count=st.integers(2, 80), seed=st.integers(0, 999), within=st.floats(0.02, 0.2), most=st.sampled_from([1, 5, 20])
)
def test_many_are_clustered_like_few(count: int, seed: int, within: float, most: int) -> None:
    """Block by block the same clusters: parts that no chain joins do not change one another, and each is small enough here."""
    places = np.random.default_rng(seed).random((count, 3))

    def apart(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        assert len(rows) * len(columns) <= max(own.CELLS, own.MOST**2, count)
        return np.linalg.norm(places[rows][:, None] - places[columns], axis=-1)

    everything = np.arange(count)
    all_at_once = clusters(apart(everything, everything), within, "average")
    chained = np.unique(
        fcluster(linkage(places, "single"), within, "distance") if count > 1 else [0], return_counts=True
    )[1].max()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(own, "MOST", max(most, int(chained)))
        patch.setattr(own, "CELLS", 100)
        np.testing.assert_array_equal(clusters_of_many(apart, count, within), all_at_once)


def test_of_very_many_the_closest_are_taken_as_one(rng: np.random.Generator) -> None:
    """Four heaps on a line, near enough to be one part, are found though only thirty things may be compared at once."""
    heap = np.repeat(np.arange(4), 100)[rng.permutation(400)]
    places = 1.5 * heap + rng.uniform(-0.3, 0.3, 400)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(own, "MOST", 30)
        patch.setattr(own, "CELLS", 1000)
        found = clusters_of_many(lambda a, b: np.abs(places[a][:, None] - places[b]), 400, 1.0)
    np.testing.assert_array_equal(found[:, None] == found, heap[:, None] == heap)


def test_things_that_stand_for_several_weigh_as_much() -> None:
    """Average linkage of three places, one of them taken ten times, is that of all twelve things."""
    places = np.array([0.0, *[1.0] * 10, 2.05])
    apart = np.abs(places[:, None] - places)
    np.testing.assert_array_equal(clusters(apart, 1.2, "average"), np.zeros(12))
    some = np.ix_([0, 1, 11], [0, 1, 11])
    np.testing.assert_array_equal(clusters(apart[some], 1.2, "average", [1, 10, 1]), [0, 0, 0])
    np.testing.assert_array_equal(clusters(apart[some], 1.2, "average"), [0, 0, 1])
