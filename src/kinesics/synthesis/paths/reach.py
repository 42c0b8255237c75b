"""By how much more could be performed if transitions might lead farther: which threshold joins what a network leaves out."""

from __future__ import annotations

import warnings
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.progress import Progress, silent
from kinesics.similarity import check_weights
from kinesics.synthesis.joining.limits import find_limits
from kinesics.synthesis.joining.seams import Pairs, Seams
from kinesics.synthesis.joining.search import search
from kinesics.synthesis.joining.sharing import refined
from kinesics.synthesis.joining.transitions import SPACING
from kinesics.synthesis.joining.widening import (
    LEAST,
    NEARLY,
    RAISED,
    TRIES,
    WORTH,
    held_together,
    least_threshold,
    rounded_up,
)
from kinesics.synthesis.paths.network import Network, network

Array = NDArray[np.float64]

FARTHEST: Final = 8.0
"""Times the threshold that is looked up to, that of the network or the usual one, if that is less; in √(2D), which is a length,
that is less than three times."""


class Reach(NamedTuple):
    """What a larger threshold joins; it has been tried."""

    threshold: float
    """Mean D, of two digits."""
    network: Network
    """Made with it."""

    @property
    def seconds(self) -> float:
        """That can be performed with it, mirror images counted where they may be used."""
        return self.network.seconds


def farther(short: Network, progress: Progress = silent) -> Reach | None:
    """The least threshold that joins most of what can be joined at all, or None if no threshold worth trying joins more.

    Parameters
    ----------
    short : what a network is made of, found with its threshold.
    progress : told the fraction done; may raise to stop.
    """
    repertoire = short.repertoire
    weights = check_weights(None)
    usual = find_limits(repertoire, short.threshold, weights).found
    farthest = FARTHEST * min(short.threshold, usual)
    if farthest <= short.threshold:
        return None
    seams = Seams(repertoire, find_limits(repertoire, farthest, weights), weights, SPACING)
    pairs = refined(seams, search(seams, lambda share, said="": progress(0.6 * share, said)).pairs)
    total = repertoire.frame_count * len(repertoire.strands) / repertoire.fps
    if not (pairs.distance > short.threshold).any():
        return None
    most = _seconds(seams, pairs)
    if most - short.seconds < LEAST * total:
        return None
    goal = short.seconds + WORTH * (most - short.seconds)
    threshold = least_threshold(pairs, short.threshold, lambda some: _seconds(seams, some) >= goal)
    best: Reach | None = None
    for number in range(TRIES):
        progress(0.6 + 0.08 * number, "trying a larger threshold")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)
                made = network(repertoire, threshold=threshold)
        except InputError:
            made = short
        if made.seconds - short.seconds >= LEAST * total and (best is None or made.seconds > best.seconds):
            best = Reach(threshold, made)
        if made.seconds >= NEARLY * goal:
            break
        threshold = rounded_up(RAISED * threshold)
    return best


def _seconds(seams: Seams, pairs: Pairs) -> float:
    """Of the largest part that holds together."""
    paths, kept = held_together(seams, pairs)
    return float(paths.length[kept].sum() / seams.fps)
