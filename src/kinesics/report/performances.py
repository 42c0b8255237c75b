"""A performance in files: the movement, where every frame comes from, and a picture of its way over the floor."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from kinesics import formats, plotting
from kinesics.body.contacts import runs
from kinesics.errors import FileError, InputError, MissingExtraError
from kinesics.plotting.canvas import figure_bytes
from kinesics.progress import Progress, silent
from kinesics.synthesis.piece import Piece

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILMS: Final = (".mp4", ".webm")
"""Suffixes of films, which are not made yet."""
IN_PLACE: Final = 1.0
"""Metres: a movement that keeps within is shown as a contact sheet, not as a trail."""


class Saved(NamedTuple):
    """What `save_performance` left."""

    motion: Path
    provenance: Path
    picture: Path
    remarks: tuple[str, ...]
    """What the format could not hold."""


def files_of(path: str | os.PathLike[str]) -> tuple[Path, Path, Path]:
    """The movement's file, and its provenance and picture beside it."""
    target = Path(path)
    return target, target.with_name(f"{target.stem}.provenance.json"), target.with_name(f"{target.stem}.png")


def check_output(path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
    """Refuse, before any work is done, what could not be written afterwards.

    Raises
    ------
    MissingExtraError
        If a film is wished for.
    InputError
        If the suffix belongs to no format, the folder does not exist, or a file is there and may not be replaced.
    """
    target, *beside = files_of(path)
    works = " ".join(s for f in formats.writable() for s in f.suffixes if s != ".asf")
    suffix = target.suffix.lower()
    if suffix in FILMS:
        raise MissingExtraError(
            f"'{target.name}': films are not made yet; they will need the `video` extra (pip install 'kinesics[video]'). "
            f"A movement can be written now as: {works}. A picture of it is left beside each."
        )
    if not any(suffix in f.suffixes for f in formats.writable()):
        raise InputError(
            f"'{target.name}' does not say in which format to write. Expected a name that ends in one of: {works}."
        )
    if suffix == ".asf":
        raise InputError(
            f"'{target.name}' would be a skeleton alone. Give '{target.stem}.amc': the .asf is left beside it."
        )
    if not target.parent.is_dir():
        raise FileError(target, "The folder to write to does not exist.", hint="Make it first.")
    more = [target.with_suffix(".asf")] if suffix == ".amc" else []
    for there in (target, *more, *beside):
        if there.is_dir():
            raise InputError(f"'{there}' is a folder; give another name.")
        if there.exists() and not overwrite:
            whose = _movement_of(there, target) if there in beside else None
            if whose is not None:
                raise InputError(
                    f"'{there.name}' is there already, in '{there.parent}', and belongs to '{whose}': '{target.name}' would "
                    f"leave its own in its place. Nothing was performed. Give another name, such as '{target.stem}-2{suffix}', or "
                    "--overwrite."
                )
            raise InputError(
                f"'{there.name}' is there already, in '{there.parent}'; nothing was performed. Give another name, or --overwrite."
            )


def _movement_of(beside: Path, target: Path) -> str | None:
    """The other movement of that stem, beside which a file lies; None where there is none."""
    others = (beside.with_name(f"{target.stem}{s}") for f in formats.writable() for s in f.suffixes if s != ".asf")
    return next((other.name for other in others if other != target and other.exists()), None)


def save_performance(
    piece: Piece, path: str | os.PathLike[str], *, overwrite: bool = False, progress: Progress = silent
) -> Saved:
    """Write the movement in the format of the suffix; beside it its provenance (JSON) and its picture (PNG).

    All is made before the first file is put down, so that stopping half-way leaves nothing half-written. In .npz the provenance
    of every frame is also in the file itself (`kinesics.formats.read_extras`).

    Raises
    ------
    MissingExtraError, InputError
        See `check_output`.
    """
    check_output(path, overwrite=overwrite)
    target, provenance, image = files_of(path)
    progress(0.0, "drawing")
    drawn = figure_bytes(picture(piece), ".png")
    told = provenance_json(piece).encode()
    progress(0.6, f"writing {target.name}")
    extras = piece.extras() if target.suffix.lower() == ".npz" else None
    remarks: list[str] = []

    def install() -> None:
        remarks.extend(formats.write(piece.motion, target, overwrite=overwrite, extras=extras))
        for file, data in ((provenance, told), (image, drawn)):
            part = file.with_name(f".{file.name}.part")
            try:
                part.write_bytes(data)
                part.replace(file)
            except OSError as error:
                raise FileError(file, f"The file cannot be written: {error.strerror or error}.") from None
            finally:
                part.unlink(missing_ok=True)

    _unstopped(install)
    progress(1.0, "saved")
    return Saved(target, provenance, image, tuple(remarks))


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
    stays = bool(np.ptp(piece.trail, axis=0).max() < IN_PLACE) and not piece.places and goal["route"] is None
    played = sorted({span.source for span in piece.spans})
    whence = " and ".join(piece.sources[k].name for k in played) if len(played) <= 2 else f"{len(played)} recordings"
    lasts = piece.motion.duration
    title = f"{lasts:.1f} s from {whence}" if lasts >= 1.0 else f"{lasts:.2g} s from {whence}"
    if piece.outcome:
        title += f": {piece.outcome[0]}"
    if stays:
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


def provenance_json(piece: Piece) -> str:
    """The text of ``*.provenance.json``: the same bytes for the same performance."""
    return json.dumps(piece.to_dict(), ensure_ascii=False, indent=1, allow_nan=False) + "\n"


def performance_schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of ``*.provenance.json``."""
    text = resources.files("kinesics.report").joinpath("provenance.schema.json").read_text(encoding="utf-8")
    result: dict[str, Any] = json.loads(text)
    return result
