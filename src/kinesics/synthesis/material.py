"""What is performed from, made ready once: all that does not depend on what is wished for.

Bringing recordings together, finding their transitions, planting their feet and looking ahead takes most of the time of a
performance, and is the same for all of them. Another part of the recordings, or the grammar's words, are made when they are first
wished for, and kept.
"""

from __future__ import annotations

import dataclasses
import warnings
import weakref
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.body import anatomy
from kinesics.body.motion import Motion
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError, SkeletonError
from kinesics.progress import Progress, silent
from kinesics.synthesis import elsewhere, goals
from kinesics.synthesis.embodiment.afoot import afoot
from kinesics.synthesis.joining.transitions import Transitions, transitions
from kinesics.synthesis.paths import labels
from kinesics.synthesis.paths import network as networks
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.paths.prospects import Prospects, prospects
from kinesics.synthesis.repertoire import LEAST_FPS, Repertoire, repertoire
from kinesics.synthesis.request import Request
from kinesics.synthesis.wish import Grammar, Wish, check_names, check_states, names_recordings

if TYPE_CHECKING:
    from kinesics.grammar.edits import Edits

Mask = NDArray[np.bool_]


class Ground(NamedTuple):
    """What is performed from for one wish."""

    wish: Wish
    """With the names that recordings have."""
    largest: Network
    """Of the largest part that holds together."""
    part: Network
    """Of the part that holds what is wished for; the largest, where that does, or none."""
    serving: Network
    """Of what is performed: that part; or the ways from one state to another, or those from a state into the part, too."""
    network: Network
    """The same with feet planted."""
    ahead: Prospects


