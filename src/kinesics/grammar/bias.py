"""The constant difference of left and right: of a body, of a rig, of how markers were placed.

In some recordings one forearm is turned by 20 to 40 degrees against the mirror image of the other throughout, and hands meet to
centimetres all the same. It is a finding about the recording, not about the movement: it is estimated, reported, and kept apart
from the movement's class.

Whatever symmetry with a mirror in it a movement has (at once, after half a period, backwards), over the whole of it the average
of a left link is the mirror image of the average of the right one. So the bias of a pair is the rotation between the two
averages, and needs no period and no alignment. Axial links are their own partners: theirs is half the rotation between the
average and its mirror image, a lean or a turn held all the time. The links of a neck or a back may zig-zag, as fits of markers
make them do: how the body is held is what the whole chain adds up to.

A difference beyond `LARGEST_DEGREES` is no bias of a rig but a posture (one arm up, the other hanging): it stays with the movement.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import pose
from kinesics.geometry import quaternion
from kinesics.grammar.moments import Moments
from kinesics.similarity import symmetry_residual
from kinesics.vocabulary import LINK_PARENTS, LINKS, MIRROR_LINKS

Array = NDArray[np.float64]

LARGEST_DEGREES: Final = 50.0
"""Rigs and marker sets have been seen to differ by up to 42°."""
CHAINS: Final = {"trunk": ("lowerback", "upperback", "thorax"), "head": ("lowerneck", "upperneck", "head")}
"""Of axial links: from the pelvis to the chest, and from the chest to the head."""
_DEFINITE: Final = 0.3
"""Least gap between the two largest eigenvalues of the mean of q qᵀ: a link that turns all the way round has no average."""


@dataclass(frozen=True, eq=False)
class Bias:
    """The constant difference of left and right over a stretch."""

    rotations: Array
    """What each link is turned by against its ideally symmetric self, half of the difference on either side, shape (15, 4)."""
    degrees: dict[str, float]
    """Difference of each pair of limbs; lean or turn to one side of each axial link. Keys are names of links, of limbs without
    their side."""
    kept: tuple[str, ...]
    """Those whose difference is a posture rather than a bias, and stays with the movement."""
    leans: dict[str, float]
    """Degrees by which the chest against the pelvis ("trunk") and the head against the chest ("head") lean or are turned to one
    side; without those of which a link is kept."""

    @property
    def largest_degrees(self) -> float:
        """The largest difference or lean of a link that counts as a bias."""
        return max((v for k, v in self.degrees.items() if k not in self.kept), default=0.0)

    @property
    def distance(self) -> float:
        """D that the bias alone puts between a body and its mirror image."""
        w = np.abs(self.rotations[:, 0])
        return float(np.mean(1.0 - (2.0 * w * w - 1.0)))  # both halves: cos of the whole half-angle


def estimate(moments: Moments, start: int = 0, end: int | None = None) -> Bias | None:
    """The bias over a stretch; None where moments are not made of poses.

    Take a whole number of periods, where there are periods.
    """
    start, end = moments.stretch(start, end)
    if moments.poses is None:
        return None
    q = moments.poses.quaternions[start:end]
    means, definite = _means(q)
    images, _ = _means(pose.mirror(q))
    rotations = quaternion.identity((len(LINKS),))
    degrees: dict[str, float] = {}
    turns: dict[int, Array] = {}
    for link, partner in enumerate(MIRROR_LINKS):
        if link == 0 or partner < link:  # the root's tilt has no frame of its own to be turned in
            continue
        # means[link] = images[link]·turn, and of the partner the mirror image of it
        turn = quaternion.canonical(quaternion.multiply(quaternion.conjugate(images[link]), means[link]))
        angle = _degrees(turn)
        # a lean to the left is mirrored to one to the right: they are apart by twice of it
        degrees[_name(link)] = angle if partner != link else 0.5 * angle
        if definite[link] and definite[partner] and angle <= LARGEST_DEGREES:
            turns[link] = turn
    # where the upper link of a limb is in another posture, the lower one is too
    turns = {link: t for link, t in turns.items() if MIRROR_LINKS[link] == link or _whole_limb(link) <= turns.keys()}
    for link, turn in turns.items():
        half = quaternion.power(turn[None], np.array([0.5]))[0]
        rotations[link] = half
        if (partner := MIRROR_LINKS[link]) != link:
            rotations[partner] = quaternion.mirror(quaternion.conjugate(half))
    kept = tuple(name for name in degrees if name not in {_name(link) for link in turns})
    leans = {name: _lean(q, chain) for name, chain in CHAINS.items() if not set(chain) & set(kept)}
    return Bias(rotations, degrees, kept, leans)


def _lean(q: Array, chain: tuple[str, ...]) -> float:
    """Degrees by which the last link of a chain leans or is turned to one side against what the first one hangs on."""
    held = q[:, [LINKS.index(link) for link in chain]]
    total = held[:, 0]
    for k in range(1, len(chain)):
        total = quaternion.multiply(total, held[:, k])
    (mean,), _ = _means(total[:, None])
    return 0.5 * _degrees(quaternion.multiply(quaternion.conjugate(quaternion.mirror(mean)), mean))


def _degrees(turn: Array) -> float:
    """The angle of one rotation."""
    return float(np.rad2deg(2.0 * np.arccos(min(1.0, abs(float(turn[0]))))))


def _name(link: int) -> str:
    return LINKS[link].removeprefix("left_")


def _whole_limb(link: int) -> set[int]:
    """The two links of a limb: femur and tibia, humerus and radius."""
    upper = link if LINKS[link].endswith(("femur", "humerus")) else LINK_PARENTS[link]
    return {upper, LINK_PARENTS.index(upper)}


def without(moments: Moments, bias: Bias) -> Moments:
    """The moments of the body without its bias: the same D, another D*."""
    poses = moments.poses
    if poses is None:
        return moments
    q = quaternion.multiply(poses.quaternions, quaternion.conjugate(bias.rotations))
    return dataclasses.replace(
        moments, poses=dataclasses.replace(poses, quaternions=q), symmetry=symmetry_residual(q, moments.weights)
    )


def _means(q: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The average rotation of each link, shape (links, 4), and whether there is one."""
    values, vectors = np.linalg.eigh(np.einsum("fli,flj->lij", q, q) / len(q))
    return vectors[..., -1], values[:, -1] - values[:, -2] > _DEFINITE
