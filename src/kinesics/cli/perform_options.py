"""What is asked for on the command line of ``kinesics perform``: its options, and how places and routes are written."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from kinesics.errors import FileError, InputError

_PANEL: Final = "What is performed"
_LONGEST_ROUTE: Final = 100_000


def _wish(flag: str, metavar: str, told: str) -> Any:
    return typer.Option(flag, metavar=metavar, rich_help_panel=_PANEL, show_default=False, help=told)


def _switch(flag: str, told: str) -> Any:
    return typer.Option(flag, rich_help_panel=_PANEL, help=told)


Files = Annotated[
    list[Path], typer.Argument(metavar="FILE", show_default=False, help="Recordings to perform from; one will do.")
]
Out = Annotated[
    list[Path] | None,
    typer.Option(
        "--out",
        metavar="OUT",
        show_default=False,
        help="The new movement: .bvh, .amc (and .asf), .glb or .npz; several times for several of them.",
    ),
]
Target = Annotated[
    str | None, _wish("--target", "X,Z", "Go to a place: metres to the left (X) and ahead (Z) of the start.")
]
Within = Annotated[float | None, _wish("--within", "METRES", "How near to --target counts as there; 0.5 unless given.")]
Route = Annotated[
    Path | None,
    _wish("--route", "CSV", "Follow a line on the floor: a corner x,z a row, in metres from the start."),
]
From = Annotated[str | None, _wish("--from", "S", "Begin in this state of the motion graph: A, 'A*', X~.")]
To = Annotated[
    str | None, _wish("--to", "S", "Go to this state (with --from) by the quickest way; a transition counts as 3 s.")
]
Favour = Annotated[
    str | None,
    _wish(
        "--favour",
        "WORD",
        "Much of this: a recording or a word in the names of recordings (walk); a class, state, path or phrase as analyze writes "
        "them (A*). Beside a goal a soft pull only.",
    ),
]
Seconds = Annotated[
    float | None,
    _wish("--seconds", "S", "How long; with a goal at most. 20 unless given, or what the goal may take."),
]
Linger = Annotated[bool, _switch("--linger", "With a goal, go on to the end of --seconds when it is attained.")]
Seed = Annotated[
    int, typer.Option("--seed", metavar="N", rich_help_panel=_PANEL, help="Another number, another performance.")
]
Beta = Annotated[
    float,
    typer.Option(
        "--beta", metavar="B", rich_help_panel=_PANEL, help="How strictly the goal decides: 0 strolls, inf never."
    ),
]
Bend = Annotated[
    float | None,
    _wish(
        "--bend",
        "DEG",
        "How much the way may be bent towards the goal, degrees a metre; more is tried where that does not do. 0: none. Unless "
        "given 5, or more where the way becomes far shorter by it.",
    ),
]
Backwards = Annotated[
    bool,
    _switch(
        "--backwards",
        "Recordings may be played backwards, too, wherever pose and velocity fit: good for ways that can be taken both ways; a "
        "jump or fall taken back looks wrong.",
    ),
]
NoMirror = Annotated[bool, _switch("--no-mirror", "No mirror images of the recordings.")]
Threshold = Annotated[
    float | None, _wish("--threshold", "D", "Largest mean distance D of a transition; found unless given.")
]
SkeletonOf = Annotated[
    Path | None,
    _wish(
        "--skeleton-of",
        "FILE",
        "Perform on the body of this recording (its movement is not used); of the first unless given.",
    ),
]
Fps = Annotated[float | None, _wish("--fps", "F", "Frames a second of the new movement; of the first unless given.")]
Edits = Annotated[
    Path | None,
    _wish("--edits", "TOML", "Your names for --from, --to and --favour; FILE.edits.toml where that is there."),
]
SkipUnusable = Annotated[
    bool,
    typer.Option(
        "--skip-unusable", help="Go on without files that cannot be read, or whose skeletons are not understood."
    ),
]


def target_of(text: str) -> tuple[float, float]:
    """A place as it is written after --target. Raises InputError where it is none."""
    parts = text.replace(";", ",").split(",")
    try:
        x, z = (float(part) for part in parts)
    except ValueError:
        raise InputError(
            f"Expected --target as two numbers, X,Z in metres, such as --target 3,2; got '{text}'."
        ) from None
    return x, z


def route_of(file: Path) -> list[tuple[float, float]]:
    """Corners of a route: two numbers a row (see `_words`); a heading may stand above. Raises FileError where it is none."""
    from kinesics import formats

    try:
        text = formats.load(file).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(file, "is not UTF-8 text.", hint="Expected rows of two numbers, x,z in metres.") from None
    corners: list[tuple[float, float]] = []
    headed = False
    for number, row in enumerate(text.splitlines(), start=1):
        words = _words(row)
        if not words:
            continue
        try:
            values = [float(word) for word in words]
        except ValueError:
            if not corners and not headed:
                headed = True
                continue
            values = []
        if len(values) != 2 or not all(math.isfinite(v) for v in values):
            raise FileError(
                file, f"Expected two numbers, x,z in metres, got '{row.strip()[:60]}'.", line=number
            ) from None
        corners.append((values[0], values[1]))
        if len(corners) > _LONGEST_ROUTE:
            raise FileError(file, f"More than {_LONGEST_ROUTE} corners.", hint="Give fewer points of the line.")
    if len(corners) < 2:
        raise FileError(
            file,
            f"Expected a line of two corners or more, got {len(corners)}.",
            hint="Write a corner a row, x,z in metres from where the performer starts; for one place there is --target.",
        )
    return corners


def _words(row: str) -> list[str]:
    """What stands in a row of a table, as spreadsheets write it: between commas, semicolons, tabs or blanks, in quotes or not.

    Beside semicolons a comma is the decimal one.
    """
    row = row.split("#")[0].replace('"', " ")
    return row.replace(",", "." if ";" in row else " ").replace(";", " ").split()
