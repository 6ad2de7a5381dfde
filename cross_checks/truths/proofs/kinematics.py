"""Places, turns and spins of bodies along a tree of joints, written on a tape that differentiates them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cross_checks.truths.proofs.tape import Formula, Tape, Vector


@dataclass(frozen=True)
class Frame:
    """A body in motion. `turn` has its rotation since t = 0, `angle` that angle in the plane, `e` its parameters."""

    place: Vector
    turn: Any  # an array (3, 3) of formulas
    spin: Vector
    angle: Formula | None = None
    e: tuple[Formula, ...] = ()

    def along(self, direction: Vector) -> Vector:
        """Return the direction that the body carries, and that it had at t = 0. Its rate is spin x direction."""
        now = self.turn @ direction
        for x, rate in zip(now, np.cross(self.spin, now), strict=True):
            if x.constant is None:
                x.tape.rates.setdefault(x.place, rate)
        return now

    def carried(self, offset: Vector) -> Vector:
        """Return the point that the body carries, and that was at an offset from its centre at t = 0."""
        return self.place + self.along(offset)


@dataclass
class Unknowns:
    """The coordinates y with their start values, and the number of z; the tape has the rates of y."""

    tape: Tape
    starts: list[Formula | None] = field(default_factory=list)  # constants but for a family; None: closures decide
    z_count: int = 0

    def state(self, start: Formula) -> Formula:
        """Return a new coordinate; `follow` states its rate."""
        self.starts.append(start)
        coordinate = self.tape.line("y", len(self.starts) - 1)
        self.follow(coordinate, self.tape.number(0))
        return coordinate

    def follow(self, coordinate: Formula, rate: Formula) -> None:
        """State y' of a coordinate."""
        self.tape.rates[coordinate.place] = rate

    @property
    def rates(self) -> list[Formula]:
        """The rates of all coordinates."""
        return [self.tape.line("y", k).rate for k in range(len(self.starts))]

    def dependent(self) -> Formula:
        """Return a new z."""
        self.z_count += 1
        return self.tape.line("z", self.z_count - 1)

    def motion(self, start: Formula, rate: Formula) -> Formula:
        """Return a coordinate whose acceleration is a new z."""
        q, u = self.state(start), self.state(rate)
        self.follow(q, u)
        self.follow(u, self.dependent())
        return q


def plane_turn(tape: Tape, angle: Formula) -> np.ndarray:
    """Return the rotation about z."""
    s, c = angle.sin_cos()
    zero, one = tape.number(0), tape.number(1)
    return np.array([[c, -s, zero], [s, c, zero], [zero, zero, one]])


def space_turn(e: tuple[Formula, ...]) -> np.ndarray:
    """Return the rotation of Euler parameters of norm 1."""
    a, b, c, d = e
    return np.array([
        [a * a + b * b - c * c - d * d, (b * c - a * d) * 2, (b * d + a * c) * 2],
        [(b * c + a * d) * 2, a * a - b * b + c * c - d * d, (c * d - a * b) * 2],
        [(b * d - a * c) * 2, (c * d + a * b) * 2, a * a - b * b - c * c + d * d],
    ])  # fmt: skip


def product(p: tuple[Formula, ...], q: tuple[Formula, ...]) -> tuple[Formula, ...]:
    """Return the product of two sets of Euler parameters, the second turn first."""
    a, b, c, d = p
    e, f, g, h = q
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


def ground(tape: Tape) -> Frame:
    """Return the frame at rest."""
    zero, one = tape.number(0), tape.number(1)
    still = np.array([zero] * 3)
    unit = np.array([[one, zero, zero], [zero, one, zero], [zero, zero, one]])
    return Frame(still, unit, still, zero, (one, zero, zero, zero))
