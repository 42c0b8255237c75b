"""How the command line speaks: remarks and errors on stderr, results on stdout, a bar for work that takes over a second."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, TaskID

_PATIENCE_SECONDS = 1.0


def error(message: str) -> None:
    """The one message of a command that failed."""
    print(f"kinesics: {_printable(message)}", file=sys.stderr)


def remark(message: str) -> None:
    """Something beside the result."""
    print(_printable(message), file=sys.stderr)


def console() -> Console:
    """For results that people read: plain where stdout is not a terminal."""
    from rich.console import Console

    return Console(highlight=False, soft_wrap=True)


def print_json(result: object) -> None:
    """A result for programs, alone on stdout."""
    print(json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False))


def examples(lines: Sequence[tuple[str, str]]) -> str:
    """The examples beneath a command's help: why, and below it what one types, on a line of its own that can be copied."""
    shown = (f"[dim]# {why}[/dim]\n{command}" if why else command for command, why in lines)
    return "[bold]Examples[/bold]\n\n" + "\n\n".join(shown)


def counted(number: int, noun: str) -> str:
    """A number and what it counts: "1 frame", "2 frames"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def escape(text: str) -> str:
    """Text from outside, to be put between rich's own markup."""
    from rich.markup import escape as escape_markup

    return escape_markup(_printable(text))


def _printable(text: str) -> str:
    """File names may hold anything; a terminal should not obey it."""
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


class Bar:
    """A progress bar on stderr, shown only to people and only once the work has taken a second.

    It is a `kinesics.progress.Progress`: ``with Bar("Comparing") as bar: analyze(motion, progress=bar)``.
    """

    def __init__(self, title: str) -> None:
        self._title = title
        self._began = time.monotonic()
        self._bar: Progress | None = None
        self._task: TaskID | None = None

    def __enter__(self) -> Bar:
        """Start the clock."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, fraction: float, message: str = "") -> None:
        """As `kinesics.progress.Progress` asks."""
        if self._bar is None:
            if not sys.stderr.isatty() or time.monotonic() - self._began < _PATIENCE_SECONDS:
                return
            self._bar, self._task = self._start()
        assert self._task is not None
        self._bar.update(
            self._task, completed=fraction, description=f"{self._title}: {message}" if message else self._title
        )

    def part(self, start: float, end: float) -> _Part:
        """A progress for a part of the work, from ``start`` to ``end`` of the whole."""
        return _Part(self, start, end)

    def _start(self) -> tuple[Progress, TaskID]:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        bar.start()
        return bar, bar.add_task(self._title, total=1.0)


class _Part:
    """A stretch of a bar."""

    def __init__(self, bar: Bar, start: float, end: float) -> None:
        self._bar, self._start, self._end = bar, start, end

    def __call__(self, fraction: float, message: str = "") -> None:
        """As `kinesics.progress.Progress` asks."""
        self._bar(self._start + fraction * (self._end - self._start), message)
