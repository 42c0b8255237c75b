"""What looks wrong in a recording: leaps, gaps, frozen stretches, noise, an impossible size, feet off the floor.

`inspect` looks at what sensors and converters do wrong, not at whether the movement is a good one. Every threshold is a
limit of the human body or a multiple of what the same recording does elsewhere; none is fitted to a data set. What
cannot be told from movement (noise below it, a slow drift) is not guessed.

Limits of the body used here:

- joints turn at up to about 50 rad/s: elbow extension in a pitch 2,400 °/s = 42 rad/s (Fleisig et al. 1999), knee in a
  kick about 30 rad/s; only the rotation of a thrower's upper arm about itself is quicker, and it takes some hundredths
  of a second to become so: it is no leap here, for a leap gathers its speed in one frame
- a runner's pelvis moves at up to 12.4 m/s (Graubner & Nixdorf 2011, 100 m); a hand or foot at up to about 35 m/s
- a leg (thigh and shank) is .491 of the stature (Drillis & Contini 1966; Winter 2009, fig. 4.1)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from kinesics.body import anatomy
from kinesics.body.motion import Motion
from kinesics.errors import SkeletonError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

Kind = Literal["size", "gap", "glitch", "frozen", "speed", "jitter", "floor"]
KINDS: Final[tuple[Kind, ...]] = get_args(Kind)
"""What a finding can be, worst first."""

TURN_LIMIT: Final = 50.0
"""rad/s. A joint that turns faster from one frame to the next leaps, if it does so abruptly and out of nowhere."""
ROOT_SPEED_LIMIT: Final = 13.0
"""m/s. No pelvis is faster."""
TIP_SPEED_LIMIT: Final = 35.0
"""m/s. No hand or foot is faster."""
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
LEG_TO_STATURE: Final = 0.491
FLOOR_TOLERANCE: Final = 0.15
"""Metres between the lowest point of the body and the floor y = 0 over the recording."""
SINK_TOLERANCE: Final = 0.15
"""Metres that the body may go below its own usual lowest level."""

MOST_SENTENCES: Final = 6


@dataclass(frozen=True)
class Finding:
    """One thing that looks wrong."""

    kind: Kind
    joints: tuple[str, ...]
    """The joints concerned, worst first; empty for the whole body."""
    start: int
    end: int
    """Frames [start, end)."""
    figure: float
    """How bad, in ``unit``."""
    unit: str
    sentence: str
    moved: float = 0.0
    """Of a glitch: metres by which the farthest point that hangs on the joints is thrown, at most."""

    @property
    def joint(self) -> str:
        """The worst joint; "" for the whole body."""
        return self.joints[0] if self.joints else ""


@dataclass(frozen=True)
class Quality:
    """What looks wrong in one recording; empty findings are the best news."""

    findings: tuple[Finding, ...]
    """Every one, by kind (worst kind first), then by how bad."""
    sentences: tuple[str, ...]
    """The same in at most six sentences, events of one joint told together."""

    def of_kind(self, kind: Kind) -> tuple[Finding, ...]:
        """The findings of one kind."""
        return tuple(f for f in self.findings if f.kind == kind)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {
            "sentences": list(self.sentences),
            "counts": {kind: len(self.of_kind(kind)) for kind in KINDS},
            "findings": [
                {
                    "kind": f.kind,
                    "joints": list(f.joints),
                    "start": f.start,
                    "end": f.end,
                    "figure": f.figure,
                    "unit": f.unit,
                    "moved_m": f.moved,
                    "sentence": f.sentence,
                }
                for f in self.findings
            ],
        }


class _Steps(NamedTuple):
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


def inspect(motion: Motion) -> Quality:
    """Look for what is wrong in a recording.

    Deterministic. Nothing is changed and nothing is raised for any motion.
    """
    # coordinates of 1e200 are wrong enough to be told as a size; they need not warn besides
    with np.errstate(over="ignore", invalid="ignore"):
        found = _inspect(motion)
    ordered = sorted(found, key=lambda f: (KINDS.index(f.kind), -f.moved, -f.figure, f.start))
    return Quality(tuple(ordered), _sentences(ordered))


def _inspect(motion: Motion) -> list[Finding]:
    found: list[Finding] = []
    found += _size(motion)
    if motion.frame_count > 1:
        # −q is the same rotation: without this every file that flips signs would seem to leap and to tremble
        rotations = _continuous(motion.rotations)
        steps = _measure(motion, rotations)
        cuts = _gaps(motion, steps)
        leaps = _glitches(motion, steps, {f.start - 1 for f in cuts})
        found += cuts + leaps
        found += _frozen(motion, steps)
        positions = motion.positions()
        found += _speeds(motion, positions, cuts + leaps)
        found += _jitter(motion, rotations)
        found += _floor(motion, positions)
    return found


def _continuous(q: Array) -> Array:
    if np.any(np.einsum("fji,fji->fj", q[1:], q[:-1]) < 0.0):
        return quaternion.continuous(q)
    return q


def _measure(motion: Motion, rotations: Array) -> _Steps:
    fps = motion.fps
    difference = np.diff(rotations, axis=0)
    # |q − p| = 2 sin(θ/4), exact for small steps
    chord = np.sqrt(np.einsum("fji,fji->fj", difference, difference))
    turn = 4.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)) * fps
    root_step = np.diff(motion.root_positions, axis=0)
    root = np.linalg.norm(root_step, axis=-1) * fps
    still = np.concatenate([turn <= STILL * fps, (root <= STILL * fps)[:, None]], axis=1)
    return _Steps(turn, _local(turn, fps), root, _local(root[:, None], fps)[:, 0], still)


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


def _gaps(motion: Motion, steps: _Steps) -> list[Finding]:
    """Where the whole body jumps at once: frames lost, clips joined, an inserted reference pose."""
    names, fps = motion.skeleton.joint_names, motion.fps
    moving = ~steps.still[:, :-1].all(axis=0)
    if moving.sum() < 2:
        return []
    sudden = steps.turn > OUT_OF_NOWHERE * np.maximum(steps.local, SETTLED)
    share = sudden[:, moving].mean(axis=1)
    out = []
    last = len(share) - 1
    for t in np.nonzero((share >= WHOLE_BODY) & (sudden.sum(axis=1) >= 2))[0].tolist():
        if 0 < t < last:
            degrees = float(np.rad2deg(steps.turn[t].max() / fps))
            text = (
                f"{share[t]:.0%} of the moving joints jump at once between frames {t} and {t + 1}: frames are missing, or two "
                "recordings were joined."
            )
            out.append(Finding("gap", (), int(t) + 1, int(t) + 2, degrees, "°", text))
    for t, near, which in ((0, slice(1, 1 + _reach(fps)), "first"), (last, slice(-1 - _reach(fps), -1), "last")):
        if len(share) < 4:
            break
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


def _glitches(motion: Motion, steps: _Steps, cuts: set[int]) -> list[Finding]:
    """Leaps of single joints or of the root, grouped by time; most come back after a few frames."""
    names, fps = motion.skeleton.joint_names, motion.fps
    leap = (steps.turn > TURN_LIMIT) & (steps.turn > OUT_OF_NOWHERE * steps.local)
    for t, j in np.argwhere(leap).tolist():
        leap[t, j] = _abrupt(motion.rotations[max(t - 1, 0) : t + 3, j], t > 0)
    root_leap = (steps.root > ROOT_SPEED_LIMIT) & (steps.root > OUT_OF_NOWHERE * np.maximum(steps.local_root, 0.1))
    for t in cuts:
        # a cut is told once; the inserted first frame is step 0, told as frame 0
        leap[max(t, 0)], root_leap[max(t, 0)] = False, False
    if motion.frame_count - 2 in cuts:
        leap[-1], root_leap[-1] = False, False
    out = []
    for first, last in _events(root_leap, fps):
        speed = float(steps.root[first : last + 1].max())
        text = f"The whole body leaps at {speed:.0f} m/s at {frames_text(first + 1, max(last + 1, first + 2))}."
        out.append(
            Finding("glitch", (names[0],), first + 1, max(last + 1, first + 2), speed, "m/s", text, moved=speed / fps)
        )
    jumpy = np.nonzero(leap.any(axis=0))[0].tolist()
    reach = _reaches(motion) if jumpy else np.zeros(0)
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


def _reaches(motion: Motion) -> Array:
    """From each joint to the farthest point that hangs on it, along the bones, metres."""
    skeleton = motion.skeleton
    out = np.zeros(skeleton.joint_count)
    for site in skeleton.end_sites:
        out[site.parent] = max(out[site.parent], float(np.linalg.norm(site.offset)))
    for j in range(skeleton.joint_count - 1, 0, -1):
        parent = skeleton.parents[j]
        out[parent] = max(out[parent], out[j] + float(np.linalg.norm(skeleton.offsets[j])))
    return out


def _frozen(motion: Motion, steps: _Steps) -> list[Finding]:
    """Stretches of exactly equal values, and frames that repeat the one before."""
    names, fps = motion.skeleton.joint_names, motion.fps
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
    runs = _runs(whole)
    repeated = sum(1 for a, b in runs if b - a == 1)
    if repeated > REPEATED_SHARE * len(whole):
        true_fps = fps * (1.0 - float(whole.mean()))
        text = (
            f"{repeated} of {motion.frame_count} frames repeat the one before: the movement was sampled at about "
            f"{true_fps:.0f} frames a second, not {fps:g}."
        )
        out.append(Finding("frozen", (), 0, motion.frame_count, float(repeated), "frames", text))
    for a, b in runs:
        if b - a >= max(2.0, FROZEN_BODY_SECONDS * fps):
            text = (
                f"The whole body is exactly still for {(b - a) / fps:.2f} s, {frames_text(a, b + 1)}: frames were repeated, "
                "or a program made them."
            )
            out.append(Finding("frozen", (), a, b + 1, (b - a) / fps, "s", text))
    # a joint that stands still half the time is animated by hand or at a stop, not frozen
    alive = ~whole
    share_moving = (~steps.still[alive]).mean(axis=0)
    labels = (*names, "the root's place")
    ever = share_moving > 0.0
    if np.mean(share_moving[ever] < 1.0 - RESTING_SHARE) > RESTING_JOINTS:
        # drawn key by key or made by a program: there it is the rule that joints rest exactly
        return out
    for j in np.nonzero(share_moving > 0.5)[0]:
        for a, b in _runs(steps.still[:, j] & alive):
            if b - a >= max(2.0, FROZEN_SECONDS * fps):
                text = (
                    f"{labels[j]} is frozen for {(b - a) / fps:.2f} s, {frames_text(a, b + 1)}, while the body moves."
                )
                out.append(Finding("frozen", (labels[j],), a, b + 1, (b - a) / fps, "s", text))
    return out


def _speeds(motion: Motion, positions: Array, known: list[Finding]) -> list[Finding]:
    """Speeds beyond the body's, where no leap explains them: a wrong frame rate or unit, or a slide."""
    fps, names = motion.fps, motion.skeleton.joint_names
    squared = np.einsum("fji,fji->fj", (difference := np.diff(positions, axis=0)), difference) * fps**2
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


