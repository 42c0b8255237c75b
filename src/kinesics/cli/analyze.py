"""``kinesics analyze FILE…``: the main job."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinesics.cli import recording, terminal
from kinesics.cli.recording import Reading

if TYPE_CHECKING:
    from rich.console import Console

    from kinesics.analysis import Analysis

_MOST_PHRASES = 40
_LONGEST_SENTENCE = 1200
_ROUNDING = 1e-5
"""1/s."""

SUMMARY = "Compare all moments of recordings; leave a report."
EXAMPLES = (
    ("kinesics analyze walk.bvh", "leaves walk.bvh-kinesics/report.html"),
    ("kinesics analyze 07_01.amc --out report", "07.asf lies beside it"),
    ("kinesics analyze left.bvh right.bvh", "together: left.bvh-and-1-more-kinesics"),
    ("kinesics analyze walk.bvh --json", "the result alone, for programs"),
    ("kinesics analyze a.bvh --edits a.toml", "with your names and merges"),
)


def analyze(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE", show_default=False, help="Recordings; several are compared with one another, too."
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="DIR",
            show_default=False,
            help="Where the report goes; unless given FILE-kinesics, or FILE-and-2-more-kinesics of three.",
        ),
    ] = None,
    beta: Annotated[
        float | None,
        typer.Option("--beta", metavar="B", show_default=False, help="Contrast of Z = exp(-B·D); found unless given."),
    ] = None,
    palette: Annotated[
        str,
        typer.Option(
            "--palette",
            metavar="NAME",
            help="Colours of Z and Z*: thesis (red and cyan) or colorblind (orange and blue).",
        ),
    ] = "thesis",
    edits: Annotated[
        Path | None,
        typer.Option(
            "--edits",
            metavar="TOML",
            show_default=False,
            help="Names, merges and splits of states, paths and phrases; FILE.edits.toml where that is there.",
        ),
    ] = None,
    overwrite: recording.Overwrite = False,
    json: recording.Json = False,
    skeleton: recording.Skeleton = None,
    map_: recording.Map = None,
    unit: recording.Unit = None,
    up: recording.Up = None,
    fps: recording.Fps = None,
) -> None:
    """Compare all moments of a recording with all others and their mirror images; leave a report.

    The report is a folder: report.html to look at, analysis.json for programs, pictures and tables.
    With --json and without --out nothing is written.

    What you know better (names of states, paths and phrases, what is one and what is two) stands in a side file,
    FILE.edits.toml, and is done again at every analysis. Labels are written as in graph.notation of analysis.json:
    X~ for X with a bar, ab_1 for the path. Such a file may say:

    states.rename = { A = "guard", "X~" = "attention" }
    states.merge = [ { keep = "B", with = ["C"] } ]
    paths.rename = { "ab_1" = "lunge" }
    phrases.rename = [ { frame = 100, name = "warm-up" } ]
    """
    from kinesics import analysis, report

    reading = Reading(skeleton, map_, unit, up, fps)
    known_better = recording.read_edits(edits or recording.edits_beside(files[0]))
    report.check_palette(palette)
    folder = out or (None if json else _default_folder(files))
    # it gets ready while the recordings are read
    drawing = report.helping() if folder is not None else contextlib.nullcontext()
    with drawing as helper, terminal.Bar("Analysing") as bar:
        motions = []
        for number, file in enumerate(files):
            bar(0.2 * number / len(files), f"reading {file.name}")
            motions.append(reading.read(file))
        result = analysis.analyze(
            motions, beta=beta, mapping=reading.mapping(), edits=known_better, progress=bar.part(0.2, 0.4)
        )
        if folder is not None:
            report.save(
                result, folder, overwrite=overwrite, palette=palette, progress=bar.part(0.4, 1.0), helper=helper
            )
    if json:
        terminal.print_json(result.to_dict())
    else:
        summarize(result)
    if folder is not None:
        said = f"Report: {folder / 'report.html'}"
        (terminal.remark if json else print)(said)


def _default_folder(files: Sequence[Path]) -> Path:
    """In the current folder, named after the first recording and how many more there are."""
    more = f"-and-{len(files) - 1}-more" if len(files) > 1 else ""
    return Path(f"{files[0].name}{more}-kinesics")


def summarize(result: Analysis) -> None:
    """What a choreographer wants to know: what it is, its phrases, its graph, what surprises; and what was assumed."""
    from kinesics.report import words

    console = terminal.console()
    names = words.source_names(result)
    for number in range(len(result.sources)):
        _say_recording(console, result, number)
    if len(names) > 1:
        for line in _whose_cycles(result, names):
            console.print(f"  {terminal.escape(line)}")
    _say_graph(console, result, names)
    for surprise in words.surprises(result):
        console.print(f"  [cyan]noteworthy:[/cyan] {terminal.escape(surprise)}")
    for line in result.warnings:
        console.print(f"  [yellow]doubtful:[/yellow] {terminal.escape(line)}")
    if result.speed.max is not None and result.speed.max_s is not None:
        # below that nothing is movement: rounding of the file
        fastest = f"fastest at {result.speed.max_s:.2f} s" if result.speed.max > _ROUNDING else "nothing moves"
        if len(names) > 1 and result.speed.max_source is not None:
            fastest += f" of {terminal.escape(names[result.speed.max_source])}"
        console.print(f"  {fastest}; contrast β = {result.beta:.3g}")


def _say_recording(console: Console, result: Analysis, number: int) -> None:
    """One recording: what it is, its phrases, where it rests."""
    from kinesics.report import words

    source = result.sources[number]
    name = words.source_names(result)[number] if source.name else "a synthetic performance"
    console.print(
        f"[bold]{terminal.escape(name)}[/bold]: "
        f"{source.duration_s:.1f} s, {terminal.counted(source.frames, 'frame')} at {source.fps:g} fps"
    )
    console.print(f"  {terminal.escape(words.headline(result, number))}")
    phrases = [k for k, p in enumerate(result.phrases) if p.source == number]
    if len(phrases) > 1:
        for k in phrases[:_MOST_PHRASES]:
            console.print(f"    {terminal.escape(words.phrase_line(result, k))}")
        if len(phrases) > _MOST_PHRASES:
            console.print(f"    … and {len(phrases) - _MOST_PHRASES} more, in phrases.csv")
    console.print(f"  {words.stillness(result, number)}")
    if source.assumptions:
        console.print(
            f"  [dim]{terminal.counted(len(source.assumptions), 'assumption')}: see the report, or kinesics info[/dim]"
        )


def _say_graph(console: Console, result: Analysis, names: Sequence[str]) -> None:
    """The motion graph and each recording as a sentence of it, shortened; nothing where no graph was read."""
    from kinesics.report import words

    graph = result.graph
    if not graph.states:
        return
    console.print(f"  motion graph: {words.counted(graph)}")
    for number in range(len(graph.sources)):
        said = words.folded(graph.pretty(number).split(" "))
        short = said if len(said) <= _LONGEST_SENTENCE else said[: said.rfind(" ", 0, _LONGEST_SENTENCE)] + " …"
        whose = f"{names[number]}: " if len(names) > 1 else ""
        console.print(f"    {terminal.escape(whose + short)}")


def _whose_cycles(result: Analysis, names: Sequence[str]) -> list[str]:
    """A table of the cycles of each phrase of each recording; nothing where nothing is cyclic."""
    from kinesics.report import words

    found = words.cycles_of_phrases(result)
    if not found:
        return []
    shown = [("cycles of", *words.CYCLES_HEADER), *((names[source], *cells) for source, cells in found[:_MOST_PHRASES])]
    widths = [max(map(len, column)) for column in zip(*shown, strict=True)]
    # names to the left, numbers to the right
    lines = [
        "  ".join([row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))])
        for row in shown
    ]
    more = len(found) - _MOST_PHRASES
    return lines + ([f"… and of {terminal.counted(more, 'phrase')} more, in cycles.csv"] if more > 0 else [])
