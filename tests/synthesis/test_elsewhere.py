"""What is wished for by name is performed wherever in the recordings it holds together, and it is said that the rest is not."""

from __future__ import annotations

import numpy as np
import pytest

import kinesics as kx
from bodies import about, moving, rounds
from kinesics.body.motion import Motion


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
