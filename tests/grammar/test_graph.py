"""The motion graph: what it refuses, how it is labelled, read back, transformed and compared."""

from __future__ import annotations

import dataclasses
import itertools
import json
from xml.etree import ElementTree

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics.performer as performer
from kinesics.errors import InputError
from kinesics.grammar import exchange
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, Source, State, Stay, build, ends_of
from motion_graphs import graph_of, random_graph, shuffled

PERFORMED = (
    "walk",
    "jog_in_place",
    "jumping_jacks",
    "sway",
    "side_kicks",
    "sun_salutation",
    "kata",
    "arm_circles",
    "throw",
)


@pytest.fixture(scope="module", params=PERFORMED)
def performed(request: pytest.FixtureRequest) -> MotionGraph:
    return graph_of(performer.perform(request.param).truth)


def _walk() -> MotionGraph:
    """A, A* and the two steps between them, ten frames each."""
    return MotionGraph(
        (State(0, "A", mirror_of=1), State(1, "A*", mirror_of=0)),
        (
            Path(0, "aa*_1", 0, 1, 1, mirror_of=1, occurrences=(Occurrence(0, 0, 10), Occurrence(0, 20, 30))),
            Path(1, "(aa*_1)*", 1, 0, 1, mirror_of=0, occurrences=(Occurrence(0, 10, 20),)),
        ),
        (Source("walk", 30, 10.0),),
    )


def _squat() -> MotionGraph:
    """X, down to Y, held, and up again; X held at both ends."""
    return MotionGraph(
        (
            State(0, "X~", symmetric=True, stays=(Stay(0, 0, 5), Stay(0, 35, 40))),
            State(1, "Y~", symmetric=True, stays=(Stay(0, 15, 25),)),
        ),
        (
            Path(
                0, "xy~_1", 0, 1, 1, reversible=True, symmetric=True,
                occurrences=(Occurrence(0, 5, 15), Occurrence(0, 25, 35, reversed=True)),
            ),
        ),
        (Source("squat", 40, 10.0),),
    )  # fmt: skip


# what is refused


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"states": (State(0, "A"), State(0, "B"))}, "every state id once"),
        ({"states": (State(0, "A"), State(1, "A"))}, "every state label once"),
        ({"states": (State(0, "A~"), State(1, "B"))}, "A chiral state is labelled"),
        ({"states": (State(0, "X", symmetric=True), State(1, "B"))}, "A symmetric state is labelled"),
        ({"states": (State(0, "A b"), State(1, "B"))}, "letters and digits"),
        ({"states": (State(0, "A", mirror_of=0), State(1, "B"))}, "its own mirror image"),
        ({"states": (State(0, "A", mirror_of=7), State(1, "B"))}, "not in the graph"),
        ({"states": (State(0, "A", mirror_of=1), State(1, "B"))}, "but 'B' names None"),
        ({"states": (State(0, "X~", symmetric=True, mirror_of=1), State(1, "B"))}, "symmetric = True and mirror_of = None"),
        ({"paths": (Path(0, "ab_1", 0, 5),)}, "ends at state 5"),
        ({"paths": (Path(0, "ab_1", 0, 1), Path(1, "ab_1", 0, 1))}, "every path label once"),
        ({"paths": (Path(0, "ab_0", 0, 1),)}, "index 0 is a stay"),
        ({"paths": (Path(0, "<ab_1", 0, 1),)}, "is labelled like"),
        ({"paths": (Path(0, "ab~_1", 0, 1),)}, "is labelled like"),
        ({"paths": (Path(0, "ab~_1", 0, 1, symmetric=True),)}, "both its ends must be"),
        ({"paths": (Path(0, "ab_1", 0, 1, mirror_of=3),)}, "not in the graph"),
        ({"paths": (Path(0, "ab_1", 0, 1, mirror_of=0),)}, "played backwards"),
        ({"paths": (Path(0, "ab_1", 0, 1, mirror_of=1), Path(1, "ba_1", 1, 0, mirror_of=0))}, "mirror images of its ends"),
        ({"paths": (Path(0, "ab_1", 0, 1, inferred=True, occurrences=(Occurrence(0, 0, 9),)),)}, "is inferred and yet"),
        ({"paths": (Path(0, "ab_1", 0, 1, occurrences=(Occurrence(0, 0, 9, reversed=True),)),)}, "not reversible"),
        ({"paths": (Path(0, "ab_1", 0, 1, occurrences=(Occurrence(3, 0, 9),)),)}, "source 3"),
    ],
)  # fmt: skip
def test_what_is_no_graph_is_refused(change: dict[str, tuple[State, ...]], message: str) -> None:
    """Each inconsistency is named by the thing that has it."""
    with pytest.raises(InputError, match=message):
        dataclasses.replace(MotionGraph((State(0, "A"), State(1, "B")), (Path(0, "ab_1", 0, 1),)), **change)


