"""The paths between transitions and which may follow which: the δ of the dissertation's P = E(j)·δ ([Schultz2012] §4.4).

The recordings, in every strand that may be used, are cut at the seams of their transitions (`kinesics.synthesis.transitions`).
A *path* is what lies between two cuts. After it comes the path that the recording goes on with, at no cost, or one that a
transition leads to. What cannot be reached again from where it leads is a dead end: only the largest strongly connected part
is kept, and what was left out is said. If mirror images belong to it, the whole is its own mirror image.

References
----------
- [Kovar2002] Kovar, Gleicher, Pighin: Motion graphs. SIGGRAPH 2002, §3.3: dead ends and strongly connected components.
"""

from __future__ import annotations

import dataclasses
import itertools
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.grammar import notation
from kinesics.progress import Progress, silent
from kinesics.similarity import Weights
from kinesics.synthesis import transitions as _transitions
from kinesics.synthesis.meeting import Meeting, meetings
from kinesics.synthesis.repertoire import BACKWARD_STRANDS, MIRRORED_STRANDS, STRANDS, Repertoire
from kinesics.synthesis.transitions import DENSITY, SPACING, Transitions, from_heading

if TYPE_CHECKING:
    from kinesics.analysis.facts import Phrase
    from kinesics.grammar.graph import MotionGraph, Step

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

_NAMES_AT_MOST: Final = 8
NEAR_STATE: Final = 0.25
"""Seconds between a seam and a state that is passed there, at most."""
_LEAST_COST: Final = 1e-12


class Pruned(NamedTuple):
    """Frames of a recording that the network leaves out."""

    recording: str
    strand: str
    """As in `kinesics.synthesis.repertoire.STRANDS`; several joined by "and"."""
    seconds: float
    why: str
    whole: bool
    """Whether nothing of the recording is left in this strand."""
    everything: bool
    """Whether nothing of the recording is left in any strand."""

    def __str__(self) -> str:
        """One line."""
        return f"{self.recording}, {self.strand}: {self.seconds:.2f} s, {self.why}"


