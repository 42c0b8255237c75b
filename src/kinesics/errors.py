"""Everything kinesics raises on purpose, and how names are listed in messages. A leaf that anyone may import.

``KinesicsError`` is the root. ``InputError`` is bad input of any kind (a file, an argument): its message names
what was given, what was expected and how to mend it. The command line turns an ``InputError`` into exit code 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike


class KinesicsError(Exception):
    """Root of every error that kinesics raises on purpose."""


class InputError(KinesicsError, ValueError):
    """What the caller gave cannot be used: the message says which, what was expected, what came, how to mend it."""


class FileError(InputError):
    """A file cannot be read as what it should be, or not be written.

    Parameters
    ----------
    path : the file.
    problem : one sentence: what was expected and what came.
    line : 1-based line number, where there is one.
    hint : how to mend it.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        problem: str,
        *,
        line: int | None = None,
        hint: str | None = None,
    ) -> None:
        self.path = str(path)
        self.problem = problem
        self.line = line
        self.hint = hint
        place = f"{self.path}, line {line}" if line is not None else self.path
        super().__init__(f"{place}: {problem}" + (f" {hint}" if hint else ""))

    def __reduce__(self) -> tuple[object, ...]:
        """Keep the parts when the error crosses a process border."""
        return _rebuild_file_error, (self.path, self.problem, self.line, self.hint)


def _rebuild_file_error(path: str, problem: str, line: int | None, hint: str | None) -> FileError:
    return FileError(path, problem, line=line, hint=hint)


class SkeletonError(InputError):
    """A skeleton cannot be understood as a human body.

    Parameters
    ----------
    found : role → joint name, for the links that were recognised.
    missing : the links that were not.
    """

    def __init__(self, message: str, *, found: dict[str, str] | None = None, missing: tuple[str, ...] = ()) -> None:
        self.found = dict(found or {})
        self.missing = missing
        super().__init__(message)


class MissingExtraError(InputError):
    """A feature needs an optional dependency that is not installed; the message has the pip line."""


class Cancelled(KinesicsError):  # noqa: N818 - it is not an error of anyone's
    """The caller asked to stop (see `kinesics.progress`)."""


def some_of(names: Sequence[str], most: int = 4) -> str:
    """Names as they stand in a message: the first few in quotes, and how many more there are."""
    shown = ", ".join(f"'{name}'" for name in names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"
