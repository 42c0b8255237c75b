"""Hierarchical clusters of a few hundred things, without SciPy: to import that takes longer than to cluster them."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def clusters(
    distances: NDArray[np.floating], within: float, linkage: Literal["average", "complete"]
) -> NDArray[np.intp]:
    """The number of each thing's cluster, counted from 0 in order of their first members; shape (things,).

    The same clusters as SciPy's ``fcluster(linkage(…), within, "distance")``.

    Parameters
    ----------
    distances : symmetric, shape (things, things); the diagonal does not count.
    within : two clusters are joined where they are no further apart than this.
    linkage : how far apart clusters are: the mean or the largest of the distances between their members.

    The clusters are joined along chains of nearest neighbours (Müllner 2011, "Modern hierarchical, agglomerative clustering
    algorithms", §3.2), in time that grows with the square of the number of things.
    """
    count = len(distances)
    apart = np.array(distances, dtype=np.float64)
    np.fill_diagonal(apart, np.inf)
    size = np.ones(count)
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


def _root(parent: NDArray[np.intp], thing: int) -> int:
    while parent[thing] != thing:
        thing = int(parent[thing])
    return thing
