"""What ``kinesics perform`` says of a movement that it made."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from kinesics.cli import terminal

if TYPE_CHECKING:
    from kinesics.synthesis.piece import Piece

MUCH: Final = 0.25
"""Share of the recordings left out from which it is said which part it is and what would join it."""
TRIED: Final = 240.0
"""Seconds of recordings and their images, up to which a larger threshold is tried rather than advised."""
_LEFT_OUT_AT_MOST: Final = 4


def summarize(piece: Piece) -> None:
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
