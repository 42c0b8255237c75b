"""How two moments meet at a cut: by the feet that bear on both sides rather than by the pelvis ([Schultz2012] §4.4).

What is entered is turned about the vertical and shifted over the floor, so that bearing feet come to stand where they stood
(Kovar, Gleicher & Pighin 2002, §3.3, align whole point clouds): the least sum of squares over heel, ball and tip of both soles,
each with what it bears on both sides as its weight. Place and heading of the pelvis weigh little while both feet bear, more
while one does, and alone decide in flight. What the pelvis is then off is blended away as everything else is.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import contacts as _contacts
from kinesics.body import kinematics
from kinesics.body.contacts import Floor, Soles
from kinesics.body.motion import Motion
from kinesics.synthesis.repertoire import Repertoire

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SECONDS: Final = 0.14
"""Around the cut, over which it is told how much a foot bears."""
BEARING: Final = 0.008
"""Metres: a point of the sole this much above the lowest bears e times less."""
PELVIS: Final = 0.02
"""What the place of the pelvis weighs; a foot that bears weighs 1."""
HEADING: Final = 0.02
"""m²: what its heading does."""
_SURE: Final = 0.999
"""Share of both that is gone while both feet bear: who stands for long would else turn a little with every round."""


class Meeting(NamedTuple):
    """Where the root of what is entered lies, seen from where that of what is left would have been."""

    place: Array
    """To the left and ahead, metres, shape (n, 2)."""
    turn: Array
    """By which it faces more to the left, radians, shape (n,)."""


def soles_of(repertoire: Repertoire) -> Soles:
    """The soles of the performing body, found once in all recordings together and kept as long as the repertoire is."""
    return repertoire.kept(_found)


def same_soles(body: Repertoire, other: Repertoire) -> None:
    """Say that the body of a repertoire has the soles of that of another."""
    body.keep(_found, soles_of(other))


def _found(repertoire: Repertoire) -> Soles:
    whole = Motion(repertoire.skeleton, repertoire.rotations[0], repertoire.root_positions[0], repertoire.fps)
    return _contacts.contacts(whole, ground=Floor(0.0)).soles_as_they_bear(whole)


def soles_beneath(repertoire: Repertoire, moments: Indices) -> Array:
    """Points of the soles as seen from the root: left, up from the floor, ahead; metres, shape (n, 2, 3, 3)."""
    soles = soles_of(repertoire)
    roots = repertoire.roots_of(moments)
    known = kinematics.forward(repertoire.skeleton, repertoire.rotations_of(moments), roots)
    places = soles.place(known.positions, known.rotations)
    yaw = repertoire.yaw_of(moments)[:, None, None]
    x, z = places[..., 0] - roots[:, None, None, 0], places[..., 2] - roots[:, None, None, 2]
    sine, cosine = np.sin(yaw), np.cos(yaw)
    return np.stack([cosine * x - sine * z, places[..., 1], sine * x + cosine * z], axis=-1)


def meetings(repertoire: Repertoire, left: Indices, entered: Indices) -> Meeting:
    """How moments that are entered meet those with which the recordings left would have gone on, shape (n,) each."""
    # a mirrored seam is the mirror image of the same seam as recorded, to the last digit; of bodies that were planted one by one,
    # whose legs may differ in length, each is met as it is played
    image = repertoire.is_mirrored(left) & (repertoire.turned is None)
    here, there = _mirrored(repertoire, left, image), _mirrored(repertoire, entered, image)
    used, at = np.unique(np.concatenate([here, there]), return_inverse=True)
    points, borne = soles_beneath(repertoire, used), _borne(repertoire, used)
    here, there = at[: len(left)], at[len(left) :]
    height = 0.5 * (points[here, ..., 1] + points[there, ..., 1])
    share = np.exp(-(height - height.min(axis=-1, keepdims=True)) / BEARING)
    feet = borne[here] * borne[there]
    weight = (feet[..., None] * share / share.sum(axis=-1, keepdims=True)).reshape(-1, 6)
    # on the floor a place is one complex number, ahead + i·left: a turn to the left by ψ is a product with e^{iψ}
    a, b = ((points[k][..., 2] + 1j * points[k][..., 0]).reshape(-1, 6) for k in (here, there))
    loose = 1.0 - _SURE * feet.min(axis=1)
    pelvis = PELVIS * loose
    total = weight.sum(axis=1) + pelvis
    # the pelvis lies at 0 on both sides
    middle_a, middle_b = (weight * a).sum(axis=1) / total, (weight * b).sum(axis=1) / total
    product = (weight * (a - middle_a[:, None]) * (b - middle_b[:, None]).conj()).sum(axis=1)
    product += pelvis * middle_a * middle_b.conj() + HEADING * loose
    turn = np.angle(product)
    place = middle_a - np.exp(1j * turn) * middle_b
    side = np.where(image, -1.0, 1.0)
    return Meeting(np.stack([side * place.imag, place.real], axis=-1), side * turn)


def _mirrored(repertoire: Repertoire, moments: Indices, image: NDArray[np.bool_]) -> Indices:
    """The moments, those of ``image`` mirrored."""
    way = np.where(repertoire.is_mirrored(moments), -1, 1)
    return np.where(image, moments + way * repertoire.frame_count, moments)


def _borne(repertoire: Repertoire, moments: Indices) -> Array:
    """Share of the time around each moment that each foot bears, shape (n, 2)."""
    reach = max(1, round(0.5 * SECONDS * repertoire.fps))
    frame, strand = repertoire.split(moments)
    recording = repertoire.recording_of(frame)
    standing = np.cumsum(np.concatenate([np.zeros((1, 2)), repertoire.contacts[0]]), axis=0)
    low = np.maximum(frame - reach, repertoire.starts[recording])
    high = np.minimum(frame + reach + 1, repertoire.starts[recording + 1])
    share = (standing[high] - standing[low]) / (high - low)[:, None]
    return np.asarray(np.where((strand % 2 == 1)[:, None], share[:, ::-1], share))
