"""How tall a body is, told by its bones."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body import anatomy
from kinesics.body.motion import Motion
from kinesics.errors import SkeletonError

Array = NDArray[np.float64]

LEG_TO_STATURE: Final = 0.491


def estimated_stature(motion: Motion) -> float | None:
    """Standing height in metres, from the length of the legs (Drillis & Contini 1966); None where there are none.

    Where the body is not understood: from the longest way over the skeleton, which is from a toe to a fingertip, about
    1.3 statures.
    """
    skeleton = motion.skeleton
    try:
        body = anatomy.resolve(motion)
    except SkeletonError:
        return _longest_way(motion) / 1.3 or None
    leg = 0.0
    for side in ("left", "right"):
        tibia, foot = getattr(body, f"{side}_tibia"), getattr(body, f"{side}_foot")
        if tibia is None:
            return None
        leg += float(np.linalg.norm(skeleton.offsets[tibia])) / 2.0
        if foot is not None:
            leg += float(np.linalg.norm(skeleton.offsets[foot])) / 2.0
        else:
            sites = [np.linalg.norm(s.offset) for s in skeleton.end_sites if s.parent == tibia]
            leg += float(max(sites, default=0.0)) / 2.0
    return leg / LEG_TO_STATURE or None


def _longest_way(motion: Motion) -> float:
    skeleton = motion.skeleton
    reach = reaches(motion)
    # the longest way turns back at some joint: its two longest branches
    branches: list[list[float]] = [[0.0, 0.0] for _ in skeleton.joint_names]
    for j, parent in enumerate(skeleton.parents[1:], start=1):
        branches[parent].append(float(reach[j] + np.linalg.norm(skeleton.offsets[j])))
    for site in skeleton.end_sites:
        branches[site.parent].append(float(np.linalg.norm(site.offset)))
    return max(sum(sorted(b)[-2:]) for b in branches)


def reaches(motion: Motion) -> Array:
    """From each joint to the farthest point that hangs on it, along the bones, metres, shape (joints,)."""
    skeleton = motion.skeleton
    out = np.zeros(skeleton.joint_count)
    for site in skeleton.end_sites:
        out[site.parent] = max(out[site.parent], float(np.linalg.norm(site.offset)))
    for j in range(skeleton.joint_count - 1, 0, -1):
        parent = skeleton.parents[j]
        out[parent] = max(out[parent], out[j] + float(np.linalg.norm(skeleton.offsets[j])))
    return out
