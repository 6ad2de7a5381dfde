"""Radau IIA of order 5, the stiff method: implicit, three stages, adaptive or fixed step.

Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996,
sec. IV.5 and IV.8 (coefficients, simplified Newton with one real and one complex system, error
estimate, Gustafsson's predictive step control).
"""

from __future__ import annotations

import numpy as np

from mbs_ref.integrators.events import EVENT, RETRY, event_tables, settle, watch
from mbs_ref.integrators.leg import (
    CLOCK_COMPLIANCE,
    CLOCK_ERROR,
    CLOCK_H,
    CLOCK_T,
    COUNT_OUTPUT,
    COUNT_REJECTED,
    COUNT_RHS,
    COUNT_STEPS,
    DONE,
    NON_FINITE,
    NOT_CONVERGED,
    PROJECTION,
    RUNNING,
    STEP_TOO_SMALL,
    Integrator,
    Leg,
    Options,
    Progress,
    run_chunks,
)
from mbs_ref.integrators.step_control import (
    begin,
    choose_step,
    close_step,
    end_step,
    first_step,
    weighted_norm,
    withdraw,
)
from mbs_ref.kernels.dense import lu_factor, lu_solve
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.questions import derivative
from mbs_ref.system import System

_S6 = 6**0.5
C = np.array([(4 - _S6) / 10, (4 + _S6) / 10, 1.0])
E = np.array([-13 - 7 * _S6, -13 + 7 * _S6, -1.0]) / 3.0
MU_REAL = 3 + 3 ** (2 / 3) - 3 ** (1 / 3)
MU_COMPLEX = 3 + 0.5 * (3 ** (1 / 3) - 3 ** (2 / 3)) - 0.5j * (3 ** (5 / 6) + 3 ** (7 / 6))
# The inverse of the Butcher matrix is T diag(MU_REAL, MU_COMPLEX, conj) T^-1 in real form.
T = np.array(
    [
        [0.09443876248897524, -0.14125529502095421, 0.03002919410514742],
        [0.25021312296533332, 0.20412935229379994, -0.38294211275726192],
        [1.0, 1.0, 0.0],
    ]
)
TI = np.array(
    [
        [4.17871859155190428, 0.32768282076106237, 0.52337644549944951],
        [-4.17871859155190428, -0.32768282076106237, 0.47662355450055044],
        [0.50287263494578682, -2.57192694985560522, 0.59603920482822492],
    ]
)
NEWTON_ITERATIONS = 7
MIN_FACTOR, MAX_FACTOR = 0.2, 8.0
KEEP_LOW, KEEP_HIGH = 1.0, 1.2  # a step this close to the last one keeps its factorization
STALE_RATE = 1e-3  # contraction above which the Jacobian is renewed


@jit
def _jacobian(model, work, t, y, f0, scratch, out):
    """Forward differences, one column an evaluation."""
    n = y.shape[0]
    shifted = y.copy()
    for j in range(n):
        delta = 1.5e-8 * max(1.0, abs(y[j]))
        shifted[j] = y[j] + delta
        step = shifted[j] - y[j]
        derivative(model, work, t, shifted, scratch)
        for i in range(n):
            out[i, j] = (scratch[i] - f0[i]) / step
        shifted[j] = y[j]


@jit
def _is_second_order(jacobian):
    """Return whether y = (q, v) with q' = v to the last bit, as in the plane."""
    n = jacobian.shape[0]
    half = n // 2
    for i in range(half):
        for j in range(n):
            if jacobian[i, j] != (1.0 if j == half + i else 0.0):
                return False
    return n % 2 == 0


@jit
def _factor(jacobian, mu, lu, pivots):
    """Factor mu I - J; where q' = v, of half the size: mu^2 I - mu dv'/dv - dv'/dq (sec. IV.8)."""
    n, size = jacobian.shape[0], lu.shape[0]
    if size == n:
        for i in range(n):
            for j in range(n):
                lu[i, j] = -jacobian[i, j]
            lu[i, i] += mu
    else:
        for i in range(size):
            for j in range(size):
                lu[i, j] = -jacobian[size + i, j] - mu * jacobian[size + i, size + j]
            lu[i, i] += mu * mu
    return lu_factor(lu, pivots)


