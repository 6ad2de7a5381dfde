"""method = "auto": the method of a run, chosen from the scene's parts, with the reason.

Small planar trees without loads and few particles are expanded in series: the steps are longer, and outputs do not
shorten them. A method that runs on one core alone exploits its structure and is chosen there. All other runs start with
the default, and their first steps decide whether a stiff method is cheaper (`after_first_steps`). Loops, trees and many
outputs have no other effect on the choice: for no scene of the library do they make another method the cheapest at
equal error (`python -m benchmarks.method_table`).

A motion is stiff if stability limits the steps of an explicit method more than accuracy does. Power iteration gives the
largest |lambda| of the linearised motion (B. P. Sommeijer, L. F. Shampine, J. G. Verwer, J. Comput. Appl. Math. 88
(1998) 315, sec. 3.2). If the number of stable steps far exceeds the number of outputs, the default method starts. As
long as stability limits its steps (Hairer and Wanner, Solving Ordinary Differential Equations II, sec. IV.2), the
implicit method takes some steps from the same state: these grow as fast motions decay. It is not tried where its
matrices cost more than a share of the default's run, as in large scenes that are hardly stiff. Contacts that are open
at the start limit the steps once they close, by the stiffness of each alone; the trials then run when the steps have
become as short. Work is counted, not timed, so that the choice is reproducible.
"""

import math
from dataclasses import replace
from functools import cache

import numpy as np

from mbs_ref.cores.choice import core_name
from mbs_ref.cores.series import small_system
from mbs_ref.cores.system import System
from mbs_ref.integrators import DEFAULT, SERIES, STIFF, integrators
from mbs_ref.integrators.loop.leg import Integrator, progress
from mbs_ref.kernels.powers import growth_of_powers
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate.linearised import fastest_contact
from mbs_ref.simulate.plan import DEFAULT_TOLERANCE, Plan, make_plan
from mbs_ref.trajectory import Status

AUTO = "auto"
POWERS = 12  # power iterations
TINY = 1e-6  # of 1 / span: a smaller |lambda| counts as this
TRIALS = (0.02, 0.05, 0.1)  # shares of the run after which the implicit method is tried
LATER = (0.2, 0.4)  # further shares if contacts that close limit the steps
FEWEST = 10  # least number of the default's steps before a trial
PROBE = 6  # steps of the implicit method to settle, each up to eight times the last, and again to measure its work
LIMITED = 0.5  # of the stable step: a shorter step is limited by accuracy
EVALUATION = 50  # multiplications of dy/dt for each entry of the state, measured over the library
WORTH = 5e6  # multiplications, some milliseconds: a shorter run costs no more than this decision
FACTORS = 5.0 / 3.0  # times n^3: multiplications to factor a real and a complex matrix of order n; n^2: to solve
SHARE = 0.2  # of the default's work that the factorisations of all trials may take


def choose_plan(scene: Scene, settings: Settings, times: np.ndarray | None) -> Plan:
    """Return the plan of a run whose method may be "auto"."""
    if settings.method != AUTO:
        return make_plan(scene, settings, times)
    core, small, why = core_name(scene, settings.coordinates), small_system(scene), "the default"
    special = [entry for entry in integrators().values() if entry.cores == (core,)]
    reason = f"specific to {core}"
    if small:
        special, reason = [integrators()[SERIES]], f"series of {small}"
    if settings.step:
        why = "the default, because a step is given"
    elif special:
        try:
            return plan_by(scene, settings, times, special[0], reason)
        except ValueError as error:  # the settings request a feature that it lacks
            why = f"the default, because {error}"
    return _default(scene, settings, times, why)


def plan_by(scene: Scene, settings: Settings, times: np.ndarray | None, integrator: Integrator, reason: str) -> Plan:
    """Return the plan of a chosen method at the requested tolerance.

    A method that accepts steps with an error of `slack` times the tolerance receives a tolerance tighter by as much.
    """
    rtol = (settings.rtol or DEFAULT_TOLERANCE) / integrator.slack
    atol = settings.atol and settings.atol / integrator.slack
    own = settings.model_copy(update={"method": integrator.name, "rtol": rtol, "atol": atol})
    return replace(make_plan(scene, own, times), settings=settings, reason=reason)


def without(scene: Scene, plan: Plan, why: str) -> Plan:
    """Return the default method's plan for a run in which the chosen method failed."""
    reason = f"the default, because {plan.integrator.name} failed: {why}"
    return _default(scene, plan.settings, plan.times, reason)


def _default(scene: Scene, settings: Settings, times: np.ndarray | None, reason: str) -> Plan:
    plain = make_plan(scene, settings.model_copy(update={"method": DEFAULT}), times)
    return replace(plain, settings=settings, reason=reason)


