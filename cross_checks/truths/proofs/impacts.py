"""Impacts on a tape: when two bodies touch, and the coordinates after an impulse without friction (Newton's law)."""

from typing import Any

from cross_checks.truths.proofs.coverage import PAIRS
from cross_checks.truths.proofs.derivation import Derivation
from cross_checks.truths.proofs.tape import dot, minus, rate


def impact(work: Derivation, part: Any) -> tuple[int, int, list[tuple[int, int]]]:
    """Return the lines of a contact's clearance and of its rate, and the columns of y with their lines after an impact.

    The clearance is positive where the bodies do not touch. A velocity changes by -(1 + e) (n v) / (n n) n times the
    share m_b / (m_a + m_b) of body a; n is the line of centres, or a plane's normal, where the share is 1.
    """
    a, b = (work.frames[name].place for name in part.ends)
    gap, length, shares = minus(a, b), work.units.length, [work.tape.number(1)]
    if part.type in PAIRS:
        normal, reach = gap, work.number(part.radius_a, length) + work.number(part.radius_b, length)
        clearance = dot(gap, gap) - reach * reach
        m_a, m_b = (work.number(work.bodies[name].mass, work.units.mass) for name in part.ends)
        shares = [m_b / (m_a + m_b), -m_a / (m_a + m_b)]
    else:
        if part.type == "circle_on_line":
            (x, y, zero), point = minus(work.vector(part.point_2), work.vector(part.point_1)), part.point_1
            normal = (-y, x, zero)
        else:
            normal, point = work.vector(part.normal), part.point
        clearance = dot(normal, minus(gap, work.vector(point, length)))
        clearance = clearance - work.number(part.radius, length) * work.root(dot(normal, normal))
    speed = dot(normal, minus(rate(a), rate(b)))
    push = (work.number(part.law.restitution) + work.tape.number(1)) * speed / dot(normal, normal)
    after = [
        (work.tape.lines[x.rate.place][1], (x.rate - push * share * n).place)
        for place, share in zip((a, b), shares, strict=False)
        for x, n in zip(place, normal, strict=True) if x.constant is None
    ]  # fmt: skip
    return clearance.place, clearance.rate.place, after
