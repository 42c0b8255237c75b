"""What is wished for by name is performed wherever in the recordings it holds together, and it is said that the rest is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinesics as kx
from bodies import about, moving, rounds
from kinesics.body.motion import Motion
from kinesics.synthesis import goals


def bowing(seconds: float = 10.0, fps: float = 30.0) -> Motion:
    """On the spot, over and over, arms far aside: like no march."""
    t = np.arange(round(seconds * fps)) / fps
    bow = 0.5 - 0.5 * np.cos(2.0 * np.pi * 0.4 * t)
    angles = {"Spine": about(0, 0.9 * bow), "LeftArm": about(2, 1.3 - bow), "RightArm": about(2, bow - 1.3)}
    return moving(angles, fps=fps, file_name="bowing")


@pytest.fixture(scope="module")
def apart() -> list[Motion]:
    """A march, and bows that it cannot go over into."""
    return [rounds(), bowing()]


def test_the_largest_part_is_performed_where_nothing_is_asked_for(apart: list[Motion]) -> None:
    """And what is in it is asked for there."""
    for favour in (None, "rounds"):
        piece = kx.performance(apart, seconds=3.0, favour=favour)
        assert set(piece.provenance.recording.tolist()) == {0}
        assert not any(w.startswith("performed is the part") for w in piece.motion.warnings)


def test_a_recording_in_another_part_is_performed_when_it_is_favoured(apart: list[Motion]) -> None:
    """With a word that says so; by a word of its name, too."""
    for favour in ("bowing", "bow"):
        piece = kx.performance(apart, seconds=3.0, favour=favour)
        assert set(piece.provenance.recording.tolist()) == {1}
        (told,) = [w for w in piece.motion.warnings if w.startswith("performed is the part")]
        assert f"holds '{favour}'" in told
        assert f"{piece.network.seconds:.1f} s" in told


def test_a_state_in_another_part_is_begun_in(apart: list[Motion]) -> None:
    """Of the states of both some are the march's and others the bows'."""
    played: set[int] = set()
    for state in kx.graph(apart).racemic().states:
        piece = kx.performance(apart, seconds=1.0, from_state=state.label)
        played |= set(piece.provenance.recording.tolist())
    assert played == {0, 1}


def test_what_is_nowhere_is_refused_as_before(apart: list[Motion]) -> None:
    """Both a name that there is none of and one of which nothing holds together."""
    with pytest.raises(kx.InputError, match="recording 'kneeling'"):
        kx.performance(apart, seconds=3.0, favour="kneeling")
    brief = bowing(0.8).replace(name="brief")
    with pytest.raises(kx.InputError, match="Nothing can be performed of 'brief'"):
        kx.performance([apart[0], brief], seconds=3.0, favour="brief", mirrored=False)


@pytest.mark.parametrize(
    ("recording", "begin", "end"), [("135_11", "A", "B"), ("86_01", "A", "B"), ("86_01", "A", "B*")]
)
def test_a_way_that_nothing_leads_back_from_is_performed(
    shared_data: Path, recording: str, begin: str, end: str
) -> None:
    """As the recording itself goes it, with what leads there and what follows; and that no more is performed is told."""
    source = kx.read(shared_data / "cmu" / recording.split("_")[0] / f"{recording}.amc")
    piece = kx.performance(source.resample(60.0), from_state=begin, to_state=end)
    assert piece.attained
    assert piece.outcome[0].startswith(f"{begin} to {end} in ")
    assert begin in piece.network.state_from
    assert end in piece.network.state_to
    (told,) = [w for w in piece.motion.warnings if w.startswith("performed is what lies on ways")]
    assert f"from '{begin}' to '{end}', or just before or after, {piece.network.seconds:.1f} s" in told
    assert "linger" not in told


def test_no_time_is_left_to_go_on_in_where_a_way_ends(shared_data: Path) -> None:
    """Nothing is asked of what follows a way that ends; so that it ends there, and that is told."""
    source = kx.read(shared_data / "cmu" / "135" / "135_11.amc").resample(60.0)
    piece = kx.performance(source, from_state="A", to_state="B", seconds=30.0, linger=True)
    assert piece.attained
    assert piece.motion.duration < 10.0
    assert any("it ends there (`linger`, --linger)" in w for w in piece.motion.warnings)


def test_a_way_that_there_is_none_of_is_refused_with_those_there_are(shared_data: Path) -> None:
    """Nobody comes back to the pose that the recording begins in: told is what is come to, and from where."""
    source = kx.read(shared_data / "cmu" / "135" / "135_11.amc").resample(60.0)
    with pytest.raises(kx.InputError) as refused:
        kx.performance(source, from_state="B", to_state="A")
    told = str(refused.value)
    assert "No way leads from the state 'B' to the state 'A'" in told
    assert "to 'A' from no other" in told
    found = told.partition("from 'B' one comes to ")[2].partition(", to 'A'")[0].split(", ")
    assert found
    for state in found:
        assert kx.performance(source, from_state="B", to_state=state).attained


def test_a_state_that_nothing_leads_back_to_is_begun_in(shared_data: Path) -> None:
    """From the pose that a kata begins in one goes into what goes on, and on towards whatever else is wished for."""
    source = kx.read(shared_data / "cmu" / "135" / "135_11.amc").resample(60.0)
    material = kx.prepare(source)
    assert (material.network.repertoire.frame_of(material.network.first) > 60).all()
    for wish in ({"seconds": 6.0}, {"seconds": 6.0, "favour": "B"}, {"target": (0.0, 1.0)}):
        piece = kx.performance(material, from_state="A", **wish)
        first = piece.course.paths[0]
        assert piece.network.first[first] == piece.provenance.moment[0]
        assert piece.network.state_from[first] == "A"
        assert piece.network.endless
        assert len(piece.network) > len(material.network)
        assert piece.attained or "target" not in wish
        assert not any(w.startswith("performed is") for w in piece.motion.warnings)
    avatar = kx.Avatar(material, from_state="A", goal=goals.Speed(1.0))
    assert avatar.network.state_from[next(avatar).path] == "A"


def test_where_nothing_goes_on_from_a_state_it_is_said_where_one_comes_to(apart: list[Motion]) -> None:
    """So that one of those can be gone to."""
    brief = bowing(1.2).replace(name="brief")
    states = {s.label for s in kx.graph([apart[0], brief]).racemic().states}
    performed, refused = set(), {}
    for state in states:
        try:
            kx.performance([apart[0], brief], seconds=1.0, from_state=state)
        except kx.InputError as error:
            refused[state] = str(error)
        else:
            performed.add(state)
    assert performed
    assert refused
    for state, told in refused.items():
        assert f"From the state '{state}' no way leads to where one could go on without end" in told
        assert "`to_state` (--to)" in told
