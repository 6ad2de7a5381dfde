"""Radau IIA's iteration for its stages as Python runs it, against the collocation that it stands for."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from mbs_ref.integrators.stages import radau_newton
from mbs_ref.integrators.stages.radau_newton import C

H = 0.3  # s
POWERS = np.arange(3)
SLOPE = np.polynomial.Polynomial([2.0, -3.0, 5.0])  # m/s over the step's time in s
A = (C[:, None] ** (POWERS + 1) / (POWERS + 1)) @ np.linalg.inv(C[:, None] ** POWERS)  # integrates quadratics


def _stages() -> np.ndarray:
    """Return what the motion with this slope has gone at each stage (3, 1)."""
    return np.array([[SLOPE.integ()(c * H)] for c in C])


@pytest.fixture
def unsolved(monkeypatch):
    """Leave the right-hand sides of the linear systems as they are."""
    monkeypatch.setattr(radau_newton, "_solve", lambda *given: None)


def test_both_systems_are_of_the_eigenvalues_of_the_inverse_of_a(monkeypatch):
    taken = []
    monkeypatch.setattr(radau_newton, "_factor_one", lambda jacobian, mu, lu, pivots: taken.append(mu) or True)
    newton = SimpleNamespace(jacobian=None, real=None, real_pivots=None, complex=None, complex_pivots=None)
    assert radau_newton.factor.py_func(newton, H)
    values = np.linalg.eigvals(np.linalg.inv(A))
    for mu in taken:
        assert np.abs(H * mu - values).min() < 1e-12
    assert [abs(np.imag(mu)) > 1.0 for mu in taken] == [False, True]


def test_stages_that_fit_need_no_correction(unsolved):
    """Where z = h A f, nothing is left to correct in any of the three transformed equations."""
    slopes, z = np.array([[SLOPE(c * H)] for c in C]), _stages()
    newton = SimpleNamespace(slopes=slopes, w=np.empty((3, 1)), z=z, scale=np.ones(1), jacobian=None, real=None,
                             real_pivots=None, complex=None, complex_pivots=None)  # fmt: skip
    radau_newton._transform.py_func(radau_newton.TI, z, newton.w)
    part, both = np.empty(1), np.empty(1, dtype=complex)
    assert radau_newton._correct.py_func(newton, H, part, both) < 1e-12
    slopes[2] += 1.0
    assert radau_newton._correct.py_func(newton, H, part, both) > 0.1


def test_no_error_is_estimated_of_a_motion_whose_slope_is_a_quadratic(unsolved, monkeypatch):
    """The embedded formula has order 3 (sec. IV.8, eq 8.17): on cubics it agrees with the method."""
    monkeypatch.setattr(radau_newton, "weighted_norm", lambda err, *given: np.abs(err).max())
    newton = SimpleNamespace(z=_stages(), jacobian=None, real=None, real_pivots=None)
    f = np.array([SLOPE(0.0)])
    given = (newton, 1e-6, np.ones(1), False)
    assert radau_newton.error_norm.py_func(None, None, 0.0, H, np.zeros(1), f, *given) < 1e-12
    newton.z[2] += 0.1
    assert radau_newton.error_norm.py_func(None, None, 0.0, H, np.zeros(1), f, *given) > 0.01


@pytest.mark.parametrize(
    ("norms", "ended"),
    [
        ([1.0, 0.1, 0.01], (True, 2, 0.1)),  # 0.1 / 0.9 of the last 0.1 is left
        ([1.0, 0.4, 0.02], (True, 3, 0.05)),
        ([1.0, 0.7], (False, 2, 0.7)),  # 0.7^5 / 0.3 of 0.7 would be left after seven
        ([1.0, 0.5], (True, 2, 0.5)),  # so is 0.5^5 / 0.5 of 0.5, but that is roundoff
        ([1.0, 1.1], (False, 2, 1.1)),
        ([0.0], (True, 1, 0.0)),
        ([np.inf], (False, 1, 1.0)),
    ],
)
def test_newton_ends_when_what_a_geometric_series_leaves_is_small(monkeypatch, norms, ended):
    corrections = iter(norms)
    monkeypatch.setattr(radau_newton, "_evaluate_stages", lambda *given: None)
    monkeypatch.setattr(radau_newton, "_correct", lambda *given: next(corrections))
    newton = SimpleNamespace(z=np.zeros((3, 1)), w=np.zeros((3, 1)))
    found = radau_newton.solve_stages.py_func(None, None, 0.0, H, np.zeros(1), newton, 0.02, 0.6)
    assert (found.converged, found.iterations, pytest.approx(found.rate)) == ended
