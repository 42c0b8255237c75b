"""The names of states and paths as they stand in a picture: in the dissertation's notation, no longer than they need be."""

from __future__ import annotations

import functools
import re
from collections import Counter
from collections.abc import Sequence
from typing import Final

import numpy as np

from kinesics.grammar import notation

_LETTERS: Final = re.compile(r"(?P<first>[A-Za-z][0-9]*\*?)(?P<second>[a-z][0-9]*\*?)?(?:_(?P<index>[0-9]+))?")
_BARRED: Final = re.compile(rf"(?P<letter>[A-Z])(?P<number>[0-9]*){notation.BAR}")
_SUBSCRIPTS: Final = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def label_text(label: str, *, index: bool = True) -> str:
    """A label as it is drawn, in italics: plain text, or mathtext where a bar goes over more than a letter.

    Mathtext looks the same and takes ten times as long.

    Parameters
    ----------
    index : False leaves the index out, as the dissertation does where there is only one such path.
    """
    if barred := _BARRED.fullmatch(label):
        return barred["letter"] + "\N{COMBINING OVERLINE}" + barred["number"].translate(_SUBSCRIPTS)
    image = label.startswith("(")
    letters = _LETTERS.fullmatch(label[1:-2] if image else label)
    if letters is None:
        return notation.mathtext(label, index=index)
    core = letters["first"] + (letters["second"] or "") + ((letters["index"] or "") if index else "")
    return f"({core}){notation.MIRROR}".translate(_SUBSCRIPTS) if image else core.translate(_SUBSCRIPTS)


def plain_labels(labels: Sequence[str]) -> set[str]:
    """Labels whose index says nothing, because no other path is named so, nor of their mirror images."""

    def base(label: str) -> str:
        return label.removeprefix("(").removesuffix(")*").rpartition("_")[0]

    often = Counter((base(label), label.startswith("(")) for label in labels)
    return {label for label in labels if max(often[base(label), image] for image in (False, True)) == 1}


def half_size(text: str, size: float) -> tuple[float, float]:
    """Half of the width and of the height of a text as long as ``size`` is high, with a little room."""
    width, height = _extent(text)
    return (0.5 * width + 0.08) * size, (0.5 * height + 0.08) * size


@functools.lru_cache(maxsize=4096)
def _extent(text: str) -> tuple[float, float]:
    """Width and height of a text of size 1."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.path import Path
    from matplotlib.textpath import TextPath

    outline = TextPath((0.0, 0.0), text, size=20.0, prop=FontProperties(style="italic"))
    assert outline.codes is not None
    # letters have points at their extremes: curves need not be followed
    points = np.asarray(outline.vertices)[outline.codes != Path.CLOSEPOLY]
    wide, high = np.ptp(points, axis=0) / 20.0 if len(points) else (0.0, 0.0)
    return float(wide), float(high)
