"""What is measured once on a repertoire before anything is performed from it, and what performing it at once and live share.

`Stage` holds the soles and the legs, how quickly joints are accelerated and how far they go: the yardsticks of a performance
([Schultz2012] §2.9: Cfree). Beside it stand the seam of a cut, the share that each part of a sole bears, and how firmly a foot
is held around a contact.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import contacts as _contacts
from kinesics.body import kinematics
from kinesics.body.capsules import Capsules
from kinesics.body.contacts import Floor, Soles
from kinesics.body.motion import Motion
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import blending, footing, inverse_kinematics
from kinesics.synthesis.embodiment.inverse_kinematics import Legs
from kinesics.synthesis.paths.meeting import soles_of
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

YARDSTICK: Final = 0.99
"""Quantile of the recordings' own accelerations that a transition may not exceed."""
LEAST_TURNING: Final = 1.0
"""rad/s²: legs that stand perfectly still in the recordings may yet be turned by so much; nobody sees it."""
LEAST_BODY: Final = 0.1
"""m/s²: the same of the body."""
REACH: Final = 1.0 / 30.0
"""Seconds to either side over which velocities and accelerations are taken: from frame to frame they would be the tremble of the
markers."""
SPARED: Final = 0.5
"""Share of that acceleration which the transition may add to the recordings' own."""
BEARING: Final = 0.008
"""Metres: a point of the sole this much above the lowest bears e times less."""
RELEASE: Final = 0.07
"""Seconds before and after a contact over which the foot is let go."""
_MARGIN: Final = 0.25
"""Share of such times for which the foot is still held as if it bore: no rule tells the very frame of its lifting."""
LIFT: Final = 0.015
"""Seconds before and after a contact over which the sole comes down to the floor."""
SOFTLY: Final = 0.05
"""Seconds before and after over which the height of a foot is corrected: less than a step, more than a marker's tremble."""
SUNK: Final = 0.007
"""Metres below the floor that are let pass: a sole gives way."""
SINK: Final = 0.15
"""Seconds before and after over which the pelvis gives way where a leg cannot reach."""
FLESH: Final = 0.003
"""Metres that limbs may press deeper into each other than they do in the recordings: a seventh of what flesh gives way by
(`kinesics.body.capsules.DEPTH_TOLERANCE`)."""


