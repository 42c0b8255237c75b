"""The arrows of a motion graph: one line for each pair of states, parallel ones bowed apart, loops where there is room."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.grammar import notation
from kinesics.grammar.graph import State
from kinesics.plotting.graph_layout import widest_gap

Array = NDArray[np.float64]

_BOW: Final = 0.26
"""Cells between parallel arrows."""
_SAMPLES: Final = 48
"""Points of a curve."""


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
    """All arrows laid out between states that stand at ``where``, by id, and are ``radius`` large."""
    rank = {s.id: (orbit_of(s), side_of(s)) for s in states}
    groups: dict[tuple[int, int], list[Arrow]] = {}
    for arrow in arrows:
        first, second = sorted((arrow.from_, arrow.to), key=lambda s: rank[s])
        groups.setdefault((first, second), []).append(arrow)
    everyone = np.array(list(where.values())).reshape(-1, 2)
    curves: list[Curve] = []
    for (first, second), members in groups.items():
        if first == second:
            continue
        a, b = where[first], where[second]
        normal = _normal(a, b)
        members.sort(key=lambda m: (_order(m), rank[m.from_], m.index, m.starred))
        offsets = _offsets(members, central=bool(a[0] == 0.0 and b[0] == 0.0))
        others = everyone[[not (np.array_equal(p, a) or np.array_equal(p, b)) for p in everyone]]
        bows = _way_round(a, b, normal, others, offsets, radius)
        for member, bow in zip(members, bows, strict=True):
            curve = _bowed(a, b, normal * bow, radius)
            curves.append(Curve(member, curve if member.from_ == first else curve[::-1]))
    for state in states:
        loops = groups.get((state.id, state.id), [])
        here = where[state.id]
        angles = directions_at(curves, state.id, here, everyone, radius)
        preferred = {-1: np.pi, 1: 0.0, 0: 0.5 * np.pi}[side_of(state)]
        for loop in sorted(loops, key=lambda m: m.index):
            angle = widest_gap(angles, preferred)
            angles += [angle - 0.5, angle, angle + 0.5]
            curves.append(Curve(loop, _loop(here, angle, radius)))
    return curves


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


def _way_round(
    a: Array, b: Array, normal: Array, others: Array, offsets: Sequence[float], radius: float
) -> list[float]:
    """How far each arrow of a bundle bows to pass the states between: all on one side, or some on either."""
    if not len(others):
        return list(offsets)
    length = float(np.linalg.norm(b - a))
    step = max(0.3, 0.16 * length) * (-1.0 if a[0] == b[0] == 0.0 else 1.0)
    together = [
        [base + o for o in offsets] for base in step * np.array([0.0, 0.6, -0.6, 1, -1, 1.5, -1.5, 2.1, -2.1, 3, -3])
    ]
    apart = [[o + float(np.sign(o)) * base for o in offsets] for base in abs(step) * np.array([0.6, 1.0, 1.5, 2.1])]
    best, least = list(offsets), np.inf
    for bows in [*together, *(apart if len(offsets) > 1 else [])]:
        hits = 0.0
        for bow in bows:
            curve = _bowed(a, b, normal * bow, 0.0)
            near = np.hypot(*np.moveaxis(others[:, None] - curve[None], -1, 0)).min(axis=1)
            hits += float((near < radius + 0.06).sum()) + 0.4 * float((near < radius + 0.15).sum())
        cost = hits + 0.25 * max(abs(bow) for bow in bows) / max(length, 1.0)
        if cost < least - 1e-9:
            best, least = bows, cost
    return best


def _bowed(a: Array, b: Array, apex: Array, radius: float) -> Array:
    """A quadratic Bézier curve whose middle is ``apex`` away from the straight line, cut at the rims."""
    t = np.linspace(0.0, 1.0, 4 * _SAMPLES)[:, None]
    control = 0.5 * (a + b) + 2.0 * apex
    curve = (1 - t) ** 2 * a + 2 * t * (1 - t) * control + t**2 * b
    rim = radius * 1.08
    outside = (np.hypot(*(curve - a).T) >= rim) & (np.hypot(*(curve - b).T) >= rim)
    kept = curve[outside]
    return np.asarray(kept[np.linspace(0, len(kept) - 1, _SAMPLES).astype(np.intp)])


def _loop(centre: Array, angle: float, radius: float) -> Array:
    """A cubic Bézier curve that leaves a state and comes back."""
    spread, reach = 0.5, radius + (0.62 if radius < 0.25 else 0.5)
    points = [
        centre + r * np.array([np.cos(angle + s), np.sin(angle + s)])
        for r, s in (
            (radius * 1.08, spread),
            (reach, spread * 1.05),
            (reach, -spread * 1.05),
            (radius * 1.08, -spread),
        )
    ]
    t = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
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
