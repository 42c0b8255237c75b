"""How much a traversal of a motion graph tells: the graph as a Markov source of paths ([Schultz2012] §1.1; Shannon 1948).

A *word* is one traversal of a path, forwards or backwards; stays are pauses between words: they take time and say nothing.

- order 0: the entropy of the words, whatever went before: H(w)
- order 1: the entropy of a word when the one before it is known: H(w | v), Shannon's source of digrams. 0 for a movement that does
  the same over and over
- bits a second: order 1 times words a second of recording, pauses included

Short recordings make the plain (maximum likelihood) entropy too small; the correction of Miller (1955) is added, (K − 1)/(2N ln 2)
for K different words in N, in each context for order 1, but never more than makes all words of the vocabulary (as estimated
below) equally likely. What is left of that bias grows with the number of contexts that were seen once or twice: compare
recordings of a few hundred words, or of like length. Standard errors are by jackknife (Efron & Stein 1981), one word left out at a
time, and take words as drawn independently given the one before. Estimates of two recordings are compared by subtracting
them: the difference carries its standard error. The size of the vocabulary is Chao's (1984, 1987) estimate from how many paths
were taken once and twice: at least as many as were seen.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError

if TYPE_CHECKING:
    from kinesics.grammar.graph import MotionGraph

Array = NDArray[np.float64]

_NATS: Final = math.log(2.0)


@dataclass(frozen=True)
class Estimate:
    """A number and its standard error; two of them subtracted are the difference and its standard error."""

    value: float
    standard_error: float

    def __sub__(self, other: Estimate) -> Estimate:
        return Estimate(self.value - other.value, math.hypot(self.standard_error, other.standard_error))


@dataclass(frozen=True)
class Information:
    """What a graph's traversals tell; None where there were too few of them to tell."""

    order0_bits: Estimate | None = None
    """Entropy of a path, bits."""
    order1_bits: Estimate | None = None
    """Entropy of a path when the one before it is known, bits."""
    bits_per_s: Estimate | None = None
    """Order 1, a second of recording."""
    vocabulary: Estimate | None = None
    """Different paths there are, seen or not (Chao); mirror images count as two, the two directions as one."""
    vocabulary_seen: int = 0
    """Different paths that were taken."""
    symmetric_share: Estimate | None = None
    """Share of the time of traversals spent on symmetric paths."""
    reversible_share: Estimate | None = None
    """… on paths that are taken in both directions."""
    mirrored_share: Estimate | None = None
    """… on paths whose mirror image is performed too."""
    words: int = 0
    """Traversals."""
    seconds: float = 0.0
    """Duration of the recordings, stays included."""

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            key: {"value": v.value, "standard_error": v.standard_error} if isinstance(v, Estimate) else v
            for key, v in vars(self).items()
        }


class _Word(NamedTuple):
    """One traversal."""

    path: int
    reversed: bool
    path_seconds: float
    seconds: float
    """Until the next word begins, or the recording ends."""
    before: tuple[int, bool] | None

    @property
    def symbol(self) -> tuple[int, bool]:
        return self.path, self.reversed


def measure(graph: MotionGraph) -> Information:
    """The information of a graph's traversals, all sources together: the last word of one leads to no other."""
    words = [w for source in range(len(graph.sources)) for w in _words(graph, source)]
    seconds = float(sum(s.frames / s.fps for s in graph.sources))
    if not words:
        return Information(seconds=seconds)
    performed = {w.symbol for w in words}
    taken = {w.path for w in words}

    def mirrored(path_id: int) -> bool:
        path = graph.path(path_id)
        if path.antipalindromic:
            return {(path_id, False), (path_id, True)} <= performed
        return path.mirror_of in taken

    times = np.array([w.path_seconds for w in words])
    paths = [graph.path(w.path) for w in words]
    counts = Counter(w.path for w in words)
    return Information(
        order0_bits=entropy(Counter(w.symbol for w in words).values()),
        order1_bits=conditional_entropy((w.before, w.symbol) for w in words if w.before is not None),
        bits_per_s=_rate(words, seconds),
        vocabulary=vocabulary_size(counts.values()),
        vocabulary_seen=len(counts),
        symmetric_share=_share(times, [p.symmetric for p in paths]),
        reversible_share=_share(times, [p.reversible for p in paths]),
        mirrored_share=_share(times, [mirrored(p.id) for p in paths]),
        words=len(words),
        seconds=seconds,
    )


def _words(graph: MotionGraph, source: int) -> Iterable[_Word]:
    steps = [s for s in graph.timeline(source) if s.path is not None]
    fps, frames = graph.sources[source].fps, graph.sources[source].frames
    before = None
    for k, step in enumerate(steps):
        assert step.path is not None
        # pauses belong to the word before them, the first pause to the first word
        start = 0 if k == 0 else step.start
        end = frames if k == len(steps) - 1 else steps[k + 1].start
        yield _Word(step.path, step.reversed, (step.end - step.start) / fps, (end - start) / fps, before)
        before = (step.path, step.reversed)


def entropy(counts: Iterable[int]) -> Estimate | None:
    """Entropy in bits of what was seen so many times each, with Miller's correction and the jackknife's standard error.

    None where less than two things were seen.

    Raises
    ------
    InputError
        If a count is negative.
    """
    seen = _counts(counts)
    total = sum(seen)
    if total < 2:
        return None
    left_out = [(_corrected([*_but(seen, k), c - 1]), c) for k, c in enumerate(seen)]
    return Estimate(_corrected(seen), _jackknife(left_out))


