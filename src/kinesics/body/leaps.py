"""Leaps: a joint, or the whole body, is from one frame to the next where no movement takes it.

A limb, however quick, gathers its speed over several frames; a leap does so in one, and comes out of nowhere. One of most of the
body at once is a gap in the recording.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body.findings import Finding, frames_text
from kinesics.body.motion import Motion
from kinesics.body.stature import reaches
from kinesics.geometry import quaternion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

TURN_LIMIT: Final = 50.0
"""rad/s. A joint that turns faster from one frame to the next leaps, if it does so abruptly and out of nowhere."""
ROOT_SPEED_LIMIT: Final = 13.0
"""m/s. No pelvis is faster."""
OUT_OF_NOWHERE: Final = 8.0
"""A step is a leap only if it is so many times the joint's median step in the half second about it."""
ABRUPT: Final = 0.7
"""A step is a leap only if its velocity is gathered or lost to so large a part within one frame."""
SETTLED: Final = 0.5
"""rad/s. What a joint that is hardly moving is taken to do, so that a start from rest is no leap."""
APART: Final = 20.0
"""rad/s. First or last frames that stand apart by more than this in two joints or more are reported."""
WHOLE_BODY: Final = 0.5
"""A leap of so large a share of the moving joints at once is a gap in the recording."""
EVENT_SECONDS: Final = 0.1
"""Leaps of one joint nearer than this in time are one event."""
STILL: Final = 1e-6
"""Radians, or metres of the root, from one frame to the next: what is less is rounding. A joint without freedom that went
through rotations, as in a performed movement or a file of single precision, has it."""


class Steps(NamedTuple):
    """How far every joint goes from frame to frame."""

    turn: Array
    """rad/s, shape (frames − 1, joints)."""
    local: Array
    """Median of ``turn`` over the half second, same shape."""
    root: Array
    """m/s, shape (frames − 1,)."""
    local_root: Array
    still: Mask
    """The same value in both frames, but for rounding: shape (frames − 1, joints + 1); the last is the root's place."""


def continuous(q: Array) -> Array:
    """Rotations (frames, joints, 4) without flips of sign: −q is the same, and a file that flips would seem to leap and tremble."""
    if np.any(np.einsum("fji,fji->fj", q[1:], q[:-1]) < 0.0):
        return quaternion.continuous(q)
    return q


def measure(motion: Motion, rotations: Array) -> Steps:
    """The steps of a motion of two frames or more, given its rotations from `continuous`."""
    fps = motion.fps
    difference = np.diff(rotations, axis=0)
    # |q − p| = 2 sin(θ/4), exact for small steps
    chord = np.sqrt(np.einsum("fji,fji->fj", difference, difference))
    turn = 4.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)) * fps
    root_step = np.diff(motion.root_positions, axis=0)
    root = np.linalg.norm(root_step, axis=-1) * fps
    still = np.concatenate([turn <= STILL * fps, (root <= STILL * fps)[:, None]], axis=1)
    return Steps(turn, _local(turn, fps), root, _local(root[:, None], fps)[:, 0], still)


