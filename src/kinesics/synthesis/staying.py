"""Whether a performance stays in place, or stands still, though its recordings do not."""

from __future__ import annotations

import itertools
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.analysis.stillness import EPSILON
from kinesics.body.pose import poses
from kinesics.similarity import check_weights, chord
from kinesics.similarity.metric import paired_distance
from kinesics.synthesis.joining.limits import BLEND
from kinesics.synthesis.piece import IN_PLACE, Piece
from kinesics.synthesis.repertoire import Repertoire

Mask = NDArray[np.bool_]

LOOKED_AT: Final = 9
"""Beginnings of a stretch of a recording that are looked at, whether the body stays in place."""
_BLOCK: Final = 4096


def going_about(piece: Piece) -> list[str]:
    """Recordings in which the body leaves its place within as long as was performed, wherever one begins."""
    stock = piece.network.repertoire
    out = []
    for name, (start, end) in zip(stock.names, itertools.pairwise(stock.starts.tolist()), strict=True):
        trail = stock.root_positions[0, start:end][:, [0, 2]]
        frames = min(piece.motion.frame_count, end - start)
        begins = np.unique(np.linspace(0, end - start - frames, LOOKED_AT).astype(np.intp))
        if all(np.ptp(trail[b : b + frames], axis=0).max() >= IN_PLACE for b in begins.tolist()):
            out.append(name)
    return out


def moving(piece: Piece) -> float:
    """Share of the performance in which the pose changes by more than a body at rest sways, within the time of a blend."""
    own = poses(piece.motion).quaternions
    return _share(own, np.array([0, len(own)]), piece.motion.fps, np.ones(len(own), np.bool_))


def moving_recorded(stock: Repertoire, among: Mask | None = None) -> float:
    """The same of all recordings together, or of some of their frames, shape (frames,)."""
    every = np.ones(stock.frame_count, dtype=np.bool_)
    return _share(stock.poses.quaternions, stock.starts, stock.fps, every if among is None else among)


def _share(quaternions: NDArray[np.float64], starts: NDArray[np.intp], fps: float, among: Mask) -> float:
    lag, weights = max(1, round(BLEND * fps)), check_weights(None)
    index = np.arange(len(quaternions) - lag)
    together = np.searchsorted(starts, index, "right") == np.searchsorted(starts, index + lag, "right")
    early = index[together & among[index]]
    if not len(early):
        return 0.0
    count = sum(
        int(np.count_nonzero(chord(paired_distance(quaternions[at], quaternions[at + lag], weights)) > EPSILON))
        for at in np.array_split(early, -(-len(early) // _BLOCK))
    )
    return count / len(early)
