"""Feet that do not flicker while they are on the ground or near it ([Schultz2012] §4.4).

Feet and toes are the links that a recording knows least about: a few markers close together, a joint of the toes fitted to one of
them. From one frame to the next they may leap by 10° and more while the ankle goes on smoothly. Where the sole is then held in
its place (`embodiment.planting`) the ankle would have to leap instead, and the leg with it. So the turning of feet near the
ground is smoothed beforehand, as in gait analysis markers are before anything is told from them: Winter, *Biomechanics and Motor
Control of Human Movement* (4th ed. 2009, ch. 3.5), has feet below 6 to 10 Hz.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment.ranges import put_within_range
from kinesics.synthesis.embodiment.stage import RELEASE, Stage, held_around

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

STEADY: Final = 0.015
"""Seconds, of a Gaussian over which the turning of feet is averaged: at 9 Hz .7 of it is left, at 3 Hz .96."""
_REACH: Final = 4.0
"""Of which so many to either side are looked at."""


def steady_feet(stage: Stage, rotations: Array, standing: Mask) -> Array:
    """The same pose in every frame, but for feet and toes near the ground, which turn more steadily: (frames, joints, 4).

    Parameters
    ----------
    rotations : of all joints, shape (frames, joints, 4).
    standing : whether each foot bears, shape (frames, 2).
    """
    fps, skeleton = stage.repertoire.fps, stage.repertoire.skeleton
    if STEADY * fps * _REACH < 1.0:
        return rotations  # frames are farther apart than anything that is averaged
    turned = kinematics.forward(skeleton, rotations, np.zeros((len(rotations), 3)), joints=stage.lower).rotations
    out = rotations.copy()
    for side, foot in enumerate(stage.legs.feet):
        near = held_around(standing[:, side], RELEASE * fps)
        # in the world, where a foot stands still while its shin goes over it
        above = quaternion.conjugate(turned[:, skeleton.parents[foot]])
        out[:, foot] = quaternion.multiply(above, _averaged(turned[:, foot], near, STEADY * fps))
        for toes in set(stage.soles.joints[side].tolist()) - {foot}:
            out[:, toes] = _averaged(rotations[:, toes], near, STEADY * fps)
    put_within_range(stage, out, np.unique([*stage.legs.feet, *stage.soles.joints.ravel()]))
    return out


def _averaged(turned: Array, share: Array, width: float) -> Array:
    """Orientations (frames, 4) on the way to their average over ``width`` frames, as far as ``share`` (frames,) says."""
    from scipy.ndimage import gaussian_filter1d

    q = quaternion.continuous(turned)
    past = min(math.ceil(_REACH * width), len(q) - 1)
    # beyond either end it goes on as it came: no foot that turns there is held back
    whole = np.pad(q, ((past, past), (0, 0)), mode="reflect", reflect_type="odd")
    mean = gaussian_filter1d(whole, width, axis=0, truncate=_REACH)[past : past + len(q)]
    return quaternion.slerp(q, quaternion.normalize(mean), share)
