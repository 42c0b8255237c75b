"""What a person says of a recording: the changes, and which phrases they leave."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from kinesics.errors import InputError

if TYPE_CHECKING:
    from kinesics.grammar.graph import MotionGraph

P = TypeVar("P", "PhraseName", "PhraseMerge", "PhraseSplit")


@dataclass(frozen=True)
class Merge:
    """Labels of what becomes part of ``keep``."""

    keep: str
    others: tuple[str, ...]


@dataclass(frozen=True)
class Split:
    """Moments of a state or a path that are another state or path, named ``into``."""

    label: str
    into: str | None
    frames: tuple[int, ...]
    source: int | str = 0
    """Number or name of the recording."""


@dataclass(frozen=True)
class PhraseName:
    """The phrase at a frame has a name."""

    frame: int
    name: str
    source: int | str = 0


@dataclass(frozen=True)
class PhraseMerge:
    """The phrases from the one at ``start`` to the one at ``end`` are one."""

    start: int
    end: int
    source: int | str = 0


@dataclass(frozen=True)
class PhraseSplit:
    """A phrase begins at a frame."""

    frame: int
    source: int | str = 0


@dataclass(frozen=True)
class Phrase:
    """Frames [start, end) of a source, with a name or none."""

    source: int
    start: int
    end: int
    name: str | None = None


@dataclass(frozen=True)
class Edits:
    """All that a side file says."""

    state_names: Mapping[str, str] = dataclasses.field(default_factory=dict)
    state_merges: tuple[Merge, ...] = ()
    state_splits: tuple[Split, ...] = ()
    path_names: Mapping[str, str] = dataclasses.field(default_factory=dict)
    path_merges: tuple[Merge, ...] = ()
    path_splits: tuple[Split, ...] = ()
    phrase_names: tuple[PhraseName, ...] = ()
    phrase_merges: tuple[PhraseMerge, ...] = ()
    phrase_splits: tuple[PhraseSplit, ...] = ()
    file: str = ""
    """Name of the side file, for messages."""

    def of_source(self, source: int, name: str = "") -> Edits:
        """Without the edits of phrases of other recordings; those of this one, by number or name, have its number."""

        def mine(entries: tuple[P, ...]) -> tuple[P, ...]:
            return tuple(dataclasses.replace(e, source=source) for e in entries if e.source in (source, name))

        return dataclasses.replace(
            self,
            phrase_names=mine(self.phrase_names),
            phrase_merges=mine(self.phrase_merges),
            phrase_splits=mine(self.phrase_splits),
        )

    def apply(self, graph: MotionGraph) -> MotionGraph:
        """The graph with states and paths split, merged and named.

        Raises
        ------
        InputError
            If a label, a frame or a recording is not in the graph (the message lists the labels that are), what is merged cannot
            be one, or a name is taken.
        """
        from kinesics.grammar.edits.graph_editor import GraphEditor

        with self._named():
            return GraphEditor(graph, self).edited()

    def apply_to_phrases(self, phrases: Iterable[Phrase]) -> tuple[Phrase, ...]:
        """The phrases split, merged and named; they tile what they tiled.

        Raises
        ------
        InputError
            If there is no phrase at a frame.
        """
        with self._named():
            return self._phrases_edited(phrases)

    @contextlib.contextmanager
    def _named(self) -> Iterator[None]:
        """What is refused says in which file it stands."""
        try:
            yield
        except InputError as error:
            raise (InputError(f"{self.file}: {error}") if self.file else error) from None

    def _phrases_edited(self, phrases: Iterable[Phrase]) -> tuple[Phrase, ...]:
        parts = sorted(phrases, key=lambda p: (p.source, p.start))
        for split in self.phrase_splits:
            k = _phrase_at(parts, split.source, split.frame)
            if parts[k].start < split.frame:
                parts[k : k + 1] = [
                    dataclasses.replace(parts[k], end=split.frame),
                    dataclasses.replace(parts[k], start=split.frame),
                ]
        for merge in self.phrase_merges:
            first, last = (_phrase_at(parts, merge.source, frame) for frame in (merge.start, merge.end))
            if first > last:
                raise InputError(
                    f"Expected 'from' before 'to' in a merge of phrases, got {merge.start} and {merge.end}."
                )
            parts[first : last + 1] = [dataclasses.replace(parts[first], end=parts[last].end)]
        for name in self.phrase_names:
            k = _phrase_at(parts, name.source, name.frame)
            parts[k] = dataclasses.replace(parts[k], name=name.name)
        return tuple(parts)


def _phrase_at(phrases: Sequence[Phrase], source: int | str, frame: int) -> int:
    for k, p in enumerate(phrases):
        if p.source == source and p.start <= frame < p.end:
            return k
    known = ", ".join(f"[{p.start}, {p.end})" for p in phrases if p.source == source) or "none"
    raise InputError(f"No phrase at frame {frame} of source {source}. Phrases there: {known}.")
