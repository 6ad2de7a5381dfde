"""Contact forces in space, in the frozen mode of each contact or clipped by the state.

The force acts on both bodies at the sphere's deepest point, so momentum is kept to roundoff. Where a contact
slides, friction opposes the slip velocity in the tangent plane; where it sticks, two springs along the plane's
edges carry it, and their deflections are states: how far a rolling sphere has slipped is no function of its pose.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

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
from mbs_ref.kernels.spatial.loads import push
from mbs_ref.kernels.spatial.model import (
    PAIR_PLANE,
    contact_laws_of,
    contact_modes_of,
    contact_pairs_of,
    grips_of,
    kinematics_of,
    near_pairs_of,
)
from mbs_ref.kernels.spatial.vectors import cross, dot, turn

SLOW = 1e5  # of the modes' noise, 1e-8 m/s: below, the direction of sliding is the frozen one, not roundoff's


class Touch(NamedTuple):
    """Where and how two shapes meet; vectors are world axes, triples of numbers."""

    gap: Any  # m
    closing: Any  # m/s, the gap's rate
    beyond: Any  # m, excess over open ends
    normal: Any  # from b to a
    slip: Any  # m/s, of a on b in the tangent plane
    arm_a: Any  # m, from the centre of mass of a to the point of contact
    arm_b: Any  # m
    edge_1: Any  # the plane's edges: stick and slip are kept along them
    edge_2: Any


@jit
def _on_plane(pairs, k, x, e, f, n):
    """Return the gap, the outward normal and how far the centre is beyond an open end."""
    along = dot(x[0], x[1], x[2], e[0], e[1], e[2])
    across = dot(x[0], x[1], x[2], f[0], f[1], f[2])
    above = dot(x[0], x[1], x[2], n[0], n[1], n[2])
    over = abs(along) - pairs.half[k, 0]
    past = abs(across) - pairs.half[k, 1]
    if pairs.ends[k] == ENDS_OPEN:
        return above - pairs.radius[k], n, max(over, past)
    if pairs.ends[k] == ENDS_CAPPED and (over > 0.0 or past > 0.0):
        p = math.copysign(max(over, 0.0), along)
        q = math.copysign(max(past, 0.0), across)
        distance = math.sqrt(p * p + q * q + above * above)
        outward = (
            (p * e[0] + q * f[0] + above * n[0]) / distance,
            (p * e[1] + q * f[1] + above * n[1]) / distance,
            (p * e[2] + q * f[2] + above * n[2]) / distance,
        )
        return distance - pairs.radius[k], outward, -1.0
    return above - pairs.radius[k], n, -1.0


@jit
def _on_sphere(pairs, k, x, n):
    distance = math.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    if distance == 0.0:
        return -pairs.radius[k] - pairs.half[k, 0], n, -1.0
    outward = (x[0] / distance, x[1] / distance, x[2] / distance)
    return distance - pairs.radius[k] - pairs.half[k, 0], outward, -1.0


@jit
def contact_geometry(pairs, kin, k):
    """Return the Touch of a pair."""
    a, b = pairs.a[k], pairs.b[k]
    c = turn(kin.turned[a], pairs.center[k])
    o = turn(kin.turned[b], pairs.origin[k])
    apart = (
        kin.position[a, 0] - kin.position[b, 0],
        kin.position[a, 1] - kin.position[b, 1],
        kin.position[a, 2] - kin.position[b, 2],
    )
    x = (apart[0] + c[0] - o[0], apart[1] + c[1] - o[1], apart[2] + c[2] - o[2])
    e = turn(kin.turned[b], pairs.axes[k, 0])
    f = turn(kin.turned[b], pairs.axes[k, 1])
    n = turn(kin.turned[b], pairs.axes[k, 2])
    if pairs.kind[k] == PAIR_PLANE:
        gap, n, beyond = _on_plane(pairs, k, x, e, f, n)
    else:
        gap, n, beyond = _on_sphere(pairs, k, x, n)
    r = pairs.radius[k]
    on_a = (c[0] - r * n[0], c[1] - r * n[1], c[2] - r * n[2])
    on_b = (apart[0] + on_a[0], apart[1] + on_a[1], apart[2] + on_a[2])
    wa, wb, va, vb = kin.omega[a], kin.omega[b], kin.velocity[a], kin.velocity[b]
    p = cross(wa[0], wa[1], wa[2], on_a[0], on_a[1], on_a[2])
    q = cross(wb[0], wb[1], wb[2], on_b[0], on_b[1], on_b[2])
    u = (va[0] + p[0] - vb[0] - q[0], va[1] + p[1] - vb[1] - q[1], va[2] + p[2] - vb[2] - q[2])
    closing = dot(n[0], n[1], n[2], u[0], u[1], u[2])
    slip = (u[0] - closing * n[0], u[1] - closing * n[1], u[2] - closing * n[2])
    return Touch(gap, closing, beyond, n, slip, on_a, on_b, e, f)


@jit
def slip_along(touch):
    """Return the slip velocity along the plane's edges, m/s."""
    s, e, f = touch.slip, touch.edge_1, touch.edge_2
    return dot(s[0], s[1], s[2], e[0], e[1], e[2]), dot(s[0], s[1], s[2], f[0], f[1], f[2])


@jit
def is_behind(pairs, k, gap):
    """Return whether a depth is more than the surface is thick."""
    return pairs.kind[k] == PAIR_PLANE and -gap > pairs.thickness[k]


