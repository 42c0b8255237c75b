"""Motifs as rows: the stretch that recurs as figures, and where in time it recurs (§3.2-3.4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from kinesics.analysis.facts import Motif, MotifMember
from kinesics.errors import InputError
from kinesics.plotting import canvas
from kinesics.plotting.palettes import find_palette
from kinesics.plotting.stick_figures import Placed, View, compute_strokes, draw_figures

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from kinesics.body.motion import Motion

_FIGURES: Final = 0.4
"""Of the width."""
_POSES: Final = 6


def motif_plot(
    motifs: Sequence[Motif],
    motions: Sequence[Motion],
    *,
    palette: str = "thesis",
    most: int = 8,
    view: View = "three-quarter",
    ax: Axes | None = None,
) -> Axes:
    """A row for each stretch that recurs: its poses, lighter as it evolves, and all its occurrences on the time axis.

    Bars have the colours of Z (the same) and Z* (mirrored); the arrow in a bar points left where the stretch is done backwards. The
    one shown is framed. Sources stand one after another.

    Parameters
    ----------
    motions : of the sources, one each.
    most : rows; those that recur for the longest time altogether.
    ax : where to draw; a new figure without.

    Raises
    ------
    InputError
        If a motif is of a source that has no motion, or ``most`` is less than 1.
    """
    if most < 1:
        raise InputError(f"Expected at least one row, got {most}.")
    if any(m.source >= len(motions) for motif in motifs for m in motif.members):
        raise InputError(f"The motifs are of more than the {len(motions)} motions given.")
    rows = ranked_stretches(motifs)[:most]
    if ax is None:
        ax = canvas.own_axes(9.6, 0.95 * max(1, len(rows)) + 0.3, rect=(0.01, 0.02, 0.98, 0.96))
    ax.set_xlim(0.0, 1.0)
    ax.set_ylim(-max(1, len(rows)) - 0.3, 0.0)
    ax.set_axis_off()
    if not rows:
        ax.text(0.5, -0.5, "nothing recurs", ha="center", va="center", color=canvas.FAINT)
        return ax
    pixels = canvas.pixel_size(ax)
    height = pixels[1] / (len(rows) + 0.3)
    colours = find_palette(palette)
    begins = np.cumsum([0.0, *(m.duration for m in motions)])
    left, width = _FIGURES + 0.05, 1.0 - _FIGURES - 0.06

    for border in begins[1:-1]:
        x = left + width * float(border / begins[-1])
        ax.plot([x, x], [-len(rows), 0.0], color=canvas.FAINT, linewidth=0.7, linestyle=(0, (3, 3)), zorder=1.5)

    def place(source: int, frame: int) -> float:
        return float(left + width * (begins[source] + frame / motions[source].fps) / begins[-1])

    for number, members in enumerate(rows):
        _figures(ax, members[0], motions, number, (pixels[0], height), view)
        ax.plot([left, left + width], [-number - 0.5] * 2, color=canvas.GRID, linewidth=1.0, zorder=1)
        for k, member in enumerate(members):
            a, b = place(member.source, member.start), place(member.source, member.end)
            y = -number - 0.5
            colour = tuple(0.25 + 0.68 * c for c in (colours.z_mirror if member.mirrored else colours.z))
            ax.fill(
                [a, b, b, a],
                [y - 0.16, y - 0.16, y + 0.16, y + 0.16],
                facecolor=colour,
                edgecolor=canvas.INK if k == 0 else "white",
                linewidth=1.2 if k == 0 else 0.6,
                zorder=3 if k == 0 else 2,
            )
            arrow = "←" if member.reversed else "→"
            if b - a > 0.014:
                ax.text(0.5 * (a + b), y, arrow, ha="center", va="center", fontsize=8, color=canvas.INK, zorder=4)
    base = -len(rows) - 0.02
    for t in _ticks(float(begins[-1])):
        x = left + width * t / float(begins[-1])
        ax.text(x, base - 0.1, f"{t:g}", ha="center", va="center", fontsize=8, color=canvas.INK)
    ax.text(left - 0.01, base - 0.1, "time (s)", ha="right", va="center", fontsize=8, color=canvas.INK)
    return ax


def ranked_stretches(motifs: Sequence[Motif]) -> list[tuple[MotifMember, ...]]:
    """Motifs of one stretch under several relations as one set, its first occurrence first; what recurs longest comes first."""
    found: dict[tuple[int, int, int], list[MotifMember]] = {}
    for motif in motifs:
        first = motif.members[0]
        found.setdefault((first.source, first.start, first.end), [first]).extend(motif.members[1:])
    rows = [tuple(members) for members in found.values()]
    return sorted(rows, key=lambda members: -sum(m.end - m.start for m in members))


def _figures(
    ax: Axes, member: MotifMember, motions: Sequence[Motion], row: int, pixels: tuple[float, float], view: View
) -> None:
    motion = motions[member.source]
    frames = np.rint(np.linspace(member.start, member.end - 1, _POSES)).astype(np.intp)
    strokes = compute_strokes(motion, frames, view=view)
    low = float(strokes.segments[..., 1].min())
    tops = float((strokes.head_centres[:, 1] + strokes.head_radius).max())
    high = max(float(strokes.segments[..., 1].max()), tops)
    metre = 0.84 * pixels[1] / max(high - low, 0.3)
    across, up = metre / pixels[0], metre / pixels[1]
    places = np.linspace(0.1, _FIGURES - 0.03, _POSES)
    line = float(np.clip(0.012 * pixels[1] * 72.0 / ax.figure.dpi, 0.6, 1.6))
    base = -row - 0.94 - low * up
    draw_figures(
        ax,
        [
            Placed(strokes, k, (float(places[k]), base), (across, up), line, 1.0 - 0.75 * k / (_POSES - 1), grey=True)
            for k in reversed(range(_POSES))
        ],
    )
    lasts = (member.end - member.start) / motion.fps
    ax.text(0.005, -row - 0.4, str(row + 1), fontsize=11, ha="left", va="center", color=canvas.INK)
    ax.text(0.005, -row - 0.68, f"{lasts:.1f} s", fontsize=8, ha="left", va="center", color=canvas.FAINT)


def _ticks(length: float) -> list[float]:
    """Round times, some six of them."""
    raw = length / 6.0
    size = 10.0 ** np.floor(np.log10(raw))
    step = float(size * next(s for s in (1.0, 2.0, 5.0, 10.0) if s * size >= raw))
    return [float(t) for t in np.arange(0.0, length + 1e-9, step)]
