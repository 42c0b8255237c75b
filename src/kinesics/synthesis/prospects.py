"""What may come after each path: the paths that may follow it, or whole composites of them over the next seconds.

The Markov controller of [Schultz2012] §4.4.1 weighs each path that may follow by what that path alone does. Walking towards
something needs more: a step to the left is good because of the two steps that can follow it. So, as an extension beyond the
dissertation, every path is given beforehand a bundle of *composites*, chains of paths over the next seconds that lie spread
over all that can be reached. They are built once, by doubling (chains of one path, then chains followed by chains) and
thinned by where they lead: of those that end in the same cell of place, heading and time the cheapest is kept. Looking ahead
0 seconds the composites are the single paths, and the controller is the dissertation's.

On the ground a place is one complex number, z + i·x: a turn by an angle ψ (radians about +y, positive to the left) is then a
product with e^{iψ}. Places and headings of a path or composite are relative to those at its first frame.

References
----------
[Schultz2012] §4.4. Precomputed trees of clips: Lau and Kuffner 2006, *Precomputed search trees*.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.synthesis import faults
from kinesics.synthesis.togo import ToGo, to_go

if TYPE_CHECKING:
    from kinesics.synthesis.network import Network

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Places = NDArray[np.complex64]
Indices = NDArray[np.intp]

LOOKAHEAD: Final = 2.0
"""Seconds that composites last at least, if nothing else is said."""
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
AT_ONCE: Final = 1.0
"""Seconds within which coming back to a moment is seen: a cycle of walking lasts as long, a bow or a wave longer."""
SOON: Final = 4.0
"""What a frame plays counts e times less for every such part of the lookahead that it comes later."""
HASTY: Final = 1e4
"""Cost of a jump that comes too soon after another: more than any other."""
LEAPING: Final = 1e2
"""Cost of a path in which the recording leaps (`kinesics.synthesis.faults`): more than any jumps, so that of ways to one place a
sound one is kept."""
NEVER: Final = 1e6
"""Seconds to a jump that does not come."""


class Trails(NamedTuple):
    """Where the root goes within each path, frame by frame, relative to the path's first frame."""

    start: Indices
    """Of each path in the arrays below; it has ``length + 1`` points, at the last of which the next path begins: (paths,)."""
    places: NDArray[np.complex128]
    """z + i·x, metres, shape (points,)."""
    headings: Array
    """Radians, shape (points,)."""
    travelled: Array
    """Metres along the way, shape (points,)."""


class Trail(NamedTuple):
    """Where composites lead, point by point: rows are composites that are weighed against each other."""

    times: Floats
    """Seconds from the composite's beginning, shape (1 or rows, points)."""
    places: Places
    """z + i·x as seen from the first frame, metres, shape (rows, points)."""
    headings: Floats
    """Radians turned, shape (rows, points)."""
    travelled: Floats
    """Metres walked, shape (rows, points)."""
    swerve: Places
    """How the places move if the way is bent by 1 radian a metre, to first order: shape (rows, points)."""
    playing: NDArray[np.int32]
    """The path that is being played: shape (rows, points)."""


