"""The README does what it says: every block marked ``<!-- run -->`` is run, and every link leads somewhere."""

from __future__ import annotations

import re
import shlex
import tomllib
from pathlib import Path

import pytest

import kinesics as kx
from kinesics.cli.analyze import summarize
from kinesics.cli.app import run

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^<!-- run -->\n```(\w+)\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder with a recording in it."""
    monkeypatch.chdir(tmp_path)
    kx.write(kx.performer.walk(seconds=3, fps=30).motion, "walk.bvh")
    return tmp_path


def test_there_is_something_to_run() -> None:
    """The marker was not lost: blocks of both kinds, and the first screen has one."""
    assert {language for language, _ in BLOCKS} == {"python", "console"}
    assert README.index("<!-- run -->") < 1500


def test_python_blocks_run_one_after_another(folder: Path) -> None:
    """As one reads them, in one session; and again the next day, in the same folder."""
    for _ in range(2):
        session: dict[str, object] = {}
        for language, code in BLOCKS:
            if language == "python":
                exec(compile(code, "README.md", "exec"), session)
    assert (folder / "walk" / "report.html").exists()
    assert (folder / "triangle.png").exists()


def test_commands_run_one_after_another(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each ends well and says something."""
    commands = [line[2:] for language, code in BLOCKS if language == "console" for line in code.splitlines()]
    assert commands
    for command in commands:
        words = shlex.split(command, comments=True)
        assert words[0] == "kinesics"
        assert run(words[1:]) == 0, capsys.readouterr().err
        assert capsys.readouterr().out
    assert (folder / "walk.bvh-kinesics" / "report.html").exists()


def test_what_analyze_is_said_to_print_is_what_it_prints(capsys: pytest.CaptureFixture[str]) -> None:
    """The lines on the jumping jacks."""
    promised = re.findall(r"jumping jacks:\n\n```text\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)[0].splitlines()
    summarize(kx.analyze(kx.performer.jumping_jacks(seconds=6).motion))
    printed = capsys.readouterr().out.splitlines()
    assert [line for line in promised if line not in printed] == []


@pytest.mark.parametrize("page", ["README.md", "ARCHITECTURE.md", "CONVENTIONS.md", "CHANGELOG.md"])
def test_links_within_the_project_lead_somewhere(page: str) -> None:
    """No link to a file that is not there."""
    text = (ROOT / page).read_text(encoding="utf-8")
    targets = [t for t in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in t]
    assert [t for t in targets if not (ROOT / t).exists()] == []


def test_every_make_target_that_is_named_exists() -> None:
    """`make x` in a page is a target of the Makefile."""
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    for page in ROOT.glob("*.md"):
        named = set(re.findall(r"(?:`|\$ )make ([a-z-]+)", page.read_text(encoding="utf-8")))
        assert named <= targets, page.name


def test_the_rules_of_who_may_call_whom_name_every_room() -> None:
    """No room is forgotten: the oracle is closed to all but the command line, and knows none that analyses."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        contracts = tomllib.load(file)["tool"]["importlinter"]["contracts"]
    layers, within, oracle, performer = contracts
    assert within["exhaustive"]  # of synthesis, import-linter itself sees to it
    rooms = {p.parent.name for p in (ROOT / "src" / "kinesics").glob("*/__init__.py")}
    named = {name for layer in layers["layers"] for name in layer.split(" | ")}
    assert rooms <= named
    assert set(oracle["source_modules"]) == {f"kinesics.{r}" for r in rooms - {"cli", "performer"}}
    # report and plotting stand above the performer already
    above = {"cli", "report", "plotting"}
    assert set(performer["forbidden_modules"]) == {
        f"kinesics.{r}" for r in rooms - above - {"performer", "body", "geometry"}
    }


def test_the_version_is_the_same_everywhere() -> None:
    """pyproject.toml, CITATION.cff and the package."""
    assert f'version = "{kx.__version__}"' in (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert f"version: {kx.__version__}" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
