"""C_free: the poses a body can take, as far as a file tells ([Schultz2012] §2.9).

Not every configuration is physically possible: joints have limits and the body cannot pass through itself. `free_space`
counts both over a recording and says what it found; nothing is changed and nothing is refused.

- `joint_excesses`: joints beyond the limits that the file itself gives (ASF ``limits``)
- `self_collisions`: limbs that pass through each other or through the trunk, as capsules round the bones
- `segment_distance`: how near two straight segments come

Radii are those of cylinders with each segment's mass, density and length in Winter, *Biomechanics and Motor Control of
Human Movement* (4th ed. 2009), table 4.1 (masses, densities) and figure 4.1 (lengths, after Drillis & Contini 1966),
for a body mass index of 22 kg/m², scaled to the body's own stature; the trunk's is its half depth. People differ, flesh
gives way and markers slip: hence the tolerance.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics import compiled
from kinesics.body import anatomy
from kinesics.body.anatomy import Anatomy
from kinesics.body.motion import Motion
from kinesics.body.quality import estimated_stature
from kinesics.body.skeleton import JointFreedom, Skeleton
from kinesics.errors import SkeletonError
from kinesics.geometry import euler, quaternion

Array = NDArray[np.float64]

JOINT_TOLERANCE: Final = np.deg2rad(1.0)
"""Radians beyond a limit that are let pass: a file's rounding and a marker's slip."""
DEPTH_TOLERANCE: Final = 0.05
"""Metres that two capsules may interpenetrate: some 2 cm of flesh that gives way, 1 to 2 cm by which either radius may
be wrong, as much by which joint centres are misplaced."""
REFERENCE_STATURE: Final = 1.75
"""Metres. Radii are those of a body of this stature, other bodies are taken to be of the same shape."""
REFERENCE_MASS: Final = 22.0 * REFERENCE_STATURE**2
"""kg: a body mass index of 22 kg/m², the middle of what the World Health Organization calls normal."""


_EXTREMITY: Final = re.compile("wrist|hand|thumb|finger|toe")
"""Joints that sentences leave out: nearly every CMU recording takes some of them 10° to 60° beyond what its ASF allows, which
says nothing about the recording. `FreeSpace.excesses` has them all."""
_MOST_JOINTS: Final = 3


class _Segment(NamedTuple):
    mass: float
    """Share of the body's mass (Winter, table 4.1)."""
    density: float
    """kg/m³ (Winter, table 4.1)."""
    length: float
    """Share of the stature (Winter, figure 4.1)."""


_SEGMENTS: Final[dict[str, _Segment]] = {
    "head": _Segment(0.081, 1110.0, 0.182),
    "femur": _Segment(0.100, 1050.0, 0.245),
    "tibia": _Segment(0.0465, 1090.0, 0.246),
    "humerus": _Segment(0.028, 1070.0, 0.186),
    "radius": _Segment(0.016, 1130.0, 0.146),
}
_HEAD_LENGTH: Final = 0.130
"""Chin to crown, share of the stature (Winter, figure 4.1); for skeletons whose head has no tip."""

_TRUNK_HALF_DEPTH: Final = 0.065
"""Share of the stature: chest and waist of the middle man are 24 and 22 cm deep (NASA-STD-3000, fig. 3.3.1.3-1)."""
_TRUNK_TO_SHOULDERS: Final = 0.3
"""Half depth of the trunk over the distance of the shoulder joints, so that a rig with narrow shoulders is a narrow
body.
"""

_CAPSULES: Final = (
    "lower trunk",
    "upper trunk",
    "head",
    "left femur",
    "left tibia",
    "left humerus",
    "left radius",
    "right femur",
    "right tibia",
    "right humerus",
    "right radius",
)
_ADJACENT: Final = {
    frozenset(pair)
    for side in ("left", "right")
    for pair in (
        ("lower trunk", "upper trunk"),
        ("upper trunk", "head"),
        ("lower trunk", f"{side} femur"),
        ("upper trunk", f"{side} humerus"),
        ("head", f"{side} humerus"),
        (f"{side} femur", f"{side} tibia"),
        (f"{side} humerus", f"{side} radius"),
    )
}
"""Pairs that meet at a joint, and the head with the upper arms, which lie against it when an arm is raised."""


