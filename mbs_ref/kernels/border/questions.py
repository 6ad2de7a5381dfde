"""The questions that compiled code asks across a border (mbs_ref.kernels.border.calls), whichever core answers.

Integrators ask most of them. The last ones a core asks itself: many of its functions need them, and without a border
each would link the dynamics.
"""

from mbs_ref.kernels.border.calls import COUNT, COUNTS, FLAG, MATRIX, NUMBER, NUMBERS, question

# Write dy/dt at (t, y).
derivative = question("derivative(model, work, t, y, dy)")
# Return max |C| and max |C_dot|.
compliance = question("compliance(model, work, t, y)", NUMBERS)
# Move y onto the constraints; return max |C| left.
project = question("project(model, work, t, y, tolerance, most)", NUMBER)
# Remove from both halves of x what points off the constraints, at the last factorization.
tangent = question("tangent(model, work, x)")
# Return how far the last factorization is from a singular pose: 1 far, 0 there.
regularity = question("regularity(work)", NUMBER)
# Copy the multipliers of the last acceleration into lam (n_slots, rows a slot).
multipliers = question("multipliers(work, lam)")
# Return how many entries of the state are positions; rates follow.
position_count = question("position_count(model)", COUNT)
# Write f - C_q^T lambda as rates are ordered; leave C, C_dot, C_q and gamma in `work`.
force_balance = question("force_balance(model, work, t, y, lam, out)")
# Write M rate.
times_mass = question("times_mass(model, rate, out)")
# Solve the augmented system for a balance and the gamma in `work`; write the accelerations.
answer = question("answer(model, work, balance, out)")
# Return one constraint row applied to rates.
row_times = question("row_times(model, work, slot, row, rate)", NUMBER)
# Add factor times one constraint row to out.
add_row = question("add_row(model, work, slot, row, factor, out)")
# Write y's positions moved along the rates' directions by `move`.
displace = question("displace(model, y, move, out)")
# Write the rates of the positions that `rate` means.
position_rate = question("position_rate(model, y, rate, out)")
# Write the rates that `moved`, rates of y's positions, mean: the inverse of `position_rate`.
rate_from = question("rate_from(model, y, moved, out)")
# Return C, or C_dot on request (n_slots, rows a slot), as the last balance left it.
defect_of = question("defect_of(work, velocity_level)", MATRIX)
# Return gamma (n_slots, rows a slot), to be read or replaced.
gamma_of = question("gamma_of(work)", MATRIX)
# Return the number of event functions watched.
root_count = question("root_count(model)", COUNT)
# Fill the table (4, n) of event functions, positive while the frozen modes hold (mbs_ref.kernels.contact.laws). All
# are in units of the function's roundoff (and s). Contacts that are far away in the last `duration` (s) are left out;
# a negative one leaves out those that were, and sources marked in the table are left out (LEFT_OUT). Return whether
# other contacts are left out now.
roots = question("roots(model, work, t, y, duration, table)", FLAG)
# Change the modes whose event functions are negative; return 0, 1 (endless) or 2 (stop), and the last source. `span`
# (s) is the leg's: what it takes for events to follow each other at once is measured by it.
transition = question("transition(model, work, t, span, y, g, dy)", COUNTS)
# Set every contact's mode by the state.
start_modes = question("start_modes(model, work, t, y, located)")
# Fill forces (n_contacts, 1 + 2 dimension): depth (m), force on body a (N), its point (m), in the present modes.
contact_forces = question("contact_forces(model, work, t, y, forces)")
# Return n^T W n (1/kg) of a contact within the joints.
contact_mobility = question("contact_mobility(model, work, t, y, k)", NUMBER)
# Compute accelerations and multipliers at (t, y) into `work`.
accelerate = question("accelerate(model, work, t, y)")
# Evaluate every constraint row at the state in `work`.
fill_rows = question("fill_rows(model, work, t)")
# Evaluate the rows of joints, but those of shared points and rods.
fill_further_rows = question("fill_further_rows(model, work, t)")
# Sum all applied forces at the state in `work`.
apply_loads = question("apply_loads(model, work, t)")
# Add the forces of all loads but gravity, contacts and granules.
apply_given_loads = question("apply_given_loads(model, work, t)")
# Add the forces of loads that depend on the time, or on modes, and of those that the core alone has.
apply_further_loads = question("apply_further_loads(model, work, t)")
# Add the forces of every contact that is closed.
apply_contacts = question("apply_contacts(model, work)")
# Let the list of near pairs cover the last `duration` (s) before the pose in `work`; return whether it is new.
find_near = question("find_near(model, work, duration)", FLAG)
# Add the forces of granules on each other and on walls.
apply_granules = question("apply_granules(model, work)")
# Evaluate the rows of contacts as constraints; an open contact's are empty.
fill_contact_rows = question("fill_contact_rows(model, work)")
# Write the rates of the deflections of contacts that can stick.
fill_deflection_rates = question("fill_deflection_rates(model, work, dy)")
# Factor the augmented matrix at the Jacobians in `work`.
factor = question("factor(model, work)")
# Let the contacts that stopped sliding stick where friction holds them, else slide on; dy is scratch.
settle_grips = question("settle_grips(model, work, t, y, dy)")
# Let the constraint contacts that touch hold or go, and take the approach speeds of those that hold away.
settle_held = question("settle_held(model, work, t, y, g)")
# Fill the functions of tension-only springs and declared events at the state in `work`.
switch_roots = question("switch_roots(model, work, table)")
# Change the modes of those whose functions are negative; return whether the run is to stop.
switch_transition = question("switch_transition(model, g)", FLAG)
# Set their modes by the state in `work`.
start_switches = question("start_switches(model, work, located)")
# Fill slips (n_contacts, tangents) with the slip velocities (m/s) at y of the contacts whose friction is probed.
slip_velocities = question("slip_velocities(model, work, y, slips)")
# Add to a solution for the load `forces` a factor times what the residuals of both equations require.
refine = question("refine(model, work, forces, factor)")
# Solve the augmented system for the load in `work` and `gamma`, into its acceleration and multipliers.
solve = question("solve(model, work, gamma)")
# Place a tree at its relative coordinates y, and write the redundant system's state to `full`.
expand = question("expand(model, work, y)")
# Write to y the rates that the velocities in `full` mean, at the places that were last written.
take_velocities = question("take_velocities(model, work, y)")
