"""What a recording was already asked for while states come and go."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar.moments import Moments
from kinesics.grammar.reading.states import ReadState
from kinesics.grammar.reading.stretches import CELLS, POINTS, below, cut_at, spaced, warped

Floats = NDArray[np.float32]


class Passage(NamedTuple):
    """The movement is near a pose."""

    start: int
    end: int
    at: int
    depth: float
    """Least distance."""


class Seen:
    """What a recording was already asked for while states come and go: when it passes a pose, how far apart stretches are."""

    def __init__(self, moments: Moments, radius: float, breaks: Sequence[int]) -> None:
        self.moments, self.radius, self.breaks = moments, radius, breaks
        self._passages: dict[tuple[int, bool], tuple[list[Passage], list[Passage]]] = {}
        self._warped: dict[tuple[int, int, int, int], dict[tuple[bool, bool], float]] = {}

    def passages(self, states: Sequence[ReadState]) -> list[tuple[list[Passage], list[Passage]]]:
        """When the movement passes each state, and when its mirror image: never, where the state is symmetric.

        A symmetric state is passed when either it or its mirror image is, for nobody is exactly symmetric.
        """
        wanted = [(s.moment, s.symmetric) for s in states]
        new = [key for key in dict.fromkeys(wanted) if key not in self._passages]
        everything = np.arange(self.moments.count)
        step = max(1, CELLS // self.moments.count)
        for first in range(0, len(new), step):
            part = new[first : first + step]
            blocks = self.moments.between(np.array([moment for moment, _ in part]), everything)
            for key, straight, image in zip(part, *blocks, strict=True):
                if key[1]:
                    self._passages[key] = [*self._passed(np.minimum(straight, image))], []
                else:
                    self._passages[key] = [*self._passed(straight)], [*self._passed(image)]
        return [self._passages[key] for key in wanted]

    def _passed(self, row: Floats) -> Iterator[Passage]:
        # in at the radius, out at three times it: noise must not make two visits of one
        for start, end in cut_at(below(row, 3 * self.radius), self.breaks):
            at = start + int(row[start:end].argmin())
            if row[at] < self.radius:
                near = np.flatnonzero(row[start:end] < self.radius)
                yield Passage(start + int(near[0]), start + int(near[-1]) + 1, at, float(row[at]))

    def distances(
        self, stretch: tuple[int, int], others: Sequence[tuple[tuple[int, int], Sequence[tuple[bool, bool]]]]
    ) -> list[float]:
        """Mean distance, warped, of a stretch from others, each under the relations (reversed, mirrored) named, in order."""
        known = [self._warped.setdefault((*stretch, *other), {}) for other, _ in others]
        missing = [
            (k, [r for r in relations if r not in known[k]])
            for k, (_, relations) in enumerate(others)
            if any(r not in known[k] for r in relations)
        ]
        if missing:
            points = [spaced(*others[k][0]) for k, _ in missing]
            d, s = self.moments.between(spaced(*stretch), np.concatenate(points))
            asked = [(k, place, r) for place, (k, relations) in enumerate(missing) for r in relations]
            blocks = []
            for _, place, (backwards, mirrored) in asked:
                block = (s if mirrored else d)[:, place * POINTS : (place + 1) * POINTS]
                blocks.append(block[:, ::-1] if backwards else block)
            for (k, _, relation), cost in zip(asked, warped(np.stack(blocks)).tolist(), strict=True):
                known[k][relation] = cost
        return [costs[r] for costs, (_, relations) in zip(known, others, strict=True) for r in relations]
