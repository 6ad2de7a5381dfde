"""The stages of an explicit Runge-Kutta step, its error estimate, and outputs inside it, compiled."""

from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.algebra.dense import weighted_norm
from mbs_ref.kernels.border.questions import derivative, project, regularity, tangent
from mbs_ref.kernels.jit import jit

STAGE_ITERATIONS = 6


class Stages(NamedTuple):
    """What a step is made of; n is the size of the state."""

    slopes: np.ndarray  # (s + 1 + e, n) f at the stages, at the new state, and at the extra stages of dense output
    new: np.ndarray  # (n,) the new state
    scratch: np.ndarray  # (n,)


@jit
def fill_stages(model, work, tableau, t, h, y, stages, restore, tolerance):
    """Fill slopes[1:s]; slopes[0] is given. Leave the new state; return the worst stage's closure pivot.

    With `restore` every stage is first projected onto the constraints, to `tolerance`. Near a singular pose the
    accelerations off the manifold grow without bound while those on it stay smooth.
    """
    slopes, new = stages.slopes, stages.new
    pivot = 1.0
    for i in range(1, tableau.b.shape[0]):
        add_slopes(y, tableau.a[i], i, slopes, h, new)
        t_stage = t + tableau.c[i] * h
        if restore:
            project(model, work, t_stage, new, tolerance, STAGE_ITERATIONS)
        derivative(model, work, t_stage, new, slopes[i])
        pivot = min(pivot, regularity(work))
    add_slopes(y, tableau.b, tableau.b.shape[0], slopes, h, new)
    return pivot


@jit
def add_slopes(y, weights, count, slopes, h, out):
    """Write y + h sum w_j k_j over the first `count` slopes."""
    for k in range(out.shape[0]):
        out[k] = y[k]
    for j in range(count):
        weight = h * weights[j]
        if weight != 0.0:
            for k in range(out.shape[0]):
                out[k] += weight * slopes[j, k]


@jit
def _combine(weights, slopes, h, out):
    """Write h sum w_j k_j."""
    for k in range(out.shape[0]):
        out[k] = 0.0
    for j in range(weights.shape[0]):
        if weights[j] != 0.0:
            for k in range(out.shape[0]):
                out[k] += h * weights[j] * slopes[j, k]


@jit
def error_norm(model, work, tableau, h, y, stages, restore, rtol, atol):
    """Return the scaled error; with a second estimate as in DOP853 (Hairer, Norsett, Wanner I, sec. II.10).

    With `restore` only the error along the constraints counts: projection removes the rest, which near a
    singular pose is roundoff magnified by eps / sigma^3.
    """
    main = _estimate(model, work, tableau.error, h, y, stages, restore, rtol, atol)
    if tableau.error_low.shape[0] == 0:
        return main
    low = _estimate(model, work, tableau.error_low, h, y, stages, restore, rtol, atol)
    scale = main * main + 0.01 * low * low
    return 0.0 if scale == 0.0 else main * main / np.sqrt(scale)  # NaN must stay NaN, and be rejected


@jit
def _estimate(model, work, weights, h, y, stages, restore, rtol, atol):
    """Return the scaled norm of one estimate."""
    _combine(weights, stages.slopes, h, stages.scratch)
    if restore:
        tangent(model, work, stages.scratch)
    return weighted_norm(stages.scratch, y, stages.new, rtol, atol)


@jit
def fill_between(model, work, tableau, options, run, attempt, y, stages, ends, restore, outputs):
    """Fill the outputs inside an accepted step from y; where it lands on the last output, that one is left.

    Like a step's end, an output is put onto the constraints where steps are.
    """
    end = outputs.times.shape[0] - 1 if attempt.lands else outputs.times.shape[0]
    first = run.next_output
    while run.next_output < end and outputs.times[run.next_output] <= attempt.t_new:
        if run.next_output == first:
            if ends.known[1] == 0:
                derivative(model, work, attempt.t_new, ends.y_new, ends.dy_new)
                run.rhs_calls += 1
                ends.known[1] = 1
            bumps = _bumps(model, work, tableau, attempt, y, stages, restore, options.projection_tolerance)
            run.rhs_calls += tableau.dense.c.shape[0]
        place = run.next_output
        share = (outputs.times[place] - attempt.t) / attempt.h
        _interpolate(share, attempt.h, y, stages, tableau.b.shape[0], bumps, outputs.states[place])
        if options.project:
            tolerance = options.projection_tolerance
            project(model, work, outputs.times[place], outputs.states[place], tolerance, STAGE_ITERATIONS)
        outputs.compliance[place] = run.compliance
        run.compliance = 0.0
        run.next_output = place + 1


@jit
def _bumps(model, work, tableau, attempt, y, stages, restore, tolerance):
    """Evaluate the extra stages; return h D k (m, n)."""
    slopes, dense, last = stages.slopes, tableau.dense, tableau.b.shape[0]
    for i in range(dense.c.shape[0]):
        t_stage = attempt.t + dense.c[i] * attempt.h
        add_slopes(y, dense.a[i], last + 1 + i, slopes, attempt.h, stages.scratch)
        if restore:
            project(model, work, t_stage, stages.scratch, tolerance, STAGE_ITERATIONS)
        derivative(model, work, t_stage, stages.scratch, slopes[last + 1 + i])
    bumps = np.zeros((dense.d.shape[0], y.shape[0]))
    for m in range(dense.d.shape[0]):
        for j in range(slopes.shape[0]):
            weight = attempt.h * dense.d[m, j]
            if weight != 0.0:
                for k in range(y.shape[0]):
                    bumps[m, k] += weight * slopes[j, k]
    return bumps


@jit
def _interpolate(share, h, y, stages, last, bumps, out):
    """Write the state at a share of the step (Hairer, Norsett, Wanner I, eq. II.6.20 and their dop853.f)."""
    rest = 1.0 - share
    for k in range(y.shape[0]):
        way = stages.new[k] - y[k]
        leaning = h * stages.slopes[0, k] - way
        total = 0.0
        for m in range(bumps.shape[0] - 1, -1, -1):
            total = (total + bumps[m, k]) * (share if m % 2 == 1 else rest)
        total = (total + way - h * stages.slopes[last, k] - leaning) * share
        out[k] = y[k] + ((total + leaning) * rest + way) * share
