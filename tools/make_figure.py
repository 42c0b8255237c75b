"""Make the template of the human figure: src/kinesics/body/figure.npz.

A neutral mannequin of 1.75 m, facing +z, its arms 45° below the horizontal, modelled as a smooth union of lofts and round
cones and polygonised as one closed surface. Lengths are those of Drillis & Contini (1966), as printed in Winter,
*Biomechanics and Motor Control of Human Movement* (4th ed. 2009), fig. 4.1; breadths and depths are near those of the
middle of men and women in NASA-STD-3000, fig. 3.3.1.3-1, rounded by eye.

Run by hand, only when the figure is to change; it needs what the package does not:

    python -m pip install scikit-image fast-simplification scipy numpy
    python tools/make_figure.py [--grid 0.004] [--triangles 24000]

Only the left half is made and kept. The right half is its mirror image to the last bit.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FOLD, KEEP = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 1.0])
TARGET = Path(__file__).resolve().parents[1] / "src" / "kinesics" / "body" / "figure.npz"

# ------------------------------------------------------------------------------------------------------- the skeleton

ARM = np.array([np.cos(np.pi / 4), -np.sin(np.pi / 4), 0.0])
SHOULDER = np.array([0.172, 1.425, -0.012])
HIP = np.array([0.091, 0.925, 0.0])
LEG = np.array([0.012, -1.0, -0.008]) / np.linalg.norm([0.012, -1.0, -0.008])
POINTS = {
    "hips": np.array([0.0, 0.925, 0.0]),
    "shoulders": np.array([0.0, 1.425, -0.012]),
    "skull": np.array([0.0, 1.585, 0.004]),
    "crown": np.array([0.0, 1.752, 0.004]),
    "shoulder": SHOULDER,
    "elbow": SHOULDER + 0.318 * ARM,
    "wrist": SHOULDER + 0.572 * ARM,
    "fingers": SHOULDER + 0.755 * ARM,
    "hip": HIP,
    "knee": HIP + 0.427 * LEG,
    "ankle": HIP + 0.846 * LEG,
    "ball": HIP + 0.846 * LEG + np.array([0.006, -0.056, 0.128]),
    "toes": HIP + 0.846 * LEG + np.array([0.006, -0.062, 0.196]),
}

# ------------------------------------------------------------------------------------------------------------ shapes


def smooth_union(*fields: Array, k: float) -> Array:
    """Polynomial smooth minimum, one after the other."""
    out = fields[0]
    for other in fields[1:]:
        h = np.clip(0.5 + 0.5 * (other - out) / k, 0.0, 1.0)
        out = other + (out - other) * h - k * h * (1.0 - h)
    return out


def curve(t: Array, knots: list[tuple[float, ...]], column: int) -> Array:
    """A smooth curve through knots (t, value, value …)."""
    from scipy.interpolate import PchipInterpolator

    table = np.array(knots)
    return np.asarray(PchipInterpolator(table[:, 0], table[:, column])(np.clip(t, table[0, 0], table[-1, 0])))


def loft(u: Array, v: Array, w: Array, knots: list[tuple[float, ...]], power: float = 2.0) -> Array:
    """A tube along u whose section is an ellipse with its own front and back: knots (u, half v, front w, back w)."""
    a, front, back = (curve(u, knots, c) for c in (1, 2, 3))
    middle, b = (front + back) / 2, (front - back) / 2
    rho = (np.abs(v / a) ** power + np.abs((w - middle) / b) ** power) ** (1 / power)
    side = (rho - 1.0) * np.minimum(a, b)
    low, high = knots[0][0], knots[-1][0]
    beyond = np.maximum(np.maximum(low - u, u - high), 0.0)
    return np.where(beyond > 0, np.hypot(np.maximum(side, 0.0), beyond) + np.minimum(side, 0.0) * (beyond == 0), side)


def cone(p: Array, a: Array, b: Array, ra: float, rb: float) -> Array:
    """A capsule from a to b with two radii."""
    ab = b - a
    t = np.clip((p - a) @ ab / (ab @ ab), 0.0, 1.0)
    return np.asarray(np.linalg.norm(p - a - t[:, None] * ab, axis=1) - (ra + (rb - ra) * t))


def ellipsoid(p: Array, centre: tuple[float, float, float], radii: tuple[float, float, float]) -> Array:
    """An ellipsoid along the axes."""
    q = p - np.array(centre)
    k0 = np.linalg.norm(q / np.array(radii), axis=1)
    k1 = np.linalg.norm(q / np.array(radii) ** 2, axis=1)
    return np.asarray(k0 * (k0 - 1.0) / np.maximum(k1, 1e-9))


# height; half width, front, back
TRUNK = [
    (0.825, 0.100, 0.050, -0.060),
    (0.850, 0.140, 0.080, -0.094),
    (0.900, 0.168, 0.094, -0.112),
    (0.950, 0.168, 0.099, -0.110),
    (1.000, 0.157, 0.100, -0.097),
    (1.060, 0.140, 0.097, -0.084),
    (1.110, 0.134, 0.095, -0.082),
    (1.170, 0.139, 0.100, -0.090),
    (1.240, 0.150, 0.109, -0.102),
    (1.300, 0.160, 0.116, -0.112),
    (1.350, 0.162, 0.112, -0.117),
    (1.400, 0.148, 0.094, -0.115),
    (1.440, 0.112, 0.066, -0.104),
    (1.470, 0.076, 0.046, -0.088),
    (1.500, 0.060, 0.045, -0.076),
]
NECK = [
    (1.420, 0.070, 0.050, -0.080),
    (1.470, 0.058, 0.046, -0.070),
    (1.510, 0.052, 0.046, -0.062),
    (1.560, 0.050, 0.046, -0.060),
    (1.600, 0.050, 0.044, -0.062),
]
# along the limb; half breadth, front, back
UPPER_LEG = [
    (-0.13, 0.030, 0.040, -0.040),
    (-0.06, 0.062, 0.068, -0.076),
    (0.00, 0.077, 0.083, -0.092),
    (0.06, 0.079, 0.087, -0.091),
    (0.14, 0.076, 0.087, -0.080),
    (0.24, 0.067, 0.078, -0.069),
    (0.34, 0.058, 0.066, -0.058),
    (0.40, 0.053, 0.059, -0.053),
    (0.430, 0.052, 0.058, -0.052),
    (0.470, 0.050, 0.050, -0.055),
    (0.530, 0.053, 0.045, -0.068),
    (0.580, 0.053, 0.042, -0.070),
    (0.660, 0.046, 0.038, -0.058),
    (0.740, 0.036, 0.035, -0.042),
    (0.800, 0.032, 0.035, -0.037),
    (0.850, 0.034, 0.038, -0.040),
]
# along the arm; half breadth across (up), front, back
UPPER_ARM = [
    (-0.02, 0.044, 0.050, -0.050),
    (0.05, 0.047, 0.052, -0.051),
    (0.10, 0.046, 0.051, -0.049),
    (0.16, 0.045, 0.048, -0.047),
    (0.22, 0.042, 0.043, -0.044),
    (0.28, 0.039, 0.039, -0.041),
    (0.318, 0.037, 0.039, -0.041),
    (0.36, 0.038, 0.042, -0.041),
    (0.41, 0.037, 0.041, -0.039),
    (0.47, 0.031, 0.036, -0.034),
    (0.53, 0.024, 0.031, -0.030),
    (0.572, 0.0215, 0.029, -0.028),
    (0.60, 0.020, 0.031, -0.029),
]


def along_arm(p: Array) -> Array:
    """Along the arm, across it (upward), forward."""
    across = np.array([-ARM[1], ARM[0], 0.0])
    q = p - SHOULDER
    return np.stack([q @ ARM, q @ across, q[:, 2]], axis=1)


def hand(p: Array) -> Array:
    """Palm down, fingers a little apart and bent, the thumb forward."""
    q = along_arm(p) - np.array([0.572, 0.0, 0.0])
    palm = loft(
        q[:, 0],
        q[:, 1] + 0.002,
        q[:, 2],
        [
            (0.000, 0.0200, 0.028, -0.027),
            (0.025, 0.0170, 0.037, -0.032),
            (0.055, 0.0155, 0.043, -0.039),
            (0.085, 0.0135, 0.044, -0.042),
            (0.098, 0.0105, 0.040, -0.040),
        ],
        power=2.6,
    )
    fields = []
    for z, start, first, rest, radius, spread in (
        (0.0335, 0.086, 0.040, 0.038, 0.0088, 0.07),
        (0.0110, 0.090, 0.044, 0.042, 0.0090, 0.022),
        (-0.0110, 0.088, 0.041, 0.039, 0.0086, -0.025),
        (-0.0325, 0.080, 0.033, 0.030, 0.0078, -0.085),
    ):
        a = np.array([start - 0.02, -0.001, z])
        b = a + (first + 0.02) * np.array([np.cos(0.12), -np.sin(0.12), spread])
        c = b + rest * np.array([np.cos(0.32), -np.sin(0.32), spread * 0.5])
        fields.append(smooth_union(cone(q, a, b, radius * 1.08, radius), cone(q, b, c, radius, radius * 0.82), k=0.004))
    fingers = np.minimum.reduce(fields)
    knuckle = np.array([0.052, -0.010, 0.052])
    thumb = smooth_union(
        cone(q, np.array([0.018, -0.004, 0.026]), knuckle, 0.0150, 0.0115),
        cone(q, knuckle, np.array([0.095, -0.016, 0.071]), 0.0112, 0.0090),
        k=0.008,
    )
    return smooth_union(smooth_union(palm, fingers, k=0.007), thumb, k=0.014)


def head(p: Array) -> Array:
    """Skull, face, jaw and a nose: enough to see where it looks."""
    skull = ellipsoid(p, (0.0, 1.662, -0.012), (0.076, 0.092, 0.098))
    face = ellipsoid(p, (0.0, 1.612, 0.030), (0.060, 0.084, 0.066))
    jaw = ellipsoid(p, (0.0, 1.553, 0.058), (0.040, 0.030, 0.040))
    nose = cone(p, np.array([0.0, 1.650, 0.090]), np.array([0.0, 1.606, 0.108]), 0.009, 0.0135)
    brow = cone(
        np.abs(p) * FOLD + p * KEEP,
        np.array([0.0, 1.655, 0.086]),
        np.array([0.038, 1.655, 0.070]),
        0.011,
        0.009,
    )
    ear = ellipsoid(np.abs(p) * FOLD + p * KEEP, (0.074, 1.622, -0.014), (0.012, 0.030, 0.018))
    out = smooth_union(skull, face, k=0.030)
    out = smooth_union(out, jaw, k=0.030)
    out = smooth_union(out, brow, k=0.022)
    out = smooth_union(out, nose, k=0.014)
    return smooth_union(out, ear, k=0.010)


def foot(p: Array) -> Array:
    """A plain shod foot, flat below."""
    ankle = POINTS["ankle"]
    q = p - np.array([ankle[0], 0.0, ankle[2]])
    outward = 0.055 * q[:, 2]
    sole = loft(
        q[:, 2],
        q[:, 0] - outward,
        q[:, 1],
        [
            (-0.064, 0.012, 0.030, 0.010),
            (-0.056, 0.025, 0.052, 0.002),
            (-0.035, 0.033, 0.080, 0.000),
            (0.000, 0.035, 0.096, 0.001),
            (0.045, 0.037, 0.084, 0.003),
            (0.090, 0.044, 0.060, 0.001),
            (0.130, 0.048, 0.044, 0.000),
            (0.165, 0.046, 0.035, 0.001),
            (0.190, 0.037, 0.028, 0.004),
            (0.202, 0.020, 0.022, 0.009),
        ],
        power=2.8,
    )
    ankle_bone = cone(p, ankle + np.array([0, 0.06, -0.004]), ankle + np.array([0, -0.025, -0.006]), 0.034, 0.036)
    return smooth_union(sole, ankle_bone, k=0.03)


def trunk(p: Array) -> Array:
    """Pelvis to shoulders."""
    body = loft(p[:, 1], p[:, 0], p[:, 2], TRUNK, power=2.3)
    # a little relief: breast, shoulder blades, buttocks
    x = np.abs(p[:, 0])
    folded = np.stack([x, p[:, 1], p[:, 2]], axis=1)
    breast = ellipsoid(folded, (0.074, 1.318, 0.062), (0.084, 0.062, 0.046))
    blade = ellipsoid(folded, (0.085, 1.335, -0.080), (0.070, 0.085, 0.036))
    seat = ellipsoid(folded, (0.076, 0.885, -0.062), (0.080, 0.085, 0.070))
    for part in (breast, blade, seat):
        body = smooth_union(body, part, k=0.04)
    slope = cone(folded, np.array([0.02, 1.474, -0.034]), SHOULDER + np.array([0.004, 0.002, -0.004]), 0.060, 0.052)
    return smooth_union(body, slope, k=0.045)


def arm(p: Array) -> Array:
    """Shoulder to wrist."""
    q = along_arm(p)
    tube = loft(q[:, 0], q[:, 1], q[:, 2], UPPER_ARM)
    deltoid = ellipsoid(p, tuple(SHOULDER + 0.045 * ARM + [-0.002, -0.004, 0.0]), (0.050, 0.058, 0.057))
    return smooth_union(tube, deltoid, k=0.03)


def leg(p: Array) -> Array:
    """Hip to ankle."""
    q = p - HIP
    along = q @ LEG
    rest = q - along[:, None] * LEG
    return loft(along, rest[:, 0], rest[:, 2], UPPER_LEG)


def neck(p: Array) -> Array:
    """Between shoulders and skull; it leans forward."""
    z = p[:, 2] - np.interp(p[:, 1], [1.42, 1.60], [-0.010, 0.006])
    return loft(p[:, 1], p[:, 0], z, NECK)


def surface(p: Array) -> Array:
    """Signed distance, nearly, of the whole figure; points (n, 3) with x ≥ 0."""
    mirrored = p * [-1.0, 1.0, 1.0]
    legs = smooth_union(leg(p), leg(mirrored), k=0.012)
    out = smooth_union(trunk(p), legs, k=0.05)
    out = smooth_union(out, neck(p), k=0.045)
    out = smooth_union(out, head(p), k=0.022)
    out = smooth_union(out, arm(p), k=0.05)
    out = smooth_union(out, hand(p), k=0.012)
    return smooth_union(out, foot(p), k=0.03)


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


def thinned(vertices: Array, faces: NDArray[np.intp], triangles: int) -> tuple[Array, NDArray[np.intp]]:
    """Fewer triangles, more of them where the surface bends."""
    import fast_simplification

    points, cells = fast_simplification.simplify(
        vertices.astype(np.float64), faces.astype(np.int32), target_count=triangles, agg=5.0
    )
    return np.asarray(points, dtype=np.float64), np.asarray(cells, dtype=np.intp)


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

BONES = ("axial", "clavicle", "humerus", "radius", "hand", "femur", "tibia", "foot", "toes")
"""Of the left half. "axial" is spread over pelvis, spine, neck and head when the figure is fitted to a skeleton."""


def ramp(t: Array, middle: float, half: float) -> Array:
    """0 before, 1 after, smooth between."""
    s = np.clip((t - middle) / (2 * half) + 0.5, 0.0, 1.0)
    return np.asarray(s * s * s * (s * (6 * s - 15) + 10))


def weights(vertices: Array, faces: NDArray[np.intp]) -> Array:
    """Shares of the bones, shape (n, len(BONES)): which part of the shape a vertex belongs to, diffused along the surface."""
    from scipy.sparse import coo_array, diags_array
    from scipy.sparse.linalg import splu

    p = vertices
    body = smooth_union(trunk(p), neck(p), head(p), k=0.02)
    height = p[:, 1]
    u, across, _ = along_arm(p).T
    beside_arm = (u > 0.16) & (across > -0.16)
    # the shoulder: what is nearer to the arm's shape than to the trunk's, and beyond the joint
    of_arm = (
        ramp(body - np.minimum(arm(p), hand(p)), 0.004, 0.035)
        * ramp(u + 0.25 * np.maximum(-across, 0.0), 0.030, 0.060)
        * (height > 1.1)
    )
    of_arm = np.where(beside_arm, 1.0, of_arm)
    # the groin: what lies below the hip joint goes with the leg, more of it at the outside and in front
    line = HIP[1] - 0.045 + 0.55 * (p[:, 0] - HIP[0]) + 0.25 * p[:, 2]
    of_leg = np.where(beside_arm, 0.0, ramp(line - height, 0.0, 0.055))
    out = np.zeros((len(p), len(BONES)))
    forearm = ramp(u, 0.318, 0.040)
    palm = ramp(u, 0.555, 0.045)
    out[:, 2], out[:, 3], out[:, 4] = of_arm * (1 - forearm), of_arm * forearm * (1 - palm), of_arm * palm
    along = (p - HIP) @ LEG
    shank = ramp(along, 0.427, 0.045)
    below = ramp(along - 0.20 * (p[:, 2] + 0.02), 0.822, 0.030)
    toe = ramp(p[:, 2], POINTS["ball"][2] - 0.006, 0.028) * below
    out[:, 5], out[:, 6] = of_leg * (1 - shank), of_leg * shank * (1 - below)
    out[:, 7], out[:, 8] = of_leg * below * (1 - toe), of_leg * below * toe
    rest = np.clip(1.0 - out.sum(axis=1), 0.0, 1.0)
    collar = ramp(p[:, 0], 0.085, 0.05) * ramp(height - 0.25 * (p[:, 0] - 0.1), 1.385, 0.045)
    out[:, 1], out[:, 0] = rest * collar, rest * (1 - collar)
    # diffusion along the surface: (M + t L)⁻¹ M, cotangents left out for plain edge weights
    n = len(p)
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    length = np.linalg.norm(p[pairs[:, 0]] - p[pairs[:, 1]], axis=1)
    area = np.zeros(n)
    cross = np.linalg.norm(np.cross(p[faces[:, 1]] - p[faces[:, 0]], p[faces[:, 2]] - p[faces[:, 0]]), axis=1)
    np.add.at(area, faces.ravel(), np.repeat(cross / 6, 3))
    strength = np.repeat((cross / 2)[None], 3, axis=0).ravel() / np.maximum(length, 1e-5) ** 2 * 0.5
    stiff = coo_array((strength, (pairs[:, 0], pairs[:, 1])), shape=(n, n)).tocsr()
    stiff = stiff + stiff.T
    laplacian = diags_array(stiff.sum(axis=1)) - stiff
    solve = splu((diags_array(area) + 0.013**2 * laplacian).tocsc())
    out = np.maximum(solve.solve(area[:, None] * out), 0.0)
    out[out < 0.01] = 0.0
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
