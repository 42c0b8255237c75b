"""Sums of D and D* along diagonals, on every code path."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinesics.body import pose
from kinesics.errors import InputError
from kinesics.similarity import _kernel, diagonal_sums, distance, mirror_distance
from naive import similarity as naive


def random_poses(rng, count):
    q = rng.normal(size=(count, 15, 4))
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(("rows", "columns", "length"), [(1, 1, 1), (9, 14, 3), (20, 17, 8), (15, 15, 15), (24, 13, 7)])
def test_matches_the_twin(rng, kernel, rows, columns, length, reverse):
    """Sums along diagonals, and against the second stretch played backwards, are those of the loops."""
    a, b = random_poses(rng, rows), random_poses(rng, columns)
    found = diagonal_sums(a, b, length=length, reverse=reverse)
    expected = naive.diagonal_sums(naive.distance(a, b), length, reverse)
    expected_mirror = naive.diagonal_sums(naive.mirror_distance(a, b), length, reverse)
    np.testing.assert_allclose(found.d, expected, atol=5e-7 * length)
    np.testing.assert_allclose(found.d_mirror, expected_mirror, atol=5e-7 * length)


def shifted_sum(d, length):
    rows, columns = d.shape[0] - length + 1, d.shape[1] - length + 1
    return sum(d[k : k + rows, k : k + columns].astype(np.float64) for k in range(length))


_SINGLE = 2e-5
"""By which D differs from one code path to another: where two pelvises are upside down to each other it goes with the root of what
single precision rounds, 2.4e-4, of which a pelvis is a fifteenth; elsewhere they agree to 4e-7."""


@given(
    seed=st.integers(0, 2**32 - 1),
    rows=st.integers(1, 420),
    columns=st.integers(1, 420),
    share=st.floats(0.0, 1.0),
    itself=st.booleans(),
)
def test_across_the_borders_of_parts(seed, rows, columns, share, itself):
    """Whatever the sizes and the length, every code path gives the shifted sums of D and D*."""
    rng = np.random.default_rng(seed)
    a = random_poses(rng, rows)
    b = None if itself else random_poses(rng, columns)
    other = a if b is None else b
    length = 1 + round(share * (min(len(a), len(other)) - 1))
    d = distance(a, other)
    if itself:
        np.fill_diagonal(d, 0.0)
    for path in _kernel.available():
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("KINESICS_KERNEL", path)
            found = diagonal_sums(a, b, length=length)
        np.testing.assert_allclose(found.d, shifted_sum(d, length), atol=_SINGLE * length)
        np.testing.assert_allclose(
            found.d_mirror, shifted_sum(mirror_distance(a, other), length), atol=_SINGLE * length
        )


def test_finds_the_four_relations(rng):
    """A stretch played the same, mirrored, reversed, or both, is found where it lies under its relation alone."""
    stretch = random_poses(rng, 20)
    between = [random_poses(rng, 7) for _ in range(4)]
    forms = [stretch, pose.mirror(stretch), stretch[::-1], pose.mirror(stretch)[::-1]]
    whole = np.concatenate([part for pair in zip(between, forms, strict=True) for part in pair])
    forwards = diagonal_sums(stretch, whole, length=20)
    backwards = diagonal_sums(stretch, whole, length=20, reverse=True)
    for number, sums in enumerate((forwards.d, forwards.d_mirror, backwards.d, backwards.d_mirror)):
        place = 7 + number * 27
        assert np.flatnonzero(sums[0] < 0.1).tolist() == [place]


def test_of_one_recording_is_symmetric(rng, kernel):
    """Compared with itself the result equals its transpose to the last bit, and is 0 on the diagonal."""
    found = diagonal_sums(random_poses(rng, 300), length=12)
    if kernel != "numpy":  # there each half is computed on its own
        np.testing.assert_array_equal(found.d, found.d.T)
        np.testing.assert_array_equal(found.d_mirror, found.d_mirror.T)
    np.testing.assert_array_equal(np.diagonal(found.d), 0.0)


def test_refuses_lengths_that_do_not_fit(rng):
    """0, and more than the shorter recording has."""
    a, b = random_poses(rng, 9), random_poses(rng, 5)
    for length in (0, 6):
        with pytest.raises(InputError, match=f"between 1 and 5, the shorter recording; got {length}"):
            diagonal_sums(a, b, length=length)


@pytest.mark.parametrize("reverse", [False, True])
def test_writes_into_out(rng, kernel, reverse):
    """The given arrays hold the result; of another shape they are refused."""
    a, b = random_poses(rng, 40), random_poses(rng, 31)
    d, d_mirror = np.full((2, 36, 27), np.nan, dtype=np.float32)
    found = diagonal_sums(a, b, length=5, reverse=reverse, out=(d, d_mirror))
    assert np.shares_memory(found.d, d)
    assert np.shares_memory(found.d_mirror, d_mirror)
    fresh = diagonal_sums(a, b, length=5, reverse=reverse)
    np.testing.assert_array_equal(found.d, fresh.d)
    np.testing.assert_array_equal(found.d_mirror, fresh.d_mirror)
    with pytest.raises(InputError, match=r"`out` d to be a float32 array of shape \(35, 26\), got float32 \(36, 27\)"):
        diagonal_sums(a, b, length=6, out=(d, d_mirror))
