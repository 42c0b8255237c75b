"""One rotation at a time: each function is the one of `kinesics.geometry.quaternion`, in plain numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinesics.geometry import quaternion, single

seeds = st.integers(0, 100_000)


def drawn(seed: int) -> tuple[tuple, tuple, tuple, tuple]:
    """Two rotations and two vectors."""
    rng = np.random.default_rng(seed)
    p, q = (tuple(quaternion.normalize(rng.normal(size=4)).tolist()) for _ in range(2))
    v, w = (tuple(rng.normal(size=3).tolist()) for _ in range(2))
    return p, q, v, w


@given(seeds)
def test_products_are_those_of_arrays(seed: int) -> None:
    """Product, product with an inverse, and turned vectors."""
    p, q, v, _ = drawn(seed)
    assert single.multiply(p, q) == pytest.approx(quaternion.multiply(p, q), abs=1e-14)
    assert single.undo(p, q) == pytest.approx(quaternion.multiply(quaternion.conjugate(p), q), abs=1e-14)
    assert single.rotate(p, v) == pytest.approx(quaternion.rotate(p, v), abs=1e-14)


@given(seeds, st.floats(0.0, 2.0 * math.pi))
def test_exponential_and_logarithm_are_those_of_arrays(seed: int, angle: float) -> None:
    """Of every angle, none and half a turn included, and of both signs of a quaternion."""
    _, q, v, _ = drawn(seed)
    v = tuple((np.array(v) * angle / np.linalg.norm(v)).tolist())
    assert single.from_rotvec(v) == pytest.approx(quaternion.from_rotvec(v), abs=1e-14)
    assert single.as_rotvec(single.from_rotvec(v)) == pytest.approx(
        quaternion.as_rotvec(quaternion.from_rotvec(v)), abs=1e-9
    )
    for rotation in (q, tuple(-c for c in q), (1.0, 0.0, 0.0, 0.0)):
        assert single.as_rotvec(rotation) == pytest.approx(quaternion.as_rotvec(rotation), abs=1e-14)


@given(seeds)
def test_least_turn_is_that_of_arrays(seed: int) -> None:
    """One direction onto another."""
    _, _, v, w = drawn(seed)
    assert single.least_turn(v, w) == pytest.approx(quaternion.between(v, w), abs=1e-12)


def test_least_turn_of_what_has_none_is_no_turn() -> None:
    """The same direction, opposite directions, no direction."""
    still = (1.0, 0.0, 0.0, 0.0)
    assert single.least_turn((0.0, 2.0, 0.0), (0.0, 1.0, 0.0)) == still
    assert single.least_turn((0.0, 2.0, 0.0), (0.0, -1.0, 0.0)) == still
    assert single.least_turn((0.0, 0.0, 0.0), (0.0, -1.0, 0.0)) == still


@given(seeds)
def test_vectors(seed: int) -> None:
    """Sum, difference, products and length."""
    _, _, v, w = drawn(seed)
    assert single.add(v, w) == pytest.approx(np.add(v, w))
    assert single.subtract(v, w) == pytest.approx(np.subtract(v, w))
    assert single.dot(v, w) == pytest.approx(np.dot(v, w))
    assert single.cross(v, w) == pytest.approx(np.cross(v, w))
    assert single.length(v) == pytest.approx(np.linalg.norm(v))
