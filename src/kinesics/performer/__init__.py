"""The performer: synthetic bodies that move with known answers.

    >>> import kinesics as kx
    >>> performance = kx.performer.walk(seconds=10, limp=0.0, seed=0)
    >>> performance.motion.frame_count, performance.truth.class_.value
    (1200, 'cyclic-antiphase')

- by name: `NAMES`, `perform`
- going: `walk`, `limp`, `run`, `jog_in_place`
- over and over in place: `jumping_jacks`, `squat`, `twist`, `wave`, `wave_both`, `arm_circles`, `butterfly`
- once: `throw`, `raise_arms`, `reach`, `sway`, `bow`
- sequences with a grammar: `side_kicks`, `sun_salutation`, `kata`; not at all: `stand`
- any graph of key poses: `KeyGraph`, `traverse`, `random_graph`, `covering_steps`
- the body: `Body`, `posture`; the answers: `Truth` and its parts

Nothing here measures anything: a performance is written down with its answers and then performed, so that it can judge
whatever measures. `Conditions` lists what every movement can be performed under: noise, a body, a facing, a route.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType
from typing import Any, Final

from kinesics.errors import InputError
from kinesics.performer.body import Body
from kinesics.performer.exercises import (
    arm_circles,
    butterfly,
    jumping_jacks,
    squat,
    stand,
    twist,
    wave,
    wave_both,
)
from kinesics.performer.gaits import jog_in_place, limp, run, walk
from kinesics.performer.key_graph import KeyGraph, KeyPath, KeyState
from kinesics.performer.postures import STANDING, T_POSE, posture
from kinesics.performer.random_graphs import covering_steps, random_graph
from kinesics.performer.sequences import kata, side_kicks, sun_salutation
from kinesics.performer.singles import bow, raise_arms, reach, sway, throw
from kinesics.performer.stage import Conditions
from kinesics.performer.traversal import Step, traverse
from kinesics.performer.truth import (
    Performance,
    Range,
    TrueOccurrence,
    TruePath,
    TruePhrase,
    TrueState,
    Truth,
)

_MOVEMENTS: Final[MappingProxyType[str, Callable[..., Performance]]] = MappingProxyType(
    {
        movement.__name__: movement
        for movement in (
            walk,
            limp,
            run,
            jog_in_place,
            jumping_jacks,
            squat,
            twist,
            wave,
            wave_both,
            arm_circles,
            butterfly,
            throw,
            raise_arms,
            reach,
            sway,
            bow,
            side_kicks,
            sun_salutation,
            kata,
            stand,
        )
    }
)

NAMES: Final[tuple[str, ...]] = tuple(_MOVEMENTS)
"""The movements that `perform` knows; between them they show each of the 13 classes."""


def perform(name: str, **parameters: Any) -> Performance:
    """Perform a movement by name; ``parameters`` are those of the function of that name.

    Raises
    ------
    InputError
        If there is no such movement or it has no such parameter; the message lists those there are.
    """
    if name not in _MOVEMENTS:
        raise InputError(f"Nobody knows the movement {name!r}. Movements: {', '.join(NAMES)}.")
    known = parameters_of(name)
    unknown = sorted(set(parameters) - set(known))
    if unknown:
        raise InputError(f"{name} has no parameter {', '.join(unknown)}. Parameters: {', '.join(known)}.")
    return _MOVEMENTS[name](**parameters)


def parameters_of(name: str) -> tuple[str, ...]:
    """Names of the parameters of a movement, its own first.

    Raises
    ------
    InputError
        If there is no such movement.
    """
    import inspect

    if name not in _MOVEMENTS:
        raise InputError(f"Nobody knows the movement {name!r}. Movements: {', '.join(NAMES)}.")
    own = [p.name for p in inspect.signature(_MOVEMENTS[name]).parameters.values() if p.kind is not p.VAR_KEYWORD]
    return (*own, *Conditions.__annotations__)


__all__ = [
    "NAMES",
    "STANDING",
    "T_POSE",
    "Body",
    "Conditions",
    "KeyGraph",
    "KeyPath",
    "KeyState",
    "Performance",
    "Range",
    "Step",
    "TrueOccurrence",
    "TruePath",
    "TruePhrase",
    "TrueState",
    "Truth",
    "covering_steps",
    "parameters_of",
    "perform",
    "posture",
    "random_graph",
    "traverse",
    *NAMES,
]
