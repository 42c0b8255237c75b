"""A motion graph of states and paths that have no numbers, labels or order yet."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from kinesics.errors import InputError
from kinesics.grammar.graph.motion_graph import MotionGraph
from kinesics.grammar.graph.parts import Path, Source, State
from kinesics.grammar.graph.rules import check_ends, check_unique

SYMMETRIC_LETTERS: Final = "XYWVUTSR"
"""Letters of symmetric states in the order they are given, as in §3.5-3.6; Z is the similarity and stays free."""
CHIRAL_LETTERS: Final = "ABCDEFGHIJKLMNOPQ"
"""Letters of states that are not symmetric."""


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
    given_states, given_paths = list(states), list(paths)
    check_unique([s.id for s in given_states], "state id")
    check_unique([p.id for p in given_paths], "path id")
    check_ends(given_paths, {s.id for s in given_states})
    turned = _turned_as_traversed(given_paths)

    state_seen = _states_first_seen(given_states, turned)
    ordered = sorted(given_states, key=lambda s: state_seen[s.id])
    number = {s.id: k for k, s in enumerate(ordered)}
    labels = _letters(ordered)
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

    in_order = sorted(turned, key=lambda p: min(((o.source, o.start) for o in p.occurrences), default=_NEVER))
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


_NEVER: Final = (float("inf"), 0.0)
"""When what no recording shows is first seen: a source and a frame after all others."""


def _turned_as_traversed(paths: Sequence[Path]) -> list[Path]:
    """Reversible where the mirror image is; and then in the direction in which either was traversed first."""
    by_id = {p.id: p for p in paths}
    out: list[Path] = []
    for path in paths:
        image = by_id.get(path.mirror_of) if path.mirror_of is not None else None
        both = [path] if image is None or image is path else [path, image]
        path = dataclasses.replace(path, reversible=any(p.reversible for p in both))
        seen = sorted((o.source, o.start, o.reversed) for p in both for o in p.occurrences)
        out.append(path.turned() if path.reversible and seen and seen[0][2] else path)
    return out


def _states_first_seen(states: Iterable[State], paths: Iterable[Path]) -> dict[int, tuple[float, float]]:
    """Source and frame at which each state is seen first, held or at the end of a path."""
    first: dict[int, tuple[float, float]] = {}
    for state in states:
        first[state.id] = min(((stay.source, stay.start) for stay in state.stays), default=_NEVER)
    for path in paths:
        for o in path.occurrences:
            enters, leaves = (path.to, path.from_) if o.reversed else (path.from_, path.to)
            # where the recording begins or ends on the way, the state out of sight is not seen; half a frame: a state is
            # seen at the end of a path before it is held there
            if o.complete or o.start > 0:
                first[enters] = min(first[enters], (o.source, o.start))
            if o.complete or o.start == 0:
                first[leaves] = min(first[leaves], (o.source, o.end - 0.5))
    return first


def _letters(ordered: Iterable[State]) -> dict[int, str]:
    """Labels of states in the order in which they are first seen; of two mirror images the second has the first one's."""
    from kinesics.grammar import notation

    letters = {True: notation.letters(SYMMETRIC_LETTERS), False: notation.letters(CHIRAL_LETTERS)}
    labels: dict[int, str] = {}
    for state in ordered:
        labels[state.id] = (
            notation.mirror_state_label(labels[state.mirror_of])
            if state.mirror_of in labels
            else next(letters[state.symmetric]) + notation.BAR * state.symmetric
        )
    return labels


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


def _translated(numbers: Mapping[int, int], which: int, kind: str, owner: int) -> int:
    if which not in numbers:
        raise InputError(f"The mirror image of {kind} {owner} is {which}, which is no {kind} of the graph.")
    return numbers[which]
