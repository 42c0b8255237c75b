"""Random motion graphs and traversals that cover them: the examination paper for whatever reads graphs."""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.pose import gravity
from kinesics.body.pose import mirror as mirror_pose
from kinesics.errors import InputError
from kinesics.performer import postures as _postures
from kinesics.performer.key_graph import STOP_TO_STOP, KeyGraph, KeyPath, KeyState, mirrored_path
from kinesics.performer.postures import ANGLE, ANGLES, STANDING, pose
from kinesics.performer.score import CHOICE_STREAM, GRAPH_STREAM, check_number, generator
from kinesics.performer.traversal import Step, seconds_of

Array = NDArray[np.float64]

APART: Final = 0.01
"""Least D between any two states of a random graph."""
SHORTEST, LONGEST = 0.4, 3.0
"""Seconds of a traversal of a path, passed at both ends or stopped at both."""
_CLEAR: Final = 0.006  # D by which a path keeps away from states that are not its ends

_SPREAD_DEGREES: Final = {
    # middle and half range of what a random posture does, within what bodies can and feet can stand on
    "pelvis_pitch": (6, 8), "pelvis_roll": (0, 4), "lowerback_bend": (5, 8), "upperback_bend": (4, 8),
    "thorax_bend": (2, 8), "lowerback_twist": (0, 10), "upperback_twist": (0, 10), "thorax_twist": (0, 10),
    "lowerback_lean": (0, 7), "upperback_lean": (0, 7), "thorax_lean": (0, 6), "lowerneck_twist": (0, 14),
    "upperneck_bend": (-2, 10), "head_twist": (0, 20), "hip_flex": (24, 26), "hip_abduct": (10, 9), "hip_rotate": (8, 14),
    "knee": (34, 26), "shoulder_elevate": (-15, 62), "shoulder_horizontal": (22, 34), "shoulder_twist": (-22, 42),
    "elbow": (55, 48),
}  # fmt: skip


def distances(a: Array, b: Array) -> Array:
    """D between poses (n, 15, 4) and (m, 15, 4), all links of one weight, the root by gravity ([Schultz2012] §2.13).

    Written out here and not taken from the library: an examiner measures with a rule of his own. Shape (n, m).
    """
    dots = np.abs(np.einsum("nji,mji->nmj", a[:, 1:], b[:, 1:])).sum(axis=-1)
    root = np.sqrt(np.clip((1.0 + gravity(a) @ gravity(b).T) / 2.0, 0.0, 1.0))
    return np.asarray(1.0 - (dots + root) / a.shape[1])


def _random_posture(rng: np.random.Generator, symmetric: bool) -> Array:
    values = np.zeros(len(ANGLES))
    values += STANDING
    for name, (middle, half) in _SPREAD_DEGREES.items():
        entries, _ = _postures.entries_of(name)
        for entry in entries:
            values[entry] = np.deg2rad(middle + half * rng.uniform(-1.0, 1.0))
    # the feet stay flat on the floor below the hips: thighs forward as much as the knees bend
    for side in ("left", "right"):
        knee = values[ANGLE[f"{side}_knee"]]
        values[ANGLE[f"{side}_hip_flex"]] = 0.55 * knee + values[ANGLE["pelvis_pitch"]] + np.deg2rad(rng.uniform(-8, 8))
    if symmetric:
        values = 0.5 * (values + _postures.mirror(values))
    return values


def _upright(curve: Array) -> bool:
    """Whether hinges bend only as they can and the feet stay under the body."""
    hinges = curve[:, [ANGLE[f"{side}_{joint}"] for side in ("left", "right") for joint in ("knee", "elbow")]]
    elevation = curve[:, [ANGLE["left_shoulder_elevate"], ANGLE["right_shoulder_elevate"]]]
    return bool(
        np.all(hinges > np.deg2rad(-2.0)) and np.all(hinges < np.deg2rad(140.0)) and np.all(np.abs(elevation) < 1.6)
    )


