"""Motion graphs for tests: the performer's answers, whose timelines are known, and random shapes of any size."""

from __future__ import annotations

import numpy as np

from kinesics.grammar.graph import MotionGraph, Occurrence, Path, Source, State, Stay, build
from kinesics.performer import Truth


def graph_of(truth: Truth, name: str = "") -> MotionGraph:
    """The graph of a performance with the labels of its score."""
    states = {s.label: k for k, s in enumerate(truth.states)}
    paths = {p.label: k for k, p in enumerate(truth.paths)}

    def image(label: str, mirror_of: str | None, ids: dict[str, int]) -> int | None:
        return None if mirror_of in (None, label) else ids[mirror_of]

    return MotionGraph(
        tuple(
            State(
                states[s.label],
                s.label,
                s.symmetric,
                image(s.label, s.mirror_of, states),
                tuple(Stay(0, r.start, r.end) for r in s.stays),
            )
            for s in truth.states
        ),
        tuple(
            Path(
                paths[p.label],
                p.label,
                states[p.from_],
                states[p.to],
                int(p.label.rstrip(")*").rpartition("_")[2]),
                p.reversible,
                image(p.label, p.mirror_of, paths),
                occurrences=tuple(Occurrence(0, o.start, o.end, o.reversed, o.complete) for o in p.occurrences),
                symmetric=p.mirror_of == p.label,
            )
            for p in truth.paths
        ),
        (Source(name or truth.movement, truth.frame_count, truth.fps),),
    )


def random_graph(states: int, seed: int = 0) -> MotionGraph:
    """A connected graph of symmetric states, pairs and lone chiral states, with parallel, symmetric, one-way and looping paths."""
    rng = np.random.default_rng(seed)
    nodes: list[State] = []
    while len(nodes) < states:
        kind = rng.choice(["symmetric", "pair", "lone"], p=[0.25, 0.6, 0.15])
        k = len(nodes)
        if kind == "pair" and k + 2 <= states:
            nodes += [State(k, mirror_of=k + 1), State(k + 1, mirror_of=k)]
        else:
            nodes.append(State(k, symmetric=kind == "symmetric"))
    image = {s.id: s.id if s.symmetric else s.mirror_of for s in nodes}
    edges: list[Path] = []

    def join(a: int, b: int) -> None:
        k = len(edges)
        reversible = bool(rng.random() < 0.4)
        mirrored = (image[a], image[b])
        if mirrored == (a, b):
            symmetric = bool(rng.random() < 0.8)
            edges.append(Path(k, from_=a, to=b, reversible=reversible, symmetric=symmetric))
        elif None not in mirrored and rng.random() < 0.7:
            edges.append(Path(k, from_=a, to=b, reversible=reversible, mirror_of=k + 1))
            edges.append(Path(k + 1, from_=mirrored[0] or 0, to=mirrored[1] or 0, reversible=reversible, mirror_of=k))
        else:
            edges.append(Path(k, from_=a, to=b, reversible=reversible))

    for k in range(1, states):
        join(int(rng.integers(max(0, k - 6), k)), k)
    for _ in range(states // 2):
        a = int(rng.integers(states))
        join(a, int(np.clip(a + rng.integers(-5, 6), 0, states - 1)))
    return build(nodes, edges)


def shuffled(graph: MotionGraph, seed: int = 0) -> MotionGraph:
    """The same graph, ids and order at random, every reversible path turned by the toss of a coin, labelled anew."""
    rng = np.random.default_rng(seed)
    state_ids = {s.id: int(k) for s, k in zip(graph.states, rng.permutation(len(graph.states)), strict=True)}
    path_ids = {p.id: int(k) for p, k in zip(graph.paths, rng.permutation(len(graph.paths)), strict=True)}
    states = [
        State(state_ids[s.id], symmetric=s.symmetric, mirror_of=None if s.mirror_of is None else state_ids[s.mirror_of])
        for s in graph.states
    ]
    coin = {min(p.id, p.mirror_of if p.mirror_of is not None else p.id): bool(rng.random() < 0.5) for p in graph.paths}
    paths = []
    for p in graph.paths:
        turn = p.reversible and coin[min(p.id, p.mirror_of if p.mirror_of is not None else p.id)]
        ends = (p.to, p.from_) if turn else (p.from_, p.to)
        paths.append(
            Path(
                path_ids[p.id],
                from_=state_ids[ends[0]],
                to=state_ids[ends[1]],
                reversible=p.reversible,
                mirror_of=None if p.mirror_of is None else path_ids[p.mirror_of],
                symmetric=p.symmetric,
            )
        )
    order = rng.permutation(len(states))
    return build([states[k] for k in order], [paths[k] for k in rng.permutation(len(paths))])
