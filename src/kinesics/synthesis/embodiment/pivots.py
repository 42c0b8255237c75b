"""The point of its sole that a foot stands on, also while it turns ([Schultz2012] §4.4).

Where a foot rolls, the point under its weight goes from heel to toes, and what is on the floor rests. Where it turns, a point that
went to and fro by a centimetre, as heights tremble, would take the whole foot with it: a turn about one point and back about
another is a step aside. Whoever turns on the spot does so about the heel or about the ball, and one point stays until another
takes over.

So the point is sought whose way over the floor is least, all in all, with what it costs to change it, which is the more the
quicker the foot turns then and nothing where it rolls or stands: exactly, by dynamic programming (Viterbi 1967), among points
half a centimetre apart along the sole. What is higher than the lowest by more than a sole gives way does not bear; and heel and
ball, which bear most of the weight, are rather turned on than what lies beside them.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled

Array = NDArray[np.float64]

APART: Final = 0.005
"""Metres along the sole between points that are looked at."""
MEANWHILE: Final = 0.1
"""Seconds before and after a change of the point: the more the foot turns in them the more it costs."""
FARTHEST: Final = 0.04
"""Metres: a point farther from the one before costs no more, so that heel gives way to ball at once rather than bit by bit."""
CHANGE: Final = 0.5
"""Metres that a change costs for each radian and metre: the point between the two goes so far meanwhile."""
GIVES: Final = 0.008
"""Metres that a point may be above the lowest and yet bear."""
RISE: Final = 0.02
"""Metres above that at which a point counts as going as far as the farthest of the sole."""
PAD: Final = 0.03
"""Metres around heel and ball from which a turn is drawn to them: so far do they bear."""
DRAWN: Final = 0.5
"""Metres that it costs for each radian turned and metre beside them."""
ROLLS: Final = 0.02
"""Seconds, of a Gaussian over which one point gives way to another."""
NEAR: Final = (0.01, 0.04)
"""Metres above where it bears at which a sole's turning begins to count for less, and no longer counts."""


def stood_on(points: Array, height: Array, fps: float) -> Array:
    """The point that a foot stands on from each frame to the next, shape (frames − 1, 3): its parts of heel, ball and tip, sum 1.

    That of `cheapest`, but that one gives way to another within `ROLLS` rather than in a frame, in which the ankle of a foot that
    spins would be thrown.

    Parameters
    ----------
    points : heel, ball and tip in the world, metres, shape (frames, 3, 3).
    height : of the same above where each usually bears, metres, shape (frames, 3).
    """
    from scipy.ndimage import gaussian_filter1d

    found = cheapest(points, height, fps)
    return np.asarray(gaussian_filter1d(found, ROLLS * fps, axis=0, mode="nearest")) if len(found) else found


def cheapest(points: Array, height: Array, fps: float) -> Array:
    """The point of a sole that goes least over the floor, all costs counted, shape (frames − 1, 3); as `stood_on`."""
    if len(points) < 2:
        return np.empty((0, 3))
    turn = _turning(points, height)
    change = CHANGE * _meanwhile(turn, fps)
    parts, apart = _along(points)
    at = np.arange(len(parts))
    beside = np.minimum(apart * np.minimum(at, np.abs(at - parts[:, 1].argmax())), PAD)
    middle = 0.5 * (height[1:] + height[:-1])
    step = points[1:] - points[:-1]
    farthest = np.sqrt(_greatest(_squares(step)))
    if compiled.wanted():
        out = np.empty(len(step), dtype=np.int32)
        compiled.native.stand_on(
            np.ascontiguousarray(step),
            np.ascontiguousarray(middle),
            farthest,
            change,
            DRAWN * turn,
            parts,
            beside,
            apart,
            FARTHEST,
            GIVES,
            RISE,
            out,
        )
        return parts[out]
    way = np.sqrt(np.square(np.einsum("kp,fpi->fki", parts, step[..., [0, 2]])).sum(axis=2))
    above = middle @ parts.T - middle.min(axis=1)[:, None]
    cost = way + farthest[:, None] * np.maximum(above - GIVES, 0.0) / RISE + DRAWN * turn[:, None] * beside
    return parts[_least(cost, change, apart)]


def way_over(points: Array, height: Array, fps: float) -> Array:
    """Where the point that a foot stands on has come to over the floor: x and z from where it began, metres, shape (frames, 2).

    Parameters
    ----------
    points, height : as of `stood_on`.
    """
    return way_of(steps_of(points, height, fps))


