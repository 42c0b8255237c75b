"""What a performer has to perform with: recordings on one skeleton and at one frame rate, with their mirror images (§4.4)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body.motion import Motion
from kinesics.body.pose import PoseSequence
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError
from kinesics.synthesis.repertoire.strands import BACKWARD_STRANDS, MIRRORED_STRANDS, STRANDS, FrameStrand

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_T = TypeVar("_T")


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
    """As recorded and mirrored, both on `skeleton`, relative to the parent joints: shape (2, frames, joints, 4).

    In the mirror image bones point as the mirror shows them (`kinesics.body.mirroring.with_bones_of`)."""
    root_positions: Array
    """As recorded and mirrored, metres, shape (2, frames, 3): the image has x negated, z the same and y as its feet stand."""
    poses: PoseSequence
    """The 15 links as recorded (strand 0); ``poses.mirror()`` are those of strand 1, but that links of the trunk are turned on by a
    constant where bones of the skeleton lean to one side."""
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
