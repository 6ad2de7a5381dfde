"""What is right, and how well that is known: one file a scene, found by listing this folder."""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from cross_checks.certify import kept_poses
from cross_checks.certify.agreement import LARGEST_UNCERTAINTY, Agreement
from cross_checks.certify.extrapolation import NoConvergenceError
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.units import unit_length


@dataclass(frozen=True)
class Truth:
    """World poses of every body at the asked times."""

    position: np.ndarray  # (n_t, n_bodies, dimension) m, centres of mass
    angle: np.ndarray  # (n_t, n_bodies) rad; in space (n_t, n_bodies, 4) Euler parameters
    uncertainty: float  # m, of every world point at every time
    kind: Literal["exact", "published", "converged"]
    how: str  # one sentence
    difference: float | None = None  # m, between two unlike ways to it; None where it was found in one
    is_costly: bool = False  # takes so long to make that `mbs-ref certify --write` keeps its poses


@dataclass(frozen=True)
class NoTruth:
    """Why there is nothing to compare with."""

    reason: str


def converged(found: Agreement, first: str, second: str) -> Truth:
    """Return a truth that two ways agree on; `first` and `second` name them."""
    how = f"{second}; {first} differ by {found.difference:.1e} m; a start error grows {found.sensitivity:.1e}-fold"
    return Truth(found.position, found.angle, found.uncertainty, "converged", how, difference=found.difference)


def known() -> list[str]:
    """Return the names of the scenes that have a truth."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__))


def truth_for(scene: Scene, times: np.ndarray) -> Truth | None:
    """Return the truth of a scene at `times` (s, increasing, >= 0), or None; `seek_truth` says why."""
    found = seek_truth(scene, times)
    return found if isinstance(found, Truth) else None


def seek_truth(scene: Scene, times: np.ndarray, *, afresh: bool = False) -> Truth | NoTruth:
    """Return the truth, or the reason for having none. Answers are kept in memory.

    A costly truth is read from the disk where it was kept, unless it is to be made `afresh`.
    """
    if scene.name not in known():
        return NoTruth(f"no truth is known for a scene named {scene.name}")
    if not is_unchanged(scene):
        return NoTruth(f"the scene differs from {scene.name} with its parameters, for which the truth is known")
    parameters = tuple(sorted(scene.parameters.items()))
    asked = np.asarray(times, dtype=float)
    kept = None if afresh else kept_poses.find(scene, asked)
    if kept is not None:
        _, position, angle, uncertainty, difference, how = kept
        return Truth(position, angle, uncertainty, "converged", how, difference, is_costly=True)
    return _solved(scene.name, parameters, tuple(asked.tolist()))


def is_unchanged(scene: Scene) -> bool:
    """Return whether the scene is what its name and parameters build: only the same physics has the same truth."""
    try:
        ours = scenes.make(scene.name, **scene.parameters)
    except ValueError:
        return False
    return all(getattr(ours, part) == getattr(scene, part) for part in kept_poses.PHYSICS)


@lru_cache(maxsize=64)
def _solved(name: str, parameters: tuple, times: tuple[float, ...]) -> Truth | NoTruth:
    solver = importlib.import_module(f"{__name__}.{name}")
    scene = scenes.make(name, **dict(parameters))
    try:
        found = solver.solve(scene, np.array(times))
    except NoConvergenceError as error:
        return NoTruth(f"the truth does not converge: {error}")
    largest = LARGEST_UNCERTAINTY * unit_length(scene)
    if isinstance(found, Truth) and not found.uncertainty <= largest:
        known_to, limit = f"{found.uncertainty:.1e} m", f"{largest:.0e} m"
        return NoTruth(f"the truth is uncertain by {known_to}, more than {limit}: the motion is too sensitive")
    return found
