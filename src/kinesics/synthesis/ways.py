"""Shortest ways over the network of paths (Dijkstra), and where one may stand still."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from kinesics.synthesis.network import Network

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

MEASURES: Final = ("seconds", "cost")
"""What a way can be shortest in."""
JUMP: Final = 3.0
"""Seconds that a transition of cost 0 counts for on the shortest way, one of cost 1 twice as many: rather than leap from state to
state, which lie near each other where transitions do, one travels what was recorded, if that takes no longer than so."""
UNREACHABLE: Final = 1e4
"""Seconds put for a way that does not exist."""
SLOW: Final = 0.1
"""Metres a second below which a path stands."""
STILL_TURN: Final = 0.35
"""Radians a second below which it does not turn either."""


def seconds_to(network: Network, goals: Mask) -> Array:
    """Seconds from the beginning of each path until a goal path begins; 0 for goals, inf where none can be reached."""
    from scipy.sparse.csgraph import dijkstra

    return np.asarray(
        dijkstra(_backwards(network, "seconds"), indices=np.flatnonzero(goals), min_only=True), dtype=np.float64
    )


def next_towards(network: Network, goals: Mask) -> Indices:
    """The path that comes next on the quickest way from each path to a goal path; −1 for goals and where there is none."""
    from scipy.sparse.csgraph import dijkstra

    _, after, _ = dijkstra(
        _backwards(network, "seconds"), indices=np.flatnonzero(goals), min_only=True, return_predecessors=True
    )
    return np.where(after < 0, -1, after).astype(np.intp)


def shortest(network: Network, origins: Mask, goals: Mask, *, by: str = "seconds") -> list[int] | None:
    """Paths of the shortest way from an origin path to a goal path, both included; None if there is no way.

    Parameters
    ----------
    by : "seconds", every transition counting as `JUMP` and more; or "cost" of the transitions, then seconds.
    """
    from scipy.sparse.csgraph import dijkstra

    far, after, _ = dijkstra(
        _backwards(network, by, JUMP), indices=np.flatnonzero(goals), min_only=True, return_predecessors=True
    )
    # a way ends when its goal path has been played
    candidates = np.flatnonzero(origins & np.isfinite(far))
    if not len(candidates):
        return None
    path = int(candidates[np.argmin(far[candidates])])
    way = [path]
    while after[path] >= 0:
        path = int(after[path])
        way.append(path)
    return way


def stances(network: Network) -> Mask:
    """Paths in which the performer stands still and can go on standing for ever without leaving them: shape (paths,)."""
    from scipy.sparse.csgraph import connected_components

    from kinesics.synthesis.prospects import trails

    duration = np.asarray(network.duration, dtype=np.float64)
    ways = trails(network)
    end = ways.start + np.asarray(network.length, dtype=np.intp)
    slow = np.hypot(*np.asarray(network.displacement, dtype=np.float64).T) / duration < SLOW
    slow &= (ways.travelled[end] / duration < 3.0 * SLOW) & (np.abs(np.asarray(network.turn)) / duration < STILL_TURN)
    among = np.flatnonzero(slow)
    if not len(among):
        return np.asarray(slow, dtype=np.bool_)
    graph = _forwards(network, np.ones(len(network.indices)))[among][:, among]
    _, part = connected_components(graph, directed=True, connection="strong")
    lasting = (np.bincount(part)[part] > 1) | (graph.diagonal() > 0)
    found = np.zeros(len(slow), dtype=np.bool_)
    found[among[lasting]] = True
    return found


def _forwards(network: Network, values: Array) -> csr_array:
    from scipy.sparse import csr_array

    paths = len(network.first)
    return csr_array((values, np.asarray(network.indices), np.asarray(network.indptr)), shape=(paths, paths))


def _backwards(network: Network, by: str, jump: float = 0.0) -> csr_array:
    """The reversed graph: from each path to those that come before it; leaving a path costs what it lasts, and a transition
    ``jump`` seconds or more.
    """
    duration = np.asarray(network.duration, dtype=np.float64)
    cost = np.asarray(network.cost, dtype=np.float64)
    values = np.repeat(duration, np.diff(network.indptr))
    leaps = np.where(cost > 0.0, jump * (1.0 + cost), 0.0)
    values = 1e-6 * values + cost if by == "cost" else values + leaps
    return _forwards(network, values).T.tocsr()
