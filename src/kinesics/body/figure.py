"""A human figure on any humanoid skeleton: one closed surface and how it hangs on the joints.

The template (``figure.npz``, made by ``tools/make_figure.py``) is a neutral mannequin of 1.75 m. It is fitted to a skeleton's
own bone lengths, left and right apart, in the *binding pose*: the T-pose with the arms let down by 45°, from which shoulders
have the least way to go in ordinary movement. Vertices then follow the joints by linear blend skinning (Magnenat-Thalmann,
Laperrière, Thalmann 1988), as glTF prescribes it.

Where a joint turns far, blending it with its parent makes the flesh collapse, and where it twists, wrings it. So the skin also
follows *helpers*, which stand at a joint and do part of what it does: half of its swing at shoulders, elbows, hips and knees,
its swing with half of its twist along upper arm, forearm and thigh, its twist alone before the wrist (in-betweens of joints: Mohr &
Gleicher, "Building Efficient, Accurate Character Skins from Examples", 2003).

Fingers are part of the hand, and each hand is one rigid piece.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
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


@dataclass(frozen=True, eq=False)
class Figure:
    """A surface bound to the joints of a skeleton, and to helpers that stand at them."""

    vertices: Array
    """In the binding pose, standing on y = 0 and facing +z, metres, shape (vertices, 3)."""
    normals: Array
    """Outward, of length 1, shape (vertices, 3)."""
    triangles: Indices
    """Counter-clockwise seen from outside, shape (triangles, 3)."""
    joints: Indices
    """That a vertex follows, shape (vertices, 4); numbers from the skeleton's joint count on are helpers."""
    weights: Array
    """Of these joints, falling, with sum 1; 0 where a vertex follows fewer than four. Shape (vertices, 4)."""
    joint_parents: tuple[int, ...]
    """Of the skeleton."""
    partner: Indices
    """Of each vertex, on the other side of the body; itself on the midline. Shape (vertices,)."""
    bind_rotations: Array
    """World orientations of the joints in the binding pose, then of the helpers, shape (joints + helpers, 4)."""
    bind_positions: Array
    """World positions of the joints in the binding pose, then of the helpers, metres, shape (joints + helpers, 3)."""
    helpers: tuple[Helper, ...]

    def helper_rotations(self, rotations: Array) -> Array:
        """Of the helpers from the parents of their joints.

        Parameters
        ----------
        rotations : of the joints from their parents, shape (frames, joints, 4).

        Returns
        -------
        Of shape (frames, helpers, 4). Twists are followed from frame to frame, beyond half a turn, too, so that nothing jumps. A
        share of a swing is undefined only where a bone points the opposite way of the binding pose.
        """
        out = np.empty((len(rotations), len(self.helpers), 4))
        parts: dict[int, tuple[Array, Array]] = {}
        for k, helper in enumerate(self.helpers):
            j = helper.joint
            if j not in parts:
                parent = self.bind_rotations[self.joint_parents[j]]
                bound = quaternion.multiply(quaternion.conjugate(self.bind_rotations[j]), parent)
                parts[j] = _swing_and_twist(quaternion.multiply(rotations[:, j], bound), helper.axis)
            swing, twist = parts[j]
            out[:, k] = quaternion.multiply(
                _part(swing, helper.swing), quaternion.from_axis_angle(helper.axis, helper.twist * twist)
            )
        return out

    def posed(self, motion: Motion) -> Array:
        """Where the vertices are in every frame, metres, shape (frames, vertices, 3)."""
        pose = kinematics.forward(motion.skeleton, motion.rotations, motion.root_positions, motion.joint_translations)
        at = [h.joint for h in self.helpers]
        above = [self.joint_parents[j] for j in at]
        helped = quaternion.multiply(pose.rotations[:, above], self.helper_rotations(motion.rotations))
        turn = quaternion.multiply(
            np.concatenate([pose.rotations, helped], axis=1), quaternion.conjugate(self.bind_rotations)
        )
        matrices = quaternion.as_matrix(turn)
        places = np.concatenate([pose.positions, pose.positions[:, at]], axis=1)
        shifts = places - np.einsum("fjab,jb->fja", matrices, self.bind_positions)
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
    helpers = _helpers(skeleton, body, rotations, marks)
    weights = _joint_weights(template, skeleton, body, helpers, vertices, positions, marks, size)
    most = np.argpartition(weights, -MOST_JOINTS - 1, axis=1)[:, -MOST_JOINTS - 1 :]
    most.sort(axis=1)
    order = np.take_along_axis(
        most, np.argsort(-np.take_along_axis(weights, most, axis=1), axis=1, kind="stable"), axis=1
    )
    kept, order = np.take_along_axis(weights, order, axis=1), order[:, :MOST_JOINTS]
    # of two that follow left and right alike neither goes without the other
    kept = np.where(kept[:, :MOST_JOINTS] > kept[:, MOST_JOINTS:] + 1e-9, kept[:, :MOST_JOINTS], 0.0)
    kept /= kept.sum(axis=1, keepdims=True)
    return Figure(
        vertices=vertices,
        normals=_normals(vertices, template.triangles),
        triangles=template.triangles,
        joints=np.where(kept > 0.0, order, 0),
        weights=kept,
        joint_parents=tuple(skeleton.parents),
        partner=template.partner,
        bind_rotations=np.concatenate([rotations, rotations[[skeleton.parents[h.joint] for h in helpers]]]),
        bind_positions=np.concatenate([positions, positions[[h.joint for h in helpers]]]),
        helpers=helpers,
    )


