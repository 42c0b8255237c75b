"""What is asked for is checked before anything is read or computed."""

from __future__ import annotations

import inspect
import math
from typing import Any

import numpy as np
import pytest

import kinesics as kx
from kinesics.synthesis import goals
from kinesics.synthesis import material as materials
from kinesics.synthesis.joining import transitions
from kinesics.synthesis.request import Request


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"seconds": -1.0}, "`seconds` above 0"),
        ({"seconds": math.nan}, "`seconds` above 0"),
        ({"seconds": "20"}, "`seconds` above 0"),
        ({"seconds": True}, "`seconds` above 0"),
        ({"seed": -1}, "0 or more as `seed`"),
        ({"seed": 1.5}, "`seed`"),
        ({"seed": "1"}, "`seed`"),
        ({"seed": None}, "`seed`"),
        ({"seed": math.inf}, "`seed`"),
        ({"beta": math.nan}, "`beta`"),
        ({"beta": "strict"}, "`beta`"),
        ({"bend": math.inf}, "`bend`"),
        ({"bend": -1.0}, "from 0 to 90"),
        ({"fps": "fast"}, "`fps`"),
        ({"fps": math.nan}, "`fps`"),
        ({"fps": "30"}, "`fps`"),
        ({"fps": 1.0}, "8 frames a second or more"),
        ({"threshold": 0.0}, "above 0 and at most 1"),
        ({"threshold": math.nan}, "above 0 and at most 1"),
        ({"target": ()}, "two numbers"),
        ({"target": (1.0, math.nan)}, "finite"),
        ({"target": (1.0, 1.0), "radius": 0.0}, "`radius` (--within)"),
        ({"route": []}, "shape (n, 2)"),
        ({"goal": []}, "`goal` is empty"),
        ({"goal": goals.Speed}, "Speed(…)"),
        ({"mirrored": "no"}, "True or False"),
        ({"linger": True}, "nothing to go for"),
        ({"linger": True, "seconds": 5.0, "favour": "walk"}, "nothing to go for"),
        ({"linger": True, "target": (0.0, 1.0)}, "say how many"),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else None,
)
def test_what_cannot_be_asked_for_is_refused(asked: dict[str, Any], says: str) -> None:
    """With what was expected; whatever the recordings are."""
    with pytest.raises(kx.InputError) as refused:
        Request(**asked)
    assert says in str(refused.value)
    with pytest.raises(kx.InputError) as refused:
        kx.perform("no motion", **asked)  # type: ignore[arg-type]
    assert says in str(refused.value)


def test_a_skeleton_is_a_skeleton() -> None:
    """Or a motion of one; anything else is told before anything is computed."""
    with pytest.raises(kx.InputError, match="Expected `skeleton` to be a skeleton, or a motion of one, got str"):
        kx.perform(kx.performer.walk(seconds=4, fps=30).motion, skeleton="walk.bvh")  # type: ignore[arg-type]


def test_numbers_of_numpy_are_numbers() -> None:
    """And come out as those of Python."""
    asked = Request(
        seconds=np.float32(2.0), seed=np.int64(3), beta=np.inf, bend=np.float64(1.0), mirrored=np.bool_(False)
    )  # type: ignore[arg-type]
    plain = asked.plain()
    assert plain["seconds"] == 2.0
    assert (type(plain["seconds"]), type(plain["seed"]), plain["beta"]) == (float, int, "infinite")
    assert plain["mirrored"] is False


def test_both_doors_take_the_same() -> None:
    """One signature and one text, but for what comes out."""
    of_motion, of_piece = inspect.signature(kx.perform), inspect.signature(kx.performance)
    assert of_motion.parameters == of_piece.parameters
    assert (of_motion.return_annotation, of_piece.return_annotation) == ("Motion", "Piece")
    assert kx.perform.__doc__ == kx.performance.__doc__
    asked = set(inspect.signature(Request).parameters)
    assert asked == set(of_piece.parameters) - {"motions", "skeleton", "mapping", "edits", "progress"}
    defaults = {name: inspect.signature(Request).parameters[name].default for name in asked}
    assert defaults == {name: of_piece.parameters[name].default for name in asked}


def test_an_unknown_state_is_told_before_transitions_are_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which may take minutes; with the states there are."""
    walk = kx.performer.walk(seconds=4, fps=30).motion

    def looked_for(*_: Any, **__: Any) -> transitions.Transitions:
        raise AssertionError("transitions were looked for")

    monkeypatch.setattr(materials, "transitions", looked_for)
    for asked in ({"from_state": "Q"}, {"from_state": "A", "to_state": "Q"}):
        with pytest.raises(kx.InputError, match=r"'Q'.* There are: A, A"):
            kx.perform(walk, **asked)  # type: ignore[arg-type]
