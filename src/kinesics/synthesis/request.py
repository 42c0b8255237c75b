"""What `kinesics.perform` is asked for, but the recordings: names and numbers, checked before anything is read or computed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from kinesics.errors import InputError
from kinesics.synthesis.control.controller import BETA, WIDEST
from kinesics.synthesis.control.courses import LONGEST
from kinesics.synthesis.goals.arguments import is_number
from kinesics.synthesis.repertoire import check_rate
from kinesics.synthesis.wish import Wish

if TYPE_CHECKING:
    from kinesics.synthesis.goals import Feature, Goal


@dataclass(frozen=True, kw_only=True, eq=False)
class Request:
    """What is asked for; see `kinesics.performance`, whose parameters these are. None: as the recordings were prepared.

    Raises
    ------
    InputError
        If one of them is out of range, or they contradict each other. What only recordings can tell, such as whether there is a
        state of that name, is told when it is performed from them.
    """

    target: ArrayLike | None = None
    radius: float | None = None
    route: ArrayLike | None = None
    from_state: str | None = None
    to_state: str | None = None
    favour: str | None = None
    goal: Goal | Feature | Sequence[Goal | Feature] | None = None
    seconds: float | None = None
    linger: bool = False
    seed: int = 0
    beta: float = BETA
    bend: float | None = None
    mirrored: bool | None = None
    backwards: bool | None = None
    fps: float | None = None
    threshold: float | None = None

    def __post_init__(self) -> None:
        """Check all of it."""
        for name in ("linger", "mirrored", "backwards"):
            value = getattr(self, name)
            if not isinstance(value, bool | np.bool_) and (name == "linger" or value is not None):
                raise InputError(f"Expected `{name}` to be True or False, got {value!r}.")
        if self.radius is not None and not (is_number(self.radius) and self.radius > 0.0):
            raise InputError(f"Expected `radius` (--within) in metres, above 0, got {self.radius!r}.")
        if isinstance(self.goal, list | tuple) and not self.goal:
            raise InputError("`goal` is empty: give a goal or several of them, or leave it out.")
        wish = self.wish
        if self.seconds is not None and not (is_number(self.seconds) and 0.0 < self.seconds <= LONGEST):
            raise InputError(f"Expected `seconds` above 0 and at most {LONGEST:g}, got {self.seconds!r}.")
        if self.linger and not wish.ends:
            raise InputError(
                "`linger` (--linger) is to go on when what is gone for is attained, but there is nothing to go for: give a target, "
                "a route, a state to go to or a goal; or leave it out, for without one it goes on to the end of `seconds` anyway."
            )
        if self.linger and self.seconds is None:
            raise InputError(
                "`linger` (--linger) is to go on to the end of `seconds` (--seconds) when the goal is attained: say how many."
            )
        _whole(self.seed)
        if not (is_number(self.beta) or self.beta == math.inf) or self.beta < 0.0:
            raise InputError(f"Expected `beta` of 0 or more (infinite: always the best), got {self.beta!r}.")
        if self.bend is not None and not (is_number(self.bend) and 0.0 <= self.bend <= WIDEST):
            raise InputError(f"Expected `bend` in degrees a metre, from 0 to {WIDEST:g}, got {self.bend!r}.")
        if self.fps is not None:
            check_rate(self.fps)
        if self.threshold is not None and not (is_number(self.threshold) and 0.0 < self.threshold <= 1.0):
            raise InputError(
                f"Expected `threshold`, a mean distance D, above 0 and at most 1, got {self.threshold!r}; it is found if none is "
                "given."
            )

    @cached_property
    def wish(self) -> Wish:
        """What is gone for."""
        return Wish.of(self.target, self.route, self.from_state, self.to_state, self.favour, self.goal, self.radius)

    @property
    def whole_seed(self) -> int:
        """The seed as a whole number of Python's own."""
        return _whole(self.seed)

    def plain(self) -> dict[str, Any]:
        """As plain values, but for the frame rate."""
        return {
            **self.wish.plain(),
            "seconds": None if self.seconds is None else float(self.seconds),
            "linger": bool(self.linger),
            "seed": self.whole_seed,
            "beta": float(self.beta) if np.isfinite(self.beta) else "infinite",
            "bend": None if self.bend is None else float(self.bend),
            "mirrored": bool(self.mirrored),
            "backwards": bool(self.backwards),
            "threshold": None if self.threshold is None else float(self.threshold),
        }


def _whole(seed: Any) -> int:
    try:
        number = int(seed)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"Expected a whole number as `seed`, got {seed!r}.") from None
    if isinstance(seed, str) or number != seed or number < 0:
        raise InputError(f"Expected a whole number of 0 or more as `seed`, got {seed!r}.")
    return number