@jit
def _solve(jacobian, mu, lu, pivots, b):
    """Solve (mu I - J) x = b in place with the factors of `_factor`."""
    size = lu.shape[0]
    if size == b.shape[0]:
        lu_solve(lu, pivots, b)
        return
    q = np.empty(size, b.dtype)
    for i in range(size):
        total = b[size + i] + mu * b[i]
        for j in range(size):
            total -= jacobian[size + i, size + j] * b[j]
        q[i] = total
    lu_solve(lu, pivots, q)
    for i in range(size):
        b[size + i] = mu * q[i] - b[i]
        b[i] = q[i]


@jit
def _newton(model, work, t, h, y, z, w, scale, tolerance, lus, stages):
    """Solve for the stage increments z (3, n); return converged, iterations, contraction."""
    real, complex_, real_pivots, complex_pivots, jacobian = lus
    n = y.shape[0]
    argument = np.empty(n)
    real_part = np.empty(n)
    complex_part = np.empty(n, dtype=np.complex128)
    for a in range(3):
        for k in range(n):
            w[a, k] = TI[a, 0] * z[0, k] + TI[a, 1] * z[1, k] + TI[a, 2] * z[2, k]
    before = -1.0
    rate = 0.0
    for iteration in range(NEWTON_ITERATIONS):
        for a in range(3):
            for k in range(n):
                argument[k] = y[k] + z[a, k]
            derivative(model, work, t + C[a] * h, argument, stages[a])
        for k in range(n):
            g0 = TI[0, 0] * stages[0, k] + TI[0, 1] * stages[1, k] + TI[0, 2] * stages[2, k]
            g1 = TI[1, 0] * stages[0, k] + TI[1, 1] * stages[1, k] + TI[1, 2] * stages[2, k]
            g2 = TI[2, 0] * stages[0, k] + TI[2, 1] * stages[1, k] + TI[2, 2] * stages[2, k]
            real_part[k] = g0 - MU_REAL / h * w[0, k]
            complex_part[k] = g1 + 1j * g2 - MU_COMPLEX / h * (w[1, k] + 1j * w[2, k])
        _solve(jacobian, MU_REAL / h, real, real_pivots, real_part)
        _solve(jacobian, MU_COMPLEX / h, complex_, complex_pivots, complex_part)
        total = 0.0
        for k in range(n):
            d1 = complex_part[k].real
            d2 = complex_part[k].imag
            total += (real_part[k] ** 2 + d1**2 + d2**2) / scale[k] ** 2
            w[0, k] += real_part[k]
            w[1, k] += d1
            w[2, k] += d2
        norm = np.sqrt(total / (3 * n))
        if not np.isfinite(norm):
            return False, iteration + 1, 1.0
        if before >= 0.0:
            rate = norm / before
            left = NEWTON_ITERATIONS - iteration - 1
            if rate >= 1.0 or rate**left / (1.0 - rate) * norm > tolerance:
                return False, iteration + 1, rate
        for a in range(3):
            for k in range(n):
                z[a, k] = T[a, 0] * w[0, k] + T[a, 1] * w[1, k] + T[a, 2] * w[2, k]
        if norm == 0.0 or (before >= 0.0 and rate / (1.0 - rate) * norm < tolerance):
            return True, iteration + 1, rate
        before = norm
    return False, NEWTON_ITERATIONS, rate


@jit
def _error(model, work, t, h, y, f, z, lus, rtol, atol, again):
    """Return the scaled error estimate, filtered once more after a rejection (sec. IV.8, eq 8.19-8.20)."""
    real, _, real_pivots, _, jacobian = lus
    n = y.shape[0]
    combined = np.empty(n)
    err = np.empty(n)
    new = np.empty(n)
    for k in range(n):
        combined[k] = (E[0] * z[0, k] + E[1] * z[1, k] + E[2] * z[2, k]) / h
        err[k] = f[k] + combined[k]
        new[k] = y[k] + z[2, k]
    _solve(jacobian, MU_REAL / h, real, real_pivots, err)
    norm = weighted_norm(err, y, new, rtol, atol)
    if again and norm > 1.0:
        slope = np.empty(n)
        derivative(model, work, t, y + err, slope)
        for k in range(n):
            err[k] = slope[k] + combined[k]
        _solve(jacobian, MU_REAL / h, real, real_pivots, err)
        norm = weighted_norm(err, y, new, rtol, atol)
    return norm


