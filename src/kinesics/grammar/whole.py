"""All that the grammar tells of one recording, read in one go: class, phrases, motifs, graph.

A recording of a few moments has none of them: that stands in `Grammar.remarks`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from kinesics.body.pose import PoseSequence
from kinesics.grammar import assembly, classes, cyclic, direction, moments, motifs, phrases, reading
from kinesics.grammar.classes import Verdict
from kinesics.grammar.cyclic import Cyclic
from kinesics.grammar.edits import Edits, Phrase
from kinesics.grammar.graph import MotionGraph
from kinesics.grammar.moments import Moments
from kinesics.grammar.motifs import Motif, Reversal, StateRepetition, Strike
from kinesics.progress import Progress, silent
from kinesics.similarity import Weights

SURE: Final = 0.6
"""Confidence from which on a cyclic class says what the states of its stretch are;"""
PERIODS_OF_THE_WHOLE: Final = classes.PERIODS_OF_HALVES
"""and so many periods where the recording is nothing else, the fewest that make a class cyclic;"""
PERIODS_OF_A_PHRASE: Final = 3.0
"""so many where it is one phrase among others: what is done twice there may be any choreography, and is read like one."""
LEAST_MOMENTS: Final = 6
"""A recording of fewer moments has no class, no phrases and no motifs, and its graph is hardly more than a pose."""


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
    still: bool = False
    """A rest."""
    mirrored: bool = False
    """It is like the first phrase of its kind as that is seen in a mirror, and not as it is."""
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
    """What could not be read, and why."""
    as_read: tuple[JudgedPhrase, ...] = ()
    """The phrases before a person's edits: what the graph is read from."""


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
    if read.count < LEAST_MOMENTS:
        graph = assembly.assemble(reading.read(read), read, name) if with_graph else None
        report(1.0, "grammar read")
        return Grammar(read, None, (), (), (), (), (), graph, (_too_short(read),))
    # as it is read, from its beginning or from its end; the motifs take both directions together
    seen = direction.reversed_moments(read) if read.from_end else read
    report(0.05, "the class of the whole and of the phrases")
    overall: Verdict | None
    overall, judged = _judge(seen, part(report, 0.05, 0.45))
    report(0.45, "motifs")
    recurring = motifs.find_motifs(read, part(report, 0.45, 0.7))
    repeated = motifs.find_state_repetitions(read)
    reversals = motifs.find_reversals(read)
    strikes = motifs.find_strikes(read)
    graph = None
    if with_graph:
        report(0.75, "the motion graph")
        states_and_paths = reading.read(seen, cyclic_stretches(seen, overall, judged), part(report, 0.75, 1.0))
        if seen is not read:
            states_and_paths = direction.reversed_reading(states_and_paths, read.count)
        graph = assembly.assemble(states_and_paths, read, name)
    if seen is not read:
        overall, judged = turned_round(overall, judged, read.source_frames)
    edited = judged if edits is None else _edited_phrases(read, judged, edits, source, name)
    report(1.0, "grammar read")
    return Grammar(
        read, overall, tuple(edited), recurring, repeated, reversals, strikes, graph, (), as_read=tuple(judged)
    )


def part(progress: Progress, start: float, end: float) -> Progress:
    """A part of the work, from 0 to 1, as a share of the whole."""
    return lambda fraction, message="": progress(start + (end - start) * fraction, message)


def _too_short(read: Moments) -> str:
    frames = f"{read.source_frames} frame{'s' * (read.source_frames != 1)}"
    return (
        f"{frames} are too few for a grammar: no class, phrases or motifs were read "
        f"(from {LEAST_MOMENTS} moments on, at most {moments.RATE:.0f} a second)."
    ).replace("1 frame are", "1 frame is")


def judge(read: Moments) -> tuple[Verdict | None, list[JudgedPhrase]]:
    """The class of a recording as one path; and its phrases, each with its class."""
    if not read.from_end:
        return _judge(read)
    return turned_round(*_judge(direction.reversed_moments(read)), read.source_frames)


