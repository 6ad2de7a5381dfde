"""Copies of the source tree, unchanged or with a kernel slowed by a known share, to test the regression verdicts:

mbs-ref compare . --slowed 15 --only "links=10 mbs_ref dop853"
"""

import ast
import shutil
from functools import partial
from pathlib import Path

from benchmarks.trees.regression import Case, Tree, cheapest
from cross_checks.prices.timing import interleaved

HERE = Path(__file__).parents[2]
PACKAGES = ("mbs_ref", "cross_checks", "benchmarks")
KERNEL = Path("mbs_ref/kernels/planar/dynamics.py")
FIRST_GUESS = 50  # turns: a few hundred nanoseconds
NEAR = 0.02  # of the unslowed time: calibrated well enough
ROUNDS = 4  # of calibration, each with a compilation
RUNS = 60  # of each tree a round, of which the fastest counts
FUNCTION = "planar_derivative"
# A chain of square roots cannot be shortened; it starts from the state and its end is used, so no compiler may
# compute it beforehand or drop it; it stays small, so that results do not change. It stands inside the function: a
# second function around it is not inlined as the first was, and that alone costs more than is requested.
BUSY = """
    x = y[0] * y[0]
    for _ in range({turns}):
        x = np.sqrt(x + 1.0)
    if x > 1e100:
        dy[0] = x
"""


def copy_tree(target: Path) -> Path:
    """Copy the packages of this tree into a new folder; return it."""
    for package in PACKAGES:
        shutil.copytree(HERE / package, target / package, ignore=shutil.ignore_patterns("__pycache__"))
    return target


def slow_down(folder: Path, turns: int) -> None:
    """Add `turns` square roots to every right-hand side of the planar core."""
    kernel = (HERE / KERNEL).read_text()
    function = next(n for n in ast.parse(kernel).body if isinstance(n, ast.FunctionDef) and n.name == FUNCTION)
    lines = kernel.splitlines(keepends=True)
    lines.insert(function.end_lineno or 0, BUSY.format(turns=turns).lstrip("\n"))
    (folder / KERNEL).write_text("".join(lines))


def calibrate(folder: Path, case: Case, share: float) -> tuple[int, float]:
    """Slow a copy of this tree until the case takes `share` more time; return the turns and the share measured."""
    turns, measured = FIRST_GUESS, 0.0
    for _ in range(ROUNDS):
        slow_down(folder, turns)
        with Tree(HERE) as before, Tree(folder) as after:
            measured = excess(before, after, case)
        if abs(measured - share) < NEAR:
            break
        turns = max(1, round(turns * share / max(measured, share / 10.0)))
    return turns, measured


def excess(before: Tree, after: Tree, case: Case) -> float:
    """Return by how much of the first tree's time the second takes longer: fastest of many alternating runs."""
    settings = cheapest(before.climb(**case.what, method=case.method), case.error)
    if settings is None:
        raise ValueError(f"no setting of {case.name} reaches {case.error:g} of the scene")
    runs = [partial(tree.time, **case.what, settings=settings) for tree in (before, after)]
    for run in runs:
        run()  # compile
    old, new = (min(sample.loop_s for sample in samples) for samples in interleaved(runs, RUNS))
    return new / old - 1.0
