"""What each vertex of the human figure follows: the joints of the skeleton, and helpers that stand at them.

Where a joint turns far, blending it with its parent makes the flesh collapse, and where it twists, wrings it. So the skin also
follows *helpers*, which stand at a joint and do part of what it does: half of its swing at shoulders, elbows, hips and knees,
its swing with half of its twist along upper arm, forearm and thigh, its twist alone before the wrist (in-betweens of joints: Mohr &
Gleicher, "Building Efficient, Accurate Character Skins from Examples", 2003).
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body.anatomy import Anatomy
from kinesics.body.figure_template import SIDES, Template
from kinesics.body.skeleton import Skeleton
from kinesics.geometry import quaternion

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

MOST_JOINTS: Final = 4
"""That one vertex follows; what glTF holds in one set."""
_HELPERS: Final = (
    ("humerus", "half", 0.5, 0.2, "shoulder", "elbow"),
    ("humerus", "swing", 1.0, 0.5, "shoulder", "elbow"),
    ("radius", "half", 0.5, 0.2, "elbow", "wrist"),
    ("radius", "swing", 1.0, 0.5, "elbow", "wrist"),
    ("hand", "twist", 0.0, 1.0, "elbow", "wrist"),
    ("femur", "half", 0.5, 0.2, "hip", "knee"),
    ("femur", "swing", 1.0, 0.5, "hip", "knee"),
    ("tibia", "half", 0.5, 0.5, "knee", "ankle"),
)
"""Which part's joint, what it is called, its shares of swing and twist, and the landmarks that the bone lies between."""


class Helper(NamedTuple):
    """What stands at a joint and does part of its turn; the joint's sibling, at rest in the binding pose."""

    name: str
    joint: int
    """Which joint it stands at."""
    swing: float
    """Its share of the joint's swing away from the binding pose."""
    twist: float
    """Its share of the joint's twist about the bone, as that lies in the binding pose."""
    axis: Array
    """Of the twist, in the frame of the joint's parent, of length 1, shape (3,)."""


def helpers_of(skeleton: Skeleton, body: Anatomy, world: Array, marks: dict[str, Array]) -> tuple[Helper, ...]:
    """Those that a skeleton has joints for, left ones first; orientations and landmarks are of the binding pose."""
    out: list[Helper] = []
    for side in SIDES:
        for part, kind, swing, twist, start, end in _HELPERS:
            joint = getattr(body.roles, f"{side}_{part}")
            if joint is None:
                continue
            bone = marks[f"{side}_{end}"] - marks[f"{side}_{start}"]
            axis = quaternion.rotate(quaternion.conjugate(world[skeleton.parents[joint]]), bone / np.linalg.norm(bone))
            name = f"{skeleton.joint_names[joint]}_{kind}"
            while name in skeleton.joint_names:
                name += "_"
            out.append(Helper(name, joint, swing, twist, axis))
    return tuple(out)


def swing_and_twist(turn: Array, axis: Array) -> tuple[Array, Array]:
    """Turns, frame after frame, as twists about an axis in radians, and then swings about one across it."""
    twist = np.unwrap(2.0 * np.arctan2(turn[:, 1:] @ axis, turn[:, 0]))
    # most frames within half a turn
    twist -= 2.0 * np.pi * np.round(np.median(twist) / (2.0 * np.pi))
    swing = quaternion.multiply(turn, quaternion.from_axis_angle(axis, -twist))
    return np.where(swing[:, :1] < 0.0, -swing, swing), twist


def share_of(swing: Array, share: float) -> Array:
    """A share of a swing, the shorter way round."""
    if share == 1.0:
        return swing
    sine = np.linalg.norm(swing[:, 1:], axis=1)
    angle = share * np.arctan2(sine, swing[:, 0])
    out = np.empty_like(swing)
    out[:, 0] = np.cos(angle)
    out[:, 1:] = (np.sin(angle) / np.maximum(sine, 1e-12))[:, None] * swing[:, 1:]
    return out


