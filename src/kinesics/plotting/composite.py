"""The motion path in the symmetry basis Ψ = S + A ([Schultz2012] §2.11-2.12, Figures 9-10 and 34-63)."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body.pose import symmetry_parts
from kinesics.geometry import quaternion
from kinesics.plotting import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from kinesics.body.pose import PoseSequence

Array = NDArray[np.float64]
SYMMETRIC_INK = "#00bcd4"
IMAGE_INK = "#cfcfcf"
TIME_COLOURS = "plasma"
_PIECES = 96


class SymmetryCoordinates(NamedTuple):
    """A path projected onto the principal directions of its symmetric and of its antisymmetric part."""

    symmetric: Array
    """About the mean of S, shape (frames, 2)."""
    antisymmetric: Array
    """About 0, so that the mirrored path is this one with its sign changed. Shape (frames, 2)."""
    symmetric_share: Array
    """Share of the variance of S along each direction, shape (2,); 0 where S does not vary."""
    antisymmetric_share: Array
    """Share of the square sum of A, shape (2,)."""


def symmetry_coordinates(poses: PoseSequence) -> SymmetryCoordinates:
    """Coordinates for the plots of the symmetry subspaces.

    S is centred on its mean; A is **not**: its origin is the symmetric subspace, and WΨ is Ψ with A negated. Each direction is
    a right singular vector, signed so that its largest component is positive: the same recording gives the same picture.
    Lengths are in units of √(2D), as far as two directions can show them.
    """
    q = np.array(poses.quaternions)
    # one sign for a link throughout: the one on the side of its mean, or S would jump where a file flips q to −q
    q *= np.where(np.sum(q * quaternion.mean(q), axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    parts = symmetry_parts(q)
    # D = |q − q'|²/2 averaged over 15 links, so √(2D) is the length of the difference over √15
    flat = [part.reshape(len(q), -1) / np.sqrt(q.shape[1]) for part in parts]
    symmetric, symmetric_share = _principal(flat[0] - flat[0].mean(axis=0))
    antisymmetric, antisymmetric_share = _principal(flat[1])
    return SymmetryCoordinates(symmetric, antisymmetric, symmetric_share, antisymmetric_share)


def subspace_plot(poses: PoseSequence, *, axes: tuple[Axes, Axes] | None = None) -> tuple[Axes, Axes]:
    """The path in the antisymmetric (left) and the symmetric subspace (right), as Figures 9, 34, 38 … 62.

    In the antisymmetric one the mirrored path −A is drawn in grey; a path that stays at the origin is symmetric.

    Parameters
    ----------
    axes : two, antisymmetric first; a new figure without.
    """
    if axes is None:
        figure = canvas.new_figure(8.4, 4.2)
        axes = (figure.add_axes((0.09, 0.15, 0.385, 0.77)), figure.add_axes((0.585, 0.15, 0.385, 0.77)))
    left, right = axes
    place = symmetry_coordinates(poses)
    _path(left, -place.antisymmetric, image=True)
    _path(left, place.antisymmetric)
    _path(right, place.symmetric)
    reach = 1.08 * max(np.abs(place.antisymmetric).max(), np.abs(place.symmetric).max(), 1e-6)
    words = ((left, "Â", place.antisymmetric_share), (right, "Ŝ", place.symmetric_share))
    for ax, letter, share in words:
        ax.set_xlim(-reach, reach)
        ax.set_ylim(-reach, reach)
        ax.set_xlabel(f"{letter}₁   ({share[0]:.0%})", fontsize=11)
        ax.set_ylabel(f"{letter}₂   ({share[1]:.0%})", fontsize=11)
        _cross(ax)
    left.set_title("antisymmetric part A", fontsize=11, color=canvas.INK)
    right.set_title("symmetric part S", fontsize=11, color=canvas.INK)
    return left, right


def composite_plot(
    poses: PoseSequence,
    *,
    symmetric: Iterable[tuple[int, int]] = (),
    title: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The path in the combined basis: the symmetry axis Ŝ upwards, Â across, and its mirror image (Figures 10, 35 … 63).

    The path runs from dark to light with time; its mirror image Ψ*, reflected in the vertical axis, is grey. On that axis lie
    the symmetric poses alone, though a pose that is symmetric in its first direction only lies there too: the shares of
    the directions stand beside the axes.

    Parameters
    ----------
    symmetric : ranges [start, end) of symmetric states, drawn in cyan (Figure 43).
    """
    if ax is None:
        ax = canvas.own_axes(6.0, 5.6, rect=(0.13, 0.11, 0.83, 0.8))
    place = symmetry_coordinates(poses)
    across, up = place.antisymmetric[:, 0], place.symmetric[:, 0]
    path = np.stack([across, up], axis=1)
    ax.axvline(0.0, color=canvas.FAINT, linewidth=1.0, zorder=0)
    _path(ax, path * np.array([-1.0, 1.0]), image=True)
    _path(ax, path)
    for start, end in symmetric:
        ax.plot(
            across[start:end], up[start:end], color=SYMMETRIC_INK, linewidth=2.4, marker="o", markersize=2.2, zorder=4
        )
    reach = 1.08 * max(float(np.abs(across).max()), 0.5 * float(np.ptp(up)), 1e-6)
    middle = 0.5 * float(up.max() + up.min())
    ax.set_xlim(-reach, reach)
    ax.set_ylim(middle - reach, middle + reach)
    ax.set_aspect("equal")
    ax.set_xlabel(f"Â   antisymmetric, first direction ({place.antisymmetric_share[0]:.0%} of A)", fontsize=11)
    ax.set_ylabel(f"Ŝ   symmetric, first direction ({place.symmetric_share[0]:.0%} of S)", fontsize=11)
    heading = "Ψ (dark to light with time) and its mirror image Ψ* (grey)" if title is None else title
    ax.set_title(heading, fontsize=11, color=canvas.INK, y=1.0)
    _cross(ax, lines=False)
    return ax


