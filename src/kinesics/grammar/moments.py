"""What the grammar reads: distances D and D* between the moments of a recording, at a rate fit for reading.

A moment is a frame of the recording taken at the analysis rate, at most 30 a second, counted from the end that the recording is
read from (`kinesics.grammar.direction`): played backwards it has the same ones. Whether D comes from poses, silhouettes or
gestures makes no difference here; and no matrix of all moments is kept: `Moments.tile` and `Moments.by_lag` give the part that is
wanted.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body.pose import PoseSequence
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.similarity import (
    Prepared,
    Weights,
    check_weights,
    chord,
    paired_distance,
    symmetry_residual,
)

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

RATE: Final = 30.0
"""Moments a second at most: fast movement of the whole body stays well below 15 Hz."""
LARGEST_BLOCK: Final = 4000
"""Moments of which all pairs may be asked for at once (two minutes)."""
_ROWS: Final = 1024
_FEWEST_ROWS: Final = 128

_EVEN: Final = 1e-9
"""Relative difference of the halves up to which rounding, not the movement, would decide."""
_NEIGHBOURS: Final = (-2, -1, 1, 2)
_WEIGHTS: Final = (-1 / 6, 4 / 6, 4 / 6, -1 / 6)
"""A cubic through the four neighbours passes the middle one: what is left of it is noise."""
_LEFT_OVER: Final = 1.0 + 34.0 / 36.0
"""Variance of middle minus cubic, in variances of one frame's noise."""
_NOISE_QUANTILE: Final = 0.2
_QUANTILE_SHARE: Final = 0.82
"""The fifth of χ²₄₅/45 (15 joints of three angles): from the calmest fifth to the mean."""


