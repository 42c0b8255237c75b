"""When the movement is in which state."""

from __future__ import annotations

import bisect
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from kinesics.grammar import ground
from kinesics.grammar.reading.seen import Seen
from kinesics.grammar.reading.states import ReadState


class Visit(NamedTuple):
    """The movement is in a state."""

    start: int
    end: int
    """Exclusive."""
    at: int
    """The moment nearest to the state."""
    state: int
    mirrored: bool


def find_visits(seen: Seen, states: Sequence[ReadState]) -> list[Visit]:
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


def without_visit(visits: Sequence[Visit], count: int, breaks: Sequence[int]) -> tuple[int, int] | None:
    """The first recording, moments [start, end), that is in no state at all."""
    places = sorted(v.at for v in visits)
    for start, end in pairwise((0, *breaks, count)):
        if bisect.bisect_left(places, start) == bisect.bisect_left(places, end):
            return start, end
    return None
