"""Friction in the plane: along the tangent, which is the normal turned by -90 degrees.

A sticking contact has a spring that is slack at the place `anchor` along a line. Sliding has a sign; its `anchor` is
the slip velocity against it (m/s, not positive) with which it began, a remainder of the stop before.
"""

import math

from mbs_ref.kernels.contact.laws import FRICTION_SMOOTH, GRIP_BACKWARD, GRIP_FORWARD, GRIP_PROBE, GRIP_STICK
from mbs_ref.kernels.jit import bare, jit


@bare
def _friction(laws, modes, k, normal, touch):
    """Return the force on body a along the tangent."""
    if laws.friction[k] == FRICTION_SMOOTH:
        return -laws.coefficient[k] * normal * math.tanh(touch.slip / laws.creep[k])
    grip = modes.grip[k]
    if grip == GRIP_STICK:
        return -laws.grip_stiffness[k] * (touch.held - modes.anchor[k, 0]) - laws.grip_damping[k] * touch.slip
    if grip == GRIP_PROBE:
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
    modes.grip[k] = GRIP_BACKWARD if sign * u[0] < 0.0 else GRIP_FORWARD
    modes.anchor[k, 0] = min(modes.grip[k] * touch.slip, 0.0)
