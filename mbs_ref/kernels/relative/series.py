"""Taylor series of a planar tree of revolute joints under gravity and torsion springs, in absolute angles x.

With E_a = exp(i x_a) every centre of mass is a constant plus sum_a d_a E_a, d_a a complex constant, so that the
principle of virtual work gives
    I_a x_a'' + Im[conj(E_a) P_a] = t_a,  P_a = sum_b Z_ab E_b'' - G_a,
    Z_ab = sum_i m_i conj(d_ia) d_ib,  G_a = g sum_i m_i conj(d_ia)
Both products of series are local to a body; what couples bodies is constant. Coefficient k of E'' is B_k + i x_k'' E_0,
where B_k is known. The coefficients x_k'' therefore solve linear systems with one matrix, the mass matrix at the start.
Recurrences: A. Jorba, M. Zou, Experimental Mathematics 14 (2005) 99, sec. 2.

Coefficients are rows of lanes (mbs_ref.kernels.algebra.lanes): WIDTH angles side by side, padded with zeros.
"""

import sys
from typing import Annotated, NamedTuple

import numpy as np

from mbs_ref.kernels import series as interface
from mbs_ref.kernels.algebra.lanes import WIDTH, in_every_lane, in_lanes, lanes_cos_sin, larger, largest_of_lanes
from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.border.handles import handle_class
from mbs_ref.kernels.border.supplies import supply
from mbs_ref.kernels.jit import bare, placed


class Series(NamedTuple):
    """A tree of m angles in rows of w lanes, then the scratch of a run. A pair is a real and an imaginary part."""

    parent: Annotated[Ints, "m"]  # angle of the parent; m for ground
    tolerance: Annotated[Ints, 2, "m"]  # places in the absolute tolerances of the angle and its rate
    coupling: Annotated[Floats, "m", 2, "w", "WIDTH"]  # kg m^2, Z_ab, a row a column b
    inertia: Annotated[Floats, "w", "WIDTH"]  # kg m^2
    weight: Annotated[Floats, 2, "w", "WIDTH"]  # N m, G
    stiffness: Annotated[Floats, "s", "w", "WIDTH"]  # N m/rad; s is m, or 0 where there is no spring
    damping: Annotated[Floats, "s", "w", "WIDTH"]  # N m s/rad
    torque: Annotated[Floats, "w", "WIDTH"]  # N m, of the springs at angle zero
    x: Annotated[Floats, "orders", "w", "WIDTH"]  # coefficients of the angles
    rate: Annotated[Floats, "orders", "w", "WIDTH"]  # of their rates
    arm: Annotated[Floats, "orders", 2, "w", "WIDTH"]  # of E
    push: Annotated[Floats, "orders", 2, "w", "WIDTH"]  # of P
    bend: Annotated[Floats, 2, "w", "WIDTH"]  # B_k
    need: Annotated[Floats, "w", "WIDTH"]  # torque that x_k'' balances
    solution: Annotated[Floats, "w", "WIDTH"]  # x_k''
    column: Annotated[Floats, "m", 2, "w", "WIDTH"]  # i Z_ab E_b
    inverse: Annotated[Floats, "m", "w", "WIDTH"]  # of the mass matrix
    start: Annotated[Floats, 2, "w", "WIDTH"]  # angles and rates
    end: Annotated[Floats, 3, "w", "WIDTH"]  # angles, rates and accelerations later in the step
    atol: Annotated[Floats, 2, "w", "WIDTH"]  # of angles and rates; infinite behind the last
    scale: Annotated[Floats, 2, "w", "WIDTH"]  # 1 over the tolerances of a step


class SeriesGroups(NamedTuple):
    series: Series


Expanded = handle_class(__name__, "Expanded", SeriesGroups, WIDTH=WIDTH)


