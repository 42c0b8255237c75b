"""Which paths to take, wherever they lead: of a kind, not played lately, joined smoothly, of a property of your own."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.errors import InputError
from kinesics.synthesis.goals.arguments import check_name, check_positive, check_weight, is_number
from kinesics.synthesis.goals.naming import paths_of
from kinesics.synthesis.goals.pursuit import Feature, Pursuit, Situation
from kinesics.synthesis.paths import ways
from kinesics.synthesis.paths.prospects import AT_ONCE, Prospects, shares_of, shares_of_chain

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Mask = NDArray[np.bool_]

FAVOURABLE: Final = "what to favour: a class, label, state, phrase or recording"
FORGET: Final = 30.0
"""Seconds after which a path that was played counts e times less as known."""
LEAST_SPREAD: Final = 0.25
"""Of what the transitions of composites cost, as a share of the mean."""


@dataclass(frozen=True)
class Favour:
    """Favour a class, a label or a state of the grammar, or a recording: "cyclic-antiphase", "ab_1", "A*", "walk".

    A path is the further off the more seconds it takes from its beginning to the nearest path of the kind wished for.
    """

    name: str
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the name and the weight."""
        check_name(self.name, FAVOURABLE)
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Longing(network, prospects, paths_of(network, self.name), self.weight)


class _Longing(Pursuit):
    """Seconds to a kind of path: the quickest way is known for every path, so that no composite needs to be asked."""

    def __init__(self, network: Network, prospects: Prospects, kind: Mask, weight: float) -> None:
        togo = ways.seconds_to(network, kind)
        togo = np.where(np.isfinite(togo), togo, ways.UNREACHABLE)
        self._paths = weight * (togo / (float(np.std(togo)) or 1.0)) ** 2
        self._miss = self._paths[prospects.sequence[:, 0]]

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        return float(self._paths[paths[0]])

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        return np.asarray(self._miss[rows], dtype=np.float64)


@dataclass(frozen=True)
class Novelty:
    """Do not repeat yourself: paths lately played cost more. Seconds until a path counts e times less as known: ``forget``."""

    weight: float = 1.0
    forget: float = FORGET

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.forget != np.inf and not (is_number(self.forget) and self.forget > 0.0):
            raise InputError(f"Expected `forget` in seconds, above 0 (infinite: never), got {self.forget!r}.")
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Fresh(network, prospects, self)


class _Fresh(Pursuit):
    """How often what a composite plays was played before, each time faded by the time since: the mean over its frames."""

    def __init__(self, network: Network, prospects: Prospects, goal: Novelty) -> None:
        self._duration = np.asarray(network.duration, dtype=np.float64)
        self._lasts: list[float] = self._duration.tolist()
        self._lookahead = prospects.lookahead
        self._all = prospects
        self._goal = goal
        self._seconds = float(self._duration.sum())
        self._weight = goal.weight
        self._known: Array | None = None
        self._since = 0.0

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        if not now.plays.any():
            return np.zeros(rows.stop - rows.start)
        known = self._now_known(now)
        shares, sequence = self._all.shares(rows), self._all.sequence[rows]
        if compiled.wanted():
            played = np.empty(len(sequence))
            compiled.native.shared_values(known, sequence, shares, played)
        else:
            played = (shares * np.append(known, 0.0)[sequence]).sum(axis=1)
        return np.asarray(self._weight * (played / self._usual(known)) ** 2, dtype=np.float64)

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        known = self._now_known(now)
        shares = shares_of_chain([self._lasts[path] for path in paths], self._lookahead)
        played = sum(float(known[path]) * share for path, share in zip(paths, shares, strict=True))
        return float(self._weight * (played / self._usual(known)) ** 2)

    def _usual(self, known: Array) -> float:
        """What is seen as well known: as if a frame in two were, and more where there is little to choose from."""
        return 0.5 + float(known @ self._duration) / self._seconds

    def note(self, now: Situation) -> None:
        if self._known is None:
            return
        # what has just been played counts from its beginning on
        self._known[now.path] += np.exp((now.last_played[now.path] - self._since) / self._goal.forget)

    def _now_known(self, now: Situation) -> Array:
        """How often each path was played, faded; of what was played before this was asked for the last time only is known."""
        if self._known is None:
            age = np.where(now.plays > 0, now.time - now.last_played, 0.0)
            faded = np.exp(-age / self._goal.forget)
            self._known, self._since = np.asarray(now.plays * faded, dtype=np.float64), now.time
        if now.time > self._since:
            self._known *= np.exp((self._since - now.time) / self._goal.forget)
            self._since = now.time
        return self._known


@dataclass(frozen=True)
class Onwards:
    """Do not come back at once: to play a moment again within a second looks like a machine, the sooner the more.

    Parameters
    ----------
    within : seconds from which on coming back costs nothing.
    """

    weight: float = 1.0
    within: float = AT_ONCE

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self.within, "within")
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Leaving(network, prospects, self)


class _Early(NamedTuple):
    """The first paths of some composites, shape (rows, those that begin early)."""

    paths: NDArray[np.int32]
    begins: Floats
    again: Floats
    shares: Floats
    later: Floats
    """What the others amount to, whatever was played before: shape (rows,)."""


