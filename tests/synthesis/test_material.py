"""Recordings prepared once give the very performances that they give themselves."""

from __future__ import annotations

import itertools
import json
from typing import Any

import numpy as np
import pytest

import kinesics as kx
from bodies import rounds
from kinesics.errors import InputError
from kinesics.grammar import edits
from kinesics.synthesis import goals
from kinesics.synthesis import material as materials
from kinesics.synthesis.piece import Piece


@pytest.fixture(scope="module")
def walks() -> list[kx.Motion]:
    """A straight walk and one in a circle to the left."""
    return [
        kx.performer.walk(seconds=8, fps=30).motion.replace(name="straight"),
        kx.performer.walk(seconds=16, fps=30, route="circle").motion.replace(name="circle"),
    ]


@pytest.fixture(scope="module")
def material(walks: list[kx.Motion]) -> kx.Material:
    """The same, prepared."""
    return kx.prepare(walks)


def all_of(piece: Piece) -> tuple[bytes, bytes, str, str]:
    """To the last bit, with all that is told."""
    motion = piece.motion
    return (
        motion.rotations.tobytes(),
        motion.root_positions.tobytes(),
        json.dumps(piece.to_dict()),
        repr(motion.warnings),
    )


@pytest.mark.parametrize(
    "wish",
    [
        {"seconds": 4.0, "seed": 5},
        {"target": (2.0, 4.0), "seed": 3},
        {"route": [(0.0, 0.0), (0.0, 2.0), (1.0, 4.0)], "seed": 1},
        {"from_state": "A", "to_state": "A*"},
        {"from_state": "A", "seconds": 3.0},
        {"favour": "circle", "seconds": 3.0},
        {"favour": "cyclic-antiphase", "seconds": 3.0},
        {"goal": goals.Speed(1.0), "seconds": 3.0},
    ],
    ids=str,
)
def test_it_is_performed_from_as_the_recordings_are(
    walks: list[kx.Motion], material: kx.Material, wish: dict[str, Any]
) -> None:
    """Byte for byte, provenance and warnings too; and again, when something else was performed meanwhile."""
    first = all_of(kx.performance(material, **wish))
    assert first == all_of(kx.performance(walks, **wish))
    kx.perform(material, target=(1.0, 3.0), seed=9)
    assert all_of(kx.performance(material, **wish)) == first


def test_another_part_is_performed_where_it_holds_what_is_wished_for() -> None:
    """What no way leads to from the largest part is prepared when it is asked for, and kept."""
    fresh = rounds().replace(name="fresh")
    low = kx.performer.walk(seconds=6, fps=30).motion
    material = kx.prepare([fresh, low.replace(name="low")])
    for name in ("low", "fresh", "low"):
        wished = all_of(kx.performance(material, favour=name, seconds=2.0))
        assert wished == all_of(kx.performance([fresh, low.replace(name="low")], favour=name, seconds=2.0))


def test_what_shapes_the_material_is_kept(walks: list[kx.Motion]) -> None:
    """Rate, body, strands, threshold and a person's names need not be said again, and stand in the provenance."""
    known = edits.parse('[states]\nrename = { A = "left" }\n')
    how: dict[str, Any] = {"fps": 24.0, "skeleton": walks[1], "mirrored": False, "threshold": 0.01, "edits": known}
    material = kx.prepare(walks, **how)
    wish: dict[str, Any] = {"from_state": "left", "seconds": 2.0}
    assert all_of(kx.performance(material, **wish)) == all_of(kx.performance(walks, **wish, **how))
    # said again it is no contradiction
    assert kx.perform(material, **wish, **how).fps == 24.0


@pytest.mark.parametrize(
    ("other", "named"),
    [
        ({"fps": 60.0}, "`fps`"),
        ({"mirrored": False}, "`mirrored`"),
        ({"backwards": True, "threshold": 0.02}, "`backwards` and `threshold`"),
        ({"skeleton": rounds()}, "`skeleton`"),
        ({"mapping": {"head": "Head"}}, "`mapping`"),
        ({"edits": edits.parse("")}, "`edits`"),
    ],
    ids=str,
)
def test_what_it_was_prepared_for_cannot_be_contradicted(
    material: kx.Material, other: dict[str, Any], named: str
) -> None:
    """With the names of all that is, and what to do."""
    with pytest.raises(InputError, match=rf"prepared with another {named}: give .* to kx\.prepare"):
        kx.perform(material, seconds=2.0, **other)


