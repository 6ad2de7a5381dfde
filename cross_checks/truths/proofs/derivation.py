"""A scene on its way to formulas: its numbers as rationals, in units of the proof, and what its bodies still need."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from cross_checks.truths.proofs import kinematics
from cross_checks.truths.proofs.family import Varied
from cross_checks.truths.proofs.kinematics import Frame, Unknowns
from cross_checks.truths.proofs.tape import Formula, Tape, Vector, cross, minus, plus
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
    shared: dict[Fraction, tuple[Formula, Formula, Formula]] = field(default_factory=dict)  # by spin: that angle
    frames: dict[str, Frame] = field(default_factory=dict)
    wrench: dict[str, tuple[Vector, Vector]] = field(default_factory=dict)  # missing force, moment about the origin
    residuals: list[Formula] = field(default_factory=list)
    closing: list[Formula] = field(default_factory=list)  # rates of the closures of loops
    order: list[tuple[str, str, Any]] = field(default_factory=list)  # parent, body, joint

    def __post_init__(self) -> None:
        self.unknowns = Unknowns(self.tape)
        self.bodies = {body.name: body for body in self.scene.bodies}
        self.frames[GROUND] = kinematics.ground(self.tape)
        self.clock: int | None = None  # the coordinate that is time, where a signal needs it
        self.free: int | None = None  # the coordinate that is the parameter of a family

    def vector(self, values: Any, unit: Fraction | int = 1) -> Vector:
        """Return a scene's vector as constants, in multiples of a unit."""
        numbers = [self.number(x, unit) for x in values]
        return tuple((numbers + [self.tape.number(0)] * 3)[:3])  # type: ignore[return-value]

    def number(self, value: float, unit: Fraction | int = 1) -> Formula:
        """Return a scene's number as a constant, or as a polynomial of a family's parameter."""
        if isinstance(value, Varied):
            if self.free is None:
                self.free = len(self.unknowns.starts)
                self.unknowns.state(Fraction(0))
            a, b, c = (x / unit for x in value.coefficients(self.exact))
            s = self.tape.line("y", self.free)
            return s * (s * c + self.tape.number(b)) + self.tape.number(a)
        return self.tape.number(self.exact(value) / unit)

    def signal(self, signal: Any, order: int = 0) -> Formula:
        """Return a derivative of a signal by the unit of time."""
        if signal.type == "constant":
            return self.number(0.0 if order else signal.value)
        if self.clock is None:
            self.clock = len(self.unknowns.starts)
            self.unknowns.follow(self.unknowns.state(Fraction(0)), self.tape.number(1))
        t = self.tape.line("y", self.clock)
        if signal.type == "harmonic":
            pace = self.exact(signal.omega) * self.units.time
            wave = (t * pace + self.number(signal.phase)).sin_cos()[order % 2]
            return wave * (self.exact(signal.amplitude) * pace**order * (-1) ** (order // 2)) + self.number(
                0.0 if order else signal.offset
            )
        total = self.tape.number(0)
        for k in reversed(range(order, len(signal.coefficients))):
            total = total * t + self.number(signal.coefficients[k]) * (self.units.time**k * math.perm(k, order))
        return total

    def displacement(self, drive: Any, order: int, unit: Fraction | int = 1) -> Formula:
        """Return a derivative of what a drive prescribes; at t = 0 where the drive prescribes a higher one."""
        level = LEVELS.index(drive.level)
        if order < level:
            return self.tape.number(0)
        return self.signal(drive.motion, order - level) * (self.units.time**level / unit)

    def offset(self, body: str, point: Any) -> Vector:
        """Return where a point is from a body's centre at t = 0."""
        centre = (0.0, 0.0, 0.0) if body == GROUND else self.bodies[body].position
        return minus(self.vector(point, self.units.length), self.vector(centre, self.units.length))

    def rate(self, body: str) -> tuple[list[Fraction], list[Fraction]]:
        """Return a body's velocity and spin at t = 0, three numbers each."""
        if body == GROUND:
            return [Fraction(0)] * 3, [Fraction(0)] * 3
        part = self.bodies[body]
        spin = getattr(part, "angular_velocity", 0.0)
        spin = spin if isinstance(spin, tuple) else (0.0, 0.0, spin)
        length, time = self.units.length, self.units.time
        straight = [self.exact(x) * time / length for x in part.velocity]
        return (straight + [Fraction(0)] * 3)[:3], [self.exact(x) * time for x in spin]

    def apply(self, body: str, place: Vector, force: Vector, moment: Vector | None = None) -> None:
        """Subtract a load from what a body needs; the ground bears any."""
        if body == GROUND:
            return
        need, turning = self.wrench[body]
        arm = cross(place, force)
        self.wrench[body] = minus(need, force), minus(turning, arm if moment is None else plus(arm, moment))
