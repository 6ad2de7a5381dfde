"""The timing protocol: false alarms and misses, trees whose verdict is known, and what the harness adds to a loop."""

import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from benchmarks.trees.regression import CASES, Finding, regressions
from benchmarks.trees.slowed import HERE, calibrate, copy_tree
from cross_checks import engines
from cross_checks.judge import ladder
from cross_checks.prices.timing import Pace, Sample, compare
from mbs_ref import Settings, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.integrators import integrators
from mbs_ref.integrators.loop.leg import progress
from mbs_ref.kernels.jit import jit
from mbs_ref.simulate import integration_options

IDENTICAL, SLOWED = 40, 20  # comparisons
WORK = 200_000  # turns of the loop, about a millisecond


@jit
def spin(turns):
    total = 0.0
    for k in range(turns):
        total += np.sin(total + k)
    return total


def timed(turns: int):
    def run() -> Sample:
        wall, cpu = time.perf_counter(), time.process_time()
        spin(turns)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        return Sample(wall, cpu / wall)

    return run


def test_false_alarms_and_found_slowdowns(benchmark):
    spin(1)
    paces: dict[str, list[Pace]] = {}

    def measure():
        paces["same"] = [compare(timed(WORK), timed(WORK), seed).pace for seed in range(IDENTICAL)]
        paces["slower"] = [compare(timed(WORK), timed(WORK * 11 // 10), seed).pace for seed in range(SLOWED)]

    benchmark.pedantic(measure, rounds=1)
    alarms = sum(pace in (Pace.SLOWER, Pace.FASTER) for pace in paces["same"])
    hits = paces["slower"].count(Pace.SLOWER)
    benchmark.extra_info |= {"false_alarms": f"{alarms}/{IDENTICAL}", "found": f"{hits}/{SLOWED}"}
    print(f"false alarms {alarms} of {IDENTICAL}, +10 % detected {hits} of {SLOWED}")
    assert alarms < 0.05 * IDENTICAL
    assert hits >= 0.9 * SLOWED


CASE = CASES[0]
TIMES = 10
SHARE = 0.15  # of the loop time


def verdicts(folder: Path) -> list[Finding]:
    """Compare this tree with the folder as `mbs-ref compare` does, each time with processes and an order of its own."""
    return [finding for seed in range(TIMES) for finding in regressions(HERE, folder, [CASE], seed=seed)]


def counts_of(benchmark, findings: list[Finding], **facts: float) -> Counter[str]:
    counts = Counter(str(finding.verdict) for finding in findings)
    benchmark.extra_info |= {"verdicts": dict(counts), **facts}
    for finding in findings:
        print(f"{finding.verdict}: {finding.sentence}")
    return counts


@pytest.fixture
def copy(tmp_path) -> Path:
    return copy_tree(tmp_path / "copy")


def test_an_unchanged_copy_is_called_same(benchmark, copy):
    findings: list[Finding] = []
    benchmark.pedantic(lambda: findings.extend(verdicts(copy)), rounds=1)
    assert counts_of(benchmark, findings)[Pace.SAME] == TIMES


def test_a_slowed_kernel_is_called_slower(benchmark, copy):
    turns, share = calibrate(copy, CASE, SHARE)
    print(f"slowed by {share:.1%} with {turns} square roots a right-hand side")
    findings: list[Finding] = []
    benchmark.pedantic(lambda: findings.extend(verdicts(copy)), rounds=1)
    assert counts_of(benchmark, findings, share=share)[Pace.SLOWER] == TIMES


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
