"""Proven enclosures of motions: `prove` proposes polynomials, `checker` proves what they enclose.

The motion obeys y' = f(y, z), 0 = g(y, z) with f and g entire and g_z invertible. z has the accelerations, the
multipliers and 1 / distance, so that no division occurs. The prover derives f and g in joint coordinates and proposes
a Taylor polynomial for every step. The checker trusts none of it: it derives the motion again in absolute coordinates
with multipliers, compares the two with hundreds of digits, and bounds the distance from the polynomials by a fixed
point in ball arithmetic. Source of the moving basis: Lohner, Computation of guaranteed enclosures (1992).
"""
