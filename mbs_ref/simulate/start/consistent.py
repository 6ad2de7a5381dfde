"""Consistency of the initial conditions with the constraints: check, projection, rank, and rates fitted to joints."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.system import System
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.scene.scene import with_rates
from mbs_ref.settings import Settings

RANK_CHECK_LIMIT = 600  # rows; a dense SVD of more takes seconds
RATES = ("velocity", "angular_velocity")


class InconsistentScene(ValueError):
    """Initial conditions violate a constraint; the message names the joints and the violations."""


def consistent_start(system: System, y: np.ndarray, settings: Settings) -> list[str]:
    """Check the initial conditions; project y if the settings allow it, and return notes on the correction."""
    tolerance = settings.initial_tolerance
    if max(system.compliance(0.0, y)) <= tolerance:
        return []
    gaps = [
        f"joint {name!r}: {what} gap {np.abs(values).max():.3g}"
        for name, pair in system.residuals(0.0, y).items()
        for what, values in zip(("position", "velocity"), pair, strict=True)
        if not np.abs(values).max() <= tolerance
    ]
    if not gaps:
        return []
    if not settings.project_initial:
        raise InconsistentScene(
            f"initial conditions break {len(gaps)} constraint(s) by more than {tolerance:g}: {'; '.join(gaps[:8])}. "
            "Correct the scene, let --project-initial (project_initial) change it as little as possible, or fix known "
            "velocities, such as a motor's, and compute the others: --keep BODY.angular_velocity or BODY.velocity"
        )
    before = y.copy()
    residual = system.project(0.0, y)
    if not residual <= tolerance:
        raise InconsistentScene(
            f"the initial positions cannot be projected: {residual:.3g} remains; {'; '.join(gaps[:8])}"
        )
    half = system.n_positions
    moved, kicked = np.abs(y - before)[:half].max(), np.abs(y - before)[half:].max()
    return [f"initial conditions were projected: largest correction {moved:.3g} m or rad, {kicked:.3g} m/s or rad/s"]


def rank_at_start(system: System, y: np.ndarray) -> int | None:
    """Return the rank of C_q at the start; None for open trees, and for more rows than RANK_CHECK_LIMIT."""
    if system.n_closure_rows == 0 or system.n_constraints > RANK_CHECK_LIMIT:
        return None
    return system.rank(0.0, y)


def redundancy(system: System, rank: int | None) -> list[str]:
    """Return a note on dependent constraint rows at the start, if there are any."""
    rows = system.n_constraints
    if rank is None or rank == rows:
        return []
    freedom = system.n_coordinates - rank
    return [
        f"{rows - rank} of {rows} constraint rows are redundant at t = 0 (rank {rank}, {freedom} degrees of freedom); "
        "multipliers are the minimum-norm ones"
    ]


def fitted_rates(scene: Scene, fixed: Sequence[str], tolerance: float) -> Scene:
    """Return the scene with initial velocities that satisfy the joints; those that `fixed` names do not change.

    `fixed` holds BODY.velocity or BODY.angular_velocity. The others change least, angular velocities counted over the
    scene's length. ValueError for an unknown name; InconsistentScene if the joints contradict the fixed velocities,
    or if the poses violate a joint by more than `tolerance` (m or rad), which velocities cannot correct.
    """
    system = compile_scene(scene)
    if not isinstance(system, JointedSystem):
        raise ValueError(f"{scene.name} has no joints that its velocities could break")
    y = system.initial_state()
    gaps = system.residuals(0.0, y)
    broken = [name for name, (gap, _) in gaps.items() if not np.abs(gap).max(initial=0.0) <= tolerance]
    if broken:
        raise InconsistentScene(f"the initial poses break joint(s) {', '.join(broken)}; no velocity corrects that")
    rates = np.concatenate([_rates(body) for body in scene.bodies])
    rows, violation = system.jacobian(0.0, y), np.concatenate([rate for _, rate in gaps.values()])
    picked = np.eye(len(rates))[_columns(scene, fixed)]
    weights = np.tile(_weights(scene), len(scene.bodies))
    wanted = np.concatenate((-violation, np.zeros(len(picked))))
    change = np.linalg.lstsq(np.vstack((rows, picked)) / weights, wanted, rcond=None)[0] / weights
    fitted = with_rates(scene, rates + change)
    _require_closed(compile_scene(fitted), fixed, tolerance)
    return fitted


def _rates(body: Any) -> np.ndarray:
    """Return a body's velocity and angular velocity, (3,) in the plane and (6,) in space; a particle does not turn."""
    still = np.zeros(1 if len(body.velocity) == 2 else 3)
    return np.concatenate((body.velocity, np.atleast_1d(getattr(body, "angular_velocity", still))))


def _weights(scene: Scene) -> np.ndarray:
    """Return the factors (3,) or (6,) that make a body's rates comparable: the scene's length for angular ones."""
    d = scene.dimension
    return np.repeat((1.0, scales_of(scene).length), (d, d * (d - 1) // 2))


def _columns(scene: Scene, fixed: Sequence[str]) -> list[int]:
    """Return the columns of C_q that the names stand for."""
    straight, each = scene.dimension, len(_weights(scene))
    places = {"velocity": range(straight), "angular_velocity": range(straight, each)}
    columns: list[int] = []
    for name in fixed:
        body, _, rate = name.rpartition(".")
        if body not in scene.body_names or rate not in places:
            allowed = f"BODY.{' or BODY.'.join(RATES)}, where BODY is one of {', '.join(scene.body_names)}"
            raise ValueError(f"keep = {name!r} is unknown; allowed: {allowed}")
        columns += [each * scene.body_index(body) + k for k in places[rate]]
    return columns


def _require_closed(system: System, fixed: Sequence[str], tolerance: float) -> None:
    """Raise InconsistentScene if the joints contradict the fixed velocities."""
    residuals = system.residuals(0.0, system.initial_state())
    gaps = {name: float(np.abs(rate).max(initial=0.0)) for name, (_, rate) in residuals.items()}
    broken = [f"{name} by {gap:.3g}" for name, gap in gaps.items() if not gap <= tolerance]
    if broken:
        raise InconsistentScene(f"with {', '.join(fixed)} fixed, no velocities of the others close {'; '.join(broken)}")
