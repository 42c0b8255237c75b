"""What ``kinesics perform`` says of a movement that it made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from kinesics.cli import terminal

if TYPE_CHECKING:
    from kinesics.synthesis.piece import Piece

MUCH: Final = 0.25
"""Share of the recordings left out from which it is said which part it is and what would join it."""
_LEFT_OUT_AT_MOST: Final = 4
_RIGS: Final = (".bvh", ".amc")
"""Of files that are played on a skeleton with joints of these names."""


def summarize(piece: Piece, out: Sequence[Path] = ()) -> None:
    """What a choreographer wants to know: whether it got there, how often it changed, from what, what was left out.

    Parameters
    ----------
    out : files that it is written to.
    """
    from kinesics.synthesis.doubts import often_played
    from kinesics.synthesis.repertoire import ROOT_PUT

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
    elif motion.frame_count == 1:
        console.print("  a single pose")
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
            if len(crossings) > 1
            else f"  1 transition{', between left and right' if mirrors else ''}"
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
    shown = ["performed at", "performed on", "favoured "]
    if any(file.suffix.lower() in _RIGS for file in out):
        # who plays it on the rig of the recordings has to know; a figure of its own, or arrays, need not
        shown.append(ROOT_PUT)
    for line in motion.assumptions:
        if line.startswith(tuple(shown)) or ": used once" in line:
            console.print(f"  [dim]{terminal.escape(line)}[/dim]")
    other = [facts.name for facts in piece.sources if facts.fps != motion.fps]
    if other:
        console.print(
            f"  [dim]resampled to {motion.fps:g} frames a second: {terminal.escape(', '.join(other[:8]))}[/dim]"
        )
    for line in motion.warnings:
        console.print(f"  [yellow]doubtful:[/yellow] {terminal.escape(line)}")


def _left_out(piece: Piece) -> list[str]:
    """How much is not used, of which recording what and why, and what would join it (where that is no doubt already)."""
    from kinesics.synthesis import unused
    from kinesics.synthesis.doubts import MOSTLY

    net = piece.network
    total = unused.used(net)
    if total.unused <= 0.0:
        return []
    if not net.pruned:
        why = (
            "it lies on no way from the one state to the other"
            if piece.parameters["to_state"] is not None
            else "no way leads there, or none goes on"
        )
        return [f"not used, for {why}: {total.unused:.0%} of what was recorded"]
    lines = [f"not used, for no way leads there or back: {total.unused:.0%} of what was recorded"]
    if total.unused < MUCH:
        return lines
    dearest = sorted(piece.pruned, key=lambda p: -p.seconds)
    lines += [f"  {p}" for p in dearest[:_LEFT_OUT_AT_MOST]]
    if more := dearest[_LEFT_OUT_AT_MOST:]:
        lines.append(f"  and {sum(p.seconds for p in more):.1f} s of others, told in the provenance")
    if total.unused >= MOSTLY:
        return lines
    if unused.too_many(net):
        return [*lines, f"a larger --threshold than {net.threshold:.2g}, or more recordings like it, may join it"]
    larger = unused.larger_threshold(net)
    if larger is None:
        return [*lines, "no larger --threshold joins much more of it; more recordings like it may"]
    left = larger.seconds.unused
    return [
        *lines,
        f"--threshold {larger.threshold:g} leaves out {left:.0%}, by transitions between moments less alike",
    ]


def _where(x: float, z: float) -> str:
    """A place on the floor, as seen by one who starts."""
    told = [f"{abs(x):g} m to the {'left' if x > 0.0 else 'right'}"] if x else []
    told += [f"{abs(z):g} m {'ahead' if z > 0.0 else 'behind'}"] if z else []
    return ", ".join(told) or "where one starts"
