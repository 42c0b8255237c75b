"""Fit the few numbers by which residuals become probabilities of classes, on synthetic performances only.

Every movement of the performer, under noise, uneven tempo, constant differences of left and right, at three frame rates and
many lengths; and movements between two classes: a cycle of the richer group plus a share α of what breaks it. No body is exactly
symmetric, so what counts as symmetric is a convention, and this is it, in residuals of the undisturbed movement:

- a reversal or a mirror that leaves up to .09 holds, one that leaves .2 or more is broken; between, chance decides, by how
  near it is to either, as people would disagree. Of sides that alternate .05 and .12: legs and arms that swing are half-way to
  their own reversal, and walking is no palindrome (§3.5.4);
- left and right that alternate hold up to about three times what one side leaves from cycle to cycle (plus .02): an unevenness
  within that is the walker's own, beyond it a limp.

The numbers of this convention were set with an eye on what people call these movements, the labelled recordings of
bench_classes.py among them; everything else follows from synthetic performances.

    python benchmarks/fit_classes.py [--count 1500] [--cache FILE]

prints the curves for `kinesics.grammar.classes`.
"""

from __future__ import annotations

import argparse
import pickle
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

import kinesics as kx
from kinesics.grammar import classes, moments
from kinesics.performer import exercises, gaits, postures
from kinesics.performer.cycles import Shape, cyclic_score, symmetrise, tracks
from kinesics.performer.stage import perform_score
from kinesics.vocabulary import MovementClass

C = MovementClass
Array = NDArray[np.float64]
HELD, BROKEN = 0.09, 0.2
ALTERNATING = (0.05, 0.12)
LARGEST = 0.5
RESIDUAL_AT_FULL = {"walk": 0.6, "run": 1.1, "wave": 0.95, "wave_both": 1.0, "jack": 0.45}
"""What the broken symmetry leaves at a share α, over α² (measured on the undisturbed mixtures)."""
UNEVEN_AT_FULL, UNEVEN_PER_DEGREE = 0.15, 0.006
"""The same of a limp; and what the period leaves at a smooth noise of s degrees, over s² (walking)."""
LIMP = (2.6, 4.0)


@dataclass(frozen=True)
class Row:
    """Residuals of one performance and the class it has."""

    label: str
    class_: MovementClass
    cyclic: bool
    residuals: dict[str, float | None]
    turn: float | None


def _between(rich: Shape, poor: Shape, share: float) -> Shape:
    return lambda phase: rich(phase) + share * (poor(phase) - rich(phase))


def _round(curves: Mapping[str, Any], side: str, rng: np.random.Generator) -> dict[str, Any]:
    """The same curves, but the hand goes round an ellipse: the shoulder swings a quarter of a cycle late."""
    up, across = rng.choice([-1.0, 1.0]) * rng.uniform(16, 26), rng.choice([-1.0, 1.0]) * rng.uniform(12, 22)
    out = dict(curves)
    out[f"{side}shoulder_elevate"] = [(0, 17), (25, 17 + up), (50, 17), (75, 17 - up)]
    out[f"{side}shoulder_horizontal"] = [(0, 18), (25, 18 + across), (50, 18), (75, 18 - across)]
    return out


def mixtures(rng: np.random.Generator) -> tuple[str, C, C, Shape, Shape, float]:
    """Name, richer class, poorer class, their cycles, period in seconds."""
    walk = tracks(gaits._STRIDING, gaits._both_sides(gaits._WALK))
    run = tracks(gaits._RUNNING, gaits._both_sides(gaits._RUN))
    limp = tracks(gaits._STRIDING, gaits._limping(gaits._both_sides(gaits._WALK), 1.0))
    wave_curves = {f"right_{k}": v for k, v in exercises._there_and_back(exercises._WAVE_ARM).items()}
    wave_base = postures.posture(postures.STANDING, right_pronate=0)
    both_curves = exercises._there_and_back(exercises._WAVE_ARM)
    both_base = postures.posture(postures.STANDING, pronate=0)
    jack = exercises._there_and_back(exercises._JACK)
    one_sided = {k: [(p, v if "shoulder" not in k else 0.5 * v) for p, v in pts] for k, pts in jack.items()}
    p2mg, p2mm = C.CYCLIC_ANTIPHASE_PALINDROMIC, C.CYCLIC_SYMMETRIC_PALINDROMIC
    paired = ("shoulder", "elbow", "hip", "knee", "ankle")
    left_only = {f"left_{k}" if k.split("_")[0] in paired else k: v for k, v in one_sided.items()}
    kinds: list[Callable[[], tuple[str, C, C, Shape, Shape, float]]] = [
        lambda: ("walk", p2mg, C.CYCLIC_ANTIPHASE, symmetrise(walk, p2mg), symmetrise(walk, C.CYCLIC_ANTIPHASE), 1.1),
        lambda: ("run", p2mg, C.CYCLIC_ANTIPHASE, symmetrise(run, p2mg), symmetrise(run, C.CYCLIC_ANTIPHASE), 0.75),
        lambda: ("limp", C.CYCLIC_ANTIPHASE, C.CYCLIC_ASYMMETRIC, symmetrise(limp, C.CYCLIC_ANTIPHASE), limp, 1.2),
        lambda: (
            "wave",
            C.CYCLIC_PALINDROMIC,
            C.CYCLIC_ASYMMETRIC,
            tracks(wave_base, wave_curves),
            tracks(wave_base, _round(wave_curves, "right_", rng)),
            0.9,
        ),
        lambda: (
            "wave_both",
            p2mm,
            C.CYCLIC_SYMMETRIC,
            tracks(both_base, both_curves),
            tracks(both_base, _round(both_curves, "", rng)),
            1.0,
        ),
        lambda: (
            "jack",
            p2mm,
            C.CYCLIC_PALINDROMIC,
            tracks(postures.STANDING, jack),
            tracks(postures.STANDING, left_only),
            1.05,
        ),
    ]
    return kinds[int(rng.integers(len(kinds)))]()


