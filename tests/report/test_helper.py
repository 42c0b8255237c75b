"""The second process that draws along: the same report with it, without it, and whatever becomes of it."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO

import pytest

import bodies
import kinesics as kx
from kinesics import report
from kinesics.report import helper as helper_module
from kinesics.report import pictures
from kinesics.report.helper import Helper

_BEGIN = """
import pickle, sys
from kinesics.report import helper
def said(value):
    pickle.dump(value, sys.stdout.buffer)
    sys.stdout.buffer.flush()
def heard():
    return pickle.load(sys.stdin.buffer)
"""
FAILING = {
    "does not begin": "import sys; sys.exit(3)",
    "is another kinesics": _BEGIN + "said(('elsewhere', '9'))\nheard()",
    "talks nonsense": "print('nonsense', flush=True)\nimport time; time.sleep(60)",
    "dies before its first sheet": _BEGIN + "said(helper._whoami())\nheard()\nsys.exit(3)",
    "dies over a sheet": _BEGIN + "said(helper._whoami())\nheard(), heard()\nsys.exit(3)",
    "dies over its second sheet": _BEGIN
    + "said(helper._whoami())\nheard()\nsaid((str(heard()).encode(),) * 2)\nheard()\nsys.exit(3)",
}


@pytest.fixture(scope="module")
def analysis() -> kx.Analysis:
    """A few seconds of walking, that all sheets can be drawn of."""
    return kx.analyze(kx.performer.walk(seconds=3, fps=30).motion)


@pytest.fixture
def sketched(analysis: kx.Analysis, monkeypatch: pytest.MonkeyPatch) -> pictures.Pictures:
    """What one process draws, if each sheet bears but its name; it begins when the second one has taken a sheet or is gone."""
    taken = threading.Event()

    def send(pipe: IO[bytes], value: object) -> None:
        sending(pipe, value)
        if isinstance(value, pictures.Sheet):
            taken.set()

    def sketch(_: kx.Analysis, sheet: pictures.Sheet, *__: object) -> tuple[bytes, ...]:
        while not taken.is_set() and any(t.name == helper_module.THREAD for t in threading.enumerate()):
            time.sleep(0.01)
        return (str(sheet).encode(),) * 2

    sending = helper_module._send
    monkeypatch.setattr(helper_module, "_send", send)
    monkeypatch.setattr(pictures, "draw_sheet", sketch)
    return pictures.draw(analysis)


@pytest.fixture
def start() -> Iterator[Callable[[str], Helper]]:
    """Begin a second process that runs a program; all are ended."""
    begun: list[Helper] = []

    def begin(program: str) -> Helper:
        begun.append(Helper(program))
        return begun[-1]

    yield begin
    for helper in begun:
        helper.end()
        assert helper._process.poll() is not None


def test_two_processes_draw_the_same_as_one(analysis: kx.Analysis, monkeypatch: pytest.MonkeyPatch) -> None:
    """Byte for byte, and the second process does take its part."""
    monkeypatch.setattr(helper_module, "core_is_free", lambda: True)
    alone = pictures.draw(analysis)
    mine: list[pictures.Sheet] = []
    with report.helping() as helper:
        assert helper is not None

        def watched(*arguments: object, **named: object) -> tuple[bytes, ...]:
            # until the other one is ready, this one does nothing
            if not mine and helper._thread is not None:
                helper._thread.join()
            mine.append(arguments[1])  # type: ignore[arg-type]
            return drawing(*arguments, **named)  # type: ignore[arg-type]

        drawing = pictures.draw_sheet
        monkeypatch.setattr(pictures, "draw_sheet", watched)
        assert pictures.draw(analysis, helper=helper) == alone
    assert len(mine) == 1
    assert helper._process.poll() is not None


@pytest.mark.parametrize("failing", list(FAILING))
def test_a_helper_that_fails_costs_nothing_but_time(
    failing: str, analysis: kx.Analysis, sketched: pictures.Pictures, start: Callable[[str], Helper]
) -> None:
    """What it had taken comes back and is drawn here."""
    helper = start(FAILING[failing])
    assert pictures.draw(analysis, helper=helper) == sketched


def test_a_helper_that_hangs_is_not_waited_for_long(
    analysis: kx.Analysis, sketched: pictures.Pictures, start: Callable[[str], Helper], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is ended after a while, and its sheet is drawn here."""
    monkeypatch.setattr(helper_module, "_PATIENCE_SECONDS", 0.3)
    hangs = start(_BEGIN + "said(helper._whoami())\nheard()\nheard()\nimport time\ntime.sleep(600)")
    assert pictures.draw(analysis, helper=hangs) == sketched


@pytest.mark.parametrize(
    ("cores", "busy", "free"), [(1, 0.0, False), (2, 0.3, True), (2, 2.5, False), (8, 2.5, True), (8, 9.0, False)]
)
def test_a_second_process_needs_a_core_of_its_own(
    cores: int, busy: float, free: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a machine that has one, or whose cores are all at work, it would only take from the first."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(cores)), raising=False)
    monkeypatch.setattr(os, "getloadavg", lambda: (busy, 0.0, 0.0), raising=False)
    assert helper_module.core_is_free() == free


def test_where_nothing_says_how_busy_it_is_the_cores_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """As on Windows."""
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.delattr(os, "getloadavg", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 4)
    assert helper_module.core_is_free()
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert not helper_module.core_is_free()


def test_there_is_none_without_a_free_core_nor_for_a_frozen_program(monkeypatch: pytest.MonkeyPatch) -> None:
    """A frozen program would start itself."""
    monkeypatch.setattr(helper_module, "core_is_free", lambda: False)
    with report.helping() as helper:
        assert helper is None
    monkeypatch.setattr(helper_module, "core_is_free", lambda: True)
    monkeypatch.setattr("sys.frozen", True, raising=False)
    with report.helping() as helper:
        assert helper is None


def test_where_no_process_can_be_started_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawing goes on without."""
    monkeypatch.setattr(helper_module, "core_is_free", lambda: True)
    monkeypatch.setattr("sys.executable", "/no/such/python")
    with report.helping() as helper:
        assert helper is None


def test_long_recordings_are_not_sent(
    analysis: kx.Analysis, sketched: pictures.Pictures, start: Callable[[str], Helper], monkeypatch: pytest.MonkeyPatch
) -> None:
    """They would be in memory twice."""
    monkeypatch.setattr(helper_module, "_MOST_FRAMES", 10)
    helper = start(helper_module._PROGRAM)
    assert pictures.draw(analysis, helper=helper) == sketched
    assert helper._thread is None


def test_stopping_ends_both_and_leaves_nothing(
    analysis: kx.Analysis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C while both draw: no second process is left, no file, and what was there is as it was."""
    monkeypatch.setattr(helper_module, "core_is_free", lambda: True)
    target = tmp_path / "walk-kinesics"
    kx.save(kx.analyze(bodies.arms_swinging(60)), target)
    before = {p.name: p.read_bytes() for p in target.iterdir()}

    def interrupt(fraction: float, message: str = "") -> None:
        if fraction > 0.0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), report.helping() as helper:
        kx.save(analysis, target, overwrite=True, progress=interrupt, helper=helper)
    assert helper is not None
    assert helper._process.poll() is not None
    assert not helper._thread or not helper._thread.is_alive()
    assert os.listdir(tmp_path) == [target.name]
    assert {p.name: p.read_bytes() for p in target.iterdir()} == before
