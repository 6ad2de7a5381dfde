"""Basilisk (AVS Lab, Boulder): spacecraft about a planet at rest, fixed steps and embedded Runge-Kutta pairs in C++.

The distribution is `bsk`. Its clock counts whole nanoseconds, and a step that is none is rounded without a word: time
is therefore counted in steps here, which leaves the equations as they are. Its MuJoCo scenes ignore the gravity of
their MJCF file without a word; none is built here.
"""

# The extra has no type information.
# pyright: reportMissingImports=false

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import Basilisk  # noqa: F401 - its absence means engine-missing
import numpy as np
from Basilisk.architecture import messaging
from Basilisk.simulation import (
    dragDynamicEffector,
    exponentialAtmosphere,
    gravityEffector,
    spacecraft,
    sphericalHarmonicsGravityModel,
    svIntegrators,
    zeroWindModel,
)
from Basilisk.utilities import SimulationBaseClass

from cross_checks.engine import RTOLS, End, Engine, Loop, Method, Plan, Poses, Refusal, exponential
from cross_checks.engine.celestial import no_satellites, normalized_zonals, of_particles, planet_of
from mbs_ref import Scene
from mbs_ref.scene.celestial import Drag, Oblateness
from mbs_ref.scene.scales import attraction, is_celestial

STEPS = (4e-2, 2e-2, 1e-2, 5e-3, 2.5e-3)  # s; in free-fall times where a scene counts in these
TASK, SECOND = "step", 1_000_000_000  # ns, of its clock
SPAN = 1e6  # s of its clock that an adaptive run lasts: outputs are on it to 1e-15 of the run
HELD = "rk4_held_air"
INTEGRATORS = {
    "euler": "svIntegratorEuler", "rk2": "svIntegratorRK2", "rk4": "svIntegratorRK4", HELD: "svIntegratorRK4",
    "rkf45": "svIntegratorRKF45", "rkf78": "svIntegratorRKF78",
}  # fmt: skip
UNCOUNTED = "Basilisk does not report how many steps an adaptive method took"
METHODS = (
    Method("rk4", "fixed", 4, "classical Runge-Kutta, the default", STEPS, stability=exponential(4)),
    Method("rk2", "fixed", 2, "Heun's method", STEPS, stability=exponential(2)),
    Method("euler", "fixed", 1, "explicit Euler", STEPS, stability=exponential(1)),
    Method("rkf45", "adaptive", 5, "Runge-Kutta-Fehlberg 4(5), begun anew at every output", RTOLS),
    Method("rkf78", "adaptive", 8, "Runge-Kutta-Fehlberg 7(8), begun anew at every output", RTOLS),
    Method(HELD, "fixed", 1, "rk4; density and wind are what they were at the step's beginning", STEPS),
)


@dataclass
class Built:
    """Spacecraft, each with what acts on it; Basilisk's objects hold no references, so this one holds them."""

    scene: Scene
    unit: float  # s that a second of Basilisk's clock stands for
    spacecraft: dict[int, Any] = field(default_factory=dict)  # by the body's index
    kept: list[Any] = field(default_factory=list)
    simulation: Any = None


class BasiliskEngine(Engine):
    """Basilisk's spacecraft as test particles about one body at rest in the origin."""

    name: ClassVar[str] = "basilisk"
    package: ClassVar[str] = "Basilisk"
    distribution: ClassVar[str] = "bsk"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    part_types: ClassVar[frozenset[str]] = frozenset({"point_mass", "newton", "epoch", "oblateness", "drag"})

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        if not is_celestial(scene):
            return [Refusal("the adapter supports particles about a planet, and nothing else", False)]
        return [Refusal(reason, False) for reason in no_satellites(scene)]

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        drags = any(isinstance(load, Drag) for load in scene.loads)
        reasons = super().method_refusals(scene, method)
        if drags and method.name != HELD:
            reasons.append(Refusal(f"Basilisk holds the air through a step, which makes {method.name} one of first "
                                   f"order: that is {HELD}", True))  # fmt: skip
        if method.name == HELD and not drags:
            reasons.append(Refusal(f"{HELD} differs from rk4 only where there is air, and there is none", True))
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        fixed = plan.method.kind == "fixed"
        model = Built(scene, plan.step if fixed else float(plan.times[-1]) / SPAN)
        if fixed:  # one task that comes every second of the clock, which is a step
            model.simulation = SimulationBaseClass.SimBaseClass()
            model.simulation.CreateNewProcess("flight").addTask(model.simulation.CreateNewTask(TASK, SECOND))
        for k in range(len(scene.bodies)):
            if k != planet_of(scene):
                model.spacecraft[k] = craft = _spacecraft(model, k)
                model.kept.append(_integrator(craft, plan))
                _add_air(model, k)
                if fixed:
                    model.simulation.AddModelToTask(TASK, craft)
                else:
                    craft.Reset(0)
        if fixed:
            model.simulation.InitializeSimulation()
        return model

    def advance(self, model: Built, plan: Plan) -> Loop:
        states = np.empty((len(plan.times), len(model.spacecraft), 2, 3))
        _read(model, states[0])
        done = 0
        for k, time in enumerate(plan.times[1:].tolist(), start=1):
            if plan.method.kind == "fixed":
                done += plan.counts[k - 1]
                model.simulation.ConfigureStopTime(done * SECOND)
                model.simulation.ExecuteSimulation()
            else:
                for craft in model.spacecraft.values():
                    craft.UpdateState(round(time / model.unit * SECOND))
            _read(model, states[k])
        return Loop(states, End(len(states)), done)

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        place, rate = np.zeros((2, len(states), len(model.scene.bodies), 3))
        for at, body in enumerate(model.spacecraft):
            place[:, body], rate[:, body] = states[:, at, 0], states[:, at, 1] / model.unit
        return of_particles(place, rate)

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        return () if plan.method.kind == "fixed" else (UNCOUNTED,)


