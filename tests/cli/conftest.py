"""Running the command in this process, and a recording to run it on."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from kinesics.cli.app import run


@dataclass(frozen=True)
class Outcome:
    """What a command left behind."""

    code: int
    out: str
    err: str

    def json(self) -> Any:
        return json.loads(self.out)


Kinesics = Callable[..., Outcome]


@pytest.fixture
def kinesics(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Kinesics:
    """Run a command in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("KINESICS_DEBUG", raising=False)
    monkeypatch.setenv("KINESICS_MIRROR", "http://127.0.0.1:9")
    monkeypatch.setenv("TERMINAL_WIDTH", "80")
    # tests run on all cores as it is; the second process has its own (tests/report/test_helper.py)
    monkeypatch.setattr("kinesics.report.helper.core_is_free", lambda: False)

    def call(*arguments: object) -> Outcome:
        capsys.readouterr()
        code = run([str(a) for a in arguments])
        said = capsys.readouterr()
        return Outcome(code, said.out, said.err)

    return call


@pytest.fixture(scope="session")
def walk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three seconds of walking as a BVH."""
    import kinesics as kx

    path = tmp_path_factory.mktemp("recordings") / "walk.bvh"
    kx.write(kx.performer.walk(seconds=3, fps=30).motion, path)
    return path


@pytest.fixture
def listening() -> Iterator[None]:
    """Ctrl-C reaches this process, also where whoever started it (nohup, a job in the background) had it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
