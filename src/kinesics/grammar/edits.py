"""What a person knows better: names, merges and splits of states, paths and phrases, kept in a side file.

The file is TOML and is applied again to every new analysis. Labels are those of the analysis without the file; they are looked up
before anything is changed. What is said of a state or a path holds for its mirror image too, but not splits, which name moments::

    [states]
    rename = { A = "guard", "X~" = "attention" }      # A* becomes guard*, X~ becomes attention~
    merge = [ { keep = "B", with = ["C", "D"] } ]
    split = [ { state = "E", into = "chamber", frames = [812, 1430] } ]      # the visits nearest to these frames

    [paths]
    rename = { "ab_1" = "lunge" }                     # its mirror image becomes (lunge)*
    merge = [ { keep = "bc_1", with = ["bc_2"] } ]
    split = [ { path = "ab_1", into = "jab", frames = [120] } ]              # the traversals at these frames

    [phrases]
    rename = [ { frame = 100, name = "warm-up" } ]    # the phrase at this frame
    merge = [ { from = 300, to = 900 } ]              # all phrases from the one to the other
    split = [ { frame = 500 } ]                       # a phrase begins here

``source = 1`` in a split, or in anything of a phrase, counts frames in the second recording; ``source = "walk.bvh"`` in the one of
that name, wherever it stands. Splits are done first, then merges, then names are given.

Labels follow the order in which states come up: another choice of recordings, weights or joints may change them. In the place of a
label a frame may stand, which does not depend on that: ``"@812"`` is the state visited nearest to frame 812 of the first recording,
or the path traversed at it; ``"1@812"`` and ``"walk.bvh@812"`` are of the second recording, and of the one of that name.
"""

from __future__ import annotations

import contextlib
import dataclasses
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar

from kinesics.errors import InputError
from kinesics.grammar import notation
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, State, Stay, label_paths

T = TypeVar("T")
P = TypeVar("P", "PhraseName", "PhraseMerge", "PhraseSplit")

NEAR: Final = 1.0
"""Seconds: a frame farther than this from every visit of a state names none of them."""
_NAME: Final = re.compile(r"[^\W_]+")
_EXAMPLES: Final = {
    "states": 'rename = { A = "guard", "X~" = "attention" }',
    "paths": 'rename = { "ab_1" = "lunge" }',
    "phrases": 'rename = [ { frame = 100, name = "warm-up" } ]',
}
"""How names are given in each table of the file."""
_FRAME: Final = re.compile(r"(.*)@(\d+)", re.DOTALL)
"""A frame of a recording in the place of a label."""
_PATH_NAME: Final = re.compile(r"[^\W_]+(?:-[^\W_]+)?")


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
        with self._named():
            return _Editor(graph, self).edited()

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


def parse(text: str, file: str = "") -> Edits:
    """The edits that a side file holds.

    Parameters
    ----------
    file : its name, which is told where something cannot be applied.

    Raises
    ------
    InputError
        If the text is not TOML, or says something that is not in this module's description; the message says where.
    """
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"The edits are not TOML: {error}.") from None
    _only(values, ("states", "paths", "phrases"), "the edits")
    states, paths, phrases = (_table(values, k, "the edits") for k in ("states", "paths", "phrases"))
    for section, place in ((states, "states"), (paths, "paths"), (phrases, "phrases")):
        _only(section, ("rename", "merge", "split"), f"[{place}]", _EXAMPLES[place])
    return Edits(
        state_names=_names(states, "states"),
        state_merges=tuple(_merge(v, at) for v, at in _entries(states, "states", "merge", ("keep", "with"))),
        state_splits=tuple(
            _split(v, at, "state", named=True)
            for v, at in _entries(states, "states", "split", ("state", "into", "frames", "source"))
        ),
        path_names=_names(paths, "paths"),
        path_merges=tuple(_merge(v, at) for v, at in _entries(paths, "paths", "merge", ("keep", "with"))),
        path_splits=tuple(
            _split(v, at, "path", named=False)
            for v, at in _entries(paths, "paths", "split", ("path", "into", "frames", "source"))
        ),
        phrase_names=tuple(
            PhraseName(_get(v, "frame", int, at), _get(v, "name", str, at), _source(v, at))
            for v, at in _entries(phrases, "phrases", "rename", ("frame", "name", "source"))
        ),
        phrase_merges=tuple(
            PhraseMerge(_get(v, "from", int, at), _get(v, "to", int, at), _source(v, at))
            for v, at in _entries(phrases, "phrases", "merge", ("from", "to", "source"))
        ),
        phrase_splits=tuple(
            PhraseSplit(_get(v, "frame", int, at), _source(v, at))
            for v, at in _entries(phrases, "phrases", "split", ("frame", "source"))
        ),
        file=file,
    )


