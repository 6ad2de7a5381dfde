"""What a planar and a spatial core supply to the kernels that are written once (mbs_ref.kernels.border.supplies).

Rates are those of bodies in world axes, 3 or 6 each; the state may have them along body axes. Vectors are tuples along
world axes.
"""

from functools import partial

from mbs_ref.kernels.border.supplies import supplied

by_core = partial(supplied, passes_handle=False)

# --- state ------------------------------------------------------------------------------------------

# Copy the state into the kinematics, in elimination order and world axes.
load_state = supplied("load_state(model, work, y)")
# Copy lane w of the kinematics into the scratch of a system alone.
take_kinematics = supplied("take_kinematics(work, w, its)")
# Scale what the state stores beyond the freedoms of its bodies: their poses do not change.
normalize = supplied("normalize(model, y)")
# Return how far the state is from what `normalize` makes of it.
largest_norm_defect = supplied("largest_norm_defect(model, work)")
# Add factor times rates of body i to out[k:], as the state has rates.
add_rates = supplied("add_rates(model, work, i, factor, rates, out, k)")
# Return the rates of body i at values[k:] (rates,), which are as the state has them.
world_rates = supplied("world_rates(model, work, i, values, k)")
# Return total plus a row of a Jacobian (rates,) times the rates of body i at values[k:].
plus_product = supplied("plus_product(model, work, total, i, row, values, k)")
# Move and turn the bodies in y by the tree's accelerations, taken as displacements.
correct_places = supplied("correct_places(model, work, y)")
# Return the centre of mass of body i, m.
centre = supplied("centre(work, i)")
# Return the velocity of the centre of mass of body i, m/s.
speed = supplied("speed(work, i)")
# Return a vector fixed in body i along world axes.
turned = supplied("turned(work, i, u)")
# Return omega x arm of body i.
swing = supplied("swing(work, i, arm)")
# Return a coordinate of body i (m, rad) and its rate.
coordinate = supplied("coordinate(work, i, component)")
# Return how fast body i turns, rad/s.
spin = supplied("spin(work, i)")
# Return the product of two vectors.
dot = by_core("dot(work, a, b)")
# Return the sum of two vectors.
plus = by_core("plus(work, a, b)")
# Return the difference of two vectors.
minus = by_core("minus(work, a, b)")
# Return a number times a vector.
times = by_core("times(work, factor, a)")
# Return a force of this tension (N) along a gap of this length (m).
pull = by_core("pull(work, tension, gap, length)")
# Return a vector divided by a number.
over = by_core("over(work, a, divisor)")
# Add a force (N) at an arm of body i.
push = supplied("push(work, i, arm, force)")

# --- loads ------------------------------------------------------------------------------------------

# Set every force to the weight, and the torque to what turning bodies add; every other load adds to it.
apply_gravity = supplied("apply_gravity(model, work)")
# Add the torque of force k, times its signal's value.
apply_torque = supplied("apply_torque(model, work, k, scale)")
# Add the torques of torsion springs.
apply_torsion_springs = supplied("apply_torsion_springs(model, work)")
# Add the loads that this core alone has.
apply_own_loads = supplied("apply_own_loads(model, work)")
# Write place and rates of body i where a user's law reads those of body k of the scene.
put_state = supplied("put_state(work, i, k)")

# --- joint rows -------------------------------------------------------------------------------------

# Write the Jacobian of r_b - r_a from a row on; body a is on this side.
put_point = supplied("put_point(work, slot, side, row, apart)")
# Return the moment (turns,) of a force at an arm, a number in the plane.
moment = by_core("moment(work, arm, force)")
# Return what the turning of n, fixed in body i, adds to the rate of n . gap.
rate_of_turning = supplied("rate_of_turning(work, i, n, gap)")
# Return `surplus` without what the turning of n, fixed in body i, adds to the second rate of n . gap.
surplus_of_turning = supplied("surplus_of_turning(work, i, n, apart, surplus)")
# Evaluate the rows that this core alone has.
fill_own_rows = supplied("fill_own_rows(model, work)")
# And those of them that prescribe a motion in time.
fill_own_drives = supplied("fill_own_drives(model, work, t)")

# --- the augmented system ---------------------------------------------------------------------------

# Return a tuple as long as a body has rates: a loop over it has bounds that the compiler knows.
block = supplied("block(model)")
# Set every articulated block to the body's own mass and inertia.
start_blocks = supplied("start_blocks(model, work)")
# Factor the block of body i and S = J M^-1 J^T of its joint; add K^T S^-1 K to its parent's block.
factor_body = supplied("factor_body(model, work, i, parent)")
# Compute M^-1 f of body i and S^-1 (J M^-1 f - gamma) of its joint; subtract K^T of this from its parent's f.
solve_free = supplied("solve_free(model, work, i, parent, gamma, multiplier)")
# Add S^-1 K a of its parent to the multipliers of body i; write its acceleration M^-1 (f - J^T lambda).
accelerate_body = supplied("accelerate_body(model, work, i, parent, multiplier, acceleration)")
# Write f - M a into load (n + 1, rates).
subtract_inertia = supplied("subtract_inertia(model, work, acceleration, load)")
# Return total plus a scale of G M^-1 G^T of a row G (rates,) of body i, taken as free.
plus_mobility = supplied("plus_mobility(model, work, total, i, row)")
# Condense body i under the closure whose rows have the place `here` at it and `there` at its parent.
pass_closure = supplied("pass_closure(model, work, i, here, there, count)")

# --- contact ----------------------------------------------------------------------------------------

# Return the Surface (mbs_ref.kernels.rigid.shapes) of pair k at a centre that lies x from the shape's origin.
surface = supplied("surface(model, work, k, x)")
# Return the direction beyond the open end of pair k that is nearest to a centre at x.
outwards = supplied("outwards(model, work, k, x)")
# Return the slip at a velocity u of a on b, n . u = closing: a number in the plane, else a vector (m/s).
slip = by_core("slip(work, n, u, closing)")
# Return the friction on body a (N) at a normal force (N), in the frozen mode.
friction_force = supplied("friction_force(model, work, k, touch, normal)")
# Return the slip velocities (m/s) of a on b along the tangents.
slip_of = supplied("slip_of(model, touch)")
# Return stick-slip friction (tangents,) on body a in the frozen mode, N.
grip_force = supplied("grip_force(model, work, k, touch, normal)")
# Return the slip velocity (m/s) along what is frozen; sliding goes on while it is positive.
ahead = supplied("ahead(model, k, touch)")
# Return whether a contact that no longer slides as frozen is at rest; else let it slide as it does now.
has_stopped = supplied("has_stopped(model, k, touch)")
# Let contact k stick, unloaded, before anything is known of it.
start_grip = supplied("start_grip(model, k, touch)")
# Probe what stops along with the contacts that have stopped; its functions in g turn negative.
stop_together = supplied("stop_together(model, work, y, g)")
# Let contact k stick, its springs giving the friction `force` (tangents,) on body a, N.
stick = supplied("stick(model, y, k, touch, force)")
# Let contact k slide in the direction of a sign times u (tangents,).
slide_along = supplied("slide_along(model, k, touch, sign, u)")
