"""The checker of proofs: a log has hints only, and what this file computes from them is the theorem.

1. The formulas of the log are compared at random points, with 300 digits, with the accelerations that `mechanics`
   derives from the scene in absolute coordinates with multipliers. Analytic functions that agree at random points are
   equal with probability 1.
2. Start values are the scene's numbers; rates that loops decide solve the closures.
3. For every step with polynomial p, y = p + V B x and z = p + W B x + w. Bounds of |x| and |w| are a box that
   V B x' = -(p' - f(p)) - R B x + f_z w + o2, g_z w = -(g(p) + S B x + o2) maps into itself, where R and S are the
   defects of the variational equations and o2 is the second order on the box. All are bounded on the whole step:
   series coefficients in ball arithmetic, their tails by Cauchy's estimate on a complex disc.

Floats: GAMMA bounds the rounding of a product of matrices with up to 9000 terms a sum; `up` exceeds a sum of
non-negative terms. The step is the unit of time within itself.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from math import comb
from typing import Any

import numpy as np
from flint import acb, arb, arb_mat, arb_series, ctx  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.proofs.mechanics import Mechanics, Number, exact, rotation
from mbs_ref.scene import Scene

OPERATIONS = ("c", "root", "y", "z", "+", "-", "*", "sin", "cos")
GAMMA = 1e-12  # of |A| |B|: 9000 roundings of 2^-53
ORDER = 20  # terms of V, W and the Jacobian: their defect is about 6^-ORDER
CONDITION = 1e6  # of the basis, above which it becomes orthogonal
POINTS, POINT_BITS, EQUAL = 3, 1000, 600  # random points, bits of numbers, bits that must agree
START_GAP = 1e-7  # of a rate, 1: how far a scene's dependent rates may be from its closures
TURNS = {"point_mass": 0, "planar": 1, "spatial": 4}  # numbers of a body's turn: none, angle, Euler parameters
DISCS = (1.5, 2.0, 3.0, 4.0, 5.0, 6.5)  # radii of discs in steps; the best one counts


class Refused(ValueError):
    """The log does not prove what it states; the message says why."""


@contextmanager
def precision(bits: int, terms: int = 10) -> Iterator[None]:
    """Set the precision of balls and the length of series, and restore both."""
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = bits, terms
    try:
        yield
    finally:
        ctx.prec, ctx.cap = before


def up(x: Any) -> Any:
    """Return a float above a sum of non-negative floats that was rounded."""
    return np.asarray(x) * (1.0 + 1e-9) + 1e-290


def above(x: Any) -> float:
    """Return a float above |x| of a ball."""
    return float(up(float(x.abs_upper()))) if x.is_finite() else np.inf


class Formulas:
    """The log's lines with their derivatives by y and z."""

    def __init__(self, system: dict[str, Any]) -> None:
        self.lines = [tuple(line) for line in system["lines"]]
        self.places = {line: k for k, line in enumerate(self.lines)}
        self.f, self.g, self.outputs = system["f"], system["g"], system["outputs"]
        self.n, self.m = len(self.f), system["z"]
        ends = {"y": self.n, "z": self.m}
        for k, (operation, a, b) in enumerate(self.lines):
            if operation not in OPERATIONS or not all(0 <= p < k for p in _operands((operation, a, b))):
                raise Refused(f"line {k} of the formulas is none")
            if operation in ends and not 0 <= a < ends[operation]:
                raise Refused(f"line {k} of the formulas has an unknown coordinate")
        places = [*self.f, *self.g, *(place for own in self.outputs for place in own)]
        if len(self.g) != self.m or not all(0 <= place < len(self.lines) for place in places):
            raise Refused("the formulas do not state one equation for every z")
        self.slopes: dict[int, dict[int, int]] = {}
        self.jacobian = [self._slopes(place) for place in (*self.f, *self.g)]

    def _line(self, operation: str, a: int, b: int = 0) -> int:
        key = (operation, a, b)
        if key not in self.places:
            self.places[key] = len(self.lines)
            self.lines.append(key)
        return self.places[key]

    def _times(self, a: int, b: int) -> int:
        one = ("c", 1, 1)
        return b if self.lines[a] == one else a if self.lines[b] == one else self._line("*", a, b)

    def _slopes(self, root: int) -> dict[int, int]:
        """Return the lines of a line's derivatives, by column: y first, then z."""
        for place in range(max(self.slopes, default=-1) + 1, root + 1):
            self.slopes[place] = self._slope(place)
        return self.slopes[root]

    def _slope(self, place: int) -> dict[int, int]:
        operation, a, b = self.lines[place]
        if operation in ("c", "root"):
            return {}
        if operation in "yz":
            return {a + (self.n if operation == "z" else 0): self._line("c", 1, 1)}
        if operation in ("sin", "cos"):
            factor = (
                self._line("cos", a)
                if operation == "sin"
                else self._times(self._line("c", -1, 1), self._line("sin", a))
            )
            return {k: self._times(factor, d) for k, d in self.slopes[a].items()}
        first, second = dict(self.slopes[a]), self.slopes[b]
        if operation == "*":
            first = {k: self._times(b, d) for k, d in first.items()}
            second = {k: self._times(a, d) for k, d in second.items()}
        sign = self._line("c", -1, 1)
        for k, d in second.items():
            d = self._times(sign, d) if operation == "-" else d
            first[k] = self._line("+", first[k], d) if k in first else d
        return first

    def plan(self, roots: Sequence[int]) -> list[int]:
        """Return the lines that some lines need, in order."""
        needed, stack = set(), list(roots)
        while stack:
            place = stack.pop()
            if place not in needed:
                needed.add(place)
                stack += _operands(self.lines[place])
        return sorted(needed)

    def run(self, plan: Sequence[int], y: Sequence[Number], z: Sequence[Number]) -> dict[int, Number]:
        """Return the values of the lines of a plan."""
        value: dict[int, Number] = {}
        for place in plan:
            operation, a, b = self.lines[place]
            if operation == "*":
                value[place] = value[a] * value[b]
            elif operation == "+":
                value[place] = value[a] + value[b]
            elif operation == "-":
                value[place] = value[a] - value[b]
            elif operation == "c":
                value[place] = exact(Fraction(a, b))
            elif operation == "root":
                value[place] = exact(Fraction(a, b)).sqrt()
            elif operation in "yz":
                value[place] = (y if operation == "y" else z)[a]
            else:
                value[place] = value[a].sin() if operation == "sin" else value[a].cos()
        return value


