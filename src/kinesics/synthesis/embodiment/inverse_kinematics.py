"""Legs that reach: the hip, knee and ankle rotations that put an ankle at a given place ([Schultz2012] §2.6, turned round).

A leg is two bones with a hinge between them, so the answer is exact and needs no iteration (Kovar, Schreiner & Gleicher
2002, *Footskate Cleanup for Motion Capture Editing*, §4.3): the knee is bent until the ankle is as far from the hip as the
target is, then the whole leg is swung at the hip, by the least rotation, until the ankle is there. The foot keeps its
orientation in the world. Joints between hip and knee or knee and ankle (twist joints) stay as they are.

Near full extension a small change of distance would need a large one of the knee. From `SOFT` of the leg's length on the
distance is given less and less of what is asked, so that the knee never snaps (their §4.4, with a limit that is never
reached in place of one that is cut); a leg that already is straighter than that counts from where it is, so that nothing
changes where nothing is asked.

`reach` does it for all frames of a performance together, compiled where that was built, `turns` for one leg at one moment, live:
the same in plain numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.body import kinematics
from kinesics.body.kinematics import Kinematics
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError, SkeletonError
from kinesics.geometry import quaternion, single
from kinesics.geometry.single import Quaternion, Vector

Array = NDArray[np.float64]

SOFT: Final = 0.985
"""Share of the leg's length, hip to ankle, up to which a target is reached exactly; the knee is then bent by 20°."""
STRAIGHTEST: Final = 0.9999
"""Share of the leg's length that no target takes it beyond."""
_HINGE_SHARE: Final = 0.8
"""Share of a knee's turning that must go about one axis for that axis to be its hinge."""
_HINGE_SWING: Final = np.deg2rad(5.0)
"""Standard deviation that a knee must turn by for its axis to be told."""
_NEXT: Final = [1, 2, 0]
_LAST: Final = [2, 0, 1]
BACKWARD_KNEE: Final = -0.15
"""Radians: knees that bend the wrong way by more are taken to be meant."""
_NO_TURN: Final[Quaternion] = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Legs:
    """The joints of both legs, left and right."""

    femurs: tuple[int, int]
    tibias: tuple[int, int]
    feet: tuple[int, int]
    hinges: Array
    """The knee's axis in the frame of the tibia, unit vectors, shape (2, 3): the knee bends by positive turns about it."""


class Reached(NamedTuple):
    """Legs after they reached."""

    rotations: Array
    """Of all joints relative to their parents, shape (frames, joints, 4)."""
    misses: Array
    """Metres by which each ankle falls short of its target, shape (frames, 2)."""


def legs(skeleton: Skeleton, rotations: Array | None = None) -> Legs:
    """The legs of a skeleton that carries its anatomy.

    Parameters
    ----------
    rotations : of all joints relative to their parents in recordings, shape (frames, joints, 4): the axis about which a knee
        turns in them is its hinge. Without, and where a knee hardly turns, it is the left-right axis of the anatomy.

    Raises
    ------
    SkeletonError
        If it carries none, has no ankles, or a leg's bones have no length.
    """
    body = skeleton.anatomy
    if body is None:
        raise SkeletonError("The skeleton does not carry its anatomy: take that of `kinesics.body.anatomy.understood`.")
    found: dict[str, list[int]] = {part: [] for part in ("femur", "tibia", "foot")}
    for side in ("left", "right"):
        for part, joints in found.items():
            joint = getattr(body.roles, f"{side}_{part}")
            if joint is None:
                raise SkeletonError(
                    f"The {side} leg has no ankle joint, so that its foot cannot be kept in place.",
                    missing=(f"{side}_{part}",),
                )
            joints.append(joint)
        for upper, lower in ((found["femur"], found["tibia"]), (found["tibia"], found["foot"])):
            chain = _chain(skeleton, upper[-1], lower[-1])
            if sum(float(np.linalg.norm(skeleton.offsets[j])) for j in chain) < 1e-9:
                raise SkeletonError(
                    f"Joints '{skeleton.joint_names[upper[-1]]}' and '{skeleton.joint_names[lower[-1]]}' lie at one place: "
                    "a leg without length reaches nothing."
                )
    tibias = found["tibia"]
    hinges = quaternion.rotate(body.frames[tibias], np.array([1.0, 0.0, 0.0]))
    if rotations is not None:
        hinges = np.stack([_hinge(rotations[:, j], axis) for j, axis in zip(tibias, hinges, strict=True)])
    return Legs(
        (found["femur"][0], found["femur"][1]), (tibias[0], tibias[1]), (found["foot"][0], found["foot"][1]), hinges
    )


