"""Newton (Linux Foundation, on NVIDIA Warp): several solvers behind one model, here on the CPU and in single precision.

The distributions are `newton` and `warp-lang`. Warp compiles each solver's kernels once, for minutes, and keeps them in
the cache folder. A step is recorded (an APIC capture) and replayed in C++, a hundred times as fast as from Python.

Not yet supported: MuJoCo-Warp, which Newton's extra `sim` brings; XPBD, whose states are poses that count no turns, and
which makes velocities of differences of positions over a step, so that rounding grows as steps shrink (seen in 1.8.0).
"""

# The extra has no type information here.
# pyright: reportMissingImports=false

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, ClassVar

version("newton")  # its absence means engine-missing, and is reported before that of Warp

import warp

from mbs_ref.kernels.jit import cache_folder

# Newton's modules read these settings of Warp when they are imported.
warp.config.log_level = warp.LOG_ERROR  # else it writes to stdout
warp.config.kernel_cache_dir = str(cache_folder() / "warp")
warp.config.enable_backward = False  # derivatives of kernels, unused: without them compiling takes a tenth

# ruff: noqa: E402
# isort: split

import newton
import numpy as np
from numba.core.event import trigger_event

from cross_checks.engine import SINGLE, STEPS, End, Loop, Method, Plan
from cross_checks.linkage.forces import LinkageEngine
from cross_checks.linkage.links import FIXED, Link, Linkage, linkage_of
from mbs_ref import Scene
from mbs_ref.scene.euler_parameters import rotation_matrices

DEVICE = "cpu"
X, Y, Z = np.eye(3)


type AddShapes = Callable[[Any, dict[int, int]], list[tuple[int, int]]]  # to a builder and its bodies, by the scene's


def model_of(linkage: Linkage, add_shapes: AddShapes | None = None) -> tuple[Any, list[tuple[int, int]]]:
    """Return the model and the pairs of its shapes that may touch; each tree is an articulation.

    The joints of an articulation have to be numbered in one piece. The check of inertias is left out: it adds
    1e-6 kg m^2 to bodies that have none, as point masses do.
    """
    builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=tuple(linkage.gravity))
    bodies = {FIXED: -1}
    for tree in trees_of(linkage):
        joints = []
        for link in tree:
            bodies[link.body] = builder.add_link(
                xform=warp.transform(link.origin, warp.quat_identity()), mass=link.mass,
                com=warp.vec3(*link.centre), inertia=warp.mat33(*link.inertia.ravel()), lock_inertia=True,
                label=link.name,
            )  # fmt: skip
            joint = _add_joint(builder, bodies[link.parent], bodies[link.body], linkage, link)
            start = builder.joint_qd_start[joint]
            builder.joint_qd[start : start + len(link.rates)] = link.rates.tolist()
            joints.append(joint)
        builder.add_articulation(joints)
    pairs = add_shapes(builder, bodies) if add_shapes else []
    return builder.finalize(device=DEVICE, skip_validation_inertia=True), pairs


def trees_of(linkage: Linkage) -> list[list[Link]]:
    """Return the links tree by tree, each after its parent."""
    trees: dict[int, list[Link]] = {}
    root: dict[int, int] = {}
    for link in linkage.links:
        root[link.body] = link.body if link.parent == FIXED else root[link.parent]
        trees.setdefault(root[link.body], []).append(link)
    return list(trees.values())


def _axis(direction: np.ndarray) -> Any:
    return newton.ModelBuilder.JointDofConfig(axis=warp.vec3(*direction), armature=0.0, friction=0.0, damping=0.0)


def _add_joint(builder: Any, parent: int, child: int, linkage: Linkage, link: Link) -> int:
    """Add the joint, whose frames stand along the world's axes at t = 0; return its number."""
    place = {"parent_xform": warp.transform(link.origin - linkage.origin(link.parent), warp.quat_identity())}
    still = {"armature": 0.0, "friction": 0.0, "damping": 0.0}
    if link.kind == "weld":
        return builder.add_joint_fixed(parent, child, **place)
    if link.kind == "free":
        return builder.add_joint_free(child, parent=parent)
    if link.kind == "ball":
        return builder.add_joint_ball(parent, child, **still, **place)
    if link.kind in ("revolute", "prismatic"):
        return getattr(builder, f"add_joint_{link.kind}")(parent, child, axis=_axis(link.axes[0]), **place)
    slides, turns = {
        "universal": ((), link.axes), "cylindrical": (link.axes[:1], link.axes[1:]), "planar": ((X, Y), (Z,)),
    }[link.kind]  # fmt: skip
    sliding, turning = map(_axis, slides), map(_axis, turns)
    return builder.add_joint_d6(parent, child, linear_axes=list(sliding), angular_axes=list(turning), **place)


def row_of(state: Any) -> np.ndarray:
    """Return coordinates, their rates, poses and velocities, one after the other."""
    parts = (state.joint_q, state.joint_qd, state.body_q, state.body_qd)
    return np.concatenate([part.numpy().ravel() for part in parts], dtype=float)


