"""Paths performed live, frame by frame as they are chosen, knowing only the past ([Schultz2012] §4.4).

`kinesics.synthesis.rendering` does the same with the whole performance before it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body import kinematics
from kinesics.errors import InputError
from kinesics.synthesis import blending, inverse_kinematics
from kinesics.synthesis.network import Network
from kinesics.synthesis.repertoire import Repertoire
from kinesics.synthesis.stage import (
    LIFT,
    RELEASE,
    SINK,
    SOFTLY,
    SPARED,
    SUNK,
    Stage,
    bearing,
    held_around,
    seams,
    shortfall,
    turn_bodies,
)

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

_SLIPPED: Final = 0.3
"""Share of what a leg falls short of that its foot slides for good."""
_FOLLOWED: Final = 0.3
"""Share of it by which the body goes along in one frame."""
_GRASP: Final = 0.03
"""Seconds in which a foot that is on the ground after a cut is grasped."""
LIVE_LEAN: Final = 0.4
"""Seconds in which, live, the body follows its feet by two thirds: quicker it would lurch, for it cannot begin before."""
RETURN: Final = 0.12
"""Seconds in which, live, a swinging foot comes back to its place in the recording by two thirds."""
_FLIGHT: Final = 0.05
"""What weighs for no shift at all, so that a body in flight comes back."""


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
    paths : numbers of paths, each a successor of the one before; the next is asked for as the one before has ended.
    start, heading : see `render`.
    pinned : whether feet are kept in place.

    Raises
    ------
    InputError
        If ``start`` or ``heading`` is not finite; on the way, if a path does not follow the one before.
    """

    def __init__(
        self,
        network: Network,
        paths: Iterable[int],
        *,
        start: ArrayLike = (0.0, 0.0),
        heading: float = 0.0,
        pinned: bool = True,
    ) -> None:
        origin = np.asarray(start, dtype=np.float64)
        if origin.shape != (2,) or not np.isfinite(origin).all() or not np.isfinite(heading):
            raise InputError(f"Expected `start` as finite x, z and a finite `heading`, got {start!r} and {heading!r}.")
        self.network, self.pinned = network, pinned
        self.stage = Stage.of(network.repertoire)
        self._paths = iter(paths)
        self._feet = _LiveFeet(self.stage)
        joints = network.repertoire.skeleton.joint_count
        self.path = -1
        """Number of the path that is being performed, −1 before the first frame."""
        self.moment = -1
        """Moment of the repertoire that is being performed."""
        self.place = origin.copy()
        """Where the root goes next, x and z, metres: where the next path begins, once a path has ended."""
        self.heading = float(heading)
        """The same of the heading, radians."""
        self._left = 0
        self._onwards = 1
        self._turn = 0.0
        self._onward = -1
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
        rotations = repertoire.rotations[image, frame][None].copy()
        turn_bodies(repertoire, self.stage.carrier, rotations, np.array([self._turn]))
        here, after = repertoire.root_positions[image, frame], repertoire.root_positions[image, onward]
        moved = after - here
        root = np.array([self.place[0], here[1], self.place[1]])
        cosine, sine = np.cos(self._turn), np.sin(self._turn)
        self.place += cosine * moved[0] + sine * moved[2], -sine * moved[0] + cosine * moved[2]
        yaw = float(repertoire.poses.yaw[onward])
        self.heading = (-yaw if image else yaw) + self._turn
        if self._since < self._duration:
            added = blending.decay(self._offset, self._velocity, np.full(1, self._since), self._duration)
            rotations[0] = self._inside(blending.add_rotation(rotations[0], added[:-1]))
            root += added[-1]
            self._since += 1.0 / repertoire.fps
        if self.pinned:
            return self._feet.step(rotations, root, self.moment)
        return LiveFrame(rotations[0], root)

    def _begin(self, path: int) -> None:
        network, repertoire = self.network, self.network.repertoire
        path = int(path)
        if not 0 <= path < len(network):
            raise InputError(f"Expected a path below {len(network)}, got {path}.")
        first = int(network.first[path])
        if self.path < 0:
            self._turn = self.heading - float(repertoire.yaw_of(first))
        else:
            if path not in network.successors(self.path):
                raise InputError(f"Path {path} does not follow path {self.path}.")
            left = int(network.onward[self.path])
            if first != left:
                self._cut(left, first)
        self.path, self.moment, self._left = path, first, int(network.length[path])
        self._onwards = -1 if bool(repertoire.is_backward(first)) else 1

    def _cut(self, left: int, first: int) -> None:
        repertoire, stage = self.network.repertoire, self.stage
        turn = self._turn + float(repertoire.yaw_of(left)) - float(repertoire.yaw_of(first))
        offsets, velocities = seams(
            repertoire,
            stage.carrier,
            np.array([left]),
            np.array([self._turn]),
            np.array([first]),
            np.array([turn]),
        )
        # what is still left of the last transition goes along
        rest, speed = np.zeros_like(self._offset), np.zeros_like(self._velocity)
        if self._since < self._duration:
            dt = 0.5 / repertoire.fps
            at = np.array([max(self._since - dt, 0.0), self._since, self._since + dt])
            before, rest, after = blending.decay(self._offset, self._velocity, at[:, None], self._duration)
            speed = (after - before) / (at[2] - at[0])
        self._offset, self._velocity = rest - offsets[0], speed - velocities[0]
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

    def _inside(self, rotations: Array) -> Array:
        """Joints of the body within their range, shape (joints, 4)."""
        stage = self.stage
        vectors = blending.rotation_offset(stage.middle, rotations)
        beyond = np.any((vectors < stage.low) | (vectors > stage.high), axis=-1)
        beyond[: stage.carrier + 1] = False
        if beyond.any():
            held = np.clip(vectors[beyond], stage.low[beyond], stage.high[beyond])
            rotations[beyond] = blending.add_rotation(stage.middle[beyond], held)
        return rotations


