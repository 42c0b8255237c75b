"""Cyclic stretches woven into a reading: their states among those found, their visits among the others.

What is a state there follows from the class of the movement (`kinesics.grammar.cyclic`), not from marked moments.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from kinesics.grammar.cyclic import Cyclic
from kinesics.grammar.ground import Nearness
from kinesics.grammar.moments import Moments
from kinesics.grammar.reading.states import ReadState
from kinesics.grammar.reading.traversals import Way
from kinesics.grammar.reading.visits import Visit

Roles = dict[tuple[int, int], tuple[int, bool]]
"""(cyclic stretch, role) to state, and whether what is unmirrored in the stretch is the state's mirror image."""


def with_cyclic(
    moments: Moments, states: Sequence[ReadState], cyclic: Sequence[Cyclic], near: Nearness
) -> tuple[list[ReadState], Roles]:
    """Add the states of the cyclic stretches; where one lies in a state that is there already, it is that one."""
    out = list(states)
    roles: Roles = {}
    for number, stretch in enumerate(cyclic):
        for role in sorted({a.role for a in stretch.anchors}):
            of_role = [a for a in stretch.anchors if a.role == role]
            side = all(a.mirrored for a in of_role)
            index = np.array([a.moment for a in of_role if a.mirrored == side], dtype=np.intp)
            d, _ = moments.between(index, index)
            new = ReadState(int(index[d.mean(axis=1).argmin()]), of_role[0].symmetric, True)
            taken = [k for (n, _), (k, _) in roles.items() if n == number]
            same = _same_as(moments, new, {k: s for k, s in enumerate(out) if k not in taken}, near)
            if same is None:
                roles[number, role] = len(out), side
                out.append(new)
            else:
                roles[number, role] = same[0], same[1] != side
    return out, roles


def _same_as(
    moments: Moments, new: ReadState, states: Mapping[int, ReadState], near: Nearness
) -> tuple[int, bool] | None:
    """The nearest of states that a new one lies in, and whether it is that one's mirror image; None where there is none."""
    candidates = [k for k, s in states.items() if s.symmetric == new.symmetric]
    if not candidates:
        return None
    there = np.array([states[k].moment for k in candidates], dtype=np.intp)
    straight, image = (block[0] for block in moments.between(np.array([new.moment]), there))
    distances = np.minimum(straight, image)
    best = int(distances.argmin())
    if distances[best] >= near.state:
        return None
    return candidates[best], bool(not new.symmetric and image[best] < straight[best])


def without_states(states: Sequence[ReadState], roles: Roles, gone: set[int]) -> tuple[list[ReadState], Roles]:
    """The states that are left, and the roles by their new numbers."""
    kept = [k for k in range(len(states)) if k not in gone]
    number = {k: i for i, k in enumerate(kept)}
    return [states[k] for k in kept], {role: (number[k], side) for role, (k, side) in roles.items()}


def cyclic_visits(
    visits: Sequence[Visit], cyclic: Sequence[Cyclic], roles: Roles
) -> tuple[list[Visit], dict[int, Way]]:
    """Visits with those of the cyclic stretches among them; and what is known of the way from a visit to the next one."""
    keyed: list[tuple[Visit, Way | None]] = [(v, None) for v in visits]
    for number, stretch in enumerate(cyclic):
        ways = [Way((number, *leg.key), leg.reversed, leg.mirrored) for leg in stretch.legs]
        for anchor, way in zip(stretch.anchors, [*ways, None], strict=True):
            state, side = roles[number, anchor.role]
            visit = Visit(anchor.moment, anchor.moment + 1, anchor.moment, state, anchor.mirrored != side)
            keyed.append((visit, way))
    keyed.sort(key=lambda item: item[0].at)
    return [v for v, _ in keyed], {k: way for k, (_, way) in enumerate(keyed) if way is not None}
