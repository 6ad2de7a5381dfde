"""What the harness adds to a timed loop: the loop time it reports against the bare integrator call, timed outside."""

from __future__ import annotations

import time

import numpy as np

from cross_checks import engines
from cross_checks.judge import ladder
from cross_checks.prices.timing import Sample, compare
from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.integrators import integrators
from mbs_ref.integrators.loop.leg import progress
from mbs_ref.settings import Settings
from mbs_ref.simulate import integration_options

LARGEST = 1.02  # times the bare loop


def test_overhead(benchmark):
    scene, settings = scenes.make("pendulum_chain", links=10), Settings(method="rk4", step=1e-3, reactions=False)
    times, engine = ladder.grid(scene), engines.get("mbs_ref")
    options = integration_options(scene, settings, times)
    system, advance = compile_scene(scene), integrators()["rk4"].advance
    start = system.initial_state()
    system.set_mode_time(0.5)

    def bare() -> Sample:
        y, run = start.copy(), progress(0.0)
        began = time.perf_counter()
        advance(system, options, run, y, np.asarray(times))
        return Sample(time.perf_counter() - began)

    def harness() -> Sample:
        return Sample(engine.run(scene, settings, times).timing.loop_s)

    for run in (bare, harness):  # compile
        run()
    comparisons = []
    benchmark.pedantic(lambda: comparisons.append(compare(bare, harness, limit=LARGEST)), rounds=1)
    (seen,) = comparisons
    benchmark.extra_info |= {"ratio": seen.ratio, "low": seen.low, "high": seen.high}
    print(f"harness {seen.ratio:.4f} times the bare loop [{seen.low:.4f}, {seen.high:.4f}]")
    assert seen.ratio < LARGEST
