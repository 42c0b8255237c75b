"""What is doubtful of a performance is told in its warnings, with what was measured, what it may be, and what helps."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import kinesics as kx
from kinesics.synthesis import unused
from kinesics.synthesis.doubts import doubts
from kinesics.synthesis.embodiment import checking
from kinesics.synthesis.embodiment.checking import Check, Slid
from kinesics.synthesis.paths.prospects import prospects
from kinesics.synthesis.piece import Piece, way_of
from kinesics.synthesis.wish import Wish

SOUND = Check(20, 0, 0.006, 0.004, 0.0, 0.001, 0.003, 0.01)


@pytest.fixture(scope="module")
def walk() -> kx.Motion:
    """Eight seconds in a circle."""
    return kx.performer.walk(seconds=8, fps=30, route="circle").motion


@pytest.fixture(scope="module")
def piece(walk: kx.Motion) -> Piece:
    """Ten seconds of it."""
    return kx.performance(walk, seconds=10)


def told(piece: Piece, **changed: Any) -> tuple[str, ...]:
    """Of a piece in which this was measured."""
    wish = Wish.of(None, None, None, None, None, None)
    checked = dataclasses.replace(piece, check=SOUND._replace(**changed))
    return doubts(checked, wish, prospects(piece.network), 10.0, 10.0)


def slid(frame: int, metres: float = 0.05) -> dict[str, Any]:
    """What is measured where the left foot slides for six frames from this one on."""
    return {"slides": 1, "slide": metres, "slid": (Slid("left", frame, frame + 6, metres),)}


def test_what_holds_is_not_doubted(piece: Piece) -> None:
    """Nothing is said of slides and the like where all is as it may be, just as it may be included."""
    assert told(piece) == ()
    assert told(piece, below_floor=checking.SUNK, distance=0.01) == ()


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"below_floor": 0.023}, "2.3 cm below the floor (1 cm"),
        ({"beyond_range": 0.1}, "5.7° beyond its range"),
        ({"deeper": 0.0121}, "12.1 mm deeper in each other than in the recordings (3 mm"),
        ({"distance": 0.02}, "by D 0.02, than transitions may be (0.01)"),
    ],
)
def test_what_does_not_stay_is_told_beside_what_it_may_be(piece: Piece, changed: dict[str, Any], says: str) -> None:
    """What failed, by how much, against which line, and what helps."""
    (doubt,) = told(piece, **changed)
    assert says in doubt
    assert "--seed" in doubt


def test_feet_that_slide_are_told_with_when_and_what_helps(piece: Piece) -> None:
    """Beside a transition another seed; far from all of them none, for it lies in the recordings."""
    cuts = piece.performance.cuts
    far = next(f for f in range(piece.motion.frame_count - 6) if abs(cuts - f - 3).min() > 20)
    (doubt,) = told(piece, **slid(int(cuts[0])))
    at = cuts[0] / 30
    assert f"more than 1 cm in 1 of 20 contacts, the left one by 5.0 cm from {at:.1f} to {at + 0.2:.1f} s" in doubt
    assert "--seed" in doubt
    assert "lies in the recordings" not in doubt
    (doubt,) = told(piece, **slid(far))
    assert "no transition is near" in doubt
    assert "--seed" not in doubt


def test_feet_that_stand_through_transitions_are_asked_where_they_slide(piece: Piece) -> None:
    """In a contact that lasts all the time another seed helps only where the sliding is beside a transition."""
    motion, cuts = piece.motion, piece.performance.cuts
    count = motion.frame_count
    far = next(f for f in range(count - 6) if abs(cuts - f - 3).min() > 20)
    for frame, seed in ((int(cuts[0]), True), (far, False)):
        roots = np.repeat(motion.root_positions[:1], count, axis=0)
        roots[frame:, 2] += 0.05
        still = motion.replace(rotations=np.repeat(motion.rotations[:1], count, axis=0), root_positions=roots)
        stands = dataclasses.replace(piece, performance=dataclasses.replace(piece.performance, motion=still))
        (doubt,) = [
            line
            for line in told(stands, slides=1, slide=0.05, slid=(Slid("left", 0, count, 0.05),))
            if line.startswith("feet slide")
        ]
        assert ("--seed" in doubt) == seed
        assert ("no transition is near" in doubt) != seed


def test_a_failed_check_is_among_the_warnings_and_made_once(walk: kx.Motion, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the motion, in the provenance; whatever is asked of the piece afterwards, and however many ways were tried."""
    made = []

    def failed(*what: Any) -> Check:
        made.append(what)
        return SOUND._replace(**slid(3, 0.12))

    monkeypatch.setattr(checking, "check", failed)
    piece = kx.performance(walk, target=(0.0, -2.0), seconds=8)
    facts = piece.to_dict()
    assert len(made) == 1
    (doubt,) = [line for line in piece.motion.warnings if "the left one by 12.0 cm" in line]
    assert doubt in facts["output"]["warnings"]
    assert facts["check"]["slid"] == [{"foot": "left", "start": 3, "end": 9, "slide_m": 0.12}]
    assert not facts["check"]["holds"]


