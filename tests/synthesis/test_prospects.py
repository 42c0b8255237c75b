"""What may come after each path."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from floor_networks import Path, floor_network, met, walker
from kinesics.errors import InputError
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.paths.prospects import Prospects, prospects
from kinesics.synthesis.paths.trails import trails
from naive import controller as naive


@pytest.fixture(scope="module")
def network() -> Network:
    return walker()


@pytest.fixture(scope="module")
def ahead(network: Network) -> Prospects:
    return prospects(network, 2.0)


def test_looking_ahead_zero_seconds_gives_the_successors_themselves(network: Network) -> None:
    """One row a successor, with its displacement and turn: the dissertation's own features."""
    got = prospects(network, 0.0)
    assert np.array_equal(got.sequence[:, 0], network.indices)
    assert np.array_equal(got.start, np.arange(len(network.indices) + 1))
    expected = network.displacement[network.indices]
    places = got.trail.places[:, 0]
    np.testing.assert_allclose(np.stack([places.imag, places.real], axis=1), expected, atol=1e-6)
    np.testing.assert_allclose(got.trail.headings[:, 0], network.turn[network.indices], atol=1e-6)


def test_every_successor_begins_some_composite(network: Network, ahead: Prospects) -> None:
    """Thinning never takes a path that may follow out of the row of P."""
    assert np.all(np.diff(ahead.start) >= 1)
    for edge, path in enumerate(network.indices):
        assert np.all(ahead.sequence[ahead.start[edge] : ahead.start[edge + 1], 0] == path)


def test_composites_follow_the_network_and_last_long_enough() -> None:
    """Each path of a composite may follow the one before it."""
    network = floor_network(
        [Path("a", 7, 0.4, 0.2), Path("b", 3, 0.1, -0.5), Path("c", 11, 0.9, 0.0)],
        {"a": ["b", "c"], "b": ["c"], "c": ["a", "c"]},
    )
    got = prospects(network, 1.5)
    assert len(got.sequence) >= len(network.indices)
    for sequence in got.sequence:
        paths = sequence[sequence >= 0]
        assert network.duration[paths].sum() >= 1.5
        for before, after in itertools.pairwise(paths):
            assert after in network.successors(before)


@pytest.mark.parametrize("aside", [False, True])
def test_trails_are_those_of_the_paths_one_after_the_other(network: Network, ahead: Prospects, aside: bool) -> None:
    """Places and headings at the ends of paths equal those composed path by path, also where transitions shift and turn."""
    if aside:
        network = met(network)
        ahead = prospects(network, 2.0)
    row_of = np.searchsorted(ahead.start, np.arange(len(ahead.sequence)), side="right") - 1
    owner = np.searchsorted(network.indptr, row_of, side="right") - 1
    compared = 0
    for row in range(0, len(ahead.sequence), 7):
        paths = ahead.sequence[row][ahead.sequence[row] >= 0].tolist()
        times = np.cumsum(network.duration[paths])
        for k, time in enumerate(times, start=1):
            point = np.flatnonzero(np.isclose(ahead.trail.times[0], time))
            if len(point):
                x, z, heading = naive.chain_end(network, paths[:k], int(owner[row]))
                place = ahead.trail.places[row, point[0]]
                assert (place.imag, place.real) == pytest.approx((x, z), abs=1e-5)
                assert ahead.trail.headings[row, point[0]] == pytest.approx(heading, abs=1e-5)
                compared += 1
    assert compared > 100


def test_swerve_is_how_the_trail_moves_when_it_is_bent(ahead: Prospects) -> None:
    """The first-order change agrees with bending the trail's chords by a small angle."""
    bend = 1e-4
    for row in range(0, len(ahead.sequence), 23):
        places = np.concatenate([[0.0], ahead.trail.places[row].astype(np.complex128)])
        bent, _ = naive.bent_way([(p.imag, p.real) for p in places], bend)
        moved = (np.array([complex(z, x) for x, z in bent]) - places)[1:] / bend
        np.testing.assert_allclose(ahead.trail.swerve[row], moved, atol=2e-3)


