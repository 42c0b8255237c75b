"""``kinesics analyze FILE…``: the main job."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinesics.cli import recording, terminal
from kinesics.cli.recording import Reading

if TYPE_CHECKING:
    from kinesics.analysis import Analysis

SUMMARY = "Compare all moments of recordings; leave a report."
EXAMPLES = (
    ("kinesics analyze walk.bvh", "leaves walk.bvh-kinesics/report.html"),
    ("kinesics analyze 07_01.amc --out report", "07.asf lies beside it"),
    ("kinesics analyze left.bvh right.bvh", "together: one report"),
    ("kinesics analyze walk.bvh --json", "the result alone, for programs"),
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
            "--out", metavar="DIR", show_default=False, help="Where the report goes; FILE-kinesics unless given."
        ),
    ] = None,
    beta: Annotated[
        float | None,
        typer.Option("--beta", metavar="B", show_default=False, help="Contrast of Z = exp(-B·D); found unless given."),
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
    """
    from kinesics import analysis, report

    reading = Reading(skeleton, map_, unit, up, fps)
    folder = out or (None if json else Path(f"{files[0].name}-kinesics"))
    with terminal.Bar("Analysing") as bar:
        motions = []
        for number, file in enumerate(files):
            bar(0.2 * number / len(files), f"reading {file.name}")
            motions.append(reading.read(file))
        result = analysis.analyze(motions, beta=beta, mapping=reading.mapping(), progress=bar.part(0.2, 0.4))
        if folder is not None:
            report.save(result, folder, overwrite=overwrite, progress=bar.part(0.4, 1.0))
    if json:
        terminal.print_json(result.to_dict())
    else:
        summarize(result)
    if folder is not None:
        said = f"Report: {folder / 'report.html'}"
        (terminal.remark if json else print)(said)


def summarize(result: Analysis) -> None:
    """A few lines for people: what went in, what was found, what was assumed."""
    console = terminal.console()
    for number, source in enumerate(result.sources):
        console.print(
            f"[bold]{terminal.escape(source.name or 'a synthetic performance')}[/bold]: "
            f"{source.frames} frames at {source.fps:g} fps, {source.duration_s:.1f} s"
        )
        still = sum(r.end - r.start for r in result.stillness if r.source == number) / source.frames
        symmetric = sum(r.end - r.start for r in result.symmetric_states if r.source == number) / source.frames
        console.print(f"  still {still:.0%} of the time, left and right alike {symmetric:.0%} of the time")
        if source.assumptions:
            console.print(
                f"  [dim]{len(source.assumptions)} things were assumed: see the report, or kinesics info[/dim]"
            )
        for line in source.warnings:
            console.print(f"  [yellow]looks wrong:[/yellow] {terminal.escape(line)}")
    if result.speed.max is not None and result.speed.max_s is not None:
        console.print(f"  fastest at {result.speed.max_s:.2f} s; contrast β = {result.beta:.3g}")