class _Editor:
    """One graph on its way to be another. Ids stay until the end, so that all labels can be looked up in the original."""

    def __init__(self, graph: MotionGraph, edits: Edits) -> None:
        self.graph, self.edits = graph, edits
        self.states = {s.id: s for s in graph.states}
        self.paths = {p.id: p for p in graph.paths}
        auto = {p.id: p for p in label_paths(graph.states, graph.paths)}
        self.path_names = {p.id: p.label for p in graph.paths if not _plainly_named(graph, p, auto[p.id])}
        self.moved_into: dict[int, int] = {}

    def edited(self) -> MotionGraph:
        edits, graph = self.edits, self.graph
        for which in (
            e.source for part in (edits.phrase_names, edits.phrase_merges, edits.phrase_splits) for e in part
        ):
            self._source(which)
        for label, name in edits.state_names.items():
            self._check_unstarred(label, name, self._state(label))
        for label, name in edits.path_names.items():
            self._check_unstarred(label, name, self._path(label))
        state_names = [(self._state(label).id, name) for label, name in edits.state_names.items()]
        path_names = [(self._path(label).id, name) for label, name in edits.path_names.items()]
        state_merges = _apart("states", edits.state_merges, lambda label: self._state(label).id)
        path_merges = _apart("paths", edits.path_merges, lambda label: self._path(label).id)
        for split in edits.path_splits:
            self._split_path(split)
        for split in edits.state_splits:
            self._split_state(split)
        for keep, other in state_merges:
            self._merge_states(self._now(keep), self._now(other))
        for keep, other in path_merges:
            self._merge_paths(self._now_path(keep), self._now_path(other))
        for state, name in self._once((self._now(s), name) for s, name in state_names):
            self._name_state(state, name)
        for path, name in self._once((~self._now_path(p), name) for p, name in path_names):
            self._name_path(~path, name)
        states = tuple(self.states.values())
        paths = label_paths(states, self.paths.values())
        named = tuple(dataclasses.replace(p, label=self.path_names.get(p.id, p.label)) for p in paths)
        return MotionGraph(states, named, graph.sources)

    def _check_unstarred(self, label: str, name: str, thing: State | Path) -> None:
        """Refuse a name for what is called after its mirror image."""
        if thing.mirror_of is None or thing.label != label or not label.endswith(notation.MIRROR):
            return
        path = isinstance(thing, Path)
        image = notation.mirror_path_label(label) if path else notation.mirror_state_label(label)
        starred = f"({name}){notation.MIRROR}" if path else name + notation.MIRROR
        raise InputError(
            f"'{label}' cannot be called '{name}': it is called after its mirror image. Name that: with "
            f"\"{image}\" = \"{name}\", '{label}' is '{starred}'."
        )

    def _once(self, names: Iterable[tuple[int, str]]) -> Iterator[tuple[int, str]]:
        """States, or paths as `_now` counts them, with their names; refused where one is to have two, it or its mirror image."""
        given: dict[int, str] = {}
        for which, name in names:
            thing = self.states[which] if which >= 0 else self.paths[~which]
            pair = thing.id if thing.mirror_of is None else min(thing.id, thing.mirror_of)
            if given.setdefault(pair, name) != name:
                what = "state" if which >= 0 else "path"
                raise InputError(
                    f"One {what}, with its mirror image, would be called both '{given[pair]}' and '{name}'."
                )
            yield which, name

    # what a label or a frame in its place speaks of: always in the graph without the edits

    def _source(self, which: int | str) -> int:
        """The number of a recording."""
        sources = self.graph.sources
        if isinstance(which, str):
            numbers = [k for k, s in enumerate(sources) if s.name == which]
            if len(numbers) != 1:
                known = ", ".join(f"'{s.name}'" for s in sources)
                why = "no recording is" if not numbers else "several recordings are: give its number, from 0, instead"
                raise InputError(f"The edits speak of a recording '{which}'; {why}. Recordings: {known}.")
            return numbers[0]
        self.graph.timeline(which)  # refuses a source that does not exist
        return which

    def _at(self, label: str) -> tuple[int, int] | None:
        """Source and frame, where a frame stands in the place of a label."""
        found = _FRAME.fullmatch(label)
        if found is None:
            return None
        named = found.group(1)
        source = self._source(int(named) if named.isdecimal() else named or 0)
        frame, frames = int(found.group(2)), self.graph.sources[source].frames
        if frame >= frames:
            raise InputError(f"The edits speak of frame {frame} of source {source}, which has {frames} frames.")
        return source, frame

    def _known(self, find: Callable[[str], T], label: str) -> T:
        try:
            return find(label)
        except InputError as error:
            raise InputError(
                f"{error} Labels may change with the choice of recordings and with weights; a frame in their place, "
                'such as "@812", does not.'
            ) from None

    def _state(self, label: str) -> State:
        at = self._at(label)
        if at is None:
            return self._known(self.graph.state, label)
        source, frame = at
        held = [s for s in self.graph.states for r in s.stays if r.source == source and r.start <= frame < r.end]
        if held:
            return held[0]
        steps = self._timeline(source, self.graph.paths)
        states = [(abs(middle - frame), self._state_at(steps, k)) for k, middle in self._visits(steps)]
        nearest = min(((apart, s) for apart, s in states if s is not None), default=None)
        if nearest is None:
            raise InputError(f"No state is visited in source {source}: '{label}' speaks of none.")
        return self.graph.state(nearest[1])

    def _path(self, label: str) -> Path:
        at = self._at(label)
        if at is None:
            return self._known(self.graph.path, label)
        source, frame = at
        for path, occurrence in self._timeline(source, self.graph.paths):
            if path is not None and occurrence is not None and occurrence.start <= frame < occurrence.end:
                return path
        raise InputError(f"No path is traversed at frame {frame} of source {source}: a state is held there.")

    # states

    def _split_state(self, split: Split) -> None:
        state, source = self._state(split.label), self._source(split.source)
        timeline = self._timeline(source)
        before = self._timeline(source, self.graph.paths)
        visits = [(k, frame) for k, frame in self._visits(before) if self._state_at(before, k) == state.id]
        if not visits:
            raise InputError(f"State '{state.label}' is not visited in source {source}: it cannot be split there.")
        chosen = {self._visit_near(frame, visits, before, state, source) for frame in split.frames}
        here = [k for k, _ in visits if self._state_at(timeline, k) == state.id]
        if not chosen <= set(here):
            raise InputError(
                f"A visit of '{state.label}' at frame {', '.join(map(str, split.frames))} of source {source} is split off "
                "twice: name each visit in one split only."
            )
        elsewhere = sum(s.source != source for s in state.stays) or any(
            o.source != source and state.id in (p.from_, p.to) for p in self.paths.values() for o in p.occurrences
        )
        if len(chosen) == len(here) and not elsewhere:
            raise InputError(
                f"All {len(here)} visits of '{state.label}' would become '{split.into}': rename it instead."
            )
        new = max(self.states) + 1
        assert split.into is not None
        self.states[new] = State(new, _name(split.into, _NAME) + notation.BAR * state.symmetric, state.symmetric)
        changed: dict[tuple[int, int, int], list[Occurrence]] = {}
        for place in chosen:
            self._move_stay(timeline, place, state.id, new)
        for k, (path, occurrence) in enumerate(timeline):
            if path is None or occurrence is None:
                continue
            ends = [path.from_, path.to]
            first, last = (1, 0) if occurrence.reversed else (0, 1)
            # boundary k lies before step k, boundary k + 1 after it
            if k in chosen:
                ends[first] = new
            if k + 1 in chosen:
                ends[last] = new
            if ends != [path.from_, path.to]:
                changed.setdefault((path.id, ends[0], ends[1]), []).append(occurrence)
        images = {p.id: p.mirror_of for p in self.paths.values()}
        made = {key: self._branch(key[0], occurrences, from_=key[1], to=key[2]) for key, occurrences in changed.items()}
        for (path_id, from_, to), branch in made.items():
            # branches of two mirror images that still join mirror images are mirror images
            image = images[path_id]
            if image is None or image == path_id or self._image(from_) is None or self._image(to) is None:
                continue
            partner = made.get((image, self._image(from_) or 0, self._image(to) or 0))
            self.paths[branch] = dataclasses.replace(self.paths[branch], mirror_of=partner)

    def _visit_near(
        self,
        frame: int,
        visits: Sequence[tuple[int, float]],
        timeline: Sequence[tuple[Path | None, Occurrence | None]],
        state: State,
        source: int,
    ) -> int:
        """The boundary at which a state is visited nearest to a frame; refused where none is near."""
        place, _ = min(visits, key=lambda visit: abs(visit[1] - frame))
        ends = [o.end for _, o in timeline[max(place - 1, 0) : place] if o is not None]
        starts = [o.start for _, o in timeline[place : place + 1] if o is not None]
        low = ends[0] if ends else 0
        high = starts[0] if starts else self.graph.sources[source].frames
        if max(low - frame, frame - high) > NEAR * self.graph.sources[source].fps:
            seen = ", ".join(f"{middle:.0f}" for _, middle in visits[:20])
            raise InputError(
                f"State '{state.label}' is not visited within {NEAR:g} s of frame {frame} of source {source}; it is at {seen}"
                f"{', …' if len(visits) > 20 else ''}."
            )
        return place

    def _image(self, state: int) -> int | None:
        known = self.states[state]
        return state if known.symmetric else known.mirror_of

    def _timeline(self, source: int, paths: Iterable[Path] = ()) -> list[tuple[Path | None, Occurrence | None]]:
        """Path and occurrence of each step, as the graph now is or of other paths; without stays: they are at the boundaries."""
        steps = [(p, o) for p in paths or self.paths.values() for o in p.occurrences if o.source == source]
        return [*sorted(steps, key=lambda step: step[1].start)]

    def _visits(self, timeline: Sequence[tuple[Path | None, Occurrence | None]]) -> list[tuple[int, float]]:
        """Boundaries between traversals, numbered, each with its middle frame."""
        out = []
        for k in range(len(timeline) + 1):
            before = timeline[k - 1][1] if k else None
            after = timeline[k][1] if k < len(timeline) else None
            start = before.end if before else 0
            end = after.start if after else start
            cut = (before is not None and not before.complete and k == len(timeline)) or (
                after is not None and not after.complete and k == 0
            )
            if not cut:
                out.append((k, 0.5 * (start + end)))
        return out

    def _state_at(self, timeline: Sequence[tuple[Path | None, Occurrence | None]], k: int) -> int | None:
        path, occurrence = timeline[k] if k < len(timeline) else timeline[k - 1] if timeline else (None, None)
        if path is None or occurrence is None:
            return None
        forwards = not occurrence.reversed
        at_start = k < len(timeline)
        return path.from_ if forwards == at_start else path.to

    def _move_stay(self, timeline: Sequence[tuple[Path | None, Occurrence | None]], k: int, old: int, new: int) -> None:
        before = timeline[k - 1][1] if k else None
        after = timeline[k][1] if k < len(timeline) else None
        source = next(o.source for _, o in timeline if o is not None)
        here = [
            s
            for s in self.states[old].stays
            if s.source == source
            and (before is None or s.start >= before.end)
            and (after is None or s.end <= after.start)
        ]
        self._set_stays(old, [s for s in self.states[old].stays if s not in here])
        self._set_stays(new, [*self.states[new].stays, *here])

    def _set_stays(self, state: int, stays: Iterable[Stay]) -> None:
        ordered = tuple(sorted(stays, key=lambda s: (s.source, s.start)))
        self.states[state] = dataclasses.replace(self.states[state], stays=ordered)

    def _merge_states(self, keep: int, other: int) -> None:
        if keep == other:
            return
        a, b = self.states[keep], self.states[other]
        if a.symmetric != b.symmetric or a.mirror_of == b.id:
            why = "mirror images of each other" if a.mirror_of == b.id else "one symmetric and one not"
            raise InputError(f"States '{a.label}' and '{b.label}' cannot be merged: they are {why}.")
        images = (a.mirror_of, b.mirror_of)
        self._absorb(keep, other)
        if images[0] is None and images[1] is not None:
            # the image of what was merged is now the image of what was kept
            self._set_image(keep, images[1])
            image = self.states[images[1]]
            self.states[image.id] = dataclasses.replace(
                image, mirror_of=keep, label=notation.mirror_state_label(self.states[keep].label)
            )
        elif images[0] is not None and images[1] is not None:
            self._absorb(images[0], images[1])

    def _absorb(self, keep: int, other: int) -> None:
        gone = self.states.pop(other)
        self.moved_into[other] = keep
        self._set_stays(keep, [*self.states[keep].stays, *gone.stays])
        for path in list(self.paths.values()):
            ends = [keep if end == other else end for end in (path.from_, path.to)]
            self.paths[path.id] = dataclasses.replace(path, from_=ends[0], to=ends[1])

    def _set_image(self, state: int, image: int | None) -> None:
        self.states[state] = dataclasses.replace(self.states[state], mirror_of=image)

    def _name_state(self, state: int, name: str) -> None:
        known = self.states[state]
        base = _name(name, _NAME)
        starred = known.label.endswith(notation.MIRROR)
        self._label_state(state, base + (notation.BAR if known.symmetric else notation.MIRROR * starred))
        if known.mirror_of is not None:
            self._label_state(known.mirror_of, base + notation.MIRROR * (not starred))

    def _label_state(self, state: int, label: str) -> None:
        taken = next((s for s in self.states.values() if s.label == label and s.id != state), None)
        if taken is not None:
            raise InputError(f"State '{self.states[state].label}' cannot be called '{label}': another state is.")
        self.states[state] = dataclasses.replace(self.states[state], label=label)

    # paths

    def _split_path(self, split: Split) -> None:
        path, source = self._path(split.label), self._source(split.source)
        chosen = []
        for frame in split.frames:
            found = [o for o in path.occurrences if o.source == source and o.start <= frame < o.end]
            if not found:
                when = ", ".join(f"[{o.start}, {o.end})" for o in path.occurrences[:20] if o.source == source)
                raise InputError(
                    f"Path '{path.label}' is not traversed at frame {frame} of source {source}; it is at {when or 'none'}."
                )
            chosen += [o for o in found if o not in chosen]
        left = self.paths[path.id].occurrences
        twice = next((o for o in chosen if o not in left), None)
        if twice is not None:
            raise InputError(
                f"The traversal of '{path.label}' at frames [{twice.start}, {twice.end}) of source {source} is split off "
                "twice: name each traversal in one split only."
            )
        if len(chosen) == len(left):
            raise InputError(f"All traversals of '{path.label}' would be split off: rename it instead.")
        new = self._branch(path.id, chosen, from_=path.from_, to=path.to)
        if split.into is not None:
            self._name_path(new, split.into)

    def _branch(self, path: int, occurrences: Sequence[Occurrence], *, from_: int, to: int) -> int:
        """Give some occurrences of a path to a new one; the path is gone where none is left."""
        old = self.paths[path]
        new = max(self.paths) + 1
        symmetric = old.symmetric and self.states[from_].symmetric and self.states[to].symmetric
        self.paths[new] = dataclasses.replace(
            old,
            id=new,
            label="",
            from_=from_,
            to=to,
            mirror_of=None,
            symmetric=symmetric,
            occurrences=_in_order(occurrences),
        )
        rest = _in_order(o for o in old.occurrences if o not in occurrences)
        if rest:
            self.paths[path] = dataclasses.replace(old, occurrences=rest)
            return new
        del self.paths[path]
        self.moved_into[~path] = ~new
        if old.mirror_of is not None and old.mirror_of in self.paths:
            self.paths[old.mirror_of] = dataclasses.replace(self.paths[old.mirror_of], mirror_of=None)
        return new

    def _merge_paths(self, keep: int, other: int) -> None:
        if keep == other:
            return
        a, b = self.paths[keep], self.paths[other]
        turn = (a.from_, a.to) != (b.from_, b.to)
        if {a.from_, a.to} != {b.from_, b.to} or a.mirror_of == b.id:
            why = (
                "mirror images of each other"
                if a.mirror_of == b.id
                else "between different states; merge the states first"
            )
            raise InputError(f"Paths '{self._said(a)}' and '{self._said(b)}' cannot be merged: they are {why}.")
        images = (a.mirror_of, b.mirror_of)
        self._absorb_path(keep, other, turn)
        own = (images[0] == keep, images[1] == other)
        if images[1] is None or own[1]:
            pass
        elif images[0] is None and not a.symmetric:
            image = self.paths[images[1]]
            if turn:
                image = _turned(image)
            self.paths[image.id] = dataclasses.replace(image, mirror_of=keep, reversible=self.paths[keep].reversible)
            self.paths[keep] = dataclasses.replace(self.paths[keep], mirror_of=image.id)
        elif images[0] is None or own[0]:
            self._absorb_path(
                keep, images[1], (self.paths[images[1]].from_, self.paths[images[1]].to) != (a.from_, a.to)
            )
        else:
            self._absorb_path(images[0], images[1], turn)
        image_id = self.paths[keep].mirror_of
        if image_id is not None:
            both = any(self.paths[p].reversible for p in (keep, image_id))
            for p in (keep, image_id):
                self.paths[p] = dataclasses.replace(self.paths[p], reversible=both)

    def _absorb_path(self, keep: int, other: int, turn: bool) -> None:
        gone = self.paths.pop(other)
        self.moved_into[~other] = ~keep
        self.path_names.pop(other, None)
        kept = self.paths[keep]
        if turn:
            gone = _turned(gone)
        occurrences = _in_order([*kept.occurrences, *gone.occurrences])
        backwards = {o.reversed for o in occurrences}
        self.paths[keep] = dataclasses.replace(
            kept,
            reversible=kept.reversible or gone.reversible or len(backwards) == 2,
            inferred=kept.inferred and gone.inferred,
            occurrences=occurrences,
        )

    def _name_path(self, path: int, name: str) -> None:
        known = self.paths[path]
        base = _name(name, _PATH_NAME)
        was = known.label or next(
            p.label for p in label_paths(self.states.values(), self.paths.values()) if p.id == path
        )
        starred = was.startswith("(")
        label = f"({base})*" if starred else base + notation.BAR * known.symmetric
        for other, taken in self.path_names.items():
            if taken == label and other != path:
                raise InputError(f"Path '{was}' cannot be called '{label}': another path is.")
        self.path_names[path] = label
        if known.mirror_of is not None and known.mirror_of != path:
            self.path_names[known.mirror_of] = notation.mirror_path_label(label)

    # what became of the things that the file speaks of

    def _now(self, state: int) -> int:
        while state in self.moved_into:
            state = self.moved_into[state]
        return state

    def _now_path(self, path: int) -> int:
        # paths are kept under the complement of their id, so that they and states share one table
        return ~self._now(~path)

    def _said(self, path: Path) -> str:
        return path.label or f"{self.states[path.from_].label} to {self.states[path.to].label}"


