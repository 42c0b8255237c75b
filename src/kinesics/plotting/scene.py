"""A movement over the floor, seen obliquely from above: its trail, where it was to go, the body along the way.

After Figure 82 of [Schultz2012] (§4.4.1), in which the avatar's trail to its target is drawn on the floor in blue.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.plotting import canvas, stick_figures

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from kinesics.body.motion import Motion

Array = NDArray[np.float64]

TRAIL: Final = "#1f5fd0"
"""The dissertation's blue."""
GOAL: Final = "#d9822b"
SHADOW: Final = "#cfcfc8"
FLOOR: Final = "#f3f2ee"
TILE: Final = "#dcdad2"

_MOST_FIGURES: Final = 20
_APART: Final = 0.55
"""Metres between the places of two figures; nearer ones would hide each other."""
_STEPS: Final = (0.1, 0.2, 0.25, 0.5, 1.0, 1.5, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0)
"""Seconds between figures."""
_MARGIN: Final = 1.0
"""Metres of floor around what is on it."""
_LEAST_FLOOR: Final = 3.0
"""Metres of floor across the picture, at least."""
_DEPTH: Final = 0.14
"""Of the floor, as a share of its length, at least: a way straight on would run over a thread."""
_TILES: Final = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
"""Metres that a tile may be wide: the first of which no more than `_MOST_TILES` lie along the floor."""
_MOST_TILES: Final = 40
"""More would be a fog of lines."""


_PAPER: Final = 9.0
"""Inches from the left end of the floor to the right."""
_LEAST_FIGURE: Final = 0.6
"""Inches: the smallest figure in which limbs can be told apart."""
_STATURE: Final = 1.7
"""Metres, about."""
_LARGER: Final = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0, 200.0, 500.0)
"""Times that figures may be drawn too large for a long way."""
_MOST_DOTS: Final = 60
_DOT_STEPS: Final = (1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0)
"""Seconds between dots."""

_TITLE_SIZE: Final = 11.0
"""Points."""
_TITLE_LINES: Final = 4

_ROUND: Final = np.linspace(0.0, 2.0 * np.pi, 90)
_RING: Final = np.stack([np.sin(_ROUND), np.cos(_ROUND)], axis=-1)
"""A circle of a metre about the origin, x and z."""


@dataclass(frozen=True)
class Camera:
    """Where the floor is seen from: looks at ``centre`` from ``distance`` metres; angles in radians."""

    centre: tuple[float, float, float]
    azimuth: float
    """Of the camera about +y, from +z."""
    elevation: float
    distance: float

    def project(self, points: Array) -> Array:
        """Points of the world (..., 3) on paper, across and up, metres at the distance of the centre: shape (..., 2)."""
        across, up, towards = self._axes(points)
        scale = self.distance / np.maximum(self.distance - towards, 0.1 * self.distance)
        return np.stack([across * scale, up * scale], axis=-1)

    def nearness(self, points: Array) -> Array:
        """Metres towards the camera from the centre: shape (...)."""
        return self._axes(points)[2]

    def _axes(self, points: Array) -> tuple[Array, Array, Array]:
        away = points - np.asarray(self.centre)
        cos, sin = np.cos(self.azimuth), np.sin(self.azimuth)
        across = cos * away[..., 0] - sin * away[..., 2]
        ahead = sin * away[..., 0] + cos * away[..., 2]
        cos, sin = np.cos(self.elevation), np.sin(self.elevation)
        return across, cos * away[..., 1] - sin * ahead, cos * ahead + sin * away[..., 1]


