"""Dataclasses to plain JSON values and back, by their type hints."""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Mapping
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from kinesics.errors import InputError
from kinesics.grammar.graph import MotionGraph

T = TypeVar("T")


def encode(value: object) -> Any:
    """Dataclasses to dicts, tuples to lists; a trailing underscore of a field is dropped."""
    if isinstance(value, MotionGraph):
        # what follows from a graph (its notation, its information) is written with it
        return value.to_dict()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name.rstrip("_"): encode(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(k): encode(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [encode(v) for v in value]
    return value


def decode(kind: type[T], value: object, where: str = "") -> T:
    """The dataclass ``kind`` from plain JSON values.

    Parameters
    ----------
    where : place in the file, for messages.

    Raises
    ------
    InputError
        If a key is missing, or a value has the wrong type; the message says where. Unknown keys are passed over, so that a
        file of a later version with additions can be read.
    """
    result: T = _decode(kind, value, where)
    return result


def _decode(kind: Any, value: object, where: str) -> Any:
    origin = get_origin(kind)
    if kind is Any:
        return value
    if kind is MotionGraph:
        if not isinstance(value, dict):
            raise _wrong(where, "an object", value)
        return MotionGraph.from_dict(value)
    if origin in (Union, types.UnionType):
        if value is None:
            return None
        (inner,) = (k for k in get_args(kind) if k is not type(None))
        return _decode(inner, value, where)
    if origin is tuple:
        if not isinstance(value, list):
            raise _wrong(where, "a list", value)
        kinds = get_args(kind)
        if kinds[-1] is Ellipsis:
            return tuple(_decode(kinds[0], v, f"{where}[{i}]") for i, v in enumerate(value))
        if len(value) != len(kinds):
            raise _wrong(where, f"a list of {len(kinds)}", value)
        return tuple(_decode(k, v, f"{where}[{i}]") for i, (k, v) in enumerate(zip(kinds, value, strict=True)))
    if origin is not None and issubclass(origin, Mapping):
        if not isinstance(value, dict):
            raise _wrong(where, "an object", value)
        return value
    if dataclasses.is_dataclass(kind):
        return _decode_dataclass(kind, value, where)
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    # bool is an int to Python, not to JSON
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise _wrong(where, kind.__name__, value)
    return value


def _decode_dataclass(kind: Any, value: object, where: str) -> Any:
    if not isinstance(value, dict):
        raise _wrong(where, "an object", value)
    hints = get_type_hints(kind)
    arguments = {}
    for field in dataclasses.fields(kind):
        key = field.name.rstrip("_")
        if key not in value:
            raise InputError(f"Expected the key '{key}' in {where or 'the analysis'}, found {', '.join(value)}.")
        arguments[field.name] = _decode(hints[field.name], value[key], f"{where}.{key}" if where else key)
    return kind(**arguments)


def _wrong(where: str, expected: str, value: object) -> InputError:
    return InputError(f"Expected {expected} at {where or 'the top'}, got {type(value).__name__}.")
