"""What is right, and how well that is known: one file a scene, found by listing this folder."""

from __future__ import annotations

import importlib
import json
import math
import pkgutil
from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path

import numpy as np

from cross_checks.certify import kept_poses
from cross_checks.certify.agreement import LARGEST_UNCERTAINTY
from cross_checks.certify.kept_poses import physics_of
from cross_checks.certify.numerics import rates
from cross_checks.certify.numerics.time_limit import time_limit
from cross_checks.truth import NoConvergenceError, NoTruth, OutsideDomainError, Truth
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of

EPS = float(np.finfo(float).eps)
LIMIT_S = 60.0  # s of processor time for one truth; those that `certify` stores have no limit
CERTIFICATES = Path(__file__).parents[1] / "certificates" / "kept"


def known() -> list[str]:
    """Return the names of the scenes that have a truth."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__))


def truth_for(scene: Scene, times: np.ndarray) -> Truth | None:
    """Return the truth of a scene at `times` (s, increasing, >= 0), or None; `seek_truth` says why."""
    truth = seek_truth(scene, times)
    return truth if isinstance(truth, Truth) else None


def seek_truth(scene: Scene, times: np.ndarray, *, afresh: bool = False) -> Truth | NoTruth:
    """Return the truth, or the reason for having none. Answers are kept in memory.

    A truth belongs to physics, not to a name: a scene file with the bodies, joints and loads of a library's scene has
    its truth. A costly one is read from the disk where it was kept, unless it is to be made `afresh`: without the
    limit of LIMIT_S, beyond which there is no truth. It raises nothing: whatever fails is a reason.
    """
    asked = np.asarray(times, dtype=float)
    kept = None if afresh else kept_poses.find(scene, asked)
    if kept is not None:
        return Truth(
            kept.position, kept.orientation, kept.uncertainty, "converged", kept.how, kept.difference, True,
            kept.velocity, kept.angular_velocity, kept.rate_uncertainty,
        )  # fmt: skip
    twin = library_twin(scene)
    if twin is None:
        return NoTruth(f"no truth is known of the physics of {scene.name}")
    with time_limit(math.inf if afresh else LIMIT_S):
        return _solved(twin.name, tuple(sorted(twin.parameters.items())), tuple(asked.tolist()), afresh)


def library_twin(scene: Scene) -> Scene | None:
    """Return the library's scene of the same physics that has a truth, whatever the given one is called."""
    candidates = [(scene.name, tuple(sorted(scene.parameters.items())))] if scene.name in known() else []
    for name, parameters in candidates:
        twin = _made(name, parameters)
        if twin is not None and _same(twin, scene):
            return twin
    entry = _library().get(physics_of(scene))
    return None if entry is None else _made(*entry)


def is_unchanged(scene: Scene) -> bool:
    """Return whether the scene is what its name and parameters build: only the same physics has the same truth."""
    ours = _made(scene.name, tuple(sorted(scene.parameters.items())))
    return ours is not None and _same(ours, scene)


def _same(first: Scene, second: Scene) -> bool:
    return all(getattr(first, part) == getattr(second, part) for part in kept_poses.PHYSICS)


@lru_cache(maxsize=256)
def _made(name: str, parameters: tuple) -> Scene | None:
    try:
        return scenes.make(name, **dict(parameters))
    except ValueError:
        return None


@cache
def _library() -> dict[str, tuple[str, tuple]]:
    """Return name and parameters by physics of every scene with a truth: as it stands, and as certified."""
    library = {}
    for name, parameters in (*((name, ()) for name in known()), *_certified()):
        made = _made(name, parameters)
        if made is not None:
            library.setdefault(physics_of(made), (name, tuple(sorted(made.parameters.items()))))
    return library


def _certified() -> list[tuple[str, tuple]]:
    """Return name and parameters of every certificate kept."""
    read = (json.loads(file.read_text()) for file in sorted(CERTIFICATES.glob("*.json")))
    return [(one["scene"], tuple(sorted(one["parameters"].items()))) for one in read]


@lru_cache(maxsize=64)
def _solved(name: str, parameters: tuple, times: tuple[float, ...], afresh: bool) -> Truth | NoTruth:
    """Return the truth or the reason for having none; one computed without a limit of time is kept apart."""
    solver = importlib.import_module(f"{__name__}.{name}")
    scene, asked = scenes.make(name, **dict(parameters)), np.array(times)
    try:
        truth = solver.solve(scene, asked)
        if isinstance(truth, Truth) and truth.velocity is None:
            truth = _with_rates(solver.solve, scene, asked, truth)
    except NoConvergenceError as error:
        return NoTruth(f"the truth does not converge: {error}")
    except OutsideDomainError as error:
        return NoTruth(str(error))
    except Exception as error:
        return NoTruth(f"the computation of the truth ends with {type(error).__name__}: {error}", "defect")
    return truth if isinstance(truth, NoTruth) else _with_rounding(scene, truth)


def _with_rounding(scene: Scene, truth: Truth) -> Truth | NoTruth:
    """Return a truth no better known than its largest coordinate is rounded; NoTruth where it is not known enough."""
    size = float(np.max(np.abs(truth.position), where=np.isfinite(truth.position), initial=0.0))
    uncertainty = np.fmax(truth.uncertainty, EPS * size) if np.isfinite(truth.uncertainty) else np.inf
    largest = LARGEST_UNCERTAINTY * scales_of(scene).length
    if not uncertainty <= largest:
        known_to, limit = f"{uncertainty:.1e} m", f"{largest:.0e} m"
        return NoTruth(f"the truth is uncertain by {known_to}, more than {limit}: the motion is too sensitive")
    return replace(truth, uncertainty=float(uncertainty))


def _with_rates(solve: Callable, scene: Scene, times: np.ndarray, truth: Truth) -> Truth:
    """Return the truth with velocities from differences of its poses around every time, where it has such poses."""
    if len(times) < 2 or np.isnan(truth.position).any():
        return truth
    scales = scales_of(scene)
    asked, h = rates.stencil_times(times, scales.time)
    try:
        around = solve(scene, asked)
    except (NoConvergenceError, OutsideDomainError):
        return truth
    if isinstance(around, NoTruth):
        return truth
    poses = around.position, around.orientation
    velocity, spin, doubt = rates.of_poses(times, h, asked, poses, around.uncertainty, scales)
    return replace(truth, velocity=velocity, angular_velocity=spin, rate_uncertainty=doubt)
