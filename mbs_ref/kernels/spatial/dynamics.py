"""The state of a spatial scene, and its rates.

State y = [q, u, s] in scene order: q = R, theta0..theta3 of a rigid body and R of a point mass, u = R', omega
and R', s the deflections of contacts that can stick. The state holds omega in body axes: on a free top at rtol
1e-12 that is 500 times more accurate than in world axes, where a steady spin already moves omega; everything
else is in world axes. theta^T theta = 1 is part of C; its multiplier and the four parameters are eliminated exactly
(see `tree`), and projection restores it.

Methods on the DAE itself move orientations by theta exp(turn / 2), a turn in body axes (Bruls and Cardona, J. Comput.
Nonlinear Dyn. 5 (2010) 031002): the norm stays one, and needs no multiplier.
"""

import sys

import numpy as np

from mbs_ref.kernels.algebra.lanes import larger, take_lane
from mbs_ref.kernels.border.handles import handle_class, handle_in_lanes
from mbs_ref.kernels.border.questions import accelerate, fill_deflection_rates
from mbs_ref.kernels.border.supplies import supply
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid import geometry
from mbs_ref.kernels.rigid.dynamics import correct_rates, is_solved, respond
from mbs_ref.kernels.rigid.elimination import rows_times
from mbs_ref.kernels.spatial import contacts, joints, loads, marks, orientation, tree
from mbs_ref.kernels.spatial.joints import leave_slips
from mbs_ref.kernels.spatial.marks import add, dot, minus, put, symmetric_times, times, triple, turn, turn_back
from mbs_ref.kernels.spatial.model import RATES, SpatialGroups, SpatialScratch
from mbs_ref.kernels.spatial.orientation import (
    composed,
    parameters,
    put_parameters,
    scale_theta,
    theta_rate,
    turn_theta,
    turning_of,
)


@bare
def take_kinematics(work, w, its):
    kin, own = work.kinematics, its.kinematics
    its.solved.time[0] = np.nan
    take_lane(kin.position, w, own.position)
    take_lane(kin.velocity, w, own.velocity)
    take_lane(kin.omega, w, own.omega)
    take_lane(kin.inertia, w, own.inertia)
    take_lane(work.grips.deflection, w, its.grips.deflection)
    for i in range(own.turned.shape[0]):
        take_lane(kin.turned[i], w, own.turned[i])


block = jit(lambda model: RATES)


@jit
def subtract_inertia(model, work, acceleration, load):
    """load -= M a."""
    bodies, kin = model.bodies, work.kinematics
    for i in range(bodies.mass.shape[0]):
        for c in range(3):
            load[i, c] -= bodies.mass[i] * acceleration[i, c]
        put(load[i], 3, minus(triple(load[i], 3), symmetric_times(kin.inertia[i], triple(acceleration[i], 3))))


@jit
def spatial_derivative(model, work, t, y, dy):
    """Write dy/dt = [R', E^T omega / 2; R'', alpha]."""
    if not is_solved(work, t, y):
        accelerate(model, work, t, y)
    bodies, kin, acceleration = model.bodies, work.kinematics, work.tree.acceleration
    for i in range(bodies.mass.shape[0]):
        q = bodies.q[i]
        v = bodies.v[i]
        for c in range(3):
            dy[q + c] = y[v + c]
            dy[v + c] = acceleration[i, c]
        if bodies.rigid[i] == 1:
            put_parameters(dy, q + 3, theta_rate(parameters(y, q + 3), triple(kin.omega[i], 0)))
            # omega_body' = A^T alpha: the body axes' own turning drops out
            put(dy, v + 3, turn_back(kin.turned[i], triple(acceleration[i], 3)))
    fill_deflection_rates(model, work, dy)


@jit
def largest_norm_defect(model, work):
    largest = 0.0
    norm, rigid = work.kinematics.norm, model.bodies.rigid
    for i in range(rigid.shape[0]):
        if rigid[i] == 1:
            largest = larger(largest, abs(norm[i]))
    return largest


