"""What a performer may wish for: a place, a line on the floor, a speed, a class of movement, nothing seen before (§4.4.1).

The Markov weight of [Schultz2012] §4.4.1 is E(j) = exp(−β Σₖ wₖ [fₖ(αⱼ) − fₖ(t)]²): each feature fₖ says something of a path
and something that is wished now. So that β means the same whatever the features' units, every difference is divided by the
feature's spread (standard deviation) over all that may be chosen: β = 1 makes a path one spread from the wish e times rarer
than one right on it.

A feature of your own needs two methods, `Feature`. The goals here know composites too (`kinesics.synthesis.prospects`): places
along a trail, turned from the performer's heading into the world ([Schultz2012] §4.4.1 with the correction that the
displacement turns with the performer, and that a far target counts as one within reach in the same direction). For a target
that stands still, f is metres from it where it is met and metres that could have been walked towards it meanwhile, on the quickest
way that the recordings allow (`kinesics.synthesis.togo`): so none is walked round for ever.

- to a place: `Target`, several `Targets`, a `MovingTarget`
- along a line: `Route`
- how: `Heading`, `Speed`, `Favour`, `Novelty`, `Economy`
- from state to state: `StateToState`
"""

from __future__ import annotations

import difflib
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.synthesis import ways
from kinesics.synthesis.prospects import Prospects, Trail
from kinesics.synthesis.togo import LEAST_RADIUS

if TYPE_CHECKING:
    from kinesics.synthesis.network import Network

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]
Complexes = NDArray[np.complexfloating]

RADIUS: Final = 0.5
"""Metres from a target that count as there."""
STEP: Final = 0.05
"""Metres between the points of a route as it is kept."""
FAR: Final = 10_000.0
"""Metres; no target lies beyond."""
HASTE: Final = 0.3
"""How much a metre late weighs beside a metre aside, when a target is within reach."""
BENDS: Final = 9
"""Ways of bending what is decided for that are compared, where the target lies beyond it."""
LATE: Final = 0.5
"""How much a metre that could have been walked meanwhile weighs beside a metre from the target, where it is met."""
FACING: Final = 1.5
"""How much turning towards a target weighs, beside the metres walked while turning so far."""
ALONG: Final = 0.3
"""How much facing along a route at the end of what is looked ahead to weighs, beside the metres walked while turning so far."""
SOON: Final = 4.0
"""A property of a path counts e times less for every such part of the lookahead that the path comes later."""
FORGET: Final = 30.0
"""Seconds after which a path that was played counts e times less as known."""


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


# --- to a place


@dataclass(frozen=True)
class Target:
    """Go to a place on the floor.

    Parameters
    ----------
    position : x, z in metres, in the world in which the performer starts.
    radius : how near counts as there, metres.
    """

    position: tuple[float, float]
    radius: float = RADIUS
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the place."""
        object.__setattr__(self, "position", _place_of(self.position, "target"))
        _positive(self.radius, "radius")
        _weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return ToPlaces(prospects, [_complex(self.position)], self.radius, self.weight)


@dataclass(frozen=True)
class Targets:
    """Go to several places one after the other: positions of shape (n, 2), x and z in metres."""

    positions: Sequence[tuple[float, float]]
    radius: float = RADIUS
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the places."""
        if not len(self.positions):
            raise InputError("Expected at least one target in `positions`, got none.")
        places = tuple(_place_of(p, f"target {k + 1}") for k, p in enumerate(self.positions))
        object.__setattr__(self, "positions", places)
        _positive(self.radius, "radius")
        _weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return ToPlaces(prospects, [_complex(p) for p in self.positions], self.radius, self.weight)