class _LiveFeet:
    """Keeps feet in place knowing only the past, and what the recordings themselves would do next."""

    def __init__(self, stage: Stage) -> None:
        self.stage = stage
        repertoire = stage.repertoire
        fps = repertoire.fps
        self._held, self._near = _holds(repertoire, RELEASE * fps), _holds(repertoire, LIFT * fps)
        self._soles: Array | None = None
        self._height = np.zeros((2, 3))
        self._shift = np.zeros((2, 2))
        self._lift = np.zeros(2)
        self._hold = np.zeros(2)
        self._lean = np.zeros(2)
        self._drop = 0.0
        self._fps = fps
        legs = stage.legs
        self._joints = [*legs.femurs, *legs.tibias, *legs.feet]
        self._middle, self._low, self._high = (v[self._joints] for v in (stage.middle, stage.low, stage.high))

    def step(self, rotations: Array, root: Array, moment: int) -> LiveFrame:
        """Plant the feet of one frame: rotations of shape (1, joints, 4)."""
        stage, dt = self.stage, 1.0 / self._fps
        skeleton, legs = stage.repertoire.skeleton, stage.legs
        frame, strand = moment % stage.repertoire.frame_count, moment // stage.repertoire.frame_count
        known = kinematics.forward(skeleton, rotations, root[None])
        soles = stage.soles.place(known.positions, known.rotations)[0]
        height = soles[..., 1] - stage.levels
        lowest = soles[..., 1].min(axis=1)
        held, near = self._held[strand % 2, frame], self._near[strand % 2, frame]
        # at a cut a foot may be grasped or let go from one frame to the next: not so quickly
        self._hold += np.clip(held - self._hold, -dt / RELEASE, dt / _GRASP)
        if self._soles is None:
            self._hold = held.copy()
            self._lift = -near * lowest
        else:
            share = bearing(0.5 * (height + self._height))
            slid = np.einsum("kp,kpi->ki", share, (soles - self._soles)[..., [0, 2]])
            free = 1.0 - self._hold
            self._shift += -self._hold[:, None] * slid - (free * _eased(dt, RETURN))[:, None] * self._shift
        self._soles, self._height = soles, height
        self._lift += _eased(dt, SOFTLY) * (-near * lowest - self._lift)
        lift = np.maximum(self._lift, -lowest - SUNK)
        toward = (self._hold[:, None] * self._shift).sum(axis=0) / (self._hold.sum() + _FLIGHT)
        self._lean += _eased(dt, LIVE_LEAN) * (toward - self._lean)
        corrected = np.stack([self._shift[:, 0], lift, self._shift[:, 1]], axis=-1)
        targets = known.positions[:, list(legs.feet)] + corrected
        shift = np.array([self._lean[0], 0.0, self._lean[1]])
        need = float((shortfall(stage, known.positions + shift, targets) * self._hold).max())
        self._drop += _eased(dt, 0.25 * SINK if need > self._drop else SINK) * (need - self._drop)
        shift[1] = -self._drop
        known = known._replace(positions=known.positions + shift)
        done = inverse_kinematics.reach(skeleton, rotations, (root + shift)[None], targets, limbs=legs, known=known)
        return LiveFrame(*self._within(done.rotations, root + shift, targets))

    def _within(self, rotations: Array, root: Array, targets: Array) -> tuple[Array, Array]:
        """Legs within their range: the foot slides, and the body goes after it from the next frame on."""
        stage, joints = self.stage, self._joints
        vectors = blending.rotation_offset(self._middle, rotations[0, joints])
        held = np.clip(vectors, self._low, self._high)
        if np.array_equal(held, vectors):
            return rotations[0], root
        rotations[0, joints] = blending.add_rotation(self._middle, held)
        known = kinematics.forward(stage.repertoire.skeleton, rotations, root[None])
        off = (targets - known.positions[:, list(stage.legs.feet)])[0][:, [0, 2]]
        self._shift -= _SLIPPED * off
        self._lean += _FOLLOWED * (self._hold[:, None] * off).sum(axis=0) / (self._hold.sum() + _FLIGHT)
        sunk = -float(stage.soles.place(known.positions, known.rotations)[..., 1].min()) - SUNK
        return rotations[0], root + np.array([0.0, max(sunk, 0.0), 0.0])


def _eased(dt: float, seconds: float) -> float:
    """Share of the way that is gone in ``dt`` by what goes two thirds in ``seconds``."""
    return float(-np.expm1(-dt / seconds))


def _holds(repertoire: Repertoire, reach: float) -> Array:
    """`held_around` of every frame, of both feet, as recorded and mirrored: shape (2, frames, 2)."""
    out = np.zeros((2, repertoire.frame_count, 2))
    for a, b in itertools.pairwise(repertoire.starts.tolist()):
        for k in (0, 1):
            standing = repertoire.contacts[0, a:b, k]
            if standing.any():
                out[0, a:b, k] = held_around(standing, reach)
    out[1] = out[0, :, ::-1]
    return out