def estimated_stature(motion: Motion) -> float | None:
    """Standing height in metres, from the length of the legs (Drillis & Contini 1966); None where there are none.

    Where the body is not understood: from the longest way over the skeleton, which is from a toe to a fingertip, about
    1.3 statures.
    """
    skeleton = motion.skeleton
    try:
        body = anatomy.resolve(motion)
    except SkeletonError:
        return _longest_way(motion) / 1.3 or None
    leg = 0.0
    for side in ("left", "right"):
        tibia, foot = getattr(body, f"{side}_tibia"), getattr(body, f"{side}_foot")
        if tibia is None:
            return None
        leg += float(np.linalg.norm(skeleton.offsets[tibia])) / 2.0
        if foot is not None:
            leg += float(np.linalg.norm(skeleton.offsets[foot])) / 2.0
        else:
            sites = [np.linalg.norm(s.offset) for s in skeleton.end_sites if s.parent == tibia]
            leg += float(max(sites, default=0.0)) / 2.0
    return leg / LEG_TO_STATURE or None


def _longest_way(motion: Motion) -> float:
    skeleton = motion.skeleton
    reach = _reaches(motion)
    # the longest way turns back at some joint: its two longest branches
    branches: list[list[float]] = [[0.0, 0.0] for _ in skeleton.joint_names]
    for j, parent in enumerate(skeleton.parents[1:], start=1):
        branches[parent].append(float(reach[j] + np.linalg.norm(skeleton.offsets[j])))
    for site in skeleton.end_sites:
        branches[site.parent].append(float(np.linalg.norm(site.offset)))
    return max(sum(sorted(b)[-2:]) for b in branches)


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
    for a, b in _runs(sunk):
        depth = float(usual - lowest[a:b].min())
        text = f"The body sinks {depth:.2f} m below the level it stands on, {frames_text(a, b)}."
        out.append(Finding("floor", (), a, b, depth, "m", text))
    return out


