"""The tables of a folder: CSV with one line of headers, one row a thing, numbers to the last digit.

What the page numbers (phrases, kinds of phrases, stretches that recur) has the page's number, from 1. Frames, sources and ids of
motifs are those of `analysis.json`, from 0. `EXPLAINED` says so to whoever opens the folder.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.analysis import Analysis
from kinesics.analysis.facts import Cycle, Motif, MotifMember
from kinesics.plotting.motif_rows import ranked_stretches
from kinesics.report import words

Array = NDArray[np.float64]
_FRAMES = ("source", "frame", "time_s", "speed", "mirror_distance")


EXPLAINED: Final = """\
The tables in this folder: CSV, one line of headers, one row a thing. An empty cell: not known.

Counted from 1, as in report.html
  phrase    through all recordings; cycles.csv names the phrase of each cycle by it
  kind      of phrases: one number, one kind of movement; mirrored is 1 where the page has a star
  stretch   that recurs: the rows of "What recurs", and on after those drawn
Counted from 0, as in analysis.json
  source    the recordings in the order given; recording is the name of the file
  motif     the id of the motif
  start, end, frame
            frames of that recording; a range begins with start and ends before end

Seconds     start_s, end_s, time_s from the recording's first frame; period_s
phase       left minus right, as a fraction of the cycle, less the half by which alternating sides are apart anyway
speed       root(2 D) / dt, in 1/s: of the step that leads to the frame, the mean over a phrase

phrases.csv  one row a phrase       cycles.csv  one row a cycle
motifs.csv   one row an occurrence  frames.csv  one row a frame
"""
"""What the columns are and from what they are counted."""


def phrases(analysis: Analysis) -> str:
    """One row a phrase, numbered as on the page."""
    header = (
        "phrase source recording start end start_s end_s class group period_s confidence runner_up "
        "residual_period residual_mirror residual_glide residual_reverse residual_mirror_reverse speed_mean "
        "smoothness name kind mirrored"
    )
    names = words.source_names(analysis)
    return _csv(
        header.split(),
        (
            (
                number,
                p.source,
                names[p.source],
                p.start,
                p.end,
                p.start_s,
                p.end_s,
                p.class_,
                p.group,
                p.period_s,
                p.confidence,
                p.runner_up,
                p.residuals.period,
                p.residuals.mirror,
                p.residuals.glide,
                p.residuals.reverse,
                p.residuals.mirror_reverse,
                p.speed_mean,
                p.smoothness,
                p.name,
                None if p.kind is None else p.kind + 1,
                int(p.mirrored),
            )
            for number, p in enumerate(analysis.phrases, 1)
        ),
    )


def motifs(analysis: Analysis) -> str:
    """One row a member of a motif, with the number that the page gives to the stretch."""
    names = words.source_names(analysis)
    stretches = {
        (members[0].source, members[0].start, members[0].end): number
        for number, members in enumerate(ranked_stretches(analysis.motifs), 1)
    }

    def cells(motif: Motif, o: MotifMember) -> tuple[object, ...]:
        first, fps = motif.members[0], analysis.sources[o.source].fps
        which = (stretches[first.source, first.start, first.end], motif.id, motif.relation, motif.similarity)
        place = (o.source, names[o.source], o.start, o.end, o.start / fps, o.end / fps)
        return (*which, *place, int(o.reversed), int(o.mirrored))

    header = "stretch motif relation similarity source recording start end start_s end_s reversed mirrored"
    return _csv(header.split(), (cells(m, o) for m in analysis.motifs for o in m.members))


def cycles(analysis: Analysis) -> str:
    """One row a cycle, with the number that the page gives to its phrase, and its recording."""
    names = words.source_names(analysis)

    def cells(c: Cycle) -> tuple[object, ...]:
        source = analysis.phrases[c.phrase].source
        fps = analysis.sources[source].fps
        place = (c.phrase + 1, source, names[source], c.start, c.end, c.start / fps, c.end / fps)
        return (*place, c.period_s, c.phase, c.mirror_residual)

    header = "phrase source recording start end start_s end_s period_s phase mirror_residual"
    return _csv(header.split(), map(cells, analysis.cycles))


def frames(analysis: Analysis) -> str:
    """One row a frame: the speed of the step that led to it (the first repeats the second), and D*(a, a)."""
    return _csv(
        _FRAMES,
        (
            (k, t, t / source.fps, float(speed[t]), float(reflected[t]))
            for k, (source, speed, reflected) in enumerate(
                zip(analysis.sources, analysis.speed_curves, analysis.mirror_distance_curves, strict=True)
            )
            for t in range(len(reflected))
        ),
    )


def read_frames(text: str) -> tuple[list[Array], list[Array]]:
    """The curves of each source back from `frames`: speeds and D*(a, a), each of shape (frames,).

    Raises
    ------
    ValueError
        If the table is not one that `frames` makes.
    """
    rows = csv.reader(io.StringIO(text))
    if tuple(next(rows, ())) != _FRAMES:
        raise ValueError(f"expected the columns {', '.join(_FRAMES)}.")
    speeds: list[list[float]] = []
    reflected: list[list[float]] = []
    for row in rows:
        if len(row) != len(_FRAMES):
            raise ValueError(f"expected {len(_FRAMES)} columns in every row, got {len(row)}.")
        source = int(row[0])
        while len(speeds) <= source:
            speeds.append([])
            reflected.append([])
        speeds[source].append(float(row[3]))
        reflected[source].append(float(row[4]))
    return [np.array(s) for s in speeds], [np.array(r) for r in reflected]


def _csv(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return stream.getvalue()
