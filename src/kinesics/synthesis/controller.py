"""The Markov controller: which path comes next, decision by decision ([Schultz2012] §4.4, §4.4.1).

At the end of each path the next is drawn from the row of P that belongs to it, Pᵢⱼ = E(j)·δᵢⱼ, where δ says which paths may
follow (the network) and E how much each is wished for now (`kinesics.synthesis.goals`):

    E(j) = exp(−β Σₖ wₖ [fₖ(αⱼ) − fₖ(t)]²)

As corrected (CONVENTIONS.md): rows are normalised to sum 1, the largest exponent subtracted first. β = 0 is a stroll, every path
that may follow as likely as any other; a large β always takes the best.

Beyond the dissertation, and only if `lookahead` is not 0: the features of path j are those of the best composite that begins
with it (`kinesics.synthesis.prospects`). The rest of the composite whose beginning was just played competes with
those of the bundle, lest a turn be put off for ever. So the decision depends on path, place, heading and that plan and on nothing
before: still Markov, in a larger state. Only wishes that remember (Novelty) look back. With ``lookahead=0`` there is no plan.
Composites that do not come to the target count by the seconds that it takes from where they end (`kinesics.synthesis.togo`).
The first path is drawn by E, too, if there is somewhere to go, to a small power: one sets out at once, but not always alike.

Also beyond it: `bend`. The way of a path over the floor may be bent a little towards the goal, evenly with the metres walked, as
if the floor had been turned under the feet; standing, nothing is turned. ``bend=0`` leaves every path as it was recorded.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.synthesis import faults, ways
from kinesics.synthesis.goals import Feature, Goal, OwnFeature, Pursuit, Situation, ToPlaces, TrailPursuit
from kinesics.synthesis.goals.pursuit import listed
from kinesics.synthesis.prospects import AT_ONCE, LOOKAHEAD, Prospects, Trail, Trails, prospects, trails

if TYPE_CHECKING:
    from kinesics.synthesis.network import Network

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
TOO_SOON: Final = 1.0
"""What leaving a recording sooner weighs, in squared spreads, where all else comes back at once: no loop is a prison."""
LEAPING: Final = 1.0
"""What every path weighs in which the recording leaps (`kinesics.synthesis.faults`), in squared spreads: it is gone round where
that costs less."""
OPENING: Final = 0.02
"""Where to begin is drawn by E to this power: so that other seeds begin otherwise, and none by standing about."""
LONGEST: Final = 24 * 3600.0
"""Seconds; nothing longer is performed in one go."""


class Step(NamedTuple):
    """One decision: a path and how its way is bent."""

    path: int
    bend: float
    """Radians a metre, positive to the left."""
    place: complex
    """z + i·x at its first frame, metres."""
    heading: float
    """At its first frame, radians."""
    turned: float
    """Radians that the whole path is bent by: what `kinesics.synthesis.live` needs beside the path."""


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


@dataclass(frozen=True, eq=False)
class Course:
    """What was decided, and the way over the floor that it makes: what rendering needs."""

    paths: Indices
    """Paths in the order played, shape (n,)."""
    bends: Array
    """Bend of each, radians a metre, shape (n,)."""
    begins: Indices
    """Frame at which each begins, shape (n,); the last may be cut short by the end."""
    moments: Indices
    """What each frame plays, shape (frames,)."""
    ground: Array
    """Root on the ground: x, z in metres, shape (frames, 2)."""
    yaw: Array
    """Heading, radians about +y, not wrapped, shape (frames,)."""
    fps: float
    attained: bool
    """Whether every goal that can be attained was."""
    outcome: tuple[str, ...]
    """What came of each goal, in words."""

    @property
    def seconds(self) -> float:
        """How long it lasts."""
        return len(self.moments) / self.fps

    @property
    def length(self) -> float:
        """Metres walked by the root."""
        return float(np.hypot(*np.diff(self.ground, axis=0).T).sum()) if len(self.ground) > 1 else 0.0

    @property
    def repeats(self) -> int:
        """How many plays are of a path that was played before."""
        return len(self.paths) - len(np.unique(self.paths))

    @property
    def most_plays(self) -> int:
        """How often the path played most was played."""
        return int(np.bincount(self.paths).max()) if len(self.paths) else 0


class Controller:
    """Chooses paths one after the other, live.

    Parameters
    ----------
    network : of paths, `kinesics.synthesis.network.network`.
    goal : what is wished for: a goal of `kinesics.synthesis.goals`, a `Feature` of your own, or several together. None strolls.
    beta : β ≥ 0, from a stroll (0) to always the best (infinite).
    lookahead : seconds; 0 decides by single paths, as the dissertation does.
    bend : greatest bend of the way, degrees a metre.
    hold : seconds that a recording is kept before it is left again, where there is a choice.
    seed : of everything drawn. The same network, goal and numbers give the same paths.
    start : path to begin with. Drawn if not given: with a target or route by E too, so that one sets out at once; else any.
    position, heading : x, z in metres and radians, of the root at the first frame.
    stand : whether to go and stand still, where the network lets one, when the last target is reached.
    prepared : from `kinesics.synthesis.prospects.prospects`, to share between controllers of one network; it then decides how far
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
        self.beta = float(beta)
        self._bend = float(np.radians(bend))
        self._hold = float(hold)
        self._rng = np.random.default_rng(seed)
        self._start = start
        self._stand = stand
        self._trails: Trails = trails(network)
        self._ends = self._trails.start + np.asarray(network.length, dtype=np.intp)
        self._indptr = np.asarray(network.indptr).tolist()
        self._rows = self.prospects.start.tolist()
        self._displacement = self._trails.places[self._ends].tolist()
        self._turn = self._trails.headings[self._ends].tolist()
        self._walked = self._trails.travelled[self._ends].tolist()
        self._duration = np.asarray(network.duration, dtype=np.float64).tolist()
        leaps = np.flatnonzero(np.asarray(network.cost) > 0.0)
        owners = np.searchsorted(network.indptr, leaps, side="right") - 1
        place_met, turn_met = network.met
        self._met: dict[tuple[int, int], tuple[complex, float]] = dict(
            zip(
                zip(owners.tolist(), np.asarray(network.indices)[leaps].tolist(), strict=True),
                zip(place_met[leaps].tolist(), turn_met[leaps].tolist(), strict=True),
                strict=True,
            )
        )
        # the path with which each one's recording goes on
        free = np.flatnonzero(np.asarray(network.cost) == 0.0)
        goes_on = np.full(paths, -1, dtype=np.intp)
        goes_on[np.searchsorted(network.indptr, free, side="right") - 1] = network.indices[free]
        self._goes_on = goes_on.tolist()
        self._moment = np.asarray(network.first).tolist()
        leaping = faults.of_paths(network)
        # of a path that is not there (-1) nothing
        self._leaping = np.append(LEAPING * leaping, 0.0) if leaping.any() else None
        self._fps = float(network.repertoire.fps)
        self.now = Situation(
            place=complex(place[1], place[0]),
            heading=float(heading),
            last_played=np.full(paths, -np.inf),
            plays=np.zeros(paths, dtype=np.intp),
        )
        self._pursuits: list[Pursuit] = []
        self._queue: list[int] = []
        self._stopping: _Stop | None = None
        self._braking = False
        self._intention: _Composite | None = None
        self._frames: Iterator[Frame] | None = None
        self.pursue(goal)

    def pursue(self, goal: Goal | Feature | Sequence[Goal | Feature] | None) -> None:
        """Wish for something else from the next decision on. Raises InputError if it cannot be pursued here."""
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
            pursuit.prepare(self._bend if isinstance(pursuit, TrailPursuit) and pursuit.steers else 0.0)
        self._pursuits, self._queue, self._braking, self._intention = pursuits, [], False, None
        if self._stand and self._stopping is None and any(isinstance(p, ToPlaces) for p in pursuits):
            stop = _Stop(self.network, self._trails)
            self._stopping = stop if stop.possible else None

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
        return self._stopping is None or self._last_target() is None or bool(self._stopping.still[self.now.path])

    def outcome(self) -> tuple[str, ...]:
        """What came of each goal so far, in words."""
        said = (p.outcome() for p in self._pursuits)
        return tuple(words for words in said if words)

    def transition(self) -> Transition:
        """The row of P for the next decision."""
        if self.now.path < 0:
            return self._opening()
        row = self._row(self._weigh())
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
        """What `kinesics.synthesis.live.LiveRenderer` asks for: paths, and by how many radians each is turned besides.

        Each decision is made in parts, None after each but the last, so that none takes long. Whatever is wished for
        meanwhile (`pursue`) counts: it is then thought over anew. The paths are those of `step`. Tables that decisions ask for
        are computed now.
        """
        self.prospects.fill()
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
        part = slice(int(self._trails.start[step.path]), int(self._ends[step.path]) + 1)
        places, headings = self._trails.places[part], self._trails.headings[part]
        if step.bend != 0.0:
            travelled = self._trails.travelled[part]
            strides = np.diff(places) * np.exp(0.5j * step.bend * (travelled[1:] + travelled[:-1]))
            places = np.concatenate([[0.0], np.cumsum(strides)])
            headings = headings + step.bend * travelled
        return step.place + places * np.exp(1j * step.heading), step.heading + headings

    def _live(self) -> Iterator[Frame]:
        while True:
            before = self.now.path
            step = self.step()
            jump = before >= 0 and self._goes_on[before] != step.path
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
            weighed = self._weigh()
            if self._intention is not None:
                yield
                if self._pursuits is not wishes:
                    continue
            row = self._row(weighed)
            yield
            if self._pursuits is wishes:
                return self._taken(row)

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
            opening = self._opening()
            return int(opening.paths[_drawn(opening.probabilities, self._rng)])
        stop, goal = self._stopping, self._last_target()
        if stop is not None and goal is not None:
            self._braking = self._braking or goal.done(now) or stop.ends_at(now, goal)
            if self._braking:
                return stop.next(now, self._rng)
        return None

    def _taken(self, row: _Row) -> tuple[int, float]:
        """One of a row of P, and its bend; what is intended behind it is remembered."""
        chosen = _drawn(row.probabilities, self._rng)
        composite = row.best(chosen)
        bend = 0.0
        if self._bend > 0.0:
            for pursuit in self._pursuits:
                if isinstance(pursuit, TrailPursuit) and pursuit.steers:
                    bend = pursuit.bend(composite.trail, self.now, self._bend)
                    break
        self._intention = self._after(composite)
        return int(row.paths[chosen]), bend

    def _last_target(self) -> ToPlaces | None:
        for pursuit in self._pursuits:
            if isinstance(pursuit, ToPlaces) and pursuit.last:
                return pursuit
        return None

    def _weigh(self) -> Array:
        """What all composites miss that may come next."""
        now = self.now
        low, high = self._indptr[now.path], self._indptr[now.path + 1]
        rows = slice(self._rows[low], self._rows[high])
        miss = self._misses(rows)
        if now.since_jump < self._hold:
            hasty = self.prospects.first_jump[rows] + now.since_jump < self._hold
            if hasty.any() and not hasty.all():
                miss[hasty] += np.inf if self._leads_on(rows, ~hasty) else TOO_SOON
        return miss

    def _leads_on(self, rows: slice, which: NDArray[np.bool_]) -> bool:
        """Whether any of some composites does not come back at once: who can only go round and round has no choice."""
        if (self.prospects.first_jump[rows][which] >= AT_ONCE).any():
            return True
        return bool((self.prospects.again(rows)[which].min(axis=1) >= AT_ONCE).any())

    def _row(self, miss: Array) -> _Row:
        """The row of P, of what the composites miss."""
        low, high = self._indptr[self.now.path], self._indptr[self.now.path + 1]
        first = self._rows[low]
        groups = self.prospects.start[low:high] - first
        least = np.minimum.reduceat(miss, groups)
        paths = self.network.indices[low:high]
        planned = None if self._intention is None else self._continued(self._intention)
        if planned is not None:
            least = np.where(paths == planned.paths[0], np.minimum(least, planned.miss), least)
        above = least - least.min()
        return _Row(paths, self._chances(above), miss, groups, first, planned, self.prospects)

    def _chances(self, above: Array) -> Array:
        """E of misses from which the least was subtracted, made to sum to 1."""
        if np.isinf(self.beta):
            weight = (above <= 0.0).astype(np.float64)
        elif self.beta:
            weight = np.exp(-self.beta * above)
        else:
            weight = np.isfinite(above) * 1.0
        return np.asarray(weight / weight.sum(), dtype=np.float64)

    def _opening(self) -> Transition:
        """Where to begin: the path given; else any, weighed by E where it is said whither to go."""
        every = np.arange(len(self.network.first))
        if self._start is not None:
            return Transition(every, (every == self._start).astype(np.float64))
        led = [p for p in self._pursuits if isinstance(p, TrailPursuit)]
        miss = np.zeros(len(every))
        if led:
            # composites that begin with each path, behind whichever path
            _, edge = np.unique(self.network.indices, return_index=True)
            count = self.prospects.start[edge + 1] - self.prospects.start[edge]
            group = np.cumsum(count) - count
            rows = np.repeat(self.prospects.start[edge] - group, count) + np.arange(int(count.sum()))
            trail = self.prospects.along(rows)
            for pursuit in led:
                bend = self._bend if pursuit.steers else 0.0
                miss += np.minimum.reduceat(pursuit.weigh(trail, self.now, bend), group)
        if self._leaping is not None and not self._leaping[:-1].all():
            miss[self._leaping[:-1] > 0.0] = np.inf
        return Transition(every, self._chances(OPENING * (miss - miss.min())))

    def _misses(self, rows: slice) -> Array:
        miss = np.zeros(rows.stop - rows.start)
        for pursuit in self._pursuits:
            steers = isinstance(pursuit, TrailPursuit) and pursuit.steers
            miss += pursuit.miss(rows, self.now, self._bend if steers else 0.0)
        if self._leaping is not None:
            miss += self._leaping[self.prospects.sequence[rows]].sum(axis=1)
        return miss

    def _continued(self, intention: _Composite) -> _Composite | None:
        """What was intended, followed by the best of what may come after it.

        The bundle of the last path need not hold the rest of the composite whose beginning was played; forgetting it, one would
        for ever be about to turn round.
        """
        place, heading, travelled, lasted, since_jump = 0j, 0.0, 0.0, 0.0, self.now.since_jump
        before = self.now.path
        for path in intention.paths:
            if self._goes_on[before] != path:
                since_jump = 0.0
            place, heading = self._entered(before, path, place, heading)
            place += cmath.exp(1j * heading) * self._displacement[path]
            heading += self._turn[path]
            travelled += self._walked[path]
            lasted += self._duration[path]
            since_jump += self._duration[path]
            before = path
        low, high = self._indptr[before], self._indptr[before + 1]
        rows = slice(self._rows[low], self._rows[high])
        then = self.prospects.along(rows)
        points = int(np.searchsorted(then.times[0], self.prospects.lookahead - lasted + 1e-4, side="right"))
        head, count = intention.trail, rows.stop - rows.start
        if points == 0:
            if not head.places.shape[1]:
                return None
            return _Composite(
                intention.paths, head, float(self._weighed(head)[0]) + self._chained(intention.paths, intention.paths)
            )
        turn = np.exp(1j * heading)
        swerve = self._swerve_at(self.now.path, intention.paths)
        trail = Trail(
            np.concatenate([head.times, then.times[:, :points] + np.float32(lasted)], axis=1),
            _beside(head.places, place + turn * then.places[:, :points], count),
            _beside(head.headings, heading + then.headings[:, :points], count),
            _beside(head.travelled, travelled + then.travelled[:, :points], count),
            _beside(
                head.swerve,
                swerve + turn * (then.swerve[:, :points] + 1j * travelled * then.places[:, :points]),
                count,
            ),
            _beside(head.playing, then.playing[:, :points], count),
        )
        miss = self._weighed(trail)
        if self._leaping is not None:
            miss += self._leaping[self.prospects.sequence[rows]].sum(axis=1)
        hasty = self.prospects.first_jump[rows] + since_jump < self._hold
        if not hasty.all():
            miss[hasty] = np.inf
        best = int(np.argmin(miss))
        sequence = self.prospects.sequence[rows.start + best].tolist()
        paths = list(intention.paths)
        for path in sequence:
            if path < 0 or lasted >= self.prospects.lookahead:
                break
            paths.append(path)
            lasted += self._duration[path]
        chosen = Trail._make((trail.times, *(values[best : best + 1] for values in trail[1:])))
        return _Composite(tuple(paths), chosen, float(miss[best]) + self._chained(paths, intention.paths))

    def _weighed(self, trail: Trail) -> Array:
        miss = np.zeros(len(trail.places))
        for pursuit in self._pursuits:
            if isinstance(pursuit, TrailPursuit):
                miss += pursuit.weigh(trail, self.now, self._bend if pursuit.steers else 0.0)
        return miss

    def _chained(self, paths: Sequence[int], intended: Sequence[int]) -> float:
        """What a chain of paths misses besides where it leads; of its faults those that were intended already."""
        miss = sum(p.chain(paths, self.now) for p in self._pursuits if not isinstance(p, TrailPursuit))
        return miss if self._leaping is None else miss + float(self._leaping[list(intended)].sum())

    def _entered(self, before: int, path: int, place: complex, heading: float) -> tuple[complex, float]:
        """Place and heading at the first frame of a path, from those with which the path before would have gone on."""
        if (before, path) not in self._met:
            return place, heading
        aside, turn = self._met[before, path]
        return place + cmath.exp(1j * heading) * aside, heading + turn

    def _swerve_at(self, before: int, paths: Sequence[int]) -> complex:
        """How the end of a chain of paths behind another moves if it is bent."""
        swerve, heading, travelled = 0j, 0.0, 0.0
        for path in paths:
            aside, heading = self._entered(before, path, 0j, heading)
            step = cmath.exp(1j * heading) * self._displacement[path]
            swerve += 1j * travelled * aside + 1j * (travelled + self._walked[path] / 2.0) * step
            heading += self._turn[path]
            travelled += self._walked[path]
            before = path
        return swerve

    def _after(self, composite: _Composite) -> _Composite | None:
        """What is left of a composite when its first path has been played."""
        if len(composite.paths) < 2 or not any(isinstance(p, TrailPursuit) for p in self._pursuits):
            return None
        path, trail = composite.paths[0], composite.trail
        place, heading = self._entered(self.now.path, path, 0j, 0.0)
        place += np.exp(1j * heading) * self._displacement[path]
        heading += self._turn[path]
        done = int(np.searchsorted(trail.times[0], self._duration[path] + 1e-4, side="right"))
        walked, back = np.float32(self._walked[path]), np.complex64(np.exp(-1j * heading))
        places = (trail.places[:, done:] - np.complex64(place)) * back
        # see `_continued`, the other way round
        swerve = (
            trail.swerve[:, done:] - np.complex64(self._swerve_at(self.now.path, (path,)))
        ) * back - 1j * walked * places
        rest = Trail(
            trail.times[:, done:] - np.float32(self._duration[path]),
            places,
            trail.headings[:, done:] - np.float32(heading),
            np.maximum(trail.travelled[:, done:] - walked, np.float32(0.0)),
            swerve.astype(np.complex64),
            trail.playing[:, done:],
        )
        return composite._replace(paths=composite.paths[1:], trail=rest)

    def _play(self, path: int, bend: float, frames: int | None = None) -> Step:
        now = self.now
        if now.path >= 0 and self._goes_on[now.path] != path:
            now.since_jump = 0.0
        step = Step(path, bend, *self._entered(now.path, path, now.place, now.heading), bend * self._walked[path])
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


