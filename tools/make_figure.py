"""Make the template of the human figure: src/kinesics/body/figure.npz.

The shape (`figure_shape`) is polygonised as one closed surface, and every vertex gets its shares of the bones and of the
helpers at the joints, which `kinesics.body.figure_skin` describes.

Run by hand, only when the figure is to change; it needs what the package does not:

    python -m pip install scikit-image fast-simplification scipy numpy
    python tools/make_figure.py [--grid 0.004] [--triangles 24000]

Only the left half is made and kept. The right half is its mirror image to the last bit.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from figure_shape import (
    FOLD,
    HIP,
    KEEP,
    LEG,
    POINTS,
    Array,
    along_arm,
    arm,
    hand,
    head,
    neck,
    smooth_union,
    surface,
    trunk,
)
from numpy.typing import NDArray

TARGET = Path(__file__).resolve().parents[1] / "src" / "kinesics" / "body" / "figure.npz"

# ----------------------------------------------------------------------------------------------------- polygonised


def polygons(grid: float) -> tuple[Array, NDArray[np.intp]]:
    """The half at x ≥ 0 by marching cubes; its rim lies on x = 0."""
    from scipy.ndimage import zoom
    from skimage.measure import marching_cubes

    low, high = np.array([0.0, -0.03, -0.17]), np.array([0.78, 1.80, 0.24])
    coarse = 4
    cells = np.ceil((high - low) / (grid * coarse)).astype(int)
    axes = [low[i] + grid * coarse * np.arange(cells[i] + 1) for i in range(3)]
    rough = evaluate(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)).reshape(
        [len(a) for a in axes]
    )
    fine = [low[i] + grid * np.arange(cells[i] * coarse + 1) for i in range(3)]
    field = zoom(rough, [len(f) / len(a) for f, a in zip(fine, axes, strict=True)], order=1, grid_mode=False)
    near = np.abs(field) < grid * coarse * 2.5
    index = np.argwhere(near)
    field[near] = evaluate(low + grid * index)
    vertices, faces, _, _ = marching_cubes(field, 0.0, spacing=(grid, grid, grid))
    vertices = vertices.astype(np.float64) + low
    return vertices, faces.astype(np.intp)


def evaluate(p: Array) -> Array:
    """`surface`, in pieces that fit the memory."""
    return np.concatenate([surface(part) for part in np.array_split(p, max(1, len(p) // 200_000))])


FACE = 1.52
"""Height above which the head is looked at more closely than the body."""


def closer(height: Array) -> Array:
    """How much larger the figure counts, where it is thinned out."""
    return 1.0 + 0.9 * np.clip((height - FACE) / 0.06, 0.0, 1.0)


def thinned(vertices: Array, faces: NDArray[np.intp], triangles: int) -> tuple[Array, NDArray[np.intp]]:
    """Fewer triangles, more of them where the surface bends, and in the face."""
    import fast_simplification

    base = np.array([0.0, FACE, 0.0])
    points, cells = fast_simplification.simplify(
        base + closer(vertices[:, 1])[:, None] * (vertices - base),
        faces.astype(np.int32),
        target_count=triangles,
        agg=5.0,
    )
    heights = np.linspace(0.0, 2.0, 20_001) - 0.1
    own = np.interp(points[:, 1], FACE + closer(heights) * (heights - FACE), heights)
    out = base + (np.asarray(points, dtype=np.float64) - base) / closer(own)[:, None]
    return out, np.asarray(cells, dtype=np.intp)


def rim_of(faces: NDArray[np.intp], count: int) -> NDArray[np.bool_]:
    """Vertices on edges that only one triangle has."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, uses = np.unique(edges, axis=0, return_counts=True)
    rim = np.zeros(count, dtype=bool)
    rim[unique[uses == 1].ravel()] = True
    return rim


def relaxed(vertices: Array, faces: NDArray[np.intp], rounds: int) -> Array:
    """Vertices evened out along the surface and put back onto it; the rim stays on x = 0."""
    from scipy.sparse import coo_array, diags_array

    n = len(vertices)
    rim = rim_of(faces, n)
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    # on the rim only its own neighbours pull
    pairs = pairs[~rim[pairs[:, 0]] | rim[pairs[:, 1]]]
    joined = (coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n)).tocsr() > 0).astype(float)
    average = diags_array(1.0 / np.maximum(joined.sum(axis=1), 1)) @ joined
    out = vertices.copy()
    out[rim, 0] = 0.0
    for step in range(rounds):
        normal = gradient(out)
        pull = average @ out - out
        pull -= np.einsum("ij,ij->i", pull, normal)[:, None] * normal
        if step < rounds - 1:
            out += 0.5 * pull
        out[rim, 0] = 0.0
        out[~rim, 0] = np.maximum(out[~rim, 0], 1e-4)
        for _ in range(2):
            normal = gradient(out)
            normal[rim, 0] = 0.0
            out -= np.clip(evaluate(out), -0.004, 0.004)[:, None] * normal
    out[rim, 0] = 0.0
    return out


