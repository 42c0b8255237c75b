"""Something of the user's own measured in the recordings, and the value wished for: how high the hands, how bent the knees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.body.motion import Motion
from kinesics.errors import InputError
from kinesics.synthesis.goals.arguments import check_weight
from kinesics.synthesis.goals.favours import OwnFeature
from kinesics.synthesis.goals.pursuit import Pursuit, Situation
from kinesics.synthesis.paths.prospects import Prospects

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Measured:
    """Make much of the moments at which something measured is near to what is wished for.

        >>> def hands(motion):  # how high the left hand is, metres, frame by frame
        ...     return motion.positions()[:, motion.skeleton.find("LeftHand"), 1]
        >>> kx.perform(motion, goal=goals.Measured(hands, 1.6), seconds=20)

    As every feature it decides by the mean over each path (the stretch between two transitions), and the difference from the
    wish counts in spreads of what there is to choose from, so units do not matter.

    Parameters
    ----------
    measure : of a recording as it may be performed (on the output's skeleton, at its frame rate, feet on the ground y = 0; the
        mirror images come, too), a number for every frame: shape (frames,), or (frames, dimensions).
    wish : the number wished for, (dimensions,) of them, or a function that gives it in a `Situation` (its ``time``, ``position``,
        ``heading``).
    """

    measure: Callable[[Motion], ArrayLike]
    wish: ArrayLike | Callable[[Situation], ArrayLike]
    weight: float = 1.0

    def __post_init__(self) -> None:
        """Check what can be checked without recordings."""
        if not callable(self.measure):
            raise InputError(f"Expected `measure` to be a function of a motion, got {type(self.measure).__name__}.")
        check_weight(self.weight)

    def pursuit(self, network: Network, prospects: Prospects) -> Pursuit:
        """See `Goal`."""
        return OwnFeature(_Measured(self)).pursuit(network, prospects)


class _Measured:
    """The `Feature` that it is: the mean over the frames of every path."""

    def __init__(self, goal: Measured) -> None:
        self._goal = goal
        self.weight = goal.weight

    def values(self, network: Network) -> Array:
        stock = network.repertoire
        strands = (0, 1) if stock.mirrored else (0,)
        images = [np.concatenate([self._of(stock.motion(k, s)) for k in range(stock.recording_count)]) for s in strands]
        out = np.empty((len(network), images[0].shape[1]))
        for path, (first, length) in enumerate(zip(network.first, network.length, strict=True)):
            moments = stock.advance(first, np.arange(length))
            out[path] = images[int(stock.is_mirrored(first))][stock.frame_of(moments)].mean(axis=0)
        return out

    def wish(self, now: Situation) -> ArrayLike:
        return self._goal.wish(now) if callable(self._goal.wish) else self._goal.wish

    def _of(self, motion: Motion) -> Array:
        """Shape (frames, dimensions)."""
        given = self._goal.measure(motion)
        try:
            values = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError):
            values = np.zeros(0)
        values = values[:, None] if values.ndim == 1 else values
        if values.ndim != 2 or len(values) != motion.frame_count or not np.isfinite(values).all():
            shape = getattr(given, "shape", None)
            raise InputError(
                f"Expected `measure` to give finite numbers for the {motion.frame_count} frames of {motion.name}, shape "
                f"({motion.frame_count},) or ({motion.frame_count}, dimensions); got {type(given).__name__}"
                f"{'' if shape is None else f' of shape {shape}'}{'' if np.isfinite(values).all() else ', with NaN or infinity'}."
            )
        return values
