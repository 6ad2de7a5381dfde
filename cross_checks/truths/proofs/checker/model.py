"""A log's formulas beside the scene: start values, and equality with the absolute coordinates."""

import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from flint import arb, arb_mat, arb_series  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import Number, Refused, above, exact, precision
from cross_checks.truths.proofs.checker.coverage import DRIVES
from cross_checks.truths.proofs.checker.formulas import Formulas, roots, solve
from cross_checks.truths.proofs.checker.mechanics import Mechanics, rotation
from cross_checks.truths.proofs.family import Varied, family
from mbs_ref.scene import Scene

POINTS, POINT_BITS, EQUAL = 3, 1000, 600  # random points, bits of numbers, bits that must agree
START_GAP = 1e-7  # of a rate, 1: how far a scene's dependent rates may be from its closures
TURNS = {"point_mass": 0, "planar": 1, "spatial": 4}  # numbers of a body's turn: none, angle, Euler parameters


class Model:
    """A scene, the formulas that a log states for it, and the start of y and z. Refused where they do not fit."""

    def __init__(self, header: dict[str, Any]) -> None:
        self.scene: Any = Scene.model_validate(header["scene"])
        if "ends" in header:
            self.scene = family(self.scene, *map(Scene.model_validate, header["ends"]))
        self.units = [Fraction(x) for x in header["system"]["units"]]
        if min(self.units) <= 0:
            raise Refused("a unit is not positive")
        self.formulas = Formulas(header["system"])
        self.mechanics = Mechanics(self.scene, header["inputs"])
        self.clock = header["system"]["clock"]
        self._refuse_without_time(header["system"]["starts"])
        self.plans = {
            "motion": self.formulas.plan([*self.formulas.f, *self.formulas.g]),
            "jacobian": self.formulas.plan([p for row in self.formulas.jacobian for p in row.values()]),
            "outputs": self.formulas.plan([p for one in self.formulas.outputs for p in one]),
        }
        self.free = header["system"]["free"]
        with precision(POINT_BITS):
            self.start = self._start(header["system"]["starts"])
            if "ends" in header:
                self._vary_start(header["system"]["starts"])
            self._compare(self.start)
            self.z_start = roots(self.formulas, self.start)
            if self.free is not None:
                self.start[self.free] = arb(0, 1)

    def _vary_start(self, starts: list[Any]) -> None:
        """Refuse a family whose start values vary, or whose parameter does."""
        lines, f = self.formulas.lines, self.formulas.f
        varied = any(isinstance(x, Varied) for body in self.scene.bodies for x in _rates(body, lambda x: x))
        if self.free is None or varied or None in starts or lines[f[self.free]] != ("c", 0, 1):
            raise Refused("the start rates vary with the parameter, which is not covered")
        for s in (-1, 1):
            self.mechanics.s, y = Fraction(s), [arb(s) if k == self.free else x for k, x in enumerate(self.start)]
            for body, own in zip(self.scene.bodies, self.bodies(y), strict=True):
                self._same_start(body, own)

    def _refuse_without_time(self, starts: list[Any]) -> None:
        signals = (signal for part in (*self.scene.joints, *self.scene.loads) for signal in part.signals)
        if self.clock is None:
            if any(signal.type != "constant" for signal in signals):
                raise Refused("no coordinate is time, on which the scene depends")
        elif Fraction(*starts[self.clock]) or self.formulas.lines[self.formulas.f[self.clock]] != ("c", 1, 1):
            raise Refused(f"coordinate {self.clock} is not time")

    @property
    def is_exhibited(self) -> bool:
        """Whether the formulas exhibit a motion of a scene with loops without their multipliers.

        It obeys the equations of motion, but in singular poses of the loops others may branch off.
        """
        joints, lines = [j for j in self.scene.joints if j.type not in DRIVES], self.formulas.lines
        return len(joints) > len(self.scene.bodies) and self.formulas.m == sum(
            lines[place][0] == "z" for place in self.formulas.f
        )

    def bodies(self, y: Sequence[Number]) -> list[list[Number]]:
        """Return place, turn since t = 0, velocity and spin of every body, SI units."""
        value, (length, time, _) = self.formulas.run(self.plans["outputs"], y, []), map(exact, self.units)
        result = []
        for body, own in zip(self.scene.bodies, self.formulas.outputs, strict=True):
            n, turns = len(body.position), TURNS[body.type]
            units = [length] * n + [arb(1)] * turns + [length / time] * n + [1 / time] * min(turns, 3)
            result.append([value[place] * unit for place, unit in zip(own, units, strict=True)])
        return result

    def states(self, bodies: list[list[arb]]) -> tuple[list[Any], list[list[arb]]]:
        """Return place, turn and angle, and the six rates, of every body as `Mechanics` takes them."""
        states, rates, zero = [], [], arb(0)
        for body, value in zip(self.scene.bodies, bodies, strict=True):
            n, turns = len(body.position), TURNS[body.type]
            turn, velocity, spin = value[n : n + turns], value[n + turns : 2 * n + turns], value[2 * n + turns :]
            angle = turn[0] if turns == 1 else zero
            e = turn if turns == 4 else [(angle / 2).cos(), zero, zero, (angle / 2).sin()]
            states.append(((value[:n] + [zero] * 3)[:3], rotation(e), angle))
            rates.append((velocity + [zero] * 3)[:3] + (spin if turns == 4 else [zero, zero, *spin, zero][:3]))
        return states, rates

    def _start(self, given: list[Any]) -> list[arb]:
        """Return the start of y; closures decide what is not given. The outputs must be the scene's start."""
        unknown = [k for k, value in enumerate(given) if value is None]
        length, time, _ = self.units
        rates = {x for body in self.scene.bodies for x in _rates(body, self.mechanics.number)} | {Fraction(0)}
        places = {self.mechanics.number(x) / length for body in self.scene.bodies for x in body.position}
        allowed = (
            {(a - b) * unit for a in rates for b in rates for unit in (time, time / length)} | places | {Fraction(1)}
        )
        if any(value is not None and Fraction(*value) not in allowed for value in given):
            raise Refused("a start value is no number of the scene")
        y = [arb(0) if value is None else exact(Fraction(*value)) for value in given]

        def closures(values: list[arb]) -> list[arb]:
            state, rate = self.states(self.bodies(values))
            jets = self.mechanics.jets(state, rate, [[arb(0)] * 6] * len(rate))
            return [row[1] for joint in self.scene.joints for row in self.mechanics.closure(jets, joint)]

        if unknown:
            base = closures(y)
            columns = [closures([arb(j == k) if j in unknown else y[j] for j in range(len(y))]) for k in unknown]
            matrix = [[c[r] - base[r] for c in columns] for r in range(len(base))]
            rows = [r for r, row in enumerate(matrix) if any(above(x) > 2.0**-EQUAL for x in row)]
            if len(rows) != len(unknown):
                raise Refused(f"{len(rows)} closures do not decide {len(unknown)} start rates")
            solved = solve(arb_mat([matrix[r] for r in rows]), arb_mat([[-base[r]] for r in rows]))
            for k, value in zip(unknown, solved.entries(), strict=True):
                y[k] = value
        for body, own in zip(self.scene.bodies, self.bodies(y), strict=True):
            self._same_start(body, own)
        if any(above(row) > 2.0**-EQUAL for row in closures(y)):
            raise Refused("the start rates do not fulfil the closures")
        return y

    def _same_start(self, body: Any, own: list[arb]) -> None:
        n, number = len(body.position), self.mechanics.number
        turn = [[], [0.0], [], [], [1.0, 0.0, 0.0, 0.0]][TURNS[body.type]]
        for x, wanted in zip(own, [*body.position, *turn], strict=False):
            if above(x - exact(number(wanted))) > 2.0**-EQUAL:
                raise Refused(f"{body.name} does not start where the scene has it")
        for x, wanted in zip(own[n + len(turn) :], _rates(body, number), strict=True):
            if above(x - exact(wanted)) > START_GAP * (1.0 + abs(float(wanted))):
                raise Refused(f"{body.name} does not start with the scene's rates")

    def _compare(self, start: list[arb]) -> None:
        """Compare the accelerations of the log's formulas with those of `Mechanics`, at the start and elsewhere."""
        dice, parameters = random.Random(repr(self.formulas.lines)), self._euler_parameters()
        for point in range(POINTS + 1):
            y = [x + arb(dice.randrange(-1000, 1000)) / 3333 * int(point > 0) for x in start]
            if self.free is not None:
                self.mechanics.s = Fraction(dice.randrange(-1000, 1000), 3333)
                y[self.free] = exact(self.mechanics.s)
            for four in parameters:
                size = arb.sqrt(sum((y[k] * y[k] for k in four), arb(0)))
                for k in four:
                    y[k] = y[k] / size
            self._compare_at(y)

    def _euler_parameters(self) -> list[list[int]]:
        """Return the places in y of every set of Euler parameters that is part of y."""
        sets = []
        for body, own in zip(self.scene.bodies, self.formulas.outputs, strict=True):
            four = [self.formulas.lines[place] for place in own[3:7]] if body.type == "spatial" else []
            if four and all(line[0] == "y" for line in four):
                sets.append([line[1] for line in four])
        return sets

    def _compare_at(self, y: list[arb]) -> None:
        formulas = self.formulas
        self.mechanics.now = arb(0) if self.clock is None else y[self.clock] * exact(self.units[1])
        value = formulas.run(self.plans["motion"], y, roots(formulas, y))
        rate_of = [value[place] for place in formulas.f]
        moving = [arb_series([x, v]) for x, v in zip(y, rate_of, strict=True)]
        with precision(POINT_BITS, 2):
            change = [[x[1] if isinstance(x, arb_series) else arb(0) for x in own] for own in self.bodies(moving)]
        state, rate = self.states(self.bodies(y))
        expected = self.mechanics.accelerations(state, rate)
        for k, (body, own) in enumerate(zip(self.scene.bodies, change, strict=True)):
            n, (w, turn) = len(body.position), (rate[k][3:], [])
            if TURNS[body.type] == 1:
                turn = [w[2]]
            elif TURNS[body.type] == 4:
                a, b, c, d = self.bodies(y)[k][3:7]
                double = (
                    -w[0] * b - w[1] * c - w[2] * d, w[0] * a + w[1] * d - w[2] * c,
                    w[1] * a + w[2] * b - w[0] * d, w[2] * a + w[0] * c - w[1] * b,
                )  # fmt: skip
                turn = [x / 2 for x in double]
            free = [c for c in self.mechanics.free[k] if c >= 3]
            wanted = [*rate[k][:n], *turn, *expected[k][:n], *(expected[k][c] for c in free)]
            for x, right in zip(own, wanted, strict=True):
                if not above(x / exact(self.units[1]) - right) <= 2.0**-EQUAL * (1.0 + above(right)):
                    raise Refused(f"the formulas do not move {body.name} as the scene does")


def _rates(body: Any, number: Any) -> list[Fraction]:
    spin = getattr(body, "angular_velocity", ())
    return [number(x) for x in (*body.velocity, *(spin if isinstance(spin, tuple) else (spin,)))]
