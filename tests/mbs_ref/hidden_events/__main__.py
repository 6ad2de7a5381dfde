"""Count the events that methods miss and invent: python -m tests.mbs_ref.hidden_events --seeds 0 40 --outputs 2 101."""

from __future__ import annotations

import argparse
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mbs_ref.simulate import simulate
from tests.mbs_ref.hidden_events.cases import Case, Comparison, case, compare
from tests.mbs_ref.hidden_events.families import FAMILIES

METHODS = ("dop853", "radau", "lsodar", "dassl", "rk4")
HARMLESS = ("good", "undecided")
VERDICTS = ("missed", "invented", "late", "undecided")


class Way(NamedTuple):
    """How a case is run."""

    method: str
    outputs: int


def compare_one(hidden: Case, way: Way) -> Comparison:
    """Return how one run differs from the truth; an input that the solver refuses is a verdict, too."""
    try:
        run = simulate(hidden.scene, hidden.settings(way.method, way.outputs))
    except ValueError as error:
        return Comparison("refused", message=str(error))
    return compare(hidden, run, way.method)


def tally(families: list[str], seeds: range, ways: list[Way]) -> Iterator[tuple[str, int, Way, Comparison]]:
    """Yield family, seed, way and comparison of every run."""
    for family in families:
        for seed in seeds:
            hidden = case(family, seed)
            for way in ways:
                yield family, seed, way, compare_one(hidden, way)


def _line(family: str, way: Way, runs: list[tuple[int, Comparison]]) -> str:
    counts = Counter(each.verdict for _, each in runs)
    failed = {name: count for name, count in counts.items() if name not in (*VERDICTS, "good")}
    errors = [each.error for _, each in runs if each.verdict in ("good", "late")]
    typical = np.quantile(errors, [0.5, 1.0]) if errors else (np.nan, np.nan)
    cells = "".join(f"{counts[name]:>10}" for name in VERDICTS)
    others = " ".join(f"{name}={count}" for name, count in failed.items())
    head = f"{family:<9} {way.method:<18} {way.outputs:>6} {len(runs):>6}"
    return f"{head}{cells}   {typical[0]:8.1e} {typical[1]:8.1e}  {others}"


def main() -> None:
    """Print a line for each family and way, and the seed of every run that is not good."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs=2, default=(0, 300), metavar=("FIRST", "END"))
    parser.add_argument("--methods", nargs="+", default=METHODS)
    parser.add_argument("--outputs", type=int, nargs="+", default=(2, 101, 20001))
    parser.add_argument("--family", nargs="+", choices=list(FAMILIES), default=list(FAMILIES))
    parser.add_argument(
        "--seeds-of", nargs="+", default=("missed", "invented"), help="verdicts whose seeds are printed"
    )
    given = parser.parse_args()
    ways = [Way(method, outputs) for method in given.methods for outputs in given.outputs]
    results: dict[tuple[str, Way], list[tuple[int, Comparison]]] = defaultdict(list)
    for family, seed, way, comparison in tally(given.family, range(*given.seeds), ways):
        results[family, way].append((seed, comparison))
    print(f"{'family':<9} {'method':<18} {'output':>6} {'scenes':>6}", end="")
    print("".join(f"{name:>10}" for name in VERDICTS), "  error of times: median, largest; runs that failed")
    if len(given.family) > 1:
        results |= {("all", way): [run for family in given.family for run in results[family, way]] for way in ways}
    for (family, way), runs in sorted(results.items(), key=lambda item: (item[0][0] == "all", *item[0])):
        print(_line(family, way, runs))
        for verdict in () if family == "all" else given.seeds_of:
            seeds = [str(seed) for seed, each in runs if each.verdict == verdict]
            if seeds:
                print(f"    {verdict}: {' '.join(seeds)}")


if __name__ == "__main__":
    main()
