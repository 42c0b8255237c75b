"""Poses that are taken again, as they were or in the mirror ([Schultz2012] §3.2.2, §3.4.2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar import linkage
from kinesics.grammar.moments import Moments
from kinesics.grammar.motifs.speed import speed_on_moments
from kinesics.grammar.ranges import STILL
from kinesics.similarity import chord

Array = NDArray[np.float64]

_CALM: Final = 0.5
"""A moment is calm whose speed is below this share of the greatest within a second."""
_SAME_STATE: Final = 2.0
"""Times the sway of a body at rest: so exactly people come back to a pose."""


@dataclass(frozen=True)
class StateRepetition:
    """Moments at which one pose is taken; with ``mirrored``, the pose and its mirror image."""

    moments: tuple[int, ...]
    mirrored: bool


def find_state_repetitions(moments: Moments) -> tuple[StateRepetition, ...]:
    """Poses that are taken again: calm moments and the first and last one, merged under D and under D*.

    Moments of one stay are one: between two of a set the body has been elsewhere.
    """
    marks = calm_moments(moments)
    if len(marks) < 2:
        return ()
    near = float(np.sqrt((_SAME_STATE * STILL) ** 2 + 4.0 * moments.noise))
    groups = _groups(moments, marks, near)
    visits = [_visits(moments, group, near) for group in groups]
    out = [StateRepetition(tuple(group), mirrored=False) for group in visits if len(group) > 1]
    out += [
        StateRepetition(tuple(sorted((*visits[a], *visits[b]))), mirrored=True)
        for a, b in _images(moments, visits, near)
    ]
    return tuple(out)


def calm_moments(moments: Moments) -> NDArray[np.intp]:
    """The first and last moment and those in between at which speed is least for a quarter of a second either way."""
    v = speed_on_moments(moments)
    n = len(v)
    apart = max(1, round(0.25 * moments.fps))
    padded = np.pad(v, apart, mode="edge")
    least = np.lib.stride_tricks.sliding_window_view(padded, 2 * apart + 1).min(axis=1)
    most = np.lib.stride_tricks.sliding_window_view(np.pad(v, 4 * apart, mode="edge"), 8 * apart + 1).max(axis=1)
    marks = np.flatnonzero((v <= least) & (v < _CALM * most))
    return np.unique(np.concatenate([[0], marks, [n - 1]])).astype(np.intp)


def _groups(moments: Moments, marks: NDArray[np.intp], near: float) -> list[NDArray[np.intp]]:
    """Marks merged under average linkage, groups in order of their first member."""

    def apart(rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        same = len(rows) == len(columns) and bool((rows == columns).all())
        d = moments.thinned(marks[rows])[0] if same else moments.between(marks[rows], marks[columns])[0]
        distances = chord(d.astype(np.float64))
        return 0.5 * (distances + distances.T) if same else distances

    labels = linkage.clusters_of_many(apart, len(marks), near)
    order = np.argsort(labels, kind="stable")
    return np.split(marks[order], np.flatnonzero(np.diff(labels[order])) + 1)


def _images(moments: Moments, visits: Sequence[Sequence[int]], near: float) -> Iterator[tuple[int, int]]:
    """Pairs of groups of moments, the earlier first, that are mirror images: √(2D*) of their moments is small on average."""
    index = np.concatenate([np.asarray(v, dtype=np.intp) for v in visits])
    sizes = np.array([len(v) for v in visits])
    firsts = np.cumsum([0, *sizes[:-1]])
    group_of = np.repeat(np.arange(len(visits)), sizes)
    step = max(1, linkage.CELLS // len(index))
    # rows of one group may lie in two blocks
    open_, total = 0, np.zeros(len(visits))
    for first in range(0, len(index), step):
        block = chord(moments.between(index[first : first + step], index)[1].astype(np.float64))
        for group, row in zip(
            group_of[first : first + step].tolist(), np.add.reduceat(block, firsts, axis=1), strict=True
        ):
            if group != open_:
                yield from _near_images(open_, total, sizes, near)
                open_, total = group, np.zeros(len(visits))
            total += row
    yield from _near_images(open_, total, sizes, near)


def _near_images(group: int, total: Array, sizes: NDArray[np.intp], near: float) -> Iterator[tuple[int, int]]:
    for other in np.flatnonzero(total <= near * sizes * sizes[group]).tolist():
        if other > group:
            yield group, other


def _visits(moments: Moments, marks: NDArray[np.intp], near: float) -> list[int]:
    """One moment for each visit: between two of them the body has been further away than ``near``."""
    out = [int(marks[0])]
    for mark in marks[1:]:
        index = np.unique(np.linspace(out[-1], int(mark), 32).round().astype(np.intp))
        if float(chord(moments.thinned(index)[0][0].astype(np.float64)).max()) > near:
            out.append(int(mark))
    return out
