"""How paths lie on the floor, one behind the other: where each begins, where it ends, which way it goes.

On the floor a place is one complex number, z + i·x, metres: see `kinesics.synthesis.paths.prospects`.
"""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.paths.trails import trails

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]


class Step(NamedTuple):
    """One decision: a path and how its way is bent."""

    path: int
    bend: float
    """Radians a metre, positive to the left."""
    place: complex
    """z + i·x at its first frame, metres."""
    heading: float
    """At its first frame, radians."""
    turned: float
    """Radians that the whole path is bent by: what `kinesics.synthesis.live.renderer` needs beside the path."""


class Laying:
    """Of the paths of one network; numbers one at a time, which decisions ask for again and again, are kept in lists."""

    def __init__(self, network: Network) -> None:
        self.trails = trails(network)
        self.ends = self.trails.start + np.asarray(network.length, dtype=np.intp)
        self.displacement: list[complex] = self.trails.places[self.ends].tolist()
        """Of each path, as seen from its first frame."""
        self.turn: list[float] = self.trails.headings[self.ends].tolist()
        self.walked: list[float] = self.trails.travelled[self.ends].tolist()
        self.duration: list[float] = np.asarray(network.duration, dtype=np.float64).tolist()
        leaps = np.flatnonzero(np.asarray(network.cost) > 0.0)
        owners = np.searchsorted(network.indptr, leaps, side="right") - 1
        place_met, turn_met = network.met
        self._met: dict[tuple[int, int], tuple[complex, float]] = dict(
            zip(
                zip(owners.tolist(), np.asarray(network.indices)[leaps].tolist(), strict=True),
                zip(place_met[leaps].tolist(), turn_met[leaps].tolist(), strict=True),
                strict=True,
            )
        )
        free = np.flatnonzero(np.asarray(network.cost) == 0.0)
        goes_on = np.full(len(network.first), -1, dtype=np.intp)
        goes_on[np.searchsorted(network.indptr, free, side="right") - 1] = network.indices[free]
        self.goes_on: list[int] = goes_on.tolist()
        """The path with which each one's recording goes on, −1 if with none."""

    def entered(self, before: int, path: int, place: complex, heading: float) -> tuple[complex, float]:
        """Place and heading at the first frame of a path, from those with which the path before would have gone on."""
        met = self._met.get((before, path))
        if met is None:
            return place, heading
        return place + cmath.exp(1j * heading) * met[0], heading + met[1]

    def swerve(self, before: int, paths: Sequence[int]) -> complex:
        """How the end of a chain of paths behind another moves if it is bent by 1 radian a metre."""
        swerve, heading, travelled = 0j, 0.0, 0.0
        for path in paths:
            aside, heading = self.entered(before, path, 0j, heading)
            step = cmath.exp(1j * heading) * self.displacement[path]
            swerve += 1j * travelled * aside + 1j * (travelled + self.walked[path] / 2.0) * step
            heading += self.turn[path]
            travelled += self.walked[path]
            before = path
        return swerve

    def way(self, step: Step) -> tuple[NDArray[np.complex128], Array]:
        """Places (z + i·x, metres) and headings (radians) of the frames of a path as played, and the entry into the next:
        shapes (length + 1,).
        """
        part = slice(int(self.trails.start[step.path]), int(self.ends[step.path]) + 1)
        places, headings = self.trails.places[part], self.trails.headings[part]
        if step.bend != 0.0:
            travelled = self.trails.travelled[part]
            strides = np.diff(places) * np.exp(0.5j * step.bend * (travelled[1:] + travelled[:-1]))
            places = np.concatenate([[0.0], np.cumsum(strides)])
            headings = headings + step.bend * travelled
        return step.place + places * np.exp(1j * step.heading), step.heading + headings
