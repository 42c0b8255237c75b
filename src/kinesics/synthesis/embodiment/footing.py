"""Where feet and body go so that bearing feet stay in place and nothing is accelerated more than need be ([Schultz2012] §4.4).

What is added to the places of both ankles and of the body is sought for all frames at once, as the least of a sum of squares
(in the spirit of Kovar, Schreiner & Gleicher 2002, *Footskate Cleanup for Motion Capture Editing*, whose corrections are
smoothed after they are found; here smoothness is part of what is sought):

- a bearing foot's going over the floor, whole in the middle of a contact, little at its ends, where it rolls on and off;
- a bearing sole's height above the floor;
- angular accelerations of knees and hips that the correction adds, as shares of what those joints do in the recordings. Near
  full extension a knee turns much for little, so there the body goes along rather than the leg being stretched;
- accelerations of feet and body that it adds;
- how far feet are from where the recording has them beneath the body, and the body from where it has it.

The sum is quadratic, its matrix banded, so that the answer is exact and takes a few milliseconds: compiled, where that was
built, in NumPy and SciPy elsewhere.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled

Array = NDArray[np.float64]

SLIP: Final = 0.0003
"""m/s over the floor that weigh as much as the accelerations below. Ten times more, and who stands for a minute creeps by
centimetres."""
HEIGHT: Final = 0.006
"""Metres above the floor that do."""
GENTLE: Final = 30.0
"""m/s²: of a foot. With `ASTRAY` it sets how soon a foot that was let go is where the recording has it beneath the body: sooner it
jerks, later a runner's feet seem to bear for longer than they do."""
ASTRAY: Final = 0.008
"""Metres of a foot from its place beneath the body."""
ADRIFT: Final = 1.0
"""Metres of the body over the floor from its place: feet that slide in the recordings make every stride a little longer than legs
that stand can, and the body, gone on as it was laid, would take a hip to the end of its range in every step."""
BOUND: Final = 0.001
"""Metres of a foot from where a joint at the end of its range has it."""
SINKING: Final = 0.02
"""Metres of the body's height."""
_SHARE: Final = 0.25
"""Of the 99th percentile of the recordings' accelerations, which weighs as much as the values above."""
_LEAST_BEND: Final = np.deg2rad(12.0)
"""A knee that is straighter counts as one bent by so much: beyond, the leg's length is quadratic in the angle."""
_BODY: Final = 6
_ANYWHERE: Final = 12.0
"""Metres that stand for `ADRIFT` while the body stands."""
_NONE: Final = "There is no least sum of squares: places, or what they weigh, are not finite."


class Leg(NamedTuple):
    """Of both legs in every frame, before anything is added."""

    direction: Array
    """Unit vectors from hip to ankle, shape (frames, 2, 3)."""
    distance: Array
    """Metres from hip to ankle, shape (frames, 2)."""
    knee: Array
    """Radians that the knee turns for each metre of that distance, shape (frames, 2)."""


def legs_of(hips: Array, knees: Array, ankles: Array) -> Leg:
    """From the places of hips, knees and ankles, shape (frames, 2, 3) each."""
    upper, lower, away = knees - hips, ankles - knees, ankles - hips
    upper, lower, distance = (np.sqrt(np.einsum("...i,...i->...", v, v)) for v in (upper, lower, away))
    distance = np.maximum(distance, 1e-6)
    cosine = np.clip((distance**2 - upper**2 - lower**2) / (2.0 * upper * lower), -1.0, 1.0)
    bend = np.maximum(np.arccos(cosine), _LEAST_BEND)
    return Leg(away / distance[..., None], distance, distance / (upper * lower * np.sin(bend)))


class Usual(NamedTuple):
    """Accelerations in the recordings, 99th percentiles."""

    hips: Array
    """rad/s², shape (2,)."""
    knees: Array
    body: float
    """m/s²."""


