"""What a person knows better is honoured when a recording is analysed again."""

from __future__ import annotations

import pytest

import kinesics as kx
from kinesics.errors import InputError
from kinesics.grammar import edits


@pytest.fixture(scope="module")
def motion() -> kx.Motion:
    return kx.performer.jumping_jacks(seconds=8, fps=30, seed=0).motion


@pytest.fixture(scope="module")
def plain(motion: kx.Motion) -> kx.Analysis:
    return kx.analyze(motion)


def test_phrases_are_cut_and_named_and_judged_anew(motion: kx.Motion, plain: kx.Analysis) -> None:
    """One phrase of jumping jacks cut in two: both are jumping jacks, and one has a name."""
    text = "phrases.split = [ { frame = 120 } ]\nphrases.rename = [ { frame = 130, name = 'second set' } ]"
    edited = kx.analyze(motion, edits=edits.parse(text))
    assert 120 in {p.start for p in edited.phrases}
    assert 120 not in {p.start for p in plain.phrases}
    assert [p.end for p in edited.phrases[:-1]] == [p.start for p in edited.phrases[1:]]
    assert {p.class_ for p in edited.phrases} == {"cyclic-symmetric-palindromic"}
    assert [p.name for p in edited.phrases if p.start <= 130 < p.end] == ["second set"]
    assert kx.Analysis.from_dict(edited.to_dict()) == edited


def test_states_are_named_and_the_rest_stays(motion: kx.Motion, plain: kx.Analysis) -> None:
    """The graph is the same graph by other names."""
    edited = kx.analyze(motion, edits=edits.parse('states.rename = { "Y~" = "star" }'))
    assert {s.label for s in edited.graph.states} == {
        "star~" if s.label == "Y~" else s.label for s in plain.graph.states
    }
    assert edited.graph.isomorphic_to(plain.graph)
    assert edited.phrases == plain.phrases


def test_labels_do_not_depend_on_the_edits_of_phrases(motion: kx.Motion, plain: kx.Analysis) -> None:
    """Phrases are edited after the graph was read: a file can speak of both."""
    edited = kx.analyze(motion, edits=edits.parse("phrases.split = [ { frame = 50 }, { frame = 99 } ]"))
    assert edited.graph == plain.graph


def test_edits_of_what_is_not_there_are_refused(motion: kx.Motion) -> None:
    """With what is."""
    with pytest.raises(InputError, match=r"No state is called 'Q'\. States: "):
        kx.analyze(motion, edits=edits.parse('states.rename = { Q = "star" }'))
    with pytest.raises(InputError, match="No phrase at frame 4000 of source 0"):
        kx.analyze(motion, edits=edits.parse("phrases.split = [ { frame = 4000 } ]"))
