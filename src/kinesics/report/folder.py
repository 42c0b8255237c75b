"""The folder that an analysis is kept in: all of it or nothing of it."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, Final

from kinesics.analysis import Analysis
from kinesics.errors import FileError, InputError
from kinesics.progress import Progress, silent
from kinesics.report import page, pictures, tables
from kinesics.report.helper import Helper

FACTS: Final = "analysis.json"
FRAMES: Final = "frames.csv"
EXPLAINED: Final = "tables.txt"
FILES: Final = (
    "report.html",
    "zz.png",
    "zz-triangle.png",
    "graph.svg",
    "graph.graphml",
    "phrases.csv",
    "motifs.csv",
    "cycles.csv",
    EXPLAINED,
    FRAMES,
    FACTS,
)
"""What `save` writes. The facts come last: a folder that has them has all."""


def save(
    analysis: Analysis,
    folder: str | os.PathLike[str],
    *,
    overwrite: bool = False,
    palette: str = "thesis",
    progress: Progress | None = None,
    helper: Helper | None = None,
) -> None:
    """Write an analysis into a folder: facts, tables, pictures and a page to read and to mail.

    All files are made beside the folder first and then put in their places, so that stopping half-way leaves what was there.
    The bytes depend on the analysis alone: no dates, no folder names.

    Parameters
    ----------
    folder : made if it does not exist. An empty folder is filled. One that holds an analysis of the same recording is
        replaced; files in it that are not the analysis's stay.
    overwrite : replace the analysis of another recording, or write among other files.
    palette : the colours of Z and Z* in the pictures: "thesis" (red and cyan) or "colorblind" (orange and blue).
    helper : a second process that draws along (`kinesics.report.helping`).

    Raises
    ------
    InputError
        If the folder holds something else and ``overwrite`` is not given, is a file, cannot be written; or if the analysis
        was read back from a folder and has no recording to draw; or if there is no such palette.
    """
    report = progress or silent
    pictures.check_palette(palette)
    target = Path(folder)
    _check(target, analysis, overwrite)
    if not analysis.motions:
        raise InputError(
            "This analysis was read back from a folder and has no recording to draw: analyse the recording again."
        )
    with _writing(target):
        parent = target.absolute().parent
        parent.mkdir(parents=True, exist_ok=True)
    with _writing(target):
        stage = Path(tempfile.mkdtemp(prefix=f".{target.absolute().name[:40]}-", dir=parent))
        try:
            for name, contents in _contents(analysis, palette, report, helper):
                (stage / name).write_bytes(contents)
            report(0.99, "putting the files in their places")
            _install(stage, target)
        finally:
            shutil.rmtree(stage, ignore_errors=True)
    report(1.0, "saved")


def load(folder: str | os.PathLike[str]) -> Analysis:
    """The analysis that `save` wrote: equal to the one saved, with its curves, without the recordings.

    Raises
    ------
    InputError
        If the folder holds no analysis, or one of another version.
    """
    path = Path(folder) / FACTS
    facts = _read_facts(path)
    curves_file = Path(folder) / FRAMES
    try:
        text = curves_file.read_text(encoding="utf-8")
    except FileNotFoundError:
        return Analysis.from_dict(facts)
    except OSError as error:
        raise FileError(curves_file, f"cannot be read: {error.strerror}.") from None
    try:
        speeds, reflected = tables.read_frames(text)
    except ValueError as error:
        raise FileError(curves_file, str(error)) from None
    return Analysis.from_dict(facts, speed_curves=speeds, mirror_distance_curves=reflected)


def schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of `analysis.json`."""
    text = resources.files("kinesics.report").joinpath("analysis.schema.json").read_text(encoding="utf-8")
    result: dict[str, Any] = json.loads(text)
    return result


def facts_json(analysis: Analysis) -> str:
    """The text of `analysis.json`."""
    return json.dumps(analysis.to_dict(), ensure_ascii=False, indent=1, allow_nan=False) + "\n"


