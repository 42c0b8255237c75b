"""Paths performed live, frame by frame as they are chosen, knowing only the past ([Schultz2012] §4.4).

`kinesics.synthesis.rendering` does the same with the whole performance before it.
"""

from __future__ import annotations

import bisect
import cmath
import math
import operator
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.geometry import quaternion, single
from kinesics.geometry.single import Quaternion, Vector
from kinesics.synthesis import blending
from kinesics.synthesis.network import Network
from kinesics.synthesis.repertoire import BACKWARD_STRANDS
from kinesics.synthesis.stage import SPARED, Stage
from kinesics.synthesis.treading import Treading

Array = NDArray[np.float64]

_UNITS: Final = np.eye(4)
_MULTIPLIED: Final = quaternion.multiply(_UNITS[:, None], _UNITS).reshape(16, 4)
"""What the product a·b is made of: the coefficients of each aᵢbⱼ, shape (16, 4)."""
_UNDONE: Final = quaternion.multiply(quaternion.conjugate(_UNITS)[:, None], _UNITS).reshape(16, 4)
"""The same of a⁻¹·b."""


class LiveFrame(NamedTuple):
    """One frame, as it is performed."""

    rotations: Array
    """Of all joints relative to their parents, shape (joints, 4)."""
    root: Array
    """Place of the root, metres, shape (3,)."""


