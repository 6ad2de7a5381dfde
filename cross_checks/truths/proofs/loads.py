"""Loads and impacts on a tape, with one z = 1 / distance for every spring and attracting pair; no friction."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np

from cross_checks.truths.proofs.coverage import PAIRS
from cross_checks.truths.proofs.derivation import Derivation
from cross_checks.truths.proofs.tape import Formula, Vector, rate
from mbs_ref.scene import GROUND


def _inverse_length(work: Derivation, gap: Vector) -> Formula:
    """Return 1 / |gap| as a new z."""
    inverse = work.unknowns.dependent()
    work.residuals.append(inverse * inverse * (gap @ gap) - work.tape.number(1))
    return inverse


def _spring(work: Derivation, load: Any) -> None:
    units, (a, b) = work.units, work.marks(load)
    gap = b - a
    inverse = _inverse_length(work, gap)
    if load.rest_length is None:
        first = work.vector(load.point_b, units.length) - work.vector(load.point_a, units.length)
        rest = work.root(first @ first)
    else:
        rest = work.number(load.rest_length, units.length)
    stiffness = work.number(load.stiffness, units.mass / units.time**2)
    tension = stiffness * ((gap @ gap) * inverse - rest)
    if load.damping:
        tension = tension + work.number(load.damping, units.mass / units.time) * (gap @ rate(gap)) * inverse
    pull = gap * (tension * inverse)
    work.apply(load.body_b, b, -pull)
    work.apply(load.body_a, a, pull)


def _torsion(work: Derivation, load: Any) -> None:
    units = work.units
    unit = units.mass * units.length**2 / units.time**2
    a, b = (work.frames[name] for name in load.ends)
    angle = b.angle - a.angle  # type: ignore[operator]  # bodies in the plane have one
    if load.rest_angle is not None:
        start = [Fraction(0) if name == GROUND else work.exact(work.bodies[name].angle) for name in load.ends]
        angle = angle + work.tape.number(start[1] - start[0] - work.exact(load.rest_angle))
    torque = angle * work.number(load.stiffness, unit)
    torque = torque + (b.spin[2] - a.spin[2]) * work.number(load.damping, unit * units.time)
    still = work.frames[GROUND].place
    for name, moment in zip(load.ends, (torque, -torque), strict=True):
        work.apply(name, still, still, np.array([*still[:2], moment]))


def _torque(work: Derivation, load: Any) -> None:
    values, still = (0.0, 0.0, load.torque) if load.type == "torque" else load.vector, work.frames[GROUND].place
    moment = work.vector(values, work.units.mass * work.units.length**2 / work.units.time**2)
    work.apply(load.body, still, still, moment * work.signal(load.factor))


def _force(work: Derivation, load: Any) -> None:
    units = work.units
    place = work.mark(load.body, load.point)
    vector = work.vector(load.vector, units.mass * units.length / units.time**2)
    work.apply(load.body, place, vector * work.signal(load.factor))


def _attract(work: Derivation, own: int, other: int, field: Vector) -> None:
    """Attract a body by gm of another in a field of gm = 1."""
    body, gm = work.scene.bodies[own], next(part for part in work.scene.loads if part.type == "newton").gm[other]
    force = work.number(gm, work.units.length**3 / work.units.time**2) * work.number(body.mass, work.units.mass)
    work.apply(body.name, work.frames[body.name].place, field * force)


def _newton(work: Derivation, load: Any) -> None:
    places = [work.frames[name].place for name in work.scene.body_names]
    for i, j in combinations(range(len(places)), 2):
        if load.gm[i] or load.gm[j]:
            gap = places[j] - places[i]
            inverse = _inverse_length(work, gap)
            field = gap * (inverse * inverse * inverse)
            _attract(work, i, j, field)
            _attract(work, j, i, -field)


def _oblateness(work: Derivation, load: Any) -> None:
    """Attract by zonal harmonics: a = -gm sum J_n R^n / r^(n+2) (P_n' k - P_(n+1)' r / |r|)."""
    names, axis, radius = work.scene.body_names, work.vector(load.axis), work.number(load.radius, work.units.length)
    k = work.scene.body_index(load.body)
    for i, name in enumerate(names):
        if i == k:
            continue
        gap = work.frames[name].place - work.frames[load.body].place
        inverse = _inverse_length(work, gap)
        unit = gap * inverse
        slopes, size = _legendre_slopes(unit @ axis, len(load.zonal) + 2), inverse * inverse * inverse * radius
        total = work.frames[GROUND].place
        for n, harmonic in enumerate(load.zonal, start=2):
            size = size * (inverse * radius)
            total = total + (axis * slopes[n] - unit * slopes[n + 1]) * (size * work.number(harmonic) * -1)
        _attract(work, i, k, total)
        _attract(work, k, i, -total)


def _legendre_slopes(s: Formula, degree: int) -> list[Formula]:
    """Return P_n'(s) for n = 0 to degree: P_(n+1)' = s P_n' + (n + 1) P_n."""
    value, slope = [s.tape.number(1), s], [s.tape.number(0), s.tape.number(1)]
    for n in range(1, degree):
        value.append((s * value[n] * (2 * n + 1) - value[n - 1] * n) * Fraction(1, n + 1))
        slope.append(s * slope[n] + value[n] * (n + 1))
    return slope


def impact(work: Derivation, part: Any) -> tuple[int, int, list[tuple[int, int]]]:
    """Return the lines of a contact's clearance and of its rate, and the columns of y with their lines after an impact.

    The clearance is positive where the bodies do not touch. A velocity changes by -(1 + e) (n v) / (n n) n times the
    share m_b / (m_a + m_b) of body a; n is the line of centres, or a plane's normal, where the share is 1.
    """
    a, b = (work.frames[name].place for name in part.ends)
    gap, length, shares = a - b, work.units.length, [work.tape.number(1)]
    if part.type in PAIRS:
        normal, reach = gap, work.number(part.radius_a, length) + work.number(part.radius_b, length)
        clearance = gap @ gap - reach * reach
        m_a, m_b = (work.number(work.bodies[name].mass, work.units.mass) for name in part.ends)
        shares = [m_b / (m_a + m_b), -m_a / (m_a + m_b)]
    else:
        if part.type == "circle_on_line":
            (x, y, zero), point = work.vector(part.point_2) - work.vector(part.point_1), part.point_1
            normal: Vector = np.array([-y, x, zero])
        else:
            normal, point = work.vector(part.normal), part.point
        clearance = normal @ (gap - work.vector(point, length))
        clearance = clearance - work.number(part.radius, length) * work.root(normal @ normal)
    speed = normal @ (rate(a) - rate(b))
    push = (work.number(part.law.restitution) + work.tape.number(1)) * speed / (normal @ normal)
    after = [
        (work.tape.lines[x.rate.place][1], (x.rate - push * share * n).place)
        for place, share in zip((a, b), shares, strict=False)
        for x, n in zip(place, normal, strict=True) if x.constant is None
    ]  # fmt: skip
    return clearance.place, clearance.rate.place, after


LAWS: dict[str, Callable[[Derivation, Any], None]] = {
    "spring_damper": _spring, "torsion_spring": _torsion, "torque": _torque, "torque_vector": _torque, "force": _force,
    "newton": _newton, "oblateness": _oblateness, "epoch": lambda work, load: None,
}  # fmt: skip