@dataclass(frozen=True, eq=False)
class Moments:
    """Moments of one recording and the distances between them. Made by `from_poses` or `from_distances`."""

    fps: float
    """Moments a second, at most `RATE`."""
    source_fps: float
    source_frames: int
    """Frames of the recording, up to the end of these moments."""
    speed: Array
    """√(2D)/Δt, 1/s, shape (count,): entry i is the step from moment i − 1 to i, entry 0 repeats entry 1."""
    symmetry: Array
    """D*(a, a) of each moment, shape (count,)."""
    noise: float
    """D that the sensor's noise alone puts between two moments of the same pose; from what no smooth movement explains."""
    poses: PoseSequence | None = None
    """The poses at the moments, where D comes from poses."""
    weights: Array | None = None
    """Of the links."""
    dense: tuple[Floats, Floats] | None = dataclasses.field(default=None, repr=False)
    """D and D* of all moments, where they were given."""
    first: int = 0
    """Moments of the recording before these (`cut`)."""
    lead: float = 0.0
    """Source frames before the first moment of the recording."""
    from_end: bool = False
    """Whether the recording is to be read from its end (`kinesics.grammar.direction`)."""

    @property
    def count(self) -> int:
        """How many moments."""
        return len(self.speed)

    def __len__(self) -> int:
        """How many moments."""
        return len(self.speed)

    @property
    def seconds(self) -> float:
        """Duration, moments over rate."""
        return self.count / self.fps

    def frame_of(self, moment: float) -> int:
        """The source frame nearest to a moment; ``count`` (an exclusive end) gives the number of source frames."""
        if moment >= self.count:
            return self.source_frames
        if self.first + moment <= 0:
            return 0  # what begins with the first moment begins with the recording
        return int(min(max(round(self.exact_frame_of(moment)), 0), self.source_frames - 1))

    def exact_frame_of(self, moment: float) -> float:
        """The time of a moment, counted in source frames."""
        return self.lead + (self.first + moment) * self.source_fps / self.fps

    def moment_of(self, frame: float) -> int:
        """The moment nearest to a source frame; the number of source frames gives ``count``."""
        if frame >= self.source_frames:
            return self.count
        moment = round((frame - self.lead) * self.fps / self.source_fps) - self.first
        return int(min(max(moment, 0), self.count - 1))

    def cut(self, start: int, end: int) -> Moments:
        """The moments [start, end) by themselves, counted from 0; frames stay those of the recording."""
        if (start, end) == (0, self.count):
            return self
        dense = self.dense
        return dataclasses.replace(
            self,
            source_frames=self.frame_of(end),
            speed=self.speed[start:end],
            symmetry=self.symmetry[start:end],
            poses=None if self.poses is None else self.poses[start:end],
            dense=None if dense is None else (dense[0][start:end, start:end], dense[1][start:end, start:end]),
            first=self.first + start,
        )

    def tile(self, rows: slice, cols: slice) -> tuple[Floats, Floats]:
        """D and D* between two ranges of moments: ``d[i, j]`` is of moment ``rows.start + i`` and ``cols.start + j``.

        Two of shape (rows, cols); views of what is kept, where the distances were given: not to be written to.
        """
        if self.dense is not None:
            return self.dense[0][rows, cols], self.dense[1][rows, cols]
        first, second = rows.indices(self.count)[0], cols.indices(self.count)[0]
        d, mirrored = self._prepared.distances(rows, cols)
        # rounding leaves up to 4e-7 between a moment and itself
        same = np.arange(max(first, second), min(first + d.shape[0], second + d.shape[1]))
        d[same - first, same - second] = 0.0
        return d, mirrored

    @cached_property
    def _prepared(self) -> Prepared:
        assert self.poses is not None
        return Prepared(self.poses, self.weights)

    def thinned(self, index: NDArray[np.intp]) -> tuple[Floats, Floats]:
        """D and D* between the moments of an index, all pairs: two of shape (len(index), len(index)), D with 0 on its diagonal."""
        if self.dense is not None:
            return self.dense[0][np.ix_(index, index)], self.dense[1][np.ix_(index, index)]
        d, mirrored = self._prepared.distances(index, index)
        np.fill_diagonal(d, 0.0)
        return d, mirrored

    def between(self, rows: NDArray[np.intp], cols: NDArray[np.intp]) -> tuple[Floats, Floats]:
        """D and D* between two lists of moments, shape (rows, cols): ``d[i, j]`` is of moment ``rows[i]`` and ``cols[j]``."""
        if self.dense is not None:
            return self.dense[0][np.ix_(rows, cols)], self.dense[1][np.ix_(rows, cols)]
        return self._prepared.distances(rows, cols)

    def block(self, start: int = 0, end: int | None = None) -> tuple[Floats, Floats]:
        """D and D* of all pairs of moments in [start, end), two of shape (end − start, end − start).

        Raises
        ------
        InputError
            If there are more than `LARGEST_BLOCK` moments: use `tile` or `by_lag`.
        """
        start, end = self.stretch(start, end)
        if end - start > LARGEST_BLOCK and self.dense is None:
            raise InputError(
                f"Expected a stretch of at most {LARGEST_BLOCK} moments, got {end - start}: "
                "take it tile by tile (`tile`) or by lag (`by_lag`)."
            )
        return self.tile(slice(start, end), slice(start, end))

    def by_lag(self, most: int, start: int = 0, end: int | None = None) -> tuple[Floats, Floats]:
        """D and D* near the identity axis: ``d[k, i]`` is of moments ``start + i`` and ``start + i + k``, inf beyond the end.

        Two of shape (most + 1, end − start).
        """
        d, mirrored = self._by_lag(most, start, end, 2)
        return d, mirrored

    def d_by_lag(self, most: int, start: int = 0, end: int | None = None) -> Floats:
        """D alone by lag, shape (most + 1, end − start): half the memory of `by_lag`."""
        d: Floats = self._by_lag(most, start, end, 1)[0]
        return d

    def _by_lag(self, most: int, start: int, end: int | None, kinds: int) -> Floats:
        start, end = self.stretch(start, end)
        n = end - start
        most = min(most, n - 1)
        out = np.full((kinds, most + 1, n), np.inf, dtype=np.float32)
        height = min(_ROWS, max(_FEWEST_ROWS, 2 * most))  # a tall tile beside a narrow band is mostly thrown away
        for first in range(0, n, height):
            rows = np.arange(first, min(first + height, n))
            stop = min(int(rows[-1]) + most + 1, n)
            parts = self.tile(slice(start + first, start + len(rows) + first), slice(start + first, start + stop))
            for k in range(most + 1):
                fits = min(len(rows), stop - first - k)
                if fits > 0:
                    for which, part in enumerate(parts[:kinds]):
                        out[which, k, first : first + fits] = np.diagonal(part, k)[:fits]
        return out

    def stretch(self, start: int, end: int | None) -> tuple[int, int]:
        """A range of moments, checked.

        Raises
        ------
        InputError
            If it is empty or reaches beyond the recording.
        """
        last = self.count if end is None else end
        if not 0 <= start < last <= self.count:
            raise InputError(f"Expected a stretch within the {self.count} moments, got [{start}, {last}).")
        return start, last


