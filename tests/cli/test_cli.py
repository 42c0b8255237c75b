"""The command line: exit codes, what goes where, and that nothing half-written is left."""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import typer

import kinesics as kx
from kinesics import report
from kinesics.cli import analyze, convert, data, demo, info, perform, terminal
from kinesics.cli.app import app

from .conftest import Kinesics

COMMANDS = (
    *([], ["demo"], ["info"], ["analyze"], ["perform"], ["convert"]),
    *(["data"], ["data", "list"], ["data", "fetch"]),
)
EXAMPLES = [
    line
    for lines in (
        *(told.EXAMPLES for told in (demo, info, analyze, perform, convert)),
        *(data.LIST_EXAMPLES, data.FETCH_EXAMPLES),
    )
    for line, _ in lines
]


def files(folder: Path) -> set[str]:
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.parametrize("command", COMMANDS, ids=lambda c: " ".join(c) or "kinesics")
def test_help_fits_a_terminal_of_80_columns_and_shows_examples(kinesics: Kinesics, command: list[str]) -> None:
    """Every command explains itself, within 80 columns, with examples."""
    got = kinesics(*command, "--help")
    assert got.code == 0
    assert max(len(line) for line in got.out.splitlines()) <= 80
    if command not in ([], ["data"]):
        assert "Examples" in got.out
        assert "kinesics " + " ".join(command) in got.out.split("Examples")[1]


@pytest.mark.parametrize("line", EXAMPLES)
def test_an_example_stands_whole_on_a_line_of_its_own(kinesics: Kinesics, line: str) -> None:
    """So that it can be copied from a terminal of 80 columns."""
    words = line.split()[1:]
    shown = kinesics(*words[: 2 if words[0] == "data" else 1], "--help").out
    assert line in [part.strip() for part in shown.splitlines()]


@pytest.mark.parametrize("line", EXAMPLES)
def test_examples_are_calls_that_the_commands_take(line: str) -> None:
    """Every option and argument in the examples beneath a command's help is one of its own."""
    name, *words = shlex.split(line)
    assert name == "kinesics"
    command = typer.main.get_command(app)
    while hasattr(command, "commands"):
        command = command.commands[words.pop(0)]
    command.make_context(line, words).close()


@pytest.mark.parametrize(("given", "native", "threads"), [(None, "0", "1"), ("3", "0", "3"), (None, "1", None)])
def test_numpy_leaves_the_cores_to_the_kernels(
    given: str | None, native: str, threads: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its products have one thread, unless the user says otherwise or NumPy does all the work."""
    import kinesics.cli
    from kinesics import compiled

    monkeypatch.setenv("OPENBLAS_NUM_THREADS", given or "")
    if given is None:
        monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    monkeypatch.setenv("KINESICS_NO_NATIVE", native)
    monkeypatch.delenv("KINESICS_KERNEL", raising=False)
    with pytest.raises(SystemExit):
        kinesics.cli.main(["--version"])
    if compiled.native is not None:
        assert os.environ.get("OPENBLAS_NUM_THREADS") == threads


def test_version(kinesics: Kinesics) -> None:
    """The version, alone."""
    assert kinesics("--version").out == f"kinesics {kx.__version__}\n"


@pytest.mark.parametrize(
    "call",
    [
        ["nothing"],
        ["analyze"],
        ["analyze", "x.bvh", "--beta", "much"],
        ["convert", "x.bvh"],
        ["info", "x.bvh", "--colour"],
        ["perform", "x.bvh"],
        ["data", "fetch"],
    ],
    ids=" ".join,
)
def test_a_wrong_call_is_2_and_says_so_on_stderr(kinesics: Kinesics, call: list[str]) -> None:
    """Unknown commands and options, missing and unusable arguments."""
    got = kinesics(*call)
    assert got.code == 2
    assert got.out == ""
    assert "Error" in got.err


@pytest.mark.parametrize("command", ["info", "analyze", "convert"])
@pytest.mark.parametrize("kind", ["missing", "folder", "empty", "rubbish", "cut"])
def test_a_bad_file_is_one_message_on_stderr(
    kinesics: Kinesics, walk: Path, tmp_path: Path, command: str, kind: str
) -> None:
    """Exit 2, the file's name, one message, no traceback, nothing on stdout, nothing written."""
    bad = tmp_path / "bad.bvh"
    if kind == "folder":
        bad.mkdir()
    elif kind == "empty":
        bad.write_bytes(b"")
    elif kind == "rubbish":
        bad.write_bytes(bytes(range(256)) * 20)
    elif kind == "cut":
        bad.write_bytes(walk.read_bytes()[:2000])
    before = files(tmp_path)
    got = kinesics(command, "bad.bvh", *(["out.bvh"] if command == "convert" else []))
    assert got.code == 2
    assert got.out == ""
    assert got.err.startswith("kinesics: ")
    assert got.err.count("bad.bvh") >= 1
    assert got.err.count("kinesics: ") == 1
    assert "Traceback" not in got.err
    assert files(tmp_path) == before


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--fps", "0", "fps"),
        ("--beta", "-1", "β"),
        ("--unit", "furlong", "furlong"),
        ("--unit", "1e-9", "the unit is wrong"),
        ("--unit", "1e300", "beyond any length"),
        ("--up", "w", "w"),
        ("--map", "no.toml", "no.toml"),
    ],
)
def test_an_unusable_option_is_named(kinesics: Kinesics, walk: Path, option: str, value: str, says: str) -> None:
    """Values that cannot be: exit 2 and the value in the message."""
    got = kinesics("analyze", walk, option, value)
    assert got.code == 2
    assert says in got.err
    assert "Traceback" not in got.err


