"""The dissertation's short and complex motion studies, remade: pictures beside what the text says they must look like.

    python gallery/make.py [--data FOLDER] [--only NAME …]

writes one PNG for each study and README.md into this folder. Recordings are read from FOLDER, $KINESICS_DATA or ``../shared/data``
beside the project; where they are absent those studies are left as they are and named on the last line. The synthetic performer
needs no data.
"""

from __future__ import annotations

import argparse
import dataclasses
import io
import os
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import kinesics as kx
from kinesics import performer, plotting
from kinesics.body.contacts import runs
from kinesics.grammar.graph import MotionGraph, State, build
from kinesics.grammar.graph import Path as GraphPath
from kinesics.plotting.canvas import INK, figure_bytes
from kinesics.plotting.similarity_plots import colour_key
from kinesics.plotting.stick_figures import View

HERE = Path(__file__).resolve().parent
CREDIT = (
    "The data used in this project was obtained from mocap.cs.cmu.edu. "  # CMU asks for these words
    "The database was created with funding from NSF EIA-0196217."
)
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Finding:
    """One expectation of the text, measured."""

    expected: str
    measured: str
    agrees: bool


@dataclass(frozen=True, eq=False)
class Measured:
    """Everything that the checks look at."""

    analysis: kx.Analysis
    d: Array
    """D of all pairs, divided by the distance at which the picture is nearly black (Z = .05), shape (n, n)."""
    d_mirror: Array
    fps: float

    @property
    def on_axis(self) -> Array:
        """D*(a, a) in the same unit, shape (n,)."""
        return np.diagonal(self.d_mirror)

    def along(self, lag: int, *, mirrored: bool = False) -> float:
        """Median along the diagonal at a lag in frames: near 0 where the stripe is bright."""
        return float(np.median(np.diagonal(self.d_mirror if mirrored else self.d, lag)))

    def period(self, low_s: float, high_s: float) -> int:
        """The lag in frames, within bounds in seconds, at which the movement is most like itself."""
        lags = range(round(low_s * self.fps), min(round(high_s * self.fps), int(0.7 * len(self.d))))
        return min(lags, key=self.along)

    def mirror_lag(self, period: int) -> int:
        """The lag within one period at which the movement is most like its mirror image."""
        return min(range(period + 1), key=lambda lag: self.along(lag, mirrored=True))

    def reversal(self, period: int, *, mirrored: bool = False) -> float:
        """The brightest line at right angles to the identity axis, half a period long either way: its median."""
        matrix = self.d_mirror if mirrored else self.d
        half = period // 2
        steps = np.arange(2, half)
        return min(float(np.median(matrix[c - steps, c + steps])) for c in range(half, len(matrix) - half))


@dataclass(frozen=True, eq=False)
class Study:
    """One picture and its text."""

    name: str
    title: str
    section: str
    source: str
    text: str
    """What the dissertation says the picture shows."""
    remark: str = dataclasses.field(default="", kw_only=True)
    """Ours, where the two do not agree."""
    read: Callable[[Path | None], kx.Motion]
    check: Callable[[Measured], Iterable[Finding]]
    view: View = "three-quarter"
    figures_s: tuple[float, float] | None = None
    """From when to when the stick figures are taken; all of it without."""
    needs_data: bool = True
    graph: MotionGraph | None = dataclasses.field(default=None, kw_only=True)
    """What the text draws; None where it gives no graph that could be compared."""


def _pair(first: int) -> list[State]:
    """A chiral state and its mirror image."""
    return [State(first, mirror_of=first + 1), State(first + 1, mirror_of=first)]


def _symmetric_path(number: int, from_: int, to: int, *, reversible: bool = False) -> GraphPath:
    return GraphPath(number, from_=from_, to=to, reversible=reversible, symmetric=True)


