"""The symmetry class of a traversal, read off the word of its steps.

Independent of any measurement: mirror, reversal and period are operations on letters. (It is exact where the paths are
pairwise different, which a graph promises.)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from kinesics.vocabulary import MovementClass


class Token(NamedTuple):
    """A letter: a path taken, or a state held."""

    label: str
    reversed: bool
    image: str | None
    """Label of its mirror image; None where there is none."""
    both_ways: bool
    """Played backwards it is itself: a hold, a palindromic loop."""
    seconds: float
    one_way: bool = False
    """Played backwards it is nothing of this word: a strike."""

    @property
    def key(self) -> tuple[str, bool, float, bool]:
        """What makes two letters the same."""
        return self.label, self.reversed and not self.both_ways, self.seconds, self.one_way

    def mirror(self) -> Token | None:
        """The letter in the mirror."""
        return None if self.image is None else self._replace(label=self.image, image=self.label)

    def reverse(self) -> Token | None:
        """The letter played backwards."""
        return None if self.one_way else self._replace(reversed=not self.reversed)


class WordClass(NamedTuple):
    """Class of a word, length of its shortest repeated part in letters, and how often that fits."""

    class_: MovementClass
    span: int
    repeats: int


def _keys(word: Sequence[Token]) -> list[tuple[str, bool, float, bool]]:
    return [t.key for t in word]


def _all(letters: Sequence[Token | None]) -> list[Token] | None:
    known = [t for t in letters if t is not None]
    return known if len(known) == len(letters) else None


def class_of(word: Sequence[Token]) -> WordClass:
    """The class of a word of at least one letter: cyclic where it repeats a part of itself at least twice.

    The last repetition may be cut short.
    """
    keys = _keys(word)
    n = len(keys)
    span = next(p for p in range(1, n + 1) if all(keys[i] == keys[i % p] for i in range(n)))
    repeats = n // span
    if repeats < 2:
        span, repeats = n, 1
    part = list(word[:span])
    mirrored = _all([t.mirror() for t in part])
    backwards = _all([t.reverse() for t in reversed(part)])
    both = None if mirrored is None else _all([t.reverse() for t in reversed(mirrored)])
    same = _keys(part)
    c = MovementClass
    if repeats < 2:
        m = mirrored is not None and _keys(mirrored) == same
        t = backwards is not None and _keys(backwards) == same
        mt = both is not None and _keys(both) == same
        single = {
            (False, False): c.ASYMMETRIC,
            (True, False): c.SYMMETRIC,
            (False, True): c.PALINDROMIC,
            (True, True): c.SYMMETRIC_PALINDROMIC,
        }[m, t]
        if mt and not (m or t):
            single = c.ANTIPALINDROMIC
        return WordClass(single, span, repeats)

    def rotation(candidate: list[Token] | None) -> int | None:
        if candidate is None:
            return None
        doubled = _keys(candidate) * 2
        return next((s for s in range(span) if doubled[s : s + span] == same), None)

    shift = rotation(mirrored)
    at_once = shift == 0
    glide = shift is not None and shift != 0
    t, mt = rotation(backwards) is not None, rotation(both) is not None
    if at_once:
        cyclic = c.CYCLIC_SYMMETRIC_PALINDROMIC if t else c.CYCLIC_SYMMETRIC
    elif glide:
        cyclic = c.CYCLIC_ANTIPHASE_PALINDROMIC if t else c.CYCLIC_ANTIPHASE
    elif t:
        cyclic = c.CYCLIC_PALINDROMIC
    elif mt:
        cyclic = c.CYCLIC_ANTIPALINDROMIC
    else:
        cyclic = c.CYCLIC_ASYMMETRIC
    return WordClass(cyclic, span, repeats)
