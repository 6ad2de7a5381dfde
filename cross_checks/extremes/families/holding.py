"""Blocks that Coulomb's law holds creep, slide or stay by the reference solver and by engines' own contact models."""

import numpy as np

from cross_checks.contact import own_engine
from cross_checks.contact.by_figure import pressed, slope
from cross_checks.extremes import STEP, Case, Measured, grid
from mbs_ref import Scene, Trajectory

ENGINE = own_engine
END = 1.0  # s
SHARE = 0.29  # of the cone, where the axis is another


def creep(scene: Scene, path: Trajectory) -> Measured:
    """Return the largest mean speed over the last half, over the speed that weight alone would give within the run."""
    middle = len(path.times) // 2
    way = np.abs(path.position[-1] - path.position[middle]) @ np.array((1.0, 0.0, 0.0))  # weight pulls along x
    free = scene.gravity[0] * path.times[-1]
    return Measured(float(way.max()) / float(path.times[-1] - path.times[middle]) / free)


def _held(scene: Scene, step: float = STEP, **more) -> Case:
    return Case(scene, grid(END, step, 5), creep, step=step, **more)


CASES = {
    "hold-slope": lambda share: _held(slope(share, 0.0)),
    "hold-wall": lambda share: _held(pressed(share)),
    "hold-grip": lambda share: _held(pressed(share, 2)),
    "hold-stack": lambda ratio: _held(slope(SHARE, ratio)),
    "hold-heavy-jaw": lambda ratio: _held(pressed(SHARE, 2, ratio)),
    "hold-step": lambda step: _held(slope(SHARE, 0.0), step, rtol=None),
}
