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
from mbs_ref.kernels.spatial.marks import push
from mbs_ref.kernels.spatial.model import (
    PAIR_PLANE,
    contact_laws_of,
    contact_modes_of,
    contact_pairs_of,
    grips_of,
    kinematics_of,
    near_pairs_of,
)
from mbs_ref.kernels.spatial.vectors import cross, dot, minus, negative, over, plus, put, times, turn

# Below this many times `modes.slow` the direction of sliding is the frozen one. A step that ends where sliding stops
# evaluates friction there; across the slip, its derivative mu N / (m v) turns roundoff of eps into eps / v, which has
# to stay far below `slow`: with v = 1e3 slow it is 1e-2 slow.
SLUGGISH = 1e3


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
    along, across, above = dot(x, e), dot(x, f), dot(x, n)
    past_e = abs(along) - pairs.half[k, 0]
    past_f = abs(across) - pairs.half[k, 1]
    if pairs.ends[k] == ENDS_OPEN:
        return above - pairs.radius[k], n, max(past_e, past_f)
    if pairs.ends[k] == ENDS_CAPPED and (past_e > 0.0 or past_f > 0.0):
        p = math.copysign(max(past_e, 0.0), along)
        q = math.copysign(max(past_f, 0.0), across)
        distance = math.sqrt(p * p + q * q + above * above)
        outward = over(plus(plus(times(p, e), times(q, f)), times(above, n)), distance)
        return distance - pairs.radius[k], outward, -1.0
    return above - pairs.radius[k], n, -1.0


@jit
def _on_sphere(pairs, k, x, n):
    distance = math.sqrt(dot(x, x))
    if distance == 0.0:
        return -pairs.radius[k] - pairs.half[k, 0], n, -1.0
    return distance - pairs.radius[k] - pairs.half[k, 0], over(x, distance), -1.0


@jit
def _places(pairs, kin, k):
    """Return the way between the bodies, the arm of the sphere's centre, and the way to it from the other's origin."""
    a, b = pairs.a[k], pairs.b[k]
    c = turn(kin.turned[a], pairs.center[k])
    apart = minus(kin.position[a], kin.position[b])
    return apart, c, minus(plus(apart, c), turn(kin.turned[b], pairs.origin[k]))


@jit
def contact_geometry(model, work, k):
    """Return the Touch of a pair."""
    pairs, kin = contact_pairs_of(model), kinematics_of(work)
    a, b = pairs.a[k], pairs.b[k]
    apart, c, x = _places(pairs, kin, k)
    e = turn(kin.turned[b], pairs.axes[k, 0])
    f = turn(kin.turned[b], pairs.axes[k, 1])
    n = turn(kin.turned[b], pairs.axes[k, 2])
    if pairs.kind[k] == PAIR_PLANE:
        gap, n, beyond = _on_plane(pairs, k, x, e, f, n)
    else:
        gap, n, beyond = _on_sphere(pairs, k, x, n)
    on_a = minus(c, times(pairs.radius[k], n))
    on_b = plus(apart, on_a)
    u = plus(kin.velocity[a], cross(kin.omega[a], on_a))
    u = minus(minus(u, kin.velocity[b]), cross(kin.omega[b], on_b))
    closing = dot(n, u)
    return Touch(gap, closing, beyond, n, minus(u, times(closing, n)), on_a, on_b, e, f)


@jit
def leaving_ends(model, work, k):
    """Return the rate (m/s) of the excess over open ends of a plane."""
    pairs, kin = contact_pairs_of(model), kinematics_of(work)
    a, b = pairs.a[k], pairs.b[k]
    apart, c, x = _places(pairs, kin, k)
    e, f = turn(kin.turned[b], pairs.axes[k, 0]), turn(kin.turned[b], pairs.axes[k, 1])
    along, across = dot(x, e), dot(x, f)
    u = minus(kin.velocity[a], kin.velocity[b])
    u = minus(plus(u, cross(kin.omega[a], c)), cross(kin.omega[b], plus(apart, c)))
    if abs(along) - pairs.half[k, 0] >= abs(across) - pairs.half[k, 1]:
        return math.copysign(1.0, along) * dot(u, e)
    return math.copysign(1.0, across) * dot(u, f)


@jit
def slip_along(touch):
    """Return the slip velocity along the plane's edges, m/s."""
    return dot(touch.slip, touch.edge_1), dot(touch.slip, touch.edge_2)


@jit
def is_behind(pairs, k, gap):
    """Return whether a depth is more than the surface is thick."""
    return pairs.kind[k] == PAIR_PLANE and -gap > pairs.thickness[k]


@jit
def _slide(laws, modes, k, normal, along, across):
    """Return mu N against the slip velocity.

    Smooth through a stop: the slip along the frozen direction counts as positive, and as no less than SLUGGISH.
    """
    d0 = modes.anchor[k, 0]
    d1 = modes.anchor[k, 1]
    ahead = d0 * along + d1 * across
    aside0 = along - ahead * d0
    aside1 = across - ahead * d1
    ahead = max(abs(ahead), SLUGGISH * modes.slow[0])
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
    if laws.friction[k] == FRICTION_SMOOTH:
        speed = math.sqrt(dot(touch.slip, touch.slip))
        ratio = speed / laws.creep[k]
        share = 1.0 / laws.creep[k] if ratio < 1e-8 else math.tanh(ratio) / speed
        return times(share * (-laws.coefficient[k] * normal), touch.slip)
    along, across = slip_along(touch)
    p, q = grip_force(laws, modes, grips, pairs, k, normal, along, across)
    return plus(times(p, touch.edge_1), times(q, touch.edge_2))


@jit
def find_near(model, work):
    """Bring the list of near pairs up to the pose in `work`."""
    near, kin = near_pairs_of(model), kinematics_of(work)
    for s in range(near.body.shape[0]):
        body = near.body[s]
        put(near.place[s], 0, plus(kin.position[body], turn(kin.turned[body], near.center[s])))
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
    friction = friction_force(laws, modes, grips_of(work), pairs, k, normal, touch)
    return plus(times(normal, touch.normal), friction)


@jit
def spatial_apply_contacts(model, work):
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
        touch = contact_geometry(model, work, k)
        if not is_touching(pairs, modes, k, touch):
            continue
        force = contact_force(model, work, k, touch)
        push(kin, pairs.a[k], touch.arm_a, force)
        push(kin, pairs.b[k], touch.arm_b, negative(force))


@jit
def spatial_fill_deflection_rates(model, work, dy):
    """Write the rates of the sticking deflections: the slip velocity while a contact sticks, else none."""
    count = grips_of(work).deflection.shape[0]
    if count == 0:
        return
    pairs, modes = contact_pairs_of(model), contact_modes_of(model)
    first = dy.shape[0] - 2 * count
    for k in range(pairs.kind.shape[0]):
        if pairs.deflection[k] < 0:
            continue
        place = first + 2 * pairs.deflection[k]
        dy[place] = 0.0
        dy[place + 1] = 0.0
        if modes.mode[k] == MODE_CLOSED and modes.grip[k] == GRIP_STICK:
            dy[place], dy[place + 1] = slip_along(contact_geometry(model, work, k))
