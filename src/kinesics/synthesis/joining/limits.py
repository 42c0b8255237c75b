"""How much may differ across a transition: thresholds found in the recordings themselves.

The offset that a blend of a quarter of a second hides may be no larger than what the movement itself covers in that time, the
median over all moments that move, in √(2D), which is a length; nor larger than the median over all pairs of such moments, which
in quick small movement is less; nor smaller than a body at rest sways (`kinesics.analysis.stillness.EPSILON`). Of everything else
that is compared, likewise, what moving moments change within the time of a blend.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.analysis.stillness import EPSILON, JITTERS, sensor_jitter
from kinesics.errors import InputError
from kinesics.similarity import chord, distance
from kinesics.similarity.metric import paired_distance
from kinesics.synthesis.joining.measures import feet_beneath, from_heading, pose_velocity
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

BLEND: Final = 0.25
"""Seconds of a blend, by which the limits are measured."""
WINDOW: Final = 0.2
"""Seconds over which two moments are compared."""
DIRECTION: Final = 0.85
"""Difference of pose velocities that is accepted, as a share of the faster one."""
SLOW: Final = 0.5
"""The same where both are slow, as a share of what the velocity itself changes in the time of a blend (median)."""
CHANGE_QUANTILE: Final = 0.9
"""Quantile of what moving moments change within a blend, the limit of all but poses and their velocities: the quickest tenth sets
no measure for the others."""
FOOT: Final = 0.5
"""Difference between shares of time on the ground about the seam: that of a foot that stands from one that lands or lifts at the
seam itself; from one that swings it differs by twice as much."""
FOOT_SECONDS: Final = 0.14
"""Seconds about the seam within which it is counted: no step is as short."""
PLACE: Final = 0.7
"""Difference between the places of the feet, as a share of what nine tenths of all moments change within a blend."""
BEARING: Final = 0.3
"""The same of a foot that bears all the time about the seam, as a share of that: its leg alone makes up for the difference."""
FOOT_VELOCITY: Final = 0.5
"""Difference between their velocities, likewise."""
_LEAST_PLACE: Final = 0.15
"""Metres, however little the feet move: half a foot's length."""
_MOST_PLACE: Final = 0.2
"""Metres, however far they go in a blend, in runs and leaps: three quarters of a foot's length."""
_LEAST_VELOCITY: Final = 0.1
"""m/s, of root and feet: 2.5 cm over a blend."""
_LEAST_TURN: Final = 0.5
"""rad/s: 7 degrees over a blend, about what the pelvis of a walker turns to and fro in a step."""
_LEAST_HEIGHT: Final = 0.03
"""Metres: about what the pelvis of a walker rises and sinks in a step."""
_SAMPLES: Final = 1024
"""Moments compared all with all for how far pairs of them usually are apart: a million pairs."""


@dataclass(frozen=True)
class Limits:
    """How much may differ across a transition."""

    distance: float
    """Mean D over the window."""
    rule: str
    """How ``distance`` was found."""
    found: float
    """What it is if it is not given, infinite where nothing moves."""
    most: float
    """To what it may be raised where recordings do not hang together else (`synthesis.joining.widening`): what nine tenths of
    the moments that move cover within a blend."""
    pose_velocity: float
    """Of the pose where it is slow, √(2D)/s."""
    velocity: float
    """Of the root over the ground, m/s."""
    turn: float
    """Of the heading, rad/s."""
    height: float
    """Of the root, metres."""
    place: float
    """Of a swinging foot beneath the root, metres; of one that bears `BEARING` of it."""
    foot_velocity: float
    """Of a foot beneath the root, m/s."""


def half_window(fps: float) -> int:
    """Frames to either side of a seam that are compared: `WINDOW` has twice as many."""
    return max(1, round(0.5 * WINDOW * fps))


def span(fps: float) -> int:
    """Frames from the first to the last about a seam, over which its velocities are taken: one fewer than are compared."""
    return 2 * half_window(fps) - 1


