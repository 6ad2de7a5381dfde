"""Shapes of space (mbs_ref.kernels.rigid.shapes), and friction along the edges of the plane of contact.

Where a contact slides, friction opposes the slip velocity in the tangent plane; where it sticks, two springs along the
edges carry it, and their deflections are states: how far a rolling sphere has slipped is no function of its pose.
Sliding keeps a frozen direction. Its function is positive while the slip velocity is within 60 degrees of it:
at the root the direction follows the slip, or, where the slip has come to a stop, the contact sticks or slides
on in the direction that its own acceleration takes.
"""

import math

from mbs_ref.kernels.algebra.lanes import WIDTH, in_floats
from mbs_ref.kernels.border.handles import alone
from mbs_ref.kernels.border.questions import fill_deflection_rates
from mbs_ref.kernels.contact import laws as law
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid.shapes import Surface, contact_geometry, on_round, tooth_gap, tooth_wall
from mbs_ref.kernels.spatial.marks import dot, minus, over, plus, times, turned
from mbs_ref.kernels.spatial.orientation import load_state


@bare
def _on_plane(pairs, k, x, edges, n):
    """Return the Surface of a plane, a rectangle or a capped rectangle."""
    (e, f), radius = edges, pairs.radius[k]
    along, across, above = dot(x, e), dot(x, f), dot(x, n)
    past_e, past_f = abs(along) - pairs.half[k, 0], abs(across) - pairs.half[k, 1]
    if pairs.ends[k] == law.ENDS_OPEN:
        return Surface(above - radius, n, max(past_e, past_f), radius, edges)
    if pairs.ends[k] == law.ENDS_CAPPED and (past_e > 0.0 or past_f > 0.0):
        p = math.copysign(max(past_e, 0.0), along)
        q = math.copysign(max(past_f, 0.0), across)
        distance = math.sqrt(p * p + q * q + above * above)
        outward = over(plus(plus(times(p, e), times(q, f)), times(above, n)), distance)
        return Surface(distance - radius, outward, -math.inf, radius, edges)
    return Surface(above - radius, n, -math.inf, radius, edges)


@bare
def _edges(work, pairs, k):
    return turned(work, pairs.b[k], pairs.axes[k, 0]), turned(work, pairs.b[k], pairs.axes[k, 1])


@bare
def surface(model, work, k, x):
    pairs = model.contact_pairs
    n = turned(work, pairs.b[k], pairs.axes[k, 2])
    if pairs.kind[k] == law.PAIR_FLAT:
        return _on_plane(pairs, k, x, _edges(work, pairs, k), n)
    e, f = _edges(work, pairs, k)
    if pairs.kind[k] == law.PAIR_ROUND:
        return on_round(work, pairs, k, x, n, (e, f))
    wall = tooth_wall(pairs, k, (dot(x, e), dot(x, f)), (1.0, 0.0), (e, f))
    normal = plus(times(wall.normal[0], e), times(wall.normal[1], f))
    return Surface(wall.gap, normal, wall.beyond, wall.back, wall.held)


@bare
def outwards(model, work, k, x):
    pairs = model.contact_pairs
    e, f = _edges(work, pairs, k)
    along, across = dot(x, e), dot(x, f)
    if pairs.kind[k] != law.PAIR_FLAT:
        gap = tooth_gap(pairs, k, (along, across), (1.0, 0.0))
        return plus(times(gap[0], e), times(gap[1], f))
    if abs(along) - pairs.half[k, 0] >= abs(across) - pairs.half[k, 1]:
        return times(math.copysign(1.0, along), e)
    return times(math.copysign(1.0, across), f)


slip = bare(lambda n, u, closing: minus(u, times(closing, n)))


COSINE = 0.5  # of the angle between slip and frozen direction at which the direction is frozen anew
TOGETHER = 10.0  # of the slip velocity that counts as a stop: so slow, a contact stops along with another one
# Below this many times `modes.slow` the direction of sliding is the frozen one. A step that ends where sliding stops
# evaluates friction there; across the slip, its derivative mu N / (m v) turns roundoff of eps into eps / v, which has
# to stay far below `slow`: with v = 1e3 slow it is 1e-2 slow.
SLUGGISH = 1e3


slip_of = bare(lambda model, touch: (dot(touch.slip, touch.held[0]), dot(touch.slip, touch.held[1])))


@bare
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