@dataclass(frozen=True)
class JointExcess:
    """One axis of one joint that goes beyond the limits of its own file."""

    joint: str
    axis: str
    """"x", "y" or "z" in the joint's frame."""
    lowest_degrees: float
    """The file's limits."""
    highest_degrees: float
    frames: int
    """How many frames are beyond, tolerance included."""
    worst_degrees: float
    """Farthest beyond the limit."""
    worst_frame: int


@dataclass(frozen=True)
class Collision:
    """Two parts of the body that pass through each other."""

    first: str
    second: str
    frames: int
    """How many frames are deeper than the tolerance."""
    worst_depth: float
    """Metres by which the capsules interpenetrate at worst, tolerance not deducted."""
    worst_frame: int


@dataclass(frozen=True)
class FreeSpace:
    """How far a recording stays within C_free (§2.9)."""

    frame_count: int
    joints_checked: int
    """Joints whose limits the file gives; 0 where it gives none."""
    excesses: tuple[JointExcess, ...]
    """Worst first."""
    excess_frames: int
    """Frames in which any joint is beyond a limit."""
    pairs_checked: int
    """Pairs of capsules that can collide; 0 where the skeleton is not understood as a human body."""
    collisions: tuple[Collision, ...]
    """Deepest first."""
    collision_frames: int
    """Frames in which any pair collides."""

    @property
    def sentences(self) -> tuple[str, ...]:
        """What was found, in at most three sentences."""
        out = []
        if self.joints_checked == 0:
            out.append("The file gives no joint limits.")
        elif not self.excesses:
            out.append(f"All {self.joints_checked} joints with limits stay within them.")
        else:
            out.append(self._beyond_limits())
        if self.pairs_checked == 0:
            out.append("Self-collision was not checked: the skeleton is not understood as a human body.")
        elif not self.collisions:
            out.append("No part of the body passes through another.")
        else:
            deepest = self.collisions[0]
            more = len(self.collisions) - 1
            others = f"; {more} more pair{'s' if more > 1 else ''}" if more else ""
            out.append(
                f"Parts of the body pass through each other in {self.collision_frames} of {self.frame_count} frames: most the "
                f"{deepest.first} and the {deepest.second}, {100 * deepest.worst_depth:.0f} cm deep at frame "
                f"{deepest.worst_frame}{others}."
            )
        return tuple(out)

    def _beyond_limits(self) -> str:
        """Which joints go beyond their limits, and how far; those that nearly every recording bends too far are left out."""
        worst: dict[str, JointExcess] = {}
        for excess in self.excesses:
            if not _EXTREMITY.search(excess.joint.lower()):
                worst.setdefault(excess.joint, excess)
        if not worst:
            return "Only wrists, hands, fingers or toes go beyond the file's own joint limits."
        told = [
            f"{e.joint} by up to {e.worst_degrees:.0f}° about {e.axis} (frame {e.worst_frame})" for e in worst.values()
        ]
        more = f" and {len(told) - _MOST_JOINTS} more" if len(told) > _MOST_JOINTS else ""
        return f"Beyond the file's own joint limits: {', '.join(told[:_MOST_JOINTS])}{more}."

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {**asdict(self), "sentences": list(self.sentences)} | {
            "excesses": [asdict(e) for e in self.excesses],
            "collisions": [asdict(c) for c in self.collisions],
        }


