"""From recordings to a new movement in one call, and what is told of how it came about."""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import jsonschema
import numpy as np
import pytest

import kinesics as kx
from bodies import rounds
from kinesics.errors import InputError
from kinesics.formats import read_extras
from kinesics.grammar import edits
from kinesics.report.performances import performance_schema
from kinesics.synthesis import attempts, goals
from kinesics.synthesis.control.courses import Course, perform_paths
from kinesics.synthesis.embodiment.rendering import Performance, render
from kinesics.synthesis.paths.labels import labelled
from kinesics.synthesis.paths.network import Network, network
from kinesics.synthesis.paths.prospects import prospects
from kinesics.synthesis.piece import Piece, SourceFacts
from kinesics.synthesis.repertoire import repertoire
from kinesics.synthesis.wish import Grammar, Wish, check_names


class Told(NamedTuple):
    """What the network asks of a phrase."""

    start: int
    end: int
    kind: int | None
    class_: str | None = None
    name: str | None = None
    source: int = 0


@pytest.fixture(scope="module")
def walks() -> list[kx.Motion]:
    """A straight walk and one in a circle to the left."""
    return [
        kx.performer.walk(seconds=8, fps=30).motion.replace(name="straight"),
        kx.performer.walk(seconds=16, fps=30, route="circle").motion.replace(name="circle"),
    ]


@pytest.fixture(scope="module")
def piece(walks: list[kx.Motion]) -> Piece:
    """A walk to a target."""
    return kx.performance(walks, target=(2.0, 4.0), seed=3)


def test_perform_is_a_motion_that_comes_to_the_target(walks: list[kx.Motion]) -> None:
    """The public call: target is x, z in metres from where it starts."""
    new = kx.perform(walks, target=(3.0, 2.0), seconds=20, seed=1)
    assert isinstance(new, kx.Motion)
    assert new.fps == 30
    assert new.duration <= 20
    ground = new.root_positions[:, [0, 2]]
    assert np.abs(ground[0]).max() < 1e-9
    assert np.hypot(*(ground - [3.0, 2.0]).T).min() <= 0.5
    assert new.warnings == ()


def test_it_starts_facing_ahead(walks: list[kx.Motion]) -> None:
    """Heading 0 at the first frame, wherever it was recorded."""
    first = kx.poses(kx.perform(walks, seconds=2, seed=5)[0])
    assert abs(float(first.yaw[0])) < 0.1


def test_what_nothing_can_be_performed_of_is_left_out_where_others_are(walks: list[kx.Motion]) -> None:
    """Single poses and too few frames a second, first or last: a warning each, and the same movement as without."""
    pose, slow = walks[1][3].replace(name="pose"), walks[0].resample(5).replace(name="slow")
    alone = kx.perform(walks, seconds=2)
    new = kx.perform([pose, *walks, slow], seconds=2)
    assert np.array_equal(new.rotations, alone.rotations)
    assert [line.partition(":")[0] for line in new.warnings] == ["pose is left out", "slow is left out"]
    assert not alone.warnings
    with pytest.raises(InputError, match="single pose"):
        kx.perform([pose, pose.replace(name="other")], seconds=2)


def test_the_same_seed_gives_the_same_movement(walks: list[kx.Motion]) -> None:
    """To the last bit; another seed another."""
    first, again, other = (kx.perform(walks, seconds=4, seed=seed) for seed in (7, 7, 8))
    assert np.array_equal(first.rotations, again.rotations)
    assert np.array_equal(first.root_positions, again.root_positions)
    assert first.root_positions.shape != other.root_positions.shape or not np.array_equal(
        first.root_positions, other.root_positions
    )


def test_one_motion_alone_will_do(walks: list[kx.Motion]) -> None:
    """Not in a list; without a goal exactly as long as asked for."""
    assert kx.perform(walks[0], seconds=3.0).frame_count == 90


def test_without_a_goal_little_is_repeated(walks: list[kx.Motion]) -> None:
    """On and on: far more of the recordings is used than in as long a stretch of the straight walk's two steps."""
    new = kx.performance(walks, seconds=12, seed=2)
    assert np.bincount(new.course.paths).max() <= 2
    assert len(np.unique(new.provenance.moment)) > 0.7 * new.motion.frame_count


def test_what_was_chosen_is_stated(walks: list[kx.Motion]) -> None:
    """Skeleton, rate, threshold, what was pruned, seed and version."""
    said = " | ".join(kx.perform(walks, seconds=2, seed=4, fps=25).assumptions)
    for words in (
        "performed at 25 frames a second",
        "performed on the skeleton of straight",
        "circle: resampled from 30 to 25",
        "transitions up to a mean D of",
        "not used: straight",
        "seed 4",
        kx.__version__,
    ):
        assert words in said


