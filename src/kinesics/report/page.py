"""One page that says it all: a single file without scripts that loads nothing from anywhere."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape
from importlib import resources
from typing import Final

import numpy as np

from kinesics.analysis import Analysis
from kinesics.analysis.facts import Overall, Range, Source
from kinesics.grammar.graph import MotionGraph
from kinesics.grammar.information import Information
from kinesics.grammar.notation import pretty_label
from kinesics.plotting.motif_rows import ranked_stretches
from kinesics.plotting.similarity_plots import colour_key
from kinesics.report import words
from kinesics.report.markup import amount, cell, drawing, picture, table
from kinesics.report.pictures import MOST_MOTIFS, Pictures, strip_paths

_MOST_ROWS: Final = 200
_MOST_WORDS: Final = 400


def report_page(analysis: Analysis, pictures: Pictures, *, palette: str = "thesis") -> str:
    """The report as HTML: complete in itself, nothing is fetched, every text of the recording escaped."""
    names = words.source_names(analysis)
    first = analysis.sources[0].name or names[0]
    title = first if len(names) == 1 else f"{first} and {len(names) - 1} more"
    body = [
        f"<h1>{escape(title)}</h1>",
        *(_headline(analysis, k) for k in range(len(names))),
        _numbers(analysis),
        _warnings(analysis),
        *_what_it_is(analysis),
        *_phrases(analysis, pictures),
        "<h2>All pairs of moments</h2>",
        picture(
            pictures.triangle,
            "Z/Z* turned by 45 degrees: time runs to the right, the lag between two moments upwards.",
            _how_to_read(palette) + _one_after_another(analysis),
        ),
        picture(
            pictures.square,
            "Z/Z*: each pixel compares two moments.",
            "The same, each pixel one moment across and one upwards. On the margin: the states of the motion graph, when they are "
            "met (those held longest, where there is no room for all).",
        ),
        *_motion_graph(analysis, pictures),
        *_cycles(analysis),
        *_motifs(analysis, pictures),
        "<h2>Speed and symmetry</h2>",
        *(
            drawing(svg, f"curve{k}", f"Speed and symmetry over time{'' if len(names) == 1 else ': ' + names[k]}.")
            for k, svg in enumerate(pictures.curves)
        ),
        "<p>The speed is √(2D)/Δt: half the root-mean-square angular speed of the 15 joints, in radians a second. "
        "D*(a, a) is the distance of the pose from its own mirror image; at 0 left and right agree.</p>",
        _ranges(analysis, "Stillness", analysis.stillness, _stillness_words(analysis)),
        _ranges(analysis, "Symmetric states", analysis.symmetric_states, _symmetry_words(analysis)),
        "<h2>The path of the body</h2>",
        drawing(pictures.path, "path", "The motion path in the symmetry basis.", kind="narrow"),
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
        f"<title>{escape(title)} · kinesics</title>\n<style>\n{_style()}</style>\n</head>\n<body>\n"
        + "\n".join(part for part in body if part)
        + "\n</body>\n</html>\n"
    )


def _style() -> str:
    return resources.files("kinesics.report").joinpath("page.css").read_text(encoding="utf-8")


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
        ("speed, median", amount(analysis.speed.median, " /s")),
        ("speed, greatest", amount(analysis.speed.max, " /s")),
        ("at rest", f"{still:.1f} s"),
        ("symmetric", f"{symmetric:.1f} s"),
        ("β", f"{analysis.beta:.3g}"),
    ]
    cells = "".join(f"<div><dt>{escape(k)}</dt><dd>{escape(v)}</dd></div>" for k, v in facts)
    return f'<dl class="numbers">{cells}</dl>'


def _headline(analysis: Analysis, source: int) -> str:
    name = f"{words.source_names(analysis)[source]}: " if len(analysis.sources) > 1 else ""
    return f'<p class="lead">{escape(name + words.headline(analysis, source))}.</p>'


def _what_it_is(analysis: Analysis) -> list[str]:
    """The class of each recording as a whole, the evidence for it, and what surprises."""
    parts = ["<h2>What it is</h2>"]
    several = len(analysis.sources) > 1
    for source, name in zip(analysis.sources, words.source_names(analysis), strict=True):
        judged = source.overall
        if several:
            parts.append(f"<h3>{escape(name)}</h3>")
        if judged.confidence is None:
            parts.append("<p>Too short to tell.</p>")
            continue
        said = f"As one path: {words.verdict(judged)}."
        if judged.class_ is not None:
            said += f" {words.CLASSES[judged.class_][1]}"
        if judged.runner_up is not None:
            said += f" Second likeliest: {words.CLASSES[judged.runner_up][0]}."
        parts.append(f"<p>{escape(said)}</p>")
        parts.extend(f"<p>{escape(said[0].upper() + said[1:])}.</p>" for said in map(words.reason, judged.reasons))
        parts.append(_residuals(judged))
    noteworthy = "".join(f"<li>{escape(_sentence(s, analysis))}.</li>" for s in words.surprises(analysis))
    if noteworthy:
        parts.append(f"<h3>Noteworthy</h3><ul>{noteworthy}</ul>")
    return parts


def _sentence(said: str, analysis: Analysis) -> str:
    """With a capital letter, unless it begins with the name of a recording."""
    names = words.source_names(analysis) if len(analysis.sources) > 1 else ()
    return said if said.startswith(tuple(f"{name}: " for name in names)) else said[0].upper() + said[1:]


def _residuals(judged: Overall) -> str:
    """How far the movement is from each symmetry."""
    known = [(said, getattr(judged.residuals, field)) for field, said in words.RESIDUALS]
    rows = [[said, f"{value:.2f}"] for said, value in known if value is not None]
    if not rows:
        return ""
    return (
        table(["compared with itself", "what is left over"], rows)
        + '<p class="small">0: it is the same. 1: it is as different as any two moments of the movement are.</p>'
    )


def _phrases(analysis: Analysis, pictures: Pictures) -> list[str]:
    """Nothing where there are none: a recording of a few frames."""
    if not analysis.phrases:
        return []
    several = len(analysis.sources) > 1
    names = words.source_names(analysis)
    smooth = any(p.smoothness is not None for p in analysis.phrases)
    header = [
        "phrase",
        *(["source"] if several else []),
        "from (s)",
        "to (s)",
        "kind",
        "what it is",
        "cycle (s)",
        "cycles",
        "how sure",
        "speed (1/s)",
        *(["smoothness"] if smooth else []),
    ]
    rows = [
        [
            str(number),
            *([names[p.source]] if several else []),
            f"{p.start_s:.2f}",
            f"{p.end_s:.2f}",
            words.kind(p),
            (f"{p.name}: " if p.name else "") + words.short_class(p),
            amount(p.period_s),
            amount(p.repeats, places=1),
            "–" if p.class_ is None or p.confidence is None else words.likelihood(p.confidence),
            amount(p.speed_mean),
            *([amount(p.smoothness)] if smooth else []),
        ]
        for number, p in enumerate(analysis.phrases[:_MOST_ROWS], 1)
    ]
    return [
        "<h2>Phrases</h2>",
        *(
            (f'<p class="small">{escape(names[k])}</p>' if several else "")
            + drawing(svg, f"phrases{k}", "The phrases over time, coloured by kind of movement.")
            for k, svg in pictures.phrases
        ),
        "<p>A phrase is a stretch of one kind of movement: what recurs in it does not recur across its borders. Phrases of one "
        + ("kind have one number and one colour" + (", in whichever recording they are." if several else "."))
        + (" Beyond ten kinds colours come again, hatched." if _kinds(analysis) > 10 else "")
        + (" Over each bar the number of the phrase, in it that of its kind")
        + (", the frieze group of what is cyclic, and a mark where each cycle begins." if analysis.cycles else ".")
        + (
            " A star: as the first of its kind is seen in a mirror."
            if any(p.mirrored for p in analysis.phrases)
            else ""
        )
        + (" Smoothness is negative: the nearer to 0, the smoother." if smooth else "")
        + "</p>",
        table(header, rows),
        _more(len(analysis.phrases), "phrases.csv"),
    ]


def _kinds(analysis: Analysis) -> int:
    """How many kinds of phrases there are; those of rests are drawn grey, and have a number all the same."""
    return 1 + max((p.kind for p in analysis.phrases if p.kind is not None), default=-1)


def _cycles(analysis: Analysis) -> list[str]:
    """Nothing where nothing is cyclic."""
    if not analysis.cycles:
        return []
    several = len(analysis.sources) > 1
    names = words.source_names(analysis)
    whose = ["source"] if several else []
    phrases = [
        [cells[0], *([names[source]] if several else []), *cells[1:]]
        for source, cells in words.cycles_of_phrases(analysis)
    ]
    rows = []
    for cycle in analysis.cycles[:_MOST_ROWS]:
        phrase = analysis.phrases[cycle.phrase]
        fps = analysis.sources[phrase.source].fps
        rows.append(
            [
                str(cycle.phrase + 1),
                *([names[phrase.source]] if several else []),
                f"{cycle.start / fps:.2f}",
                f"{cycle.end / fps:.2f}",
                f"{cycle.period_s:.2f}",
                "–" if cycle.phase is None else f"{round(100.0 * cycle.phase, 1) + 0.0:+.1f} %",
                amount(cycle.mirror_residual),
            ]
        )
    first, *rest = words.CYCLES_HEADER
    return [
        "<h2>Cycles</h2>",
        table([first, *whose, *rest], phrases[:_MOST_ROWS]),
        '<p class="small">Means and standard deviations over the cycles of each phrase. Right after left: by how much of the '
        "cycle the right side comes later than the left one, less the half by which alternating sides are apart anyway. Left "
        "unlike right: what the mirror image leaves over at that phase; 0 is an even movement.</p>",
        "<h3>One by one</h3>",
        table([first, *whose, "from (s)", "to (s)", "lasts (s)", "right after left", "left unlike right"], rows),
        _more(len(analysis.cycles), "cycles.csv"),
    ]


def _motifs(analysis: Analysis, pictures: Pictures) -> list[str]:
    """Nothing where nothing recurs and nothing strikes."""
    parts = []
    if pictures.motifs is not None:
        stretches = ranked_stretches(analysis.motifs)
        left_out = len(stretches) - MOST_MOTIFS
        parts += [
            "<h2>What recurs</h2>",
            drawing(pictures.motifs, "motifs", "Stretches that recur: their poses, and when they come back."),
            "<p>A row for each stretch that comes back: its poses, lighter as it evolves, and when it is done; framed is the "
            "one shown. The others have the colour of Z where they are the same, of Z* where they are mirrored, and ← where they "
            "are done backwards. "
            + (
                "The recordings stand one after another, in the order given, a broken line between. "
                if len(analysis.sources) > 1
                else ""
            )
            + "Their numbers are those of stretches in motifs.csv"
            + (f", which has {left_out} more." if left_out > 0 else ".")
            + "</p>",
        ]
    found = [
        (len(analysis.reversals), "turning back on its own path", "turnings back on their own path"),
        (
            len(analysis.strikes),
            "strike (fast movement that stops at once)",
            "strikes (fast movement that stops at once)",
        ),
        (len(analysis.state_repetitions), "pose that is taken again", "poses that are taken again"),
    ]
    said = ", ".join(f"{n} {one if n == 1 else many}" for n, one, many in found if n)
    if said:
        parts.append(f"<p>{escape(said)}: all in analysis.json.</p>")
    return parts if pictures.motifs is not None or not parts else ["<h2>What recurs</h2>", *parts]


def _more(count: int, file: str) -> str:
    return f"<p>And {count - _MOST_ROWS} more, in {file}.</p>" if count > _MOST_ROWS else ""


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
        drawing(pictures.graph, "graph", "The motion graph: states and the paths between them.", kind="natural"),
        "<p>A circle is a pose that returns, is held, is turned back in or branched from; an arrow is a movement from one "
        "to another, with two heads where it is done in both directions. Symmetric poses, under a bar, stand on the middle "
        "line; a pose and its mirror image (starred) face each other across it. In figures, the left limbs are red, the right ones "
        "blue.</p>",
    ]
    parts.append(f"<p>{escape(words.counted(graph))}. {escape(_shape(graph))}</p>")
    for number, name in enumerate(words.source_names(analysis)):
        said = words.folded(graph.pretty(number).split(" ")).split(" ")
        short = " ".join(said[:_MOST_WORDS]) + (" …" if len(said) > _MOST_WORDS else "")
        whose = f"{escape(name)}: " if len(graph.sources) > 1 else ""
        parts.append(f'<p class="sentence">{whose}{escape(short)}</p>')
    parts.append(
        '<p class="small">So it reads: states, and the paths between them; ← before a path that is done backwards, … after '
        "a pose in which the body lingers, if only for a moment (for rests see <q>Stillness</q>), .. where the recording begins "
        "or ends on the way, n × (…) for what comes n times.</p>"
    )
    if pictures.strips is not None:
        parts.append(
            drawing(
                pictures.strips, "strips", "Paths as strips of poses that lighten as the path evolves.", kind="natural"
            )
        )
        drawn, left_out = strip_paths(graph)
        parts.append(
            '<p class="small">Each path as its poses, which lighten as it evolves; how long it takes, and how often it is done. '
            "A path and its mirror image share a strip."
            + (f" The {len(drawn)} most frequent are drawn; {left_out} more are in analysis.json." if left_out else "")
            + "</p>"
        )
    parts.append(_information(graph.information()))
    return parts


def _shape(graph: MotionGraph) -> str:
    """Whether one can go on for ever."""
    ends = [pretty_label(graph.state(s).label) for s in graph.dead_ends()]
    if ends and len(graph.states) > 1:
        return f"No path leads on from {', '.join(ends)}."
    if len(graph.states) > 1 and len(graph.strongly_connected()) == 1:
        return "From every state one can go on to every other."
    return ""


def _information(known: Information) -> str:
    """Shannon's measures of the graph as a source of paths."""
    measures = [
        ("a path tells", known.order0_bits, "bits"),
        ("a path tells, when the one before it is known", known.order1_bits, "bits"),
        ("that is, a second of recording", known.bits_per_s, "bits/s"),
        ("vocabulary, with paths not seen yet", known.vocabulary, "paths"),
        ("time on symmetric paths", known.symmetric_share, "%"),
        ("time on paths done both ways", known.reversible_share, "%"),
        ("time on paths done mirrored, too", known.mirrored_share, "%"),
    ]
    rows = []
    for name, estimate, unit in measures:
        if estimate is not None:
            factor, places = (100.0, 0) if unit == "%" else (1.0, 2)
            value, error = factor * estimate.value, factor * estimate.standard_error
            rows.append([name, f"{value:.{places}f} ± {error:.{places}f} {unit}"])
    if not rows:
        return ""
    said = (
        f"The graph as a source of {known.words} {'word' if known.words == 1 else 'words'}, each one path, after Shannon; "
        "with standard errors, which are wide for short recordings. A movement that does the same over and over tells nothing."
    )
    return f'<h3>How much it tells</h3>{table(["", ""], rows)}<p class="small">{escape(said)}</p>'


