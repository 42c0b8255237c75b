"""A human figure on any humanoid skeleton: one closed surface and how it hangs on the joints.

The template (``figure.npz``, made by ``tools/make_figure.py``) is a neutral mannequin of 1.75 m. It is fitted to a skeleton's
own bone lengths, left and right apart, in the *binding pose*: the T-pose with the arms let down by 45°, from which shoulders
have the least way to go in ordinary movement. Vertices then follow the joints by linear blend skinning (Magnenat-Thalmann,
Laperrière, Thalmann 1988), as glTF prescribes it.

Fingers are part of the hand, and each hand is one rigid piece.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.body.anatomy import Anatomy
from kinesics.body.motion import Motion
from kinesics.body.skeleton import Skeleton
from kinesics.errors import SkeletonError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

ARMS_DOWN: Final = np.pi / 4
"""Radians below the horizontal, in the binding pose."""
MOST_JOINTS: Final = 4
"""That one vertex follows; what glTF holds in one set."""

_SIDES: Final = ("left", "right")
_FOREFOOT: Final = np.array([0.0, -0.40, 0.92])
"""Direction from ankle to ball of the foot where the rest pose has none."""


@dataclass(frozen=True, eq=False)
class Figure:
    """A surface bound to the joints of a skeleton."""

    vertices: Array
    """In the binding pose, standing on y = 0 and facing +z, metres, shape (vertices, 3)."""
    normals: Array
    """Outward, of length 1, shape (vertices, 3)."""
    triangles: Indices
    """Counter-clockwise seen from outside, shape (triangles, 3)."""
    joints: Indices
    """That a vertex follows, shape (vertices, 4)."""
    weights: Array
    """Of these joints, falling, with sum 1; 0 where a vertex follows fewer than four. Shape (vertices, 4)."""
    partner: Indices
    """Of each vertex, on the other side of the body; itself on the midline. Shape (vertices,)."""
    bind_rotations: Array
    """World orientations of the joints in the binding pose, shape (joints, 4)."""
    bind_positions: Array
    """World positions of the joints in the binding pose, metres, shape (joints, 3)."""

    def posed(self, motion: Motion) -> Array:
        """Where the vertices are in every frame, metres, shape (frames, vertices, 3)."""
        pose = kinematics.forward(motion.skeleton, motion.rotations, motion.root_positions, motion.joint_translations)
        turn = quaternion.multiply(pose.rotations, quaternion.conjugate(self.bind_rotations))
        matrices = quaternion.as_matrix(turn)
        shifts = pose.positions - np.einsum("fjab,jb->fja", matrices, self.bind_positions)
        out = np.zeros((motion.frame_count, len(self.vertices), 3))
        for k in range(MOST_JOINTS):
            j, w = self.joints[:, k], self.weights[:, k]
            for frame, (m, s) in enumerate(zip(matrices, shifts, strict=True)):
                out[frame] += w[:, None] * (np.einsum("vab,vb->va", m[j], self.vertices) + s[j])
        return out


def fit(skeleton: Skeleton, offsets: Array | None = None) -> Figure:
    """The figure on a skeleton.

    Parameters
    ----------
    skeleton : one that carries its anatomy (`kinesics.body.anatomy.understood`).
    offsets : of the joints from their parents, metres, shape (joints, 3), where they are not the skeleton's.

    Raises
    ------
    SkeletonError
        If the skeleton is not understood as a human body, or its bones have no length.
    """
    body = skeleton.anatomy
    if body is None:
        raise SkeletonError("A figure needs a human body, and this skeleton is not understood as one.")
    offsets = skeleton.offsets if offsets is None else offsets
    template = _template()
    rotations, positions = _binding_pose(skeleton, body, offsets)
    marks = _marks(skeleton, body, rotations, positions)
    size = _size(marks)
    sole = min(marks[f"{side}_ankle"][1] - _ankle_height(marks, side, size) for side in _SIDES)
    middle = marks["hips"]
    shift = -np.array([middle[0], sole, middle[2]])
    positions = positions + shift
    marks = {name: point + shift for name, point in marks.items()}

    vertices = _fitted(template, marks, size)
    weights = _joint_weights(template, skeleton, body, vertices, positions, marks, size)
    order = np.argsort(-weights, axis=1, kind="stable")[:, :MOST_JOINTS]
    kept = np.take_along_axis(weights, order, axis=1)
    kept /= kept.sum(axis=1, keepdims=True)
    return Figure(
        vertices=vertices,
        normals=_normals(vertices, template.triangles),
        triangles=template.triangles,
        joints=np.where(kept > 0.0, order, 0),
        weights=kept,
        partner=template.partner,
        bind_rotations=rotations,
        bind_positions=positions,
    )


class _Template(NamedTuple):
    vertices: Array
    triangles: Indices
    partner: Indices
    bones: dict[str, Array]
    """Shares of the vertices in "axial", "left_femur" …, each of shape (vertices,)."""
    points: dict[str, Array]
    """Landmarks, both sides."""


@cache
def _template() -> _Template:
    with resources.files("kinesics.body").joinpath("figure.npz").open("rb") as file, np.load(file) as stored:
        half = stored["vertices"].astype(np.float64)
        faces = stored["faces"].astype(np.intp)
        rim = int(stored["rim"])
        shares = stored["weights"].astype(np.float64)
        names = [str(n) for n in stored["bones"]]
        points = {str(n): p for n, p in zip(stored["point_names"], stored["points"], strict=True)}
    count = len(half)
    # the rim lies on the midline and is its own mirror image
    image = np.concatenate([np.arange(rim), np.arange(count, 2 * count - rim)])
    partner = np.concatenate([image, np.arange(rim, count)])
    flip = np.array([-1.0, 1.0, 1.0])
    shares /= shares.sum(axis=1, keepdims=True)
    bones: dict[str, Array] = {}
    for name, own in zip(names, shares.T, strict=True):
        if name == "axial":
            bones[name] = np.concatenate([own, own[rim:]])
            continue
        for side, other in (("left", False), ("right", True)):
            # on the rim both sides have an equal share
            beside = np.zeros(count - rim)
            bones[f"{side}_{name}"] = np.concatenate(
                [own[:rim] / 2, beside if other else own[rim:], own[rim:] if other else beside]
            )
    sided = {
        f"{side}_{name}": point * (1.0 if side == "left" else flip)
        for name, point in points.items()
        if point[0] > 0.0
        for side in _SIDES
    }
    return _Template(
        vertices=np.concatenate([half, half[rim:] * flip]),
        triangles=np.concatenate([faces, image[faces][:, ::-1]]),
        partner=partner,
        bones=bones,
        points={**{n: p for n, p in points.items() if p[0] == 0.0}, **sided},
    )


def _binding_pose(skeleton: Skeleton, body: Anatomy, offsets: Array) -> tuple[Array, Array]:
    """World orientations and positions of all joints, the root at the origin."""
    roles = body.roles
    let_down = {
        side: quaternion.from_axis_angle([0.0, 0.0, 1.0], -ARMS_DOWN if side == "left" else ARMS_DOWN)
        for side in _SIDES
    }
    anatomical: dict[int, Array] = {
        j: quaternion.identity()
        for j in (roles.pelvis, *roles.spine, *roles.neck, roles.head, *roles.left_clavicle, *roles.right_clavicle)
    }
    for side in _SIDES:
        for part in ("femur", "tibia"):
            anatomical[getattr(roles, f"{side}_{part}")] = quaternion.identity()
        for part in ("humerus", "radius"):
            anatomical[getattr(roles, f"{side}_{part}")] = let_down[side]
    feet: dict[int | None, int | None] = {
        getattr(roles, f"{side}_foot"): getattr(roles, f"{side}_toes") for side in _SIDES
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


def _straightened(bone: Array, along: Array, world: Array) -> Array:
    """Turns a hand that rests across the forearm to go on along it."""
    if min(np.linalg.norm(bone), np.linalg.norm(along)) < 1e-6:
        return quaternion.identity()
    now = quaternion.rotate(world, bone)
    cosine = float(now @ along / (np.linalg.norm(now) * np.linalg.norm(along)))
    return quaternion.identity() if cosine > 0.5 else quaternion.between(now, along)


def _marks(skeleton: Skeleton, body: Anatomy, world: Array, positions: Array) -> dict[str, Array]:
    """The template's landmarks on the skeleton."""
    roles, template = body.roles, _template().points
    out: dict[str, Array] = {"skull": positions[roles.head]}
    for side in _SIDES:
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
    out["hips"] = (out["left_hip"] + out["right_hip"]) / 2
    out["shoulders"] = (out["left_shoulder"] + out["right_shoulder"]) / 2
    return out


