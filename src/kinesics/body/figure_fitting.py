"""The human figure's template on a skeleton: its binding pose, its landmarks there, and the flesh carried along with them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.anatomy import Anatomy
from kinesics.body.feet import POINTS, Soles
from kinesics.body.figure_template import SIDES, Template, mannequin
from kinesics.body.skeleton import Skeleton
from kinesics.errors import SkeletonError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

ARMS_DOWN: Final = np.pi / 4
"""Radians below the horizontal, in the binding pose."""
_FOREFOOT: Final = np.array([0.0, -0.40, 0.92])
"""Direction from ankle to ball of the foot where the rest pose has none."""
_ANKLE_HEIGHTS: Final = (0.5, 1.6)
"""Least and most of the ankle's height over the template's, where soles are known."""
_MOST_PITCH: Final = np.pi / 4
_MOST_ROLL: Final = np.radians(25.0)
"""Radians that feet are turned by from how they rest."""
_ROLL_SHARE: Final = 0.5
"""Of the roll that soles tell: they are found where ankles are lowest, when feet are rolled farther than they mostly are."""
_FOREFOOT_LENGTHS: Final = (0.55, 1.3)
"""Least and most of the toes' length over the template's, where soles are known."""
_TOE_SPRING: Final = 0.003
"""Metres that the toes' end is raised by in the template."""
_SPRING_BEYOND: Final = 0.4
"""Share of what it is too long for the sole that it is raised by besides."""
_EDGE: Final = 0.005
"""Metres that the edges of the sole are raised by in the template, as feet are soft there."""
_MEASURES: Final = (
    ("hips", "shoulders"),
    *(
        (f"{side}_{a}", f"{side}_{b}")
        for side in SIDES
        for a, b in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
    ),
)


def binding_pose(skeleton: Skeleton, body: Anatomy, offsets: Array, soles: Soles | None = None) -> tuple[Array, Array]:
    """World orientations and positions of all joints, the root at the origin; feet stand flat, where their soles are known."""
    roles = body.roles
    let_down = {
        side: quaternion.from_axis_angle([0.0, 0.0, 1.0], -ARMS_DOWN if side == "left" else ARMS_DOWN) for side in SIDES
    }
    anatomical: dict[int, Array] = {
        j: quaternion.identity()
        for j in (roles.pelvis, *roles.spine, *roles.neck, roles.head, *roles.left_clavicle, *roles.right_clavicle)
    }
    for side in SIDES:
        for part in ("femur", "tibia"):
            anatomical[getattr(roles, f"{side}_{part}")] = quaternion.identity()
        for part in ("humerus", "radius"):
            anatomical[getattr(roles, f"{side}_{part}")] = let_down[side]
    feet: dict[int | None, int | None] = {
        getattr(roles, f"{side}_foot"): getattr(roles, f"{side}_toes") for side in SIDES
    }
    hands = (roles.left_hand, roles.right_hand)
    world = quaternion.identity((skeleton.joint_count,))
    for j, parent in enumerate(skeleton.parents):
        if j in anatomical:
            world[j] = quaternion.multiply(anatomical[j], quaternion.conjugate(body.frames[j]))
        elif parent >= 0:
            world[j] = world[parent]  # as it rests on its parent
            swing = quaternion.identity()
            # feet and hands that rest otherwise are put right
            if j in feet:
                swing = _forefoot_swing(skeleton, offsets, feet[j], j, world[j])
            elif j in hands:
                forearm = quaternion.rotate(world[parent], offsets[j])
                swing = _straightened(_reach(skeleton, offsets, j), forearm, world[j])
            world[j] = quaternion.multiply(swing, world[j])
            if soles is not None:
                world[j] = quaternion.multiply(_levelling(soles, j, parent, world, offsets[j]), world[j])
    positions = np.zeros((skeleton.joint_count, 3))
    for j, parent in enumerate(skeleton.parents):
        if parent >= 0:
            positions[j] = positions[parent] + quaternion.rotate(world[parent], offsets[j])
    return world, positions


def _reach(skeleton: Skeleton, offsets: Array, joint: int) -> Array:
    """From a joint to its farthest child or tip, in its own frame; zero where it has none."""
    reach = [offsets[c] for c in skeleton.children[joint]]
    reach += [np.array(s.offset) for s in skeleton.end_sites if s.parent == joint]
    return max(reach, key=lambda r: float(np.linalg.norm(r)), default=np.zeros(3))