def _local(values: Array, fps: float) -> Array:
    """Median over each half second; the larger of the two nearest stretches, so that no start is a leap."""
    width = max(3, round(0.5 * fps))
    count = max(1, len(values) // width)
    blocks = np.array_split(values, count)
    medians = np.stack([np.median(block, axis=0) for block in blocks])
    lengths = np.array([len(block) for block in blocks])
    ends = np.cumsum(lengths)
    own = np.repeat(np.arange(count), lengths)
    first_half = np.arange(len(values)) - (ends - lengths)[own] < lengths[own] / 2.0
    other = np.clip(own + np.where(first_half, -1, 1), 0, count - 1)
    return np.asarray(np.maximum(medians[own], medians[other]))


def gaps(motion: Motion, steps: Steps) -> list[Finding]:
    """Where the whole body jumps at once: frames lost, clips joined, an inserted reference pose."""
    moving = ~steps.still[:, :-1].all(axis=0)
    if moving.sum() < 2:
        return []
    sudden = steps.turn > OUT_OF_NOWHERE * np.maximum(steps.local, SETTLED)
    share = sudden[:, moving].mean(axis=1)
    out = []
    last = len(share) - 1
    for t in np.nonzero((share >= WHOLE_BODY) & (sudden.sum(axis=1) >= 2))[0].tolist():
        if 0 < t < last:
            degrees = float(np.rad2deg(steps.turn[t].max() / motion.fps))
            text = (
                f"{share[t]:.0%} of the moving joints jump at once between frames {t} and {t + 1}: frames are missing, or two "
                "recordings were joined."
            )
            out.append(Finding("gap", (), t + 1, t + 2, degrees, "°", text))
    return out + _reference_poses(motion, steps)


def _reference_poses(motion: Motion, steps: Steps) -> list[Finding]:
    """First and last frames that stand apart from those beside them."""
    names, fps = motion.skeleton.joint_names, motion.fps
    last = len(steps.turn) - 1
    if last < 3:
        return []
    out = []
    for t, near, which in ((0, slice(1, 1 + _reach(fps)), "first"), (last, slice(-1 - _reach(fps), -1), "last")):
        after = np.maximum(steps.turn[near].max(axis=0), SETTLED)
        apart = (steps.turn[t] > APART) & (steps.turn[t] > OUT_OF_NOWHERE * after)
        if apart.sum() >= 2:
            joint = int(np.argmax(steps.turn[t]))
            degrees = float(np.rad2deg(steps.turn[t, joint] / fps))
            text = (
                f"The {which} frame stands apart ({names[joint]} turns by {degrees:.0f}° in one frame): perhaps an inserted "
                "reference pose."
            )
            frame = 0 if which == "first" else motion.frame_count - 1
            out.append(Finding("gap", (names[joint],), frame, frame + 1, degrees, "°", text))
    return out


def _reach(fps: float) -> int:
    return max(2, round(EVENT_SECONDS * fps))


def glitches(motion: Motion, steps: Steps, cuts: Collection[int]) -> list[Finding]:
    """Leaps of single joints or of the root, grouped by time; most come back after a few frames.

    Parameters
    ----------
    cuts : steps at which the recording has a gap: what leaps there is told already.
    """
    leap = (steps.turn > TURN_LIMIT) & (steps.turn > OUT_OF_NOWHERE * steps.local)
    for t, j in np.argwhere(leap).tolist():
        leap[t, j] = _abrupt(motion.rotations[max(t - 1, 0) : t + 3, j], t > 0)
    root_leap = (steps.root > ROOT_SPEED_LIMIT) & (steps.root > OUT_OF_NOWHERE * np.maximum(steps.local_root, 0.1))
    for t in cuts:
        # a cut is told once; the inserted first frame is step 0, told as frame 0
        leap[max(t, 0)], root_leap[max(t, 0)] = False, False
    if motion.frame_count - 2 in cuts:
        leap[-1], root_leap[-1] = False, False
    return _leaps_of_root(motion, steps, root_leap) + _leaps_of_joints(motion, steps, leap)


def thrown(motion: Motion, least: float) -> list[tuple[int, int]]:
    """Where a motion of two frames or more leaps so that something is thrown by ``least`` metres, or has a gap: first and last
    frame of each stretch, from the frame before the leap to the frame behind it.
    """
    steps = measure(motion, continuous(motion.rotations))
    cuts = gaps(motion, steps)
    found = cuts + [leap for leap in glitches(motion, steps, {c.start - 1 for c in cuts}) if leap.moved >= least]
    return [(max(f.start - 1, 0), min(f.end, motion.frame_count - 1)) for f in found]


def _leaps_of_root(motion: Motion, steps: Steps, leap: Mask) -> list[Finding]:
    out = []
    for first, last in _events(leap, motion.fps):
        start, end = first + 1, max(last + 1, first + 2)
        speed = float(steps.root[first : last + 1].max())
        text = f"The whole body leaps at {speed:.0f} m/s at {frames_text(start, end)}."
        joints = (motion.skeleton.joint_names[0],)
        out.append(Finding("glitch", joints, start, end, speed, "m/s", text, moved=speed / motion.fps))
    return out


def _leaps_of_joints(motion: Motion, steps: Steps, leap: Mask) -> list[Finding]:
    names, fps = motion.skeleton.joint_names, motion.fps
    out = []
    jumpy = np.nonzero(leap.any(axis=0))[0].tolist()
    reach = reaches(motion) if jumpy else np.zeros(0)
    for j in jumpy:
        for first, last in _events(leap[:, j], fps):
            start, end = first + 1, max(last + 1, first + 2)
            angle = float(steps.turn[first : last + 1, j].max()) / fps
            ends = motion.rotations[first, j], motion.rotations[min(last + 1, motion.frame_count - 1), j]
            back = last > first and float(quaternion.angle(*ends)) < 0.5 * angle
            degrees = float(np.rad2deg(angle))
            text = f"{names[j]} leaps by {degrees:.0f}° in one frame at {frames_text(start, end)}{' and back' if back else ''}."
            moved = float(2.0 * np.sin(0.5 * angle) * reach[j])
            out.append(Finding("glitch", (names[j],), start, end, degrees, "°", text, moved=moved))
    return out


def _abrupt(q: Array, has_before: bool) -> bool:
    """Whether the velocity of a step changes, from the step before or to the step after, by most of itself.

    A limb, however quick, takes several frames to gather its speed; a leap takes one, and comes back in one.
    """
    steps = quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(q[:-1]), q[1:]))
    this = 1 if has_before else 0
    changes = np.linalg.norm(np.diff(steps, axis=0), axis=-1)
    return len(changes) == 0 or bool(changes.max() > ABRUPT * np.linalg.norm(steps[this]))


def _events(leap: Mask, fps: float) -> list[tuple[int, int]]:
    """(first, last) step of each run of leaps that are near in time."""
    when = np.nonzero(leap)[0]
    if len(when) == 0:
        return []
    groups = np.split(when, np.nonzero(np.diff(when) > EVENT_SECONDS * fps)[0] + 1)
    return [(int(g[0]), int(g[-1])) for g in groups]