@pytest.mark.parametrize(
    ("start", "end", "message"),
    [(6, 15, "should start at 5"), (4, 15, "should start at 5"), (5, 5, "is empty"), (5, 14, "should start at 14")],
)
def test_steps_that_do_not_tile_the_frames_are_refused(start: int, end: int, message: str) -> None:
    """A gap, an overlap, an empty step: each frame belongs to exactly one step."""
    graph = _squat()
    path = graph.paths[0]
    broken = dataclasses.replace(path, occurrences=(Occurrence(0, start, end), path.occurrences[1]))
    with pytest.raises(InputError, match=message):
        dataclasses.replace(graph, paths=(broken,))


def test_a_timeline_that_ends_early_is_refused() -> None:
    """The last step reaches the last frame."""
    with pytest.raises(InputError, match="tile all 41 frames"):
        dataclasses.replace(_squat(), sources=(Source("squat", 41, 10.0),))


def test_a_step_that_begins_elsewhere_is_refused() -> None:
    """One cannot go down twice without coming up."""
    graph = _squat()
    twice = dataclasses.replace(graph.paths[0], occurrences=(Occurrence(0, 5, 15), Occurrence(0, 25, 35)))
    with pytest.raises(InputError, match="begins in 'X~', but the step before it ended in 'Y~'"):
        dataclasses.replace(graph, paths=(twice,))


def test_only_the_ends_of_a_recording_can_be_incomplete() -> None:
    """In the middle there is nothing that could have cut a step short."""
    graph = _walk()
    cut = dataclasses.replace(graph.paths[1], occurrences=(Occurrence(0, 10, 20, complete=False),))
    with pytest.raises(InputError, match="can be incomplete"):
        dataclasses.replace(graph, paths=(graph.paths[0], cut))


def test_of_two_mirror_images_both_are_reversible_or_none() -> None:
    """What a body can do one way round it can do the other."""
    graph = _walk()
    with pytest.raises(InputError, match="only one is reversible"):
        dataclasses.replace(graph, paths=(dataclasses.replace(graph.paths[0], reversible=True), graph.paths[1]))


def test_an_unknown_label_is_answered_with_those_that_are() -> None:
    """The message lists what could have been meant."""
    with pytest.raises(InputError, match=r"No state is called 'B'\. States: A, A\*"):
        _walk().state("B")
    with pytest.raises(InputError, match=r"No path is called 'ab_1'\. Paths: aa\*_1, \(aa\*_1\)\*"):
        _walk().path("ab_1")
    with pytest.raises(InputError, match="No source 1 in a graph of 1"):
        _walk().timeline(1)


# labels