def test_spans_tile_the_performance_and_name_the_source_frames(piece: Piece) -> None:
    """Every frame away from transitions has the very pose of the source frame named, mirrored where it says so."""
    bounds = [(s.start, s.end) for s in piece.spans]
    assert bounds[0][0] == 0
    assert bounds[-1][1] == piece.motion.frame_count
    assert all(a[1] == b[0] for a, b in itertools.pairwise(bounds))
    new = kx.poses(piece.motion)
    for span in piece.spans:
        steady = [k for k in range(span.start, span.end) if piece.provenance.weight[k] == 1.0]
        assert span.source_end - span.source_start == pytest.approx(span.end - span.start)
        for k in steady:
            source = round(span.source_start) + k - span.start
            assert piece.provenance.source_frame[k] == source
        if steady:
            mirrored = bool(piece.provenance.mirrored[steady[0]])
            assert mirrored == span.mirrored
    d = (kx.distance, kx.mirror_distance)
    walks = [
        kx.performer.walk(seconds=8, fps=30).motion,
        kx.performer.walk(seconds=16, fps=30, route="circle").motion,
    ]
    shown = 0
    for span in piece.spans:
        for k in range(span.start, span.end):
            if piece.provenance.weight[k] < 1.0:
                continue
            source = kx.poses(walks[span.source])[int(piece.provenance.source_frame[k])]
            # legs are moved a little so that the feet stay where they are
            assert float(d[span.mirrored](new[k : k + 1], source)[0, 0]) < piece.network.threshold
            shown += 1
    assert shown > 10


def test_crossings_are_transitions_of_the_network(piece: Piece) -> None:
    """One at every seam, none above the threshold; those that mirror change the strand."""
    assert [c.frame for c in piece.crossings] == [s.start for s in piece.spans[1:]]
    assert all(0.0 < c.distance <= piece.network.threshold for c in piece.crossings)
    for (before, after), crossing in zip(itertools.pairwise(piece.spans), piece.crossings, strict=True):
        assert crossing.mirrors == (before.mirrored != after.mirrored)
        assert (crossing.from_source, crossing.to_source) == (before.source, after.source)


def test_the_facts_satisfy_their_schema(piece: Piece, walks: list[kx.Motion]) -> None:
    """Of a target, of a route, of nothing."""
    jsonschema.Draft202012Validator.check_schema(performance_schema())
    for made in (piece, kx.performance(walks, route=[(0, 0), (1, 4)], seconds=6), kx.performance(walks, seconds=1)):
        jsonschema.validate(made.to_dict(), performance_schema())
    facts = piece.to_dict()
    assert facts["goal"]["nearest_m"] <= 0.5
    assert facts["sources"][1]["name"] == "circle"
    assert facts["parameters"]["seed"] == 3


def test_a_route_is_followed(walks: list[kx.Motion]) -> None:
    """To its end, and not far beside it."""
    made = kx.performance(walks, route=[(0, 0), (0, 3), (1, 6), (3, 8)], seed=1)
    assert made.attained
    assert made.aside is not None
    assert made.aside < 0.3
    assert np.hypot(*(made.trail[-1] - [3, 8])) < 1.0


def test_from_state_to_state_begins_and_ends_there(walks: list[kx.Motion]) -> None:
    """The words of `kx.graph`: from a moment at which the one is passed to a moment at which the other is, mirrored or not."""
    made = kx.performance(walks[0], from_state="A", to_state="A*")
    assert made.attained
    graph = kx.graph(walks[0]).racemic()
    passed: dict[str, set[int]] = {"A": set(), "A*": set()}
    for step in graph.timeline(0):
        assert step.path is not None
        path = graph.path(step.path)
        ends = (path.from_, path.to) if not step.reversed else (path.to, path.from_)
        if step.start > 0:
            passed[graph.state(ends[0]).label].add(step.start)
        if step.complete:
            passed[graph.state(ends[1]).label].add(step.end)
    image = {"A": "A*", "A*": "A"}
    said = re.search(r"from (\d+\.\d\d) to (\d+\.\d\d) s, between what leads there and what follows", *made.outcome)
    assert said is not None, "this way takes half a second"
    begin, end = (round(float(second) * made.motion.fps) for second in said.groups())
    assert 1.0 < float(said[1]) < 2.1
    assert 1.0 < made.motion.duration - float(said[2]) < 2.1
    where = made.provenance
    assert where.source_frame[begin] in passed[image["A"] if where.mirrored[begin] else "A"]
    assert where.source_frame[end - 1] + 1 in passed[image["A*"] if where.mirrored[end - 1] else "A*"]
    assert kx.performance(walks[0], from_state="A", seconds=2).spans[0].source_start in passed["A"] | passed["A*"]


def test_a_state_that_there_is_no_time_for_is_not_come_to(walks: list[kx.Motion]) -> None:
    """What is told is what was performed, cut short or not; and how many seconds it takes, in which it is then done."""
    short = kx.performance(walks[0], from_state="A", to_state="A*", seconds=0.2)
    assert short.motion.frame_count == 6
    assert not short.attained
    found = re.fullmatch(r"did not come from A to A\*, to which the quickest way takes (\d\.\d\d) s", *short.outcome)
    assert found is not None
    assert short.motion.warnings == (f"{short.outcome[0]}: give more seconds",)
    enough = kx.performance(walks[0], from_state="A", to_state="A*", seconds=float(found[1]))
    assert enough.attained
    assert enough.motion.warnings == ()
    assert enough.outcome[0].startswith("A to A* in ")


