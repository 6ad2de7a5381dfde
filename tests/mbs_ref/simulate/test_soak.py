"""Growing sizes and growing times: nothing breaks, drifts or leaks on the way. Run by `make nightly`."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from mbs_ref import observables, scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

pytestmark = pytest.mark.slow
LEAK = 4 * 2**20  # bytes a million steps may add to resident memory: what an allocator keeps for itself
MEMORY = """
import sys
from cross_checks.isolation.parent import resident
import os
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
scene = scenes.make(sys.argv[1], links=3)
def run(steps, times=1):
    for _ in range(times):
        path = simulate(scene, Settings(method="rk4", step=1e-5, t_end=1e-5 * steps, samples=2, estimate="off"))
        assert path.ok and path.steps >= steps, path.message
run(10_000, 3)
before = resident(os.getpid())
run(int(sys.argv[2]), int(sys.argv[3]))
print(resident(os.getpid()) - before)
"""


def grown(scene: str, steps: int, times: int) -> int:
    words = [sys.executable, "-c", MEMORY, scene, str(steps), str(times)]
    return int(subprocess.run(words, capture_output=True, text=True, check=True).stdout)


@pytest.mark.parametrize("scene", ["pendulum_chain", "spatial_chain"])
def test_memory_is_flat_over_a_million_steps(scene, capsys):
    added = grown(scene, 1_000_000, 1)
    with capsys.disabled():
        print(f"\n{scene}: 1e6 steps added {added / 2**20:.2f} MiB")
    assert added < LEAK


@pytest.mark.parametrize("scene", ["pendulum_chain", "spatial_chain"])
def test_memory_is_flat_over_many_runs(scene, capsys):
    added = grown(scene, 10, 300)
    with capsys.disabled():
        print(f"\n{scene}: 300 runs added {added / 2**20:.2f} MiB")
    assert added < LEAK


@pytest.mark.parametrize("links", [10, 100, 1000, 10_000])
def test_chains_grow(links, capsys):
    scene = scenes.make("pendulum_chain", links=links)
    path = simulate(scene, Settings(rtol=1e-9, t_end=0.02, samples=3, reactions=False, estimate="off"))
    assert path.ok, path.message
    energy = observables.energy_balance(scene, path)
    scale = np.abs(observables.kinetic_energy(scene, path)).max()
    drift, gap = np.abs(energy.drift).max() / scale, np.abs(observables.constraint_residual(scene, path)).max()
    with capsys.disabled():
        print(f"\n{links} links: {path.steps} steps, energy {drift:.1e} of the kinetic, |C| {gap:.1e} m, "
              f"build {path.timing.build_s:.2f} s, loop {path.timing.loop_s:.2f} s")  # fmt: skip
    assert drift < 1e-6
    assert gap < 1e-11 * links


@pytest.mark.parametrize("t_end", [10.0, 100.0, 1000.0])
def test_times_grow(t_end, capsys):
    scene = scenes.make("n_four_bar", loops=2)
    path = simulate(scene, Settings(rtol=1e-10, t_end=t_end, samples=101, reactions=False, estimate="off"))
    assert path.ok, path.message
    drift = float(np.abs(observables.energy_balance(scene, path).drift).max())
    gap = float(np.abs(observables.constraint_residual(scene, path)).max())
    with capsys.disabled():
        print(f"\n{t_end:g} s of two four-bars: {path.steps} steps, energy {drift:.1e} J, |C| {gap:.1e} m")
    assert drift < 1e-8 * t_end
    assert gap < 1e-11
