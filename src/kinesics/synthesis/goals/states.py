"""From one state of the motion graph to another."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.synthesis.goals.arguments import check_least, check_name, check_positive, check_weight
from kinesics.synthesis.goals.naming import states_of
from kinesics.synthesis.goals.pursuit import Pursuit, Situation
from kinesics.synthesis.paths import ways
from kinesics.synthesis.paths.prospects import Prospects

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

BRIEF: Final = 1.0
"""Seconds of a way, below which it is hardly seen by itself."""
LEAD: Final = 1.5
"""Seconds that are played before and after so brief a way: to see the one state, the way, and the other state."""
LONGEST: Final = 4.0
"""Seconds that it may be at most, where the recordings cannot be entered or left elsewhere."""


@dataclass(frozen=True)
class StateToState:
    """Go from one state of the motion graph to another by the shortest way; what comes after is chosen freely.

    Parameters
    ----------
    begin : state in which the performance begins (underway: to which it goes first).
    end : state in which the way ends.
    by : "seconds", every transition counting as `kinesics.synthesis.paths.ways.JUMP` seconds and more, so that what was recorded is
        travelled where it does not take much longer; or "cost" of the transitions (then seconds).
    lead : seconds for which, where the way takes less than `BRIEF`, what leads to its beginning is played before it and what
        follows its end after it, as recorded; not where one is underway.
    most : seconds that all of it may take: where these are few, less is played before and after.
    """

    begin: str
    end: str
    by: str = "seconds"
    weight: float = 1.0
    lead: float = 0.0
    most: float = math.inf

    def __post_init__(self) -> None:
        """Check the names and the measure."""
        for name in (self.begin, self.end):
            check_name(name, "a state")
        if self.by not in ways.MEASURES:
            raise InputError(f"Expected `by` to be one of {', '.join(ways.MEASURES)}, got {self.by!r}.")
        check_weight(self.weight)
        check_least(self.lead, "lead", "seconds")
        if self.most != math.inf:
            check_positive(self.most, "most")

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _ByGraph(network, prospects, self)


def way_between(
    network: Network, begin: str, end: str, by: str = "seconds", faulty: Mask | None = None
) -> list[int] | None:
    """Paths of the shortest way from one state to another, as `StateToState` goes it; None where there is none.

    Parameters
    ----------
    faulty : the paths in which the recording leaps, where they are known.

    Raises
    ------
    InputError
        If there is no such state.
    """
    origins, target = states_of(network, begin, "from"), states_of(network, end, "to")
    return ways.shortest(network, origins, target, by=by, avoiding=network.leaping if faulty is None else faulty)


class _ByGraph(Pursuit):
    def __init__(self, network: Network, prospects: Prospects, goal: StateToState) -> None:
        self._network, self._goal = network, goal
        self._begin = states_of(network, goal.begin, "from")
        faulty = network.leaping
        self._way = way_between(network, goal.begin, goal.end, goal.by, faulty)
        if self._way is None:
            raise InputError(f"No way leads from state {goal.begin} to state {goal.end}.")
        self._faulty = bool(faulty[self._way].any())
        self._planned = False
        self._left = 0
        self._seconds = 0.0
        self._duration = np.asarray(network.duration, dtype=np.float64)
        self._before: list[int] = []
        self._led = False

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
        self._seconds = float(self._duration[plan].sum())
        room = 0.5 * (self._goal.most - self._seconds)
        lead = min(self._goal.lead, room)
        after: list[int] = []
        if now.path < 0 and self._seconds < BRIEF and lead > 0.0:
            self._before = ways.leading_to(self._network, plan[0], lead, min(room, LONGEST))
            after = ways.following(self._network, plan[-1], lead, min(room, LONGEST))
        self._led = bool(self._before or after)
        self._left = len(self._before) + len(plan)
        return self._before + plan + after

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
        seconds = float(self._duration[self._way].sum())
        count = len(self._way)
        told = f"{begin} to {end} in {count} {'path' if count == 1 else 'paths'}, {seconds:.2f} s"
        if self._led:
            since = float(self._duration[self._before].sum())
            told += f": from {since:.2f} to {since + seconds:.2f} s, between what leads there and what follows"
        if self._faulty:
            told += (
                "; it leads through a fault of the recording, where the body leaps, for no other way is nearly as short"
            )
        return told
