"""Unit quaternions: the group, the exponential, every way in and out; near 0, near π, for q and −q."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from kinesics import compiled
from kinesics.errors import InputError
from kinesics.geometry import quaternion
from naive import geometry as naive

SHAPES = [(), (1,), (3, 1, 2, 1)]

directions = arrays(np.float64, 3, elements=st.floats(-1.0, 1.0)).filter(lambda v: np.linalg.norm(v) > 1e-2)
angles = st.one_of(
    st.floats(0.0, np.pi, allow_subnormal=False),
    st.sampled_from([0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-4, np.pi - 1e-4, np.pi - 1e-8, np.pi - 1e-12, np.pi]),
)
vectors = arrays(np.float64, 3, elements=st.floats(-1e3, 1e3))


@st.composite
def rotations(draw: st.DrawFn) -> np.ndarray:
    """Unit quaternions of either sign, with the awkward angles among them."""
    axis = draw(directions)
    half = draw(angles) / 2.0
    q = np.array([np.cos(half), *(np.sin(half) * axis / np.linalg.norm(axis))])
    return -q if draw(st.booleans()) else q


def random(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    return quaternion.normalize(rng.normal(size=(*shape, 4)))


def assert_same_rotation(a: np.ndarray, b: np.ndarray, within: float = 1e-12) -> None:
    __tracebackhide__ = True
    assert float(np.max(quaternion.angle(a, b))) <= within


@pytest.mark.parametrize("shape", SHAPES)
def test_group_axioms_hold_for_every_batch_shape(rng: np.random.Generator, shape: tuple[int, ...]) -> None:
    """Associative, with identity and inverse, and unit quaternions stay unit."""
    a, b, c = (random(rng, shape) for _ in range(3))
    one = quaternion.identity(shape)
    assert one.shape == (*shape, 4)
    left = quaternion.multiply(quaternion.multiply(a, b), c)
    assert_allclose(left, quaternion.multiply(a, quaternion.multiply(b, c)), atol=1e-14)
    assert_allclose(quaternion.multiply(a, one), a)
    assert_allclose(quaternion.multiply(one, a), a)
    assert_allclose(quaternion.multiply(a, quaternion.conjugate(a)), one, atol=1e-15)
    assert_allclose(np.linalg.norm(left, axis=-1), 1.0)


def test_leading_axes_broadcast(rng: np.random.Generator) -> None:
    """(3, 1) against (2,) is (3, 2), entry by entry the product of the two."""
    a, b, v = random(rng, (3, 1)), random(rng, (2,)), rng.normal(size=(2, 3))
    product, turned = quaternion.multiply(a, b), quaternion.rotate(a, v)
    assert product.shape == (3, 2, 4)
    for i in range(3):
        for j in range(2):
            assert_allclose(product[i, j], naive.multiply(a[i, 0], b[j]), atol=1e-15)
            assert_allclose(turned[i, j], naive.rotate(a[i, 0], v[j]), atol=1e-14)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ((), ()),
        ((5,), ()),
        ((), (5,)),
        ((4, 3), (3,)),
        ((3, 1), (2,)),
        ((0, 3), (0, 3)),
        ((2, 1, 4, 3), (5, 1, 3)),
        ((2, 0, 3), (3,)),
    ],
)
def test_compiled_and_plain_agree(
    first: tuple[int, ...], second: tuple[int, ...], monkeypatch, rng: np.random.Generator
) -> None:
    """Products, turned vectors, logarithms and exponentials: the same from the compiled module and from NumPy, however axes lie."""
    if compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    a, b, v = random(rng, first), random(rng, second), 3.0 * rng.normal(size=(*second, 3))
    # picked joints lie in other orders in memory, and a turn of nothing has no axis
    twice, picked = np.concatenate([b, -b], axis=-1)[..., ::2], np.swapaxes(np.array(np.swapaxes(b, 0, -1)), 0, -1)
    v[..., 0] *= 1e-9
    b[..., 1:] *= 0.0 if second == (5,) else 1.0

    def results() -> list[np.ndarray]:
        return [
            quaternion.multiply(a, b),
            quaternion.multiply(twice, picked),
            quaternion.rotate(a, v),
            quaternion.as_rotvec(picked),
            quaternion.from_rotvec(v),
            quaternion.offset(a, picked),
            quaternion.angle(a, b),
        ]

    monkeypatch.delenv("KINESICS_KERNEL", raising=False)
    monkeypatch.setenv("KINESICS_NO_NATIVE", "0")
    quick = results()
    monkeypatch.setenv("KINESICS_NO_NATIVE", "1")
    for one, other in zip(quick, results(), strict=True):
        assert one.shape == other.shape
        assert_allclose(one, other, rtol=1e-12, atol=1e-13)


@given(rotations(), rotations())
def test_the_offset_is_what_turns_the_one_into_the_other(a: np.ndarray, b: np.ndarray) -> None:
    """a · exp(offset) is b, and no longer way round than half a turn."""
    found = quaternion.offset(a, b)
    assert np.linalg.norm(found) <= np.pi + 1e-12
    assert_same_rotation(quaternion.multiply(a, quaternion.from_rotvec(found)), b)


@given(rotations(), rotations(), vectors)
def test_acting_on_a_vector_is_associative(a: np.ndarray, b: np.ndarray, v: np.ndarray) -> None:
    """§2.2: Q2(Q1 r) = (Q2 Q1) r, and the action is that of the matrix."""
    scale = max(1.0, float(np.abs(v).max()))
    together = quaternion.rotate(quaternion.multiply(a, b), v)
    assert_allclose(together, quaternion.rotate(a, quaternion.rotate(b, v)), atol=1e-13 * scale)
    assert_allclose(quaternion.rotate(a, v), quaternion.as_matrix(a) @ v, atol=1e-13 * scale)


def test_rotation_formula_needs_its_brackets(rng: np.random.Generator) -> None:
    """§2.2 prints 2q×q×r, which read from the left is 0: only v + 2w q×v + 2q×(q×v) agrees with Q r Q*."""
    q, v = random(rng, ()), rng.normal(size=3)
    w, u = q[0], q[1:]
    right = naive.rotate(q, v)
    assert_allclose(v + 2 * w * np.cross(u, v) + 2 * np.cross(u, np.cross(u, v)), right)
    assert_allclose(quaternion.rotate(q, v), right)
    as_printed = v + 2 * w * np.cross(u, v) + 2 * np.cross(np.cross(u, u), v)
    assert np.linalg.norm(as_printed - right) > 0.1


@given(directions, angles)
def test_exponential_and_logarithm_are_inverse(axis: np.ndarray, angle: float) -> None:
    """Up to a half turn the logarithm gives back the rotation vector, to its own precision however small."""
    v = axis / np.linalg.norm(axis) * angle
    back = quaternion.as_rotvec(quaternion.from_rotvec(v))
    if angle > np.pi - 1e-7:
        # either of the two opposite vectors is right at π
        back = back if back @ v > 0 else -back
    assert_allclose(back, v, rtol=1e-12, atol=1e-14 * angle)


@given(rotations())
def test_logarithm_is_blind_to_sign_and_at_most_pi(q: np.ndarray) -> None:
    """q and −q have one logarithm, no longer than π, and its exponential is the rotation."""
    v = quaternion.as_rotvec(q)
    assert np.linalg.norm(v) <= np.pi + 1e-15
    if abs(q[0]) > 1e-15:
        assert_allclose(quaternion.as_rotvec(-q), v, atol=1e-15)
    assert_same_rotation(quaternion.from_rotvec(v), q)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, 3.0, np.pi - 1e-9, np.pi, 5.0, 40.0])
def test_exponential_is_the_matrix_exponential(angle: float) -> None:
    """Against the power series of exp(ω̂), beyond a whole turn too."""
    v = angle * np.array([2.0, -3.0, 6.0]) / 7.0
    assert_allclose(quaternion.as_matrix(quaternion.from_rotvec(v)), naive.exp_matrix(naive.hat(v)), atol=1e-13)


def test_rodrigues_as_the_dissertation_has_it() -> None:
    """§2.1: exp(ω̂θ) = I + ω̂ sin θ + ω̂²(1 − cos θ)."""
    axis, theta = np.array([1.0, 2.0, 2.0]) / 3.0, 0.7
    w = naive.hat(axis)
    expected = np.eye(3) + w * np.sin(theta) + w @ w * (1 - np.cos(theta))
    assert_allclose(quaternion.as_matrix(quaternion.from_axis_angle(axis, theta)), expected, atol=1e-15)


@given(rotations())
def test_matrix_and_back(q: np.ndarray) -> None:
    """Through the matrix nothing is lost, at any angle, and w ≥ 0 comes back."""
    back = quaternion.from_matrix(quaternion.as_matrix(q))
    assert back[0] >= 0.0
    assert_same_rotation(back, q, within=1e-14 * 100)


@pytest.mark.parametrize("shape", SHAPES)
def test_agrees_with_scipy(rng: np.random.Generator, shape: tuple[int, ...]) -> None:
    """Product, action, matrix, logarithm: as SciPy has them, once its scalar is moved."""
    a, b, v = random(rng, shape), random(rng, shape), rng.normal(size=(*shape, 3))
    flat_a, flat_b = a.reshape(-1, 4), b.reshape(-1, 4)
    ra = Rotation.from_quat(quaternion.as_scalar_last(flat_a))
    rb = Rotation.from_quat(quaternion.as_scalar_last(flat_b))
    product = quaternion.from_scalar_last((ra * rb).as_quat()).reshape(a.shape)
    assert_same_rotation(quaternion.multiply(a, b), product)
    assert_allclose(quaternion.rotate(a, v).reshape(-1, 3), ra.apply(v.reshape(-1, 3)), atol=1e-14)
    assert_allclose(quaternion.as_matrix(a).reshape(-1, 3, 3), ra.as_matrix(), atol=1e-14)
    assert_allclose(quaternion.as_rotvec(a).reshape(-1, 3), ra.as_rotvec(), atol=1e-13)
    assert_allclose(quaternion.angle(a).reshape(-1), ra.magnitude(), atol=1e-13)


def test_scalar_last_and_back() -> None:
    """(w, x, y, z) is (x, y, z, w) elsewhere."""
    assert_allclose(quaternion.as_scalar_last([1.0, 2.0, 3.0, 4.0]), [2.0, 3.0, 4.0, 1.0])
    assert_allclose(quaternion.from_scalar_last([2.0, 3.0, 4.0, 1.0]), [1.0, 2.0, 3.0, 4.0])


@given(directions, angles)
def test_euler_pole_and_angle(axis: np.ndarray, angle: float) -> None:
    """§2.1: a turn of θ about ω is found again, where the arccos of the trace would have lost it."""
    axis = axis / np.linalg.norm(axis)
    found = quaternion.as_axis_angle(quaternion.from_axis_angle(axis, angle))
    assert_allclose(found.angle, angle, rtol=1e-12, atol=0.0)
    pole = found.axis if found.axis @ axis > 0 or angle < np.pi - 1e-7 else -found.axis
    if angle > 0.0:
        assert_allclose(pole, axis, atol=1e-12)
    assert_allclose(np.linalg.norm(found.axis), 1.0)


def test_no_turn_has_a_stated_pole() -> None:
    """The identity has no pole: +x is given, for either sign."""
    found = quaternion.as_axis_angle([[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0]])
    assert_allclose(found.angle, 0.0)
    assert_allclose(found.axis, [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])


@given(directions, st.sampled_from([1e-12, 1e-9, 1e-5, 0.3, np.pi - 1e-9]), rotations())
def test_angle_keeps_its_digits_near_zero(axis: np.ndarray, size: float, q: np.ndarray) -> None:
    """The angle between q and q turned by a little is that little, for −q too."""
    turned = quaternion.multiply(q, quaternion.from_axis_angle(axis, size))
    assert_allclose(quaternion.angle(q, turned), size, rtol=1e-6, atol=1e-15)
    assert_allclose(quaternion.angle(-q, turned), size, rtol=1e-6, atol=1e-15)


@given(rotations(), rotations(), st.floats(0.0, 1.0))
def test_slerp_runs_at_constant_rate_along_the_shorter_arc(a: np.ndarray, b: np.ndarray, t: float) -> None:
    """The angle from a grows as t; the ends are a and b; the sign of b does not matter."""
    whole = float(quaternion.angle(a, b))
    middle = quaternion.slerp(a, b, t)
    assert_allclose(quaternion.angle(a, middle), t * whole, atol=1e-12)
    assert_same_rotation(quaternion.slerp(a, b, 0.0), a)
    assert_same_rotation(quaternion.slerp(a, b, 1.0), b)
    if whole < np.pi - 1e-6:
        assert_same_rotation(quaternion.slerp(a, -b, t), middle, within=1e-9)


def test_power_counts_repetitions(rng: np.random.Generator) -> None:
    """q³ is q·q·q, half of q twice is q, and −1 is the inverse, while no half turn is passed."""
    q = quaternion.from_rotvec(rng.uniform(-0.5, 0.5, size=(20, 3)))
    thrice = quaternion.multiply(q, quaternion.multiply(q, q))
    half = quaternion.power(q, 0.5)
    assert_same_rotation(quaternion.power(q, 3.0), thrice)
    assert_same_rotation(quaternion.multiply(half, half), q)
    assert_same_rotation(quaternion.power(q, -1.0), quaternion.conjugate(q))


@given(directions, directions)
def test_between_turns_one_direction_onto_the_other(a: np.ndarray, b: np.ndarray) -> None:
    """The smallest rotation: it moves a onto b about an axis at right angles to both."""
    q = quaternion.between(a, b)
    assert_allclose(quaternion.rotate(q, a) / np.linalg.norm(a), b / np.linalg.norm(b), atol=1e-13)
    assert abs(q[1:] @ a) < 1e-9
    assert abs(q[1:] @ b) < 1e-9


@pytest.mark.parametrize("axis", [*np.eye(3), np.array([1.0, -2.0, 3.0])])
@pytest.mark.parametrize("off", [0.0, 1e-15, 1e-9, 1e-5])
def test_between_opposite_directions(axis: np.ndarray, off: float) -> None:
    """Exactly and nearly opposite directions are a (nearly) half turn apart."""
    b = -axis + off * np.array([0.3, 0.5, -0.7])
    q = quaternion.between(axis, b)
    assert_allclose(quaternion.rotate(q, axis) / np.linalg.norm(axis), b / np.linalg.norm(b), atol=1e-13)


def test_mean_is_blind_to_signs(rng: np.random.Generator) -> None:
    """The mean of rotations spread evenly about one is that one, whatever their signs."""
    centre = random(rng, ())
    spread = quaternion.from_rotvec(0.3 * np.vstack([np.eye(3), -np.eye(3)]))
    signs = np.where(rng.random((6, 1)) < 0.5, -1.0, 1.0)
    samples = signs * quaternion.multiply(centre, spread)
    assert_same_rotation(quaternion.mean(samples), centre, within=1e-9)
    batched = quaternion.mean(np.repeat(samples[:, None], 3, axis=1))
    assert batched.shape == (3, 4)
    assert_same_rotation(batched, centre, within=1e-9)


def test_weighted_mean_leans_to_the_heavier(rng: np.random.Generator) -> None:
    """A sample of weight 0 does not count; whole weights are repetitions."""
    q = random(rng, (3,))
    assert_same_rotation(quaternion.mean(q, [0.0, 1.0, 0.0]), q[1], within=1e-9)
    repeated = quaternion.mean(np.stack([q[0], q[0], q[1]]))
    assert_same_rotation(quaternion.mean(q[:2], [2.0, 1.0]), repeated, within=1e-9)


def test_continuous_signs(rng: np.random.Generator) -> None:
    """Neighbours lie in the same half afterwards, every rotation is what it was, and the first keeps its sign."""
    angle = np.linspace(0.0, 20.0, 200)
    path = quaternion.from_axis_angle(np.array([1.0, 1.0, 0.0]), angle)
    scrambled = path * np.where(rng.random((200, 1)) < 0.5, -1.0, 1.0)
    smooth = quaternion.continuous(scrambled)
    assert np.all(np.sum(smooth[1:] * smooth[:-1], axis=-1) > 0.0)
    assert_same_rotation(smooth, path)
    assert_allclose(smooth[0], scrambled[0])


@given(rotations(), directions)
def test_swing_and_twist_multiply_to_the_whole(q: np.ndarray, axis: np.ndarray) -> None:
    """q = swing · twist, the twist about the axis, the swing at right angles to it."""
    axis = axis / np.linalg.norm(axis)
    swing, twist = quaternion.swing_twist(q, axis)
    assert_allclose(quaternion.multiply(swing, twist), q, atol=1e-12)
    assert_allclose(np.cross(twist[1:], axis), 0.0, atol=1e-12)
    if np.hypot(q[0], q[1:] @ axis) > 1e-6:
        assert abs(swing[1:] @ axis) < 1e-9


@given(rotations(), st.floats(-np.pi, np.pi))
def test_tilt_does_not_feel_yaw(q: np.ndarray, turn: float) -> None:
    """§2.8: turning the body about gravity changes the yaw alone, except upside down where yaw is not defined."""
    w, y = q[0], q[2]
    if np.hypot(w, y) < 1e-3:
        return
    before = quaternion.yaw_tilt(q)
    about_y = quaternion.from_axis_angle(np.array([0.0, 1.0, 0.0]), turn)
    after = quaternion.yaw_tilt(quaternion.multiply(about_y, q))
    assert_allclose(after.tilt, before.tilt, atol=1e-9)
    assert abs(np.exp(1j * (after.yaw - before.yaw - turn)) - 1.0) < 1e-9
    again = quaternion.multiply(quaternion.from_axis_angle(np.array([0.0, 1.0, 0.0]), before.yaw), before.tilt)
    assert_same_rotation(again, q, within=1e-9)


def test_upside_down_is_flagged() -> None:
    """A body on its head has no yaw: it is given as 0 and flagged."""
    split = quaternion.yaw_tilt(quaternion.from_axis_angle([1.0, 0.0, 0.5], np.pi))
    assert bool(split.singular)
    assert split.yaw == 0.0


@given(rotations())
def test_mirror_is_conjugation_by_the_reflection(q: np.ndarray) -> None:
    """§2.10: w(q) is F R F with F = diag(−1, 1, 1), and twice it is nothing."""
    flip = np.diag([-1.0, 1.0, 1.0])
    expected = flip @ quaternion.as_matrix(q) @ flip
    assert_allclose(quaternion.as_matrix(quaternion.mirror(q)), expected, atol=1e-14)
    assert_allclose(quaternion.mirror(quaternion.mirror(q)), q)


def test_normalize_at_the_ends_of_the_floats() -> None:
    """Squares that leave the range of floats do no harm."""
    for scale in (1e-300, 1e-170, 1.0, 1e170, 1e300):
        assert_allclose(quaternion.normalize(np.array([1.0, 2.0, 2.0, 4.0]) * scale), np.array([1, 2, 2, 4]) / 5)


@pytest.mark.parametrize("bad", [0.0, np.nan, np.inf])
def test_normalize_names_the_first_bad_quaternion(bad: float) -> None:
    """Zero and non-finite quaternions are refused with their index."""
    q = quaternion.identity((4, 3))
    q[2, 1] = [bad, 0.0, 0.0, 0.0]
    with pytest.raises(InputError, match=r"\(2, 1\)"):
        quaternion.normalize(q)


def test_what_is_no_rotation_is_refused() -> None:
    """A reflection, a sheared matrix, a wrong shape, NaN: one clear error each."""
    with pytest.raises(InputError, match="determinant -1"):
        quaternion.from_matrix(np.diag([1.0, 1.0, -1.0]))
    sheared = np.stack([np.eye(3), np.eye(3) + np.eye(3, k=1)])
    with pytest.raises(InputError, match="Matrix 1 is off by 1"):
        quaternion.from_matrix(sheared)
    with pytest.raises(InputError, match=r"\(\.\.\., 3, 3\), got \(3,\)"):
        quaternion.from_matrix([1.0, 2.0, 3.0])
    with pytest.raises(InputError, match="not finite"):
        quaternion.from_matrix(np.full((3, 3), np.nan))


def test_directions_and_means_that_are_none_are_refused() -> None:
    """An axis of length 0, no quaternions to average, weights that do not fit."""
    with pytest.raises(InputError, match="axis that is not zero"):
        quaternion.from_axis_angle([0.0, 0.0, 0.0], 1.0)
    with pytest.raises(InputError, match="direction that is not zero"):
        quaternion.between([0.0, 0.0, 0.0], [1.0, 0.0, 0.0])
    with pytest.raises(InputError, match="n ≥ 1"):
        quaternion.mean(np.zeros((0, 4)))
    with pytest.raises(InputError, match="2 `weights`"):
        quaternion.mean(quaternion.identity((2,)), [1.0, -1.0])
    with pytest.raises(InputError, match=r"\(\.\.\., 4\), got \(3,\)"):
        quaternion.normalize([1.0, 2.0, 3.0])
