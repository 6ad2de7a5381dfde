"""Truths of two problems of the IVP test set: Andrews' squeezer and the car axis."""

from typing import Any

import numpy as np

from cross_checks.truths.made_by import Formulation, agree
from cross_checks.truths.made_by.mechanisms.one_freedom import agree_on
from cross_checks.truths.made_by.numerics import jet
from cross_checks.truths.made_by.numerics.jet import Jet
from cross_checks.truths.truth import Truth
from mbs_ref import Scene

# Andrews' squeezer in the source's names, m: fixed points; joint to joint, K1 to K5, K7, K6; the spring's hook on K3
A, B, C = (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)
RR, D, SS, E, ZT, U, ZF = 0.007, 0.028, 0.035, 0.02, 0.04, 0.04, 0.02
HOOK = (0.018, 0.02)  # along K3 from B, and to the left
STIFFNESS, REST, DRIVE = 4530.0, 0.07785, 0.033  # N/m, m, N m
BETA = -0.0617138900142764496358948458001  # rad, at t = 0
# of K1 to K7: the centre, m, along a body from its first joint and to the left; quarter turns from the source's angle
# to the body's direction from its first to its second joint
CENTRES = (((0.00092, 0.0), 0), ((0.0115, 0.0), 2), ((0.01874, 0.01043), -1), ((E - 0.01421, 0.0), -1),
           ((0.02308, 0.00916), 0), ((ZF - 0.01421, 0.0), 0), ((0.01228, -0.00449), -1))  # fmt: skip
# The car axis: m, of the axis and of the springs at rest; kg, of each end; m, rad/s, of the right wheel on its road
LENGTH, HEIGHT, MASS, AMPLITUDE, OMEGA = 1.0, 0.5, 5e-4, 0.1, 10.0


def andrews(scene: Scene, times: np.ndarray) -> Truth:
    """Lagrange's and Hamilton's equations in beta; neither knows a constraint or a multiplier."""
    how = "Hamilton's equations in the crank angle, loops closed by circles, by extrapolation in extended precision"
    start, ways = np.longdouble(BETA), ("Lagrange's by DOP853", how)
    return agree_on(scene, _squeezer_poses, start, np.longdouble(0), times, ways, stored=_stored, is_costly=True)


def _squeezer_poses(beta: Jet) -> tuple[Jet, Jet]:
    """Return the centres (7, 2) and angles (7,) of K1 to K7."""
    centres, angles = [], []
    for ((ahead, left), quarters), (root, along) in zip(CENTRES, _legs(beta), strict=True):
        centres.append(root + along * ahead + _left(along) * left)
        angles.append(_angle(_turned(along, -quarters)))
    return jet.stack(centres), jet.stack(angles)


def _legs(beta: Jet) -> list[tuple[Jet, Jet]]:
    """Return the first joint (2,) m and the unit vector (2,) to the second joint of K1 to K7."""
    origin, a, b = (jet.lift(np.array(point)) for point in ((0.0, 0.0), A, B))
    crank = jet.stack([jet.cos(beta), jet.sin(beta)])
    pin = crank * RR
    apex = _apex(pin, b, D, SS, 1)
    upper, lower = _apex(a, apex, ZT, E, 1), _apex(a, apex, U, ZF, -1)
    second = ((pin, apex, D), (b, apex, SS), (upper, apex, E), (a, upper, ZT), (lower, apex, ZF), (a, lower, U))
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
    hook = root + along * HOOK[0] + _left(along) * HOOK[1]
    reach = hook - jet.lift(np.array(C))
    stretch = jet.sqrt(_dot(reach, reach)) - REST
    return stretch * stretch * (0.5 * STIFFNESS) - beta * DRIVE


def _dot(a: Jet, b: Jet) -> Jet:
    return a[0] * b[0] + a[1] * b[1]


def _left(a: Jet) -> Jet:
    return jet.stack([-a[1], a[0]])


def _turned(a: Jet, quarters: int) -> Jet:
    """Return a vector turned by right angles, exactly."""
    for _ in range(quarters % 4):
        a = _left(a)
    return a


def _angle(along: Jet) -> Jet:
    """Return the angle of a unit vector; its value ignores the complex step, by which it changes no energy."""
    x, y = along[0], along[1]
    value = np.arctan2(np.real(y.value), np.real(x.value))
    return Jet(value, x.value * y.first - y.value * x.first, x.value * y.second - y.value * x.second)


