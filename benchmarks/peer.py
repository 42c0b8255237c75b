"""A rival that lives in the environment of the peers ($KINESICS_PEERS, made by `make bench`), timed in turn with ours."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from types import TracebackType

_LOOP = """
import sys
print("ready", flush=True)
for _ in sys.stdin:
    job()
    print("done", flush=True)
"""


class PeerMissingError(Exception):
    """The peer cannot be measured here; the message says why, in a few words for a table."""


class Peer:
    """A Python process of the peers' environment; calling it runs its ``job`` once and waits.

    Parameters
    ----------
    source : Python text that imports what it needs and defines ``job()``.
    arguments : become ``sys.argv[1:]`` there.
    """

    def __init__(self, source: str, arguments: Sequence[str] = ()) -> None:
        python = os.environ.get("KINESICS_PEERS")
        if not python:
            raise PeerMissingError("not measured: $KINESICS_PEERS is not set (`make bench` sets it)")
        self._process = subprocess.Popen(
            [python, "-c", source + _LOOP, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._wait("ready")

    def __call__(self) -> None:
        """Run the job once."""
        assert self._process.stdin is not None
        self._process.stdin.write("go\n")
        self._process.stdin.flush()
        self._wait("done")

    def _wait(self, word: str) -> None:
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        for line in self._process.stdout:
            if line.strip() == word:
                return
        said = self._process.stderr.read().strip().splitlines()
        raise PeerMissingError(f"not measured: {said[-1] if said else 'it stopped without a word'}")

    def __enter__(self) -> Peer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.communicate()
