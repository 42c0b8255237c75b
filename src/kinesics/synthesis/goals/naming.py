"""The paths of a network that a name stands for: of the grammar, of a person's, of a recording, or a word in one."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.errors import InputError, some_of
from kinesics.vocabulary import CLASS_WORDS

if TYPE_CHECKING:
    from kinesics.synthesis.paths.network import Network

Mask = NDArray[np.bool_]

_LEAST_WORD: Final = 3
_LEAST_NUMBER: Final = 2
_LISTED: Final = 30
_OF_A_SORT: Final = 12
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
        raise InputError(_unknown_favour(network, name))
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
            "`kinesics.synthesis.paths.labels.labelled` gives them the grammar's."
        )
    listed = ", ".join(there[:_LISTED]) + (f" and {len(there) - _LISTED} more" if len(there) > _LISTED else "")
    return f"No {what} {name!r}.{_meant(name, there)} There are: {listed}."


def _meant(name: str, there: Sequence[str]) -> str:
    """Of sorted names, those that this one may be a slip for: of all of it, or of one word of it."""
    near = difflib.get_close_matches(name, there, n=3, cutoff=0.5)
    words = {word: full for full in reversed(there) for word in _words(full).split() if len(word) > 2}
    near += [full for part in _words(name).split() for full in with_word(part, there) if full not in near]
    near += [words[w] for w in difflib.get_close_matches(name.lower(), words, n=3, cutoff=0.7) if words[w] not in near]
    return f" Did you mean {' or '.join(near[:3])}?" if near else ""


def _unknown_favour(network: Network, name: str) -> str:
    """That there is nothing of that name to be favoured, and what there is: of which sort, how long, in plain words."""
    seconds = np.asarray(network.duration, dtype=np.float64)
    every = network.repertoire.names
    sorts: list[tuple[str, Sequence[str], Callable[[str], str]]] = [
        ("recordings", [every[k] for k in network.recording.tolist()], lambda _: ""),
        ("classes", network.class_, _class_in_words),
        ("phrases", network.phrase, _phrase_in_words(network)),
        ("states", network.state_to, lambda _: "on the way there: "),
        ("paths between states", network.label, _path_in_words(network)),
    ]
    lines = []
    for sort, words, told in sorts:
        lasts: dict[str, float] = {}
        for word, length in zip(words, seconds.tolist(), strict=False):
            if word:
                lasts[word] = lasts.get(word, 0.0) + length
        if not lasts:
            continue
        most = sorted(lasts, key=lambda word: (-lasts[word], word))
        more = f"; {len(most) - _OF_A_SORT} more" if len(most) > _OF_A_SORT else ""
        lines.append(
            f"  {sort}: " + "; ".join(f"{word} ({told(word)}{lasts[word]:.1f} s)" for word in most[:_OF_A_SORT]) + more
        )
    there = sorted({word for _, words, _ in sorts for word in words} - {""})
    return (
        f"No class, label, state, phrase or recording {name!r}.{_meant(name, there)} There are, with the seconds that can be "
        "performed of each, mirror images counted:\n" + "\n".join(lines)
    )


def _class_in_words(slug: str) -> str:
    known = {c.value: words for c, words in CLASS_WORDS.items()}
    return f"{known[slug]}: " if slug in known else ""


def _phrase_in_words(network: Network) -> Callable[[str], str]:
    """Of which class most of a phrase is."""
    lasts: dict[tuple[str, str], float] = {}
    for phrase, class_, length in zip(network.phrase, network.class_, np.asarray(network.duration), strict=False):
        lasts[phrase, class_] = lasts.get((phrase, class_), 0.0) + float(length)
    mostly = {phrase: class_ for (phrase, class_), _ in sorted(lasts.items(), key=lambda item: item[1])}
    return lambda phrase: f"{mostly[phrase]}: " if mostly.get(phrase) else ""


def _path_in_words(network: Network) -> Callable[[str], str]:
    """Between which states each path of the motion graph goes, where its pieces tell."""
    begins: dict[str, str] = {}
    ends: dict[str, str] = {}
    for label, first, last in zip(network.label, network.state_from, network.state_to, strict=True):
        if first:
            begins.setdefault(label, first)
        if last:
            ends.setdefault(label, last)
    return lambda label: f"{begins[label]} to {ends[label]}: " if label in begins and label in ends else ""


def _words(name: str) -> str:
    """The words of a name, small, a blank between them."""
    apart = re.sub(r"([^\W\d_A-Z])([A-Z])", r"\1 \2", name)
    return " ".join(re.findall(r"[^\W\d_]+|\d+", apart)).lower()
