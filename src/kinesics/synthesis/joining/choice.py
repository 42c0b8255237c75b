"""Which of many pairs of seams are used: the best of every second, and what joins all that can be joined."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.joining.parts import draft, largest_part
from kinesics.synthesis.joining.seams import Pairs, Seams, ways

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

_FORESTS: Final = 4
"""Times that recordings are joined, each time by other pairs of them: so that none hangs on one other alone."""
_BRIDGES: Final = 4
"""Pairs of seams that join two recordings, the cheapest: one alone may lead there and never back."""
_AS_GOOD_AS_FREE: Final = 1e-6
"""What it costs to go over by pairs that are chosen already, where any other costs 1 and more: any number of them is better than
one more pair, and of two ways over them the shorter one is taken."""


def best(seams: Seams, pairs: Pairs, density: float) -> Pairs:
    """The best of every second, in turn towards every recording and under every relation; and what joins recordings.

    Parameters
    ----------
    density : transitions that leave each second of a strand, on average: at most so many, but 2 at least and a whole number of
        twos; not counted are those that join recordings.
    """
    # a pair is left from either side; each second names half of its transitions, its partners name the others
    most = max(1, int(0.5 * density))
    starts = seams.repertoire.starts
    cost = np.tile(pairs.cost, 2)
    here, there = np.concatenate([pairs.a, pairs.b]), np.concatenate([pairs.b, pairs.a])
    second = ((here - starts[seams.recording[here]]) / seams.fps).astype(np.intp) + starts[seams.recording[here]]
    kind = np.tile(pairs.relation, 2) * seams.repertoire.recording_count + seams.recording[there]
    turn = _rank(cost, second, kind)
    named = _rank(turn + cost / 2.0, second) < most  # costs are little more than 1 at most
    return pairs.take(named[: pairs.size] | named[pairs.size :] | _bridges(seams, pairs))


def best_of_steps(seams: Seams, pairs: Pairs) -> Pairs:
    """Of every two steps and each relation the cheapest pair."""
    # moved by a frame or two, the second seam of a pair may come to lie before the first
    row, column = np.sort(np.stack([seams.cell[pairs.a], seams.cell[pairs.b]]), axis=0)
    return pairs.cheapest((pairs.relation * seams.steps + row) * seams.steps + column)


def lowest(seams: Seams, pairs: Pairs) -> Mask:
    """Which of pairs, one of every two steps (`best_of_steps`), cost no more than those of all the steps about them."""
    # a step beside the last of a recording belongs to none
    sides = np.stack([seams.cell[side] + 2 * seams.recording[side] + 1 for side in (pairs.a, pairs.b)])
    row, column = np.sort(sides, axis=0)
    width = seams.steps + 2 * seams.repertoire.recording_count + 2
    key = (pairs.relation * width + row) * width + column
    order = np.argsort(key)
    keys, costs = key[order], pairs.cost[order]
    out = np.ones(pairs.size, dtype=np.bool_)
    for beside in (d * width + e for d in (-1, 0, 1) for e in (-1, 0, 1) if d or e):
        at = np.minimum(np.searchsorted(keys, key + beside), max(len(keys) - 1, 0))
        out &= (keys[at] != key + beside) | (costs[at] >= pairs.cost)
    return out


def joining(seams: Seams, chosen: Pairs, others: Pairs) -> Mask:
    """Which of the other pairs it takes to join to the chosen ones all that can be joined by any of them.

    The largest strongly connected part that all pairs make holds one that the chosen ones alone make. From there to all the
    rest, and back again, lead the shortest ways: of few pairs and of cheap ones.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    out = np.zeros(others.size, dtype=np.bool_)
    both = Pairs.joined([chosen, others])
    if not others.size:
        return out
    leads = ways(seams.repertoire, both)
    paths = draft(seams.repertoire, leads.source, leads.target)
    whole = largest_part(paths)
    pair = np.append(leads.pair, -1)[paths.transition]
    free = pair < chosen.size
    inside = whole[paths.path] & whole[paths.indices]
    core = largest_part(paths, inside & free)
    if not whole.any() or (whole == core).all():
        return out
    if not core.any():
        core[np.flatnonzero(whole)[0]] = True
    weight = np.where(free, _AS_GOOD_AS_FREE, 1.0 + np.append(both.cost, 0.0)[pair])
    # of all that lead from one path to another the cheapest
    count = len(paths.first)
    key = paths.path * count + paths.indices
    order = np.lexsort((weight, key))
    order = order[inside[order]]
    order = order[np.append(True, np.diff(key[order]) > 0)]
    before, after = paths.path[order], paths.indices[order]
    forth = csr_array((weight[order], (before, after)), shape=(count, count))
    missing = np.flatnonzero(whole & ~core)
    used = []
    for graph, onward in ((forth, True), (forth.T.tocsr(), False)):
        _, came, _ = dijkstra(graph, indices=np.flatnonzero(core), min_only=True, return_predecessors=True)
        near = came[missing].astype(np.intp)
        used.append(near * count + missing if onward else missing * count + near)
    numbers = pair[order][np.searchsorted(key[order], np.concatenate(used))]
    out[numbers[numbers >= chosen.size] - chosen.size] = True
    return out


def _bridges(seams: Seams, pairs: Pairs) -> Mask:
    """The cheapest pairs that join all recordings and their mirror images that can be joined at all.

    Where many recordings are much alike, the best pairs of every second lie among those; a few dearer ones hold the others.
    So the spanning forest of least cost over recordings and mirror images is taken, several times over.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import minimum_spanning_tree

    count = seams.repertoire.recording_count
    first, second = seams.recording[pairs.a], seams.recording[pairs.b]
    # forwards and backwards make no difference here
    edge = (first * count + second) * 2 + pairs.relation % 2
    place = _rank(pairs.cost, edge)
    best = np.flatnonzero((place == 0) & ((first != second) | (pairs.relation % 2 == 1)))
    chosen = np.zeros(pairs.size, dtype=np.bool_)
    for _ in range(_FORESTS):
        if not len(best):
            break
        image = pairs.relation[best] % 2
        tails = np.concatenate([first[best], first[best] + count])
        heads = np.concatenate([second[best] + image * count, second[best] + (1 - image) * count])
        weights = np.tile(pairs.cost[best] + 1e-6, 2)
        tree = minimum_spanning_tree(csr_array((weights, (tails, heads)), shape=(2 * count, 2 * count))).tocoo()
        ends = np.minimum(tree.row, tree.col) * 2 * count + np.maximum(tree.row, tree.col)
        used = np.isin(np.minimum(tails, heads) * 2 * count + np.maximum(tails, heads), ends)
        taken = used[: len(best)] | used[len(best) :]
        chosen |= np.isin(edge, edge[best[taken]]) & (place < _BRIDGES)
        best = best[~taken]
    return chosen


def _rank(values: Array, *groups: Indices) -> Indices:
    """Place of each value, 0 the least, among those of its group."""
    order = np.lexsort((values, *groups))
    new = np.zeros(len(order), dtype=np.bool_)
    new[:1] = True
    for group in groups:
        new[1:] |= np.diff(group[order]) != 0
    place = np.arange(len(order))
    out = np.empty(len(order), dtype=np.intp)
    out[order] = place - np.maximum.accumulate(np.where(new, place, 0))
    return out
