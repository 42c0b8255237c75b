"""The paths between transitions and which may follow which: the δ of the dissertation's P = E(j)·δ ([Schultz2012] §4.4).

The recordings, in every strand that may be used, are cut at the seams of their transitions (`synthesis.joining.transitions`).
A *path* is what lies between two cuts. After it comes the path that the recording goes on with, at no cost, or one that a
transition leads to. What cannot be reached again from where it leads is a dead end: only the largest strongly connected part
is kept, and what was left out is said. If mirror images belong to it, the whole is its own mirror image. For ways that may end
there is the network of `everything`.

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
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.progress import Progress, silent
from kinesics.similarity import Weights
from kinesics.synthesis.joining import faults
from kinesics.synthesis.joining import transitions as _transitions
from kinesics.synthesis.joining.measures import from_heading
from kinesics.synthesis.joining.parts import Draft, draft, largest_part, places
from kinesics.synthesis.joining.transitions import DENSITY, SPACING, Transitions
from kinesics.synthesis.paths.meeting import Meeting, meetings
from kinesics.synthesis.paths.pruning import Pruned, listed, pruned_of, unperformed, why_none
from kinesics.synthesis.repertoire import BACKWARD_STRANDS, LEAST_SECONDS, Repertoire

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

_LEAST_COST: Final = 1e-12


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
    afoot: Repertoire | None = None
    """The recordings with their feet planted, where ways over the floor are theirs (`kinesics.synthesis.embodiment.afoot`)."""
    state_from: tuple[str, ...] = ()
    """The grammar's words for each path; empty until `kinesics.synthesis.paths.labels.labelled`."""
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
            f"threshold {self.threshold:.3g}, {len(unperformed(self.pruned))} recordings pruned)"
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

    def edge(self, before: int, after: int) -> int:
        """`edges` of one path behind one other."""
        order, keys = self._ordered
        key = before * len(self) + after
        at = int(keys.searchsorted(key))
        return int(order[at]) if at < len(keys) and keys[at] == key else -1

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
    def leaping(self) -> Mask:
        """Which paths play a fault of the recordings; none of recordings that are not known frame by frame. Shape (paths,)."""
        stock = self.repertoire
        known = isinstance(stock, Repertoire)
        return (
            faults.touching(stock, self.first, self.last, stock.faults)
            if known
            else np.zeros(len(self), dtype=np.bool_)
        )

    @cached_property
    def mirror_of(self) -> Indices:
        """The path that is the mirror image of each, −1 where mirror images are not part of the network."""
        strand = self.strand
        image = self.first + np.where(strand % 2 == 0, 1, -1) * self.repertoire.frame_count
        return places(self.first, image)

    @property
    def seconds(self) -> float:
        """Of all paths together."""
        return float(self.duration.sum())

    @property
    def endless(self) -> bool:
        """Whether something may follow every path."""
        return bool((np.diff(self.indptr) > 0).all())