def conditional_entropy(pairs: Iterable[tuple[object, object]]) -> Estimate | None:
    """Entropy in bits of the second of a pair when the first is known; corrected in each context; None for less than two pairs."""
    table = _contexts(pairs)
    total = sum(table.total.values())
    if total < 2:
        return None
    left_out = [(_without(table, pair), count) for pair, count in table.pairs.items()]
    return Estimate(table.bits / total, _jackknife([(bits / (total - 1), count) for bits, count in left_out]))


def vocabulary_size(counts: Iterable[int]) -> Estimate | None:
    """How many different things there are, from how often each one seen was seen (Chao 1984; standard error Chao 1987).

    The bias-corrected form S + (n − 1)/n · f₁(f₁ − 1)/(2(f₂ + 1)), with f₁ and f₂ the things seen once and twice.
    """
    seen = _counts(counts)
    n, kinds = sum(seen), len(seen)
    if n < 1:
        return None
    once, twice = seen.count(1), seen.count(2)
    share = (n - 1) / n
    unseen = _chao(seen) - kinds
    if once == 0:
        gone = math.exp(-n / kinds)
        variance = kinds * gone * (1.0 - gone)
    else:
        variance = unseen + share**2 * once * (2 * once - 1) ** 2 / (4 * (twice + 1) ** 2)
        if twice:
            variance += share**2 * once**2 * twice * (once - 1) ** 2 / (4 * (twice + 1) ** 4)
        else:
            variance -= share**2 * once**4 / (4 * (kinds + unseen))
    return Estimate(kinds + unseen, math.sqrt(max(variance, 0.0)))


class _Table(NamedTuple):
    """Pairs counted, and the corrected bits of all pairs together: Σ over contexts of n·H."""

    pairs: dict[tuple[object, object], int]
    total: dict[object, int]
    rows: dict[object, tuple[int, ...]]
    bits: float


def _contexts(pairs: Iterable[tuple[object, object]]) -> _Table:
    counted = Counter(pairs)
    rows: dict[object, list[int]] = {}
    for (context, _), count in counted.items():
        rows.setdefault(context, []).append(count)
    bits = sum(sum(row) * _corrected(row) for row in rows.values())
    frozen = {context: tuple(row) for context, row in rows.items()}
    return _Table(dict(counted), {c: sum(row) for c, row in frozen.items()}, frozen, bits)


def _without(table: _Table, pair: tuple[object, object]) -> float:
    """Bits of all pairs together when one such pair was not seen."""
    row, count = table.rows[pair[0]], table.pairs[pair]
    shorter = [*_but(row, row.index(count)), count - 1]
    return table.bits - sum(row) * _corrected(row) + sum(shorter) * _corrected(shorter)


def _rate(words: Sequence[_Word], seconds: float) -> Estimate | None:
    pairs = [(w.before, w.symbol) for w in words if w.before is not None]
    table = _contexts(pairs)
    total = len(pairs)
    if total < 2 or seconds <= 0.0:
        return None
    bits = {pair: _without(table, pair) / (total - 1) for pair in table.pairs}
    n = len(words)
    left_out = []
    for w in words:
        rest = seconds - w.seconds
        if rest > 0.0:
            order1 = table.bits / total if w.before is None else bits[w.before, w.symbol]
            left_out.append((order1 * (n - 1) / rest, 1))
    return Estimate(table.bits / total * n / seconds, _jackknife(left_out))


def _share(times: Array, chosen: ArrayLike) -> Estimate | None:
    """Share of the time, a ratio of sums: jackknife over traversals."""
    part = np.where(np.asarray(chosen, dtype=bool), times, 0.0)
    total = float(times.sum())
    if len(times) < 2:
        return None
    left_out = (part.sum() - part) / (total - times)
    return Estimate(float(part.sum() / total), _jackknife([(float(v), 1) for v in left_out]))


def _corrected(counts: Sequence[int]) -> float:
    """Entropy in bits plus Miller's correction, at most that of a uniform vocabulary; nothing seen says nothing."""
    seen = [c for c in counts if c > 0]
    if len(seen) < 2:
        return 0.0
    n = sum(seen)
    p = np.array(seen, dtype=np.float64) / n
    plain = float(-(p * np.log2(p)).sum())
    return min(plain + (len(seen) - 1) / (2.0 * n * _NATS), math.log2(_chao(seen)))


def _chao(seen: Sequence[int]) -> float:
    n, once, twice = sum(seen), seen.count(1), seen.count(2)
    return len(seen) + (n - 1) / n * once * (once - 1) / (2 * (twice + 1))


def _jackknife(left_out: Sequence[tuple[float, int]]) -> float:
    """Standard error from the estimates with one observation left out, each with how many observations give it."""
    values = np.array([v for v, _ in left_out])
    weights = np.array([w for _, w in left_out], dtype=np.float64)
    n = weights.sum()
    if n < 2:
        return 0.0
    mean = (weights * values).sum() / n
    return float(math.sqrt((n - 1.0) / n * (weights * (values - mean) ** 2).sum()))


def _but(values: Sequence[int], k: int) -> list[int]:
    return [*values[:k], *values[k + 1 :]]


def _counts(counts: Iterable[int]) -> list[int]:
    seen = list(counts)
    if any(c < 0 for c in seen):
        raise InputError(f"Expected counts of at least 0, got {min(seen)}.")
    return [c for c in seen if c > 0]
