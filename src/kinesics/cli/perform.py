"""``kinesics perform FILE… --out OUT``: new movement from recordings."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinesics.cli import recording, terminal
from kinesics.cli.recording import Reading
from kinesics.errors import FileError, InputError

if TYPE_CHECKING:
    from kinesics.report.performances import Saved
    from kinesics.synthesis.piece import Piece

SUMMARY = "Make new movement from recordings."
EXAMPLES = (
    ("kinesics perform walk.bvh --out new.bvh --target 2,4", "walks there"),
    ("kinesics perform a.amc b.amc --out new.glb --route eight.csv", "along a line"),
    ("kinesics perform dance.bvh --out new.bvh --out new.glb --seconds 60", "twice"),
    ("kinesics perform a.bvh --out new.bvh --from A --to 'B*'", "state to state"),
)
_PANEL = "What is performed"
_LONGEST_ROUTE = 100_000
MUCH = 0.25
"""Share of the recordings left out from which it is said which part it is and what would join it."""
TRIED = 240.0
"""Seconds of recordings and their images, up to which a larger threshold is tried rather than advised."""
_LEFT_OUT_AT_MOST = 4


def perform(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE", show_default=False, help="Recordings to perform from; one will do.")
    ],
    out: Annotated[
        list[Path] | None,
        typer.Option(
            "--out",
            metavar="OUT",
            show_default=False,
            help="The new movement: .bvh, .amc (and .asf), .glb or .npz; several times for several of them.",
        ),
    ] = None,
    target: Annotated[
        str | None,
        typer.Option(
            "--target",
            metavar="X,Z",
            rich_help_panel=_PANEL,
            show_default=False,
            help="Go to a place: metres to the left (X) and ahead (Z) of the start.",
        ),
    ] = None,
    within: Annotated[
        float | None,
        typer.Option(
            "--within",
            metavar="METRES",
            rich_help_panel=_PANEL,
            show_default=False,
            help="How near to --target counts as there; 0.5 unless given.",
        ),
    ] = None,
    route: Annotated[
        Path | None,
        typer.Option(
            "--route",
            metavar="CSV",
            rich_help_panel=_PANEL,
            show_default=False,
            help="Follow a line on the floor: a corner x,z a row, in metres from the start.",
        ),
    ] = None,
    from_: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="S",
            rich_help_panel=_PANEL,
            show_default=False,
            help="Begin in this state of the motion graph: A, 'A*', X~.",
        ),
    ] = None,
    to: Annotated[
        str | None,
        typer.Option(
            "--to",
            metavar="S",
            rich_help_panel=_PANEL,
            show_default=False,
            help="Go to this state (with --from) by the quickest way; a transition counts as 3 s.",
        ),
    ] = None,
    favour: Annotated[
        str | None,
        typer.Option(
            "--favour",
            metavar="WORD",
            rich_help_panel=_PANEL,
            show_default=False,
            help="Much of this: a recording or a word in the names of recordings (walk); a class, state, path or phrase as "
            "analyze writes them (A*). Beside a goal a soft pull only.",
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds",
            metavar="S",
            rich_help_panel=_PANEL,
            show_default=False,
            help="How long; with a goal at most. 20 unless given, or what the goal may take.",
        ),
    ] = None,
    linger: Annotated[
        bool,
        typer.Option(
            "--linger", rich_help_panel=_PANEL, help="Go on to the end of --seconds when the goal is attained."
        ),
    ] = False,
    seed: Annotated[
        int, typer.Option("--seed", metavar="N", rich_help_panel=_PANEL, help="Another number, another performance.")
    ] = 0,
    beta: Annotated[
        float,
        typer.Option(
            "--beta", metavar="B", rich_help_panel=_PANEL, help="How strictly the goal decides: 0 strolls, inf never."
        ),
    ] = 100.0,
    bend: Annotated[
        float | None,
        typer.Option(
            "--bend",
            metavar="DEG",
            rich_help_panel=_PANEL,
            help="How much the way may be bent towards the goal, degrees a metre; more is tried where that does not do. 0: none. "
            "Unless given 5, or more where the way becomes far shorter by it.",
        ),
    ] = None,
    backwards: Annotated[
        bool,
        typer.Option(
            "--backwards",
            rich_help_panel=_PANEL,
            help="Recordings may be played backwards, too, wherever pose and velocity fit: good for ways that can be taken both "
            "ways; a jump or fall taken back looks wrong.",
        ),
    ] = False,
    no_mirror: Annotated[
        bool, typer.Option("--no-mirror", rich_help_panel=_PANEL, help="No mirror images of the recordings.")
    ] = False,
    threshold: Annotated[
        float | None,
        typer.Option(
            "--threshold",
            metavar="D",
            rich_help_panel=_PANEL,
            show_default=False,
            help="Largest mean distance D of a transition; found unless given.",
        ),
    ] = None,
    skeleton_of: Annotated[
        Path | None,
        typer.Option(
            "--skeleton-of",
            metavar="FILE",
            rich_help_panel=_PANEL,
            show_default=False,
            help="Perform on the body of this recording (its movement is not used); of the first unless given.",
        ),
    ] = None,
    fps: Annotated[
        float | None,
        typer.Option(
            "--fps",
            metavar="F",
            rich_help_panel=_PANEL,
            show_default=False,
            help="Frames a second of the new movement; of the first unless given.",
        ),
    ] = None,
    edits: Annotated[
        Path | None,
        typer.Option(
            "--edits",
            metavar="TOML",
            rich_help_panel=_PANEL,
            show_default=False,
            help="Your names for --from, --to and --favour; FILE.edits.toml where that is there.",
        ),
    ] = None,
    skip_unusable: Annotated[
        bool,
        typer.Option(
            "--skip-unusable", help="Go on without files that cannot be read, or whose skeletons are not understood."
        ),
    ] = False,
    overwrite: recording.Overwrite = False,
    json: recording.Json = False,
    skeleton: recording.Skeleton = None,
    map_: recording.Map = None,
    unit: recording.Unit = None,
    up: recording.Up = None,
) -> None:
    """Make new movement from recordings, over the moments at which one can pass into another.

    Where nothing is to be gone for, it goes on for --seconds without repeating itself more than it must.
    Beside OUT are left OUT's provenance.json (where every frame comes from) and a picture of the way over the floor.
    --out new.bvh --out new.glb share them.
    """
    from kinesics.report import performances
    from kinesics.synthesis.perform import performance
    from kinesics.synthesis.wish import Wish

    if not out and not json:
        raise typer.BadParameter(
            "Say where the new movement goes, such as --out new.bvh (or ask for --json alone).", param_hint="--out"
        )
    if out:
        recording.check_none_of(
            out, (*files, *([skeleton_of] if skeleton_of else []), *([skeleton] if skeleton else []))
        )
        performances.check_output(out, overwrite=overwrite)
    place = None if target is None else _target(target)
    line = None if route is None else _route(route)
    # what contradicts itself is told before anything is read
    Wish.of(place, line, from_, to, favour, None, within)
    named = from_ is not None or favour is not None
    known_better = recording.read_edits(edits or (recording.edits_beside(files[0]) if named else None))
    reading = Reading(skeleton, map_, unit, up)
    saved = None
    with terminal.Bar("Performing") as bar:
        read, left_out = reading.read_all(files, skip=skip_unusable, progress=bar.part(0.0, 0.15))
        for remark in left_out:
            terminal.remark(remark)
        body = None if skeleton_of is None else reading.read(skeleton_of)
        recording.check_none_of(out or (), itertools.starmap(recording.skeleton_beside, read))
        piece = performance(
            [motion for _, motion in read],
            target=place,
            radius=within,
            route=line,
            from_state=from_,
            to_state=to,
            favour=favour,
            seconds=seconds,
            linger=linger,
            seed=seed,
            beta=beta,
            bend=bend,
            mirrored=not no_mirror,
            backwards=backwards,
            skeleton=body,
            fps=fps,
            threshold=threshold,
            mapping=reading.mapping(),
            edits=known_better,
            progress=bar.part(0.15, 0.8),
        )
        piece = piece.with_warnings(left_out)
        if out:
            saved = performances.save_performance(piece, out, overwrite=overwrite, progress=bar.part(0.8, 1.0))
    if json:
        terminal.print_json(piece.to_dict())
    else:
        _summarize(piece)
    if saved is not None:
        _say_where(saved, terminal.remark if json else print)


def _target(text: str) -> tuple[float, float]:
    parts = text.replace(";", ",").split(",")
    try:
        x, z = (float(part) for part in parts)
    except ValueError:
        raise InputError(
            f"Expected --target as two numbers, X,Z in metres, such as --target 3,2; got '{text}'."
        ) from None
    return x, z


def _route(file: Path) -> list[tuple[float, float]]:
    """Corners of a route: two numbers a row (see `_words`); a heading may stand above."""
    from kinesics import formats

    try:
        text = formats.load(file).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(file, "is not UTF-8 text.", hint="Expected rows of two numbers, x,z in metres.") from None
    corners: list[tuple[float, float]] = []
    headed = False
    for number, row in enumerate(text.splitlines(), start=1):
        words = _words(row)
        if not words:
            continue
        try:
            values = [float(word) for word in words]
        except ValueError:
            if not corners and not headed:
                headed = True
                continue
            values = []
        if len(values) != 2 or not all(math.isfinite(v) for v in values):
            raise FileError(
                file, f"Expected two numbers, x,z in metres, got '{row.strip()[:60]}'.", line=number
            ) from None
        corners.append((values[0], values[1]))
        if len(corners) > _LONGEST_ROUTE:
            raise FileError(file, f"More than {_LONGEST_ROUTE} corners.", hint="Give fewer points of the line.")
    if len(corners) < 2:
        raise FileError(
            file,
            f"Expected a line of two corners or more, got {len(corners)}.",
            hint="Write a corner a row, x,z in metres from where the performer starts; for one place there is --target.",
        )
    return corners


def _words(row: str) -> list[str]:
    """What stands in a row of a table, as spreadsheets write it: between commas, semicolons, tabs or blanks, in quotes or not.

    Beside semicolons a comma is the decimal one.
    """
    row = row.split("#")[0].replace('"', " ")
    return row.replace(",", "." if ";" in row else " ").replace(";", " ").split()


def _summarize(piece: Piece) -> None:
    """What a choreographer wants to know: whether it got there, how often it changed, from what, what was left out."""
    from kinesics.synthesis.doubts import often_played

    console = terminal.console()
    motion, counted = piece.motion, terminal.counted
    lasts = f"{motion.duration:.1f}" if motion.duration >= 1.0 else f"{motion.duration:.2g}"
    console.print(
        f"[bold]{lasts} s[/bold] of new movement: {counted(motion.frame_count, 'frame')} at {motion.fps:g} fps"
    )
    target, away = piece.parameters["target"], piece.nearest
    if target is not None and away is not None:
        console.print(
            f"  target {_where(*target)}: came within {away:.2f} m; went {piece.length:.1f} m, {math.hypot(*target):.1f} m in a "
            "straight line"
        )
    elif piece.stays is not None:
        console.print(f"  stays in place, within {piece.stays:.2f} m of where it begins")
    else:
        console.print(f"  went {piece.length:.1f} m over the floor")
    # what was not attained is told among what is doubtful
    for said in piece.outcome if piece.attained or not motion.warnings else ():
        console.print(f"  {terminal.escape(said)}")
    crossings = piece.crossings
    if crossings:
        mirrors = sum(c.mirrors for c in crossings)
        console.print(
            f"  {counted(len(crossings), 'transition')}, one every {motion.duration / len(crossings):.1f} s"
            + (f"; {mirrors} of them between left and right" if mirrors else "")
        )
    else:
        console.print("  no transition: one stretch of one recording")
    shares = [0.0] * len(piece.sources)
    for span in piece.spans:
        shares[span.source] += (span.end - span.start) / motion.frame_count
    parts = sorted(((share, piece.sources[k].name) for k, share in enumerate(shares) if share > 0.0), reverse=True)
    console.print("  from " + ", ".join(f"{terminal.escape(name)} ({share:.0%})" for share, name in parts[:8]))
    console.print(
        f"  {piece.mirrored_share:.0%} of it mirrored"
        + (f", {piece.backwards_share:.0%} backwards" if piece.parameters["backwards"] else "")
    )
    checked = "checked:" if piece.check.holds else "[yellow]checked, and not all is as it should be:[/yellow]"
    console.print(f"  {checked} {terminal.escape(piece.check.sentence)}")
    times = motion.duration / piece.network.seconds
    if not piece.outcome:
        console.print(
            f"  {piece.network.seconds:.1f} s to choose from"
            + (f": every moment comes about {times:.1f} times" if times > 1.2 else "")
            + terminal.escape(f", {often}" if (often := often_played(piece)) else "")
        )
    for line in _left_out(piece):
        console.print(f"  [dim]{terminal.escape(line)}[/dim]")
    for line in motion.assumptions:
        if line.startswith(("performed ", "favoured ")) or ": used once" in line:
            console.print(f"  [dim]{terminal.escape(line)}[/dim]")
    other = [facts.name for facts in piece.sources if facts.fps != motion.fps]
    if other:
        console.print(
            f"  [dim]resampled to {motion.fps:g} frames a second: {terminal.escape(', '.join(other[:8]))}[/dim]"
        )
    for line in motion.warnings:
        console.print(f"  [yellow]doubtful:[/yellow] {terminal.escape(line)}")


def _left_out(piece: Piece) -> list[str]:
    """How much is not used, of which recording what and why, and what would join it."""
    lost = sum(p.seconds * (p.strand.count(" and ") + 1) for p in piece.pruned)
    if lost <= 0.0:
        return []
    have = lost + piece.network.seconds
    either = " or mirrored" if piece.parameters["mirrored"] else ""
    lines = [f"not used, for no way leads there or back: {lost / have:.0%} of what was recorded{either}"]
    if lost < MUCH * have:
        return lines
    dearest = sorted(piece.pruned, key=lambda p: -p.seconds)
    lines += [f"  {p}" for p in dearest[:_LEFT_OUT_AT_MOST]]
    if more := dearest[_LEFT_OUT_AT_MOST:]:
        lines.append(f"  and {sum(p.seconds for p in more):.1f} s of others, told in the provenance")
    if have > TRIED:
        return [
            *lines,
            f"a larger --threshold than {piece.network.threshold:.2g}, or more recordings like it, may join it",
        ]
    from kinesics.synthesis.reach import farther

    larger = farther(piece.network)
    if larger is None:
        return [*lines, "no larger --threshold joins much more of it; more recordings like it may"]
    return [
        *lines,
        f"--threshold {larger.threshold:g} leaves out {1.0 - larger.seconds / have:.0%}, by transitions between moments less alike",
    ]


def _where(x: float, z: float) -> str:
    """A place on the floor, as seen by one who starts."""
    told = [f"{abs(x):g} m to the {'left' if x > 0.0 else 'right'}"] if x else []
    told += [f"{abs(z):g} m {'ahead' if z > 0.0 else 'behind'}"] if z else []
    return ", ".join(told) or "where one starts"


def _say_where(saved: Saved, say: object) -> None:
    assert callable(say)
    for remark in saved.remarks:
        terminal.remark(remark)
    for motion in saved.motions:
        say(f"Movement: {motion}")
    for provenance in saved.provenances:
        say(f"Where it comes from: {provenance}")
    for picture in saved.pictures:
        say(f"Picture: {picture}")
