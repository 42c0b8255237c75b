"""The compiled paths through distances and their NumPy twins give the same."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinesics import compiled
from kinesics.grammar import evidence, ground, motifs, reading
from kinesics.grammar.moments import from_distances


def _smooth(rng: np.random.Generator, rows: int, columns: int) -> np.ndarray:
    """Distances as movement has them: valleys and hills, a few exact zeros."""
    a, b = (np.cumsum(rng.normal(size=(n, 3)), axis=0) * 0.1 for n in (rows, columns))
    d = np.square(a[:, None] - b[None]).sum(axis=-1)
    return np.ascontiguousarray(np.minimum(d, 1.0), dtype=np.float32)


def _both(job):
    """What a job gives compiled and with NumPy."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("KINESICS_NO_NATIVE", "0")
        patch.delenv("KINESICS_KERNEL", raising=False)
        if not compiled.wanted():
            pytest.skip("built without compiled kernels")
        quick = job()
        patch.setenv("KINESICS_NO_NATIVE", "1")
        return quick, job()


sizes = st.tuples(st.integers(0, 2**31), st.integers(1, 12), st.integers(1, 5000))


class TestTwins:
    """Each code path forced in turn."""

    @given(sizes, st.booleans())
    def test_seeds(self, size, backwards):
        """Costs of a stretch at each column are equal bit by bit, over the borders of blocks and beside the ends."""
        seed, half, columns = size
        tile = _smooth(np.random.default_rng(seed), 2 * half + 1, columns)
        a, b = _both(lambda: motifs.seed_costs(tile, np.float32(0.003), backwards=backwards))
        np.testing.assert_array_equal(a, b)

    @given(sizes, st.booleans())
    def test_subsequences(self, size, backwards):
        """Costs and beginnings of a stretch looked up elsewhere are equal."""
        seed, rows, columns = size
        tile = _smooth(np.random.default_rng(seed), rows, min(columns, 300))
        a, b = _both(lambda: motifs.subsequence(tile, 0.003, backwards=backwards))
        np.testing.assert_array_equal(a[0], b[0])
        reached = np.isfinite(a[0])
        np.testing.assert_array_equal(a[1][reached], b[1][reached])

    @given(st.integers(0, 2**31), st.integers(1, 40))
    def test_folded(self, seed, count):
        """The fold about the middle costs the same and ends at the same place."""
        rng = np.random.default_rng(seed)
        d = _smooth(rng, count, count)
        weight = rng.uniform(0.0, 1.0, count)
        a, b = _both(lambda: evidence.folded(d, weight))
        assert a[0] == pytest.approx(b[0], rel=1e-12)
        assert a[1] == b[1]

    @given(st.integers(0, 2**31), st.integers(1, 8), st.integers(1, 24))
    def test_warped(self, seed, count, side):
        """Warped distances of square blocks are equal."""
        rng = np.random.default_rng(seed)
        blocks = np.stack([_smooth(rng, side, side) for _ in range(count)])
        a, b = _both(lambda: reading.warped(blocks))
        np.testing.assert_allclose(a, b, rtol=1e-12)

    @given(st.integers(0, 2**31), st.integers(2, 700), st.floats(0.001, 0.1))
    def test_known_ground(self, seed, count, same):
        """Every moment is on the same ground, at the same place, on the same side of the mirror."""
        rng = np.random.default_rng(seed)
        # back and forth along one way, so that much of it is known ground, with leaps and mirrored parts
        way = np.cumsum(rng.normal(size=(60, 3)), axis=0) * 0.08
        at = np.abs((np.cumsum(rng.choice([-1, 1, 1, 1, 7], size=count)) % 118) - 59)
        place = way[at] * np.where(rng.random(count) < 0.2, -1.0, 1.0)[:, None] + rng.normal(size=(count, 3)) * 1e-3
        d, s = (np.square(place[:, None] - side * place[None]).sum(axis=-1) for side in (1.0, -1.0))
        read = from_distances(d, s, 30.0)
        a, b = _both(lambda: ground.localise(read, same, lambda fraction, message="": None))
        np.testing.assert_array_equal(a.new, b.new)
        np.testing.assert_array_equal(a.where, b.where)
        np.testing.assert_array_equal(a.mirrored, b.mirrored)
