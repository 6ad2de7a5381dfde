"""MuJoCo's loop, and its silent resets."""

from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco import rollout

from cross_checks.engine.outcome import End
from cross_checks.engine.plan import Plan
from cross_checks.linkage.links import Linkage
from mbs_ref.trajectory import Status

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