def way_of(steps: Array) -> Array:
    """Places that are come to by steps (frames − 1, 2), from the first on, shape (frames, 2)."""
    out = np.zeros((len(steps) + 1, 2))
    np.cumsum(steps, axis=0, out=out[1:])
    return out


def steps_of(points: Array, height: Array, fps: float) -> Array:
    """How far that point goes from each frame to the next, x and z in metres, shape (frames − 1, 2); as `way_over`."""
    return np.asarray(np.einsum("fp,fpi->fi", stood_on(points, height, fps), np.diff(points[..., [0, 2]], axis=0)))


def spreads(way: Array, runs: list[tuple[int, int]]) -> Array:
    """How far apart the places of a way over the floor are at most in each run of frames [start, end), metres, shape (runs,).

    Along eight directions, of which one is that in which they are spread most: 2 % short of it at most, however the way is turned.

    Parameters
    ----------
    way : x and z, metres, shape (frames, 2).
    """
    if compiled.wanted():
        out = np.empty(len(runs))
        starts, stops = np.array(runs, dtype=np.int64).reshape(-1, 2).T.copy()
        compiled.native.spreads(np.ascontiguousarray(way), starts, stops, out)
        return out
    return np.array([_spread(way[a:b]) for a, b in runs])


def _spread(way: Array) -> float:
    x, z = (way - way.mean(axis=0)).T
    along = 0.5 * np.arctan2(2.0 * (x @ z), x @ x - z @ z)
    directions = along + np.arange(8) * np.pi / 8.0
    return float(np.ptp(np.outer(x, np.cos(directions)) + np.outer(z, np.sin(directions)), axis=0).max())


def _least(cost: Array, change: Array, apart: float) -> NDArray[np.intp]:
    """Which point is chosen in each step so that all costs together are least, shape (steps,)."""
    steps, count = cost.shape
    far = np.minimum(apart * np.abs(np.subtract.outer(np.arange(count), np.arange(count))), FARTHEST)
    came = np.empty((steps, count), dtype=np.intp)
    here, total = np.arange(count), cost[0]
    for t in range(1, steps):
        through = total[:, None] + change[t] * far
        best = through.argmin(axis=0)
        # one that does just as well stays
        came[t] = np.where(through[best, here] < total, best, here)
        total = through[came[t], here] + cost[t]
    out = np.empty(steps, dtype=np.intp)
    out[-1] = total.argmin()
    for t in range(steps - 1, 0, -1):
        out[t - 1] = came[t, out[t]]
    return out


def _along(points: Array) -> tuple[Array, float]:
    """Points along a sole as parts of heel, ball and tip, shape (n, 3), and how far apart they are, metres."""
    a, b = np.sqrt(_squares(points[:, 1:] - points[:, :-1])).mean(axis=0).tolist()
    count = max(2, int((a + b) / APART + 0.5) + 1)
    at = np.linspace(0.0, a + b, count)
    return np.stack([np.interp(at, [0.0, a, a + b], unit) for unit in np.eye(3)], axis=1), (a + b) / (count - 1)


def _turning(points: Array, height: Array) -> Array:
    """Radians that a foot turns about the vertical, on the floor, in each step, shape (frames − 1,)."""
    along = points[:, 2] - points[:, 0]
    flat = along[:, 2] + 1j * along[:, 0]
    # the steeper a foot stands the less its turning moves what bears
    level = np.abs(flat) / np.maximum(np.sqrt(_squares(along)), 1e-9)
    turn = np.abs(np.angle(flat[1:] * flat[:-1].conj())) * np.square(np.minimum(level[1:], level[:-1]))
    lowest = 0.5 * -_greatest(-(height[1:] + height[:-1]))
    return np.asarray(turn * np.clip((NEAR[1] - lowest) / (NEAR[1] - NEAR[0]), 0.0, 1.0))


def _meanwhile(turn: Array, fps: float) -> Array:
    """What it turns in twice `MEANWHILE` around the frame before each step, shape (frames − 1,)."""
    so_far = np.concatenate([[0.0], np.cumsum(turn)])
    reach, at = max(1, round(MEANWHILE * fps)), np.arange(len(turn))
    return np.asarray(so_far[np.minimum(at + reach, len(turn))] - so_far[np.maximum(at - reach, 0)])


def _squares(vectors: Array) -> Array:
    """Of the lengths of vectors (..., 3): shape (...)."""
    # over as short an axis NumPy reduces ten times more slowly
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.asarray(x * x + y * y + z * z)


def _greatest(values: Array) -> Array:
    """Of three: shape (..., 3) to (...)."""
    return np.asarray(np.maximum(np.maximum(values[..., 0], values[..., 1]), values[..., 2]))
