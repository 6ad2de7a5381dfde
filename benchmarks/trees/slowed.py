"""Copies of the source tree: unchanged, or with a kernel slowed by a known share, to try the regression verdicts on.

python -m benchmarks.trees.slowed FOLDER --percent 15 --only "links=10 mbs_ref dop853"
mbs-ref compare . FOLDER --only "links=10 mbs_ref dop853"
"""

from __future__ import annotations

import ast
import random
import shutil
from pathlib import Path

import click

from benchmarks.trees.regression import CASES, Case, cheapest
from benchmarks.trees.tree import Tree

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
# second function around it is not inlined as the first was, and that alone costs more than is asked for.
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
    """Let every right-hand side of the planar core turn in a loop for `turns` square roots."""
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
        raise ValueError(f"no setting of {case.name} reaches {case.error:g} m")
    order, loops = random.Random(0), {before: [], after: []}
    for tree in (before, after):
        tree.time(**case.what, settings=settings)  # compile
    for _ in range(RUNS):
        for tree in order.sample((before, after), 2):
            loops[tree].append(tree.time(**case.what, settings=settings).loop_s)
    return min(loops[after]) / min(loops[before]) - 1.0


def case_named(text: str) -> Case:
    """Return the one case whose name holds the text; ValueError where it is none or several."""
    fitting = [case for case in CASES if text in case.name]
    if len(fitting) != 1:
        names = ", ".join(case.name for case in CASES)
        raise ValueError(f"case = {text!r} fits {len(fitting)} cases; give one of: {names}")
    return fitting[0]


@click.command()
@click.argument("folder", type=click.Path(exists=False, path_type=Path))
@click.option("--percent", type=click.FloatRange(0.0, 1000.0), default=15.0, show_default=True, help="0: unchanged.")
@click.option("--only", default="links=10 mbs_ref dop853", show_default=True, help="The case it is calibrated on.")
def main(folder: Path, percent: float, only: str) -> None:
    """Make a copy of this tree in FOLDER whose planar kernel is PERCENT slower on one case."""
    try:
        case = case_named(only)
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    copy_tree(folder)
    if percent == 0.0:
        click.echo(f"{folder}: an unchanged copy")
        return
    turns, measured = calibrate(folder, case, percent / 100.0)
    click.echo(f"{folder}: {case.name} takes {measured:.1%} longer, {turns} square roots a right-hand side")


if __name__ == "__main__":
    main()
