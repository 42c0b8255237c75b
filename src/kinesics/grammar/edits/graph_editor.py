"""A graph with states and paths split, merged and named."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

from kinesics.errors import InputError
from kinesics.grammar import notation
from kinesics.grammar.edits.labels import Labels, Traversed, state_at, traversed
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, State, Stay, label_paths

if TYPE_CHECKING:
    from kinesics.grammar.edits.changes import Edits, Merge, Split

_NAME: Final = re.compile(r"[^\W_]+")
_PATH_NAME: Final = re.compile(r"[^\W_]+(?:-[^\W_]+)?")


class GraphEditor:
    """One graph on its way to be another. Ids stay until the end, so that all labels can be looked up in the original."""

    def __init__(self, graph: MotionGraph, edits: Edits) -> None:
        self.graph, self.edits, self.labels = graph, edits, Labels(graph)
        self.states = {s.id: s for s in graph.states}
        self.paths = {p.id: p for p in graph.paths}
        auto = {p.id: p for p in label_paths(graph.states, graph.paths)}
        self.path_names = {p.id: p.label for p in graph.paths if not _plainly_named(graph, p, auto[p.id])}
        self.moved_into: dict[int, int] = {}

    def edited(self) -> MotionGraph:
        """The graph with all changes: splits, then merges, then names.

        Raises
        ------
        InputError
            As `Edits.apply`.
        """
        edits, graph = self.edits, self.graph
        for which in (
            e.source for part in (edits.phrase_names, edits.phrase_merges, edits.phrase_splits) for e in part
        ):
            self.labels.source(which)
        for label, name in edits.state_names.items():
            self._check_unstarred(label, name, self.labels.state(label))
        for label, name in edits.path_names.items():
            self._check_unstarred(label, name, self.labels.path(label))
        state_names = [(self.labels.state(label).id, name) for label, name in edits.state_names.items()]
        path_names = [(self.labels.path(label).id, name) for label, name in edits.path_names.items()]
        state_merges = _apart("states", edits.state_merges, lambda label: self.labels.state(label).id)
        path_merges = _apart("paths", edits.path_merges, lambda label: self.labels.path(label).id)
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

    # states

    def _split_state(self, split: Split) -> None:
        state, source = self.labels.state(split.label), self.labels.source(split.source)
        visits = self.labels.visits(state, source)
        chosen = {self.labels.visit_near(frame, state, source) for frame in split.frames}
        steps = traversed(self.paths.values(), source)
        here = [k for k, _ in visits if state_at(steps, k) == state.id]
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
        for place in chosen:
            self._move_stay(steps, place, state.id, new)
        self._lead_elsewhere(steps, chosen, new)

    def _lead_elsewhere(self, steps: Sequence[Traversed], boundaries: Collection[int], state: int) -> None:
        """Traversals that end or begin at some boundaries become those of branches that do so in another state."""
        changed: dict[tuple[int, int, int], list[Occurrence]] = {}
        for k, (path, occurrence) in enumerate(steps):
            ends = [path.from_, path.to]
            first, last = (1, 0) if occurrence.reversed else (0, 1)
            if k in boundaries:
                ends[first] = state
            if k + 1 in boundaries:
                ends[last] = state
            if ends != [path.from_, path.to]:
                changed.setdefault((path.id, ends[0], ends[1]), []).append(occurrence)
        images = {p.id: p.mirror_of for p in self.paths.values()}
        made = {key: self._branch(key[0], occurrences, from_=key[1], to=key[2]) for key, occurrences in changed.items()}
        for (path_id, from_, to), branch in made.items():
            # branches of two mirror images that still join mirror images are mirror images
            image, ends_there = images[path_id], (self._image(from_), self._image(to))
            if image is None or image == path_id or ends_there[0] is None or ends_there[1] is None:
                continue
            partner = made.get((image, ends_there[0], ends_there[1]))
            self.paths[branch] = dataclasses.replace(self.paths[branch], mirror_of=partner)

    def _image(self, state: int) -> int | None:
        known = self.states[state]
        return state if known.symmetric else known.mirror_of

    def _move_stay(self, steps: Sequence[Traversed], k: int, old: int, new: int) -> None:
        before = steps[k - 1][1] if k else None
        after = steps[k][1] if k < len(steps) else None
        source = steps[0][1].source
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
        path, source = self.labels.path(split.label), self.labels.source(split.source)
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
                image = image.turned()
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
            gone = gone.turned()
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


def _in_order(occurrences: Iterable[Occurrence]) -> tuple[Occurrence, ...]:
    return tuple(sorted(occurrences, key=lambda o: (o.source, o.start)))


def _name(name: str, pattern: re.Pattern[str]) -> str:
    if pattern.fullmatch(name) is None:
        raise InputError(
            f"Expected a name of letters and digits without '{notation.BAR}', '{notation.MIRROR}' or spaces (they are added), "
            f"got '{name}'."
        )
    return name