def free_space(
    motion: Motion, *, joint_tolerance: float = JOINT_TOLERANCE, depth_tolerance: float = DEPTH_TOLERANCE
) -> FreeSpace:
    """Joint limits and self-collision over a recording, counted (§2.9).

    Parameters
    ----------
    joint_tolerance : radians beyond a limit that are let pass.
    depth_tolerance : metres that two limbs may interpenetrate.

    A skeleton that is not understood as a human body is not checked for collisions; the result says so.
    """
    limited = [f for f in motion.skeleton.freedoms if f.limits]
    excesses, excess_frames = joint_excesses(motion, tolerance=joint_tolerance)
    try:
        hits = self_collisions(motion, tolerance=depth_tolerance)
    except SkeletonError:
        hits = SelfCollisions(0, (), 0)
    return FreeSpace(
        frame_count=motion.frame_count,
        joints_checked=len(limited),
        excesses=excesses,
        excess_frames=excess_frames,
        pairs_checked=hits.pairs,
        collisions=hits.collisions,
        collision_frames=hits.frames,
    )


class JointExcesses(NamedTuple):
    """Joints beyond their limits, worst first, and in how many frames any of them is."""

    excesses: tuple[JointExcess, ...]
    frames: int


def joint_excesses(motion: Motion, *, tolerance: float = JOINT_TOLERANCE) -> JointExcesses:
    """Axes of joints that go beyond the limits of the file (§2.9).

    The local rotation C·R·C⁻¹ is taken back to the joint's own angles. Two sets of angles give the same rotation, and
    each angle may be counted with whole turns: a joint is beyond its limits only if every reading is. At gimbal lock
    angles are not defined, and such frames are not judged.

    Parameters
    ----------
    tolerance : radians that are let pass.
    """
    out = []
    beyond_any = np.zeros(motion.frame_count, dtype=np.bool_)
    for j, freedom in enumerate(motion.skeleton.freedoms):
        if not freedom.limits or not freedom.channels:
            continue
        excess = _excess(motion.rotations[:, j], freedom)
        beyond = excess > tolerance
        beyond_any |= beyond.any(axis=1)
        for k, (axis, (low, high)) in enumerate(zip(freedom.channels, freedom.limits, strict=False)):
            if not beyond[:, k].any():
                continue
            worst = int(np.argmax(excess[:, k]))
            out.append(
                JointExcess(
                    joint=motion.skeleton.joint_names[j],
                    axis=axis.lower(),
                    lowest_degrees=float(np.rad2deg(low)),
                    highest_degrees=float(np.rad2deg(high)),
                    frames=int(beyond[:, k].sum()),
                    worst_degrees=float(np.rad2deg(excess[worst, k])),
                    worst_frame=worst,
                )
            )
    out.sort(key=lambda e: (-e.worst_degrees, e.joint, e.axis))
    return JointExcesses(tuple(out), int(beyond_any.sum()))


def _excess(rotations: Array, freedom: JointFreedom) -> Array:
    """Radians beyond the limits, 0 within them, for each channel with limits; shape (frames, channels)."""
    frame = np.asarray(freedom.axis)
    own = quaternion.multiply(quaternion.multiply(quaternion.conjugate(frame), rotations), frame)
    found = euler.as_euler(own, freedom.order)
    order, channels = freedom.order.upper(), freedom.channels.upper()
    # an axis without a channel does not turn, one without limits turns freely
    low = np.array([-np.inf if axis in channels else 0.0 for axis in order])
    high = np.array([np.inf if axis in channels else 0.0 for axis in order])
    columns = [order.index(axis) for axis in channels[: len(freedom.limits)]]
    for column, limits in zip(columns, freedom.limits, strict=False):
        low[column], high[column] = limits
    middle = np.where(np.isfinite(low) & np.isfinite(high), 0.5 * (low + high), 0.0)
    readings = []
    for angles in (found.angles, _other_angles(found.angles)):
        # with the whole turns that bring each angle nearest to the middle of its range
        nearest = angles - 2.0 * np.pi * np.round((angles - middle) / (2.0 * np.pi))
        readings.append(np.maximum(np.maximum(low - nearest, nearest - high), 0.0))
    other = readings[1].max(axis=1) < readings[0].max(axis=1)
    excess = np.where(other[:, None], readings[1], readings[0])
    excess[found.gimbal_lock] = 0.0
    return np.asarray(excess[:, columns])


