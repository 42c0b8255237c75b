"""From recordings to a new movement in one call: the public `kinesics.perform` and `kinesics.performance` ([Schultz2012] §4.4).

Repertoire, transitions, network, controller, rendering, one after the other; and what came of it, told so that anyone can
check it: which frames of which recording, mirrored or not, over which transitions, with which numbers.
"""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from kinesics.body import anatomy
from kinesics.body.motion import Motion
from kinesics.body.skeleton import Skeleton
from kinesics.errors import InputError, SkeletonError
from kinesics.progress import Progress, silent
from kinesics.synthesis import goals
from kinesics.synthesis import network as networks
from kinesics.synthesis.controller import BEND, BETA, LONGEST, Course, perform_paths
from kinesics.synthesis.network import Network
from kinesics.synthesis.piece import Piece, SourceFacts
from kinesics.synthesis.prospects import Prospects, prospects, trails
from kinesics.synthesis.rendering import Performance, Provenance, render
from kinesics.synthesis.repertoire import repertoire

if TYPE_CHECKING:
    from kinesics.analysis.facts import Phrase
    from kinesics.grammar.graph import MotionGraph
    from kinesics.synthesis.goals import Feature, Goal

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
NEAR: Final = goals.RADIUS - 0.12
"""Metres from the target that the way is led to: where feet are kept in place the body may come to stand a little beside it."""
SHARPER: Final = (1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0)
"""Ways drawn one after the other until one leads to the target or along the route, and how many times more each may be bent."""
MOST_BEND: Final = 20.0
"""Degrees a metre, to which the way may be bent on further attempts."""
FAVOURED: Final = 1.0
"""Weight of a favoured kind of movement beside the goal."""
FRESH: Final = 0.05
"""Weight of not repeating oneself beside a favoured kind of movement."""


def perform(
    motions: Motion | Sequence[Motion],
    *,
    target: ArrayLike | None = None,
    route: ArrayLike | None = None,
    from_state: str | None = None,
    to_state: str | None = None,
    favour: str | None = None,
    goal: Goal | Feature | Sequence[Goal | Feature] | None = None,
    seconds: float | None = None,
    linger: bool = False,
    seed: int = 0,
    beta: float = BETA,
    bend: float = BEND,
    mirrored: bool = True,
    backwards: bool = False,
    skeleton: Skeleton | None = None,
    fps: float | None = None,
    threshold: float | None = None,
    mapping: Mapping[str, object] | None = None,
    progress: Progress = silent,
) -> Motion:
    """A new movement from recordings, over the transitions between their moments ([Schultz2012] §4.4).

    What was chosen stands in ``assumptions`` of the result, what went wrong in ``warnings``; `performance`, of the same
    parameters, tells where every frame comes from.

    Parameters
    ----------
    motions : recordings to perform from; one alone will do. Skeletons and frame rates may differ.
    target : x, z in metres from where the performer starts, facing +z.
    route : corners of a line on the floor to follow, shape (n, 2), x and z in metres from where the performer starts.
    from_state, to_state : states of the motion graph (`kinesics.graph` of the same recordings names them, such as "A", "A*" or
        "X~"): begin in the one, and go to the other by the quickest way, on which every transition counts as 3 seconds or more:
        what was recorded between them is travelled rather than leapt over. The first alone is only where it begins.
    favour : a class, a state or a path of the grammar, or the name of a recording, of which there is to be much. Beside a target
        or route it is a soft pull only: of ways about as good the one with more of it is taken.
    goal : a goal, or several, of `kinesics.synthesis.goals`, or a feature of your own, in place of target and route.
    seconds : how long. With a goal at most, for it ends when that is attained. Without: 20, or what the goal may take.
    linger : with a goal, go on to the end of ``seconds``.
    seed : of all that is drawn; the same recordings and numbers give the same movement. Where the first way drawn does not lead
        to the target or along the route, up to seven others are drawn, which may be bent up to three times more; the best is
        performed.
    beta : how strictly the goal decides, from a stroll (0) to a beeline (infinite).
    bend : by how much the way may be bent towards the goal, degrees a metre.
    mirrored : whether mirror images of the recordings may be performed.
    backwards : whether the recordings may be performed backwards, too.
    skeleton, fps : of the result; those of the first recording unless given.
    threshold : largest mean D of a transition; found from the recordings unless given.
    mapping : joint names by the user, where a skeleton is not understood (see `kinesics.body.anatomy.resolve`).
    progress : called with a fraction now and then; may raise to stop.

    Raises
    ------
    InputError
        If there is no recording, one is a single pose, nothing recurs so that there are no transitions, goals contradict
        each other or cannot be pursued here, a state is unknown, or a number is out of range.
    SkeletonError
        If a skeleton cannot be understood as a human body; the message says which recording.
    """
    return performance(
        motions,
        target=target,
        route=route,
        from_state=from_state,
        to_state=to_state,
        favour=favour,
        goal=goal,
        seconds=seconds,
        linger=linger,
        seed=seed,
        beta=beta,
        bend=bend,
        mirrored=mirrored,
        backwards=backwards,
        skeleton=skeleton,
        fps=fps,
        threshold=threshold,
        mapping=mapping,
        progress=progress,
    ).motion


