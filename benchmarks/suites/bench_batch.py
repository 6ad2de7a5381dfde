"""Many starts of one chain: a batch against single runs, and against MuJoCo's own batches at equal error.

`python -m pytest -s benchmarks/suites/bench_batch.py` prints throughput and CPU time, the medians of interleaved pairs.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import median

import numpy as np
import pytest

from cross_checks.engine import Plan, plan_run
from cross_checks.engines.mujoco_ import Built, MuJoCo, rolled_out
from mbs_ref import Settings, Trajectory, scenes
from mbs_ref.cores.system import Poses
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.simulate import simulate, simulate_starts
from mbs_ref.simulate.many.lanes import NOTE

STARTS, THREADS, DURATION = 1000, 2, 1.0  # s
ROUNDS = 5  # of interleaved pairs
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
    return Poses.of(path)


def _ends(paths: list[Trajectory]) -> np.ndarray:
    return np.array([path.position[-1] for path in paths])


def _batch(starts: Poses, settings: Settings, lanes: bool) -> list[Trajectory]:
    return simulate_starts(SCENE, starts, settings, threads=THREADS, lanes=lanes)


@pytest.mark.parametrize("lanes", [False, True], ids=["threads", "lanes"])
@pytest.mark.parametrize("settings", [LEAN, Settings(t_end=DURATION, estimate="off"), Settings(t_end=DURATION)])
def test_batch_against_single_runs(benchmark, starts, settings, lanes):
    def single() -> None:
        for k in range(0, STARTS, 10):
            simulate(SCENE, settings, start=Poses(*(part[k : k + 1] for part in starts)))

    single()
    _batch(starts, settings, lanes)
    wall, cpu = np.median([_ratios(single, lambda: _batch(starts, settings, lanes)) for _ in range(ROUNDS)], axis=0)
    benchmark.pedantic(lambda: _batch(starts, settings, lanes), rounds=3)
    ratios = {"throughput": 10.0 * wall, "cpu": 10.0 * cpu}
    benchmark.extra_info |= ratios
    print(f"{settings.samples} outputs, estimate {settings.estimate}, {'lanes' if lanes else 'threads'}: {ratios}")


FAMILIES = {  # a scene, its parameters, and the time (s) of its runs
    "balls": ("spatial_chain", {"links": 10}, 1.0),
    "closed loops": ("n_four_bar", {"loops": 4}, 1.0),
    "closed loops in space": ("spatial_slider_crank", {}, 1.0),
    "a ball on a floor": ("bouncing_ball", {}, 0.4),
    "a crash": ("android_simplified", {}, 0.12),
}


@pytest.mark.parametrize("family", FAMILIES)
def test_lanes_of_each_family(family):
    name, parameters, duration = FAMILIES[family]
    scene, settings = scenes.make(name, **parameters), Settings(t_end=duration)
    path = simulate(scene, Settings(t_end=0.5 * duration, samples=64, rtol=1e-9, estimate="off", reactions=False))
    starts = Poses.of(path)

    def single() -> None:
        for k in range(0, len(path.times), 4):
            simulate(scene, settings, start=Poses(*(part[k : k + 1] for part in starts)))

    def lanes() -> list[Trajectory]:
        return simulate_starts(scene, starts, settings, threads=1, lanes=True)

    single()
    assert all(one.notes[0].startswith(NOTE) for one in lanes())
    cpu = median(_ratios(single, lanes)[1] for _ in range(ROUNDS))
    print(f"{family}, {settings.samples} outputs, estimate on: CPU {4.0 * cpu:.2f} times that of single runs (aim 8)")


def _ratios(first: Callable[[], object], second: Callable[[], object]) -> tuple[float, float]:
    """Return the first's time over the second's: wall, CPU."""
    spent = []
    for work in (first, second):
        wall, cpu = time.perf_counter(), time.process_time()
        work()
        spent.append((time.perf_counter() - wall, time.process_time() - cpu))
    return spent[0][0] / spent[1][0], spent[0][1] / spent[1][1]


@pytest.mark.parametrize("lanes", [False, True], ids=["threads", "lanes"])
def test_batch_against_rollout(benchmark, times, starts, lanes):
    fine = Settings(rtol=1e-12, samples=2, t_end=DURATION, estimate="off", reactions=False)
    truth = _ends(_batch(starts, fine, lanes=False))
    ours, (step, theirs) = _coarsest_of_ours(starts, truth, lanes), _coarsest_of_theirs(times, truth)
    wall, cpu = np.median([_ratios(lambda: _batch(starts, ours, lanes), theirs) for _ in range(ROUNDS)], axis=0)
    benchmark.pedantic(lambda: _batch(starts, ours, lanes), rounds=3)
    benchmark.extra_info |= {"wall_ratio": wall, "cpu_ratio": cpu, "rtol": ours.rtol, "step": step}
    print(f"{'lanes' if lanes else 'threads'} at {ERROR:g} m, ours over rollout: wall {wall:.3f}, CPU {cpu:.3f}; "
          f"rtol {ours.rtol:g}, step {step:g} s")  # fmt: skip


def _coarsest_of_ours(starts: Poses, truth: np.ndarray, lanes: bool) -> Settings:
    for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9):
        settings = LEAN.model_copy(update={"rtol": rtol})
        if farthest(SCENE, Partial(_ends(_batch(starts, settings, lanes))), Partial(truth))[0] <= ERROR:
            return settings
    raise AssertionError("no tolerance reaches it")


def _coarsest_of_theirs(times: np.ndarray, truth: np.ndarray) -> tuple[float, Callable[[], np.ndarray]]:
    """Return the step (s) that reaches the error, and the work."""
    engine = MuJoCo()
    way, built = _planned(engine, FINE, times)
    states = engine.advance(built, way).states
    for steps in (100, 200, 400, 800, 1600, 3200, 6400):
        plan, built = _planned(engine, DURATION / steps, np.array([0.0, DURATION]))
        after = rolled_out(built.model, states, steps, THREADS)
        ends = engine.poses(built, replace(plan, times=np.zeros(STARTS)), after)[0]
        if farthest(SCENE, Partial(ends), Partial(truth))[0] <= ERROR:
            return DURATION / steps, partial(rolled_out, built.model, states, steps, THREADS)
    raise AssertionError("no step reaches it")


def _planned(engine: MuJoCo, step: float, times: np.ndarray) -> tuple[Plan, Built]:
    plan = plan_run(engine, SCENE, Settings(method="rk4", step=step), times)
    assert isinstance(plan, Plan)
    return plan, engine.build(SCENE, plan)
