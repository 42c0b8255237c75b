"""The cycles of a cyclic movement, one by one ([Schultz2012] §3.2.4, §3.5).

A cycle begins at the slowest moment of the movement and ends where the same moment comes again. Within it, left and right are
compared: the phase is by how much of the cycle the right side comes after the left, less the half that alternating sides are
apart anyway; 0 for an even walk as for a jumping jack.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from kinesics.geometry import quaternion
from kinesics.grammar.lags import bend_cost, follow
from kinesics.grammar.moments import Moments
from kinesics.vocabulary import LINKS

Array = NDArray[np.float64]
Distances = NDArray[Any]

_BACKWARDS_BAND: Final = 0.15
PHASES: Final = 48
"""Moments at which a cycle is sampled to compare its sides."""
_ALIKE: Final = 0.5
"""Sides whose mirror images leave more than this do different things: they have no phase."""
_ROWS: Final = np.arange(PHASES)[None, :]
_SHIFTED: Final = (np.arange(PHASES)[:, None] + np.arange(PHASES)[None, :]) % PHASES
_LIMBS: Final = tuple(i for i, name in enumerate(LINKS) if name.startswith("left_"))
_OTHERS: Final = tuple(LINKS.index("right_" + LINKS[i][5:]) for i in _LIMBS)


@dataclass(frozen=True)
class Cycle:
    """One repetition."""

    start: int
    """Source frame of its slowest moment."""
    end: int
    """Source frame at which the next one begins."""
    period_s: float
    phase: float | None
    """By how much the right side follows the left, as a fraction of the cycle in (−½, ½], less ½ where the sides alternate.

    None where the sides do not do the same thing (waving one hand) or moments are not made of poses."""
    mirror_residual: float | None
    """What the mirror (at the best shift) leaves over, against the movement's range; without the constant bias."""


@dataclass(frozen=True)
class Stability:
    """How alike the cycles are."""

    period_deviation: float
    """Standard deviation of the periods over their mean."""
    residual: float
    """Distance of neighbouring cycles along the path, over the movement's range: 0 for a machine."""


def fractional_lags(by_lag: Distances, lags: NDArray[np.intp]) -> Array:
    """The lags of a path, finer than a moment: the vertex of the parabola through each cost and its neighbours'.

    Smoothed over a tenth of the lag, for the cost is flat where the movement is slow. Shape (len(lags),).
    """
    t = np.arange(len(lags))
    inner = (lags > 0) & (lags < len(by_lag) - 1)
    k = np.clip(lags, 1, len(by_lag) - 2)
    low, mid, high = (by_lag[k + s, t].astype(np.float64) for s in (-1, 0, 1))
    bend = low - 2.0 * mid + high
    good = inner & np.isfinite(bend) & (bend > 0.0)
    shift = np.zeros(len(lags))
    shift[good] = np.clip(0.5 * (low[good] - high[good]) / bend[good], -0.5, 0.5)
    weight = np.where(good, bend, 0.0) + 1e-12
    width = max(3, int(0.1 * float(np.median(lags))) | 1)
    window = np.ones(width)
    values = (lags + shift) * weight
    return np.asarray(np.convolve(values, window, "same") / np.convolve(weight, window, "same"))


