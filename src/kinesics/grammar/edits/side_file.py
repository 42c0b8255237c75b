"""The side file read: TOML to `Edits`; what is not in its description is refused, and where it stands is told."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any, Final, TypeVar

from kinesics.errors import InputError
from kinesics.grammar.edits.changes import Edits, Merge, PhraseMerge, PhraseName, PhraseSplit, Split

T = TypeVar("T")
_EXAMPLES: Final = {
    "states": 'rename = { A = "guard", "X~" = "attention" }',
    "paths": 'rename = { "ab_1" = "lunge" }',
    "phrases": 'rename = [ { frame = 100, name = "warm-up" } ]',
}
"""How names are given in each table of the file."""


def parse(text: str, file: str = "") -> Edits:
    """The edits that a side file holds.

    Parameters
    ----------
    file : its name, which is told where something cannot be applied.

    Raises
    ------
    InputError
        If the text is not TOML, or says something that is not in this module's description; the message says where.
    """
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"The edits are not TOML: {error}.") from None
    _only(values, ("states", "paths", "phrases"), "the edits")
    states, paths, phrases = (_table(values, k, "the edits") for k in ("states", "paths", "phrases"))
    for section, place in ((states, "states"), (paths, "paths"), (phrases, "phrases")):
        _only(section, ("rename", "merge", "split"), f"[{place}]", _EXAMPLES[place])
    return Edits(
        state_names=_names(states, "states"),
        state_merges=tuple(_merge(v, at) for v, at in _entries(states, "states", "merge", ("keep", "with"))),
        state_splits=tuple(
            _split(v, at, "state", named=True)
            for v, at in _entries(states, "states", "split", ("state", "into", "frames", "source"))
        ),
        path_names=_names(paths, "paths"),
        path_merges=tuple(_merge(v, at) for v, at in _entries(paths, "paths", "merge", ("keep", "with"))),
        path_splits=tuple(
            _split(v, at, "path", named=False)
            for v, at in _entries(paths, "paths", "split", ("path", "into", "frames", "source"))
        ),
        phrase_names=tuple(
            PhraseName(_get(v, "frame", int, at), _get(v, "name", str, at), _source(v, at))
            for v, at in _entries(phrases, "phrases", "rename", ("frame", "name", "source"))
        ),
        phrase_merges=tuple(
            PhraseMerge(_get(v, "from", int, at), _get(v, "to", int, at), _source(v, at))
            for v, at in _entries(phrases, "phrases", "merge", ("from", "to", "source"))
        ),
        phrase_splits=tuple(
            PhraseSplit(_get(v, "frame", int, at), _source(v, at))
            for v, at in _entries(phrases, "phrases", "split", ("frame", "source"))
        ),
        file=file,
    )


def _names(section: Mapping[str, Any], place: str) -> dict[str, str]:
    names = _table(section, "rename", f"[{place}]")
    return {label: _get(names, label, str, f"[{place}] rename") for label in names}


def _merge(values: Mapping[str, Any], at: str) -> Merge:
    others: list[Any] = _get(values, "with", list, at)
    if not others or not all(isinstance(o, str) for o in others):
        raise InputError(f"Expected a list of labels in 'with' of {at}, got {others!r}.")
    return Merge(_get(values, "keep", str, at), tuple(others))


def _split(values: Mapping[str, Any], at: str, what: str, *, named: bool) -> Split:
    frames: list[Any] = _get(values, "frames", list, at)
    if not frames or not all(isinstance(f, int) and not isinstance(f, bool) and f >= 0 for f in frames):
        raise InputError(f"Expected a list of frames from 0 in 'frames' of {at}, got {frames!r}.")
    into = _get(values, "into", str, at) if named or "into" in values else None
    return Split(_get(values, what, str, at), into, tuple(frames), _source(values, at))


def _source(values: Mapping[str, Any], at: str) -> int | str:
    """Number or name of a recording."""
    return values["source"] if isinstance(values.get("source"), str) else _get(values, "source", int, at, 0)


def _entries(
    section: Mapping[str, Any], place: str, kind: str, keys: Sequence[str]
) -> list[tuple[Mapping[str, Any], str]]:
    out: list[tuple[Mapping[str, Any], str]] = []
    entries: list[Any] = _get(section, kind, list, f"[{place}]", [])
    for k, entry in enumerate(entries):
        at = f"{place}.{kind}[{k}]"
        if not isinstance(entry, dict):
            raise InputError(f"Expected a table with {', '.join(keys)} at {at}, got {entry!r}.")
        _only(entry, keys, at)
        out.append((entry, at))
    return out


def _only(values: Mapping[str, Any], keys: Sequence[str], at: str, example: str = "") -> None:
    for key in values:
        if key not in keys:
            such = f" For example: {example}" if example else ""
            raise InputError(f"Unknown key '{key}' in {at}. Keys: {', '.join(keys)}.{such}")


def _table(values: Mapping[str, Any], key: str, at: str) -> dict[str, Any]:
    found: dict[str, Any] = _get(values, key, dict, at, {})
    return found


def _get(values: Mapping[str, Any], key: str, kind: type[T], at: str, default: T | None = None) -> T:
    if key not in values:
        if default is not None:
            return default
        raise InputError(f"Expected the key '{key}' in {at}.")
    value = values[key]
    if not isinstance(value, kind) or isinstance(value, bool):
        name = {"dict": "a table", "list": "a list", "str": "a text", "int": "a whole number"}[kind.__name__]
        raise InputError(f"Expected {name} for '{key}' in {at}, got {value!r}.")
    return value
