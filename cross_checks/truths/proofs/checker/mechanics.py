"""The motion of a scene in absolute coordinates with multipliers, as the checker derives it, in SI units.

Every derivative is a coefficient of a series in time: closures, energies and stretches are evaluated on motions.
"""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from flint import arb, arb_mat, arb_series  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.balls import Number, Refused, exact
from cross_checks.truths.proofs.checker.coverage import DRIVES, ENERGETIC, complaints
from cross_checks.truths.proofs.checker.formulas import solve
from cross_checks.truths.proofs.family import Varied
from mbs_ref.scene import GROUND


class Mechanics:
    """A scene in absolute coordinates."""

    def __init__(self, scene: Any, inputs: str) -> None:
        if list(complaints(scene)):
            raise Refused("; ".join(complaints(scene)))
        self.scene = scene
        self.exact = Fraction if inputs == "binary64" else lambda x: Fraction(repr(float(x)))
        self.s = Fraction(0)  # of a family of scenes
        self.index = {body.name: k for k, body in enumerate(scene.bodies)} | {GROUND: -1}
        self.free = [
            {"planar": (0, 1, 5), "spatial": range(6)}.get(b.type, range(len(b.position))) for b in scene.bodies
        ]
        self.now = arb(0)  # s
        self.gm = next((load.gm for load in scene.loads if load.type == "newton"), ())
        self.columns = [(k, c) for k, free in enumerate(self.free) for c in free]

    def number(self, value: float) -> Fraction:
        if isinstance(value, Varied):
            a, b, c = value.coefficients(self.exact)
            return a + self.s * (b + self.s * c)
        return self.exact(value)

    def ball(self, value: float) -> arb:
        return exact(self.number(value))

    def vector(self, values: Sequence[float]) -> list[arb]:
        return ([self.ball(x) for x in values] + [arb(0)] * 3)[:3]

    def offset(self, body: int, point: Sequence[float]) -> list[arb]:
        place = self.scene.bodies[body].position if body >= 0 else (0.0,) * 3
        return [x - y for x, y in zip(self.vector(point), self.vector(place), strict=True)]

    def jets(self, state: list[Any], rate: list[Any], acceleration: list[Any], pace: int = 1) -> list[Any]:
        """Return place, turn and angle of every body as series to t^2; the last are time, at a pace, and ground."""
        moved = []
        for (r, turn, angle), v, a in zip(state, rate, acceleration, strict=True):
            place = [arb_series([r[i], v[i], a[i] / 2]) for i in range(3)]
            w, swing = _skew(v[3:]), _skew(a[3:])
            square = _matmul(w, w)
            series = [
                [arb_series([arb(i == j), w[i][j], (swing[i][j] + square[i][j]) / 2]) for j in range(3)]
                for i in range(3)
            ]
            moved.append((place, _matmul(series, turn), arb_series([angle, v[5], a[5] / 2])))
        unit = [[arb_series([arb(i == j)]) for j in range(3)] for i in range(3)]
        return [*moved, arb_series([self.now, pace]), ([arb_series([0])] * 3, unit, arb_series([0]))]

    def mark(self, jets: list[Any], body: int, point: Sequence[float]) -> list[Number]:
        place, turn, _ = jets[body]
        return [x + y for x, y in zip(place, _apply(turn, self.offset(body, point)), strict=True)]

    def signal(self, signal: Any, t: Number) -> Number:
        """Return the value of a signal at a time, or along a series of times."""
        names = {"constant": ("value",), "harmonic": ("offset",), "polynomial": ("coefficients",)}[signal.type]
        own = getattr(signal, names[0])
        total = arb(0) * t
        for c in reversed(own if isinstance(own, tuple) else (own,)):
            total = total * t + self.ball(c)
        if signal.type == "harmonic":
            amplitude, omega, phase = (self.ball(x) for x in (signal.amplitude, signal.omega, signal.phase))
            total += amplitude * (omega * t + phase).sin()
        return total

    def driven(self, jets: list[Any], joint: Any) -> list[Number]:
        """Return how far a body is from where a drive wants it, up to a constant; a virtual motion has no time."""
        body, t = self.index[joint.body], jets[-2]
        wanted = self.signal(joint.motion, t)
        for _ in range(("position", "velocity", "acceleration").index(joint.level)):
            wanted = wanted.integral() * t.derivative()
        if joint.type == "coordinate_drive":
            return [
                (jets[body][2] if joint.coordinate == "angle" else jets[body][0]["xyz".index(joint.coordinate)])
                - wanted
            ]
        axis = self.vector(joint.direction)
        return [dot(axis, self.mark(jets, body, joint.point)) - wanted * dot(axis, axis).sqrt()]

    def closure(self, jets: list[Any], joint: Any) -> list[Number]:
        """Return the rows of a joint, each zero where it holds."""
        if joint.type in DRIVES:
            return self.driven(jets, joint)
        a, b = self.index[joint.body_a], self.index[joint.body_b]
        points = (joint.point_a, joint.point_b) if joint.type == "distance" else (joint.point, joint.point)
        gap = [y - x for x, y in zip(self.mark(jets, a, points[0]), self.mark(jets, b, points[1]), strict=True)]
        if joint.type == "distance":
            return [dot(gap, gap)]
        flat = self.scene.dimension == 2
        still = [(0, 1)] if flat else [(0, 1), (1, 2), (2, 0)]
        same = [dot(_column(jets[a][1], i), _column(jets[b][1], j)) for i, j in still]
        if joint.type == "weld":
            return gap[: self.scene.dimension] + same
        if joint.type == "universal":
            sides = zip((a, b), (joint.axis_a, joint.axis_b), strict=True)
            return [*gap, dot(*(_apply(jets[body][1], self.vector(axis)) for body, axis in sides))]
        if joint.type == "spherical" or joint.axis is None:
            return gap[: self.scene.dimension]
        axis = self.vector(joint.axis)
        main = max(range(3), key=lambda i: abs((*joint.axis, 0.0)[i]))
        across = [
            [-axis[i] if j == main else axis[main] if j == i else arb(0) for j in range(3)]
            for i in range(3)
            if i != main
        ]
        across = across[:1] if flat else across
        if joint.type == "prismatic":
            return [dot(_apply(jets[a][1], n), gap) for n in across] + same
        return gap + [dot(_apply(jets[a][1], n), _apply(jets[b][1], axis)) for n in across]

    def stretches(self, jets: list[Any]) -> Iterator[tuple[Number, Any, Any, tuple[int, ...]]]:
        """Yield the stretch of every spring with its stiffness, damping and bodies."""
        for load in self.scene.loads:
            if load.type in ("spring_damper", "torsion_spring"):
                a, b = self.index[load.body_a], self.index[load.body_b]
                if load.type == "torsion_spring":
                    first = [self.number(self.scene.bodies[k].angle) if k >= 0 else Fraction(0) for k in (a, b)]
                    rest = (
                        Fraction(0) if load.rest_angle is None else self.number(load.rest_angle) - first[1] + first[0]
                    )
                    stretch = jets[b][2] - jets[a][2] - exact(rest)
                else:
                    gap = [
                        y - x
                        for x, y in zip(self.mark(jets, a, load.point_a), self.mark(jets, b, load.point_b), strict=True)
                    ]
                    start = sum(
                        (self.number(x) - self.number(y)) ** 2 for x, y in zip(load.point_a, load.point_b, strict=True)
                    )
                    rest = exact(Fraction(start)).sqrt() if load.rest_length is None else self.ball(load.rest_length)
                    stretch = dot(gap, gap).sqrt() - rest
                yield stretch, self.ball(load.stiffness), self.ball(load.damping), (a, b)

    def potential(self, jets: list[Any], body: int) -> Number:
        """Return the potential energy that moving one body changes."""
        part = self.scene.bodies[body]
        mass = self.ball(part.mass)
        total = -dot(self.vector(self.scene.gravity), jets[body][0]) * mass
        for stretch, stiffness, _, bodies in self.stretches(jets):
            if body in bodies:
                total += stretch * stretch * stiffness / 2
        for load in self.scene.loads:
            if load.type == "force" and self.index[load.body] == body:
                vector = [x * self.signal(load.factor, self.now) for x in self.vector(load.vector)]
                total -= dot(vector, self.mark(jets, body, load.point))
        others = (k for k in range(len(self.scene.bodies)) if k != body and self.gm)
        return total - sum((mass * self.ball(self.gm[k]) * self.well(jets, body, k) for k in others), arb(0))

    def well(self, jets: list[Any], a: int, b: int) -> Number:
        """Return the sum of 1 / r of two bodies, and of what zonal harmonics add to it."""
        gap = [y - x for x, y in zip(jets[b][0], jets[a][0], strict=True)]
        fields = (load for load in self.scene.loads if load.type in ("newton", "oblateness"))
        return sum(
            (self._well(gap, one) for one in fields if self.index.get(getattr(one, "body", ""), a) in (a, b)), arb(0)
        )

    def _well(self, gap: list[Number], load: Any) -> Number:
        """Return 1 / r of a point, or what zonal harmonics add: -sum J_n R^n P_n(z / r) / r^(n + 1)."""
        distance = dot(gap, gap).sqrt()
        if load.type == "newton":
            return 1 / distance
        sine = dot(self.vector(load.axis), gap) / distance
        legendre, ratio, total = [arb(1), sine], self.ball(load.radius) / distance, arb(0) * sine
        for n, harmonic in enumerate(load.zonal, start=2):
            legendre.append((sine * legendre[-1] * (2 * n - 1) - legendre[-2] * (n - 1)) / n)
            total -= self.ball(harmonic) * ratio**n * legendre[n] / distance
        return total

    def accelerations(self, state: list[Any], rate: list[list[arb]]) -> list[list[arb]]:
        """Return the accelerations of all bodies by multipliers, six numbers each."""
        count = len(self.scene.bodies)
        rest, zero = [[arb(0)] * 6 for _ in range(count)], self.jets(state, rate, [[arb(0)] * 6] * count)
        known = [2 * row[2] for joint in self.scene.joints for row in self.closure(zero, joint)]
        size = len(self.columns) + len(known)
        matrix, right = arb_mat(size, size), arb_mat(size, 1)
        for column, (body, c) in enumerate(self.columns):
            unit = [list(row) for row in rest]
            unit[body][c] = arb(1)
            virtual = self.jets(state, unit, rest, 0)
            right[column, 0] = -self.potential(virtual, body)[1] + self._driven(zero, virtual, body, c)
            row = len(self.columns)
            for joint in self.scene.joints:
                touched = body in [self.index[end] for end in joint.ends]
                rows = self.closure(virtual, joint) if touched else None
                for k in range(len(self.closure(zero, joint))) if rows is None else range(len(rows)):
                    if rows is not None:
                        matrix[row, column] = matrix[column, row] = rows[k][1]
                    row += 1
        for row, value in enumerate(known, start=len(self.columns)):
            right[row, 0] = -value
        self._inertial(matrix, right, state, rate)
        solved = solve(matrix, right)
        for column, (body, c) in enumerate(self.columns):
            rest[body][c] = solved[column, 0]
        return rest

    def _driven(self, motion: list[Any], virtual: list[Any], body: int, c: int) -> arb:
        """Return the power of torques and dampers along one unit rate of a body."""
        total = arb(0)
        for (now, _, damping, bodies), (then, *_) in zip(self.stretches(motion), self.stretches(virtual), strict=True):
            if body in bodies:
                total -= damping * now[1] * then[1]
        for load in self.scene.loads:
            if load.type in ("torque", "torque_vector") and self.index[load.body] == body and c >= 3:
                vector = (0.0, 0.0, load.torque) if load.type == "torque" else load.vector
                total += self.ball(vector[c - 3]) * self.signal(load.factor, self.now)
        return total

    def _inertial(self, matrix: arb_mat, right: arb_mat, state: list[Any], rate: list[list[arb]]) -> None:
        for first, (body, c) in enumerate(self.columns):
            part = self.scene.bodies[body]
            if c < 3:
                matrix[first, first] = self.ball(part.mass)
            elif part.type == "planar":
                matrix[first, first] = self.ball(part.inertia)
            else:
                inertia = self._inertia(part, state[body][1])
                for second in range(3):
                    matrix[first, first - c + 3 + second] = inertia[c - 3][second]
                w = rate[body][3:]
                right[first, 0] -= _apply(_skew(w), _apply(inertia, w))[c - 3]

    def _inertia(self, part: Any, turn: list[list[arb]]) -> list[list[arb]]:
        xx, yy, zz, xy, xz, yz = (self.ball(x) for x in part.inertia)
        whole = _matmul(turn, rotation([self.ball(x) for x in part.orientation]))
        inverse = [list(column) for column in zip(*whole, strict=True)]
        return _matmul(whole, _matmul([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], inverse))

    @property
    def conserves(self) -> bool:
        """Whether `energy` is constant: nothing takes or gives any, and no body feels both a field and others."""
        kinds = {load.type for load in self.scene.loads}
        damped = any(getattr(load, "damping", 0.0) for load in self.scene.loads)
        damped = damped or any(joint.type in DRIVES for joint in self.scene.joints)
        damped = damped or any(part.law.restitution != 1.0 for part in self.scene.contacts)
        return not damped and kinds <= set(ENERGETIC) and ("newton" not in kinds or not any(self.scene.gravity))

    def energy(self, state: list[Any], rate: list[list[arb]]) -> arb:
        """Return kinetic and potential energy without dampers; gm counts as mass among attracting bodies."""
        gm = self.gm
        jets, total = self.jets(state, [[arb(0)] * 6] * len(rate), [[arb(0)] * 6] * len(rate)), arb(0)
        for k, (part, own) in enumerate(zip(self.scene.bodies, rate, strict=True)):
            mass = self.ball(gm[k] if gm else part.mass)
            total += mass * dot(own[:3], own[:3]) / 2
            if not gm:
                total += -mass * dot(self.vector(self.scene.gravity), jets[k][0])[0]
            if part.type == "planar":
                total += self.ball(part.inertia) * own[5] * own[5] / 2
            elif part.type == "spatial":
                total += dot(own[3:], _apply(self._inertia(part, state[k][1]), own[3:])) / 2
            for j in range(k if gm else 0):
                total -= mass * self.ball(gm[j]) * self.well(jets, k, j)[0]
        for stretch, stiffness, *_ in self.stretches(jets):
            total += (stretch * stretch)[0] * stiffness / 2
        return total


def _skew(w: Sequence[Number]) -> list[list[Number]]:
    zero = w[0] - w[0]
    return [[zero, -w[2], w[1]], [w[2], zero, -w[0]], [-w[1], w[0], zero]]


def dot(a: Sequence[Number], b: Sequence[Number]) -> Number:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _apply(matrix: Any, vector: Sequence[Number]) -> list[Number]:
    return [dot(row, vector) for row in matrix]


def _column(matrix: Any, k: int) -> list[Number]:
    return [row[k] for row in matrix]


def _matmul(a: Any, b: Any) -> list[list[Number]]:
    return [[dot(row, _column(b, k)) for k in range(3)] for row in a]


def rotation(e: Sequence[arb]) -> list[list[arb]]:
    """Return (2 e0^2 - 1) 1 + 2 v v^T + 2 e0 [v] of Euler parameters divided by their norm."""
    size = sum((x * x for x in e), arb(0))
    skew = _skew(e[1:])
    return [
        [
            ((2 * e[0] * e[0] - size) * int(i == j) + 2 * e[i + 1] * e[j + 1] + 2 * e[0] * skew[i][j]) / size
            for j in range(3)
        ]
        for i in range(3)
    ]
