"""A log's formulas beside the scene: start values, and equality with the absolute coordinates."""

import random
from collections.abc import Sequence
from fractions import Fraction
from itertools import chain
from typing import Any

from flint import arb, arb_mat, arb_series  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import Number, Refused, above, exact, precision, terms
from cross_checks.truths.proofs.checker.formulas import Formulas
from cross_checks.truths.proofs.checker.mechanics import EQUAL, Mechanics, rotation
from cross_checks.truths.proofs.coverage import DRIVES
from cross_checks.truths.proofs.family import Varied, family
from mbs_ref import Scene

POINTS, POINT_BITS = 3, 1000  # random points, bits of numbers
ITERATIONS, NEGLIGIBLE = 60, 2.0**-800  # of Newton's method for z, from 1; of a change of z, where it ends
STATE = 14  # numbers of a body's state
ONE, ZERO = ("c", 1, 1), ("c", 0, 1)  # lines
START_GAP = 1e-7  # of a rate, 1: how far a scene's dependent rates may be from its closures


class Model:
    """A scene, the formulas that a log states for it, and the start of y and z. Refused where they do not fit."""

    def __init__(self, header: dict[str, Any]) -> None:
        self.scene: Any = Scene.model_validate(header["scene"])
        if "ends" in header:
            self.scene = family(self.scene, *map(Scene.model_validate, header["ends"]))
        system, self.formulas = header["system"], Formulas(header["system"])
        self.units, self.clock, self.free = [Fraction(x) for x in system["units"]], system["clock"], system["free"]
        if min(self.units) <= 0 or [len(own) for own in self.formulas.outputs] != [STATE] * len(self.scene.bodies):
            raise Refused("a unit is not positive, or the outputs are not the states of the bodies")
        self.mechanics = Mechanics(self.scene, header["inputs"])
        clock, starts = self.clock, system["starts"]
        if clock is not None and (Fraction(*starts[clock]) or self.formulas.lines[self.formulas.f[clock]] != ONE):
            raise Refused(f"coordinate {clock} is not time")
        with precision(POINT_BITS):
            self.start = self._start(starts)
            if "ends" in header:
                self._vary_start(starts)
            self._compare(self.start)
            self.z_start = root(self.formulas, self.start)
            if self.free is not None:
                self.start[self.free] = self.mechanics.s = arb(0, 1)

    def _vary_start(self, starts: list[Any]) -> None:
        """Refuse a family whose start values vary, or whose parameter does."""
        varied = any(isinstance(x, Varied) for body in self.scene.bodies for x in _rates(body))
        formulas = self.formulas
        if self.scene.contacts:
            raise Refused("a parameter as an interval is not covered where bodies collide")
        if self.free is None or varied or None in starts or formulas.lines[formulas.f[self.free]] != ZERO:
            raise Refused("the start rates vary with the parameter, which is not covered")
        for s in (-1, 1):
            self.mechanics.s = arb(s)
            self._same_start([arb(s) if k == self.free else x for k, x in enumerate(self.start)])

    @property
    def is_exhibited(self) -> bool:
        """Whether the formulas exhibit a motion of a scene with loops without their multipliers.

        It obeys the equations of motion, but in singular poses of the loops others may branch off.
        """
        joints, lines = [j for j in self.scene.joints if j.type not in DRIVES], self.formulas.lines
        accelerations = sum(lines[place][0] == "z" for place in self.formulas.f)
        return len(joints) > len(self.scene.bodies) and self.formulas.m == accelerations

    def bodies(self, y: Sequence[Number]) -> list[list[Number]]:
        """Return place, angle in the plane, Euler parameters since t = 0, velocity and spin of every body, SI units."""
        outputs, (length, time, _) = self.formulas.outputs, map(exact, self.units)
        values = iter(self.formulas.run([place for own in outputs for place in own], y))
        units = [*[length] * 3, *[arb(1)] * 5, *[length / time] * 3, *[1 / time] * 3]
        return [[next(values) * unit for unit in units] for _ in outputs]

    def states(self, bodies: list[list[Any]]) -> tuple[list[Any], list[list[Any]]]:
        """Return place, turn and angle, and the six rates, of every body as `Mechanics` takes them."""
        return [(own[:3], rotation(own[4:8]), own[3]) for own in bodies], [own[8:] for own in bodies]

    def _closures(self, y: list[arb]) -> list[arb]:
        """Return the rates of all closures."""
        jets = self.mechanics.jets(*self.states(self.bodies(y)))
        return [row[1] for joint in self.scene.joints for row in self.mechanics.closure(jets, joint)]

    def _start(self, given: list[Any]) -> list[arb]:
        """Return the start of y; closures decide what is not given. The outputs must be the scene's start."""
        number, (length, time, _) = self.mechanics.exact, self.units
        rates = {number(x) for body in self.scene.bodies for x in _rates(body)} | {Fraction(0)}
        allowed = {(a - b) * unit for a in rates for b in rates for unit in (time, time / length)} | {Fraction(1)}
        allowed |= {number(x) / length for body in self.scene.bodies for x in body.position}
        if any(value is not None and Fraction(*value) not in allowed for value in given):
            raise Refused("a start value is no number of the scene")
        y = [arb(0) if value is None else exact(Fraction(*value)) for value in given]
        if unknown := [k for k, value in enumerate(given) if value is None]:
            base = self._closures(y)
            columns = [self._closures([arb(j == k) if j in unknown else x for j, x in enumerate(y)]) for k in unknown]
            matrix = [[c - b for c in row] for b, *row in zip(base, *columns, strict=True)]
            rows = [r for r, row in enumerate(matrix) if max(map(above, row)) > EQUAL]
            if len(rows) != len(unknown):
                raise Refused(f"{len(rows)} closures do not decide {len(unknown)} start rates")
            solved = solve(arb_mat([matrix[r] for r in rows]), arb_mat([[-base[r]] for r in rows]))
            for k, value in zip(unknown, solved.entries(), strict=True):
                y[k] = value
        self._same_start(y)
        if any(above(row) > EQUAL for row in self._closures(y)):
            raise Refused("the start rates do not fulfil the closures")
        return y

    def _same_start(self, y: list[arb]) -> None:
        for body, own in zip(self.scene.bodies, self.bodies(y), strict=True):
            wanted = [*self.mechanics.vector(body.position), *map(arb, (0, 1, 0, 0, 0))]
            wanted += [self.mechanics.ball(x) for x in _rates(body)]
            for k, (x, right) in enumerate(zip(own, wanted, strict=True)):
                if above(x - right) > (EQUAL if k < 8 else START_GAP * (1.0 + above(right))):
                    raise Refused(f"{body.name} does not start as the scene has it")

    def compare_energies(self, enclosures: list[list[list[arb]]], bits: int) -> None:
        """Refuse enclosures of a scene that conserves energy, but on which it is not constant."""
        with precision(bits):
            energies = [self.mechanics.energy(*self.states(bodies)) for bodies in enclosures]
        if self.mechanics.conserves and not all(energy.overlaps(energies[0]) for energy in energies):
            raise Refused("the energy is not constant")

    def _compare(self, start: list[arb]) -> None:
        """Compare the accelerations of the log's formulas with those of `Mechanics`, at the start and elsewhere."""
        dice, lines = random.Random(repr(self.formulas.lines)), self.formulas.lines
        turns = [[lines[p] for p in own[4:8]] for own in self.formulas.outputs]
        for point in range(POINTS + 1):
            y = [x + arb(dice.randrange(-1000, 1000)) / 3333 * int(point > 0) for x in start]
            if self.free is not None:
                self.mechanics.s = y[self.free] = arb(dice.randrange(-1000, 1000)) / 3333
            for four in turns:  # Euler parameters that are part of y
                if all(operation == "y" for operation, *_ in four):
                    size = sum((y[k] * y[k] for _, k, _ in four), arb(0)).sqrt()
                    for _, k, _ in four:
                        y[k] = y[k] / size
            chance = arb(dice.randrange(1000)) / 333  # s: the formulas have no time, so that any must do
            self.mechanics.now = chance if self.clock is None else y[self.clock] * exact(self.units[1])
            self._compare_at(y)

    def _compare_at(self, y: list[arb]) -> None:
        time = exact(self.units[1])
        f = self.formulas.run(self.formulas.f, [*y, *root(self.formulas, y)])
        with precision(POINT_BITS, 3):
            outputs = self.bodies([arb_series([x, rate / time]) for x, rate in zip(y, f, strict=True)])
            moving, (states, rates) = self.states(outputs), self.states(self.bodies(y))
            bends = [[terms(x, 2)[1] for x in own] for own in moving[1]]
            missing = self.mechanics.missing(states, rates, bends)
            rows = zip(self.scene.bodies, outputs, moving[0], states, rates, strict=True)
            for body, own, (place, turn, angle), state, rate in rows:
                right_place, right_turn, right_angle = self.mechanics.jet(state, rate)
                pairs = [*zip([*place, *chain(*turn)], [*right_place, *chain(*right_turn)], strict=True)]
                pairs += [(sum(x * x for x in own[4:8]), arb(0))]
                pairs += [(angle, right_angle)] if body.type == "planar" else []
                missing += [terms(a, 2)[1] - terms(b, 2)[1] for a, b in pairs]
            most = max(above(x) for own in (*rates, *bends) for x in own)
            if not all(above(x) <= EQUAL * (1.0 + most) for x in missing):
                raise Refused("the formulas do not move the bodies as the scene does")


