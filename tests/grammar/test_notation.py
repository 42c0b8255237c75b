"""The string of paths: written, read, rebuilt, and shown to people."""

from __future__ import annotations

import dataclasses

import matplotlib.mathtext
import pytest

import kinesics.performer as performer
from kinesics.errors import InputError
from kinesics.grammar import notation
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, Source, State, build
from motion_graphs import graph_of, random_graph


@pytest.mark.parametrize("name", performer.NAMES)
def test_the_timeline_is_rebuilt_from_graph_and_string(name: str) -> None:
    """Exactly, for every performance."""
    graph = graph_of(performer.perform(name).truth)
    assert graph.states
    assert graph.rebuild(graph.notation(0), 0) == graph.timeline(0)


def test_several_recordings_are_several_lines() -> None:
    """One line a source, each rebuilt by itself."""
    once = graph_of(performer.squat(seconds=5).truth)
    path = once.paths[0]
    twice = MotionGraph(
        tuple(
            dataclasses.replace(s, stays=(*s.stays, *(dataclasses.replace(r, source=1) for r in s.stays)))
            for s in once.states
        ),
        (
            dataclasses.replace(
                path,
                occurrences=(*path.occurrences, *(dataclasses.replace(o, source=1) for o in path.occurrences)),
            ),
        ),
        (once.sources[0], dataclasses.replace(once.sources[0], name="again")),
    )
    assert twice.notation() == once.notation() + "\n" + once.notation()
    assert twice.rebuild(twice.notation(1), 1) == twice.timeline(1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("aa_1 bb_1", "Word 2 of the notation, 'bb_1', is neither a path nor a stay"),
        ("<aa_1", "goes backwards along 'aa_1', which is not reversible"),
        ("aa_1 (aa_1)*", r"begins in 'A\*', but the word before it ends in 'A'"),
        ("aa_1 ax_1.. <(ax_1)*", "cut short in the middle"),
        ("aa_1 aa_1 aa_1 aa_1 aa_1", "was not performed at frame"),
        ("aa_1 aa_1", "The notation ends at frame"),
        ("aa_1 ax_1 <ax_1", "was not performed"),
    ],
)
def test_a_wrong_sentence_is_refused(text: str, message: str) -> None:
    """Unknown words, wrong ways, leaps, and sentences that are not the recording's."""
    graph = graph_of(performer.side_kicks().truth)
    with pytest.raises(InputError, match=message):
        graph.rebuild(text)


def test_the_index_may_be_left_out_where_it_says_nothing() -> None:
    """``ax`` is ``ax_1`` where there is no ``ax_2``; ``xa`` of the kata could be two."""
    kicks = graph_of(performer.side_kicks().truth)
    assert notation.parse(kicks, "aa ax <(ax)*") == notation.parse(kicks, "aa_1 ax_1 <(ax_1)*")
    with pytest.raises(InputError, match="neither a path"):
        notation.parse(graph_of(performer.kata().truth), "xa")


@pytest.mark.parametrize(
    ("ends", "symmetric", "expected"),
    [
        (("A", "B"), False, ("ab", False)),
        (("A*", "B*"), False, ("ab", True)),
        (("A", "B*"), False, ("ab*", False)),
        (("A*", "B"), False, ("ab*", True)),
        (("A", "A*"), False, ("aa*", False)),
        (("A*", "A"), False, ("aa*", True)),
        (("X~", "A*"), False, ("xa", True)),
        (("X~", "Y~"), True, ("xy~", False)),
        (("X~", "Y~"), False, ("xy", False)),
        (("X1~", "A12"), False, ("x1a12", False)),
        (("guard*", "B"), False, ("guard-b*", True)),
    ],
)
def test_labels_follow_from_the_ends(ends: tuple[str, str], symmetric: bool, expected: tuple[str, bool]) -> None:
    """The star goes to the path that begins on the starred side."""
    assert notation.path_base(*ends, symmetric) == expected


@pytest.mark.parametrize(
    ("state", "stay"), [("A", "aa_0"), ("A*", "(aa_0)*"), ("X~", "xx~_0"), ("B2", "b2b2_0"), ("guard", "guard-guard_0")]
)
def test_a_stay_is_the_path_with_index_0(state: str, stay: str) -> None:
    """§3.2.1."""
    assert notation.stay_label(state) == stay


def test_mirroring_a_label_twice_gives_it_back() -> None:
    """Of every state and path of random graphs."""
    for seed in range(5):
        graph = random_graph(12, seed)
        for state in graph.states:
            assert notation.mirror_state_label(notation.mirror_state_label(state.label)) == state.label
        for path in graph.paths:
            assert notation.mirror_path_label(notation.mirror_path_label(path.label)) == path.label


@pytest.mark.parametrize(
    ("label", "shown"),
    [
        ("A", "A"),
        ("A*", "A*"),
        ("X~", "X̄"),
        ("ab_1", "ab₁"),
        ("(ab_12)*", "(ab₁₂)*"),
        ("xy~_1", "x̄ȳ₁"),
        ("X1~", "X̄₁"),
        ("A12*", "A₁₂*"),
        ("attention~", "attention~"),
        ("attention-x~_1", "attention-x~₁"),
    ],
)
def test_people_see_bars_and_subscripts(label: str, shown: str) -> None:
    """The label as the dissertation prints it."""
    assert notation.pretty_label(label) == shown


def test_a_sentence_for_people() -> None:
    """States between arrows, each once; what is held has an ellipsis."""
    assert graph_of(performer.sway().truth).pretty() == "A… ax₁→ X̄ ←(ax₁)* A*…"
    assert graph_of(performer.bow().truth).pretty() == "X̄… x̄ȳ₁→ Ȳ ←x̄ȳ₁ X̄…"


def test_where_a_recording_begins_and_ends_on_the_way_is_shown() -> None:
    """The state that it does not reach is not said."""
    cut = build(
        [State(0, symmetric=True), State(1, symmetric=True)],
        [
            Path(
                0, from_=0, to=1, occurrences=(Occurrence(0, 0, 5, False, False), Occurrence(0, 10, 15, False, False))
            ),
            Path(1, from_=1, to=0, occurrences=(Occurrence(0, 5, 10),)),
        ],
        [Source("cut", 15, 30.0)],
    )
    assert cut.notation() == "..yx_1 xy_1 yx_1.."
    assert cut.pretty() == "..yx₁→ X̄ xy₁→ Ȳ yx₁→.."


@pytest.mark.parametrize(
    "label", ["A", "A*", "A1*", "X~", "X2~", "ab_1", "ab*_2", "(ab_12)*", "xy~_1", "guard-b_1", "(lunge)*", "jab~"]
)
def test_matplotlib_understands_every_label(label: str) -> None:
    """Each is valid mathtext, with and without the index."""
    parser = matplotlib.mathtext.MathTextParser("path")
    for index in (True, False):
        assert parser.parse(notation.mathtext(label, index=index)).width > 0
    assert "_{" not in notation.mathtext("ab_1", index=False)


def test_a_state_alone_has_the_notation_of_nothing() -> None:
    """A graph without recordings has no sentence."""
    assert MotionGraph((State(0, "A"),), (Path(0, "aa_1"),)).notation() == ""
