"""How far joints go in the recordings, and joints put back that would go farther ([Schultz2012] §2.9: Cfree).

A joint's angles are two things, and it keeps within both: the components of its rotation vector from its mean, by which it is
turned (`Stage.low`, `Stage.high`), and the angle that each bone which hangs on it makes with the bone before, which is what one
measures on a body: knee, elbow, or the ankle between shank and toes. Of two components each may be within while both together
bend a foot farther than it ever was; and between two postures of a hand, each as recorded, another lies in which it is straighter.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.body.skeleton import Skeleton
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

YIELD: Final = 0.05
"""Seconds before and after over which a joint goes back that would go beyond its range."""
ROUNDING: Final = 1e-9
"""Radians beyond a range that are none."""
STRAIGHT: Final = np.deg2rad(1.0)
"""A bone that came so near to the line of the one before may lie in it: markers tell no straighter one."""
_SHORTEST: Final = 1e-3
"""Metres: of a shorter bone no direction is told."""
_STEPS: Final = 16
"""Most steps along the slope by which a joint comes back."""
_LEVEL: Final = 1e-6
"""Square of the slope, no components left out that are at their end, of which less leads nowhere."""
_HALVINGS: Final = 40
_SOME: Final = 4000
"""Frames that are looked at for a posture well within all ranges."""


class Bends(NamedTuple):
    """The angles between bones that meet at one joint, and how far they go."""

    along: Array
    """Direction of the bone before, in the frame of the joint's mean rotation, shape (bends, 3)."""
    own: Array
    """Directions of bones that hang on the joint, in its own frame, shape (bends, 3)."""
    least: Array
    """Radians, shape (bends,): 0 straight on, π folded back."""
    most: Array

    def angles(self, vectors: Array) -> Array:
        """Of rotation vectors from the mean, shape (n, 3) to (n, bends)."""
        points = quaternion.rotate(quaternion.from_rotvec(vectors)[:, None], self.own)
        return _angle(self.along, points)

    def over(self, vectors: Array) -> Array:
        """Radians by which each angle is too large, negative if too small, 0 within: (n, 3) to (n, bends)."""
        angles = self.angles(vectors)
        return np.asarray(np.maximum(angles - self.most, 0.0) + np.minimum(angles - self.least, 0.0))

    def slope(self, vectors: Array, which: Indices) -> Array:
        """What one angle of each vector grows by as its components do, shapes (n, 3) and (n,) to (n, 3)."""
        q = quaternion.from_rotvec(vectors)
        along, own = quaternion.rotate(quaternion.conjugate(q), self.along[which]), self.own[which]
        about = np.cross(along, own)
        sine = np.linalg.norm(about, axis=-1, keepdims=True)
        about = np.where(sine > 1e-12, about / np.maximum(sine, 1e-12), 0.0)
        # that is of a turn in the joint's own frame; by which it turns as its rotation vector changes
        size = np.linalg.norm(vectors, axis=-1, keepdims=True)
        far = np.where(size > 1e-3, size, 1.0)
        first = np.where(size > 1e-3, (1.0 - np.cos(far)) / far**2, 0.5)
        second = np.where(size > 1e-3, (far - np.sin(far)) / far**3, 1.0 / 6.0)
        once = np.cross(vectors, about)
        return np.asarray(about + first * once + second * np.cross(vectors, once))


