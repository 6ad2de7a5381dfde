"""MuJoCo's methods with every option pinned, its loop, and its silent resets."""

from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco import rollout

from cross_checks.engine import End, Method, Plan, exponential, fixed
from cross_checks.linkage.links import Linkage
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Status

INTEGRATORS = {
    "rk4": (mujoco.mjtIntegrator.mjINT_RK4, 4, "explicit Runge-Kutta 4"),
    "euler": (mujoco.mjtIntegrator.mjINT_EULER, 1, "semi-implicit Euler, joint damping implicit"),
    "implicit": (mujoco.mjtIntegrator.mjINT_IMPLICIT, 1, "implicit in velocity, with Coriolis terms"),
    "implicitfast": (mujoco.mjtIntegrator.mjINT_IMPLICITFAST, 1, "implicit in velocity, without Coriolis terms"),
}
DEFAULT_SOLREF = (0.02, 1.0)  # s, damping ratio: MuJoCo's default, pinned
TIGHT = "_tight"
# How much is lost depends on which joints close the loops: A02 loses 1.4 J over this tree, 7.1 J over a serial one.
SOFT = (
    "loop closures and rods in space are springs of 0.02 s time constant whatever the step: "
    "the energy of a loop is lost at every step; "
    "friction raises the normal force of a contact that slides"
)
SOFTENED = frozenset({"closed-loop", "rod-in-space", "friction"})
STEP_SOFT = "loop closures and rods in space are springs whose time constant is two steps"


def _methods() -> tuple[Method, ...]:
    plain = [
        fixed(n, p, text, stability=exponential(p), wrong_limit=SOFT, weak_on=SOFTENED)
        for n, (_, p, text) in INTEGRATORS.items()
    ]  # what is implicit bears more, but shared forces are explicit in all
    tight = [
        fixed(m.name + TIGHT, None, f"{m.description}; {STEP_SOFT}") for m in plain if m.name in ("rk4", "implicitfast")
    ]
    return (*plain, *tight)


METHODS = _methods()


def pin_options(spec: mujoco.MjSpec, plan: Plan, scene: Scene) -> None:
    """Leave no option to a default that a release may change."""
    spec.compiler.degree = False  # else a spring's rest angle is read as degrees
    option = spec.option
    option.timestep = plan.step
    option.integrator = INTEGRATORS[plan.method.name.removesuffix(TIGHT)][0]
    option.gravity = tuple(np.resize((*scene.gravity, 0.0), 3))
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.tolerance, option.iterations, option.ls_tolerance, option.ls_iterations = 1e-15, 200, 0.01, 50
    option.noslip_iterations, option.impratio = 0, 1.0
    option.cone, option.jacobian = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtJacobian.mjJAC_DENSE
    option.wind, option.density, option.viscosity = (0.0, 0.0, 0.0), 0.0, 0.0
    flags = mujoco.mjtDisableBit
    # without warm starts a run repeats bit for bit
    option.disableflags = int(flags.mjDSBL_WARMSTART) | (0 if scene.contacts else int(flags.mjDSBL_CONTACT))
    # without it the effective mass of a jointed body is guessed, and was seen wrong by 7.5x
    option.enableflags = int(mujoco.mjtEnableBit.mjENBL_DIAGEXACT) if scene.contacts else 0
    spec.compiler.autolimits = False


def solref_of(plan: Plan) -> tuple[float, float]:
    return (2.0 * plan.step, 1.0) if plan.method.name.endswith(TIGHT) else DEFAULT_SOLREF


if mujoco.get_mju_user_warning() is None:  # else every warning is added to a file in the user's folder
    mujoco.set_mju_user_warning(lambda message: None)  # they are counted in MjData, where `clock_end` reads them


def at_start(model: mujoco.MjModel, linkage: Linkage) -> mujoco.MjData:
    """Return the data at t = 0, where all coordinates are the model's reference."""
    data = mujoco.MjData(model)
    data.qvel[:] = linkage.rates
    return data


@dataclass(frozen=True)
class Left:
    """What the loop read at the output times."""

    states: np.ndarray  # (n_t, n_q + n_v)
    clock: np.ndarray  # (n_t,) s, what MuJoCo's own clock showed


def advance(model: mujoco.MjModel, data: mujoco.MjData, plan: Plan) -> Left:
    """Step through the output times; each interval is one call into C."""
    nq, qpos, qvel = model.nq, data.qpos, data.qvel
    left = Left(np.empty((len(plan.times), nq + model.nv)), np.empty(len(plan.times)))
    places, speeds, clock = left.states[:, :nq], left.states[:, nq:], left.clock
    places[0], speeds[0], clock[0] = qpos, qvel, data.time
    for k, count in enumerate(plan.counts, start=1):
        mujoco.mj_step(model, data, nstep=count)
        places[k], speeds[k], clock[k] = qpos, qvel, data.time
    return left


def clock_end(data: mujoco.MjData, clock: np.ndarray, plan: Plan) -> End:
    """Return where MuJoCo restarted: a bad state sends its clock back to 0 without an exception, and is counted.

    Other warnings (a full buffer) leave the clock alone: then only the start is vouched for.
    """
    late = np.abs(clock - plan.times) > 0.5 * plan.step
    counts = {mujoco.mjtWarning(k).name: int(w.number) for k, w in enumerate(data.warning) if w.number}
    if not late.any():
        return End(1, Status.ENGINE_ERROR, f"mujoco warned on the way: {counts}") if counts else End(len(plan.times))
    k = int(np.argmax(late))
    warned = f", with the warnings {counts}" if counts else ""
    where = f"before t = {plan.times[k]:g} s and reports t = {clock[k]:g} s"
    return End(k, Status.RESET, f"mujoco reset its state {where}{warned}")


def rolled_out(model: mujoco.MjModel, states: np.ndarray, steps: int, threads: int) -> np.ndarray:
    """Return positions and rates (n, n_q + n_v) so many steps after each of n, by MuJoCo's own batches in C."""
    data = [mujoco.MjData(model) for _ in range(threads)]
    started = np.column_stack((np.zeros(len(states)), states))  # with the clock, as MuJoCo has a full state
    after, _ = rollout.rollout(model, data, started, nstep=steps, persistent_pool=True)
    return np.asarray(after)[:, -1, 1:]
