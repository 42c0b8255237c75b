"""The pictures of one analysis, in sheets that do not need each other: two processes can draw them (`kinesics.report.helper`)."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable, MutableMapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol

import numpy as np

from kinesics.analysis import Analysis
from kinesics.analysis.analysis import joined
from kinesics.analysis.symmetric_states import SYMMETRY_THRESHOLD
from kinesics.body.pose import PoseSequence
from kinesics.errors import InputError
from kinesics.plotting import (
    composite_plot,
    figures_beneath,
    graph_plot,
    motif_plot,
    new_figure,
    path_strips,
    pooled_similarity,
    similarity_plot,
    similarity_triangle,
    speed_plot,
    state_margin,
    state_moments,
    symmetry_plot,
)
from kinesics.plotting.canvas import FAINT, INK, figure_bytes
from kinesics.plotting.palettes import PALETTES
from kinesics.plotting.similarity_plots import colour_key
from kinesics.progress import Progress, silent
from kinesics.report import words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from kinesics.grammar.graph import MotionGraph

_DPI: Final = 150
_MOST_FIGURES: Final = 80
"""States that are drawn with a figure each."""
MOST_STRIPS: Final = 48
"""Paths that are drawn as strips; mirror images share one."""
MOST_MOTIFS: Final = 8
_KINDS: Final = (
    "#9ecae1",
    "#fdd0a2",
    "#c7e9c0",
    "#dadaeb",
    "#f4b6c2",
    "#d9c7a8",
    "#b5e0d8",
    "#e8e39a",
    "#c5cfe8",
    "#e3c4e0",
)
"""Of phrases; light enough for black letters."""
_STROKES: Final = ("//", "\\\\", "..", "||", "--", "oo")
"""Hatchings of matplotlib that can be told apart, also one over another."""
_PIXELS: Final = 1200
"""Width of the axes of both similarity pictures: one pixel of the pooled matrices is one pixel of the picture."""


class Pictures(NamedTuple):
    """Files' contents."""

    square: bytes
    """PNG."""
    triangle: bytes
    """PNG."""
    graph: bytes
    """SVG: the motion graph; the path of the body in the symmetry basis where no graph was read."""
    path: bytes
    """SVG, the path of the body in the symmetry basis."""
    strips: bytes | None
    """SVG, the paths of the graph as strips of poses (`strip_paths`); None where there are none."""
    phrases: tuple[tuple[int, bytes], ...]
    """The source's number and SVG, the phrases over time, for each source that has some."""
    motifs: bytes | None
    """SVG, what recurs, as figures and over time; None where nothing does."""
    curves: tuple[bytes, ...]
    """SVG, speed and symmetry over time, one for each source."""


def check_palette(palette: str) -> None:
    """Refuse a palette that cannot show Z and Z* together.

    Raises
    ------
    InputError
        If there is none of that name, or it has one colour for both.
    """
    useful = [name for name, p in PALETTES.items() if p.z != p.z_mirror]
    if palette not in useful:
        why = "has one colour for Z and Z*" if palette in PALETTES else "is not known"
        raise InputError(f"The palette '{palette}' {why}. Palettes of a report: {', '.join(useful)}.")


class Sheet(NamedTuple):
    """One piece of the drawing, which needs none of the others: they can be drawn in any order, in several processes."""

    what: str
    """As in `_SHEETS`."""
    source: int = 0
    """Of the phrases and curves."""


class Hand(Protocol):
    """Somebody who draws along."""

    def draw(
        self,
        analysis: Analysis,
        palette: str,
        waiting: deque[Sheet],
        drawn: MutableMapping[Sheet, tuple[bytes, ...]],
    ) -> None:
        """Begin to take sheets from ``waiting`` and to put them into ``drawn``."""
        ...

    def wait(self) -> bool:
        """Wait until the last sheet is drawn; whether one has come back undrawn, to ``waiting``."""
        ...


