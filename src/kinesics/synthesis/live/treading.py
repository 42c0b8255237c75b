"""Feet kept in place live, knowing little of what comes ([Schultz2012] §4.4).

What is played has its feet on the ground (`synthesis.embodiment.rehearsal`); transitions and bends move them. A foot that bears
stays where it came down, and the body goes along with it; one that swings comes back to its place in what is played, and the
body with it, step by step. At a cut the body stays over the feet that bear, wherever those of the recording entered stand.
Nothing snaps: what is added to the body's place and to the rotations of the legs goes after what is asked no more quickly than
the recordings accelerate the same (`Gently`), the body half as quickly: it moves as played besides. No joint leaves its range;
what a leg then lacks, its foot slides.
`synthesis.embodiment.planting` does it for a whole performance at once. Here it is done in plain numbers, and for the joints
between root and soles alone: see `kinesics.geometry.single`; how a leg reaches, `kinesics.synthesis.live.leg`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.geometry import single
from kinesics.geometry.single import Quaternion, Vector
from kinesics.synthesis.embodiment import inverse_kinematics
from kinesics.synthesis.embodiment.stage import (
    BEARING,
    LIFT,
    RELEASE,
    SINK,
    SOFTLY,
    SPARED,
    SUNK,
    Stage,
    held_around,
)
from kinesics.synthesis.live.clear_legs import ClearLegs
from kinesics.synthesis.live.foresight import Coming, Foresight
from kinesics.synthesis.live.leg import Gently, Leg, chain, leg
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]

_SLIPPED: Final = 0.3
"""Seconds in which a foot slides for good by two thirds of what its leg falls short of."""
_FOLLOWED: Final = 0.05
"""The same of the body going along."""
_DEEPEST: Final = 0.009
"""Metres below the floor that nothing goes."""
_GRASP: Final = 0.03
"""Seconds in which a foot that is on the ground after a cut is grasped."""
LIVE_LEAN: Final = 0.4
"""Seconds in which, live, the body comes between its feet by two thirds."""
_SWING: Final = 0.5
"""Seconds in which a foot comes back to its place that swings for longer, or for nobody knows how long."""
_EARLY: Final = 0.04
"""Seconds before it comes down that it is over its place: a sole bears a little before it rests."""
_GENTLY: Final = 25.0
"""m/s² that are added to a swinging foot so that it comes down in its place."""
_KEPT: Final = 0.8
"""Share of what the body is beside its place that is left a step later."""
SHORTEST_GAP: Final = 0.13
"""Seconds: no foot is lifted for less."""
_FLIGHT: Final = 0.05
"""What weighs for no shift at all, so that a body in flight comes back."""
_LEAST_STOPPED: Final = 10.0
"""m/s² that a foot is stopped by as it comes down, and started by as it is lifted, also where those recorded hardly move; else as
quickly as those are."""
_STRETCH: Final = 0.1
"""Seconds in which the leg of a foot that comes down is stretched as far as its foot asks, by two thirds."""


class Treading:
    """Keeps the feet of one performance in place, frame by frame."""

    def __init__(self, stage: Stage) -> None:
        repertoire, legs = stage.repertoire, stage.legs
        skeleton, soles = repertoire.skeleton, stage.soles
        fps = repertoire.fps
        known = Foresight.of(stage)
        standing, quick = known.standing, max(known.quick, _LEAST_STOPPED)
        self._held, self._near = (_holds(repertoire, standing, reach * fps) for reach in (RELEASE, LIFT))
        joints = _hanging(skeleton.parents, [*legs.femurs, *legs.tibias, *legs.feet, *soles.joints.ravel().tolist()])
        place = {joint: k for k, joint in enumerate(joints)}
        self._chain = chain(skeleton, joints)
        self._feet = [
            _Foot(
                leg(stage, k, place),
                [legs.femurs[k], legs.tibias[k], legs.feet[k]],
                place,
                [(place[int(j)], _vector(v)) for j, v in zip(soles.joints[k], soles.offsets[k], strict=True)],
                stage.levels[k].tolist(),
                1.0 / fps,
                quick,
            )
            for k in (0, 1)
        ]
        self._clear_legs = ClearLegs(stage)
        self._lean_x = self._lean_z = self._drop = 0.0
        self._body, self._raised = (Gently(SPARED * stage.usual.body, 1.0 / fps) for _ in (0, 1))
        self._follows = _eased(1.0 / fps, _FOLLOWED)
        self._leans = _eased(1.0 / fps, LIVE_LEAN)
        self._sinks, self._sinks_quickly = _eased(1.0 / fps, SINK), _eased(1.0 / fps, 0.25 * SINK)

    def step(self, rotations: Array, root: Vector, image: int, frame: int, coming: tuple[Coming, Coming]) -> Vector:
        """Plant the feet of one frame: the legs' rotations, of (joints, 4), in place; and where the root comes to be."""
        feet = self._feet
        local, places, world = self._chain.placed(rotations, root)
        held, near = self._held[image, frame].tolist(), self._near[image, frame].tolist()
        lean = complex(self._lean_z, self._lean_x)
        for k, foot in enumerate(feet):
            foot.follow(places, world, held[k], near[k], coming[k], _KEPT * lean)
        grip = sum(foot.hold for foot in feet) + _FLIGHT
        # what bears moves beside the recording, and the body with it
        along = sum(foot.hold * foot.went for foot in feet) / grip
        self._lean_x += along.imag
        self._lean_z += along.real
        self._lean_x += self._leans * (sum(foot.hold * foot.shift.imag for foot in feet) / grip - self._lean_x)
        self._lean_z += self._leans * (sum(foot.hold * foot.shift.real for foot in feet) / grip - self._lean_z)
        need = max(foot.shortfall(places, self._lean_x, self._lean_z) * foot.hold for foot in feet)
        self._drop += (self._sinks_quickly if need > self._drop else self._sinks) * (need - self._drop)
        shift = self._body.follow((self._lean_x, -self._drop, self._lean_z))
        self._clear(places, shift)
        lowest = math.inf
        for foot in feet:
            # a foot whose leg was held back slides, and the body goes after it from the next frame on
            (x, _, z), under = foot.reach(places, world, local, shift)
            self._lean_x += self._follows * foot.hold * x
            self._lean_z += self._follows * foot.hold * z
            lowest = min(lowest, under)
            rotations[foot.joints] = foot.rotations
        _, raised, _ = self._raised.follow((0.0, max(-lowest - SUNK, 0.0), 0.0))
        return root[0] + shift[0], root[1] + shift[1] + max(raised, -lowest - _DEEPEST), root[2] + shift[2]

    def _clear(self, places: list[Vector], shift: Vector) -> None:
        """Let feet go where their legs do not pass through each other."""
        hips, knees, ankles = zip(*(foot.expected(places, shift) for foot in self._feet), strict=True)
        asides = self._clear_legs.aside(list(hips), list(knees), list(ankles), [1.0 - foot.hold for foot in self._feet])
        for foot, aside in zip(self._feet, asides, strict=True):
            if aside:
                foot.target = single.add(foot.target, (aside.imag, 0.0, aside.real))

    @property
    def carried(self) -> complex:
        """By how much the body is beside what is played, as it goes with its feet: z + i·x, metres."""
        return complex(self._lean_z, self._lean_x)

    def held(self, image: int, frame: int) -> list[float]:
        """How firmly the recording holds either foot."""
        return [float(held) for held in self._held[image, frame]]

    def leap(self, aside: complex) -> None:
        """Let what is performed leap from here on over the floor, z + i·x, metres: the body stays where it is, and its feet."""
        self._lean_z -= aside.real
        self._lean_x -= aside.imag
        self._body.leap((-aside.imag, 0.0, -aside.real))
        for foot in self._feet:
            foot.leap(aside)

    def apart(self, left: tuple[Array, Vector], entered: tuple[Array, Vector], borne: list[float]) -> complex:
        """By how much feet stand apart in two poses, each with what it bears as its weight, z + i·x, metres.

        Parameters
        ----------
        left, entered : rotations of all joints and place of the root.
        borne : how firmly either foot is held in both.
        """
        soles = []
        for rotations, root in (left, entered):
            _, places, world = self._chain.placed(rotations, root)
            soles.append([foot.placed(places, world) for foot in self._feet])
        total = 0j
        for foot, before, after, weight in zip(self._feet, *soles, borne, strict=True):
            total += weight * foot.apart(before, after)
        return total / (sum(borne) + _FLIGHT)