def test_jumps_come_no_sooner_than_the_hold(network: Network) -> None:
    """Where every recording can be kept on, none is left within the hold of the jump before."""
    got = prospects(network, 2.0, hold=0.6)
    holds: list[float] = []
    for sequence in got.sequence:
        paths = sequence[sequence >= 0]
        jumps = np.flatnonzero(np.diff(paths) != 0) + 1
        begins = np.concatenate([[0.0], np.cumsum(network.duration[paths])])
        holds.extend(np.diff(begins[jumps]).tolist())
    assert holds
    assert min(holds) >= 0.6 - 1e-9


def test_first_jump_is_when_a_recording_is_left(network: Network, ahead: Prospects) -> None:
    """At once if the first path is jumped to, else when the chain leaves the first recording."""
    owner = np.repeat(np.arange(len(network.first)), np.diff(ahead.start[network.indptr]))
    for row in range(0, len(ahead.sequence), 11):
        chain = [owner[row], *ahead.sequence[row][ahead.sequence[row] >= 0].tolist()]
        expected, time = np.inf, 0.0
        for before, after in itertools.pairwise(chain):
            if before != after:
                expected = time
                break
            time += network.duration[after]
        got = ahead.first_jump[row]
        assert got == pytest.approx(expected) if np.isfinite(expected) else got >= 1e6


def test_what_comes_twice_in_a_composite_is_known(network: Network, ahead: Prospects) -> None:
    """For every path how long ago it began before, and how much its frames count, as found one by one."""
    rows = slice(int(ahead.start[2]), int(ahead.start[5]))
    again, shares = ahead.again(rows), ahead.shares(rows)
    assert np.isfinite(again).any()
    for row, sequence in enumerate(ahead.sequence[rows]):
        began: dict[int, float] = {}
        time = 0.0
        for column, path in enumerate(sequence[sequence >= 0].tolist()):
            assert again[row, column] == pytest.approx(time - began.get(path, -np.inf), rel=1e-5)
            began[path] = time
            time += network.duration[path]
        assert np.isinf(again[row, (sequence >= 0).sum() :]).all()
        assert shares[row].sum() == pytest.approx(1.0, rel=1e-5)
        assert not shares[row, sequence < 0].any()


def test_the_same_seed_gives_the_same_bundle(network: Network) -> None:
    """Nothing depends on anything but network and seed; another seed gives another bundle."""
    small = floor_network([Path(f"p{k}", 4, 0.1 * k, 0.3 * k - 1.0) for k in range(8)])
    one, two, other = (prospects(small, 2.0, seed=s).sequence for s in (4, 4, 5))
    assert np.array_equal(one, two)
    assert one.shape != other.shape or not np.array_equal(one, other)


def test_trails_of_the_root_end_where_the_network_says(network: Network) -> None:
    """The last point of each path is its displacement, the last heading its turn, also beyond half a turn."""
    spun = floor_network([Path("spin", 40, 1.0, 7.0), *[Path("on", 4, 0.2, 0.0)]])
    for net in (network, spun):
        ways = trails(net)
        end = ways.start + net.length
        np.testing.assert_allclose(ways.places[end].imag, net.displacement[:, 0], atol=1e-9)
        np.testing.assert_allclose(ways.places[end].real, net.displacement[:, 1], atol=1e-9)
        np.testing.assert_allclose(ways.headings[end], net.turn, atol=1e-9)
        assert np.all(ways.places[ways.start] == 0.0)


@pytest.mark.parametrize("bad", [{"lookahead": -1.0}, {"lookahead": np.nan}, {"hold": np.inf}])
def test_seconds_must_be_seconds(network: Network, bad: dict[str, float]) -> None:
    """Negative or endless spans are refused, by name."""
    with pytest.raises(InputError, match=f"`{next(iter(bad))}`"):
        prospects(network, **bad)
