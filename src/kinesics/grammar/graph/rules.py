"""What a motion graph has to satisfy; whoever breaks a rule is told which, where and how."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from kinesics.errors import InputError
from kinesics.grammar.graph.parts import Path, Step, ends_of, steps_of

if TYPE_CHECKING:
    from kinesics.grammar.graph.motion_graph import MotionGraph


def check(graph: MotionGraph) -> None:
    """All rules at once.

    Raises
    ------
    InputError
        As `MotionGraph`.
    """
    _check_names(graph)
    _check_states(graph)
    _check_paths(graph)
    _check_timelines(graph)


def check_unique(values: Iterable[object], what: str) -> None:
    """Every value once.

    Raises
    ------
    InputError
        If one comes twice; the message says which, and ``what`` it is.
    """
    seen: set[object] = set()
    for value in values:
        if value in seen:
            raise InputError(f"Expected every {what} once, got '{value}' twice.")
        seen.add(value)


def check_ends(paths: Iterable[Path], known: Iterable[int]) -> None:
    """Every path joins known states.

    Raises
    ------
    InputError
        If one does not.
    """
    ids = set(known)
    for path in paths:
        for end in (path.from_, path.to):
            if end not in ids:
                raise InputError(f"Path '{path.label or path.id}' ends at state {end}, which is not in the graph.")


def _check_names(graph: MotionGraph) -> None:
    from kinesics.grammar import notation

    check_unique((s.id for s in graph.states), "state id")
    check_unique((p.id for p in graph.paths), "path id")
    check_unique((s.label for s in graph.states), "state label")
    check_unique((p.label for p in graph.paths), "path label")
    for state in graph.states:
        notation.check_state_label(state.label, state.symmetric)
    for path in graph.paths:
        notation.check_path_label(path.label, path.symmetric)


def _check_states(graph: MotionGraph) -> None:
    by_id = {s.id: s for s in graph.states}
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
    check_ends(graph.paths, (s.id for s in graph.states))
    by_id = {p.id: p for p in graph.paths}
    for path in graph.paths:
        _check_traversals(path)
        if path.symmetric and (path.mirror_of is not None or _mirrored_ends(graph, path) != (path.from_, path.to)):
            raise InputError(
                f"Path '{path.label}' is symmetric: both its ends must be, and mirror_of is None; "
                f"got {_ends_named(graph, path)} and {path.mirror_of}."
            )
        if path.mirror_of is not None:
            _check_image(graph, path, by_id.get(path.mirror_of))


def _check_traversals(path: Path) -> None:
    if path.inferred and path.occurrences:
        raise InputError(f"Path '{path.label}' is inferred and yet occurs {len(path.occurrences)} times.")
    if not path.reversible and any(o.reversed for o in path.occurrences):
        raise InputError(f"Path '{path.label}' is traversed backwards and yet not reversible.")


def _check_image(graph: MotionGraph, path: Path, image: Path | None) -> None:
    """A path and what it names as its mirror image."""
    mirrored = _mirrored_ends(graph, path)
    if image is None or image.mirror_of != path.id:
        raise InputError(
            f"Path '{path.label}' names {path.mirror_of} as its mirror image, "
            + ("which is not in the graph." if image is None else f"but '{image.label}' names {image.mirror_of}.")
        )
    if image is path:
        if not path.reversible or mirrored != (path.to, path.from_):
            raise InputError(
                f"Path '{path.label}' is its own mirror image played backwards: it must be reversible and join a state "
                f"to its mirror image, not {_ends_named(graph, path)}."
            )
    elif (image.from_, image.to) != mirrored:
        raise InputError(
            f"Path '{image.label}' is the mirror image of '{path.label}' and must join the mirror images of its ends, "
            f"got {_ends_named(graph, image)} for {_ends_named(graph, path)}."
        )
    elif image.reversible != path.reversible:
        raise InputError(f"Of the mirror images '{path.label}' and '{image.label}' only one is reversible.")


def _mirrored_ends(graph: MotionGraph, path: Path) -> tuple[int | None, int | None]:
    return graph.mirror_state(path.from_), graph.mirror_state(path.to)


def _ends_named(graph: MotionGraph, path: Path) -> str:
    return f"{graph.state(path.from_).label} to {graph.state(path.to).label}"


def _check_timelines(graph: MotionGraph) -> None:
    for step in steps_of(graph):
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


def _name(graph: MotionGraph, step: Step) -> str:
    if step.path is not None:
        return f"Path '{graph.path(step.path).label}'"
    assert step.state is not None
    return f"The stay in '{graph.state(step.state).label}'"
