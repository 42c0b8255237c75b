"""Pictures that already have the pixels that they are shown in."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.image import AxesImage
from matplotlib.transforms import IdentityTransform


class PixelImage(AxesImage):
    """An image (rows, columns, 3) of bytes that is laid on the axes as it is, where these have as many pixels.

    matplotlib resamples every image, which takes longer than to make a plot of Z. Where sizes differ, this one is, too.
    """

    def make_image(self, renderer: Any, magnification: float = 1.0, unsampled: bool = False) -> Any:
        """As matplotlib asks: RGBA with its lowest row first, the place of its lower left corner, and a transform."""
        image = np.asarray(self.get_array())
        rows, columns = image.shape[:2]
        axes = self.axes
        assert axes is not None
        place = axes.get_window_extent(renderer)
        corner = (round(place.x0), round(place.y0))
        same = np.allclose(
            (*place.extents, *axes.get_xlim(), *axes.get_ylim()),
            (*corner, corner[0] + columns, corner[1] + rows, *self.get_extent()),
            rtol=1e-6,
            atol=0.01,
        )
        if unsampled or magnification != 1.0 or not same:
            return super().make_image(renderer, magnification, unsampled)
        pixels = np.full((rows, columns, 4), 255, dtype=np.uint8)
        pixels[..., :3] = image
        return pixels, *corner, IdentityTransform()
