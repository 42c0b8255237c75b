"""From one recording into another without a seam: pose and velocity go over smoothly ([Schultz2012] §4.4).

At a cut the pose leaps by an offset and changes its velocity. Neither recording is mixed with the other; instead the
offset is taken away bit by bit (D. Bollo, *Inertialization: High-Performance Animation Transitions in Gears of War*, GDC
2018), by a quintic that starts with the offset and its velocity and ends at rest, so that position, velocity and
acceleration stay continuous.

- `two_sided`: all at once, when what comes is known: the recording left bends towards the cut and the one entered away
  from it, each by a share of the offset (all accelerations are then a quarter of what one side alone would need).
- `one_sided`: live, when a cut is known only as it happens: what is entered bears the whole offset.

Offsets of rotations are logarithms, ``q_entered = q_left · exp(δ)``: they are added on the right, in the frame of the
joint itself, so that each path of a joint's rotation is curved by what it lacks and by nothing else. Velocities are changes
of such logarithms. Where a cut follows while the transition before is not over, its offset leads from what that has made of the
pose (`absorbed`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.geometry import quaternion

Array = NDArray[np.float64]

SHORTEST: Final = 0.1
"""Seconds that a transition takes to either side of the cut, at least."""
LONGEST: Final = 0.4
"""At most: a longer one would show a movement that is neither the one nor the other."""
PEAK: Final = 10.0 / np.sqrt(3.0)
"""Greatest acceleration of the quintic that goes from 1 to 0 in unit time."""
PEAK_OF_VELOCITY: Final = (224.0 + 152.0 * np.sqrt(19.0)) / 225.0
"""Greatest acceleration of the quintic that starts at 0 with unit velocity and ends at rest in unit time, t (1 − t)³ (1 + 3t): that
at t = (8 − √19)/15."""
FARTHEST: Final = 16.0 / 81.0
"""How far that one goes from 0: at t = 1/3."""
SLOWEST: Final = 1.0
"""Seconds to either side that fingers and the like may take."""
CARRIED: Final = 0.1
"""Radians that the leap of its velocity may carry a joint which does not set how long a transition takes."""
_INSTANT: Final = 1e-3
"""Seconds over which it is told how quickly an offset changes that is known at all times."""


def ease(t: Array) -> Array:
    """From 0 at t ≤ 0 to 1 at t ≥ 1 with no velocity and no acceleration at either end: 6t⁵ − 15t⁴ + 10t³."""
    s = np.clip(t, 0.0, 1.0)
    return np.asarray(s * s * s * (s * (6.0 * s - 15.0) + 10.0))


def decay(offset: Array, velocity: Array, times: Array, duration: Array | float) -> Array:
    """The quintic that starts at ``offset`` with ``velocity`` and no acceleration, and is at rest at 0 from ``duration`` on.

    Parameters
    ----------
    offset, velocity : shape (..., n); the velocity per second.
    times : seconds since the start, not negative, broadcast against the leading axes.
    duration : seconds, above 0.

    Returns
    -------
    Array
        Shape of ``times`` broadcast with ``offset``.
    """
    t = np.minimum(times / duration, 1.0)[..., None]
    seconds = np.asarray(duration)[..., None]
    rest = 1.0 - t
    # (1 − t)³ times a parabola whose value and first two derivatives at 0 are those wanted
    cube = rest * rest * rest
    parabola = offset * (1.0 + 3.0 * t + 6.0 * t * t) + velocity * seconds * (t + 3.0 * t * t)
    return np.asarray(cube * parabola)


def one_sided(offset: Array, velocity: Array, times: Array, duration: float) -> Array:
    """What is added to the recording entered, ``times`` (n,) seconds after its first frame: (n, ..., 3).

    Parameters
    ----------
    offset : of what is left from what is entered, at the first frame entered: (..., 3).
    velocity : the same of the velocities, per second.
    """
    at = np.maximum(np.asarray(times, dtype=np.float64), 0.0).reshape(-1, *(1,) * (np.ndim(offset) - 1))
    return decay(offset, velocity, at, duration)


@dataclass(frozen=True)
class Window:
    """How long a transition takes to either side of the cut, and which share of the offset each side bears."""

    before: float
    """Seconds."""
    after: float
    share_before: float
    """0 to 1; the rest is borne after the cut."""


def window(
    offsets: Array, velocities: Array, accelerations: Array, *, before: float = np.inf, after: float = np.inf
) -> Window:
    """How long a transition must take so that it accelerates nothing more than the recordings themselves do.

    Parameters
    ----------
    offsets, velocities : size of each offset (of rotations, radians, or of places, metres) and of the leap of its velocity (per
        second), shape (n,).
    accelerations : what each may be accelerated by, per second², shape (n,): of the 99th percentile of the recordings.
    before, after : seconds that there are to either side of the cut.
    """
    half = float(np.clip(_needed(offsets, velocities, accelerations).max(initial=0.0), SHORTEST, LONGEST))
    first, last = min(half, before), min(half, after)
    # the same acceleration on both sides: the share goes as the square of the time
    weight = first * first + last * last
    return Window(first, last, first * first / weight if weight > 0.0 else 0.5)


def _needed(offsets: Array, velocities: Array, accelerations: Array) -> Array:
    """Seconds that each takes to either side of a cut, so that it is accelerated no more than it may be."""
    # half the offset to either side: ½(d·peak/h² + v·peak_v/h) = a, solved for h
    a = np.maximum(accelerations, 1e-9)
    linear = 0.5 * velocities * PEAK_OF_VELOCITY / a
    square = 0.5 * offsets * PEAK / a
    return np.asarray(0.5 * (linear + np.sqrt(linear * linear + 4.0 * square)))


class Paced(NamedTuple):
    """What `at_their_own_pace` gives."""

    velocities: Array
    """Per second, shape (n, 3)."""
    pace: Array
    """The time that each joint takes, as a multiple of the window's, shape (n,)."""


