"""Twenty random requests to `mbs-ref contact`, measured without any of the code that translates and measures them.

Each engine runs the lines that the command prints for it. Its model is built here from its own documentation, and
rebound, duration and penetration are read from its coordinates.
"""

# Drake has no type information here.
# pyright: reportMissingImports=false

import json
import re
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from reports.cli import main

REQUESTS, ALLOWED = 20, 0.02  # -, relative
RADIUS, FLIGHT = 0.1, 12.37  # m, steps


def _requests() -> list[dict[str, float]]:
    """Return requests whose impacts last 60 to 300 steps."""
    random, found = np.random.default_rng(46), []
    for _ in range(REQUESTS):
        stiffness, mass = 10.0 ** random.uniform(3.0, 6.0), 10.0 ** random.uniform(-1.0, 1.3)
        step = np.pi * np.sqrt(mass / stiffness) / random.uniform(60.0, 300.0)
        values = {"rebound": random.uniform(0.1, 1.0), "friction": random.uniform(0.05, 1.2), "stiffness": stiffness,
                  "mass": mass, "speed": random.uniform(0.2, 3.0), "step": step}  # fmt: skip
        found.append({name: float(f"{value:.6g}") for name, value in values.items()})
    return found


def _mjcf(request: dict[str, float], snippet: str) -> Any:
    """Return MuJoCo's model of a sphere above a fixed one, with the printed option and pair."""
    import mujoco

    option = re.search(r"<option.*</option>", snippet)
    pair = re.search(r"<pair[^>]*/>", snippet)
    assert option
    assert pair
    sphere = f'type="sphere" size="{RADIUS}" contype="0" conaffinity="0"'
    height = 2.0 * RADIUS + FLIGHT * request["step"] * request["speed"]
    text = f"""<mujoco>{option[0].replace("<option", '<option gravity="0 0 0"')}<worldbody><geom name="A" {sphere}/>
      <body pos="0 0 {height:.17g}"><joint type="slide" axis="0 0 1"/><geom name="B" {sphere} mass="{request["mass"]}"/>
      </body></worldbody><contact>{pair[0]}</contact></mujoco>"""
    return mujoco.MjModel.from_xml_string(text)


def _mujoco(request: dict[str, float], snippet: str) -> np.ndarray:
    """Return the gaps (n,), m, at every step of a sphere against a fixed one."""
    import mujoco

    model = _mjcf(request, snippet)
    data: Any = mujoco.MjData(model)
    data.qvel[0] = -request["speed"]
    gaps = [FLIGHT * request["step"] * request["speed"]]
    for _ in range(900):
        mujoco.mj_step(model, data)
        gaps.append(gaps[0] + data.qpos[0])
    return np.array(gaps)


def _mjx(request: dict[str, float], snippet: str) -> np.ndarray:
    """Return the same by MJX."""
    import jax
    import mujoco
    from mujoco import mjx

    jax.config.update("jax_enable_x64", True)
    model = _mjcf(request, snippet)
    data: Any = mujoco.MjData(model)
    data.qvel[0] = -request["speed"]
    there, state = mjx.put_model(model), mjx.put_data(model, data)
    step = jax.jit(mjx.step)
    gaps = [FLIGHT * request["step"] * request["speed"]]
    for _ in range(900):
        state = step(there, state)
        gaps.append(gaps[0] + float(state.qpos[0]))
    return np.array(gaps)


def _newton(request: dict[str, float], snippet: str) -> np.ndarray:
    """Return the same of two spheres of Newton, the lower one on a body fixed to the world, by the printed line."""
    import newton
    import warp

    known: dict[str, Any] = {"newton": newton}
    exec(snippet, known)
    known["material"].density = 0.0
    builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=(0.0, 0.0, 0.0))
    place, unit = warp.transform((0.0, 0.0, 2.0 * RADIUS), warp.quat_identity()), warp.mat33(np.eye(3))
    lower, upper = (builder.add_link(mass=request["mass"], inertia=unit, lock_inertia=True) for _ in range(2))
    builder.add_articulation([builder.add_joint_fixed(-1, lower)])
    builder.add_articulation([builder.add_joint_prismatic(-1, upper, parent_xform=place, axis=newton.Axis.Z)])
    for body in (lower, upper):
        builder.add_shape_sphere(body, radius=RADIUS, cfg=known["material"])
    builder.joint_q, builder.joint_qd = [FLIGHT * request["step"] * request["speed"]], [-request["speed"]]
    model = builder.finalize(device="cpu")
    solver, pipeline = newton.solvers.SolverFeatherstone(model), newton.CollisionPipeline(model)
    here, there, contacts, control = model.state(), model.state(), pipeline.contacts(), model.control()
    newton.eval_fk(model, model.joint_q, model.joint_qd, here)
    gaps = [float(here.joint_q.numpy()[0])]
    for _ in range(900):
        pipeline.collide(here, contacts)
        solver.step(here, there, control, contacts, request["step"])
        here, there = there, here
        gaps.append(float(here.joint_q.numpy()[0]))
    return np.array(gaps)


