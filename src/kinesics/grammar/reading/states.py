"""Which moments are states: marks that lie together under D or D*, and the moment that stands for them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar import bias, ground, linkage
from kinesics.grammar.ground import Mark, Nearness
from kinesics.grammar.linkage import clusters
from kinesics.grammar.moments import Moments
from kinesics.grammar.reading.stretches import CELLS, below, cut_at, recording_of
from kinesics.similarity import chord

Array = NDArray[np.float64]

_CHIRAL: Final = 4.0
"""A pose with so many times the D*(a, a) of what still counts as symmetric is clearly not."""
_BIASED: Final = 2.0
"""A bias may double what counts as symmetric: both bones of a forearm turned by 40° against the other's make .008 of D*."""
_APART: Final = 4.0
"""No √(2D) is so large."""
_FEW_MARKS: Final = 500
"""So many are clustered sooner than SciPy is imported."""
_MOST_MARKS: Final = 6000
"""Marks that are compared all with all: what ten minutes have."""
_CLOSEST: Final = 0.25
"""Of very many marks, those nearer than this share of what makes a state are one."""


@dataclass(frozen=True)
class ReadState:
    """A state, up to its mirror image."""

    moment: int
    """A moment at which the movement is in it, unmirrored."""
    symmetric: bool
    traced: bool
    """Whether the movement stops or turns back there."""


def found_states(
    moments: Moments, fair: Moments, marks: Sequence[Mark], near: Nearness, breaks: Sequence[int]
) -> list[ReadState]:
    """The states that marked moments speak of; none where there are no marks.

    Parameters
    ----------
    fair : the moments from `without_bias`, by which poses are judged symmetric.
    breaks : moments at which another recording begins.
    """
    if not marks:
        return []
    groups = cluster(fair, marks, near.state, near.centred)
    return _refined(moments, [state_of(fair, group, near) for group in groups], near, breaks)