@jit
def _extrapolate(z, h_old, h, c_last):
    """Guess the stage increments from the last step's collocation polynomial (sec. IV.8, eq 8.4)."""
    n = z.shape[1]
    ratio = h / h_old
    for k in range(n):
        d1 = z[0, k] / C[0]
        d2 = (z[1, k] - z[0, k]) / (C[1] - C[0])
        d3 = (z[2, k] - z[1, k]) / (C[2] - C[1])
        e1 = (d2 - d1) / C[1]
        e2 = (d3 - d2) / (C[2] - C[0])
        f1 = (e2 - e1) / C[2]
        end = z[2, k]
        for a in range(3):
            x = 1.0 + C[a] * ratio
            z[a, k] = x * (d1 + (x - C[0]) * (e1 + (x - C[1]) * f1)) - end


@jit
def advance_radau(model, work, options, run, y, times, states, worst_per_time):
    """Advance y through times[1:], in place; return a status code (RUNNING when the chunk is used up)."""
    clock, counts = run.clock, run.counts
    n = y.shape[0]
    adaptive = options.step == 0.0
    rtol = options.rtol if adaptive else 1e-12
    atol = options.atol if adaptive else 1e-12
    newton_tolerance = max(10 * 2.3e-16 / rtol, min(0.03, np.sqrt(rtol))) if adaptive else 1e-2
    jac = np.empty((n, n))
    z = np.zeros((3, n))
    w = np.empty((3, n))
    stages = np.empty((3, n))
    f = np.empty(n)
    trial = np.empty(n)
    scale = np.empty(n)
    budget = counts[COUNT_STEPS] + options.chunk
    search, table = event_tables(model)
    watched = table.shape[1] > 0
    code = begin(model, work, run, y, f, table, options.max_events)
    if code != RUNNING:
        return code
    if adaptive and clock[CLOCK_H] == 0.0:
        clock[CLOCK_H] = first_step(
            model, work, clock[CLOCK_T], y, f, 3, rtol, atol, times[-1] - times[0]
        )
        counts[COUNT_RHS] += 1
    _jacobian(model, work, clock[CLOCK_T], y, f, trial, jac)
    counts[COUNT_RHS] += n
    size = n // 2 if _is_second_order(jac) else n
    lus = (
        np.empty((size, size)),
        np.empty((size, size), dtype=np.complex128),
        np.empty(size, dtype=np.int64),
        np.empty(size, dtype=np.int64),
        jac,
    )
    fresh = True  # Jacobian of this very state
    stale = False
    factored = 0.0  # step the factors belong to
    h_last = 0.0  # step behind the polynomial in z
    error_last = 0.0
    rejected = False
    failures = 0
    while counts[COUNT_OUTPUT] < times.shape[0]:
        t = clock[CLOCK_T]
        target = times[counts[COUNT_OUTPUT]]
        proposed = clock[CLOCK_H] if adaptive else options.step
        reach = target - t
        h, lands, searching = choose_step(proposed, reach, adaptive, search)
        if searching:
            h_last = 0.0
        t_new = target if lands else t + h
        if searching:
            pass
        elif t_new == t or h < 1e-14 * (times[-1] - times[0]):
            return STEP_TOO_SMALL
        if stale:
            _jacobian(model, work, t, y, f, trial, jac)
            counts[COUNT_RHS] += n
            fresh = True
            stale = False
            factored = 0.0
        if factored != h:
            if not (_factor(jac, MU_REAL / h, lus[0], lus[2]) and _factor(jac, MU_COMPLEX / h, lus[1], lus[3])):
                return NON_FINITE
            factored = h
        if h_last == 0.0:
            z[:] = 0.0
        else:
            _extrapolate(z, h_last, h, 1.0)
        for k in range(n):
            scale[k] = atol + rtol * abs(y[k])
        converged, iterations, rate = _newton(model, work, t, h, y, z, w, scale, newton_tolerance, lus, stages)
        counts[COUNT_RHS] += 3 * iterations
        if not converged:
            h_last = 0.0
            if not fresh:
                stale = True
                continue
            failures += 1
            if not adaptive or searching:
                return NOT_CONVERGED
            if failures > 60:
                return NON_FINITE
            clock[CLOCK_H] = 0.5 * h
            counts[COUNT_REJECTED] += 1
            continue
        if adaptive and not searching:
            error = _error(model, work, t, h, y, f, z, lus, rtol, atol, rejected or counts[COUNT_STEPS] == 0)
            safety = 0.9 * (2 * NEWTON_ITERATIONS + 1) / (2 * NEWTON_ITERATIONS + iterations)
            if not error < 1.0:
                counts[COUNT_REJECTED] += 1
                factor = MIN_FACTOR if not np.isfinite(error) else max(MIN_FACTOR, safety * error**-0.25)
                clock[CLOCK_H] = h * factor
                rejected = True
                h_last = 0.0
                continue
            floor = max(error, 1e-10)
            growth = safety * floor**-0.25
            if clock[CLOCK_ERROR] > 0.0 and not rejected and error_last > 0.0:  # Gustafsson
                growth = min(growth, safety * h / clock[CLOCK_ERROR] * (error_last / floor) ** 0.25 * floor**-0.25)
            growth = min(MAX_FACTOR, max(MIN_FACTOR, growth))
            if rejected:
                growth = min(growth, 1.0)
            error_last = floor
            clock[CLOCK_ERROR] = h
            rejected = False
            if KEEP_LOW <= growth <= KEEP_HIGH and rate < STALE_RATE:
                growth = 1.0
            suggested = h * growth
            clock[CLOCK_H] = max(suggested, proposed) if lands and growth >= 1.0 else suggested
        for k in range(n):
            trial[k] = y[k] + z[2, k]
        code, clock[CLOCK_COMPLIANCE] = close_step(
            model, work, t_new, trial, h, options.project, options.projection_tolerance,
            options.stop_on_compliance, clock[CLOCK_COMPLIANCE],
        )  # fmt: skip
        if code == PROJECTION and adaptive and not searching:
            code = withdraw(run, t, h, times[-1] - times[0])
            rejected = True
            h_last = 0.0
            if code == RUNNING:
                continue
        if code != RUNNING:
            return code
        verdict = 0
        if watched:
            verdict = watch(model, work, t, h, trial, search, table)
            if verdict == RETRY:
                if adaptive:
                    clock[CLOCK_H] = proposed
                continue
        for k in range(n):
            y[k] = trial[k]
        h_last = h
        failures = 0
        clock[CLOCK_T] = t_new
        counts[COUNT_STEPS] += 1
        if verdict == EVENT:
            h_last = 0.0
            error_last = 0.0
            code = settle(model, work, t_new, y, table, run, options.max_events)
            if code != RUNNING:
                return code
        code = end_step(run, lands, y, times, states, worst_per_time, options.max_steps)
        if code != RUNNING:
            return code
        derivative(model, work, t_new, y, f)
        counts[COUNT_RHS] += 1
        fresh = False
        stale = rate > STALE_RATE or verdict == EVENT
        if counts[COUNT_STEPS] >= budget:
            return RUNNING
    return DONE


def advance(system: System, options: Options, run: Progress, y: np.ndarray, times: np.ndarray) -> Leg:
    """Integrate one leg."""

    def chunk(states: np.ndarray, worst: np.ndarray) -> int:
        return advance_radau(system.model, system.work, options, run, y, times, states, worst)

    return run_chunks(chunk, options, run, y, times)


INTEGRATOR = Integrator(
    name="radau",
    kind="both",
    order=5,
    description="Radau IIA, three stages: the stiff method",
    advance=advance,
    ladder=(1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10),
    source="Hairer and Wanner, Solving Ordinary Differential Equations II, sec. IV.8",
    cores=("planar", "spatial"),
)
