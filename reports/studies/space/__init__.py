"""What Euler parameters do and cost: three small measurements for the report."""

from functools import partial
from typing import Any

import numpy as np

from cross_checks.metrics.metric import off_truth
from cross_checks.prices.timing import interleaved
from mbs_ref import Settings, Trajectory, observables, scenes
from mbs_ref.scene import PointMass, Scene, SpatialBody
from mbs_ref.simulate import simulate
from reports.facts.curves import Measured, Value

FALLING = 20  # bodies in the scenes whose cost is compared
PAIRS = 9  # interleaved runs of each; the least counts


def measure() -> Measured:
    """Run everything; a few seconds with compiled code at hand."""
    figures = _long_steps() | {"space.cost_ratio": _cost_ratio()}
    return Measured(figures, {"norm": tuple(_norm_drift(half) for half in (0.05, 0.1, 0.2))})


def _rk4(scene: Scene, step: float, stored: bool, samples: int = 2) -> Trajectory:
    stabilization = "projection" if stored else "none"
    coarse: dict[str, Any] = {"samples": samples, "estimate": "off"}
    return simulate(scene, Settings(method="rk4", step=step, stabilization=stabilization, **coarse))


def _turned_away(scene: Scene, path: Trajectory) -> float:
    off = off_truth(scene, path)
    assert off is not None
    return off[1]


def _norm_drift(half: float) -> dict[str, Value]:
    """Return the loss of norm by RK4 in a steady spin of `half` = w h / 2 (rad), and the orientation errors (rad)."""
    spin = 10.0  # rad/s
    scene = scenes.make("torque_free_top", tilt=0.0, axis=3, spin=spin, turns=20.0)
    step = 2.0 * half / spin
    free, stored = (_rk4(scene, step, stored) for stored in (False, True))
    measured = 1.0 - float(np.linalg.norm(free.orientation[-1, 0]))
    formula = free.steps * half**6 / 144.0
    return {
        "half_angle": half, "steps": free.steps, "measured": measured, "formula": formula,
        "free": _turned_away(scene, free), "normalised": _turned_away(scene, stored),
    }  # fmt: skip


def _long_steps() -> dict[str, Value]:
    """Return the errors of a spin that makes 10 rad a step."""
    spin, step = 1e4, 1e-3  # rad/s, s
    moments = {"inertia_1": 1.0, "inertia_2": 1.0, "inertia_3": 1.02}  # slow nutation: the rates stay resolved
    scene = scenes.make("torque_free_top", tilt=0.1, axis=3, spin=spin, turns=200.0, **moments)
    path = _rk4(scene, step, stored=True, samples=21)
    assert path.ok, path.message
    energy = observables.kinetic_energy(scene, path)
    return {
        "space.radians_a_step": spin * step, "space.energy_error": float(np.abs(energy / energy[0] - 1.0).max()),
        "space.orientation_error": _turned_away(scene, path),
    }  # fmt: skip


def _falling(rigid: bool) -> Scene:
    """The same free fall, as rigid bodies or as point masses."""
    places = [(float(k), 0.0, 0.0) for k in range(FALLING)]
    still = (0.0, 0.0, 0.0)
    bodies = tuple(
        SpatialBody(name=f"b{k}", mass=1.0, inertia=(1.0, 1.0, 1.0, 0.0, 0.0, 0.0), position=place)
        if rigid
        else PointMass(name=f"b{k}", mass=1.0, position=place, velocity=still)
        for k, place in enumerate(places)
    )
    return Scene(name="falling", gravity=(0.0, 0.0, -9.81), bodies=bodies)


def _cost_ratio() -> float:
    settings = Settings(method="rk4", step=1e-4, t_end=0.2, samples=2, stabilization="none", estimate="off")
    runs = interleaved([partial(simulate, _falling(rigid), settings) for rigid in (True, False)], PAIRS)
    rigid, particles = (min(path.timing.loop_s for path in paths) for paths in runs)
    return rigid / particles
