"""Where points leap away for some frames and come back: point by point, frame by frame, in plain words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def leaps_away(points: Array, length: int, least: float, as_before: float, all_away: float) -> Array:
    """As `kinesics.body.mending.leaps_away`, whose bounds are given."""
    frames, count, _ = points.shape
    out = np.zeros((frames, count))
    for point in range(count):
        way = points[:, point]
        for begin in range(1, frames - length):
            last, behind = begin - 1, begin + length
            velocity = (way[behind] - way[last]) / (behind - last)
            away = [float(np.linalg.norm(way[k] - (way[last] + (k - last) * velocity))) for k in range(begin, behind)]
            size = max(away)
            if size < least or min(away) < all_away * size:
                continue
            if last > 0 and np.linalg.norm(way[last] - way[last - 1] - velocity) > as_before * size:
                continue
            if behind < frames - 1 and np.linalg.norm(way[behind + 1] - way[behind] - velocity) > as_before * size:
                continue
            out[begin, point] = size
    return out
