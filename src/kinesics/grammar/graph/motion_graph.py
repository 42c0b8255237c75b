"""The motion graph as a whole: it finds, tells and transforms; other modules know how."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from kinesics.errors import InputError
from kinesics.grammar.graph import rules
from kinesics.grammar.graph.parts import Path, Source, State, Step, steps_of

if TYPE_CHECKING:
    import networkx as nx

    from kinesics.grammar.comparison import EditDistance
    from kinesics.grammar.information import Information
    from kinesics.grammar.racemic import Condensed


@dataclass(frozen=True)
class MotionGraph:
    """States joined by paths, and where in the recordings each was seen.

    Raises
    ------
    InputError
        If ids or labels are not unique, a path ends nowhere, mirror images do not match, a path that was never seen has
        occurrences, one that is not reversible was traversed backwards, or the steps of a source do not tile its frames.
    """

    states: tuple[State, ...] = ()
    paths: tuple[Path, ...] = ()
    sources: tuple[Source, ...] = ()

    def __post_init__(self) -> None:
        rules.check(self)

    # finding things

    @cached_property
    def _state_by_id(self) -> Mapping[int, State]:
        return {s.id: s for s in self.states}

    @cached_property
    def _path_by_id(self) -> Mapping[int, Path]:
        return {p.id: p for p in self.paths}

    def state(self, which: int | str) -> State:
        """The state of that id or label.

        Raises
        ------
        InputError
            If there is none; the message lists the labels.
        """
        found = self._state_by_id.get(which) if isinstance(which, int) else _labelled(self.states, which)
        if found is None:
            raise InputError(f"No state is called '{which}'. States: {_listed(s.label for s in self.states)}.")
        return found

    def path(self, which: int | str) -> Path:
        """The path of that id or label.

        Raises
        ------
        InputError
            If there is none; the message lists the labels.
        """
        found = self._path_by_id.get(which) if isinstance(which, int) else _labelled(self.paths, which)
        if found is None:
            raise InputError(f"No path is called '{which}'. Paths: {_listed(p.label for p in self.paths)}.")
        return found

    def mirror_state(self, state: int) -> int | None:
        """Id of the mirror image of a state: a symmetric state is its own; None where the graph has none."""
        known = self.state(state)
        return known.id if known.symmetric else known.mirror_of

    # reading it as a sentence

    def timeline(self, source: int = 0) -> tuple[Step, ...]:
        """Stays and traversals of one source in the order of time; together they tile [0, frames).

        Raises
        ------
        InputError
            If there is no such source.
        """
        if not 0 <= source < len(self.sources):
            raise InputError(f"No source {source} in a graph of {len(self.sources)} sources.")
        return self._timelines[source]

    @cached_property
    def _timelines(self) -> tuple[tuple[Step, ...], ...]:
        steps: list[list[Step]] = [[] for _ in self.sources]
        for step in steps_of(self):
            steps[step.source].append(step)
        return tuple(tuple(sorted(s, key=lambda step: (step.start, step.end))) for s in steps)

    def notation(self, source: int | None = None) -> str:
        """The recording as a string of paths separated by spaces; all sources, a line each, without ``source``.

        ``A`` and ``A*`` mirror images, ``X~`` symmetric, ``ab_1`` a path, ``(ab_1)*`` its mirror image, ``xy~_1`` a symmetric
        one, ``<ab_1`` traversed backwards, ``aa_0`` a stay. ``..ab_1`` at the start of a recording is entered on the way,
        ``ab_1..`` at its end is left on the way.
        """
        from kinesics.grammar import notation

        return notation.notation(self, source)

    def pretty(self, source: int | None = None) -> str:
        """The notation with bars, subscripts and arrows, for people: ``A ax₁→ X̄ ←(ax₁)* A*``."""
        from kinesics.grammar import notation

        return notation.pretty(self, source)

    def rebuild(self, text: str, source: int = 0) -> tuple[Step, ...]:
        """The timeline of a source from its notation: `timeline` again, exactly.

        Raises
        ------
        InputError
            If the string is no sentence of this graph, or not the one of that source.
        """
        from kinesics.grammar import notation

        return notation.rebuild(self, text, source)

    def information(self) -> Information:
        """How much a traversal tells (§1.1); see `kinesics.grammar.information`."""
        from kinesics.grammar.information import measure

        return measure(self)

    # its shape

    def components(self) -> tuple[tuple[int, ...], ...]:
        """Ids of the states of each part that no path joins to another, the largest first."""
        after = self._reached(both_ways=True)
        return _by_size({frozenset(reached) for reached in after.values()})

    def strongly_connected(self) -> tuple[tuple[int, ...], ...]:
        """Ids of the states of each part within which every state can be reached from every other, the largest first."""
        after = self._reached()
        return _by_size({frozenset(b for b in reached if a in after[b]) for a, reached in after.items()})

    def dead_ends(self) -> tuple[int, ...]:
        """Ids of the states that no path leaves for another state: there a traversal must stop or repeat itself."""
        leaving = {a for a, b in self._arrows() if a != b}
        return tuple(s.id for s in self.states if s.id not in leaving)

    def _arrows(self) -> Iterator[tuple[int, int]]:
        for p in self.paths:
            yield p.from_, p.to
            if p.reversible:
                yield p.to, p.from_

    def _reached(self, *, both_ways: bool = False) -> dict[int, set[int]]:
        """The states that can be reached from each state, itself among them."""
        beside: dict[int, set[int]] = {s.id: set() for s in self.states}
        for a, b in self._arrows():
            beside[a].add(b)
            if both_ways:
                beside[b].add(a)
        out: dict[int, set[int]] = {}
        for start in beside:
            reached, new = {start}, {start}
            while new:
                new = set().union(*(beside[a] for a in new)) - reached
                reached |= new
            out[start] = reached
        return out

    # other graphs from it

    def racemic(self) -> MotionGraph:
        """With the mirror image of every state and path; what was never seen is ``inferred`` (§3.6.2)."""
        from kinesics.grammar import racemic

        return racemic.racemic(self)

    def condensed(self) -> Condensed:
        """The short form that the dissertation gives after "or" (Figures 65-67); to be drawn, not traversed."""
        from kinesics.grammar import racemic

        return racemic.condense(self)

    def contracted(self) -> MotionGraph:
        """Without the states that leave no trace: one way in, one way out, no stop, no turning back, not symmetric."""
        from kinesics.grammar import racemic

        return racemic.contract(self)

    def mirrored(self) -> MotionGraph:
        """The graph of the mirrored recordings: every label starred that was not, and the other way round."""
        from kinesics.grammar import racemic

        return racemic.mirror(self)

    def reversed_in_time(self) -> MotionGraph:
        """The graph of the recordings played backwards: every one-way arrow turned."""
        from kinesics.grammar import racemic

        return racemic.reverse(self)

    # beside another

    def isomorphic_to(self, other: MotionGraph) -> bool:
        """Whether the two are one graph up to labels, order and occurrences; see `kinesics.grammar.comparison`."""
        from kinesics.grammar.comparison import isomorphic

        return isomorphic(self, other)

    def edit_distance(self, other: MotionGraph) -> EditDistance:
        """Fewest changes that make one of the two the other; see `kinesics.grammar.comparison`."""
        from kinesics.grammar.comparison import edit_distance

        return edit_distance(self, other)

    # in other forms

    def to_networkx(self) -> nx.MultiDiGraph[str]:
        """A directed multigraph of labels; see `kinesics.grammar.exchange`."""
        from kinesics.grammar import exchange

        return exchange.to_networkx(self)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON values, as ``graph`` of `analysis.json`."""
        from kinesics.grammar import exchange

        return exchange.to_dict(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> MotionGraph:
        """The graph that `to_dict` wrote.

        Raises
        ------
        InputError
            If a key is missing or a value is wrong; the message says which.
        """
        from kinesics.grammar import exchange

        return exchange.from_dict(values)

    def to_json(self) -> str:
        """The text of `to_dict`."""
        from kinesics.grammar import exchange

        return exchange.to_json(self)

    def to_graphml(self) -> str:
        """GraphML, for Gephi, yEd, igraph and others."""
        from kinesics.grammar import exchange

        return exchange.to_graphml(self)

    def to_mermaid(self) -> str:
        """A Mermaid flowchart, for Markdown pages."""
        from kinesics.grammar import exchange

        return exchange.to_mermaid(self)


def _labelled(things: Iterable[Any], label: str) -> Any:
    return next((t for t in things if t.label == label), None)


def _listed(labels: Iterable[str]) -> str:
    names = list(labels)
    shown = ", ".join(names[:60]) or "none"
    return shown if len(names) <= 60 else f"{shown} and {len(names) - 60} more"


def _by_size(parts: Iterable[Iterable[int]]) -> tuple[tuple[int, ...], ...]:
    return tuple(sorted((tuple(sorted(p)) for p in parts), key=lambda part: (-len(part), part)))