def _hinge(knee: Array, anatomical: Array) -> Array:
    """The axis that a knee turns about, shape (frames, 4) to (3,): the first principal axis of its rotation vectors."""
    vectors = quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(quaternion.mean(knee)), knee))
    spread, axes = np.linalg.eigh(np.cov(vectors.T))
    axis = axes[:, -1] * (1.0 if axes[:, -1] @ anatomical >= 0.0 else -1.0)
    told = spread[-1] > _HINGE_SWING**2 and spread[-1] > _HINGE_SHARE * spread.sum() and axis @ anatomical > 0.7
    return np.asarray(axis if told else anatomical)


def reach(
    skeleton: Skeleton,
    rotations: Array,
    root_positions: Array,
    targets: Array,
    *,
    limbs: Legs | None = None,
    known: Kinematics | None = None,
) -> Reached:
    """Put the ankles at their targets, feet oriented in the world as they were.

    Parameters
    ----------
    rotations : relative to the parents, unit quaternions, shape (frames, joints, 4).
    root_positions : metres, shape (frames, 3).
    targets : of the left and right ankle in the world, metres, shape (frames, 2, 3).
    limbs : the legs, where known; else those of the skeleton's anatomy.
    known : forward kinematics of these rotations, where known.

    Raises
    ------
    InputError
        If shapes disagree or a target is not finite.
    SkeletonError
        As `legs`.
    """
    limbs = legs(skeleton) if limbs is None else limbs
    if targets.shape != (len(rotations), 2, 3) or not np.isfinite(targets).all():
        raise InputError(f"Expected finite `targets` of shape ({len(rotations)}, 2, 3), got {targets.shape}.")
    where, world = kinematics.forward(skeleton, rotations, root_positions) if known is None else known
    if compiled.wanted():
        return _quickly(skeleton, rotations, where, world, targets, limbs)
    femurs, tibias, feet = list(limbs.femurs), list(limbs.tibias), list(limbs.feet)
    hip, knee, ankle = where[:, femurs], where[:, tibias], where[:, feet]
    bend, swing, wanted = _bend_and_swing(hip, knee, ankle, targets, quaternion.rotate(world[:, tibias], limbs.hinges))
    out = rotations.copy()
    joints = [*femurs, *tibias, *feet]
    lower = quaternion.multiply(swing, bend)
    still = np.zeros_like(swing)
    still[..., 0] = 1.0
    # each is the old world orientation, turned, seen from its parent, turned or not
    own = quaternion.multiply(np.concatenate([swing, lower, still], axis=1), world[:, joints])
    above = world[:, [skeleton.parents[j] for j in joints]]
    out[:, joints] = _local(quaternion.multiply(np.concatenate([still, swing, lower], axis=1), above), own)
    return Reached(out, wanted)


def _quickly(skeleton: Skeleton, rotations: Array, where: Array, world: Array, targets: Array, limbs: Legs) -> Reached:
    chains = zip(limbs.femurs, limbs.tibias, limbs.feet, strict=True)
    joints = np.array([[*chain, *(skeleton.parents[j] for j in chain)] for chain in chains], dtype=np.int32)
    out, misses = np.array(rotations, dtype=np.float64, order="C"), np.empty((len(rotations), 2))
    compiled.native.reach_legs(
        np.ascontiguousarray(where),
        np.ascontiguousarray(world),
        np.ascontiguousarray(targets, dtype=np.float64),
        joints,
        np.ascontiguousarray(limbs.hinges),
        SOFT,
        STRAIGHTEST,
        BACKWARD_KNEE,
        out,
        misses,
    )
    return Reached(out, misses)


def _bend_and_swing(hip: Array, knee: Array, ankle: Array, target: Array, hinge: Array) -> tuple[Array, Array, Array]:
    """Turns in the world of what hangs on the knee, then of the whole leg; and by how much the target is missed.

    Shapes (..., 3) to (..., 4), (..., 4), (...).
    """
    upper, lower = knee - hip, ankle - knee
    l1, l2 = _length(upper), _length(lower)
    u, v = upper / l1[..., None], lower / l2[..., None]
    now, asked = _length(ankle - hip), _length(target - hip)
    far = softened(asked, now, l1 + l2)
    far = np.maximum(far, np.abs(l1 - l2) + 1e-4 * (l1 + l2))
    far = np.where(asked == now, now, far)
    axis = hinge
    # u·(v turned by Δ about the axis) = a cos Δ + b sin Δ + c must become what the law of cosines asks of it
    along_u, along_v = np.sum(axis * u, axis=-1), np.sum(axis * v, axis=-1)
    c = along_u * along_v
    cosine = np.sum(u * v, axis=-1)
    a, b = cosine - c, np.sum(u * _cross(axis, v), axis=-1)
    size = np.hypot(a, b)
    wanted = (far**2 - l1**2 - l2**2) / (2.0 * l1 * l2)
    bent = -np.arctan2(b, a)
    # where a bone lies along the hinge, turning about it changes nothing
    turns = size > 1e-12
    angle = np.arccos(np.clip((wanted - c) / np.where(turns, size, 1.0), -1.0, 1.0)) - np.abs(bent)
    angle = np.where(bent < BACKWARD_KNEE, -angle, angle)
    angle = np.where(turns & (asked != now), angle, 0.0)
    half = 0.5 * angle[..., None]
    bend = np.concatenate([np.cos(half), np.sin(half) * axis], axis=-1)
    reached = upper + quaternion.rotate(bend, lower)
    swing = _between(reached, target - hip)
    return bend, swing, np.abs(_length(reached) - asked)