def test_the_contacts_that_slide_are_those_that_are_counted(piece: Piece) -> None:
    """Of a body dragged over the floor: each with its foot and frames, the worst among them."""
    motion = piece.motion
    drift = (motion.root_positions[:, :1] * 0.0 + 0.004).cumsum(axis=0) * [1.0, 0.0, 0.0]
    dragged = dataclasses.replace(
        piece.performance, motion=motion.replace(root_positions=motion.root_positions + drift)
    )
    found = checking.check(dragged, piece.network)
    assert 0 < found.slides == len(found.slid) <= found.contacts
    assert max(one.slide for one in found.slid) == found.slide
    assert all(one.slide > checking.SLIDE and one.start < one.end <= motion.frame_count for one in found.slid)
    assert [one.start for one in found.slid] == sorted(one.start for one in found.slid)


def test_a_way_too_short_to_be_seen_is_told(walk: kx.Motion) -> None:
    """How long the way itself lasts, whatever is performed before and after it; and how to go on where that is nothing."""
    piece = kx.performance(walk, from_state="A", to_state="A*")
    assert not any("lasts" in line for line in piece.motion.warnings)
    quick = dataclasses.replace(piece.network, duration=0.1 * piece.network.duration)
    wish = Wish.of(None, None, "A", "A*", None, None)
    for frames, says in ((4, "--linger"), (60, "of 2.0: the recordings pass so quickly")):
        short = dataclasses.replace(
            piece,
            network=quick,
            performance=dataclasses.replace(
                piece.performance, motion=piece.motion.resample(120)[:frames].replace(fps=30)
            ),
            check=SOUND,
        )
        (doubt,) = (line for line in doubts(short, wish, prospects(piece.network), 10.0, None) if "lasts" in line)
        assert "the way from A to A* lasts 0.0" in doubt
        assert says in doubt


def test_recordings_of_which_most_is_not_used_are_told(walk: kx.Motion) -> None:
    """How much is, of which; and that no larger threshold helps, where none does."""
    jacks, squats = kx.performer.jumping_jacks(seconds=7, fps=30).motion, kx.performer.squat(seconds=7, fps=30).motion
    piece = kx.performance([walk, jacks, squats], seconds=2)
    (doubt,) = (line for line in piece.motion.warnings if "most of what was recorded" in line)
    each = unused.used_of_each(piece.network)
    assert [one.name for one in each] == ["jumping_jacks", "squat", "walk"]
    assert unused.used(piece.network).unused == pytest.approx(1.0 - sum(o.seconds.used for o in each) / 22.0, abs=0.01)
    assert (
        f"of 'jumping_jacks' 0.0 of 7.0 s, of 'squat' 0.0 of 7.0 s, of 'walk' {each[2].seconds.used:.1f} of 8.0 s"
        in doubt
    )
    assert "No larger `threshold` joins much more" in doubt
    assert not any("most of what" in line for line in kx.performance([walk, jacks], seconds=2).motion.warnings)


def test_who_stays_although_the_recordings_go_about_is_told(piece: Piece) -> None:
    """In place, or as still as a statue; not who was asked to, nor who goes about."""
    motion = piece.motion
    root = np.array(motion.root_positions)
    root[:, [0, 2]] = 0.02 * np.sin(np.arange(len(root)))[:, None]
    there = motion.replace(root_positions=root)
    statue = there.replace(rotations=np.repeat(there.rotations[:1], len(root), axis=0))
    for still, says in (
        (there, "stays in place for all of 10.0 s, within 3 cm"),
        (statue, "nearly still for all of 10.0 s"),
    ):
        staying = dataclasses.replace(piece, performance=dataclasses.replace(piece.performance, motion=still))
        (doubt,) = told(staying)
        assert says in doubt
        assert "--target" in doubt
        checked = dataclasses.replace(staying, check=SOUND)
        ahead = prospects(piece.network)
        for asked in (Wish.of(None, None, None, None, "walk", None), Wish.of(None, None, "A", "A*", None, None)):
            assert not any("body st" in line for line in doubts(checked, asked, ahead, 10.0, 10.0))
    assert told(piece) == ()


