"""How much of the recordings can be performed, and whether a larger threshold would make it more."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from kinesics.progress import Progress, silent
from kinesics.synthesis.network import Network
from kinesics.synthesis.reach import Reach, farther

TRIED: Final = 240.0
"""Seconds of recordings and their images, up to which a larger threshold is tried rather than advised."""


class Used(NamedTuple):
    """Seconds, mirror images counted where they may be used."""

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


def used(network: Network) -> Used:
    """Of all recordings together."""
    stock = network.repertoire
    return Used(network.seconds, stock.frame_count * len(stock.strands) / stock.fps)


def used_of_each(network: Network) -> list[OfRecording]:
    """Of each recording, those first of which most is left out."""
    stock = network.repertoire
    played = np.bincount(network.recording, network.duration, minlength=stock.recording_count)
    have = np.diff(stock.starts) * len(stock.strands) / stock.fps
    out = [OfRecording(*one) for one in zip(stock.names, map(Used, played.tolist(), have.tolist()), strict=True)]
    return sorted(out, key=lambda one: one.seconds.used - one.seconds.recorded)


def larger_threshold(network: Network, progress: Progress = silent) -> Reach | None:
    """See `kinesics.synthesis.reach.farther`; None where there is too much to try it with, too."""
    return farther(network, progress) if used(network).recorded <= TRIED else None