class LiveRenderer:
    """Performs paths frame by frame, as they are chosen: nothing is known of what comes.

    A transition takes its whole offset away after the cut (`kinesics.synthesis.blending.one_sided`); a foot stays where it
    came down, and comes back to its place in the recording while it swings. An iterator of `LiveFrame`; it ends when the
    paths do.

    Parameters
    ----------
    network : of the paths.
    paths : numbers of paths, each a successor of the one before, or pairs of such a number and the radians that the path is
        turned by besides, as ``bend`` of `render`; the next is asked for as the one before has ended.
    start, heading : see `render`.
    pinned : whether feet are kept in place.

    Raises
    ------
    InputError
        If ``start`` or ``heading`` is not finite or ``paths`` cannot be gone through; on the way, if a path is none, does not
        follow the one before or its bend is not finite.
    """

    def __init__(
        self,
        network: Network,
        paths: Iterable[int | tuple[int, float]],
        *,
        start: ArrayLike = (0.0, 0.0),
        heading: float = 0.0,
        pinned: bool = True,
    ) -> None:
        try:
            origin, faced = np.asarray(start, dtype=np.float64), float(heading)
        except (TypeError, ValueError):
            origin, faced = np.empty(0), math.nan
        if origin.shape != (2,) or not np.isfinite(origin).all() or not math.isfinite(faced):
            raise InputError(f"Expected `start` as finite x, z and a finite `heading`, got {start!r} and {heading!r}.")
        if not isinstance(paths, Iterable):
            raise InputError(f"Expected `paths` as numbers of paths one after the other, got {paths!r}.")
        self.network, self.pinned = network, pinned
        self.stage = Stage.of(network.repertoire)
        self._paths = iter(paths)
        self._treading = Treading(self.stage)
        # joints that the body's carrier hangs on, from the root on
        self._above: list[int] = []
        joint = self.stage.carrier
        while joint > 0:
            joint = network.repertoire.skeleton.parents[joint]
            self._above.insert(0, joint)
        self._starts = network.repertoire.starts.tolist()
        network.edges(0, 0), network.met, network.onward  # tables that are made when first asked for
        joints = network.repertoire.skeleton.joint_count
        self.path = -1
        """Number of the path that is being performed, −1 before the first frame."""
        self.moment = -1
        """Moment of the repertoire that is being performed."""
        self.place = origin.copy()
        """Where the root goes next, x and z, metres: where the next path begins, once a path has ended."""
        self.heading = faced
        """The same of the heading, radians."""
        self._left = 0
        self._onwards = 1
        self._turn = 0.0
        self._bend = 0.0
        self._offset = np.zeros((joints + 1, 3))
        self._velocity = np.zeros((joints + 1, 3))
        self._since = np.inf
        self._duration = 1.0

    def __iter__(self) -> LiveRenderer:
        """Itself."""
        return self

    def __next__(self) -> LiveFrame:
        """The next frame."""
        return self.step()

    def step(self) -> LiveFrame:
        """The next frame.

        Raises
        ------
        StopIteration
            If the paths have ended.
        """
        repertoire = self.network.repertoire
        if self._left == 0:
            self._begin(next(self._paths))
        else:
            self.moment += self._onwards
        self._left -= 1
        # within a path, and just behind it, the recording goes on: no need to ask how far it reaches
        strand, frame = divmod(self.moment, repertoire.frame_count)
        image, onward = strand % 2, frame + self._onwards
        rotations = repertoire.rotations[image, frame].copy()
        rotations[self.stage.carrier] = self._faced(rotations, self._turn)
        here, after = repertoire.root_positions[image, [frame, onward]].tolist()
        root = (float(self.place[0]), here[1], float(self.place[1]))
        x, _, z = _turned(single.subtract(after, here), self._turn + 0.5 * self._bend)
        self.place += x, z
        self._turn += self._bend
        yaw = float(repertoire.poses.yaw[onward])
        self.heading = (-yaw if image else yaw) + self._turn
        if self._since < self._duration:
            added = blending.decay(self._offset, self._velocity, np.full(1, self._since), self._duration)
            rotations = self._inside(_added(rotations, added[:-1]))
            x, y, z = added[-1].tolist()
            root = single.add(root, (x, y, z))
            self._since += 1.0 / repertoire.fps
        if self.pinned:
            root = self._treading.step(rotations, root, image, frame)
        return LiveFrame(rotations, np.array(root))

    def _faced(self, rotations: Array, turn: float) -> Quaternion:
        """The rotation of the joint that a body hangs on, turned about the vertical: see `turn_bodies`."""
        yaw: Quaternion = (math.cos(0.5 * turn), 0.0, math.sin(0.5 * turn), 0.0)
        if self._above:
            above, *others = (_plain(rotations[joint]) for joint in self._above)
            for q in others:
                above = single.multiply(above, q)
            yaw = single.undo(above, single.multiply(yaw, above))
        return single.multiply(yaw, _plain(rotations[self.stage.carrier]))

    def _begin(self, chosen: int | tuple[int, float]) -> None:
        network, repertoire = self.network, self.network.repertoire
        try:
            number, turned = chosen if isinstance(chosen, tuple) else (chosen, 0.0)
            path, bend = operator.index(number), float(turned)
        except (TypeError, ValueError):
            path, bend = -1, math.nan
        if not math.isfinite(bend):
            raise InputError(
                f"Expected the number of a path, or a pair of one and finite radians that it is bent by, got {chosen!r}."
            )
        if not 0 <= path < len(network):
            raise InputError(f"Expected a path below {len(network)}, got {path}.")
        first = int(network.first[path])
        if self.path < 0:
            self._turn = self.heading - float(repertoire.yaw_of(first))
        else:
            edge = int(network.edges(self.path, path))
            if edge < 0:
                raise InputError(f"Path {path} does not follow path {self.path}.")
            left = int(network.onward[self.path])
            if first != left:
                self._cut(left, first, edge)
        self.path, self.moment, self._left = path, first, int(network.length[path])
        self._bend = bend / self._left
        self._onwards = -1 if bool(repertoire.is_backward(first)) else 1

    def _cut(self, left: int, first: int, edge: int) -> None:
        repertoire, stage = self.network.repertoire, self.stage
        # how the two meet: as the controller and `kinesics.synthesis.rendering` have it
        place, met = (complex(values[edge]) for values in self.network.met)
        aside = place * cmath.exp(1j * self.heading)
        turn = self._turn + float(repertoire.yaw_of(left)) + met.real - float(repertoire.yaw_of(first))
        offset, velocity = self._seam(left, first, turn, aside)
        self.place += aside.imag, aside.real
        self.heading += met.real
        # what is still left of the last transition goes along
        rest, speed = np.zeros_like(self._offset), np.zeros_like(self._velocity)
        if self._since < self._duration:
            dt = 0.5 / repertoire.fps
            at = np.array([max(self._since - dt, 0.0), self._since, self._since + dt])
            before, rest, after = blending.decay(self._offset, self._velocity, at[:, None], self._duration)
            speed = (after - before) / (at[2] - at[0])
        self._offset, self._velocity = rest - offset, speed - velocity
        which = stage.blended
        span = blending.window(
            np.linalg.norm(self._offset[which], axis=-1),
            np.linalg.norm(self._velocity[which], axis=-1),
            SPARED * stage.accelerations[which],
        )
        # one side alone has twice the offset to take away
        self._duration = min(np.sqrt(2.0) * span.after, blending.LONGEST)
        self._since = 0.0
        self._turn = turn

    def _seam(self, left: int, first: int, turn: float, aside: complex) -> tuple[Array, Array]:
        """`kinesics.synthesis.stage.seams` of one cut, shapes (joints + 1, 3)."""
        repertoire, fps = self.network.repertoire, self.network.repertoire.fps
        (image, here), (entered, there) = self._around(left), self._around(first)
        reached = [a >= 0 and b >= 0 for a, b in zip(here, there, strict=True)]
        # where either recording does not reach, the moment itself stands for the one beside it
        here = [a if both else here[1] for a, both in zip(here, reached, strict=True)]
        there = [b if both else there[1] for b, both in zip(there, reached, strict=True)]
        old, new = repertoire.rotations[image, here], repertoire.rotations[entered, there]
        offsets = np.empty((3, len(self._offset), 3))
        offsets[:, :-1] = _offset(old, new)
        roots = repertoire.root_positions[image, here].tolist(), repertoire.root_positions[entered, there].tolist()
        for k, (before, after) in enumerate(zip(*roots, strict=True)):
            own, other = self._faced(old[k], self._turn), self._faced(new[k], turn)
            offsets[k, self.stage.carrier] = single.as_rotvec(single.undo(own, other))
            offsets[k, -1] = single.subtract(_turned(after, turn), _turned(before, self._turn))
        earlier, now, later = offsets
        change, span = later - earlier, reached[0] + reached[2]
        velocity = change * (fps / span) if span else np.zeros_like(change)
        # a rotation vector leaps where it passes half a turn; such an offset has no velocity that could be told
        velocity[np.einsum("ij,ij->i", change, change) >= 4.0] = 0.0
        now[-1, 0], now[-1, 2] = aside.imag, aside.real
        return now, velocity

    def _around(self, moment: int) -> tuple[int, list[int]]:
        """Which image a moment plays, and the frames before, at and after it, −1 where its recording does not reach."""
        strand, frame = divmod(moment, self.network.repertoire.frame_count)
        k = bisect.bisect_right(self._starts, frame)
        step = -1 if BACKWARD_STRANDS[strand] else 1
        inside = range(self._starts[k - 1], self._starts[k])
        return strand % 2, [f if f in inside else -1 for f in (frame - step, frame, frame + step)]

    def _inside(self, rotations: Array) -> Array:
        """Joints of the body within their range, shape (joints, 4)."""
        stage = self.stage
        vectors = _offset(stage.middle, rotations)
        beyond = np.any((vectors < stage.low) | (vectors > stage.high), axis=-1)
        beyond[: stage.carrier + 1] = False
        if beyond.any():
            held = np.clip(vectors[beyond], stage.low[beyond], stage.high[beyond])
            rotations[beyond] = blending.add_rotation(stage.middle[beyond], held)
        return rotations


