"""What the first steps tell: is a motion stiff, so that an implicit method gets further for the same work?

A motion is stiff where stability holds the steps of an explicit method shorter than accuracy would. Whether it may be
is told by the largest |lambda| of the linearised motion, found by powers of it (B. P. Sommeijer, L. F. Shampine,
J. G. Verwer, J. Comput. Appl. Math. 88 (1998) 315, sec. 3.2): if the steps that it allows are more than the outputs
ask for, the default goes ahead. As long as it is held up there (Hairer and Wanner, Solving Ordinary
Differential Equations II, sec. IV.2), the implicit method makes some steps from where it is: as fast motions decay,
that one's steps grow. All is counted and nothing timed, so that the choice repeats.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbs_ref.cores.system import System
from mbs_ref.integrators import STIFF, integrators
from mbs_ref.integrators.loop.leg import Integrator, progress
from mbs_ref.run.method_choice import AUTO, plan_by
from mbs_ref.run.plan import Plan
from mbs_ref.trajectory import Status

POWERS = 12  # of the linearised motion
NUDGE = 1e-6  # of the state's units: along which the motion is linearised
LOOKS = (0.02, 0.05, 0.1)  # of the run: how far the default has gone when the other is tried
FEWEST = 10  # steps of the default at least before a look
PROBE = 6  # steps of the implicit method to begin, each up to eight times the one before, and to be judged by
HELD_UP = 0.5  # of the step that stability allows: a shorter one is held up by accuracy
EVALUATION = 50  # multiplications that dy/dt takes for each entry of the state, measured over the library
WORTH = 5e6  # multiplications, some milliseconds: a run of fewer takes no longer than to look
FACTORS = 10.0 / 3.0  # times n^3: a real and a complex matrix of order n factored


class _Trial:
    """A method under way."""

    def __init__(self, system: System, plan: Plan, t: float, y: np.ndarray) -> None:
        self.system, self.plan, self.run, self.y, self.seen = system, plan, progress(t), y.copy(), (0, 0)

    def advance(self, until: float, steps: int) -> bool:
        """Go on up to a time (s), by so many steps at most; return whether that went well."""
        self.seen = int(self.run.steps), int(self.run.rhs_calls)
        options = self.plan.options._replace(max_steps=int(self.run.steps) + steps)
        times = np.array([float(self.run.t), until])
        self.system.start_contacts(float(self.run.t), self.y, self.plan.settings.events != "none")
        with np.errstate(all="ignore"):
            leg = self.plan.integrator.advance(self.system, options, self.run, self.y, times)
        return leg.status in (Status.SUCCESS, Status.TOO_MANY_STEPS)

    def cost(self, longest: float) -> float:
        """Return the multiplications a second of steps like the last, as long as the next, `longest` (s) at most."""
        n, steps = len(self.y), max(1, int(self.run.steps) - self.seen[0])
        factored = 0.0 if self.plan.integrator.stability else FACTORS * n**3
        work = EVALUATION * n * (int(self.run.rhs_calls) - self.seen[1]) / steps + factored
        return work / min(float(self.run.h), longest)


def after_first_steps(system: System, plan: Plan, y: np.ndarray) -> Plan:
    """Return the plan by the implicit method where the method is left to us and the first steps ask for it.

    The contacts' modes must be started again afterwards.
    """
    loaded = system.scene.loads or system.scene.contacts
    if plan.settings.method != AUTO or plan.options.step or not plan.integrator.stability or not loaded:
        return plan
    span, allowed = float(plan.times[-1]), stable_step(system, plan, y)
    bounded = span / allowed  # steps
    if bounded <= 2 * len(plan.times) or bounded * plan.integrator.order * EVALUATION * len(y) < WORTH:
        return plan
    implicit = _implicit(system, plan)
    return plan if implicit is None else _looked_at(system, plan, implicit, y, allowed)


def _looked_at(system: System, plan: Plan, implicit: Plan, y: np.ndarray, allowed: float) -> Plan:
    """Return the plan that costs less after some first steps; `allowed` (s) is the step that stability allows."""
    span, gap = float(plan.times[-1]), float(plan.times[-1]) / (len(plan.times) - 1)
    smooth = min([span, *(t for t in system.scene.breakpoints() if t > 0.0)])
    explicit = _Trial(system, plan, 0.0, y)
    for look in LOOKS:
        until, enough = min(look * span, smooth), max(FEWEST, int(2.0 * look * span / allowed))
        if explicit.run.t >= until or not explicit.advance(until, enough) or explicit.run.h < HELD_UP * allowed:
            return plan
        now = float(explicit.run.t)
        other = _Trial(system, implicit, now, explicit.y)
        settled = all(other.advance(share * (smooth - now) + now, PROBE) for share in (0.25, 0.5))
        if settled and other.cost(gap) < explicit.cost(gap):
            return replace(implicit, reason=(
                f"stiff: stability holds the steps of {plan.integrator.name} at {explicit.run.h:.2g} s, and this one "
                f"takes {other.run.h:.2g} s after t = {now:.2g} s"
            ))  # fmt: skip
    return plan


def stable_step(system: System, plan: Plan, y: np.ndarray) -> float:
    """Return the step (s) that the plan's explicit method bears by the largest |lambda| at y, whatever its angle."""
    fastest = largest_eigenvalue(system, plan.options.units, y)
    return stability_radius(plan.integrator) / fastest if fastest > 0.0 else np.inf


def stability_radius(integrator: Integrator) -> float:
    """Return the least |z| on the negative axis where |R(z)| passes 1."""
    radii = np.linspace(0.05, 50.0, 1000)
    grows = np.abs(np.polynomial.polynomial.polyval(-radii, integrator.stability)) > 1.0
    return float(radii[max(int(np.argmax(grows)) - 1, 0)])


def largest_eigenvalue(system: System, units: np.ndarray, y: np.ndarray) -> float:
    """Return about the largest |lambda| (1/s) of dy/dt at t = 0, as growth over the last half of the powers.

    Complex pairs make the growth swing, hence the mean.
    """
    f = system.derivative(0.0, y) / units
    direction = np.random.default_rng(0).standard_normal(len(y))
    growth = []
    for _ in range(POWERS):
        length = float(np.linalg.norm(direction))
        if not 0.0 < length < np.inf:
            return 0.0
        nudge = NUDGE / length
        direction = (system.derivative(0.0, y + nudge * direction * units) / units - f) / nudge
        growth.append(float(np.linalg.norm(direction)) / length)
    late = np.array(growth[POWERS // 2 :])
    return float(np.exp(np.mean(np.log(late)))) if np.all((late > 0.0) & (late < np.inf)) else 0.0


def _implicit(system: System, plan: Plan) -> Plan | None:
    """Return the plan by the implicit method; None where it does not run the scene so."""
    try:
        return plan_by(system.scene, plan.settings, plan.times, integrators()[STIFF], "")
    except ValueError:
        return None
