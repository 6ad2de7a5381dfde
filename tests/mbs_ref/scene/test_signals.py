"""Signals: values, prescribed motions against quadrature, and declared breakpoints."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import quad

from mbs_ref.scene.signals import DEGREE, Constant, HalfSine, Harmonic, Polynomial, Table, breakpoints, motion_segments

QUADRATURE = 1e-9  # adaptive quadrature of O(10) values over seconds, with room

SIGNALS = {
    "constant": (Constant(value=3.0), lambda t: 3.0),
    "table": (Table(times=(0.5, 1.5, 1.5, 2.0), values=(1.0, 3.0, -2.0, 0.0)), None),
    "table around zero": (Table(times=(-1.0, 1.0), values=(-4.0, 4.0)), lambda t: 4.0 * min(1.0, max(-1.0, t))),
    "single point": (Table(times=(1.0,), values=(2.5,)), lambda t: 2.5),
    "jump at zero": (Table(times=(0.0, 0.0), values=(1.0, 5.0)), lambda t: 1.0 if t < 0.0 else 5.0),
    "half sine": (
        HalfSine(peak=7.0, duration=0.4, start=0.3),
        lambda t: 7.0 * math.sin(math.pi * (t - 0.3) / 0.4) if 0.3 <= t < 0.7 else 0.0,
    ),
    "harmonic": (
        Harmonic(amplitude=2.0, omega=3.0, phase=0.4, offset=-1.0),
        lambda t: -1.0 + 2.0 * math.sin(3.0 * t + 0.4),
    ),
    "still harmonic": (Harmonic(amplitude=2.0, omega=0.0, phase=0.5, offset=1.0), lambda t: 1.0 + 2.0 * math.sin(0.5)),
    "polynomial": (
        Polynomial(coefficients=(1.0, -2.0, 0.5, 0.1, -0.02)),
        lambda t: 1.0 - 2.0 * t + 0.5 * t**2 + 0.1 * t**3 - 0.02 * t**4,
    ),
}
TIMES = (0.0, 0.1, 0.5, 0.69, 1.2, 1.5, 1.7, 2.6)  # s


def table_value(t: float) -> float:
    if t < 0.5:
        return 1.0
    if t < 1.5:
        return 1.0 + 2.0 * (t - 0.5)
    return -2.0 + 4.0 * (t - 1.5) if t < 2.0 else 0.0


def exact(name):
    return SIGNALS[name][1] or table_value


def evaluate(pieces, t):
    """Return the value of the last piece that has begun: right-continuous."""
    begun = [piece for piece in pieces if piece.start <= t]
    return (begun or pieces)[-1 if begun else 0].value(t)


def integral(function, t, points):
    stops = [0.0, *sorted(p for p in points if 0.0 < p < t), t]
    return sum(quad(function, a, b, epsabs=1e-12, epsrel=1e-12)[0] for a, b in pairwise(stops))


@pytest.mark.parametrize("name", SIGNALS)
@pytest.mark.parametrize("t", TIMES)
def test_values(name, t):
    assert evaluate(SIGNALS[name][0].segments(), t) == pytest.approx(exact(name)(t), abs=1e-12)


@pytest.mark.parametrize("name", SIGNALS)
def test_a_position_motion_is_the_signal_from_its_value_at_zero(name):
    pieces = motion_segments(SIGNALS[name][0], "position")
    f = exact(name)
    assert all(math.isfinite(piece.start) for piece in pieces)
    for t in TIMES:
        assert evaluate(pieces, t) == pytest.approx(f(t) - f(0.0), abs=1e-12)


@pytest.mark.parametrize("name", SIGNALS)
def test_a_velocity_motion_is_the_integral(name):
    signal, f = SIGNALS[name][0], exact(name)
    pieces = motion_segments(signal, "velocity")
    for t in TIMES:
        assert evaluate(pieces, t) == pytest.approx(integral(f, t, breakpoints(signal)), abs=QUADRATURE)


@pytest.mark.parametrize("name", SIGNALS)
def test_an_acceleration_motion_is_the_double_integral_from_rest(name):
    signal, f = SIGNALS[name][0], exact(name)
    pieces = motion_segments(signal, "acceleration")
    for t in TIMES:
        # Cauchy's formula: the double integral from rest is int (t - s) f(s) ds
        moved = integral(lambda s, t=t: (t - s) * f(s), t, breakpoints(signal))
        assert evaluate(pieces, t) == pytest.approx(moved, abs=QUADRATURE)


@pytest.mark.parametrize("level", ["velocity", "acceleration"])
@pytest.mark.parametrize("name", SIGNALS)
def test_a_motion_is_continuous_and_within_the_compiled_degree(name, level):
    pieces = motion_segments(SIGNALS[name][0], level)
    assert max(len(piece.coefficients) for piece in pieces) <= DEGREE + 1
    for before, after in pairwise(pieces):
        assert before.value(after.start) == pytest.approx(after.value(after.start), abs=1e-12)


def test_breakpoints_are_where_the_signal_may_jump():
    assert breakpoints(Constant()) == []
    assert breakpoints(HalfSine(peak=1.0, duration=0.001, start=5.0)) == [5.0, 5.001]
    assert breakpoints(Table(times=(0.5, 1.5, 1.5, 2.0), values=(1.0, 3.0, -2.0, 0.0))) == [0.5, 1.5, 2.0]
    assert breakpoints(Polynomial(coefficients=(1.0, 2.0))) == []


def test_a_motion_keeps_the_signal_s_breakpoints():
    pulse = HalfSine(peak=15e3, duration=1e-3, start=5.0)
    for level in ("velocity", "acceleration"):
        assert [piece.start for piece in motion_segments(pulse, level)[1:]] == breakpoints(pulse)
    # the impulse of a half sine is 2 peak duration / pi
    assert evaluate(motion_segments(pulse, "velocity"), 10.0) == pytest.approx(2 * 15e3 * 1e-3 / np.pi, rel=1e-12)


@pytest.mark.parametrize(
    ("times", "values", "complaint"),
    [
        ((0.0, 1.0), (1.0,), "times has 2 entries and values 1"),
        ((1.0, 0.0), (1.0, 2.0), "must not decrease, but 0.0 follows 1.0"),
        ((1.0, 1.0, 1.0), (1.0, 2.0, 3.0), "at most twice"),
        ((0.0, math.nan), (1.0, 2.0), "finite number"),
    ],
)
def test_a_bad_table_is_refused(times, values, complaint):
    with pytest.raises(ValidationError, match=complaint):
        Table(times=times, values=values)