def boundaries(speed: Array, lags: Array, noise_speed: float = 0.0) -> Array:
    """Beginnings of the cycles, fractional moments from the stretch's start, shape (cycles + 1,): the last one ends the last cycle.

    Parameters
    ----------
    speed : of each moment of the stretch.
    lags : from each moment to the same one a period later (`fractional_lags`), shorter than the stretch by about a period.
    noise_speed : speed that the noise alone gives.
    """
    n = len(speed)
    tau = float(np.mean(lags))
    moving = np.sqrt(np.maximum(speed**2 - noise_speed**2, 0.0))
    width = max(1, int(tau / 16)) | 1
    smooth = np.convolve(np.pad(moving, width // 2, mode="edge"), np.ones(width) / width, "valid")

    known = np.arange(len(lags))

    def later(t: Array) -> Array:
        return np.asarray(t + np.interp(t, known, lags))

    # where, over all cycles, the movement is slowest: chains from each phase of the first period
    chains: list[Array] = [np.arange(np.ceil(tau), dtype=np.float64)]
    while (following := later(chains[-1]))[0] <= n - 1 and len(chains) < n:
        chains.append(following)
    chain = np.stack(chains)
    inside = chain <= n - 1
    slow = np.where(inside, np.interp(chain, np.arange(n), smooth), 0.0).sum(axis=0) / inside.sum(axis=0)
    whole = inside.sum(axis=0) >= 2
    if whole.any():
        slow = np.where(whole, slow, np.inf)  # at least one cycle that is seen from its beginning to its end
    best = int(np.argmin(slow))
    return np.asarray(chain[inside[:, best], best])


def find(
    moments: Moments,
    start: int,
    end: int,
    by_lag: Distances,
    lags: NDArray[np.intp],
    returns: NDArray[np.bool_],
    range_: float,
    *,
    alternating: bool,
) -> tuple[tuple[Cycle, ...], float]:
    """The cycles of a stretch, and its period in seconds: the mean over all moments that return.

    Parameters
    ----------
    by_lag : D by lag of the stretch.
    lags : path of the period.
    returns : which moments of the path return.
    range_ : what residuals are measured against, in units of D.
    alternating : whether the sides do the same half a period apart.
    """
    fine = fractional_lags(by_lag, lags)
    noise_speed = float(np.sqrt(2.0 * moments.noise)) * moments.fps
    cuts = boundaries(moments.speed[start:end], fine, noise_speed)
    found = []
    for a, b in pairwise(cuts.tolist()):
        phase, residual = _sides(moments, start + a, start + b, alternating=alternating)
        share = max(residual - moments.noise, 0.0) / max(range_, 1e-12)
        found.append(
            Cycle(
                int(min(max(round(moments.exact_frame_of(start + a)), 0), moments.source_frames - 1)),
                int(min(round(moments.exact_frame_of(start + b)), moments.source_frames)),
                float(b - a) / moments.fps,
                phase if share < _ALIKE else None,
                share,
            )
        )
    forwards = float((fine[returns] if returns.any() else fine).mean())
    backwards = _period_backwards(by_lag, lags, returns)
    period = forwards if backwards is None else 0.5 * (forwards + backwards)
    return tuple(found), period / moments.fps


def _period_backwards(by_lag: Distances, lags: NDArray[np.intp], returns: NDArray[np.bool_]) -> float | None:
    """The period read from the end towards the beginning.

    A path ends a little before the last return it could show; read both ways, a short recording has the same period as its
    reverse.
    """
    n = by_lag.shape[1]
    near = by_lag[: int(1.3 * lags.max()) + 4]
    turned = np.full_like(near, np.inf)
    for k in range(len(near)):
        turned[k, : n - k] = near[k, : n - k][::-1]
    path = follow(turned, float(np.median(lags)), bend=bend_cost(near), band=_BACKWARDS_BAND)
    if path is None:
        return None
    first = n - 1 - np.arange(len(path.lags)) - path.lags  # the earlier moment of each pair
    known = first < len(returns)
    keep = np.where(known, returns[np.minimum(first, len(returns) - 1)], bool(returns[-1]))
    fine = fractional_lags(turned, path.lags)
    return float(fine[keep].mean()) if keep.any() else None


def stability(cycles: tuple[Cycle, ...], residual: float | None) -> Stability | None:
    """How alike the cycles are; None for fewer than two."""
    if len(cycles) < 2 or residual is None:
        return None
    periods = np.array([c.period_s for c in cycles])
    return Stability(float(periods.std() / periods.mean()), residual)


def _sides(moments: Moments, start: float, end: float, *, alternating: bool) -> tuple[float | None, float]:
    """Phase of right against left, and mean D* at the best shift, of one cycle."""
    at = start + np.arange(PHASES) / PHASES * (end - start)
    index = np.minimum(np.round(at).astype(np.intp), moments.count - 1)
    _, mirrored = moments.thinned(index)
    own = _by_shift(mirrored)
    centre = PHASES // 2 if alternating else 0
    if moments.poses is None:
        return None, float(own[_near(centre)].min())
    q = moments.poses.quaternions[index]
    # cost[s]: right at phase p + s against left at phase p
    alike = np.abs(np.einsum("plc,slc->lps", q[:, _LIMBS], quaternion.mirror(q[:, _OTHERS])))
    cost = len(_LIMBS) - _by_shift(alike.sum(axis=0))
    near = _near(centre)
    best = int(near[int(np.argmin(cost[near]))])
    low, mid, high = cost[best - 1], cost[best], cost[(best + 1) % PHASES]
    bend = low - 2.0 * mid + high
    if bend <= 1e-12 or cost.max() - cost.min() < 1e-6:
        return None, float(own[near].min())
    fine = best + float(np.clip(0.5 * (low - high) / bend, -0.5, 0.5)) - centre
    return float((fine / PHASES + 0.5) % 1.0 - 0.5), float(own[near].min())


def _near(centre: int) -> NDArray[np.intp]:
    """Shifts within a quarter of a cycle of one."""
    return np.asarray((centre + np.arange(-(PHASES // 4), PHASES // 4 + 1)) % PHASES)


def _by_shift(matrix: Distances) -> Array:
    """Mean of each diagonal of a matrix over phases, wrapped round: entry s compares phase p with phase p + s."""
    return np.asarray(matrix[_ROWS, _SHIFTED].mean(axis=1), dtype=np.float64)