def test_states_and_paths_are_labelled_as_in_the_dissertation() -> None:
    """Symmetric states are X, Y, W; the others A, B; the image seen second has the star; parallel paths count."""
    graph = build(
        [State(7, symmetric=True), State(3, mirror_of=4), State(4, mirror_of=3), State(9, symmetric=True), State(5)],
        [
            Path(2, from_=7, to=4, mirror_of=8, occurrences=(Occurrence(0, 0, 10),)),
            Path(3, from_=4, to=7, occurrences=(Occurrence(0, 10, 20), Occurrence(0, 50, 60))),
            Path(8, from_=7, to=3, mirror_of=2, occurrences=(Occurrence(0, 20, 30),)),
            Path(4, from_=3, to=7, occurrences=(Occurrence(0, 30, 40),)),
            Path(5, from_=7, to=4, occurrences=(Occurrence(0, 40, 50),)),
            Path(6, from_=7, to=9, symmetric=True, occurrences=(Occurrence(0, 60, 70),)),
            Path(1, from_=9, to=5, occurrences=(Occurrence(0, 70, 80),)),
            Path(0, from_=5, to=3, occurrences=(Occurrence(0, 80, 90),)),
        ],
        [Source("made", 90, 30.0)],
    )
    assert [s.label for s in graph.states] == ["X~", "A", "A*", "Y~", "B"]
    assert graph.notation() == "xa_1 ax_1 (xa_1)* (ax_2)* xa_2 ax_1 xy~_1 yb_1 ba*_1"
    assert [p.index for p in graph.paths] == [1, 1, 1, 2, 2, 1, 1, 1]
    assert [s.id for s in graph.states] == [0, 1, 2, 3, 4]


def test_a_reversible_path_is_named_by_its_first_direction() -> None:
    """Begun at the far end, a path is called from there; its mirror image turns with it."""
    graph = build(
        [State(0, symmetric=True), State(1, mirror_of=2), State(2, mirror_of=1)],
        [
            Path(0, from_=0, to=1, reversible=True, mirror_of=1, occurrences=(Occurrence(0, 0, 10, reversed=True),)),
            Path(1, from_=0, to=2, mirror_of=0, occurrences=(Occurrence(0, 10, 20),)),
        ],
        [Source("jog", 20, 30.0)],
    )
    assert graph.notation() == "ax_1 <(ax_1)*"
    assert all(p.reversible for p in graph.paths)


def test_letters_do_not_run_out() -> None:
    """After the last letter come A1, B1, …; no label is given twice."""
    graph = build([State(k) for k in range(40)] + [State(k, symmetric=True) for k in range(40, 60)], [])
    labels = [s.label for s in graph.states]
    assert labels[16:19] == ["Q", "A1", "B1"]
    assert labels[40:50] == ["X~", "Y~", "W~", "V~", "U~", "T~", "S~", "R~", "X1~", "Y1~"]
    assert len(set(labels)) == 60


def test_labels_do_not_depend_on_the_order_given(performed: MotionGraph) -> None:
    """The same states and paths in another order make the same graph."""
    made = build(performed.states, performed.paths, performed.sources)
    assert build(performed.states[::-1], performed.paths[::-1], performed.sources) == made
    assert build(made.states, made.paths, made.sources) == made


# sentences


def test_a_timeline_tiles_the_frames(performed: MotionGraph) -> None:
    """Every frame belongs to one step, and each step begins where the last one ended."""
    steps = performed.timeline()
    frames = [f for step in steps for f in range(step.start, step.end)]
    assert frames == list(range(performed.sources[0].frames))
    for one, following in itertools.pairwise(steps):
        assert ends_of(performed, one)[1] == ends_of(performed, following)[0]


def test_the_performers_notation_is_read_from_the_graph() -> None:
    """The string of paths of the score is the string of the graph, stays and cut ends apart."""
    for name in PERFORMED:
        truth = performer.perform(name).truth
        words = [w for w in graph_of(truth).notation().split() if not w.rstrip(")*").endswith("_0") and ".." not in w]
        assert " ".join(words) == truth.notation


# other graphs from it


def test_racemising_reflects_all_and_invents_nothing(performed: MotionGraph) -> None:
    """Everything has its image, what was there stays as it was, what is new is inferred; twice is once."""
    racemic = performed.racemic()
    for state in racemic.states:
        assert racemic.mirror_state(state.id) is not None
    for path in racemic.paths:
        assert path.symmetric or path.mirror_of is not None
    new = racemic.paths[len(performed.paths) :]
    assert all(p.inferred and not p.occurrences for p in new)
    assert [p.label for p in racemic.paths[: len(performed.paths)]] == [p.label for p in performed.paths]
    assert racemic.notation() == performed.notation()
    assert racemic.racemic() == racemic
    assert racemic.isomorphic_to(racemic.mirrored())