@dataclass(frozen=True, eq=False)
class Prospects:
    """Composites that may follow each path. Those that begin with successor ``e`` of the network's list of successors are
    rows ``start[e]:start[e + 1]``, so that what may follow path ``i`` lies together.
    """

    lookahead: float
    """Seconds; 0 for single paths."""
    start: Indices
    """Shape (successors + 1,)."""
    sequence: NDArray[np.int32]
    """Paths of each composite, −1 after the last: shape (rows, longest)."""
    trail: Trail
    """Every `SAMPLE` seconds; at the end, if nothing is looked ahead to."""
    cost: Floats
    """Of all its transitions together, that into its first path included: shape (rows,)."""
    first_jump: Floats
    """Seconds until it first leaves a recording, `NEVER` if it does not: shape (rows,)."""
    rows: Indices
    """Those that may follow path ``i`` are ``rows[i]:rows[i + 1]``: shape (paths + 1,)."""
    duration: Array
    """Seconds of each path, shape (paths,)."""
    _to_go: dict[tuple[float, float], ToGo] = field(default_factory=dict, repr=False)
    _again: dict[tuple[int, int], Floats] = field(default_factory=dict, repr=False)
    _shares: dict[tuple[int, int], Floats] = field(default_factory=dict, repr=False)

    @cached_property
    def reach(self) -> float:
        """Metres in a straight line: the most that can be made of one composite, from all but the fastest tenth of the paths."""
        far = np.abs(self.trail.places[:, -1])
        return float(np.quantile(np.maximum.reduceat(far, self.start[:-1]), 0.9))

    @cached_property
    def farthest(self) -> float:
        """Metres: no composite leads farther while it is looked at."""
        return float(np.abs(self.trail.places).max())

    @property
    def pace(self) -> float:
        """Metres a second in a straight line, as most of the paths allow."""
        return self.reach / self.lookahead

    @property
    def fastest(self) -> float:
        """Metres a second in a straight line, which nothing in the recordings exceeds for long."""
        return self.farthest / self.lookahead

    @cached_property
    def widest(self) -> float:
        """Metres by which a composite is moved at most, if it is bent by 1 radian a metre."""
        return float(np.abs(self.trail.swerve).max())

    @cached_property
    def spread(self) -> float:
        """Metres: standard deviation of where composites end."""
        return float(np.std(self.trail.places[:, -1])) or 1.0

    @cached_property
    def turning(self) -> float:
        """Metres walked while turning by a radian, as quickly as all but the quickest tenth of the paths allow."""
        turned = float(np.quantile(np.maximum.reduceat(np.abs(self.trail.headings[:, -1]), self.start[:-1]), 0.9))
        return self.reach / max(turned, 0.1)

    def to_go(self, radius: float, bend: float) -> ToGo:
        """Seconds to a target of so many metres, by ways bent by so many radians a metre. Computed when first asked for."""
        asked = round(float(radius), 3), round(float(bend), 6)
        if asked not in self._to_go:
            self._to_go[asked] = to_go(self.trail, self.rows, self.reach, *asked)
        return self._to_go[asked]

    def begins(self, rows: slice) -> Floats:
        """Seconds until each path of some composites begins: shape (rows, longest)."""
        seconds = np.append(self.duration, 0.0)[self.sequence[rows]]
        return np.asarray(np.cumsum(seconds, axis=1) - seconds, dtype=np.float32)

    def again(self, rows: slice) -> Floats:
        """Seconds since each path of some composites began before within the composite, infinite if it did not: shape (rows,
        longest). Computed when first asked for.
        """
        asked = rows.start, rows.stop
        if asked not in self._again:
            order = np.argsort(self.sequence[rows], axis=1, kind="stable")
            paths = np.take_along_axis(self.sequence[rows], order, axis=1)
            begins = np.take_along_axis(self.begins(rows), order, axis=1)
            since = np.full(begins.shape, np.inf, dtype=np.float32)
            same = (paths[:, 1:] == paths[:, :-1]) & (paths[:, 1:] >= 0)
            since[:, 1:][same] = np.diff(begins, axis=1)[same]
            out = np.empty_like(since)
            np.put_along_axis(out, order, since, axis=1)
            self._again[asked] = out
        return self._again[asked]

    def shares(self, rows: slice) -> Floats:
        """How much each path of some composites counts, together 1, what comes late counting less: shape (rows, longest).

        If all counted alike, what is wished for could be put off from decision to decision. Computed when first asked for.
        """
        asked = rows.start, rows.stop
        if asked not in self._shares:
            seconds = np.append(self.duration, 0.0)[self.sequence[rows]]
            self._shares[asked] = shares_of(seconds, self.lookahead).astype(np.float32)
        return self._shares[asked]

    def fill(self) -> None:
        """Compute what `again` and `shares` would when first asked for, of what may follow each path."""
        for first, past in itertools.pairwise(self.rows.tolist()):
            self.again(slice(first, past)), self.shares(slice(first, past))

    def along(self, rows: slice | Indices) -> Trail:
        """The trails of some rows."""
        times, *others = self.trail
        return Trail._make((times if len(times) == 1 else times[rows], *(values[rows] for values in others)))


def shares_of(seconds: Array, lookahead: float) -> Array:
    """How much each of some paths one after the other counts, together 1; of their durations, along the last axis.

    Frames count the less the later they come, not paths: else one long path would count for more than many short ones.
    """
    if lookahead:
        ends = np.cumsum(seconds, axis=-1)
        fading = SOON / lookahead
        seconds = np.exp(-fading * (ends - seconds)) - np.exp(-fading * ends)
    return np.asarray(seconds / seconds.sum(axis=-1, keepdims=True), dtype=np.float64)


