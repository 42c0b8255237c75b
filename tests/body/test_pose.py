"""The pose as an array: mirror operator, symmetric and antisymmetric parts, gravity, slices."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from kinesics.body import pose
from kinesics.errors import InputError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]


def random_poses(rng: np.random.Generator, count: int, size: float = 1.0) -> Array:
    q = quaternion.from_rotvec(rng.normal(0, size, (count, 15, 3)))
    q[:, 0] = quaternion.yaw_tilt(q[:, 0]).tilt
    return q


def mirror_distance_to_itself(q: Array) -> Array:
    """D*(a, a) from the definition, the root by gravity."""
    image = pose.mirror(q)
    dots = np.abs(np.sum(q * image, axis=-1))
    cos = np.sum(pose.gravity(q) * pose.gravity(image), axis=-1)
    dots[:, 0] = np.sqrt(np.maximum(0.0, (1 + cos) / 2))
    return np.asarray(1 - dots.mean(axis=-1))


def test_the_mirror_is_an_involution_that_swaps_sides(rng: np.random.Generator) -> None:
    """W twice is the identity; the left femur comes from the right one."""
    q = random_poses(rng, 10)
    np.testing.assert_allclose(pose.mirror(pose.mirror(q)), q)
    np.testing.assert_allclose(pose.mirror(q)[:, 7], q[:, 11] * [1, 1, -1, -1])


@pytest.mark.parametrize("size", [0.01, 0.5, 3.0])
def test_symmetric_and_antisymmetric_parts(size: float, rng: np.random.Generator) -> None:
    """D*(a, a) = 2·mean|A|² exactly; the parts are orthogonal and of unit sum link by link (§2.11)."""
    q = random_poses(rng, 200, size)
    parts = pose.symmetry_parts(q)
    squares = np.sum(parts.antisymmetric**2, axis=-1)
    np.testing.assert_allclose(2 * squares.mean(axis=-1), mirror_distance_to_itself(q), atol=1e-12)
    np.testing.assert_allclose(np.sum(parts.symmetric**2, axis=-1) + squares, 1.0, atol=1e-12)
    # S is its own mirror image and A the negative of its own, up to the sign that makes q·(Wq) ≥ 0
    np.testing.assert_allclose(np.abs(pose.mirror(parts.symmetric)), np.abs(parts.symmetric), atol=1e-12)
    np.testing.assert_allclose(np.abs(pose.mirror(parts.antisymmetric)), np.abs(parts.antisymmetric), atol=1e-12)


def test_parts_do_not_know_signs(rng: np.random.Generator) -> None:
    """Flipping quaternion signs changes no length of any part."""
    q = random_poses(rng, 50)
    flipped = q * rng.choice([-1.0, 1.0], (50, 15, 1))
    a, b = pose.symmetry_parts(q), pose.symmetry_parts(flipped)
    np.testing.assert_allclose(
        np.linalg.norm(a.antisymmetric, axis=-1), np.linalg.norm(b.antisymmetric, axis=-1), atol=1e-12
    )


def test_inner_product_splits_into_parts(rng: np.random.Generator) -> None:
    """Ψa∘Ψb = S∘S + A∘A over the whole signed body vector (§2.14)."""
    a, b = (pose.symmetry_parts(random_poses(rng, 60, 0.4)) for _ in range(2))
    whole = np.sum((a.symmetric + a.antisymmetric) * (b.symmetric + b.antisymmetric), axis=(-1, -2))
    split = np.sum(a.symmetric * b.symmetric, axis=(-1, -2)) + np.sum(a.antisymmetric * b.antisymmetric, axis=(-1, -2))
    np.testing.assert_allclose(whole, split, atol=1e-12)


def test_gravity_points_down_when_standing(rng: np.random.Generator) -> None:
    """The identity feels gravity along −y; the mirror negates its x."""
    assert pose.gravity(quaternion.identity((15,))).tolist() == [0.0, -1.0, 0.0]
    q = random_poses(rng, 20)
    np.testing.assert_allclose(pose.gravity(pose.mirror(q)), pose.gravity(q) * [-1, 1, 1], atol=1e-12)


def test_slices_and_bad_shapes(rng: np.random.Generator) -> None:
    """A sequence slices like an array, backwards too; wrong shapes and values are named."""
    q = random_poses(rng, 12)
    path = pose.PoseSequence(q, np.arange(12.0), np.zeros((12, 2)), 30.0)
    assert len(path[3:9]) == 6
    assert path[::2].fps == 15.0
    np.testing.assert_allclose(path[::-1].yaw, np.arange(12.0)[::-1])
    np.testing.assert_allclose(path.mirror().quaternions, pose.mirror(q))
    with pytest.raises(InputError, match=r"\(frames, 15, 4\)"):
        pose.PoseSequence(q[:, :14], np.zeros(12), np.zeros((12, 2)), 30.0)
    with pytest.raises(InputError, match="`yaw`"):
        pose.PoseSequence(q, np.zeros(11), np.zeros((12, 2)), 30.0)
    with pytest.raises(InputError, match="not finite"):
        pose.PoseSequence(np.full((1, 15, 4), np.nan), np.zeros(1), np.zeros((1, 2)), 30.0)
    with pytest.raises(InputError, match="`yaw` is not finite"):
        pose.PoseSequence(q, np.full(12, np.nan), np.zeros((12, 2)), 30.0)
    with pytest.raises(InputError, match="`ground` is not finite"):
        pose.PoseSequence(q, np.zeros(12), np.full((12, 2), np.inf), 30.0)


def test_one_index_gives_one_frame(rng: np.random.Generator) -> None:
    """As with a motion: from either end, by a number of NumPy's too; what is not there is an IndexError or named."""
    path = pose.PoseSequence(random_poses(rng, 12), np.arange(12.0), np.zeros((12, 2)), 30.0)
    for index in (5, -7, np.int64(5)):
        one = path[index]
        assert (len(one), one.fps) == (1, 30.0)
        assert one.yaw.tolist() == [5.0]
        np.testing.assert_array_equal(one.quaternions, path.quaternions[5:6])
    for missing in (12, -13):
        with pytest.raises(IndexError, match=f"Frame {missing} of a path of 12 frames"):
            path[missing]
    with pytest.raises(InputError, match=r"No frame is left of 12 by \[9:3\]"):
        path[9:3]
    assert [float(one.yaw[0]) for one in path] == list(range(12))


def test_yaw_is_carried_where_it_has_no_meaning(rng: np.random.Generator) -> None:
    """Through a moment upside down the heading is the last one, and it is flagged."""
    values = pose._carry(np.array([5.0, 1.0, 0.0, 0.0, 2.0]), np.array([True, False, True, True, False]))
    assert values.tolist() == [1.0, 1.0, 1.0, 1.0, 2.0]