def draw(
    analysis: Analysis, *, palette: str = "thesis", progress: Progress | None = None, helper: Hand | None = None
) -> Pictures:
    """All pictures of an analysis that still has its motions and poses.

    Parameters
    ----------
    palette : the colours of Z and Z*, see `kinesics.plotting.palettes`.
    helper : somebody who draws along, as a second process (`kinesics.report.helper`); the pictures are the same without.

    Raises
    ------
    InputError
        If there is no such palette, or it has one colour for both.
    """
    check_palette(palette)
    report = progress or silent
    waiting = deque(sheets(analysis))
    # most of a long recording's time goes into all its pairs
    worth = {sheet: len(waiting) if sheet.what == "pairs" else 1 for sheet in waiting}
    drawn: dict[Sheet, tuple[bytes, ...]] = {}

    def done(sheet: Sheet, fraction: float) -> None:
        share = sum(worth[s] for s in tuple(drawn)) + fraction * worth[sheet]
        report(min(1.0, share / sum(worth.values())), f"drawing {_SHEETS[sheet.what].name}")

    if helper is not None:
        helper.draw(analysis, palette, waiting, drawn)
        # that loads the library, which takes a while: the other process, if it is ready, begins with what takes longest
        new_figure(1.0, 1.0)
    while waiting or (helper is not None and helper.wait()):
        try:
            sheet = waiting.popleft()
        except IndexError:
            # the helper was quicker
            continue
        drawn[sheet] = draw_sheet(analysis, sheet, palette, lambda f, _="", s=sheet: done(s, f))

    def all_of(what: str) -> list[tuple[int, bytes]]:
        return [(sheet.source, files[0]) for sheet, files in sorted(drawn.items()) if sheet.what == what]

    def one_of(what: str) -> bytes | None:
        return next((file for _, file in all_of(what)), None)

    square, triangle = drawn[Sheet("pairs")]
    path = drawn[Sheet("path")][0]
    curves = tuple(file for _, file in all_of("curves"))
    result = Pictures(
        square,
        triangle,
        one_of("graph") or path,
        path,
        one_of("strips"),
        tuple(all_of("phrases")),
        one_of("motifs"),
        curves,
    )
    report(1.0, "pictures drawn")
    return result


def warm_up() -> None:
    """Load what drawing needs: libraries and fonts."""
    figure, ax = _page(100, 100, left=50, right=50, bottom=50, top=50)
    ax.set_xlabel("time $t_i$ (s)")
    _caption(figure, "name", "key")
    for suffix in (".png", ".svg"):
        figure_bytes(figure, suffix)


def sheets(analysis: Analysis) -> list[Sheet]:
    """All that is to be drawn of an analysis, what takes longest first."""
    graph = analysis.graph
    out = [Sheet("pairs")]
    if graph.states:
        out.append(Sheet("graph"))
    if strip_paths(graph)[0]:
        out.append(Sheet("strips"))
    if analysis.motifs:
        out.append(Sheet("motifs"))
    out.append(Sheet("path"))
    for number in range(len(analysis.sources)):
        out.append(Sheet("curves", number))
        if any(p.source == number for p in analysis.phrases):
            out.append(Sheet("phrases", number))
    return out


def draw_sheet(analysis: Analysis, sheet: Sheet, palette: str, progress: Progress | None = None) -> tuple[bytes, ...]:
    """The files' contents: two of "pairs", the square and the triangle, one of all others."""
    report = progress or silent
    report(0.0)
    return _SHEETS[sheet.what].draw(analysis, sheet.source, palette, report)