def test_a_place_counts_from_its_edge_on() -> None:
    """Two metres and a half in a straight line lead to half a metre from a place three metres off."""
    wish = Wish.of((0.0, 3.0), None, None, None, None, None)
    assert wish.least_metres == 2.5
    assert wish.may_try_again(2.0, 1.25)
    assert not wish.may_try_again(1.9, 1.25)
    assert Wish.of((0.0, 3.0), None, None, None, None, None, radius=0.2).least_metres == pytest.approx(2.8)
    both = Wish.of(None, None, None, None, None, goals.Targets([(0.0, 3.0), (4.0, 3.0)], radius=0.2))
    assert both.least_metres == pytest.approx(6.4)
    assert Wish.of((0.0, 0.1), None, None, None, None, None).least_metres == 0.0


def test_a_way_to_a_place_has_few_transitions() -> None:
    """Of ways about as quick the one with fewer is taken: clearly fewer in all, and hardly later."""
    # no two rounds quite alike, as of people: whoever goes over pays for it
    circling = kx.performer.walk(seconds=12, fps=60, noise_degrees=0.5, noise_kind="smooth", route="circle", seed=1)
    net = network(repertoire(circling.motion))
    ahead = prospects(net)
    wish = Wish.of((1.0, 5.0), None, None, None, None, None)
    only = [g for g in wish.goals() if isinstance(g, goals.Target)]
    seams, seconds = [0, 0], np.zeros((2, 12))
    for seed in range(12):
        for k, goal in enumerate((wish.goals(), only)):
            course = perform_paths(net, goal, 20.0, seed, finish=True, prepared=ahead)
            assert course.attained
            seams[k] += int((net.first[course.paths[1:]] != net.onward[course.paths[:-1]]).sum())
            seconds[k, seed] = course.seconds
    assert seams[0] < 0.85 * seams[1]
    # of a dozen one may be drawn that passes by and comes round again
    assert np.median(seconds[0]) < 1.05 * np.median(seconds[1])


def test_how_near_counts_as_there_can_be_said(walks: list[kx.Motion]) -> None:
    """Nearer than half a metre, and told in the facts."""
    made = kx.performance(walks, target=(1.0, 4.0), radius=0.25, seed=1)
    assert made.attained
    assert made.nearest is not None
    assert made.nearest <= 0.25
    facts = made.to_dict()
    jsonschema.validate(facts, performance_schema())
    assert facts["parameters"]["radius"] == 0.25


def test_a_recording_is_favoured(walks: list[kx.Motion]) -> None:
    """By its name, without reading the grammar; more than half of it then comes from there."""
    for number, name in enumerate(("straight", "circle")):
        made = kx.performance(walks, favour=name, seconds=10)
        assert (made.provenance.recording == number).mean() > 0.5


@pytest.mark.parametrize("word", ["walk", "Slow Walk", "walk_in_a_circle.bvh"])
def test_a_word_favours_the_recordings_that_have_it_in_their_names(walks: list[kx.Motion], word: str) -> None:
    """As a person names them, small or large, with the suffix of the file or without; what was taken is said."""
    stand = kx.performer.walk(seconds=6, fps=30, body=1.5, seed=3).motion.replace(name="sidestep")
    named = [stand, walks[1].replace(name="slow-walk_in_a_circle" if word != "walk_in_a_circle.bvh" else word[:-4])]
    made = kx.performance(named, favour=word, seconds=8)
    assert (made.provenance.recording == 1).mean() > 0.5
    assert any(line.startswith("favoured as") for line in made.motion.assumptions) == (not word.endswith("bvh"))


def test_what_a_person_named_is_favoured_and_gone_to(walks: list[kx.Motion]) -> None:
    """Names of phrases and states from a side file, and the kinds that a report counts."""
    known = edits.parse(
        "[phrases]\nsplit = [ { frame = 240 } ]\n"
        'rename = [ { frame = 100, name = "warm-up" }, { frame = 300, name = "rest" } ]'
    )
    share = {
        name: (kx.performance(walks[1], favour=name, seconds=8, edits=known).provenance.source_frame < 240).mean()
        for name in ("warm-up", "rest")
    }
    assert share["warm-up"] > 0.8
    assert share["rest"] < 0.3
    known = edits.parse('states.rename = { A = "guard" }')
    made = kx.performance(walks[0], from_state="guard", to_state="guard*", edits=known)
    assert made.attained
    with pytest.raises(kx.InputError, match=r"guard, guard\*"):
        kx.perform(walks[0], from_state="A", seconds=3, edits=known)


def test_a_kind_of_phrase_is_favoured() -> None:
    """As a report counts them: the one kind takes half of the time, the other all of it."""
    kata = kx.performer.kata(fps=30).motion
    phrases = kx.analyze(kata).phrases
    assert {p.kind for p in phrases} == {0, 1}
    share = []
    for kind in (0, 1):
        made = kx.performance(kata, favour=f"kind {kind + 1}", seconds=20)
        frames = made.provenance.source_frame
        own = [(p.start <= frames) & (frames < p.end) for p in phrases if p.kind == 0]
        share.append(np.logical_or.reduce(own).mean())
    assert share[0] > share[1] + 0.3


