"""The motion of a scene in absolute coordinates with multipliers, as the checker derives it, in SI units.

Every derivative is a coefficient of a series in time: closures and energies are evaluated along motions. The plane is
space with bodies that turn about z: closures on which no coordinate acts are left out.
"""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import zip_longest
from typing import Any

from flint import arb, arb_series  # pyright: ignore[reportMissingImports]  # an optional extra

from cross_checks.truths.proofs.checker.formulas import Number, Refused, above, exact, terms
from cross_checks.truths.proofs.coverage import DRIVES, ENERGETIC, PAIRS, complaints
from cross_checks.truths.proofs.family import Varied
from mbs_ref.scene import GROUND

EQUAL = 2.0**-600  # how nearly numbers of 1000 bits must agree
STILL = [arb(0)] * 6  # rates of a body at rest
Jet = tuple[list[Number], list[list[Number]], Number]  # place, turn since t = 0 and angle about z of a body in motion


class Mechanics:
    """A scene in absolute coordinates."""

    def __init__(self, scene: Any, inputs: str) -> None:
        if reasons := list(complaints(scene)):
            raise Refused("; ".join(reasons))
        self.scene, self.now, self.s = scene, arb(0), arb(0)  # time, s; parameter of a family
        self.exact = Fraction if inputs == "binary64" else lambda x: Fraction(repr(float(x)))
        self.index = {body.name: k for k, body in enumerate(scene.bodies)} | {GROUND: -1}
        own = {"planar": (0, 1, 5), "spatial": range(6)}
        self.free = [tuple(own.get(body.type, range(len(body.position)))) for body in scene.bodies]
        self.columns = [(k, c) for k, free in enumerate(self.free) for c in free]
        self.gm = next((load.gm for load in scene.loads if load.type == "newton"), ())

    def ball(self, value: float) -> Number:
        if isinstance(value, Varied):
            a, b, c = map(exact, value.coefficients(self.exact))
            return a + self.s * (b + self.s * c)
        return exact(self.exact(value))

    def vector(self, values: Sequence[float]) -> list[Number]:
        return ([self.ball(x) for x in values] + [arb(0)] * 3)[:3]

    def angle(self, name: str) -> arb:
        return self.ball(0.0 if name == GROUND else self.scene.bodies[self.index[name]].angle)

    def offset(self, body: int, point: Sequence[float]) -> list[arb]:
        return minus(self.vector(point), self.vector(self.scene.bodies[body].position if body >= 0 else ()))

    def jet(self, state: Any, rate: Sequence[arb], bend: Sequence[arb] = STILL) -> Jet:
        """Return a body in motion, to t^2."""
        place, turn, angle = state
        swing, twist = _skew(rate[3:]), _skew(bend[3:])
        square = _matmul(swing, swing)
        whole = [[arb_series([arb(i == j), swing[i][j], (square[i][j] + twist[i][j]) / 2]) for j in range(3)]
                 for i in range(3)]  # fmt: skip
        path = [arb_series([x, v, a / 2]) for x, v, a in zip(place, rate, bend, strict=False)]
        return path, _matmul(whole, turn), arb_series([angle, rate[5], bend[5] / 2])

    def jets(self, states: list[Any], rates: Sequence[Any] = (), bends: Sequence[Any] = ()) -> list[Any]:
        """Return all bodies in motion, or at rest without time; the last are time and ground."""
        rest = ([arb(0)] * 3, rotation([arb(1), arb(0), arb(0), arb(0)]), arb(0))
        moving = [self.jet(*own) for own in zip_longest(states, rates, bends, fillvalue=STILL)]
        return [*moving, arb_series([self.now, int(bool(rates))]), self.jet(rest, STILL)]

    def mark(self, jets: list[Any], body: int, point: Sequence[float]) -> list[Number]:
        place, turn, _ = jets[body]
        return [x + y for x, y in zip(place, apply(turn, self.offset(body, point)), strict=True)]

    def gap(self, jets: list[Any], part: Any) -> list[Number]:
        """Return the vector between the points of both bodies that a joint or a spring connects."""
        points = (part.point_a, part.point_b) if hasattr(part, "point_a") else (part.point, part.point)
        a, b = (self.mark(jets, self.index[name], point) for name, point in zip(part.ends, points, strict=True))
        return minus(b, a)

    def signal(self, signal: Any, t: Number) -> Number:
        """Return the value of a signal at a time, or along a series of times."""
        if signal.type == "harmonic":
            amplitude, omega, phase = (self.ball(x) for x in (signal.amplitude, signal.omega, signal.phase))
            return amplitude * (omega * t + phase).sin() + self.ball(signal.offset)
        total = arb(0) * t
        for c in reversed(signal.coefficients if signal.type == "polynomial" else (signal.value,)):
            total = total * t + self.ball(c)
        return total

    def driven(self, jets: list[Any], joint: Any) -> Number:
        """Return how far a body is from where a drive wants it, up to a constant; a virtual motion has no time."""
        body, t = self.index[joint.body], jets[-2]
        wanted = self.signal(joint.motion, t)
        for _ in range(("position", "velocity", "acceleration").index(joint.level)):
            wanted = wanted.integral() * t.derivative()
        if joint.type == "coordinate_drive":
            place, _, angle = jets[body]
            return (angle if joint.coordinate == "angle" else place["xyz".index(joint.coordinate)]) - wanted
        axis = self.vector(joint.direction)
        return dot(axis, self.mark(jets, body, joint.point)) - wanted * dot(axis, axis).sqrt()

    def closure(self, jets: list[Any], joint: Any) -> list[Number]:
        """Return the rows of a joint, each constant where it holds."""
        if joint.type in DRIVES:
            return [self.driven(jets, joint)]
        gap = self.gap(jets, joint)
        if joint.type == "distance":
            return [dot(gap, gap)]
        turn_a, turn_b = (jets[self.index[name]][1] for name in joint.ends)
        same = [dot(_column(turn_a, i), _column(turn_b, j)) for i, j in ((0, 1), (1, 2), (2, 0))]
        if joint.type == "weld":
            return gap + same
        if joint.type == "universal":
            return [*gap, dot(apply(turn_a, self.vector(joint.axis_a)), apply(turn_b, self.vector(joint.axis_b)))]
        if joint.type == "spherical" or joint.axis is None:
            return gap
        axis, main = self.vector(joint.axis), max(range(3), key=lambda i: abs((*joint.axis, 0.0)[i]))
        across = [[axis[main] * (i == j) - axis[i] * (j == main) for j in range(3)] for i in range(3) if i != main]
        if joint.type == "prismatic":
            return [dot(apply(turn_a, n), gap) for n in across] + same
        return gap + [dot(apply(turn_a, n), apply(turn_b, axis)) for n in across]

    def stretches(self, jets: list[Any]) -> Iterator[tuple[Number, Any, Any, list[int]]]:
        """Yield the stretch of every spring with its stiffness, damping and bodies."""
        for load in self.scene.loads:
            if load.type == "torsion_spring":
                (a, first), (b, second) = ((jets[self.index[name]][2], self.angle(name)) for name in load.ends)
                stretch = b - a - (0 if load.rest_angle is None else self.ball(load.rest_angle) - second + first)
            elif load.type == "spring_damper":
                gap, first = self.gap(jets, load), minus(self.vector(load.point_a), self.vector(load.point_b))
                rest = dot(first, first).sqrt() if load.rest_length is None else self.ball(load.rest_length)
                stretch = dot(gap, gap).sqrt() - rest
            else:
                continue
            ends = [self.index[name] for name in load.ends]
            yield stretch, self.ball(load.stiffness), self.ball(load.damping), ends

    def mass(self, body: int, attracts: bool) -> arb:
        """Return a body's mass; of one that attracts, gm instead if requested."""
        return self.ball(self.gm[body] if attracts and self.gm else self.scene.bodies[body].mass)

    def potential(self, jets: list[Any], moved: int | None = None) -> Number:
        """Return the potential energy that moving one body changes; without one, all with gm as masses."""
        total, gravity = arb(0), self.vector(self.scene.gravity)
        for k in range(len(self.scene.bodies)) if moved is None else (moved,):
            total -= dot(gravity, jets[k][0]) * self.mass(k, moved is None)
            for j, gm in enumerate(self.gm[: k if moved is None else None]):
                total -= self.mass(k, moved is None) * self.ball(gm) * self.well(jets, k, j) if j != k else 0
        for stretch, stiffness, _, bodies in self.stretches(jets):
            total += stretch * stretch * stiffness / 2 if moved is None or moved in bodies else 0
        for load in self.scene.loads:
            if load.type == "force" and self.index[load.body] == moved:
                pull = dot(self.vector(load.vector), self.mark(jets, self.index[load.body], load.point))
                total -= pull * self.signal(load.factor, self.now)
        return total

    def well(self, jets: list[Any], a: int, b: int) -> Number:
        """Return the sum of 1 / r of two bodies, and of what zonal harmonics add: -sum J_n R^n P_n(z / r) / r^(n+1)."""
        gap = minus(jets[a][0], jets[b][0])
        distance = dot(gap, gap).sqrt()
        total = 1 / distance
        for load in self.scene.loads:
            if load.type == "oblateness" and self.index[load.body] in (a, b):
                sine, ratio = dot(self.vector(load.axis), gap) / distance, self.ball(load.radius) / distance
                legendre = [1 + 0 * sine, sine]
                for n, harmonic in enumerate(load.zonal, start=2):
                    legendre.append((sine * legendre[-1] * (2 * n - 1) - legendre[-2] * (n - 1)) / n)
                    total -= self.ball(harmonic) * ratio**n * legendre[n] / distance
        return total

    def clearance(self, jets: list[Any], part: Any) -> Number:
        """Return what is positive where the bodies of a contact do not touch, and 0 where they do."""
        gap = minus(*(jets[self.index[name]][0] for name in part.ends))
        if part.type in PAIRS:
            return dot(gap, gap) - (self.ball(part.radius_a) + self.ball(part.radius_b)) ** 2
        if part.type == "circle_on_line":
            point = self.vector(part.point_1)
            normal = apply(_skew([arb(0), arb(0), arb(1)]), minus(self.vector(part.point_2), point))
        else:
            point, normal = self.vector(part.point), self.vector(part.normal)
        return dot(normal, minus(gap, point)) - self.ball(part.radius) * dot(normal, normal).sqrt()

    def struck(self, part: Any, states: list[Any], rates: list[list[arb]], later: list[list[arb]]) -> list[arb]:
        """Return what is 0 in an impact: rate of clearance + e times the first, and momentum that no impulse bears."""
        before, after = (self.clearance(self.jets(states, own), part)[1] for own in (rates, later))
        bodies = zip(self.scene.bodies, states, map(minus, later, rates), strict=True)
        momenta = [self._inertial(body, state, STILL, change) for body, state, change in bodies]
        impulse = [self.clearance(virtual, part)[1] for *_, virtual in self._virtual(states)]
        return [
            after + self.ball(part.law.restitution) * before,
            *_beyond([impulse], [momenta[k][c] for k, c in self.columns]),
        ]

    def _virtual(self, states: list[Any]) -> Iterator[tuple[int, int, list[Any]]]:
        """Yield the motions of all bodies at rest but one, which has one unit rate."""
        still = self.jets(states)
        for body, c in self.columns:
            virtual = list(still)
            virtual[body] = self.jet(states[body], [arb(i == c) for i in range(6)])
            yield body, c, virtual

    def missing(self, states: list[Any], rates: list[list[arb]], bends: list[list[arb]]) -> list[arb]:
        """Return what is 0 in a motion: all closures' second derivatives, and forces that no multipliers bear."""
        motion, slopes, needs = self.jets(states, rates, bends), {}, []
        inertial = [self._inertial(*own) for own in zip(self.scene.bodies, states, rates, bends, strict=True)]
        for column, (body, c, virtual) in enumerate(self._virtual(states)):
            driven = self._driven(motion, virtual, body, c)
            needs.append(inertial[body][c] - driven + self.potential(virtual, body)[1])
            for joint in (joint for joint in self.scene.joints if body in map(self.index.get, joint.ends)):
                for k, row in enumerate(self.closure(virtual, joint)):
                    slopes.setdefault((joint.name, k), [arb(0)] * len(self.columns))[column] = row[1]
        bent = [terms(row, 3)[2] for joint in self.scene.joints for row in self.closure(motion, joint)]
        return [*_beyond(list(slopes.values()), needs), *bent]

    def _inertial(self, part: Any, state: Any, rate: list[arb], bend: list[arb]) -> list[arb]:
        """Return the force and the moment of a body's acceleration."""
        inertia, w = self._inertia(part, state[1]), rate[3:]
        turning = zip(apply(inertia, bend[3:]), apply(_skew(w), apply(inertia, w)), strict=True)
        return [*(self.ball(part.mass) * a for a in bend[:3]), *(x + y for x, y in turning)]

    def _driven(self, motion: list[Any], virtual: list[Any], body: int, c: int) -> arb:
        """Return the power of torques and dampers along one unit rate of a body."""
        total = arb(0)
        for (now, _, damping, bodies), (then, *_) in zip(self.stretches(motion), self.stretches(virtual), strict=True):
            total -= damping * now[1] * then[1] if body in bodies else 0
        for load in self.scene.loads:
            if load.type in ("torque", "torque_vector") and self.index[load.body] == body and c > 2:
                vector = (0.0, 0.0, load.torque) if load.type == "torque" else load.vector
                total += self.ball(vector[c - 3]) * self.signal(load.factor, self.now)
        return total

    def _inertia(self, part: Any, turn: list[list[arb]]) -> list[list[arb]]:
        spatial = part.type == "spatial"
        own = part.inertia if spatial else (0.0, 0.0, getattr(part, "inertia", 0.0), 0.0, 0.0, 0.0)
        xx, yy, zz, xy, xz, yz = map(self.ball, own)
        whole = _matmul(turn, rotation([self.ball(x) for x in part.orientation])) if spatial else turn
        inverse = [_column(whole, k) for k in range(3)]
        return _matmul(whole, _matmul([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], inverse))

    @property
    def conserves(self) -> bool:
        """Whether `energy` is constant: nothing takes or gives any, and no body feels both a field and others."""
        scene, kinds = self.scene, {load.type for load in self.scene.loads}
        losses = [getattr(load, "damping", 0.0) for load in scene.loads] + [j.type in DRIVES for j in scene.joints]
        losses += [part.law.restitution != 1.0 for part in scene.contacts]
        return not any(losses) and kinds <= {*ENERGETIC} and ("newton" not in kinds or not any(scene.gravity))

    def energy(self, states: list[Any], rates: list[list[arb]]) -> arb:
        """Return kinetic and potential energy; gm counts as mass among attracting bodies."""
        total = terms(self.potential(self.jets(states)), 1)[0]
        for k, (part, own) in enumerate(zip(self.scene.bodies, rates, strict=True)):
            total += self.mass(k, True) * dot(own, own) / 2
            total += dot(own[3:], apply(self._inertia(part, states[k][1]), own[3:])) / 2
        return total


