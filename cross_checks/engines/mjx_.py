"""MJX: MuJoCo's equations written in JAX, here in double precision on the CPU.

The model is MuJoCo's own, compiled by the adapter of MuJoCo; MJX takes it over or names what it lacks.
"""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass
from typing import Any, ClassVar

# the first, for its absence is what says that the extra is not installed
import mujoco.mjx as mjx

# isort: split
import jax
import mujoco
import numpy as np

from cross_checks.engine import End, Loop, Method, Plan, Poses, Refusal
from cross_checks.engines.mujoco_ import METHODS as OF_MUJOCO
from cross_checks.engines.mujoco_ import Built, MuJoCo, at_start, compile_links
from cross_checks.engines.mujoco_.forces import own_refusals
from cross_checks.linkage.links import Linkage, closure_refusals, linkage_of
from mbs_ref import Scene

jax.config.update("jax_enable_x64", True)  # else everything is in single precision, without a word

METHODS = tuple(m for m in OF_MUJOCO if m.name != "implicit")  # an integrator that MJX lacks
# rk4 is of order 2 where quaternions turn (3.17); MuJoCo documents 4, and the judge says what it finds

# MJX lacks mjENBL_DIAGEXACT: the effective mass is a mean over directions, 1.5 of what it is in the plane
GUESSED = "mjx guesses the effective mass of a contact, rightly for bodies that are free in space alone"


@jax.jit
def _steps(model: Any, data: Any, counts: Any) -> Any:
    """Return positions and rates (n, n_q + n_v) after each of n counts of steps, compiled once for a model and n."""

    def step(_: int, state: Any) -> Any:
        # in double precision some of its integers grow to 64 bits, which a loop does not bear
        return jax.tree.map(lambda old, new: new.astype(old.dtype), state, mjx.step(model, state))

    def interval(state: Any, count: Any) -> Any:
        after = jax.lax.fori_loop(0, count, step, state)
        return after, jax.numpy.concatenate((after.qpos, after.qvel))

    return jax.lax.scan(interval, data, counts)[1]


@dataclass(frozen=True)
class Copied(Built):
    """A MuJoCo model without forces from Python, its copy in JAX, and the state there at t = 0."""

    copy: Any
    start: Any


class Mjx(MuJoCo):
    """MJX in double precision, each run one compiled call."""

    name: ClassVar[str] = "mjx"
    package: ClassVar[str] = "mujoco.mjx"
    distribution: ClassVar[str] = "mujoco-mjx"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    as_shipped: ClassVar[None] = None
    lacks: ClassVar[frozenset[str]] = frozenset(
        {"bushing", "point_bushing", "user_force", "circle_on_line", "circle_on_circle", "pin_on_sprocket"}
        | {"progressive_law", "hunt_crossley_law", "regularised_coulomb", "rolling_friction"}
    )

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        found = closure_refusals(self.name, scene, self.closes) + own_refusals(linkage_of(scene))
        if scene.dimension == 2 and scene.contacts:
            found.append(Refusal(GUESSED, permanent=True))
        return [Refusal(r.reason.replace("mujoco", "mjx"), r.permanent) for r in found]

    def build(self, scene: Scene, plan: Plan) -> Copied:
        linkage = linkage_of(scene)
        return copied(linkage, compile_links(linkage, plan, shared=False))

    def first_call(self, model: Copied, plan: Plan) -> None:
        """Compile, which takes seconds."""
        jax.block_until_ready(_steps(model.copy, model.start, np.zeros(len(plan.counts), int)))

    def advance(self, model: Copied, plan: Plan) -> Any:
        start, steps = np.concatenate((model.start.qpos, model.start.qvel)), sum(plan.counts)
        states = np.vstack((start, _steps(model.copy, model.start, np.array(plan.counts, int))))
        stages = 4 if model.model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4 else 1
        return Loop(states, End(len(states)), steps, steps * stages)

    def collect(self, model: Copied, plan: Plan, left: Any) -> Loop:
        return left

    def reactions(self, model: Copied, plan: Plan, states: np.ndarray, poses: Poses) -> dict[str, np.ndarray]:
        return {}


ENGINE = Mjx


def copied(linkage: Linkage, model: mujoco.MjModel) -> Copied:
    """Return a model in JAX, which lacks exact effective masses, and elliptic cones of contacts without friction."""
    model.opt.enableflags = 0
    if (model.pair_dim == 1).all():
        model.opt.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL  # elliptic ones without any friction are a TypeError in it
    start = at_start(model, linkage)
    return Copied(linkage, model, start, None, mjx.put_model(model), mjx.put_data(model, start))
