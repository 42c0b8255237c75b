"""The motion graph on paper, in the composite layout of [Schultz2012] §3.5-3.6 (Figures 64-71).

- `graph_plot`: symmetric states on the central vertical axis, A left and A* right of it
- `path_strips`: each path as its poses one over the other, the grey lightening as it evolves
- `state_margin`: labels of the states on the margin of a Z/Z* plot
- `state_moments`: the moment that shows each state best, for the figures in `graph_plot`
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.mirroring import mirror
from kinesics.errors import InputError
from kinesics.grammar import notation
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, State, ends_of
from kinesics.plotting import canvas
from kinesics.plotting.graph_layout import Place, lay_out, widest_gap
from kinesics.plotting.stick_figures import View, compute_strokes, draw_strokes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from kinesics.body.motion import Motion

Array = NDArray[np.float64]
Moment = tuple["Motion", int]
"""A motion and one of its frames."""

_DOTS: Final = (0, (1.2, 1.7))
_BOW: Final = 0.26
"""Cells between parallel arrows."""
_SAMPLES: Final = 48
_LETTERS: Final = re.compile(r"(?P<first>[A-Za-z][0-9]*\*?)(?P<second>[a-z][0-9]*\*?)?(?:_(?P<index>[0-9]+))?")
_BARRED: Final = re.compile(rf"(?P<letter>[A-Z])(?P<number>[0-9]*){notation.BAR}")
_SUBSCRIPTS: Final = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


@dataclass(frozen=True)
class _Arrow:
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
class _Curve:
    """An arrow laid out: points (samples, 2) from its start to its end, between the rims of its states."""

    arrow: _Arrow
    points: Array


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
        [Place(_orbit(s), _side(s)) for s in states],
        _index_pairs(states, arrows),
        seed=seed,
    )
    where = {s.id: points[k] for k, s in enumerate(states)}
    radius = 0.31 if figures else 0.19 if len(states) <= 30 else 0.16
    curves = _curves(states, arrows, where, radius)
    low, high = _extent(points, curves, radius)
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


def state_moments(graph: MotionGraph, motions: Sequence[Motion]) -> dict[int, Moment]:
    """For each state the moment that shows it best: the middle of its longest stay, else the middle one of its passages.

    A state that was never seen, but whose mirror image was, is shown by the mirrored motion; one that was never seen at all is
    left out.

    Parameters
    ----------
    motions : of the sources of the graph, one each; a source's frames are the motion's.

    Raises
    ------
    InputError
        If there are not as many motions as sources, or one has another number of frames.
    """
    _check_motions(graph, motions)
    passages: dict[int, list[tuple[int, int]]] = {}
    for number in range(len(graph.sources)):
        for step in graph.timeline(number):
            for end, frame, known in zip(
                ends_of(graph, step),
                (step.start, step.end - 1),
                (step.complete or step.start > 0, step.complete or step.start == 0),
                strict=True,
            ):
                if known:
                    passages.setdefault(end, []).append((number, frame))
    # the first and the last are often half-hearted
    seen = {state: met[len(met) // 2] for state, met in passages.items()}
    for state in graph.states:
        if state.stays:
            longest = max(state.stays, key=lambda s: s.end - s.start)
            seen[state.id] = (longest.source, (longest.start + longest.end) // 2)
    moments: dict[int, Moment] = {}
    for state in graph.states:
        image = state.mirror_of
        if state.id in seen:
            source, frame = seen[state.id]
            moments[state.id] = (motions[source], frame)
        elif image is not None and image in seen:
            source, frame = seen[image]
            moments[state.id] = (mirror(motions[source][frame : frame + 1]), 0)
    return moments


def path_strips(
    graph: MotionGraph,
    motions: Sequence[Motion],
    *,
    paths: Sequence[int | str] | None = None,
    moments: int = 8,
    view: View = "three-quarter",
    columns: int = 3,
    ax: Axes | None = None,
) -> Axes:
    """Each path as a strip of poses that lighten as it evolves, time running right, with its label (§3.5).

    The traversal shown is the one of median length. A path that was never seen is shown by its mirror image, mirrored; if that
    was not seen either it is left out.

    Parameters
    ----------
    motions : of the sources of the graph, one each.
    paths : ids or labels; all without.
    moments : poses in a strip.
    columns : strips side by side.
    ax : where to draw; a new figure without.

    Raises
    ------
    InputError
        If there are not as many motions as sources, a path is unknown, or ``moments`` or ``columns`` is less than 1.
    """
    _check_motions(graph, motions)
    if moments < 1 or columns < 1:
        raise InputError(f"Expected moments and columns of at least 1, got {moments} and {columns}.")
    wanted = [graph.path(p) for p in paths] if paths is not None else list(graph.paths)
    shown = [(p, o, image) for p in wanted for o, image in [_typical(graph, p)] if o is not None]
    columns = min(columns, max(1, len(shown)))
    rows = max(1, -(-len(shown) // columns))
    if ax is None:
        ax = canvas.own_axes(3.1 * columns, 1.5 * rows, rect=(0.01, 0.01, 0.98, 0.98))
    ax.set_xlim(0.0, columns)
    ax.set_ylim(-rows, 0.0)
    ax.set_axis_off()
    pixels = canvas.pixel_size(ax)
    cell = (pixels[0] / columns, pixels[1] / rows)
    plain = _plain_labels([p.label for p in graph.paths])
    for number, (path, occurrence, image) in enumerate(shown):
        row, column = divmod(number, columns)
        twin = graph.path(path.mirror_of) if path.mirror_of not in (None, path.id) else None
        frames = np.rint(np.linspace(occurrence.start, occurrence.end - 1, moments)).astype(np.intp)
        if occurrence.reversed:
            frames = frames[::-1]
        motion = motions[occurrence.source]
        part = motion[int(frames.min()) : int(frames.max()) + 1]
        strokes = compute_strokes(mirror(part) if image else part, frames - frames.min(), view=view)
        tops = (strokes.head_centres[:, 1] + strokes.head_radius).max()
        low = float(strokes.segments[..., 1].min())
        high = max(float(strokes.segments[..., 1].max()), float(tops))
        metre = 0.72 * cell[1] / max(high - low, 0.3)
        across, up = metre / cell[0], metre / cell[1]
        wide = float(np.abs(strokes.segments[..., 0]).max()) * across
        left, right = 0.02 + min(wide, 0.3), 0.98 - min(wide, 0.3)
        places = np.linspace(left, right, moments) if moments > 1 else np.array([0.5 * (left + right)])
        width = float(np.clip(0.01 * cell[1] * 72.0 / ax.figure.dpi, 0.6, 2.0))
        for k in reversed(range(moments)):
            strength = 1.0 - 0.78 * k / max(1, moments - 1)
            spot = (column + float(places[k]), -row - 0.95 - low * up)
            draw_strokes(ax, strokes, k, spot, (across, up), strength, width, grey=True)
        # what is said stands above the figures, where they cannot reach
        size = float(np.clip(0.12 * cell[1] * 72.0 / ax.figure.dpi, 6.0, 13.0))
        line: dict[str, Any] = {"ha": "left", "va": "center_baseline"}
        text = label_text(path.label, index=path.label not in plain)
        arrow = "↔" if path.reversible else "→"
        ax.text(column + 0.02, -row - 0.11, text, fontsize=size, style="italic", color=canvas.INK, **line)
        beside = column + 0.04 + 2.0 * _half_size(text, size * ax.figure.dpi / 72.0 / cell[0])[0]
        taken = f"{len(path.occurrences)}×" if path.occurrences else "mirrored"
        if path.occurrences and twin is not None and twin.occurrences:
            taken += f" and {len(twin.occurrences)}× mirrored"
        remark = f"{arrow}  {(occurrence.end - occurrence.start) / motion.fps:.1f} s, {taken}"
        ax.text(beside, -row - 0.11, remark, fontsize=0.7 * size, color=canvas.FAINT, **line)
    if not shown:
        ax.text(0.5, -0.5, "no paths", ha="center", va="center", color=canvas.FAINT)
    return ax


def state_margin(
    ax: Axes,
    graph: MotionGraph,
    *,
    source: int = 0,
    fps: float | None = None,
    begin: float = 0.0,
    side: str = "right",
) -> Axes:
    """Labels of the states on the margin of a square Z/Z* plot, where in time they are met (§3.5).

    Labels that would touch stand in two columns; where that is not enough, those of states that are held longest are kept.

    Parameters
    ----------
    ax : what `similarity_plot` returned.
    fps : frames a second where the axes of the plot are in seconds; without they count frames.
    begin : where on the axis the source begins: not at 0 where several stand one after another.
    side : "right" or "top".

    Raises
    ------
    InputError
        If there is no such source, or ``side`` is neither.
    """
    if side not in ("right", "top"):
        raise InputError(f"Expected side 'right' or 'top', got '{side}'.")
    met: dict[tuple[int, float], float] = {}
    for step in graph.timeline(source):
        enters, leaves = ends_of(graph, step)
        if step.path is None:
            met[enters, 0.5 * (step.start + step.end)] = float(step.end - step.start)
            continue
        if step.complete or step.start > 0:
            met.setdefault((enters, float(step.start)), 0.0)
        if step.complete or step.start == 0:
            met.setdefault((leaves, float(step.end)), 0.0)
    held = [(s, stay.start, stay.end) for s in graph.states for stay in s.stays if stay.source == source]
    unit = 1.0 / fps if fps else 1.0
    pixels = canvas.pixel_size(ax)[0 if side == "top" else 1]
    low, high = sorted(ax.get_xlim() if side == "top" else ax.get_ylim())
    room = 9.5 * ax.figure.dpi / 72.0 * (high - low) / pixels
    # two columns: what does not fit into the first stands in the second
    columns = (1.01, 1.045)
    along = 1 if side == "right" else 0
    # labels of other sources on the same margin keep their places
    taken = tuple(
        [float(t.get_position()[along]) for t in ax.texts if t.get_position()[1 - along] == column]
        for column in columns
    )
    for (state, moment), length in sorted(met.items(), key=lambda item: (-item[1], item[0][1])):
        # a state entered or left where it is held is shown once, in the middle
        if length == 0.0 and any(s.id == state and a <= moment <= b for s, a, b in held):
            continue
        place = begin + moment * unit
        free = [column for column in taken if all(abs(place - t) >= room for t in column)]
        if not free:
            continue
        free[0].append(place)
        offset = columns[0] if free[0] is taken[0] else columns[1]
        text = label_text(graph.state(state).label)
        if side == "right":
            where, transform, align = (offset, place), ax.get_yaxis_transform(), ("left", "center")
        else:
            where, transform, align = (place, offset), ax.get_xaxis_transform(), ("center", "bottom")
        ax.text(*where, text, transform=transform, ha=align[0], va=align[1], fontsize=9, style="italic")
    return ax


def label_text(label: str, *, index: bool = True) -> str:
    """A label as it is drawn, in italics: plain text, or mathtext where a bar goes over more than a letter.

    Mathtext looks the same and takes ten times as long.

    Parameters
    ----------
    index : False leaves the index out, as the dissertation does where there is only one such path.
    """
    if barred := _BARRED.fullmatch(label):
        return barred["letter"] + "\N{COMBINING OVERLINE}" + barred["number"].translate(_SUBSCRIPTS)
    image = label.startswith("(")
    letters = _LETTERS.fullmatch(label[1:-2] if image else label)
    if letters is None:
        return notation.mathtext(label, index=index)
    core = letters["first"] + (letters["second"] or "") + ((letters["index"] or "") if index else "")
    return f"({core}){notation.MIRROR}".translate(_SUBSCRIPTS) if image else core.translate(_SUBSCRIPTS)


# what is drawn


def _shown(graph: MotionGraph, condensed: bool) -> tuple[list[State], list[_Arrow]]:
    if not condensed:
        return list(graph.states), [
            _Arrow(
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
        _Arrow(e.from_, e.to, e.label, e.both_ways, e.inferred, e.label.startswith("("), notation.BAR in e.label, k)
        for k, e in enumerate(short.edges)
    ]


def _side(state: State) -> int:
    return 0 if state.symmetric else 1 if state.label.endswith(notation.MIRROR) else -1


def _orbit(state: State) -> int:
    return state.id if state.mirror_of is None else min(state.id, state.mirror_of)


def _index_pairs(states: Sequence[State], arrows: Sequence[_Arrow]) -> list[tuple[int, int]]:
    place = {s.id: k for k, s in enumerate(states)}
    return [(place[a.from_], place[a.to]) for a in arrows]


def _plain_labels(labels: Sequence[str]) -> set[str]:
    """Labels whose index says nothing, because no other path is named so, nor of their mirror images."""

    def base(label: str) -> str:
        return label.removeprefix("(").removesuffix(")*").rpartition("_")[0]

    often = Counter((base(label), label.startswith("(")) for label in labels)
    return {label for label in labels if max(often[base(label), image] for image in (False, True)) == 1}


# curves


def _curves(
    states: Sequence[State], arrows: Sequence[_Arrow], where: Mapping[int, Array], radius: float
) -> list[_Curve]:
    rank = {s.id: (_orbit(s), _side(s)) for s in states}
    groups: dict[tuple[int, int], list[_Arrow]] = {}
    for arrow in arrows:
        first, second = sorted((arrow.from_, arrow.to), key=lambda s: rank[s])
        groups.setdefault((first, second), []).append(arrow)
    everyone = np.array(list(where.values())).reshape(-1, 2)
    curves: list[_Curve] = []
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
            curves.append(_Curve(member, curve if member.from_ == first else curve[::-1]))
    for state in states:
        loops = groups.get((state.id, state.id), [])
        here = where[state.id]
        angles = _directions(curves, state.id, here, everyone, radius)
        preferred = {-1: np.pi, 1: 0.0, 0: 0.5 * np.pi}[_side(state)]
        for loop in sorted(loops, key=lambda m: m.index):
            angle = widest_gap(angles, preferred)
            angles += [angle - 0.5, angle, angle + 0.5]
            curves.append(_Curve(loop, _loop(here, angle, radius)))
    return curves


def _order(arrow: _Arrow) -> int:
    return 0 if arrow.symmetric else 1 if arrow.starred else -1


def _normal(a: Array, b: Array) -> Array:
    """Unit normal of a pair of states; of the mirrored pair it is the mirrored one, of a pair on the axis it points right."""
    along = (b - a) / np.linalg.norm(b - a)
    normal = np.array([-along[1], along[0]])
    if a[0] == 0.0 and b[0] == 0.0:
        return np.asarray(normal * np.sign(normal[0]))
    on_the_left = a[0] < 0.0 or (a[0] == 0.0 and b[0] < 0.0)
    return np.asarray(normal if on_the_left else -normal)


def _offsets(members: Sequence[_Arrow], *, central: bool) -> list[float]:
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


def _directions(curves: Sequence[_Curve], state: int, here: Array, everyone: Array, radius: float) -> list[float]:
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


def _extent(points: Array, curves: Sequence[_Curve], radius: float) -> tuple[Array, Array]:
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


# ink


def _draw_curve(ax: Axes, curve: _Curve, line: float, head: float) -> None:
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
    curves: Sequence[_Curve],
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
            _draw_figure(ax, *figures[state.id], (x, y), radius, view, cell)
        angles = _directions(curves, state.id, where[state.id], everyone, radius)
        preferred = 1.25 * np.pi if _side(state) <= 0 else 1.75 * np.pi
        angle = widest_gap(angles, preferred)
        spot = np.array([x + (radius + 0.11) * np.cos(angle), y + (radius + 0.11) * np.sin(angle)])
        boxes.append((spot, _half_size(text, 0.8 * size / cell)))
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
    return boxes


def _draw_figure(
    ax: Axes, motion: Motion, frame: int, centre: tuple[float, float], radius: float, view: View, cell: float
) -> None:
    strokes = compute_strokes(motion, [frame], view=view)
    points = strokes.segments[0].reshape(-1, 2)
    top = max(float(points[:, 1].max()), float(strokes.head_centres[0, 1] + strokes.head_radius))
    low, high = points.min(axis=0), np.array([points[:, 0].max(), top])
    scale = 1.62 * radius / max(float(np.hypot(*(high - low))), 1.2)
    middle = 0.5 * (low + high) * scale
    origin = (centre[0] - float(middle[0]), centre[1] - float(middle[1]))
    draw_strokes(ax, strokes, 0, origin, scale, 1.0, float(np.clip(cell / 75.0, 0.5, 2.2)))


def _draw_labels(
    ax: Axes,
    curves: Sequence[_Curve],
    points: Array,
    radius: float,
    cell: float,
    head: float,
    named: Sequence[tuple[Array, tuple[float, float]]],
) -> None:
    """Each label on its own arrow, at the place where it hides least."""
    size = float(np.clip((0.135 if len(points) <= 30 else 0.115) * cell, 3.6, 14.0))
    plain = _plain_labels([c.arrow.label for c in curves])
    lines = [c.points for c in curves]
    boxes = list(named)
    for number, curve in enumerate(curves):
        index = curve.arrow.label not in plain
        text = label_text(curve.arrow.label, index=index)
        half = _half_size(text, size / cell)
        others = np.concatenate([np.zeros((0, 2)), *(p for k, p in enumerate(lines) if k != number)])
        best, least = curve.points[len(curve.points) // 2], np.inf
        for spot, cost in _label_places(curve, half, head):
            cost += float(_inside(points, spot, (half[0] + 0.85 * radius, half[1] + 0.85 * radius)).sum())
            cost += 0.12 * min(float(_inside(others, spot, half).sum()), 8.0)
            for centre, size_there in boxes:
                both = (half[0] + size_there[0], half[1] + size_there[1])
                cost += 3.0 * float(_inside(centre[None], spot, both).sum())
            if cost < least:
                best, least = spot, cost
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


def _label_places(curve: _Curve, half: tuple[float, float], head: float) -> list[tuple[Array, float]]:
    """Where the label of an arrow may stand, and how much less good than on its middle that is.

    On the line, where that leaves enough of it to be seen; beside it otherwise; outside a loop.
    """
    points = curve.points
    count = len(points)
    if curve.arrow.from_ == curve.arrow.to:
        apex = points[count // 2]
        outward = apex - 0.5 * (points[0] + points[-1])
        outward /= max(float(np.linalg.norm(outward)), 1e-9)
        reach = abs(outward[0]) * half[0] + abs(outward[1]) * half[1]
        return [(apex + outward * (reach + 0.03), 0.0)]
    length = float(np.hypot(*np.diff(points, axis=0).T).sum()) - head * (1 + curve.arrow.both_ways)
    out: list[tuple[Array, float]] = []
    for at in (0.5, 0.42, 0.58, 0.34, 0.66, 0.27, 0.73):
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
    return out


def _half_size(text: str, size: float) -> tuple[float, float]:
    """Half of the width and of the height of a text as long as ``size`` is high, with a little room."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    box = TextPath((0.0, 0.0), text, size=20.0, prop=FontProperties(style="italic")).get_extents()
    return (0.5 * box.width / 20.0 + 0.08) * size, (0.5 * box.height / 20.0 + 0.08) * size


