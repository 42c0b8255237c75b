"""Angles of joints with fewer axes than three: found where there are any, and how nearly where there are none."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from kinesics.formats import angles
from kinesics.geometry import euler, quaternion

ORDERS = ["".join(p) for p in permutations("XYZ")]


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("kept", [[0], [1], [2], [0, 1], [0, 2], [1, 2], [0, 1, 2]], ids=str)
def test_angles_that_made_a_rotation_are_found(order: str, kept: list[int], rng: np.random.Generator) -> None:
    """For any of the axes, in any order, with q and −q."""
    axes = "".join(order[k] for k in kept)
    made = rng.uniform(-1.4, 1.4, size=(50, len(axes)))
    rotations = euler.from_euler(made, axes) * rng.choice([-1.0, 1.0], size=(50, 1))
    found, missed = angles.angles_of_rotations(rotations, order, axes)
    np.testing.assert_allclose(found, made, atol=1e-12)
    assert missed < 1e-7


@pytest.mark.parametrize("order", ORDERS)
def test_what_fewer_axes_miss_is_measured(order: str, rng: np.random.Generator) -> None:
    """The angle between the rotations and those of the angles found: all of it where no axis may turn."""
    turned = rng.uniform(0.2, 1.0, size=20)
    alone = euler.from_euler(turned[:, None], order[2])
    found, missed = angles.angles_of_rotations(alone, order, order[:1])
    np.testing.assert_allclose(found, 0.0, atol=1e-12)
    assert missed == pytest.approx(turned.max())
    found, missed = angles.angles_of_rotations(alone, order, "")
    assert found.shape == (20, 0)
    assert missed == pytest.approx(turned.max())


@pytest.mark.parametrize("order", ORDERS)
def test_two_angles_are_found_where_one_half_turn_leaves_little(order: str) -> None:
    """A half turn about one of the axes, at which half of the components are nothing."""
    for made in ([np.pi, 0.3], [0.3, np.pi], [np.pi, np.pi], [0.0, 0.0]):
        rotation = euler.from_euler(np.array([made]), order[:2])
        found, missed = angles.angles_of_rotations(rotation, order, order[:2])
        assert missed < 1e-7
        assert quaternion.angle(euler.from_euler(found, order[:2]), rotation).max() < 1e-7


def test_an_order_is_completed_in_the_preferred_one_where_it_can_be() -> None:
    """The letters keep their order; what is no axis, or stands twice, is a mistake."""
    assert angles.complete_order("", "ZXY") == "ZXY"
    assert angles.complete_order("zy", "ZXY") == "ZXY"
    assert angles.complete_order("YZ", "ZXY") == "XYZ"
    assert angles.complete_order("yxz", "ZXY") == "YXZ"
    for wrong in ("XX", "W"):
        with pytest.raises(ValueError, match=wrong):
            angles.complete_order(wrong, "ZXY")
