"""Vectors of two numbers. What is computed is a pair; rows of arrays are taken as well as pairs."""

from mbs_ref.kernels.jit import bare


@bare
def pair(row, k):
    """Return row[k : k + 2]."""
    return row[k], row[k + 1]


@bare
def plus(a, b):
    return a[0] + b[0], a[1] + b[1]


@bare
def minus(a, b):
    return a[0] - b[0], a[1] - b[1]


@bare
def times(factor, a):
    return factor * a[0], factor * a[1]


@bare
def over(a, divisor):
    return a[0] / divisor, a[1] / divisor


@bare
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1]


@bare
def cross(a, b):
    """Return the third component of a x b."""
    return a[0] * b[1] - a[1] * b[0]


@bare
def perpendicular(a):
    """Return a turned by 90 degrees: d(a)/d(theta)."""
    return -a[1], a[0]


@bare
def rotated(c, s, u):
    """Return u turned by an angle of this cosine and sine."""
    return c * u[0] - s * u[1], s * u[0] + c * u[1]
