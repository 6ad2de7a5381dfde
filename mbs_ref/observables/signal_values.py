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
        result[here] = _rate(piece, times[here]) if rate else _value(piece, times[here])
    return result


def _local(piece: Segment, times: np.ndarray) -> np.ndarray:
    return times - (piece.start if np.isfinite(piece.start) else 0.0)  # from -inf on only constants occur


def _value(piece: Segment, times: np.ndarray) -> np.ndarray:
    tau = _local(piece, times)
    polynomial = np.polynomial.polynomial.polyval(tau, piece.coefficients)
    return polynomial + piece.amplitude * np.sin(piece.omega * tau + piece.phase)


def _rate(piece: Segment, times: np.ndarray) -> np.ndarray:
    tau = _local(piece, times)
    slope = np.polynomial.polynomial.polyder(piece.coefficients)
    polynomial = np.polynomial.polynomial.polyval(tau, slope)
    return polynomial + piece.amplitude * piece.omega * np.cos(piece.omega * tau + piece.phase)
