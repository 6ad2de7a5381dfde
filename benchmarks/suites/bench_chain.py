"""The chain at 1e-6 m: every engine's cheapest setting, in the same run, with its accuracy."""

import pytest

from cross_checks import engines
from cross_checks.isolation.parent import Isolated
from cross_checks.judge import ladder
from cross_checks.judge.runs import Runs
from cross_checks.prices.pick import pick, setting
from cross_checks.prices.sweep import sweep
from mbs_ref import scenes
from mbs_ref.settings import Settings

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
