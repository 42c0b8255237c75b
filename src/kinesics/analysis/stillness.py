"""Stretches in which the body stays in one neighbourhood of C ([Schultz2012] §3.2.1).

The dissertation: all pairs of moments of such a stretch are within a threshold of each other, "though the model may not
actually be still". That bounds the *diameter* of the stretch, not its speed; but slow movement and the turning point of a swing
also stay near for a while. Two rules make it definite, and none knows of β, of the picture, of the frame rate or of the tempo:

- **near**: all pairs are within ε in √(2D), which is about half the r.m.s. angle between the joints. A person who stands still
  sways by one or two degrees in each joint; 5° r.m.s. is ε = 2 sin(5°/4) = .0436. Where the sensor's own jitter is larger, three
  times the jitter is taken.
- **long**: it lasts more than twice as long as the widest swing of this recording would linger at its turning point. With the
  recording's own pace v (the speed above and below which half of the distance is travelled, in steps of ε, so that neither
  jitter nor stillness counts) and reach a (half the 95th percentile of √(2D) between moments), a swing at that pace stays within
  ε of its turn for √3 (a/ε) arccos(1 − ε/a) times ε/v: four to twelve crossings of ε. So no smooth reversal is mistaken for
  stillness, steady movement is not still however slow it is, and a recording played at half speed has the same stretches.

A recording that never moves by ε is still as a whole.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.pose import PoseSequence
from kinesics.body.runs import runs
from kinesics.geometry import quaternion
from kinesics.similarity import Weights, check_weights, chord, distance
from kinesics.similarity.metric import Frames, paired_distance

Array = NDArray[np.float64]

SWAY_DEGREES: Final = 5.0
EPSILON: Final = float(2.0 * np.sin(np.deg2rad(SWAY_DEGREES) / 4.0))
JITTERS: Final = 3.0
TURNS: Final = 2.0
REACH_QUANTILE: Final = 0.95
_REACH_SAMPLES: Final = 512
_BLOCK: Final = 2048
"""Most moments compared all with all; a longer stretch is sampled evenly to this many."""


@dataclass(frozen=True)
class StillnessRule:
    """The two numbers, as found for one recording."""

    epsilon: float
    """In √(2D)."""
    minimum_s: float
    """Seconds; 0 where the body never moves by ε."""
    jitter: float
    """Of the sensor, in √(2D) from one frame to the next."""
    pace: float | None
    """In √(2D) a second; None where the body never moves by ε."""
    reach: float
    """Half of how far apart moments are, in √(2D)."""


def stillness_rule(poses: PoseSequence, weights: Weights | None = None) -> StillnessRule:
    """ε and the least duration for this recording (see the module's text).

    Raises
    ------
    InputError
        If the weights cannot be used.
    """
    share = check_weights(weights)
    jitter = sensor_jitter(poses.quaternions, share)
    epsilon = max(EPSILON, JITTERS * jitter)
    pace = _pace(poses, epsilon, share)
    reach = _reach(poses.quaternions, share)
    minimum = 0.0 if pace is None else TURNS * _turn(epsilon, reach) / pace
    return StillnessRule(epsilon, minimum, jitter, pace, reach)


def find_stillness(
    poses: PoseSequence, rule: StillnessRule | None = None, weights: Weights | None = None
) -> list[tuple[int, int]]:
    """Ranges [start, end) in which the body is still, in order, not overlapping.

    Where stretches overlap the longest is taken first.

    Parameters
    ----------
    weights : of the 15 links; equal without.
    """
    if len(poses) < 2:
        return []
    share = check_weights(weights)
    rule = rule or stillness_rule(poses, share)
    frames = len(poses)
    if rule.pace is None:
        return [(0, frames)]
    # how many steps lie between the first and the last frame of the shortest stretch
    span = max(2, int(np.ceil(rule.minimum_s * poses.fps - 1e-9)))
    if span >= frames:
        return []
    q = poses.quaternions
    # a stretch of `span` steps or more is near at both ends and half-way: one cheap pass leaves few candidates
    near = _apart(q[:-span], q[span:], share) <= rule.epsilon
    half = span // 2
    near &= _apart(q[: frames - span], q[half : frames - span + half], share) <= rule.epsilon
    found: list[tuple[int, int]] = []
    for first, last in runs(near):
        found.extend(_stretches(q, first, last + span, span, rule.epsilon, share))
    return _without_overlap(found)


def sensor_jitter(q: Array, weights: Array) -> float:
    """The sensor's noise in √(2D): how far a pose lies from the middle of its neighbours, in the calmest tenth of a recording.

    Movement bends little within two frames where the body is calm; what is left there is noise, √1.5 times one frame's.

    Parameters
    ----------
    q : poses, shape (frames, 15, 4).
    weights : of the 15 links, as `kinesics.similarity.check_weights` returns them.
    """
    if len(q) < 3:
        return 0.0
    before, after = q[:-2], q[2:]
    sign = np.where(np.sum(before * after, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    middle = quaternion.normalize(before + sign * after)
    return float(np.quantile(_apart(q[1:-1], middle, weights), 0.1) / np.sqrt(1.5))


def _stretches(q: Array, start: int, end: int, span: int, epsilon: float, weights: Array) -> list[tuple[int, int]]:
    """Maximal ranges within [start, end) whose moments are all within epsilon of each other, longer than ``span``."""
    step = -(-(end - start) // _BLOCK)
    index = np.arange(start, end, step)
    distances = chord(distance(q[index], q[index], weights))
    n = len(index)
    rows = np.arange(n)
    far = (distances > epsilon) & (rows[:, None] < rows)
    # the last earlier moment too far from moment j, plus one: j's stretch cannot begin before it
    begin = np.where(far.any(axis=0), n - np.argmax(far[::-1], axis=0), 0)
    begin = np.maximum.accumulate(begin)
    ends = np.flatnonzero(np.append(np.diff(begin) > 0, True))
    ranges = ((int(index[begin[j]]), min(int(index[j]) + step, end)) for j in ends)
    return [(a, b) for a, b in ranges if b - a > span]


def _without_overlap(ranges: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The longest first, then those that touch none of the chosen."""
    chosen: list[tuple[int, int]] = []
    for start, end in sorted(ranges, key=lambda r: (r[0] - r[1], r[0])):
        if all(end <= a or start >= b for a, b in chosen):
            chosen.append((start, end))
    return sorted(chosen)


def _turn(epsilon: float, reach: float) -> float:
    """How long a swing of amplitude ``reach`` stays within epsilon of its turning point, times its pace.

    For a·cos(ωt) that is 2 arccos(1 − ε/a)/ω, and half of the way is travelled faster than v = aω √3/2.
    """
    wide = max(reach, 0.5 * epsilon)
    return float(np.sqrt(3.0) * wide * np.arccos(1.0 - epsilon / wide))


def _reach(q: Array, weights: Array) -> float:
    """Half the 95th percentile of √(2D) over pairs of moments evenly spaced in time."""
    count = min(len(q), _REACH_SAMPLES)
    moments = ((np.arange(count) + 0.5) * len(q) / count).astype(np.intp)
    pairs = chord(distance(q[moments], q[moments], weights))[np.triu_indices(count, 1)]
    return 0.5 * float(np.quantile(pairs, REACH_QUANTILE)) if len(pairs) else 0.0


def _pace(poses: PoseSequence, epsilon: float, weights: Array) -> float | None:
    """The speed above and below which half of the distance is travelled, in steps of epsilon.

    Each step begins where the last one ended and ends at the first moment further than epsilon away. Its speed is that of its
    second half: a stay at its beginning then takes no part, however long it was.
    """
    frames = Frames(poses.quaternions, weights)
    last = len(poses) - 1
    lengths: list[float] = []
    speeds: list[float] = []
    here = 0
    while here < last:
        ahead = 16
        while True:
            end = min(here + ahead, last) + 1
            distances = chord(frames.distance_from(here, here, end))
            beyond = distances > epsilon
            if beyond.any() or end > last:
                break
            ahead *= 4
        if not beyond.any():
            break
        exit_ = int(np.argmax(beyond))
        half = int(np.flatnonzero(distances[:exit_] <= 0.5 * epsilon)[-1])
        lengths.append(float(distances[exit_]))
        speeds.append(float(distances[exit_] - distances[half]) / (exit_ - half) * poses.fps)
        here += exit_
    if not lengths:
        return None
    order = np.argsort(speeds)
    travelled = np.cumsum(np.array(lengths)[order])
    return float(np.array(speeds)[order][np.searchsorted(travelled, 0.5 * travelled[-1])])


def _apart(a: Array, b: Array, weights: Array) -> Array:
    """√(2D) between frame k of both."""
    return chord(paired_distance(a, b, weights))
