"""How long it still takes to a target, by what the recordings let a performer do: the cost-to-go of the material.

Composites look a few seconds ahead. A target inside the narrowest turn asks for more: one has to walk away from it and come
back, and every step of that seems wrong to whoever looks only so far. So, as a further extension beyond [Schultz2012] §4.4.1,
the seconds to go are computed once, by dynamic programming over the ends of the composites, as a function of where a target
lies from the performer (distance and bearing) and of what the performer can do next:

    V(i, d) = min over composites c after path i of  t, if the target is met t seconds on;  else T + V(end of c, d as seen there)

Paths that can do alike share a table. The iteration starts from below, from the straight way at full pace, so that after n rounds
V is true for all that takes less than n composites, and what cannot be met at all goes on growing.

References
----------
Bellman 1957, *Dynamic Programming*. Value functions over motion graphs: Lo and Zwicker 2008, *Real-time planning for
parameterized human motion*; Treuille, Lee and Popović 2007, *Near-optimal character animation with continuous control*.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.synthesis.paths.trails import Trail

if TYPE_CHECKING:
    from scipy.sparse import csr_array


Floats = NDArray[np.float32]
Indices = NDArray[np.signedinteger]
Complexes = NDArray[np.complexfloating]

KINDS: Final = 128
"""Tables at most: paths that can do alike share one."""
TURNS: Final = 12
"""Composites after a path that count, spread over how far they turn; and each unbent and bent either way."""
PER_FOLD: Final = 6.0
"""Distances d at which the tables are kept, for every factor e in 1 m + d: near targets are told apart best."""
KNOTS: Final = tuple(math.expm1(k / PER_FOLD) for k in range(15))
"""Metres, up to 9.3; beyond, the straight way is added."""
BEARINGS: Final = 24
"""Directions in which they are kept, the first straight ahead."""
ROUNDS: Final = 16
"""Composites one after the other that are thought of."""
LEAST_RADIUS: Final = 0.25
"""Metres: composites are looked at every quarter of a second, so that smaller targets would slip through between."""


@dataclass(frozen=True, eq=False)
class ToGo:
    """Seconds to a target."""

    kind: Indices
    """Table of each path, by what may follow it: shape (paths,)."""
    seconds: Floats
    """Shape (kinds, knots, bearings + 1)."""
    pace: float
    """Metres a second, straight on."""
    detour: float
    """Seconds more than straight on: for what takes longer no way was found."""

    def hopeless(self, path: int, target: complex) -> bool:
        """Whether no way was found to a target z + i·x metres away, seen by one who has just played a path."""
        seconds = self.after(np.array([path]), np.array([target], dtype=np.complex64), np.zeros(1, dtype=np.float32))
        return bool(seconds[0] > abs(target) / self.pace + self.detour)

    def by(self, trail: Trail, target: complex, bends: Floats) -> Floats:
        """Seconds to a target z + i·x metres away, by each of the trails and on from its end, if it is bent by each of
        ``bends`` (n,), radians a metre: shape (n, rows).
        """
        if not compiled.wanted():
            bend = bends[:, None]
            there = trail.places[:, -1] + bend * trail.swerve[:, -1]
            turned = trail.headings[:, -1] + bend * trail.travelled[:, -1]
            return trail.times[:, -1] + self.after(trail.playing[:, -1], np.complex64(target) - there, turned)
        out = np.empty((len(bends), len(trail.places)), dtype=np.float32)
        compiled.native.seconds_by(
            self.seconds,
            self.kind,
            trail.playing[:, -1],
            trail.places.view(np.float32)[:, -2:],
            trail.swerve.view(np.float32)[:, -2:],
            trail.headings[:, -1],
            trail.travelled[:, -1],
            trail.times[:, -1],
            bends,
            target.real,
            target.imag,
            PER_FOLD,
            KNOTS[-1],
            1.0 / self.pace,
            out,
        )
        return out

    def after(self, paths: Indices, target: Complexes, turned: Floats) -> Floats:
        """Seconds to targets z + i·x metres away, for those who have just played each path and are turned by so many radians."""
        entry, part, slant, beyond = _spot(self.kind[paths], target, turned)
        flat, width = self.seconds.ravel(), BEARINGS + 1
        near, far = flat[entry], flat[entry + width]
        near += slant * (flat[entry + 1] - near)
        far += slant * (flat[entry + (width + 1)] - far)
        near += part * (far - near)
        near += beyond * np.float32(1.0 / self.pace)
        return near


def to_go(trail: Trail, first: Indices, reach: float, radius: float, bend: float) -> ToGo:
    """Seconds to go to a target.

    Parameters
    ----------
    trail : of all composites, those that may follow path ``i`` in rows ``first[i]:first[i + 1]``.
    reach : metres that a composite leads at most.
    radius : how near counts as there, metres.
    bend : how much the way may be bent to either side, radians a metre.
    """
    kind, chosen = _kinds(trail, first)
    rows, owner = _rows(trail, first, chosen)
    bends = np.array([0.0, -bend, bend] if bend > 0.0 else [0.0], dtype=np.float32)[:, None, None]
    places = (trail.places[rows] + bends * trail.swerve[rows]).reshape(-1, trail.places.shape[1])
    turned = (trail.headings[rows, -1] + bends[..., 0] * trail.travelled[rows, -1]).ravel()
    end = kind[np.tile(trail.playing[rows, -1], len(bends))]
    owner = np.tile(owner, len(bends))
    order = np.argsort(owner, kind="stable")
    places, turned, end = places[order], turned[order], end[order]
    groups = np.searchsorted(owner[order], np.arange(len(chosen)))
    knots = np.array(KNOTS, dtype=np.float32)
    around = np.exp(2j * np.pi * np.arange(BEARINGS) / BEARINGS).astype(np.complex64)
    targets = (knots[:, None] * around).ravel()
    times = trail.times[0]
    horizon = float(times[-1])
    met = np.full((len(places), len(targets)), np.inf, dtype=np.float32)
    within = max(radius, LEAST_RADIUS)
    for k in range(len(times) - 1, -1, -1):
        square = _square(targets - places[:, k, None])
        met[square <= within**2] = times[k]
    spot = _spot(end[:, None], targets - places[:, -1, None], turned[:, None])
    shape = (len(chosen), len(knots), BEARINGS)
    mixing = _mixing(spot, len(chosen) * len(knots) * (BEARINGS + 1))
    pace = max(reach / horizon, 1e-3)
    away = np.abs(targets)
    here = away <= within
    table = np.broadcast_to((np.maximum(away - within, 0.0) / pace).astype(np.float32), (len(chosen), len(targets)))
    further = spot.beyond * np.float32(1.0 / pace) + np.float32(horizon)
    for _ in range(ROUNDS):
        then = (mixing @ _closed(table.reshape(shape)).ravel()).reshape(met.shape)
        then += further
        np.minimum(then, met, out=then)
        table = np.minimum.reduceat(then, groups, axis=0)
        table[:, here] = 0.0
    return ToGo(kind, _closed(table.reshape(shape)), pace, 0.75 * ROUNDS * horizon)


def _kinds(trail: Trail, first: Indices) -> tuple[Indices, Indices]:
    """Paths put together by how far and whither one turns after them; and one path of each kind."""
    turned, gone = trail.headings[:, -1], np.abs(trail.places[:, -1])
    features = np.stack(
        [
            np.minimum.reduceat(turned, first[:-1]),
            np.maximum.reduceat(turned, first[:-1]),
            np.add.reduceat(turned, first[:-1]) / np.diff(first),
            np.maximum.reduceat(gone, first[:-1]),
        ],
        axis=1,
    )
    # the farthest from all chosen so far, again and again
    chosen = [0]
    away = _square(features - features[0], axis=1)
    kind = np.zeros(len(features), dtype=np.intp)
    while len(chosen) < min(KINDS, len(features)) and away.max() > 1e-6:
        chosen.append(int(np.argmax(away)))
        off = _square(features - features[chosen[-1]], axis=1)
        kind[off < away] = len(chosen) - 1
        away = np.minimum(away, off)
    return kind, np.array(chosen, dtype=np.intp)


def _rows(trail: Trail, first: Indices, chosen: Indices) -> tuple[Indices, Indices]:
    """Of the composites after each chosen path the fastest of those that turn about as far; and whose they are."""
    turned, gone = trail.headings[:, -1], np.abs(trail.places[:, -1])
    rows: list[Indices] = []
    for path in chosen.tolist():
        low, high = first[path : path + 2].tolist()
        order = low + np.argsort(turned[low:high], kind="stable")
        parts = np.array_split(order, min(TURNS, high - low))
        fastest = [int(part[np.argmax(gone[part])]) for part in parts]
        rows.append(np.unique([order[0], *fastest, order[-1]]))
    return np.concatenate(rows), np.repeat(np.arange(len(chosen)), [len(r) for r in rows])


class _Spot(NamedTuple):
    """Where a target lies in the tables: the knot and bearing below it, how far it is to the next ones, metres beyond all."""

    entry: Indices
    """Of the flattened tables."""
    part: Floats
    slant: Floats
    beyond: Floats


def _spot(kind: Indices, target: Complexes, turned: Floats) -> _Spot:
    away = np.sqrt(_square(target))
    step = np.minimum(np.log1p(away) * np.float32(PER_FOLD), np.float32(len(KNOTS) - 1.001))
    turn = (np.arctan2(target.imag, target.real) - turned) * np.float32(1.0 / (2.0 * np.pi))
    turn -= np.floor(turn)
    turn *= np.float32(BEARINGS)
    low, sector = np.floor(step), np.minimum(np.floor(turn), np.float32(BEARINGS - 1))
    entry = (kind * len(KNOTS) + low.astype(np.int32)) * (BEARINGS + 1) + sector.astype(np.int32)
    beyond = np.maximum(away - np.float32(KNOTS[-1]), np.float32(0.0))
    return _Spot(entry, step - low, turn - sector, beyond)


def _mixing(spot: _Spot, entries: int) -> csr_array:
    """The matrix that interpolates in flattened tables."""
    from scipy.sparse import csr_array

    entry, part, slant = spot.entry.ravel().astype(np.int32), spot.part.ravel(), spot.slant.ravel()
    weights = np.empty((len(entry), 4), dtype=np.float32)
    np.multiply(part, slant, out=weights[:, 3])
    np.subtract(slant, weights[:, 3], out=weights[:, 1])
    np.subtract(part, weights[:, 3], out=weights[:, 2])
    np.subtract(1.0 - part, weights[:, 1], out=weights[:, 0])
    corners = entry[:, None] + np.array([0, 1, BEARINGS + 1, BEARINGS + 2], dtype=np.int32)
    ends = np.arange(0, 4 * len(entry) + 1, 4, dtype=np.int32)
    return csr_array((weights.ravel(), corners.ravel(), ends), shape=(len(entry), entries))


def _closed(table: Floats) -> Floats:
    """With the first bearing again after the last."""
    return np.concatenate([table, table[:, :, :1]], axis=2)


def _square(values: NDArray[np.inexact], axis: int | None = None) -> Floats:
    square = values.real**2 + values.imag**2
    return np.asarray(square if axis is None else square.sum(axis=axis), dtype=np.float32)
