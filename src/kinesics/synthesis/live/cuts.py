"""From one recording into another live: how the two meet, how far apart they are, and how long the transition takes.

The same as `embodiment.stage.seams` and `embodiment.rendering` have it for a whole performance, one cut at a time
and in parts, so that no frame has to wait for all of it; compiled where that was built.
"""

from __future__ import annotations

import cmath
import math
import weakref
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.body import kinematics
from kinesics.geometry import single
from kinesics.geometry.single import Vector
from kinesics.synthesis.embodiment import blending
from kinesics.synthesis.embodiment.afoot import afoot
from kinesics.synthesis.embodiment.stage import LEAST_TURNING, SPARED, Stage
from kinesics.synthesis.live.blends import Blend, absorbed
from kinesics.synthesis.live.poses import Poses
from kinesics.synthesis.live.treading import Treading
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]

_SHORTEST: Final = 1e-3
"""Seconds that a transition takes to either side at least, where there is no time at all."""
_RULES: Final = [
    float(rule)
    for rule in (
        blending.PEAK,
        blending.PEAK_OF_VELOCITY,
        blending.FARTHEST,
        blending.SHORTEST,
        blending.LONGEST,
        blending.SLOWEST,
        blending.CARRIED,
        _SHORTEST,
    )
]
"""What the compiled twin of `blending.window` and `blending.at_their_own_pace` goes by."""


class Crossing(NamedTuple):
    """From one recording into another."""

    left: int
    """The moment with which what is left would have gone on."""
    first: int
    """The one that is entered."""
    aside: complex
    """By which its root lies elsewhere, z + i·x, metres."""
    turned: float
    """By which what is left is turned about the vertical, radians."""
    turn: float
    """By which what is entered is."""
    met: float
    """By which it faces elsewhere."""


class Seam(NamedTuple):
    """By how much what is entered differs from what is left, and how quickly that changes: `synthesis.embodiment.stage.Seams`."""

    offset: Array
    """Of joints and root, shape (joints + 1, 3)."""
    velocity: Array
    places: Array
    """Of the joints' places, shape (joints, 3)."""
    moving: Array