def trail_plot(
    motion: Motion,
    *,
    target: ArrayLike | None = None,
    radius: float = 0.5,
    route: ArrayLike | None = None,
    every: float | None = None,
    title: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The way of the body over the floor, in blue, with stick figures along it ([Schultz2012] Figure 82).

    Seen from beside the way, which runs to the right. Left limbs red, right limbs blue. A tile of the floor is a metre wide; on
    floors of more than forty metres 2, 5, 10, … metres. Where the way is so long that figures would be too small to be made out,
    they are drawn larger than the floor. Both are said below the picture.

    Parameters
    ----------
    target : x, z in metres: a ring of ``radius`` metres on the floor; or several, shape (n, 2).
    route : corners of the line that was to be followed, shape (n, 2), x and z in metres.
    every : seconds between figures; chosen for a dozen figures unless given. Where the body stays in one place only the first of
        them is drawn.
    ax : where to draw; a new figure without.

    Raises
    ------
    InputError
        If ``target`` or ``route`` has another shape or is not finite, or ``every`` or ``radius`` is not positive.
    """
    places = np.zeros((0, 2)) if target is None else np.atleast_2d(_points(target, "target", 1))
    line = None if route is None else _points(route, "route", 2)
    for name, value in (("every", every), ("radius", radius)):
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise InputError(f"Expected `{name}` above 0, got {value}.")
    trail = motion.root_positions[:, [0, 2]]
    things = np.concatenate([trail, *([] if line is None else [line]), *(place + radius * _RING for place in places)])
    camera = _camera(things, trail)
    floor = _floor(camera, things)
    inches = _PAPER / float(np.ptp(camera.project(floor.corners)[:, 0]))
    larger = next((n for n in _LARGER if n * _STATURE * inches >= _LEAST_FIGURE), _LARGER[-1])
    step, frames = _frames(motion, trail, every, larger * _APART)
    figures = _enlarged(_figures(motion, frames), trail[frames], larger)
    least, most = _extent(camera, floor, figures)
    titled = [] if title is None else canvas.title_lines(title, _PAPER, _TITLE_SIZE, most=_TITLE_LINES)
    if ax is None:
        wide, high = most - least
        height = _PAPER * float(high / wide)
        paper = (_PAPER + 0.2, height + 0.75 + 0.18 * max(0, len(titled) - 1))
        ax = canvas.own_axes(*paper, rect=(0.1 / paper[0], 0.3 / paper[1], _PAPER / paper[0], height / paper[1]))
    ax.set_aspect("equal", adjustable="box")
    ax.set_xlim(least[0], most[0])
    ax.set_ylim(least[1], most[1])
    ax.set_axis_off()
    _draw_floor(ax, camera, floor)
    if line is not None:
        _draw_line(ax, camera, _finely(line), color=GOAL, linewidth=2.2, linestyle=(0, (4, 2.5)), zorder=2.0)
    for place in places:
        _draw_target(ax, camera, place, radius)
    begin = camera.project(_on_floor(trail[:1]))
    ax.plot(
        begin[:, 0], begin[:, 1], marker="o", markersize=9, color="white", markeredgecolor=TRAIL, mew=2.2, zorder=3.2
    )
    _draw_line(ax, camera, trail, color=TRAIL, linewidth=2.8, solid_capstyle="round", zorder=3.0)
    dots_apart = next((t for t in _DOT_STEPS if motion.duration <= t * _MOST_DOTS), _DOT_STEPS[-1])
    seconds = np.arange(0.0, motion.duration, dots_apart)
    dots = camera.project(_on_floor(trail[np.minimum(np.round(seconds * motion.fps).astype(int), len(trail) - 1)]))
    ax.plot(dots[:, 0], dots[:, 1], linestyle="", marker="o", markersize=3.2, color=TRAIL, zorder=3.1)
    _draw_figures(ax, camera, figures)
    said = (
        f"From the ring on: a figure every {step:g} s where there is room"
        f"{'' if larger == 1.0 else f', drawn {larger:g} times too large'}, a dot every "
        f"{'second' if dots_apart == 1.0 else f'{dots_apart:g} s'}; a tile is "
        f"{'a metre' if floor.tile == 1.0 else f'{floor.tile:g} metres'} wide."
    )
    ax.text(
        0.004, -0.01, said, transform=ax.transAxes, fontsize=8.5, color=canvas.INK, ha="left", va="top", clip_on=False
    )
    if title is not None:
        ax.set_title("\n".join(titled), fontsize=_TITLE_SIZE, loc="left", color=canvas.INK, parse_math=False)
    return ax


def _points(values: ArrayLike, name: str, least: int) -> Array:
    """A place, x and z, if one dimension is enough, or several, shape (n, 2)."""
    try:
        points = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        points = np.zeros(0)
    if not least <= points.ndim <= 2 or points.shape[-1:] != (2,) or not np.isfinite(points).all() or not points.size:
        expected = "x, z, or several places of shape (n, 2)," if least == 1 else "shape (n, 2)"
        raise InputError(f"Expected `{name}` as {expected} in metres, got {values!r}.")
    return points


def _frames(motion: Motion, trail: Array, every: float | None, apart: float) -> tuple[float, list[int]]:
    """At which frames the body is drawn: regularly, but not where it stands on itself, ``apart`` metres from another."""
    step = every
    if step is None:
        # as many steps as figures fit along the way; at least a second of standing is one figure
        length = float(np.hypot(*np.diff(trail, axis=0).T).sum()) if len(trail) > 1 else 0.0
        many = min(_MOST_FIGURES, max(1.0, length / apart))
        step = next((s for s in _STEPS if motion.duration / s <= many), _STEPS[-1])
    times = np.arange(0.0, motion.duration - 0.5 / motion.fps, step)
    wanted = np.minimum(np.round(times * motion.fps).astype(int), motion.frame_count - 1).tolist()
    # the last frame tells where it ends
    wanted.append(motion.frame_count - 1)
    chosen: list[int] = []
    for frame in (wanted[0], wanted[-1], *wanted[1:-1]):
        away = [np.hypot(*(trail[frame] - trail[other])) for other in chosen]
        if not away or min(away) >= apart:
            chosen.append(frame)
    return float(step), sorted(chosen)


def _camera(things: Array, trail: Array) -> Camera:
    """From beside the way, so that it runs across the picture, from left to right."""
    middle = 0.5 * (things.min(axis=0) + things.max(axis=0))
    size = float(max(np.ptp(things, axis=0).max(), 2.0))
    spread = np.cov(things.T) if len(things) > 1 else np.zeros((2, 2))
    values, axes = np.linalg.eigh(spread)
    along = axes[:, 1] if values[1] > 1e-6 else np.array([0.0, 1.0])
    if (trail[-1] - trail[0]) @ along < 0.0:
        along = -along
    # across the picture is (cos, −sin) of the azimuth in x, z
    azimuth = float(np.arctan2(-along[1], along[0]))
    round_ = float(np.sqrt(max(values[0], 0.0) / values[1])) if values[1] > 1e-6 else 0.0
    elevation = np.radians(24.0 + 16.0 * min(1.0, round_))
    return Camera((float(middle[0]), 0.5, float(middle[1])), azimuth, float(elevation), 2.0 * size + 5.0)


def _on_floor(points: Array) -> Array:
    """x, z (..., 2) as points of the world (..., 3)."""
    return np.stack([points[..., 0], np.zeros(points.shape[:-1]), points[..., 1]], axis=-1)


def _finely(corners: Array) -> Array:
    """Points every decimetre along a line of straight pieces: perspective bends nothing, but dashes want it."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    at = np.linspace(0.0, along[-1], max(2, int(along[-1] / 0.1)))
    return np.stack([np.interp(at, along, corners[:, k]) for k in range(2)], axis=-1)


class _Floor(NamedTuple):
    """A rectangle of whole tiles whose front runs across the picture."""

    along: Array
    """Unit vectors, x and z, shape (2, 2): across the picture to the right, and away from the viewer."""
    low: Array
    high: Array
    tile: float
    """Metres."""

    def point(self, across: float, away: float) -> Array:
        return _on_floor(across * self.along[0] + away * self.along[1])

    @property
    def corners(self) -> Array:
        (a, c), (b, d) = self.low.tolist(), self.high.tolist()
        return np.stack([self.point(*p) for p in ((a, c), (b, c), (b, d), (a, d))])


def _floor(camera: Camera, things: Array) -> _Floor:
    cos, sin = np.cos(camera.azimuth), np.sin(camera.azimuth)
    along = np.array([[cos, -sin], [-sin, -cos]])
    places = things @ along.T
    # whole tiles about the middle
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
    size = np.ptp(places, axis=0) + 2.0 * _MARGIN
    size = np.maximum(size, [_LEAST_FLOOR, _DEPTH * size[0]])
    tile = next((t for t in _TILES if size.max() <= t * _MOST_TILES), _TILES[-1])
    half = 0.5 * tile * np.ceil(size / tile - 1e-9)
    return _Floor(along, middle - half, middle + half, tile)


def _extent(camera: Camera, floor: _Floor, figures: _Figures) -> tuple[Array, Array]:
    """Left below and right above of all that is drawn, on paper."""
    head = figures.heads + np.array([0.0, 1.3 * figures.radius, 0.0])
    points = np.concatenate([camera.project(p).reshape(-1, 2) for p in (floor.corners, figures.bones, head)])
    margin = 0.004 * float(np.ptp(points[:, 0]))
    return points.min(axis=0) - margin, points.max(axis=0) + margin


def _draw_floor(ax: Axes, camera: Camera, floor: _Floor) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Polygon

    ax.add_patch(Polygon(camera.project(floor.corners), closed=True, facecolor=FLOOR, edgecolor="none", zorder=0.5))
    (a, c), (b, d) = floor.low.tolist(), floor.high.tolist()
    step = floor.tile
    lines = [camera.project(np.stack([floor.point(x, c), floor.point(x, d)])) for x in np.arange(a, b + 0.01, step)]
    lines += [camera.project(np.stack([floor.point(a, z), floor.point(b, z)])) for z in np.arange(c, d + 0.01, step)]
    ax.add_collection(LineCollection(lines, colors=TILE, linewidths=0.8, zorder=0.6), autolim=False)


def _draw_line(ax: Axes, camera: Camera, points: Array, **how: Any) -> None:
    seen = camera.project(_on_floor(points))
    ax.plot(seen[:, 0], seen[:, 1], **how)


def _draw_target(ax: Axes, camera: Camera, goal: Array, radius: float) -> None:
    from matplotlib.patches import Polygon

    for share, alpha in ((1.0, 0.18), (0.25, 1.0)):
        disc = camera.project(_on_floor(goal + share * radius * _RING))
        ax.add_patch(Polygon(disc, closed=True, facecolor=GOAL, edgecolor="none", alpha=alpha, zorder=1.4))
    _draw_line(ax, camera, goal + radius * _RING, color=GOAL, linewidth=1.8, zorder=1.5)


class _Figures(NamedTuple):
    bones: Array
    """In the world, shape (frames, bones, 2, 3)."""
    sides: Sequence[str]
    widths: Sequence[float]
    heads: Array
    """Middle of the head, shape (frames, 3)."""
    radius: float


def _figures(motion: Motion, frames: Sequence[int]) -> _Figures:
    """The bones as `stick_figures` draws them, in the world."""
    motion, body = stick_figures.with_anatomy(motion)
    index = np.asarray(frames)
    picked = motion.replace(
        rotations=motion.rotations[index],
        root_positions=motion.root_positions[index],
        joint_translations=None if motion.joint_translations is None else motion.joint_translations[index],
    )
    skeleton = motion.skeleton
    tips, parents = stick_figures.tips_of(picked)
    sides = stick_figures.sides_of(skeleton, body)
    fine = stick_figures.beyond_hands_and_feet(skeleton, body)
    drawn = stick_figures.descendants_of(skeleton, [0 if body is None else body.pelvis])
    long = np.linalg.norm(tips - tips[:, parents], axis=-1).max(axis=0) > stick_figures.SHORTEST_BONE
    ends = [j for j, p in enumerate(parents) if p >= 0 and drawn[p] and long[j]]
    owner = [j if j < skeleton.joint_count else parents[j] for j in range(len(parents))]
    head = stick_figures.head_of(skeleton, body)
    if head is None or body is None:
        heads, radius = tips[:, 0], 0.0
    else:
        base, tip = tips[:, head[0]], tips[:, head[1]]
        radius = stick_figures.head_radius_of(skeleton, body)
        length = np.linalg.norm(tip - base, axis=-1, keepdims=True)
        unit = np.where(length > 1e-9, (tip - base) / np.maximum(length, 1e-9), [0.0, 1.0, 0.0])
        heads = base + unit * np.maximum(0.5 * length, radius)
    return _Figures(
        np.stack([tips[:, [parents[j] for j in ends]], tips[:, ends]], axis=2),
        [sides[parents[j] if j >= skeleton.joint_count else j] for j in ends],
        [0.45 if fine[owner[j]] else 1.0 for j in ends],
        heads,
        radius,
    )


def _enlarged(figures: _Figures, places: Array, times: float) -> _Figures:
    """Figures so many times as large, each about its place on the floor: x, z in metres, shape (frames, 2)."""
    here = _on_floor(places)
    return figures._replace(
        bones=here[:, None, None] + times * (figures.bones - here[:, None, None]),
        heads=here + times * (figures.heads - here),
        radius=times * figures.radius,
    )


def _draw_figures(ax: Axes, camera: Camera, figures: _Figures) -> None:
    """Shadows, then bodies from the farthest to the nearest."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Ellipse
    from matplotlib.patheffects import Normal, Stroke

    seen = camera.project(figures.bones)
    shadows = camera.project(figures.bones * [1.0, 0.0, 1.0])
    ink = {"left": canvas.LEFT, "right": canvas.RIGHT, "": canvas.INK}
    colours = [ink[side] for side in figures.sides]
    widths = np.asarray(figures.widths)
    ax.add_collection(
        LineCollection(
            list(shadows.reshape(-1, 2, 2)),
            colors=SHADOW,
            linewidths=np.tile(2.4 * widths, len(figures.heads)),
            capstyle="round",
            zorder=1.0,
        ),
        autolim=False,
    )
    for rank, k in enumerate(np.argsort(camera.nearness(figures.heads), kind="stable").tolist()):
        level = 4.0 + 0.01 * rank
        # limbs that are farther away behind the others
        order = np.argsort(camera.nearness(figures.bones[k].mean(axis=1)), kind="stable")
        lines = LineCollection(
            list(seen[k][order]),
            colors=[colours[b] for b in order],
            linewidths=2.1 * widths[order],
            capstyle="round",
            zorder=level,
        )
        halo = LineCollection(
            list(seen[k]), colors="white", linewidths=2.1 * widths + 1.8, capstyle="round", zorder=level - 0.004
        )
        for collection in (halo, lines):
            ax.add_collection(collection, autolim=False)
        if figures.radius > 0.0:
            centre = camera.project(figures.heads[k])
            size = float(2.0 * figures.radius * camera.distance / (camera.distance - camera.nearness(figures.heads[k])))
            head = Ellipse(
                (float(centre[0]), float(centre[1])), size, size, facecolor="white", edgecolor=canvas.INK, linewidth=1.7
            )
            head.set_zorder(level + 0.004)
            head.set_path_effects([Stroke(linewidth=3.2, foreground="white"), Normal()])
            ax.add_artist(head)
