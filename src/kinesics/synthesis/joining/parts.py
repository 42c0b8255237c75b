"""Paths between the cuts of a network, what may follow what, and which of them hold together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.repertoire import BACKWARD_STRANDS, Repertoire

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]


class Draft(NamedTuple):
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


def draft(repertoire: Repertoire, source: Indices, target: Indices, besides: Indices | None = None) -> Draft:
    """The recordings cut wherever a transition leaves or arrives.

    Parameters
    ----------
    source, target : moments after which one leaves, and at which one arrives, shape (transitions,).
    besides : frames before which the recordings are cut, too.
    """
    firsts: list[Indices] = []
    lasts: list[Indices] = []
    lengths: list[Indices] = []
    backward_source, backward_target = repertoire.is_backward(source), repertoire.is_backward(target)
    # the seam behind a moment from which one leaves, and the one before a moment at which one arrives
    behind = repertoire.frame_of(source) + np.where(backward_source, 0, 1)
    before = repertoire.frame_of(target) + np.where(backward_target, 1, 0)
    others = () if besides is None else (besides,)
    cuts = np.unique(np.concatenate([behind, before, repertoire.starts, *others]))
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
    leaving = by_last[np.searchsorted(last[by_last], source)]
    onward = places(first, repertoire.advance(last, 1))
    goes_on = np.flatnonzero(onward >= 0)
    return Draft(
        first,
        last,
        length,
        np.concatenate([goes_on, leaving]),
        np.concatenate([onward[goes_on], places(first, target)]),
        np.concatenate([np.full(len(goes_on), -1), np.arange(len(source))]).astype(np.intp),
    )


def places(first: Indices, moments: Indices) -> Indices:
    """Number of the path that begins at each moment, −1 where none does."""
    at = np.minimum(np.searchsorted(first, moments), len(first) - 1)
    return np.where(first[at] == moments, at, -1)


def frames_between(repertoire: Repertoire, first: Indices, last: Indices) -> Mask:
    """Which frames of the recordings paths play, in whatever strand, from their first and last moments: shape (frames,)."""
    ends = np.sort(repertoire.frame_of(np.stack([first, last])), axis=0)
    steps = np.zeros(repertoire.frame_count + 1, dtype=np.intp)
    np.add.at(steps, ends[0], 1)
    np.add.at(steps, ends[1] + 1, -1)
    return np.asarray(np.cumsum(steps)[:-1] > 0)


def largest_part(draft: Draft, among: Mask | None = None, holding: Mask | None = None) -> Mask:
    """The strongly connected part that plays longest and has a way round; none if no part has one.

    Parameters
    ----------
    among : which successions there are, shape (successions,); all unless given.
    holding : paths of which the part is to play as much as any, shape (paths,); longest only where that is the same.
    """
    parts = round_about(draft, among)
    if not parts:
        return np.zeros(len(draft.first), dtype=np.bool_)
    # the first of equals: of two mirror images the one as recorded, for it holds the earlier moments
    wanted = np.zeros_like(draft.length) if holding is None else draft.length * holding
    return max(parts, key=lambda part: (int(wanted[part].sum()), int(draft.length[part].sum())))


def round_about(draft: Draft, among: Mask | None = None) -> list[Mask]:
    """All strongly connected parts that have a way round, in the order of their first moments: shape (paths,) each.

    Parameters
    ----------
    among : which successions there are, shape (successions,); all unless given.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    count = len(draft.first)
    path, indices = (draft.path, draft.indices) if among is None else (draft.path[among], draft.indices[among])
    matrix = csr_array((np.ones(len(path), dtype=np.int8), (path, indices)), shape=(count, count))
    parts, part = connected_components(matrix, directed=True, connection="strong")
    inside = part[path] == part[indices]
    turning = np.bincount(part[path[inside]], minlength=parts) > 0
    numbers, first = np.unique(part[turning[part]], return_index=True)
    return [np.asarray(part == number) for number in numbers[np.argsort(first)].tolist()]
