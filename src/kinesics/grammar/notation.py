"""Labels and sentences of a motion graph in ASCII, and the same for people ([Schultz2012] §3.5, §3.6.2).

=============  ==========================================================================================
``A``, ``A*``  a state and its mirror image
``X~``         a symmetric state: X with a bar
``ab_1``       the first path from A to B; ``ab*_1`` from A to B*; ``xa1_1`` from X~ to A1
``(ab_1)*``    its mirror image, from A* to B*
``xy~_1``      a symmetric path from X~ to Y~ (``xy_1`` is one that breaks symmetry on the way)
``<ab_1``      traversed backwards
``aa_0``       a stay in A; ``xx~_0`` in X~, ``(aa_0)*`` in A*
``..ab_1``     the recording begins on the way; ``ab_1..`` it ends on the way
=============  ==========================================================================================

A state may be given a word for a name (`kinesics.grammar.edits`); its paths are then written with a hyphen, ``guard-b_1``.
"""

from __future__ import annotations

import itertools
import re
import unicodedata
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, NamedTuple

from kinesics.errors import InputError

if TYPE_CHECKING:
    from kinesics.grammar.graph import MotionGraph, Step

MIRROR: Final = "*"
BAR: Final = "~"
BACKWARDS: Final = "<"
CUT: Final = ".."

_STATE: Final = re.compile(r"(?P<name>[^\W_]+)(?P<mark>[*~]?)")
_PATH: Final = re.compile(r"(?P<name>[^\W_]+(?:\*?-[^\W_]+)?\*?)(?P<bar>~?)(?:_(?P<index>[0-9]+))?")
_LETTER: Final = re.compile(r"[A-Z][0-9]*")
_SUBSCRIPTS: Final = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_OVERLINE: Final = "\N{COMBINING MACRON}"


class Token(NamedTuple):
    """One word of a sentence: a stay (``state``) or a traversal (``path``), by id."""

    state: int | None
    path: int | None
    reversed: bool
    complete: bool


def letters(alphabet: str) -> Iterator[str]:
    """A, B, C, …, then A1, B1, …, then A2, … for ever."""
    for round_ in itertools.count():
        for letter in alphabet:
            yield letter + (str(round_) if round_ else "")


def mirror_state_label(label: str) -> str:
    """The label of the mirror image of a state: starred or no longer; what has a bar keeps its label."""
    if label.endswith(BAR):
        return label
    return label[:-1] if label.endswith(MIRROR) else label + MIRROR


def mirror_path_label(label: str) -> str:
    """The label of the mirror image of a path: in parentheses with a star, or no longer; what has a bar keeps its label."""
    if BAR in label:
        return label
    return label[1:-2] if label.startswith("(") else f"({label}){MIRROR}"


def path_base(from_label: str, to_label: str, symmetric: bool) -> tuple[str, bool]:
    """The label without index of a path between two states, and whether the path carries the star.

    The star goes to the path that begins in a starred state, or, beginning in a symmetric one, ends in a starred one.
    """
    starred = from_label.endswith(MIRROR) or (from_label.endswith(BAR) and to_label.endswith(MIRROR))
    if starred:
        from_label, to_label = mirror_state_label(from_label), mirror_state_label(to_label)
    names = [label.rstrip(BAR) for label in (from_label, to_label)]
    plain = [_LETTER.fullmatch(name.rstrip(MIRROR)) is not None for name in names]
    small = [name.lower() if letter else name for name, letter in zip(names, plain, strict=True)]
    joined = ("" if all(plain) else "-").join(small)
    return joined + BAR * symmetric, starred


def stay_label(state_label: str) -> str:
    """How a stay in a state is written: ``aa_0`` (§3.2.1)."""
    symmetric = state_label.endswith(BAR)
    base, starred = path_base(state_label, state_label, symmetric)
    # in A* the stay is the mirror image of the stay in A
    return mirror_path_label(f"{base}_0") if starred else f"{base}_0"


def check_state_label(label: str, symmetric: bool) -> None:
    """Refuse a label that the notation could not be read back from.

    Raises
    ------
    InputError
        If it is no word of letters and digits, or its mark does not say what the state is.
    """
    match = _STATE.fullmatch(label)
    if match is None or (match["mark"] == BAR) != symmetric:
        wanted = f"'{BAR}' at the end, as 'X~'" if symmetric else f"no '{BAR}', as 'A' or 'A*'"
        raise InputError(
            f"A {'symmetric' if symmetric else 'chiral'} state is labelled by letters and digits with {wanted}; got '{label}'."
        )


