"""States that leave no trace, and states that are only the shadow of another: neither is one."""

from __future__ import annotations

import bisect
from collections.abc import Collection, Sequence

import numpy as np

from kinesics.grammar import ground
from kinesics.grammar.ground import Nearness
from kinesics.grammar.moments import Moments
from kinesics.grammar.reading.states import ReadState
from kinesics.grammar.reading.traversals import BREAK, Traversal
from kinesics.grammar.reading.visits import Visit

_PathEnd = tuple[int, bool, bool]
"""Which path, whether its far end, and on which side of the mirror."""


def traceless_states(states: Sequence[ReadState], visits: Sequence[Visit], traversals: Sequence[Traversal]) -> set[int]:
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


def shadow_states(
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
