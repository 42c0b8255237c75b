"""The motion graph: states joined by paths, and every frame of the recordings it was read from ([Schultz2012] §3.5-3.6).

- the parts: `State`, `Path`, `Stay`, `Occurrence`, `Source`; the whole: `MotionGraph`
- to make one: `build` gives ids, labels and order to states and paths that have none yet
- to read one: `MotionGraph.timeline`, `MotionGraph.notation`, `MotionGraph.rebuild`
- to transform one: `MotionGraph.racemic`, `condensed`, `contracted`, `mirrored`, `reversed_in_time`
- to compare two: `MotionGraph.isomorphic_to`, `MotionGraph.edit_distance`

Conventions, binding for whoever makes a graph:

- Frames are counted from 0, ranges are [start, end). Stays and occurrences of one source tile [0, frames) exactly once, and
  one step begins in the state in which the last one ended.
- What is symmetric (`State.symmetric`, `Path.symmetric`) is its own mirror image and has ``mirror_of = None``; what is not
  names its image in ``mirror_of``, or None where the graph does not have it.
- A path that is its own mirror image *played backwards* (antipalindromic: MT) has its own id in ``mirror_of``; it is
  reversible and joins a state to that state's mirror image.
- A path is reversible where it, or its mirror image, was traversed in both directions (§3.5); of two mirror images both are
  or none is.
- A stay has no path of its own: it is written ``aa_0`` (§3.2.1).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from kinesics.errors import InputError

if TYPE_CHECKING:
    import networkx as nx

    from kinesics.grammar.comparison import EditDistance
    from kinesics.grammar.information import Information
    from kinesics.grammar.racemic import Condensed

SYMMETRIC_LETTERS: Final = "XYWVUTSR"
"""Letters of symmetric states in the order they are given, as in §3.5-3.6; Z is the similarity and stays free."""
CHIRAL_LETTERS: Final = "ABCDEFGHIJKLMNOPQ"
"""Letters of states that are not symmetric."""


@dataclass(frozen=True)
class Source:
    """A recording that the graph was read from."""

    name: str
    frames: int
    fps: float

    def __post_init__(self) -> None:
        if self.frames < 1 or not 0.0 < self.fps < float("inf"):
            raise InputError(
                f"Expected a source of at least one frame and a positive frame rate, got '{self.name}' with "
                f"{self.frames} frames at {self.fps} fps."
            )


@dataclass(frozen=True)
class Stay:
    """Frames [start, end) of a source in which a state is held."""

    source: int
    start: int
    end: int


@dataclass(frozen=True)
class Occurrence:
    """One traversal of a path: frames [start, end) of a source."""

    source: int
    start: int
    end: int
    reversed: bool = False
    """Traversed from the path's end to its start."""
    complete: bool = True
    """False where the recording begins or ends on the way: only the first and the last step of a source can be so."""


@dataclass(frozen=True)
class State:
    """A node: a pose that is repeated, held, turned back in or branched from."""

    id: int
    label: str = ""
    symmetric: bool = False
    mirror_of: int | None = None
    """Id of the state that is its mirror image; None for a symmetric state, and where the graph has none."""
    stays: tuple[Stay, ...] = ()


@dataclass(frozen=True)
class Path:
    """An edge: the movement from one state to another."""

    id: int
    label: str = ""
    from_: int = 0
    to: int = 0
    index: int = 0
    """1, 2, … of the distinct paths between the same states (§3.6.2); mirror images share it."""
    reversible: bool = False
    mirror_of: int | None = None
    """Id of the path that is its mirror image; its own id where it is that played backwards; None for a symmetric path."""
    inferred: bool = False
    """Never seen: known by racemisation only (§3.6.2)."""
    occurrences: tuple[Occurrence, ...] = ()
    symmetric: bool = False
    """Symmetric throughout, so that its label carries a bar."""

    @property
    def antipalindromic(self) -> bool:
        """Its mirror image is itself played backwards."""
        return self.mirror_of == self.id


