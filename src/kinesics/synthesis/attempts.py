"""Ways drawn one after the other until one, as performed, leads where it is wished to.

A way is drawn by chance, a target may lie inside the narrowest turn, and where feet are kept in place the body goes a little
otherwise than the way decided for. So ways are judged by the movement performed. One that leads to a target beside which the body
then goes by some centimetres is kept but for its last seconds, which are decided for anew from where the body truly is. Where a
way does not do otherwise, others are drawn: by other numbers, bent more, or by way of a place ahead, from which the target can be
turned to.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.control.controller import Controller
from kinesics.synthesis.control.courses import Course, perform_paths
from kinesics.synthesis.embodiment.rendering import Performance, Provenance, render
from kinesics.synthesis.paths.laying import Step
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.paths.prospects import Prospects
from kinesics.synthesis.paths.trails import trails
from kinesics.synthesis.piece import visits
from kinesics.synthesis.wish import Detour, Wish

Array = NDArray[np.float64]

SHARPER: Final = (1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0)
"""Ways drawn one after the other, and how many times more each may be bent."""
DETOURS: Final = (3.0, 5.0)
"""Radii of the narrowest turn that are gone straight on on the last ways, bent as the last before, so as to come back to a place
inside that turn: whoever goes round it at arm's length would go round it for ever."""
AIMS: Final = 3
"""Times that a way is performed, its last seconds decided for anew, where it leads to a place that the body goes beside."""
RUN_UP: Final = 8.0
"""Seconds before such a place from which on they are: what feet take away meanwhile is known to centimetres, and there is room to
turn by what is to be made up for."""
BESIDE: Final = 0.2
"""Metres that feet may take a body off the way decided for along a route, before it is decided for anew with what they take."""
ENOUGH: Final = 5000.0
"""Seconds of movement performed for ways that do not do, after which no other is drawn: far targets take minutes each."""
PATIENT: Final = 4
"""Ways drawn before others may take longer, where no time was asked for."""
MORE_TIME: Final = 2.0
ROUNDABOUT: Final = 2.0
"""Times the straight way that the way is long, from which it is tried whether bending it more would make it far shorter."""
FAR_SHORTER: Final = 1.5
"""Times shorter that it then is."""
ABOUT_AS_SHORT: Final = 1.25
"""Times the shortest way, up to which one that is bent less is taken instead."""
LEAST_BEND: Final = 5.0
"""Degrees a metre: no smaller multiples of less are tried."""
MOST_BEND: Final = 20.0
"""Degrees a metre, to which the way may be bent on further attempts."""


class Shorter(NamedTuple):
    """A far shorter way."""

    bend: float
    """Degrees a metre by which it might be bent."""
    metres: float


class Attempt(NamedTuple):
    """A way drawn, and by how much it misses what was wished for."""

    course: Course
    bend: float
    """Degrees a metre by which it might be bent."""
    via: Detour | None
    """A place that was gone to besides, to turn there."""
    done: Performance | None
    """What is performed of it, where the way decided for leads there."""
    miss: tuple[float, float]
    """See `Wish.miss`."""
    shorter: Shorter | None = None
    """How one would come there by a far shorter way."""
    spared: float = 0.0
    """Metres of the long way round that was not gone, for this one is bent more."""


def best_attempt(
    net: Network,
    wish: Wish,
    seconds: float,
    seed: int,
    *,
    finish: bool,
    beta: float,
    bend: float,
    start: int | None,
    ahead: Prospects,
    again: bool,
    more_time: bool,
    shorten: bool,
    progress: Callable[[float], object],
) -> Attempt:
    """The first way drawn that, as performed, leads where it is wished to; else that which misses least.

    Parameters
    ----------
    seconds, seed, finish, beta, bend, start, ahead : as of `kinesics.synthesis.control.courses.perform_paths`.
    again : whether, where the first does not lead there, others are drawn.
    more_time : whether the later ways and detours may take longer than ``seconds``.
    shorten : whether a way that is far shorter by being bent more is gone, not only told of.
    progress : called with the share done.
    """
    attempts = _Attempts(net, wish, seconds, seed, finish, beta, start, ahead)
    allowed = [min(sharper * bend, max(bend, MOST_BEND)) for sharper in (SHARPER if again else SHARPER[:1])]
    radii = [0.0] * len(allowed)
    if again and wish.places:
        allowed += [allowed[-1]] * len(DETOURS)
        radii += DETOURS
    best: Attempt | None = None
    for number, (most_bent, radius) in enumerate(zip(allowed, radii, strict=True)):
        via, most = None, seconds * (MORE_TIME if more_time and number >= PATIENT else 1.0)
        if radius and best is not None:
            gone = radius / (1.0 / ahead.turning + math.radians(most_bent))
            via = _ahead(best, wish, gone)
            most += 2.0 * gone * ahead.lookahead / ahead.reach if more_time else 0.0
        progress(number / len(allowed))
        this = attempts.aimed(number, most_bent, via, most)
        if best is None or this.miss < best.miss:
            best = this
        if not any(best.miss) or attempts.spent > ENOUGH:
            break
    assert best is not None
    shorter = attempts.far_shorter(best) if again else None
    if shorter is not None and shorten:
        attempts.spent = 0.0
        more_bent = attempts.aimed(0, shorter.bend, None, seconds)
        if more_bent.done is not None and more_bent.miss <= best.miss:
            return more_bent._replace(spared=best.course.length)
    return best._replace(shorter=shorter)