def _inside(points: Array, centre: Array, half: tuple[float, float]) -> NDArray[np.bool_]:
    return np.asarray((np.abs(points - centre) < np.asarray(half)).all(axis=1))


# moments


def _typical(graph: MotionGraph, path: Path) -> tuple[Occurrence | None, bool]:
    """The traversal of median length, forwards and complete where there is one; and whether it is the mirror image's."""
    image = graph.path(path.mirror_of) if path.mirror_of is not None else None
    for candidate, mirrored in ((path, False), (image, True)):
        if candidate is None or not candidate.occurrences:
            continue
        good = [o for o in candidate.occurrences if o.complete] or list(candidate.occurrences)
        forwards = [o for o in good if not o.reversed] or good
        ordered = sorted(forwards, key=lambda o: o.end - o.start)
        return ordered[len(ordered) // 2], mirrored
    return None, False


def _check_motions(graph: MotionGraph, motions: Sequence[Motion]) -> None:
    if len(motions) != len(graph.sources):
        raise InputError(f"Expected one motion for each of the {len(graph.sources)} sources, got {len(motions)}.")
    for number, (source, motion) in enumerate(zip(graph.sources, motions, strict=True)):
        if motion.frame_count != source.frames:
            raise InputError(
                f"Source {number} '{source.name}' has {source.frames} frames, the motion given for it {motion.frame_count}."
            )