def from_poses(poses: PoseSequence, rate: float = RATE, *, weights: Weights | None = None) -> Moments:
    """The moments of a sequence of poses.

    Parameters
    ----------
    rate : moments a second; the recording's own rate where that is lower.
    weights : of the 15 links in D (see `kinesics.similarity.distance`).

    Raises
    ------
    InputError
        If the rate is not above 0 or the weights cannot be used.
    """
    if not (np.isfinite(rate) and rate > 0.0):
        raise InputError(f"Expected `rate` above 0, got {rate}.")
    share = check_weights(weights)
    lagged = [
        paired_distance(poses.quaternions[:-k], poses.quaternions[k:], share) for k in range(1, min(5, len(poses)))
    ]
    from_end = bool(lagged) and _livelier_first(lagged[0])
    taken, lead = _resampled(poses, rate, from_end)
    q = taken.quaternions
    return Moments(
        fps=taken.fps,
        source_fps=poses.fps,
        source_frames=len(poses),
        speed=_speed(paired_distance(q[:-1], q[1:], share) if len(q) > 1 else np.empty(0), taken.fps),
        symmetry=symmetry_residual(q, share),
        # the noise is the sensor's: seen best at the sensor's own rate
        noise=_noise(lagged if len(lagged) == 4 else None),
        poses=taken,
        weights=share,
        lead=lead,
        from_end=from_end,
    )


def from_distances(d: ArrayLike, d_mirror: ArrayLike, fps: float, rate: float = RATE) -> Moments:
    """The moments of anything of which all distances are known: silhouettes, gestures.

    Parameters
    ----------
    d, d_mirror : D and D* between all frames, shape (frames, frames).
    fps : frames a second.
    rate : moments a second at most; where the frames are more, the nearest ones are taken.

    Raises
    ------
    InputError
        If the shapes disagree, values are not finite or negative, or a rate is not above 0.
    """
    matrices = [np.asarray(m, dtype=np.float32) for m in (d, d_mirror)]
    for name, m in zip(("d", "d_mirror"), matrices, strict=True):
        if m.ndim != 2 or m.shape[0] != m.shape[1] or len(m) == 0 or m.shape != matrices[0].shape:
            raise InputError(f"Expected `d` and `d_mirror` of one shape (frames, frames), got {name} of {m.shape}.")
        if not np.isfinite(m).all() or m.min() < -1e-5:
            raise InputError(f"Expected distances that are finite and not negative; `{name}` has others.")
    if not (np.isfinite(fps) and fps > 0.0 and np.isfinite(rate) and rate > 0.0):
        raise InputError(f"Expected `fps` and `rate` above 0, got {fps} and {rate}.")
    frames = len(matrices[0])
    lagged = [np.diagonal(matrices[0], k).astype(np.float64) for k in range(1, min(5, frames))]
    from_end = bool(lagged) and _livelier_first(lagged[0])
    taken, lead = min(fps, rate), 0.0
    if taken < fps:
        times = _times(frames, fps, taken, from_end)
        lead = float(times[0])
        index = np.minimum(np.round(times).astype(np.intp), frames - 1)
        matrices = [m[np.ix_(index, index)] for m in matrices]
    matrices = [np.maximum(m, np.float32(0.0)) for m in matrices]
    return Moments(
        fps=taken,
        source_fps=fps,
        source_frames=frames,
        speed=_speed(np.diagonal(matrices[0], 1).astype(np.float64), taken),
        symmetry=np.diagonal(matrices[1]).astype(np.float64),
        noise=_noise(lagged if len(lagged) == 4 else None),
        dense=(matrices[0], matrices[1]),
        lead=lead,
        from_end=from_end,
    )


