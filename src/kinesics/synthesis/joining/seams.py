"""Seams, the places between two frames, what is known of each, and pairs of seams that one may go over between.

The place between frame a − 1 and frame a is *seam* a. Whoever arrives at a seam may go on behind it, or behind any seam that is
near. Nearness is one of four relations, the dissertation's Klein four-group: the same (D), mirrored (D*), reversed, reversed and
mirrored. A pair of near seams (a, b) under a relation r serves every strand x: from (a, x) to (b, x·r) and from (b, x) to
(a, x·r), x·r the strand in which both are applied. So the transitions of mirrored recordings are the mirrored transitions, and
those of reversed ones the reversed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import ceil
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.similarity import chord
from kinesics.similarity.metric import paired_distance
from kinesics.synthesis.joining.limits import BEARING, DIRECTION, FOOT, FOOT_SECONDS, Limits, half_window, span
from kinesics.synthesis.joining.measures import feet_beneath, from_heading, pose_velocity
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

SAME: Final = 0
MIRROR: Final = 1
REVERSE: Final = 2
"""Relations between seams, which add up (a mirror image backwards is 3); applied to a strand: strand ^ relation."""

POSE: Final = "pose"
STEP: Final = 1.0
"""Seconds that a step lasts at most: so many seams are kept of quiet standing."""
BAND: Final = 0.3
"""Seconds: nearer moments of one recording are near because they are nearly one."""
SEARCH_RATE: Final = 30.0
"""Moments a second that are compared all with all; the pairs found are refined at full rate."""
_CHUNK: Final = 4096


class Pairs(NamedTuple):
    """Pairs of seams under relations, a before b."""

    a: Indices
    b: Indices
    relation: Indices
    distance: Array
    """Mean D over the window."""
    cost: Array
    """Mean of the squares of what differs, each as a share of its limit; infinite where any differs by more."""

    @classmethod
    def near(cls, a: Indices, b: Indices, relation: Indices, distance: Array) -> Pairs:
        """Pairs of which nothing but the distance is known yet."""
        return cls(a, b, relation, distance, np.full(len(a), np.inf))

    @classmethod
    def none(cls) -> Pairs:
        """Not a single one."""
        empty = np.zeros(0, dtype=np.intp)
        return cls.near(empty, empty, empty, np.zeros(0))

    @classmethod
    def joined(cls, parts: list[Pairs]) -> Pairs:
        """All of these."""
        return cls._make(np.concatenate(columns) for columns in zip(*parts, strict=True)) if parts else cls.none()

    @property
    def size(self) -> int:
        """How many."""
        return len(self.a)

    def take(self, which: Indices | Mask) -> Pairs:
        """Some of them."""
        return Pairs._make(column[which] for column in self)

    def cheapest(self, keys: Indices) -> Pairs:
        """Of those with equal keys the one that costs least, the earliest of equals; the cheapest first."""
        ordered = np.lexsort((self.b, self.a, self.cost))
        _, first = np.unique(keys[ordered], return_index=True)
        return self.take(ordered[np.sort(first)])


class Judged(NamedTuple):
    """Pairs with their costs, and how many are refused for what."""

    pairs: Pairs
    refused: dict[str, int]


class Seams:
    """What is known of every seam: index a is the seam between frames a − 1 and a."""

    def __init__(self, repertoire: Repertoire, limits: Limits, weights: Array, spacing: float) -> None:
        self.repertoire, self.limits, self.weights = repertoire, limits, weights
        self.fps, starts = repertoire.fps, repertoire.starts
        self.frames = repertoire.frame_count
        self.quaternions = (repertoire.poses.quaternions, repertoire.poses.mirror().quaternions)
        self.half = half_window(self.fps)
        self.spacing = max(1, ceil(spacing * self.fps - 1e-9))
        self.recording = repertoire.recording_of(np.arange(self.frames))
        first, end = starts[self.recording], starts[self.recording + 1]
        index = np.arange(self.frames)
        self.inside: Mask = (index - self.half >= first) & (index + self.half <= end)
        self.step = max(1, round(self.fps / SEARCH_RATE))
        far = 0.5 * float(chord(min(limits.distance, limits.found)))
        self.cell = _steps(repertoire, far, weights, self.spacing)
        """Number of the step that each seam lies in."""
        before = np.maximum(index - self.half, first)
        after = np.minimum(index - self.half + span(self.fps), end - 1)
        seconds = np.maximum(after - before, 1) / self.fps
        self.pose_velocity = [pose_velocity(q[before], q[after], weights, seconds) for q in self.quaternions]
        last = np.maximum(index - 1, first)
        place = repertoire.roots_of(index)
        self.height = 0.5 * (place[last, 1] + place[:, 1])
        yaw = np.unwrap(repertoire.yaw_of(index))
        self.turning = (yaw[after] - yaw[before]) / seconds
        moved = place[after][:, [0, 2]] - place[before][:, [0, 2]]
        self.travel = from_heading(moved, 0.5 * (yaw[last] + yaw)) / seconds[:, None]
        feet = feet_beneath(repertoire)
        self.place = 0.5 * (feet[:, last] + feet)
        self.foot_velocity = (feet[:, after] - feet[:, before]) / seconds[:, None, None]
        reach = max(1, round(0.5 * FOOT_SECONDS * self.fps))
        standing = np.cumsum(np.concatenate([np.zeros((1, 2)), repertoire.contacts_of(index)]), axis=0)
        low, high = np.maximum(index - reach, first), np.minimum(index + reach, end)
        self.standing = (standing[high] - standing[low]) / (high - low)[:, None]

    @property
    def steps(self) -> int:
        """How many steps the recordings are divided into."""
        return int(self.cell[-1]) + 1

    def measured(self, pairs: Pairs) -> Pairs:
        """With their mean D over the window, at full rate."""
        out = np.empty(pairs.size)
        offsets = np.arange(-self.half, self.half)
        for relation in range(4):
            chosen = np.flatnonzero(pairs.relation == relation)
            other = self.quaternions[relation % 2]
            for part in np.array_split(chosen, max(1, -(-len(chosen) // _CHUNK))):
                if not len(part):
                    continue
                rows = pairs.a[part, None] + offsets
                columns = pairs.b[part, None] + (offsets if relation < REVERSE else -1 - offsets)
                d = paired_distance(self.quaternions[0][rows.ravel()], other[columns.ravel()], self.weights)
                out[part] = d.reshape(rows.shape).mean(axis=1)
        return pairs._replace(distance=out)

    def judged(self, pairs: Pairs, *, slack: float = 1.0) -> Judged:
        """With what they cost.

        Parameters
        ----------
        slack : times the limit by which poses may be apart.
        """
        cost = np.full(pairs.size, np.inf)
        refused: dict[str, int] = {}
        for start in range(0, pairs.size, _CHUNK):
            left = np.arange(start, min(start + _CHUNK, pairs.size))
            total = np.zeros(len(left))
            kinds = 0
            # what refuses most and takes least time goes first: all that follows is asked of the others only
            for what, share in self._shares():
                differs = share(pairs.take(left))
                most = np.sqrt(slack) if what == POSE else 1.0
                good = differs <= most
                if what != POSE and not good.all():
                    refused[what] = refused.get(what, 0) + int(np.count_nonzero(~good))
                left, total = left[good], total[good] + np.square(differs[good])
                kinds += 1
            cost[left] = total / kinds
        return Judged(pairs._replace(cost=cost), refused)

    def agreeing(self, pairs: Pairs, *, slack: float = 1.0) -> Judged:
        """Those of which nothing differs too much, with what they cost."""
        judged, refused = self.judged(pairs, slack=slack)
        return Judged(judged.take(np.isfinite(judged.cost)), refused)

    def _shares(self) -> Iterator[tuple[str, Callable[[Pairs], Array]]]:
        """What is compared across pairs of seams: how far apart as a share of what may be."""
        yield POSE, lambda pairs: np.sqrt(pairs.distance / self.limits.distance)
        yield "velocity of the pose", self._pose_velocities
        yield "velocity over the ground", self._travels
        yield "turning", self._turnings
        yield "height of the pelvis", lambda p: np.abs(self.height[p.a] - self.height[p.b]) / self.limits.height
        yield "feet on the ground", self._standings
        yield "place of the feet", self._places
        yield "velocity of the feet", self._foot_velocities

    def _pose_velocities(self, pairs: Pairs) -> Array:
        here = self.pose_velocity[0][pairs.a]
        there = self.pose_velocity[0][pairs.b]
        image = _image(pairs)
        there[image] = self.pose_velocity[1][pairs.b[image]]
        apart = np.linalg.norm(here - _time(pairs)[:, None] * there, axis=1)
        faster = np.maximum(np.linalg.norm(here, axis=1), np.linalg.norm(there, axis=1))
        return np.asarray(apart / np.maximum(DIRECTION * faster, self.limits.pose_velocity), dtype=np.float64)

    def _travels(self, pairs: Pairs) -> Array:
        mirror = _sign(pairs)
        there = self.travel[pairs.b] * np.stack([mirror, np.ones_like(mirror)], axis=1) * _time(pairs)[:, None]
        return np.asarray(np.linalg.norm(self.travel[pairs.a] - there, axis=1) / self.limits.velocity)

    def _turnings(self, pairs: Pairs) -> Array:
        there = _sign(pairs) * _time(pairs) * self.turning[pairs.b]
        return np.asarray(np.abs(self.turning[pairs.a] - there) / self.limits.turn)

    def _standing_there(self, pairs: Pairs) -> Array:
        there = self.standing[pairs.b]
        return np.asarray(np.where(_image(pairs)[:, None], there[:, ::-1], there))

    def _standings(self, pairs: Pairs) -> Array:
        return np.asarray(np.abs(self.standing[pairs.a] - self._standing_there(pairs)).max(axis=1, initial=0.0) / FOOT)

    def _places(self, pairs: Pairs) -> Array:
        strand = _image(pairs).astype(np.intp)
        away = np.linalg.norm(self.place[0, pairs.a] - self.place[strand, pairs.b], axis=-1)
        bearing = np.tile(np.minimum(self.standing[pairs.a], self._standing_there(pairs)), 2)
        return np.asarray((away / (self.limits.place * (1.0 - (1.0 - BEARING) * bearing))).max(axis=1, initial=0.0))

    def _foot_velocities(self, pairs: Pairs) -> Array:
        strand = _image(pairs).astype(np.intp)
        there = _time(pairs)[:, None, None] * self.foot_velocity[strand, pairs.b]
        apart = np.linalg.norm(self.foot_velocity[0, pairs.a] - there, axis=-1)
        return np.asarray(apart.max(axis=1, initial=0.0) / self.limits.foot_velocity)


def _image(pairs: Pairs) -> Mask:
    return np.asarray(pairs.relation % 2 == 1)


def _sign(pairs: Pairs) -> Array:
    return np.where(_image(pairs), -1.0, 1.0)


def _time(pairs: Pairs) -> Array:
    return np.where(pairs.relation >= REVERSE, -1.0, 1.0)


def _steps(repertoire: Repertoire, far: float, weights: Array, shortest: int) -> Indices:
    """Number of the step that each frame lies in."""
    q, fps, starts = repertoire.poses.quaternions, repertoire.fps, repertoire.starts
    longest = max(shortest, round(STEP * fps))
    index = np.arange(repertoire.frame_count)
    ends = starts[repertoire.recording_of(index) + 1]
    # where the step would end that began at each frame
    until = np.minimum(index + longest, ends)
    near = index
    for lag in range(shortest, longest, max(1, round(fps / SEARCH_RATE))):
        near = near[near + lag < ends[near]]
        gone = paired_distance(q[near], q[near + lag], weights) > 0.5 * far * far if len(near) else near > 0
        until[near[gone]] = near[gone] + lag
        near = near[~gone]
    onward: list[int] = until.tolist()
    begins = np.zeros(repertoire.frame_count, dtype=np.intp)
    here = 0
    while here < repertoire.frame_count:
        begins[here] = 1
        here = onward[here]
    return np.cumsum(begins) - 1


class Ways(NamedTuple):
    """What pairs of seams allow in every strand."""

    source: Indices
    """Moment after which one leaves."""
    target: Indices
    """Moment at which one arrives."""
    pair: Indices
    """Number of the pair."""


def ways(repertoire: Repertoire, pairs: Pairs) -> Ways:
    """From every strand that may be used, in both directions."""
    columns: list[tuple[Indices, Indices, Indices]] = []
    number = np.arange(pairs.size)
    for strand in repertoire.strands:
        for here, there, keep in ((pairs.a, pairs.b, slice(None)), (pairs.b, pairs.a, pairs.a != pairs.b)):
            source = arriving(repertoire, here, np.full(pairs.size, strand))
            target = leaving(repertoire, there, strand ^ pairs.relation)
            columns.append((source[keep], target[keep], number[keep]))
    return Ways(*(np.concatenate(c) for c in zip(*columns, strict=True)))


def arriving(repertoire: Repertoire, seam: Indices, strand: Indices) -> Indices:
    """The last moment before a seam."""
    return np.where(strand >= 2, seam, seam - 1) + repertoire.frame_count * strand


def leaving(repertoire: Repertoire, seam: Indices, strand: Indices) -> Indices:
    """The first moment behind a seam."""
    return np.where(strand >= 2, seam - 1, seam) + repertoire.frame_count * strand