class _Known(NamedTuple):
    """By how much a body will be beside the way laid for it, from a frame on at which that is reckoned with."""

    frame: int
    beside: complex
    """z + i·x, metres."""


@dataclasses.dataclass(eq=False)
class _Attempts:
    """Ways drawn for one wish, and how much was performed for them."""

    net: Network
    wish: Wish
    seconds: float
    seed: int
    finish: bool
    beta: float
    start: int | None
    ahead: Prospects
    spent: float = 0.0
    """Seconds of movement."""

    def aimed(self, number: int, bend: float, via: Detour | None, most: float) -> Attempt:
        """A way, and where the body goes beside a place that it leads to the best of those whose last seconds are set right."""
        best: Attempt | None = None
        known: list[_Known] = []
        for _ in range(AIMS + max(0, len(self.wish.places) - 1)):
            this = self._drawn(number, bend, via, most, known)
            if best is None or this.miss < best.miss:
                best = this
            self.spent += 0.0 if this.done is None else this.done.motion.duration
            if this.done is None or not self.wish.places or not any(this.miss) or self.spent > ENOUGH:
                break
            known = self._learnt(this, known)
        assert best is not None
        if self.wish.route is None or best.done is None:
            return best
        known = _learnt_along(best)
        again = self._drawn(number, bend, via, most, known) if known else best
        return again if again.done is not None and again.miss <= best.miss else best

    def far_shorter(self, best: Attempt) -> Shorter | None:
        """The least bent of the far shorter ways that a long way round becomes if it may be bent more, of those about as short as
        the shortest; tried, not rendered.
        """
        places = bool(self.wish.places)
        if not (self.finish and places and best.course.attained and best.course.length > ROUNDABOUT * self.wish.metres):
            return None
        found: list[Shorter] = []
        for bend in sorted({min(sharper * max(best.bend, LEAST_BEND), MOST_BEND) for sharper in SHARPER}):
            if bend > best.bend:
                course = self._course(0, bend, None, self.seconds)
                if course.attained and FAR_SHORTER * course.length <= best.course.length:
                    found.append(Shorter(bend, course.length))
        shortest = min((way.metres for way in found), default=0.0)
        return next((way for way in found if way.metres <= ABOUT_AS_SHORT * shortest), None)

    def _course(
        self, number: int, bend: float, via: Detour | None, most: float, known: Sequence[_Known] = ()
    ) -> Course:
        return perform_paths(
            self.net,
            self.wish.goals(via, most),
            most,
            self.seed if number == 0 else np.random.default_rng([self.seed, number]),
            finish=self.finish,
            beta=self.beta,
            bend=bend,
            start=self.start,
            prepared=self.ahead,
            after_each=_setting_right(known),
        )

    def _drawn(self, number: int, bend: float, via: Detour | None, most: float, known: Sequence[_Known]) -> Attempt:
        course = self._course(number, bend, via, most, known)
        if course.attained:
            done = performed(self.net, course)
            return Attempt(course, bend, via, done, self.wish.miss(trail_of(done), True))
        miss = self.wish.miss(course.ground, False)
        if any(miss) or not self.finish:
            return Attempt(course, bend, via, None, miss)
        done = _until_there(performed(self.net, course), self.wish)
        return Attempt(course, bend, via, done, self.wish.miss(trail_of(done), False))

    def _learnt(self, missed: Attempt, known: Sequence[_Known]) -> list[_Known]:
        """What is known of a way beside which the body went past a place: up to some seconds before it is gone as it was, with
        what was known then, and from there on with where the body comes to by then.
        """
        assert missed.done is not None
        course, trail = missed.course, trail_of(missed.done)
        reached = len(visits(trail, self.wish.places, self.wish.radius))
        planned = visits(course.ground, self.wish.places, self.wish.radius)
        # who passes by on the way decided for is nearest there when nearest to the place
        at = min(planned[reached] if reached < len(planned) else len(trail) - 1, len(trail) - 1)
        frame = max(0, at - round(RUN_UP * course.fps))
        before = [k for k in known if k.frame < frame]
        beside = complex(*(trail[at] - course.ground[at])[::-1])
        # the way decided for begins anew at what was known of it
        beside += next((k.beside for k in reversed(known) if k.frame <= at), 0j)
        return [*before, _Known(frame, beside)]


