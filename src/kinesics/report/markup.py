"""The pieces of HTML that the page is put together from: every text of a recording is escaped here."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import Final

_WIDEST: Final = 800.0
"""Points: a drawing up to so wide can be read at the width of the page; a wider one can be enlarged."""


def picture(png: bytes, words: str, caption: str = "") -> str:
    """A PNG file as part of the page, with words in its place for whoever cannot see it."""
    data = base64.b64encode(png).decode("ascii")
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return f'<figure><img alt="{escape(words)}" src="data:image/png;base64,{data}">{below}</figure>'


def drawing(svg: bytes, prefix: str, words: str, *, kind: str = "wide") -> str:
    """An SVG file as part of the page: its ids are made its own, for ids are shared by a whole page.

    Parameters
    ----------
    kind : "wide" as the page, "narrow", or "natural" as it was drawn where the page is wide enough.
    """
    text = svg.decode()
    text = text[text.index("<svg") :]
    for named in (' id="', 'href="#', "url(#"):
        text = text.replace(named, f"{named}{prefix}-")
    # width and height in points would hold the drawing at one size; the viewBox is there
    head, tail = text.split(">", 1)
    natural = re.search(r'\swidth="([0-9.]+pt)"', head)
    style = f' style="max-width: {natural.group(1)}"' if kind == "natural" and natural else ""
    head = re.sub(r'\s(width|height)="[^"]*"', "", head)
    named = f'role="img" aria-label="{escape(words)}"'
    if kind == "natural" and natural and float(natural.group(1)[:-2]) > _WIDEST:
        # the whole is seen at a glance; what is too small then is made larger on demand, and moved sideways in its own box
        return (
            f'<figure class="{kind}" style="--full: {natural.group(1)}">'
            f'<input class="zoom" type="checkbox" id="{prefix}-zoom"/>'
            f'<label class="zoom" for="{prefix}-zoom">full size</label>'
            f'<div class="scaled" {named}>{head}>{tail}</div></figure>'
        )
    return f'<figure class="{kind}"{style} {named}>{head}>{tail}</figure>'


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in a box of its own."""
    top = "".join(f"<th>{escape(h)}</th>" for h in header)
    body = "".join("<tr>" + "".join(map(cell, row)) + "</tr>" for row in rows)
    # on a narrow screen a table of many columns is moved sideways, in its own box
    many = ' class="many"' if len(header) > 7 else ""
    return f'<div class="wide"><table{many}><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def cell(text: str) -> str:
    """A cell of a table."""
    # a number that is broken in two reads as another one; a word as long as a file's name may be broken
    long = max(map(len, text.split()), default=0) > 24
    kind = ' class="long"' if long else ""
    text = text.replace(" %", "\N{NO-BREAK SPACE}%")
    return f"<td{kind}>{escape(text)}</td>"


def amount(value: float | None, unit: str = "", *, places: int = 2) -> str:
    """A figure with its unit; a dash where there is none."""
    return "–" if value is None else f"{value:.{places}f}{unit}"