@dataclass(frozen=True, eq=False)
class MovingTarget:
    """Follow something that moves.

    Parameters
    ----------
    position : a function of the time in seconds, which gives x, z in metres (it is asked for the near future too; one that
        cannot know may give the present place), or positions of shape (n, 2), ``fps`` of them a second, the last of which
        holds on.
    """

    position: Callable[[float], tuple[float, float]] | ArrayLike
    fps: float | None = None
    radius: float = RADIUS
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the track."""
        if not callable(self.position):
            track = _line(self.position, "positions of the moving target", 1)
            if self.fps is None:
                raise InputError("Positions of a moving target need `fps`, how many of them there are a second.")
            _positive(self.fps, "fps")
            object.__setattr__(self, "position", track)
        _positive(self.radius, "radius")
        _weight(self.weight)

    def at(self, time: float) -> complex:
        """Where it is at a time."""
        if callable(self.position):
            return _complex(_place_of(self.position(time), f"moving target at {time:.3f} s"))
        track = np.asarray(self.position)
        assert self.fps is not None
        x, z = track[min(int(max(time, 0.0) * self.fps), len(track) - 1)]
        return complex(z, x)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _AfterIt(prospects, self)


class _Seeking(TrailPursuit):
    """Trails that pass where the wish is: at the right time, or at the end if nothing is looked ahead to."""

    def __init__(self, prospects: Prospects, radius: float, weight: float) -> None:
        super().__init__(prospects)
        self._radius = radius
        self._scale = weight / prospects.spread**2
        self._turning = prospects.turning

    def _wish(self, now: Situation, times: Floats) -> complex | NDArray[np.complex128]:
        """Displacement wished for, in the world; one, or one for each point of the trail."""
        raise NotImplementedError

    def _misses(self, trail: Trail, now: Situation, most: float) -> tuple[Array, Complexes]:
        """Squared metres at every point of the trails, and the gaps before bending."""
        from_heading = np.exp(-1j * now.heading)
        wish = np.atleast_1d(np.asarray(self._wish(now, trail.times[0]) * from_heading))
        far = np.abs(wish)
        if far.max() > self._reach:
            wish = wish * np.minimum(1.0, self._reach / np.maximum(far, 1e-9))
        gap = trail.places - wish.astype(np.complex64)
        miss = gap.real**2 + gap.imag**2
        if most > 0.0:
            bent = gap + _best_bend(gap, trail.swerve, most) * trail.swerve
            miss = bent.real**2 + bent.imag**2
        if self._pace:
            due = np.minimum(far, self._reach) / self._pace
            miss = miss + (HASTE * self._pace * (trail.times - due)) ** 2
            # what is behind one has to be turned to first: as far as one walks meanwhile
            ahead = (wish * np.maximum(1.0, far / self._reach) - trail.places).astype(np.complex64)
            off = np.angle(ahead * np.exp(-1j * trail.headings))
            miss = miss + (FACING * self._turning * off * np.minimum(1.0, np.abs(ahead) / self._reach)) ** 2
        return np.asarray(miss, dtype=np.float64), gap

    def weigh(self, trail: Trail, now: Situation, bend: float) -> Array:
        """See `TrailPursuit`."""
        return np.asarray(self._scale * self._misses(trail, now, bend)[0].min(axis=1), dtype=np.float64)

    def bend(self, trail: Trail, now: Situation, most: float) -> float:
        """See `TrailPursuit`."""
        miss, gap = self._misses(trail, now, most)
        return float(_best_bend(gap, trail.swerve, most)[0, int(np.argmin(miss))])


class ToPlaces(_Seeking):
    """Places one after the other: what `Target` and `Targets` become."""

    def __init__(self, prospects: Prospects, places: list[complex], radius: float, weight: float) -> None:
        super().__init__(prospects, radius, weight)
        self._places = places
        self._next = 0
        self._nearest = np.inf
        self._story: list[str] = []

    @property
    def goal(self) -> complex:
        """The place to go to now, or the last."""
        return self._places[min(self._next, len(self._places) - 1)]

    @property
    def last(self) -> bool:
        """Whether no other target comes after the present one."""
        return self._next >= len(self._places) - 1

    @property
    def radius(self) -> float:
        """How near counts as there, metres."""
        return self._radius

    def prepare(self, bend: float) -> None:
        """See `Pursuit`."""
        if self._pace:
            self._all.to_go(self._radius, bend)

    def weigh(self, trail: Trail, now: Situation, bend: float) -> Array:
        """See `TrailPursuit`: metres from the target when it is met, and metres that could have been walked meanwhile."""
        if not self._pace:
            return super().weigh(trail, now, bend)
        met, onward, _ = self._prices(trail, now, bend, (0.0, -bend, bend) if bend > 0.0 else (0.0,))
        return np.asarray(self._scale * np.minimum(met.min(axis=1), onward.min(axis=0)), dtype=np.float64)

    def bend(self, trail: Trail, now: Situation, most: float) -> float:
        """See `TrailPursuit`."""
        if not self._pace:
            return super().bend(trail, now, most)
        bends = np.linspace(-most, most, BENDS)
        met, onward, at_each = self._prices(trail, now, most, bends)
        k, b = int(np.argmin(met[0])), int(np.argmin(onward[:, 0]))
        return float(at_each[0, k] if met[0, k] <= onward[b, 0] else bends[b])

    def _prices(self, trail: Trail, now: Situation, most: float, bends: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Squared metres that it costs to be there at each point of the trails, infinite where one is not; to go on from
        their ends, for each of the bends; and the bend that leads nearest to each point.
        """
        target = np.complex64((self.goal - now.place) * np.exp(-1j * now.heading))
        straight = max(float(abs(target)) - self._radius, 0.0)
        if straight > self._all.farthest + most * self._all.widest:
            met, bent = _NOWHERE, _NOWHERE
        else:
            gap = trail.places - target
            bent = _best_bend(gap, trail.swerve, most)
            off = gap + bent * trail.swerve
            square = off.real**2 + off.imag**2
            late = LATE * np.maximum(self._pace * trail.times - straight, 0.0)
            met = np.where(square <= max(self._radius, LEAST_RADIUS) ** 2, square + late**2, np.inf)
        bend: Floats = np.asarray(bends, dtype=np.float32)[:, None]
        there = trail.places[:, -1] + bend * trail.swerve[:, -1]
        turned = trail.headings[:, -1] + bend * trail.travelled[:, -1]
        seconds = trail.times[:, -1] + self._all.to_go(self._radius, most).after(
            trail.playing[:, -1], target - there, turned
        )
        late = LATE * np.maximum(self._pace * seconds - straight, 0.0)
        return met, late**2 + (self._radius / 2.0) ** 2, bent

    def _wish(self, now: Situation, times: Floats) -> complex:
        return self.goal - now.place

    def passed(self, places: NDArray[np.complex128], times: Array) -> None:
        """Look along the way that is about to be walked."""
        at = 0
        while self._next < len(self._places) and at < len(places):
            off = np.abs(places[at:] - self.goal)
            self._nearest = min(self._nearest, float(off.min()))
            there = np.flatnonzero(off <= self._radius)
            if not len(there):
                return
            at += int(there[0])
            self._story.append(f"reached {_said(self.goal)} after {times[at]:.1f} s")
            self._next += 1
            self._nearest = np.inf

    def done(self, now: Situation) -> bool:
        """Whether the last was reached."""
        return self._next >= len(self._places)

    def outcome(self) -> str:
        """Which were reached when, and how near the one came that was not."""
        story = list(self._story)
        if self._next < len(self._places):
            near = "never set out" if np.isinf(self._nearest) else f"came within {self._nearest:.2f} m"
            story.append(f"did not reach {_said(self.goal)}: {near}")
        return "; ".join(story)


