"""Text files of numbers: lines, where they are, and the numbers in them, read in one pass.

The compiled parser (`kinesics._native`) is some five times faster than Python's; both give the same numbers to the last bit
and stop at the same places.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from kinesics import compiled
from kinesics.errors import FileError

Array = NDArray[np.float64]

LARGEST_VALUE: Final = 1e9
"""No length in any unit, and no angle in degrees, of a moving body is larger: such a number is a damaged one."""

CUT_OFF: Final = "The file seems cut off"
GET_AGAIN: Final = "fetch or export it again"

_CHUNK = 1024


class Table(NamedTuple):
    """Numbers of a text file, and where they stop."""

    values: Array
    """Shape (rows, columns)."""
    stop: int
    """Byte at which the first row begins that is not as it must be; −1 where all are."""


@dataclass(frozen=True)
class TextFile:
    """The bytes of a text file, with line feeds between the lines and no byte order mark."""

    path: Path
    data: bytes

    @classmethod
    def of(cls, path: Path, raw: bytes) -> TextFile:
        """From the bytes as they lie on the disk: UTF-8 or Latin-1, or UTF-16 with its mark; any line ends.

        Raises
        ------
        FileError
            If it is not text.
        """
        data = raw
        if data.startswith((b"\xff\xfe", b"\xfe\xff")):
            try:
                data = data.decode("utf-16").encode("utf-8")
            except UnicodeDecodeError:
                raise FileError(path, "Expected text, but it is neither UTF-8 nor UTF-16.") from None
        data = data.removeprefix(b"\xef\xbb\xbf")
        if b"\n" not in data:
            data = data.replace(b"\r", b"\n")
        if b"\0" in data[:4096]:
            raise FileError(path, "Expected text, but there are zero bytes in it.", line=1)
        return cls(path, data)

    def line_number(self, offset: int) -> int:
        """The 1-based line in which a byte lies."""
        return self.data.count(b"\n", 0, offset) + 1

    def line_at(self, offset: int) -> bytes:
        """The line that begins at a byte, without its end."""
        stop = self.data.find(b"\n", offset)
        return self.data[offset : len(self.data) if stop < 0 else stop]

    def ends_with_line_at(self, offset: int) -> bool:
        """Whether nothing but blanks follows the line that begins at a byte."""
        return not self.data[offset + len(self.line_at(offset)) :].strip()

    def fail(self, problem: str, *, offset: int | None = None, line: int | None = None, hint: str = "") -> NoReturn:
        """Raise a `FileError` that names the line."""
        if offset is not None:
            line = self.line_number(offset)
        raise FileError(self.path, problem, line=line, hint=hint or None)


def decode(data: bytes) -> str:
    """Text of bytes: UTF-8 where it is lawful, else Latin-1, which always is."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def number(word: str | bytes) -> float:
    """A finite decimal number.

    Raises
    ------
    ValueError
        If the word is anything else, "nan", "inf" and "1_000" among them.
    """
    value = float(word)
    grouped = b"_" in word if isinstance(word, bytes) else "_" in word
    if grouped or not math.isfinite(value):
        raise ValueError(word)
    return value


def short(word: str) -> str:
    """A word as it may stand in a message: damaged files have long ones."""
    shown = word if len(word) <= 40 else word[:37] + "..."
    return shown if shown.isprintable() else ascii(shown)[1:-1]


def why_not_a_number(word: str) -> str:
    """What is wrong with a word that should have been a number."""
    shown = short(word)
    try:
        float(word)
    except ValueError:
        if "," in word:
            return f"'{shown}' is not a number; decimals are written with a point."
        if "#" in word:
            return f"'{shown}' is not a number; the program that wrote the file had none there."
        return f"'{shown}' is not a number."
    return f"'{shown}' is not a finite number."


def refuse_huge(file: TextFile, values: Array) -> None:
    """Numbers that no body has, shape (frames, columns).

    Raises
    ------
    FileError
        If there is one; the message names the frame.
    """
    if values.size and max(values.max(), -values.min()) > LARGEST_VALUE:
        sizes = np.abs(values).max(axis=1)
        frame = int(np.argmax(sizes > LARGEST_VALUE))
        raise FileError(
            file.path,
            f"Frame {frame} (counted from 0) has a value of size {sizes[frame]:g}: no length or angle of a body.",
        )


def parse_rows(data: bytes, start: int, columns: int) -> Table:
    """Rows of numbers from byte ``start`` on, one row of ``columns`` numbers a line.

    Blank lines and lines that begin with ``#`` or ``//`` are passed over.
    """
    if compiled.wanted():
        values, stop = compiled.native.parse_rows(data, start, columns)
        return Table(values, stop)
    return _parse_rows_python(data, start, columns)


def parse_labelled(data: bytes, start: int, labels: list[str], counts: list[int]) -> Table:
    """Frames of labelled numbers from byte ``start`` on, shape (frames, 1 + sum of ``counts``).

    A frame is a line with its number (column 0), then for each label a line with the label and so many numbers. Blank lines
    and lines that begin with ``#`` are passed over.
    """
    if compiled.wanted():
        values, stop = compiled.native.parse_labelled(data, start, labels, counts)
        return Table(values, stop)
    return _parse_labelled_python(data, start, labels, counts)


def _parse_rows_python(data: bytes, start: int, columns: int) -> Table:
    blocks: list[Array] = []
    rows: list[list[float]] = []
    position = start
    for line in data[start:].split(b"\n"):
        words = line.split()
        if words and not words[0].startswith((b"#", b"//")):
            row = _numbers(words, line) if len(words) == columns else None
            if row is None:
                return Table(_stacked(blocks, rows, columns), position)
            rows.append(row)
            if len(rows) == _CHUNK:
                blocks.append(np.array(rows))
                rows = []
        position += len(line) + 1
    return Table(_stacked(blocks, rows, columns), -1)


def _parse_labelled_python(data: bytes, start: int, labels: list[str], counts: list[int]) -> Table:
    wanted = [(label.encode(), count + 1) for label, count in zip(labels, counts, strict=True)]
    columns = 1 + sum(counts)
    blocks: list[Array] = []
    rows: list[list[float]] = []
    row: list[float] = []
    position = frame_start = start
    at = -1
    for line in data[start:].split(b"\n"):
        words = line.split()
        if words and not words[0].startswith(b"#"):
            if at < 0:
                frame_start = position
                values = _numbers(words, line) if len(words) == 1 else None
            else:
                label, length = wanted[at]
                values = _numbers(words[1:], line) if words[0] == label and len(words) == length else None
            if values is None:
                return Table(_stacked(blocks, rows, columns), frame_start)
            row.extend(values)
            at += 1
            if at == len(wanted):
                rows.append(row)
                row, at = [], -1
                if len(rows) == _CHUNK:
                    blocks.append(np.array(rows))
                    rows = []
        position += len(line) + 1
    return Table(_stacked(blocks, rows, columns), frame_start if row else -1)


def _numbers(words: list[bytes], line: bytes) -> list[float] | None:
    """The words as finite numbers, or None."""
    try:
        values = list(map(float, words))
    except ValueError:
        return None
    # the sum is not finite when a term is not; a sum that overflows is looked at term by term
    if not math.isfinite(sum(values)) and not all(map(math.isfinite, values)):
        return None
    return None if b"_" in line and b"_" in b"".join(words) else values


def _stacked(blocks: list[Array], rows: list[list[float]], columns: int) -> Array:
    last = np.array(rows, dtype=np.float64).reshape(len(rows), columns)
    return np.concatenate([*blocks, last]) if blocks else last
