"""One object from any motion, with the keys of `analysis.json`."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest

import bodies
import kinesics as kx
from kinesics.analysis import Analysis
from kinesics.body import anatomy
from kinesics.errors import Cancelled, InputError
from kinesics.similarity import default_beta, symmetry_residual

KEYS = [
    "schema_version",
    "kinesics_version",
    "parameters",
    "beta",
    "sources",
    "overall",
    "phrases",
    "motifs",
    "state_repetitions",
    "stillness",
    "symmetric_states",
    "reversals",
    "strikes",
    "cycles",
    "gaps",
    "graph",
]


def test_all_keys_are_there_also_where_nothing_is_known() -> None:
    """A missing thing is null or [], never absent: one frame has no class, no phrase and no path."""
    facts = kx.analyze(bodies.legs_striding(1)).to_dict()
    assert set(KEYS) <= set(facts)
    nothing = {"class", "group", "period_s", "confidence", "runner_up", "repeats", "bias_largest_degrees"}
    assert {k for k, v in facts["overall"].items() if v is None} == nothing
    assert set(facts["overall"]["residuals"].values()) == {None}
    assert [facts[k] for k in ("phrases", "motifs", "state_repetitions", "reversals", "strikes", "cycles")] == [[]] * 6
    assert facts["graph"]["paths"] == []
    assert [s["stays"] for s in facts["graph"]["states"]] == [[{"source": 0, "start": 0, "end": 1}]]
    assert facts["graph"]["notation"] == "aa_0"


def test_the_class_of_a_walk() -> None:
    """Left and right in turn: its class, period, phrase and cycles, as JSON values."""
    motion = kx.performer.walk(seconds=6, fps=60, seed=0)
    analysis = kx.analyze(motion.motion)
    assert (analysis.overall.class_, analysis.overall.group) == ("cyclic-antiphase", "p11g")
    assert type(analysis.overall.class_) is str
    assert analysis.overall.period_s == pytest.approx(motion.truth.period_s, rel=0.02)
    assert analysis.sources[0].overall == analysis.overall
    (phrase,) = analysis.phrases
    assert (phrase.start, phrase.end, phrase.class_) == (0, analysis.sources[0].frames, "cyclic-antiphase")
    assert phrase.speed_mean == pytest.approx(analysis.speed.mean, rel=0.01)
    assert len(analysis.cycles) >= 3
    for cycle in analysis.cycles:
        assert cycle.phrase == 0
        assert 0 <= cycle.start < cycle.end <= analysis.sources[0].frames
        assert cycle.period_s == pytest.approx(motion.truth.period_s, rel=0.1)
        assert cycle.phase == pytest.approx(0.0, abs=0.05)


def test_phrases_tile_the_recording_and_cycles_lie_within_theirs() -> None:
    """One movement after another: no frame is in two phrases or in none; of two sources each has its own."""
    first = kx.performer.jumping_jacks(seconds=6, fps=60, seed=0).motion
    second = kx.performer.walk(seconds=6, fps=30, seed=1).motion
    analysis = kx.analyze([first, second])
    for number, source in enumerate(analysis.sources):
        phrases = [p for p in analysis.phrases if p.source == number]
        assert [p.start for p in phrases] == [0, *(p.end for p in phrases[:-1])]
        assert phrases[-1].end == source.frames
        assert all(p.start_s == p.start / source.fps and p.end_s == p.end / source.fps for p in phrases)
    for cycle in analysis.cycles:
        phrase = analysis.phrases[cycle.phrase]
        assert phrase.start <= cycle.start < cycle.end <= phrase.end
    assert [s.overall.class_ for s in analysis.sources] == ["cyclic-symmetric-palindromic", "cyclic-antiphase"]
    assert analysis.overall.class_ is None
    for number, source in enumerate(analysis.sources):
        steps = analysis.graph.timeline(number)
        assert (steps[0].start, steps[-1].end) == (0, source.frames)


def test_the_graph_tells_every_frame() -> None:
    """The graph of one recording accounts for all its frames, and its notation rebuilds them."""
    analysis = kx.analyze(kx.performer.jumping_jacks(seconds=6, fps=60, seed=0).motion)
    steps = analysis.graph.timeline(0)
    assert (steps[0].start, steps[-1].end) == (0, analysis.sources[0].frames)
    assert analysis.graph.rebuild(analysis.graph.notation()) == steps
    assert {s.label for s in analysis.graph.states} == {"X~", "Y~"}


def test_a_defect_is_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    """A part that fails is a defect of ours, and is not told as a property of the recording."""
    from kinesics.grammar import phrases

    def broken(_: object) -> None:
        raise IndexError("index 3 is out of bounds")

    monkeypatch.setattr(phrases, "find_phrases", broken)
    with pytest.raises(IndexError, match="out of bounds"):
        kx.analyze(kx.performer.walk(seconds=4, fps=30, seed=0).motion)


@pytest.mark.parametrize("frames", [1, 2, 5, 6, 7, 11, 20, 33])
def test_short_recordings_are_read_or_said_to_be_too_short(frames: int) -> None:
    """However short a recording is, its graph accounts for every frame, what is empty is said to be, and all of it is JSON."""
    for make in (bodies.arms_swinging, bodies.legs_striding):
        analysis = kx.analyze(make(frames))
        steps = analysis.graph.timeline(0)
        assert (steps[0].start, steps[-1].end) == (0, frames)
        assert bool(analysis.phrases) != any("too few for a grammar" in w for w in analysis.warnings)
        json.dumps(analysis.to_dict(), allow_nan=False)


@pytest.mark.parametrize("first", [True, False])
def test_one_frame_beside_a_recording_leaves_its_graph(first: bool) -> None:
    """The walk is read as it is alone, the single pose is a state without ways, and a warning says why."""
    walk = kx.performer.walk(seconds=5, fps=60, seed=0, noise_degrees=0.3).motion
    pose = kx.performer.jumping_jacks(seconds=3, fps=60, seed=0).motion[30:31].replace(name="a pose")
    analysis = kx.analyze([pose, walk] if first else [walk, pose])
    assert [w for w in analysis.warnings if w.startswith("a pose: 1 frame is too few")]
    alone = kx.graph(walk)
    assert len(analysis.graph.paths) == len(alone.paths) == 2
    assert len(analysis.graph.states) == len(alone.states) + 1
    for number, source in enumerate(analysis.sources):
        steps = analysis.graph.timeline(number)
        assert (steps[0].start, steps[-1].end) == (0, source.frames)


def test_facts_survive_json() -> None:
    """To plain JSON and back the facts are equal, floats to the last bit."""
    analysis = kx.analyze(bodies.legs_striding(file_name="a.bvh", sha256="0" * 64))
    text = json.dumps(analysis.to_dict(), allow_nan=False)
    assert Analysis.from_dict(json.loads(text)) == analysis


def test_sources_tell_the_file_and_not_the_folder() -> None:
    """Name without folders, format, frame rate, what was assumed."""
    motion = bodies.arms_swinging(120, file_name="/home/ann/secret/clip.bvh").replace(assumptions=("unit: metre",))
    (source,) = kx.analyze(motion).sources
    assert (source.name, source.format, source.fps, source.frames, source.duration_s) == (
        "clip.bvh",
        "bvh",
        60,
        120,
        2.0,
    )
    assert "unit: metre" in source.assumptions
    assert "ann" not in json.dumps(kx.analyze(motion).to_dict())


def test_curves_are_those_of_the_metric() -> None:
    """Speed √(2D)/Δt and D*(a, a), one value a frame; the summary is theirs."""
    analysis = kx.analyze(bodies.legs_striding(100))
    (poses,), (speed,), (reflected,) = analysis.poses, analysis.speed_curves, analysis.mirror_distance_curves
    np.testing.assert_allclose(reflected, symmetry_residual(poses))
    assert analysis.speed.max == speed.max()
    assert analysis.speed.max_frame is not None
    assert speed[analysis.speed.max_frame] == speed.max()
    assert analysis.speed.mean == pytest.approx(speed[1:].mean())
    assert analysis.speed.median == pytest.approx(np.median(speed[1:]), rel=0.05)


def test_beta_is_given_or_of_the_rule_and_moves_no_fact() -> None:
    """β and how it was chosen are stored; stillness and symmetry are the same under any β."""
    motion = bodies.legs_striding()
    own, given = kx.analyze(motion), kx.analyze(motion, beta=3.0)
    assert own.beta == default_beta(own.poses[0])
    assert given.beta == 3.0
    assert given.parameters["beta_rule"] != own.parameters["beta_rule"]
    assert (given.stillness, given.symmetric_states, given.speed) == (own.stillness, own.symmetric_states, own.speed)


def test_several_recordings_are_sources_of_one_analysis() -> None:
    """Frames are counted within their source; rates may differ; one β serves all."""
    a = bodies.arms_swinging(120, fps=60.0, file_name="a.bvh")
    b = bodies.legs_striding(90, fps=30.0, file_name="b.bvh")
    analysis = kx.analyze([a, b])
    assert [s.name for s in analysis.sources] == ["a.bvh", "b.bvh"]
    assert [len(c) for c in analysis.speed_curves] == [120, 90]
    assert {r.source for r in analysis.symmetric_states} == {0}
    assert analysis.speed.max_source == 1


@pytest.mark.parametrize("together", [kx.analyze, kx.graph])
def test_bodies_of_unlike_rules_are_not_compared(together: Callable[[list[kx.Motion]], object]) -> None:
    """An arm told from the chest and one told from the clavicle: both recordings are named, and what to do."""
    composed = bodies.arms_swinging(30, file_name="a.bvh")
    dropped = anatomy.understood(bodies.arms_swinging(30, file_name="b.bvh"), {"clavicle": "drop"})
    with pytest.raises(InputError, match=r"'a\.bvh' has the clavicle composed.*'b\.bvh' has it dropped"):
        together([composed, dropped])
    together([dropped, dropped])


def test_one_frame_has_no_speed() -> None:
    """Nothing is divided by nothing: all None."""
    analysis = kx.analyze(bodies.arms_swinging(1))
    assert analysis.speed.mean is analysis.speed.max is None
    assert analysis.stillness == ()


def test_warnings_of_all_sources_are_gathered() -> None:
    """Once each; of several recordings each says whose it is, and the same one of two recordings is told of both."""
    a = bodies.arms_swinging(20, file_name="a.bvh").replace(warnings=("the left hand jumps",))
    b = bodies.arms_swinging(20, file_name="b.bvh").replace(warnings=("the left hand jumps", "the feet float"))
    assert kx.analyze(b).warnings == ("the left hand jumps", "the feet float")
    both = kx.analyze([a, b])
    assert both.warnings == ("a.bvh: the left hand jumps", "b.bvh: the left hand jumps", "b.bvh: the feet float")
    assert both.sources[1].warnings == b.warnings
    assert both.to_dict()["warnings"] == list(both.warnings)
    twins = kx.analyze([a, a[:15]])
    assert twins.warnings == ("a.bvh (1): the left hand jumps", "a.bvh (2): the left hand jumps")


def test_bad_arguments_are_refused() -> None:
    """Before the work begins, with what came."""
    motion = bodies.arms_swinging(10)
    with pytest.raises(InputError, match="none"):
        kx.analyze([])
    with pytest.raises(InputError, match=r"kinesics\.read"):
        kx.analyze(["walk.bvh"])
    for beta in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(InputError, match="β"):
            kx.analyze(motion, beta=beta)
    with pytest.raises(InputError, match="weights"):
        kx.analyze(motion, weights=[1.0, 2.0])


def test_facts_of_another_version_are_refused() -> None:
    """With what to do about it; and a missing key is named."""
    facts = kx.analyze(bodies.arms_swinging(10)).to_dict()
    with pytest.raises(InputError, match="analyse the recording again"):
        Analysis.from_dict({**facts, "schema_version": 99})
    del facts["graph"]["notation"]
    with pytest.raises(InputError, match="'notation' in graph"):
        Analysis.from_dict(facts)
    with pytest.raises(InputError, match="beta"):
        Analysis.from_dict({**kx.analyze(bodies.arms_swinging(10)).to_dict(), "beta": "big"})


def test_work_can_be_stopped_and_reports_how_far_it_is() -> None:
    """Fractions never fall; an exception raised by the callback goes through."""
    seen: list[float] = []
    kx.analyze(bodies.arms_swinging(30), progress=lambda f, message="": seen.append(f))
    assert seen == sorted(seen)
    assert seen[-1] == 1.0

    def stop(fraction: float, message: str = "") -> None:
        raise Cancelled

    with pytest.raises(Cancelled):
        kx.analyze(bodies.arms_swinging(30), progress=stop)
