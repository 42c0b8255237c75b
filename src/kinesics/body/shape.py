"""A human body found by the shape of its skeleton, whatever its joints are called.

Two pairs of equal branches: the longer, lower pair are legs, the other arms; what goes on upwards past the arms is the
head. Which side is left follows from which way the feet (else the knees) point: that needs a clip.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.skeleton import Skeleton
from kinesics.body.tree import ancestors, reaches

Array = NDArray[np.float64]
Limb = tuple[int, int, int | None]
"""Upper, lower and end joint."""

_TOLD: Final = 0.01
"""Of a leg's length: toes and knees that point forward by less do not tell left from right."""


def by_shape(skeleton: Skeleton, positions: Array) -> dict[str, int] | None:
    """Find a human body by its shape alone, whatever the names; None where there is none.

    Two pairs of equal branches: the longer, lower pair are legs, the other arms; what goes on upwards past the arms is the
    head. Which side is left follows from which way the feet (else the knees) point.
    """
    reach = reaches(skeleton)
    paths = _branch_pairs(skeleton, reach)
    best: tuple[float, dict[str, int]] | None = None
    for at_legs, legs in paths:
        for at_arms, arms in paths:
            above = ancestors(skeleton, at_arms)
            if at_legs not in above or any(leg in (at_arms, *above) for leg in legs):
                continue
            leg_reach, arm_reach = reach[legs[0]], reach[arms[0]]
            if not 0.35 < arm_reach / max(leg_reach, 1e-9) < 1.6:
                continue
            head = _head_above(skeleton, reach, at_arms, arms)
            if head is None:
                continue
            limbs = [_limb_joints(skeleton, reach, branch) for branch in (*legs, *arms)]
            if any(limb is None for limb in limbs):
                continue
            leg_p, leg_q, arm_p, arm_q = (limb for limb in limbs if limb is not None)
            if not (_equal_bones(skeleton, leg_p, leg_q) and _equal_bones(skeleton, arm_p, arm_q)):
                continue
            if not _upright(positions, leg_p, leg_q, at_legs, at_arms):
                continue
            first_is_left = _first_is_left(skeleton, positions, leg_p, leg_q, at_legs, at_arms)
            arm_first_left = _same_side(positions, leg_p, leg_q, arm_p, arm_q)
            if first_is_left is None or arm_first_left is None:
                continue
            if not first_is_left:
                leg_p, leg_q = leg_q, leg_p
                arm_first_left = not arm_first_left
            if not arm_first_left:
                arm_p, arm_q = arm_q, arm_p
            found = {"head": head, "pelvis": at_legs, "chest": at_arms}
            for side, leg, arm in (("left", leg_p, arm_p), ("right", leg_q, arm_q)):
                found[f"{side}_femur"], found[f"{side}_tibia"] = leg[0], leg[1]
                found[f"{side}_humerus"], found[f"{side}_radius"] = arm[0], arm[1]
                if leg[2] is not None:
                    found[f"{side}_foot"] = leg[2]
                if arm[2] is not None:
                    found[f"{side}_hand"] = arm[2]
            score = leg_reach + arm_reach
            if best is None or score > best[0]:
                best = (score, found)
    return None if best is None else best[1]


def _branch_pairs(skeleton: Skeleton, reach: Sequence[float]) -> list[tuple[int, tuple[int, int]]]:
    """Pairs of branches of (nearly) equal reach that leave the same joint."""
    return [
        (j, (a, b))
        for j, children in enumerate(skeleton.children)
        for a, b in combinations(children, 2)
        if min(reach[a], reach[b]) > 0 and abs(reach[a] - reach[b]) < 0.12 * max(reach[a], reach[b])
    ]


def _limb_joints(skeleton: Skeleton, reach: Sequence[float], branch: int) -> Limb | None:
    """Upper, lower and end joint of a limb: the two longest bones one after the other along its longest way."""
    way = [branch]
    while skeleton.children[way[-1]]:
        way.append(
            max(
                skeleton.children[way[-1]],
                key=lambda c: float(np.linalg.norm(skeleton.offsets[c])) + reach[c],
            )
        )
    lengths = [float(np.linalg.norm(skeleton.offsets[c])) for c in way[1:]]
    # the last two long bones that end in joints: collar bones and hip joints come before them, hands and feet after
    long = 0.18 * sum(lengths)
    pairs = [k for k in range(len(way) - 2) if min(lengths[k], lengths[k + 1]) >= long]
    if pairs:
        upper = pairs[-1]
        return way[upper], way[upper + 1], way[upper + 2]
    tip = [float(np.linalg.norm(s.offset)) for s in skeleton.end_sites if s.parent == way[-1]]
    lengths.append(max(tip, default=0.0))
    if len(way) < 2:
        return None
    upper = max(range(len(way) - 1), key=lambda k: lengths[k] + lengths[k + 1])
    if lengths[upper] <= 0 or lengths[upper + 1] <= 0:
        return None
    end = way[upper + 2] if upper + 2 < len(way) else None
    return way[upper], way[upper + 1], end


