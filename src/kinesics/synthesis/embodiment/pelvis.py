"""The pelvis turned beneath a steady trunk, so that hips stay in their range while feet stay where they are ([Schultz2012] §2.9).

Where paths meet, feet come to stand a little elsewhere beneath the body than in any recording, and a hip that landed at the end of
its range would go beyond it. Moving the body mends that but little: it hangs on both legs, of which one would have to be longer
for the other's sake. People turn the pelvis, as they do in every stride (rotation and tilt are the first two determinants of gait
of Saunders, Inman & Eberhart 1953, *J Bone Joint Surg Am* 35:543).
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.body.kinematics import Kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import blending, inverse_kinematics
from kinesics.synthesis.embodiment.ranges import both_ways, put_within_range
from kinesics.synthesis.embodiment.stage import Stage

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

FARTHEST: Final = np.deg2rad(5.0)
"""By which the pelvis is turned at most: a walker's goes to and fro by as much."""
GENTLY: Final = 0.1
"""Seconds before and after over which it is turned."""
ROUNDS: Final = 10
"""Most times that it is turned and looked where the hips are."""
_OVER: Final = 0.001
"""Radians beyond the range of hip or knee from which on it is turned."""
_STEP: Final = 0.001
"""Radians that it is turned by to see what comes of it."""
_DAMPED: Final = 0.05
"""Added to the squares of how much a joint turns with it, for ways along which it hardly does."""
_PROJECTIONS: Final = 15
"""Most times that, at one moment, the joint that is beyond its range by most is put right by the least turn."""


class Turned(NamedTuple):
    """What `turned_for_the_hips` gives."""

    rotations: Array
    """Shape (frames, joints, 4)."""
    wanted: Array
    """Rotation vectors of the pelvis, as its hips ask for at each moment, shape (frames, 3)."""


def turned_for_the_hips(
    stage: Stage, rotations: Array, roots: Array, before: Turned | None = None, rounds: int = ROUNDS
) -> Turned:
    """Turn the pelvis, feet left where they are, by what brings hips and knees back into their range.

    The trunk stays as it is, as far as its range lets it; legs reach by inverse kinematics.

    Parameters
    ----------
    rotations, roots : shapes (frames, joints, 4) and (frames, 3).
    before : what came of much the same movement, where that is known, to begin with.
    rounds : of looking where the hips are and turning, at most.
    """
    legs, frames = stage.legs, len(rotations)
    joints = np.array([*legs.femurs, *legs.tibias])
    middle, low, high = stage.middle[joints], stage.low[joints], stage.high[joints]
    at = blending.rotation_offset(middle, rotations[:, joints])
    wanted = np.zeros((frames, 3)) if before is None else before.wanted.copy()
    if np.maximum(at - high, low - at).max() <= _OVER:
        return Turned(rotations, np.zeros((frames, 3)))
    known = kinematics.forward(stage.repertoire.skeleton, rotations, roots, joints=stage.lower)
    feet = Kinematics(*(values[:, list(legs.feet)] for values in known))
    reach = max(1, round(GENTLY * stage.repertoire.fps))

    def performed(some: Indices, turn: Array) -> Array:
        return _turned(stage, rotations[some], roots[some], Kinematics(*(values[some] for values in feet)), turn)

    turn = np.zeros((frames, 3))
    out = rotations.copy()
    for attempt in range(rounds):
        if attempt or wanted.any():
            # what is turned as in the round before is where it was
            last, turn = turn, _no_farther(both_ways(wanted, reach))
            goes = np.flatnonzero((turn != last).any(axis=1))
            out[goes] = performed(goes, turn[goes])
            at[goes] = blending.rotation_offset(middle, out[np.ix_(goes, joints)])
        over = np.maximum(at - high, low - at).reshape(frames, -1)
        some = np.flatnonzero(over.max(axis=1) > _OVER)
        if not len(some) or attempt == rounds - 1:
            break
        change = np.empty((len(some), len(joints), 3, 3))
        for axis in range(3):
            moved = performed(some, turn[some] + _STEP * np.eye(3)[axis])[:, joints]
            change[..., axis] = (blending.rotation_offset(middle, moved) - at[some]) / _STEP
        change *= np.where(at[some] - high > low - at[some], 1.0, -1.0)[..., None]
        wanted[some] += _least_turns(change.reshape(len(some), -1, 3), over[some])
        wanted = _no_farther(wanted)
    put_within_range(stage, out, np.array(stage.trunk, dtype=np.intp), np.asarray(turn.any(axis=1)))
    return Turned(out, wanted)


def _turned(stage: Stage, rotations: Array, roots: Array, feet: Kinematics, turn: Array) -> Array:
    """The pelvis turned by rotation vectors in its own frame, shape (frames, 3), trunk and feet left where and as they are."""
    skeleton, carrier = stage.repertoire.skeleton, stage.carrier
    out = rotations.copy()
    by = quaternion.from_rotvec(turn)
    out[:, carrier] = quaternion.multiply(rotations[:, carrier], by)
    for joint in stage.trunk:
        out[:, joint] = quaternion.multiply(quaternion.conjugate(by), rotations[:, joint])
    known = kinematics.forward(skeleton, out, roots, joints=stage.lower)
    known.rotations[:, list(stage.legs.feet)] = feet.rotations
    return inverse_kinematics.reach(skeleton, out, roots, feet.positions, limbs=stage.legs, known=known).rotations


def _no_farther(turn: Array) -> Array:
    """Rotation vectors (frames, 3), none longer than `FARTHEST`."""
    size = np.linalg.norm(turn, axis=-1, keepdims=True)
    return np.asarray(turn * np.minimum(1.0, FARTHEST / np.maximum(size, 1e-9)))


def _least_turns(change: Array, over: Array) -> Array:
    """What the pelvis is to be turned by so that nothing is beyond its range any more, as far as that goes: shape (frames, 3).

    Projected in turn onto what each component allows, the worst first (Kaczmarz, for inequalities).

    Parameters
    ----------
    change : by which each component goes outwards as the pelvis is turned, shape (frames, components, 3).
    over : radians by which each is beyond its range, negative within, shape (frames, components).
    """
    out = np.zeros((len(change), 3))
    size = np.square(change).sum(axis=-1) + _DAMPED
    each = np.arange(len(change))
    for _ in range(_PROJECTIONS):
        rest = over + np.einsum("fci,fi->fc", change, out)
        worst = rest.argmax(axis=1)
        by = np.maximum(rest[each, worst], 0.0)
        if not by.any():
            break
        out -= (by / size[each, worst])[:, None] * change[each, worst]
    return out
