"""What a performer has to perform with: recordings on one skeleton and at one frame rate, with their mirror images (§4.4).

**Strands.** Every frame can be played in four ways: 0 as recorded, 1 mirrored, 2 backwards, 3 backwards and mirrored.
**Moments.** A frame in a strand is one whole number, ``frame + frame_count · strand``, frames counted over all recordings
put end to end. Time runs from moment to moment within a recording and a strand: in strands 2 and 3 from frame to the frame
before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body import anatomy as _anatomy
from kinesics.body import leaps
from kinesics.body.contacts import floor_height, foot_contacts, grounded
from kinesics.body.legs_apart import legs_apart
from kinesics.body.limits import DEPTH_TOLERANCE, Capsules
from kinesics.body.mirroring import mirror
from kinesics.body.motion import Motion
from kinesics.body.pose import PoseSequence, poses
from kinesics.body.retargeting import body_of, retarget
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError, SkeletonError, some_of

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_T = TypeVar("_T")

STRANDS: Final = ("as recorded", "mirrored", "backwards", "backwards and mirrored")
"""What each strand plays."""

MIRRORED_STRANDS: Final = (False, True, False, True)
"""Whether a strand plays the mirror image."""

BACKWARD_STRANDS: Final = (False, False, True, True)
"""Whether time runs from later frames to earlier ones in a strand."""

LEAST_FPS: Final = 8.0
"""Frames a second: one recording goes over into another within a quarter of a second, which has to hold two frames."""

MOST_FPS: Final = 1000.0
"""Frames a second: no body has anything to say between more."""

LEAST_SECONDS: Final = 0.5
"""Of the longest recording: in less, nothing can be left and come back to."""

DEEPER: Final = 0.02
"""Metres by which limbs pass deeper into each other on another body than on their own, before it is said."""
THROWN: Final = 0.1
"""Metres that something is thrown by from one frame to the next, from which a leap is a fault that is not performed where there is
a choice: a hand's length; toes and fingers that flicker are no reason to leave a step out."""
LOOKS: Final = 12.0
"""Moments a second at which that is looked for."""
LIFTED: Final = 0.05
"""Metres between the root joint and the pelvis from which it is said that the result has the root in the pelvis."""

ROOT_PUT: Final = "the root joint,"
"""How it begins that this is told."""
_WHY_LEAST: Final = (
    "one recording passes into another within a quarter of a second, which has to hold two frames or more"
)


class FrameStrand(NamedTuple):
    """A moment taken apart."""

    frame: Indices
    """Over all recordings end to end."""
    strand: Indices
    """0 as recorded, 1 mirrored, 2 backwards, 3 backwards and mirrored."""


