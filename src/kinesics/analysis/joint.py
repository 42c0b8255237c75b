"""One motion graph of one or many motions: the public `kinesics.graph`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from kinesics.body.motion import Motion
from kinesics.body.pose import poses
from kinesics.errors import InputError
from kinesics.progress import Progress, silent

if TYPE_CHECKING:
    from kinesics.grammar.edits import Edits
    from kinesics.grammar.graph import MotionGraph


def graph(
    motions: Motion | Sequence[Motion],
    *,
    mapping: Mapping[str, object] | None = None,
    edits: Edits | None = None,
    progress: Progress = silent,
) -> MotionGraph:
    """The motion graph of one motion, or of several read together ([Schultz2012] §3.5-3.6).

    What the recordings share, the same or mirrored, is one state and one path; skeletons may differ.

    Parameters
    ----------
    mapping : joint names by the user (see `kinesics.body.anatomy.resolve`).
    edits : names, merges and splits of states and paths (see `kinesics.grammar.edits`).
    progress : called with a fraction now and then; may raise to stop.

    Raises
    ------
    SkeletonError
        If a skeleton cannot be understood as a human body.
    InputError
        If there is no motion, the edits speak of what is not in the graph, or one body has the clavicle composed and another
        has it dropped.
    """
    from kinesics.grammar import many

    given = [motions] if isinstance(motions, Motion) else list(motions)
    if not given:
        raise InputError("Expected at least one motion.")
    names = [m.source.file_name or m.name or f"motion {k + 1}" for k, m in enumerate(given)]
    found = many.read_graph([poses(m, mapping) for m in given], names, progress=progress)
    return found if edits is None else edits.apply(found)
