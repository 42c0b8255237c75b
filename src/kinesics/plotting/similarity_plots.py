"""Z, Z* and both: the square of all pairs of moments and the triangle with time running right ([Schultz2012] §3.2-3.4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.plotting import canvas
from kinesics.plotting.palettes import Palette, blend, find_palette
from kinesics.plotting.pooling import Float32, pool_maximum
from kinesics.plotting.stick_figures import stick_figure_row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from kinesics.body.motion import Motion

Kind = Literal["both", "z", "z_mirror"]
_TITLES: dict[str, str] = {"both": "Z/Z*", "z": "Z", "z_mirror": "Z*"}


@runtime_checkable
class HasSimilarity(Protocol):
    """What the plots need of a result: `kinesics.similarity.Similarity` and `PooledSimilarity` have it."""

    @property
    def z(self) -> NDArray[np.floating]:
        """Similarity, shape (n, n)."""
        ...

    @property
    def z_mirror(self) -> NDArray[np.floating]:
        """Anti-similarity, shape (n, n)."""
        ...


class _Layers(NamedTuple):
    """What is drawn: pooled layers and what is known of them."""

    z: Float32 | None
    z_mirror: Float32 | None
    frames: int
    beta: float | None
    fps: float | None


def similarity_plot(
    sim: HasSimilarity | tuple[ArrayLike, ArrayLike],
    *,
    kind: Kind = "both",
    palette: str | Palette = "thesis",
    fps: float | None = None,
    beta: float | None = None,
    title: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The square plot of all pairs of moments (Figures 18, 20, 30, 32, 107).

    The pixel in column i and row j (counted from the lower left, so that both times run away from the corner) shows how
    alike the poses at frames i and j are: Z with one light, Z* with the other, both together white.

    Parameters
    ----------
    sim : a `Similarity`, a `PooledSimilarity`, or two square arrays (z, z_mirror), values in [0, 1], shape (n, n).
    kind : "both", "z" or "z_mirror".
    palette : "thesis" (red and cyan), "colorblind" (orange and blue), "grey" for one matrix alone, or a `Palette`.
    fps : frames a second, for axes in seconds; taken from ``sim`` where it knows, else the axes count frames.
    beta : for the caption; taken from ``sim`` where it knows.
    title : in place of "Z/Z*   β = …"; "" for none.
    ax : where to draw; a new figure without.

    Returns
    -------
    The axes. Larger matrices than the axes have pixels are pooled by maximum, so that no signal is lost.

    Raises
    ------
    InputError
        If an array is not square, the two differ in shape, or ``kind`` or ``palette`` is unknown.
    """
    if ax is None:
        ax = canvas.own_axes(6.4, 6.4, rect=(0.12, 0.11, 0.82, 0.82))
    layers = _layers(sim, kind, min(canvas.pixel_size(ax)), fps, beta)
    image = blend(layers.z, layers.z_mirror, palette)
    extent = _span(layers)
    canvas.show_pixels(ax, image, (extent, extent), aspect=1.0)
    unit = "s" if layers.fps else "frames"
    ax.set_xlabel(f"time $t_i$ ({unit})", fontsize=11)
    ax.set_ylabel(f"time $t_j$ ({unit})", fontsize=11)
    _finish(ax, layers, kind, title)
    return ax