@dataclass(frozen=True, eq=False, repr=False)
class Network:
    """The paths between transition points, and which may follow which. Made by `network`; arrays are read-only.

    Paths are in the order of their first moments. Path p plays the moments ``repertoire.advance(first[p], k)``,
    k < ``length[p]``. Its successors are ``indices[indptr[p] : indptr[p + 1]]``, the cheapest first; `cost` and `distance` run
    along with them.
    """

    repertoire: Repertoire
    first: Indices
    """Moment at which each path begins, shape (paths,), rising."""
    length: Indices
    """Frames that each path plays, shape (paths,)."""
    indptr: Indices
    """Where the successors of each path begin, shape (paths + 1,)."""
    indices: Indices
    """Paths that may follow, shape (successors,)."""
    cost: Array
    """Of going over to each successor, in [0, 1]: 0 where the recording itself goes on and only there. Shape (successors,)."""
    distance: Array
    """Mean D of going over to each successor, 0 where the recording itself goes on. Shape (successors,)."""
    displacement: Array
    """From the first moment of a path to that with which the recording goes on: metres to the left and ahead as seen from the
    heading at the first moment, shape (paths, 2)."""
    turn: Array
    """By which the heading turns on the way, radians about +y, positive to the left, not wrapped. Shape (paths,)."""
    duration: Array
    """Seconds, shape (paths,)."""
    threshold: float
    """Largest mean D accepted at a transition."""
    rule: str
    """How it was found."""
    pruned: tuple[Pruned, ...]
    """What was left out."""
    meeting: Meeting | None = None
    """How each successor meets what the path before would have gone on with: along with `indices`, 0 where the recording itself
    goes on. None: place and heading of the pelvis are the same everywhere."""
    state_from: tuple[str, ...] = ()
    """The grammar's words for each path; empty until `labelled`."""
    state_to: tuple[str, ...] = ()
    label: tuple[str, ...] = ()
    class_: tuple[str, ...] = ()
    phrase: tuple[str, ...] = ()
    """Names that a person gave to phrases; of one recording alone also their kinds, "kind 2"."""

    def __len__(self) -> int:
        """How many paths."""
        return len(self.first)

    def __repr__(self) -> str:
        """Its size in one line."""
        return (
            f"Network({len(self)} paths of {self.seconds:.1f} s, {len(self.indices)} successors, "
            f"threshold {self.threshold:.3g}, {len(self.pruned)} recordings pruned)"
        )

    def successors(self, path: int) -> Indices:
        """The paths that may follow one, the cheapest first."""
        return self.indices[self.indptr[path] : self.indptr[path + 1]]

    @cached_property
    def last(self) -> Indices:
        """Last moment of each path."""
        return self.repertoire.advance(self.first, self.length - 1)

    @cached_property
    def onward(self) -> Indices:
        """The moment with which the recording goes on after each path: the one whose place the next path's first takes."""
        return self.repertoire.advance(self.first, self.length)

    def edges(self, before: ArrayLike, after: ArrayLike) -> Indices:
        """Where in `indices` each path ``after`` follows the path ``before``, any shape; −1 where it does not."""
        order, keys = self._ordered
        key = np.asarray(before, dtype=np.intp) * len(self) + np.asarray(after, dtype=np.intp)
        at = np.minimum(np.searchsorted(keys, key), len(keys) - 1)
        return np.where(keys[at] == key, order[at], -1)

    @cached_property
    def _ordered(self) -> tuple[Indices, Indices]:
        """Places in `indices` in the order of both paths' numbers, and those numbers as one."""
        keys = np.repeat(np.arange(len(self)), np.diff(self.indptr)) * len(self) + self.indices
        order = np.argsort(keys)
        return order, keys[order]

    @cached_property
    def met(self) -> tuple[NDArray[np.complex128], Array]:
        """`meeting` as numbers, ahead + i·left, and radians: shape (successors,) each."""
        if self.meeting is None:
            return np.zeros(len(self.indices), dtype=np.complex128), np.zeros(len(self.indices))
        return self.meeting.place[:, 1] + 1j * self.meeting.place[:, 0], self.meeting.turn

    @cached_property
    def strand(self) -> Indices:
        """Strand of each path."""
        return self.repertoire.strand_of(self.first)

    @cached_property
    def recording(self) -> Indices:
        """Number of the recording of each path."""
        return self.repertoire.recording_of(self.repertoire.frame_of(self.first))

    @cached_property
    def mirror_of(self) -> Indices:
        """The path that is the mirror image of each, −1 where mirror images are not part of the network."""
        strand = self.strand
        image = self.first + np.where(strand % 2 == 0, 1, -1) * self.repertoire.frame_count
        return _places(self.first, image)

    @property
    def seconds(self) -> float:
        """Of all paths together."""
        return float(self.duration.sum())

    def path_at(self, moment: int) -> int:
        """The path that plays a moment, −1 if none does."""
        frame, strand = int(self.repertoire.frame_of(moment)), int(self.repertoire.strand_of(moment))
        chosen = np.flatnonzero(self.strand == strand)
        ends = self.repertoire.frame_of(np.stack([self.first[chosen], self.last[chosen]]))
        inside = chosen[(ends.min(axis=0) <= frame) & (frame <= ends.max(axis=0))]
        return int(inside[0]) if len(inside) else -1


