"""The motion graph on paper: what stands where, what is drawn of it, and the same picture every time."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon

import kinesics as kx
import kinesics.performer as performer
from kinesics import plotting
from kinesics.errors import InputError
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, Source, State, build
from kinesics.plotting.canvas import figure_bytes
from kinesics.plotting.graph_labels import label_text
from kinesics.plotting.graph_layout import Place, lay_out, widest_gap
from motion_graphs import graph_of, random_graph


def _graph(name: str) -> MotionGraph:
    return graph_of(performer.perform(name).truth)


def _centres(ax: Axes) -> list[tuple[float, float]]:
    return [tuple(np.round(p.center, 6)) for p in ax.patches if isinstance(p, Circle)]


def _heads(ax: Axes) -> int:
    return sum(isinstance(p, Polygon) for p in ax.patches)


def _figures(ax: Axes) -> int:
    """How many stick figures there are: all heads are one collection."""
    _, heads = ax.collections
    return len(heads.get_paths())


def _texts(ax: Axes) -> list[str]:
    return [t.get_text() for t in ax.texts]


def _arrows(ax: Axes) -> list[Line2D]:
    return [line for line in ax.lines if len(np.atleast_1d(line.get_xdata())) > 2]


def test_symmetric_states_stand_on_the_axis_and_images_face_each_other() -> None:
    """X in the middle, A left, A* at the mirrored place (§3.5)."""
    for seed in range(4):
        graph = random_graph(14, seed)
        where = dict(zip((s.id for s in graph.states), _centres(plotting.graph_plot(graph)), strict=True))
        for state in graph.states:
            x, y = where[state.id]
            if state.symmetric:
                assert x == 0.0
            else:
                assert (x > 0.0) == state.label.endswith("*")
                assert x != 0.0
            if state.mirror_of is not None:
                assert where[state.mirror_of] == (-x, y)


@pytest.mark.parametrize("size", [2, 12, 60])
def test_no_two_states_share_a_place(size: int) -> None:
    """At least a cell apart, from two states to sixty."""
    centres = np.array(_centres(plotting.graph_plot(random_graph(size, 3))))
    assert len(centres) == size
    apart = np.hypot(*(centres[:, None] - centres[None]).transpose(2, 0, 1))[np.triu_indices(size, 1)]
    assert apart.min() >= 0.999


def test_a_picture_is_racemised_without_moving() -> None:
    """The image of a lone state goes to the place that was kept for it."""
    graph = _graph("limp")
    ((x, y),) = _centres(plotting.graph_plot(graph))
    assert sorted(_centres(plotting.graph_plot(graph.racemic()))) == [(x, y), (-x, y)]


@pytest.mark.parametrize("pairs", [1, 2, 3])
@pytest.mark.parametrize("middle", [0, 1, 2])
def test_parallel_arrows_between_symmetric_states_are_evenly_spread(pairs: int, middle: int) -> None:
    """Symmetric paths keep to the axis, the others stand left of it and their mirror images right, all equally far apart."""
    paths = [Path(k, from_=0, to=1, mirror_of=k ^ 1) for k in range(2 * pairs)]
    paths += [Path(2 * pairs + k, from_=0, to=1, symmetric=True) for k in range(middle)]
    graph = build([State(0, symmetric=True), State(1, symmetric=True)], paths)
    ax = plotting.graph_plot(graph)
    middles = sorted(float(max(line.get_xdata(), key=abs)) for line in _arrows(ax))
    assert len(middles) == 2 * pairs + middle
    np.testing.assert_allclose(middles, np.negative(middles[::-1]), atol=1e-6)
    gaps = np.diff(middles)
    assert gaps.min() > 0.15
    np.testing.assert_allclose(gaps, gaps[0], rtol=0.01)
    where = {t.get_text(): t.get_position()[0] for t in ax.texts}
    starred = [x for label, x in where.items() if label.startswith("(")]
    assert len(starred) == pairs
    assert min(starred) > 0.0


@pytest.mark.parametrize(
    ("name", "states", "heads", "labels"),
    [
        ("butterfly", 1, 1, {r"$\overline{xx}$"}),
        ("jumping_jacks", 2, 2, {r"$\overline{xy}$"}),
        ("jog_in_place", 3, 4, {"ax", "(ax)*"}),
        ("walk", 2, 2, {"aa*", "(aa*)*"}),
        ("limp", 1, 1, {"aa"}),
        ("side_kicks", 3, 6, {"aa", "(aa)*", "ax", "(ax)*"}),
    ],
)
def test_the_short_studies_have_the_arrows_of_the_figures(name: str, states: int, heads: int, labels: set[str]) -> None:
    """Figures 64-69: one head for a one-way path, two for a reversible one, every label once."""
    graph = _graph(name)
    ax = plotting.graph_plot(graph)
    assert len(_centres(ax)) == states
    assert _heads(ax) == heads
    assert labels <= set(_texts(ax))
    assert len(_texts(ax)) == states + len(graph.paths)


def test_the_condensed_form_is_that_of_the_figures() -> None:
    """Figure 66: A and A* with one arrow of two heads, labelled by the state it passes."""
    ax = plotting.graph_plot(_graph("jog_in_place"), condensed=True)
    assert len(_centres(ax)) == 2
    assert _heads(ax) == 2
    assert "X\N{COMBINING OVERLINE}" in _texts(ax)


def test_inferred_paths_are_dotted_and_grey() -> None:
    """And only they (§3.6.2)."""
    racemic = _graph("limp").racemic()
    seen, inferred = _arrows(plotting.graph_plot(racemic))
    assert seen.get_linestyle() == "-"
    assert inferred.get_linestyle() != "-"
    assert seen.get_color() != inferred.get_color()


def test_parallel_paths_bow_apart_and_keep_clear_of_states() -> None:
    """Between two states no two arrows meet, and none runs through a third state."""
    states = [State(0), State(1), State(2)]
    paths = [Path(k, from_=0, to=1, reversible=k == 2) for k in range(4)] + [
        Path(4, from_=0, to=2),
        Path(5, from_=2, to=0),
    ]
    ax = plotting.graph_plot(build(states, paths))
    curves = [np.stack([line.get_xdata(), line.get_ydata()], axis=1) for line in _arrows(ax)]
    assert len(curves) == 6
    for a, b in itertools.combinations(curves[:4], 2):
        middle = np.hypot(*(a[len(a) // 2] - b[len(b) // 2]))
        assert middle > 0.15
    centres = np.array(_centres(ax))
    for k, curve in enumerate(curves):
        ends = (0, 1) if k < 4 else (0, 2)
        (other,) = set(range(3)) - set(ends)
        assert np.hypot(*(curve - centres[other]).T).min() > 0.19


def test_mirror_images_are_drawn_as_mirror_images() -> None:
    """Reflected in the axis the arrows of the racemised kata are the arrows of the kata racemised."""
    graph = _graph("kata").racemic()
    ax = plotting.graph_plot(graph)
    drawn = {(round(float(c[0]), 4), round(float(c[1]), 4)) for c in _ends_and_middles(ax)}
    off_axis = {(x, y) for x, y in drawn if abs(x) > 0.6}
    assert off_axis
    mirrored = {(-x, y) for x, y in off_axis}
    assert len(off_axis & mirrored) >= 0.8 * len(off_axis)


def _ends_and_middles(ax: Axes) -> np.ndarray:
    curves = [np.stack([line.get_xdata(), line.get_ydata()], axis=1) for line in _arrows(ax)]
    return np.concatenate([c[[0, -1]] for c in curves])


def test_an_index_is_shown_where_it_says_something() -> None:
    """The kata has xa₁ and xa₂, and only one ab."""
    texts = _texts(plotting.graph_plot(_graph("kata")))
    assert {"xa₁", "xa₂", "ab"} <= set(texts)


def test_labels_of_mirror_images_agree() -> None:
    """Where one of two mirror images needs its index, the other shows it too."""
    seen = (Occurrence(0, 0, 10), Occurrence(0, 10, 20), Occurrence(0, 20, 30))
    graph = build(
        [State(0, mirror_of=1), State(1, mirror_of=0)],
        [
            Path(0, from_=0, to=0, mirror_of=1, occurrences=seen[:1]),
            Path(1, from_=1, to=1, mirror_of=0, inferred=True),
            Path(2, from_=0, to=0, occurrences=seen[1:]),
        ],
        [Source("turns", 30, 30.0)],
    )
    assert {p.label for p in graph.paths} == {"aa_1", "(aa_1)*", "aa_2"}
    assert {"aa₁", "(aa₁)*", "aa₂"} <= set(_texts(plotting.graph_plot(graph)))


@pytest.mark.parametrize(
    ("label", "shown"),
    [
        ("A", "A"),
        ("A12*", "A₁₂*"),
        ("X~", "X\N{COMBINING OVERLINE}"),
        ("X12~", "X\N{COMBINING OVERLINE}₁₂"),
        ("ab*_12", "ab*₁₂"),
        ("(a1b_2)*", "(a₁b₂)*"),
        ("xy~_1", r"${\overline{xy}}_{1}$"),
        ("guard-b_1", r"${\mathrm{guard{-}b}}_{1}$"),
    ],
)
def test_labels_are_plain_text_where_that_can_show_them(label: str, shown: str) -> None:
    """A bar over several letters and a word are mathtext, all else letters and small figures."""
    assert label_text(label) == shown


def test_a_graph_without_states_is_said_to_be_empty() -> None:
    """Not an empty sheet."""
    assert _texts(plotting.graph_plot(MotionGraph())) == ["no states"]


def test_the_same_graph_is_the_same_picture() -> None:
    """The same bytes on every run."""
    pictures = [figure_bytes(plotting.graph_plot(random_graph(9, 1)).figure, ".svg") for _ in range(2)]
    assert pictures[0] == pictures[1]


def test_axes_that_are_given_are_used() -> None:
    """By all of them; pyplot hears nothing."""
    import matplotlib.pyplot as plt

    before = plt.get_fignums()
    performance = performer.side_kicks()
    graph = graph_of(performance.truth)
    for draw in (
        lambda ax: plotting.graph_plot(graph, ax=ax),
        lambda ax: plotting.path_strips(graph, [performance.motion], ax=ax),
        lambda ax: plotting.state_margin(ax, graph),
    ):
        ax = plotting.new_figure(4, 4).add_subplot()
        assert draw(ax) is ax
    assert plt.get_fignums() == before


# moments


def test_each_state_is_shown_at_a_moment_of_its_own() -> None:
    """In the middle of its stay, or where it is passed; the pose there is the performer's key pose."""
    performance = performer.perform("sun_salutation")
    graph = graph_of(performance.truth)
    moments = plotting.state_moments(graph, [performance.motion])
    poses = kx.poses(performance.motion).quaternions
    assert set(moments) == {s.id for s in graph.states}
    for state in graph.states:
        _, frame = moments[state.id]
        assert any(stay.start <= frame < stay.end for stay in state.stays)
        wanted = performance.truth.state(state.label).pose
        assert kx.distance(poses[frame : frame + 1], wanted[None])[0, 0] < 1e-3