def similarity_triangle(
    sim: HasSimilarity | tuple[ArrayLike, ArrayLike],
    motion: Motion | None = None,
    *,
    kind: Kind = "both",
    palette: str | Palette = "thesis",
    fps: float | None = None,
    beta: float | None = None,
    title: str | None = None,
    overlap: float = 1.0 / 6.0,
    figures: int = 10,
    ax: Axes | None = None,
) -> Axes:
    """The plot turned by 45°: the identity axis below, time running right, the lag between the moments upwards (Figure 21).

    Parameters
    ----------
    sim, kind, palette, fps, beta, title, ax : as in `similarity_plot`.
    motion : draws the row of stick figures beneath: at each time Ψ(t) and Ψ(t + Δ) overlap, so that a fast stretch,
        where the identity axis is thin, shows bodies far apart.
    overlap : Δ in seconds; the dissertation's is a sixth of a second.
    figures : how many.

    Returns
    -------
    The axes of the triangle; the row of figures is in ``ax.child_axes``.

    Raises
    ------
    InputError
        As `similarity_plot`; or if ``motion`` has another number of frames than the matrices.
    """
    row = motion is not None
    if ax is None:
        ax = canvas.own_axes(9.0, 6.2 if row else 4.9, rect=(0.08, 0.3 if row else 0.11, 0.89, 0.64 if row else 0.81))
    width = canvas.pixel_size(ax)[0]
    layers = _layers(sim, kind, width, fps, beta)
    if motion is not None and motion.frame_count != layers.frames:
        raise InputError(f"The motion has {motion.frame_count} frames, the matrices {layers.frames}.")
    if layers.fps is None and motion is not None:
        layers = layers._replace(fps=motion.fps)
    z, z_mirror = (None if x is None else rotate_to_triangle(x, width) for x in (layers.z, layers.z_mirror))
    image = blend(z, z_mirror, palette)
    shape = image.shape
    # above the hypotenuse there is no pair of moments: leave it to the paper
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    outside = (columns < rows) | (columns + rows > shape[1] - 1)
    image[outside] = 255
    extent = _span(layers)
    # a pixel is one cell wide and two lags high: with an aspect of one half it is square
    height = 2.0 * shape[0] * extent / shape[1]
    canvas.show_pixels(ax, image, (extent, height), aspect=0.5)
    # a white signal that reaches the edge would run out into the paper
    ax.plot([0.0, extent / 2.0, extent], [0.0, extent, 0.0], color=canvas.FAINT, linewidth=0.8, clip_on=False)
    ax.set_xlim(0.0, extent)
    ax.set_ylim(0.0, height)
    unit = "s" if layers.fps else "frames"
    ax.set_xlabel(f"time $(t_i + t_j)/2$ ({unit})", fontsize=11)
    ax.set_ylabel(f"lag $t_j - t_i$ ({unit})", fontsize=11)
    _finish(ax, layers, kind, title)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    if motion is not None:
        figures_beneath(ax, [motion], overlap=overlap, figures=figures)
    return ax


