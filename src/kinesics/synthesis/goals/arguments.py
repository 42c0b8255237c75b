"""What a goal is made from: places, lines and numbers, refused in words where they cannot be meant."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError

Array = NDArray[np.float64]

FAR: Final = 10_000.0
"""Metres; no target lies beyond."""


def as_complex(position: tuple[float, float]) -> complex:
    """A place x, z as z + i·x."""
    return complex(position[1], position[0])


def place_of(position: object, name: str) -> tuple[float, float]:
    """A place, x and z in metres. Raises InputError where ``position`` is none, or lies beyond `FAR`."""
    if type(position) is tuple and len(position) == 2:
        # what something that moves gives, several times at every decision
        x, z = position
        if type(x) is float and type(z) is float and abs(x) <= FAR and abs(z) <= FAR:
            return x, z
    try:
        values = np.asarray(position, dtype=np.float64)
    except (TypeError, ValueError):
        values = np.zeros(0)
    if values.shape != (2,):
        raise InputError(f"Expected the {name} to be two numbers, x and z in metres, got {position!r}.")
    if not np.isfinite(values).all() or np.abs(values).max() > FAR:
        raise InputError(f"Expected the {name} within {FAR:g} m, in finite numbers x and z, got {position!r}.")
    return float(values[0]), float(values[1])


def line_of(points: ArrayLike, name: str, least: int) -> Array:
    """At least ``least`` places, shape (n, 2), x and z in metres, not to be written to. Raises InputError as `place_of`."""
    try:
        line = np.array(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"Expected {name} of shape (n, 2), x and z in metres, got {type(points).__name__}.") from error
    if line.ndim != 2 or line.shape[1] != 2 or len(line) < least:
        raise InputError(f"Expected {name} of shape (n, 2), x and z in metres, n at least {least}, got {line.shape}.")
    bad = ~np.isfinite(line).all(axis=1) | (np.abs(line).max(axis=1) > FAR)
    if bad.any():
        k = int(np.argmax(bad))
        raise InputError(f"Expected {name} in finite numbers within {FAR:g} m; number {k} is {line[k].tolist()}.")
    line.setflags(write=False)
    return line


def is_number(value: object) -> bool:
    """Whether it is one finite number."""
    return (
        isinstance(value, int | float | np.integer | np.floating)
        and not isinstance(value, bool)
        and math.isfinite(value)
    )


def check_positive(value: float, name: str) -> None:
    """Raise InputError unless a finite number above 0."""
    if not (is_number(value) and value > 0.0):
        raise InputError(f"Expected `{name}` above 0, got {value!r}.")


def check_finite(value: float, name: str) -> None:
    """Raise InputError unless a finite number."""
    if not is_number(value):
        raise InputError(f"Expected `{name}` to be a finite number, got {value!r}.")


def check_least(value: float, name: str, unit: str = "") -> None:
    """Raise InputError unless a finite number, 0 or more."""
    if not (is_number(value) and value >= 0.0):
        raise InputError(f"Expected `{name}` of 0 or more{unit and f' {unit}'}, got {value!r}.")


def check_weight(value: float) -> None:
    """Raise InputError unless a finite number, 0 or more."""
    check_least(value, "weight")


def check_name(name: str, what: str) -> None:
    """Raise InputError unless a word or more."""
    if not isinstance(name, str):
        raise InputError(f"Expected the name of {what} as text, got {name!r}.")
    if not name.strip():
        raise InputError(f"Expected the name of {what}, got an empty one.")
