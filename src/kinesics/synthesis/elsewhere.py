"""Where what is wished for lies in another part of the recordings than the largest that holds together, that part is performed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.synthesis import faults
from kinesics.synthesis.goals.naming import paths_of, states_of
from kinesics.synthesis.parts import draft, round_about
from kinesics.synthesis.repertoire import LEAST_SECONDS, Repertoire
from kinesics.synthesis.transitions import Transitions

if TYPE_CHECKING:
    from kinesics.synthesis.network import Network
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
    best, most = net, 0.0
    for frames in _parts(net.repertoire, found):
        try:
            other = made(frames)
        except InputError:
            continue
        seconds = _wished(other, wish)
        if seconds > most:
            best, most = other, seconds
    return best


def told(net: Network, largest: Network, wish: Wish) -> tuple[str, ...]:
    """That not the largest part is performed, and what for."""
    if net is largest:
        return ()
    names = dict.fromkeys(n for n in (wish.favour, wish.from_state, wish.to_state) if n is not None)
    wanted = " and ".join(repr(name) for name in names)
    return (
        f"performed is the part of the recordings that holds {wanted}, {net.seconds:.1f} s; no transition leads from there to the "
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
