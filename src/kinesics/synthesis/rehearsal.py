"""The recordings performed beforehand, feet on the ground: what is played live, and what is laid end to end at once.

In recordings feet slide: markers slip, bodies were brought onto another skeleton. All of what comes is known of each, so that
the most of it can be put right at leisure, by `kinesics.synthesis.planting`; live is left what transitions and bends do.
"""

from __future__ import annotations

import dataclasses
import itertools
import weakref
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.meeting import same_soles
from kinesics.synthesis.planting import pin
from kinesics.synthesis.repertoire import Repertoire
from kinesics.synthesis.stage import Stage
from kinesics.synthesis.steady_feet import steady_feet

Array = NDArray[np.float64]

_ANYWHERE: Final = 10.0
"""Metres: as of `pin`, where the body may go wherever its feet carry it."""
_PATIENT: Final = 12
"""Rounds, as of `pin`."""
_AT_ONCE: Final = 6000
"""Frames that are performed at once, for the sake of memory."""
_URGED: Final = 0.0
"""Metres, as of `pin`: what is asked of a body that plays on and on is asked of it in every round, so gently."""
_OVERLAP: Final = 300
"""Frames besides before and after; the next stretch takes their place."""


_plays: weakref.WeakKeyDictionary[Repertoire, Repertoire] = weakref.WeakKeyDictionary()


def played(stage: Stage) -> Repertoire:
    """The repertoire with its feet planted, as paths are laid end to end from it; done once and kept as long as that is.

    In many recordings every stride is a little longer than legs can make that stand: played round after round, what each lacks
    adds up, and no leg could make up for it where the paths were laid. Here the body goes as far as its feet carry it. Poses,
    by which moments are compared, are those recorded.
    """
    if stage.repertoire not in _plays:
        _plays[stage.repertoire] = _planted(stage)
    return _plays[stage.repertoire]


def _planted(stage: Stage) -> Repertoire:
    own = stage.repertoire
    rotations, roots = own.rotations.copy(), own.root_positions.copy()
    for image in (0, 1) if own.mirrored else (0,):
        for first, past in itertools.pairwise(own.starts.tolist()):
            for a in range(first, past, _AT_ONCE):
                low, high = max(a - _OVERLAP, first), min(a + _AT_ONCE + _OVERLAP, past)
                standing = own.contacts[image, low:high]
                steady = steady_feet(stage, own.rotations[image, low:high], standing)
                given = steady, own.root_positions[image, low:high], standing
                done = pin(stage, *given, adrift=_ANYWHERE, urged=_URGED, rounds=_PATIENT)
                places = done.roots[a - low :]
                if a > first:
                    # it goes on from where the stretch before has come to
                    places = places + (roots[image, a] - places[0]) * [1.0, 0.0, 1.0]
                rotations[image, a:high], roots[image, a:high] = done.rotations[a - low :], places
    for array in (rotations, roots):
        array.setflags(write=False)
    out = dataclasses.replace(own, rotations=rotations, root_positions=roots)
    same_soles(out, own)
    return out
