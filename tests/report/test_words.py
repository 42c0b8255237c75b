"""What an analysis says, in words."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinesics as kx
from kinesics.analysis import facts
from kinesics.geometry import quaternion
from kinesics.grammar.graph import MotionGraph, Occurrence, State, Stay
from kinesics.grammar.graph import Path as GraphPath
from kinesics.grammar.graph import Source as GraphSource
from kinesics.report import words
from kinesics.vocabulary import MovementClass


@pytest.fixture(scope="module")
def jacks() -> kx.Analysis:
    return kx.analyze(kx.performer.jumping_jacks(seconds=6, fps=60, seed=0).motion)


def test_every_class_has_words() -> None:
    """No class is told by its slug."""
    assert set(words.CLASSES) == {c.value for c in MovementClass}


def test_one_movement_is_told_by_its_class(jacks: kx.Analysis) -> None:
    """Class, group, period, cycles, how sure."""
    said = words.headline(jacks, 0)
    assert said.startswith("Like jumping jacks: cyclic, to and fro, left and right together (p2mm), ")
    assert "s a cycle" in said
    assert "cycles; " in said
    assert "%" in said


def test_several_phrases_are_counted_not_summed_up(jacks: kx.Analysis) -> None:
    """Of three phrases, of which two are of one kind and one is a rest."""
    whole = replace(jacks.sources[0], overall=facts.Overall(class_="asymmetric", confidence=0.9))
    phrases = (
        facts.Phrase(0, 0, 100, 0.0, 1.0, class_="symmetric", kind=0),
        facts.Phrase(0, 100, 200, 1.0, 2.0, class_="still", kind=1),
        facts.Phrase(0, 200, 300, 2.0, 3.0, class_="symmetric", kind=0),
    )
    said = words.headline(replace(jacks, sources=(whole,), phrases=phrases), 0)
    assert said == "2 phrases of 1 kind and 1 rest"


def test_what_cannot_be_told_says_why() -> None:
    """The reason, and no class."""
    judged = facts.Overall(confidence=0.0, reasons=("0.1 s is too short to tell",))
    assert words.verdict(judged) == "cannot tell: 0.1 s is too short to tell"


def test_reasons_name_classes_in_words() -> None:
    """Longer names first: a cyclic class is not taken for the one its name ends in."""
    assert words.reason("it would read as cyclic-palindromic") == "it would read as “cyclic, to and fro”"
    assert words.reason("stilling") == "stilling"


@pytest.mark.parametrize(
    ("confidence", "said"),
    [(1.0, "surely (over 99 %)"), (0.97, "surely (97 %)"), (0.83, "very likely (83 %)"), (0.5, "perhaps (50 %)")],
)
def test_nothing_is_ever_wholly_sure(confidence: float, said: str) -> None:
    """A word and a figure; never 100 %."""
    assert words.likelihood(confidence) == said


def test_refrains_are_folded() -> None:
    """What comes again and again is said once; a state is held if it is so every time."""
    assert (
        words.folded(["A", "ab→", "B", "ba→", "A", "ab→", "B", "ba→", "A", "ab→", "B", "ba→", "A"])
        == "3 × (A ab→ B ba→) A"
    )
    assert words.folded(["A", "ab→", "B…", "←ab", "A…", "ab→", "B…", "←ab", "A"]) == "2 × (A ab→ B… ←ab) A"
    assert words.folded(["A", "ab→", "B", "bc→", "C"]) == "A ab→ B bc→ C"


def _unfolded(text: str) -> list[str]:
    out: list[str] = []
    parts = text.split(" ")
    k = 0
    while k < len(parts):
        if k + 1 < len(parts) and parts[k + 1] == "×":
            end = next(j for j in range(k + 2, len(parts)) if parts[j].endswith(")"))
            inner = [p.strip("()") for p in parts[k + 2 : end + 1]]
            out += inner * int(parts[k])
            k = end + 1
        else:
            out.append(parts[k])
            k += 1
    return out


@given(st.lists(st.sampled_from("abc"), max_size=60))
def test_folding_loses_nothing(said: list[str]) -> None:
    """Unfolded again, it is what it was."""
    assert _unfolded(words.folded(said)) == (said or [""])


def test_a_limp_is_noteworthy() -> None:
    """One side that comes late in every cycle is said, and which; an even walk is not."""
    even = kx.analyze(kx.performer.walk(seconds=10, fps=60, seed=0).motion)
    assert not [s for s in words.surprises(even) if "late" in s]
    late = tuple(replace(c, phase=0.1 + 0.001 * k) for k, c in enumerate(even.cycles))
    (said,) = [s for s in words.surprises(replace(even, cycles=late)) if "late" in s]
    assert "the right side comes late by 10% of a cycle" in said


def test_strikes_and_differences_of_the_sides_are_noteworthy(jacks: kx.Analysis) -> None:
    """When, and where."""
    overall = replace(
        jacks.overall,
        bias_degrees={"humerus": 90.0, "radius": 31.2, "head": 45.0},
        bias_kept=("humerus",),
        lean_degrees={},
    )
    changed = replace(
        jacks,
        sources=(replace(jacks.sources[0], overall=overall),),
        strikes=(facts.Strike(0, 60, 1.0, 5.0),),
    )
    said = words.surprises(changed)
    assert any("forearms (31°)" in s for s in said)
    assert not any("leaning" in s for s in said)
    assert any(s.startswith("1 strike") and "1.0 s" in s for s in said)


@pytest.mark.parametrize(
    ("held", "said"),
    [
        ({"Head": 10.0}, "the head by 10° against the chest: "),
        ({"Neck": 10.0, "Head": 10.0}, "the head by 20° against the chest: "),
        ({"Spine": 10.0, "Spine1": -1.0}, "the chest by 9° against the pelvis: "),
        ({"Spine": 9.0, "Head": -12.0}, "the chest by 9° against the pelvis and the head by 12° against the chest: "),
        ({"Neck": -12.0, "Head": 12.0}, None),
        ({"Head": 5.0}, None),
        ({}, None),
    ],
)
def test_a_lean_is_told_at_its_size(held: dict[str, float], said: str | None) -> None:
    """As many degrees as the head or the chest was turned to a side; links of a neck that cancel out are no posture."""
    motion = kx.performer.walk(seconds=6, fps=30, seed=1).motion
    rotations = motion.rotations.copy()
    for name, degrees in held.items():
        joint, half = motion.skeleton.joint_names.index(name), np.deg2rad(degrees) / 2
        aside = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
        rotations[:, joint] = quaternion.multiply(rotations[:, joint], aside)
    found = kx.analyze(motion.replace(rotations=rotations))
    told = [s for s in words.surprises(found) if "leaning" in s]
    if said is None:
        assert told == []
    else:
        (sentence,) = told
        assert f"all the time, {said}" in sentence
    if "Head" in held:
        assert found.overall.bias_degrees["head"] == pytest.approx(abs(held["Head"]), abs=0.5)


@pytest.mark.parametrize(
    ("similarity", "said"), [(0.9, "0.90"), (0.9949, "0.99"), (0.99995, "0.99995"), (0.999999, "over 0.99999")]
)
def test_a_similarity_begins_with_its_zero(jacks: kx.Analysis, similarity: float, said: str) -> None:
    """A number as it is written everywhere else, and never rounded up to 1."""
    (source,) = jacks.sources
    once = replace(source, overall=replace(source.overall, period_s=None))
    members = (facts.MotifMember(0, 0, 150, False, False), facts.MotifMember(0, 180, 330, False, True))
    found = replace(jacks, sources=(once,), motifs=(facts.Motif(0, "mirror", similarity, members),))
    assert any(s.endswith(f"(similarity {said})") for s in words.surprises(found))


def test_a_half_that_mirrors_the_other_is_noteworthy() -> None:
    """The kata's second half is its first in the mirror: said with both times; a walk, which is so cycle by cycle, is not."""
    kata = kx.analyze(kx.performer.perform("kata", noise_degrees=0.2, noise_kind="smooth").motion)
    said = [s for s in words.surprises(kata) if "mirror image" in s]
    assert len(said) == 1
    second, first = (tuple(map(float, pair)) for pair in re.findall(r"([0-9.]+)-([0-9.]+) s", said[0]))
    assert second[0] - first[0] == pytest.approx(kata.sources[0].duration_s / 2, abs=1.0)
    assert second[1] - first[1] == pytest.approx(kata.sources[0].duration_s / 2, abs=1.0)
    walk = kx.analyze(kx.performer.walk(seconds=6).motion)
    assert not any("mirror image" in s for s in words.surprises(walk))


