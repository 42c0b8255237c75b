"""How much of the recordings can be performed, and whether a larger threshold would make it more."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.progress import Progress, silent
from kinesics.synthesis.joining.parts import frames_between
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.paths.reach import farther

TRIED: Final = 240.0
"""Seconds of recordings and their images, up to which a larger threshold is tried rather than advised."""


class Used(NamedTuple):
    """Seconds of recordings. What is performed mirrored or backwards alone is used, too."""

    used: float
    """That can be performed."""
    recorded: float

    @property
    def unused(self) -> float:
        """Share that cannot be performed."""
        return 1.0 - self.used / self.recorded


class OfRecording(NamedTuple):
    """How much of one of them."""

    name: str
    seconds: Used


class Larger(NamedTuple):
    """A larger threshold, which has been tried."""

    threshold: float
    """Mean D."""
    seconds: Used


def used(network: Network) -> Used:
    """Of all recordings together."""
    frames = frames_of(network)
    fps = network.repertoire.fps
    return Used(int(np.count_nonzero(frames)) / fps, len(frames) / fps)


def used_of_each(network: Network) -> list[OfRecording]:
    """Of each recording, those first of which most is left out."""
    stock = network.repertoire
    played = np.add.reduceat(frames_of(network).astype(np.intp), stock.starts[:-1]) / stock.fps
    have = np.diff(stock.starts) / stock.fps
    out = [OfRecording(*one) for one in zip(stock.names, map(Used, played.tolist(), have.tolist()), strict=True)]
    return sorted(out, key=lambda one: one.seconds.used - one.seconds.recorded)


def too_many(network: Network) -> bool:
    """Whether there are too many recordings to try a larger threshold with."""
    stock = network.repertoire
    return stock.frame_count * len(stock.strands) > TRIED * stock.fps


def larger_threshold(network: Network, progress: Progress = silent) -> Larger | None:
    """The least threshold that joins most of what can be joined at all (`synthesis.paths.reach.farther`); None for none."""
    found = farther(network, progress)
    return None if found is None else Larger(found.threshold, used(found.network))


def frames_of(network: Network) -> NDArray[np.bool_]:
    """Which frames of the recordings a network plays in whatever strand, shape (frames,)."""
    return frames_between(network.repertoire, network.first, network.last)