ENGINE = BasiliskEngine


def _spacecraft(model: Built, body: int) -> Any:
    """Return a particle about the planet; velocities count in the clock's seconds."""
    scene = model.scene
    craft, start = spacecraft.Spacecraft(), scene.bodies[body]
    craft.ModelTag = start.name
    craft.hub.mHub = start.mass
    craft.pointMassTranslationalOnly = not any(isinstance(load, Drag) for load in scene.loads)  # drag asks for a pose
    craft.hub.r_CN_NInit = list(start.position)
    craft.hub.v_CN_NInit = [speed * model.unit for speed in start.velocity]
    planet = _planet(model)
    craft.gravField.gravBodies = spacecraft.GravBodyVector([planet])
    model.kept.append(planet)
    return craft


def _planet(model: Built) -> Any:
    """Return the attracting body; harmonics take gm and radius from it: without its radius they are NaN."""
    scene, planet = model.scene, gravityEffector.GravBodyData()
    planet.planetName, planet.isCentralBody = "planet", True
    planet.mu = attraction(scene)[planet_of(scene)] * model.unit**2
    zonal = next((load for load in scene.loads if isinstance(load, Oblateness)), None)
    if zonal is not None:
        harmonics = sphericalHarmonicsGravityModel.SphericalHarmonicsGravityModel()
        column = normalized_zonals(zonal.zonal)
        harmonics.cBar = [[value, *(0.0,) * n] for n, value in enumerate(column)]
        harmonics.sBar = [[0.0] * (n + 1) for n in range(len(column))]
        harmonics.maxDeg = len(column) - 1
        planet.radEquator = zonal.radius
        planet.gravityModel = harmonics
        model.kept.append(harmonics)
    return planet


def _integrator(craft: Any, plan: Plan) -> Any:
    chosen = getattr(svIntegrators, INTEGRATORS[plan.method.name])(craft)
    if plan.method.kind == "adaptive":
        chosen.setRelativeTolerance(plan.rtol)
        chosen.setAbsoluteTolerance(0.0)  # its default of 1e-8 counts metres and metres a second alike
    craft.setIntegrator(chosen)
    return chosen


def _add_air(model: Built, body: int) -> None:
    """Add drag to a spacecraft; density and wind are computed at the start of a step and constant through it."""
    scene, craft = model.scene, model.spacecraft[body]
    for load in scene.loads:
        if not isinstance(load, Drag) or load.body != scene.bodies[body].name:
            continue
        air, wind, drag = (
            exponentialAtmosphere.ExponentialAtmosphere(), zeroWindModel.ZeroWindModel(),
            dragDynamicEffector.DragDynamicEffector(),
        )  # fmt: skip
        # from the ground: beneath the altitude of its base density Basilisk has no air, without a word
        air.planetRadius, air.scaleHeight = load.radius, load.scale_height
        air.baseDensity = load.density * math.exp(load.altitude / load.scale_height)
        at_rest = messaging.SpicePlanetStateMsgPayload(J20002Pfix=np.eye(3).tolist())
        planet = messaging.SpicePlanetStateMsg().write(at_rest)
        wind.planetPosInMsg.subscribeTo(planet)
        wind.setUseSpiceOmegaFlag(False)
        wind.setPlanetOmega_N([0.0, 0.0, load.spin * model.unit])
        drag.coreParams.dragCoeff, drag.coreParams.projectedArea = load.coefficient, scene.bodies[body].mass
        for model_of_air in (air, wind):
            model_of_air.addSpacecraftToModel(craft.scStateOutMsg)
        drag.atmoDensInMsg.subscribeTo(air.envOutMsgs[0])
        drag.windVelInMsg.subscribeTo(wind.envOutMsgs[0])
        craft.addDynamicEffector(drag)
        for module in (air, wind, drag):
            model.simulation.AddModelToTask(TASK, module)
        model.kept += [air, wind, drag, planet]


def _read(model: Built, row: np.ndarray) -> None:
    for at, craft in enumerate(model.spacecraft.values()):
        message = craft.scStateOutMsg.read()
        row[at] = message.r_BN_N, message.v_BN_N
