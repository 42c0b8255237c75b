"""``kinesics perform``: what it leaves, what it says, and what it refuses."""

from __future__ import annotations

import dataclasses
import json
import re
import signal
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import kinesics as kx
from kinesics.cli import terminal
from kinesics.report.performances import performance_schema
from kinesics.synthesis.embodiment import checking

from .conftest import Kinesics


def files(folder: Path) -> set[str]:
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="session")
def circle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A walk in a circle as a BVH."""
    path = tmp_path_factory.mktemp("recordings") / "circle.bvh"
    kx.write(kx.performer.walk(seconds=8, fps=30, route="circle").motion, path)
    return path


def test_help_fits_a_terminal_and_shows_examples(kinesics: Kinesics) -> None:
    """80 columns, with examples."""
    got = kinesics("perform", "--help")
    assert got.code == 0
    assert max(len(line) for line in got.out.splitlines()) <= 80
    assert "kinesics perform" in got.out.split("Examples")[1]


@pytest.mark.parametrize("suffix", ["bvh", "amc", "glb", "npz"])
def test_it_leaves_the_movement_its_provenance_and_a_picture(
    kinesics: Kinesics, walk: Path, circle: Path, tmp_path: Path, suffix: str
) -> None:
    """Three files (an .amc has its .asf), named on stdout; what was reached is said in words."""
    got = kinesics("perform", walk, circle, "--out", f"new.{suffix}", "--target", "2,3", "--seed", "1")
    assert got.code == 0, got.err
    more = {"new.asf"} if suffix == "amc" else set()
    assert files(tmp_path) == {f"new.{suffix}", "new.provenance.json", "new.png"} | more
    assert "target 2 m to the left, 3 m ahead: came within 0." in got.out
    assert "reached (2.00, 3.00)" in got.out
    assert "mirrored" in got.out
    assert got.out.splitlines()[-3:] == [
        f"Movement: new.{suffix}",
        "Where it comes from: new.provenance.json",
        "Picture: new.png",
    ]
    facts = json.loads((tmp_path / "new.provenance.json").read_text(encoding="utf-8"))
    jsonschema.validate(facts, performance_schema())
    assert [s["name"] for s in facts["sources"]] == ["walk.bvh", "circle.bvh"]
    assert facts["sources"][0]["sha256"] == kx.read(walk).source.sha256
    assert facts["parameters"]["target"] == [2.0, 3.0]
    assert kx.read(tmp_path / f"new.{suffix}").frame_count == facts["output"]["frames"]
    assert (tmp_path / "new.png").read_bytes().startswith(b"\x89PNG")


def test_a_second_movement_of_the_same_name_is_told_whose_provenance_lies_there(
    kinesics: Kinesics, walk: Path, tmp_path: Path
) -> None:
    """One provenance belongs to one movement: refused, with the movement it belongs to and a name that would do."""
    (tmp_path / "new.provenance.json").write_text("{}", encoding="utf-8")
    got = kinesics("perform", walk, "--out", "new.glb", "--seconds", "1")
    assert got.code == 2
    assert "belongs to" not in got.err
    (tmp_path / "new.provenance.json").unlink()
    assert kinesics("perform", walk, "--out", "new.bvh", "--seconds", "1").code == 0
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    got = kinesics("perform", walk, "--out", "new.glb", "--seconds", "1")
    assert got.code == 2
    told = " ".join(got.err.split())
    assert "belongs to 'new.bvh'" in told
    assert "such as 'new-2.glb'" in told
    assert "--out new.bvh --out new.glb" in told
    again = kinesics("perform", walk, "--out", "new.glb", "--seconds", "1", "--seed", 2, "--overwrite")
    assert again.code == 2
    told = " ".join(again.err.split())
    assert "belongs to 'new.bvh'" in told
    assert "--out new.bvh --out new.glb, which replaces all of them" in told
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before
    both = ("--out", "new.bvh", "--out", "new.glb", "--overwrite")
    assert kinesics("perform", walk, *both, "--seconds", "1", "--seed", 2).code == 0
    facts = json.loads((tmp_path / "new.provenance.json").read_text(encoding="utf-8"))
    assert facts["output"]["files"] == ["new.bvh", "new.glb"]
    # what stays would be without its own
    assert kinesics("perform", walk, "--out", "new.bvh", "--seconds", "1", "--overwrite").code == 2
    (tmp_path / "new.glb").unlink()
    assert kinesics("perform", walk, "--out", "new.bvh", "--seconds", "1", "--overwrite").code == 0


@pytest.mark.parametrize(
    ("mine", "out"), [("new.png", "new.bvh"), ("new.asf", "new.amc"), ("new.provenance.json", "new.npz")]
)
def test_what_no_performance_left_is_not_written_over(
    kinesics: Kinesics, walk: Path, tmp_path: Path, mine: str, out: str
) -> None:
    """Whoever lets a movement be replaced has not spoken of a picture, or a skeleton, of that name."""
    (tmp_path / mine).write_text("mine", encoding="utf-8")
    got = kinesics("perform", walk, "--out", out, "--seconds", "1", "--overwrite")
    assert got.code == 2
    told = " ".join(got.err.split())
    assert f"'{mine}' is there already" in told
    assert "no performance left it" in told
    assert files(tmp_path) == {mine}
    assert (tmp_path / mine).read_text(encoding="utf-8") == "mine"


def test_a_recording_beside_which_one_performs_is_no_performance(
    kinesics: Kinesics, walk: Path, tmp_path: Path
) -> None:
    """A movement of the recording's own name in another format may be made anew as often as one likes."""
    own = tmp_path / "own.bvh"
    own.write_bytes(walk.read_bytes())
    for _ in range(2):
        assert kinesics("perform", own, "--out", "own.glb", "--seconds", "1", "--overwrite").code == 0
    assert own.read_bytes() == walk.read_bytes()


