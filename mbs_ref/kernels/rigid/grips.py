"""Stick-slip friction at events: its functions, its changes, and the friction that keeps stopped contacts at rest.

The slip velocities' rates are linear in the friction forces, which are probed one direction of search at a time.
"""

import numpy as np

from mbs_ref.kernels.border.questions import derivative, slip_velocities
from mbs_ref.kernels.contact.laws import FRICTION_STICK_SLIP, GRIP_PROBE, GRIP_STICK, normal_force
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.landing import contact_mass
from mbs_ref.kernels.rigid.shapes import contact_geometry

DIFFERENCE = 1e-4  # of the sticking springs' time scale: step of the differences along the motion
ACCURACY = 1e-30  # of the square of the slip rates: less is roundoff
INTERNAL = 1e-6  # of the largest mobility under a load: below, forces push corners of one block against each other


@bare
def _size(u):
    square = 0.0
    for c in range(len(u)):
        square += u[c] * u[c]
    return np.sqrt(square)


@jit
def grip_margin(model, work, k, touch):
    """Return how much more force sticking bears, or the speed along what is frozen, in units of their roundoff."""
    laws, modes = model.contact_laws, model.contact_modes
    if modes.grip[k] != GRIP_STICK:
        return core.ahead(model, k, touch) / modes.noise[1]
    normal = normal_force(laws, modes, k, -touch.gap, -touch.closing)
    margin = laws.static[k] * normal - _size(core.grip_force(model, work, k, touch, normal))
    return margin / (modes.noise[0] * laws.grip_stiffness[k] + modes.noise[1] * laws.grip_damping[k])


@jit
def take_grip(model, y, k, touch):
    """Slide where there is a slip velocity; stick, unloaded, where there is none."""
    if model.contact_laws.friction[k] != FRICTION_STICK_SLIP:
        return
    slip = core.slip_of(model, touch)
    if is_still(slip):
        model.contact_modes.grip[k] = GRIP_STICK
        core.stick(model, y, k, touch, slip)
    else:
        core.slide_along(model, k, touch, 1.0, slip)


@jit
def change_grip(model, work, k, touch):
    """End a mode of friction; return whether the contact has stopped and is to be probed."""
    laws, modes = model.contact_laws, model.contact_modes
    if modes.grip[k] != GRIP_STICK:
        return core.has_stopped(model, k, touch)
    normal = normal_force(laws, modes, k, -touch.gap, -touch.closing)
    core.slide_along(model, k, touch, -1.0, core.grip_force(model, work, k, touch, normal))
    return False


@jit
def probe(modes, k):
    """Let the friction of contact k be what is probed, at first none."""
    modes.grip[k] = GRIP_PROBE
    for c in range(modes.anchor.shape[1]):
        modes.anchor[k, c] = 0.0


@jit
def is_still(slip):
    """Return whether no slip velocity differs from zero."""
    fastest = 0.0
    for speed in slip:
        fastest = max(fastest, abs(speed))
    return fastest == 0.0


@jit
def rigid_slip_velocities(model, work, y, out):
    modes = model.contact_modes
    core.load_state(model, work, y)
    for k in range(out.shape[0]):
        if modes.grip[k] == GRIP_PROBE:
            slip = core.slip_of(model, contact_geometry(model, work, k))
            for c in range(len(slip)):
                out[k, c] = slip[c]


@jit
def rigid_settle_grips(model, work, t, y, dy):
    """Let the stopped contacts stick where mu_s allows what holds them, else slide on against it."""
    pairs, laws, modes = model.contact_pairs, model.contact_laws, model.contact_modes
    count = pairs.kind.shape[0]
    loads, force = np.zeros(count), np.zeros((count, modes.anchor.shape[1]))
    core.load_state(model, work, y)
    for k in range(count):
        if modes.grip[k] == GRIP_PROBE:
            touch = contact_geometry(model, work, k)
            loads[k] = max(normal_force(laws, modes, k, -touch.gap, -touch.closing), 0.0)
    if np.sum(loads) > 0.0:
        _hold(model, work, t, y, dy, loads, force)
    core.load_state(model, work, y)
    for k in range(count):
        if modes.grip[k] != GRIP_PROBE:
            continue
        touch = contact_geometry(model, work, k)
        if _size(force[k]) <= laws.static[k] * loads[k]:
            modes.grip[k] = GRIP_STICK
            core.stick(model, y, k, touch, force[k])
        else:
            core.slide_along(model, k, touch, -1.0, force[k])


@jit
def _stick_time(model):
    """Return the least sqrt(m / k) (s) of the springs of the contacts under probe."""
    laws, modes, least = model.contact_laws, model.contact_modes, np.inf
    for k in range(laws.grip_stiffness.shape[0]):
        if modes.grip[k] == GRIP_PROBE:
            least = min(least, np.sqrt(contact_mass(model, k) / laws.grip_stiffness[k]))
    return least


@jit
def _slip_rates(model, work, t, y, dy, force, step, rates):
    """Fill the rates (m/s^2) of the slip velocities under probe forces (N), by differences along the motion."""
    modes = model.contact_modes
    for k in range(force.shape[0]):
        if modes.grip[k] == GRIP_PROBE:
            for c in range(force.shape[1]):
                modes.anchor[k, c] = force[k, c]
    derivative(model, work, t, y, dy)
    before = np.zeros_like(rates)
    slip_velocities(model, work, y - step * dy, before)
    slip_velocities(model, work, y + step * dy, rates)
    rates[:] = (rates - before) / (2.0 * step)


@jit
def _hold(model, work, t, y, dy, loads, force):
    """Fill `force` (n_contacts, tangents) with the friction (N) that keeps the contacts under probe from slipping.

    Conjugate gradients (Hestenes and Stiefel 1952). Where it is not unique, as under the corners of one block,
    preconditioning by the normal `loads` (n_contacts,) shares it in proportion to them: sum |F|^2 / N is least.
    Slip rates of a turning block have a part that no force changes: forces within it are sought inside the cones alone.
    """
    step = DIFFERENCE * _stick_time(model)
    base, change = np.zeros_like(force), np.zeros_like(force)
    _slip_rates(model, work, t, y, dy, force, step, base)
    weight = loads.reshape(-1, 1)
    residual = -base
    direction = weight * residual
    square = np.sum(residual * direction)
    least, stiffest = ACCURACY * square, 0.0
    for _ in range(force.size + 2):
        if square <= least:
            break
        scale = np.sum(loads) / np.sum(np.abs(direction))  # a small force would be lost in the roundoff of `base`
        _slip_rates(model, work, t, y, dy, scale * direction, step, change)
        change = (change - base) / scale
        curvature = np.sum(direction * change)
        mobility = curvature / np.sum(direction**2 / np.maximum(weight, 1e-300))
        stiffest = max(stiffest, mobility)
        length = square / curvature
        after = force + length * direction
        beyond = np.any(np.sum(after**2, axis=1) > (model.contact_laws.static * loads) ** 2)
        if not mobility > INTERNAL * stiffest and beyond:
            break
        force[:] = after
        residual -= length * change
        before = square
        square = np.sum(residual * (weight * residual))
        direction = weight * residual + square / before * direction