def _apart(what: str, merges: Iterable[Merge], find: Callable[[str], int]) -> list[tuple[int, int]]:
    """What is kept and what becomes part of it, by id; refused where they are one."""
    out = []
    for merge in merges:
        for other in merge.others:
            pair = find(merge.keep), find(other)
            if pair[0] == pair[1]:
                named = f"'{merge.keep}'" if merge.keep == other else f"'{merge.keep}' and '{other}', which are one,"
                raise InputError(f"Expected two {what} or more in a merge, got {named} alone: nothing would be merged.")
            out.append(pair)
    return out


def _plainly_named(graph: MotionGraph, path: Path, auto: Path) -> bool:
    base = notation.path_base(graph.state(path.from_).label, graph.state(path.to).label, path.symmetric)[0]
    core = path.label[1:-2] if path.label.startswith("(") else path.label
    return core.rpartition("_")[0] == base or path.label == auto.label


def _turned(path: Path) -> Path:
    occurrences = tuple(dataclasses.replace(o, reversed=not o.reversed) for o in path.occurrences)
    return dataclasses.replace(path, from_=path.to, to=path.from_, occurrences=occurrences)


def _in_order(occurrences: Iterable[Occurrence]) -> tuple[Occurrence, ...]:
    return tuple(sorted(occurrences, key=lambda o: (o.source, o.start)))


