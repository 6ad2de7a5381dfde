"""Cartesian against relative coordinates in our own solver: the same motion, and the time of a right-hand side."""

from time import process_time

import numpy as np

from cross_checks.prices.timing import Sample, compare
from mbs_ref import Scene, Settings, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.kernels.border.questions import derivative
from mbs_ref.kernels.jit import jit
from mbs_ref.observables.distance import farthest
from mbs_ref.scene.traits import Coordinates
from mbs_ref.simulate import simulate
from reports.studies.crash import PAPER

TREES = {  # name, its scene, and how long (s) the motions are compared
    "chain": ("pendulum_chain", {"links": 10}, 1.0),
    "balls": ("spatial_chain", {"links": 10}, 1.0),
    "simplified": ("android_simplified", PAPER, 0.2),
    "vertebral": ("android_vertebral", PAPER, 0.2),
}
FINE = 1e-11  # rtol
CALLS = 2000  # of bodies' right-hand sides in one sample: about a millisecond


@jit
def _repeat(model, work, y, dy, count):
    for _ in range(count):
        derivative(model, work, 0.0, y, dy)


def coordinates() -> dict[str, float | str]:
    """Return how far apart the motions are (m), the time relative to Cartesian, and the numbers of coordinates."""
    figures: dict[str, float | str] = {}
    for name, (kind, parameters, t_end) in TREES.items():
        scene = scenes.make(kind, **parameters)
        cartesian, relative = (_loop(scene, coordinates) for coordinates in ("cartesian", "relative"))
        settings = Settings(rtol=FINE, t_end=t_end, samples=21, estimate="off", reactions=False)
        runs = [
            simulate(scene, settings.model_copy(update={"coordinates": kind})) for kind in ("cartesian", "relative")
        ]
        failed = next((run.message for run in runs if not run.ok), None)
        figures[f"coordinates.{name}.apart"] = failed or farthest(scene, *runs)[0]
        figures[f"coordinates.{name}.time"] = compare(cartesian, relative).ratio
        for coordinates in ("cartesian", "relative"):
            figures[f"coordinates.{name}.{coordinates}"] = compile_scene(scene, coordinates).n_positions
    return figures


def _loop(scene: Scene, coordinates: Coordinates):
    """Return what times CALLS right-hand sides of a body, in processor time."""
    system = compile_scene(scene, coordinates)
    system.set_mode_time(0.0)
    y = system.initial_state()
    system.start_contacts(0.0, y, True)
    dy, count = np.empty_like(y), max(1, CALLS // len(scene.bodies))
    _repeat(system.model, system.work, y, dy, 1)

    def timed() -> Sample:
        began = process_time()
        _repeat(system.model, system.work, y, dy, count)
        return Sample(process_time() - began)

    return timed