class _AfterIt(_Seeking):
    def __init__(self, prospects: Prospects, target: MovingTarget) -> None:
        super().__init__(prospects, target.radius, target.weight)
        self._target = target
        self._gaps: list[float] = []

    def _wish(self, now: Situation, times: Floats) -> NDArray[np.complex128]:
        ahead = times.tolist() if self._pace else [0.0]
        return np.array([self._target.at(now.time + t) for t in ahead]) - now.place

    def passed(self, places: NDArray[np.complex128], times: Array) -> None:
        """Look along the way that is about to be walked."""
        if len(places):
            self._gaps.append(abs(complex(places[-1]) - self._target.at(float(times[-1]))))

    def outcome(self) -> str:
        if not self._gaps:
            return "never set out after the moving target"
        near = float(np.mean(np.asarray(self._gaps) <= self._radius))
        return (
            f"followed the moving target at {np.median(self._gaps):.2f} m (median); within {self._radius:g} m "
            f"{100 * near:.0f} % of the time, {min(self._gaps):.2f} m at best"
        )


# --- along a line


@dataclass(frozen=True, eq=False)
class Route:
    """Follow a line drawn on the floor, from its first point to within half a metre of its last.

    Parameters
    ----------
    points : corners of the line, shape (n, 2), x and z in metres, n ≥ 2. It may cross itself.
    haste : how much a metre of progress missed weighs beside a metre off the line.
    """

    points: ArrayLike
    weight: float = 1.0
    haste: float = HASTE

    def __post_init__(self) -> None:
        """Check the line."""
        object.__setattr__(self, "points", _line(self.points, "points of the route", 2))
        if not np.hypot(*np.diff(np.asarray(self.points), axis=0).T).sum() > 0.0:
            raise InputError("The points of the route all lie in one place; give a line, or a Target.")
        _weight(self.weight)

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.hypot(*np.diff(np.asarray(self.points), axis=0).T).sum())

    def sampled(self) -> NDArray[np.complex128]:
        """Points every `STEP` metres, as z + i·x."""
        corners = np.asarray(self.points) @ np.array([1j, 1.0])
        along = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(corners)))])
        at = np.append(np.arange(0.0, along[-1], STEP), along[-1])
        line: NDArray[np.complex128] = np.interp(at, along, corners.real) + 1j * np.interp(at, along, corners.imag)
        return line

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Along(prospects, self)


