"""Damaged files and files that are none: one clear error with its line, or the right motion; nothing else, ever."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import kinesics as kx
import small_files
from kinesics.errors import FileError, InputError

FIRST = small_files.BVH_LINES_BEFORE_FRAMES + 1
"""Line of the first frame of the small BVH."""
ROW = small_files.AMC_LINES_BEFORE_FRAMES + 1
"""Line of the first frame's number in the small .amc; each frame takes six lines."""


def small_bvh() -> str:
    """The same every time."""
    return small_files.bvh(np.random.default_rng(5))


def small_amc() -> str:
    """The same every time."""
    return small_files.amc(np.random.default_rng(5))


def put(lines: list[str], number: int, line: str | None) -> str:
    """The text with one line, counted from 1, changed or taken out."""
    out = list(lines)
    out[number - 1 : number] = [] if line is None else [line]
    return "\n".join(out) + "\n"


def in_line(number, change, content):
    """The text with one line, counted from 1, changed by a function."""
    lines = content.splitlines()
    return put(lines, number, change(lines[number - 1]))


BVH_DAMAGE = {
    "not a number": (lambda t: in_line(FIRST + 2, lambda s: s.replace(".", "x", 1), t), FIRST + 2, "is not a number"),
    "nan": (
        lambda t: in_line(FIRST, lambda s: "nan" + s[s.index(" ") :], t),
        FIRST,
        "Value 1 .Xposition of Hips.*finite",
    ),
    "infinite": (lambda t: in_line(FIRST + 1, lambda s: s[: s.rindex(" ")] + " -inf", t), FIRST + 1, "finite"),
    "too large a power": (lambda t: in_line(FIRST, lambda s: "1e999" + s[s.index(" ") :], t), FIRST, "finite"),
    "decimal commas": (lambda t: in_line(FIRST, lambda s: s.replace(".", ","), t), FIRST, "point"),
    "broken printf": (lambda t: in_line(FIRST, lambda s: "-1.#IND" + s[s.index(" ") :], t), FIRST, "1.#IND"),
    "digits with underscores": (lambda t: in_line(FIRST, lambda s: "1_0" + s[s.index(" ") :], t), FIRST, "1_0"),
    "huge value": (lambda t: in_line(FIRST + 1, lambda s: "1e200" + s[s.index(" ") :], t), None, "Frame 1 .* 1e\\+200"),
    "a value lacks": (
        lambda t: in_line(FIRST + 1, lambda s: s[: s.rindex(" ")], t),
        FIRST + 1,
        f"Expected {small_files.BVH_COLUMNS} values, .* got {small_files.BVH_COLUMNS - 1}",
    ),
    "a value too many": (lambda t: in_line(FIRST + 4, lambda s: s + " 1.0", t), FIRST + 4, "got 29"),
    "cut within a frame": (
        lambda t: t[:-40],
        FIRST + 4,
        f"Expected {small_files.BVH_COLUMNS} values.*cut off after 4 whole frames of 5: .* again, "
        f"or delete this line and write 'Frames: 4' on line {FIRST - 2}",
    ),
    "cut within a number": (
        lambda t: "\n".join(t.splitlines()[:FIRST]) + "\n1.5 -",
        FIRST + 1,
        "Value 2 .*'-' is not a number.*cut off after 1 whole frame of 5",
    ),
    "cut within the first frame": (lambda t: t[: t.index("0.01\n") + 20], FIRST, "cut off in its first frame"),
    "cut before the frames": (lambda t: t[: t.index("0.01\n") + 5], FIRST - 1, "Expected 5 frames.*none.*cut off"),
    "cut before the frame time": (lambda t: t[: t.index("Frame Time") + 4], FIRST - 1, "'Frame Time:'.*cut off"),
    "a piece of a frame too many": (
        lambda t: t + "1.5 2\n",
        FIRST + 5,
        f"got 2. The 5 frames as said on line {FIRST - 2} are there: delete this line",
    ),
    "cut between frames": (
        lambda t: "\n".join(t.splitlines()[:-2]) + "\n",
        FIRST + 2,
        f"Expected 5 frames as said on line {FIRST - 2}, got 3.*cut off.*or write 'Frames: 3' on line {FIRST - 2}",
    ),
    "cut in the skeleton": (lambda t: t[: t.index("JOINT Head")], None, "brackets.*cut off before its first frame"),
    "cut within a word": (lambda t: t[: t.index("OFFSET 28") + 3], None, "got 'OFF'.*cut off before its first frame"),
    "no frames": (lambda t: t[: t.index("0.01\n") + 5].replace("Frames: 5", "Frames: 0"), FIRST - 2, "no frames"),
    "no motion": (lambda t: small_files.BVH_TREE, None, "MOTION.*cut off"),
    "frame time 0": (lambda t: t.replace("0.01\n", "0\n"), FIRST - 1, "frame time of 0"),
    "frame time negative": (lambda t: t.replace("0.01\n", "-0.01\n"), FIRST - 1, "cannot be"),
    "frame time a word": (lambda t: t.replace("0.01\n", "fast\n"), FIRST - 1, "'fast' is not a number"),
    "frame time lacks": (lambda t: t.replace("Frame Time: 0.01\n", ""), FIRST - 1, "Frame Time"),
    "half a frame": (lambda t: t.replace("Frames: 5", "Frames: 4.5"), FIRST - 2, "number of frames"),
    "no skeleton": (lambda t: "HIERARCHY\n" + t[t.index("MOTION") :], 2, "ROOT"),
    "wrong word": (lambda t: t.replace("JOINT Head", "JOIN Head"), "JOIN Head", "got 'JOIN'"),
    "unnamed joint": (lambda t: t.replace("JOINT Head", "JOINT"), "JOINT\n", "name of a joint"),
    "unknown channel": (lambda t: t.replace("CHANNELS 1 Yrotation", "CHANNELS 1 Yscale"), "Yscale", "got 'Yscale'"),
    "wrong channel count": (
        lambda t: t.replace("CHANNELS 1 Yrotation", "CHANNELS 2 Yrotation"),
        "JOINT LeftThumb",
        "Expected a channel",
    ),
    "channels without end": (lambda t: t.replace("CHANNELS 1 ", "CHANNELS 999999999999 "), "99999", "from 0 to 6"),
    "channel twice": (
        lambda t: t.replace("2 Zrotation Yrotation", "2 Zrotation Zrotation"),
        "Zrotation Zrotation",
        "twice",
    ),
    "offset of two": (
        lambda t: t.replace("OFFSET 28 0 0", "OFFSET 28 0"),
        "CHANNELS 1 Y",
        "OFFSET.*'CHANNELS' is not a number",
    ),
    "offset nan": (lambda t: t.replace("OFFSET 28 0 0", "OFFSET 28 nan 0"), "28 nan 0", "finite"),
    "offset huge": (lambda t: t.replace("OFFSET 28 0 0", "OFFSET 1e300 0 0"), "1e300", "no length"),
    "offset lacks": (lambda t: t.replace("OFFSET 28 0 0\n", "\n"), None, "'LeftForeArm' has no OFFSET"),
    "one bracket too many": (lambda t: t.replace("MOTION", "}\nMOTION"), "}\nMOTION", "got '}'"),
    "no channels": (
        lambda t: "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\n}\nMOTION\nFrames: 1\nFrame Time: 1\n\n",
        None,
        "nothing moves",
    ),
}

