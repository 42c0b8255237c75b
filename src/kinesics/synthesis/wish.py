"""What is wished for of a performance: checked before any work is done, its names looked up, and what it comes to."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body.motion import Motion
from kinesics.errors import InputError
from kinesics.synthesis import goals
from kinesics.synthesis.goals.arguments import check_name, place_of
from kinesics.synthesis.goals.favours import FAVOURABLE
from kinesics.synthesis.goals.naming import unknown, unusable, with_word
from kinesics.synthesis.goals.pursuit import listed
from kinesics.synthesis.paths import labels
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.paths.prospects import Prospects
from kinesics.synthesis.piece import ASIDE, aside_of, visits
from kinesics.vocabulary import MovementClass

if TYPE_CHECKING:
    from kinesics.analysis.facts import Phrase
    from kinesics.grammar.edits import Edits
    from kinesics.grammar.graph import MotionGraph
    from kinesics.synthesis.goals import Feature, Goal

Array = NDArray[np.float64]

SECONDS: Final = 20.0
"""How long is performed if neither a goal nor a time is given, and at least to be had for a goal."""
MOST_SECONDS: Final = 600.0
"""How long a goal is sought at most if no time is given."""
DETOUR: Final = 3.0
"""Times the straight way that is allowed for a goal if no time is given."""
SETTLING: Final = 10.0
"""Seconds allowed besides, to turn round and to come to a stand."""
STAYING: Final = 0.05
"""Metres a second: recordings that never get about faster stay in place."""
SURELY: Final = 1.1
"""Times the fastest pace that was found: who would have to be faster than that is not sent out."""
HARDLY: Final = 0.25
"""Metres a second, below which a way is found by chance."""
SPARE: Final = 0.12
"""Metres by which the way is led nearer to a target than it has to be: where feet are kept in place the body may come to stand a
little beside it."""
FAVOURED: Final = 1.0
"""Weight of a favoured kind of movement beside the goal."""
FRESH: Final = 0.05
"""Weight of not repeating oneself beside a favoured kind of movement."""
CALM: Final = 0.1
"""Weight of passing from recording to recording seldom and smoothly, as a share of that of not repeating oneself: a third to two
thirds of the transitions are left, and hardly a moment comes twice for it. With three times as much some recordings would be
played from end to end, which is nothing new."""
ABIDING: Final = 1.0
"""Weight of staying with a recording for two seconds, where nothing is wished for: about half of the transitions are left, and as
many moments are new within a hundredth."""
ABIDING_BESIDE: Final = 0.2
"""The same beside a favoured kind of movement: half of the transitions, and as much of what is favoured."""
SPARING: Final = 0.05
"""The same beside a target: a seventh of the transitions is saved, and the target reached as soon within a fiftieth of the time."""
SPARING_ALONG: Final = 0.02
"""The same beside a route: nearly a third is saved, and the line kept to as well."""
ONWARDS: Final = 1.0
"""Weight of not coming back at once to what was just played, whatever is wished for: three times a loop of a third of a second
weigh like one spread of anything else."""
_SUFFIXES: Final = (".bvh", ".amc", ".glb", ".gltf", ".npz")
"""Of recordings' files: a recording may be named with or without."""


class Detour(NamedTuple):
    """A place to be gone to although nobody asked for it."""

    before: int
    """Number of the place wished for that comes after it."""
    place: tuple[float, float]
    """x, z in metres."""


class Grammar(NamedTuple):
    """What the recordings say of states, paths and classes."""

    graph: MotionGraph
    phrases: Sequence[Phrase]


