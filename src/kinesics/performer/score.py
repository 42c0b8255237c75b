"""A score: what is to be performed, as functions of continuous time, and what is thereby true.

Frames come last (`kinesics.performer.stage`), so that a movement is the same at every frame rate.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.performer.truth import Range, Truth

Array = NDArray[np.float64]
TimeFunction = Callable[[Array], Array]

TEMPO_STREAM, NOISE_STREAM, CHOICE_STREAM, GRAPH_STREAM = range(4)
"""Each use of chance has its own stream, so that asking for noise does not change the tempo."""


def generator(seed: int, stream: int) -> np.random.Generator:
    """The random numbers of one use of chance.

    Raises
    ------
    InputError
        If the seed is not a whole number ≥ 0.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"Expected `seed` to be a whole number, 0 or greater, got {seed!r}.")
    return np.random.default_rng([int(seed), stream])


@dataclass(frozen=True)
class Shutter:
    """Where moments fall among the frames: frame k is taken at k / fps seconds."""

    fps: float
    frame_count: int

    def frame(self, seconds: float) -> int:
        """The first frame at or after a moment, within [0, frame_count]."""
        # the tolerance keeps a moment that should fall on a frame from being pushed to the next by rounding
        return int(np.clip(np.ceil(seconds * self.fps - 1e-6), 0, self.frame_count))

    def nearest(self, seconds: float) -> int | None:
        """The frame nearest to a moment; None where the recording does not reach it."""
        frame = int(np.floor(seconds * self.fps + 0.5))
        return frame if 0 <= frame < self.frame_count else None

    def range(self, start: float, end: float) -> Range:
        """The frames of [start, end) seconds."""
        return Range(self.frame(start), self.frame(end))


def zero(times: Array) -> Array:
    """Nothing at any time."""
    return np.zeros(len(times))


@dataclass(frozen=True)
class Score:
    """Continuous movement and its truth."""

    movement: str
    seconds: float
    angles: TimeFunction
    """Seconds (n,) to postures (n, angles)."""
    truth: Callable[[Shutter], Truth]
    heading: TimeFunction = zero
    """Seconds to turns about +y of the whole body, radians, beside what the route asks."""
    lift: TimeFunction = zero
    """Seconds to metres between the ground and the lowest point of the body."""
    travels: bool = False
    """Whether it goes over the floor and so can follow a route."""
    detrend: bool = False
    """Whether it stays in place however the feet push."""
    blend: float = 0.0
    """Seconds over which the weight passes from one support to the next. A foot that comes down while the leg swings would
    otherwise throw the whole body forward; so it slides a little instead, as one that steps or stamps does."""


def check_number(name: str, value: float, low: float, high: float, *, unit: str = "") -> float:
    """A finite number within [low, high].

    Raises
    ------
    InputError
        With the name, the range and what came.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = float("nan")
    if not (np.isfinite(number) and low <= number <= high):
        suffix = f" {unit}" if unit else ""
        raise InputError(f"Expected `{name}` between {low:g} and {high:g}{suffix}, got {value!r}.")
    return number
