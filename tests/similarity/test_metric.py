"""D, D* and √(2D): what they are, and the laws they obey."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics as kx
from kinesics.body import pose
from kinesics.body.pose import PoseSequence, symmetry_parts
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from kinesics.similarity import (
    check_weights,
    chord,
    distance,
    mirror_distance,
    paired_distance,
    speed,
    symmetry_residual,
)
from kinesics.similarity.metric import Frames
from kinesics.vocabulary import LINKS, MIRROR_LINKS
from naive import similarity as naive

ROUNDING = 5e-7


def random_poses(rng, count):
    q = rng.normal(size=(count, 15, 4))
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def near(rng, poses, radians):
    """Each joint turned a little about an axis of its own."""
    return quaternion.multiply(poses, quaternion.from_rotvec(rng.normal(size=(*poses.shape[:-1], 3)) * radians))


def even_weights(rng):
    weights = rng.uniform(0.0, 2.0, size=15)
    weights[11:] = weights[7:11]
    return weights


def test_matches_the_twin(rng, kernel):
    """On every code path D and D* are those of the loops, for odd shapes and random weights."""
    for rows, columns in ((1, 1), (3, 17), (40, 29)):
        a, b, weights = random_poses(rng, rows), random_poses(rng, columns), even_weights(rng)
        np.testing.assert_allclose(distance(a, b, weights), naive.distance(a, b, weights), atol=ROUNDING)
        np.testing.assert_allclose(mirror_distance(a, b, weights), naive.mirror_distance(a, b, weights), atol=ROUNDING)
        np.testing.assert_allclose(distance(a, b), naive.distance(a, b), atol=ROUNDING)


def test_a_link_of_weight_zero_does_not_count(rng, kernel):
    """With weight on the root alone, only its tilt matters; without the root, it does not matter at all."""
    a = random_poses(rng, 20)
    b = a.copy()
    b[:, 1:] = random_poses(rng, 20)[:, 1:]
    only_root = np.eye(15)[0]
    np.testing.assert_allclose(np.diagonal(distance(a, b, only_root)), 0.0, atol=ROUNDING)
    c = a.copy()
    c[:, 0] = random_poses(rng, 20)[:, 0]
    np.testing.assert_allclose(np.diagonal(distance(a, c, 1.0 - only_root)), 0.0, atol=ROUNDING)


@given(seed=st.integers(0, 2**32 - 1))
def test_signs_mean_nothing(seed):
    """D and D* do not change when any quaternion changes sign."""
    rng = np.random.default_rng(seed)
    a, b = random_poses(rng, 6), random_poses(rng, 5)
    flipped = a * rng.choice([-1.0, 1.0], size=(6, 15, 1))
    np.testing.assert_array_equal(distance(flipped, b), distance(a, b))
    np.testing.assert_array_equal(mirror_distance(flipped, b), mirror_distance(a, b))
    np.testing.assert_allclose(speed(flipped, fps=30.0), speed(a, fps=30.0), atol=1e-12)


def test_is_a_distance_between_0_and_1(rng, kernel):
    """D is symmetric, 0 between a pose and itself up to rounding, never negative, never above 1; D* is symmetric too."""
    a, b = random_poses(rng, 130), random_poses(rng, 70)
    for function in (distance, mirror_distance):
        d = function(a, b)
        assert d.dtype == np.float32
        assert d.shape == (130, 70)
        assert d.min() >= 0.0
        assert d.max() <= 1.0
    np.testing.assert_allclose(mirror_distance(a, b), mirror_distance(b, a).T, atol=ROUNDING)
    own = np.diagonal(distance(a, a))
    assert own.min() >= 0.0
    assert own.max() < ROUNDING


def test_identical_poses_are_clamped_at_zero(rng, kernel):
    """1 − |q·g| of identical unit quaternions is negative now and then in float32; D is not."""
    q = random_poses(rng, 500).astype(np.float32)
    raw = np.float32(1.0) - np.abs(np.einsum("fji,fji->fj", q, q))
    assert (raw < 0.0).any()
    for link in range(15):
        own = np.diagonal(distance(q, q, np.eye(15)[link] + np.eye(15)[MIRROR_LINKS[link]]))
        assert own.min() >= 0.0
        assert own.max() < 2e-6


def test_opposite_tilts_are_at_distance_1(kernel):
    """Upright against upside down, by any axis, is 1 for the root alone: no NaN under the root at g·h = −1."""
    half_turns = quaternion.from_rotvec(np.pi * np.array([[1.0, 0, 0], [0, 0, 1.0], [0.6, 0, 0.8]]))
    upright = np.tile(quaternion.identity(), (1, 15, 1))
    flipped = np.tile(quaternion.identity(), (3, 15, 1))
    flipped[:, 0] = half_turns
    # the root of a rounding error of 1e-8 is 1e-4
    np.testing.assert_allclose(distance(upright, flipped, np.eye(15)[0]), 1.0, atol=3e-4)


def test_mirroring_both_leaves_d_and_mirroring_one_swaps(rng):
    """D(Wa, Wb) = D(a, b), D(a, Wb) = D*(a, b), D*(a, Wb) = D(a, b)."""
    a, b, weights = random_poses(rng, 40), random_poses(rng, 30), even_weights(rng)
    d, d_mirror = distance(a, b, weights), mirror_distance(a, b, weights)
    np.testing.assert_allclose(distance(pose.mirror(a), pose.mirror(b), weights), d, atol=ROUNDING)
    np.testing.assert_allclose(distance(a, pose.mirror(b), weights), d_mirror, atol=ROUNDING)
    np.testing.assert_allclose(distance(pose.mirror(a), b, weights), d_mirror, atol=ROUNDING)
    np.testing.assert_allclose(mirror_distance(a, pose.mirror(b), weights), d, atol=ROUNDING)


def test_heading_does_not_matter(rng):
    """Turning the body about gravity leaves D and D* as they are."""
    a, b = random_poses(rng, 20), random_poses(rng, 20)
    turned = a.copy()
    turned[:, 0] = quaternion.multiply(quaternion.from_rotvec([0.0, 1.2345, 0.0]), a[:, 0])
    np.testing.assert_allclose(distance(turned, b), distance(a, b), atol=ROUNDING)
    np.testing.assert_allclose(mirror_distance(turned, b), mirror_distance(a, b), atol=ROUNDING)


def test_root_term_is_the_best_over_all_headings(rng):
    """D of the root is 1 − max over ψ of |q_a · Y(ψ) q_b|, found by trying 20,000 headings."""
    a, b = random_poses(rng, 30), random_poses(rng, 30)
    headings = quaternion.from_rotvec(np.linspace(0.0, 2.0 * np.pi, 20_000)[:, None] * np.array([0.0, 1.0, 0.0]))
    tried = np.array([np.abs(quaternion.multiply(headings, b[k, 0]) @ a[k, 0]).max() for k in range(30)])
    only_root = np.eye(15)[0]
    np.testing.assert_allclose(np.diagonal(distance(a, b, only_root)), 1.0 - tried, atol=1e-6)


def triples(rng, count, kind):
    """(a, b, c): at random, or nearly in line with b between a and c, all distances small."""
    a = random_poses(rng, count)
    if kind == "random":
        return a, random_poses(rng, count), random_poses(rng, count)
    axis = rng.normal(size=(count, 15, 3))
    reach = 10.0 ** rng.uniform(-3.0, 0.3, size=(count, 1, 1))
    share = rng.uniform(size=(count, 1, 1))
    end = quaternion.from_rotvec(axis * reach)
    middle = quaternion.from_rotvec(axis * reach * share + rng.normal(size=axis.shape) * 1e-6)
    return a, quaternion.multiply(a, middle), quaternion.multiply(a, end)


@pytest.mark.parametrize("kind", ["random", "nearly in line"])
def test_triangle_inequalities(rng, kind):
    """√(2D) obeys the triangle inequality, and with one star moved the mixed ones hold, on 100,000 triples."""
    for _ in range(10):
        a, b, c = triples(rng, 10_000, kind)
        weights = even_weights(rng)

        def root(p, q, weights=weights):
            return chord(paired_distance(p, q, weights))

        def root_mirror(p, q, weights=weights):
            return chord(paired_distance(p, pose.mirror(q), weights))

        assert np.all(root(a, c) <= root(a, b) + root(b, c) + 1e-9)
        assert np.all(root_mirror(a, c) <= root(a, b) + root_mirror(b, c) + 1e-9)
        # mirror b: then both of the longer way round are stars
        image = pose.mirror(b)
        assert np.all(root(a, c) <= root_mirror(a, image) + root_mirror(image, c) + 1e-9)
        assert np.all(root(a, c) <= root_mirror(a, b) + root_mirror(b, c) + 1e-9)


def test_frames_compared_a_few_at_a_time_are_as_far_apart(rng):
    """`Frames` says what `paired_distance` does."""
    q, weights = random_poses(rng, 30), even_weights(rng)
    frames = Frames(q, weights)
    for frame, start, end in ((0, 0, 30), (29, 3, 4), (7, 7, 20), (5, 8, 8)):
        some = q[start:end]
        found = frames.distance_from(frame, start, end)
        assert found.shape == (end - start,)
        if len(some):
            np.testing.assert_allclose(found, paired_distance(some, np.broadcast_to(q[frame], some.shape), weights))
    with pytest.raises(InputError, match="unit quaternions"):
        Frames(2.0 * q)


def test_d_itself_fails_the_triangle_inequality():
    """Three poses evenly spaced along one rotation: D fails for every step up to 103.6° and holds beyond (§2.13, axiom 4)."""
    only_head = np.eye(15)[LINKS.index("head")]
    for degrees in (0.5, 5.0, 30.0, 60.0, 90.0, 103.5, 103.7, 110.0, 120.0):
        q = np.tile(quaternion.identity(), (3, 15, 1))
        q[:, LINKS.index("head")] = quaternion.from_rotvec(
            np.outer(np.radians([0.0, degrees, 2.0 * degrees]), [1.0, 0, 0])
        )
        d_ab, d_bc, d_ac = (float(paired_distance(q[[i]], q[[j]], only_head)[0]) for i, j in ((0, 1), (1, 2), (0, 2)))
        assert (d_ac > d_ab + d_bc) == (degrees < 103.6)
        assert chord(d_ac) <= chord(d_ab) + chord(d_bc) + 1e-12


def test_two_stars_do_not_bound_a_third():
    """√(2D*)(a, c) can exceed √(2D*)(a, b) + √(2D*)(b, c): b = Wa is at star distance 0 from a and from no further image."""
    q = np.tile(quaternion.identity(), (1, 15, 1))
    q[:, LINKS.index("left_humerus")] = quaternion.from_rotvec([0.0, 0.0, 1.0])
    b = pose.mirror(q)
    assert paired_distance(q, pose.mirror(b))[0] == pytest.approx(0.0, abs=1e-12)
    assert paired_distance(q, pose.mirror(q))[0] > 0.01


def test_chord_is_that_of_quaternions(rng):
    """For one link √(2D) is min(|q − g|, |q + g|) = 2 sin(θ/4)."""
    link = LINKS.index("thorax")
    a, b = random_poses(rng, 50), random_poses(rng, 50)
    root = chord(paired_distance(a, b, np.eye(15)[link]))
    theta = quaternion.angle(a[:, link], b[:, link])
    np.testing.assert_allclose(root, 2.0 * np.sin(theta / 4.0), atol=1e-12)
    np.testing.assert_array_equal(chord([-1e-9, 0.5]), [0.0, 1.0])


def test_paired_distance_is_the_diagonal(rng):
    """Frame by frame in float64 and all pairs in float32 agree, and with the twin."""
    a, b, weights = random_poses(rng, 25), random_poses(rng, 25), even_weights(rng)
    paired = paired_distance(a, b, weights)
    np.testing.assert_allclose(paired, np.diagonal(distance(a, b, weights)), atol=ROUNDING)
    np.testing.assert_allclose(paired, np.diagonal(naive.distance(a, b, weights)), atol=1e-14)


def test_residual_is_the_antisymmetric_part(rng):
    """D*(a, a) = 2·mean|A|², exactly, with equal weights (§2.11)."""
    a = random_poses(rng, 2000)
    a[:, 0] = quaternion.yaw_tilt(a[:, 0]).tilt
    antisymmetric = symmetry_parts(a).antisymmetric
    expected = 2.0 * np.mean(np.sum(antisymmetric**2, axis=-1), axis=-1)
    np.testing.assert_allclose(symmetry_residual(a), expected, atol=1e-12)
    np.testing.assert_allclose(symmetry_residual(a), np.diagonal(mirror_distance(a, a)), atol=ROUNDING)


def test_residual_of_a_symmetric_pose_is_zero(rng):
    """Whatever the axial links do within the sagittal plane, equal limbs on both sides make a symmetric pose."""
    q = random_poses(rng, 10)
    q[:, :7, 2:] = 0.0
    q[:, :7] /= np.linalg.norm(q[:, :7], axis=-1, keepdims=True)
    q[:, 11:] = quaternion.mirror(q[:, 7:11])
    np.testing.assert_allclose(symmetry_residual(q), 0.0, atol=1e-12)


class TestSpeed:
    """√(2D)/Δt."""

    def test_matches_the_twin(self, rng):
        """The speed of a path is that of the loops; entry 0 repeats entry 1."""
        poses, weights = random_poses(rng, 12), even_weights(rng)
        np.testing.assert_allclose(
            speed(poses, fps=50.0, weights=weights), naive.speed(poses, 50.0, weights), rtol=1e-6
        )

    def test_is_half_the_angular_speed(self):
        """A body all of whose joints turn at ω about their own axes moves at ω/2, at any frame rate, however slowly."""
        for omega, fps in ((2.0, 120.0), (1e-5, 120.0), (1e-5, 1000.0)):
            t = np.arange(5) / fps
            q = np.tile(quaternion.from_rotvec(np.outer(t, [omega, 0.0, 0.0]))[:, None], (1, 15, 1))
            np.testing.assert_allclose(speed(q, fps=fps), omega / 2.0, rtol=1e-3)

    def test_one_frame_stands_still(self, rng):
        """One frame has speed 0."""
        np.testing.assert_array_equal(speed(random_poses(rng, 1), fps=30.0), [0.0])

    def test_takes_the_frame_rate_of_a_sequence(self, rng):
        """A PoseSequence knows its frame rate; an array must be given one."""
        q = random_poses(rng, 4)
        sequence = PoseSequence(quaternions=q, yaw=np.zeros(4), ground=np.zeros((4, 2)), fps=25.0)
        np.testing.assert_allclose(speed(sequence), speed(q, fps=25.0), rtol=1e-12)
        with pytest.raises(InputError, match="give `fps`"):
            speed(q)
        with pytest.raises(InputError, match="above 0"):
            speed(q, fps=0.0)


class TestRefusals:
    """Bad input is refused at the door, by name."""

    @pytest.mark.parametrize(
        ("poses", "message"),
        [
            (np.zeros((3, 14, 4)), r"`a` of shape \(frames, 15, 4\), got \(3, 14, 4\)"),
            (np.zeros((0, 15, 4)), "at least one frame"),
            (np.zeros((2, 15, 4)), "root in frame 0 has length 0"),
            (np.full((2, 15, 4), np.nan), "length nan"),
            (np.full((2, 15, 4), np.inf), "length inf"),
            ("walk.bvh", "PoseSequence"),
            (None, "of shape"),
        ],
    )
    def test_poses(self, poses, message):
        """Wrong shape, no frame, no unit quaternions, no array at all."""
        good = np.tile(quaternion.identity(), (2, 15, 1))
        with pytest.raises(InputError, match=message):
            distance(poses, good)

    def test_names_the_second_argument(self):
        """The message says which of the two is bad, and where."""
        good = np.tile(quaternion.identity(), (2, 15, 1))
        bad = good.copy()
        bad[1, 8] *= 1.1
        with pytest.raises(InputError, match=r"`b`; that of left_tibia in frame 1 has length 1\.1"):
            kx.mirror_distance(good, bad)
        with pytest.raises(InputError, match="as many frames, got 2 and 1"):
            paired_distance(good, good[:1])

    @pytest.mark.parametrize(
        ("weights", "message"),
        [
            (np.ones(14), r"shape \(15,\)"),
            (np.zeros(15), "at least one"),
            (-np.ones(15), "that of root is -1"),
            (np.full(15, np.nan), "that of root is nan"),
            (np.eye(15)[7], "differ for left_femur"),
            ({"left_femur": 2.0}, "differ for left_femur"),
            ({"pelvis": 2.0}, "Unknown link in `weights`: pelvis"),
            ({"femur": "heavy"}, "numbers; that of femur is 'heavy'"),
            ("heavy", "15 numbers or a mapping"),
        ],
    )
    def test_weights(self, weights, message):
        """Wrong count, all zero, negative, not finite, uneven, unknown names, no numbers."""
        good = np.tile(quaternion.identity(), (2, 15, 1))
        for call in (lambda: distance(good, good, weights), lambda: mirror_distance(good, good, weights)):
            with pytest.raises(InputError, match=message):
                call()

    def test_weights_by_name(self):
        """Links by name, both sides at once; what is not named weighs 1."""
        weights = check_weights({"root": 0.0, "humerus": 3.0, "left_tibia": 0.5, "right_tibia": 0.5})
        expected = np.ones(15)
        expected[0] = 0.0
        for link in ("left_humerus", "right_humerus"):
            expected[LINKS.index(link)] = 3.0
        for link in ("left_tibia", "right_tibia"):
            expected[LINKS.index(link)] = 0.5
        np.testing.assert_array_equal(weights, expected)
        assert all(weights[i] == weights[j] for i, j in enumerate(MIRROR_LINKS))


def test_float32_poses_are_welcome(rng):
    """float32 quaternions are unit to 1e-7 only; they are taken and made unit."""
    q = random_poses(rng, 8)
    np.testing.assert_allclose(distance(q.astype(np.float32), q), distance(q, q), atol=ROUNDING)
    assert math.isfinite(float(symmetry_residual(q.astype(np.float32)).max()))
