"""The Markov controller: its probabilities, its wishes, its way over the floor."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable
from pathlib import Path as FilePath

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics as kx
from floor_networks import STEPS, Path, floor_network, met, walker
from kinesics.errors import InputError
from kinesics.synthesis.control.controller import Controller
from kinesics.synthesis.control.courses import Course, perform_paths
from kinesics.synthesis.goals import (
    Economy,
    Favour,
    Goal,
    Heading,
    MovingTarget,
    Novelty,
    Onwards,
    OwnFeature,
    Route,
    Situation,
    Speed,
    StateToState,
    Target,
    Targets,
)
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.paths.prospects import Prospects, prospects
from kinesics.synthesis.repertoire import repertoire
from naive import controller as naive

AHEAD, LEFT, RIGHT, STAND = range(4)


@pytest.fixture(scope="module")
def net() -> Network:
    return walker(
        state_from=("A", "A", "A", "A"),
        state_to=("A", "B", "B*", "A"),
        label=("aa_1", "ab_1", "(ab_1)*", "aa_0"),
        class_=("cyclic-antiphase", "asymmetric", "asymmetric", "still"),
    )


@pytest.fixture(scope="module")
def ready(net: Network) -> Prospects:
    return prospects(net, 2.0)


def nearest(course: Course, x: float, z: float) -> float:
    return float(np.hypot(course.ground[:, 0] - x, course.ground[:, 1] - z).min())


# --- the row of P


@given(
    st.floats(-8, 8),
    st.floats(-8, 8),
    st.floats(-math.pi, math.pi),
    st.sampled_from([0.0, 0.5, 3.0, 40.0]),
    st.integers(0, 3),
)
def test_single_paths_are_weighed_as_the_dissertation_says(
    x: float, z: float, heading: float, beta: float, path: int
) -> None:
    """Looking ahead 0 seconds, without bending, P is E(j)·δ with rows summing to 1, as computed path by path."""
    net = walker()
    controller = Controller(
        net, Target((x, z)), beta=beta, lookahead=0.0, bend=0.0, hold=0.0, start=path, heading=heading, position=(1, 2)
    )
    controller.step()
    row = controller.transition()
    expected = naive.markov_row(
        net,
        path,
        controller.now.position,
        controller.now.heading,
        (x, z),
        beta=beta,
        reach=controller.prospects.reach,
        spread=controller.prospects.spread,
    )
    assert row.probabilities.sum() == pytest.approx(1.0)
    for j, p in zip(row.paths, row.probabilities, strict=True):
        assert p == pytest.approx(expected[int(j)], abs=1e-4)


def test_beta_nought_is_a_stroll(net: Network, ready: Prospects) -> None:
    """Every path that may follow is as likely as any other, however far ahead is looked."""
    controller = Controller(net, Target((4.0, 1.0)), beta=0.0, hold=0.0, prepared=ready, start=AHEAD)
    controller.step()
    np.testing.assert_allclose(controller.transition().probabilities, 0.25)


def test_endless_beta_takes_the_best(net: Network, ready: Prospects) -> None:
    """The row of P is then 1 for one path, for the one that every large β favours."""
    rows = []
    for beta in (np.inf, 1e5):
        controller = Controller(net, Target((3.0, 0.5)), beta=beta, prepared=ready, start=AHEAD)
        controller.step()
        rows.append(controller.transition().probabilities)
    assert rows[0].max() == 1.0
    assert np.argmax(rows[0]) == np.argmax(rows[1]) == LEFT


def test_far_targets_leave_no_zero_over_zero(net: Network) -> None:
    """The largest exponent is subtracted first: a target kilometres away still gives a row that sums to 1."""
    controller = Controller(net, Target((-9000.0, 9000.0)), beta=1e6, lookahead=0.0, start=AHEAD)
    controller.step()
    row = controller.transition()
    assert np.isfinite(row.probabilities).all()
    assert row.probabilities.sum() == pytest.approx(1.0)
    assert row.paths[np.argmax(row.probabilities)] == RIGHT


def test_paths_are_drawn_as_often_as_p_says(net: Network) -> None:
    """Over many seeds the first choice comes with the probabilities of the row."""
    goal, rows, drawn = Target((2.0, 2.0)), None, np.zeros(4)
    ready = prospects(net, 0.0)
    for seed in range(800):
        controller = Controller(net, goal, beta=0.3, prepared=ready, start=AHEAD, seed=seed)
        controller.step()
        rows = controller.transition() if rows is None else rows
        drawn[controller.step().path] += 1
    assert rows is not None
    assert rows.probabilities.max() < 0.9
    np.testing.assert_allclose(drawn[rows.paths] / 800, rows.probabilities, atol=0.06)


def test_only_what_may_follow_follows() -> None:
    """δ: a path is never played after one that it may not follow."""
    follows = {"ahead": ["ahead", "left"], "left": ["right"], "right": ["ahead", "stand"], "stand": ["ahead"]}
    net = floor_network(STEPS, follows)
    course = perform_paths(net, Target((-3.0, -3.0)), 40.0)
    assert len(set(course.paths)) > 2
    for before, after in itertools.pairwise(course.paths):
        assert after in net.successors(before)


# --- the same again


@pytest.mark.parametrize("goal", [None, Target((3.0, -2.0)), Novelty(), Route([(0, 0), (0, 3), (3, 3)])])
def test_the_same_seed_gives_the_same_performance(net: Network, ready: Prospects, goal: Goal | None) -> None:
    """All at once, once more, and frame by frame live: the same moments and places."""
    one, two = (perform_paths(net, goal, 8.0, seed=3, prepared=ready) for _ in range(2))
    assert np.array_equal(one.moments, two.moments)
    assert np.array_equal(one.ground, two.ground)
    live = Controller(net, goal, seed=3, prepared=ready)
    frames = [live.frame() for _ in range(len(one.moments))]
    assert [f.moment for f in frames] == one.moments.tolist()
    np.testing.assert_allclose([f.position for f in frames], one.ground, atol=1e-12)
    np.testing.assert_allclose([f.heading for f in frames], one.yaw, atol=1e-12)


def test_another_seed_strolls_elsewhere(net: Network, ready: Prospects) -> None:
    """Without a goal the seed decides."""
    one, two = (perform_paths(net, None, 10.0, seed=s, prepared=ready) for s in (1, 2))
    assert not np.array_equal(one.paths, two.paths)


@given(st.floats(-math.pi, math.pi), st.floats(-5, 5), st.floats(-5, 5))
def test_it_does_not_matter_where_the_world_begins(turn: float, x: float, z: float) -> None:
    """Turned and moved with its target, the performer plays the same paths along the same way, turned and moved."""
    net, target = walker(), (2.5, 1.0)
    ready = prospects(net, 1.0)
    plain = perform_paths(net, Target(target), 5.0, seed=1, prepared=ready, start=AHEAD)
    dx, dz = naive.world_displacement(*target, turn)
    moved = perform_paths(
        net, Target((x + dx, z + dz)), 5.0, seed=1, prepared=ready, start=AHEAD, position=(x, z), heading=turn
    )
    assert np.array_equal(plain.paths, moved.paths)
    expected = [naive.world_displacement(a, b, turn) for a, b in plain.ground]
    np.testing.assert_allclose(moved.ground, np.add(expected, (x, z)), atol=1e-4)


# --- the way over the floor


@pytest.mark.parametrize("aside", [False, True])
def test_without_bending_paths_are_walked_as_recorded(net: Network, aside: bool) -> None:
    """Each path ends at its displacement and turn, composed with those before it and how they meet."""
    net = met(net) if aside else net
    course = perform_paths(net, Target((4.0, 4.0)), 12.0, bend=0.0, start=AHEAD)
    assert np.all(course.bends == 0.0)
    for k in range(1, len(course.paths)):
        # up to the first frame of path k, how it meets the one before included: as if a path of no length followed
        x, z, heading = naive.chain_end(net, course.paths[:k].tolist())
        if net.meeting is not None:
            edge = int(net.edges(course.paths[k - 1], course.paths[k]))
            dx, dz = naive.world_displacement(*net.meeting.place[edge].tolist(), heading)
            x, z, heading = x + dx, z + dz, heading + net.meeting.turn[edge]
        assert course.ground[course.begins[k]] == pytest.approx((x, z), abs=1e-9)
        assert course.yaw[course.begins[k]] == pytest.approx(heading, abs=1e-9)


def test_plans_count_how_paths_meet(net: Network) -> None:
    """Where a plan that is followed leads is where it said, though transitions shift and turn what they enter."""
    net = met(net)
    ready = prospects(net, 2.0)
    controller = Controller(net, Target((2.0, 5.0)), beta=np.inf, bend=0.0, prepared=ready, start=AHEAD, stand=False)
    followed = 0
    controller.step()
    for _ in range(30):
        controller._intention = None
        weighing = controller._weighing
        row = weighing.row(controller.now, weighing.misses(controller.now), None)
        composite = row.best(int(np.argmax(row.probabilities)))
        place, heading = controller.now.place, controller.now.heading
        assert composite.paths[0] == controller.step().path
        rest = controller._intention
        assert rest is not None
        if not rest.trail.places.shape[1]:
            continue
        before = place + composite.trail.places[0, -1] * np.exp(1j * heading)
        after = controller.now.place + rest.trail.places[0, -1] * np.exp(1j * controller.now.heading)
        assert abs(before - after) < 1e-4
        followed += 1
    assert followed > 15


def test_an_edge_is_found_by_its_paths(net: Network) -> None:
    """`Network.edges` finds every successor where it is, and nothing where a path does not follow."""
    assert net.edges(np.repeat(np.arange(len(net)), np.diff(net.indptr)), net.indices).tolist() == list(
        range(len(net.indices))
    )
    some = floor_network([Path("a", 7, 0.4, 0.2), Path("b", 3, 0.1, -0.5)], {"a": ["b"], "b": ["a", "b"]})
    assert some.edges([0, 0, 1], [0, 1, 1]).tolist() == [-1, 0, 2]


def test_bending_turns_every_stride_with_the_metres_walked(net: Network, ready: Prospects) -> None:
    """A bent way is what turning stride by stride makes of it; no bend is larger than allowed; standing turns nothing."""
    controller = Controller(net, Target((1.0, 6.0)), bend=8.0, prepared=ready, start=AHEAD)
    bent = 0
    for _ in range(30):
        step = controller.step()
        assert abs(step.bend) <= math.radians(8.0) + 1e-6
        got, headings = controller.way(step)
        straight, turned = controller.way(step._replace(bend=0.0))
        local = (straight - straight[0]) * np.exp(-1j * step.heading)
        expected, turns = naive.bent_way([(p.imag, p.real) for p in local], step.bend)
        places = np.array([complex(z, x) for x, z in expected]) * np.exp(1j * step.heading) + step.place
        np.testing.assert_allclose(got, places, atol=1e-9)
        np.testing.assert_allclose(headings - turned, turns, atol=1e-9)
        bent += step.bend != 0.0
        if step.path == STAND:
            np.testing.assert_allclose(headings, turned, atol=1e-12)
    assert bent > 0


def test_bending_brings_nearer(net: Network) -> None:
    """With only steps ahead, a target a little aside is reached by bending alone."""
    only = floor_network([Path("ahead", 10, 0.6, 0.0)])
    stiff, bent = (perform_paths(only, Target((1.0, 6.0)), 8.0, bend=b) for b in (0.0, 5.0))
    assert nearest(stiff, 1.0, 6.0) > 0.9
    assert nearest(bent, 1.0, 6.0) < 0.2


# --- wishes


@pytest.mark.parametrize("bend", [0.0, 5.0])
@pytest.mark.parametrize("degrees", range(-150, 181, 30))
def test_targets_all_round_are_reached(net: Network, ready: Prospects, degrees: int, bend: float) -> None:
    """Six metres away in any direction, by one and a half times the straight way and a step at most, and there it stands."""
    x, z = 6.0 * math.sin(math.radians(degrees)), 6.0 * math.cos(math.radians(degrees))
    course = perform_paths(net, Target((x, z)), 30.0, finish=True, bend=bend, prepared=ready, start=AHEAD)
    assert course.attained
    assert nearest(course, x, z) <= 0.5
    # and a metre to turn round
    assert course.length <= (9.2 if abs(degrees) <= 150 else 10.0)
    assert course.paths[-1] == STAND
    assert course.seconds < 20.0
    assert "reached" in course.outcome[0]


def test_after_the_last_target_it_stays_standing(net: Network, ready: Prospects) -> None:
    """Given more time than needed, the rest is spent standing there."""
    course = perform_paths(net, Target((2.0, 3.0)), 30.0, prepared=ready)
    assert np.all(course.paths[-20:] == STAND)
    assert np.hypot(*(course.ground[-1] - [2.0, 3.0])) <= 0.7


def test_several_targets_are_visited_in_order(net: Network, ready: Prospects) -> None:
    """The story names them one after the other, and the way passes each in turn."""
    places = [(2.0, 3.0), (-3.0, 1.0), (0.0, -4.0)]
    course = perform_paths(net, Targets(places), 60.0, finish=True, prepared=ready)
    assert course.attained
    arrivals = [int(np.argmax(np.hypot(*(course.ground - p).T) <= 0.5)) for p in places]
    assert arrivals[0] < arrivals[1]
    assert course.outcome[0].count("reached") == 3


def test_a_moving_target_is_followed(net: Network, ready: Prospects) -> None:
    """Given as a function or as positions, something on a slow circle is caught up with and kept near."""

    def circle(time: float) -> tuple[float, float]:
        return 3.0 * math.sin(0.2 * time), 3.0 * math.cos(0.2 * time)

    track = [circle(k / 10.0) for k in range(600)]
    for goal in (MovingTarget(circle), MovingTarget(track, fps=10.0)):
        course = perform_paths(net, goal, 40.0, prepared=ready)
        where = np.array([circle(k / course.fps) for k in range(len(course.ground))])
        off = np.hypot(*(course.ground - where).T)
        assert np.median(off[200:]) < 0.6
        assert "followed the moving target" in course.outcome[0]


def test_a_route_is_followed_to_its_end(net: Network, ready: Prospects) -> None:
    """A line with a corner, which crosses itself: near it all the way, all of it, in order."""
    corners = np.array([[0, 0], [0, 5], [4, 5], [4, 2], [-3, 2]], dtype=float)
    course = perform_paths(net, Route(corners, haste=0.5), 60.0, finish=True, prepared=ready, start=AHEAD)
    line = Route(corners).sampled()
    off = np.abs((course.ground[:, 1] + 1j * course.ground[:, 0])[:, None] - line)
    assert course.attained
    assert np.median(off.min(axis=1)) < 0.2
    assert off.min(axis=0).max() < 0.9
    assert course.length < 1.3 * Route(corners).length


def test_heading_and_speed_are_kept(net: Network, ready: Prospects) -> None:
    """Facing a direction it ends up facing it; asked for no speed it stands, for much it goes."""
    course = perform_paths(net, Heading(2.0), 20.0, prepared=ready)
    assert abs((course.yaw[-1] - 2.0 + math.pi) % (2 * math.pi) - math.pi) < 0.4
    slow, fast = (perform_paths(net, Speed(v), 20.0, prepared=ready).length for v in (0.0, 1.2))
    assert slow < 2.0
    assert fast > 20.0


@pytest.mark.parametrize(("name", "path"), [("still", STAND), ("(ab_1)*", RIGHT), ("B", LEFT), ("ahead", AHEAD)])
def test_a_class_a_label_a_state_or_a_recording_is_favoured(
    net: Network, ready: Prospects, name: str, path: int
) -> None:
    """Nearly every path played is of the kind wished for."""
    course = perform_paths(net, Favour(name), 20.0, prepared=ready, start=AHEAD)
    assert np.mean(course.paths == path) > 0.9


def test_what_is_favoured_is_found_far_off() -> None:
    """A kind of path that lies many paths away, beyond what is looked ahead to, is gone to."""
    chain = [Path(f"p{k}", 10, 0.1, 0.0) for k in range(12)]
    follows = {f"p{k}": [f"p{(k + 1) % 12}", f"p{k}", f"p{(k - 1) % 12}"] for k in range(12)}
    net = floor_network(chain, follows)
    course = perform_paths(net, Favour("p6"), 30.0, start=0)
    assert np.all(course.paths[-20:] == 6)
    assert len(np.unique(course.paths)) <= 7


def test_novelty_plays_no_path_more_often_than_needed() -> None:
    """Of twenty paths that may all follow each other none is played twice before all were played once."""
    net = floor_network([Path(f"p{k}", 10, 0.1, 0.0) for k in range(20)])
    course = perform_paths(net, Novelty(), 10.0, beta=np.inf, hold=0.0)
    assert np.bincount(course.paths).max() == 1
    twice = perform_paths(net, Novelty(), 20.0, beta=np.inf, hold=0.0)
    assert len(twice.paths) - len(np.unique(twice.paths)) == 20
    assert np.bincount(twice.paths).max() <= 3


def _loop() -> Network:
    """A loop of .3 s, left and entered only .1 s after its jump back, and a way round of 2 s."""
    net = floor_network(
        [Path("in", 2, 0.0, 0.0), Path("back", 4, 0.0, 0.0), Path("round", 40, 0.0, 0.0)],
        {"in": ["back", "round"], "back": ["in"], "round": ["in"]},
    )
    cost = net.cost.copy()
    cost[net.edges(0, 1)] = 0.0
    return dataclasses.replace(net, cost=cost)


def test_no_loop_is_a_prison() -> None:
    """A loop whose jump back is followed too soon by its only way out is left for good, but for what is novel there."""
    net = _loop()
    course = perform_paths(net, [Novelty(), Onwards()], 60.0, start=0)
    share = np.bincount(course.paths, minlength=3) * net.duration / course.seconds
    assert share[2] > 0.8
    assert not np.any(course.paths[1:] == course.paths[:-1])


def test_what_is_played_long_is_no_less_novel_than_what_is_played_often() -> None:
    """Frames count, not paths: a loop of .25 s has no more of the time than its frames are of all frames, or a little."""
    net = floor_network([Path("loop", 5, 0.0, 0.0), Path("long", 60, 0.0, 0.0), Path("other", 35, 0.0, 0.0)])
    course = perform_paths(net, Novelty(), 60.0, beta=np.inf, hold=0.0)
    share = np.bincount(course.paths, minlength=3) * net.duration / course.seconds
    assert share[0] < 0.1


def test_coming_back_at_once_costs_the_more_the_sooner() -> None:
    """By itself in the chain or to what was played before; from a second on it costs nothing."""
    net = floor_network([Path(f"p{k}", frames, 0.0, 0.0) for k, frames in enumerate((4, 6, 12, 30))])
    ready = prospects(net, 2.0)
    pursuit = Onwards().pursuit(net, ready)
    never = Situation(last_played=np.full(4, -np.inf), plays=np.zeros(4, dtype=np.intp))
    costs = [pursuit.chain(chain, never) for chain in ([0, 0, 3], [0, 1, 0, 3], [0, 2, 0, 3], [0, 3, 0, 3])]
    assert costs == sorted(costs, reverse=True)
    assert costs[2] > costs[3] == 0.0
    lately = dataclasses.replace(never, time=5.0, last_played=np.array([-np.inf, 4.5, -np.inf, 3.5]))
    assert pursuit.chain([0, 3], lately) == 0.0
    assert pursuit.chain([1, 3], lately) > pursuit.chain([0, 1, 3], lately) > 0.0


def test_economy_stays_in_the_recording(net: Network, ready: Prospects) -> None:
    """Where going on costs nothing, nothing else is done."""
    course = perform_paths(net, Economy(), 20.0, prepared=ready, start=LEFT)
    assert np.all(course.paths == LEFT)


def test_wishes_together(net: Network, ready: Prospects) -> None:
    """Targets and fewer jumps: there all the same, with fewer transitions than for the targets alone."""
    targets = [(4.0, -3.0), (-4.0, 2.0), (0.0, -5.0), (3.0, 4.0)]

    def jumps(*others: Goal) -> int:
        total = 0
        for target in targets:
            goals = [Target(target), *others]
            course = perform_paths(net, goals, 30.0, finish=True, stand=False, prepared=ready, start=AHEAD)
            assert course.attained
            total += int(np.count_nonzero(np.diff(course.paths)))
        return total

    assert jumps(Economy(1.0)) < jumps()


class Leftwards:
    """A feature of one's own: turn by so much a path."""

    weight = 1.0

    def values(self, network: Network) -> np.ndarray:
        return network.turn

    def wish(self, now: Situation) -> float:
        return math.radians(40) if now.time < 10.0 else math.radians(-40)


