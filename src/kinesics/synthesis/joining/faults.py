"""Faults of the recordings, in which the body leaps from one frame to the next as no movement does (`kinesics.body.leaps`).

They are left out where what is sound holds together without them. Elsewhere, in a short recording that nothing else leads through,
they stay, and the controller goes round them where it has a choice.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.joining.parts import Draft, largest_part
from kinesics.synthesis.repertoire import Repertoire

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

SOUND: Final = 0.9
"""Share of what is sound and can be performed that is to be left, or the fault is kept."""


def edges(faults: Mask, starts: Indices) -> Indices:
    """Frames before which faults begin and end, but for the ends of recordings."""
    changes = np.flatnonzero(np.diff(faults)) + 1
    return np.setdiff1d(changes, starts)


def touching(repertoire: Repertoire, first: Indices, last: Indices, faults: Mask) -> Mask:
    """Which paths, from their first and last moments, play any of some frames."""
    before = np.concatenate([[0], np.cumsum(faults)])
    ends = np.sort(repertoire.frame_of(np.stack([first, last])), axis=0)
    return np.asarray(before[ends[1] + 1] > before[ends[0]], dtype=np.bool_)


def left_out(repertoire: Repertoire, cut: Draft, holding: Mask | None = None) -> Mask:
    """Frames of the faults that are left out, shape (frames,).

    Parameters
    ----------
    cut : all paths, cut at the `edges` of faults, too, and all that may follow them.
    holding : paths that the part performed is to hold, shape (paths,): see `largest_part`.
    """
    faults = repertoire.faults
    out = np.zeros_like(faults)
    if not faults.any():
        return out
    faulty = touching(repertoire, cut.first, cut.last, faults)
    whole = largest_part(cut, holding=holding)
    enough = SOUND * int(cut.length[whole & ~faulty].sum())

    def holds(leaving: Mask) -> bool:
        rest = without(cut, touching(repertoire, cut.first, cut.last, leaving))
        return int(rest.length[largest_part(rest, holding=holding) & ~faulty].sum()) >= enough

    if holds(faults):
        return np.array(faults)
    steps = np.concatenate([[0], edges(faults, repertoire.starts), repertoire.starts[1:]])
    steps.sort()
    for start, end in zip(steps[:-1].tolist(), steps[1:].tolist(), strict=True):
        if faults[start:end].any():
            out[start:end] = True
            out[start:end] = holds(out)
    return out


def without(cut: Draft, faulty: Mask) -> Draft:
    """The same paths, none of which is followed by, or follows, some of them."""
    sound = ~(faulty[cut.path] | faulty[cut.indices])
    return cut._replace(path=cut.path[sound], indices=cut.indices[sound], transition=cut.transition[sound])
