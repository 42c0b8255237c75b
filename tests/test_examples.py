"""Every example runs and ends in a picture."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("[0-9]*.py"))


def test_they_are_numbered_without_a_gap() -> None:
    """In the order of learning."""
    assert [int(p.name[:2]) for p in EXAMPLES] == list(range(1, len(EXAMPLES) + 1))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_it_ends_in_a_picture(example: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A PNG of its name, and not an empty one."""
    monkeypatch.setattr("sys.argv", [example.name, str(tmp_path)])
    runpy.run_path(str(example), run_name="__main__")
    picture = (tmp_path / f"{example.stem}.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 10_000
