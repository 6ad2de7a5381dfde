"""Euler parameters theta: the state into world axes, and rates of theta from angular velocities.

A = I + 2 th0 [e~] + 2 [e~]^2 with e = (th1, th2, th3) (Fox 1999, appendix), divided by |theta|^2 so that a
rotation results whatever the norm; theta' = E^T omega / 2 with the world angular velocity.
"""

import numpy as np

from mbs_ref.kernels.algebra.lanes import chosen_in_lanes, either, in_every_lane
from mbs_ref.kernels.jit import bare, jit, loop_jit
from mbs_ref.kernels.spatial.marks import dot, put, triple, turn

# Return row[k : k + 4].
parameters = jit(lambda row, k: (row[k], row[k + 1], row[k + 2], row[k + 3]))


@jit
def put_parameters(row, k, theta):
    """row[k : k + 4] = theta."""
    row[k], row[k + 1], row[k + 2], row[k + 3] = theta


@jit
def composed(p, q):
    """Return the Euler parameters of the turn q followed by p."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + q[0] * p[1] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] + q[0] * p[2] + p[3] * q[1] - p[1] * q[3],
        p[0] * q[3] + q[0] * p[3] + p[1] * q[2] - p[2] * q[1],
    )


@jit
def rotation(theta, turned):
    """Write A(theta / |theta|) and return theta . theta."""
    e0, e1, e2, e3 = theta
    square = e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3
    s = 2.0 / square
    turned[0, 0] = 1.0 - s * (e2 * e2 + e3 * e3)
    turned[0, 1] = s * (e1 * e2 - e0 * e3)
    turned[0, 2] = s * (e1 * e3 + e0 * e2)
    turned[1, 0] = s * (e1 * e2 + e0 * e3)
    turned[1, 1] = 1.0 - s * (e1 * e1 + e3 * e3)
    turned[1, 2] = s * (e2 * e3 - e0 * e1)
    turned[2, 0] = s * (e1 * e3 - e0 * e2)
    turned[2, 1] = s * (e2 * e3 + e0 * e1)
    turned[2, 2] = 1.0 - s * (e1 * e1 + e2 * e2)
    return square


@jit
def theta_rate(theta, w):
    """Return E^T w / 2."""
    e0, e1, e2, e3 = theta
    w0, w1, w2 = w
    return (
        -0.5 * (w0 * e1 + w1 * e2 + w2 * e3),
        0.5 * (e0 * w0 + w1 * e3 - w2 * e2),
        0.5 * (e0 * w1 + w2 * e1 - w0 * e3),
        0.5 * (e0 * w2 + w0 * e2 - w1 * e1),
    )


@jit
def turning_of(theta, change):
    """Return 2 E d / |theta|^2: the small rotation (world) that a change d of theta means."""
    e0, e1, e2, e3 = theta
    d0, d1, d2, d3 = change
    s = 2.0 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    return (
        s * (e0 * d1 - d0 * e1 + e2 * d3 - e3 * d2),
        s * (e0 * d2 - d0 * e2 + e3 * d1 - e1 * d3),
        s * (e0 * d3 - d0 * e3 + e1 * d2 - e2 * d1),
    )


@jit
def world_inertia(a, j, out):
    """out = A J A^T; both as xx, yy, zz, xy, xz, yz."""
    for r in range(3):
        h0 = a[r, 0] * j[0] + a[r, 1] * j[3] + a[r, 2] * j[4]
        h1 = a[r, 0] * j[3] + a[r, 1] * j[1] + a[r, 2] * j[5]
        h2 = a[r, 0] * j[4] + a[r, 1] * j[5] + a[r, 2] * j[2]
        out[r] = h0 * a[r, 0] + h1 * a[r, 1] + h2 * a[r, 2]
        if r == 0:
            out[3] = h0 * a[1, 0] + h1 * a[1, 1] + h2 * a[1, 2]
            out[4] = h0 * a[2, 0] + h1 * a[2, 1] + h2 * a[2, 2]
        elif r == 1:
            out[5] = h0 * a[2, 0] + h1 * a[2, 1] + h2 * a[2, 2]


@jit
def load_state(model, work, y):
    """Copy the state into elimination order; turn Euler parameters into world axes and inertias."""
    bodies, kin = model.bodies, work.kinematics
    work.solved.time[0] = np.nan
    for i in range(bodies.mass.shape[0]):
        q = bodies.q[i]
        v = bodies.v[i]
        for c in range(3):
            kin.position[i, c] = y[q + c]
            kin.velocity[i, c] = y[v + c]
        if bodies.rigid[i] == 1:
            for c in range(4):
                kin.theta[i, c] = y[q + 3 + c]
            kin.norm[i] = rotation(parameters(y, q + 3), kin.turned[i]) - 1.0
            put(kin.omega[i], 0, turn(kin.turned[i], triple(y, v + 3)))
            world_inertia(kin.turned[i], bodies.inertia[i], kin.inertia[i])
    deflection = work.grips.deflection
    first = y.shape[0] - 2 * deflection.shape[0]
    for i in range(deflection.shape[0]):
        deflection[i, 0] = y[first + 2 * i]
        deflection[i, 1] = y[first + 2 * i + 1]


@jit
def turn_theta(y, q, turning):
    """Turn the Euler parameters at y[q : q + 4] by a small world rotation, to norm one."""
    change = theta_rate(parameters(y, q), turning)
    for c in range(4):
        y[q + c] += change[c]
    scale_theta(y, q, dot(turning, turning))


@jit
def scale_theta(y, q, moves):
    """Scale the Euler parameters at y[q : q + 4] to norm one; of lanes, those where `moves` is not zero."""
    e0, e1, e2, e3 = parameters(y, q)
    s = _scale(moves, 1.0 / np.sqrt(e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3))
    put_parameters(y, q, (s * e0, s * e1, s * e2, s * e3))


# A lane that does not move stays as it is to the last digit, whatever those beside it do.
_scale = either(
    "_scale(moves, s)", bare(lambda moves, s: s), bare(lambda moves, s: chosen_in_lanes(moves, s, in_every_lane(1.0)))
)


@loop_jit
def write_poses(bodies, states, position, theta, velocity, omega):
    """Write the bodies' poses and rates in world axes (n_t, n_bodies, ...), in scene order; particles do not turn."""
    turned = np.empty((3, 3))
    for k in range(states.shape[0]):
        for i in range(bodies.q.shape[0]):
            y, own, q, v = states[k], bodies.scene_index[i], bodies.q[i], bodies.v[i]
            put(position[k, own], 0, triple(y, q))
            put(velocity[k, own], 0, triple(y, v))
            if bodies.rigid[i] == 1:
                put_parameters(theta[k, own], 0, parameters(y, q + 3))
                rotation(parameters(y, q + 3), turned)
                put(omega[k, own], 0, turn(turned, triple(y, v + 3)))
            else:
                put_parameters(theta[k, own], 0, (1.0, 0.0, 0.0, 0.0))
                put(omega[k, own], 0, (0.0, 0.0, 0.0))
