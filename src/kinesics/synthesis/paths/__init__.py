"""The stretches between transitions, what may follow what, and where they lead: the δ of [Schultz2012] §4.4.

- the graph: `network`, with how bodies meet (`meeting`) and what was left out (`pruning`, `reach` what would join it)
- its words: `labels` (the grammar's), `ways` (from one path to another)
- its places: `trails` (where a path leads over the floor), `laying` (one after the other)
- what may come: `bundles` and `prospects` (composites of paths), `togo` (seconds to a place)
"""