def _contents(analysis: Analysis, palette: str, report: Progress, helper: Helper | None) -> Iterator[tuple[str, bytes]]:
    """Name and contents of every file, in the order of `FILES`."""
    drawn = pictures.draw(
        analysis, palette=palette, progress=lambda f, message="": report(0.8 * f, message), helper=helper
    )
    report(0.8, "the page")
    made: Mapping[str, bytes] = {
        "report.html": page.report_page(analysis, drawn, palette=palette).encode(),
        "zz.png": drawn.square,
        "zz-triangle.png": drawn.triangle,
        "graph.svg": drawn.graph,
        "graph.graphml": analysis.graph.to_graphml().encode(),
        "phrases.csv": tables.phrases(analysis).encode(),
        "motifs.csv": tables.motifs(analysis).encode(),
        "cycles.csv": tables.cycles(analysis).encode(),
        EXPLAINED: tables.EXPLAINED.encode(),
        FRAMES: tables.frames(analysis).encode(),
        FACTS: facts_json(analysis).encode(),
    }
    for name in FILES:
        yield name, made[name]


def _check(target: Path, analysis: Analysis, overwrite: bool) -> None:
    """Refuse before the work begins."""
    with _writing(target):
        for place in (target, *target.parents):
            if place.exists() and not place.is_dir():
                inside = "" if place == target else f", so '{target}' cannot be in it"
                raise InputError(f"'{place}' is a file{inside}; give the name of a folder.")
    if overwrite or not target.is_dir():
        return
    with _writing(target):
        held = sorted(entry.name for entry in target.iterdir())
    if not held:
        return
    if FACTS not in held:
        raise InputError(
            f"'{target}' holds other files ({', '.join(held[:3])}{' …' if len(held) > 3 else ''}) and no analysis. "
            "Choose another folder with --out, or write into this one with --overwrite."
        )
    try:
        there = [(s.get("name"), s.get("sha256")) for s in _read_facts(target / FACTS)["sources"]]
    except (InputError, KeyError, TypeError, AttributeError):
        # whatever it is, it is no analysis of ours
        there = None
    if there != [(s.name, s.sha256) for s in analysis.sources]:
        what = "something else" if there is None else f"the analysis of {_names([n for n, _ in there])}"
        same_name = there is not None and [n for n, _ in there] == [s.name for s in analysis.sources]
        why = ", with other contents than the file now" if same_name else ""
        raise InputError(
            f"'{target}' holds {what}{why}. Choose another folder with --out, or replace it with --overwrite."
        )


def _install(stage: Path, target: Path) -> None:
    """Move the finished files to where they belong."""
    if not target.exists():
        # mkdtemp makes folders for its owner alone; a result is as open as the user's other files
        mask = os.umask(0)
        os.umask(mask)
        stage.chmod(0o777 & ~mask)
        with contextlib.suppress(FileExistsError):
            stage.rename(target)
            return
    names = [name for name in FILES if (stage / name).exists()]
    interrupted: KeyboardInterrupt | None = None
    while names:
        # a handful of renames: being stopped between two of them would leave old and new side by side, so finish first
        try:
            (stage / names[0]).replace(target / names[0])
            names.pop(0)
        except KeyboardInterrupt as stop:
            interrupted = stop
    if interrupted is not None:
        raise interrupted


def _read_facts(path: Path) -> dict[str, Any]:
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise FileError(path, "is not there: the folder holds no analysis.") from None
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}.") from None
    except json.JSONDecodeError as error:
        raise FileError(path, f"is not JSON: {error.msg}.", line=error.lineno) from None
    except UnicodeDecodeError:
        raise FileError(path, "is not UTF-8 text.") from None
    if not isinstance(values, dict):
        raise FileError(path, "holds no JSON object.")
    return values


@contextlib.contextmanager
def _writing(target: Path) -> Iterator[None]:
    """Say in one sentence why a folder cannot be written."""
    try:
        yield
    except OSError as error:
        # the folders and the stage that are made on the way are nothing that the user named
        why = _WHY.get(error.errno or 0) or error.strerror or type(error).__name__
        raise InputError(f"'{target}' cannot be written: {why}. Give another folder (--out).") from None


_WHY: Final = {
    errno.ENOENT: "no folder can be made there",
    errno.EEXIST: "a file is in the way",
    errno.ENOTDIR: "a file is in the way",
}


def _names(names: Sequence[object]) -> str:
    return ", ".join(f"'{n}'" for n in names) or "nothing"
