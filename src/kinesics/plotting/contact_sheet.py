"""A contact sheet: a movement in rows of stick figures over time, as strips of film are laid out to be looked through."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.plotting import canvas
from kinesics.plotting.stick_figures import Placed, Strokes, View, compute_strokes, draw_figures

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from kinesics.body.motion import Motion

MIRRORED: Final = "#00a7b5"
"""Cyan, as Z* is (§3.4), dark enough for white paper."""
MIRRORED_SHADE: Final = "#dff5f6"
CUT: Final = "#d9822b"

_GAP: Final = 0.72
"""Metres of paper between two figures."""
_ROW: Final = 2.15
"""Metres of paper from floor to floor."""
_EDGE: Final = 0.04
"""Metres of paper beyond the outermost figure: half a stroke."""
_ACROSS: Final = 16
"""Figures in a row, if nothing else is said."""
_ROWS: Final = 4
"""Rows at most, if nothing else is said."""
_STEPS: Final = (0.2, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0)


def contact_sheet(
    motion: Motion,
    *,
    transitions: ArrayLike = (),
    mirrored: Iterable[tuple[int, int]] = (),
    every: float | None = None,
    across: int = _ACROSS,
    view: View = "three-quarter",
    title: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Rows of stick figures over time, on the floor; transitions marked, mirrored passages in cyan.

    Every figure is turned to face one way and stands on its own spot; left limbs red, right limbs blue.

    Parameters
    ----------
    transitions : frames at which one recording is left for another place, shape (n,): orange marks on the floor line.
    mirrored : ranges [start, end) of frames that play a mirror image.
    every : seconds between figures; chosen for at most four rows unless given.
    across : figures in a row.
    ax : where to draw; a new figure without.

    Raises
    ------
    InputError
        If ``every`` or ``across`` is not positive, a frame does not exist, or the sheet would hold over 2000 figures.
    """
    if every is not None and not (np.isfinite(every) and every > 0.0):
        raise InputError(f"Expected `every` above 0 seconds, got {every}.")
    if across < 1:
        raise InputError(f"Expected one figure or more `across`, got {across}.")
    cuts = np.asarray(transitions, dtype=np.float64).reshape(-1)
    ranges = [(int(a), int(b)) for a, b in mirrored]
    for frame in (*cuts.tolist(), *(f for pair in ranges for f in pair)):
        if not 0 <= frame <= motion.frame_count:
            raise InputError(f"No frame {frame:g} in a motion of {motion.frame_count} frames.")
    step = every
    if step is None:
        step = next((s for s in _STEPS if motion.duration / s <= across * _ROWS), _STEPS[-1])
    times = np.arange(0.0, motion.duration - 1e-9, step)
    if len(times) > 2000:
        raise InputError(f"A figure every {step:g} s would make {len(times)} figures; give a larger `every`.")
    rows = -(-len(times) // across)
    columns = min(across, len(times))
    frames = np.minimum(np.round(times * motion.fps).astype(int), motion.frame_count - 1)
    strokes = compute_strokes(motion, frames, view=view)
    ground = float(motion.positions()[:, :, 1].min())
    spots = np.array([(k % across * _GAP, (rows - 1 - k // across) * _ROW - ground) for k in range(len(times))])
    # a figure may be wider than its share of the paper, and higher
    least, most = _extent(strokes, spots)
    low = (min(-0.5 * _GAP, least[0] - _EDGE), min(-0.42, least[1] - _EDGE))
    high = (max((columns - 0.5) * _GAP, most[0] + _EDGE), max(rows * _ROW, most[1] + _EDGE))
    if ax is None:
        width = 0.66 / _GAP * max(high[0] - low[0], 6.0 * _GAP)
        height = width * (high[1] - low[1]) / (high[0] - low[0])
        # inches to the left for the times, above for the title
        paper = (width + 0.65, height + 0.5)
        ax = canvas.own_axes(*paper, rect=(0.55 / paper[0], 0.05 / paper[1], width / paper[0], height / paper[1]))
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal")
    metre = canvas.pixel_size(ax)[0] / (high[0] - low[0]) * 72.0 / ax.figure.dpi
    line_width = float(np.clip(0.024 * metre, 0.5, 2.2))
    a_row = across * step
    for row in range(rows):
        floor = (rows - 1 - row) * _ROW
        start, end = row * a_row, min((row + 1) * a_row, motion.duration)
        _floor(ax, floor, _place(0.0, step), _place(end - start, step))
        for a, b in ranges:
            t0, t1 = max(a / motion.fps, start), min(b / motion.fps, end)
            if t1 > t0:
                _mirrored(ax, floor, _place(t0 - start, step), _place(t1 - start, step))
        for cut in cuts / motion.fps:
            if start <= cut < end:
                _cut(ax, floor, _place(float(cut) - start, step))
        ax.text(low[0] - 0.06, floor, f"{start:g} s", fontsize=8, ha="right", va="center", color=canvas.INK)
    draw_figures(ax, [Placed(strokes, k, (x, y), (1.0, 1.0), line_width) for k, (x, y) in enumerate(spots.tolist())])
    ax.set_axis_off()
    said = (
        "Every figure "
        + f"{step:g} s later"
        + ("; orange marks: transitions" if len(cuts) else "")
        + ("; cyan: mirrored" if ranges else "")
    )
    ax.set_title(said if title is None else f"{title}   ({said})", fontsize=9.5, loc="left", color=canvas.INK)
    return ax


def _extent(strokes: Strokes, spots: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The corners of what the figures cover when each stands on its spot, shape (figures, 2): across and up, metres."""
    points = strokes.segments.reshape(len(spots), -1, 2) + spots[:, None]
    heads = strokes.head_centres + spots
    least = np.minimum(points.min(axis=(0, 1)), heads.min(axis=0) - strokes.head_radius)
    return least, np.maximum(points.max(axis=(0, 1)), heads.max(axis=0) + strokes.head_radius)


def _place(seconds: float, step: float) -> float:
    """Metres across the paper."""
    return (seconds / step) * _GAP


def _floor(ax: Axes, floor: float, left: float, right: float) -> None:
    ax.plot([left - 0.5 * _GAP, right - 0.5 * _GAP], [floor, floor], color=canvas.FAINT, linewidth=1.0, zorder=1.0)


def _mirrored(ax: Axes, floor: float, left: float, right: float) -> None:
    from matplotlib.patches import Rectangle

    # a figure stands in the middle of its time
    left, right = left - 0.5 * _GAP, right - 0.5 * _GAP
    ax.add_patch(
        Rectangle((left, floor), right - left, 0.87 * _ROW, facecolor=MIRRORED_SHADE, edgecolor="none", zorder=0.5)
    )
    ax.plot([left, right], [floor, floor], color=MIRRORED, linewidth=3.0, solid_capstyle="butt", zorder=1.1)


def _cut(ax: Axes, floor: float, place: float) -> None:
    place -= 0.5 * _GAP
    ax.plot([place, place], [floor - 0.2, floor + 0.1], color=CUT, linewidth=1.6, zorder=1.2)
