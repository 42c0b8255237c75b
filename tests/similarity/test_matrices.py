"""Z and Z* on every code path, the contrast β, tiles, and what is refused."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics as kx
from kinesics.body.pose import PoseSequence
from kinesics.errors import Cancelled, InputError
from kinesics.geometry import quaternion
from kinesics.similarity import BETA_RULE, _kernel, default_beta, distance, mirror_distance, similarity, tiles
from naive import similarity as naive

ROUNDING = 5e-7


def random_poses(rng, count):
    q = rng.normal(size=(count, 15, 4))
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def swinging(seconds, fps, *, start=0.0, amplitude=0.6):
    """A body whose limbs swing at 1 Hz and whose spine sways, sampled at ``fps``."""
    t = start + np.arange(round(seconds * fps)) / fps
    angles = np.zeros((len(t), 15, 3))
    angles[:, 7:11, 0] = amplitude * np.sin(2 * np.pi * t)[:, None]
    angles[:, 11:, 0] = -amplitude * np.sin(2 * np.pi * t)[:, None]
    angles[:, 1:7, 2] = 0.3 * amplitude * np.cos(2 * np.pi * t)[:, None]
    return quaternion.from_rotvec(angles)


def sequence(q, fps):
    return PoseSequence(quaternions=q, yaw=np.zeros(len(q)), ground=np.zeros((len(q), 2)), fps=fps)


class TestAgainstTheTwin:
    """The fast ways against the loops."""

    @pytest.mark.parametrize("frames", [1, 2, 15, 16, 17, 33])
    def test_small(self, rng, kernel, frames):
        """Z and Z* are exp(−β D) and exp(−β D*) of the loops."""
        q = random_poses(rng, frames)
        weights = rng.uniform(0.1, 2.0, size=15)
        weights[11:] = weights[7:11]
        result = similarity(q, beta=2.5, weights=weights)
        np.testing.assert_allclose(result.z, np.exp(-2.5 * naive.distance(q, q, weights)), atol=2e-6)
        np.testing.assert_allclose(result.z_mirror, np.exp(-2.5 * naive.mirror_distance(q, q, weights)), atol=2e-6)

    @pytest.mark.parametrize("frames", [127, 128, 129, 143, 255, 256, 257, 300])
    def test_around_the_borders_of_tiles(self, rng, kernel, frames):
        """Sizes about the tile of 128 frames: every element is right, and every one is written."""
        q = random_poses(rng, frames)
        z = np.full((frames, frames), np.nan, dtype=np.float32)
        z_mirror = z.copy()
        result = similarity(q, beta=3.0, out=(z, z_mirror))
        assert result.z is z
        assert result.z_mirror is z_mirror
        # the paired NumPy way was checked against the loops above; 300² poses by loops would take minutes
        np.testing.assert_allclose(z, np.exp(-3.0 * _by_matrix_products(q, q)), atol=3e-6)
        np.testing.assert_allclose(z_mirror, np.exp(-3.0 * _by_matrix_products(q, naive_mirror(q))), atol=3e-6)

    @pytest.mark.skipif(
        len(_kernel.available()) < 2, reason="built without compiled kernels: one code path is all there is"
    )
    @given(seed=st.integers(0, 2**32 - 1), frames=st.integers(1, 300), beta=st.floats(0.01, 5000.0))
    def test_all_code_paths_agree(self, seed, frames, beta):
        """Whatever the number of frames, the weights and β, every code path gives the same Z and Z*."""
        rng = np.random.default_rng(seed)
        q = random_poses(rng, frames)
        # tilts within 60° of upright: see the next test for opposite ones
        q[:, 0] = quaternion.from_rotvec(rng.uniform(-1.0, 1.0, size=(frames, 3)) * np.radians([42.0, 0.0, 42.0]))
        weights = rng.uniform(0.0, 1.0, size=15)
        weights[11:] = weights[7:11]
        with pytest.MonkeyPatch.context() as patch:
            results = []
            for path in _kernel.available():
                patch.setenv("KINESICS_KERNEL", path)
                results.append(similarity(q, beta=beta, weights=weights))
        for other in results[:-1]:
            # D differs by rounding; where β is great, so much the more does the exponential
            for name in ("z", "z_mirror"):
                difference = np.abs(getattr(other, name) - getattr(results[-1], name))
                assert difference.max() <= 5e-7 * (1.0 + beta)


def test_precision_of_opposite_tilts(rng, kernel):
    """Upside down against upright, √((1 + g·h)/2) is the root of a rounding error: D keeps 4 digits there, not 6."""
    q = random_poses(rng, 40)
    half_turn = quaternion.from_rotvec([np.pi, 0.0, 0.0])
    q[20:] = q[:20]
    tremor = quaternion.from_rotvec(rng.normal(size=(20, 3)) * 10.0 ** rng.uniform(-9.0, -2.0, size=(20, 1)))
    # half a turn about an axis that is horizontal in the world
    q[20:, 0] = quaternion.multiply(half_turn, quaternion.multiply(q[:20, 0], tremor))
    np.testing.assert_allclose(distance(q, q), naive.distance(q, q), atol=3e-5)


def naive_mirror(q):
    return np.array([naive.mirror(p) for p in q])


def _by_matrix_products(a, b):
    down_a = np.array([naive.gravity(p[0]) for p in a])
    down_b = np.array([naive.gravity(p[0]) for p in b])
    total = np.sqrt(np.maximum(0.0, (1.0 + down_a @ down_b.T) / 2.0))
    for link in range(1, 15):
        total += np.abs(a[:, link] @ b[:, link].T)
    return np.maximum(0.0, 1.0 - total / 15.0)


def test_exactly_symmetric_with_ones_on_the_diagonal(rng, kernel):
    """Z and Z* equal their transposes to the last bit; a moment is exactly like itself."""
    result = similarity(random_poses(rng, 211))
    np.testing.assert_array_equal(result.z, result.z.T)
    np.testing.assert_array_equal(result.z_mirror, result.z_mirror.T)
    np.testing.assert_array_equal(np.diagonal(result.z), 1.0)
    assert result.z.min() >= np.exp(-result.beta) * (1.0 - 1e-5)
    assert result.z.max() <= 1.0
    assert result.z_mirror.max() <= 1.0


@pytest.mark.parametrize("shift", [0, 4, 12, 36, 60])
def test_result_does_not_depend_on_where_the_arrays_lie(rng, kernel, shift):
    """Wherever in a cache line ``out`` begins, the same bits are written and none beside them."""
    frames = 150
    q = random_poses(rng, frames)
    fresh = similarity(q, beta=4.0)
    arrays = []
    for _ in range(2):
        room = np.full(4 * frames * frames + 256, 0xAB, dtype=np.uint8)
        begin = (-room.ctypes.data) % 64 + shift
        arrays.append((room, begin, room[begin : begin + 4 * frames * frames].view(np.float32).reshape(frames, frames)))
    similarity(q, beta=4.0, out=(arrays[0][2], arrays[1][2]))
    for (room, begin, array), expected in zip(arrays, (fresh.z, fresh.z_mirror), strict=True):
        np.testing.assert_array_equal(array, expected)
        assert (room[:begin] == 0xAB).all()
        assert (room[begin + array.nbytes :] == 0xAB).all()


def test_large_outputs_past_the_caches(rng, kernel):
    """Above 8 MB the results are written around the caches: the same values."""
    q = random_poses(rng, 1601)
    result = similarity(q, beta=1.0)
    for rows in (slice(0, 40), slice(800, 840), slice(1561, 1601)):
        np.testing.assert_allclose(result.z[rows], np.exp(-distance(q[rows], q)), atol=2e-6)
        np.testing.assert_allclose(result.z_mirror[rows], np.exp(-mirror_distance(q[rows], q)), atol=2e-6)
    np.testing.assert_array_equal(result.z, result.z.T)


def test_keeps_what_it_was_made_with(rng):
    """β, its rule, the weights and the frame rate travel with the result."""
    q = random_poses(rng, 9)
    given_beta = similarity(q, beta=7.0, weights={"head": 2.0})
    assert (given_beta.beta, given_beta.beta_rule, given_beta.fps) == (7.0, "given by the caller", None)
    assert given_beta.weights[6] == 2.0
    assert given_beta.frame_count == len(given_beta) == 9
    chosen = similarity(sequence(q, 60.0))
    assert (chosen.beta, chosen.beta_rule, chosen.fps) == (default_beta(q), BETA_RULE, 60.0)


def test_the_room_can_be_called(rng):
    """`kx.similarity` is the function and the room, in whatever order they were first used."""
    q = random_poses(rng, 4)
    kx.distance(q, q)
    np.testing.assert_array_equal(kx.similarity(q, beta=1.0).z, similarity(q, beta=1.0).z)
    program = (
        "import numpy as np, kinesics as kx; q = np.tile([1.0, 0, 0, 0], (3, 15, 1));"
        "kx.similarity(q); import kinesics.similarity; kx.similarity(q); kx.similarity.tiles(q); kx.distance(q, q)"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


class TestBeta:
    """The default contrast."""

    def test_frame_rate_does_not_matter(self):
        """The same clip at 30 and 120 fps gets the same β to 2 %, and the same again."""
        slow, fast = default_beta(swinging(6.0, 30.0)), default_beta(swinging(6.0, 120.0))
        assert slow == pytest.approx(fast, rel=0.02)
        assert default_beta(swinging(6.0, 30.0)) == slow

    def test_trimming_hardly_matters(self):
        """The same clip without its first and last second gets nearly the same β."""
        assert default_beta(swinging(5.0, 60.0, start=1.0)) == pytest.approx(
            default_beta(swinging(7.0, 60.0)), rel=0.05
        )

    def test_follows_the_rule(self):
        """A quarter of all pairs is darker than e^−3 ≈ .05."""
        result = similarity(sequence(swinging(5.0, 60.0), 60.0))
        pairs = result.z[np.triu_indices(len(result), 1)]
        assert np.mean(pairs < 0.05) == pytest.approx(0.25, abs=0.02)

    def test_weights_count(self):
        """With the limbs left out, only the sway of the spine is seen and contrast is higher."""
        q = swinging(5.0, 60.0)
        limbs_out = {"femur": 0.0, "tibia": 0.0, "humerus": 0.0, "radius": 0.0}
        assert default_beta(q, limbs_out) > default_beta(q)

    def test_stillness_is_not_stretched(self, rng):
        """A body that sways by half a degree looks like one moment: Z stays above one half everywhere."""
        still = quaternion.from_rotvec(rng.normal(size=(400, 15, 3)) * np.radians(0.5))
        assert similarity(still).z.min() > 0.5
        frozen = np.tile(quaternion.identity(), (50, 15, 1))
        assert np.isfinite(default_beta(frozen))
        assert similarity(frozen).z.min() > 0.999

    def test_one_frame(self, rng):
        """One frame has a finite β too."""
        assert np.isfinite(default_beta(random_poses(rng, 1)))


class TestTiles:
    """D and D* without N×N."""

    @pytest.mark.parametrize(("frames", "size"), [(1, 16), (100, 16), (300, 100), (257, 128), (300, 4096)])
    def test_tile_the_whole(self, rng, kernel, frames, size):
        """The tiles cover D and D* exactly once, with the values of `distance`."""
        q = random_poses(rng, frames)
        d = np.full((frames, frames), np.nan, dtype=np.float32)
        d_mirror = d.copy()
        for tile in tiles(q, size=size):
            assert np.isnan(d[tile.rows, tile.columns]).all()
            d[tile.rows, tile.columns] = tile.d
            d_mirror[tile.rows, tile.columns] = tile.d_mirror
        np.testing.assert_allclose(d, distance(q, q), atol=ROUNDING)
        np.testing.assert_allclose(d_mirror, mirror_distance(q, q), atol=ROUNDING)
        np.testing.assert_array_equal(np.diagonal(d), 0.0)

    def test_symmetric_to_the_last_bit(self, rng):
        """Tiles below the diagonal are the transposes of those above."""
        whole = {(t.rows.start, t.columns.start): t for t in tiles(random_poses(rng, 200), size=64)}
        for (row, column), tile in whole.items():
            np.testing.assert_array_equal(tile.d, whole[column, row].d.T)
            np.testing.assert_array_equal(tile.d_mirror, whole[column, row].d_mirror.T)

    def test_half(self, rng):
        """``half`` leaves out the tiles below the diagonal and nothing else."""
        q = random_poses(rng, 200)
        whole = [(t.rows.start, t.columns.start) for t in tiles(q, size=64)]
        upper = [(t.rows.start, t.columns.start) for t in tiles(q, size=64, half=True)]
        assert upper == [(row, column) for row, column in whole if column >= row]

    def test_two_recordings(self, rng, kernel):
        """Rows of one and columns of another."""
        a, b = random_poses(rng, 70), random_poses(rng, 40)
        found = np.zeros((70, 40), dtype=np.float32)
        for tile in tiles(a, b, size=32):
            found[tile.rows, tile.columns] = tile.d_mirror
        np.testing.assert_allclose(found, mirror_distance(a, b), atol=ROUNDING)

    def test_refusals_come_at_once(self, rng):
        """Bad arguments are refused before the first tile is asked for."""
        q = random_poses(rng, 5)
        with pytest.raises(InputError, match="at least 16, got 8"):
            tiles(q, size=8)
        with pytest.raises(InputError, match="`half`"):
            tiles(q, q, half=True)
        with pytest.raises(InputError, match="`other`"):
            tiles(q, q[:, :3])

    def test_progress_may_stop(self, rng):
        """The fraction never falls, ends at 1, and raising stops the work."""
        q = random_poses(rng, 100)
        seen = []
        for _ in tiles(q, size=32, progress=lambda fraction, message="": seen.append(fraction)):
            pass
        assert seen == sorted(seen)
        assert seen[-1] == 1.0

        def stop(fraction, message=""):
            if fraction > 0.4:
                raise Cancelled

        with pytest.raises(Cancelled):
            list(tiles(q, size=32, progress=stop))


class TestOut:
    """What may be written into."""

    @pytest.mark.parametrize(
        ("out", "message"),
        [
            (np.zeros((6, 6), np.float32), "pair"),
            ((np.zeros((6, 6), np.float32),), "pair"),
            ((np.zeros((6, 6)), np.zeros((6, 6))), "float32"),
            ((np.zeros((6, 5), np.float32), np.zeros((6, 6), np.float32)), r"z to be .* \(6, 6\)"),
            ((np.zeros((6, 6), np.float32), np.zeros((7, 6), np.float32)), r"z_mirror to be .* \(6, 6\)"),
            ((np.zeros((6, 6), np.float32), None), "NoneType"),
            ((np.zeros((6, 6), np.float32, order="F"), np.zeros((6, 6), np.float32)), "C-contiguous"),
            ((np.zeros((6, 12), np.float32)[:, ::2], np.zeros((6, 6), np.float32)), "C-contiguous"),
        ],
    )
    def test_refused(self, rng, out, message):
        """Wrong kind, number, type, shape or layout."""
        with pytest.raises(InputError, match=message):
            similarity(random_poses(rng, 6), out=out)

    def test_read_only_and_overlapping_are_refused(self, rng):
        """Neither is written to."""
        q = random_poses(rng, 6)
        locked, free = np.zeros((6, 6), np.float32), np.zeros((6, 6), np.float32)
        locked.setflags(write=False)
        with pytest.raises(InputError, match="writeable"):
            similarity(q, out=(locked, free))
        with pytest.raises(InputError, match="overlap"):
            similarity(q, out=(free, free))
        assert not free.any()


def test_beta_must_be_positive(rng):
    """β of 0, below, NaN or infinite is refused."""
    for beta in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="`beta` above 0"):
            similarity(random_poses(rng, 3), beta=beta)


def test_what_cannot_fit_is_refused_before_the_work():
    """A million frames would need 8 TB: refused with the way out, not killed by the system."""
    from kinesics.similarity import matrices

    with pytest.raises(InputError, match=r"need 8000 GB .*tiles"):
        matrices._check_memory(1_000_000)


def test_progress_of_similarity(rng, kernel):
    """The fraction rises from 0 to 1; raising stops."""
    seen = []
    similarity(random_poses(rng, 300), progress=lambda fraction, message="": seen.append(fraction))
    assert seen[0] == 0.0
    assert seen[-1] == 1.0
    assert seen == sorted(seen)

    def stop(fraction, message=""):
        raise Cancelled

    with pytest.raises(Cancelled):
        similarity(random_poses(rng, 300), progress=stop)


def test_work_in_small_pieces_gives_the_same(rng, monkeypatch):
    """However the tiles are cut into pieces between looks at Ctrl-C, every element is written, and with the same bits."""
    q = random_poses(rng, 1000)
    whole = similarity(q, beta=2.0)
    monkeypatch.setattr(_kernel, "_FIRST_TILES", 5)
    monkeypatch.setattr(_kernel, "_CHUNK_SECONDS", 1e-9)
    arrays = np.full((2, 1000, 1000), np.nan, dtype=np.float32)
    seen = []
    similarity(q, beta=2.0, out=tuple(arrays), progress=lambda fraction, message="": seen.append(fraction))
    np.testing.assert_array_equal(arrays[0], whole.z)
    np.testing.assert_array_equal(arrays[1], whole.z_mirror)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


class TestChoiceOfCodePath:
    """How a code path is forced."""

    def test_unknown_is_refused(self, rng, monkeypatch):
        """The message lists what there is."""
        monkeypatch.setenv("KINESICS_KERNEL", "abacus")
        with pytest.raises(InputError, match=r"KINESICS_KERNEL=abacus: this machine has .*numpy"):
            similarity(random_poses(rng, 3))

    def test_no_native(self, monkeypatch):
        """KINESICS_NO_NATIVE=1 asks for NumPy; 0 and nothing do not."""
        monkeypatch.delenv("KINESICS_KERNEL", raising=False)
        monkeypatch.setenv("KINESICS_NO_NATIVE", "1")
        assert _kernel.chosen() == "numpy"
        monkeypatch.setenv("KINESICS_NO_NATIVE", "0")
        assert _kernel.chosen() == _kernel.available()[0]

    def test_works_where_the_extension_was_not_built(self):
        """With `kinesics._native` not importable everything still runs, on NumPy."""
        program = (
            "import sys; sys.modules['kinesics._native'] = None\n"
            "import numpy as np, kinesics as kx\n"
            "from kinesics.similarity import _kernel\n"
            "assert _kernel.available() == ['numpy'], _kernel.available()\n"
            "q = np.tile([1.0, 0, 0, 0], (3, 15, 1))\n"
            "assert kx.similarity(q, beta=1.0).z.min() > 0.999999 and kx.distance(q, q).max() < 1e-6\n"
        )
        subprocess.run([sys.executable, "-c", program], check=True)


def _child(q, queue):
    queue.put(float(similarity(q, beta=1.0).z.sum()))


@pytest.mark.skipif(sys.platform != "linux", reason="fork is the way of Linux")
def test_works_after_a_fork(rng):
    """A child forked after the kernels ran here does not wait for threads that it does not have."""
    q = random_poses(rng, 400)
    expected = float(similarity(q, beta=1.0).z.sum())
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12 warns of any fork beside threads
        child = context.Process(target=_child, args=(q, queue))
        child.start()
    try:
        assert queue.get(timeout=60.0) == expected
        child.join(timeout=60.0)
    finally:
        child.kill()