AMC_DAMAGE = {
    "not a number": (lambda t: t.replace("\nlfoot ", "\nlfoot x", 1), ROW + 5, "lfoot: 'x.*' is not a number"),
    "nan": (lambda t: in_line(ROW + 3, lambda s: "lfemur nan 1 2", t), ROW + 3, "finite"),
    "a value lacks": (
        lambda t: in_line(ROW + 6 + 3, lambda s: s[: s.rindex(" ")], t),
        ROW + 9,
        r"Expected 3 values \(rx ry rz\) for 'lfemur', got 2",
    ),
    "a value too many": (lambda t: in_line(ROW + 6 + 5, lambda s: s + " 4", t), ROW + 11, "got 3"),
    "unknown bone": (lambda t: t.replace("lfoot", "wing"), ROW + 5, "'wing' is no bone of 07.asf.*lfemur"),
    "bone lacks later": (
        lambda t: in_line(ROW + 12 + 4, lambda s: "", t),
        ROW + 18,
        "Frame 3 has no values for 'ltibia'",
    ),
    "bone twice": (lambda t: in_line(ROW + 5, lambda s: s + "\nlfoot 1 2", t), ROW + 6, "'lfoot' twice"),
    "bone more later": (
        lambda t: "".join(s for k, s in enumerate(t.splitlines(keepends=True), 1) if k != ROW + 5),
        ROW + 10,
        "Expected a frame number, got 'lfoot.*the first frame has no 'lfoot'; all",
    ),
    "cut within a line": (lambda t: t[: t.rindex(" ")] + "\n", ROW + 29, "got 1.*cut off"),
    "cut between lines": (lambda t: t[: t.rindex("lfoot")], ROW + 28, "Frame 5 has no values for 'lfoot'.*cut off"),
    "cut within a name": (
        lambda t: t[: t.rindex("ltibia") + 3],
        ROW + 28,
        "Frame 5 ends with 'lti'.*cut off in frame 5: .* or delete what there is of that frame",
    ),
    "cut after a number": (lambda t: t[: t.rindex("root")], None, "Frame 5 has no values.*cut off"),
    "no frame number": (lambda t: t.replace("\n1\n", "\n", 1), ROW, "Expected a frame number, got 'root"),
    "no frames": (lambda t: "#x\n:FULLY-SPECIFIED\n:DEGREES\n", None, "no frames"),
    "huge": (lambda t: in_line(ROW + 6 + 4, lambda s: "ltibia 1e30", t), None, "Frame 1 .*1e\\+30"),
}

