"""Legs that pass each other live without passing through each other ([Schultz2012] §2.9: Cfree).

In the recordings they do not; transitions bring one past the other where it never was, and a foot that comes back to its place goes
there straight. Where a leg would be deeper in the other than it ever is, the foot that swings goes aside by as much as brings it
out: that is a continuous function of where the legs are, so that nothing snaps. Two feet that bear stay where they are.
`kinesics.synthesis.embodiment.planting` does the same for a whole performance.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.capsules import Ends, depths_between
from kinesics.geometry.single import Vector
from kinesics.synthesis.embodiment.arms import SKIN, STEP
from kinesics.synthesis.embodiment.stage import Stage

Array = NDArray[np.float64]

_PARTS: Final = ("left femur", "left tibia", "right femur", "right tibia")
_TIMES: Final = 3
"""Most times that feet are moved in a frame: past one pair of the legs' parts lies another."""
_FARTHEST: Final = 0.08
"""Metres that a foot goes aside at most."""
_LEAST: Final = 0.05
"""Sum of squares of metres that a leg comes out for each metre that feet go: where they hardly help they go no farther."""
_WAYS: Final = ((0, 0), (0, 2), (1, 0), (1, 2))
"""In which feet may go: the left one and the right one along x and z."""
_GOES: Final = np.array([0.5, 1.0])
"""Of a foot's way: how far its knee goes, and its ankle."""


class ClearLegs:
    """Tells how far feet go aside so that legs do not pass through each other."""

    def __init__(self, stage: Stage) -> None:
        capsules = stage.capsules
        numbers = [
            n for n, (a, b) in enumerate(capsules.pairs) if {capsules.names[a], capsules.names[b]} <= set(_PARTS)
        ]
        pairs = np.array([capsules.pairs[n] for n in numbers], dtype=np.intp).reshape(-1, 2)
        self._a, self._b = (
            np.array([_PARTS.index(capsules.names[m]) for m in column], dtype=np.intp) for column in pairs.T
        )
        self._reach = capsules.radii[pairs].sum(axis=1)
        self._deepest = stage.deepest[numbers] + SKIN

    def aside(self, hips: list[Vector], knees: list[Vector], ankles: list[Vector], free: list[float]) -> list[complex]:
        """How far each foot goes aside over the floor, z + i·x, metres.

        Parameters
        ----------
        hips, knees, ankles : where those of the left and the right leg come to be, metres.
        free : 0 to 1, how far each foot may go: not at all where it bears.
        """
        out = np.zeros((2, 2))
        if len(self._reach):
            # hip, knee and ankle of either leg
            joints = np.array([hips, knees, ankles]).transpose(1, 0, 2)
            share = np.array(free)
            for _ in range(_TIMES):
                over = self._over(joints[None])[0]
                if over.max() <= 0.0 or not share.any():
                    break
                moved = np.repeat(joints[None], len(_WAYS), axis=0)
                for n, (k, axis) in enumerate(_WAYS):
                    moved[n, k, 1:, axis] += STEP * _GOES
                deep = np.flatnonzero(over > 0.0)
                change = ((self._over(moved)[:, deep] - over[deep]) / STEP).T.reshape(-1, 2, 2) * share[:, None]
                square = np.square(change).sum(axis=(1, 2))
                # of all pairs the one for which feet go farthest: hips that are too near no foot brings apart
                worst = int((over[deep] * np.sqrt(square) / np.maximum(square, _LEAST)).argmax())
                asked = out - change[worst] * over[deep[worst]] / max(float(square[worst]), _LEAST)
                asked *= np.minimum(
                    1.0, _FARTHEST / np.maximum(np.linalg.norm(asked, axis=1, keepdims=True), _FARTHEST)
                )
                joints[:, 1:, [0, 2]] += _GOES[:, None] * (asked - out)[:, None]
                out = asked
        return [complex(z, x) for x, z in out.tolist()]

    def _over(self, joints: Array) -> Array:
        """By how much each pair is deeper than ever, metres: shape (bodies, 2, 3, 3) to (bodies, pairs)."""
        parts = Ends(joints[:, :, :2].reshape(-1, 4, 3), joints[:, :, 1:].reshape(-1, 4, 3))
        return depths_between(parts, self._a, self._b, self._reach) - self._deepest
