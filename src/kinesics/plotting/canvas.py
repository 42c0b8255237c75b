"""Figures that pyplot never hears of, and files that are the same bytes on every run."""

from __future__ import annotations

import io
import os
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.plotting.letters import UNKNOWN, drawable, lettering

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK: Final = "#1a1a1a"
FAINT: Final = "#9a9a9a"
GRID: Final = "#e4e4e4"
LEFT: Final = "#c8442e"
RIGHT: Final = "#2b6ca3"

DPI: Final = 150
SUFFIXES: Final = (".png", ".svg")


def new_figure(width: float, height: float, *, dpi: float = DPI) -> Figure:
    """An empty figure of ``width`` × ``height`` inches that belongs to the caller alone: nothing has to be closed."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=dpi, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def figure_bytes(figure: Figure, suffix: str) -> bytes:
    """The figure as a file's contents, the same on every run: no date, no program version, ids from a fixed salt.

    Raises
    ------
    InputError
        If the suffix is neither .png nor .svg.
    """
    import matplotlib

    if suffix not in SUFFIXES:
        raise InputError(f"Expected a picture named {' or '.join(SUFFIXES)}, got '{suffix}'.")
    if suffix == ".png":
        return _png(figure)
    stream = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "kinesics", "svg.fonttype": "path"}), drawable(figure):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return stream.getvalue()


def _png(figure: Figure) -> bytes:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    stream = io.BytesIO()
    paper: Any = FigureCanvasAgg(figure)  # matplotlib types it in part
    with drawable(figure):
        paper.draw()
    pixels = np.asarray(paper.buffer_rgba())
    picture = Image.fromarray(pixels if (pixels[..., 3] < 255).any() else np.ascontiguousarray(pixels[..., :3]))
    # runs alone: a search for repetitions takes twice as long and gains nothing in plots of Z
    picture.save(stream, format="png", dpi=(figure.dpi, figure.dpi), compress_type=zlib.Z_RLE)
    return stream.getvalue()


def show_pixels(ax: Axes, image: NDArray[np.uint8], size: tuple[float, float], *, aspect: float) -> None:
    """A picture, shape (rows from below, columns, 3), over the axes from (0, 0) to ``size``; nothing is blurred."""
    from kinesics.plotting.pixel_image import PixelImage

    shown = PixelImage(ax, origin="lower", extent=(0.0, size[0], 0.0, size[1]), interpolation="nearest")
    ax.set_aspect(aspect)
    shown.set_data(image)
    shown.set_clip_path(ax.patch)
    shown.set_extent(shown.get_extent())
    ax.add_image(shown)


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure as PNG or SVG, by its suffix; the file appears whole or not at all.

    Raises
    ------
    InputError
        If the suffix is neither .png nor .svg.
    """
    target = Path(path)
    contents = figure_bytes(figure, target.suffix.lower())
    part = target.with_name(f".{target.name}.part")
    try:
        part.write_bytes(contents)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def own_axes(width: float, height: float, *, rect: tuple[float, float, float, float]) -> Axes:
    """Axes at ``rect`` (left, bottom, width, height as fractions) of a new figure of that many inches.

    The place is given, not found: the layout engines of matplotlib draw every text twice to find theirs.
    """
    return new_figure(width, height).add_axes(rect)


def title_lines(text: str, inches: float, size: float, *, most: int) -> list[str]:
    """A title in as many lines as it takes so as to be no wider; what does not fit into ``most`` of them ends in "…".

    Parameters
    ----------
    size : of the letters, points.
    """
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextToPath

    known = lettering(text)
    font = FontProperties(family=[*FontProperties().get_family(), *known.families], size=size)
    measure, drawn = TextToPath(), str.maketrans(dict.fromkeys(known.lacking, UNKNOWN))

    def fits(line: str) -> bool:
        width, _, _ = measure.get_text_width_height_descent(line.translate(drawn), font, ismath=False)
        # letters are put on whole pixels as they are drawn
        return bool(1.03 * width <= 72.0 * inches)

    lines: list[str] = []
    rest = text.strip()
    while rest:
        if fits(rest):
            return [*lines, rest]
        if len(lines) == most - 1:
            return [
                *lines,
                next((f"{rest[:n].rstrip()} …" for n in range(len(rest), 0, -1) if fits(f"{rest[:n]} …")), "…"),
            ]
        room = next((n for n in range(len(rest), 1, -1) if fits(rest[:n])), 1)
        end = rest.rfind(" ", 0, room + 1)
        # a long word is broken rather than half a line left empty
        end = end if end > room // 2 else room
        lines.append(rest[:end].rstrip())
        rest = rest[end:].lstrip()
    return lines


def pixel_size(ax: Axes) -> tuple[int, int]:
    """Width and height of the axes in pixels at the figure's resolution."""
    extent = ax.get_window_extent()
    return max(1, round(extent.width)), max(1, round(extent.height))


def tidy(ax: Axes) -> None:
    """Open frame, quiet ticks, horizontal guide lines."""
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        ax.spines[side].set_color(FAINT)
    ax.tick_params(colors=INK, labelsize=9, color=FAINT)
    ax.grid(axis="y", color=GRID, linewidth=0.6)
    ax.set_axisbelow(True)
