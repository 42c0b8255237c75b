"""Graphs read from performances are the graphs that were performed."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from kinesics.grammar import assembly, classes, cyclic, moments, reading
from kinesics.grammar.graph import MotionGraph
from kinesics.grammar.reading import visits
from kinesics.grammar.reading.seen import Seen
from kinesics.grammar.whole import read_grammar
from kinesics.performer.random_graphs import covering_steps, random_graph
from kinesics.vocabulary import MovementClass as C
from performed_graphs import performed


def read_graph(poses: kx.PoseSequence) -> MotionGraph:
    m = moments.from_poses(poses)
    return assembly.assemble(reading.read(m), m, "recording")


def traversed(
    seed: int, *, states: int, noise: float = 1.0, jitter: float = 0.05, fps: float = 60.0
) -> tuple[MotionGraph, kx.PoseSequence]:
    graph = random_graph(states=states, seed=seed)
    done = kx.performer.traverse(
        graph, covering_steps(graph, seed=seed), fps=fps, noise_degrees=noise, tempo_jitter=jitter, seed=seed
    )
    return performed(done.truth), kx.poses(done.motion)


@pytest.mark.parametrize(("seed", "states"), [(0, 3), (1, 4), (2, 5), (4, 7), (7, 10)])
def test_random_graphs_are_recovered(seed: int, states: int) -> None:
    """Random graphs traversed with noise and wavering tempo read back the same, but for states that leave no trace."""
    truth, poses = traversed(seed, states=states)
    assert read_graph(poses).contracted().isomorphic_to(truth.contracted())


def test_a_wrong_graph_is_not_taken_for_right() -> None:
    """The comparison can fail: the graph of one performance is not that of another."""
    truth, _ = traversed(1, states=4)
    _, poses = traversed(2, states=5)
    assert not read_graph(poses).contracted().isomorphic_to(truth.contracted())


def test_the_mirrored_recording_gives_the_mirrored_graph() -> None:
    """Left and right exchanged, the graph is the same with every state and path reflected."""
    _, poses = traversed(2, states=5)
    assert read_graph(poses.mirror()).isomorphic_to(read_graph(poses).mirrored())


def test_the_reversed_recording_turns_every_one_way_arrow() -> None:
    """Played backwards, a recording gives the graph with its one-way paths turned round."""
    _, poses = traversed(1, states=4)
    forwards, backwards = read_graph(poses).contracted(), read_graph(poses[::-1]).contracted()
    assert backwards.isomorphic_to(forwards.reversed_in_time())
    assert not backwards.isomorphic_to(forwards)


def test_frame_rate_and_heading_change_nothing() -> None:
    """At 30 frames a second, and turned about the vertical, the same graph is read."""
    truth, fast = traversed(1, states=4, fps=120.0)
    slow = kx.PoseSequence(fast.quaternions[::4], fast.yaw[::4] + 1.0, fast.ground[::4] + 3.0, 30.0)
    a, b = read_graph(fast), read_graph(slow)
    assert a.isomorphic_to(b)
    assert a.contracted().isomorphic_to(truth.contracted())


@pytest.mark.parametrize(("frames", "size"), [(1, 0.0), (2, 0.1), (5, 0.1), (40, 0.0)])
def test_next_to_nothing_is_read_as_such(frames: int, size: float, rng: np.random.Generator) -> None:
    """One pose, a few frames and a body that stands still give a graph that accounts for every frame."""
    from kinesics.geometry import quaternion

    q = np.tile(quaternion.identity((15,)), (frames, 1, 1))
    q[:, 9] = quaternion.from_rotvec(np.linspace(0, size, frames)[:, None] * np.array([0, 0, 1.0]))
    poses = kx.PoseSequence(q, np.zeros(frames), np.zeros((frames, 2)), 30.0)
    graph = read_graph(poses)
    assert sum(s.end - s.start for s in graph.timeline()) == frames


@pytest.mark.parametrize(
    ("name", "paths"),
    [
        ("butterfly", {"xx~_1": False}),
        ("jumping_jacks", {"yx~_1": True}),
        ("jog_in_place", {"xa_1": True, "(xa_1)*": True}),
        ("walk", {"aa*_1": False, "(aa*_1)*": False}),
        ("limp", {"aa_1": False}),
        ("wave", {"ba_1": True}),
        ("arm_circles", {"yx_1": True, "(yx_1)*": True}),
    ],
)
def test_the_short_studies(name: str, paths: dict[str, bool]) -> None:
    """Each cyclic class has the graph that the dissertation draws for it (§3.5), whichever of its states comes first."""
    done = kx.performer.perform(name, fps=60, noise_degrees=0.5, seconds=8)
    m = moments.from_poses(kx.poses(done.motion))
    cuts = [m.moment_of(c) for c in done.truth.cycles]
    stretch = cyclic.structure(m, 0, m.count, done.truth.class_, cuts)
    assert stretch is not None
    graph = assembly.assemble(reading.read(m, [stretch]), m, name)
    assert graph.isomorphic_to(graph.mirrored() if name != "limp" and name != "wave" else graph)
    found = {p.label: p.reversible for p in graph.paths}
    assert len(found) == len(paths)
    assert sorted(found.values()) == sorted(paths.values())
    assert {p.symmetric for p in graph.paths} == {"~" in label for label in paths}
    symmetric_states = sum(s.symmetric for s in graph.states)
    assert symmetric_states == {"butterfly": 1, "jumping_jacks": 2, "jog_in_place": 1, "arm_circles": 2}.get(name, 0)
    assert sum(s.end - s.start for s in graph.timeline()) == done.motion.frame_count


def test_cyclic_anchors_come_in_order_and_once() -> None:
    """Anchors of a cyclic stretch follow one another in time, and between two of them lies one leg."""
    done = kx.performer.perform("jog_in_place", fps=60, seconds=6, tempo_jitter=0.08)
    m = moments.from_poses(kx.poses(done.motion))
    found = cyclic.structure(m, 0, m.count, C.CYCLIC_ANTIPHASE_PALINDROMIC, [m.moment_of(c) for c in done.truth.cycles])
    assert found is not None
    assert all(b.moment > a.moment for a, b in itertools.pairwise(found.anchors))
    assert len(found.legs) == len(found.anchors) - 1
    assert cyclic.structure(m, 0, m.count, C.PALINDROMIC, [0, 20, 40]) is None
    assert cyclic.structure(m, 0, m.count, C.CYCLIC_ANTIPHASE, [0]) is None


def test_side_kicks_of_a_real_recording(shared_data: Path) -> None:
    """CMU 135_11 reads as a stance that is returned to kick after kick, and, after a turn, its mirror image (Fig. 69)."""
    graph = read_graph(kx.poses(kx.read(shared_data / "cmu/135/135_11.amc")))
    stances = [s for s in graph.states if s.mirror_of is not None and len(s.stays) >= 3]
    assert len(stances) == 2
    left, right = stances
    assert left.mirror_of == right.id
    assert max(stay.end for stay in left.stays) < min(stay.start for stay in right.stays)


def test_classes_lead_to_graphs_on_real_exercises(shared_data: Path) -> None:
    """CMU jumping jacks read as two symmetric states and one way between them, both ways (Fig. 65)."""
    motion = kx.read(shared_data / "cmu/13/13_29.amc")[0:456]
    m = moments.from_poses(kx.poses(motion))
    verdict = classes.classify(m)
    assert verdict.class_ is C.CYCLIC_SYMMETRIC_PALINDROMIC
    cuts = [m.moment_of(c.start) for c in verdict.cycles] + [m.moment_of(verdict.cycles[-1].end)]
    stretch = cyclic.structure(m, 0, m.count, verdict.class_, cuts)
    assert stretch is not None
    graph = assembly.assemble(reading.read(m, [stretch]), m, "jacks")
    assert [p.reversible for p in graph.paths] == [True]
    assert [s.symmetric for s in graph.states] == [True, True]


@pytest.mark.parametrize(("fps", "seed"), [(30.0, 1), (60.0, 2), (120.0, 1)])
def test_side_kicks_of_the_performer(fps: float, seed: int) -> None:
    """The graph of §3.5.6 is read: a kick on either side, and the turn through a symmetric stance near the guards."""
    done = kx.performer.side_kicks(fps=fps, seed=seed, noise_degrees=0.5)
    graph = read_grammar(kx.poses(done.motion)).graph
    assert graph is not None
    assert graph.isomorphic_to(performed(done.truth))
    assert [s.symmetric for s in graph.states].count(True) == 1


@pytest.mark.parametrize(("fps", "seed"), [(30.0, 1), (60.0, 2), (120.0, 1)])
def test_the_sun_salutation(fps: float, seed: int) -> None:
    """The graph of §3.6.1 is read: one leg goes back after the other on a way of its own, and both return together."""
    done = kx.performer.sun_salutation(fps=fps, seed=seed, noise_degrees=0.5)
    graph = read_grammar(kx.poses(done.motion)).graph
    assert graph is not None
    assert graph.isomorphic_to(performed(done.truth))
    assert [p.reversible for p in graph.paths if not p.symmetric] == [False]


def test_a_stop_nearly_its_own_mirror_image_is_one_stay() -> None:
    """Who sways from one side of a nearly symmetric pose to the other while standing is in one state, not in two by turns."""
    down = np.linspace(1.0, 0.0, 20)
    sway = 0.04 * np.cos(np.linspace(0.0, np.pi, 4))
    side = np.concatenate([np.full(20, 0.04), sway, np.full(20, -0.04)])
    height = np.concatenate([down, np.zeros(4), down[::-1]])

    def half_squared(x: float) -> np.ndarray:
        return 0.5 * ((side[:, None] - x * side[None, :]) ** 2 + (height[:, None] - height[None, :]) ** 2)

    seen = moments.from_distances(half_squared(1.0), half_squared(-1.0), fps=30.0)
    state = reading.ReadState(moment=20, symmetric=False, traced=True)
    found = visits.find_visits(Seen(seen, 0.01, ()), [state])
    assert [(v.state, v.mirrored) for v in found] == [(0, False)]
    assert found[0].start <= 19
    assert found[0].end >= 25