@dataclass(frozen=True, eq=False)
class Wish:
    """What is wished for, checked before any work is done."""

    target: goals.Target | None
    route: goals.Route | None
    from_state: str | None
    to_state: str | None
    favour: str | None
    own: tuple[Goal | Feature, ...]

    @classmethod
    def of(
        cls,
        target: ArrayLike | None = None,
        route: ArrayLike | None = None,
        from_state: str | None = None,
        to_state: str | None = None,
        favour: str | None = None,
        goal: Goal | Feature | Sequence[Goal | Feature] | None = None,
        radius: float | None = None,
    ) -> Wish:
        """From the arguments of `kinesics.perform`.

        Raises
        ------
        InputError
            If they contradict each other or are none.
        """
        where = {"target": target, "route": route, "to_state": to_state, "goal": goal}
        asked = [name for name, value in where.items() if value is not None]
        if len(asked) > 1:
            raise InputError(f"Expected one thing to go for, got {' and '.join(asked)}: give one of them.")
        if to_state is not None and from_state is None:
            raise InputError(
                f"A way to the state {to_state!r} begins in a state, too: give `from_state` (--from) beside `to_state` (--to)."
            )
        if radius is not None and target is None:
            raise InputError(
                "`radius` (--within) says how near to a `target` counts as there: give one, or leave it out."
            )
        for name, state in (("from_state", from_state), ("to_state", to_state)):
            if state is not None:
                check_name(state, f"a state in `{name}`")
        if favour is not None:
            check_name(favour, FAVOURABLE)
        own = listed(goal)
        for one in own:
            if isinstance(one, type):
                raise InputError(f"Expected a goal, got the class {one.__name__} itself: give {one.__name__}(…).")
        return cls(
            None
            if target is None
            else goals.Target(place_of(target, "target"), goals.RADIUS if radius is None else radius),
            None if route is None else goals.Route(route),
            from_state,
            to_state,
            favour,
            own,
        )

    @property
    def ends(self) -> bool:
        """Whether there is something to be attained."""
        return bool(self.target or self.route or self.to_state or self.own)

    @property
    def attainable(self) -> bool:
        """Whether it is something that can be said not to have been attained: a moving target or a speed never is."""
        known = goals.Target | goals.Targets | goals.Route | goals.StateToState
        return bool(self.target or self.route or self.to_state or any(isinstance(g, known) for g in self.own))

    @property
    def _to_places(self) -> goals.Target | goals.Targets | None:
        """The goal that leads to places, where there is just one such."""
        if self.target is not None:
            return self.target
        led = [g for g in self.own if isinstance(g, goals.Target | goals.Targets)]
        return led[0] if len(led) == 1 else None

    @property
    def places(self) -> tuple[tuple[float, float], ...]:
        """Places to be reached one after the other."""
        goal = self._to_places
        return () if goal is None else (goal.position,) if isinstance(goal, goals.Target) else tuple(goal.positions)

    @property
    def radius(self) -> float:
        """How near to a place counts as there; 0 without one."""
        goal = self._to_places
        return 0.0 if goal is None else goal.radius

    @property
    def metres(self) -> float:
        """The straight way to it."""
        if self.route is not None:
            x, z = np.asarray(self.route.points)[0].tolist()
            return self.route.length + math.hypot(x, z)
        return sum(math.dist(a, b) for a, b in itertools.pairwise(((0.0, 0.0), *self.places)))

    @property
    def least_metres(self) -> float:
        """The shortest way that counts: to the edge of the last place, across those before."""
        nearer = goals.RADIUS if self.route is not None else self.radius * (2 * len(self.places) - 1)
        return max(0.0, self.metres - nearer)

    def most_seconds(self, ahead: Prospects, seconds: float | None, linger: bool = False) -> float:
        """How long may be performed: ``seconds``, or what the goal may take.

        Parameters
        ----------
        linger : whether all of ``seconds`` is performed in any case, so that one may go towards what is too far.

        Raises
        ------
        InputError
            If there is somewhere to go, and the recordings stay in place, or it cannot be come to in that time, or not within
            `MOST_SECONDS`, or they hardly get about and no time was asked for.
        """
        away = self.metres - self.radius
        if away > 0.0 and ahead.pace < STAYING:
            raise InputError(
                f"These recordings stay in place (at most {ahead.pace:.2g} metres a second in a straight line): no "
                f"{'target' if self.places else 'route'} can be reached with them. Give recordings that go about, "
                "or perform without a place to go to."
            )
        if away <= 0.0:
            return float(seconds) if seconds is not None else MOST_SECONDS if self.to_state is not None else SECONDS
        usual = SETTLING + self.metres / ahead.pace
        most = min(MOST_SECONDS, max(SECONDS, SETTLING + DETOUR * self.metres / ahead.pace))
        given = most if seconds is None else float(seconds)
        reach = (
            f"reach the target {self.metres:.1f} m off"
            if self.places
            else f"come to the end of a route of {self.metres:.1f} m"
        )
        nearer = f"{'a nearer target' if self.places else 'a shorter route'}"
        least = self.least_metres / (SURELY * ahead.fastest)
        if given < least and not linger:
            raise InputError(
                f"These recordings cannot {reach} in {given:g} s: at {ahead.fastest:.2f} metres a second, the "
                f"fastest there is in them, it takes {least:.0f} s at least, and some {_rounded(usual)} s as a rule. Give as "
                f"many `seconds` (--seconds) or {nearer}; with `linger` (--linger) they go towards it for as long as is given."
            )
        if seconds is None and ahead.pace < HARDLY and usual - SETTLING > SECONDS:
            raise InputError(
                f"These recordings hardly get about ({ahead.pace:.2f} metres a second in a straight line): to {reach} they "
                f"would take some {_rounded(usual)} s, and as likely as not never come there. Give {nearer}, of "
                f"{SECONDS * ahead.pace:.1f} m at most; or say how long to try, `seconds` (--seconds)."
            )
        return given

    def may_try_again(self, seconds: float, fastest: float) -> bool:
        """Whether, where the first draw does not lead there, another may: ``fastest`` in metres a second."""
        return bool(self.places or self.route is not None) and self.least_metres <= seconds * fastest

    def miss(self, trail: Array, attained: bool) -> tuple[float, float]:
        """How many places were not reached, and metres from the next; 0 and 0 if all were.

        Of a route, if it was not attained or left aside, 1 and metres: how far aside of it the way is, and how far from its end it
        ends.
        """
        if self.places:
            there = visits(trail, self.places, self.radius)
            if len(there) == len(self.places):
                return 0.0, 0.0
            since = trail[there[-1] if there else 0 :]
            return float(len(self.places) - len(there)), float(np.hypot(*(since - self.places[len(there)]).T).min())
        if attained and (self.route is None or aside_of(trail, np.asarray(self.route.points)) <= ASIDE):
            return 0.0, 0.0
        if self.route is None:
            return 1.0, 0.0
        left = 0.0 if attained else float(np.hypot(*(trail[-1] - np.asarray(self.route.points)[-1])))
        return 1.0, aside_of(trail, np.asarray(self.route.points)) + left

    def by_name(self, motions: Sequence[Motion], names: Sequence[str]) -> Wish:
        """With the name of a recording in place of that of its file, where that is favoured."""
        if self.favour is None or self.favour in names or not self.favour.lower().endswith(_SUFFIXES):
            return self
        whose = [n for m, n in zip(motions, names, strict=True) if m.source.file_name == self.favour]
        return dataclasses.replace(self, favour=whose[0] if whose else self.favour.rpartition(".")[0])

    def goals(self, via: Detour | None = None, most: float = math.inf) -> list[Goal | Feature]:
        """For the controller; something new all the time, where nothing is wished for.

        Parameters
        ----------
        via : a place to be gone to besides.
        most : seconds that there are.
        """
        led = self._to_places
        out: list[Goal | Feature] = [g for g in self.own if g is not led]
        if led is not None:
            out.append(_aimed(led, via))
        if self.route is not None:
            out.append(self.route)
        if self.target is not None or self.route is not None:
            out.append(goals.Economy(weight=SPARING if self.route is None else SPARING_ALONG))
        if self.to_state is not None:
            assert self.from_state is not None
            out.append(goals.StateToState(self.from_state, self.to_state, lead=goals.LEAD, most=most))
        goes_somewhere = bool(out)
        out.append(goals.Onwards(weight=ONWARDS))
        if self.favour is not None:
            out.append(goals.Favour(self.favour, weight=FAVOURED))
        if not goes_somewhere:
            fresh = 1.0 if self.favour is None else FRESH
            abiding = ABIDING if self.favour is None else ABIDING_BESIDE
            out += [goals.Novelty(weight=fresh), goals.Economy(weight=CALM * fresh), goals.Abiding(weight=abiding)]
        return out

    def plain(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "target": None if self.target is None else list(self.target.position),
            "radius": None if self.target is None else float(self.target.radius),
            "route": None if self.route is None else np.asarray(self.route.points).tolist(),
            "from_state": self.from_state,
            "to_state": self.to_state,
            "favour": self.favour,
            "goal": [repr(g) if dataclasses.is_dataclass(g) else type(g).__name__ for g in self.own],
        }