def _operands(line: tuple[str, int, int]) -> tuple[int, ...]:
    operation, a, b = line
    return (a, b) if operation in "+-*" else (a,) if operation in ("sin", "cos") else ()


class Proof:
    """What the checker knows of one log: the formulas, the start, and the enclosure at the end of the last step."""

    def __init__(self, header: dict[str, Any]) -> None:
        self.scene: Any = Scene.model_validate(header["scene"])
        self.bits = int(header["bits"])
        self.units = [Fraction(x) for x in header["system"]["units"]]
        self.formulas = Formulas(header["system"])
        self.mechanics = Mechanics(self.scene, header["inputs"])
        self.t = Fraction(0)
        self.times = [self.mechanics.number(t) / self.units[1] for t in header["times"]]
        if sorted(set(self.times)) != self.times or self.times[:1] < [Fraction(0)] or min(self.units) <= 0:
            raise Refused("the times do not increase from 0")
        self.enclosures: list[list[list[arb]]] = []  # at the times reached: place, turn, velocity and spin of bodies
        self.plans = {
            "motion": self.formulas.plan([*self.formulas.f, *self.formulas.g]),
            "jacobian": self.formulas.plan([p for row in self.formulas.jacobian for p in row.values()]),
            "outputs": self.formulas.plan([p for one in self.formulas.outputs for p in one]),
        }
        with precision(POINT_BITS):
            start = self._start(header["system"]["starts"])
            self._compare(start)
        with precision(self.bits + 64):
            self.middle = [x.mid() * 1 for x in start]
        self.moved, self.moved_error = np.eye(self.formulas.n), np.zeros((self.formulas.n, self.formulas.n))
        self.box = up([above(x - m) for x, m in zip(start, self.middle, strict=True)])

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
            solved = _solve(arb_mat([matrix[r] for r in rows]), arb_mat([[-base[r]] for r in rows]))
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
        dice, parameters = random.Random(len(self.formulas.lines)), self._euler_parameters()
        for point in range(POINTS + 1):
            y = [x + arb(dice.randrange(-1000, 1000)) / 3333 * int(point > 0) for x in start]
            for four in parameters:
                size = sum((y[k] * y[k] for k in four), arb(0)).sqrt()
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
        value = formulas.run(self.plans["motion"], y, _roots(formulas, y))
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

    def step(self, h: Fraction, rows: list[list[int]]) -> None:
        """Prove that the motion stays beside a polynomial for a time h; Refused where the bounds do not close."""
        try:
            self._step(h, rows)
        except (ZeroDivisionError, np.linalg.LinAlgError, FloatingPointError) as error:
            raise Refused(f"a bound is infinite: {error}") from error

    def _step(self, h: Fraction, rows: list[list[int]]) -> None:
        n, m = self.formulas.n, self.formulas.m
        if len(rows) != n + m or not h > 0 or len({len(row) for row in rows}) != 1 or len(rows[0]) <= ORDER:
            raise Refused("a step has no polynomial for every coordinate")
        with precision(self.bits + 64):
            p = [[arb((int(c), -self.bits)) for c in row] for row in rows]
            basis, x0 = self._new_basis([p[i][0] for i in range(n)])
            size = np.array([[above(c) for c in row] for row in p])
        defect, disc = self._defects(h, p, size)
        jacobian, error = self._jacobian(float(h), p, disc)
        flow = _variations(jacobian, n)
        flow_size, r = _variation_defects(jacobian, error, flow, n)
        inverse = _inverse_bound(jacobian[:, n:, n:], error[n:, n:])
        back = up(np.abs(_inverse_bound(flow[:, :n], np.zeros((n, n)))))
        back = up(_inverse_bound(basis[None], np.zeros((n, n))) @ back)
        f_z = up(np.abs(jacobian[:, :n, n:]).sum(0) + error[:n, n:])
        b = np.abs(basis)
        box, w = up(x0 * 1.01), np.zeros(m)
        for _ in range(12):
            e = up(flow_size @ up(b @ box))
            e[n:] = up(e[n:] + w)
            second = self._second_order(h, p, size, e)
            new_w = up(inverse @ up(up(r[n:] @ up(b @ box)) + defect[n:] + second[n:]))
            rate = up(up(r[:n] @ up(b @ box)) + defect[:n] + up(f_z @ new_w) + second[:n])
            new_box = up(x0 + up(back @ rate))
            if (new_box <= box).all() and (new_w <= w).all():
                break
            box, w = np.maximum(box, new_box * 1.1), np.maximum(w, new_w * 1.1)
        else:
            raise Refused("the box does not map into itself")
        if not np.isfinite(new_box).all():
            raise Refused("the box is infinite")
        self._record(h, p, flow[:, :n], basis, new_box)
        end = flow[:, :n].sum(0)
        self.moved = end @ basis
        self.moved_error = up(GAMMA * up(flow_size[:n] @ b))
        with precision(self.bits + 64):
            self.middle = [sum(row, arb(0)) for row in p[:n]]
        self.box, self.t = new_box, self.t + h

    def _new_basis(self, start: list[arb]) -> tuple[np.ndarray, np.ndarray]:
        """Return a basis of floats near the moved one, and the box of the state in it about the polynomial's start."""
        shift = up([above(x - m) for x, m in zip(start, self.middle, strict=True)])
        basis = self.moved / np.linalg.norm(self.moved, axis=0)
        if not np.linalg.cond(basis) < CONDITION:
            order = np.argsort(-np.linalg.norm(self.moved, axis=0) * self.box)
            basis = np.linalg.qr(self.moved[:, order])[0]
        inverse = np.linalg.inv(basis)
        gap = _gap(inverse, basis)
        size = up(np.abs(inverse @ self.moved) + GAMMA * up(np.abs(inverse) @ np.abs(self.moved)))
        box = up(up(size @ self.box) + up(np.abs(inverse) @ up(shift + up(self.moved_error @ self.box))))
        return basis, up(box + gap / (1.0 - gap) * box.max())

    def _defects(self, h: Fraction, p: list[list[arb]], size: np.ndarray) -> tuple[np.ndarray, float]:
        """Return bounds of |p' - h f(p)| and |g(p)| on the step, and the radius of the best disc."""
        formulas, degree = self.formulas, len(p[0]) - 1
        roots = [*formulas.f, *formulas.g]
        with precision(self.bits + 64, degree):
            series = [arb_series(row, degree) for row in p]
            value = formulas.run(self.plans["motion"], series[: formulas.n], series[formulas.n :])
            sums = []
            for k, place in enumerate(roots):
                own = _terms(value[place], degree)
                if k < formulas.n:
                    own = [p[k][j + 1] * (j + 1) - exact(h) * own[j] for j in range(degree)]
                sums.append(up(sum(above(c) for c in own)))
        factor = np.array([float(h)] * formulas.n + [1.0] * formulas.m)
        tails = [
            (
                up(
                    self._on_disc("motion", p, size, radius, roots)
                    * factor
                    * radius ** -float(degree)
                    / (1 - 1 / radius)
                ),
                radius,
            )
            for radius in DISCS
        ]
        tail, radius = min(tails, key=lambda one: np.nan_to_num(one[0], nan=np.inf).max())
        return up(np.array(sums) + tail), radius

    def _on_disc(self, plan: str, p: list[list[arb]], size: np.ndarray, radius: float, roots: list[int]) -> np.ndarray:
        """Return bounds of lines for |t| <= radius steps."""
        reach = up(size[:, 1:] @ (radius ** np.arange(1.0, size.shape[1])))
        with precision(64):
            discs = [acb(arb(row[0].mid(), d) + 0, arb(0, d)) for row, d in zip(p, reach, strict=True)]
            value = self.formulas.run(self.plans[plan], discs[: self.formulas.n], discs[self.formulas.n :])
            return np.array([above(value[place]) for place in roots])

    def _jacobian(self, h: float, p: list[list[arb]], radius: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the series of the Jacobian, rows of f times h, and bounds of its error on the step."""
        formulas, total = self.formulas, self.formulas.n + self.formulas.m
        entries = [(i, j, place) for i, row in enumerate(formulas.jacobian) for j, place in row.items()]
        jacobian, error = np.zeros((ORDER, total, total)), np.zeros((total, total))
        with precision(64, ORDER):
            series = [arb_series(row[:ORDER], ORDER) for row in p]
            value = formulas.run(self.plans["jacobian"], series[: formulas.n], series[formulas.n :])
            for i, j, place in entries:
                terms = _terms(value[place], ORDER)
                jacobian[:, i, j] = [float(c.mid()) for c in terms]
                error[i, j] = sum(float(c.rad()) for c in terms)
        size = np.array([[above(c) for c in row] for row in p])
        bound = self._on_disc("jacobian", p, size, radius, [place for *_, place in entries])
        for (i, j, _), most in zip(entries, bound, strict=True):
            error[i, j] += most * radius ** -float(ORDER) / (1.0 - 1.0 / radius)
        error = up(error + GAMMA * np.abs(jacobian).sum(0))
        jacobian[:, : formulas.n] *= h
        error[: formulas.n] *= h
        return jacobian, up(error)

    def _second_order(self, h: Fraction, p: list[list[arb]], size: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Return bounds of the second-order terms of f (times h) and g for deviations |e|."""
        reach = up(size[:, 1:].sum(1) + e)
        formulas = self.formulas
        with precision(64, 3):
            boxes = [
                arb_series([arb(row[0].mid(), d), arb(0, float(s))], 3) for row, d, s in zip(p, reach, e, strict=True)
            ]
            value = formulas.run(self.plans["motion"], boxes[: formulas.n], boxes[formulas.n :])
            terms = np.array([above(_terms(value[place], 3)[2]) for place in (*formulas.f, *formulas.g)])
        terms[: formulas.n] *= float(h)
        return up(terms)

    def _record(self, h: Fraction, p: list[list[arb]], flow: np.ndarray, basis: np.ndarray, box: np.ndarray) -> None:
        """Append the enclosures of all bodies at the output times of the step."""
        n = self.formulas.n
        with precision(self.bits + 64):
            while len(self.enclosures) < len(self.times) and self.times[len(self.enclosures)] <= self.t + h:
                s = (self.times[len(self.enclosures)] - self.t) / h
                powers = float(s) ** np.arange(ORDER)
                here = np.tensordot(powers, flow, 1) @ basis
                spread = up(up(np.abs(here) + GAMMA * up(np.abs(flow).sum(0) @ np.abs(basis))) @ box)
                at = exact(s)
                y = []
                for row, wide in zip(p[:n], spread, strict=True):
                    value = arb(0)
                    for c in reversed(row):
                        value = value * at + c
                    y.append(value + arb(0, float(wide)))
                self.enclosures.append(self.bodies(y))

    @property
    def radius(self) -> float:
        """The largest radius of a place (m), turn (rad), velocity or spin at the output times so far."""
        return max((float(x.rad()) for one in self.enclosures for own in one for x in own), default=0.0)

    def check_energy(self) -> None:
        """Refuse enclosures whose energies have no value in common, where nothing takes or gives any."""
        with precision(self.bits + 64):
            energies = [self.mechanics.energy(*self.states(bodies)) for bodies in self.enclosures]
        if self.mechanics.conserves and not all(energy.overlaps(energies[0]) for energy in energies):
            raise Refused("the energy is not constant")


def _rates(body: Any, number: Any) -> list[Fraction]:
    spin = getattr(body, "angular_velocity", ())
    return [number(x) for x in (*body.velocity, *(spin if isinstance(spin, tuple) else (spin,)))]


def _terms(value: Number, count: int) -> list[arb]:
    terms = value.coeffs() if isinstance(value, arb_series) else [value]
    return [*terms, *[arb(0)] * (count - len(terms))][:count]


def _solve(matrix: arb_mat, right: arb_mat) -> arb_mat:
    try:
        return matrix.solve(right)
    except ZeroDivisionError as error:
        raise Refused("a matrix is singular") from error


def _roots(formulas: Formulas, y: list[arb]) -> list[arb]:
    """Return z with g(y, z) = 0 by Newton's method from 1."""
    n, m = formulas.n, formulas.m
    z = [arb(1)] * m
    plan = formulas.plan([*formulas.g, *(p for row in formulas.jacobian[n:] for k, p in row.items() if k >= n)])
    for _ in range(60 if m else 0):
        value = formulas.run(plan, y, z)
        slopes = [[value[row[n + j]] if n + j in row else arb(0) for j in range(m)] for row in formulas.jacobian[n:]]
        change = _solve(arb_mat(slopes), arb_mat([[value[place]] for place in formulas.g])).entries()
        z = [(x - d).mid() for x, d in zip(z, change, strict=True)]
        if max(above(d) for d in change) < 2.0 ** (-EQUAL - 200):
            break
    return z


def _variations(jacobian: np.ndarray, n: int) -> np.ndarray:
    """Return V and W, V' = f_y V + f_z W, 0 = g_y V + g_z W, V(0) = 1, to ORDER terms."""
    flow = np.zeros((ORDER, len(jacobian[0]), n))
    flow[0, :n] = np.eye(n)
    inverse = np.linalg.inv(jacobian[0, n:, n:])
    for k in range(ORDER):
        if k:
            flow[k, :n] = sum(jacobian[j, :n] @ flow[k - 1 - j] for j in range(k)) / k
        flow[k, n:] = -inverse @ sum(jacobian[j, n:] @ flow[k - j] for j in range(k + 1))
    return flow


def _variation_defects(
    jacobian: np.ndarray, error: np.ndarray, flow: np.ndarray, n: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return bounds of |V| and |W|, and of the defects of their equations, on the step."""
    whole = np.zeros((2 * ORDER, *flow.shape[1:]))
    for j in range(ORDER):
        whole[j : j + ORDER] += jacobian[j] @ flow
    whole[: ORDER - 1, :n] -= np.arange(1, ORDER)[:, None, None] * flow[1:, :n]
    size = up(np.abs(flow).sum(0))
    rounding = up(GAMMA * up(np.abs(jacobian).sum(0) @ size) + error @ size)
    rounding[:n] = up(rounding[:n] + GAMMA * ORDER * size[:n])
    return size, up(np.abs(whole).sum(0) + rounding)


def _gap(inverse: np.ndarray, matrix: np.ndarray) -> float:
    """Return a bound of the row sums of |1 - inverse matrix|; Refused unless it is below 1."""
    gap = up(np.abs(np.eye(len(matrix)) - inverse @ matrix) + GAMMA * up(np.abs(inverse) @ np.abs(matrix)))
    most = float(up(gap.sum(1)).max(initial=0.0))
    if not most < 1.0:
        raise Refused("a matrix is singular to rounding")
    return most


def _inverse_bound(
    matrix: np.ndarray, error: np.ndarray, low: float = 0.0, high: float = 1.0, depth: int = 0
) -> np.ndarray:
    """Return a bound of |matrix(t)^-1| for low <= t <= high, the matrix a series with an error."""
    size = matrix.shape[1]
    if not size:
        return np.zeros((0, 0))
    middle, half, count = (low + high) / 2, (high - low) / 2, len(matrix)
    shift = np.array(
        [[comb(k, j) * middle ** (k - j) * half**j if k >= j else 0.0 for k in range(count)] for j in range(count)]
    )
    moved = np.tensordot(shift, matrix, 1)
    blur = up(error + GAMMA * up(np.abs(matrix).sum(0)))
    inverse = np.linalg.inv(moved[0])
    rest = up(np.abs(inverse @ moved[1:]).sum(0) + GAMMA * up(np.abs(inverse) @ np.abs(moved).sum(0)))
    rest = up(rest + up(np.abs(inverse) @ blur) + np.abs(np.eye(size) - inverse @ moved[0]))
    most = float(up(rest.sum(1)).max())
    if most < 0.5:
        first = up(rest @ np.abs(inverse))
        return up(np.abs(inverse) + first + most / (1.0 - most) * first.max(0))
    if depth > 6:
        raise Refused("a matrix is singular within the step")
    return np.maximum(
        _inverse_bound(matrix, error, low, middle, depth + 1), _inverse_bound(matrix, error, middle, high, depth + 1)
    )


@dataclass(frozen=True)
class Checked:
    """What a log proves."""

    proven_to: float  # s
    radius: float  # m, rad, m/s and rad/s, the largest at the output times
    steps: int
    energy: bool  # whether the enclosures of the energy share a value, too; False where it is not constant


def check(log: dict[str, Any]) -> tuple[Checked, list[list[list[arb]]]]:
    """Return what a log proves and the enclosures at its times. Refused where it is not a proof of what it states."""
    try:
        proof = Proof(log)
        for numerator, denominator, rows in log["steps"]:
            proof.step(Fraction(numerator, denominator), rows)
        claimed = float(log["radius"]), len(log["times"])
    except (KeyError, TypeError, IndexError, ValueError, OverflowError) as error:
        raise Refused(str(error) or type(error).__name__) from error
    if len(proof.enclosures) < claimed[1]:
        raise Refused(f"the steps end at {float(proof.t * proof.units[1]):g} s, before the last output time")
    if not proof.radius <= claimed[0]:
        raise Refused(f"the radius is {proof.radius:.2g}, above the stated {claimed[0]:.2g}")
    proof.check_energy()
    end = float(proof.t * proof.units[1])
    return Checked(end, proof.radius, len(log["steps"]), proof.mechanics.conserves), proof.enclosures
