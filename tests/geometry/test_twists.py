"""Twists and the velocities of sampled motions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from kinesics.errors import InputError
from kinesics.geometry import quaternion, rigid, twists
from kinesics.geometry.rigid import Rigid
from naive import geometry as naive

SHAPES = [(), (1,), (3, 1, 2, 1)]


def tumbling(times: np.ndarray) -> Rigid:
    """A smooth motion about no fixed axis, with known derivatives (by small differences of its formula)."""
    vector = np.stack([np.sin(times), 0.7 * np.cos(1.3 * times), 0.5 * times], axis=-1)
    place = np.stack([np.cos(times), times**2 / 5.0, np.sin(2.0 * times)], axis=-1)
    return Rigid(quaternion.from_rotvec(vector), place)


@pytest.mark.parametrize("shape", SHAPES)
def test_hat_and_vee(rng: np.random.Generator, shape: tuple[int, ...]) -> None:
    """ω̂ r = ω × r, ω̂ is skew, vee undoes hat, and the same for twists."""
    omega, r, twist = rng.normal(size=(*shape, 3)), rng.normal(size=(*shape, 3)), rng.normal(size=(*shape, 6))
    hat = twists.hat(omega)
    assert_allclose(np.einsum("...ij,...j->...i", hat, r), np.cross(omega, r), atol=1e-14)
    assert_allclose(hat, -np.swapaxes(hat, -1, -2))
    assert_allclose(twists.vee(hat), omega)
    assert twists.hat_twist(twist).shape == (*shape, 4, 4)
    assert_allclose(twists.hat_twist(twist)[..., 3, :], 0.0)
    assert_allclose(twists.vee_twist(twists.hat_twist(twist)), twist)


@pytest.mark.parametrize("rate", [0.1, 1.0, 30.0, 180.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_screw_motion_has_its_constant_twist(rng: np.random.Generator, shape: tuple[int, ...], rate: float) -> None:
    """g(t) = g₀ exp(ξ̂t) has the body twist ξ in every frame, ends included, up to nearly half a turn a frame."""
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    twist = np.concatenate([rng.normal(size=(*shape, 3)), np.broadcast_to(rate * axis, (*shape, 3))], axis=-1)
    start = Rigid(quaternion.normalize(rng.normal(size=(*shape, 4))), rng.normal(size=(*shape, 3)))
    times = (np.arange(7) / 60.0).reshape(-1, *(1,) * (len(shape) + 1))
    g = rigid.compose(start, rigid.exp(times * twist))
    assert_allclose(
        twists.body_velocity(g, 60.0), np.broadcast_to(twist, (7, *shape, 6)), rtol=1e-9, atol=1e-9 * (1 + rate)
    )
    expected = np.einsum("...ij,...j->...i", rigid.adjoint(start), twist)
    assert_allclose(
        twists.space_velocity(g, 60.0), np.broadcast_to(expected, (7, *shape, 6)), rtol=1e-9, atol=1e-9 * (1 + rate)
    )


def test_body_angular_velocity_is_q_star_q_dot() -> None:
    """ω̂ᴮ = Q*Q̇ and ω̂ᴬ = Q̇Q*, with Q̇ by small differences of matrices; §2.4's Q̇ alone is not even skew."""
    fps, t, h = 2000.0, 0.8, 1e-6
    rotation = quaternion.as_matrix(tumbling(np.array([t])).rotation)[0]
    ends = quaternion.as_matrix(tumbling(np.array([t - h, t + h])).rotation)
    q_dot = (ends[1] - ends[0]) / (2.0 * h)
    sampled = tumbling(t + np.arange(-3, 4) / fps).rotation
    assert_allclose(twists.hat(twists.angular_velocity_body(sampled, fps)[3]), rotation.T @ q_dot, atol=1e-5)
    assert_allclose(twists.hat(twists.angular_velocity_space(sampled, fps)[3]), q_dot @ rotation.T, atol=1e-5)
    assert np.abs(q_dot + q_dot.T).max() > 0.1