def _one_after_another(analysis: Analysis) -> str:
    """Which stretch of a common time axis is which recording; nothing where there is one."""
    if len(analysis.sources) == 1:
        return ""
    ends = [float(t) for t in np.cumsum([0.0, *(s.duration_s for s in analysis.sources)])]
    said = ", ".join(
        f"{name} from {start:.2f} to {end:.2f} s"
        for name, start, end in zip(words.source_names(analysis), ends, ends[1:], strict=False)
    )
    return (
        f" The recordings stand one after another, white lines between: {said}. Squares and triangles on the edge compare a "
        "recording with itself, those beyond the lines one with another."
    )


def _how_to_read(palette: str) -> str:
    key = colour_key(palette)
    figures = (
        " Beneath: each pose and, paler, the pose a sixth of a second later; the left limbs red, the right ones blue."
    )
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
        f"Rests: stretches of at least {waits} s in which all poses stay within √(2D) = {near} of each other: a few degrees in "
        "each joint, for longer than a swing of this recording lingers at its turning point."
        + (
            f" The motion graph also tells shorter stays, each marked … in its sentence: {lingers:.1f} s in all."
            if (lingers := sum(words.lingering(analysis.graph, k) for k in range(len(analysis.sources)))) > 0.0
            else ""
        )
    )