class _Along(TrailPursuit):
    def __init__(self, prospects: Prospects, route: Route) -> None:
        super().__init__(prospects)
        self._line = route.sampled()
        # where the line leads, smoothed over half a metre
        ends = np.clip(np.arange(len(self._line)) + np.array([[-5], [5]]), 0, len(self._line) - 1)
        self._direction = np.angle(self._line[ends[1]] - self._line[ends[0]])
        self._turning = prospects.turning
        self._scale = route.weight / prospects.spread**2
        self._haste = route.haste
        self._at = 0
        self._off: list[float] = []

    def _index(self, trail: Trail) -> Indices:
        """Points of the line that are as far along it as those of the trails."""
        ahead = np.round(trail.travelled / STEP).astype(np.intp)
        return np.asarray(np.minimum(self._at + ahead, len(self._line) - 1), dtype=np.intp)

    def _gaps(self, trail: Trail, now: Situation) -> NDArray[np.complex64]:
        """From the points of the line to those of each trail as far along."""
        # where the performer is aside of the line, it counts from the nearest point on
        wanted = (self._line[self._index(trail)] - now.place) * np.exp(-1j * now.heading)
        return np.asarray(trail.places - wanted, dtype=np.complex64)

    def weigh(self, trail: Trail, now: Situation, bend: float) -> Array:
        gap = self._gaps(trail, now)
        if bend > 0.0:
            gap = gap + _shared_bend(gap, trail.swerve, bend)[:, None] * trail.swerve
        aside = np.mean(gap.real**2 + gap.imag**2, axis=1)
        # beside the line but facing away from it is a metre aside soon
        turned = self._direction[self._index(trail)[:, -1]] - now.heading - trail.headings[:, -1]
        turned = (turned + np.pi) % (2.0 * np.pi) - np.pi
        aside = aside + (ALONG * self._turning * turned) ** 2
        remaining = (len(self._line) - 1 - self._at) * STEP
        due = self._pace * trail.times[:, -1] if self._pace else self._reach
        late = np.minimum(remaining, due) - np.minimum(trail.travelled[:, -1], remaining)
        return np.asarray(self._scale * (aside + (self._haste * late) ** 2), dtype=np.float64)

    def bend(self, trail: Trail, now: Situation, most: float) -> float:
        return float(_shared_bend(self._gaps(trail, now), trail.swerve, most)[0])

    def passed(self, places: NDArray[np.complex128], times: Array) -> None:
        """Look along the way that is about to be walked: how far along the line it leads, and how far off."""
        back, ahead = round(0.3 / STEP), round(1.0 / STEP)
        for place in places:
            low = max(0, self._at - back)
            off = np.abs(self._line[low : self._at + ahead] - place)
            nearest = int(np.argmin(off))
            self._off.append(float(off[nearest]))
            self._at = low + nearest

    def done(self, now: Situation) -> bool:
        return self._at >= len(self._line) - 1 - round(RADIUS / STEP)

    def outcome(self) -> str:
        length = (len(self._line) - 1) * STEP
        if not self._off:
            return "never set out along the route"
        return (
            f"followed {min(self._at * STEP, length):.1f} m of a route of {length:.1f} m, "
            f"{np.median(self._off):.2f} m aside (median), {max(self._off):.2f} m at most"
        )


