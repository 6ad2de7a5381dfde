"""Reference solutions with stated uncertainties, computed by the families of `of` or read from `data`."""

import math
import pkgutil
from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache
from importlib import import_module

import numpy as np

from cross_checks.truths import certificate, of, stored_poses
from cross_checks.truths.made_by import LARGEST_UNCERTAINTY
from cross_checks.truths.made_by.numerics import rates
from cross_checks.truths.stored_poses import physics_of
from cross_checks.truths.truth import EPS, NoConvergenceError, NoTruth, OutsideDomainError, Truth, time_limit
from mbs_ref import Scene, scenes
from mbs_ref.scene.scales import scales_of

LIMIT_S = 60.0  # s of processor time for one truth; those that `certify` stores have no limit
Solver = Callable[[Scene, np.ndarray], Truth | NoTruth]  # the scene and times (s)


@cache
def _solvers() -> dict[str, Solver]:
    """Return, by the name of the scene, what computes its truth: the function of that name, or what TRUTHS lists."""
    solvers, all_scenes = {}, set(scenes.names())
    for info in pkgutil.iter_modules(of.__path__):
        module = import_module(f"{of.__name__}.{info.name}")
        own = (item for item in vars(module).values() if getattr(item, "__module__", "") == module.__name__)
        solvers |= {item.__name__: item for item in own if item.__name__ in all_scenes}
        solvers |= getattr(module, "TRUTHS", {})
    return solvers


def known() -> list[str]:
    """Return the names of the scenes that have a truth."""
    return sorted(_solvers())


def truth_for(scene: Scene, times: np.ndarray) -> Truth | None:
    """Return the truth of a scene at `times` (s, increasing, >= 0), or None; `seek_truth` says why."""
    truth = seek_truth(scene, times)
    return truth if isinstance(truth, Truth) else None


def seek_truth(scene: Scene, times: np.ndarray, *, afresh: bool = False) -> Truth | NoTruth:
    """Return the truth, or the reason for having none. Results are cached in memory.

    A truth belongs to physics, not to a name: a scene file with the bodies, joints and loads of a library's scene has
    its truth. A stored truth is read from the disk, unless it is to be computed `afresh`. The limit of LIMIT_S then
    does not apply; otherwise there is no truth beyond it. It raises nothing: whatever fails is a reason.
    """
    requested = np.asarray(times, dtype=float)
    stored = None if afresh else stored_poses.load(scene, requested)
    if stored is not None:
        return stored
    twin = library_twin(scene)
    if twin is None:
        return NoTruth(f"no truth is known of the physics of {scene.name}")
    with time_limit(math.inf if afresh else LIMIT_S) as limit:
        return _solved(twin.name, tuple(sorted(twin.parameters.items())), tuple(requested.tolist()), limit)


def library_twin(scene: Scene) -> Scene | None:
    """Return the library's scene of the same physics that has a truth, whatever the given one is called."""
    if scene.name in known() and is_unchanged(scene):
        return _made(scene.name, tuple(sorted(scene.parameters.items())))
    entry = _library().get(physics_of(scene))
    return None if entry is None else _made(*entry)


def is_unchanged(scene: Scene) -> bool:
    """Return whether the scene is what its name and parameters build: only the same physics has the same truth."""
    ours = _made(scene.name, tuple(sorted(scene.parameters.items())))
    return ours is not None and all(getattr(ours, part) == getattr(scene, part) for part in stored_poses.PHYSICS)


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
    certified = ((one.scene, tuple(sorted(one.parameters.items()))) for one in certificate.every())
    for name, parameters in (*((name, ()) for name in known()), *certified):
        made = _made(name, parameters)
        if made is not None:
            library.setdefault(physics_of(made), (name, tuple(sorted(made.parameters.items()))))
    return library


@lru_cache(maxsize=64)
def _solved(name: str, parameters: tuple, times: tuple[float, ...], limit: float) -> Truth | NoTruth:
    """Return the truth or the reason for having none, each cached with the limit (s) that it was computed within."""
    solve, scene, requested = _solvers()[name], scenes.make(name, **dict(parameters)), np.array(times)
    try:
        truth = solve(scene, requested)
        if isinstance(truth, Truth) and truth.velocity is None:
            truth = _with_rates(solve, scene, requested, truth)
    except NoConvergenceError as error:
        return NoTruth(f"the truth does not converge: {error}", limit_s=limit)
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


def _with_rates(solve: Solver, scene: Scene, times: np.ndarray, truth: Truth) -> Truth:
    """Return the truth with velocities from differences of its poses around every time, where it has such poses."""
    if len(times) < 2 or np.isnan(truth.position).any():
        return truth
    scales = scales_of(scene)
    stencil, h = rates.stencil_times(times, scales.time)
    try:
        around = solve(scene, stencil)
    except (NoConvergenceError, OutsideDomainError):
        return truth
    if isinstance(around, NoTruth):
        return truth
    poses = around.position, around.orientation
    velocity, spin, doubt = rates.of_poses(times, h, stencil, poses, around.uncertainty, scales)
    return replace(truth, velocity=velocity, angular_velocity=spin, rate_uncertainty=doubt)
