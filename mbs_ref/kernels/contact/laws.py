"""Contact laws of every core: F = k d^n + c d^m d', with friction; and the modes that events switch.

The normal force and the rules that end a mode know nothing of shapes, so that the plane and space share them.
"""

import math
from typing import Annotated, NamedTuple

import numpy as np

from mbs_ref.kernels.border.groups import Floats, Ints, empty
from mbs_ref.kernels.jit import bare

RELEASE_GAP, RELEASE_FORCE, RELEASE_RIGID, RELEASE_CONSTRAINT = range(4)
FRICTION_NONE, FRICTION_SMOOTH, FRICTION_STICK_SLIP = range(3)
ENDS_NONE, ENDS_OPEN, ENDS_CAPPED = range(3)
PAIR_FLAT, PAIR_ROUND, PAIR_SPROCKET = range(3)  # on a line or plane, on a circle or sphere, in a sprocket
# PLAIN: no events, the force is clipped by the state. LIFTED: still inside after a release at F = 0.
# BEHIND: too deep to have come through the front. LEAVING: rigid, just hit, not yet clear. LIMITED: of a spring.
MODE_OPEN, MODE_CLOSED, MODE_LIFTED, MODE_BEHIND, MODE_LEAVING, MODE_PLAIN, MODE_LIMITED = range(7)
GRIP_BACKWARD, GRIP_STICK, GRIP_FORWARD, GRIP_PROBE = -1, 0, 1, 2
ROOTS_EACH = 4  # event functions of a contact, a tension-only spring or a watch
ENDS = 3  # that of a contact's open ends
# Rows of a table of event functions: the function, its rate where known, else 0, a bound on its rate at these
# velocities while the bodies turn little, UNKNOWN where there is none, and how fast they turn (rad/s).
VALUE, RATE, SPEED, TURN = range(4)
UNKNOWN = -1.0
LEFT_OUT = -2.0  # instead of the bound of a source's first function, before an evaluation: none of its four is needed
TURNED = -math.inf  # value of friction's function where only the direction of sliding is frozen anew: no event


class ContactLaws(NamedTuple):
    """F = k d^n + c d^m d' with c = damping + impact_damping k / v0, and friction."""

    stiffness: Annotated[Floats, "k"]  # N/m^n
    damping: Annotated[Floats, "k"]  # N s/m^(m + 1)
    exponent: Annotated[Floats, "k"]  # n
    damping_exponent: Annotated[Floats, "k"]  # m
    impact_damping: Annotated[Floats, "k"]  # -, what stands before d'/v0
    slowest: Annotated[Floats, "k"]  # m/s, least v0
    release: Annotated[Ints, "k"]  # RELEASE_*
    restitution: Annotated[Floats, "k"]  # -, of a rigid contact
    friction: Annotated[Ints, "k"]  # FRICTION_*
    coefficient: Annotated[Floats, "k"]  # mu
    static: Annotated[Floats, "k"]  # mu_s
    creep: Annotated[Floats, "k"]  # m/s, v_s
    grip_stiffness: Annotated[Floats, "k"]  # N/m
    grip_damping: Annotated[Floats, "k"]  # N s/m
    lever: Annotated[Floats, "k"]  # m, of rolling resistance; 0 for none
    roll: Annotated[Floats, "k"]  # rad/s, w_s
    slot: Annotated[Ints, "k"]  # of the row gap = 0 of a constraint contact; -1 for others


class ContactModes(NamedTuple):
    """What changes at events alone, frozen inside a step.

    Of contacts, then of tension-only springs and of watches.
    """

    mode: Annotated[Ints, "k"]  # MODE_*; of a watch, the side it is on: 1 above its value, -1 below
    grip: Annotated[Ints, "k"]  # GRIP_*; in space FORWARD is sliding in any direction
    # m, place at which a sticking contact's spring is slack; in space the direction of sliding; N while GRIP_PROBE
    anchor: Annotated[Floats, "k", "tangents"]
    dashpot: Annotated[Floats, "k"]  # N s/m^(m + 1), c in force
    stamp: Annotated[Floats, "k"]  # s, time of the contact's last event; of one that comes to rest, when bounces end
    burst: Annotated[Ints, "k"]  # events since then without a pause
    # m, m/s: the gap and its rate that the row of a closed constraint contact imposes; 0 outside of impacts
    lead: Annotated[Floats, "k", 2]
    # in `noise`: how far beyond its root the gap of a contact that was held must be, until it has once been as wide
    lag: Annotated[Floats, "k"]
    first_lag: Annotated[Floats, 1]  # its value where a contact opens; 0 of one-step methods
    roots: Annotated[Ints, 1]  # event functions watched; 0 without contacts and in the plain mode
    noise: Annotated[Floats, 3]  # m, m/s, m/s^2: how far past its root a function must be, above roundoff
    slow: Annotated[Floats, 1]  # m/s, slip speed that counts as none in space: eps^(1/2) of the scene's speeds
    # time (s), contact, mode, grip, anchor, dashpot after each change; then the time at which its bounces end, NaN of a
    # change that is no event
    log: Annotated[Floats, "most", "6 + tangents"]
    logged: Annotated[Ints, 1]  # events so far; beyond `most` they are only counted


def fresh_modes(count: int, noise: np.ndarray, slow: float, most_logged: int, dimension: int) -> ContactModes:
    """Return the modes of `count` contacts before a run has settled them."""
    tangents = dimension - 1
    log = np.empty((most_logged if count else 0, 6 + tangents))  # zeros would take a millisecond
    modes = empty(ContactModes, k=count, tangents=tangents)
    return modes._replace(noise=noise, slow=np.array([slow]), log=log)


@bare
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


@bare
def share(speed, creep):
    """Return tanh(v / v_s) / v of a speed v >= 0."""
    ratio = speed / creep
    return 1.0 / creep if ratio < 1e-8 else math.tanh(ratio) / speed


# Return what the slip velocity times gives smooth friction at a slip `speed`, -mu N tanh(v / v_s) / v (N s/m).
drag = bare(lambda laws, k, normal, speed: share(speed, laws.creep[k]) * (-laws.coefficient[k] * normal))