ASF_DAMAGE = {
    "no hierarchy": (lambda t: t[: t.index(":hierarchy")], "No bone hangs on the root"),
    "cut within a bone": (lambda t: t[: t.index("name lfoot")], "line 48.*no 'end'|has no 'end'"),
    "bone of no name": (lambda t: t.replace("     name lfoot\n", ""), "has no name"),
    "two of one name": (lambda t: t.replace("name lfoot", "name ltibia"), "two bones called 'ltibia'"),
    "hangs on two": (lambda t: t.replace("root lhipjoint", "root lfoot lhipjoint"), "'lfoot' hangs on two"),
    "unknown in hierarchy": (lambda t: t.replace("ltibia lfoot", "ltibia lhoof"), "'lhoof' that is not among"),
    "direction of two": (
        lambda t: t.replace("direction 0 1 0", "direction 0 1"),
        "Expected 3 numbers after 'direction', got 2",
    ),
    "length a word": (lambda t: t.replace("length 2.5", "length long"), "length: 'long' is not a number"),
    "length huge": (lambda t: t.replace("length 2.5", "length 1e99"), "larger than anything"),
    "scale 0": (lambda t: t.replace("length 0.45", "length 0"), "length scale of 0"),
    "axis order": (lambda t: t.replace("ZXY", "ZZY"), "order of axes such as XYZ, got 'ZZY'"),
    "angle": (lambda t: t.replace("angle deg", "angle gon"), "'angle gon'"),
    "stretching bone": (lambda t: t.replace("dof rx\n", "dof rx l\n"), "change their length"),
    "odd freedom": (lambda t: t.replace("dof rx\n", "dof rq\n"), "got 'rq'"),
    "freedom twice": (lambda t: t.replace("dof rx\n", "dof rx rx\n"), "twice"),
    "odd limits": (lambda t: t.replace("(-10.0 170.0)", "(-10.0)"), "in pairs"),
    "limits of words": (lambda t: t.replace("(-10.0 170.0)", "(none)"), "in pairs"),
}