def network(
    repertoire: Repertoire,
    *,
    transitions: Transitions | None = None,
    threshold: float | None = None,
    density: float = DENSITY,
    spacing: float = SPACING,
    weights: Weights | None = None,
    seams: Indices | Sequence[int] = (),
    progress: Progress = silent,
) -> Network:
    """Cut the recordings at their transitions and keep what can be performed without end.

    Parameters
    ----------
    transitions : as found by `kinesics.synthesis.transitions.transitions`, or some of them; found with the other parameters if
        not given.
    threshold, density, spacing, weights, progress : see there.
    seams : frames, over all recordings end to end, before which the recordings are cut besides: so that paths begin and end there.

    Returns
    -------
    Every path has a successor, and every path can be reached from every other.

    Raises
    ------
    InputError
        If there is no transition, or none leads back.

    Warns
    -----
    UserWarning
        If nothing of a recording is left; by name.
    """
    found = transitions
    if found is None:
        found = _transitions.transitions(
            repertoire, threshold=threshold, density=density, spacing=spacing, weights=weights, progress=progress
        )
    elif found.repertoire is not repertoire:
        raise InputError("The transitions were found in another repertoire than the one given.")
    if not len(found):
        raise InputError(_why_none(found))
    besides = np.asarray(seams, dtype=np.intp).reshape(-1)
    if len(besides) and not (besides.min() >= 0 and besides.max() < repertoire.frame_count):
        raise InputError(f"Expected `seams` below {repertoire.frame_count}, got {besides.min()} to {besides.max()}.")
    draft = _draft(repertoire, found, besides)
    while True:
        kept = _largest_part(draft)
        if not kept.any():
            raise InputError(
                f"Nothing can be performed without end: {len(found)} transitions were found in "
                f"{_names(repertoire.names)}, but none leads back to where it came from. Give longer recordings, in which "
                "the movement recurs, "
                + ("" if repertoire.mirrored else "`mirrored=True`, ")
                + "or a larger `threshold` "
                f"than {found.threshold:.3g} (mean D)."
            )
        # cuts of which no transition is left only divide what always follows
        inside = kept[draft.path] & kept[draft.indices] & (draft.transition >= 0)
        used = np.unique(draft.transition[inside])
        if len(used) == len(found):
            break
        found = _some(found, used)
        draft = _draft(repertoire, found, besides)
    return _finished(repertoire, found, draft, kept)


class _Draft(NamedTuple):
    """All paths between cuts, and all that may follow them."""

    first: Indices
    last: Indices
    length: Indices
    path: Indices
    """Of each succession the path before…"""
    indices: Indices
    """…and the path after…"""
    transition: Indices
    """…and the number of the transition between them, −1 where the recording goes on."""


def _draft(repertoire: Repertoire, found: Transitions, besides: Indices) -> _Draft:
    firsts: list[Indices] = []
    lasts: list[Indices] = []
    lengths: list[Indices] = []
    backward_source, backward_target = repertoire.is_backward(found.source), repertoire.is_backward(found.target)
    # the seam behind a moment from which one leaves, and the one before a moment at which one arrives
    behind = repertoire.frame_of(found.source) + np.where(backward_source, 0, 1)
    before = repertoire.frame_of(found.target) + np.where(backward_target, 1, 0)
    cuts = np.unique(np.concatenate([behind, before, repertoire.starts, besides]))
    for strand in repertoire.strands:
        start, end = repertoire.moments(cuts[:-1], strand), repertoire.moments(cuts[1:] - 1, strand)
        backward = BACKWARD_STRANDS[strand]
        firsts.append(end if backward else start)
        lasts.append(start if backward else end)
        lengths.append(np.diff(cuts))
    first, last, length = (np.concatenate(parts) for parts in (firsts, lasts, lengths))
    order = np.argsort(first)
    first, last, length = first[order], last[order], length[order]
    by_last = np.argsort(last)
    leaving = by_last[np.searchsorted(last[by_last], found.source)]
    onward = _places(first, repertoire.advance(last, 1))
    goes_on = np.flatnonzero(onward >= 0)
    return _Draft(
        first,
        last,
        length,
        np.concatenate([goes_on, leaving]),
        np.concatenate([onward[goes_on], _places(first, found.target)]),
        np.concatenate([np.full(len(goes_on), -1), np.arange(len(found))]).astype(np.intp),
    )


def _places(first: Indices, moments: Indices) -> Indices:
    """Number of the path that begins at each moment, −1 where none does."""
    at = np.minimum(np.searchsorted(first, moments), len(first) - 1)
    return np.where(first[at] == moments, at, -1)


