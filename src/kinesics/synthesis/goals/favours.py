"""Which paths to take, wherever they lead: of a kind, not played lately, joined smoothly, of a property of your own."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.synthesis import ways
from kinesics.synthesis.goals.arguments import check_name, check_weight, is_number
from kinesics.synthesis.goals.naming import paths_of
from kinesics.synthesis.goals.pursuit import Feature, Pursuit, Situation
from kinesics.synthesis.prospects import Prospects

if TYPE_CHECKING:
    from kinesics.synthesis.network import Network

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Mask = NDArray[np.bool_]

SOON: Final = 4.0
"""A property of a path counts e times less for every such part of the lookahead that the path comes later."""
FAVOURABLE: Final = "what to favour: a class, label, state, phrase or recording"
FORGET: Final = 30.0
"""Seconds after which a path that was played counts e times less as known."""


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
    """Seconds of a composite that were played before, faded by the time since."""

    def __init__(self, network: Network, prospects: Prospects, goal: Novelty) -> None:
        self._duration = np.asarray(network.duration, dtype=np.float64)
        self._lookahead = prospects.lookahead
        self._seconds = _soon(network, prospects)
        self._sequence = prospects.sequence
        self._goal = goal
        # no spread to take it from before anything was played: as if a path in two were known
        self._scale = goal.weight / (float(np.mean(self._seconds.sum(axis=1))) / 2.0) ** 2

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        if not now.plays.any():
            return np.zeros(rows.stop - rows.start)
        known = now.plays * np.exp((now.last_played - now.time) / self._goal.forget)
        seconds = (self._seconds[rows] * np.append(known, 0.0)[self._sequence[rows]]).sum(axis=1)
        return np.asarray(self._scale * seconds**2, dtype=np.float64)

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        played = list(paths)
        known = now.plays[played] * np.exp((now.last_played[played] - now.time) / self._goal.forget)
        return float(self._scale * (known @ _fading(self._duration[played], self._lookahead)) ** 2)


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
        self._scale = weight / (float(np.var(prospects.cost)) or 1.0)
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
        seconds = _soon(network, prospects)
        self._duration = np.asarray(network.duration, dtype=np.float64)
        self._lookahead, self._of_paths = prospects.lookahead, values
        total = seconds.sum(axis=1)
        self._values = np.stack(
            [(seconds * np.append(v, 0.0)[prospects.sequence]).sum(axis=1) / total for v in values.T], axis=1
        )
        spread = self._values.std(axis=0)
        self._spread = np.where(spread > 0.0, spread, 1.0)
        self._feature, self._name = feature, name

    def miss(self, rows: slice, now: Situation, bend: float) -> Array:
        off = (self._values[rows] - self._wish(now)) / self._spread
        return np.asarray(self._feature.weight * np.einsum("rd,rd->r", off, off), dtype=np.float64)

    def chain(self, paths: Sequence[int], now: Situation) -> float:
        seconds = _fading(self._duration[list(paths)], self._lookahead)
        off = (seconds @ self._of_paths[list(paths)] / seconds.sum() - self._wish(now)) / self._spread
        return float(self._feature.weight * off @ off)

    def _wish(self, now: Situation) -> Array:
        wish = np.atleast_1d(np.asarray(self._feature.wish(now), dtype=np.float64))
        if wish.shape != self._values.shape[1:] or not np.isfinite(wish).all():
            raise InputError(
                f"Expected `wish` of {self._name} to be {self._values.shape[1]} finite number(s), got {wish.tolist()}."
            )
        return wish


def _soon(network: Network, prospects: Prospects) -> Floats:
    """Seconds of each path of each composite, those that come late counting less: shape (rows, longest).

    If they counted alike, what is wished for could be put off from decision to decision.
    """
    seconds = np.append(np.asarray(network.duration, dtype=np.float64), 0.0)[prospects.sequence]
    return np.asarray(_fading(seconds, prospects.lookahead), dtype=np.float32)


def _fading(seconds: Array, lookahead: float) -> Array:
    """Durations of paths one after the other, along the last axis, less the later they come."""
    begins = np.cumsum(seconds, axis=-1) - seconds
    return seconds * np.exp(-SOON * begins / lookahead) if lookahead else seconds