def rotate_to_triangle(matrix: NDArray[np.float32], width: int) -> Float32:
    """The upper triangle of a symmetric matrix turned by 45°, without losing a cell.

    Parameters
    ----------
    matrix : shape (n, n), n ≤ width.
    width : of the result, in pixels, at most; small matrices are blown up by a whole factor.

    Returns
    -------
    Row r, column c is the larger of the cells (c − r, c + r) and (c − r, c + r + 1): these two share the pixel, each cell
    with i ≤ j is in exactly one. Where the factor is 2 or more, cells are points and what lies between them is interpolated
    instead, for enlarged cells are diamonds whose stepped edges look like hatching. Row 0 is the identity axis. Shape
    ((m + 1) // 2, m); 0 outside the triangle.
    """
    factor = max(1, width // len(matrix))
    m = len(matrix) * factor
    if factor > 1:
        c, r = np.arange(m)[None, :], np.arange((m + 1) // 2)[:, None]
        low, high = c - r, c + r
        inside = (low >= 0) & (high < m)
        middle = factor // 2
        turned = np.zeros(inside.shape, dtype=np.float32)
        turned[inside] = _between_cells(matrix, (low[inside] - middle) / factor, (high[inside] - middle) / factor)
        return turned
    out = np.zeros(((m + 1) // 2, m), dtype=np.float32)
    for lag, row in enumerate(out):
        even, odd = matrix.diagonal(2 * lag), matrix.diagonal(2 * lag + 1)
        row[lag : lag + len(even)] = even
        np.maximum(row[lag : lag + len(odd)], odd, out=row[lag : lag + len(odd)])
    return out


def _between_cells(matrix: Float32, i: NDArray[np.float64], j: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values at fractional indices: cells are met exactly, and lines along either diagonal do not pulse.

    Linear over the two triangles of each four cells, cut along the brighter diagonal. (Bilinear interpolation would dim a
    line one cell thin, such as the identity axis of a fast movement, to a half between any two of its cells.)
    """
    last = len(matrix) - 1
    i, j = np.clip(i, 0.0, last), np.clip(j, 0.0, last)
    i0, j0 = np.floor(i).astype(np.intp), np.floor(j).astype(np.intp)
    i1, j1 = np.minimum(i0 + 1, last), np.minimum(j0 + 1, last)
    u, v = i - i0, j - j0
    a, b, c, d = matrix[i0, j0], matrix[i0, j1], matrix[i1, j1], matrix[i1, j0]
    same_lag = a + (c - a) * np.minimum(u, v) + np.where(u >= v, (d - a) * (u - v), (b - a) * (v - u))
    same_time = np.where(u + v <= 1.0, a + (d - a) * u + (b - a) * v, c + (b - c) * (1.0 - u) + (d - c) * (1.0 - v))
    return np.asarray(np.where(a + c >= b + d, same_lag, same_time))


def _layers(
    sim: HasSimilarity | tuple[ArrayLike, ArrayLike], kind: Kind, size: int, fps: float | None, beta: float | None
) -> _Layers:
    """Check what came and pool it to at most ``size``."""
    if kind not in _TITLES:
        raise InputError(f"Expected `kind` to be one of {', '.join(_TITLES)}, got '{kind}'.")
    if isinstance(sim, tuple):
        if len(sim) != 2:
            raise InputError(f"Expected two matrices (z, z_mirror), got {len(sim)}.")
        pair = sim
    elif isinstance(sim, HasSimilarity):
        pair = (sim.z, sim.z_mirror)
        fps = getattr(sim, "fps", None) if fps is None else fps
        beta = getattr(sim, "beta", None) if beta is None else beta
    else:
        raise InputError(f"Expected a Similarity or two matrices (z, z_mirror), got {type(sim).__name__}.")
    shapes = [np.shape(values) for values in pair]
    if shapes[0] != shapes[1]:
        raise InputError(f"Expected `z` and `z_mirror` of one shape, got {shapes[0]} and {shapes[1]}.")
    frames = getattr(sim, "frame_count", shapes[0][0] if shapes[0] else 0)
    return _Layers(
        pool_maximum(pair[0], size) if kind != "z_mirror" else None,
        pool_maximum(pair[1], size) if kind != "z" else None,
        int(frames),
        beta,
        fps,
    )


def _span(layers: _Layers) -> float:
    """Length of the time axis: seconds where the frame rate is known, else frames."""
    return layers.frames / layers.fps if layers.fps else float(layers.frames)


def _finish(ax: Axes, layers: _Layers, kind: Kind, title: str | None) -> None:
    """Title and ticks."""
    if title is None:
        title = _TITLES[kind] + (f"    β = {layers.beta:.3g}" if layers.beta is not None else "")
    if title:
        # with its height given, matplotlib does not look for one that keeps clear of ticks above, where there are none
        ax.set_title(title, fontsize=12, color=canvas.INK, pad=8, y=1.0)
    ax.tick_params(labelsize=10, colors=canvas.INK, direction="out")


def colour_key(palette: str | Palette) -> str:
    """One line that says which light is which, for captions."""
    colours = find_palette(palette)
    return (
        f"{colours.z_word}: the same pose (Z); {colours.z_mirror_word}: the mirrored pose (Z*); "
        f"{colours.both_word}: both"
    )


def figures_beneath(ax: Axes, motions: Sequence[Motion], *, overlap: float = 1.0 / 6.0, figures: int = 10) -> None:
    """The row of overlaid figures under a triangle, each centred under its own time (Figure 21).

    Parameters
    ----------
    ax : of the triangle; its time axis is the motions one after another.
    motions : at least one.
    overlap, figures : as in `similarity_triangle`; each motion has its share of the figures, and at least one.
    """
    ends = np.cumsum([0.0, *(m.duration for m in motions)]) / sum(m.duration for m in motions)
    for motion, start, end in zip(motions, ends, ends[1:], strict=False):
        # the axis label and the tick labels stand between the triangle and the figures
        below = ax.inset_axes((float(start), -0.45, float(end - start), 0.32))
        count = min(max(1, round(figures * float(end - start))), motion.frame_count)
        # figure k stands in the middle of its share of the time axis
        frames = ((np.arange(count) + 0.5) * motion.frame_count / count).astype(np.intp)
        step = max(1, round(overlap * motion.fps)) if motion.frame_count > 1 else 0
        stick_figure_row(motion, frames, overlap_frames=step, ax=below, spread="time")
