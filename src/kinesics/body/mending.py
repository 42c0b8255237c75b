"""Short glitches of the capture, mended: for some frames something leaps away and back, quicker than any body can.

Genuine movement is told apart by what lies beside. A hand that strikes, a foot that lands, a knee that snaps straight changes
its velocity, and goes on otherwise than it came. What leaps goes on afterwards as if nothing had been: the same velocity leads
there, over the frames between, and on, and only they lie aside, from the first to the last of them. No movement has such frames,
however quick it is. What leaps and stays, or comes back late, is left as it is (`kinesics.body.leaps`).
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.body.motion import Motion
from kinesics.errors import some_of
from kinesics.geometry import quaternion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SECONDS: Final = 0.042
"""From the last frame before a glitch to the first behind it, at most: there and back within it is more than 12 Hz, at which
no limb is moved by centimetres. At fewer than 48 frames a second a single frame takes longer, and nothing can be told."""
AWAY: Final = 0.015
"""Metres that something leaps away, at least."""
AS_BEFORE: Final = 0.35
"""What the velocity before and behind may differ from that which leads over the glitch, metres a frame, as a share of how far away
it leads. At the corner of a path that is changed abruptly it is 1, at the turn of one that is changed steadily .9 or more."""
ALL_AWAY: Final = 0.5
"""Share of that by which every frame of it lies aside."""
OWN: Final = np.deg2rad(0.5)
"""Radians from where a joint would be between the frames beside, from which it has a part in a glitch."""
ROUNDS: Final = 3
"""Times that glitches are looked for: beside one that is mended another may show."""
_STEADY: Final = 0.1
"""Radians a frame that a joint may turn otherwise beside a glitch than over it, for that to be gone on with."""


class Mended(NamedTuple):
    """A motion without its short glitches."""

    motion: Motion
    """The very same where there are none."""
    frames: Mask
    """Which frames were mended, shape (frames,)."""
    joints: tuple[str, ...]
    """Whose ends leapt, those that leapt farthest first."""
    away: float
    """Metres by which the farthest did."""

    def __str__(self) -> str:
        """In words; "" where nothing was mended."""
        count = int(self.frames.sum())
        if not count:
            return ""
        return (
            f"{count} frame{'s'[: count != 1]} mended, in which the capture leaps away and back by up to "
            f"{100.0 * self.away:.0f} cm ({some_of(self.joints)}): taken from those beside"
        )


def mended(motion: Motion) -> Mended:
    """A motion whose short glitches are bridged, joint by joint, from the frames beside; all else is the same to the last bit."""
    longest = int(np.floor(SECONDS * motion.fps + 1e-6)) - 1
    frames = np.zeros(motion.frame_count, dtype=np.bool_)
    if longest < 1 or motion.frame_count < 4:
        return Mended(motion, frames, (), 0.0)
    farthest = np.zeros(motion.skeleton.joint_count)
    out, points = motion, _points(motion)
    for _ in range(ROUNDS):
        before = out
        for length in range(1, longest + 1):
            away = leaps_away(points, length)
            begins = np.flatnonzero(away.any(axis=1))
            if len(begins):
                out = _bridged(out, begins, away, length, frames)
                points = _points(out)
                np.maximum(farthest, _by_joint(motion, away.max(axis=0)), out=farthest)
        if out is before:
            break
    order = np.argsort(-farthest, kind="stable")
    joints = tuple(motion.skeleton.joint_names[j] for j in order.tolist() if farthest[j] > 0.0)
    return Mended(out, frames, joints, float(farthest.max(initial=0.0)))


def leaps_away(points: Array, length: int) -> Array:
    """Where points leap away for so many frames, and come back.

    Parameters
    ----------
    points : metres, shape (frames, points, 3).

    Returns
    -------
    Metres by which each point does in the ``length`` frames from each frame on, 0 where it does not: shape (frames, points).
    """
    frames, count = points.shape[:2]
    out = np.zeros((frames, count))
    starts = frames - length - 1
    if starts < 1:
        return out
    last, behind = points[:starts], points[length + 1 :]
    over = (behind - last) / (length + 1)
    size, least = np.zeros((starts, count)), np.full((starts, count), np.inf)
    for k in range(1, length + 1):
        aside = _norms(points[k : k + starts] - last - k * over)
        np.maximum(size, aside, out=size)
        np.minimum(least, aside, out=least)
    frame, point = np.nonzero((size >= AWAY) & (least >= ALL_AWAY * size))
    size, over = size[frame, point], over[frame, point]
    # where the recording begins or ends nothing is known of beyond
    coming = points[frame, point] - points[np.maximum(frame - 1, 0), point]
    beyond = np.minimum(frame + length + 2, frames - 1)
    going = points[beyond, point] - points[frame + length + 1, point]
    found = (frame == 0) | (_norms(coming - over) <= AS_BEFORE * size)
    found &= (frame + length + 2 == frames) | (_norms(going - over) <= AS_BEFORE * size)
    out[frame[found] + 1, point[found]] = size[found]
    return out


def _norms(vectors: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("...i,...i", vectors, vectors)))


def _points(motion: Motion) -> Array:
    """Places of the joints and, behind them, of the tips, shape (frames, points, 3)."""
    pose = kinematics.forward(motion.skeleton, motion.rotations, motion.root_positions, motion.joint_translations)
    sites = motion.skeleton.end_sites
    tips = [pose.positions[:, s.parent] + quaternion.rotate(pose.rotations[:, s.parent], s.offset) for s in sites]
    return np.concatenate([pose.positions, *(tip[:, None] for tip in tips)], axis=1)


def _by_joint(motion: Motion, values: Array) -> Array:
    """Of every joint, the most of its own point and its tips; of each point one is given."""
    out = values[: motion.skeleton.joint_count].copy()
    for site, value in zip(motion.skeleton.end_sites, values[motion.skeleton.joint_count :].tolist(), strict=True):
        out[site.parent] = max(out[site.parent], value)
    return out


def _bridged(motion: Motion, begins: NDArray[np.intp], away: Array, length: int, frames: Mask) -> Motion:
    """With every joint that has a part in what leaps led over these frames; they are marked."""
    last = motion.frame_count - 1
    rotations, roots = motion.rotations.copy(), motion.root_positions.copy()
    moved = None if motion.joint_translations is None else motion.joint_translations.copy()
    shares = np.arange(1, length + 1) / (length + 1)
    for begin in begins.tolist():
        a, b = begin - 1, begin + length
        chain = _chain(motion, _by_joint(motion, away[begin]) > 0.0)
        between = slice(begin, b)
        over = _over(rotations[max(a - 1, 0) : min(b + 1, last) + 1, chain], a > 0, b < last, length)
        part = (quaternion.angle(over, rotations[between, chain]) > OWN).any(axis=0)
        which = np.flatnonzero(chain)[part]
        rotations[between, which] = over[:, part]
        if chain[0]:
            roots[between] = roots[a] + shares[:, None] * (roots[b] - roots[a])
        if moved is not None:
            moved[between, chain] = moved[a, chain] + shares[:, None, None] * (moved[b, chain] - moved[a, chain])
        frames[between] = True
    return motion.replace(rotations=rotations, root_positions=roots, joint_translations=moved)


def _chain(motion: Motion, leaping: Mask) -> Mask:
    """Joints by which others leap: all that they hang on, but for the root, and all that hangs on them; all if the root does.

    What compensates the leap of one by that of another is so led over together.
    """
    parents = motion.skeleton.parents
    if leaping[0]:
        return np.ones(len(parents), dtype=np.bool_)
    out = leaping.copy()
    for joint in range(len(parents) - 1, 0, -1):
        out[parents[joint]] |= out[joint]
    below = leaping.copy()
    for joint in range(1, len(parents)):
        below[joint] |= below[parents[joint]]
    out |= below
    out[0] = False
    return out


def _over(beside: Array, before: bool, behind: bool, length: int) -> Array:
    """Rotations led over some frames, as they turn before and behind: shape (length, joints, 4).

    Parameters
    ----------
    beside : from the last frame but one before to the second behind, shape (frames, joints, 4).
    before, behind : whether that frame and that second one are there.
    """
    first = beside[1 if before else 0]
    last = beside[-2 if behind else -1]
    whole = quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(first), last))
    pace = whole / (length + 1)
    coming = _pace(beside[0], first, pace) if before else pace
    going = _pace(last, beside[-1], pace) if behind else pace
    third = (length + 1) / 3.0
    leave = quaternion.multiply(first, quaternion.from_rotvec(third * coming))
    arrive = quaternion.multiply(last, quaternion.from_rotvec(-third * going))
    out = np.empty((length, *first.shape))
    for k in range(length):
        t = (k + 1) / (length + 1)
        a, b, c = (quaternion.slerp(p, q, t) for p, q in ((first, leave), (leave, arrive), (arrive, last)))
        out[k] = quaternion.slerp(quaternion.slerp(a, b, t), quaternion.slerp(b, c, t), t)
    return out


def _pace(a: Array, b: Array, usual: Array) -> Array:
    """How joints turn from one frame to the next, radians; as usual where that is no movement either."""
    turned = quaternion.as_rotvec(quaternion.multiply(quaternion.conjugate(a), b))
    steady = np.linalg.norm(turned - usual, axis=-1) <= _STEADY
    return np.where(steady[:, None], turned, usual)