def gradient(p: Array) -> Array:
    """Unit normals of the surface by central differences."""
    h = 5e-4
    columns = []
    for step in np.eye(3) * h:
        # the figure is its own mirror image: what lies beyond the midline is as on this side
        after, before = p + step, p - step
        columns.append(evaluate(np.abs(after) * FOLD + after * KEEP) - evaluate(np.abs(before) * FOLD + before * KEEP))
    g = np.stack(columns, axis=1)
    return np.asarray(g / np.maximum(np.linalg.norm(g, axis=1, keepdims=True), 1e-12))


# ------------------------------------------------------------------------------------------------------------ weights

ARM_CHAIN = ("humerus_half", "humerus_swing", "humerus", "radius_half", "radius_swing", "radius", "hand_twist", "hand")
LEG_CHAIN = ("femur_half", "femur_swing", "femur", "tibia_half", "tibia", "foot", "toes")
BONES = ("axial", "clavicle", *ARM_CHAIN, *LEG_CHAIN)
"""Of the left half. "axial" is spread over pelvis, spine, neck and head when the figure is fitted to a skeleton."""


def eased(t: Array) -> Array:
    """0 before 0, 1 after 1, smooth between."""
    s = np.clip(t, 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s))


def ramp(t: Array, middle: float | Array, half: float | Array) -> Array:
    """0 before, 1 after, smooth between."""
    s = np.clip((t - middle) / (2 * half) + 0.5, 0.0, 1.0)
    return np.asarray(s * s * s * (s * (6 * s - 15) + 10))


class Spread:
    """Diffusion along the surface: (M + r² L)⁻¹ M."""

    def __init__(self, vertices: Array, faces: NDArray[np.intp]) -> None:
        from scipy.sparse import coo_array, diags_array

        n = len(vertices)
        corners = [vertices[faces[:, k]] for k in range(3)]
        area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]), axis=1) / 2
        self.mass = np.zeros(n)
        np.add.at(self.mass, faces.ravel(), np.repeat(area / 3, 3))
        stiff = coo_array((n, n)).tocsr()
        for k in range(3):
            one, other = corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]
            # a little more than nothing, so that slivers do not repel
            cotangent = np.maximum(np.einsum("ij,ij->i", one, other) / np.maximum(4 * area, 1e-12), 1e-3)
            pair = (faces[:, (k + 1) % 3], faces[:, (k + 2) % 3])
            stiff = stiff + coo_array((cotangent, pair), shape=(n, n)).tocsr()
        stiff = stiff + stiff.T
        self.laplacian = diags_array(stiff.sum(axis=1)) - stiff

    def __call__(self, field: Array, reach: float) -> Array:
        from scipy.sparse import diags_array
        from scipy.sparse.linalg import splu

        matrix = (diags_array(self.mass) + reach**2 * self.laplacian).tocsc()
        return np.asarray(np.clip(splu(matrix).solve(self.mass * field), 0.0, 1.0))


