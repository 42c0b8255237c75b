"""Whether two motion graphs are one up to labels, and how far apart they are if not.

What is compared: states (symmetric or not), which are mirror images of which, and paths with their directions, parallels, symmetry,
reversibility and mirror images. What is not: labels, ids, order, stays, occurrences, and whether a path is only inferred.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Hashable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

from kinesics.grammar.graph import MotionGraph, Path

if TYPE_CHECKING:
    import networkx as nx

Kind = tuple[bool, bool, bool, bool]
"""Of a path: reversible, symmetric, antipalindromic, its mirror image is in the graph."""


def isomorphic(a: MotionGraph, b: MotionGraph) -> bool:
    """Whether the states and paths of one can be renamed to be those of the other.

    Mirror images go to mirror images; a state may go to the mirror image of its namesake, if everything goes along.
    """
    import networkx as nx

    if len(a.states) != len(b.states) or len(a.paths) != len(b.paths):
        return False
    first, second = _incidence(a), _incidence(b)
    # colours first: they decide nearly every pair of graphs and make the search for the rest short
    colours = _refined(first, second)
    if Counter(colours[0].values()) != Counter(colours[1].values()):
        return False
    for graph, colour in zip((first, second), colours, strict=True):
        nx.set_node_attributes(graph, colour, "colour")
    return bool(
        nx.is_isomorphic(
            first,
            second,
            node_match=lambda x, y: x["colour"] == y["colour"],
            edge_match=lambda x, y: x["kinds"] == y["kinds"],
        )
    )


def _incidence(graph: MotionGraph) -> nx.DiGraph[tuple[str, int]]:
    """States and paths as nodes; ways in, ways out and mirror images as edges: parallel paths and loops need nothing special."""
    import networkx as nx

    out: nx.DiGraph[tuple[str, int]] = nx.DiGraph()
    for state in graph.states:
        out.add_node(("state", state.id), start=("state", state.symmetric))
    for path in graph.paths:
        out.add_node(("path", path.id), start=("path", *_kind(path)))

    def join(u: tuple[str, int], v: tuple[str, int], kind: str) -> None:
        before = out.edges[u, v]["kinds"] if out.has_edge(u, v) else ()
        out.add_edge(u, v, kinds=tuple(sorted((*before, kind))))

    for state in graph.states:
        if state.mirror_of is not None:
            join(("state", state.id), ("state", state.mirror_of), "mirror")
    for path in graph.paths:
        node = ("path", path.id)
        join(("state", path.from_), node, "way")
        join(node, ("state", path.to), "way")
        if path.reversible:
            join(("state", path.to), node, "way")
            join(node, ("state", path.from_), "way")
        if path.mirror_of is not None and path.mirror_of != path.id:
            join(node, ("path", path.mirror_of), "mirror")
    return out


def _kind(path: Path) -> Kind:
    return path.reversible, path.symmetric, path.antipalindromic, path.mirror_of is not None


def _refined(*graphs: nx.DiGraph[tuple[str, int]]) -> list[dict[tuple[str, int], int]]:
    """Colours that tell nodes apart by what surrounds them, numbered alike in all graphs (Weisfeiler & Leman 1968)."""
    names: dict[Hashable, int] = {}
    colours = [{n: names.setdefault(g.nodes[n]["start"], len(names)) for n in g} for g in graphs]
    while True:
        names = {}
        finer = []
        for g, colour in zip(graphs, colours, strict=True):
            signs = {}
            for n in g:
                outward = sorted((g.edges[n, m]["kinds"], colour[m]) for m in g.successors(n))
                inward = sorted((g.edges[m, n]["kinds"], colour[m]) for m in g.predecessors(n))
                signs[n] = names.setdefault((colour[n], tuple(outward), tuple(inward)), len(names))
            finer.append(signs)
        if len(names) == len({c for colour in colours for c in colour.values()}):
            return finer
        colours = finer


@dataclass(frozen=True)
class EditDistance:
    """Fewest changes found that make one graph the other, and whether fewer are impossible."""

    value: int
    exact: bool


EFFORT: Final = 1_000_000
"""Pairs of states compared before the search stops, a few seconds: a bound on time that is the same on every machine."""


def edit_distance(a: MotionGraph, b: MotionGraph, *, effort: int = EFFORT) -> EditDistance:
    """Fewest changes that make one graph the other.

    A change is: a state added or removed, a state made symmetric or not, two states made mirror images or no longer, a path
    added, removed or made of another kind (reversible, symmetric, with a mirror image or not). A path is not moved: it is removed
    and added.

    Parameters
    ----------
    effort : pairs of states compared; with too few the value is an upper bound and ``exact`` is False.
    """
    if len(a.states) > len(b.states):
        a, b = b, a
    if isomorphic(a, b):
        return EditDistance(0, exact=True)
    search = _Search(a, b, effort)
    search.run()
    return EditDistance(search.best, exact=not search.stopped)


class _Search:
    """Depth first over assignments of the states of ``left`` to those of ``right`` or to none, likely ones first."""

    def __init__(self, left: MotionGraph, right: MotionGraph, effort: int) -> None:
        self.left, self.right = _Shape(left), _Shape(right)
        self.effort = effort
        self.looked = 0
        self.stopped = False
        self.reached_end = False
        self.best = len(left.states) + len(left.paths) + len(right.states) + len(right.paths)
        self.order = sorted(self.left.ids, key=lambda s: -self.left.degree[s])

    def run(self) -> None:
        self._extend({}, 0)

    def _extend(self, chosen: dict[int, int | None], cost: int) -> None:
        if len(chosen) == len(self.order):
            self.best = min(self.best, cost + self._left_over(chosen))
            self.reached_end = True
            return
        if self.looked >= self.effort and self.reached_end:
            self.stopped = True
            return
        self.looked += len(self.right.ids) * (1 + len(chosen))
        if cost + self._still_to_come(chosen) >= self.best:
            return
        state = self.order[len(chosen)]
        taken = set(chosen.values())
        options: list[tuple[int, int, int | None]] = [
            (self._added(state, other, chosen), abs(self.left.degree[state] - self.right.degree[other]), other)
            for other in self.right.ids
            if other not in taken
        ]
        options.append((self._added(state, None, chosen), len(self.left.degree), None))
        for added, _, other in sorted(options, key=lambda o: o[:2]):
            if cost + added < self.best:
                chosen[state] = other
                self._extend(chosen, cost + added)
                del chosen[state]

    def _added(self, state: int, other: int | None, chosen: Mapping[int, int | None]) -> int:
        """What the choice costs, against itself and everything chosen before."""
        cost = 1 if other is None else int(self.left.symmetric[state] != self.right.symmetric[other])
        for u, image in ((state, other), *chosen.items()):
            here = self.left.between(state, u)
            there = self.right.between(other, image) if other is not None and image is not None else _NONE
            cost += _changes(here, there)
            if u != state and other is not None and image is not None:
                cost += (self.left.image.get(state) == u) != (self.right.image.get(other) == image)
        return cost

    def _still_to_come(self, chosen: Mapping[int, int | None]) -> int:
        """At least this much: states and paths that one side has too many of."""
        images = {v for v in chosen.values() if v is not None}
        states = len(self.left.ids) - len(chosen) - len(self.right.ids) + len(images)
        paths = self.left.outside(chosen.keys()) - self.right.outside(images)
        return abs(states) + abs(paths)

    def _left_over(self, chosen: Mapping[int, int | None]) -> int:
        """States of the right graph that nothing was assigned to, and their paths."""
        images = {v for v in chosen.values() if v is not None}
        return len(self.right.ids) - len(images) + self.right.outside(images)


class _Between(NamedTuple):
    """Paths between two states, seen from the first: how many of each kind."""

    forwards: Counter[Kind]
    backwards: Counter[Kind]
    both_ways: Counter[Kind]


_NONE: Final = _Between(Counter(), Counter(), Counter())


def _changes(a: _Between, b: _Between) -> int:
    """Paths added, removed or changed: a change saves one of the two, and joins paths of one direction or one of no direction."""
    more = [(x - y).total() for x, y in zip(a, b, strict=True)]
    fewer = [(y - x).total() for x, y in zip(a, b, strict=True)]
    total, changed = sum(more) + sum(fewer), 0
    for way in (0, 1):
        same_way = min(more[way], fewer[way])
        changed += same_way
        more[way] -= same_way
        fewer[way] -= same_way
    changed += min(sum(more), sum(fewer), more[2] + fewer[2])
    return total - changed


class _Shape:
    """What of a graph the distance sees."""

    def __init__(self, graph: MotionGraph) -> None:
        self.ids = [s.id for s in graph.states]
        self.symmetric = {s.id: s.symmetric for s in graph.states}
        self.image = {s.id: s.mirror_of for s in graph.states if s.mirror_of is not None}
        self.ends = [(p.from_, p.to) for p in graph.paths]
        self.degree = Counter(dict.fromkeys(self.ids, 0))
        self._between: dict[tuple[int, int], _Between] = {}
        for path in graph.paths:
            self.degree.update({path.from_, path.to})
            kind = _kind(path)
            self._at(path.from_, path.to)[2 if path.reversible else 0][kind] += 1
            if path.from_ != path.to:
                self._at(path.to, path.from_)[2 if path.reversible else 1][kind] += 1

    def _at(self, u: int, v: int) -> _Between:
        return self._between.setdefault((u, v), _Between(Counter(), Counter(), Counter()))

    def between(self, u: int, v: int) -> _Between:
        return self._between.get((u, v), _NONE)

    def outside(self, inner: Collection[int]) -> int:
        """Paths with an end outside these states."""
        return sum(u not in inner or v not in inner for u, v in self.ends)
