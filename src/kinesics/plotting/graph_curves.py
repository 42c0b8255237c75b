"""The arrows of a motion graph: one line for each pair of states, parallel ones bowed apart, loops where there is room."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar import notation
from kinesics.grammar.graph import State
from kinesics.plotting.graph_layout import gaps
from kinesics.plotting.graph_ways import RIM, SAMPLES, Ways

Array = NDArray[np.float64]

_BOW: Final = 0.26
"""Cells between parallel arrows."""
_LOOP_SIZES: Final = (1.0, 0.8, 0.6)
_MIRROR: Final = np.array([-1.0, 1.0])


@dataclass(frozen=True)
class Arrow:
    """What is drawn of one or several paths."""

    from_: int
    to: int
    label: str
    both_ways: bool
    dotted: bool
    starred: bool
    symmetric: bool
    index: int


@dataclass(frozen=True)
class Curve:
    """An arrow laid out: points (samples, 2) from its start to its end, between the rims of its states."""

    arrow: Arrow
    points: Array


def side_of(state: State) -> int:
    """0 on the axis of symmetry, −1 left and 1 right of it."""
    return 0 if state.symmetric else 1 if state.label.endswith(notation.MIRROR) else -1


def orbit_of(state: State) -> int:
    """The same number for a state and its mirror image."""
    return state.id if state.mirror_of is None else min(state.id, state.mirror_of)


def curves_of(
    states: Sequence[State], arrows: Sequence[Arrow], where: Mapping[int, Array], radius: float
) -> list[Curve]:
    """All arrows laid out between states that stand at ``where``, by id, a cell apart, and are ``radius`` large.

    No arrow runs through a state that it does not join. The arrows of a pair of states are mirror images of those of the mirrored
    pair, if those are as many; between states on the axis the starred ones are images of the others.
    """
    everyone = np.array(list(where.values())).reshape(-1, 2)
    ways = Ways(everyone, radius)
    curves = _joining(states, arrows, where, ways)
    known: dict[int, list[Array]] = {}
    for state in states:
        loops = sorted((a for a in arrows if a.from_ == a.to == state.id), key=lambda m: m.index)
        here = where[state.id]
        drawn = [points * _MIRROR for points in known.get(_image(state), [])]
        if len(drawn) != len(loops) or any(ways.hits(points, [here]) for points in drawn):
            angles = directions_at(curves, state.id, here, everyone, radius)
            drawn = []
            for _ in loops:
                angle, points = _free_loop(here, angles, {-1: np.pi, 1: 0.0, 0: 0.5 * np.pi}[side_of(state)], ways)
                angles += [angle - 0.5, angle, angle + 0.5]
                drawn.append(points)
        known[state.id] = drawn
        curves += [Curve(loop, points) for loop, points in zip(loops, drawn, strict=True)]
    return curves


def _joining(states: Sequence[State], arrows: Sequence[Arrow], where: Mapping[int, Array], ways: Ways) -> list[Curve]:
    """The arrows between two states, the shortest first: they have the least choice."""
    rank = {s.id: (orbit_of(s), side_of(s)) for s in states}
    image = {s.id: _image(s) for s in states}
    groups: dict[tuple[int, int], list[Arrow]] = {}
    for arrow in arrows:
        first, second = sorted((arrow.from_, arrow.to), key=lambda s: rank[s])
        if first != second:
            groups.setdefault((first, second), []).append(arrow)

    def length(pair: tuple[int, int]) -> float:
        return round(float(np.hypot(*(where[pair[0]] - where[pair[1]]))), 6)

    laid: dict[tuple[int, int], list[Array]] = {}
    curves: list[Curve] = []
    for first, second in sorted(groups, key=lambda pair: (length(pair), rank[pair[0]], rank[pair[1]])):
        members = groups[first, second]
        a, b = where[first], where[second]
        central = bool(a[0] == 0.0 and b[0] == 0.0)
        twin = (image[first], image[second])
        if central or image[first] == second:
            members.sort(key=lambda m: (_order(m), rank[m.from_], m.index, m.starred))
        else:
            # the same order for the mirror images
            members.sort(key=lambda m: (rank[m.from_][0], len(m.label.strip("()*")), m.label.strip("()*"), m.index))
        if len(laid.get(twin, [])) == len(members):
            drawn = [points * _MIRROR for points in laid[twin]]
            ways.lay(drawn)
        else:
            kinds = [_order(m) for m in members]
            paired = central and kinds.count(-1) == kinds.count(1) > 0
            symmetric = paired or (twin != (first, second) and len(groups.get(twin, [])) == len(members))
            offsets = _offsets(members, central=central)
            drawn = ways.bundle(a, b, _normal(a, b), offsets, symmetric=symmetric, paired=paired)
        laid[first, second] = drawn
        curves += [
            Curve(member, points if member.from_ == first else points[::-1])
            for member, points in zip(members, drawn, strict=True)
        ]
    return curves


def _image(state: State) -> int:
    """The id of the mirror image; −1 for none."""
    return state.id if state.symmetric else -1 if state.mirror_of is None else state.mirror_of


def _order(arrow: Arrow) -> int:
    return 0 if arrow.symmetric else 1 if arrow.starred else -1


def _normal(a: Array, b: Array) -> Array:
    """Unit normal of a pair of states; of the mirrored pair it is the mirrored one, of a pair on the axis it points right."""
    along = (b - a) / np.linalg.norm(b - a)
    normal = np.array([-along[1], along[0]])
    if a[0] == 0.0 and b[0] == 0.0:
        return np.asarray(normal * np.sign(normal[0]))
    on_the_left = a[0] < 0.0 or (a[0] == 0.0 and b[0] < 0.0)
    return np.asarray(normal if on_the_left else -normal)


def _offsets(members: Sequence[Arrow], *, central: bool) -> list[float]:
    """How far each arrow of a pair bows, sorted: on the axis symmetric paths keep to it, the others left and their images right."""
    count = len(members)
    if not central:
        return [_BOW * (k - 0.5 * (count - 1)) for k in range(count)]
    kinds = [_order(m) for m in members]
    left, middle = kinds.count(-1), kinds.count(0)
    inner = 0.5 * (middle - 1) if middle else -0.5
    out = []
    for k, kind in enumerate(kinds):
        if kind < 0:
            out.append(-_BOW * (inner + left - k))
        elif kind == 0:
            out.append(_BOW * (k - left - 0.5 * (middle - 1)))
        else:
            out.append(_BOW * (inner + 1 + k - left - middle))
    return out


def _free_loop(here: Array, angles: Sequence[float], preferred: float, ways: Ways) -> tuple[float, Array]:
    """A loop where there is room for it, smaller where there is little: its direction and points."""
    tried: list[tuple[float, Array]] = []
    for size in _LOOP_SIZES:
        for angle in gaps(angles, preferred):
            points = _loop(here, angle, ways.radius, size)
            if not ways.hits(points, [here]):
                return angle, points
            tried.append((angle, points))
    return min(tried, key=lambda t: ways.hits(t[1], [here]))


def _loop(centre: Array, angle: float, radius: float, size: float) -> Array:
    """A cubic Bézier curve that leaves a state and comes back."""
    spread, reach = 0.5, radius + (0.62 if radius < 0.25 else 0.5) * size
    points = [
        centre + r * np.array([np.cos(angle + s), np.sin(angle + s)])
        for r, s in (
            (radius * RIM, spread),
            (reach, spread * 1.05),
            (reach, -spread * 1.05),
            (radius * RIM, -spread),
        )
    ]
    t = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    weights = ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3)
    return np.asarray(sum(w * p for w, p in zip(weights, points, strict=True)))


def directions_at(curves: Sequence[Curve], state: int, here: Array, everyone: Array, radius: float) -> list[float]:
    """The angles around a state at which there is something: arrows that touch or pass it, states beside it."""
    out: list[Array] = []
    for curve in curves:
        away = curve.points - here
        if curve.arrow.from_ == curve.arrow.to == state:
            ends = away[[3, -4]]
            out.append(np.concatenate([ends, ends.mean(axis=0, keepdims=True)]))
        elif state in (curve.arrow.from_, curve.arrow.to):
            out.append(away[[3 if curve.arrow.from_ == state else -4]])
        else:
            out.append(away[np.hypot(*away.T) < radius + 0.22][::4])
    beside = everyone - here
    distance = np.hypot(*beside.T)
    out.append(beside[(distance > 0.0) & (distance < 1.1)])
    found = np.concatenate(out)
    return [float(v) for v in np.arctan2(found[:, 1], found[:, 0])]


def extent_of(points: Array, curves: Sequence[Curve], radius: float) -> tuple[Array, Array]:
    """Lower left and upper right corner of what is drawn, with room for the labels of loops."""
    loops = [
        c.points + 0.4 * (c.points - c.points[[0, -1]].mean(axis=0)) for c in curves if c.arrow.from_ == c.arrow.to
    ]
    everything = np.concatenate(
        [points - radius, points + radius, *(c.points for c in curves), *loops, np.zeros((1, 2))]
    )
    low, high = everything.min(axis=0) - 0.3, everything.max(axis=0) + 0.3
    # the axis of symmetry is the middle of the picture, unless all is on one side of it
    half = max(-low[0], high[0])
    one_sided = len(points) > 0 and bool((points[:, 0] < 0.0).all() or (points[:, 0] > 0.0).all())
    return (low, high) if one_sided else (np.array([-half, low[1]]), np.array([half, high[1]]))
