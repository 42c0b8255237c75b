"""By how much more could be performed if transitions might lead farther: which threshold joins what a network leaves out."""

from __future__ import annotations

import warnings
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.progress import Progress, silent
from kinesics.similarity import check_weights
from kinesics.synthesis import faults
from kinesics.synthesis.limits import find_limits
from kinesics.synthesis.network import Network, network
from kinesics.synthesis.parts import draft, largest_part
from kinesics.synthesis.seams import Pairs, Seams, ways
from kinesics.synthesis.search import search
from kinesics.synthesis.sharing import refined
from kinesics.synthesis.transitions import SPACING

Array = NDArray[np.float64]

FARTHEST: Final = 8.0
"""Times the threshold of the network that is looked up to; in √(2D), which is a length, that is less than three times."""
WORTH: Final = 0.9
"""Share of all that could be joined up to there which a threshold is to join."""
LEAST: Final = 0.05
"""Share of the recordings below which more is not worth telling."""
_TRIES: Final = 5
_RAISED: Final = 1.25


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
    limits = find_limits(repertoire, FARTHEST * short.threshold, weights)
    seams = Seams(repertoire, limits, weights, SPACING)
    pairs = refined(seams, search(seams, lambda share, said="": progress(0.6 * share, said)).pairs)
    steps = np.unique(pairs.distance[pairs.distance > short.threshold])
    total = repertoire.frame_count * len(repertoire.strands) / repertoire.fps
    if not len(steps):
        return None
    most = _seconds(seams, pairs)
    if most - short.seconds < LEAST * total:
        return None
    goal = short.seconds + WORTH * (most - short.seconds)
    low, high = 0, len(steps) - 1
    while low < high:
        middle = (low + high) // 2
        if _seconds(seams, pairs.take(pairs.distance <= steps[middle])) >= goal:
            high = middle
        else:
            low = middle + 1
    threshold = _rounded_up(float(steps[low]))
    best: Reach | None = None
    for number in range(_TRIES):
        progress(0.6 + 0.08 * number, "trying a larger threshold")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)
                made = network(repertoire, threshold=threshold)
        except InputError:
            made = short
        if made.seconds - short.seconds >= LEAST * total and (best is None or made.seconds > best.seconds):
            best = Reach(threshold, made)
        if made.seconds >= 0.95 * goal:
            break
        threshold = _rounded_up(_RAISED * threshold)
    return best


def _seconds(seams: Seams, pairs: Pairs) -> float:
    """Of the largest part that holds together."""
    leads = ways(seams.repertoire, pairs)
    edges = faults.edges(seams.repertoire.faults, seams.repertoire.starts)
    paths = draft(seams.repertoire, leads.source, leads.target, edges)
    leaping = faults.touching(seams.repertoire, paths.first, paths.last, faults.left_out(seams.repertoire, paths))
    paths = faults.without(paths, leaping)
    return float(paths.length[largest_part(paths)].sum() / seams.fps)


def _rounded_up(value: float) -> float:
    """To two digits, upwards."""
    unit = 10.0 ** (np.floor(np.log10(value)) - 1.0)
    return float(f"{np.ceil(value / unit - 1e-9) * unit:.2g}")