@pytest.mark.parametrize("word", ["jacks", "jack"])
def test_what_was_pruned_cannot_be_favoured_and_is_told_so(walks: list[kx.Motion], word: str) -> None:
    """It is there, but nothing leads to it and back: another word than "unknown". A recording can be performed from alone."""
    jacks = kx.performer.jumping_jacks(seconds=4, fps=30).motion[:20].replace(name="jacks")
    with pytest.raises(kx.InputError, match=r"Nothing can be performed of '.*', which is to be") as refused:
        kx.perform([walks[0], jacks], favour=word, seconds=3)
    assert str(refused.value).endswith("; or perform from it alone.")


@pytest.mark.parametrize("word", ["jack", "cyclic-symmetric-palindromic"])
def test_what_holds_together_by_itself_is_performed_when_it_is_favoured(walks: list[kx.Motion], word: str) -> None:
    """Though more of the walk does, and nothing leads from the one to the other: a recording, or a class."""
    jacks = kx.performer.jumping_jacks(seconds=4, fps=30).motion.replace(name="jacks")
    made = kx.performance([walks[0], jacks], favour=word, seconds=3)
    assert set(made.provenance.recording.tolist()) == {1}
    assert f"holds '{word}'" in "".join(made.motion.warnings)


def test_a_kind_that_was_pruned_is_told_so(walks: list[kx.Motion]) -> None:
    """A kind is counted in the report, whether or not it can be performed."""
    net = kx.performance(walks[1], favour="kind 1", seconds=2).network
    phrases = [Told(0, 1, 0), Told(1, 240, 1), Told(240, 480, None)]
    graph = kx.graph(walks[1])
    wish = Wish.of(None, None, None, None, "kind 1", None)
    told = labelled(net, graph, phrases)
    assert set(told.phrase) - {""} == {"kind 2"}
    with pytest.raises(kx.InputError, match="Nothing can be performed of 'kind 1'"):
        check_names(told, wish, Grammar(graph, phrases))


def test_one_word_that_is_nearly_right_is_answered_with_the_name(walks: list[kx.Motion]) -> None:
    """Also where the name has other words besides."""
    with pytest.raises(kx.InputError, match=r"Did you mean strange-walk_007\?") as refused:
        kx.perform(walks[0].replace(name="strange-walk_007"), favour="wlak", seconds=3)
    _, *lines = str(refused.value).splitlines()
    told = dict(line.strip().split(": ", 1) for line in lines)
    assert list(told) == ["recordings", "classes", "phrases", "states", "paths between states"]
    assert re.fullmatch(r"strange-walk_007 \(1\d\.\d s\)", told["recordings"])
    assert told["classes"].startswith("cyclic-antiphase (cyclic, left and right in turn: 1")
    assert told["phrases"].startswith("kind 1 (cyclic-antiphase: 1")
    assert "A* (on the way there: " in told["states"]
    assert "(A to A*: " in told["paths between states"]


def test_what_is_given_twice_is_used_once(walks: list[kx.Motion]) -> None:
    """The same recording, or a copy under another name: one source, and said."""
    copy = walks[0].replace(name="copy")
    made = kx.performance([walks[0], copy, walks[1], walks[0]], seconds=3)
    assert [s.name for s in made.sources] == ["straight", "circle"]
    said = made.motion.assumptions
    assert "copy holds the very movement of straight: used once, as straight" in said
    assert "straight was given more than once: used once" in said
    alone = kx.perform([walks[0], walks[1]], seconds=3)
    assert np.array_equal(alone.rotations, made.motion.rotations)


def test_a_class_is_favoured() -> None:
    """The grammar's word for a kind of movement."""
    made = kx.performance(kx.performer.walk(seconds=6, fps=30).motion, favour="cyclic-antiphase", seconds=3)
    assert set(made.network.class_) >= {"cyclic-antiphase"}
    assert made.motion.duration == 3.0


def test_places_one_after_the_other_are_sought_as_long_as_one_is(walks: list[kx.Motion]) -> None:
    """The second lies inside the narrowest turn, and is come back to from farther on; judged by the movement performed."""
    made = kx.performance(walks[:1], goal=goals.Targets([(0, 3), (1.5, 3.2)]), seed=1, mirrored=False)
    assert made.attained
    first, second = made.visits
    assert 0 < first < second
    for frame, place in zip(made.visits, made.places, strict=True):
        assert np.hypot(*(made.trail[frame] - place)) <= 0.5
    assert made.outcome[0].count("reached") == 2
    assert made.parameters["bend_used"] > 5.0
    assert any("degrees a metre, for " in line for line in made.motion.assumptions)
    far = kx.performance(walks[:1], goal=goals.Targets([(0, 2), (0, 40)]), seconds=5, linger=True)
    assert not far.attained
    assert far.outcome[0].startswith("reached (0.00, 2.00) after ")
    assert "did not reach (0.00, 40.00): came within" in far.outcome[0]


