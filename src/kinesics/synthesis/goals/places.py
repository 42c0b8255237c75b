"""To a place on the floor, to several one after the other, after something that moves.

For a target that stands still, what is missed is metres from it where it is met and metres that could have been walked
towards it meanwhile, on the quickest way that the recordings allow (`kinesics.synthesis.paths.togo`): so none is walked round for
ever. One that moves is to be met where it will be.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics import compiled
from kinesics.errors import InputError
from kinesics.synthesis.goals.arguments import as_complex, check_positive, check_weight, line_of, place_of
from kinesics.synthesis.goals.pursuit import Pursuit, Situation, TrailPursuit
from kinesics.synthesis.paths.prospects import Prospects
from kinesics.synthesis.paths.togo import LEAST_RADIUS
from kinesics.synthesis.paths.trails import Trail

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Complexes = NDArray[np.complexfloating]

RADIUS: Final = 0.5
"""Metres from a target that count as there."""
HASTE: Final = 0.3
"""How much a metre late weighs beside a metre aside, when a target is within reach."""
BENDS: Final = 9
"""Ways of bending what is decided for that are compared, where the target lies beyond it."""
LATE: Final = 0.5
"""How much a metre that could have been walked meanwhile weighs beside a metre from the target, where it is met."""
ASIDE: Final = 0.1
"""Metres that feet may take a body beside its way, live, by the time it is there; at most half of the radius."""
FACING: Final = 1.5
"""How much turning towards a target weighs, beside the metres walked while turning so far."""
_REMEMBERED: Final = 20_000
"""Paths after something that moves that are told of: an hour of them."""
_FAN: Final = np.linspace(-1.0, 1.0, BENDS)


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
        object.__setattr__(self, "position", place_of(self.position, "target"))
        check_positive(self.radius, "radius")
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return ToPlaces(prospects, [as_complex(self.position)], self.radius, self.weight)


@dataclass(frozen=True)
class Targets:
    """Go to several places one after the other: positions of shape (n, 2), x and z in metres."""

    positions: Sequence[tuple[float, float]]
    radius: float = RADIUS
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the places."""
        try:
            given = list(self.positions)
        except TypeError:
            raise InputError(
                f"Expected `positions` of shape (n, 2), x and z in metres of each target, got {self.positions!r}."
            ) from None
        if not given:
            raise InputError("Expected at least one target in `positions`, got none.")
        places = tuple(place_of(p, f"target {k + 1}") for k, p in enumerate(given))
        object.__setattr__(self, "positions", places)
        check_positive(self.radius, "radius")
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return ToPlaces(prospects, [as_complex(p) for p in self.positions], self.radius, self.weight)


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
            track = line_of(self.position, "positions of the moving target", 1)
            if self.fps is None:
                raise InputError("Positions of a moving target need `fps`, how many of them there are a second.")
            check_positive(self.fps, "fps")
            object.__setattr__(self, "position", track)
        check_positive(self.radius, "radius")
        check_weight(self.weight)

    def at(self, time: float) -> complex:
        """Where it is at a time."""
        if callable(self.position):
            return as_complex(place_of(self.position(time), f"moving target at {time:.3f} s"))
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

    def _wished(self, trail: Trail, now: Situation) -> tuple[NDArray[np.complex128], Array]:
        """What is wished for as seen from here, as far as can be reached; and how far it truly is, metres: shape (1 or points,)."""
        wish = np.atleast_1d(np.asarray(self._wish(now, trail.times[0]) * np.exp(-1j * now.heading)))
        far = np.abs(wish)
        if far.max() > self._reach:
            wish = wish * np.minimum(1.0, self._reach / np.maximum(far, 1e-9))
        return wish, far

    def _misses(self, trail: Trail, wish: NDArray[np.complex128], far: Array, most: float) -> Array:
        """Squared metres at every point of the trails."""
        if compiled.wanted():
            out = np.empty(trail.places.shape)
            compiled.native.sought(
                trail.places.view(np.float32),
                trail.swerve.view(np.float32),
                trail.headings,
                trail.times,
                np.stack([wish.real, wish.imag, far], axis=1),
                most,
                self._reach,
                self._pace,
                HASTE * self._pace,
                FACING * self._turning,
                out,
            )
            return out
        gap = trail.places - wish.astype(np.complex64)
        bent = gap + _best_bend(gap, trail.swerve, most) * trail.swerve
        miss = bent.real**2 + bent.imag**2
        if self._pace:
            due = np.minimum(far, self._reach) / self._pace
            miss = miss + (HASTE * self._pace * (trail.times - due)) ** 2
            # what is behind one has to be turned to first: as far as one walks meanwhile
            ahead = (wish * np.maximum(1.0, far / self._reach) - trail.places).astype(np.complex64)
            off = np.angle(ahead * np.exp(-1j * trail.headings))
            miss = miss + (FACING * self._turning * off * np.minimum(1.0, np.abs(ahead) / self._reach)) ** 2
        return np.asarray(miss, dtype=np.float64)

    def weigh(self, trail: Trail, now: Situation, bend: float) -> Array:
        """See `TrailPursuit`."""
        return np.asarray(
            self._scale * self._misses(trail, *self._wished(trail, now), bend).min(axis=1), dtype=np.float64
        )

    def bend(self, trail: Trail, now: Situation, most: float) -> float:
        """See `TrailPursuit`."""
        wish, far = self._wished(trail, now)
        point = int(np.argmin(self._misses(trail, wish, far, most)))
        gap = trail.places[:1, point] - wish.astype(np.complex64)[min(point, len(wish) - 1)]
        return float(_best_bend(gap, trail.swerve[:1, point], most)[0])


