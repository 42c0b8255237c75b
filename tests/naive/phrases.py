"""Slow and obvious: the best path through a pair of moments, and how well two cuts of one recording agree."""

from __future__ import annotations

import itertools
from collections.abc import Hashable, Sequence

import numpy as np


def path_through(distance: np.ndarray, i: int, j: int, steps: int, bend: float, *, backwards: bool) -> float:
    """Mean distance along the worse half of the cheapest path through (i, j), over all paths written out; i ≤ j throughout."""
    n = len(distance)
    # of the second side for one step of the first: as fast, standing, twice as fast
    moves = ((1, 0.0), (2, bend), (0, bend))

    def half(direction: int) -> float:
        best = np.inf
        for choice in itertools.product(moves, repeat=steps):
            a, b, cost = i, j, float(distance[i, j])
            for move, extra in choice:
                a += direction
                b += -direction * move if backwards else direction * move
                if not (0 <= a <= b < n):
                    break
                cost += extra + float(distance[a, b])
            else:
                best = min(best, cost)
        return best

    return max(half(1), half(-1)) / (steps + 1)


def hamming(found: Sequence[tuple[int, int, int]], labels: Sequence[tuple[Hashable, int, int]]) -> float:
    """Share of the labelled frames whose kind is not the one matched to their label, at the best one-to-one matching."""
    from scipy.optimize import linear_sum_assignment

    names = sorted({str(label) for label, _, _ in labels})
    last = max(end for _, _, end in labels)
    truth, guess = np.full(last, -1), np.full(last, -1)
    for label, start, end in labels:
        truth[start:end] = names.index(str(label))
    for kind, start, end in found:
        guess[start:end] = kind
    guess, truth = guess[truth >= 0], truth[truth >= 0]
    table = np.zeros((int(guess.max()) + 1, len(names)))
    for g, t in zip(guess, truth, strict=True):
        table[g, t] += 1
    rows, columns = linear_sum_assignment(-table)
    return 1.0 - float(table[rows, columns].sum()) / len(truth)
