"""What looks wrong in a recording: leaps, gaps, frozen stretches, noise, an impossible size, feet off the floor.

`inspect` looks at what sensors and converters do wrong, not at whether the movement is a good one. Every threshold is a
limit of the human body or a multiple of what the same recording does elsewhere; none is fitted to a data set. What
cannot be told from movement (noise below it, a slow drift) is not guessed.

- `inspect`: all that looks wrong, a `Quality` of `Finding` (findings.py); leaps are found in leaps.py
- `estimated_stature` (stature.py)

Limits of the body used here:

- joints turn at up to about 50 rad/s: elbow extension in a pitch 2,400 °/s = 42 rad/s (Fleisig et al. 1999), knee in a
  kick about 30 rad/s; only the rotation of a thrower's upper arm about itself is quicker, and it takes some hundredths
  of a second to become so: it is no leap here, for a leap gathers its speed in one frame
- a runner's pelvis moves at up to 12.4 m/s (Graubner & Nixdorf 2011, 100 m); a hand or foot at up to about 35 m/s
- a leg (thigh and shank) is .491 of the stature (Drillis & Contini 1966; Winter 2009, fig. 4.1)
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.findings import KINDS, MOST_SENTENCES, Finding, Kind, Quality, frames_text, told
from kinesics.body.leaps import ROOT_SPEED_LIMIT, Steps, continuous, gaps, glitches, measure
from kinesics.body.motion import Motion
from kinesics.body.runs import runs
from kinesics.body.stature import estimated_stature

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

__all__ = ["KINDS", "MOST_SENTENCES", "Finding", "Kind", "Quality", "estimated_stature", "inspect"]

TIP_SPEED_LIMIT: Final = 35.0
"""m/s. No hand or foot is faster."""
FROZEN_SECONDS: Final = 0.5
"""A moving joint that stands exactly still for longer is frozen."""
RESTING_SHARE: Final = 0.01
"""A joint that stands exactly still in a larger share of the frames rests."""
RESTING_JOINTS: Final = 0.2
"""If a larger share of the joints rest, the movement was drawn or made by a program, not measured, and none is frozen.
"""
FROZEN_BODY_SECONDS: Final = 0.2
"""The same for the whole body: living bodies are never exactly still."""
REPEATED_SHARE: Final = 0.2
"""Share of frames that repeat the one before from which the recording is said to be of a lower frame rate."""
NOISE_LIMIT: Final = np.deg2rad(0.5)
"""Standard deviation of a joint's white noise, radians, from which it is reported."""
ROOT_NOISE_LIMIT: Final = 0.005
"""The same for the root's place, metres."""
NOISE_AGAINST_TYPICAL: Final = 4.0
"""A joint's noise is reported if it is so many times that of the body's median joint, or the body's own is too much."""
WHITE: Final = -0.6
"""Correlation of successive third differences below which they are noise: white noise has −.75, movement is positive.
"""
STATURE: Final = (0.7, 2.4)
"""Metres. Below and above, the unit of length is more likely wrong than the body that small or tall."""
FLOOR_TOLERANCE: Final = 0.15
"""Metres between the lowest point of the body and the floor y = 0 over the recording."""
SINK_TOLERANCE: Final = 0.15
"""Metres that the body may go below its own usual lowest level."""


def inspect(motion: Motion) -> Quality:
    """Look for what is wrong in a recording.

    Deterministic. Nothing is changed and nothing is raised for any motion.
    """
    # coordinates of 1e200 are wrong enough to be told as a size; they need not warn besides
    with np.errstate(over="ignore", invalid="ignore"):
        found = _inspect(motion)
    ordered = sorted(found, key=lambda f: (KINDS.index(f.kind), -f.moved, -f.figure, f.start))
    return Quality(tuple(ordered), told(ordered))


def _inspect(motion: Motion) -> list[Finding]:
    found: list[Finding] = []
    found += _size(motion)
    if motion.frame_count > 1:
        rotations = continuous(motion.rotations)
        steps = measure(motion, rotations)
        cuts = gaps(motion, steps)
        leaps = glitches(motion, steps, {f.start - 1 for f in cuts})
        found += cuts + leaps
        found += _frozen(motion, steps)
        positions = motion.positions()
        found += _speeds(motion, positions, cuts + leaps)
        found += _jitter(motion, rotations)
        found += _floor(motion, positions)
    return found