def _aimed(led: goals.Target | goals.Targets, via: Detour | None) -> goals.Target | goals.Targets:
    """Somewhat nearer than asked for, and by way of a place besides."""
    radius = max(led.radius - SPARE, 0.5 * led.radius)
    aims = [led.position] if isinstance(led, goals.Target) else list(led.positions)
    if via is not None:
        aims.insert(via.before, via.place)
    if len(aims) == 1:
        return goals.Target(aims[0], radius, led.weight)
    return goals.Targets(aims, radius, led.weight)


def _rounded(seconds: float) -> int:
    """Up, to ten."""
    return 10 * math.ceil(seconds / 10.0)


def names_recordings(word: str, names: Sequence[str], edits: Edits | None) -> bool:
    """Whether a word can only mean recordings, so that the grammar need not be read for it."""
    if word in names:
        return True
    small = word.isalpha() and word.islower()
    return small and edits is None and word not in tuple(MovementClass) and bool(with_word(word, names))


def check_states(wish: Wish, graph: MotionGraph) -> None:
    """Refuse states that are nowhere in the recordings, before transitions are looked for."""
    there = {state.label for state in graph.racemic().states}
    for what, name in (("state to begin in", wish.from_state), ("state to go to", wish.to_state)):
        if name is not None and name not in there:
            raise InputError(unknown(what, name, there))