def _beyond(rows: list[list[arb]], vector: list[arb]) -> list[arb]:
    """Return what remains of a vector beyond the span of rows, by elimination; redundant rows leave nothing."""
    pivots: list[tuple[int, list[arb]]] = []
    for row in [*rows, vector]:
        for column, other in pivots:
            factor = row[column]
            row = row if factor.is_zero() else [x - factor * y for x, y in zip(row, other, strict=True)]
        largest = max(range(len(row)), key=lambda k: above(row[k]))
        if above(row[largest]) > EQUAL:
            pivots.append((largest, [x / row[largest] for x in row]))
    return row


def _skew(w: Sequence[Number]) -> list[list[Number]]:
    zero = w[0] - w[0]
    return [[zero, -w[2], w[1]], [w[2], zero, -w[0]], [-w[1], w[0], zero]]


def minus(a: Sequence[Number], b: Sequence[Number]) -> list[Number]:
    return [x - y for x, y in zip(a, b, strict=True)]


def dot(a: Sequence[Number], b: Sequence[Number]) -> Number:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def apply(matrix: Any, vector: Sequence[Number]) -> list[Number]:
    return [dot(row, vector) for row in matrix]


def _column(matrix: Any, k: int) -> list[Number]:
    return [row[k] for row in matrix]


def _matmul(a: Any, b: Any) -> list[list[Number]]:
    return [[dot(row, _column(b, k)) for k in range(3)] for row in a]


def rotation(e: Sequence[arb]) -> list[list[arb]]:
    """Return (2 e0^2 - 1) 1 + 2 v v^T + 2 e0 [v] of Euler parameters divided by their norm."""
    size, skew = sum((x * x for x in e), arb(0)), _skew(e[1:])
    whole = [[2 * e[i + 1] * e[j + 1] + 2 * e[0] * skew[i][j] for j in range(3)] for i in range(3)]
    return [[(whole[i][j] + (2 * e[0] * e[0] - size) * (i == j)) / size for j in range(3)] for i in range(3)]
