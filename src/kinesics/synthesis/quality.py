"""How good a performance is, with the recordings it was made from as the yardstick.

Nothing here knows how a performance was made: its motion is measured as a recording would be, and each figure stands
beside the same figure of the recordings. Contacts are found anew by `kinesics.body.contacts`, not taken from the performer.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import contacts as _contacts
from kinesics.body.contacts import Floor, runs
from kinesics.body.limits import DEPTH_TOLERANCE, self_collisions
from kinesics.body.motion import Motion
from kinesics.body.pose import poses
from kinesics.geometry import quaternion
from kinesics.similarity import distance, mirror_distance
from kinesics.synthesis.rendering import BEARING, Performance, Stage
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

QUANTILE: Final = 0.99
_BLOCK: Final = 512


class Beside(NamedTuple):
    """A figure of the performance beside that of the recordings."""

    performance: float
    recordings: float


@dataclass(frozen=True)
class Quality:
    """Measures of a performance beside its recordings."""

    turning: Beside
    """Leaps of angular velocity from frame to frame, per joint as a share of the recordings' 99th percentile: the 99th
    percentile over joints and frames of transitions; and of the same moments as they were recorded."""
    turning_over: Beside
    """Share of them that are beyond the recordings' 99th percentile, which is .01 over all that was recorded."""
    acceleration: Beside
    """The same of the accelerations of the joints' places."""
    acceleration_over: Beside
    slide: Beside
    """Metres that the bearing part of a foot goes over the floor in one contact: the 95th percentile of contacts."""
    slide_worst: Beside
    slides_over: float
    """Share of the contacts of the performance that slide more than 1 cm."""
    contact_share: Beside
    """Share of time that a foot is on the ground, mean of both."""
    penetration: Beside
    """Metres that a heel or toe goes below the floor at worst."""
    distance: Beside
    """D of a frame to the nearest frame of the recordings, mirrored counted, at worst; and the largest accepted at a
    transition."""
    joint_excess: float
    """Radians by which a joint goes beyond its range in the recordings, mirrored counted, at worst."""
    joint_excess_share: float
    """Share of frames in which any joint does by more than a degree."""
    collision: Beside
    """Metres that two parts of the body pass into each other at worst."""
    collision_share: Beside
    """Share of frames in which any do, beyond the tolerance of `kinesics.body.limits`."""
    lowered: float
    """Metres that the pelvis was lowered at worst."""
    contacts: int
    cuts: int


@dataclass(frozen=True, eq=False)
class _Yardstick:
    turning: Array
    """99th percentile of each joint."""
    acceleration: Array
    turnings: Array
    """Of every frame and its mirror image, shape (2, frames, joints)."""
    accelerations: Array
    slides: Array
    feet: Mask
    """Shape (2, frames, 2)."""
    penetration: float
    collision: float
    collision_share: float


_yardsticks: weakref.WeakKeyDictionary[Repertoire, _Yardstick] = weakref.WeakKeyDictionary()


def measure(performance: Performance, repertoire: Repertoire, *, threshold: float = np.nan) -> Quality:
    """Measure a performance against its recordings.

    Parameters
    ----------
    threshold : largest D accepted at a transition (`Network.threshold`).
    """
    if repertoire not in _yardsticks:
        _yardsticks[repertoire] = _yardstick(repertoire)
    own = _yardsticks[repertoire]
    motion, stage = performance.motion, Stage.of(repertoire)
    came = performance.provenance
    turning, acceleration = _leaps(motion)
    at = came.transition[1:-1]
    turned, pushed = turning[at] / own.turning, acceleration[at] / own.acceleration
    # the same moments as they were recorded
    frame = repertoire.frame_of(came.moment)[1:-1][at]
    image = came.mirrored[1:-1][at].astype(np.intp)
    was_turned, was_pushed = (
        own.turnings[image, frame] / own.turning,
        own.accelerations[image, frame] / own.acceleration,
    )
    slides, feet, sunk = _feet(motion, stage)
    share = float(feet.mean())
    frame_all, image_all = repertoire.frame_of(came.moment), came.mirrored.astype(np.intp)
    low = [float(_nearest(motion, repertoire).max())]
    excess = _beyond(motion, stage)
    hit = self_collisions(motion)
    return Quality(
        turning=Beside(_quantile(turned), _quantile(was_turned)),
        turning_over=Beside(_over(turned), _over(was_turned)),
        acceleration=Beside(_quantile(pushed), _quantile(was_pushed)),
        acceleration_over=Beside(_over(pushed), _over(was_pushed)),
        slide=Beside(_quantile(slides, 0.95), _quantile(own.slides, 0.95)),
        slide_worst=Beside(_quantile(slides, 1.0), _quantile(own.slides, 1.0)),
        slides_over=float(np.mean(slides > 0.01)) if len(slides) else 0.0,
        contact_share=Beside(share, float(own.feet[image_all, frame_all].mean())),
        penetration=Beside(sunk, own.penetration),
        distance=Beside(low[0], threshold),
        joint_excess=float(excess.max(initial=0.0)),
        joint_excess_share=float(np.mean((excess > np.deg2rad(1.0)).any(axis=1))),
        collision=Beside(_deepest(hit), own.collision),
        collision_share=Beside(hit.frames / motion.frame_count, own.collision_share),
        lowered=float(performance.lowered.max()),
        contacts=len(slides),
        cuts=len(performance.cuts),
    )


