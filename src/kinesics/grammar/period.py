"""The shortest period of a movement, with tempo freedom."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar import lags

Distances = NDArray[Any]

SHORTEST_S: Final = 0.25
"""Seconds of the shortest period looked for."""
LONGEST_S: Final = 40.0
"""Seconds of the longest period looked for, so that memory grows with the recording and not with its square."""
LONGEST_SHARE: Final = 0.7
"""Of the recording: the rest of it must show the return."""
_STEP: Final = 1.06
"""Ratio of neighbouring trial lags: far finer than the band that each of them searches."""
_COVERED: Final = 0.25
"""A path must cover this share of the recording."""
_RETURN: Final = 0.5
"""A return must bring the distance below this share of what it rose to."""
_AS_GOOD: Final = 0.12
"""Of the rise: a shorter lag within this of the best one is the period, the best one a multiple of it."""


def longest_lag(moments: int, fps: float) -> int:
    """The longest lag looked at in a recording of so many moments."""
    return max(1, int(min(LONGEST_SHARE * moments, LONGEST_S * fps)))


def find(by_lag: Distances, *, shortest: float) -> lags.LagPath | None:
    """The path at the shortest lag after which the movement is the same, or None.

    A lag counts as a return when the movement went clearly away before it; medians over time, so that a beginning and an
    end that do not belong to the cycle (raising the hand before waving) do not decide.

    Parameters
    ----------
    by_lag : D of moments i and i + k in row k (`Moments.by_lag`), up to `longest_lag`.
    shortest : shortest lag tried, moments.
    """
    most, n = len(by_lag) - 1, by_lag.shape[1]
    bend = lags.bend_cost(by_lag)
    trials: list[lags.LagPath] = []
    lag = float(shortest)
    while lag < most / 1.05:
        path = lags.follow(by_lag, lag, bend=bend, band=min(lags.BAND, (most - 1) / lag - 1))
        if path is not None and len(path.lags) >= _COVERED * n:
            trials.append(path)
        lag *= _STEP
    if not trials:
        return None
    typical = np.array([np.median(p.costs) for p in trials])
    rise = np.maximum.accumulate(typical)
    returned = typical < _RETURN * rise
    if not returned.any():
        return None
    best = float(typical[returned].min())
    good = returned & (typical <= best + _AS_GOOD * (float(rise.max()) - best))
    # the first good trial may look into the valley from the edge of its band: take the deepest one of the same valley
    first = trials[int(np.argmax(good))].lag
    valley = [k for k in range(len(trials)) if good[k] and abs(trials[k].lag / first - 1) < 0.15]
    return trials[min(valley, key=lambda k: float(typical[k]))]
