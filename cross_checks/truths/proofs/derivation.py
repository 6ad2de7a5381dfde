"""A scene on its way to formulas: its numbers as rationals, in units of the proof, and what its bodies still need."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from cross_checks.truths.proofs.family import Varied
from cross_checks.truths.proofs.kinematics import Frame, Unknowns, ground
from cross_checks.truths.proofs.tape import Formula, Tape, Vector
from mbs_ref.scene import GROUND

Exact = Callable[[float], Fraction]
LEVELS = ("position", "velocity", "acceleration")  # the derivative of a displacement that a signal may give
READINGS: dict[str, Exact] = {"binary64": Fraction, "decimal": lambda x: Fraction(repr(float(x)))}


class NotCovered(ValueError):
    """The scene has a part that no proof covers."""


@dataclass(frozen=True)
class Units:
    """What counts as 1 in the proof, powers of two: m, s, kg."""

    length: Fraction
    time: Fraction
    mass: Fraction


@dataclass
class Derivation:
    """A scene on its way to a tape."""

    scene: Any
    exact: Exact
    units: Units
    tape: Tape = field(default_factory=Tape)
    parallel: bool = False  # whether bodies that start with one spin keep one angle; those at rest do not turn
    shared: dict[tuple[Formula, ...], Formula] = field(default_factory=dict)  # by spin: that angle
    frames: dict[str, Frame] = field(default_factory=dict)
    wrench: dict[str, tuple[Vector, Vector]] = field(default_factory=dict)  # missing force, moment about the origin
    residuals: list[Formula] = field(default_factory=list)
    closing: list[Formula] = field(default_factory=list)  # rates of the closures of loops
    order: list[tuple[str, str, Any]] = field(default_factory=list)  # parent, body, joint

    def __post_init__(self) -> None:
        self.unknowns = Unknowns(self.tape)
        self.bodies = {body.name: body for body in self.scene.bodies}
        self.frames[GROUND] = ground(self.tape)
        self.clock: int | None = None  # the coordinate that is time, where a signal needs it
        self.free: int | None = None  # the coordinate that is the parameter of a family

    def vector(self, values: Any, unit: Fraction | int = 1) -> Vector:
        """Return a scene's vector as constants, in multiples of a unit."""
        numbers = [self.number(x, unit) for x in values]
        return np.array((numbers + [self.tape.number(0)] * 3)[:3])

    def number(self, value: float, unit: Fraction | int = 1) -> Formula:
        """Return a scene's number as a constant, or as a polynomial of a family's parameter."""
        if isinstance(value, Varied):
            if self.free is None:
                self.free = len(self.unknowns.starts)
                self.unknowns.state(self.tape.number(0))
            a, b, c = (x / unit for x in value.coefficients(self.exact))
            s = self.tape.line("y", self.free)
            return s * (s * c + self.tape.number(b)) + self.tape.number(a)
        return self.tape.number(self.exact(value) / unit)

    def unit(self, direction: Any) -> Vector:
        """Return a direction of length 1."""
        axis = self.vector(direction)
        return axis * self.root(self.tape.number(1) / (axis @ axis))

    def root(self, square: Formula) -> Formula:
        """Return the square root of a constant."""
        if square.constant is None:
            raise NotCovered(
                "the length of a direction or of a spring changes with the parameter, which is not covered"
            )
        exact = Fraction(*map(math.isqrt, square.constant.as_integer_ratio()))
        is_square = exact * exact == square.constant
        return self.tape.number(exact) if is_square else self.tape.line("root", *square.constant.as_integer_ratio())

    def signal(self, signal: Any) -> Formula:
        """Return the value of a signal."""
        if signal.type == "constant":
            return self.number(signal.value)
        if self.clock is None:
            self.clock = len(self.unknowns.starts)
            self.unknowns.follow(self.unknowns.state(self.tape.number(0)), self.tape.number(1))
        t = self.tape.line("y", self.clock) * self.units.time
        if signal.type == "harmonic":
            wave = (t * self.exact(signal.omega) + self.number(signal.phase)).sin_cos()[0]
            return wave * self.exact(signal.amplitude) + self.number(signal.offset)
        total = self.tape.number(0)
        for c in reversed(signal.coefficients):
            total = total * t + self.number(c)
        return total

    def offset(self, body: str, point: Any) -> Vector:
        """Return where a point is from a body's centre at t = 0."""
        centre = (0.0, 0.0, 0.0) if body == GROUND else self.bodies[body].position
        return self.vector(point, self.units.length) - self.vector(centre, self.units.length)

    def mark(self, body: str, point: Any) -> Vector:
        """Return the point that a body carries, and that was at `point` at t = 0."""
        return self.frames[body].carried(self.offset(body, point))

    def marks(self, part: Any) -> list[Vector]:
        """Return the points of two bodies that a joint or a load connects."""
        points = (part.point_a, part.point_b) if hasattr(part, "point_a") else (part.point, part.point)
        return [self.mark(body, point) for body, point in zip((part.body_a, part.body_b), points, strict=True)]

    def somewhere(self, formulas: Sequence[Formula]) -> np.ndarray:
        """Return the values of formulas in floats at one arbitrary point."""
        y = [0.3 + 0.1 * k for k in range(len(self.unknowns.starts))]
        return self.tape.values([one.place for one in formulas], y)

    def close(self, value: Formula) -> None:
        """Add a closure, which stays as it is: its rate at the start, its acceleration always."""
        self.closing.append(value.rate)
        self.residuals.append(value.rate.rate)

    def rate(self, body: str) -> tuple[Vector, Vector]:
        """Return a body's velocity and spin at t = 0."""
        if body == GROUND:
            return self.frames[GROUND].place, self.frames[GROUND].spin
        part = self.bodies[body]
        spin = getattr(part, "angular_velocity", 0.0)
        spin = spin if isinstance(spin, tuple) else (0.0, 0.0, spin)
        return self.vector(part.velocity, self.units.length / self.units.time), self.vector(spin, 1 / self.units.time)

    def apply(self, body: str, place: Vector, force: Vector, moment: Vector | None = None) -> None:
        """Subtract a load from what a body needs; the ground bears any."""
        if body == GROUND:
            return
        need, turning = self.wrench[body]
        arm = np.cross(place, force)
        self.wrench[body] = need - force, turning - (arm if moment is None else arm + moment)
