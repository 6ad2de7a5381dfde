"""Places and rates of spatial bodies and of points fixed in them (mbs_ref.kernels.rigid.marks), and forces on them.

Vectors are triples along world axes; rows of arrays are taken as well as triples.
"""

import math

from mbs_ref.kernels.jit import bare

# Return row[k : k + 3].
triple = bare(lambda row, k: (row[k], row[k + 1], row[k + 2]))


@bare
def put(row, k, a):
    """row[k : k + 3] = a."""
    row[k] = a[0]
    row[k + 1] = a[1]
    row[k + 2] = a[2]


plus = bare(lambda a, b: (a[0] + b[0], a[1] + b[1], a[2] + b[2]))
minus = bare(lambda a, b: (a[0] - b[0], a[1] - b[1], a[2] - b[2]))
negative = bare(lambda a: (-a[0], -a[1], -a[2]))
times = bare(lambda factor, a: (factor * a[0], factor * a[1], factor * a[2]))
over = bare(lambda a, divisor: (a[0] / divisor, a[1] / divisor, a[2] / divisor))
cross = bare(lambda a, b: (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))
dot = bare(lambda a, b: a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@bare
def add(row, k, a):
    """row[k : k + 3] += a."""
    row[k] += a[0]
    row[k + 1] += a[1]
    row[k + 2] += a[2]


@bare
def turn(m, u):
    """Return m u."""
    return (
        m[0, 0] * u[0] + m[0, 1] * u[1] + m[0, 2] * u[2],
        m[1, 0] * u[0] + m[1, 1] * u[1] + m[1, 2] * u[2],
        m[2, 0] * u[0] + m[2, 1] * u[1] + m[2, 2] * u[2],
    )


@bare
def turn_back(m, u):
    """Return m^T u."""
    return (
        m[0, 0] * u[0] + m[1, 0] * u[1] + m[2, 0] * u[2],
        m[0, 1] * u[0] + m[1, 1] * u[1] + m[2, 1] * u[2],
        m[0, 2] * u[0] + m[1, 2] * u[1] + m[2, 2] * u[2],
    )


@bare
def symmetric_times(s, u):
    """Return S u with S = xx, yy, zz, xy, xz, yz."""
    return (
        s[0] * u[0] + s[3] * u[1] + s[4] * u[2],
        s[3] * u[0] + s[1] * u[1] + s[5] * u[2],
        s[4] * u[0] + s[5] * u[1] + s[2] * u[2],
    )


centre = bare(lambda work, i: triple(work.kinematics.position[i], 0))


@bare
def spin(work, i):
    w = work.kinematics.omega[i]
    return math.sqrt(dot(w, w))


speed = bare(lambda work, i: triple(work.kinematics.velocity[i], 0))
turned = bare(lambda work, i, u: turn(work.kinematics.turned[i], u))
swing = bare(lambda work, i, arm: cross(work.kinematics.omega[i], arm))


@bare
def push(work, i, arm, force):
    add(work.kinematics.force[i], 0, force)
    twist(work, i, cross(arm, force))


# Add a torque (N m).
twist = bare(lambda work, i, torque: add(work.kinematics.force[i], 3, torque))


pull = bare(lambda tension, gap, length: times(tension / length, gap))


@bare
def coordinate(work, i, component):
    kin = work.kinematics
    return kin.position[i, component], kin.velocity[i, component]
