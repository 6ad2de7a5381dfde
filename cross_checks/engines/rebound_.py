"""REBOUND: N-body integrators in C; REBOUNDx adds relativity and J2. No Python callback is ever used."""

# The package has no type information for its integrators' settings.
# pyright: reportAttributeAccessIssue=false

from importlib.util import find_spec
from typing import Any, ClassVar

import numpy as np
import rebound

from cross_checks.engine import RTOLS, End, Engine, Loop, Method, Plan, Poses, Refusal
from cross_checks.engine.celestial import of_particles, unsupported
from mbs_ref import Scene, Status
from mbs_ref.scene.celestial import Oblateness, Relativity
from mbs_ref.scene.scales import attraction, free_fall_time, is_celestial

STEPS = (4e-2, 2e-2, 1e-2, 5e-3, 2.5e-3)  # s; WHFast and SABA, in time units of the Kepler scene
EPSILONS = (1e-3, 1e-5, 1e-7, 1e-9)  # IAS15's own measure; its default 1e-9 is machine precision
START = 1e-3  # of the shortest free-fall time: the first step of the adaptive methods
EXTRAS = (Relativity, Oblateness)  # by reboundx
VELOCITY_BLIND = frozenset({"whfast", "saba"})
METHODS = (
    Method("ias15", "adaptive", 15, "IAS15 (Rein and Spiegel 2015), compiled; rtol is its epsilon", EPSILONS),
    Method("whfast", "fixed", 2, "WHFast, Wisdom-Holman (Rein and Tamayo 2015), Jacobi coordinates", STEPS),
    Method("saba", "fixed", None, "SABA(10,6,4) (Blanes et al. 2013), a Wisdom-Holman splitting of high order", STEPS),
    Method("bs", "adaptive", None, "Gragg-Bulirsch-Stoer with variable order", RTOLS),
)


class Rebound(Engine):
    """REBOUND's integrators on free particles."""

    name: ClassVar[str] = "rebound"
    package: ClassVar[str] = "rebound"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    part_types: ClassVar[frozenset[str]] = frozenset({"point_mass", "newton", "epoch", "relativity", "oblateness"})

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        if not is_celestial(scene):
            return [Refusal("rebound moves free particles in space under gravity, and nothing else", True)]
        reasons = unsupported(scene, "rebound", j2_alone=True)
        if any(isinstance(load, EXTRAS) for load in scene.loads) and find_spec("reboundx") is None:
            reasons.append("relativity and oblateness need the package reboundx")
        return [Refusal(reason, False) for reason in reasons]

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        extra = any(isinstance(load, EXTRAS) for load in scene.loads)
        if extra and method.name in VELOCITY_BLIND:
            return [Refusal(f"{method.name} splits Newton's forces alone; with reboundx's it loses its order", True)]
        return super().method_refusals(scene, method)

    def build(self, scene: Scene, plan: Plan) -> tuple[Any, Any]:
        """Return the simulation, in SI units with G = 1 and gm as masses, and its extras, which must stay alive."""
        simulation = rebound.Simulation()
        simulation.G = 1.0
        for mass, body in zip(attraction(scene), scene.bodies, strict=True):
            (x, y, z), (u, v, w) = body.position, body.velocity  # pyright: ignore[reportAssignmentType]
            simulation.add(m=mass, x=x, y=y, z=z, vx=u, vy=v, vz=w)
        extras = _extras(simulation, scene)
        _choose(simulation, plan, free_fall_time(scene))
        return simulation, extras

    def advance(self, model: tuple[Any, Any], plan: Plan) -> np.ndarray:
        simulation, fixed = model[0], plan.method.kind == "fixed"
        states = np.empty((len(plan.times), 2, simulation.N, 3))
        simulation.serialize_particle_data(xyz=states[0, 0], vxvyvz=states[0, 1])
        for k, t in enumerate(plan.times[1:].tolist(), start=1):
            if fixed:
                simulation.steps(plan.counts[k - 1])
                simulation.synchronize()
            else:
                simulation.integrate(t)
            simulation.serialize_particle_data(xyz=states[k, 0], vxvyvz=states[k, 1])
        return states

    def collect(self, model: tuple[Any, Any], plan: Plan, left: np.ndarray) -> Loop:
        simulation = model[0]
        late = abs(simulation.t - plan.times[-1]) > 1e-9 * plan.times[-1]
        end = End(len(left), Status.RESET, f"the clock stands at {simulation.t:g} s") if late else End(len(left))
        return Loop(left, end, int(simulation.steps_done))

    def poses(self, model: tuple[Any, Any], plan: Plan, states: np.ndarray) -> Poses:
        return of_particles(states[:, 0], states[:, 1])


ENGINE = Rebound


def _extras(simulation: Any, scene: Scene) -> Any:
    parts = [load for load in scene.loads if isinstance(load, EXTRAS)]
    if not parts:
        return None
    import reboundx

    extras = reboundx.Extras(simulation)
    for part in parts:
        if isinstance(part, Relativity):
            force = extras.load_force("gr_full" if part.form == "eih" else "gr")
            force.params["c"] = part.c
        else:
            force = extras.load_force("gravitational_harmonics")
            particle = simulation.particles[scene.body_index(part.body)]
            particle.params["J2"], particle.params["R_eq"] = part.zonal[0], part.radius
        extras.add_force(force)
    return extras


def _choose(simulation: Any, plan: Plan, free_fall: float) -> None:
    name = plan.method.name
    simulation.integrator = "saba10,6,4" if name == "saba" else name
    if plan.method.kind == "fixed":
        simulation.dt = plan.step
        return
    simulation.dt = START * free_fall
    if name == "ias15":
        simulation.integrator.epsilon = plan.rtol
    else:
        simulation.integrator.eps_rel, simulation.integrator.eps_abs = plan.rtol, plan.atol
