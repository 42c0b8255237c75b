"""Fast movements that end abruptly ([Schultz2012] §3.6.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from kinesics.grammar.moments import Moments
from kinesics.grammar.ranges import STILL

STRIKE_S: Final = 0.12
"""A strike loses half of its speed in no more than this. A swing of half a second takes .17 s."""
_STRIKE_SPEED: Final = 2.0
"""A strike is faster than the middling movement of the recording by this factor."""


@dataclass(frozen=True)
class Strike:
    """A fast movement that ends abruptly."""

    moment: int
    """When half of the speed is gone."""
    speed: float
    """√(2D)/Δt at its fastest, 1/s."""


def find_strikes(moments: Moments) -> tuple[Strike, ...]:
    """Fast movements that end abruptly (§3.6.3: the identity signal thins, then a spike stands at right angles to it)."""
    v, fps = np.convolve(np.pad(moments.speed, 1, mode="edge"), (0.25, 0.5, 0.25), "valid"), moments.fps
    moving = v[v > STILL]
    if len(v) < 4 or not len(moving):
        return ()
    enough = _STRIKE_SPEED * float(np.median(moving))
    span = max(1, int(np.floor(STRIKE_S * fps + 1e-9)))
    out: list[Strike] = []
    for k in range(1, len(v) - 1):
        if not (v[k] >= enough and v[k] >= v[k - 1] and v[k] > v[k + 1]):
            continue
        after = np.flatnonzero(v[k + 1 : k + 1 + span] <= 0.5 * v[k])
        if not len(after):
            continue
        hit = Strike(int(k + 1 + after[0]), float(v[k]))
        if out and hit.moment - out[-1].moment <= 2 * span:
            out[-1] = max(out[-1], hit, key=lambda s: s.speed)
        else:
            out.append(hit)
    return tuple(out)
