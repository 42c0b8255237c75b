"""Toes that do not dig into the floor ([Schultz2012] §2.9).

Feet are planted by heel, ball and a tip that lies where toes end as a foot stands flat. A recording that bends its toes down
farther than any toe goes, on a sole that bears, has their true ends below the floor all the same: they are bent up by as much.
Where they cannot be, the foot is raised.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.body.kinematics import Kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import inverse_kinematics
from kinesics.synthesis.embodiment.ranges import envelope, put_within_range
from kinesics.synthesis.embodiment.stage import SOFTLY, Stage
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]

DEEP: Final = 0.009
"""Metres below that which are let pass."""
_HARDLY: Final = 0.001
"""Metres for which no foot is raised."""
_SLOWLY: Final = 0.1
"""Seconds before and after over which one is."""
USUAL: Final = 0.2
"""Quantile of the heights of the ends of toes while their foot bears, at which they usually do: some skeletons draw them longer or
lower than the flesh is."""


class Ends(NamedTuple):
    """Where toes end."""

    joints: NDArray[np.intp]
    """Joints of toes that have ends, shape (n,)."""
    sites: Array
    """Their ends, the farthest of each, in the frame of the joint, metres, shape (n, 3)."""
    sides: NDArray[np.intp]
    """0 left, 1 right, shape (n,)."""

    @classmethod
    def of(cls, stage: Stage) -> Ends:
        """Of the feet that have toes, and toes that have ends."""
        skeleton = stage.repertoire.skeleton
        found = []
        for side, foot in enumerate(stage.legs.feet):
            toes = int(stage.soles.joints[side, 2])
            sites = [np.asarray(s.offset, dtype=np.float64) for s in skeleton.end_sites if s.parent == toes]
            if toes != foot and sites:
                found.append((toes, max(sites, key=lambda v: float(np.linalg.norm(v))), side))
        return cls(
            np.array([toes for toes, _, _ in found], dtype=np.intp),
            np.array([site for _, site, _ in found]).reshape(-1, 3),
            np.array([side for _, _, side in found], dtype=np.intp),
        )

    def beneath(self, known: Kinematics) -> Array:
        """From the joints of the toes to their ends, in the world, metres, shape (frames, n, 3)."""
        return quaternion.rotate(known.rotations[:, self.joints], self.sites)

    def heights(self, known: Kinematics) -> Array:
        """Of the ends above the floor, metres, shape (frames, n)."""
        return np.asarray(known.positions[:, self.joints, 1] + self.beneath(known)[..., 1])


def usual_heights(stage: Stage, planted: Repertoire) -> Array:
    """Heights above the floor at which toes usually end while their foot bears, at most 0, metres, shape (n,).

    Parameters
    ----------
    planted : the recordings with their feet on the ground.
    """
    ends = Ends.of(stage)
    known = kinematics.forward(planted.skeleton, planted.rotations[0], planted.root_positions[0], joints=stage.lower)
    height = ends.heights(known)
    usual = []
    for n, side in enumerate(ends.sides.tolist()):
        bears = planted.contacts[0, :, side]
        if bears.any():
            usual.append(min(0.0, float(np.quantile(height[bears, n], USUAL))))
    # either foot is the other's mirror image
    return np.full(len(ends.joints), min(usual, default=0.0))


def toes_above_the_floor(stage: Stage, rotations: Array, roots: Array, usual: Array) -> Array:
    """Bent up where they end more than `DEEP` below where they usually do: (frames, joints, 4); the same where none does.

    Toes that cannot be bent as far are raised with their foot.

    Parameters
    ----------
    rotations, roots : shapes (frames, joints, 4) and (frames, 3).
    usual : as of `usual_heights`.
    """
    ends = Ends.of(stage)
    if not len(ends.joints):
        return rotations
    known = kinematics.forward(stage.repertoire.skeleton, rotations, roots, joints=stage.lower)
    below = usual - DEEP - ends.heights(known)
    if not (below > 0.0).any():
        return rotations
    beneath = ends.beneath(known)
    out = rotations.copy()
    reach = max(1, round(SOFTLY * stage.repertoire.fps))
    for n, toes in enumerate(ends.joints.tolist()):
        length = float(np.linalg.norm(ends.sites[n]))
        here = np.clip(beneath[:, n, 1] / length, -1.0, 1.0)
        there = np.clip((beneath[:, n, 1] + np.maximum(below[:, n], 0.0)) / length, -1.0, 1.0)
        turn = envelope(np.arcsin(there) - np.arcsin(here), reach)
        goes = np.flatnonzero(turn)
        # about the level axis across the toes, from where they point towards straight up
        across = np.cross(beneath[goes, n], [0.0, 1.0, 0.0])
        across /= np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-9)
        turned = quaternion.multiply(quaternion.from_rotvec(turn[goes, None] * across), known.rotations[goes, toes])
        above = known.rotations[goes, stage.repertoire.skeleton.parents[toes]]
        out[goes, toes] = quaternion.multiply(quaternion.conjugate(above), turned)
    put_within_range(stage, out, ends.joints)
    return _raised(stage, out, roots, ends, usual)


def _raised(stage: Stage, rotations: Array, roots: Array, ends: Ends, usual: Array) -> Array:
    """Feet raised by what toes that go no farther are still too low: rotations, shape (frames, joints, 4)."""
    known = kinematics.forward(stage.repertoire.skeleton, rotations, roots, joints=stage.lower)
    below = usual - DEEP - ends.heights(known)
    up = np.zeros((len(rotations), 2))
    np.maximum.at(up.T, ends.sides, below.T)
    if up.max() <= _HARDLY:
        return rotations
    reach = max(1, round(_SLOWLY * stage.repertoire.fps))
    up = np.stack([envelope(up[:, side], reach) for side in (0, 1)], axis=-1)
    goes = np.flatnonzero(up.any(axis=1))
    there = known._replace(positions=known.positions[goes], rotations=known.rotations[goes])
    targets = there.positions[:, list(stage.legs.feet)].copy()
    targets[..., 1] += up[goes]
    out = rotations.copy()
    out[goes] = inverse_kinematics.reach(
        stage.repertoire.skeleton, rotations[goes], roots[goes], targets, limbs=stage.legs, known=there
    ).rotations
    put_within_range(stage, out, np.array([*stage.legs.femurs, *stage.legs.tibias, *stage.legs.feet]))
    return out
