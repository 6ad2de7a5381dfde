"""Chains of 1 to 10 000 links."""

from __future__ import annotations

from cross_checks.extremes import measures
from cross_checks.extremes.extreme import Axis, Case, Extreme, grid
from mbs_ref import scenes

STEP = 1e-3  # s


def _chain(links: float) -> Case:
    scene = scenes.make("pendulum_chain", links=round(links))
    return Case(scene, grid(0.02, STEP, 6), measures.invariants(), step=STEP, rtol=1e-6)


EXTREMES = (
    Extreme(
        "chain-length", "chain length", "Rods in a row fall for 20 ms; energy and joints are judged.",
        Axis("links", "", (1.0, 3.0, 10.0, 30.0, 100.0, 300.0), full=(1000.0, 3000.0, 10_000.0)), _chain, good=1e-3,
    ),
)  # fmt: skip
