"""Before a run: do the initial conditions keep the constraints, which rows are redundant, can the step work at all."""

from __future__ import annotations

import numpy as np

from mbs_ref.cores.system import System
from mbs_ref.run.plan import Plan
from mbs_ref.self_checks.stiffness import may_be_stiff, stiffness
from mbs_ref.settings import Settings

RANK_CHECK_LIMIT = 600  # rows; a dense SVD beyond takes seconds and a tree without closures is regular


class InconsistentScene(ValueError):
    """Initial conditions break a constraint; names the joint and the gap."""


def consistent_start(system: System, y: np.ndarray, settings: Settings) -> list[str]:
    """Check the initial conditions; repair them when asked for and say by how much."""
    if max(system.compliance(0.0, y)) <= settings.initial_tolerance:
        return []
    gaps = [
        f"joint {name!r}: {what} gap {np.abs(values).max():.3g}"
        for name, pair in system.residuals(0.0, y).items()
        for what, values in zip(("position", "velocity"), pair, strict=True)
        if not np.abs(values).max() <= settings.initial_tolerance
    ]
    if not gaps:
        return []
    if not settings.project_initial:
        raise InconsistentScene(
            f"initial conditions break {len(gaps)} constraint(s) by more than {settings.initial_tolerance:g}: "
            f"{'; '.join(gaps[:8])}. Mend the scene, ask for projection (project_initial), "
            "or keep some velocities and let the others follow (--keep)"
        )
    before = y.copy()
    left = system.project(0.0, y)
    if not left <= settings.initial_tolerance:
        raise InconsistentScene(f"the initial positions cannot be projected: {left:.3g} left; {'; '.join(gaps[:8])}")
    half = system.n_positions
    moved, kicked = np.abs(y - before)[:half].max(), np.abs(y - before)[half:].max()
    return [f"initial conditions were projected: largest correction {moved:.3g} m or rad, {kicked:.3g} m/s or rad/s"]


def rank_at_start(system: System, y: np.ndarray) -> int | None:
    """Return the rank of C_q at the start; None where it is not looked at."""
    if system.n_closure_rows == 0 or system.n_constraints > RANK_CHECK_LIMIT:
        return None
    return system.rank(0.0, y)


def redundancy(system: System, rank: int | None) -> list[str]:
    """Report dependent constraint rows at the start."""
    rows = system.n_constraints
    if rank is None or rank == rows:
        return []
    freedom = system.n_coordinates - rank
    return [
        f"{rows - rank} of {rows} constraint rows are redundant at t = 0 (rank {rank}, {freedom} degrees of freedom); "
        "multipliers are the minimum-norm ones"
    ]


def unstable_step(system: System, plan: Plan, y: np.ndarray) -> str:
    """Return why an explicit fixed step cannot work from the start on, or nothing."""
    asked = plan.options.step
    if not (asked and plan.integrator.stability and plan.settings.refuse_unstable and may_be_stiff(system.scene)):
        return ""
    stiff = stiffness(system, 0.0, y)
    limit = stiff.step_limit(plan.integrator.stability)
    if asked <= limit:
        return ""
    return (f"step = {asked:g} s is beyond what {plan.integrator.name} can bear: the fastest motion has |lambda| = "
            f"{stiff.fastest:.4g} 1/s and needs a step of at most {limit:.3g} s; take that, an implicit or adaptive "
            "method, or refuse_unstable = False")  # fmt: skip
