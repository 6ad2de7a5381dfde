"""What a default call costs over its loop, and how the cost of a link grows in space: medians of processor time.

`python -m pytest -s -m '' -p no:xdist benchmarks/suites/bench_calls.py` prints a line a scene.
"""

import time
from statistics import median

import pytest

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.one_run import compiled, run_legs, start_run

TURNS = 9
COORDINATES = ("cartesian", "relative")


def times(name: str, links: int, chosen: Settings) -> tuple[float, float]:
    """Return the medians of a whole call and of its loop (s)."""
    scene, calls, loops = scenes.make(name, links=links), [], []
    plan, system, _ = compiled(scene, chosen, None)
    for _ in range(TURNS + 1):  # the first compiles
        began = time.process_time()
        simulate(scene, chosen)
        calls.append(time.process_time() - began)
        y = system.initial_state()
        start_run(system, plan, y)
        began = time.process_time()
        run_legs(system, plan, y)
        loops.append(time.process_time() - began)
    return median(calls[1:]), median(loops[1:])


@pytest.mark.parametrize("coordinates", COORDINATES)
@pytest.mark.parametrize("links", [10, 100, 300])
def test_default_call_over_its_loop(benchmark, coordinates, links):
    chosen = Settings(coordinates=coordinates)
    call, loop = benchmark.pedantic(lambda: times("pendulum_chain", links, chosen), rounds=1)
    print(f"\nchain {links}, {coordinates}: call {1e3 * call:.3g} ms, {call / loop:.2f} times its loop (aim 2)")


def test_growth_of_a_link(benchmark):
    chosen = Settings(coordinates="relative", estimate="off", reactions=False, samples=2, t_end=0.05)
    few, many = benchmark.pedantic(lambda: [times("spatial_chain", n, chosen)[0] / n for n in (100, 1000)], rounds=1)
    print(f"\nspatial chain, relative: a link of 1000 costs {many / few:.2f} times one of 100 (aim 1.1)")
