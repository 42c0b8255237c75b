"""A larger threshold where the usual one leaves most of the recordings out."""

from __future__ import annotations

import numpy as np

from bodies import about, moving
from kinesics.body.motion import Motion
from kinesics.similarity import check_weights
from kinesics.synthesis import unused
from kinesics.synthesis.joining.limits import find_limits
from kinesics.synthesis.joining.transitions import transitions
from kinesics.synthesis.joining.widening import WIDER
from kinesics.synthesis.paths.network import network
from kinesics.synthesis.paths.reach import farther
from kinesics.synthesis.repertoire import repertoire


def _three_ways(apart: float, far: float = 1.6) -> Motion:
    """Arms swung low, and seldom far, for eight seconds each in three postures of the trunk."""
    t = np.arange(720) / 30.0
    size = np.where(np.sin(2.0 * np.pi * 0.25 * t) > 0.5, far, 0.5) * (1.0 + 0.1 * np.sin(2.0 * np.pi * 0.23 * t))
    size = np.convolve(np.pad(size, 4, mode="edge"), np.ones(9) / 9.0, mode="valid")
    swing = size * np.sin(2.0 * np.pi * 0.8 * t)
    over = apart * (np.clip(t - 8.0, 0.0, 1.0) + np.clip(t - 16.0, 0.0, 1.0))
    angles = {f"{side}Arm": about(0, 0.6 * sign * swing) for side, sign in (("Left", 1.0), ("Right", -1.0))}
    return moving(angles | {"Spine": about(0, over), "Chest": about(0, over), "Neck": about(0, over)}, fps=30)


def test_a_larger_threshold_joins_what_would_be_left_out() -> None:
    """Two thirds are left out by the usual threshold: the one that is found joins them, is no larger than nine tenths of the
    moments allow, and is told."""
    stock = repertoire(_three_ways(0.8))
    limits = find_limits(stock, None, check_weights(None))
    before = network(stock, threshold=limits.distance)
    assert unused.used(before).unused > 0.6
    raised = network(stock)
    assert limits.distance < raised.threshold <= min(limits.most, WIDER * limits.distance)
    assert unused.used(raised).unused < 0.1
    assert "by the usual" in raised.rule
    assert raised.distance.max() <= raised.threshold


def test_what_hangs_together_keeps_its_threshold() -> None:
    """Where half is joined already, though more would be by a larger one."""
    stock = repertoire(_three_ways(0.4))
    limits = find_limits(stock, None, check_weights(None))
    assert limits.distance < limits.most
    made = transitions(stock)
    assert made.threshold == limits.distance
    assert made.limits.rule == limits.rule


def test_what_nothing_joins_keeps_its_threshold() -> None:
    """Where no moment changes much more than the others nine tenths of them allow no more, either."""
    stock = repertoire(_three_ways(0.8, far=0.5))
    limits = find_limits(stock, None, check_weights(None))
    made = network(stock)
    assert unused.used(made).unused > 0.5
    assert made.threshold == limits.distance


def test_a_threshold_that_is_given_is_taken() -> None:
    """However little it joins."""
    made = transitions(repertoire(_three_ways(0.8)), threshold=0.002)
    assert made.threshold == 0.002
    assert made.limits.rule == "given"


def test_no_threshold_is_advised_that_is_taken_already() -> None:
    """Beyond what is taken nothing more is joined."""
    assert farther(network(repertoire(_three_ways(0.8)))) is None