_MEASURES: Final = (
    ("hips", "shoulders"),
    *(
        (f"{side}_{a}", f"{side}_{b}")
        for side in _SIDES
        for a, b in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
    ),
)


def _size(marks: dict[str, Array]) -> float:
    """The body's size over the template's: the median over trunk and limbs."""
    template = _template().points
    ratios = [
        float(np.linalg.norm(marks[b] - marks[a]) / np.linalg.norm(template[b] - template[a])) for a, b in _MEASURES
    ]
    size = float(np.median(ratios))
    if min(ratios) < 1e-3 * max(size, 1e-9) or size < 1e-9:
        raise SkeletonError("A figure needs trunk, arms and legs of some length; a bone of this skeleton has none.")
    return size


def _ankle_height(marks: dict[str, Array], side: str, size: float) -> float:
    """Of the ankle above the sole, judged by how far the ball of the foot lies below it."""
    template = _template().points
    usual = size * template[f"{side}_ankle"][1]
    if f"{side}_ball" not in marks:
        return float(usual)
    drop = marks[f"{side}_ankle"][1] - marks[f"{side}_ball"][1] + size * template[f"{side}_ball"][1]
    return float(np.clip(drop, 0.75 * usual, 1.3 * usual))


def _fitted(template: _Template, marks: dict[str, Array], size: float) -> Array:
    """The template's vertices on the skeleton's bones: each part is carried along and stretched, seams are blended."""
    source, p = template.points, template.vertices
    trunk = _trunk_carried(template, p, marks, size)
    carried: dict[str, Array] = {"axial": trunk}
    for side in _SIDES:
        at = {
            n: (source[f"{side}_{n}"], marks[f"{side}_{n}"])
            for n in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
        }
        carried[f"{side}_clavicle"] = trunk
        for bone, a, b in (
            ("femur", "hip", "knee"),
            ("tibia", "knee", "ankle"),
            ("humerus", "shoulder", "elbow"),
            ("radius", "elbow", "wrist"),
        ):
            (p0, q0), (p1, q1) = at[a], at[b]
            carried[f"{side}_{bone}"] = _stretched(p, p0, p1, q0, q1, size)
        (p0, q0), (p1, q1) = at["elbow"], at["wrist"]
        turn = quaternion.between(p1 - p0, q1 - q0)
        carried[f"{side}_hand"] = q1 + quaternion.rotate(turn, size * (p - p1))
        p0, q0 = at["ankle"]
        ball = source[f"{side}_ball"]
        height = _ankle_height(marks, side, size) / p0[1]
        length = size
        turn = quaternion.identity()
        if f"{side}_ball" in marks:
            flat = (marks[f"{side}_ball"] - q0) * [1.0, 0.0, 1.0]
            own = (ball - p0) * [1.0, 0.0, 1.0]
            length *= float(np.clip(np.linalg.norm(flat) / (size * np.linalg.norm(own)), 0.8, 1.25))
            if np.linalg.norm(flat) > 0.02 * size:
                turn = quaternion.between(own, flat)
        foot = q0 + quaternion.rotate(turn, (p - p0) * [size, height, length])
        carried[f"{side}_foot"] = carried[f"{side}_toes"] = foot
    out = np.zeros_like(p)
    for bone, share in template.bones.items():
        out += share[:, None] * carried[bone]
    return out