@dataclass(frozen=True, eq=False)
class Ranges:
    """How far each joint of a body goes, but for those that carry it whole."""

    middle: Array
    """Mean rotations, shape (joints, 4)."""
    low: Array
    """Least and greatest component of the rotation vector from there, radians, shape (joints, 3)."""
    high: Array
    inner: Array
    """Rotation vectors of a posture as recorded that is well within, shape (joints, 3)."""
    bends: tuple[Bends, ...]
    """Of each joint."""
    first: int
    """Joints before that carry the body whole, and go wherever it goes."""

    @classmethod
    def of(cls, stage: Stage) -> Ranges:
        """Of the recordings of a stage; measured once and kept as long as those are."""
        return stage.repertoire.kept(cls._measured)

    @classmethod
    def _measured(cls, repertoire: Repertoire) -> Ranges:
        stage = Stage.of(repertoire)
        joints, first = repertoire.skeleton.joint_count, stage.carrier + 1
        images = 2 if repertoire.mirrored else 1
        rotations = repertoire.rotations[:images].reshape(-1, joints, 4)
        some = rotations[:: max(1, len(rotations) // _SOME)]
        bends, inner = [], np.zeros((joints, 3))
        for j in range(joints):
            along, own = _bones(repertoire.skeleton, j) if j >= first else (np.zeros(3), np.zeros((0, 3)))
            along = quaternion.rotate(quaternion.conjugate(stage.middle[j]), along)
            least, most = np.zeros((2, len(own)))
            for k, bone in enumerate(own):
                turned = quaternion.multiply(quaternion.conjugate(stage.middle[j]), rotations[:, j])
                directions = quaternion.rotate(turned, bone)
                angles = _angle(along, directions)
                least[k], most[k] = angles.min(), angles.max()
                if _to_all_sides(along, directions):
                    least[k] = 0.0
            least[least < STRAIGHT], most[most > np.pi - STRAIGHT] = 0.0, np.pi
            bends.append(Bends(np.broadcast_to(along, own.shape).copy(), own, least, most))
            inner[j] = _well_within(
                blending.rotation_offset(stage.middle[j], some[:, j]), stage.low[j], stage.high[j], bends[-1]
            )
        return cls(stage.middle, stage.low, stage.high, inner, tuple(bends), first)

    def within(self, joint: int, vectors: Array) -> Array:
        """A joint's rotation vectors from its mean, each moved as little as need be to be within its range: (n, 3) to the same.

        Components are cut off at their ends; then the angle that is farthest beyond is changed along its slope, components
        that are at their end left out, until none is beyond. Where that leads nowhere it goes towards what is well within.
        """
        if compiled.wanted():
            out = np.array(vectors, dtype=np.float64, order="C")
            self.native.within(joint, out)
            return out
        low, high, bends = self.low[joint], self.high[joint], self.bends[joint]
        out = np.clip(vectors, low, high)
        if not len(bends.own):
            return out
        some = np.arange(len(out))
        for step in range(_STEPS + 1):
            over = bends.over(out[some])
            worst = np.abs(over).argmax(axis=1)
            over = over[np.arange(len(some)), worst]
            still = np.abs(over) > ROUNDING
            some, over = some[still], over[still]
            if not len(some) or step == _STEPS:
                break
            at, slope = out[some], bends.slope(out[some], worst[still])
            goes = -over[:, None] * slope
            slope[((goes > 0.0) & (at >= high)) | ((goes < 0.0) & (at <= low))] = 0.0
            size = np.square(slope).sum(axis=1)
            by = np.where(size < _LEVEL, 0.0, over / np.maximum(size, _LEVEL))
            out[some] = np.clip(at - by[:, None] * slope, low, high)
        good, bad = np.ones(len(some)), np.zeros(len(some))
        towards = self.inner[joint] - out[some]
        for _ in range(_HALVINGS if len(some) else 0):
            share = 0.5 * (good + bad)
            beyond = np.abs(bends.over(out[some] + share[:, None] * towards)).max(axis=1) > ROUNDING
            good, bad = np.where(beyond, good, share), np.where(beyond, share, bad)
        out[some] += good[:, None] * towards
        return out

    def over(self, joints: Indices, vectors: Array) -> Array:
        """By how much joints (...) are beyond what `within` makes of them, shape (frames, ..., 3) to the same."""
        out = np.empty_like(vectors)
        for at in np.ndindex(joints.shape):
            here = (slice(None), *at)
            out[here] = vectors[here] - self.within(int(joints[at]), vectors[here])
        return out

    def hold(self, rotations: Array, back: Array | None = None) -> None:
        """Keep the joints of one moment within their ranges, rotations of shape (joints, 4), in place.

        Parameters
        ----------
        back : by which each is turned back first, as a rotation vector in the frame of its mean, radians, shape (joints, 3).
        """
        if compiled.wanted():
            if back is None:
                self.native.hold(rotations, self.first)
            else:
                self.native.hold_back(rotations, self.first, back)
            return
        vectors = blending.rotation_offset(self.middle, rotations)
        for joint in range(self.first, len(rotations)):
            asked = vectors[joint] if back is None else vectors[joint] - back[joint]
            held = self.within(joint, asked[None])[0]
            if np.abs(held - asked).sum() >= ROUNDING or (back is not None and back[joint].any()):
                rotations[joint] = blending.add_rotation(self.middle[joint], held)

    def excess(self, rotations: Array) -> Array | None:
        """What `hold` would turn each joint of one moment back by, shape (joints, 4) to (joints, 3); None if nothing."""
        if compiled.wanted():
            out = np.empty((len(rotations), 3))
            return out if self.native.excess(rotations, self.first, out) else None
        vectors = blending.rotation_offset(self.middle, rotations)
        out = np.zeros_like(vectors)
        for joint in range(self.first, len(rotations)):
            over = vectors[joint] - self.within(joint, vectors[joint : joint + 1])[0]
            if np.abs(over).sum() >= ROUNDING:
                out[joint] = over
        return out if out.any() else None

    def beyond(self, rotations: Array) -> Array:
        """Radians by which each joint is beyond its range, shape (frames, joints, 4) to (frames, joints)."""
        vectors = blending.rotation_offset(self.middle, rotations)
        out = np.maximum(np.maximum(self.low - vectors, vectors - self.high), 0.0).max(axis=-1)
        for joint, bends in enumerate(self.bends):
            if len(bends.own):
                over = np.abs(bends.over(vectors[:, joint])).max(axis=1)
                out[:, joint] = np.maximum(out[:, joint], over)
        out[:, : self.first] = 0.0
        return np.asarray(out)

    @functools.cached_property
    def native(self) -> compiled.native.Ranges:
        """The same for compiled code."""
        middle, low, high, inner = map(np.ascontiguousarray, (self.middle, self.low, self.high, self.inner))
        bent = [joint for joint, bends in enumerate(self.bends) for _ in bends.own]
        rows = [np.concatenate([b.along, b.own, b.least[:, None], b.most[:, None]], axis=1) for b in self.bends]
        return compiled.native.Ranges(middle, low, high, inner, bent, np.concatenate(rows))


def _bones(skeleton: Skeleton, joint: int) -> tuple[Array, Array]:
    """Direction of the bone before a joint, in its parent's frame, (3,), and of those that hang on it, in its own, (bones, 3)."""
    own = [skeleton.offsets[child] for child in skeleton.children[joint]]
    own += [np.asarray(site.offset) for site in skeleton.end_sites if site.parent == joint]
    size = float(np.linalg.norm(skeleton.offsets[joint]))
    long = [bone / np.linalg.norm(bone) for bone in own if size > _SHORTEST and np.linalg.norm(bone) > _SHORTEST]
    return skeleton.offsets[joint] / max(size, _SHORTEST), np.array(long).reshape(-1, 3)


def _angle(a: Array, b: Array) -> Array:
    """Between directions, radians: exact also where they are nearly the same."""
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.einsum("...i,...i->...", a, b)))