def cluster(moments: Moments, marks: Sequence[Mark], radius: float, symmetric: float = 0.0) -> list[list[Mark]]:
    """Marks that lie together under D or D*: complete linkage of √(2D). A symmetric pose is none with a clearly chiral one.

    Time and memory grow with the square of the marks. Of very many, those that lie closest together are taken as one first.
    """

    def apart(rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        return _chords(moments, rows, columns, symmetric)

    limit = float(np.sqrt(2.0 * radius))
    index, place = np.unique([m.moment for m in marks], return_inverse=True)
    reach = _CLOSEST * limit
    while len(index) > _MOST_MARKS:
        index, led = linkage.led(apart, index, reach, CELLS)
        place = led[place]
        reach *= 1.5
    labels = _complete_linkage(moments, index, limit, symmetric)[place]
    groups: dict[int, list[Mark]] = {}
    for mark, label in zip(marks, labels.tolist(), strict=True):
        groups.setdefault(label, []).append(mark)
    return sorted(groups.values(), key=lambda g: min(m.moment for m in g))


def _chords(moments: Moments, rows: NDArray[np.intp], columns: NDArray[np.intp], symmetric: float) -> Array:
    """√(2D) or √(2D*), whichever is less; of a symmetric and a clearly chiral pose more than any."""
    out = chord(np.minimum(*moments.between(rows, columns)))
    one, other = moments.symmetry[rows][:, None], moments.symmetry[columns][None, :]
    unlike = (np.minimum(one, other) < symmetric) & (np.maximum(one, other) > _CHIRAL * symmetric)
    return np.where(unlike, _APART, out)


def _complete_linkage(moments: Moments, index: NDArray[np.intp], limit: float, symmetric: float) -> NDArray[np.intp]:
    """Number of the cluster of each moment: no two in a cluster are further apart than ``limit``."""
    count = len(index)
    if count <= _FEW_MARKS:
        upper = np.triu(_chords(moments, index, index, symmetric), 1)
        return clusters(upper + upper.T, limit, "complete")
    from scipy.cluster.hierarchy import fcluster, linkage

    condensed = np.empty(count * (count - 1) // 2)
    step = max(1, CELLS // count)
    end = 0
    for first in range(0, count, step):
        part = _chords(moments, index[first : first + step], index[first:], symmetric)
        for k, row in enumerate(part):
            condensed[end : end + len(row) - k - 1] = row[k + 1 :]
            end += len(row) - k - 1
    return np.asarray(fcluster(linkage(condensed, "complete"), limit, "distance"), dtype=np.intp)


def without_bias(moments: Moments, near: Nearness, breaks: Sequence[int]) -> Moments:
    """The same moments, what keeps them from symmetry being no constant difference of left and right (`kinesics.grammar.bias`).

    Only of poses that are nearly symmetric as they are: in a recording of few poses the estimate holds some of their asymmetry, and
    no pose that is clearly chiral may become symmetric by it.
    """
    if moments.poses is None:
        return moments
    symmetry = moments.symmetry.copy()
    for start, end in pairwise((0, *breaks, moments.count)):
        part = moments.cut(start, end)
        estimate = bias.estimate(part)
        assert estimate is not None
        fair = np.minimum(part.symmetry, bias.without(part, estimate).symmetry)
        symmetry[start:end] = np.where(part.symmetry <= _BIASED * near.symmetric, fair, part.symmetry)
    return dataclasses.replace(moments, symmetry=symmetry)


def state_of(moments: Moments, group: Sequence[Mark], near: Nearness) -> ReadState:
    """The middle of a cluster, of its traced moments where there are any."""
    traced = [m for m in group if m.traced]
    middle = np.array([m.moment for m in (traced or group)])
    every = np.array([m.moment for m in group])
    step = max(1, CELLS // len(every))
    means = [
        np.minimum(*moments.between(middle[first : first + step], every)).mean(axis=1)
        for first in range(0, len(middle), step)
    ]
    moment = int(middle[np.concatenate(means).argmin()])
    symmetric = float(np.median(moments.symmetry[middle])) <= near.symmetric
    return ReadState(moment, symmetric, bool(traced))


def _refined(moments: Moments, states: Sequence[ReadState], near: Nearness, breaks: Sequence[int]) -> list[ReadState]:
    """States that are only passed, put where the ways cross: at the moment near by that most passages come closest to.

    Ways join early and part late, so the marks lie to either side of the state.
    """
    reach = max(1, round(ground.PARTING_S * moments.fps))
    everything = np.arange(moments.count)
    out = []
    for state in states:
        if state.traced:
            out.append(state)
            continue
        first, last = recording_of(state.moment, moments.count, breaks)
        around = np.arange(max(first, state.moment - reach), min(last, state.moment + reach + 1))
        close = around[moments.between(np.array([state.moment]), around)[0][0] < near.state]
        exact = max(near.same, 0.005 * near.spread)
        best = (0, -np.inf)
        moment = state.moment
        for candidate, *rows in zip(close.tolist(), *moments.between(close, everything), strict=True):
            depths = [
                ground.deepest(row[start:end]) for row in rows for start, end in cut_at(below(row, near.visit), breaks)
            ]
            through = [x for x in depths if x < exact]
            score = (len(through), -float(np.mean(through)) if through else -np.inf)
            if score > best:
                best, moment = score, candidate
        out.append(ReadState(moment, state.symmetric, False))
    return _distinct(moments, out, near)


def _distinct(moments: Moments, states: Sequence[ReadState], near: Nearness) -> list[ReadState]:
    """Of states that have come to lie in one place, the first traced one, else the first."""
    index = np.array([s.moment for s in states], dtype=np.intp)
    d, s = moments.between(index, index)
    apart = np.minimum(d, s)
    kept: list[int] = []
    for k in sorted(range(len(states)), key=lambda k: (not states[k].traced, states[k].moment)):
        if all(apart[k, o] >= 2 * near.visit for o in kept):
            kept.append(k)
    return [states[k] for k in sorted(kept)]
