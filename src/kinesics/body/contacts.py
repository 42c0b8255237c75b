"""Feet on the ground: where the floor is, when a foot bears on it, and with which part of its sole.

A skeleton has an ankle and, mostly, a toe joint, but no heel and no skin. `soles` finds from a recording what is missing:
while a foot stands flat its heel, ball and tip lie on the floor, which fixes them in the frames of its joints. A point of
the sole bears while it is low and slow (`contacts`):

- low: within `HEIGHT_ON` of the level it usually bears at, as a share of the stature, and until it is above `HEIGHT_OFF`;
- slow: below ``SPEED_ON · √(g·leg)`` (a Froude number, so that bodies of all sizes and planets are alike) or, in quick
  movement, `SPEED_SHARE` of the foot's own quick speed, and until it is half as fast again;
- gaps shorter than `SHORTEST_GAP` are closed and touches shorter than `SHORTEST_TOUCH` left out.

Speed thresholds for heel and toe are those of Ghoussayni, Stevens, Durham & Ewins 2004 (*Gait & Posture* 20:266), grown
with the speed of going as Bruening & Ridge 2014 (*Gait & Posture* 39:472) found necessary; two thresholds in place of one
because a single one chatters. The floor is a plane; it may tilt by a few degrees, for the floors of recordings do (`Floor`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.body import anatomy
from kinesics.body.anatomy import Anatomy
from kinesics.body.motion import Motion
from kinesics.body.quality import LEG_TO_STATURE
from kinesics.errors import SkeletonError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

POINTS: Final = ("heel", "ball", "tip")
"""The points of a sole, in the order of every array here."""

HEIGHT_ON: Final = 0.018
"""Share of the stature: 3 cm of a grown man. A sole is soft, a marker slips, and a floor is never quite level."""
HEIGHT_OFF: Final = 0.030
SPEED_ON: Final = 0.10
"""Times √(g·leg length), which is 2.9 m/s for a grown man: .3 m/s, six times what Ghoussayni et al. take for bare feet."""
SPEED_SHARE: Final = 0.10
"""Of the 95th percentile of the foot's speed: .4 m/s in a walk, .8 m/s in a run."""
SPEED_MOST: Final = 0.30
"""Times √(g·leg length): beyond it a foot slides or flies."""
SPEED_OFF: Final = 1.5
"""Times the speed at which a point begins to bear."""
SHORTEST_GAP: Final = 0.06
"""Seconds. No foot is lifted and set down again in less."""
SHORTEST_TOUCH: Final = 0.06
"""Seconds. A sprinter's foot bears for a tenth of a second."""

USUAL_SLOPE: Final = 0.03
"""Metres a metre, one standard deviation: 2°. Floors of recordings tilt by as much."""
_LEVEL_SPREAD: Final = 0.006
"""Share of the stature, one standard deviation, by which places of rest lie off a plane: 1 cm."""
_TILT_BAND: Final = 0.06
"""Share of the stature: what rests 10 cm off the floor is no tilt."""

_GRAVITY: Final = 9.80665
_SPAN: Final = 1.0 / 60.0
"""Seconds to either side over which a speed is measured: half a frame at 30 fps, two at 120."""
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
_FOOT_MOST: Final = 0.25
"""Share of the stature: what reaches farther is no foot."""


@dataclass(frozen=True)
class Floor:
    """A plane that the feet bear on: in many recordings it tilts by a degree or three, as the cameras were calibrated."""

    height: float
    """At x = z = 0, metres."""
    slope_x: float = 0.0
    """Rise along +x, metres a metre."""
    slope_z: float = 0.0

    def at(self, points: Array) -> Array:
        """Height of the floor below points (..., 3), metres, shape (...)."""
        return np.asarray(self.height + self.slope_x * points[..., 0] + self.slope_z * points[..., 2])


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
class Contacts:
    """When the feet bear on the ground, and with what."""

    feet: Mask
    """Left and right foot on the ground, shape (frames, 2)."""
    points: Mask
    """Heel, ball and tip of each on the ground, shape (frames, 2, 3); a foot bears while any of them does."""
    positions: Array
    """Where these points are, metres, shape (frames, 2, 3, 3)."""
    levels: Array
    """Height above the floor at which each point bears, metres, shape (2, 3)."""
    floor: Floor
    soles: Soles
    slow: float
    """Speed below which a point begins to bear, m/s."""
    stature: float
    """Of the body, told by its legs, metres."""


