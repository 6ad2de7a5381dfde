"""One right-hand side of each core: time per body, how it grows, and how exactly it solves its equations."""

import itertools
import math
from collections.abc import Callable
from functools import partial
from time import process_time

import numpy as np
import pytest

from benchmarks.trees.worker import right_hand_sides
from cross_checks.prices.timing import interleaved
from mbs_ref import Scene, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.planar import PlanarSystem
from mbs_ref.cores.spatial import SpatialSystem
from mbs_ref.scene.celestial import Newton
from mbs_ref.scene.euler_parameters import rotation_matrices

CALLS = 200  # of the right-hand side inside compiled code, so that no Python call is timed
ROUNDS = 30  # of interleaved runs
LOOPS = ((20, 100, 400, 1000), "loops")
GROWING = {"pendulum_chain": ((100, 1000), "links"), "n_four_bar": LOOPS, "spatial_n_four_bar": LOOPS}
LINEAR = 1.1  # largest exponent from the fewest to the most: 1 is linear
SOLVED = 1e-9  # m/s^2 or rad/s^2: what roundoff leaves of accelerations of some ten, over chains of a thousand


def loop(scene: Scene):
    """Return a function that evaluates CALLS right-hand sides."""
    run, _ = right_hand_sides(scene)
    run(1)  # compile
    return partial(run, CALLS)


def chain(links: int) -> Scene:
    return scenes.make("pendulum_chain", links=links)


def planar_residual(scene: Scene) -> float:
    """Return the largest residual of M a + C_q^T lambda = Q and C_q a = gamma, as an acceleration."""
    system = PlanarSystem(scene)
    system.set_mode_time(0.0)
    y = system.initial_state()
    half = len(y) // 2
    force = system.applied_forces(0.0, y).ravel()
    mass, jacobian, gamma = system.mass_matrix(), system.jacobian(0.0, y), system.right_side()
    a, lam = system.derivative(0.0, y)[half:], system.multipliers(0.0, y)
    left = np.concatenate(((mass * a + jacobian.T @ lam - force) / mass, jacobian @ a - gamma))
    return float(np.max(np.abs(left)))


def spatial_residual(scene: Scene) -> float:
    """Return the largest residual of C_q a = gamma."""
    system = SpatialSystem(scene)
    system.set_mode_time(0.0)
    y = system.initial_state()
    places, rates = y[: system.n_positions].reshape(-1, 7), system.derivative(0.0, y)[system.n_positions :]
    a = rates.reshape(-1, 6).copy()
    for k, place in enumerate(places):
        a[k, 3:] = rotation_matrices(place[3:]) @ a[k, 3:]  # from body axes to world axes
    return float(np.max(np.abs(system.jacobian(0.0, y) @ a.ravel() - system.right_side())))


def particle_residual(scene: Scene) -> float:
    """Compare with Newton's sum in extended precision; the largest difference (m/s^2)."""
    system = compile_scene(scene)
    (newton,) = (load for load in scene.loads if isinstance(load, Newton))
    y = system.initial_state()
    q = y[: len(y) // 2].reshape(-1, 3).astype(np.longdouble)
    gap = q[None] - q[:, None]
    cubed = np.sum(gap**2, axis=2) ** np.longdouble(1.5)
    np.fill_diagonal(cubed, np.inf)
    a = np.sum(np.array(newton.gm)[None, :, None] * gap / cubed[:, :, None], axis=1)
    return float(np.max(np.abs(system.derivative(0.0, y)[len(y) // 2 :] - a.ravel())))


KERNELS = {
    "planar-10": (lambda: chain(10), planar_residual),
    "planar-100": (lambda: chain(100), planar_residual),
    "planar-1000": (lambda: chain(1000), planar_residual),
    "spatial-10": (lambda: scenes.make("spatial_chain", links=10), spatial_residual),
    "spatial-100": (lambda: scenes.make("spatial_chain", links=100), spatial_residual),
    "particles": (lambda: scenes.make("outer_solar_system"), particle_residual),
}


@pytest.mark.parametrize("kernel", KERNELS)
def test_right_hand_side(benchmark, kernel):
    make, residual = KERNELS[kernel]
    scene = make()
    benchmark.pedantic(loop(scene), rounds=50, warmup_rounds=3)
    seconds = benchmark.stats.stats.min / CALLS
    left = residual(scene)
    benchmark.extra_info |= {"loop_s": seconds, "ns_per_body": seconds / len(scene.bodies) * 1e9, "error_mps2": left}
    assert left < SOLVED


@pytest.mark.parametrize("name", GROWING)
def test_growth_is_linear(benchmark, name):
    """Exponents of the processor time a right-hand side, from interleaved minima."""
    sizes, parameter = GROWING[name]
    built = {size: scenes.make(name, **{parameter: size}) for size in sizes}
    runs = [partial(_processor_time, loop(scene)) for scene in built.values()]
    times = benchmark.pedantic(interleaved, args=(runs, ROUNDS), rounds=1, warmup_rounds=1)
    best = {size: min(own) for size, own in zip(sizes, times, strict=True)}
    per_body = {size: best[size] / CALLS / len(scene.bodies) * 1e9 for size, scene in built.items()}
    exponents = {f"exponent_{a}_{b}": math.log(best[b] / best[a], b / a) for a, b in itertools.combinations(sizes, 2)}
    benchmark.extra_info |= exponents | {"ns_per_body": per_body}
    print(f"\n{name}: ns a body { ({k: round(v) for k, v in per_body.items()}) }", exponents)
    assert exponents[f"exponent_{sizes[0]}_{sizes[-1]}"] <= LINEAR


def _processor_time(run: Callable[[], None]) -> float:
    began = process_time()
    run()
    return process_time() - began
