"""heyoka: Taylor's method of arbitrary order, compiled for the scene at hand (Biscani and Izzo 2021)."""

# The package has no type information for its expressions.
# pyright: reportAttributeAccessIssue=false, reportCallIssue=false

from dataclasses import dataclass
from itertools import combinations
from typing import Any, ClassVar

import heyoka  # an optional extra
import numpy as np

from cross_checks.engine import End, Engine, Loop, Method, Plan, Poses, Refusal
from cross_checks.engine.celestial import of_particles, unsupported
from mbs_ref import Scene, Status
from mbs_ref.scene.celestial import Oblateness
from mbs_ref.scene.scales import attraction, is_celestial

TOLERANCES = (1e-6, 1e-9, 1e-12, 1e-15, 1e-18)  # of the Taylor series' remainder; 1e-18 is below roundoff
METHODS = (
    Method("taylor", "adaptive", None, "Taylor's method, order and step by the tolerance", TOLERANCES),
    Method("taylor_compensated", "adaptive", None, "the same with compensated sums", TOLERANCES),
)


@dataclass
class Built:
    """The equations of motion, and the integrator once it is compiled."""

    equations: list[tuple[Any, Any]]  # of each variable and its rate
    start: np.ndarray  # (n, 6) m, m/s
    moves: list[int]  # the bodies that equations are written for; all others rest
    integrator: Any = None


class Heyoka(Engine):
    """heyoka's adaptive Taylor integrator on free particles."""

    name: ClassVar[str] = "heyoka"
    package: ClassVar[str] = "heyoka"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    part_types: ClassVar[frozenset[str]] = frozenset({"point_mass", "newton", "epoch", "oblateness"})
    unrolled: ClassVar[int] = 3  # bodies; beyond, unrolled code takes long to compile

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        if not is_celestial(scene):
            return [Refusal("the adapter writes free particles in space under gravity as series, nothing else", False)]
        return [Refusal(reason, False) for reason in unsupported(scene, "heyoka")]

    def build(self, scene: Scene, plan: Plan) -> Built:
        gm = attraction(scene)
        moves = [i for i, body in enumerate(scene.bodies) if any(body.velocity) or any((*gm[:i], *gm[i + 1 :]))] or [0]
        x = [_variables(body, i in moves) for i, body in enumerate(scene.bodies)]
        pull: list[Any] = [[heyoka.expression(0.0)] * 3 for _ in gm]  # m/s^2
        for i, j in combinations(range(len(gm)), 2):
            if gm[i] or gm[j]:
                field = _field([x[j][c] - x[i][c] for c in range(3)], _zonals(scene, i), _zonals(scene, j))
                for c in range(3):
                    pull[j][c] += gm[i] * field[c]
                    pull[i][c] -= gm[j] * field[c]
        equations = [pair for i in moves for pair in zip(x[i], [*x[i][3:], *pull[i]], strict=True)]
        start = np.array([[*body.position, *body.velocity] for body in scene.bodies], dtype=float)  # m, m/s
        return Built(equations, start, moves)

    def first_call(self, model: Built, plan: Plan) -> None:
        """Compile machine code, which the construction of the integrator does."""
        large = len(model.moves) > self.unrolled
        model.integrator = heyoka.taylor_adaptive(
            model.equations, model.start[model.moves].ravel().tolist(), tol=plan.rtol, compact_mode=large,
            fast_math=not large, high_accuracy=plan.method.name == "taylor_compensated",
        )  # fmt: skip

    def advance(self, model: Built, plan: Plan) -> Loop:
        """Stop at every output time by a step that ends there: no dense output."""
        integrator, steps = model.integrator, 0
        states = np.full((len(plan.times), *model.start.shape), np.nan)
        states[0] = model.start
        for k, t in enumerate(plan.times[1:].tolist(), start=1):
            outcome, _, _, made, _, _ = integrator.propagate_until(t)
            steps += made
            if outcome != heyoka.taylor_outcome.time_limit:
                end = End(k, Status.NON_FINITE, f"heyoka stopped before t = {t:g} s with {outcome}")
                return Loop(states, end, steps)
            states[k] = model.start
            states[k, model.moves] = integrator.state.reshape(-1, 6)
        return Loop(states, End(len(plan.times)), steps)

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        return of_particles(states[:, :, :3], states[:, :, 3:])


class Unrolled(Heyoka):
    """heyoka with code unrolled for every scene: that of the solar system takes 20 s to compile."""

    unrolled: ClassVar[int] = 100


ENGINE = Heyoka


def _variables(body: Any, moves: bool) -> list[Any]:
    """Return place and velocity: variables of a body that moves, else numbers."""
    names = [f"{name}_{body.name}" for name in ("x", "y", "z", "vx", "vy", "vz")]
    return [heyoka.expression(name) for name in names] if moves else [*body.position, *body.velocity]


def _zonals(scene: Scene, i: int) -> list[Oblateness]:
    return [load for load in scene.loads if isinstance(load, Oblateness) and scene.body_index(load.body) == i]


def _field(d: list[Any], own: list[Oblateness], other: list[Oblateness]) -> list[Any]:
    """Return the field of a unit gm at d from it (1/m^2), with the zonal harmonics of both bodies of a pair.

    sum J_n R^n [P'_(n+1)(s) d/r - P'_n(s) p] / r^(n+2), s = h/r, as powers of r^2 times products of h = d.p: each is
    one recurrence, and none divides by h, which is 0 on the equator.
    """
    square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    along, rest = -(square**-1.5), [0.0, 0.0, 0.0]
    for load, sign in (*((load, 1.0) for load in own), *((load, -1.0) for load in other)):
        axis = np.array(load.axis) / np.linalg.norm(load.axis)
        h = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]
        for n, harmonic in enumerate(load.zonal, start=2):
            share = harmonic * load.radius**n * sign**n  # seen from the other body, d and h are reversed
            along += share * _over_powers(_slope(n + 1), h, square, n + 3)
            toward = share * _over_powers(_slope(n), h, square, n + 2)
            rest = [rest[c] - toward * axis[c] for c in range(3)]
    return [along * d[c] + rest[c] for c in range(3)]


def _slope(n: int) -> np.ndarray:
    """Return the coefficients of P'_n."""
    return np.polynomial.legendre.Legendre.basis(n).deriv().convert(kind=np.polynomial.Polynomial).coef


def _over_powers(coefficients: np.ndarray, h: Any, square: Any, power: int) -> Any:
    """Return sum c_k s^k / r^power with s = h / r."""
    total, product = 0.0, 1.0
    for k, coefficient in enumerate(coefficients.tolist()):
        if coefficient:
            total = total + coefficient * product * square ** (-0.5 * (power + k))
        product = product * h
    return total
