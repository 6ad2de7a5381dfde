"""A log's formulas beside the scene: start values, and equality with the absolute coordinates."""

import random
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import chain
from typing import Any

import numpy as np
from flint import arb, arb_mat, arb_series  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.formulas import Formulas, Number, Refused, above, exact, precision, terms
from cross_checks.truths.proofs.checker.mechanics import EQUAL, STILL, Mechanics, dot, minus, rotation
from cross_checks.truths.proofs.coverage import DRIVES, PAIRS
from cross_checks.truths.proofs.family import family
from mbs_ref import Scene

POINTS, POINT_BITS = 3, 1000  # random points, bits of numbers
ITERATIONS, NEGLIGIBLE = 60, 2.0**-800  # of Newton's method for z, from 1; of a change of z, where it ends
STATE = 14  # numbers of a body's state
ONE, ZERO = ("c", 1, 1), ("c", 0, 1)  # lines
START_GAP = 1e-7  # of a rate, 1: how far a scene's dependent rates may be from its closures


class Model:
    """A scene, the formulas that a log states for it, and the start of y and z. Refused where they do not fit."""

    def __init__(self, header: dict[str, Any], compares: bool) -> None:
        self.scene: Any = Scene.model_validate(header["scene"])
        if "ends" in header:
            self.scene = family(self.scene, *map(Scene.model_validate, header["ends"]))
            for end in header["ends"]:
                Mechanics(Scene.model_validate(end), header["inputs"])
        system, self.formulas = header["system"], Formulas(header["system"])
        self.contacts = system["contacts"]  # of each: clearance, its rate, columns of y with lines after an impact
        self.units, self.clock, self.free = [Fraction(x) for x in system["units"]], system["clock"], system["free"]
        if min(self.units) <= 0 or [len(own) for own in self.formulas.outputs] != [STATE] * len(self.scene.bodies):
            raise Refused("a unit is not positive, or the outputs are not the states of the bodies")
        if (self.free is None) == ("ends" in header):
            raise Refused("the formulas have no parameter that varies, or one that the scene has not")
        columns = {column for *_, changes in self.contacts for column, _ in changes}
        if len(self.contacts) != len(self.scene.contacts) or columns & {self.clock, self.free}:
            raise Refused("the impacts are not those of the contacts")
        self.mechanics = Mechanics(self.scene, header["inputs"])
        lines, self.starts = self.formulas.lines, system["starts"]
        for own, rate in ((self.clock, ONE), (self.free, ZERO)):
            if own is not None and (lines[self.starts[own]] != ZERO or lines[self.formulas.f[own]] != rate):
                raise Refused(f"coordinate {own} is not time, or is no parameter")
        with precision(POINT_BITS):
            self.start = self._start()
            if compares:
                self._compare(self.start)
            self.z_start = root(self.formulas, self.start)
            self.moved, self.box = np.eye(self.formulas.n), np.zeros(self.formulas.n)
            if "ends" in header:
                self._vary_start(self.free)

    def _vary_start(self, free: int) -> None:
        """Enclose the start of a family: for every parameter in [-1, 1], it is in `start` + `moved` x, |x| <= `box`."""
        for s in (arb(-1), arb(1), arb(random.Random(0).randrange(1000)) / 3333):
            self.mechanics.s = s
            self._start()
        self.mechanics.s = arb(0, 1)
        whole = self._solved_start()
        slopes = self.formulas.slopes([place for place in self.starts if place is not None], whole)
        for k, place in enumerate(self.starts):
            if place is None:
                self.start[k] = whole[k]
            else:
                own = slopes.pop(0).get(free, arb(0))
                self.moved[k, free] = float(own.mid())
                self.start[k] += (own - self.moved[k, free]) * arb(0, 1)
        self.moved[free, free] = self.box[free] = 1.0

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

    def after(self, contact: int, y: Sequence[Number]) -> list[Number]:
        """Return y after an impact."""
        changed = {column: self.formulas.run([place], y)[0] for column, place in self.contacts[contact][2]}
        return [changed.get(k, x) for k, x in enumerate(y)]

    def states(self, bodies: list[list[Any]]) -> tuple[list[Any], list[list[Any]]]:
        """Return place, turn and angle, and the six rates, of every body as `Mechanics` takes them."""
        return [(own[:3], rotation(own[4:8]), own[3]) for own in bodies], [own[8:] for own in bodies]

    def _closures(self, y: list[arb]) -> list[arb]:
        """Return the rates of all closures."""
        jets = self.mechanics.jets(*self.states(self.bodies(y)))
        return [row[1] for joint in self.scene.joints for row in self.mechanics.closure(jets, joint)]

    def _start(self) -> list[arb]:
        """Return the start of y at one parameter; each value given, and all outputs, must be the scene's."""
        ball, (length, time, _), bodies = self.mechanics.ball, map(exact, self.units), self.scene.bodies
        rates = [*{(x, getattr(x, "ends", ())): ball(x) for body in bodies for x in _rates(body)}.values(), arb(0)]
        allowed = [(a - b) * unit for a in rates for b in rates for unit in (time, time / length)]
        allowed += [ball(x) / length for body in bodies for x in body.position] + [arb(1)]
        along = [(turn * time, slide * time / length) for turn, slide in self._along_axes()]
        allowed += [sign * x for both in along for x in both for sign in (1, -1)]
        y = self._solved_start()
        for k, place in enumerate(self.starts):
            if place is not None and k != self.free and min(above(y[k] - right) for right in allowed) > EQUAL:
                raise Refused("a start value is no number of the scene")
        self._same_start(y)
        if any(above(row) > EQUAL for row in self._closures(y)):
            raise Refused("the start rates do not fulfil the closures")
        return y

    def _along_axes(self) -> Iterator[tuple[Number, Number]]:
        """Yield the scene's rates along each joint's axis: of a turn (rad/s) and of a slide (m/s)."""
        own, bodies = self.mechanics, self.scene.bodies
        rates = [[own.ball(x) for x in _rates(body)] for body in bodies]
        still = rotation([arb(1), arb(0), arb(0), arb(0)]), arb(0)
        jets = own.jets([(own.vector(body.position), *still) for body in bodies], rates)
        for joint in (joint for joint in self.scene.joints if getattr(joint, "axis", None)):
            axis, (a, b) = own.vector(joint.axis), ([*rates, STILL][own.index[name]] for name in joint.ends)
            gap, size = [terms(x, 2)[1] for x in own.gap(jets, joint)], dot(axis, axis).sqrt()
            yield dot(axis, minus(b[3:], a[3:])) / size, dot(axis, gap) / size

    def _solved_start(self) -> list[arb]:
        """Return the start of y at the parameter of now; closures decide what is not given."""
        y = [self.mechanics.s if k == self.free else arb(0) for k in range(self.formulas.n)]
        for k, place in enumerate(self.starts):
            if place is not None and k != self.free:
                (y[k],) = self.formulas.run([place], y)
        if unknown := [k for k, place in enumerate(self.starts) if place is None]:
            base = self._closures(y)
            columns = [self._closures([arb(j == k) if j in unknown else x for j, x in enumerate(y)]) for k in unknown]
            matrix = [[c - b for c in row] for b, *row in zip(base, *columns, strict=True)]
            rows = [r for r, row in enumerate(matrix) if max(float(x.abs_lower()) for x in row) > EQUAL]
            if len(rows) != len(unknown):
                raise Refused(f"{len(rows)} closures do not decide {len(unknown)} start rates")
            solved = solve(arb_mat([matrix[r] for r in rows]), arb_mat([[-base[r]] for r in rows]))
            for k, value in zip(unknown, solved.entries(), strict=True):
                y[k] = value
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
            missing = [*self.mechanics.missing(states, rates, bends), *self._impacts(y)]
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

    def _impacts(self, y: list[arb]) -> list[arb]:
        """Return what is 0 where the contacts' clearances, their rates, and the states after impacts are right."""
        (length, time, _), missing = map(exact, self.units), []
        before, (states, rates) = self.bodies(y), self.states(self.bodies(y))
        for k, (part, (place, rate, _)) in enumerate(zip(self.scene.contacts, self.contacts, strict=True)):
            later = self.bodies(self.after(k, y))
            value, change = (x * length ** (1 + (part.type in PAIRS)) for x in self.formulas.run([place, rate], y))
            right = self.mechanics.clearance(self.mechanics.jets(states, rates), part)
            missing += [value - right[0], change / time - right[1]]
            missing += self.mechanics.struck(part, states, rates, self.states(later)[1])
            missing += [
                x - y for old, new in zip(before, later, strict=True) for x, y in zip(old[:8], new[:8], strict=True)
            ]
        return missing


def _rates(body: Any) -> list[float]:
    spin = getattr(body, "angular_velocity", 0.0)
    return [*(*body.velocity, 0.0)[:3], *(spin if isinstance(spin, tuple) else (0.0, 0.0, spin))]


def newton(formulas: Formulas, y: Sequence[Number], z: Sequence[Number], wide: Sequence[Number]) -> list[arb]:
    """Return Newton's correction of z; the slopes of g are those on balls, which may be wider than z."""
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