def _image_paths(number: int, ends: tuple[int, int], images: tuple[int, int], *, reversible: bool) -> list[GraphPath]:
    """A path and its mirror image."""
    return [
        GraphPath(number, from_=ends[0], to=ends[1], reversible=reversible, mirror_of=number + 1),
        GraphPath(number + 1, from_=images[0], to=images[1], reversible=reversible, mirror_of=number),
    ]


BUTTERFLY = build([State(0, symmetric=True)], [_symmetric_path(0, 0, 0)])
JUMPING_JACKS = build([State(0, symmetric=True), State(1, symmetric=True)], [_symmetric_path(0, 0, 1, reversible=True)])
JOGGING = build([*_pair(0), State(2, symmetric=True)], _image_paths(0, (0, 2), (1, 2), reversible=True))
WALKING = build(_pair(0), _image_paths(0, (0, 1), (1, 0), reversible=False))
LIMPING = build([State(0)], [GraphPath(0, from_=0, to=0)])
SIDE_KICKS = build(
    [*_pair(0), State(2, symmetric=True)],
    [*_image_paths(0, (0, 0), (1, 1), reversible=False), *_image_paths(2, (0, 2), (1, 2), reversible=True)],
)
SUN_SALUTATION = build(
    [State(k, symmetric=True) for k in range(5)],  # Y X T W V, as the text meets them
    [
        *(_symmetric_path(k, k, k + 1, reversible=True) for k in range(3)),
        _symmetric_path(3, 0, 0),
        GraphPath(4, from_=3, to=4),
        _symmetric_path(5, 4, 4),
        _symmetric_path(6, 4, 3),
    ],
)


def _graph_of_the_text(study: Study, m: Measured) -> Iterable[Finding]:
    """Whether the graph that was read is the one that is drawn in the text, up to names."""
    if study.graph is None:
        return
    read = m.analysis.graph
    distance = read.edit_distance(study.graph)
    same = "the same graph" if distance.value == 0 else f"{_counted(distance.value, 'change')} away"
    shown = f"{_size(read)}: {same}"
    expected = f"the motion graph of the text: {_size(study.graph)}"
    yield Finding(expected, shown, distance.value == 0)


def _size(graph: MotionGraph) -> str:
    return f"{_counted(len(graph.states), 'state')}, {_counted(len(graph.paths), 'path')}"


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _clip(path: str, start: int | None = None, end: int | None = None) -> Callable[[Path | None], kx.Motion]:
    def read(data: Path | None) -> kx.Motion:
        if data is None or not (data / path).exists():
            raise FileNotFoundError(path)
        return kx.read(data / path)[start:end]

    return read


def _performed(name: str, **how: float) -> Callable[[Path | None], kx.Motion]:
    return lambda data: getattr(performer, name)(**how).motion


def _white_axis(m: Measured, most: float = 0.15) -> Finding:
    value = float(np.median(m.on_axis))
    return Finding(
        "the identity axis is white: every pose is symmetric", f"median D*(a, a) = {value:.2f}", value <= most
    )


def _stripes(m: Measured, low_s: float, high_s: float, most: float = 0.2) -> tuple[int, Finding]:
    period = m.period(low_s, high_s)
    value = m.along(period)
    return period, Finding(
        "lines parallel to the identity axis: the movement is cyclic",
        f"period {period / m.fps:.2f} s, median D along the line = {value:.2f}",
        value <= most,
    )


def _jumping_jacks(m: Measured) -> Iterable[Finding]:
    period, stripes = _stripes(m, 0.6, 2.5)
    yield Finding(
        "the plot is grey: Z and Z* agree everywhere",
        f"median difference of D and D* over all pairs = {np.median(np.abs(m.d - m.d_mirror)):.2f}",
        bool(np.median(np.abs(m.d - m.d_mirror)) <= 0.2),
    )
    yield _white_axis(m, 0.35)
    yield stripes
    value = m.reversal(period)
    yield Finding(
        "cross-hatching at right angles to the axis: the cycle is palindromic",
        f"median D along the best such line = {value:.2f}",
        value <= 0.2,
    )