@jit
def _slide(laws, modes, k, normal, along, across):
    """Return mu N against the slip velocity.

    Smooth through a stop: the slip along the frozen direction counts as positive, and as no less than SLOW.
    """
    d0 = modes.anchor[k, 0]
    d1 = modes.anchor[k, 1]
    ahead = d0 * along + d1 * across
    aside0 = along - ahead * d0
    aside1 = across - ahead * d1
    ahead = max(abs(ahead), SLOW * modes.noise[0])
    scale = -laws.coefficient[k] * normal / math.sqrt(ahead * ahead + aside0 * aside0 + aside1 * aside1)
    return scale * (ahead * d0 + aside0), scale * (ahead * d1 + aside1)


@jit
def grip_force(laws, modes, grips, pairs, k, normal, along, across):
    """Return stick-slip friction on body a along the plane's edges, N."""
    grip = modes.grip[k]
    if grip == GRIP_PROBE:
        return modes.anchor[k, 0], modes.anchor[k, 1]
    if grip == GRIP_STICK:
        spring = grips.deflection[pairs.deflection[k]]
        stiffness, damping = laws.grip_stiffness[k], laws.grip_damping[k]
        return -stiffness * spring[0] - damping * along, -stiffness * spring[1] - damping * across
    return _slide(laws, modes, k, normal, along, across)


@jit
def friction_force(laws, modes, grips, pairs, k, normal, touch):
    """Return the friction on body a, world axes, N."""
    if laws.friction[k] == FRICTION_NONE:
        return 0.0, 0.0, 0.0
    s = touch.slip
    if laws.friction[k] == FRICTION_SMOOTH:
        speed = math.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2])
        ratio = speed / laws.creep[k]
        share = 1.0 / laws.creep[k] if ratio < 1e-8 else math.tanh(ratio) / speed
        share *= -laws.coefficient[k] * normal
        return share * s[0], share * s[1], share * s[2]
    along, across = slip_along(touch)
    p, q = grip_force(laws, modes, grips, pairs, k, normal, along, across)
    e, f = touch.edge_1, touch.edge_2
    return p * e[0] + q * f[0], p * e[1] + q * f[1], p * e[2] + q * f[2]


@jit
def find_near(model, work):
    """Bring the list of near pairs up to the pose in `work`."""
    near, kin = near_pairs_of(model), kinematics_of(work)
    for s in range(near.body.shape[0]):
        body = near.body[s]
        place = turn(kin.turned[body], near.center[s])
        for c in range(3):
            near.place[s, c] = kin.position[body, c] + place[c]
    refresh(near, contact_modes_of(model))


@jit
def is_touching(pairs, modes, k, touch):
    """Return whether the contact has a force: by its frozen mode, or in the plain mode by the state."""
    if modes.mode[k] == MODE_PLAIN:
        return touch.gap < 0.0 and touch.beyond <= 0.0 and not is_behind(pairs, k, touch.gap)
    return modes.mode[k] == MODE_CLOSED


@jit
def contact_force(model, work, k, touch):
    """Return the force on body a of a contact that touches, world axes, N."""
    pairs, laws, modes = contact_pairs_of(model), contact_laws_of(model), contact_modes_of(model)
    normal = normal_force(laws, modes, k, -touch.gap, -touch.closing)
    if modes.mode[k] == MODE_PLAIN and laws.release[k] == RELEASE_FORCE:
        normal = max(normal, 0.0)
    t0, t1, t2 = friction_force(laws, modes, grips_of(work), pairs, k, normal, touch)
    n = touch.normal
    return normal * n[0] + t0, normal * n[1] + t1, normal * n[2] + t2


@jit
def apply_contacts(model, work):
    """Add the forces of every contact that is closed."""
    pairs = contact_pairs_of(model)
    if pairs.kind.shape[0] == 0:
        return
    modes, kin, near = contact_modes_of(model), kinematics_of(work), near_pairs_of(model)
    if modes.roots[0] == 0 or near.stale[0] == 1:  # while modes are frozen, what touches is in the list already
        find_near(model, work)
    for place in range(near.count[0]):
        k = near.pair[place]
        if modes.mode[k] != MODE_CLOSED and modes.mode[k] != MODE_PLAIN:
            continue
        touch = contact_geometry(pairs, kin, k)
        if not is_touching(pairs, modes, k, touch):
            continue
        f0, f1, f2 = contact_force(model, work, k, touch)
        a, b = touch.arm_a, touch.arm_b
        push(kin, pairs.a[k], a[0], a[1], a[2], f0, f1, f2)
        push(kin, pairs.b[k], b[0], b[1], b[2], -f0, -f1, -f2)


@jit
def fill_deflection_rates(model, work, dy):
    """Write the rates of the sticking deflections: the slip velocity while a contact sticks, else none."""
    count = grips_of(work).deflection.shape[0]
    if count == 0:
        return
    pairs, modes, kin = contact_pairs_of(model), contact_modes_of(model), kinematics_of(work)
    first = dy.shape[0] - 2 * count
    for k in range(pairs.kind.shape[0]):
        if pairs.deflection[k] < 0:
            continue
        place = first + 2 * pairs.deflection[k]
        dy[place] = 0.0
        dy[place + 1] = 0.0
        if modes.mode[k] == MODE_CLOSED and modes.grip[k] == GRIP_STICK:
            dy[place], dy[place + 1] = slip_along(contact_geometry(pairs, kin, k))
