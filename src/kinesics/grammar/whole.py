"""All that the grammar tells of one recording, read in one go: class, phrases, motifs, graph.

Each part is read by itself. One that cannot be read (a recording of one frame has no phrases) is empty and leaves the others as
they are; why it is empty stands in `Grammar.remarks`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final, TypeVar

from kinesics.body.pose import PoseSequence
from kinesics.errors import Cancelled
from kinesics.grammar import assembly, classes, cyclic, direction, moments, motifs, phrases, reading
from kinesics.grammar.classes import Verdict
from kinesics.grammar.cyclic import Cyclic
from kinesics.grammar.edits import Edits, Phrase
from kinesics.grammar.graph import MotionGraph
from kinesics.grammar.moments import Moments
from kinesics.grammar.motifs import Motif, Reversal, StateRepetition, Strike
from kinesics.progress import Progress, silent
from kinesics.similarity import Weights

T = TypeVar("T")

SURE: Final = 0.6
"""Confidence from which on a cyclic class says what the states of its stretch are;"""
CYCLES: Final = 3
"""and so many periods: what is done twice may be any choreography, and is read like one."""
LEAST_MOMENTS: Final = 6
"""A recording of fewer moments has no phrases, no motifs and no graph."""


@dataclass(frozen=True, eq=False)
class JudgedPhrase:
    """A phrase and its class."""

    start: int
    """Source frame."""
    end: int
    """Exclusive."""
    kind: int
    """The same number for phrases of the same kind of movement, in order of appearance."""
    verdict: Verdict | None
    """None where the phrase could not be judged at all."""
    name: str | None = None
    """Given by a person (`kinesics.grammar.edits`)."""


@dataclass(frozen=True, eq=False)
class Grammar:
    """What was read.

    Phrases and the graph count frames of the recording, motifs and the like count moments: `Moments.frame_of` leads from these to
    those.
    """

    moments: Moments
    overall: Verdict | None
    """Of the whole as one path."""
    phrases: tuple[JudgedPhrase, ...]
    """They follow one another from the first frame to the last; none for a recording that is too short."""
    motifs: tuple[Motif, ...]
    state_repetitions: tuple[StateRepetition, ...]
    reversals: tuple[Reversal, ...]
    strikes: tuple[Strike, ...]
    graph: MotionGraph | None
    remarks: tuple[str, ...]
    """Which parts could not be read, and why."""


def read_grammar(
    poses: PoseSequence,
    *,
    name: str = "",
    weights: Weights | None = None,
    edits: Edits | None = None,
    source: int = 0,
    with_graph: bool = True,
    progress: Progress | None = None,
) -> Grammar:
    """The grammar of one recording.

    Parameters
    ----------
    name : of the recording, for the graph.
    weights : of the 15 links in D (see `kinesics.similarity.distance`).
    edits : what a person knows better of the phrases; done when all is read, so that the labels of the graph do not depend on it.
        The graph is left as it is: `Edits.apply` changes it.
    source : the number of the recording in the edits.
    with_graph : read the motion graph, too; not needed for one of several recordings (`kinesics.grammar.many`).
    progress : called with a fraction now and then; may raise to stop.

    Raises
    ------
    InputError
        If the weights cannot be used, or the edits speak of phrases that are not there.
    """
    report = progress or silent
    report(0.0, "moments")
    read = moments.from_poses(poses, weights=weights)
    remarks: list[str] = []
    if read.count < LEAST_MOMENTS:
        report(1.0, "grammar read")
        return Grammar(read, None, (), (), (), (), (), None, ())

    def attempt(what: str, job: Callable[[], T]) -> T | None:
        return attempted(remarks, what, job)

    # as it is read, from its beginning or from its end; the motifs take both directions together
    seen = direction.reversed_moments(read) if direction.from_the_end(read) else read
    report(0.05, "the class of the whole")
    overall = attempt("The class of the whole", lambda: classes.classify(seen))
    report(0.2, "phrases")
    found = attempt("Phrases", lambda: phrases.find_phrases(seen)) or ()
    judged: list[JudgedPhrase] = []
    for number, phrase in enumerate(found):
        report(0.3 + 0.15 * number / len(found), "classes of the phrases")
        verdict = overall
        if (phrase.start, phrase.end) != (0, read.count) or verdict is None:
            judge = partial(classes.classify, seen, phrase.start, phrase.end)
            verdict = attempt(f"The class of phrase {number}", judge)
        judged.append(JudgedPhrase(seen.frame_of(phrase.start), seen.frame_of(phrase.end), phrase.kind, verdict))

    def part(start: float, end: float) -> Progress:
        return lambda fraction, message="": report(start + (end - start) * fraction, message)

    report(0.45, "motifs")
    recurring = attempt("Motifs", lambda: motifs.find_motifs(read, part(0.45, 0.7))) or ()
    repeated = attempt("State repetitions", lambda: motifs.find_state_repetitions(read)) or ()
    reversals = attempt("Reversals", lambda: motifs.find_reversals(read)) or ()
    strikes = attempt("Strikes", lambda: motifs.find_strikes(read)) or ()
    report(0.75, "the motion graph")

    def read_graph() -> MotionGraph:
        states_and_paths = reading.read(seen, _cyclic(seen, overall, judged), part(0.75, 1.0))
        if seen is not read:
            states_and_paths = direction.reversed_reading(states_and_paths, read.count)
        return assembly.assemble(states_and_paths, read, name)

    graph = attempt("The motion graph", read_graph) if with_graph else None
    if seen is not read:
        overall = None if overall is None else direction.reversed_verdict(overall, read)
        judged = _turned_round(judged, read)
    if edits is not None:
        judged = _edited_phrases(read, judged, edits, source)
    report(1.0, "grammar read")
    return Grammar(read, overall, tuple(judged), recurring, repeated, reversals, strikes, graph, tuple(remarks))


def attempted(remarks: list[str], what: str, job: Callable[[], T]) -> T | None:
    """What the job gives; None, and a remark, where it fails: one part must not take the others with it, nor fail unseen."""
    try:
        return job()
    except (Cancelled, MemoryError):
        raise
    except Exception as error:
        remarks.append(f"{what} could not be read: {type(error).__name__}: {error}")
        return None


def cyclic_stretches(read: Moments) -> list[Cyclic]:
    """Judge a recording and its phrases, and give the stretches whose states follow from their class."""
    overall = classes.classify(read)
    judged = [
        JudgedPhrase(read.frame_of(p.start), read.frame_of(p.end), p.kind, classes.classify(read, p.start, p.end))
        for p in phrases.find_phrases(read)
    ]
    return _cyclic(read, overall, judged)


def _cyclic(read: Moments, overall: Verdict | None, judged: Sequence[JudgedPhrase]) -> list[Cyclic]:
    """Stretches whose states follow from their class: the whole where it is one cyclic movement, else cyclic phrases."""
    whole = _structures(read, [(0, read.count, overall)])
    return whole or _structures(read, [(read.moment_of(p.start), read.moment_of(p.end), p.verdict) for p in judged])


def _structures(read: Moments, candidates: Sequence[tuple[int, int, Verdict | None]]) -> list[Cyclic]:
    out: list[Cyclic] = []
    for start, end, verdict in candidates:
        if verdict is None or verdict.class_ is None or verdict.confidence < SURE:
            continue
        if len(verdict.cycles) < 2 or (verdict.repeats or 0.0) < CYCLES:
            continue
        cuts = [read.moment_of(c.start) for c in verdict.cycles] + [read.moment_of(verdict.cycles[-1].end)]
        found = cyclic.structure(read, start, end, verdict.class_, cuts)
        if found is not None:
            out.append(found)
    return out


def _turned_round(judged: Sequence[JudgedPhrase], read: Moments) -> list[JudgedPhrase]:
    """The phrases of a recording that was read from its end; kinds are numbered in order of appearance again."""
    kinds: dict[int, int] = {}
    return [
        dataclasses.replace(
            p,
            start=read.frame_of(read.count - read.moment_of(p.end)),
            end=read.frame_of(read.count - read.moment_of(p.start)),
            kind=kinds.setdefault(p.kind, len(kinds)),
            verdict=None if p.verdict is None else direction.reversed_verdict(p.verdict, read),
        )
        for p in reversed(judged)
    ]


def _edited_phrases(read: Moments, judged: Sequence[JudgedPhrase], edits: Edits, source: int) -> list[JudgedPhrase]:
    """Phrases split, merged and named; what was not judged yet, because a person made it, is judged now."""
    known = {(p.start, p.end): p for p in judged}
    out = []
    for phrase in edits.of_source(source).apply_to_phrases(Phrase(source, p.start, p.end) for p in judged):
        same = known.get((phrase.start, phrase.end))
        if same is None:
            kind = next(p.kind for p in judged if p.start <= phrase.start < p.end)
            start, end = read.moment_of(phrase.start), read.moment_of(phrase.end)
            verdict = classes.classify(read, start, end) if end - start >= LEAST_MOMENTS else None
            same = JudgedPhrase(phrase.start, phrase.end, kind, verdict)
        out.append(dataclasses.replace(same, name=phrase.name))
    return out
