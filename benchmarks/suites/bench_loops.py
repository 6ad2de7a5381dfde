"""How the right-hand side of closed loops grows with their number, in the plane and in space."""

from __future__ import annotations

import itertools
import math
from time import process_time

import pytest

from benchmarks.suites.bench_rhs import CALLS, loop
from mbs_ref import scenes

LOOPS: tuple[int, ...] = (20, 100, 400, 1000)
ASKED = 1.1  # largest exponent from the fewest to the most: 1 is linear


@pytest.mark.parametrize("name", ["n_four_bar", "spatial_n_four_bar"])
def test_growth_is_linear(benchmark, name):
    """From interleaved minima of processor time."""
    runs = {loops: loop(scenes.make(name, loops=loops)) for loops in LOOPS}
    best = dict.fromkeys(LOOPS, math.inf)

    def measure():
        for loops, run in runs.items():
            start = process_time()
            run()
            best[loops] = min(best[loops], process_time() - start)

    benchmark.pedantic(measure, rounds=15, warmup_rounds=1)
    per_body = {loops: best[loops] / CALLS / len(scenes.make(name, loops=loops).bodies) * 1e9 for loops in LOOPS}
    exponents = {f"exponent_{a}_{b}": math.log(best[b] / best[a], b / a) for a, b in itertools.combinations(LOOPS, 2)}
    benchmark.extra_info |= exponents | {"ns_per_body": per_body}
    print(f"\n{name}: ns a body { ({k: round(v) for k, v in per_body.items()}) }", exponents)
    assert exponents[f"exponent_{LOOPS[0]}_{LOOPS[-1]}"] <= ASKED
