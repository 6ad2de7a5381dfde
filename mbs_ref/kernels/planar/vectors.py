"""Vectors of two numbers. What is computed is a pair; rows of arrays are taken as well as pairs."""

from mbs_ref.kernels.jit import bare

# Return row[k : k + 2].
pair = bare(lambda row, k: (row[k], row[k + 1]))
plus = bare(lambda a, b: (a[0] + b[0], a[1] + b[1]))
minus = bare(lambda a, b: (a[0] - b[0], a[1] - b[1]))
times = bare(lambda factor, a: (factor * a[0], factor * a[1]))
over = bare(lambda a, divisor: (a[0] / divisor, a[1] / divisor))
dot = bare(lambda a, b: a[0] * b[0] + a[1] * b[1])
# Return the third component of a x b.
cross = bare(lambda a, b: a[0] * b[1] - a[1] * b[0])
# Return a turned by 90 degrees: d(a)/d(theta).
perpendicular = bare(lambda a: (-a[1], a[0]))
# Return u turned by an angle of this cosine and sine.
rotated = bare(lambda c, s, u: (c * u[0] - s * u[1], s * u[0] + c * u[1]))