def _forefoot_swing(skeleton: Skeleton, offsets: Array, toes: int | None, foot: int, world: Array) -> Array:
    """Turns a foot that rests along the shank, or backwards, to point forward."""
    bone = offsets[toes] if toes is not None and skeleton.parents[toes] == foot else _reach(skeleton, offsets, foot)
    length = float(np.linalg.norm(bone))
    if length < 1e-6:
        return quaternion.identity()
    now = quaternion.rotate(world, bone) / length
    return quaternion.identity() if now[2] > 0.5 else quaternion.between(now, _FOREFOOT)


def _levelling(soles: Soles, joint: int, parent: int, world: Array, offset: Array) -> Array:
    """Turns a foot until heel and ball are level and the ankle is straight above the line between them, as soles are found
    (feet.py), and pitches toes until their tip is as low as the ball."""
    for points, places in zip(soles.joints, soles.offsets, strict=True):
        heel, ball, tip = (int(k) for k in points)
        if joint == heel == ball:
            pitch = _pitched(quaternion.rotate(world[joint], places[1] - places[0]), 0.0)
            pitched = quaternion.multiply(pitch, world[joint])
            return quaternion.multiply(_rolled(*quaternion.rotate(pitched, places[:2])), pitch)
        if joint == tip != ball == parent:
            # from the toe joint, beneath which the ball lies
            drop = quaternion.rotate(world[ball], places[1] - offset)[1]
            return _pitched(quaternion.rotate(world[joint], places[2]), float(drop))
    return quaternion.identity()


def _pitched(along: Array, drop: float) -> Array:
    """The turn about a level axis that lets the end of what points along lie so far up."""
    flat, length = np.linalg.norm(along[[0, 2]]), np.linalg.norm(along)
    if flat < 1e-3 or length <= abs(drop):
        return quaternion.identity()
    turn = np.arcsin(drop / length) - np.arctan2(along[1], flat)
    return quaternion.from_axis_angle([-along[2] / flat, 0.0, along[0] / flat], _within(turn, _MOST_PITCH))


def _rolled(heel: Array, ball: Array) -> Array:
    """The turn about the level line from heel to ball that brings it straight below the ankle, which both are seen from."""
    along = (ball - heel) * [1.0, 0.0, 1.0]
    length = np.linalg.norm(along)
    if length < 1e-3:
        return quaternion.identity()
    along = along / length
    sideways = float(np.cross([0.0, 1.0, 0.0], along) @ heel)
    return quaternion.from_axis_angle(along, _within(-_ROLL_SHARE * np.arctan2(sideways, -heel[1]), _MOST_ROLL))


def _within(angle: float, most: float) -> float:
    return float(np.clip(angle, -most, most))


def _straightened(bone: Array, along: Array, world: Array) -> Array:
    """Turns a hand that rests across the forearm to go on along it."""
    if min(np.linalg.norm(bone), np.linalg.norm(along)) < 1e-6:
        return quaternion.identity()
    now = quaternion.rotate(world, bone)
    cosine = float(now @ along / (np.linalg.norm(now) * np.linalg.norm(along)))
    return quaternion.identity() if cosine > 0.5 else quaternion.between(now, along)


def landmarks(
    skeleton: Skeleton, body: Anatomy, world: Array, positions: Array, soles: Soles | None = None
) -> dict[str, Array]:
    """The template's landmarks on the skeleton; heel, ball and tip of the soles, where these are known, as "left_sole_heel" …"""
    roles, template = body.roles, mannequin().points
    out: dict[str, Array] = {"skull": positions[roles.head]}
    for side in SIDES:
        joint = {
            part: getattr(roles, f"{side}_{part}")
            for part in ("femur", "tibia", "humerus", "radius", "foot", "hand", "toes")
        }
        for name, part in (("hip", "femur"), ("knee", "tibia"), ("shoulder", "humerus"), ("elbow", "radius")):
            out[f"{side}_{name}"] = positions[joint[part]]
        for start, middle, end, last in (("hip", "knee", "ankle", "foot"), ("shoulder", "elbow", "wrist", "hand")):
            if joint[last] is not None:
                out[f"{side}_{end}"] = positions[joint[last]]
                continue
            # no joint there: the tip of the bone, or as long as in the template
            lower = joint["tibia" if last == "foot" else "radius"]
            tip = np.array(next((s.offset for s in skeleton.end_sites if s.parent == lower), (0.0, 0.0, 0.0)))
            if np.linalg.norm(tip) < 0.3 * np.linalg.norm(out[f"{side}_{middle}"] - out[f"{side}_{start}"]):
                a, b, c = (template[f"{side}_{n}"] for n in (start, middle, end))
                ratio = np.linalg.norm(c - b) / np.linalg.norm(b - a)
                out[f"{side}_{end}"] = out[f"{side}_{middle}"] + ratio * (
                    out[f"{side}_{middle}"] - out[f"{side}_{start}"]
                )
            else:
                out[f"{side}_{end}"] = positions[lower] + quaternion.rotate(world[lower], tip)
        if joint["toes"] is not None:
            out[f"{side}_ball"] = positions[joint["toes"]]
    if soles is not None:
        for side, places in zip(SIDES, soles.place(positions[None], world[None])[0], strict=True):
            out |= {f"{side}_sole_{name}": place for name, place in zip(POINTS, places, strict=True)}
    out["hips"] = (out["left_hip"] + out["right_hip"]) / 2
    out["shoulders"] = (out["left_shoulder"] + out["right_shoulder"]) / 2
    return out


