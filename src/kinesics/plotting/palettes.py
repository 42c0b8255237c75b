"""The two colours of the Z/Z* plot: light that adds up, so that both together are white ([Schultz2012] §3.4).

The dissertation shows Z on the red channel and Z* on green and blue. Any two colours that add up to white do the same;
the one for the colour-blind was chosen so that its two lights stay apart from each other, from black and from white for
every kind of colour blindness (tests/plotting holds it to that with the simulation of Machado, Oliveira & Fernandes 2009).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Palette:
    """Two lights on black; colours are sRGB in [0, 1]."""

    name: str
    z: Colour
    """Of similarity alone: the same pose."""
    z_mirror: Colour
    """Of anti-similarity alone: the mirrored pose."""
    z_word: str
    """What people call the colour, for captions."""
    z_mirror_word: str
    both_word: str = "white"


PALETTES: Final[dict[str, Palette]] = {
    # §3.4: "orthogonal color vectors, red and cyan"
    "thesis": Palette("thesis", (1.0, 0.0, 0.0), (0.0, 1.0, 1.0), "red", "cyan"),
    # Red and cyan differ for a protanope mostly in lightness, and red is nearly black to them. Orange and blue
    # differ along the axis that red-green blindness leaves whole, and both are well above black.
    "colorblind": Palette("colorblind", (1.0, 0.55, 0.0), (0.0, 0.45, 1.0), "orange", "blue"),
    # Figures 20-31, where one matrix is shown alone
    "grey": Palette("grey", (1.0, 1.0, 1.0), (1.0, 1.0, 1.0), "light", "light", "light"),
}
"""The palettes by name."""


def find_palette(palette: str | Palette) -> Palette:
    """A palette by its name, or itself.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    if isinstance(palette, Palette):
        return palette
    if palette not in PALETTES:
        raise InputError(f"No palette is called '{palette}'. Palettes: {', '.join(PALETTES)}.")
    return PALETTES[palette]


def blend(z: ArrayLike | None, z_mirror: ArrayLike | None, palette: str | Palette = "thesis") -> NDArray[np.uint8]:
    """Colours of Z and Z*: the sum of the two lights, 0 black and 1 full, linearly (§3.2, §3.4).

    Parameters
    ----------
    z, z_mirror : values in [0, 1], same shape (...); one of them may be None to show the other alone.

    Returns
    -------
    sRGB, shape (..., 3).

    Raises
    ------
    InputError
        If both are None or their shapes differ.
    """
    colours = find_palette(palette)
    layers = [
        (np.asarray(values, dtype=np.float32), colour)
        for values, colour in ((z, colours.z), (z_mirror, colours.z_mirror))
        if values is not None
    ]
    if not layers:
        raise InputError("Expected `z`, `z_mirror` or both, got neither.")
    if len({values.shape for values, _ in layers}) > 1:
        raise InputError(
            f"Expected `z` and `z_mirror` of one shape, got {layers[0][0].shape} and {layers[1][0].shape}."
        )
    out = np.empty((*layers[0][0].shape, 3), dtype=np.uint8)
    for channel in range(3):
        light = sum(values * np.float32(255.0 * colour[channel]) for values, colour in layers)
        out[..., channel] = np.clip(np.rint(light), 0.0, 255.0)
    return out
