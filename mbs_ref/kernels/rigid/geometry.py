"""What a planar and a spatial core supply to the kernels that are written once (mbs_ref.kernels.border.supplies).

Rates are those of bodies in world axes, 3 or 6 each; the state may have them along body axes. Vectors are tuples along
world axes. A touch is a named tuple of the core's own, with gap, closing, beyond, normal, arm_a and arm_b among its
fields.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from mbs_ref.kernels.border.supplies import supplied

by_core = partial(supplied, passes_handle=False)

# --- state ------------------------------------------------------------------------------------------


@supplied
def load_state(model, work, y) -> Any:
    """Copy the state into the kinematics, in elimination order and world axes."""


@supplied
def position_count(model) -> Any:
    """Return how many entries of the state are positions; rates follow."""


@supplied
def normalize(model, y) -> Any:
    """Scale what the state stores beyond the freedoms of its bodies: their poses do not change."""


@supplied
def largest_norm_defect(model, work) -> Any:
    """Return how far the state is from what `normalize` makes of it."""


@supplied
def add_rates(model, work, i, factor, rates, out, k) -> Any:
    """Add factor times rates of body i to out[k:], as the state has rates."""


@supplied
def world_rates(model, work, i, values, k) -> Any:
    """Return the rates of body i at values[k:] (rates,), which are as the state has them."""


@supplied
def plus_product(model, work, total, i, row, values, k) -> Any:
    """Return total plus a row of a Jacobian (rates,) times the rates of body i at values[k:]."""


@supplied
def correct_places(model, work, y) -> Any:
    """Move and turn the bodies in y by the tree's accelerations, taken as displacements."""


@supplied
def centre(work, i) -> Any:
    """Return the centre of mass of body i, m."""


@supplied
def place_of_mark(work, i, point) -> Any:
    """Return the place (m) of a point of body i."""


@supplied
def coordinate(work, i, component) -> Any:
    """Return a coordinate of body i (m, rad) and its rate."""


@supplied
def speed(work, i) -> Any:
    """Return how fast the centre of mass of body i moves, m/s."""


@supplied
def spin(work, i) -> Any:
    """Return how fast body i turns, rad/s."""


@supplied
def speed_between(work, a, b) -> Any:
    """Return how fast the centres of mass of two bodies move against each other, m/s."""


@by_core
def dot(work, a, b) -> Any:
    """Return the product of two vectors."""


@by_core
def plus(work, a, b) -> Any:
    """Return the sum of two vectors."""


@by_core
def times(work, factor, a) -> Any:
    """Return a number times a vector."""


@supplied
def rate_seen(work, a, gap, rate) -> Any:
    """Return the rate (m/s) of a gap as body a sees it."""


@by_core
def pull(work, tension, gap, length) -> Any:
    """Return a force of this tension (N) along a gap of this length (m)."""


@by_core
def over(work, a, divisor) -> Any:
    """Return a vector divided by a number."""


@supplied
def separation(work, a, b, point_a, point_b) -> Any:
    """Return how a point of body b lies and moves from one of body a: arm_a, arm_b, gap and rate among its fields."""


@supplied
def inward(work, a, b, apart) -> Any:
    """Return the second rate (m/s^2) of the gap of a separation without the bodies' accelerations, negative."""


@supplied
def rate_along(work, i, point, e) -> Any:
    """Return the velocity (m/s) of a point of body i along a unit vector."""


@supplied
def acceleration_along(work, i, point, e) -> Any:
    """Return the acceleration (m/s^2) of a point of body i along a unit vector, without the body's own."""


# --- loads ------------------------------------------------------------------------------------------


@supplied
def apply_gravity(model, work) -> Any:
    """Set every force to the weight, and the torque to what turning bodies add; every other load adds to it."""


@supplied
def apply_force(model, work, k, scale) -> Any:
    """Add force and torque k, times its signal's value."""


@supplied
def apply_own_loads(model, work) -> Any:
    """Add the loads that this core alone has, torsion springs among them."""


@supplied
def put_state(work, i, k) -> Any:
    """Write place and rates of body i where a user's law reads those of body k of the scene."""


