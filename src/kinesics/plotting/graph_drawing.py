"""The motion graph on paper, in the composite layout of [Schultz2012] §3.5-3.6 (Figures 64-71).

Symmetric states stand on the central vertical axis, A left and A* right of it. Where the states stand is found in
`kinesics.plotting.graph_layout`, how the arrows run in `kinesics.plotting.graph_curves` and `graph_ways`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.grammar import notation
from kinesics.grammar.graph import MotionGraph, State
from kinesics.plotting import canvas
from kinesics.plotting.graph_curves import Arrow, Curve, curves_of, directions_at, extent_of, orbit_of, side_of
from kinesics.plotting.graph_labels import half_size, label_text, plain_labels
from kinesics.plotting.graph_layout import Place, lay_out, widest_gap
from kinesics.plotting.graph_moments import Moment
from kinesics.plotting.stick_figures import Placed, Strokes, View, draw_figures, strokes_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

_DOTS: Final = (0, (1.2, 1.7))


def graph_plot(
    graph: MotionGraph,
    *,
    figures: Mapping[int, Moment] | None = None,
    condensed: bool = False,
    view: View = "front",
    seed: int = 0,
    ax: Axes | None = None,
) -> Axes:
    """The motion graph in the composite layout.

    Symmetric states stand on the central vertical axis (dashed), a state left of it and its mirror image right, at mirrored places.
    A reversible path has two heads, a path known only by racemisation is dotted, parallel paths bow apart; an index is shown
    where there are several paths between two states.

    Parameters
    ----------
    figures : stick figures in the states: state id → motion and frame; `state_moments` finds them. States without stay empty.
    condensed : the short form that the dissertation gives after "or" (Figures 65-67).
    view : of the figures. Mirror images are told apart from the front.
    seed : of the layout.
    ax : where to draw; a new figure without, as large as the graph needs.

    Returns
    -------
    The axes, one unit a cell of the layout; equal scales.
    """
    states, arrows = _shown(graph, condensed)
    points = lay_out(
        [Place(orbit_of(s), side_of(s)) for s in states],
        _index_pairs(states, arrows),
        seed=seed,
    )
    where = {s.id: points[k] for k, s in enumerate(states)}
    radius = 0.31 if figures else 0.19 if len(states) <= 30 else 0.16
    curves = curves_of(states, arrows, where, radius)
    low, high = extent_of(points, curves, radius)
    if ax is None:
        pitch = (1.9 if figures else 1.35) * (1.0 if len(states) <= 20 else 0.8)
        width, height = np.maximum((high - low) * pitch, 2.0)
        ax = canvas.own_axes(float(width), float(height), rect=(0.0, 0.0, 1.0, 1.0))
    ax.set_aspect("equal")
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_axis_off()
    pixels = canvas.pixel_size(ax)
    cell = min(pixels[0] / (high[0] - low[0]), pixels[1] / (high[1] - low[1])) * 72.0 / ax.figure.dpi
    line = float(np.clip(cell / 70.0, 0.45, 1.4))
    if len(states):
        ax.axvline(0.0, color=canvas.GRID, linewidth=line, linestyle=(0, (5, 4)), zorder=0)
    head = 0.075 if figures else 0.095
    for curve in curves:
        _draw_curve(ax, curve, line, head)
    named = _draw_states(ax, states, where, curves, radius, figures or {}, view, cell, line)
    _draw_labels(ax, curves, points, radius, cell, head, named)
    if not states:
        ax.text(0.5, 0.5, "no states", ha="center", va="center", color=canvas.FAINT, transform=ax.transAxes)
    return ax


def _shown(graph: MotionGraph, condensed: bool) -> tuple[list[State], list[Arrow]]:
    if not condensed:
        return list(graph.states), [
            Arrow(
                p.from_,
                p.to,
                p.label,
                p.reversible,
                p.inferred,
                p.label.startswith("("),
                p.symmetric,
                p.index,
            )
            for p in graph.paths
        ]
    short = graph.condensed()
    return list(short.states), [
        Arrow(e.from_, e.to, e.label, e.both_ways, e.inferred, e.label.startswith("("), notation.BAR in e.label, k)
        for k, e in enumerate(short.edges)
    ]


def _index_pairs(states: Sequence[State], arrows: Sequence[Arrow]) -> list[tuple[int, int]]:
    place = {s.id: k for k, s in enumerate(states)}
    return [(place[a.from_], place[a.to]) for a in arrows]


def _draw_curve(ax: Axes, curve: Curve, line: float, head: float) -> None:
    from matplotlib.patches import Polygon

    points = curve.points
    ink = canvas.FAINT if curve.arrow.dotted else canvas.INK
    ax.plot(*points.T, color=ink, linewidth=line, linestyle=_DOTS if curve.arrow.dotted else "-", zorder=1)
    for ends in (points, points[::-1])[: 1 + curve.arrow.both_ways]:
        tip = ends[-1]
        back = tip - ends[max(int(np.argmax(np.hypot(*(ends - tip).T) < 1.1 * head)) - 1, 0)]
        along = back / max(float(np.linalg.norm(back)), 1e-9)
        across = np.array([-along[1], along[0]])
        corners = np.array([tip, *(tip - head * along + side * head * across for side in (0.38, -0.38))])
        ax.add_patch(Polygon(corners, closed=True, facecolor=ink, edgecolor=ink, linewidth=0.3 * line, zorder=1.2))


def _draw_states(
    ax: Axes,
    states: Sequence[State],
    where: Mapping[int, Array],
    curves: Sequence[Curve],
    radius: float,
    figures: Mapping[int, Moment],
    view: View,
    cell: float,
    line: float,
) -> list[tuple[Array, tuple[float, float]]]:
    """Circles, figures and labels; the centres and half sizes of labels that stand beside their states."""
    from matplotlib.patches import Circle

    everyone = np.array(list(where.values())).reshape(-1, 2)
    boxes: list[tuple[Array, tuple[float, float]]] = []
    size = float(np.clip(0.2 * cell, 4.5, 20.0))
    seen = [s.id for s in states if s.id in figures]
    drawn = dict(
        zip(seen, strokes_of([(m, [frame]) for m, frame in (figures[k] for k in seen)], view=view), strict=True)
    )
    bodies: list[Placed] = []
    for state in states:
        x, y = (float(v) for v in where[state.id])
        unseen = figures and state.id not in figures
        ax.add_patch(
            Circle(
                (x, y),
                radius,
                facecolor="white",
                edgecolor=canvas.FAINT if figures else canvas.INK,
                linewidth=line,
                linestyle=_DOTS if unseen else "-",
                zorder=1.5,
            )
        )
        text = label_text(state.label)
        if not figures:
            ax.text(
                x,
                y,
                text,
                fontsize=size,
                style="italic",
                ha="center",
                va="center_baseline",
                color=canvas.INK,
                zorder=4,
            )
            continue
        if state.id in figures:
            bodies.append(_figure(drawn[state.id], (x, y), radius, cell))
        angles = directions_at(curves, state.id, where[state.id], everyone, radius)
        preferred = 1.25 * np.pi if side_of(state) <= 0 else 1.75 * np.pi
        angle = widest_gap(angles, preferred)
        spot = np.array([x + (radius + 0.11) * np.cos(angle), y + (radius + 0.11) * np.sin(angle)])
        boxes.append((spot, half_size(text, 0.8 * size / cell)))
        ax.text(
            float(spot[0]),
            float(spot[1]),
            text,
            fontsize=0.8 * size,
            style="italic",
            ha="center",
            va="center",
            color=canvas.INK,
            zorder=4,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85},
        )
    draw_figures(ax, bodies)
    return boxes


def _figure(strokes: Strokes, centre: tuple[float, float], radius: float, cell: float) -> Placed:
    points = strokes.segments[0].reshape(-1, 2)
    top = max(float(points[:, 1].max()), float(strokes.head_centres[0, 1] + strokes.head_radius))
    low, high = points.min(axis=0), np.array([points[:, 0].max(), top])
    scale = 1.62 * radius / max(float(np.hypot(*(high - low))), 1.2)
    middle = 0.5 * (low + high) * scale
    origin = (centre[0] - float(middle[0]), centre[1] - float(middle[1]))
    return Placed(strokes, 0, origin, (scale, scale), float(np.clip(cell / 75.0, 0.5, 2.2)))


def _draw_labels(
    ax: Axes,
    curves: Sequence[Curve],
    points: Array,
    radius: float,
    cell: float,
    head: float,
    named: Sequence[tuple[Array, tuple[float, float]]],
) -> None:
    """Each label on its own arrow, at the place where it hides least."""
    size = float(np.clip((0.135 if len(points) <= 30 else 0.115) * cell, 3.6, 14.0))
    plain = plain_labels([c.arrow.label for c in curves])
    lines = [c.points for c in curves]
    boxes = list(named)
    # the short ones first: they have the least choice
    for number in np.argsort([round(float(np.hypot(*np.diff(p, axis=0).T).sum()), 6) for p in lines], kind="stable"):
        curve = curves[number]
        index = curve.arrow.label not in plain
        text = label_text(curve.arrow.label, index=index)
        half = half_size(text, size / cell)
        others = np.concatenate([np.zeros((0, 2)), *(p for k, p in enumerate(lines) if k != number)])
        spots, cost = _label_places(curve, half, head)
        cost = cost + _inside(points, spots, np.add(half, 0.85 * radius)).sum(axis=1)
        cost += 0.12 * np.minimum(_inside(others, spots, half).sum(axis=1), 8.0)
        both = np.array([size_there for _, size_there in boxes]).reshape(-1, 2) + half
        centres = np.array([centre for centre, _ in boxes]).reshape(-1, 2)
        cost += 3.0 * _inside(centres, spots, both).sum(axis=1) + 0.4 * _inside(centres, spots, 1.2 * both).sum(axis=1)
        best = spots[int(np.argmin(np.round(cost, 9)))]
        boxes.append((best, half))
        ink = canvas.FAINT if curve.arrow.dotted else canvas.INK
        ax.text(
            float(best[0]),
            float(best[1]),
            text,
            fontsize=size,
            style="italic",
            ha="center",
            va="center",
            color=ink,
            zorder=3,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.06 * size, "alpha": 0.9},
        )


def _label_places(curve: Curve, half: tuple[float, float], head: float) -> tuple[Array, Array]:
    """Where the label of an arrow may stand (n, 2), and how much less good than on its middle that is (n,).

    On the line, where that leaves enough of it to be seen; beside it otherwise; outside a loop.
    """
    points = curve.points
    count = len(points)
    if curve.arrow.from_ == curve.arrow.to:
        apex = points[count // 2]
        outward = apex - 0.5 * (points[0] + points[-1])
        outward /= max(float(np.linalg.norm(outward)), 1e-9)
        reach = abs(outward[0]) * half[0] + abs(outward[1]) * half[1]
        return (apex + outward * (reach + 0.03))[None], np.zeros(1)
    length = float(np.hypot(*np.diff(points, axis=0).T).sum()) - head * (1 + curve.arrow.both_ways)
    out: list[tuple[Array, float]] = []
    for at in (0.5, 0.46, 0.54, 0.42, 0.58, 0.38, 0.62, 0.34, 0.66, 0.3, 0.7, 0.26, 0.74, 0.2, 0.8):
        k = round(at * (count - 1))
        along = points[min(k + 2, count - 1)] - points[max(k - 2, 0)]
        along = along / max(float(np.linalg.norm(along)), 1e-9)
        covered = 2.0 * min(half[0] / max(abs(along[0]), 1e-9), half[1] / max(abs(along[1]), 1e-9))
        price = 0.3 * abs(at - 0.5)
        if covered < 0.62 * length and abs(at - 0.5) * length + 0.5 * covered < 0.5 * length:
            out.append((points[k], price))
        elif abs(at - 0.5) < 0.2:
            normal = np.array([-along[1], along[0]])
            # above the line; beside an upright one away from the axis, as its mirror image will be
            wanted = normal[1] if abs(normal[1]) > 0.3 else normal[0] * (points[k, 0] or 1.0)
            normal = normal if wanted >= 0.0 else -normal
            reach = abs(normal[0]) * half[0] + abs(normal[1]) * half[1] + 0.03
            out += [(points[k] + normal * reach, price + 0.1), (points[k] - normal * reach, price + 0.15)]
    if not out:
        return points[count // 2][None], np.zeros(1)
    return np.array([spot for spot, _ in out]), np.array([price for _, price in out])


def _inside(points: Array, centres: Array, half: ArrayLike) -> NDArray[np.bool_]:
    """Whether each point (n, 2) is in a box of half size ``half``, one for all or (n, 2), about each centre; (centres, n)."""
    off = np.abs(points - centres[:, None]) < half
    return np.asarray(off[..., 0] & off[..., 1])
