"""A slow, obvious twin of `kinesics.synthesis.live.treading`: the whole body is placed, all of both feet in arrays."""

from __future__ import annotations

import numpy as np

from kinesics.body import kinematics
from kinesics.body.capsules import segment_distance
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import inverse_kinematics
from kinesics.synthesis.embodiment.stage import (
    LEAST_TURNING,
    LIFT,
    RELEASE,
    SINK,
    SOFTLY,
    SPARED,
    SUNK,
    held_around,
    shortfall,
)
from kinesics.synthesis.live.foresight import Foresight
from naive import ranges


class Follower:
    """Goes after a point, never accelerated by more than ``most``."""

    def __init__(self, most: float, dt: float) -> None:
        self.most, self.dt, self.aim = most, dt, None

    def follow(self, aim: np.ndarray) -> np.ndarray:
        """Its place."""
        if self.aim is None:
            self.aim, self.at, self.velocity = aim, aim, np.zeros(3)
            return aim
        behind = self.aim - self.at
        far, brake = np.linalg.norm(behind), 0.5 * self.most
        speed = min(far / self.dt, np.sqrt((0.5 * brake * self.dt) ** 2 + 2.0 * brake * far) - 0.5 * brake * self.dt)
        wanted = (aim - self.aim) / self.dt + (behind / far * speed if far > 1e-12 else 0.0)
        change = wanted - self.velocity
        self.velocity = self.velocity + change * min(1.0, self.most * self.dt / max(np.linalg.norm(change), 1e-300))
        self.at, self.aim = self.at + self.velocity * self.dt, aim
        return self.at