@dataclass(frozen=True, eq=False)
class Stage:
    """What is measured once on a repertoire: soles, legs, how quick its joints are and how far they go."""

    repertoire: Repertoire
    legs: Legs
    lower: Indices
    """Joints of legs and soles: all that matters as feet are planted."""
    soles: Soles
    levels: Array
    """Height above the floor at which each point of the soles usually bears, metres, shape (2, 3)."""
    slow: float
    """Speed below which a sole begins to bear, m/s."""
    stature: float
    """Metres."""
    accelerations: Array
    """99th percentile for each joint (rad/s²) and, last, for the root's place (m/s²), shape (joints + 1,)."""
    places: Array
    """The same of the joints' places (m/s²), shape (joints,)."""
    blended: Indices
    """Joints that set the length of a transition: those of the body, not fingers or toes; and the root's place."""
    middle: Array
    """Mean rotation of each joint over all recordings and mirror images, shape (joints, 4)."""
    carrier: int
    """Joint that the body hangs on: the root, or the pelvis where the root joint does nothing but stand beneath it."""
    trunk: tuple[int, ...]
    """Joints that hang on it and bear no leg."""
    low: Array
    """Least and greatest component of the rotation vector of each joint from its mean, radians, shape (joints, 3)."""
    high: Array
    usual: footing.Usual
    """Accelerations of the legs and the body."""
    capsules: Capsules
    deepest: Array
    """Metres that each pair of the capsules passes into each other in the recordings, mirrored counted; 0 if never."""

    @classmethod
    def of(cls, repertoire: Repertoire) -> Stage:
        """Of a repertoire; measured once and kept as long as the repertoire is.

        Raises
        ------
        SkeletonError
            If the skeleton's legs have no feet.
        """
        return repertoire.kept(cls._measured)

    @classmethod
    def _measured(cls, repertoire: Repertoire) -> Stage:
        skeleton, fps = repertoire.skeleton, repertoire.fps
        whole = Motion(skeleton, repertoire.rotations[0], repertoire.root_positions[0], fps)
        found = _contacts.contacts(whole, ground=Floor(0.0), known=soles_of(repertoire))
        legs = inverse_kinematics.legs(skeleton, repertoire.rotations[0][:: max(1, repertoire.frame_count // 4000)])
        carrier = _carrier(repertoire)
        strands = (0, 1) if repertoire.mirrored else (0,)
        rotations = repertoire.rotations[list(strands)]
        accelerations = np.full(skeleton.joint_count + 1, 1e-6)
        places = np.full(skeleton.joint_count, 1e-6)
        w = frames_of_reach(fps)
        inside = _inner(repertoire, w)
        if len(inside):
            seconds = w / fps
            at = rotations[:, inside]
            before = blending.rotation_offset(rotations[:, inside - w], at)
            after = blending.rotation_offset(at, rotations[:, inside + w])
            change = np.linalg.norm(after - before, axis=-1) / seconds**2
            accelerations[:-1] = np.quantile(change.reshape(-1, skeleton.joint_count), YARDSTICK, axis=0)
            place = repertoire.root_positions[0]
            change = place[inside + w] - 2.0 * place[inside] + place[inside - w]
            accelerations[-1] = np.quantile(np.linalg.norm(change, axis=-1), YARDSTICK) / seconds**2
            np.maximum(accelerations, 1e-6, out=accelerations)  # legs of a performed body may not move at all
        middle = np.empty((skeleton.joint_count, 4))
        flat = rotations.reshape(-1, skeleton.joint_count, 4)
        middle[:] = quaternion.mean(flat[:: max(1, len(flat) // 4000)])
        vectors = blending.rotation_offset(middle, flat)
        levels = 0.5 * (found.levels + found.levels[::-1])
        capsules = Capsules.of(whole)
        deepest = np.zeros(len(capsules.pairs))
        pushed: list[Array] = []
        for strand in strands:
            known = kinematics.forward(skeleton, repertoire.rotations[strand], repertoire.root_positions[strand])
            at = known.positions
            pushed.append(_length(at[inside + w] - 2.0 * at[inside] + at[inside - w]) * (fps / w) ** 2)
            deepest = np.maximum(deepest, capsules.depths(*known).max(axis=0, initial=0.0))
        if len(inside):
            np.maximum(np.quantile(np.concatenate(pushed), YARDSTICK, axis=0), places, out=places)
        return cls(
            repertoire,
            legs,
            np.unique([*legs.femurs, *legs.tibias, *legs.feet, *found.soles.joints.ravel()]),
            found.soles,
            levels,
            found.slow,
            found.stature,
            accelerations,
            places,
            _body_joints(repertoire),
            middle,
            carrier,
            _trunk(repertoire, carrier, legs),
            vectors.min(axis=0),
            vectors.max(axis=0),
            footing.Usual(
                np.maximum(accelerations[list(legs.femurs)], LEAST_TURNING),
                np.maximum(accelerations[list(legs.tibias)], LEAST_TURNING),
                max(float(accelerations[-1]), LEAST_BODY),
            ),
            capsules,
            deepest,
        )


def frames_of_reach(fps: float) -> int:
    """Frames before and after a moment over which it is told how quick joints are there."""
    return max(1, round(REACH * fps))


def _inner(repertoire: Repertoire, reach: int) -> Indices:
    """Frames that have ``reach`` frames of their own recording before and behind them."""
    inside = np.zeros(repertoire.frame_count, dtype=np.bool_)
    for a, b in itertools.pairwise(repertoire.starts.tolist()):
        inside[a + reach : max(a, b - reach)] = True
    return np.nonzero(inside)[0]


def _carrier(repertoire: Repertoire) -> int:
    """The pelvis, if nothing else hangs on the joints above it; else the root."""
    skeleton = repertoire.skeleton
    assert skeleton.anatomy is not None
    joint = pelvis = skeleton.anatomy.pelvis
    while joint > 0:
        joint = skeleton.parents[joint]
        if len(skeleton.children[joint]) > 1:
            return 0
    return pelvis


def _trunk(repertoire: Repertoire, carrier: int, legs: Legs) -> tuple[int, ...]:
    """Joints that hang on the carrier and bear no leg."""
    skeleton = repertoire.skeleton
    bears = set()
    for joint in legs.femurs:
        while joint >= 0 and joint != carrier:
            bears.add(joint)
            joint = skeleton.parents[joint]
    return tuple(j for j in skeleton.children[carrier] if j not in bears)


def _body_joints(repertoire: Repertoire) -> Indices:
    """Joints that carry the 15 links, and number ``joint_count`` for the root's place."""
    skeleton = repertoire.skeleton
    assert skeleton.anatomy is not None
    roles = skeleton.anatomy.roles
    joints = {0, roles.pelvis, *roles.spine, *roles.neck, roles.head}
    for side in ("left", "right"):
        joints |= {getattr(roles, f"{side}_{part}") for part in ("femur", "tibia", "humerus", "radius")}
    return np.array([*sorted(joints), skeleton.joint_count], dtype=np.intp)


def turn_bodies(repertoire: Repertoire, carrier: int, rotations: Array, yaw: Array) -> None:
    """Turn bodies (frames, joints, 4) about the vertical, in place, by turning the joint that they hang on."""
    turn = about_y(yaw)
    above: Array | None = None
    joint = carrier
    while joint > 0:
        joint = repertoire.skeleton.parents[joint]
        own = rotations[:, joint]
        above = own if above is None else quaternion.multiply(own, above)
    if above is not None:
        turn = quaternion.multiply(quaternion.conjugate(above), quaternion.multiply(turn, above))
    rotations[:, carrier] = quaternion.multiply(turn, rotations[:, carrier])


def about_y(yaw: Array) -> Array:
    """Turns about the vertical by ``yaw`` radians, shape (...) to (..., 4)."""
    half = 0.5 * np.asarray(yaw)
    zero = np.zeros_like(half)
    return np.stack([np.cos(half), zero, np.sin(half), zero], axis=-1)


class Seams(NamedTuple):
    """By how much what is entered differs from what is left, at every cut."""

    offsets: Array
    """Of joints and (last) the root's place: shape (cuts, joints + 1, 3)."""
    velocities: Array
    """What they change by in a second."""
    places: Array
    """Of the joints' places in the world, metres, shape (cuts, joints, 3)."""
    moving: Array
    """What they change by in a second."""


def seams(
    repertoire: Repertoire,
    carrier: int,
    left: Indices,
    left_yaw: Array,
    entered: Indices,
    entered_yaw: Array,
    aside: Array,
) -> Seams:
    """Offsets of what is entered from what is left, and how quickly they change.

    Parameters
    ----------
    left, entered : moments, those left as their recordings would have gone on, shape (cuts,).
    left_yaw, entered_yaw : by which each is turned, radians.
    aside : by which the root of what is entered lies beside that of what is left, in the world: x, z, metres, shape (cuts, 2).
    """
    reach = frames_of_reach(repertoire.fps)
    around = np.array([[-reach], [0], [reach]])
    sides = np.stack([left, entered])
    moments = repertoire.advance(sides[None], around[..., None])
    there = np.asarray((moments >= 0).all(axis=1))
    moments = np.where(there[:, None], moments, sides)
    yaw = np.broadcast_to(np.stack([left_yaw, entered_yaw]), moments.shape).ravel()
    q, roots = repertoire.rotations_of(moments.ravel()), repertoire.roots_of(moments.ravel())
    turn_bodies(repertoire, carrier, q, yaw)
    roots = quaternion.rotate(about_y(yaw), roots)
    body = kinematics.forward(repertoire.skeleton, q, roots).positions
    q, place, body = (v.reshape(*moments.shape, *v.shape[1:]) for v in (q, roots, body))
    turned = blending.rotation_offset(q[:, 0], q[:, 1])
    before, now, after = np.concatenate([turned, (place[:, 1] - place[:, 0])[:, :, None]], axis=2)
    span = reach * (there[0].astype(np.float64) + there[2].astype(np.float64))[:, None, None]
    fps = repertoire.fps
    # a rotation vector leaps where it passes half a turn; such an offset has no velocity that could be told
    change = after - before
    velocity = np.where(span > 0.0, change / np.maximum(span, 1.0) * fps, 0.0)
    velocity = np.where(np.linalg.norm(change, axis=-1, keepdims=True) < 2.0, velocity, 0.0)
    away = body[:, 1] - body[:, 0]
    moving = np.where(span > 0.0, (away[2] - away[0]) / np.maximum(span, 1.0) * fps, 0.0)
    now, apart = now.copy(), away[1] - now[:, -1:]
    now[:, -1, [0, 2]] = aside
    return Seams(now, velocity, apart + now[:, -1:], moving)


def bearing(height: Array) -> Array:
    """Share of the weight that each point of a sole bears, by its height: shape (..., points) to the same, sum 1."""
    # over as short an axis NumPy reduces ten times more slowly
    least = functools.reduce(np.minimum, np.moveaxis(height, -1, 0))
    weight = np.exp((least[..., None] - height) / BEARING)
    return np.asarray(weight / functools.reduce(np.add, np.moveaxis(weight, -1, 0))[..., None])


def held_around(standing: Mask, reach: float) -> Array:
    """1 while a foot bears, going to 0 smoothly over ``reach`` frames before and after."""
    from scipy.ndimage import distance_transform_edt

    if standing.all() or not standing.any():
        return standing.astype(np.float64)
    away = np.asarray(distance_transform_edt(~standing))
    return 1.0 - blending.ease((away - _MARGIN * reach) / ((1.0 - _MARGIN) * reach + 1.0))


def shortfall(stage: Stage, positions: Array, targets: Array) -> Array:
    """How far each hip must come down for its leg to reach, metres, shape (frames, 2)."""
    legs = stage.legs
    hips, knees, ankles = (positions[:, list(joints)] for joints in (legs.femurs, legs.tibias, legs.feet))
    length, now = _length(knees - hips) + _length(ankles - knees), _length(ankles - hips)
    most = np.minimum(np.maximum(now, inverse_kinematics.SOFT * length), inverse_kinematics.STRAIGHTEST * length)
    away = targets - hips
    flat = away[..., 0] ** 2 + away[..., 2] ** 2
    return np.asarray(np.maximum(-away[..., 1] - np.sqrt(np.maximum(most**2 - flat, 0.0)), 0.0))


def _length(v: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", v, v)))
