"""The spatial core against its own definition: the dense augmented matrix in Euler parameters, and derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import observables, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.spatial import SpatialSystem
from mbs_ref.scene.euler_parameters import parameter_matrix, rotation_matrices
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status, Trajectory
from tests.mbs_ref.cores.every_spatial_part import every_part, general_state

T = 0.37  # s, no special time


def augmented(system: SpatialSystem, t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the papers' augmented matrix in Euler parameters and its right-hand side, dense.

    Unknowns: qdd (3 a point mass, 7 a rigid body), then the multipliers of the joint rows (`rows`),
    then of theta^T theta = 1 for each rigid body (Fox 1999 eq 9 and appendix). The upper-left block is
    4 E^T J E in each body's theta, of rank 3: the matrix is to be factored whole.
    """
    force = system.applied_forces(t, y).ravel()
    gamma = np.array([system.scratch.rows.gamma[slot, row] for _, slot, row in system.rows()])
    jacobian, mass = system.jacobian(t, y), system.mass_matrix()
    to_rates, norms, squares = _rate_map(system, y)
    size, m, k = to_rates.shape[1], len(gamma), len(norms)
    matrix = np.zeros((size + m + k, size + m + k))
    matrix[:size, :size] = to_rates.T @ mass @ to_rates
    matrix[size : size + m, :size] = jacobian @ to_rates
    matrix[size + m :, :size] = norms
    matrix[:size, size:] = matrix[size:, :size].T
    return matrix, np.concatenate((to_rates.T @ force, gamma, squares))


