"""Right-hand sides of two source trees in turns: python -m benchmarks.trees.right_hand_side OLD NEW [-o FILE].

Prints, for each scene, the processor time a body in both trees and the median of their paired ratios.
"""

import argparse
import json
import statistics
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.trees.regression import Tree
from cross_checks.prices.timing import interleaved

ROUNDS = 15  # pairs, each in an order of its own
SECONDS = 0.02  # of processor time a measurement
CASES: tuple[tuple[str, dict[str, Any]], ...] = (
    *(("n_four_bar", {"loops": loops}) for loops in (1, 2, 10, 40, 100)),
    *(("spatial_n_four_bar", {"loops": loops}) for loops in (1, 10, 40)),
    ("slider_crank", {}), ("andrews", {}), ("bricard", {}), ("tracked_vehicle", {"model": "paper", "links": 100}),
    ("pendulum_chain", {"links": 100}), ("spatial_chain", {"links": 100}),
)  # fmt: skip


class Pair(NamedTuple):
    """A right-hand side in two trees, ns a body (least of all rounds), and new / old (median)."""

    scene: str
    parameters: dict[str, Any]
    old_ns_per_body: float
    new_ns_per_body: float
    ratio: float


def paired(old: Tree, new: Tree, scene: str, parameters: dict[str, Any]) -> Pair:
    """Measure one scene in both trees, in turns."""
    runs = [partial(tree.rate, scene=scene, parameters=parameters, seconds=SECONDS) for tree in (old, new)]
    times = interleaved(runs, ROUNDS)
    ratios = [after / before for before, after in zip(*times, strict=True)]
    return Pair(scene, parameters, min(times[0]), min(times[1]), statistics.median(ratios))


def main() -> None:
    """Compare the trees that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("-o", "--output", type=Path, help="JSON file for the figures")
    wanted = parser.parse_args()
    result = []
    with Tree(wanted.old) as old, Tree(wanted.new) as new:
        for scene, parameters in CASES:
            pair = paired(old, new, scene, parameters)
            result.append(pair._asdict())
            print(f"{scene} {parameters}: {pair.old_ns_per_body:.0f} -> {pair.new_ns_per_body:.0f} ns a body, "
                  f"new / old {pair.ratio:.3g}", flush=True)  # fmt: skip
    if wanted.output is not None:
        wanted.output.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