def test_info_tells_what_a_file_is(kinesics: Kinesics, walk: Path) -> None:
    """For people: format, length, and which joint is what."""
    got = kinesics("info", walk)
    assert got.code == 0
    assert "90 frames at 30 fps: 3.00 s" in got.out
    assert re.search(r"left_femur\s+\S", got.out)
    assert got.err == ""


def test_info_as_json(kinesics: Kinesics, walk: Path) -> None:
    """For programs: the same, alone on stdout."""
    got = kinesics("info", walk, "--json")
    facts = got.json()
    assert facts["frames"] == 90
    assert facts["fps"] == pytest.approx(30)
    assert facts["format"] == "bvh"
    assert facts["not_understood"] is None
    assert facts["body"]["parts"]["head"] in facts["joints"]


def test_info_of_several_files(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """One after another, as a list for programs; a bad one among them is one message and nothing on stdout."""
    kx.write(kx.read(walk)[10:40], tmp_path / "part.bvh")
    said = kinesics("info", walk, "part.bvh").out
    assert said.index("walk.bvh") < said.index("90 frames") < said.index("part.bvh") < said.index("30 frames")
    facts = kinesics("info", walk, "part.bvh", "--json").json()
    assert [(f["name"], f["frames"]) for f in facts] == [("walk.bvh", 90), ("part.bvh", 30)]
    got = kinesics("info", walk, "missing.bvh")
    assert (got.code, got.out) == (2, "")
    assert "missing.bvh" in got.err


DOG = """HIERARCHY
ROOT Body
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Tail
  {
    OFFSET 0 0 -30
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 0 -20
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.01
0 40 0 0 0 0 0 0 0
0 40 0 0 0 0 0 10 0
"""


def test_info_says_why_a_skeleton_is_not_understood(kinesics: Kinesics, tmp_path: Path) -> None:
    """Not a human body: the file is described all the same, with what is missing."""
    (tmp_path / "dog.bvh").write_text(DOG)
    got = kinesics("info", "dog.bvh")
    assert got.code == 0
    assert "not understood" in got.out
    assert "left_femur" in got.out
    facts = kinesics("info", "dog.bvh", "--json").json()
    assert facts["body"] is None
    assert "left_femur" in facts["not_understood"]["missing"]


def test_analyze_refuses_a_skeleton_that_is_not_understood(kinesics: Kinesics, tmp_path: Path) -> None:
    """Exit 2, and the way out (--map) named."""
    (tmp_path / "dog.bvh").write_text(DOG)
    got = kinesics("analyze", "dog.bvh")
    assert got.code == 2
    assert "--map" in got.err
    assert files(tmp_path) == {"dog.bvh"}


def test_a_mapping_file_is_used(kinesics: Kinesics, tmp_path: Path, walk: Path) -> None:
    """Joints under names that say nothing become known by the user's word; wrong ones are refused by name."""
    motion = kx.read(walk)
    names = tuple(f"b{k:02d}" for k in range(motion.skeleton.joint_count))
    kx.write(motion.replace(skeleton=motion.skeleton.replace(joint_names=names)), tmp_path / "bare.bvh")
    parts = kinesics("info", walk, "--json").json()["body"]["parts"]
    index = dict(zip(motion.skeleton.joint_names, names, strict=True))
    chosen = {
        r: index[j] for r, j in parts.items() if r.split("_")[-1] in ("femur", "tibia", "humerus", "radius", "head")
    }
    (tmp_path / "map.toml").write_text("[joints]\n" + "".join(f'{r} = "{j}"\n' for r, j in chosen.items()))
    facts = kinesics("info", "bare.bvh", "--map", "map.toml", "--json").json()
    assert {r: facts["body"]["parts"][r] for r in chosen} == chosen
    (tmp_path / "map.toml").write_text('[joints]\nleft_femur = "nowhere"\n')
    got = kinesics("info", "bare.bvh", "--map", "map.toml")
    assert got.code == 2
    assert "nowhere" in got.err
    (tmp_path / "map.toml").write_text("left_femur = \n")
    assert "map.toml" in kinesics("info", "bare.bvh", "--map", "map.toml").err


def test_analyze_leaves_a_report_beside(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """FILE-kinesics in the current folder; stdout says where; a second time it is replaced."""
    for _ in range(2):
        got = kinesics("analyze", walk)
        assert got.code == 0, got.err
        assert got.out.rstrip().endswith(str(Path("walk.bvh-kinesics/report.html")))
    assert {f"walk.bvh-kinesics/{name}" for name in report.FILES} == files(tmp_path)


def test_analyze_says_what_it_is(kinesics: Kinesics, walk: Path) -> None:
    """Class, period and how sure in words, the motion graph in its notation."""
    said = kinesics("analyze", walk).out
    assert "Like walking: cyclic, left and right in turn (p11g), " in said
    assert "s a cycle" in said
    assert "%)" in said
    assert "motion graph: 2 states, 2 paths" in said
    assert "A aa*₁→ A* (aa*₁)*→" in said


def test_a_frozen_recording_is_told(kinesics: Kinesics, tmp_path: Path, walk: Path) -> None:
    """One frame many times over: it looks wrong, and no moment of it is the fastest."""
    motion = kx.read(walk)
    frozen = motion.replace(rotations=motion.rotations[[0] * 90], root_positions=motion.root_positions[[0] * 90])
    kx.write(frozen, tmp_path / "frozen.bvh")
    assert "Nothing moves" in kinesics("info", tmp_path / "frozen.bvh").out
    got = kinesics("analyze", tmp_path / "frozen.bvh", "--out", tmp_path / "frozen")
    assert got.code == 0
    assert "doubtful: Nothing moves" in got.out
    assert "fastest" not in got.out


def test_analyze_as_json_writes_nothing(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """The result alone on stdout, valid by the shipped schema; files only with --out."""
    got = kinesics("analyze", walk, "--json")
    assert got.code == 0
    jsonschema.validate(got.json(), report.schema())
    assert files(tmp_path) == set()
    got = kinesics("analyze", walk, "--json", "--out", "here")
    assert got.json()["sources"][0]["name"] == "walk.bvh"
    assert (tmp_path / "here" / "analysis.json").exists()


def test_beta_is_taken_and_stored(kinesics: Kinesics, walk: Path) -> None:
    """What the user says of the contrast stands in the result."""
    assert kinesics("analyze", walk, "--beta", "12.5", "--json").json()["beta"] == 12.5


def test_fps_is_taken(kinesics: Kinesics, walk: Path) -> None:
    """A file's frame rate can be overridden."""
    assert kinesics("analyze", walk, "--fps", "60", "--json").json()["sources"][0]["fps"] == 60


def test_a_side_file_is_honoured(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """Beside the recording or named; that it was found is said, and a wrong one is a message that names it."""
    here = tmp_path / "mine.bvh"
    here.write_bytes(walk.read_bytes())
    side = tmp_path / "mine.bvh.edits.toml"
    side.write_text("phrases.rename = [ { frame = 5, name = 'a stroll' } ]", encoding="utf-8")
    found = kinesics("analyze", here, "--json")
    assert found.json()["phrases"][0]["name"] == "a stroll"
    assert "mine.bvh.edits.toml" in found.err
    other = tmp_path / "other.toml"
    other.write_text("phrases.rename = [ { frame = 5, name = 'a march' } ]", encoding="utf-8")
    assert kinesics("analyze", here, "--json", "--edits", other).json()["phrases"][0]["name"] == "a march"
    other.write_text("phrase = 3", encoding="utf-8")
    wrong = kinesics("analyze", here, "--edits", other)
    assert wrong.code == 2
    assert "other.toml" in wrong.err
    assert "Unknown key 'phrase'" in wrong.err
    assert kinesics("analyze", here, "--edits", tmp_path / "none.toml").code == 2


def test_several_files_are_one_analysis(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """Each file becomes a source."""
    kx.write(kx.read(walk)[10:40], tmp_path / "part.bvh")
    got = kinesics("analyze", walk, "part.bvh", "--json").json()
    assert [(s["name"], s["frames"]) for s in got["sources"]] == [("walk.bvh", 90), ("part.bvh", 30)]


def test_whose_cycles_and_whose_doubts_is_told(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """Of two recordings: a table of the cycles of each, and every doubt with its recording."""
    jacks = kx.performer.jumping_jacks(seconds=5, fps=30, seed=0).motion
    places = jacks.root_positions.copy()
    places[60] += 1.0
    kx.write(jacks.replace(root_positions=places), tmp_path / "leap.bvh")
    kx.write(jacks, tmp_path / "jacks.bvh")
    analysis = kinesics("analyze", "jacks.bvh", "leap.bvh", "--out", "two")
    lines = analysis.out.splitlines()
    facts = kx.load(tmp_path / "two")
    (top,) = [k for k, line in enumerate(lines) if line.split()[:2] == ["cycles", "of"]]
    for line, number in zip(lines[top + 1 :], dict.fromkeys(c.phrase for c in facts.cycles), strict=False):
        name, phrase, count = line.split()[:3]
        assert (phrase, int(count)) == (str(number + 1), sum(c.phrase == number for c in facts.cycles))
        assert name == facts.sources[facts.phrases[number].source].name
    doubts = [line.split("doubtful: ")[1] for line in lines if "doubtful: " in line]
    assert doubts == list(facts.warnings)
    assert any(d.startswith("leap.bvh: ") for d in doubts)
    page = (tmp_path / "two" / "report.html").read_text(encoding="utf-8")
    assert '<li class="warning">leap.bvh: ' in page
    assert "cycles of" not in kinesics("analyze", "jacks.bvh").out


def test_several_files_share_a_folder_that_says_so(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """Named after the first and how many more there are: it is not that of the first alone."""
    for name in ("part.bvh", "rest.bvh"):
        kx.write(kx.read(walk)[10:40], tmp_path / name)
    assert "walk.bvh-and-2-more-kinesics" in kinesics("analyze", walk, "part.bvh", "rest.bvh").out
    assert (tmp_path / "walk.bvh-and-2-more-kinesics" / "analysis.json").is_file()
    assert not (tmp_path / "walk.bvh-kinesics").exists()


def test_the_palette_is_chosen(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """For the colour-blind, orange and blue; the page says so."""
    assert kinesics("analyze", walk, "--palette", "colorblind").code == 0
    page = (tmp_path / "walk.bvh-kinesics" / "report.html").read_text(encoding="utf-8")
    assert "Orange: the same pose" in page
    assert "cyan" not in page
    assert "colorblind" in kinesics("analyze", "--help").out


@pytest.mark.parametrize("palette", ["grey", "sepia"])
def test_a_palette_that_cannot_show_both_is_refused(
    kinesics: Kinesics, walk: Path, palette: str, tmp_path: Path
) -> None:
    """Unknown, or of one colour for Z and Z*: before the work, with the names that are left."""
    got = kinesics("analyze", walk, "--palette", palette)
    assert got.code == 2
    assert f"'{palette}'" in got.err
    assert "thesis, colorblind" in got.err
    assert files(tmp_path) == set()


def test_the_folder_of_something_else_is_left_alone(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """Neither other files nor the analysis of another recording are replaced, unless --overwrite."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work")
    got = kinesics("analyze", walk, "--out", "mine")
    assert got.code == 2
    assert "--overwrite" in got.err
    assert files(tmp_path) == {"mine/thesis.txt"}
    assert kinesics("analyze", walk, "--out", "mine", "--overwrite").code == 0
    assert (tmp_path / "mine" / "thesis.txt").read_text() == "years of work"


def test_convert_keeps_the_movement(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """BVH to ASF/AMC and back: positions to a millionth; stdout names the file."""
    assert kinesics("convert", walk, "walk.amc").code == 0
    assert (tmp_path / "walk.asf").exists()
    got = kinesics("convert", "walk.amc", "again.bvh")
    assert got.code == 0
    assert got.out == "again.bvh\n"
    first, again = kx.read(walk), kx.read(tmp_path / "again.bvh")
    common = [n for n in first.skeleton.joint_names if n in again.skeleton.joint_names]
    assert len(common) >= 15
    there = first.positions()[:, [first.skeleton.find(n) for n in common]]
    here = again.positions()[:, [again.skeleton.find(n) for n in common]]
    assert np.abs(there - here).max() < 1e-6


def test_convert_does_not_overwrite_unasked(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """A file that is there stays, and the recording itself stays whatever is asked."""
    (tmp_path / "there.bvh").write_text("mine")
    got = kinesics("convert", walk, "there.bvh")
    assert got.code == 2
    assert "--overwrite" in got.err
    assert (tmp_path / "there.bvh").read_text() == "mine"
    assert kinesics("convert", walk, "there.bvh", "--overwrite").code == 0
    got = kinesics("convert", "there.bvh", "there.bvh", "--overwrite")
    assert got.code == 2
    assert kx.read(tmp_path / "there.bvh").frame_count == 90


def test_convert_to_an_unknown_format_lists_the_known(kinesics: Kinesics, walk: Path) -> None:
    """The suffix decides; a wrong one is answered with those there are."""
    got = kinesics("convert", walk, "walk.xyz")
    assert got.code == 2
    assert ".bvh" in got.err


def test_demo_runs_and_can_be_run_again(kinesics: Kinesics, tmp_path: Path) -> None:
    """The main job without a recording; a second run replaces its own report."""
    for _ in range(2):
        got = kinesics("demo", "--movement", "walk")
        assert got.code == 0, got.err
        assert got.out.rstrip().endswith(str(Path("demo-kinesics/report.html")))
    assert (tmp_path / "demo-kinesics" / "zz.png").exists()


def test_demo_lists_the_movements(kinesics: Kinesics) -> None:
    """A wrong name is answered with the right ones."""
    got = kinesics("demo", "--movement", "flying")
    assert got.code == 2
    assert "walk" in got.err


def test_data_list_has_terms(kinesics: Kinesics) -> None:
    """Sets, homes and terms, for people and for programs."""
    got = kinesics("data", "list")
    assert got.code == 0
    assert "butterfly" in got.out
    assert "may not be resold" in got.out
    assert {"cmu", "bandai-namco"} <= {c["name"] for c in kinesics("data", "list", "--json").json()["collections"]}


def test_data_fetch_without_a_network(kinesics: Kinesics, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Exit 2, one message, what to do."""
    monkeypatch.setattr("kinesics.datasets.download._RETRIES", 0)
    got = kinesics("data", "fetch", "07_01", "--to", "here")
    assert got.code == 2
    assert "Check the network" in got.err
    assert files(tmp_path) == set()


def test_a_defect_is_1_with_a_short_message(kinesics: Kinesics, walk: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What we did not foresee: no traceback unless asked for, and the request to report it."""

    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr("kinesics.analysis.analyze", broken)
    got = kinesics("analyze", walk)
    assert got.code == 1
    assert "report it" in got.err
    assert "Traceback" not in got.err
    assert "Traceback" in kinesics("--debug", "analyze", walk).err


def test_a_full_disk_or_a_forbidden_folder_is_not_a_defect(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """The system's own reasons are told in one sentence."""
    (tmp_path / "file").write_text("")
    got = kinesics("analyze", walk, "--out", "file/inside")
    assert got.code == 2
    assert "file" in got.err
    assert "Traceback" not in got.err


def test_one_frame_is_not_told_as_frames(kinesics: Kinesics, walk: Path) -> None:
    """A photograph of a movement has "1 frame"."""
    kx.write(kx.read(walk)[7], "moment.bvh")
    assert "1 frame at 30 fps" in kinesics("info", "moment.bvh").out
    assert "90 frames at 30 fps" in kinesics("info", walk).out


def test_names_from_outside_cannot_command_the_terminal(kinesics: Kinesics, tmp_path: Path, walk: Path) -> None:
    """Escape sequences in file names are shown, not obeyed; brackets are not taken for markup."""
    name = "[bold]a\x1b[2Jb[x].bvh"
    (tmp_path / name).write_bytes(walk.read_bytes())
    for call in (["info", name], ["info", "missing\x1b[2J.bvh"]):
        got = kinesics(*call)
        assert "\x1b[2J" not in got.out + got.err
    assert "[bold]a" in kinesics("info", name).out


@pytest.mark.usefixtures("listening")
@pytest.mark.parametrize("after", [1, 2, 4, 8, 12])
@pytest.mark.parametrize("again", [False, True], ids=["new folder", "old folder"])
def test_ctrl_c_is_130_and_leaves_nothing_half_written(
    kinesics: Kinesics, walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, after: int, again: bool
) -> None:
    """Stopped at any of the moments at which work reports: no traceback, and the folder is as it was before."""
    if again:
        kinesics("analyze", walk)
    before = {name: (tmp_path / name).read_bytes() for name in files(tmp_path)}
    told: list[float] = []

    def stop(_: terminal.Bar, fraction: float, message: str = "") -> None:
        told.append(fraction)
        if len(told) == after:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(terminal.Bar, "__call__", stop)
    got = kinesics("analyze", walk)
    assert len(told) == after, "the work reports more often than the test stops it"
    assert got.code == 130
    assert "Traceback" not in got.err
    assert got.out == ""
    assert {name: (tmp_path / name).read_bytes() for name in files(tmp_path)} == before
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


def test_a_reader_that_goes_away_is_no_error(walk: Path) -> None:
    """`kinesics … | head -1`."""
    command = subprocess.Popen(
        [sys.executable, "-m", "kinesics.cli", "analyze", str(walk), "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert command.stdout is not None
    assert command.stderr is not None
    command.stdout.close()
    said = command.stderr.read()
    command.stderr.close()
    assert command.wait(60) == 0
    assert said == b""


def test_the_bar_appears_only_for_people_and_only_after_a_second(capsys: pytest.CaptureFixture[str]) -> None:
    """Where stderr is no terminal nothing is drawn."""
    with terminal.Bar("Working") as bar:
        bar.part(0.0, 0.5)(1.0, "half")
    assert capsys.readouterr().err == ""