def car_axis(scene: Scene, times: np.ndarray) -> Truth:
    """Newton's law along the slide and across the axis; index one with both constraints differentiated by hand."""
    first = "the source's coordinates with multipliers by DOP853"
    second = "Newton's law along the slide and across the axis by extrapolation in extended precision"
    return agree(_with_multipliers(), _minimal(), times, (first, second), extended=True, is_costly=True)


def _road(t) -> tuple[Any, Any, Any]:
    """Return the right wheel and its first two derivatives, x + i y in m.

    It stays LENGTH from the origin while its height is AMPLITUDE sin(OMEGA t).
    """
    y, dy = AMPLITUDE * np.sin(OMEGA * t), AMPLITUDE * OMEGA * np.cos(OMEGA * t)
    ddy = -(OMEGA**2) * y
    x = np.sqrt(LENGTH**2 - y * y)
    dx = -y * dy / x
    ddx = -(dy * dy + y * ddy + dx * dx) / x
    return x + 1j * y, dx + 1j * dy, ddx + 1j * ddy


def _along(a, b):
    """Return the product a . b of vectors x + i y."""
    return (np.conj(a) * b).real


def _forces(left, right, wheel) -> tuple[Any, Any]:
    """Return springs and weight on both ends, N."""
    first, second = ((HEIGHT / abs(arm) - 1.0) * arm - 1j * MASS for arm in (left, right - wheel))
    return first, second


def _placed(wheel, left, right) -> tuple[np.ndarray, np.ndarray]:
    """Return places and angles of the wheels' axis, of the left and of the right end."""
    places, tilt = np.array([wheel, left, right]), np.angle(wheel)
    return np.stack((np.real(places), np.imag(places)), axis=1), np.array([tilt, tilt, 0.0 * tilt])


def _minimal() -> Formulation:
    """s: how far up the slide the left end is, in units of LENGTH; alpha: the axis' angle."""

    def ends(t, y):
        road, along = _road(t), np.exp(1j * y[1])
        left = y[0] * 1j * road[0]
        return road, along, left, left + LENGTH * along

    def derivative(t, y):
        (wheel, velocity, acceleration), along, left, right = ends(t, y)
        up, over = 1j * wheel, 1j * along
        known = 1j * (2.0 * y[2] * velocity + y[0] * acceleration)  # of both accelerations
        swing = -LENGTH * y[3] ** 2 * along
        first, second = _forces(left, right, wheel)
        total, end = (first + second) / MASS - 2.0 * known - swing, second / MASS - known - swing
        a, b, c, d = 2.0 * _along(up, up), LENGTH * _along(up, over), _along(up, over), LENGTH
        e, f = _along(up, total), _along(over, end)
        det = a * d - b * c
        return np.array([y[2], y[3], (e * d - b * f) / det, (a * f - e * c) / det])

    def poses(t, y):
        road, _, left, right = ends(t, y)
        return _placed(road[0], left, right)

    return Formulation(derivative, np.array([HEIGHT / LENGTH, 0.0, 0.0, 0.0]), poses)


def _with_multipliers() -> Formulation:
    """Left and right end, four coordinates and their rates; 0 = left . wheel and |left - right| = LENGTH."""

    def derivative(t, y):
        (wheel, velocity, acceleration), (left, right, v_left, v_right) = _road(t), y.view(complex)
        first, second = (force / MASS for force in _forces(left, right, wheel))
        between, closing = left - right, v_left - v_right
        shared = _along(wheel, between)
        matrix = [[_along(wheel, wheel), shared], [shared, 2.0 * _along(between, between)]]
        due = 2.0 * _along(v_left, velocity) + _along(left, acceleration), _along(closing, closing)
        free = _along(wheel, first), _along(between, first - second)
        along, across = np.linalg.solve(matrix, -np.add(due, free))
        push = across * between
        return np.array([v_left, v_right, first + along * wheel + push, second - push]).view(float)

    lean = -HEIGHT * AMPLITUDE * OMEGA / LENGTH
    start = np.array([0.0, HEIGHT, LENGTH, HEIGHT, lean, 0.0, lean, 0.0])
    return Formulation(derivative, start, lambda t, y: _placed(_road(t)[0], *y.view(complex)[:2]))
