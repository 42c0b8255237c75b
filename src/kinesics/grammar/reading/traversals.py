"""The stretches between visits: which of them are the same path, as it is, backwards, mirrored or both."""

from __future__ import annotations

import bisect
import dataclasses
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, groupby, pairwise, product
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar.ground import Nearness
from kinesics.grammar.moments import Moments
from kinesics.grammar.reading.seen import Seen
from kinesics.grammar.reading.states import ReadState
from kinesics.grammar.reading.visits import Visit

BREAK: Final = -1
"""In place of a path, between the last visit of one recording and the first of the next."""
_AS_WELL: Final = 0.1
"""Of the distance up to which two traversals are one path: what fits so nearly as well as the best fits as well."""
_COMPARED: Final = 6
"""Traversals of a path, of each direction, that are compared with each other;"""
_UNLIKE: Final = 2.5
"""and so many times what lies between those of one direction parts the two directions."""


@dataclass(frozen=True)
class Traversal:
    """A stretch between two visits, as one of the paths."""

    start: int
    end: int
    path: int
    """-1 where one recording ends and the next begins between the visits."""
    reversed: bool
    mirrored: bool


@dataclass(frozen=True)
class ReadPath:
    """A path, up to its mirror image; its first traversal runs forwards and unmirrored."""

    from_: tuple[int, bool]
    """State, and whether its mirror image."""
    to: tuple[int, bool]
    symmetric: bool | None = None
    """Whether it is symmetric throughout, where the class of a cyclic movement tells."""


class Way(NamedTuple):
    """What the class of a cyclic movement tells of the way from one visit to the next."""

    key: tuple[int, int, int]
    """The cyclic stretch and the roles of the path's ends: ways of one key are one path."""
    reversed: bool
    mirrored: bool


class _Fit(NamedTuple):
    """A stretch is this path, done so."""

    path: int
    reversed: bool
    mirrored: bool

    def seen_from(self, way: Way) -> _Fit:
        """The same, the way there taken off or put on: to do so twice changes nothing."""
        return _Fit(self.path, self.reversed != way.reversed, self.mirrored != way.mirrored)


_End = tuple[int, bool]
"""State, and whether its mirror image."""


class _Paths:
    """The paths found so far, and what a stretch is among them."""

    def __init__(self, seen: Seen, states: Sequence[ReadState], near: Nearness) -> None:
        self.found: list[ReadPath] = []
        self._seen, self._states, self._near = seen, states, near
        self._first: list[tuple[int, int]] = []
        """The first traversal of each."""
        self._by_ends: dict[tuple[_End, _End], list[_Fit]] = {}

    def fit(self, a: Visit, b: Visit) -> _Fit | None:
        """The path between the same states that the stretch from one visit to another is nearest to; None where none is near."""
        trials = self._by_ends.get(((a.state, a.mirrored), (b.state, b.mirrored)), [])
        if not trials:
            return None
        others = [
            (self._first[k], [(trial.reversed, trial.mirrored) for trial in group])
            for k, group in groupby(trials, key=lambda trial: trial.path)
        ]
        costs = self._seen.distances((a.at, b.at), others)
        best = float(np.min(costs))
        if best >= self._near.path:
            return None
        # a path that is its own image fits more than one way: then it is taken as it is, not backwards or mirrored
        fits = [trial for trial, cost in zip(trials, costs, strict=True) if cost <= best + _AS_WELL * self._near.path]
        return min(fits, key=lambda trial: trial.reversed + trial.mirrored)

    def add(self, a: Visit, b: Visit, symmetric: bool | None) -> _Fit:
        """The stretch from one visit to another as a path of its own."""
        here, there = (a.state, a.mirrored), (b.state, b.mirrored)
        new = len(self.found)
        for reverse, mirror, ends in (
            (False, False, (here, there)),
            (True, False, (there, here)),
            (False, True, (self._image(here), self._image(there))),
            (True, True, (self._image(there), self._image(here))),
        ):
            self._by_ends.setdefault(ends, []).append(_Fit(new, reverse, mirror))
        self.found.append(ReadPath(here, there, symmetric))
        self._first.append((a.at, b.at))
        return _Fit(new, False, False)

    def _image(self, end: _End) -> _End:
        return end if self._states[end[0]].symmetric else (end[0], not end[1])


