"""Shortest ways over the network, and where one can stand."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest

from floor_networks import Path, floor_network, walker
from kinesics.synthesis.paths import ways
from kinesics.synthesis.paths.network import Network
from naive import controller as naive


def random_network(rng: np.random.Generator, paths: int = 12) -> Network:
    names = [f"p{k}" for k in range(paths)]
    steps = [Path(n, int(rng.integers(1, 9)), float(rng.uniform(0, 1)), float(rng.uniform(-1, 1))) for n in names]
    follows = {n: list(rng.choice(names, size=2, replace=False)) for n in names}
    return floor_network(steps, follows)


def mask(network: Network, *paths: int) -> np.ndarray:
    out = np.zeros(len(network.first), dtype=np.bool_)
    out[list(paths)] = True
    return out


@pytest.mark.parametrize("seed", range(5))
def test_seconds_to_a_path_agree_with_relaxing_by_hand(seed: int) -> None:
    """Dijkstra on the reversed graph gives what trying every succession gives, unreachable ones included."""
    network = random_network(np.random.default_rng(seed))
    got = ways.seconds_to(network, mask(network, 2, 5))
    np.testing.assert_allclose(got, naive.seconds_to(network, [2, 5]), rtol=1e-12)


@pytest.mark.parametrize("by", ways.MEASURES)
def test_the_shortest_way_follows_the_network(rng: np.random.Generator, by: str) -> None:
    """It begins at an origin, ends at a goal, and each path may follow the one before."""
    network = random_network(rng)
    origins = mask(network, 0, 1, 3)
    way = ways.shortest(network, origins, mask(network, 7), by=by)
    assert way is not None
    assert origins[way[0]]
    assert way[-1] == 7
    for before, after in itertools.pairwise(way):
        assert after in network.successors(before)
    if by == "seconds":
        lasted = network.duration[way[:-1]].sum()
        for before, after in itertools.pairwise(way):
            edges = np.arange(network.indptr[before], network.indptr[before + 1])
            cost = network.cost[edges[network.indices[edges] == after]].min()
            lasted += ways.JUMP * (1.0 + cost) if cost > 0.0 else 0.0
        assert lasted == pytest.approx(min(naive.seconds_to(network, [7], ways.JUMP)[k] for k in (0, 1, 3)))


def test_what_was_recorded_is_travelled_rather_than_leapt_over() -> None:
    """A leap of a fifth of a second is left out for two seconds of the recording, but not for many."""

    def way(frames: int) -> list[int] | None:
        paths = [Path("from", 4, 0.1, 0.0), Path("between", frames, 1.0, 0.0), Path("to", 4, 0.1, 0.0)]
        made = floor_network(paths, {"from": ["between", "to"], "between": ["to"], "to": ["from"]})
        cost = made.cost.copy()
        cost[[0, 2]] = 0.0  # the recording goes on: from, between, to
        return ways.shortest(dataclasses.replace(made, cost=cost), mask(made, 0), mask(made, 2))

    assert way(40) == [0, 1, 2]
    assert way(400) == [0, 2]


def test_by_cost_a_longer_way_without_jumps_is_preferred() -> None:
    """Staying in the recordings counts before seconds."""
    network = walker()
    # from "ahead" to "left" there is one jump either way; by seconds through nothing, by cost no more jumps than needed
    assert ways.shortest(network, mask(network, 0), mask(network, 1), by="cost") == [0, 1]


def test_no_way_is_no_way() -> None:
    """Where nothing leads there, there is no shortest way."""
    network = floor_network([Path("a", 2, 0.1, 0.0), Path("b", 2, 0.1, 0.0)], {"a": ["a"], "b": ["b"]})
    assert ways.shortest(network, mask(network, 0), mask(network, 1)) is None
    assert np.isinf(ways.seconds_to(network, mask(network, 1))[0])
    assert ways.next_towards(network, mask(network, 1))[0] == -1


def test_stances_can_be_kept_for_ever() -> None:
    """A path that stands but must be left for walking is no stance; neither is turning or stepping on the spot."""
    paths = [
        Path("walk", 10, 0.7, 0.0),
        Path("pause", 10, 0.0, 0.0),
        Path("stand", 10, 0.01, 0.0),
        Path("spin", 10, 0.0, 1.5),
    ]
    everywhere = [p.name for p in paths]
    network = floor_network(
        paths, {"walk": everywhere, "pause": ["walk"], "stand": ["stand", "walk"], "spin": ["spin", "walk"]}
    )
    assert ways.stances(network).tolist() == [False, False, True, False]


def test_a_path_in_which_the_recording_leaps_is_gone_round() -> None:
    """Unless any other way takes ten seconds longer; and what the last path takes counts, too."""
    paths = [
        Path("leap", 2, 0.0, 0.0),
        Path("out", 20, 0.0, 0.0),
        Path("back", 10, 0.0, 0.0),
        Path("slow", 90, 0.0, 0.0),
    ]
    net = floor_network(paths, {"leap": ["back"], "out": ["back", "slow"], "back": ["leap", "out"], "slow": ["back"]})
    origins, goals = np.array([True, True, False, False]), np.array([True, False, True, True])
    assert ways.shortest(net, origins, goals) == [0]
    faulty = np.array([True, False, False, False])
    assert ways.shortest(net, origins, goals, avoiding=faulty) == [1, 2]
    assert ways.shortest(net, faulty, faulty, avoiding=faulty) == [0]


def test_what_leads_to_a_path_and_what_follows_it() -> None:
    """As recorded and so long, a little more where half would be missing; by a transition where the recording ends."""
    paths = [Path(f"p{k}", 10, 0.0, 0.0) for k in range(6)]
    net = floor_network(paths, {f"p{k}": [f"p{(k + 1) % 6}", f"p{(k + 3) % 6}"] for k in range(6)})
    cost = np.where(net.indices == (np.repeat(np.arange(6), 2) + 1) % 6, 0.0, 0.5)
    cost[net.edges(5, 0)] = 0.7
    net = dataclasses.replace(net, cost=cost)
    assert ways.leading_to(net, 3, 1.0, 9.0) == [1, 2]
    assert ways.following(net, 1, 1.2, 9.0) == [2, 3]
    assert ways.following(net, 5, 0.6, 9.0) == [2]
    assert ways.following(net, 1, 0.2, 9.0) == [2]
    assert ways.following(net, 1, 0.2, 0.3) == []


def test_what_lies_between_two_paths_is_what_leads_from_the_one_to_the_other() -> None:
    """With what is gone within so many seconds before and after, where there is any; dead ends aside are left out."""
    names = ["early", "before", "from", "between", "aside", "to", "after", "late"]
    follows = {
        "early": ["before"],
        "before": ["from"],
        "from": ["between", "aside"],
        "between": ["to"],
        "aside": [],
        "to": ["after"],
        "after": ["late"],
        "late": [],
    }
    network = floor_network([Path(name, 10, 0.5, 0.0) for name in names], follows)
    lasts = float(network.duration[0])

    def kept(begin: int, end: int, paths: float) -> list[str]:
        return [
            names[k] for k in np.flatnonzero(ways.between(network, mask(network, begin), mask(network, end), paths))
        ]

    assert kept(2, 5, 0.0) == ["from", "between", "to"]
    assert kept(2, 5, 1.5 * lasts) == ["before", "from", "between", "to", "after"]
    assert kept(0, 7, 10.0 * lasts) == [name for name in names if name != "aside"]
    assert kept(5, 2, 10.0 * lasts) == kept(4, 5, 10.0 * lasts) == []
    assert ways.following(network, 6, 5.0 * lasts, 10.0 * lasts) == [7]
    assert ways.leading_to(network, 1, 5.0 * lasts, 10.0 * lasts) == [0]