def _choose_states(count: int, rng: np.random.Generator) -> list[KeyState]:
    """Symmetric states, chiral states with their images, and chiral states alone, pairwise `APART`."""
    kinds = ["symmetric", "pair"]
    left = count - 3
    while left > 0:
        kind = str(rng.choice(["symmetric", "pair", "lone"], p=[0.3, 0.5, 0.2]))
        if kind == "pair" and left < 2:
            continue
        kinds.append(kind)
        left -= 2 if kind == "pair" else 1
    sizes = [2 if kind == "pair" else 1 for kind in kinds]
    passed: set[int] = set()
    for k in rng.permutation(len(kinds)):
        if sum(sizes[i] for i in passed) + sizes[k] <= (count + 1) // 2:
            passed.add(int(k))
    symmetric_letters, chiral_letters = iter("XYZUVWTSRQPO"), iter("ABCDEFGHIJKL")
    states: list[KeyState] = []
    for k, kind in enumerate(kinds):
        for _attempt in range(1000):
            values = _random_posture(rng, kind == "symmetric")
            image = _postures.mirror(values)
            others = np.array([s.pose for s in states]).reshape(-1, 15, 4)
            mine = pose(values)[None]
            # far from every other state and from the mirror image of every other; a chiral one also from its own
            far = (
                len(others) == 0
                or min(distances(mine, others).min(), distances(mine, mirror_pose(others)).min()) >= APART
            )
            if far and (kind == "symmetric" or distances(mine, mirror_pose(mine)).min() >= APART):
                break
        else:  # pragma: no cover - the space of postures is far larger than twelve states need
            raise InputError(f"No room for {count} states {APART} apart; try another `seed`.")
        velocity = None
        if k in passed:
            velocity = _random_posture(rng, False) - _random_posture(rng, False)
            if kind == "symmetric":
                sign = rng.choice([-1.0, 1.0])
                velocity = velocity + sign * _postures.mirror(velocity)
            velocity = velocity * (_SPEED / np.linalg.norm(velocity))
        if kind == "symmetric":
            label = next(symmetric_letters) + "~"
            states.append(KeyState(label, values, label, velocity))
            continue
        label = next(chiral_letters)
        states.append(KeyState(label, values, label + "*" if kind == "pair" else None, velocity))
        if kind == "pair":
            states.append(KeyState(label + "*", image, label, None if velocity is None else _postures.mirror(velocity)))
    return states


_SPEED: Final = 1.6  # radians a second, all angles together, at which a state is passed
_PACE: Final = 2.2  # the same, on the way


