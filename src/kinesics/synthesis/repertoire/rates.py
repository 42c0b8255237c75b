"""Frame rates that can be performed at."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from kinesics.body.motion import Motion
from kinesics.errors import InputError

LEAST_FPS: Final = 8.0
"""Frames a second: one recording goes over into another within a quarter of a second, which has to hold two frames."""

MOST_FPS: Final = 1000.0
"""Frames a second: no body has anything to say between more."""
_WHY_LEAST: Final = (
    "one recording passes into another within a quarter of a second, which has to hold two frames or more"
)


def check_rate(fps: float) -> float:
    """Frames a second that can be performed at. Raises InputError where ``fps`` is none such."""
    rate = float(fps) if isinstance(fps, int | float | np.number) and not isinstance(fps, bool) else math.nan
    if not (math.isfinite(rate) and rate > 0.0):
        raise InputError(f"Expected a frame rate above 0, got `fps` = {fps!r}.")
    if rate < LEAST_FPS:
        raise InputError(
            f"Expected {LEAST_FPS:g} frames a second or more to perform at, got `fps` = {rate:g}: {_WHY_LEAST}."
        )
    if rate > MOST_FPS:
        raise InputError(f"Expected at most {MOST_FPS:g} frames a second to perform at, got `fps` = {rate:g}.")
    return rate


def rate_of(fps: float | None, motions: Sequence[Motion], names: Sequence[str]) -> float:
    """Frames a second of the output."""
    rate = motions[0].fps if fps is None else check_rate(fps)
    if rate > MOST_FPS:
        raise InputError(
            f"{names[0]} has {rate:g} frames a second, more than the {MOST_FPS:g} that are performed at most. Give a lower "
            "rate (`fps`, --fps), or, if the file is wrong about its own, read it with the right one (`kinesics.read(…, fps=…)`)."
        )
    for name, motion in zip(names, motions, strict=True):
        if motion.fps < LEAST_FPS:
            raise InputError(
                f"{name} has {motion.fps:g} frames a second, fewer than the {LEAST_FPS:g} it takes to perform: {_WHY_LEAST}. If "
                "the file is wrong about its rate, read it with the right one (`kinesics.read(…, fps=…)`)."
            )
    return rate