def body_size(marks: dict[str, Array]) -> float:
    """The body's size over the template's: the median over trunk and limbs."""
    template = mannequin().points
    ratios = [
        float(np.linalg.norm(marks[b] - marks[a]) / np.linalg.norm(template[b] - template[a])) for a, b in _MEASURES
    ]
    size = float(np.median(ratios))
    if min(ratios) < 1e-3 * max(size, 1e-9) or size < 1e-9:
        raise SkeletonError("A figure needs trunk, arms and legs of some length; a bone of this skeleton has none.")
    return size


def ankle_height(marks: dict[str, Array], side: str, size: float) -> float:
    """Of the ankle above the sole: as it is known, else judged by how far the ball of the foot lies below it."""
    template = mannequin().points
    usual = size * template[f"{side}_ankle"][1]
    if f"{side}_sole_heel" in marks:
        level = (marks[f"{side}_sole_heel"][1] + marks[f"{side}_sole_ball"][1]) / 2.0
        return float(np.clip(marks[f"{side}_ankle"][1] - level, *(f * usual for f in _ANKLE_HEIGHTS)))
    if f"{side}_ball" not in marks:
        return float(usual)
    drop = marks[f"{side}_ankle"][1] - marks[f"{side}_ball"][1] + size * template[f"{side}_ball"][1]
    return float(np.clip(drop, 0.75 * usual, 1.3 * usual))


def fitted(template: Template, marks: dict[str, Array], size: float) -> Array:
    """The template's vertices on the skeleton's bones: each part is carried along and stretched, seams are blended."""
    source, p = template.points, template.vertices
    carried: dict[str, Callable[[Array], Array]] = {"axial": lambda at: _trunk_carried(template, at, marks, size)}
    for side in SIDES:
        for bone, a, b in (
            ("femur", "hip", "knee"),
            ("tibia", "knee", "ankle"),
            ("humerus", "shoulder", "elbow"),
            ("radius", "elbow", "wrist"),
        ):
            ends = [(source[f"{side}_{n}"], marks[f"{side}_{n}"]) for n in (a, b)]
            carried[f"{side}_{bone}"] = partial(_stretched, start=ends[0], end=ends[1], size=size)
        carried[f"{side}_hand"] = partial(_hand_carried, source=source, marks=marks, side=side, size=size)
        carried[f"{side}_foot"] = partial(_foot_carried, source=source, marks=marks, side=side, size=size)
    out = np.zeros_like(p)
    for bone, share in template.masses.items():
        rows = np.flatnonzero(share)
        out[rows] += share[rows, None] * carried[bone](p[rows])
    return out


def _hand_carried(p: Array, source: dict[str, Array], marks: dict[str, Array], side: str, size: float) -> Array:
    """Along the forearm, of the body's size."""
    (p0, q0), (p1, q1) = ((source[f"{side}_{n}"], marks[f"{side}_{n}"]) for n in ("elbow", "wrist"))
    turn = quaternion.between(p1 - p0, q1 - q0)
    return np.asarray(q1 + quaternion.rotate(turn, size * (p - p1)))


