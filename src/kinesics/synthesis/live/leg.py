"""A leg that reaches, frame by frame: its foot goes where it is asked to, as far as its joints go and as gently as they turn.

The knee is bent and the leg swung as by `synthesis.embodiment.inverse_kinematics.turns`; where that would take the thigh beyond its
range, as of a leg that trails behind a long step, the knee alone takes the foot as near as it can: to stretch it all the same
would drag the foot along by centimetres for millimetres that the leg lacks. No joint leaves its range, and what is added
to its rotation goes after what is asked no more quickly than the recordings accelerate it (`Gently`). Done for both legs in every
frame, it is compiled where that was built; here is the same in plain numbers.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.body.skeleton import Skeleton
from kinesics.geometry import single
from kinesics.geometry.single import Quaternion, Vector
from kinesics.synthesis.embodiment import inverse_kinematics
from kinesics.synthesis.embodiment.ranges import ROUNDING, Ranges
from kinesics.synthesis.embodiment.stage import LEAST_TURNING, Stage

Array = NDArray[np.float64]

_BRAKE: Final = 0.5
"""Share of the acceleration that there may be which is counted on for stopping: what is gone after may turn round."""
_NOWHERE: Final[Vector] = (0.0, 0.0, 0.0)


class Gently:
    """Goes after a point as closely as it can without being accelerated more than it may be."""

    def __init__(self, most: float, dt: float) -> None:
        self._dt, self._most, self._leap = dt, most, most * dt
        self._aim: Vector | None = None
        self._at = self._velocity = _NOWHERE

    def leap(self, by: Vector) -> None:
        """Be elsewhere, and whatever is gone after too."""
        if self._aim is not None:
            self._aim, self._at = single.add(self._aim, by), single.add(self._at, by)

    def follow(self, aim: Vector) -> Vector:
        """Where it is, when the point is at ``aim``; at once where it begins."""
        dt, before = self._dt, self._aim
        self._aim = aim
        if before is None:
            self._at = aim
            return aim
        behind = single.subtract(before, self._at)
        far = single.length(behind)
        # no faster than it can stop there; within the last frame right there
        most = _BRAKE * self._most
        brake = 0.5 * dt * most
        speed = min(far / dt, math.sqrt(brake * brake + 2.0 * most * far) - brake)
        closer = speed / far if far > 1e-12 else 0.0
        vx, vy, vz = self._velocity
        change = (
            (aim[0] - before[0]) / dt + closer * behind[0] - vx,
            (aim[1] - before[1]) / dt + closer * behind[1] - vy,
            (aim[2] - before[2]) / dt + closer * behind[2] - vz,
        )
        asked = single.length(change)
        share = self._leap / asked if asked > self._leap else 1.0
        vx, vy, vz = vx + share * change[0], vy + share * change[1], vz + share * change[2]
        self._velocity = (vx, vy, vz)
        x, y, z = self._at
        self._at = (x + vx * dt, y + vy * dt, z + vz * dt)
        return self._at


class Limb(NamedTuple):
    """A joint of a leg."""

    at: int
    """Among the joints between root and soles."""
    above: int
    """The same of its parent."""
    joint: int
    """In the skeleton."""
    ranges: Ranges
    most: float
    """What it may be turned by in addition, radians per second²."""

    @classmethod
    def of(cls, stage: Stage, joint: int, place: dict[int, int]) -> Limb:
        """Of a joint of the skeleton, ``place`` telling where joints are among those between root and soles."""
        most = max(float(stage.accelerations[joint]), LEAST_TURNING)
        return cls(place[joint], place[stage.repertoire.skeleton.parents[joint]], joint, Ranges.of(stage), most)

    def inside(self, q: Quaternion) -> Quaternion:
        """A rotation within the joint's range."""
        w, x, y, z = self.ranges.middle[self.joint].tolist()
        vector = single.as_rotvec(single.undo((w, x, y, z), q))
        held = _vector(self.ranges.within(self.joint, np.array([vector]))[0])
        # a joint that was held stands at the end of its range: rounding is not to decide whether it is held again
        if sum(abs(here - there) for here, there in zip(held, vector, strict=True)) < ROUNDING:
            return q
        return single.multiply((w, x, y, z), single.from_rotvec(held))


