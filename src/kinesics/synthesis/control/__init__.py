"""Which path comes next, one decision after the other: the Markov controller of [Schultz2012] §4.4.1.

- a row of P: `intentions` (what is wished now), `weighing` (what each choice is worth)
- the walk: `controller`, until `stopping`; at once: `courses`
"""