def weights(vertices: Array, faces: NDArray[np.intp]) -> Array:
    """Shares of the bones and helpers, shape (n, len(BONES)).

    Along a limb one hands over to the next: how far a place is past the shoulder or the hip depends on which shape it belongs
    to, diffused along the surface; past elbow and knee, on how far along the limb it lies.
    """
    p, spread = vertices, Spread(vertices, faces)
    height = p[:, 1]
    u, across, _ = along_arm(p).T
    body = smooth_union(trunk(p), neck(p), head(p), k=0.02)
    beside_arm = (u > 0.16) & (across > -0.16)
    # on top all of the deltoid follows the arm, so that a raised one leaves no cleft above the collar
    above = np.clip(across / 0.045, 0.0, 1.0)
    # the shoulder: what is nearer to the arm's shape than to the trunk's, and beyond the joint
    of_arm = (
        ramp(body - np.minimum(arm(p), hand(p)), 0.002, 0.030)
        * ramp(u + 0.25 * np.maximum(-across, 0.0), 0.022 - 0.036 * above, 0.060 - 0.008 * above)
        * (height > 1.1)
    )
    shoulder = spread(np.where(beside_arm, 1.0, of_arm), 0.030)
    elbow = spread(ramp(u, 0.318, 0.055) * beside_arm, 0.008)
    # the hip: the crease of the groin in front, broad behind, where the seat is drawn out
    beyond_hip = p[:, 0] - HIP[0]
    line = 0.895 + np.where(beyond_hip > 0.0, 0.6, 0.3) * beyond_hip + 0.35 * p[:, 2]
    half = 0.055 + 0.30 * np.maximum(-p[:, 2], 0.0) * np.clip(p[:, 0] / 0.08, 0.0, 1.0)
    of_leg = np.where(beside_arm, 0.0, ramp(line - height, 0.0, half))
    # between the legs the flesh is the trunk's
    beside = np.maximum(eased(p[:, 0] / 0.045), ramp(0.790 - height, 0.0, 0.025))
    hip = spread(of_leg * beside, 0.022)
    along = np.where(beside_arm, -1.0, (p - HIP) @ LEG)
    knee = spread(ramp(along, 0.427, 0.055 + 0.35 * np.maximum(p[:, 2], 0.0)), 0.010)
    below = ramp(along - 0.20 * (p[:, 2] + 0.02), 0.822, 0.034)
    toe = ramp(p[:, 2], POINTS["ball"][2] - 0.006, 0.028) * below

    def halfway(far: Array, share: float | Array) -> tuple[Array, Array]:
        """From how far a place is past a joint: what lies beyond the parent, and beyond the half; as much of it as is said."""
        straight = eased(far)
        return share * eased(2 * far) + (1 - share) * straight, share * eased(2 * far - 1) + (1 - share) * straight

    def passed(*steps: Array) -> list[Array]:
        """How much of a place lies beyond each step: never more than beyond the one before."""
        return [np.minimum.reduce(steps[: k + 1]) for k in range(len(steps))]

    # an armpit is hollow: there the joint and its parent meet with less of the half between them, which would bulge
    between = 0.55 - 0.25 * np.clip(-across / 0.05, 0.0, 1.0)
    limbs = (
        passed(
            *halfway(shoulder, between),
            ramp(u, 0.19, 0.13),
            *halfway(elbow, 1.0),
            ramp(u, 0.43, 0.08),
            ramp(u, 0.505, 0.055),
            ramp(u, 0.566, 0.034),
        ),
        passed(
            *halfway(hip, 0.5 + 0.5 * np.clip(-p[:, 2] / 0.06, 0.0, 1.0)),
            ramp(along, 0.24, 0.15),
            *halfway(knee, 1.0),
            spread(below, 0.008),
            spread(toe, 0.008),
        ),
    )
    out = np.zeros((len(p), len(BONES)))
    column = 2
    for beyond in limbs:
        for here, after in zip(beyond, [*beyond[1:], np.zeros(len(p))], strict=True):
            out[:, column] = here - after
            column += 1
    rest = np.clip(1.0 - limbs[0][0] - limbs[1][0], 0.0, 1.0)
    collar = spread(ramp(p[:, 0], 0.085, 0.06) * ramp(height - 0.25 * (p[:, 0] - 0.1), 1.385, 0.05), 0.020)
    out[:, 1], out[:, 0] = rest * collar, rest * (1 - collar)
    out[out < 0.004] = 0.0
    return np.asarray(out / out.sum(axis=1, keepdims=True))


def main() -> None:
    """Make it and write it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--grid", type=float, default=0.004)
    parser.add_argument("--triangles", type=int, default=24000)
    parser.add_argument("--out", type=Path, default=TARGET)
    options = parser.parse_args()
    vertices, faces = polygons(options.grid)
    print("polygons", len(vertices), len(faces))
    vertices, faces = thinned(vertices, faces, options.triangles // 2)
    vertices = relaxed(vertices, faces, 6)
    rim = rim_of(faces, len(vertices))
    print("thinned", len(vertices), len(faces), "rim", rim.sum(), np.abs(vertices[rim, 0]).max())
    share = weights(vertices, faces)
    # outward: the normal of a triangle looks where the field grows
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    if np.mean(np.einsum("ij,ij->i", np.cross(b - a, c - a), gradient((a + b + c) / 3)) > 0) < 0.5:
        faces = faces[:, ::-1]
    order = np.argsort(~rim, kind="stable")
    back = np.empty_like(order)
    back[order] = np.arange(len(order))
    np.savez_compressed(
        options.out,
        vertices=vertices[order].astype(np.float32),
        faces=back[faces].astype(np.uint16),
        rim=np.array(int(rim.sum())),
        weights=np.round(share[order] * 255).astype(np.uint8),
        bones=np.array(BONES),
        points=np.array([POINTS[k] for k in POINTS]),
        point_names=np.array(list(POINTS)),
    )
    print(options.out.name, options.out.stat().st_size)


if __name__ == "__main__":
    main()
