"""Impacts of free bodies without friction: gaps with their rates, and what an impulse changes.

Between impacts every gap stays positive. In the window of an impact one gap falls from positive to negative, so that
its root is the one impact; all motions of the enclosure pass through it there (transversality).
"""

from typing import Any

from flint import arb  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import Number
from cross_checks.truths.proofs.checker.coverage import PAIRS
from cross_checks.truths.proofs.checker.mechanics import Mechanics, dot
from cross_checks.truths.proofs.checker.model import TURNS


class Impacts:
    """The contacts of a scene, in the numbers of the checker's mechanics."""

    def __init__(self, mechanics: Mechanics) -> None:
        self.mechanics, self.parts = mechanics, mechanics.scene.contacts

    def gap(self, part: Any, bodies: list[list[Number]]) -> tuple[Number, Number, list[Number], int, int]:
        """Return a gap (m), its rate (m/s), the normal from body b to body a, and both bodies (ground: -1)."""
        a, b = (self.mechanics.index[name] for name in part.ends)
        place, velocity = (
            [*(self._three(k, own, moving) for k, own in enumerate(bodies)), [arb(0)] * 3] for moving in (0, 1)
        )
        vector, ball = self.mechanics.vector, self.mechanics.ball
        if part.type in PAIRS:
            normal, radius = (
                [x - y for x, y in zip(place[a], place[b], strict=True)],
                ball(part.radius_a) + ball(part.radius_b),
            )
            base = [arb(0)] * 3
        else:
            base, radius = vector(part.point_1 if part.type == "circle_on_line" else part.point), ball(part.radius)
            normal = vector(part.normal) if part.type == "sphere_on_plane" else self._left(part)
        size = dot(normal, normal).sqrt()
        normal = [x / size for x in normal]
        apart = [x - y - z for x, y, z in zip(place[a], place[b], base, strict=True)]
        speed = [x - y for x, y in zip(velocity[a], velocity[b], strict=True)]
        return dot(normal, apart) - radius, dot(normal, speed), normal, a, b

    def _three(self, k: int, own: list[Number], moving: int) -> list[Number]:
        """Return a body's place or velocity."""
        n, turns = self.mechanics.scene.dimension, TURNS[self.mechanics.scene.bodies[k].type]
        first = (n + turns) * moving
        return (own[first : first + n] + [arb(0)] * 3)[:3]

    def _left(self, line: Any) -> list[arb]:
        start, end = self.mechanics.vector(line.point_1), self.mechanics.vector(line.point_2)
        return [start[1] - end[1], end[0] - start[0], arb(0)]

    def after(self, part: Any, bodies: list[list[Number]]) -> list[tuple[int, list[Number]]]:
        """Return the bodies that an impact moves, and their new velocities: v+ = -e v- along the normal."""
        _, rate, normal, a, b = self.gap(part, bodies)
        ends = [
            (k, way, self.mechanics.ball(self.mechanics.scene.bodies[k].mass)) for k, way in ((a, 1), (b, -1)) if k >= 0
        ]
        impulse = -(1 + self.mechanics.ball(part.law.restitution)) * rate / sum(1 / mass for *_, mass in ends)
        return [
            (k, [v + way * impulse / mass * n for v, n in zip(self._three(k, bodies[k], 1), normal, strict=True)])
            for k, way, mass in ends
        ]