def conditions(rng: np.random.Generator) -> dict[str, Any]:
    smooth = rng.random() < 0.5
    return {
        "fps": float(rng.choice([30, 60, 120])),
        "seed": int(rng.integers(1 << 30)),
        "tempo_jitter": float(rng.uniform(0, 0.1)),
        "noise_degrees": float(rng.uniform(0, 1) ** 2 * (5.0 if smooth else 2.0)),
        "noise_kind": "smooth" if smooth else "white",
        "asymmetry_degrees": float(rng.uniform(0, 15) if rng.random() < 0.8 else rng.uniform(15, 40)),
        "mirrored": bool(rng.random() < 0.5),
    }


CYCLIC = [
    "walk",
    "limp",
    "run",
    "jog_in_place",
    "jumping_jacks",
    "squat",
    "twist",
    "wave",
    "wave_both",
    "arm_circles",
    "butterfly",
]
SINGLE = ["throw", "raise_arms", "reach", "sway", "bow"]


def performances(count: int, seed: int = 0) -> Iterator[tuple[str, C, bool, kx.Motion]]:
    rng = np.random.default_rng(seed)
    for _ in range(count):
        kind = rng.random()
        under = conditions(rng)
        if kind < 0.3:
            name = SINGLE[int(rng.integers(len(SINGLE)))]
            period = float(rng.uniform(0.8, 3.5))
            p = kx.performer.perform(
                name,
                seconds=period + float(rng.uniform(0.1, 2.0)),
                period=period,
                amplitude=float(rng.uniform(0.6, 1.05)),
                **under,
            )
            yield name, p.truth.class_, False, p.motion
            continue
        periods = float(rng.uniform(1.7, 2.5) if rng.random() < 0.3 else rng.uniform(2.5, 9.0))
        if kind < 0.65:
            name = CYCLIC[int(rng.integers(len(CYCLIC)))]
            extra = {"degree": float(rng.uniform(0.7, 1.0))} if name == "limp" else {}
            if name == "limp" and under["noise_kind"] == "smooth":
                under["noise_degrees"] = min(under["noise_degrees"], 1.0)
            period = float(rng.uniform(0.7, 2.5))
            p = kx.performer.perform(
                name,
                seconds=period * max(periods, 2.0) * 1.4,
                period=period,
                amplitude=float(rng.uniform(0.6, 1.1)),
                **extra,
                **under,
            )
            motion, class_, label = p.motion, p.truth.class_, name
        else:
            name, rich, poor, even, broken, period = mixtures(rng)
            if name == "limp":
                under["noise_kind"], under["noise_degrees"] = "smooth", float(rng.uniform(0.0, 5.0))
                share = float(rng.uniform(0.0, 1.0))
                own = UNEVEN_PER_DEGREE * under["noise_degrees"] ** 2 + 0.02
                value, (held, from_) = (UNEVEN_AT_FULL * share**2 + own) / own, LIMP
            else:
                value = float(rng.uniform(0.0, LARGEST))
                held, from_ = ALTERNATING if name in ("walk", "run") else (HELD, BROKEN)
                if rng.random() < 0.5:
                    value = float(rng.uniform(0.0, 2.0 * BROKEN))
                share = min(1.0, float(np.sqrt(value / RESIDUAL_AT_FULL[name])))
                value = RESIDUAL_AT_FULL[name] * share**2
            class_ = rich if rng.random() < np.clip((from_ - value) / (from_ - held), 0.0, 1.0) else poor
            period *= float(rng.uniform(0.8, 1.5))
            jitter = under.pop("tempo_jitter")
            score = cyclic_score(
                name, class_, _between(even, broken, share), seconds=period * max(periods, 2.0) * 1.4, period=period,
                tempo_jitter=jitter, seed=under["seed"],
            )  # fmt: skip
            motion, label = perform_score(score, **under).motion, f"{name} {share:.2f}"
        first = int(rng.integers(0, max(1, round(0.3 * period * motion.fps))))
        yield label, class_, True, motion[first : first + round(periods * period * motion.fps)]


