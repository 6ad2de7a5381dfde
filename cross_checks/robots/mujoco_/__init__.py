"""A robot file as MuJoCo's own parser reads it."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from cross_checks.robots.parity import Dynamics, Unreadable, Values


def by_mujoco(path: Path, q: Values, v: Values) -> Dynamics:
    """Return what MuJoCo says; the other joints stay where the file has them."""
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise Unreadable(" ".join(str(error).split())) from error
    known = {model.joint(k).name for k in range(model.njnt)}
    if unknown := [name for name in q if name not in known]:
        raise Unreadable(f"it has no joint {', '.join(unknown)}")
    data = mujoco.MjData(model)
    index = [int(model.joint(name).dofadr[0]) for name in q]
    places = [int(model.joint(name).qposadr[0]) for name in q]
    data.qpos[places] = list(q.values())
    mujoco.mj_forward(model, data)
    gravity, mass = data.qfrc_bias.copy(), np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    data.qvel[index] = list(v.values())
    mujoco.mj_forward(model, data)
    return Dynamics(mass[np.ix_(index, index)], gravity[index], data.qfrc_bias[index].copy())


READER = by_mujoco
