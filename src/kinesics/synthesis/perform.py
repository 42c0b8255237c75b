"""From recordings to a new movement in one call: the public `kinesics.perform` and `kinesics.performance` ([Schultz2012] §4.4).

Repertoire, transitions, network, controller, rendering, one after the other; and what came of it, told so that anyone can
check it: which frames of which recording, mirrored or not, over which transitions, with which numbers.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ParamSpec

from numpy.typing import ArrayLike

from kinesics.body.motion import Motion
from kinesics.body.skeleton import Skeleton
from kinesics.progress import Progress, silent
from kinesics.synthesis import elsewhere, goals
from kinesics.synthesis.attempts import Attempt, best_attempt, performed
from kinesics.synthesis.control.controller import BEND, BETA
from kinesics.synthesis.doubts import doubts
from kinesics.synthesis.embodiment import checking
from kinesics.synthesis.material import Material, beginning
from kinesics.synthesis.paths.network import Network
from kinesics.synthesis.piece import Piece, SourceFacts
from kinesics.synthesis.request import Request
from kinesics.synthesis.wish import HARDLY, favoured

if TYPE_CHECKING:
    from kinesics.grammar.edits import Edits
    from kinesics.synthesis.goals import Feature, Goal

P = ParamSpec("P")


def performance(
    motions: Motion | Sequence[Motion] | Material,
    *,
    target: ArrayLike | None = None,
    radius: float | None = None,
    route: ArrayLike | None = None,
    from_state: str | None = None,
    to_state: str | None = None,
    favour: str | None = None,
    goal: Goal | Feature | Sequence[Goal | Feature] | None = None,
    seconds: float | None = None,
    linger: bool = False,
    seed: int = 0,
    beta: float = BETA,
    bend: float | None = None,
    mirrored: bool | None = None,
    backwards: bool | None = None,
    skeleton: Skeleton | Motion | None = None,
    fps: float | None = None,
    threshold: float | None = None,
    mapping: Mapping[str, object] | None = None,
    edits: Edits | None = None,
    progress: Progress = silent,
) -> Piece:
    """A new movement from recordings, over the transitions between their moments ([Schultz2012] §4.4).

    `kinesics.perform` gives the `Motion` alone: what was chosen stands in its ``assumptions``, what went wrong in its
    ``warnings``. `kinesics.performance`, of the same parameters, gives a `Piece`: that motion, where every frame of it comes
    from, what came of the goal, and what was measured.

    Parameters
    ----------
    motions : recordings to perform from; one alone will do. Skeletons and frame rates may differ. What is given twice is used once.
        Or what `kinesics.prepare` made of them: most of the work is done then, for any number of performances.
    target : x, z in metres from where the performer starts, facing +z.
    radius : how near to the target counts as there, metres; .5 unless given.
    route : corners of a line on the floor to follow, shape (n, 2), x and z in metres from where the performer starts.
    from_state, to_state : states of the motion graph (`kinesics.graph` of the same recordings names them, such as "A", "A*" or
        "X~"): begin in the one, and go to the other by the quickest way, on which every transition counts as 3 seconds or more:
        what was recorded between them is travelled rather than leapt over; no way need lead back. The first alone is only where it
        begins.
    favour : of what there is to be much: a class ("cyclic-antiphase"), a state ("A*") or a path ("ab_1") of the grammar, a phrase
        by the name that ``edits`` give it (of one recording also by its kind, "kind 2"), a recording by its name; or a word that
        stands in the names of recordings, "walk". Where it is not in the largest part of the recordings that holds together, the
        part with most of it is performed. Beside a target or route it is a soft pull only: of ways about as good the one
        with more of it is taken.
    goal : a goal, or several, of `kinesics.synthesis.goals`, or a feature of your own, in place of target and route.
    seconds : how long. With a goal at most, for it ends when that is attained. Without: 20, or what the goal may take.
    linger : with a goal and ``seconds``, go on to the end of these when it is attained.
    seed : of all that is drawn; the same recordings and numbers give the same movement. Where the first way drawn does not lead
        to the target or along the route, up to seven others are drawn, which may be bent up to four times more; the best is
        performed.
    beta : how strictly the goal decides, from a stroll (0) to a beeline (infinite).
    bend : by how much the way may be bent towards the goal, degrees a metre. Unless given 5, and more where the way to a target
        becomes far shorter by it.
    mirrored : whether mirror images of the recordings may be performed; they may unless given.
    backwards : whether the recordings may be performed backwards, too, which they may not unless given: where the movement can be
        passed into from one that runs forwards, pose and velocity alike, as a reversible path can ([Schultz2012] §3.5). Nothing
        asks whether gravity allows it: a jump played backwards looks like none.
    skeleton, fps : of the result; those of the first recording unless given. For the skeleton a recording on it will do, and
        what its rest pose alone does not tell is seen there.
    threshold : largest mean D of a transition; found from the recordings unless given, larger than usual where most of them
        would be left out.
    mapping : joint names by the user, where a skeleton is not understood (see `kinesics.body.anatomy.resolve`).
    edits : names, merges and splits of states, paths and phrases (see `kinesics.grammar.edits`), by which they may be asked for.
    progress : called with a fraction now and then; may raise to stop.

    Raises
    ------
    InputError
        If there is no recording, all are single poses (one beside others is left out, which is among the warnings) or of fewer
        than 8 frames a second, nothing recurs so that there are no transitions, goals contradict
        each other or cannot be pursued here, a state is unknown, a number is out of range, or what the recordings were prepared for
        is contradicted.
    SkeletonError
        If a skeleton cannot be understood as a human body; the message says which recording.
    """
    return fulfil(
        motions,
        Request(
            target=target,
            radius=radius,
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
            fps=fps,
            threshold=threshold,
        ),
        skeleton=skeleton,
        mapping=mapping,
        edits=edits,
        progress=progress,
    )


def _motion_of(make: Callable[P, Piece]) -> Callable[P, Motion]:
    """The same call, signature and words, for the movement alone."""

    @functools.wraps(make)
    def perform(*args: P.args, **named: P.kwargs) -> Motion:
        return make(*args, **named).motion

    perform.__name__ = perform.__qualname__ = "perform"
    perform.__annotations__ = {**make.__annotations__, "return": "Motion"}
    shown = inspect.signature(make).replace(return_annotation="Motion")
    perform.__signature__ = shown  # type: ignore[attr-defined]
    return perform


perform = _motion_of(performance)


def fulfil(
    motions: Motion | Sequence[Motion] | Material,
    asked: Request,
    *,
    skeleton: Skeleton | Motion | None = None,
    mapping: Mapping[str, object] | None = None,
    edits: Edits | None = None,
    progress: Progress = silent,
) -> Piece:
    """What is asked for, from recordings: `performance`, for those who have checked what is asked before they read any."""
    progress(0.0, "bringing the recordings together")
    material = (
        motions
        if isinstance(motions, Material)
        else Material(
            motions,
            skeleton=skeleton,
            fps=asked.fps,
            mirrored=True if asked.mirrored is None else asked.mirrored,
            backwards=bool(asked.backwards),
            threshold=asked.threshold,
            mapping=mapping,
            edits=edits,
        )
    )
    asked = material.agreed(asked, skeleton, mapping, edits)
    stock, seed, seconds = material.repertoire, asked.whole_seed, asked.seconds
    wish, largest, part, serving, net, ahead = material.ground(
        asked.wish, lambda share, message="": progress(0.1 + 0.65 * share, message)
    )
    start = beginning(net, wish, seed)
    most = wish.most_seconds(ahead, seconds, asked.linger)
    best = best_attempt(
        net,
        wish,
        most,
        seed,
        finish=wish.ends and not (asked.linger and net.endless),
        beta=float(asked.beta),
        bend=BEND if asked.bend is None else float(asked.bend),
        start=start,
        ahead=ahead,
        again=wish.may_try_again(most, ahead.fastest),
        more_time=seconds is None and ahead.pace >= HARDLY,
        shorten=asked.bend is None,
        progress=lambda share: progress(0.75 + 0.1 * share, "choosing the way"),
    )
    progress(0.85, "performing")
    done = performed(net, best.course) if best.done is None else best.done
    parameters: dict[str, Any] = {
        **asked.plain(),
        **wish.plain(),
        "bend_used": float(best.bend),
        "fps": stock.fps,
    }
    motion = done.motion.replace(
        assumptions=(*material.twice, *stock.assumptions, *favoured(net, wish), *_chosen(net, parameters, best)),
    )
    facts = tuple(
        SourceFacts(
            m.source.file_name or name, m.source.sha256 or None, m.source.format or None, m.frame_count, float(m.fps)
        )
        for m, name in zip(material.recordings, stock.names, strict=True)
    )
    progress(0.9, "checking what was performed")
    done = dataclasses.replace(done, motion=motion)
    piece = Piece(
        done,
        best.course,
        net,
        facts,
        checking.check(done, net),
        parameters,
        wish.places,
        wish.radius or goals.RADIUS,
    )
    told = (
        material.left_out
        + stock.warnings
        + elsewhere.told(serving, part, largest, wish, linger=asked.linger)
        + doubts(
            piece,
            wish,
            ahead,
            most,
            seconds,
            best.shorter,
            whole=(part is largest and wish.to_state is None) or serving is largest,
            progress=lambda share, message="": progress(0.95 + 0.05 * share, message),
        )
    )
    progress(1.0, "performed")
    return dataclasses.replace(piece, performance=dataclasses.replace(done, motion=motion.replace(warnings=told)))


def _why_bent(best: Attempt, asked: float) -> str:
    if best.spared:
        return f", for with {asked:g} the way is {best.spared:.1f} m long instead of {best.course.length:.1f}"
    return "" if best.bend == asked else f", for {asked:g} did not lead there"


def _chosen(net: Network, parameters: Mapping[str, Any], best: Attempt) -> tuple[str, ...]:
    from kinesics import __version__

    return (
        f"transitions up to a mean D of {net.threshold:.3g} ({net.rule})",
        *(f"not used: {pruned}" for pruned in net.pruned),
        f"chosen with seed {parameters['seed']}, beta {parameters['beta']}, bend {best.bend:g} degrees a metre"
        + _why_bent(best, BEND if parameters["bend"] is None else parameters["bend"])
        + ("" if best.via is None else f", by way of ({best.via.place[0]:.1f}, {best.via.place[1]:.1f}) to turn there")
        + f", by kinesics {__version__}",
    )
