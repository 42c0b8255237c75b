"""The paths of a network that a name of the grammar stands for."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError

if TYPE_CHECKING:
    from kinesics.synthesis.network import Network

Mask = NDArray[np.bool_]


def paths_of(network: Network, name: str) -> Mask:
    """Paths that a class, a label, a state (either end) or a recording names: shape (paths,).

    Raises
    ------
    InputError
        If there are none; the message lists what there is.
    """
    found = np.zeros(len(network.first), dtype=np.bool_)
    known: set[str] = set()
    recordings = [network.repertoire.names[k] for k in network.recording.tolist()]
    for words in (network.class_, network.label, network.state_from, network.state_to, recordings):
        if len(words):
            found |= np.asarray(words) == name
            known.update(words)
    if not found.any():
        raise InputError(_unknown("class, label, state or recording", name, known))
    return found


def states_of(network: Network, name: str, end: str) -> Mask:
    """Paths that begin (``end`` = "from") or end ("to") in a state: shape (paths,). Raises InputError if none."""
    words = network.state_from if end == "from" else network.state_to
    found = np.asarray(words) == name if len(words) else np.zeros(0, dtype=np.bool_)
    if not found.any():
        raise InputError(_unknown(f"state for a path to go {end}", name, set(words)))
    return np.asarray(found, dtype=np.bool_)


def _unknown(what: str, name: str, known: set[str]) -> str:
    there = sorted(known - {""})
    if not there:
        return (
            f"No {what} {name!r}: the paths of this network have no names; "
            "`kinesics.synthesis.network.labelled` gives them the grammar's."
        )
    near = difflib.get_close_matches(name, there, n=3, cutoff=0.5)
    listed = ", ".join(there[:30]) + (f" and {len(there) - 30} more" if len(there) > 30 else "")
    return f"No {what} {name!r}." + (f" Did you mean {' or '.join(near)}?" if near else "") + f" There are: {listed}."
