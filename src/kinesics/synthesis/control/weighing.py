"""What each path that may come next, and all that may follow it, is weighed as: the row of P of [Schultz2012] §4.4.1."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.control.intentions import Composite, Intentions
from kinesics.synthesis.goals import Pursuit, Situation, TrailPursuit
from kinesics.synthesis.paths.prospects import AT_ONCE, Prospects
from kinesics.synthesis.paths.trails import Trail

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

TOO_SOON: Final = 1.0
"""What leaving a recording sooner weighs, in squared spreads, where all else comes back at once: no loop is a prison."""
LEAPING: Final = 1.0
"""What every path weighs in which the recording leaps (`synthesis.joining.faults`), in squared spreads: it is gone round where
that costs less."""
OPENING: Final = 0.02
"""Where to begin is drawn by E to this power: so that other seeds begin otherwise, and none by standing about."""


class Row(NamedTuple):
    """A row of P, and the composites that stand behind it."""

    paths: Indices
    probabilities: Array
    miss: Array
    groups: Indices
    first: int
    planned: Composite | None
    prospects: Prospects

    def drawn(self, rng: np.random.Generator) -> int:
        """The number of one of the paths."""
        return drawn(self.probabilities, rng)

    def best(self, successor: int) -> Composite:
        """The best composite that begins with a successor."""
        low = int(self.groups[successor])
        high = int(self.groups[successor + 1]) if successor + 1 < len(self.groups) else len(self.miss)
        index = low + int(np.argmin(self.miss[low:high]))
        miss = float(self.miss[index])
        if self.planned is not None and self.planned.paths[0] == self.paths[successor] and self.planned.miss < miss:
            return self.planned
        row = self.first + index
        sequence = self.prospects.sequence[row]
        paths = tuple(sequence[sequence >= 0].tolist())
        return Composite(paths, self.prospects.along(slice(row, row + 1)), miss)


class Weighing:
    """By what is pursued on one network.

    Parameters
    ----------
    bend : greatest bend of the way, radians a metre.
    hold : seconds that a recording is kept before it is left again, where there is a choice.
    """

    def __init__(
        self, network: Network, prospects: Prospects, intentions: Intentions, beta: float, bend: float, hold: float
    ) -> None:
        self.network, self.prospects, self.intentions = network, prospects, intentions
        self.beta, self._bend, self._hold = beta, bend, hold
        self.pursuits: list[Pursuit] = []
        self._indptr = np.asarray(network.indptr).tolist()
        self._rows = prospects.rows.tolist()
        leaping = network.leaping
        # of a path that is not there (-1) nothing
        self._leaping = np.append(LEAPING * leaping, 0.0) if leaping.any() else None

    def bend_of(self, pursuit: Pursuit) -> float:
        """The greatest bend that a pursuit may reckon with, radians a metre."""
        return self._bend if isinstance(pursuit, TrailPursuit) and pursuit.steers else 0.0

    def misses(self, now: Situation) -> Array:
        """Of all composites that may come next."""
        rows = slice(self._rows[now.path], self._rows[now.path + 1])
        miss = np.zeros(rows.stop - rows.start)
        for pursuit in self.pursuits:
            miss += pursuit.miss(rows, now, self.bend_of(pursuit))
        if self._leaping is not None:
            miss += self._leaping[self.prospects.sequence[rows]].sum(axis=1)
        if now.since_jump < self._hold:
            hasty = self.prospects.first_jump[rows] + now.since_jump < self._hold
            if hasty.any() and not hasty.all():
                miss[hasty] += np.inf if self._leads_on(rows, ~hasty) else TOO_SOON
        return miss

    def planned(self, intention: Composite | None, now: Situation) -> Composite | None:
        """What is intended, followed by the best of what may come after it."""
        continued = None if intention is None else self.intentions.continued(intention, now)
        if intention is None or continued is None:
            return None
        miss, rows = self._weighed(continued.trail, now), continued.rows
        if rows is not None:
            if self._leaping is not None:
                miss += self._leaping[self.prospects.sequence[rows]].sum(axis=1)
            hasty = self.prospects.first_jump[rows] + continued.since_jump < self._hold
            if not hasty.all():
                miss[hasty] = np.inf
        best = int(np.argmin(miss))
        planned = self.intentions.chosen(intention, continued, best, float(miss[best]))
        return planned._replace(miss=planned.miss + self._chained(planned.paths, intention.paths, now))

    def row(self, now: Situation, miss: Array, planned: Composite | None) -> Row:
        """The row of P, of what the composites miss and what is planned."""
        low, high = self._indptr[now.path], self._indptr[now.path + 1]
        first = self._rows[now.path]
        groups = self.prospects.start[low:high] - first
        least = np.minimum.reduceat(miss, groups)
        paths = self.network.indices[low:high]
        if planned is not None:
            least = np.where(paths == planned.paths[0], np.minimum(least, planned.miss), least)
        above = least - least.min()
        return Row(paths, self._chances(above), miss, groups, first, planned, self.prospects)

    def opening(self, now: Situation) -> Array:
        """The probability of each path to begin with: any, weighed by E where it is said whither to go; shape (paths,)."""
        led = [p for p in self.pursuits if isinstance(p, TrailPursuit)]
        miss = np.zeros(len(self.network.first))
        if led:
            # composites that begin with each path, behind whichever path
            _, edge = np.unique(self.network.indices, return_index=True)
            count = self.prospects.start[edge + 1] - self.prospects.start[edge]
            group = np.cumsum(count) - count
            rows = np.repeat(self.prospects.start[edge] - group, count) + np.arange(int(count.sum()))
            trail = self.prospects.along(rows)
            for pursuit in led:
                miss += np.minimum.reduceat(pursuit.weigh(trail, now, self.bend_of(pursuit)), group)
        if self._leaping is not None and not self._leaping[:-1].all():
            miss[self._leaping[:-1] > 0.0] = np.inf
        return self._chances(OPENING * (miss - miss.min()))

    def _leads_on(self, rows: slice, which: NDArray[np.bool_]) -> bool:
        """Whether any of some composites does not come back at once: who can only go round and round has no choice."""
        if (self.prospects.first_jump[rows][which] >= AT_ONCE).any():
            return True
        return bool((self.prospects.again(rows)[which].min(axis=1) >= AT_ONCE).any())

    def _chances(self, above: Array) -> Array:
        """E of misses from which the least was subtracted, made to sum to 1."""
        if np.isinf(self.beta):
            weight = (above <= 0.0).astype(np.float64)
        elif self.beta:
            weight = np.exp(-self.beta * above)
        else:
            weight = np.isfinite(above) * 1.0
        return np.asarray(weight / weight.sum(), dtype=np.float64)

    def _weighed(self, trail: Trail, now: Situation) -> Array:
        miss = np.zeros(len(trail.places))
        for pursuit in self.pursuits:
            if isinstance(pursuit, TrailPursuit):
                miss += pursuit.weigh(trail, now, self.bend_of(pursuit))
        return miss

    def _chained(self, paths: Sequence[int], intended: Sequence[int], now: Situation) -> float:
        """What a chain of paths misses besides where it leads; of its faults those that were intended already."""
        miss = sum(p.chain(paths, now) for p in self.pursuits if not isinstance(p, TrailPursuit))
        return miss if self._leaping is None else miss + float(self._leaping[list(intended)].sum())


def drawn(probabilities: Array, rng: np.random.Generator) -> int:
    """The number of one of some possibilities."""
    chosen = int(np.searchsorted(np.cumsum(probabilities), rng.random() * (1.0 - 1e-12)))
    return min(chosen, len(probabilities) - 1)