# --- joint rows -------------------------------------------------------------------------------------


@supplied
def put_point(work, slot, side, row, apart) -> Any:
    """Write the Jacobian of r_b - r_a from a row on; body a is on this side."""


@supplied
def put_line(work, slot, side, row, e, apart) -> Any:
    """Write the Jacobian of e . (r_b - r_a) at a fixed unit vector e."""


@supplied
def put_on_body(work, slot, side, row, i, point, e) -> Any:
    """Write the Jacobian of e . r of a point of body i at a fixed unit vector e."""


@supplied
def fill_plane(work, slot, side, row, a, b, normal, apart) -> Any:
    """Evaluate the row n . (r_b - r_a) = 0 of a normal in body a."""


@supplied
def fill_own_rows(model, work, t) -> Any:
    """Evaluate the rows that this core alone has."""


# --- the augmented system ---------------------------------------------------------------------------


@supplied
def block(model) -> Any:
    """Return a tuple as long as a body has rates: a loop over it has bounds that the compiler knows."""


@supplied
def factor_tree(model, work, loops) -> Any:
    """Factor every body's block and joint, leaf to root, and the closures at their apexes; loops may be None."""


@supplied
def solve_tree(model, work, loops, gamma, acceleration, multiplier) -> Any:
    """Solve with the tree's load and the rows' right-hand side gamma; loops may be None."""


@supplied
def subtract_inertia(model, work, acceleration, load) -> Any:
    """Write f - M a into load (n + 1, rates)."""


@supplied
def has_no_rows(model) -> Any:
    """Return whether no body has a constraint row."""


@supplied
def row_mobility(model, work, slot, row) -> Any:
    """Return a scale of G M^-1 G^T of one row G, the bodies taken as free."""


@supplied
def pass_closure(model, work, i, here, there, count) -> Any:
    """Condense body i under the closure whose rows have the place `here` at it and `there` at its parent."""


# --- contact ----------------------------------------------------------------------------------------


@supplied
def contact_geometry(model, work, k) -> Any:
    """Return the touch of pair k."""


@supplied
def leaving_ends(model, work, k) -> Any:
    """Return the rate (m/s) of the excess over open ends."""


@supplied
def gap_rows(model, touch) -> Any:
    """Return the rows (rates,) that give the gap's rate from the rates of body a and of body b."""


@supplied
def gap_response(model, work, k, touch) -> Any:
    """Return the gap's rows applied to the accelerations in the tree."""


@supplied
def gap_gamma(model, work, k, touch) -> Any:
    """Return what the gap's second rate lacks of its rows applied to accelerations, negative (m/s^2)."""


@supplied
def contact_force(model, work, k, touch, normal) -> Any:
    """Return the force on body a (N) at a normal force (N), with friction in the frozen mode."""


@supplied
def exchange(work, a, arm_a, b, arm_b, force) -> Any:
    """Add a force (N) at an arm of body a, and its opposite at an arm of body b."""


@supplied
def slip_of(model, touch) -> Any:
    """Return the slip velocities (m/s) of a on b along the tangents."""


@supplied
def grip_margin(model, work, k, touch) -> Any:
    """Return how far friction is from the end of its mode, in units of its roundoff."""


@supplied
def start_grip(model, k, touch) -> Any:
    """Let contact k stick, unloaded, before anything is known of it."""


@supplied
def take_grip(model, y, k, touch) -> Any:
    """Slide where there is a slip velocity; stick, unloaded, where there is none."""


@supplied
def change_grip(model, work, k, touch) -> Any:
    """End a mode of friction; return whether the contact has stopped and is to be probed."""


@supplied
def stop_together(model, work, y, g) -> Any:
    """Probe what stops along with the contacts that have stopped; its functions in g turn negative."""


@supplied
def stick(model, y, k, touch, force) -> Any:
    """Let contact k stick, its springs giving the friction `force` (tangents,) on body a, N."""


@supplied
def slide_against(model, k, force) -> Any:
    """Let contact k slide against the friction `force` (tangents,) on body a, N."""
