"""One right-hand side of the planar core: time per body, and how it grows."""

from __future__ import annotations

import itertools
import math
from timeit import timeit

import pytest

from mbs_ref import scenes
from mbs_ref.cores import compile_scene
from mbs_ref.kernels import core
from mbs_ref.kernels.jit import jit

CALLS = 200  # of the right-hand side inside compiled code, so that no Python call is timed


@jit
def repeat(model, work, y, dy, count):
    for _ in range(count):
        core.derivative(model, work, 0.0, y, dy)


def loop(links: int):
    """Return a function that evaluates CALLS right-hand sides of a chain."""
    system = compile_scene(scenes.make("pendulum_chain", links=links))
    system.set_mode_time(0.0)
    y = system.initial_state()
    dy = y.copy()
    repeat(system.model, system.work, y, dy, 1)
    return lambda system=system: repeat(system.model, system.work, y, dy, CALLS)


@pytest.mark.parametrize("links", [10, 100, 1000])
def test_right_hand_side(benchmark, links):
    benchmark.pedantic(loop(links), rounds=50, warmup_rounds=3)
    benchmark.extra_info["ns_per_body"] = benchmark.stats.stats.min / CALLS / links * 1e9


def test_growth_is_linear(benchmark):
    """Exponent of the time from 100 to 1000 bodies, from interleaved minima."""
    loops = {links: loop(links) for links in (100, 1000)}
    best = dict.fromkeys(loops, math.inf)

    def measure():
        for links, run in loops.items():
            best[links] = min(best[links], timeit(run, number=1))

    benchmark.pedantic(measure, rounds=50, warmup_rounds=2)
    (few, short), (many, long) = best.items()
    exponents = {f"exponent_{a}_{b}": math.log(best[b] / best[a], b / a) for a, b in itertools.pairwise(best)}
    per_body = {few: short / CALLS / few * 1e9, many: long / CALLS / many * 1e9}
    benchmark.extra_info |= exponents | {"ns_per_body": per_body}
    assert exponents["exponent_100_1000"] <= 1.1