def test_the_limp_racemised_is_two_components() -> None:
    """The image of a graph without a symmetric state does not touch it (§3.5.5); the dotted loop is (aa)*."""
    racemic = graph_of(performer.limp(seconds=6).truth).racemic()
    assert [s.label for s in racemic.states] == ["A", "A*"]
    assert [(p.label, p.inferred) for p in racemic.paths] == [("aa_1", False), ("(aa_1)*", True)]
    assert racemic.components() == ((0,), (1,))


def test_the_kata_racemised_is_strongly_connected() -> None:
    """§3.6.3: from every state every other can be reached."""
    graph = graph_of(performer.kata().truth).racemic()
    assert len(graph.strongly_connected()) == 1
    assert graph.dead_ends() == ()


def test_mirrored_twice_and_reversed_twice_is_the_graph(performed: MotionGraph) -> None:
    """Both are involutions."""
    assert performed.mirrored().mirrored() == performed
    assert performed.reversed_in_time().reversed_in_time() == performed


def test_the_graph_of_the_mirrored_performance_is_the_mirrored_graph(performed: MotionGraph) -> None:
    """A mirrored recording says the same sentence with the stars exchanged."""
    mirrored = performed.mirrored()
    assert mirrored.isomorphic_to(performed)
    steps = [w.strip(".<") for w in performed.notation().split()]
    starred = [w.strip(".<") for w in mirrored.notation().split()]
    for a, b in zip(steps, starred, strict=True):
        assert ("~" in a and a == b) or a == f"({b})*" or b == f"({a})*"


def test_the_graph_of_the_reversed_performance_is_the_reversed_graph() -> None:
    """Every one-way arrow is turned, every reversible path traversed the other way."""
    for name in PERFORMED:
        truth = performer.perform(name).truth
        graph = graph_of(truth)
        backwards = graph.reversed_in_time()
        assert backwards.notation().split().__len__() == graph.notation().split().__len__()
        turned = truth.reverse()
        for path, true in zip(backwards.paths, turned.paths, strict=True):
            assert (backwards.state(path.from_).label, backwards.state(path.to).label) == (true.from_, true.to)
            assert [(o.start, o.end, o.reversed) for o in path.occurrences] == [
                (o.start, o.end, o.reversed) for o in true.occurrences
            ]


def test_states_without_a_trace_are_contracted() -> None:
    """B lies on the only way from A to X, and B* on the way from A*: both go, A, A* and the symmetric X stay."""
    graph = MotionGraph(
        (
            State(0, "X~", symmetric=True),
            State(1, "A", mirror_of=2),
            State(2, "A*", mirror_of=1),
            State(3, "B", mirror_of=4),
            State(4, "B*", mirror_of=3),
        ),
        (
            Path(0, "xa_1", 0, 1, 1, mirror_of=1, occurrences=(Occurrence(0, 0, 4), Occurrence(0, 12, 16))),
            Path(1, "(xa_1)*", 0, 2, 1, mirror_of=0, occurrences=(Occurrence(0, 24, 28),)),
            Path(2, "ab_1", 1, 3, 1, mirror_of=3, occurrences=(Occurrence(0, 4, 8), Occurrence(0, 16, 20))),
            Path(3, "(ab_1)*", 2, 4, 1, mirror_of=2, occurrences=(Occurrence(0, 28, 32),)),
            Path(4, "bx_1", 3, 0, 1, mirror_of=5, occurrences=(Occurrence(0, 8, 12), Occurrence(0, 20, 24))),
            Path(5, "(bx_1)*", 4, 0, 1, mirror_of=4, occurrences=(Occurrence(0, 32, 36),)),
            Path(6, "xx~_1", 0, 0, 1, symmetric=True, occurrences=(Occurrence(0, 36, 40),)),
        ),
        (Source("loops", 40, 10.0),),
    )
    small = graph.contracted()
    assert small.notation() == "xx_1 xx_1 (xx_1)* xx~_1"
    assert [(s.start, s.end) for s in small.timeline()] == [(0, 12), (12, 24), (24, 36), (36, 40)]
    held = dataclasses.replace(
        graph,
        states=(*graph.states[:3], dataclasses.replace(graph.states[3], stays=(Stay(0, 8, 10),)), graph.states[4]),
        paths=(
            *graph.paths[:4],
            dataclasses.replace(graph.paths[4], occurrences=(Occurrence(0, 10, 12), Occurrence(0, 20, 24))),
            *graph.paths[5:],
        ),
    )
    assert [s.label for s in held.contracted().states] == ["X~", "A", "A*"]


