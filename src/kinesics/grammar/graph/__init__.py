"""The motion graph: states joined by paths, and every frame of the recordings it was read from ([Schultz2012] §3.5-3.6).

- the parts: `State`, `Path`, `Stay`, `Occurrence`, `Source`; the whole: `MotionGraph`
- to make one: `build` gives ids, labels and order to states and paths that have none yet; `label_paths` the labels of paths alone
- to read one: `MotionGraph.timeline`, `MotionGraph.notation`, `MotionGraph.rebuild`
- to transform one: `MotionGraph.racemic`, `condensed`, `contracted`, `mirrored`, `reversed_in_time`
- to compare two: `MotionGraph.isomorphic_to`, `MotionGraph.edit_distance`

Conventions, binding for whoever makes a graph:

- Frames are counted from 0, ranges are [start, end). Stays and occurrences of one source tile [0, frames) exactly once, and
  one step begins in the state in which the last one ended.
- What is symmetric (`State.symmetric`, `Path.symmetric`) is its own mirror image and has ``mirror_of = None``; what is not
  names its image in ``mirror_of``, or None where the graph does not have it.
- A path that is its own mirror image *played backwards* (antipalindromic: MT) has its own id in ``mirror_of``; it is
  reversible and joins a state to that state's mirror image.
- A path is reversible where it, or its mirror image, was traversed in both directions (§3.5); of two mirror images both are
  or none is.
- A stay has no path of its own: it is written ``aa_0`` (§3.2.1).
"""

from __future__ import annotations

from kinesics.grammar.graph.building import CHIRAL_LETTERS, SYMMETRIC_LETTERS, build, label_paths
from kinesics.grammar.graph.motion_graph import MotionGraph
from kinesics.grammar.graph.parts import Occurrence, Path, Source, State, Stay, Step, ends_of

__all__ = [
    "CHIRAL_LETTERS",
    "SYMMETRIC_LETTERS",
    "MotionGraph",
    "Occurrence",
    "Path",
    "Source",
    "State",
    "Stay",
    "Step",
    "build",
    "ends_of",
    "label_paths",
]
