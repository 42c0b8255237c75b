"""Traversals of a motion graph of key poses: the graph as it is given, the steps taken, and every frame accounted for.

Only the clock differs from one traversal of a path to the next: it stops at a state, or passes it without slowing down, or
hits and recoils.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Unpack

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from kinesics.errors import InputError
from kinesics.performer.cycles import unequal
from kinesics.performer.key_graph import STOP_TO_STOP, KeyGraph, KeyState
from kinesics.performer.postures import ANGLES
from kinesics.performer.score import TEMPO_STREAM, Score, Shutter, check_number, generator
from kinesics.performer.stage import Conditions, perform_score, stillness_of
from kinesics.performer.truth import (
    Performance,
    TrueOccurrence,
    TruePath,
    TruePhrase,
    TrueState,
    Truth,
    notation_of,
)
from kinesics.performer.words import Token, class_of
from kinesics.vocabulary import MovementClass

Array = NDArray[np.float64]

_STOP_AT_ONE_END: Final = 1.5
_IMPACT: Final = 0.5  # share of a strike's time until the impact
_IMPACT_SECONDS: Final = 0.04  # how long the impact takes: no limb is stopped in an instant
_RECOIL: Final = 0.07  # share of the path that the recoil goes back


@dataclass(frozen=True)
class Step:
    """One path taken."""

    path: str
    reversed: bool = False
    hold: float = 0.0
    """Seconds of stillness at its end."""
    strike: bool = False
    """Hit the end at full speed and recoil (§3.6.3)."""
    turn_degrees: float = 0.0
    """Turn of the whole body to the left meanwhile."""


def parse_step(step: Step | str) -> Step:
    """A step from notation: "ab_1", or "<ab_1" backwards. Raises InputError for what is neither that nor a `Step`."""
    if isinstance(step, Step):
        return step
    if not isinstance(step, str):
        raise InputError(f"Expected a step as a label or a `Step`, got {step!r}.")
    return Step(step[1:], reversed=True) if step.startswith("<") else Step(step)


@dataclass(frozen=True)
class Part:
    """A named stretch of a traversal: steps [first, last)."""

    name: str
    first: int
    last: int


@dataclass(frozen=True)
class _Piece:
    """A stretch of time on one path or in one state."""

    start: float
    end: float
    label: str
    """Of a path, or of a state that is held."""
    step: int
    held: bool = False
    reversed: bool = False
    stop_before: bool = True
    stop_after: bool = True
    strike: bool = False
    heading: float = 0.0
    turn: float = 0.0

    def progress(self, times: Array) -> Array:
        """How much of the path lies behind, in the direction of travel, 0 to 1."""
        x = np.clip((times - self.start) / (self.end - self.start), 0.0, 1.0)
        if self.strike:
            soft = min(_IMPACT_SECONDS / (self.end - self.start), 0.2)
            near = np.clip((x - _IMPACT + 0.5 * soft) / soft, 0.0, 1.0)
            (v0, first), (v1, second) = (self._struck(np.array([_IMPACT + k * soft])) for k in (-0.5, 0.5))
            braking = CubicHermiteSpline([0.0, 1.0], [first[0], second[0]], [soft * v0[0], soft * v1[0]])
            return np.where((near > 0.0) & (near < 1.0), braking(near), self._struck(x)[1])
        return _quintic(x, 0.0 if self.stop_before else self.speed, 0.0 if self.stop_after else self.speed)

    def _struck(self, x: Array) -> tuple[Array, Array]:
        """Speed and progress of a strike that is stopped in an instant."""
        hit = np.minimum(x / _IMPACT, 1.0)
        into = x < _IMPACT
        first, rate = (hit**2, 2.0 * hit) if self.stop_before else (hit, np.ones_like(hit))
        y = np.maximum(x - _IMPACT, 0.0) / (1.0 - _IMPACT)
        back = _RECOIL * 6.75 * (1.0 - y) * (1.0 - 3.0 * y) / (1.0 - _IMPACT)
        return np.where(into, rate / _IMPACT, -back), first - _RECOIL * 6.75 * y * (1.0 - y) ** 2

    @property
    def speed(self) -> float:
        """Full speed, in paths per piece."""
        return 1.0 if not (self.stop_before or self.stop_after) else _STOP_AT_ONE_END

    @property
    def impact(self) -> float:
        """Seconds of the impact of a strike."""
        return self.start + _IMPACT * (self.end - self.start)


def _quintic(x: Array, v0: float, v1: float) -> Array:
    """From 0 to 1 with given speeds and no acceleration at the ends."""
    a = 10.0 - 6.0 * v0 - 4.0 * v1
    b = -15.0 + 8.0 * v0 + 7.0 * v1
    c = 6.0 - 3.0 * v0 - 3.0 * v1
    return np.asarray(v0 * x + a * x**3 + b * x**4 + c * x**5)


@dataclass(frozen=True, eq=False)
class _Timeline:
    """Pieces without gap, on a clock that may waver."""

    graph: KeyGraph
    pieces: tuple[_Piece, ...]
    knots: Array
    """Seconds of the score at each border of pieces, and ..."""
    warped: Array
    """... seconds of the performance."""

    def clock(self, times: Array) -> Array:
        """Seconds of the score at seconds of the performance."""
        inside = np.clip(times, 0.0, self.warped[-1])
        if np.array_equal(self.knots, self.warped):
            return inside
        return np.asarray(PchipInterpolator(self.warped, self.knots)(inside))

    def _spread(self, times: Array, width: int) -> tuple[Array, NDArray[np.intp], Array]:
        at = self.clock(times)
        starts = np.array([p.start for p in self.pieces])
        which = np.clip(np.searchsorted(starts, at, side="right") - 1, 0, len(starts) - 1)
        return at, which, np.zeros((len(times), width))

    def angles(self, times: Array) -> Array:
        at, which, out = self._spread(times, len(ANGLES))
        for k in np.unique(which):
            piece, rows = self.pieces[k], which == k
            if piece.held:
                out[rows] = self.graph.state(piece.label).posture
            else:
                u = piece.progress(at[rows])
                out[rows] = self.graph.along(piece.label, 1.0 - u if piece.reversed else u)
        return out

    def heading(self, times: Array) -> Array:
        at, which, out = self._spread(times, 1)
        for k in np.unique(which):
            piece, rows = self.pieces[k], which == k
            x = np.clip((at[rows] - piece.start) / (piece.end - piece.start), 0.0, 1.0)
            out[rows, 0] = piece.heading + piece.turn * _quintic(x, 0.0, 0.0)
        return out[:, 0]


def _lay_out(graph: KeyGraph, steps: Sequence[Step], first_hold: float) -> list[_Piece]:
    """Put the steps one after the other and decide where to stop."""
    faults: list[str] = []
    at: str | None = None
    for k, step in enumerate(steps):
        path = graph.path(step.path)
        if step.reversed and not path.reversible:
            faults.append(f"step {k}: path '{path.label}' is not reversible")
        start, end = (path.to, path.from_) if step.reversed else (path.from_, path.to)
        if at is not None and start != at:
            faults.append(f"step {k}: '{path.label}' starts at '{start}', but the step before ends at '{at}'")
        if not (np.isfinite(step.hold) and 0.0 <= step.hold <= 600.0):
            faults.append(f"step {k}: hold of {step.hold} s, expected 0 to 600")
        at = end
    if faults:
        raise InputError("These steps cannot be taken: " + "; ".join(faults) + ".")

    def passes(k: int) -> bool:
        """Whether the body goes through the state between steps k and k + 1 without stopping."""
        if not 0 <= k < len(steps) - 1 or steps[k].hold > 0.0 or steps[k].strike:
            return False
        path = graph.path(steps[k].path)
        if graph.state(path.from_ if steps[k].reversed else path.to).velocity is None:
            return False
        arriving = graph.velocity(steps[k].path, reversed_=steps[k].reversed, at_end=True)
        leaving = graph.velocity(steps[k + 1].path, reversed_=steps[k + 1].reversed, at_end=False)
        return bool(np.allclose(arriving, leaving, atol=1e-9))

    pieces: list[_Piece] = []
    now, heading = 0.0, 0.0
    origin = graph.path(steps[0].path)
    at = origin.to if steps[0].reversed else origin.from_
    if first_hold > 0.0:
        pieces.append(_Piece(0.0, first_hold, at, -1, held=True))
        now = first_hold
    for k, step in enumerate(steps):
        path = graph.path(step.path)
        stops = (not passes(k - 1), not passes(k))
        full_speed = path.seconds / STOP_TO_STOP
        length = full_speed * (1.0, _STOP_AT_ONE_END, STOP_TO_STOP)[sum(stops)]
        turn = float(np.deg2rad(step.turn_degrees))
        pieces.append(
            _Piece(
                now,
                now + length,
                path.label,
                k,
                reversed=step.reversed,
                stop_before=stops[0],
                stop_after=stops[1],
                strike=step.strike,
                heading=heading,
                turn=turn,
            )
        )
        now += length
        heading += turn
        at = path.from_ if step.reversed else path.to
        if step.hold > 0.0:
            pieces.append(_Piece(now, now + step.hold, at, k, held=True, heading=heading))
            now += step.hold
    return pieces


def seconds_of(graph: KeyGraph, steps: Sequence[Step | str], first_hold: float = 0.0) -> float:
    """How long the steps take at the tempo of the graph."""
    return _lay_out(graph, [parse_step(s) for s in steps], first_hold)[-1].end


def traversal_score(
    graph: KeyGraph,
    steps: Sequence[Step | str],
    *,
    seconds: float | None = None,
    first_hold: float = 0.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    parts: Sequence[Part] | None = None,
) -> Score:
    """The score of a traversal.

    Parameters
    ----------
    graph, steps, seconds, first_hold, tempo_jitter, seed : as in `traverse`.
    parts : the phrases; one of all steps, without.

    Raises
    ------
    InputError
        As `traverse`.
    """
    taken = [parse_step(s) for s in steps]
    if not taken:
        raise InputError("Expected at least one step to take.")
    tempo_jitter = check_number("tempo_jitter", tempo_jitter, 0.0, 0.3)
    first_hold = check_number("first_hold", first_hold, 0.0, 600.0, unit="s")
    pieces = tuple(_lay_out(graph, taken, first_hold))
    knots = np.array([p.start for p in pieces] + [pieces[-1].end])
    warped = knots
    if tempo_jitter > 0.0:
        lengths = unequal(np.diff(knots), tempo_jitter, generator(seed, TEMPO_STREAM))
        warped = np.concatenate([[0.0], np.cumsum(lengths)])
    if seconds is not None:
        seconds = check_number("seconds", seconds, 0.05, 3600.0, unit="s")
        warped = warped * (seconds / warped[-1])
        if tempo_jitter == 0.0:
            # the same tempo throughout: a plain change of scale, kept exact
            pieces = tuple(
                dataclasses.replace(p, start=float(a), end=float(b))
                for p, a, b in zip(pieces, warped[:-1], warped[1:], strict=True)
            )
            knots = warped
    line = _Timeline(graph, pieces, knots, warped)
    named = tuple(parts) if parts else (Part(graph.name, 0, len(taken)),)

    def truth(shutter: Shutter) -> Truth:
        return _traversal_truth(line, taken, named, shutter, exact=tempo_jitter == 0.0)

    return Score(graph.name, float(warped[-1]), line.angles, truth, heading=line.heading)


def _tokens(line: _Timeline, first: int, last: int) -> list[Token]:
    """The word of steps [first, last): paths and holds."""
    graph = line.graph
    images = {p.label: p.mirror_of for p in graph.paths}
    state_images = {s.label: s.label if s.symmetric else s.mirror_of for s in graph.states}
    out: list[Token] = []
    for piece in line.pieces:
        if not first <= max(piece.step, 0) < last:
            continue
        length = round(piece.end - piece.start, 6)
        if piece.held:
            out.append(Token(piece.label, False, state_images[piece.label], True, length))
        else:
            both = graph.palindromic(piece.label) and not piece.strike
            out.append(Token(piece.label, piece.reversed, images[piece.label], both, length, one_way=piece.strike))
    return out


def _traversal_truth(
    line: _Timeline, steps: Sequence[Step], parts: Sequence[Part], shutter: Shutter, *, exact: bool
) -> Truth:
    graph, n = line.graph, shutter.frame_count

    def performed(seconds_of_score: float) -> float:
        return float(np.interp(seconds_of_score, line.knots, line.warped))

    borders = [shutter.frame(float(t)) for t in line.warped]
    borders[-1] = n
    occurrences: dict[str, list[TrueOccurrence]] = {p.label: [] for p in graph.paths}
    stays: dict[str, list[tuple[float, float]]] = {s.label: [] for s in graph.states}
    holds: list[tuple[float, float]] = []
    strikes: list[int | None] = []
    turns: list[int | None] = []
    previous: _Piece | None = None
    middle = 0.0
    for k, piece in enumerate(line.pieces):
        start, end = float(line.warped[k]), float(line.warped[k + 1])
        if piece.held:
            stays[piece.label].append((start, end))
            holds.append((start, end))
            middle = 0.5 * (start + end)
            continue
        if borders[k + 1] > borders[k]:
            occurrences[piece.label].append(TrueOccurrence(borders[k], borders[k + 1], piece.reversed))
        at = middle if k > 0 and line.pieces[k - 1].held else start
        if previous is not None and previous.label == piece.label and previous.reversed != piece.reversed:
            turns.append(shutter.nearest(at))
        if graph.palindromic(piece.label):
            turns.append(shutter.nearest(performed(0.5 * (piece.start + piece.end))))
        if piece.strike:
            clock = PchipInterpolator(line.knots, line.warped) if not np.array_equal(line.knots, line.warped) else None
            strikes.append(shutter.nearest(float(clock(piece.impact)) if clock else piece.impact))
        previous = piece

    first_piece = {p.step: k for k, p in reversed(list(enumerate(line.pieces))) if not p.held}
    phrases: list[TruePhrase] = []
    for i, part in enumerate(parts):
        begin = 0 if i == 0 else borders[first_piece[part.first]]
        finish = n if i == len(parts) - 1 else borders[first_piece[part.last]]
        class_, span, repeats = class_of(_tokens(line, part.first, part.last))
        cycles: tuple[int, ...] = ()
        period: float | None = None
        if repeats >= 2:
            word_start = 0 if i == 0 else first_piece[part.first]
            marks = [word_start + r * span for r in range(repeats + 1)]
            cycles = tuple(borders[m] for m in marks)
            period = float((line.warped[marks[-1]] - line.warped[marks[0]]) / repeats)
        phrases.append(TruePhrase(part.name, begin, finish, class_, period, cycles, tempo_exact=exact))
    if len(phrases) == 1:
        overall, overall_period = phrases[0].class_, phrases[0].period_s
    else:
        overall, span, repeats = class_of(_tokens(line, 0, len(steps)))
        overall_period = float(line.warped[-1] / repeats) if repeats >= 2 else None

    paths = tuple(
        TruePath(p.label, p.from_, p.to, p.reversible, p.mirror_of, tuple(occurrences[p.label])) for p in graph.paths
    )
    return Truth(
        movement=graph.name,
        class_=overall,
        period_s=overall_period,
        frame_count=n,
        fps=shutter.fps,
        phrases=tuple(phrases),
        states=tuple(
            TrueState(
                s.label,
                s.pose,
                s.symmetric,
                s.label if s.symmetric else s.mirror_of,
                tuple(stillness_of(stays[s.label], shutter)),
            )
            for s in graph.states
        ),
        paths=paths,
        reversals=tuple(sorted(f for f in turns if f is not None)),
        stillness=stillness_of(holds, shutter),
        strikes=tuple(f for f in strikes if f is not None),
        notation=notation_of(paths),
    )


def still_score(name: str, posture: Array, seconds: float) -> Score:
    """Standing in one posture: no path at all."""
    seconds = check_number("seconds", seconds, 0.05, 3600.0, unit="s")
    state = KeyState("X~", posture, mirror_of="X~")

    def truth(shutter: Shutter) -> Truth:
        whole = shutter.range(0.0, seconds + 1.0)
        return Truth(
            movement=name,
            class_=MovementClass.STILL,
            period_s=None,
            frame_count=shutter.frame_count,
            fps=shutter.fps,
            phrases=(TruePhrase(name, 0, shutter.frame_count, MovementClass.STILL),),
            states=(TrueState("X~", state.pose, True, "X~", (whole,)),),
            stillness=(whole,),
        )

    return Score(name, seconds, lambda times: np.tile(posture, (len(times), 1)), truth)


def traverse(
    graph: KeyGraph,
    steps: Sequence[Step | str],
    *,
    seconds: float | None = None,
    fps: float = 120.0,
    first_hold: float = 0.0,
    tempo_jitter: float = 0.0,
    seed: int = 0,
    **conditions: Unpack[Conditions],
) -> Performance:
    """Traverse a graph of key poses.

    Parameters
    ----------
    graph : states and paths.
    steps : paths in the order of travel: "ab_1", "<ab_1" backwards, or `Step` with holds, strikes and turns.
    seconds : stretch or press the whole into this time (default: as long as it takes).
    first_hold : seconds of stillness before the first step.
    tempo_jitter : relative deviation of the length of each path and hold, 0 to 0.3.
    seed : of the jitter and the noise.
    conditions : see `kinesics.performer.Conditions`.

    Raises
    ------
    InputError
        If a step does not start where the one before ends, a one-way path is taken backwards, or a value is out of range.
    """
    score = traversal_score(graph, steps, seconds=seconds, first_hold=first_hold, tempo_jitter=tempo_jitter, seed=seed)
    return perform_score(score, fps=fps, seed=seed, **conditions)