class _Foot:
    """One foot that is kept in place, and the leg that bears it."""

    def __init__(
        self,
        its: Leg,
        joints: list[int],
        place: dict[int, int],
        points: list[tuple[int, Vector]],
        levels: list[float],
        dt: float,
        quick: float,
    ) -> None:
        self._leg, self.joints = its, joints
        """Hip, knee and ankle in the skeleton."""
        self._hip, self._knee, self._ankle = (place[joint] for joint in joints)
        self.rotations: list[Quaternion] = []
        """Of these, as the leg reached last."""
        self._points, self._levels = points, levels
        self._slips, self._stretches = _eased(dt, _SLIPPED), _eased(dt, _STRETCH)
        self._dt, self._steady = dt, quick * dt
        self._releases, self._grasps, self._softly = dt / RELEASE, dt / _GRASP, _eased(dt, SOFTLY)
        self._sole: list[Vector] = []
        self._velocity = self._acceleration = 0j
        self._over = 0j
        """How quickly its bearing part goes over the floor, z + i·x, m/s."""
        self._stands = False
        self._lifted = False
        """Whether it was lifted and still lags behind what is played."""
        self.went = 0j
        """By how much it was moved against the recording while it bears, z + i·x, metres."""
        self._bears = 0.0
        self._lift = 0.0
        self.hold = 0.0
        """How firmly it is held, 0 to 1."""
        self.shift = 0j
        """By how much it stands beside its place in the recording, z + i·x, metres."""
        self.target: Vector = (0.0, 0.0, 0.0)
        """Where its ankle goes, metres."""

    def placed(self, places: list[Vector], world: list[Quaternion]) -> list[Vector]:
        """Where heel, ball and tip are."""
        return [single.add(places[j], single.rotate(world[j], offset)) for j, offset in self._points]

    def follow(
        self, places: list[Vector], world: list[Quaternion], held: float, near: float, coming: Coming, there: complex
    ) -> None:
        """Where the ankle goes, if the recording holds the foot so firmly and has it so near to the floor, and it is to come
        down ``there`` beside its place in the recording.
        """
        sole = self.placed(places, world)
        lowest = min(point[1] for point in sole)
        # at a cut a foot may be grasped or let go from one frame to the next: not so quickly
        self.hold += min(max(held - self.hold, -self._releases), self._grasps)
        bears = coming.bears or (self._stands and coming.seconds < SHORTEST_GAP)
        slid = 0j
        if not self._sole:
            self.hold, self._lift = held, near * (coming.height - lowest)
        else:
            slid = _moved(coming.parts, self._sole, sole)
            if bears:
                self._stay(slid)
            else:
                self._swing(coming.seconds, there)
        self._over = slid / self._dt + self._velocity
        self.went = self._dt * self._velocity if bears and self._sole else 0j
        self._stands, self._sole = bears, sole
        self._bears += self._stretches * (float(coming.seconds < _STRETCH) - self._bears)
        self._lift += self._softly * (near * (coming.height - lowest) - self._lift)
        lift = max(self._lift, -lowest - SUNK)
        self.target = single.add(places[self._ankle], (self.shift.imag, lift, self.shift.real))

    def apart(self, before: list[Vector], after: list[Vector]) -> complex:
        """How far what bears in both of two poses is apart over the floor, z + i·x, metres: `embodiment.stage.bearing`."""
        height = [0.5 * (a[1] + b[1]) - c for a, b, c in zip(before, after, self._levels, strict=True)]
        least = min(height)
        weights = [math.exp((least - h) / BEARING) for h in height]
        return _moved(weights, before, after) / sum(weights)

    def leap(self, aside: complex) -> None:
        """Stay where it is while what is performed leaps."""
        self.shift -= aside
        self._sole = [single.add(point, (aside.imag, 0.0, aside.real)) for point in self._sole]

    def _stay(self, slid: complex) -> None:
        """On the floor, against what is played moves it by: it comes to rest there, and rests."""
        dt = self._dt
        speed = abs(self._over)
        over = self._over * (1.0 - self._steady / speed) if speed > self._steady else 0j
        self._velocity = over - slid / dt
        self._acceleration = 0j
        self._lifted = False
        self.shift += dt * self._velocity

    def _swing(self, seconds: float, there: complex) -> None:
        """Through the air, to where it will be put down and at rest there: by the quintic that leads there from here."""
        dt, v, a = self._dt, self._velocity, self._acceleration
        if self._stands or self._lifted:
            # lifted, it goes as it is played: what lags behind is still on the floor
            speed = abs(v)
            self._lifted = speed > self._steady
            v = v * (1.0 - self._steady / speed) if self._lifted else 0j
        time = max(min(max(seconds - _EARLY, 0.5 * seconds), _SWING), dt)
        # not farther than goes gently meanwhile
        gently = self.shift + 0.5 * time * v
        most, far = _GENTLY * time * time / 6.0, abs(there - gently)
        if far > most:
            there = gently + (there - gently) * (most / far)
        way = there - self.shift - time * (v + 0.5 * time * a)
        faster, slower = -(v + time * a) * time, -a * time * time
        c = 10.0 * way - 4.0 * faster + 0.5 * slower
        d = -15.0 * way + 7.0 * faster - slower
        e = 6.0 * way - 3.0 * faster + 0.5 * slower
        t = dt / time
        self.shift += dt * (v + 0.5 * dt * a) + t * t * t * (c + t * (d + t * e))
        self._velocity = v + dt * a + t * t * (3.0 * c + t * (4.0 * d + t * 5.0 * e)) / time
        self._acceleration = a + t * (6.0 * c + t * (12.0 * d + t * 20.0 * e)) / (time * time)

    def shortfall(self, places: list[Vector], lean_x: float, lean_z: float) -> float:
        """`kinesics.synthesis.embodiment.stage.shortfall` of a body that leans, metres."""
        hip, knee, ankle = places[self._hip], places[self._knee], places[self._ankle]
        length = single.length(single.subtract(knee, hip)) + single.length(single.subtract(ankle, knee))
        now = single.length(single.subtract(ankle, hip))
        most = min(max(now, inverse_kinematics.SOFT * length), inverse_kinematics.STRAIGHTEST * length)
        x, y, z = single.subtract(self.target, single.add(hip, (lean_x, 0.0, lean_z)))
        return max(-y - math.sqrt(max(most * most - x * x - z * z, 0.0)), 0.0)

    def expected(self, places: list[Vector], shift: Vector) -> tuple[Vector, Vector, Vector]:
        """Where hip, knee and ankle come to be, the body shifted, as nearly as that is known before the leg reaches."""
        x, y, z = single.add(shift, single.subtract(self.target, places[self._ankle]))
        knee = single.add(places[self._knee], (0.5 * x, 0.5 * y, 0.5 * z))
        return single.add(places[self._hip], shift), knee, self.target

    def reach(
        self, places: list[Vector], world: list[Quaternion], local: list[Quaternion], shift: Vector
    ) -> tuple[Vector, float]:
        """Put the ankle at its target, the body shifted, as far as the leg goes: changes the rotations.

        Returns what the ankle falls short of, and the height of the lowest point of the sole, metres.
        """
        hip, knee, ankle, missed, lowest = self._leg.reach(
            places, world, local, self._sole, self.target, shift, self._bears
        )
        self.rotations = [hip, knee, ankle]
        self.shift -= self._slips * complex(missed[2], missed[0])
        return missed, lowest