def foot_contacts(motion: Motion, mapping: Mapping[str, object] | None = None) -> Mask:
    """Whether the left and the right foot bear on the ground in each frame, shape (frames, 2).

    Parameters
    ----------
    mapping : as for `kinesics.body.anatomy.resolve`.

    Raises
    ------
    SkeletonError
        If the skeleton cannot be understood as a human body, or its legs have no ends.
    """
    return contacts(motion, mapping).feet


def floor(motion: Motion, mapping: Mapping[str, object] | None = None) -> Floor:
    """The plane that the feet bear on.

    It is laid through the places at which the ball of a foot (the ankle, where there are no toes) comes to rest, as far as
    they are low; its tilt is held back by what is usual (`USUAL_SLOPE`), so that a few steps on one spot do not tilt it.
    From there it is put lower by the height of that joint above the sole in a body of this stature: true to 1 or 2 cm, for
    no skeleton tells how thick a sole is, but the same for all recordings of one body.

    Raises
    ------
    SkeletonError
        As `foot_contacts`.
    """
    return _Feet.of(motion, mapping).floor


def floor_height(motion: Motion, mapping: Mapping[str, object] | None = None) -> float:
    """Height of the floor in the middle of where the body goes, metres: see `floor`.

    Raises
    ------
    SkeletonError
        As `foot_contacts`.
    """
    feet = _Feet.of(motion, mapping)
    return float(np.median(feet.floor.at(feet.positions[:, feet.body.pelvis])))


def grounded(motion: Motion, mapping: Mapping[str, object] | None = None) -> Motion:
    """The same motion with its floor at y = 0 everywhere: the root is raised or lowered, nothing else changes.

    Raises
    ------
    SkeletonError
        As `foot_contacts`.
    """
    feet = _Feet.of(motion, mapping)
    roots = motion.root_positions.copy()
    roots[:, 1] -= feet.floor.at(feet.positions[:, feet.body.pelvis])
    return motion.replace(root_positions=roots)


def soles(motion: Motion, mapping: Mapping[str, object] | None = None, *, ground: Floor | None = None) -> Soles:
    """Heel, ball and tip of both feet, as they lie on the floor when the feet stand flat in this recording.

    Parameters
    ----------
    ground : the floor, where it is known.

    Raises
    ------
    SkeletonError
        As `foot_contacts`.
    """
    return _Feet.of(motion, mapping, ground).soles()


def contacts(
    motion: Motion,
    mapping: Mapping[str, object] | None = None,
    *,
    known: Soles | None = None,
    ground: Floor | None = None,
    slow: float | None = None,
) -> Contacts:
    """When each point of the soles bears on the ground.

    Parameters
    ----------
    mapping : as for `kinesics.body.anatomy.resolve`.
    known : the soles of this body, where another recording told them already.
    ground : the floor, where it is known.
    slow : speed below which a point begins to bear, m/s, where another recording told it already.

    Raises
    ------
    SkeletonError
        As `foot_contacts`.
    """
    feet = _Feet.of(motion, mapping, ground)
    if slow is not None:
        feet = dataclasses.replace(feet, slow=slow)
    sole = feet.soles() if known is None else known
    places = sole.place(feet.positions, feet.rotations)
    found = touching(places, places[..., 1] - feet.floor.at(places), motion.fps, feet.stature, feet.slow)
    return Contacts(found.feet, found.points, places, found.levels, feet.floor, sole, feet.slow, feet.stature)


class Touching(NamedTuple):
    """When feet bear, found from the places of their soles alone."""

    feet: Mask
    """Left and right foot, shape (frames, 2)."""
    points: Mask
    """Heel, ball and tip of each, shape (frames, 2, 3)."""
    levels: Array
    """Height above the floor at which each point bears, metres, shape (2, 3)."""