def _other_angles(angles: Array) -> Array:
    """The other set of three angles about three different axes that gives the same rotation."""
    first, middle, third = angles[:, 0], angles[:, 1], angles[:, 2]
    return np.stack([first + np.pi, np.pi - middle, third + np.pi], axis=1)


class SelfCollisions(NamedTuple):
    """How many pairs were looked at, those that collide, deepest first, and in how many frames any does."""

    pairs: int
    collisions: tuple[Collision, ...]
    frames: int


class Ends(NamedTuple):
    """Both ends of every capsule, metres, shape (frames, capsules, 3) each."""

    starts: Array
    ends: Array


@dataclass(frozen=True, eq=False)
class Capsules:
    """The body as capsules round its bones, and which of them may not pass through each other (§2.9)."""

    skeleton: Skeleton
    body: Anatomy
    stature: float
    radii: Array
    """Metres, shape (capsules,)."""
    pairs: tuple[tuple[int, int], ...]
    """Capsules that are looked at: neither meet at a joint nor pass through each other in the T-pose."""

    @classmethod
    def of(cls, motion: Motion, body: Anatomy | None = None, *, tolerance: float = DEPTH_TOLERANCE) -> Capsules:
        """Measured on a motion. Parameters and errors are those of `self_collisions`."""
        body = anatomy.resolve(motion) if body is None else body
        stature = estimated_stature(motion) or 0.0
        starts, ends = _capsules(motion.skeleton, motion.positions(), motion.global_rotations(), body, stature)
        left, right = (starts[:, _CAPSULES.index(f"{side} humerus")] for side in ("left", "right"))
        shoulders = float(np.median(np.linalg.norm(left - right, axis=-1)))
        trunk = min(_TRUNK_HALF_DEPTH * stature, _TRUNK_TO_SHOULDERS * shoulders)
        radii = np.array([trunk if "trunk" in n else capsule_radius(n.split()[-1], stature) for n in _CAPSULES])
        return cls(motion.skeleton, body, stature, radii, tuple(_pairs(starts, ends, radii, tolerance)))

    @property
    def names(self) -> tuple[str, ...]:
        """Of the capsules."""
        return _CAPSULES

    def ends(self, positions: Array, rotations: Array) -> Ends:
        """Where the capsules are, by where all joints are in the world: (frames, joints, 3) and (frames, joints, 4)."""
        return Ends(*_capsules(self.skeleton, positions, rotations, self.body, self.stature))

    def depths(self, positions: Array, rotations: Array, *, least: float = 0.0) -> Array:
        """Metres by which each pair interpenetrates, −∞ where by less than about ``least``: shape (frames, pairs)."""
        a, b = np.array(self.pairs, dtype=np.intp).reshape(-1, 2).T
        reach = self.radii[a] + self.radii[b]
        looked_at, places = np.unique(np.concatenate([a, b]), return_inverse=True)
        starts, ends = _capsules(self.skeleton, positions, rotations, self.body, self.stature, looked_at.tolist())
        a, b = places.reshape(2, -1)
        if compiled.wanted():
            depth = np.empty((len(positions), len(self.pairs)))
            compiled.native.capsule_depths(starts, ends, a.astype(np.int32), b.astype(np.int32), reach, least, depth)
            return depth
        depth = np.full((len(positions), len(self.pairs)), -np.inf)
        # segments whose middles are farther apart than half their lengths and their radii cannot touch
        middles = 0.5 * (starts + ends)
        along = ends - starts
        half = 0.5 * np.sqrt(_dot(along, along))
        apart = middles[:, a] - middles[:, b]
        near = _dot(apart, apart) < (half[:, a] + half[:, b] + reach - least) ** 2
        frames, which = np.nonzero(near)
        first, second = (frames, a[which]), (frames, b[which])
        depth[near] = reach[which] - segment_distance(starts[first], ends[first], starts[second], ends[second])
        return depth