def find_limits(repertoire: Repertoire, threshold: float | None, weights: Array) -> Limits:
    """What may differ across a transition between these recordings.

    Parameters
    ----------
    threshold : largest mean D; found if not given.
    weights : of the 15 links in D, shape (15,).

    Raises
    ------
    InputError
        If nothing moves and no threshold is given.
    """
    lag = max(1, round(BLEND * repertoire.fps))
    index = np.arange(repertoire.frame_count)
    recording = repertoire.recording_of(index)
    early = index[:-lag][recording[:-lag] == recording[lag:]] if len(index) > lag else index[:0]
    q = repertoire.poses.quaternions
    covered = chord(paired_distance(q[early], q[early + lag], weights)) if len(early) else np.zeros(0)
    moving = covered > _still(repertoire, weights)
    if not moving.any() and threshold is None:
        raise InputError(
            f"Nothing can be performed: in {_listed(repertoire.names)} the body holds one pose, or moves for less than "
            f"{BLEND:g} s. Give recordings in which it moves; or, to perform stillness, `threshold` (mean D, about "
            f"{0.5 * EPSILON**2:.1g})."
        )
    allowed, rule = np.inf, ""
    if moving.any():
        own = float(np.median(covered[moving]))
        samples = early[moving][np.linspace(0, np.count_nonzero(moving) - 1, _SAMPLES).astype(np.intp)]
        typical = float(np.median(chord(distance(q[samples], q[samples], weights))))
        allowed = 0.5 * max(min(own, typical), EPSILON) ** 2
        why = f"what the movement covers in {BLEND:g} s, median of the moments that move"
        if typical < own:
            why = f"the median of all pairs of moments that move, less than {why}"
        if min(own, typical) < EPSILON:
            why = "as much as a body at rest sways"
        rule = f"√(2D) of {chord(allowed):.3f}: {why}"
    found = allowed
    most = max(found, 0.5 * float(np.quantile(covered[moving], CHANGE_QUANTILE)) ** 2) if moving.any() else found
    if threshold is not None:
        allowed, rule = float(threshold), "given"
    early = early[moving] if moving.any() else early
    roots = repertoire.roots_of(index)
    yaw = np.unwrap(repertoire.yaw_of(index))
    # velocities over a window; those of seams, which lie between its frames, are over one frame less (`span`)
    wide = max(1, round(WINDOW * repertoire.fps))
    ends = repertoire.starts[recording + 1] - 1
    ahead = np.minimum(index + wide, ends)
    seconds = np.maximum(ahead - index, 1) / repertoire.fps
    travel = from_heading(roots[ahead][:, [0, 2]] - roots[:, [0, 2]], yaw) / seconds[:, None]
    turning = (yaw[ahead] - yaw) / seconds
    whole = early[early + lag + wide <= ends[early]]

    feet = feet_beneath(repertoire)[0]
    going = (feet[ahead] - feet) / seconds[:, None, None]
    velocity = pose_velocity(q, q[ahead], weights, seconds)
    bent = np.linalg.norm(velocity[whole + lag] - velocity[whole], axis=1)
    bends = float(np.median(bent)) if len(whole) else 0.0

    def change(values: Array, at: Indices, least: float) -> float:
        if not len(at):
            return least
        apart = values[at + lag] - values[at]
        size = np.linalg.norm(apart, axis=-1) if apart.ndim > 1 else np.abs(apart)
        return max(least, float(np.quantile(size, CHANGE_QUANTILE)))

    return Limits(
        distance=allowed,
        rule=rule,
        found=found,
        most=most,
        pose_velocity=max(SLOW * bends, 0.5 * EPSILON / BLEND),
        velocity=change(travel, whole, _LEAST_VELOCITY),
        turn=change(turning, whole, _LEAST_TURN),
        height=change(roots[:, 1], early, _LEAST_HEIGHT),
        place=float(np.clip(PLACE * change(feet, early, 0.0), _LEAST_PLACE, _MOST_PLACE)),
        foot_velocity=max(_LEAST_VELOCITY, FOOT_VELOCITY * change(going, whole, 0.0)),
    )


def _still(repertoire: Repertoire, weights: Array) -> float:
    """√(2D) within which a body that stands still sways, or the sensor's noise."""
    q = repertoire.poses.quaternions
    return max(EPSILON, JITTERS * max(sensor_jitter(q[s:e], weights) for s, e in itertools.pairwise(repertoire.starts)))


def _listed(names: tuple[str, ...], most: int = 6) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
