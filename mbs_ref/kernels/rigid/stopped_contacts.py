"""Contacts that have stopped sliding: the friction that would keep them at rest, in the plane and in space.

The slip velocities' rates are linear in the friction forces, which are probed one direction of search at a time.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.kernels.border.questions import derivative, slip_velocities
from mbs_ref.kernels.contact.laws import GRIP_PROBE
from mbs_ref.kernels.jit import jit

DIFFERENCE = 1e-3  # of the sticking springs' time scale: step of the differences along the motion
ACCURACY = 1e-18  # of the square of what is left of the slip rates: what differences resolve


@jit
def _stick_time(modes, stiffness, a, b, mass):
    """Return the least sqrt(m / k) (s) of the springs of the contacts under probe."""
    least = np.inf
    for k in range(a.shape[0]):
        if modes.grip[k] == GRIP_PROBE:
            total = 0.0
            for body in (a[k], b[k]):
                if body < mass.shape[0]:
                    total += mass[body]
            least = min(least, np.sqrt(total / stiffness[k]))
    return least


@jit
def _slip_rates(model, work, t, y, dy, modes, force, step, rates):
    """Fill the rates (m/s^2) of the slip velocities under probe forces (N), by differences along the motion."""
    for k in range(force.shape[0]):
        if modes.grip[k] == GRIP_PROBE:
            for c in range(force.shape[1]):
                modes.anchor[k, c] = force[k, c]
    derivative(model, work, t, y, dy)
    before = np.zeros_like(rates)
    slip_velocities(model, work, y - step * dy, before)
    slip_velocities(model, work, y + step * dy, rates)
    for k in range(rates.shape[0]):
        for c in range(rates.shape[1]):
            rates[k, c] = (rates[k, c] - before[k, c]) / (2.0 * step)


@jit
def holding_forces(model, work, t, y, dy, modes, stiffness, a, b, mass, loads, force):
    """Fill `force` (n_contacts, tangents) with the friction (N) that keeps the contacts under probe from slipping.

    Conjugate gradients (Hestenes and Stiefel 1952). Where it is not unique, as under the corners of one block,
    preconditioning by the normal `loads` (n_contacts,) shares it in proportion to them: sum |F|^2 / N is least.
    """
    step = DIFFERENCE * _stick_time(modes, stiffness, a, b, mass)
    base, change = np.zeros_like(force), np.zeros_like(force)
    _slip_rates(model, work, t, y, dy, modes, force, step, base)
    weight = loads.reshape(-1, 1)
    residual = -base
    direction = weight * residual
    square = np.sum(residual * direction)
    least = ACCURACY * square
    for _ in range(force.size + 2):
        if square <= least:
            break
        _slip_rates(model, work, t, y, dy, modes, direction, step, change)
        change -= base
        curvature = np.sum(direction * change)
        if not curvature > 0.0:
            break
        length = square / curvature
        force += length * direction
        residual -= length * change
        before = square
        square = np.sum(residual * (weight * residual))
        direction = weight * residual + square / before * direction