def test_a_cycle_keeps_its_state() -> None:
    """A walk has nothing but states with one way in and one way out: the last of them cannot go."""
    assert _walk().contracted() == _walk()


@pytest.mark.parametrize(
    ("name", "states", "edges"),
    [
        ("jumping_jacks", ["X~"], [("X~", "X~", "xx~", True)]),
        ("jog_in_place", ["A", "A*"], [("A", "A*", "X~", True)]),
        ("walk", ["A", "A*"], [("A", "A*", "aa*_1", True)]),
        ("side_kicks", ["A", "A*"], [("A", "A*", "X~", True), ("A", "A", "aa_1", False), ("A*", "A*", "(aa_1)*", False)]),
        ("butterfly", ["X~"], [("X~", "X~", "xx~_1", False)]),
        ("limp", ["A"], [("A", "A", "aa_1", False)]),
    ],
)  # fmt: skip
def test_the_short_studies_condense_as_in_the_figures(
    name: str, states: list[str], edges: list[tuple[str, str, str, bool]]
) -> None:
    """What Figures 64-69 give after "or"."""
    graph = graph_of(performer.perform(name).truth)
    short = graph.condensed()
    assert [s.label for s in short.states] == states
    drawn = [(graph.state(e.from_).label, graph.state(e.to).label, e.label, e.both_ways) for e in short.edges]
    assert drawn == edges
    assert sorted(p for e in short.edges for p in e.paths) == [p.id for p in graph.paths]


# comparison


@given(st.integers(2, 14), st.integers(0, 10**6), st.integers(0, 10**6))
def test_a_graph_renamed_is_the_same_graph(size: int, seed: int, order: int) -> None:
    """Ids, order, labels and the direction in which a reversible path is named do not matter."""
    graph = random_graph(size, seed)
    assert graph.isomorphic_to(shuffled(graph, order))
    assert graph.edit_distance(shuffled(graph, order)).value == 0


def _changed(graph: MotionGraph, kind: str) -> MotionGraph | None:
    """A graph that differs in one thing, or None where it has no such thing."""
    states, paths = list(graph.states), list(graph.paths)
    if kind == "path":
        last = paths[-1]
        keep = [p for p in paths if p.id not in (last.id, last.mirror_of)]
        return build(states, keep)
    if kind == "parallel":
        return build(states, [*paths, Path(len(paths), from_=paths[0].from_, to=paths[0].to)])
    if kind == "direction":
        one = next((k for k, p in enumerate(paths) if not p.reversible and p.from_ != p.to), None)
        if one is None:
            return None
        pair = {paths[one].id, paths[one].mirror_of}
        return build(states, [dataclasses.replace(p, from_=p.to, to=p.from_) if p.id in pair else p for p in paths])
    if kind == "reversible":
        pair = {paths[0].id, paths[0].mirror_of}
        return build(
            states, [dataclasses.replace(p, reversible=not p.reversible) if p.id in pair else p for p in paths]
        )
    pairs = [p for p in paths if p.mirror_of is not None]
    if not pairs:
        return None
    unpaired = {pairs[0].id, pairs[0].mirror_of}
    return build(states, [dataclasses.replace(p, mirror_of=None) if p.id in unpaired else p for p in paths])


@pytest.mark.parametrize("kind", ["path", "parallel", "reversible", "pairing"])
@pytest.mark.parametrize("seed", range(6))
def test_a_graph_that_differs_is_another(kind: str, seed: int) -> None:
    """One path more or less, one flag, one pair of mirror images: no longer isomorphic, and a few edits away."""
    graph = random_graph(5, seed)
    other = _changed(graph, kind)
    if other is None:
        other = _changed(random_graph(5, seed + 100), "path")
        assert other is not None
    assert not graph.isomorphic_to(other)
    distance = graph.edit_distance(other)
    assert distance.exact
    assert distance.value >= 1
    assert distance == other.edit_distance(graph)


