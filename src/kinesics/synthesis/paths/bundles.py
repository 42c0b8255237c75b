"""Bundles of composites: chains of paths over the next seconds, spread over all that can be reached after each path.

They are built once, by doubling (chains of one path, then chains followed by chains) and thinned by where they lead: of those that
end in the same cell of place, heading and time the cheapest is kept.

References
----------
Precomputed trees of clips: Lau and Kuffner 2006, *Precomputed search trees*.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.synthesis.paths.trails import Trail, Trails, trails

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Indices = NDArray[np.intp]

SAMPLE: Final = 0.25
"""Seconds between the points of a composite's trail."""
MOST_ROWS: Final = 120_000
"""Composites of a network all together: about 300 bytes each."""
FEWEST: Final = 32
"""Composites that follow one path, if as many differ and the network is large."""
MOST: Final = 128
"""Composites that follow one path, if as many differ and the network is small."""
BRANCHES: Final = 8
"""Chains tried behind each chain when they are doubled, at least."""
TRIED: Final = 250_000
"""Chains tried all together when they are doubled, if each then has no fewer than `BRANCHES`."""
CELL: Final = 0.3
"""Metres; chains that end in the same cell, `SECTOR` and `BEAT` count as the same."""
SECTOR: Final = np.pi / 8.0
"""Radians."""
BEAT: Final = 0.75
"""Seconds."""
HASTY: Final = 1e4
"""Cost of a jump that comes too soon after another: more than any other."""
LEAPING: Final = 1e2
"""Cost of a path in which the recording leaps (`synthesis.joining.faults`): more than any jumps, so that of ways to one place a
sound one is kept."""
NEVER: Final = 1e6
"""Seconds to a jump that does not come."""


class Bundles(NamedTuple):
    """Composites that may follow each path: see `kinesics.synthesis.paths.prospects.Prospects`."""

    start: Indices
    """Of those that begin with each of the network's successors, shape (successors + 1,)."""
    sequence: NDArray[np.int32]
    """Paths of each, −1 after the last: shape (rows, longest)."""
    trail: Trail
    cost: Floats
    """Of all its transitions together, shape (rows,)."""
    first_jump: Floats
    """Seconds until it first leaves a recording, `NEVER` if it does not: shape (rows,)."""


class _Chains(NamedTuple):
    """Composites while they are being built; rows in the order of the network's successors."""

    edge: Indices
    size: Indices
    last: Indices
    place: NDArray[np.complex128]
    heading: Array
    duration: Array
    cost: Array
    first_jump: Array
    since_jump: Array
    haste: NDArray[np.int32]
    """How many jumps come too soon after another."""
    faults: NDArray[np.int32]
    """In how many paths the recording leaps."""

    def taken(self, rows: Indices) -> _Chains:
        return _Chains._make(column[rows] for column in self)

    def followed(self, others: _Chains) -> _Chains:
        """These, and then the others."""
        return _Chains._make(np.concatenate([own, theirs]) for own, theirs in zip(self, others, strict=True))


def _single(network: Network) -> _Chains:
    path = np.asarray(network.indices, dtype=np.intp)
    cost = np.asarray(network.cost, dtype=np.float64)
    jumps = cost > 0.0
    duration = np.asarray(network.duration, dtype=np.float64)[path]
    displacement = np.asarray(network.displacement, dtype=np.float64)[path]
    place, turn = network.met
    return _Chains(
        edge=np.arange(len(path)),
        size=np.ones(len(path), dtype=np.intp),
        last=path,
        place=place + np.exp(1j * turn) * (displacement[:, 1] + 1j * displacement[:, 0]),
        heading=turn + np.asarray(network.turn, dtype=np.float64)[path],
        duration=duration,
        cost=cost,
        first_jump=np.where(jumps, 0.0, NEVER),
        since_jump=np.where(jumps, duration, NEVER),
        haste=np.zeros(len(path), dtype=np.int32),
        faults=network.leaping[path].astype(np.int32),
    )


