"""Performing from all kinds of recordings for all kinds of wishes: a sample of `benchmarks/sweep_synthesis.py`."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"

NEVER = ("floor", "file", "again", "command line", "not finite", "warned")
"""Beyond which nothing may be, whatever the recordings."""


@pytest.fixture(scope="module")
def sweep() -> ModuleType:
    """The script as a module; it finds its neighbours as it does when it is run."""
    spec = importlib.util.spec_from_file_location("sweep_synthesis", BENCHMARKS / "sweep_synthesis.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(BENCHMARKS))
    try:
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(BENCHMARKS))
    return module


def grave(sweep: ModuleType, row: dict[str, Any]) -> dict[str, Any]:
    """What is so far beyond a line that no close call explains it: of the few contacts of a short movement one is 2 %."""
    values, lines = row["values"], {name: 1.5 * line for name, (line, _) in sweep.LINES.items()} | {"slides": 0.05}
    return {k: v for k, v in row["beyond"].items() if k in NEVER or values.get(k, 1.0) > lines.get(k, 0.0)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("recordings")


@pytest.mark.parametrize("which", ["performer/7", "performer together/4", "performer together/5", "states/1"])
def test_performed_bodies_are_performed_well(sweep: ModuleType, folder: Path, which: str) -> None:
    """Feet, floor, D, ranges, depth, leaps, provenance; written and read again; the same once more."""
    group, number = which.split("/")
    row = sweep.perform(sweep.case(group, int(number), 1), folder)
    assert row["outcome"] == "performed", row["told"]
    assert grave(sweep, row) == {}


@pytest.mark.parametrize(
    "which", ["cmu/3", "cmu together/3", "bandai/3", "bandai together/4", "bandai gaits/1", "mixed/6", "far/5"]
)
def test_recordings_are_performed_well(sweep: ModuleType, folder: Path, shared_data: Path, which: str) -> None:
    """The same of real ones."""
    group, number = which.split("/")
    row = sweep.perform(sweep.case(group, int(number), 1), folder)
    assert row["outcome"] == "performed", row["told"]
    assert grave(sweep, row) == {}


def test_a_case_is_the_same_for_the_same_number(sweep: ModuleType) -> None:
    """So that a row can be done again."""
    assert sweep.case("performer", 7, 1) == sweep.case("performer", 7, 1) != sweep.case("performer", 7, 2)


@pytest.mark.long
@pytest.mark.parametrize("group", ["performer", "performer together", "states"])
def test_nothing_breaks(sweep: ModuleType, folder: Path, group: str) -> None:
    """No defect, nothing below the floor, files that hold what was performed, the same for the same seed."""
    _nothing_breaks(sweep, folder, group)


@pytest.mark.long
@pytest.mark.parametrize("group", ["cmu", "cmu together", "bandai", "bandai together", "bandai gaits", "mixed", "far"])
def test_nothing_breaks_with_recordings(sweep: ModuleType, folder: Path, shared_data: Path, group: str) -> None:
    """The same of real ones."""
    _nothing_breaks(sweep, folder, group)


def _nothing_breaks(sweep: ModuleType, folder: Path, group: str) -> None:
    rows = [sweep.perform(sweep.case(group, number, 2), folder) for number in range(20)]
    assert [row["told"] for row in rows if row["outcome"] == "defect"] == []
    assert [(row["id"], row["beyond"]) for row in rows if set(NEVER) & set(row.get("beyond", {}))] == []
