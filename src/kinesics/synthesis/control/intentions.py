"""What is intended: the rest of the composite whose beginning was just played, and what may come behind it.

The bundle of the last path need not hold that rest; forgetting it, one would for ever be about to turn round.
"""

from __future__ import annotations

import cmath
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.goals.pursuit import Situation
from kinesics.synthesis.paths.laying import Laying
from kinesics.synthesis.paths.prospects import Prospects
from kinesics.synthesis.paths.trails import Trail

Array = NDArray[np.float64]


class Composite(NamedTuple):
    """Paths to be played one after the other, and where they lead from here, unbent."""

    paths: tuple[int, ...]
    trail: Trail
    """Of one row."""
    miss: float


class Continued(NamedTuple):
    """What was intended, followed by all that may come after it."""

    trail: Trail
    rows: slice | None
    """Of the composites that follow; None where there is no time left for any."""
    lasted: float
    """Seconds that what was intended takes."""
    since_jump: float
    """Seconds since a recording was left, at its end."""


class Intentions:
    """On one network."""

    def __init__(self, laying: Laying, prospects: Prospects) -> None:
        self._laying, self._all = laying, prospects
        self._first: list[int] = prospects.rows.tolist()

    def continued(self, intention: Composite, now: Situation) -> Continued | None:
        """What was intended, followed by all that may come after it; None if nothing of it lies ahead."""
        laying = self._laying
        place, heading, travelled, lasted, since_jump = 0j, 0.0, 0.0, 0.0, now.since_jump
        before = now.path
        for path in intention.paths:
            if laying.goes_on[before] != path:
                since_jump = 0.0
            place, heading = laying.entered(before, path, place, heading)
            place += cmath.exp(1j * heading) * laying.displacement[path]
            heading += laying.turn[path]
            travelled += laying.walked[path]
            lasted += laying.duration[path]
            since_jump += laying.duration[path]
            before = path
        rows = slice(self._first[before], self._first[before + 1])
        then = self._all.along(rows)
        points = int(np.searchsorted(then.times[0], self._all.lookahead - lasted + 1e-4, side="right"))
        head, count = intention.trail, rows.stop - rows.start
        if points == 0:
            return Continued(head, None, lasted, since_jump) if head.places.shape[1] else None
        turn = np.exp(1j * heading)
        swerve = laying.swerve(now.path, intention.paths)
        there = then.places[:, :points]
        trail = Trail(
            np.concatenate([head.times, then.times[:, :points] + np.float32(lasted)], axis=1),
            _beside(head.places, place + turn * there, count),
            _beside(head.headings, heading + then.headings[:, :points], count),
            _beside(head.travelled, travelled + then.travelled[:, :points], count),
            _beside(head.swerve, swerve + turn * (then.swerve[:, :points] + 1j * travelled * there), count),
            _beside(head.playing, then.playing[:, :points], count),
        )
        return Continued(trail, rows, lasted, since_jump)

    def chosen(self, intention: Composite, continued: Continued, best: int, miss: float) -> Composite:
        """What was intended, followed by one of what may come after it."""
        if continued.rows is None:
            return intention._replace(miss=miss)
        paths, lasted = list(intention.paths), continued.lasted
        for path in self._all.sequence[continued.rows.start + best].tolist():
            if path < 0 or lasted >= self._all.lookahead:
                break
            paths.append(path)
            lasted += self._laying.duration[path]
        times, *others = continued.trail
        return Composite(tuple(paths), Trail._make((times, *(values[best : best + 1] for values in others))), miss)

    def after(self, composite: Composite, now: Situation) -> Composite | None:
        """What is left of a composite when its first path has been played."""
        if len(composite.paths) < 2:
            return None
        laying = self._laying
        path, trail = composite.paths[0], composite.trail
        place, heading = laying.entered(now.path, path, 0j, 0.0)
        place += np.exp(1j * heading) * laying.displacement[path]
        heading += laying.turn[path]
        done = int(np.searchsorted(trail.times[0], laying.duration[path] + 1e-4, side="right"))
        walked, back = np.float32(laying.walked[path]), np.complex64(np.exp(-1j * heading))
        places = (trail.places[:, done:] - np.complex64(place)) * back
        # see `continued`, the other way round
        swerve = (trail.swerve[:, done:] - np.complex64(laying.swerve(now.path, (path,)))) * back - 1j * walked * places
        rest = Trail(
            trail.times[:, done:] - np.float32(laying.duration[path]),
            places,
            trail.headings[:, done:] - np.float32(heading),
            np.maximum(trail.travelled[:, done:] - walked, np.float32(0.0)),
            swerve.astype(np.complex64),
            trail.playing[:, done:],
        )
        return composite._replace(paths=composite.paths[1:], trail=rest)


def _beside(head: NDArray[Any], then: NDArray[Any], rows: int) -> NDArray[Any]:
    """The points of one trail before those of many."""
    points = head.shape[1]
    out = np.empty((rows, points + then.shape[1]), dtype=head.dtype)
    out[:, :points], out[:, points:] = head, then
    return out
