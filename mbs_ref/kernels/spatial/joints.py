"""Joint rows in space: Jacobian blocks, which multiply (R', omega), products of directions, turns, rolling wheels.

A wheel that rolls has rows on velocities alone besides.
"""

from typing import Any, NamedTuple

import numpy as np

from mbs_ref.kernels.algebra.lanes import zero_like
from mbs_ref.kernels.jit import bare
from mbs_ref.kernels.rigid.joints import bodies_of_row, put_row
from mbs_ref.kernels.rigid.model import CONTROL_MODE_TIME
from mbs_ref.kernels.signals import evaluate
from mbs_ref.kernels.spatial.marks import cross, dot, minus, negative, over, plus, swing, times, triple, turn, turned

NO_FORCE = (0.0, 0.0, 0.0)


class Product(NamedTuple):
    """How the product e . f of a direction e of body a and one f of body b changes."""

    normal: Any  # e x f: on omega_a in the rate, its negative on omega_b
    rate: Any  # 1/s
    gamma: Any  # 1/s^2, the second rate without angular accelerations, negative


@bare
def _turn_rows(rows, slot, side, row, normal):
    """Write a row that multiplies omega_a - omega_b."""
    put_row(rows.jacobian[slot, side, row], NO_FORCE, normal)
    put_row(rows.jacobian[slot, 1 - side, row], NO_FORCE, negative(normal))


@bare
def _product(kin, a, b, e, f):
    """Return the Product of a direction of a and one of b."""
    wa, wb = kin.omega[a], kin.omega[b]
    turn_e, turn_f = cross(wa, e), cross(wb, f)
    rate = dot(turn_e, f) + dot(e, turn_f)
    second = dot(cross(wa, turn_e), f) + 2.0 * dot(turn_e, turn_f) + dot(e, cross(wb, turn_f))
    return Product(cross(e, f), rate, -second)


@bare
def fill_products(model, work):
    joint, slots, kin, rows = model.products, model.slots, work.kinematics, work.rows
    for k in range(joint.slot.shape[0]):
        slot, row, side, a, b = bodies_of_row(slots, joint, k)
        e, f = turn(kin.turned[a], joint.along_a[k]), turn(kin.turned[b], joint.along_b[k])
        product = _product(kin, a, b, e, f)
        _turn_rows(rows, slot, side, row, product.normal)
        rows.residual[slot, row] = dot(e, f)
        rows.rate[slot, row] = product.rate
        rows.gamma[slot, row] = product.gamma


moment = bare(lambda arm, force: cross(arm, force))


@bare
def put_point(work, slot, side, row, apart):
    a0, a1, a2 = apart.arm_a
    b0, b1, b2 = apart.arm_b
    on_a, on_b = work.rows.jacobian[slot, side], work.rows.jacobian[slot, 1 - side]
    zero = zero_like(a0)
    put_row(on_a[row], (-1.0, 0.0, 0.0), (zero, -a2, a1))
    put_row(on_a[row + 1], (0.0, -1.0, 0.0), (a2, zero, -a0))
    put_row(on_a[row + 2], (0.0, 0.0, -1.0), (-a1, a0, zero))
    put_row(on_b[row], (1.0, 0.0, 0.0), (zero, b2, -b1))
    put_row(on_b[row + 1], (0.0, 1.0, 0.0), (-b2, zero, b0))
    put_row(on_b[row + 2], (0.0, 0.0, 1.0), (b1, -b0, zero))


rate_of_turning = bare(lambda work, i, n, gap: dot(swing(work, i, n), gap))


@bare
def surplus_of_turning(work, i, n, apart, surplus):
    turning = swing(work, i, n)
    return surplus - (dot(swing(work, i, turning), apart.gap) + 2.0 * dot(turning, apart.rate))


@bare
def fill_own_drives(model, work, t):
    """m(phi) . b = 0 with m = cos(phi) quarter - sin(phi) zero: b follows the angle phi about the axis."""
    joint, slots, kin, rows = model.turns, model.slots, work.kinematics, work.rows
    signals = model.signals
    mode_time = model.world.control[CONTROL_MODE_TIME]
    for k in range(joint.slot.shape[0]):
        slot, row, side, a, b = bodies_of_row(slots, joint, k)
        phi, speed, surge = evaluate(signals, joint.signal[k], t, mode_time)
        c, s = np.cos(phi), np.sin(phi)
        zero, quarter = turn(kin.turned[a], joint.zero[k]), turn(kin.turned[a], joint.quarter[k])
        m = minus(times(c, quarter), times(s, zero))
        along = plus(times(c, zero), times(s, quarter))  # dm/dphi = -along
        f = turn(kin.turned[b], joint.mark[k])
        product = _product(kin, a, b, m, f)
        kf, mf = dot(along, f), dot(m, f)
        _turn_rows(rows, slot, side, row, product.normal)
        rows.residual[slot, row] = mf
        rows.rate[slot, row] = product.rate - speed * kf
        turning = _product(kin, a, b, along, f).rate
        rows.gamma[slot, row] = product.gamma + 2.0 * speed * turning + surge * kf + speed * speed * mf


@bare
def fill_wheels(model, work):
    """v + omega x (rho + r e) = 0 along the plane's edges and its normal n; e points down the wheel, of the axis a.

    With u = n - (n . a) a and s = |u|: e = -u / s, e' = -(u' - e (e . u')) / s. Along n it is the rate of the height
    n . (R + rho) - r s. Source: Neimark and Fufaev, Dynamics of Nonholonomic Systems (1972).
    """
    wheel, slots, kin, rows = model.wheels, model.slots, work.kinematics, work.rows
    for k in range(wheel.slot.shape[0]):
        slot, first = wheel.slot[k], wheel.row[k]
        body, radius, normal = slots.body[slot, wheel.side[k]], wheel.radius[k], triple(wheel.frame[k, 2], 0)
        arm, axis = turned(work, body, wheel.centre[k]), turned(work, body, wheel.axis[k])
        arm_rate, turning = swing(work, body, arm), swing(work, body, axis)
        share = dot(normal, axis)
        up = minus(normal, times(share, axis))
        rise = np.sqrt(dot(up, up))
        e = over(negative(up), rise)
        change = negative(plus(times(dot(normal, turning), axis), times(share, turning)))
        e_rate = over(minus(times(dot(e, change), e), change), rise)
        reach = plus(arm, times(radius, e))
        slip = plus(kin.velocity[body], cross(kin.omega[body], reach))
        surplus = cross(kin.omega[body], plus(arm_rate, times(radius, e_rate)))
        for c in range(3):
            d = triple(wheel.frame[k, c], 0)
            put_row(rows.jacobian[slot, wheel.side[k], first + c], d, cross(reach, d))
            rows.residual[slot, first + c] = 0.0
            rows.rate[slot, first + c] = dot(d, slip)
            rows.gamma[slot, first + c] = -dot(d, surplus)
        rows.residual[slot, first + 2] = dot(normal, plus(kin.position[body], reach)) - wheel.height[k]


@bare
def leave_slips(model, values):
    """Zero what rows on velocities alone have in `values` (n_slots, 6): they do not say where a body is."""
    wheel = model.wheels
    for k in range(wheel.slot.shape[0]):
        for c in range(2):
            values[wheel.slot[k], wheel.row[k] + c] = 0.0


@bare
def fill_own_rows(model, work):
    fill_products(model, work)
    fill_wheels(model, work)