@dataclass(frozen=True)
class Step:
    """One step of a timeline: a stay (``state``) or a traversal (``path``)."""

    source: int
    start: int
    end: int
    state: int | None = None
    path: int | None = None
    reversed: bool = False
    complete: bool = True


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
        _check_names(self)
        _check_states(self)
        _check_paths(self)
        _check_timelines(self)

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
        for step in _steps(self):
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


def build(states: Iterable[State], paths: Iterable[Path], sources: Iterable[Source] = ()) -> MotionGraph:
    """A graph of states and paths whose ids are any distinct numbers and whose labels, indices and order are not known yet.

    States are numbered and lettered in the order in which they are first seen: X, Y, W, V, … for symmetric ones, A, B, C, … for the
    others; of two mirror images the one seen first has the letter, the other the star. Paths are numbered in that order
    too, and each reversible one is turned to the direction in which it (or its mirror image) was traversed first. What was
    never seen comes last, in the order given. A path is made reversible where its mirror image is.

    Parameters
    ----------
    states, paths : labels and indices are passed over and given anew; ``from_``, ``to`` and ``mirror_of`` refer to the ids.
    sources : the recordings; stays and occurrences count them from 0.

    Raises
    ------
    InputError
        As `MotionGraph`.
    """
    from kinesics.grammar import notation

    given_states, given_paths = list(states), list(paths)
    _check_unique([s.id for s in given_states], "state id")
    _check_unique([p.id for p in given_paths], "path id")
    known, edges = {s.id for s in given_states}, {p.id: p for p in given_paths}
    _check_ends(given_paths, known)

    def with_image(path: Path) -> list[Path]:
        image = edges.get(path.mirror_of) if path.mirror_of is not None else None
        return [path] if image is None or image is path else [path, image]

    turned: list[Path] = []
    for path in given_paths:
        both = with_image(path)
        path = dataclasses.replace(path, reversible=any(p.reversible for p in both))
        seen = sorted((o.source, o.start, o.reversed) for p in both for o in p.occurrences)
        turned.append(_turned(path) if path.reversible and seen and seen[0][2] else path)

    never = (float("inf"), 0.0)
    first_path = {p.id: min(((o.source, o.start) for o in p.occurrences), default=never) for p in turned}
    first_state = dict.fromkeys((s.id for s in given_states), never)
    for state in given_states:
        for stay in state.stays:
            first_state[state.id] = min(first_state[state.id], (stay.source, stay.start))
    for path in turned:
        for o in path.occurrences:
            enters, leaves = (path.to, path.from_) if o.reversed else (path.from_, path.to)
            # where the recording begins or ends on the way, the state out of sight is not seen; half a frame: a state is
            # seen at the end of a path before it is held there
            if o.complete or o.start > 0:
                first_state[enters] = min(first_state[enters], (o.source, o.start))
            if o.complete or o.start == 0:
                first_state[leaves] = min(first_state[leaves], (o.source, o.end - 0.5))

    ordered = sorted(given_states, key=lambda s: first_state[s.id])
    number = {s.id: k for k, s in enumerate(ordered)}
    labels: dict[int, str] = {}
    letters = {True: notation.letters(SYMMETRIC_LETTERS), False: notation.letters(CHIRAL_LETTERS)}
    for state in ordered:
        image = state.mirror_of
        labels[state.id] = (
            notation.mirror_state_label(labels[image])
            if image in labels
            else next(letters[state.symmetric]) + notation.BAR * state.symmetric
        )
    new_states = tuple(
        dataclasses.replace(
            s,
            id=number[s.id],
            label=labels[s.id],
            mirror_of=None if s.mirror_of is None else _translated(number, s.mirror_of, "state", s.id),
            stays=tuple(sorted(s.stays, key=lambda stay: (stay.source, stay.start))),
        )
        for s in ordered
    )

    in_order = sorted(turned, key=lambda p: first_path[p.id])
    path_number = {p.id: k for k, p in enumerate(in_order)}
    new_paths = tuple(
        dataclasses.replace(
            p,
            id=path_number[p.id],
            from_=number[p.from_],
            to=number[p.to],
            mirror_of=None if p.mirror_of is None else _translated(path_number, p.mirror_of, "path", p.id),
            occurrences=tuple(sorted(p.occurrences, key=lambda o: (o.source, o.start))),
        )
        for p in in_order
    )
    return MotionGraph(new_states, label_paths(new_states, new_paths), tuple(sources))


