"""A slow, obvious twin of `kinesics.synthesis.treading`: the whole body is placed, all of both feet in arrays."""

from __future__ import annotations

import numpy as np

from kinesics.body import kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis import inverse_kinematics
from kinesics.synthesis.stage import LIFT, RANGE_TOLERANCE, RELEASE, SINK, SOFTLY, SUNK, bearing, held_around, shortfall


class Treading:
    """Keeps feet in place knowing only the past."""

    def __init__(self, stage) -> None:
        self.stage = stage
        self.legs = stage.legs
        self.joints = [*self.legs.femurs, *self.legs.tibias, *self.legs.feet]
        self.soles = None
        self.drop = 0.0
        self.slips = 0

    def around(self, frame: int, image: int, seconds: float) -> np.ndarray:
        """How firmly each foot is held in a frame."""
        own = self.stage.repertoire
        recording = int(own.recording_of(frame))
        a, b = int(own.starts[recording]), int(own.starts[recording + 1])
        out = np.zeros(2)
        for k in (0, 1):
            standing = own.contacts[0, a:b, k]
            if standing.any():
                out[k] = held_around(standing, seconds * own.fps)[frame - a]
        return out[::-1] if image else out

    def placed(self, rotations: np.ndarray, root: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Joints, and the points of the soles."""
        known = kinematics.forward(self.stage.repertoire.skeleton, rotations[None], root[None])
        return known.positions[0], self.stage.soles.place(known.positions, known.rotations)[0]

    def step(self, rotations: np.ndarray, root: np.ndarray, image: int, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """Rotations and root of the frame as performed."""
        stage, dt = self.stage, 1.0 / self.stage.repertoire.fps

        def eased(seconds: float) -> float:
            return 1.0 - np.exp(-dt / seconds)

        held, near = self.around(frame, image, RELEASE), self.around(frame, image, LIFT)
        positions, soles = self.placed(rotations, root)
        height, lowest = soles[..., 1] - stage.levels, soles[..., 1].min(axis=1)
        if self.soles is None:
            self.hold, self.lift, self.shift, self.lean = held, -near * lowest, np.zeros((2, 2)), np.zeros(2)
        else:
            self.hold = np.clip(held, self.hold - dt / RELEASE, self.hold + dt / 0.03)
            share = bearing(0.5 * (height + self.height))
            slid = (share[..., None] * (soles - self.soles)[..., [0, 2]]).sum(axis=1)
            back = (1.0 - self.hold) * eased(0.12)
            self.shift = self.shift - self.hold[:, None] * slid - back[:, None] * self.shift
        self.soles, self.height = soles, height
        self.lift = self.lift + eased(SOFTLY) * (-near * lowest - self.lift)
        lift = np.maximum(self.lift, -lowest - SUNK)
        grip = self.hold.sum() + 0.05
        self.lean = self.lean + eased(0.4) * (self.hold @ self.shift / grip - self.lean)
        targets = positions[list(self.legs.feet)] + np.stack([self.shift[:, 0], lift, self.shift[:, 1]], axis=1)
        leant = np.array([self.lean[0], 0.0, self.lean[1]])
        need = (shortfall(stage, (positions + leant)[None], targets[None])[0] * self.hold).max()
        self.drop += eased(0.25 * SINK if need > self.drop else SINK) * (need - self.drop)
        root = root + leant - [0.0, self.drop, 0.0]
        done = inverse_kinematics.reach(
            stage.repertoire.skeleton, rotations[None], root[None], targets[None], limbs=self.legs
        )
        rotations = done.rotations[0]
        middle = stage.middle[self.joints]
        vectors = quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(middle), rotations[self.joints]))
        low, high = stage.low[self.joints] - RANGE_TOLERANCE, stage.high[self.joints] + RANGE_TOLERANCE
        inside = np.clip(vectors, low, high)
        if np.abs(inside - vectors).max() < 1e-9:
            return rotations, root
        self.slips += 1
        rotations[self.joints] = quaternion.multiply(middle, quaternion.from_rotvec(inside))
        positions, soles = self.placed(rotations, root)
        off = (targets - positions[list(self.legs.feet)])[:, [0, 2]]
        self.shift = self.shift - 0.3 * off
        self.lean = self.lean + 0.3 * self.hold @ off / grip
        return rotations, root + np.array([0.0, max(-soles[..., 1].min() - SUNK, 0.0), 0.0])