def _draw_pairs(analysis: Analysis, _: int, palette: str, progress: Progress) -> tuple[bytes, ...]:
    """The square and the triangle: the poses are compared once for both."""
    poses, borders = _common_time(analysis)
    pooled = pooled_similarity(
        poses,
        size=_PIXELS,
        beta=analysis.beta,
        weights=analysis.parameters.get("weights"),
        progress=lambda fraction, _="": progress(0.9 * fraction),
    )
    # several are named over their blocks
    name = analysis.sources[0].name if len(analysis.sources) == 1 else ""
    key = colour_key(palette)

    square, ax = _page(_PIXELS, _PIXELS, left=130, right=45, bottom=150, top=85)
    similarity_plot(pooled, palette=palette, ax=ax)
    _borders(ax, borders, len(poses) / poses.fps, triangle=False)
    read = analysis.graph
    begins = [0.0, *borders]
    if read.states:
        for number, begin in enumerate(begins):
            state_margin(ax, read, source=number, fps=read.sources[number].fps, begin=begin)
    _name_blocks(ax, analysis, [*begins, len(poses) / poses.fps])
    _caption(square, name, key)
    square_file = figure_bytes(square, ".png")

    triangle, ax = _page(_PIXELS, _PIXELS // 2, left=130, right=45, bottom=345 + 40 * bool(borders), top=85)
    similarity_triangle(pooled, palette=palette, ax=ax)
    figures_beneath(ax, analysis.motions)
    _borders(ax, borders, len(poses) / poses.fps, triangle=True)
    _name_blocks(ax, analysis, [*begins, len(poses) / poses.fps], height=-0.49)
    _caption(triangle, name, key + "; figures: a pose and, paler, the pose 1/6 s later")
    return square_file, figure_bytes(triangle, ".png")


def _draw_path(analysis: Analysis, _: int, __: str, ___: Progress) -> tuple[bytes, ...]:
    symmetric = [(r.start, r.end) for r in analysis.symmetric_states] if len(analysis.sources) == 1 else []
    path, ax = _page(720, 670, left=120, right=35, bottom=100, top=75)
    composite_plot(_common_time(analysis)[0], symmetric=symmetric, ax=ax)
    return (figure_bytes(path, ".svg"),)


def _draw_graph(analysis: Analysis, _: int, __: str, ___: Progress) -> tuple[bytes, ...]:
    read = analysis.graph
    figures = state_moments(read, analysis.motions) if len(read.states) <= _MOST_FIGURES else None
    return (figure_bytes(_figure(graph_plot(read, figures=figures)), ".svg"),)


def _draw_strips(analysis: Analysis, _: int, __: str, ___: Progress) -> tuple[bytes, ...]:
    shown = strip_paths(analysis.graph)[0]
    return (figure_bytes(_figure(path_strips(analysis.graph, analysis.motions, paths=shown, moments=7)), ".svg"),)


def _draw_motifs(analysis: Analysis, _: int, palette: str, __: Progress) -> tuple[bytes, ...]:
    ax = motif_plot(analysis.motifs, analysis.motions, palette=palette, most=MOST_MOTIFS)
    return (figure_bytes(_figure(ax), ".svg"),)


def _draw_curves(analysis: Analysis, source: int, _: str, __: Progress) -> tuple[bytes, ...]:
    return (figure_bytes(_curves(analysis, source), ".svg"),)


def _draw_phrases(analysis: Analysis, source: int, _: str, __: Progress) -> tuple[bytes, ...]:
    return (figure_bytes(_phrases(analysis, source), ".svg"),)


class _Kind(NamedTuple):
    name: str
    """For people who wait."""
    draw: Callable[[Analysis, int, str, Progress], tuple[bytes, ...]]


_SHEETS: Final = {
    "pairs": _Kind("all pairs of moments", _draw_pairs),
    "graph": _Kind("the motion graph", _draw_graph),
    "strips": _Kind("the paths", _draw_strips),
    "motifs": _Kind("what recurs", _draw_motifs),
    "path": _Kind("the path of the body", _draw_path),
    "curves": _Kind("the curves", _draw_curves),
    "phrases": _Kind("the phrases", _draw_phrases),
}


def strip_paths(graph: MotionGraph) -> tuple[list[int], int]:
    """Ids of the paths that are drawn as strips, in the order of the graph, and how many more there are.

    Of two mirror images the one that was performed more often stands for both; beyond `MOST_STRIPS` the most frequent are kept.
    """
    often = {p.id: len(p.occurrences) for p in graph.paths}
    chosen: dict[int, int] = {}
    for path in graph.paths:
        twin = path.id if path.mirror_of is None else path.mirror_of
        one = max((path.id, twin), key=lambda k: (often[k], -k))
        if often[one]:
            chosen.setdefault(min(path.id, twin), one)
    together: dict[int, int] = dict.fromkeys(chosen, 0)
    for path in graph.paths:
        orbit = path.id if path.mirror_of is None else min(path.id, path.mirror_of)
        if orbit in together:
            together[orbit] += often[path.id]
    kept = sorted(chosen, key=lambda orbit: -together[orbit])[:MOST_STRIPS]
    return sorted(chosen[orbit] for orbit in kept), len(chosen) - len(kept)


def _common_time(analysis: Analysis) -> tuple[PoseSequence, list[float]]:
    """All poses one after another on one time axis, and the times in seconds at which a new source begins.

    Where frame rates differ, frames of the slower recordings are repeated: none is dropped.
    """
    rate = max(p.fps for p in analysis.poses)
    shown = []
    for poses in analysis.poses:
        count = max(len(poses), round(len(poses) * rate / poses.fps))
        index = (np.arange(count) * len(poses)) // count
        shown.append(poses if count == len(poses) else _take(poses, index, rate))
    ends = np.cumsum([len(p) for p in shown]) / rate
    return joined(shown), [float(t) for t in ends[:-1]]


def _take(poses: PoseSequence, index: np.ndarray[tuple[int, ...], np.dtype[np.intp]], fps: float) -> PoseSequence:
    return dataclasses.replace(
        poses,
        quaternions=poses.quaternions[index],
        yaw=poses.yaw[index],
        ground=poses.ground[index],
        yaw_undefined=None,
        fps=fps,
    )


def _figure(ax: Axes) -> Figure:
    figure = ax.get_figure(root=True)
    assert figure is not None
    return figure


def _page(width: int, height: int, *, left: int, right: int, bottom: int, top: int) -> tuple[Figure, Axes]:
    """A figure whose axes are exactly width × height pixels."""
    full, tall = width + left + right, height + bottom + top
    figure = new_figure(full / _DPI, tall / _DPI, dpi=_DPI)
    return figure, figure.add_axes((left / full, bottom / tall, width / full, height / tall))


def _caption(figure: Figure, name: str, key: str) -> None:
    """What the colours mean, and which recording it is."""
    pixels = figure.get_size_inches() * figure.dpi
    figure.text(130 / pixels[0], 18 / pixels[1], key, fontsize=10, color=INK, va="bottom")
    if name:
        shown = name if len(name) <= 60 else name[:59] + "…"
        # a file may be called "a$b$c": its name is no formula
        figure.text(
            1.0 - 45 / pixels[0],
            1.0 - 40 / pixels[1],
            shown,
            fontsize=10,
            color=FAINT,
            ha="right",
            va="bottom",
            parse_math=False,
        )


def _name_blocks(ax: Axes, analysis: Analysis, borders: list[float], *, height: float = 1.008) -> None:
    """The recordings' names over (or under) their stretches of the time axis, where there are several."""
    if len(borders) < 3:
        return
    if height > 1.0:
        ax.set_title(ax.get_title(), fontsize=12, color=INK, pad=22, y=1.0)
    # some 10 pixels a letter
    letters = _PIXELS / borders[-1] / 10.0
    for name, start, end in zip(words.source_names(analysis), borders, borders[1:], strict=False):
        room = int((end - start) * letters)
        shown = name if len(name) <= room else name[: max(0, room - 1)] + "…" if room > 2 else ""
        style: dict[str, Any] = {"ha": "center", "va": "bottom" if height > 1.0 else "top", "fontsize": 9, "color": INK}
        where = ax.get_xaxis_transform()
        ax.text(0.5 * (start + end), height, shown, transform=where, parse_math=False, **style)


def _borders(ax: Axes, borders: list[float], length: float, *, triangle: bool) -> None:
    """Where one recording ends and the next begins."""
    for t in borders:
        if triangle:
            ax.plot([t / 2.0, t, (t + length) / 2.0], [t, 0.0, length - t], color="white", linewidth=0.8)
        else:
            ax.axvline(t, color="white", linewidth=0.8)
            ax.axhline(t, color="white", linewidth=0.8)


def look_of(kind: int) -> tuple[str, str]:
    """Colour and hatching of the phrases of a kind, the same for no two: ten colours plain, the ten hatched, and so on."""
    turn, colour = divmod(kind, len(_KINDS))
    if not turn:
        return _KINDS[colour], ""
    # hatchings and what they make together, as bits of a number; when all were had, denser
    density, hatching = divmod(turn - 1, 2 ** len(_STROKES) - 1)
    chosen = [stroke for bit, stroke in enumerate(_STROKES) if (hatching + 1) >> bit & 1]
    return _KINDS[colour], "".join(chosen) * (density + 1)


def _phrases(analysis: Analysis, source: int) -> Figure:
    """The phrases over time, coloured by kind; their numbers above, a mark where each cycle begins."""
    figure = new_figure(9.6, 1.1, dpi=100)
    ax = figure.add_axes((0.085, 0.38, 0.9, 0.43))
    known = analysis.sources[source]
    pixels = 860.0 / known.duration_s
    free = -np.inf
    for number, phrase in enumerate(analysis.phrases):
        if phrase.source != source:
            continue
        still = phrase.class_ == "still"
        colour, hatch = ("#e6e6e6", "") if still else look_of(phrase.kind or 0)
        ax.axvspan(phrase.start_s, phrase.end_s, facecolor=colour, edgecolor=FAINT, hatch=hatch, linewidth=0)
        ax.axvline(phrase.end_s, color="white", linewidth=1.2)
        begins = [c.start / known.fps for c in analysis.cycles if c.phrase == number]
        ax.vlines(begins, 0.0, 0.28, color=INK, linewidth=0.7)
        kind = words.kind(phrase)
        told = ["rest"] if still else [f"{kind}  {phrase.group}" if phrase.group else kind, kind]
        # some 7 pixels a letter
        room = (phrase.end_s - phrase.start_s) * pixels / 7
        said = next((t for t in told if len(t) < room), None)
        middle = 0.5 * (phrase.start_s + phrase.end_s)
        if said is not None:
            # strokes through letters would be letters
            beneath = {"facecolor": colour, "edgecolor": "none", "pad": 1.0} if hatch else None
            ax.text(middle, 0.62, said, ha="center", va="center", fontsize=8, color=INK, bbox=beneath, parse_math=False)
        above = str(number + 1)
        wide = 3.5 * len(above) + 1.5
        if middle * pixels - wide > free:
            ax.text(middle, 1.06, above, ha="center", va="bottom", fontsize=7, color="#666666")
            free = middle * pixels + wide
    for height, row in ((1.14, "phrase"), (0.62, "kind")):
        ax.text(-0.008, height, row, transform=ax.transAxes, ha="right", va="center", fontsize=7, color="#666666")
    ax.set_xlim(0.0, known.duration_s)
    ax.set_ylim(0.0, 1.0)
    ax.set_yticks([])
    ax.set_xlabel("time (s)", fontsize=8)
    ax.tick_params(labelsize=8)
    for side in ("left", "right", "top"):
        ax.spines[side].set_visible(False)
    return figure


def _curves(analysis: Analysis, source: int) -> Figure:
    """Speed above, symmetry below, on one time axis."""
    figure = new_figure(9.6, 4.6, dpi=100)
    above, below = figure.add_axes((0.085, 0.6, 0.9, 0.32)), figure.add_axes((0.085, 0.115, 0.9, 0.32))
    fps = analysis.sources[source].fps
    still = [(r.start, r.end) for r in analysis.stillness if r.source == source]
    symmetric = [(r.start, r.end) for r in analysis.symmetric_states if r.source == source]
    speed_plot(
        analysis.speed_curves[source], fps, stillness=still, title="Speed of the pose; still where shaded", ax=above
    )
    above.set_xlabel("")
    symmetry_plot(
        analysis.mirror_distance_curves[source],
        fps,
        threshold=SYMMETRY_THRESHOLD,
        symmetric=symmetric,
        title="Distance of the pose from its own mirror image; symmetric where shaded",
        ax=below,
    )
    return figure
