"""Slow and obvious: the Markov row, shortest ways by trying, a bent way step by step ([Schultz2012] §4.4.1)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any


def world_displacement(left: float, ahead: float, heading: float) -> tuple[float, float]:
    """x, z of a displacement seen from a heading."""
    return (
        math.cos(heading) * left + math.sin(heading) * ahead,
        -math.sin(heading) * left + math.cos(heading) * ahead,
    )


def markov_row(
    network: Any,
    path: int,
    position: tuple[float, float],
    heading: float,
    target: tuple[float, float],
    *,
    beta: float,
    reach: float,
    spread: float,
) -> dict[int, float]:
    """P of every path after one, for a target: single paths, nothing looked ahead to."""
    dx, dz = target[0] - position[0], target[1] - position[1]
    far = math.hypot(dx, dz)
    if far > reach:
        dx, dz = dx * reach / far, dz * reach / far
    exponents = {}
    for j in range(len(network.first)):
        follows = j in network.indices[network.indptr[path] : network.indptr[path + 1]]
        if not follows:
            continue
        x, z = world_displacement(network.displacement[j][0], network.displacement[j][1], heading)
        exponents[j] = -beta * ((x - dx) ** 2 + (z - dz) ** 2) / spread**2
    largest = max(exponents.values())
    weights = {j: math.exp(e - largest) for j, e in exponents.items()}
    total = sum(weights.values())
    return {j: w / total for j, w in weights.items()}


def bent_way(places: Sequence[tuple[float, float]], bend: float) -> tuple[list[tuple[float, float]], list[float]]:
    """A way (x, z) whose every stride is turned by the bend times the metres walked up to its middle; and the turns."""
    out, turns, walked = [(0.0, 0.0)], [0.0], 0.0
    for (x0, z0), (x1, z1) in itertools.pairwise(places):
        stride = math.hypot(x1 - x0, z1 - z0)
        angle = bend * (walked + stride / 2)
        dx, dz = world_displacement(x1 - x0, z1 - z0, angle)
        out.append((out[-1][0] + dx, out[-1][1] + dz))
        walked += stride
        turns.append(bend * walked)
    return out, turns


def seconds_to(network: Any, goals: Sequence[int], jump: float = 0.0) -> list[float]:
    """Seconds from each path's beginning until a goal begins, by relaxing every succession until nothing changes.

    A transition counts as ``jump`` seconds, times 1 + its cost.
    """
    best = [0.0 if j in goals else math.inf for j in range(len(network.first))]
    changed = True
    while changed:
        changed = False
        for i in range(len(best)):
            for e in range(network.indptr[i], network.indptr[i + 1]):
                j, cost = network.indices[e], network.cost[e]
                way = network.duration[i] + best[j] + (jump * (1.0 + cost) if cost > 0.0 else 0.0)
                if i not in goals and way < best[i] - 1e-12:
                    best[i], changed = way, True
    return best


def chain_end(network: Any, paths: Sequence[int], before: int = -1) -> tuple[float, float, float]:
    """x, z and heading where paths played one after the other end, begun at 0, 0 facing +z, behind another path if told."""
    x = z = heading = 0.0
    for path in paths:
        if before >= 0 and network.meeting is not None:
            edge = network.indptr[before] + list(network.successors(before)).index(path)
            dx, dz = world_displacement(network.meeting.place[edge][0], network.meeting.place[edge][1], heading)
            x, z, heading = x + dx, z + dz, heading + network.meeting.turn[edge]
        dx, dz = world_displacement(network.displacement[path][0], network.displacement[path][1], heading)
        x, z, heading = x + dx, z + dz, heading + network.turn[path]
        before = path
    return x, z, heading
