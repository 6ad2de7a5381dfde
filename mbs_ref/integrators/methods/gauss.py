"""Gauss-Legendre collocation of order 16 for free particles, adaptive, with compensated sums.

Stages: Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed. (2006), sec. II.1.3 and VIII.6.
Roundoff: Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231: iterate to the end, no rounded coefficients.

The step rule follows from analyticity alone. Where the nearest singularity of the motion lies at the
Bernstein ellipse rho, the accelerations' Legendre coefficients fall as rho^-k and the quadrature's error as
rho^-2s. With s = 8 stages and e the relative size of coefficient 7, the error is about e^(16/7): steps are
chosen for e = rtol^(7/16).
"""

from functools import cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mbs_ref.cores.particles import nearest
from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop.step import SLIVER
from mbs_ref.integrators.stages.gauss_coefficients import STAGES, Gauss, gauss
from mbs_ref.kernels.algebra.dense import all_finite
from mbs_ref.kernels.algebra.lanes import aligned, in_lanes
from mbs_ref.kernels.border.handles import handle_class, make_handle
from mbs_ref.kernels.jit import bare, jit, loop_jit
from mbs_ref.kernels.particles.dynamics import accelerate
from mbs_ref.kernels.particles.model import LANES
from mbs_ref.kernels.particles.pair import combine, settle, square_between, touching
from mbs_ref.trajectory import Status

if TYPE_CHECKING:
    from mbs_ref.cores.system import System

TINY_RTOL = 1e-18  # a hundredth of roundoff a step: over 1e4 steps its steady growth stays below the random walk
MOST_ITERATIONS = 30
LOOSE = 1e-3  # of the tolerance: where the iteration of a step may end
SAFETY, SHRINK, GROW = 0.9, 0.2, 2.0
ACCEPT = 1.3  # a step whose coefficient 7 asks for less than 1/1.3 of it is repeated
FIRST = 0.05  # of the shortest free-fall time: the first step tried
SIX = 0.1  # coefficient 6 counts a tenth: it guards against a seventh that happens to vanish
SUNLIGHT = 1e-8  # of gravity: 4.56e-6 N/m^2 on 0.02 m^2/kg near the Earth (Montenbruck and Gill 2000, sec. 3.4)
RESOLVED = 1e-4  # of the sunlight, where a shadow's edge cuts it
SMALLEST = 1e-12  # of the run's time elapsed or to go: a shorter step means that two bodies fall into each other


@jit
def _two_sum(a, b):
    """Return a + b and the part it drops (Knuth)."""
    s = a + b
    z = s - a
    return s, (a - (s - z)) + (b - z)


@jit
def _two_product(a, b):
    """Return a b and the part it drops (Dekker)."""
    p = a * b
    t = 134_217_729.0 * a
    ah = t - (t - a)
    t = 134_217_729.0 * b
    bh = t - (t - b)
    al, bl = a - ah, b - bh
    return p, ((ah * bh - p) + ah * bl + al * bh) + al * bl


@jit
def free_fall(gm, y, n):
    """Return the least sqrt(r^3 / gm) over pairs (s), infinite without attraction."""
    least = np.inf
    for i in range(n):
        for j in range(i + 1, n):
            m = gm[i] + gm[j]
            if m > 0.0:
                r2 = square_between(y, i, j)
                least = min(least, np.sqrt(r2 * np.sqrt(r2) / m))
    return least


@bare
def _extrapolate(g, ratio, lanes):
    """Predict the stage accelerations: extrapolate the polynomial through those of the last step (barycentric form)."""
    table, total, f = lanes.table, lanes.lines[0], in_lanes(lanes.acceleration)
    for i in range(STAGES):
        total[i] = 0.0
    for j in range(STAGES):
        for i in range(STAGES):
            table[j, i] = g.weight[j] / ((1.0 + ratio * g.c[i]) - g.c[j])
            total[i] += table[j, i]
    for j in range(STAGES):
        for i in range(STAGES):
            table[j, i] /= total[i]
    for b in range(lanes.acceleration.shape[0]):
        for c in range(3):
            combine(f, in_lanes(lanes.zero), in_lanes(table), lanes.old, b, c, 1.0)


