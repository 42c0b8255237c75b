"""Transitions frame by frame: what each adds to the joints and the root.

The same as `synthesis.embodiment.blending` does for a whole performance. It is compiled where that was built.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.geometry import quaternion
from kinesics.geometry.single import Vector
from kinesics.synthesis.embodiment import blending

Array = NDArray[np.float64]

INSTANT: Final = 1e-3
"""Seconds over which it is told how quickly an offset changes that is known at all times."""


class Blend(NamedTuple):
    """A transition."""

    cut: int
    """The frame at which another recording is entered."""
    ends: int
    offset: Array
    """Of joints and root, shape (joints + 1, 3)."""
    velocity: Array
    before: Array
    """Seconds that each takes to either side of the cut, shape (joints + 1, 1)."""
    after: Array
    share: Array
    """Of the offset that each bears before the cut."""
    leap: complex
    """By how much what is then performed lies beside where its feet would stand where those stand that are left, z + i·x."""

    def at(self, time: float) -> Array:
        """What it adds so many seconds from the cut: `kinesics.synthesis.embodiment.blending.two_sided`."""
        if time < 0.0:
            share, span, time = self.share, self.before, -time
            way = -span
        else:
            share, span = self.share - 1.0, self.after
            way = span
        t = np.minimum(time / span, 1.0)
        rest = 1.0 - t
        cube = share * rest * rest * rest
        return np.asarray(
            (cube * (1.0 + t * (3.0 + 6.0 * t))) * self.offset + (cube * way * t * (1.0 + 3.0 * t)) * self.velocity
        )

    def add(self, rotations: Array, time: float) -> Vector:
        """Add it to the rotations of all joints, (joints, 4), in place; returns what it adds to the root's place."""
        if compiled.wanted():
            return compiled.native.blended(
                rotations, self.offset, self.velocity, self.before, self.after, self.share, time
            )
        added = self.at(time)
        rotations[:] = blending.add_rotation(rotations, added[:-1])
        x, y, z = added[-1].tolist()
        return x, y, z


def absorbed(offset: Array, velocity: Array, earlier: Blend, since: float) -> tuple[Array, Array]:
    """`kinesics.synthesis.embodiment.blending.absorbed`."""
    if compiled.wanted():
        offset, velocity = offset.copy(), velocity.copy()
        compiled.native.absorbed(
            offset,
            velocity,
            earlier.offset,
            earlier.velocity,
            earlier.before,
            earlier.after,
            earlier.share,
            since,
            INSTANT,
        )
        return offset, velocity
    remains = np.stack([earlier.at(since + time) for time in (-INSTANT, 0.0, INSTANT)])
    apart = offset + np.array([-INSTANT, 0.0, INSTANT])[:, None, None] * velocity
    gone, turned = (quaternion.from_rotvec(vectors[:, :-1]) for vectors in (remains, apart))
    apart[:, :-1] = blending.rotation_offset(gone, turned)
    apart[:, -1] -= remains[:, -1]
    return apart[1], (apart[2] - apart[0]) / (2.0 * INSTANT)