def label_paths(states: Iterable[State], paths: Iterable[Path]) -> tuple[Path, ...]:
    """The paths with the labels and indices that follow from the labels of their ends and from their order."""
    from kinesics.grammar import notation

    names = {s.id: s.label for s in states}
    listed = list(paths)
    counts: dict[str, int] = {}
    given: dict[int, tuple[str, int]] = {}
    for path in listed:
        if path.id in given:
            continue
        base, starred = notation.path_base(names[path.from_], names[path.to], path.symmetric)
        index = counts[base] = counts.get(base, 0) + 1
        label = f"{base}_{index}"
        given[path.id] = (notation.mirror_path_label(label) if starred else label, index)
        if path.mirror_of is not None and path.mirror_of != path.id:
            given[path.mirror_of] = (notation.mirror_path_label(given[path.id][0]), index)
    return tuple(dataclasses.replace(p, label=given[p.id][0], index=given[p.id][1]) for p in listed)


def _turned(path: Path) -> Path:
    """The same reversible path, named in the other direction."""
    occurrences = tuple(dataclasses.replace(o, reversed=not o.reversed) for o in path.occurrences)
    return dataclasses.replace(path, from_=path.to, to=path.from_, occurrences=occurrences)


def _translated(numbers: Mapping[int, int], which: int, kind: str, owner: int) -> int:
    if which not in numbers:
        raise InputError(f"The mirror image of {kind} {owner} is {which}, which is no {kind} of the graph.")
    return numbers[which]


def _steps(graph: MotionGraph) -> Iterator[Step]:
    for state in graph.states:
        for stay in state.stays:
            yield Step(stay.source, stay.start, stay.end, state=state.id)
    for path in graph.paths:
        for o in path.occurrences:
            yield Step(o.source, o.start, o.end, path=path.id, reversed=o.reversed, complete=o.complete)


def _labelled(things: Iterable[Any], label: str) -> Any:
    return next((t for t in things if t.label == label), None)


def _listed(labels: Iterable[str]) -> str:
    names = list(labels)
    shown = ", ".join(names[:60]) or "none"
    return shown if len(names) <= 60 else f"{shown} and {len(names) - 60} more"


def _by_size(parts: Iterable[Iterable[int]]) -> tuple[tuple[int, ...], ...]:
    return tuple(sorted((tuple(sorted(p)) for p in parts), key=lambda part: (-len(part), part)))


def _check_unique(values: Iterable[object], what: str) -> None:
    seen: set[object] = set()
    for value in values:
        if value in seen:
            raise InputError(f"Expected every {what} once, got '{value}' twice.")
        seen.add(value)


def _check_ends(paths: Iterable[Path], known: Iterable[int]) -> None:
    ids = set(known)
    for path in paths:
        for end in (path.from_, path.to):
            if end not in ids:
                raise InputError(f"Path '{path.label or path.id}' ends at state {end}, which is not in the graph.")


def _check_names(graph: MotionGraph) -> None:
    from kinesics.grammar import notation

    _check_unique((s.id for s in graph.states), "state id")
    _check_unique((p.id for p in graph.paths), "path id")
    _check_unique((s.label for s in graph.states), "state label")
    _check_unique((p.label for p in graph.paths), "path label")
    for state in graph.states:
        notation.check_state_label(state.label, state.symmetric)
    for path in graph.paths:
        notation.check_path_label(path.label, path.symmetric)


def _check_states(graph: MotionGraph) -> None:
    by_id = graph._state_by_id
    for state in graph.states:
        if state.mirror_of is None:
            continue
        image = by_id.get(state.mirror_of)
        if state.symmetric or image is state:
            raise InputError(
                f"State '{state.label}' is its own mirror image: that is said by symmetric = True and mirror_of = None."
            )
        if image is None or image.mirror_of != state.id:
            raise InputError(
                f"State '{state.label}' names {state.mirror_of} as its mirror image, "
                + ("which is not in the graph." if image is None else f"but '{image.label}' names {image.mirror_of}.")
            )


