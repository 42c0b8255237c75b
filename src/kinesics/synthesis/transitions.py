"""Where one movement can go over into another: near moments of the recordings ([Schultz2012] §4.4, [Kovar2002] §3.1).

**Seams.** The place between frame a − 1 and frame a is *seam* a. Whoever arrives at a seam may go on behind it, or behind any
seam that is near. Nearness is one of four relations, the dissertation's Klein four-group: the same (D), mirrored (D*),
reversed, reversed and mirrored. A pair of near seams (a, b) under a relation r serves every strand x: from (a, x) to (b, x·r)
and from (b, x) to (a, x·r), x·r the strand in which both are applied. So the transitions of mirrored recordings are the
mirrored transitions, and those of reversed ones the reversed.

**Distance.** The mean of D over a short window about the two seams, frames a − h … a + h − 1 against b − h … b + h − 1
(reversed: against b + h − 1 … b − h), 2h frames in all.

**Which pairs.** Local minima of that distance in the (a, b) plane that are near enough, and of which neither differs too much in

- the velocity of the pose: by no more than .85 of the faster one (two of equal speed: 50 degrees apart), or, where both are
  slow, by half of what it usually changes within the time of a blend: one may begin to move from rest;
- the velocity of the root over the ground and its turning, seen from the heading, and its height: by no more than nine tenths
  of all moving moments change within the time of a blend, see `Limits`;
- the feet: none that stands where the other swings, unless it changes at the seam;
- where ankles and toes are beneath the body, seen from the heading: D is in angles and does not tell strides of unlike length, but
  a foot that stays where it bears must make up for the difference with its leg. By no more than `PLACE` of what all moving
  moments change within the time of a blend, 15 to 20 cm, a bearing foot by half as much;
- and how fast they go there: by no more than `FOOT_VELOCITY` of what changes within that time.

**The threshold** is found in the recordings (`Limits.rule`): the offset that a blend of a quarter of a second hides may be no
larger than what the movement itself covers in that time, the median over all moments that move, in √(2D), which is a length;
nor larger than the median over all pairs of such moments, which in quick small movement is less; nor smaller than a body at rest
sways (`kinesics.analysis.stillness.EPSILON`).

**Stillness.** In quiet standing everything is near everything. Each recording is therefore divided into *steps*, in which the
pose goes half of the threshold (of that found, if a larger one is given, which would else leave fewer seams) and which last .1 s
at least and 1 s at most; of two steps only the nearest pair is kept, and a step has one seam.

References
----------
- [Kovar2002] Kovar, Gleicher, Pighin: Motion graphs. SIGGRAPH 2002.
- [Arikan2002] Arikan, Forsyth: Interactive motion generation from examples. SIGGRAPH 2002.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.analysis.stillness import EPSILON, JITTERS, sensor_jitter
from kinesics.body import kinematics, pose
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.progress import Progress, silent
from kinesics.similarity import Weights, check_weights, chord, diagonal_sums, distance
from kinesics.similarity.metric import paired_distance
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

SAME: Final = 0
MIRROR: Final = 1
REVERSE: Final = 2
MIRROR_REVERSE: Final = 3
"""Relations between seams; applied to a strand: strand ^ relation."""

BLEND: Final = 0.25
"""Seconds of a blend, by which the limits are measured."""
WINDOW: Final = 0.2
"""Seconds over which two moments are compared."""
SPACING: Final = 0.1
"""Seconds between seams that are used, at least."""
DENSITY: Final = 30.0
"""Transitions that leave each second of each strand, at most, on average."""
POSE: Final = "pose"
STEP: Final = 1.0
"""Seconds that a step lasts at most: so many seams are kept of quiet standing."""
BAND: Final = 0.3
"""Seconds: nearer moments of one recording are near because they are nearly one."""
SEARCH_RATE: Final = 30.0
"""Moments a second that are compared all with all; the pairs found are refined at full rate."""
DIRECTION: Final = 0.85
"""Difference of pose velocities that is accepted, as a share of the faster one."""
SLOW: Final = 0.5
"""The same where both are slow, as a share of what the velocity itself changes in the time of a blend (median)."""
CHANGE_QUANTILE: Final = 0.9
FOOT: Final = 0.5
"""Difference between shares of time on the ground about the seam."""
FOOT_SECONDS: Final = 0.14
PLACE: Final = 0.7
"""Difference between the places of the feet, as a share of what nine tenths of all moments change within a blend."""
BEARING: Final = 0.5
"""The same of a foot that bears, as a share of that."""
FOOT_VELOCITY: Final = 0.5
_LEAST_PLACE: Final = 0.15
_MOST_PLACE: Final = 0.2
_LEAST_VELOCITY: Final = 0.1
_LEAST_TURN: Final = 0.5
_LEAST_HEIGHT: Final = 0.03
_TILE: Final = 1024
_SAMPLES: Final = 1024
_CHUNK: Final = 4096
_GRID_SLACK: Final = 1.2
_FORESTS: Final = 4
_BRIDGES: Final = 4


@dataclass(frozen=True)
class Limits:
    """How much may differ across a transition."""

    distance: float
    """Mean D over the window."""
    rule: str
    """How ``distance`` was found."""
    found: float
    """What it is if it is not given, infinite where nothing moves."""
    pose_velocity: float
    """Of the pose where it is slow, √(2D)/s."""
    velocity: float
    """Of the root over the ground, m/s."""
    turn: float
    """Of the heading, rad/s."""
    height: float
    """Of the root, metres."""
    place: float
    """Of a swinging foot beneath the root, metres; of one that bears half as much."""
    foot_velocity: float
    """Of a foot beneath the root, m/s."""


class Nearest(NamedTuple):
    """Of all pairs of moments outside the trivial band, the nearest in pose."""

    distance: float
    """Mean D over the window; infinite where there is no pair at all."""
    first: int
    second: int
    """Frames, over all recordings end to end."""


@dataclass(frozen=True, eq=False, repr=False)
class Transitions:
    """Where one may leave and where one then arrives, sorted by `source` and `cost`."""

    repertoire: Repertoire
    source: Indices
    """Moment after which one leaves."""
    target: Indices
    """Moment at which one arrives: it takes the place of the one that would follow `source`."""
    distance: Array
    """Mean D over the window."""
    cost: Array
    """In [0, 1]: mean of the squares of what differs, each as a share of its limit; going on as recorded would cost 0."""
    limits: Limits
    nearest: Nearest
    refused: Mapping[str, int]
    """Pairs that are near in pose, but differ too much in something else: what → how many."""

    def __len__(self) -> int:
        """How many."""
        return len(self.source)

    def __repr__(self) -> str:
        """How many, and how near."""
        return f"Transitions({len(self)} of {len(self.repertoire.names)} recordings, threshold {self.threshold:.3g})"

    @property
    def threshold(self) -> float:
        """Largest mean D accepted."""
        return self.limits.distance


class _Pairs(NamedTuple):
    """Pairs of seams under relations."""

    a: Indices
    b: Indices
    relation: Indices
    distance: Array

    def take(self, which: Indices | Mask) -> _Pairs:
        return _Pairs(self.a[which], self.b[which], self.relation[which], self.distance[which])


def transitions(
    repertoire: Repertoire,
    *,
    threshold: float | None = None,
    density: float = DENSITY,
    spacing: float = SPACING,
    weights: Weights | None = None,
    progress: Progress = silent,
) -> Transitions:
    """Find the transitions within and between the recordings of a repertoire, mirrored and backward ones where it has them.

    Parameters
    ----------
    threshold : largest mean D accepted; found in the recordings if not given (`Limits.rule`).
    density : transitions that leave each second of a strand, on average and at most; the best are kept, of every second and
        towards every recording.
    spacing : seconds between the moments at which one may leave or arrive, at least.
    weights : of the 15 links in D, see `kinesics.similarity.distance`.
    progress : told the fraction done; may raise to stop.

    Returns
    -------
    Possibly none: `Transitions.nearest` and `Transitions.refused` then tell why.

    Raises
    ------
    InputError
        If a parameter is not a positive number, or nothing moves in the recordings and no threshold is given.
    """
    for name, value in (("threshold", threshold), ("density", density), ("spacing", spacing)):
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise InputError(f"Expected `{name}` above 0, got {value}.")
    share = check_weights(weights)
    limits = _limits(repertoire, threshold, share)
    seams = _Seams(repertoire, limits, share, spacing)
    found, nearest = _search(seams, progress)
    # the distances found on the grid are not yet those at full rate
    agreed = _agreeing(seams, found, slack=_GRID_SLACK if seams.step > 1 else 1.0)
    rough = _choose(seams, agreed.pairs, 2.0 * density)
    if seams.step > 1:
        rough = _refined(seams, rough)
    shared = _agreeing(seams, _on_shared_seams(seams, rough))
    pairs = _choose(seams, shared.pairs, density)
    progress(1.0, "finding transitions")
    return _transitions(seams, pairs, nearest, agreed.refused)


class _Seams:
    """What is known of every seam: index a is the seam between frames a − 1 and a."""

    def __init__(self, repertoire: Repertoire, limits: Limits, weights: Array, spacing: float) -> None:
        self.repertoire, self.limits, self.weights = repertoire, limits, weights
        self.fps, starts = repertoire.fps, repertoire.starts
        self.frames = repertoire.frame_count
        self.quaternions = (repertoire.poses.quaternions, repertoire.poses.mirror().quaternions)
        self.half = max(1, round(0.5 * WINDOW * self.fps))
        self.spacing = max(1, ceil(spacing * self.fps - 1e-9))
        self.recording = repertoire.recording_of(np.arange(self.frames))
        first, end = starts[self.recording], starts[self.recording + 1]
        index = np.arange(self.frames)
        self.inside: Mask = (index - self.half >= first) & (index + self.half <= end)
        self.step = max(1, round(self.fps / SEARCH_RATE))
        self.cell = _steps(repertoire, 0.5 * float(chord(min(limits.distance, limits.found))), weights, spacing)
        before, after = np.maximum(index - self.half, first), np.minimum(index + self.half, end) - 1
        seconds = np.maximum(after - before, 1) / self.fps
        self.pose_velocity = [_pose_velocity(q[before], q[after], weights, seconds) for q in self.quaternions]
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

    def distances(self, pairs: _Pairs) -> Array:
        """Mean D over the window of each pair, at full rate."""
        out = np.empty(len(pairs.a))
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
        return out

    def differences(self, pairs: _Pairs) -> dict[str, Array]:
        """What differs across each pair, as a share of what may."""
        a, b = pairs.a, pairs.b
        image = pairs.relation % 2 == 1
        mirror = np.where(image, -1.0, 1.0)
        time = np.where(pairs.relation >= REVERSE, -1.0, 1.0)
        limits = self.limits
        pose_velocity = np.empty(len(a))
        for start in range(0, len(a), _CHUNK):
            part = slice(start, start + _CHUNK)
            here = self.pose_velocity[0][a[part]]
            there = np.where(image[part, None], self.pose_velocity[1][b[part]], self.pose_velocity[0][b[part]])
            apart = np.linalg.norm(here - time[part, None] * there, axis=1)
            faster = np.maximum(np.linalg.norm(here, axis=1), np.linalg.norm(there, axis=1))
            pose_velocity[part] = apart / np.maximum(DIRECTION * faster, limits.pose_velocity)
        travel = self.travel[b] * np.stack([mirror, np.ones_like(mirror)], axis=1) * time[:, None]
        standing = np.where(image[:, None], self.standing[b][:, ::-1], self.standing[b])
        strand = image.astype(np.intp)
        away = np.linalg.norm(self.place[0, a] - self.place[strand, b], axis=-1)
        bearing = np.tile(np.minimum(self.standing[a], standing), 2)
        faster = np.linalg.norm(self.foot_velocity[0, a] - time[:, None, None] * self.foot_velocity[strand, b], axis=-1)
        return {
            POSE: np.sqrt(pairs.distance / limits.distance),
            "velocity of the pose": pose_velocity,
            "velocity over the ground": np.linalg.norm(self.travel[a] - travel, axis=1) / limits.velocity,
            "turning": np.abs(self.turning[a] - mirror * time * self.turning[b]) / limits.turn,
            "height of the pelvis": np.abs(self.height[a] - self.height[b]) / limits.height,
            "feet on the ground": np.abs(self.standing[a] - standing).max(axis=1) / FOOT,
            "place of the feet": (away / (limits.place * (1.0 - (1.0 - BEARING) * bearing))).max(axis=1),
            "velocity of the feet": faster.max(axis=1) / limits.foot_velocity,
        }


def _pose_velocity(before: Array, after: Array, weights: Array, seconds: Array) -> Floats:
    """Velocity of the pose whose length is √(2D)/s: half the angular velocities and that of gravity, (frames, 45)."""
    turned = 0.5 * quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(before), after))
    turned[:, 0] = 0.5 * (pose.gravity(after) - pose.gravity(before))
    share = np.sqrt(weights / weights.sum())
    return np.asarray((turned * share[:, None] / seconds[:, None, None]).reshape(len(before), -1), dtype=np.float32)


def from_heading(vectors: Array, yaw: Array) -> Array:
    """Vectors (x, z) of the world as seen by one who faces ``yaw``: to the left, ahead."""
    sine, cosine = np.sin(yaw), np.cos(yaw)
    x, z = vectors[:, 0], vectors[:, 1]
    return np.stack([cosine * x - sine * z, sine * x + cosine * z], axis=1)


def feet_beneath(repertoire: Repertoire) -> Array:
    """Ankles and toes from the root, to the left, up, ahead as seen from the heading, metres, as recorded and mirrored.

    Shape (2, frames, 4, 3): left ankle, right ankle, left toes, right toes.
    """
    skeleton = repertoire.skeleton
    index = np.arange(repertoire.frame_count)
    out = np.zeros((2, repertoire.frame_count, 4, 3))
    points = [_foot_points(skeleton, side) for side in ("left", "right")]
    for strand in (0, 1) if repertoire.mirrored else (0,):
        roots = repertoire.root_positions[strand]
        where, world = kinematics.forward(skeleton, repertoire.rotations[strand], roots)
        yaw = repertoire.yaw_of(repertoire.moments(index, strand))
        for k, (ankle, offset) in enumerate(points):
            tip = where[:, ankle] + quaternion.rotate(world[:, ankle], offset)
            for row, place in ((k, where[:, ankle]), (k + 2, tip)):
                away = place - roots
                out[strand, :, row, [0, 2]] = from_heading(away[:, [0, 2]], yaw).T
                out[strand, :, row, 1] = away[:, 1]
    return out


def _foot_points(skeleton: Skeleton, side: str) -> tuple[int, Array]:
    """The ankle, or the knee of a leg without one, and from there to what hangs on it farthest, in its own frame."""
    assert skeleton.anatomy is not None
    ankle = getattr(skeleton.anatomy.roles, f"{side}_foot")
    if ankle is None:
        ankle = getattr(skeleton.anatomy.roles, f"{side}_tibia")
    ends = [skeleton.offsets[c] for c in skeleton.children[ankle]]
    ends += [np.asarray(site.offset) for site in skeleton.end_sites if site.parent == ankle]
    return ankle, max(ends, key=lambda v: float(np.linalg.norm(v)), default=np.zeros(3))


def _limits(repertoire: Repertoire, threshold: float | None, weights: Array) -> Limits:
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
    if threshold is not None:
        allowed, rule = float(threshold), "given"
    early = early[moving] if moving.any() else early
    roots = repertoire.roots_of(index)
    yaw = np.unwrap(repertoire.yaw_of(index))
    # velocities over a window, as they are compared
    wide = max(1, round(WINDOW * repertoire.fps))
    ends = repertoire.starts[recording + 1] - 1
    ahead = np.minimum(index + wide, ends)
    seconds = np.maximum(ahead - index, 1) / repertoire.fps
    travel = from_heading(roots[ahead][:, [0, 2]] - roots[:, [0, 2]], yaw) / seconds[:, None]
    turning = (yaw[ahead] - yaw) / seconds
    whole = early[early + lag + wide <= ends[early]]

    feet = feet_beneath(repertoire)[0]
    going = (feet[ahead] - feet) / seconds[:, None, None]
    velocity = _pose_velocity(q, q[ahead], weights, seconds)
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


def _steps(repertoire: Repertoire, far: float, weights: Array, spacing: float) -> Indices:
    """Number of the step that each frame lies in."""
    q, fps, starts = repertoire.poses.quaternions, repertoire.fps, repertoire.starts
    shortest = max(1, ceil(spacing * fps - 1e-9))
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


def _search(seams: _Seams, progress: Progress) -> tuple[_Pairs, Nearest]:
    """Local minima below the threshold, the nearest of every two steps, on a grid of about 30 moments a second."""
    starts, step = seams.repertoire.starts, seams.step
    grid = np.concatenate([np.arange(s, e, step) for s, e in itertools.pairwise(starts)])
    half = max(1, round(0.5 * WINDOW * seams.fps / step))
    q = np.ascontiguousarray(seams.quaternions[0][grid])
    recording = seams.recording[grid]
    windows = len(grid) - 2 * half + 1
    if windows < 1:
        return _none(), Nearest(np.inf, 0, 0)
    # a window that begins at grid moment i lies about the seam before grid moment i + half
    ok = recording[:windows] == recording[2 * half - 1 :]
    seam = grid[half : half + windows]
    owner = recording[half : half + windows]
    ok &= seams.inside[seam]
    band = BAND * seams.fps / step
    most = seams.limits.distance * 2 * half * (_GRID_SLACK if step > 1 else 1.0)
    corners = [(i, j) for i in range(0, windows, _TILE) for j in range(i, windows, _TILE)]
    nearest = Nearest(np.inf, 0, 0)
    parts: list[_Pairs] = []
    for done, (i, j) in enumerate(corners):
        progress(0.9 * done / len(corners), "comparing all moments")
        # one more on each side, so that a minimum has all its neighbours
        rows = slice(max(i - 1, 0), min(i + _TILE + 1, windows))
        columns = slice(max(j - 1, 0), min(j + _TILE + 1, windows))
        a = q[rows.start : rows.stop + 2 * half - 1]
        b = q[columns.start : columns.stop + 2 * half - 1]
        for reverse in (False, True) if seams.repertoire.backwards else (False,):
            sums = diagonal_sums(a, b, length=2 * half, reverse=reverse, weights=seams.weights)
            for mirrored, d in ((False, sums.d), (True, sums.d_mirror)):
                if mirrored and not seams.repertoire.mirrored:
                    continue
                relation = (REVERSE if reverse else SAME) + mirrored
                d[~ok[rows]] = np.inf
                d[:, ~ok[columns]] = np.inf
                if relation == SAME and columns.start - rows.stop < band:
                    across = np.arange(columns.start, columns.stop) - np.arange(rows.start, rows.stop)[:, None]
                    # what is below the diagonal is found above it; across the border of a recording nothing is trivial
                    d[(across < band) & ((across < 0) | (owner[rows][:, None] == owner[columns]))] = np.inf
                least = int(np.argmin(d))
                value = float(d.flat[least]) / (2 * half)
                if value < nearest.distance:
                    at = divmod(least, d.shape[1])
                    nearest = Nearest(value, int(seam[rows.start + at[0]]), int(seam[columns.start + at[1]]))
                if value * 2 * half > most:
                    continue
                r, c = _minima(d, most)
                r, c = r + rows.start, c + columns.start
                own = (r >= i) & (r < i + _TILE) & (c >= j) & (c < j + _TILE) & (r <= c)
                values = d[r[own] - rows.start, c[own] - columns.start].astype(np.float64) / (2 * half)
                pairs = _Pairs(seam[r[own]], seam[c[own]], np.full(np.count_nonzero(own), relation), values)
                parts.append(_thinned(seams, pairs))
    return _thinned(seams, _joined(parts)), nearest


def _none() -> _Pairs:
    empty = np.zeros(0, dtype=np.intp)
    return _Pairs(empty, empty, empty, np.zeros(0))


def _joined(parts: list[_Pairs]) -> _Pairs:
    if not parts:
        return _none()
    return _Pairs(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _minima(d: Floats, most: float) -> tuple[Indices, Indices]:
    """Entries of at most ``most`` that none of their eight neighbours undercuts."""
    rows, columns = d.shape
    wide = np.full((rows + 2, columns + 2), np.inf, dtype=np.float32)
    wide[1:-1, 1:-1] = d
    inner = wide[1:-1, 1:-1]
    found = inner <= np.float32(most)
    for beside in (wide[1:-1, 2:], wide[1:-1, :-2], wide[2:, 1:-1], wide[:-2, 1:-1]):
        found &= inner <= beside
    r, c = np.divmod(np.flatnonzero(found), columns)
    for dr, dc in ((2, 2), (0, 0), (2, 0), (0, 2)):
        keep = d[r, c] <= wide[r + dr, c + dc]
        r, c = r[keep], c[keep]
    return r, c


def _thinned(seams: _Seams, pairs: _Pairs) -> _Pairs:
    """Of every two steps and each relation the nearest pair."""
    order = np.lexsort((pairs.b, pairs.a, pairs.distance))
    ordered = pairs.take(order)
    count = int(seams.cell[-1]) + 1
    key = (ordered.relation * count + seams.cell[ordered.a]) * count + seams.cell[ordered.b]
    _, first = np.unique(key, return_index=True)
    return ordered.take(np.sort(first))


class _Agreeing(NamedTuple):
    pairs: _Pairs
    refused: dict[str, int]


def _agreeing(seams: _Seams, pairs: _Pairs, slack: float = 1.0) -> _Agreeing:
    """Those that differ in nothing too much; of the others that are near in pose, how many for each reason."""
    good = np.ones(len(pairs.a), dtype=np.bool_)
    refused: dict[str, int] = {}
    for what, share in seams.differences(pairs).items():
        bad = good & (share > (np.sqrt(slack) if what == POSE else 1.0))
        if what != POSE and bad.any():
            refused[what] = int(np.count_nonzero(bad))
        good &= ~bad
    return _Agreeing(pairs.take(good), refused)


def _costs(seams: _Seams, pairs: _Pairs) -> Array:
    return np.asarray(np.mean([np.square(v) for v in seams.differences(pairs).values()], axis=0))


def _choose(seams: _Seams, pairs: _Pairs, density: float) -> _Pairs:
    """The best of every second, in turn towards every recording and under every relation; and what joins recordings."""
    # a pair is left from either side; each second names half of its transitions, its partners name the others
    most = max(1, int(0.5 * density))
    costs = _costs(seams, pairs)
    starts = seams.repertoire.starts
    cost = np.tile(costs, 2)
    here, there = np.concatenate([pairs.a, pairs.b]), np.concatenate([pairs.b, pairs.a])
    second = ((here - starts[seams.recording[here]]) / seams.fps).astype(np.intp) + starts[seams.recording[here]]
    kind = np.tile(pairs.relation, 2) * seams.repertoire.recording_count + seams.recording[there]
    turn = _rank(cost, second, kind)
    named = _rank(turn + cost / 2.0, second) < most  # costs are at most 1
    return pairs.take(named[: len(pairs.a)] | named[len(pairs.a) :] | _bridges(seams, pairs, costs))


def _bridges(seams: _Seams, pairs: _Pairs, costs: Array) -> Mask:
    """The cheapest pairs that join all recordings and their mirror images that can be joined at all.

    Where many recordings are much alike, the best pairs of every second lie among those; a few dearer ones hold the others.
    So the spanning forest of least cost over recordings and mirror images is taken, several times over.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import minimum_spanning_tree

    count = seams.repertoire.recording_count
    first, second = seams.recording[pairs.a], seams.recording[pairs.b]
    # forwards and backwards make no difference here
    edge = (first * count + second) * 2 + pairs.relation % 2
    place = _rank(costs, edge)
    best = np.flatnonzero((place == 0) & ((first != second) | (pairs.relation % 2 == 1)))
    chosen = np.zeros(len(pairs.a), dtype=np.bool_)
    for _ in range(_FORESTS):
        if not len(best):
            break
        image = pairs.relation[best] % 2
        tails = np.concatenate([first[best], first[best] + count])
        heads = np.concatenate([second[best] + image * count, second[best] + (1 - image) * count])
        weights = np.tile(costs[best] + 1e-6, 2)
        tree = minimum_spanning_tree(csr_array((weights, (tails, heads)), shape=(2 * count, 2 * count))).tocoo()
        ends = np.minimum(tree.row, tree.col) * 2 * count + np.maximum(tree.row, tree.col)
        used = np.isin(np.minimum(tails, heads) * 2 * count + np.maximum(tails, heads), ends)
        taken = used[: len(best)] | used[len(best) :]
        chosen |= np.isin(edge, edge[best[taken]]) & (place < _BRIDGES)
        best = best[~taken]
    return chosen


