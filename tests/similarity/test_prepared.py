"""Poses made ready once: parts of D and D* are what they are when computed alone."""

import numpy as np
import pytest

from kinesics.errors import InputError
from kinesics.similarity import Prepared, distance, mirror_distance

ROUNDING = 5e-7


def _poses(rng, count):
    q = rng.normal(size=(count, 15, 4))
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


@pytest.mark.parametrize(
    ("rows", "columns"),
    [
        (slice(0, 40), slice(0, 700)),
        (slice(5, 6), slice(3, 690)),
        (slice(333, 600), slice(17, 20)),
        (slice(301, 700), slice(299, 700)),
        (np.array([699, 0, 4, 4, -1]), np.array([3, 2, 1])),
        (slice(10, 12), np.arange(0, 700, 7)),
        (slice(10, 10), slice(0, 5)),
    ],
)
def test_parts_are_those_of_the_whole(rng, kernel, rows, columns):
    """Whatever ranges or lists are asked for, on every code path, D and D* are those of the frames named."""
    q = _poses(rng, 700)
    d, mirrored = Prepared(q).distances(rows, columns)
    if isinstance(rows, slice) and rows.start == rows.stop:
        assert d.shape == mirrored.shape == (0, 5)
        return
    np.testing.assert_allclose(d, distance(q[rows], q[columns]), atol=ROUNDING)
    np.testing.assert_allclose(mirrored, mirror_distance(q[rows], q[columns]), atol=ROUNDING)


def test_weights_count(rng, kernel):
    """Weights are those of the distances."""
    q, weights = _poses(rng, 50), np.arange(1.0, 16.0)
    weights[11:] = weights[7:11]
    d, _ = Prepared(q, weights).distances(slice(3, 9), slice(0, 50))
    np.testing.assert_allclose(d, distance(q[3:9], q, weights), atol=ROUNDING)


def test_bad_poses_are_refused():
    """What is no pose is refused at the door."""
    with pytest.raises(InputError, match="unit quaternions"):
        Prepared(np.ones((2, 15, 4)))
