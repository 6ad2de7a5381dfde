"""heyoka: Taylor's method of arbitrary order, compiled for the scene at hand (Biscani and Izzo 2021)."""

# The package has no type information for its expressions.
# pyright: reportAttributeAccessIssue=false, reportCallIssue=false

from dataclasses import dataclass
from typing import Any, ClassVar

import heyoka  # an optional extra
import numpy as np

from cross_checks.engine import End, Engine, Loop, Method, Plan, Poses, Refusal
from cross_checks.engine.celestial import of_particles, unsupported
from mbs_ref import Scene, Status
from mbs_ref.scene.celestial import Oblateness
from mbs_ref.scene.scales import attraction, is_celestial

TOLERANCES = (1e-6, 1e-9, 1e-12, 1e-15, 1e-18)  # of the Taylor series' remainder; 1e-18 is below roundoff
UNROLLED = 3  # bodies; beyond, unrolled code takes minutes to compile
METHODS = (
    Method("taylor", "adaptive", None, "Taylor's method, order and step by the tolerance", TOLERANCES),
    Method("taylor_compensated", "adaptive", None, "the same with compensated sums", TOLERANCES),
)


@dataclass
class Built:
    """The equations of motion, and the integrator once it is compiled."""

    equations: list[tuple[Any, Any]]
    start: np.ndarray
    integrator: Any = None


class Heyoka(Engine):
    """heyoka's adaptive Taylor integrator on free particles."""

    name: ClassVar[str] = "heyoka"
    package: ClassVar[str] = "heyoka"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    part_types: ClassVar[frozenset[str]] = frozenset({"point_mass", "newton", "epoch", "oblateness"})

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        if not is_celestial(scene):
            return [Refusal("the adapter writes free particles in space under gravity as series, nothing else", False)]
        return [Refusal(reason, False) for reason in unsupported(scene, "heyoka")]

    def build(self, scene: Scene, plan: Plan) -> Built:
        start = [[*body.position, *body.velocity] for body in scene.bodies]  # m, m/s
        gm = attraction(scene)
        equations = heyoka.model.nbody(len(scene.bodies), masses=list(gm), Gconst=1.0)  # (variable, its rate)
        extra: dict[int, Any] = {}
        for load in scene.loads:
            if isinstance(load, Oblateness):
                _add_zonals(extra, load, scene.body_index(load.body), gm, [variable for variable, _ in equations])
        equations = [(variable, rate + extra.get(k, 0.0)) for k, (variable, rate) in enumerate(equations)]
        return Built(equations, np.array(start, dtype=float).ravel())

    def first_call(self, model: Built, plan: Plan) -> None:
        """Compile machine code, which the construction of the integrator does."""
        model.integrator = heyoka.taylor_adaptive(
            model.equations, model.start.tolist(), tol=plan.rtol, compact_mode=len(model.start) > 6 * UNROLLED,
            high_accuracy=plan.method.name == "taylor_compensated",
        )  # fmt: skip

    def advance(self, model: Built, plan: Plan) -> Loop:
        """Stop at every output time by a step that ends there: no dense output."""
        integrator, steps = model.integrator, 0
        states = np.full((len(plan.times), len(model.start)), np.nan)
        states[0] = integrator.state
        for k, t in enumerate(plan.times[1:].tolist(), start=1):
            outcome, _, _, made, _, _ = integrator.propagate_until(t)
            steps += made
            if outcome != heyoka.taylor_outcome.time_limit:
                end = End(k, Status.NON_FINITE, f"heyoka stopped before t = {t:g} s with {outcome}")
                return Loop(states, end, steps)
            states[k] = integrator.state
        return Loop(states, End(len(plan.times)), steps)

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        both = states.reshape(len(states), -1, 6)
        return of_particles(both[:, :, :3], both[:, :, 3:])


ENGINE = Heyoka


def _add_zonals(extra: dict[int, Any], load: Oblateness, i: int, gm: tuple[float, ...], x: list[Any]) -> None:
    """Add sum J_n (R/r)^n / r^2 [P'_(n+1)(s) d/r - P'_n(s) p] on every other body, and the reaction on it."""
    for j in range(len(gm)):
        if j == i or gm[i] == gm[j] == 0.0:
            continue
        pull = _zonal_pull([x[6 * j + c] - x[6 * i + c] for c in range(3)], load)
        for c in range(3):
            extra[6 * j + 3 + c] = extra.get(6 * j + 3 + c, 0.0) + gm[i] * pull[c]
            if gm[j] > 0.0:
                extra[6 * i + 3 + c] = extra.get(6 * i + 3 + c, 0.0) - gm[j] * pull[c]


def _zonal_pull(d: list[Any], load: Oblateness) -> list[Any]:
    """Return the field of a unit gm at d from the body (1/m^2), with Legendre's polynomials written out."""
    square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    inverse = square**-0.5
    axis = np.array(load.axis) / np.linalg.norm(load.axis)
    s = (d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]) * inverse
    along, toward = 0.0, 0.0
    for n, harmonic in enumerate(load.zonal, start=2):
        share = harmonic * load.radius**n * square ** (-0.5 * (n + 2))
        along = along + share * _legendre_slope(n + 1, s) * inverse
        toward = toward + share * _legendre_slope(n, s)
    return [along * d[c] - toward * axis[c] for c in range(3)]


def _legendre_slope(n: int, s: Any) -> Any:
    """Return P'_n(s) by Horner's scheme: the series of a power s^k is NaN where s = 0, on the equator."""
    powers = np.polynomial.legendre.Legendre.basis(n).deriv().convert(kind=np.polynomial.Polynomial).coef
    total: Any = float(powers[-1])
    for coefficient in powers[-2::-1]:
        total = total * s + float(coefficient)
    return total
