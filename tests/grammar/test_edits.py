"""The side file: names, merges and splits, done again on every analysis."""

from __future__ import annotations

import itertools

import pytest

import kinesics.performer as performer
from kinesics.errors import InputError
from kinesics.grammar import edits
from kinesics.grammar.edits import Edits, Phrase
from kinesics.grammar.graph import MotionGraph
from motion_graphs import graph_of


@pytest.fixture(scope="module")
def kata() -> MotionGraph:
    return graph_of(performer.kata().truth)


@pytest.fixture(scope="module")
def kicks() -> MotionGraph:
    return graph_of(performer.side_kicks().truth)


def _apply(graph: MotionGraph, text: str) -> MotionGraph:
    edited = edits.parse(text).apply(graph)
    for source in range(len(graph.sources)):
        assert edited.rebuild(edited.notation(source), source) == edited.timeline(source)
        assert [(s.start, s.end) for s in edited.timeline(source)] == [(s.start, s.end) for s in graph.timeline(source)]
    return edited


def test_an_empty_file_changes_nothing(kata: MotionGraph) -> None:
    """Not a label."""
    assert _apply(kata, "") == kata
    assert edits.parse("") == Edits()


def test_states_are_renamed_with_their_images_and_paths(kicks: MotionGraph) -> None:
    """A* becomes guard*, the paths follow."""
    named = _apply(kicks, 'states.rename = { A = "guard", "X~" = "attention" }')
    assert [s.label for s in named.states] == ["guard", "attention~", "guard*"]
    assert [p.label for p in named.paths] == [
        "guard-guard_1", "(guard-guard_1)*", "guard-attention_1", "(guard-attention_1)*",
    ]  # fmt: skip
    assert named.isomorphic_to(kicks)


def test_what_is_called_after_its_image_has_no_name_of_its_own(kicks: MotionGraph) -> None:
    """A* cannot be guard while A is guard*: refused, with the name to give instead. A frame names the pair."""
    with pytest.raises(InputError, match=r"""with "A" = "guard", 'A\*' is 'guard\*'"""):
        _apply(kicks, 'states.rename = { "A*" = "guard" }')
    with pytest.raises(InputError, match=r"""with "ax_1" = "turn", '\(ax_1\)\*' is '\(turn\)\*'"""):
        _apply(kicks, 'paths.rename = { "(ax_1)*" = "turn" }')


def test_paths_are_renamed_with_their_images(kicks: MotionGraph) -> None:
    """The string of paths says the names."""
    named = _apply(kicks, 'paths.rename = { aa_1 = "kick", ax_1 = "turn" }')
    assert named.notation().split()[3:7] == ["kick", "turn", "<(turn)*", "(kick)*"]


def test_a_symmetric_path_keeps_its_bar() -> None:
    """The name gets the bar."""
    yoga = graph_of(performer.sun_salutation().truth)
    assert "vinyasa~" in _apply(yoga, 'paths.rename = { "vv~_1" = "vinyasa" }').notation().split()


def test_states_are_merged_with_their_images(kata: MotionGraph) -> None:
    """D goes into B, D* into B*; the paths between them become loops, and their number stays."""
    merged = _apply(kata, 'states.merge = [ { keep = "B", with = ["D"] } ]')
    assert [s.label for s in merged.states] == ["X~", "A", "A*", "B", "B*", "C", "C*"]
    assert len(merged.paths) == len(kata.paths)
    assert {"bb_1", "(bb_1)*", "cb_1", "(ba_1)*"} <= {p.label for p in merged.paths}
    stays = {s.label: len(s.stays) for s in kata.states}
    assert len(merged.state("B").stays) == stays["B"] + stays["D"]


def test_what_is_unlike_is_not_merged(kata: MotionGraph) -> None:
    """A symmetric state with a chiral one, a state with its own image, paths between different states."""
    with pytest.raises(InputError, match="one symmetric and one not"):
        _apply(kata, 'states.merge = [ { keep = "B", with = ["X~"] } ]')
    with pytest.raises(InputError, match="mirror images of each other"):
        _apply(kata, 'states.merge = [ { keep = "B", with = ["B*"] } ]')
    with pytest.raises(InputError, match="between different states"):
        _apply(kata, 'paths.merge = [ { keep = "ab_1", with = ["bc_1"] } ]')