def collect(count: int) -> list[Row]:
    rows = []
    for label, class_, cyclic, motion in performances(count):
        m = moments.from_poses(kx.poses(motion))
        seen = classes.measure(m, 0, m.count)
        found = None if seen is None else (seen.cyclic if cyclic else seen.single)
        if found is None:
            continue
        rows.append(Row(label, class_, cyclic, vars(found.residuals).copy(), found.turn_speed))
    return rows


def design(rows: list[Row], name: str, cyclic: bool) -> Array:
    """Columns of one curve: 1, −ln residual, −ln ratio (cyclic), −ln turn (reverse)."""
    out = []
    for row in rows:
        r, p = row.residuals[name], row.residuals["period"]
        r = 30.0 if r is None else r
        line = [1.0, -np.log(r + classes._FLOOR)]
        if cyclic:
            line.append(-np.log((r + classes._PERIOD_FLOOR) / ((p if p is not None else 1.0) + classes._PERIOD_FLOOR)))
        if name == "reverse":
            line.append(-np.log((row.turn if row.turn is not None else 1.0) + 0.1))
        out.append(line)
    return np.array(out, dtype=np.float64)


def fit(rows: list[Row], cyclic: bool) -> tuple[dict[str, Array], float]:
    groups = classes.CYCLIC_SYMMETRIES if cyclic else classes.SINGLE_SYMMETRIES
    names = list(classes.CYCLIC_CURVES if cyclic else classes.SINGLE_CURVES)
    X = {n: design(rows, n, cyclic) for n in names}
    listed = list(groups)
    truth = np.array([listed.index(r.class_) for r in rows])
    has = np.array([[n in groups[c] for n in names] for c in listed])
    frequency = np.bincount(truth, minlength=len(listed))
    weight = 1.0 / np.maximum(frequency, 1)[truth]
    weight /= weight.sum()
    sizes = [X[n].shape[1] for n in names]
    cuts = np.cumsum(sizes)
    few = len(listed)

    def split(theta: Array) -> dict[str, Array]:
        parts = np.split(theta[: cuts[-1]], cuts[:-1])
        # slopes are positive: a larger residual never makes a symmetry likelier
        return {n: np.concatenate([[p[0]], np.exp(p[1:])]) for n, p in zip(names, parts, strict=True)}

    def logs(theta: Array) -> Array:
        w = split(theta)
        odds = np.clip(np.stack([X[n] @ w[n] for n in names], axis=1), -30.0, 30.0)
        yes, no = -np.logaddexp(0, -odds), -np.logaddexp(0, odds)
        total = yes @ has.T + no @ (~has).T
        total = total / np.exp(theta[-1]) + (theta[-1 - few : -1] - theta[-1 - few : -1].mean())
        return np.asarray(total - np.logaddexp.reduce(total, axis=1, keepdims=True))

    def loss(theta: Array) -> float:
        data = -float(weight @ logs(theta)[np.arange(len(rows)), truth])
        return data + 0.002 * float((theta[:-1] ** 2).sum() * 0.2 + theta[-1] ** 2)

    start = np.concatenate([*(np.concatenate([[-3.0], np.zeros(s - 1)]) for s in sizes), np.zeros(few), [0.0]])
    best = minimize(loss, start, method="L-BFGS-B", options={"maxiter": 3000, "maxfun": 200000})
    chance = np.exp(logs(best.x))
    right = chance.argmax(1) == truth
    top = chance.max(1)
    print(
        "cyclic" if cyclic else "single",
        f"{len(rows)} performances, right {right.mean():.4f}, ECE {ece(top, right):.4f}",
    )
    for c in listed:
        k = truth == listed.index(c)
        if k.any():
            print(f"  {c.value:32s} {k.sum():4d} right {right[k].mean():.3f}")
    leaning = best.x[-1 - few : -1]
    for c, v in zip(listed, leaning - leaning.mean(), strict=True):
        print(f"    C.{c.name}: {v:.2f},")
    return split(best.x), float(np.exp(best.x[-1]))


def ece(confidence: Array, right: NDArray[np.bool_], bins: int = 10) -> float:
    """Expected calibration error over bins of equal width."""
    which = np.minimum((confidence * bins).astype(int), bins - 1)
    parts = ((which == b) for b in range(bins))
    return float(sum(abs(confidence[k].mean() - right[k].mean()) * k.mean() for k in parts if k.any()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1500)
    parser.add_argument("--cache", type=Path)
    options = parser.parse_args()
    if options.cache and options.cache.exists():
        rows = pickle.loads(options.cache.read_bytes())
    else:
        rows = collect(options.count)
        if options.cache:
            options.cache.write_bytes(pickle.dumps(rows))
    for cyclic in (True, False):
        weights, temperature = fit([r for r in rows if r.cyclic is cyclic], cyclic)
        for name, w in weights.items():
            fields = ["offset", "residual"] + (["ratio"] if cyclic else []) + (["turn"] if name == "reverse" else [])
            print(f'    "{name}": Curve({", ".join(f"{f}={v:.3g}" for f, v in zip(fields, w, strict=True))}),')
        print(f"    temperature {temperature:.3g}")


if __name__ == "__main__":
    main()
