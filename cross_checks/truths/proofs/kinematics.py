"""Places, velocities and accelerations of bodies along a tree of joints, written on a tape."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from fractions import Fraction

from cross_checks.truths.proofs.tape import Formula, Tape, Vector, cross, dot, minus, plus, times

Matrix = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class Frame:
    """A body in motion. `turn` has its rotation since t = 0, `angle` that angle in the plane, `e` its parameters."""

    place: Vector
    velocity: Vector
    acceleration: Vector
    turn: Matrix
    spin: Vector
    spin_rate: Vector
    angle: Formula | None = None
    e: tuple[Formula, ...] = ()

    def at(self, place: Vector, velocity: Vector, acceleration: Vector) -> Frame:
        """Return a frame with this turn and spin, elsewhere."""
        return replace(self, place=place, velocity=velocity, acceleration=acceleration)

    def carried(self, offset: Vector) -> tuple[Vector, Vector, Vector]:
        """Return place, velocity and acceleration of the point that was at an offset from the centre at t = 0."""
        arm = turned(self.turn, offset)
        moved = cross(self.spin, arm)
        return (
            plus(self.place, arm),
            plus(self.velocity, moved),
            plus(self.acceleration, cross(self.spin_rate, arm), cross(self.spin, moved)),
        )


@dataclass
class Unknowns:
    """The coordinates y with their rates of change and start values, and the number of z."""

    tape: Tape
    starts: list[Fraction | None] = field(default_factory=list)  # Fraction, or None where closures decide
    rates: list[Formula] = field(default_factory=list)
    z_count: int = 0

    def state(self, start: Fraction) -> Formula:
        """Return a new coordinate; `follow` states its rate."""
        self.starts.append(start)
        self.rates.append(self.tape.number(0))
        return self.tape.line("y", len(self.starts) - 1)

    def follow(self, coordinate: Formula, rate: Formula) -> None:
        """State y' of a coordinate."""
        self.rates[self.tape.lines[coordinate.place][1]] = rate

    def dependent(self) -> Formula:
        """Return a new z."""
        self.z_count += 1
        return self.tape.line("z", self.z_count - 1)

    def motion(self, start: Fraction, rate: Fraction) -> tuple[Formula, Formula, Formula]:
        """Return a coordinate, its rate and its acceleration."""
        q, u, a = self.state(start), self.state(rate), self.dependent()
        self.follow(q, u)
        self.follow(u, a)
        return q, u, a


def turned(matrix: Matrix, vector: Vector) -> Vector:
    """Return a matrix times a vector."""
    return dot(matrix[0], vector), dot(matrix[1], vector), dot(matrix[2], vector)


def transposed(matrix: Matrix) -> Matrix:
    """Return the transposed matrix."""
    a, b, c = matrix
    return (a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2])


def plane_turn(tape: Tape, angle: Formula) -> Matrix:
    """Return the rotation about z."""
    s, c = angle.sin_cos()
    zero, one = tape.number(0), tape.number(1)
    return (c, -s, zero), (s, c, zero), (zero, zero, one)


def space_turn(e: tuple[Formula, ...]) -> Matrix:
    """Return the rotation of Euler parameters of norm 1."""
    a, b, c, d = e
    return (
        (a * a + b * b - c * c - d * d, (b * c - a * d) * 2, (b * d + a * c) * 2),
        ((b * c + a * d) * 2, a * a - b * b + c * c - d * d, (c * d - a * b) * 2),
        ((b * d - a * c) * 2, (c * d + a * b) * 2, a * a - b * b - c * c + d * d),
    )


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
    still = (zero, zero, zero)
    unit = ((one, zero, zero), (zero, one, zero), (zero, zero, one))
    return Frame(still, still, still, unit, still, still, zero, (one, zero, zero, zero))


def hung(joint: tuple[Vector, Vector, Vector], offset: Vector, own: Frame) -> Frame:
    """Return the frame of a body whose point at `offset` moves as `joint`; `own` states its turn and spin."""
    arm = turned(own.turn, offset)
    moved = cross(own.spin, arm)
    bend = plus(cross(own.spin_rate, arm), cross(own.spin, moved))
    moves = (minus(mark, shift) for mark, shift in zip(joint, (arm, moved, bend), strict=True))
    return own.at(*moves)


def slid(base: Frame, offset: Vector, axis: Vector, motion: tuple[Formula, Formula, Formula]) -> Frame:
    """Return the frame of a body that slides along an axis of `base`, from an offset."""
    s, u, a = motion
    place, velocity, acceleration = base.carried(plus(offset, times(axis, s)))
    along = turned(base.turn, axis)
    bend = plus(times(along, a), times(cross(base.spin, along), u * 2))
    return base.at(place, plus(velocity, times(along, u)), plus(acceleration, bend))
