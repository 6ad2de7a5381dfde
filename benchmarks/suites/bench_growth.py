"""The chain at one error by every engine, the growth of a track and of a link, and what a default call costs.

`python -m pytest -s -m '' -p no:xdist benchmarks/suites/bench_growth.py` prints a line a scene.
"""

import time
from functools import partial
from statistics import median
from typing import Any

import pytest

from cross_checks import engines
from cross_checks.isolation.parent import Isolated
from cross_checks.judge import ladder
from cross_checks.judge.runs import Runs
from cross_checks.prices.pick import pick, setting
from cross_checks.prices.sweep import sweep
from cross_checks.prices.timing import interleaved
from mbs_ref import Settings, scenes
from mbs_ref.simulate import simulate
from mbs_ref.simulate.one_run import compiled, run_legs, start_run

ERROR = 1e-6  # of the scene


@pytest.mark.parametrize("links", [10, 100])
@pytest.mark.parametrize("engine", engines.names())
def test_chain_at_equal_error(benchmark, engine, links):
    scene = scenes.make("pendulum_chain", links=links)
    with Isolated(timeout=30.0) as call:
        best = pick(sweep(Runs(call=call), scene, [engine], targets=(ERROR,)), ERROR).best
    if best is None:
        pytest.skip(f"{engine} does not reach {ERROR:g} with {links} links")
    solver, chosen, times = engines.get(engine), Settings(**best.settings), ladder.grid(scene)
    assert best.error is not None
    loops = []
    benchmark.pedantic(lambda: loops.append(solver.run(scene, chosen, times).timing.loop_s), rounds=5, warmup_rounds=1)
    benchmark.extra_info |= {
        "links": links, "engine": engine, "setting": setting(best), "loop_s": min(loops),
        "error": best.error.value, "truth_uncertainty": best.error.uncertainty,
        "compliance": best.measure("compliance_position"),
    }  # fmt: skip


ROUNDS = 5
DRIVE = Settings(method="dop853", rtol=1e-6, t_end=0.1, samples=2)
LINKS, ASKED = (50, 100), 2.5  # largest ratio: 2 is linear
PAPERS = Settings(method="rk4", step=5e-5, t_end=0.5, samples=2, estimate="off")
HELD = 3.0  # largest ratio of wheels held on the links by constraints (Fox 2001) to wheels on springs


def in_turns(benchmark, settings: Settings, *parameters: dict) -> list[float]:
    """Return the least time (s) of the loop for each choice of the scene's parameters."""
    runs = [
        partial(simulate, scenes.make("tracked_vehicle", model="paper", **chosen), settings) for chosen in parameters
    ]
    paths = benchmark.pedantic(interleaved, args=(runs, ROUNDS), rounds=1, warmup_rounds=1)
    assert all(path.ok for built in paths for path in built)
    return [min(path.timing.loop_s for path in built) for built in paths]


def test_the_cost_of_a_track_grows_linearly(benchmark):
    short, long = in_turns(benchmark, DRIVE, *({"links": links} for links in LINKS))
    benchmark.extra_info |= {"links": LINKS, "loop_s": (short, long), "ratio": long / short, "asked": ASKED}
    assert long / short <= ASKED


def test_contacts_on_constraints_cost_little_more_than_on_springs(benchmark):
    soft, held = in_turns(benchmark, PAPERS, {"law": "spring_damper"}, {"law": "constraint"})
    benchmark.extra_info |= {"loop_s": (soft, held), "ratio": held / soft, "asked": HELD}
    assert held / soft <= HELD


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
    # the same steps: a longer chain needs more of them at one tolerance
    work: dict[str, Any] = {"method": "rk4", "step": 5e-4, "t_end": 0.05, "samples": 2}
    chosen = Settings(coordinates="relative", estimate="off", reactions=False, **work)
    few, many = benchmark.pedantic(lambda: [times("spatial_chain", n, chosen)[0] / n for n in (100, 1000)], rounds=1)
    print(f"\nspatial chain, relative: a link of 1000 costs {many / few:.2f} times one of 100 (aim 1.1)")