def _symmetry_words(analysis: Analysis) -> str:
    threshold = analysis.parameters["symmetric_states"]["threshold"]
    bars = (
        " The motion graph has the same threshold (more where the sensors are noisier), but judges a state by all of its visits "
        "together and sets a small constant difference of left and right aside: a single visit of a state under a bar may lie "
        "outside these stretches."
        if analysis.graph.states
        else ""
    )
    return (
        "Stretches in which the pose is its own mirror image as nearly as a body at rest: D*(a, a) ≤ "
        f"{threshold:g}, for every recording the same.{bars}"
    )


def _ranges(analysis: Analysis, title: str, ranges: Sequence[Range], said: str) -> str:
    if not ranges:
        return f"<h2>{escape(title)}</h2><p>{escape(said)}</p><p>None.</p>"
    several = len(analysis.sources) > 1
    names = words.source_names(analysis)
    header = [*(["source"] if several else []), "from (s)", "to (s)", "lasts (s)", "frames"]
    rows = []
    for r in ranges[:_MOST_ROWS]:
        fps = analysis.sources[r.source].fps
        times = [f"{r.start / fps:.2f}", f"{r.end / fps:.2f}", f"{(r.end - r.start) / fps:.2f}", f"{r.start}-{r.end}"]
        rows.append([*([names[r.source]] if several else []), *times])
    left_out = len(ranges) - len(rows)
    more = f"<p>And {left_out} more, in analysis.json.</p>" if left_out > 0 else ""
    return f"<h2>{escape(title)}</h2><p>{escape(said)}</p>{table(header, rows)}{more}"


def _source(source: Source) -> str:
    facts = [
        ("file", source.name),
        ("format", source.format),
        ("skeleton", f"{source.skeleton} ({source.joints} joints)"),
        ("frames", f"{source.frames} at {source.fps:.6g} a second, {source.duration_s:.3f} s"),
        ("SHA-256", source.sha256),
    ]
    rows = "".join(f"<tr><th>{escape(k)}</th>{cell(v)}</tr>" for k, v in facts if v)
    assumed = "".join(f"<li>{escape(a)}</li>" for a in source.assumptions)
    said = f"<p>What the file does not say and was assumed:</p><ul>{assumed}</ul>" if assumed else ""
    return f"<table>{rows}</table>{said}"


def _parameters(analysis: Analysis) -> str:
    values = {"beta": analysis.beta, **analysis.to_dict()["parameters"]}
    return json.dumps(values, ensure_ascii=False, indent=1)