class Material:
    """Recordings made ready to perform from, once, so that any number of performances can begin at once.

    Made by `kinesics.prepare`; `kinesics.perform`, `kinesics.performance` and `kinesics.Avatar` take it in place of recordings, and
    give with it the very same movement as without.
    """

    def __init__(
        self,
        motions: Motion | Sequence[Motion],
        *,
        skeleton: Skeleton | Motion | None = None,
        fps: float | None = None,
        mirrored: bool = True,
        backwards: bool = False,
        threshold: float | None = None,
        mapping: Mapping[str, object] | None = None,
        edits: Edits | None = None,
    ) -> None:
        """See `kinesics.prepare`. What is brought together here is worked out no further until it is asked for."""
        # of what is asked for all that shapes the material is checked by it
        Request(fps=fps, mirrored=mirrored, backwards=backwards, threshold=threshold)
        given, self.twice = _given(motions, mapping)
        given, self.left_out = _usable(given)
        self.recordings = tuple(given)
        """Each once: what was given twice is told in `twice`, what nothing can be performed of in `left_out`."""
        self.repertoire: Repertoire = repertoire(
            given, skeleton=skeleton, fps=fps, mirrored=bool(mirrored), backwards=bool(backwards)
        )
        self.skeleton, self.fps, self.threshold, self.mapping, self.edits = skeleton, fps, threshold, mapping, edits
        self._found: Transitions | None = None
        self._grammars: dict[bool, Grammar] = {}
        self._networks: dict[tuple[bool | None, str, bytes], Network] = {}
        self._ready: weakref.WeakKeyDictionary[Network, tuple[Network, Prospects]] = weakref.WeakKeyDictionary()

    def __repr__(self) -> str:
        """Its size in one line."""
        seconds = self.repertoire.frame_count / self.repertoire.fps
        return f"Material({len(self.recordings)} recording{'s'[: len(self.recordings) != 1]}, {seconds:.1f} s)"

    @cached_property
    def network(self) -> Network:
        """The paths of the largest part that holds together, with feet planted: for a `Controller` and a `LiveRenderer` of one's
        own.
        """
        return self.ground(Wish.of()).network

    @cached_property
    def ahead(self) -> Prospects:
        """What may follow each path of `network`: ``prepared`` of a `Controller`."""
        return self.ground(Wish.of()).ahead

    def agreed(
        self,
        asked: Request,
        skeleton: Skeleton | Motion | None = None,
        mapping: Mapping[str, object] | None = None,
        edits: Edits | None = None,
    ) -> Request:
        """What is asked for, completed by what the material was prepared for.

        Raises
        ------
        InputError
            If it was prepared for something else.
        """
        own = self.repertoire
        pairs: list[tuple[str, object, object]] = [
            ("fps", asked.fps, own.fps),
            ("mirrored", asked.mirrored, own.mirrored),
            ("backwards", asked.backwards, own.backwards),
            ("threshold", asked.threshold, self.threshold),
            ("mapping", mapping, self.mapping),
            ("edits", edits, self.edits),
        ]
        others = [name for name, wanted, has in pairs if wanted is not None and wanted != has]
        if skeleton is not None and skeleton is not self.skeleton:
            others.append("skeleton")
        if others:
            told = " and ".join(f"`{name}`" for name in others)
            raise InputError(
                f"The recordings were prepared with another {told}: give {'it' if len(others) == 1 else 'them'} to kx.prepare(…), "
                "which makes another material, or leave it out here."
            )
        return dataclasses.replace(
            asked, fps=self.fps, mirrored=own.mirrored, backwards=own.backwards, threshold=self.threshold
        )

    def ground(self, wish: Wish, progress: Progress = silent) -> Ground:
        """What is performed from for a wish: the part that holds it, looked ahead from.

        Raises
        ------
        InputError
            If nothing recurs so that there are no transitions, or something wished for by name is nowhere, or cannot be come to.
        """
        stock = self.repertoire
        wish = wish.by_name(self.recordings, stock.names)
        words = self._words(wish)
        grammar = None
        if words is not None:
            grammar = self._grammar(words, lambda f, message="": progress(0.2 * f, message))
            check_states(wish, grammar.graph)
        found = self._transitions(lambda f, message="": progress(0.2 + 0.7 * f, message))

        def made(holding: Mask | None) -> Network:
            return self._network(found, words, wish, holding)

        def everything() -> Network:
            assert grammar is not None, "states are asked for"
            every = networks.everything(found, self._seams(grammar, wish))
            return labels.labelled(every, grammar.graph, grammar.phrases, at_states=True)

        largest = made(None)
        part = elsewhere.serving(largest, wish, found, made)
        serving = elsewhere.way_in(elsewhere.way_there(part, wish, everything), wish, everything)
        if grammar is not None:
            check_names(serving, wish, grammar)
        if serving not in self._ready:
            progress(0.9, "looking ahead")
            planted = afoot(serving)
            self._ready[serving] = planted, prospects(planted)
        return Ground(wish, largest, part, serving, *self._ready[serving])

    def _words(self, wish: Wish) -> bool | None:
        """Whether the grammar is to be read with its phrases; None where nobody asks for any of it."""
        if wish.favour is not None and not names_recordings(wish.favour, self.repertoire.names, self.edits):
            return True
        return None if wish.from_state is None else False

    def _grammar(self, phrases: bool, progress: Progress) -> Grammar:
        if phrases not in self._grammars:
            progress(0.0, "reading the grammar")
            if phrases:
                from kinesics.analysis import analyze

                read = analyze(list(self.recordings), edits=self.edits, progress=progress)
                self._grammars[phrases] = Grammar(read.graph, read.phrases)
            else:
                from kinesics.analysis import joint

                graph = joint.graph(list(self.recordings), edits=self.edits, progress=progress)
                self._grammars[phrases] = Grammar(graph, ())
        return self._grammars[phrases]

    def _transitions(self, progress: Progress) -> Transitions:
        if self._found is None:
            self._found = transitions(self.repertoire, threshold=self.threshold, progress=progress)
        return self._found

    def _seams(self, grammar: Grammar, wish: Wish) -> NDArray[np.intp]:
        """Frames at which paths are to begin, so that they can in states."""
        lead = goals.LEAD if wish.to_state is not None else 0.0
        return labels.state_seams(self.repertoire, grammar.graph, lead)

    def _network(self, found: Transitions, words: bool | None, wish: Wish, holding: Mask | None) -> Network:
        """The network, with the grammar's words, of the part that holds most of some frames; the largest for None."""
        at_states = "" if wish.from_state is None else "from" if wish.to_state is None else "from and to"
        key = words, at_states, b"" if holding is None else holding.tobytes()
        if key not in self._networks:
            grammar = None if words is None else self._grammars[words]
            seams = () if grammar is None or not at_states else self._seams(grammar, wish)
            with warnings.catch_warnings():
                # what was pruned is told in the result
                warnings.simplefilter("ignore", UserWarning)
                net = networks.network(self.repertoire, transitions=found, seams=seams, holding=holding)
            self._networks[key] = (
                net if grammar is None else labels.labelled(net, grammar.graph, grammar.phrases, at_states=True)
            )
        return self._networks[key]


