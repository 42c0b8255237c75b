"""What a performer may wish for: a place, a line on the floor, a speed, a class of movement, nothing seen before (§4.4.1).

The Markov weight of [Schultz2012] §4.4.1 is E(j) = exp(−β Σₖ wₖ [fₖ(αⱼ) − fₖ(t)]²): each feature fₖ says something of a path
and something that is wished now. So that β means the same whatever the features' units, every difference is divided by the
feature's spread (standard deviation) over all that may be chosen: β = 1 makes a path one spread from the wish e times rarer
than one right on it.

A feature of your own is a function of a motion in `Measured`, or, where paths are to be judged as such, an object of two
methods, `Feature`. The goals here know composites too (`kinesics.synthesis.paths.prospects`): places along a trail, turned from the
performer's heading into the world ([Schultz2012] §4.4.1 with the correction that the displacement turns with the performer,
and that a far target counts as one within reach in the same direction).

- to a place: `Target`, several `Targets`, a `MovingTarget` (places.py)
- along a line: `Route` (routes.py)
- how: `Heading`, `Speed` (manner.py)
- by anything you can measure in a motion: `Measured` (measured.py)
- by which paths: `Favour`, `Novelty`, `Onwards`, `Economy`, `OwnFeature` (favours.py), `Abiding` (abiding.py)
- from state to state: `StateToState` (states.py)
"""

from kinesics.synthesis.goals.abiding import AWHILE, Abiding
from kinesics.synthesis.goals.favours import Economy, Favour, Novelty, Onwards, OwnFeature
from kinesics.synthesis.goals.manner import Heading, Speed
from kinesics.synthesis.goals.measured import Measured
from kinesics.synthesis.goals.naming import paths_of, states_of
from kinesics.synthesis.goals.places import RADIUS, MovingTarget, Target, Targets, ToPlaces
from kinesics.synthesis.goals.pursuit import Feature, Goal, Pursuit, Situation, TrailPursuit
from kinesics.synthesis.goals.routes import Route
from kinesics.synthesis.goals.states import LEAD, StateToState

__all__ = [
    "AWHILE",
    "LEAD",
    "RADIUS",
    "Abiding",
    "Economy",
    "Favour",
    "Feature",
    "Goal",
    "Heading",
    "Measured",
    "MovingTarget",
    "Novelty",
    "Onwards",
    "OwnFeature",
    "Pursuit",
    "Route",
    "Situation",
    "Speed",
    "StateToState",
    "Target",
    "Targets",
    "ToPlaces",
    "TrailPursuit",
    "paths_of",
    "states_of",
]
