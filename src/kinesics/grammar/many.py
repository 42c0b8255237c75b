"""One motion graph of many recordings: what they share is one state, one path (§3.6.2, and §1.3 on motion graphs)."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable, Sequence
from typing import TypeVar

import numpy as np

from kinesics.body.pose import PoseSequence, check_alike
from kinesics.errors import InputError
from kinesics.grammar import assembly, direction, reading, whole
from kinesics.grammar import moments as _moments
from kinesics.grammar.assembly import Recorded
from kinesics.grammar.cyclic import Anchor, Cyclic
from kinesics.grammar.graph import MotionGraph, Occurrence, Source, Stay, build
from kinesics.grammar.moments import Moments
from kinesics.grammar.whole import Grammar
from kinesics.progress import Progress, silent
from kinesics.similarity import Weights

_Range = TypeVar("_Range", Stay, Occurrence)


def read_graph(
    recordings: Sequence[PoseSequence],
    names: Sequence[str] = (),
    *,
    weights: Weights | None = None,
    grammars: Sequence[Grammar] = (),
    progress: Progress = silent,
) -> MotionGraph:
    """The motion graph of one or several recordings, in the order given.

    All are read at the lowest of their rates (at most 30 moments a second) and under one measure of nearness. In which order
    they are given decides only what is called what.

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
    # whoever begins elsewhere decides close calls another way: the recordings say themselves in which order they are read
    from_end = sum(m.count if m.from_end else -m.count for m in own) > 0
    order = sorted(range(len(own)), key=lambda k: (-own[k].count, _digest(own[k])))
    seen = [direction.reversed_moments(own[k]) if from_end else own[k] for k in order]
    together = _joined(seen)
    starts = [int(x) for x in np.cumsum([0, *(m.count for m in seen)])]
    cyclic: list[Cyclic] = []
    for number, (k, m, first) in enumerate(zip(order, seen, starts, strict=False)):
        progress(0.3 * number / len(own), f"classes of {named[k]}")
        if m.count >= whole.LEAST_MOMENTS:
            overall, phrases = (grammars[k].overall, grammars[k].as_read) if grammars else whole.judge(own[k])
            if from_end:
                overall, phrases = whole.turned_round(overall, phrases, m.source_frames)
            cyclic += [_shifted(stretch, first) for stretch in whole.cyclic_stretches(m, overall, phrases)]
    read = reading.read(together, cyclic, whole.part(progress, 0.3, 1.0), breaks=starts[1:-1])
    if from_end:
        read = direction.reversed_reading(read, together.count)
        order, seen = order[::-1], [own[k] for k in order[::-1]]
        together = _joined(seen)
        starts = [int(x) for x in np.cumsum([0, *(m.count for m in seen)])]
    parts = [
        Recorded(Source(named[k], m.source_frames, m.source_fps), first, m)
        for k, m, first in zip(order, seen, starts, strict=False)
    ]
    return _in_order_given(assembly.assemble_many(read, together, parts), order)


def _joined(recordings: Sequence[Moments]) -> Moments:
    """The moments of all recordings, one after the other."""
    taken = [m.poses for m in recordings if m.poses is not None]
    poses = dataclasses.replace(
        taken[0],
        quaternions=np.concatenate([p.quaternions for p in taken]),
        yaw=np.concatenate([p.yaw for p in taken]),
        ground=np.concatenate([p.ground for p in taken]),
        yaw_undefined=None,
        fps=recordings[0].fps,
    )
    together = _moments.from_poses(poses, poses.fps, weights=recordings[0].weights)
    # the joints between recordings are no movement, and each recording's noise is known at its own rate
    return dataclasses.replace(
        together, speed=np.concatenate([m.speed for m in recordings]), noise=max(m.noise for m in recordings)
    )


def _digest(moments: Moments) -> bytes:
    """The same for the same movement only: it puts recordings of one length in an order."""
    assert moments.poses is not None
    return hashlib.sha256(np.ascontiguousarray(moments.poses.quaternions).tobytes()).digest()


def _in_order_given(graph: MotionGraph, order: Sequence[int]) -> MotionGraph:
    """The graph of sources that were read in another order; ``order[k]`` is the given number of source k."""
    sources = [graph.sources[k] for k in np.argsort(order)]
    states = [
        dataclasses.replace(s, stays=_sorted(dataclasses.replace(stay, source=order[stay.source]) for stay in s.stays))
        for s in graph.states
    ]
    paths = [
        dataclasses.replace(
            p, occurrences=_sorted(dataclasses.replace(o, source=order[o.source]) for o in p.occurrences)
        )
        for p in graph.paths
    ]
    return build(states, paths, sources)


def _sorted(ranges: Iterable[_Range]) -> tuple[_Range, ...]:
    return tuple(sorted(ranges, key=lambda r: (r.source, r.start)))


def _shifted(stretch: Cyclic, by: int) -> Cyclic:
    anchors = tuple(Anchor(a.moment + by, a.role, a.mirrored, a.symmetric) for a in stretch.anchors)
    return dataclasses.replace(stretch, start=stretch.start + by, end=stretch.end + by, anchors=anchors)
