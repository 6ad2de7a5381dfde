"""A scene on its way to formulas: its numbers as rationals, in units of the proof, and what its bodies still need."""

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from cross_checks.truths.proofs import kinematics
from cross_checks.truths.proofs.kinematics import Frame, Unknowns
from cross_checks.truths.proofs.tape import Formula, Tape, Vector, cross, minus, plus
from mbs_ref.scene import GROUND

Exact = Callable[[float], Fraction]
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
    frames: dict[str, Frame] = field(default_factory=dict)
    wrench: dict[str, tuple[Vector, Vector]] = field(default_factory=dict)  # missing force, moment about the origin
    residuals: list[Formula] = field(default_factory=list)
    closing: list[Formula] = field(default_factory=list)  # rates of the closures of loops
    order: list[tuple[str, str, Any]] = field(default_factory=list)  # parent, body, joint

    def __post_init__(self) -> None:
        self.unknowns = Unknowns(self.tape)
        self.bodies = {body.name: body for body in self.scene.bodies}
        self.frames[GROUND] = kinematics.ground(self.tape)

    def vector(self, values: Any, unit: Fraction | int = 1) -> Vector:
        """Return a scene's vector as constants, in multiples of a unit."""
        numbers = [self.tape.number(self.exact(x) / unit) for x in values]
        return tuple((numbers + [self.tape.number(0)] * 3)[:3])  # type: ignore[return-value]

    def number(self, value: float, unit: Fraction | int = 1) -> Formula:
        """Return a scene's number as a constant."""
        return self.tape.number(self.exact(value) / unit)

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
