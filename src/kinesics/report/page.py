"""One page that says it all: a single file without scripts that loads nothing from anywhere."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import Final

from kinesics.analysis import Analysis
from kinesics.analysis.facts import Range, Source
from kinesics.plotting.similarity_plots import colour_key
from kinesics.report.pictures import Pictures

_MOST_ROWS: Final = 200
_MOST_WORDS: Final = 400

_STYLE: Final = """
:root { color-scheme: light; }
body { margin: 0 auto; max-width: 62rem; padding: 2rem 1.5rem 4rem; color: #1a1a1a; background: #fff;
  font: 1rem/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0 0 .3rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2.6rem 0 .6rem; padding-top: .7rem; border-top: 1px solid #ddd; }
p.lead { color: #555; margin: 0 0 1.4rem; }
dl.numbers { display: flex; flex-wrap: wrap; gap: .6rem 1.6rem; margin: 0 0 1rem; }
dl.numbers div { min-width: 5.2rem; }
dl.numbers dt { color: #666; font-size: .8rem; }
dl.numbers dd { margin: 0; font-size: 1.25rem; font-variant-numeric: tabular-nums; }
figure { margin: 1rem 0 1.6rem; }
figure img, figure svg { display: block; width: 100%; height: auto; }
figure.narrow { max-width: 36rem; }
figcaption { color: #555; font-size: .9rem; margin-top: .5rem; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .25rem 1.2rem .25rem 0; border-bottom: 1px solid #eee; vertical-align: top;
  overflow-wrap: anywhere; }
th { color: #555; font-weight: 600; }
td.number, th.number { text-align: right; }
ul { padding-left: 1.2rem; }
li.warning { color: #8a3b00; }
p.sentence { overflow-wrap: anywhere; line-height: 1.9; }
pre { font-size: .8rem; overflow-x: auto; background: #f6f6f4; padding: .8rem; }
footer { margin-top: 3rem; color: #777; font-size: .85rem; }
@media print { body { padding: 0; } figure { break-inside: avoid; } }
"""


def report_page(analysis: Analysis, pictures: Pictures, *, palette: str = "thesis") -> str:
    """The report as HTML: complete in itself, nothing is fetched, every text of the recording escaped."""
    names = [s.name or "a motion made by the program" for s in analysis.sources]
    title = names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"
    body = [
        f"<h1>{escape(title)}</h1>",
        '<p class="lead">What kinesics found in this recording.</p>',
        _numbers(analysis),
        _warnings(analysis),
        "<h2>All pairs of moments</h2>",
        _picture(
            pictures.triangle,
            "Z/Z* turned by 45 degrees: time runs to the right, the lag between two moments upwards.",
            _how_to_read(analysis, palette),
        ),
        _picture(pictures.square, "Z/Z*: each pixel compares two moments of the recording."),
        *_motion_graph(analysis, pictures),
        "<h2>Speed and symmetry</h2>",
        *(
            _drawing(svg, f"curve{k}", f"Speed and symmetry over time{'' if len(names) == 1 else ': ' + names[k]}.")
            for k, svg in enumerate(pictures.curves)
        ),
        "<p>The speed is √(2D)/Δt: half the root-mean-square angular speed of the 15 joints, in radians a second. "
        "D*(a, a) is the distance of the pose from its own mirror image; at 0 left and right agree.</p>",
        _ranges(analysis, "Stillness", analysis.stillness, _stillness_words(analysis)),
        _ranges(analysis, "Symmetric states", analysis.symmetric_states, _symmetry_words(analysis)),
        "<h2>The path of the body</h2>",
        _drawing(pictures.path, "path", "The motion path in the symmetry basis.", kind="narrow"),
        "<p>Every pose is a symmetric part (upwards) and an antisymmetric part (across). The path runs from dark (round "
        "mark) to light (square mark); in grey its mirror image. A symmetric pose lies on the middle line.</p>",
        "<h2>The recording</h2>",
        *(_source(s) for s in analysis.sources),
        "<h2>How it was measured</h2>",
        f"<details><summary>Parameters</summary><pre>{escape(_parameters(analysis))}</pre></details>",
        f"<footer>Made by kinesics {escape(analysis.kinesics_version)}. The measures follow A. Schultz, "
        "<cite>Performance Physics</cite> (2012), §2.13-2.14 and §3.1-3.4.</footer>",
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; img-src data:; '
        "style-src 'unsafe-inline'\">\n"
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)} · kinesics</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(part for part in body if part)
        + "\n</body>\n</html>\n"
    )


def _numbers(analysis: Analysis) -> str:
    """The first look: a handful of figures."""
    seconds = sum(s.duration_s for s in analysis.sources)
    frames = sum(s.frames for s in analysis.sources)
    still = sum((r.end - r.start) / analysis.sources[r.source].fps for r in analysis.stillness)
    symmetric = sum((r.end - r.start) / analysis.sources[r.source].fps for r in analysis.symmetric_states)
    rates = sorted({s.fps for s in analysis.sources})
    facts = [
        ("duration", f"{seconds:.2f} s"),
        ("frames", f"{frames:,}"),
        ("frame rate", f"{', '.join(f'{r:.6g}' for r in rates)} /s"),
        ("speed, median", _number(analysis.speed.median, " /s")),
        ("speed, greatest", _number(analysis.speed.max, " /s")),
        ("still", f"{still:.1f} s"),
        ("symmetric", f"{symmetric:.1f} s"),
        ("β", f"{analysis.beta:.3g}"),
    ]
    cells = "".join(f"<div><dt>{escape(k)}</dt><dd>{escape(v)}</dd></div>" for k, v in facts)
    return f'<dl class="numbers">{cells}</dl>'


def _warnings(analysis: Analysis) -> str:
    items = "".join(f'<li class="warning">{escape(w)}</li>' for w in analysis.warnings)
    return f"<h2>Doubtful</h2><ul>{items}</ul>" if items else ""


def _motion_graph(analysis: Analysis, pictures: Pictures) -> list[str]:
    """Nothing where no graph was read."""
    graph = analysis.graph
    if not graph.states:
        return []
    parts = [
        "<h2>The motion graph</h2>",
        _drawing(pictures.graph, "graph", "The motion graph: states and the paths between them."),
        "<p>A circle is a pose that returns, is held, is turned back in or branched from; an arrow is a movement from one "
        "to another, with two heads where it is done in both directions. Symmetric poses, under a bar, stand on the middle "
        "line; a pose and its mirror image (starred) face each other across it.</p>",
    ]
    for number, source in enumerate(graph.sources):
        words = graph.pretty(number).split(" ")
        said = " ".join(words[:_MOST_WORDS]) + (" …" if len(words) > _MOST_WORDS else "")
        name = f"{escape(source.name)}: " if len(graph.sources) > 1 else ""
        parts.append(f'<p class="sentence">{name}{escape(said)}</p>')
    if pictures.strips is not None:
        parts.append(_drawing(pictures.strips, "strips", "Paths as strips of poses that lighten as the path evolves."))
    return parts


def _how_to_read(analysis: Analysis, palette: str) -> str:
    key = colour_key(palette)
    figures = "" if len(analysis.sources) > 1 else " Beneath: each pose and, paler, the pose a sixth of a second later."
    return (
        f"{key[0].upper()}{key[1:]}. On the lower edge every moment meets itself: where that line is thin the body moves fast, "
        "where it is white the pose is symmetric. Stripes along it are repetitions, stripes straight up from it are movements "
        f"taken back; in the colour of Z* they are so mirrored.{figures}"
    )


def _stillness_words(analysis: Analysis) -> str:
    rules = analysis.parameters["stillness"]["sources"]
    near = " or ".join(sorted({f"{r['epsilon']:.3f}" for r in rules}))
    waits = " or ".join(sorted({f"{r['minimum_s']:.2f}" for r in rules}))
    return (
        f"Stretches of at least {waits} s in which all poses stay within √(2D) = {near} of each other: a few degrees in each "
        "joint, for longer than a swing of this recording lingers at its turning point."
    )


def _symmetry_words(analysis: Analysis) -> str:
    threshold = analysis.parameters["symmetric_states"]["threshold"]
    return f"Stretches in which the pose is its own mirror image as nearly as a body at rest: D*(a, a) ≤ {threshold:g}."


def _ranges(analysis: Analysis, title: str, ranges: Sequence[Range], words: str) -> str:
    if not ranges:
        return f"<h2>{escape(title)}</h2><p>{escape(words)}</p><p>None.</p>"
    several = len(analysis.sources) > 1
    header = [*(["source"] if several else []), "from (s)", "to (s)", "lasts (s)", "frames"]
    rows = []
    for r in ranges[:_MOST_ROWS]:
        fps = analysis.sources[r.source].fps
        times = [f"{r.start / fps:.2f}", f"{r.end / fps:.2f}", f"{(r.end - r.start) / fps:.2f}", f"{r.start}-{r.end}"]
        rows.append([*([analysis.sources[r.source].name] if several else []), *times])
    left_out = len(ranges) - len(rows)
    more = f"<p>And {left_out} more, in analysis.json.</p>" if left_out > 0 else ""
    return f"<h2>{escape(title)}</h2><p>{escape(words)}</p>{_table(header, rows)}{more}"


def _source(source: Source) -> str:
    facts = [
        ("file", source.name),
        ("format", source.format),
        ("skeleton", f"{source.skeleton} ({source.joints} joints)"),
        ("frames", f"{source.frames} at {source.fps:.6g} a second, {source.duration_s:.3f} s"),
        ("SHA-256", source.sha256),
    ]
    rows = "".join(f"<tr><th>{escape(k)}</th><td>{escape(v)}</td></tr>" for k, v in facts if v)
    assumed = "".join(f"<li>{escape(a)}</li>" for a in source.assumptions)
    said = f"<p>What the file does not say and was assumed:</p><ul>{assumed}</ul>" if assumed else ""
    return f"<table>{rows}</table>{said}"


def _parameters(analysis: Analysis) -> str:
    values = {"beta": analysis.beta, **analysis.to_dict()["parameters"]}
    return json.dumps(values, ensure_ascii=False, indent=1)


def _picture(png: bytes, words: str, caption: str = "") -> str:
    data = base64.b64encode(png).decode("ascii")
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return f'<figure><img alt="{escape(words)}" src="data:image/png;base64,{data}">{below}</figure>'


def _drawing(svg: bytes, prefix: str, words: str, *, kind: str = "wide") -> str:
    """An SVG file as part of the page: its ids are made its own, for ids are shared by a whole page."""
    text = svg.decode()
    text = text[text.index("<svg") :]
    text = re.sub(r'\bid="', f'id="{prefix}-', text)
    text = re.sub(r'(href="#|url\(#)', rf"\g<1>{prefix}-", text)
    # width and height in points would hold the drawing at one size; the viewBox is there
    head, tail = text.split(">", 1)
    head = re.sub(r'\s(width|height)="[^"]*"', "", head)
    return f'<figure class="{kind}" role="img" aria-label="{escape(words)}">{head}>{tail}</figure>'


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    top = "".join(f"<th>{escape(h)}</th>" for h in header)
    body = "".join("<tr>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def _number(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.2f}{unit}"