def test_one_movement_in_several_formats(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """In one call: the same movement in each, one provenance and one picture for a name; what is given twice is written once."""
    (tmp_path / "sub").mkdir()
    outs = ["new.bvh", "new.glb", "new.npz", "new.amc", "./new.bvh", "sub/new.npz"]
    got = kinesics("perform", walk, "--seconds", "2", *(word for out in outs for word in ("--out", out)))
    assert got.code == 0, got.err
    beside = {"new.provenance.json", "new.png"}
    assert files(tmp_path) == {"new.bvh", "new.glb", "new.npz", "new.amc", "new.asf", *beside} | {
        f"sub/{name}" for name in ("new.npz", *beside)
    }
    assert [line for line in got.out.splitlines() if line.startswith(("Movement", "Where it", "Picture"))] == [
        *(f"Movement: {Path(out)}" for out in ("new.bvh", "new.glb", "new.npz", "new.amc", "sub/new.npz")),
        *(f"Where it comes from: {Path(out)}" for out in ("new.provenance.json", "sub/new.provenance.json")),
        *(f"Picture: {Path(out)}" for out in ("new.png", "sub/new.png")),
    ]
    whole = kx.read(tmp_path / "new.npz")
    for name in ("new.bvh", "new.glb", "new.amc"):
        assert np.allclose(kx.read(tmp_path / name).root_positions, whole.root_positions, atol=1e-4)
    (tmp_path / "alone").mkdir()
    alone = kinesics("perform", walk, "--seconds", "2", "--out", "alone/new.glb")
    assert alone.code == 0, alone.err
    for name in ("new.glb", "new.png"):
        assert (tmp_path / "alone" / name).read_bytes() == (tmp_path / name).read_bytes()
    told, told_alone = (
        json.loads((tmp_path / folder / "new.provenance.json").read_text(encoding="utf-8")) for folder in (".", "alone")
    )
    assert told["output"].pop("files") == ["new.bvh", "new.glb", "new.npz", "new.amc"]
    assert told_alone["output"].pop("files") == ["new.glb"]
    assert told == told_alone


@pytest.mark.parametrize("bad", ["new.mp4", "new", "nowhere/new.bvh", "there.npz", ".", "walk.bvh"])
def test_of_several_outputs_none_is_left_where_one_cannot_be(
    kinesics: Kinesics, walk: Path, tmp_path: Path, bad: str
) -> None:
    """Whichever it is; refused before any work."""
    (tmp_path / "there.npz").write_text("mine")
    (tmp_path / "walk.bvh").write_bytes(walk.read_bytes())
    for outs in (("new.glb", bad), (bad, "new.glb")):
        got = kinesics("perform", "walk.bvh", "--seconds", "1", "--out", outs[0], "--out", outs[1])
        assert got.code == 2
        assert Path(bad).name in got.err
        assert files(tmp_path) == {"there.npz", "walk.bvh"}


def test_a_folder_that_cannot_be_written_to_is_told_before_any_work(
    kinesics: Kinesics, walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Which file, why, and no recording is read first."""
    import tempfile

    def refused(*_: object, **__: object) -> str:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(tempfile, "mkdtemp", refused)
    got = kinesics("perform", "none.bvh", "--out", "new.bvh")
    assert got.code == 2
    assert "new.bvh: The file cannot be written: Permission denied. Give another folder." in " ".join(got.err.split())
    assert list(tmp_path.iterdir()) == []


def test_a_format_that_fails_leaves_nothing_of_the_others(
    kinesics: Kinesics, walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where it is found out only as it is written."""
    from kinesics import formats

    write = formats.write

    def failing(motion: kx.Motion, path: Path, **how: object) -> tuple[str, ...]:
        if path.suffix == ".glb":
            raise kx.InputError("cannot be told in glTF")
        return write(motion, path, **how)  # type: ignore[arg-type]

    monkeypatch.setattr(formats, "write", failing)
    got = kinesics("perform", walk, "--seconds", "1", "--out", "new.bvh", "--out", "new.glb")
    assert got.code == 2
    assert "cannot be told" in got.err
    assert list(tmp_path.iterdir()) == []


def test_the_skeleton_of_a_recording_is_not_written_over(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """An .amc leaves an .asf: never in the place of the one that was read, whatever may be replaced."""
    kx.write(kx.read(walk), tmp_path / "07.amc")
    (tmp_path / "07_01.amc").write_bytes((tmp_path / "07.amc").read_bytes())
    before = (tmp_path / "07.asf").read_bytes()
    got = kinesics("perform", "07_01.amc", "--seconds", "1", "--out", "07.amc", "--overwrite")
    assert got.code == 2
    assert "'07.asf' is one of the recordings" in got.err
    assert (tmp_path / "07.asf").read_bytes() == before


def test_how_near_counts_as_there(kinesics: Kinesics, walk: Path) -> None:
    """--within, beside a target."""
    got = kinesics("perform", walk, "--target", "0,2", "--within", "0.2", "--json")
    assert got.code == 0, got.err
    facts = json.loads(got.out)
    assert facts["parameters"]["radius"] == 0.2
    assert facts["goal"]["nearest_m"] <= 0.2
    assert "how near to a `target`" in " ".join(kinesics("perform", walk, "--within", "0.2", "--json").err.split())


@pytest.mark.parametrize("suffix", [".bvh", ".amc", ".glb", ".npz"])
def test_the_same_call_leaves_the_same_bytes(kinesics: Kinesics, walk: Path, tmp_path: Path, suffix: str) -> None:
    """Nothing depends on the day, the folder, or what was made before; another seed makes another movement."""
    made = []
    for folder, seed in (("a", 3), ("b", 3), ("c", 4)):
        out = tmp_path / folder
        out.mkdir()
        assert kinesics("perform", walk, "--out", out / f"new{suffix}", "--seconds", "2", "--seed", seed).code == 0
        made.append({file.name: file.read_bytes() for file in sorted(out.iterdir())})
    assert len(made[0]) == (4 if suffix == ".amc" else 3)
    assert made[0] == made[1]
    assert made[0][f"new{suffix}"] != made[2][f"new{suffix}"]


def test_json_is_alone_on_stdout_and_needs_no_out(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """Files only with --out, and then their names go to stderr."""
    got = kinesics("perform", walk, "--json", "--seconds", "2")
    assert got.json()["output"]["duration_s"] == 2.0
    assert files(tmp_path) == set()
    got = kinesics("perform", walk, "--json", "--seconds", "2", "--out", "new.bvh")
    assert got.json()["goal"]["attained"] is False
    assert "Movement: new.bvh" in got.err
    assert "new.bvh" in files(tmp_path)


@pytest.mark.parametrize("separator", [",", ";", "\t", "  "])
@pytest.mark.parametrize("heading", ["", "x,z\n", "\ufeff# metres\n\n"])
def test_a_route_is_read_from_a_table(
    kinesics: Kinesics, walk: Path, tmp_path: Path, separator: str, heading: str
) -> None:
    """Whatever stands between the numbers; a heading or remarks may stand above."""
    rows = "".join(f"{x}{separator}{z}\n" for x, z in ((0, 0), (0, 1.5), (0.2, 3)))
    (tmp_path / "route.csv").write_text(heading + rows, encoding="utf-8")
    got = kinesics("perform", walk, "--route", "route.csv", "--json", "--seconds", "4")
    assert got.code == 0, got.err
    assert got.json()["parameters"]["route"] == [[0.0, 0.0], [0.0, 1.5], [0.2, 3.0]]


@pytest.mark.parametrize("rows", ['"x","z"\n"0","0"\n"0.2","3"\n', "x;z\n0;0\n0,2;3,0\n", "0;0\r\n.2;3\r\n"])
def test_a_route_is_read_as_spreadsheets_write_it(kinesics: Kinesics, walk: Path, tmp_path: Path, rows: str) -> None:
    """In quotes; with semicolons and decimal commas."""
    (tmp_path / "route.csv").write_text(rows, encoding="utf-8")
    got = kinesics("perform", walk, "--route", "route.csv", "--json", "--seconds", "4")
    assert got.code == 0, got.err
    assert got.json()["parameters"]["route"] == [[0.0, 0.0], [0.2, 3.0]]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"0,0\n1,abc\n", "route.csv, line 2"),
        (b"x,z\n0,0\n\n1,2,3\n", "route.csv, line 4"),
        (b"0,0\n0,inf\n", "line 2"),
        (b"x,z\ny,w\n0,0\n0,1\n", "line 2"),
        (b"0,0\n", "two corners or more, got 1"),
        (b"", "two corners or more, got 0"),
        (b"\xff\xfe0,0", "UTF-8"),
        (b"1,1\n1,1\n", "one place"),
    ],
)
def test_a_bad_route_is_refused_with_its_line(
    kinesics: Kinesics, walk: Path, tmp_path: Path, content: bytes, says: str
) -> None:
    """Exit 2, which line, nothing written."""
    (tmp_path / "route.csv").write_bytes(content)
    got = kinesics("perform", walk, "--out", "new.bvh", "--route", "route.csv")
    assert got.code == 2
    assert says in got.err
    assert "Traceback" not in got.err
    assert files(tmp_path) == {"route.csv"}


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (["--out", "new.mp4"], "`video`"),
        (["--out", "new.webm"], ".bvh"),
        (["--out", "new.xyz"], ".glb"),
        (["--out", "new"], ".bvh"),
        (["--out", "new.asf"], "new.amc"),
        (["--out", "nowhere/new.bvh"], "does not exist"),
        (["--out", "new.bvh", "--target", "3"], "X,Z"),
        (["--out", "new.bvh", "--target", "a,b"], "a,b"),
        (["--out", "new.bvh", "--target", "nan,1"], "finite"),
        (["--out", "new.bvh", "--target", "1,1", "--route", "none.csv"], "none.csv"),
        (["--out", "new.bvh", "--to", "A"], "--from"),
        (["--out", "new.bvh", "--from", "Q", "--to", "A"], "There are: A, A*"),
        (["--out", "new.bvh", "--favour", "wlak"], "Did you mean walk"),
        (["--out", "new.bvh", "--seconds", "0"], "seconds"),
        (["--out", "new.bvh", "--beta", "-1"], "beta"),
        (["--out", "new.bvh", "--fps", "0"], "fps"),
        (["--out", "new.bvh", "--fps", "1"], "Expected 8 frames a second or more"),
        (["--out", "new.bvh", "--edits", "none.toml"], "none.toml"),
        (["--out", "new.bvh", "--skeleton-of", "none.bvh"], "none.bvh"),
        (["--out", "new.bvh", "--threshold", "1e-12"], "larger `threshold`"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_what_cannot_be_is_one_message(
    kinesics: Kinesics, walk: Path, tmp_path: Path, call: list[str], says: str
) -> None:
    """Exit 2, what was expected, nothing written."""
    got = kinesics("perform", walk, *call)
    assert got.code == 2
    assert says in got.err
    assert got.out == ""
    assert got.err.count("kinesics: ") == 1
    assert "Traceback" not in got.err
    assert files(tmp_path) == set()


@pytest.mark.parametrize(
    "call",
    [
        ["--target", "nan,1"],
        ["--target", "1e9,1"],
        ["--target", "1,1", "--from", "A", "--to", "A"],
        ["--to", "A"],
        ["--within", "1"],
        ["--target", "1,1", "--within", "0"],
        ["--from", ""],
        ["--favour", " "],
        ["--linger"],
        ["--linger", "--seconds", "5"],
        ["--linger", "--from", "A", "--seconds", "5"],
        ["--linger", "--target", "1,1"],
        ["--seconds", "-1"],
        ["--seconds", "nan"],
        ["--seconds", "1e9"],
        ["--seed", "-1"],
        ["--beta", "nan"],
        ["--bend", "-1"],
        ["--bend", "91"],
        ["--fps", "nan"],
        ["--fps", "0"],
        ["--fps", "5000"],
        ["--threshold", "0"],
        ["--threshold", "-0.1"],
        ["--threshold", "inf"],
        ["--threshold", "2"],
        ["--target", "1,1", "--within", "-1"],
    ],
    ids=" ".join,
)
def test_wishes_that_cannot_be_are_told_before_a_recording_is_read(kinesics: Kinesics, call: list[str]) -> None:
    """Nobody waits for a folder of recordings to be told so."""
    got = kinesics("perform", "none.bvh", "--out", "new.bvh", *call)
    assert got.code == 2
    assert "none.bvh" not in got.err
    assert got.err.count("kinesics: ") == 1


@pytest.mark.parametrize(
    ("frames", "says"),
    [(1, "short is a single pose"), (2, "'short' lasts 0.067 s, 2 frames"), (12, "'short' lasts 0.4 s, 12 frames")],
)
def test_too_few_frames_are_told(kinesics: Kinesics, walk: Path, tmp_path: Path, frames: int, says: str) -> None:
    """How many they are and how many it takes, and not what follows from it inside."""
    kx.write(kx.read(walk).resample(30.0)[:frames], tmp_path / "short.bvh")
    got = kinesics("perform", "short.bvh", "--out", "new.bvh")
    assert got.code == 2
    assert says in got.err
    assert "threshold" not in got.err
    assert files(tmp_path) == {"short.bvh"}


def test_what_is_doubtful_in_a_file_is_told_where_nothing_comes_of_it(
    kinesics: Kinesics, walk: Path, tmp_path: Path
) -> None:
    """It may be why: a body that lies, here, for z is not up."""
    kx.write(kx.read(walk)[:12], tmp_path / "short.bvh")
    got = kinesics("perform", "short.bvh", "--up", "z", "--out", "new.bvh")
    assert got.code == 2
    assert got.err.startswith("short.bvh: With z up the body never stands: it lies")
    assert "'short' lasts 0.4 s" in got.err.splitlines()[-1]


def test_a_single_pose_beside_others_is_left_out(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """Told among what is doubtful; the others are performed as without it, also where it comes first."""
    kx.write(kx.read(walk)[0], tmp_path / "pose.bvh")
    made = []
    for given in (("pose.bvh", walk), (walk, "pose.bvh"), (walk,)):
        got = kinesics("perform", *given, "--seconds", "1", "--out", "new.npz", "--overwrite")
        assert got.code == 0, got.err
        assert ("doubtful: pose.bvh is left out: a single pose" in got.out) == (len(given) == 2)
        facts = json.loads((tmp_path / "new.provenance.json").read_text(encoding="utf-8"))
        assert [s["name"] for s in facts["sources"]] == ["walk.bvh"]
        made.append(kx.read(tmp_path / "new.npz").rotations.tobytes())
    assert made[0] == made[1] == made[2]
    got = kinesics("perform", "pose.bvh", "pose.bvh", "--seconds", "1", "--out", "new.npz", "--overwrite")
    assert got.code == 2
    assert "pose is a single pose" in got.err


def test_what_is_wrong_with_a_file_is_among_what_is_doubtful(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """As reading it tells, by the file's name; beside the movement, too."""
    text = walk.read_text(encoding="utf-8")
    (tmp_path / "long.bvh").write_text(re.sub(r"Frames:\s*\d+", "Frames: 60", text), encoding="utf-8")
    said = kx.read(tmp_path / "long.bvh").warnings
    assert said
    got = kinesics("perform", "long.bvh", "--out", "new.bvh", "--seconds", "1")
    assert got.code == 0, got.err
    assert f"doubtful: long.bvh: {said[0]}" in got.out
    told = json.loads((tmp_path / "new.provenance.json").read_text(encoding="utf-8"))["output"]["warnings"]
    assert f"long.bvh: {said[0]}" in told


def test_all_that_cannot_be_used_is_named_at_once(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """Files that cannot be read or understood are an error, with a way to go on; without them it goes on, and says so."""
    (tmp_path / "cut.bvh").write_text(walk.read_text(encoding="utf-8")[:3000], encoding="utf-8")
    motion = kx.read(walk)
    pole = kx.Skeleton(("root", "tip"), (-1, 0), np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), ())
    kx.write(kx.Motion(pole, motion.rotations[:, :2], motion.root_positions, 30.0), tmp_path / "pole.npz")
    given = ("perform", "cut.bvh", walk, "pole.npz", "none.bvh", "--seconds", "1")
    got = kinesics(*given, "--out", "new.bvh")
    assert got.code == 2
    assert "3 of 4 recordings cannot be used" in got.err
    assert "--skip-unusable" in got.err
    for said in ("cut.bvh, line", "pole.npz: ", "none.bvh: "):
        assert said in got.err
    assert files(tmp_path) == {"cut.bvh", "pole.npz"}
    got = kinesics(*given, "--out", "new.bvh", "--skip-unusable")
    assert got.code == 0, got.err
    told = json.loads((tmp_path / "new.provenance.json").read_text(encoding="utf-8"))["output"]["warnings"]
    for file, said in zip(("cut", "pole", "none"), told, strict=False):
        assert said.startswith(f"left out: {file}")
        assert said in got.err
    got = kinesics("perform", "cut.bvh", "none.bvh", "--skip-unusable", "--out", "again.bvh")
    assert got.code == 2
    assert "2 of 2 recordings cannot be used" in got.err
    assert "--skip" not in got.err


@pytest.mark.parametrize("suffix", ["bvh", "amc"])
@pytest.mark.parametrize("how", ["bom", "crlf", "utf-16"])
def test_files_of_other_editors_are_performed_alike(
    kinesics: Kinesics, walk: Path, tmp_path: Path, suffix: str, how: str
) -> None:
    """With a byte order mark, with other ends of lines, in UTF-16: the movement is the same."""
    kx.write(kx.read(walk), tmp_path / f"walk.{suffix}")
    assert kinesics("perform", f"walk.{suffix}", "--out", "new.npz", "--seconds", "2").code == 0
    for file in [tmp_path / f"walk.{s}" for s in ((suffix, "asf") if suffix == "amc" else (suffix,))]:
        data = file.read_bytes()
        file.write_bytes(
            b"\xef\xbb\xbf" + data
            if how == "bom"
            else data.replace(b"\n", b"\r\n")
            if how == "crlf"
            else data.decode().encode("utf-16")
        )
    got = kinesics("perform", f"walk.{suffix}", "--out", "again.npz", "--seconds", "2")
    assert got.code == 0, got.err
    new, again = kx.read(tmp_path / "new.npz"), kx.read(tmp_path / "again.npz")
    assert (new.rotations == again.rotations).all()
    assert (new.root_positions == again.root_positions).all()


def test_the_body_to_perform_on_is_looked_at_before_the_recordings(
    kinesics: Kinesics, walk: Path, tmp_path: Path
) -> None:
    """There may be hundreds of these."""
    motion = kx.read(walk)
    pole = kx.Skeleton(("root", "tip"), (-1, 0), np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), ())
    kx.write(kx.Motion(pole, motion.rotations[:, :2], motion.root_positions, 30.0), tmp_path / "pole.npz")
    got = kinesics("perform", "none.bvh", "--skeleton-of", "pole.npz", "--out", "new.bvh")
    assert got.code == 2
    assert "pole.npz: The skeleton cannot be understood" in got.err
    assert "none.bvh" not in got.err


def test_what_it_is_performed_on_and_from_is_said(kinesics: Kinesics, walk: Path, circle: Path, tmp_path: Path) -> None:
    """Whose skeleton, where its root lies, what a word was taken for, what was given twice."""
    tall = kx.performer.walk(seconds=3, fps=30, body=1.9).motion
    stand = tall.skeleton.replace(
        joint_names=("Stand", *tall.skeleton.joint_names),
        parents=(-1, *(p + 1 for p in tall.skeleton.parents)),
        offsets=np.concatenate([np.zeros((1, 3)), [[0.0, 1.0, 0.0]], tall.skeleton.offsets[1:]]),
        end_sites=tuple(dataclasses.replace(s, parent=s.parent + 1) for s in tall.skeleton.end_sites),
        freedoms=(),
        anatomy=None,
    )
    still = np.zeros((tall.frame_count, 1, 4))
    still[..., 0] = 1.0
    rig = kx.Motion(stand, np.concatenate([still, tall.rotations], axis=1), tall.root_positions - [0.0, 1.0, 0.0], 30.0)
    kx.write(rig, tmp_path / "rig.bvh")
    how = ("--skeleton-of", "rig.bvh", "--favour", "circ", "--seconds", "2", "--out", "new.bvh")
    got = kinesics("perform", walk, circle, walk, *how)
    assert got.code == 0, got.err
    assert "performed on the skeleton of rig" in got.out
    put = "the root joint, Stand, is in the pelvis, where Hips is"
    assert put in " ".join(got.out.split())
    assert "favoured as 'circ': circle" in got.out
    assert "walk.bvh was given more than once: used once" in got.out
    new = kx.read(tmp_path / "new.bvh")
    assert set(new.skeleton.joint_names) == set(stand.joint_names)
    facts = json.loads((tmp_path / "new.provenance.json").read_text(encoding="utf-8"))
    assert [s["name"] for s in facts["sources"]] == ["walk.bvh", "circle.bvh"]
    got = kinesics("perform", walk, *how[:-1], "new.glb", "--overwrite")
    assert put not in " ".join(got.out.split()), "who plays it on a figure of its own need not know"


@pytest.mark.parametrize(
    ("target", "says"),
    [("0,2", "target 2 m ahead: came"), ("0,-1", "target 1 m behind"), ("-1,2", "target 1 m to the right, 2 m ahead")],
)
def test_a_target_is_told_as_seen_by_the_performer(
    kinesics: Kinesics, walk: Path, circle: Path, target: str, says: str, tmp_path: Path
) -> None:
    """Left or right, ahead or behind, and no "0 m to the left"."""
    got = kinesics("perform", walk, circle, "--out", "new.npz", f"--target={target}", "--seconds", "3")
    assert says in got.out


def test_a_persons_names_are_understood(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """From the side file of the first recording, which is said, or from the file given."""
    (tmp_path / "a.bvh").write_bytes(walk.read_bytes())
    (tmp_path / "a.bvh.edits.toml").write_text('[states]\nrename = { A = "guard" }\n')
    (tmp_path / "other.toml").write_text('[states]\nrename = { A = "stance" }\n')
    got = kinesics("perform", "a.bvh", "--from", "guard", "--to", "guard*", "--out", "new.bvh")
    assert got.code == 0, got.err
    assert "guard to guard*" in got.out
    assert "Edits: a.bvh.edits.toml" in got.err
    got = kinesics("perform", "a.bvh", "--from", "guard", "--to", "guard*", "--json", "--edits", "other.toml")
    assert got.code == 2
    assert "There are: stance, stance*" in got.err


def test_without_out_or_json_it_asks_where_to(kinesics: Kinesics, walk: Path) -> None:
    """A wrong call is 2."""
    got = kinesics("perform", walk)
    assert got.code == 2
    assert "--out" in got.err


def test_nothing_is_overwritten_unasked(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """Neither the movement nor what lies beside it; the recording itself never."""
    for name in ("new.bvh", "new.provenance.json", "new.png"):
        (tmp_path / name).write_text("mine")
        got = kinesics("perform", walk, "--out", "new.bvh", "--seconds", "1")
        assert got.code == 2
        assert name in got.err
        assert "--overwrite" in got.err
        assert files(tmp_path) == {name}
        (tmp_path / name).unlink()
    own = tmp_path / "own.bvh"
    own.write_bytes(walk.read_bytes())
    got = kinesics("perform", own, "--out", "own.bvh", "--overwrite")
    assert got.code == 2
    assert own.read_bytes() == walk.read_bytes()
    for _ in range(2):
        assert kinesics("perform", own, "--out", "new.bvh", "--seconds", "1", "--overwrite").code == 0


def test_what_was_left_out_and_missed_is_said(kinesics: Kinesics, circle: Path, tmp_path: Path) -> None:
    """Unconnected clips by name, other rates, a target that was not reached; all the same it is performed."""
    kx.write(kx.performer.jumping_jacks(seconds=4, fps=60).motion, tmp_path / "jacks.bvh")
    got = kinesics("perform", circle, "jacks.bvh", "--out", "new.bvh", "--target=-30,-2", "--seconds", "3", "--linger")
    assert got.code == 0
    assert "nothing is performed of 'jacks'" in got.out
    assert "resampled to 30 frames a second: jacks.bvh" in got.out
    assert "target 30 m to the right, 2 m behind" in got.out
    assert "did not reach (-30.00, -2.00)" in got.out


def test_a_check_that_fails_is_seen(kinesics: Kinesics, circle: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the line of what was checked, among what is doubtful, and nowhere where all is as it should be."""
    slid = checking.Slid("right", 30, 45, 0.031)
    failed = checking.Check(12, 1, 0.031, 0.004, 0.0, 0.001, 0.003, 0.01, (slid,))
    monkeypatch.setattr(checking, "check", lambda *_: failed)
    told = " ".join(kinesics("perform", circle, "--out", "new.bvh", "--seconds", "3").out.split())
    assert "checked, and not all is as it should be: 1 of 12 contacts slides more than 1 cm" in told
    assert "doubtful: feet slide more than 1 cm in 1 of 12 contacts, the right one by 3.1 cm from 1.0 to 1.5 s" in told
    monkeypatch.setattr(checking, "check", lambda *_: failed._replace(slides=0, slide=0.005, slid=()))
    told = " ".join(kinesics("perform", circle, "--out", "sound.bvh", "--seconds", "3").out.split())
    assert "checked: feet slide 0.5 cm at most" in told
    assert "doubtful" not in told


def test_where_much_is_left_out_it_is_said_what_and_why(kinesics: Kinesics, circle: Path, tmp_path: Path) -> None:
    """The share, which recordings and why, and that nothing joins them; no word of it where all but the ends is used."""
    for name, perform in (("jacks", kx.performer.jumping_jacks), ("squats", kx.performer.squat)):
        kx.write(perform(seconds=7, fps=30).motion, tmp_path / f"{name}.bvh")
    got = kinesics("perform", circle, "jacks.bvh", "squats.bvh", "--out", "new.bvh", "--seconds", "1")
    assert got.code == 0, got.err
    told = " ".join(got.out.split())
    assert "jacks, as recorded and mirrored: 7.00 s, no transition leads there and back again" in told
    assert "doubtful: most of what was recorded is not used" in told
    assert "No larger `threshold` joins" in told
    alone = kinesics("perform", circle, "--out", "alone.bvh", "--seconds", "1")
    assert "--threshold" not in " ".join(alone.out.split())


def test_the_threshold_that_would_join_more_does(kinesics: Kinesics, shared_data: Path) -> None:
    """Of exercises, little of which the usual one joins: the seconds that nothing leads to, and a threshold with which as little
    is left out as is said."""
    given = (
        "perform",
        shared_data / "cmu/13/13_29.amc",
        "--fps",
        "30",
        "--seconds",
        "1",
        "--out",
        "new.bvh",
        "--overwrite",
    )
    got = kinesics(*given, "--threshold", "0.007")
    assert got.code == 0, got.err
    told = " ".join(got.out.split())
    assert re.search(r"no transition leads there: 0\.00–\d+\.\d+ s", told)
    larger = re.search(r"doubtful: most .* --threshold (\S+)\) makes it (\S+) s,", told.replace("(--", "--"))
    assert larger is not None
    assert float(larger[2]) > 15.0
    again = " ".join(kinesics(*given, "--threshold", larger[1]).out.split())
    assert f"not used, for no way leads there or back: {1.0 - float(larger[2]) / 38.27:.0%} of" in again


def test_the_body_of_another_recording(kinesics: Kinesics, walk: Path, tmp_path: Path) -> None:
    """--skeleton-of decides who moves, --fps how often."""
    kx.write(kx.performer.walk(seconds=3, fps=30, body=1.4).motion, tmp_path / "small.bvh")
    got = kinesics("perform", walk, "--out", "new.bvh", "--seconds", "2", "--skeleton-of", "small.bvh", "--fps", "24")
    assert got.code == 0, got.err
    new, small = kx.read(tmp_path / "new.bvh"), kx.read(tmp_path / "small.bvh")
    assert new.fps == pytest.approx(24)
    assert abs(new.skeleton.offsets - small.skeleton.offsets).max() < 1e-6


@pytest.mark.usefixtures("listening")
@pytest.mark.parametrize("after", [1, 3, 6, 9])
def test_ctrl_c_is_130_and_leaves_nothing(
    kinesics: Kinesics, walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, after: int
) -> None:
    """Stopped at any of the moments at which work reports."""
    told: list[float] = []

    def stop(_: terminal.Bar, fraction: float, message: str = "") -> None:
        told.append(fraction)
        if len(told) == after:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(terminal.Bar, "__call__", stop)
    got = kinesics("perform", walk, "--out", "new.bvh", "--seconds", "1")
    assert len(told) == after
    assert got.code == 130
    assert got.out == ""
    assert "Traceback" not in got.err
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("listening")
def test_ctrl_c_while_files_are_put_down_waits_until_all_are(
    kinesics: Kinesics, walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A movement without its provenance would be half a result."""
    replace = Path.replace

    def interrupted(self: Path, target: Path) -> Path:
        out = replace(self, target)
        if Path(target).parent.resolve() == tmp_path.resolve():
            signal.raise_signal(signal.SIGINT)
        return out

    monkeypatch.setattr(Path, "replace", interrupted)
    got = kinesics("perform", walk, "--out", "new.bvh", "--seconds", "1")
    assert got.code == 130
    assert files(tmp_path) == {"new.bvh", "new.provenance.json", "new.png"}
