"""Slow, obvious twins of `kinesics.synthesis.embodiment.pivots`: every choice of points tried, every point of a sole looked at."""

from __future__ import annotations

import itertools
import math

import numpy as np

from kinesics.synthesis.embodiment import pivots


def along(points: np.ndarray) -> tuple[list[np.ndarray], float]:
    """Points along a sole as parts of heel, ball and tip, and how far apart they are."""
    a = float(np.mean([np.linalg.norm(p[1] - p[0]) for p in points]))
    b = float(np.mean([np.linalg.norm(p[2] - p[1]) for p in points]))
    count = max(2, math.floor((a + b) / pivots.APART + 0.5) + 1)
    out = []
    for k in range(count):
        at = (a + b) * k / (count - 1)
        share = min(at / a, 1.0), max(at - a, 0.0) / b
        out.append(np.array([1.0 - share[0], share[0] - share[1], share[1]]))
    return out, (a + b) / (count - 1)


def turning(points: np.ndarray, height: np.ndarray) -> list[float]:
    """Radians that a foot turns in each step, less where it is steep or above the floor."""
    out = []
    for p, q, low, lower in zip(points, points[1:], height, height[1:], strict=False):
        before, after = p[2] - p[0], q[2] - q[0]
        turn = math.atan2(after[0], after[2]) - math.atan2(before[0], before[2])
        turn = abs((turn + math.pi) % (2.0 * math.pi) - math.pi)
        level = min(math.hypot(v[0], v[2]) / float(np.linalg.norm(v)) for v in (before, after))
        lowest = min(0.5 * (u + v) for u, v in zip(low, lower, strict=True))
        near = (pivots.NEAR[1] - lowest) / (pivots.NEAR[1] - pivots.NEAR[0])
        out.append(turn * level**2 * min(max(near, 0.0), 1.0))
    return out


def cost(
    points: np.ndarray, height: np.ndarray, fps: float, parts: list[np.ndarray], apart: float, chosen: list[int]
) -> float:
    """What it costs to stand on these points, one for each step."""
    turns = turning(points, height)
    reach = max(1, round(pivots.MEANWHILE * fps))
    total = 0.0
    for t, k in enumerate(chosen):
        middle = 0.5 * (height[t] + height[t + 1])
        moved = points[t + 1] - points[t]
        above = float(parts[k] @ middle - middle.min())
        farthest = max(float(np.linalg.norm(m)) for m in moved)
        total += float(np.linalg.norm((parts[k] @ moved)[[0, 2]]))
        total += farthest * max(above - pivots.GIVES, 0.0) / pivots.RISE
        beside = min(apart * k, apart * abs(k - max(range(len(parts)), key=lambda n: parts[n][1])), pivots.PAD)
        total += pivots.DRAWN * turns[t] * beside
        if t > 0:
            around = sum(turns[max(t - reach, 0) : t + reach])
            total += pivots.CHANGE * around * min(apart * abs(k - chosen[t - 1]), pivots.FARTHEST)
    return total


def least(points: np.ndarray, height: np.ndarray, fps: float) -> float:
    """The least cost of all choices."""
    parts, apart = along(points)
    every = itertools.product(range(len(parts)), repeat=len(points) - 1)
    return min(cost(points, height, fps, parts, apart, list(chosen)) for chosen in every)


def gone(points: np.ndarray, height: np.ndarray, fps: float, seconds: float = 0.3) -> float:
    """How far a sole goes on the floor, whatever point it may stand on: one before and one after any moment of some time, at worst.

    Of all points along the sole, and 3 cm beside, that are within 15 mm of the lowest the two that go least.
    """
    heel, ball, tip = points[:, 0], points[:, 1], points[:, 2]
    aside = np.cross(tip - heel, [0.0, 1.0, 0.0])
    aside /= np.linalg.norm(aside, axis=-1, keepdims=True)
    places, heights = [], []
    for k in range(41):
        u = k / 40.0
        part = [1.0 - u / 0.7, u / 0.7, 0.0] if u <= 0.7 else [0.0, (1.0 - u) / 0.3, (u - 0.7) / 0.3]
        for v in (-0.03, 0.0, 0.03):
            places.append(part[0] * heel + part[1] * ball + part[2] * tip + v * aside)
            heights.append(height @ np.array(part))
    at, above = np.array(places)[..., [0, 2]], np.array(heights)
    step, length = max(1, round(fps / 30.0)), max(3, round(seconds * fps))
    worst = 0.0
    for a in range(0, max(1, len(points) - length + 1), step):
        window, low = at[:, a : a + length : step], above[:, a : a + length : step]
        apart = np.linalg.norm(window[:, :, None] - window[:, None], axis=-1)
        ways = []
        for c in range(1, window.shape[1] + 1):
            both = []
            for part in (slice(0, c), slice(c - 1, None)):
                bears = low[:, part].min(axis=1) <= low[:, part].min() + 0.015
                both.append(float(apart[bears][:, part, part].max(axis=(1, 2)).min()))
            ways.append(sum(both))
        worst = max(worst, min(ways))
    return worst
