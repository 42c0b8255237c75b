"""To stay with a recording for a while before it is left: who changes at every step looks restless, however smoothly."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.goals.arguments import check_positive, check_weight
from kinesics.synthesis.goals.pursuit import Pursuit, Situation
from kinesics.synthesis.paths.prospects import Prospects

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]

AWHILE: Final = 2.0
"""Seconds: two steps and more, in which one sees what somebody does."""


@dataclass(frozen=True)
class Abiding:
    """Stay with a recording for a while: leaving it sooner costs, the sooner the more.

    Unlike `Economy`, which would rather not leave at all, it does not mind that recordings are left: passages of a few seconds are
    as new as those of half a second.

    Parameters
    ----------
    awhile : seconds from which on leaving costs nothing.
    """

    weight: float = 1.0
    awhile: float = AWHILE

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self.awhile, "awhile")
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Staying(network, prospects, self)


class _Staying(Pursuit):
    """By how much too soon a composite first leaves what is being played."""

    def __init__(self, network: Network, prospects: Prospects, goal: Abiding) -> None:
        # the path with which each one's recording goes on
        self._goes_on = np.full(len(network.first), -1, dtype=np.intp)
        free = np.flatnonzero(np.asarray(network.cost) == 0.0)
        self._goes_on[np.searchsorted(network.indptr, free, side="right") - 1] = network.indices[free]
        self._duration = np.asarray(network.duration, dtype=np.float64)
        self._first_jump = np.asarray(prospects.first_jump, dtype=np.float64)
        self._goal = goal

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        soon = np.maximum(1.0 - (self._first_jump[rows] + now.since_jump) / self._goal.awhile, 0.0)
        return np.asarray(self._goal.weight * soon**2, dtype=np.float64)

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        stayed = now.since_jump
        for before, after in itertools.pairwise((now.path, *paths)):
            if self._goes_on[before] != after:
                return float(self._goal.weight * max(1.0 - stayed / self._goal.awhile, 0.0) ** 2)
            stayed += float(self._duration[after])
        return 0.0
