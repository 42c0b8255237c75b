"""Which pairs of seams are used: the lowest, the best of every second, and what joins."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from bodies import about, moving
from kinesics.similarity import check_weights
from kinesics.synthesis.joining import transitions as transitions_module
from kinesics.synthesis.joining.choice import best, best_of_steps, joining, lowest
from kinesics.synthesis.joining.limits import find_limits
from kinesics.synthesis.joining.parts import draft, largest_part
from kinesics.synthesis.joining.seams import Pairs, Seams, ways
from kinesics.synthesis.joining.search import search
from kinesics.synthesis.joining.sharing import Shared, refined
from kinesics.synthesis.joining.transitions import transitions
from kinesics.synthesis.paths.network import network
from kinesics.synthesis.repertoire import repertoire


def _swinging(fps: float, seconds: float = 25.0) -> Seams:
    """Of arms that swing at rates of their own, now with the trunk bent and now not."""
    t = np.arange(round(seconds * fps)) / fps
    rates = {"LeftArm": 0.5, "RightArm": 0.73, "LeftForeArm": 0.41, "RightForeArm": 0.9, "Spine": 0.07}
    angles = {name: about(0, 0.5 * np.sin(2.0 * np.pi * rate * t)) for name, rate in rates.items()}
    rep, weights = repertoire(moving(angles, fps=fps)), check_weights(None)
    return Seams(rep, find_limits(rep, None, weights), weights, 0.1)


def _agreeing(seams: Seams) -> Pairs:
    """All that is near and agrees, at full rate."""
    return best_of_steps(seams, refined(seams, search(seams, lambda share, said="": None).pairs))


@pytest.fixture(scope="module")
def seams() -> Seams:
    """At 30 frames a second."""
    return _swinging(30.0)


@pytest.fixture(scope="module")
def pool(seams: Seams) -> Pairs:
    """All that is near and agrees."""
    return _agreeing(seams)


@pytest.fixture(scope="module")
def quick() -> tuple[Seams, Pairs]:
    """At 120 frames a second, where pairs are moved from where they were found, some of them into other steps."""
    seams = _swinging(120.0)
    return seams, _agreeing(seams)


def _kept(seams: Seams, pairs: Pairs) -> int:
    """Frames of the largest part that holds together."""
    leads = ways(seams.repertoire, pairs)
    paths = draft(seams.repertoire, leads.source, leads.target)
    return int(paths.length[largest_part(paths)].sum())


def test_the_best_of_every_two_steps_is_kept_and_agrees(seams: Seams, pool: Pairs) -> None:
    """No two pairs lie in the same two steps, and nothing differs by more than it may."""
    keys = set(zip(seams.cell[pool.a].tolist(), seams.cell[pool.b].tolist(), pool.relation.tolist(), strict=True))
    assert len(keys) == pool.size > 100
    assert np.isfinite(pool.cost).all()
    assert np.allclose(seams.judged(pool).pairs.cost, pool.cost)
    assert np.allclose(seams.measured(pool).distance, pool.distance, atol=1e-6)


def _steps_of(seams: Seams, pairs: Pairs) -> list[tuple[int, int, int]]:
    """Relation and the two steps, the earlier first, of each pair."""
    cells = np.sort(seams.cell[np.stack([pairs.a, pairs.b])], axis=0).tolist()
    return list(zip(pairs.relation.tolist(), *cells, strict=True))


def test_lowest_are_those_that_no_neighbour_undercuts(
    seams: Seams, pool: Pairs, quick: tuple[Seams, Pairs], rng: np.random.Generator
) -> None:
    """By looking at all steps about each pair, one after the other; at any rate and in whatever order pairs come."""
    for at, found in ((seams, pool), quick):
        pairs = found.take(rng.permutation(found.size))
        where = _steps_of(at, pairs)
        cost = dict(zip(where, pairs.cost.tolist(), strict=True))
        assert len(cost) == pairs.size > 100
        low = lowest(at, pairs)
        for k, (relation, row, column) in enumerate(where):
            about_it = [cost.get((relation, row + d, column + e), np.inf) for d in (-1, 0, 1) for e in (-1, 0, 1)]
            assert low[k] == (min(about_it) == pairs.cost[k])


def test_transitions_weigh_one_pair_of_every_two_steps(
    quick: tuple[Seams, Pairs], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of all that refining moves into the same two steps the cheapest pair alone is chosen from."""
    seen: list[Pairs] = []

    def looking(seams: Seams, pairs: Pairs) -> np.ndarray:
        seen.append(pairs)
        return lowest(seams, pairs)

    monkeypatch.setattr(transitions_module, "lowest", looking)
    seams, _ = quick
    transitions(seams.repertoire)
    refound = refined(seams, search(seams, lambda share, said="": None).pairs)
    cheapest: dict[tuple[int, int, int], float] = {}
    for key, cost in zip(_steps_of(seams, refound), refound.cost.tolist(), strict=True):
        cheapest[key] = min(cost, cheapest.get(key, np.inf))
    assert refound.size > len(cheapest)
    given = dict(zip(_steps_of(seams, seen[0]), seen[0].cost.tolist(), strict=True))
    assert len(given) == seen[0].size
    assert given == cheapest


def test_what_joins_joins_all_that_can_be_joined(seams: Seams, pool: Pairs) -> None:
    """To nothing, to a few pairs and to many: then as much holds together as with all pairs, by far fewer."""
    everything = _kept(seams, pool)
    for count in (0, 3, 40):
        some, others = pool.take(np.arange(count)), pool.take(np.arange(count, pool.size))
        needed = others.take(joining(seams, some, others))
        assert _kept(seams, Pairs.joined([some, needed])) == everything
        assert needed.size < 0.3 * pool.size
    assert not joining(seams, pool, Pairs.none()).any()


def test_the_best_of_every_second_are_no_more_than_asked_for(seams: Seams, pool: Pairs) -> None:
    """On average, what joins strands besides; and they cost less than those left out."""
    few = best(seams, pool, 10.0)
    assert few.size < 10.0 * seams.frames / seams.fps
    assert few.cost.mean() < pool.cost.mean()


def test_shared_seams_keep_their_distance(seams: Seams, pool: Pairs) -> None:
    """However pairs are brought onto them, and every pair on them agrees."""
    shared = Shared(seams)
    shared.hold(pool.take(joining(seams, Pairs.none(), pool)))
    shared.add(pool.take(lowest(seams, pool)))
    used = np.unique(np.concatenate([shared.pairs.a, shared.pairs.b]))
    assert np.diff(used).min() >= seams.spacing
    assert np.isfinite(seams.judged(seams.measured(shared.pairs)).pairs.cost).all()
    assert _kept(seams, shared.pairs) > 0.95 * _kept(seams, pool)


def test_exercises_are_performed_from_nearly_all_of_their_material(shared_data: Path) -> None:
    """At 120 frames a second, where a seam moved by a hundredth of a second may no longer agree."""
    exercises = kx.read(shared_data / "cmu" / "14" / "14_06.amc")
    assert network(repertoire(exercises)).seconds > 0.97 * 2.0 * exercises.duration
