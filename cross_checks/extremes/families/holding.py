"""Does it hold? Blocks that Coulomb's law holds, by each engine's own contact model: they creep, slide or stay."""

import numpy as np

from cross_checks.contact import own_engine
from cross_checks.contact.by_figure import pressed, slope
from cross_checks.extremes.extreme import STEP, Axis, Case, Extreme, Measured, decades, grid
from mbs_ref import Scene, Trajectory

FAMILY, END = "holding", 1.0  # s
SHARES = Axis("share of the friction cone", "", (0.1, 0.29, 0.5, 0.9, 0.99))
RATIOS = Axis("mass ratio", "", decades(1.0, 1e4))
SHARE = 0.29  # of the cone, on the other axes


def creep(scene: Scene, path: Trajectory) -> Measured:
    """Return the largest mean speed over the last half, over the speed that weight alone would give within the run."""
    middle = len(path.times) // 2
    way = np.abs(path.position[-1] - path.position[middle]) @ np.array((1.0, 0.0, 0.0))  # weight pulls along x
    free = scene.gravity[0] * path.times[-1]
    return Measured(float(way.max()) / float(path.times[-1] - path.times[middle]) / free)


def _held(scene: Scene, step: float = STEP, **more) -> Case:
    return Case(scene, grid(END, step, 5), creep, step=step, **more)


def _extreme(name: str, title: str, axis: Axis, case) -> Extreme:
    return Extreme(name, FAMILY, title, axis, case, own_engine)


EXTREMES = (
    _extreme("hold-slope", "A block rests on an ever steeper slope; it should not creep.", SHARES,
             lambda share: _held(slope(share, 0.0))),
    _extreme("hold-wall", "A force presses a block to a wall ever closer to what friction needs.", SHARES,
             lambda share: _held(pressed(share))),
    _extreme("hold-grip", "Two jaws grip a block ever closer to what friction needs.", SHARES,
             lambda share: _held(pressed(share, 2))),
    _extreme("hold-stack", "An ever heavier block rests on a light one on a slope.", RATIOS,
             lambda ratio: _held(slope(SHARE, ratio))),
    _extreme("hold-heavy-jaw", "An ever heavier jaw grips a light block.", RATIOS,
             lambda ratio: _held(pressed(SHARE, 2, ratio))),
    _extreme("hold-step", "A block rests on a slope at ever longer steps.", Axis("step", "s", (1e-4, 1e-3, 5e-3, 1e-2)),
             lambda step: _held(slope(SHARE, 0.0), step, rtol=None)),
)  # fmt: skip