def test_goals_of_ones_own(walks: list[kx.Motion]) -> None:
    """Any goal of the controller, also several."""
    made = kx.performance(walks, goal=[goals.Heading(1.5), goals.Speed(1.3)], seconds=8)
    assert abs(np.median(kx.poses(made.motion).yaw[-60:]) - 1.5) < 0.5
    assert "Heading" in made.to_dict()["parameters"]["goal"][0]
    # neither can be attained, so that nothing was missed
    assert made.motion.warnings == ()
    chased = kx.performance(walks, goal=goals.MovingTarget(lambda t: (0.0, 1.2 * t)), seconds=6)
    assert chased.outcome[0].startswith("followed the moving target")
    assert chased.motion.warnings == ()


def test_where_one_way_does_not_lead_there_another_is_tried(walks: list[kx.Motion]) -> None:
    """A target inside the narrowest circle that was walked: drawn again, bent more, and said."""
    made = [kx.performance(walks, target=(3.0, 2.0), seed=seed) for seed in range(4)]
    assert all(m.attained for m in made)
    assert all(m.nearest is not None and m.nearest <= 0.5 for m in made)
    strict = kx.performance(walks[:1], target=(0.0, -3.0), bend=0.0, seconds=8)
    assert not strict.attained
    assert strict.outcome[0].startswith("did not reach (0.00, -3.00): came within")


def test_lingering_fills_the_time(walks: list[kx.Motion]) -> None:
    """With a goal it ends when that is attained, unless it is to linger."""
    ended = kx.perform(walks, target=(0, 2), seconds=8)
    stayed = kx.perform(walks, target=(0, 2), seconds=8, linger=True)
    assert ended.duration < 6
    assert stayed.duration == pytest.approx(8)


def test_without_mirror_images_none_is_played(walks: list[kx.Motion]) -> None:
    """And backwards only on request."""
    made = kx.performance(walks, seconds=5, mirrored=False)
    assert made.mirrored_share == 0
    assert made.backwards_share == 0
    still = kx.performance(kx.performer.jumping_jacks(seconds=6, fps=30).motion, seconds=8, backwards=True, seed=1)
    assert still.backwards_share > 0


def test_the_body_can_be_chosen(walks: list[kx.Motion]) -> None:
    """The skeleton of the result."""
    body = kx.mirror(kx.performer.walk(seconds=3, fps=30, body=1.5).motion).skeleton
    new = kx.perform(walks, seconds=2, skeleton=body)
    assert np.array_equal(new.skeleton.offsets, body.offsets)


@pytest.mark.parametrize("suffix", [".bvh", ".amc", ".glb", ".npz"])
def test_every_format_gives_it_back(piece: Piece, tmp_path: Path, suffix: str) -> None:
    """Written and read: the same movement, and it can be analysed as a recording."""
    path = tmp_path / f"new{suffix}"
    kx.write(piece.motion, path, extras=piece.extras() if suffix == ".npz" else None)
    again = kx.read(path)
    assert again.frame_count == piece.motion.frame_count
    assert again.fps == pytest.approx(30)
    common = [n for n in piece.motion.skeleton.joint_names if n in again.skeleton.joint_names]
    assert len(common) >= 15
    here, there = (m.positions()[:, [m.skeleton.find(n) for n in common]] for m in (piece.motion, again))
    assert np.abs(here - there).max() < 1e-4
    if suffix == ".npz":
        assert np.array_equal(read_extras(path)["provenance_source_frame"], piece.provenance.source_frame)


def test_what_was_performed_can_be_analysed_and_performed_from(walks: list[kx.Motion]) -> None:
    """A performance is a recording like any other: a walk reads as a walk, and gives new ones."""
    new = kx.perform(walks, route=[(0, 0), (0, 8)], seed=1)
    assert kx.analyze(new).overall.class_ == "cyclic-antiphase"
    assert kx.perform([new, walks[1]], seconds=3).duration == 3.0


def test_differing_rates_and_bodies_are_brought_together() -> None:
    """A tall body at 60 frames a second and a small one at 40; said in the assumptions."""
    motions = [
        kx.performer.walk(seconds=6, fps=60, body=1.9).motion.replace(name="tall"),
        kx.performer.walk(seconds=6, fps=40, body=1.5, seed=2).motion.replace(name="small"),
    ]
    made = kx.performance(motions, seconds=6, seed=1)
    assert made.motion.fps == 60
    said = " | ".join(made.motion.assumptions)
    assert "small: resampled from 40 to 60" in said
    assert "small: places scaled" in said
    for span in made.spans:
        rate = motions[span.source].fps / 60
        assert span.source_end - span.source_start == pytest.approx((span.end - span.start) * rate, abs=1e-6)