def _equal_bones(skeleton: Skeleton, p: Limb, q: Limb) -> bool:
    """Whether the upper bones of two limbs are as long as each other, to a seventh: bodies are no more exact."""
    a, b = (float(np.linalg.norm(skeleton.offsets[limb[1]])) for limb in (p, q))
    return abs(a - b) < max(a, b) / 7


def _head_above(skeleton: Skeleton, reach: Sequence[float], chest: int, arms: tuple[int, int]) -> int | None:
    others = [c for c in skeleton.children[chest] if c not in arms]
    if not others:
        return None
    way = [max(others, key=lambda c: reach[c])]
    while skeleton.children[way[-1]]:
        way.append(skeleton.children[way[-1]][0])
    # a lone leaf without a tip is the crown; the head is the joint that carries it
    has_tip = any(s.parent == way[-1] for s in skeleton.end_sites)
    return way[-1] if has_tip or len(way) == 1 else way[-2]


def _upright(positions: Array, p: Limb, q: Limb, hip: int, chest: int) -> bool:
    """Whether trunk and legs point opposite ways most of the time, as in people and not in four-footed animals."""
    trunk = positions[:, chest] - positions[:, hip]
    cosines = []
    for limb in (p, q):
        end = limb[2] if limb[2] is not None else limb[1]
        leg = positions[:, end] - positions[:, limb[0]]
        norm = np.linalg.norm(leg, axis=1) * np.linalg.norm(trunk, axis=1)
        cosines.append(np.sum(leg * trunk, axis=1) / np.maximum(norm, 1e-12))
    return bool(np.median(np.mean(cosines, axis=0)) < -0.5)


def _first_is_left(
    skeleton: Skeleton,
    positions: Array,
    p: Limb,
    q: Limb,
    hip: int,
    chest: int,
) -> bool | None:
    """Whether the first leg is the left one, by which way toes point and knees bend; None where neither tells."""
    up = positions[:, chest] - positions[:, hip]
    lateral = positions[:, p[0]] - positions[:, q[0]]
    forward_if_left = np.cross(lateral, up)
    forward_if_left /= np.maximum(np.linalg.norm(forward_if_left, axis=1, keepdims=True), 1e-12)
    told = 0.0
    for limb in (p, q):
        if limb[2] is None:
            continue
        leg = np.linalg.norm(positions[:, limb[0]] - positions[:, limb[2]], axis=1).max() + 1e-12
        # knees bend backwards: the knee lies ahead of the line from hip to ankle
        middle = (positions[:, limb[0]] + positions[:, limb[2]]) / 2
        told += float(np.mean(np.sum((positions[:, limb[1]] - middle) * forward_if_left, axis=1)) / leg)
        toes = skeleton.children[limb[2]]
        if toes:
            toe = positions[:, toes[0]] - positions[:, limb[2]]
            told += float(np.mean(np.sum(toe * forward_if_left, axis=1)) / leg)
    return None if abs(told) < _TOLD else told > 0


def _same_side(
    positions: Array,
    leg_p: Limb,
    leg_q: Limb,
    arm_p: Limb,
    arm_q: Limb,
) -> bool | None:
    """Whether the first arm is on the side of the first leg; None where shoulders and elbows do not tell."""
    hips = positions[:, leg_p[0]] - positions[:, leg_q[0]]
    across = sum(positions[:, arm_p[k]] - positions[:, arm_q[k]] for k in (0, 1))
    size = np.linalg.norm(hips, axis=1) * np.linalg.norm(across, axis=1)
    cosine = float(np.mean(np.sum(hips * across, axis=1) / np.maximum(size, 1e-12)))
    return None if abs(cosine) < 0.3 else cosine > 0
