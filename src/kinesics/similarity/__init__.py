"""How alike two moments are: D and its mirror D*, and the similarity plots Z and Z* ([Schultz2012] §2.13-2.14, §3.1-3.4).

- two sets of poses: `distance` (D), `mirror_distance` (D*), `chord` (√(2D), the metric)
- all moments of a recording: `similarity` (Z and Z*), `default_beta`; `tiles` where N×N would not fit;
  `Prepared` for many small parts of them
- stretches of movement: `diagonal_sums`
- frame by frame: `paired_distance`, `speed`, `symmetry_residual`

The compiled kernels do the work where they were built; the environment variable ``KINESICS_KERNEL`` forces a code path
("avx512", "avx2", "portable" or "numpy"), and ``KINESICS_NO_NATIVE=1`` is the same as "numpy".
"""

from __future__ import annotations

import sys
from types import ModuleType

from kinesics.similarity._inputs import Weights, check_weights
from kinesics.similarity.matrices import BETA_RULE, Similarity, default_beta, similarity
from kinesics.similarity.metric import chord, distance, mirror_distance, paired_distance, speed, symmetry_residual
from kinesics.similarity.prepared import Prepared
from kinesics.similarity.tiling import Tile, tiles
from kinesics.similarity.windows import DiagonalSums, diagonal_sums

__all__ = [
    "BETA_RULE",
    "DiagonalSums",
    "Prepared",
    "Similarity",
    "Tile",
    "Weights",
    "check_weights",
    "chord",
    "default_beta",
    "diagonal_sums",
    "distance",
    "mirror_distance",
    "paired_distance",
    "similarity",
    "speed",
    "symmetry_residual",
    "tiles",
]


class _Room(ModuleType):
    """``kinesics.similarity`` is the name of this room and of its chief function: the room can be called."""

    __call__ = staticmethod(similarity)


sys.modules[__name__].__class__ = _Room
