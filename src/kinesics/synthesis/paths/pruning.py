"""What a network leaves out, and why there is none, in words."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.joining.parts import Draft
from kinesics.synthesis.joining.transitions import Transitions
from kinesics.synthesis.repertoire import STRANDS, Repertoire

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

_NAMES_AT_MOST: Final = 8
_STRETCHES_AT_MOST: Final = 4
_WHY: Final = (
    "",
    "no transition leads back from there",
    "no transition leads there",
    "no transition leads there and back again",
    "a fault of the recording, in which the body leaps",
)
_FAULT: Final = 4


class Stretch(NamedTuple):
    """Part of a recording that the network leaves out."""

    start: float
    """Seconds of the recording."""
    end: float
    why: str
    """Whether nothing leads there, nothing leads back, or neither."""

    def __str__(self) -> str:
        """From when to when."""
        return f"{self.start:.2f}–{self.end:.2f} s"


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
    stretches: tuple[Stretch, ...] = ()
    """Which of its seconds, in their order."""

    def __str__(self) -> str:
        """One line."""
        return f"{self.recording}, {self.strand}: {self.seconds:.2f} s, {self.why}"


def pruned_of(repertoire: Repertoire, cut: Draft, kept: Mask, faulty: Mask) -> tuple[Pruned, ...]:
    """What is not played of the recordings.

    Parameters
    ----------
    cut : all paths, and all that may follow them.
    kept : the paths that are played, shape (paths,).
    faulty : frames that are left out for what is wrong in them, shape (frames,).
    """
    fps = repertoire.fps
    lot = np.zeros((4, repertoire.frame_count), dtype=np.intp)
    why = _lots(cut, kept)
    low = np.minimum(repertoire.frame_of(cut.first), repertoire.frame_of(cut.last))
    for s, start, count, what in zip(
        repertoire.strand_of(cut.first).tolist(), low.tolist(), cut.length.tolist(), why.tolist(), strict=True
    ):
        lot[s, start : start + count] = what
    lot[(lot > 0) & faulty] = _FAULT
    out: list[Pruned] = []
    for name, (start, end) in zip(repertoire.names, itertools.pairwise(repertoire.starts.tolist()), strict=True):
        # strands may lose it for different reasons
        everything = all(bool(lot[s, start:end].all()) for s in repertoire.strands)
        # strands that lose the same are told together
        losses: dict[bytes, list[int]] = {}
        for s in repertoire.strands:
            losses.setdefault(lot[s, start:end].tobytes(), []).append(s)
        for strands in losses.values():
            own = lot[strands[0], start:end]
            if not own.any():
                continue
            edges = [0, *(np.flatnonzero(np.diff(own)) + 1).tolist(), end - start]
            stretches = tuple(
                Stretch(a / fps, b / fps, _WHY[int(own[a])]) for a, b in itertools.pairwise(edges) if own[a]
            )
            whole = bool(own.all())
            alike = len({part.why for part in stretches}) == 1
            told = stretches[0].why if whole and alike else _told(stretches)
            seconds = float(np.count_nonzero(own)) / fps
            how = " and ".join(STRANDS[s] for s in strands)
            out.append(Pruned(name, how, seconds, told, whole, everything, stretches))
    return tuple(out)


def _told(stretches: Sequence[Stretch]) -> str:
    """Every reason once, and for it from when to when; of many stretches the longest."""
    longest = sorted(stretches, key=lambda part: part.start - part.end)
    shown, rest = sorted(longest[:_STRETCHES_AT_MOST]), longest[_STRETCHES_AT_MOST:]
    reasons = dict.fromkeys(part.why for part in shown)
    told = "; ".join(f"{why}: {', '.join(str(part) for part in shown if part.why == why)}" for why in reasons)
    if rest:
        shorter = "a shorter part" if len(rest) == 1 else f"{len(rest)} shorter parts"
        told += f"; and {shorter} of {sum(part.end - part.start for part in rest):.2f} s{' in all' if len(rest) > 1 else ''}"
    return told


def unperformed(pruned: Iterable[Pruned]) -> tuple[str, ...]:
    """Names of the recordings of which nothing is left, in their order."""
    return tuple(dict.fromkeys(p.recording for p in pruned if p.everything))


def _lots(cut: Draft, kept: Mask) -> Indices:
    """Of each path 0 if it is kept, else the number of the reason in `_WHY`."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order

    count = len(kept)
    reached: list[Mask] = []
    start = np.flatnonzero(kept)[0]
    for path, onward in ((cut.path, cut.indices), (cut.indices, cut.path)):
        graph = csr_array((np.ones(len(path)), (path, onward)), shape=(count, count))
        seen = np.zeros(count, dtype=np.bool_)
        seen[breadth_first_order(graph, start, return_predecessors=False)] = True
        reached.append(seen)
    entered, left = reached
    # whatever is both entered and left is kept
    return np.where(kept, 0, np.where(entered, 1, np.where(left, 2, 3)))


def why_none(found: Transitions) -> str:
    """Why no transition was found, and what would help."""
    repertoire, nearest = found.repertoire, found.nearest
    names = listed(repertoire.names)
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


def listed(names: Sequence[str]) -> str:
    """The first few names, and how many more there are."""
    more = len(names) - _NAMES_AT_MOST
    return ", ".join(names[:_NAMES_AT_MOST]) + (f" and {more} more" if more > 0 else "")
