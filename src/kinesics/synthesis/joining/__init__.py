"""Where recordings may go over into one another, and what of them holds together then ([Schultz2012] §4.4; Kovar 2002).

- what agrees: `seams` (poses over a window, with `measures`), `limits` (velocities, contacts), compared for all pairs by `search`
- which are used: `choice`, `sharing` (on which seams), `widening` (when poses may differ by more than usual)
- the whole: `transitions`; what it cuts: `parts`; leaps of the recordings: `faults`
"""
