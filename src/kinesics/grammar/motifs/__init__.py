"""Motifs: stretches that recur, the same, mirrored, backwards or both; states that return; turnings back; strikes.

The dissertation's visual motifs ([Schultz2012] §3.2-3.4): proximity signals in Z (same, reverse) and Z* (mirror, mirror and
reverse), along the identity axis or at right angles to it. Here they are sets: a stretch, and all places where it comes back.

- `find_motifs`: going through the recording, the first stretch not yet explained is looked up in the whole recording, made as
  long as it recurs, and looked up again as a whole; what is found is explained and not looked up any more. So a movement done
  a hundred times is one set of a hundred members, not 4,950 pairs.
- `find_state_repetitions` (§3.2.2, §3.4.2), `find_reversals` (§3.2.4), `find_strikes` (§3.6.3).

**Tempo** is free: one side may go up to twice as fast as the other, for a while or throughout. **Ends** are where the alignment
gains no more (Smith and Waterman 1981): every moment of it gains what it is nearer than chance. **Chance**: distances are
measured against the range of the movement around; unrelated movement leaves about 1. **Stillness** has no range and gains nothing:
it never poses as a repetition.

Memory grows with the length of the recording and with the stretch that is looked up, not with its square.
"""

from __future__ import annotations

from kinesics.grammar.motifs.alignment import seed_costs, subsequence
from kinesics.grammar.motifs.returns import StateRepetition, find_state_repetitions
from kinesics.grammar.motifs.search import find_motifs
from kinesics.grammar.motifs.sets import RELATIONS, Member, Motif, in_frames
from kinesics.grammar.motifs.strikes import Strike, find_strikes
from kinesics.grammar.motifs.turnings import Reversal, find_reversals

__all__ = [
    "RELATIONS",
    "Member",
    "Motif",
    "Reversal",
    "StateRepetition",
    "Strike",
    "find_motifs",
    "find_reversals",
    "find_state_repetitions",
    "find_strikes",
    "in_frames",
    "seed_costs",
    "subsequence",
]
