"""MuJoCo: joints in a tree are exact minimal coordinates; loop closures are always soft constraints.

In its model of a scene frames stand along the world's axes at t = 0.
"""

from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np
from mujoco import rollout

from cross_checks.engine import End, Loop, Method, Plan, Poses, Refusal, end_of, exponential, fixed
from cross_checks.engines.mujoco_ import forces
from cross_checks.engines.mujoco_.contact import add_contact
from cross_checks.engines.mujoco_.forces import LOADS, Callback, Observer, add_tendon, passive
from cross_checks.linkage.forces import LinkageEngine
from cross_checks.linkage.links import FIXED, Closure, Link, Linkage, closure_refusals, linkage_of
from cross_checks.linkage.motion import poses_of, tree_reactions
from mbs_ref import Scene, Settings, Status
from mbs_ref.scene.euler_parameters import from_matrix
from mbs_ref.scene.joints import Drive

INTEGRATORS = {
    "rk4": (mujoco.mjtIntegrator.mjINT_RK4, 4, "explicit Runge-Kutta 4"),
    "euler": (mujoco.mjtIntegrator.mjINT_EULER, 1, "semi-implicit Euler, joint damping implicit"),
    "implicit": (mujoco.mjtIntegrator.mjINT_IMPLICIT, 1, "implicit in velocity, with Coriolis terms"),
    "implicitfast": (mujoco.mjtIntegrator.mjINT_IMPLICITFAST, 1, "implicit in velocity, without Coriolis terms"),
}
DEFAULT_SOLREF = (0.02, 1.0)  # s, damping ratio: MuJoCo's default, pinned
TIGHT = "_tight"
NO_DRIVE = "MuJoCo prescribes motions of mocap bodies alone, which its constraints see at rest"
# How much is lost depends on which joints close the loops: A02 loses 1.4 J over this tree, 7.1 J over a serial one.
SOFT = (
    "loop closures and rods in space are springs of 0.02 s time constant whatever the step: "
    "the energy of a loop is lost at every step"
)
SOFTENED = frozenset({"closed-loop", "rod-in-space"})
RAISED = "friction raises the normal force of a contact that slides", frozenset({"friction"})
STEP_SOFT = "loop closures and rods in space are springs whose time constant is two steps"


METHODS = (
    *(  # what is implicit bears more, but shared forces are explicit in all
        fixed(name, p, text, stability=exponential(p), wrong_limit=SOFT, weak_on=SOFTENED, weak_also=(RAISED,))
        for name, (_, p, text) in INTEGRATORS.items()
    ),
    *(fixed(name + TIGHT, None, f"{INTEGRATORS[name][2]}; {STEP_SOFT}") for name in ("rk4", "implicitfast")),
)


def pin_options(spec: mujoco.MjSpec, plan: Plan, scene: Scene) -> None:
    """Set every option whose default a release may change."""
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


JOINTS = {
    "free": mujoco.mjtJoint.mjJNT_FREE, "ball": mujoco.mjtJoint.mjJNT_BALL, "slide": mujoco.mjtJoint.mjJNT_SLIDE,
    "turn": mujoco.mjtJoint.mjJNT_HINGE,
}  # fmt: skip
LEAST_MOMENT = 2.0 * mujoco.mjMINVAL  # kg m^2, of a particle on a rod: MuJoCo takes nothing smaller


def specify_links(linkage: Linkage, plan: Plan) -> tuple[mujoco.MjSpec, dict]:
    """Return a specification of all links and closures, and the frame of each body in it."""
    spec = mujoco.MjSpec()
    pin_options(spec, plan, linkage.scene)
    frames = {FIXED: spec.worldbody}
    for link in linkage.links:
        frames[link.body] = _add_body(frames[link.parent], linkage, link)
    solref = (2.0 * plan.step, 1.0) if plan.method.name.endswith(TIGHT) else DEFAULT_SOLREF
    for closure in linkage.closures:
        _add_closure(spec, frames, linkage, closure, solref)
    return spec, frames


def add_loads(spec, frames, linkage: Linkage, shared: bool) -> None:
    """Add the loads; `shared` forces come from their callback with the weight."""
    if shared:
        spec.option.gravity = (0.0, 0.0, 0.0)
        return
    for load in linkage.scene.loads:
        LOADS[type(load)](spec, frames, linkage, load)


def compile_links(linkage: Linkage, plan: Plan, shared: bool) -> mujoco.MjModel:
    """Return the model; with `shared` forces, their callback applies all loads, contacts and the weight."""
    spec, frames = specify_links(linkage, plan)
    add_loads(spec, frames, linkage, shared)
    for contact in () if shared else linkage.scene.contacts:
        add_contact(spec, frames, linkage, contact)
    return spec.compile()


def _add_body(parent: mujoco.MjsBody, linkage: Linkage, link: Link) -> mujoco.MjsBody:
    frame = parent.add_body(name=link.name, pos=link.origin - linkage.origin(link.parent))
    moments, axes = np.linalg.eigh(link.inertia)
    moments = np.maximum(moments, LEAST_MOMENT)
    moments[2] = min(moments[2], moments[0] + moments[1])  # a plate's roundoff would be refused
    frame.explicitinertial, frame.mass, frame.inertia = True, link.mass, moments
    frame.ipos, frame.iquat = link.centre, from_matrix(np.linalg.det(axes) * axes)
    for k, (kind, axis) in enumerate(link.freedoms):
        frame.add_joint(name=f"{link.name}/{k}", type=JOINTS[kind], **({"axis": axis} if axis.any() else {}))
    return frame


