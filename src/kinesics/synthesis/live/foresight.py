"""What a live performer knows of its feet beforehand: when each comes down next, and how high above the floor it is played.

Of the paths that are known, and behind them of the recording that is being played, as if it went on.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import contacts, kinematics
from kinesics.geometry.single import Vector
from kinesics.synthesis.embodiment.pivots import stood_on
from kinesics.synthesis.embodiment.rehearsal import played
from kinesics.synthesis.embodiment.stage import YARDSTICK, Stage
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]

_NEVER: Final = 1 << 30
_BLOCK: Final = 2048


@dataclass(frozen=True)
class Stretch:
    """A path that is known to be performed."""

    path: int
    moment: int
    """Its first."""
    image: int
    """1 if it is mirrored."""
    frame: int
    """Of the repertoire: its first."""
    onward: int
    """1, or −1 where it is played backwards."""
    length: int
    """Frames."""
    turn: float
    """Radians about the vertical that it is turned by in its first frame."""
    bend: float
    """By which it is turned more with every frame."""
    places: Sequence[complex]
    """Of the root in each frame, z + i·x, metres."""


class Coming(NamedTuple):
    """What is known of one foot."""

    bears: bool
    """Whether it is on the ground."""
    seconds: float
    """Until it comes down, infinite if that is not known."""
    height: float
    """Of the lowest point of its sole above the floor in what is played, metres."""
    parts: Vector
    """The point of its sole that it stands on: parts of heel, ball and tip, sum 1 (`synthesis.embodiment.pivots`)."""


@dataclass(frozen=True, eq=False)
class Foresight:
    """Tables of a repertoire: as recorded and mirrored, frame by frame, left foot and right foot."""

    down: NDArray[np.int32]
    """Frames until a foot bears, 0 while it does, if the recording goes on or back: shape (2 ways, 2, frames, 2)."""
    heights: Array
    """Of the lowest point of its sole above the floor, metres, shape (2, frames, 2)."""
    standing: NDArray[np.bool_]
    """Whether it bears: as in the recordings, and as anyone would find in them as they are played; shape (2, frames, 2)."""
    quick: float
    """99th percentile of how feet are accelerated over the floor from frame to frame, m/s²."""
    parts: Array
    """The point of its sole that each stands on from each frame to the next, shape (2, frames, 2, 3)."""
    fps: float

    @classmethod
    def of(cls, stage: Stage) -> Foresight:
        """Of a repertoire; made once and kept as long as that is."""
        return stage.repertoire.kept(cls._made)

    @classmethod
    def _made(cls, repertoire: Repertoire) -> Foresight:
        stage = Stage.of(repertoire)
        own = played(stage)
        shape = (2, 2, own.frame_count, 2)
        down, heights, standing = np.full(shape, _NEVER, dtype=np.int32), np.zeros(shape[1:]), own.contacts.copy()
        parts = np.zeros((*shape[1:], 3))
        parts[..., 0] = 1.0
        pushes = [np.zeros(1)]
        for first, past in itertools.pairwise(own.starts.tolist()):
            for image in (0, 1):
                places = _soles(stage, own, image, first, past)
                way = np.diff((places[..., 2] + 1j * places[..., 0]).mean(axis=-1), n=2, axis=0)
                pushes.append(np.abs(way).ravel() * own.fps**2)
                heights[image, first:past] = places[..., 1].min(axis=-1)
                for k in (0, 1):
                    points = places[:, k]
                    parts[image, first : past - 1, k] = stood_on(points, points[..., 1] - stage.levels[k], own.fps)
                parts[image, past - 1] = parts[image, max(past - 2, first)]
                # held for less than anyone would find it bear, a foot slides in what is left
                found = contacts.touching(places, places[..., 1], own.fps, stage.stature, stage.slow)
                standing[image, first:past] |= found.feet
                for k in (0, 1):
                    before = first
                    for a, b in contacts.runs(standing[image, first:past, k]):
                        a, b = a + first, b + first
                        down[0, image, before:b, k] = np.maximum(np.arange(a - before, a - b, -1), 0)
                        down[1, image, a:past, k] = np.maximum(np.arange(a - b + 1, past - b + 1), 0)
                        before = b
        return cls(down, heights, standing, float(np.quantile(np.concatenate(pushes), YARDSTICK)), parts, own.fps)

    def coming(self, known: Sequence[Stretch], at: int) -> tuple[Coming, Coming]:
        """What is known of either foot in frame ``at`` of the first stretch, and those behind it."""
        return self._coming(0, known, at), self._coming(1, known, at)

    def _coming(self, k: int, known: Sequence[Stretch], at: int) -> Coming:
        playing = known[0]
        here = playing.frame + at * playing.onward
        height = float(self.heights[playing.image, here, k])
        # on the way to here; of the first frame of a path, on the way from it
        a, b, c = self.parts[playing.image, here - max(playing.onward, 0) * min(at, 1), k].tolist()
        parts = a, b, c
        waited = 0
        for number, stretch in enumerate(known):
            frame = stretch.frame + at * stretch.onward
            away = int(self.down[max(-stretch.onward, 0), stretch.image, frame, k])
            if away < stretch.length - at or number + 1 == len(known):
                waited += away
                return Coming(waited == 0, waited / self.fps if away < _NEVER else math.inf, height, parts)
            waited += stretch.length - at
            at = 0
        return Coming(False, math.inf, height, parts)


def _soles(stage: Stage, own: Repertoire, image: int, first: int, past: int) -> Array:
    """Where the points of both soles are as they are played, shape (frames, 2, 3, 3)."""
    out = np.empty((past - first, 2, 3, 3))
    for a in range(first, past, _BLOCK):
        b = min(a + _BLOCK, past)
        known = kinematics.forward(own.skeleton, own.rotations[image, a:b], own.root_positions[image, a:b])
        out[a - first : b - first] = stage.soles.place(known.positions, known.rotations)
    return out
