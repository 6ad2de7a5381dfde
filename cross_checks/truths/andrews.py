"""Andrews' squeezer in the crank angle alone: every other body follows by the intersection of two circles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cross_checks.certify.agreement import agree, converged
from cross_checks.certify.mechanisms.one_freedom import OneFreedom, hamilton, lagrange
from cross_checks.certify.numerics import jet
from cross_checks.certify.numerics.jet import Jet
from cross_checks.truth import Truth
from mbs_ref.scene import Scene
from mbs_ref.scenes import andrews as given


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Lagrange's and Hamilton's equations in beta; neither knows a constraint or a multiplier."""
    mass = np.array([body.mass for body in scene.bodies])
    inertia = np.zeros((len(mass), 3, 3))
    inertia[:, 2, 2] = [getattr(body, "inertia", 0.0) for body in scene.bodies]
    free = OneFreedom(_poses, mass, inertia, np.zeros(3), np.longdouble(given.START["beta"]), np.longdouble(0), _stored)
    found = agree(lagrange(free), hamilton(free), times, extended=True)
    how = "Hamilton's equations in the crank angle, loops closed by circles, by extrapolation in extended precision"
    truth = converged(found, "Lagrange's by DOP853", how)
    angle = 2.0 * np.arctan2(truth.orientation[..., 3], truth.orientation[..., 0])
    spin = None if truth.angular_velocity is None else truth.angular_velocity[..., 2]
    velocity = None if truth.velocity is None else truth.velocity[..., :2]
    flat = replace(truth, position=truth.position[..., :2], orientation=angle, velocity=velocity)
    return replace(flat, angular_velocity=spin, is_costly=True)


def _poses(beta: Jet) -> tuple[Jet, Jet]:
    """Return the centres (7, 3) and axes (7, 3, 3) of K1 to K7."""
    legs = _legs(beta)
    centres, axes = [], []
    for (name, (ahead, left)), (root, along) in zip(given.CENTRES.items(), legs, strict=True):
        centres.append(_in_space(root + along * ahead + _left(along) * left))
        axes.append(_axes(_turned(along, -given.AHEAD[name])))
    return jet.stack(centres), jet.stack(axes)


def _legs(beta: Jet) -> list[tuple[Jet, Jet]]:
    """Return the first joint (2,) m and the unit vector (2,) to the second joint of K1 to K7."""
    origin, a, b = (jet.lift(np.array(point)) for point in ((0.0, 0.0), given.A, given.B))
    crank = jet.stack([jet.cos(beta), jet.sin(beta)])
    pin = crank * given.RR
    apex = _apex(pin, b, given.D, given.SS, 1)
    upper, lower = _apex(a, apex, given.ZT, given.E, 1), _apex(a, apex, given.U, given.ZF, -1)
    second = ((pin, apex, given.D), (b, apex, given.SS), (upper, apex, given.E), (a, upper, given.ZT),
              (lower, apex, given.ZF), (a, lower, given.U))  # fmt: skip
    return [(origin, crank), *((root, (end - root) * (1.0 / length)) for root, end, length in second)]


def _apex(first: Jet, second: Jet, r: float, s: float, side: int) -> Jet:
    """Return the point at distance r from the first and s from the second; side 1: left of the way between them."""
    between = second - first
    square = _dot(between, between)
    ahead = (square + (r * r - s * s)) * 0.5  # times the distance
    height = jet.sqrt(square * (r * r) - ahead * ahead)
    return first + (between * ahead + _left(between) * height * side) * jet.reciprocal(square)


def _stored(beta: Jet) -> Jet:
    """Return the energy of the spring less the work of the motor, J."""
    root, along = _legs(beta)[2]
    hook = root + along * given.HOOK[0] + _left(along) * given.HOOK[1]
    reach = hook - jet.lift(np.array(given.C))
    stretch = jet.sqrt(_dot(reach, reach)) - given.REST
    return stretch * stretch * (0.5 * given.STIFFNESS) - beta * given.DRIVE


def _dot(a: Jet, b: Jet) -> Jet:
    return a[0] * b[0] + a[1] * b[1]


def _left(a: Jet) -> Jet:
    return jet.stack([-a[1], a[0]])


def _turned(a: Jet, angle: float) -> Jet:
    """Return a vector turned by a multiple of a right angle, exactly."""
    for _ in range(round(angle / (np.pi / 2)) % 4):
        a = _left(a)
    return a


def _in_space(a: Jet) -> Jet:
    return jet.stack([a[0], a[1], a[0] * 0])


def _axes(along: Jet) -> Jet:
    c, s, zero = along[0], along[1], along[0] * 0
    one = zero + 1
    rows = ([c, -s, zero], [s, c, zero], [zero, zero, one])
    return jet.stack([jet.stack(row) for row in rows])
