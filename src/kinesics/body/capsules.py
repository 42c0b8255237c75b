"""The body as capsules round its bones, and which of them pass through each other ([Schultz2012] §2.9).

- `self_collisions`: limbs that pass through each other or through the trunk
- `Capsules`: where they are, and how deep each pair is in the other
- `segment_distance`: how near two straight segments come

Radii are those of cylinders with each segment's mass, density and length in Winter, *Biomechanics and Motor Control of
Human Movement* (4th ed. 2009), table 4.1 (masses, densities) and figure 4.1 (lengths, after Drillis & Contini 1966),
for a body mass index of 22 kg/m², scaled to the body's own stature; the trunk's is its half depth. People differ, flesh
gives way and markers slip: hence the tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics import compiled
from kinesics.body import anatomy
from kinesics.body.anatomy import Anatomy
from kinesics.body.motion import Motion
from kinesics.body.quality import estimated_stature
from kinesics.body.skeleton import Skeleton
from kinesics.geometry import quaternion

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

DEPTH_TOLERANCE: Final = 0.05
"""Metres that two capsules may interpenetrate: some 2 cm of flesh that gives way, 1 to 2 cm by which either radius may
be wrong, as much by which joint centres are misplaced."""
REFERENCE_STATURE: Final = 1.75
"""Metres. Radii are those of a body of this stature, other bodies are taken to be of the same shape."""
REFERENCE_MASS: Final = 22.0 * REFERENCE_STATURE**2
"""kg: a body mass index of 22 kg/m², the middle of what the World Health Organization calls normal."""


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
class Collision:
    """Two parts of the body that pass through each other."""

    first: str
    second: str
    frames: int
    """How many frames are deeper than the tolerance."""
    worst_depth: float
    """Metres by which the capsules interpenetrate at worst, tolerance not deducted."""
    worst_frame: int


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
        bones = _Bones.of(motion.skeleton, body, stature)
        starts, ends = bones.ends(motion.positions(), motion.global_rotations())
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
        return self._bones.ends(positions, rotations)

    def depths(self, positions: Array, rotations: Array, *, least: float = 0.0) -> Array:
        """Metres by which each pair interpenetrates, −∞ where by less than about ``least``: shape (frames, pairs)."""
        bones, a, b, reach = self._looked_at
        return depths_between(bones.ends(positions, rotations), a, b, reach, least=least)

    @cached_property
    def _bones(self) -> _Bones:
        return _Bones.of(self.skeleton, self.body, self.stature)

    @cached_property
    def _looked_at(self) -> tuple[_Bones, Indices, Indices, Array]:
        """The capsules that any pair is of; of each pair the two among these, and the sum of their radii."""
        a, b = np.array(self.pairs, dtype=np.intp).reshape(-1, 2).T
        which, places = np.unique(np.concatenate([a, b]), return_inverse=True)
        first, second = places.reshape(2, -1)
        return self._bones.of_some(which.tolist()), first, second, self.radii[a] + self.radii[b]


def depths_between(capsules: Ends, a: Indices, b: Indices, reach: Array, *, least: float = 0.0) -> Array:
    """Metres by which pairs of capsules interpenetrate, −∞ where by less than about ``least``: shape (frames, pairs).

    Parameters
    ----------
    a, b : the capsules of each pair, shape (pairs,).
    reach : the sum of their radii, metres, shape (pairs,).
    """
    starts, ends = capsules
    depth = np.empty((len(starts), len(reach)))
    if compiled.wanted():
        compiled.native.capsule_depths(starts, ends, a.astype(np.int32), b.astype(np.int32), reach, least, depth)
        return depth
    depth[:] = -np.inf
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


class _Bones(NamedTuple):
    """From which joints capsules reach to which."""

    joints: Indices
    """Where each starts and ends, all starts before all ends, shape (2 capsules,)."""
    between: tuple[tuple[int, tuple[int, ...]], ...]
    """Of the same the ends that lie between several joints instead."""
    tips: tuple[tuple[int, Array], ...]
    """Those that lie at a place in the frame of their joint, metres."""
    beyond: tuple[tuple[int, float, tuple[int, ...]], ...]
    """Those that lie so many metres beyond their joint, straight on from other joints."""

    @classmethod
    def of(cls, skeleton: Skeleton, body: Anatomy, stature: float) -> _Bones:
        def at(role: str) -> int:
            joint = getattr(body, role)
            assert joint is not None
            return int(joint)

        hips, shoulders = ((at(f"left_{part}"), at(f"right_{part}")) for part in ("femur", "humerus"))
        middle = (body.spine[len(body.spine) // 2],) if body.spine else (*hips, *shoulders)
        starts: list[tuple[int, ...]] = [hips, middle, (body.head,)]
        ends: list[tuple[int, ...]] = [middle, shoulders, (body.head,)]
        open_ends: list[tuple[int, float, tuple[int, ...]]] = [(2, _HEAD_LENGTH * stature, shoulders)]
        for side in ("left", "right"):
            for upper, lower, last in (("femur", "tibia", "foot"), ("humerus", "radius", "hand")):
                near, hinge, below = at(f"{side}_{upper}"), at(f"{side}_{lower}"), getattr(body, f"{side}_{last}")
                if below is None:
                    open_ends.append((len(ends) + 1, _SEGMENTS[lower].length * stature, (near,)))
                starts += [(near,), (hinge,)]
                ends += [(hinge,), (hinge if below is None else below,)]
        both = starts + ends
        tips, beyond = [], []
        for k, length, above in open_ends:
            (joint,) = ends[k]
            # the end site farthest from the joint, else a point straight on from the bone before
            sites = [np.array(s.offset) for s in skeleton.end_sites if s.parent == joint]
            sites += [skeleton.offsets[c] for c in skeleton.children[joint]]
            site = max(sites, key=lambda v: float(np.linalg.norm(v)), default=np.zeros(3))
            if np.linalg.norm(site) > 0.3 * length:
                tips.append((len(starts) + k, site))
            else:
                beyond.append((len(starts) + k, length, above))
        return cls(
            np.array([joints[0] for joints in both]),
            tuple((k, joints) for k, joints in enumerate(both) if len(joints) > 1),
            tuple(tips),
            tuple(beyond),
        )

    def of_some(self, which: Sequence[int]) -> _Bones:
        """Of some of the capsules, in this order."""
        count = len(self.joints) // 2
        place = {k: n for n, k in enumerate([*which, *(count + w for w in which)])}
        return _Bones(
            self.joints[list(place)],
            tuple((place[k], joints) for k, joints in self.between if k in place),
            tuple((place[k], site) for k, site in self.tips if k in place),
            tuple((place[k], length, above) for k, length, above in self.beyond if k in place),
        )

    def ends(self, positions: Array, world: Array) -> Ends:
        """Where they are, by where all joints are in the world: (frames, joints, 3) and (frames, joints, 4)."""
        out = positions[:, self.joints]
        for k, joints in self.between:
            out[:, k] = _middle(positions, joints)
        for k, site in self.tips:
            out[:, k] += quaternion.rotate(world[:, self.joints[k]], site)
        for k, length, above in self.beyond:
            along = out[:, k] - _middle(positions, above)
            norm = np.linalg.norm(along, axis=-1, keepdims=True)
            out[:, k] += length * along / np.where(norm > 0.0, norm, 1.0)
        count = len(self.joints) // 2
        return Ends(np.ascontiguousarray(out[:, :count]), np.ascontiguousarray(out[:, count:]))


def _middle(positions: Array, joints: tuple[int, ...]) -> Array:
    """Of two joints, or of the middles of two pairs of them, or one joint's place, shape (frames, 3)."""
    if len(joints) == 1:
        return np.asarray(positions[:, joints[0]])
    half = len(joints) // 2
    return np.asarray(0.5 * (_middle(positions, joints[:half]) + _middle(positions, joints[half:])))


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
