"""From which end a recording is read: what is read must not depend on the direction in which it is played.

Classes, cycles, phrases and states are found by going through the recording from one end to the other, and whoever starts at the
other end decides close calls another way. So the recording itself says from which end it is read: from the one with less
movement in its half. Played backwards it is read from the same end, and what is found is the same, turned round.
"""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np

from kinesics.grammar.classes import Verdict
from kinesics.grammar.moments import Moments
from kinesics.grammar.reading import Reading, Traversal

_EVEN: Final = 1e-9
"""Relative difference of the halves up to which rounding, not the movement, would decide."""


def from_the_end(moments: Moments) -> bool:
    """Whether the recording is to be read from its end: there is less movement there than at its beginning."""
    way = moments.speed[1:]
    if len(way) == 0:
        return False
    lever = np.linspace(-1.0, 1.0, len(way))
    return bool(way @ lever < -_EVEN * way.sum())


def reversed_moments(moments: Moments) -> Moments:
    """The moments played backwards: moment m becomes moment count − 1 − m."""
    dense = moments.dense
    return dataclasses.replace(
        moments,
        # entry i is the step towards moment i, entry 0 repeats the first step
        speed=np.concatenate([moments.speed[-1:], moments.speed[:0:-1]]),
        symmetry=moments.symmetry[::-1].copy(),
        poses=None if moments.poses is None else moments.poses[::-1],
        dense=None if dense is None else (dense[0][::-1, ::-1], dense[1][::-1, ::-1]),
    )


def reversed_verdict(verdict: Verdict, moments: Moments) -> Verdict:
    """The verdict on the movement played backwards, for the movement; ``moments`` are those of either."""

    def turned(frame: int) -> int:
        return moments.frame_of(moments.count - 1 - moments.moment_of(frame))

    cycles = tuple(
        dataclasses.replace(
            c,
            start=turned(c.end),
            end=turned(c.start),
            phase=c.phase if c.phase is None or c.phase == 0.5 else -c.phase,
        )
        for c in reversed(verdict.cycles)
    )
    return dataclasses.replace(verdict, cycles=cycles)


def reversed_reading(read: Reading, count: int) -> Reading:
    """What was read of one recording played backwards, for the recording: one-way paths turn round."""
    last, visits = count - 1, len(read.visits)

    def turned(t: Traversal) -> Traversal:
        return dataclasses.replace(t, start=last - t.end, end=last - t.start)

    return dataclasses.replace(
        read,
        states=tuple(dataclasses.replace(s, moment=last - s.moment) for s in read.states),
        paths=tuple(dataclasses.replace(p, from_=p.to, to=p.from_) for p in read.paths),
        visits=tuple(
            v._replace(start=count - v.end, end=count - v.start, at=last - v.at) for v in reversed(read.visits)
        ),
        traversals=tuple(turned(t) for t in reversed(read.traversals)),
        leads={visits - 1 - k: turned(t) for k, t in read.tails.items()},
        tails={visits - 1 - k: turned(t) for k, t in read.leads.items()},
    )