@pytest.mark.parametrize("python", [False, True], ids=["native", "python"])
@pytest.mark.parametrize("damage", BVH_DAMAGE)
def test_a_damaged_bvh_is_one_error_with_its_line(tmp_path, monkeypatch, damage, python) -> None:
    """What is wrong, where, and what was expected; with and without the compiled parser."""
    if python:
        monkeypatch.setenv("KINESICS_NO_NATIVE", "1")
    change, line, words = BVH_DAMAGE[damage]
    path = tmp_path / "a.bvh"
    path.write_text(change(small_bvh()))
    with pytest.raises(FileError, match=words) as caught:
        kx.read(path, unit="m", up="y")
    if isinstance(line, str):
        # the line that has this in it
        content = path.read_text()
        line = content.count("\n", 0, content.index(line)) + 1
    assert line is None or caught.value.line == line
    assert "a.bvh" in str(caught.value)


@pytest.mark.parametrize("python", [False, True], ids=["native", "python"])
@pytest.mark.parametrize("damage", AMC_DAMAGE)
def test_a_damaged_amc_is_one_error_with_its_line(tmp_path, monkeypatch, damage, python) -> None:
    """What is wrong, where, and what was expected; with and without the compiled parser."""
    if python:
        monkeypatch.setenv("KINESICS_NO_NATIVE", "1")
    change, line, words = AMC_DAMAGE[damage]
    (tmp_path / "07.asf").write_text(small_files.ASF)
    path = tmp_path / "07_01.amc"
    path.write_text(change(small_amc()))
    with pytest.raises(FileError, match=words) as caught:
        kx.read(path, up="y")
    assert line is None or caught.value.line == line


def test_other_text_is_no_bvh_that_was_cut_off(tmp_path) -> None:
    """What does not begin as one is called by what it begins with."""
    (tmp_path / "notes.bvh").write_text("hello\n")
    with pytest.raises(FileError, match=r"begin with HIERARCHY, got 'hello'\.$"):
        kx.read(tmp_path / "notes.bvh")


def test_a_bvh_cut_off_anywhere_is_said_to_be(tmp_path) -> None:
    """Whichever byte is the last one: only within the very last number nothing can be told."""
    whole = small_bvh().rstrip()
    path = tmp_path / "a.bvh"
    before_last_number = whole.rindex(" ") + 1
    for end in range(1, before_last_number + 1):
        path.write_text(whole[:end])
        with pytest.raises(FileError, match=r"seems cut off.*fetch or export it again") as caught:
            kx.read(path, unit="m", up="y")
        assert caught.value.line == whole[:end].rstrip().count("\n") + 1


@pytest.mark.parametrize("damage", ASF_DAMAGE)
def test_a_damaged_asf_is_an_error_that_names_it(tmp_path, damage) -> None:
    """The error is about the .asf, not about the .amc that was asked for."""
    change, words = ASF_DAMAGE[damage]
    (tmp_path / "07.asf").write_text(change(small_files.ASF))
    (tmp_path / "07_01.amc").write_text(small_amc())
    with pytest.raises(FileError, match=words) as caught:
        kx.read(tmp_path / "07_01.amc", up="y")
    assert caught.value.path.endswith("07.asf")
    assert caught.value.line is not None


