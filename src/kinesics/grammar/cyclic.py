"""The states of a cyclic movement follow from its class: the dissertation's short studies (§3.5) as a rule.

| class | states | paths |
| --- | --- | --- |
| cyclic-asymmetric | A at the slowest moment | aa |
| cyclic-antiphase | A, and A* half a period later | aa*, (aa*)* |
| cyclic-symmetric | X at the slowest moment | xx |
| cyclic-palindromic | A and B, where it turns back | ab both ways |
| cyclic-symmetric-palindromic | X and Y, where it turns back | xy both ways |
| cyclic-antiphase-palindromic | A and A*, where it turns back; X, the symmetric pose between | ax both ways, (ax)* both ways |
| cyclic-antipalindromic | X and Y, the symmetric poses | xy, and its mirror image backwards |
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar.classes import SLOW_S
from kinesics.grammar.moments import Moments
from kinesics.vocabulary import MovementClass

C = MovementClass

_SLOW: Final = 0.15
"""Of the quickest tenth of a way: slower is standing."""
_STOPS: Final = 0.1
"""Of the ways: more with a stop make a choreography."""
_STOPPED: Final = 0.15
"""Of the middle half of a way."""


@dataclass(frozen=True)
class Anchor:
    """A moment at which a cyclic movement is in one of its states."""

    moment: int
    role: int
    """0 for the first state of its class, 1 for the second."""
    mirrored: bool
    symmetric: bool


@dataclass(frozen=True)
class Leg:
    """The movement from one anchor to the next."""

    key: tuple[int, int]
    """Roles of the path's ends in the direction in which it counts as forwards; legs of one key are one path."""
    reversed: bool
    mirrored: bool


@dataclass(frozen=True)
class Cyclic:
    """A stretch [start, end) of cyclic movement with its states in order."""

    start: int
    end: int
    anchors: tuple[Anchor, ...]
    legs: tuple[Leg, ...]
    """One fewer than anchors."""
    symmetric: bool
    """Whether the movement is symmetric at every moment."""


def structure(moments: Moments, start: int, end: int, class_: MovementClass, cuts: Sequence[int]) -> Cyclic | None:
    """The states of a cyclic stretch.

    None where there are too few cycles, the class is not cyclic, or the cycle has a stop of its own (a choreography that is
    repeated, such as the sun salutation): then its states are more than the class can tell.

    Parameters
    ----------
    cuts : moments at which cycles begin, in order, the end of the last one included.
    """
    cuts = [c for c in cuts if start <= c < end]
    if len(cuts) < 2 or float(np.mean(np.diff(cuts))) > SLOW_S * moments.fps:
        return None
    anchors: list[Anchor] = []
    legs: list[Leg] = []
    for a, b in pairwise(cuts):
        found = _cycle(moments, a, b, class_)
        if found is None:
            return None
        inside, ways = found
        anchors += inside
        legs += ways
    first = anchors[0]
    anchors.append(Anchor(cuts[-1], first.role, first.mirrored, first.symmetric))
    if any(b.moment <= a.moment for a, b in pairwise(anchors)) or _stops_between(moments, anchors):
        return None
    symmetric = class_ in (C.CYCLIC_SYMMETRIC, C.CYCLIC_SYMMETRIC_PALINDROMIC)
    return Cyclic(start, end, tuple(anchors), tuple(legs), symmetric)


def _stops_between(moments: Moments, anchors: Sequence[Anchor]) -> bool:
    """Whether the movement stops, for a good part of the way, between one state and the next."""
    stops = 0
    for a, b in pairwise(anchors):
        way = moments.speed[a.moment + 1 : b.moment + 1]
        middle = way[len(way) // 4 : len(way) - len(way) // 4]
        slow = np.count_nonzero(middle < _SLOW * np.quantile(way, 0.9)) if len(middle) else 0
        if slow > max(1, _STOPPED * len(middle)):
            stops += 1
    return stops > _STOPS * (len(anchors) - 1)


def _cycle(moments: Moments, a: int, b: int, class_: MovementClass) -> tuple[list[Anchor], list[Leg]] | None:
    """Anchors from the beginning of one cycle up to (not with) the next, and the legs that follow each of them."""
    if class_ is C.CYCLIC_ASYMMETRIC:
        return [Anchor(a, 0, False, False)], [Leg((0, 0), False, False)]
    if class_ is C.CYCLIC_SYMMETRIC:
        return [Anchor(a, 0, False, True)], [Leg((0, 0), False, False)]
    half = (a + b) / 2
    if class_ is C.CYCLIC_ANTIPHASE:
        image = _least(_to(moments, a, a, b)[1], half - a, b - a)
        return (
            [Anchor(a, 0, False, False), Anchor(a + image, 0, True, False)],
            [Leg((0, 0), False, False), Leg((0, 0), False, True)],
        )
    if class_ in (C.CYCLIC_PALINDROMIC, C.CYCLIC_SYMMETRIC_PALINDROMIC):
        symmetric = class_ is C.CYCLIC_SYMMETRIC_PALINDROMIC
        # where it turns back it is slowest, and farthest from where it turned back before
        turn = _least(-_to(moments, a, a, b)[0].astype(np.float64), half - a, b - a)
        return (
            [Anchor(a, 0, False, symmetric), Anchor(a + turn, 1, False, symmetric)],
            [Leg((0, 1), False, False), Leg((0, 1), True, False)],
        )
    symmetry = moments.symmetry[a:b]
    if class_ is C.CYCLIC_ANTIPHASE_PALINDROMIC:
        image = _least(_to(moments, a, a, b)[1], half - a, b - a)
        one = _least(symmetry[:image], image / 2, image)
        other = image + _least(symmetry[image:], (b - a - image) / 2, b - a - image)
        return (
            [
                Anchor(a, 0, False, False),
                Anchor(a + one, 1, False, True),
                Anchor(a + image, 0, True, False),
                Anchor(a + other, 1, False, True),
            ],
            [
                Leg((0, 1), False, False),
                Leg((0, 1), True, True),
                Leg((0, 1), False, True),
                Leg((0, 1), True, False),
            ],
        )
    if class_ is C.CYCLIC_ANTIPALINDROMIC:
        first = _least(symmetry, 0.25 * (b - a), b - a)
        # the other symmetric pose lies half a period on
        second = _least(np.roll(symmetry, -first), 0.5 * (b - a), b - a)
        one, two = sorted((first, (first + second) % (b - a)))
        return (
            [Anchor(a + one, 0, False, True), Anchor(a + two, 1, False, True)],
            [Leg((0, 1), False, False), Leg((0, 1), True, True)],
        )
    return None


def _to(moments: Moments, at: int, start: int, end: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    d, s = moments.tile(slice(at, at + 1), slice(start, end))
    return d[0], s[0]


def _least(values: NDArray[np.floating], middle: float, length: int) -> int:
    """Where the values are least within a quarter of the length around a place where that is expected."""
    low = max(1, int(np.ceil(middle - length / 4)))
    high = min(len(values) - 1, int(np.floor(middle + length / 4)))
    if high < low:
        return min(max(1, round(middle)), max(1, len(values) - 1))
    return low + int(np.argmin(values[low : high + 1]))
