"""Truths against the values published for the IFToMM benchmark problems A01 and A02.

IFToMM Technical Committee for Multibody Dynamics, benchmark library (A01 Simple pendulum, A02
N-four-bar mechanism), and the digits to which their exact solutions are quoted.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from cross_checks.truths import known, truth_for
from cross_checks.truths.made_by.numerics.closed_forms import amplitude, quarter_period
from cross_checks.truths.made_by.numerics.solvers import extrapolate
from cross_checks.truths.truth import Truth
from mbs_ref import scenes

quoted_to = 1e-13  # m, the digits of A01 that hold
a02_quoted_to = 2e-12  # m: its last three digits do not hold (40-digit arithmetic gives ...540816 and ...178601)


def truth_at(name: str, *times: float, **parameters) -> Truth:
    truth = truth_for(scenes.make(name, **parameters), np.array(times))
    assert truth is not None
    return truth


def test_a01_position_at_ten_seconds():
    truth = truth_at("pendulum", 10.0)
    np.testing.assert_allclose(truth.position[0, 0], [-0.2750874625761, -0.9614192050991], atol=quoted_to)
    assert truth.kind == "proven"
    assert truth.uncertainty < 1e-15


def test_a01_returns_after_its_published_period():
    np.testing.assert_allclose(truth_at("pendulum", 2.3678419475762373).position[0, 0], [-1.0, 0.0], atol=1e-15)


def test_a02_tip_at_ten_seconds():
    tip = 2.0 * truth_at("n_four_bar", 10.0, loops=2).position[0, 0]
    np.testing.assert_allclose(tip, [0.328458111539739, 0.944518538178975], atol=a02_quoted_to)
    forty_digits = [0.3284581115408156227258781239, 0.9445185381786008772841888838]  # mpmath 1.4.1, 40 digits
    np.testing.assert_allclose(tip, forty_digits, atol=4e-16)


@pytest.mark.parametrize("loops", [1, 2, 40])
def test_a02_equals_its_differential_equation(loops):
    ratio = 9.81 * ((loops + 1) / 2 + loops) / ((loops + 1) / 3 + loops)

    def derivative(t, y):
        return np.array([y[1], ratio * np.sin(y[0])])

    theta = extrapolate(derivative, np.array([0.0, 1.0], dtype=np.longdouble), np.linspace(0.0, 10.0, 11), 1e-16)[:, 0]
    truth = truth_at("n_four_bar", *np.linspace(0.0, 10.0, 11), loops=loops)
    np.testing.assert_allclose(truth.orientation[:, 0], (np.pi / 2 - theta).astype(float), atol=3e-12)


def test_scenes_start_where_their_truths_do():
    # seen from a body, known at the end alone, known in the plane alone: test_against_de440.py, test_spatial_android.py
    elsewhere = {"solar_system", "pleiades", "android_spatial"}
    long = {"android_vertebral", "andrews"}  # half a minute: test_android_truths.py, test_published_problems.py
    for name in sorted(set(known()) - elsewhere - long):
        scene = scenes.make(name)
        start = [body.position for body in scene.bodies]
        np.testing.assert_allclose(truth_at(name, 0.0, 0.01).position[0], start, atol=1e-15, err_msg=name)


@pytest.mark.parametrize("m", [0.0, 0.5, 0.97])
def test_amplitude_equals_scipys(m):
    u = np.linspace(0.0, 10.0, 11)
    np.testing.assert_allclose(amplitude(u, m).astype(float), ellipj(u, m)[3], rtol=1e-13)
    np.testing.assert_allclose(float(quarter_period(m)), ellipk(m), rtol=1e-15)
