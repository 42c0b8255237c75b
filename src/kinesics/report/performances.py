"""A performance in files: the movement, where every frame comes from, and a picture of its way over the floor."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from kinesics import formats, plotting
from kinesics.body.contacts import runs
from kinesics.errors import FileError, InputError, MissingExtraError, some_of
from kinesics.plotting import letters
from kinesics.plotting.canvas import figure_bytes
from kinesics.progress import Progress, silent
from kinesics.synthesis.piece import Piece

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILMS: Final = (".mp4", ".webm")
"""Suffixes of films, which are not made yet."""


class Saved(NamedTuple):
    """What `save_performance` left."""

    motions: tuple[Path, ...]
    provenances: tuple[Path, ...]
    """One for all movements of a name."""
    pictures: tuple[Path, ...]
    remarks: tuple[str, ...]
    """What the formats could not hold, or the picture not show."""


Paths = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]
"""Of a file, or of several: the same movement in other formats or under other names."""


def files_of(path: str | os.PathLike[str]) -> tuple[Path, Path, Path]:
    """The movement's file, and its provenance and picture beside it."""
    target = Path(path)
    return target, target.with_name(f"{target.stem}.provenance.json"), target.with_name(f"{target.stem}.png")


def check_output(paths: Paths, *, overwrite: bool = False) -> None:
    """Refuse, before any work is done, what could not be written afterwards.

    Raises
    ------
    MissingExtraError
        If a film is wished for.
    InputError
        If a suffix belongs to no format, a folder does not exist, or a file is there and may not be replaced: unless ``overwrite``
        none may, and even then nothing that no performance left, nor the provenance and picture of a movement that stays.
    """
    targets = _targets(paths)
    for target in targets:
        _check_suffix(target)
    for target in targets:
        if not target.parent.is_dir():
            raise FileError(target, "The folder to write to does not exist.", hint="Make it first.")
        _check_free(target, targets, overwrite)
    for target in targets:
        # only trying tells whether a folder can be written to
        with _room_beside(target):
            pass


def _targets(paths: Paths) -> list[Path]:
    """Each file once."""
    several = [paths] if isinstance(paths, str | os.PathLike) else list(paths)
    if not several:
        raise InputError("Expected a file to write the movement to, got none.")
    once: dict[str, Path] = {}
    for path in several:
        once.setdefault(os.path.abspath(path), Path(path))
    return list(once.values())


def _check_suffix(target: Path) -> None:
    works = " ".join(s for f in formats.writable() for s in f.suffixes if s != ".asf")
    suffix = target.suffix.lower()
    if suffix in FILMS:
        raise MissingExtraError(
            f"'{target.name}': films are not made yet; they will need the `video` extra (pip install 'kinesics[video]'). "
            f"A movement can be written now as: {works}. A picture of it is left beside each."
        )
    if target.is_dir():
        raise InputError(f"'{target}' is a folder; give the name of a file in it, such as '{target / 'new.bvh'}'.")
    if not any(suffix in f.suffixes for f in formats.writable()):
        raise InputError(
            f"'{target.name}' does not say in which format to write. Expected a name that ends in one of: {works}."
        )
    if suffix == ".asf":
        raise InputError(
            f"'{target.name}' would be a skeleton alone. Give '{target.stem}.amc': the .asf is left beside it."
        )


def _check_free(target: Path, targets: Sequence[Path], overwrite: bool) -> None:
    """Refuse what is there already; and, whatever may be replaced, to take from a movement that stays what belongs to it."""
    _, *beside = files_of(target)
    suffix = target.suffix.lower()
    more = [target.with_suffix(".asf")] if suffix == ".amc" else []
    for there in (target, *more, *beside):
        if there.is_dir():
            raise InputError(f"'{there}' is a folder; give another name.")
        if not there.exists():
            continue
        where = f"'{there.name}' is there already, in '{there.parent}'"
        another = f"Give another name, such as '{target.stem}-2{suffix}'"
        whose = _staying(target, targets) if there in beside else ()
        if whose:
            together = " ".join(f"--out {name}" for name in (*whose, target.name))
            raise InputError(
                f"{where}, and belongs to {some_of(whose)}: '{target.name}' would leave its own in its place. Nothing was "
                f"performed. {another}; one movement in several formats is {together}"
                + (", which replaces all of them." if overwrite else " (and --overwrite).")
            )
        if not overwrite:
            raise InputError(f"{where}; nothing was performed. Give another name, or --overwrite.")
        if there != target and not _left_by_us(there, target):
            raise InputError(
                f"{where}, and no performance left it: it is not written over, whatever may be. Nothing was performed. {another}."
            )


def _staying(target: Path, targets: Sequence[Path]) -> tuple[str, ...]:
    """Movements that the provenance beside a file is of, too, and that stay as they are."""
    _, provenance, _ = files_of(target)
    told = _told(provenance)
    if told is None:
        return ()
    written = {os.path.abspath(t) for t in targets}
    others = (provenance.with_name(str(name)) for name in told)
    return tuple(other.name for other in others if other.exists() and os.path.abspath(other) not in written)


