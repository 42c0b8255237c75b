"""The motion graph read from a recording (§3.5-3.6): which moments are states, which stretches are the same path.

The dissertation drew its graphs by eye. Here the recording draws a map of itself (`kinesics.grammar.ground`) and is read as a
string: marked moments that lie together under D, or under D*, are one state or a mirrored pair; the times at which the movement
is in a state are visits; the stretches between are compared with each other with tempo freedom and merged.

A state that leaves no trace (one way in, one way out, no stop, no turning back, not symmetric) is none.
"""

from __future__ import annotations

import bisect
import dataclasses
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, groupby, pairwise, product
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.grammar import bias, ground
from kinesics.grammar.cyclic import Cyclic
from kinesics.grammar.ground import Mark, Nearness
from kinesics.grammar.linkage import clusters
from kinesics.grammar.moments import Moments
from kinesics.progress import Progress, silent
from kinesics.similarity import chord

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

BREAK: Final = -1
"""In place of a path, between the last visit of one recording and the first of the next."""


_AS_WELL: Final = 0.1
"""Of the distance up to which two traversals are one path: what fits so nearly as well as the best fits as well."""


_COMPARED: Final = 6
"""Traversals of a path, of each direction, that are compared with each other;"""
_UNLIKE: Final = 2.5
"""and so many times what lies between those of one direction parts the two directions."""


_CHIRAL: Final = 4.0
"""A pose with so many times the D*(a, a) of what still counts as symmetric is clearly not."""
_BIASED: Final = 2.0
"""A bias may double what counts as symmetric: both bones of a forearm turned by 40° against the other's make .008 of D*."""
_APART: Final = 4.0
"""No √(2D) is so large."""


class Visit(NamedTuple):
    """The movement is in a state."""

    start: int
    end: int
    """Exclusive."""
    at: int
    """The moment nearest to the state."""
    state: int
    mirrored: bool


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
class ReadState:
    """A state, up to its mirror image."""

    moment: int
    """A moment at which the movement is in it, unmirrored."""
    symmetric: bool
    traced: bool
    """Whether the movement stops or turns back there."""


@dataclass(frozen=True)
class ReadPath:
    """A path, up to its mirror image; its first traversal runs forwards and unmirrored."""

    from_: tuple[int, bool]
    """State, and whether its mirror image."""
    to: tuple[int, bool]
    symmetric: bool | None = None
    """Whether it is symmetric throughout, where the class of a cyclic movement tells."""


@dataclass(frozen=True)
class Reading:
    """States, paths, and the recording as a string of them."""

    states: tuple[ReadState, ...]
    paths: tuple[ReadPath, ...]
    visits: tuple[Visit, ...]
    traversals: tuple[Traversal, ...]
    """One fewer than visits."""
    nearness: Nearness
    leads: Mapping[int, Traversal] = field(default_factory=dict)
    """By visit: where a recording begins on the way of a cyclic movement, the path to its first visit, begun before."""
    tails: Mapping[int, Traversal] = field(default_factory=dict)
    """By visit: where a recording ends on the way of a cyclic movement, the path from its last visit, not ended."""


def _cluster(moments: Moments, marks: Sequence[Mark], radius: float, symmetric: float = 0.0) -> list[list[Mark]]:
    """Marks that lie together under D or D*: complete linkage of √(2D). A symmetric pose is none with a clearly chiral one.

    Time and memory grow with the square of the marks. Of very many, those that lie closest together are taken as one first.
    """
    limit = float(np.sqrt(2.0 * radius))
    index, place = np.unique([m.moment for m in marks], return_inverse=True)
    reach = _CLOSEST * limit
    while len(index) > _MOST_MARKS:
        leader = _leaders(moments, index, reach, symmetric)
        kept, numbers = np.unique(leader, return_inverse=True)
        index, place = index[kept], numbers[place]
        reach *= 1.5
    labels = _complete_linkage(moments, index, limit, symmetric)[place]
    groups: dict[int, list[Mark]] = {}
    for mark, label in zip(marks, labels.tolist(), strict=True):
        groups.setdefault(label, []).append(mark)
    return sorted(groups.values(), key=lambda g: min(m.moment for m in g))


