"""Impacts of free bodies without friction: gaps with their rates, and what an impulse changes.

Between impacts every gap stays positive. In the window of an impact one gap falls from positive to negative, so that
its root is the one impact; all motions of the enclosure pass through it there (transversality).
"""

from typing import Any

from flint import arb  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import Number
from cross_checks.truths.proofs.checker.mechanics import Mechanics, dot, minus
from cross_checks.truths.proofs.coverage import PAIRS


class Impacts:
    """The contacts of a scene, in the numbers of the checker's mechanics."""

    def __init__(self, mechanics: Mechanics) -> None:
        self.mechanics, self.parts = mechanics, mechanics.scene.contacts

    def gap(self, part: Any, bodies: list[list[Number]]) -> tuple[Number, Number, list[Number], list[int]]:
        """Return a gap (m), its rate (m/s), the normal from body b to body a, and both bodies (ground: -1)."""
        ends, vector, ball = (
            [self.mechanics.index[name] for name in part.ends],
            self.mechanics.vector,
            self.mechanics.ball,
        )
        states = [bodies[k] if k >= 0 else [arb(0)] * 14 for k in ends]
        apart, speed = minus(*(own[:3] for own in states)), minus(*(own[8:11] for own in states))
        if part.type in PAIRS:
            normal, radius = apart, ball(part.radius_a) + ball(part.radius_b)
        elif part.type == "circle_on_line":
            start, end, radius = vector(part.point_1), vector(part.point_2), ball(part.radius)
            apart, normal = minus(apart, start), [start[1] - end[1], end[0] - start[0], arb(0)]
        else:
            apart, normal, radius = minus(apart, vector(part.point)), vector(part.normal), ball(part.radius)
        size = dot(normal, normal).sqrt()
        normal = [x / size for x in normal]
        return dot(normal, apart) - radius, dot(normal, speed), normal, ends

    def after(self, part: Any, bodies: list[list[Number]]) -> list[tuple[int, list[Number]]]:
        """Return the bodies that an impact moves, and their new velocities: v+ = -e v- along the normal."""
        _, rate, normal, ends = self.gap(part, bodies)
        inverse = {
            k: way / self.mechanics.ball(self.mechanics.scene.bodies[k].mass)
            for k, way in zip(ends, (1, -1), strict=True)
            if k >= 0
        }
        impulse = -(1 + self.mechanics.ball(part.law.restitution)) * rate / sum(map(abs, inverse.values()))
        return [
            (k, [v + impulse * share * n for v, n in zip(bodies[k][8:11], normal, strict=True)])
            for k, share in inverse.items()
        ]
