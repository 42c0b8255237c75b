"""A motion: a skeleton and, for every frame, the rotation of each joint (§2.15).

Rotations are kept as quaternions relative to the parent joint, whatever angles the file used. World: right-handed, y up,
metres, seconds. Frames count from 0; ranges are [start, end).
"""

from __future__ import annotations

import dataclasses
import operator
from dataclasses import dataclass, field
from typing import Any, Final, SupportsIndex, overload

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.body.skeleton import LONGEST, Skeleton
from kinesics.errors import InputError
from kinesics.geometry import quaternion

Array = NDArray[np.float64]

_QUICK: Final = np.deg2rad(60.0)
"""Radians from one frame to the next: components of quaternions farther apart bulge between them."""


@dataclass(frozen=True)
class Source:
    """Where a motion came from and how its file spoke, so that it can be written the same way."""

    format: str = ""
    """Name in the registry of formats: "bvh", "asf_amc"; "" for a motion made by the program."""
    file_name: str = ""
    """Without folders."""
    sha256: str = ""
    metres_per_unit: float = 1.0
    """Length of the file's unit of length."""
    up_axis: str = "y"
    """The file's vertical axis: "x", "y", "z", or with a minus."""
    details: dict[str, str] = field(default_factory=dict)
    """What only this format knows and wants back on writing."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Skeleton and joint rotations over time. Its arrays are read-only: copy one to change it, then `replace`.

    Raises
    ------
    InputError
        If shapes disagree, a value is not finite or beyond any length, there is no frame, or the frame rate is not
        positive.
    """

    skeleton: Skeleton
    rotations: Array
    """Of each joint relative to its parent, unit quaternions (w, x, y, z), shape (frames, joints, 4)."""
    root_positions: Array
    """Of the root in the world, metres, shape (frames, 3)."""
    fps: float
    """Frames a second."""
    joint_translations: Array | None = None
    """From the parent's origin to the joint's, in the parent's frame, metres, shape (frames, joints, 3), where the file
    moves joints other than the root; it then takes the place of the skeleton's offsets. Entry 0 is `root_positions`."""
    name: str = ""
    source: Source = field(default_factory=Source)
    assumptions: tuple[str, ...] = ()
    """What was not in the file and was assumed: unit, up axis, frame rate, left and right."""
    warnings: tuple[str, ...] = ()
    """What was wrong with the file. What looks wrong with the movement is told by `kinesics.inspect`."""

    def __post_init__(self) -> None:
        """Check shapes and values once, so that nothing downstream has to."""
        rotations, roots = _frozen(self.rotations), _frozen(self.root_positions)
        joints = self.skeleton.joint_count
        if rotations.ndim != 3 or rotations.shape[1:] != (joints, 4):
            raise InputError(f"Expected `rotations` of shape (frames, {joints}, 4), got {rotations.shape}.")
        if len(rotations) == 0:
            raise InputError("A motion needs at least one frame.")
        if roots.shape != (len(rotations), 3):
            raise InputError(f"Expected `root_positions` of shape ({len(rotations)}, 3), got {roots.shape}.")
        if not (np.isfinite(self.fps) and self.fps > 0):
            raise InputError(f"Expected a frame rate above 0, got {self.fps}.")
        # a sum is finite exactly when all its terms are (overflow aside), and costs one pass
        for label, values in (("rotations", rotations), ("root_positions", roots)):
            if not np.isfinite(values.sum()) and not np.isfinite(values).all():
                frame = int(np.argmax(~np.isfinite(values.reshape(len(values), -1)).all(axis=1)))
                raise InputError(f"`{label}` is not finite in frame {frame}.")
        if np.abs(roots).max() > LONGEST:
            frame = int(np.argmax(np.abs(roots).max(axis=1)))
            raise InputError(
                f"The root lies {np.abs(roots[frame]).max():.3g} m away in frame {frame}, beyond any length."
            )
        norm = np.einsum("fji,fji->fj", rotations, rotations)
        if not np.all(np.abs(norm - 1.0) < 1e-6):
            rotations = _frozen(quaternion.normalize(rotations))
        object.__setattr__(self, "rotations", rotations)
        object.__setattr__(self, "root_positions", roots)
        object.__setattr__(self, "fps", float(self.fps))
        if self.joint_translations is not None:
            shifts = _frozen(self.joint_translations)
            if shifts.shape != (len(rotations), joints, 3):
                raise InputError(
                    f"Expected `joint_translations` of shape ({len(rotations)}, {joints}, 3), got {shifts.shape}."
                )
            if not np.isfinite(shifts).all():
                raise InputError("`joint_translations` is not finite.")
            if np.abs(shifts).max() > LONGEST:
                raise InputError(f"`joint_translations` reaches {np.abs(shifts).max():.3g} m, beyond any length.")
            object.__setattr__(self, "joint_translations", shifts)

    @property
    def frame_count(self) -> int:
        """How many frames."""
        return len(self.rotations)

    def __len__(self) -> int:
        """How many frames."""
        return len(self.rotations)

    @property
    def duration(self) -> float:
        """Seconds: frames divided by frame rate."""
        return self.frame_count / self.fps

    def positions(self) -> Array:
        """World positions of all joints, metres, shape (frames, joints, 3)."""
        return kinematics.positions(self.skeleton, self.rotations, self.root_positions, self.joint_translations)

    def global_rotations(self) -> Array:
        """World orientations of all joints, quaternions, shape (frames, joints, 4)."""
        return kinematics.global_rotations(self.skeleton, self.rotations)

    def replace(self, **changes: Any) -> Motion:
        """A copy with some fields changed."""
        return dataclasses.replace(self, **changes)

    @overload
    def __getitem__(self, item: slice) -> Motion: ...
    @overload
    def __getitem__(self, item: SupportsIndex) -> Motion: ...
    def __getitem__(self, item: slice | SupportsIndex) -> Motion:
        """Frames ``[start:end]`` as a motion of its own; a step divides the frame rate; one index gives one frame.

        Raises
        ------
        InputError
            If no frame is left, or the step is negative (`reverse` plays backwards).
        IndexError
            If there is no such frame.
        """
        if not isinstance(item, slice):
            wanted = operator.index(item)
            index = wanted + self.frame_count if wanted < 0 else wanted
            if not 0 <= index < self.frame_count:
                raise IndexError(f"Frame {wanted} of a motion of {self.frame_count} frames.")
            item = slice(index, index + 1)
        start, stop, step = item.indices(self.frame_count)
        if step < 0:
            raise InputError("Expected a positive step; `kinesics.reverse` plays a motion backwards.")
        if start >= stop:
            raise InputError(f"No frame is left of {self.frame_count} by [{item.start}:{item.stop}].")
        return self._frames(slice(start, stop, step), self.fps / step)

    def _frames(self, item: slice, fps: float) -> Motion:
        shifts = None if self.joint_translations is None else self.joint_translations[item]
        return self.replace(
            rotations=self.rotations[item],
            root_positions=self.root_positions[item],
            joint_translations=shifts,
            fps=fps,
        )

    def resample(self, fps: float) -> Motion:
        """The same movement at another frame rate, by cubic splines: nothing jerks from frame to frame that did not before.

        Of quaternions all components are interpolated and made a rotation again; a joint that turns by more than `_QUICK` from
        one frame to the next goes along great circles instead. New frame k lies at time k / fps; the last one is the last that
        the recording reaches. Nothing is smoothed, so a lower rate keeps frames that fall on the same times to the last bit.

        Raises
        ------
        InputError
            If ``fps`` is not positive, or so high that the motion would have more than a hundred million frames.
        """
        if not (np.isfinite(fps) and fps > 0):
            raise InputError(f"Expected a frame rate above 0, got {fps}.")
        if fps == self.fps or self.frame_count == 1:
            return self.replace(fps=fps)
        last = self.frame_count - 1
        if last / self.fps * fps > 1e8:
            raise InputError(
                f"{fps:g} frames a second would make {last / self.fps * fps:.3g} frames of {self.frame_count}."
            )
        # the tolerance keeps the last frame where the quotient falls short of a whole number by rounding
        times = np.arange(int(np.floor(last / self.fps * fps + 1e-9)) + 1) * (self.fps / fps)
        left = np.minimum(np.floor(times + 1e-9).astype(np.intp), last)
        right = np.minimum(left + 1, last)
        t = np.clip(times - left, 0.0, 1.0)
        t[t < 1e-9] = 0.0
        between = t > 0.0

        def spline(values: Array) -> Array:
            from scipy.interpolate import CubicSpline

            out = np.asarray(values[left], dtype=np.float64)
            out[between] = CubicSpline(np.arange(self.frame_count), values, axis=0)(times[between])
            return out

        rotations = self.rotations[left]
        if between.any():
            signed = quaternion.continuous(self.rotations)
            quick = (quaternion.angle(self.rotations[1:], self.rotations[:-1]) > _QUICK).any(axis=0)
            if not quick.all():
                smooth = spline(signed[:, ~quick])[between]
                rotations[np.ix_(between, ~quick)] = quaternion.normalize(smooth)
            rotations[np.ix_(between, quick)] = quaternion.slerp(
                self.rotations[np.ix_(left[between], quick)],
                self.rotations[np.ix_(right[between], quick)],
                t[between, None],
            )
        return self.replace(
            rotations=rotations,
            root_positions=spline(self.root_positions),
            joint_translations=None if self.joint_translations is None else spline(self.joint_translations),
            fps=fps,
        )


def _frozen(values: Array) -> Array:
    """Read-only and contiguous: a copy of what a caller could still change, shared where nobody can (slices)."""
    array = np.asarray(values, dtype=np.float64)
    if array.flags.writeable or not array.flags.c_contiguous:
        array = array.copy(order="C")
        array.setflags(write=False)
    return array


def reverse(motion: Motion) -> Motion:
    """The motion played backwards: the last frame first (§3.2.4)."""
    return motion._frames(slice(None, None, -1), motion.fps)
