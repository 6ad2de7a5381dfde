"""Contact laws of every core: F = k d^n + c d^m d', with friction; and the modes that events switch.

The normal force and the rules that end a mode know nothing of shapes, so that the plane and space share them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.jit import jit

RELEASE_GAP, RELEASE_FORCE, RELEASE_RIGID, RELEASE_CONSTRAINT = range(4)
FRICTION_NONE, FRICTION_SMOOTH, FRICTION_STICK_SLIP = range(3)
ENDS_NONE, ENDS_OPEN, ENDS_CAPPED = range(3)
# PLAIN: no events, the force is clipped by the state. LIFTED: still inside after a release at F = 0.
# BEHIND: found too deep to have come through the front. LEAVING: rigid, just hit, not yet clear.
MODE_OPEN, MODE_CLOSED, MODE_LIFTED, MODE_BEHIND, MODE_LEAVING, MODE_PLAIN = range(6)
GRIP_BACKWARD, GRIP_STICK, GRIP_FORWARD, GRIP_PROBE = -1, 0, 1, 2
ROOTS_EACH = 3  # event functions of a contact, a tension-only spring or a watch


class ContactLaws(NamedTuple):
    """F = k d^n + c d^m d' with c = damping + impact_damping k / v0, and friction."""

    stiffness: np.ndarray  # (k,) N/m^n
    damping: np.ndarray  # (k,) N s/m^(m + 1)
    exponent: np.ndarray  # (k,) n
    damping_exponent: np.ndarray  # (k,) m
    impact_damping: np.ndarray  # (k,) -, what stands before d'/v0
    slowest: np.ndarray  # (k,) m/s, least v0
    release: np.ndarray  # (k,) int, RELEASE_*
    restitution: np.ndarray  # (k,) -, of a rigid contact
    friction: np.ndarray  # (k,) int, FRICTION_*
    coefficient: np.ndarray  # (k,) mu
    static: np.ndarray  # (k,) mu_s
    creep: np.ndarray  # (k,) m/s, v_s
    grip_stiffness: np.ndarray  # (k,) N/m
    grip_damping: np.ndarray  # (k,) N s/m
    slot: np.ndarray  # (k,) int, of the row gap = 0 of a constraint contact; -1 for others


class ContactModes(NamedTuple):
    """What changes at events alone, frozen inside a step.

    Of contacts, then in the plane of tension-only springs and watches.
    """

    mode: np.ndarray  # (k,) int, MODE_*; of a watch, the side it is on: 1 above its value, -1 below
    grip: np.ndarray  # (k,) int, GRIP_*; in space FORWARD is sliding in any direction
    anchor: np.ndarray  # (k,) m, where a sticking contact's spring is slack; in space (k, 2) the direction of sliding;
    # in both a force (N) while GRIP_PROBE
    dashpot: np.ndarray  # (k,) N s/m^(m + 1), c in force
    stamp: np.ndarray  # (k,) s, time of the contact's last event
    burst: np.ndarray  # (k,) int, events since then without a pause
    roots: np.ndarray  # (1,) int, event functions watched; 0 without contacts and in the plain mode
    noise: np.ndarray  # (1,) m and m/s, how far past its root a function must be: roundoff must not switch modes
    log: np.ndarray  # (most, 6 or 7) time (s), contact, mode, grip, anchor, dashpot after each event
    logged: np.ndarray  # (1,) int, events so far; beyond `most` they are only counted


def no_laws() -> ContactLaws:
    """Return the laws of a scene without contact."""
    integers, floats = np.zeros(0, dtype=np.int64), np.zeros(0)
    counted = ("release", "friction", "slot")
    return ContactLaws(*(integers if name in counted else floats for name in ContactLaws._fields))


def fresh_modes(count: int, noise: float, most_logged: int, anchors: int | None = None) -> ContactModes:
    """Return the modes of `count` contacts before a run has settled them; `anchors` numbers each in space."""
    integers = [np.zeros(count, dtype=np.int64) for _ in range(3)]
    floats = [np.zeros(count) for _ in range(2)]
    return ContactModes(
        mode=integers[0],
        grip=integers[1],
        anchor=np.zeros(count) if anchors is None else np.zeros((count, anchors)),
        dashpot=floats[0],
        stamp=floats[1],
        burst=integers[2],
        roots=np.zeros(1, dtype=np.int64),
        noise=np.array([noise]),
        log=np.zeros((most_logged if count else 0, 5 + (anchors or 1))),
        logged=np.zeros(1, dtype=np.int64),
    )


@jit
def normal_force(laws, modes, k, depth, rate):
    """Return F = k d^n + c d^m d' without any clipping; d' is `rate`."""
    elastic = depth
    if laws.exponent[k] != 1.0:
        elastic = math.copysign(abs(depth) ** laws.exponent[k], depth)
    weight = 1.0
    if laws.damping_exponent[k] == 1.0:
        weight = depth
    elif laws.damping_exponent[k] != 0.0:
        weight = math.copysign(abs(depth) ** laws.damping_exponent[k], depth)
    return laws.stiffness[k] * elastic + modes.dashpot[k] * weight * rate
