"""What a person knows better: names, merges and splits of states, paths and phrases, kept in a side file.

The file is TOML and is applied again to every new analysis. Labels are those of the analysis without the file; they are looked up
before anything is changed. What is said of a state or a path holds for its mirror image too, but not splits, which name moments::

    [states]
    rename = { A = "guard", "X~" = "attention" }      # A* becomes guard*, X~ becomes attention~
    merge = [ { keep = "B", with = ["C", "D"] } ]
    split = [ { state = "E", into = "chamber", frames = [812, 1430] } ]      # the visits nearest to these frames

    [paths]
    rename = { "ab_1" = "lunge" }                     # its mirror image becomes (lunge)*
    merge = [ { keep = "bc_1", with = ["bc_2"] } ]
    split = [ { path = "ab_1", into = "jab", frames = [120] } ]              # the traversals at these frames

    [phrases]
    rename = [ { frame = 100, name = "warm-up" } ]    # the phrase at this frame
    merge = [ { from = 300, to = 900 } ]              # all phrases from the one to the other
    split = [ { frame = 500 } ]                       # a phrase begins here

``source = 1`` in a split, or in anything of a phrase, counts frames in the second recording; ``source = "walk.bvh"`` in the one of
that name, wherever it stands. Splits are done first, then merges, then names are given.

Labels follow the order in which states come up: another choice of recordings, weights or joints may change them. In the place of a
label a frame may stand, which does not depend on that: ``"@812"`` is the state visited nearest to frame 812 of the first recording,
or the path traversed at it; ``"1@812"`` and ``"walk.bvh@812"`` are of the second recording, and of the one of that name.

- `parse` reads the text of such a file: `Edits`, which is applied to a graph and to phrases
"""

from __future__ import annotations

from kinesics.grammar.edits.changes import Edits, Merge, Phrase, PhraseMerge, PhraseName, PhraseSplit, Split
from kinesics.grammar.edits.labels import NEAR
from kinesics.grammar.edits.side_file import parse

__all__ = ["NEAR", "Edits", "Merge", "Phrase", "PhraseMerge", "PhraseName", "PhraseSplit", "Split", "parse"]
