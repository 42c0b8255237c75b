"""What a larger threshold would join."""

from __future__ import annotations

import numpy as np

from bodies import about, moving
from kinesics.body.motion import Motion
from kinesics.synthesis.paths.network import network
from kinesics.synthesis.paths.reach import farther
from kinesics.synthesis.repertoire import repertoire


def _two_ways(apart: float) -> Motion:
    """Arms swung low for ten seconds, and then with the trunk bent by an angle; from the one to the other only once."""
    t = np.arange(600) / 30.0
    swing = (1.0 + 0.1 * np.sin(2.0 * np.pi * 0.23 * t)) * np.sin(2.0 * np.pi * 0.8 * t)
    over = apart * np.clip((t - 9.5), 0.0, 1.0)
    angles = {f"{side}Arm": about(0, 0.6 * sign * swing) for side, sign in (("Left", 1.0), ("Right", -1.0))}
    return moving(angles | {"Spine": about(0, over), "Chest": about(0, over), "Neck": about(0, over)}, fps=30)


def test_the_least_threshold_that_joins_the_rest() -> None:
    """Half is left out; with the threshold named nearly nothing is, with a fifth less of it half still is."""
    both = repertoire(_two_ways(0.8))
    short = network(both)
    assert short.seconds < 0.6 * 2 * 20.0
    larger = farther(short)
    assert larger is not None
    assert network(both, threshold=larger.threshold).seconds == larger.seconds > 0.9 * 2 * 20.0
    assert network(both, threshold=0.8 * larger.threshold).seconds < 0.6 * 2 * 20.0


def test_none_where_nothing_more_is_joined() -> None:
    """Where all is joined already."""
    assert farther(network(repertoire(_two_ways(0.0)))) is None