def _check_paths(graph: MotionGraph) -> None:
    _check_ends(graph.paths, graph._state_by_id)
    by_id = graph._path_by_id
    for path in graph.paths:
        ends = (path.from_, path.to)
        mirrored = (graph.mirror_state(path.from_), graph.mirror_state(path.to))
        if path.inferred and path.occurrences:
            raise InputError(f"Path '{path.label}' is inferred and yet occurs {len(path.occurrences)} times.")
        if not path.reversible and any(o.reversed for o in path.occurrences):
            raise InputError(f"Path '{path.label}' is traversed backwards and yet not reversible.")
        if path.symmetric and (path.mirror_of is not None or mirrored != ends):
            raise InputError(
                f"Path '{path.label}' is symmetric: both its ends must be, and mirror_of is None; "
                f"got {graph.state(path.from_).label} to {graph.state(path.to).label} and {path.mirror_of}."
            )
        if path.mirror_of is None:
            continue
        image = by_id.get(path.mirror_of)
        if image is None or image.mirror_of != path.id:
            raise InputError(
                f"Path '{path.label}' names {path.mirror_of} as its mirror image, "
                + ("which is not in the graph." if image is None else f"but '{image.label}' names {image.mirror_of}.")
            )
        if image is path:
            if not path.reversible or mirrored != ends[::-1]:
                raise InputError(
                    f"Path '{path.label}' is its own mirror image played backwards: it must be reversible and join a state "
                    f"to its mirror image, not {graph.state(path.from_).label} to {graph.state(path.to).label}."
                )
        elif (image.from_, image.to) != mirrored:
            raise InputError(
                f"Path '{image.label}' is the mirror image of '{path.label}' and must join the mirror images of its ends, "
                f"got {graph.state(image.from_).label} to {graph.state(image.to).label} for "
                f"{graph.state(path.from_).label} to {graph.state(path.to).label}."
            )
        elif image.reversible != path.reversible:
            raise InputError(f"Of the mirror images '{path.label}' and '{image.label}' only one is reversible.")


def _check_timelines(graph: MotionGraph) -> None:
    for step in _steps(graph):
        if not 0 <= step.source < len(graph.sources):
            raise InputError(f"A step refers to source {step.source}; the graph has {len(graph.sources)} sources.")
    for number, source in enumerate(graph.sources):
        steps = graph.timeline(number)
        reached, here = 0, None
        for k, step in enumerate(steps):
            name = f"{_name(graph, step)} at [{step.start}, {step.end}) of source {number} '{source.name}'"
            if step.start != reached or step.end <= step.start:
                problem = "is empty" if step.end <= step.start else f"should start at {reached}"
                raise InputError(f"Stays and traversals must tile the frames: {name} {problem}.")
            if not step.complete and 0 < k < len(steps) - 1:
                raise InputError(f"Only the first and the last step of a source can be incomplete: {name} is neither.")
            enters, leaves = ends_of(graph, step)
            if here is not None and enters != here:
                raise InputError(
                    f"{name} begins in '{graph.state(enters).label}', but the step before it ended in "
                    f"'{graph.state(here).label}'."
                )
            reached, here = step.end, leaves
        if reached != source.frames:
            raise InputError(
                f"Stays and traversals must tile all {source.frames} frames of source {number} '{source.name}', "
                f"they end at {reached}."
            )


def ends_of(graph: MotionGraph, step: Step) -> tuple[int, int]:
    """Ids of the states in which a step begins and ends."""
    if step.path is None:
        assert step.state is not None
        return step.state, step.state
    path = graph.path(step.path)
    return (path.to, path.from_) if step.reversed else (path.from_, path.to)


def _name(graph: MotionGraph, step: Step) -> str:
    if step.path is not None:
        return f"Path '{graph.path(step.path).label}'"
    assert step.state is not None
    return f"The stay in '{graph.state(step.state).label}'"