def test_one_arrow_turned_is_another_graph() -> None:
    """A chain is not a fork, though both have three states and two paths."""
    states = [State(0), State(1), State(2)]
    chain = build(states, [Path(0, from_=0, to=1), Path(1, from_=1, to=2)])
    fork = build(states, [Path(0, from_=1, to=0), Path(1, from_=1, to=2)])
    assert not chain.isomorphic_to(fork)
    assert chain.edit_distance(fork) == fork.edit_distance(chain)
    assert chain.edit_distance(fork).value == 2


@pytest.mark.parametrize(
    ("added", "distance"),
    [
        ({}, 0),
        ({"paths": [Path(2, from_=0, to=1)]}, 1),
        ({"states": [State(3)]}, 1),
        ({"states": [State(3)], "paths": [Path(2, from_=2, to=3, reversible=True), Path(3, from_=3, to=3)]}, 3),
    ],
)
def test_the_edit_distance_counts_what_was_added(added: dict[str, list[State]], distance: int) -> None:
    """States and paths count one each."""
    states = [State(0), State(1), State(2, symmetric=True)]
    paths = [Path(0, from_=0, to=1), Path(1, from_=1, to=2)]
    graph = build(states, paths)
    more = build([*states, *added.get("states", [])], [*paths, *added.get("paths", [])])
    assert graph.edit_distance(more).value == distance
    assert more.edit_distance(graph).value == distance


def _by_force(a: MotionGraph, b: MotionGraph) -> int:
    """Fewest edits over all assignments of the states of the smaller graph, written out."""
    if len(a.states) > len(b.states):
        a, b = b, a
    left, right = [s.id for s in a.states], [s.id for s in b.states]

    def kinds(graph: MotionGraph, u: int | None, v: int | None) -> list[tuple[str, bool, bool, bool]]:
        out = []
        for p in graph.paths:
            if {p.from_, p.to} == {u, v}:
                way = "both" if p.reversible else "there" if p.from_ == u else "back"
                out.append((way, p.symmetric, p.antipalindromic, p.mirror_of is not None))
        return out

    def pair_cost(x: list[tuple[str, bool, bool, bool]], y: list[tuple[str, bool, bool, bool]]) -> int:
        if not x or not y:
            return len(x) + len(y)
        best = len(x) + len(y)
        for k, theirs in enumerate(y):
            rest = pair_cost(x[1:], y[:k] + y[k + 1 :])
            fits = x[0][0] == theirs[0] or "both" in (x[0][0], theirs[0])
            best = min(best, rest + (0 if x[0] == theirs else 1 if fits else 2))
        return min(best, 1 + pair_cost(x[1:], y))

    def cost(choice: tuple[int | None, ...]) -> int:
        image = dict(zip(left, choice, strict=True))
        total = sum(v is None for v in choice) + sum(s not in choice for s in right)
        for s in left:
            if image[s] is not None:
                total += a.state(s).symmetric != b.state(image[s]).symmetric
        for u, v in itertools.combinations_with_replacement(left, 2):
            x, y = image[u], image[v]
            total += pair_cost(kinds(a, u, v), kinds(b, x, y) if x is not None and y is not None else [])
            if u != v and x is not None and y is not None:
                total += (a.state(u).mirror_of == v) != (b.state(x).mirror_of == y)
        return total + sum(p.from_ not in choice or p.to not in choice for p in b.paths)

    return min(cost(c) for c in itertools.permutations([*right, *([None] * len(left))], len(left)))


@pytest.mark.parametrize("seed", range(8))
def test_the_edit_distance_is_the_least_over_all_assignments(seed: int) -> None:
    """The search agrees with trying everything."""
    a, b = random_graph(3, seed), random_graph(4 - seed % 2, seed + 50)
    found = a.edit_distance(b)
    assert found.exact
    assert found.value == _by_force(a, b)


def test_large_graphs_get_a_bound() -> None:
    """The search stops, says that it did, and its value is no less than the difference in size."""
    a, b = random_graph(30, 1), random_graph(28, 2)
    found = a.edit_distance(b)
    assert not found.exact
    assert found.value >= 2


# other forms