def _rank(values: Array, *groups: Indices) -> Indices:
    """Place of each value, 0 the least, among those of its group."""
    order = np.lexsort((values, *groups))
    new = np.zeros(len(order), dtype=np.bool_)
    new[:1] = True
    for group in groups:
        new[1:] |= np.diff(group[order]) != 0
    place = np.arange(len(order))
    out = np.empty(len(order), dtype=np.intp)
    out[order] = place - np.maximum.accumulate(np.where(new, place, 0))
    return out


def _refined(seams: _Seams, pairs: _Pairs) -> _Pairs:
    """The second seam moved to where it is nearest, by less than the grid's step, at full rate."""
    best = pairs._replace(distance=np.full(len(pairs.a), np.inf))
    for shift in range(-seams.step, seams.step + 1):
        moved = pairs._replace(b=np.clip(pairs.b + shift, 0, seams.frames - 1))
        allowed = seams.inside[moved.b] & (seams.recording[moved.b] == seams.recording[pairs.b])
        d = np.full(len(pairs.a), np.inf)
        d[allowed] = seams.distances(moved.take(allowed))
        nearer = d < best.distance
        best = best._replace(b=np.where(nearer, moved.b, best.b), distance=np.where(nearer, d, best.distance))
    return best


def _on_shared_seams(seams: _Seams, pairs: _Pairs) -> _Pairs:
    """All pairs moved onto few seams, one a step, the places of the best pairs first."""
    chosen = _shared_seams(seams, pairs)
    known = np.concatenate([[-1], chosen, [-1]])
    # each pair: the seams of the step it lies in and of the steps beside it, on both sides; the two least moved pairs
    sides: list[Indices] = []
    for seam in (pairs.a, pairs.b):
        cell = seams.cell[seam]
        options = np.stack([known[cell + 1 + k] for k in (0, -1, 1)], axis=1)
        near = np.abs(options - seam[:, None]) <= seams.spacing
        near[:, 0] = True
        same = seams.recording[np.maximum(options, 0)] == seams.recording[seam][:, None]
        sides.append(np.where((options >= 0) & near & same, options, -1))
    a, b = np.repeat(sides[0], 3, axis=1), np.tile(sides[1], (1, 3))
    back = np.where(pairs.relation >= REVERSE, -1, 1)[:, None]
    far = np.iinfo(np.intp).max
    shear = np.abs((a - pairs.a[:, None]) - back * (b - pairs.b[:, None])) * 4 + np.abs(a - pairs.a[:, None])
    shear = np.where((a < 0) | (b < 0), far, shear)
    parts: list[_Pairs] = []
    order = np.argsort(shear, axis=1, kind="stable")
    for k in range(2):
        at = order[:, k : k + 1]
        real = np.take_along_axis(shear, at, axis=1)[:, 0] < far
        first, second = (np.take_along_axis(side, at, axis=1)[real, 0] for side in (a, b))
        parts.append(_Pairs(first, second, pairs.relation[real], np.zeros(len(first))))
    moved = _joined(parts)
    low, high = np.minimum(moved.a, moved.b), np.maximum(moved.a, moved.b)
    key = (moved.relation * seams.frames + low) * seams.frames + high
    _, first = np.unique(key, return_index=True)
    moved = _Pairs(low[first], high[first], moved.relation[first], moved.distance[first])
    trivial = (
        (moved.relation == SAME)
        & (moved.b - moved.a < BAND * seams.fps)
        & (seams.recording[moved.a] == seams.recording[moved.b])
    )
    moved = moved.take(~trivial)
    return moved._replace(distance=seams.distances(moved))


