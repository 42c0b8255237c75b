"""Feet that neither flicker nor turn to and fro while they are on the ground ([Schultz2012] §4.4).

Feet and toes are the links that a recording knows least about: a few markers close together, a joint of the toes fitted to one of
them. From one frame to the next they may leap by 10° and more while the ankle goes on smoothly. Where the sole is then held in
its place (`embodiment.planting`) the ankle would have to leap instead, and the leg with it. So the turning of feet near the
ground is smoothed beforehand, as in gait analysis markers are before anything is told from them: Winter, *Biomechanics and Motor
Control of Human Movement* (4th ed. 2009, ch. 3.5), has feet below 6 to 10 Hz.

What remains turns about the vertical under the body's weight by 3° in every step and by 8° in slower movement, as markers on a shoe
do that gives way; the foot beneath stands still or pivots. Heel and ball cannot both stay in their places while it is
turned so. Hence a bearing foot turns only as far as the recording cannot be understood otherwise: `unturning`.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.body import kinematics
from kinesics.body.kinematics import Kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment.ranges import put_within_range
from kinesics.synthesis.embodiment.stage import RELEASE, Stage, about_y, held_around

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

STEADY: Final = 0.015
"""Seconds, of a Gaussian over which the turning of feet is averaged: at 9 Hz .7 of it is left, at 3 Hz .96."""
PLAY: Final = np.deg2rad(6.0)
"""By which a bearing foot may head elsewhere than it was recorded."""
LETTING: Final = 0.15
"""Seconds before and after a contact over which it comes to head as recorded."""
_SOFT: Final = 0.03
"""Seconds, of a Gaussian over which it begins to turn and ceases."""
ROLLED: Final = 0.02
"""Metres that the heel, or the forefoot, is above the other when the foot is half-way between flat and rolled."""
PIVOTING: Final = 3.0
"""rad/s at which the recording has a flat foot turn as readily as one on its heel."""
_LOOSE: Final = 0.001
"""Of how readily it turns on its heel, or its toes, alone: how readily it does so flat."""
_REACH: Final = 4.0
"""Of which so many to either side are looked at."""


def steady_feet(stage: Stage, rotations: Array, standing: Mask) -> Array:
    """The same pose in every frame, but for feet and toes near the ground, which turn more steadily: (frames, joints, 4).

    Parameters
    ----------
    rotations : of all joints, shape (frames, joints, 4).
    standing : whether each foot bears, shape (frames, 2).
    """
    fps, out = stage.repertoire.fps, rotations
    if STEADY * fps * _REACH >= 1.0:  # else frames are farther apart than anything that is averaged
        out = _averaged_feet(stage, rotations, standing)
    return unturned_feet(stage, out, standing)


def _averaged_feet(stage: Stage, rotations: Array, standing: Mask) -> Array:
    fps = stage.repertoire.fps
    turned = _lower(stage, rotations).rotations
    out = rotations.copy()
    for side, foot in enumerate(stage.legs.feet):
        near = held_around(standing[:, side], RELEASE * fps)
        # in the world, where a foot stands still while its shin goes over it
        _put(stage, out, turned, foot, _averaged(turned[:, foot], near, STEADY * fps))
        for toes in set(stage.soles.joints[side].tolist()) - {foot}:
            out[:, toes] = _averaged(rotations[:, toes], near, STEADY * fps)
    return out


def unturned_feet(stage: Stage, rotations: Array, standing: Mask) -> Array:
    """The same pose in every frame, but for feet that bear, which head elsewhere only where they must: (frames, joints, 4).

    Parameters
    ----------
    rotations : of all joints, shape (frames, joints, 4).
    standing : whether each foot bears, shape (frames, 2).
    """
    known = _lower(stage, rotations)
    height = stage.soles.place(known.positions, known.rotations)[..., 1] - stage.levels
    rolled = height[..., 0] - np.minimum(height[..., 1], height[..., 2])
    flat = 1.0 / (1.0 + (rolled / ROLLED) ** 4)
    along = stage.soles.offsets[:, 1] - stage.soles.offsets[:, 0]
    out = rotations.copy()
    for side, foot in enumerate(stage.legs.feet):
        if standing[:, side].any():
            turned = known.rotations[:, foot]
            still = unturning(turned, along[side], flat[:, side], standing[:, side], stage.repertoire.fps)
            _put(stage, out, known.rotations, foot, still)
    put_within_range(stage, out, np.unique([*stage.legs.feet, *stage.soles.joints.ravel()]))
    return out


def _lower(stage: Stage, rotations: Array) -> Kinematics:
    """Legs and soles, wherever the body is."""
    skeleton = stage.repertoire.skeleton
    return kinematics.forward(skeleton, rotations, np.zeros((len(rotations), 3)), joints=stage.lower)


def _put(stage: Stage, rotations: Array, turned: Array, foot: int, orientation: Array) -> None:
    """Turn a foot, in place, to orientations in the world, shape (frames, 4), where all joints are turned as ``turned``."""
    above = turned[:, stage.repertoire.skeleton.parents[foot]]
    rotations[:, foot] = quaternion.multiply(quaternion.conjugate(above), orientation)


def unturning(turned: Array, along: Array, flat: Array, standing: Mask, fps: float) -> Array:
    """Orientations of a foot in the world, shape (frames, 4), that head nowhere else than they must while it bears.

    Of all ways to turn about the vertical that are nowhere farther than `PLAY` from the recorded one the shortest: a foot that is
    turned to and fro stands still, one that pivots does so once. Before and after it goes over into what was recorded.

    Parameters
    ----------
    turned : as recorded, shape (frames, 4).
    along : the sole from heel to ball, in the frame of the foot, shape (3,).
    flat : 0 to 1, how much it bears on heel and forefoot at once, shape (frames,): it turns sooner where it does not.
    standing : whether the foot bears, shape (frames,).
    """
    from scipy.ndimage import gaussian_filter1d

    ahead = quaternion.rotate(turned, along / np.linalg.norm(along))
    heading = np.unwrap(np.arctan2(ahead[:, 0], ahead[:, 2]))
    # the steeper a foot stands the less it heads anywhere, and the less its heading moves what bears
    level = np.square(ahead[:, [0, 2]]).sum(axis=1)
    play = PLAY * level * held_around(standing, LETTING * fps)
    pace = (
        np.abs(gaussian_filter1d(np.gradient(heading), _SOFT * fps, mode="nearest")) * fps if len(heading) > 1 else 0.0
    )
    loose = _LOOSE + np.square(1.0 - flat * standing) + np.square(pace / PIVOTING)
    still = taut(heading - play, heading + play, np.cumsum(loose))
    softly = gaussian_filter1d(still, _SOFT * fps, mode="nearest") - still
    return quaternion.multiply(about_y(still - heading + softly * level * held_around(standing, LETTING * fps)), turned)


def taut(low: Array, high: Array, at: Array) -> Array:
    """The shortest line between two others, shape (frames,): a string pulled taut in a tube, its ends free to go up and down in it.

    Of all lines in the tube it has the least sum of squared slopes, too, each times its length, and turns back no more often than
    it must (Davies & Kovac 2001, *Annals of Statistics* 29:1).

    Parameters
    ----------
    at : where along the tube each frame lies, rising, shape (frames,).
    """
    if compiled.wanted():
        found = np.empty((2, 2 * len(low)))
        bounds = (np.ascontiguousarray(values, dtype=np.float64) for values in (low, high, at))
        count = compiled.native.taut(*bounds, *found)
        return np.asarray(np.interp(at, *found[:, :count])) if count else _unbent(low, high)
    floor, ceiling, place = low.tolist(), high.tolist(), at.tolist()
    begin, end = _level(floor, ceiling), _level(floor[::-1], ceiling[::-1])
    if begin is None or end is None:
        return _unbent(low, high)
    floor[0] = ceiling[0] = begin
    floor[-1] = ceiling[-1] = end
    # a funnel: from the last corner on, the hulls of what the string may have to go round below and above it
    corners = [(place[0], begin)]
    below, above = deque(corners), deque(corners)
    for x, least, most in zip(place[1:], floor[1:], ceiling[1:], strict=True):
        for hull, other, point, side in ((below, above, (x, least), 1.0), (above, below, (x, most), -1.0)):
            while len(hull) > 1 and side * (_slope(hull[-2], hull[-1]) - _slope(hull[-1], point)) <= 0.0:
                hull.pop()
            # past the other side: the string is bent round what lies there first
            while (
                len(hull) == 1
                and len(other) > 1
                and side * (_slope(other[0], point) - _slope(other[0], other[1])) > 0.0
            ):
                other.popleft()
                corners.append(other[0])
                hull[0] = other[0]
            hull.append(point)
    corners.append((place[-1], end))
    return np.asarray(np.interp(at, *np.array(corners).T))


def _unbent(low: Array, high: Array) -> Array:
    """A level line in a tube that has room for one, as near the middle as there is: shape (frames,)."""
    return np.full(len(low), min(max(float(np.mean(0.5 * (low + high))), float(low.max())), float(high.min())))


def _slope(a: tuple[float, float], b: tuple[float, float]) -> float:
    return (b[1] - a[1]) / (b[0] - a[0])


def _level(floor: list[float], ceiling: list[float]) -> float | None:
    """Where a string begins that is free to: level with what it goes round first; None where nothing is in its way."""
    least, most = -np.inf, np.inf
    for low, high in zip(floor, ceiling, strict=True):
        if low > most:
            return most
        if high < least:
            return least
        least, most = max(least, low), min(most, high)
    return None


def _averaged(turned: Array, share: Array, width: float) -> Array:
    """Orientations (frames, 4) on the way to their average over ``width`` frames, as far as ``share`` (frames,) says."""
    from scipy.ndimage import gaussian_filter1d

    q = quaternion.continuous(turned)
    past = min(math.ceil(_REACH * width), len(q) - 1)
    # beyond either end it goes on as it came: no foot that turns there is held back
    whole = np.pad(q, ((past, past), (0, 0)), mode="reflect", reflect_type="odd")
    mean = gaussian_filter1d(whole, width, axis=0, truncate=_REACH)[past : past + len(q)]
    return quaternion.slerp(q, quaternion.normalize(mean), share)
