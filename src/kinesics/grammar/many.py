"""One motion graph of many recordings: what they share is one state, one path (§3.6.2, and §1.3 on motion graphs)."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from kinesics.body.pose import PoseSequence, check_alike
from kinesics.errors import InputError
from kinesics.grammar import assembly, reading, whole
from kinesics.grammar import moments as _moments
from kinesics.grammar.assembly import Recorded
from kinesics.grammar.cyclic import Anchor, Cyclic
from kinesics.grammar.graph import MotionGraph, Source
from kinesics.grammar.whole import Grammar
from kinesics.progress import Progress, silent
from kinesics.similarity import Weights


def read_graph(
    recordings: Sequence[PoseSequence],
    names: Sequence[str] = (),
    *,
    weights: Weights | None = None,
    grammars: Sequence[Grammar] = (),
    progress: Progress = silent,
) -> MotionGraph:
    """The motion graph of one or several recordings, in the order given.

    All are read at the lowest of their rates (at most 30 moments a second) and under one measure of nearness.

    Parameters
    ----------
    grammars : of the recordings, where they have been read already: their classes are not judged again.

    Raises
    ------
    InputError
        If there is no recording, names or grammars and recordings differ in number, or one body has the clavicle composed and
        another has it dropped.
    """
    if not recordings:
        raise InputError("Expected at least one recording.")
    named = list(names) or [f"recording {k + 1}" for k in range(len(recordings))]
    if len(named) != len(recordings):
        raise InputError(f"Expected as many names as recordings ({len(recordings)}), got {len(named)}.")
    if grammars and len(grammars) != len(recordings):
        raise InputError(f"Expected as many grammars as recordings ({len(recordings)}), got {len(grammars)}.")
    check_alike(recordings, named)
    if len(recordings) == 1:
        alone = whole.read_grammar(recordings[0], name=named[0], weights=weights, progress=progress)
        assert alone.graph is not None
        return alone.graph
    rate = min(_moments.RATE, *(p.fps for p in recordings))
    own = [_moments.from_poses(p, rate, weights=weights) for p in recordings]
    taken = [m.poses for m in own if m.poses is not None]
    joined = dataclasses.replace(
        taken[0],
        quaternions=np.concatenate([p.quaternions for p in taken]),
        yaw=np.concatenate([p.yaw for p in taken]),
        ground=np.concatenate([p.ground for p in taken]),
        yaw_undefined=None,
        fps=rate,
    )
    together = _moments.from_poses(joined, rate, weights=weights)
    # the joints between recordings are no movement, and each recording's noise is known at its own rate
    starts = np.cumsum([0, *(m.count for m in own)])
    together = dataclasses.replace(
        together, speed=np.concatenate([m.speed for m in own]), noise=max(m.noise for m in own)
    )
    cyclic: list[Cyclic] = []
    for number, (m, first) in enumerate(zip(own, starts, strict=False)):
        progress(0.3 * number / len(own), f"classes of {named[number]}")
        if m.count >= whole.LEAST_MOMENTS:
            judged = (grammars[number].overall, grammars[number].as_read) if grammars else whole.judge(m)
            cyclic += [_shifted(stretch, int(first)) for stretch in whole.cyclic_stretches(m, *judged)]
    breaks = [int(b) for b in starts[1:-1]]
    read = reading.read(together, cyclic, whole.part(progress, 0.3, 1.0), breaks=breaks)
    parts = [
        Recorded(Source(name, m.source_frames, m.source_fps), int(first), m)
        for name, m, first in zip(named, own, starts, strict=False)
    ]
    return assembly.assemble_many(read, together, parts)


def _shifted(stretch: Cyclic, by: int) -> Cyclic:
    anchors = tuple(Anchor(a.moment + by, a.role, a.mirrored, a.symmetric) for a in stretch.anchors)
    return dataclasses.replace(stretch, start=stretch.start + by, end=stretch.end + by, anchors=anchors)
