"""D, D*, Z and Z* by loops, from the dissertation with its corrections: slow and obvious ([Schultz2012] §2.10-2.14, §3.1)."""

from __future__ import annotations

import itertools
import math

import numpy as np

# root, lowerback, upperback, thorax, lowerneck, upperneck, head | left femur tibia humerus radius | right ...
PARTNER = [0, 1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 7, 8, 9, 10]


def gravity(root):
    """Where down is, seen from the pelvis: Rᵀ (0, −1, 0)."""
    w, x, y, z = root
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return rotation.T @ np.array([0.0, -1.0, 0.0])


def mirror(pose):
    """W: (w, x, −y, −z) on every link, left and right swapped."""
    return np.array([[pose[p][0], pose[p][1], -pose[p][2], -pose[p][3]] for p in PARTNER])


def pose_distance(a, b, weights=None):
    """D of two poses, shape (15, 4) each."""
    weights = [1.0] * 15 if weights is None else list(weights)
    total = weights[0] * math.sqrt(max(0.0, (1.0 + float(gravity(a[0]) @ gravity(b[0]))) / 2.0))
    for link in range(1, 15):
        total += weights[link] * abs(sum(float(a[link][k]) * float(b[link][k]) for k in range(4)))
    return max(0.0, 1.0 - total / sum(weights))


def distance(a, b, weights=None):
    """D: out[i, j] of a[i] and b[j]."""
    return np.array([[pose_distance(p, q, weights) for q in b] for p in a]).reshape(len(a), len(b))


def mirror_distance(a, b, weights=None):
    """D*: out[i, j] of a[i] and the mirror image of b[j]."""
    return distance(a, [mirror(q) for q in b], weights)


def speed(poses, fps, weights=None):
    """√(2D)/Δt; entry 0 repeats entry 1."""
    steps = [math.sqrt(2.0 * pose_distance(p, q, weights)) * fps for p, q in itertools.pairwise(poses)]
    return np.array([steps[0], *steps]) if steps else np.zeros(1)


def diagonal_sums(d, length, reverse=False):
    """Sum of d[i + k, j + k] (reversed: d[i + k, j + length − 1 − k]) over k < length."""
    rows, columns = len(d) - length + 1, len(d[0]) - length + 1
    out = np.zeros((rows, columns))
    for i in range(rows):
        for j in range(columns):
            for k in range(length):
                out[i, j] += d[i + k][j + length - 1 - k if reverse else j + k]
    return out
