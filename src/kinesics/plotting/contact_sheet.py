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
"""Metres of paper between two figures, at least."""
_WIDEST_GAP: Final = 1.3
"""At most: arms stretched sideways may reach over their neighbours'."""
_CLEAR: Final = 0.1
"""Metres between most figures and their neighbours."""
_ROW: Final = 2.15
"""Metres of paper from floor to floor."""
_EDGE: Final = 0.04
"""Metres of paper beyond the outermost figure: half a stroke."""
_LEFT: Final = 0.55
"""Inches beside the rows, for the times."""
_INCHES: Final = 0.92
"""Of paper a metre."""
_PAPER: Final = 11.9
"""Metres of figures in a row, if nothing else is said."""
_LEAST_PAPER: Final = 6.0
"""Metres from the left end of the sheet to the right, at least."""
_FEW: Final = 6
"""Figures at least, where there are as many frames."""
_ROWS: Final = 4
"""Rows at most, if nothing else is said."""
_SOON: Final = (0.1, 0.05, 0.02, 0.01, 0.005)
"""Seconds between figures of what is over sooner."""
_TITLE_SIZE: Final = 9.5
"""Points."""
_TITLE_LINES: Final = 4
_STEPS: Final = (0.2, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0)


def contact_sheet(
    motion: Motion,
    *,
    transitions: ArrayLike = (),
    mirrored: Iterable[tuple[int, int]] = (),
    every: float | None = None,
    across: int | None = None,
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
    across : figures in a row; as many as there is room for unless given.
    ax : where to draw; a new figure without.

    Raises
    ------
    InputError
        If ``every`` or ``across`` is not positive, a frame does not exist, or the sheet would hold over 2000 figures.
    """
    if every is not None and not (np.isfinite(every) and every > 0.0):
        raise InputError(f"Expected `every` above 0 seconds, got {every}.")
    if across is not None and across < 1:
        raise InputError(f"Expected one figure or more `across`, got {across}.")
    cuts = np.asarray(transitions, dtype=np.float64).reshape(-1)
    ranges = [(int(a), int(b)) for a, b in mirrored]
    for frame in (*cuts.tolist(), *(f for pair in ranges for f in pair)):
        if not 0 <= frame <= motion.frame_count:
            raise InputError(f"No frame {frame:g} in a motion of {motion.frame_count} frames.")
    if every is not None and motion.duration > 2000 * every:
        raise InputError(
            f"A figure every {every:g} s would make {int(motion.duration / every)} figures; give a larger `every`."
        )
    gap = _gap(motion, view)
    across = max(1, int(_PAPER / gap)) if across is None else across
    step = _step(motion, across) if every is None else every
    times = np.arange(0.0, motion.duration - 1e-9, step)
    rows = -(-len(times) // across)
    columns = min(across, len(times))
    frames = np.minimum(np.round(times * motion.fps).astype(int), motion.frame_count - 1)
    strokes = compute_strokes(motion, frames, view=view)
    ground = float(motion.positions()[:, :, 1].min())
    spots = np.array([(k % across * gap, (rows - 1 - k // across) * _ROW - ground) for k in range(len(times))])
    # a figure may be wider than its share of the paper, and higher
    least, most = _extent(strokes, spots)
    low = (min(-0.5 * gap, least[0] - _EDGE), min(-0.42, least[1] - _EDGE))
    high = (max((columns - 0.5) * gap, most[0] + _EDGE), max(rows * _ROW, most[1] + _EDGE))
    said = (
        f"Every figure {_told(step)} later"
        + ("; orange marks: transitions" if len(cuts) else "")
        + ("; cyan: mirrored" if ranges else "")
    )
    said = said if title is None else f"{title}   ({said})"
    titled = [said]
    if ax is None:
        # a sheet of few figures is as wide as a title
        high = (max(high[0], low[0] + _LEAST_PAPER), high[1])
        width, height = _INCHES * (high[0] - low[0]), _INCHES * (high[1] - low[1])
        titled = canvas.title_lines(said, width - 0.1, _TITLE_SIZE, most=_TITLE_LINES)
        paper = (width + _LEFT + 0.1, height + 0.5 + 0.16 * (len(titled) - 1))
        ax = canvas.own_axes(*paper, rect=(_LEFT / paper[0], 0.05 / paper[1], width / paper[0], height / paper[1]))
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal")
    metre = canvas.pixel_size(ax)[0] / (high[0] - low[0]) * 72.0 / ax.figure.dpi
    line_width = float(np.clip(0.024 * metre, 0.5, 2.2))
    a_row = across * step
    for row in range(rows):
        floor = (rows - 1 - row) * _ROW
        start, end = row * a_row, min((row + 1) * a_row, motion.duration)
        _floor(ax, floor, gap, step, 0.0, end - start)
        for a, b in ranges:
            t0, t1 = max(a / motion.fps, start), min(b / motion.fps, end)
            if t1 > t0:
                _mirrored(ax, floor, gap, step, t0 - start, t1 - start)
        for cut in cuts / motion.fps:
            if start <= cut < end:
                _cut(ax, floor, gap, step, float(cut) - start)
        ax.text(low[0] - 0.06, floor, f"{start:g} s", fontsize=8, ha="right", va="center", color=canvas.INK)
    draw_figures(ax, [Placed(strokes, k, (x, y), (1.0, 1.0), line_width) for k, (x, y) in enumerate(spots.tolist())])
    ax.set_axis_off()
    ax.set_title("\n".join(titled), fontsize=_TITLE_SIZE, loc="left", color=canvas.INK, parse_math=False)
    return ax


def _extent(strokes: Strokes, spots: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The corners of what the figures cover when each stands on its spot, shape (figures, 2): across and up, metres."""
    points = strokes.segments.reshape(len(spots), -1, 2) + spots[:, None]
    heads = strokes.head_centres + spots
    least = np.minimum(points.min(axis=(0, 1)), heads.min(axis=0) - strokes.head_radius)
    return least, np.maximum(points.max(axis=(0, 1)), heads.max(axis=0) + strokes.head_radius)


def _gap(motion: Motion, view: View) -> float:
    """Metres of paper a figure, by what most of them want."""
    some = np.unique(np.linspace(0, motion.frame_count - 1, 40).astype(int))
    strokes = compute_strokes(motion, some, view=view)
    points = strokes.segments.reshape(len(some), -1, 2)[..., 0]
    return float(np.clip(np.quantile(np.ptp(points, axis=1), 0.75) + _CLEAR, _GAP, _WIDEST_GAP))


def _step(motion: Motion, across: int) -> float:
    """Seconds between figures: no more of them than rows hold, no fewer than show how it goes on, and none twice."""
    step = next((s for s in _STEPS if motion.duration / s <= across * _ROWS), _STEPS[-1])
    if motion.duration > step * (_FEW - 1):
        return step
    sooner = next((s for s in _SOON if motion.duration > s * (_FEW - 1)), _SOON[-1])
    return max(sooner, 1.0 / motion.fps)


def _told(seconds: float) -> str:
    return f"{seconds:g} s" if seconds >= 0.1 else f"{1000.0 * seconds:.3g} ms"


def _floor(ax: Axes, floor: float, gap: float, step: float, start: float, end: float) -> None:
    ends = [_place(start, gap, step), _place(end, gap, step)]
    ax.plot(ends, [floor, floor], color=canvas.FAINT, linewidth=1.0, zorder=1.0)


def _mirrored(ax: Axes, floor: float, gap: float, step: float, start: float, end: float) -> None:
    from matplotlib.patches import Rectangle

    left, right = _place(start, gap, step), _place(end, gap, step)
    ax.add_patch(
        Rectangle((left, floor), right - left, 0.87 * _ROW, facecolor=MIRRORED_SHADE, edgecolor="none", zorder=0.5)
    )
    ax.plot([left, right], [floor, floor], color=MIRRORED, linewidth=3.0, solid_capstyle="butt", zorder=1.1)


def _cut(ax: Axes, floor: float, gap: float, step: float, at: float) -> None:
    place = _place(at, gap, step)
    ax.plot([place, place], [floor - 0.2, floor + 0.1], color=CUT, linewidth=1.6, zorder=1.2)


def _place(seconds: float, gap: float, step: float) -> float:
    """Metres across the paper: a figure stands in the middle of its time."""
    return (seconds / step - 0.5) * gap
