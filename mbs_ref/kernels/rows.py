"""Constraint rows by slots, (n_slots, rows a slot), as both rigid cores keep them.

C_q is (n_slots, 2 sides, rows a slot, rates of a body), zero in unused rows; `body` (n_slots, 2) tells whose
sides they are.
"""

from mbs_ref.kernels.algebra.lanes import larger
from mbs_ref.kernels.jit import jit


@jit
def largest_entry(values):
    """Return max |values|; a NaN wins."""
    largest = 0.0
    for slot in range(values.shape[0]):
        for row in range(values.shape[1]):
            largest = larger(largest, abs(values[slot, row]))
    return largest


@jit
def take_reactions(force, body, jacobian, multiplier):
    """force -= C_q^T lambda."""
    for slot in range(jacobian.shape[0]):
        for side in range(2):
            on = body[slot, side]
            for row in range(jacobian.shape[2]):
                for c in range(jacobian.shape[3]):
                    force[on, c] -= jacobian[slot, side, row, c] * multiplier[slot, row]


@jit
def take_accelerations(gamma, body, jacobian, acceleration):
    """gamma -= C_q a."""
    for slot in range(jacobian.shape[0]):
        for side in range(2):
            of = body[slot, side]
            for row in range(jacobian.shape[2]):
                for c in range(jacobian.shape[3]):
                    gamma[slot, row] -= jacobian[slot, side, row, c] * acceleration[of, c]


@jit
def add_to(target, other):
    """target += other, both with two axes."""
    for i in range(target.shape[0]):
        for c in range(target.shape[1]):
            target[i, c] += other[i, c]


@jit
def clear(target):
    """target = 0."""
    for i in range(target.shape[0]):
        for c in range(target.shape[1]):
            target[i, c] = 0.0


@jit
def scale(factor, source, target):
    """target = factor source."""
    for i in range(source.shape[0]):
        for c in range(source.shape[1]):
            target[i, c] = factor * source[i, c]


@jit
def copy_rows(source, target):
    """Copy source into target."""
    for slot in range(target.shape[0]):
        for row in range(target.shape[1]):
            target[slot, row] = source[slot, row]
