"""To come to a stand: the quickest way from each path to a stance, and where it ends."""

from __future__ import annotations

import cmath
from typing import TYPE_CHECKING

import numpy as np

from kinesics.synthesis.goals import Situation, ToPlaces
from kinesics.synthesis.paths import ways
from kinesics.synthesis.paths.laying import Laying

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network


class Stop:
    """Of one network."""

    def __init__(self, network: Network, laying: Laying) -> None:
        self.still = ways.stances(network)
        self.possible = bool(self.still.any())
        if not self.possible:
            return
        self._network = network
        seconds = ways.seconds_to(network, self.still)
        self._after = ways.next_towards(network, self.still)
        displacement, turn = laying.trails.places[laying.ends], laying.trails.headings[laying.ends]
        place_met, turn_met = network.met
        # where one comes to stand, seen from the beginning of each path: nearest paths first
        self._rest = np.zeros(len(seconds), dtype=np.complex128)
        for path in np.argsort(seconds, kind="stable").tolist():
            if not self.still[path] and self._after[path] >= 0:
                then = self._after[path]
                edge = network.edges(path, then)
                aside = place_met[edge] + np.exp(1j * turn_met[edge]) * self._rest[then]
                self._rest[path] = displacement[path] + np.exp(1j * turn[path]) * aside
        self._seconds = seconds

    def next(self, now: Situation, rng: np.random.Generator) -> int:
        """The successor from which a stance is reached soonest; within the stance one that stays in it, not lately played."""
        if self.still[now.path]:
            may = self._network.successors(now.path)
            may = may[self.still[may]]
            may = may[now.last_played[may] == now.last_played[may].min()]
            return int(may[rng.integers(len(may))])
        return self._soonest(now.path)

    def _soonest(self, path: int) -> int:
        may = self._network.successors(path)
        return int(may[np.argmin(self._seconds[may])])

    def ends_at(self, now: Situation, goal: ToPlaces) -> bool:
        """Whether stopping now ends at the goal."""
        rest = now.place
        if not self.still[now.path]:
            path = self._soonest(now.path)
            edge = self._network.edges(now.path, path)
            place, turn = (complex(values[edge]) for values in self._network.met)
            rest += cmath.exp(1j * now.heading) * (place + cmath.exp(1j * turn) * complex(self._rest[path]))
        return abs(rest - goal.goal) <= goal.radius
