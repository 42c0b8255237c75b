"""The sum of squares of `kinesics.synthesis.embodiment.footing`, term by term."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.embodiment import footing
from kinesics.synthesis.embodiment.footing import Bounds, Leg, Usual

Array = NDArray[np.float64]


def sum_of_squares(
    feet: Array,
    body: Array,
    slid: Array,
    grip: Array,
    height: Array,
    press: Array,
    leg: Leg,
    usual: Usual,
    fps: float,
    bounds: Bounds,
    both: Array,
) -> float:
    """Of what is added to feet (frames, 2, 3) and body (frames, 3)."""
    total = 0.0
    frames = len(body)
    for t in range(frames):
        for k in (0, 1):
            total += (press[t, k] * (feet[t, k, 1] + height[t, k]) / footing.HEIGHT) ** 2
            apart = feet[t, k] - body[t]
            total += float(apart @ apart) / footing.ASTRAY**2
            if bounds.way[t, k].any():
                total += ((float(bounds.way[t, k] @ apart) - bounds.least[t, k]) / footing.BOUND) ** 2
            if t > 0:
                slips = (feet[t, k] - feet[t - 1, k])[[0, 2]] + slid[t - 1, k]
                total += (grip[t - 1, k] * fps / footing.SLIP) ** 2 * float(slips @ slips)
        total += (body[t, 1] / footing.SINKING) ** 2
        for axis in (0, 2):
            total += (1.0 - both[t]) * (body[t, axis] / footing.ADRIFT) ** 2
            total += both[t] * (body[t, axis] / footing._ANYWHERE) ** 2
    for t in range(1, frames - 1):
        bent = [[], [], []]
        for n, s in enumerate((t - 1, t, t + 1)):
            for k in (0, 1):
                apart = feet[s, k] - body[s]
                bent[n].append(leg.knee[s, k] * float(leg.direction[s, k] @ apart) / (footing._SHARE * usual.knees[k]))
                bent[n].extend(apart / (leg.distance[s, k] * footing._SHARE * usual.hips[k]))
                bent[n].extend(feet[s, k] / footing.GENTLE)
            bent[n].extend(body[s] / (footing._SHARE * usual.body))
        before, now, after = (np.array(b) for b in bent)
        total += float(np.sum(((before - 2.0 * now + after) * fps**2) ** 2))
    return total
