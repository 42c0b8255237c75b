"""Recordings gathered to perform from: mended, on one skeleton, at one frame rate and on one ground, with their mirror images."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import leaps
from kinesics.body.contacts import floor_height, foot_contacts, grounded
from kinesics.body.mending import mended
from kinesics.body.mirroring import mirror, with_bones_of
from kinesics.body.motion import Motion
from kinesics.body.pose import poses
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError, SkeletonError, some_of
from kinesics.synthesis.repertoire.bodies import brought, output_body, root_put, understood
from kinesics.synthesis.repertoire.depths import through_each_other
from kinesics.synthesis.repertoire.rates import rate_of
from kinesics.synthesis.repertoire.stock import Repertoire

Array = NDArray[np.float64]

LEAST_SECONDS: Final = 0.5
"""Of the longest recording: in less, nothing can be left and come back to."""
THROWN: Final = 0.1
"""Metres that something is thrown by from one frame to the next, from which a leap is a fault that is not performed where there is
a choice: a hand's length; toes and fingers that flicker are no reason to leave a step out."""


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
    rate = rate_of(fps, motions, names)
    longest = max(m.duration for m in motions)
    if longest < LEAST_SECONDS:
        raise InputError(
            f"Too short to perform from: {some_of(names)} {'lasts' if len(names) == 1 else 'last'} {longest:.2g} s"
            f"{'' if len(names) == 1 else ' at most'}, {max(m.frame_count for m in motions)} frames. Give recordings of some "
            f"seconds ({LEAST_SECONDS:g} s at the very least), in which the movement recurs."
        )
    known = [understood(m, name) for m, name in zip(motions, names, strict=True)]
    said = [f"performed at {rate:g} frames a second" + (f", the rate of {names[0]}" if fps is None else "")]
    chosen, remark = _chosen(skeleton, known[0].skeleton, names[0])
    body = output_body(chosen, known)
    said += [remark, *root_put(chosen, body)]
    brought_here: list[_Brought] = []
    for name, motion in zip(names, known, strict=True):
        try:
            brought_here.append(_bring(name, motion, body, rate))
        except SkeletonError as error:
            raise SkeletonError(f"{name}: {error}", found=error.found, missing=error.missing) from error
        said += brought_here[-1].said
    together = np.concatenate([one.rotations for one in brought_here], axis=1)
    places = np.concatenate([one.roots for one in brought_here], axis=1)
    stands = np.concatenate([one.contacts for one in brought_here])
    arrays = [
        np.cumsum([0, *(len(one.contacts) for one in brought_here)]).astype(np.intp),
        together,
        places,
        np.stack([stands, stands[:, ::-1]]),
        np.concatenate([one.source_frames for one in brought_here]),
        np.concatenate([one.faults for one in brought_here]),
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
        poses=poses(Motion(body, together[0], places[0], rate)),
        contacts=arrays[3],
        source_frames=arrays[4],
        source_fps=tuple(m.fps for m in motions),
        assumptions=tuple(said),
        mirrored=mirrored,
        backwards=backwards,
        faults=arrays[5],
        warnings=tuple(line for one in brought_here for line in one.doubts),
    )


def _chosen(skeleton: Skeleton | Motion | None, first: Skeleton, whose: str) -> tuple[Skeleton, str]:
    """The skeleton that is asked for, that of the first recording if none is; and whose it is, in words."""
    if skeleton is None:
        return first, f"performed on the skeleton of {whose}"
    if isinstance(skeleton, Motion):
        whose = skeleton.name or "the recording given for it"
        known = understood(skeleton, f"The skeleton to perform on, of {whose}")
        return known.skeleton, f"performed on the skeleton of {whose}"
    if not isinstance(skeleton, Skeleton):
        raise InputError(f"Expected `skeleton` to be a skeleton, or a motion of one, got {type(skeleton).__name__}.")
    return (
        skeleton,
        f"performed on the skeleton {skeleton.name!r}" if skeleton.name else "performed on the skeleton given",
    )


class _Brought(NamedTuple):
    """One recording as it is performed from."""

    rotations: Array
    """As recorded and mirrored, shape (2, frames, joints, 4)."""
    roots: Array
    """The same, metres, shape (2, frames, 3)."""
    contacts: NDArray[np.bool_]
    """Shape (frames, 2)."""
    source_frames: Array
    faults: NDArray[np.bool_]
    said: tuple[str, ...]
    doubts: tuple[str, ...]


def _bring(name: str, recording: Motion, body: Skeleton, rate: float) -> _Brought:
    """A recording mended, at the rate, on the body and on the ground."""
    whole = mended(recording)
    motion = whole.motion
    said = [f"resampled from {motion.fps:g} to {rate:g} frames a second"] if motion.fps != rate else []
    out, remarks = brought(motion.resample(rate), body)
    doubts = through_each_other(name, motion, out)
    level = floor_height(out)
    out = grounded(out)
    seen = mirror(out)
    image = grounded(with_bones_of(brought(seen, body)[0], seen))
    # the pelvis of the image is a little higher or lower where left and right legs are of unlike length
    place = out.root_positions * [-1.0, 1.0, 1.0]
    place[:, 1] = image.root_positions[:, 1]
    said += [*([str(whole)] if whole.frames.any() else []), *remarks, f"its ground, found at {level:.3f} m, put to 0"]
    return _Brought(
        np.stack([out.rotations, image.rotations]),
        np.stack([out.root_positions, place]),
        foot_contacts(out),
        np.minimum(np.arange(out.frame_count) * (motion.fps / rate), float(motion.frame_count - 1)),
        _faults(motion, out.frame_count, rate),
        tuple(f"{name}: {line}" for line in said),
        tuple(doubts),
    )


def _faults(motion: Motion, frames: int, rate: float) -> NDArray[np.bool_]:
    """Frames at another rate in which a recording leaps, where it does so farther than `THROWN`."""
    out = np.zeros(frames, dtype=np.bool_)
    times = rate / motion.fps
    for first, last in leaps.thrown(motion, THROWN):
        out[math.floor(first * times) : math.ceil(last * times) + 1] = True
    return out


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
