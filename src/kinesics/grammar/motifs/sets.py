"""Motifs as sets: a stretch, and all places where it comes back."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from kinesics.grammar.moments import Moments

RELATIONS: Final = ("same", "mirror", "reverse", "mirror_reverse")


@dataclass(frozen=True)
class Member:
    """One occurrence, moments [start, end)."""

    start: int
    end: int
    reversed: bool
    mirrored: bool
    residual: float
    """Mean distance to the first member over its range."""
    path: tuple[tuple[int, int], ...]
    """Pairs of moments (this member's, the first member's), from its start to its end."""


@dataclass(frozen=True)
class Motif:
    """A stretch that recurs under one relation: its first occurrence and all others."""

    id: int
    family: int
    """Motifs of one stretch under several relations share this number."""
    relation: str
    similarity: float
    """One less the mean residual of all members but the first: 1 is exact."""
    members: tuple[Member, ...]


def at_rate(motif: Motif, step: int, count: int) -> Motif:
    """A motif found in every so manieth moment, counted in all ``count`` moments."""
    return motif if step == 1 else _counted(motif, lambda k: min(k * step, count))


def in_frames(moments: Moments, motifs: Sequence[Motif]) -> Iterator[Motif]:
    """Motifs with frames of the recording in the place of moments."""
    for motif in motifs:
        yield _counted(motif, moments.frame_of)


def _counted(motif: Motif, at: Callable[[int], int]) -> Motif:
    """The motif, its moments counted otherwise."""
    members = tuple(
        replace(m, start=at(m.start), end=at(m.end), path=tuple((at(x), at(y)) for x, y in m.path))
        for m in motif.members
    )
    return replace(motif, members=members)
