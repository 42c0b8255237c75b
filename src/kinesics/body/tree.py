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


def reach(skeleton: Skeleton, j: int) -> float:
    """Length of the longest way down from joint j, its own offset left out."""
    tips = [float(np.linalg.norm(s.offset)) for s in skeleton.end_sites if s.parent == j]
    ways = [float(np.linalg.norm(skeleton.offsets[c])) + reach(skeleton, c) for c in skeleton.children[j]]
    return max([0.0, *tips, *ways])
