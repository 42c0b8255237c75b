"""Phrases, and the pieces they are made of."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Phrase:
    """A stretch of one kind of movement, moments [start, end)."""

    start: int
    end: int
    kind: int
    """The same number for phrases of the same kind, counted from 0 in order of appearance."""
    still: bool = False
    """A rest: the body stays where it is."""
    recurs: bool = False
    """The movement recurs within the phrase; False for what is made once."""
    mirrored: bool = False
    """It is like the first phrase of its kind as that is seen in a mirror, and not as it is."""


@dataclass(frozen=True)
class Piece:
    """A stretch on its way to be a phrase, coarse moments [start, end)."""

    start: int
    end: int
    still: bool = False
    recurs: bool = False
