"""What a reader can know of a performance: its graph with labels given anew."""

from __future__ import annotations

from kinesics.grammar.graph import MotionGraph, Occurrence, Path, Source, State, Stay, build
from kinesics.performer import TruePath, Truth


def performed(truth: Truth) -> MotionGraph:
    """The graph that a reader can know: labels given anew, reversible what was traversed both ways, itself or mirrored."""

    states = {s.label: k for k, s in enumerate(truth.states)}
    paths = {p.label: k for k, p in enumerate(truth.paths)}

    def images(pairs: dict[str, str | None]) -> dict[str, str]:
        out = {a: b for a, b in pairs.items() if b is not None and b in pairs}
        return out | {b: a for a, b in out.items() if a != b}

    of_state = images({s.label: s.mirror_of for s in truth.states})
    of_path = images({p.label: p.mirror_of for p in truth.paths})
    ways = {p.label: {o.reversed for o in p.occurrences} for p in truth.paths}
    both = {label: len(ways[label] | ways[of_path.get(label, label)]) == 2 for label in ways}

    def path(p: TruePath) -> Path:
        turned = not both[p.label] and True in ways[p.label]
        ends = (p.to, p.from_) if turned else (p.from_, p.to)
        image = of_path.get(p.label)
        return Path(
            paths[p.label],
            from_=states[ends[0]],
            to=states[ends[1]],
            reversible=both[p.label],
            mirror_of=paths[image] if image not in (None, p.label) else None,
            occurrences=tuple(
                Occurrence(0, o.start, o.end, o.reversed and not turned, o.complete) for o in p.occurrences
            ),
            symmetric=image == p.label,
        )

    return build(
        [
            State(
                states[s.label],
                symmetric=s.symmetric,
                mirror_of=states[of_state[s.label]] if of_state.get(s.label) not in (None, s.label) else None,
                stays=tuple(Stay(0, r.start, r.end) for r in s.stays),
            )
            for s in truth.states
        ],
        [path(p) for p in truth.paths],
        (Source(truth.movement, truth.frame_count, truth.fps),),
    )