def prepare(
    motions: Motion | Sequence[Motion],
    *,
    skeleton: Skeleton | Motion | None = None,
    fps: float | None = None,
    mirrored: bool = True,
    backwards: bool = False,
    threshold: float | None = None,
    mapping: Mapping[str, object] | None = None,
    edits: Edits | None = None,
    progress: Progress = silent,
) -> Material:
    """Make recordings ready to perform from, once, for any number of performances ([Schultz2012] §4.4).

        >>> material = kx.prepare([walk, turn])
        >>> for seed in range(10):
        ...     new = kx.perform(material, seconds=10, seed=seed)

    `kinesics.perform` and `kinesics.performance` give the very same movement of it as of the recordings; `kinesics.Avatar` performs
    live. What is wished for by the grammar's words (a state, a class) has that read when it is first asked for.

    Parameters
    ----------
    motions, skeleton, fps, mirrored, backwards, threshold, mapping, edits, progress : as of `kinesics.performance`.

    Raises
    ------
    InputError, SkeletonError
        As `kinesics.performance`, as far as it lies with the recordings.
    """
    progress(0.0, "bringing the recordings together")
    material = Material(
        motions,
        skeleton=skeleton,
        fps=fps,
        mirrored=mirrored,
        backwards=backwards,
        threshold=threshold,
        mapping=mapping,
        edits=edits,
    )
    material.ground(Wish.of(), lambda share, message="": progress(0.2 + 0.8 * share, message))
    progress(1.0, "ready")
    return material


def beginning(net: Network, wish: Wish, seed: int) -> int | None:
    """A path that begins in the state wished for; None if the way itself, or the draw, decides."""
    if wish.from_state is None or wish.to_state is not None:
        return None
    begins = np.flatnonzero(goals.states_of(net, wish.from_state, "from"))
    return int(np.random.default_rng(seed).choice(begins))


def _given(
    motions: Motion | Sequence[Motion], mapping: Mapping[str, object] | None
) -> tuple[list[Motion], tuple[str, ...]]:
    """Each recording once, understood by the user's mapping; and what was left out for having been given before."""
    if isinstance(motions, str | PathLike) or not isinstance(motions, Motion | Iterable):
        raise InputError(f"Expected motions to perform from, got {type(motions).__name__}{_read_first(motions)}.")
    given = [motions] if isinstance(motions, Motion) else list(motions)
    for k, motion in enumerate(given):
        if not isinstance(motion, Motion):
            raise InputError(
                f"Expected motions to perform from, got {type(motion).__name__} as number {k + 1}{_read_first(motion)}."
            )
    if mapping:
        for k, motion in enumerate(given):
            try:
                given[k] = anatomy.understood(motion, mapping)
            except SkeletonError as error:
                name = motion.source.file_name or motion.name or f"recording {k + 1}"
                raise SkeletonError(f"{name}: {error}", found=error.found, missing=error.missing) from error
    once: list[Motion] = []
    said: list[str] = []
    for motion in given:
        same = next((other for other in once if _same(motion, other)), None)
        if same is None:
            once.append(motion)
            continue
        name, first = (m.source.file_name or m.name or "a recording" for m in (motion, same))
        said.append(
            f"{name} was given more than once: used once"
            if name == first
            else f"{name} holds the very movement of {first}: used once, as {first}"
        )
    return once, tuple(dict.fromkeys(said))


def _usable(motions: list[Motion]) -> tuple[list[Motion], tuple[str, ...]]:
    """Those that something can be performed of, and which are left out, and why; all of them where none can."""
    kept: list[Motion] = []
    said: list[str] = []
    for k, motion in enumerate(motions):
        name = motion.source.file_name or motion.name or f"recording {k + 1}"
        if motion.frame_count < 2:
            said.append(f"{name} is left out: a single pose, in which nothing moves")
        elif motion.fps < LEAST_FPS:
            said.append(
                f"{name} is left out: it has {motion.fps:g} frames a second, fewer than the {LEAST_FPS:g} it takes to perform; if "
                "the file is wrong about its rate, read it with the right one (`kinesics.read(…, fps=…)`)"
            )
        else:
            kept.append(motion)
    return (kept, tuple(said)) if kept else (motions, ())


def _read_first(given: object) -> str:
    if isinstance(given, Material):
        return ", which is prepared already: give it alone, as it is, to kx.perform, kx.performance or kx.Avatar"
    return ": read the file first, kx.read(…)" if isinstance(given, str | PathLike) else ""


def _same(a: Motion, b: Motion) -> bool:
    """Whether two recordings are one, to the last bit."""
    if a is b:
        return True
    if a.fps != b.fps or a.rotations.shape != b.rotations.shape or not a.skeleton.same_tree(b.skeleton):
        return False
    pairs = [
        (a.skeleton.offsets, b.skeleton.offsets),
        (a.root_positions, b.root_positions),
        (a.rotations, b.rotations),
        (a.joint_translations, b.joint_translations),
    ]
    return all(x is y or (x is not None and y is not None and np.array_equal(x, y)) for x, y in pairs)