def _rates(body: Any) -> list[float]:
    spin = getattr(body, "angular_velocity", 0.0)
    return [*(*body.velocity, 0.0)[:3], *(spin if isinstance(spin, tuple) else (0.0, 0.0, spin))]


def newton(formulas: Formulas, y: Sequence[Number], z: Sequence[Number], wide: Sequence[Number]) -> list[arb]:
    """Return the change of z by Newton's method, with the slopes of g on balls that may be wider than z."""
    right = formulas.run(formulas.g, [*y, *z])
    rows = matrix_of(formulas.slopes(formulas.g, [*y, *wide]), len(y) + len(z))
    return solve(arb_mat([row[formulas.n :] for row in rows]), arb_mat(formulas.m, 1, [-x for x in right])).entries()


def matrix_of(rows: list[dict[int, arb]], columns: int) -> list[list[arb]]:
    """Return derivatives by column as a matrix."""
    return [[row.get(k, arb(0)) for k in range(columns)] for row in rows]


def root(formulas: Formulas, y: list[arb]) -> list[arb]:
    """Return z with g(y, z) = 0 by Newton's method from 1."""
    z = [arb(1)] * formulas.m
    for _ in range(ITERATIONS if z else 0):
        change = newton(formulas, y, z, z)
        z = [(x + d).mid() for x, d in zip(z, change, strict=True)]
        if max(map(above, change)) < NEGLIGIBLE:
            break
    return z


def solve(matrix: arb_mat, right: arb_mat) -> arb_mat:
    """Return the solution of a linear system; Refused where it may be singular."""
    try:
        return matrix.solve(right)
    except ZeroDivisionError as error:
        raise Refused("accelerations or multipliers are not unique: a matrix is singular") from error
