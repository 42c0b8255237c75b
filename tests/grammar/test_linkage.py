"""Clusters are those that SciPy finds."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from kinesics.grammar.linkage import clusters


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