def trails(network: Network) -> Trails:
    """The way of the root within each path, from the recordings, or those with their feet planted (`Network.afoot`)."""
    repertoire = network.repertoire if network.afoot is None else network.afoot
    length = np.asarray(network.length, dtype=np.intp)
    start = np.concatenate([[0], np.cumsum(length + 1)[:-1]]).astype(np.intp)
    path = np.repeat(np.arange(len(length)), length + 1)
    frame = np.arange(len(path)) - start[path]
    moments = repertoire.advance(network.first[path], frame)
    roots = repertoire.roots_of(moments)
    ground = roots[:, 2] + 1j * roots[:, 0]
    yaw = repertoire.yaw_of(moments)
    # a path may turn by more than half a turn: it is followed frame by frame
    step = (np.diff(yaw, prepend=0.0) + np.pi) % (2.0 * np.pi) - np.pi
    turned = np.cumsum(step)
    places = (ground - ground[start][path]) * np.exp(-1j * yaw[start][path])
    strides = np.abs(np.diff(places, prepend=0.0))
    strides[start] = 0.0
    walked = np.cumsum(strides)
    return Trails(start, places, turned - turned[start][path], walked - walked[start][path])


def prospects(network: Network, lookahead: float = LOOKAHEAD, *, hold: float = 0.2, seed: int = 0) -> Prospects:
    """Bundle what may follow each path of a network.

    Parameters
    ----------
    lookahead : seconds that each composite lasts at least; 0 for single paths, as in [Schultz2012] §4.4.1.
    hold : seconds that a recording is kept before the next jump, where there is a choice, so that one blend ends before
        another begins.
    seed : of the choice among composites that lead to the same place. The same network and seed give the same bundle.

    Raises
    ------
    InputError
        If a number of seconds is negative or not finite, or the network has no paths.
    """
    for name, value in (("lookahead", lookahead), ("hold", hold)):
        if not (np.isfinite(value) and value >= 0.0):
            raise InputError(f"Expected `{name}` in seconds, 0 or more, got {value}.")
    if len(network.first) == 0 or len(network.indices) == 0:
        raise InputError(
            "The network has no path that another may follow, so nothing can be performed. Give more recordings, or a "
            "larger `threshold` when it is made."
        )
    chains = _single(network)
    sequence = chains.last.astype(np.int32)[:, None]
    if lookahead > 0.0:
        chains, sequence = _lengthened(chains, sequence, network, lookahead, hold, np.random.default_rng(seed))
    return _sampled(chains, sequence, network, trails(network), lookahead)


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
        faults=faults.of_paths(network)[path].astype(np.int32),
    )


def _lengthened(
    chains: _Chains,
    sequence: NDArray[np.int32],
    network: Network,
    lookahead: float,
    hold: float,
    rng: np.random.Generator,
) -> tuple[_Chains, NDArray[np.int32]]:
    """Chains followed by chains, thinned, until all last long enough."""
    successors = np.diff(network.indptr)
    owner_of = np.repeat(np.arange(len(successors)), successors)
    room = np.maximum(np.clip(MOST_ROWS // len(successors), FEWEST, MOST), successors)
    while True:
        owner = owner_of[chains.edge]
        open_ = np.flatnonzero(chains.duration < lookahead)
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
        done = chains.taken(np.flatnonzero(chains.duration >= lookahead))
        source_head = np.concatenate([np.flatnonzero(chains.duration >= lookahead), head])
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


def _sampled(
    chains: _Chains, sequence: NDArray[np.int32], network: Network, ways: Trails, lookahead: float
) -> Prospects:
    """Trails at regular times (at the end, if nothing is looked ahead to)."""
    rows = len(chains.edge)
    edges = np.arange(len(network.indices) + 1)
    start = np.searchsorted(chains.edge, edges).astype(np.intp)
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
    return Prospects(
        lookahead=float(lookahead),
        start=start,
        sequence=sequence,
        trail=Trail(
            clock.astype(np.float32),
            places.astype(np.complex64),
            headings.astype(np.float32),
            travelled.astype(np.float32),
            swerve.astype(np.complex64),
            playing,
        ),
        cost=chains.cost.astype(np.float32),
        first_jump=chains.first_jump.astype(np.float32),
        rows=start[np.asarray(network.indptr)],
        duration=np.asarray(network.duration, dtype=np.float64),
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
