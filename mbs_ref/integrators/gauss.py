"""Gauss-Legendre collocation of order 16 for free particles, adaptive, with compensated sums.

Stages: Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed. (2006), sec. II.1.3 and VIII.6.
Roundoff: Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231: iterate to the end, no rounded coefficients.

The step rule follows from analyticity alone. Where the nearest singularity of the motion lies at the
Bernstein ellipse rho, the accelerations' Legendre coefficients fall as rho^-k and the quadrature's error as
rho^-2s. With s = 8 stages and e the relative size of coefficient 7, the error is about e^(16/7): steps are
chosen for e = rtol^(7/16).
"""

# An intrinsic takes one argument fewer than its definition.
# pyright: reportCallIssue=false

from __future__ import annotations

import numpy as np

from mbs_ref.integrators.gauss_coefficients import STAGES, gauss
from mbs_ref.integrators.leg import (
    CLOCK_H,
    CLOCK_T,
    COUNT_OUTPUT,
    COUNT_REJECTED,
    COUNT_RHS,
    COUNT_STEPS,
    DONE,
    MESSAGES,
    NON_FINITE,
    NOT_CONVERGED,
    RUNNING,
    STEP_TOO_SMALL,
    TOO_MANY_STEPS,
    Integrator,
    Leg,
    Options,
    Progress,
    drive,
    finish_leg,
)
from mbs_ref.integrators.step_control import all_finite
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.particles.dynamics import accelerate
from mbs_ref.kernels.particles.model import LANES, lanes_of, lights_of, particles_of
from mbs_ref.kernels.particles.pair import combine
from mbs_ref.system import System
from mbs_ref.trajectory import Status

COLLISION = 100  # code of this loop alone: two bodies came closer than the sum of their radii
TINY_RTOL = 1e-18  # a hundredth of roundoff a step: over 1e4 steps its steady growth stays below the random walk
MOST_ITERATIONS = 30
LOOSE = 1e-3  # of the tolerance: where the iteration of a step may end
SAFETY, SHRINK, GROW = 0.9, 0.2, 2.0
ACCEPT = 1.3  # a step whose coefficient 7 asks for less than 1/1.3 of it is made again
FIRST = 0.05  # of the shortest free-fall time: the first step tried
SIX = 0.1  # coefficient 6 counts a tenth: it guards against a seventh that happens to vanish
SHADOW = 1e-12  # relative size of coefficient 7 that resolves sunlight (1e-8 of gravity) to four figures
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
                r2 = 0.0
                for c in range(3):
                    r2 += (y[3 * i + c] - y[3 * j + c]) ** 2
                least = min(least, np.sqrt(r2 * np.sqrt(r2) / m))
    return least


@jit
def touching(radius, y, n):
    """Return whether two bodies are closer than the sum of their radii."""
    for i in range(n):
        for j in range(i + 1, n):
            reach = radius[i] + radius[j]
            if reach > 0.0:
                r2 = 0.0
                for c in range(3):
                    r2 += (y[3 * i + c] - y[3 * j + c]) ** 2
                if r2 < reach * reach:
                    return True
    return False


@jit
def _extrapolate(g, ratio, old, zero, table, new):
    """Predict the stage accelerations from the polynomial through the last step's (barycentric form)."""
    for i in range(STAGES):
        x = 1.0 + ratio * g.c[i]
        total = 0.0
        for j in range(STAGES):
            table[j, i] = g.weight[j] / (x - g.c[j])
            total += table[j, i]
        for j in range(STAGES):
            table[j, i] /= total
    for b in range(old.shape[0]):
        for c in range(3):
            combine(new, zero, table, old, b, c, 1.0)


@jit
def _place_stages(g, h, lanes, y, f, fixed, trial, moves):
    """Set delta and velocity from the stage accelerations f; return the largest change of delta, scaled."""
    n = f.shape[0]
    h2 = h * h
    worst = 0.0
    delta = lanes.delta
    for b in range(n):
        change, size = 0.0, 0.0
        for c in range(3):
            combine(trial, fixed, g.abar, f, b, c, h2)
            for i in range(STAGES):
                change = max(change, abs(trial[b, c, i] - delta[b, c, i]))
                size = max(size, abs(trial[b, c, i] - fixed[b, c, i]))
                delta[b, c, i] = trial[b, c, i]
        if not change <= 0.0:
            worst = max(worst, change / size) if size > 0.0 and change < np.inf else np.inf
        if moves:
            for c in range(3):
                for i in range(STAGES):
                    trial[b, c, i] = y[3 * (n + b) + c]
                combine(lanes.velocity, trial, g.a, f, b, c, h)
    return worst


