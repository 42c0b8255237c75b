"""Hierarchical clusters of a few hundred things, without SciPy: to import that takes longer than to cluster them.

Of thousands of things not all distances are kept: `clusters_of_many` asks for them block by block.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

MOST: Final = 1500
"""Things of which all pairs are compared at once."""
CELLS: Final = 2_000_000
"""Distances that are asked for at once."""
_CLOSEST: Final = 0.5
"""Of very many things that are not far apart from each other, those within this share of the limit are taken as one first."""


def clusters(
    distances: NDArray[np.floating],
    within: float,
    linkage: Literal["average", "complete"],
    sizes: ArrayLike | None = None,
) -> NDArray[np.intp]:
    """The number of each thing's cluster, counted from 0 in order of their first members; shape (things,).

    The same clusters as SciPy's ``fcluster(linkage(…), within, "distance")``.

    Parameters
    ----------
    distances : symmetric, shape (things, things); the diagonal does not count.
    within : two clusters are joined where they are no further apart than this.
    linkage : how far apart clusters are: the mean or the largest of the distances between their members.
    sizes : how many each thing stands for; one without.

    The clusters are joined along chains of nearest neighbours (Müllner 2011, "Modern hierarchical, agglomerative clustering
    algorithms", §3.2), in time that grows with the square of the number of things.
    """
    count = len(distances)
    apart = np.array(distances, dtype=np.float64)
    np.fill_diagonal(apart, np.inf)
    size = np.ones(count) if sizes is None else np.array(sizes, dtype=np.float64)
    parent = np.arange(count)
    chain: list[int] = []
    for _ in range(count - 1):
        if not chain:
            chain = [int(np.flatnonzero(size)[0])]
        while True:
            here = chain[-1]
            near = int(apart[here].argmin())
            # the one before it in the chain wins where two are equally near, or the chain would run in a circle
            if len(chain) > 1 and apart[here, chain[-2]] <= apart[here, near]:
                break
            chain.append(near)
        gone, kept = sorted((chain.pop(), chain.pop()))
        if apart[gone, kept] <= within:
            parent[_root(parent, gone)] = _root(parent, kept)
        if linkage == "complete":
            joint = np.maximum(apart[gone], apart[kept])
        else:
            joint = (size[gone] * apart[gone] + size[kept] * apart[kept]) / (size[gone] + size[kept])
        apart[kept] = apart[:, kept] = joint
        apart[gone] = apart[:, gone] = np.inf
        apart[kept, kept] = np.inf
        size[kept] += size[gone]
        size[gone] = 0.0
    numbers: dict[int, int] = {}
    return np.array([numbers.setdefault(_root(parent, k), len(numbers)) for k in range(count)], dtype=np.intp)


def clusters_of_many(apart: Callable[[Indices, Indices], Array], count: int, within: float) -> Indices:
    """Clusters by average linkage of any number of things, numbered as by `clusters`; memory grows with their number.

    Things that no chain of neighbours within the limit joins are in no cluster together, so each such part is clustered by
    itself. In a part of more than `MOST` things those that lie closest together are taken as one first: an hour of standing is
    a few postures, each seen thousands of times.

    Parameters
    ----------
    apart : the distances of two lists of things, shape (rows, columns); asked for at most `CELLS` of them, or one row, at once
        where there are more than `MOST` things.
    """
    everything = np.arange(count)
    if count <= MOST:
        return clusters(apart(everything, everything), within, "average")
    labels = np.empty(count, dtype=np.intp)
    last = 0
    parts = _parts(apart, count, within)
    order = np.argsort(parts, kind="stable")
    for members in np.split(order, np.flatnonzero(np.diff(parts[order])) + 1):
        heads, number = members, np.arange(len(members))
        reach = _CLOSEST * within
        while len(heads) > MOST:
            heads, followed = led(apart, heads, reach, CELLS)
            number = followed[number]
            reach *= 1.5
        own = clusters(apart(heads, heads), within, "average", np.bincount(number))
        labels[members] = last + own[number]
        last += int(own.max()) + 1
    numbers: dict[int, int] = {}
    return np.array([numbers.setdefault(k, len(numbers)) for k in labels.tolist()], dtype=np.intp)


def _parts(apart: Callable[[Indices, Indices], Array], count: int, within: float) -> Indices:
    """A number for each thing: the same for two that a chain of things within the limit of each other joins."""
    everything = np.arange(count)
    part = everything.copy()
    step = max(1, CELLS // count)
    for first in range(0, count, step):
        for k, near in enumerate(apart(everything[first : first + step], everything[first:]) <= within, first):
            touched = part[first:][near]
            least = min(int(part[k]), int(touched.min(initial=count)))
            if (touched != least).any() or part[k] != least:
                joined = np.zeros(count, dtype=np.bool_)
                joined[touched] = joined[part[k]] = True
                part[joined[part]] = least
    return part


def led(
    apart: Callable[[Indices, Indices], Array], things: Indices, reach: float, cells: int
) -> tuple[Indices, Indices]:
    """Things of which no two lie within ``reach``; and for each thing the number of the one it is led by.

    Parameters
    ----------
    apart : the distances of two lists of things, shape (rows, columns).
    cells : distances that are asked for at once.
    """
    leader = np.full(len(things), -1, dtype=np.intp)
    heads: list[int] = []
    step = max(1, cells // len(things))
    for first in range(0, len(things), step):
        here = np.arange(first, min(first + step, len(things)))
        if heads:
            distances = apart(things[here], things[heads])
            nearest = distances.argmin(axis=1)
            known = distances[np.arange(len(here)), nearest] <= reach
            leader[here[known]] = nearest[known]
            here = here[~known]
        for k, row in zip(here.tolist(), apart(things[here], things[here]) <= reach, strict=True):
            if leader[k] < 0:
                followers = here[row]
                leader[followers[leader[followers] < 0]] = len(heads)
                leader[k] = len(heads)
                heads.append(k)
    return things[heads], leader


def _root(parent: NDArray[np.intp], thing: int) -> int:
    while parent[thing] != thing:
        thing = int(parent[thing])
    return thing
