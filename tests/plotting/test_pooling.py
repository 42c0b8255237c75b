"""Large matrices made small: by maximum, so that nothing thin is lost."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bodies
import kinesics as kx
from kinesics.errors import InputError
from kinesics.plotting import pool_maximum, pooled_similarity
from kinesics.plotting.similarity_plots import rotate_to_triangle
from naive import pooling as naive


@given(st.integers(1, 25), st.integers(1, 30), st.integers(0, 99))
def test_pooling_is_the_maximum_over_blocks(frames: int, size: int, seed: int) -> None:
    """The fast pooling and the loops agree to the last bit."""
    matrix = np.random.default_rng(seed).random((frames, frames), dtype=np.float32)
    np.testing.assert_array_equal(pool_maximum(matrix, size), naive.pool_maximum(matrix, size))


@given(st.integers(2, 60), st.integers(1, 12), st.integers(0, 99))
def test_no_cell_is_dropped(frames: int, size: int, seed: int) -> None:
    """A single bright cell anywhere is still as bright in the pooled picture."""
    matrix = np.zeros((frames, frames), dtype=np.float32)
    i, j = np.random.default_rng(seed).integers(0, frames, 2)
    matrix[i, j] = 1.0
    assert pool_maximum(matrix, size).max() == 1.0


@given(st.integers(1, 40), st.integers(0, 99))
def test_the_triangle_holds_every_cell_once(frames: int, seed: int) -> None:
    """Turned by 45 degrees the matrix is what the loops make of it."""
    half = np.random.default_rng(seed).random((frames, frames), dtype=np.float32)
    matrix = np.maximum(half, half.T)
    np.testing.assert_array_equal(rotate_to_triangle(matrix, frames), naive.triangle(matrix))


def test_a_small_matrix_is_blown_up_by_a_whole_factor() -> None:
    """Two moments fill a triangle as wide as asked for, the identity axis along its lower edge."""
    matrix = np.array([[1.0, 0.25], [0.25, 1.0]], dtype=np.float32)
    triangle = rotate_to_triangle(matrix, 9)
    assert triangle.shape == (4, 8)
    assert (triangle[0] == 1.0).all()
    assert triangle[-1].max() == pytest.approx(0.25)


@given(st.integers(2, 20), st.sampled_from([2, 4, 6]), st.integers(0, 99))
def test_between_the_cells_of_a_small_matrix_nothing_jumps(frames: int, factor: int, seed: int) -> None:
    """Every cell is met at its own place, pixels beside one another differ by little, and none is out of bounds."""
    half = np.random.default_rng(seed).random((frames, frames), dtype=np.float32)
    matrix = np.maximum(half, half.T)
    triangle = rotate_to_triangle(matrix, frames * factor + min(factor, frames) - 1)
    middle = factor // 2
    for i in range(frames):
        for j in range(i, frames):
            row, column = (j - i) * factor // 2, (i + j) * factor // 2 + middle
            assert triangle[row, column] == pytest.approx(matrix[i, j], abs=1e-6)
    rows, columns = np.mgrid[: triangle.shape[0], : triangle.shape[1]]
    inside = (columns >= rows) & (columns + rows < triangle.shape[1])
    assert triangle[inside].min() >= matrix.min() - 1e-6
    assert triangle.max() <= matrix.max() + 1e-6
    # a pixel to the right is 1/factor of a cell along either index
    steepest = 2.0 * (matrix.max() - matrix.min()) / factor
    beside = inside[:, 1:] & inside[:, :-1]
    assert np.abs(np.diff(triangle, axis=1))[beside].max() <= steepest + 1e-6


@pytest.mark.parametrize("factor", [2, 3, 5, 8])
def test_thin_lines_of_a_small_matrix_do_not_pulse(factor: int) -> None:
    """One moment, one lag: a line that is a single cell thin is as bright between two of its cells as on them."""
    frames = 21
    i, j = np.indices((frames, frames))
    again = rotate_to_triangle((np.abs(i - j) == 8).astype(np.float32), frames * factor)
    assert again[4 * factor, 5 * factor : -5 * factor] == pytest.approx(1.0)
    turning = rotate_to_triangle((i + j == 20).astype(np.float32), frames * factor)
    assert turning[: 9 * factor, 10 * factor + factor // 2] == pytest.approx(1.0)


@pytest.mark.parametrize(("frames", "size"), [(1, 10), (2, 10), (37, 64), (1500, 101), (1300, 1300), (1100, 700)])
def test_pooling_the_tiles_is_pooling_the_matrix(frames: int, size: int) -> None:
    """Straight from the poses, without N×N, comes the same picture as from the full matrices."""
    poses = kx.poses(bodies.legs_striding(frames, period=1.37))
    pooled = pooled_similarity(poses, size=size)
    full = kx.similarity(poses)
    assert pooled.frame_count == frames
    assert pooled.beta == full.beta
    np.testing.assert_allclose(pooled.z, pool_maximum(full.z, size), atol=2e-5)
    np.testing.assert_allclose(pooled.z_mirror, pool_maximum(full.z_mirror, size), atol=2e-5)
    np.testing.assert_array_equal(pooled.z, pooled.z.T)


def test_a_strike_of_one_frame_survives_in_a_long_recording() -> None:
    """Two single frames with the same strange pose leave a full-strength mark among 3,000 others."""
    frames = 3000
    raised = np.zeros(frames)
    raised[[701, 2203]] = 1.5
    motion = bodies.moving(
        {"LeftArm": bodies.about(2, raised), "RightLeg": bodies.about(0, np.linspace(0.2, 1.2, frames))}
    )
    poses = kx.poses(motion)
    pooled = pooled_similarity(poses, size=100, beta=50.0)
    z = pooled.z[701 * 100 // frames, 2203 * 100 // frames]
    expected = np.exp(-50.0 * kx.distance(poses[701:702], poses[2203:2204])[0, 0])
    assert z >= expected - 1e-5


@pytest.mark.parametrize("matrix", [np.zeros((3, 4)), np.zeros(5), np.zeros((0, 0))])
def test_what_is_no_square_is_refused(matrix: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> None:
    """The message tells the shape that came."""
    with pytest.raises(InputError, match="square"):
        pool_maximum(matrix, 4)


def test_a_size_below_one_is_refused() -> None:
    """By both ways of pooling."""
    with pytest.raises(InputError, match="size"):
        pool_maximum(np.eye(3), 0)
    with pytest.raises(InputError, match="size"):
        pooled_similarity(kx.poses(bodies.arms_swinging(5)), size=0)
