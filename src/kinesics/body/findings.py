"""What looks wrong in a recording, and how it is told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

Kind = Literal["size", "gap", "glitch", "frozen", "speed", "jitter", "floor"]
KINDS: Final[tuple[Kind, ...]] = get_args(Kind)
"""What a finding can be, worst first."""
MOST_SENTENCES: Final = 6
_KIND_WORDS: Final[dict[Kind, str]] = {
    "size": "A wrong size",
    "gap": "Such a jump",
    "glitch": "Such a leap",
    "frozen": "Such a stretch",
    "speed": "Such a speed",
    "jitter": "Such noise",
    "floor": "The like",
}


@dataclass(frozen=True)
class Finding:
    """One thing that looks wrong."""

    kind: Kind
    joints: tuple[str, ...]
    """The joints concerned, worst first; empty for the whole body."""
    start: int
    end: int
    """Frames [start, end)."""
    figure: float
    """How bad, in ``unit``."""
    unit: str
    sentence: str
    moved: float = 0.0
    """Of a glitch: metres by which the farthest point that hangs on the joints is thrown, at most."""

    @property
    def joint(self) -> str:
        """The worst joint; "" for the whole body."""
        return self.joints[0] if self.joints else ""


@dataclass(frozen=True)
class Quality:
    """What looks wrong in one recording; empty findings are the best news."""

    findings: tuple[Finding, ...]
    """Every one, by kind (worst kind first), then by how bad."""
    sentences: tuple[str, ...]
    """The same in at most six sentences, events of one joint told together."""

    def of_kind(self, kind: Kind) -> tuple[Finding, ...]:
        """The findings of one kind."""
        return tuple(f for f in self.findings if f.kind == kind)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {
            "sentences": list(self.sentences),
            "counts": {kind: len(self.of_kind(kind)) for kind in KINDS},
            "findings": [
                {
                    "kind": f.kind,
                    "joints": list(f.joints),
                    "start": f.start,
                    "end": f.end,
                    "figure": f.figure,
                    "unit": f.unit,
                    "moved_m": f.moved,
                    "sentence": f.sentence,
                }
                for f in self.findings
            ],
        }


def told(findings: Sequence[Finding]) -> tuple[str, ...]:
    """At most `MOST_SENTENCES`, worst kind first; events of one kind told together."""
    told: list[str] = []
    for kind in KINDS:
        members = [f for f in findings if f.kind == kind]
        if kind == "glitch":
            told += _tell_glitches(members)
        elif len(members) <= 2:
            told += [f.sentence for f in members]
        else:
            told += [members[0].sentence, f"{_KIND_WORDS[kind]} {len(members) - 1} times more: {_frames(members[1:])}."]
    if len(told) > MOST_SENTENCES:
        left = len(told) - MOST_SENTENCES + 1
        told = [*told[: MOST_SENTENCES - 1], f"And {left} more findings of less weight."]
    return tuple(told)


def _tell_glitches(findings: Sequence[Finding]) -> list[str]:
    """One sentence for each of the three joints that throw the body farthest, one for the rest."""
    if len(findings) <= 2:
        return [f.sentence for f in findings]
    by_joint: dict[str, list[Finding]] = {}
    for finding in findings:
        by_joint.setdefault(finding.joint, []).append(finding)
    # findings come worst first, so joints come in the order of their worst; those that leap together are told together
    together: dict[tuple[int, ...], list[str]] = {}
    for joint, members in by_joint.items():
        together.setdefault(tuple(sorted(f.start for f in members)), []).append(joint)
    told = []
    for joints in list(together.values())[:3]:
        members = by_joint[joints[0]]
        worst = max(members, key=lambda f: f.figure)
        size = f"{worst.figure:.0f}{'' if worst.unit == '°' else ' '}{worst.unit}"
        times = f"at frame {members[0].start}" if len(members) == 1 else f"{len(members)} times: {_frames(members)}"
        verb = "leaps" if len(joints) == 1 else "leap"
        told.append(f"{', '.join(joints)} {verb} by up to {size} in one frame {times}.")
    rest = [f"{joint} ({len(by_joint[joint])})" for joints in list(together.values())[3:] for joint in joints]
    if rest:
        more = f" and {len(rest) - 6} more joints" if len(rest) > 6 else ""
        told.append(f"Leaps also of {', '.join(rest[:6])}{more}.")
    return told


def _frames(findings: Sequence[Finding]) -> str:
    starts = sorted(f.start for f in findings)
    text = ", ".join(str(t) for t in starts[:6])
    return f"frame{'s' if len(starts) > 1 else ''} {text}{', …' if len(starts) > 6 else ''}"


def frames_text(start: int, end: int) -> str:
    """ "frame 7" or "frames 7-9" for [start, end)."""
    return f"frame {start}" if end - start == 1 else f"frames {start}-{end - 1}"
