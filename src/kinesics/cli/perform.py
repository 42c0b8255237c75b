"""``kinesics perform FILE… --out OUT``: new movement from recordings."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING

import typer

from kinesics.cli import perform_options as options
from kinesics.cli import recording, terminal
from kinesics.cli.perform_summary import summarize
from kinesics.cli.recording import Reading
from kinesics.errors import InputError

if TYPE_CHECKING:
    from kinesics.report.performances import Saved

SUMMARY = "Make new movement from recordings."
EXAMPLES = (
    ("kinesics perform walk.bvh --out new.bvh --target 2,4", "walks to a place: 2 m to the left, 4 m ahead"),
    ("kinesics perform a.amc b.amc --out new.glb --route eight.csv", "along a line: a corner x,z a row, in metres"),
    ("kinesics perform dance.bvh --out new.bvh --out new.glb --seconds 60", "a minute, in two formats"),
    ("kinesics perform a.bvh --out new.bvh --from A --to 'B*'", "from state to state of the motion graph"),
)


def perform(
    files: options.Files,
    out: options.Out = None,
    target: options.Target = None,
    within: options.Within = None,
    route: options.Route = None,
    from_: options.From = None,
    to: options.To = None,
    favour: options.Favour = None,
    seconds: options.Seconds = None,
    linger: options.Linger = False,
    seed: options.Seed = 0,
    beta: options.Beta = 100.0,
    bend: options.Bend = None,
    backwards: options.Backwards = False,
    no_mirror: options.NoMirror = False,
    threshold: options.Threshold = None,
    skeleton_of: options.SkeletonOf = None,
    fps: options.Fps = None,
    edits: options.Edits = None,
    skip_unusable: options.SkipUnusable = False,
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
    from kinesics.synthesis.perform import fulfil
    from kinesics.synthesis.request import Request

    if not out and not json:
        raise typer.BadParameter(
            "Say where the new movement goes, such as --out new.bvh (or ask for --json alone).", param_hint="--out"
        )
    if out:
        recording.check_none_of(
            out, (*files, *([skeleton_of] if skeleton_of else []), *([skeleton] if skeleton else []))
        )
        performances.check_output(out, overwrite=overwrite)
    # what cannot be, or contradicts itself, is told before anything is read
    asked = Request(
        target=None if target is None else options.target_of(target),
        radius=within,
        route=None if route is None else options.route_of(route),
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
        fps=fps,
        threshold=threshold,
    )
    named = from_ is not None or favour is not None
    known_better = recording.read_edits(edits or (recording.edits_beside(files[0]) if named else None))
    reading = Reading(skeleton, map_, unit, up)
    saved = None
    with terminal.Bar("Performing") as bar:
        body = None if skeleton_of is None else reading.read_body(skeleton_of)
        read, left_out = reading.read_all(files, skip=skip_unusable, progress=bar.part(0.0, 0.15))
        for remark in left_out:
            terminal.remark(remark)
        recording.check_none_of(out or (), itertools.starmap(recording.skeleton_beside, read))
        doubts = [f"{file.name}: {said}" for file, motion in read for said in motion.warnings]
        try:
            piece = fulfil(
                [motion for _, motion in read],
                asked,
                skeleton=body,
                mapping=reading.mapping(),
                edits=known_better,
                progress=bar.part(0.15, 0.8),
            )
        except InputError:
            # what looked wrong in a file may be why nothing comes of it
            for doubt in doubts:
                terminal.remark(doubt)
            raise
        piece = piece.with_warnings([*left_out, *doubts])
        if out:
            saved = performances.save_performance(piece, out, overwrite=overwrite, progress=bar.part(0.8, 1.0))
    if json:
        terminal.print_json(piece.to_dict())
    else:
        summarize(piece, out or ())
    if saved is not None:
        _say_where(saved, terminal.remark if json else print)


def _say_where(saved: Saved, say: Callable[[str], None]) -> None:
    for remark in saved.remarks:
        terminal.remark(remark)
    for motion in saved.motions:
        say(f"Movement: {motion}")
    for provenance in saved.provenances:
        say(f"Where it comes from: {provenance}")
    for picture in saved.pictures:
        say(f"Picture: {picture}")