def _add_closure(spec, frames, linkage: Linkage, closure: Closure, solref: tuple[float, float]) -> None:
    """Tie two bodies by soft constraints."""
    names = {FIXED: "world"} | {link.body: link.name for link in linkage.links}
    if closure.kind == "rod":
        ends = ((closure.a, closure.point_a), (closure.b, closure.point_b))
        tendon = add_tendon(spec, frames, closure.name, [(body, point - linkage.origin(body)) for body, point in ends])
        rows = [spec.add_equality(name=closure.name, type=mujoco.mjtEq.mjEQ_TENDON, name1=tendon.name)]
        rows[0].data[0] = closure.length - float(np.linalg.norm(closure.point_b - closure.point_a))
    else:
        weld = closure.kind == "weld"
        ends = (closure.b, closure.a) if weld else (closure.a, closure.b)  # the anchor is in body 2 of a weld, else 1
        ends = [names[end] for end in ends]
        kind = mujoco.mjtEq.mjEQ_WELD if weld else mujoco.mjtEq.mjEQ_CONNECT
        rows = []
        for k, point in enumerate(closure.shared_points):
            row = spec.add_equality(name=f"{closure.name}/{k}", type=kind, objtype=mujoco.mjtObj.mjOBJ_BODY)
            row.name1, row.name2 = ends
            row.data[0:3] = point - linkage.origin(closure.a)
            if weld:
                row.data[10] = 1.0  # m/rad, torque scale
            rows.append(row)
    for row in rows:
        row.active, row.solref = True, solref


@dataclass(frozen=True)
class Built:
    """A MuJoCo model, its state at t = 0, and the forces it calls Python for."""

    linkage: Linkage
    model: mujoco.MjModel
    data: mujoco.MjData
    applied: Callback | None  # of a tree the shared forces, else loads that vary in time


class MuJoCo(LinkageEngine):
    """MuJoCo through MjSpec, every option pinned, the loop in C."""

    name: ClassVar[str] = "mujoco"
    package: ClassVar[str] = "mujoco"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    as_shipped: ClassVar[Settings | None] = Settings(method="euler", step=2e-3)
    extra: ClassVar[frozenset[str]] = frozenset({"stick_slip"})
    closes: ClassVar[frozenset[str]] = frozenset({"point", "hinge", "weld", "rod"})
    no_equivalent: ClassVar[dict[str, str]] = {
        drive.model_fields["type"].default: NO_DRIVE for drive in Drive.__subclasses__()
    }

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        return closure_refusals(self.name, scene, self.closes) + forces.force_refusals(linkage_of(scene))

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if method.name.endswith(TIGHT) and not reasons and not linkage_of(scene).closures:
            reasons.append(Refusal(f"{method.name} differs only where a joint closes a loop, and none does", True))
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        linkage = linkage_of(scene)
        shared = forces.takes_shared_forces(linkage)
        model = compile_links(linkage, plan, shared)
        return Built(linkage, model, at_start(model, linkage), forces.shared_forces(model, linkage) if shared else None)

    def first_call(self, model: Built, plan: Plan) -> None:
        with passive(model.applied):
            mujoco.mj_step(model.model, at_start(model.model, model.linkage))

    def advance(self, model: Built, plan: Plan) -> Left:
        """Step through the output times; each interval is one call into C."""
        nq, data, qpos, qvel = model.model.nq, model.data, model.data.qpos, model.data.qvel
        left = Left(np.empty((len(plan.times), nq + model.model.nv)), np.empty(len(plan.times)))
        places, speeds, clock = left.states[:, :nq], left.states[:, nq:], left.clock
        places[0], speeds[0], clock[0] = qpos, qvel, data.time
        with passive(model.applied):
            for k, count in enumerate(plan.counts, start=1):
                mujoco.mj_step(model.model, data, nstep=count)
                places[k], speeds[k], clock[k] = qpos, qvel, data.time
        return left

    def collect(self, model: Built, plan: Plan, left: Left) -> Loop:
        end = end_of(left.states, plan.times, clock_end(model.data, left.clock, plan))
        steps = sum(plan.counts[: max(0, end.samples - 1)])
        stages = 4 if model.model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4 else 1
        return Loop(left.states, end, steps, steps * stages)

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        observer = Observer(model.model, model.linkage)
        with passive(model.applied):
            return poses_of(model.linkage, observer.motions(plan.times[: len(states)], states))

    def reactions(self, model: Built, plan: Plan, states: np.ndarray, poses: Poses) -> dict[str, np.ndarray]:
        """Return none where MuJoCo's own tendons and actuators act: cfrc_int leaves them out."""
        if model.linkage.loaded and (model.applied is None or model.linkage.closures):
            return {}
        with passive(model.applied):
            wrench = Observer(model.model, model.linkage).wrenches(plan.times[: len(states)], states)
        return tree_reactions(model.linkage, poses, wrench)

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        return () if model.linkage.closures else super().notes(model, plan)


ENGINE = MuJoCo
