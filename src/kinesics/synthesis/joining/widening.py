"""A larger threshold than the usual one, where by that most of the recordings cannot be performed.

The usual threshold of poses is the median of what moving moments change within a blend. Of exercises, in which poses are held and
then changed at once, it joins little. In all else moments may differ by what nine tenths of the moving moments change; where less
than half of the recordings hangs together poses may, too, or by `WIDER` times as much as usual where that is less: by the least
that joins most of what this bound would join.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.progress import Progress
from kinesics.similarity import chord
from kinesics.synthesis.joining import faults
from kinesics.synthesis.joining.choice import best_of_steps
from kinesics.synthesis.joining.limits import Limits
from kinesics.synthesis.joining.parts import Draft, draft, frames_between, largest_part
from kinesics.synthesis.joining.seams import Pairs, Seams, ways
from kinesics.synthesis.joining.search import Found, search
from kinesics.synthesis.joining.sharing import refined
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

MOSTLY: Final = 0.5
"""Share of the recordings that hangs together, below which a larger threshold is looked for."""
WORTH: Final = 0.9
"""Share of all that could be joined up to a bound which a threshold is to join."""
LEAST: Final = 0.05
"""Share of the recordings below which more is not worth a larger threshold."""
WIDER: Final = 1.6
"""Times the usual threshold that it is at most: by more, feet that stand all along were seen to slide (exercises of CMU's 13, 2.3
times), and a gesture was joined to itself alone."""
ENOUGH: Final = 2.0
"""Seconds that have to hang together: less would go round and round."""
TRIES: Final = 5
RAISED: Final = 1.25
"""Times the threshold that is tried next, where one joins less than it was to."""
NEARLY: Final = 0.95
"""Share of what it was to join that a threshold is content with."""


class Pool(NamedTuple):
    """Pairs of seams that agree within limits: all of them, or those that are used."""

    seams: Seams
    pairs: Pairs
    found: Found
    limits: Limits


def pool_of(repertoire: Repertoire, limits: Limits, weights: Array, spacing: float, progress: Progress) -> Pool:
    """What agrees within these limits."""
    seams = Seams(repertoire, limits, weights, spacing)
    found = search(seams, progress)
    # refined, some pairs lie in the same two steps as others
    return Pool(seams, best_of_steps(seams, refined(seams, found.pairs)), found, limits)


def widened(usual: Pool, spacing: float, chosen: Callable[[Pool], Pool], progress: Progress) -> Pool:
    """What is used where poses may differ by more; the same where half of the recordings hangs together, or no more would.

    Parameters
    ----------
    usual : what is used of what agrees within the usual limits.
    spacing : seconds between seams that are used, as there.
    chosen : a pool with those pairs alone that are used.
    progress : told the fraction done, if anything has to be done.
    """
    limits, stock = usual.limits, usual.seams.repertoire
    whole = stock.frame_count
    joins = frames_joined(usual.seams, usual.pairs)
    bound = min(limits.most, WIDER * limits.distance)
    if joins >= MOSTLY * whole or bound <= limits.distance:
        return usual

    def tried(distance: float, number: int) -> Pool:
        return pool_of(
            stock,
            dataclasses.replace(limits, distance=distance),
            usual.seams.weights,
            spacing,
            lambda share, said="": progress((number + share) / (TRIES + 1), said),
        )

    farthest = tried(bound, 0)
    most = frames_joined(farthest.seams, farthest.pairs)
    if most - joins < LEAST * whole or not (farthest.pairs.distance > limits.distance).any():
        return usual
    goal = joins + WORTH * (most - joins)
    threshold = least_threshold(
        farthest.pairs, limits.distance, lambda some: frames_joined(farthest.seams, some) >= goal
    )
    for number in range(TRIES):
        at_last = threshold >= bound
        # on the few seams that are used less may hang together
        out = chosen(farthest if at_last else tried(threshold, number + 1))
        held = frames_joined(out.seams, out.pairs)
        if at_last or held - joins >= NEARLY * (goal - joins):
            break
        threshold = rounded_up(RAISED * threshold)
    if held - joins < LEAST * whole or held < ENOUGH * stock.fps:
        return usual
    rule = (
        f"√(2D) of {chord(out.limits.distance):.3f}, by which {held / whole:.0%} of the recordings hang together; by the usual "
        f"{limits.rule.removeprefix('√(2D) of ')}, {joins / whole:.0%} do"
    )
    return out._replace(limits=dataclasses.replace(out.limits, rule=rule))


def least_threshold(pairs: Pairs, above: float, enough: Callable[[Pairs], bool]) -> float:
    """The least threshold above another by which pairs are enough, of two digits, upwards: that of all if no less will do."""
    steps = np.unique(pairs.distance[pairs.distance > above])
    low, high = 0, len(steps) - 1
    while low < high:
        middle = (low + high) // 2
        if enough(pairs.take(pairs.distance <= steps[middle])):
            high = middle
        else:
            low = middle + 1
    return rounded_up(float(steps[low]))


def held_together(seams: Seams, pairs: Pairs) -> tuple[Draft, Mask]:
    """The paths between all these pairs, and which of them are in the largest part; faults of the recordings are left out."""
    stock = seams.repertoire
    leads = ways(stock, pairs)
    paths = draft(stock, leads.source, leads.target, faults.edges(stock.faults, stock.starts))
    leaping = faults.touching(stock, paths.first, paths.last, faults.left_out(stock, paths))
    paths = faults.without(paths, leaping)
    return paths, largest_part(paths)


def frames_joined(seams: Seams, pairs: Pairs) -> int:
    """Frames of the recordings in the largest part, in whatever strand."""
    paths, kept = held_together(seams, pairs)
    return int(np.count_nonzero(frames_between(seams.repertoire, paths.first[kept], paths.last[kept])))


def rounded_up(value: float) -> float:
    """To two digits, upwards."""
    unit = 10.0 ** (np.floor(np.log10(value)) - 1.0)
    return float(f"{np.ceil(value / unit - 1e-9) * unit:.2g}")