def test_a_feature_of_ones_own(net: Network, ready: Prospects) -> None:
    """Its values are compared with its wish, which may change with time."""
    course = perform_paths(net, Leftwards(), 20.0, prepared=ready, start=LEFT)
    early, late = course.paths[course.begins < 160], course.paths[course.begins > 240]
    assert np.mean(early == LEFT) > 0.8
    assert np.mean(late == RIGHT) > 0.8


@pytest.mark.parametrize("goal", [Economy(), Novelty(), Onwards(), Favour("B"), OwnFeature(Leftwards())])
def test_a_chain_of_paths_is_weighed_as_in_the_bundle(net: Network, ready: Prospects, goal: Goal) -> None:
    """What is planned and what the bundle offers are measured alike."""
    controller = Controller(net, goal, prepared=ready, start=LEFT)
    for _ in range(9):
        controller.step()
    pursuit, path = goal.pursuit(net, ready), controller.now.path
    first, last = ready.start[net.indptr[path]], ready.start[net.indptr[path + 1]]
    misses = pursuit.miss(slice(int(first), int(last)), controller.now, 0.0)
    chains = [ready.sequence[row] for row in range(first, last)]
    by_hand = [pursuit.chain(chain[chain >= 0].tolist(), controller.now) for chain in chains]
    assert np.ptp(misses) > 0.0
    np.testing.assert_allclose(by_hand, misses, rtol=1e-4, atol=1e-7)