# --- how


@dataclass(frozen=True)
class Heading:
    """Face a direction of the world: radians about +y, 0 is +z, π/2 is +x."""

    heading: float
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the number."""
        _finite(self.heading, "heading")
        _weight(self.weight)

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
        if not (np.isfinite(self.speed) and self.speed >= 0.0):
            raise InputError(f"Expected a speed of 0 or more metres a second, got {self.speed}.")
        _weight(self.weight)

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


@dataclass(frozen=True)
class Favour:
    """Favour a class, a label or a state of the grammar, or a recording: "cyclic-antiphase", "ab_1", "A*", "walk".

    A path is the further off the more seconds it takes from its beginning to the nearest path of the kind wished for.
    """

    name: str
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the weight."""
        _weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Longing(network, prospects, paths_of(network, self.name), self.weight)


class _Longing(Pursuit):
    """Seconds to a kind of path: the quickest way is known for every path, so that no composite needs to be asked."""

    def __init__(self, network: Network, prospects: Prospects, kind: Mask, weight: float) -> None:
        togo = ways.seconds_to(network, kind)
        togo = np.where(np.isfinite(togo), togo, ways.UNREACHABLE)
        self._paths = weight * (togo / (float(np.std(togo)) or 1.0)) ** 2
        self._miss = self._paths[prospects.sequence[:, 0]]

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        return float(self._paths[paths[0]])

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        return np.asarray(self._miss[rows], dtype=np.float64)


@dataclass(frozen=True)
class Novelty:
    """Do not repeat yourself: paths lately played cost more. Seconds until a path counts e times less as known: ``forget``."""

    weight: float = 1.0
    forget: float = FORGET

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not self.forget > 0.0:
            raise InputError(f"Expected `forget` in seconds, above 0 (infinite: never), got {self.forget}.")
        _weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Fresh(network, prospects, self)


class _Fresh(Pursuit):
    """Seconds of a composite that were played before, faded by the time since."""

    def __init__(self, network: Network, prospects: Prospects, goal: Novelty) -> None:
        self._duration = np.asarray(network.duration, dtype=np.float64)
        self._lookahead = prospects.lookahead
        self._seconds = _soon(network, prospects)
        self._sequence = prospects.sequence
        self._goal = goal
        # no spread to take it from before anything was played: as if a path in two were known
        self._scale = goal.weight / (float(np.mean(self._seconds.sum(axis=1))) / 2.0) ** 2

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        if not now.plays.any():
            return np.zeros(rows.stop - rows.start)
        known = now.plays * np.exp((now.last_played - now.time) / self._goal.forget)
        seconds = (self._seconds[rows] * np.append(known, 0.0)[self._sequence[rows]]).sum(axis=1)
        return np.asarray(self._scale * seconds**2, dtype=np.float64)

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        played = list(paths)
        known = now.plays[played] * np.exp((now.last_played[played] - now.time) / self._goal.forget)
        return float(self._scale * (known @ _fading(self._duration[played], self._lookahead)) ** 2)


@dataclass(frozen=True)
class Economy:
    """Change from recording to recording seldom and smoothly: the cost of transitions counts."""

    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the weight."""
        _weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Thrifty(network, prospects, self.weight)


class _Thrifty(Pursuit):
    """The cost of all transitions of a composite."""

    def __init__(self, network: Network, prospects: Prospects, weight: float) -> None:
        self._network = network
        self._scale = weight / (float(np.var(prospects.cost)) or 1.0)
        self._miss = self._scale * np.asarray(prospects.cost, dtype=np.float64) ** 2

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        return np.asarray(self._miss[rows], dtype=np.float64)

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        total = 0.0
        for before, after in itertools.pairwise((now.path, *paths)):
            low, high = self._network.indptr[before], self._network.indptr[before + 1]
            total += float(self._network.cost[low:high][self._network.indices[low:high] == after].min())
        return self._scale * total**2


class OwnFeature:
    """A `Feature` of the user's as a goal."""

    def __init__(self, feature: Feature) -> None:
        self.feature = feature
        self.weight = float(feature.weight)
        _weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        name = type(self.feature).__name__
        values = np.asarray(self.feature.values(network), dtype=np.float64)
        values = values[:, None] if values.ndim == 1 else values
        paths = len(network.first)
        if values.ndim != 2 or len(values) != paths or not np.isfinite(values).all():
            raise InputError(
                f"Expected `values` of {name} to give finite numbers of shape ({paths},) or ({paths}, dimensions), one a "
                f"path, got shape {values.shape}{'' if np.isfinite(values).all() else ' with NaN or infinity'}."
            )
        return _Valued(network, prospects, values, self.feature, name)


