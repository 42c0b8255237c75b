"""The shape of the human figure, as a signed distance: a neutral mannequin of 1.75 m, facing +z, arms 45° below the horizontal.

Lofts and round cones say where the masses are, smooth unions join them. Lengths are those of Drillis & Contini (1966), as
printed in Winter, *Biomechanics and Motor Control of Human Movement* (4th ed. 2009), fig. 4.1; breadths and depths are near
those of the middle of men and women in NASA-STD-3000, fig. 3.3.1.3-1, rounded by eye; muscles are where they are.

Only the left half, x ≥ 0, is described: the figure is its own mirror image.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FOLD, KEEP = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 1.0])

ARM = np.array([np.cos(np.pi / 4), -np.sin(np.pi / 4), 0.0])
ACROSS_ARM = np.array([np.sin(np.pi / 4), np.cos(np.pi / 4), 0.0])
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
"""Landmarks of the left half."""

Place = tuple[float, float, float]
Knots = list[tuple[float, float, float, float]]

# ---------------------------------------------------------------------------------------------------------- primitives


def smooth_union(*fields: Array, k: float) -> Array:
    """Polynomial smooth minimum, one after the other."""
    out = fields[0]
    for other in fields[1:]:
        h = np.clip(0.5 + 0.5 * (other - out) / k, 0.0, 1.0)
        out = other + (out - other) * h - k * h * (1.0 - h)
    return out


def carved(field: Array, tool: Array, k: float) -> Array:
    """A shape less another, with rounded edges."""
    return -smooth_union(-field, tool, k=k)


def curve(t: Array, knots: Knots, column: int) -> Array:
    """A smooth curve through knots (t, value, value …)."""
    from scipy.interpolate import PchipInterpolator

    table = np.array(knots)
    return np.asarray(PchipInterpolator(table[:, 0], table[:, column])(np.clip(t, table[0, 0], table[-1, 0])))


def loft(u: Array, v: Array, w: Array, knots: Knots, power: float = 2.0) -> Array:
    """A tube along u whose section is an ellipse with its own front and back: knots (u, half v, front w, back w)."""
    a, front, back = (curve(u, knots, c) for c in (1, 2, 3))
    middle, b = (front + back) / 2, (front - back) / 2
    rho = (np.abs(v / a) ** power + np.abs((w - middle) / b) ** power) ** (1 / power)
    side = (rho - 1.0) * np.minimum(a, b)
    low, high = knots[0][0], knots[-1][0]
    beyond = np.maximum(np.maximum(low - u, u - high), 0.0)
    return np.where(beyond > 0, np.hypot(np.maximum(side, 0.0), beyond) + np.minimum(side, 0.0) * (beyond == 0), side)


def cone(p: Array, a: Place | Array, b: Place | Array, ra: float, rb: float) -> Array:
    """A capsule from a to b with two radii."""
    start = np.asarray(a, dtype=np.float64)
    ab = np.asarray(b, dtype=np.float64) - start
    t = np.clip((p - start) @ ab / (ab @ ab), 0.0, 1.0)
    return np.asarray(np.linalg.norm(p - start - t[:, None] * ab, axis=1) - (ra + (rb - ra) * t))


def ellipsoid(p: Array, centre: Place | Array, radii: Place, axes: Array | None = None) -> Array:
    """An ellipsoid along the axes, or along the rows of a rotation matrix."""
    q = p - np.asarray(centre)
    if axes is not None:
        q = q @ axes.T
    k0 = np.linalg.norm(q / np.array(radii), axis=1)
    k1 = np.linalg.norm(q / np.array(radii) ** 2, axis=1)
    return np.asarray(k0 * (k0 - 1.0) / np.maximum(k1, 1e-9))


def leaning(a: Place, b: Place, front: Place = (0.0, 0.0, 1.0)) -> Array:
    """Axes of something that lies from a to b: along it, across, and near to `front`."""
    along = np.array(b) - np.array(a)
    along /= np.linalg.norm(along)
    across = np.cross(np.array(front), along)
    across /= np.linalg.norm(across)
    return np.stack([along, across, np.cross(along, across)])


def muscle(p: Array, a: Place, b: Place, half: float, deep: float, front: Place = (0.0, 0.0, 1.0)) -> Array:
    """A spindle from a to b, of half a breadth and half a depth; its flat side looks to `front`."""
    centre = (np.array(a) + np.array(b)) / 2
    long = float(np.linalg.norm(np.array(b) - np.array(a))) / 2
    return ellipsoid(p, centre, (long, half, deep), leaning(a, b, front))


# ---------------------------------------------------------------------------------------------------------- the trunk

# height; half width, front, back
TRUNK: Knots = [
    (0.826, 0.040, 0.024, -0.040),
    (0.850, 0.078, 0.056, -0.070),
    (0.900, 0.128, 0.084, -0.088),
    (0.950, 0.150, 0.094, -0.092),
    (1.000, 0.151, 0.097, -0.086),
    (1.060, 0.145, 0.095, -0.078),
    (1.110, 0.141, 0.092, -0.078),
    (1.170, 0.142, 0.096, -0.086),
    (1.240, 0.143, 0.105, -0.097),
    (1.300, 0.150, 0.110, -0.106),
    (1.350, 0.147, 0.102, -0.110),
    (1.400, 0.128, 0.080, -0.105),
    (1.440, 0.096, 0.050, -0.092),
    (1.470, 0.064, 0.026, -0.080),
    (1.490, 0.045, 0.014, -0.070),
]
NECK: Knots = [
    (1.400, 0.066, 0.040, -0.066),
    (1.450, 0.058, 0.044, -0.062),
    (1.490, 0.0545, 0.047, -0.059),
    (1.540, 0.0530, 0.049, -0.057),
    (1.600, 0.0530, 0.048, -0.060),
]


def folded(p: Array) -> Array:
    """Points of the right half, too, on the left."""
    return np.abs(p) * FOLD + p * KEEP


def trunk(p: Array) -> Array:
    """Pelvis to shoulders."""
    q = folded(p)
    body = loft(p[:, 1], p[:, 0], p[:, 2], TRUNK, power=2.25)
    # collar bones to the breast: flat above, an edge below, drawn out to the arm
    breast = smooth_union(
        ellipsoid(q, (0.078, 1.338, 0.060), (0.076, 0.056, 0.042)),
        muscle(q, (0.050, 1.372, 0.062), (0.196, 1.388, 0.004), 0.050, 0.024, (0.3, 0.2, 1.0)),
        k=0.030,
    )
    blade = muscle(q, (0.070, 1.270, -0.094), (0.120, 1.425, -0.074), 0.052, 0.026, (0.25, 0.0, -1.0))
    # the back of the armpit, down to the waist
    flank = muscle(q, (0.108, 1.150, -0.052), (0.178, 1.405, -0.052), 0.052, 0.026, (0.6, 0.0, -1.0))
    seat = smooth_union(
        ellipsoid(q, (0.076, 0.890, -0.054), (0.076, 0.088, 0.072)),
        muscle(q, (0.040, 1.000, -0.064), (0.150, 0.900, -0.026), 0.050, 0.040, (0.3, 0.1, -1.0)),
        k=0.04,
    )
    hip = ellipsoid(q, (0.110, 0.905, 0.004), (0.060, 0.130, 0.074))
    for part, k in ((breast, 0.034), (blade, 0.035), (flank, 0.035), (hip, 0.05), (seat, 0.045)):
        body = smooth_union(body, part, k=k)
    # from the neck over the collar to the tip of the shoulder
    slope = smooth_union(
        cone(q, (0.018, 1.525, -0.042), (0.095, 1.452, -0.042), 0.030, 0.033),
        cone(q, (0.095, 1.452, -0.042), (0.172, 1.428, -0.022), 0.033, 0.036),
        k=0.03,
    )
    body = smooth_union(body, slope, k=0.045)
    collar = cone(q, (0.018, 1.434, 0.030), (0.165, 1.452, 0.004), 0.011, 0.012)
    body = smooth_union(body, collar, k=0.026)
    # the furrow of the spine
    furrow = muscle(p, (0.0, 1.000, -0.104), (0.0, 1.410, -0.126), 0.018, 0.016, (0.0, 0.0, 1.0))
    return carved(body, furrow, k=0.030)


def neck(p: Array) -> Array:
    """Between shoulders and skull; it leans forward."""
    z = p[:, 2] - np.interp(p[:, 1], [1.42, 1.60], [-0.024, 0.000])
    column = loft(p[:, 1], p[:, 0], z, NECK)
    strap = cone(folded(p), (0.014, 1.445, 0.018), (0.058, 1.590, -0.018), 0.012, 0.016)
    return smooth_union(column, strap, k=0.022)


# -------------------------------------------------------------------------------------------------------------- head


def head(p: Array) -> Array:
    """Skull, face, ears: enough to see where it looks."""
    q = folded(p)
    skull = ellipsoid(p, (0.0, 1.664, -0.012), (0.0745, 0.088, 0.096))
    face = ellipsoid(p, (0.0, 1.618, 0.030), (0.0585, 0.086, 0.062))
    out = smooth_union(skull, face, k=0.030)
    cheek = ellipsoid(q, (0.043, 1.612, 0.052), (0.022, 0.020, 0.024))
    out = smooth_union(out, cheek, k=0.026)
    jaw = smooth_union(
        cone(q, (0.050, 1.574, 0.004), (0.022, 1.548, 0.060), 0.013, 0.013),
        ellipsoid(p, (0.0, 1.548, 0.070), (0.024, 0.016, 0.018)),
        k=0.026,
    )
    out = smooth_union(out, jaw, k=0.030)
    muzzle = ellipsoid(p, (0.0, 1.578, 0.062), (0.030, 0.028, 0.026))
    out = smooth_union(out, muzzle, k=0.024)
    out = carved(out, ellipsoid(q, (0.034, 1.6355, 0.100), (0.022, 0.011, 0.020)), k=0.014)
    brow = cone(q, (0.010, 1.655, 0.086), (0.046, 1.656, 0.066), 0.0065, 0.006)
    out = smooth_union(out, brow, k=0.018)
    eye = ellipsoid(q, (0.0315, 1.6355, 0.0715), (0.0135, 0.0100, 0.0125))
    out = smooth_union(out, eye, k=0.004)
    nose = smooth_union(
        cone(p, (0.0, 1.646, 0.086), (0.0, 1.606, 0.105), 0.0060, 0.0088),
        ellipsoid(q, (0.0095, 1.600, 0.096), (0.0080, 0.0070, 0.0095)),
        k=0.008,
    )
    out = smooth_union(out, nose, k=0.010)
    upper = cone(q, (0.0, 1.5795, 0.0945), (0.0225, 1.5745, 0.0800), 0.0046, 0.0030)
    lower = cone(q, (0.0, 1.5680, 0.0930), (0.0205, 1.5715, 0.0795), 0.0054, 0.0032)
    out = smooth_union(out, upper, k=0.006)
    out = smooth_union(out, lower, k=0.006)
    tilted = leaning((0.0, 0.0, 0.0), (0.10, 1.0, -0.30), (0.9, 0.0, -0.35))
    ear = ellipsoid(q, (0.0765, 1.624, -0.014), (0.030, 0.0165, 0.0075), tilted)
    ear = carved(ear, ellipsoid(q, (0.0850, 1.628, -0.010), (0.016, 0.008, 0.006), tilted), k=0.005)
    return smooth_union(out, ear, k=0.008)


# -------------------------------------------------------------------------------------------------------------- arms

# along the arm; half breadth across (up), front, back
UPPER_ARM: Knots = [
    (-0.02, 0.040, 0.046, -0.046),
    (0.05, 0.044, 0.048, -0.048),
    (0.10, 0.043, 0.046, -0.046),
    (0.16, 0.041, 0.042, -0.043),
    (0.22, 0.039, 0.039, -0.041),
    (0.28, 0.037, 0.036, -0.039),
    (0.318, 0.037, 0.036, -0.040),
    (0.36, 0.039, 0.039, -0.039),
    (0.41, 0.037, 0.039, -0.037),
    (0.47, 0.0305, 0.034, -0.032),
    (0.53, 0.0235, 0.029, -0.028),
    (0.572, 0.0210, 0.0275, -0.0270),
    (0.60, 0.0200, 0.029, -0.0280),
]


def along_arm(p: Array) -> Array:
    """Along the arm, across it (upward), forward."""
    q = p - SHOULDER
    return np.stack([q @ ARM, q @ ACROSS_ARM, q[:, 2]], axis=1)


def arm(p: Array) -> Array:
    """Shoulder to wrist."""
    q = along_arm(p)
    out = loft(q[:, 0], q[:, 1], q[:, 2], UPPER_ARM)
    deltoid = smooth_union(
        muscle(q, (-0.036, 0.018, 0.000), (0.155, 0.020, 0.000), 0.046, 0.034, (0.0, 1.0, 0.0)),
        muscle(q, (-0.030, 0.012, 0.026), (0.140, 0.016, 0.012), 0.036, 0.032, (0.0, 1.0, 0.5)),
        muscle(q, (-0.030, 0.012, -0.026), (0.140, 0.014, -0.014), 0.036, 0.032, (0.0, 1.0, -0.5)),
        k=0.020,
    )
    out = smooth_union(out, deltoid, k=0.028)
    biceps = muscle(q, (0.060, -0.004, 0.022), (0.300, 0.002, 0.020), 0.029, 0.024)
    triceps = muscle(q, (0.040, -0.012, -0.026), (0.280, -0.004, -0.020), 0.033, 0.024)
    out = smooth_union(out, biceps, triceps, k=0.026)
    outer = muscle(q, (0.265, 0.014, 0.014), (0.470, 0.004, 0.016), 0.023, 0.024)
    inner = muscle(q, (0.300, -0.016, -0.006), (0.490, -0.008, -0.006), 0.024, 0.024)
    out = smooth_union(out, outer, inner, k=0.026)
    elbow = ellipsoid(q, (0.318, 0.000, -0.030), (0.020, 0.018, 0.014))
    return smooth_union(out, elbow, k=0.018)


def hand(p: Array) -> Array:
    """Palm down, fingers a little apart and bent, the thumb forward."""
    q = along_arm(p) - np.array([0.572, 0.0, 0.0])
    palm = loft(
        q[:, 0],
        q[:, 1] + 0.002,
        q[:, 2],
        [
            (0.000, 0.0195, 0.027, -0.026),
            (0.025, 0.0165, 0.034, -0.031),
            (0.055, 0.0145, 0.041, -0.038),
            (0.085, 0.0120, 0.043, -0.041),
            (0.098, 0.0090, 0.039, -0.039),
        ],
        power=2.5,
    )
    heel = ellipsoid(q, (0.034, -0.010, -0.024), (0.034, 0.012, 0.015))
    ball = muscle(q, (0.008, -0.010, 0.016), (0.066, -0.012, 0.040), 0.018, 0.014, (0.0, 1.0, 0.0))
    palm = smooth_union(palm, heel, ball, k=0.014)
    fields = []
    for z, start, first, rest, radius, spread in (
        (0.0335, 0.086, 0.040, 0.038, 0.0088, 0.07),
        (0.0110, 0.090, 0.044, 0.042, 0.0090, 0.022),
        (-0.0110, 0.088, 0.041, 0.039, 0.0086, -0.025),
        (-0.0325, 0.080, 0.033, 0.030, 0.0078, -0.085),
    ):
        a = np.array([start - 0.02, -0.001, z])
        b = a + (first + 0.02) * np.array([np.cos(0.16), -np.sin(0.16), spread])
        middle = b + 0.55 * rest * np.array([np.cos(0.42), -np.sin(0.42), spread * 0.5])
        tip = middle + 0.45 * rest * np.array([np.cos(0.62), -np.sin(0.62), spread * 0.3])
        fields.append(
            smooth_union(
                cone(q, a, b, radius * 1.10, radius),
                cone(q, b, middle, radius * 1.02, radius * 0.90),
                cone(q, middle, tip, radius * 0.92, radius * 0.78),
                k=0.003,
            )
        )
    fingers = np.minimum.reduce(fields)
    thumb = smooth_union(
        cone(q, (0.018, -0.006, 0.026), (0.052, -0.013, 0.050), 0.0140, 0.0112),
        cone(q, (0.052, -0.013, 0.050), (0.078, -0.017, 0.063), 0.0108, 0.0100),
        cone(q, (0.078, -0.017, 0.063), (0.099, -0.020, 0.069), 0.0102, 0.0080),
        k=0.006,
    )
    return smooth_union(smooth_union(palm, fingers, k=0.007), thumb, k=0.012)


# -------------------------------------------------------------------------------------------------------------- legs

# along the limb; half breadth, front, back
UPPER_LEG: Knots = [
    (-0.13, 0.030, 0.040, -0.040),
    (-0.06, 0.058, 0.064, -0.070),
    (0.00, 0.078, 0.080, -0.088),
    (0.06, 0.083, 0.084, -0.088),
    (0.14, 0.077, 0.081, -0.079),
    (0.24, 0.065, 0.070, -0.065),
    (0.34, 0.054, 0.057, -0.054),
    (0.40, 0.0505, 0.052, -0.052),
    (0.430, 0.050, 0.051, -0.052),
    (0.470, 0.047, 0.046, -0.053),
    (0.530, 0.046, 0.042, -0.058),
    (0.580, 0.045, 0.039, -0.058),
    (0.660, 0.040, 0.036, -0.050),
    (0.740, 0.033, 0.034, -0.041),
    (0.800, 0.030, 0.034, -0.038),
    (0.850, 0.033, 0.038, -0.042),
]


def leg(p: Array) -> Array:
    """Hip to ankle."""
    q = p - HIP
    along = q @ LEG
    rest = q - along[:, None] * LEG
    # x outward, y along, z forward
    f = np.stack([rest[:, 0], along, rest[:, 2]], axis=1)
    out = loft(along, f[:, 0], f[:, 2], UPPER_LEG)
    parts = (
        (muscle(f, (0.034, -0.020, 0.014), (0.034, 0.390, 0.012), 0.046, 0.042, (1.0, 0.0, 0.7)), 0.034),
        (muscle(f, (0.010, 0.040, 0.044), (0.006, 0.385, 0.032), 0.040, 0.034), 0.030),
        (muscle(f, (-0.026, 0.230, 0.024), (-0.030, 0.425, 0.020), 0.028, 0.026, (-1.0, 0.0, 0.7)), 0.024),
        (muscle(f, (-0.040, 0.020, -0.004), (-0.026, 0.300, -0.010), 0.050, 0.044, (-1.0, 0.0, 0.0)), 0.035),
        (muscle(f, (0.022, 0.050, -0.040), (0.028, 0.420, -0.028), 0.034, 0.032, (0.3, 0.0, -1.0)), 0.026),
        (muscle(f, (-0.022, 0.050, -0.042), (-0.024, 0.425, -0.030), 0.032, 0.030, (-0.3, 0.0, -1.0)), 0.026),
        (ellipsoid(f, (0.000, 0.424, 0.040), (0.026, 0.032, 0.020)), 0.016),
        (ellipsoid(f, (0.000, 0.478, 0.036), (0.018, 0.024, 0.013)), 0.018),
        (muscle(f, (-0.020, 0.435, -0.032), (-0.016, 0.690, -0.032), 0.034, 0.036, (-0.4, 0.0, -1.0)), 0.026),
        (muscle(f, (0.020, 0.435, -0.030), (0.014, 0.670, -0.030), 0.032, 0.034, (0.4, 0.0, -1.0)), 0.026),
        (muscle(f, (0.024, 0.460, 0.010), (0.014, 0.720, 0.008), 0.024, 0.028, (0.8, 0.0, 0.5)), 0.026),
    )
    for part, k in parts:
        out = smooth_union(out, part, k=k)
    return out


def foot(p: Array) -> Array:
    """Bare, on y = 0: heel, arch, instep, five toes."""
    ankle = POINTS["ankle"]
    q = p - np.array([ankle[0], 0.0, ankle[2]])
    q[:, 0] -= 0.055 * q[:, 2]
    body = loft(
        q[:, 2],
        q[:, 0],
        q[:, 1],
        [
            (-0.066, 0.012, 0.034, 0.010),
            (-0.058, 0.024, 0.056, 0.000),
            (-0.035, 0.032, 0.080, -0.004),
            (0.000, 0.033, 0.096, -0.003),
            (0.045, 0.035, 0.078, 0.000),
            (0.085, 0.0415, 0.055, -0.002),
            (0.125, 0.0455, 0.036, -0.004),
            (0.150, 0.044, 0.026, -0.002),
            (0.160, 0.040, 0.021, 0.002),
        ],
        power=2.5,
    )
    # the arch lies at the inner side
    body = carved(body, ellipsoid(q, (-0.046, -0.004, 0.046), (0.026, 0.020, 0.050)), k=0.014)
    toes = []
    for x, start, tip, radius in (
        (-0.0285, 0.130, 0.1900, 0.0140),
        (-0.0070, 0.138, 0.1890, 0.0098),
        (0.0115, 0.136, 0.1800, 0.0092),
        (0.0270, 0.130, 0.1690, 0.0088),
        (0.0400, 0.120, 0.1560, 0.0084),
    ):
        bent = np.array([x, radius + 0.007, (start + 2 * tip) / 3])
        toes.append(
            smooth_union(
                cone(q, (x, radius + 0.008, start), bent, radius, radius * 0.95),
                cone(q, bent, (x, radius * 0.85, tip), radius * 0.95, radius * 0.88),
                k=0.004,
            )
        )
    body = smooth_union(body, np.minimum.reduce(toes), k=0.008)
    q = p - ankle
    shaft = cone(q, (0.0, 0.06, -0.006), (0.0, -0.025, -0.008), 0.032, 0.034)
    body = smooth_union(body, shaft, k=0.03)
    for x, y, z in ((-0.034, 0.006, 0.004), (0.033, -0.006, -0.008)):
        body = smooth_union(body, ellipsoid(q, (x, y, z), (0.009, 0.014, 0.011)), k=0.012)
    tendon = cone(q, (0.0, 0.09, -0.038), (0.0, -0.030, -0.050), 0.008, 0.010)
    body = smooth_union(body, tendon, k=0.020)
    # nothing goes below the floor
    return -smooth_union(-body, p[:, 1], k=0.006)


# ------------------------------------------------------------------------------------------------------------ together


def surface(p: Array) -> Array:
    """Signed distance, nearly, of the whole figure; points (n, 3) with x ≥ 0."""
    mirrored = p * [-1.0, 1.0, 1.0]
    legs = smooth_union(leg(p), leg(mirrored), k=0.012)
    out = smooth_union(trunk(p), legs, k=0.055)
    out = smooth_union(out, neck(p), k=0.035)
    out = smooth_union(out, head(p), k=0.018)
    out = smooth_union(out, arm(p), k=0.035)
    out = smooth_union(out, hand(p), k=0.012)
    return smooth_union(out, foot(p), k=0.020)