def _chords(moments: Moments, rows: NDArray[np.intp], columns: NDArray[np.intp], symmetric: float) -> Array:
    """√(2D) or √(2D*), whichever is less; of a symmetric and a clearly chiral pose more than any."""
    out = chord(np.minimum(*moments.between(rows, columns)))
    one, other = moments.symmetry[rows][:, None], moments.symmetry[columns][None, :]
    unlike = (np.minimum(one, other) < symmetric) & (np.maximum(one, other) > _CHIRAL * symmetric)
    return np.where(unlike, _APART, out)


def _complete_linkage(moments: Moments, index: NDArray[np.intp], limit: float, symmetric: float) -> NDArray[np.intp]:
    """Number of the cluster of each moment: no two in a cluster are further apart than ``limit``."""
    count = len(index)
    if count <= _FEW_MARKS:
        upper = np.triu(_chords(moments, index, index, symmetric), 1)
        return clusters(upper + upper.T, limit, "complete")
    from scipy.cluster.hierarchy import fcluster, linkage

    condensed = np.empty(count * (count - 1) // 2)
    step = max(1, _CELLS // count)
    end = 0
    for first in range(0, count, step):
        part = _chords(moments, index[first : first + step], index[first:], symmetric)
        for k, row in enumerate(part):
            condensed[end : end + len(row) - k - 1] = row[k + 1 :]
            end += len(row) - k - 1
    return np.asarray(fcluster(linkage(condensed, "complete"), limit, "distance"), dtype=np.intp)


def _leaders(moments: Moments, index: NDArray[np.intp], reach: float, symmetric: float) -> NDArray[np.intp]:
    """For each moment the first one, itself perhaps, that leads and lies within ``reach``; who has none leads."""
    out = np.full(len(index), -1, dtype=np.intp)
    leading: list[int] = []
    step = max(1, _CELLS // len(index))
    for first in range(0, len(index), step):
        part = index[first : first + step]
        if leading:
            apart = _chords(moments, part, index[leading], symmetric)
            nearest = apart.argmin(axis=1)
            led = apart[np.arange(len(part)), nearest] <= reach
            out[first : first + step][led] = np.array(leading)[nearest[led]]
        alone = np.flatnonzero(out[first : first + step] < 0)
        own = _chords(moments, part[alone], part[alone], symmetric) <= reach
        own[np.diag_indices(len(alone))] = True
        for k, row in zip(alone.tolist(), own, strict=True):
            if out[first + k] < 0:
                leading.append(first + k)
                followers = alone[row]
                out[first + followers[out[first + followers] < 0]] = first + k
    return out


def _without_bias(moments: Moments, near: Nearness, breaks: Sequence[int]) -> Moments:
    """The same moments, what keeps them from symmetry being no constant difference of left and right (`kinesics.grammar.bias`).

    Only of poses that are nearly symmetric as they are: in a recording of few poses the estimate holds some of their asymmetry, and
    no pose that is clearly chiral may become symmetric by it.
    """
    if moments.poses is None:
        return moments
    symmetry = moments.symmetry.copy()
    for start, end in pairwise((0, *breaks, moments.count)):
        part = moments.cut(start, end)
        estimate = bias.estimate(part)
        assert estimate is not None
        fair = np.minimum(part.symmetry, bias.without(part, estimate).symmetry)
        symmetry[start:end] = np.where(part.symmetry <= _BIASED * near.symmetric, fair, part.symmetry)
    return dataclasses.replace(moments, symmetry=symmetry)


def _state_of(moments: Moments, group: Sequence[Mark], near: Nearness) -> ReadState:
    """The middle of a cluster, of its traced moments where there are any."""
    traced = [m for m in group if m.traced]
    middle = np.array([m.moment for m in (traced or group)])
    every = np.array([m.moment for m in group])
    step = max(1, _CELLS // len(every))
    means = [
        np.minimum(*moments.between(middle[first : first + step], every)).mean(axis=1)
        for first in range(0, len(middle), step)
    ]
    moment = int(middle[np.concatenate(means).argmin()])
    symmetric = float(np.median(moments.symmetry[middle])) <= near.symmetric
    return ReadState(moment, symmetric, bool(traced))


def _refined(moments: Moments, states: Sequence[ReadState], near: Nearness, breaks: Sequence[int]) -> list[ReadState]:
    """States that are only passed, put where the ways cross: at the moment near by that most passages come closest to.

    Ways join early and part late, so the marks lie to either side of the state.
    """
    reach = max(1, round(ground.PARTING_S * moments.fps))
    everything = np.arange(moments.count)
    out = []
    for state in states:
        if state.traced:
            out.append(state)
            continue
        first, last = _recording_of(state.moment, moments.count, breaks)
        around = np.arange(max(first, state.moment - reach), min(last, state.moment + reach + 1))
        close = around[moments.between(np.array([state.moment]), around)[0][0] < near.state]
        exact = max(near.same, 0.005 * near.spread)
        best = (0, -np.inf)
        moment = state.moment
        for candidate, *rows in zip(close.tolist(), *moments.between(close, everything), strict=True):
            depths = [
                ground.deepest(row[start:end]) for row in rows for start, end in _split(_below(row, near.visit), breaks)
            ]
            through = [x for x in depths if x < exact]
            score = (len(through), -float(np.mean(through)) if through else -np.inf)
            if score > best:
                best, moment = score, candidate
        out.append(ReadState(moment, state.symmetric, False))
    return _distinct(moments, out, near)


def _distinct(moments: Moments, states: Sequence[ReadState], near: Nearness) -> list[ReadState]:
    """Of states that have come to lie in one place, the first traced one, else the first."""
    index = np.array([s.moment for s in states], dtype=np.intp)
    d, s = moments.between(index, index)
    apart = np.minimum(d, s)
    kept: list[int] = []
    for k in sorted(range(len(states)), key=lambda k: (not states[k].traced, states[k].moment)):
        if all(apart[k, o] >= 2 * near.visit for o in kept):
            kept.append(k)
    return [states[k] for k in sorted(kept)]


def _recording_of(moment: int, count: int, breaks: Sequence[int]) -> tuple[int, int]:
    """The range [start, end) of the recording that a moment is of."""
    k = bisect.bisect_right(breaks, moment)
    return (0, *breaks)[k], (*breaks, count)[k]


def _split(stretches: Iterable[tuple[int, int]], breaks: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Cut stretches where another recording begins."""
    for start, end in stretches:
        borders = [start, *(b for b in breaks if start < b < end), end]
        yield from pairwise(borders)


def _below(row: Floats, limit: float) -> list[tuple[int, int]]:
    inside = np.concatenate([[False], row < limit, [False]])
    edges = np.flatnonzero(inside[1:] != inside[:-1])
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


class _Seen:
    """What a recording was already asked for while states come and go: when it passes a pose, how far apart stretches are."""

    def __init__(self, moments: Moments, radius: float, breaks: Sequence[int]) -> None:
        self.moments, self.radius, self.breaks = moments, radius, breaks
        self._passages: dict[tuple[int, bool], tuple[list[_Passage], list[_Passage]]] = {}
        self._warped: dict[tuple[int, int, int, int], dict[tuple[bool, bool], float]] = {}

    def passages(self, states: Sequence[ReadState]) -> list[tuple[list[_Passage], list[_Passage]]]:
        """When the movement passes each state, and when its mirror image: never, where the state is symmetric.

        A symmetric state is passed when either it or its mirror image is, for nobody is exactly symmetric.
        """
        wanted = [(s.moment, s.symmetric) for s in states]
        new = [key for key in dict.fromkeys(wanted) if key not in self._passages]
        everything = np.arange(self.moments.count)
        step = max(1, _CELLS // self.moments.count)
        for first in range(0, len(new), step):
            part = new[first : first + step]
            blocks = self.moments.between(np.array([moment for moment, _ in part]), everything)
            for key, straight, image in zip(part, *blocks, strict=True):
                if key[1]:
                    self._passages[key] = [*self._passed(np.minimum(straight, image))], []
                else:
                    self._passages[key] = [*self._passed(straight)], [*self._passed(image)]
        return [self._passages[key] for key in wanted]

    def _passed(self, row: Floats) -> Iterator[_Passage]:
        # in at the radius, out at three times it: noise must not make two visits of one
        for start, end in _split(_below(row, 3 * self.radius), self.breaks):
            at = start + int(row[start:end].argmin())
            if row[at] < self.radius:
                near = np.flatnonzero(row[start:end] < self.radius)
                yield _Passage(start + int(near[0]), start + int(near[-1]) + 1, at, float(row[at]))

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
            points = [_points(*others[k][0]) for k, _ in missing]
            d, s = self.moments.between(_points(*stretch), np.concatenate(points))
            asked = [(k, place, r) for place, (k, relations) in enumerate(missing) for r in relations]
            blocks = []
            for _, place, (backwards, mirrored) in asked:
                block = (s if mirrored else d)[:, place * _POINTS : (place + 1) * _POINTS]
                blocks.append(block[:, ::-1] if backwards else block)
            for (k, _, relation), cost in zip(asked, warped(np.stack(blocks)).tolist(), strict=True):
                known[k][relation] = cost
        return [costs[r] for costs, (_, relations) in zip(known, others, strict=True) for r in relations]


class _Passage(NamedTuple):
    """The movement is near a pose."""

    start: int
    end: int
    at: int
    depth: float
    """Least distance."""


def _visits(seen: _Seen, states: Sequence[ReadState]) -> list[Visit]:
    """All times at which the movement is in a state; where two claim it, the nearer one's."""
    found: list[tuple[Visit, float]] = []
    for k, passages in enumerate(seen.passages(states)):
        for is_mirrored, passed in zip((False, True), passages, strict=True):
            found += [(Visit(p.start, p.end, p.at, k, is_mirrored), p.depth) for p in passed]
    found.sort(key=lambda v: (v[0].at, v[1]))
    out: list[tuple[Visit, float]] = []
    for visit, depth in found:
        if out and visit.start < out[-1][0].end:
            before, its_depth = out[-1]
            if (before.state, before.mirrored) == (visit.state, visit.mirrored):
                continue
            if before.state == visit.state and visit.at - before.at < ground.STOP_S * seen.moments.fps:
                # a pose nearer to its mirror image than a state is wide: a stop is a stay in one of them, not a way between
                start, end = before.start, max(before.end, visit.end)
                nearer, least = (visit, depth) if depth < its_depth else (before, its_depth)
                out[-1] = (nearer._replace(start=start, end=end), least)
                continue
            if visit.at - before.at >= 3:
                border = (before.at + visit.at + 1) // 2
                out[-1] = (before._replace(end=min(before.end, border)), its_depth)
                out.append((visit._replace(start=max(visit.start, border)), depth))
                continue
            if depth < its_depth:
                out[-1] = (visit, depth)
            continue
        out.append((visit, depth))
    return [v for v, _ in out]


_POINTS: Final = 24
_CELLS: Final = 4_000_000
"""Distances that are asked for at once."""
_FEW_MARKS: Final = 500
"""So many are clustered sooner than SciPy is imported."""
_MOST_MARKS: Final = 6000
"""Marks that are compared all with all: what ten minutes have."""
_CLOSEST: Final = 0.25
"""Of very many marks, those nearer than this share of what makes a state are one."""


def _points(start: int, end: int) -> NDArray[np.intp]:
    """Moments evenly spaced over a stretch, its ends included."""
    return np.linspace(start, end, _POINTS).round().astype(np.intp)


def warped(blocks: Floats) -> Array:
    """Mean distance along the best monotone way from corner to corner, for many square blocks at once. (b, p, p) to (b,)."""
    count, p, _ = blocks.shape
    if compiled.wanted():
        out = np.empty(count)
        compiled.native.warped(np.ascontiguousarray(blocks), out)
        return out
    total = np.full((count, p + 1, p + 1), np.inf)
    total[:, 0, 0] = 0.0
    for i in range(p):
        for j in range(p):
            here = blocks[:, i, j]
            total[:, i + 1, j + 1] = here + np.minimum(
                total[:, i, j] + here, np.minimum(total[:, i, j + 1], total[:, i + 1, j])
            )
    return np.asarray(total[:, p, p] / (2 * p))


def _traverse(
    seen: _Seen,
    states: Sequence[ReadState],
    visits: Sequence[Visit],
    near: Nearness,
    keys: Mapping[int, tuple[tuple[int, int, int], bool, bool]],
    symmetric: Mapping[int, bool],
    breaks: Sequence[int],
) -> tuple[list[ReadPath], list[Traversal]]:
    """The stretches between visits, equal ones merged: the same, reversed, mirrored or both.

    Where the class of a cyclic movement tells which path a stretch is (``keys``), its first occurrence alone is compared.
    """
    known: dict[tuple[int, int, int], Traversal] = {}
    compared: set[int] = set()
    paths: list[ReadPath] = []
    shapes: list[tuple[int, int]] = []
    by_ends: dict[tuple[tuple[int, bool], tuple[int, bool]], list[tuple[int, bool, bool]]] = {}
    out: list[Traversal] = []

    def image(end: tuple[int, bool]) -> tuple[int, bool]:
        return end if states[end[0]].symmetric else (end[0], not end[1])

    def note(number: int, path: int, backwards: bool, mirrored: bool) -> Traversal:
        a, b = visits[number], visits[number + 1]
        taken = Traversal(a.at, b.at, path, backwards, mirrored)
        if number in keys:
            key, way_back, way_mirrored = keys[number]
            known.setdefault(key, Traversal(a.at, b.at, path, backwards != way_back, mirrored != way_mirrored))
        return taken

    def best_fit(a: Visit, b: Visit) -> tuple[int, bool, bool] | None:
        trials = by_ends.get(((a.state, a.mirrored), (b.state, b.mirrored)), [])
        if not trials:
            return None
        others = [
            (shapes[k], [(reverse, mirror) for _, reverse, mirror in group])
            for k, group in groupby(trials, key=lambda trial: trial[0])
        ]
        costs = seen.distances((a.at, b.at), others)
        best = float(np.min(costs))
        if best >= near.path:
            return None
        # a path that is its own image fits more than one way: then it is taken as it is, not backwards or mirrored
        fits = [trial for trial, cost in zip(trials, costs, strict=True) if cost <= best + _AS_WELL * near.path]
        return min(fits, key=lambda trial: trial[1] + trial[2])

    for number, (a, b) in enumerate(pairwise(visits)):
        if any(a.at < border <= b.at for border in breaks):
            out.append(Traversal(a.at, b.at, BREAK, False, False))
            continue
        if number in keys and keys[number][0] in known:
            key, way_back, way_mirrored = keys[number]
            model = known[key]
            out.append(note(number, model.path, model.reversed != way_back, model.mirrored != way_mirrored))
            continue
        here, there = (a.state, a.mirrored), (b.state, b.mirrored)
        fit = best_fit(a, b)
        if fit is not None:
            compared.add(number)
            out.append(note(number, *fit))
            continue
        told = symmetric.get(keys[number][0][0]) if number in keys else None
        for reverse, mirror, ends in (
            (False, False, (here, there)),
            (True, False, (there, here)),
            (False, True, (image(here), image(there))),
            (True, True, (image(there), image(here))),
        ):
            by_ends.setdefault(ends, []).append((len(paths), reverse, mirror))
        paths.append(ReadPath(here, there, told))
        shapes.append((a.at, b.at))
        out.append(note(number, len(paths) - 1, False, False))
    # once all paths are known, the nearest: what a stretch is must not depend on which others came before it
    for number in compared - keys.keys():
        fit = best_fit(visits[number], visits[number + 1])
        if fit is not None:
            out[number] = Traversal(out[number].start, out[number].end, *fit)
    return paths, out


def _one_way(
    seen: _Seen,
    visits: Sequence[Visit],
    paths: Sequence[ReadPath],
    traversals: Sequence[Traversal],
    near: Nearness,
    keys: Collection[int],
) -> tuple[list[ReadPath], list[Traversal]]:
    """Paths of which going forth and coming back are much less alike than two goings forth, or two comings back, made two paths.

    How alike the traversals of one path are is a matter of the recording; that some go the other way must not add to it.
    """
    paths, traversals = list(paths), list(traversals)
    for path in range(len(paths)):
        numbers = [n for n, t in enumerate(traversals) if t.path == path]
        if any(n in keys for n in numbers):
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


def _cost(seen: _Seen, traversals: Sequence[Traversal], a: int, b: int) -> float:
    """Mean distance, warped, of two traversals of one path."""
    one, other = traversals[a], traversals[b]
    relation = (one.reversed != other.reversed, one.mirrored != other.mirrored)
    return seen.distances((one.start, one.end), [((other.start, other.end), [relation])])[0]


_PathEnd = tuple[int, bool, bool]
"""Which path, whether its far end, and on which side of the mirror."""


def _traceless(states: Sequence[ReadState], visits: Sequence[Visit], traversals: Sequence[Traversal]) -> set[int]:
    """States with one way in and one way out, no stop, no turning back, not symmetric.

    Who passes a symmetric pose leaves a trace there, unless all of his movement is symmetric: then no pose is a state for being so.
    """
    ways: dict[int, set[frozenset[_PathEnd]]] = {k: set() for k in range(len(states))}
    ends: dict[int, set[_PathEnd]] = {k: set() for k in range(len(states))}
    for visit, before, after in zip(visits[1:-1], traversals[:-1], traversals[1:], strict=True):
        if BREAK in (before.path, after.path):
            continue  # no way through: as at the beginning and at the end of a recording by itself
        # an end of a path: which path, which of its ends, and on which side of the mirror, seen from the unmirrored state
        arriving = (before.path, not before.reversed, before.mirrored != visit.mirrored)
        leaving = (after.path, after.reversed, after.mirrored != visit.mirrored)
        way = frozenset((arriving, leaving))
        if states[visit.state].symmetric:
            # its mirror image is the same way: a recording read with its mirror image has no more states for it
            way = min(way, frozenset((path, far, not side) for path, far, side in way), key=sorted)
        ways[visit.state].add(way)
        ends[visit.state].update(way)
    return {
        k
        for k, state in enumerate(states)
        if not state.traced and ((len(ends[k]) == 2 and len(ways[k]) == 1) or _only_touched(ends[k], ways[k]))
    }


def _only_touched(ends: Collection[_PathEnd], ways: Collection[frozenset[_PathEnd]]) -> bool:
    """Whether a way always comes past the same place twice and never turns off there: in, round a loop, out by another path."""
    loops = {(path, side) for path, far, side in ends if (path, not far, side) in ends}
    if len(ends) != 4 or len(ways) != 2 or len(loops) != 1:
        return False
    return all(len(way) == 2 and sum((path, side) in loops for path, _, side in way) == 1 for way in ways)


def held(moments: Moments, reading: Reading) -> list[tuple[int, int] | None]:
    """For each visit the stretch [start, end) in which the pose is held, or None."""
    least = max(2, round(ground.STOP_S * moments.fps))
    out: list[tuple[int, int] | None] = []
    for visit in reading.visits:
        around = np.arange(visit.start, visit.end)
        near = moments.between(np.array([visit.at]), around)[0][0] < 0.6 * reading.nearness.same
        k = visit.at - visit.start
        low = high = k
        while low > 0 and near[low - 1]:
            low -= 1
        while high + 1 < len(near) and near[high + 1]:
            high += 1
        out.append((visit.start + low, visit.start + high + 1) if high - low >= least else None)
    return out


def self_symmetry(moments: Moments, stretches: Sequence[tuple[int, int]]) -> tuple[float, float]:
    """Mean distance of stretches from their mirror images, and from their mirror images played backwards (warped)."""
    blocks = []
    for start, end in stretches:
        points = _points(start, end)
        blocks.append(moments.between(points, points)[1])
    s = np.stack(blocks)
    return float(np.diagonal(s, axis1=1, axis2=2).mean()), float(warped(s[:, :, ::-1]).mean())


def _shadows(
    moments: Moments, states: Sequence[ReadState], visits: Sequence[Visit], near: Nearness, breaks: Sequence[int]
) -> set[int]:
    """States that are only the slow parting or joining of ways at another: always just before or after it, and close by."""
    index = np.array([s.moment for s in states], dtype=np.intp)
    d, s = moments.between(index, index)
    apart = np.minimum(d, s)
    reach = 2 * ground.PARTING_S * moments.fps
    out: set[int] = set()
    recording = [bisect.bisect_right(breaks, v.at) for v in visits]
    visited: list[list[int]] = [[] for _ in states]
    for i, visit in enumerate(visits):
        visited[visit.state].append(i)
    for k, state in enumerate(states):
        if state.traced:
            continue
        places = visited[k]
        beside: dict[int, int] = {}
        for i in places:
            for o in {
                visits[j].state
                for j in (i - 1, i + 1)
                if 0 <= j < len(visits)
                and recording[j] == recording[i]
                and abs(visits[j].at - visits[i].at) <= reach
                and visits[j].state != k
            }:
                beside[o] = beside.get(o, 0) + 1
        if any(
            count >= 0.8 * len(places) and apart[k, o] < 2.5 * near.state and o not in out
            for o, count in beside.items()
        ):
            out.add(k)
    return out


_Roles = dict[tuple[int, int], tuple[int, bool]]
"""(cyclic stretch, role) to state, and whether what is unmirrored in the stretch is the state's mirror image."""


def _with_cyclic(
    moments: Moments, states: list[ReadState], cyclic: Sequence[Cyclic], near: Nearness
) -> tuple[list[ReadState], _Roles]:
    """Add the states of the cyclic stretches; where one lies in a state that is there already, it is that one."""
    roles: _Roles = {}
    for number, stretch in enumerate(cyclic):
        for role in sorted({a.role for a in stretch.anchors}):
            of_role = [a for a in stretch.anchors if a.role == role]
            side = all(a.mirrored for a in of_role)
            index = np.array([a.moment for a in of_role if a.mirrored == side], dtype=np.intp)
            symmetric = next(a.symmetric for a in stretch.anchors if a.role == role)
            d, _ = moments.between(index, index)
            moment = int(index[d.mean(axis=1).argmin()])
            taken = [k for (n, _), (k, _) in roles.items() if n == number]
            candidates = [k for k, s in enumerate(states) if s.symmetric == symmetric and k not in taken]
            if candidates:
                there = np.array([states[k].moment for k in candidates], dtype=np.intp)
                straight, image = (block[0] for block in moments.between(np.array([moment]), there))
                distances = np.minimum(straight, image)
                best = int(distances.argmin())
                if distances[best] < near.state:
                    is_mirrored = bool(not symmetric and image[best] < straight[best])
                    roles[number, role] = candidates[best], is_mirrored != side
                    continue
            roles[number, role] = len(states), side
            states = [*states, ReadState(moment, symmetric, True)]
    return states, roles


def _without(states: Sequence[ReadState], roles: _Roles, gone: set[int]) -> tuple[list[ReadState], _Roles]:
    kept = [k for k in range(len(states)) if k not in gone]
    number = {k: i for i, k in enumerate(kept)}
    return [states[k] for k in kept], {role: (number[k], side) for role, (k, side) in roles.items()}


def _cyclic_visits(
    visits: list[Visit], cyclic: Sequence[Cyclic], roles: _Roles
) -> tuple[list[Visit], dict[int, tuple[tuple[int, int, int], bool, bool]]]:
    """Visits with those of the cyclic stretches among them; and what is known of the way from a visit to the next one."""
    keyed: list[tuple[Visit, tuple[tuple[int, int, int], bool, bool] | None]] = [(v, None) for v in visits]
    for number, stretch in enumerate(cyclic):
        ways = [((number, *leg.key), leg.reversed, leg.mirrored) for leg in stretch.legs]
        for anchor, way in zip(stretch.anchors, [*ways, None], strict=True):
            state, side = roles[number, anchor.role]
            visit = Visit(anchor.moment, anchor.moment + 1, anchor.moment, state, anchor.mirrored != side)
            keyed.append((visit, way))
    keyed.sort(key=lambda item: item[0].at)
    return [v for v, _ in keyed], {k: way for k, (_, way) in enumerate(keyed) if way is not None}


def _without_visit(visits: Sequence[Visit], count: int, breaks: Sequence[int]) -> tuple[int, int] | None:
    """The first recording, moments [start, end), that is in no state at all."""
    places = sorted(v.at for v in visits)
    for start, end in pairwise((0, *breaks, count)):
        if bisect.bisect_left(places, start) == bisect.bisect_left(places, end):
            return start, end
    return None


def _ends(
    moments: Moments,
    visits: Sequence[Visit],
    traversals: Sequence[Traversal],
    inside: NDArray[np.bool_],
    breaks: Sequence[int],
) -> tuple[dict[int, Traversal], dict[int, Traversal]]:
    """The paths of a cyclic movement that each recording begins and ends on, away from any state."""
    leads: dict[int, Traversal] = {}
    tails: dict[int, Traversal] = {}
    for start, end in pairwise((0, *breaks, moments.count)):
        own = [k for k, v in enumerate(visits) if start <= v.at < end]
        if not own:
            continue
        first, last = own[0], own[-1]
        if visits[first].at > start and inside[start]:
            # whatever path arrives in that state later arrives in it now
            here = (visits[first].state, visits[first].mirrored)
            for t, v in zip(traversals, visits[1:], strict=True):
                if t.path != BREAK and (v.state, v.mirrored) == here:
                    leads[first] = Traversal(start, visits[first].at, t.path, t.reversed, t.mirrored)
                    break
        if visits[last].at < end - 1 and inside[end - 1]:
            here = (visits[last].state, visits[last].mirrored)
            for t, v in zip(traversals, visits[:-1], strict=True):
                if t.path != BREAK and (v.state, v.mirrored) == here:
                    tails[last] = Traversal(visits[last].at, end - 1, t.path, t.reversed, t.mirrored)
                    break
    return leads, tails


def read(
    moments: Moments, cyclic: Sequence[Cyclic] = (), progress: Progress = silent, *, breaks: Sequence[int] = ()
) -> Reading:
    """Read states and paths from a recording, or from several put one after the other.

    Parameters
    ----------
    cyclic : stretches whose states follow from their class (see `kinesics.grammar.cyclic`), in order, not overlapping.
    breaks : moments at which another recording begins.
    """
    near = ground.judge_nearness(moments, breaks)
    inside = np.zeros(moments.count, dtype=np.bool_)
    for stretch in cyclic:
        first, last = stretch.anchors[0].moment, stretch.anchors[-1].moment
        # what leads up to the first state and away from the last one within the cyclic movement is part of it
        inside[min(stretch.start, first) : max(stretch.end, last + 1)] = True
    marks: list[Mark] = []
    if not inside.all():
        marks = [m for m in ground.all_marks(moments, near, breaks, progress) if not inside[m.moment]]
    fair = _without_bias(moments, near, breaks)
    groups = _cluster(fair, marks, near.state, near.centred) if marks else []
    states = [_state_of(fair, group, near) for group in groups]
    states = _refined(moments, states, near, breaks) if states else []
    states, roles = _with_cyclic(moments, states, cyclic, near)
    fixed = {k for k, _ in roles.values()}
    symmetric = {number: stretch.symmetric for number, stretch in enumerate(cyclic)}
    seen = _Seen(moments, near.visit, breaks)
    while True:
        if not states:
            # a cycle without stop, turning back or parting of ways has its state at its slowest moment
            slowest = int(moments.speed.argmin())
            states = [_state_of(fair, [Mark(slowest, True)], near)]
        visits = [v for v in _visits(seen, states) if not inside[v.at]]
        visits, keys = _cyclic_visits(visits, cyclic, roles)
        nowhere = _without_visit(visits, moments.count, breaks)
        if nowhere is not None:
            # so has each of several recordings; one at a time, for the others may pass there
            slowest = nowhere[0] + int(moments.speed[slice(*nowhere)].argmin())
            states = [*states, _state_of(fair, [Mark(slowest, True)], near)]
            continue
        shadows = _shadows(moments, states, visits, near, breaks) - fixed
        if shadows:
            states, roles = _without(states, roles, shadows)
            fixed = {k for k, _ in roles.values()}
            continue
        paths, traversals = _traverse(seen, states, visits, near, keys, symmetric, breaks)
        paths, traversals = _one_way(seen, visits, paths, traversals, near, keys)
        visited = {v.state for v in visits}
        drop = (_traceless(states, visits, traversals) | (set(range(len(states))) - visited)) - fixed
        if not drop:
            break
        # one at a time: two neighbours without trace may be each other's only trace
        states, roles = _without(states, roles, {min(drop)})
        fixed = {k for k, _ in roles.values()}
    leads, tails = _ends(moments, visits, traversals, inside, breaks)
    return Reading(tuple(states), tuple(paths), tuple(visits), tuple(traversals), near, leads, tails)
