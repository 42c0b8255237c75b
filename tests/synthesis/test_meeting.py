"""How two moments meet at a cut: by the feet that bear on both sides."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import kinesics as kx
from kinesics.synthesis.paths import meeting
from kinesics.synthesis.paths.meeting import meetings, soles_beneath
from kinesics.synthesis.repertoire import Repertoire, repertoire


@pytest.fixture(scope="module")
def own() -> Repertoire:
    walk = kx.performer.walk(seconds=6, fps=30, noise_degrees=0.5, noise_kind="smooth", route="circle", seed=1)
    return repertoire(walk.motion)


def bearing_feet(own: Repertoire, standing: tuple[bool, bool]) -> np.ndarray:
    """Frames around which the feet bear so all the time."""
    kept = np.all([np.roll(own.contacts[0], k, axis=0) == standing for k in range(-3, 4)], axis=(0, 2))
    kept[:4] = kept[-4:] = False
    return np.flatnonzero(kept)


def test_a_moment_meets_itself_where_it_is(own: Repertoire) -> None:
    """Nothing is shifted or turned where what is entered is what is left."""
    moments = np.arange(0, own.frame_count, 7)
    found = meetings(own, moments, moments)
    assert np.abs(found.place).max() < 1e-12
    assert np.abs(found.turn).max() < 1e-12


def test_mirror_images_meet_as_mirror_images(own: Repertoire, rng: np.random.Generator) -> None:
    """The meeting of mirrored moments is the mirror image of that of the moments as recorded."""
    left, entered = rng.integers(own.frame_count, size=(2, 40))
    entered = entered + own.frame_count * rng.integers(2, size=40)
    image = np.where(own.is_mirrored(entered), entered - own.frame_count, entered + own.frame_count)
    found, mirrored = meetings(own, left, entered), meetings(own, left + own.frame_count, image)
    np.testing.assert_array_equal(mirrored.place, found.place * [-1.0, 1.0])
    np.testing.assert_array_equal(mirrored.turn, -found.turn)


def test_a_foot_that_bears_on_both_sides_stays(own: Repertoire) -> None:
    """The middle of the one bearing sole comes to lie nearly where it was, though the pelvis lies elsewhere."""
    left = bearing_feet(own, (True, False))
    entered = np.roll(left, 2)
    found = meetings(own, left, entered)
    place = found.place[:, 1] + 1j * found.place[:, 0]
    here, there = (soles_beneath(own, m)[:, 0].mean(axis=1) for m in (left, entered))
    here, there = (v[:, 2] + 1j * v[:, 0] for v in (here, there))
    apart = np.abs(here - there)
    assert apart.max() > 0.05
    assert np.abs(here - (place + np.exp(1j * found.turn) * there)).max() < 0.1 * apart.max() + 0.01


def test_in_flight_the_pelvis_decides(own: Repertoire, rng: np.random.Generator) -> None:
    """Where no foot bears, place and heading are those of the pelvis."""
    flying = dataclasses.replace(own, contacts=np.zeros_like(own.contacts))
    left, entered = rng.integers(own.frame_count, size=(2, 20))
    found = meetings(flying, left, entered)
    assert np.abs(found.place).max() < 1e-12
    assert np.abs(found.turn).max() < 1e-12


def test_no_other_turn_and_shift_brings_the_soles_nearer(own: Repertoire, rng: np.random.Generator) -> None:
    """The sum of squares that is told to be least is no less anywhere near."""
    left = bearing_feet(own, (True, False))[:1]
    entered = bearing_feet(own, (True, False))[4:5]
    found = meetings(own, left, entered)
    a, b = (soles_beneath(own, m)[0] for m in (left, entered))
    height = 0.5 * (a[..., 1] + b[..., 1])
    weight = np.exp(-(height - height.min(axis=1, keepdims=True)) / meeting.BEARING)
    weight = weight / weight.sum(axis=1, keepdims=True) * np.array([[1.0], [0.0]])

    def squares(x: float, z: float, turn: float) -> float:
        sine, cosine = np.sin(turn), np.cos(turn)
        there_x, there_z = cosine * b[..., 0] + sine * b[..., 2] + x, cosine * b[..., 2] - sine * b[..., 0] + z
        feet = weight * ((a[..., 0] - there_x) ** 2 + (a[..., 2] - there_z) ** 2)
        return float(feet.sum() + meeting.PELVIS * (x * x + z * z) + 2.0 * meeting.HEADING * (1.0 - np.cos(turn)))

    best = squares(*found.place[0], found.turn[0])
    for off in rng.normal(0.0, 0.01, (50, 3)):
        assert squares(*(np.array([*found.place[0], found.turn[0]]) + off)) > best