@pytest.mark.parametrize(
    ("mirrored", "backwards", "said"),
    [
        (False, False, "the same as"),
        (True, False, "the mirror image of"),
        (False, True, "the same, played backwards, as"),
        (True, True, "the mirror image, played backwards, of"),
    ],
)
def test_only_a_large_part_that_is_another_part_is_noteworthy(
    jacks: kx.Analysis, mirrored: bool, backwards: bool, said: str
) -> None:
    """As long as three tenths of the recording, apart from the other, of the same recording, and no cycle."""
    (source,) = jacks.sources
    once = replace(source, overall=replace(source.overall, period_s=None))

    def told(first: tuple[int, int], second: tuple[int, int], *, of: int = 0, whole: facts.Source = once) -> int:
        members = (facts.MotifMember(0, *first, False, False), facts.MotifMember(of, *second, backwards, mirrored))
        motif = facts.Motif(0, "any", 0.95, members)
        return sum(said in s for s in words.surprises(replace(jacks, sources=(whole,), motifs=(motif,))))

    assert source.frames == 360
    assert told((0, 150), (180, 330)) == told((180, 330), (0, 150)) == 1
    assert told((0, 108), (108, 216)) == 1
    assert told((0, 107), (107, 214)) == 0
    assert told((0, 150), (149, 330)) == 0
    assert told((0, 150), (180, 330), of=1) == 0
    assert told((0, 150), (180, 330), whole=source) == 0


def test_rest_and_lingering_are_two_things(jacks: kx.Analysis) -> None:
    """Where a graph has stays that are no rests, the line says both."""
    source = GraphSource("a", jacks.sources[0].frames, jacks.sources[0].fps)
    half = source.frames // 2
    held = MotionGraph(
        (State(0, "A", stays=(Stay(0, half, source.frames),)),),
        (GraphPath(0, "aa_1", 0, 0, 1, occurrences=(Occurrence(0, 0, half),)),),
        (source,),
    )
    assert "at rest 0% of the time (it lingers in poses of the graph, if only for a moment, 50% of" in words.stillness(
        replace(jacks, graph=held, stillness=()), 0
    )
    assert "lingers" not in words.stillness(replace(jacks, graph=MotionGraph(), stillness=()), 0)


def test_recordings_of_one_name_are_told_apart(jacks: kx.Analysis) -> None:
    """Numbered; a name that stands alone stays as it is."""
    named = [replace(jacks.sources[0], name=n) for n in ("a.bvh", "b.bvh", "a.bvh")]
    assert words.source_names(replace(jacks, sources=tuple(named))) == ("a.bvh (1)", "b.bvh", "a.bvh (2)")


def test_a_graph_is_counted(jacks: kx.Analysis) -> None:
    """States, paths, and how many are symmetric or go both ways."""
    assert words.counted(jacks.graph) == "2 states (2 symmetric), 1 path (1 both ways)"
