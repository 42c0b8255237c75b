"""A second process that draws along, so that a report is there sooner where a second core is free.

`kinesics analyze` starts it first of all: it loads the drawing library while the recording is still being read and analysed.
Sheets (`kinesics.report.pictures.Sheet`) are taken from one queue by both processes. They come out the same bytes wherever they
are drawn, and whatever becomes of the second process, this one draws what is left.
"""

from __future__ import annotations

import contextlib
import dataclasses
import os
import pickle
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator, MutableMapping
from typing import IO, TYPE_CHECKING, Final

import kinesics

if TYPE_CHECKING:
    from kinesics.analysis import Analysis
    from kinesics.report.pictures import Sheet

_MOST_FRAMES: Final = 40_000
"""Longer recordings are drawn by one process: the second would need them in memory, too, and drawing is a small part then."""
_PATIENCE_SECONDS: Final = 20.0
"""A process that was stopped by someone must not keep this one waiting for ever; a sheet takes a second or two."""
THREAD: Final = "kinesics-helper"
_PROGRAM: Final = """
import signal
signal.signal(signal.SIGINT, signal.SIG_IGN)
from kinesics.report import helper
helper.serve()
"""


@contextlib.contextmanager
def helping() -> Iterator[Helper | None]:
    """A helper for as long as the context lasts; None where no core is free, or no process can be started."""
    helper = None
    if core_is_free() and not getattr(sys, "frozen", False):
        with contextlib.suppress(OSError):
            helper = Helper()
    try:
        yield helper
    finally:
        if helper is not None:
            helper.end()


def core_is_free() -> bool:
    """Whether a second process finds a core that has nothing else to do: where it does not it takes more than it gives."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    busy = 0.0
    if hasattr(os, "getloadavg"):
        with contextlib.suppress(OSError):
            busy = os.getloadavg()[0]
    return cores > 1 and busy < cores


class Helper:
    """The second process, seen from the first.

    Raises
    ------
    OSError
        If it cannot be started.
    """

    def __init__(self, program: str = _PROGRAM) -> None:
        # -P: what lies in the user's folder is no module of ours. Ctrl-C reaches both processes: the second one is ended by
        # this one, and has nothing to say about it
        self._process = subprocess.Popen(
            [sys.executable, "-P", *(["-I"] if sys.flags.isolated else []), "-c", program],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._thread: threading.Thread | None = None
        self._waiting: deque[Sheet] = deque()

    def draw(
        self,
        analysis: Analysis,
        palette: str,
        waiting: deque[Sheet],
        drawn: MutableMapping[Sheet, tuple[bytes, ...]],
    ) -> None:
        """Begin to take sheets from ``waiting`` and to put them into ``drawn``, while the caller does the same."""
        if sum(s.frames for s in analysis.sources) > _MOST_FRAMES:
            return
        self._waiting = waiting
        # what the grammar holds beside its results is not drawn
        job = (dataclasses.replace(analysis, grammars=()), palette)
        self._thread = threading.Thread(target=self._draw, args=(job, waiting, drawn), name=THREAD, daemon=True)
        self._thread.start()

    def wait(self) -> bool:
        """Wait until the last sheet is drawn; whether one has come back undrawn, to ``waiting``."""
        if self._thread is not None:
            began = time.monotonic()
            while self._thread.is_alive():
                # in short steps: Ctrl-C is not heard while a thread is waited for on Windows
                self._thread.join(0.2)
                if time.monotonic() - began > _PATIENCE_SECONDS:
                    self._process.kill()
            self._thread = None
        return bool(self._waiting)

    def end(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        if self._thread is not None:
            self._thread.join()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError):
                pipe.close()
        self._process.wait()

    def _draw(
        self,
        job: tuple[Analysis, str],
        waiting: deque[Sheet],
        drawn: MutableMapping[Sheet, tuple[bytes, ...]],
    ) -> None:
        """What the thread does that talks with the process."""
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        # whatever happens to the process, the other one draws what is left
        with contextlib.suppress(Exception):
            # another kinesics than this one might draw something else
            if pickle.load(stdout) != _whoami():
                return
            _send(stdin, job)
            while waiting:
                sheet = waiting.popleft()
                try:
                    _send(stdin, sheet)
                    drawn[sheet] = pickle.load(stdout)
                finally:
                    if sheet not in drawn:
                        waiting.append(sheet)


def serve() -> None:
    """What the second process does: draw the sheets that it is sent until there are no more."""
    source, sink = sys.stdin.buffer, sys.stdout.buffer
    # what a library prints must not come between
    sys.stdout = sys.stderr
    from kinesics.report import pictures

    pictures.warm_up()
    _send(sink, _whoami())
    with contextlib.suppress(EOFError):
        analysis, palette = pickle.load(source)
        while True:
            _send(sink, pictures.draw_sheet(analysis, pickle.load(source), palette))


def _whoami() -> tuple[str, str]:
    return os.path.realpath(kinesics.__file__), kinesics.__version__


def _send(pipe: IO[bytes], value: object) -> None:
    pickle.dump(value, pipe, protocol=pickle.HIGHEST_PROTOCOL)
    pipe.flush()
