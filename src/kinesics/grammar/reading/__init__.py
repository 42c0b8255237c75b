"""The motion graph read from a recording (§3.5-3.6): which moments are states, which stretches are the same path.

The dissertation drew its graphs by eye. Here the recording draws a map of itself (`kinesics.grammar.ground`) and is read as a
string: marked moments that lie together under D, or under D*, are one state or a mirrored pair (states.py); the times at which the
movement is in a state are visits (visits.py); the stretches between are compared with each other with tempo freedom and merged
(traversals.py). What the class of a cyclic movement tells is woven in (weaving.py).

A state that leaves no trace (one way in, one way out, no stop, no turning back, not symmetric) is none (traces.py).

- `read` makes a `Reading`: `ReadState`, `ReadPath`, and the string of `Visit` and `Traversal`
- `held`, `self_symmetry`: what is asked of it afterwards
"""

from __future__ import annotations

from kinesics.grammar.reading.recording import Reading, held, read
from kinesics.grammar.reading.states import ReadState
from kinesics.grammar.reading.stretches import self_symmetry, warped
from kinesics.grammar.reading.traversals import BREAK, ReadPath, Traversal
from kinesics.grammar.reading.visits import Visit

__all__ = ["BREAK", "ReadPath", "ReadState", "Reading", "Traversal", "Visit", "held", "read", "self_symmetry", "warped"]