def check_names(net: Network, wish: Wish, grammar: Grammar) -> None:
    """Refuse what the grammar knows but nothing of which can be performed."""
    graph = grammar.graph.racemic()
    states = {s.label for s in graph.states}
    for state, there in ((wish.from_state, net.state_from), (wish.to_state, net.state_to)):
        if state in states and state not in there:
            raise InputError(
                f"The state {state!r} is in the recordings, but no transition leads {'from' if there is net.state_from else 'to'} "
                "it and back again. Give longer recordings, in which it returns; or ask for one of: "
                f"{', '.join(sorted(set(there) - {''}))}."
            )
    known = states | {p.label for p in graph.paths} | {p.class_ or "" for p in grammar.phrases}
    known |= {p.name or "" for p in grammar.phrases}
    if net.repertoire.recording_count == 1:
        known |= {labels.kind_name(p.kind) for p in grammar.phrases}
    if wish.favour in known - {""} and not any(
        wish.favour in words for words in (net.class_, net.label, net.state_from, net.state_to, net.phrase)
    ):
        raise unusable([wish.favour], recordings=False)


def favoured(net: Network, wish: Wish) -> tuple[str, ...]:
    """What a word was taken to mean, where it is no name."""
    if wish.favour is None:
        return ()
    recordings = {net.repertoire.names[k] for k in np.unique(net.recording).tolist()}
    if any(
        wish.favour in words for words in (net.class_, net.label, net.state_from, net.state_to, net.phrase, recordings)
    ):
        return ()
    meant = [n for words in (net.class_, net.phrase) for n in with_word(wish.favour, set(words), whole=True)]
    meant += with_word(wish.favour, recordings)
    return (f"favoured as {wish.favour!r}: {', '.join(meant)}",)
