"""Numbers out of text: the compiled parser, Python's, and what `float` says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from kinesics.errors import FileError
from kinesics.formats import text

native = pytest.importorskip("kinesics._native", reason="Built without the compiled kernels.")

numbers = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.from_regex(r"[-+]?[0-9]{1,25}(\.[0-9]{0,25})?([eE][-+]?[0-9]{1,3})?", fullmatch=True),
    st.from_regex(r"[-+]?\.[0-9]{1,12}([eE][-+]?[0-9]{1,4})?", fullmatch=True),
)
pieces = st.sampled_from(
    [" ", "\t", "\n", "\r\n", "1", "-2.5", "1e3", "x", "nan", "inf", "#", "//", "1_0", "root", "b", "\0", "-"]
)


@given(numbers)
@example("9007199254740993")
@example("1e400")
@example("-1e-400")
@example("2.2250738585072011e-308")
@example("-2.07272e-014")
def test_a_number_is_what_float_makes_of_it_to_the_last_bit(word: str) -> None:
    """Every finite decimal number comes out as Python's own conversion gives it; others stop the parser."""
    values, stop = native.parse_rows(word.encode(), 0, 1)
    expected = float(word)
    if math.isfinite(expected):
        assert stop == -1
        assert values[0, 0] == expected
        assert math.copysign(1.0, values[0, 0]) == math.copysign(1.0, expected)
    else:
        assert stop == 0


@given(st.lists(pieces, max_size=30).map("".join), st.integers(1, 3))
def test_rows_are_the_same_without_the_compiled_parser(content: str, columns: int) -> None:
    """Values and the place where the parser stops do not depend on whether the extension was built."""
    data = content.encode()
    fast, slow = text.Table(*native.parse_rows(data, 0, columns)), text._parse_rows_python(data, 0, columns)
    assert fast.stop == slow.stop
    np.testing.assert_array_equal(fast.values, slow.values)


@given(st.lists(st.one_of(pieces, st.just("1\nroot 1 2\nb 3\n")), max_size=12).map("".join))
@example("1\nroot 1 2\nb 3 4\n")
@example(" 1")
@example("# a\n 1\n")
@example("1 root 1 2\nb 3\n")
@example("1\nroot 1 2 b 3\n")
def test_labelled_frames_are_the_same_without_the_compiled_parser(content: str) -> None:
    """Values and the place where the parser stops do not depend on whether the extension was built."""
    data = content.encode()
    fast = text.Table(*native.parse_labelled(data, 0, ["root", "b"], [2, 1]))
    slow = text._parse_labelled_python(data, 0, ["root", "b"], [2, 1])
    assert fast.stop == slow.stop
    np.testing.assert_array_equal(fast.values, slow.values)


def test_more_rows_than_one_block_are_joined() -> None:
    """Python's parser works in blocks; a row lost or doubled at a border would show."""
    data = b"".join(b"%d %d\n" % (k, 2 * k) for k in range(2500))
    for table in (text.parse_rows(data, 0, 2), text._parse_rows_python(data, 0, 2)):
        np.testing.assert_array_equal(table.values[:, 0], np.arange(2500))
    frames = b"".join(b"%d\nroot %d\n" % (k, 2 * k) for k in range(2500))
    for table in (text.parse_labelled(frames, 0, ["root"], [1]), text._parse_labelled_python(frames, 0, ["root"], [1])):
        np.testing.assert_array_equal(table.values[:, 1], 2 * np.arange(2500))


def test_text_files_lose_their_mark_and_old_line_ends(tmp_path) -> None:
    """Byte order marks and the single carriage returns of old systems are taken off before anything is parsed."""
    for raw in ("\ufeffa\nb".encode(), "a\nb".encode("utf-16"), b"a\rb"):
        assert text.TextFile.of(tmp_path / "x", raw).data == b"a\nb"
    with pytest.raises(FileError, match="zero bytes"):
        text.TextFile.of(tmp_path / "x", b"a\0b")