def traverse(
    seen: Seen,
    states: Sequence[ReadState],
    visits: Sequence[Visit],
    near: Nearness,
    ways: Mapping[int, Way],
    symmetric: Mapping[int, bool],
    breaks: Sequence[int],
) -> tuple[list[ReadPath], list[Traversal]]:
    """The stretches between visits, equal ones merged: the same, reversed, mirrored or both.

    Parameters
    ----------
    ways : by visit, what the class of a cyclic movement tells of the way to the next one: of those of one key the first occurrence
        alone is compared.
    symmetric : by cyclic stretch, whether it is symmetric throughout.
    breaks : moments at which another recording begins.
    """
    paths = _Paths(seen, states, near)
    known: dict[tuple[int, int, int], _Fit] = {}
    compared: set[int] = set()
    out: list[Traversal] = []
    for number, (a, b) in enumerate(pairwise(visits)):
        if any(a.at < border <= b.at for border in breaks):
            out.append(Traversal(a.at, b.at, BREAK, False, False))
            continue
        way = ways.get(number)
        if way is not None and way.key in known:
            fit = known[way.key].seen_from(way)
        else:
            nearest = paths.fit(a, b)
            if nearest is not None:
                compared.add(number)
            fit = nearest or paths.add(a, b, None if way is None else symmetric.get(way.key[0]))
            if way is not None:
                known[way.key] = fit.seen_from(way)
        out.append(Traversal(a.at, b.at, *fit))
    # once all paths are known, the nearest: what a stretch is must not depend on which others came before it
    for number in compared - ways.keys():
        nearest = paths.fit(visits[number], visits[number + 1])
        if nearest is not None:
            out[number] = Traversal(out[number].start, out[number].end, *nearest)
    return paths.found, out


def one_way(
    seen: Seen,
    visits: Sequence[Visit],
    paths: Sequence[ReadPath],
    traversals: Sequence[Traversal],
    near: Nearness,
    told: Collection[int],
) -> tuple[list[ReadPath], list[Traversal]]:
    """Paths of which going forth and coming back are much less alike than two goings forth, or two comings back, made two paths.

    How alike the traversals of one path are is a matter of the recording; that some go the other way must not add to it.

    Parameters
    ----------
    told : the traversals that the class of a cyclic movement tells the path of: it stays as it is.
    """
    paths, traversals = list(paths), list(traversals)
    for path in range(len(paths)):
        numbers = [n for n, t in enumerate(traversals) if t.path == path]
        if any(n in told for n in numbers):
            continue
        back = [n for n in numbers if traversals[n].reversed]
        alike: list[float] = []
        across: list[float] = []
        # within each recording: a copy of another says nothing of how alike the ways of a body are
        for _, same in groupby(numbers, key=lambda n: bisect.bisect_right(seen.breaks, traversals[n].start)):
            own = list(same)
            ways = [[n for n in own if traversals[n].reversed == side][:_COMPARED] for side in (False, True)]
            alike += [_cost(seen, traversals, a, b) for way in ways for a, b in combinations(way, 2)]
            across += [_cost(seen, traversals, a, b) for a, b in product(*ways)]
        if not alike or not across or float(np.median(across)) <= max(_UNLIKE * float(np.median(alike)), near.precise):
            continue
        first = back[0]
        here, there = visits[first], visits[first + 1]
        is_mirrored = traversals[first].mirrored
        for n in back:
            t = traversals[n]
            traversals[n] = Traversal(t.start, t.end, len(paths), False, t.mirrored != is_mirrored)
        paths.append(ReadPath((here.state, here.mirrored), (there.state, there.mirrored), paths[path].symmetric))
    return paths, traversals


def _cost(seen: Seen, traversals: Sequence[Traversal], a: int, b: int) -> float:
    """Mean distance, warped, of two traversals of one path."""
    one, other = traversals[a], traversals[b]
    relation = (one.reversed != other.reversed, one.mirrored != other.mirrored)
    return seen.distances((one.start, one.end), [((other.start, other.end), [relation])])[0]


def ends(
    moments: Moments,
    visits: Sequence[Visit],
    traversals: Sequence[Traversal],
    inside: NDArray[np.bool_],
    breaks: Sequence[int],
) -> tuple[dict[int, Traversal], dict[int, Traversal]]:
    """The paths of a cyclic movement that each recording begins and ends on, away from any state; by visit.

    Parameters
    ----------
    inside : whether each moment is part of a cyclic movement, shape (moments,).
    breaks : moments at which another recording begins.
    """
    leads: dict[int, Traversal] = {}
    tails: dict[int, Traversal] = {}
    for start, end in pairwise((0, *breaks, moments.count)):
        own = [k for k, v in enumerate(visits) if start <= v.at < end]
        if not own:
            continue
        first, last = own[0], own[-1]
        if visits[first].at > start and inside[start]:
            # whatever path arrives in that state later arrives in it now
            arriving = _beside(visits[first], traversals, visits[1:])
            if arriving is not None:
                leads[first] = dataclasses.replace(arriving, start=start, end=visits[first].at)
        if visits[last].at < end - 1 and inside[end - 1]:
            leaving = _beside(visits[last], traversals, visits[:-1])
            if leaving is not None:
                tails[last] = dataclasses.replace(leaving, start=visits[last].at, end=end - 1)
    return leads, tails


def _beside(visit: Visit, traversals: Sequence[Traversal], visits: Sequence[Visit]) -> Traversal | None:
    """The first traversal beside a visit, of those given one for each, to the same state on the same side of the mirror."""
    for t, v in zip(traversals, visits, strict=True):
        if t.path != BREAK and (v.state, v.mirrored) == (visit.state, visit.mirrored):
            return t
    return None
