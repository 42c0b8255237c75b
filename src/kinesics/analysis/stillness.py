"""Stretches in which the body stays in one neighbourhood of C ([Schultz2012] §3.2.1).

The dissertation: all pairs of moments of such a stretch are within a threshold of each other, "though the model may not
actually be still". That is a bound on the *diameter* of the stretch, not on its speed. Two numbers make it definite, and neither
knows of β, of the picture or of the frame rate:

- **how near**: ε in √(2D), which is about half the r.m.s. angle between the joints. A person who stands still sways by one or
  two degrees in each joint; 5° r.m.s. is ε = 2 sin(5°/4) = .0436. Where the sensor's own jitter is larger, three times the
  jitter is taken.
- **how long**: slow movement also stays within ε for a while, so the measure of time is the recording's own pace v (the speed
  above and below which half of the distance is travelled, measured in steps of ε so that jitter does not count). A swing of
  amplitude a (in √(2D)) stays within ε of its turning point for 2.4 √(a/ε) crossing times ε/v; at a = 1, wider than any human
  swing, that is 12. Stillness lasts longer than that: no smooth reversal is mistaken for it, and a recording played at half
  speed has the same stretches. Where even that would ask for more than 3 s, 3 s are enough: 5° in 3 s is still by any standard.

A stretch must also be a *stay*, not a slow passage: at least four fifths of it lie within ε/3 of its middle (of a uniform
passage, two thirds do). Only what lasts three times as long again, and so drifts at less than a thirty-sixth of the pace, needs
no such proof: a body that settles is still.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.pose import PoseSequence
from kinesics.geometry import quaternion
from kinesics.similarity import check_weights, chord, distance
from kinesics.similarity._inputs import Weights
from kinesics.similarity.metric import paired_distance

Array = NDArray[np.float64]

SWAY_DEGREES: Final = 5.0
EPSILON: Final = float(2.0 * np.sin(np.deg2rad(SWAY_DEGREES) / 4.0))
JITTERS: Final = 3.0
CROSSINGS: Final = 12.0
LONGEST_WAIT_S: Final = 3.0
STAY_SHARE: Final = 0.8
SURE: Final = 3.0
"""A stretch this many times the least duration (or `LONGEST_WAIT_S`) is a stay without further proof."""
_STAY_RADIUS: Final = 1.0 / 3.0
_BLOCK: Final = 2048
"""Most moments compared all with all; a longer stretch is sampled evenly to this many."""


@dataclass(frozen=True)
class StillnessRule:
    """The two numbers, as found for one recording."""

    epsilon: float
    """In √(2D)."""
    minimum_s: float
    """Seconds."""
    jitter: float
    """Of the sensor, in √(2D) from one frame to the next."""
    pace: float | None
    """In √(2D) a second; None where the body never moves by ε."""


def stillness_rule(poses: PoseSequence, weights: Weights | None = None) -> StillnessRule:
    """ε and the least duration for this recording (see the module's text).

    Raises
    ------
    InputError
        If the weights cannot be used.
    """
    share = check_weights(weights)
    jitter = _jitter(poses.quaternions, share)
    epsilon = max(EPSILON, JITTERS * jitter)
    pace = _pace(poses, epsilon, share)
    minimum = LONGEST_WAIT_S if pace is None else min(CROSSINGS * epsilon / pace, LONGEST_WAIT_S)
    return StillnessRule(epsilon, minimum, jitter, pace)


def find_stillness(
    poses: PoseSequence, rule: StillnessRule | None = None, weights: Weights | None = None
) -> list[tuple[int, int]]:
    """Ranges [start, end) in which the body is still, in order, not overlapping.

    Where stretches overlap the longest is taken first. A recording that never moves by ε is still as a whole, however short.

    Parameters
    ----------
    weights : of the 15 links; equal without.
    """
    if len(poses) < 2:
        return []
    share = check_weights(weights)
    rule = rule or stillness_rule(poses, share)
    frames = len(poses)
    # how many steps lie between the first and the last frame of the shortest stretch
    span = max(1, int(np.ceil(rule.minimum_s * poses.fps - 1e-9)))
    span = min(span, frames - 1) if rule.pace is None else span
    if span >= frames:
        return []
    q = poses.quaternions
    # a stretch of `span` steps or more is near at both ends and half-way: one cheap pass leaves few candidates
    near = _apart(q[:-span], q[span:], share) <= rule.epsilon
    half = span // 2
    near &= _apart(q[: frames - span], q[half : frames - span + half], share) <= rule.epsilon
    found: list[tuple[int, int]] = []
    for first, last in _runs(near):
        found.extend(_stretches(q, first, last + span, span, rule.epsilon, share))
    sure = min(SURE * rule.minimum_s, LONGEST_WAIT_S) * poses.fps
    return [
        (start, end)
        for start, end in _without_overlap(found)
        if end - start > min(sure, frames - 1) or _is_stay(q[start:end], rule.epsilon, share)
    ]


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


def _is_stay(q: Array, epsilon: float, weights: Array) -> bool:
    middle = q[len(q) // 2]
    inside = _apart(q, middle[None], weights) <= _STAY_RADIUS * epsilon
    return bool(inside.mean() >= STAY_SHARE)


def _jitter(q: Array, weights: Array) -> float:
    """The sensor's noise: how far a pose lies from the middle of its neighbours, in the calmest tenth of the recording.

    Movement bends little within two frames where the body is calm; what is left there is noise, √1.5 times one frame's.
    """
    if len(q) < 3:
        return 0.0
    before, after = q[:-2], q[2:]
    sign = np.where(np.sum(before * after, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    middle = quaternion.normalize(before + sign * after)
    return float(np.quantile(_apart(q[1:-1], middle, weights), 0.1) / np.sqrt(1.5))


def _pace(poses: PoseSequence, epsilon: float, weights: Array) -> float | None:
    """The speed above and below which half of the distance is travelled, in steps of at least epsilon."""
    q = poses.quaternions
    lengths: list[float] = []
    durations: list[int] = []
    here = 0
    while here < len(q) - 1:
        ahead = 16
        while True:
            distances = _apart(q[here + 1 : here + 1 + ahead], q[here : here + 1], weights)
            beyond = distances > epsilon
            if beyond.any() or here + 1 + ahead >= len(q):
                break
            ahead *= 4
        if not beyond.any():
            break
        step = int(np.argmax(beyond))
        lengths.append(float(distances[step]))
        durations.append(step + 1)
        here += step + 1
    if not lengths:
        return None
    distance = np.array(lengths)
    speed = distance / np.array(durations) * poses.fps
    order = np.argsort(speed)
    travelled = np.cumsum(distance[order])
    return float(speed[order][np.searchsorted(travelled, 0.5 * travelled[-1])])


def _apart(a: Array, b: Array, weights: Array) -> Array:
    """√(2D) between frame k of both; one frame of ``b`` is compared with every frame of ``a``."""
    return chord(paired_distance(a, np.broadcast_to(b, a.shape), weights))


def _runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Ranges [start, end) where the mask is true."""
    edges = np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8))
    return list(zip(np.flatnonzero(edges > 0).tolist(), np.flatnonzero(edges < 0).tolist(), strict=True))
