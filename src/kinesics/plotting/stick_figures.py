"""Stick figures: one moment, or a path as overlaid moments that fade ([Schultz2012] Figures 21 and 64-71).

A pose is intrinsic (§2.8), so a figure is turned to face one way and stands on one spot: what moves is the body itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body import anatomy
from kinesics.body.pose import poses
from kinesics.errors import InputError, SkeletonError
from kinesics.plotting import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.path import Path

    from kinesics.body.motion import Motion
    from kinesics.body.skeleton import Skeleton

Array = NDArray[np.float64]
View = Literal["front", "side", "three-quarter"]

_CAMERAS: Final[dict[str, tuple[float, float]]] = {
    # azimuth of the camera about +y from the front, and elevation, degrees. "side" sees the right side: the subject
    # then faces to the right, as time runs
    "front": (0.0, 0.0),
    "side": (-90.0, 0.0),
    "three-quarter": (-35.0, 8.0),
}

SHORTEST_BONE: Final = 1e-6
"""Metres: what is shorter in every frame drawn is no stroke."""


class Strokes(NamedTuple):
    """Bones on paper."""

    segments: Array
    """Start and end of each bone, metres, shape (frames, bones, 2, 2): the last axis is across, up."""
    sides: tuple[str, ...]
    """"left", "right" or "" for each bone."""
    widths: tuple[float, ...]
    """Relative line widths: fingers are thin."""
    head_centres: Array
    """Shape (frames, 2)."""
    head_radius: float
    """Metres."""
    limbs: tuple[tuple[int, ...], ...]
    """Bones of one side and width that run on from one another: each is drawn in one stroke."""


def stick_figure(
    motion: Motion,
    frame: int,
    *,
    view: View = "three-quarter",
    turned: bool = True,
    ax: Axes | None = None,
) -> Axes:
    """The body at one moment; left limbs red, right limbs blue.

    Parameters
    ----------
    frame : counted from 0; negative from the end.
    view : "front", "side" (of the right side, facing right) or "three-quarter".
    turned : face the camera's front whatever the heading; False shows the body as it stands in the world.
    ax : where to draw; a new figure without.

    Raises
    ------
    InputError
        If there is no such frame, or the view is unknown.
    """
    if not -motion.frame_count <= frame < motion.frame_count:
        raise InputError(f"No frame {frame} in a motion of {motion.frame_count} frames.")
    if ax is None:
        ax = canvas.own_axes(3.2, 4.2, rect=(0.02, 0.02, 0.96, 0.96))
    strokes = compute_strokes(motion, [frame % motion.frame_count], view=view, turned=turned)
    draw_figures(ax, [Placed(strokes, 0, (0.0, 0.0), (1.0, 1.0), line_width=3.0)])
    _frame_figures(ax)
    return ax


def stick_figure_row(
    motion: Motion,
    frames: ArrayLike,
    *,
    overlap_frames: int = 0,
    trail: int = 2,
    view: View = "three-quarter",
    spread: Literal["even", "time"] = "even",
    ax: Axes | None = None,
) -> Axes:
    """A row of figures; with ``overlap_frames`` each is Ψ(t) and, fading, what follows it (Figure 21).

    Parameters
    ----------
    frames : of the figures, shape (n,).
    overlap_frames : step between overlaid moments; 0 overlays none.
    trail : moments overlaid in one figure: 2 shows Ψ(t) and Ψ(t + Δ), more a path that lightens as it evolves (§3.5).
    spread : "even", or "time": each figure stands at its own time on an axis from 0 to the length of the motion.
    ax : where to draw; a new figure without.

    Raises
    ------
    InputError
        If a frame does not exist.
    """
    chosen = np.atleast_1d(np.asarray(frames, dtype=np.intp))
    if chosen.ndim != 1 or chosen.size == 0 or chosen.min() < 0 or chosen.max() >= motion.frame_count:
        raise InputError(f"Expected frames within [0, {motion.frame_count}), got {chosen.tolist()}.")
    if ax is None:
        ax = canvas.own_axes(max(2.0, 0.9 * len(chosen)), 2.2, rect=(0.01, 0.02, 0.98, 0.96))
    layers = max(1, trail) if overlap_frames > 0 else 1
    shown = np.minimum(chosen[:, None] + overlap_frames * np.arange(layers), motion.frame_count - 1)
    unique, place = np.unique(shown, return_inverse=True)
    place = place.reshape(shown.shape)
    strokes = compute_strokes(motion, unique, view=view)
    places = chosen / motion.frame_count if spread == "time" else (np.arange(len(chosen)) + 0.5) / len(chosen)
    # one scale for all: as high as the tallest figure, no wider than the space between two
    points = strokes.segments.reshape(-1, 2)
    low, high = points[:, 1].min(), max(points[:, 1].max(), (strokes.head_centres[:, 1] + strokes.head_radius).max())
    widest = max(0.5, 2.0 * np.abs(points[:, 0]).max())
    room = float(np.diff(np.sort(places)).min()) if len(places) > 1 else 1.0
    pixels = canvas.pixel_size(ax)
    height = min(0.96 * pixels[1], (high - low) / widest * 1.3 * room * pixels[0]) if high > low else pixels[1]
    metre = height / max(high - low, 1e-9)  # pixels
    across, up = metre / pixels[0], metre / pixels[1]
    line_width = float(np.clip(0.0125 * height * 72.0 / ax.figure.dpi, 0.7, 3.0))
    strengths = [1.0 if layers == 1 else 1.0 - 0.62 * layer / (layers - 1) for layer in range(layers)]
    draw_figures(
        ax,
        [
            Placed(strokes, int(rows[layer]), (float(spot), -low * up), (across, up), line_width, strengths[layer])
            for spot, rows in zip(places, place, strict=True)
            for layer in reversed(range(layers))
        ],
    )
    ax.set_xlim(0.0, 1.0)
    ax.set_ylim(-0.03, 1.03)
    ax.set_axis_off()
    return ax


def compute_strokes(motion: Motion, frames: ArrayLike, *, view: View = "three-quarter", turned: bool = True) -> Strokes:
    """The bones of some frames projected onto paper, the pelvis above the origin.

    Raises
    ------
    InputError
        If the view is unknown.
    """
    if view not in _CAMERAS:
        raise InputError(f"No view is called '{view}'. Views: {', '.join(_CAMERAS)}.")
    azimuth, elevation = np.deg2rad(_CAMERAS[view])
    motion, body = with_anatomy(motion)
    index = np.asarray(frames, dtype=np.intp)
    picked = motion.replace(
        rotations=motion.rotations[index],
        root_positions=motion.root_positions[index],
        joint_translations=None if motion.joint_translations is None else motion.joint_translations[index],
    )
    skeleton = motion.skeleton
    tips, parents = tips_of(picked)
    points = tips - tips[:, [0 if body is None else body.pelvis]] * np.array([1.0, 0.0, 1.0])
    turn = azimuth + (poses(picked).yaw if turned and body is not None else np.zeros(len(index)))
    cos, sin = np.cos(turn)[:, None], np.sin(turn)[:, None]
    across = cos * points[..., 0] - sin * points[..., 2]
    towards = sin * points[..., 0] + cos * points[..., 2]
    up = np.cos(elevation) * points[..., 1] - np.sin(elevation) * towards
    flat = np.stack([across, up], axis=-1)
    sides = sides_of(skeleton, body)
    # what leads to the pelvis is no bone, nor is what else hangs there: a rig's node on the floor may stay behind while the
    # body walks away; and what has no length is a joint that a converter put into another
    drawn = descendants_of(skeleton, [0 if body is None else body.pelvis])
    lengths = np.linalg.norm(tips - tips[:, parents], axis=-1).max(axis=0)
    hung = [j for j, p in enumerate(parents) if p >= 0 and drawn[p]]
    # a body of no size at all is a point, and is drawn as one
    ends = [j for j in hung if lengths[j] > SHORTEST_BONE] or hung
    starts = [parents[j] for j in ends]
    fine = beyond_hands_and_feet(skeleton, body)
    head = head_of(skeleton, body)
    if head is not None and body is not None:
        base, tip = head
        radius = head_radius_of(skeleton, body)
        direction = flat[:, tip] - flat[:, base]
        length = np.linalg.norm(direction, axis=-1, keepdims=True)
        unit = np.where(length > 1e-9, direction / np.maximum(length, 1e-9), np.array([0.0, 1.0]))
        centres = flat[:, base] + unit * np.maximum(length * 0.5, radius)
    else:
        radius, centres = 0.0, flat[:, 0]
    side_of = tuple(sides[parents[j]] if j >= skeleton.joint_count else sides[j] for j in ends)
    widths = tuple(0.45 if fine[j if j < skeleton.joint_count else parents[j]] else 1.0 for j in ends)
    return Strokes(
        segments=np.stack([flat[:, starts], flat[:, ends]], axis=2),
        sides=side_of,
        widths=widths,
        head_centres=centres,
        head_radius=float(radius),
        limbs=_limbs(starts, ends, list(zip(side_of, widths, strict=True))),
    )


def strokes_of(parts: Sequence[tuple[Motion, ArrayLike]], *, view: View = "three-quarter") -> list[Strokes]:
    """As `compute_strokes`, of several motions and frames of each: what is of one motion is computed at once."""
    wanted = [np.asarray(frames, dtype=np.intp) for _, frames in parts]
    of_motion: dict[int, list[int]] = {}
    for number, (motion, _) in enumerate(parts):
        of_motion.setdefault(id(motion), []).append(number)
    found: dict[int, Strokes] = {}
    for numbers in of_motion.values():
        together = compute_strokes(parts[numbers[0]][0], np.concatenate([wanted[k] for k in numbers]), view=view)
        ends = np.cumsum([0, *(len(wanted[k]) for k in numbers)])
        for k, start, end in zip(numbers, ends, ends[1:], strict=False):
            found[k] = together._replace(
                segments=together.segments[start:end], head_centres=together.head_centres[start:end]
            )
    return [found[k] for k in range(len(parts))]


def _limbs(starts: Sequence[int], ends: Sequence[int], looks: Sequence[object]) -> tuple[tuple[int, ...], ...]:
    """Bones, given by the joints they lead from and to, in chains of one look."""
    chains: list[list[int]] = []
    growing: dict[tuple[int, object], list[int]] = {}
    for bone, (start, end, look) in enumerate(zip(starts, ends, looks, strict=True)):
        chain = growing.pop((start, look), None)
        if chain is None:
            chain = []
            chains.append(chain)
        chain.append(bone)
        growing[end, look] = chain
    return tuple(tuple(chain) for chain in chains)


def with_anatomy(motion: Motion) -> tuple[Motion, anatomy.Anatomy | None]:
    """The motion with its anatomy attached; without where the skeleton is no human body: bones can be drawn all the same."""
    try:
        known = anatomy.understood(motion)
    except SkeletonError:
        return motion, None
    return known, anatomy.resolve(known)


def tips_of(motion: Motion) -> tuple[Array, list[int]]:
    """Joints followed by end sites: positions (frames, joints + sites, 3) and the parent of each."""
    from kinesics.body import kinematics
    from kinesics.geometry import quaternion

    skeleton = motion.skeleton
    where = kinematics.forward(skeleton, motion.rotations, motion.root_positions, motion.joint_translations)
    parents = list(skeleton.parents) + [site.parent for site in skeleton.end_sites]
    sites = [
        where.positions[:, site.parent] + quaternion.rotate(where.rotations[:, site.parent], np.array(site.offset))
        for site in skeleton.end_sites
    ]
    return np.concatenate([where.positions, *(s[:, None] for s in sites)], axis=1), parents


def descendants_of(skeleton: Skeleton, roots: Sequence[int | None]) -> list[bool]:
    """Whether each joint is one of ``roots`` or hangs on one."""
    wanted = {r for r in roots if r is not None}
    out: list[bool] = []
    for j, parent in enumerate(skeleton.parents):
        out.append(j in wanted or (parent >= 0 and out[parent]))
    return out


def sides_of(skeleton: Skeleton, body: anatomy.Anatomy | None) -> list[str]:
    """Which side of the body each joint belongs to."""
    if body is None:
        return [""] * skeleton.joint_count
    roles = body.roles
    left = descendants_of(skeleton, [roles.left_femur, roles.left_humerus, *roles.left_clavicle])
    right = descendants_of(skeleton, [roles.right_femur, roles.right_humerus, *roles.right_clavicle])
    return ["left" if a else "right" if b else "" for a, b in zip(left, right, strict=True)]


def beyond_hands_and_feet(skeleton: Skeleton, body: anatomy.Anatomy | None) -> list[bool]:
    """Whether each joint is a finger or a toe."""
    if body is None:
        return [False] * skeleton.joint_count
    roles = body.roles
    extremities = [j for j in (roles.left_hand, roles.right_hand) if j is not None]
    return [beyond and j not in extremities for j, beyond in enumerate(descendants_of(skeleton, extremities))]


def head_of(skeleton: Skeleton, body: anatomy.Anatomy | None) -> tuple[int, int] | None:
    """Base and tip of the head among joints and end sites."""
    if body is None:
        return None
    for number, site in enumerate(skeleton.end_sites):
        if site.parent == body.head and np.linalg.norm(site.offset) > 1e-6:
            return body.head, skeleton.joint_count + number
    parent = skeleton.parents[body.head]
    return (parent, body.head) if parent >= 0 else None


def head_radius_of(skeleton: Skeleton, body: anatomy.Anatomy) -> float:
    """Half the height of a head, metres: .13 of the stature, of which the thigh is .245 (Drillis & Contini 1966)."""
    thigh = float(np.linalg.norm(skeleton.offsets[body.roles.left_tibia]))
    return 0.5 * 0.13 / 0.245 * thigh


class Placed(NamedTuple):
    """A figure and where it goes."""

    strokes: Strokes
    row: int
    """Which of the frames of ``strokes``."""
    origin: tuple[float, float]
    """Where the pelvis' ground point goes, in the units of the axes."""
    scale: tuple[float, float]
    """How long a metre is, across and up, in the units of the axes."""
    line_width: float
    """Points."""
    strength: float = 1.0
    """1 full ink, 0 paper."""
    grey: bool = False
    """Both sides of the body in black ink."""


