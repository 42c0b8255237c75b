"""Pictures that already have the pixels that they are shown in."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.image import AxesImage
from matplotlib.transforms import IdentityTransform
from numpy.typing import NDArray


class PixelImage(AxesImage):
    """An image (rows, columns, 3) of bytes that is laid on the axes as it is, where these have as many pixels or more.

    matplotlib resamples every image, which takes longer than to make a plot of Z. Where the axes have more pixels, each shows what
    lies at its middle; where they have fewer, or show another part, matplotlib does it.
    """

    def make_image(self, renderer: Any, magnification: float = 1.0, unsampled: bool = False) -> Any:
        """As matplotlib asks: RGBA with its lowest row first, the place of its lower left corner, and a transform."""
        image = np.asarray(self.get_array())
        rows, columns = image.shape[:2]
        axes = self.axes
        assert axes is not None
        place = axes.get_window_extent(renderer)
        left, low, right, top = (round(v) for v in place.extents)
        wide, high = right - left, top - low
        fills = np.allclose(
            (*place.extents, *axes.get_xlim(), *axes.get_ylim()),
            (left, low, right, top, *self.get_extent()),
            rtol=1e-6,
            atol=0.01,
        )
        if unsampled or magnification != 1.0 or not fills or wide < columns or high < rows:
            return super().make_image(renderer, magnification, unsampled)
        if (high, wide) != (rows, columns):
            image = image[_nearest(rows, high)][:, _nearest(columns, wide)]
        pixels = np.full((high, wide, 4), 255, dtype=np.uint8)
        pixels[..., :3] = image
        return pixels, left, low, IdentityTransform()


def _nearest(cells: int, pixels: int) -> NDArray[np.intp]:
    """The cell at the middle of each pixel."""
    return ((2 * np.arange(pixels, dtype=np.intp) + 1) * cells) // (2 * pixels)
