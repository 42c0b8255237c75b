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

The sum is quadratic, its matrix banded, so that the answer is exact and takes a few milliseconds.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SLIP: Final = 0.0003
"""m/s over the floor that weigh as much as the accelerations below."""
HEIGHT: Final = 0.006
"""Metres above the floor that do."""
GENTLE: Final = 100.0
"""m/s²: of a foot."""
ASTRAY: Final = 0.008
"""Metres of a foot from its place beneath the body."""
ADRIFT: Final = 0.12
"""Metres of the body over the floor from its place."""
BOUND: Final = 0.001
"""Metres of a foot from where a joint at the end of its range has it."""
SINKING: Final = 0.02
"""Metres of the body's height."""
_SHARE: Final = 0.25
"""Of the 99th percentile of the recordings' accelerations, which weighs as much as the values above."""
_LEAST_BEND: Final = np.deg2rad(12.0)
"""A knee that is straighter counts as one bent by so much: beyond, the leg's length is quadratic in the angle."""
_BODY: Final = 6
_LEFT: Final = 1e-4
"""Share of the weight of `ADRIFT` that is left while the body stands."""


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
    upper, lower = np.linalg.norm(knees - hips, axis=-1), np.linalg.norm(ankles - knees, axis=-1)
    away = ankles - hips
    distance = np.maximum(np.linalg.norm(away, axis=-1), 1e-6)
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
    """Weights of second differences of what is added to both feet and the body: see `stiffness`."""

    here: Array
    """Of each frame with itself, shape (frames, 9, 9)."""
    next: Array
    """With the one after, shape (frames − 1, 9, 9)."""
    after: Array
    """With the one after that, shape (frames − 2, 9, 9)."""


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
) -> Footing:
    """Seek what is added to the places of feet and body.

    Parameters
    ----------
    slid : what the bearing part of each sole goes over the floor from each frame to the next, x and z: (frames − 1, 2, 2).
    grip : 0 to 1, how much of that is to be taken away, shape (frames − 1, 2).
    height : of the lowest point of each sole above the floor, shape (frames, 2).
    press : 0 to 1, how much it is to be on the floor, shape (frames, 2).
    both : 0 to 1, how surely the body stands on both feet, shape (frames,): it is then where they are, and comes back when one
        swings.
    """
    frames = len(height)
    if frames < 3:
        return Footing(np.zeros((frames, 2, 3)), np.zeros((frames, 3)))
    here, next_, after = np.zeros((frames, 9, 9)), np.zeros((frames, 9, 9)), np.zeros((frames, 9, 9))
    wanted = np.zeros((frames, 9))
    diagonal = np.einsum("fii->fi", here)
    beside = np.einsum("fii->fi", next_)
    for k in (0, 1):
        for n, axis in enumerate((0, 2)):
            column = 3 * k + axis
            weight = np.square(grip[:, k] * fps / SLIP)
            diagonal[1:, column] += weight
            diagonal[:-1, column] += weight
            beside[:-1, column] -= weight
            wanted[1:, column] -= weight * slid[:, k, n]
            wanted[:-1, column] += weight * slid[:, k, n]
        weight = np.square(press[:, k] / HEIGHT)
        diagonal[:, 3 * k + 1] += weight
        wanted[:, 3 * k + 1] -= weight * height[:, k]
        foot, body = slice(3 * k, 3 * k + 3), slice(_BODY, _BODY + 3)
        way = bounds.way[:, k] / BOUND
        firm = way[:, :, None] * way[:, None, :] + np.eye(3) / ASTRAY**2
        here[:, foot, foot] += firm
        here[:, body, body] += firm
        here[:, foot, body] -= firm
        here[:, body, foot] -= firm
        pull = way * (bounds.least[:, k] / BOUND)[:, None]
        wanted[:, foot] += pull
        wanted[:, body] -= pull
    weights = np.broadcast_to(1.0 / np.square([ADRIFT, SINKING, ADRIFT]), (frames, 3)).copy()
    weights[:, [0, 2]] *= 1.0 - (1.0 - _LEFT) * np.broadcast_to(both, frames)[:, None]
    diagonal[:, _BODY:] += weights
    square, cross, far = stiff
    here[:-2] += square[:-2]
    here[1:-1] += 4.0 * square[1:-1]
    here[2:] += square[2:]
    next_[:-2] -= 2.0 * cross[:-1]
    next_[1:-1] -= 2.0 * cross[1:]
    after[:-2] += far
    found = _solved(here, next_, after, wanted)
    return Footing(found[:, :_BODY].reshape(frames, 2, 3), found[:, _BODY:])


def stiffness(leg: Leg, usual: Usual, fps: float) -> Stiffness:
    """What it weighs to accelerate feet and body so that these legs bend and swing."""
    return Stiffness(*(_bent(leg, usual, fps, lag) for lag in (0, 1, 2)))


def _bent(leg: Leg, usual: Usual, fps: float, lag: int) -> Array:
    """MᵗM of each frame with that ``lag`` frames later, shape (frames − lag, 9, 9): M times what is added is what is to have
    little second difference, as a share of what that weighs."""
    frames = max(len(leg.distance) - lag, 0)
    early, late = slice(0, frames), slice(lag, None)
    out = np.zeros((frames, 9, 9))
    body = slice(_BODY, _BODY + 3)
    for k in (0, 1):
        foot = slice(3 * k, 3 * k + 3)
        knee = leg.direction[:, k] * (leg.knee[:, k] * fps**2 / (_SHARE * usual.knees[k]))[:, None]
        hip = fps**2 / (leg.distance[:, k] * _SHARE * usual.hips[k])
        block = knee[early, :, None] * knee[late, None, :]
        block += (hip[early] * hip[late])[:, None, None] * np.eye(3)
        out[:, foot, foot] += block + (fps**2 / GENTLE) ** 2 * np.eye(3)
        out[:, body, body] += block
        out[:, foot, body] -= block
        out[:, body, foot] -= block
    out[:, body, body] += (fps**2 / (_SHARE * usual.body)) ** 2 * np.eye(3)
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
    return np.asarray(found).reshape(frames, size)