def test_paths_are_merged_with_their_images(kata: MotionGraph) -> None:
    """xa_2 was xa_1 after all: one path and one image less."""
    merged = _apply(kata, 'paths.merge = [ { keep = "xa_1", with = ["xa_2"] } ]')
    assert len(merged.paths) == len(kata.paths) - 2
    assert len(merged.path("xa_1").occurrences) == 2
    assert merged.path("(xa_1)*").mirror_of == merged.path("xa_1").id


def test_a_way_and_the_way_back_merged_are_reversible() -> None:
    """vw is wv backwards, if the user says so; its traversals are backwards then."""
    yoga = graph_of(performer.sun_salutation().truth)
    merged = _apply(yoga, 'paths.merge = [ { keep = "wv_1", with = ["vw~_1"] } ]')
    path = merged.path("wv_1")
    assert path.reversible
    assert sorted(o.reversed for o in path.occurrences) == [False, False, True, True]
    assert not path.symmetric


def test_a_state_is_split_by_its_visits(kata: MotionGraph) -> None:
    """The middle X becomes a state of its own; all paths to and from it are new."""
    middle = kata.state("X~").stays
    frame = middle[1].start if len(middle) > 2 else middle[0].start
    split = _apply(kata, f'states.split = [ {{ state = "X~", into = "center", frames = [{frame}] }} ]')
    assert split.state("center~").symmetric
    assert len(split.state("center~").stays) + len(split.state("X~").stays) == len(middle)
    assert len(split.states) == len(kata.states) + 1


def test_a_state_that_is_only_passed_is_split_too(kicks: MotionGraph) -> None:
    """One visit of A between two kicks becomes B: the loop opens there."""
    boundary = kicks.path("aa_1").occurrences[0].end
    split = _apply(kicks, f'states.split = [ {{ state = "A", into = "B", frames = [{boundary + 3}] }} ]')
    assert split.notation().split()[:4] == ["ab_1", "ba_1", "aa_1", "aa_1"]
    assert split.state("B").mirror_of is None


def test_branches_of_images_are_images() -> None:
    """In jogging one visit of X and so one end of ax and of (ax)* is split off: the new ends are mirror images."""
    jog = graph_of(performer.jog_in_place(seconds=4).truth)
    first = jog.path("ax_1").occurrences[0].end
    split = _apply(jog, f'states.split = [ {{ state = "X~", into = "Y", frames = [{first}] }} ]')
    assert split.path("(ay_1)*").mirror_of == split.path("ay_1").id


def test_traversals_are_split_off_a_path(kicks: MotionGraph) -> None:
    """The second kick was another kick."""
    frame = kicks.path("aa_1").occurrences[1].start + 5
    split = _apply(kicks, f'paths.split = [ {{ path = "aa_1", into = "feint", frames = [{frame}] }} ]')
    assert split.notation().split()[:4] == ["aa_1", "feint", "aa_1", "aa_1"]
    unnamed = _apply(kicks, f'paths.split = [ {{ path = "aa_1", frames = [{frame}] }} ]')
    assert unnamed.notation().split()[:4] == ["aa_1", "aa_2", "aa_1", "aa_1"]


def test_all_of_a_thing_cannot_be_split_off(kicks: MotionGraph) -> None:
    """That would be a new name."""
    with pytest.raises(InputError, match="rename it instead"):
        _apply(kicks, 'paths.split = [ { path = "ax_1", frames = [700, 701, 650, 800] } ]'.replace(
            "700, 701, 650, 800", str(kicks.path("ax_1").occurrences[0].start)))  # fmt: skip


