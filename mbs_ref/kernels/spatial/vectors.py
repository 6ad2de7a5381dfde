"""Three-vectors as scalars: what the spatial kernels are written in."""

from __future__ import annotations

from mbs_ref.kernels.jit import jit


@jit
def cross(a0, a1, a2, b0, b1, b2):
    return a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0


@jit
def dot(a0, a1, a2, b0, b1, b2):
    return a0 * b0 + a1 * b1 + a2 * b2


@jit
def turn(m, u):
    """Return m u."""
    return (
        m[0, 0] * u[0] + m[0, 1] * u[1] + m[0, 2] * u[2],
        m[1, 0] * u[0] + m[1, 1] * u[1] + m[1, 2] * u[2],
        m[2, 0] * u[0] + m[2, 1] * u[1] + m[2, 2] * u[2],
    )


@jit
def turn_back(m, x, y, z):
    """Return m^T (x, y, z)."""
    return (
        m[0, 0] * x + m[1, 0] * y + m[2, 0] * z,
        m[0, 1] * x + m[1, 1] * y + m[2, 1] * z,
        m[0, 2] * x + m[1, 2] * y + m[2, 2] * z,
    )


@jit
def symmetric_times(s, x, y, z):
    """Return S (x, y, z) with S = xx, yy, zz, xy, xz, yz."""
    return (
        s[0] * x + s[3] * y + s[4] * z,
        s[3] * x + s[1] * y + s[5] * z,
        s[4] * x + s[5] * y + s[2] * z,
    )


@jit
def centripetal(w0, w1, w2, r0, r1, r2):
    """Return w x (w x r)."""
    c0, c1, c2 = cross(w0, w1, w2, r0, r1, r2)
    return cross(w0, w1, w2, c0, c1, c2)