def test_a_long_way_round_is_told(walk: kx.Motion) -> None:
    """How long, how long straight on, and what shortens it; not a word of it where the way is short."""
    piece = kx.performance(walk, target=(0.0, 4.0), seconds=40)
    assert piece.attained
    wish = Wish.of((0.0, 4.0), None, None, None, None, None)
    motion, frames = piece.motion, piece.motion.frame_count
    way = np.zeros((frames, 3))
    way[:, 1] = motion.root_positions[:, 1]
    for metres, said in ((4.5, 0), (14.0, 1)):
        # straight on past the place and back to it, or to it at once
        along = np.linspace(0.0, metres, frames)
        way[:, 2] = np.where(along > 9.0, 18.0 - along, along) if said else along
        way[:, 0] = np.where(along < 8.9, 0.6, 0.0) * said
        there = dataclasses.replace(
            piece,
            check=SOUND,
            performance=dataclasses.replace(piece.performance, motion=motion.replace(root_positions=way)),
        )
        told_ = [line for line in doubts(there, wish, prospects(piece.network), 40.0, 40.0) if "long way round" in line]
        assert len(told_) == said
        assert all("instead of 4.0 m straight on" in line and "--bend" in line for line in told_)


def test_the_way_is_measured_without_the_sway() -> None:
    """Straight on and round as long as it is, to and fro next to nothing; of one frame, none."""
    times = np.linspace(0.0, 10.0, 301)
    straight = np.stack([0.0 * times, 1.3 * times], axis=1)
    assert way_of(straight, 30.0) == pytest.approx(13.0)
    assert way_of(straight + 0.05 * np.stack([np.sin(2 * np.pi * times), 0.0 * times], axis=1), 30.0) == pytest.approx(
        13.0, rel=0.01
    )
    circle = 2.0 * np.stack([np.sin(times), np.cos(times)], axis=1)
    assert way_of(circle, 30.0) == pytest.approx(20.0, rel=0.05)
    assert way_of(straight[:2], 30.0) == pytest.approx(1.3 / 30.0)
    assert way_of(straight[:1], 30.0) == 0.0


def test_what_is_performed_mirrored_or_backwards_alone_is_used(walk: kx.Motion) -> None:
    """Whatever strand a frame is played in: with mirror images and backward ones no less of it is used than without."""
    shares = [
        unused.used(kx.performance(walk, seconds=1, backwards=backwards).network).unused for backwards in (False, True)
    ]
    assert 0.0 <= shares[1] <= shares[0] < 0.2


def test_who_is_there_already_is_told(walk: kx.Motion) -> None:
    """Of a target about the start, unless one is to linger there; of no other."""
    for wish, said in (
        ({"target": (0.2, 0.0)}, 1),
        ({"target": (0.2, 0.0), "linger": True}, 0),
        ({"target": (0.0, 2.0)}, 0),
    ):
        piece = kx.performance(walk, seconds=4, **wish)  # type: ignore[arg-type]
        assert sum("one is there at once" in line for line in piece.motion.warnings) == said


def test_a_route_that_the_body_was_far_from_is_told(piece: Piece) -> None:
    """With how far in the median and at the worst, and what helps; a way to where the route begins is none of it."""

    def said(points: list[tuple[float, float]], bend: float = 5.0) -> list[str]:
        wish = Wish.of(None, points, None, None, None, None)
        parameters = {**piece.parameters, "route": [list(p) for p in points], "bend_used": bend}
        course = dataclasses.replace(piece.course, attained=True)
        made = dataclasses.replace(piece, check=SOUND, parameters=parameters, course=course)
        lines = doubts(made, wish, prospects(piece.network), 10.0, 10.0)
        return [line for line in lines if "beside the route" in line]

    trail = [tuple(place) for place in piece.trail[::5].tolist()]
    assert said(trail) == []
    assert said(trail[len(trail) // 4 :]) == said([trail[0], *trail[len(trail) // 4 :]])
    straight = [(0.0, 0.0), (0.0, 12.0)]
    away = np.abs(piece.trail[:, 0])
    behind = np.where(piece.trail[:, 1] < 0.0, np.hypot(*piece.trail.T), away)
    (line,) = said(straight)
    assert f"{np.median(behind):.2f} m beside the route in the median, {behind.max():.1f} m at the worst" in line
    assert "--bend 10" in line
    (line,) = said(straight, bend=20.0)
    assert "--bend" not in line
    assert "another seed" in line


def test_a_single_pose_is_told_to_be_one(walk: kx.Motion) -> None:
    """There is no time to stand still in: what is told is that there is none, and how much there was."""
    (told,) = kx.perform(walk, seconds=0.01).warnings
    assert told == "a single pose, in which nothing moves: 0.01 s (--seconds) at 30 frames a second; give more"
    assert not any("stands" in line or "pose" in line for line in kx.perform(walk, seconds=0.2).warnings)
