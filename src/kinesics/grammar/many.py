"""Many recordings read together: what they share is one state and one path of one motion graph (§3.6.2, and §1.3 on motion
graphs), and their phrases are of the same kinds."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from kinesics.body.pose import PoseSequence, check_alike
from kinesics.errors import InputError
from kinesics.grammar import assembly, coarse, direction, phrases, reading, whole
from kinesics.grammar import moments as _moments
from kinesics.grammar.assembly import Recorded
from kinesics.grammar.cyclic import Anchor, Cyclic
from kinesics.grammar.graph import MotionGraph, Occurrence, Source, Stay, build
from kinesics.grammar.moments import Moments
from kinesics.grammar.phrases import Phrase
from kinesics.grammar.whole import Grammar, JudgedPhrase
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
            overall, judged = (grammars[k].overall, grammars[k].as_read) if grammars else whole.judge(own[k])
            if from_end:
                overall, judged = whole.turned_round(overall, judged, m.source_frames)
            cyclic += [_shifted(stretch, first) for stretch in whole.cyclic_stretches(m, overall, judged)]
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


def match_kinds(grammars: Sequence[Grammar]) -> tuple[Grammar, ...]:
    """The grammars with one numbering of kinds: phrases of the same kind of movement have the same number in all recordings.

    Kinds of one recording stay apart. Those of different recordings are matched as phrases of one recording are, under D or D*,
    the nearest first: each is found in the other. `JudgedPhrase.mirrored` is against the first phrase of the kind in any of them.
    """
    read = [k for k, g in enumerate(grammars) if g.as_read and g.moments.poses is not None]
    if len(read) < 2:
        return tuple(grammars)
    rate = min(grammars[k].moments.fps for k in read)
    thinned: list[Moments] = []
    tiles: list[Phrase] = []
    groups: list[int] = []
    kinds: list[tuple[int, int]] = []
    for k in read:
        source = grammars[k].moments
        assert source.poses is not None
        own = _moments.from_poses(source.poses, rate, weights=source.weights)
        part = dataclasses.replace(coarse.thinned(own, coarse.RATE)[0], noise=source.noise)
        first = sum(c.count for c in thinned)
        thinned.append(part)
        share = part.count / source.source_frames
        last = 0
        for judged in grammars[k].as_read:
            end = part.count if judged.end == source.source_frames else round(judged.end * share)
            if end <= last:
                continue
            if (k, judged.kind) not in kinds:
                kinds.append((k, judged.kind))
            tiles.append(Phrase(first + last, first + end, 0, judged.still))
            groups.append(kinds.index((k, judged.kind)))
            last = end
    number, flipped = _matched(phrases.kinds_apart(_joined(thinned), tiles, groups), [k for k, _ in kinds])
    # the longest of each kind was compared: what it is to the first of its recording, that one is to it
    longest = [
        max((p for p in grammars[k].as_read if p.kind == kind), key=lambda p: p.end - p.start) for k, kind in kinds
    ]
    known = {
        which: (n, flip != long.mirrored) for which, n, flip, long in zip(kinds, number, flipped, longest, strict=True)
    }
    alone = len(kinds)
    everyone: list[JudgedPhrase] = []
    for k, g in enumerate(grammars):
        for p in g.as_read:
            n, flip = known.get((k, p.kind), (alone + sum(len(o.as_read) for o in grammars[:k]) + p.kind, False))
            everyone.append(dataclasses.replace(p, kind=n, mirrored=p.mirrored != flip))
    counted = iter(whole.in_order_of_kinds(everyone))
    return tuple(_with_kinds(g, [next(counted) for _ in g.as_read]) for g in grammars)


def _matched(apart: NDArray[np.float64], recordings: Sequence[int]) -> tuple[list[int], list[bool]]:
    """The number of what each kind is matched with, and whether it is its mirror image; the nearest are matched first.

    Parameters
    ----------
    apart : as `kinesics.grammar.phrases.kinds_apart` tells it.
    recordings : of each kind the recording; two of one are not matched.
    """
    count = len(recordings)
    number, flipped = list(range(count)), [False] * count
    first, second = np.nonzero(np.triu(apart[0] <= phrases.KIN, 1))
    for k in np.argsort(apart[0, first, second], kind="stable"):
        a, b = int(first[k]), int(second[k])
        one, other = ([m for m in range(count) if number[m] == number[x]] for x in (a, b))
        if {recordings[m] for m in one} & {recordings[m] for m in other}:
            continue
        turned = phrases.mirror_image(*apart[1:, a, b].tolist()) != (flipped[a] != flipped[b])
        for m in other:
            number[m], flipped[m] = number[a], flipped[m] != turned
    return number, flipped


def _with_kinds(grammar: Grammar, counted: Sequence[JudgedPhrase]) -> Grammar:
    """The same grammar, kinds and mirror images of its phrases being those of its phrases as they were read."""
    known = {
        was.kind: (now.kind, now.mirrored != was.mirrored) for was, now in zip(grammar.as_read, counted, strict=True)
    }
    edited = []
    for p in grammar.phrases:
        kind, flip = known[p.kind]
        edited.append(dataclasses.replace(p, kind=kind, mirrored=p.mirrored != flip))
    return dataclasses.replace(grammar, phrases=tuple(edited), as_read=tuple(counted))


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
