"""What is played live in one frame: turned about the vertical and put in its place ([Schultz2012] §4.4)."""

from __future__ import annotations

import bisect
import math

import numpy as np
from numpy.typing import NDArray

from kinesics.geometry import single
from kinesics.geometry.single import Quaternion, Vector
from kinesics.synthesis.embodiment.stage import Stage, frames_of_reach
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.repertoire import BACKWARD_STRANDS, Repertoire

Array = NDArray[np.float64]
Complexes = NDArray[np.complex128]


class Poses:
    """Of one performance: what its recordings play, and where."""

    def __init__(self, stage: Stage, own: Repertoire, network: Network) -> None:
        self.carrier = stage.carrier
        self.own = own
        """As it is played: `kinesics.synthesis.embodiment.rehearsal.played`."""
        self.reach = frames_of_reach(own.fps)
        self.above: list[int] = []
        """Joints that the body's carrier hangs on, from the root on."""
        joint = stage.carrier
        while joint > 0:
            joint = own.skeleton.parents[joint]
            self.above.insert(0, joint)
        self._starts = own.starts.tolist()
        self.faces: list[float] = own.yaw_of(network.first).tolist()
        """Where the body faces at the first moment of each path, radians."""
        self.faces_onward: list[float] = own.yaw_of(network.onward).tolist()
        """And at the moment with which its recording goes on."""
        self._strides = np.diff(own.root_positions[..., 2] + 1j * own.root_positions[..., 0], axis=1)
        self._halfway = np.arange(int(network.length.max(initial=0))) + 0.5

    def at(self, image: int, frame: int, turn: float, place: complex) -> tuple[Array, Vector]:
        """What is performed in a frame, turned and put in its place: rotations (joints, 4), and where the root is."""
        own = self.own
        rotations = own.rotations[image, frame].copy()
        root: Vector = (place.imag, float(own.root_positions[image, frame, 1]), place.real)
        rotations[self.carrier] = self.faced(rotations, turn)
        return rotations, root

    def way(self, image: int, frame: int, onward: int, length: int, turn: float, bend: float) -> Complexes:
        """Where the root is in so many frames and the one behind them, seen from the first, z + i·x, metres: shape (length + 1,).

        Parameters
        ----------
        onward : 1, or −1 backwards.
        turn, bend : radians by which it is turned about the vertical at first, and more with every frame.
        """
        strides = self._strides[image]
        moved = strides[frame : frame + length] if onward > 0 else -strides[frame - length : frame][::-1]
        places = np.zeros(length + 1, dtype=np.complex128)
        np.cumsum(moved * np.exp(1j * (turn + bend * self._halfway[:length])), out=places[1:])
        return places

    def faced(self, rotations: Array, turn: float) -> Quaternion:
        """The rotation of the joint that a body hangs on, turned about the vertical: see `turn_bodies`."""
        yaw: Quaternion = (math.cos(0.5 * turn), 0.0, math.sin(0.5 * turn), 0.0)
        if self.above:
            above, *others = (_plain(rotations[joint]) for joint in self.above)
            for q in others:
                above = single.multiply(above, q)
            yaw = single.undo(above, single.multiply(yaw, above))
        return single.multiply(yaw, _plain(rotations[self.carrier]))

    def around(self, moment: int) -> tuple[int, list[int]]:
        """Which image a moment plays, and the frames before, at and after it, −1 where its recording does not reach."""
        strand, frame = divmod(moment, self.own.frame_count)
        k = bisect.bisect_right(self._starts, frame)
        step = -self.reach if BACKWARD_STRANDS[strand] else self.reach
        inside = range(self._starts[k - 1], self._starts[k])
        return strand % 2, [f if f in inside else -1 for f in (frame - step, frame, frame + step)]


def _plain(rotation: Array) -> Quaternion:
    w, x, y, z = rotation.tolist()
    return w, x, y, z
