"""Injury measures of acceleration, deflection and load histories.

Accelerations are in g here, at the edge, as the measures are defined. Between samples a(t) is taken as
linear, so that every integral is that of a piecewise linear history.
"""

import numpy as np

STANDARD_GRAVITY = 9.80665  # m/s^2, one g (CGPM 1901)
CLIP = 3e-3  # s
TTI_AGE, TTI_LOAD = 1.4, 0.5  # Eppinger, Marcus, Morgan 1984 (SAE 840885)
# intercepts of Nij; the Hybrid III 50th percentile male (49 CFR 571.208 S6.6)
TENSION, COMPRESSION = 6806.0, 6160.0  # N
FLEXION, EXTENSION = 310.0, 135.0  # N m


def hic(times: np.ndarray, a_g: np.ndarray, window: float) -> tuple[float, float, float]:
    """Return HIC and its interval: max of (t2 - t1) [mean of a over (t1, t2)]^2.5 with t2 - t1 <= window (s).

    times (n,) s increasing, a_g (n,) in g. Both ends are samples, or one is and the window is full.
    """
    times, velocity = _velocity(times, a_g)
    best = (0.0, float(times[0]), float(times[0]))
    for t1, v1 in zip(times, velocity, strict=True):
        stops = np.append(times[(times > t1) & (times < t1 + window)], min(t1 + window, times[-1]))
        best = max(best, _best_stop(t1, v1, stops, np.interp(stops, times, velocity)))
    starts = times[times >= times[0] + window] - window  # windows that are full and end on a sample
    if len(starts):
        mean = (np.interp(starts + window, times, velocity) - np.interp(starts, times, velocity)) / window
        k = int(np.argmax(mean))
        best = max(best, (float(window * max(mean[k], 0.0) ** 2.5), float(starts[k]), float(starts[k] + window)))
    return best


def _velocity(times: np.ndarray, a_g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    times, a_g = np.asarray(times, dtype=float), np.asarray(a_g, dtype=float)
    if times.ndim != 1 or times.shape != a_g.shape or len(times) < 2 or not np.all(np.diff(times) > 0.0):
        raise ValueError(f"times must increase and match a_g; got shapes {times.shape} and {a_g.shape}")
    steps = 0.5 * np.diff(times) * (a_g[1:] + a_g[:-1])
    return times, np.concatenate(([0.0], np.cumsum(steps)))


def _best_stop(t1: float, v1: float, stops: np.ndarray, velocity: np.ndarray) -> tuple[float, float, float]:
    span = stops - t1
    if not len(stops) or not span[-1] > 0.0:
        return 0.0, t1, t1
    value = span ** (-1.5) * np.maximum(velocity - v1, 0.0) ** 2.5
    k = int(np.argmax(value))
    return float(value[k]), float(t1), float(stops[k])


def gsi(times: np.ndarray, a_g: np.ndarray) -> float:
    """Return the Gadd severity index, the integral of a^2.5 dt (Gadd 1966), a in g, for a linear between samples."""
    a, b = np.maximum(a_g[:-1], 0.0), np.maximum(a_g[1:], 0.0)
    slope, mean = b - a, 0.5 * (a + b)
    steep = np.abs(slope) > 1e-6 * np.maximum(mean, 1e-300)
    exact = np.divide(b**3.5 - a**3.5, 3.5 * slope, out=mean**2.5, where=steep)
    return float(np.sum(np.diff(times) * exact))


def clip(times: np.ndarray, a_g: np.ndarray, duration: float = CLIP) -> float:
    """Return the largest level (g) that a(t) holds without interruption for `duration` (s): the 3 ms clip."""
    if times[-1] - times[0] < duration:
        raise ValueError(f"times span {times[-1] - times[0]:g} s; the clip needs {duration:g} s")
    low, high = float(np.min(a_g)), float(np.max(a_g))
    for _ in range(100):
        level = 0.5 * (low + high)
        low, high = (level, high) if _longest_above(times, a_g, level) >= duration else (low, level)
    return low


def _longest_above(times: np.ndarray, a_g: np.ndarray, level: float) -> float:
    """Return the longest unbroken time (s) with a(t) >= level."""
    over = a_g - level
    crossing = np.flatnonzero(over[:-1] * over[1:] < 0.0)
    share = over[crossing] / (over[crossing] - over[crossing + 1])
    between = times[crossing] + share * np.diff(times)[crossing]
    cuts = np.unique(np.concatenate((times[[0, -1]], between, times[over == 0.0])))
    held = np.interp(0.5 * (cuts[1:] + cuts[:-1]), times, over) >= 0.0
    longest = run = 0.0
    for length, above in zip(np.diff(cuts), held, strict=True):
        run = run + length if above else 0.0
        longest = max(longest, run)
    return longest


def thoracic_trauma_index(age: float, rib_g: float, t12_g: float, mass: float, standard_mass: float = 75.0) -> float:
    """Return TTI = 1.4 AGE + 0.5 (RIB + T12) M / Mstd (Eppinger et al. 1984): years, g, g, kg, kg."""
    return TTI_AGE * age + TTI_LOAD * (rib_g + t12_g) * mass / standard_mass


def viscous_criterion(times: np.ndarray, deflection: np.ndarray, depth: float, scale: float = 1.3) -> float:
    """Return VC = max of scale dD/dt D/D0, m/s (Lau and Viano 1986): deflection D (m), chest depth D0 (m)."""
    rate = np.gradient(deflection, times, edge_order=2)
    return float(np.max(scale * rate * deflection / depth))


def nij(axial: np.ndarray, moment: np.ndarray) -> np.ndarray:
    """Return Nij = Fz/Fzc + My/Myc: axial force (N, tension positive) and occipital moment (N m, flexion positive)."""
    force, bend = np.asarray(axial), np.asarray(moment)
    stretch = np.where(force >= 0.0, force / TENSION, force / -COMPRESSION)
    return stretch + np.where(bend >= 0.0, bend / FLEXION, bend / -EXTENSION)
