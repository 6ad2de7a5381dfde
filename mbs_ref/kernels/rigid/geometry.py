"""What a planar and a spatial core supply to the kernels that are written once (mbs_ref.kernels.border.supplies).

Rates are those of bodies in world axes, 3 or 6 each; the state may have them along body axes. Vectors are tuples along
world axes.
"""

from functools import partial
from typing import Any

from mbs_ref.kernels.border.supplies import supplied

by_core = partial(supplied, passes_handle=False)

# --- state ------------------------------------------------------------------------------------------


@supplied
def load_state(model, work, y) -> Any:
    """Copy the state into the kinematics, in elimination order and world axes."""


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
def speed(work, i) -> Any:
    """Return the velocity of the centre of mass of body i, m/s."""


@supplied
def turned(work, i, u) -> Any:
    """Return a vector fixed in body i along world axes."""


@supplied
def swing(work, i, arm) -> Any:
    """Return omega x arm of body i."""


@supplied
def coordinate(work, i, component) -> Any:
    """Return a coordinate of body i (m, rad) and its rate."""


@supplied
def spin(work, i) -> Any:
    """Return how fast body i turns, rad/s."""


@by_core
def dot(work, a, b) -> Any:
    """Return the product of two vectors."""


@by_core
def plus(work, a, b) -> Any:
    """Return the sum of two vectors."""


@by_core
def minus(work, a, b) -> Any:
    """Return the difference of two vectors."""


@by_core
def times(work, factor, a) -> Any:
    """Return a number times a vector."""


@by_core
def pull(work, tension, gap, length) -> Any:
    """Return a force of this tension (N) along a gap of this length (m)."""


@by_core
def over(work, a, divisor) -> Any:
    """Return a vector divided by a number."""


@supplied
def push(work, i, arm, force) -> Any:
    """Add a force (N) at an arm of body i."""


# --- loads ------------------------------------------------------------------------------------------


@supplied
def apply_gravity(model, work) -> Any:
    """Set every force to the weight, and the torque to what turning bodies add; every other load adds to it."""


@supplied
def apply_torque(model, work, k, scale) -> Any:
    """Add the torque of force k, times its signal's value."""


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


@by_core
def moment(work, arm, force) -> Any:
    """Return the moment (turns,) of a force at an arm, a number in the plane."""


@supplied
def rate_of_turning(work, i, n, gap) -> Any:
    """Return what the turning of n, fixed in body i, adds to the rate of n . gap."""


@supplied
def surplus_of_turning(work, i, n, apart, surplus) -> Any:
    """Return `surplus` without what the turning of n, fixed in body i, adds to the second rate of n . gap."""


@supplied
def fill_own_rows(model, work, t) -> Any:
    """Evaluate the rows that this core alone has."""


# --- the augmented system ---------------------------------------------------------------------------


@supplied
def block(model) -> Any:
    """Return a tuple as long as a body has rates: a loop over it has bounds that the compiler knows."""


@supplied
def start_blocks(model, work) -> Any:
    """Set every articulated block to the body's own mass and inertia."""


@supplied
def factor_body(model, work, i, parent) -> Any:
    """Factor the block of body i and S = J M^-1 J^T of its joint; add K^T S^-1 K to its parent's block."""


@supplied
def solve_free(model, work, i, parent, gamma, multiplier) -> Any:
    """Compute M^-1 f of body i and S^-1 (J M^-1 f - gamma) of its joint; subtract K^T of this from its parent's f."""


@supplied
def accelerate_body(model, work, i, parent, multiplier, acceleration) -> Any:
    """Add S^-1 K a of its parent to the multipliers of body i; write its acceleration M^-1 (f - J^T lambda)."""


@supplied
def subtract_inertia(model, work, acceleration, load) -> Any:
    """Write f - M a into load (n + 1, rates)."""


@supplied
def plus_mobility(model, work, total, i, row) -> Any:
    """Return total plus a scale of G M^-1 G^T of a row G (rates,) of body i, taken as free."""


@supplied
def pass_closure(model, work, i, here, there, count) -> Any:
    """Condense body i under the closure whose rows have the place `here` at it and `there` at its parent."""


# --- contact ----------------------------------------------------------------------------------------


@supplied
def surface(model, work, k, x) -> Any:
    """Return the Surface (mbs_ref.kernels.rigid.shapes) of pair k at a centre that lies x from the shape's origin."""


@supplied
def outwards(model, work, k, x) -> Any:
    """Return the direction beyond the open end of pair k that is nearest to a centre at x."""


@by_core
def slip(work, n, u, closing) -> Any:
    """Return the slip at a velocity u of a on b, n . u = closing: a number in the plane, else a vector (m/s)."""


@supplied
def friction_force(model, work, k, touch, normal) -> Any:
    """Return the friction on body a (N) at a normal force (N), in the frozen mode."""


@supplied
def slip_of(model, touch) -> Any:
    """Return the slip velocities (m/s) of a on b along the tangents."""


@supplied
def grip_force(model, work, k, touch, normal) -> Any:
    """Return stick-slip friction (tangents,) on body a in the frozen mode, N."""


@supplied
def ahead(model, k, touch) -> Any:
    """Return the slip velocity (m/s) along what is frozen; sliding goes on while it is positive."""


@supplied
def has_stopped(model, k, touch) -> Any:
    """Return whether a contact that no longer slides as frozen is at rest; else let it slide as it does now."""


@supplied
def start_grip(model, k, touch) -> Any:
    """Let contact k stick, unloaded, before anything is known of it."""


@supplied
def stop_together(model, work, y, g) -> Any:
    """Probe what stops along with the contacts that have stopped; its functions in g turn negative."""


@supplied
def stick(model, y, k, touch, force) -> Any:
    """Let contact k stick, its springs giving the friction `force` (tangents,) on body a, N."""


@supplied
def slide_along(model, k, touch, sign, u) -> Any:
    """Let contact k slide in the direction of a sign times u (tangents,)."""
