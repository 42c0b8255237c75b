"""The feet of a body in a recording: their ankles and balls, the floor beneath them and their soles."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.body import anatomy
from kinesics.body.anatomy import Anatomy
from kinesics.body.floor import Floor, plane
from kinesics.body.motion import Motion
from kinesics.body.stature import LEG_TO_STATURE
from kinesics.body.touching import HEIGHT_ON, SPEED_MOST, SPEED_ON, SPEED_SHARE, speeds_of
from kinesics.errors import SkeletonError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_GRAVITY: Final = 9.80665
_ANKLE_HEIGHT: Final = 0.039
"""Share of the stature (Drillis & Contini 1966; Winter 2009, fig. 4.1)."""
_BALL_HEIGHT: Final = (0.009, 0.025)
"""Least and most of the same of the joint at the ball of the foot: 1.5 and 4.5 cm; between them, what the ankle's height
less the drop from ankle to ball in a flat foot leaves."""
_HEEL_BACK: Final = 0.036
"""Share of the stature that the heel lies behind the ankle: a quarter of the foot's length of .152."""
_BALL_AHEAD: Final = 0.076
_TIP_AHEAD: Final = 0.035
"""From the ball to the tip of the toes, where the skeleton has none."""
POINTS: Final = ("heel", "ball", "tip")
"""The points of a sole, in the order of every array here."""


@dataclass(frozen=True, eq=False)
class Soles:
    """Heel, ball and tip of both feet, in the frames of the joints that carry them."""

    joints: NDArray[np.intp]
    """Joint that carries each point, shape (2, 3): left and right; heel, ball, tip."""
    offsets: Array
    """In the frame of that joint, metres, shape (2, 3, 3)."""

    def place(self, positions: Array, rotations: Array) -> Array:
        """Where the points are in the world, metres, shape (frames, 2, 3, 3).

        Parameters
        ----------
        positions, rotations : of all joints in the world, shapes (frames, joints, 3) and (frames, joints, 4).
        """
        if compiled.wanted():
            out = np.empty((len(positions), self.joints.size, 3))
            compiled.native.carried_points(
                np.ascontiguousarray(positions, dtype=np.float64),
                np.ascontiguousarray(rotations, dtype=np.float64),
                self.joints.ravel().astype(np.int32),
                np.ascontiguousarray(self.offsets.reshape(-1, 3)),
                out,
            )
            return out.reshape(len(positions), *self.offsets.shape)
        return positions[:, self.joints] + quaternion.rotate(rotations[:, self.joints], self.offsets)


