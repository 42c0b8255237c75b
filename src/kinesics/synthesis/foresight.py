"""What a live performer knows of its feet beforehand: when each comes down next, and how the recording moves it then.

Of the paths that are known, and behind them of the recording that is being played, as if it went on. While a foot bears, the
recordings themselves let it slide; one that is put down where it will be needed on the average has half as far to be held back.
"""

from __future__ import annotations

import cmath
import itertools
import math
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import kinematics
from kinesics.body.contacts import runs
from kinesics.synthesis.rehearsal import Rehearsal
from kinesics.synthesis.repertoire import Repertoire
from kinesics.synthesis.stage import Stage, bearing

Array = NDArray[np.float64]

_ROLLS: Final = 0.04
"""Seconds at the beginning and the end of a contact in which the sole rolls on and off."""
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
    moves: complex
    """By how much its bearing part goes over the floor in this frame all the same, rolling on or off: z + i·x, metres."""
    height: float
    """Of the lowest point of its sole above the floor in what is played, metres."""


@dataclass(frozen=True, eq=False)
class Foresight:
    """Tables of a repertoire: as recorded and mirrored, frame by frame, left foot and right foot."""

    next: NDArray[np.int32]
    """Frames until a foot bears, if the recording goes on or back: shape (2 ways, 2, frames, 2)."""
    steps: NDArray[np.complex128]
    """By how much the bearing part of its sole has gone over the floor since the frame before, z + i·x, metres: shape
    (2 ways, 2, frames, 2)."""
    heights: Array
    """Of the lowest point of its sole above the floor, metres, shape (2, frames, 2)."""
    fps: float

    @classmethod
    def of(cls, stage: Stage) -> Foresight:
        """Of a repertoire; made once and kept as long as that is."""
        if stage.repertoire not in _tables:
            _tables[stage.repertoire] = cls._made(stage)
        return _tables[stage.repertoire]

    @classmethod
    def _made(cls, stage: Stage) -> Foresight:
        own = stage.repertoire
        shape = (2, 2, own.frame_count, 2)
        following, steps = np.full(shape, _NEVER, dtype=np.int32), np.zeros(shape, dtype=np.complex128)
        steps[0], heights = _steps(stage)
        ramp = max(1, round(_ROLLS * own.fps))
        for first, past in itertools.pairwise(own.starts.tolist()):
            for k in (0, 1):
                before = first
                for a, b in runs(own.contacts[0, first:past, k]):
                    a, b = a + first, b + first
                    # what it slides besides is not wanted
                    inner = slice(a if a == first else min(a + ramp, b), b if b == past else max(b - ramp, a))
                    steps[0, 0, inner, k] = steps[0, 1, inner, 1 - k] = 0.0
                    following[0, 0, before:b, k] = np.maximum(np.arange(a - before, a - b, -1), 0)
                    following[1, 0, a:past, k] = np.maximum(np.arange(a - b + 1, past - b + 1), 0)
                    before = b
            steps[1, :, first : past - 1] = -steps[0, :, first + 1 : past]
        following[:, 1] = following[:, 0, :, ::-1]
        return cls(following, steps, heights, own.fps)

    def coming(self, known: Sequence[Stretch], at: int) -> tuple[Coming, Coming]:
        """What is known of either foot in frame ``at`` of the first stretch, and those behind it."""
        return self._coming(0, known, at), self._coming(1, known, at)

    def _coming(self, k: int, known: Sequence[Stretch], at: int) -> Coming:
        waited = 0
        playing = known[0]
        frame = playing.frame + at * playing.onward
        moves = complex(self.steps[max(-playing.onward, 0), playing.image, frame, k])
        height = float(self.heights[playing.image, frame, k])
        moves *= cmath.exp(1j * (playing.turn + at * playing.bend))
        for number, stretch in enumerate(known):
            frame = stretch.frame + at * stretch.onward
            away = int(self.next[max(-stretch.onward, 0), stretch.image, frame, k])
            if away < stretch.length - at or number + 1 == len(known):
                waited += away
                return Coming(waited == 0, waited / self.fps if away < _NEVER else math.inf, moves, height)
            waited += stretch.length - at
            at = 0
        return Coming(False, math.inf, moves, height)


_tables: weakref.WeakKeyDictionary[Repertoire, Foresight] = weakref.WeakKeyDictionary()


def _steps(stage: Stage) -> tuple[NDArray[np.complex128], Array]:
    """See `Foresight.steps`, forwards, and `Foresight.heights`."""
    own, played = stage.repertoire, Rehearsal.of(stage)
    steps, heights = np.zeros((2, own.frame_count, 2), dtype=np.complex128), np.zeros((2, own.frame_count, 2))
    for first, past in itertools.pairwise(own.starts.tolist()):
        for a in range(first, max(past - 1, first + 1), _BLOCK):
            b = min(a + _BLOCK + 1, past)
            for image in (0, 1):
                rotations = own.rotations[image, a:b].copy()
                rotations[:, played.joints] = played.rotations[image, a:b]
                known = kinematics.forward(own.skeleton, rotations, played.roots[image, a:b])
                soles = stage.soles.place(known.positions, known.rotations)
                heights[image, a:b] = soles[..., 1].min(axis=-1)
                height = soles[..., 1] - stage.levels
                share = bearing(0.5 * (height[1:] + height[:-1]))
                moved = np.diff(soles[..., 2] + 1j * soles[..., 0], axis=0)
                steps[image, a + 1 : b] = (share * moved).sum(axis=-1)
    return steps, heights
