"""What a network leaves out, and why there is none, in words."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.repertoire import BACKWARD_STRANDS, STRANDS, Repertoire
from kinesics.synthesis.transitions import Transitions

Indices = NDArray[np.intp]

_NAMES_AT_MOST: Final = 8


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


def pruned_of(repertoire: Repertoire, first: Indices, length: Indices) -> tuple[Pruned, ...]:
    """What the paths of a network do not play: they begin at these moments and last so many frames, shape (paths,) each."""
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