def _moved(parts: Sequence[float], before: list[Vector], after: list[Vector]) -> complex:
    """How far parts of a sole moved over the floor, z + i·x, metres."""
    x = z = 0.0
    for part, old, new in zip(parts, before, after, strict=True):
        x += part * (new[0] - old[0])
        z += part * (new[2] - old[2])
    return complex(z, x)


def _hanging(parents: Sequence[int], joints: Iterable[int]) -> list[int]:
    """These joints and all that they hang on, parents first."""
    found: set[int] = set()
    for joint in joints:
        while joint >= 0 and joint not in found:
            found.add(joint)
            joint = parents[joint]
    return sorted(found)


def _vector(values: Array) -> Vector:
    x, y, z = values.tolist()
    return x, y, z


def _eased(dt: float, seconds: float) -> float:
    """Share of the way that is gone in ``dt`` by what goes two thirds in ``seconds``."""
    return -math.expm1(-dt / seconds)


def _holds(repertoire: Repertoire, standing: NDArray[np.bool_], reach: float) -> Array:
    """`held_around` of every frame, of both feet, as recorded and mirrored: shape (2, frames, 2)."""
    out = np.zeros((2, repertoire.frame_count, 2))
    for a, b in itertools.pairwise(repertoire.starts.tolist()):
        for image in (0, 1):
            for k in (0, 1):
                if standing[image, a:b, k].any():
                    out[image, a:b, k] = held_around(standing[image, a:b, k], reach)
    return out