def test_an_asf_with_small_faults_is_read_with_warnings(tmp_path) -> None:
    """Limits that do not fit and bones that hang nowhere are left out, and this is said."""
    asf = small_files.ASF.replace("            (-60.0 inf)\n", "").replace("root lhipjoint lowerback", "root lhipjoint")
    (tmp_path / "07.asf").write_text(asf)
    amc = "".join(s for s in small_amc().splitlines(keepends=True) if not s.startswith("lowerback"))
    (tmp_path / "07_01.amc").write_text(amc)
    motion = kx.read(tmp_path / "07_01.amc", up="y")
    assert any("2 limits for 3 degrees of freedom" in w for w in motion.warnings)
    assert any("'lowerback' not connected" in w for w in motion.warnings)


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        (b"", "an empty file"),
        (b"PK\x03\x04" + bytes(99), "zip archive"),
        (b"\x89PNG\r\n\x1a\n" + bytes(99), "picture"),
        (b"\xff\xd8\xff\xe0" + bytes(99), "picture"),
        (b"RIFF\x10\x00\x00\x00AVI LIST" + bytes(99), "video"),
        (b"\x00\x00\x00\x18ftypmp42" + bytes(99), "video"),
        (b"Kaydara FBX Binary  \x00" + bytes(99), "FBX"),
        (b"\x02P" + bytes(510), "C3D"),
        (bytes(999), "zero bytes"),
        (b"\x1f\x8b\x08" + bytes(99), "gzip"),
        (b"<!DOCTYPE html><html>404</html>", "web page"),
        (b"version https://git-lfs.github.com/spec/v1\n", "LFS"),
        (random.Random(3).randbytes(5000), "binary data"),
    ],
)
@pytest.mark.parametrize("name", ["a.bvh", "a.amc", "a.xyz"])
def test_a_file_that_is_no_recording_is_called_what_it_is(tmp_path, raw, words, name) -> None:
    """Whatever its name says."""
    (tmp_path / name).write_bytes(raw)
    with pytest.raises(FileError, match=words):
        kx.read(tmp_path / name)


def test_text_that_is_no_recording(tmp_path) -> None:
    """With a suffix of ours the error says what was expected there, else which formats there are."""
    (tmp_path / "a.txt").write_text("Dear diary,\n")
    with pytest.raises(FileError, match=r"can be read: .*\.amc.*\.bvh"):
        kx.read(tmp_path / "a.txt")
    (tmp_path / "a.bvh").write_text("Dear diary,\n")
    with pytest.raises(FileError, match="begin with HIERARCHY"):
        kx.read(tmp_path / "a.bvh")
    (tmp_path / "x.asf").write_text("Dear diary,\n")
    (tmp_path / "a.amc").write_text(small_amc())
    with pytest.raises(FileError, match=r"x\.asf: Expected a skeleton"):
        kx.read(tmp_path / "a.amc")


def test_things_that_are_no_files(tmp_path) -> None:
    """A folder, nothing at all, a device that never ends, a name that cannot be."""
    with pytest.raises(FileError, match=r"^[^:]*: Expected a file, but this is a folder. Give one file of it.$"):
        kx.read(tmp_path)
    with pytest.raises(FileError, match="no such file"):
        kx.read(tmp_path / "none.bvh")
    with pytest.raises(FileError, match="device"):
        kx.read("/dev/zero")
    with pytest.raises(FileError, match="cannot be opened"):
        kx.read("a\0b.bvh")


@pytest.mark.parametrize("head", [b"", small_files.BVH_TREE.encode()], ids=["empty", "bvh"])
def test_two_gigabytes_are_refused_before_they_are_read(tmp_path, head) -> None:
    """The size is looked at first; a sparse file takes no room on the disk."""
    path = tmp_path / "a.bvh"
    with path.open("wb") as file:
        file.write(head)
        file.truncate(2 << 30)
    with pytest.raises(FileError, match=r"2\.0 GiB; at most 1 GiB|zero bytes"):
        kx.read(path)


