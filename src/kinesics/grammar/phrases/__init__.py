"""Phrases: a recording cut into stretches of one kind of movement.

What makes a stretch one phrase is that it recurs within itself: the same, mirrored, backwards or both ([Schultz2012] §3.2-3.4),
a few seconds later. Between one exercise and the next nothing recurs across. So for every moment all recurrences are weighed
that reach across it, from a stretch before it to one after it (crossing.py): phrases are the hills of that curve, and where it
falls to a small part of the lower hill beside it, one phrase ends and another begins.

- **Tempo freedom.** A recurrence is a path, not a straight line: one side may go up to twice as fast for a while.
- **Several scales.** Stretches of about 0.8, 1.6 and 3.2 s are compared, so that quick and slow cycles are seen alike.
- **Against chance.** A path's mean distance is measured against the range of both stretches. Stretches of unrelated movement
  leave about 1, and one in twenty finds somewhere in the neighbourhood a path that leaves .3 to .4; what leaves more than `CHANCE`
  does not count, and what leaves less counts the more, the less it leaves. Both halves of a path must be alike.
- **Stillness is no recurrence.** Both stretches must move by more than a body at rest sways.

The border itself is put where the moments before it are nearer to the one hill and those after it to the other. What recurs
nowhere, between two calm moments, is a phrase made once; a long rest is a phrase of its own. Phrases whose movements are found
in one another get the same kind, however far apart they are.

- `find_phrases` (cutting.py; rests.py says where the body rests or is calm)
- `kinds_apart`, `mirror_image`: which are of one kind, in one recording or several (kinds.py)
"""

from __future__ import annotations

from kinesics.grammar.phrases.crossing import CHANCE, REACH_S, SCALES_S
from kinesics.grammar.phrases.cutting import GAP_S, SHORTEST_S, find_phrases
from kinesics.grammar.phrases.kinds import KIN, kinds_apart, mirror_image
from kinesics.grammar.phrases.pieces import Phrase
from kinesics.grammar.phrases.rests import REST_S

__all__ = [
    "CHANCE",
    "GAP_S",
    "KIN",
    "REACH_S",
    "REST_S",
    "SCALES_S",
    "SHORTEST_S",
    "Phrase",
    "find_phrases",
    "kinds_apart",
    "mirror_image",
]