def test_own_features_are_checked(net: Network, ready: Prospects) -> None:
    """Values of the wrong shape, and wishes that are no numbers, are refused by the feature's name."""

    class Crooked(Leftwards):
        def values(self, network: Network) -> np.ndarray:
            return network.turn[:-1]

    class Vague(Leftwards):
        def wish(self, now: Situation) -> float:
            return math.nan

    with pytest.raises(InputError, match=r"`values` of Crooked.*\(4,\)"):
        Controller(net, Crooked(), prepared=ready)
    with pytest.raises(InputError, match="`wish` of Vague"):
        perform_paths(net, Vague(), 5.0, prepared=ready)


def test_from_state_to_state_by_the_shortest_way() -> None:
    """It begins in the one state and plays the quickest chain of paths to the other."""
    paths = [Path("ab", 4, 0.1, 0.0), Path("bc", 4, 0.1, 0.0), Path("ad", 2, 0.1, 0.0), Path("dd", 9, 0.1, 0.0),
             Path("dc", 3, 0.1, 0.0), Path("ca", 5, 0.1, 0.0)]  # fmt: skip
    follows = {"ab": ["bc"], "bc": ["ca"], "ad": ["dd"], "dd": ["dc"], "dc": ["ca"], "ca": ["ab", "ad"]}
    net = floor_network(paths, follows, state_from=tuple("ABADDC"), state_to=tuple("BCDDCA"))
    for start in (None, 5, 3):
        course = perform_paths(net, StateToState("A", "C"), 5.0, start=start, finish=True)
        assert course.paths.tolist()[-2:] == [0, 1]
        assert course.attained
        assert course.outcome == ("A to C in 2 paths, 0.40 s",)