def check_path_label(label: str, symmetric: bool) -> None:
    """Refuse a label that the notation could not be read back from.

    Raises
    ------
    InputError
        If it has not the form of this module's table, or has a bar and the path is not symmetric or the other way round.
    """
    core = label[1:-2] if label.startswith("(") and label.endswith(")*") else label
    match = _PATH.fullmatch(core)
    if (
        match is None
        or (match["bar"] == BAR) != symmetric
        or (symmetric and core is not label)
        or match["index"] == "0"
    ):
        wanted = "'xy~_1'" if symmetric else "'ab_1' or '(ab_1)*'"
        raise InputError(
            f"A {'symmetric path' if symmetric else 'path'} is labelled like {wanted}; got '{label}'"
            + (" (index 0 is a stay)." if match is not None and match["index"] == "0" else ".")
        )


def notation(graph: MotionGraph, source: int | None = None) -> str:
    """See `MotionGraph.notation`."""
    numbers = range(len(graph.sources)) if source is None else [source]
    lines = []
    for number in numbers:
        steps = graph.timeline(number)
        lines.append(" ".join(_word(graph, step, k == 0, k == len(steps) - 1) for k, step in enumerate(steps)))
    return "\n".join(lines)


def _word(graph: MotionGraph, step: Step, first: bool, last: bool) -> str:
    if step.path is None:
        assert step.state is not None
        return stay_label(graph.state(step.state).label)
    word = BACKWARDS * step.reversed + graph.path(step.path).label
    if step.complete:
        return word
    return CUT * first + word + CUT * last


def parse(graph: MotionGraph, text: str) -> tuple[Token, ...]:
    """The words of a sentence of the graph; any sentence, also one that was never performed.

    The index may be left out where there is only one such path: ``ab`` for ``ab_1``.

    Raises
    ------
    InputError
        If a word is no path of the graph, is traversed backwards and cannot be, or does not begin where the last one ended.
    """
    stays = {stay_label(s.label): s.id for s in graph.states}
    paths = {p.label: p.id for p in graph.paths}
    short: dict[str, list[int]] = {}
    for path in graph.paths:
        short.setdefault(re.sub(r"_[0-9]+", "", path.label), []).append(path.id)
    paths |= {label: ids[0] for label, ids in short.items() if len(ids) == 1 and label not in paths}
    words = text.split()
    tokens: list[Token] = []
    here: int | None = None
    for place, word in enumerate(words):
        name = word.removeprefix(CUT).removesuffix(CUT)
        complete = name == word
        reversed_ = name.startswith(BACKWARDS)
        name = name.removeprefix(BACKWARDS)
        where = f"word {place + 1} of the notation, '{word}',"
        if name in stays and not reversed_:
            token = Token(stays[name], None, False, complete)
            enters = leaves = stays[name]
        elif name in paths:
            path = graph.path(paths[name])
            if reversed_ and not path.reversible:
                raise InputError(f"{_capital(where)} goes backwards along '{path.label}', which is not reversible.")
            token = Token(None, path.id, reversed_, complete)
            enters, leaves = (path.to, path.from_) if reversed_ else (path.from_, path.to)
        else:
            known = ", ".join([*paths, *stays][:60]) or "none"
            raise InputError(f"{_capital(where)} is neither a path nor a stay of the graph. Known: {known}.")
        if not complete and 0 < place < len(words) - 1:
            raise InputError(f"{_capital(where)} is cut short in the middle of the sentence.")
        if here is not None and enters != here:
            raise InputError(
                f"{_capital(where)} begins in '{graph.state(enters).label}', but the word before it ends in "
                f"'{graph.state(here).label}'."
            )
        tokens.append(token)
        here = leaves
    return tuple(tokens)


