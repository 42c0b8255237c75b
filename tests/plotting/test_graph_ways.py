"""The arrows of a drawn motion graph: none runs through a state that it does not join, and mirror images are drawn as such."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon

import kinesics as kx
import kinesics.performer as performer
from kinesics import plotting
from kinesics.grammar.graph import MotionGraph, Path, State, build
from kinesics.plotting.graph_ways import Ways
from motion_graphs import random_graph


def _distance(curve: np.ndarray, place: np.ndarray) -> float:
    """From a place to a line of straight pieces, exactly."""
    begin, step = curve[:-1], np.diff(curve, axis=0)
    t = np.clip(((place - begin) * step).sum(axis=1) / np.maximum((step**2).sum(axis=1), 1e-12), 0.0, 1.0)
    return float(np.hypot(*(begin + t[:, None] * step - place).T).min())


def _curves(ax: Axes) -> list[np.ndarray]:
    lines = [np.stack([line.get_xdata(), line.get_ydata()], axis=1) for line in ax.lines]
    return [line for line in lines if len(line) > 2]


def _through(ax: Axes) -> list[tuple[np.ndarray, np.ndarray]]:
    """Which arrows run through which circles, besides those they begin and end at."""
    circles = [p for p in ax.patches if isinstance(p, Circle)]
    centres = np.array([c.center for c in circles])
    out = []
    for curve in _curves(ax):
        ends = {int(np.hypot(*(centres - end).T).argmin()) for end in curve[[0, -1]]}
        out += [
            (curve, centres[k])
            for k, circle in enumerate(circles)
            if k not in ends and _distance(curve, centres[k]) < circle.radius
        ]
    return out


def _more_paths(graph: MotionGraph, seed: int) -> MotionGraph:
    """With three more paths for each state, between any two."""
    rng = np.random.default_rng(seed)
    states = [State(s.id, symmetric=s.symmetric, mirror_of=s.mirror_of) for s in graph.states]
    paths = [dataclasses.replace(p, label="", index=0) for p in graph.paths]
    for pair in rng.integers(len(states), size=(3 * len(states), 2)):
        paths.append(Path(len(paths), from_=int(pair[0]), to=int(pair[1])))
    return build(states, paths)


@pytest.fixture(scope="module")
def moment() -> plotting.Moment:
    """A figure to put into a state."""
    return (performer.limp(seconds=6).motion, 0)


@pytest.mark.parametrize("figures", [False, True], ids=["circles", "figures"])
@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(size=st.integers(3, 20), seed=st.integers(0, 10_000), condensed=st.booleans())
def test_no_arrow_runs_through_a_third_state(figures: bool, size: int, seed: int, condensed: bool, moment) -> None:
    """Of whatever graph, in either form: an arrow through a state would show a path that is not there."""
    graph = random_graph(size, seed)
    shown = {graph.states[0].id: moment} if figures else None
    assert _through(plotting.graph_plot(graph, figures=shown, condensed=condensed)) == []


@pytest.mark.parametrize(("size", "seed"), [(12, 0), (16, 1), (30, 3)])
def test_no_arrow_runs_through_a_third_state_where_there_are_many(size: int, seed: int, moment) -> None:
    """Some five paths for each state, figures in them."""
    graph = _more_paths(random_graph(size, seed), seed)
    assert _through(plotting.graph_plot(graph, figures={0: moment})) == []


@pytest.mark.parametrize("radius", [0.16, 0.31])
def test_a_way_is_found_between_any_two_places_of_a_full_page(radius: float) -> None:
    """Five rows of three states, no place free: parallel arrows between every two of them come through."""
    places = np.stack(np.meshgrid([-1.0, 0.0, 1.0], np.arange(5.0)), axis=-1).reshape(-1, 2)
    ways = Ways(places, radius)
    for a, b in itertools.combinations(places, 2):
        along = (b - a) / np.hypot(*(b - a))
        found = ways.bundle(a, b, along[::-1] * [-1, 1], [-0.13, 0.13], symmetric=True, paired=False)
        for way in found:
            assert np.hypot(*(way[[0, -1]] - [a, b]).T) == pytest.approx(radius * 1.08, abs=0.03)
            others = [p for p in places if not (np.array_equal(p, a) or np.array_equal(p, b))]
            assert min(_distance(way, p) for p in others) > radius + 0.03
        assert np.abs(found[0] - found[1]).max() > 0.1


@pytest.mark.parametrize("seed", range(6))
def test_arrows_of_mirror_images_are_mirror_images(seed: int) -> None:
    """Of a graph that has all of them; those of a state to itself or to its own image stand beside each other."""
    graph = random_graph(14, seed).racemic()
    image = {s.id: s.id if s.mirror_of is None else s.mirror_of for s in graph.states}
    ax = plotting.graph_plot(graph, figures={0: (performer.limp(seconds=6).motion, 0)})
    centres = np.array([p.center for p in ax.patches if isinstance(p, Circle)])
    ids = [s.id for s in graph.states]
    checked = 0
    curves = _curves(ax)
    for curve in curves:
        first, last = (ids[int(np.hypot(*(centres - end).T).argmin())] for end in curve[[0, -1]])
        if first == last or image[first] == last or (image[first] == first and image[last] == last):
            continue
        mirrored = curve * [-1, 1]
        assert min(min(np.abs(c - mirrored).max(), np.abs(c[::-1] - mirrored).max()) for c in curves) < 1e-6
        checked += 1
    assert checked > 4


def test_the_arrows_of_a_pair_on_the_axis_pass_what_stands_between_on_either_side() -> None:
    """A path and its image from X past Y to W: one left, one right; the symmetric one comes by, too."""
    states = [State(k, symmetric=True) for k in range(3)]
    paths = [Path(0, from_=0, to=1, symmetric=True), Path(1, from_=1, to=2, symmetric=True)]
    paths += [Path(2, from_=0, to=2, mirror_of=3), Path(3, from_=0, to=2, mirror_of=2), Path(4, from_=0, to=2)]
    paths[4] = dataclasses.replace(paths[4], symmetric=True)
    ax = plotting.graph_plot(build(states, paths))
    assert _through(ax) == []
    long = [c for c in _curves(ax) if np.hypot(*(c[-1] - c[0])) > 1.2]
    assert len(long) == 3
    twins = [(a, b) for a, b in itertools.combinations(long, 2) if np.abs(a * [-1, 1] - b).max() < 1e-6]
    assert len(twins) >= 1


def test_a_loop_is_small_where_there_is_little_room(moment) -> None:
    """In the middle of eight other states, joined to all of them, with loops of its own."""
    states = [State(k) for k in range(9)]
    paths = [Path(k, from_=4, to=k, reversible=True) for k in range(9) if k != 4]
    paths += [Path(20 + k, from_=4, to=4) for k in range(3)]
    ax = plotting.graph_plot(build(states, paths), figures={0: moment})
    assert _through(ax) == []
    assert sum(isinstance(p, Polygon) for p in ax.patches) == 2 * 8 + 3


@pytest.mark.parametrize(
    ("names", "arrows"),
    [
        (("14/14_06.amc", "13/13_29.amc", "13/13_30.amc"), 20),
        (("07/07_01.amc", "07/07_05.amc", "91/91_01.amc", "91/91_34.amc", "35/35_01.amc"), 10),
    ],
    ids=["exercises", "walks"],
)
def test_recordings_of_several_movements_show_no_path_that_is_not_there(shared_data, names, arrows: int) -> None:
    """Joint graphs of the CMU library, with figures and without, in either form; no two arrows lie on each other."""
    motions = [kx.read(shared_data / "cmu" / name) for name in names]
    graph = kx.analyze(motions).graph
    figures = plotting.state_moments(graph, motions)
    for shown, condensed in ((figures, False), (figures, True), (None, False)):
        ax = plotting.graph_plot(graph, figures=shown, condensed=condensed)
        assert _through(ax) == []
        curves = _curves(ax)
        assert len(curves) >= arrows
        at, finely = np.arange(48.0), np.linspace(0.0, 47.0, 400)
        fine = [np.stack([np.interp(finely, at, c[:, k]) for k in range(2)], axis=1) for c in curves]
        for (_, a), (b, _) in itertools.combinations(enumerate(curves), 2):
            assert np.mean(np.abs(a[4:-4, None] - fine[b]).max(axis=-1).min(axis=1) < 0.03) < 0.5