class ToPlaces(_Seeking):
    """Places one after the other: what `Target` and `Targets` become."""

    def __init__(self, prospects: Prospects, places: list[complex], radius: float, weight: float) -> None:
        super().__init__(prospects, radius, weight)
        self._places = places
        self._within = radius
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
        """How near counts as there, metres, on the way that is reckoned with."""
        return self._within

    def carried(self) -> None:
        """See `Pursuit`: what is to be within the radius is aimed at and counted farther inside."""
        self._within = max(self._radius - ASIDE, 0.5 * self._radius)

    def prepare(self, bend: float) -> None:
        """See `Pursuit`."""
        if self._pace:
            self._all.to_go(self._radius, bend), self._all.farthest, self._all.widest

    def weigh(self, trail: Trail, now: Situation, bend: float) -> Array:
        """See `TrailPursuit`: metres from the target when it is met, and metres that could have been walked meanwhile."""
        if not self._pace:
            return super().weigh(trail, now, bend)
        target = self._seen(now)
        onward = self._onward(trail, target, bend, (0.0, -bend, bend) if bend > 0.0 else (0.0,))
        met = self._met(trail, target, bend)
        least = onward.min(axis=0) if met is None else np.minimum(met.min(axis=1), onward.min(axis=0))
        return np.asarray(self._scale * least, dtype=np.float64)

    def bend(self, trail: Trail, now: Situation, most: float) -> float:
        """See `TrailPursuit`."""
        if not self._pace:
            return super().bend(trail, now, most)
        target, bends = self._seen(now), most * _FAN
        met, onward = self._met(trail, target, most), self._onward(trail, target, most, bends)[:, 0]
        b = int(np.argmin(onward))
        if met is None or met.min() > onward[b]:
            return float(bends[b])
        k = int(np.argmin(met[0]))
        return float(_best_bend(trail.places[:1, k] - target, trail.swerve[:1, k], most)[0])

    def _seen(self, now: Situation) -> np.complex64:
        """Where the target lies as seen from here."""
        return np.complex64((self.goal - now.place) * np.exp(-1j * now.heading))

    def _met(self, trail: Trail, target: np.complex64, most: float) -> Array | None:
        """Squared metres that it costs to be there at each point of the trails, infinite where one is not; None: far off."""
        straight = self._straight(target)
        if straight > self._all.farthest + most * self._all.widest:
            return None
        within = max(self._within, LEAST_RADIUS) ** 2
        if compiled.wanted():
            out = np.empty(trail.places.shape)
            compiled.native.met_at(
                trail.places.view(np.float32),
                trail.swerve.view(np.float32),
                trail.times,
                float(target.real),
                float(target.imag),
                most,
                within,
                self._pace,
                straight,
                LATE,
                out,
            )
            return out
        gap = trail.places - target
        off = gap + _best_bend(gap, trail.swerve, most) * trail.swerve
        square = off.real**2 + off.imag**2
        late = LATE * np.maximum(self._pace * trail.times - straight, 0.0)
        return np.asarray(np.where(square <= within, square + late**2, np.inf), dtype=np.float64)

    def _onward(self, trail: Trail, target: np.complex64, most: float, bends: ArrayLike) -> Floats:
        """What it costs to go on from the ends of the trails, for each of the bends: shape (bends, rows)."""
        seconds = self._all.to_go(self._radius, most).by(trail, complex(target), np.asarray(bends, dtype=np.float32))
        late = LATE * np.maximum(self._pace * seconds - self._straight(target), 0.0)
        return np.asarray(late**2 + (self._radius / 2.0) ** 2, dtype=np.float32)

    def _straight(self, target: np.complex64) -> float:
        """Metres to go, straight on."""
        return max(float(abs(target)) - self._radius, 0.0)

    def _wish(self, now: Situation, times: Floats) -> complex:
        return self.goal - now.place

    def passed(self, places: NDArray[np.complex128], times: Array) -> None:
        """Look along the way that is about to be walked."""
        at = 0
        while self._next < len(self._places) and at < len(places):
            off = np.abs(places[at:] - self.goal)
            self._nearest = min(self._nearest, float(off.min()))
            there = np.flatnonzero(off <= self._within)
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
        self._gaps: deque[float] = deque(maxlen=_REMEMBERED)

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


def _best_bend(gap: Complexes, swerve: Complexes, most: float) -> NDArray[np.float32]:
    """Bend that brings each point nearest to its wish, clipped: least squares, |gap + bend · swerve|²."""
    if most <= 0.0:
        return np.zeros(gap.shape, dtype=np.float32)
    along = gap.real * swerve.real + gap.imag * swerve.imag
    bend = -along / (swerve.real**2 + swerve.imag**2 + 1e-9)
    return np.asarray(np.minimum(np.maximum(bend, -most), most), dtype=np.float32)


def _said(place: complex) -> str:
    return f"({place.imag:.2f}, {place.real:.2f})"
