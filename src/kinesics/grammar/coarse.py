"""Moments at a coarser rate: what phrases are cut from, and motifs of long recordings are looked for in."""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np

from kinesics.grammar.moments import Moments

RATE: Final = 15.0
"""Moments a second at which recurrences are looked for: a cycle of 0.4 s still has six."""


def thinned(moments: Moments, rate: float) -> tuple[Moments, int]:
    """Every so manieth moment, so that there are about ``rate`` a second; and how manieth."""
    step = max(1, round(moments.fps / rate))
    if step == 1 or moments.count < 2 * step:
        return moments, 1
    speed = moments.speed[::step].copy()
    for k in range(1, step):
        later = moments.speed[k::step]
        speed[: len(later)] += later
    # the last one may stand for fewer than the others
    counts = np.full(len(speed), float(step))
    counts[-1] = moments.count - (len(speed) - 1) * step
    poses, dense = moments.poses, moments.dense
    return (
        dataclasses.replace(
            moments,
            fps=moments.fps / step,
            speed=speed / counts,
            symmetry=moments.symmetry[::step],
            poses=None if poses is None else poses[::step],
            dense=None if dense is None else (dense[0][::step, ::step], dense[1][::step, ::step]),
        ),
        step,
    )