def _to_all_sides(along: Array, directions: Array) -> bool:
    """Whether a bone is bent to all sides of straight on, which then lies between: it may be straighter than it ever was.

    Kept from it, a hand that goes from one side to the other would have to leap across.

    Parameters
    ----------
    along : straight on, shape (3,).
    directions : of the bone, shape (n, 3).
    """
    aside = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    other = np.cross(along, aside)
    towards = np.sort(np.arctan2(directions @ other, directions @ aside))
    widest = max(float(np.diff(towards).max(initial=0.0)), float(towards[0] + 2.0 * np.pi - towards[-1]))
    return widest < np.pi


def _well_within(vectors: Array, low: Array, high: Array, bends: Bends) -> Array:
    """That of some rotation vectors (n, 3) which is farthest from all ends, as a share of each range."""
    at = np.concatenate([vectors, bends.angles(vectors)], axis=1)
    least, most = np.concatenate([low, bends.least]), np.concatenate([high, bends.most])
    turns = most - least > ROUNDING
    if not turns.any():
        return np.asarray(vectors[0])
    share = (at - least)[:, turns] / (most - least)[turns]
    return np.asarray(vectors[np.minimum(share, 1.0 - share).min(axis=1).argmax()])


def put_within_range(stage: Stage, rotations: Array, joints: Indices, where: Mask | None = None) -> None:
    """Put joints back into the range that they have in the recordings, over a stretch of time rather than at once.

    Parameters
    ----------
    rotations : shape (frames, joints, 4); changed in place.
    joints : numbers of those looked at.
    where : frames in which a joint can be beyond at all.
    """
    ranges = Ranges.of(stage)
    reach = max(1, round(YIELD * stage.repertoire.fps))
    frames = np.arange(len(rotations)) if where is None else np.nonzero(where)[0]
    over = ranges.over(joints, blending.rotation_offset(stage.middle[joints], rotations[np.ix_(frames, joints)]))
    over[np.abs(over) <= ROUNDING] = 0.0
    for n, joint in enumerate(joints.tolist()):
        if not over[:, n].any():
            continue
        back = np.zeros((len(rotations), 3))
        back[frames] = over[:, n]
        back = both_ways(back, reach)
        goes = np.flatnonzero(back.any(axis=1))
        at = blending.rotation_offset(stage.middle[joint], rotations[goes, joint]) - back[goes]
        put_joint(rotations, goes, joint, blending.add_rotation(stage.middle[joint], ranges.within(joint, at)))


