"""Slow, obvious twins of `kinesics.synthesis.embodiment.rendering`: paths laid end to end, frame after frame."""

from __future__ import annotations

import math

import numpy as np


def laid(network, paths: list[int], start: tuple[float, float], heading: float, bend: list[float]) -> list[tuple]:
    """(x, z, yaw of the pelvis) of every frame, from the recordings' own places and headings alone."""
    repertoire = network.repertoire
    x, z = start
    out = []
    facing = heading
    for number, (path, extra) in enumerate(zip(paths, bend, strict=True)):
        if number:
            # how the path meets the one before
            followers = list(network.successors(paths[number - 1]))
            edge = int(network.indptr[paths[number - 1]]) + followers.index(path)
            left, ahead = network.meeting.place[edge]
            x += math.cos(facing) * left + math.sin(facing) * ahead
            z += -math.sin(facing) * left + math.cos(facing) * ahead
            facing += network.meeting.turn[edge]
        moment = int(network.first[path])
        length = int(network.length[path])
        own = float(repertoire.yaw_of(moment))
        for k in range(length):
            onward = int(repertoire.advance(moment, 1))
            turn = facing - own + extra * k / length
            out.append((x, z, float(repertoire.yaw_of(moment)) + turn))
            step = repertoire.roots_of(np.array([onward]))[0] - repertoire.roots_of(np.array([moment]))[0]
            half = turn + 0.5 * extra / length
            x += math.cos(half) * step[0] + math.sin(half) * step[2]
            z += -math.sin(half) * step[0] + math.cos(half) * step[2]
            moment = onward
        facing += float(repertoire.yaw_of(moment)) - own + extra
    return out
