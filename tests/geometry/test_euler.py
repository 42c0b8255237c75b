"""Euler angles in all 24 orders, gimbal lock among them."""

from __future__ import annotations

import warnings

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from kinesics.errors import InputError
from kinesics.geometry import euler, quaternion
from naive import geometry as naive

SHAPES = [(), (1,), (3, 1, 2, 1)]
turns = st.one_of(st.floats(-np.pi, np.pi), st.sampled_from([0.0, np.pi / 2, -np.pi / 2, np.pi, -np.pi, 1e-9]))


def lock_of(order: str) -> tuple[float, float]:
    return (0.0, np.pi) if order[0] == order[2] else (-np.pi / 2, np.pi / 2)


def test_there_are_twelve_orders_of_each_kind() -> None:
    """24 in all, 12 of them intrinsic, half of these with three different axes; the dissertation's is one of them."""
    assert len(set(euler.ORDERS)) == 24
    assert sum(order.isupper() for order in euler.ORDERS) == 12
    assert sum(len(set(order)) == 3 for order in euler.ORDERS) == 12
    assert euler.FICK in euler.ORDERS


@pytest.mark.parametrize("order", euler.ORDERS)
@pytest.mark.parametrize("shape", SHAPES)
def test_from_euler_is_the_product_of_matrices(order: str, shape: tuple[int, ...], rng: np.random.Generator) -> None:
    """Each turn as a matrix, multiplied in order, for every batch shape."""
    angles = rng.uniform(-4.0, 4.0, size=(*shape, 3))
    found = quaternion.as_matrix(euler.from_euler(angles, order))
    assert found.shape == (*shape, 3, 3)
    for index in np.ndindex(shape):
        assert_allclose(found[index], naive.euler_matrix(angles[index], order), atol=1e-14)


@pytest.mark.parametrize("order", ["X", "y", "ZX", "yz", "XZ"])
def test_joints_with_fewer_axes(order: str, rng: np.random.Generator) -> None:
    """A hinge has one letter, a saddle two."""
    angles = rng.uniform(-3.0, 3.0, size=(5, len(order)))
    found = quaternion.as_matrix(euler.from_euler(angles, order))
    for k in range(5):
        assert_allclose(found[k], naive.euler_matrix(angles[k], order), atol=1e-14)


@pytest.mark.parametrize("order", euler.ORDERS)
def test_agrees_with_scipy_both_ways(order: str, rng: np.random.Generator) -> None:
    """The same quaternions from the same angles, and the same angles back, away from gimbal lock."""
    angles = rng.uniform(-np.pi, np.pi, size=(200, 3))
    theirs = Rotation.from_euler(order, angles)
    ours = euler.from_euler(angles, order)
    assert float(np.max(quaternion.angle(ours, quaternion.from_scalar_last(theirs.as_quat())))) < 1e-14
    assert_allclose(euler.as_euler(ours, order).angles, theirs.as_euler(order), atol=1e-10)


@pytest.mark.parametrize("order", euler.ORDERS)
@given(first=turns, middle=turns, third=turns, flip=st.booleans())
def test_there_and_back_is_the_same_rotation(order: str, first: float, middle: float, third: float, flip: bool) -> None:
    """For any angles and either sign the rotation survives, and the angles are in their ranges."""
    q = euler.from_euler([first, middle, third], order)
    back = euler.as_euler(-q if flip else q, order)
    assert float(quaternion.angle(q, euler.from_euler(back.angles, order))) < 1e-12
    low, high = lock_of(order)
    assert low - 1e-12 <= back.angles[1] <= high + 1e-12
    assert np.all(np.abs(back.angles) <= np.pi + 1e-12)


@pytest.mark.parametrize("order", euler.ORDERS)
def test_gimbal_lock_is_reported_and_harmless(order: str, rng: np.random.Generator) -> None:
    """At the lock and near it: the rotation is kept, no warning escapes, the flag says so, the third angle is 0."""
    outer = rng.uniform(-np.pi, np.pi, size=(50, 2))
    for lock in lock_of(order):
        for off in (0.0, 1e-14, 1e-10, 1e-8, 1e-5, 1e-2):
            middle = np.full(50, lock + (off if lock in (0.0, -np.pi / 2) else -off))
            q = euler.from_euler(np.stack([outer[:, 0], middle, outer[:, 1]], axis=1), order)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                found = euler.as_euler(q, order)
            again = euler.from_euler(found.angles, order)
            assert float(np.max(quaternion.angle(q, again))) < 1e-11
            assert np.all(found.gimbal_lock == (off < euler.LOCK_TOLERANCE))
            if off == 0.0:
                assert_allclose(found.angles[:, 2], 0.0, atol=1e-15)


def test_fick_angles_are_the_dissertations(rng: np.random.Generator) -> None:
    """§2.1: R(θx, θy, θz) = Rz·Ry·Rx, the angles given in the order x, y, z."""
    x, y, z = angles = rng.uniform(-1.5, 1.5, size=3)
    matrix = naive.rotation_matrix("z", z) @ naive.rotation_matrix("y", y) @ naive.rotation_matrix("x", x)
    q = euler.from_fick(angles)
    assert_allclose(quaternion.as_matrix(q), matrix, atol=1e-15)
    assert_allclose(euler.as_fick(q).angles, angles, atol=1e-14)
    assert_allclose(euler.from_euler([z, y, x], "ZYX"), q, atol=1e-15)


def test_batches_come_back_in_shape() -> None:
    """No axis is dropped or gained, on either way."""
    q = quaternion.identity((3, 1, 2, 1))
    found = euler.as_euler(q, "ZXY")
    assert found.angles.shape == (3, 1, 2, 1, 3)
    assert found.gimbal_lock.shape == (3, 1, 2, 1)
    assert euler.from_euler(found.angles, "ZXY").shape == q.shape
    assert euler.as_euler(quaternion.identity(), "zyz").gimbal_lock.shape == ()


@pytest.mark.parametrize("order", ["", "XX", "XYY", "XYZX", "XyZ", "ABC", "XY Z"])
def test_what_is_no_order_is_refused(order: str) -> None:
    """The message says what an order looks like."""
    with pytest.raises(InputError, match="no order of Euler angles"):
        euler.from_euler(np.zeros(3), order)


def test_wrong_shapes_are_refused() -> None:
    """Angles that do not fit the order, orders too short to take a rotation apart, what is no quaternion."""
    with pytest.raises(InputError, match=r"\(\.\.\., 2\) for the order 'XY', got \(4, 3\)"):
        euler.from_euler(np.zeros((4, 3)), "XY")
    with pytest.raises(InputError, match="Expected three letters"):
        euler.as_euler(quaternion.identity(), "XY")
    with pytest.raises(InputError, match=r"\(\.\.\., 4\), got \(3,\)"):
        euler.as_euler(np.zeros(3), "XYZ")