def put_joint(rotations: Array, frames: Indices, joint: int, q: Array) -> None:
    """Turn a joint as told in some frames; signs stay as they were, so that from frame to frame they do not change."""
    sign = np.copysign(1.0, np.einsum("fi,fi->f", q, rotations[frames, joint]))
    rotations[frames, joint] = sign[:, None] * q


def envelope(values: Array, reach: int) -> Array:
    """A smooth curve that is nowhere below ``values`` (frames,), which are not negative: it rises and falls over ``reach``.

    The greatest within ``reach`` frames, averaged under a Hann window of the same reach.
    """
    if not values.any():
        return np.zeros_like(values)
    if compiled.wanted():
        out = np.empty(len(values))
        compiled.native.envelope(np.ascontiguousarray(values, dtype=np.float64), hann(reach), out)
        return out
    from scipy.ndimage import maximum_filter1d

    wide = maximum_filter1d(values, 2 * reach + 1, mode="nearest")
    return smooth(wide, reach)


def both_ways(values: Array, reach: int) -> Array:
    """`envelope` of vectors (frames, n): of what each component is above 0, and of what it is below."""
    return np.stack(
        [envelope(np.maximum(v, 0.0), reach) - envelope(np.maximum(-v, 0.0), reach) for v in values.T], axis=-1
    )


def smooth(values: Array, reach: int) -> Array:
    """Averaged under a Hann window of ``reach`` frames to either side."""
    return np.convolve(np.pad(values, reach, mode="edge"), hann(reach), "valid")


@functools.cache
def hann(reach: int) -> Array:
    """A Hann window of ``reach`` frames to either side, sum 1."""
    window = np.hanning(2 * reach + 3)[1:-1]
    return np.asarray(window / window.sum())