class _Valued(Pursuit):
    def __init__(self, network: Network, prospects: Prospects, values: Array, feature: Feature, name: str) -> None:
        seconds = _soon(network, prospects)
        self._duration = np.asarray(network.duration, dtype=np.float64)
        self._lookahead, self._of_paths = prospects.lookahead, values
        total = seconds.sum(axis=1)
        self._values = np.stack(
            [(seconds * np.append(v, 0.0)[prospects.sequence]).sum(axis=1) / total for v in values.T], axis=1
        )
        spread = self._values.std(axis=0)
        self._spread = np.where(spread > 0.0, spread, 1.0)
        self._feature, self._name = feature, name

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        off = (self._values[rows] - self._wish(now)) / self._spread
        return np.asarray(self._feature.weight * np.einsum("rd,rd->r", off, off), dtype=np.float64)

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        seconds = _fading(self._duration[list(paths)], self._lookahead)
        off = (seconds @ self._of_paths[list(paths)] / seconds.sum() - self._wish(now)) / self._spread
        return float(self._feature.weight * off @ off)

    def _wish(self, now: Situation) -> Array:
        wish = np.atleast_1d(np.asarray(self._feature.wish(now), dtype=np.float64))
        if wish.shape != self._values.shape[1:] or not np.isfinite(wish).all():
            raise InputError(
                f"Expected `wish` of {self._name} to be {self._values.shape[1]} finite number(s), got {wish.tolist()}."
            )
        return wish


# --- from state to state


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
        """Check the measure."""
        if self.by not in ways.MEASURES:
            raise InputError(f"Expected `by` to be one of {', '.join(ways.MEASURES)}, got {self.by!r}.")

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
        return plan

    def note(self, now: Situation) -> None:
        if self._planned:
            self._left -= 1

    def done(self, now: Situation) -> bool:
        return self._planned and self._left <= 0

    def outcome(self) -> str:
        assert self._way is not None
        seconds = float(np.asarray(self._network.duration)[self._way].sum())
        return f"{self._goal.begin} to {self._goal.end} in {len(self._way)} paths, {seconds:.2f} s"


# --- names of the grammar


def paths_of(network: Network, name: str) -> Mask:
    """Paths that a class, a label, a state (either end) or a recording names: shape (paths,).

    Raises
    ------
    InputError
        If there are none; the message lists what there is.
    """
    found = np.zeros(len(network.first), dtype=np.bool_)
    known: set[str] = set()
    recordings = [network.repertoire.names[k] for k in network.recording.tolist()]
    for words in (network.class_, network.label, network.state_from, network.state_to, recordings):
        if len(words):
            found |= np.asarray(words) == name
            known.update(words)
    if not found.any():
        raise InputError(_unknown("class, label, state or recording", name, known))
    return found


def states_of(network: Network, name: str, end: str) -> Mask:
    """Paths that begin (``end`` = "from") or end ("to") in a state: shape (paths,). Raises InputError if none."""
    words = network.state_from if end == "from" else network.state_to
    found = np.asarray(words) == name if len(words) else np.zeros(0, dtype=np.bool_)
    if not found.any():
        raise InputError(_unknown(f"state for a path to go {end}", name, set(words)))
    return np.asarray(found, dtype=np.bool_)