@pytest.mark.parametrize("fps", [20.0, 40.0, 120.0])
def test_spans_hold_as_much_of_their_source_as_they_play(fps: float) -> None:
    """Forwards and backwards, of a recording with more frames a second and with fewer: in its own frames."""
    march = rounds(speed=0.0)
    rep = repertoire(march, fps=fps, mirrored=False, backwards=True)
    net = network(rep)
    rng = np.random.default_rng(4)
    paths = [int(np.flatnonzero(net.strand == 0)[0])]
    while len(paths) < 60:
        nexts = net.successors(paths[-1])
        jumps = nexts[net.first[nexts] != net.onward[paths[-1]]]
        paths.append(int(rng.choice(jumps if len(jumps) else nexts)))
    facts = SourceFacts(march.name, None, None, march.frame_count, march.fps)
    played = kx.performance(march, seconds=1.0, fps=fps, mirrored=False, backwards=True)
    made = dataclasses.replace(played, performance=render(net, paths), network=net, sources=(facts,))
    assert {span.backwards for span in made.spans} == {False, True}
    for span in made.spans:
        held = (span.end - span.start) * march.fps / fps
        if span.source_end < march.frame_count:
            assert span.source_end - span.source_start == pytest.approx(held, abs=1e-6)
        for k in (span.start, span.end - 1):
            assert span.source_start - 1e-6 <= made.provenance.source_frame[k] < span.source_end


def _standing() -> kx.Motion:
    return kx.performer.stand(fps=30).motion


@pytest.mark.parametrize(
    ("motions", "how", "says"),
    [
        (list, {}, "without recordings"),
        (lambda: [1], {}, "got int as number 1"),
        (lambda: "walk.bvh", {}, "got str: read the file first"),
        (lambda: [Path("walk.bvh")], {}, "as number 1: read the file first"),
        (_standing, {"goal": goals.Target}, r"the class Target itself: give Target\("),
        (lambda: kx.performer.walk(seconds=3, fps=30).motion[3], {}, "single pose"),
        (_standing, {}, "holds one pose"),
        (lambda: kx.performer.throw(fps=30).motion, {}, "without end"),
        (lambda: kx.performer.jumping_jacks(seconds=5, fps=30).motion, {"target": (3, 0)}, "stay in place"),
        (lambda: kx.performer.jumping_jacks(seconds=5, fps=30).motion, {"route": [(0, 0), (0, 3)]}, "no route"),
        (_standing, {"target": (3, 0), "route": [(0, 0), (1, 1)]}, "target and route"),
        (_standing, {"to_state": "A"}, "from_state"),
        (_standing, {"from_state": 3}, "name of a state in `from_state` as text, got 3"),
        (_standing, {"favour": ""}, "name of what to favour: a class, .*, got an empty one"),
        (_standing, {"favour": 7}, "as text, got 7"),
        (_standing, {"radius": 0.3}, "how near to a `target`"),
        (_standing, {"target": (0, 3), "radius": -1}, r"`radius` .* above 0, got -1"),
        (_standing, {"target": (0, 3), "radius": "near"}, r"`radius` .* above 0, got 'near'"),
        (_standing, {"target": (1e9, 0)}, "within 10000 m"),
        (_standing, {"target": 3}, "x and z"),
        (_standing, {"target": (float("nan"), 0)}, "finite"),
        (_standing, {"route": [(0, 0)]}, "at least 2"),
        (_standing, {"seconds": 0}, "seconds"),
        (_standing, {"seconds": float("nan")}, "seconds"),
        (_standing, {"seed": 1.5}, "seed"),
        (_standing, {"seed": -1}, "seed"),
        (_standing, {"fps": 0}, "fps"),
    ],
)
def test_what_cannot_be_is_refused_in_words(motions: Callable[[], Any], how: dict[str, Any], says: str) -> None:
    """Which argument or recording, what was expected."""
    with pytest.raises(kx.InputError, match=says):
        kx.perform(motions(), **how)


def test_an_unknown_state_is_answered_with_those_there_are(walks: list[kx.Motion]) -> None:
    """And a word that is nearly one with what it may have meant."""
    with pytest.raises(kx.InputError, match=r"There are: A, A\*"):
        kx.perform(walks[0], from_state="A", to_state="Q")
    with pytest.raises(kx.InputError, match="Did you mean cyclic-antiphase"):
        kx.perform(walks[0], favour="cyclic-antiphas")


def test_a_target_that_was_not_reached_is_told_with_advice(walks: list[kx.Motion]) -> None:
    """Too far for the time, if one is to go on all the same; and behind somebody who only ever went straight on."""
    far = kx.perform(walks, target=(0, 40), seconds=5, linger=True)
    assert "came within" in far.warnings[0]
    assert "give more seconds" in far.warnings[0]
    behind = kx.performance(walks[0], target=(0, -4), seconds=10, bend=0)
    assert not behind.attained
    assert "turn more" in behind.motion.warnings[0]


def test_what_cannot_be_come_to_in_time_is_refused_at_once(walks: list[kx.Motion]) -> None:
    """With the seconds that it takes at least: as many are not refused, nor a little fewer than the network's pace asks for."""
    with pytest.raises(
        kx.InputError, match=r"cannot reach the target 40\.0 m off in 5 s.*takes (\d+) s at least"
    ) as refused:
        kx.perform(walks, target=(0, 40), seconds=5)
    least = re.search(r"takes (\d+) s at least", str(refused.value))
    assert least is not None
    made = kx.performance(walks, target=(0, 40), seconds=float(least[1]) + 1.0)
    assert made.trail[-1, 1] > 25.0
    with pytest.raises(kx.InputError, match=r"come to the end of a route of 900\.0 m in 9 s"):
        kx.perform(walks, route=[(0, 0), (0, 900)], seconds=9)