class _Composite(NamedTuple):
    """Paths to be played one after the other, and where they lead from here, unbent."""

    paths: tuple[int, ...]
    trail: Trail
    """Of one row."""
    miss: float


class _Row(NamedTuple):
    """A row of P, and the composites that stand behind it."""

    paths: Indices
    probabilities: Array
    miss: Array
    groups: Indices
    first: int
    planned: _Composite | None
    prospects: Prospects

    def best(self, successor: int) -> _Composite:
        """The best composite that begins with a successor."""
        low = int(self.groups[successor])
        high = int(self.groups[successor + 1]) if successor + 1 < len(self.groups) else len(self.miss)
        index = low + int(np.argmin(self.miss[low:high]))
        miss = float(self.miss[index])
        if self.planned is not None and self.planned.paths[0] == self.paths[successor] and self.planned.miss < miss:
            return self.planned
        row = self.first + index
        sequence = self.prospects.sequence[row]
        paths = tuple(sequence[sequence >= 0].tolist())
        return _Composite(paths, self.prospects.along(slice(row, row + 1)), miss)


def _drawn(probabilities: Array, rng: np.random.Generator) -> int:
    chosen = int(np.searchsorted(np.cumsum(probabilities), rng.random() * (1.0 - 1e-12)))
    return min(chosen, len(probabilities) - 1)