def self_collisions(
    motion: Motion, body: Anatomy | None = None, *, tolerance: float = DEPTH_TOLERANCE
) -> SelfCollisions:
    """Limbs that pass through each other or through the trunk (§2.9), as capsules round the bones.

    The trunk is two capsules, from between the hips to the middle of the spine and on to between the shoulders, as
    thick as a trunk is deep (it is wider than deep, so that an arm pressed to the side is let pass). Parts that meet at
    a joint are left out, and so are pairs that interpenetrate when this body stands in the T-pose.

    Parameters
    ----------
    body : which joints are the limbs; found if not given.
    tolerance : metres that two capsules may interpenetrate.

    Raises
    ------
    SkeletonError
        If the skeleton cannot be understood as a human body.
    """
    capsules = Capsules.of(motion, body, tolerance=tolerance)
    pairs = capsules.pairs
    depth = capsules.depths(motion.positions(), motion.global_rotations(), least=tolerance)
    deep = depth > tolerance
    out = []
    for k, (i, j) in enumerate(pairs):
        if deep[:, k].any():
            worst = int(np.argmax(depth[:, k]))
            out.append(Collision(_CAPSULES[i], _CAPSULES[j], int(deep[:, k].sum()), float(depth[worst, k]), worst))
    out.sort(key=lambda c: (-c.worst_depth, c.first, c.second))
    return SelfCollisions(len(pairs), tuple(out), int(deep.any(axis=1).sum()))


def capsule_radius(segment: str, stature: float) -> float:
    """Radius in metres of the cylinder with a segment's mass, density and length (Winter 2009, table and figure 4.1).

    Parameters
    ----------
    segment : "head", "femur", "tibia", "humerus" or "radius".
    stature : metres.
    """
    part = _SEGMENTS[segment]
    volume = part.mass * REFERENCE_MASS / part.density
    radius = np.sqrt(volume / (np.pi * part.length * REFERENCE_STATURE))
    return float(radius * stature / REFERENCE_STATURE)


