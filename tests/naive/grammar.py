"""Lag paths, turnings and folded movements by trying everything: slow and obvious ([Schultz2012] §3.2-3.4)."""

from __future__ import annotations

import math

import numpy as np


def cheapest_path(rows, bend):
    """Cost of the cheapest path through columns 0 … last, one row up or down a step at most, by recursion."""
    width, length = rows.shape

    def onward(t, k):
        if t == length - 1:
            return float(rows[k, t])
        steps = [(0.0, k), (bend, k - 1), (bend, k + 1)]
        return float(rows[k, t]) + min(cost + onward(t + 1, j) for cost, j in steps if 0 <= j < width)

    return min(onward(0, k) for k in range(width))


def turning_best(distance, reach, bend):
    """Least mean distance along a path outwards from the axis, over all places from which one ends at its place.

    Cells (i, j) with i ≤ j. From (i, j) to (i − 1, j + 1), weighing two, or to (i − 1, j) or (i, j + 1), weighing one and bending.
    """
    n = len(distance)

    def outward(i, j, left):
        if left == 0:
            return 0.0
        best = math.inf
        if left >= 2 and i > 0 and j < n - 1:
            best = min(best, 2.0 * distance[i - 1, j + 1] + outward(i - 1, j + 1, left - 2))
        if i > 0 and left >= 1:
            best = min(best, distance[i - 1, j] + bend + outward(i - 1, j, left - 1))
        if j < n - 1 and left >= 1:
            best = min(best, distance[i, j + 1] + bend + outward(i, j + 1, left - 1))
        return best

    best = math.inf
    for i in range(n):
        best = min(best, distance[i, i] + outward(i, i, 2 * reach), distance[i, i] + outward(i, i, 2 * reach - 1))
        if i < n - 1:
            best = min(best, distance[i, i + 1] + outward(i, i + 1, 2 * reach - 1))
            best = min(best, distance[i, i + 1] + outward(i, i + 1, 2 * reach - 2))
    return best / (2 * reach + 1)


def folded(distance, weight):
    """Cost of the cheapest way from (first, last) inwards to the identity axis, each step weighed by the moment it takes in."""
    n = len(distance)
    memo = {}

    def from_(i, j):
        """i moments taken from the front, j from the back, beyond the first of each."""
        if (i, j) not in memo:
            cell = distance[i, n - 1 - j]
            if i == 0 and j == 0:
                memo[i, j] = cell * (weight[0] + weight[n - 1])
            else:
                ways = []
                if i > 0:
                    ways.append(from_(i - 1, j) + cell * weight[i])
                if j > 0:
                    ways.append(from_(i, j - 1) + cell * weight[n - 1 - j])
                memo[i, j] = min(ways)
        return memo[i, j]

    return min(from_(i, n - 1 - i) for i in range(n))


def window_mean(distance, start, width):
    """Mean over all pairs of moments of a window."""
    part = np.asarray(distance)[start : start + width, start : start + width]
    return sum(float(v) for row in part for v in row) / part.size


def noise_of(points):
    """2D that noise leaves between middle and cubic, for points in a Euclidean space where 2D is the squared distance."""
    w = np.array([-1, 4, 4, -1]) / 6.0
    out = []
    for t in range(2, len(points) - 2):
        around = points[[t - 2, t - 1, t + 1, t + 2]]
        out.append(float(np.sum((points[t] - w @ around) ** 2)))
    return out
