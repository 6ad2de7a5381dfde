"""method = "auto" against the best fixed choice, over the scenes of the library: `python -m benchmarks.method_table`.

At each tolerance the chosen run has an error, from comparison with a run far tighter. The best fixed choice is the
cheapest of all methods and tolerances that errs no more: one call of each shows the few cheapest, whose calls are then
timed in turns with the chosen one. A method ends at the tolerance where a call costs far more than all chosen ones.
Calls of `simulate` are timed whole, in CPU time, without estimates and reactions;
the least of some turns counts. Where even the tight run is another motion, as in chaos, nothing is compared.
"""

import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

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
TURNS = 5
FEW = 4  # fixed choices, the cheapest, that are timed in turns
FAR = 4.0  # times the largest cost of a chosen run: a method that costs more is not tried with smaller tolerances
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
    asked = {wanted: _called(scene, AUTO, wanted) for wanted in ASKED}
    fixed = sorted(_fixed(scene, tight, FAR * max(cost for cost, _ in asked.values())))
    for wanted, (_, path) in asked.items():
        error = _error(scene, path, tight)
        fitting = [choice for _, choice, one in fixed if one <= max(error, ROUNDOFF)][:FEW]
        if not fitting:
            continue
        own, *others = _in_turns(scene, (AUTO, wanted), *fitting)
        best, (method, rtol) = min(zip(others, fitting, strict=True))
        yield Row(name, wanted, path.method, error, f"{method} {rtol:g}", own, own / best)


def _fixed(scene: Scene, tight: Trajectory, most: float) -> Iterator[tuple[float, tuple[str, float], float]]:
    """Yield the CPU time (s) of a call, method and rtol, and the error of each fixed choice, up to `most` s."""
    core = core_name(scene)
    for name, one in integrators().items():
        if name in METHODS and core in (one.cores or (core,)) and not any(one.refusals(scene)):
            for rtol in TRIED:
                cost, path = _called(scene, name, rtol)
                if path.ok:
                    yield cost, (name, rtol), _error(scene, path, tight)
                if cost > most:
                    break


def _run(scene: Scene, method: str, rtol: float) -> Trajectory:
    return simulate(scene, Settings(method=method, rtol=rtol, estimate="off", reactions=False))


def _called(scene: Scene, method: str, rtol: float) -> tuple[float, Trajectory]:
    """Return the CPU time (s) of a call, and the run."""
    began = time.process_time()
    path = _run(scene, method, rtol)
    return time.process_time() - began, path


def _in_turns(scene: Scene, *choices: tuple[str, float]) -> list[float]:
    """Return the least CPU time (s) of each choice's calls, in interleaved turns; slow ones take one."""
    calls = [lambda choice=choice: _called(scene, *choice)[0] for choice in choices]
    first = [min(times) for times in interleaved(calls, 1)]
    return first if sum(first) >= SLOW else [min(times) for times in interleaved(calls, TURNS)]


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
