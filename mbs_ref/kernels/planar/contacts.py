"""Shapes of the plane (mbs_ref.kernels.rigid.shapes), and friction along the tangent, the normal turned by -90 degrees.

A sticking contact has a spring that is slack at the place `anchor` along a line. Sliding has a sign; its `anchor` is
the slip velocity against it (m/s, not positive) with which it began, a remainder of the stop before.
"""

import math

from mbs_ref.kernels.contact import laws as law
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.planar.marks import dot, over, perpendicular, plus, times, turned
from mbs_ref.kernels.rigid.shapes import Surface, on_round, tooth_gap, tooth_wall


@bare
def _on_line(pairs, k, x, tangent, rolled):
    """Return the Surface of a line, a segment or a capped segment."""
    normal, radius = perpendicular(tangent), pairs.radius[k]
    along, above = dot(x, tangent), dot(x, normal)
    held, beyond = along + rolled, abs(along) - pairs.half[k, 0]
    if pairs.ends[k] == law.ENDS_OPEN:
        return Surface(above - radius, normal, beyond, radius, held)
    if pairs.ends[k] == law.ENDS_CAPPED and beyond > 0.0:
        px = math.copysign(beyond, along)
        distance = math.sqrt(px * px + above * above)
        outward = over(plus(times(px, tangent), times(above, normal)), distance)
        return Surface(distance - radius, outward, -math.inf, radius, held)
    return Surface(above - radius, normal, -math.inf, radius, held)


@bare
def surface(model, work, k, x):
    pairs = model.contact_pairs
    a, b = pairs.a[k], pairs.b[k]
    if pairs.kind[k] == law.PAIR_ROUND:
        return on_round(work, pairs, k, x, (0.0, 1.0), 0.0)
    direction = turned(work, b, pairs.axes[k, 0])
    if pairs.kind[k] == law.PAIR_SPROCKET:
        return tooth_wall(pairs, k, x, direction, 0.0)
    motion = work.kinematics.motion
    return _on_line(pairs, k, x, direction, pairs.radius[k] * (motion[a, 3] - motion[b, 3]))


@bare
def outwards(model, work, k, x):
    pairs = model.contact_pairs
    direction = turned(work, pairs.b[k], pairs.axes[k, 0])
    if pairs.kind[k] == law.PAIR_FLAT:
        return times(math.copysign(1.0, dot(x, direction)), direction)
    return tooth_gap(pairs, k, x, direction)


slip = bare(lambda n, u, closing: n[1] * u[0] - n[0] * u[1])


@bare
def _friction(laws, modes, k, normal, touch):
    """Return the force on body a along the tangent."""
    if laws.friction[k] == law.FRICTION_SMOOTH:
        return -laws.coefficient[k] * normal * math.tanh(touch.slip / laws.creep[k])
    grip = modes.grip[k]
    if grip == law.GRIP_STICK:
        return -laws.grip_stiffness[k] * (touch.held - modes.anchor[k, 0]) - laws.grip_damping[k] * touch.slip
    if grip == law.GRIP_PROBE:
        return modes.anchor[k, 0]
    return -laws.coefficient[k] * normal * grip


@bare
def friction_force(model, work, k, touch, normal):
    tangential = _friction(model.contact_laws, model.contact_modes, k, normal, touch)
    return tangential * touch.normal[1], -tangential * touch.normal[0]


slip_of = bare(lambda model, touch: (touch.slip,))


@jit
def grip_force(model, work, k, touch, normal):
    return (_friction(model.contact_laws, model.contact_modes, k, normal, touch),)


@jit
def ahead(model, k, touch):
    modes = model.contact_modes
    return modes.grip[k] * touch.slip - modes.anchor[k, 0]


has_stopped = jit(lambda model, k, touch: True)


@jit
def start_grip(model, k, touch):
    model.contact_modes.anchor[k, 0] = touch.held


stop_together = jit(lambda model, work, y, g: None)


@jit
def stick(model, y, k, touch, force):
    laws, modes = model.contact_laws, model.contact_modes
    modes.anchor[k, 0] = touch.held + force[0] / laws.grip_stiffness[k]


@jit
def slide_along(model, k, touch, sign, u):
    modes = model.contact_modes
    modes.grip[k] = law.GRIP_BACKWARD if sign * u[0] < 0.0 else law.GRIP_FORWARD
    modes.anchor[k, 0] = min(modes.grip[k] * touch.slip, 0.0)