def draw_figures(ax: Axes, figures: Sequence[Placed]) -> None:
    """Figures, those that come later over the earlier ones, and all heads over the lines.

    All lines are one collection and all heads another: a page has hundreds of figures, and matplotlib takes longer to make an
    artist than to draw it.
    """
    from matplotlib.collections import PathCollection

    lines: list[_Look] = []
    heads: list[_Look] = []
    for figure in figures:
        lines += _lines_of(figure)
        heads += _head_of(figure)
    for looks, zorder in ((lines, 2.0), (heads, 2.1)):
        if looks:
            drawn = PathCollection(
                [look.path for look in looks],
                facecolors="none" if looks is lines else "white",
                edgecolors=[look.ink for look in looks],
                linewidths=[look.width for look in looks],
                capstyle="round",
                joinstyle="round",
                zorder=zorder,
            )
            # what it covers is known: matplotlib takes long to find out
            ax.add_collection(drawn, autolim=False)
            ax.update_datalim(np.concatenate([look.path.vertices for look in looks]))


class _Look(NamedTuple):
    path: Path
    ink: Array
    """Red, green and blue."""
    width: float


def _lines_of(figure: Placed) -> list[_Look]:
    """Each limb, or all in one where they have one ink."""
    from matplotlib.path import Path

    strokes = figure.strokes
    bones = strokes.segments[figure.row] * figure.scale + figure.origin
    lines = [np.concatenate([bones[limb[0], :1], bones[list(limb), 1]]) for limb in strokes.limbs]
    firsts = [limb[0] for limb in strokes.limbs]
    width = figure.line_width
    if not figure.grey:
        ink = {"left": canvas.LEFT, "right": canvas.RIGHT, "": canvas.INK}
        return [
            _Look(Path(line), _faded(ink[strokes.sides[k]], figure.strength), width * strokes.widths[k])
            for line, k in zip(lines, firsts, strict=True)
        ]
    together: dict[float, list[Array]] = {}
    for line, k in zip(lines, firsts, strict=True):
        together.setdefault(strokes.widths[k], []).append(line)
    ink_now = _faded(canvas.INK, figure.strength)
    return [
        _Look(Path(np.concatenate(those), _codes([len(line) for line in those])), ink_now, width * share)
        for share, those in together.items()
    ]