def _runs(mask: Mask) -> list[tuple[int, int]]:
    """[start, end) of each stretch of True."""
    edges = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    return list(zip(np.nonzero(edges == 1)[0].tolist(), np.nonzero(edges == -1)[0].tolist(), strict=True))


def frames_text(start: int, end: int) -> str:
    """ "frame 7" or "frames 7-9" for [start, end)."""
    return f"frame {start}" if end - start == 1 else f"frames {start}-{end - 1}"


def _sentences(findings: list[Finding]) -> tuple[str, ...]:
    """At most `MOST_SENTENCES`, worst kind first; events of one kind told together."""
    told: list[str] = []
    for kind in KINDS:
        members = [f for f in findings if f.kind == kind]
        if kind == "glitch":
            told += _tell_glitches(members)
        elif len(members) <= 2:
            told += [f.sentence for f in members]
        else:
            told += [members[0].sentence, f"{_KIND_WORDS[kind]} {len(members) - 1} times more: {_frames(members[1:])}."]
    if len(told) > MOST_SENTENCES:
        left = len(told) - MOST_SENTENCES + 1
        told = [*told[: MOST_SENTENCES - 1], f"And {left} more findings of less weight."]
    return tuple(told)


_KIND_WORDS: Final[dict[Kind, str]] = {
    "size": "A wrong size",
    "gap": "Such a jump",
    "glitch": "Such a leap",
    "frozen": "Such a stretch",
    "speed": "Such a speed",
    "jitter": "Such noise",
    "floor": "The like",
}