def _frozen(motion: Motion, steps: Steps) -> list[Finding]:
    """Stretches of exactly equal values, and frames that repeat the one before."""
    fps = motion.fps
    whole: Mask = np.asarray(steps.still.all(axis=1))
    if whole.all():
        if len(whole) < max(2.0, FROZEN_BODY_SECONDS * fps):
            return []
        text = (
            f"Nothing moves: all {motion.frame_count} frames are exactly the same pose. Living bodies are never exactly still: "
            "one frame was repeated, or the movement was lost on the way into this file."
        )
        return [Finding("frozen", (), 0, motion.frame_count, len(whole) / fps, "s", text)]
    out = []
    pauses = runs(whole)
    repeated = sum(1 for a, b in pauses if b - a == 1)
    if repeated > REPEATED_SHARE * len(whole):
        true_fps = fps * (1.0 - float(whole.mean()))
        text = (
            f"{repeated} of {motion.frame_count} frames repeat the one before: the movement was sampled at about "
            f"{true_fps:.0f} frames a second, not {fps:g}."
        )
        out.append(Finding("frozen", (), 0, motion.frame_count, float(repeated), "frames", text))
    for a, b in pauses:
        if b - a >= max(2.0, FROZEN_BODY_SECONDS * fps):
            text = (
                f"The whole body is exactly still for {(b - a) / fps:.2f} s, {frames_text(a, b + 1)}: frames were repeated, "
                "or a program made them."
            )
            out.append(Finding("frozen", (), a, b + 1, (b - a) / fps, "s", text))
    return out + _frozen_joints(motion, steps, ~whole)


def _frozen_joints(motion: Motion, steps: Steps, alive: Mask) -> list[Finding]:
    """Joints that stand still while the body moves (``alive``, of each step)."""
    fps = motion.fps
    share_moving = (~steps.still[alive]).mean(axis=0)
    labels = (*motion.skeleton.joint_names, "the root's place")
    ever = share_moving > 0.0
    if np.mean(share_moving[ever] < 1.0 - RESTING_SHARE) > RESTING_JOINTS:
        # drawn key by key or made by a program: there it is the rule that joints rest exactly
        return []
    out = []
    # a joint that stands still half the time is animated by hand or at a stop, not frozen
    for j in np.nonzero(share_moving > 0.5)[0]:
        for a, b in runs(steps.still[:, j] & alive):
            if b - a >= max(2.0, FROZEN_SECONDS * fps):
                text = (
                    f"{labels[j]} is frozen for {(b - a) / fps:.2f} s, {frames_text(a, b + 1)}, while the body moves."
                )
                out.append(Finding("frozen", (labels[j],), a, b + 1, (b - a) / fps, "s", text))
    return out


def _speeds(motion: Motion, positions: Array, known: list[Finding]) -> list[Finding]:
    """Speeds beyond the body's, where no leap explains them: a wrong frame rate or unit, or a slide."""
    fps, names = motion.fps, motion.skeleton.joint_names
    way = np.diff(positions, axis=0)
    squared = np.einsum("fji,fji->fj", way, way) * fps**2
    limits = np.full(len(names), TIP_SPEED_LIMIT)
    limits[0] = ROOT_SPEED_LIMIT
    over = squared > limits**2
    for finding in known:
        over[max(0, finding.start - 1) : finding.end] = False
    if not over.any():
        return []
    frames = np.nonzero(over.any(axis=1))[0]
    ratio = np.where(over, squared / limits**2, 0.0)
    t, j = divmod(int(np.argmax(ratio)), len(names))
    speed = float(np.sqrt(squared[t, j]))
    text = f"{names[j]} moves at {speed:.0f} m/s at frame {t + 1}; {len(frames)} frames are faster than a body can be."
    return [Finding("speed", (names[j],), int(frames[0]) + 1, int(frames[-1]) + 2, speed, "m/s", text)]