@jit
def add_rates(model, work, i, factor, rates, out, k):
    add(out, k, times(factor, rates))
    if model.bodies.rigid[i] == 1:
        add(out, k + 3, times(factor, turn_back(work.kinematics.turned[i], triple(rates, 3))))


@jit
def world_rates(model, work, i, values, k):
    omega = (0.0, 0.0, 0.0)
    if model.bodies.rigid[i] == 1:
        omega = turn(work.kinematics.turned[i], triple(values, k + 3))
    return values[k], values[k + 1], values[k + 2], omega[0], omega[1], omega[2]


@jit
def plus_product(model, work, total, i, row, values, k):
    total += dot(row, triple(values, k))
    if model.bodies.rigid[i] == 1:
        total += dot(triple(row, 3), turn(work.kinematics.turned[i], triple(values, k + 3)))
    return total


@jit
def correct_places(model, work, y):
    """Move and turn the bodies in y by the correction in `work`."""
    bodies, acceleration = model.bodies, work.tree.acceleration
    for i in range(bodies.mass.shape[0]):
        q = bodies.q[i]
        add(y, q, acceleration[i])
        if bodies.rigid[i] == 1:
            turn_theta(y, q + 3, triple(acceleration[i], 3))


@jit
def _removed(model, work, of_places):
    """Turn the increments in the tree's acceleration into the correction that lets them keep the rows.

    Increments of places may be off what rows on velocities alone ask for, and the correction leaves that as it is.
    """
    rows, tree = work.rows, work.tree
    rows_times(RATES, model.slots.body, rows.jacobian, tree.acceleration, rows.rate)
    if of_places:
        leave_slips(model, rows.rate)
    respond(model, work, rows.rate)


@jit
def spatial_tangent(model, work, x):
    """Remove from both halves of x, in the mass norm, what points off the constraints and the norms."""
    bodies, kin, acceleration = model.bodies, work.kinematics, work.tree.acceleration
    n = bodies.mass.shape[0]
    for i in range(n):
        q = bodies.q[i]
        put(acceleration[i], 0, triple(x, q))
        if bodies.rigid[i] == 1:
            theta = parameters(kin.theta[i], 0)
            turning = turning_of(theta, parameters(x, q + 3))
            put(acceleration[i], 3, turning)
            put_parameters(x, q + 3, theta_rate(theta, turning))
    _removed(model, work, True)
    for i in range(n):
        q = bodies.q[i]
        add(x, q, acceleration[i])
        if bodies.rigid[i] == 1:
            change = theta_rate(parameters(kin.theta[i], 0), triple(acceleration[i], 3))
            for c in range(4):
                x[q + 3 + c] += change[c]
    for i in range(n):
        v = bodies.v[i]
        put(acceleration[i], 0, triple(x, v))
        if bodies.rigid[i] == 1:
            put(acceleration[i], 3, turn(kin.turned[i], triple(x, v + 3)))
    _removed(model, work, False)
    correct_rates(model, work, 1.0, x)


@jit
def normalize(model, y):
    """Scale every body's Euler parameters to norm one: the orientation does not change."""
    bodies = model.bodies
    for i in range(bodies.mass.shape[0]):
        if bodies.rigid[i] == 1:
            scale_theta(y, bodies.q[i] + 3, 1.0)


# --- for methods on the DAE itself ------------------------------------------------------------------


@jit
def spatial_times_mass(model, rate, out):
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
            turned = (np.cos(half), s * turning[0], s * turning[1], s * turning[2])
            put_parameters(out, q + 3, composed(parameters(y, q + 3), turned))


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


SpatialModel = handle_class(
    __name__, "SpatialModel", SpatialGroups, dimension=3, tangents=2, axes=3, turns=3, moments=6
)
SpatialWork = handle_class(__name__, "SpatialWork", SpatialScratch, rates=6)
SpatialModelInLanes, SpatialWorkInLanes = handle_in_lanes(SpatialModel), handle_in_lanes(SpatialWork)


_MODULES = (sys.modules[__name__], contacts, joints, loads, marks, orientation, tree)
supply((SpatialModel, SpatialWork, SpatialModelInLanes, SpatialWorkInLanes), geometry, _MODULES)