class Reader:
    """Reads rows as `row_of` makes them; velocities are those of centres of mass."""

    def __init__(self, linkage: Linkage, model: Any) -> None:
        links = [link for tree in trees_of(linkage) for link in tree]
        self.split = np.cumsum([model.joint_coord_count, model.joint_dof_count, 7 * model.body_count])
        self.order = np.argsort([link.body for link in links])  # of Newton's bodies, in the scene
        self.centres = np.array([links[k].centre for k in self.order])
        numbers = {link.body: k for k, link in enumerate(links)}
        counted = [(numbers[link.body], k) for link in linkage.links for k in range(link.size)]
        starts = model.joint_q_start.numpy(), model.joint_qd_start.numpy()
        self.places, self.rates = ([int(start[joint]) + k for joint, k in counted] for start in starts)

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        q, v, *_ = np.split(state, self.split)
        return q[self.places], v[self.rates]

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        *_, poses, twists = np.split(state, self.split)
        place, twist = poses.reshape(-1, 7)[self.order], twists.reshape(-1, 6)[self.order]
        theta = place[:, [6, 3, 4, 5]]
        turn = rotation_matrices(theta / np.linalg.norm(theta, axis=1, keepdims=True))
        centre = place[:, :3] + np.einsum("nij,nj->ni", turn, self.centres)
        return turn, centre, twist[:, :3], twist[:, 3:]


FEATHERSTONE = "featherstone"
FLOAT32 = "Newton computes in single precision: n steps leave up to 6e-8 n of rounding"
METHODS = (Method(FEATHERSTONE, "fixed", 1, "symplectic Euler on joint coordinates", STEPS, roundoff=SINGLE),)
SOLVERS: dict[str, tuple[str, dict[str, Any]]] = {  # class, options
    FEATHERSTONE: ("SolverFeatherstone", {"angular_damping": 0.0})  # 0.05 by default, which 1.8.0 does not read
}


@dataclass
class Built:
    """A model, its solver, two states that take turns, and the recorded steps from one to the other."""

    linkage: Linkage
    model: Any
    solver: Any
    states: tuple[Any, Any]
    reader: Reader
    pipeline: Any  # of collisions, and the contacts that it finds; None without
    contacts: Any
    steps: tuple[Any, ...] = ()


class Newton(LinkageEngine):
    """Newton's solvers of articulated bodies."""

    name: ClassVar[str] = "newton"
    package: ClassVar[str] = "newton"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    takes_loads: ClassVar[bool] = False

    def build(self, scene: Scene, plan: Plan) -> Built:
        return self.built(linkage_of(scene), plan)

    def built(self, linkage: Linkage, plan: Plan, add_shapes: AddShapes | None = None) -> Built:
        """Return what steps a linkage, and finds the contacts of pairs of shapes where there are any."""
        kind, options = SOLVERS[plan.method.name]
        with trigger_event("numba:compile"):  # who waits for a run sees that it compiles
            model, pairs = model_of(linkage, add_shapes)
            solver = getattr(newton.solvers, kind)(model, **options)
            pipeline = contacts = None
            if pairs:
                listed = warp.array(pairs, dtype=warp.vec2i, device=DEVICE)
                pipeline = newton.CollisionPipeline(model, broad_phase="explicit", shape_pairs_filtered=listed)
                contacts = pipeline.contacts()
            states = model.state(), model.state()
            built = Built(linkage, model, solver, states, Reader(linkage, model), pipeline, contacts)
            _to_start(built)
        return built

    def first_call(self, model: Built, plan: Plan) -> None:
        """Compile, and record a step from each state to the other; recording makes none."""
        here, there = model.states
        control = model.model.control()

        def step(before: Any, after: Any) -> None:
            if model.pipeline is not None:
                model.pipeline.collide(before, model.contacts)
            model.solver.step(before, after, control, model.contacts, plan.step)

        with trigger_event("numba:compile"):
            step(here, there)
        recorded = []
        for before, after in ((here, there), (there, here)):
            with warp.ScopedCapture(device=DEVICE) as capture:
                step(before, after)
            recorded.append(capture.graph)
        model.steps = tuple(recorded)
        _to_start(model)

    def advance(self, model: Built, plan: Plan) -> Loop:
        states = np.empty((len(plan.times), row_of(model.states[0]).size))
        states[0] = row_of(model.states[0])
        done = 0
        for k, count in enumerate(plan.counts, start=1):
            for _ in range(count):
                warp.capture_launch(model.steps[done % 2])
                done += 1
            states[k] = row_of(model.states[done % 2])
        return Loop(states, End(len(states)), done, done)

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        return (FLOAT32,)


ENGINE = Newton


def _to_start(built: Built) -> None:
    model = built.model
    for state in built.states:
        state.assign(model.state())
        newton.eval_fk(model, model.joint_q, model.joint_qd, state)