def _jitter(motion: Motion, rotations: Array) -> list[Finding]:
    """White noise in the joints' angles and in the root's place.

    The third difference of white noise of deviation σ has deviation √20 σ and its neighbours correlate by −.75; that of
    a movement sampled finely enough is small and correlates positively. Medians keep leaps out.
    """
    if motion.frame_count < 16:
        return []
    names = motion.skeleton.joint_names
    out = []
    # a quaternion's length on the unit sphere is half the angle
    sigma, white = _white_noise(rotations)
    sigma = 2.0 * sigma
    moving = sigma > 0.0
    if moving.any():
        typical = float(np.median(sigma[moving]))
        limit = max(NOISE_LIMIT, min(NOISE_AGAINST_TYPICAL * typical, 2.0 * NOISE_LIMIT))
        noisy = (sigma > limit) & white
        if noisy.sum() > 0.5 * moving.sum():
            degrees = float(np.rad2deg(np.median(sigma[noisy])))
            text = f"All joints tremble: noise of about {degrees:.1f}° from frame to frame."
            out.append(Finding("jitter", (), 0, motion.frame_count, degrees, "°", text))
        else:
            for j in np.nonzero(noisy)[0]:
                degrees = float(np.rad2deg(sigma[j]))
                text = (
                    f"{names[j]} trembles: noise of about {degrees:.1f}° from frame to frame, "
                    f"{np.rad2deg(typical):.2g}° being usual in this body."
                )
                out.append(Finding("jitter", (names[j],), 0, motion.frame_count, degrees, "°", text))
    place, white_place = _white_noise(motion.root_positions[:, None, :])
    if place[0] > ROOT_NOISE_LIMIT and white_place[0]:
        text = f"The root's place trembles by about {place[0] * 1000:.0f} mm from frame to frame."
        out.append(Finding("jitter", (names[0],), 0, motion.frame_count, float(place[0]), "m", text))
    return out


def _white_noise(values: Array) -> tuple[Array, Mask]:
    """Deviation per axis of the noise in (frames, joints, n), and whether it is noise; shape (joints,) each."""
    third = np.diff(values, n=3, axis=0)
    squared = np.einsum("fji,fji->fj", third, third)
    beside = np.einsum("fji,fji->fj", third[1:], third[:-1])
    median = np.median(squared, axis=0)
    # the median of a sum of three squares of unit normals is 2.366
    sigma = np.sqrt(median / 2.366 / 20.0)
    # leaps would drown the correlation: only differences of ordinary size count
    ordinary = (squared[1:] < 16.0 * median) & (squared[:-1] < 16.0 * median)
    power = np.sum(np.where(ordinary, 0.5 * (squared[1:] + squared[:-1]), 0.0), axis=0)
    correlation = np.sum(np.where(ordinary, beside, 0.0), axis=0) / np.where(power > 0.0, power, 1.0)
    return sigma, (power > 0.0) & (correlation < WHITE)


def _size(motion: Motion) -> list[Finding]:
    """A body too small or too tall to be one: most often the unit of length is wrong."""
    stature = estimated_stature(motion)
    if stature is None or STATURE[0] <= stature <= STATURE[1]:
        return []
    text = f"The body is about {stature:.3g} m tall: the unit of length is probably not {motion.source.metres_per_unit:g} m."
    return [Finding("size", (), 0, motion.frame_count, stature, "m", text)]


def _floor(motion: Motion, positions: Array) -> list[Finding]:
    """Where the lowest point of the body lies: y = 0 is the floor, and nobody sinks into it."""
    lowest = positions[..., 1].min(axis=1)
    usual = float(np.quantile(lowest, 0.05))
    end = motion.frame_count
    out = []
    if abs(usual) > FLOOR_TOLERANCE:
        where = "below" if usual < 0.0 else "above"
        text = f"The body stands {abs(usual):.2f} m {where} the floor y = 0: the floor is somewhere else, or the unit is wrong."
        out.append(Finding("floor", (), 0, end, abs(usual), "m", text))
    sunk = lowest < usual - SINK_TOLERANCE
    for a, b in runs(sunk):
        depth = float(usual - lowest[a:b].min())
        text = f"The body sinks {depth:.2f} m below the level it stands on, {frames_text(a, b)}."
        out.append(Finding("floor", (), a, b, depth, "m", text))
    return out