def test_who_hardly_gets_about_is_not_sent_far_unasked() -> None:
    """Told beforehand, with a place that is near enough; whoever says how long is let try."""
    exercises: Any = SimpleNamespace(pace=0.1, fastest=0.5)
    far, near = (Wish.of((0.0, z), None, None, None, None, None) for z in (5.0, 1.5))
    with pytest.raises(kx.InputError, match=r"hardly get about .0\.10 metres.* nearer target, of 2\.0 m at most"):
        far.most_seconds(exercises, None)
    assert far.most_seconds(exercises, 90.0) == 90.0
    assert near.most_seconds(exercises, None) > 20.0


def test_of_ways_beside_a_route_the_nearer_is_the_better() -> None:
    """A route that ends where it begins tells nothing by how near to its end one was."""
    corners = [(0.0, 0.0), (0.0, 4.0), (4.0, 4.0), (4.0, 0.0), (0.0, 0.0)]
    wish = Wish.of(None, corners, None, None, None, None)
    line = np.concatenate([np.linspace(a, b, 50) for a, b in itertools.pairwise(np.array(corners))])
    along = 0.9 * (line - 2.0) + 2.0
    beside = line + np.array([3.0, 0.0])
    assert wish.miss(line, True) == (0.0, 0.0)
    assert wish.miss(line, False) < wish.miss(beside, True) < wish.miss(beside, False)
    assert wish.miss(along, True) < wish.miss(beside, True)


def test_a_far_target_is_reached_and_the_way_decided_for_is_gone(shared_data: Path) -> None:
    """Feet that slide in the recording take nothing away: what is decided for is where feet that are planted lead."""
    walk = kx.read(shared_data / "cmu" / "07" / "07_01.amc").resample(30.0)
    made = kx.performance(walk, target=(120, -90), seed=3)
    assert made.attained
    assert made.length < 1.1 * 150.0
    beside = np.hypot(*(made.trail - made.course.ground[: len(made.trail)]).T)
    assert beside.max() < 0.5  # over 150 m


def test_the_last_seconds_are_decided_for_anew(walks: list[kx.Motion], monkeypatch: pytest.MonkeyPatch) -> None:
    """A body that is carried off by a twentieth of its way comes to its target all the same, and goes most of the way as it
    first did.
    """
    drawn: list[Course] = []

    def carried_off(net: Network, course: Course) -> Performance:
        drawn.append(course)
        done = attempts_performed(net, course)
        roots = done.motion.root_positions
        return dataclasses.replace(done, motion=done.motion.replace(root_positions=roots + 0.05 * roots[:, [2, 1, 0]]))

    attempts_performed = attempts.performed
    monkeypatch.setattr(attempts, "performed", carried_off)
    made = kx.performance(walks, target=(2.0, 30.0), seed=1)
    assert made.attained
    assert 2 <= len(drawn) <= attempts.AIMS
    first, last = drawn[0], drawn[-1]
    same = int(np.argmin(first.moments[: len(last.moments)] == last.moments[: len(first.moments)]))
    assert 0.5 * len(first.moments) < same < len(first.moments)


def test_a_far_shorter_way_by_more_bend_is_named(walks: list[kx.Motion]) -> None:
    """Tried before it is named: with that bend it is about as long as said."""
    round_ = kx.performance(walks[0], target=(5, -2), bend=3, seconds=90)
    (doubt,) = (line for line in round_.motion.warnings if "long way round" in line)
    said = re.search(r"--bend (\d+)\) leads there in about (\d+\.\d) m", doubt)
    assert said is not None
    bent = kx.performance(walks[0], target=(5, -2), bend=float(said[1]), seconds=90)
    assert bent.attained
    assert bent.length == pytest.approx(float(said[2]), abs=1.5)
    assert 1.3 * bent.length < round_.length


def test_a_far_shorter_way_is_gone(shared_data: Path) -> None:
    """Who says nothing comes there by the shorter way, and is told why; who asks for so much bend gets no more."""
    walk = kx.read(shared_data / "cmu" / "07" / "07_01.amc").resample(30.0)
    asked = kx.performance(walk, target=(3, -3), bend=5, seconds=90)
    (doubt,) = (line for line in asked.motion.warnings if "long way round" in line)
    assert "leads there in about" in doubt
    assert asked.parameters["bend_used"] == 5.0
    free = kx.performance(walk, target=(3, -3), seconds=90)
    assert free.attained
    assert free.parameters["bend"] is None
    assert free.parameters["bend_used"] > 5.0
    assert 1.5 * free.length < asked.length
    assert any("with 5 the way is" in line for line in free.motion.assumptions)


def test_on_and_on_it_passes_seldom_and_repeats_little(shared_data: Path) -> None:
    """Where nothing is wished for: fewer transitions than novelty alone would make, and hardly a moment twice."""
    clips = [kx.read(shared_data / "cmu" / n[:2] / f"{n}.amc") for n in ("91_01", "91_34")]
    made = kx.performance(clips, seconds=30, fps=30.0, seed=1)
    restless = kx.performance(clips, seconds=30, fps=30.0, seed=1, goal=goals.Novelty())
    assert len(made.crossings) < 0.5 * len(restless.crossings)
    assert len(np.unique(made.provenance.moment)) > 0.9 * made.motion.frame_count


