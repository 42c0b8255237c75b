"""Where the body of a performance truly is while its way is still being decided for.

Feet that stay where they bear take the body a little elsewhere than the way laid for it: millimetres at a transition, but what is
laid comes after what was laid before, so that on a way of hundreds of metres they add up to metres. What was decided for is
therefore performed now and then, stretch by stretch, and one goes on deciding from where the body has come to.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from kinesics.synthesis.controller import Controller, Step
from kinesics.synthesis.network import Network
from kinesics.synthesis.rendering import render

OVERLAP: Final = 3.0
"""Seconds of the stretch before that are performed again: at its end feet did not yet know what comes."""


class Underway:
    """Sets a controller right at the end of every stretch of so many seconds.

    Parameters
    ----------
    network : on which decisions are made; its ways are those of feet that are planted (`kinesics.synthesis.afoot`).
    every : seconds of a stretch, at least.
    """

    def __init__(self, network: Network, every: float) -> None:
        self._network = network
        self._every = every
        self._known: list[complex] = []
        """By how much the body was known to be beside its way, z + i·x, as each path was decided for."""
        self._beside = 0j
        self._until = 0.0
        """Seconds looked at so far."""
        self._anchor, self._there = 0, 0j
        """A path from which on what was looked at last is looked at again, and by how much the body was beside its way as it
        began: to which that is added by which it is now more so."""

    def __call__(self, controller: Controller, steps: Sequence[Step]) -> None:
        """Look at the paths decided for so far, if they are a stretch more."""
        self._known += [self._beside] * (len(steps) - len(self._known))
        if controller.now.time < self._until + self._every:
            return
        lengths = self._network.length[[step.path for step in steps]]
        begins = np.concatenate([[0], np.cumsum(lengths)])
        overlap = OVERLAP * self._network.repertoire.fps
        first = max(0, int(np.searchsorted(begins, begins[self._anchor] - overlap, side="right")) - 1)
        some = steps[first:]
        way = np.concatenate(
            [controller.way(step)[0][:-1] - known for step, known in zip(some, self._known[first:], strict=True)]
        )
        done = render(
            self._network,
            [step.path for step in some],
            start=(way[0].imag, way[0].real),
            heading=some[0].heading,
            bend=[step.turned for step in some],
        )
        beside = done.motion.root_positions[:, [0, 2]] @ [1j, 1.0] - way
        beside += self._there - beside[begins[self._anchor] - begins[first]]
        self._anchor = max(self._anchor, int(np.searchsorted(begins, begins[-1] - overlap, side="right")) - 1)
        self._there = complex(beside[begins[self._anchor] - begins[first]])
        self._until = controller.now.time
        controller.now.place += complex(beside[-1]) - self._beside
        self._beside = complex(beside[-1])