@jit
def _fix(g, h, y, low, f, fixed):
    """Fill what no iteration changes: low + c_i h v + the dropped digits of the coefficients."""
    n = f.shape[0]
    for b in range(n):
        for c in range(3):
            k = 3 * b + c
            v, v_low = y[3 * n + k], low[3 * n + k]
            for i in range(STAGES):
                tail = 0.0
                for j in range(STAGES):
                    tail += g.abar_low[j, i] * f[b, c, j]
                fixed[b, c, i] = h * g.c[i] * v + (low[k] + h * (g.c[i] * v_low + g.c_low[i] * v) + h * h * tail)


@jit
def _iterate(model, work, g, t, h, y, low, f, fixed, trial, enough):
    """Solve for the stage accelerations; return the evaluations made, negative where they do not settle."""
    lanes, moves = lanes_of(work), particles_of(model).uses_velocity[0] == 1
    n = f.shape[0]
    for k in range(LANES):
        lanes.time[k] = t + g.c[k] * h
    for b in range(n):
        for c in range(3):
            lanes.base[b, c] = y[3 * b + c]
    _fix(g, h, y, low, f, fixed)
    _place_stages(g, h, lanes, y, f, fixed, trial, moves)
    before = np.inf
    for count in range(1, MOST_ITERATIONS + 1):
        accelerate(model, work)
        for b in range(n):
            for c in range(3):
                for k in range(LANES):
                    f[b, c, k] = lanes.acceleration[b, c, k]
        change = _place_stages(g, h, lanes, y, f, fixed, trial, moves)
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
            x, e2 = _two_sum(x, h * h * dx)
            rest = low[k] + ((e + h * low[n3 + k]) + h * h * tail_x) + (e1 + e2)
            y[k], low[k] = _two_sum(x, rest)
            p, e = _two_product(h, dv)
            v, e1 = _two_sum(y[n3 + k], p)
            y[n3 + k], low[n3 + k] = _two_sum(v, (low[n3 + k] + e + h * tail_v) + e1)