class Cuts:
    """The cuts of one performance."""

    def __init__(self, network: Network, stage: Stage, poses: Poses, treading: Treading) -> None:
        self._network, self._stage, self._poses, self._treading = network, stage, poses, treading
        self._met = _met(network, poses.own)
        which = stage.blended
        self._spared = SPARED * np.concatenate([stage.accelerations[which], stage.places])
        self._loose = np.ones(len(stage.accelerations), dtype=np.bool_)
        self._loose[which] = False
        # what each may be accelerated by that may take a time of its own
        self._slowly = np.maximum(SPARED * stage.accelerations, LEAST_TURNING)
        self._slowly[stage.lower] = np.inf
        self._which = np.asarray(which, dtype=np.int32)
        self._parents = np.array(poses.own.skeleton.parents, dtype=np.int32)
        self._arms = np.ascontiguousarray(poses.own.skeleton.offsets)

    def crossing(self, last: int, path: int, turned: float, heading: float) -> Crossing:
        """From one path into another that is no part of its recording.

        Parameters
        ----------
        turned : radians by which the first is turned about the vertical as it ends.
        heading : radians, where it then faces.
        """
        network, poses = self._network, self._poses
        left, first = int(network.onward[last]), int(network.first[path])
        # how the two meet: as the controller and `kinesics.synthesis.embodiment.rendering` have it
        edge = network.edge(last, path)
        place, met = complex(self._met[0][edge]), float(self._met[1][edge])
        turn = turned + poses.faces_onward[last] + met - poses.faces[path]
        return Crossing(left, first, place * cmath.exp(1j * heading), turned, turn, met)

    def seam(self, crossing: Crossing) -> Seam:
        """`kinesics.synthesis.embodiment.stage.seams` of one cut."""
        poses, own = self._poses, self._poses.own
        (image, here), (entered, there) = poses.around(crossing.left), poses.around(crossing.first)
        reached = [a >= 0 and b >= 0 for a, b in zip(here, there, strict=True)]
        # where either recording does not reach, the moment itself stands for the one beside it
        here = [a if both else here[1] for a, both in zip(here, reached, strict=True)]
        there = [b if both else there[1] for b, both in zip(there, reached, strict=True)]
        span = poses.reach * (reached[0] + reached[2])
        pace = own.fps / span if span else 0.0
        old, new = own.rotations[image, here], own.rotations[entered, there]
        places = own.root_positions[image, here], own.root_positions[entered, there]
        carrier, joints = poses.carrier, old.shape[1]
        if compiled.wanted():
            made = Seam(*np.empty((2, joints + 1, 3)), *np.empty((2, joints, 3)))
            compiled.native.seam(
                old,
                new,
                *places,
                self._parents,
                self._arms,
                poses.above,
                carrier,
                (crossing.turned, crossing.turn),
                (crossing.aside.imag, crossing.aside.real),
                pace,
                *made,
            )
            return made
        offsets = np.empty((3, joints + 1, 3))
        offsets[:, :-1] = blending.rotation_offset(old, new)
        roots = places[0].tolist(), places[1].tolist()
        stood = []
        for k, (before, after) in enumerate(zip(*roots, strict=True)):
            left, other = poses.faced(old[k], crossing.turned), poses.faced(new[k], crossing.turn)
            offsets[k, carrier] = single.as_rotvec(single.undo(left, other))
            old[k, carrier], new[k, carrier] = left, other
            stood.append((_turned(before, crossing.turned), _turned(after, crossing.turn)))
        at = np.array(stood).swapaxes(0, 1)
        offsets[:, -1] = at[1] - at[0]
        body = kinematics.forward(own.skeleton, np.concatenate([old, new]), at.reshape(6, 3)).positions
        away = body[3:] - body[:3]
        earlier, now, later = offsets
        change, moving = later - earlier, away[2] - away[0]
        velocity = change * pace
        # a rotation vector leaps where it passes half a turn; such an offset has no velocity that could be told
        velocity[np.einsum("ij,ij->i", change, change) >= 4.0] = 0.0
        apart = away[1] - now[-1]
        now[-1, 0], now[-1, 2] = crossing.aside.imag, crossing.aside.real
        return Seam(now, velocity, apart + now[-1], moving * pace)

    def leap(self, crossing: Crossing) -> complex:
        """By how much bearing feet stand elsewhere in what is entered, z + i·x, metres."""
        poses: list[tuple[Array, Vector]] = []
        borne = [1.0, 1.0]
        for moment, yaw, place in (
            (crossing.left, crossing.turned, 0j),
            (crossing.first, crossing.turn, crossing.aside),
        ):
            strand, frame = divmod(moment, self._network.repertoire.frame_count)
            image = strand % 2
            poses.append(self._poses.at(image, frame, yaw, place))
            borne = [a * b for a, b in zip(borne, self._treading.held(image, frame), strict=True)]
        return self._treading.apart(poses[0], poses[1], borne)

    def blend(self, seam: Seam, leap: complex, cut: int, frames: int, earlier: Blend | None) -> Blend:
        """The transition.

        Parameters
        ----------
        leap : what its feet have it begin beside, z + i·x, metres.
        cut : the frame at which what is entered begins.
        frames : that there are until then.
        earlier : the transition before, if it is not over by then.
        """
        stage, fps = self._stage, self._poses.own.fps
        offset, velocity, places, moving = seam
        stays = np.array([leap.imag, 0.0, leap.real])
        offset[-1] -= stays
        if earlier is not None:
            offset, velocity = absorbed(offset, velocity, earlier, (cut - earlier.cut) / fps)
        if compiled.wanted():
            early, late, shares = np.empty((3, len(offset), 1))
            latest = compiled.native.paced(
                offset,
                velocity,
                places,
                moving,
                self._which,
                self._spared,
                self._loose,
                self._slowly,
                (leap.imag, 0.0, leap.real),
                frames / fps,
                _RULES,
                early,
                late,
                shares,
            )
            return Blend(cut, cut + math.ceil(latest * fps), offset, velocity, early, late, shares, leap)
        which = stage.blended
        half = blending.window(
            _sizes(np.concatenate([offset[which], places - stays])),
            _sizes(np.concatenate([velocity[which], moving])),
            self._spared,
        ).after
        before = min(half, frames / fps)
        # what there is no time for before the cut has to be done after it
        after = min(math.sqrt(2.0 * half * half - before * before), blending.LONGEST)
        share = before * before / (before * before + after * after)
        window = blending.Window(before, after, share)
        velocity, pace = blending.at_their_own_pace(offset, velocity, window, self._loose, self._slowly)
        # what takes longer cannot have begun before it was known
        early, late = before * np.minimum(pace, 1.0), after * pace
        shares = early * early / (early * early + late * late)
        ends = cut + math.ceil(float(late.max()) * fps)
        early = np.maximum(early, _SHORTEST)
        return Blend(cut, ends, offset, velocity, early[:, None], late[:, None], shares[:, None], leap)


_met_afoot: weakref.WeakKeyDictionary[Network, tuple[NDArray[np.complex128], Array]] = weakref.WeakKeyDictionary()


def _met(network: Network, played: Repertoire) -> tuple[NDArray[np.complex128], Array]:
    """`Network.met`, of moments with their feet where they are played; made once and kept as long as the network is."""
    if network.meeting is None or played is network.repertoire or played is network.afoot:
        return network.met
    if network not in _met_afoot:
        _met_afoot[network] = afoot(network).met
    return _met_afoot[network]


def _sizes(vectors: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def _turned(place: Sequence[float], yaw: float) -> Vector:
    """A place turned about the vertical."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return cosine * place[0] + sine * place[2], place[1], -sine * place[0] + cosine * place[2]
