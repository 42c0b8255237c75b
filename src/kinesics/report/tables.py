"""The tables of a folder: CSV with one line of headers, one row a thing, numbers to the last digit."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from kinesics.analysis import Analysis

Array = NDArray[np.float64]
_FRAMES = ("source", "frame", "time_s", "speed", "mirror_distance")


def phrases(analysis: Analysis) -> str:
    """One row a phrase."""
    header = (
        "source start end start_s end_s class group period_s confidence runner_up "
        "residual_period residual_mirror residual_glide residual_reverse residual_mirror_reverse speed_mean "
        "smoothness name kind mirrored"
    )
    return _csv(
        header.split(),
        (
            (
                p.source,
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
                p.kind,
                int(p.mirrored),
            )
            for p in analysis.phrases
        ),
    )


def motifs(analysis: Analysis) -> str:
    """One row a member of a motif."""
    return _csv(
        ("motif", "relation", "similarity", "source", "start", "end", "reversed", "mirrored"),
        (
            (m.id, m.relation, m.similarity, o.source, o.start, o.end, int(o.reversed), int(o.mirrored))
            for m in analysis.motifs
            for o in m.members
        ),
    )


def cycles(analysis: Analysis) -> str:
    """One row a cycle."""
    return _csv(
        ("phrase", "start", "end", "period_s", "phase", "mirror_residual"),
        ((c.phrase, c.start, c.end, c.period_s, c.phase, c.mirror_residual) for c in analysis.cycles),
    )


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