def turns(hip: Vector, knee: Vector, ankle: Vector, target: Vector, hinge: Vector) -> tuple[Quaternion, Quaternion]:
    """Turns in the world of what hangs on the knee, then of the whole leg, that put one ankle at its target.

    Parameters
    ----------
    hip, knee, ankle, target : in the world, metres.
    hinge : the knee's axis in the world, of length 1.
    """
    upper, lower, aim = single.subtract(knee, hip), single.subtract(ankle, knee), single.subtract(target, hip)
    l1, l2 = single.length(upper), single.length(lower)
    now, asked = single.length(single.subtract(ankle, hip)), single.length(aim)
    if asked == now:
        return _NO_TURN, single.least_turn(single.add(upper, lower), aim)
    far = max(_softened_once(asked, now, l1 + l2), abs(l1 - l2) + 1e-4 * (l1 + l2))
    # see `_bend_and_swing`
    scale = 1.0 / (l1 * l2)
    c = single.dot(hinge, upper) * single.dot(hinge, lower) * scale
    a, b = single.dot(upper, lower) * scale - c, single.dot(upper, single.cross(hinge, lower)) * scale
    size, bent = math.hypot(a, b), -math.atan2(b, a)
    wanted = 0.5 * (far * far - l1 * l1 - l2 * l2) * scale - c
    # where a bone lies along the hinge, turning about it changes nothing
    angle = math.acos(min(max(wanted / size, -1.0), 1.0)) - abs(bent) if size > 1e-12 else 0.0
    if bent < BACKWARD_KNEE:
        angle = -angle
    sine = math.sin(0.5 * angle)
    bend = (math.cos(0.5 * angle), sine * hinge[0], sine * hinge[1], sine * hinge[2])
    return bend, single.least_turn(single.add(upper, single.rotate(bend, lower)), aim)


def _softened_once(asked: float, now: float, length: float) -> float:
    """`softened` of one leg."""
    most = STRAIGHTEST * length
    start = min(max(now, SOFT * length), most - 1e-9 * length)
    if asked <= start:
        return asked
    room = most - start
    return start - room * math.expm1(-(asked - start) / room)


def softened(asked: Array, now: Array, length: Array) -> Array:
    """How far from the hip the ankle goes when so much is asked: all of it up to `SOFT` of the leg, then ever less.

    Parameters
    ----------
    asked, now : distance of target and ankle from the hip, metres.
    length : of the leg when straight, metres.
    """
    most = STRAIGHTEST * length
    start = np.minimum(np.maximum(now, SOFT * length), most - 1e-9 * length)
    room = most - start
    beyond = np.maximum(asked - start, 0.0)
    return np.asarray(np.where(asked <= start, asked, start + room * -np.expm1(-beyond / room)))


def _between(a: Array, b: Array) -> Array:
    """The least rotation from direction a to direction b, none where either has no length."""
    a, b = a / np.maximum(_length(a), 1e-12)[..., None], b / np.maximum(_length(b), 1e-12)[..., None]
    halfway = a + b
    w = 0.5 * _length(halfway)
    safe = w > 1e-9
    vector = _cross(a, halfway) / np.where(safe, 2.0 * w, 1.0)[..., None]
    q = np.concatenate([np.where(safe, w, 1.0)[..., None], np.where(safe[..., None], vector, 0.0)], axis=-1)
    return np.asarray(q / _length(q)[..., None])


def _local(parent: Array, world: Array) -> Array:
    return quaternion.multiply(quaternion.conjugate(parent), world)


def _cross(a: Array, b: Array) -> Array:
    """For few vectors at a time ``np.cross`` takes longer to prepare than to compute."""
    return np.asarray(a[..., _NEXT] * b[..., _LAST] - a[..., _LAST] * b[..., _NEXT])


def _length(v: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", v, v)))


def _chain(skeleton: Skeleton, upper: int, lower: int) -> list[int]:
    """Joints below ``upper`` down to ``lower``."""
    out = []
    while lower != upper:
        out.append(lower)
        lower = skeleton.parents[lower]
        if lower < 0:
            raise SkeletonError("The joints of a leg do not hang on each other.")
    return out