def test_splits_merges_and_names_work_together(kata: MotionGraph) -> None:
    """Labels are those of the analysis whatever else the file says."""
    text = """
        [states]
        rename = { B = "horse", A = "cat" }
        merge = [ { keep = "B", with = ["D"] } ]
        [paths]
        rename = { "xa_2" = "entry" }
        merge = [ { keep = "xa_2", with = ["xa_1"] } ]
    """
    edited = _apply(kata, text)
    assert [s.label for s in edited.states] == ["X~", "cat", "cat*", "horse", "horse*", "C", "C*"]
    assert len(edited.path("entry").occurrences) == 2
    assert edited.path("(entry)*").mirror_of == edited.path("entry").id


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('states.rename = { Q = "guard" }', r"No state is called 'Q'\. States: A, X~, A\*"),
        ('paths.rename = { "ab_1" = "go" }', "No path is called 'ab_1'. Paths: aa_1"),
        ('states.merge = [ { keep = "A", with = ["C"] } ]', "No state is called 'C'"),
        ('states.rename = { A = "two words" }', "without '~', '\\*' or spaces"),
        ('states.rename = { "X~" = "A~" }', "without '~'"),
        ('states.split = [ { state = "A", into = "B", frames = [0], source = 4 } ]', "No source 4"),
        ('paths.split = [ { path = "ax_1", frames = [1] } ]', "is not traversed at frame 1"),
        ("nonsense", "not TOML"),
        ("state = 1", "Unknown key 'state' in the edits. Keys: states, paths, phrases"),
        ('states.join = ["A"]', r"Unknown key 'join' in \[states\]. Keys: rename, merge, split"),
        ("states.rename = { A = 3 }", r"Expected a text for 'A' in \[states\] rename, got 3"),
        ('states.merge = [ { keep = "A" } ]', r"Expected the key 'with' in states.merge\[0\]"),
        ('[states]\nA = "guard"', r'Unknown key .A. in \[states\].*For example: rename = \{ A = "guard"'),
        ('[phrases]\n3 = "bow"', r"For example: rename = \[ \{ frame = 100"),
        ('states.merge = [ "A" ]', r"Expected a table with keep, with at states.merge\[0\]"),
        ('states.split = [ { state = "A", into = "B", frames = ["x"] } ]', "Expected a list of frames"),
        ('states.split = [ { state = "A", frames = [3] } ]', "Expected the key 'into'"),
        ("phrases.split = [ { frame = true } ]", "Expected a whole number for 'frame'"),
    ],
)
def test_a_wrong_file_is_refused(kicks: MotionGraph, text: str, message: str) -> None:
    """The message says which entry, and what there is."""
    with pytest.raises(InputError, match=message):
        _apply(kicks, text)


def test_a_frame_may_stand_for_a_label(kata: MotionGraph) -> None:
    """Every frame of a stay speaks of its state, every frame of a traversal of its path, and the middle of a stay splits it."""
    for step in kata.timeline(0):
        frames = (step.start, step.end - 1)
        for frame in frames:
            if step.path is None:
                said = _apply(kata, f'states.rename = {{ "@{frame}" = "here" }}')
                base = kata.state(step.state).label.rstrip("~*")
                assert said == _apply(
                    kata, f'states.rename = {{ "{base}{"~" * kata.state(step.state).symmetric}" = "here" }}'
                )
            else:
                assert "here" in "".join(
                    p.label for p in _apply(kata, f'paths.rename = {{ "0@{frame}" = "here" }}').paths
                )
    held = next(s for s in kata.timeline(0) if s.path is None)
    with pytest.raises(InputError, match="a state is held there"):
        _apply(kata, f'paths.rename = {{ "@{held.start}" = "x" }}')


def test_nothing_is_split_off_twice_or_has_two_names(kicks: MotionGraph) -> None:
    """What two entries ask for at once is refused, whichever of a pair of mirror images they speak of."""
    path = next(p for p in kicks.paths if len(p.occurrences) > 2)
    entry = f'{{ path = "{path.label}", frames = [{path.occurrences[1].start}] }}'
    with pytest.raises(InputError, match=r"split off twice: name each traversal"):
        _apply(kicks, f"paths.split = [ {entry}, {entry} ]")
    with pytest.raises(InputError, match=r"A visit of 'A' at frame 0 .* split off twice"):
        _apply(
            kicks,
            'states.split = [ { state = "A", into = "b", frames = [0] }, { state = "A", into = "c", frames = [0] } ]',
        )
    image = next(p for p in kicks.paths if p.label == "(ax_1)*").occurrences[0]
    passed = image.end if image.reversed else image.start
    assert passed > 0
    with pytest.raises(InputError, match="One state, with its mirror image, would be called both 'one' and 'two'"):
        _apply(kicks, f'states.rename = {{ A = "one", "@{passed}" = "two" }}')
    with pytest.raises(InputError, match="One path, with its mirror image, would be called both 'one' and 'two'"):
        _apply(kicks, f'paths.rename = {{ "ax_1" = "one", "@{image.start + 1}" = "two" }}')


