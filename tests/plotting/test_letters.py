"""Letters that the usual font lacks: another font of the machine is taken, or a question mark, and nothing is said on stderr."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen
from matplotlib.font_manager import fontManager

from kinesics.plotting import letters
from kinesics.plotting.canvas import figure_bytes, new_figure, title_lines

LINEAR_A = "\U00010600\U00010601"
"""Letters that hardly any machine has."""


@pytest.fixture
def no_other_font(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A machine with matplotlib's own fonts alone."""
    own = [f for f in fontManager.ttflist if "mpl-data" in f.fname]
    monkeypatch.setattr(fontManager, "ttflist", own)
    for found in (letters.lettering, letters._others):
        found.cache_clear()
    yield
    for found in (letters.lettering, letters._others):
        found.cache_clear()


def font_of(letter: str, path: Path) -> None:
    """A font with a square for one letter."""
    pen = TTGlyphPen(None)
    for k, corner in enumerate(((100, 0), (100, 700), (800, 700), (800, 0))):
        (pen.lineTo if k else pen.moveTo)(corner)
    pen.closePath()
    square, empty = pen.glyph(), TTGlyphPen(None).glyph()
    builder = FontBuilder(1000, isTTF=True)
    builder.setupGlyphOrder([".notdef", "letter"])
    builder.setupCharacterMap({ord(letter): "letter"})
    builder.setupGlyf({".notdef": empty, "letter": square})
    builder.setupHorizontalMetrics({".notdef": (500, 0), "letter": (900, 100)})
    builder.setupHorizontalHeader(ascent=800, descent=-200)
    builder.setupNameTable({"familyName": "Squares of a test", "styleName": "Regular"})
    builder.setupOS2(sTypoAscender=800, sTypoDescender=-200, usWinAscent=800, usWinDescent=200)
    builder.setupPost()
    builder.save(path)


@pytest.mark.usefixtures("no_other_font")
def test_what_no_font_has_is_a_question_mark() -> None:
    """Letter by letter, and told which; joiners draw nothing, and are no letters."""
    assert letters.lettering("walk é سلام λ 3.5") == ("walk é سلام λ 3.5", (), "")
    assert letters.lettering(f"a{LINEAR_A}\u200db") == ("a??\u200db", (), LINEAR_A)


@pytest.mark.usefixtures("no_other_font")
@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_pictures_are_drawn_with_it_and_left_as_they_were(suffix: str) -> None:
    """As a picture of question marks, byte by byte; the figure keeps its text."""
    drawn = []
    for text in (f"{LINEAR_A}.bvh", "??.bvh"):
        figure = new_figure(2.0, 1.0)
        said = figure.text(0.1, 0.5, text)
        assert letters.lacking(figure) == (LINEAR_A if "?" not in text else "")
        drawn.append(figure_bytes(figure, suffix))
        assert said.get_text() == text
    assert drawn[0] == drawn[1]


@pytest.mark.usefixtures("no_other_font")
def test_a_font_that_has_them_is_taken(tmp_path: Path) -> None:
    """By name, besides the usual one; what only that has is in it."""
    font_of(LINEAR_A[0], tmp_path / "squares.ttf")
    fontManager.addfont(str(tmp_path / "squares.ttf"))
    assert letters.lettering(f"a{LINEAR_A}") == (f"a{LINEAR_A[0]}?", ("Squares of a test",), LINEAR_A[1])
    pictures = []
    for text in (LINEAR_A[0], "?"):
        figure = new_figure(2.0, 1.0)
        said = figure.text(0.1, 0.5, text)
        before = said.get_fontfamily()
        pictures.append(figure_bytes(figure, ".png"))
        assert said.get_fontfamily() == before
    assert pictures[0] != pictures[1]


@pytest.mark.usefixtures("no_other_font")
def test_titles_keep_the_letters_they_were_given() -> None:
    """However they are broken: as wide as with what is drawn instead."""
    name = f"{LINEAR_A[0]} " * 40
    lines = title_lines(name, 3.0, 11.0, most=9)
    assert len(lines) > 1
    assert "".join(lines).replace(" ", "") == LINEAR_A[0] * 40
    assert [line.replace(LINEAR_A[0], "?") for line in lines] == title_lines("? " * 40, 3.0, 11.0, most=9)
