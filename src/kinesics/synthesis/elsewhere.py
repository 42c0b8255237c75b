"""Where what is wished for lies in another part of the recordings than the largest that holds together, that part is performed.

A way from state to state needs none that leads back: where no part holds both, what lies on ways from the one to the other is. Nor
does a beginning: from a state that nothing leads back to one goes into the part that goes on.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.synthesis.goals.naming import paths_of, states_of
from kinesics.synthesis.goals.states import LONGEST
from kinesics.synthesis.joining import faults
from kinesics.synthesis.joining.parts import draft, round_about
from kinesics.synthesis.joining.transitions import Transitions
from kinesics.synthesis.paths import ways
from kinesics.synthesis.paths.network import part_of
from kinesics.synthesis.repertoire import LEAST_SECONDS, Repertoire

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network
    from kinesics.synthesis.wish import Wish

Mask = NDArray[np.bool_]

MOST_PARTS: Final = 24
"""Parts that are looked through, the largest first."""


def serving(net: Network, wish: Wish, found: Transitions, made: Callable[[Mask], Network]) -> Network:
    """The network itself, or, where nothing in it is of the name wished for, that of the part in which most is.

    Parameters
    ----------
    net : of the largest part.
    found : all transitions.
    made : the network, with the grammar's words, of the part that holds most of some frames.
    """
    if _wished(net, wish) > 0.0:
        return net
    best, most = _serving(net, wish, found, made)
    if most == 0.0 and wish.from_state is not None and wish.to_state is None and wish.favour is not None:
        # one can begin elsewhere (`way_in`)
        freely = dataclasses.replace(wish, from_state=None)
        best = net if _wished(net, freely) > 0.0 else _serving(net, freely, found, made)[0]
    return best


def _serving(net: Network, wish: Wish, found: Transitions, made: Callable[[Mask], Network]) -> tuple[Network, float]:
    """The network of the part in which most is of the name wished for, and how many seconds; the network itself if nothing is."""
    best, most = net, 0.0
    for frames in _parts(net.repertoire, found):
        try:
            other = made(frames)
        except InputError:
            continue
        seconds = _wished(other, wish)
        if seconds > most:
            best, most = other, seconds
    return best, most


def way_in(net: Network, wish: Wish, whole: Callable[[], Network]) -> Network:
    """The network itself, or, where it does not hold the state that is to be begun in and nothing else is gone for, with all ways
    that lead from there into it: no way need lead back.

    Parameters
    ----------
    whole : all paths there are, with the grammar's words.

    Raises
    ------
    InputError
        If no way leads from there into it.
    """
    begin = wish.from_state
    if begin is None or wish.to_state is not None or begin in net.state_from:
        return net
    every = whole()
    begins, lasting = np.asarray(every.state_from) == begin, _within(every, net)
    led = ways.led_to(every, begins)
    kept = led & ways.leading_there(every, lasting)
    if not (begins & kept).any():
        raise InputError(
            f"From the state {begin!r} no way leads to where one could go on without end, only to "
            f"{_listed(itertools.compress(every.state_to, led), begin)}: say which to go to, `to_state` (--to); or begin in one of "
            f"{_listed(net.state_from, '')}, or give longer recordings, in which it returns."
        )
    return part_of(every, kept | lasting)


def _within(every: Network, net: Network) -> Mask:
    """Which of all paths play nothing but what a network of larger ones plays."""
    stock = net.repertoire
    played = np.zeros(stock.moment_count + 1, dtype=np.intp)
    ends = np.sort(np.stack([net.first, net.last]), axis=0)
    np.add.at(played, ends[0], 1)
    np.add.at(played, ends[1] + 1, -1)
    inside = np.cumsum(played) > 0
    return np.asarray(inside[every.first] & inside[every.last])


def way_there(net: Network, wish: Wish, whole: Callable[[], Network]) -> Network:
    """The network itself, or, where it does not hold both states wished for, all ways from the one to the other, with what is
    gone just before and after: nothing need lead back.

    Parameters
    ----------
    whole : all paths there are, with the grammar's words.

    Raises
    ------
    InputError
        If no way leads from the one state to the other.
    """
    begin, end = wish.from_state, wish.to_state
    if begin is None or end is None or (begin in net.state_from and end in net.state_to):
        return net
    every = whole()
    begins, ends = np.asarray(every.state_from) == begin, np.asarray(every.state_to) == end
    kept = ways.between(every, begins, ends, LONGEST)
    if not kept.any():
        raise InputError(_no_way(every, begin, end, begins, ends))
    return part_of(every, kept)


def _no_way(every: Network, begin: str, end: str, begins: Mask, ends: Mask) -> str:
    """That there is none, and which there are."""
    onward, hither = ways.led_to(every, begins), ways.leading_there(every, ends)
    leads = f"from {begin!r} one comes to {_listed(itertools.compress(every.state_to, onward), begin)}"
    comes = f"to {end!r} from {_listed(itertools.compress(every.state_from, hither), end)}"
    return (
        f"No way leads from the state {begin!r} to the state {end!r}: neither the recordings go there nor any transition; {leads}, "
        f"{comes}. Ask for one of these, give recordings in which it is gone, or a larger `threshold` (--threshold) than "
        f"{every.threshold:.3g}."
    )


def _listed(states: Iterable[str], but: str) -> str:
    return ", ".join(sorted(set(states) - {"", but})) or "no other"


def told(net: Network, part: Network, largest: Network, wish: Wish, *, linger: bool = False) -> tuple[str, ...]:
    """That not the largest part is performed, and what for.

    Parameters
    ----------
    net : of what is performed.
    part : what served best (`serving`): where that is not the same, the ways from one state to another alone are performed
        (`way_there`), or those from a state into it, too (`way_in`).
    linger : whether one was to go on from there.
    """
    if net is not part and wish.to_state is not None:
        return (
            f"performed is what lies on ways from {wish.from_state!r} to {wish.to_state!r}, or just before or after, "
            f"{net.seconds:.1f} s: not all of it belongs to the largest part of the recordings that holds together, "
            f"{largest.seconds:.1f} s, so that nothing need lead back"
            + (
                "; it ends there (`linger`, --linger), for not everything goes on" if linger and not net.endless else ""
            ),
        )
    if part is largest:
        return ()
    begun = wish.from_state if net is part else None
    names = dict.fromkeys(n for n in (wish.favour, begun, wish.to_state) if n is not None)
    wanted = " and ".join(repr(name) for name in names)
    return (
        f"performed is the part of the recordings that holds {wanted}, {part.seconds:.1f} s; no transition leads from there to the "
        f"largest part that holds together, {largest.seconds:.1f} s, and back again",
    )


def _wished(net: Network, wish: Wish) -> float:
    """Seconds of what is wished for by name; 0 where any of it is not there."""
    seconds = float(net.seconds)
    try:
        for state, end in ((wish.from_state, "from"), (wish.to_state, "to")):
            if state is not None:
                states_of(net, state, end)
        if wish.favour is not None:
            seconds = float(net.duration[paths_of(net, wish.favour)].sum())
    except InputError:
        return 0.0
    return seconds


def _parts(stock: Repertoire, found: Transitions) -> Iterator[Mask]:
    """Frames of each part that holds together, the largest first; of mirror images one."""
    cut = draft(stock, found.source, found.target, faults.edges(stock.faults, stock.starts))
    seen: set[bytes] = set()
    for part in sorted(round_about(cut), key=lambda part: -int(cut.length[part].sum()))[: 2 * MOST_PARTS]:
        frames = np.zeros(stock.frame_count, dtype=np.bool_)
        ends = np.sort(stock.frame_of(np.stack([cut.first[part], cut.last[part]])), axis=0)
        for start, end in zip(*ends.tolist(), strict=True):
            frames[start : end + 1] = True
        if frames.tobytes() not in seen and cut.length[part].sum() >= LEAST_SECONDS * stock.fps:
            seen.add(frames.tobytes())
            yield frames