@bare
def _place_stages(g, h, lanes, y, moves):
    """Set delta and velocity from the stage accelerations f; return the largest change of delta, scaled."""
    f, start = lanes.acceleration, in_lanes(lanes.start)
    delta, velocity, fixed = in_lanes(lanes.delta), in_lanes(lanes.velocity), in_lanes(lanes.fixed)
    abar, a = in_lanes(g.abar), in_lanes(g.a)
    n = f.shape[0]
    h2 = h * h
    worst = 0.0
    for b in range(n):
        change, size = settle(delta, fixed, abar, f, b, h2)
        if not change <= 0.0:
            worst = max(worst, change / size) if size > 0.0 and change < np.inf else np.inf
        if moves:
            for c in range(3):
                start[b, c] = y[3 * (n + b) + c]
                combine(velocity, start, a, f, b, c, h)
    return worst


@bare
def _fix(g, h, y, low, lanes):
    """Fill what no iteration changes: low + c_i h v + what rounding drops from h, h^2 and the coefficients.

    Where steps are equal those roundings are the same in every step: left alone, energy drifts steadily.
    """
    f, fixed = lanes.acceleration, lanes.fixed
    hc, hc_low, lead, tail = lanes.lines[0], lanes.lines[1], lanes.lines[2], lanes.lines[3]
    h2, h2_low = _two_product(h, h)
    for i in range(STAGES):
        hc[i], rest = _two_product(h, g.c[i])
        hc_low[i] = rest + h * g.c_low[i]
    n = f.shape[0]
    for b in range(n):
        for c in range(3):
            k = 3 * b + c
            x_low, v, v_low = low[k], y[3 * n + k], low[3 * n + k]
            _sums(g, f, b, c, lead, tail)
            for i in range(STAGES):
                small = hc[i] * v_low + hc_low[i] * v + (h2 * tail[i] + h2_low * lead[i])
                fixed[b, c, i] = hc[i] * v + (x_low + small)


@bare
def _sums(g, f, b, c, lead, tail):
    """Set lead and tail (STAGES,) to the sums of abar_ij f_j and of what its rounding drops."""
    for i in range(STAGES):
        lead[i] = tail[i] = 0.0
    for j in range(STAGES):
        factor = f[b, c, j]
        for i in range(STAGES):
            lead[i] += g.abar[j, i] * factor
            tail[i] += g.abar_low[j, i] * factor


@jit
def _iterate(model, work, g, t, h, y, low, enough):
    """Solve for the stage accelerations; return the count of evaluations, negative where they do not settle."""
    lanes, moves = work.lanes, model.particles.uses_velocity[0] == 1
    for k in range(LANES):
        lanes.time[k] = t + g.c[k] * h
    for b in range(lanes.acceleration.shape[0]):
        for c in range(3):
            lanes.base[b, c] = y[3 * b + c]
    _fix(g, h, y, low, lanes)
    _place_stages(g, h, lanes, y, moves)
    before = np.inf
    for count in range(1, MOST_ITERATIONS + 1):
        accelerate(model, work)
        change = _place_stages(g, h, lanes, y, moves)
        if not change < np.inf:
            return -count
        if change <= enough or (change >= before and before < 1e-12):
            return count
        if count > 8 and change > before:
            return -count
        before = change
    return -MOST_ITERATIONS


@jit
def _roughness(g, f):
    """Return the largest relative Legendre coefficient 6 or 7 of any body's acceleration."""
    worst = 0.0
    for b in range(f.shape[0]):
        top, size = 0.0, 0.0
        for c in range(3):
            six, seven = 0.0, 0.0
            for j in range(STAGES):
                six += g.legendre[0, j] * f[b, c, j]
                seven += g.legendre[1, j] * f[b, c, j]
                size = max(size, abs(f[b, c, j]))
            top = max(top, abs(seven), SIX * abs(six))
        if size > 0.0:
            worst = max(worst, top / size)
    return worst


