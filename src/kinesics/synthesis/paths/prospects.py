"""What may come after each path: the paths that may follow it, or whole composites of them over the next seconds.

The Markov controller of [Schultz2012] §4.4.1 weighs each path that may follow by what that path alone does. Walking towards
something needs more: a step to the left is good because of the two steps that can follow it. So, as an extension beyond the
dissertation, every path is given beforehand a bundle of *composites*, chains of paths over the next seconds that lie spread
over all that can be reached (`synthesis.paths.bundles`). Looking ahead 0 seconds the composites are the single paths, and the
controller is the dissertation's. What is asked of them at decisions is kept here.

References
----------
[Schultz2012] §4.4.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.synthesis.paths.bundles import bundled
from kinesics.synthesis.paths.togo import ToGo, to_go
from kinesics.synthesis.paths.trails import Trail

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Indices = NDArray[np.intp]

LOOKAHEAD: Final = 2.0
"""Seconds that composites last at least, if nothing else is said."""
AT_ONCE: Final = 1.0
"""Seconds within which coming back to a moment is seen: a cycle of walking lasts as long, a bow or a wave longer."""
SOON: Final = 4.0
"""What a frame plays counts e times less for every such part of the lookahead that it comes later."""


@dataclass(frozen=True, eq=False)
class Prospects:
    """Composites that may follow each path. Those that begin with successor ``e`` of the network's list of successors are
    rows ``start[e]:start[e + 1]``, so that what may follow path ``i`` lies together.
    """

    lookahead: float
    """Seconds; 0 for single paths."""
    start: Indices
    """Shape (successors + 1,)."""
    sequence: NDArray[np.int32]
    """Paths of each composite, −1 after the last: shape (rows, longest)."""
    trail: Trail
    """Every `kinesics.synthesis.paths.bundles.SAMPLE` seconds; at the end, if nothing is looked ahead to."""
    cost: Floats
    """Of all its transitions together, that into its first path included: shape (rows,)."""
    first_jump: Floats
    """Seconds until it first leaves a recording, `kinesics.synthesis.paths.bundles.NEVER` if it does not: shape (rows,)."""
    rows: Indices
    """Those that may follow path ``i`` are ``rows[i]:rows[i + 1]``: shape (paths + 1,)."""
    duration: Array
    """Seconds of each path, shape (paths,)."""
    _to_go: dict[tuple[float, float], ToGo] = field(default_factory=dict, repr=False)
    _again: dict[tuple[int, int], Floats] = field(default_factory=dict, repr=False)
    _shares: dict[tuple[int, int], Floats] = field(default_factory=dict, repr=False)

    @cached_property
    def reach(self) -> float:
        """Metres in a straight line: the most that can be made of one composite, from all but the fastest tenth of the paths."""
        far = np.abs(self.trail.places[:, -1])
        return float(np.quantile(np.maximum.reduceat(far, self.start[:-1]), 0.9))

    @cached_property
    def farthest(self) -> float:
        """Metres: no composite leads farther while it is looked at."""
        return float(np.abs(self.trail.places).max())

    @property
    def pace(self) -> float:
        """Metres a second in a straight line, as most of the paths allow."""
        return self.reach / self.lookahead

    @property
    def fastest(self) -> float:
        """Metres a second in a straight line, which nothing in the recordings exceeds for long."""
        return self.farthest / self.lookahead

    @cached_property
    def widest(self) -> float:
        """Metres by which a composite is moved at most, if it is bent by 1 radian a metre."""
        return float(np.abs(self.trail.swerve).max())

    @cached_property
    def spread(self) -> float:
        """Metres: standard deviation of where composites end."""
        return float(np.std(self.trail.places[:, -1])) or 1.0

    @cached_property
    def turning(self) -> float:
        """Metres walked while turning by a radian, as quickly as all but the quickest tenth of the paths allow."""
        turned = float(np.quantile(np.maximum.reduceat(np.abs(self.trail.headings[:, -1]), self.start[:-1]), 0.9))
        return self.reach / max(turned, 0.1)

    def to_go(self, radius: float, bend: float) -> ToGo:
        """Seconds to a target of so many metres, by ways bent by so many radians a metre. Computed when first asked for."""
        asked = round(float(radius), 3), round(float(bend), 6)
        if asked not in self._to_go:
            self._to_go[asked] = to_go(self.trail, self.rows, self.reach, *asked)
        return self._to_go[asked]

    def begins(self, rows: slice) -> Floats:
        """Seconds until each path of some composites begins: shape (rows, longest)."""
        seconds = np.append(self.duration, 0.0)[self.sequence[rows]]
        return np.asarray(np.cumsum(seconds, axis=1) - seconds, dtype=np.float32)

    def again(self, rows: slice) -> Floats:
        """Seconds since each path of some composites began before within the composite, infinite if it did not: shape (rows,
        longest). Computed when first asked for.
        """
        asked = rows.start, rows.stop
        if asked not in self._again:
            order = np.argsort(self.sequence[rows], axis=1, kind="stable")
            paths = np.take_along_axis(self.sequence[rows], order, axis=1)
            begins = np.take_along_axis(self.begins(rows), order, axis=1)
            since = np.full(begins.shape, np.inf, dtype=np.float32)
            same = (paths[:, 1:] == paths[:, :-1]) & (paths[:, 1:] >= 0)
            since[:, 1:][same] = np.diff(begins, axis=1)[same]
            out = np.empty_like(since)
            np.put_along_axis(out, order, since, axis=1)
            self._again[asked] = out
        return self._again[asked]

    def shares(self, rows: slice) -> Floats:
        """How much each path of some composites counts, together 1, what comes late counting less: shape (rows, longest).

        If all counted alike, what is wished for could be put off from decision to decision. Computed when first asked for.
        """
        asked = rows.start, rows.stop
        if asked not in self._shares:
            seconds = np.append(self.duration, 0.0)[self.sequence[rows]]
            self._shares[asked] = shares_of(seconds, self.lookahead).astype(np.float32)
        return self._shares[asked]

    def fill(self) -> None:
        """Compute what `again` and `shares` would when first asked for, of what may follow each path."""
        for first, past in itertools.pairwise(self.rows.tolist()):
            self.again(slice(first, past)), self.shares(slice(first, past))

    def along(self, rows: slice | Indices) -> Trail:
        """The trails of some rows."""
        times, *others = self.trail
        return Trail._make((times if len(times) == 1 else times[rows], *(values[rows] for values in others)))


def shares_of(seconds: Array, lookahead: float) -> Array:
    """How much each of some paths one after the other counts, together 1; of their durations, along the last axis.

    Frames count the less the later they come, not paths: else one long path would count for more than many short ones.
    """
    if lookahead:
        ends = np.cumsum(seconds, axis=-1)
        fading = SOON / lookahead
        seconds = np.exp(-fading * (ends - seconds)) - np.exp(-fading * ends)
    return np.asarray(seconds / seconds.sum(axis=-1, keepdims=True), dtype=np.float64)


def shares_of_chain(seconds: Sequence[float], lookahead: float) -> list[float]:
    """The same of one chain, in plain numbers."""
    shares, ended = list(seconds), 0.0
    if lookahead:
        fading = SOON / lookahead
        for k, lasts in enumerate(seconds):
            begun, ended = ended, ended + lasts
            shares[k] = math.exp(-fading * begun) - math.exp(-fading * ended)
    total = sum(shares)
    return [share / total for share in shares]


def prospects(network: Network, lookahead: float = LOOKAHEAD, *, hold: float = 0.2, seed: int = 0) -> Prospects:
    """Bundle what may follow each path of a network.

    Parameters
    ----------
    lookahead : seconds that each composite lasts at least; 0 for single paths, as in [Schultz2012] §4.4.1.
    hold : seconds that a recording is kept before the next jump, where there is a choice, so that one blend ends before
        another begins.
    seed : of the choice among composites that lead to the same place. The same network and seed give the same bundle.

    Raises
    ------
    InputError
        If a number of seconds is negative or not finite, or the network has no paths.
    """
    for name, value in (("lookahead", lookahead), ("hold", hold)):
        if not (np.isfinite(value) and value >= 0.0):
            raise InputError(f"Expected `{name}` in seconds, 0 or more, got {value}.")
    if len(network.first) == 0 or len(network.indices) == 0:
        raise InputError(
            "The network has no path that another may follow, so nothing can be performed. Give more recordings, or a "
            "larger `threshold` when it is made."
        )
    found = bundled(network, lookahead, hold, np.random.default_rng(seed))
    return Prospects(
        lookahead=float(lookahead),
        start=found.start,
        sequence=found.sequence,
        trail=found.trail,
        cost=found.cost,
        first_jump=found.first_jump,
        rows=found.start[np.asarray(network.indptr)],
        duration=np.asarray(network.duration, dtype=np.float64),
    )
