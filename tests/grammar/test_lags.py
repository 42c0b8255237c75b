"""Paths of recurrence: compiled, NumPy and naive agree; tempo may change; turnings lie where the movement turns."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from kinesics.grammar import lags
from naive import grammar as naive

WAYS = ["0", "1"]

costs = st.floats(0.0, 1.0, width=32)


def _by_lag(position: np.ndarray, most: int | None = None) -> np.ndarray:
    d = np.abs(position[:, None] - position[None, :]).astype(np.float32)
    return lags.diagonals(d, len(d) - 1 if most is None else most)


@pytest.mark.parametrize("no_native", WAYS)
@given(
    rows=hnp.arrays(np.float32, st.tuples(st.integers(1, 4), st.integers(3, 6)), elements=costs), bend=st.floats(0, 0.5)
)
def test_the_cheapest_path_costs_what_trying_all_finds(no_native: str, rows: np.ndarray, bend: float):
    """Dynamic programming finds a path as cheap as the cheapest of all, and tells its costs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("KINESICS_NO_NATIVE", no_native)
        width, length = rows.shape
        low = 5
        # a band of rows low … low + width − 1 within rows that would all be cheaper
        by_lag = np.full((low + width, length + low + width - 1), -9.0, dtype=np.float32)
        by_lag[low:, :length] = rows
        middle = low + (width - 1) / 2.0
        path = lags.follow(by_lag, middle, bend=bend, band=((width - 1) / 2.0 - 1e-6) / middle)
    assert path is not None
    assert path.lags.min() >= low
    assert path.lags.max() < low + width
    bends = int(np.abs(np.diff(path.lags)).sum())
    assert np.abs(np.diff(path.lags)).max(initial=0) <= 1
    assert np.allclose(path.costs, rows[path.lags - low, np.arange(length)])
    assert path.costs.sum() + bend * bends == pytest.approx(naive.cheapest_path(rows.astype(float), bend), abs=1e-5)


@given(
    position=hnp.arrays(np.float32, st.integers(5, 9), elements=st.floats(0, 1, width=32)),
    reach=st.integers(1, 3),
    bend=st.floats(0.0, 0.2),
)
def test_the_best_turning_is_what_trying_all_finds(position: np.ndarray, reach: int, bend: float):
    """The least cost over all places is that of the cheapest path outwards from the axis."""
    d = np.abs(position[:, None] - position[None, :]).astype(np.float64)
    found = lags.turning(lags.diagonals(d, len(d) - 1), reach, bend=bend).costs
    expected = naive.turning_best(d, reach, bend)
    if np.isinf(expected):
        assert np.isinf(found).all()
    else:
        assert found.min() == pytest.approx(expected, abs=1e-5)


def test_compiled_and_numpy_take_the_same_paths(monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator):
    """Both ways give the same lags and the same turnings, ties included."""
    t = np.arange(150)
    by_lag = _by_lag(np.round(np.sin(2 * np.pi * t / 23) + 0.2 * rng.standard_normal(150), 1))
    seen = []
    for way in WAYS:
        monkeypatch.setenv("KINESICS_NO_NATIVE", way)
        path = lags.follow(by_lag, 22.0, bend=0.01)
        assert path is not None
        seen.append((path.lags, lags.turning(by_lag, 11, bend=0.01).costs))
    assert np.array_equal(seen[0][0], seen[1][0])
    assert np.allclose(seen[0][1], seen[1][1])


def test_a_lag_follows_a_tempo_that_changes():
    """A swing that slows down by a third keeps returning after one swing, not after so many moments."""
    t = np.arange(240.0)
    phase = t / 20.0 - (t / 240.0) ** 2 * 2.0
    position = np.stack([np.cos(2 * np.pi * phase), np.sin(2 * np.pi * phase)], axis=1)
    d = np.linalg.norm(position[:, None] - position[None], axis=-1)
    path = lags.follow(lags.diagonals(d, 80), 24.0, bend=lags.bend_cost(d), band=0.4)
    assert path is not None
    ahead = np.interp(np.arange(len(path.lags)) + path.lags, t, phase) - phase[: len(path.lags)]
    assert np.abs(ahead - 1.0).max() < 0.06
    assert path.lags[-1] > path.lags[0] + 3


def test_a_turning_lies_where_the_movement_turns():
    """There and back, the way back slower: the cheapest path starts where the way back begins."""
    there = np.linspace(0.0, 1.0, 31)
    back = np.linspace(1.0, 0.0, 46)[1:]
    position = np.concatenate([there, back])
    found = lags.turning(_by_lag(position), 30, bend=1e-4).costs
    assert abs(int(np.argmin(found)) / 2.0 - 30.0) <= 1.0
    assert found.min() < 0.02
    one_way = lags.turning(_by_lag(np.linspace(0.0, 2.0, 76)), 30, bend=1e-4).costs
    assert one_way.min() > 10.0 * found.min()


def test_too_short_for_a_lag_is_none():
    """A lag longer than the recording has no path."""
    assert lags.follow(_by_lag(np.arange(10.0)), 9.0, bend=0.1) is None


def test_a_flat_recording_has_no_turning_that_costs():
    """All turnings of a standstill cost nothing: what they mean is for the caller to judge."""
    found = lags.turning(_by_lag(np.zeros(20)), 4, bend=0.0).costs
    assert found[np.isfinite(found)].max() == 0.0