def _largest_part(draft: _Draft) -> Mask:
    """The strongly connected part that plays longest and has a way round; none if no part has one."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    count = len(draft.first)
    matrix = csr_array((np.ones(len(draft.path), dtype=np.int8), (draft.path, draft.indices)), shape=(count, count))
    parts, part = connected_components(matrix, directed=True, connection="strong")
    inside = part[draft.path] == part[draft.indices]
    round_about = np.bincount(part[draft.path[inside]], minlength=parts) > 0
    frames = np.where(round_about, np.bincount(part, weights=draft.length, minlength=parts), 0.0)
    if not round_about.any():
        return np.zeros(count, dtype=np.bool_)
    # of two mirror images the one as recorded: it holds the earlier moments
    longest = np.flatnonzero(frames >= frames.max() - 0.5)
    return np.asarray(part == part[np.flatnonzero(np.isin(part, longest))[0]])


def _some(found: Transitions, which: Indices) -> Transitions:
    return dataclasses.replace(
        found,
        source=found.source[which],
        target=found.target[which],
        distance=found.distance[which],
        cost=found.cost[which],
    )


def _finished(repertoire: Repertoire, found: Transitions, draft: _Draft, kept: Mask) -> Network:
    number = np.cumsum(kept) - 1
    inside = kept[draft.path] & kept[draft.indices]
    before, after, transition = number[draft.path[inside]], number[draft.indices[inside]], draft.transition[inside]
    # only what was recorded costs nothing at all
    cost = np.where(transition < 0, 0.0, np.maximum(np.append(found.cost, 0.0)[transition], _LEAST_COST))
    apart = np.where(transition < 0, 0.0, np.append(found.distance, 0.0)[transition])
    order = np.lexsort((after, cost, before))
    first, length = draft.first[kept], draft.length[kept]
    onward = repertoire.advance(draft.last[kept], 1)
    assert (onward >= 0).all(), "the last frames of a recording lead nowhere"
    places = repertoire.roots_of(onward)[:, [0, 2]] - repertoire.roots_of(first)[:, [0, 2]]
    # a heading that is followed from frame to frame within every recording; only differences are used
    yaw = np.unwrap(repertoire.poses.yaw)
    mirrored = np.where(repertoire.is_mirrored(first), -1.0, 1.0)
    turn = mirrored * (yaw[repertoire.frame_of(onward)] - yaw[repertoire.frame_of(first)])
    pruned = _pruned(repertoire, first, length)
    gone = tuple(dict.fromkeys(p.recording for p in pruned if p.everything))
    if gone:
        warnings.warn(
            f"Nothing is performed of {_names(gone)}: no transition leads there and back again. Nearer recordings, longer "
            "ones or a larger `threshold` would join them.",
            stacklevel=3,
        )
    out = Network(
        repertoire=repertoire,
        first=first,
        length=length,
        indptr=np.searchsorted(before[order], np.arange(len(first) + 1)),
        indices=after[order],
        cost=cost[order],
        distance=apart[order],
        displacement=from_heading(places, repertoire.yaw_of(first)),
        turn=turn,
        duration=length / repertoire.fps,
        threshold=found.threshold,
        rule=found.limits.rule,
        pruned=pruned,
        meeting=_meeting(repertoire, onward[before], first[after], transition >= 0, order),
    )
    assert out.meeting is not None
    for values in (
        *out.meeting,
        out.first,
        out.length,
        out.indptr,
        out.indices,
        out.cost,
        out.distance,
        out.displacement,
        out.turn,
        out.duration,
    ):
        values.setflags(write=False)
    return out


def _meeting(repertoire: Repertoire, left: Indices, entered: Indices, leaps: Mask, order: Indices) -> Meeting:
    """How what is entered meets what is left, 0 where nothing leaps; in this order."""
    found = meetings(repertoire, left[leaps], entered[leaps])
    place, turn = np.zeros((len(left), 2)), np.zeros(len(left))
    place[leaps], turn[leaps] = found
    return Meeting(place[order], turn[order])


def _pruned(repertoire: Repertoire, first: Indices, length: Indices) -> tuple[Pruned, ...]:
    frames, fps = repertoire.frame_count, repertoire.fps
    played = np.zeros((4, frames), dtype=np.bool_)
    strand, frame = repertoire.strand_of(first), repertoire.frame_of(first)
    low = np.where(np.asarray(BACKWARD_STRANDS)[strand], frame - length + 1, frame)
    for s, start, count in zip(strand.tolist(), low.tolist(), length.tolist(), strict=True):
        played[s, start : start + count] = True
    out: list[Pruned] = []
    for name, (start, end) in zip(repertoire.names, itertools.pairwise(repertoire.starts.tolist()), strict=True):
        # strands that lose the same are told together
        losses: dict[bytes, list[int]] = {}
        for s in repertoire.strands:
            losses.setdefault(played[s, start:end].tobytes(), []).append(s)
        for strands in losses.values():
            used = played[strands[0], start:end]
            if used.all():
                continue
            how = " and ".join(STRANDS[s] for s in strands)
            if not used.any():
                everything = len(strands) == len(repertoire.strands)
                why = "no transition leads there and back again"
                out.append(Pruned(name, how, (end - start) / fps, why, True, everything))
                continue
            head, tail = int(np.argmax(used)), int(np.argmax(used[::-1]))
            middle = int(np.count_nonzero(~used)) - head - tail
            parts = [
                f"{count / fps:.2f} s {place}"
                for count, place in ((head, "before the first way in"), (tail, "after the last way out"))
                if count
            ] + ([f"{middle / fps:.2f} s between, from where no way leads back"] if middle else [])
            out.append(Pruned(name, how, (head + middle + tail) / fps, ", ".join(parts), False, False))
    return tuple(out)


def _why_none(found: Transitions) -> str:
    repertoire, nearest = found.repertoire, found.nearest
    names = _names(repertoire.names)
    advice = "Give longer recordings in which the movement recurs" + (
        "" if repertoire.mirrored else ", or `mirrored=True`"
    )
    if not np.isfinite(nearest.distance):
        return (
            f"There are no transitions in {names}: {repertoire.frame_count / repertoire.fps:.2f} s are too short to leave and "
            f"to arrive in. {advice}."
        )
    where = " and ".join(_where(repertoire, frame) for frame in (nearest.first, nearest.second))
    told = (
        f"There are no transitions in {names}. The nearest moments, {where}, have a mean D of {nearest.distance:.3g}; the "
        f"threshold is {found.threshold:.3g} ({found.limits.rule}). "
    )
    if found.refused and nearest.distance <= found.threshold:
        reasons = ", ".join(f"{what} ({count})" for what, count in found.refused.items())
        return f"{told}Moments near in pose differ in {reasons}. {advice}."
    return f"{told}{advice}, or a larger `threshold`."


def _where(repertoire: Repertoire, frame: int) -> str:
    recording = int(repertoire.recording_of(frame))
    return f"{repertoire.names[recording]} at {(frame - int(repertoire.starts[recording])) / repertoire.fps:.2f} s"


def _names(names: Sequence[str]) -> str:
    more = len(names) - _NAMES_AT_MOST
    return ", ".join(names[:_NAMES_AT_MOST]) + (f" and {more} more" if more > 0 else "")


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


def state_seams(repertoire: Repertoire, graph: MotionGraph) -> Indices:
    """Where the states of a motion graph are passed, entered and left: `seams` for `network`, so that paths can begin there.

    Parameters
    ----------
    graph : of the same recordings in the same order.
    """
    out: list[int] = []
    for number in range(min(len(graph.sources), repertoire.recording_count)):
        low, high = repertoire.starts[number : number + 2].tolist()
        rate = repertoire.fps / repertoire.source_fps[number]
        ends = {frame for step in graph.timeline(number) for frame in (step.start, step.end)}
        out += [low + round(frame * rate) for frame in sorted(ends) if 0 < round(frame * rate) < high - low]
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
