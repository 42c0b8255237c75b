"""Where one movement can go over into another: near moments of the recordings ([Schultz2012] §4.4, [Kovar2002] §3.1).

Seams, the places between frames, and the relations between them are told in `kinesics.synthesis.joining.seams`.

**Distance.** The mean of D over a short window about the two seams, frames a − h … a + h − 1 against b − h … b + h − 1
(reversed: against b + h − 1 … b − h), 2h frames in all.

**What must agree.** Pairs that are near enough, and of which neither differs too much in

- the velocity of the pose: by no more than .85 of the faster one (two of equal speed: 50 degrees apart), or, where both are
  slow, by half of what it usually changes within the time of a blend: one may begin to move from rest;
- the velocity of the root over the ground and its turning, seen from the heading, and its height: by no more than nine tenths
  of all moving moments change within the time of a blend, see `Limits`;
- the feet: none that stands where the other swings, unless it changes at the seam;
- where ankles and toes are beneath the body, seen from the heading: D is in angles and does not tell strides of unlike length, but
  a foot that stays where it bears must make up for the difference with its leg. By no more than `PLACE` of what all moving
  moments change within the time of a blend, 15 to 20 cm, a bearing foot by `BEARING` of that;
- and how fast they go there: by no more than `FOOT_VELOCITY` of what changes within that time.

The thresholds are found in the recordings (`kinesics.synthesis.joining.limits`).

**Which pairs.** In quiet standing everything is near everything. Each recording is therefore divided into *steps*, in which the
pose goes half of the threshold (of that found, if a larger one is given, which would else leave fewer seams) and which last .1 s
at least and 1 s at most. Of two steps the pair that costs least is kept: all that must agree counts for it, each as a share of
its limit (`Pairs.cost`). Used are the local minima among those, moved onto few seams; and besides whatever pairs it takes so that
nothing is lost that any of them joins (`kinesics.synthesis.joining.choice.joining`).

References
----------
- [Kovar2002] Kovar, Gleicher, Pighin: Motion graphs. SIGGRAPH 2002.
- [Arikan2002] Arikan, Forsyth: Interactive motion generation from examples. SIGGRAPH 2002.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.progress import Progress, silent
from kinesics.similarity import Weights, check_weights
from kinesics.synthesis.joining.choice import best, joining, lowest
from kinesics.synthesis.joining.limits import Limits, find_limits
from kinesics.synthesis.joining.seams import Pairs, Seams, ways
from kinesics.synthesis.joining.search import Nearest
from kinesics.synthesis.joining.sharing import Shared
from kinesics.synthesis.joining.widening import Pool, pool_of, widened
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

SPACING: Final = 0.1
"""Seconds between seams that are used, at least."""
DENSITY: Final = 30.0
"""Transitions that leave each second of each strand, at most, on average, but for those that join."""
_ROUNDS: Final = 4
"""Times that more is joined, where what was to join it agrees on no seams that there are."""


@dataclass(frozen=True, eq=False, repr=False)
class Transitions:
    """Where one may leave and where one then arrives, sorted by `source` and `cost`."""

    repertoire: Repertoire
    source: Indices
    """Moment after which one leaves."""
    target: Indices
    """Moment at which one arrives: it takes the place of the one that would follow `source`."""
    distance: Array
    """Mean D over the window."""
    cost: Array
    """In [0, 1]: mean of the squares of what differs, each as a share of its limit; going on as recorded would cost 0."""
    limits: Limits
    nearest: Nearest
    refused: Mapping[str, int]
    """Pairs that are near in pose, but differ too much in something else: what → how many."""

    def __len__(self) -> int:
        """How many."""
        return len(self.source)

    def __repr__(self) -> str:
        """How many, and how near."""
        return f"Transitions({len(self)} of {len(self.repertoire.names)} recordings, threshold {self.threshold:.3g})"

    @property
    def threshold(self) -> float:
        """Largest mean D accepted."""
        return self.limits.distance


def transitions(
    repertoire: Repertoire,
    *,
    threshold: float | None = None,
    density: float = DENSITY,
    spacing: float = SPACING,
    weights: Weights | None = None,
    progress: Progress = silent,
) -> Transitions:
    """Find the transitions within and between the recordings of a repertoire, mirrored and backward ones where it has them.

    Parameters
    ----------
    threshold : largest mean D accepted. If not given it is found in the recordings (`Limits.rule`), a larger one than usual where
        that leaves most of them out (`kinesics.synthesis.joining.widening`).
    density : transitions that leave each second of a strand, on average and at most; the best are kept, of every second and
        towards every recording. Each second names one at least, which is used from both its sides: less than 2 leaves
        hardly fewer than 2, and beyond that only twos count. Whatever it takes that nothing is lost comes on top.
    spacing : seconds between the moments at which one may leave or arrive, at least.
    weights : of the 15 links in D, see `kinesics.similarity.distance`.
    progress : told the fraction done; may raise to stop.

    Returns
    -------
    Possibly none: `Transitions.nearest` and `Transitions.refused` then tell why.

    Raises
    ------
    InputError
        If a parameter is not a positive number, or nothing moves in the recordings and no threshold is given.
    """
    for name, value in (("threshold", threshold), ("density", density), ("spacing", spacing)):
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise InputError(f"Expected `{name}` above 0, got {value}.")
    share = check_weights(weights)
    limits = find_limits(repertoire, threshold, share)
    pool = pool_of(repertoire, limits, share, spacing, progress)

    def chosen(pool: Pool) -> Pool:
        return pool._replace(pairs=_chosen(pool.seams, pool.pairs, density))

    used = chosen(pool)
    if threshold is None:
        used = widened(used, spacing, chosen, lambda done, said="": progress(0.9 + 0.1 * done, said))
    progress(1.0, "finding transitions")
    return _transitions(used)


def _chosen(seams: Seams, pool: Pairs, density: float) -> Pairs:
    """Those of a pool that are used, on few seams."""
    shared = Shared(seams)
    low = lowest(seams, pool)
    some, others = pool.take(low), pool.take(~low)
    # what joins goes first: it has the choice of seams
    needed = joining(seams, Pairs.none(), some), joining(seams, some, others)
    shared.hold(Pairs.joined([some.take(needed[0]), others.take(needed[1])]))
    left = pool.take(~_either(low, *needed))
    for _ in range(_ROUNDS):
        used = joining(seams, shared.pairs, left)
        if not used.any():
            break
        shared.hold(left.take(used))
        left = left.take(~used)
    shared.add(best(seams, some, 2.0 * density))
    densest = best(seams, shared.pairs, density)
    return Pairs.joined([densest, shared.pairs.take(joining(seams, densest, shared.pairs))])


def _either(low: Mask, among_low: Mask, among_others: Mask) -> Mask:
    """Two choices as one: among the low ones, and among the others."""
    out = np.zeros(len(low), dtype=np.bool_)
    out[low], out[~low] = among_low, among_others
    return out


def _transitions(pool: Pool) -> Transitions:
    """Every strand's transitions, in both directions."""
    stock, pairs = pool.seams.repertoire, pool.pairs
    leads = ways(stock, pairs)
    cost = pairs.cost[leads.pair]
    order = np.lexsort((leads.target, cost, leads.source))
    out = Transitions(
        stock,
        leads.source[order],
        leads.target[order],
        pairs.distance[leads.pair][order],
        cost[order],
        pool.limits,
        pool.found.nearest,
        pool.found.refused,
    )
    for values in (out.source, out.target, out.distance, out.cost):
        values.setflags(write=False)
    return out