def _phrase_at(phrases: Sequence[Phrase], source: int | str, frame: int) -> int:
    for k, p in enumerate(phrases):
        if p.source == source and p.start <= frame < p.end:
            return k
    known = ", ".join(f"[{p.start}, {p.end})" for p in phrases if p.source == source) or "none"
    raise InputError(f"No phrase at frame {frame} of source {source}. Phrases there: {known}.")


def _name(name: str, pattern: re.Pattern[str]) -> str:
    if pattern.fullmatch(name) is None:
        raise InputError(
            f"Expected a name of letters and digits without '{notation.BAR}', '{notation.MIRROR}' or spaces (they are added), "
            f"got '{name}'."
        )
    return name


# reading the file


def _names(section: Mapping[str, Any], place: str) -> dict[str, str]:
    names = _table(section, "rename", f"[{place}]")
    return {label: _get(names, label, str, f"[{place}] rename") for label in names}


def _merge(values: Mapping[str, Any], at: str) -> Merge:
    others: list[Any] = _get(values, "with", list, at)
    if not others or not all(isinstance(o, str) for o in others):
        raise InputError(f"Expected a list of labels in 'with' of {at}, got {others!r}.")
    return Merge(_get(values, "keep", str, at), tuple(others))


def _split(values: Mapping[str, Any], at: str, what: str, *, named: bool) -> Split:
    frames: list[Any] = _get(values, "frames", list, at)
    if not frames or not all(isinstance(f, int) and not isinstance(f, bool) and f >= 0 for f in frames):
        raise InputError(f"Expected a list of frames from 0 in 'frames' of {at}, got {frames!r}.")
    into = _get(values, "into", str, at) if named or "into" in values else None
    return Split(_get(values, what, str, at), into, tuple(frames), _source(values, at))