def test_little_to_choose_from_is_told() -> None:
    """Two seconds performed for half a minute repeat themselves, whatever is wished."""
    short = kx.performer.walk(seconds=3, fps=30).motion
    (doubt,) = kx.perform(short, seconds=30).warnings
    assert re.match(r"every moment comes about [56] times: only 5\.\d s can be performed, mirror images counted", doubt)
    assert kx.perform(short, seconds=10).warnings == ()


def test_a_recording_that_nothing_leads_to_is_named(walks: list[kx.Motion]) -> None:
    """Unconnected clips: the larger part is performed, and the other one told."""
    jacks = kx.performer.jumping_jacks(seconds=4, fps=30).motion.replace(name="jacks")
    made = kx.performance([walks[0], jacks], seconds=3)
    assert any("nothing is performed of 'jacks'" in line for line in made.motion.warnings)
    assert any(p.recording == "jacks" and p.everything for p in made.pruned)
    faster = kx.performer.jumping_jacks(seconds=4, fps=30, period=0.7).motion.replace(name="faster")
    (doubt,) = kx.perform([walks[0], jacks, faster], seconds=3).warnings
    assert "of 'jacks' 0.0 of 4.0 s, of 'faster' 0.0 of 4.0 s" in doubt
    assert "or perform from 'jacks', 'faster' alone, or favour it (--favour)" in doubt


def test_work_can_be_stopped_and_reports_rising_shares(walks: list[kx.Motion]) -> None:
    """Progress goes from 0 to 1 and never falls; what it raises comes through."""
    told: list[float] = []
    kx.perform(walks[0], seconds=1, progress=lambda share, message="": told.append(share))
    assert told[0] == 0.0
    assert told[-1] == 1.0
    assert told == sorted(told)

    def stop(share: float, message: str = "") -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        kx.perform(walks[0], seconds=1, progress=stop)


def test_real_walks_come_to_their_target(shared_data: Path) -> None:
    """CMU walks of four people, one skeleton."""
    clips = [kx.read(shared_data / "cmu" / n[:2] / f"{n}.amc") for n in ("91_01", "91_34", "07_01", "35_01")]
    made = kx.performance(clips, target=(-3.0, -2.0), fps=30.0, seed=1)
    assert made.attained
    assert made.nearest is not None
    assert made.nearest <= 0.5
    assert all(facts.sha256 for facts in made.sources)


@pytest.mark.parametrize(("names", "target"), [(["16/16_35"], (4.0, 4.0)), (["09/09_06", "16/16_35"], (4.0, 4.0))])
def test_runners_come_to_their_target_with_their_feet_in_place(
    shared_data: Path, names: list[str], target: tuple[float, float]
) -> None:
    """Feet kept in place shorten every stride of a run; the way is chosen so that the body comes there all the same."""
    runs = [kx.read(shared_data / "cmu" / f"{name}.amc") for name in names]
    made = kx.performance(runs, target=target)
    assert made.nearest is not None
    assert made.nearest <= 0.5
    assert made.attained


def test_a_target_that_no_way_leads_to_is_told_so() -> None:
    """Straight walks alone, unbent, never come to a place behind the performer: more seconds or seeds are not what helps."""
    straight = kx.performer.walk(seconds=10, fps=30).motion
    done = kx.perform(straight, target=(0.0, -4.0), mirrored=False, bend=0.0, seconds=8)
    (doubt,) = [w for w in done.warnings if "did not reach" in w]
    assert "no way there was found" in doubt


@pytest.mark.parametrize("name", ["bow", "wave"])
def test_legs_that_never_move_may_be_performed(name: str) -> None:
    """Perfectly still legs have no accelerations to be measured by."""
    still = getattr(kx.performer, name)(seconds=4).motion
    done = kx.perform(still, seconds=3)
    assert done.frame_count == 360
    assert np.isfinite(done.rotations).all()


def test_a_route_gone_beside_is_not_attained() -> None:
    """Whoever goes metres away from the line did not follow it, though the line was gone along."""
    straight = kx.performer.walk(seconds=8, fps=30).motion
    piece = kx.performance(straight, route=[(6.0, 0.0), (6.0, 3.0)], mirrored=False, bend=0.0, seconds=6)
    assert piece.aside is not None
    assert piece.aside > 1.0
    assert not piece.attained
    assert piece.motion.warnings


@pytest.mark.parametrize(("motions", "seconds"), [(None, 5), (7, 5), ("walk", "5")])
def test_what_is_no_motion_or_no_number_is_refused(motions: Any, seconds: Any) -> None:
    """One clear error, whatever is handed in."""
    walk = kx.performer.walk(seconds=4, fps=30).motion
    with pytest.raises(InputError, match=r"motions|seconds"):
        kx.perform(walk if motions == "walk" else motions, seconds=seconds)
