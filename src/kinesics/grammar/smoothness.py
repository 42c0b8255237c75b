"""How smooth a movement is, from its speed curve: jagged karate against smooth yoga ([Schultz2012] §3.6.3).

Two measures, neither of which depends on how large or how long the movement is:

- `sparc`, spectral arc length: the length of the outline of the speed curve's spectrum, the shorter the smoother
  (Balasubramanian, Melendez-Calderon, Roby-Brami & Burdet, "On the analysis of movement smoothness", J. NeuroEngineering and
  Rehabilitation 12:112, 2015).
- `log_dimensionless_jerk`: minus the logarithm of the squared jerk, made dimensionless by duration and greatest speed (Hogan &
  Sternad, "Sensitivity of smoothness measures to movement duration, amplitude, and arrests", J. Motor Behavior 41, 2009; in
  Balasubramanian et al. 2015 as LDLJ).

Both are negative and nearer to 0 for smoother movement. A single reach with a bell-shaped speed has a spectral arc length of about
−1.4 and a jerk measure of −6; each stop and new start lowers both. `of_phrase` takes the speed √(2D)/Δt of the whole body (§3.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinesics.errors import InputError
from kinesics.grammar.moments import Moments

Array = NDArray[np.float64]

CUTOFF_HZ: Final = 10.0
"""No voluntary movement of the whole body is quicker (ibid., p. 5)."""
AMPLITUDE: Final = 0.05
"""The spectrum counts up to the last frequency at which it exceeds this share of its value at 0."""
PADDING: Final = 4
"""The spectrum is taken of a series 2⁴ times as long, padded with zeros, so that its outline is fine enough to measure."""
_FEWEST: Final = 4


@dataclass(frozen=True)
class Smoothness:
    """Of one phrase; None where nothing moves or it is too short."""

    spectral_arc_length: float | None
    log_dimensionless_jerk: float | None


def sparc(speed: ArrayLike, fps: float, *, cutoff: float = CUTOFF_HZ, amplitude: float = AMPLITUDE) -> float:
    """The spectral arc length, negative; the nearer to 0 the smoother.

    Parameters
    ----------
    speed : of any unit, shape (moments,), at least four, not all 0.
    fps : moments a second.
    cutoff : hertz; frequencies above count for nothing.
    amplitude : share of the spectrum's value at 0 below which its tail counts for nothing.

    Raises
    ------
    InputError
        If the speed or a parameter cannot be used.
    """
    v = _checked(speed, fps)
    if not (cutoff > 0.0 and 0.0 <= amplitude < 1.0):
        raise InputError(f"Expected `cutoff` above 0 and `amplitude` in [0, 1), got {cutoff} and {amplitude}.")
    length = 2 ** (int(np.ceil(np.log2(len(v)))) + PADDING)
    spectrum = np.abs(np.fft.rfft(v, length))
    spectrum /= spectrum[0]
    frequency = np.fft.rfftfreq(length, 1.0 / fps)
    inside = frequency <= cutoff
    spectrum, frequency = spectrum[inside], frequency[inside]
    last = int(np.flatnonzero(spectrum >= amplitude)[-1])
    if last == 0:
        return 0.0
    spectrum, frequency = spectrum[: last + 1], frequency[: last + 1]
    steps = np.hypot(np.diff(frequency) / (frequency[-1] - frequency[0]), np.diff(spectrum))
    return -float(steps.sum())


def log_dimensionless_jerk(speed: ArrayLike, fps: float) -> float:
    """−ln(T³/v² · ∫ (d²v/dt²)² dt) with duration T and greatest speed v; the nearer to 0 the smoother.

    The same values and errors as `sparc`. Twice differentiated, so it needs data with little noise.

    Raises
    ------
    InputError
        If the speed cannot be used.
    """
    v = _checked(speed, fps)
    jerk = np.diff(v, 2) * fps**2
    duration = len(v) / fps
    whole = float((jerk**2).sum() / fps) * duration**3 / float(v.max()) ** 2
    if whole <= 0.0:
        raise InputError("Expected a speed that changes; a constant one has no jerk and its measure is infinite.")
    return -float(np.log(whole))


def of_phrase(moments: Moments, start: int = 0, end: int | None = None) -> Smoothness:
    """The smoothness of the whole body's speed over a stretch of moments, without what the sensor's noise adds to it.

    Raises
    ------
    InputError
        If the stretch is empty or reaches beyond the recording.
    """
    start, end = moments.stretch(start, end)
    squared = moments.speed[start:end] ** 2 - 2.0 * moments.noise * moments.fps**2
    # the noise has random sign after the subtraction: average before the root
    if len(squared) >= 3:
        squared = np.convolve(np.pad(squared, 1, mode="edge"), (0.25, 0.5, 0.25), "valid")
    v = np.sqrt(np.maximum(squared, 0.0))
    if len(v) < _FEWEST or not v.max() > 0.0:
        return Smoothness(None, None)
    changes = bool((np.diff(v, 2) != 0.0).any())
    return Smoothness(sparc(v, moments.fps), log_dimensionless_jerk(v, moments.fps) if changes else None)


def _checked(speed: ArrayLike, fps: float) -> Array:
    v = np.asarray(speed, dtype=np.float64)
    if v.ndim != 1 or len(v) < _FEWEST:
        raise InputError(f"Expected `speed` of shape (moments,) with at least {_FEWEST} of them, got shape {v.shape}.")
    if not np.isfinite(v).all() or v.min() < 0.0 or not v.max() > 0.0:
        raise InputError("Expected a `speed` of finite values, none negative and not all 0.")
    if not (np.isfinite(fps) and fps > 0.0):
        raise InputError(f"Expected `fps` above 0, got {fps}.")
    return v