def heaviest(weights: Array) -> tuple[Indices, Array]:
    """The joints and helpers that each vertex follows most, and how much: shapes (vertices, 4), falling, with sum 1."""
    most = np.argpartition(weights, -MOST_JOINTS - 1, axis=1)[:, -MOST_JOINTS - 1 :]
    most.sort(axis=1)
    order = np.take_along_axis(
        most, np.argsort(-np.take_along_axis(weights, most, axis=1), axis=1, kind="stable"), axis=1
    )
    kept, order = np.take_along_axis(weights, order, axis=1), order[:, :MOST_JOINTS]
    # of two that follow left and right alike neither goes without the other
    kept = np.where(kept[:, :MOST_JOINTS] > kept[:, MOST_JOINTS:] + 1e-9, kept[:, :MOST_JOINTS], 0.0)
    kept /= kept.sum(axis=1, keepdims=True)
    return np.where(kept > 0.0, order, 0), kept


def joint_weights(
    template: Template,
    skeleton: Skeleton,
    body: Anatomy,
    helpers: tuple[Helper, ...],
    vertices: Array,
    positions: Array,
    marks: dict[str, Array],
    size: float,
) -> Array:
    """How much each vertex follows each joint and helper, shape (vertices, joints + helpers)."""
    roles = body.roles
    out = np.zeros((len(vertices), skeleton.joint_count + len(helpers)))
    axial = template.bones["axial"].copy()
    for side in SIDES:
        collar = getattr(roles, f"{side}_clavicle")
        if collar:
            out[:, collar[-1]] += template.bones[f"{side}_clavicle"]
        else:
            axial += template.bones[f"{side}_clavicle"]
        at = {(h.joint, h.name.rstrip("_").rsplit("_", 1)[1]): skeleton.joint_count + k for k, h in enumerate(helpers)}
        for part, kind, *_ in _HELPERS:
            joint = getattr(roles, f"{side}_{part}")
            # a forearm without a hand of its own is not wrung
            follows = at[joint, kind] if joint is not None else getattr(roles, f"{side}_radius")
            out[:, follows] += template.bones[f"{side}_{part}_{kind}"]
        carrier = 0
        for part in ("femur", "tibia", "foot", "toes", "humerus", "radius", "hand"):
            joint = getattr(roles, f"{side}_{part}")
            # where there is no joint the flesh goes on with the bone before
            carrier = carrier if joint is None else joint
            out[:, carrier] += template.bones[f"{side}_{part}"]

    # heights at which one axial joint hands over to the next
    hips, shoulders = marks["hips"][1], marks["shoulders"][1]
    low, high = hips + 0.07 * size, shoulders - 0.10 * size
    handover = [float(np.clip(positions[j][1], low, high)) for j in roles.spine]
    if len(handover) > 1 and min(np.diff(handover)) < 0.03 * size:
        handover = list(np.linspace(low, max(handover[-1], low + 0.04 * size * len(handover)), len(handover)))
    gap = min([0.14 * size, *np.diff(handover)]) if handover else 0.0
    halves = [gap / 2] * len(handover)
    last = len(roles.neck) + 1
    skull = shoulders + 0.125 * size
    handover += list(np.linspace(shoulders + 0.050 * size, skull, last) if last > 1 else [skull - 0.03 * size])
    halves += [0.034 * size] * last
    x, y, z = (vertices - [marks["hips"][0], 0.0, marks["shoulders"][2]]).T
    # the neck is narrow and the chin belongs to the head: level lines fall to the sides and in front
    above = _ramp(y, shoulders, 0.05 * size)
    level = y + above * (0.45 * np.maximum(z - 0.02 * size, 0.0) - 0.6 * np.maximum(np.abs(x) - 0.06 * size, 0.0))
    chain = (roles.pelvis, *roles.spine, *roles.neck, roles.head)
    passed = np.ones(len(vertices))
    for joint, middle, half in zip(chain, [*handover, np.inf], [*halves, 1.0], strict=True):
        beyond = np.minimum(passed, _ramp(level, middle, half)) if np.isfinite(middle) else np.zeros(len(vertices))
        out[:, joint] += axial * (passed - beyond)
        passed = beyond
    return out


def _ramp(t: Array, middle: float, half: float) -> Array:
    """From 0 to 1 over [middle − half, middle + half], smooth at both ends."""
    s = np.clip((t - middle) / (2.0 * half) + 0.5, 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s))