def _tell_glitches(findings: list[Finding]) -> list[str]:
    """One sentence for each of the three joints that throw the body farthest, one for the rest."""
    if len(findings) <= 2:
        return [f.sentence for f in findings]
    by_joint: dict[str, list[Finding]] = {}
    for finding in findings:
        by_joint.setdefault(finding.joint, []).append(finding)
    # findings come worst first, so joints come in the order of their worst; those that leap together are told together
    together: dict[tuple[int, ...], list[str]] = {}
    for joint, members in by_joint.items():
        together.setdefault(tuple(sorted(f.start for f in members)), []).append(joint)
    told = []
    for joints in list(together.values())[:3]:
        members = by_joint[joints[0]]
        worst = max(members, key=lambda f: f.figure)
        size = f"{worst.figure:.0f}{'' if worst.unit == '°' else ' '}{worst.unit}"
        times = f"at frame {members[0].start}" if len(members) == 1 else f"{len(members)} times: {_frames(members)}"
        verb = "leaps" if len(joints) == 1 else "leap"
        told.append(f"{', '.join(joints)} {verb} by up to {size} in one frame {times}.")
    rest = [f"{joint} ({len(by_joint[joint])})" for joints in list(together.values())[3:] for joint in joints]
    if rest:
        more = f" and {len(rest) - 6} more joints" if len(rest) > 6 else ""
        told.append(f"Leaps also of {', '.join(rest[:6])}{more}.")
    return told


def _frames(findings: list[Finding]) -> str:
    starts = sorted(f.start for f in findings)
    text = ", ".join(str(t) for t in starts[:6])
    return f"frame{'s' if len(starts) > 1 else ''} {text}{', …' if len(starts) > 6 else ''}"
