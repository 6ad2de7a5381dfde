"""The questions that compiled code asks across a border (mbs_ref.kernels.border.calls), whichever core answers.

Integrators ask most of them. The last ones a core asks itself: many of its functions need them, and without a border
each would link the dynamics.
"""

from typing import Any

from numba import types

from mbs_ref.kernels.border.calls import COUNT, FLAG, MATRIX, MODEL, NOTHING, NUMBER, VECTOR, WORK, question


@question(NOTHING, MODEL, WORK, NUMBER, VECTOR, VECTOR)
def derivative(model, work, t, y, dy) -> Any:
    """Write dy/dt at (t, y)."""


@question(types.UniTuple(NUMBER, 2), MODEL, WORK, NUMBER, VECTOR)
def compliance(model, work, t, y) -> Any:
    """Return max |C| and max |C_dot|."""


@question(NUMBER, MODEL, WORK, NUMBER, VECTOR, NUMBER, COUNT)
def project(model, work, t, y, tolerance, most) -> Any:
    """Move y onto the constraints; return max |C| left."""


@question(NOTHING, MODEL, WORK, VECTOR)
def tangent(model, work, x) -> Any:
    """Remove from both halves of x what points off the constraints, at the last factorization."""


@question(NUMBER, WORK)
def regularity(work) -> Any:
    """Return how far the last factorization is from a singular pose: 1 far, 0 there."""


@question(NOTHING, WORK, MATRIX)
def multipliers(work, lam) -> Any:
    """Copy the multipliers of the last acceleration into lam (n_slots, rows a slot)."""


@question(COUNT, MODEL)
def position_count(model) -> Any:
    """Return how many entries of the state are positions; rates follow."""


@question(NOTHING, MODEL, WORK, NUMBER, VECTOR, MATRIX, VECTOR)
def force_balance(model, work, t, y, lam, out) -> Any:
    """Write f - C_q^T lambda as rates are ordered; leave C, C_dot, C_q and gamma in `work`."""


@question(NOTHING, MODEL, VECTOR, VECTOR)
def times_mass(model, rate, out) -> Any:
    """Write M rate."""


@question(NOTHING, MODEL, WORK, VECTOR, VECTOR)
def answer(model, work, balance, out) -> Any:
    """Solve the augmented system for a balance and the gamma in `work`; write the accelerations."""


@question(NUMBER, MODEL, WORK, COUNT, COUNT, VECTOR)
def row_times(model, work, slot, row, rate) -> Any:
    """Return one constraint row applied to rates."""


@question(NOTHING, MODEL, WORK, COUNT, COUNT, NUMBER, VECTOR)
def add_row(model, work, slot, row, factor, out) -> Any:
    """Add factor times one constraint row to out."""


@question(NOTHING, MODEL, VECTOR, VECTOR, VECTOR)
def displace(model, y, move, out) -> Any:
    """Write y's positions moved along the rates' directions by `move`."""


@question(NOTHING, MODEL, VECTOR, VECTOR, VECTOR)
def position_rate(model, y, rate, out) -> Any:
    """Write the rates of the positions that `rate` means."""


@question(NOTHING, MODEL, VECTOR, VECTOR, VECTOR)
def rate_from(model, y, moved, out) -> Any:
    """Write the rates that `moved`, rates of y's positions, mean: the inverse of `position_rate`."""


@question(MATRIX, WORK, FLAG)
def defect_of(work, velocity_level) -> Any:
    """Return C, or C_dot where asked (n_slots, rows a slot), as the last balance left it."""


@question(MATRIX, WORK)
def gamma_of(work) -> Any:
    """Return gamma (n_slots, rows a slot), to be read or replaced."""


@question(COUNT, MODEL)
def root_count(model) -> Any:
    """Return the number of event functions watched."""


@question(FLAG, MODEL, WORK, NUMBER, VECTOR, NUMBER, MATRIX)
def roots(model, work, t, y, duration, table) -> Any:
    """Fill the table (4, n) of event functions, positive while the frozen modes hold (mbs_ref.kernels.contact.laws).

    All are in units of the function's roundoff (and s). Contacts that are far away in the last `duration` (s) are left
    out; a negative one leaves out those that were. Return whether others are left out now.
    """


@question(types.UniTuple(COUNT, 2), MODEL, WORK, NUMBER, NUMBER, VECTOR, VECTOR, VECTOR)
def transition(model, work, t, span, y, g, dy) -> Any:
    """Change the modes whose event functions are negative; return 0, 1 (endless) or 2 (stop), and the last source.

    `span` (s) is the leg's: what it takes for events to follow each other at once is measured by it.
    """


@question(NOTHING, MODEL, WORK, NUMBER, VECTOR, FLAG)
def start_modes(model, work, t, y, located) -> Any:
    """Set every contact's mode by the state."""


@question(NOTHING, MODEL, WORK, NUMBER, VECTOR, MATRIX)
def contact_forces(model, work, t, y, out) -> Any:
    """Fill out (n_contacts, 1 + 2 dimension): depth (m), force on body a (N), its point (m), in the present modes."""


@question(NUMBER, MODEL, WORK, NUMBER, VECTOR, COUNT)
def contact_mobility(model, work, t, y, k) -> Any:
    """Return n^T W n (1/kg) of a contact within the joints."""


@question(NOTHING, MODEL, WORK, NUMBER, VECTOR)
def accelerate(model, work, t, y) -> Any:
    """Compute accelerations and multipliers at (t, y) into `work`."""


@question(NOTHING, MODEL, WORK, NUMBER)
def fill_rows(model, work, t) -> Any:
    """Evaluate every constraint row at the state in `work`."""


@question(NOTHING, MODEL, WORK, NUMBER)
def apply_loads(model, work, t) -> Any:
    """Sum all applied forces at the state in `work`."""


@question(NOTHING, MODEL, WORK)
def apply_contacts(model, work) -> Any:
    """Add the forces of every contact that is closed."""


@question(NOTHING, MODEL, WORK)
def fill_contact_rows(model, work) -> Any:
    """Evaluate the rows of contacts as constraints; an open contact's are empty."""


@question(NOTHING, MODEL, WORK, VECTOR)
def fill_deflection_rates(model, work, dy) -> Any:
    """Write the rates of the deflections of contacts that can stick."""


@question(NOTHING, MODEL, WORK)
def factor(model, work) -> Any:
    """Factor the augmented matrix at the Jacobians in `work`."""


@question(NOTHING, MODEL, WORK, NUMBER, VECTOR, VECTOR)
def settle_grips(model, work, t, y, dy) -> Any:
    """Let the contacts that stopped sliding stick where friction holds them, else slide on; dy is scratch."""


@question(NOTHING, MODEL, WORK, VECTOR, MATRIX)
def slip_velocities(model, work, y, out) -> Any:
    """Fill out (n_contacts, tangents) with the slip velocities (m/s) at y of the contacts whose friction is probed."""


@question(NOTHING, MODEL, WORK, MATRIX)
def solve(model, work, gamma) -> Any:
    """Solve the augmented system for the load in `work` and `gamma`, into its acceleration and multipliers."""


@question(NOTHING, MODEL, WORK, VECTOR)
def expand(model, work, y) -> Any:
    """Place a tree at its relative coordinates y, and write the redundant system's state to `full`."""


@question(NOTHING, MODEL, WORK, VECTOR)
def take_velocities(model, work, y) -> Any:
    """Write to y the rates that the velocities in `full` mean, at the places that were last written."""
