"""Where feet and body go: the sum of squares is written out by a slow twin, and bearing feet stay."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.synthesis.embodiment import footing
from kinesics.synthesis.embodiment.footing import Bounds, Leg, Usual
from naive import footing as naive

Array = NDArray[np.float64]
FPS = 50.0
USUAL = Usual(np.array([60.0, 70.0]), np.array([100.0, 90.0]), 8.0)


def walk(rng: np.random.Generator, frames: int) -> tuple[Array, Array, Array, Array, Leg]:
    """Legs that swing, and soles that slide and are not quite on the floor."""
    hips = np.array([[0.1, 0.9, 0.0], [-0.1, 0.9, 0.0]]) + 0.01 * rng.normal(size=(frames, 2, 3))
    ankles = np.array([[0.1, 0.1, 0.1], [-0.1, 0.1, -0.1]]) + 0.03 * rng.normal(size=(frames, 2, 3))
    knees = 0.5 * (hips + ankles) + np.array([0.0, 0.0, 0.08])
    slid = 0.002 * rng.normal(size=(frames - 1, 2, 2))
    height = 0.01 * rng.normal(size=(frames, 2))
    standing = (np.arange(frames)[:, None] // 8 + np.array([0, 1])) % 2 > 0
    grip = np.minimum(standing[1:], standing[:-1]).astype(float)
    return slid, grip, height, standing.astype(float), footing.legs_of(hips, knees, ankles)


def sought(
    slid: Array, grip: Array, height: Array, press: Array, leg: Leg, bounds: Bounds, both: Array | float = 0.0
) -> footing.Footing:
    stiff = footing.stiffness(leg, USUAL, FPS)
    return footing.footing(slid, grip, height, press, stiff, FPS, bounds, both)


@pytest.fixture(params=["compiled", "numpy"])
def way(request, monkeypatch) -> str:
    """Each way forced in turn."""
    if request.param == "compiled" and compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    monkeypatch.delenv("KINESICS_KERNEL", raising=False)
    monkeypatch.setenv("KINESICS_NO_NATIVE", "1" if request.param == "numpy" else "0")
    return request.param


@pytest.mark.usefixtures("way")
def test_the_least_is_found(rng: np.random.Generator) -> None:
    """Whatever is changed, the sum of squares that the twin adds up grows."""
    given = walk(rng, 20)
    way = rng.normal(size=(20, 2, 3))
    way *= (rng.random((20, 2)) < 0.5)[..., None] / np.linalg.norm(way, axis=-1, keepdims=True)
    bounds, both = Bounds(way, rng.uniform(-0.01, 0.02, (20, 2))), rng.random(20)
    found = sought(*given, bounds, both)
    least = naive.sum_of_squares(found.feet, found.body, *given, USUAL, FPS, bounds, both)
    for _ in range(50):
        feet = found.feet + 1e-4 * rng.normal(size=found.feet.shape)
        body = found.body + 1e-4 * rng.normal(size=found.body.shape)
        assert naive.sum_of_squares(feet, body, *given, USUAL, FPS, bounds, both) > least
    for axis in range(3):
        body = found.body.copy()
        for step in (-1e-6, 1e-6):
            body[7, axis] = found.body[7, axis] + step
            assert naive.sum_of_squares(found.feet, body, *given, USUAL, FPS, bounds, both) > least


@pytest.mark.parametrize("frames", [3, 4, 5, 400])
def test_compiled_and_plain_agree(frames: int, monkeypatch, rng: np.random.Generator) -> None:
    """The compiled module and SciPy solve the same system to a tenth of a micrometre, from the shortest on."""
    if compiled.native is None:
        pytest.skip("The compiled kernels were not built.")
    given = walk(rng, frames)
    direction = rng.normal(size=(frames, 2, 3))
    direction *= (rng.random((frames, 2)) < 0.5)[..., None] / np.linalg.norm(direction, axis=-1, keepdims=True)
    bounds, both = Bounds(direction, rng.uniform(-0.01, 0.02, (frames, 2))), rng.random(frames)
    monkeypatch.delenv("KINESICS_KERNEL", raising=False)
    monkeypatch.setenv("KINESICS_NO_NATIVE", "0")
    quick = sought(*given, bounds, both)
    monkeypatch.setenv("KINESICS_NO_NATIVE", "1")
    plain = sought(*given, bounds, both)
    np.testing.assert_allclose(quick.feet, plain.feet, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(quick.body, plain.body, rtol=0.0, atol=1e-7)
    assert np.abs(plain.feet).max() > 1e-4


@pytest.mark.usefixtures("way")
def test_what_has_no_answer_is_refused(rng: np.random.Generator) -> None:
    """Of what is no number there is no least sum, rather than places that are none."""
    slid, grip, height, press, leg = walk(rng, 12)
    leg.knee[5, 0] = np.nan
    with pytest.raises(np.linalg.LinAlgError, match="not finite"):
        sought(slid, grip, height, press, leg, Bounds.none(12))


def test_a_bearing_foot_stays(rng: np.random.Generator) -> None:
    """What a sole slides while it bears is taken away, to less than a millimetre a contact."""
    slid, grip, _, press, leg = walk(rng, 64)
    height = np.broadcast_to(np.array([0.02, -0.02]), (64, 2))
    found = sought(slid, grip, height, press, leg, Bounds.none(64))
    left = np.diff(found.feet[..., [0, 2]], axis=0) + slid
    assert np.abs(left[grip > 0.0]).sum() / 8 < 1e-3
    assert np.abs((found.feet[..., 1] + height)[press > 0.0]).max() < 0.015


def test_nothing_is_asked_nothing_is_added(rng: np.random.Generator) -> None:
    """Feet that neither slide nor hover are left alone, and so are feet in the air."""
    slid, grip, height, press, leg = walk(rng, 30)
    for weight in (1.0, 0.0):
        found = sought(
            (1.0 - weight) * slid,
            weight * grip,
            (1.0 - weight) * height,
            weight * press,
            leg,
            Bounds.none(30),
        )
        assert np.abs(found.feet).max() < 1e-12
        assert np.abs(found.body).max() < 1e-12


def test_a_bound_foot_takes_the_body_along() -> None:
    """A foot that must be ahead beneath the body and bears where it is has the body go back."""
    frames = 40
    ones = np.ones((frames, 2))
    hips = np.broadcast_to(np.array([[0.1, 0.9, 0.0], [-0.1, 0.9, 0.0]]), (frames, 2, 3))
    ankles = hips - np.array([0.0, 0.8, 0.0])
    leg = footing.legs_of(hips, 0.5 * (hips + ankles) + np.array([0.0, 0.0, 0.1]), ankles)
    bounds = Bounds(np.broadcast_to(np.array([0.0, 0.0, 1.0]), (frames, 2, 3)), np.full((frames, 2), 0.02))
    zero = np.zeros((frames - 1, 2, 2))
    found = sought(zero, ones[1:], 0.0 * ones, ones, leg, bounds)
    assert (found.feet[..., 2] - found.body[:, None, 2])[10:-10] == pytest.approx(0.02, abs=1e-3)
    assert np.abs(np.diff(found.feet[..., 2], axis=0)).max() < 1e-4


@pytest.mark.parametrize("frames", [1, 2])
def test_too_short_to_have_accelerations(frames: int, rng: np.random.Generator) -> None:
    """One or two frames are left as they are."""
    slid, grip, height, press, leg = walk(rng, frames)
    found = sought(slid, grip, height, press, leg, Bounds.none(frames))
    assert found.feet.shape == (frames, 2, 3)
    assert not found.feet.any()
    assert not found.body.any()


def test_a_straight_knee_counts_as_a_little_bent() -> None:
    """How much a knee turns for a metre is finite for a straight leg, and that of the law of cosines for a bent one."""
    hips = np.zeros((2, 2, 3))
    ankles = np.broadcast_to(np.array([0.0, -0.8, 0.0]), (2, 2, 3))
    knees = np.broadcast_to(np.array([0.0, -0.4, 0.0]), (2, 2, 3)).copy()
    assert np.isfinite(footing.legs_of(hips, knees, ankles).knee).all()
    knees[..., 2] = 0.2
    leg = footing.legs_of(hips, knees, ankles)
    upper = np.hypot(0.4, 0.2)
    angles = [np.arccos(1.0 - far**2 / (2.0 * upper**2)) for far in (0.8 - 1e-6, 0.8 + 1e-6)]
    assert leg.knee == pytest.approx((angles[1] - angles[0]) / 2e-6, rel=1e-5)