class _Builder:
    """Adds paths, each with its mirror image where there is one, until the graph keeps its promises."""

    def __init__(self, states: list[KeyState], rng: np.random.Generator) -> None:
        self.states = {s.label: s for s in states}
        self.poses = np.array([s.pose for s in states])
        self.labels = [s.label for s in states]
        self.paths: list[KeyPath] = []
        self.rng = rng

    def add(self, from_: str, to: str) -> None:
        """One path, and mostly its image."""
        for _attempt in range(400):
            path = self._draft(from_, to)
            image = self._image(path)
            if self._good(path) and (image is None or self._good(image, beside=path)):
                break
        else:
            raise _NoRoomError
        if image is None or image.label == path.label:
            self.paths.append(path)
        elif self.rng.random() < 0.8:
            self.paths += [dataclasses.replace(path, mirror_of=image.label), image]
        else:
            self.paths.append(path)

    def _draft(self, from_: str, to: str) -> KeyPath:
        rng = self.rng
        a, b = self.states[from_], self.states[to]
        symmetric = a.symmetric and b.symmetric and rng.random() < 0.7
        count = int(rng.integers(1, 3)) if from_ != to else 2
        via: list[Array] = []
        for k in range(count):
            u = (k + 1) / (count + 1)
            straight = (1 - u) * a.posture + u * b.posture
            detour = _random_posture(rng, symmetric) - _random_posture(rng, symmetric)
            via.append(straight + 0.45 * detour)
        length = float(np.linalg.norm(np.diff(np.array([a.posture, *via, b.posture]), axis=0), axis=1).sum())
        seconds = float(
            np.clip(STOP_TO_STOP * length / _PACE * rng.uniform(0.8, 1.25), SHORTEST * STOP_TO_STOP, LONGEST)
        )
        if symmetric:
            # a symmetric path cannot leave or arrive sideways: such ends were given a sideways velocity for others
            sideways = [s.velocity is not None and not _same(_postures.mirror(s.velocity), s.velocity) for s in (a, b)]
            symmetric = not any(sideways)
        label = self._label(a, b, symmetric)
        return KeyPath(
            label,
            from_,
            to,
            seconds,
            via=tuple(via),
            reversible=bool(rng.random() < 0.5),
            mirror_of=label if symmetric else None,
        )

    def _label(self, a: KeyState, b: KeyState, symmetric: bool) -> str:
        stem = a.label.rstrip("~").lower() + b.label.rstrip("~").lower()
        stem += "~" if symmetric else ""
        taken = {p.label for p in self.paths}
        return next(f"{stem}_{k}" for k in range(1, 1000) if f"{stem}_{k}" not in taken)

    def _image(self, path: KeyPath) -> KeyPath | None:
        if path.mirror_of == path.label:
            return path
        if any(self.states[end].mirror_of is None for end in (path.from_, path.to)):
            return None
        return mirrored_path(path, f"({path.label})*", self.states)

    def _curve(self, path: KeyPath) -> Array:
        graph = KeyGraph(tuple(self.states.values()), (dataclasses.replace(path, mirror_of=None),))
        return graph.along(path.label, np.linspace(0.0, 1.0, 61))

    def _good(self, path: KeyPath, beside: KeyPath | None = None) -> bool:
        curve = self._curve(path)
        if not _upright(curve):
            return False
        poses = pose(curve)
        away = distances(poses, self.poses)
        for k, label in enumerate(self.labels):
            # it keeps clear of other states, and of its own ends once it has left
            inside = slice(20, 41) if label in (path.from_, path.to) else slice(None)
            if away[inside, k].min() < _CLEAR:
                return False
        twins = [p for p in self.paths if {p.from_, p.to} == {path.from_, path.to}]
        if beside is not None and beside.label != path.label and {beside.from_, beside.to} == {path.from_, path.to}:
            twins.append(beside)
        return all(distances(poses, pose(self._curve(p))).min(axis=1).max() >= APART for p in twins)


class _NoRoomError(Exception):
    """No path found between two states that keeps clear of all others."""


def _same(a: Array, b: Array) -> bool:
    return bool(np.allclose(a, b, atol=1e-9))


def _parallel_share(paths: list[KeyPath]) -> float:
    ends = [frozenset((p.from_, p.to)) for p in paths]
    return float(np.mean([ends.count(e) > 1 for e in ends]))


def random_graph(states: int = 6, seed: int = 0) -> KeyGraph:
    """A random motion graph of human postures.

    Symmetric states, chiral states with and without their mirror images; paths reversible and one-way, symmetric, mirrored
    and alone, at least a third of them parallel to another; all states at least `APART` in D (and from each other's
    images); half of the states are passed without a stop; a path takes .4 to 3 s. Every state can be reached from every
    other.

    Parameters
    ----------
    states : 3 to 12, images counted.
    seed : of everything.

    Raises
    ------
    InputError
        If a value is out of range.
    """
    if isinstance(states, bool) or not isinstance(states, int | np.integer) or not 3 <= states <= 12:
        raise InputError(f"Expected `states` to be a whole number from 3 to 12, got {states!r}.")
    rng = generator(seed, GRAPH_STREAM)
    for _attempt in range(50):
        builder = _Builder(_choose_states(int(states), rng), rng)
        try:
            ring = [str(x) for x in rng.permutation(builder.labels)]
            for k, label in enumerate(ring):
                builder.add(label, ring[(k + 1) % len(ring)])
            while _parallel_share(builder.paths) < 1.0 / 3.0:
                twin = builder.paths[int(rng.integers(len(builder.paths)))]
                builder.add(twin.from_, twin.to)
            graph = KeyGraph(tuple(builder.states.values()), tuple(builder.paths), name="random_graph")
            covering_steps(graph, seed)
        except (_NoRoomError, _TooLongError):
            continue
        return graph
    raise InputError(f"Found no graph of {states} states with `seed` {seed}; try another seed.")  # pragma: no cover