def _exudyn(request: dict[str, float], snippet: str) -> np.ndarray:
    """Return the same of two spheres of Exudyn's GeneralContact, by the printed lines."""
    import exudyn as exu
    import exudyn.itemInterface as item

    exu.config.printToConsole = False
    system = exu.SystemContainer().AddSystem()
    height, ground = FLIGHT * request["step"] * request["speed"], system.AddObject(item.ObjectGround())
    node = system.AddNode(item.NodePoint(referenceCoordinates=[0, 0, 2 * RADIUS + height],
                                         initialVelocities=[0, 0, -request["speed"]]))  # fmt: skip
    body = system.AddObject(item.ObjectMassPoint(mass=request["mass"], nodeNumber=node))
    known: dict[str, Any] = {"np": np, "mbs": system, "radius": RADIUS}
    marks = [system.AddMarker(item.MarkerBodyPosition(bodyNumber=number)) for number in (ground, body)]
    exec(snippet, known | {"marker": marks[0]}, known)
    again = snippet[snippet.index("contact.AddSphereWithMarker") : snippet.index("# against triangles")]
    exec(again, known | {"marker": marks[1]})
    known["contact"].SetSearchTreeCellSize([2, 2, 2])
    known["contact"].SetSearchTreeBox([-1, -1, -1], [1, 1, 1])
    sensor = system.AddSensor(
        item.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=exu.OutputVariableType.Position)
    )
    system.Assemble()
    options = exu.SimulationSettings()
    options.solution.file.write = False
    time = options.timeIntegration
    time.verboseMode, time.adaptiveStep, time.automaticStepSize = 0, False, False
    time.numberOfSteps, time.endTime = 900, 900 * request["step"]
    options.solution.sensors.writePeriod = request["step"]
    assert system.SolveDynamic(options, solverType=exu.DynamicSolverType.RK44)
    return np.asarray(system.GetSensorStoredData(sensor), dtype=float)[:, 3] - 2.0 * RADIUS


def _drake(request: dict[str, float], snippet: str) -> np.ndarray:
    """Return the same of two spheres of Drake, the lower one of the world, by the printed lines."""
    from pydrake import geometry
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, DiscreteContactApproximation
    from pydrake.multibody.tree import PrismaticJoint, SpatialInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    builder: Any = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, request["step"])
    names = {"plant": plant, "DiscreteContactApproximation": DiscreteContactApproximation}
    known: dict[str, Any] = names | {"CoulombFriction": CoulombFriction} | vars(geometry)
    exec(snippet, known)
    mass, height = request["mass"], 2.0 * RADIUS + FLIGHT * request["step"] * request["speed"]
    body = plant.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(mass, RADIUS))
    slide = plant.AddJoint(PrismaticJoint("slide", plant.world_frame(), body.body_frame(), np.array([0.0, 0.0, 1.0])))
    for owner in (plant.world_body(), body):
        sphere = geometry.Sphere(RADIUS)
        plant.RegisterCollisionGeometry(owner, RigidTransform(), sphere, "sphere", known["properties"])
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    slide.set_translation(context, height)
    slide.set_translation_rate(context, -request["speed"])
    gaps = [slide.get_translation(context) - 2.0 * RADIUS]
    for k in range(900):
        simulator.AdvanceTo((k + 0.5) * request["step"])  # an update belongs to the time where it begins
        gaps.append(slide.get_translation(context) - 2.0 * RADIUS)
    return np.array(gaps)


def _figures(gaps: np.ndarray, step: float, speed: float) -> dict[str, float]:
    """Return rebound, duration (s) and penetration (m) of gaps at every step; flights before and after are straight."""
    inside = np.flatnonzero(gaps < 0.0)
    first, last = int(inside[0]), int(inside[-1])
    leaving = (gaps[last + 2] - gaps[last + 1]) / step
    duration = (last + 1 - gaps[last + 1] / leaving / step) * step - gaps[0] / speed
    k = int(np.argmin(gaps))
    a, b, c = gaps[k - 1 : k + 2]
    assert first > 0
    return {
        "restitution": leaving / speed,
        "duration, s": duration,
        "penetration, m": -b + 0.125 * (a - c) ** 2 / (a - 2.0 * b + c),  # top of the parabola through three
    }


RUNS = {"mujoco": _mujoco, "mjx": _mjx, "exudyn": _exudyn, "drake": _drake, "newton": _newton}


def measured(request: dict[str, float], engine: str) -> tuple[dict[str, tuple[float, float]], list[str]]:
    """Return requested and obtained figures of an engine, and the names of those that the command refuses."""
    options = [f"--{name}={value:.17g}" for name, value in request.items()]
    result = CliRunner().invoke(main, ["contact", *options, "--engine", engine, "--json"])
    assert result.exit_code == 0, result.output
    printed = json.loads(result.stdout.splitlines()[0])
    own = _figures(RUNS[engine](request, printed["snippet"]), request["step"], request["speed"])
    wanted = {row["figure"]: row["requested"] for row in printed["figures"] if row["figure"] in own}
    refused = [row["figure"] for row in printed["figures"] if row["note"].startswith("cannot")]
    return {name: (wanted[name], own[name]) for name in wanted}, refused


@pytest.mark.slow
@pytest.mark.parametrize("engine", RUNS)
def test_an_engine_obtains_what_was_requested(engine):
    pytest.importorskip({"drake": "pydrake", "mjx": "mujoco.mjx"}.get(engine, engine))
    for request in _requests():
        figures, refused = measured(request, engine)
        for name, (requested, obtained) in figures.items():
            assert name in refused or abs(obtained / requested - 1.0) < ALLOWED, (request, name, requested, obtained)


if __name__ == "__main__":
    for engine in RUNS:
        for request in _requests():
            figures, refused = measured(request, engine)
            print(
                engine,
                *(
                    f"{name}: {b / a - 1.0:+.2%}{' refused' if name in refused else ''}"
                    for name, (a, b) in figures.items()
                ),
            )
