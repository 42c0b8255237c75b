"""How a recording is named on the command line: the options that every command shares, and the reading."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinesics.cli import terminal

if TYPE_CHECKING:
    from kinesics.body.motion import Motion
    from kinesics.grammar.edits import Edits
    from kinesics.progress import Progress

_MOST_BAD = 12
_PANEL = "How to read the file"

Skeleton = Annotated[
    Path | None,
    typer.Option(
        "--skeleton",
        metavar="ASF",
        rich_help_panel=_PANEL,
        help="The skeleton of an AMC file, where it is not beside it.",
    ),
]
Map = Annotated[
    Path | None,
    typer.Option(
        "--map",
        metavar="TOML",
        rich_help_panel=_PANEL,
        help="Which joint is what, where the skeleton is not understood.",
    ),
]
Unit = Annotated[
    str | None,
    typer.Option(
        "--unit",
        metavar="U",
        rich_help_panel=_PANEL,
        help="Unit of length: m, cm, mm, in, ft, asf, or metres per unit.",
    ),
]
Up = Annotated[
    str | None,
    typer.Option("--up", metavar="A", rich_help_panel=_PANEL, help="The axis that points up: x, y, z, -x, -y, -z."),
]
Fps = Annotated[
    float | None,
    typer.Option(
        "--fps", metavar="F", rich_help_panel=_PANEL, help="Frames a second, where the file does not say or is wrong."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, alone, on stdout.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")]


@dataclass(frozen=True)
class Reading:
    """What the user says of the files."""

    skeleton: Path | None = None
    map: Path | None = None
    unit: str | None = None
    up: str | None = None
    fps: float | None = None

    def mapping(self) -> Mapping[str, object] | None:
        """The mapping file as a table.

        Raises
        ------
        FileError
            If it is missing or no TOML.
        """
        from kinesics import formats

        return None if self.map is None else formats.read_mapping(self.map)

    def read_all(
        self, files: Sequence[Path], *, skip: bool, progress: Progress
    ) -> tuple[list[tuple[Path, Motion]], list[str]]:
        """Read recordings of human bodies; those that cannot be read or understood are named together.

        Parameters
        ----------
        skip : go on without these, where others are left.

        Returns
        -------
        Each file with what is in it, and what was wrong with those left out.

        Raises
        ------
        InputError
            If one cannot be read or understood, or with ``skip`` none can.
        """
        from kinesics.errors import InputError

        read: list[tuple[Path, Motion]] = []
        bad: list[tuple[Path, InputError]] = []
        for number, file in enumerate(files):
            progress(number / len(files), f"reading {file.name}")
            try:
                read.append((file, self.read_body(file)))
            except InputError as error:
                bad.append((file, error))
        if not bad or (skip and read):
            return read, [f"left out: {error}" for _, error in bad]
        if len(files) == 1:
            raise bad[0][1]
        told = "\n".join(f"  {error}" for _, error in bad[:_MOST_BAD])
        if len(bad) > _MOST_BAD:
            told += f"\n  and {len(bad) - _MOST_BAD} more: {', '.join(str(file) for file, _ in bad[_MOST_BAD:])}"
        helps = " Mend what is wrong, or go on without: --skip-unusable." if read else ""
        raise InputError(f"{len(bad)} of {len(files)} recordings cannot be used.{helps}\n{told}")

    def read_body(self, file: Path) -> Motion:
        """Read a recording of a human body.

        Raises
        ------
        InputError
            If it cannot be read, or its skeleton not be understood.
        """
        from kinesics.body import anatomy
        from kinesics.errors import SkeletonError

        try:
            return anatomy.understood(self.read(file), self.mapping())
        except SkeletonError as error:
            raise SkeletonError(f"{file}: {error}", found=error.found, missing=error.missing) from error

    def read(self, file: Path) -> Motion:
        """Read a recording the way the user says.

        Raises
        ------
        InputError
            If it cannot be read.
        """
        from kinesics import formats

        return formats.read(
            file, skeleton=self.skeleton, unit=self.unit, up=self.up, fps=self.fps, mapping=self.mapping()
        )


def check_none_of(outs: Iterable[Path], files: Iterable[Path | None]) -> None:
    """Refuse to write where something is read from, whatever may be replaced.

    Raises
    ------
    InputError
        If an output, or the .asf beside an .amc, is one of the files.
    """
    from kinesics.errors import InputError

    read = [file for file in files if file is not None and file.exists()]
    for out in outs:
        for written in (out, *([out.with_suffix(".asf")] if out.suffix.lower() == ".amc" else [])):
            if written.exists() and any(written.samefile(file) for file in read):
                raise InputError(f"'{written}' is one of the recordings; give the new movement another name.")


def skeleton_beside(file: Path, motion: Motion) -> Path | None:
    """The file of the skeleton that was found beside a recording; None where there is none."""
    name = motion.source.details.get("skeleton_file")
    return None if name is None else file.with_name(str(name))


def edits_beside(file: Path) -> Path | None:
    """The side file of a recording, where it is there; that it is honoured is said."""
    side = file.with_name(f"{file.name}.edits.toml")
    if not side.is_file():
        return None
    terminal.remark(f"Edits: {side.name}")
    return side


def read_edits(file: Path | None) -> Edits | None:
    """What a person knows better, of a side file.

    Raises
    ------
    FileError
        If it is missing, no text, or says what cannot be.
    """
    from kinesics import formats
    from kinesics.errors import FileError, InputError
    from kinesics.grammar import edits

    if file is None:
        return None
    try:
        return edits.parse(formats.load(file).decode("utf-8-sig"), file.name)
    except UnicodeDecodeError:
        raise FileError(file, "is not UTF-8 text.") from None
    except FileError:
        raise
    except InputError as error:
        raise FileError(file, str(error)) from None
