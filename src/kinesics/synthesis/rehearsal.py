"""The recordings performed beforehand, feet on the ground: what is played live, and what is laid end to end at once.

In recordings feet slide: markers slip, bodies were brought onto another skeleton. All of what comes is known of each, so that
the most of it can be put right at leisure, by `kinesics.synthesis.planting`; live is left what transitions and bends do.
"""

from __future__ import annotations

import dataclasses
import itertools
import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.meeting import same_soles
from kinesics.synthesis.planting import ROUNDS, URGED, pin
from kinesics.synthesis.repertoire import Repertoire
from kinesics.synthesis.stage import Stage

Array = NDArray[np.float64]

_ANYWHERE: Final = 10.0
"""Metres: as of `pin`, where the body may go wherever its feet carry it."""
_PATIENT: Final = 12
"""Rounds, as of `pin`."""
_AT_ONCE: Final = 6000
"""Frames that are performed at once, for the sake of memory."""
_ADRIFT: Final = 0.12
"""Metres: as of `pin`. Live, ways are decided by the recordings as they are."""
_URGED: Final = 0.0
"""The same: what is asked of a body that plays on and on is asked of it in every round, so gently."""
_OVERLAP: Final = 300
"""Frames besides before and after, which are then left out."""


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """What planting the feet changes of recordings, as recorded and mirrored."""

    joints: NDArray[np.intp]
    """That are turned: those of the legs, and the one that the body hangs on."""
    rotations: Array
    """Of these, shape (2, frames, joints, 4)."""
    roots: Array
    """Places of the root, metres, shape (2, frames, 3)."""

    @classmethod
    def of(cls, stage: Stage) -> Rehearsal:
        """Of a repertoire; done once and kept as long as that is."""
        if stage.repertoire not in _rehearsals:
            _rehearsals[stage.repertoire] = cls._done(stage)
        return _rehearsals[stage.repertoire]

    @classmethod
    def _done(cls, stage: Stage) -> Rehearsal:
        own, legs = stage.repertoire, stage.legs
        joints = np.array([stage.carrier, *legs.femurs, *legs.tibias, *legs.feet])
        rotations, roots = own.rotations[:, :, joints].copy(), own.root_positions.copy()
        for part in _stretches(stage, adrift=_ADRIFT, urged=_URGED):
            kept = slice(part.begins, part.begins + part.wanted)
            rotations[part.image, kept] = part.rotations[: part.wanted, joints]
            roots[part.image, kept] = part.roots[: part.wanted]
        return cls(joints, rotations, roots)


class _Stretch(NamedTuple):
    """Some of one recording, planted."""

    image: int
    """0 as recorded, 1 mirrored."""
    begins: int
    """Its first frame, over all recordings."""
    continues: bool
    """Whether a stretch of the same recording comes before."""
    wanted: int
    """Frames of it; what lies behind them comes again in the next."""
    rotations: Array
    """Shape (frames, joints, 4)."""
    roots: Array
    """Metres, shape (frames, 3)."""


def _stretches(stage: Stage, *, adrift: float, urged: float = URGED, rounds: int = ROUNDS) -> Iterator[_Stretch]:
    """All recordings, as recorded and mirrored, planted a stretch at a time; otherwise as `pin`."""
    own = stage.repertoire
    for image in (0, 1) if own.mirrored else (0,):
        for first, past in itertools.pairwise(own.starts.tolist()):
            for a in range(first, past, _AT_ONCE):
                b = min(a + _AT_ONCE, past)
                low, high = max(a - _OVERLAP, first), min(b + _OVERLAP, past)
                given = own.rotations[image, low:high], own.root_positions[image, low:high]
                done = pin(stage, *given, own.contacts[image, low:high], adrift=adrift, urged=urged, rounds=rounds)
                yield _Stretch(image, a, a > first, b - a, done.rotations[a - low :], done.roots[a - low :])


_rehearsals: weakref.WeakKeyDictionary[Repertoire, Rehearsal] = weakref.WeakKeyDictionary()
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
    for part in _stretches(stage, adrift=_ANYWHERE, rounds=_PATIENT):
        kept = slice(part.begins, part.begins + len(part.roots))
        places = part.roots
        if part.continues:
            # it goes on from where the stretch before has come to
            places = places + (roots[part.image, part.begins] - places[0]) * [1.0, 0.0, 1.0]
        rotations[part.image, kept] = part.rotations
        roots[part.image, kept] = places
    for array in (rotations, roots):
        array.setflags(write=False)
    out = dataclasses.replace(own, rotations=rotations, root_positions=roots)
    same_soles(out, own)
    return out
