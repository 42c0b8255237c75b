"""Limbs that pass through each other on another body than their own."""

from __future__ import annotations

from typing import Final

import numpy as np

from kinesics.body.limits import DEPTH_TOLERANCE, Capsules
from kinesics.body.motion import Motion
from kinesics.body.skeleton import Skeleton

DEEPER: Final = 0.02
"""Metres by which limbs pass deeper into each other on another body than on their own, before it is said."""
LOOKS: Final = 12.0
"""Moments a second at which that is looked for."""


def through_each_other(name: str, motion: Motion, out: Motion) -> list[str]:
    """That limbs of a body that was given a movement pass through each other, deeper than those of its own did."""
    if _same_bones(motion.skeleton, out.skeleton):
        return []
    # pairs that interpenetrate in the T-pose of the one body may not in that of the other: of its own all are asked for
    own, here = _deepest(motion, np.inf), _deepest(out, DEPTH_TOLERANCE)
    known = {pair: depth for pair, depth in here.items() if depth > max(DEPTH_TOLERANCE, own[pair] + DEEPER)}
    if not known:
        return []
    pair = max(known, key=lambda p: known[p])
    before = max(own[pair], 0.0)
    told = f"{100.0 * before:.0f} cm" if before >= 0.005 else "not at all"
    return [
        f"{name}: on this body {_said(pair)} pass up to {100.0 * known[pair]:.0f} cm into each other, {told} on its own; "
        "perform on a body more like it in build"
    ]


def _same_bones(a: Skeleton, b: Skeleton) -> bool:
    return a.same_tree(b) and np.array_equal(a.offsets[1:], b.offsets[1:])


def _deepest(motion: Motion, tolerance: float) -> dict[tuple[str, str], float]:
    """By how many metres each two limbs pass into each other at most, −∞ if never; a few frames a second are looked at."""
    some = motion[:: max(1, round(motion.fps / LOOKS))]
    capsules = Capsules.of(some, tolerance=tolerance)
    depth = capsules.depths(some.positions(), some.global_rotations()).max(axis=0).tolist()
    return {(capsules.names[a], capsules.names[b]): d for (a, b), d in zip(capsules.pairs, depth, strict=True)}


def _said(pair: tuple[str, str]) -> str:
    """As in "the thighs" or "left thigh and right shank"."""
    words = {"femur": "thigh", "tibia": "shank", "humerus": "upper arm", "radius": "forearm"}
    first, second = (" ".join(words.get(word, word) for word in limb.split()) for limb in pair)
    if first.partition(" ")[2] == second.partition(" ")[2]:
        return f"the {first.partition(' ')[2]}s"
    return f"{first} and {second}"
