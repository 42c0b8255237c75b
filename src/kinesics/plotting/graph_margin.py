"""The states of a motion graph on the margin of the plot that they were read from."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kinesics.errors import InputError
from kinesics.grammar.graph import MotionGraph, ends_of
from kinesics.plotting import canvas
from kinesics.plotting.graph_labels import label_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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