def _principal(values: Array) -> tuple[Array, Array]:
    """Coordinates along the first two right singular vectors and the share of the square sum that each holds."""
    scatter = values.T @ values
    power, directions = np.linalg.eigh(scatter)
    first = directions[:, [-1, -2]]
    largest = np.argmax(np.abs(first), axis=0)
    first = first * np.sign(first[largest, [0, 1]])
    total = float(np.trace(scatter))
    share = np.clip(power[[-1, -2]], 0.0, None) / total if total > 1e-12 else np.zeros(2)
    return values @ first, share


def _path(ax: Axes, points: Array, *, image: bool = False) -> None:
    """A line from dark to light with time; grey for the mirror image."""
    from matplotlib import colormaps
    from matplotlib.collections import LineCollection

    if image:
        ax.plot(points[:, 0], points[:, 1], color=IMAGE_INK, linewidth=1.0, zorder=1)
        return
    # the last fifth of the scale is too pale on paper
    pieces = min(_PIECES, max(1, len(points) - 1))
    colours = colormaps[TIME_COLOURS](np.linspace(0.0, 0.82, pieces))
    if len(points) > 1:
        # neighbouring pieces share a point, so that the line has no gaps
        ends = (np.arange(pieces + 1) * (len(points) - 1)) // pieces
        lines = [points[a : b + 1] for a, b in pairwise(ends)]
        ax.add_collection(LineCollection(lines, colors=colours, linewidths=1.3, zorder=2))
    ax.plot(*points[0], color=colours[0], marker="o", markersize=6, zorder=3)
    ax.plot(*points[-1], color=colours[-1], marker="s", markersize=6, zorder=3)


def _cross(ax: Axes, *, lines: bool = True) -> None:
    """Axes through the origin."""
    if lines:
        ax.axhline(0.0, color=canvas.GRID, linewidth=0.8, zorder=0)
        ax.axvline(0.0, color=canvas.GRID, linewidth=0.8, zorder=0)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    ax.tick_params(labelsize=9, colors=canvas.INK)
    ax.locator_params(nbins=6)