def _yardstick(repertoire: Repertoire) -> _Yardstick:
    stage = Stage.of(repertoire)
    shape = (2, repertoire.frame_count, repertoire.skeleton.joint_count)
    turnings, pushes = np.zeros(shape), np.zeros(shape)
    feet = np.zeros((2, repertoire.frame_count, 2), dtype=np.bool_)
    slides, sunk, hits, deep = [], 0.0, 0, 0.0
    inner = np.zeros(repertoire.frame_count, dtype=np.bool_)
    for k in range(repertoire.recording_count):
        a, b = int(repertoire.starts[k]), int(repertoire.starts[k + 1])
        inner[a + 1 : b - 1] = True
        for strand in (0, 1) if repertoire.mirrored else (0,):
            motion = repertoire.motion(k, strand)
            turnings[strand, a + 1 : b - 1], pushes[strand, a + 1 : b - 1] = _leaps(motion)
            slide, stands, low = _feet(motion, stage)
            feet[strand, a:b] = stands
            slides.append(slide)
            sunk = max(sunk, low)
            hit = self_collisions(motion)
            hits += hit.frames
            deep = max(deep, _deepest(hit))
    strands = (0, 1) if repertoire.mirrored else (0,)
    return _Yardstick(
        _per_joint(turnings[list(strands)][:, inner].reshape(-1, shape[2])),
        _per_joint(pushes[list(strands)][:, inner].reshape(-1, shape[2])),
        turnings,
        pushes,
        np.concatenate(slides),
        feet,
        sunk,
        deep,
        hits / (len(strands) * repertoire.frame_count),
    )


def _per_joint(values: Array) -> Array:
    """99th percentile of each joint; joints that do not move count as the least of those that do."""
    out = np.quantile(values, QUANTILE, axis=0) if len(values) else np.ones(values.shape[1])
    moving = out > 1e-3 * out.max(initial=1e-9)
    return np.where(moving, out, np.inf)


def _leaps(motion: Motion) -> tuple[Array, Array]:
    """Changes of angular velocity (rad/s) and accelerations of places (m/s²), each (frames − 2, joints)."""
    q = motion.rotations
    turned = quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(q[:-1]), q[1:])) * motion.fps
    places = motion.positions()
    return (
        np.linalg.norm(np.diff(turned, axis=0), axis=-1),
        np.linalg.norm(np.diff(places, n=2, axis=0), axis=-1) * motion.fps**2,
    )


def _feet(motion: Motion, stage: Stage) -> tuple[Array, Mask, float]:
    """How far each contact slides, when the feet are on the ground, greatest depth below the floor."""
    found = _contacts.contacts(motion, known=stage.soles, ground=Floor(0.0))
    slides = [
        slide(found.positions[a:b, k], found.positions[a:b, k, :, 1] - stage.levels[k])
        for k in (0, 1)
        for a, b in runs(found.feet[:, k])
    ]
    return np.array(slides), found.feet, float(max(0.0, -found.positions[..., 1].min()))


def slide(points: Array, height: Array) -> float:
    """How far the bearing part of a sole goes over the floor during one contact, metres.

    Parameters
    ----------
    points : of the sole, shape (frames, points, 3).
    height : above where each usually bears, shape (frames, points): the lower, the more it bears.
    """
    if len(points) < 2:
        return 0.0
    middle = 0.5 * (height[1:] + height[:-1])
    share = np.exp(-(middle - middle.min(axis=1, keepdims=True)) / BEARING)
    share /= share.sum(axis=1, keepdims=True)
    steps = np.einsum("fp,fpi->fi", share, np.diff(points[..., [0, 2]], axis=0))
    way = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return float(np.linalg.norm(way[:, None] - way[None], axis=-1).max())


def _nearest(motion: Motion, repertoire: Repertoire) -> Array:
    """D of every frame to the nearest of the recordings, shape (frames,)."""
    own, sources = poses(motion), repertoire.poses
    out = np.empty(len(own))
    for a in range(0, len(own), _BLOCK):
        block = own[a : a + _BLOCK]
        best = distance(block, sources).min(axis=1)
        if repertoire.mirrored:
            best = np.minimum(best, mirror_distance(block, sources).min(axis=1))
        out[a : a + _BLOCK] = best
    return out


def _beyond(motion: Motion, stage: Stage) -> Array:
    """Radians by which each joint but those the body hangs on is beyond its range, shape (frames, joints)."""
    vectors = quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(stage.middle), motion.rotations))
    out = np.maximum(np.maximum(stage.low - vectors, vectors - stage.high), 0.0).max(axis=-1)
    out[:, : stage.carrier + 1] = 0.0
    return np.asarray(out)


def _deepest(found: object) -> float:
    hits = getattr(found, "collisions", ())
    return float(hits[0].worst_depth) if hits else DEPTH_TOLERANCE * 0.0


def _over(shares: Array) -> float:
    return float(np.mean(shares > 1.0)) if shares.size else 0.0


def _quantile(values: Array, q: float = QUANTILE) -> float:
    return float(np.quantile(values, q)) if np.size(values) else 0.0
