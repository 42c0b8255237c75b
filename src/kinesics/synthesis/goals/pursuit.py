"""What a goal is, and what it becomes on a network: a pursuit, which is asked at every decision ([Schultz2012] §4.4.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.synthesis.paths.prospects import Prospects
from kinesics.synthesis.paths.trails import Trail

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass
class Situation:
    """Where the performer is and what has been played: what a wish may depend on."""

    time: float = 0.0
    """Seconds since it began."""
    place: complex = 0j
    """z + i·x, metres."""
    heading: float = 0.0
    """Radians about +y, 0 facing +z, positive to the left (towards +x)."""
    path: int = -1
    """The last path played; −1 before the first."""
    since_jump: float = np.inf
    """Seconds since a recording was left."""
    last_played: Array = field(default_factory=lambda: np.zeros(0))
    """When each path was last begun, −inf for never: shape (paths,)."""
    plays: Indices = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    """How often each path was played, shape (paths,)."""

    @property
    def position(self) -> tuple[float, float]:
        """On the ground: x, z in metres."""
        return self.place.imag, self.place.real


@runtime_checkable
class Feature(Protocol):
    """A property of paths and the value wished for now, of the user's own making.

    Of composites the mean over their paths counts, each weighted with its duration and the less the later it comes.
    """

    @property
    def weight(self) -> float:
        """How much it matters beside others; 1 is usual."""
        ...

    def values(self, network: Network) -> ArrayLike:
        """f(α) of every path, shape (paths,) or (paths, dimensions)."""
        ...

    def wish(self, now: Situation) -> ArrayLike:
        """f(t): the value wished for now, one number or (dimensions,)."""
        ...


class Pursuit:
    """A goal being pursued on one network: built by ``goal.pursuit(...)``, asked at every decision."""

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        """Weighted square of how far each composite of ``rows`` is from the wish, in spreads: shape (rows,).

        ``bend`` is the greatest bend of the way in radians a metre that the controller may add (0: none).
        """
        raise NotImplementedError

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        """As `miss`, of a chain of paths that is in no bundle; by pursuits that do not judge by trails."""
        return 0.0

    def prepare(self, bend: float) -> None:
        """Compute what is needed for decisions, ways being bent by ``bend`` radians a metre at most."""

    def passed(self, places: NDArray[np.complex128], times: Array) -> None:
        """Look along the way that is about to be walked: places (z + i·x) frame by frame and their times."""

    def carried(self) -> None:
        """Reckon from here on with feet that take the body a little elsewhere than its way goes."""

    def note(self, now: Situation) -> None:
        """Look at the new situation after a path has been decided for."""

    def plan(self, now: Situation) -> list[int] | None:
        """Paths to be played now without further choice; None to choose."""
        return None

    def done(self, now: Situation) -> bool | None:
        """Whether it has been attained for good; None if it never ends."""
        return None

    def outcome(self) -> str | None:
        """What came of it, in words."""
        return None


class TrailPursuit(Pursuit):
    """A pursuit that judges composites by where they lead."""

    steers = True
    """Whether it can say how the way should be bent."""

    def __init__(self, prospects: Prospects) -> None:
        self._all = prospects
        self._reach = prospects.reach
        self._pace = prospects.reach / prospects.lookahead if prospects.lookahead else 0.0

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        """See `Pursuit`."""
        return self.weigh(self._all.along(rows), now, bend)

    def weigh(self, trail: Trail, now: Situation, bend: float) -> Array:
        """As `miss`, of trails of whatever origin: shape (rows,)."""
        raise NotImplementedError

    def bend(self, trail: Trail, now: Situation, most: float) -> float:
        """The bend, radians a metre in [−most, most], that brings a trail of one row nearest to the wish."""
        return 0.0


class Goal(Protocol):
    """What the controller can pursue."""

    @property
    def weight(self) -> float:
        """How much it matters beside others; 1 is usual."""
        ...

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """Get ready for one network. Raises InputError where it cannot be pursued there."""
        ...


def listed(goal: Goal | Feature | Sequence[Goal | Feature] | None) -> tuple[Any, ...]:
    """Goals one by one, however they were given; whether they are any is for the caller to see."""
    return () if goal is None else tuple(goal) if isinstance(goal, list | tuple) else (goal,)