def test_what_is_merged_with_itself_is_refused(kicks: MotionGraph) -> None:
    """Nothing would become of it: said, not passed over."""
    for what, label in (("states", "A"), ("paths", "aa_1")):
        with pytest.raises(InputError, match=f"two {what} or more in a merge, got '{label}' alone"):
            _apply(kicks, f'{what}.merge = [ {{ keep = "{label}", with = ["{label}"] }} ]')


def test_a_state_is_not_split_far_from_its_visits(kata: MotionGraph) -> None:
    """A frame names the visit a second off or less; farther off it names none, and the message tells where they are."""
    fps = kata.sources[0].fps
    visits = [(s.start, s.end) for s in kata.timeline(0) if s.path is None and kata.state(s.state).label == "X~"]
    (_, end), (start, _) = next(pair for pair in itertools.pairwise(visits) if pair[1][0] - pair[0][1] > 4 * fps)
    near, far = end + round(0.9 * fps), (end + start) // 2
    assert (
        _apply(kata, f'states.split = [ {{ state = "X~", into = "center", frames = [{near}] }} ]')
        .state("center~")
        .stays
    )
    with pytest.raises(
        InputError, match=rf"'X~' is not visited within 1 s of frame {far} of source 0; it is at \d+, \d+"
    ):
        _apply(kata, f'states.split = [ {{ state = "X~", into = "center", frames = [{far}] }} ]')


def test_what_is_refused_names_its_file(kicks: MotionGraph) -> None:
    """Where several files lie about, the message says in which one to look."""
    with pytest.raises(InputError, match=r"^kicks\.toml: No state is called 'Q'"):
        edits.parse('states.rename = { Q = "guard" }', "kicks.toml").apply(kicks)
    with pytest.raises(InputError, match=r"^kicks\.toml: No phrase at frame 9"):
        edits.parse("phrases.split = [ { frame = 9 } ]", "kicks.toml").apply_to_phrases([Phrase(0, 0, 5)])


def test_a_name_that_is_taken_is_refused(kata: MotionGraph) -> None:
    """Of states and of paths."""
    with pytest.raises(InputError, match="cannot be called 'B'"):
        _apply(kata, 'states.rename = { A = "B" }')
    with pytest.raises(InputError, match="cannot be called 'go'"):
        _apply(kata, 'paths.rename = { ab_1 = "go", bc_1 = "go" }')


def test_phrases_are_split_merged_and_named() -> None:
    """They tile what they tiled."""
    phrases = [Phrase(0, 0, 100), Phrase(0, 100, 300), Phrase(0, 300, 400), Phrase(1, 0, 50)]
    text = """
        [phrases]
        rename = [ { frame = 10, name = "warm-up" }, { frame = 10, name = "end", source = 1 } ]
        merge = [ { from = 150, to = 350 } ]
        split = [ { frame = 120 }, { frame = 300 } ]
    """
    assert edits.parse(text).apply_to_phrases(phrases) == (
        Phrase(0, 0, 100, "warm-up"),
        Phrase(0, 100, 120),
        Phrase(0, 120, 400),
        Phrase(1, 0, 50, "end"),
    )
    with pytest.raises(InputError, match=r"No phrase at frame 400 of source 0. Phrases there: \[0, 100\)"):
        edits.parse("phrases.split = [ { frame = 400 } ]").apply_to_phrases(phrases)
    with pytest.raises(InputError, match="'from' before 'to'"):
        edits.parse("phrases.merge = [ { from = 350, to = 20 } ]").apply_to_phrases(phrases)
