"""The floor: a plane through the places where feet come to rest; it may tilt by a few degrees, for the floors of recordings do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.runs import runs
from kinesics.body.touching import HEIGHT_OFF

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

USUAL_SLOPE: Final = 0.03
"""Metres a metre, one standard deviation: 2°. Floors of recordings tilt by as much."""
_LEVEL_SPREAD: Final = 0.006
"""Share of the stature, one standard deviation, by which places of rest lie off a plane: 1 cm."""
_TILT_BAND: Final = 0.06
"""Share of the stature: what rests 10 cm off the floor is no tilt."""


@dataclass(frozen=True)
class Floor:
    """A plane that the feet bear on: in many recordings it tilts by a degree or three, as the cameras were calibrated."""

    height: float
    """At x = z = 0, metres."""
    slope_x: float = 0.0
    """Rise along +x, metres a metre."""
    slope_z: float = 0.0

    def at(self, points: Array) -> Array:
        """Height of the floor below points (..., 3), metres, shape (...)."""
        return np.asarray(self.height + self.slope_x * points[..., 0] + self.slope_z * points[..., 2])


def plane(points: Array, slow: Mask, fps: float, stature: float) -> Floor:
    """The plane through where points (frames, n, 3) rest, leaving out what rests higher than the floor can tilt.

    One place for each stretch of rest, weighed by its length up to half a second; least squares with a prior on the
    slope, repeated with those places alone that lie near the plane.
    """
    rests, weights = [], []
    for k in range(points.shape[1]):
        for a, b in runs(slow[:, k]):
            # a long stand is one place, a long shuffle is many
            for part in np.array_split(np.arange(a, b), max(1, round((b - a) / fps))):
                rests.append(np.median(points[part, k], axis=0))
                weights.append(min(len(part) / fps, 0.5) / 0.5)
    if not rests:
        return Floor(float(points[..., 1].min()))
    p, w = np.array(rests), np.array(weights)
    order = np.argsort(p[:, 1])
    low = float(p[order[np.searchsorted(np.cumsum(w[order]), 0.2 * w.sum())], 1])
    fit = np.array([low, 0.0, 0.0])
    middle = np.average(p, axis=0, weights=w)
    design = np.stack([np.ones(len(p)), p[:, 0] - middle[0], p[:, 2] - middle[2]], axis=1)
    prior = np.diag([0.0, 1.0, 1.0]) * (_LEVEL_SPREAD * stature / USUAL_SLOPE) ** 2
    band = _TILT_BAND * stature
    for _ in range(8):
        residual = p[:, 1] - design @ fit
        kept = w * (np.abs(residual) < band)
        if not kept.any():
            break
        fit = np.linalg.solve(design.T @ (kept[:, None] * design) + prior, design.T @ (kept * p[:, 1]))
        band = max(0.6 * band, HEIGHT_OFF * stature)
    return Floor(float(fit[0] - fit[1] * middle[0] - fit[2] * middle[2]), float(fit[1]), float(fit[2]))
