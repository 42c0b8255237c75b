"""What of a performance is doubtful: what was measured beside what it may be, what was wished for beside what came of it."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from kinesics.body import kinematics
from kinesics.errors import some_of
from kinesics.progress import Progress, silent
from kinesics.synthesis import rounds, staying, unused
from kinesics.synthesis.attempts import MOST_BEND, Shorter
from kinesics.synthesis.embodiment.checking import ROUNDING, SLIDE, SUNK, Slid
from kinesics.synthesis.embodiment.pivots import steps_of
from kinesics.synthesis.embodiment.stage import FLESH, Stage
from kinesics.synthesis.goals.states import way_between
from kinesics.synthesis.paths.prospects import Prospects
from kinesics.synthesis.piece import SWAY, Piece, distance_to_line, way_of
from kinesics.synthesis.repertoire import LEAST_SECONDS, THROWN
from kinesics.synthesis.wish import HARDLY, MOST_SECONDS, SPARE, Wish

MOSTLY: Final = 0.5
"""Share of the recordings that is not used, from which that is doubtful."""
NAMED: Final = 6
"""Recordings of which it is told how much is used."""
STILL: Final = 0.25
"""Share of the time in which the recordings move, below which who moves stands nearly still."""
REPEATED: Final = 5.0
"""Times that every moment comes, from which it is said that there is little to choose from."""
ROUND_AND_ROUND: Final = 2.0
"""Seconds in one loop of less than a second, from which it is told."""
ROUNDABOUT: Final = 2.0
"""Times the straight way to a target, from which it is said that the way is long, and what shortens it."""
AT_LEAST: Final = 5.0
"""Metres round, below which nothing is said of it: nobody turns on the spot."""
BESIDE: Final = 0.3
"""Metres from a route, in the median, above which it is told how it was followed: more than a body sways."""
FAR_BESIDE: Final = 1.0
"""The same at the worst: more than a step."""
SHORT: Final = 0.25
"""Seconds of a way from state to state, below which hardly anything of it is to be seen."""
SEEN: Final = 1.0
"""Seconds of a performance from which the two states are seen, at least, however short the way."""
NEAR_CUT: Final = 0.3
"""Seconds from a transition, up to which that may have moved a foot: a blend, and what it takes to settle."""
BY_CUTS: Final = 0.5
"""Share of the way that a foot slides in a contact that lies so near transitions, from which they are what moves it."""


def doubts(
    piece: Piece,
    wish: Wish,
    ahead: Prospects,
    most: float,
    seconds: float | None,
    shorter: Shorter | None = None,
    *,
    whole: bool = True,
    progress: Progress = silent,
) -> tuple[str, ...]:
    """What did not go as wished, what does not stay where the recordings were, and what helps.

    Parameters
    ----------
    most : seconds that were allowed.
    seconds : those that were asked for, if any were.
    shorter : how one would come to the place by a far shorter way, if that was found.
    whole : whether what can be performed is the largest part that holds together, not another that was wished for.
    progress : called as a larger threshold is tried, where most of the recordings is not used.
    """
    said = (
        _unused(piece, whole, progress),
        _pose(piece, seconds),
        _stays(piece, wish),
        _repeated(piece, wish),
        _round_and_round(piece),
        _there_already(piece, wish),
        _missed(piece, wish, ahead, most, seconds),
        _beside(piece, wish),
        _roundabout(piece, wish, shorter),
        _short(piece, wish),
        _leapt(piece),
        *_slid(piece),
        _jolted(piece),
        _jerked(piece),
        _beyond(piece),
    )
    return tuple(line for line in said if line)


def _unused(piece: Piece, whole: bool, progress: Progress) -> str:
    """What hardly anything is performed of: of all of it together, or of a recording."""
    net = piece.network
    none_of = list(dict.fromkeys(p.recording for p in piece.pruned if p.everything))
    if whole and unused.used(net).unused >= MOSTLY:
        shown, total = unused.used_of_each(net), unused.used(net)
        of = ", ".join(f"of '{one.name}' {_of(one.seconds)}" for one in shown[:NAMED])
        if more := shown[NAMED:]:
            rest = unused.Used(*(sum(one.seconds[k] for one in more) for k in range(2)))
            of += f", of {len(more)} more {_of(rest)}"
        return (
            f"most of what was recorded is not used: {total.used:.1f} of {total.recorded:.1f} s hold together"
            + (f" ({of})" if len(shown) > 1 else "")
            + f"; no way leads to the rest, or none back. {_joining(piece, progress)}"
            + (f"; or perform from {some_of(none_of)} alone, or favour it (--favour)" if none_of else "")
        )
    if not none_of:
        return ""
    return (
        f"nothing is performed of {some_of(none_of, 8)}: no transition leads there and back again; longer "
        "recordings, or others nearer in pose, speed and footing, would join it; or perform from it alone, or favour it (--favour)"
    )


def _of(seconds: unused.Used) -> str:
    return f"{seconds.used:.1f} of {seconds.recorded:.1f} s"


def _joining(piece: Piece, progress: Progress) -> str:
    """What would make it more."""
    net = piece.network
    others = "longer recordings, or more that are like them in pose, speed and footing, would join it"
    if unused.too_many(net):
        return f"A larger `threshold` (--threshold) than {net.threshold:.2g} may join it; {others}"
    larger = unused.larger_threshold(net, progress)
    if larger is None:
        return f"No larger `threshold` joins much more; {others}"
    return (
        f"`threshold` {larger.threshold:g} (--threshold {larger.threshold:g}) makes it {larger.seconds.used:.1f} s, by "
        f"transitions between moments less alike; {others} as smoothly"
    )


def _pose(piece: Piece, seconds: float | None) -> str:
    """That there was no time for more than a single frame."""
    if piece.motion.frame_count > 1 or seconds is None:
        return ""
    return f"a single pose, in which nothing moves: {seconds:g} s (--seconds) at {piece.motion.fps:g} frames a second; give more"


def _stays(piece: Piece, wish: Wish) -> str:
    """That the body stays where it is, or as it is, though the recordings do not."""
    if wish.ends or wish.favour is not None or piece.stays is None or piece.motion.duration < LEAST_SECONDS:
        return ""
    where = f"for all of {piece.motion.duration:.1f} s, within {_metres(piece.stays)} of where it begins"
    helps = "give another seed (--seed), what to favour (--favour), or a place to go to (`target`, --target)"
    net = piece.network
    moves, recorded = staying.moving(piece), staying.moving_recorded(net.repertoire)
    if moves < STILL * recorded:
        no_more = staying.moving_recorded(net.repertoire, unused.frames_of(net)) < STILL * recorded
        return (
            f"the body stands nearly still {where}: it moves in {moves:.0%} of the time, in the recordings in {recorded:.0%}; "
            + ("what moves more is among what is not used" if no_more else helps)
        )
    going = staying.going_about(piece)
    if not going:
        return ""
    usable = {one.name for one in unused.used_of_each(net) if one.seconds.unused < MOSTLY}
    return f"the body stays in place {where}, though in {some_of(going, 8)} it goes about; " + (
        helps if usable.intersection(going) else "most of that is not used"
    )


def _metres(metres: float) -> str:
    return f"{100.0 * metres:.0f} cm" if metres < 0.1 else f"{metres:.2f} m"


def _repeated(piece: Piece, wish: Wish) -> str:
    times = piece.motion.duration / piece.network.seconds
    if wish.ends or times < REPEATED:
        return ""
    often = often_played(piece)
    return (
        f"every moment comes about {times:.0f} times"
        + (f", {often}" if often else "")
        + f": only {piece.network.seconds:.1f} s can be performed"
        f"{', mirror images counted' if piece.parameters['mirrored'] else ''}; give longer recordings, or more that are like "
        "one another"
    )


def often_played(piece: Piece) -> str:
    """What is played far more often than the rest, and how often; empty where nothing is."""
    most = rounds.played_most(piece.course, piece.network)
    return f"{_frames(piece, most)} {most.times} times" if most else ""


def _round_and_round(piece: Piece) -> str:
    """A loop too short not to be seen."""
    loop = rounds.longest_loop(piece.course, piece.network)
    if loop is None or loop.seconds < ROUND_AND_ROUND:
        return ""
    return (
        f"{loop.seconds:.1f} of {piece.motion.duration:.1f} s stay in a loop of {loop.period:.2g} s: {_frames(piece, loop)}, "
        f"{loop.rounds} times; no other way on was found from there, or none that serves what is wished for; give longer "
        "recordings, or more that are like them"
    )


def _frames(piece: Piece, stretch: rounds.Loop | rounds.Often) -> str:
    where = f"frames {stretch.first}–{stretch.end - 1}"
    return where if len(piece.sources) == 1 else f"{where} of {piece.sources[stretch.recording].name}"


def _there_already(piece: Piece, wish: Wish) -> str:
    if not wish.places or wish.least_metres > 0.0 or piece.parameters["linger"] or len(wish.places) > 1:
        return ""
    return (
        f"where to go lies within {wish.radius:g} m (`radius`, --within) of where one starts: one is there at once, after "
        f"{piece.motion.duration:.2g} s; give a place farther off, a smaller radius, or `linger` (--linger) with `seconds` "
        "(--seconds)"
    )


def _missed(piece: Piece, wish: Wish, ahead: Prospects, most: float, seconds: float | None) -> str:
    """That the goal was not attained, and what helps."""
    if not wish.attainable or piece.attained:
        return ""
    told = "; ".join(piece.outcome) or "the goal was not attained"
    if piece.course.attained and wish.places:
        return (
            f"{told}: the way that was chosen leads there, but keeping the feet in place takes the body beside it; give another "
            "seed or a lower `fps` (--fps), or recordings whose feet slide less"
        )
    if wish.least_metres > most * ahead.fastest:
        return (
            f"{told}: {wish.least_metres:.1f} m at {ahead.fastest:.2f} m/s, the fastest there is, take longer than {most:g} s; "
            "give more seconds"
        )
    if wish.target is not None and _hopeless(piece, wish, ahead):
        return (
            f"{told}: no way there was found with these recordings; give recordings that turn more, another seed, or allow "
            "more `bend` (--bend)"
        )
    if not wish.places and wish.route is None:
        return f"{told}: give more seconds"
    advice = "give more seconds, another seed, or recordings that turn more"
    if seconds is None and most < MOST_SECONDS:
        advice = "give another seed, or recordings that turn more"
    elif seconds is None:
        advice = f"{most:g} s are given where nothing is said; give more `seconds` (--seconds), or another seed"
    if ahead.pace < HARDLY:
        advice += f"; these hardly get about ({ahead.pace:.2f} metres a second in a straight line)"
    return f"{told}: {advice}"


def _hopeless(piece: Piece, wish: Wish, ahead: Prospects) -> bool:
    """Whether no way to the target was found from where the performer began."""
    assert wish.target is not None
    x, z = wish.target.position
    bend = math.radians(piece.parameters["bend_used"])
    tables = ahead.to_go(wish.radius - SPARE, bend)
    return tables.hopeless(int(piece.course.paths[0]), complex(z, x))


def _beside(piece: Piece, wish: Wish) -> str:
    """A route that the body was far from, though it came to its end."""
    if wish.route is None:
        return ""
    # who begins elsewhere than the route goes there first
    away = distance_to_line(piece.trail, np.array([(0.0, 0.0), *np.asarray(wish.route.points).tolist()]))
    worst = int(np.argmax(away))
    median, farthest = float(np.median(away)), float(away[worst])
    if median <= BESIDE and farthest <= FAR_BESIDE:
        return ""
    bend = float(piece.parameters["bend_used"])
    more = f"more `bend` (--bend {max(2.0 * bend, 10.0):g})" if bend < MOST_BEND else "another seed (--seed)"
    return (
        f"the body is {median:.2f} m beside the route in the median, {farthest:.1f} m at the worst, at "
        f"{worst / piece.motion.fps:.1f} s ({BESIDE:g} and {FAR_BESIDE:g} m are let pass): recordings that turn more, a route of "
        f"wider turns, or {more} may keep it nearer"
    )


def _roundabout(piece: Piece, wish: Wish, shorter: Shorter | None) -> str:
    """A place that was come to by a long way round."""
    if not piece.attained or not piece.places:
        return ""
    went = way_of(piece.trail[: piece.visits[-1] + 1], SWAY * piece.motion.fps)
    if went < ROUNDABOUT * wish.metres or went - wish.metres < AT_LEAST:
        return ""
    bend = float(piece.parameters["bend_used"])
    helps = "recordings that turn more may shorten it"
    if shorter is not None:
        helps = f"`bend` {shorter.bend:g} (--bend {shorter.bend:g}) leads there in about {shorter.metres:.1f} m"
    elif bend < MOST_BEND:
        helps = f"more `bend` (--bend {max(2.0 * bend, 10.0):g}) or {helps}"
    return (
        f"came there by a long way round, {went:.1f} m instead of {wish.metres:.1f} m straight on: these recordings hardly turn as "
        f"they would have to; {helps}"
    )


def _short(piece: Piece, wish: Wish) -> str:
    """A way from state to state that is over before it is seen, whatever is performed before and after it."""
    if wish.to_state is None or not piece.attained:
        return ""
    assert wish.from_state is not None
    way = way_between(piece.network, wish.from_state, wish.to_state)
    seconds = 0.0 if way is None else float(piece.network.duration[way].sum())
    if seconds >= SHORT:
        return ""
    told = f"the way from {wish.from_state} to {wish.to_state} lasts {seconds:.2g} s"
    if piece.motion.duration >= SEEN:
        return f"{told} of {piece.motion.duration:.1f}: the recordings pass so quickly from the one to the other"
    return (
        f"{told}: where the recordings pass so quickly from the one to the other there is hardly more to be seen; `linger` "
        "(--linger) with `seconds` (--seconds) goes on from there"
    )


def _leapt(piece: Piece) -> str:
    """Faults of the recordings that had to be performed."""
    stock = piece.network.repertoire
    played = stock.faults[stock.frame_of(piece.course.moments)]
    begins = np.flatnonzero(np.diff(played, prepend=False) & played) / piece.motion.fps
    if not len(begins):
        return ""
    shown = ", ".join(f"{second:.1f} s" for second in begins[:4].tolist())
    more = _more(len(begins) - 4)
    return (
        f"the body leaps at {shown}{more} as it does in the recordings, by more than {100 * THROWN:g} cm from one frame to the "
        "next: what was wished for leads through these faults, or nothing else goes on from there; mend them, or give other "
        "recordings"
    )


def _more(times: int) -> str:
    return "" if times <= 0 else " and once more" if times == 1 else f" and {times} times more"


def _slid(piece: Piece) -> list[str]:
    """Feet that slide: those beside transitions, which another seed may do without, and those that slide without one."""
    found, fps = piece.check, piece.motion.fps
    if not found.slid:
        return []
    worst = max(found.slid, key=lambda slid: slid.slide)
    alone = [slid for slid in found.slid if _by_cuts(piece, slid) < BY_CUTS]
    out = (
        f"feet slide more than {100 * SLIDE:g} cm in {found.slides} of {found.contacts} contacts, the {worst.foot} one by "
        f"{100 * worst.slide:.1f} cm from {worst.start / fps:.1f} to {worst.end / fps:.1f} s"
    )
    advice = []
    if len(alone) < found.slides:
        advice.append(
            "another seed (--seed) takes other transitions, longer recordings or more that are like them give better ones"
        )
    if alone:
        which = "" if len(alone) == found.slides else f"in {len(alone)} of these "
        lies = "it lies in the recordings, and only others help"
        if len(piece.sources) > 1:
            lies = (
                "it lies in the recordings, or in feet that are unlike in them, and others help, or one of them alone"
            )
        advice.append(f"{which}no transition is near where they slide: {lies}")
    return [f"{out}; {'; '.join(advice)}"]


def _jolted(piece: Piece) -> str:
    """Ankles that leap where the recordings do not."""
    leaps, fps = piece.check.leaps, piece.motion.fps
    if not leaps:
        return ""
    shown = ", ".join(f"{leap.frame / fps:.2f} s ({leap.foot})" for leap in leaps[:4])
    more = _more(len(leaps) - 4)
    return (
        f"an ankle is thrown off its way for a frame at {shown}{more}: there the recording's foot turns or slides so quickly "
        "while it bears that the leg must follow; another seed (--seed) may do without"
    )


def _jerked(piece: Piece) -> str:
    """Joints that turn in a frame as they never do in the recordings."""
    jerked, fps = piece.check.jerked, piece.motion.fps
    if not jerked:
        return ""
    shown = ", ".join(f"{j.joint} by {math.degrees(j.turn):.0f}° at {j.frame / fps:.2f} s" for j in jerked[:4])
    return (
        f"joints turn more from one frame to the next than ever in the recordings: {shown}{_more(len(jerked) - 4)}; another seed "
        "(--seed) may do without"
    )


def _by_cuts(piece: Piece, slid: Slid) -> float:
    """Share of the way that a foot slides that lies near transitions: a contact may last through many of them."""
    motion, done = piece.motion, piece.performance
    part = slice(slid.start, slid.end)
    side = ("left", "right").index(slid.foot)
    known = kinematics.forward(motion.skeleton, motion.rotations[part], motion.root_positions[part])
    points = done.soles.place(known.positions, known.rotations)[:, side]
    height = points[..., 1] - Stage.of(piece.network.repertoire).levels[side]
    gone = np.linalg.norm(steps_of(points, height, motion.fps), axis=1)
    between = np.arange(slid.start, slid.end - 1) + 0.5
    near = (np.abs(between[:, None] - done.cuts) <= NEAR_CUT * motion.fps).any(axis=1)
    return float(gone[near].sum() / max(gone.sum(), 1e-9))


def _beyond(piece: Piece) -> str:
    """What else was measured that is more than it may be."""
    found = piece.check
    said = []
    if found.below_floor > SUNK:
        said.append(f"a sole is {100 * found.below_floor:.1f} cm below the floor ({100 * SUNK:g} cm is let pass)")
    if found.beyond_range > ROUNDING:
        said.append(f"a joint is {math.degrees(found.beyond_range):.2g}° beyond its range in the recordings")
    if found.deeper > FLESH:
        said.append(
            f"limbs are {1000 * found.deeper:.1f} mm deeper in each other than in the recordings ({1000 * FLESH:g} mm is let "
            "pass)"
        )
    if found.distance > found.accepted:
        said.append(
            f"a pose is farther from the recordings, by D {found.distance:.2g}, than transitions may be ({found.accepted:.2g})"
        )
    if not said:
        return ""
    return "; ".join(said) + ": another seed (--seed) may do without, or more recordings that are like these"