def _livelier_first(steps: Array) -> bool:
    """Whether there is more movement towards the beginning than towards the end, by D from frame to frame."""
    way = chord(steps)
    lever = np.linspace(-1.0, 1.0, len(way))
    return bool(way @ lever < -_EVEN * way.sum())


def _times(frames: int, fps: float, rate: float, from_end: bool) -> Array:
    """When the moments are, in frames: from the end that the recording is read from, so that turned round it has the same."""
    ratio = fps / rate
    steps = int(np.floor((frames - 1) / ratio + 1e-9))
    first = frames - 1 - steps * ratio if from_end else 0.0
    return np.asarray(first + ratio * np.arange(steps + 1), dtype=np.float64)


def _resampled(poses: PoseSequence, rate: float, from_end: bool) -> tuple[PoseSequence, float]:
    """At ``rate`` or the poses' own, if that is lower, and when the first moment is; frames that are moments stay as they are."""
    if poses.fps <= rate * (1.0 + 1e-6) or len(poses) == 1:
        return poses, 0.0
    last = len(poses) - 1
    times = _times(len(poses), poses.fps, rate, from_end)
    left = np.minimum(np.floor(times + 1e-9).astype(np.intp), last)
    right = np.minimum(left + 1, last)
    t = np.clip(times - left, 0.0, 1.0)
    t[t < 1e-9] = 0.0
    q = poses.quaternions[left]
    between = t > 0.0
    if between.any():
        q[between] = quaternion.slerp(q[between], poses.quaternions[right[between]], t[between, None])
    yaw = np.unwrap(poses.yaw)
    undefined = poses.yaw_undefined
    assert undefined is not None
    ground = poses.ground
    taken = dataclasses.replace(
        poses,
        quaternions=q,
        yaw=yaw[left] * (1.0 - t) + yaw[right] * t,
        ground=ground[left] * (1.0 - t)[:, None] + ground[right] * t[:, None],
        yaw_undefined=undefined[left] | (undefined[right] & between),
        fps=rate,
    )
    return taken, float(times[0])


def _speed(steps: Array, fps: float) -> Array:
    """From D between neighbours to √(2D)/Δt of every moment."""
    if len(steps) == 0:
        return np.zeros(1)
    s = chord(steps) * fps
    return np.concatenate([s[:1], s])


def _noise(lagged: list[Array] | None) -> float:
    """D between two moments of one pose, from D at lags 1 to 4.

    2D is a squared distance, so the distance of the middle from the cubic through its neighbours needs distances only:
    |x − Σ wᵢ aᵢ|² = Σ wᵢ |x − aᵢ|² − Σ_{i<j} wᵢ wⱼ |aᵢ − aⱼ|² where Σ wᵢ = 1. Noise is there always, movement bends most
    when it is fast: the calmest fifth of the moments tells.
    """
    if lagged is None:
        return 0.0
    count = len(lagged[3])
    squared = np.zeros(count)

    def between(i: int, j: int) -> Array:
        first, second = min(i, j) + 2, max(i, j) + 2
        return lagged[second - first - 1][first : first + count]

    for place, (i, w) in enumerate(zip(_NEIGHBOURS, _WEIGHTS, strict=True)):
        squared += w * between(0, i)
        for j, v in zip(_NEIGHBOURS[place + 1 :], _WEIGHTS[place + 1 :], strict=True):
            squared -= w * v * between(i, j)
    calm = float(np.quantile(np.maximum(squared, 0.0), _NOISE_QUANTILE))
    return calm / _QUANTILE_SHARE * 2.0 / _LEFT_OVER