def _rate_map(system: SpatialSystem, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return d(R', omega)/d(q'), the Jacobian of the norms and their right-hand side -2 theta'^T theta'."""
    to_rates = np.zeros((6 * system.n_bodies, system.n_positions))
    norms, squares = np.zeros((len(system.rigid), system.n_positions)), np.zeros(len(system.rigid))
    bodies = system.groups.bodies
    place = {k: (bodies.q[i], bodies.v[i]) for i, k in enumerate(bodies.scene_index)}
    for k in range(system.n_bodies):
        to_rates[6 * k : 6 * k + 3, place[k][0] : place[k][0] + 3] = np.eye(3)
    for row, k in enumerate(system.rigid):
        q, v = place[k]
        theta = y[q + 3 : q + 7]
        e = parameter_matrix(theta)
        to_rates[6 * k + 3 : 6 * k + 6, q + 3 : q + 7] = 2.0 * e
        norms[row, q + 3 : q + 7] = 2.0 * theta
        rate = 0.5 * e.T @ rotation_matrices(theta) @ y[v + 3 : v + 6]
        squares[row] = -2.0 * rate @ rate
    return to_rates, norms, squares


@pytest.fixture(scope="module")
def system():
    return compile_scene(every_part())


def test_elimination_equals_the_augmented_matrix_factored_whole(system):
    y = general_state(system)
    dy = system.derivative(T, y)
    matrix, right = augmented(system, T, y)
    size = system.n_positions
    upper_left = matrix[:size, :size]
    assert np.linalg.matrix_rank(upper_left) == size - len(system.rigid)  # singular by itself, as the papers say
    found = np.linalg.solve(matrix, right)
    bodies = system.groups.bodies
    for q, v, rigid in zip(bodies.q, bodies.v, bodies.rigid, strict=True):
        assert found[q : q + 3] == pytest.approx(dy[v : v + 3], rel=1e-10, abs=1e-10)
        if rigid:
            theta, rate = y[q + 3 : q + 7], dy[q + 3 : q + 7]
            alpha = rotation_matrices(theta) @ dy[v + 3 : v + 6]
            second = 0.5 * parameter_matrix(theta).T @ alpha - theta * (rate @ rate)
            assert found[q + 3 : q + 7] == pytest.approx(second, rel=1e-10, abs=1e-10)
    lam = system.multipliers(T, y)
    assert found[size : size + len(lam)] == pytest.approx(lam, rel=1e-9, abs=1e-9)


def test_rates_and_gamma_are_derivatives_along_the_motion(system):
    y = general_state(system)
    h = 1e-5  # s: central differences of order 2, with rounding near 1e-10

    def moved(step: float) -> np.ndarray:
        k1 = system.derivative(T, y)
        k2 = system.derivative(T + step / 2, y + step / 2 * k1)
        k3 = system.derivative(T + step / 2, y + step / 2 * k2)
        k4 = system.derivative(T + step, y + step * k3)
        return y + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    after, before, now = system.residuals(T + h, moved(h)), system.residuals(T - h, moved(-h)), system.residuals(T, y)
    for joint, (_, rate) in now.items():
        assert (after[joint][0] - before[joint][0]) / (2 * h) == pytest.approx(rate, abs=1e-8), joint
        assert after[joint][1] - before[joint][1] == pytest.approx(0.0, abs=2e-12), joint  # C_q qdd = gamma


def test_the_judge_sees_the_same_constraints(system):
    """Every joint gapes by a size of its own. Rows may be told apart by other directions: their norms compare."""
    y = general_state(system)
    y[: system.n_positions] += 1e-3 * np.random.default_rng(5).standard_normal(system.n_positions)
    path = Trajectory(np.array([T]), *system.poses(y[None]))
    seen = observables.rows(system.scene, path)
    for joint, (residual, rate) in system.residuals(T, y).items():
        mine = [k for k, name in enumerate(seen.joints) if name == joint]
        assert len(mine) == len(rate)
        if joint == "turn":  # an angle here, and a row of direction cosines there
            continue
        assert np.linalg.norm(residual) > 5e-4, joint
        assert np.linalg.norm(seen.residual[0, mine]) == pytest.approx(np.linalg.norm(residual), rel=1e-9), joint
        assert np.linalg.norm(seen.rate[0, mine]) == pytest.approx(np.linalg.norm(rate), rel=1e-9), joint


def test_projection_restores_constraints_and_norms(system):
    y = system.initial_state()
    y += 1e-3 * np.random.default_rng(3).standard_normal(len(y))
    assert system.project(0.0, y) < 1e-12
    position, velocity = system.compliance(0.0, y)
    assert position < 1e-12
    assert velocity < 1e-10


@pytest.mark.parametrize(
    ("name", "rank_lost", "freedoms"),
    [("bricard", 1, 1), ("spatial_n_four_bar", 6, 1), ("spatial_slider_crank", 0, 1), ("flyball_governor", 0, 4)],
)
def test_rank_and_freedoms(name, rank_lost, freedoms):
    system = compile_scene(scenes.make(name))
    y = system.initial_state()
    rank = system.rank(0.0, y)
    assert system.n_constraints - rank == rank_lost
    assert system.n_coordinates - rank == freedoms


def test_bricard_keeps_energy_and_constraints_and_says_what_is_redundant():
    scene = scenes.make("bricard")
    path = simulate(scene, Settings(rtol=1e-10))
    assert path.status is Status.SUCCESS
    assert any("1 of 35" in note and "1 degrees of freedom" in note for note in path.notes)
    drift = observables.energy_balance(scene, path).drift
    assert drift is not None
    assert np.abs(drift).max() < 1e-6  # J, the bound
    assert np.abs(observables.constraint_residual(scene, path)).max() < 1e-9  # m


def test_every_part_balances_its_energy():
    """The judge's potentials and powers are coded apart from the solver's forces."""
    scene = every_part()
    path = simulate(scene, Settings(rtol=1e-11, t_end=0.3, samples=601, project_initial=True, estimate="off"))
    balance = observables.energy_balance(scene, path)
    assert balance.drift is not None, balance.reason
    assert np.abs(balance.drift).max() < 1e-6 * np.abs(balance.energy).max()


def test_norm_drift_under_rk4_and_normalising_changes_no_orientation():
    """|R(iz)|^2 = 1 - z^6 / 72 + ... for RK4 on theta' = i (w / 2) theta, so |theta| falls by z^6 / 144 a step."""
    scene = scenes.make("torque_free_top", tilt=0.0, axis=3, spin=10.0, turns=10.0)
    step = 0.02  # s, w h / 2 = 0.1
    free = simulate(scene, Settings(method="rk4", step=step, stabilization="none", samples=2))
    kept = simulate(scene, Settings(method="rk4", step=step, stabilization="projection", samples=2))
    drift = 1.0 - np.linalg.norm(free.orientation[-1, 0])
    assert drift == pytest.approx(free.steps * 0.1**6 / 144.0, rel=0.02)
    turned = free.orientation[-1, 0] / np.linalg.norm(free.orientation[-1, 0])
    assert turned == pytest.approx(kept.orientation[-1, 0], abs=1e-11)