def test_linear_velocities_of_both_frames() -> None:
    """vᴮ = Q*ṗ and vᴬ = ṗ − ω̂ᴬp (§2.4), with ṗ by small differences."""
    fps, t, h = 2000.0, 0.8, 1e-6
    here = tumbling(np.array([t]))
    ends = tumbling(np.array([t - h, t + h])).translation
    p_dot = (ends[1] - ends[0]) / (2.0 * h)
    sampled = tumbling(t + np.arange(-3, 4) / fps)
    body, space = twists.body_velocity(sampled, fps)[3], twists.space_velocity(sampled, fps)[3]
    assert_allclose(body[:3], quaternion.rotate(quaternion.conjugate(here.rotation[0]), p_dot), atol=1e-5)
    assert_allclose(space[:3], p_dot - np.cross(space[3:], here.translation[0]), atol=1e-5)
    assert_allclose(twists.point_velocity(space, here.translation[0]), p_dot, atol=1e-5)


def test_space_twist_is_the_adjoint_of_the_body_twist() -> None:
    """Frame by frame ξᴬ = Ad(g) ξᴮ."""
    g = tumbling(np.arange(20) / 30.0)
    moved = np.einsum("...ij,...j->...i", rigid.adjoint(g), twists.body_velocity(g, 30.0))
    assert_allclose(twists.space_velocity(g, 30.0), moved, atol=1e-12)


def test_differences_are_of_second_order_inside_and_first_at_the_ends() -> None:
    """Halving the time step divides the error by four in the middle and by two at the ends."""
    t, h = 0.8, 1e-6
    exact = rigid.log(
        rigid.compose(
            rigid.inverse(tumbling(np.array(t - h))),
            tumbling(np.array(t + h)),
        )
    ) / (2.0 * h)
    errors = []
    for fps in (50.0, 100.0):
        g = tumbling(t + np.arange(-2, 3) / fps)
        middle = np.abs(twists.body_velocity(g, fps)[2] - exact).max()
        late = tumbling(t + np.arange(0, 3) / fps)
        end = np.abs(twists.body_velocity(late, fps)[0] - exact).max()
        errors.append((middle, end))
    assert 3.5 < errors[0][0] / errors[1][0] < 4.5
    assert 1.8 < errors[0][1] / errors[1][1] < 2.2


def test_signs_of_quaternions_do_not_matter(rng: np.random.Generator) -> None:
    """A file that flips q to −q from frame to frame has the same velocities."""
    g = tumbling(np.arange(30) / 30.0)
    flipped = Rigid(g.rotation * np.where(rng.random((30, 1)) < 0.5, -1.0, 1.0), g.translation)
    assert_allclose(twists.body_velocity(flipped, 30.0), twists.body_velocity(g, 30.0), atol=1e-12)
    assert_allclose(
        twists.angular_velocity_body(flipped.rotation, 30.0),
        twists.body_velocity(g, 30.0)[:, 3:],
        atol=1e-12,
    )


def test_the_velocity_of_a_whole_body(rng: np.random.Generator) -> None:
    """Frames and joints at once: each joint's column is what it would be alone."""
    q = quaternion.from_rotvec(rng.normal(scale=0.2, size=(6, 3, 3)))
    together = twists.angular_velocity_body(q, 120.0)
    assert together.shape == (6, 3, 3)
    assert_allclose(together[:, 1], twists.angular_velocity_body(q[:, 1], 120.0))


def test_the_logarithm_of_a_step_is_the_matrix_logarithm() -> None:
    """The exponential of the first step's twist, by its power series, leads from frame 0 to frame 1."""
    g = tumbling(np.array([0.3, 0.35]))
    twist = twists.body_velocity(g, 20.0)[0] / 20.0
    matrices = rigid.as_matrix(g)
    assert_allclose(matrices[0] @ naive.exp_matrix(naive.hat_twist(twist)), matrices[1], atol=1e-12)


def test_too_little_to_differ_is_refused() -> None:
    """One frame has no velocity; a frame rate is above 0; rotations and translations belong together."""
    with pytest.raises(InputError, match="at least two frames"):
        twists.angular_velocity_body(quaternion.identity((1,)), 30.0)
    with pytest.raises(InputError, match="frame rate above 0, got 0"):
        twists.angular_velocity_body(quaternion.identity((2,)), 0.0)
    with pytest.raises(InputError, match="as many rotations as translations"):
        twists.body_velocity(Rigid(quaternion.identity((3,)), np.zeros((2, 3))), 30.0)