class _Leaving(Pursuit):
    """By how much too soon a composite plays what was played lately, or twice within itself: the mean over its frames."""

    def __init__(self, network: Network, prospects: Prospects, goal: Onwards) -> None:
        self._lasts: list[float] = np.asarray(network.duration, dtype=np.float64).tolist()
        self._lookahead = prospects.lookahead
        self._all = prospects
        self._goal = goal
        self._known: dict[int, _Early] = {}

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        early = self._early(rows)
        if compiled.wanted():
            soon = early.later.astype(np.float64)
            compiled.native.too_soon(
                now.last_played,
                now.time,
                early.paths,
                early.begins,
                early.again,
                early.shares,
                self._goal.within,
                soon,
            )
        else:
            age = (now.time - now.last_played).astype(np.float32)
            since = np.minimum(early.begins + age[early.paths], early.again)
            soon = early.later + (early.shares * np.maximum(1.0 - since / self._goal.within, 0.0)).sum(axis=1)
        return np.asarray(self._goal.weight * soon**2, dtype=np.float64)

    def _early(self, rows: slice) -> _Early:
        """Of composites what begins so early that what was played before counts; computed when first asked for."""
        if rows.start not in self._known:
            begins, again, shares = self._all.begins(rows), self._all.again(rows), self._all.shares(rows)
            count = int((begins < self._goal.within).sum(axis=1).max())
            later = (shares * np.maximum(1.0 - again / self._goal.within, 0.0))[:, count:].sum(axis=1)
            self._known[rows.start] = _Early(
                np.ascontiguousarray(self._all.sequence[rows, :count]),
                np.ascontiguousarray(begins[:, :count]),
                np.ascontiguousarray(again[:, :count]),
                np.ascontiguousarray(shares[:, :count]),
                later,
            )
        return self._known[rows.start]

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        seconds = [self._lasts[path] for path in paths]
        began: dict[int, float] = {}
        time = soon = 0.0
        for path, lasts, share in zip(paths, seconds, shares_of_chain(seconds, self._lookahead), strict=True):
            since = time - began.get(path, float(now.last_played[path]) - now.time)
            soon += share * max(1.0 - since / self._goal.within, 0.0)
            began[path] = time
            time += lasts
        return float(self._goal.weight * soon**2)


@dataclass(frozen=True)
class Economy:
    """Change from recording to recording seldom and smoothly: the cost of transitions counts."""

    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check the weight."""
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return _Thrifty(network, prospects, self.weight)


class _Thrifty(Pursuit):
    """The cost of all transitions of a composite."""

    def __init__(self, network: Network, prospects: Prospects, weight: float) -> None:
        self._network = network
        # where all cost about alike, nothing is to be had by counting what they differ in
        spread = max(float(np.std(prospects.cost)), LEAST_SPREAD * float(np.mean(prospects.cost)))
        self._scale = weight / (spread**2 or 1.0)
        self._miss = self._scale * np.asarray(prospects.cost, dtype=np.float64) ** 2
        self._costs: dict[tuple[int, int], float] = {}

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        return np.asarray(self._miss[rows], dtype=np.float64)

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        total = sum(self._cost(before, after) for before, after in itertools.pairwise((now.path, *paths)))
        return self._scale * total**2

    def _cost(self, before: int, after: int) -> float:
        """Of one transition; remembered, for the same chains are asked for again and again."""
        if (before, after) not in self._costs:
            low, high = self._network.indptr[before], self._network.indptr[before + 1]
            cost = self._network.cost[low:high][self._network.indices[low:high] == after]
            self._costs[before, after] = float(cost.min())
        return self._costs[before, after]


class OwnFeature:
    """A `Feature` of the user's as a goal."""

    def __init__(self, feature: Feature) -> None:
        self.feature = feature
        check_weight(feature.weight)
        self.weight = float(feature.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        name = type(self.feature).__name__.lstrip("_")
        values = np.asarray(self.feature.values(network), dtype=np.float64)
        values = values[:, None] if values.ndim == 1 else values
        paths = len(network.first)
        if values.ndim != 2 or len(values) != paths or not np.isfinite(values).all():
            raise InputError(
                f"Expected `values` of {name} to give finite numbers of shape ({paths},) or ({paths}, dimensions), one a "
                f"path, got shape {values.shape}{'' if np.isfinite(values).all() else ' with NaN or infinity'}."
            )
        return _Valued(network, prospects, values, self.feature, name)


class _Valued(Pursuit):
    def __init__(self, network: Network, prospects: Prospects, values: Array, feature: Feature, name: str) -> None:
        shares = prospects.shares(slice(0, len(prospects.sequence)))
        self._duration = np.asarray(network.duration, dtype=np.float64)
        self._lookahead, self._of_paths = prospects.lookahead, values
        self._values = np.stack(
            [(shares * np.append(v, 0.0)[prospects.sequence]).sum(axis=1) for v in values.T], axis=1
        )
        spread = self._values.std(axis=0)
        self._spread = np.where(spread > 0.0, spread, 1.0)
        self._feature, self._name = feature, name

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        off = (self._values[rows] - self._wish(now)) / self._spread
        return np.asarray(self._feature.weight * np.einsum("rd,rd->r", off, off), dtype=np.float64)

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        shares = shares_of(self._duration[list(paths)], self._lookahead)
        off = (shares @ self._of_paths[list(paths)] - self._wish(now)) / self._spread
        return float(self._feature.weight * off @ off)

    def _wish(self, now: Situation) -> Array:
        wish = np.atleast_1d(np.asarray(self._feature.wish(now), dtype=np.float64))
        if wish.shape != self._values.shape[1:] or not np.isfinite(wish).all():
            raise InputError(
                f"Expected `wish` of {self._name} to be {self._values.shape[1]} finite number(s), got {wish.tolist()}."
            )
        return wish