def _lengthened(
    chains: _Chains,
    sequence: NDArray[np.int32],
    network: Network,
    lookahead: float,
    hold: float,
    rng: np.random.Generator,
) -> tuple[_Chains, NDArray[np.int32]]:
    """_Chains followed by chains, thinned, until all last long enough."""
    successors = np.diff(network.indptr)
    owner_of = np.repeat(np.arange(len(successors)), successors)
    room = np.maximum(np.clip(MOST_ROWS // len(successors), FEWEST, MOST), successors)
    while True:
        owner = owner_of[chains.edge]
        # a chain that nothing follows is as long as it is
        brief = (chains.duration < lookahead) & (successors[chains.last] > 0)
        open_ = np.flatnonzero(brief)
        if not len(open_):
            return chains, sequence
        # those that stay longest in their recording first: jump after jump leads nowhere
        steady = np.lexsort((-chains.first_jump, owner))
        begin = np.searchsorted(owner, np.arange(len(successors)))
        number = np.bincount(owner, minlength=len(successors))
        branches = int(np.clip(TRIED // len(open_), BRANCHES, 8 * BRANCHES))
        head = np.repeat(open_, branches)
        strata = np.tile(np.arange(branches), len(open_)) + rng.random(len(head))
        then = chains.last[head]
        strata[::branches] = 0.0
        tail = steady[begin[then] + ((strata / branches) ** 2 * number[then]).astype(np.intp)]
        joined = _joined(chains, head, tail, hold)
        done = chains.taken(np.flatnonzero(~brief))
        source_head = np.concatenate([np.flatnonzero(~brief), head])
        source_tail = np.concatenate([np.full(len(done.edge), -1), tail])
        everything = done.followed(joined)
        kept = _thinned(everything, owner_of, room, rng)
        sequence = _strung(chains, sequence, source_head[kept], source_tail[kept])
        chains = everything.taken(kept)


def _joined(chains: _Chains, head: Indices, tail: Indices, hold: float) -> _Chains:
    h, t = chains.taken(head), chains.taken(tail)
    never_h, never_t = h.first_jump >= NEVER, t.first_jump >= NEVER
    return _Chains(
        edge=h.edge,
        size=h.size + t.size,
        last=t.last,
        place=h.place + np.exp(1j * h.heading) * t.place,
        heading=h.heading + t.heading,
        duration=h.duration + t.duration,
        cost=h.cost + t.cost,
        first_jump=np.where(never_h, np.minimum(h.duration + t.first_jump, NEVER), h.first_jump),
        since_jump=np.where(never_t, np.minimum(h.since_jump + t.duration, NEVER), t.since_jump),
        haste=(h.haste + t.haste + (~never_h & ~never_t & (h.since_jump + t.first_jump < hold))).astype(np.int32),
        faults=h.faults + t.faults,
    )


def _thinned(chains: _Chains, owner_of: Indices, room: Indices, rng: np.random.Generator) -> Indices:
    """Rows to keep, in the order of the network's successors: one of a cell, each successor's best among them."""
    owner = owner_of[chains.edge]
    chance = rng.random(len(owner))
    x, z = np.floor(chains.place.imag / CELL), np.floor(chains.place.real / CELL)
    cell = ((x + 1000) * 2000 + z + 1000) * 1024
    cell = cell + (np.floor(chains.heading / SECTOR) % 16) * 64 + np.minimum(chains.duration // BEAT, 63)
    cell += (owner * 2000.0 * 2000.0) * 1024.0
    # fewest hasty jumps, then fewest faults, then least cost, then chance, as one number
    dear = chains.cost + HASTY * chains.haste + LEAPING * chains.faults + 1e-6 * chance
    order = np.lexsort((dear, cell))
    fresh = np.ones(len(order), dtype=np.bool_)
    fresh[1:] = np.diff(cell[order]) != 0
    candidates = np.zeros(len(order), dtype=np.bool_)
    candidates[order[fresh]] = True
    order = np.lexsort((dear, chains.edge))
    fresh[1:] = np.diff(chains.edge[order]) != 0
    must = np.zeros(len(order), dtype=np.bool_)
    must[order[fresh]] = True
    rows = np.flatnonzero(candidates & (chains.haste == 0) | must)
    # the fastest way out in each direction first: it is what one needs to get anywhere
    bearing = np.floor(np.angle(chains.place[rows]) / SECTOR) * 16 + np.floor(chains.heading[rows] / SECTOR) % 16
    pace = np.abs(chains.place[rows]) / chains.duration[rows]
    order = np.lexsort((-pace, chains.haste[rows], bearing, owner[rows]))
    fresh = np.ones(len(order), dtype=np.bool_)
    fresh[1:] = (np.diff(owner[rows][order]) != 0) | (np.diff(bearing[order]) != 0)
    outermost = np.zeros(len(order), dtype=np.bool_)
    outermost[order[fresh]] = True
    order = rows[np.lexsort((chance[rows], chains.haste[rows], ~outermost, ~must[rows], owner[rows]))]
    place = np.arange(len(order)) - np.searchsorted(owner[order], owner[order])
    kept = order[place < room[owner[order]]]
    return kept[np.argsort(chains.edge[kept], kind="stable")]


def _strung(chains: _Chains, sequence: NDArray[np.int32], head: Indices, tail: Indices) -> NDArray[np.int32]:
    """The paths of chains followed by chains (−1: by none)."""
    before = chains.size[head]
    after = np.where(tail < 0, 0, chains.size[tail])
    out = np.full((len(head), int((before + after).max())), -1, dtype=np.int32)
    width = sequence.shape[1]
    out[:, :width] = sequence[head]
    for column in range(width):
        rows = np.flatnonzero(column < after)
        out[rows, before[rows] + column] = sequence[tail[rows], column]
    return out


def bundled(network: Network, lookahead: float, hold: float, rng: np.random.Generator) -> Bundles:
    """The bundles of all paths; for what is drawn, ``rng``."""
    chains = _single(network)
    sequence = chains.last.astype(np.int32)[:, None]
    if lookahead > 0.0:
        chains, sequence = _lengthened(chains, sequence, network, lookahead, hold, rng)
    start = np.searchsorted(chains.edge, np.arange(len(network.indices) + 1)).astype(np.intp)
    return Bundles(
        start,
        sequence,
        _sampled(chains, sequence, network, trails(network), lookahead),
        chains.cost.astype(np.float32),
        chains.first_jump.astype(np.float32),
    )


def _sampled(chains: _Chains, sequence: NDArray[np.int32], network: Network, ways: Trails, lookahead: float) -> Trail:
    """Trails at regular times (at the end, if nothing is looked ahead to)."""
    rows = len(chains.edge)
    if lookahead > 0.0:
        times = SAMPLE * np.arange(1.0, max(1, round(lookahead / SAMPLE)) + 1.0)
        places = np.zeros((rows, len(times)), dtype=np.complex128)
        headings = np.zeros((rows, len(times)))
        playing = np.zeros((rows, len(times)), dtype=np.int32)
        _follow(chains.edge, sequence, network, ways, times, places, headings, playing)
        strides = np.diff(places, axis=1, prepend=0.0)
        lengths = np.abs(strides)
        travelled = np.cumsum(lengths, axis=1)
        swerve = np.cumsum(1j * (travelled - lengths / 2.0) * strides, axis=1)
        clock = times[None]
    else:
        places, headings = chains.place[:, None], chains.heading[:, None]
        clock = chains.duration[:, None]
        path = chains.last
        playing = path.astype(np.int32)[:, None]
        end = ways.start[path] + np.asarray(network.length, dtype=np.intp)[path]
        travelled = ways.travelled[end][:, None]
        # bent evenly over its length, a straight way turns by half the angle
        swerve = 0.5j * travelled * places
    return Trail(
        clock.astype(np.float32),
        places.astype(np.complex64),
        headings.astype(np.float32),
        travelled.astype(np.float32),
        swerve.astype(np.complex64),
        playing,
    )


def _follow(
    edge: Indices,
    sequence: NDArray[np.int32],
    network: Network,
    ways: Trails,
    times: Array,
    places: NDArray[np.complex128],
    headings: Array,
    playing: NDArray[np.int32],
) -> None:
    """Fill in where each chain is at each of the times, and which path it plays."""
    fps = network.repertoire.fps
    lengths = np.asarray(network.length, dtype=np.intp)
    frames = np.round(times * fps).astype(np.intp)
    at = np.zeros(len(sequence), dtype=np.complex128)
    facing = np.zeros(len(sequence))
    passed = np.zeros(len(sequence), dtype=np.intp)
    live = np.arange(len(sequence))
    place_met, turn_met = network.met
    for column in range(sequence.shape[1]):
        live = live[(sequence[live, column] >= 0) & (passed[live] < frames[-1])]
        if not len(live):
            break
        path = sequence[live, column]
        way = edge[live] if column == 0 else network.edges(sequence[live, column - 1], path)
        at[live] += np.exp(1j * facing[live]) * place_met[way]
        facing[live] += turn_met[way]
        until = passed[live] + lengths[path]
        for k, frame in enumerate(frames):
            here = (passed[live] < frame) & (frame <= until)
            rows = live[here]
            point = ways.start[path[here]] + frame - passed[rows]
            places[rows, k] = at[rows] + np.exp(1j * facing[rows]) * ways.places[point]
            headings[rows, k] = facing[rows] + ways.headings[point]
            playing[rows, k] = path[here]
        end = ways.start[path] + lengths[path]
        at[live] += np.exp(1j * facing[live]) * ways.places[end]
        facing[live] += ways.headings[end]
        passed[live] = until
