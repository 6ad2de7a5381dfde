"""A small scene for every kind of joint, drive and load, so that an engine is tested on whatever it declares.

Two bodies in generic places, about generic axes: the joint under test holds both; a load or a drive under test
acts on bodies that hinges hold. The truth shares no equation with any engine, ours among them: the dense
oracle, which reads forces and constraints from the shared judge alone, is integrated by SciPy's DOP853.
"""

import tomllib
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from cross_checks.conformance.bounces import bounce_truth, bounces
from cross_checks.truths.oracle import Moment, augmented, consistent
from cross_checks.truths.truth import Truth
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import GROUND, Scene
from mbs_ref.scene.euler_parameters import product

DURATION = 0.2  # s
TOLERANCES = (1e-10, 1e-11)  # of the runs whose difference is what the truth is known to

WORLDS = tomllib.loads((files(__package__) / "probes.toml").read_text(encoding="utf-8"))
ENDS = ({"name": "one", "body_a": GROUND, "body_b": "a"}, {"name": "two", "body_a": "a", "body_b": "b"})


@cache
def probes() -> dict[tuple[str, int], Scene]:
    """Return the scenes, by the part's type and the dimension."""
    scenes = (*_in_dimension(2), *_in_dimension(3), *bounces())
    return {(kind, scene.dimension): scene for kind, scene in scenes}


def _in_dimension(d: int) -> Iterator[tuple[str, Scene]]:
    """Yield two of each joint, each drive and load on bodies that two hinges hold, and particles, welds, bushings."""
    world = _resolved(WORLDS["plane" if d == 2 else "space"], d)
    bodies = [*world["bodies"].values()]
    joints = {
        kind: [{"type": kind, **ENDS[k], **{name: pair[k] for name, pair in fields.items()}} for k in (0, 1)]
        for kind, fields in world["joints"].items()
    }
    hinges = joints["revolute"]
    drives = {kind: [*hinges, {"type": kind, "name": "drive"} | drive] for kind, drive in world["drives"].items()}
    loads = {kind: [{"type": kind, "name": "load"} | load] for kind, load in world["loads"].items()}
    built: dict[str, dict[str, Any]] = {kind: {"joints": own} for kind, own in (joints | drives).items()}
    built |= {kind: {"joints": hinges, "loads": own} for kind, own in loads.items()} | world["scenes"]
    shared = {"bodies": bodies, "gravity": WORLDS["vectors"]["gravity"][:d], "duration": DURATION}
    yield from ((kind, consistent(Scene.model_validate(shared | {"name": kind} | own))) for kind, own in built.items())


def _resolved(data: Any, d: int) -> Any:
    """Return data in which the names of vectors are replaced by their first d components."""
    if isinstance(data, dict):
        return {name: _resolved(value, d) for name, value in data.items()}
    if isinstance(data, list):
        return [_resolved(value, d) for value in data]
    return WORLDS["vectors"][data][:d] if data in WORLDS["vectors"] else data


# --- the truth ------------------------------------------------------------------------------------


def probe_truth(scene: Scene, times: np.ndarray) -> Truth:
    """Return the truth of a probe at the times (s)."""
    if scene.contacts:
        return bounce_truth(scene, times)
    rough, fine = (_motion(scene, times, rtol) for rtol in TOLERANCES)
    apart = float(np.nanmax(farthest(scene, Partial(*rough), Partial(*fine))))
    how = f"the dense oracle at {TOLERANCES[1]:g}, from which {TOLERANCES[0]:g} differs by {apart:.1e}"
    position, orientation, _ = fine
    return Truth(position, orientation, apart, "converged", how)


def _motion(scene: Scene, times: np.ndarray, rtol: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions, orientations and rates at the times."""
    start = Moment.start(scene)
    shapes = [start.position.shape, start.orientation.shape, start.rate.shape]
    cuts = np.cumsum([int(np.prod(shape)) for shape in shapes])[:2]

    def parts(y: np.ndarray) -> list[np.ndarray]:
        return [part.reshape(shape) for part, shape in zip(np.split(y, cuts), shapes, strict=True)]

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        position, orientation, rate = parts(y)
        here = replace(start, time=t, position=position, orientation=orientation, rate=rate)
        straight, turning = rate[:, : scene.dimension], rate[:, scene.dimension :]
        turned = turning[:, 0] if scene.dimension == 2 else _turning(orientation, turning)
        return np.concatenate([straight.ravel(), turned.ravel(), augmented(here).solve().acceleration.ravel()])

    y = np.concatenate([part.ravel() for part in (start.position, start.orientation, start.rate)])
    solved = solve_ivp(slope, (0.0, times[-1]), y, "DOP853", times, rtol=rtol, atol=1e-2 * rtol)
    states = [parts(column) for column in solved.y.T]
    position, orientation, rate = (np.array(part) for part in zip(*states, strict=True))
    return position, orientation, rate


def _turning(theta: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Return theta' (n, 4) of Euler parameters at angular velocities (n, 3) about world axes."""
    return 0.5 * product(np.concatenate((np.zeros((len(omega), 1)), omega), axis=1), theta)