def _shared_seams(seams: _Seams, pairs: _Pairs) -> Indices:
    """The seam chosen in each step, −1 in those without one."""
    count = int(seams.cell[-1]) + 1
    chosen: list[int] = [-1] * (count + 1)  # one more, so that the step before the first has none
    cell: list[int] = seams.cell.tolist()
    inside: list[bool] = seams.inside.tolist()
    spacing = seams.spacing

    def settle(seam: int) -> int:
        """The seam to use near this one: the step's own, itself where it is free, else its neighbour."""
        own = cell[seam]
        if chosen[own] >= 0:
            return chosen[own]
        for beside in (chosen[own - 1], chosen[own + 1]):
            if beside >= 0 and abs(beside - seam) < spacing:
                return beside
        chosen[own] = seam
        return seam

    order = np.argsort(_costs(seams, pairs), kind="stable")
    for k in order.tolist():
        a, b, relation = int(pairs.a[k]), int(pairs.b[k]), int(pairs.relation[k])
        moved = settle(a) - a
        onward = b - moved if relation >= REVERSE else b + moved
        # moved along with its partner, it stays as near as it was
        same = 0 <= onward < seams.frames and inside[onward] and cell[onward] == cell[b]
        settle(onward if same else b)
    return np.array(chosen[:count], dtype=np.intp)