def test_what_there_is_no_time_for_is_not_attained() -> None:
    """A last path cut short is not come to the end of: neither a state nor a place beyond."""
    net = floor_network([Path("ab", 4, 0.1, 0.0), Path("ba", 4, 0.1, 0.0)], {"ab": ["ba"], "ba": ["ab"]},
                        state_from=("A", "B"), state_to=("B", "A"))  # fmt: skip
    for frames in range(3, 6):
        course = perform_paths(net, StateToState("A", "B"), frames / net.repertoire.fps, start=0, finish=True)
        assert course.attained == (frames >= 4)
    place = Target((0.0, 0.1), radius=0.03)  # a path leads .1 m, in four frames of .025 m
    for frames, there in ((2, False), (3, False), (4, True)):
        course = perform_paths(net, place, frames / net.repertoire.fps, start=0, bend=0.0, stand=False)
        assert course.attained == there, (course.ground, course.outcome)


def test_goals_can_be_changed_while_it_goes_on(net: Network, ready: Prospects) -> None:
    """Live, the next decision obeys the new wish."""
    controller = Controller(net, Target((0.0, 8.0)), prepared=ready, start=AHEAD)
    for _ in range(6):
        controller.step()
    controller.pursue(Favour("still"))
    assert [controller.step().path for _ in range(5)][-1] == STAND


