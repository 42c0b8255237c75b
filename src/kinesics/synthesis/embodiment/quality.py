"""How good a performance is, with the recordings it was made from as the yardstick.

Nothing here knows how a performance was made: its motion is measured as a recording would be, and each figure stands
beside the same figure of the recordings. Contacts are found anew by `kinesics.body.contacts`, not taken from the performer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import contacts as _contacts
from kinesics.body.contacts import Floor, runs
from kinesics.body.motion import Motion
from kinesics.body.pose import poses
from kinesics.body.touching import speeds_of
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment.checking import ROUNDING, SLIDE, beyond, farthest, nearest, slide
from kinesics.synthesis.embodiment.rendering import Performance
from kinesics.synthesis.embodiment.stage import FLESH, LEAST_BODY, LEAST_TURNING, Stage
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

QUANTILE: Final = 0.99
DOWN: Final = 0.015
"""Metres above the level at which a point of the sole usually bears."""
STILL: Final = 0.25
"""m/s."""
AWHILE: Final = 0.1
"""Seconds."""


class Beside(NamedTuple):
    """A figure of the performance beside that of the recordings."""

    performance: float
    recordings: float


@dataclass(frozen=True)
class Quality:
    """Measures of a performance beside its recordings."""

    turning: Beside
    """Leaps of angular velocity from frame to frame, per joint as a share of the recordings' 99th percentile: the 99th
    percentile over joints and frames of transitions; and of the same moments as they were recorded. Joints that hardly move there
    are measured by what nobody sees (`LEAST_TURNING`, of places `LEAST_BODY`)."""
    turning_over: Beside
    """Share of them that are beyond the recordings' 99th percentile, which is .01 over all that was recorded."""
    turning_added: float
    """What performing adds: the difference, as a vector in the frame of the joint, of each leap from that of the same moment
    as recorded; again the 99th percentile over joints and frames of transitions of its share of the recordings' 99th."""
    acceleration: Beside
    """The same of the accelerations of the joints' places."""
    acceleration_over: Beside
    acceleration_added: float
    """Vectors as seen from the heading."""
    slide: Beside
    """Metres that the point a foot stands on (`pivots`) goes over the floor in one contact: the 95th percentile of contacts."""
    slide_worst: Beside
    slides_over: Beside
    """Share of the contacts that slide more than 1 cm."""
    shift: Beside
    """Metres that heel or ball goes over the floor while it is firmly down, as anyone would see it: nearer to the floor than
    `DOWN` and slower than `STILL` for at least `AWHILE`. The 90th percentile of such times."""
    shifts_over: Beside
    """Share of them with more than 1 cm. Whoever pivots on a ball takes the heel along."""
    contact_share: Beside
    """Share of time that a foot is on the ground, mean of both."""
    touches: float
    """Share of the contacts, no part of which is one in what is played."""
    penetration: Beside
    """Metres that a heel or toe goes below the floor at worst."""
    distance: Beside
    """D of a frame to the nearest frame of the recordings, mirrored counted, at worst; and the largest accepted at a
    transition."""
    joint_excess: float
    """Radians by which a joint goes beyond its range in the recordings, mirrored counted, at worst."""
    joint_excess_share: float
    """Share of frames in which any joint does by more than rounding (`checking.ROUNDING`)."""
    collision: float
    """Metres by which two parts of the body pass deeper into each other than the same two ever do in the recordings."""
    collision_share: float
    """Share of frames in which any do by more than `FLESH`."""
    lowered: float
    """Metres that the pelvis was lowered at worst."""
    contacts: int
    cuts: int


class _Leaps(NamedTuple):
    """Changes of angular velocity in the joints' frames, rad/s, and accelerations of their places as seen from the heading,
    m/s², of all frames but the first and the last: shape (frames − 2, joints, 3) each."""

    turning: Array
    acceleration: Array


