"""The performer's answers as motion graphs: where the tests of the grammar get graphs whose timelines are known."""

from __future__ import annotations

from kinesics.grammar.graph import MotionGraph, Occurrence, Path, Source, State, Stay
from kinesics.performer import Truth


def graph_of(truth: Truth, name: str = "") -> MotionGraph:
    """The graph of a performance with the labels of its score."""
    states = {s.label: k for k, s in enumerate(truth.states)}
    paths = {p.label: k for k, p in enumerate(truth.paths)}

    def image(label: str, mirror_of: str | None, ids: dict[str, int]) -> int | None:
        return None if mirror_of in (None, label) else ids[mirror_of]

    return MotionGraph(
        tuple(
            State(
                states[s.label],
                s.label,
                s.symmetric,
                image(s.label, s.mirror_of, states),
                tuple(Stay(0, r.start, r.end) for r in s.stays),
            )
            for s in truth.states
        ),
        tuple(
            Path(
                paths[p.label],
                p.label,
                states[p.from_],
                states[p.to],
                int(p.label.rstrip(")*").rpartition("_")[2]),
                p.reversible,
                image(p.label, p.mirror_of, paths),
                occurrences=tuple(Occurrence(0, o.start, o.end, o.reversed, o.complete) for o in p.occurrences),
                symmetric=p.mirror_of == p.label,
            )
            for p in truth.paths
        ),
        (Source(name or truth.movement, truth.frame_count, truth.fps),),
    )
