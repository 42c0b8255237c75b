"""Arms that are moved clear of the body live ([Schultz2012] §2.9: Cfree).

Where transitions and planted legs bring an arm deeper into another part of the body than it ever is in the recordings, the
shoulders are turned by the least that brings it out, within their range: a continuous function of where the limbs are, so that
nothing snaps. `kinesics.synthesis.embodiment.arms` does so for a whole performance, more smoothly, and besides finds a way round
where arms pass through something from one side to the other, which one moment does not tell.
"""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.arms import SKIN, STEP, Span, least_turn, pairs_of_arms, shoulders_of
from kinesics.synthesis.embodiment.ranges import Ranges
from kinesics.synthesis.embodiment.stage import Stage

Array = NDArray[np.float64]

_TIMES: Final = 3
"""Most times that shoulders are turned in a frame: the way that an arm comes out is no straight line."""


class ClearArms:
    """Moves the arms of one performance."""

    def __init__(self, stage: Stage) -> None:
        self._skeleton, self._ranges = stage.repertoire.skeleton, Ranges.of(stage)
        self._shoulders, moved = shoulders_of(stage), pairs_of_arms(stage)
        kept = np.flatnonzero(moved.any(axis=0))
        self._capsules = dataclasses.replace(stage.capsules, pairs=tuple(stage.capsules.pairs[n] for n in kept))
        self._deepest, self._moved = stage.deepest[kept] + SKIN, moved[:, kept]
        self._middle, self._low, self._high = (v[self._shoulders] for v in (stage.middle, stage.low, stage.high))
        # what capsules look up once is looked up now, so that the first moment takes no longer than any other
        self._over(stage.middle[None])

    def put_clear(self, rotations: Array) -> None:
        """Turn the shoulders of one moment so that no arm is too deep in anything: rotations of shape (joints, 4), in place."""
        body = rotations[None]
        at: Array | None = None
        for _ in range(_TIMES if len(self._deepest) else 0):
            over = self._over(body)[0]
            worst = int(over.argmax())
            if over[worst] <= 0.0:
                break
            if at is None:
                at = blending.rotation_offset(self._middle, rotations[self._shoulders])
            tried = np.repeat(body, 6, axis=0)
            for k, joint in enumerate(self._shoulders.tolist()):
                tried[3 * k : 3 * k + 3, joint] = blending.add_rotation(self._middle[k], at[k] + STEP * np.eye(3))
            found = self._over(tried)[:, worst].reshape(2, 3)
            change = np.where(np.isfinite(found), found - over[worst], 0.0) / STEP
            asked = at + least_turn(change, over[worst], self._moved[:, worst], Span(at, self._low, self._high))
            at = np.stack(
                [self._ranges.within(int(j), v[None])[0] for j, v in zip(self._shoulders, asked, strict=True)]
            )
            body[0, self._shoulders] = blending.add_rotation(self._middle, at)

    def _over(self, bodies: Array) -> Array:
        """By how much each pair is deeper than ever, metres: (bodies, joints, 4) to (bodies, pairs)."""
        known = kinematics.forward(self._skeleton, bodies, np.zeros((len(bodies), 3)))
        return self._capsules.depths(*known) - self._deepest
