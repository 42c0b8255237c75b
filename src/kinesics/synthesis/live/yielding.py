"""Joints that a transition would take beyond their range: they go back before they come there, and are let go afterwards.

Held at its end only in the frame that would go beyond, a joint that flies there stops dead. But what is played in the coming
frames is known, and what transitions add to it; so that is known as well by how much joints will be beyond. They are turned back
by a smooth curve that is nowhere less, as all at once by `synthesis.embodiment.ranges.put_within_range`. Where a transition is
known late the curve goes over into another one; what that leaves beyond is held as it comes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.ranges import YIELD, Ranges, hann

Array = NDArray[np.float64]

_LOOKED_AT: Final = 3
"""Coming frames that are looked at anew in one frame, at most."""


class Yielding:
    """The joints of one performance.

    Parameters
    ----------
    joints : how many.
    fps : frames a second.
    """

    def __init__(self, ranges: Ranges, joints: int, fps: float) -> None:
        self._ranges, self._fps = ranges, fps
        reach = max(1, round(YIELD * fps))
        self.ahead = 2 * reach
        """Frames before it comes that it is looked for what is beyond."""
        self._window = hann(reach)
        # by how much in each frame, from as many before the last one on to as many after this one
        self._beyond = np.zeros((2 * self.ahead + 2, joints, 3))
        self._any = [False] * len(self._beyond)
        self._anew = self.ahead
        self._back = np.zeros((joints, 3))
        self._late: tuple[Array, Array] | None = None
        self._since = 0

    @property
    def at_rest(self) -> bool:
        """Whether no joint is turned back, nor is to be, as far as it was looked for."""
        return self._late is None and not any(self._any)

    def step(self, rotations: Array, coming: Callable[[int], Array | None], *, anew: bool) -> None:
        """Keep the joints of a frame within their ranges, rotations of shape (joints, 4), in place.

        Parameters
        ----------
        coming : the rotations so many frames later, shape (joints, 4); None where no transition adds to them or they are not known.
        anew : whether other is known of the coming frames than was a frame before.
        """
        self._beyond[:-1] = self._beyond[1:]
        self._any = [*self._any[1:], False]
        self._look([self.ahead], coming)
        if anew:
            self._anew = 0
        elif self._anew < self.ahead:
            self._anew = max(self._anew - 1, 0)
        if self._anew < self.ahead:
            self._look_anew(coming)
        if self.at_rest:
            self._back[:] = 0.0
            if self._anew < self.ahead:
                self._ranges.hold(rotations)
            return
        self._back = self._asked()
        self._since += 1
        if self._since >= self.ahead:
            self._late = None
        self._ranges.hold(rotations, self._back)

    def _look(self, frames: Iterable[int], coming: Callable[[int], Array | None]) -> None:
        for k in frames:
            rotations = coming(k)
            found = None if rotations is None else self._ranges.excess(rotations)
            at = self.ahead + 1 + k
            self._beyond[at] = 0.0 if found is None else found
            self._any[at] = found is not None

    def _look_anew(self, coming: Callable[[int], Array | None]) -> None:
        """At the next of the frames of which other is known; and go over from what was to be to what is to be, without a leap."""
        rested = self.at_rest
        asked = None if rested else self._asked()
        past = min(self._anew + _LOOKED_AT, self.ahead)
        self._look(range(self._anew, past), coming)
        self._anew = past
        if rested and self.at_rest:
            return
        before = self._back - self._curve(0)
        change = (0.0 if asked is None else asked) - self._curve(1) - before
        self._since = 0
        self._late = (before, change * self._fps) if before.any() or change.any() else None

    def _asked(self) -> Array:
        """By how much joints are to be turned back in this frame, shape (joints, 3)."""
        out = self._curve(1)
        if self._late is not None:
            offset, velocity = self._late
            time, duration = np.array((self._since + 1) / self._fps), self.ahead / self._fps
            out += blending.decay(offset, velocity, time, duration)
        return out

    def _curve(self, k: int) -> Array:
        """`synthesis.embodiment.ranges.both_ways` in the last frame (0) or in this one (1): shape (joints, 3)."""
        out = np.zeros_like(self._back)
        beyond = self._beyond[k : k + 2 * self.ahead + 1]
        if compiled.wanted():
            compiled.native.eased(beyond, self._window, out)
            return out
        wide = np.lib.stride_tricks.sliding_window_view(beyond, len(self._window), axis=0)
        return np.asarray(np.tensordot(self._window, np.maximum(wide.max(-1), 0.0) + np.minimum(wide.min(-1), 0.0), 1))