def covering_steps(
    graph: KeyGraph, seed: int = 0, *, times: int = 2, shortest: float = 60.0, longest: float = 180.0
) -> tuple[Step, ...]:
    """Steps that take every path of a graph at least ``times`` times, in random order.

    States without a velocity are held for .3 to 1 s; the others are passed, or turned back in where a path is taken
    the other way.

    Parameters
    ----------
    graph : strongly connected.
    seed : of the order and the holds.
    times : 1 to 20.
    shortest, longest : seconds of the whole.

    Raises
    ------
    InputError
        If a state cannot be reached again, or the paths do not fit into ``longest``.
    """
    times = int(check_number("times", times, 1, 20))
    shortest = check_number("shortest", shortest, 0.0, 3600.0, unit="s")
    longest = check_number("longest", longest, shortest, 36000.0, unit="s")
    rng = generator(seed, CHOICE_STREAM)
    for _attempt in range(20):
        steps = _wander(graph, rng, times, shortest)
        if seconds_of(graph, steps) <= longest:
            return tuple(steps)
    raise _TooLongError(f"Every path {times} times does not fit into `longest` of {longest:g} s; allow more.")


class _TooLongError(InputError):
    """The paths do not fit into the time allowed."""


_Arc = tuple[str, bool, str]
"""Path, reversed?, where it leads."""


def _wander(graph: KeyGraph, rng: np.random.Generator, times: int, shortest: float) -> list[Step]:
    """A random traversal that takes every path at least ``times`` times and lasts at least ``shortest`` seconds."""
    arcs: dict[str, list[_Arc]] = {s.label: [] for s in graph.states}
    for p in graph.paths:
        arcs[p.from_].append((p.label, False, p.to))
        if p.reversible:
            arcs[p.to].append((p.label, True, p.from_))
    taken = {p.label: 0 for p in graph.paths}
    at = graph.paths[int(rng.integers(len(graph.paths)))].from_
    steps: list[Step] = []
    while True:
        enough = all(count >= times for count in taken.values())
        if enough and seconds_of(graph, steps) >= shortest:
            return steps
        wanted = set(taken) if enough else {label for label, count in taken.items() if count < times}
        for label, reversed_, end in _way_to(graph, wanted, at, arcs, steps, rng):
            hold = float(rng.uniform(0.3, 1.0)) if graph.state(end).velocity is None else 0.0
            steps.append(Step(label, reversed_, hold))
            taken[label] += 1
            at = end


def _sense(graph: KeyGraph, label: str, reversed_: bool, *, leaving: bool) -> int:
    """Whether a traversal leaves or reaches its state with the state's velocity (1) or against it (−1)."""
    along = graph.path(label).along
    return -along[1 if leaving else 0] if reversed_ else along[0 if leaving else 1]


def _way_to(
    graph: KeyGraph,
    wanted: set[str],
    at: str,
    arcs: dict[str, list[_Arc]],
    steps: list[Step],
    rng: np.random.Generator,
) -> list[_Arc]:
    """The shortest way from a state to a wanted path, that path included; ties by chance."""
    ways: dict[str, list[_Arc]] = {at: []}
    queue = [at]
    while queue:
        here = queue.pop(0)
        order = [arcs[here][i] for i in rng.permutation(len(arcs[here]))]
        if steps and here == at:
            # to stop in a state made for passing, or to turn straight back, is allowed but not the habit
            last = steps[-1]
            order.sort(
                key=lambda arc: (
                    _sense(graph, arc[0], arc[1], leaving=True)
                    != _sense(graph, last.path, last.reversed, leaving=False),
                    arc[0] == last.path and arc[1] != last.reversed,
                )
            )
        for arc in order:
            if arc[0] in wanted:
                return [*ways[here], arc]
        for arc in order:
            if arc[2] not in ways:
                ways[arc[2]] = [*ways[here], arc]
                queue.append(arc[2])
    raise InputError(f"From state '{at}' no way leads to {', '.join(sorted(wanted))}: the graph is not connected.")