def _jogging(m: Measured) -> Iterable[Finding]:
    period, stripes = _stripes(m, 0.5, 1.5)
    yield stripes
    lag = m.mirror_lag(period)
    yield Finding(
        "the cyan pattern is 180° out of phase with the red one",
        f"best lag of the mirror image / period = {lag / period:.2f}, median D* there = {m.along(lag, mirrored=True):.2f}",
        abs(lag / period - 0.5) <= 0.05 and m.along(lag, mirrored=True) <= 0.3,
    )
    back, mirrored = m.reversal(period), m.reversal(period, mirrored=True)
    yield Finding(
        "two palindromic crosshatch patterns, one red, one cyan",
        f"median D along the best line at right angles = {back:.2f}, D* = {mirrored:.2f}",
        max(back, mirrored) <= 0.3,
    )
    lows = _lows(m.on_axis, period // 2)
    yield Finding(
        "a white patch each half cycle: the same symmetric state is passed twice",
        f"D*(a, a) falls to {np.median(lows):.2f} (median of {len(lows)} half cycles), from {np.quantile(m.on_axis, 0.9):.2f}",
        bool(np.median(lows) <= 0.3),
    )


def _walking(m: Measured) -> Iterable[Finding]:
    period, stripes = _stripes(m, 0.7, 1.6)
    yield stripes
    lag = m.mirror_lag(period)
    yield Finding(
        "cyan stripes midway between the red ones",
        f"best lag of the mirror image / period = {lag / period:.2f}, median D* there = {m.along(lag, mirrored=True):.2f}",
        abs(lag / period - 0.5) <= 0.05 and m.along(lag, mirrored=True) <= 0.3,
    )
    back = m.reversal(period)
    yield Finding(
        "stripes only, no crosshatch: a walk is not palindromic",
        f"median D along the best line at right angles = {back:.2f}, {back / m.along(period):.0f} times that along the stripes",
        back >= 2.0 * m.along(period),
    )
    least = float(m.on_axis.min())
    yield Finding(
        "red and cyan never cross in white: no pose of a walk is symmetric",
        f"least D*(a, a) = {least:.2f}; along the stripe of Z* {m.along(lag, mirrored=True):.2f}",
        least >= 0.25,
    )


def _side_kicks(m: Measured) -> Iterable[Finding]:
    half = len(m.d) // 2
    first, second = slice(0, int(0.4 * len(m.d))), slice(int(0.6 * len(m.d)), None)
    moving = m.analysis.speed_curves[0] > np.median(m.analysis.speed_curves[0])
    across = m.d[first, second][moving[first]].min(axis=1), m.d_mirror[first, second][moving[first]].min(axis=1)
    yield Finding(
        "the kicks of one side are the mirror image of those of the other: cyan between them, not red",
        f"nearest moment on the other side, median over moving frames: D = {np.median(across[0]):.2f}, D* = "
        f"{np.median(across[1]):.2f}",
        bool(np.median(across[1]) < 0.6 * np.median(across[0])),
    )
    own = _nearest_apart(m.d[first, first], round(1.0 * m.fps))[moving[first]]
    yield Finding(
        "red stripes: each side repeats its kick",
        f"nearest moment at least 1 s away on the same side, median D = {np.median(own):.2f}",
        bool(np.median(own) <= 0.2),
    )
    middle = m.on_axis[half - round(0.15 * len(m.d)) : half + round(0.15 * len(m.d))]
    yield Finding(
        "white where the two regions meet: the change of facing passes a symmetric state",
        f"least D*(a, a) in the middle third = {middle.min():.2f}; median while kicking {np.median(m.on_axis[first]):.2f}",
        bool(middle.min() <= 0.3 < np.median(m.on_axis[first])),
    )


def _bassai(m: Measured) -> Iterable[Finding]:
    seconds = [(r.start / m.fps, r.end / m.fps) for r in m.analysis.symmetric_states if r.end - r.start >= 0.5 * m.fps]
    length = len(m.d) / m.fps
    said = ", ".join(f"{a:.1f}-{b:.1f} s" for a, b in seconds)
    yield Finding(
        "the one symmetric state is performed at the beginning, the middle and the end",
        f"symmetric for half a second or more at {said} of {length:.1f} s",
        len(seconds) == 3
        and seconds[0][0] < 1.0
        and 0.3 < sum(seconds[1]) / 2.0 / length < 0.7
        and seconds[2][1] > length - 1.0,
    )
    yield Finding(
        "mostly asymmetric movement",
        f"D*(a, a) is above {np.quantile(m.on_axis, 0.2):.2f} for four fifths of the time",
        bool(np.quantile(m.on_axis, 0.2) > 0.25),
    )
    speed = m.analysis.speed_curves[0]
    ratio = float(np.quantile(speed, 0.99) / np.median(speed))
    yield Finding(
        "a jagged identity axis: abrupt changes of momentum",
        f"fastest hundredth / median speed = {ratio:.1f}",
        ratio >= 4.0,
    )
    racemic = m.analysis.graph.racemic()
    parts = racemic.strongly_connected()
    yield Finding(
        "the racemised motion graph is fully connected",
        f"{len(racemic.states)} states; the largest part in which all reach all has {len(parts[0]) if parts else 0}",
        len(parts) == 1,
    )


def _butterfly(m: Measured) -> Iterable[Finding]:
    period, stripes = _stripes(m, 0.8, 2.5)
    yield _white_axis(m, 0.05)
    yield stripes
    value = m.reversal(period)
    yield Finding(
        "the lines are not connected: the path runs one way",
        f"median D along the best line at right angles = {value:.2f}",
        value >= 0.2,
    )


def _limping(m: Measured) -> Iterable[Finding]:
    period, stripes = _stripes(m, 0.8, 2.0)
    yield stripes
    lag = m.mirror_lag(period)
    value = m.along(lag, mirrored=True)
    yield Finding(
        "no signal from Z*: the two sides do not do the same",
        f"best median D* at any lag = {value:.2f}, against {m.along(period):.2f} along the red stripes",
        value >= 0.4,
    )


def _sun_salutation(m: Measured) -> Iterable[Finding]:
    truth = performer.sun_salutation(fps=m.fps).truth
    (asymmetric,) = (p for p in truth.paths if p.label.startswith("wv"))
    red = np.flatnonzero(m.on_axis > 0.15)
    inside = np.zeros(len(m.d), dtype=bool)
    for o in asymmetric.occurrences:
        inside[o.start : o.end] = True
    yield Finding(
        "no colour on the axis but where the legs go back one by one (path wv), twice",
        f"{inside[red].mean():.0%} of the frames with D*(a, a) > .15 are on that path; "
        f"elsewhere the greatest is {m.on_axis[~inside].max():.2f}",
        bool(len(red)) and bool(inside[red].mean() >= 0.95),
    )
    half = len(m.d) // 2
    yield Finding(
        "the sequence is performed twice",
        f"median D at half of the recording = {m.along(half):.2f}",
        m.along(half) <= 0.1,
    )
    still = m.analysis.stillness
    kept = sum(any(r.start <= (s.start + s.end) // 2 < r.end for r in still) for s in truth.stillness)
    yield Finding(
        "squares along the axis: the subject dwells in each pose",
        f"{len(still)} stretches of stillness found, covering {kept} of the {len(truth.stillness)} performed",
        kept >= 0.9 * len(truth.stillness),
    )


def _lows(values: Array, width: int) -> Array:
    """The least value in each stretch of ``width`` frames."""
    return np.array([values[a : a + width].min() for a in range(0, len(values) - width + 1, width)])


def _nearest_apart(matrix: Array, apart: int) -> Array:
    """The least value in each row at least ``apart`` frames from the diagonal."""
    n = len(matrix)
    away = np.abs(np.subtract.outer(np.arange(n), np.arange(n))) >= apart
    return np.asarray(np.where(away, matrix, np.inf).min(axis=1))


STUDIES = (
    Study(
        "butterfly",
        "Butterfly stroke",
        "§3.5.1, Figure 64",
        "synthetic performer (`performer.butterfly`)",
        "Symmetric and cyclic: a lack of colour; lines parallel to the diagonal; the lines are not connected, so the "
        "paths run one way.",
        _performed("butterfly", seconds=10, fps=60),
        _butterfly,
        "side",
        (1.7, 3.4),
        needs_data=False,
        graph=BUTTERFLY,
    ),
    Study(
        "jumping-jacks",
        "Jumping jacks",
        "§3.5.2, Figure 65",
        "CMU 13_29, frames 0-456",
        "Symmetric, palindromic, cyclic: a light grey crosshatched grid.",
        _clip("cmu/13/13_29.amc", 0, 456),
        _jumping_jacks,
        "front",
        (0.0, 1.5),
        graph=JUMPING_JACKS,
    ),
    Study(
        "jogging",
        "Jogging in place",
        "§3.5.3, Figure 66",
        "CMU 13_30, frames 1920-2364",
        "Two palindromic crosshatch patterns, one red for Z and one cyan for Z*, 180 degrees out of phase; a white patch "
        "where they "
        "cross, for the same symmetric state is passed every half cycle.",
        _clip("cmu/13/13_30.amc", 1920, 2364),
        _jogging,
        "three-quarter",
        (1.0, 1.8),
        remark="The red pattern is there and its cyan counterpart is at the right lag, but faint: this subject jogs lopsidedly "
        "and drifts from stride to stride, so his left side never does quite what his right side did. The next picture "
        "is of another "
        "subject, and is as the text says.",
        graph=JOGGING,
    ),
    Study(
        "jogging-14",
        "Jogging in place, another subject",
        "§3.5.3, Figure 66",
        "CMU 14_06, frames 420-1008",
        "As above.",
        _clip("cmu/14/14_06.amc", 420, 1008),
        _jogging,
        "three-quarter",
        (1.0, 1.8),
        graph=JOGGING,
    ),
    Study(
        "walking",
        "Walking",
        "§3.5.4, Figure 67",
        "CMU 07_01",
        "Two parallel stripe patterns, red and cyan, 180 degrees out of phase, that never cross to make white: the path never "
        "passes through a symmetric state.",
        _clip("cmu/07/07_01.amc"),
        _walking,
        "side",
        (0.3, 1.5),
        graph=WALKING,
    ),
    Study(
        "limping",
        "Limping",
        "§3.5.5, Figure 68",
        "synthetic performer (`performer.limp`)",
        "Asymmetric and cyclic: a red striped pattern in Z and no signal from Z*.",
        _performed("limp", seconds=8, fps=60, degree=1.0),
        _limping,
        "side",
        (1.3, 2.6),
        remark="The performer's limp shortens and stiffens one side, but the legs still take turns: the cyan stripes are dimmer "
        "than the red ones and not gone. The dissertation's recordings of limping (CMU 91_16, 77_19 to 77_24) are not among "
        "those used "
        "here; `kinesics data fetch` gets them.",
        needs_data=False,
        graph=LIMPING,
    ),
    Study(
        "side-kicks",
        "Side kicks",
        "§3.5.6, Figure 69",
        "CMU 135_11",
        "Kicks to one side, a change of facing, kicks to the other: a region of red stripes, a region of cyan stripes, "
        "and a small area "
        "around the identity axis where the two cross and a white signal is visible.",
        _clip("cmu/135/135_11.amc"),
        _side_kicks,
        remark="The graph read is the one that the text gives in its condensed form, guard and image, a one-way kick on each and "
        "one antipalindromic turn between them; what is more is the recording's: the stance from which the subject steps into the "
        "first guard (A) and the one in which he ends (C), with the way from and to each. He turns through a nearly symmetric "
        "pose without marking it (D*(a, a) falls to .09 and no farther), so it is no state of its own.",
        graph=SIDE_KICKS,
    ),
    Study(
        "sun-salutation",
        "Sun salutation",
        "§3.6.1, Figure 70",
        "synthetic performer (`performer.sun_salutation`)",
        "Performed twice. Symmetric, so without colour, apart from the path wv, where one leg goes back and then the "
        "other: there the "
        "identity axis is visibly red. Squares along the axis where the subject dwells.",
        _performed("sun_salutation", fps=30),
        _sun_salutation,
        "side",
        (0.0, 34.0),
        needs_data=False,
        graph=SUN_SALUTATION,
    ),
    Study(
        "bassai",
        "Bassai Dai kata",
        "§3.6.3, Figure 71",
        "CMU 135_01, as BVH at 30 frames a second by way of keijiro/CMUMocap",
        "Mostly asymmetric movement; the one symmetric state is performed at the beginning, middle and end. The diagonal "
        "is jagged: abrupt "
        "changes in momentum, strikes where it thins.",
        _clip("cmu/bvh/135_01_bassai_30fps.bvh"),
        _bassai,
    ),
)


def measure(motion: kx.Motion) -> Measured:
    """Analysis and all distances, in units of the distance that is nearly black in the picture."""
    analysis = kx.analyze(motion)
    (poses,) = analysis.poses
    dark = np.log(20.0) / analysis.beta
    d, d_mirror = (np.asarray(f(poses, poses), dtype=np.float64) / dark for f in (kx.distance, kx.mirror_distance))
    return Measured(analysis, d, d_mirror, poses.fps)


def draw(study: Study, measured: Measured, path: Path) -> None:
    """Z/Z* on the left, the path in the symmetry basis on the right, the body beneath."""
    analysis = measured.analysis
    (poses,), (motion,) = analysis.poses, analysis.motions
    width, height = 1000, 790
    figure = plotting.new_figure(width / 100, height / 100, dpi=100)

    def place(left: int, bottom: int, wide: int, high: int) -> Axes:
        return figure.add_axes((left / width, bottom / height, wide / width, high / height))

    square = plotting.similarity_plot(
        plotting.pooled_similarity(poses, size=480, beta=analysis.beta), ax=place(65, 235, 480, 480)
    )
    square.tick_params(labelsize=9)
    if analysis.graph.states:
        plotting.state_margin(square, analysis.graph, fps=motion.fps)
    symmetric = [(r.start, r.end) for r in analysis.symmetric_states]
    path_axes = plotting.composite_plot(
        poses, symmetric=symmetric, title="Ψ (dark to light) and Ψ* (grey)", ax=place(635, 300, 350, 350)
    )
    path_axes.set_xlabel("Â  antisymmetric", fontsize=10)
    path_axes.set_ylabel("Ŝ  symmetric", fontsize=10)
    start, end = study.figures_s or (0.0, motion.duration)
    frames = np.minimum(np.linspace(start, end, 12, endpoint=False) * motion.fps, motion.frame_count - 1)
    plotting.stick_figure_row(motion, frames.astype(int), view=study.view, ax=place(20, 35, 960, 150))
    figure.text(
        20 / width,
        12 / height,
        f"{colour_key('thesis')}. Figures: {start:.1f}-{end:.1f} s, left limbs red, right limbs blue.",
        fontsize=8.5,
        color=INK,
    )
    figure.text(65 / width, 768 / height, f"{study.title}   ({study.source.replace('`', '')})", fontsize=12, color=INK)
    _save_small(figure, path)


def draw_graph(measured: Measured, path: Path) -> None:
    """The motion graph that was read, a figure in every state."""
    graph = measured.analysis.graph
    ax = plotting.graph_plot(graph, figures=plotting.state_moments(graph, measured.analysis.motions))
    figure = ax.get_figure(root=True)
    assert figure is not None
    figure.set_dpi(100)
    _save_small(figure, path)


WALKS = ("91_01", "91_34", "07_01", "35_01")


@dataclass(frozen=True, eq=False)
class Stage:
    """A performance by the Markov controller, and its picture (Figure 82)."""

    name: str
    title: str
    wish: dict[str, Any]
    """What `kinesics.performance` is asked for."""


def _eight(size: float = 3.0) -> Array:
    """A figure of eight from the origin, shape (n, 2), x and z in metres."""
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    return np.stack([size * np.sin(2.0 * angle) / 2.0, 1.6 * size * np.sin(angle)], axis=-1)


STAGES = (
    Stage("avatar-target", "To a target", {"target": (-4.0, 3.0), "seed": 3}),
    Stage("avatar-route", "Along a figure of eight", {"route": _eight(), "seed": 1}),
)
AVATAR = (
    "## Markov controlled avatar\n\n§4.4.1, Figure 82. Source: CMU "
    + ", ".join(WALKS)
    + ", brought onto one skeleton, at 30 frames a second, with their mirror images.\n\n"
    "The text: an avatar that moves through a space and chooses motion paths which lead it toward the goal marker; the trail is "
    "shown in blue. Figures: left limbs red, right limbs blue; orange is where it was to go.\n\n"
)


def perform(data: Path | None) -> str:
    """Make the pictures of Figure 82; the part of README.md about them."""
    if data is None or not all((data / "cmu" / n[:2] / f"{n}.amc").exists() for n in WALKS):
        raise FileNotFoundError(f"cmu/{WALKS[0]}.amc")
    motions = [kx.read(data / "cmu" / n[:2] / f"{n}.amc") for n in WALKS]
    text, findings = AVATAR, []
    for stage in STAGES:
        piece = kx.performance(motions, fps=30.0, **stage.wish)
        goal = {key: value for key, value in stage.wish.items() if key in ("target", "route")}
        figure = plotting.trail_plot(piece.motion, **goal).get_figure(root=True)
        assert figure is not None
        figure.set_dpi(110)
        _save_small(figure, HERE / f"{stage.name}.png")
        text += f"![{stage.title}: the trail of the avatar]({stage.name}.png)\n\n"
        if piece.nearest is not None:
            findings.append(
                Finding(
                    "the paths chosen lead it to the target: within .5 m",
                    f"came within {piece.nearest:.2f} m, {piece.length:.1f} m for {np.hypot(*stage.wish['target']):.1f} m",
                    piece.nearest <= 0.5,
                )
            )
        elif piece.aside is not None:
            findings.append(
                Finding(
                    "and along a line: median .3 m beside it at most",
                    f"{piece.aside:.2f} m beside it (median), {piece.length:.1f} m long",
                    piece.attained and piece.aside <= 0.3,
                )
            )
    sheet = plotting.contact_sheet(
        piece.motion[: round(8.0 * piece.motion.fps)],
        transitions=[c for c in piece.performance.cuts.tolist() if c < 8.0 * piece.motion.fps],
        mirrored=[(a, min(b, 240)) for a, b in runs(piece.provenance.mirrored) if a < 240],
        every=0.25,
    ).get_figure(root=True)
    assert sheet is not None
    sheet.set_dpi(90)
    _save_small(sheet, HERE / "avatar-sheet.png")
    text += "The first eight seconds along the figure of eight:\n\n![Stick figures over time](avatar-sheet.png)\n\n"
    rows = "\n".join(f"| {f.expected} | {f.measured} | {'yes' if f.agrees else '**no**'} |" for f in findings)
    for f in findings:
        print(f"avatar: {'yes' if f.agrees else 'NO '}  {f.expected}: {f.measured}")
    return f"{text}| expected | measured | |\n| --- | --- | --- |\n{rows}\n"


def _save_small(figure: Figure, path: Path) -> None:
    """A PNG of 256 colours: a third of the size, and the eye does not see it."""
    from PIL import Image

    full = Image.open(io.BytesIO(figure_bytes(figure, ".png"))).convert("RGB")
    full.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)


def describe(study: Study, findings: list[Finding]) -> str:
    """The study's part of README.md."""
    verdicts = [f.agrees for f in findings]
    verdict = "agrees" if all(verdicts) else "does not agree" if not any(verdicts) else "agrees in part"
    rows = "\n".join(f"| {f.expected} | {f.measured} | {'yes' if f.agrees else '**no**'} |" for f in findings)
    return (
        f"## {study.title}: {verdict}\n\n{study.section}. Source: {study.source}.\n\n![Z/Z* of "
        f"{study.title.lower()}]({study.name}.png)\n\n"
        f"![Motion graph of {study.title.lower()}]({study.name}-graph.png)\n\n"
        f"The text: {study.text}\n\n{study.remark and study.remark + chr(10) * 2}| expected | measured | |\n| --- | --- | "
        f"--- |\n{rows}\n"
    )


HEAD = f"""# Gallery

The motion studies of A. Schultz, *Performance Physics* (2012), §3.5-3.6, made again by `make gallery`, beside what the text says
they must look like. Each expectation is checked by a number, and where the number disagrees the table says so.

Left: every pixel compares two moments; red is the same pose (Z), cyan the mirrored pose (Z*), white both, and the identity axis
runs from the lower left to the upper right. Right: the path in the symmetry basis, symmetric part upwards, antisymmetric part
across, the mirrored path in grey, symmetric poses in cyan. On the margin: the states of the motion graph where they are met.
Below: the motion graph that was read, symmetric states on the middle line, a state and its mirror image (starred) on either side;
it is compared with the one that the text draws, up to names. Distances in the tables are divided by the one at which the picture
is nearly black (Z = .05): 0 is the same pose, 1 is as unlike as the darker quarter of all pairs.

The bounds in the checks are ours (the dissertation gives no numbers): a line counts as bright up to .2 or .3 of that distance.

CMU recordings: {CREDIT}

"""


def main() -> int:
    """Make every picture that can be made here."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, help="folder of the recordings")
    everything = [*(s.name for s in STUDIES), "avatar"]
    parser.add_argument("--only", nargs="*", default=everything, help="names of studies, and avatar")
    arguments = parser.parse_args()
    named = arguments.data or os.environ.get("KINESICS_DATA")
    data = Path(named) if named else HERE.parents[1] / "shared" / "data"
    parts, missing = [], []
    for study in STUDIES:
        if study.name not in arguments.only:
            continue
        try:
            motion = study.read(data)
        except FileNotFoundError as error:
            missing.append(f"{study.name} ({error})")
            continue
        # the program's own motions have no file; a title does not need one
        measured = measure(dataclasses.replace(motion, name=study.name))
        draw(study, measured, HERE / f"{study.name}.png")
        draw_graph(measured, HERE / f"{study.name}-graph.png")
        findings = [*study.check(measured), *_graph_of_the_text(study, measured)]
        parts.append(describe(study, findings))
        print(f"{study.name}: {sum(f.agrees for f in findings)} of {len(findings)} agree")
        for f in findings:
            print(f"   {'yes' if f.agrees else 'NO '}  {f.expected}: {f.measured}")
    if "avatar" in arguments.only:
        try:
            parts.append(perform(data))
        except FileNotFoundError as error:
            missing.append(f"avatar ({error})")
    if len(parts) == len(everything):
        (HERE / "README.md").write_text(HEAD + "\n".join(parts), encoding="utf-8")
    if missing:
        print(f"Not made, the recordings are not in {data.name}: {', '.join(missing)}. README.md is left as it was.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