@dataclass(frozen=True, eq=False)
class _Yardstick:
    turning: Array
    """What is usual of each joint, see `_per_joint`."""
    acceleration: Array
    leaps: _Leaps
    """Of every frame and its mirror image, shape (2, frames, joints, 3); forwards."""
    slides: Array
    shifts: Array
    feet: Mask
    """Shape (2, frames, 2)."""
    penetration: float


def measure(performance: Performance, repertoire: Repertoire, *, threshold: float = np.nan) -> Quality:
    """Measure a performance against its recordings.

    Parameters
    ----------
    threshold : largest D accepted at a transition (`Network.threshold`).
    """
    own = repertoire.kept(_yardstick)
    motion, stage = performance.motion, Stage.of(repertoire)
    came = performance.provenance
    frame, image = repertoire.frame_of(came.moment), came.mirrored.astype(np.intp)
    leaps = _leaps(motion)
    at = np.flatnonzero(came.transition[1:-1])
    # the same moments as they were recorded; played backwards a velocity is reversed, and so is its change in time: twice
    recorded = _Leaps(*(values[image[at + 1], frame[at + 1]] for values in own.leaps))
    turned, was_turned, turn_added = _shares(leaps.turning[at], recorded.turning, own.turning)
    pushed, was_pushed, push_added = _shares(leaps.acceleration[at], recorded.acceleration, own.acceleration)
    slides, shifts, feet, sunk = _feet(motion, stage)
    played = own.feet[image, frame]
    excess = beyond(motion, stage)
    deep = stage.capsules.depths(motion.positions(), motion.global_rotations()) - stage.deepest
    spans = [(k, a, b) for k in (0, 1) for a, b in runs(feet[:, k])]
    return Quality(
        turning=Beside(_quantile(turned), _quantile(was_turned)),
        turning_over=Beside(_over(turned), _over(was_turned)),
        turning_added=_quantile(turn_added),
        acceleration=Beside(_quantile(pushed), _quantile(was_pushed)),
        acceleration_over=Beside(_over(pushed), _over(was_pushed)),
        acceleration_added=_quantile(push_added),
        slide=Beside(_quantile(slides, 0.95), _quantile(own.slides, 0.95)),
        slide_worst=Beside(_quantile(slides, 1.0), _quantile(own.slides, 1.0)),
        slides_over=Beside(_over(slides / SLIDE), _over(own.slides / SLIDE)),
        shift=Beside(_quantile(shifts, 0.9), _quantile(own.shifts, 0.9)),
        shifts_over=Beside(_over(shifts / SLIDE), _over(own.shifts / SLIDE)),
        contact_share=Beside(float(feet.mean()), float(played.mean())),
        touches=float(np.mean([not played[a:b, k].any() for k, a, b in spans])) if spans else 0.0,
        penetration=Beside(sunk, own.penetration),
        distance=Beside(float(nearest(poses(motion), repertoire).max()), threshold),
        joint_excess=float(excess.max(initial=0.0)),
        joint_excess_share=float(np.mean((excess > ROUNDING).any(axis=1))),
        collision=float(max(0.0, deep.max(initial=0.0))),
        collision_share=float(np.mean((deep > FLESH).any(axis=1))),
        lowered=float(performance.lowered.max()),
        contacts=len(slides),
        cuts=len(performance.cuts),
    )


def _shares(values: Array, recorded: Array, usual: Array) -> tuple[Array, Array, Array]:
    """Sizes of vectors (n, joints, 3), of the recorded ones and of their difference, as shares of what is usual (joints,)."""
    sizes = (np.linalg.norm(v, axis=-1) / usual for v in (values, recorded, values - recorded))
    a, b, c = sizes
    return a, b, c


