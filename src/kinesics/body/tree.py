"""Ways through the tree of joints."""

from __future__ import annotations

import numpy as np

from kinesics.body.skeleton import Skeleton


def ancestors(skeleton: Skeleton, j: int) -> list[int]:
    """What joint j hangs on, from its parent to the root."""
    out = []
    while (j := skeleton.parents[j]) >= 0:
        out.append(j)
    return out


def meet(skeleton: Skeleton, a: int, b: int) -> int:
    """The lowest joint that both hang on (or are)."""
    line = [a, *ancestors(skeleton, a)]
    other = {b, *ancestors(skeleton, b)}
    return next(j for j in line if j in other)


def between(skeleton: Skeleton, top: int, bottom: int) -> tuple[int, ...] | None:
    """Joints strictly between ``top`` and its descendant ``bottom``, from the top; None if it is not one."""
    if top == bottom:
        return ()
    line = ancestors(skeleton, bottom)
    if top not in line:
        return None
    return tuple(reversed(line[: line.index(top)]))


def reaches(skeleton: Skeleton) -> list[float]:
    """For each joint the length of the longest way down from it, its own offset left out; in the skeleton's unit."""
    out = [0.0] * skeleton.joint_count
    for site in skeleton.end_sites:
        out[site.parent] = max(out[site.parent], float(np.linalg.norm(site.offset)))
    for j in range(skeleton.joint_count - 1, 0, -1):
        parent = skeleton.parents[j]
        out[parent] = max(out[parent], float(np.linalg.norm(skeleton.offsets[j])) + out[j])
    return out