def test_a_state_that_was_never_seen_is_shown_in_the_mirror() -> None:
    """A* of the limp is A mirrored."""
    performance = performer.limp(seconds=6)
    graph = graph_of(performance.truth).racemic()
    moments = plotting.state_moments(graph, [performance.motion])
    seen, mirrored = (kx.poses(m[f : f + 1]).quaternions for m, f in (moments[0], moments[1]))
    assert kx.mirror_distance(seen, mirrored)[0, 0] < 1e-6
    ax = plotting.graph_plot(graph, figures=moments)
    assert _figures(ax) == 2


def test_strips_show_every_path_that_is_known() -> None:
    """Label, direction and length; the inferred path by its mirrored image."""
    performance = performer.limp(seconds=6)
    graph = graph_of(performance.truth).racemic()
    ax = plotting.path_strips(graph, [performance.motion], moments=5)
    assert _figures(ax) == 10
    assert {"aa", "(aa)*"} <= set(_texts(ax))
    assert [text[0] for text in _texts(ax) if text.endswith(("×", "mirrored"))] == ["→", "→"]
    assert any("mirrored" in t for t in _texts(ax))
    one = plotting.path_strips(graph, [performance.motion], paths=["aa_1"], moments=5)
    assert _figures(one) == 5


def test_a_strip_lightens_as_the_path_evolves() -> None:
    """The first pose is black, every next one lighter (§3.5)."""
    performance = performer.raise_arms()
    graph = graph_of(performance.truth)
    ax = plotting.path_strips(graph, [performance.motion], moments=6)
    _, heads = ax.collections
    places = [float(path.vertices[:, 0].mean()) for path in heads.get_paths()]
    greys = [float(heads.get_edgecolor()[k][0]) for k in np.argsort(places)]
    assert len(greys) == 6
    assert greys == sorted(greys)
    assert greys[0] < 0.15
    assert greys[-1] > 0.6


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda g, m: plotting.path_strips(g, [m, m]), "one motion for each of the 1 sources, got 2"),
        (lambda g, m: plotting.state_moments(g, [m[:50]]), "frames, the motion given for it 50"),
        (lambda g, m: plotting.path_strips(g, [m], paths=["qq_1"]), "No path is called 'qq_1'"),
        (lambda g, m: plotting.path_strips(g, [m], moments=0), "at least 1"),
        (lambda g, m: plotting.state_margin(plotting.new_figure(2, 2).add_subplot(), g, side="left"), "'right' or 'top'"),
        (lambda g, m: plotting.state_margin(plotting.new_figure(2, 2).add_subplot(), g, source=3), "No source 3"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(call, message: str) -> None:
    """The message says what was expected."""
    performance = performer.limp(seconds=6)
    with pytest.raises(InputError, match=message):
        call(graph_of(performance.truth), performance.motion)


def test_the_margin_names_the_states_where_they_are_met() -> None:
    """Every stay once, in the middle of it, in the units of the plot."""
    graph = _graph("kata")
    ax = plotting.new_figure(6, 6).add_axes((0.1, 0.1, 0.8, 0.8))
    fps = graph.sources[0].fps
    ax.set_xlim(0, graph.sources[0].frames / fps)
    ax.set_ylim(0, graph.sources[0].frames / fps)
    plotting.state_margin(ax, graph, fps=fps)
    stays = [(0.5 * (r.start + r.end) / fps, label_text(s.label)) for s in graph.states for r in s.stays]
    for text in ax.texts:
        place = text.get_position()[1]
        assert any(abs(place - t) < 1e-9 and text.get_text() == label for t, label in stays)
    assert len(ax.texts) >= 0.9 * len(stays)
    for column in {t.get_position()[0] for t in ax.texts}:
        places = sorted(t.get_position()[1] for t in ax.texts if t.get_position()[0] == column)
        assert np.diff(places).min() > 0.8


# the layout by itself


def test_an_arrow_is_not_laid_over_a_state() -> None:
    """Three lone states joined to each other are not put in one row."""
    places = [Place(k, -1) for k in range(6)]
    points = lay_out(places, [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3)])
    for trio in ((0, 1, 2), (3, 4, 5)):
        a, b, c = points[list(trio)]
        assert abs(np.linalg.det(np.stack([b - a, c - a]))) > 0.5


def test_a_chain_is_laid_out_in_its_order() -> None:
    """Symmetric states joined one after another stand so, from the top down."""
    points = lay_out([Place(k, 0) for k in range(6)], [(k, k + 1) for k in range(5)])
    assert points[:, 0].tolist() == [0.0] * 6
    steps = np.diff(points[:, 1])
    assert (steps == steps[0]).all()
    assert abs(steps[0]) == 1.0


def test_nothing_is_laid_out_as_nothing() -> None:
    """No states, no places."""
    assert lay_out([], []).shape == (0, 2)


@pytest.mark.parametrize(
    ("angles", "preferred", "expected"),
    [([], 1.0, 1.0), ([0.0], np.pi, np.pi), ([0.0, np.pi], np.pi / 2, np.pi / 2)],
)
def test_a_loop_goes_where_there_is_room(angles: list[float], preferred: float, expected: float) -> None:
    """In the direction preferred where that is free."""
    assert widest_gap(angles, preferred) == pytest.approx(expected)


def test_a_loop_makes_way_for_an_arrow() -> None:
    """At least a radian from an arrow that goes where the loop would."""
    found = widest_gap([np.pi], np.pi)
    assert abs((found - np.pi + np.pi) % (2 * np.pi) - np.pi) > 1.0
