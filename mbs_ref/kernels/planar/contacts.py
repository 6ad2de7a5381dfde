"""Contact forces in the plane, in the frozen mode of each contact or clipped by the state.

The force acts on both bodies at the circle's deepest point, so momentum is kept to roundoff.
"""

from __future__ import annotations

import math

import numpy as np

from mbs_ref.kernels.contact.laws import (
    ENDS_CAPPED,
    ENDS_OPEN,
    FRICTION_NONE,
    FRICTION_SMOOTH,
    GRIP_PROBE,
    GRIP_STICK,
    MODE_CLOSED,
    MODE_PLAIN,
    RELEASE_FORCE,
    normal_force,
)
from mbs_ref.kernels.contact.near_pairs import refresh
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.planar.joints import arm
from mbs_ref.kernels.planar.model import (
    PAIR_CIRCLE,
    PAIR_LINE,
    contact_laws_of,
    contact_modes_of,
    contact_pairs_of,
    kinematics_of,
    near_pairs_of,
)


@jit
def _on_line(pairs, k, x, y, tx, ty):
    """Return the gap, the outward normal, how far beyond an open end, and the place along the line."""
    nx = -ty
    ny = tx
    along = x * tx + y * ty
    above = x * nx + y * ny
    beyond = abs(along) - pairs.half[k]
    if pairs.ends[k] == ENDS_OPEN:
        return above - pairs.radius[k], nx, ny, beyond, along
    if pairs.ends[k] == ENDS_CAPPED and beyond > 0.0:
        px = math.copysign(beyond, along)
        distance = math.sqrt(px * px + above * above)
        return distance - pairs.radius[k], (px * tx + above * nx) / distance, (
            px * ty + above * ny
        ) / distance, -1.0, along
    return above - pairs.radius[k], nx, ny, -1.0, along


@jit
def _on_circle(pairs, k, x, y):
    distance = math.sqrt(x * x + y * y)
    if distance == 0.0:
        return -pairs.radius[k] - pairs.half[k], 0.0, 1.0, -1.0, 0.0
    return distance - pairs.radius[k] - pairs.half[k], x / distance, y / distance, -1.0, 0.0


@jit
def _in_sprocket(pairs, k, x, y, sx, sy):
    """Gap between a pin and the nearest tooth gap's wall; the normal points from the wall to the pin."""
    turn = math.atan2(sx * y - sy * x, sx * x + sy * y)
    pitch = 2.0 * math.pi / pairs.ends[k]
    seat = pitch * np.round(turn / pitch)
    c = math.cos(seat)
    s = math.sin(seat)
    ox = c * sx - s * sy  # outward, through the seat
    oy = s * sx + c * sy
    out = x * ox + y * oy - pairs.half[k]
    side = oy * x - ox * y
    wall = math.copysign(1.0, side)
    cosine = pairs.flank[k, 0]
    sine = pairs.flank[k, 1]
    width = abs(side)
    if width * sine + out * cosine > 0.0:  # on the straight flank
        offset = width * cosine - out * sine
        du = sine
        dw = -wall * cosine
    else:
        offset = math.sqrt(width * width + out * out)
        du = -out / offset if offset > 0.0 else 1.0
        dw = -side / offset if offset > 0.0 else 0.0
    return pairs.radius[k] - offset, du * ox + dw * oy, du * oy - dw * ox, out - pairs.thickness[k], 0.0


