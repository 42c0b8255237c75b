"""What the benchmarks share: a table, a clock that times rivals in turn, and where the real recordings are.

A benchmark is ``bench_<topic>.py`` with a docstring that says what is measured, and ends in ``main(run)``, where ``run``
gives its tables. It prints them, and with ``--json FILE`` writes them for `run.py`, which puts them into RESULTS.md.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Table:
    """A small table: all cells are text."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    notes: Sequence[str] = ()

    def markdown(self) -> str:
        """As it stands in RESULTS.md."""
        lines = [
            f"**{self.title}**",
            "",
            "| " + " | ".join(self.columns) + " |",
            "| " + " | ".join("---" for _ in self.columns) + " |",
            *("| " + " | ".join(str(cell) for cell in row) + " |" for row in self.rows),
        ]
        return "\n".join(lines + (["", *self.notes] if self.notes else [])) + "\n"

    def text(self) -> str:
        """As it is printed."""
        cells = [[str(c) for c in row] for row in (self.columns, *self.rows)]
        widths = [max(len(row[k]) for row in cells) for k in range(len(self.columns))]
        lines = ["  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in cells]
        return "\n".join([self.title, "", lines[0], "  ".join("-" * w for w in widths), *lines[1:], *self.notes]) + "\n"


def in_turn(rivals: Mapping[str, Callable[[], object]], repeats: int = 5) -> dict[str, float]:
    """Median seconds of each rival, timed one after another in every round, so that a busy machine is busy for all."""
    samples: dict[str, list[float]] = {name: [] for name in rivals}
    for call in rivals.values():
        call()
    for _ in range(repeats):
        for name, call in rivals.items():
            time.sleep(0.2)  # the idle threads of some libraries spin for a while and would slow whoever comes next
            began = time.perf_counter()
            call()
            samples[name].append(time.perf_counter() - began)
    return {name: statistics.median(got) for name, got in samples.items()}


def data_folder() -> Path | None:
    """The real recordings: $KINESICS_DATA, or ../shared/data beside the project; None where they are not."""
    named = os.environ.get("KINESICS_DATA")
    folder = Path(named) if named else Path(__file__).resolve().parents[2] / "shared" / "data"
    return folder if folder.is_dir() else None


_LAUNCHER = """
import json, os, subprocess, sys, time
began = time.perf_counter()
child = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL)
_, status, usage = os.wait4(child.pid, 0)
child.returncode = os.waitstatus_to_exitcode(status)
seconds = time.perf_counter() - began
print(json.dumps([child.returncode, seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss]))
"""


def measure(
    arguments: Sequence[str], folder: str, environment: Mapping[str, str] | None = None
) -> tuple[float, float, float]:
    """Wall seconds, seconds of processor time and peak MB of one run of a command, as a process of its own."""
    # a child is said to have held at least what its parent held when it began: so a small parent begins it
    launched = subprocess.run(
        [sys.executable, "-S", "-c", _LAUNCHER, *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    said = json.loads(launched.stdout) if launched.returncode == 0 else [launched.returncode, 0.0, 0.0, 0]
    code, seconds, processor, peak = said
    if code != 0:
        raise SystemExit(f"{' '.join(arguments)}: exit {code}\n{launched.stderr}")
    return seconds, processor, peak / (2**20 if sys.platform == "darwin" else 2**10)


def main(
    run: Callable[[], Sequence[Table]],
    arguments: Sequence[str] | None = None,
    *,
    parts: Mapping[str, Callable[[], Sequence[Table]]] | None = None,
) -> None:
    """Print the tables of a benchmark; with ``--json FILE`` write them too; with ``--only PART``, where it has parts, only
    those of one.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("--json", type=Path, metavar="FILE")
    if parts:
        parser.add_argument("--only", choices=[*parts], metavar="PART", help=", ".join(parts))
    told = parser.parse_args(arguments)
    tables = parts[told.only]() if parts and told.only else run()
    for table in tables:
        print(table.text())
    if told.json:
        told.json.write_text(
            json.dumps([dataclasses.asdict(t) for t in tables], ensure_ascii=False, indent=1), encoding="utf-8"
        )