def test_what_was_prepared_is_not_worked_out_again(material: kx.Material, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the transitions nor what may follow each path, whatever the target."""
    kx.perform(material, seconds=1.0)

    def again(*_: object, **__: object) -> object:
        raise AssertionError("worked out again")

    for name in ("repertoire", "transitions", "afoot", "prospects"):
        monkeypatch.setattr(materials, name, again)
    assert kx.perform(material, target=(0.5, 3.0)).duration > 1.0
    assert kx.perform(material, seconds=2.0, seed=4).duration == pytest.approx(2.0)


def test_what_nothing_can_be_performed_of_is_refused_when_it_is_prepared(material: kx.Material) -> None:
    """As `kinesics.perform` does; and a number out of range before anything is done."""
    for again in (material, [material]):
        with pytest.raises(InputError, match="prepared already"):
            kx.prepare(again)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="Expected motions"):
        kx.prepare("walk.bvh")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="threshold"):
        kx.prepare([], threshold=-1.0)
    with pytest.raises(InputError, match="mirrored"):
        kx.prepare([], mirrored="yes")  # type: ignore[arg-type]


def test_preparing_reports_rising_shares(walks: list[kx.Motion]) -> None:
    """From 0 to 1, in words."""
    shares: list[float] = []
    words: list[str] = []

    def progress(fraction: float, message: str = "") -> None:
        shares.append(fraction)
        words.append(message)

    material = kx.prepare(walks, progress=progress)
    assert shares[0] == 0.0
    assert shares[-1] == 1.0
    assert shares == sorted(shares)
    assert "looking ahead" in words
    assert repr(material) == "Material(2 recordings, 24.0 s)"


def test_an_avatar_is_told_meanwhile_where_to_go(material: kx.Material) -> None:
    """It comes to the one place, and then to the other; what it performed is a motion of the recordings' skeleton."""
    avatar = kx.Avatar(material, target=(1.0, 3.0), seed=1)
    frames = []
    for place in ((1.0, 3.0), (-1.0, 5.0)):
        avatar.pursue(target=place)
        assert not avatar.attained
        while not avatar.attained and len(frames) < 60 * avatar.fps:
            frames.append(next(avatar))
        assert avatar.attained
        assert "reached" in avatar.outcome[0]
    # the decision is made a third of a second ahead of what is shown
    frames += itertools.islice(avatar, round(0.5 * avatar.fps))
    motion = avatar.motion(frames)
    assert motion.skeleton is avatar.skeleton
    trail = motion.root_positions[:, [0, 2]]
    for place in ((1.0, 3.0), (-1.0, 5.0)):
        assert np.hypot(*(trail - place).T).min() < 0.75


def test_an_avatar_begins_where_it_is_said(material: kx.Material) -> None:
    """In a place, facing aside; or in a state, by the grammar's name."""
    avatar = kx.Avatar(material, start=(4.0, -2.0), heading=1.0)
    frames = list(itertools.islice(avatar, 3))
    assert np.hypot(frames[0].root[0] - 4.0, frames[0].root[2] + 2.0) < 0.1
    assert abs(float(kx.poses(avatar.motion(frames)).yaw[0]) - 1.0) < 0.1
    begun = kx.Avatar(material, from_state="A")
    assert begun.network.state_from[next(begun).path] == "A"


def test_what_an_avatar_cannot_pursue_is_refused_in_words(material: kx.Material, walks: list[kx.Motion]) -> None:
    """And it goes on with what it was wished before; recordings may be given themselves."""
    avatar = kx.Avatar(walks, target=(0.0, 3.0))
    before = next(avatar)
    with pytest.raises(InputError, match="one thing to go for"):
        avatar.pursue(target=(1.0, 1.0), route=[(0.0, 0.0), (0.0, 1.0)])
    with pytest.raises(InputError, match="kneeling"):
        avatar.pursue(favour="kneeling")
    after = next(avatar)
    assert after.moment != before.moment
    with pytest.raises(InputError, match="bend"):
        kx.Avatar(material, bend=-1.0)
