"""Rigid motions: the group SE(3), its adjoint, its exponential and logarithm."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose

from kinesics.errors import InputError
from kinesics.geometry import quaternion, rigid
from kinesics.geometry.rigid import Rigid
from naive import geometry as naive

SHAPES = [(), (1,), (3, 1, 2, 1)]
ANGLES = [0.0, 1e-200, 1e-12, 1e-6, 1e-3, 0.1, 0.49999, 0.5, 0.50001, 1.0, 3.0, np.pi - 1e-6, np.pi - 1e-12, np.pi]

unit_vectors = (
    arrays(np.float64, 3, elements=st.floats(-1.0, 1.0))
    .filter(lambda v: np.linalg.norm(v) > 1e-2)
    .map(lambda v: v / np.linalg.norm(v))
)
sizes = st.one_of(st.floats(0.0, np.pi, allow_subnormal=False), st.sampled_from(ANGLES))
lengths = st.floats(-10.0, 10.0)
twists = st.builds(
    lambda v, axis, angle: np.concatenate([v, angle * axis]),
    arrays(np.float64, 3, elements=lengths),
    unit_vectors,
    sizes,
)


def random(rng: np.random.Generator, shape: tuple[int, ...]) -> Rigid:
    return Rigid(quaternion.normalize(rng.normal(size=(*shape, 4))), rng.normal(size=(*shape, 3)))


def assert_same_motion(a: Rigid, b: Rigid, within: float = 1e-12) -> None:
    __tracebackhide__ = True
    assert_allclose(rigid.as_matrix(a), rigid.as_matrix(b), atol=within)


@pytest.mark.parametrize("shape", SHAPES)
def test_group_axioms_hold_for_every_batch_shape(rng: np.random.Generator, shape: tuple[int, ...]) -> None:
    """Associative, with identity and inverse, and composition is the product of homogeneous matrices."""
    a, b, c = (random(rng, shape) for _ in range(3))
    one = rigid.identity(shape)
    product = rigid.compose(a, b)
    assert rigid.as_matrix(product).shape == (*shape, 4, 4)
    assert_allclose(rigid.as_matrix(product), rigid.as_matrix(a) @ rigid.as_matrix(b), atol=1e-14)
    assert_same_motion(rigid.compose(product, c), rigid.compose(a, rigid.compose(b, c)))
    assert_same_motion(rigid.compose(a, one), a)
    assert_same_motion(rigid.compose(one, a), a)
    assert_same_motion(rigid.compose(a, rigid.inverse(a)), one)
    assert_same_motion(rigid.compose(rigid.inverse(a), a), one)


@pytest.mark.parametrize("shape", SHAPES)
def test_applied_to_points(rng: np.random.Generator, shape: tuple[int, ...]) -> None:
    """§2.3: r_A = Q r_B + p, the same as the homogeneous matrix on (r, 1); acting is associative."""
    a, b, r = random(rng, shape), random(rng, shape), rng.normal(size=(*shape, 3))
    homogeneous = np.concatenate([r, np.ones((*shape, 1))], axis=-1)
    expected = np.einsum("...ij,...j->...i", rigid.as_matrix(a), homogeneous)[..., :3]
    assert_allclose(rigid.apply(a, r), expected, atol=1e-14)
    assert_allclose(rigid.apply(a, rigid.apply(b, r)), rigid.apply(rigid.compose(a, b), r), atol=1e-14)


def test_the_group_is_a_semidirect_product(rng: np.random.Generator) -> None:
    """§2.3 prints SE(3) = R³ × SO(3): as a group translations do not simply add."""
    a, b = random(rng, ()), random(rng, ())
    together = rigid.compose(a, b).translation
    assert_allclose(together, a.translation + quaternion.rotate(a.rotation, b.translation))
    assert np.linalg.norm(together - (a.translation + b.translation)) > 0.1


def test_matrix_and_back(rng: np.random.Generator) -> None:
    """Homogeneous matrices come back as the same rigid motions."""
    g = random(rng, (4, 3))
    assert_same_motion(rigid.from_matrix(rigid.as_matrix(g)), g)
    assert_allclose(rigid.as_matrix(g)[1, 2], naive.homogeneous(g.rotation[1, 2], g.translation[1, 2]), atol=1e-15)


@given(twists)
def test_exponential_and_logarithm_are_inverse(twist: np.ndarray) -> None:
    """Up to half a turn the logarithm gives back the twist: near 0, near π, and between."""
    back = rigid.log(rigid.exp(twist))
    angle = np.linalg.norm(twist[3:])
    if angle > np.pi - 1e-7:
        # either axis is right at π: compare where they lead
        assert_same_motion(rigid.exp(back), rigid.exp(twist), within=1e-12)
    else:
        assert_allclose(back, twist, rtol=1e-12, atol=1e-12 * max(1.0, float(np.abs(twist).max())))


@given(twists)
def test_exponential_is_the_matrix_exponential(twist: np.ndarray) -> None:
    """Against the power series of exp(ξ̂)."""
    assert_allclose(rigid.as_matrix(rigid.exp(twist)), naive.exp_matrix(naive.hat_twist(twist)), atol=1e-11)


@pytest.mark.parametrize("angle", [*ANGLES, 4.0, 7.0, 50.0])
def test_exponential_has_no_seam(angle: float) -> None:
    """The series and the closed form agree where one takes over from the other, and beyond whole turns."""
    axis, v = np.array([2.0, -1.0, 2.0]) / 3.0, np.array([0.3, -1.2, 0.8])
    twist = np.concatenate([v, angle * axis])
    g = rigid.exp(twist)
    assert_allclose(rigid.as_matrix(g), naive.exp_matrix(naive.hat_twist(twist)), atol=1e-12)
    assert_same_motion(rigid.exp(rigid.log(g)), g, within=1e-13)


@given(twists)
def test_logarithm_is_blind_to_the_quaternions_sign(twist: np.ndarray) -> None:
    """(q, p) and (−q, p) are one rigid motion and have one logarithm."""
    g = rigid.exp(twist)
    other = Rigid(-g.rotation, g.translation)
    assert_same_motion(rigid.exp(rigid.log(other)), g, within=1e-12)
    if abs(g.rotation[0]) > 1e-9:
        assert_allclose(rigid.log(other), rigid.log(g), atol=1e-12)


def test_g_minus_identity_is_only_the_first_order(rng: np.random.Generator) -> None:
    """§2.4 takes ξ̂ = g − I: its error grows as the square of the step, and its last row is (0 0), not (0 1)."""
    twist = rng.normal(size=6)
    errors = []
    for step in (1e-2, 1e-3):
        difference = rigid.as_matrix(rigid.exp(step * twist)) - np.eye(4)
        assert_allclose(difference[3], 0.0)
        errors.append(np.abs(difference - naive.hat_twist(step * twist)).max())
    assert 50.0 < errors[0] / errors[1] < 200.0


@pytest.mark.parametrize("shape", SHAPES)
def test_adjoint_identities(rng: np.random.Generator, shape: tuple[int, ...]) -> None:
    """Ad(ab) = Ad(a) Ad(b), Ad(g⁻¹) = Ad(g)⁻¹, and g exp(ξ) g⁻¹ = exp(Ad(g) ξ)."""
    a, b = random(rng, shape), random(rng, shape)
    twist = rng.normal(size=(*shape, 6))
    assert rigid.adjoint(a).shape == (*shape, 6, 6)
    assert_allclose(rigid.adjoint(rigid.compose(a, b)), rigid.adjoint(a) @ rigid.adjoint(b), atol=1e-13)
    identity = np.broadcast_to(np.eye(6), (*shape, 6, 6))
    assert_allclose(rigid.adjoint(rigid.inverse(a)) @ rigid.adjoint(a), identity, atol=1e-13)
    moved = np.einsum("...ij,...j->...i", rigid.adjoint(a), twist)
    conjugated = rigid.compose(rigid.compose(a, rigid.exp(twist)), rigid.inverse(a))
    assert_same_motion(rigid.exp(moved), conjugated)


def test_adjoint_by_its_definition(rng: np.random.Generator) -> None:
    """Column k is the twist of g ê_k g⁻¹."""
    g = random(rng, ())
    assert_allclose(rigid.adjoint(g), naive.adjoint(rigid.as_matrix(g)), atol=1e-13)


def test_agrees_with_pytransform3d(rng: np.random.Generator) -> None:
    """An independent library (whose twists are ω first) has the same exponential, logarithm and adjoint."""
    theirs = pytest.importorskip("pytransform3d.transformations", reason="pytransform3d is not installed")
    twist = np.concatenate([rng.normal(size=3), [0.4, -1.1, 0.7]])
    omega_first = np.roll(twist, 3)
    g = rigid.exp(twist)
    matrix = theirs.transform_from_exponential_coordinates(omega_first)
    assert_allclose(rigid.as_matrix(g), matrix, atol=1e-12)
    assert_allclose(np.roll(rigid.log(g), 3), theirs.exponential_coordinates_from_transform(matrix), atol=1e-12)
    swap = np.roll(np.eye(6), 3, axis=0)
    assert_allclose(swap @ rigid.adjoint(g) @ swap, theirs.adjoint_from_transform(matrix), atol=1e-12)


def test_leading_axes_broadcast(rng: np.random.Generator) -> None:
    """One rigid motion acts on many, and on many points."""
    one, many, points = random(rng, ()), random(rng, (5,)), rng.normal(size=(7, 5, 3))
    together = rigid.compose(one, many)
    assert together.rotation.shape == (5, 4)
    assert together.translation.shape == (5, 3)
    assert rigid.apply(many, points).shape == (7, 5, 3)
    assert rigid.log(Rigid(one.rotation, many.translation)).shape == (5, 6)
    assert rigid.as_matrix(Rigid(one.rotation, many.translation)).shape == (5, 4, 4)
    assert rigid.adjoint(Rigid(many.rotation, one.translation)).shape == (5, 6, 6)


def test_what_is_no_rigid_motion_is_refused() -> None:
    """Wrong shapes, a projective last row, NaN, a twist of five numbers."""
    with pytest.raises(InputError, match=r"\(\.\.\., 4, 4\), got \(3, 3\)"):
        rigid.from_matrix(np.eye(3))
    with pytest.raises(InputError, match="last row"):
        rigid.from_matrix(np.ones((4, 4)))
    bad = np.eye(4)
    bad[0, 3] = np.nan
    with pytest.raises(InputError, match="finite translations"):
        rigid.from_matrix(bad)
    with pytest.raises(InputError, match=r"\(\.\.\., 6\), got \(5,\)"):
        rigid.exp(np.zeros(5))
