"""Symmetric states (§2.12, §3.3)."""

from __future__ import annotations

import numpy as np
import pytest

import bodies
import kinesics as kx
from kinesics.analysis import SYMMETRY_THRESHOLD, find_symmetric_states
from kinesics.errors import InputError


def test_ranges_are_below_the_threshold_and_end_exclusive() -> None:
    """[start, end), from the first frame below to the first above again."""
    values = np.array([0.1, 0.004, 0.003, 0.1, 0.1, 0.002])
    assert find_symmetric_states(values) == [(1, 3), (5, 6)]


def test_noise_at_the_border_does_not_cut_a_stretch() -> None:
    """A stretch goes on until 1.25 times the threshold; it needs one moment below the threshold itself."""
    edge = SYMMETRY_THRESHOLD
    assert find_symmetric_states([0.1, 0.9 * edge, 1.2 * edge, 0.9 * edge, 0.1]) == [(1, 4)]
    assert find_symmetric_states([0.1, 1.2 * edge, 1.1 * edge, 0.1]) == []


def test_a_movement_passes_its_symmetric_state_twice_a_cycle() -> None:
    """An arm that swings through the symmetric pose is symmetric for a moment each time (§3.4.8), at any frame rate."""
    for fps in (30.0, 120.0):
        motion = bodies.arms_swinging(round(8 * fps), fps=fps, period=4.0, mirrored=False)
        analysis = kx.analyze(motion)
        middles = [(r.start + r.end - 1) / 2 / fps for r in analysis.symmetric_states]
        np.testing.assert_allclose(middles[1:4], [2.0, 4.0, 6.0], atol=2.0 / fps)


def test_a_symmetric_movement_is_one_long_state() -> None:
    """Both arms alike: symmetric from the first frame to the last."""
    analysis = kx.analyze(bodies.arms_swinging(100))
    assert [(r.start, r.end) for r in analysis.symmetric_states] == [(0, 100)]


def test_bad_arguments_are_refused() -> None:
    """A matrix in place of a curve, a threshold of 0."""
    with pytest.raises(InputError, match="one value a frame"):
        find_symmetric_states(np.eye(3))
    with pytest.raises(InputError, match="above 0"):
        find_symmetric_states([0.1], threshold=0.0)