def _transitions(seams: _Seams, pairs: _Pairs, nearest: Nearest, refused: dict[str, int]) -> Transitions:
    """Every strand's transitions, in both directions."""
    repertoire = seams.repertoire
    cost = _costs(seams, pairs)
    columns: list[tuple[Indices, Indices, Array, Array]] = []
    for strand in repertoire.strands:
        for here, there, keep in ((pairs.a, pairs.b, slice(None)), (pairs.b, pairs.a, pairs.a != pairs.b)):
            onward = strand ^ pairs.relation
            source = arriving(repertoire, here, np.full(len(here), strand))
            target = leaving(repertoire, there, onward)
            columns.append((source[keep], target[keep], pairs.distance[keep], cost[keep]))
    sources, targets, apart, costs = (np.concatenate(c) for c in zip(*columns, strict=True))
    order = np.lexsort((targets, costs, sources))
    found = Transitions(
        repertoire, sources[order], targets[order], apart[order], costs[order], seams.limits, nearest, refused
    )
    for values in (found.source, found.target, found.distance, found.cost):
        values.setflags(write=False)
    return found


def arriving(repertoire: Repertoire, seam: Indices, strand: Indices) -> Indices:
    """The last moment before a seam."""
    return np.where(strand >= 2, seam, seam - 1) + repertoire.frame_count * strand


def leaving(repertoire: Repertoire, seam: Indices, strand: Indices) -> Indices:
    """The first moment behind a seam."""
    return np.where(strand >= 2, seam - 1, seam) + repertoire.frame_count * strand