@bare
def grip_force(model, work, k, touch, normal):
    laws, modes = model.contact_laws, model.contact_modes
    along, across = slip_of(model, touch)
    if modes.grip[k] == law.GRIP_PROBE:
        return modes.anchor[k, 0], modes.anchor[k, 1]
    if modes.grip[k] == law.GRIP_STICK:
        spring = work.grips.deflection[model.contact_pairs.deflection[k]]
        stiffness, damping = laws.grip_stiffness[k], laws.grip_damping[k]
        return -stiffness * spring[0] - damping * along, -stiffness * spring[1] - damping * across
    return _slide(laws, modes, k, normal, along, across)


@bare
def friction_force(model, work, k, touch, normal):
    laws = model.contact_laws
    if laws.friction[k] == law.FRICTION_SMOOTH:
        return times(law.drag(laws, k, normal, math.sqrt(dot(touch.slip, touch.slip))), touch.slip)
    p, q = grip_force(model, work, k, touch, normal)
    return plus(times(p, touch.held[0]), times(q, touch.held[1]))


@jit
def ahead(model, k, touch):
    along, across = slip_of(model, touch)
    anchor = model.contact_modes.anchor[k]
    return anchor[0] * along + anchor[1] * across - COSINE * math.sqrt(along * along + across * across)


@jit
def has_stopped(model, k, touch):
    along, across = slip_of(model, touch)
    if math.sqrt(along * along + across * across) > model.contact_modes.slow[0]:  # it turns
        slide_along(model, k, touch, 1.0, (along, across))
        return False
    return True


@jit
def start_grip(model, k, touch):
    modes = model.contact_modes
    modes.anchor[k, 0], modes.anchor[k, 1] = 1.0, 0.0


@jit
def stick(model, y, k, touch, force):
    pairs, laws = model.contact_pairs, model.contact_laws
    place = y.shape[0] - 2 * pairs.sticking[0] + 2 * pairs.deflection[k]
    y[place] = -force[0] / laws.grip_stiffness[k]
    y[place + 1] = -force[1] / laws.grip_stiffness[k]


@jit
def slide_along(model, k, touch, sign, u):
    modes = model.contact_modes
    speed = math.sqrt(u[0] * u[0] + u[1] * u[1])
    modes.grip[k] = law.GRIP_FORWARD
    modes.anchor[k, 0] = sign * u[0] / speed
    modes.anchor[k, 1] = sign * u[1] / speed


@jit
def stop_together(model, work, y, g):
    """Probe every other sliding contact that is as good as at rest: the corners of one block stop at once.

    Their functions in g turn negative, as of all that change.
    """
    laws, modes = model.contact_laws, model.contact_modes
    load_state(model, work, y)
    for k in range(modes.grip.shape[0]):
        closed = modes.mode[k] == law.MODE_CLOSED and laws.friction[k] == law.FRICTION_STICK_SLIP
        if not closed or modes.grip[k] != law.GRIP_FORWARD:
            continue
        along, across = slip_of(model, contact_geometry(model, work, k))
        if math.sqrt(along * along + across * across) <= TOGETHER * modes.slow[0]:
            modes.grip[k] = law.GRIP_PROBE
            g[law.ROOTS_EACH * k + 2] = -1.0


@jit
def spatial_fill_deflection_rates(model, work, dy):
    """Write the rates of the sticking deflections: the slip velocity while a contact sticks, else none."""
    count = work.grips.deflection.shape[0]
    if count == 0:
        return
    pairs, modes = model.contact_pairs, model.contact_modes
    first = dy.shape[0] - 2 * count
    for k in range(pairs.kind.shape[0]):
        if pairs.deflection[k] < 0:
            continue
        place = first + 2 * pairs.deflection[k]
        dy[place] = 0.0
        dy[place + 1] = 0.0
        if modes.mode[k] == law.MODE_CLOSED and modes.grip[k] == law.GRIP_STICK:
            dy[place], dy[place + 1] = slip_of(model, contact_geometry(model, work, k))


@jit
def lanes_fill_deflection_rates(model, work, dy):
    """Let the system of each lane write the rates of its deflections; it has evaluated the loads of the same state."""
    count, beside, every = work.grips.deflection.shape[0], work.beside, in_floats(dy)
    for w in range(WIDTH if count > 0 else 0):
        if beside.model[w] != 0:
            its = alone(work, beside.work[w])
            own_dy = its.solved.state
            fill_deflection_rates(alone(model, beside.model[w]), its, own_dy)
            for k in range(dy.shape[0] - 2 * count, dy.shape[0]):
                every[k, w] = own_dy[k]