@jit
def advance_gauss(model, work, g, options, run, y, low, f, times, states):
    """Advance y through times[1:], in place; return a status code (RUNNING when the chunk is used up)."""
    clock, counts = run.clock, run.counts
    n = f.shape[0]
    particles = particles_of(model)
    adaptive = options.step == 0.0
    rtol = max(options.rtol, TINY_RTOL) if adaptive else TINY_RTOL
    goal = rtol ** (7.0 / 16.0)
    if lights_of(model).body.shape[0] > 0:
        goal = max(rtol, SHADOW)  # a shadow's edge is not analytic: there the error is about e itself
    enough = max(LOOSE * rtol, 0.0) if adaptive and rtol > 1e-13 else 0.0
    budget = counts[COUNT_STEPS] + options.chunk
    old = np.empty_like(f)
    fixed = np.empty_like(f)
    trial = np.empty_like(f)
    zero = np.zeros_like(f)
    table = np.empty((STAGES, STAGES))
    if adaptive and clock[CLOCK_H] == 0.0:
        clock[CLOCK_H] = min(FIRST * free_fall(particles.gm, y, n), times[-1] - times[0])
    last = 0.0  # s, the step that f belongs to; 0 where there is none
    if clock[3] > 0.0:
        last = clock[3]
    else:
        for b in range(n):
            for c in range(3):
                for k in range(STAGES):
                    f[b, c, k] = 0.0
    for b in range(n):
        for c in range(3):
            for k in range(STAGES):
                old[b, c, k] = f[b, c, k]
    while counts[COUNT_OUTPUT] < times.shape[0]:
        t = clock[CLOCK_T]
        target = times[counts[COUNT_OUTPUT]]
        proposed = clock[CLOCK_H] if adaptive else options.step
        reach = target - t
        lands = proposed >= reach * (1.0 - 1e-9)
        h = reach if lands else proposed
        if adaptive and not lands:
            h = reach / np.ceil(reach / proposed)  # even steps rather than a whole one and a sliver
        t_new = target if lands else t + h
        h = t_new - t  # what time's own rounding leaves
        if t_new == t or (adaptive and not lands and proposed < SMALLEST * t):
            return STEP_TOO_SMALL
        if last > 0.0:
            _extrapolate(g, h / last, old, zero, table, f)
        made = _iterate(model, work, g, t, h, y, low, f, fixed, trial, enough)
        counts[COUNT_RHS] += STAGES * abs(made)
        if made < 0 and not adaptive:
            return NOT_CONVERGED if all_finite(f.ravel()) else NON_FINITE
        factor = 0.25
        if made > 0 and adaptive:
            rough = _roughness(g, f)
            factor = GROW if rough == 0.0 else min(GROW, max(SHRINK, (goal / rough) ** (1.0 / 7.0)))
        if adaptive and (made < 0 or factor < 1.0 / ACCEPT):
            counts[COUNT_REJECTED] += 1
            clock[CLOCK_H] = h * SAFETY * factor
            last = last if made > 0 else 0.0
            if not all_finite(f.ravel()):
                last = 0.0
            if last == 0.0:
                for b in range(n):
                    for c in range(3):
                        for k in range(STAGES):
                            f[b, c, k] = 0.0
            continue
        _finish(g, h, y, low, f)
        if not all_finite(y):
            return NON_FINITE
        clock[CLOCK_T] = t_new
        counts[COUNT_STEPS] += 1
        last = h
        clock[3] = h
        for b in range(n):
            for c in range(3):
                for k in range(STAGES):
                    old[b, c, k] = f[b, c, k]
        if adaptive:
            grown = h * min(GROW, factor * SAFETY if factor < GROW else GROW)
            clock[CLOCK_H] = max(grown, proposed) if factor * SAFETY >= 1.0 else grown
        if touching(particles.radius, y, n):
            return COLLISION
        if lands:
            for k in range(y.shape[0]):
                states[counts[COUNT_OUTPUT], k] = y[k]
            counts[COUNT_OUTPUT] += 1
        if counts[COUNT_OUTPUT] == times.shape[0]:
            return DONE
        if counts[COUNT_STEPS] >= options.max_steps:
            return TOO_MANY_STEPS
        if counts[COUNT_STEPS] >= budget:
            return RUNNING
    return DONE


def _closest(system: System, y: np.ndarray) -> str:
    """Return a sentence on the two bodies nearest to each other."""
    q = y[: len(y) // 2].reshape(-1, 3)
    if len(q) < 2:
        return "one body alone"
    gap = np.linalg.norm(q[:, None] - q[None], axis=2) + np.diag(np.full(len(q), np.inf))
    i, j = np.unravel_index(int(np.argmin(gap)), gap.shape)
    names = system.scene.body_names
    return f"{names[min(i, j)]!r} and {names[max(i, j)]!r} are {gap[i, j]:.6g} m apart"


def advance(system: System, options: Options, run: Progress, y: np.ndarray, times: np.ndarray) -> Leg:
    """Advance a system of particles over one leg."""
    states = np.empty((len(times), len(y)))
    states[0] = y
    run.counts[COUNT_OUTPUT] = 1
    run.clock[3] = 0.0
    low = np.zeros_like(y)
    f = np.zeros((len(y) // 6, 3, STAGES))
    g = gauss()
    g = g._replace(abar=g.abar.T.copy(), a=g.a.T.copy(), abar_low=g.abar_low.T.copy(), a_low=g.a_low.T.copy())
    arguments = (system.model, system.work, g, options, run, y, low, f, times, states)
    code = drive(lambda: advance_gauss(*arguments), run)
    worst, at = np.zeros(len(times)), f"at t = {run.clock[CLOCK_T]:.9g} s"
    if code == COLLISION:
        message = f"{at} two bodies collided: {_closest(system, y)}"
        return Leg(states, worst, int(run.counts[COUNT_OUTPUT]), Status.COLLISION, message)
    if code == STEP_TOO_SMALL:
        message = f"{at} {MESSAGES[code]}: {_closest(system, y)}"
        return Leg(states, worst, int(run.counts[COUNT_OUTPUT]), Status.STEP_TOO_SMALL, message)
    return finish_leg(code, states, worst, run)


INTEGRATOR = Integrator(
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
)