_BEFORE: Final = {"humerus": None, "radius": "humerus", "femur": None, "tibia": "femur"}
"""Bones of the limbs and what they hang on, None for the trunk."""
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


def _helpers(skeleton: Skeleton, body: Anatomy, world: Array, marks: dict[str, Array]) -> tuple[Helper, ...]:
    out: list[Helper] = []
    for side in _SIDES:
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


def _swing_and_twist(turn: Array, axis: Array) -> tuple[Array, Array]:
    """Turns, frame after frame, as twists about an axis in radians, and then swings about one across it."""
    twist = np.unwrap(2.0 * np.arctan2(turn[:, 1:] @ axis, turn[:, 0]))
    # most frames within half a turn
    twist -= 2.0 * np.pi * np.round(np.median(twist) / (2.0 * np.pi))
    swing = quaternion.multiply(turn, quaternion.from_axis_angle(axis, -twist))
    return np.where(swing[:, :1] < 0.0, -swing, swing), twist


def _part(swing: Array, share: float) -> Array:
    """A share of a swing, the shorter way round."""
    if share == 1.0:
        return swing
    sine = np.linalg.norm(swing[:, 1:], axis=1)
    angle = share * np.arctan2(sine, swing[:, 0])
    out = np.empty_like(swing)
    out[:, 0] = np.cos(angle)
    out[:, 1:] = (np.sin(angle) / np.maximum(sine, 1e-12))[:, None] * swing[:, 1:]
    return out


class _Template(NamedTuple):
    vertices: Array
    triangles: Indices
    partner: Indices
    bones: dict[str, Array]
    """Shares of the vertices in "axial", "left_femur", "left_femur_half" …, each of shape (vertices,)."""
    masses: dict[str, Array]
    """The same where the helpers' shares are given to the bones: what is carried along with which bone."""
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
    masses = {n: share.copy() for n, share in bones.items() if not n.endswith(("_half", "_swing", "_twist"))}
    for side in _SIDES:
        masses["axial"] += masses.pop(f"{side}_clavicle")
        masses[f"{side}_foot"] += masses.pop(f"{side}_toes")
        masses[f"{side}_radius"] += bones[f"{side}_hand_twist"]
        for name, before in _BEFORE.items():
            own, seam = f"{side}_{name}", bones[f"{side}_{name}_half"] / 2
            masses[own] += seam + bones.get(f"{own}_swing", 0.0)
            masses["axial" if before is None else f"{side}_{before}"] += seam
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
        masses=masses,
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
    carried: dict[str, Callable[[Array], Array]] = {"axial": lambda at: _trunk_carried(template, at, marks, size)}
    for side in _SIDES:
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
    """From the ankle, as high as it stands, as long as to the ball of the foot."""
    p0, q0, ball = source[f"{side}_ankle"], marks[f"{side}_ankle"], source[f"{side}_ball"]
    height = _ankle_height(marks, side, size) / p0[1]
    length = size
    turn = quaternion.identity()
    if f"{side}_ball" in marks:
        flat = (marks[f"{side}_ball"] - q0) * [1.0, 0.0, 1.0]
        own = (ball - p0) * [1.0, 0.0, 1.0]
        length *= float(np.clip(np.linalg.norm(flat) / (size * np.linalg.norm(own)), 0.8, 1.25))
        if np.linalg.norm(flat) > 0.02 * size:
            turn = quaternion.between(own, flat)
    return np.asarray(q0 + quaternion.rotate(turn, (p - p0) * [size, height, length]))


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


def _stretched(p: Array, start: tuple[Array, Array], end: tuple[Array, Array], size: float) -> Array:
    """A bone's surroundings carried to where its ends are: along it by its length, across it by the body's size."""
    (p0, q0), (p1, q1) = start, end
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
    for side in _SIDES:
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


def _normals(vertices: Array, triangles: Indices) -> Array:
    """Means of the triangles' normals, by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    flat = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    corners = triangles.ravel()
    out = np.stack([np.bincount(corners, flat[:, k], len(vertices)) for k in range(3)], axis=1)
    length = np.linalg.norm(out, axis=1, keepdims=True)
    return np.asarray(out / np.where(length > 0.0, length, 1.0))