def _yardstick(repertoire: Repertoire) -> _Yardstick:
    stage = Stage.of(repertoire)
    shape = (2, repertoire.frame_count, repertoire.skeleton.joint_count, 3)
    turnings, pushes = np.zeros(shape), np.zeros(shape)
    feet = np.zeros((2, repertoire.frame_count, 2), dtype=np.bool_)
    slides, shifts, sunk = [], [], 0.0
    inner = np.zeros(repertoire.frame_count, dtype=np.bool_)
    strands = (0, 1) if repertoire.mirrored else (0,)
    for k in range(repertoire.recording_count):
        a, b = int(repertoire.starts[k]), int(repertoire.starts[k + 1])
        inner[a + 1 : b - 1] = True
        for strand in strands:
            motion = repertoire.motion(k, strand)
            turnings[strand, a + 1 : b - 1], pushes[strand, a + 1 : b - 1] = _leaps(motion)
            slid, shifted, stands, low = _feet(motion, stage)
            feet[strand, a:b] = stands
            slides.append(slid)
            shifts.append(shifted)
            sunk = max(sunk, low)
    turning, pushing = (
        _per_joint(np.linalg.norm(v[list(strands)][:, inner], axis=-1).reshape(-1, shape[2]), least)
        for v, least in ((turnings, LEAST_TURNING / repertoire.fps), (pushes, LEAST_BODY))
    )
    return _Yardstick(
        turning, pushing, _Leaps(turnings, pushes), np.concatenate(slides), np.concatenate(shifts), feet, sunk
    )


def _per_joint(values: Array, least: float) -> Array:
    """99th percentile of each joint, but no less than nobody sees: fingers, for one, that hardly move as they were recorded.

    Parameters
    ----------
    values : of every frame and joint, shape (n, joints).
    least : `LEAST_TURNING` for the time of a frame, rad/s, or `LEAST_BODY`, m/s².
    """
    usual = np.quantile(values, QUANTILE, axis=0) if len(values) else np.zeros(values.shape[1])
    return np.maximum(usual, least)


def _leaps(motion: Motion) -> _Leaps:
    q = motion.rotations
    turned = quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(q[:-1]), q[1:])) * motion.fps
    pushed = np.diff(motion.positions(), n=2, axis=0) * motion.fps**2
    yaw = poses(motion).yaw[1:-1, None]
    sine, cosine = np.sin(yaw), np.cos(yaw)
    x, y, z = np.moveaxis(pushed, -1, 0)
    return _Leaps(np.diff(turned, axis=0), np.stack([cosine * x - sine * z, y, sine * x + cosine * z], axis=-1))


def _feet(motion: Motion, stage: Stage) -> tuple[Array, Array, Mask, float]:
    """How far each contact slides and each heel or ball shifts, when the feet are on the ground, greatest depth below the floor."""
    found = _contacts.contacts(motion, known=stage.soles, ground=Floor(0.0), slow=stage.slow)
    slides = [
        slide(found.positions[a:b, k], found.positions[a:b, k, :, 1] - stage.levels[k], motion.fps)
        for k in (0, 1)
        for a, b in runs(found.feet[:, k])
    ]
    places = found.positions[:, :, :2]
    shifts = shifted(places, places[..., 1] - stage.levels[:, :2], motion.fps)
    return np.array(slides), shifts, found.feet, float(max(0.0, -found.positions[..., 1].min()))


def shifted(places: Array, height: Array, fps: float) -> Array:
    """How far points go over the floor while they are firmly down, metres, shape (times,): see `Quality.shift`.

    Parameters
    ----------
    places : in the world, metres, shape (frames, feet, points, 3).
    height : above where each usually bears, shape (frames, feet, points).
    """
    flat = places.reshape(len(places), -1, 3)
    down = (height.reshape(len(flat), -1) < DOWN) & (speeds_of(flat, fps) < STILL)
    spans = [(n, a, b) for n in range(flat.shape[1]) for a, b in runs(down[:, n]) if b - a >= AWHILE * fps]
    return np.array([farthest(flat[a:b, n][:, [0, 2]]) for n, a, b in spans])


def _over(shares: Array) -> float:
    return float(np.mean(shares > 1.0)) if shares.size else 0.0


def _quantile(values: Array, q: float = QUANTILE) -> float:
    return float(np.quantile(values, q)) if np.size(values) else 0.0