@dataclass(frozen=True, eq=False)
class Repertoire:
    """All recordings on one skeleton and at one frame rate, end to end, with their mirror images.

    Made by `repertoire`. The root joint lies in the pelvis, the ground at y = 0. Arrays are read-only.
    """

    skeleton: Skeleton
    """Of the output; it carries its anatomy."""
    fps: float
    names: tuple[str, ...]
    """Of the recordings."""
    starts: Indices
    """First frame of each recording and, last, the number of all frames: shape (recordings + 1,)."""
    rotations: Array
    """As recorded and mirrored, both on `skeleton`, relative to the parent joints: shape (2, frames, joints, 4)."""
    root_positions: Array
    """As recorded and mirrored, metres, shape (2, frames, 3): the image has x negated, z the same and y as its feet stand."""
    poses: PoseSequence
    """The 15 links as recorded (strand 0); ``poses.mirror()`` are those of strand 1."""
    contacts: NDArray[np.bool_]
    """Whether the left and the right foot stand on the ground: shape (2, frames, 2)."""
    source_frames: Array
    """Place of each frame in its recording, counted in that recording's own frames: shape (frames,)."""
    source_fps: tuple[float, ...]
    """Frame rates of the recordings as they came."""
    assumptions: tuple[str, ...]
    """What was chosen or assumed, in words."""
    mirrored: bool
    """Whether mirrored strands may be used."""
    backwards: bool
    """Whether backward strands may be used."""
    faults: NDArray[np.bool_]
    """Whether the body leaps in a frame as no movement does, seen in the recording as it came: shape (frames,)."""
    warnings: tuple[str, ...] = ()
    """What went wrong when they were brought onto the skeleton."""
    turned: Array | None = None
    """By how much farther to the left than recorded the body faces, where its feet were planted and it turned with them: radians,
    shape (2, frames)."""

    @property
    def frame_count(self) -> int:
        """Frames of all recordings together."""
        return int(self.starts[-1])

    @property
    def recording_count(self) -> int:
        """How many recordings."""
        return len(self.names)

    @cached_property
    def strands(self) -> tuple[int, ...]:
        """The strands that may be used."""
        return tuple(
            s
            for s in range(4)
            if (self.mirrored or not MIRRORED_STRANDS[s]) and (self.backwards or not BACKWARD_STRANDS[s])
        )

    @property
    def moment_count(self) -> int:
        """Moments are numbered below this; those of strands that may not be used included."""
        return 4 * self.frame_count

    def moments(self, frames: ArrayLike, strand: int = 0) -> Indices:
        """The moments of frames in one strand, any shape."""
        return np.asarray(frames, dtype=np.intp) + self.frame_count * strand

    def split(self, moments: ArrayLike) -> FrameStrand:
        """Frame and strand of each moment, any shape."""
        values = np.asarray(moments, dtype=np.intp)
        return FrameStrand(values % self.frame_count, values // self.frame_count)

    def frame_of(self, moments: ArrayLike) -> Indices:
        """Frame of each moment, over all recordings end to end, any shape."""
        return self.split(moments).frame

    def strand_of(self, moments: ArrayLike) -> Indices:
        """Strand of each moment, any shape."""
        return self.split(moments).strand

    def recording_of(self, frames: ArrayLike) -> Indices:
        """Number of the recording that each frame belongs to, any shape."""
        return np.searchsorted(self.starts, np.asarray(frames), side="right") - 1

    def is_mirrored(self, moments: ArrayLike) -> NDArray[np.bool_]:
        """Whether each moment plays the mirror image, any shape."""
        return np.asarray(MIRRORED_STRANDS)[self.split(moments).strand]

    def is_backward(self, moments: ArrayLike) -> NDArray[np.bool_]:
        """Whether time runs backwards at each moment, any shape."""
        return np.asarray(BACKWARD_STRANDS)[self.split(moments).strand]

    def advance(self, moments: ArrayLike, steps: ArrayLike = 1) -> Indices:
        """The moments ``steps`` frames later in playing (before, if negative); −1 where the recording does not reach."""
        values, steps = np.broadcast_arrays(np.asarray(moments, dtype=np.intp), np.asarray(steps, dtype=np.intp))
        frame, strand = self.split(values)
        reached = frame + np.where(np.asarray(BACKWARD_STRANDS)[strand], -steps, steps)
        recording = self.recording_of(frame)
        inside = (reached >= self.starts[recording]) & (reached < self.starts[recording + 1])
        return np.where(inside, reached + self.frame_count * strand, -1)

    def remaining(self, moments: ArrayLike) -> Indices:
        """How many frames can be played from each moment on to the end of its recording, itself not counted, any shape."""
        frame, strand = self.split(moments)
        recording = self.recording_of(frame)
        backward = np.asarray(BACKWARD_STRANDS)[strand]
        return np.where(backward, frame - self.starts[recording], self.starts[recording + 1] - 1 - frame)

    def rotations_of(self, moments: ArrayLike) -> Array:
        """Joint rotations at moments (n,): shape (n, joints, 4)."""
        frame, strand = self.split(moments)
        return self.rotations[strand % 2, frame]

    def roots_of(self, moments: ArrayLike) -> Array:
        """Positions of the root in the recording's own world (mirrored: its reflection), metres: shape (n, 3)."""
        frame, strand = self.split(moments)
        return self.root_positions[strand % 2, frame]

    def quaternions_of(self, moments: ArrayLike) -> Array:
        """The 15 links at moments (n,), mirrored where the strand is: shape (n, 15, 4)."""
        frame, strand = self.split(moments)
        return self._link_rotations[strand % 2, frame]

    def yaw_of(self, moments: ArrayLike) -> Array:
        """Heading of the pelvis about +y, radians, any shape. Played backwards the body faces as in the frame itself."""
        frame, strand = self.split(moments)
        return np.where(strand % 2 == 1, -1.0, 1.0) * self.poses.yaw[frame] + self.turned_at(moments)

    def turned_at(self, moments: ArrayLike) -> Array:
        """By how much farther to the left than recorded the body faces, radians, any shape."""
        frame, strand = self.split(moments)
        return np.zeros(frame.shape) if self.turned is None else self.turned[strand % 2, frame]

    def kept(self, make: Callable[[Repertoire], _T]) -> _T:
        """What ``make`` gives of this repertoire: made once, and kept as long as the repertoire is, and no longer."""
        if make not in self._kept:
            self._kept[make] = make(self)
        found: _T = self._kept[make]
        return found

    def keep(self, make: Callable[[Repertoire], _T], known: _T) -> None:
        """Have `kept` give what is known already, instead of making it."""
        self._kept[make] = known

    @cached_property
    def _kept(self) -> dict[Callable[[Repertoire], Any], Any]:
        return {}

    def contacts_of(self, moments: ArrayLike) -> NDArray[np.bool_]:
        """Whether the left and the right foot stand on the ground at moments (n,): shape (n, 2)."""
        frame, strand = self.split(moments)
        return self.contacts[strand % 2, frame]

    def motion(self, recording: int, strand: int = 0) -> Motion:
        """One recording, in one strand, as a motion on the output's skeleton.

        Raises
        ------
        InputError
            If there is no such recording or strand.
        """
        if not 0 <= recording < self.recording_count or not 0 <= strand < 4:
            raise InputError(
                f"Expected a recording below {self.recording_count} and a strand below 4, got {recording} and {strand}."
            )
        frames = np.arange(self.starts[recording], self.starts[recording + 1])
        moments = self.moments(frames[::-1] if BACKWARD_STRANDS[strand] else frames, strand)
        name = self.names[recording] + (f", {STRANDS[strand]}" if strand else "")
        return Motion(self.skeleton, self.rotations_of(moments), self.roots_of(moments), self.fps, name=name)

    @cached_property
    def _link_rotations(self) -> Array:
        """The links as recorded and mirrored, shape (2, frames, 15, 4)."""
        return np.stack([self.poses.quaternions, self.poses.mirror().quaternions])


def repertoire(
    motions: Motion | Sequence[Motion],
    *,
    skeleton: Skeleton | Motion | None = None,
    fps: float | None = None,
    mirrored: bool = True,
    backwards: bool = False,
) -> Repertoire:
    """Bring recordings onto one skeleton, one frame rate and one ground, and add their mirror images.

    Parameters
    ----------
    motions : of any humanoid skeletons and frame rates; one alone will do.
    skeleton : of the output, or a recording on it, which tells more of a rig at rest in no human pose; that of the first
        recording if not given.
    fps : frames a second of the output; those of the first recording if not given.
    mirrored : whether mirror images may be performed too.
    backwards : whether recordings may be played backwards too (reversible paths, §3.5).

    Raises
    ------
    InputError
        If there is no motion, a motion has a single frame, all are too short, a frame rate is too low to pass from one
        recording to another, or that of the output is above `MOST_FPS`.
    SkeletonError
        If a skeleton cannot be understood as a human body or has no feet; the message says which recording.

    References
    ----------
    [Schultz2012] §4.4.
    """
    motions = [motions] if isinstance(motions, Motion) else list(motions)
    if not motions:
        raise InputError("Nothing can be performed without recordings: `motions` is empty. Give one or more.")
    names = _distinct([m.name or f"recording {k + 1}" for k, m in enumerate(motions)])
    for name, motion in zip(names, motions, strict=True):
        if motion.frame_count < 2:
            raise InputError(f"{name} is a single pose: nothing moves in it. Give recordings of two frames or more.")
    rate = _rate(fps, motions, names)
    longest = max(m.duration for m in motions)
    if longest < LEAST_SECONDS:
        raise InputError(
            f"Too short to perform from: {some_of(names)} {'lasts' if len(names) == 1 else 'last'} {longest:.2g} s"
            f"{'' if len(names) == 1 else ' at most'}, {max(m.frame_count for m in motions)} frames. Give recordings of some "
            f"seconds ({LEAST_SECONDS:g} s at the very least), in which the movement recurs."
        )
    understood = [_understood(m, name) for m, name in zip(motions, names, strict=True)]
    said = [f"performed at {rate:g} frames a second" + (f", the rate of {names[0]}" if fps is None else "")]
    if skeleton is not None and not isinstance(skeleton, Skeleton | Motion):
        raise InputError(f"Expected `skeleton` to be a skeleton, or a motion of one, got {type(skeleton).__name__}.")
    if skeleton is None:
        said.append(f"performed on the skeleton of {names[0]}")
        skeleton = understood[0].skeleton
    elif isinstance(skeleton, Motion):
        whose = skeleton.name or "the recording given for it"
        said.append(f"performed on the skeleton of {whose}")
        skeleton = _understood(skeleton, f"The skeleton to perform on, of {whose}").skeleton
    else:
        said.append(
            f"performed on the skeleton {skeleton.name!r}" if skeleton.name else "performed on the skeleton given"
        )
    body = _output_body(skeleton, understood)
    said += _root_put(skeleton, body)
    rotations: list[tuple[Array, Array]] = []
    roots: list[tuple[Array, Array]] = []
    contacts: list[NDArray[np.bool_]] = []
    sources: list[Array] = []
    faults: list[NDArray[np.bool_]] = []
    doubts: list[str] = []
    for name, motion in zip(names, understood, strict=True):
        if motion.fps != rate:
            said.append(f"{name}: resampled from {motion.fps:g} to {rate:g} frames a second")
        try:
            out, remarks = _brought(motion.resample(rate), body)
            doubts += _through_each_other(name, motion, out)
            level = floor_height(out)
            out = grounded(out)
            feet = foot_contacts(out)
            image = grounded(_brought(mirror(out), body)[0])
        except SkeletonError as error:
            raise SkeletonError(f"{name}: {error}", found=error.found, missing=error.missing) from error
        said += [f"{name}: {remark}" for remark in (*remarks, f"its ground, found at {level:.3f} m, put to 0")]
        rotations.append((out.rotations, image.rotations))
        # the pelvis of the image is a little higher or lower where left and right legs are of unlike length
        place = out.root_positions * [-1.0, 1.0, 1.0]
        place[:, 1] = image.root_positions[:, 1]
        roots.append((out.root_positions, place))
        contacts.append(feet)
        faults.append(_faults(motion, out.frame_count, rate))
        sources.append(np.minimum(np.arange(out.frame_count) * (motion.fps / rate), float(motion.frame_count - 1)))
    together = np.stack([np.concatenate([pair[k] for pair in rotations]) for k in range(2)])
    places = np.stack([np.concatenate([pair[k] for pair in roots]) for k in range(2)])
    stands = np.concatenate(contacts)
    whole = poses(Motion(body, together[0], places[0], rate))
    arrays = [
        np.cumsum([0, *(len(feet) for feet in contacts)]).astype(np.intp),
        together,
        places,
        np.stack([stands, stands[:, ::-1]]),
        np.concatenate(sources),
        np.concatenate(faults),
    ]
    for array in arrays:
        array.setflags(write=False)
    return Repertoire(
        skeleton=body,
        fps=rate,
        names=names,
        starts=arrays[0],
        rotations=arrays[1],
        root_positions=arrays[2],
        poses=whole,
        contacts=arrays[3],
        source_frames=arrays[4],
        source_fps=tuple(m.fps for m in motions),
        assumptions=tuple(said),
        mirrored=mirrored,
        backwards=backwards,
        faults=arrays[5],
        warnings=tuple(doubts),
    )


def _faults(motion: Motion, frames: int, rate: float) -> NDArray[np.bool_]:
    """Frames at another rate in which a recording leaps, where it does so farther than `THROWN`."""
    out = np.zeros(frames, dtype=np.bool_)
    times = rate / motion.fps
    for first, last in leaps.thrown(motion, THROWN):
        out[math.floor(first * times) : math.ceil(last * times) + 1] = True
    return out


def _through_each_other(name: str, motion: Motion, out: Motion) -> list[str]:
    """That limbs of a body that was given a movement pass through each other, deeper than those of its own did."""
    if _same_bones(motion.skeleton, out.skeleton):
        return []
    # pairs that interpenetrate in the T-pose of the one body may not in that of the other: of its own all are asked for
    own, here = _deepest(motion, np.inf), _deepest(out, DEPTH_TOLERANCE)
    known = {pair: depth for pair, depth in here.items() if depth > max(DEPTH_TOLERANCE, own[pair] + DEEPER)}
    if not known:
        return []
    pair = max(known, key=lambda p: known[p])
    before = max(own[pair], 0.0)
    told = f"{100.0 * before:.0f} cm" if before >= 0.005 else "not at all"
    return [
        f"{name}: on this body {_said(pair)} pass up to {100.0 * known[pair]:.0f} cm into each other, {told} on its own; "
        "perform on a body more like it in build"
    ]


def _same_bones(a: Skeleton, b: Skeleton) -> bool:
    return a.same_tree(b) and np.array_equal(a.offsets[1:], b.offsets[1:])


def _deepest(motion: Motion, tolerance: float) -> dict[tuple[str, str], float]:
    """By how many metres each two limbs pass into each other at most, −∞ if never; a few frames a second are looked at."""
    some = motion[:: max(1, round(motion.fps / LOOKS))]
    capsules = Capsules.of(some, tolerance=tolerance)
    depth = capsules.depths(some.positions(), some.global_rotations()).max(axis=0).tolist()
    return {(capsules.names[a], capsules.names[b]): d for (a, b), d in zip(capsules.pairs, depth, strict=True)}


def _said(pair: tuple[str, str]) -> str:
    """As in "the thighs" or "left thigh and right shank"."""
    words = {"femur": "thigh", "tibia": "shank", "humerus": "upper arm", "radius": "forearm"}
    first, second = (" ".join(words.get(word, word) for word in limb.split()) for limb in pair)
    if first.partition(" ")[2] == second.partition(" ")[2]:
        return f"the {first.partition(' ')[2]}s"
    return f"{first} and {second}"


def check_rate(fps: float) -> float:
    """Frames a second that can be performed at. Raises InputError where ``fps`` is none such."""
    rate = float(fps) if isinstance(fps, int | float | np.number) and not isinstance(fps, bool) else math.nan
    if not (math.isfinite(rate) and rate > 0.0):
        raise InputError(f"Expected a frame rate above 0, got `fps` = {fps!r}.")
    if rate < LEAST_FPS:
        raise InputError(
            f"Expected {LEAST_FPS:g} frames a second or more to perform at, got `fps` = {rate:g}: {_WHY_LEAST}."
        )
    if rate > MOST_FPS:
        raise InputError(f"Expected at most {MOST_FPS:g} frames a second to perform at, got `fps` = {rate:g}.")
    return rate


def _rate(fps: float | None, motions: Sequence[Motion], names: Sequence[str]) -> float:
    """Frames a second of the output."""
    rate = motions[0].fps if fps is None else check_rate(fps)
    if rate > MOST_FPS:
        raise InputError(
            f"{names[0]} has {rate:g} frames a second, more than the {MOST_FPS:g} that are performed at most. Give a lower "
            "rate (`fps`, --fps), or, if the file is wrong about its own, read it with the right one (`kinesics.read(…, fps=…)`)."
        )
    for name, motion in zip(names, motions, strict=True):
        if motion.fps < LEAST_FPS:
            raise InputError(
                f"{name} has {motion.fps:g} frames a second, fewer than the {LEAST_FPS:g} it takes to perform: {_WHY_LEAST}. If "
                "the file is wrong about its rate, read it with the right one (`kinesics.read(…, fps=…)`)."
            )
    return rate


def _root_put(before: Skeleton, after: Skeleton) -> list[str]:
    """That the root joint lies in the pelvis, where in the recordings it does not: a stand on the floor, for one."""
    assert after.anatomy is not None
    joint, away = after.anatomy.pelvis, np.zeros(3)
    while joint > 0:
        away = away + before.offsets[joint]
        joint = before.parents[joint]
    if np.linalg.norm(away) < LIFTED:
        return []
    root, pelvis = after.joint_names[0], after.joint_names[after.anatomy.pelvis]
    return [
        f"{ROOT_PUT} {root}, is in the pelvis, where {pelvis} is; recordings on this skeleton have it elsewhere, as a stand on the "
        "floor, for one"
    ]


def _understood(motion: Motion, name: str) -> Motion:
    try:
        return _anatomy.understood(motion)
    except SkeletonError as error:
        raise SkeletonError(f"{name}: {error}", found=error.found, missing=error.missing) from error


def _output_body(skeleton: Skeleton, motions: Sequence[Motion]) -> Skeleton:
    """The skeleton to perform on, with its anatomy, and with the joints above the pelvis (a rig's stand) drawn into it."""
    if skeleton.anatomy is None:
        # a recording on the same joints tells more than the rest pose
        like = next((m.skeleton for m in motions if m.skeleton.same_tree(skeleton)), None)
        try:
            skeleton = skeleton.replace(anatomy=body_of(skeleton if like is None else like))
        except SkeletonError as error:
            raise SkeletonError(
                f"The skeleton to perform on: {error}", found=error.found, missing=error.missing
            ) from error
    assert skeleton.anatomy is not None
    offsets = skeleton.offsets.copy()
    joint = skeleton.anatomy.pelvis
    while joint > 0:
        offsets[joint] = 0.0
        joint = skeleton.parents[joint]
    return skeleton if np.array_equal(offsets, skeleton.offsets) else skeleton.replace(offsets=offsets)


def _brought(motion: Motion, skeleton: Skeleton) -> tuple[Motion, tuple[str, ...]]:
    """The motion on the skeleton, with nothing but rotations and a root in the pelvis; what was assumed for it."""
    assert skeleton.anatomy is not None
    out = retarget(motion, skeleton)
    if out.joint_translations is not None:
        # the root joint lies in the pelvis
        out = out.replace(root_positions=out.positions()[:, skeleton.anatomy.pelvis], joint_translations=None)
    said = out.assumptions[len(motion.assumptions) :]
    apart = legs_apart(out.replace(skeleton=skeleton), motion)
    if apart.angle > 0.0:
        said += (
            f"thighs turned outwards by {np.rad2deg(apart.angle):.1f}°, for the hips are narrower than those recorded: knees and "
            "feet are as far apart as they were",
        )
    return apart.motion, said


def _distinct(names: Sequence[str]) -> tuple[str, ...]:
    """Names told apart: the second "walk" is "walk (2)"."""
    out: list[str] = []
    for name in names:
        count = 1
        candidate = name
        while candidate in out:
            count += 1
            candidate = f"{name} ({count})"
        out.append(candidate)
    return tuple(out)