def performance(
    motions: Motion | Sequence[Motion],
    *,
    target: ArrayLike | None = None,
    route: ArrayLike | None = None,
    from_state: str | None = None,
    to_state: str | None = None,
    favour: str | None = None,
    goal: Goal | Feature | Sequence[Goal | Feature] | None = None,
    seconds: float | None = None,
    linger: bool = False,
    seed: int = 0,
    beta: float = BETA,
    bend: float = BEND,
    mirrored: bool = True,
    backwards: bool = False,
    skeleton: Skeleton | None = None,
    fps: float | None = None,
    threshold: float | None = None,
    mapping: Mapping[str, object] | None = None,
    progress: Progress = silent,
) -> Piece:
    """As `perform`, with all that is known of how the movement came about."""
    wish = _Wish.of(target, route, from_state, to_state, favour, goal)
    if seconds is not None and not (isinstance(seconds, int | float | np.number) and 0.0 < float(seconds) <= LONGEST):
        raise InputError(f"Expected `seconds` above 0 and at most {LONGEST:g}, got {seconds!r}.")
    seed = _whole(seed)
    given = _given(motions, mapping)
    progress(0.0, "bringing the recordings together")
    stock = repertoire(given, skeleton=skeleton, fps=fps, mirrored=mirrored, backwards=backwards)
    grammar = _grammar(given, wish, stock.names, progress)
    seams = () if grammar is None or wish.from_state is None else networks.state_seams(stock, grammar.graph)
    with warnings.catch_warnings():
        # what was pruned is told in the result
        warnings.simplefilter("ignore", UserWarning)
        net = networks.network(
            stock,
            threshold=threshold,
            seams=seams,
            progress=lambda f, message="": progress(0.2 + 0.39 * f, message),
        )
    if grammar is not None:
        net = networks.labelled(net, grammar.graph, grammar.phrases, at_states=True)
    start = _start(net, wish, seed)
    progress(0.6, "looking ahead")
    ahead = prospects(net)
    most = _most_seconds(wish, ahead, seconds)
    sharpness = SHARPER if wish.may_try_again(most, _pace(ahead)) else SHARPER[:1]
    best: tuple[Course, float] | None = None
    for attempt, sharper in enumerate(sharpness):
        bent = min(sharper * bend, max(bend, MOST_BEND))
        progress(0.75 + 0.1 * attempt / len(sharpness), "choosing the way")
        course = perform_paths(
            net,
            wish.goals(),
            most,
            seed if attempt == 0 else np.random.default_rng([seed, attempt]),
            finish=wish.ends and not linger,
            beta=beta,
            bend=bent,
            start=start,
            prepared=ahead,
        )
        if best is None or course.attained or wish.miss(course) < wish.miss(best[0]):
            best = course, bent
        if course.attained:
            break
    assert best is not None
    course, bent = best
    progress(0.85, "performing")
    ways = trails(net)
    walked = ways.travelled[ways.start + net.length][course.paths]
    done = _from_the_origin(_first(render(net, course.paths, bend=course.bends * walked), len(course.moments)))
    parameters: dict[str, Any] = {
        **wish.plain(),
        "seconds": seconds,
        "linger": bool(linger),
        "seed": seed,
        "beta": float(beta) if np.isfinite(beta) else "infinite",
        "bend": float(bend),
        "bend_used": float(bent),
        "mirrored": bool(mirrored),
        "backwards": bool(backwards),
        "fps": stock.fps,
        "threshold": threshold,
    }
    motion = done.motion.replace(
        assumptions=(*stock.assumptions, *_chosen(net, parameters, bent)),
    )
    facts = tuple(
        SourceFacts(
            m.source.file_name or name, m.source.sha256 or None, m.source.format or None, m.frame_count, float(m.fps)
        )
        for m, name in zip(given, stock.names, strict=True)
    )
    progress(1.0, "performed")
    piece = Piece(dataclasses.replace(done, motion=motion), course, net, facts, parameters)
    motion = motion.replace(warnings=_doubts(piece, wish, ahead, most, seconds))
    return dataclasses.replace(piece, performance=dataclasses.replace(done, motion=motion))