def _unknown(what: str, name: str, known: set[str]) -> str:
    there = sorted(known - {""})
    if not there:
        return (
            f"No {what} {name!r}: the paths of this network have no names; "
            "`kinesics.synthesis.network.labelled` gives them the grammar's."
        )
    near = difflib.get_close_matches(name, there, n=3, cutoff=0.5)
    listed = ", ".join(there[:30]) + (f" and {len(there) - 30} more" if len(there) > 30 else "")
    return f"No {what} {name!r}." + (f" Did you mean {' or '.join(near)}?" if near else "") + f" There are: {listed}."


# --- small helpers of the goals above

_NOWHERE: Final = np.full((1, 1), np.inf, dtype=np.float32)


def _best_bend(gap: Complexes, swerve: Complexes, most: float) -> NDArray[np.float32]:
    """Bend that brings each point nearest to its wish, clipped: least squares, |gap + bend · swerve|²."""
    if most <= 0.0:
        return np.zeros(gap.shape, dtype=np.float32)
    along = gap.real * swerve.real + gap.imag * swerve.imag
    bend = -along / (swerve.real**2 + swerve.imag**2 + 1e-9)
    return np.asarray(np.minimum(np.maximum(bend, -most), most), dtype=np.float32)


def _shared_bend(gap: Complexes, swerve: Complexes, most: float) -> NDArray[np.float32]:
    """One bend for all points of a trail, by least squares, clipped."""
    along = np.sum(gap.real * swerve.real + gap.imag * swerve.imag, axis=1)
    square = np.sum(swerve.real**2 + swerve.imag**2, axis=1) + 1e-9
    return np.asarray(np.clip(-along / square, -most, most), dtype=np.float32)


def _soon(network: Network, prospects: Prospects) -> Floats:
    """Seconds of each path of each composite, those that come late counting less: shape (rows, longest).

    If they counted alike, what is wished for could be put off from decision to decision.
    """
    seconds = np.append(np.asarray(network.duration, dtype=np.float64), 0.0)[prospects.sequence]
    return np.asarray(_fading(seconds, prospects.lookahead), dtype=np.float32)


def _fading(seconds: Array, lookahead: float) -> Array:
    """Durations of paths one after the other, along the last axis, less the later they come."""
    begins = np.cumsum(seconds, axis=-1) - seconds
    return seconds * np.exp(-SOON * begins / lookahead) if lookahead else seconds


def _complex(position: tuple[float, float]) -> complex:
    return complex(position[1], position[0])


def _said(place: complex) -> str:
    return f"({place.imag:.2f}, {place.real:.2f})"


def _place_of(position: object, name: str) -> tuple[float, float]:
    try:
        values = np.asarray(position, dtype=np.float64)
    except (TypeError, ValueError):
        values = np.zeros(0)
    if values.shape != (2,):
        raise InputError(f"Expected the {name} to be two numbers, x and z in metres, got {position!r}.")
    if not np.isfinite(values).all() or np.abs(values).max() > FAR:
        raise InputError(f"Expected the {name} within {FAR:g} m, in finite numbers x and z, got {position!r}.")
    return float(values[0]), float(values[1])


def _line(points: ArrayLike, name: str, least: int) -> Array:
    try:
        line = np.array(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"Expected {name} of shape (n, 2), x and z in metres, got {type(points).__name__}.") from error
    if line.ndim != 2 or line.shape[1] != 2 or len(line) < least:
        raise InputError(f"Expected {name} of shape (n, 2), x and z in metres, n at least {least}, got {line.shape}.")
    bad = ~np.isfinite(line).all(axis=1) | (np.abs(line).max(axis=1) > FAR)
    if bad.any():
        k = int(np.argmax(bad))
        raise InputError(f"Expected {name} in finite numbers within {FAR:g} m; number {k} is {line[k].tolist()}.")
    line.setflags(write=False)
    return line


def _positive(value: float, name: str) -> None:
    if not (np.isfinite(value) and value > 0.0):
        raise InputError(f"Expected `{name}` above 0, got {value}.")


def _finite(value: float, name: str) -> None:
    if not np.isfinite(value):
        raise InputError(f"Expected `{name}` to be a finite number, got {value}.")


def _weight(value: float) -> None:
    if not (np.isfinite(value) and value >= 0.0):
        raise InputError(f"Expected `weight` of 0 or more, got {value}.")