class _Trial:
    """A method that has integrated up to some time."""

    def __init__(self, system: System, plan: Plan, t: float, y: np.ndarray) -> None:
        self.system, self.plan, self.run, self.y, self.before = system, plan, progress(t), y.copy(), (0, 0)

    def advance(self, until: float, steps: int) -> bool:
        """Integrate up to a time (s), in at most `steps` steps; return whether that succeeded."""
        self.before = int(self.run.steps), int(self.run.rhs_calls)
        options = self.plan.options._replace(max_steps=int(self.run.steps) + steps)
        now, outputs = float(self.run.t), self.plan.times
        times = np.hstack([now, outputs[(outputs > now) & (outputs < until)], until])
        self.system.start_contacts(float(self.run.t), self.y, self.plan.settings.events != "none")
        with np.errstate(all="ignore"):
            leg = self.plan.integrator.advance(self.system, options, self.run, self.y, times)
        return leg.status in (Status.SUCCESS, Status.TOO_MANY_STEPS)

    def advance_until_short(self, until: float, steps: int, shortest: float) -> bool:
        """Integrate as `advance` does, but stop once steps without events are shorter than `shortest` (s)."""
        end, events, is_short = int(self.run.steps) + steps, -1, False
        while self.run.t < until and self.run.steps < end and not is_short:
            events = int(self.run.events)
            if not self.advance(until, FEWEST):
                return False
            is_short = self.run.h < shortest and self.run.events == events
        return True

    def cost(self, longest: float) -> float:
        """Return multiplications per simulated second, from the last steps; a step is at most `longest` (s)."""
        n, steps, h = len(self.y), max(1, int(self.run.steps) - self.before[0]), float(self.run.h)
        evaluations, each, factored = int(self.run.rhs_calls) - self.before[1], EVALUATION * n, 0.0
        if not self.plan.integrator.stability:  # a Jacobian that later steps share, and factors that equal steps share
            evaluations -= n
            each += FACTORS * n**2
            factored = _factoring(self.system, n) / (steps if h > longest else 1)
        return (each * evaluations / steps + factored) / min(h, longest)


def _factoring(system: System, n: int) -> float:
    """Return the multiplications to factor both matrices of the implicit method for n states, half in the plane."""
    return FACTORS * (n / 2 if system.CORE == "planar" else n) ** 3


def after_first_steps(system: System, plan: Plan, y: np.ndarray) -> Plan:
    """Return the implicit method's plan if the method is "auto" and the first steps show that it is cheaper.

    The contacts' modes must be started again afterwards.
    """
    loaded = system.scene.loads or system.scene.contacts
    if plan.settings.method != AUTO or plan.options.step or not plan.integrator.stability or not loaded:
        return plan
    span, radius = float(plan.times[-1]), stability_radius(plan.integrator.stability)
    fastest = largest_eigenvalue(system, plan.options.units, y)
    now = radius / fastest if fastest > 0.0 else np.inf
    closed = radius / max(fastest_contact(system, y), TINY / span)
    allowed = min(now, closed)
    bounded = span / allowed  # steps
    work = bounded * plan.integrator.order * EVALUATION * len(y)  # multiplications of the whole explicit run
    trials = int(SHARE * work / (2 * PROBE * _factoring(system, len(y))))
    if bounded <= 2 * len(plan.times) or work < WORTH or not trials:
        return plan
    try:
        implicit = plan_by(system.scene, plan.settings, plan.times, integrators()[STIFF], "")
    except ValueError:  # it cannot run the scene with these settings
        return plan
    return _tried(system, plan, implicit, y, allowed, closed < now / LIMITED, trials)


def _tried(
    system: System, plan: Plan, implicit: Plan, y: np.ndarray, allowed: float, closes: bool, trials: int
) -> Plan:
    """Return the cheaper plan after some first steps, in at most so many `trials`.

    `allowed` (s) is the largest stable step; `closes` states whether contacts that are open at the start determine it.
    """
    span, gap = float(plan.times[-1]), float(plan.times[-1]) / (len(plan.times) - 1)
    smooth = min([span, *(t for t in system.scene.breakpoints() if t > 0.0)])
    explicit = _Trial(system, plan, 0.0, y)
    for share in (*TRIALS, *LATER) if closes else TRIALS:
        until, enough = min(share * span, smooth), max(FEWEST, int(2.0 * share * span / allowed))
        if closes:
            succeeds = explicit.advance_until_short(until, enough, allowed / LIMITED)
        else:
            succeeds = (
                explicit.run.t < until and explicit.advance(until, enough) and explicit.run.h >= LIMITED * allowed
            )
        if not succeeds:
            return plan
        if closes and explicit.run.h >= allowed / LIMITED:
            continue
        if not trials:
            return plan
        now = float(explicit.run.t)
        other, trials = _Trial(system, implicit, now, explicit.y), trials - 1
        settled = all(other.advance(part * (smooth - now) + now, PROBE) for part in (0.25, 0.5))
        if settled and other.cost(gap) < explicit.cost(gap):
            return replace(implicit, reason=(
                f"stiff: stability limits the steps of {plan.integrator.name} to {explicit.run.h:.2g} s, and this one "
                f"takes {other.run.h:.2g} s after t = {now:.2g} s"
            ))  # fmt: skip
    return plan


@cache
def stability_radius(stability: tuple[float, ...]) -> float:
    """Return the least |z| on the negative axis where |R(z)| passes 1, from R's coefficients, lowest power first."""
    radii = np.linspace(0.05, 50.0, 1000)
    grows = np.abs(np.polynomial.polynomial.polyval(-radii, stability)) > 1.0
    return float(radii[max(int(np.argmax(grows)) - 1, 0)])


def largest_eigenvalue(system: System, units: np.ndarray, y: np.ndarray) -> float:
    """Return an estimate of the largest |lambda| (1/s) of dy/dt at t = 0: the growth over the last half of the powers.

    For complex pairs the growth oscillates, hence the mean.
    """
    growth = np.empty(POWERS)
    growth_of_powers(system.model, system.work, y, units, _any_direction(len(y)).copy(), growth)
    late = growth[POWERS // 2 :].tolist()
    return math.prod(late) ** (1.0 / len(late)) if all(0.0 < factor < np.inf for factor in late) else 0.0


@cache
def _any_direction(count: int) -> np.ndarray:
    return np.random.default_rng(0).standard_normal(count)
