"""A spatial scene as methods on the DAE itself see it: its mass matrix, and moves of its orientations.

Rates are (R', omega) with omega in body axes, where the inertia is constant. Orientations are moved by
theta exp(turn / 2), a turn in body axes (Bruls and Cardona, J. Comput. Nonlinear Dyn. 5 (2010) 031002): the
norm stays one, and needs no multiplier.
"""

import numpy as np

from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.spatial.orientation import composed, parameters, put_parameters
from mbs_ref.kernels.spatial.vectors import dot, put, symmetric_times, times, triple


@jit
def spatial_times_mass(model, rate, out):
    """Write M rate."""
    bodies = model.bodies
    for i in range(bodies.mass.shape[0]):
        k = bodies.v[i] - bodies.start[0]
        for c in range(3):
            out[k + c] = bodies.mass[i] * rate[k + c]
        if bodies.rigid[i] == 1:
            put(out, k + 3, symmetric_times(bodies.inertia[i], triple(rate, k + 3)))


@jit
def spatial_displace(model, y, move, out):
    """Write y's positions moved by `move`, turns in body axes, to out."""
    bodies = model.bodies
    for i in range(bodies.mass.shape[0]):
        q, k = bodies.q[i], bodies.v[i] - bodies.start[0]
        for c in range(3):
            out[q + c] = y[q + c] + move[k + c]
        if bodies.rigid[i] == 1:
            turning = triple(move, k + 3)
            half = 0.5 * np.sqrt(dot(turning, turning))
            s = 0.5 if half < 1e-8 else 0.5 * np.sin(half) / half
            put_parameters(
                out,
                q + 3,
                composed(parameters(y, q + 3), (np.cos(half), s * turning[0], s * turning[1], s * turning[2])),
            )


@jit
def spatial_position_rate(model, y, rate, out):
    """Write the rates of positions and Euler parameters at `rate`: theta' = theta (0, omega) / 2."""
    bodies = model.bodies
    for i in range(bodies.mass.shape[0]):
        q, k = bodies.q[i], bodies.v[i] - bodies.start[0]
        for c in range(3):
            out[q + c] = rate[k + c]
        if bodies.rigid[i] == 1:
            half = times(0.5, triple(rate, k + 3))
            put_parameters(out, q + 3, composed(parameters(y, q + 3), (0.0, half[0], half[1], half[2])))


@jit
def spatial_rate_from(model, y, moved, out):
    """Write the velocities and turns in body axes that rates of positions and Euler parameters mean."""
    bodies = model.bodies
    for i in range(bodies.mass.shape[0]):
        q, k = bodies.q[i], bodies.v[i] - bodies.start[0]
        for c in range(3):
            out[k + c] = moved[q + c]
        if bodies.rigid[i] == 1:
            e0, e1, e2, e3 = parameters(y, q + 3)
            half = composed((e0, -e1, -e2, -e3), parameters(moved, q + 3))
            put(out, k + 3, times(2.0, half[1:]))
