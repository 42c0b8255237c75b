"""All that the grammar tells of one recording, read in one go: class, phrases, graph.

Each part is read by itself. One that cannot be read (a recording of one frame has no phrases) is empty and leaves the others as
they are; why it is empty stands in `Grammar.remarks`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final, TypeVar

from kinesics.body.pose import PoseSequence
from kinesics.errors import Cancelled
from kinesics.grammar import assembly, classes, cyclic, moments, phrases, reading
from kinesics.grammar.classes import Verdict
from kinesics.grammar.cyclic import Cyclic
from kinesics.grammar.graph import MotionGraph
from kinesics.grammar.moments import Moments
from kinesics.progress import Progress, silent
from kinesics.similarity._inputs import Weights

T = TypeVar("T")

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


@dataclass(frozen=True, eq=False)
class Grammar:
    """What was read; all frames are those of the recording."""

    moments: Moments
    overall: Verdict | None
    """Of the whole as one path."""
    phrases: tuple[JudgedPhrase, ...]
    """They follow one another from the first frame to the last; none for a recording that is too short."""
    graph: MotionGraph | None
    remarks: tuple[str, ...]
    """Which parts could not be read, and why."""


def read_grammar(
    poses: PoseSequence,
    *,
    name: str = "",
    weights: Weights | None = None,
    progress: Progress | None = None,
) -> Grammar:
    """The grammar of one recording.

    Parameters
    ----------
    name : of the recording, for the graph.
    weights : of the 15 links in D (see `kinesics.similarity.distance`).
    progress : called with a fraction now and then; may raise to stop.

    Raises
    ------
    InputError
        If the weights cannot be used.
    """
    report = progress or silent
    report(0.0, "moments")
    read = moments.from_poses(poses, weights=weights)
    remarks: list[str] = []
    if read.count < LEAST_MOMENTS:
        report(1.0, "grammar read")
        return Grammar(read, None, (), None, ())

    def attempt(what: str, job: Callable[[], T]) -> T | None:
        try:
            return job()
        except (Cancelled, MemoryError):
            raise
        # one part must not take the others with it; it is said, not hidden
        except Exception as error:
            remarks.append(f"{what} could not be read: {type(error).__name__}: {error}")
            return None

    report(0.05, "the class of the whole")
    overall = attempt("The class of the whole", lambda: classes.classify(read))
    report(0.2, "phrases")
    found = attempt("Phrases", lambda: phrases.find_phrases(read)) or ()
    judged: list[JudgedPhrase] = []
    for number, phrase in enumerate(found):
        report(0.35 + 0.2 * number / len(found), "classes of the phrases")
        verdict = overall
        if (phrase.start, phrase.end) != (0, read.count) or verdict is None:
            judge = partial(classes.classify, read, phrase.start, phrase.end)
            verdict = attempt(f"The class of phrase {number}", judge)
        judged.append(JudgedPhrase(read.frame_of(phrase.start), read.frame_of(phrase.end), phrase.kind, verdict))
    report(0.55, "the motion graph")

    def later(fraction: float, message: str = "") -> None:
        report(0.55 + 0.45 * fraction, message or "the motion graph")

    def read_graph() -> MotionGraph:
        return assembly.assemble(reading.read(read, _cyclic(read, overall, judged), later), read, name)

    graph = attempt("The motion graph", read_graph)
    report(1.0, "grammar read")
    return Grammar(read, overall, tuple(judged), graph, tuple(remarks))


def _cyclic(read: Moments, overall: Verdict | None, judged: Sequence[JudgedPhrase]) -> list[Cyclic]:
    """Stretches whose states follow from their class: the whole where it is one cyclic movement, else cyclic phrases."""
    candidates = [(0, read.count, overall)]
    if overall is None or not overall.cycles:
        candidates = [(read.moment_of(p.start), read.moment_of(p.end), p.verdict) for p in judged]
    out: list[Cyclic] = []
    for start, end, verdict in candidates:
        if verdict is None or verdict.class_ is None or not verdict.cycles:
            continue
        cuts = [read.moment_of(c.start) for c in verdict.cycles] + [read.moment_of(verdict.cycles[-1].end)]
        found = cyclic.structure(read, start, end, verdict.class_, cuts)
        if found is not None:
            out.append(found)
    return out
