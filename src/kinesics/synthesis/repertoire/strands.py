"""The four ways in which every frame can be played, and what a frame in one of them is called.

**Strands.** Every frame can be played in four ways: 0 as recorded, 1 mirrored, 2 backwards, 3 backwards and mirrored.
**Moments.** A frame in a strand is one whole number, ``frame + frame_count · strand``, frames counted over all recordings
put end to end. Time runs from moment to moment within a recording and a strand: in strands 2 and 3 from frame to the frame
before.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.intp]

STRANDS: Final = ("as recorded", "mirrored", "backwards", "backwards and mirrored")
"""What each strand plays."""

MIRRORED_STRANDS: Final = (False, True, False, True)
"""Whether a strand plays the mirror image."""

BACKWARD_STRANDS: Final = (False, False, True, True)
"""Whether time runs from later frames to earlier ones in a strand."""


class FrameStrand(NamedTuple):
    """A moment taken apart."""

    frame: Indices
    """Over all recordings end to end."""
    strand: Indices
    """0 as recorded, 1 mirrored, 2 backwards, 3 backwards and mirrored."""
