"""From which end a recording is read: what is read must not depend on the direction in which it is played.

Classes, cycles, phrases and states are found by going through the recording from one end to the other, and whoever starts at the
other end decides close calls another way. So the recording itself says from which end it is read: from the one with less
movement in its half (`Moments.from_end`). Played backwards it is read from the same end, and what is found is the same, turned
round.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from kinesics.grammar.classes import Verdict
from kinesics.grammar.moments import Moments
from kinesics.grammar.reading import Reading, Traversal


def reversed_moments(moments: Moments) -> Moments:
    """The moments played backwards: moment m becomes moment count − 1 − m."""
    dense = moments.dense
    return dataclasses.replace(
        moments,
        from_end=not moments.from_end,
        lead=moments.source_frames - 1 - moments.exact_frame_of(moments.count - 1),
        # entry i is the step towards moment i, entry 0 repeats the first step
        speed=np.concatenate([moments.speed[-1:], moments.speed[:0:-1]]),
        symmetry=moments.symmetry[::-1].copy(),
        poses=None if moments.poses is None else moments.poses[::-1],
        dense=None if dense is None else (dense[0][::-1, ::-1], dense[1][::-1, ::-1]),
    )


def reversed_verdict(verdict: Verdict, frames: int) -> Verdict:
    """The verdict on a recording of so many frames played backwards, for the recording."""

    def turned(frame: int) -> int:
        return max(frames - 1 - frame, 0)

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