def _learnt_along(done: Attempt) -> list[_Known]:
    """By how much a body was beside its way, from wherever that had grown by `BESIDE`; nothing where it never did."""
    assert done.done is not None
    trail = trail_of(done.done)
    ground = done.course.ground[: len(trail)]
    beside = (trail[: len(ground)] - ground) @ [1j, 1.0]
    out: list[_Known] = []
    at, here = 0, 0j
    while True:
        farther = np.flatnonzero(np.abs(beside[at:] - here) > BESIDE)
        if not len(farther):
            return out
        at += int(farther[0])
        here = complex(beside[at])
        out.append(_Known(at, here))


def _setting_right(known: Sequence[_Known]) -> Callable[[Controller, Sequence[Step]], None] | None:
    """Has a controller reckon with what is known, from the path on that begins after each frame."""
    if not known:
        return None
    left, beside = list(known), 0j

    def set_right(controller: Controller, steps: Sequence[Step]) -> None:
        nonlocal beside
        while left and round(controller.now.time * controller.network.repertoire.fps) >= left[0].frame:
            now = left.pop(0).beside
            controller.now.place += now - beside
            beside = now

    return set_right


def _until_there(done: Performance, wish: Wish) -> Performance:
    """To the end of the path on which the last place is reached: nearer than it was decided to go to, it was gone by."""
    there = visits(trail_of(done), wish.places, wish.radius)
    if len(there) < len(wish.places):
        return done
    step = done.provenance.step
    return _first(done, int(np.searchsorted(step, step[there[-1]], side="right")))


def _ahead(best: Attempt, wish: Wish, metres: float) -> Detour:
    """The place so many metres straight on from the last place that was reached."""
    course = best.course
    there = visits(course.ground, wish.places, wish.radius)
    frame = there[-1] if there else 0
    x, z = course.ground[frame].tolist()
    yaw = float(course.yaw[frame])
    return Detour(len(there), (x + metres * math.sin(yaw), z + metres * math.cos(yaw)))


def trail_of(done: Performance) -> Array:
    """Root on the floor: x, z in metres, shape (frames, 2)."""
    return done.motion.root_positions[:, [0, 2]]


def performed(net: Network, course: Course) -> Performance:
    """What was decided for as movement, begun at x = z = 0."""
    ways = trails(net)
    walked = ways.travelled[ways.start + net.length][course.paths]
    return _from_the_origin(_first(render(net, course.paths, bend=course.bends * walked), len(course.moments)))


def _first(done: Performance, frames: int) -> Performance:
    """The first frames of a performance: the last path may be cut short."""
    if frames >= done.motion.frame_count:
        return done
    where = done.provenance
    cut = {f.name: getattr(where, f.name)[:frames] for f in dataclasses.fields(where)}
    return dataclasses.replace(
        done,
        motion=done.motion[:frames],
        provenance=Provenance(**cut),
        paths=done.paths[: int(cut["step"][-1]) + 1],
        cuts=done.cuts[done.cuts < frames],
        feet=done.feet[:frames],
        contacts=tuple(c._replace(end=min(c.end, frames)) for c in done.contacts if c.start < frames),
        lowered=done.lowered[:frames],
    )


def _from_the_origin(done: Performance) -> Performance:
    """The same, begun at x = z = 0: where feet are kept in place the body leans a little, in the first frame too."""
    x, _, z = done.motion.root_positions[0].tolist()
    return dataclasses.replace(
        done,
        motion=done.motion.replace(root_positions=done.motion.root_positions - [x, 0.0, z]),
        contacts=tuple(c._replace(place=(c.place[0] - x, c.place[1] - z)) for c in done.contacts),
    )
