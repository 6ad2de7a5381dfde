"""method = "auto" against the best fixed choice, over the scenes of the library: `python -m benchmarks.method_table`.

At each tolerance the chosen run has an error, from comparison with a run far tighter. The best fixed choice is the
cheapest of all methods and tolerances that errs no more. Both calls of `simulate` are timed whole, in CPU time and in
turns, without estimates and reactions; the least of some turns counts. Where even the tight run is another motion, as
in chaos, nothing is compared.
"""

import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from cross_checks.prices.timing import interleaved
from mbs_ref import Scene, Settings, Trajectory, scenes
from mbs_ref.cores.choice import core_name
from mbs_ref.integrators import DEFAULT, integrators
from mbs_ref.observables.distance import largest, relative
from mbs_ref.simulate import simulate
from mbs_ref.simulate.method_choice import AUTO

ASKED = (1e-4, 1e-6, 1e-8, 1e-10)  # rtol
TRIED = tuple(10.0**-k for k in range(3, 13))
TIGHT = 1e-13
ROUNDOFF = 1e-12  # of the scene: below no error tells one run from another
LOST = 1e-2  # of the scene: where the default at 1e-11 is so far from the tight run, no truth is known
SLOW = 2.0  # s, a call that is not repeated
TURNS = 3
METHODS = ("dop853", "radau", "lsodar", "gauss", "taylor")  # adaptive ones


@dataclass(frozen=True)
class Row:
    """One scene at one tolerance."""

    scene: str
    wanted: float  # rtol
    chosen: str
    error: float  # of the scene, the largest of positions and orientations
    best: str  # method and rtol
    cost_s: float  # CPU, of the call with 'auto'
    ratio: float  # to that of the best fixed choice


def rows(name: str) -> Iterator[Row]:
    """Yield a row for each tolerance, or none where no run can be judged."""
    scene = scenes.make(name)
    tight = _run(scene, DEFAULT if core_name(scene) != "particles" else "gauss", TIGHT)
    if not tight.ok or _error(scene, _run(scene, DEFAULT, 1e-11), tight) > LOST:
        return
    fixed = sorted(
        (_in_turns(scene, (method, rtol))[0], method, rtol, _error(scene, path, tight))
        for method in METHODS if core_name(scene) in (integrators()[method].cores or (core_name(scene),))
        and not any(integrators()[method].refusals(scene))
        for rtol in TRIED if (path := _run(scene, method, rtol)).ok
    )  # fmt: skip
    for wanted in ASKED:
        path = _run(scene, AUTO, wanted)
        error = _error(scene, path, tight)
        fitting = [one for one in fixed if one[3] <= max(error, ROUNDOFF)]
        if not fitting:
            continue
        _, method, rtol, _ = fitting[0]
        own, best = _in_turns(scene, (AUTO, wanted), (method, rtol))
        yield Row(name, wanted, path.method, error, f"{method} {rtol:g}", own, own / best)


def _run(scene: Scene, method: str, rtol: float) -> Trajectory:
    return simulate(scene, Settings(method=method, rtol=rtol, estimate="off", reactions=False))


def _cost(scene: Scene, method: str, rtol: float) -> float:
    """Return the CPU time (s) of a call."""
    began = time.process_time()
    _run(scene, method, rtol)
    return time.process_time() - began


def _in_turns(scene: Scene, *choices: tuple[str, float]) -> list[float]:
    """Return the least CPU time (s) of each choice's calls, in interleaved turns; a slow one takes few."""
    calls = [partial(_cost, scene, *choice) for choice in choices]
    first = [min(times) for times in interleaved(calls, 1)]
    return [min(times) for times in interleaved(calls, TURNS if sum(first) < SLOW else 1)]


def _error(scene: Scene, path: Trajectory, tight: Trajectory) -> float:
    return float(largest(relative(scene, path, tight)[:, :2])) if path.ok else np.inf


def main(names: list[str]) -> None:
    result = []
    for name in names or scenes.names():
        for row in rows(name):
            result.append(row)
            print(f"{row.scene:22s} {row.wanted:6g}  {row.chosen:7s} error {row.error:8.1e}  "
                  f"{row.cost_s * 1e3:9.2f} ms  {row.ratio:5.2f} of {row.best}", flush=True)  # fmt: skip
    ratios = np.sort([row.ratio for row in result])
    print(f"{len(result)} rows: median {np.median(ratios):.2f}, {np.mean(ratios <= 1.3):.0%} at most 1.3, "
          f"largest {ratios[-1]:.2f}")  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1:])