def _beside(head: NDArray[Any], then: NDArray[Any], rows: int) -> NDArray[Any]:
    """The points of one trail before those of many."""
    points = head.shape[1]
    out = np.empty((rows, points + then.shape[1]), dtype=head.dtype)
    out[:, :points], out[:, points:] = head, then
    return out


class _Stop:
    """The quickest way from each path to a stance, and where it ends."""

    def __init__(self, network: Network, ways_of_root: Trails) -> None:
        self.still = ways.stances(network)
        self.possible = bool(self.still.any())
        if not self.possible:
            return
        self._network = network
        seconds = ways.seconds_to(network, self.still)
        self._after = ways.next_towards(network, self.still)
        end = ways_of_root.start + np.asarray(network.length, dtype=np.intp)
        displacement, turn = ways_of_root.places[end], ways_of_root.headings[end]
        place_met, turn_met = network.met
        # where one comes to stand, seen from the beginning of each path: nearest paths first
        self._rest = np.zeros(len(seconds), dtype=np.complex128)
        for path in np.argsort(seconds, kind="stable").tolist():
            if not self.still[path] and self._after[path] >= 0:
                then = self._after[path]
                edge = network.edges(path, then)
                aside = place_met[edge] + np.exp(1j * turn_met[edge]) * self._rest[then]
                self._rest[path] = displacement[path] + np.exp(1j * turn[path]) * aside
        self._seconds = seconds

    def next(self, now: Situation, rng: np.random.Generator) -> int:
        """The successor from which a stance is reached soonest; within the stance one that stays in it, not lately played."""
        if self.still[now.path]:
            may = self._network.successors(now.path)
            may = may[self.still[may]]
            may = may[now.last_played[may] == now.last_played[may].min()]
            return int(may[rng.integers(len(may))])
        return self._soonest(now.path)

    def _soonest(self, path: int) -> int:
        may = self._network.successors(path)
        return int(may[np.argmin(self._seconds[may])])

    def ends_at(self, now: Situation, goal: ToPlaces) -> bool:
        """Whether stopping now ends at the goal."""
        rest = now.place
        if not self.still[now.path]:
            path = self._soonest(now.path)
            edge = self._network.edges(now.path, path)
            place, turn = (complex(values[edge]) for values in self._network.met)
            rest += cmath.exp(1j * now.heading) * (place + cmath.exp(1j * turn) * complex(self._rest[path]))
        return abs(rest - goal.goal) <= goal.radius


