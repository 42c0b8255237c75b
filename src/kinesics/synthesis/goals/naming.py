"""The paths of a network that a name stands for: of the grammar, of a person's, of a recording, or a word in one."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError, some_of

if TYPE_CHECKING:
    from kinesics.synthesis.network import Network

Mask = NDArray[np.bool_]

_LEAST_WORD: Final = 3
_LEAST_NUMBER: Final = 2
_LISTED: Final = 30
_SEVERAL: Final = 8


def paths_of(network: Network, name: str) -> Mask:
    """Paths that a name stands for: shape (paths,).

    A class, a label, a state (either end), a phrase or a recording of that very name; where there is none, all classes and
    phrases with that word in their names, and all recordings with a word that begins with it: "walk" are "walk_01", "slow walking"
    and "MaleWalk", but no "sidewalk".

    Raises
    ------
    InputError
        If there are none: nothing of that name can be performed, or there is none; the message lists what there is.
    """
    every = network.repertoire.names
    recordings = [every[k] for k in network.recording.tolist()]
    words = (network.class_, network.label, network.state_from, network.state_to, network.phrase, recordings)
    found = np.zeros(len(network.first), dtype=np.bool_)
    for said in words:
        if len(said):
            found |= np.asarray(said) == name
    if not found.any():
        for said, whole in ((network.class_, True), (network.phrase, True), (recordings, False)):
            likewise = with_word(name, set(said), whole=whole)
            if likewise:
                found |= np.isin(said, likewise)
    if not found.any():
        left_out = [name] if name in every else with_word(name, every)
        if left_out:
            raise unusable(left_out)
        raise InputError(unknown("class, label, state, phrase or recording", name, set().union(*words)))
    return found


def states_of(network: Network, name: str, end: str) -> Mask:
    """Paths that begin (``end`` = "from") or end ("to") in a state: shape (paths,). Raises InputError if none."""
    words = network.state_from if end == "from" else network.state_to
    found = np.asarray(words) == name if len(words) else np.zeros(0, dtype=np.bool_)
    if not found.any():
        what = "state to begin in" if end == "from" else "state to go to"
        raise InputError(unknown(what, name, set(words)))
    return np.asarray(found, dtype=np.bool_)


def with_word(word: str, names: Iterable[str], *, whole: bool = False) -> list[str]:
    """Those names in which a word, or several one after the other, stands, or (but for ``whole``) begins another; sorted.

    Upper and lower case are one; words end at whatever is no letter and where small letters pass into capitals. None has fewer
    than three letters: "A" is a state, and not all that begins with it. Numbers have two digits or more and begin nothing: "07" is
    whoever was recorded seventh.
    """
    wanted = _words(word)
    number = wanted.isdigit()
    if len(wanted) < (_LEAST_NUMBER if number else _LEAST_WORD):
        return []
    end = " " if whole or number else ""
    return sorted({name for name in names if f" {wanted}{end}" in f" {_words(name)} "})


def unusable(names: Sequence[str], *, recordings: bool = True) -> InputError:
    """That nothing can be performed of what is favoured, recordings or words of the grammar, and what helps."""
    it = "it" if len(names) == 1 else "them"
    return InputError(
        f"Nothing can be performed of {some_of(names, _SEVERAL)}, which {'is' if len(names) == 1 else 'are'} to be favoured: no "
        f"transition leads there and back again. Give longer recordings, or others that are nearer to {it} in pose, speed and "
        f"footing{f'; or perform from {it} alone' if recordings else ''}."
    )


def unknown(what: str, name: str, known: Iterable[str]) -> str:
    """That there is none of that name, what it may have meant, and what there is."""
    there = sorted(set(known) - {""})
    if not there:
        return (
            f"No {what} {name!r}: the paths of this network have no names; "
            "`kinesics.synthesis.labels.labelled` gives them the grammar's."
        )
    # one word of a name may be meant as well as all of it
    near = difflib.get_close_matches(name, there, n=3, cutoff=0.5)
    words = {word: full for full in reversed(there) for word in _words(full).split() if len(word) > 2}
    near += [full for part in _words(name).split() for full in with_word(part, there) if full not in near]
    near += [words[w] for w in difflib.get_close_matches(name.lower(), words, n=3, cutoff=0.7) if words[w] not in near]
    listed = ", ".join(there[:_LISTED]) + (f" and {len(there) - _LISTED} more" if len(there) > _LISTED else "")
    return (
        f"No {what} {name!r}." + (f" Did you mean {' or '.join(near[:3])}?" if near else "") + f" There are: {listed}."
    )


def _words(name: str) -> str:
    """The words of a name, small, a blank between them."""
    apart = re.sub(r"([^\W\d_A-Z])([A-Z])", r"\1 \2", name)
    return " ".join(re.findall(r"[^\W\d_]+|\d+", apart)).lower()