# --- what cannot be


def test_what_was_not_reached_is_said(net: Network, ready: Prospects) -> None:
    """Too far for the time given: not attained, and how near it came."""
    course = perform_paths(net, Target((0.0, 100.0)), 10.0, prepared=ready, start=AHEAD)
    assert not course.attained
    assert course.outcome[0].startswith("did not reach (0.00, 100.00): came within ")
    said = float(course.outcome[0].split()[-2])
    assert said == pytest.approx(nearest(course, 0.0, 100.0), abs=0.6)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Target((math.nan, 1.0)), "finite numbers"),
        (lambda: Target((1.0, 2.0, 3.0)), "two numbers"),
        (lambda: Target("there"), "two numbers"),
        (lambda: Target((1e9, 0.0)), "within 10000 m"),
        (lambda: Target((1.0, 2.0), radius=0.0), "`radius`"),
        (lambda: Target((1.0, 2.0), weight=-1.0), "`weight`"),
        (lambda: Targets([]), "at least one"),
        (lambda: Targets([(0, 0), (1, math.inf)]), "target 2"),
        (lambda: MovingTarget([(0.0, 1.0)]), "`fps`"),
        (lambda: Route([(0.0, 1.0)]), r"n at least 2, got \(1, 2\)"),
        (lambda: Route([(0.0, 1.0), (0.0, 1.0)]), "one place"),
        (lambda: Route([(0.0, 1.0), (math.nan, 1.0)]), "number 1"),
        (lambda: Route("circle"), "shape"),
        (lambda: Heading(math.inf), "`heading`"),
        (lambda: Speed(-1.0), "speed"),
        (lambda: Novelty(forget=0.0), "`forget`"),
        (lambda: Onwards(within=0.0), "`within`"),
        (lambda: StateToState("A", "B", by="hops"), "seconds, cost"),
        (lambda: StateToState("A", ""), "name of a state, got an empty one"),
        (lambda: Targets(3), "`positions`.*got 3"),
        (lambda: Target((1.0, 2.0), radius="near"), "`radius` above 0, got 'near'"),
        (lambda: Heading("left"), "`heading` to be a finite number, got 'left'"),
        (lambda: Speed(None), "`speed` of 0 or more metres a second, got None"),
        (lambda: Novelty(forget="soon"), "`forget`.*got 'soon'"),
        (lambda: Favour(7), "as text, got 7"),
        (lambda: Favour(" "), "got an empty one"),
        (lambda: Route([(0.0, 1.0), (2.0, 1.0)], haste=None), "`haste`"),
    ],
)
def test_impossible_wishes_are_refused(make: Callable[[], object], words: str) -> None:
    """The message says what was expected."""
    with pytest.raises(InputError, match=words):
        make()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"seconds": 0.0}, "`seconds`"),
        ({"seconds": math.nan}, "`seconds`"),
        ({"beta": -1.0}, "`beta`"),
        ({"beta": math.nan}, "`beta`"),
        ({"bend": -5.0}, "`bend`"),
        ({"start": 4}, "0 to 3"),
        ({"position": (0.0, math.nan)}, "`position`"),
        (
            {"goal": Favour("walks")},
            r"No class, label, state, phrase or recording 'walks'. There are, with .*\n(.*\n)*  states: A \(on",
        ),
        ({"goal": Favour("cyclic-antifase")}, "Did you mean cyclic-antiphase"),
        ({"goal": StateToState("A", "C")}, "state"),
        ({"goal": 3.0}, "Expected a goal"),
    ],
)
def test_bad_calls_are_refused(net: Network, ready: Prospects, arguments: dict[str, object], words: str) -> None:
    """By name, with what there is instead."""
    with pytest.raises(InputError, match=words):
        perform_paths(net, **({"prepared": ready, "seconds": 5.0} | arguments))


