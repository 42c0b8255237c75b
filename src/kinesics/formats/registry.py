"""What a file format is, and which there are.

A new format is one file in this folder: a module with a constant ``FORMAT``. It reads into a `Recording`, which speaks as
the file does (its unit, its axes); metres, y up and everything else that is the same for all formats is done once, in
`kinesics.formats`.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.body.feet import Soles
from kinesics.body.motion import Motion, Source
from kinesics.body.skeleton import Skeleton
from kinesics.errors import FileError, InputError

Array = NDArray[np.float64]

HEAD_BYTES: Final = 8192
"""How much of a file a format sees to recognise it by."""


@dataclass(frozen=True)
class ReadOptions:
    """What the caller of `kinesics.formats.read` says that the file does not, or says wrongly."""

    skeleton: Path | None = None
    unit: str | float | None = None
    up: str | None = None
    fps: float | None = None
    keep_first_frame: bool = False


@dataclass(frozen=True)
class Recording:
    """What a file says, in its own unit and its own axes, angles already turned into quaternions."""

    skeleton: Skeleton
    rotations: Array
    """Relative to the parents, shape (frames, joints, 4)."""
    root_positions: Array
    """Shape (frames, 3)."""
    fps: float
    joint_translations: Array | None = None
    """Shape (frames, joints, 3), where joints other than the root move; entry 0 is not read."""
    metres_per_unit: float | None = None
    """Where the file says so; else it is judged by the body."""
    up_axis: str | None = None
    """Where the file says so; else it is judged by the body."""
    assumptions: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    details: Mapping[str, str] = field(default_factory=dict)
    """What the format wants back on writing."""
    name: str | None = None
    """Of the motion, where the file says so; else it is the file's."""
    source: Source | None = None
    """Where the movement came from before it was in this file, where the file says so."""


@dataclass(frozen=True)
class Written:
    """Files ready to be put down, all or none, and what they could not hold."""

    files: tuple[tuple[Path, bytes], ...]
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Format:
    """One way to keep a recording in a file."""

    name: str
    """Short, such as "bvh"; kept in `kinesics.body.motion.Source.format`."""
    title: str
    """For people."""
    suffixes: tuple[str, ...]
    """With the point, small letters; the first is the one to write."""
    sniff: Callable[[bytes], bool]
    """Whether a file that begins with these bytes (at most `HEAD_BYTES`) is of this format."""
    read: Callable[[Path, bytes, ReadOptions], Recording] | None = None
    """From a path and what lies there."""
    write: Callable[[Motion, Path], Written] | None = None
    """To the bytes to be put at a path."""
    extras: Callable[[Motion, Path, Mapping[str, NDArray[Any]]], Written] | None = None
    """As ``write``, with further arrays by name, where the format has room for them."""
    on_soles: Callable[[Motion, Path, Soles], Written] | None = None
    """As ``write``, by a body whose soles are known, where the format has a figure that stands on them."""


@cache
def formats() -> tuple[Format, ...]:
    """All formats: the ``FORMAT`` of every module of this folder that has one, by name."""
    found = []
    package = importlib.import_module("kinesics.formats")
    for module in pkgutil.iter_modules(package.__path__):
        candidate = getattr(importlib.import_module(f"kinesics.formats.{module.name}"), "FORMAT", None)
        if isinstance(candidate, Format):
            found.append(candidate)
    return tuple(sorted(found, key=lambda f: f.name))


def readable() -> tuple[Format, ...]:
    """The formats that can be read."""
    return tuple(f for f in formats() if f.read is not None)


def writable() -> tuple[Format, ...]:
    """The formats that can be written."""
    return tuple(f for f in formats() if f.write is not None)


def describe(some: tuple[Format, ...]) -> str:
    """Formats in words: title and suffixes."""
    return ", ".join(f"{f.title} ({' '.join(f.suffixes)})" for f in some)


def of_content(path: Path, head: bytes) -> Format:
    """The format of a file, by how it begins; the suffix decides only between equals.

    Raises
    ------
    FileError
        If no format fits; the message says what the file looks like instead.
    """
    candidates = [f for f in readable() if f.sniff(head)]
    by_suffix = [f for f in candidates or readable() if path.suffix.lower() in f.suffixes]
    looks_like = None if candidates else _looks_like(head)
    if by_suffix and looks_like is None:
        return by_suffix[0]
    if candidates:
        return candidates[0]
    problem = (
        f"Expected a recording of movement, but it looks like {looks_like}."
        if looks_like
        else "This is no recording of movement that kinesics knows."
    )
    raise FileError(path, problem, hint=f"Recordings that can be read: {describe(readable())}.")


def for_writing(path: Path) -> Format:
    """The format to write, by the suffix.

    Raises
    ------
    InputError
        If no format that can be written has this suffix.
    """
    for candidate in writable():
        if path.suffix.lower() in candidate.suffixes:
            return candidate
    raise InputError(
        f"'{path.name}' does not say in which format to write. Expected a name that ends in one of: "
        f"{' '.join(s for f in writable() for s in f.suffixes)}."
    )


_SIGNATURES: Final[tuple[tuple[int, bytes, str], ...]] = (
    (0, b"PK\x03\x04", "a zip archive (unpack it first)"),
    (0, b"\x1f\x8b", "a gzip archive (unpack it first)"),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive (unpack it first)"),
    (0, b"Rar!", "a RAR archive (unpack it first)"),
    (257, b"ustar", "a tar archive (unpack it first)"),
    (0, b"\x89PNG", "a picture (PNG)"),
    (0, b"\xff\xd8\xff", "a picture (JPEG)"),
    (0, b"GIF8", "a picture (GIF)"),
    (8, b"WEBP", "a picture (WebP)"),
    (8, b"AVI ", "a video (AVI)"),
    (8, b"WAVE", "a sound (WAV)"),
    (4, b"ftyp", "a video (MP4)"),
    (0, b"\x1aE\xdf\xa3", "a video (Matroska or WebM)"),
    (0, b"Kaydara FBX Binary", "an FBX file"),
    (0, b"; FBX", "an FBX file"),
    (0, b"glTF", "a glTF file"),
    (0, b"%PDF", "a PDF document"),
    (0, b"\x93NUMPY", "a NumPy array"),
    (0, b"BLENDER", "a Blender file"),
    (0, b"SQLite format 3", "a database"),
    (0, b"PathFileType", "a TRC file of marker positions"),
)


def _looks_like(head: bytes) -> str | None:
    """What a file that is no recording seems to be; None for text."""
    if not head:
        return "an empty file"
    for offset, mark, what in _SIGNATURES:
        if head[offset : offset + len(mark)] == mark:
            return what
    if len(head) > 1 and head[1] == 0x50 and 1 < head[0] < 128 and b"\0" in head:
        return "a C3D file of marker positions"
    start = head[:512].lstrip().lower()
    if start.startswith((b"<!doctype html", b"<html")):
        return "a web page (was the download refused?)"
    if start.startswith(b"version https://git-lfs"):
        return "a Git LFS pointer (run 'git lfs pull')"
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return None
    if not head.strip(b"\0"):
        return "nothing but zero bytes (a copy that was cut off?)"
    return "binary data" if b"\0" in head else None