def touching(places: Array, height: Array, fps: float, stature: float, slow: float) -> Touching:
    """When each point of the soles bears, by the rules at the top of this module.

    Parameters
    ----------
    places : of heel, ball and tip in the world, metres, shape (frames, 2, 3, 3).
    height : of the same above the floor, metres, shape (frames, 2, 3).
    stature : of the body, metres.
    slow : speed below which a point begins to bear, m/s.
    """
    speeds = _speeds(places.reshape(len(places), 6, 3), fps).reshape(len(places), 2, 3)
    levels = _levels(height, speeds, stature, slow)
    height = height - levels
    on = (height < HEIGHT_ON * stature) & (speeds < slow)
    stay = (height < HEIGHT_OFF * stature) & (speeds < SPEED_OFF * slow)
    points: Mask = _hysteresis(on.reshape(-1, 6), stay.reshape(-1, 6)).reshape(-1, 2, 3)
    # over as short an axis as that of the three points NumPy reduces ten times more slowly
    some = points[..., 0] | points[..., 1] | points[..., 2]
    either = _closed(some, round(SHORTEST_GAP * fps))
    either = _opened(either, round(SHORTEST_TOUCH * fps))
    # in a gap that was closed the lowest point bears on; a touch left out bears with nothing
    least = np.minimum(np.minimum(height[..., 0], height[..., 1]), height[..., 2])
    points = np.where(some[..., None], points, height == least[..., None]) & either[..., None]
    return Touching(either, points, levels)


def _levels(height: Array, speeds: Array, stature: float, slow: float) -> Array:
    """Height above the floor at which each point bears, shape (2, 3): its usual low among slow frames, near the floor."""
    out = np.empty((2, 3))
    most = HEIGHT_ON * stature
    for k in (0, 1):
        for n in range(3):
            low = _usual_low(height[:, k, n], speeds[:, k, n] < slow)
            # what never comes near the floor does not bear on it
            out[k, n] = np.clip(low, -most, 0.5 * most)
    return out


@dataclass(frozen=True, eq=False)
class _Feet:
    """What `floor_height`, `soles` and `contacts` share."""

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
    def of(cls, motion: Motion, mapping: Mapping[str, object] | None, ground: Floor | None = None) -> _Feet:
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
        speeds = _speeds(forefoot, motion.fps)
        froude = np.sqrt(_GRAVITY * leg)
        quick = float(np.quantile(speeds, 0.95)) if len(speeds) > 1 else 0.0
        slow = min(max(SPEED_ON * froude, SPEED_SHARE * quick), SPEED_MOST * froude)
        plane = _plane(forefoot, speeds < slow, motion.fps, stature)
        bearing = (forefoot[..., 1] - plane.at(forefoot) < HEIGHT_ON * stature) & (speeds < slow)
        thick = _ANKLE_HEIGHT * stature
        if balls is not None:
            above = (ankles - balls)[..., 1]
            flat = float(np.quantile(above[bearing], 0.25)) if bearing.any() else float(above.min())
            thick = min(max(thick - flat, _BALL_HEIGHT[0] * stature), _BALL_HEIGHT[1] * stature)
        floor = dataclasses.replace(plane, height=plane.height - thick) if ground is None else ground
        return cls(body, motion, positions, rotations, stature, slow, ankles, balls, bearing, floor, thick)

    def soles(self) -> Soles:
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


