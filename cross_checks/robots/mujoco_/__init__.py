"""A robot in an MJCF file as a scene, read by MuJoCo's own parser; and MuJoCo's dynamics of a file."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from cross_checks.robots import LOCKED, RATE, Robot, RobotError, of_file, plain, refuse, three, unknown
from cross_checks.robots.mujoco_.mjcf_pose import HINGE, IGNORABLE, SLIDE, Posed, assumptions, refusals
from cross_checks.robots.parity import Dynamics, Unreadable, Values
from mbs_ref import Scene

OPTIONS = "gravity, duration, ignore"


def read_mjcf(path: Path, given: Mapping[str, Any] | None = None) -> Robot:
    """Read a model, at rest in the pose of its file unless `given` says otherwise.

    `given` holds joint values (rad, m) by joint names, or "locked" for one that shall not move, rates (rad/s, m/s) as
    `joint.rate`, `gravity` (m/s^2, down along z), `duration` (s), and `ignore`: a comma-separated list of IGNORABLE
    that the file has and the scene leaves out. Hinges of one body become the joint that they make together: two that
    cross at right angles a universal joint, three a ball. Raises RobotError: no MJCF, other combinations of joints,
    what a scene cannot hold unless it is to be ignored, a moving body without mass, an unknown name.
    """
    asked = dict(given or {})
    gravity, duration = asked.pop("gravity", None), float(asked.pop("duration", 1.0))
    ignored = [word for word in str(asked.pop("ignore", "")).split(",") if word]
    refuse(path, (f"-p ignore={word}: allowed: {', '.join(IGNORABLE)}" for word in ignored if word not in IGNORABLE))
    locked = [name for name, value in asked.items() if value == LOCKED]
    model = _model(path, locked)
    names = [model.joint(j).name for j in range(model.njnt) if model.jnt_type[j] in (SLIDE, HINGE)]
    refuse(path, (unknown(name, names, OPTIONS) for name in asked if name.removesuffix(RATE) not in (*names, *locked)))
    posed = Posed(model, {name: float(value) for name, value in asked.items() if value != LOCKED}, ignored)
    refuse(path, refusals(posed))
    pulled = three(model.opt.gravity) if gravity is None else (0.0, 0.0, -float(gravity))
    with of_file(path):
        scene = Scene(
            name=plain(path.stem), source=path.name, description="The model, let go: no actuator acts.",
            duration=duration, gravity=pulled,
            bodies=tuple(map(posed.body, posed.moving)), joints=(*posed.joints(), *posed.closures()),
            loads=tuple(posed.loads()), parameters=dict(given or {}),
        )  # fmt: skip
    return Robot(scene, tuple(assumptions(posed, locked)))


def _model(path: Path, locked: list[str]) -> Any:
    """Return MuJoCo's model without the joints that are locked in their zero pose, and what couples these."""
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        for joint in [joint for joint in spec.joints if joint.name in locked]:
            for couple in [e for e in spec.equalities if joint.name in (e.name1, e.name2)]:
                spec.delete(couple)
            spec.delete(joint)
        for actuator in list(spec.actuators):  # none acts, and some name joints that are locked
            spec.delete(actuator)
        for key in list(spec.keys):
            spec.delete(key)
        return spec.compile()
    except (ValueError, RuntimeError, OSError) as error:
        raise RobotError(f"{path}: MuJoCo cannot read it: {error}") from error


def by_mujoco(path: Path, q: Values, v: Values) -> Dynamics:
    """Return the dynamics that MuJoCo computes; the other joints stay at the file's values."""
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
