"""The Markov controller: which path comes next, decision by decision ([Schultz2012] §4.4, §4.4.1).

At the end of each path the next is drawn from the row of P that belongs to it, Pᵢⱼ = E(j)·δᵢⱼ, where δ says which paths may
follow (the network) and E how much each is wished for now (`kinesics.synthesis.goals`):

    E(j) = exp(−β Σₖ wₖ [fₖ(αⱼ) − fₖ(t)]²)

As corrected (CONVENTIONS.md): rows are normalised to sum 1, the largest exponent subtracted first. β = 0 is a stroll, every path
that may follow as likely as any other; a large β always takes the best.

Beyond the dissertation, and only if `lookahead` is not 0: the features of path j are those of the best composite that begins
with it (`kinesics.synthesis.paths.prospects`). The rest of the composite whose beginning was just played competes with
those of the bundle, lest a turn be put off for ever. So the decision depends on path, place, heading and that plan and on nothing
before: still Markov, in a larger state. Only wishes that remember (Novelty) look back. With ``lookahead=0`` there is no plan.
Composites that do not come to the target count by the seconds that it takes from where they end (`kinesics.synthesis.paths.togo`).
The first path is drawn by E, too, if there is somewhere to go, to a small power: one sets out at once, but not always alike.

Also beyond it: `bend`. The way of a path over the floor may be bent a little towards the goal, evenly with the metres walked, as
if the floor had been turned under the feet; standing, nothing is turned. ``bend=0`` leaves every path as it was recorded.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.synthesis.control.intentions import Composite, Intentions
from kinesics.synthesis.control.stopping import Stop
from kinesics.synthesis.control.weighing import Row, Weighing, drawn
from kinesics.synthesis.goals import Feature, Goal, OwnFeature, Pursuit, Situation, Target, ToPlaces, TrailPursuit
from kinesics.synthesis.goals.pursuit import listed
from kinesics.synthesis.paths.laying import Laying, Step
from kinesics.synthesis.paths.prospects import LOOKAHEAD, Prospects, prospects

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

BETA: Final = 100.0
"""Default β: near a beeline, but of two ways as good either may be taken."""
BEND: Final = 5.0
"""Default greatest bend, degrees a metre: some 3.5° a step of walking."""
WIDEST: Final = 90.0
"""Greatest bend that may be asked for, degrees a metre: a turn on the spot, nearly."""
HOLD: Final = 0.2
"""Seconds that a recording is kept before it is left again, where there is a choice."""


class Frame(NamedTuple):
    """One frame for a live avatar."""

    moment: int
    """What to show: see `kinesics.synthesis.repertoire`."""
    position: tuple[float, float]
    """Of the root on the ground: x, z in metres."""
    heading: float
    """Radians about +y."""
    jump: bool
    """Whether a recording is left for another place in this frame, so that a blend begins."""


class Transition(NamedTuple):
    """A row of P."""

    paths: Indices
    """The paths that may follow, shape (successors,)."""
    probabilities: Array
    """Of each, summing to 1, shape (successors,)."""


class Controller:
    """Chooses paths one after the other, live.

    Parameters
    ----------
    network : of paths, `kinesics.synthesis.paths.network.network`.
    goal : what is wished for: a goal of `kinesics.synthesis.goals`, a `Feature` of your own, or several together. None strolls.
    beta : β ≥ 0, from a stroll (0) to always the best (infinite).
    lookahead : seconds; 0 decides by single paths, as the dissertation does.
    bend : greatest bend of the way, degrees a metre.
    hold : seconds that a recording is kept before it is left again, where there is a choice.
    seed : of everything drawn. The same network, goal and numbers give the same paths.
    start : path to begin with. Drawn if not given: with a target or route by E too, so that one sets out at once; else any.
    position, heading : x, z in metres and radians, of the root at the first frame.
    stand : whether to go and stand still, where the network lets one, when the last target is reached.
    prepared : from `synthesis.paths.prospects.prospects`, to share between controllers of one network; it then decides how far
        is looked ahead.

    Raises
    ------
    InputError
        If a number is out of range, or a goal cannot be pursued on this network.

    References
    ----------
    [Schultz2012] §4.4, §4.4.1.
    """

    def __init__(
        self,
        network: Network,
        goal: Goal | Feature | Sequence[Goal | Feature] | None = None,
        *,
        beta: float = BETA,
        lookahead: float = LOOKAHEAD,
        bend: float = BEND,
        hold: float = HOLD,
        seed: int | np.random.Generator = 0,
        start: int | None = None,
        position: tuple[float, float] = (0.0, 0.0),
        heading: float = 0.0,
        stand: bool = True,
        prepared: Prospects | None = None,
    ) -> None:
        if not beta >= 0.0:
            raise InputError(f"Expected `beta` of 0 or more (infinite: always the best), got {beta}.")
        if not (np.isfinite(bend) and 0.0 <= bend <= WIDEST):
            raise InputError(f"Expected `bend` in degrees a metre, from 0 to {WIDEST:g}, got {bend}.")
        place = np.asarray(position, dtype=np.float64)
        if place.shape != (2,) or not np.isfinite(place).all() or not np.isfinite(heading):
            raise InputError(
                f"Expected `position` x, z and `heading` in finite numbers, got {position!r}, {heading!r}."
            )
        paths = len(network.first)
        if start is not None and not 0 <= start < paths:
            raise InputError(f"Expected `start` to be a path, 0 to {paths - 1}, got {start}.")
        self.network = network
        self.prospects = prospects(network, lookahead, hold=hold) if prepared is None else prepared
        if len(self.prospects.start) != len(network.indices) + 1:
            raise InputError("`prepared` was made for another network.")
        self._bend = float(np.radians(bend))
        self._rng = np.random.default_rng(seed)
        self._start = start
        self._stand = stand
        self._laying = Laying(network)
        self._intentions = Intentions(self._laying, self.prospects)
        self._weighing = Weighing(network, self.prospects, self._intentions, float(beta), self._bend, float(hold))
        self._moment = np.asarray(network.first).tolist()
        self._fps = float(network.repertoire.fps)
        self.now = Situation(
            place=complex(place[1], place[0]),
            heading=float(heading),
            last_played=np.full(paths, -np.inf),
            plays=np.zeros(paths, dtype=np.intp),
        )
        self._pursuits: list[Pursuit] = []
        self._queue: list[int] = []
        self._stopping: Stop | None = None
        self._braking = False
        self._intention: Composite | None = None
        self._frames: Iterator[Frame] | None = None
        self.pursue(goal)

    def pursue(self, goal: Goal | Feature | Sequence[Goal | Feature] | None) -> None:
        """Wish for something else from the next decision on.

        Whatever the decisions need is computed here and kept, so that none of them waits for it. Most wishes need a fraction of
        a millisecond. The first target of a radius asks for the seconds to go to it, up to a second of work on some hundred
        paths: `prepare` does that beforehand (`choices` does it for targets of the usual radius). Before anything is performed,
        where to begin is weighed here, too.

        Raises
        ------
        InputError
            If it cannot be pursued here.
        """
        pursuits = self._ready(goal)
        self._pursuits, self._queue, self._braking, self._intention = pursuits, [], False, None
        self._weighing.pursuits = pursuits
        if self.now.path < 0:
            self._begins = self._opening()

    def prepare(self, goal: Goal | Feature | Sequence[Goal | Feature] | None) -> None:
        """Compute what `pursue` would have to for such a wish, to be kept: it is then taken up at once.

        Targets want the same wherever they are, if their radius is the same. Raises InputError if it cannot be pursued here.
        """
        self._ready(goal)

    def _ready(self, goal: Goal | Feature | Sequence[Goal | Feature] | None) -> list[Pursuit]:
        """What pursues a wish, all computed that decisions ask for."""
        pursuits: list[Pursuit] = []
        for one in listed(goal):
            if hasattr(one, "pursuit"):
                pursuits.append(one.pursuit(self.network, self.prospects))
            elif isinstance(one, Feature):
                pursuits.append(OwnFeature(one).pursuit(self.network, self.prospects))
            else:
                raise InputError(
                    f"Expected a goal (Target, Route, Favour, …) or a feature with `weight`, `values` and `wish`, got {one!r}."
                )
        for pursuit in pursuits:
            pursuit.prepare(self._weighing.bend_of(pursuit))
        if self._stand and self._stopping is None and any(isinstance(p, ToPlaces) for p in pursuits):
            self._stopping = Stop(self.network, self._laying)
        return pursuits

    @property
    def attained(self) -> bool:
        """Whether every goal that can be attained was; False if there is none such."""
        ends = [p.done(self.now) for p in self._pursuits]
        ends = [done for done in ends if done is not None]
        return bool(ends) and all(ends)

    @property
    def finished(self) -> bool:
        """Whether the goals are attained and the performer, if it is to stand, stands."""
        if not self.attained or self._queue:
            return False
        stop = self._stopping
        if stop is None or not stop.possible or self._last_target() is None:
            return True
        return bool(stop.still[self.now.path])

    def outcome(self) -> tuple[str, ...]:
        """What came of each goal so far, in words."""
        said = (p.outcome() for p in self._pursuits)
        return tuple(words for words in said if words)

    def transition(self) -> Transition:
        """The row of P for the next decision."""
        if self.now.path < 0:
            return self._begins
        weighing, now = self._weighing, self.now
        row = weighing.row(now, weighing.misses(now), weighing.planned(self._intention, now))
        return Transition(row.paths, row.probabilities)

    def step(self, frames: int | None = None) -> Step:
        """Decide for the next path, and be at its end.

        Parameters
        ----------
        frames : for how many of its frames there is time, where it is the last and may be cut short: what would come after
            them attains nothing. All if not given.
        """
        thinking = self._decide()
        while True:
            try:
                next(thinking)
            except StopIteration as decided:
                path, bend = decided.value
                return self._play(path, bend, frames)

    def choices(self) -> Iterator[tuple[int, float] | None]:
        """What `kinesics.synthesis.live.renderer.LiveRenderer` asks for: paths, and by how many radians each is turned besides.

        Each decision is made in parts, None after each but the last, so that none takes long. Whatever is wished for
        meanwhile (`pursue`) counts: it is then thought over anew. The paths are those of `step`. Tables that decisions ask for
        are computed now, those for targets of the usual radius included.
        """
        self.prospects.fill()
        self.prepare(Target((0.0, 0.0)))
        return self._chosen()

    def _chosen(self) -> Iterator[tuple[int, float] | None]:
        while True:
            path, bend = yield from self._decide()
            step = self._play(path, bend)
            yield step.path, step.turned

    def be_at(self, place: complex, heading: float) -> None:
        """Reckon from here on with where the body truly is at the end of the path decided for last.

        Parameters
        ----------
        place, heading : z + i·x, metres; and radians.
        """
        now = self.now
        now.place = place
        now.heading += math.remainder(heading - now.heading, 2.0 * math.pi)
        for pursuit in self._pursuits:
            pursuit.carried()

    def frame(self) -> Frame:
        """The next frame for a live avatar: decides whenever a path has been played to its end."""
        if self._frames is None:
            self._frames = self._live()
        return next(self._frames)

    def way(self, step: Step) -> tuple[NDArray[np.complex128], Array]:
        """Places (z + i·x, metres) and headings (radians) of the frames of a path as played, and the entry into the next:
        shapes (length + 1,).
        """
        return self._laying.way(step)

    def _live(self) -> Iterator[Frame]:
        while True:
            before = self.now.path
            step = self.step()
            jump = before >= 0 and self._laying.goes_on[before] != step.path
            places, headings = self.way(step)
            first = int(self._moment[step.path])
            moments = self.network.repertoire.advance(first, np.arange(len(places) - 1)).tolist()
            for moment, place, heading in zip(moments, places.tolist(), headings.tolist(), strict=False):
                yield Frame(moment, (place.imag, place.real), heading, jump)
                jump = False

    def _decide(self) -> Generator[None, None, tuple[int, float]]:
        """The next path and its bend; in parts."""
        while True:
            wishes = self._pursuits
            at_once = self._without_choice()
            if at_once is not None:
                return at_once, 0.0
            missed = self._weighing.misses(self.now)
            yield
            if self._pursuits is not wishes:
                continue
            planned = self._weighing.planned(self._intention, self.now)
            if planned is not None:
                yield
            if self._pursuits is not wishes:
                continue
            drawing = self._rng.bit_generator.state
            taken = self._taken(self._weighing.row(self.now, missed, planned))
            yield
            if self._pursuits is wishes:
                return taken
            self._rng.bit_generator.state = drawing

    def _without_choice(self) -> int | None:
        """The next path where rows of P are not asked: one that was planned, the first, one on the way to a stance."""
        now = self.now
        for pursuit in self._pursuits if not self._queue else ():
            plan = pursuit.plan(now)
            if plan:
                self._queue = plan
        if self._queue:
            return self._queue.pop(0)
        if now.path < 0:
            return drawn(self._begins.probabilities, self._rng)
        stop, goal = self._stopping, self._last_target()
        if stop is not None and stop.possible and goal is not None:
            self._braking = self._braking or goal.done(now) or stop.ends_at(now, goal)
            if self._braking:
                return stop.next(now, self._rng)
        return None

    def _taken(self, row: Row) -> tuple[int, float]:
        """One of a row of P, and its bend; what is intended behind it is remembered."""
        chosen = row.drawn(self._rng)
        composite = row.best(chosen)
        bend = 0.0
        if self._bend > 0.0:
            for pursuit in self._pursuits:
                if isinstance(pursuit, TrailPursuit) and pursuit.steers:
                    bend = pursuit.bend(composite.trail, self.now, self._bend)
                    break
        led = any(isinstance(pursuit, TrailPursuit) for pursuit in self._pursuits)
        self._intention = self._intentions.after(composite, self.now) if led else None
        return int(row.paths[chosen]), bend

    def _last_target(self) -> ToPlaces | None:
        for pursuit in self._pursuits:
            if isinstance(pursuit, ToPlaces) and pursuit.last:
                return pursuit
        return None

    def _opening(self) -> Transition:
        """Where to begin: the path given, or any."""
        every = np.arange(len(self.network.first))
        if self._start is None:
            return Transition(every, self._weighing.opening(self.now))
        return Transition(every, (every == self._start).astype(np.float64))

    def _play(self, path: int, bend: float, frames: int | None = None) -> Step:
        now = self.now
        if now.path >= 0 and self._laying.goes_on[now.path] != path:
            now.since_jump = 0.0
        place, heading = self._laying.entered(now.path, path, now.place, now.heading)
        step = Step(path, bend, place, heading, bend * self._laying.walked[path])
        places, headings = self.way(step)
        times = now.time + np.arange(len(places)) / self._fps
        shown = len(places) - 1 if frames is None else min(frames, len(places) - 1)
        for pursuit in self._pursuits:
            pursuit.passed(places[:shown], times[:shown])
        now.plays[path] += 1
        now.last_played[path] = now.time
        now.path = path
        now.place, now.heading = complex(places[-1]), float(headings[-1])
        lasted = (len(places) - 1) / self._fps
        now.time += lasted
        now.since_jump += lasted
        for pursuit in self._pursuits if shown == len(places) - 1 else ():
            pursuit.note(now)
        return step
