"""The stages of an explicit Runge-Kutta step and its error estimate, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbs_ref.integrators.loop.step_control import weighted_norm
from mbs_ref.kernels.border.questions import derivative, project, regularity, tangent
from mbs_ref.kernels.jit import jit

STAGE_ITERATIONS = 6


class Stages(NamedTuple):
    """What a step is made of; n is the size of the state."""

    slopes: np.ndarray  # (s + 1 + e, n) f at the stages, at the new state, and at the extra stages of dense output
    new: np.ndarray  # (n,) the new state
    scratch: np.ndarray  # (n,)


@jit
def fill_stages(model, work, tableau, options, t, h, y, stages, restore):
    """Fill slopes[1:s]; slopes[0] is given. Leave the new state; return the worst stage's closure pivot.

    With `restore` every stage is first projected onto the constraints. Near a singular pose the
    accelerations off the manifold grow without bound while those on it stay smooth.
    """
    slopes, new = stages.slopes, stages.new
    pivot = 1.0
    for i in range(1, tableau.b.shape[0]):
        add_slopes(y, tableau.a[i], i, slopes, h, new)
        t_stage = t + tableau.c[i] * h
        if restore:
            project(model, work, t_stage, new, options.projection_tolerance, STAGE_ITERATIONS)
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
def error_norm(model, work, tableau, options, h, y, stages, restore):
    """Return the scaled error; with a second estimate as in DOP853 (Hairer, Norsett, Wanner I, sec. II.10).

    With `restore` only the error along the constraints counts: projection removes the rest, which near a
    singular pose is roundoff magnified by eps / sigma^3.
    """
    main = _estimate(model, work, tableau.error, options, h, y, stages, restore)
    if tableau.error_low.shape[0] == 0:
        return main
    low = _estimate(model, work, tableau.error_low, options, h, y, stages, restore)
    scale = main * main + 0.01 * low * low
    return 0.0 if scale == 0.0 else main * main / np.sqrt(scale)  # NaN must stay NaN, and be rejected


@jit
def _estimate(model, work, weights, options, h, y, stages, restore):
    """Return the scaled norm of one estimate."""
    _combine(weights, stages.slopes, h, stages.scratch)
    if restore:
        tangent(model, work, stages.scratch)
    return weighted_norm(stages.scratch, y, stages.new, options.rtol, options.atol)
