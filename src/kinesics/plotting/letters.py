"""Letters that matplotlib's own font lacks, as names of files may have: drawn with fonts of this machine, else as "?".

Nothing is looked for where the font has all letters, so pictures of such names are the same bytes on every machine.
"""

from __future__ import annotations

import contextlib
import unicodedata
from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Text

UNKNOWN: Final = "?"
"""In place of a letter that no font has."""
_INVISIBLE: Final = ("Cc", "Cf", "Zl", "Zp")
"""Kinds of characters that draw nothing themselves: joiners, marks of direction."""
_LAST_RESORT: Final = "Last Resort"
"""A font of matplotlib that has a box for everything."""
_REGULAR: Final = 400
"""Weight of letters neither thin nor bold."""


class Lettering(NamedTuple):
    """How a text is drawn."""

    text: str
    """With `UNKNOWN` for what no font has."""
    families: tuple[str, ...]
    """Of fonts, besides the usual ones, that have the rest."""
    lacking: str
    """The letters that no font has, each once."""


@cache
def lettering(text: str) -> Lettering:
    """How a text is drawn on this machine."""
    from matplotlib.font_manager import findfont

    own = _letters_of(findfont("DejaVu Sans"))
    missing = {c for c in text if ord(c) not in own and unicodedata.category(c) not in _INVISIBLE}
    families: list[str] = []
    while missing:
        family, had = max(_others(), key=lambda font: len(missing & font[1]), default=("", frozenset()))
        if not missing & had:
            break
        families.append(family)
        missing -= had
    shown = "".join(UNKNOWN if c in missing else c for c in text)
    return Lettering(shown, tuple(families), "".join(sorted(missing)))


def lacking(figure: Figure) -> str:
    """The letters in a figure that no font of this machine has, each once."""
    return "".join(sorted({c for text in _texts(figure) for c in lettering(text.get_text()).lacking}))


@contextlib.contextmanager
def drawable(figure: Figure) -> Iterator[None]:
    """The figure with all its texts in letters that there are, for as long as the context lasts."""
    before = []
    for text in _texts(figure):
        how = lettering(text.get_text())
        if how.families or how.lacking:
            before.append((text, text.get_text(), text.get_fontfamily()))
            text.set_text(how.text)
            text.set_fontfamily([*text.get_fontfamily(), *how.families])
    try:
        yield
    finally:
        for text, said, families in before:
            text.set_text(said)
            text.set_fontfamily(families)


def _texts(figure: Figure) -> list[Text]:
    from matplotlib.text import Text

    return [artist for artist in figure.findobj(Text) if isinstance(artist, Text)]


@cache
def _letters_of(file: str) -> frozenset[int]:
    """The characters that a font has; none if it cannot be drawn with."""
    from matplotlib.ft2font import FT2Font

    try:
        font = FT2Font(file)
        # pictures of letters, as those of emoji, cannot be scaled
        return frozenset(font.get_charmap()) if font.scalable else frozenset()
    except (OSError, RuntimeError, ValueError):
        return frozenset()


@cache
def _others() -> list[tuple[str, frozenset[str]]]:
    """Upright fonts of this machine by name, plain ones first, and the characters that each has."""
    from matplotlib.font_manager import fontManager

    fonts = [f for f in fontManager.ttflist if f.style == "normal" and not f.name.startswith(_LAST_RESORT)]
    fonts.sort(key=lambda f: (f.weight != _REGULAR, f.name, f.fname))
    out: dict[str, frozenset[str]] = {}
    for font in fonts:
        if font.name not in out:
            out[font.name] = frozenset(map(chr, _letters_of(font.fname)))
    return list(out.items())
