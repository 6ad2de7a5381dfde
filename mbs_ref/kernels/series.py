"""What trees and particles supply to the loop of Taylor series (mbs_ref.kernels.border.supplies)."""

from mbs_ref.kernels.border.supplies import supplied

# Let a step start at the state y, and weigh each coordinate and rate by its tolerance.
start_at = supplied("start_at(series, y, rtol)")
# Fill the coefficients up to `order` + 1.
expand = supplied("expand(series, order)")
# Keep the absolute tolerances of the state.
take_tolerances = supplied("take_tolerances(series, atol)")
# Return the largest coefficient k of a coordinate, or of its rate, over its tolerance (1/s^k).
largest_term = supplied("largest_term(series, k)")
# Write the state and its rate at h (s) from the start.
evaluate = supplied("evaluate(series, order, h, y, dy)")
# Return whether two bodies are closer at y than the sum of their radii.
collided = supplied("collided(series, y)")

MAX_ORDER = 28
