"""The grammar's words for the paths of a network: states, paths, classes and names of phrases."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.grammar import notation
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.repertoire import BACKWARD_STRANDS, MIRRORED_STRANDS, Repertoire

if TYPE_CHECKING:
    from kinesics.analysis.facts import Phrase
    from kinesics.grammar.graph import MotionGraph, Step

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

NEAR_STATE: Final = 0.25
"""Seconds between a seam and a state that is passed there, at most."""


class _Words(NamedTuple):
    state_from: str
    state_to: str
    label: str


def labelled(
    network: Network, graph: MotionGraph, phrases: Sequence[Phrase] = (), *, at_states: bool = False
) -> Network:
    """The network with the grammar's words for every path.

    A path gets the words of that path or stay of the motion graph with which it shares most time; a mirrored one those of its
    mirror image, one played backwards those of the way back (``<ab_1``).

    Parameters
    ----------
    graph : of the same recordings in the same order, as `kinesics.graph` reads it. Not necessarily racemic.
    phrases : whose classes and names are given to the paths, as `kinesics.analyze` finds them; none leaves `Network.class_` and
        `Network.phrase` empty.
    at_states : whether a path is said to come from a state, or to lead to one, only if it begins or ends there itself. Else
        all pieces of a path of the motion graph carry the states at its two ends.

    Raises
    ------
    InputError
        If the graph was read from other recordings than the network.
    """
    from kinesics.grammar.racemic import racemic

    repertoire = network.repertoire
    if len(graph.sources) != repertoire.recording_count:
        raise InputError(
            f"The motion graph was read from {len(graph.sources)} recordings, the network from "
            f"{repertoire.recording_count}: give the graph of the same recordings, in the same order."
        )
    whole = racemic(graph)
    ends = np.sort(repertoire.source_frames[repertoire.frame_of(np.stack([network.first, network.last]))], axis=0)
    for number, source in enumerate(graph.sources):
        own = network.recording == number
        if own.any() and ends[1, own].max() > source.frames:
            raise InputError(
                f"{repertoire.names[number]} has more frames than source {number} of the motion graph, {source.name} "
                f"({source.frames}): give the graph of the same recordings, in the same order."
            )
    words = [_Words("", "", "")] * len(network)
    classes, named = [""] * len(network), [""] * len(network)
    for number in range(repertoire.recording_count):
        own = np.flatnonzero(network.recording == number)
        if not len(own):
            continue
        steps = whole.timeline(number)
        said = [p for p in phrases if p.source == number]
        for path, at in zip(own.tolist(), _most_shared(steps, *ends[:, own]), strict=True):
            if at >= 0:
                words[path] = _word(whole, steps[at], int(network.strand[path]))
        if at_states:
            rate = repertoire.source_fps[number] / repertoire.fps
            for strand in np.unique(network.strand[own]).tolist():
                these = own[network.strand[own] == strand]
                low, high = ends[0, these], ends[1, these] + rate
                places = (high, low) if BACKWARD_STRANDS[strand] else (low, high)
                near = NEAR_STATE * repertoire.source_fps[number]
                for path, begin, end in zip(
                    these.tolist(), *_at_states(whole, steps, *places, strand, near), strict=True
                ):
                    words[path] = words[path]._replace(state_from=begin, state_to=end)
        for path, at in zip(own.tolist(), _most_shared(said, *ends[:, own]), strict=True):
            if at >= 0:
                classes[path] = said[at].class_ or ""
                named[path] = said[at].name or (kind_name(said[at].kind) if repertoire.recording_count == 1 else "")
    return dataclasses.replace(
        network,
        state_from=tuple(w.state_from for w in words),
        state_to=tuple(w.state_to for w in words),
        label=tuple(w.label for w in words),
        class_=tuple(classes),
        phrase=tuple(named),
    )


def kind_name(kind: int | None) -> str:
    """What a kind of phrases is called, counted from 1; "" for none."""
    return "" if kind is None else f"kind {kind + 1}"


def state_seams(repertoire: Repertoire, graph: MotionGraph, lead: float = 0.0) -> Indices:
    """Where the states of a motion graph are passed, entered and left: `seams` for `network`, so that paths can begin there.

    Parameters
    ----------
    graph : of the same recordings in the same order.
    lead : seconds before and after these at which there are seams, too; none for 0.
    """
    out: list[int] = []
    for number in range(min(len(graph.sources), repertoire.recording_count)):
        low, high = repertoire.starts[number : number + 2].tolist()
        rate = repertoire.fps / repertoire.source_fps[number]
        ends = {round(frame * rate) for step in graph.timeline(number) for frame in (step.start, step.end)}
        aside = round(lead * repertoire.fps)
        ends |= {frame + sign * aside for frame in ends for sign in (-1, 1)}
        out += [low + frame for frame in sorted(ends) if 0 < frame < high - low]
    return np.array(sorted(set(out)), dtype=np.intp)


def _at_states(
    graph: MotionGraph, steps: Sequence[Step], begins: Array, ends: Array, strand: int, near: float
) -> tuple[list[str], list[str]]:
    """The states in which paths begin and end, "" for none; places in one recording's own frames, of paths of one strand.

    A path begins in a state if of all seams its own lies nearest to where the state is passed, and not farther than ``near``
    frames away; or if it lies within a stay.
    """
    passed: list[tuple[float, float, int]] = []
    for number, step in enumerate(steps):
        if step.path is None:
            assert step.state is not None
            passed.append((step.start, step.end, step.state))
            continue
        path = graph.path(step.path)
        first, last = (path.to, path.from_) if step.reversed else (path.from_, path.to)
        # a step that the recording cuts off at its beginning or end reaches no state there
        if step.complete or number > 0:
            passed.append((step.start, step.start, first))
        if step.complete or number < len(steps) - 1:
            passed.append((step.end, step.end, last))
    seams = np.unique(np.concatenate([begins, ends]))
    named: dict[float, str] = {}
    for low, high, state in passed:
        image = graph.mirror_state(state) if MIRRORED_STRANDS[strand] else state
        assert image is not None, "a racemic graph has every mirror image"
        away = np.maximum(np.maximum(low - seams, seams - high), 0.0)
        for seam in seams[(away <= min(float(away.min()), near))].tolist():
            named[seam] = graph.state(image).label
    return [named.get(at, "") for at in begins.tolist()], [named.get(at, "") for at in ends.tolist()]


class _Stretch(Protocol):
    @property
    def start(self) -> int: ...
    @property
    def end(self) -> int: ...


def _most_shared(stretches: Sequence[_Stretch], first: Array, last: Array) -> list[int]:
    """Number of the stretch that shares most with each of the frames first … last, the earliest of equals, −1 if none does."""
    if not stretches:
        return [-1] * len(first)
    start, end = (np.array([getattr(s, side) for s in stretches]) for side in ("start", "end"))
    shared = np.minimum(last[:, None] + 1.0, end) - np.maximum(first[:, None], start)
    most = np.argmax(shared, axis=1)
    numbers: list[int] = np.where(shared[np.arange(len(first)), most] > 0.0, most, -1).tolist()
    return numbers


def _word(graph: MotionGraph, step: Step, strand: int) -> _Words:
    mirrored, backward = MIRRORED_STRANDS[strand], BACKWARD_STRANDS[strand]
    if step.path is None:
        assert step.state is not None
        state = graph.mirror_state(step.state) if mirrored else step.state
        assert state is not None, "a racemic graph has every mirror image"
        label = graph.state(state).label
        return _Words(label, label, notation.stay_label(label))
    path, reversed_ = graph.path(step.path), step.reversed ^ backward
    if mirrored and path.antipalindromic:
        reversed_ = not reversed_
    elif mirrored and path.mirror_of is not None:
        path = graph.path(path.mirror_of)
    enters, leaves = (path.to, path.from_) if reversed_ else (path.from_, path.to)
    return _Words(graph.state(enters).label, graph.state(leaves).label, notation.BACKWARDS * reversed_ + path.label)
