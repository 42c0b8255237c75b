"""Two lights that add up to white and stay apart for every eye."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from kinesics.errors import InputError
from kinesics.plotting import PALETTES, blend

# Machado, Oliveira & Fernandes (2009), severity 1, on linear RGB
BLINDNESS = {
    "none": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
COLOURED = [p for p in PALETTES.values() if p.name != "grey"]


def _lab(srgb: np.ndarray, blindness: np.ndarray) -> np.ndarray:
    """CIELAB of a colour as that eye sees it."""
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    linear = np.clip(blindness @ linear, 0.0, 1.0)
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) @ linear
    f = xyz / np.array([0.9505, 1.0, 1.089])
    f = np.where(f > 216 / 24389, np.cbrt(f), (24389 / 27 * f + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def _least_difference(palette_name: str, blindness: str) -> float:
    palette = PALETTES[palette_name]
    colours = [palette.z, palette.z_mirror, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)]
    seen = [_lab(np.array(c), BLINDNESS[blindness]) for c in colours]
    return min(float(np.linalg.norm(a - b)) for a, b in itertools.combinations(seen, 2))


@pytest.mark.parametrize("palette", COLOURED, ids=lambda p: p.name)
def test_the_two_lights_add_up_to_white(palette: object) -> None:
    """Where Z = Z* = 1 the picture is white, exactly."""
    assert (blend(np.ones((2, 2)), np.ones((2, 2)), palette) == 255).all()


@pytest.mark.parametrize("blindness", BLINDNESS)
def test_the_colour_blind_can_tell_the_four_corners_apart(blindness: str) -> None:
    """Black, both lights and white differ by far more than the eye needs (a just noticeable difference is about 2.3)."""
    assert _least_difference("colorblind", blindness) > 35.0


def test_red_and_cyan_are_the_worse_choice_for_red_blindness() -> None:
    """The reason for the second palette: to a protanope the dissertation's red is nearer to black than our orange is."""
    assert _least_difference("colorblind", "protanopia") > _least_difference("thesis", "protanopia")


def test_red_only_where_z_only() -> None:
    """Z alone lights red and nothing else, Z* alone cyan and nothing else (§3.4)."""
    z = np.array([1.0, 0.0, 0.5, 0.0])
    z_mirror = np.array([0.0, 1.0, 0.5, 0.0])
    np.testing.assert_array_equal(blend(z, z_mirror), [[255, 0, 0], [0, 255, 255], [128, 128, 128], [0, 0, 0]])


def test_unknown_names_and_unequal_shapes_are_refused() -> None:
    """With the names there are."""
    with pytest.raises(InputError, match="thesis, colorblind"):
        blend(np.ones(2), np.ones(2), "mauve")
    with pytest.raises(InputError, match="one shape"):
        blend(np.ones(2), np.ones(3))
    with pytest.raises(InputError, match="neither"):
        blend(None, None)
