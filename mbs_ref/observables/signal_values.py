"""Signals evaluated at many times at once."""

import numpy as np

from mbs_ref.scene.signals import Level, Segment, Signal, motion_segments


def values(signal: Signal, times: np.ndarray) -> np.ndarray:
    """Return the signal's values (n_t,); at a jump the later one."""
    return _evaluate(signal.segments(), times, rate=False)


def motion(signal: Signal, level: Level, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the displacement a drive prescribes, zero at t = 0, and its rate; each (n_t,)."""
    pieces = motion_segments(signal, level)
    return _evaluate(pieces, times, rate=False), _evaluate(pieces, times, rate=True)


def _evaluate(pieces: list[Segment], times: np.ndarray, *, rate: bool) -> np.ndarray:
    starts = [piece.start for piece in pieces]
    chosen = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, None)
    result = np.empty(len(times), dtype=np.result_type(times, float))
    for k, piece in enumerate(pieces):
        here = chosen == k
        tau = times[here] - (piece.start if np.isfinite(piece.start) else 0.0)  # from -inf on only constants occur
        angle, coefficients = piece.omega * tau + piece.phase, np.asarray(piece.coefficients)
        wave = piece.amplitude * piece.omega * np.cos(angle) if rate else piece.amplitude * np.sin(angle)
        polynomial = np.polynomial.polynomial.polyder(coefficients) if rate else coefficients
        result[here] = np.polynomial.polynomial.polyval(tau, polynomial) + wave
    return result