def _trunk_carried(template: _Template, p: Array, marks: dict[str, Array], size: float) -> Array:
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


def _stretched(p: Array, p0: Array, p1: Array, q0: Array, q1: Array, size: float) -> Array:
    """A bone's surroundings carried from p0-p1 to q0-q1: along it by its length, across it by the body's size."""
    axis = (p1 - p0) / np.linalg.norm(p1 - p0)
    along = (p - p0) @ axis
    across = p - p0 - along[:, None] * axis
    ratio = np.linalg.norm(q1 - q0) / np.linalg.norm(p1 - p0)
    turn = quaternion.between(p1 - p0, q1 - q0)
    return np.asarray(q0 + quaternion.rotate(turn, size * across + ratio * along[:, None] * axis))


def _ramp(t: Array, middle: float, half: float) -> Array:
    """From 0 to 1 over [middle − half, middle + half], smooth at both ends."""
    s = np.clip((t - middle) / (2.0 * half) + 0.5, 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s))


def _joint_weights(
    template: _Template,
    skeleton: Skeleton,
    body: Anatomy,
    vertices: Array,
    positions: Array,
    marks: dict[str, Array],
    size: float,
) -> Array:
    """How much each vertex follows each joint, shape (vertices, joints)."""
    roles = body.roles
    out = np.zeros((len(vertices), skeleton.joint_count))
    axial = template.bones["axial"].copy()
    for side in _SIDES:
        collar = getattr(roles, f"{side}_clavicle")
        if collar:
            out[:, collar[-1]] += template.bones[f"{side}_clavicle"]
        else:
            axial += template.bones[f"{side}_clavicle"]
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


def _normals(vertices: Array, triangles: Indices) -> Array:
    """Means of the triangles' normals, by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    flat = np.cross(b - a, c - a)
    out = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(out, triangles[:, k], flat)
    length = np.linalg.norm(out, axis=1, keepdims=True)
    return np.asarray(out / np.where(length > 0.0, length, 1.0))