class Stepped(NamedTuple):
    """A leg after it reached."""

    hip: Quaternion
    """Rotations relative to the parents."""
    knee: Quaternion
    ankle: Quaternion
    missed: Vector
    """What the ankle falls short of, metres."""
    lowest: float
    """Height of the lowest point of the sole, metres."""


class Chain(Protocol):
    """The joints between root and soles, parents first."""

    def placed(self, rotations: Array, root: Vector) -> tuple[list[Quaternion], list[Vector], list[Quaternion]]:
        """Their rotations, of those of all joints (joints, 4); their places and orientations in the world."""
        ...


class Leg(Protocol):
    """A leg of one performance."""

    def reach(
        self,
        places: list[Vector],
        world: list[Quaternion],
        local: list[Quaternion],
        sole: list[Vector],
        target: Vector,
        shift: Vector,
        bears: float,
    ) -> tuple[Quaternion, Quaternion, Quaternion, Vector, float]:
        """Put the ankle at its target, as far as the leg goes; the parts of `Stepped`.

        Parameters
        ----------
        places, world, local : of the joints between root and soles, as they are played: metres, and rotations.
        sole : points of it in the world, metres.
        target : of the ankle, metres.
        shift : of the body, metres.
        bears : 0 to 1: how far the leg is stretched for what its foot cannot reach.
        """
        ...


def chain(skeleton: Skeleton, joints: list[int]) -> Chain:
    """Joints of a skeleton, each after its parent; compiled where that was built."""
    place = {joint: k for k, joint in enumerate(joints)}
    above = [0, *(place[skeleton.parents[joint]] for joint in joints[1:])]
    offsets = [_vector(skeleton.offsets[joint]) for joint in joints]
    if compiled.wanted():
        return compiled.native.Chain(joints, above, offsets)
    return _PlainChain(joints, above, offsets)


def leg(stage: Stage, k: int, place: dict[int, int]) -> Leg:
    """The left (0) or right (1) leg of one performance; compiled where that was built."""
    joints = stage.legs.femurs[k], stage.legs.tibias[k], stage.legs.feet[k]
    limbs = [Limb.of(stage, joint, place) for joint in joints]
    hinge, dt = _vector(stage.legs.hinges[k]), 1.0 / stage.repertoire.fps
    if not compiled.wanted():
        return _Plain(limbs, hinge, dt)
    at, above, turned, _, most = (list(column) for column in zip(*limbs, strict=True))
    return compiled.native.Leg(
        Ranges.of(stage).native,
        turned,
        at,
        above,
        most,
        hinge,
        dt,
        _BRAKE,
        inverse_kinematics.SOFT,
        inverse_kinematics.STRAIGHTEST,
        inverse_kinematics.BACKWARD_KNEE,
    )


class _PlainChain:
    """In plain numbers."""

    def __init__(self, joints: list[int], above: list[int], offsets: list[Vector]) -> None:
        self._joints = np.array(joints)
        self._links = list(zip(above, offsets, strict=True))[1:]

    def placed(self, rotations: Array, root: Vector) -> tuple[list[Quaternion], list[Vector], list[Quaternion]]:
        """See `Chain`."""
        local: list[Quaternion] = list(map(tuple, rotations[self._joints].tolist()))
        places, world = [root], [local[0]]
        for (parent, offset), own in zip(self._links, local[1:], strict=True):
            above = world[parent]
            places.append(single.add(places[parent], single.rotate(above, offset)))
            world.append(single.multiply(above, own))
        return local, places, world