def _left_by_us(beside: Path, target: Path) -> bool:
    """Whether a file that would be written over was left beside a movement of that name."""
    if beside.suffix == ".asf":
        return target.exists()
    return _told(files_of(target)[1]) is not None


def _told(provenance: Path) -> list[Any] | None:
    """Names of the files whose provenance it is; None where it is none."""
    try:
        files = json.loads(provenance.read_text(encoding="utf-8"))["output"]["files"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return files if isinstance(files, list) else None


def save_performance(piece: Piece, paths: Paths, *, overwrite: bool = False, progress: Progress = silent) -> Saved:
    """Write the movement in the format of each suffix; beside it its provenance (JSON) and its picture (PNG).

    Files of one name in one folder, such as new.bvh and new.glb, share both. All is made before the first file is put down, so
    that stopping half-way leaves nothing half-written. In .npz the provenance of every frame is also in the file itself
    (`kinesics.formats.read_extras`).

    Raises
    ------
    MissingExtraError, InputError
        See `check_output`.
    """
    check_output(paths, overwrite=overwrite)
    targets = _targets(paths)
    progress(0.0, "drawing")
    figure = picture(piece)
    drawn = figure_bytes(figure, ".png")
    unknown = letters.lacking(figure)
    remarks = [f"The picture has {letters.UNKNOWN} for {unknown}: no font of this machine has it"] if unknown else []
    with contextlib.ExitStack() as stack:
        made: list[tuple[Path, Path]] = []
        for number, target in enumerate(targets):
            progress(0.6 + 0.4 * number / len(targets), f"writing {target.name}")
            room = stack.enter_context(_room_beside(target))
            extras = piece.extras() if target.suffix.lower() == ".npz" else None
            said = formats.write(piece.motion, room / target.name, extras=extras, soles=piece.performance.soles)
            remarks += said if len(targets) == 1 else [f"{target.name}: {line}" for line in said]
            _, provenance, image = files_of(target)
            together = [t.name for t in targets if files_of(t)[1] == provenance]
            told = provenance_json(piece, together).encode()
            for file, data in ((provenance, told), (image, drawn)):
                (room / file.name).write_bytes(data)
            made += [(file, target.with_name(file.name)) for file in sorted(room.iterdir())]

        def install() -> None:
            for file, place in made:
                try:
                    file.replace(place)
                except OSError as error:
                    raise FileError(place, f"The file cannot be written: {error.strerror or error}.") from None

        _unstopped(install)
    progress(1.0, "saved")
    provenances, pictures = (tuple(dict.fromkeys(files_of(target)[k] for target in targets)) for k in (1, 2))
    return Saved(tuple(targets), provenances, pictures, tuple(remarks))


@contextlib.contextmanager
def _room_beside(target: Path) -> Iterator[Path]:
    """A folder beside a file, where it and what belongs to it is made; gone afterwards."""
    try:
        room = Path(tempfile.mkdtemp(prefix=f".{target.stem[:40]}.", suffix=".part", dir=target.parent))
    except OSError as error:
        raise FileError(
            target, f"The file cannot be written: {error.strerror or error}.", hint="Give another folder."
        ) from None
    try:
        yield room
    finally:
        shutil.rmtree(room, ignore_errors=True)


def _unstopped(work: Callable[[], None]) -> None:
    """Run something short to its end, Ctrl-C or not: a movement without its provenance would be half a result."""
    import signal
    import threading

    if threading.current_thread() is not threading.main_thread():
        work()
        return
    stopped: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: stopped.append(number))
    try:
        work()
    finally:
        signal.signal(signal.SIGINT, before)
    if stopped:
        raise KeyboardInterrupt


def picture(piece: Piece) -> Figure:
    """The trail on the floor (Figure 82 of [Schultz2012]); a contact sheet where the body stays in place."""
    goal = piece.parameters
    played = sorted({span.source for span in piece.spans})
    whence = " and ".join(piece.sources[k].name for k in played) if len(played) <= 2 else f"{len(played)} recordings"
    lasts = piece.motion.duration
    title = f"{lasts:.1f} s from {whence}" if lasts >= 1.0 else f"{lasts:.2g} s from {whence}"
    if piece.outcome:
        title += f": {piece.outcome[0]}"
    if piece.in_place:
        ax = plotting.contact_sheet(
            piece.motion,
            transitions=piece.performance.cuts,
            mirrored=runs(piece.provenance.mirrored),
            title=title,
        )
    else:
        ax = plotting.trail_plot(
            piece.motion, target=piece.places or None, radius=piece.radius, route=goal["route"], title=title
        )
    figure = ax.get_figure(root=True)
    assert figure is not None
    return figure


def provenance_json(piece: Piece, files: Sequence[str] = ()) -> str:
    """The text of ``*.provenance.json``: the same bytes for the same performance.

    Parameters
    ----------
    files : names of the movement's files beside it.
    """
    told = piece.to_dict()
    told["output"]["files"] = list(files)
    return json.dumps(told, ensure_ascii=False, indent=1, allow_nan=False) + "\n"


def performance_schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of ``*.provenance.json``."""
    text = resources.files("kinesics.report").joinpath("provenance.schema.json").read_text(encoding="utf-8")
    result: dict[str, Any] = json.loads(text)
    return result
