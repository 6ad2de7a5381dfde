"""Small solves and rotations as Python runs them, which minds the bounds of arrays: against NumPy and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbs_ref.kernels.algebra.dense import factor3, factor6, ldl3, ldl3_solve, lu_factor, lu_solve, solve3, solve6
from mbs_ref.kernels.rigid.dynamics import refinements
from mbs_ref.kernels.spatial.loads import _product, _relative
from mbs_ref.kernels.spatial.marks import symmetric_times, turn, turn_back
from mbs_ref.kernels.spatial.orientation import composed, rotation, theta_rate, world_inertia

THETA = (0.4, -1.1, 0.7, 1.3)  # Euler parameters of no norm
MATRIX = np.array([[0.0, 2.0, -1.0, 0.5], [3.0, 1.0, 4.0, -2.0], [0.5, -3.0, 2.0, 1.0], [1.0, 0.7, -0.6, 5.0]])
RIGHT = np.array([1.0, -2.0, 3.0, 0.5])
POSITIVE = MATRIX @ MATRIX.T + np.eye(4)
INERTIA = np.array([[2.0, 0.3, -0.1], [0.3, 3.0, 0.4], [-0.1, 0.4, 4.0]])
SIX = (2.0, 3.0, 4.0, 0.3, -0.1, 0.4)  # of it: xx, yy, zz, xy, xz, yz


def _turned() -> np.ndarray:
    turned = np.empty((3, 3))
    assert rotation.py_func(THETA, turned) == pytest.approx(np.dot(THETA, THETA))
    return turned


@pytest.mark.parametrize("factor", [1.0, 1.0 + 0.5j], ids=["real", "complex"])
def test_a_matrix_whose_first_pivot_is_zero_is_solved(factor):
    a, x, pivots = factor * MATRIX, RIGHT * factor**2, np.empty(4, dtype=np.int64)
    assert lu_factor.py_func(a, pivots)
    lu_solve.py_func(a, pivots, x)
    np.testing.assert_allclose(MATRIX @ x, factor * RIGHT, atol=1e-14)


def test_a_singular_matrix_is_told():
    assert not lu_factor.py_func(np.ones((2, 2)), np.empty(2, dtype=np.int64))


def test_three_symmetric_equations_are_solved():
    a = POSITIVE[:3, :3]
    x = ldl3_solve.py_func(ldl3.py_func(a[0, 0], a[1, 0], a[1, 1], a[2, 0], a[2, 1], a[2, 2]), RIGHT)
    np.testing.assert_allclose(a @ x, RIGHT[:3], atol=1e-13)


def test_symmetric_equations_are_solved_from_the_lower_triangle():
    root = np.random.default_rng(0).standard_normal((6, 6))
    positive, right = root @ root.T + 0.1 * np.eye(6), np.arange(1.0, 7.0)
    a = np.where(np.triu(np.ones((6, 6)), 1) == 1.0, np.nan, positive)
    whole, part = a.copy(), a.copy()
    factor6(whole)
    factor3(part)
    np.testing.assert_allclose(positive @ np.hstack(solve6(whole, right[:3], right[3:])), right, atol=1e-12)
    np.testing.assert_allclose(positive[:3, :3] @ solve3(part, right[:3]), right[:3], atol=1e-12)
    np.testing.assert_array_equal(part[3:], a[3:])


@pytest.mark.parametrize(("pivot", "steps"), [(0.5, 0), (1e-4, 1), (1e-8, 1), (1e-10, 2), (1e-13, 0)])
def test_a_solution_is_refined_until_what_elimination_lost_is_borne(pivot, steps):
    """(eps / pivot)^(1 + steps) comes below 100 eps: from 2e-12, 2e-8 and 2e-6; from 2e-3 a rank is lost."""
    assert refinements.py_func(pivot) == steps


def test_euler_parameters_of_any_norm_turn_as_scipys_quaternions_do():
    np.testing.assert_allclose(_turned(), Rotation.from_quat(THETA, scalar_first=True).as_matrix(), atol=1e-15)


def test_rates_of_euler_parameters_turn_axes_by_the_worlds_angular_velocity():
    """A' = [w x] A, by central differences."""
    w, step = np.array([0.7, -0.4, 1.9]), 1e-5
    after, before = np.empty((3, 3)), np.empty((3, 3))
    change = step * np.array(theta_rate.py_func(THETA, w))
    rotation.py_func(tuple(THETA + change), after)
    rotation.py_func(tuple(THETA - change), before)
    wanted = np.cross(w, _turned().T).T
    np.testing.assert_allclose((after - before) / (2.0 * step), wanted, atol=1e-9)


def test_a_product_of_quaternions_is_one_rotation_after_the_other():
    s, v = 0.3, (0.5, -0.2, 0.9)
    found = Rotation.from_quat(composed.py_func(THETA, (s, *v)), scalar_first=True)
    one, other = (Rotation.from_quat(theta, scalar_first=True) for theta in (THETA, (s, *v)))
    np.testing.assert_allclose(found.as_matrix(), (one * other).as_matrix(), atol=1e-15)


def test_inertia_turns_with_its_body():
    a, out = _turned(), np.empty(6)
    world_inertia.py_func(a, SIX, out)
    wanted = a @ INERTIA @ a.T
    np.testing.assert_allclose(out, wanted[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]], atol=1e-14)


def test_matrices_times_vectors_and_matrices_are_numpys():
    a, m, u, out = _turned(), MATRIX[:3, 1:], RIGHT[1:], np.empty((3, 3))
    np.testing.assert_allclose(turn.py_func(m, u), m @ u, atol=1e-14)
    np.testing.assert_allclose(turn_back.py_func(m, u), m.T @ u, atol=1e-14)
    np.testing.assert_allclose(symmetric_times.py_func(SIX, u), INERTIA @ u, atol=1e-14)
    _product.py_func(m, a, out)
    np.testing.assert_allclose(out, m @ a, atol=1e-14)
    _relative.py_func(m, a, out)
    np.testing.assert_allclose(out, m.T @ a, atol=1e-14)