class Stiffness(NamedTuple):
    """How much what is added to feet and body bends knees and turns hips, as shares of what that weighs: see `stiffness`."""

    knees: Array
    """For each metre that a foot goes beneath the body, shape (frames, 2, 3)."""
    hips: Array
    """The same of turning, whichever way it goes, shape (frames, 2)."""
    foot: float
    """For each metre that a foot goes in the world."""
    body: float


class Footing(NamedTuple):
    """What is added to places, metres."""

    feet: Array
    """Shape (frames, 2, 3)."""
    body: Array
    """Shape (frames, 3)."""


class Bounds(NamedTuple):
    """How far feet must be moved beneath the body, as far as legs reach and joints go."""

    way: Array
    """In which way, unit vectors, shape (frames, 2, 3); 0 where nothing binds."""
    least: Array
    """How far, metres, shape (frames, 2)."""

    @classmethod
    def none(cls, frames: int) -> Bounds:
        """Nothing binds."""
        return cls(np.zeros((frames, 2, 3)), np.zeros((frames, 2)))


def footing(
    slid: Array,
    grip: Array,
    height: Array,
    press: Array,
    stiff: Stiffness,
    fps: float,
    bounds: Bounds,
    both: Array | float = 0.0,
    adrift: float = ADRIFT,
) -> Footing:
    """Seek what is added to the places of feet and body.

    Parameters
    ----------
    slid : what the point that each foot stands on goes over the floor from each frame to the next, x and z: (frames − 1, 2, 2).
    grip : 0 to 1, how much of that is to be taken away, shape (frames − 1, 2).
    height : of the lowest point of each sole above the floor, shape (frames, 2).
    press : 0 to 1, how much it is to be on the floor, shape (frames, 2).
    both : 0 to 1, how surely the body stands on both feet, shape (frames,): it is then where they are, and comes back when one
        swings.
    adrift : metres of the body over the floor from its place that weigh as much as the others.
    """
    frames = len(height)
    if frames < 3:
        return Footing(np.zeros((frames, 2, 3)), np.zeros((frames, 3)))
    drift = np.broadcast_to(1.0 / np.square([adrift, SINKING, adrift]), (frames, 3)).copy()
    drift[:, [0, 2]] += np.broadcast_to(both, frames)[:, None] * (_ANYWHERE**-2 - drift[:, [0, 2]])
    sought = _Sought(
        stiff, slid, grip * (fps / SLIP), height, press / HEIGHT, bounds.way / BOUND, bounds.least / BOUND, drift
    )
    found = _quickly(sought) if compiled.wanted() else _plainly(sought)
    return Footing(found[:, :_BODY].reshape(frames, 2, 3), found[:, _BODY:])


def stiffness(leg: Leg, usual: Usual, fps: float) -> Stiffness:
    """What it weighs to accelerate feet and body so that these legs bend and swing."""
    return Stiffness(
        leg.direction * (leg.knee * fps**2 / (_SHARE * usual.knees))[..., None],
        fps**2 / (leg.distance * _SHARE * usual.hips),
        fps**2 / GENTLE,
        fps**2 / (_SHARE * usual.body),
    )


class _Sought(NamedTuple):
    """The sum of squares: every difference times the root of what it weighs."""

    stiff: Stiffness
    slid: Array
    """Metres, as it comes."""
    grip: Array
    height: Array
    """Metres, as it comes."""
    press: Array
    way: Array
    least: Array
    drift: Array
    """What the body's place weighs, shape (frames, 3)."""


def _quickly(sought: _Sought) -> Array:
    """What is added to both feet and the body where the sum is least, shape (frames, 9)."""
    out = np.empty((len(sought.height), 9))
    stiff, *others, drift = sought
    slid, grip, height, press, way, least = (np.ascontiguousarray(o, dtype=np.float64) for o in others)
    if not compiled.native.seek_footing(
        np.ascontiguousarray(stiff.knees),
        np.ascontiguousarray(stiff.hips),
        stiff.foot**2,
        stiff.body**2,
        slid,
        grip,
        height,
        press,
        way,
        least,
        1.0 / ASTRAY**2,
        drift,
        out,
    ):
        raise np.linalg.LinAlgError(_NONE)
    return out


