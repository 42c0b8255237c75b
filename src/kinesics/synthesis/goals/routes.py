"""Along a line drawn on the floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.synthesis.goals.arguments import check_least, check_weight, line_of
from kinesics.synthesis.goals.places import HASTE, RADIUS
from kinesics.synthesis.goals.pursuit import Pursuit, Situation, TrailPursuit
from kinesics.synthesis.paths.prospects import Prospects
from kinesics.synthesis.paths.trails import Trail

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Complexes = NDArray[np.complexfloating]

STEP: Final = 0.05
"""Metres between the points of a route as it is kept."""
ALONG: Final = 0.3
"""How much facing along a route at the end of what is looked ahead to weighs, beside the metres walked while turning so far."""


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
        object.__setattr__(self, "points", line_of(self.points, "points of the route", 2))
        if not np.hypot(*np.diff(np.asarray(self.points), axis=0).T).sum() > 0.0:
            raise InputError("The points of the route all lie in one place; give a line, or a Target.")
        check_weight(self.weight)
        check_least(self.haste, "haste")

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


def _shared_bend(gap: Complexes, swerve: Complexes, most: float) -> NDArray[np.float32]:
    """One bend for all points of a trail, by least squares, clipped."""
    along = np.sum(gap.real * swerve.real + gap.imag * swerve.imag, axis=1)
    square = np.sum(swerve.real**2 + swerve.imag**2, axis=1) + 1e-9
    return np.asarray(np.clip(-along / square, -most, most), dtype=np.float32)
