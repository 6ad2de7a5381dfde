"""Closed forms that several families share."""

from __future__ import annotations

import math

import numpy as np

from cross_checks.truths.made_by.numerics.closed_forms import amplitude, quarter_period


def swing(times: np.ndarray, rate: float, start: float) -> np.ndarray:
    """Return the angle (n_t,) rad from the lowest place of theta'' = -rate^2 sin(theta), at rest at `start` in (0, pi).

    sin(theta/2) = k sn(K + rate t | k^2), k = sin(start/2) (Whittaker 1904, section 44).
    """
    k = np.sin(np.longdouble(start) / 2)
    phase = amplitude(quarter_period(k * k) + np.longdouble(rate) * times.astype(np.longdouble), k * k)
    return (2 * np.arcsin(k * np.sin(phase))).astype(float)


def half_sine_push(since: np.ndarray, duration: float, peak: float) -> np.ndarray:
    """Return the way (n_t,) m of a body at rest accelerated by peak sin(pi s / duration) (m/s^2) from s = 0 s on."""
    inside = np.clip(since, 0.0, duration)
    turn = math.pi / duration
    way = peak / turn * (inside - np.sin(turn * inside) / turn)
    return way + 2.0 * peak / turn * np.maximum(since - duration, 0.0)