def _judge(read: Moments, progress: Progress = silent) -> tuple[Verdict, list[JudgedPhrase]]:
    overall = classes.classify(read)
    progress(0.4, "phrases")
    found = phrases.find_phrases(read)
    judged: list[JudgedPhrase] = []
    for number, phrase in enumerate(found):
        progress(0.6 + 0.4 * number / len(found), "classes of the phrases")
        all_of_it = (phrase.start, phrase.end) == (0, read.count)
        verdict = overall if all_of_it else classes.classify(read, phrase.start, phrase.end)
        start, end = read.frame_of(phrase.start), read.frame_of(phrase.end)
        judged.append(JudgedPhrase(start, end, phrase.kind, verdict, phrase.still, phrase.mirrored))
    return overall, judged


def cyclic_stretches(read: Moments, overall: Verdict | None, judged: Sequence[JudgedPhrase]) -> list[Cyclic]:
    """Stretches whose states follow from their class: the whole where it is one cyclic movement, else cyclic phrases."""
    whole = _structures(read, [(0, read.count, overall)], PERIODS_OF_THE_WHOLE)
    return whole or _structures(
        read, [(read.moment_of(p.start), read.moment_of(p.end), p.verdict) for p in judged], PERIODS_OF_A_PHRASE
    )


def _structures(
    read: Moments, candidates: Sequence[tuple[int, int, Verdict | None]], least_periods: float
) -> list[Cyclic]:
    out: list[Cyclic] = []
    for start, end, verdict in candidates:
        if verdict is None or verdict.class_ is None or verdict.confidence < SURE:
            continue
        if not verdict.cycles or (verdict.repeats or 0.0) < least_periods:
            continue
        cuts = [read.moment_of(c.start) for c in verdict.cycles] + [read.moment_of(verdict.cycles[-1].end)]
        found = cyclic.structure(read, start, end, verdict.class_, cuts)
        if found is not None:
            out.append(found)
    return out


def turned_round(
    overall: Verdict | None, judged: Sequence[JudgedPhrase], frames: int
) -> tuple[Verdict | None, list[JudgedPhrase]]:
    """Class and phrases of a recording that was read from its other end; kinds are numbered in order of appearance again."""
    phrases_turned = [
        dataclasses.replace(
            p,
            start=frames - p.end,
            end=frames - p.start,
            verdict=None if p.verdict is None else direction.reversed_verdict(p.verdict, frames),
        )
        for p in reversed(judged)
    ]
    return None if overall is None else direction.reversed_verdict(overall, frames), in_order_of_kinds(phrases_turned)


def in_order_of_kinds(judged: Sequence[JudgedPhrase]) -> list[JudgedPhrase]:
    """Phrases whose kinds are numbered in order of appearance, and mirrored against the first one of their kind."""
    firsts: dict[int, tuple[int, bool]] = {}
    out = []
    for phrase in judged:
        kind, mirrored = firsts.setdefault(phrase.kind, (len(firsts), phrase.mirrored))
        out.append(dataclasses.replace(phrase, kind=kind, mirrored=phrase.mirrored != mirrored))
    return out


def _edited_phrases(
    read: Moments, judged: Sequence[JudgedPhrase], edits: Edits, source: int, name: str
) -> list[JudgedPhrase]:
    """Phrases split, merged and named; what was not judged yet, because a person made it, is judged now."""
    known = {(p.start, p.end): p for p in judged}
    out = []
    for phrase in edits.of_source(source, name).apply_to_phrases(Phrase(source, p.start, p.end) for p in judged):
        same = known.get((phrase.start, phrase.end))
        if same is None:
            part = next(p for p in judged if p.start <= phrase.start < p.end)
            start, end = read.moment_of(phrase.start), read.moment_of(phrase.end)
            verdict = classes.classify(read, start, end) if end - start >= LEAST_MOMENTS else None
            still = part.still and phrase.end <= part.end
            same = JudgedPhrase(phrase.start, phrase.end, part.kind, verdict, still, part.mirrored)
        out.append(dataclasses.replace(same, name=phrase.name))
    return out