def _foot_carried(p: Array, source: dict[str, Array], marks: dict[str, Array], side: str, size: float) -> Array:
    """From the ankle, as high as it stands, as long as to the ball of the foot, and on to the tip of the sole where it is known."""
    p0, q0, ball = source[f"{side}_ankle"], marks[f"{side}_ankle"], source[f"{side}_ball"]
    height = ankle_height(marks, side, size) / p0[1]
    length = size
    turn = quaternion.identity()
    if f"{side}_ball" in marks:
        flat = (marks[f"{side}_ball"] - q0) * [1.0, 0.0, 1.0]
        own = (ball - p0) * [1.0, 0.0, 1.0]
        length *= float(np.clip(np.linalg.norm(flat) / (size * np.linalg.norm(own)), 0.8, 1.25))
        if np.linalg.norm(flat) > 0.02 * size:
            turn = quaternion.between(own, flat)
    out = (p - p0) * [size, height, length]
    if f"{side}_sole_tip" in marks:
        toes = source[f"{side}_toes"][2] - ball[2]
        reach = np.linalg.norm((marks[f"{side}_sole_tip"] - q0)[[0, 2]]) - length * (ball[2] - p0[2])
        ratio = float(np.clip(reach / (size * toes), *_FOREFOOT_LENGTHS))
        out[:, 2] += (size * ratio - length) * np.maximum(p[:, 2] - ball[2], 0.0)
        # what is longer than the sole has to come down beyond its tip
        spring = _TOE_SPRING * size + _SPRING_BEYOND * float(np.clip(size * ratio * toes - reach, 0.0, 0.03 * size))
        out[:, 1] += spring * np.clip((p[:, 2] - ball[2]) / toes, 0.0, 1.2) ** 1.5
        out[:, 1] += size * _rounding(p, ball)
    return np.asarray(q0 + quaternion.rotate(turn, out))


def _rounding(p: Array, ball: Array) -> Array:
    """By how much the sole's edges are raised, more than they are in the template: a foot that rolls does so over them."""
    out = np.clip((np.abs(p[:, 0] - ball[0]) - 0.015) / 0.03, 0.0, 1.0) ** 2
    return np.asarray(_EDGE * out * np.clip(1.0 - p[:, 1] / 0.03, 0.0, 1.0))


def _trunk_carried(template: Template, p: Array, marks: dict[str, Array], size: float) -> Array:
    """Trunk, neck and head: heights by those of hips, shoulders and skull, breadths by hip and shoulder line."""
    source = template.points
    neck = (source["skull"][1] - source["shoulders"][1]) * size
    skull = marks["skull"].copy()
    skull[1] = marks["shoulders"][1] + np.clip(skull[1] - marks["shoulders"][1], 0.85 * neck, 1.25 * neck)
    heights = np.array([source[n][1] for n in ("hips", "shoulders", "skull")])
    steps = np.stack([marks["hips"], marks["shoulders"], skull]) - size * np.stack(
        [source[n] for n in ("hips", "shoulders", "skull")]
    )
    shift = np.stack([_eased(p[:, 1], heights, steps[:, c]) for c in range(3)], axis=1)

    def breadth(name: str, low: float, high: float) -> float:
        ratio = np.linalg.norm(marks[f"left_{name}"] - marks[f"right_{name}"]) / (
            size * np.linalg.norm(source[f"left_{name}"] - source[f"right_{name}"])
        )
        return float(np.clip(ratio, low, high))

    wide = _eased(p[:, 1], heights, np.array([breadth("hip", 0.92, 1.12), breadth("shoulder", 0.85, 1.15), 1.0]))
    return np.asarray(size * p * np.stack([wide, np.ones_like(wide), np.ones_like(wide)], axis=1) + shift)


def _eased(t: Array, knots: Array, values: Array) -> Array:
    """Through the values at the knots with level tangents, constant beyond them."""
    out = np.full_like(t, values[0])
    for k in range(len(knots) - 1):
        s = np.clip((t - knots[k]) / (knots[k + 1] - knots[k]), 0.0, 1.0)
        out += (values[k + 1] - values[k]) * s * s * (3.0 - 2.0 * s)
    return out


def _stretched(p: Array, start: tuple[Array, Array], end: tuple[Array, Array], size: float) -> Array:
    """A bone's surroundings carried to where its ends are: along it by its length, across it by the body's size."""
    (p0, q0), (p1, q1) = start, end
    axis = (p1 - p0) / np.linalg.norm(p1 - p0)
    along = (p - p0) @ axis
    across = p - p0 - along[:, None] * axis
    ratio = np.linalg.norm(q1 - q0) / np.linalg.norm(p1 - p0)
    turn = quaternion.between(p1 - p0, q1 - q0)
    return np.asarray(q0 + quaternion.rotate(turn, size * across + ratio * along[:, None] * axis))
