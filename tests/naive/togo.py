"""A slow, obvious twin of `kinesics.synthesis.paths.togo.ToGo.by`: one trail, one bend, interpolated in its path's table."""

from __future__ import annotations

import cmath
import math

from kinesics.synthesis.paths.togo import BEARINGS, KNOTS


def seconds_by(ahead, trail, row: int, target: complex, bend: float) -> float:
    """Seconds along the trail, and on from its end to the target."""
    there = complex(trail.places[row, -1]) + bend * complex(trail.swerve[row, -1])
    facing = float(trail.headings[row, -1]) + bend * float(trail.travelled[row, -1])
    gap = target - there
    away = abs(gap)
    bearing = (cmath.phase(gap) - facing) % (2.0 * math.pi) / (2.0 * math.pi) * BEARINGS
    table = ahead.seconds[ahead.kind[trail.playing[row, -1]]]
    # knots lie evenly on the logarithm of 1 m + distance
    spacing = math.log1p(KNOTS[1])
    along = min(math.log1p(away) / spacing, len(KNOTS) - 1.001)
    k, b = int(along), min(int(bearing), BEARINGS - 1)
    u, v = along - k, bearing - b
    near = (1.0 - v) * float(table[k, b]) + v * float(table[k, b + 1])
    far = (1.0 - v) * float(table[k + 1, b]) + v * float(table[k + 1, b + 1])
    beyond = max(away - KNOTS[-1], 0.0) / ahead.pace
    return float(trail.times[row if len(trail.times) > 1 else 0, -1]) + (1.0 - u) * near + u * far + beyond