def _plainly(sought: _Sought) -> Array:
    """`_quickly` without the compiled module."""
    stiff, slid, grip, height, press, ways, least, drift = sought
    frames = len(height)
    here, next_, after = np.zeros((frames, 9, 9)), np.zeros((frames, 9, 9)), np.zeros((frames, 9, 9))
    wanted = np.zeros((frames, 9))
    diagonal = np.einsum("fii->fi", here)
    beside = np.einsum("fii->fi", next_)
    for k in (0, 1):
        for n, axis in enumerate((0, 2)):
            column = 3 * k + axis
            weight = np.square(grip[:, k])
            diagonal[1:, column] += weight
            diagonal[:-1, column] += weight
            beside[:-1, column] -= weight
            wanted[1:, column] -= weight * slid[:, k, n]
            wanted[:-1, column] += weight * slid[:, k, n]
        weight = np.square(press[:, k])
        diagonal[:, 3 * k + 1] += weight
        wanted[:, 3 * k + 1] -= weight * height[:, k]
        foot, body = slice(3 * k, 3 * k + 3), slice(_BODY, _BODY + 3)
        way = ways[:, k]
        firm = way[:, :, None] * way[:, None, :] + np.eye(3) / ASTRAY**2
        here[:, foot, foot] += firm
        here[:, body, body] += firm
        here[:, foot, body] -= firm
        here[:, body, foot] -= firm
        pull = way * least[:, k, None]
        wanted[:, foot] += pull
        wanted[:, body] -= pull
    diagonal[:, _BODY:] += drift
    square, cross, far = (_bent(stiff, lag) for lag in (0, 1, 2))
    here[:-2] += square[:-2]
    here[1:-1] += 4.0 * square[1:-1]
    here[2:] += square[2:]
    next_[:-2] -= 2.0 * cross[:-1]
    next_[1:-1] -= 2.0 * cross[1:]
    after[:-2] += far
    return _solved(here, next_, after, wanted)


def _bent(stiff: Stiffness, lag: int) -> Array:
    """MᵗM of each frame with that ``lag`` frames later, shape (frames − lag, 9, 9): M times what is added is what is to have
    little second difference, as a share of what that weighs."""
    frames = len(stiff.knees) - lag
    early, late = slice(0, frames), slice(lag, None)
    out = np.zeros((frames, 9, 9))
    body = slice(_BODY, _BODY + 3)
    for k in (0, 1):
        foot = slice(3 * k, 3 * k + 3)
        knee, hip = stiff.knees[:, k], stiff.hips[:, k]
        block = knee[early, :, None] * knee[late, None, :]
        block += (hip[early] * hip[late])[:, None, None] * np.eye(3)
        out[:, foot, foot] += block + stiff.foot**2 * np.eye(3)
        out[:, body, body] += block
        out[:, foot, body] -= block
        out[:, body, foot] -= block
    out[:, body, body] += stiff.body**2 * np.eye(3)
    return out


def _solved(here: Array, next_: Array, after: Array, wanted: Array) -> Array:
    """Solution of the block-banded symmetric system: blocks of each frame with itself, the next and the one after that."""
    from scipy.linalg import solveh_banded

    frames, size = wanted.shape
    bands = np.zeros((3 * size, frames * size))
    # in lower form row d holds the entries (i + d, i)
    for offset, blocks in enumerate((here, next_, after)):
        for i in range(size):
            for j in range(size):
                below = offset * size + j - i
                if below >= 0:
                    bands[below, i::size] = blocks[:, i, j]
    found = solveh_banded(bands, wanted.reshape(-1), lower=True, overwrite_ab=True, check_finite=False)
    if not np.isfinite(found).all():
        raise np.linalg.LinAlgError(_NONE)
    return np.asarray(found).reshape(frames, size)
