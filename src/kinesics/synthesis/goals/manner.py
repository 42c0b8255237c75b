"""How to go, wherever it leads: facing a direction, at a speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.goals.arguments import check_finite, check_least, check_weight
from kinesics.synthesis.goals.pursuit import Pursuit, Situation, TrailPursuit
from kinesics.synthesis.paths.prospects import Prospects
from kinesics.synthesis.paths.trails import Trail

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Heading:
    """Face a direction of the world: radians about +y, 0 is +z, π/2 is +x."""

    heading: float
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the number."""
        check_finite(self.heading, "heading")
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Facing(prospects, self)


class _Facing(TrailPursuit):
    steers = False

    def __init__(self, prospects: Prospects, goal: Heading) -> None:
        super().__init__(prospects)
        self._wish = goal.heading
        self._scale = goal.weight / (float(np.var(prospects.trail.headings[:, -1])) or 1.0)

    def weigh(self, trail: Trail, now: Situation, bend: float) -> Array:
        # all the way and not only at its end, or turning could wait for ever
        off = trail.headings - (self._wish - now.heading)
        off = (off + np.pi) % (2.0 * np.pi) - np.pi
        return np.asarray(self._scale * np.mean(off**2, axis=1), dtype=np.float64)


@dataclass(frozen=True)
class Speed:
    """Go at a speed, metres a second over the ground."""

    speed: float
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the number."""
        check_least(self.speed, "speed", "metres a second")
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Paced(prospects, self)


class _Paced(TrailPursuit):
    steers = False

    def __init__(self, prospects: Prospects, goal: Speed) -> None:
        super().__init__(prospects)
        self._wish = goal.speed
        self._scale = goal.weight / (float(np.var(self._speed(prospects.trail))) or 1.0)

    def weigh(self, trail: Trail, now: Situation, bend: float) -> Array:
        return np.asarray(self._scale * (self._speed(trail) - self._wish) ** 2, dtype=np.float64)

    @staticmethod
    def _speed(trail: Trail) -> Floats:
        return trail.travelled[:, -1] / trail.times[:, -1]
