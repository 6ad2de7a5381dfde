"""Many starts of one chain: a batch against single runs, and against MuJoCo's own batches at equal error."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from cross_checks.engines.mujoco_ import Built, MuJoCo
from cross_checks.engines.mujoco_.run import rolled_out
from cross_checks.workshop.plan import Plan, plan_run
from mbs_ref import scenes
from mbs_ref.cores.system import Poses
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate, simulate_starts
from mbs_ref.trajectory import Trajectory

STARTS, THREADS, DURATION = 400, 2, 1.0  # s
ERROR = 1e-6  # m, the largest over starts and bodies
FINE = 1e-4  # s, step of MuJoCo's own way to the starts
SCENE = scenes.make("pendulum_chain", links=10)
LEAN = Settings(rtol=1e-6, samples=2, t_end=DURATION, estimate="off", reactions=False)


@pytest.fixture(scope="module")
def times() -> np.ndarray:
    return np.round(np.linspace(0.0, DURATION, STARTS) / FINE) * FINE


@pytest.fixture(scope="module")
def starts(times: np.ndarray) -> Poses:
    path = simulate(SCENE, Settings(rtol=1e-12, estimate="off", reactions=False), times)
    return Poses(path.position, path.orientation, path.velocity, path.angular_velocity)


def _one(starts: Poses, k: int) -> Poses:
    return Poses(*(part[k : k + 1] for part in starts))


def _ends(paths: list[Trajectory]) -> np.ndarray:
    return np.array([path.position[-1] for path in paths])


@pytest.mark.parametrize("settings", [LEAN, Settings(t_end=DURATION, estimate="off"), Settings(t_end=DURATION)])
def test_batch_against_single_runs(benchmark, starts, settings):
    def single() -> None:
        for k in range(0, STARTS, 10):
            simulate(SCENE, settings, start=_one(starts, k))

    single()
    spent = []
    for work in (single, lambda: simulate_starts(SCENE, starts, settings, threads=THREADS)):
        wall, cpu = time.perf_counter(), time.process_time()
        work()
        spent.append((time.perf_counter() - wall, time.process_time() - cpu))
    benchmark.pedantic(lambda: simulate_starts(SCENE, starts, settings, threads=THREADS), rounds=3)
    (alone, alone_cpu), (batch, batch_cpu) = spent[0], spent[1]
    ratios = {"throughput": 10.0 * alone / batch, "cpu": 10.0 * alone_cpu / batch_cpu}
    benchmark.extra_info |= ratios
    print(f"{settings.samples} outputs, estimate {settings.estimate}: {ratios}")


def test_batch_against_rollout(benchmark, times, starts):
    fine = Settings(rtol=1e-12, samples=2, t_end=DURATION, estimate="off", reactions=False)
    truth = _ends(simulate_starts(SCENE, starts, fine, threads=THREADS))
    ours, theirs = _cheapest_of_ours(starts, truth), _cheapest_of_theirs(times, truth)
    benchmark.pedantic(lambda: simulate_starts(SCENE, starts, ours[1], threads=THREADS), rounds=3)
    benchmark.extra_info |= {"ours_s": ours[0], "rollout_s": theirs[0], "ratio": ours[0] / theirs[0]}
    print(f"CPU ms a run at {ERROR:g} m: ours {ours[0] * 1e3:.3f} at rtol {ours[1].rtol:g}, "
          f"rollout {theirs[0] * 1e3:.3f} at step {theirs[1]:g}; ratio {ours[0] / theirs[0]:.2f}")  # fmt: skip


def _cheapest_of_ours(starts: Poses, truth: np.ndarray) -> tuple[float, Settings]:
    for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9):
        settings = LEAN.model_copy(update={"rtol": rtol})
        began = time.process_time()
        ends = _ends(simulate_starts(SCENE, starts, settings, threads=THREADS))
        if np.max(np.abs(ends - truth)) <= ERROR:
            return (time.process_time() - began) / STARTS, settings
    raise AssertionError("no tolerance reaches it")


def _cheapest_of_theirs(times: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    engine = MuJoCo()
    way, built = _planned(engine, FINE, times)
    states = engine.advance(built, way).states
    for steps in (100, 200, 400, 800, 1600, 3200, 6400):
        plan, built = _planned(engine, DURATION / steps, np.array([0.0, DURATION]))
        began = time.process_time()
        after = rolled_out(built.model, states, steps, THREADS)
        spent = time.process_time() - began
        ends = engine.poses(built, replace(plan, times=np.zeros(STARTS)), after)[0]
        if np.max(np.abs(ends - truth)) <= ERROR:
            return spent / STARTS, DURATION / steps
    raise AssertionError("no step reaches it")


def _planned(engine: MuJoCo, step: float, times: np.ndarray) -> tuple[Plan, Built]:
    plan = plan_run(engine, SCENE, Settings(method="rk4", step=step), times)
    assert isinstance(plan, Plan)
    return plan, engine.build(SCENE, plan)
