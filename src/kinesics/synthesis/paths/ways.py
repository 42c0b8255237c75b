"""Shortest ways over the network of paths (Dijkstra), and where one may stand still."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.paths.trails import trails

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

MEASURES: Final = ("seconds", "cost")
"""What a way can be shortest in."""
JUMP: Final = 3.0
"""Seconds that a transition of cost 0 counts for on the shortest way, one of cost 1 twice as many: rather than leap from state to
state, which lie near each other where transitions do, one travels what was recorded, if that takes no longer than so."""
AVOIDED: Final = 10.0
"""Seconds that a path counts for besides which is gone only where there is hardly another."""
UNREACHABLE: Final = 1e4
"""Seconds put for a way that does not exist."""
SLOW: Final = 0.1
"""Metres a second below which a path stands."""
STILL_TURN: Final = 0.35
"""Radians a second below which it does not turn either."""


def seconds_to(network: Network, goals: Mask) -> Array:
    """Seconds from the beginning of each path until a goal path begins; 0 for goals, inf where none can be reached."""
    from scipy.sparse.csgraph import dijkstra

    return np.asarray(dijkstra(_backwards(network), indices=np.flatnonzero(goals), min_only=True), dtype=np.float64)


def next_towards(network: Network, goals: Mask) -> Indices:
    """The path that comes next on the quickest way from each path to a goal path; −1 for goals and where there is none."""
    from scipy.sparse.csgraph import dijkstra

    _, after, _ = dijkstra(_backwards(network), indices=np.flatnonzero(goals), min_only=True, return_predecessors=True)
    return np.where(after < 0, -1, after).astype(np.intp)


def shortest(
    network: Network, origins: Mask, goals: Mask, *, by: str = "seconds", avoiding: Mask | None = None
) -> list[int] | None:
    """Paths of the shortest way from an origin path to a goal path, both included; None if there is no way.

    Parameters
    ----------
    by : "seconds", every transition counting as `JUMP` and more; or "cost" of the transitions, then seconds.
    avoiding : paths each of which counts as `AVOIDED` seconds more, shape (paths,).
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    paths = len(network.first)
    seconds = np.asarray(network.duration, dtype=np.float64)
    seconds = seconds if avoiding is None else seconds + AVOIDED * avoiding
    seconds = 1e-6 * seconds if by == "cost" else seconds
    cost = np.asarray(network.cost, dtype=np.float64)
    leaps = cost if by == "cost" else np.where(cost > 0.0, JUMP * (1.0 + cost), 0.0)
    before = np.repeat(np.arange(paths), np.diff(network.indptr))
    ends = np.flatnonzero(goals)
    # leaving a path costs what it lasts; behind all goals lies one place, for a goal path is played, too
    values = np.concatenate([seconds[before] + leaps, seconds[ends]])
    tails = np.concatenate([before, ends])
    heads = np.concatenate([np.asarray(network.indices), np.full(len(ends), paths)])
    graph = csr_array((values, (heads, tails)), shape=(paths + 1, paths + 1))
    far, after, _ = dijkstra(graph, indices=np.array([paths]), min_only=True, return_predecessors=True)
    candidates = np.flatnonzero(origins & np.isfinite(far[:paths]))
    if not len(candidates):
        return None
    way = [int(candidates[np.argmin(far[candidates])])]
    while after[way[-1]] != paths:
        way.append(int(after[way[-1]]))
    return way


def between(network: Network, origins: Mask, goals: Mask, lead: float) -> Mask:
    """Paths on any way from an origin path to a goal path, those included, and what is gone just before and after them.

    Parameters
    ----------
    lead : seconds before an origin path, and after a goal path, within which paths begin, or end, that are taken besides.

    Returns
    -------
    Shape (paths,); none where there is no way.
    """
    duration = np.asarray(network.duration, dtype=np.float64)
    begun, ended = origins & leading_there(network, goals), goals & led_to(network, origins)
    if not begun.any():
        return np.zeros(len(duration), dtype=np.bool_)
    on_the_way = led_to(network, begun) & leading_there(network, ended)
    return np.asarray(on_the_way | (seconds_to(network, begun) <= lead) | (_seconds_since(network, ended) <= lead))


def leading_there(network: Network, goals: Mask) -> Mask:
    """Paths from which a goal path can be come to, those included: shape (paths,)."""
    return np.isfinite(seconds_to(network, goals))


def led_to(network: Network, origins: Mask) -> Mask:
    """Paths that can be come to from an origin path, those included: shape (paths,)."""
    return np.isfinite(_seconds_since(network, origins))


def leading_to(network: Network, path: int, seconds: float, most: float) -> list[int]:
    """Paths that come before one, the earliest first: see `following`."""
    owners = np.repeat(np.arange(len(network.first)), np.diff(network.indptr))
    return _on_and_on(network, owners, np.asarray(network.indices), path, seconds, most)[::-1]


def following(network: Network, path: int, seconds: float, most: float) -> list[int]:
    """Paths that come after one: as recorded, by the cheapest transition where the recording ends.

    Parameters
    ----------
    seconds : how long; less where a path would lead beyond, unless half of it would be missing.
    most : seconds that it may be in any case.
    """
    owners = np.repeat(np.arange(len(network.first)), np.diff(network.indptr))
    return _on_and_on(network, np.asarray(network.indices), owners, path, seconds, most)


def _on_and_on(network: Network, beside: Indices, here: Indices, path: int, seconds: float, most: float) -> list[int]:
    """Path after path: ``beside`` each path of ``here`` lies another."""
    out: list[int] = []
    lasted, spare = 0.0, 0.5 / network.repertoire.fps
    while lasted < seconds - spare:
        ways = np.flatnonzero(here == path)
        if not len(ways):
            break
        path = int(beside[ways[np.argmin(network.cost[ways])]])
        lasted += float(network.duration[path])
        too_long = lasted > seconds + spare and lasted - network.duration[path] >= 0.5 * seconds
        if too_long or lasted > most + spare or path in out:
            break
        out.append(path)
    return out


def stances(network: Network) -> Mask:
    """Paths in which the performer stands still and can go on standing for ever without leaving them: shape (paths,)."""
    from scipy.sparse.csgraph import connected_components

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


def _seconds_since(network: Network, origins: Mask) -> Array:
    """Seconds from the end of the last origin path until the end of each path; 0 for origins, inf where none leads there."""
    from scipy.sparse.csgraph import dijkstra

    lasts = np.asarray(network.duration, dtype=np.float64)[np.asarray(network.indices)]
    return np.asarray(
        dijkstra(_forwards(network, lasts), indices=np.flatnonzero(origins), min_only=True), dtype=np.float64
    )


def _forwards(network: Network, values: Array) -> csr_array:
    from scipy.sparse import csr_array

    paths = len(network.first)
    return csr_array((values, np.asarray(network.indices), np.asarray(network.indptr)), shape=(paths, paths))


def _backwards(network: Network) -> csr_array:
    """The reversed graph: from each path to those that come before it; leaving a path costs what it lasts."""
    duration = np.asarray(network.duration, dtype=np.float64)
    return _forwards(network, np.repeat(duration, np.diff(network.indptr))).T.tocsr()