def _head_of(figure: Placed) -> list[_Look]:
    """One, or none where the head is not known."""
    from matplotlib.path import Path

    strokes = figure.strokes
    if strokes.head_radius <= 0.0:
        return []
    centre = strokes.head_centres[figure.row] * figure.scale + figure.origin
    circle = Path.unit_circle()
    path = Path(np.asarray(circle.vertices) * (strokes.head_radius * np.asarray(figure.scale)) + centre, circle.codes)
    return [_Look(path, _faded(canvas.INK, figure.strength), figure.line_width)]


def _codes(lengths: Sequence[int]) -> NDArray[np.uint8]:
    """Of a path of several lines: what is done at each of its points."""
    from matplotlib.path import Path

    codes = np.full(sum(lengths), Path.LINETO, dtype=np.uint8)
    codes[np.cumsum([0, *lengths[:-1]])] = Path.MOVETO
    return codes


def _faded(colour: str, strength: float) -> Array:
    """Ink mixed with paper rather than transparent: overlaid lines then do not add up to dark spots."""
    from matplotlib.colors import to_rgb

    return 1.0 - strength * (1.0 - np.array(to_rgb(colour)))


def _frame_figures(ax: Axes) -> None:
    """Equal scales, no axes."""
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.margins(0.06)
    ax.set_axis_off()
