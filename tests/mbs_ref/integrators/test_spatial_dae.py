"""Methods on the DAE itself in space: generalized-alpha on rotations, DASSL on two index forms."""

from __future__ import annotations

from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.spatial import SpatialSystem
from mbs_ref.integrators.methods.dassl import _Ida, as_dae
from mbs_ref.kernels.answers import FORM
from mbs_ref.kernels.residual import GGL, INDEX_1, residual
from mbs_ref.observables.distance import farthest
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from tests.mbs_ref.cores.every_spatial_part import every_part, general_state

TIMES = np.linspace(0.0, 0.4, 3)
LOOPS = ("torque_free_top", "bricard", "spatial_slider_crank")  # free; redundant; spherical, universal, prismatic


@lru_cache
def exact(name: str) -> Trajectory:
    return simulate(scenes.make(name), Settings(rtol=1e-11, reactions=False, estimate="off"), TIMES)


def gap(name: str, **settings) -> float:
    path = simulate(scenes.make(name), Settings(reactions=False, **settings), TIMES)
    assert path.ok, path.message
    return max(farthest(scenes.make(name), path, exact(name))[:2])


@pytest.mark.parametrize("name", [*LOOPS, "heavy_top"])
def test_generalized_alpha_has_order_two_on_rotations(name):
    halved = gap(name, method="generalized_alpha", step=2e-3) / gap(name, method="generalized_alpha", step=1e-3)
    assert halved == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("method", ["dassl", "dassl_index1"])
def test_dassl_agrees_with_the_reference_in_space(name, method):
    pytest.importorskip("sundials4py")
    coarse, fine = gap(name, method=method, rtol=1e-6), gap(name, method=method, rtol=1e-9)
    assert fine < 1e-6  # a multistep method controls the error of a step, not its sum
    assert fine < 0.05 * coarse


def test_generalized_alpha_closes_the_loops_at_every_step():
    path = simulate(scenes.make("bricard"), Settings(method="generalized_alpha", step=2e-3, t_end=0.4, estimate="off"))
    assert path.step_compliance[:, 1].max() < 1e-11  # m, rad: the iteration's own limit, 1e-12 of the scene's size
    assert np.abs(np.linalg.norm(path.orientation, axis=-1) - 1.0).max() < 1e-12


def test_dassl_is_given_as_many_rows_as_the_mechanism_has_rank():
    """With the redundant rows too, 21 264 steps at this tolerance: off the constraints they contradict each other."""
    system = compile_scene(scenes.make("bricard"))
    y = system.initial_state()
    kept = system.independent_rows(0.0, y)
    assert len(kept) == len(system.rows()) - 1
    assert np.linalg.matrix_rank(system.scaled_jacobian(0.0, y)[kept]) == len(kept)
    pytest.importorskip("sundials4py")
    run = simulate(scenes.make("bricard"), Settings(method="dassl", rtol=1e-6, estimate="off"), TIMES)
    assert run.steps < 500
    assert run.rhs_calls > run.steps


def test_rows_that_are_kept_carry_the_forces_of_those_that_are_not():
    """C_q^T lambda = f - M a, with the multipliers of the kept rows alone."""
    system = compile_scene(scenes.make("bricard"))
    assert isinstance(system, SpatialSystem)
    y = system.initial_state()
    ida = SimpleNamespace(system=system, used=system.independent_rows(0.0, y))
    lam = _Ida._multipliers(ida, y, 0.0)  # type: ignore[arg-type]
    wanted = system.applied_forces(0.0, y).ravel() - system.mass_matrix() @ system.accelerations(0.0, y).ravel()
    assert len(lam) == len(system.rows()) - 1
    assert np.abs(wanted).max() > 1.0
    np.testing.assert_allclose(system.jacobian(0.0, y)[ida.used].T @ lam, wanted, atol=1e-11 * np.abs(wanted).max())


def test_raw_index_3_stops_in_space_too_and_says_so():
    pytest.importorskip("sundials4py")
    run = simulate(scenes.make("heavy_top"), Settings(method="dassl_index3", rtol=1e-8, estimate="off"))
    assert not run.ok
    assert "t = " in run.message
    assert "iteration" in run.message or "error test" in run.message


def test_the_residual_vanishes_on_the_motion_of_every_part():
    """With the accelerations and multipliers of the ODE form, and not with others."""
    system = compile_scene(every_part())
    system.prepare(FORM)
    y, t = general_state(system), 0.37
    dy, lam = system.derivative(t, y), system.multipliers(t, y)
    x, rates = np.concatenate((y, lam)), np.concatenate((dy, 0.0 * lam))
    out = np.empty_like(x)
    dae = as_dae(system, INDEX_1, np.arange(len(lam)), 0.0)
    residual(dae, t, x, rates, out)
    size = np.abs(system.applied_forces(t, y)).max()
    assert np.abs(out).max() < 1e-10 * size
    residual(dae, t, x, rates + 1e-3, out)
    assert np.abs(out).max() > 1e-4


def test_mu_moves_places_as_lambda_pushes():
    """M v' = f - C_q^T lambda and q' = v - C_q^T mu (Gear, Gupta and Leimkuhler 1985): the same rows, the same sign."""
    system = compile_scene(scenes.make("slider_crank"))
    system.prepare(FORM)
    y, rows = system.initial_state(), len(system.rows())
    start, force = system.n_positions, np.random.default_rng(4).standard_normal(rows)
    dae = as_dae(system, GGL, np.arange(rows), 0.0)
    x = np.concatenate((y, np.zeros(2 * rows)))
    pulled, moved = x.copy(), x.copy()
    pulled[len(y) : len(y) + rows] = force
    moved[len(y) + rows :] = force
    plain, by_lambda, by_mu = (np.empty_like(x) for _ in range(3))
    for state, out in ((x, plain), (pulled, by_lambda), (moved, by_mu)):
        residual(dae, 0.0, state, np.zeros_like(x), out)
    wanted = system.jacobian(0.0, y).T @ force
    np.testing.assert_allclose((by_lambda - plain)[start : len(y)], wanted, atol=1e-12)
    np.testing.assert_allclose((by_mu - plain)[:start], wanted, atol=1e-12)


@pytest.mark.parametrize("settings", [{"method": "generalized_alpha", "step": 2e-5}, {"method": "dassl", "rtol": 1e-8}])
def test_a_bounce_in_space_agrees_with_the_reference(settings):
    pytest.importorskip("sundials4py")
    scene = scenes.make("bouncing_sphere")
    truth = simulate(scene, Settings(rtol=1e-11, estimate="off"), TIMES)
    path = simulate(scene, Settings(**settings), TIMES)
    assert path.ok, path.message
    assert path.events == truth.events
    assert np.abs(path.position - truth.position).max() < 1e-6


@pytest.mark.parametrize("settings", [{"method": "generalized_alpha", "step": 1e-3}, {"method": "dassl"}])
def test_sticking_in_space_is_refused_by_name(settings):
    with pytest.raises(ValueError, match=r"cannot run 'rolling_sphere': contacts 'ground' stick in space"):
        simulate(scenes.make("rolling_sphere"), Settings(**settings))