def network(
    repertoire: Repertoire,
    *,
    transitions: Transitions | None = None,
    threshold: float | None = None,
    density: float = DENSITY,
    spacing: float = SPACING,
    weights: Weights | None = None,
    seams: Indices | Sequence[int] = (),
    holding: Mask | None = None,
    progress: Progress = silent,
) -> Network:
    """Cut the recordings at their transitions and keep what can be performed without end.

    Parameters
    ----------
    transitions : as found by `synthesis.joining.transitions.transitions`, or some of them; found with the other parameters if
        not given.
    threshold, density, spacing, weights, progress : see there.
    seams : frames, over all recordings end to end, before which the recordings are cut besides: so that paths begin and end there.
    holding : frames of which the part that is kept is to hold as many as any, shape (frames,); the largest unless given.

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
        raise InputError(why_none(found))
    besides = np.asarray(seams, dtype=np.intp).reshape(-1)
    if len(besides) and not (besides.min() >= 0 and besides.max() < repertoire.frame_count):
        raise InputError(f"Expected `seams` below {repertoire.frame_count}, got {besides.min()} to {besides.max()}.")
    besides = np.concatenate([besides, faults.edges(repertoire.faults, repertoire.starts)])
    cut = draft(repertoire, found.source, found.target, besides)
    faulty = faults.left_out(repertoire, cut, _holding(repertoire, cut, holding))
    cut = _sound(repertoire, cut, faulty)
    pruned: tuple[Pruned, ...] | None = None
    while True:
        kept = largest_part(cut, holding=_holding(repertoire, cut, holding))
        if int(cut.length[kept].sum()) < LEAST_SECONDS * repertoire.fps:
            back = (
                f"only {cut.length[kept].sum() / repertoire.fps:.2g} s hold together"
                if kept.any()
                else ("none leads back to where it came from")
            )
            raise InputError(
                f"Nothing can be performed without end: {len(found)} transitions were found in "
                f"{listed(repertoire.names)}, but {back}. Give longer recordings, in which the movement recurs, "
                + ("" if repertoire.mirrored else "`mirrored=True`, ")
                + "or a larger `threshold` "
                f"than {found.threshold:.3g} (mean D)."
            )
        # why anything is left out is seen while all transitions are there
        pruned = pruned_of(repertoire, cut, kept, faulty) if pruned is None else pruned
        # cuts of which no transition is left only divide what always follows
        inside = kept[cut.path] & kept[cut.indices] & (cut.transition >= 0)
        used = np.unique(cut.transition[inside])
        if len(used) == len(found):
            break
        found = _some(found, used)
        cut = _sound(repertoire, draft(repertoire, found.source, found.target, besides), faulty)
    return _finished(repertoire, found, cut, kept, pruned)


def everything(found: Transitions, seams: Indices | Sequence[int] = ()) -> Network:
    """All paths of the recordings and the transitions between them, dead ends included: for ways that may end.

    Of every recording the last frame is missing, and of one played backwards the first: nothing tells how either goes on.

    Parameters
    ----------
    found : the transitions.
    seams : as of `network`.
    """
    stock = found.repertoire
    besides = [
        np.asarray(seams, dtype=np.intp).reshape(-1),
        faults.edges(stock.faults, stock.starts),
        stock.starts[1:] - 1,
    ]
    if any(BACKWARD_STRANDS[strand] for strand in stock.strands):
        besides.append(stock.starts[:-1] + 1)
    cut = draft(stock, found.source, found.target, np.concatenate(besides))
    return _finished(stock, found, cut, stock.advance(cut.last, 1) >= 0, ())


def part_of(network: Network, kept: Mask) -> Network:
    """Some paths of a network, shape (paths,), and what of them may follow what."""
    number = np.cumsum(kept) - 1
    before = np.repeat(np.arange(len(network)), np.diff(network.indptr))
    inside = kept[before] & kept[network.indices]
    arrays: dict[str, Any] = {
        **{name: getattr(network, name)[kept] for name in ("first", "length", "displacement", "turn", "duration")},
        "indptr": np.searchsorted(number[before[inside]], np.arange(int(kept.sum()) + 1)),
        "indices": number[network.indices[inside]],
        "cost": network.cost[inside],
        "distance": network.distance[inside],
    }
    meeting = None if network.meeting is None else Meeting(*(values[inside] for values in network.meeting))
    for values in (*arrays.values(), *(meeting or ())):
        values.setflags(write=False)
    words: dict[str, Any] = {
        name: tuple(itertools.compress(getattr(network, name), kept))
        for name in ("state_from", "state_to", "label", "class_", "phrase")
    }
    return dataclasses.replace(network, **arrays, **words, meeting=meeting)


def _sound(repertoire: Repertoire, cut: Draft, faulty: Mask) -> Draft:
    """Without what follows faults that are left out, and what they follow."""
    return faults.without(cut, faults.touching(repertoire, cut.first, cut.last, faulty)) if faulty.any() else cut


def _holding(repertoire: Repertoire, cut: Draft, holding: Mask | None) -> Mask | None:
    return None if holding is None else faults.touching(repertoire, cut.first, cut.last, holding)


def _some(found: Transitions, which: Indices) -> Transitions:
    return dataclasses.replace(
        found,
        source=found.source[which],
        target=found.target[which],
        distance=found.distance[which],
        cost=found.cost[which],
    )


def _finished(
    repertoire: Repertoire, found: Transitions, cut: Draft, kept: Mask, pruned: tuple[Pruned, ...]
) -> Network:
    number = np.cumsum(kept) - 1
    inside = kept[cut.path] & kept[cut.indices]
    before, after, transition = number[cut.path[inside]], number[cut.indices[inside]], cut.transition[inside]
    # only what was recorded costs nothing at all
    cost = np.where(transition < 0, 0.0, np.maximum(np.append(found.cost, 0.0)[transition], _LEAST_COST))
    apart = np.where(transition < 0, 0.0, np.append(found.distance, 0.0)[transition])
    order = np.lexsort((after, cost, before))
    first, length = cut.first[kept], cut.length[kept]
    onward = repertoire.advance(cut.last[kept], 1)
    assert (onward >= 0).all(), "the last frames of a recording lead nowhere"
    places = repertoire.roots_of(onward)[:, [0, 2]] - repertoire.roots_of(first)[:, [0, 2]]
    # a heading that is followed from frame to frame within every recording; only differences are used
    yaw = np.unwrap(repertoire.poses.yaw)
    mirrored = np.where(repertoire.is_mirrored(first), -1.0, 1.0)
    turn = mirrored * (yaw[repertoire.frame_of(onward)] - yaw[repertoire.frame_of(first)])
    gone = unperformed(pruned)
    if gone:
        warnings.warn(
            f"Nothing is performed of {listed(gone)}: no transition leads there and back again. Nearer recordings, longer "
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