def test_a_network_without_words_says_where_they_come_from() -> None:
    """Wishing for a state before the grammar was read names the function that reads it."""
    with pytest.raises(InputError, match="labelled"):
        perform_paths(walker(), StateToState("A", "B"), 5.0)


def test_a_bundle_of_another_network_is_refused(ready: Prospects) -> None:
    """Prospects and network belong together."""
    with pytest.raises(InputError, match="another network"):
        Controller(floor_network(STEPS[:2]), prepared=ready)


# --- on real recordings


def test_real_walks_go_where_they_are_sent(shared_data: FilePath) -> None:
    """From two CMU walks and their mirror images, targets on four sides are reached by near the straight way."""
    names = ("91/91_01", "07/07_01")
    walks = network(repertoire([kx.read(shared_data / "cmu" / f"{n}.amc") for n in names], fps=30.0))
    ready = prospects(walks)
    ratios = []
    for seed, (x, z) in enumerate([(5.0, 0.0), (-5.0, 0.0), (0.0, 5.0), (0.0, -5.0)]):
        course = perform_paths(walks, Target((x, z)), 30.0, seed=seed, finish=True, stand=False, prepared=ready)
        assert nearest(course, x, z) <= 0.5, course.outcome
        ratios.append(course.length / 5.0)
    assert np.median(ratios) <= 1.5


@pytest.mark.parametrize("beta", [0.0, 100.0, np.inf])
def test_one_sets_out_at_once(net: Network, ready: Prospects, beta: float) -> None:
    """With somewhere to go the first path is no standing; on a stroll it is any."""
    opening = Controller(net, Target((0.0, 6.0)), beta=beta, prepared=ready).transition()
    assert opening.probabilities.sum() == pytest.approx(1.0)
    if beta:
        assert opening.probabilities[STAND] < 0.1
    else:
        np.testing.assert_allclose(opening.probabilities, 0.25)
    np.testing.assert_allclose(Controller(net, None, prepared=ready).transition().probabilities, 0.25)


def test_starts_are_drawn_by_seed(net: Network, ready: Prospects) -> None:
    """Other seeds begin otherwise, the same alike."""
    firsts = [Controller(net, Target((0.0, 6.0)), seed=s % 20, prepared=ready).step().path for s in range(40)]
    assert firsts[:20] == firsts[20:]
    assert len(set(firsts)) > 1
