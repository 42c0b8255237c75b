"""Moments at which a movement turns back on its own path ([Schultz2012] §3.2.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from kinesics.grammar import lags
from kinesics.grammar.moments import Moments
from kinesics.grammar.motifs.speed import speed_on_moments
from kinesics.grammar.motifs.valleys import valleys
from kinesics.grammar.ranges import SWAY, range_of, spread

_TURN_S: Final = (0.4, 0.8, 1.6)
_TURNING: Final = 0.12
"""Residual up to which a path counts as turning back; up to twice as much where the body stops for it."""
_MUCH: Final = 0.35
"""Share of the range of the longest reach that must be passed through within a shorter one to judge by that."""
_SLOWED: Final = 0.6
"""Share of the speed around, from which down a turning counts as slowed for."""
_TURNS_APART_S: Final = 0.25


@dataclass(frozen=True)
class Reversal:
    """A moment at which the movement turns back on its own path."""

    moment: int
    residual: float
    """What the way back leaves of the way there, over what may be left: 0 is exact, 1 the limit."""


def find_reversals(moments: Moments) -> tuple[Reversal, ...]:
    """Moments at which the movement turns back on its own path, in order.

    What comes after is what was before, backwards, for 0.4 s at least (or 0.8 or 1.6 s, where it stays at the turning for a
    while), and the body is slower there than around. Between strides, too, legs nearly retrace their way: that leaves .15 to .3
    of the range, where true turnings leave less than .12, or somewhat more where the body stops.
    """
    n, fps = moments.count, moments.fps
    reaches = [w for w in (max(2, round(s * fps)) for s in _TURN_S) if 2 * w < n]
    if not reaches:
        return ()
    by_lag = moments.d_by_lag(2 * max(reaches) + 1)
    bend = lags.bend_cost(by_lag)
    floor = SWAY + moments.noise
    places = np.arange(2 * n - 1)
    least = np.full(2 * n - 1, np.inf)
    judged = np.zeros(2 * n - 1, dtype=np.bool_)
    on = speed_on_moments(moments)
    around = range_of(moments, spread(by_lag, reaches[-1]))
    widest = 0.5 * (around[places // 2] + around[(places + 1) // 2])
    for reach in reaches:
        range_ = range_of(moments, spread(by_lag, reach))
        # a place between two moments has the range of both
        size = 0.5 * (range_[places // 2] + range_[(places + 1) // 2])
        mean = np.convolve(np.pad(on, reach, mode="edge"), np.ones(2 * reach + 1) / (2 * reach + 1), "valid")
        slow = 0.5 * (on[places // 2] + on[(places + 1) // 2]) / np.maximum(mean[places // 2], 1e-12)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.maximum(lags.turning(by_lag, reach, bend=bend).costs - moments.noise, 0.0) / size
        share /= _TURNING * (1.0 + np.maximum(1.0 - slow / _SLOWED, 0.0))
        share[(slow >= 1.0) | np.isnan(share)] = np.inf
        # a longer reach is for where little moves within the shorter one
        here = (size > np.maximum(floor, _MUCH * widest)) & ~judged
        least[here] = share[here]
        judged |= here
    found = valleys(least, 1.0, round(2 * _TURNS_APART_S * fps))
    return tuple(Reversal(c // 2, float(least[c])) for c in sorted(found))