def _offset(left: Array, entered: Array) -> Array:
    """`kinesics.synthesis.blending.rotation_offset` of one frame or three: fewer steps, more memory for each rotation."""
    q = (left[..., :, None] * entered[..., None, :]).reshape(*entered.shape[:-1], 16) @ _UNDONE
    w, vector = q[..., 0], q[..., 1:]
    sin_half = np.sqrt(np.einsum("...i,...i->...", vector, vector))
    scale = 2.0 * np.arctan2(sin_half, np.abs(w)) / np.maximum(sin_half, 1e-150)
    return np.asarray(np.copysign(scale, w)[..., None] * vector)


def _added(q: Array, offset: Array) -> Array:
    """The same of `kinesics.synthesis.blending.add_rotation`."""
    angle = np.sqrt(np.einsum("...i,...i->...", offset, offset))
    turn = np.empty_like(q)
    turn[..., 0] = np.cos(0.5 * angle)
    turn[..., 1:] = (np.sin(0.5 * angle) / np.maximum(angle, 1e-150))[..., None] * offset
    return np.asarray((q[..., :, None] * turn[..., None, :]).reshape(*q.shape[:-1], 16) @ _MULTIPLIED)


def _plain(rotation: Array) -> Quaternion:
    w, x, y, z = rotation.tolist()
    return w, x, y, z


def _turned(place: Sequence[float], yaw: float) -> Vector:
    """A place turned about the vertical."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return cosine * place[0] + sine * place[2], place[1], -sine * place[0] + cosine * place[2]
