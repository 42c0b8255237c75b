"""Ways over the floor as feet carry the body, rather than as it was recorded.

In many recordings feet slide: every stride is a little longer than legs that stand can make it. What is performed has its feet
planted, so ways that are decided for by the recordings lead elsewhere, the further the longer they are: 4 % beside a target. Here
the same paths are measured on the recordings with their feet planted beforehand (`synthesis.embodiment.rehearsal`), as which they
are laid end to end.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from kinesics.synthesis.embodiment.rehearsal import played
from kinesics.synthesis.embodiment.stage import Stage
from kinesics.synthesis.joining.measures import from_heading
from kinesics.synthesis.paths.meeting import Meeting, meetings
from kinesics.synthesis.paths.network import Network


def afoot(network: Network) -> Network:
    """The same network, whose ways over the floor are those of the recordings with their feet planted.

    Raises
    ------
    SkeletonError
        If the skeleton's legs have no feet.
    """
    planted = played(Stage.of(network.repertoire))
    first, onward = network.first, network.onward
    gone = planted.roots_of(onward)[:, [0, 2]] - planted.roots_of(first)[:, [0, 2]]
    displacement = from_heading(gone, planted.yaw_of(first))
    faced = network.turn + planted.turned_at(onward) - planted.turned_at(first)
    leaps = np.flatnonzero(network.cost > 0.0)
    left = np.searchsorted(network.indptr, leaps, side="right") - 1
    place, turn = np.zeros((len(network.indices), 2)), np.zeros(len(network.indices))
    place[leaps], turn[leaps] = meetings(planted, onward[left], first[network.indices[leaps]])
    for values in (displacement, faced, place, turn):
        values.setflags(write=False)
    return dataclasses.replace(
        network, displacement=displacement, turn=faced, meeting=Meeting(place, turn), afoot=planted
    )
