"""Pictures of performances: the trail on the floor, the contact sheet."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.patches import Ellipse, Polygon, Rectangle
from matplotlib.text import Text

import kinesics as kx
from kinesics import plotting
from kinesics.plotting import canvas
from kinesics.plotting.canvas import figure_bytes
from kinesics.plotting.contact_sheet import CUT, MIRRORED
from kinesics.plotting.scene import GOAL, TILE, TRAIL, Camera


@pytest.fixture(scope="module")
def walk() -> kx.Motion:
    """Five seconds, on a curve."""
    return kx.performer.walk(seconds=5, fps=30, route="circle").motion


def test_the_camera_is_a_perspective() -> None:
    """What is nearer is larger, parallel lines meet, and what lies at the centre keeps its measure."""
    camera = Camera((0.0, 0.0, 0.0), 0.0, 0.0, 10.0)
    assert np.allclose(camera.project(np.array([1.0, 2.0, 0.0])), [1.0, 2.0])
    near, far = camera.project(np.array([[1.0, 0.0, 5.0], [1.0, 0.0, -10.0]]))
    assert np.allclose(near, [2.0, 0.0])
    assert np.allclose(far, [0.5, 0.0])
    above = Camera((0.0, 0.0, 0.0), 0.0, np.pi / 2, 10.0)
    # seen from above with +z before one: left is to the right of whoever looks the subject in the face
    assert np.allclose(above.project(np.array([1.0, 0.0, 2.0])), [1.0, -2.0])
    turned = Camera((0.0, 0.0, 0.0), np.pi / 2, 0.0, 10.0)
    assert np.allclose(turned.project(np.array([0.0, 1.0, -1.0])), [1.0, 1.0])


def test_the_trail_runs_over_the_picture_in_blue(walk: kx.Motion) -> None:
    """A blue line of a point a frame, from left to right; with target and route in orange."""
    ax = plotting.trail_plot(walk, target=(2.0, 3.0), route=[(0, 0), (0, 2), (2, 3)])
    (trail,) = [line for line in ax.lines if line.get_color() == TRAIL and len(line.get_xdata()) == walk.frame_count]
    across = np.asarray(trail.get_xdata())
    assert across[-1] - across[0] > 2.0
    assert [line for line in ax.lines if line.get_color() == GOAL and line.get_linestyle() == "--"]
    discs = [p for p in ax.patches if isinstance(p, Polygon) and to_hex(p.get_facecolor()) == GOAL]
    assert len(discs) == 2
    several = plotting.trail_plot(walk, target=[(2.0, 3.0), (0.0, 4.0), (1.0, 1.0)])
    assert len([p for p in several.patches if isinstance(p, Polygon) and to_hex(p.get_facecolor()) == GOAL]) == 6
    assert figure_bytes(ax.figure, ".png").startswith(b"\x89PNG")


def test_a_long_title_stays_on_the_paper(walk: kx.Motion) -> None:
    """In lines, none of which runs out of the picture."""
    said = "; ".join(f"reached ({k}.00, 3.00) after {k}.5 s" for k in range(9))
    figure = plotting.trail_plot(walk, title=said).get_figure(root=True)
    assert figure is not None
    figure.canvas.draw()
    (left,) = [t.get_window_extent() for t in figure.findobj(Text) if t.get_text().startswith("reached")]
    assert left.x1 < figure.bbox.x1
    assert left.y1 < figure.bbox.y1


@pytest.mark.parametrize("draw", [plotting.trail_plot, plotting.contact_sheet])
@pytest.mark.parametrize("name", ["WALK_" * 25, "q$\\frac$c", "a$b$", "歩行", "many words of " * 9, "walk"])
def test_whatever_a_recording_is_called_its_title_is_whole(
    walk: kx.Motion, draw: Callable[..., Axes], name: str
) -> None:
    """On the paper, letter for letter and no formula, over wide sheets and narrow ones; nothing is said of strange letters."""
    for motion in (walk, walk[:2]):
        ax = draw(motion, title=f"1.0 s from {name}")
        figure = ax.get_figure(root=True)
        assert figure is not None
        assert figure_bytes(figure, ".png").startswith(b"\x89PNG")
        title = ax._left_title  # type: ignore[attr-defined]
        shown = title.get_text().replace("\n", "").replace(" ", "")
        assert shown.startswith(f"1.0 s from {name}".replace(" ", ""))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            seen = title.get_window_extent()
        assert seen.x0 >= 0.0
        assert seen.x1 <= figure.bbox.x1
        assert seen.y1 <= figure.bbox.y1
        assert not title.get_parse_math()


def test_a_title_that_is_too_long_ends_in_dots() -> None:
    """In no more lines than asked for, each within the width; what fits is in one."""
    assert canvas.title_lines("a walk", 3.0, 10.0, most=2) == ["a walk"]
    assert canvas.title_lines("", 3.0, 10.0, most=2) == []
    lines = canvas.title_lines("to and fro " * 40, 3.0, 10.0, most=2)
    assert len(lines) == 2
    assert lines[1].endswith(" …")
    assert all(12 < len(line) < 60 for line in lines)


@pytest.mark.parametrize("metres", [0.0, 3.0, 60.0, 400.0])
def test_a_trail_is_neither_a_thread_nor_a_tower(walk: kx.Motion, metres: float) -> None:
    """Straight on or in place: at most six times as wide as high, and never higher than wide."""
    straight = walk.root_positions * [0.0, 1.0, 0.0] + np.linspace(0.0, metres, walk.frame_count)[:, None] * [0, 0, 1]
    ax = plotting.trail_plot(walk.replace(root_positions=straight), title="straight on")
    wide, high = ax.get_figure(root=True).get_size_inches()
    assert 1.0 < wide / high < 6.0


def test_figures_stand_at_regular_times_where_there_is_room(walk: kx.Motion) -> None:
    """One every second, and the last frame; none on another; all within the picture, on the trail."""
    ax = plotting.trail_plot(walk, every=1.0)
    heads = [a for a in ax.get_children() if isinstance(a, Ellipse)]
    assert len(heads) == 6
    assert "every 1 s" in ax.texts[0].get_text()
    (low, high), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    for collection in ax.collections:
        assert isinstance(collection, LineCollection)
        points = np.concatenate(collection.get_segments())
        assert points[:, 0].min() >= low
        assert points[:, 0].max() <= high
        assert points[:, 1].min() >= bottom
        assert points[:, 1].max() <= top
    standing = plotting.trail_plot(kx.performer.jumping_jacks(seconds=5, fps=30).motion)
    assert len([a for a in standing.get_children() if isinstance(a, Ellipse)]) <= 2


@pytest.mark.parametrize(
    "how",
    [
        {"target": 3.0},
        {"target": (1.0, np.nan)},
        {"target": (1, 2, 3)},
        {"target": "here"},
        {"route": [1.0, 2.0]},
        {"route": []},
        {"every": 0.0},
        {"radius": -1.0},
    ],
)
def test_a_trail_of_nonsense_is_refused(walk: kx.Motion, how: dict[str, object]) -> None:
    """The argument is named."""
    with pytest.raises(kx.InputError, match=next(iter(how))):
        plotting.trail_plot(walk, **how)


def test_a_single_frame_and_a_far_walk_have_a_picture() -> None:
    """A dot; a floor of many tiles, without a fog of lines."""
    walk = kx.performer.walk(seconds=3, fps=30).motion
    assert figure_bytes(plotting.trail_plot(walk[0]).figure, ".png")
    far = walk.replace(root_positions=walk.root_positions * [1.0, 1.0, 200.0])
    ax = plotting.trail_plot(far)
    floor = ax.collections[0]
    assert isinstance(floor, LineCollection)
    assert len(floor.get_segments()) < 120


@pytest.mark.parametrize(
    ("metres", "tile", "words"),
    [
        (8.0, 1.0, "a tile is a metre wide"),
        (60.0, 2.0, "a tile is 2 metres wide"),
        (700.0, 20.0, "a tile is 20 metres wide"),
    ],
)
def test_tiles_are_as_wide_as_is_said(walk: kx.Motion, metres: float, tile: float, words: str) -> None:
    """Whole tiles, of a metre while they can be told apart; what they are and how figures are drawn stands below."""
    straight = np.zeros((walk.frame_count, 3))
    straight[:, 1] = walk.root_positions[:, 1]
    straight[:, 2] = np.linspace(0.0, metres, walk.frame_count)
    ax = plotting.trail_plot(walk.replace(root_positions=straight))
    (said,) = (text.get_text() for text in ax.texts)
    assert words in said
    # the floor is a metre or more larger all round and never a thread, in whole tiles: as many lines across as tiles, and one more
    (lines,) = [c for c in ax.collections if isinstance(c, LineCollection) and to_hex(c.get_color()[0]) == TILE]
    long, wide = np.ceil(np.array([metres + 2.0, max(2.0, 0.14 * (metres + 2.0))]) / tile)
    assert len(lines.get_segments()) == long + wide + 2
    head = next(a for a in ax.get_children() if isinstance(a, Ellipse))
    inches = 9.0 / np.ptp(ax.get_xlim())
    assert head.height * inches > 0.03
    assert ("times too large" in said) == (metres > 20.0)


def test_a_contact_sheet_has_a_figure_a_step_and_its_marks(walk: kx.Motion) -> None:
    """Rows of as many figures as asked for; a mark a transition; cyan as long as what is mirrored."""
    ax = plotting.contact_sheet(walk, transitions=[30, 100], mirrored=[(30, 100)], every=0.5, across=4)
    _, heads = ax.collections
    assert len(heads.get_paths()) == 10
    assert [t.get_text() for t in ax.texts] == ["0 s", "2 s", "4 s"]
    assert len([line for line in ax.lines if line.get_color() == CUT]) == 2
    cyan = [line for line in ax.lines if line.get_color() == MIRRORED]
    length = sum(float(np.ptp(line.get_xdata())) for line in cyan)
    whole = sum(float(np.ptp(line.get_xdata())) for line in ax.lines if line not in cyan and line.get_color() != CUT)
    assert length / whole == pytest.approx(70 / 150)
    assert len([p for p in ax.patches if isinstance(p, Rectangle)]) == len(cyan)
    assert "cyan: mirrored" in ax.get_title(loc="left")
    assert figure_bytes(ax.figure, ".png").startswith(b"\x89PNG")


@pytest.mark.parametrize("across", [1, 4, 16])
def test_no_figure_is_cut_off_at_the_edge(across: int) -> None:
    """Arms stretched wider than a figure's share of the paper, and up beyond a row: all of it is within the picture."""
    jacks = kx.performer.jumping_jacks(seconds=3, fps=30).motion
    leaping = jacks.replace(
        root_positions=jacks.root_positions + np.linspace(0.0, 0.9, jacks.frame_count)[::-1, None] * [0, 1, 0]
    )
    for motion in (jacks, leaping):
        ax = plotting.contact_sheet(motion, every=0.25, across=across, view="front")
        limbs, skulls = ([np.asarray(p.vertices) for p in c.get_paths()] for c in ax.collections)
        # a figure's limbs are drawn one after another
        bones = [np.concatenate(limbs[k : k + len(limbs) // 12]) for k in range(0, len(limbs), len(limbs) // 12)]
        heads = [np.array([skull.min(axis=0), skull.max(axis=0)]) for skull in skulls]
        assert len(heads) == len(bones) == 12
        points = np.concatenate([*bones, *heads])
        widest = max(np.ptp(b[:, 0]) for b in bones)
        assert widest > 1.2
        assert (points.min(axis=0) >= [ax.get_xlim()[0], ax.get_ylim()[0]]).all()
        assert (points.max(axis=0) <= [ax.get_xlim()[1], ax.get_ylim()[1]]).all()
        figure = ax.get_figure(root=True)
        assert figure is not None
        figure.canvas.draw()
        assert min(t.get_window_extent().x0 for t in ax.texts) > 0.0


@pytest.mark.parametrize("frames", [1, 2, 4, 12, 30, 149])
def test_a_sheet_of_a_moment_is_well_proportioned(walk: kx.Motion, frames: int) -> None:
    """Wider than high, a figure no larger than on other sheets; every frame at most once, six of them where there are as many."""
    ax = plotting.contact_sheet(walk[:frames], title="a moment")
    wide, high = ax.get_figure(root=True).get_size_inches()
    assert 1.0 < wide / high < 6.0
    _, heads = ax.collections
    assert min(6, frames) <= len(heads.get_paths()) <= frames
    metre = ax.get_position().height * high / np.ptp(ax.get_ylim())
    assert metre == pytest.approx(0.92, rel=0.02)


def test_stretched_arms_have_room() -> None:
    """Figures stand farther apart where arms go sideways, so that there are fewer in a row."""
    stretched = kx.performer.jumping_jacks(seconds=60, fps=10).motion
    walk = kx.performer.walk(seconds=60, fps=10).motion
    assert len(plotting.contact_sheet(stretched, view="front").texts) <= 4
    widths = [
        np.ptp(plotting.contact_sheet(m, every=1.0, across=10, view="front").get_xlim()) for m in (walk, stretched)
    ]
    assert widths[1] > 1.2 * widths[0]


def test_a_long_movement_has_at_most_four_rows() -> None:
    """The step is chosen."""
    motion = kx.performer.walk(seconds=60, fps=10).motion
    assert len(plotting.contact_sheet(motion).texts) <= 4


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"every": 0.0}, "every"),
        ({"across": 0}, "across"),
        ({"transitions": [151]}, "151"),
        ({"mirrored": [(0, 400)]}, "400"),
        ({"every": 0.001}, "larger `every`"),
    ],
)
def test_a_sheet_of_nonsense_is_refused(walk: kx.Motion, how: dict[str, object], says: str) -> None:
    """The argument is named."""
    with pytest.raises(kx.InputError, match=says):
        plotting.contact_sheet(walk, **how)