@dataclass(frozen=True, eq=False)
class Feet:
    """Feet as a recording tells them, before it is known when they bear: what all of `kinesics.body.contacts` begins with."""

    body: Anatomy
    motion: Motion
    positions: Array
    rotations: Array
    stature: float
    slow: float
    """m/s."""
    ankles: Array
    """Shape (frames, 2, 3)."""
    balls: Array | None
    """The same of the toe joints, or of what ends the foot where it has none; None where there is nothing."""
    bearing: Mask
    """Frames in which each foot is slow and as low as it gets, shape (frames, 2)."""
    floor: Floor
    thick: float
    """Height of the ball's joint (the ankle's, where there is no ball) above the sole, metres."""

    @classmethod
    def of(cls, motion: Motion, mapping: Mapping[str, object] | None, ground: Floor | None = None) -> Feet:
        """Those of a motion.

        Raises
        ------
        SkeletonError
            If the skeleton cannot be understood as a human body, or its legs have no ends.
        """
        body = anatomy.resolve(motion, mapping)
        positions, rotations = motion.positions(), motion.global_rotations()
        leg = _leg_length(motion, body)
        stature = leg / LEG_TO_STATURE
        ankles = np.stack([_ankle(motion, body, side, positions, rotations) for side in ("left", "right")], axis=1)
        tips = [_forefoot(motion, body, side) for side in ("left", "right")]
        balls = None
        if tips[0] is not None and tips[1] is not None:
            balls = np.stack(
                [positions[:, j] + quaternion.rotate(rotations[:, j], offset) for j, offset in (tips[0], tips[1])],
                axis=1,
            )
        forefoot = ankles if balls is None else balls
        speeds = speeds_of(forefoot, motion.fps)
        froude = np.sqrt(_GRAVITY * leg)
        quick = float(np.quantile(speeds, 0.95)) if len(speeds) > 1 else 0.0
        slow = min(max(SPEED_ON * froude, SPEED_SHARE * quick), SPEED_MOST * froude)
        bed = plane(forefoot, speeds < slow, motion.fps, stature)
        bearing = (forefoot[..., 1] - bed.at(forefoot) < HEIGHT_ON * stature) & (speeds < slow)
        thick = _ANKLE_HEIGHT * stature
        if balls is not None:
            above = (ankles - balls)[..., 1]
            flat = float(np.quantile(above[bearing], 0.25)) if bearing.any() else float(above.min())
            thick = min(max(thick - flat, _BALL_HEIGHT[0] * stature), _BALL_HEIGHT[1] * stature)
        floor = dataclasses.replace(bed, height=bed.height - thick) if ground is None else ground
        return cls(body, motion, positions, rotations, stature, slow, ankles, balls, bearing, floor, thick)

    def soles(self) -> Soles:
        """Heel, ball and tip of both feet, as they lie on the floor while the feet stand flat."""
        joints = np.zeros((2, 3), dtype=np.intp)
        offsets = np.zeros((2, 3, 3))
        skeleton, roles, h = self.motion.skeleton, self.body.roles, self.stature
        for k, side in enumerate(("left", "right")):
            foot = getattr(roles, f"{side}_foot")
            foot = getattr(roles, f"{side}_tibia") if foot is None else foot
            toes = getattr(roles, f"{side}_toes")
            joints[k] = foot, foot, foot if toes is None else toes
            flat = self._flat(k)
            ankle = self.ankles[flat, k]
            ahead = self._ahead(k, flat)
            ball = ankle + _BALL_AHEAD * h * ahead if self.balls is None else self.balls[flat, k]
            tip = ball + _TIP_AHEAD * h * ahead
            bears, forefoot = bool(self.bearing[:, k].any()), ankle if self.balls is None else ball
            if toes is not None:
                sites = [np.array(s.offset) for s in skeleton.end_sites if s.parent == toes]
                site = max(sites, key=lambda v: float(np.linalg.norm(v)), default=np.zeros(3))
                if np.linalg.norm(site) > 0.01 * h:
                    tip = self.positions[flat, toes] + quaternion.rotate(self.rotations[flat, toes], site)
            for n, point in enumerate((ankle - _HEEL_BACK * h * ahead, ball, tip)):
                # flat on the floor means: on the floor; a foot that never came down has its sole below itself
                on_floor = point.copy()
                on_floor[:, 1] = self.floor.at(point) if bears else forefoot[:, 1] - self.thick
                j = joints[k, n]
                local = quaternion.rotate(
                    quaternion.conjugate(self.rotations[flat, j]), on_floor - self.positions[flat, j]
                )
                offsets[k, n] = np.median(local, axis=0)
        return Soles(joints, offsets)

    def _flat(self, k: int) -> NDArray[np.intp]:
        """Frames in which foot k stands flat: it bears and its ankle is about as low as it then gets."""
        bears = np.nonzero(self.bearing[:, k])[0]
        if len(bears) == 0:
            bears = np.array([int(np.argmin(self.ankles[:, k, 1]))])
        height = self.ankles[bears, k, 1]
        low = np.quantile(height, 0.25)
        return np.asarray(bears[np.abs(height - low) <= max(0.004 * self.stature, float(np.abs(height - low).min()))])

    def _ahead(self, k: int, frames: NDArray[np.intp]) -> Array:
        """Horizontal unit vectors the way foot k points, shape (len(frames), 3)."""
        forward = np.array([0.0, 0.0, 1.0])
        if self.balls is not None:
            vectors = self.balls[frames, k] - self.ankles[frames, k]
        else:
            pelvis = self.body.pelvis
            vectors = quaternion.rotate(
                quaternion.multiply(self.rotations[frames, pelvis], self.body.frames[pelvis]), forward
            )
        vectors = vectors * np.array([1.0, 0.0, 1.0])
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        return np.where(length > 1e-9, vectors / np.where(length > 1e-9, length, 1.0), forward)


def _leg_length(motion: Motion, body: Anatomy) -> float:
    skeleton = motion.skeleton
    total = 0.0
    for side in ("left", "right"):
        joint, chain = getattr(body, f"{side}_foot"), 0.0
        femur, tibia = getattr(body, f"{side}_femur"), getattr(body, f"{side}_tibia")
        if joint is None:
            chain = max((float(np.linalg.norm(s.offset)) for s in skeleton.end_sites if s.parent == tibia), default=0.0)
            joint = tibia
        while joint != femur:
            chain += float(np.linalg.norm(skeleton.offsets[joint]))
            joint = skeleton.parents[joint]
        total += chain / 2.0
    if total <= 0.0:
        raise SkeletonError("The legs of this skeleton have no length, so that nothing tells where its feet are.")
    return total


def _ankle(motion: Motion, body: Anatomy, side: str, positions: Array, rotations: Array) -> Array:
    foot = getattr(body, f"{side}_foot")
    if foot is not None:
        return np.asarray(positions[:, foot])
    tibia = getattr(body, f"{side}_tibia")
    sites = [np.array(s.offset) for s in motion.skeleton.end_sites if s.parent == tibia]
    if not sites:
        raise SkeletonError(
            f"The {side} leg ends at joint '{motion.skeleton.joint_names[tibia]}': there is no foot and no end site.",
            missing=(f"{side}_foot",),
        )
    site = max(sites, key=lambda v: float(np.linalg.norm(v)))
    return np.asarray(positions[:, tibia] + quaternion.rotate(rotations[:, tibia], site))


def _forefoot(motion: Motion, body: Anatomy, side: str) -> tuple[int, Array] | None:
    """(joint, offset in its frame) of the ball of the foot: the toe joint, else what the foot ends in."""
    toes, foot = getattr(body, f"{side}_toes"), getattr(body, f"{side}_foot")
    if toes is not None:
        return toes, np.zeros(3)
    if foot is None:
        return None
    ends = [np.array(s.offset) for s in motion.skeleton.end_sites if s.parent == foot]
    ends += [motion.skeleton.offsets[c] for c in motion.skeleton.children[foot]]
    end = max(ends, key=lambda v: float(np.linalg.norm(v)), default=np.zeros(3))
    return (foot, end) if np.linalg.norm(end) > 0.0 else None
