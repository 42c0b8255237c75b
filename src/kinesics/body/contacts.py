"""Feet on the ground: where the floor is, when a foot bears on it, and with which part of its sole.

A skeleton has an ankle and, mostly, a toe joint, but no heel and no skin. `soles` finds from a recording what is missing:
while a foot stands flat its heel, ball and tip lie on the floor, which fixes them in the frames of its joints (feet.py). A point of
the sole bears while it is low and slow (touching.py). The floor is a plane (floor.py).

- `contacts`: all of it, `foot_contacts` the feet alone
- `soles`, `floor`, `floor_height`: parts of it
- `grounded`: the motion with its floor at y = 0
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinesics.body.feet import POINTS, Feet, Soles
from kinesics.body.floor import Floor
from kinesics.body.motion import Motion
from kinesics.body.runs import runs
from kinesics.body.touching import Touching, touching
from kinesics.geometry import quaternion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

__all__ = [
    "POINTS",
    "Contacts",
    "Floor",
    "Soles",
    "Touching",
    "contacts",
    "floor",
    "floor_height",
    "foot_contacts",
    "grounded",
    "runs",
    "soles",
    "touching",
]


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

    def soles_as_they_bear(self, motion: Motion) -> Soles:
        """The soles, each point where it lies on the floor as it usually bears in the motion that they were found in.

        They were found as feet stood flat, or from the skeleton where none does; a heel taken for a corner, which is round, then
        dips below the floor as it comes down, and legs would have to be bent to lift what never was that low.
        """
        level = 0.5 * (self.levels + self.levels[::-1])
        offsets = self.soles.offsets.copy()
        rotations = motion.global_rotations()
        for foot, point in itertools.product((0, 1), range(offsets.shape[1])):
            bears = self.points[:, foot, point]
            if bears.any():
                carrier = rotations[bears, self.soles.joints[foot, point]]
                up = quaternion.rotate(quaternion.conjugate(carrier), np.array([0.0, 1.0, 0.0])).mean(axis=0)
                offsets[foot, point] -= level[foot, point] * up / np.linalg.norm(up)
        return dataclasses.replace(self.soles, offsets=offsets)


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
    they are low; its tilt is held back by what is usual, so that a few steps on one spot do not tilt it.
    From there it is put lower by the height of that joint above the sole in a body of this stature: true to 1 or 2 cm, for
    no skeleton tells how thick a sole is, but the same for all recordings of one body.

    Raises
    ------
    SkeletonError
        As `foot_contacts`.
    """
    return Feet.of(motion, mapping).floor


def floor_height(motion: Motion, mapping: Mapping[str, object] | None = None) -> float:
    """Height of the floor in the middle of where the body goes, metres: see `floor`.

    Raises
    ------
    SkeletonError
        As `foot_contacts`.
    """
    feet = Feet.of(motion, mapping)
    return float(np.median(feet.floor.at(feet.positions[:, feet.body.pelvis])))


def grounded(motion: Motion, mapping: Mapping[str, object] | None = None) -> Motion:
    """The same motion with its floor at y = 0 everywhere: the root is raised or lowered, nothing else changes.

    Raises
    ------
    SkeletonError
        As `foot_contacts`.
    """
    feet = Feet.of(motion, mapping)
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
    return Feet.of(motion, mapping, ground).soles()


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
    feet = Feet.of(motion, mapping, ground)
    if slow is not None:
        feet = dataclasses.replace(feet, slow=slow)
    sole = feet.soles() if known is None else known
    places = sole.place(feet.positions, feet.rotations)
    found = touching(places, places[..., 1] - feet.floor.at(places), motion.fps, feet.stature, feet.slow)
    return Contacts(found.feet, found.points, places, found.levels, feet.floor, sole, feet.slow, feet.stature)
