"""What a recording is: one object from any door, the facts of `analysis.json` and the curves behind them.

- `analyze`: a motion, or several, to an `Analysis`
- `find_stillness`, `stillness_rule`: where the body stays (§3.2.1)
- `find_symmetric_states`: where it is its own mirror image (§3.3)
- `kinesics.analysis.facts`: the dataclasses of the parts
"""

from __future__ import annotations

from kinesics.analysis.analysis import SCHEMA_VERSION, Analysis, analyze
from kinesics.analysis.stillness import StillnessRule, find_stillness, stillness_rule
from kinesics.analysis.symmetric_states import SYMMETRY_THRESHOLD, find_symmetric_states

__all__ = [
    "SCHEMA_VERSION",
    "SYMMETRY_THRESHOLD",
    "Analysis",
    "StillnessRule",
    "analyze",
    "find_stillness",
    "find_symmetric_states",
    "stillness_rule",
]
