"""A recording, or several put one after the other, as a string of states and paths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar import ground
from kinesics.grammar.cyclic import Cyclic
from kinesics.grammar.ground import Mark, Nearness
from kinesics.grammar.moments import Moments
from kinesics.grammar.reading.seen import Seen
from kinesics.grammar.reading.states import ReadState, found_states, state_of, without_bias
from kinesics.grammar.reading.traces import shadow_states, traceless_states
from kinesics.grammar.reading.traversals import ReadPath, Traversal, ends, one_way, traverse
from kinesics.grammar.reading.visits import Visit, find_visits, without_visit
from kinesics.grammar.reading.weaving import cyclic_visits, with_cyclic, without_states
from kinesics.progress import Progress, silent


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
    inside = _inside(cyclic, moments.count)
    fair = without_bias(moments, near, breaks)
    marks: list[Mark] = []
    if not inside.all():
        marks = [m for m in ground.all_marks(moments, near, breaks, progress) if not inside[m.moment]]
    states, roles = with_cyclic(moments, found_states(moments, fair, marks, near, breaks), cyclic, near)
    symmetric = {number: stretch.symmetric for number, stretch in enumerate(cyclic)}
    seen = Seen(moments, near.visit, breaks)

    def slowest(start: int, end: int) -> ReadState:
        """A movement without stop, turning back or parting of ways has its state at its slowest moment."""
        return state_of(fair, [Mark(start + int(moments.speed[start:end].argmin()), True)], near)

    # states come and go until every recording is in one and each leaves a trace
    while True:
        fixed = {k for k, _ in roles.values()}
        states = states or [slowest(0, moments.count)]
        visits, ways = cyclic_visits([v for v in find_visits(seen, states) if not inside[v.at]], cyclic, roles)
        nowhere = without_visit(visits, moments.count, breaks)
        if nowhere is not None:
            # one recording at a time, for the others may pass there
            states = [*states, slowest(*nowhere)]
            continue
        shadows = shadow_states(moments, states, visits, near, breaks) - fixed
        if shadows:
            states, roles = without_states(states, roles, shadows)
            continue
        paths, traversals = traverse(seen, states, visits, near, ways, symmetric, breaks)
        paths, traversals = one_way(seen, visits, paths, traversals, near, ways)
        unvisited = set(range(len(states))) - {v.state for v in visits}
        drop = (traceless_states(states, visits, traversals) | unvisited) - fixed
        if not drop:
            break
        # one at a time: two neighbours without trace may be each other's only trace
        states, roles = without_states(states, roles, {min(drop)})
    leads, tails = ends(moments, visits, traversals, inside, breaks)
    return Reading(tuple(states), tuple(paths), tuple(visits), tuple(traversals), near, leads, tails)


def _inside(cyclic: Sequence[Cyclic], count: int) -> NDArray[np.bool_]:
    """Whether each moment is part of a cyclic movement: what leads up to its first state and away from its last one is, too."""
    out = np.zeros(count, dtype=np.bool_)
    for stretch in cyclic:
        first, last = stretch.anchors[0].moment, stretch.anchors[-1].moment
        out[min(stretch.start, first) : max(stretch.end, last + 1)] = True
    return out


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