@placed
def start_at(s, y, rtol):
    """Let a step start at the state y of relative angles and their rates."""
    start, atol, scale, m = in_lanes(s.start), in_lanes(s.atol), in_lanes(s.scale), s.parent.shape[0]
    for a in range(m):
        p = s.parent[a]
        for c in range(2):
            s.start[c, a >> 3, a & 7] = y[c * m + a] + (s.start[c, p >> 3, p & 7] if p < m else 0.0)
    for w in range(start.shape[1]):
        for c in range(2):
            scale[c, w] = 1.0 / (atol[c, w] + rtol * abs(start[c, w]))


@placed
def evaluate(s, order, h, y, dy):
    """Write the state and its rate at h (s) from the start."""
    x, start, end, m = in_lanes(s.x), in_lanes(s.start), in_lanes(s.end), s.parent.shape[0]
    for w in range(x.shape[1]):
        rise = rate = acceleration = in_every_lane(0.0)
        for k in range(order + 1, 1, -1):
            acceleration = acceleration * h + (k * (k - 1.0)) * x[k, w]
            rate = rate * h + k * x[k, w]
            rise = rise * h + x[k, w]
        end[0, w] = start[0, w] + h * (start[1, w] + h * rise)
        end[1, w], end[2, w] = start[1, w] + h * rate, acceleration
    for a in range(m):
        p, lane = s.parent[a], a & 7
        y[a], y[m + a], dy[m + a] = s.end[0, a >> 3, lane], s.end[1, a >> 3, lane], s.end[2, a >> 3, lane]
        if p < m:
            y[a] -= s.end[0, p >> 3, p & 7]
            y[m + a] -= s.end[1, p >> 3, p & 7]
            dy[m + a] -= s.end[2, p >> 3, p & 7]
        dy[a] = y[m + a]


@placed
def take_tolerances(s, atol):
    """Keep the absolute tolerances of the state."""
    s.atol[:] = np.inf
    for a in range(s.parent.shape[0]):
        for c in range(2):
            s.atol[c, a >> 3, a & 7] = atol[s.tolerance[c, a]]


@placed
def largest_term(s, k):
    """Return the largest coefficient k of an angle, or of its rate, over its tolerance."""
    x, scale, largest = in_lanes(s.x), in_lanes(s.scale), in_every_lane(0.0)
    for w in range(x.shape[1]):
        largest = larger(abs(x[k, w]) * scale[0, w], largest)
        largest = larger(abs((k + 1.0) * x[k + 1, w]) * scale[1, w], largest)
    return largest_of_lanes(largest)


@placed
def expand(s, order):
    """Fill the series of the angles up to `order` + 1 from angles and rates at the start."""
    x, start, rate, arm = in_lanes(s.x), in_lanes(s.start), in_lanes(s.rate), in_lanes(s.arm)
    bend, words, zero = in_lanes(s.bend), s.x.shape[1], in_every_lane(0.0)
    for w in range(words):
        x[0, w], rate[0, w] = start[0, w], start[1, w]
        arm[0, 0, w], arm[0, 1, w] = lanes_cos_sin(x[0, w])
        arm[1, 0, w], arm[1, 1, w] = -(rate[0, w] * arm[0, 1, w]), rate[0, w] * arm[0, 0, w]
    _invert(s)
    for k in range(order):
        for w in range(words):
            x[k + 1, w] = rate[k, w] * (1.0 / (k + 1))
            re, im = zero, zero
            for j in range(k + 1):
                re += rate[j, w] * arm[k + 1 - j, 1, w]
                im += rate[j, w] * arm[k + 1 - j, 0, w]
            bend[0, w], bend[1, w] = re * -(k + 1.0), im * (k + 1.0)
        _balance(s, k)
        _advance(s, k)
    for w in range(words):
        x[order + 1, w] = rate[order, w] * (1.0 / (order + 1))