def test_a_skeleton_as_deep_as_a_well_is_read(tmp_path) -> None:
    """Depth is no recursion: a thousand joints in one chain, there and back."""
    depth = 1000
    head = "HIERARCHY\nROOT j0\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n"
    head += "".join(f"JOINT j{k}\n{{\nOFFSET 0 1 0\n" for k in range(1, depth)) + "}\n" * depth
    path = tmp_path / "deep.bvh"
    path.write_text(head + "MOTION\nFrames: 1\nFrame Time: 1\n10\n")
    motion = kx.read(path, unit="m", up="y")
    assert motion.skeleton.joint_count == depth
    kx.write(motion, tmp_path / "again.bvh")
    assert kx.read(tmp_path / "again.bvh", unit="m", up="y").skeleton.joint_count == depth


# ------------------------------------------------------------------------------------------------- fuzz

WORDS = [
    *(
        "{",
        "}",
        "-",
        "e",
        "E+",
        ".",
        "nan",
        "inf",
        "1e308",
        "-1e-320",
        "1e400",
        "0",
        "99999999999999999999",
        "\0",
        "\xff",
    ),
    *(
        "\n",
        "\r",
        "\t",
        " ",
        "#",
        "//",
        ":",
        "JOINT x\n{",
        "ROOT y",
        "End Site",
        "OFFSET",
        "CHANNELS 3",
        "MOTION",
        "Frames: 3",
    ),
    *(
        "Frame Time: 0",
        "Xrotation",
        "root 1 2 3 4 5 6",
        ":DEGREES",
        ":bonedata",
        "begin",
        "end",
        "dof rx",
        "limits (",
        "length 0",
    ),
]


def mutated(content: str, choose: random.Random) -> bytes:
    """Bytes cut, doubled, moved, replaced: a few times over."""
    data = bytearray(content.encode("latin-1"))
    for _ in range(choose.randint(1, 6)):
        a, b = sorted(choose.randrange(len(data) + 1) for _ in range(2))
        b = min(b, a + choose.choice([1, 4, 40, 400]))
        match choose.randrange(7):
            case 0:
                del data[a:b]
            case 1:
                data[a:a] = data[a:b]
            case 2:
                data[a:b] = choose.choice(WORDS).encode("latin-1")
            case 3:
                data[a:a] = choose.choice(WORDS).encode("latin-1")
            case 4:
                del data[a:]
            case 5:
                lines = data.split(b"\n")
                k = choose.randrange(len(lines))
                lines.insert(choose.randrange(len(lines)), lines.pop(k))
                data = bytearray(b"\n".join(lines))
            case 6 if len(data):
                data[choose.randrange(len(data))] = choose.randrange(256)
    return bytes(data)


def read_or_refuse(path) -> None:
    """A valid motion, or an error of ours; warnings are errors here."""
    try:
        motion = kx.read(path)
    except InputError:
        return
    assert np.isfinite(motion.positions()).all()
    assert motion.frame_count > 0
    assert motion.fps > 0


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(seed=st.integers(0, 2**32))
def test_mutated_files_are_read_or_refused(tmp_path, seed) -> None:
    """Whatever happens to a file, either a valid motion or a FileError comes out."""
    choose = random.Random(seed)
    kind = choose.randrange(3)
    asf, amc, bvh = small_files.ASF, small_amc(), small_bvh()
    (tmp_path / "07.asf").write_bytes(mutated(asf, choose) if kind == 1 else asf.encode())
    (tmp_path / "07_01.amc").write_bytes(mutated(amc, choose) if kind == 2 else amc.encode())
    (tmp_path / "a.bvh").write_bytes(mutated(bvh, choose))
    read_or_refuse(tmp_path / ("a.bvh" if kind == 0 else "07_01.amc"))


@pytest.mark.long
def test_many_mutated_files_are_read_or_refused(tmp_path) -> None:
    """The same for a hundred thousand files."""
    for seed in range(100_000):
        test_mutated_files_are_read_or_refused.hypothesis.inner_test(tmp_path, seed)
