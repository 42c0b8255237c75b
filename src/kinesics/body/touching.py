"""When feet bear on the ground, told by the places of their soles alone: while they are low and slow.

- low: within `HEIGHT_ON` of the level a point usually bears at, as a share of the stature, and until it is above `HEIGHT_OFF`;
- slow: below ``SPEED_ON · √(g·leg)`` (a Froude number, so that bodies of all sizes and planets are alike) or, in quick
  movement, `SPEED_SHARE` of the foot's own quick speed, and until it is half as fast again;
- gaps shorter than `SHORTEST_GAP` are closed and touches shorter than `SHORTEST_TOUCH` left out.

Speed thresholds for heel and toe are those of Ghoussayni, Stevens, Durham & Ewins 2004 (*Gait & Posture* 20:266), grown
with the speed of going as Bruening & Ridge 2014 (*Gait & Posture* 39:472) found necessary; two thresholds in place of one
because a single one chatters.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body.runs import runs

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

HEIGHT_ON: Final = 0.018
"""Share of the stature: 3 cm of a grown man. A sole is soft, a marker slips, and a floor is never quite level."""
HEIGHT_OFF: Final = 0.030
SPEED_ON: Final = 0.10
"""Times √(g·leg length), which is 2.9 m/s for a grown man: .3 m/s, six times what Ghoussayni et al. take for bare feet."""
SPEED_SHARE: Final = 0.10
"""Of the 95th percentile of the foot's speed: .4 m/s in a walk, .8 m/s in a run."""
SPEED_MOST: Final = 0.30
"""Times √(g·leg length): beyond it a foot slides or flies."""
SPEED_OFF: Final = 1.5
"""Times the speed at which a point begins to bear."""
SHORTEST_GAP: Final = 0.06
"""Seconds. No foot is lifted and set down again in less."""
SHORTEST_TOUCH: Final = 0.06
"""Seconds. A sprinter's foot bears for a tenth of a second."""
_SPAN: Final = 1.0 / 60.0
"""Seconds to either side over which a speed is measured: half a frame at 30 fps, two at 120."""


class Touching(NamedTuple):
    """When feet bear, found from the places of their soles alone."""

    feet: Mask
    """Left and right foot, shape (frames, 2)."""
    points: Mask
    """Heel, ball and tip of each, shape (frames, 2, 3)."""
    levels: Array
    """Height above the floor at which each point bears, metres, shape (2, 3)."""


def touching(places: Array, height: Array, fps: float, stature: float, slow: float) -> Touching:
    """When each point of the soles bears, by the rules at the top of this module.

    Parameters
    ----------
    places : of heel, ball and tip in the world, metres, shape (frames, 2, 3, 3).
    height : of the same above the floor, metres, shape (frames, 2, 3).
    stature : of the body, metres.
    slow : speed below which a point begins to bear, m/s.
    """
    speeds = speeds_of(places.reshape(len(places), 6, 3), fps).reshape(len(places), 2, 3)
    levels = _levels(height, speeds, stature, slow)
    height = height - levels
    on = (height < HEIGHT_ON * stature) & (speeds < slow)
    stay = (height < HEIGHT_OFF * stature) & (speeds < SPEED_OFF * slow)
    points: Mask = hysteresis(on.reshape(-1, 6), stay.reshape(-1, 6)).reshape(-1, 2, 3)
    # over as short an axis as that of the three points NumPy reduces ten times more slowly
    some = points[..., 0] | points[..., 1] | points[..., 2]
    either = _closed(some, round(SHORTEST_GAP * fps))
    either = _opened(either, round(SHORTEST_TOUCH * fps))
    # in a gap that was closed the lowest point bears on; a touch left out bears with nothing
    least = np.minimum(np.minimum(height[..., 0], height[..., 1]), height[..., 2])
    points = np.where(some[..., None], points, height == least[..., None]) & either[..., None]
    return Touching(either, points, levels)


def _levels(height: Array, speeds: Array, stature: float, slow: float) -> Array:
    """Height above the floor at which each point bears, shape (2, 3): its usual low among slow frames, near the floor."""
    out = np.empty((2, 3))
    most = HEIGHT_ON * stature
    for k in (0, 1):
        for n in range(3):
            low = _usual_low(height[:, k, n], speeds[:, k, n] < slow)
            # what never comes near the floor does not bear on it
            out[k, n] = np.clip(low, -most, 0.5 * most)
    return out


def speeds_of(points: Array, fps: float) -> Array:
    """Speed of points (frames, n, 3) over `_SPAN` to either side, m/s, shape (frames, n)."""
    frames = len(points)
    w = max(1, round(_SPAN * fps))
    at = np.arange(frames)
    before, after = np.maximum(at - w, 0), np.minimum(at + w, frames - 1)
    seconds = np.maximum(after - before, 1) / fps
    way = points[after] - points[before]
    if frames >= 3 * w:
        # at either end to second order: a foot that is just being lifted there is not as slow as it was
        first, last = at[:w], at[-w:]
        way[:w] = (4.0 * points[first + w] - 3.0 * points[first] - points[first + 2 * w]) * 0.5
        way[-w:] = (3.0 * points[last] - 4.0 * points[last - w] + points[last - 2 * w]) * 0.5
        seconds[:w] = seconds[-w:] = w / fps
    return np.asarray(np.sqrt(np.einsum("fni,fni->fn", way, way)) / seconds[:, None])


def _usual_low(height: Array, slow: Mask) -> float:
    """The level at which a point comes to rest: the 20th percentile of its height while slow and in its lower half."""
    if not slow.any():
        return float(height.min())
    resting = np.sort(height[slow])
    low, high = sorted_quantile(resting, 0.02), sorted_quantile(resting, 0.98)
    lower = resting[: np.searchsorted(resting, 0.5 * (low + high), side="right")]
    return sorted_quantile(lower, 0.4) if high > low else low


def sorted_quantile(values: Array, share: float) -> float:
    """NumPy's quantile, of values in order: it would sort them, and takes longer to prepare than to compute."""
    place = share * (len(values) - 1)
    at = int(place)
    after = min(at + 1, len(values) - 1)
    return float(values[at] + (place - at) * (values[after] - values[at]))


def hysteresis(on: Mask, stay: Mask) -> Mask:
    """True from where ``on`` is until ``stay`` ends, before and after: stretches of ``stay`` that hold an ``on``.

    All of shape (frames, points).
    """
    out = np.zeros_like(stay)
    for k in range(stay.shape[1]):
        count = np.concatenate([[0], np.cumsum(on[:, k])])
        for a, b in runs(stay[:, k]):
            out[a:b, k] = count[b] > count[a]
    return out


def _closed(mask: Mask, longest: int) -> Mask:
    """Gaps of at most so many frames are filled, save at the ends."""
    out = mask.copy()
    for k in range(mask.shape[1]):
        for a, b in runs(~mask[:, k]):
            if b - a <= longest and a > 0 and b < len(mask):
                out[a:b, k] = True
    return out


def _opened(mask: Mask, shortest: int) -> Mask:
    """Runs of fewer than so many frames are left out, save at the ends, where more may lie beyond."""
    out = mask.copy()
    for k in range(mask.shape[1]):
        for a, b in runs(mask[:, k]):
            if b - a < shortest and a > 0 and b < len(mask):
                out[a:b, k] = False
    return out