def _capsules(
    skeleton: Skeleton,
    positions: Array,
    world: Array,
    body: Anatomy,
    stature: float,
    which: Sequence[int] = range(len(_CAPSULES)),
) -> tuple[Array, Array]:
    """Both ends of every capsule, or of some, metres, shape (frames, capsules, 3) each."""

    def at(role: str) -> Array:
        joint = getattr(body, role)
        assert joint is not None
        return np.asarray(positions[:, joint])

    def tip(joint: int, length: float, below: Array) -> Array:
        """The end site farthest from the joint, else a point straight on from the bone before."""
        sites = [np.array(s.offset) for s in skeleton.end_sites if s.parent == joint]
        sites += [skeleton.offsets[c] for c in skeleton.children[joint]]
        site = max(sites, key=lambda v: float(np.linalg.norm(v)), default=np.zeros(3))
        if np.linalg.norm(site) > 0.3 * length:
            return np.asarray(positions[:, joint] + quaternion.rotate(world[:, joint], site))
        along = positions[:, joint] - below
        norm = np.linalg.norm(along, axis=-1, keepdims=True)
        return np.asarray(positions[:, joint] + length * along / np.where(norm > 0.0, norm, 1.0))

    hips = 0.5 * (at("left_femur") + at("right_femur"))
    shoulders = 0.5 * (at("left_humerus") + at("right_humerus"))
    middle = 0.5 * (hips + shoulders) if not body.spine else positions[:, body.spine[len(body.spine) // 2]]
    starts = [hips, middle, positions[:, body.head]]
    ends = [middle, shoulders, tip(body.head, _HEAD_LENGTH * stature, shoulders)]
    for side in ("left", "right"):
        for upper, lower, last in (("femur", "tibia", "foot"), ("humerus", "radius", "hand")):
            joint = getattr(body, f"{side}_{lower}")
            below = getattr(body, f"{side}_{last}")
            near, hinge = at(f"{side}_{upper}"), at(f"{side}_{lower}")
            length = _SEGMENTS[lower].length * stature
            starts += [near, hinge]
            ends += [hinge, tip(joint, length, near) if below is None else positions[:, below]]
    picked = [[side[k] for k in which] for side in (starts, ends)]
    if not picked[0]:
        none = np.empty((len(positions), 0, 3))
        return none, none
    return np.stack(picked[0], axis=1), np.stack(picked[1], axis=1)


def _pairs(starts: Array, ends: Array, radii: Array, tolerance: float) -> list[tuple[int, int]]:
    """Pairs that do not meet at a joint and do not interpenetrate in the T-pose of a body of these lengths."""
    lengths = np.median(np.linalg.norm(ends - starts, axis=-1), axis=0)
    index = {name: k for k, name in enumerate(_CAPSULES)}
    low, high = np.zeros((len(_CAPSULES), 3)), np.zeros((len(_CAPSULES), 3))
    up, down = np.array([0.0, 1.0, 0.0]), np.array([0.0, -1.0, 0.0])
    waist = lengths[index["lower trunk"]] * up
    top = waist + lengths[index["upper trunk"]] * up
    neck = np.median(np.linalg.norm(starts[:, index["head"]] - ends[:, index["upper trunk"]], axis=-1))
    high[index["lower trunk"]], low[index["upper trunk"]], high[index["upper trunk"]] = waist, waist, top
    low[index["head"]] = top + neck * up
    high[index["head"]] = low[index["head"]] + lengths[index["head"]] * up
    for side, sign in (("left", 1.0), ("right", -1.0)):
        out = np.array([sign, 0.0, 0.0])
        for upper, lower, origin, along in (
            ("femur", "tibia", np.zeros(3), down),
            ("humerus", "radius", top, out),
        ):
            k, m = index[f"{side} {upper}"], index[f"{side} {lower}"]
            opposite = index[f"{'right' if side == 'left' else 'left'} {upper}"]
            width = np.median(np.linalg.norm(starts[:, k] - starts[:, opposite], axis=-1))
            low[k] = origin + 0.5 * width * out
            high[k] = low[m] = low[k] + lengths[k] * along
            high[m] = low[m] + lengths[m] * along
    pairs = []
    for i, j in combinations(range(len(_CAPSULES)), 2):
        if frozenset((_CAPSULES[i], _CAPSULES[j])) in _ADJACENT:
            continue
        depth = radii[i] + radii[j] - float(segment_distance(low[i], high[i], low[j], high[j]))
        if depth <= tolerance:
            pairs.append((i, j))
    return pairs


def segment_distance(a0: ArrayLike, a1: ArrayLike, b0: ArrayLike, b1: ArrayLike) -> Array:
    """How near the segments a0-a1 and b0-b1 come: shapes (..., 3), broadcast, to (...), metres.

    Ericson, *Real-Time Collision Detection* (2005), §5.1.9. Parallel segments and segments of no length are right too.
    """
    a0, b0 = np.asarray(a0, dtype=np.float64), np.asarray(b0, dtype=np.float64)
    along_a, along_b = np.asarray(a1, dtype=np.float64) - a0, np.asarray(b1, dtype=np.float64) - b0
    between = a0 - b0
    aa, bb, ab = _dot(along_a, along_a), _dot(along_b, along_b), _dot(along_a, along_b)
    a_gap, b_gap = _dot(along_a, between), _dot(along_b, between)
    across = aa * bb - ab * ab
    # parallel: any point of a will do to begin with, since what follows moves it to where it belongs
    crossing = across > 1e-12 * aa * bb
    s = np.where(crossing, np.clip((ab * b_gap - a_gap * bb) / np.where(crossing, across, 1.0), 0.0, 1.0), 0.0)
    t = np.clip(_ratio(ab * s + b_gap, bb), 0.0, 1.0)
    s = np.clip(_ratio(ab * t - a_gap, aa), 0.0, 1.0)
    nearest = between + s[..., None] * along_a - t[..., None] * along_b
    return np.asarray(np.sqrt(_dot(nearest, nearest)))


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("...i,...i->...", a, b))


def _ratio(numerator: Array, denominator: Array) -> Array:
    """0 where there is nothing to divide by: a segment of no length has one point."""
    positive = denominator > 0.0
    return np.asarray(np.where(positive, numerator / np.where(positive, denominator, 1.0), 0.0))
