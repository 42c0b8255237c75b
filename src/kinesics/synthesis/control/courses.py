"""Whole performances decided for at once: the paths, and the way over the floor that they make."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError
from kinesics.synthesis.control.controller import BEND, BETA, HOLD, Controller
from kinesics.synthesis.goals import Feature, Goal
from kinesics.synthesis.paths.laying import Step
from kinesics.synthesis.paths.prospects import LOOKAHEAD, Prospects

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

LONGEST: Final = 24 * 3600.0
"""Seconds; nothing longer is performed in one go."""


@dataclass(frozen=True, eq=False)
class Course:
    """What was decided, and the way over the floor that it makes: what rendering needs."""

    paths: Indices
    """Paths in the order played, shape (n,)."""
    bends: Array
    """Bend of each, radians a metre, shape (n,)."""
    begins: Indices
    """Frame at which each begins, shape (n,); the last may be cut short by the end."""
    moments: Indices
    """What each frame plays, shape (frames,)."""
    ground: Array
    """Root on the ground: x, z in metres, shape (frames, 2)."""
    yaw: Array
    """Heading, radians about +y, not wrapped, shape (frames,)."""
    fps: float
    attained: bool
    """Whether every goal that can be attained was."""
    outcome: tuple[str, ...]
    """What came of each goal, in words."""

    @property
    def seconds(self) -> float:
        """How long it lasts."""
        return len(self.moments) / self.fps

    @property
    def length(self) -> float:
        """Metres walked by the root."""
        return float(np.hypot(*np.diff(self.ground, axis=0).T).sum()) if len(self.ground) > 1 else 0.0


def perform_paths(
    network: Network,
    goal: Goal | Feature | Sequence[Goal | Feature] | None = None,
    seconds: float = 20.0,
    seed: int | np.random.Generator = 0,
    *,
    finish: bool = False,
    beta: float = BETA,
    lookahead: float = LOOKAHEAD,
    bend: float = BEND,
    hold: float = HOLD,
    start: int | None = None,
    position: tuple[float, float] = (0.0, 0.0),
    heading: float = 0.0,
    stand: bool = True,
    prepared: Prospects | None = None,
    after_each: Callable[[Controller, Sequence[Step]], None] | None = None,
) -> Course:
    """Decide for a whole performance at once. Parameters as of `Controller`.

    Parameters
    ----------
    seconds : how long, at most.
    finish : whether to end when the goals are attained (and the performer stands, if it can), before the time is up.
    after_each : called after every decision with all so far; may set the controller right, as by `Controller.be_at`.

    Raises
    ------
    InputError
        As `Controller`, and if `seconds` is not above 0.
    """
    if not (np.isfinite(seconds) and 0.0 < seconds <= LONGEST):
        raise InputError(f"Expected `seconds` above 0 and at most {LONGEST:g}, got {seconds}.")
    controller = Controller(
        network,
        goal,
        beta=beta,
        lookahead=lookahead,
        bend=bend,
        hold=hold,
        seed=seed,
        start=start,
        position=position,
        heading=heading,
        stand=stand,
        prepared=prepared,
    )
    fps = float(network.repertoire.fps)
    most = max(1, round(seconds * fps))
    steps: list[Step] = []
    frames = 0
    while frames < most and not (finish and steps and controller.finished):
        step = controller.step(most - frames)
        steps.append(step)
        frames += int(network.length[step.path])
        if after_each is not None and frames < most:
            after_each(controller, steps)
    return _course(controller, steps, most)


def _course(controller: Controller, steps: Sequence[Step], most: int) -> Course:
    network = controller.network
    places: list[NDArray[np.complex128]] = []
    headings: list[Array] = []
    for step in steps:
        way, facing = controller.way(step)
        places.append(way[:-1])
        headings.append(facing[:-1])
    paths = np.array([s.path for s in steps], dtype=np.intp)
    lengths = np.asarray(network.length, dtype=np.intp)[paths]
    begins = np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(np.intp)
    within = np.arange(int(lengths.sum())) - np.repeat(begins, lengths)
    moments = network.repertoire.advance(np.repeat(np.asarray(network.first)[paths], lengths), within)
    ground = np.concatenate(places)[:most]
    return Course(
        paths=paths,
        bends=np.array([s.bend for s in steps]),
        begins=begins,
        moments=moments[:most],
        ground=np.stack([ground.imag, ground.real], axis=1),
        yaw=np.concatenate(headings)[:most],
        fps=float(network.repertoire.fps),
        attained=controller.attained,
        outcome=controller.outcome(),
    )
