"""Small networks of paths with known answers: steps over a floor, without bodies."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from kinesics.synthesis.paths.meeting import Meeting
from kinesics.synthesis.paths.network import Network

FPS = 20.0


class Path(NamedTuple):
    """One path, bent evenly."""

    name: str
    frames: int
    metres: float
    """Along the way."""
    turn: float
    """Radians."""
    begins: str = "A"
    ends: str = "A"


class Floor:
    """Stands for a repertoire: every path is a recording of its own, one frame longer than the path."""

    def __init__(self, paths: Sequence[Path], fps: float) -> None:
        self.fps = fps
        self.names = tuple(p.name for p in paths)
        places, yaws, starts = [], [], [0]
        for k, path in enumerate(paths):
            # each recording begins elsewhere and faces elsewhere: nothing may depend on that
            x, z, yaw = float(k), -2.0 * k, 0.7 * k
            for _ in range(path.frames + 1):
                places.append((x, 0.9, z))
                yaws.append((yaw + math.pi) % (2 * math.pi) - math.pi)
                middle = yaw + path.turn / path.frames / 2
                x += path.metres / path.frames * math.sin(middle)
                z += path.metres / path.frames * math.cos(middle)
                yaw += path.turn / path.frames
            starts.append(len(places))
        self.places, self.yaws, self.starts = np.array(places), np.array(yaws), np.array(starts)
        self.frame_count = len(places)
        self.source_fps = (fps,) * len(paths)
        self.source_frames = np.concatenate([np.arange(path.frames + 1.0) for path in paths])

    def advance(self, moments: Any, steps: Any = 1) -> Any:
        return np.asarray(moments) + np.asarray(steps)

    def roots_of(self, moments: Any) -> Any:
        return self.places[moments]

    def yaw_of(self, moments: Any) -> Any:
        return self.yaws[moments]

    def frame_of(self, moments: Any) -> Any:
        return np.asarray(moments)

    def strand_of(self, moments: Any) -> Any:
        return np.zeros_like(np.asarray(moments))

    def recording_of(self, frames: Any) -> Any:
        return np.searchsorted(self.starts, np.asarray(frames), side="right") - 1


def floor_network(
    paths: Sequence[Path], follows: dict[str, Sequence[str]] | None = None, *, fps: float = FPS, **words: Any
) -> Network:
    """A network of paths; ``follows`` names successors (all of all where not given), transitions of cost .5 but to itself."""
    floor = Floor(paths, fps)
    names = [p.name for p in paths]
    rows = [sorted((follows or {}).get(n, names), key=names.index) for n in names]
    indices = [names.index(n) for row in rows for n in row]
    owners = [k for k, row in enumerate(rows) for _ in row]
    first = floor.starts[:-1]
    last = floor.starts[1:] - 1
    step = floor.places[last] - floor.places[first]
    yaw = floor.yaws[first]
    displacement = np.stack(
        [np.cos(yaw) * step[:, 0] - np.sin(yaw) * step[:, 2], np.sin(yaw) * step[:, 0] + np.cos(yaw) * step[:, 2]],
        axis=1,
    )
    cost = np.array([0.0 if i == j else 0.5 for i, j in zip(owners, indices, strict=True)])
    length = np.array([p.frames for p in paths])
    return Network(
        repertoire=floor,
        first=first,
        length=length,
        indptr=np.concatenate([[0], np.cumsum([len(r) for r in rows])]),
        indices=np.array(indices),
        cost=cost,
        distance=cost * 0.01,
        displacement=displacement,
        turn=np.array([p.turn for p in paths]),
        duration=length / fps,
        threshold=0.01,
        rule="given",
        pruned=(),
        **words,
    )


STEPS = (
    Path("ahead", 10, 0.6, 0.0),
    Path("left", 10, 0.5, math.radians(40)),
    Path("right", 10, 0.5, math.radians(-40)),
    Path("stand", 5, 0.0, 0.0),
)
"""A walker that can go ahead, turn and stand."""


def walker(**words: Any) -> Network:
    """Every step may follow every other."""
    return floor_network(STEPS, **words)


def met(network: Network, seed: int = 0) -> Network:
    """The same network, what a transition enters lying a few centimetres and degrees beside what it leaves."""
    rng = np.random.default_rng(seed)
    leaps = network.cost > 0.0
    place = rng.uniform(-0.1, 0.1, (len(leaps), 2)) * leaps[:, None]
    return dataclasses.replace(network, meeting=Meeting(place, rng.uniform(-0.2, 0.2, len(leaps)) * leaps))
