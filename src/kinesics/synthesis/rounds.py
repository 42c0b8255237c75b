"""What a performance comes back to: loops that are played round and round, and what comes far more often than the rest."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.control.courses import Course
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.paths.prospects import AT_ONCE
from kinesics.synthesis.repertoire import Repertoire

Indices = NDArray[np.intp]

ROUNDS: Final = 4
"""Times on end that a stretch shorter than a second is played before it is called a loop."""
FAR_ABOVE: Final = 3.0
"""Times the mean from which a stretch is played far more often than the rest."""
OFTEN: Final = 6
"""Plays below which nothing is played often."""


class Loop(NamedTuple):
    """A stretch of a recording that is played again and again, never more than a second apart."""

    recording: int
    first: int
    """Frames [first, end) of the recording, in its own count."""
    end: int
    period: float
    """Seconds of one round, in the median."""
    seconds: float
    """All rounds together, wherever in the performance."""

    @property
    def rounds(self) -> int:
        """How many, to the nearest."""
        return round(self.seconds / self.period)


class Often(NamedTuple):
    """A stretch of a recording that is played far more often than the rest."""

    recording: int
    first: int
    """Frames [first, end) of the recording, in its own count."""
    end: int
    times: int


def longest_loop(course: Course, network: Network) -> Loop | None:
    """The loop in which most of the time is spent; None where nothing is played round and round."""
    stock = network.repertoire
    since = _since(course.moments) / course.fps
    again = since <= AT_ONCE
    edges = np.flatnonzero(np.diff(again, prepend=False, append=False)).reshape(-1, 2)
    # one that is left and come back to is one loop: known by the frames that it plays
    found: dict[tuple[int, int, int], list[tuple[float, float]]] = {}
    for start, end in edges.tolist():
        period = float(np.median(since[start:end]))
        lasted = (end - start) / course.fps + period
        if lasted >= ROUNDS * period - 0.5 / course.fps:
            where = _stretch(stock, course.moments[start:end])
            found.setdefault(where, []).append((period, lasted))
    if not found:
        return None
    (recording, first, last), rounds = max(found.items(), key=lambda item: sum(lasted for _, lasted in item[1]))
    return Loop(
        recording,
        *_own_frames(stock, recording, first, last),
        float(np.median([period for period, _ in rounds])),
        sum(lasted for _, lasted in rounds),
    )


def played_most(course: Course, network: Network) -> Often | None:
    """What is played far more often than the rest, mirror images counted apart; None where nothing is."""
    plays = np.bincount(course.paths, minlength=len(network))
    mean = len(course.moments) / course.fps / network.seconds
    path = int(np.argmax(plays))
    if plays[path] < max(OFTEN, FAR_ABOVE * mean):
        return None
    stock = network.repertoire
    strand, recording = network.strand, network.recording
    alike = (plays >= 0.75 * plays[path]) & (strand == strand[path]) & (recording == recording[path])
    first = last = path
    # paths are in the order of the frames that they play
    while last + 1 < len(plays) and alike[last + 1] and network.first[last + 1] == network.onward[last]:
        last += 1
    while first > 0 and alike[first - 1] and network.onward[first - 1] == network.first[first]:
        first -= 1
    frames = stock.frame_of(np.array([network.first[first], network.last[last]]))
    own = _own_frames(stock, int(recording[path]), int(frames.min()), int(frames.max()))
    return Often(int(recording[path]), *own, int(plays[path]))


def _since(moments: Indices) -> NDArray[np.float64]:
    """Frames since each moment was shown before, infinite where it was not."""
    order = np.argsort(moments, kind="stable")
    out = np.full(len(moments), np.inf)
    same = np.diff(moments[order]) == 0
    out[order[1:][same]] = np.diff(order)[same]
    return out


def _stretch(stock: Repertoire, moments: Indices) -> tuple[int, int, int]:
    """Recording of moments that are played round and round, and the first and the last frame of them, over all end to end.

    Of several recordings that which has most.
    """
    frames = stock.frame_of(moments)
    recordings = stock.recording_of(frames)
    recording = int(np.bincount(recordings).argmax())
    own = frames[recordings == recording]
    return recording, int(own.min()), int(own.max())


def _own_frames(stock: Repertoire, recording: int, first: int, last: int) -> tuple[int, int]:
    """[first, end) in the recording's own frames, of frames over all recordings end to end at the output's rate."""
    step = max(1.0, stock.source_fps[recording] / stock.fps)
    return round(float(stock.source_frames[first])), round(float(stock.source_frames[last]) + step)