@jit
def contact_geometry(pairs, kin, k):
    """Return gap, its rate, normal (from b to a), sliding speed, place for sticking, excess beyond the ends, arms.

    The tangent is the normal turned by -90 degrees.
    """
    a = pairs.a[k]
    b = pairs.b[k]
    cx, cy = arm(kin.pose, a, pairs.center[k])
    ox, oy = arm(kin.pose, b, pairs.origin[k])
    x = kin.pose[a, 0] + cx - kin.pose[b, 0] - ox
    y = kin.pose[a, 1] + cy - kin.pose[b, 1] - oy
    back = pairs.radius[k]
    if pairs.kind[k] == PAIR_CIRCLE:
        gap, nx, ny, beyond, along = _on_circle(pairs, k, x, y)
    else:
        dx, dy = arm(kin.pose, b, pairs.direction[k])
        if pairs.kind[k] == PAIR_LINE:
            gap, nx, ny, beyond, along = _on_line(pairs, k, x, y, dx, dy)
            along += back * (kin.motion[a, 3] - kin.motion[b, 3])
        else:
            gap, nx, ny, beyond, along = _in_sprocket(pairs, k, x, y, dx, dy)
            back = 0.0
    ax = cx - back * nx
    ay = cy - back * ny
    bx = kin.pose[a, 0] + ax - kin.pose[b, 0]
    by = kin.pose[a, 1] + ay - kin.pose[b, 1]
    ux = kin.motion[a, 0] - ay * kin.motion[a, 2] - kin.motion[b, 0] + by * kin.motion[b, 2]
    uy = kin.motion[a, 1] + ax * kin.motion[a, 2] - kin.motion[b, 1] - bx * kin.motion[b, 2]
    return gap, nx * ux + ny * uy, nx, ny, ny * ux - nx * uy, along, beyond, ax, ay, bx, by


@jit
def is_behind(pairs, k, gap):
    """Return whether a depth is more than the surface is thick."""
    return pairs.kind[k] == PAIR_LINE and -gap > pairs.thickness[k]


@jit
def friction_force(laws, modes, k, normal, speed, along):
    """Return the force on body a along the tangent."""
    if laws.friction[k] == FRICTION_SMOOTH:
        return -laws.coefficient[k] * normal * math.tanh(speed / laws.creep[k])
    grip = modes.grip[k]
    if grip == GRIP_STICK:
        return -laws.grip_stiffness[k] * (along - modes.anchor[k]) - laws.grip_damping[k] * speed
    if grip == GRIP_PROBE:
        return modes.anchor[k]
    return -laws.coefficient[k] * normal * grip


@jit
def find_near(model, work):
    """Bring the list of near pairs up to the pose in `work`."""
    near, kin = near_pairs_of(model), kinematics_of(work)
    for s in range(near.body.shape[0]):
        body = near.body[s]
        x, y = arm(kin.pose, body, near.center[s])
        near.place[s, 0] = kin.pose[body, 0] + x
        near.place[s, 1] = kin.pose[body, 1] + y
    refresh(near, contact_modes_of(model))


@jit
def apply_contacts(model, work):
    """Add the forces of every contact that is closed."""
    pairs = contact_pairs_of(model)
    if pairs.kind.shape[0] == 0:
        return
    laws, modes, kin, near = contact_laws_of(model), contact_modes_of(model), kinematics_of(work), near_pairs_of(model)
    if modes.roots[0] == 0 or near.stale[0] == 1:  # while modes are frozen, what touches is in the list already
        find_near(model, work)
    for place in range(near.count[0]):
        k = near.pair[place]
        mode = modes.mode[k]
        if mode != MODE_CLOSED and mode != MODE_PLAIN:
            continue
        gap, rate, nx, ny, speed, along, beyond, ax, ay, bx, by = contact_geometry(pairs, kin, k)
        if mode == MODE_PLAIN and not (gap < 0.0 and beyond <= 0.0 and not is_behind(pairs, k, gap)):
            continue
        normal = normal_force(laws, modes, k, -gap, -rate)
        if mode == MODE_PLAIN and laws.release[k] == RELEASE_FORCE and normal < 0.0:
            continue
        fx = normal * nx
        fy = normal * ny
        if laws.friction[k] != FRICTION_NONE:
            tangential = friction_force(laws, modes, k, normal, speed, along)
            fx += tangential * ny
            fy -= tangential * nx
        a = pairs.a[k]
        b = pairs.b[k]
        kin.force[a, 0] += fx
        kin.force[a, 1] += fy
        kin.force[a, 2] += ax * fy - ay * fx
        kin.force[b, 0] -= fx
        kin.force[b, 1] -= fy
        kin.force[b, 2] -= bx * fy - by * fx
