"""The motion graph in stick figures: the moment that shows each state best, and each path as a strip of its poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinesics.body.mirroring import mirror
from kinesics.errors import InputError
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, ends_of
from kinesics.plotting import canvas
from kinesics.plotting.graph_labels import half_size, label_text, plain_labels
from kinesics.plotting.stick_figures import Placed, View, draw_figures, strokes_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from kinesics.body.motion import Motion

Indices = NDArray[np.intp]
Moment = tuple["Motion", int]
"""A motion and one of its frames."""


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
    plain = plain_labels([p.label for p in graph.paths])
    figures: list[Placed] = []
    drawn = strokes_of([_moments(motions, o, image, moments) for _, o, image in shown], view=view)
    for number, ((path, occurrence, _), strokes) in enumerate(zip(shown, drawn, strict=True)):
        row, column = divmod(number, columns)
        twin = graph.path(path.mirror_of) if path.mirror_of not in (None, path.id) else None
        motion = motions[occurrence.source]
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
            figures.append(Placed(strokes, k, spot, (across, up), width, strength, grey=True))
        # what is said stands above the figures, where they cannot reach
        size = float(np.clip(0.12 * cell[1] * 72.0 / ax.figure.dpi, 6.0, 13.0))
        line: dict[str, Any] = {"ha": "left", "va": "center_baseline"}
        text = label_text(path.label, index=path.label not in plain)
        arrow = "↔" if path.reversible else "→"
        ax.text(column + 0.02, -row - 0.11, text, fontsize=size, style="italic", color=canvas.INK, **line)
        beside = column + 0.04 + 2.0 * half_size(text, size * ax.figure.dpi / 72.0 / cell[0])[0]
        taken = f"{len(path.occurrences)}×" if path.occurrences else "mirrored"
        if path.occurrences and twin is not None and twin.occurrences:
            taken += f" and {len(twin.occurrences)}× mirrored"
        remark = f"{arrow}  {(occurrence.end - occurrence.start) / motion.fps:.1f} s, {taken}"
        ax.text(beside, -row - 0.11, remark, fontsize=0.7 * size, color=canvas.FAINT, **line)
    draw_figures(ax, figures)
    if not shown:
        ax.text(0.5, -0.5, "no paths", ha="center", va="center", color=canvas.FAINT)
    return ax


def _moments(motions: Sequence[Motion], occurrence: Occurrence, image: bool, moments: int) -> tuple[Motion, Indices]:
    """The poses of a strip: of which motion, and which of its frames."""
    frames = np.rint(np.linspace(occurrence.start, occurrence.end - 1, moments)).astype(np.intp)
    if occurrence.reversed:
        frames = frames[::-1]
    motion = motions[occurrence.source]
    if not image:
        return motion, frames
    first = int(frames.min())
    return mirror(motion[first : int(frames.max()) + 1]), frames - first


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