class _Plain:
    """In plain numbers."""

    def __init__(self, limbs: list[Limb], hinge: Vector, dt: float) -> None:
        self._limbs = limbs
        self._turned = [Gently(limb.most, dt) for limb in limbs]
        self._hinge = hinge

    def reach(
        self,
        places: list[Vector],
        world: list[Quaternion],
        local: list[Quaternion],
        sole: list[Vector],
        target: Vector,
        shift: Vector,
        bears: float,
    ) -> Stepped:
        """See `Leg`."""
        hip, knee, ankle = self._limbs
        at = single.add(places[hip.at], shift)
        upper = single.subtract(places[knee.at], places[hip.at])
        lower = single.subtract(places[ankle.at], places[knee.at])
        middle = single.add(at, upper)
        now, aim = single.length(single.add(upper, lower)), single.subtract(target, at)
        asked, reachable = single.length(aim), target
        if asked > now:
            # a leg that swings is not stretched for what its foot cannot reach
            share = (now + bears * (asked - now)) / asked
            reachable = single.add(at, (share * aim[0], share * aim[1], share * aim[2]))
        axis = single.rotate(world[knee.at], self._hinge)
        bend, swing = inverse_kinematics.turns(at, middle, single.add(middle, lower), reachable, axis)
        above = world[hip.above]
        wanted = single.undo(above, single.multiply(swing, world[hip.at]))
        held = hip.inside(wanted)
        if held is not wanted:
            # a thigh at the end of its range goes no farther, and the knee takes the ankle as near as it can
            swung = _turn(world[hip.at], single.multiply(above, held))
            bend = _pointing(upper, lower, single.subtract(reachable, at), axis, swung)
        # each is the old world orientation, turned, seen from its parent, turned or not; the foot's is as it was
        above = world[knee.above]
        bent_knee = self._toward(1, local[knee.at], single.undo(above, single.multiply(bend, world[knee.at])))
        bent = _turn(world[knee.at], single.multiply(above, bent_knee))
        # the leg as it was bent points to the target, be that nearer or farther than it reaches
        lower = single.rotate(bent, lower)
        swing = single.least_turn(single.add(upper, lower), aim)
        above = world[hip.above]
        swung_hip = self._toward(0, local[hip.at], single.undo(above, single.multiply(swing, world[hip.at])))
        swung = _turn(world[hip.at], single.multiply(above, swung_hip))
        above = single.multiply(single.multiply(swung, bent), world[ankle.above])
        tipped_ankle = self._toward(2, local[ankle.at], single.undo(above, world[ankle.at]))
        tipped = _turn(world[ankle.at], single.multiply(above, tipped_ankle))
        reached = single.add(at, single.rotate(swung, single.add(upper, lower)))
        lowest = min(single.rotate(tipped, single.subtract(point, places[ankle.at]))[1] for point in sole)
        return Stepped(swung_hip, bent_knee, tipped_ankle, single.subtract(target, reached), reached[1] + lowest)

    def _toward(self, k: int, own: Quaternion, wanted: Quaternion) -> Quaternion:
        """As near as a joint goes to the rotation wanted in place of its own."""
        limb = self._limbs[k]
        turn = single.as_rotvec(single.undo(own, limb.inside(wanted)))
        return limb.inside(single.multiply(own, single.from_rotvec(self._turned[k].follow(turn))))


def _pointing(upper: Vector, lower: Vector, target: Vector, axis: Vector, swung: Quaternion) -> Quaternion:
    """The turn of the shank, the thigh being swung, by which it points as near to the target as its hinge lets it."""
    w, x, y, z = swung
    way = single.subtract(single.rotate((w, -x, -y, -z), target), upper)
    along = single.dot(lower, way) - single.dot(axis, lower) * single.dot(axis, way)
    half = 0.5 * math.atan2(single.dot(axis, single.cross(lower, way)), along)
    sine = math.sin(half)
    return math.cos(half), sine * axis[0], sine * axis[1], sine * axis[2]


def _turn(before: Quaternion, after: Quaternion) -> Quaternion:
    """What turns one orientation in the world into the other."""
    w, x, y, z = before
    return single.multiply(after, (w, -x, -y, -z))


def _vector(values: Array) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