def test_json_goes_there_and_back(performed: MotionGraph) -> None:
    """What was written is read as the same graph."""
    assert exchange.from_json(performed.to_json()) == performed
    assert MotionGraph.from_dict(performed.racemic().to_dict()) == performed.racemic()


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda d: d.pop("states"), "Expected the key 'states' in graph"),
        (lambda d: d["states"][0].pop("label"), r"Expected the key 'label' in graph.states\[0\]"),
        (lambda d: d["paths"][1].update(to="A"), r"Expected int at graph.paths\[1\].to, got str"),
        (lambda d: d["paths"][0].update(reversible=1), r"Expected bool at graph.paths\[0\].reversible, got int"),
        (lambda d: d["states"].append(7), r"Expected an object at graph.states\[2\], got int"),
        (lambda d: d.update(notation="aa*_1"), "does not agree"),
    ],
)
def test_a_spoilt_file_is_refused(spoil, message: str) -> None:
    """The message says where."""
    values = json.loads(_walk().to_json())
    spoil(values)
    with pytest.raises(InputError, match=message):
        MotionGraph.from_dict(values)


def test_what_is_not_json_is_refused() -> None:
    """With the line."""
    with pytest.raises(InputError, match="not JSON: line 1"):
        exchange.from_json("{")


def test_networkx_has_both_directions_of_a_reversible_path() -> None:
    """One edge a direction, flagged; the seconds are those spent."""
    graph = _squat().to_networkx()
    assert set(graph.nodes) == {"X~", "Y~"}
    assert set(graph.edges) == {("X~", "Y~", "xy~_1"), ("Y~", "X~", "<xy~_1")}
    back = graph.edges["Y~", "X~", "<xy~_1"]
    assert back["backwards"]
    assert back["occurrences"] == 1
    assert back["seconds"] == pytest.approx(1.0)
    assert graph.nodes["X~"]["seconds"] == pytest.approx(1.0)
    assert nx.shortest_path(_walk().to_networkx(), "A*", "A") == ["A*", "A"]


@pytest.mark.parametrize("size", [1, 4, 15, 40])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_parts_are_those_that_networkx_finds(size: int, seed: int) -> None:
    """Weakly and strongly connected parts of graphs at random, and of the same with half of their paths."""
    whole = random_graph(size, seed)
    alone = [dataclasses.replace(p, mirror_of=None) for p in whole.paths if p.id % 4 < 2]
    for graph in (whole, MotionGraph(whole.states, tuple(alone), whole.sources)):
        net = graph.to_networkx()
        ids = {s.label: s.id for s in graph.states}
        for ours, theirs in (
            (graph.components(), nx.weakly_connected_components(net)),
            (graph.strongly_connected(), nx.strongly_connected_components(net)),
        ):
            assert sorted(ours) == sorted(tuple(sorted(ids[name] for name in part)) for part in theirs)
            assert [len(part) for part in ours] == sorted((len(part) for part in ours), reverse=True)


def test_graphml_is_valid_and_is_read_back(performed: MotionGraph) -> None:
    """networkx reads nodes, edges and every fact as it knows them."""
    written = performed.to_graphml()
    assert ElementTree.fromstring(written).tag.endswith("graphml")
    read = nx.parse_graphml(written, force_multigraph=True)
    made = performed.to_networkx()
    assert dict(read.nodes(data=True)) == dict(made.nodes(data=True))
    assert {e[:3]: e[3] for e in read.edges(keys=True, data=True)} == {
        e[:3]: e[3] for e in made.edges(keys=True, data=True)
    }


def test_mermaid_tells_the_kinds_of_paths_apart() -> None:
    """Two heads for a reversible path, dots for one that is inferred, no star that Markdown could swallow."""
    drawn = graph_of(performer.side_kicks().truth).to_mermaid().splitlines()
    assert drawn[0] == "flowchart LR"
    assert '  s1(["X̄"])' in drawn
    assert '  s0 <-->|"ax₁"| s1' in drawn
    assert '  s2 -->|"(aa₁)#42;"| s2' in drawn
    limp = graph_of(performer.limp(seconds=5).truth).racemic().to_mermaid()
    assert "-.->" in limp
    assert "no states" in MotionGraph().to_mermaid()
