"""From a reading (states and paths up to the mirror) to the motion graph with both sides of it, every frame accounted for."""

from __future__ import annotations

from collections.abc import Sequence

from kinesics.grammar import reading as _reading
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, Source, State, Stay, build
from kinesics.grammar.moments import Moments
from kinesics.grammar.reading import Reading


def assemble(read: Reading, moments: Moments, name: str = "") -> MotionGraph:
    """The graph of one recording.

    A state seen on one side of the mirror only has no image in the graph (`MotionGraph.racemic` adds it). A visit in which
    the pose is held is a stay; the other frames belong to the paths, which begin and end at the moment nearest to the state.
    """
    source = Source(name, moments.source_frames, moments.source_fps)
    if len(read.visits) == 0:
        return MotionGraph((), (), (source,))
    stays, occurrences = _timeline(read, moments)
    sides = {(v.state, v.mirrored) for v in read.visits}
    states = [
        State(
            id=_state_id(k, side),
            symmetric=state.symmetric,
            mirror_of=_state_id(k, not side) if not state.symmetric and {(k, False), (k, True)} <= sides else None,
            stays=tuple(stays.get((k, side), ())),
        )
        for k, state in enumerate(read.states)
        for side in (False, True)
        if (k, side) in sides
    ]
    return build(states, _paths(read, moments, occurrences), (source,))


_LEAD, _TAIL = -1, -2
"""Numbers of the traversals that the recording begins and ends on."""


def _state_id(state: int, mirrored: bool) -> int:
    return 2 * state + mirrored


def _timeline(
    read: Reading, moments: Moments
) -> tuple[dict[tuple[int, bool], list[Stay]], list[tuple[int, Occurrence]]]:
    """Stays by state and side; and for each traversal that lasts, its number and its frames, direction left open."""
    held = _reading.held(moments, read)
    stays: dict[tuple[int, bool], list[Stay]] = {}
    occurrences: list[tuple[int, Occurrence]] = []
    at = 0
    last = len(read.visits) - 1
    if read.lead is not None:
        at = max(1, moments.frame_of(read.visits[0].at))
        occurrences.append((_LEAD, Occurrence(0, 0, at, complete=False)))
    for k, visit in enumerate(read.visits):
        stretch = held[k]
        if k == 0:
            start, end = at, moments.frame_of(stretch[1] if stretch else visit.at)
        elif stretch is None:
            start = end = moments.frame_of(visit.at)
        else:
            start, end = moments.frame_of(stretch[0]), moments.frame_of(stretch[1])
        if k == last and read.tail is None:
            end = moments.source_frames
        start, end = max(start, at), max(end, at)
        if k > 0:
            # a path has at least one frame, even where two states lie within one
            start = max(start, at + 1)
            end = max(end, start)
            occurrences.append((k - 1, Occurrence(0, at, start)))
        if end > start:
            stays.setdefault((visit.state, visit.mirrored), []).append(Stay(0, start, end))
        at = end
    if read.tail is not None and at < moments.source_frames:
        occurrences.append((_TAIL, Occurrence(0, at, moments.source_frames, complete=False)))
    return stays, occurrences


def _paths(read: Reading, moments: Moments, occurrences: Sequence[tuple[int, Occurrence]]) -> list[Path]:
    frames = dict(occurrences)
    out: list[Path] = []
    for k, path in enumerate(read.paths):
        taken = [(n, t) for n, t in enumerate(read.traversals) if t.path == k]
        first = taken[0][1]
        taken += [
            (n, t) for n, t in ((_LEAD, read.lead), (_TAIL, read.tail)) if t is not None and t.path == k and n in frames
        ]
        mirror_cost, mirror_reverse_cost = _reading.self_symmetry(moments, first.start, first.end)
        ends_symmetric = read.states[path.from_[0]].symmetric and read.states[path.to[0]].symmetric
        symmetric = (
            path.symmetric if path.symmetric is not None else ends_symmetric and mirror_cost < read.nearness.path
        )
        crosses = path.from_[0] == path.to[0] and (ends_symmetric or path.from_[1] != path.to[1])
        antipalindromic = not symmetric and crosses and mirror_reverse_cost < read.nearness.path
        sides: dict[bool, list[Occurrence]] = {}
        for n, t in taken:
            backwards = t.reversed != (antipalindromic and t.mirrored)
            side = t.mirrored and not (symmetric or antipalindromic)
            f = frames[n]
            sides.setdefault(side, []).append(Occurrence(f.source, f.start, f.end, backwards, f.complete))
        reversible = antipalindromic or len({o.reversed for side in sides.values() for o in side}) == 2
        for side, seen in sides.items():
            image = 2 * k + (not side) if len(sides) == 2 else None
            # seen in one direction only, that direction is the path's
            turned = not reversible and seen[0].reversed
            start, end = (path.to, path.from_) if turned else (path.from_, path.to)
            out.append(
                Path(
                    id=2 * k + side,
                    from_=_end_id(read, start, side),
                    to=_end_id(read, end, side),
                    reversible=reversible,
                    mirror_of=2 * k if antipalindromic else image,
                    symmetric=symmetric,
                    occurrences=tuple(
                        Occurrence(o.source, o.start, o.end, o.reversed and not turned, o.complete) for o in seen
                    ),
                )
            )
    return out


def _end_id(read: Reading, end: tuple[int, bool], mirrored: bool) -> int:
    """The state at the end of a path or of its mirror image."""
    state, side = end
    return _state_id(state, not read.states[state].symmetric and side != mirrored)