def _source(values: Mapping[str, Any], at: str) -> int | str:
    """Number or name of a recording."""
    return values["source"] if isinstance(values.get("source"), str) else _get(values, "source", int, at, 0)


def _entries(
    section: Mapping[str, Any], place: str, kind: str, keys: Sequence[str]
) -> list[tuple[Mapping[str, Any], str]]:
    out: list[tuple[Mapping[str, Any], str]] = []
    entries: list[Any] = _get(section, kind, list, f"[{place}]", [])
    for k, entry in enumerate(entries):
        at = f"{place}.{kind}[{k}]"
        if not isinstance(entry, dict):
            raise InputError(f"Expected a table with {', '.join(keys)} at {at}, got {entry!r}.")
        _only(entry, keys, at)
        out.append((entry, at))
    return out


def _only(values: Mapping[str, Any], keys: Sequence[str], at: str, example: str = "") -> None:
    for key in values:
        if key not in keys:
            such = f" For example: {example}" if example else ""
            raise InputError(f"Unknown key '{key}' in {at}. Keys: {', '.join(keys)}.{such}")


def _table(values: Mapping[str, Any], key: str, at: str) -> dict[str, Any]:
    found: dict[str, Any] = _get(values, key, dict, at, {})
    return found


def _get(values: Mapping[str, Any], key: str, kind: type[T], at: str, default: T | None = None) -> T:
    if key not in values:
        if default is not None:
            return default
        raise InputError(f"Expected the key '{key}' in {at}.")
    value = values[key]
    if not isinstance(value, kind) or isinstance(value, bool):
        name = {"dict": "a table", "list": "a list", "str": "a text", "int": "a whole number"}[kind.__name__]
        raise InputError(f"Expected {name} for '{key}' in {at}, got {value!r}.")
    return value
