"""Ways drawn one after the other until one, as performed, leads where it is wished to.

A way is drawn by chance, a target may lie inside the narrowest turn, and where feet are kept in place the body goes a little
otherwise than the way decided for. So ways are judged by the movement performed, and where one does not do, others are drawn: by
other numbers, with the place to be decided for set off by what the feet take away, bent more, or by way of a place ahead, from
which the target can be turned to.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.courses import Course, perform_paths
from kinesics.synthesis.network import Network
from kinesics.synthesis.piece import visits
from kinesics.synthesis.prospects import Prospects
from kinesics.synthesis.rendering import Performance, Provenance, render
from kinesics.synthesis.trails import trails
from kinesics.synthesis.wish import Detour, Wish

Array = NDArray[np.float64]

SHARPER: Final = (1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0)
"""Ways drawn one after the other, and how many times more each may be bent."""
DETOURS: Final = (3.0, 5.0)
"""Radii of the narrowest turn that are gone straight on on the last ways, bent as the last before, so as to come back to a place
inside that turn: whoever goes round it at arm's length would go round it for ever."""
AIMS: Final = 3
"""Times that a way is drawn anew where it leads to the target but, with the feet kept in place, the body goes beside it."""
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
    seconds, seed, finish, beta, bend, start, ahead : as of `kinesics.synthesis.courses.perform_paths`.
    again : whether, where the first does not lead there, others are drawn.
    more_time : whether the later ways and detours may take longer than ``seconds``.
    shorten : whether a way that is far shorter by being bent more is gone, not only told of.
    progress : called with the share done.
    """
    drift, spent = 1.0 + 0.0j, 0.0

    def draw(number: int, bent: float, via: Detour | None, most: float) -> Attempt:
        course = perform_paths(
            net,
            wish.goals(drift, via, most),
            most,
            seed if number == 0 else np.random.default_rng([seed, number]),
            finish=finish,
            beta=beta,
            bend=bent,
            start=start,
            prepared=ahead,
        )
        if course.attained:
            done = performed(net, course)
            return Attempt(course, bent, via, done, wish.miss(trail_of(done), True))
        expected = (course.ground @ [1j, 1.0]) * drift
        miss = wish.miss(np.stack([expected.imag, expected.real], axis=1), False)
        if any(miss) or not finish:
            return Attempt(course, bent, via, None, miss)
        done = _until_there(performed(net, course), wish)
        return Attempt(course, bent, via, done, wish.miss(trail_of(done), False))

    def aimed(number: int, bent: float, via: Detour | None, most: float) -> Attempt:
        """The best of ways set off, one after the other, by what the feet take away."""
        nonlocal drift, spent
        best: Attempt | None = None
        for _ in range(AIMS):
            this = draw(number, bent, via, most)
            if best is None or this.miss < best.miss:
                best = this
            spent += 0.0 if this.done is None else this.done.motion.duration
            if this.done is None or not wish.places or not any(this.miss) or spent > ENOUGH:
                break
            drift = drift_of(this.course.ground, trail_of(this.done))
        assert best is not None
        return best

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
        this = aimed(number, most_bent, via, most)
        if best is None or this.miss < best.miss:
            best = this
        if not any(best.miss) or spent > ENOUGH:
            break
    assert best is not None
    shorter = _far_shorter(net, wish, best, seconds, seed, finish, beta, start, ahead) if again else None
    if shorter is not None and shorten:
        drift, spent = 1.0 + 0.0j, 0.0
        more_bent = aimed(0, shorter.bend, None, seconds)
        if more_bent.done is not None and more_bent.miss <= best.miss:
            return more_bent._replace(spared=best.course.length)
    return best._replace(shorter=shorter)


def _far_shorter(
    net: Network,
    wish: Wish,
    best: Attempt,
    seconds: float,
    seed: int,
    finish: bool,
    beta: float,
    start: int | None,
    ahead: Prospects,
) -> Shorter | None:
    """The least bent of the far shorter ways that a long way round becomes if it may be bent more, of those about as short as the
    shortest; tried, not rendered.
    """
    if not (finish and wish.places and best.course.attained and best.course.length > ROUNDABOUT * wish.metres):
        return None
    found: list[Shorter] = []
    for bend in sorted({min(sharper * max(best.bend, LEAST_BEND), MOST_BEND) for sharper in SHARPER}):
        if bend <= best.bend:
            continue
        course = perform_paths(
            net, wish.goals(most=seconds), seconds, seed, finish=True, beta=beta, bend=bend, start=start, prepared=ahead
        )
        if course.attained and FAR_SHORTER * course.length <= best.course.length:
            found.append(Shorter(bend, course.length))
    shortest = min((way.metres for way in found), default=0.0)
    return next((way for way in found if way.metres <= ABOUT_AS_SHORT * shortest), None)


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


def drift_of(ground: Array, trail: Array) -> complex:
    """What the way decided for has to be multiplied by, as z + i·x, to come nearest to the way performed.

    Feet kept in place shorten every stride of a runner whose feet slide, all alike. Both of shape (frames, 2), x and z.
    """
    planned, went = ground[: len(trail)] @ [1j, 1.0], trail[: len(ground)] @ [1j, 1.0]
    square = float(np.vdot(planned, planned).real)
    return complex(np.vdot(planned, went) / square) if square > 0.0 else 1.0 + 0.0j


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
        corrected=done.corrected[:frames],
        lowered=done.lowered[:frames],
        missed=done.missed[:frames],
    )


def _from_the_origin(done: Performance) -> Performance:
    """The same, begun at x = z = 0: where feet are kept in place the body leans a little, in the first frame too."""
    x, _, z = done.motion.root_positions[0].tolist()
    return dataclasses.replace(
        done,
        motion=done.motion.replace(root_positions=done.motion.root_positions - [x, 0.0, z]),
        contacts=tuple(c._replace(place=(c.place[0] - x, c.place[1] - z)) for c in done.contacts),
    )