def rebuild(graph: MotionGraph, text: str, source: int = 0) -> tuple[Step, ...]:
    """See `MotionGraph.rebuild`: the n-th time a word is said is the n-th time that step was seen.

    Raises
    ------
    InputError
        As `MotionGraph.rebuild`.
    """
    from kinesics.grammar.graph import Step

    tokens = parse(graph, text)
    graph.timeline(source)  # refuses a source that does not exist
    waiting: dict[Token, Iterator[tuple[int, int]]] = {}
    for state in graph.states:
        mine = sorted((s.start, s.end) for s in state.stays if s.source == source)
        waiting[Token(state.id, None, False, True)] = iter(mine)
    for path in graph.paths:
        for way, whole in itertools.product((False, True), repeat=2):
            mine = sorted(
                (o.start, o.end)
                for o in path.occurrences
                if o.source == source and o.reversed == way and o.complete == whole
            )
            waiting[Token(None, path.id, way, whole)] = iter(mine)
    steps: list[Step] = []
    for place, token in enumerate(tokens):
        start, end = next(waiting[token], (-1, -1))
        reached = steps[-1].end if steps else 0
        if start != reached:
            raise InputError(
                f"The notation is not that of source {source}: word {place + 1}, '{text.split()[place]}', "
                f"was not performed at frame {reached}."
            )
        steps.append(Step(source, start, end, token.state, token.path, token.reversed, token.complete))
    reached = steps[-1].end if steps else 0
    if reached != graph.sources[source].frames:
        raise InputError(
            f"The notation ends at frame {reached} of the {graph.sources[source].frames} of source {source}."
        )
    return tuple(steps)


def pretty(graph: MotionGraph, source: int | None = None) -> str:
    """See `MotionGraph.pretty`."""
    from kinesics.grammar.graph import ends_of

    numbers = range(len(graph.sources)) if source is None else [source]
    lines = []
    for number in numbers:
        said: list[str] = []
        here: int | None = None
        for step in graph.timeline(number):
            enters, leaves = ends_of(graph, step)
            if step.path is None:
                # a stay is shown as the state itself, held
                said.append(pretty_label(graph.state(enters).label) + "…")
                here = enters
                continue
            name = pretty_label(graph.path(step.path).label)
            word = f"←{name}" if step.reversed else f"{name}→"
            # a state that the recording does not reach, or did not begin in, is not said
            entered, left = step.complete or step.start > 0, step.complete or step.end < graph.sources[number].frames
            if here != enters and entered:
                said.append(pretty_label(graph.state(enters).label))
            said.append(CUT * (not entered) + word + CUT * (not left))
            if left:
                said.append(pretty_label(graph.state(leaves).label))
            here = leaves
        lines.append(_held_once(said))
    return "\n".join(lines)


def _held_once(said: list[str]) -> str:
    """``X̄ X̄…`` is ``X̄…``."""
    kept = [w for w, following in itertools.pairwise([*said, ""]) if following != w + "…"]
    return " ".join(kept)


def pretty_label(label: str) -> str:
    """A label with overbars and subscripts: ``X̄``, ``X̄₁``, ``x̄ȳ₁``, ``(ab₁)*``; a word that someone chose keeps its ``~``."""
    name, _, index = label.partition("_")
    tail = ""
    if index.endswith(")*"):
        index, tail = index[:-2], ")*"
    if BAR in name and _short(name.replace(BAR, "")):
        name = "".join(c.translate(_SUBSCRIPTS) if c.isdigit() else c + _OVERLINE for c in name.replace(BAR, ""))
    elif _LETTER.fullmatch(name.rstrip(MIRROR)):
        name = name.translate(_SUBSCRIPTS)
    return unicodedata.normalize("NFC", name) + index.translate(_SUBSCRIPTS) + tail


def mathtext(label: str, *, index: bool = True) -> str:
    """A label as matplotlib's mathtext: a bar over what is symmetric, a raised star.

    Parameters
    ----------
    index : False leaves the index out, as the dissertation does where there is only one such path.
    """
    starred = label.startswith("(")
    core = label[1:-2] if starred else label
    name, _, number = core.partition("_")
    barred = BAR in name
    name = name.replace(BAR, "")
    letters_ = re.sub(r"([0-9]+)", r"_{\1}", name) if _short(name) else rf"\mathrm{{{name.replace('-', '{-}')}}}"
    letters_ = letters_.replace(MIRROR, r"^{*}")
    body = rf"\overline{{{letters_}}}" if barred else letters_
    if number and index:
        body = f"{{{body}}}_{{{number}}}"
    return f"$({body})^{{*}}$" if starred else f"${body}$"


def _short(name: str) -> bool:
    """Letters of the alphabet of states, not a word that someone chose."""
    return re.fullmatch(r"[A-Za-z][0-9]*\*?(?:[a-z][0-9]*\*?)?", name) is not None


def _capital(text: str) -> str:
    return text[0].upper() + text[1:]
