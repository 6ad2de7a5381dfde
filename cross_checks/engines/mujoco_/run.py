"""MuJoCo's loop, and its silent resets."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco
import numpy as np

from cross_checks.engines.mujoco_.spatial_build import start_rates
from cross_checks.workshop.outcome import End, Plan, end_of
from cross_checks.workshop.planar_tree import JointTree
from cross_checks.workshop.spatial_tree import SpatialTree, depth_first
from mbs_ref.trajectory import Status


def at_start(model: mujoco.MjModel, tree: JointTree | SpatialTree) -> mujoco.MjData:
    data = mujoco.MjData(model)
    if isinstance(tree, SpatialTree):  # the reference configuration is the start
        data.qvel[:] = np.concatenate([start_rates(tree, edge) for edge in depth_first(tree)])
        return data
    data.qpos[:], data.qvel[:] = 0.0, tree.rates()
    return data


def advance(model: mujoco.MjModel, data: mujoco.MjData, plan: Plan, samples: int) -> tuple[np.ndarray, End]:
    """Step through the output times; each interval is one call into C."""
    states = np.zeros((len(plan.times), model.nq + model.nv))
    states[0] = np.concatenate((data.qpos, data.qvel))
    if samples == 1:  # a first call: one step
        mujoco.mj_step(model, data)
        return states, End(1)
    for k, count in enumerate(plan.counts, start=1):
        mujoco.mj_step(model, data, nstep=count)
        states[k, : model.nq], states[k, model.nq :] = data.qpos, data.qvel
        trouble = trouble_of(data, plan.times[k], plan.step)
        if trouble:
            return states, end_of(states, plan.times, End(k, Status.RESET, trouble))
    return states, end_of(states, plan.times, End(len(plan.times)))


def trouble_of(data: mujoco.MjData, time: float, step: float) -> str:
    """Return a sentence if MuJoCo warned or restarted: it goes on from t = 0 without an exception."""
    counts = {mujoco.mjtWarning(k).name: int(w.number) for k, w in enumerate(data.warning) if w.number}
    late = abs(data.time - time) > 0.5 * step
    if not counts and not late:
        return ""
    warned = f", with the warnings {counts}" if counts else ""
    return f"mujoco reset its state before t = {time:g} s and reports t = {data.time:g} s{warned}"