@placed
def _invert(s):
    """Set the columns i Z_ab E_b, and invert the mass matrix without pivots (Gauss-Jordan): it is definite."""
    arm, coupling, column, inverse = in_lanes(s.arm), in_lanes(s.coupling), in_lanes(s.column), in_lanes(s.inverse)
    count, words = inverse.shape
    for b in range(count):
        cos, sin = s.arm[0, 0, b >> 3, b & 7], s.arm[0, 1, b >> 3, b & 7]
        for w in range(words):
            re, im = coupling[b, 0, w], coupling[b, 1, w]
            column[b, 0, w], column[b, 1, w] = -(re * sin + im * cos), re * cos - im * sin
            inverse[b, w] = arm[0, 0, w] * column[b, 1, w] - arm[0, 1, w] * column[b, 0, w]
        s.inverse[b, b >> 3, b & 7] += s.inertia[b >> 3, b & 7]
    for b in range(count):
        place, lane = b >> 3, b & 7
        pivot = 1.0 / s.inverse[b, place, lane]
        s.inverse[b, place, lane] = 1.0
        for w in range(words):
            inverse[b, w] *= pivot
        for a in range(count):
            if a != b:
                factor = s.inverse[a, place, lane]
                s.inverse[a, place, lane] = 0.0
                for w in range(words):
                    inverse[a, w] -= factor * inverse[b, w]


@placed
def _balance(s, k):
    """Set coefficient k of P without x'', and the torque that is left to x''."""
    arm, push, need, torque = in_lanes(s.arm), in_lanes(s.push), in_lanes(s.need), in_lanes(s.torque)
    weight, coupling, zero = in_lanes(s.weight), in_lanes(s.coupling), in_every_lane(0.0)
    stiffness, damping = in_lanes(s.stiffness), in_lanes(s.damping)
    for w in range(need.shape[0]):
        re, im, left = (-weight[0, w], -weight[1, w], torque[w]) if k == 0 else (zero, zero, zero)
        for b in range(coupling.shape[0]):
            p, q = s.bend[0, b >> 3, b & 7], s.bend[1, b >> 3, b & 7]
            re += coupling[b, 0, w] * p - coupling[b, 1, w] * q
            im += coupling[b, 0, w] * q + coupling[b, 1, w] * p
        push[k, 0, w], push[k, 1, w] = re, im
        for b in range(stiffness.shape[0]):
            left -= stiffness[b, w] * s.x[k, b >> 3, b & 7] + damping[b, w] * s.rate[k, b >> 3, b & 7]
        right = zero
        for j in range(k + 1):
            left += arm[j, 1, w] * push[k - j, 0, w]
            right += arm[j, 0, w] * push[k - j, 1, w]
        need[w] = left - right


@placed
def _advance(s, k):
    """Solve for coefficient k of x''; set those of the rates and of E that follow, and complete that of P."""
    rate, arm, push, bend = in_lanes(s.rate), in_lanes(s.arm), in_lanes(s.push), in_lanes(s.bend)
    column, inverse, solution = in_lanes(s.column), in_lanes(s.inverse), in_lanes(s.solution)
    scale = 1.0 / (k + 1)
    lead = scale / (k + 2.0)
    for w in range(solution.shape[0]):
        a = in_every_lane(0.0)
        for b in range(inverse.shape[0]):
            a += inverse[b, w] * s.need[b >> 3, b & 7]
        solution[w], rate[k + 1, w] = a, a * scale
        arm[k + 2, 0, w] = (bend[0, w] - a * arm[0, 1, w]) * lead
        arm[k + 2, 1, w] = (bend[1, w] + a * arm[0, 0, w]) * lead
    for w in range(solution.shape[0]):
        re, im = push[k, 0, w], push[k, 1, w]
        for b in range(inverse.shape[0]):
            a = s.solution[b >> 3, b & 7]
            re += column[b, 0, w] * a
            im += column[b, 1, w] * a
        push[k, 0, w], push[k, 1, w] = re, im


collided = bare(lambda s, y: False)  # joints allow it
supply((Series,), interface, (sys.modules[__name__],))