@jit
def _finish(g, h, y, low, f):
    """Advance y and its low part by the step, with compensated sums."""
    n3 = 3 * f.shape[0]
    h2, h2_low = _two_product(h, h)
    for b in range(f.shape[0]):
        for c in range(3):
            k = 3 * b + c
            dx, dv, tail_x, tail_v = 0.0, 0.0, 0.0, 0.0
            for j in range(STAGES):
                dx += g.bbar[j] * f[b, c, j]
                dv += g.b[j] * f[b, c, j]
                tail_x += g.bbar_low[j] * f[b, c, j]
                tail_v += g.b_low[j] * f[b, c, j]
            p, e = _two_product(h, y[n3 + k])
            x, e1 = _two_sum(y[k], p)
            x, e2 = _two_sum(x, h2 * dx)
            rest = low[k] + ((e + h * low[n3 + k]) + h2 * tail_x + h2_low * dx) + (e1 + e2)
            y[k], low[k] = _two_sum(x, rest)
            p, e = _two_product(h, dv)
            v, e1 = _two_sum(y[n3 + k], p)
            y[n3 + k], low[n3 + k] = _two_sum(v, (low[n3 + k] + e + h * tail_v) + e1)


class Groups(NamedTuple):
    gauss: Gauss  # abar, a and their low parts transposed: the stage is the last index


Coefficients = handle_class(__name__, "Coefficients", Groups)


@cache
def _coefficients() -> tuple[Any, Groups, np.ndarray]:
    """Return the method's coefficients as compiled code receives them, and what keeps them alive."""
    g = gauss()
    g = g._replace(abar=aligned(g.abar.T), a=aligned(g.a.T), abar_low=g.abar_low.T.copy(), a_low=g.a_low.T.copy())
    groups = Groups(g)
    handle = make_handle(groups)
    return Coefficients(handle.ctypes.data), groups, handle


@bare
def _copy(target, source):
    for b in range(source.shape[0]):
        for c in range(3):
            for k in range(STAGES):
                target[b, c, k] = source[b, c, k]


@jit
def _targets(model, options):
    """Return the size of coefficient 7 to aim at, and the change at which the iteration may end."""
    rtol = TINY_RTOL
    if options.step == 0.0:
        rtol = max(options.rtol, TINY_RTOL)
    goal = rtol ** (7.0 / 16.0)
    if model.lights.body.shape[0] > 0:
        # a shadow's edge is not analytic: there the error is about coefficient 7 itself
        goal = max(rtol, RESOLVED * SUNLIGHT)
    return goal, LOOSE * rtol if rtol > 1e-13 else 0.0


@jit
def _propose(run, target, step):
    """Return when the next step ends, its length and whether it ends at the target; `step` is 0 when adaptive."""
    t = run.t
    reach = target - t
    wanted = step if step > 0.0 else run.h
    if wanted >= reach * (1.0 - SLIVER):
        return target, reach, True
    h = wanted if step > 0.0 else reach / np.ceil(reach / wanted)  # even steps, not a whole one and a sliver
    return t + h, (t + h) - t, False  # what time's own rounding leaves


@jit
def _attempt(model, work, g, t, h, y, low, last, enough):
    """Solve the step's equations; as `_iterate`, from the step before of `last` (s) where that extrapolates so far."""
    if h <= GROW * last:
        _extrapolate(g, h / last, work.lanes)
    else:
        _copy(work.lanes.acceleration, work.lanes.zero)
    return _iterate(model, work, g, t, h, y, low, enough)


@jit
def _factor(g, f, made, goal):
    """Return by how much the step might have been longer."""
    if made < 0:
        return 0.25
    rough = _roughness(g, f)
    return GROW if rough == 0.0 else min(GROW, max(SHRINK, (goal / rough) ** (1.0 / 7.0)))


