"""A bent chain by small steps, and where bones point: slow and obvious."""

from __future__ import annotations

import math

import numpy as np


def multiply(a, b):
    """Hamilton product of two quaternions (w, x, y, z)."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def fraction(q, part):
    """The same turn about the same axis, by a part of its angle."""
    w, *v = q if q[0] >= 0 else [-c for c in q]
    length = math.sqrt(sum(c * c for c in v))
    if length == 0.0:
        return (1.0, 0.0, 0.0, 0.0)
    half = math.atan2(length, w) * part
    return (math.cos(half), *(math.sin(half) * c / length for c in v))


def links_of_chain(joints, links):
    """The rotations of ``links`` equal stretches of a chain: every joint turns in ``links`` small steps, one after another."""
    steps = [fraction(q, 1.0 / links) for q in joints for _ in range(links)]
    each = len(joints)
    out = []
    for link in range(links):
        total = (1.0, 0.0, 0.0, 0.0)
        for step in steps[link * each : (link + 1) * each]:
            total = multiply(total, step)
        out.append(total)
    return out


def directions(positions, names, bones):
    """Where bones point in the world: for each (joint, joint at its end), in each frame, a unit vector."""
    out = {}
    for start, end in bones:
        rows = []
        for frame in positions:
            v = frame[names.index(end)] - frame[names.index(start)]
            rows.append(v / math.sqrt(sum(c * c for c in v)))
        out[start] = np.array(rows)
    return out


def mirrored_bones(positions, parents, partner, lengths):
    """Where joints are, from the first: each bone of its own length, pointing as its counterpart does in the mirror."""
    out = np.zeros_like(positions)
    for f, frame in enumerate(positions):
        for j in range(1, len(parents)):
            x, y, z = frame[partner[j]] - frame[parents[partner[j]]]
            length = math.sqrt(x * x + y * y + z * z)
            out[f, j] = out[f, parents[j]] + lengths[j] / length * np.array([-x, y, z])
    return out
