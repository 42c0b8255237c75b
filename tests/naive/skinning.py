"""Linear blend skinning as the definition says it: one vertex, one joint, one matrix at a time."""

from __future__ import annotations

import numpy as np

from kinesics.geometry import quaternion


def placed(rotation, position):
    """The 4 × 4 matrix of a turn and a place."""
    out = np.eye(4)
    out[:3, :3] = quaternion.as_matrix(rotation)
    out[:3, 3] = position
    return out


def world_matrices(skeleton, rotations, root, shifts=None):
    """Of all joints in one frame, by going down the tree."""
    out = []
    for j, parent in enumerate(skeleton.parents):
        place = root if parent < 0 else (skeleton.offsets[j] if shifts is None else shifts[j])
        own = placed(rotations[j], place)
        out.append(own if parent < 0 else out[parent] @ own)
    return out


def skinned(vertex, joints, weights, inverse_binds, matrices):
    """Where one vertex is: Σ w · world · bind⁻¹ · v."""
    v = np.append(vertex, 1.0)
    out = np.zeros(4)
    for joint, weight in zip(joints, weights, strict=True):
        out += weight * (matrices[joint] @ (inverse_binds[joint] @ v))
    return out[:3]


def share(turn, part):
    """A part of a turn, the shorter way round, by its axis and angle."""
    w, vector = (turn[0], turn[1:]) if turn[0] >= 0.0 else (-turn[0], -turn[1:])
    angle = 2.0 * np.arctan2(np.linalg.norm(vector), w)
    return quaternion.identity() if angle < 1e-12 else quaternion.from_axis_angle(vector, part * angle)


def helped(turn, axis, swing, twist):
    """Shares of the shortest turn that carries an axis to where the whole turn carries it, and of the rest."""
    away = quaternion.between(axis, quaternion.rotate(turn, axis))
    about = quaternion.multiply(quaternion.conjugate(away), turn)
    return quaternion.multiply(share(away, swing), share(about, twist))


def crossings(vertices, triangles):
    """How many edges of a closed surface go through a triangle that has none of their ends, by asking near ones."""
    from scipy.spatial import cKDTree

    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    middle, centre = vertices[edges].mean(axis=1), vertices[triangles].mean(axis=1)
    half = np.linalg.norm(vertices[edges[:, 0]] - middle, axis=1)
    reach = np.linalg.norm(vertices[triangles] - centre[:, None], axis=2).max(axis=1)
    e, t = [], []
    tree = cKDTree(centre)
    for k, found in enumerate(tree.query_ball_point(middle, half + reach.max())):
        close = np.array(found)
        close = close[np.linalg.norm(centre[close] - middle[k], axis=1) < half[k] + reach[close]]
        e.append(np.repeat(edges[k : k + 1], len(close), axis=0))
        t.append(triangles[close])
    e, t = np.concatenate(e), np.concatenate(t)
    apart = (e[:, :, None] != t[:, None, :]).all(axis=(1, 2))
    e, t = e[apart], t[apart]
    start, way = vertices[e[:, 0]], vertices[e[:, 1]] - vertices[e[:, 0]]
    corner, one, other = vertices[t[:, 0]], vertices[t[:, 1]] - vertices[t[:, 0]], vertices[t[:, 2]] - vertices[t[:, 0]]
    # start + s·way = corner + u·one + v·other
    system = np.stack([-way, one, other], axis=2)
    solvable = np.abs(np.linalg.det(system)) > 1e-15
    s, u, v = np.linalg.solve(system[solvable], (start - corner)[solvable][..., None])[..., 0].T
    return int(np.sum((s > 0.0) & (s < 1.0) & (u > 0.0) & (v > 0.0) & (u + v < 1.0)))
