"""Graphs made from a motion graph: racemised, mirrored, reversed, contracted, condensed ([Schultz2012] §3.5, §3.6.2)."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass

from kinesics.grammar import notation
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, State, Stay, build, label_paths


def racemic(graph: MotionGraph) -> MotionGraph:
    """The graph with the mirror image of every state and path (§3.6.2); ids and labels that were there stay.

    A reflected state has no stays, a reflected path is ``inferred`` and has no occurrences. Racemising twice changes nothing.
    """
    next_state = max((s.id for s in graph.states), default=-1) + 1
    next_path = max((p.id for p in graph.paths), default=-1) + 1
    images: dict[int, int] = {}
    for state in graph.states:
        known = graph.mirror_state(state.id)
        images[state.id] = next_state if known is None else known
        next_state += known is None
    states = [dataclasses.replace(s, mirror_of=None if s.symmetric else images[s.id]) for s in graph.states]
    states += [
        State(images[s.id], notation.mirror_state_label(s.label), mirror_of=s.id)
        for s in graph.states
        if not s.symmetric and s.mirror_of is None
    ]
    paths, reflected = [], []
    for path in graph.paths:
        if path.symmetric or path.mirror_of is not None:
            paths.append(path)
            continue
        paths.append(dataclasses.replace(path, mirror_of=next_path))
        reflected.append(
            dataclasses.replace(
                path,
                id=next_path,
                label=notation.mirror_path_label(path.label),
                from_=images[path.from_],
                to=images[path.to],
                mirror_of=path.id,
                inferred=True,
                occurrences=(),
            )
        )
        next_path += 1
    return MotionGraph(tuple(states), tuple(paths + reflected), graph.sources)


def mirror(graph: MotionGraph) -> MotionGraph:
    """The graph of the mirrored recordings: as a shape the same, every label mirrored."""
    return MotionGraph(
        tuple(dataclasses.replace(s, label=notation.mirror_state_label(s.label)) for s in graph.states),
        tuple(dataclasses.replace(p, label=notation.mirror_path_label(p.label)) for p in graph.paths),
        graph.sources,
    )


def reverse(graph: MotionGraph) -> MotionGraph:
    """The graph of the recordings played backwards.

    States keep their labels. A one-way path is turned, and so named anew; a reversible one keeps its direction and is traversed
    the other way.
    """
    frames = [s.frames for s in graph.sources]

    def turned(path: Path) -> Path:
        occurrences = tuple(
            dataclasses.replace(
                o,
                start=frames[o.source] - o.end,
                end=frames[o.source] - o.start,
                reversed=o.reversed ^ path.reversible,
            )
            for o in reversed(path.occurrences)
        )
        ends = (path.from_, path.to) if path.reversible else (path.to, path.from_)
        return dataclasses.replace(path, from_=ends[0], to=ends[1], occurrences=_in_order(occurrences))

    states = tuple(
        dataclasses.replace(
            s,
            stays=tuple(
                sorted(
                    (Stay(r.source, frames[r.source] - r.end, frames[r.source] - r.start) for r in s.stays),
                    key=lambda stay: (stay.source, stay.start),
                )
            ),
        )
        for s in graph.states
    )
    return MotionGraph(states, label_paths(states, [turned(p) for p in graph.paths]), graph.sources)


def contract(graph: MotionGraph) -> MotionGraph:
    """The graph without the states that leave no trace in a recording, labelled anew.

    Such a state is not symmetric, is never held, has one way in and one way out, each taken in one direction only, and lies
    between two other states; and its mirror image, where the graph has it, is so too. The two ways become one path.
    """
    while True:
        through = _traceless(graph)
        if through is None:
            return graph
        graph = _without(graph, through)


def _traceless(graph: MotionGraph) -> frozenset[int] | None:
    """The first state that leaves no trace, with its mirror image."""
    ways_in: dict[int, list[Path]] = {s.id: [] for s in graph.states}
    ways_out: dict[int, list[Path]] = {s.id: [] for s in graph.states}
    for path in graph.paths:
        ways_out[path.from_].append(path)
        ways_in[path.to].append(path)

    def plain(state: State, orbit: frozenset[int]) -> bool:
        if state.symmetric or state.stays or len(ways_in[state.id]) != 1 or len(ways_out[state.id]) != 1:
            return False
        before, after = ways_in[state.id][0], ways_out[state.id][0]
        if before.reversible or after.reversible or before.inferred != after.inferred:
            return False
        if {before.from_, after.to} & orbit:
            return False
        return not _met_at_an_end(before, after)

    for state in graph.states:
        orbit = frozenset({state.id} if state.mirror_of is None else {state.id, state.mirror_of})
        if all(plain(graph.state(s), orbit) for s in orbit):
            return orbit
    return None


def _met_at_an_end(before: Path, after: Path) -> bool:
    """Whether a recording begins or ends exactly between the two paths: it shows the state there."""
    ends = {(o.source, o.end) for o in before.occurrences}
    starts = {(o.source, o.start) for o in after.occurrences}
    begins = any(o.complete and (o.source, o.start) not in ends for o in after.occurrences)
    return begins or any(o.complete and (o.source, o.end) not in starts for o in before.occurrences)


def _without(graph: MotionGraph, states: frozenset[int]) -> MotionGraph:
    joined: dict[int, Path] = {}
    halves: dict[int, Path] = {}
    for state in states:
        before = next(p for p in graph.paths if p.to == state)
        after = next(p for p in graph.paths if p.from_ == state)
        starts = {(o.source, o.start): o for o in after.occurrences}
        occurrences = []
        for o in before.occurrences:
            follow = starts.pop((o.source, o.end), None)
            occurrences.append(
                dataclasses.replace(o, complete=False)
                if follow is None
                else Occurrence(o.source, o.start, follow.end, complete=o.complete and follow.complete)
            )
        occurrences += [dataclasses.replace(o, complete=False) for o in starts.values()]
        joined[before.id] = dataclasses.replace(before, to=after.to, occurrences=_in_order(occurrences))
        halves[before.id] = after
    gone = {p.id for p in halves.values()}
    paths = [joined.get(p.id, p) for p in graph.paths if p.id not in gone]

    def image(path: Path) -> int | None:
        # two joined paths are mirror images if both halves are
        half = halves.get(path.id)
        other = None if path.mirror_of is None else halves.get(path.mirror_of)
        agree = path.mirror_of not in gone and (half is None) == (other is None)
        return path.mirror_of if agree and (half is None or other is None or half.mirror_of == other.id) else None

    paths = [dataclasses.replace(p, mirror_of=image(p)) for p in paths]
    return build([s for s in graph.states if s.id not in states], paths, graph.sources)


def _in_order(occurrences: Iterable[Occurrence]) -> tuple[Occurrence, ...]:
    return tuple(sorted(occurrences, key=lambda o: (o.source, o.start)))


@dataclass(frozen=True)
class CondensedEdge:
    """An arrow of the short form: one or several paths of the graph."""

    from_: int
    to: int
    label: str
    """Of a path, or of the symmetric state that the arrow passes (Figure 66)."""
    paths: tuple[int, ...]
    """Ids of the paths it stands for."""
    both_ways: bool
    inferred: bool = False


@dataclass(frozen=True)
class Condensed:
    """The short form of a graph, as the dissertation draws it after "or" (Figures 65-67)."""

    states: tuple[State, ...]
    edges: tuple[CondensedEdge, ...]


def condense(graph: MotionGraph) -> Condensed:
    """The short form of a graph.

    - Two mirror images that lead to one symmetric state, which nothing else touches, are one antipalindromic arrow labelled by
      that state: A ←X̄→ A* for A ↔ X̄ ↔ A* (Figure 66).
    - A path from a state to its mirror image and the mirror image of that path are one arrow: A ↔ A* (Figure 67).
    - A reversible symmetric path to a symmetric state that nothing else touches is a loop that goes there and comes back: x̄x̄ for
      X̄ ↔ Ȳ (Figure 65).
    """
    at: dict[int, list[Path]] = {s.id: [] for s in graph.states}
    for path in graph.paths:
        for end in {path.from_, path.to}:
            at[end].append(path)
    gone: set[int] = set()
    used: set[int] = set()
    edges: list[CondensedEdge] = []
    for state in graph.states:
        here = at[state.id]
        if not state.symmetric or any(p.id in used for p in here):
            continue
        if _passes_the_middle(here):
            outer = [_other(p, state.id) for p in here]
            ids = tuple(p.id for p in here)
            inferred = all(p.inferred for p in here)
            edges.append(CondensedEdge(outer[0], outer[1], state.label, ids, both_ways=True, inferred=inferred))
        elif (
            len(here) == 1
            and here[0].reversible
            and here[0].symmetric
            and _other(here[0], state.id) not in gone | {state.id}
        ):
            base = _other(here[0], state.id)
            # of two states that only have each other, the first is kept
            if len(at[base]) == 1 and base > state.id:
                continue
            label = notation.path_base(graph.state(base).label, graph.state(base).label, symmetric=True)[0]
            edges.append(CondensedEdge(base, base, label, (here[0].id,), both_ways=True, inferred=here[0].inferred))
        else:
            continue
        gone.add(state.id)
        used |= {p.id for p in here}
    for path in graph.paths:
        if path.id in used:
            continue
        used.add(path.id)
        image = path.mirror_of
        crosses = graph.mirror_state(path.from_) == path.to and path.from_ != path.to
        if crosses and image is not None and image not in used:
            used.add(image)
            edges.append(CondensedEdge(path.from_, path.to, path.label, (path.id, image), True, path.inferred))
        else:
            edges.append(CondensedEdge(path.from_, path.to, path.label, (path.id,), path.reversible, path.inferred))
    return Condensed(tuple(s for s in graph.states if s.id not in gone), tuple(edges))


def _passes_the_middle(here: list[Path]) -> bool:
    if len(here) != 2 or here[0].mirror_of != here[1].id or not here[0].reversible:
        return False
    return len({here[0].from_, here[0].to, here[1].from_, here[1].to}) == 3


def _other(path: Path, end: int) -> int:
    return path.to if path.from_ == end else path.from_
