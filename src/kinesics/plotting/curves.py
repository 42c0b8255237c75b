"""Curves over time: how fast the pose changes (§3.2), how symmetric it is (§3.3)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.plotting import canvas
from kinesics.plotting.pooling import bin_starts

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SPEED_INK = "#7a3e9d"
SYMMETRY_INK = "#0b7f8c"
STILL_SHADE = "#d9d2c4"
SYMMETRIC_SHADE = "#cdeef0"


def speed_plot(
    speed: ArrayLike,
    fps: float,
    *,
    stillness: Iterable[tuple[int, int]] = (),
    title: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The rate of change of the pose, √(2D)/Δt, in 1/s: half the r.m.s. angular speed of the joints in rad/s (§3.2).

    Parameters
    ----------
    speed : of each frame (`kinesics.similarity.speed`), shape (frames,).
    fps : frames a second.
    stillness : ranges [start, end) to shade.

    Returns
    -------
    The axes. Longer curves than the axes have pixels are drawn as the band from least to greatest value in each pixel.
    """
    ax = _curve(speed, fps, SPEED_INK, stillness, STILL_SHADE, ax)
    ax.set_ylabel("speed √(2D)/Δt (1/s)", fontsize=10)
    ax.set_title("Speed of the pose" if title is None else title, fontsize=11, loc="left", color=canvas.INK, y=1.0)
    return ax


def symmetry_plot(
    mirror_distance: ArrayLike,
    fps: float,
    *,
    threshold: float | None = None,
    symmetric: Iterable[tuple[int, int]] = (),
    title: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """How far the pose is from its own mirror image over time: D*(a, a), no unit; 0 is symmetric (§2.14, §3.3).

    Parameters
    ----------
    mirror_distance : D*(a, a) of each frame, shape (frames,).
    threshold : drawn as a dashed line.
    symmetric : ranges [start, end) to shade.
    """
    ax = _curve(mirror_distance, fps, SYMMETRY_INK, symmetric, SYMMETRIC_SHADE, ax)
    if threshold is not None:
        ax.axhline(threshold, color=canvas.INK, linewidth=0.8, linestyle=(0, (4, 3)))
    ax.set_ylabel("D*(a, a)", fontsize=10)
    heading = "Distance of the pose from its own mirror image" if title is None else title
    ax.set_title(heading, fontsize=11, loc="left", color=canvas.INK, y=1.0)
    return ax


def _curve(
    values: ArrayLike,
    fps: float,
    colour: str,
    ranges: Iterable[tuple[int, int]],
    shade: str,
    ax: Axes | None,
) -> Axes:
    y = np.asarray(values, dtype=np.float64)
    if y.ndim != 1:
        raise InputError(f"Expected one value a frame, got shape {y.shape}.")
    if not fps > 0:
        raise InputError(f"Expected a frame rate above 0, got {fps}.")
    if ax is None:
        ax = canvas.own_axes(9.0, 2.4, rect=(0.085, 0.22, 0.9, 0.66))
    for start, end in ranges:
        ax.axvspan(start / fps, end / fps, color=shade, linewidth=0.0, zorder=0)
    bins = canvas.pixel_size(ax)[0]
    if len(y) == 0:
        pass
    elif len(y) <= 2 * bins:
        ax.plot(np.arange(len(y)) / fps, y, color=colour, linewidth=1.1, marker="." if len(y) == 1 else "")
    else:
        times, low, high = _band(y, bins, fps)
        ax.fill_between(times, low, high, color=colour, linewidth=0.6)
    ax.set_xlim(0.0, max(len(y), 1) / fps)
    top = float(y.max()) if len(y) else 1.0
    ax.set_ylim(0.0, 1.06 * top if top > 0.0 else 1.0)
    ax.set_xlabel("time (s)", fontsize=10)
    canvas.tidy(ax)
    return ax


def _band(
    y: NDArray[np.float64], bins: int, fps: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Time, least and greatest value in each bin; neighbours overlap by one frame so that no gap opens between them."""
    starts = bin_starts(len(y), bins)
    low, high = np.minimum.reduceat(y, starts), np.maximum.reduceat(y, starts)
    first = y[starts[1:]]
    low[:-1], high[:-1] = np.minimum(low[:-1], first), np.maximum(high[:-1], first)
    return starts / fps, low, high