def perform_paths(
    network: Network,
    goal: Goal | Feature | Sequence[Goal | Feature] | None = None,
    seconds: float = 20.0,
    seed: int | np.random.Generator = 0,
    *,
    finish: bool = False,
    beta: float = BETA,
    lookahead: float = LOOKAHEAD,
    bend: float = BEND,
    hold: float = HOLD,
    start: int | None = None,
    position: tuple[float, float] = (0.0, 0.0),
    heading: float = 0.0,
    stand: bool = True,
    prepared: Prospects | None = None,
    after_each: Callable[[Controller, Sequence[Step]], None] | None = None,
) -> Course:
    """Decide for a whole performance at once. Parameters as of `Controller`.

    Parameters
    ----------
    seconds : how long, at most.
    finish : whether to end when the goals are attained (and the performer stands, if it can), before the time is up.
    after_each : called after every decision with all so far; may set the controller right (`kinesics.synthesis.underway`).

    Raises
    ------
    InputError
        As `Controller`, and if `seconds` is not above 0.
    """
    if not (np.isfinite(seconds) and 0.0 < seconds <= LONGEST):
        raise InputError(f"Expected `seconds` above 0 and at most {LONGEST:g}, got {seconds}.")
    controller = Controller(
        network,
        goal,
        beta=beta,
        lookahead=lookahead,
        bend=bend,
        hold=hold,
        seed=seed,
        start=start,
        position=position,
        heading=heading,
        stand=stand,
        prepared=prepared,
    )
    fps = float(network.repertoire.fps)
    most = max(1, round(seconds * fps))
    steps: list[Step] = []
    frames = 0
    while frames < most and not (finish and steps and controller.finished):
        step = controller.step(most - frames)
        steps.append(step)
        frames += int(network.length[step.path])
        if after_each is not None and frames < most:
            after_each(controller, steps)
    return _course(controller, steps, most)


def _course(controller: Controller, steps: Sequence[Step], most: int) -> Course:
    network = controller.network
    places: list[NDArray[np.complex128]] = []
    headings: list[Array] = []
    for step in steps:
        way, facing = controller.way(step)
        places.append(way[:-1])
        headings.append(facing[:-1])
    paths = np.array([s.path for s in steps], dtype=np.intp)
    lengths = np.asarray(network.length, dtype=np.intp)[paths]
    begins = np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(np.intp)
    within = np.arange(int(lengths.sum())) - np.repeat(begins, lengths)
    moments = network.repertoire.advance(np.repeat(np.asarray(network.first)[paths], lengths), within)
    ground = np.concatenate(places)[:most]
    return Course(
        paths=paths,
        bends=np.array([s.bend for s in steps]),
        begins=begins,
        moments=moments[:most],
        ground=np.stack([ground.imag, ground.real], axis=1),
        yaw=np.concatenate(headings)[:most],
        fps=float(network.repertoire.fps),
        attained=controller.attained,
        outcome=controller.outcome(),
    )