class Treading:
    """Keeps feet in place knowing little of what comes."""

    def __init__(self, stage) -> None:
        self.stage, self.known = stage, Foresight.of(stage)
        self.legs = stage.legs
        self.joints = [*self.legs.femurs, *self.legs.tibias, *self.legs.feet]
        self.ranges = {joint: ranges.limits(stage, joint) for joint in self.joints}
        self.soles = None
        self.lean, self.drop = np.zeros(2), 0.0
        self.shift, self.velocity, self.acceleration = np.zeros((3, 2, 2))
        self.over = np.zeros((2, 2))
        self.stood, self.lags = [False, False], [False, False]
        self.slips = self.held_back = self.asides = 0
        dt = 1.0 / stage.repertoire.fps
        self.turned = {j: Follower(max(stage.accelerations[j], LEAST_TURNING), dt) for j in self.joints}
        self.body, self.raised = Follower(SPARED * stage.usual.body, dt), Follower(SPARED * stage.usual.body, dt)

    def around(self, frame: int, image: int, seconds: float) -> np.ndarray:
        """How firmly each foot is held in a frame."""
        own = self.stage.repertoire
        recording = int(own.recording_of(frame))
        a, b = int(own.starts[recording]), int(own.starts[recording + 1])
        out = np.zeros(2)
        for k in (0, 1):
            standing = self.known.standing[image, a:b, k]
            if standing.any():
                out[k] = held_around(standing, seconds * own.fps)[frame - a]
        return out

    def placed(self, rotations: np.ndarray, root: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Joints, and the points of the soles."""
        known = kinematics.forward(self.stage.repertoire.skeleton, rotations[None], root[None])
        return known.positions[0], self.stage.soles.place(known.positions, known.rotations)[0]

    def step(
        self, rotations: np.ndarray, root: np.ndarray, image: int, frame: int, coming
    ) -> tuple[np.ndarray, np.ndarray]:
        """Rotations and root of the frame as performed."""
        stage, dt = self.stage, 1.0 / self.stage.repertoire.fps

        def eased(seconds: float) -> float:
            return 1.0 - np.exp(-dt / seconds)

        held, near = self.around(frame, image, RELEASE), self.around(frame, image, LIFT)
        positions, soles = self.placed(rotations, root)
        height, lowest = soles[..., 1] - stage.levels, soles[..., 1].min(axis=1)
        played = np.array([known.height for known in coming])
        went = np.zeros((2, 2))
        if self.soles is None:
            self.hold, self.lift, self.bears = held, near * (played - lowest), np.zeros(2)
        else:
            self.hold = np.clip(held, self.hold - dt / RELEASE, self.hold + dt / 0.03)
            share = np.array([known.parts for known in coming])
            slid = (share[..., None] * (soles - self.soles)[..., [0, 2]]).sum(axis=1)
        for k, known in enumerate(coming):
            stands = known.bears or (self.stood[k] and known.seconds < 0.13)
            if self.soles is not None and stands:
                # however the recording moves it, over the floor it comes to rest
                self.velocity[k] = self.slower(self.over[k]) - slid[k] / dt
                self.acceleration[k] = 0.0
                self.shift[k] += dt * self.velocity[k]
                self.lags[k] = False
            elif self.soles is not None:
                if self.stood[k] or self.lags[k]:
                    self.velocity[k] = self.slower(self.velocity[k])
                    self.lags[k] = self.velocity[k].any()
                self.swing(k, known.seconds, 0.8 * self.lean, dt)
            if stands and self.soles is not None:
                went[k] = dt * self.velocity[k]
            if self.soles is not None:
                self.over[k] = slid[k] / dt + self.velocity[k]
            self.stood[k] = stands
            self.bears[k] += eased(0.1) * ((known.seconds < 0.1) - self.bears[k])
        self.soles, self.height = soles, height
        self.lift = self.lift + eased(SOFTLY) * (near * (played - lowest) - self.lift)
        lift = np.maximum(self.lift, -lowest - SUNK)
        grip = self.hold.sum() + 0.05
        self.lean = self.lean + self.hold @ went / grip
        self.lean = self.lean + eased(0.4) * (self.hold @ self.shift / grip - self.lean)
        targets = positions[list(self.legs.feet)] + np.stack([self.shift[:, 0], lift, self.shift[:, 1]], axis=1)
        leant = np.array([self.lean[0], 0.0, self.lean[1]])
        need = (shortfall(stage, (positions + leant)[None], targets[None])[0] * self.hold).max()
        self.drop += eased(0.25 * SINK if need > self.drop else SINK) * (need - self.drop)
        shift = self.body.follow(leant - [0.0, self.drop, 0.0])
        targets = targets + self.aside(positions, shift, targets)
        root = root + shift
        # how far legs are bent: those that swing are not stretched
        near_targets = targets.copy()
        for k in (0, 1):
            hip, ankle = positions[self.legs.femurs[k]], positions[self.legs.feet[k]]
            now, away = np.linalg.norm(ankle - hip), targets[k] - hip - shift
            asked = np.linalg.norm(away)
            if asked > now:
                near_targets[k] = hip + shift + away / asked * (now + self.bears[k] * (asked - now))
        skeleton = stage.repertoire.skeleton
        wanted = inverse_kinematics.reach(
            skeleton, rotations[None], root[None], near_targets[None], limbs=self.legs
        ).rotations[0]
        feet = kinematics.forward(skeleton, rotations[None], root[None]).rotations[0, list(self.legs.feet)]
        rotations = rotations.copy()
        for k, (hip, knee) in enumerate(zip(self.legs.femurs, self.legs.tibias, strict=True)):
            held = self.inside(hip, wanted[hip])
            if quaternion.angle(held, wanted[hip]) > 1e-9:
                self.held_back += 1
                wanted[knee] = self.pointing(rotations, root, k, held, near_targets[k])
            self.toward(rotations, knee, wanted[knee])
        positions, _ = self.placed(rotations, root)
        for k, joint in enumerate(self.legs.femurs):
            hip, ankle = positions[joint], positions[self.legs.feet[k]]
            swing = inverse_kinematics._between((ankle - hip)[None], (targets[k] - hip)[None])[0]
            above, own = self.worlds(rotations, root, joint)
            self.toward(rotations, joint, seen_from(above, quaternion.multiply(swing, own)))
        for joint, kept in zip(self.legs.feet, feet, strict=True):
            above, _ = self.worlds(rotations, root, joint)
            self.toward(rotations, joint, seen_from(above, kept))
        positions, soles = self.placed(rotations, root)
        off = (targets - positions[list(self.legs.feet)])[:, [0, 2]]
        self.slips += int(np.abs(off).max() > 1e-6)
        self.shift = self.shift - eased(0.3) * off
        self.lean = self.lean + eased(0.05) * (self.hold @ off)
        under = -soles[..., 1].min()
        raised = self.raised.follow(np.array([0.0, max(under - SUNK, 0.0), 0.0]))[1]
        return rotations, root + np.array([0.0, max(raised, under - 0.009), 0.0])

    def pointing(
        self, rotations: np.ndarray, root: np.ndarray, k: int, held: np.ndarray, target: np.ndarray
    ) -> np.ndarray:
        """The rotation of the knee, of all that its hinge lets it take, that brings the ankle nearest to its target."""
        hip, knee, ankle = self.legs.femurs[k], self.legs.tibias[k], self.legs.feet[k]
        legs = rotations.copy()
        legs[hip] = held
        # the square of the distance goes as a sine of the angle: four of them tell where it is least
        angles = np.array([0.0, 0.5, 1.0, -0.5]) * np.pi
        turned = np.repeat(legs[None], len(angles), axis=0)
        turned[:, knee] = quaternion.multiply(legs[knee], quaternion.from_rotvec(angles[:, None] * self.legs.hinges[k]))
        at = kinematics.forward(self.stage.repertoire.skeleton, turned, np.repeat(root[None], len(angles), axis=0))
        ahead, left, behind, right = np.square(at.positions[:, ankle] - target).sum(axis=-1)
        least = np.arctan2(right - left, behind - ahead)
        return quaternion.multiply(legs[knee], quaternion.from_rotvec(least * self.legs.hinges[k]))

    def aside(self, positions: np.ndarray, shift: np.ndarray, targets: np.ndarray) -> np.ndarray:
        """How far feet go aside, (2, 3), so that no part of a leg is deeper in the other than ever: those that swing."""
        legs = [positions[list(part)] for part in (self.legs.femurs, self.legs.tibias, self.legs.feet)]
        hips, knees, ankles = legs[0] + shift, legs[1] + 0.5 * (shift + targets - legs[2]), targets

        def over(by: np.ndarray) -> np.ndarray:
            parts = {}
            for k, side in enumerate(("left", "right")):
                parts[f"{side} femur"] = hips[k], knees[k] + 0.5 * by[k]
                parts[f"{side} tibia"] = knees[k] + 0.5 * by[k], ankles[k] + by[k]
            capsules, out = self.stage.capsules, []
            for (a, b), deepest in zip(capsules.pairs, self.stage.deepest, strict=True):
                one, other = parts.get(capsules.names[a]), parts.get(capsules.names[b])
                if one is not None and other is not None:
                    depth = capsules.radii[a] + capsules.radii[b] - segment_distance(*one, *other)
                    out.append(depth - deepest - 0.001)
            return np.array(out)

        by = np.zeros((2, 3))
        for _ in range(3):
            now = over(by)
            if now.max(initial=-1.0) <= 0.0 or not (self.hold < 1.0).any():
                break
            farthest = np.zeros((2, 3))
            for pair in np.flatnonzero(now > 0.0):
                change = np.zeros((2, 3))
                for k in (0, 1):
                    for axis in (0, 2):
                        step = np.zeros((2, 3))
                        step[k, axis] = 0.001
                        change[k, axis] = (1.0 - self.hold[k]) * (over(by + step)[pair] - now[pair]) / 0.001
                way = -change * now[pair] / max((change**2).sum(), 0.05)
                if np.linalg.norm(way) > np.linalg.norm(farthest):
                    farthest = way
            by = by + farthest
            for k in (0, 1):
                by[k] *= min(1.0, 0.08 / max(np.linalg.norm(by[k]), 1e-300))
            self.asides += 1
        return by

    def slower(self, velocity: np.ndarray) -> np.ndarray:
        """Braked for one frame as quickly as feet are."""
        speed = np.linalg.norm(velocity)
        least = max(speed - max(self.known.quick, 10.0) / self.stage.repertoire.fps, 0.0)
        return velocity * (least / speed) if speed else velocity

    def swing(self, k: int, seconds: float, there: np.ndarray, dt: float) -> None:
        """One frame of a foot that swings: the polynomial of fifth degree that comes to rest in its place."""
        time = max(min(max(seconds - 0.04, 0.5 * seconds), 0.5), dt)
        gently = self.shift[k] + 0.5 * time * self.velocity[k]
        off = there - gently
        there = gently + off * min(1.0, 25.0 * time**2 / 6.0 / max(np.linalg.norm(off), 1e-300))
        here = [self.shift[k], self.velocity[k], 0.5 * self.acceleration[k]]
        powers = time ** np.arange(6.0)
        orders = np.array([powers, np.arange(6) * powers / time, np.arange(6) * np.arange(-1, 5) * powers / time**2])
        ends = np.array([there, np.zeros(2), np.zeros(2)]) - orders[:, :3] @ here
        curve = np.concatenate([here, np.linalg.solve(orders[:, 3:], ends)])
        self.shift[k] = dt ** np.arange(6) @ curve
        self.velocity[k] = np.arange(1, 6) * dt ** np.arange(5) @ curve[1:]
        self.acceleration[k] = np.arange(1, 5) * np.arange(2, 6) * dt ** np.arange(4) @ curve[2:]

    def leap(self, aside: complex) -> None:
        """What is performed leaps over the floor; body and feet stay."""
        by = np.array([aside.imag, aside.real])
        self.lean = self.lean - by
        self.shift = self.shift - by
        self.body.aim, self.body.at = self.body.aim - [by[0], 0.0, by[1]], self.body.at - [by[0], 0.0, by[1]]
        self.soles = self.soles + np.array([by[0], 0.0, by[1]])

    def worlds(self, rotations: np.ndarray, root: np.ndarray, joint: int) -> tuple[np.ndarray, np.ndarray]:
        """Orientations of a joint's parent and of the joint in the world."""
        skeleton = self.stage.repertoire.skeleton
        world = kinematics.forward(skeleton, rotations[None], root[None]).rotations[0]
        return world[skeleton.parents[joint]], world[joint]

    def inside(self, joint: int, q: np.ndarray) -> np.ndarray:
        """The rotation of a joint within its range."""
        middle = self.stage.middle[joint]
        held = ranges.within(self.stage, joint, quaternion.as_rotvec(seen_from(middle, q)), self.ranges[joint])
        return quaternion.multiply(middle, quaternion.from_rotvec(held))

    def toward(self, rotations: np.ndarray, joint: int, wanted: np.ndarray) -> None:
        """Turn a joint as far as it goes in one frame to the rotation wanted."""
        turn = quaternion.as_rotvec(seen_from(rotations[joint], self.inside(joint, wanted)))
        turned = quaternion.multiply(rotations[joint], quaternion.from_rotvec(self.turned[joint].follow(turn)))
        rotations[joint] = self.inside(joint, turned)


def seen_from(above: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The rotation q as seen from another."""
    return quaternion.multiply(quaternion.conjugate(above), q)