@jit
def _lengthen(run, h, factor):
    """Set the next step; one cut short to land on an output leaves the longer one proposed before."""
    grown = h * (factor * SAFETY if factor < GROW else GROW)
    run.h = max(grown, run.h) if factor * SAFETY >= 1.0 else grown


_broken = jit(lambda f: leg.NOT_CONVERGED if all_finite(f.ravel()) else leg.NON_FINITE)


@jit
def _one_step(model, work, g, options, run, y, low, target, goal, enough):
    """Make one attempt; return a code, RUNNING where the run goes on, and whether it has reached the target."""
    adaptive, f = options.step == 0.0, work.lanes.acceleration
    t_new, h, lands = _propose(run, target, options.step)
    if h <= 0.0 or (adaptive and not lands and run.h < SMALLEST * run.t):
        return leg.STEP_TOO_SMALL, False
    made = _attempt(model, work, g, run.t, h, y, low, run.h_before, enough)
    run.rhs_calls += STAGES * abs(made)
    if made < 0 and not adaptive:
        return _broken(f), False
    factor = _factor(g, f, made, goal) if adaptive else 1.0
    if factor < 1.0 / ACCEPT:
        run.rejected += 1
        run.h = h * SAFETY * factor
        run.h_before = run.h_before if made > 0 and all_finite(f.ravel()) else 0.0
        return leg.RUNNING, False
    _finish(g, h, y, low, f)
    if not all_finite(y):
        return leg.NON_FINITE, False
    run.t, run.h_before = t_new, h
    run.steps += 1
    _copy(work.lanes.old, f)
    if adaptive:
        _lengthen(run, h, factor)
    return leg.COLLISION if touching(model.particles.radius, y, f.shape[0]) else leg.RUNNING, lands


@loop_jit
def advance_gauss(model, work, method, options, run, y, low, outputs):
    """Advance y through times[1:], in place; return a status code (RUNNING when the chunk is used up)."""
    g, times = method.gauss, outputs.times
    goal, enough = _targets(model, options)
    budget = run.steps + options.chunk
    if options.step == 0.0 and run.h == 0.0:
        run.h = min(FIRST * free_fall(model.particles.gm, y, y.shape[0] // 6), times[-1] - times[0])
    while run.next_output < times.shape[0]:
        target = times[run.next_output]
        code, lands = _one_step(model, work, g, options, run, y, low, target, goal, enough)
        if code != leg.RUNNING:
            return code
        if lands:
            for k in range(y.shape[0]):
                outputs.states[run.next_output, k] = y[k]
            run.next_output += 1
        if run.next_output == times.shape[0]:
            return leg.DONE
        if run.steps >= options.max_steps:
            return leg.TOO_MANY_STEPS
        if run.steps >= budget:
            return leg.RUNNING
    return leg.DONE


def advance(system: "System", options: leg.Options, run: leg.Progress, y: np.ndarray, times: np.ndarray) -> leg.Leg:
    """Advance a system of particles over one leg."""
    run.h_before = 0.0
    method, *_ = _coefficients()
    chunk = partial(advance_gauss, *system.own_handles, method, options, run, y, np.zeros_like(y))
    ended = leg.run_chunks(chunk, options, run, y, times)
    if ended.status in (Status.COLLISION, Status.STEP_TOO_SMALL):
        ended.message += f": {nearest(system.scene, y)}"
    return ended


METHOD = leg.Integrator(
    name="gauss",
    kind="both",
    order=16,
    description="Gauss-Legendre of order 16 for free particles, adaptive, with compensated sums",
    advance=advance,
    stabilization="none",
    stabilizations=("none",),
    ladder=(1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16, 1e-18),
    source="Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., Springer 2006, sec. VIII.6",
    cores=("particles",),
    slack=ACCEPT ** (2 * STAGES),
)
