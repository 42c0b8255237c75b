"""Slow and obvious: the spectrum summed up frequency by frequency, and its outline measured."""

from __future__ import annotations

import math
from collections.abc import Sequence


def sparc(speed: Sequence[float], fps: float) -> float:
    """Spectral arc length with a cut at 10 Hz and 5 %."""
    length = 16 * 2 ** math.ceil(math.log2(len(speed)))
    outline = []
    k = 0
    while k * fps / length <= 10.0 and k <= length // 2:
        a = sum(v * math.cos(2 * math.pi * k * t / length) for t, v in enumerate(speed))
        b = sum(v * math.sin(2 * math.pi * k * t / length) for t, v in enumerate(speed))
        outline.append(math.hypot(a, b))
        k += 1
    outline = [x / outline[0] for x in outline]
    while outline[-1] < 0.05:
        outline.pop()
    steps = len(outline) - 1
    return -sum(math.hypot(1.0 / steps, outline[k + 1] - outline[k]) for k in range(steps))
