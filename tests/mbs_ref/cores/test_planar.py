"""The compiled planar core against differences, the dense augmented system and the shared judge."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.cores.planar import PlanarSystem
from tests.mbs_ref.cores.mechanisms import EVERY, moved_state

T = 0.3  # s, inside a smooth stretch of every signal used
ROUNDOFF = 1e-9  # of accelerations of order 10 to 100, at poses of moderate condition


def _stacked(system: PlanarSystem, t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    pairs = system.residuals(t, y).values()
    return np.concatenate([c for c, _ in pairs]), np.concatenate([rate for _, rate in pairs])


def _augmented(system: PlanarSystem, t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return matrix and right-hand side of [M C_q^T; C_q 0][qdd; lambda] = [Q_e; gamma]."""
    force, jacobian = system.applied_forces(t, y).ravel(), system.jacobian(t, y)
    rows = len(jacobian)
    matrix = np.block([[np.diag(system.mass_matrix()), jacobian.T], [jacobian, np.zeros((rows, rows))]])
    return matrix, np.concatenate((force, system.right_side()))


@pytest.fixture(params=[(build, seed) for build in EVERY for seed in range(3)], ids=lambda p: f"{p[0].__name__}-{p[1]}")
def case(request) -> tuple[PlanarSystem, np.ndarray]:
    build, seed = request.param
    system = PlanarSystem(build())
    system.set_mode_time(T)
    return system, moved_state(system, seed)


def test_the_jacobian_is_the_derivative_of_the_constraints(case):
    system, y = case
    jacobian = system.jacobian(T, y)
    step = 1e-6
    for k in range(3 * system.n_bodies):
        ahead, behind = y.copy(), y.copy()
        ahead[k] += step
        behind[k] -= step
        difference = (_stacked(system, T, ahead)[0] - _stacked(system, T, behind)[0]) / (2 * step)
        np.testing.assert_allclose(jacobian[:, k], difference, atol=1e-8)


def test_the_rate_is_the_total_derivative_of_the_constraints(case):
    system, y = case
    half, step = y.size // 2, 1e-6
    ahead, behind = y.copy(), y.copy()
    ahead[:half] += step * y[half:]
    behind[:half] -= step * y[half:]
    difference = (_stacked(system, T + step, ahead)[0] - _stacked(system, T - step, behind)[0]) / (2 * step)
    np.testing.assert_allclose(_stacked(system, T, y)[1], difference, atol=1e-7)


def test_accelerations_keep_the_rate_constant(case):
    """C_q a - gamma = d(C_dot)/dt = 0 along the motion: checks gamma against d/dt."""
    system, y = case
    step = 1e-6
    dy = system.derivative(T, y)
    change = _stacked(system, T + step, y + step * dy)[1] - _stacked(system, T - step, y - step * dy)[1]
    np.testing.assert_allclose(change / (2 * step), 0.0, atol=2e-6)


def test_tree_elimination_equals_the_dense_augmented_system(case):
    system, y = case
    half = y.size // 2
    dense = np.linalg.solve(*_augmented(system, T, y))
    np.testing.assert_allclose(system.derivative(T, y)[half:], dense[:half], atol=ROUNDOFF, rtol=1e-9)
    np.testing.assert_allclose(system.multipliers(T, y), dense[half:], atol=ROUNDOFF, rtol=1e-8)


def test_reactions_and_loads_balance_every_body(case):
    """M a = f - C_q^T lambda: the sum of what the judge may be told about each joint."""
    system, y = case
    half = y.size // 2
    force = system.applied_forces(T, y).ravel()
    lam = system.multipliers(T, y)
    left = system.mass_matrix() * system.derivative(T, y)[half:]
    np.testing.assert_allclose(left, force - system.jacobian(T, y).T @ lam, atol=1e-8, rtol=1e-9)


def test_redundant_rows_are_ranked_and_share_in_the_minimum_norm():
    """Two welds on one pair: six rows of rank three; the two carry equal parts."""
    from mbs_ref.scene import PlanarBody, Scene, Weld

    body = PlanarBody(name="b", mass=2.0, inertia=1.0)
    welds = [Weld(name=f"w{k}", body_a="ground", body_b="b", point=(0.0, 0.0)) for k in range(2)]
    system = PlanarSystem(Scene(name="twice", gravity=(0.0, -9.81), bodies=(body,), joints=tuple(welds)))
    y = system.initial_state()
    assert system.rank(0.0, y) == 3
    assert system.n_constraints == 6
    reactions = {name: values[0] for name, values in system.reactions_over(np.zeros(1), y[None]).items()}
    np.testing.assert_allclose(reactions["w0"], [0.0, 9.81, 0.0], atol=1e-9)
    np.testing.assert_allclose(reactions["w1"], [0.0, 9.81, 0.0], atol=1e-9)


@pytest.mark.parametrize("links", [3, 40])
def test_a_chain_hangs_from_its_own_weight(links):
    """The first pin carries the whole chain at rest, hanging straight down."""
    from mbs_ref.scene import PlanarBody, Revolute, Scene

    bodies = tuple(PlanarBody(name=f"b{k}", mass=1.0, inertia=1 / 12, position=(0, -k - 0.5)) for k in range(links))
    names = ["ground", *(b.name for b in bodies)]
    joints = tuple(Revolute(name=f"j{k}", body_a=names[k], body_b=names[k + 1], point=(0, -k)) for k in range(links))
    system = PlanarSystem(Scene(name="hanging", gravity=(0.0, -9.81), bodies=bodies, joints=joints))
    reactions = {
        name: values[0] for name, values in system.reactions_over(np.zeros(1), system.initial_state()[None]).items()
    }
    for k in range(links):
        np.testing.assert_allclose(reactions[f"j{k}"], [0.0, 9.81 * (links - k), 0.0], atol=1e-8)


@pytest.mark.parametrize("name", ["spring_pendulum", "pendulum", "slider_crank", "driven_pendulum"])
def test_every_scene_agrees_with_the_dense_system(name):
    system = PlanarSystem(scenes.make(name))
    y = system.initial_state()
    half = y.size // 2
    dense = np.linalg.lstsq(*_augmented(system, 0.0, y), rcond=1e-13)[0]
    np.testing.assert_allclose(system.derivative(0.0, y)[half:], dense[:half], atol=ROUNDOFF)


def test_projection_moves_onto_the_constraints_in_the_mass_norm():
    """The correction is M-orthogonal to every motion the joints allow."""
    system = PlanarSystem(scenes.make("double_pendulum"))
    y = system.initial_state()
    off = y.copy()
    off[:6] += 1e-5 * np.arange(1.0, 7.0)
    on = off.copy()
    assert system.project(0.0, on, tolerance=1e-14) < 1e-13
    correction = system.mass_matrix() * (on - off)[:6]
    _, _, kernel = np.linalg.svd(system.jacobian(0.0, on))
    allowed = kernel[system.rank(0.0, on) :]
    np.testing.assert_allclose(allowed @ correction, 0.0, atol=1e-9)  # second order in the gap of 1e-5
