"""From one state of the motion graph to another."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.synthesis import ways
from kinesics.synthesis.goals.arguments import check_name, check_weight
from kinesics.synthesis.goals.naming import states_of
from kinesics.synthesis.goals.pursuit import Pursuit, Situation
from kinesics.synthesis.prospects import Prospects

if TYPE_CHECKING:
    from kinesics.synthesis.network import Network

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StateToState:
    """Go from one state of the motion graph to another by the shortest way; what comes after is chosen freely.

    Parameters
    ----------
    begin : state in which the performance begins (underway: to which it goes first).
    end : state in which the way ends.
    by : "seconds", every transition counting as `kinesics.synthesis.ways.JUMP` seconds and more, so that what was recorded is
        travelled where it does not take much longer; or "cost" of the transitions (then seconds).
    """

    begin: str
    end: str
    by: str = "seconds"
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the names and the measure."""
        for name in (self.begin, self.end):
            check_name(name, "a state")
        if self.by not in ways.MEASURES:
            raise InputError(f"Expected `by` to be one of {', '.join(ways.MEASURES)}, got {self.by!r}.")
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _ByGraph(network, prospects, self)


class _ByGraph(Pursuit):
    def __init__(self, network: Network, prospects: Prospects, goal: StateToState) -> None:
        begin, end = states_of(network, goal.begin, "from"), states_of(network, goal.end, "to")
        self._network, self._goal = network, goal
        self._begin = begin
        self._way = ways.shortest(network, begin, end, by=goal.by)
        if self._way is None:
            raise InputError(f"No way leads from state {goal.begin} to state {goal.end}.")
        self._planned = False
        self._left = 0
        self._seconds = 0.0

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        return np.zeros(rows.stop - rows.start)

    def plan(self, now: Situation) -> list[int] | None:
        if self._planned:
            return None
        self._planned = True
        assert self._way is not None
        plan = list(self._way)
        if now.path >= 0:
            origins = np.zeros(len(self._begin), dtype=np.bool_)
            origins[now.path] = True
            target = np.zeros_like(origins)
            target[plan[0]] = True
            there = ways.shortest(self._network, origins, target, by=self._goal.by)
            assert there is not None
            plan = there[1:] + plan[1:] if len(there) > 1 else plan[1:]
        self._left = len(plan)
        self._seconds = float(np.asarray(self._network.duration)[plan].sum())
        return plan

    def note(self, now: Situation) -> None:
        if self._planned:
            self._left -= 1

    def done(self, now: Situation) -> bool:
        return self._planned and self._left <= 0

    def outcome(self) -> str:
        assert self._way is not None
        begin, end = self._goal.begin, self._goal.end
        if not self._planned:
            return f"never set out from {begin} to {end}"
        if self._left > 0:
            # rounded up: whoever gives as many is there
            needed = math.ceil(100.0 * self._seconds - 1e-6) / 100.0
            return f"did not come from {begin} to {end}, to which the quickest way takes {needed:.2f} s"
        seconds = float(np.asarray(self._network.duration)[self._way].sum())
        count = len(self._way)
        return f"{begin} to {end} in {count} {'path' if count == 1 else 'paths'}, {seconds:.2f} s"