@dataclass(frozen=True, eq=False)
class _Wish:
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
        target: ArrayLike | None,
        route: ArrayLike | None,
        from_state: str | None,
        to_state: str | None,
        favour: str | None,
        goal: Goal | Feature | Sequence[Goal | Feature] | None,
    ) -> _Wish:
        where = {"target": target, "route": route, "to_state": to_state, "goal": goal}
        asked = [name for name, value in where.items() if value is not None]
        if len(asked) > 1:
            raise InputError(f"Expected one thing to go for, got {' and '.join(asked)}: give one of them.")
        if to_state is not None and from_state is None:
            raise InputError(
                f"A way to the state {to_state!r} begins in a state, too: give `from_state` (--from) beside `to_state` (--to)."
            )
        own: tuple[Any, ...] = () if goal is None else tuple(goal) if isinstance(goal, (list, tuple)) else (goal,)
        return cls(
            None if target is None else goals.Target(target, radius=NEAR),  # type: ignore[arg-type]
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
    def metres(self) -> float:
        """The straight way to it."""
        if self.target is not None:
            return math.hypot(*self.target.position)
        if self.route is not None:
            x, z = np.asarray(self.route.points)[0].tolist()
            return self.route.length + math.hypot(x, z)
        return 0.0

    def may_try_again(self, seconds: float, pace: float) -> bool:
        """Whether, where the first draw does not lead there, another may."""
        return (self.target is not None or self.route is not None) and self.metres <= seconds * pace

    def miss(self, course: Course) -> float:
        """Metres from target or end of the route at best."""
        if self.target is not None:
            place = np.asarray(self.target.position)
        elif self.route is not None:
            place = np.asarray(self.route.points)[-1]
        else:
            return 0.0
        return float(np.hypot(*(course.ground - place).T).min())

    def goals(self) -> list[Goal | Feature]:
        """For the controller; something new all the time, where nothing is wished for."""
        out: list[Goal | Feature] = list(self.own)
        if self.target is not None:
            out.append(self.target)
        if self.route is not None:
            out.append(self.route)
        if self.to_state is not None:
            assert self.from_state is not None
            out.append(goals.StateToState(self.from_state, self.to_state))
        goes_somewhere = bool(out)
        if self.favour is not None:
            out.append(goals.Favour(self.favour, weight=FAVOURED))
        if not goes_somewhere:
            out.append(goals.Novelty(weight=1.0 if self.favour is None else FRESH))
        return out

    def plain(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "target": None if self.target is None else list(self.target.position),
            "route": None if self.route is None else np.asarray(self.route.points).tolist(),
            "from_state": self.from_state,
            "to_state": self.to_state,
            "favour": self.favour,
            "goal": [repr(g) if dataclasses.is_dataclass(g) else type(g).__name__ for g in self.own],
        }


def _given(motions: Motion | Sequence[Motion], mapping: Mapping[str, object] | None) -> list[Motion]:
    if not isinstance(motions, Motion | Iterable):
        raise InputError(f"Expected motions to perform from, got {type(motions).__name__}.")
    given = [motions] if isinstance(motions, Motion) else list(motions)
    for k, motion in enumerate(given):
        if not isinstance(motion, Motion):
            raise InputError(f"Expected motions to perform from, got {type(motion).__name__} as number {k + 1}.")
    if mapping:
        for k, motion in enumerate(given):
            try:
                given[k] = anatomy.understood(motion, mapping)
            except SkeletonError as error:
                name = motion.source.file_name or motion.name or f"recording {k + 1}"
                raise SkeletonError(f"{name}: {error}", found=error.found, missing=error.missing) from error
    return given


def _whole(seed: object) -> int:
    try:
        number = int(seed)  # type: ignore[call-overload]
    except (TypeError, ValueError):
        raise InputError(f"Expected a whole number as `seed`, got {seed!r}.") from None
    if number != seed or number < 0:
        raise InputError(f"Expected a whole number of 0 or more as `seed`, got {seed!r}.")
    return int(number)


class _Grammar(NamedTuple):
    graph: MotionGraph
    phrases: Sequence[Phrase]


def _grammar(motions: Sequence[Motion], wish: _Wish, names: Sequence[str], progress: Progress) -> _Grammar | None:
    """What the recordings say of states, paths and classes; None where nobody asks."""
    if wish.favour is not None and wish.favour not in names:
        from kinesics.analysis import analyze

        progress(0.1, "reading the grammar")
        read = analyze(motions)
        return _Grammar(read.graph, read.phrases)
    if wish.from_state is not None:
        from kinesics.analysis import joint

        progress(0.1, "reading the grammar")
        return _Grammar(joint.graph(motions), ())
    return None


def _start(net: Network, wish: _Wish, seed: int) -> int | None:
    """A path that begins in the state wished for; None if the way itself, or the draw, decides."""
    if wish.from_state is None or wish.to_state is not None:
        return None
    begins = np.flatnonzero(goals.states_of(net, wish.from_state, "from"))
    return int(np.random.default_rng(seed).choice(begins))


def _pace(ahead: Prospects) -> float:
    """Metres a second in a straight line, at best."""
    return ahead.reach / ahead.lookahead


def _most_seconds(wish: _Wish, ahead: Prospects, seconds: float | None) -> float:
    pace = _pace(ahead)
    away = wish.metres - (goals.RADIUS if wish.target is not None else 0.0)
    if away > 0.0 and pace < STAYING:
        raise InputError(
            f"These recordings stay in place (at most {pace:.2g} metres a second in a straight line): no "
            f"{'target' if wish.target is not None else 'route'} can be reached with them. Give recordings that go about, "
            "or perform without a place to go to."
        )
    if seconds is not None:
        return float(seconds)
    if away <= 0.0:
        return MOST_SECONDS if wish.to_state is not None else SECONDS
    return min(MOST_SECONDS, max(SECONDS, SETTLING + DETOUR * wish.metres / pace))


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


def _chosen(net: Network, parameters: Mapping[str, Any], bent: float) -> tuple[str, ...]:
    from kinesics import __version__

    return (
        f"transitions up to a mean D of {net.threshold:.3g} ({net.rule})",
        *(f"not used: {pruned}" for pruned in net.pruned),
        f"chosen with seed {parameters['seed']}, beta {parameters['beta']}, bend {bent:g} degrees a metre"
        + ("" if bent == parameters["bend"] else f", for {parameters['bend']:g} did not lead there")
        + f", by kinesics {__version__}",
    )


def _hopeless(piece: Piece, wish: _Wish, ahead: Prospects) -> bool:
    """Whether no way to the target was found from where the performer began."""
    assert wish.target is not None
    x, z = wish.target.position
    bend = math.radians(piece.parameters["bend"])
    tables = ahead.to_go(wish.target.radius, bend)
    return tables.hopeless(int(piece.course.paths[0]), complex(z, x))


def _doubts(piece: Piece, wish: _Wish, ahead: Prospects, most: float, seconds: float | None) -> tuple[str, ...]:
    """What did not go as wished, and what helps."""
    out = [
        f"nothing is performed of {name}: no transition leads there and back again; recordings nearer to the others, longer "
        "ones or a larger threshold would join it"
        for name in dict.fromkeys(p.recording for p in piece.pruned if p.everything)
    ]
    if wish.ends and not piece.attained:
        told = "; ".join(piece.outcome) or "the goal was not attained"
        pace = _pace(ahead)
        if wish.metres > most * pace:
            advice = (
                f": {wish.metres:.1f} m at {pace:.2f} m/s, the fastest there is, take longer than {most:g} s; "
                "give more seconds"
            )
        elif wish.target is not None and _hopeless(piece, wish, ahead):
            advice = (
                ": no way there was found with these recordings; give recordings that turn more, another seed, or allow "
                "more `bend` (--bend)"
            )
        elif wish.target is not None or wish.route is not None:
            advice = (
                ": give more seconds, another seed, or recordings that turn more"
                if seconds is not None
                else ": give another seed, or recordings that turn more"
            )
        else:
            advice = ": give more seconds"
        out.append(told + advice)
    return tuple(out)
