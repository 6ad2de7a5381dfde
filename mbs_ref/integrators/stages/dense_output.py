"""Outputs inside a step, by the polynomial that a tableau brings along, compiled."""

from __future__ import annotations

import numpy as np

from mbs_ref.integrators.stages.explicit_stages import STAGE_ITERATIONS, add_slopes
from mbs_ref.kernels.border.questions import derivative, project
from mbs_ref.kernels.jit import jit


@jit
def fill_between(model, work, tableau, options, run, attempt, y, stages, restore, outputs):
    """Fill the outputs inside an accepted step from y; where it lands on the last output, that one is left.

    Like a step's end, an output is put onto the constraints where steps are.
    """
    end = outputs.times.shape[0] - 1 if attempt.lands else outputs.times.shape[0]
    first = run.next_output
    while run.next_output < end and outputs.times[run.next_output] <= attempt.t_new:
        if run.next_output == first:
            bumps = _bumps(model, work, tableau, options, run, attempt, y, stages, restore)
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
def _bumps(model, work, tableau, options, run, attempt, y, stages, restore):
    """Evaluate the extra stages; return h D k (m, n)."""
    slopes, dense, last = stages.slopes, tableau.dense, tableau.b.shape[0]
    if attempt.searching or options.step > 0.0:  # no judgement has needed the slope at its end
        derivative(model, work, attempt.t_new, stages.new, slopes[last])
        run.rhs_calls += 1
    for i in range(dense.c.shape[0]):
        t_stage = attempt.t + dense.c[i] * attempt.h
        add_slopes(y, dense.a[i], last + 1 + i, slopes, attempt.h, stages.scratch)
        if restore:
            project(model, work, t_stage, stages.scratch, options.projection_tolerance, STAGE_ITERATIONS)
        derivative(model, work, t_stage, stages.scratch, slopes[last + 1 + i])
        run.rhs_calls += 1
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