def _plane(points: Array, slow: Mask, fps: float, stature: float) -> Floor:
    """The plane through where points (frames, n, 3) rest, leaving out what rests higher than the floor can tilt.

    One place for each stretch of rest, weighed by its length up to half a second; least squares with a prior on the
    slope, repeated with those places alone that lie near the plane.
    """
    rests, weights = [], []
    for k in range(points.shape[1]):
        for a, b in runs(slow[:, k]):
            # a long stand is one place, a long shuffle is many
            for part in np.array_split(np.arange(a, b), max(1, round((b - a) / fps))):
                rests.append(np.median(points[part, k], axis=0))
                weights.append(min(len(part) / fps, 0.5) / 0.5)
    if not rests:
        return Floor(float(points[..., 1].min()))
    p, w = np.array(rests), np.array(weights)
    order = np.argsort(p[:, 1])
    low = float(p[order[np.searchsorted(np.cumsum(w[order]), 0.2 * w.sum())], 1])
    fit = np.array([low, 0.0, 0.0])
    middle = np.average(p, axis=0, weights=w)
    design = np.stack([np.ones(len(p)), p[:, 0] - middle[0], p[:, 2] - middle[2]], axis=1)
    prior = np.diag([0.0, 1.0, 1.0]) * (_LEVEL_SPREAD * stature / USUAL_SLOPE) ** 2
    band = _TILT_BAND * stature
    for _ in range(8):
        residual = p[:, 1] - design @ fit
        kept = w * (np.abs(residual) < band)
        if not kept.any():
            break
        fit = np.linalg.solve(design.T @ (kept[:, None] * design) + prior, design.T @ (kept * p[:, 1]))
        band = max(0.6 * band, HEIGHT_OFF * stature)
    return Floor(float(fit[0] - fit[1] * middle[0] - fit[2] * middle[2]), float(fit[1]), float(fit[2]))


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


def _speeds(points: Array, fps: float) -> Array:
    """Speed of points (frames, n, 3) over `_SPAN` to either side, m/s, shape (frames, n)."""
    frames = len(points)
    w = max(1, round(_SPAN * fps))
    at = np.arange(frames)
    before, after = np.maximum(at - w, 0), np.minimum(at + w, frames - 1)
    seconds = np.maximum(after - before, 1) / fps
    way = points[after] - points[before]
    return np.asarray(np.sqrt(np.einsum("fni,fni->fn", way, way)) / seconds[:, None])


def _usual_low(height: Array, slow: Mask) -> float:
    """The level at which a point comes to rest: the 20th percentile of its height while slow and in its lower half."""
    if not slow.any():
        return float(height.min())
    resting = np.sort(height[slow])
    low, high = _sorted_quantile(resting, 0.02), _sorted_quantile(resting, 0.98)
    lower = resting[: np.searchsorted(resting, 0.5 * (low + high), side="right")]
    return _sorted_quantile(lower, 0.4) if high > low else low


def _sorted_quantile(values: Array, share: float) -> float:
    """NumPy's quantile, of values in order: it would sort them, and takes longer to prepare than to compute."""
    place = share * (len(values) - 1)
    at = int(place)
    after = min(at + 1, len(values) - 1)
    return float(values[at] + (place - at) * (values[after] - values[at]))


def _hysteresis(on: Mask, stay: Mask) -> Mask:
    """True from where ``on`` is until ``stay`` ends, before and after: stretches of ``stay`` that hold an ``on``."""
    out = np.zeros_like(stay)
    for k in range(stay.shape[1]):
        count = np.concatenate([[0], np.cumsum(on[:, k])])
        for a, b in runs(stay[:, k]):
            out[a:b, k] = count[b] > count[a]
    return out


def _closed(mask: Mask, longest: int) -> Mask:
    """Gaps of at most so many frames are filled, save at the ends."""
    out = mask.copy()
    for k in range(mask.shape[1]):
        for a, b in runs(~mask[:, k]):
            if b - a <= longest and a > 0 and b < len(mask):
                out[a:b, k] = True
    return out


def _opened(mask: Mask, shortest: int) -> Mask:
    """Runs of fewer than so many frames are left out, save at the ends, where more may lie beyond."""
    out = mask.copy()
    for k in range(mask.shape[1]):
        for a, b in runs(mask[:, k]):
            if b - a < shortest and a > 0 and b < len(mask):
                out[a:b, k] = False
    return out


def runs(mask: Mask) -> list[tuple[int, int]]:
    """[start, end) of each stretch of True in a mask of shape (frames,)."""
    edges = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    return list(zip(np.nonzero(edges == 1)[0].tolist(), np.nonzero(edges == -1)[0].tolist(), strict=True))