def at_their_own_pace(
    offsets: Array, velocities: Array, window: Window, loose: NDArray[np.bool_], accelerations: Array
) -> Paced:
    """A transition in which hands, fingers, feet and what else does not set its length go over in a time of their own.

    What leaps by a great velocity is carried far in a long time: a foot that rolls off, 20° at 10 rad/s in .4 s. Such joints take
    as much less time, down to `SHORTEST`; what would carry them farther even so is a glitch of the recording and left out. What
    hardly ever moves and is held otherwise in what is entered, as fingers are, takes as much more, up to `SLOWEST`.

    Parameters
    ----------
    offsets, velocities : that the joints leap by, radians, and per second, shape (n, 3).
    window : of the joints that set the length.
    loose : joints that do not, shape (n,).
    accelerations : what each may be accelerated by, per second², shape (n,); infinite of what is not to take longer.
    """
    speed = np.linalg.norm(velocities, axis=-1)
    longest = max(window.before, window.after, 1e-9)
    carried = 0.5 * FARTHEST * longest * np.maximum(speed, 1e-9)
    wanted = np.clip(_needed(np.linalg.norm(offsets, axis=-1), speed, accelerations), longest, SLOWEST) / longest
    pace = np.where(loose, np.clip(CARRIED / carried, min(SHORTEST / longest, 1.0), np.maximum(wanted, 1.0)), 1.0)
    kept = np.where(loose, np.minimum(CARRIED / (carried * pace), 1.0), 1.0)
    return Paced(velocities * kept[:, None], pace)


def two_sided(offset: Array, velocity: Array, times: Array, window: Window, pace: Array | float = 1.0) -> Array:
    """What is added to the recordings on both sides of a cut, ``times`` (n,) seconds from the first frame entered.

    Negative times lie in the recording left. ``left + two_sided(t < 0)`` and ``entered + two_sided(t ≥ 0)`` meet in value
    and velocity and the added part has no acceleration there.

    Parameters
    ----------
    offset : of what is entered from what is left, at the first frame entered: (..., 3).
    velocity : the same of the velocities, per second.
    pace : the time that each takes, as a multiple of the window's, shape (...).

    Returns
    -------
    Array
        Shape (n, ..., 3).
    """
    t = np.asarray(times, dtype=np.float64)
    at = t.reshape(-1, *(1,) * (np.ndim(offset) - 1))
    s = window.share_before
    out = np.zeros((len(t), *np.shape(offset)))
    early, late = t < 0.0, t >= 0.0
    if window.before > 0.0:
        # the same quintic with time turned round
        out[early] = decay(s * offset, -s * velocity, -at[early], window.before * pace)
    out[late] = decay((s - 1.0) * offset, (s - 1.0) * velocity, at[late], max(window.after, 1e-9) * pace)
    return out


@dataclass(frozen=True, eq=False)
class Passing:
    """What one transition adds to the recordings on both sides of its cut."""

    offset: Array
    """Of rotations and (last) the root's place, shape (n, 3)."""
    paced: Paced
    window: Window

    def at(self, times: Array) -> Array:
        """Seconds from the cut, shape (times,) to (times, n, 3): see `two_sided`."""
        return two_sided(self.offset, self.paced.velocities, times, self.window, self.paced.pace)


def absorbed(offset: Array, velocity: Array, earlier: Passing, since: float) -> tuple[Array, Array]:
    """Offset and velocity of a cut at which an earlier transition is not over yet: what remains of that ends here.

    Rotations do not commute: of two offsets borne at the same time the later one, told from the recordings, does not lead from
    what the earlier one has made of the pose, which would leap at the cut by half the product of the two.

    Parameters
    ----------
    offset, velocity : of what is entered from what is left as it was recorded: rotations and (last) the root's place, shape (n, 3).
    since : seconds from the earlier cut to this one.
    """
    times = np.array([-_INSTANT, 0.0, _INSTANT])
    remains = earlier.at(since + times)
    apart = offset + times[:, None, None] * velocity
    turned = quaternion.from_rotvec(apart[:, :-1])
    apart[:, :-1] = rotation_offset(quaternion.from_rotvec(remains[:, :-1]), turned)
    apart[:, -1] -= remains[:, -1]
    return apart[1], (apart[2] - apart[0]) / (2.0 * _INSTANT)


def rotation_offset(left: Array, entered: Array) -> Array:
    """δ with ``entered = left · exp(δ)``, rotation vectors of at most π, shape (..., 4) to (..., 3)."""
    return quaternion.offset(left, entered)


def add_rotation(q: Array, offset: Array) -> Array:
    """``q · exp(offset)``, shapes (..., 4) and (..., 3)."""
    return quaternion.multiply(q, quaternion.from_rotvec(offset))
