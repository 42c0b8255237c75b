"""The recordings performed beforehand, feet on the ground: what is played live, and what is laid end to end at once.

In recordings feet slide: markers slip, bodies were brought onto another skeleton. All of what comes is known of each, so that
the most of it can be put right at leisure, by `kinesics.synthesis.embodiment.planting`; live is left what transitions and bends do.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.geometry import quaternion
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.planting import Followed, pin, with_the_feet
from kinesics.synthesis.embodiment.ranges import put_within_range
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.embodiment.steady_feet import steady_feet
from kinesics.synthesis.embodiment.toes import toes_above_the_floor, usual_heights
from kinesics.synthesis.paths.meeting import same_soles
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_ANYWHERE: Final = 10.0
"""Metres: as of `pin`, where the body may go wherever its feet carry it."""
_PATIENT: Final = 12
"""Rounds, as of `pin`."""
_AT_ONCE: Final = 6000
"""Frames that are performed at once, for the sake of memory."""
_URGED: Final = 0.0
"""Metres, as of `pin`: what is asked of a body that plays on and on is asked of it in every round, so gently."""
_OVERLAP: Final = 3.0
"""Seconds besides before and after, so that what lies beyond a stretch hardly tells within it."""
_MEETING: Final = 0.5
"""Seconds before and after the first frame of a stretch in which the one before goes over into it."""


def played(stage: Stage) -> Repertoire:
    """The repertoire with its feet planted, as paths are laid end to end from it; done once and kept as long as that is.

    In many recordings every stride is a little longer than legs can make that stand: played round after round, what each lacks
    adds up, and no leg could make up for it where the paths were laid. Here the body goes as far as its feet carry it. Poses,
    by which moments are compared, are those recorded.
    """
    return stage.repertoire.kept(_planted)


def drawn(stage: Stage) -> Array:
    """Where toes usually end as they are played (`toes.usual_heights`), metres, shape (n,); kept as long as the repertoire is."""
    return stage.repertoire.kept(_drawn)


def _drawn(own: Repertoire) -> Array:
    stage = Stage.of(own)
    return usual_heights(stage, played(stage))


def _planted(own: Repertoire) -> Repertoire:
    stage = Stage.of(own)
    rotations, roots = own.rotations.copy(), own.root_positions.copy()
    turned = np.zeros(roots.shape[:2])
    for image in (0, 1) if own.mirrored else (0,):
        for first, past in itertools.pairwise(own.starts.tolist()):
            standing = own.contacts[image, first:past]
            steady = steady_feet(stage, own.rotations[image, first:past], standing)
            along = with_the_feet(stage, steady, own.root_positions[image, first:past], standing)
            turned[image, first:past] = along.turn
            rotations[image, first:past], roots[image, first:past] = _in_stretches(stage, along, standing)
    usual = usual_heights(stage, dataclasses.replace(own, rotations=rotations, root_positions=roots))
    for image in (0, 1) if own.mirrored else (0,):
        for first, past in itertools.pairwise(own.starts.tolist()):
            part = slice(first, past)
            rotations[image, part] = toes_above_the_floor(stage, rotations[image, part], roots[image, part], usual)
    for array in (rotations, roots, turned):
        array.setflags(write=False)
    out = dataclasses.replace(own, rotations=rotations, root_positions=roots, turned=turned)
    same_soles(out, own)
    return out


def _in_stretches(stage: Stage, given: Followed, standing: Mask) -> tuple[Array, Array]:
    """One recording planted, a stretch after the other: rotations (frames, joints, 4) and places of the root (frames, 3).

    Each begins where the one before has come to, and over `_MEETING` the one goes over into the other.
    """
    fps, frames = stage.repertoire.fps, len(given.roots)
    rotations, roots = np.empty_like(given.rotations), np.empty_like(given.roots)
    overlap, meeting = math.ceil(_OVERLAP * fps), math.ceil(_MEETING * fps)
    for a in range(0, frames, _AT_ONCE):
        low, high = max(a - overlap, 0), min(a + _AT_ONCE + overlap, frames)
        part = slice(low, high)
        done = pin(
            stage,
            given.rotations[part],
            given.roots[part],
            standing[part],
            adrift=_ANYWHERE,
            urged=_URGED,
            rounds=_PATIENT,
            turning=False,
        )
        if a == 0:
            rotations[:high], roots[:high] = done.rotations, done.roots
            continue
        places = done.roots + (roots[a] - done.roots[a - low]) * [1.0, 0.0, 1.0]
        begin, end = max(a - meeting, low), min(a + meeting, high)
        both, late = slice(begin, end), slice(begin - low, end - low)
        share = blending.ease(np.linspace(0.0, 1.0, end - begin + 2)[1:-1])
        rotations[both] = quaternion.slerp(rotations[both], done.rotations[late], share[:, None])
        roots[both] += share[:, None] * (places[late] - roots[both])
        rotations[end:high], roots[end:high] = done.rotations[end - low :], places[end - low :]
        between = np.zeros(high, dtype=np.bool_)
        between[both] = True
        put_within_range(stage, rotations[:high], np.arange(stage.carrier + 1, rotations.shape[1]), between)
    return rotations, roots
