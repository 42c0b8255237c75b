"""Where paths and composites of them lead over the floor, point by point.

On the ground a place is one complex number, z + i·x: a turn by an angle ψ (radians about +y, positive to the left) is then a
product with e^{iψ}. Places and headings of a path or composite are relative to those at its first frame.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Places = NDArray[np.complex64]
Indices = NDArray[np.intp]


class Trails(NamedTuple):
    """Where the root goes within each path, frame by frame, relative to the path's first frame."""

    start: Indices
    """Of each path in the arrays below; it has ``length + 1`` points, at the last of which the next path begins: (paths,)."""
    places: NDArray[np.complex128]
    """z + i·x, metres, shape (points,)."""
    headings: Array
    """Radians, shape (points,)."""
    travelled: Array
    """Metres along the way, shape (points,)."""


class Trail(NamedTuple):
    """Where composites lead, point by point: rows are composites that are weighed against each other."""

    times: Floats
    """Seconds from the composite's beginning, shape (1 or rows, points)."""
    places: Places
    """z + i·x as seen from the first frame, metres, shape (rows, points)."""
    headings: Floats
    """Radians turned, shape (rows, points)."""
    travelled: Floats
    """Metres walked, shape (rows, points)."""
    swerve: Places
    """How the places move if the way is bent by 1 radian a metre, to first order: shape (rows, points)."""
    playing: NDArray[np.int32]
    """The path that is being played: shape (rows, points)."""


def trails(network: Network) -> Trails:
    """The way of the root within each path, from the recordings, or those with their feet planted (`Network.afoot`)."""
    repertoire = network.repertoire if network.afoot is None else network.afoot
    length = np.asarray(network.length, dtype=np.intp)
    start = np.concatenate([[0], np.cumsum(length + 1)[:-1]]).astype(np.intp)
    path = np.repeat(np.arange(len(length)), length + 1)
    frame = np.arange(len(path)) - start[path]
    moments = repertoire.advance(network.first[path], frame)
    roots = repertoire.roots_of(moments)
    ground = roots[:, 2] + 1j * roots[:, 0]
    yaw = repertoire.yaw_of(moments)
    # a path may turn by more than half a turn: it is followed frame by frame
    step = (np.diff(yaw, prepend=0.0) + np.pi) % (2.0 * np.pi) - np.pi
    turned = np.cumsum(step)
    places = (ground - ground[start][path]) * np.exp(-1j * yaw[start][path])
    strides = np.abs(np.diff(places, prepend=0.0))
    strides[start] = 0.0
    walked = np.cumsum(strides)
    return Trails(start, places, turned - turned[start][path], walked - walked[start][path])
