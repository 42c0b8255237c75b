"""Entropies, jackknife and Chao's estimate in loops."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any


def entropy(words: Sequence[object]) -> float:
    """Miller-Madow bits of a list of words, no more than a uniform vocabulary of Chao's size has."""
    kinds = set(words)
    plain = 0.0
    for kind in kinds:
        p = sum(w == kind for w in words) / len(words)
        plain -= p * math.log(p) / math.log(2)
    corrected = plain + (len(kinds) - 1) / (2 * len(words) * math.log(2))
    return min(corrected, math.log(vocabulary(words)) / math.log(2))


def vocabulary(words: Sequence[object]) -> float:
    """Chao's estimate, bias-corrected."""
    often = [sum(w == kind for w in words) for kind in set(words)]
    once = sum(c == 1 for c in often)
    twice = sum(c == 2 for c in often)
    n = len(words)
    return len(often) + (n - 1) / n * once * (once - 1) / (2 * (twice + 1))


def conditional_entropy(pairs: Sequence[tuple[object, object]]) -> float:
    """Bits of the second given the first, each context corrected by itself."""
    total = 0.0
    for context in {a for a, _ in pairs}:
        followers = [b for a, b in pairs if a == context]
        total += len(followers) / len(pairs) * entropy(followers)
    return total


def jackknife(statistic: Callable[[Sequence[Any]], float], data: Sequence[Any]) -> float:
    """Standard error by leaving out every datum in turn."""
    n = len(data)
    values = [statistic([*data[:i], *data[i + 1 :]]) for i in range(n)]
    mean = sum(values) / n
    return math.sqrt((n - 1) / n * sum((v - mean) ** 2 for v in values))
